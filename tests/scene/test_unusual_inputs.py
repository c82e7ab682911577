"""Inputs as people have them: made when they are asked for, in feet, outside, without names."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import GeometryError, InputError


class Lazy:
    """An array that is made when somebody asks for its values, as those of dask are."""

    __array_priority__ = 20

    def __init__(self, values):
        self.hidden, self.asked = values, 0
        self.shape, self.dtype, self.ndim = values.shape, values.dtype, values.ndim

    def __array__(self, dtype=None, copy=None):
        self.asked += 1
        return np.array(self.hidden, dtype=dtype)

    def __array_function__(self, function, types, args, kwargs):
        raise TypeError(f"{function.__name__} is not for arrays that are not there yet")

    def __array_ufunc__(self, ufunc, method, *inputs, **kwargs):
        raise TypeError(f"{ufunc.__name__} is not for arrays that are not there yet")


@pytest.fixture(scope="module")
def world():
    return gs.synthetic.graben(n=9)


def scene(world, **more):
    return gs.Scene(world.horizons, world.faults, world.box, **more)


def lazily(da):
    return xr.DataArray(Lazy(da.values), da.coords, da.dims, da.name, da.attrs)


def test_arrays_that_are_made_when_asked_for_give_the_same_bytes(world):
    lazy = {name: lazily(da) for name, da in world.horizons.items()}
    twin = gs.Scene(lazy, world.faults, world.box)
    assert all(da.data.asked == 0 for da in lazy.values())
    assert twin.patches.local.tobytes() == scene(world).patches.local.tobytes()
    assert list(twin.units) == list(scene(world).units)
    for name, da in lazy.items():
        alone = gs.triangulate_horizon(da, name=name)
        assert alone.vertices.tobytes() == twin.surface(name).vertices.tobytes()


def test_a_fault_that_is_not_in_the_model_is_said_to_be_left_out(world):
    corners = [[9000, 0, -3000], [9000, 4000, -3000], [9100, 2000, -1000]]
    far = gs.TriSurface("Far", "fault", corners, [[0, 1, 2]])
    model = gs.Scene(world.horizons, {**world.faults, "Far": far}, world.box)
    with pytest.warns(gs.GeosurfWarning, match="Fault 'Far' lies 4000 m east of the model box"):
        assert list(model.units) == list(scene(world).units)
    (step,) = [step for step in model.steps if step.outcome == "skipped"]
    assert (step.stage, step.subject) == ("carve", "Far")
    assert step.detail == "does not reach the model box, and parts nothing"
    near = model.replace(faults={"Far": None})
    assert len(near.units) == len(model.units)
    assert not [step for step in near.steps if step.outcome == "skipped"]
    with pytest.raises(GeometryError, match=r"'Far' lies outside the model. Enlarge"):
        model.allan("Far")


def test_grids_in_two_reference_systems_are_refused_by_name(world, tmp_path):
    """Both are metres: nothing else would tell."""
    here = {name: da.assign_attrs(crs="EPSG:32631") for name, da in world.horizons.items()}
    gs.write(here["Base"].assign_attrs(crs="EPSG:23031"), tmp_path / "Base.nc")
    for other in (here["Base"].assign_attrs(crs="EPSG:23031"), tmp_path / "Base.nc"):
        with pytest.raises(
            InputError,
            match=r"'Base' is in EPSG:23031, but 'Top' is in EPSG:32631\. Convert one of them",
        ):
            _ = gs.Scene({**here, "Base": other}, world.faults, world.box).units
    fault = world.faults["F1"].assign_attrs(crs="epsg:23031")
    mixed = gs.Scene(here, {"F1": fault}, world.box)
    with pytest.raises(InputError, match=r"'F1' is in epsg:23031, but 'Top' is in EPSG:32631"):
        _ = mixed.surfaces
    with pytest.raises(InputError, match=r"'F1' is in epsg:23031"):
        _ = mixed.replace(box=world.box).surfaces  # what is remembered is compared, too
    made = gs.triangulate_fault(fault)
    assert made.crs == "epsg:23031"
    assert gs.triangulate_horizon(here["Top"], tolerance=1.0).crs == "EPSG:32631"
    with pytest.raises(InputError, match=r"'F1' is in epsg:23031"):
        _ = gs.Scene(here, {"F1": made}, world.box).surfaces  # made by hand, turned or not
    same = {"F1": world.faults["F1"].assign_attrs(crs="epsg:32631")}
    assert len(gs.Scene({**here, "Base": world.horizons["Base"]}, same, world.box).surfaces) == 4


def test_contacts_of_zones_and_blocks_that_there_are_not(world):
    def refused(contacts, words):
        with pytest.raises(InputError, match=words):
            _ = scene(world, contacts=contacts).units

    refused(
        {"OWC": gs.FluidContact(-2100.0, zones="Top/Bse")},
        r"'OWC': unknown zone 'Top/Bse'. Zones are \['above Top', ",
    )
    refused(
        {"OWC": gs.FluidContact(-2100.0, block="F9+")},
        r"'OWC': no unit lies on 'F9\+'. Name a block or a side of a fault: \['F1\+', ",
    )
    refused({"OWC": float("nan")}, r"the elevation of fluid contact 'OWC' is nan. Give a number")
    called = gs.FluidContact(-2100.0, name="GOC")
    refused({"OWC": called}, r"'OWC' holds a FluidContact with another name, 'GOC'. Use one name")
    refused({"OWC": -2.1}, r"'OWC' is at elevation -2\.1 m, outside the model box .*enlarge")
