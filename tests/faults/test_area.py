"""Sides of faults in an area of interest: inside its fence, not in the box around it."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import Scene, build_walls, rebuild_surfaces
from geosurf.errors import GeometryError
from geosurf.faults.truncate import inside_area
from tests.faults.worlds import BOX, antithetic
from tests.strategies import grid, sheet

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
    ring = np.array(NOTCHED)
    p, q = ring, np.roll(ring, -1, axis=0)
    area = 0.5 * abs((p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]).sum())
    assert scene.units.volume == pytest.approx(8.0 * area, rel=1e-12)
    again = scene.replace(aoi=None)
    with pytest.raises(GeometryError, match="goes on around"):
        _ = again.units


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
    with pytest.raises(
        GeometryError, match=r"'F1' lies inside and outside .* Give all that build_"
    ):
        inside_area(patches, rows)
