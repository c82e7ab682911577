"""Two faults that cross: the younger one is whole, the older one becomes two faults at it."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import geosurf as gs
from geosurf import Scene, TriSurface, build_walls, rebuild_surfaces, truncate_faults
from geosurf.conventions import place as place_in_words
from geosurf.errors import GeometryError, GeosurfError, InputError, ScenarioError, SurfaceError
from geosurf.faults.distance import closest_approach
from geosurf.faults.rules import read_extend, read_truncations
from geosurf.faults.sides import adjacency
from geosurf.faults.truncate import inside_area
from geosurf.scenario import build_scene, read_scenario
from tests.faults.worlds import (
    BOX,
    across,
    antithetic,
    bytes_of,
    dipping,
    turned,
    upright,
    vector_area,
    volumes,
)
from tests.grids import gridded, ring_area
from tests.messages import refused
from tests.planes import INPUTS, write_grids
from tests.strategies import grid, sheet, shuffled

X = {"F1": dipping(), "F2": across(4, "F2")}


def scene(truncations, faults=X, **more):
    return gs.Scene({}, faults, BOX, truncations=truncations, **more)


@pytest.mark.parametrize("older", [across(4, "F2"), across(3, "F2"), antithetic()])
def test_halves_cut_the_same_blocks_as_two_faults_that_cross(older):
    faults = {"F1": dipping(), "F2": older}
    crossed, split = scene({}, faults), scene({"F2": ("F1", "both")}, faults)
    assert split.fault_names == ("F1", "F2 (1)", "F2 (2)")
    assert (volumes(split.units) == volumes(crossed.units)).all()
    assert split.check().ok

    # the halves add up to the fault, one on each side; the younger fault is whole
    assert sum(cut.kept_area for cut in split.fault_actions) == pytest.approx(
        split.fault_actions[0].kept_area + split.fault_actions[0].dropped_area, rel=1e-15
    )
    for name, sign in (("F2 (1)", 1), ("F2 (2)", -1)):
        x = split.surface(name).vertices
        assert (sign * (x[:, 0] + x[:, 2] - 8)).min() == 0
    assert split.surface("F1").bounds == dipping().bounds
    for cut, side in zip(split.fault_actions, "+-", strict=True):
        assert " ends at F1 along " in str(cut)
        assert str(cut).endswith(f" on its {side} side kept")

    # blocks on one side of F1 lie on one half only
    for unit in split.units.values():
        half = "F2 (1)" if "F1+" in unit.block else "F2 (2)"
        other = "F2 (2)" if half == "F2 (1)" else "F2 (1)"
        assert half in unit.block
        assert other not in unit.block


def test_what_is_stated_for_the_fault_holds_for_its_halves():
    short = gs.TriSurface("F2", "fault", X["F2"].vertices * (1, 1, 0.8), X["F2"].triangles)
    faults = {"F1": dipping(), "F2": short}
    made = scene({"F2": ("F1", "both")}, faults, extend={"F2": "up"}, tear={"F2": 2})
    assert made.extend == {"F2 (1)": ("up",), "F2 (2)": ("up",)}
    assert made.check().ok
    again = made.replace(faults={"F2": across(3, "F2")})
    assert again.surface("F2 (2)").bounds[2:4] == (3, 3)
    assert made.replace(faults={"F2": None}).fault_names == ("F1",)
    crossed = made.replace(truncations=None)
    assert crossed.fault_names == ("F1", "F2")
    assert crossed.extend == {"F2": ("up",)}
    one = scene({"F2": ("F1", "both")}, faults, extend={"F2": "up", "F2 (2)": "down"})
    assert one.extend == {"F2 (1)": ("up",), "F2 (2)": ("down",)}


def test_a_half_has_rules_of_its_own():
    faults = {**X, "F3": upright(6, "F3")}
    rules = {"F2": ("F1", "both"), "F2 (1)": ("F3", "right"), "F3": ("F1", "hanging wall")}
    made = scene(rules, faults)
    assert made.check().ok
    assert made.surface("F2 (1)").bounds[0] == 6
    twice = scene({"F2": (("F1", "both"), ("F3", "both"))}, {**X, "F3": across(4, "F3")})
    assert len(twice.fault_names) == 6
    with pytest.raises(GeometryError):
        _ = twice.units  # F3 lies in F2


@pytest.mark.parametrize(
    ("rules", "more", "words"),
    [
        ({"F2": ("F1", "both"), "F3": ("F2", "+")}, {"F3": upright(6, "F3")},
         r"F3 ends at 'F2', which is split into 'F2 \(1\)' and 'F2 \(2\)'. Name the half"),
        ({"F2": ("F1", "both")}, {"F2 (1)": upright(6)},
         r"half would be called 'F2 \(1\)'.*Rename"),
        ({"F2": ("F9", "both")}, {}, r"'F9', which is not a fault"),
        ({"F2": ("F1", "both")}, {"F2": gs.TriSurface(
            "F2", "fault", upright(6).vertices * (1, 1, 0.5) + (0, 0, 4), upright(6).triangles)},
         r"'F2 \(1\)' ends .* short of 'F1'"),
    ],
)  # fmt: skip
def test_what_cannot_be_split_is_one_plain_sentence(rules, more, words):
    refused((InputError, GeometryError), words, lambda: scene(rules, {**X, **more}).patches)


def test_a_scenario_splits_a_fault(tmp_path):
    write_grids(tmp_path)
    gs.write(gs.TriSurface("F2", "fault", np.array(
        [(-99, 1500, -2600), (4099, 1500, -2600), (4099, 1500, -1600), (-99, 1500, -1600)]
    ), [[0, 1, 2], [0, 2, 3]]), tmp_path / "F2.ts")  # fmt: skip
    rule = '[[truncations]]\nfault = "F2"\nmain = "F1"\nkeep = "both"\n'
    older = '[[faults]]\nname = "F2"\nfile = "F2.ts"\n'
    path = tmp_path / "scenario.toml"
    path.write_text(INPUTS + older + rule)
    made = build_scene(read_scenario(path))
    assert made.fault_names == ("F1", "F2 (1)", "F2 (2)")
    assert made.check().ok
    throw = '[[throws]]\nfault = "F2"\nthrow_m = 20\nhorizons = ["Base"]\n'
    tear = '[tear]\nhorizons = ["Top"]\ntrim_cells = { F2 = 2 }\n'
    path.write_text(INPUTS + older + rule + throw + tear)
    read = read_scenario(path)
    assert [entry.fault for entry in read.throws] == ["F2 (1)", "F2 (2)"]
    assert read.tear is not None
    assert read.tear.trim_cells == {"F2 (1)": 2, "F2 (2)": 2}
    path.write_text(INPUTS + older + older.replace('"F2"', '"F2 (1)"') + rule)
    refused(ScenarioError, r"half would be called 'F2 \(1\)'", read_scenario, path)


@pytest.mark.parametrize("picked_apart", [False, True])
@pytest.mark.parametrize("turn", [0.0, -35.0, 35.0])
def test_halves_offset_each_its_own_side(turn: float, picked_apart: bool) -> None:
    """The older throw, then the younger one: four level blocks, whatever angle and names."""

    def plane(name: str, strike: float, dip: float) -> gs.TriSurface:
        along = np.array([np.sin(np.radians(strike)), np.cos(np.radians(strike))])
        down = np.array([along[1], -along[0]]) * 1000.0 / np.tan(np.radians(dip))
        ends = np.array([[1000.0, 1000.0] - 1800 * along, [1000.0, 1000.0] + 1800 * along])
        x = [[*ends[0], -500], [*ends[1], -500], [*(ends[1] + down), -1500]]
        return gs.TriSurface(
            name, "fault", [*x, [*(ends[0] + down), -1500]], [[0, 1, 2], [0, 2, 3]]
        )

    x = np.arange(0.0, 2001.0, 50.0)
    grid = gridded(np.full((41, 41), -1000.0), x)
    given = {"F1": plane("F1", 0.0, 70.0), "F2": plane("F2", 90.0 + turn, 75.0)}
    box = (0.0, 2000.0, 0.0, 2000.0, -1400.0, -600.0)
    rules = {"F2": ("F1", "both")}
    if picked_apart:
        rules = {"east": ("F1", "hanging wall"), "west": ("F1", "footwall")}
        given |= {name: given["F2"].renamed(name, "fault") for name in rules}
        del given["F2"]
    scene = gs.Scene({}, given, box, truncations=rules)
    faults = [scene.whole_surface(name) for name in scene.fault_names]
    throws = {name: 40.0 if name == "F1" else 25.0 for name in scene.fault_names}
    sheet = gs.throw_horizon(grid, faults, throws, name="Top")
    levels = np.unique(sheet.surface.vertices[:, 2].round(6))
    np.testing.assert_allclose(levels, [-1065.0, -1040.0, -1025.0, -1000.0])


# ---- Faults that end at faults: the right part stays, shares vertices, and parts add up.
def cut(faults, truncations):
    return truncate_faults(rebuild_surfaces(faults), truncations)


def test_parts_add_up_exactly_on_a_lattice():
    whole = antithetic(n=(5, 1))
    up, down = (cut([dipping(), whole], {"F2": ("F1", side)}) for side in ("+", "-"))
    parts = [vector_area(made.surfaces["F2"]) for made in (up, down)]
    assert [a + b for a, b in zip(*parts, strict=True)] == vector_area(whole)
    kept, dropped = up.truncations[0].kept_area, up.truncations[0].dropped_area
    assert kept == pytest.approx(50 * math.sqrt(2), rel=1e-15)
    assert dropped == pytest.approx(50 * math.sqrt(2), rel=1e-15)
    assert down.truncations[0].kept_area == dropped
    assert vector_area(up.surfaces["F1"]) == vector_area(dipping())


@pytest.mark.parametrize("keep", ["hanging wall", "footwall"])
def test_words_do_not_depend_on_how_triangles_are_turned(keep):
    expected = cut([dipping(), antithetic()], {"F2": ("F1", keep)})
    for main, other in ((turned(dipping()), antithetic()), (dipping(), turned(antithetic()))):
        made = cut([main, other], {"F2": ("F1", keep)})
        assert made.surfaces["F2"].vertices.tobytes() == expected.surfaces["F2"].vertices.tobytes()
        assert made.truncations[0].kept_area == expected.truncations[0].kept_area
    side = cut([turned(dipping()), antithetic()], {"F2": ("F1", keep)}).truncations[0].side
    assert side != expected.truncations[0].side


def test_the_order_of_faults_and_triangles_does_not_matter(rng):
    faults = [dipping(n=(3, 2)), antithetic(n=(4, 3)), across(4)]
    rules = {"F3": (("F1", "hanging wall"), ("F2", "hanging wall")), "F2": ("F1", "hanging wall")}
    first = cut(faults, rules)
    for _ in range(3):
        mixed = [shuffled(faults[i], rng, reflect=False) for i in rng.permutation(3)]
        again = cut(mixed, dict(reversed(rules.items())))
        assert again.truncations == first.truncations
        for name, surface in first.surfaces.items():
            assert bytes_of(again.surfaces[name]) == bytes_of(surface)


def test_a_fault_ends_at_what_is_left_of_its_main_fault():
    # F3 ends at F2, which itself ends at F1: below F1 nothing of F2 is left to end at
    faults = [dipping(), antithetic(), sheet("F3", [(4, 1, 5), (8, 1, 5), (8, 7, 5), (4, 7, 5)])]
    made = cut(faults, {"F2": ("F1", "+"), "F3": ("F2", "hanging wall")})
    kept = made.surfaces["F3"].vertices
    assert (kept[:, 0] <= kept[:, 2]).all()  # west of x = z
    assert made.truncations[1].kept_area == pytest.approx(6.0)
    rules = {"F2": ("F1", "+"), "F3": ("F2", "+")}
    error = refused(
        GeometryError, r"'F3' ends .* m short of 'F2', nearest at ",
        cut, [*faults[:2], across(4, west=1, east=2)], rules,
    )  # fmt: skip
    assert error.surfaces == ("F3", "F2")
    assert place_in_words(error.place) in str(error)


def test_pieces_that_do_not_meet_the_main_fault_stay_and_are_told():
    far = sheet("F2", [(1, 1, 0), (2, 1, 0), (2, 2, 0), (1, 2, 0)])
    two = TriSurface(
        "F2", "fault",
        np.concatenate([antithetic().vertices, far.vertices]),
        np.concatenate([antithetic().triangles, far.triangles + 4]),
    )  # fmt: skip
    (told,) = cut([dipping(), two], {"F2": ("F1", "hanging wall")}).truncations
    assert told.apart_area == 1.0


def test_a_vertical_fault_has_no_hanging_wall_but_a_right_and_a_left():
    faults = [upright(4, "F1"), across(4, "F2")]
    with pytest.raises(InputError, match=r"'F1' is vertical, so that it has no hanging wall"):
        cut(faults, {"F2": ("F1", "hanging wall")})
    for main in (faults[0], turned(faults[0])):
        right = cut([main, faults[1]], {"F2": ("F1", "right")}).surfaces["F2"]
        assert right.bounds[:2] == (4.0, 9.0)
    north = cut(faults, {"F1": ("F2", "right")}).surfaces["F1"]
    assert north.bounds[2:4] == (4.0, 9.0)


def test_main_faults_without_two_sides_are_refused():
    mixed = dipping()
    t = mixed.triangles.copy()
    t[0] = t[0, [0, 2, 1]]
    mixed = TriSurface("F1", "fault", mixed.vertices, t)
    diagonal = sheet("F2", [(-1, -1, -1), (9, 9, -1), (9, 9, 9), (-1, -1, 9)])
    with pytest.raises(SurfaceError, match=r"'F1': its triangles do not agree about their front"):
        cut([mixed, diagonal], {"F2": ("F1", "+")})
    fin = TriSurface(
        "F1", "fault",
        np.concatenate([dipping().vertices, [[9, 9, 9]]]),
        np.concatenate([dipping().triangles, [[0, 3, 4]]]),
    )  # fmt: skip
    ridge = TriSurface("F2", "fault", [[-1, -1, 9], [9, 9, -1], [-1, 9, -1]], [[0, 1, 2]])
    refused(GeometryError, r"'F1' has 3 sheets at", cut, [fin, ridge], {"F2": ("F1", "+")})


CIRCLE = {"F1": ("F2", "+"), "F2": ("F3", "+"), "F3": ("F1", "-"), "F4": ("F1", "-")}


@pytest.mark.parametrize(
    ("rules", "words"),
    [
        (CIRCLE, "form a circle: F1 ends at F2, F2 ends at F3, F3 ends at F1. Leave out one"),
        ({"F1": ("F1", "+")}, "form a circle: F1 ends at F1"),
        ({"F2": ("F1", "hangingwall")}, "keep 'hangingwall' of F1.*Did you mean 'hanging wall'"),
        ({"F2": (("F1", "+"), ("F1", "-"))}, "F2 ends at F1 twice. Keep one"),
    ],
)
def test_rules_that_cannot_be_are_refused(rules, words):
    refused(InputError, words, read_truncations, rules, ["F1", "F2", "F3", "F4"])


def test_sides_to_extend_that_cannot_be_are_refused():
    refused(InputError, "has side 'top'; sides are", read_extend, {"F1": "top"}, ["F1"])
    assert read_extend(None, ["F1"]) == {}
    assert read_extend(True, ["F1", "F2"]) == dict.fromkeys(
        ("F1", "F2"), ("start", "end", "up", "down")
    )
    assert read_extend({"F1": "up"}, ["F1"]) == {"F1": ("up",)}


corner = st.tuples(st.integers(0, 4), st.integers(0, 4), st.integers(0, 4))


@given(st.lists(corner, min_size=4, max_size=4, unique=True), st.integers(1, 3), st.booleans())
def test_law_every_kept_triangle_is_on_its_side_of_a_plane_main_fault(points, at, east):
    """Whole numbers, any two triangles across a plane that is beyond them all."""
    p = np.array(points, dtype=float)
    t = np.array([[0, 1, 2], [0, 2, 3]])
    normals = np.cross(p[t[:, 1]] - p[t[:, 0]], p[t[:, 2]] - p[t[:, 0]])
    if (normals == 0).all(axis=1).any() or np.dot(*normals) <= 0:
        return
    other = TriSurface("F2", "fault", p, t)
    main = sheet("F1", [(at, -9, -9), (at, 9, -9), (at, 9, 9), (at, -9, 9)], (2, 2))
    beyond = p[:, 0] - at
    keep = 1 if east else -1
    try:
        made = cut([main, other], {"F2": ("F1", "right" if east else "left")})
    except GeometryError:
        assert not ((beyond < 0).any() and (beyond > 0).any() and keep * beyond.max() > 0)
        return
    kept = made.surfaces["F2"].vertices[made.surfaces["F2"].triangles]
    assert (keep * (kept[:, :, 0] - at) >= 0).all()
    (told,) = made.truncations
    area = 0.5 * np.linalg.norm(normals, axis=1).sum()
    assert told.kept_area + told.dropped_area == pytest.approx(area, rel=1e-12)


@given(st.lists(corner, min_size=6, max_size=6, unique=True))
def test_law_closest_approach_is_the_least_of_many_samples(points):
    p = np.array(points, dtype=float)
    p[3:] += (0, 0, 3)
    one, two = np.array([[0, 1, 2]]), np.array([[3, 4, 5]])
    for t in (one, two):
        if not np.cross(p[t[0, 1]] - p[t[0, 0]], p[t[0, 2]] - p[t[0, 0]]).any():
            return
    found = closest_approach(p, one, two)
    n = 12
    u, v = (k.ravel() / n for k in np.meshgrid(np.arange(n + 1), np.arange(n + 1)))
    u, v = u[u + v <= 1], v[u + v <= 1]
    a, b = (p[t[0, 0]] + u[:, None] * (p[t[0, 1]] - p[t[0, 0]])
            + v[:, None] * (p[t[0, 2]] - p[t[0, 0]]) for t in (one, two))  # fmt: skip
    sampled = np.linalg.norm(a[:, None] - b[None], axis=2).min()
    # samples are at most one step of either triangle away from the closest places
    assert found.distance <= sampled + 1e-9
    assert np.linalg.norm(found.at - found.there) == pytest.approx(found.distance, abs=1e-12)
    if sampled > 2.0:
        assert found.distance >= sampled - 2 * 4 * math.sqrt(3) / n


# ---- Sides of faults in an area of interest: inside its fence, not in the box around it.
NOTCHED = [(0, 1), (8, 1), (8, 8), (5, 8), (4, 3), (3, 8), (0, 8)]
RULES = {"F2": ("F1", "hanging wall")}


def holds(ring, x, y):
    """Whether a place is inside a ring: by the sides that a ray to the east crosses."""
    inside = False
    for (ax, ay), (bx, by) in zip(ring, [*ring[1:], ring[0]], strict=True):
        if (ay > y) != (by > y) and x < ax + (y - ay) * (bx - ax) / (by - ay):
            inside = not inside
    return inside


@pytest.mark.parametrize("turn", [1, -1])
def test_triangles_lie_where_their_middles_are(turn):
    """A wavy sheet, a plane along a side of the area, and one that never meets the fence."""
    axis = np.linspace(-1.0, 9.0, 8)
    x, y = np.meshgrid(axis, axis)
    look = {"role": "fault", "spacing": 10.0 / 7.0, "corner": (-1.0, -1.0)}
    wavy = grid("F1", 4.0 + np.sin(x * y), **look)
    side = sheet("F2", [(-1, 1, -1), (9, 1, -1), (9, 1, 9), (-1, 1, 9)])
    inner = sheet("F3", [(1, 2, 3), (2, 2, 3), (2, 2.5, 3), (1, 2.5, 3)])
    outer = sheet("F4", [(3.9, 6, 3), (4.1, 6, 3), (4.1, 6.5, 3), (3.9, 6.5, 3)])
    walls = build_walls(BOX, NOTCHED[::turn])
    patches = rebuild_surfaces([wavy, side, inner, outer, *walls])
    rows = np.flatnonzero(patches.surface_of_triangle >= 4)
    found = inside_area(patches, rows)
    assert not found[rows].any()
    middles = patches.vertices[patches.triangles].mean(axis=1)
    for name, expected in (("F2", False), ("F3", True), ("F4", False)):
        mine = patches.surface_of_triangle == patches.names.index(name)
        assert set(found[mine].tolist()) == {expected}
    mine = np.flatnonzero(patches.surface_of_triangle == 0)
    assert [holds(NOTCHED, *middles[i, :2]) for i in mine] == found[mine].tolist()


def test_what_happens_in_the_box_beyond_the_area_does_not_matter():
    """F1 ends in the box, but beyond the area: there F2 goes on around it."""
    main = sheet("F1", [(-1, 0.5, 9), (9, 0.5, -1), (9, 9, -1), (-1, 9, 9)])
    faults = {"F1": main, "F2": antithetic()}
    with pytest.raises(GeometryError, match=r"goes on around the end of 'F1' at .*N 0\.5"):
        _ = Scene({}, faults, BOX, truncations=RULES).units
    scene = Scene({}, faults, BOX, aoi=NOTCHED, truncations=RULES)
    assert scene.check().ok
    assert {unit.block for unit in scene.units.values()} >= {"F1-", "F1+ F2+", "F1+ F2-"}
    area = abs(ring_area(NOTCHED))
    assert scene.units.volume == pytest.approx(8.0 * area, rel=1e-12)
    again = scene.replace(aoi=None)
    refused(GeometryError, "goes on around", lambda: again.units)


@pytest.mark.parametrize("turn", [1, -1])
def test_faults_are_extended_out_of_the_box_that_is_given(turn):
    """Horizons fill it beyond the area of interest, and are torn there, too."""
    small = sheet("F1", [(3, 3, 5), (5, 3, 3), (5, 5, 3), (3, 5, 5)])
    options = {"extend": ["F1"], "box": BOX}
    whole = Scene({}, {"F1": small}, **options).surface("F1")
    ring = [(1, 2), (7, 2), (7, 6), (1, 6)][::turn]
    scene = Scene({}, {"F1": small}, aoi=ring, **options)
    np.testing.assert_array_equal(scene.surface("F1").vertices, whole.vertices)
    south, north = scene.surface("F1").bounds[2:4]
    assert south < BOX[2] < BOX[3] < north
    assert {unit.block for unit in scene.units.values()} == {"F1+", "F1-"}
    top = grid("Top", np.full((9, 9), 4.0))
    alone = Scene({"Top": top}, {"F1": small}, aoi=ring, extend=["F1"])  # no box: the area's
    assert alone.surface("F1").bounds[2] < 2.0 < 6.0 < alone.surface("F1").bounds[3] < 8.0


def test_walls_that_are_not_closed_are_refused():
    fault = sheet("F1", [(1, 2, 3), (9, 2, 3), (9, 2, 12), (1, 2, 12)])
    patches = rebuild_surfaces([fault, *build_walls(BOX, NOTCHED)[:2]])  # without the top
    rows = np.flatnonzero(patches.surface_of_triangle > 0)
    words = r"'F1' lies inside and outside .* Give all that build_"
    refused(GeometryError, words, inside_area, patches, rows)


# ---- On which side a fault leaves a bent one: against arithmetic that a child could follow.
place = st.tuples(*[st.integers(-2, 2)] * 2, st.integers(-1, 3))


def height(p, a, b, c):
    """Six times the volume of a, b, c and p: positive in front of a, b, c."""
    u, v, w = ([Fraction(q[k] - a[k]) for k in range(3)] for q in (b, c, p))
    n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    return sum(x * y for x, y in zip(n, w, strict=True))


def in_front(p, u, v, left, right):
    """Whether p lies in front of the flanks (u, v, left) and (v, u, right); 0 where it is in one.

    In front of a fold towards the front is what is in front of both flanks; of a fold towards the
    back, what is in front of one of them.
    """
    one, two = height(p, u, v, left), height(p, v, u, right)
    fold = height(right, u, v, left)
    if fold == 0:  # flat, or folded onto itself
        return 1 if one > 0 else -1 if one < 0 else 0
    if fold > 0:
        return 1 if one > 0 and two > 0 else -1 if one < 0 or two < 0 else 0
    return 1 if one > 0 or two > 0 else -1 if one < 0 and two < 0 else 0


@given(place, place, place, st.booleans(), st.booleans())
def test_law_the_side_of_a_fold_is_that_of_two_planes(left, right, far, turn, back):
    u, v = (0, 0, 0), (0, 0, 2)
    expected = in_front(far, u, v, left, right)
    places = [u, v, left, right, far]
    if len(set(places)) < 5 or any(p[0] == p[1] == 0 for p in (left, right, far)):
        return
    across = left[0] * right[1] - left[1] * right[0]
    if across == 0 and left[0] * right[0] + left[1] * right[1] > 0:
        return  # a main fault folded onto itself
    if expected == 0:
        return  # in the plane of a flank
    main = TriSurface("F1", "fault", [u, v, left, right], [[0, 1, 2], [1, 0, 3]])
    faces = [[1, 0, 2]] if turn else [[0, 1, 2]]
    other = TriSurface("F2", "fault", [u, v, far], faces)
    patches = rebuild_surfaces([other, main] if back else [main, other])
    rows = [
        np.flatnonzero(patches.surface_of_triangle == patches.names.index(n)) for n in ("F2", "F1")
    ]
    beside = adjacency(patches, *rows)
    # the piece at the edge u, v alone: flanks may be met again elsewhere
    at_edge = [
        beside.piece[half // 3]
        for half, edge in zip(beside.half_edges, beside.edge_of_half, strict=True)
        if (patches.vertices[beside.edges[edge]][:, :2] == 0).all()
    ]
    sides = beside.beside[at_edge]
    assert len(sides) > 0
    assert sides[:, 0 if expected > 0 else 1].all()


@given(st.integers(1, 40), st.integers(1, 40), st.integers(-3, 3))
def test_law_nearly_flat_folds_far_from_the_origin_are_told_exactly(a, b, lift):
    """A fold of one part in 10^9 at UTM coordinates, and a fault between its flanks' planes."""
    origin = np.array([460_000.0, 5_930_000.0, -2_000.0])
    tiny = 2.0**-28
    main = np.array([[0, 0, 0], [0, 64, 0], [-64, 0, -a * tiny], [64, 0, -b * tiny]])
    fault = np.array([[0, 0, 0], [0, 64, 0], [-64, 0, lift * tiny - a * tiny]])
    if lift == 0:
        return
    surfaces = [
        TriSurface("F1", "fault", main + origin, [[0, 1, 2], [1, 0, 3]]),
        TriSurface("F2", "fault", fault + origin, [[0, 1, 2]]),
    ]
    try:
        patches = rebuild_surfaces(surfaces)
    except GeosurfError:
        return  # refused by name: too thin for float64
    if patches.report["moved_vertices"]:
        return
    rows = [np.flatnonzero(patches.surface_of_triangle == k) for k in (1, 0)]
    assert adjacency(patches, *rows).beside.tolist() == [[lift > 0, lift < 0]]
