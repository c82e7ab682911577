"""Faults that leave the model box: nothing given moves, lines go on straight, no crossing."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import geosurf as gs
from geosurf import TriSurface, extend_fault, lengthen_fault, triangulate_fault, triangulate_sticks
from geosurf.arrangement.triangles import crossing_pairs
from geosurf.errors import GeometryError, InputError, SurfaceError
from geosurf.faults.rim import find_rim, find_rims, segments_meet_box
from geosurf.synthetic.world import make_fault
from tests.faults.worlds import BOX, across, bytes_of, triangles_of, turned, upright, volumes
from tests.messages import refused
from tests.strategies import grid, sheet, shuffled


def parametric(x, y, z):
    """A fault over (down_dip, along_strike) from arrays that broadcast."""
    return triangulate_fault(make_fault("F1", x, y, z, (0.0, 0.0, 0.0)), name="F1")


def assert_leaves(made, given, box=BOX, sides=("start", "end", "up", "down")):
    """The fault as given comes first, nothing crosses, and the rim lies outside the box."""
    longer = made.surface
    assert longer.vertices[: given.n_vertex].tobytes() == given.vertices.tobytes()
    assert longer.triangles[: given.n_triangle].tobytes() == given.triangles.tobytes()
    assert made.n_given == given.n_triangle
    assert len(crossing_pairs(longer.vertices, longer.triangles)) == 0
    rim = find_rim(longer)
    low, high = np.reshape(box, (3, 2)).T
    for side in sides:
        line = longer.vertices[rim.arcs[side]]
        # nodes and many places between them
        u = np.linspace(0, 1, 30)[:, None, None]
        points = ((1 - u) * line[:-1] + u * line[1:]).reshape(-1, 3)
        assert ((points < low) | (points > high)).any(axis=1).all(), side
    assert sum(e.n_triangle for e in made.extensions) == longer.n_triangle - given.n_triangle


@pytest.mark.parametrize(("angle", "top"), [(0.8, 300.0), (0.8, 200.0), (0.6, 300.0)])
def test_lines_that_meet_above_the_box_each_go_on_as_far_as_they_have_to(angle, top):
    """A fan of dip lines to one point at elevation 0, with an upper rim that climbs."""
    angles, box = np.linspace(-angle, angle, 9), (-100.0, 100.0, -900.0, 900.0, -700.0, -50.0)
    radius = np.stack([np.linspace(top, top + 200.0, 9), np.full(9, 800.0)])
    given = parametric(np.zeros((2, 9)), radius * np.sin(angles), -radius * np.cos(angles))
    assert_leaves(extend_fault(given, box, sides=["up"]), given, box, ["up"])
    # all as far: past the point
    refused(GeometryError, "'F1' would cross itself", lengthen_fault, given, {"up": top + 300.0})


@pytest.mark.parametrize("n", [(1, 1), (3, 2)])
@pytest.mark.parametrize(
    "corners",
    [
        [(4, 3, 3), (4, 5, 3), (4, 5, 5), (4, 3, 5)],  # vertical, strikes north
        [(3, 4, 3), (5, 4, 3), (5, 4, 5), (3, 4, 5)],  # vertical, strikes east
        [(3, 3, 5), (5, 3, 3), (5, 5, 3), (3, 5, 5)],  # dips east
        [(3, 3, 3), (5, 3, 5), (5, 5, 5), (3, 5, 3)],  # dips west
    ],
)
def test_a_plane_fault_stays_plane_and_leaves_the_box(corners, n):
    given = sheet("F1", corners, n)
    a, b, c = given.vertices[given.triangles[0]]
    normal = np.cross(b - a, c - a)
    for fault in (given, turned(given)):
        made = extend_fault(fault, BOX)
        assert_leaves(made, fault)
        off = (made.surface.vertices - given.vertices[0]) @ normal / np.linalg.norm(normal)
        assert np.abs(off).max() < 1e-14
        assert [e.side for e in made.extensions] == ["start", "end", "up", "down"]
        new = made.surface.vertices[made.surface.triangles]
        turn = np.cross(new[:, 1] - new[:, 0], new[:, 2] - new[:, 0])
        assert (turn @ turn[0] > 0).all()  # new triangles face as their neighbours


def test_a_listric_grid_goes_on_with_its_last_dip():
    z = np.array([7.0, 6.0, 5.0, 4.5])[:, None]
    x = np.array([2.0, 2.25, 2.75, 3.75])[:, None]
    given = parametric(x, np.arange(2.0, 7.0)[None], z)
    made = extend_fault(given, BOX)
    assert_leaves(made, given)
    rim = find_rim(made.surface)
    bottom = made.surface.vertices[rim.arcs["down"]]
    # the last step runs 1 east and 0.5 down
    np.testing.assert_allclose((bottom[:, 0] - 3.75) * -0.5, bottom[:, 2] - 4.5, rtol=1e-13)
    top = made.surface.vertices[rim.arcs["up"]]
    np.testing.assert_allclose(top[:, 0] - 2.0, (top[:, 2] - 7.0) * -0.25, rtol=1e-13)


def twisted(rng, n=9):
    """Sticks with dips and strikes of their own."""
    tops = [(2 + rng.uniform(0, 0.3), 0.5 + 0.8 * k, 6 + rng.uniform(0, 0.3)) for k in range(n)]
    ways = np.column_stack([rng.uniform(0.2, 0.9, n), rng.uniform(-0.1, 0.1, n), -np.ones(n)])
    return triangulate_sticks(
        [[top, top + way] for top, way in zip(tops, ways, strict=True)], name="F1"
    )


@pytest.mark.parametrize("make", [twisted, lambda rng: upright_mesh(rng)])
@pytest.mark.parametrize("side", ["down", "up", "end"])
def test_law_a_fault_that_goes_less_far_is_a_part_of_one_that_goes_farther(make, side, rng):
    given = make(rng)
    far = [0.01, 0.5, 4.0, 30.0]
    made = [lengthen_fault(given, {side: one}).surface for one in far]
    # up to a box dip lines agree within the first row, half of the smaller side long
    boxes = [(-d, 8 + d, -d, 8 + d, -d, 8 + d) for d in (0, 1, 3, 9, 40)]
    wide = [extend_fault(given, box, sides=side).surface for box in boxes]
    parts = [*pairwise(made), *((made[1], longer) for longer in wide)]
    parts += pairwise(wide) if side == "end" else []
    for one, longer in parts:
        middle = one.vertices[one.triangles].mean(axis=1)
        _, nearest = longer.to_pyvista().find_closest_cell(middle, return_closest_point=True)
        assert np.abs(nearest - middle).max() < 1e-12
    assert lengthen_fault(given, {side: 0.7}).extensions[0].distance == pytest.approx(0.7)


def curved(radius, turn, n=9, dip=0.0):
    """A trace on a circle; dip lines lean inwards by `dip` for each metre down."""
    angle = np.linspace(-turn / 2, turn / 2, n)[None]
    z = np.array([5.0, 4.0, 3.0])[:, None]
    r = radius - dip * (5.0 - z)
    return parametric(4 + r * np.cos(angle) - radius, 4 + r * np.sin(angle), z)


def test_converging_dip_lines_are_refused_with_the_place_where_they_cross():
    given = curved(2.0, np.pi, dip=0.75)
    assert_leaves(extend_fault(given, BOX, sides="up"), given, sides=("up",))
    words = r"'F1' would cross itself if its side 'down' were .*near"
    refused(GeometryError, words, extend_fault, given, (-9, 9, -9, 9, -9, 9), sides="down")


def test_a_bend_of_three_quarters_crosses_itself_along_strike():
    given = curved(2.0, 1.5 * np.pi, n=17)
    words = r"'F1' would cross itself if its side 'end' were extended"
    refused(GeometryError, words, extend_fault, given, (-9, 9, -9, 9, 0, 8), sides="strike")


def upright_mesh(rng, present=None):
    """A bumpy mesh that strikes north and dips steeply east; nodes are off their grid."""
    flat = grid("F1", rng.integers(0, 2, (7, 7)) * 0.125, role="fault", present=present)
    x, y, bump = flat.vertices.T
    x, y = x + rng.integers(-1, 2, len(x)) / 8, y + rng.integers(-1, 2, len(x)) / 8
    vertices = np.stack([3 + bump + 0.25 * y, 1 + x, 7 - y], axis=1)
    used, t = np.unique(flat.triangles, return_inverse=True)
    return TriSurface("F1", "fault", vertices[used], t.reshape(-1, 3))


def test_a_mesh_goes_on_from_its_rim_whatever_the_order_of_its_triangles(rng):
    given = upright_mesh(rng)
    made = extend_fault(given, BOX)
    assert_leaves(made, given)
    for _ in range(3):
        again = extend_fault(shuffled(given, rng, reflect=False), BOX)
        assert triangles_of(again.surface) == triangles_of(made.surface)


@pytest.mark.parametrize(
    ("gone", "filled"),
    [
        ([64, 65, 52, 53, 40, 41], True),  # half through it
        ([0, 1, 2, 3, 12, 13], False),  # a corner, in two steps
        ([64, 65, 66, 67], False),  # a notch in a side, shallow enough to go on by itself
        ([0, 1, 12, 13, 58, 59, 70, 71], False),
    ],
)
def test_notches_of_a_rim_with_steps_are_filled_where_they_have_to(gone, filled, rng):
    torn = np.ones(72, dtype=bool)
    torn[gone] = False
    told = set()
    for sides in ("up", "down", "start", "end", ("start", "end", "up", "down")):
        given = upright_mesh(rng, torn)
        made = extend_fault(given, BOX, sides=sides)
        assert_leaves(made, given, sides=(sides,) if isinstance(sides, str) else sides)
        told.update(e.lines for e in made.extensions)
    assert "filled" in told or not filled


def test_holes_stay_and_pieces_are_refused():
    given = grid("F1", np.zeros((5, 5)), role="fault", present=np.arange(32) != 13)
    given = TriSurface("F1", "fault", given.vertices[:, [2, 0, 1]] + 2.0, given.triangles)
    assert_leaves(extend_fault(given, BOX), given)
    two = np.ones(32, dtype=bool)
    two[8:16] = False
    apart = grid("F1", np.zeros((5, 5)), role="fault", present=two)
    refused(SurfaceError, r"'F1' is in 2 pieces, one of them at \(E", extend_fault, apart, BOX)
    assert len(find_rims(apart)) == 2


def mesh(vertices, triangles):
    return TriSurface("F1", "fault", vertices, triangles)


PLANE = sheet("F1", [(4, 3, 3), (4, 5, 3), (4, 5, 5), (4, 3, 5)])
TETRA = [[1, 1, 1], [3, 1, 1], [1, 3, 1], [1, 1, 3]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
FOLDED = [[4, 1, 1], [4, 1, 5], [5, 3, 2], [5, 3, 4]], [[0, 1, 2], [1, 0, 3]]
RING = (
    [[4, 1, 3], [4, 1, 1], [4, 3, 3], [4, 5, 1], [4, 5, 3], [4, 0, 0], [4, 0, 2], [4, 6, 0]],
    [[0, 1, 2], [1, 0, 6], [1, 6, 7], [1, 7, 3], [3, 7, 4], [2, 3, 4]],
)
REFUSED = {
    "closed": (mesh(*TETRA), SurfaceError, r"'F1' is closed at .* it has no rim. Cut it open"),
    "two fronts": (mesh(PLANE.vertices, [[0, 1, 3], [0, 2, 3]]), SurfaceError,
                   r"'F1': its triangles do not agree about their front at"),
    "a line": (mesh([[4, 1, 1], [4, 2, 2], [4, 3, 3]], [[0, 1, 2]]), SurfaceError,
               r"1 of 1 triangles have no area, .* Remove them"),
    # normals beside the fold cancel
    "folded back onto itself": (mesh(*FOLDED), GeometryError,
                                r"'F1' has no tangent plane at .* slivers or folded"),
    "a ring that closes in one corner only": (mesh(*RING), SurfaceError,
                                              r"'F1': its rim touches itself at \(E 4, N"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_extended_is_refused(case):
    fault, error, words = REFUSED[case]
    refused(error, words, extend_fault, fault, BOX, sides="up")


def test_law_segments_meet_the_box_as_many_samples_say(rng):
    low, high = np.zeros(3), np.full(3, 4.0)
    line = rng.integers(-2, 7, (400, 3)).astype(float)
    meets = segments_meet_box(line, low, high)
    u = np.linspace(0, 1, 4001)[:, None, None]
    points = (1 - u) * line[:-1] + u * line[1:]
    sampled = ((points >= low) & (points <= high)).all(axis=2).any(axis=0)
    assert not (sampled & ~meets).any()
    wide = ((points >= low - 0.01) & (points <= high + 0.01)).all(axis=2).any(axis=0)
    assert not (meets & ~wide).any()


def test_sticks_that_would_cross_are_averaged_and_that_is_told():
    tops = [(4, 1 + 0.25 * k, 6.0) for k in range(24)]
    leans = [0.25 * (-1) ** k for k in range(24)]
    sticks = [
        [top, np.add(top, (0.5, lean / 8, -1))] for top, lean in zip(tops, leans, strict=True)
    ]
    given = triangulate_sticks(sticks, name="F1")
    near = extend_fault(given, (0, 8, 0, 8, 5.5, 6.25), sides="up")
    assert [e.lines for e in near.extensions] == ["own"]
    far = extend_fault(given, (0, 8, 0, 8, -20, 8), sides="down")
    assert [e.lines for e in far.extensions] == ["averaged"]
    assert_leaves(far, given, (0, 8, 0, 8, -20, 8), sides=("down",))


# ---- Faults that are continued by a distance: exact on planes, in scenes and in scenarios.
ROOT2 = np.sqrt(2.0)


def dipping(n=(1, 1)):
    """Six long, four wide, dips 45 degrees east: starts in the south."""
    high, low = 6.0, 6.0 - 4.0 / ROOT2
    west, east = 2.0, 2.0 + 4.0 / ROOT2
    return sheet("F1", [(west, 1, high), (east, 1, low), (east, 7, low), (west, 7, high)], n)


def area_of(surface):
    a, b, c = surface.vertices[surface.triangles].swapaxes(0, 1)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


@pytest.mark.parametrize("n", [(1, 1), (3, 2)])
@pytest.mark.parametrize("turn", [False, True])
def test_a_plane_grows_by_the_distance_on_each_side(n, turn):
    given = turned(dipping(n)) if turn else dipping(n)
    made = gs.lengthen_fault(given, {"start": 1, "end": 2, "up": 0.5, "down": 3})
    assert [(e.side, e.distance) for e in made.extensions] == [
        ("start", 1.0), ("end", 2.0), ("up", 0.5), ("down", 3.0),
    ]  # fmt: skip
    longer = made.surface
    assert area_of(longer) == pytest.approx((6 + 1 + 2) * (4 + 0.5 + 3), rel=1e-12)
    expected = (2 - 0.5 / ROOT2, 2 + 7 / ROOT2, 0.0, 9.0, 6 - 7 / ROOT2, 6 + 0.5 / ROOT2)
    assert longer.bounds == pytest.approx(expected, abs=1e-12)
    assert longer.vertices[: given.n_vertex].tobytes() == given.vertices.tobytes()
    assert longer.triangles[: made.n_given].tobytes() == given.triangles.tobytes()


def test_sticks_go_on_by_their_own_last_step():
    """Each stick of a fault that steepens along strike keeps its own direction, up and down."""
    top, bottom = np.array([[0.0, y, 0.0] for y in range(4)]), []
    for y in range(4):
        bottom.append([3.0 - 0.5 * y, y + 0.1 * y, -4.0])
    sticks = [np.array(pair) for pair in zip(top, bottom, strict=True)]
    fault = gs.triangulate_fault(gs.FaultSticks("F1", tuple(sticks)))
    longer = gs.lengthen_fault(fault, {"up": 1.5, "down": 2.5}).surface
    found = {tuple(np.round(x, 9)) for x in longer.vertices}
    for a, b in sticks:
        way = (b - a) / np.linalg.norm(b - a)
        assert tuple(np.round(a - 1.5 * way, 9) + 0.0) in found
        assert tuple(np.round(b + 2.5 * way, 9) + 0.0) in found


def test_law_faults_that_share_a_stick_share_what_it_goes_on_with(rng):
    # within the first row of triangles, which is longer for a larger fault
    for _ in range(20):
        foot = np.array([0.0, 0.0, -2000.0]) + rng.uniform(0, 50, 3) + [4.6e5, 5.9e6, 0.0]
        dip = np.array([rng.uniform(-60, 60), 40.0, -150.0])
        steps = rng.uniform([150, -40, -20], [900, 40, 20], (2, 3)) * [[-1], [1]]
        stick = np.array([foot, foot + dip])
        faults = [
            triangulate_fault(gs.FaultSticks(name, [stick, stick + np.array([step, 1.1 * step])]))
            for name, step in zip("AB", steps, strict=True)
        ]
        by = {"up": rng.uniform(20, 70), "down": rng.uniform(20, 70)}
        places = [{*map(tuple, lengthen_fault(one, by).surface.vertices)} for one in faults]
        assert len(places[0] & places[1]) == 4


def test_a_scene_lengthens_first_and_extends_then():
    faults = {"F1": dipping(), "F2": sheet("F2", [(7, 1, 1), (7, 2, 1), (7, 2, 2), (7, 1, 2)])}
    scene = gs.Scene({}, faults, BOX, lengthen={"F1": {"strike": 0.5}}, extend={"F1": "down"})
    assert [(e.fault, e.side, e.until) for e in scene.fault_actions] == [
        ("F1", "start", "the given distance"), ("F1", "end", "the given distance"),
        ("F1", "down", "the model box"),
    ]  # fmt: skip
    assert "F1 (start) was extended by 0.5 m until the given distance" in str(
        scene.fault_actions[0]
    )
    assert scene.surface("F1").bounds[2:4] == (0.5, 7.5)
    all_of_them = scene.replace(lengthen=0.25)
    assert dict(all_of_them.lengthen["F2"]) == dict.fromkeys(("start", "end", "up", "down"), 0.25)
    assert area_of(all_of_them.surface("F2")) == pytest.approx(1.5**2, rel=1e-12)
    assert all_of_them.replace(faults={"F2": None}).lengthen.keys() == {"F1"}


def test_distances_that_cannot_be_used_are_refused():
    for wrong, words in (
        ({"up": -1}, "Give a distance in metres above 0"),
        ({"strike": 1, "end": 2}, "gives side 'end' twice"),
    ):
        refused(InputError, words, gs.lengthen_fault, dipping(), wrong)
        refused(InputError, words, gs.Scene, {}, {"F1": dipping()}, BOX, lengthen={"F1": wrong})


def test_a_mesh_in_pieces_becomes_a_fault_of_each():
    one, two = upright(3, n=(2, 2)), across(4)
    # pieces that meet in a place, but not along an edge; vertices at one place are given twice
    moved = two.vertices + np.array([4, 5, 0])
    x = np.concatenate([one.vertices, moved])
    t = np.concatenate([two.triangles + one.n_vertex, one.triangles])
    mesh = gs.TriSurface("F1", "fault", x, t)
    refused(SurfaceError, r"is in 2 pieces.*gs.split_fault", gs.lengthen_fault, mesh, 5)
    parts = gs.split_fault(mesh)
    assert list(parts) == ["F1 (1)", "F1 (2)"]
    assert {bytes_of(part) for part in parts.values()} == {
        bytes_of(one),
        bytes_of(gs.TriSurface("F3", "fault", moved, two.triangles)),
    }
    for name, part in parts.items():
        assert part.name == name
        assert gs.lengthen_fault(part, 5).surface.n_triangle > part.n_triangle
    assert gs.split_fault(one) == {one.name: one}
    box = (-20, 20, -20, 20, 0, 8)
    whole, apart = (gs.Scene({}, faults, box) for faults in ({"F1": mesh}, parts))
    assert volumes(whole.units) == pytest.approx(volumes(apart.units), rel=1e-14)


def test_law_plane_faults_with_uneven_rims_leave_the_box_as_one_surface(rng):
    """Parallel dip lines of uneven length, across the edges of the box."""
    n_made = 0
    for _ in range(60):
        strike = rng.uniform(0.0, np.pi)
        along = np.array([np.cos(strike), np.sin(strike), 0.0])
        dip = np.array([-along[1], along[0], -rng.uniform(0.5, 3.0)])
        places = np.sort(rng.uniform(-2.0, 2.0, rng.integers(2, 6)))
        middle = rng.uniform(2.0, 6.0, 3)
        ends = rng.uniform(0.1, 0.6, (len(places), 2)) * [-1.0, 1.0]
        sticks = [
            [middle + along * s + dip * end for end in two]
            for s, two in zip(places, ends, strict=True)
        ]
        given = triangulate_sticks(sticks, name="F1")
        try:
            made = extend_fault(given, BOX, sides=("up", "down")).surface
        except GeometryError:  # steps of its rim cross when they go on
            continue
        n_made += 1
        find_rim(made)  # one piece, triangles that agree about their front
        normal = np.cross(along, dip)
        off = (made.vertices - middle) @ normal / np.linalg.norm(normal)
        assert np.abs(off).max() < 1e-12
    assert n_made > 50
