"""Areas whose sides run along the rim of a horizon: closed, and what that leaves out is stated."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import GeosurfWarning
from geosurf.triangulate.outline import NEAR, _found_beside, _is_clear, off_the_rims


def turned(degrees, shape=(9, 7)):
    """A grid turned about its corner, and its four corner nodes."""
    i, j = np.meshgrid(np.arange(shape[1]) * 50.0, np.arange(shape[0]) * 50.0)
    turn = np.radians(degrees)
    east = 460000 + i * np.cos(turn) - j * np.sin(turn)
    north = 5930000 + i * np.sin(turn) + j * np.cos(turn)
    values = -1700 + 0.02 * i + 0.01 * j
    coords = {"easting": (("row", "column"), east), "northing": (("row", "column"), north)}
    grid = xr.DataArray(values, coords, ("row", "column"), attrs={"units": "m", "positive": "up"})
    corners = np.array([[east[a], north[a]] for a in ((0, 0), (0, -1), (-1, -1), (-1, 0))])
    return grid, corners


@pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
@pytest.mark.parametrize("decimals", [None, 3, 2])
@pytest.mark.parametrize("degrees", [1e-3, 7.0, 30.0, 45.0, 89.9, 133.0, 271.0])
def test_the_corners_of_a_grid_are_an_area_that_is_closed(degrees, decimals):
    grid, corners = turned(degrees, (40, 30))
    given = corners if decimals is None else corners.round(decimals)
    scene = gs.Scene({"T": grid}, {}, aoi=given)
    assert len(scene.units) == 2
    assert scene.check().ok


def test_the_warning_states_what_is_left_out():
    grid, corners = turned(30.0)
    scene = gs.Scene({"T": grid}, {}, aoi=corners.round(3))
    with pytest.warns(GeosurfWarning, match="runs along the rim of horizon 'T'"):
        area = scene.aoi
    (note,) = scene.warnings
    assert (note.kind, note.subject) == ("rim", "T")
    width, height = 300.0, 400.0
    lost = width * height - area_of(area)
    assert 0 < lost < 30.0
    assert note.effect.endswith(
        f"which leaves out {area_of(corners.round(3)) - area_of(area):.3g} m²."
    )


def area_of(ring):
    x, y = (ring - ring[0]).T
    return 0.5 * abs(float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)))


def test_an_area_exactly_on_the_rim_stays_as_it_is():
    x, y = np.arange(0, 301, 50.0) + 460000.1, np.arange(0, 201, 50.0) + 5930000.3
    coords = {"northing": y, "easting": x}
    attrs = {"units": "m", "positive": "up"}
    grid = xr.DataArray(np.full((5, 7), -1700.0), coords, ("northing", "easting"), attrs=attrs)
    box = (x[0], x[-1], y[0], y[-1], -1800.0, -1600.0)
    scene = gs.Scene({"T": grid}, {}, box)
    assert scene.box == box
    assert len(scene.units) == 2
    assert scene.warnings == ()


def test_a_box_beside_the_rim_by_rounding_is_closed_and_an_area_inside_stays():
    grid, corners = turned(0.0)
    west, south = corners.min(axis=0)
    east, north = corners.max(axis=0)
    scene = gs.Scene({"T": grid}, {}, (west - 1e-9, east, south, north, -1800.0, -1500.0))
    with pytest.warns(GeosurfWarning, match="The model box runs along the rim"):
        assert len(scene.units) == 2
    top = gs.triangulate_horizon(grid, name="T")
    inside = corners.mean(axis=0) + 0.5 * (corners - corners.mean(axis=0))
    assert off_the_rims(inside, [top], "area of interest") is inside


def test_rims_around_holes_and_of_meshes_count():
    grid, corners = turned(30.0)
    padded, _ = turned(30.0, (11, 9))
    padded = padded.where((np.arange(11)[:, None] < 9) & (np.arange(9) < 7))
    mesh = gs.triangulate_horizon(grid, name="T")
    mesh = gs.TriSurface("T", "horizon", mesh.vertices, mesh.triangles)
    for horizon in (padded, mesh):
        scene = gs.Scene({"T": horizon}, {}, aoi=corners)
        with pytest.warns(GeosurfWarning, match="rim of horizon 'T'"):
            assert len(scene.units) == 2


def test_a_horizon_that_ends_farther_inside_still_leaks():
    grid, corners = turned(30.0)
    middle = corners.mean(axis=0)
    with pytest.raises(gs.errors.OpenUnitError, match="Shrink"):
        _ = gs.Scene({"T": grid}, {}, aoi=middle + 1.001 * (corners - middle)).units


def test_grids_that_are_clear_of_a_box_by_their_axes_are_not_searched():
    """Wherever axes show that no node is just inside, the search of the rim finds none, either."""
    rng, seen = np.random.default_rng(3), []
    x, y = np.arange(0.0, 301.0, 50.0), np.arange(0.0, 201.0, 50.0)
    coords = {"northing": y, "easting": x}
    attrs = {"units": "m", "positive": "up"}
    grid = xr.DataArray(np.full((5, 7), -1700.0), coords, ("northing", "easting"), attrs=attrs)
    for whole in (True, False):
        grid[2, 3] = -1700.0 if whole else np.nan
        surface = gs.triangulate_horizon(grid, name="T")
        for _ in range(200):
            off = rng.choice([0.0, 1e-9, -1e-9, 1e-4, -1e-4, 20.0, -20.0], 4)
            west, east, south, north = np.array([0.0, 300.0, 0.0, 200.0]) + off
            ring = np.array([(west, south), (east, south), (east, north), (west, north)])
            near = NEAR * float(np.ptp(ring, axis=0).max())
            clear = _is_clear(ring, surface, near)
            assert not clear or _found_beside(ring, surface, near)[1] == 0.0
            seen.append(clear)
    assert 0.1 < np.mean(seen) < 0.9
    assert not _is_clear(ring[[0, 1, 3, 2]], surface, near)  # sides that are no rectangle's
