"""Faults that are continued by a distance: exact on planes, in scenes and in scenarios."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import InputError, SurfaceError
from tests.faults.worlds import BOX, across, bytes_of, turned, upright, volumes
from tests.strategies import sheet

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


def test_a_scene_lengthens_first_and_extends_then():
    faults = {"F1": dipping(), "F2": sheet("F2", [(7, 1, 1), (7, 2, 1), (7, 2, 2), (7, 1, 2)])}
    scene = gs.Scene({}, faults, BOX, lengthen={"F1": {"strike": 0.5}}, extend={"F1": "down"})
    sides = [(e.fault, e.side, e.until) for e in scene.fault_actions]
    assert sides == [
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
        (0, "is 0. Give a distance in metres above 0"),
        ("far", "is 'far'. Give a distance"),
        ({"left": 3}, "has side 'left'; sides are"),
        ({"up": -1}, "Give a distance in metres above 0"),
        ({"strike": 1, "end": 2}, "gives side 'end' twice"),
    ):
        with pytest.raises(InputError, match=words):
            gs.lengthen_fault(dipping(), wrong)
        with pytest.raises(InputError, match=words):
            gs.Scene({}, {"F1": dipping()}, BOX, lengthen={"F1": wrong})
    with pytest.raises(InputError, match=r"lengthen names 'F9', which is not a fault"):
        gs.Scene({}, {"F1": dipping()}, BOX, lengthen={"F9": 1})


def test_a_mesh_in_pieces_becomes_a_fault_of_each():
    one, two = upright(3, n=(2, 2)), across(4)
    # pieces that meet in a place, but not along an edge; vertices at one place are given twice
    moved = two.vertices + np.array([4, 5, 0])
    x = np.concatenate([one.vertices, moved])
    t = np.concatenate([two.triangles + one.n_vertex, one.triangles])
    mesh = gs.TriSurface("F1", "fault", x, t)
    with pytest.raises(SurfaceError, match=r"is in 2 pieces.*gs.split_fault"):
        gs.lengthen_fault(mesh, 5)
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
