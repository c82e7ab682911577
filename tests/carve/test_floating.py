"""Pieces that touch nothing, inside an area of interest and in the corners beyond its walls."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf import TriSurface, build_walls, carve_units, rebuild_surfaces
from geosurf.carve.cells import find_cells
from geosurf.carve.measures import AREA
from geosurf.carve.zones import owned_by
from geosurf.errors import GeometryError, OpenUnitError
from tests import laws, oracles
from tests.strategies import sheet, soups

# part of the field, or some faults, are left out on purpose; the warnings have tests of their own
pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")

BOX = (0.0, 8.0, 0.0, 8.0, -4.0, 4.0)
CORNER = [(0, 0), (8, 0), (0, 8)]  # x + y <= 8: half of the box, 32 m2 and 8 m high

# squares around (6, 6, 0), beyond the slanted wall, and upright or flat as rays run
BEYOND = {
    "x": [(6, 5, -1), (6, 7, -1), (6, 7, 1), (6, 5, 1)],
    "y": [(5, 6, -1), (7, 6, -1), (7, 6, 1), (5, 6, 1)],
    "z": [(5, 5, 0), (7, 5, 0), (7, 7, 0), (5, 7, 0)],
}


def carve(surfaces, ring=CORNER, box=BOX):
    return laws.carved(surfaces, ring, box)


def volumes(units):
    return {name: unit.volume for name, unit in units.items()}


def moved(corners, offset):
    return [tuple(np.add(corner, offset)) for corner in corners]


def closed(name, low, high):
    """A closed fault: the sides of a box."""
    walls = build_walls((low[0], high[0], low[1], high[1], low[2], high[2]))
    corners = np.concatenate([wall.vertices[wall.triangles] for wall in walls]).reshape(-1, 3)
    vertices, number = np.unique(corners, axis=0, return_inverse=True)
    return TriSurface(name, "fault", vertices, number.reshape(-1, 3))


# ------------------------------------------------------------------ beyond the walls


def test_a_horizon_beyond_the_walls_is_told():
    words = (
        r"horizon 'Top' \(easting 5 to 7, northing 5 to 7, elevation 0 to 0\) lies outside the "
        r"area of interest, .* Enlarge the area, or leave the horizon out\."
    )
    with pytest.raises(GeometryError, match=words):
        carve([sheet("Top", BEYOND["z"], role="horizon")])


# ------------------------------------------------------------- inside, across, both


def test_side_by_side_nested_inside_and_beyond():
    """One surface with a part on either side; shells within shells on either side."""
    near, far = closed("In", (1, 1, -1), (2, 2, 1)), closed("Out", (5, 5, -2), (7, 7, 2))
    sheets = [sheet("F1", moved(BEYOND["z"], shift)) for shift in ((-4, -4, 3), (0, 0, 3))]
    both = TriSurface(
        "F1", "fault",
        np.concatenate([part.vertices for part in sheets]),
        np.concatenate([part.triangles + 4 * i for i, part in enumerate(sheets)]),
    )  # fmt: skip
    within = [sheet(f"S{k}", [(c, c, 0), (d, c, 0), (d, d, 0), (c, d, 0)])
              for k, (c, d) in enumerate([(1.25, 1.75), (5.5, 6.5)])]  # fmt: skip
    surfaces = [near, far, both, *within]
    for order in (surfaces, surfaces[::-1]):
        units = carve(order)
        assert volumes(units) == {"box In+": 254.0, "box In-": 2.0}
        assert units.report["slits"] == pytest.approx({"F1": 4.0, "S0": 0.25})


def inside(corners):
    """Area of a triangle's part in x, y >= 0, x + y <= 8, exact but for its last step."""
    part = oracles.rational(corners)
    for normal, through in [
        ((1, 0, 0), (0, 0, 0)), ((0, 1, 0), (0, 0, 0)), ((-1, -1, 0), (8, 0, 0)),
        ((0, 0, 1), (0, 0, -4)), ((0, 0, -1), (0, 0, 4)),
    ]:  # fmt: skip
        part = oracles.clip(part, normal, through)
    return oracles.area(part) if part else 0.0


@given(soups(most=1, extent=6, names=("F1", "F2", "F3")), st.sampled_from([1.0, 1.5]))
def test_what_faults_have_inside_is_what_clipping_leaves(faults, scale):
    """Any triangles, in whatever way they float, touch or cross: law of the sides."""
    faults = [
        TriSurface(f.name, "fault", f.vertices * scale + (1.0, 1.0, -3.0), f.triangles)
        for f in faults
    ]
    patches = rebuild_surfaces([*faults, *build_walls(BOX, CORNER)])
    cells = find_cells(patches)
    for i, fault in enumerate(faults):
        mine = owned_by(cells, i)
        seen = mine[(cells.cell_of_side[mine] > 0).any(axis=1)]
        want = inside(fault.vertices[fault.triangles[0]])
        assert math.fsum(cells.sums[seen, AREA].ravel()) == pytest.approx(want, rel=1e-9, abs=1e-9)
    assert carve_units(patches).volume == pytest.approx(256.0, rel=1e-12)


# --------------------------------------------------------------------- the walls
@pytest.mark.parametrize("missing", range(6))
def test_in_an_open_box_the_walls_are_blamed(missing):
    walls = [wall for i, wall in enumerate(build_walls(BOX)) if i != missing]
    for corners in BEYOND.values():
        with pytest.raises(OpenUnitError, match=r"walls of the model are open: wall '.*its six"):
            carve_units(rebuild_surfaces([sheet("F1", corners), *walls]))


def test_a_fault_that_is_all_of_the_walls():
    """It stands for them: the walls have no triangle of their own left."""
    around = closed("Salt", BOX[::2], BOX[1::2])
    units = carve([around, sheet("F1", BEYOND["x"])], None)
    assert [unit.volume for unit in units.values()] == [512.0]
    assert units.report["slits"] == {"F1": pytest.approx(4.0)}


def test_a_wall_that_is_missing_under_a_fault_is_called_by_its_name():
    walls = build_walls(BOX)
    cover = TriSurface("Cover", "fault", walls[0].vertices, walls[0].triangles)
    with pytest.raises(OpenUnitError, match=f"open: wall '{walls[0].name}' has"):
        carve_units(rebuild_surfaces([cover, *walls[:-1]]))
