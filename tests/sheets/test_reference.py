"""A torn horizon stays in the reference system of its data, and no other is mixed in."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs

UTM31, UTM32 = "EPSG:32631", "EPSG:32632"


@pytest.fixture(scope="module")
def world():
    return gs.synthetic.torn("through", 31)


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


def test_a_scene_compares_torn_horizons_with_its_other_surfaces(world):
    top = world.horizons["Top"]
    sheet = torn(top.assign_attrs(crs=UTM31), world.faults)
    base = (top - 300.0).assign_attrs(crs=UTM32)
    box = (100, 600, 100, 600, -2200, -1600)
    scene = gs.Scene({"Top": sheet, "Base": base}, {f.name: f for f in sheet.faults}, box)
    with pytest.raises(gs.errors.InputError, match=r"in EPSG:32632, but .*'Top' is in EPSG:32631"):
        _ = scene.units
