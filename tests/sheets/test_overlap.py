"""Horizons that overlap by many cells, on a plane that dips by 30 degrees: throw is known."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import GeometryError

CELL, MIDDLE, LEVEL = 40.0, 2003.0, -1500.0
RUN = float(1.0 / np.tan(np.radians(30.0)))
X, Y = np.arange(-200.0, 4201.0, CELL), np.arange(0.0, 801.0, CELL)


def thrust():
    """A plane that rises eastward: its hanging wall is in the west."""
    corners = [
        (MIDDLE + (z - LEVEL) * RUN, y, z)
        for y, z in ((-900, -3000), (1700, -3000), (1700, 0), (-900, 0))
    ]
    return {"T": gs.TriSurface("T", "fault", np.array(corners, float), [[0, 1, 2], [0, 2, 3]])}


def overlapping(throw):
    """Points of two level walls, each up to its own cut-off."""
    x, y = (a.ravel() for a in np.meshgrid(X, Y))
    upper, lower = LEVEL + 0.5 * throw, LEVEL - 0.5 * throw
    hanging = x < MIDDLE + (upper - LEVEL) * RUN
    foot = x > MIDDLE + (lower - LEVEL) * RUN
    wall = [(x[hanging], y[hanging], upper), (x[foot], y[foot], lower)]
    return np.concatenate([np.column_stack([a, b, np.full(len(a), z)]) for a, b, z in wall])


@pytest.mark.parametrize("trim", [1.0, 3.0])
@pytest.mark.parametrize("cells", [6.0, 9.0, 15.0, 21.0])
def test_throw_does_not_depend_on_the_width_of_an_overlap(cells, trim):
    """At nine cells and more a mean of both walls was taken for the horizon, without throw."""
    throw = cells * CELL / RUN
    data = overlapping(throw)
    sheet = gs.tear_horizon(data, thrust(), name="H", trim=trim, positive="up")
    np.testing.assert_allclose(sheet.cuts["T"].throw, -throw, rtol=1e-6)


def test_an_overlap_that_is_too_wide_is_refused_by_name():
    data = overlapping(26.0 * CELL / RUN)
    with pytest.raises(GeometryError, match=r"by 26 cells at fault 'T', near \(.* of 47.* m or mo"):
        gs.tear_horizon(data, thrust(), name="H", trim=1.0, positive="up")


@pytest.mark.parametrize("cells", [9.0, 26.0])
def test_throw_that_is_given_may_overlap_by_any_width(cells):
    """Wider than 24 cells, no wall had a cut-off, and throw was not a number anywhere."""
    coords = {"northing": Y, "easting": X}
    flat = xr.DataArray(np.full((len(Y), len(X)), LEVEL), coords, attrs={"units": "m"})
    throw = cells * CELL / RUN
    sheet = gs.throw_horizon(flat, thrust(), {"T": -throw}, name="H", positive="up")
    np.testing.assert_allclose(sheet.cuts["T"].throw, -throw, rtol=1e-6)


@pytest.mark.parametrize("cells", [5, 6])
def test_a_tear_that_ends_where_it_starts_parts_nothing(cells):
    """Its only triangle was there twice, so that no unit could be found."""
    world = gs.synthetic.torn("thrust", n=41)
    scene = gs.Scene(world.horizons, world.faults, tear=cells)
    with pytest.warns(gs.GeosurfWarning, match="throw dies there"):
        certificate = scene.check()
    assert certificate.ok
    assert len(scene.units) == 2
