"""Horizons that are continued beyond their rim: exact where they can be, marked everywhere."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import GeosurfWarning
from geosurf.render.compose import plotted
from geosurf.render.map import draw_map
from tests.grids import gridded, turned

E0, N0 = 460000.0, 5930000.0


def grid(function, degrees=30.0, shape=(41, 31), cell=50.0):
    """A turned grid of some elevations."""
    east, north, *_ = turned(degrees, shape, cell, (E0, N0))
    axes = (east[0], north[:, 0]) if degrees == 0 else (east, north)
    return gridded(function(east - E0, north - N0), *axes)


def error(function, wide):
    """Largest error at new nodes [m]."""
    there = wide.extrapolated.values
    x, y = xr.broadcast(wide.easting, wide.northing)
    x, y = (one.transpose(*wide.dims).values for one in (x, y))
    return float(np.nanmax(np.abs(wide.values - function(x - E0, y - N0))[there]))


def plane(x, y):
    return -1700 + 0.1 * x - 0.05 * y


def bowl(x, y):
    return plane(x, y) + 1e-5 * x * x - 2e-5 * x * y + 3e-5 * y * y


def folds(x, y):
    return -1700 + 30 * np.sin(2 * np.pi * x / 3000) * np.cos(2 * np.pi * y / 2500)


@pytest.mark.parametrize("degrees", [0.0, 30.0, 211.0])
@pytest.mark.parametrize("function", [plane, bowl])
def test_planes_and_quadratics_are_continued_exactly(function, degrees):
    given = grid(function, degrees)
    wide = gs.extend_horizon(given, distance=500.0)
    assert error(function, wide) < 1e-6
    kept = ~wide.extrapolated.values & np.isfinite(wide.values)
    np.testing.assert_array_equal(np.sort(wide.values[kept]), np.sort(given.values.ravel()))
    assert kept.sum() == given.size
    easting = xr.broadcast(wide.easting, wide)[0].transpose(*wide.dims).values[kept]
    every = xr.broadcast(given.easting, given)[0].values.ravel()
    np.testing.assert_array_equal(np.sort(easting), np.sort(every))


def test_the_error_on_folds_falls_with_the_cube_of_the_distance():
    errors = [
        error(folds, gs.extend_horizon(grid(folds), distance=d)) for d in (400.0, 200.0, 100.0)
    ]
    assert errors[0] < 15
    assert errors[0] / errors[1] > 4
    assert errors[1] / errors[2] > 4


def test_noise_is_not_carried_on():
    rng = np.random.default_rng(0)
    wide = gs.extend_horizon(grid(plane) + rng.normal(0, 0.1, (41, 31)), distance=400.0)
    assert error(plane, wide) < 5


def test_no_node_is_farther_from_data_than_asked_and_an_area_limits_them():
    given, ring = grid(plane), [(E0, N0), (E0 + 900, N0 - 200), (E0 + 900, N0 + 900)]
    wide = gs.extend_horizon(given, ring, distance=230.0)
    new = wide.extrapolated.values
    places = np.stack([wide.easting.values, wide.northing.values], axis=-1)
    data = np.stack([given.easting.values, given.northing.values], axis=-1).reshape(-1, 2)
    far = [np.hypot(*(data - place).T).min() for place in places[new]]
    assert 0 < max(far) <= 230.0 + 1e-6
    assert 0 < new.sum() < gs.extend_horizon(given, distance=230.0).extrapolated.sum()
    assert places[new][:, 1].min() > N0 - 400


def test_a_hole_is_filled_from_its_own_side_of_a_fault():
    """Two plateaus, 60 m apart, with a hole across the fault between them."""

    def step(x, y):
        return np.where(x < 1000.0, -1700.0, -1760.0) + 0.02 * y

    holed = grid(step, 0.0, shape=(41, 41))
    holed[15:24, 14:27] = np.nan
    wall = np.array([[E0 + 990, N0 - 99, -2e3], [E0 + 990, N0 + 2100, -2e3],
                     [E0 + 990, N0 + 2100, -1500], [E0 + 990, N0 - 99, -1500]])  # fmt: skip
    fault = gs.TriSurface("F1", "fault", wall, [[0, 1, 2], [0, 2, 3]])
    across = gs.extend_horizon(holed, fill_holes=True)
    assert across.shape == holed.shape
    assert error(step, across) > 15
    own = gs.extend_horizon(holed, fill_holes=True, faults={"F1": fault})
    assert error(step, own) < 1e-6


def test_points_with_a_wide_hole_leak_and_are_filled_from_their_side_of_a_fault():
    xy = np.random.default_rng(2).uniform(0.0, 3000.0, (4000, 2))
    xy = xy[np.hypot(xy[:, 0] - 700.0, xy[:, 1] - 1500.0) > 550.0]

    def step(x, y):
        return -1000.0 + 0.02 * x + 0.01 * y - 60.0 * (x > 1500.0)

    points = np.column_stack([xy, step(*xy.T)])
    corners = [[1500, y, z] for y, z in ((-99, -2000), (3099, -2000), (3099, 0), (-99, 0))]
    faults = {"F1": gs.TriSurface("F1", "fault", corners, [[0, 1, 2], [0, 2, 3]])}
    scene = gs.Scene({"Top": points}, faults, positive="up", tear=True)
    with pytest.raises(gs.errors.OpenUnitError, match=r"fill_holes=True\), .* in a scenario"):
        scene.check()
    filled = gs.extend_horizon(points, fill_holes=True, faults=faults, positive="up")
    east, north = np.meshgrid(filled.easting, filled.northing)
    np.testing.assert_allclose(filled, step(east, north), atol=0.05)
    with pytest.warns(GeosurfWarning, match="extrapolated over 0.8"):
        assert scene.replace(horizons={"Top": filled}).check().ok


def test_a_scene_lists_what_is_extrapolated_and_the_map_hatches_it(tmp_path):
    scene = gs.Scene({"T": gs.extend_horizon(grid(plane), distance=300.0)})
    with pytest.warns(
        GeosurfWarning, match=r"'T' is extrapolated over 2\.\d+ km², up to (29\d|300) m"
    ):
        (found,) = scene.warnings
    assert found.kind == "extrapolated"
    assert scene.check().ok
    surface = scene.surface("T")
    plain = plotted(draw_map, surface, path=tmp_path / "plain.png", size=(400, 300))
    hatched = plotted(
        draw_map, surface, path=tmp_path / "hatched.png", size=(400, 300), hatched=surface
    )
    assert plain.read_bytes() != hatched.read_bytes()
    assert gs.Scene({"T": grid(plane)}).warnings == ()


def test_a_decreasing_axis_keeps_its_marks():
    wide = gs.extend_horizon(grid(plane, 0.0), distance=100.0)
    up, down = (gs.triangulate_horizon(one) for one in (wide, wide[::-1, ::-1]))
    np.testing.assert_array_equal(up.vertex_data["extrapolated"], down.vertex_data["extrapolated"])


# the last digits of a solve decide whether rounding moves a vertex, and processors differ there
@pytest.mark.filterwarnings("ignore:.*vertices of 'Top' moved by:geosurf.errors.GeosurfWarning")
def test_a_torn_horizon_keeps_its_marks(tmp_path):
    world = gs.synthetic.torn("normal", 41)
    wide = gs.extend_horizon(world.horizons["Top"], distance=100.0, faults=world.faults)
    sheet = gs.tear_horizon(wide, world.faults, name="Top")
    np.testing.assert_array_equal(sheet.extrapolated, wide.extrapolated.values)
    scene = gs.Scene({"Top": sheet}, {fault.name: fault for fault in sheet.faults})
    with pytest.warns(GeosurfWarning, match="'Top' is extrapolated over"):
        _ = scene.warnings
    assert scene.check().ok
