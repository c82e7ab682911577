"""Zarr stores, and large grids that are opened and not read: the values of grids in memory."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.cli import main
from geosurf.errors import FormatError, InputError
from geosurf.read import netcdf
from tests.messages import refused

pytest.importorskip("zarr")
pytest.importorskip("h5netcdf")


@pytest.fixture
def small(monkeypatch):
    """Grids of more than 100 nodes are large."""
    monkeypatch.setattr(netcdf, "LARGE", 100)
    monkeypatch.setattr(netcdf, "PART", 5)


def dataset(kind: str = "f4") -> xr.Dataset:
    """Depths in feet, rows from north to south, with a hole."""
    z = np.round(np.random.default_rng(3).normal(size=(14, 11)) * 30 + 5000)
    values = np.where(np.arange(11) == 4, np.nan, z).astype(kind)
    axes = {"northing": 50.0 * np.arange(14)[::-1], "easting": 25.0 * np.arange(11)}
    attrs = {"units": "ft", "positive": "down"}
    return xr.Dataset({"depth": (("northing", "easting"), values, attrs)}, axes)


def written(tmp_path, suffix: str, **how):
    path = tmp_path / f"top{suffix}"
    if suffix == ".zarr":
        dataset().chunk({"northing": 4, "easting": 6}).to_zarr(path, consolidated=False)
    else:
        dataset().to_netcdf(path, engine="h5netcdf", encoding={"depth": how} if how else None)
    return path


def test_stores_are_read_as_netcdf_files(tmp_path):
    one, two = (gs.read_horizon(written(tmp_path, suffix)) for suffix in (".nc", ".zarr"))
    assert one.drop_attrs().identical(two.drop_attrs())
    assert two.attrs["units"] == "m"
    assert (np.diff(two.northing) > 0).all()
    refused(InputError, "positive", gs.read_horizon, tmp_path / "top.zarr", positive="up")


@pytest.mark.parametrize(
    ("suffix", "how"), [(".zarr", {}), (".nc", {}), (".nc", {"chunksizes": (4, 6), "zlib": True})]
)
def test_law_large_grids_are_opened_only(tmp_path, small, suffix, how, monkeypatch):
    path = written(tmp_path, suffix, **how)
    found = gs.read_horizon(path)
    assert hasattr(found.data, "dask")
    monkeypatch.undo()
    loaded = gs.read_horizon(path)
    assert not hasattr(loaded.data, "dask")
    assert found.compute().identical(loaded)
    opened, whole = (gs.triangulate_horizon(of).lattice for of in (found, loaded))
    assert opened.elevation.tobytes() == whole.elevation.tobytes()


def test_damaged_and_other_folders_are_refused(tmp_path):
    path = written(tmp_path, ".zarr")
    (path / "depth" / "zarr.json").write_text("{")
    refused(FormatError, "zarr cannot read it", gs.read_horizon, path)
    (tmp_path / "other.zarr").mkdir()
    refused(InputError, "this is a folder", gs.read_horizon, tmp_path / "other.zarr")


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
def test_of_several_variables_the_name_selects_one(tmp_path, suffix, capsys):
    path, two = tmp_path / f"field{suffix}", dataset().assign(Base=lambda d: d.depth + 100.0)
    two.Base.attrs = two.depth.attrs
    two.to_zarr(path, consolidated=False) if suffix == ".zarr" else two.to_netcdf(
        path, engine="h5netcdf"
    )
    for how in ({}, {"name": "Top"}):
        with pytest.raises(FormatError, match=r"'depth', 'Base'\]|'Base', 'depth'\]") as error:
            gs.read_horizon(path, **how)
        assert "name=; geosurf convert takes --name" in str(error.value)
    base = gs.read_horizon(path, name="Base")
    assert base.identical(gs.read_horizon(path, name="Base", variable="Base"))
    assert float((gs.read_horizon(path, name="depth") - base).max()) == pytest.approx(30.48)

    # the way of the command line, as the message has it
    assert main(["convert", str(path), str(tmp_path / "base.gri"), "--name", "Base"]) == 0
    one = gs.read_horizon(tmp_path / "base.gri", positive="up", length_unit="m")
    np.testing.assert_allclose(one.values, base.values, atol=1e-3)


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
@pytest.mark.parametrize("form", ["chunks", "whole"])
def test_a_small_file_that_announces_many_nodes_is_refused_at_once(tmp_path, suffix, form):
    """Reading the fill value of 200 000 x 200 000 nodes would take hours."""
    import h5py
    import zarr

    n, path = 200_000, tmp_path / f"top{suffix}"
    axis = np.arange(n) * 10.0
    if suffix == ".zarr":
        xr.Dataset(coords={"northing": axis, "easting": axis}).to_zarr(path, consolidated=False)
        zarr.open_group(path).create_array(
            "z", shape=(n, n), chunks=(1000, 1000 if form == "chunks" else n), dtype="f4",
            fill_value=-1000.0, dimension_names=("northing", "easting"),
            attributes={"units": "m", "positive": "up"},
        )  # fmt: skip
    else:
        with h5py.File(path, "w") as file:
            how = {"chunks": (1000, 1000)} if form == "chunks" else {}
            z = file.create_dataset("z", shape=(n, n), dtype="f4", fillvalue=-1000.0, **how)
            for k, key in enumerate(("northing", "easting")):
                file.create_dataset(key, data=axis, compression="gzip").make_scale(key)
                z.dims[k].attach_scale(file[key])
            z.attrs["units"], z.attrs["positive"] = "m", "up"
    with pytest.raises(FormatError, match=r"'z' announces 200000 x 200000 values, but only 0 of"):
        gs.read_horizon(path)
    assert "Check that the file is complete" in gs.info(path).doubts[0]


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
def test_law_large_rotated_grids_are_opened_only(tmp_path, small, suffix, monkeypatch):
    i, j = np.indices((14, 11)).astype(np.float64)
    x, y = 460e3 + 20.0 * j - 7.0 * i, 5930e3 + 8.0 * j + 21.0 * i
    places = {key: (("row", "column"), of, {"units": "m"}) for key, of in (("x", x), ("y", y))}
    attrs = {"units": "m", "positive": "up"}
    grid = xr.Dataset({"depth": (("row", "column"), np.sin(i * j), attrs)}, coords=places)
    path = tmp_path / f"top{suffix}"
    if suffix == ".zarr":
        grid.chunk({"row": 4, "column": 6}).to_zarr(path, consolidated=False)
    else:
        grid.to_netcdf(path, engine="h5netcdf")
    found = gs.read_horizon(path)
    assert all(hasattr(of.data, "dask") for of in (found, found.easting, found.northing))
    monkeypatch.undo()
    loaded = gs.read_horizon(path)
    assert found.compute().identical(loaded)
    opened, whole = (gs.triangulate_horizon(of).lattice for of in (found, loaded))
    nodes = np.arange(14 * 11)
    assert opened.places_of_nodes(nodes).tobytes() == whole.places_of_nodes(nodes).tobytes()
    assert opened.rising == whole.rising
