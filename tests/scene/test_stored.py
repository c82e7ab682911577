"""Horizons in a store: read into memory; what does not fit is read in bands or in the area."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import HorizonError
from geosurf.triangulate import decimate
from geosurf.triangulate import grids as grids_room
from tests.messages import refused
from tests.scene.conftest import FAULT, waves

pytest.importorskip("dask")
pytest.importorskip("zarr")

BOX = (10, 190, 10, 190, -300, 0)


@pytest.fixture(autouse=True)
def _small(monkeypatch):
    monkeypatch.setattr(grids_room, "BAND", 700)
    monkeypatch.setattr(decimate, "LEAST_NODES", 100)


@pytest.fixture
def full(monkeypatch):
    """Memory holds 60 000 bytes, which is 3750 nodes."""
    monkeypatch.setattr(grids_room, "free_memory", lambda: 60_000)


def grid_of(z, chunks=None, way=(1, 1)):
    axes = {
        "northing": np.linspace(0.0, 200.0, len(z))[:: way[0]],
        "easting": np.linspace(0, 200, len(z[0]))[:: way[1]],
    }
    attrs = {"units": "m", "positive": "down"}
    made = xr.DataArray(-z[:: way[0], :: way[1]], axes, ("northing", "easting"), attrs=attrs)
    return made if chunks is None else made.chunk(dict(zip(made.dims, chunks, strict=True)))


@pytest.mark.parametrize("rotated", [False, True])
@pytest.mark.parametrize("lazy", ["dask", "zarr"])
def test_law_what_fits_is_read_as_if_it_had_been_in_memory(tmp_path, lazy, rotated):
    grid = grid_of(waves(-100.0, 41), way=(-1, 1))
    if rotated:
        east, north = np.meshgrid(np.arange(41) * 5.0, np.arange(41) * 5.0)
        at = {"easting": (("j", "i"), east - north), "northing": (("j", "i"), east + north)}
        grid = xr.DataArray(grid.values, dims=("j", "i"), coords=at, attrs=grid.attrs)
    opened = grid.chunk(7)
    if lazy == "zarr":
        opened.rename("Top").to_dataset().to_zarr(tmp_path / "top.zarr", consolidated=False)
        opened = xr.open_zarr(tmp_path / "top.zarr", consolidated=False, chunks=None).Top
    assert grids_room.is_stored(opened)
    assert not grids_room.is_stored(grid)
    one, two = (gs.triangulate_horizon(of, name="Top") for of in (grid, opened))
    assert grids_room.is_stored(opened)  # the array of the user is as it was
    assert one.vertices.tobytes() == two.vertices.tobytes()
    assert one.triangles.tobytes() == two.triangles.tobytes()
    scenes = [gs.Scene({"Top": of}) for of in (grid, opened)]
    assert scenes[0].volumes.identical(scenes[1].volumes)


@pytest.mark.parametrize("tolerance", [0.2, 1.5])
def test_law_a_tolerance_keeps_the_nodes_that_it_keeps_in_memory(tolerance, full):
    grids = {"Top": waves(-100.0, 101), "Base": waves(-130.0, 101, phase=0.3)}
    given = {name: grid_of(z) for name, z in grids.items()}
    one = gs.Scene(given, {"F1": FAULT}, BOX, tolerance=tolerance)
    assert one.surface("Top").lattice.shape[0] < 101
    for way in ((1, 1), (-1, 1)):
        opened = {name: grid_of(z, (30, 40), way) for name, z in grids.items()}
        two = gs.Scene(opened, {"F1": FAULT}, BOX, tolerance=tolerance)
        assert one.units.table.identical(two.units.table)
        for name in one.units:
            np.testing.assert_array_equal(one.units[name].vertices, two.units[name].vertices)
            np.testing.assert_array_equal(one.units[name].triangles, two.units[name].triangles)
        for name in grids:
            for key, values in one.surface(name).vertex_data.items():
                assert two.surface(name).vertex_data[key].tobytes() == values.tobytes()
        assert two.volume_error_bound == one.volume_error_bound > 0.0


def test_what_does_not_fit_is_an_error_with_both_remedies(full):
    opened = grid_of(waves(-100.0, 101), (30, 40))
    words = (
        r"'Top': a grid of 101 x 101 nodes .* 163216 bytes are needed, 60000 are free\. "
        r"Give tolerance=1\.0 .*, or aoi="
    )
    refused(HorizonError, words, gs.triangulate_horizon, opened, name="Top")
    refused(HorizonError, words, lambda: gs.Scene({"Top": opened}).volumes)
    with pytest.raises(HorizonError, match="does not fit into memory"):
        _ = gs.Scene({"Top": opened}, {"F1": FAULT}, BOX, tear=True).volumes
    top = gs.triangulate_horizon(opened, name="Top", tolerance=1.5)
    assert top.lattice.shape[0] < 51
    assert len(gs.Scene({"Top": top}, {"F1": FAULT}, BOX, tear=True).units) == 4


@pytest.mark.parametrize("rotated", [False, True])
def test_of_an_area_only_its_part_is_read(full, rotated, monkeypatch):
    grid = grid_of(waves(-100.0, 101))
    area = np.array([[40.0, 52.0], [83.0, 47.0], [61.0, 97.0]])
    if rotated:
        east, north = np.meshgrid(np.arange(101) * 2.0, np.arange(101) * 2.0)
        at = {"easting": (("j", "i"), east - north), "northing": (("j", "i"), east + north)}
        grid = xr.DataArray(grid.values, dims=("j", "i"), coords=at, attrs=grid.attrs)
        area = area @ np.array([[1.0, 1.0], [-1.0, 1.0]])
        monkeypatch.setattr(grids_room, "free_memory", lambda: 400_000)
    (west, south), (east, north) = area.min(axis=0), area.max(axis=0)
    box = west, east, south, north, -300.0, 0.0
    for how in ({"aoi": area}, {}):
        one, two = (gs.Scene({"Top": of}, box=box, **how) for of in (grid, grid.chunk(20)))
        assert two.surface("Top").lattice.n_node < 0.6 * grid.size
        np.testing.assert_allclose(one.volumes.values, two.volumes.values, rtol=1e-12)
    with pytest.raises(HorizonError, match="no node of its grid is in the area"):
        _ = gs.Scene({"Top": grid.chunk(20)}, aoi=area + 1e4).volumes


def test_files_of_large_grids_keep_the_same_nodes(tmp_path, full, monkeypatch):
    from geosurf.read import netcdf

    monkeypatch.setattr(netcdf, "LARGE", 1000)
    grids = {"Top": waves(-100.0, 101), "Base": waves(-130.0, 101, phase=0.3)}
    data = xr.Dataset({name: grid_of(z, (30, 40)) for name, z in grids.items()})
    for name in grids:
        data[[name]].to_zarr(tmp_path / f"{name}.zarr", consolidated=False)
    paths = {name: tmp_path / f"{name}.zarr" for name in grids}
    in_memory = {name: grid_of(z) for name, z in grids.items()}
    one, two = (gs.Scene(of, {"F1": FAULT}, BOX, tolerance=0.2) for of in (in_memory, paths))
    assert one.units.table.identical(two.units.table)
    for name in grids:
        assert one.surface(name).vertices.tobytes() == two.surface(name).vertices.tobytes()
