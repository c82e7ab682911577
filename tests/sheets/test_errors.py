"""Messages of the sheets say what is wrong, where, what next; reference systems stay apart."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import GeometryError, HorizonError, InputError
from geosurf.sheets.mesh import build
from tests.messages import refused


@pytest.fixture(scope="module")
def world():
    return gs.synthetic.torn("through", n=31)


def test_faults_need_names_of_their_own(world):
    fault, top = gs.triangulate_fault(world.faults["F1"], name="F1"), world.horizons["Top"]
    refused(InputError, r"2 faults are called 'F1'; rename", gs.tear_horizon, top, [fault, fault])
    refused(InputError, r"faults is a TriSurface; give a mapping", gs.tear_horizon, top, fault)


def test_data_that_cannot_be_torn(world):
    mesh = gs.TriSurface("Top", "horizon", [[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]])
    words = r"'Top' is a mesh without a lattice.*Give the grid"
    refused(HorizonError, words, gs.tear_horizon, mesh, world.faults)
    points, scattered = world.truth["points"].copy(), world.truth["points"].copy()
    points[7, 2] = np.nan
    scattered[5, 0] += 9.0
    for data, words in (
        (points, r"1 points are not finite, the first is point 7"),
        (scattered, r"1 of \d+ points lie off the lattice.*0\.36 cells off"),
        (np.arange(4.0), r"points have shape \(4,\), expected numbers \(n, 3\)"),
    ):
        refused(HorizonError, words, gs.tear_horizon, data, world.faults, positive="up")


def test_points_that_do_not_declare_elevation_or_depth_are_refused(world):
    """Two horizons at 2000 and 2100 m of depth were elevations, the younger one below."""
    points = world.truth["points"]
    names = ["easting", "northing", "elevation"]
    table = pd.DataFrame(points, columns=names)
    dataset = xr.Dataset(
        {name: ("point", column) for name, column in zip(names, points.T, strict=True)}
    )
    for data in (points, points.tolist(), table, dataset):
        for call in (gs.tear_horizon, gs.propose_trim):
            with pytest.raises(HorizonError, match=r"depth or elevation.* positive='down'.*'up'"):
                call(data, world.faults)
    depths = dataset.assign(elevation=-dataset["elevation"])
    depths["elevation"].attrs["positive"] = "down"
    found = gs.tear_horizon(depths, {}, name="Top")
    again = gs.tear_horizon(points, {}, name="Top", positive="up")
    np.testing.assert_array_equal(found.lattice.elevation, again.lattice.elevation)
    with pytest.raises(HorizonError, match=r"is 'down', the argument positive is 'up'. Leave"):
        gs.tear_horizon(depths, {}, positive="up")


def test_uneven_steps_are_refused(world):
    top = world.horizons["Top"]
    east = top["easting"].values.copy()
    east[10:] += 10.0
    with pytest.raises(HorizonError, match=r"even steps at right angles.*Resample it"):
        gs.tear_horizon(top.assign_coords(easting=east), world.faults)


def test_a_block_without_data_is_refused_by_name():
    world = gs.synthetic.torn("parallel", n=41, smear=0)
    top, turn = world.horizons["Top"], np.radians(12.0)
    across = (top["easting"] - 500.0) * np.cos(turn) - (top["northing"] - 500.0) * np.sin(turn)
    top = top.where(abs(across) > 60.0)  # nothing between the two faults
    with pytest.raises(
        GeometryError, match=r"block next to faults 'F1', 'F2' has no data.*fill_empty_blocks=True"
    ):
        gs.tear_horizon(top, world.faults, trim=1.0)


def test_an_overlap_that_scattered_points_cannot_close_is_told_with_its_width(monkeypatch):
    monkeypatch.setattr(build, "ROUNDS", 1)  # it stays so, however many rings it gets
    world = gs.synthetic.torn("thrust", n=61)
    points = world.truth["scattered"](6000)
    with pytest.raises(
        GeometryError, match=r"cut at fault 'F1'.* 6\.9 cells, .* or a larger spacing\."
    ):
        gs.tear_horizon(points, world.faults, name="Top", trim=0.5, spacing=25.0, positive="up")


# ---- A torn horizon stays in the reference system of its data, and no other is mixed in.
UTM31, UTM32 = "EPSG:32631", "EPSG:32632"


def torn(horizon, faults):
    return gs.tear_horizon(horizon, faults, name="Top")


def thrown(horizon, faults):
    return gs.throw_horizon(horizon, faults, {"F1": 10.0}, name="Top")


def no_throw(horizon, faults):
    return gs.throw_horizon(horizon, faults, {}, name="Top")


@pytest.mark.parametrize("make", [torn, thrown, no_throw])
def test_a_sheet_is_in_the_reference_system_of_its_data(world, make):
    top = world.horizons["Top"]
    assert make(top, world.faults).crs is None
    said = top.assign_attrs(crs=UTM31)
    for horizon in (said, gs.triangulate_horizon(said)):
        sheet = make(horizon, world.faults)
        assert sheet.crs == sheet.surface.crs == UTM31
    assert np.array_equal(sheet.surface.vertices, make(top, world.faults).surface.vertices)


@pytest.mark.parametrize("make", [torn, thrown])
def test_faults_in_another_reference_system_are_refused(world, make):
    top = world.horizons["Top"].assign_attrs(crs=UTM31)
    (fault,) = world.faults.values()
    same = make(top, {"F1": fault.assign_attrs(crs=UTM31.lower())})
    assert same.crs == UTM31
    with pytest.raises(
        gs.errors.InputError, match=r"'F1' is in EPSG:32632, but 'Top' is in EPSG:326"
    ):
        make(top, {"F1": fault.assign_attrs(crs=UTM32)})
