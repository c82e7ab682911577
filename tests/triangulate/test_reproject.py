"""Coordinate reference systems: through every noun, and from one into another."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import DependencyError, InputError
from tests.messages import refused

CRS, OTHER = "EPSG:23031", "EPSG:32631"
STICKS = [np.array([[1500.0, y, -1500], [1700, y, -2600]]) for y in (-100, 1500, 3100)]


@pytest.fixture(scope="module")
def world():
    return gs.synthetic.tilted_planes(n=9)


def sticks(crs):
    made = gs.FaultSticks("F1", STICKS)
    object.__setattr__(made, "crs", crs)
    return made


def mesh(crs):
    surface = gs.triangulate_sticks(STICKS, name="F1")
    surface.crs = crs
    return surface.to_pyvista()


@pytest.mark.parametrize("fault", [sticks, mesh])
def test_sticks_and_meshes_bring_their_system(world, fault):
    horizons = {name: grid.assign_attrs(crs=CRS) for name, grid in world.horizons.items()}
    assert gs.Scene(horizons, {"F1": fault(CRS)}, world.box).surface("F1").crs == CRS
    scene = gs.Scene(horizons, {"F1": fault(OTHER)}, world.box)
    refused(InputError, rf"'F1' is in {OTHER}, but .* is in {CRS}\. Convert", lambda: scene.units)


def test_results_of_a_scene_are_in_its_system(world):
    scene = gs.Scene(world.horizons, world.faults, world.box, crs=CRS)
    assert {surface.crs for surface in scene.surfaces} == {scene.crs} == {CRS}
    tables = [
        scene.volumes,
        scene.units.table,
        scene.fault_polygons("Top"),
        scene.thickness("Top/Base"),
        scene.throw("Top", "F1"),
        scene.juxtaposition("F1", "all"),
        scene.orientation("Top"),
    ]
    assert {table.attrs["crs"] for table in tables} == {CRS}
    assert next(iter(scene.units.values())).to_pyvista().field_data["crs"][0] == CRS
    plain = gs.Scene(world.horizons, world.faults, world.box)
    assert plain.crs is None
    assert "crs" not in plain.volumes.attrs


# ---- conversion ----------------------------------------------------------------------------


def grid(world):
    top = world.horizons["Top"].assign_attrs(crs=CRS)
    return top.assign_coords(easting=top.easting + 450000.0, northing=top.northing + 6700000.0)


def test_what_cannot_be_converted_is_refused(world):
    refused(InputError, r"'Top' declares no .* source=", gs.reproject, world.horizons["Top"], OTHER)
    with pytest.raises(InputError, match=rf"'Top' is in {CRS}, but source is '{OTHER}'"):
        gs.reproject(grid(world), OTHER, source=OTHER)
    with pytest.raises(InputError, match="cannot convert Dataset"):
        gs.reproject(xr.Dataset(attrs={"crs": CRS}), OTHER)


def test_without_pyproj_the_remedy_is_an_extra(world, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyproj", None)
    refused(DependencyError, r"geosurf\[crs\]", gs.reproject, grid(world), OTHER)


def test_law_all_forms_are_converted_alike_and_back(world):
    pyproj = pytest.importorskip("pyproj", reason="pyproj is not installed (extra crs)")
    top = grid(world)
    x, y = np.meshgrid(top.easting, top.northing)
    made = gs.reproject(top, OTHER)
    new = pyproj.Transformer.from_crs(CRS, OTHER, always_xy=True).transform(x, y)
    assert np.hypot(made.easting - new[0], made.northing - new[1]).max() < 2.0  # of any operation
    assert np.array_equal(made.values, top.values)
    assert gs.triangulate_horizon(made, name="Top").crs == made.attrs["crs"] == OTHER

    # one operation for grids, points, meshes and sticks
    points = np.stack([made.easting, made.northing, made], axis=-1).reshape(-1, 3)
    as_mesh = gs.reproject(gs.triangulate_horizon(top, name="Top"), OTHER)
    assert np.array_equal(np.unique(as_mesh.vertices, axis=0), np.unique(points, axis=0))
    names = dict(zip(("easting", "northing", "elevation"), (x, y, top.values), strict=True))
    table = xr.Dataset({key: ("point", part.ravel()) for key, part in names.items()})
    table = gs.reproject(table, OTHER, source=CRS)
    assert np.array_equal(table.easting, points[:, 0])
    fault = gs.FaultSticks("F", np.stack([x, y, top.values], axis=-1))
    fault = gs.reproject(fault, OTHER, source=CRS)
    assert np.array_equal(np.concatenate(fault.sticks), points)
    back = gs.reproject(fault, CRS)
    assert np.abs(np.concatenate(back.sticks)[:, 0] - x.ravel()).max() < 0.01


@pytest.mark.parametrize("crs", ["EPSG:4326", "EPSG:2276", "EPSG:99999", "somewhere"])
def test_other_targets_are_refused(world, crs):
    pytest.importorskip("pyproj", reason="pyproj is not installed (extra crs)")
    refused(InputError, r"projected in metres|Give EPSG codes", gs.reproject, grid(world), crs)
