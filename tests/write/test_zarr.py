"""Block models as Zarr: equal to the dataset, same bytes, nothing of others replaced, kills."""

from __future__ import annotations

import sys

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from benchmarks.stress.crash_points import attack
from benchmarks.stress.crash_writers import OTHERS
from geosurf.errors import OutputError
from geosurf.write import written

pytest.importorskip("zarr", reason="zarr is not installed")
CRS = "EPSG:23031"


@pytest.fixture(scope="module")
def scene():
    world = gs.synthetic.graben(n=7)
    return gs.Scene(world.horizons, world.faults, world.box, crs=CRS)


@pytest.fixture(scope="module")
def blocks(scene):
    return scene.sample(cell=(700, 600, 90), codes=True)


def bytes_of(folder):
    """All files of a folder, hidden ones too."""
    paths = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}


@pytest.mark.parametrize("codes", [False, True])
def test_law_a_block_model_comes_back(scene, tmp_path, codes):
    given = scene.sample(cell=(700, 600, 90), codes=codes, distance=True)
    written = gs.write(given, tmp_path / "a.zarr")
    found = xr.open_zarr(tmp_path / "a.zarr").load()
    assert ([*written], written.lost) == ([tmp_path / "a.zarr"], ())
    assert set(found.variables) == {*given.variables, "spatial_ref"}
    for key, variable in given.variables.items():
        np.testing.assert_array_equal(found[key].values, variable.values)
        assert found[key].dims == variable.dims
        for word, value in variable.attrs.items():
            assert np.array_equal(found[key].attrs[word], value)
        assert found[key].dtype == variable.dtype or not codes
    assert found.attrs.items() >= given.attrs.items()
    assert found.attrs["crs"] == CRS
    assert found.spatial_ref.attrs["epsg_code"] == CRS
    assert found.easting.attrs["units"] == found.elevation.attrs["units"] == "m"


def test_law_the_same_as_netcdf(blocks, tmp_path):
    pytest.importorskip("h5netcdf", reason="h5netcdf is not installed")
    for suffix in (".nc", ".zarr"):
        gs.write(blocks, tmp_path / f"a{suffix}")
    one = xr.open_dataset(tmp_path / "a.nc", engine="h5netcdf").load()
    two = xr.open_zarr(tmp_path / "a.zarr").load()
    xr.testing.assert_equal(one, two)
    for key in one.variables:
        assert {k for k in one[key].attrs if k != "names"} <= set(two[key].attrs)


def test_law_the_same_bytes_each_time_and_nothing_hidden(blocks, tmp_path):
    gs.write(blocks, tmp_path / "a.zarr")
    first = bytes_of(tmp_path / "a.zarr")
    gs.write(blocks.isel(elevation=slice(1)), tmp_path / "a.zarr")
    assert bytes_of(tmp_path / "a.zarr") != first
    gs.write(blocks, tmp_path / "a.zarr")
    assert bytes_of(tmp_path) == {f"a.zarr/{name}": data for name, data in first.items()}


def test_a_system_that_cannot_swap_folders_replaces_it_too(blocks, tmp_path, monkeypatch):
    gs.write(blocks, tmp_path / "b.zarr")
    gs.write(blocks.isel(elevation=slice(1)), tmp_path / "a.zarr")
    monkeypatch.setattr(written, "exchange", lambda one, two: False)
    gs.write(blocks, tmp_path / "a.zarr")
    assert bytes_of(tmp_path / "a.zarr") == bytes_of(tmp_path / "b.zarr")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.zarr", "b.zarr"]


def folder_with_note(place, blocks):
    place.mkdir()
    (place / "note.txt").write_text("mine")


def store_with_note(place, blocks):
    gs.write(blocks, place)
    (place / "unit" / "note.txt").write_text("mine")


def other_store(place, blocks):
    xr.Dataset({"a": ("x", [1.0])}).to_zarr(place, zarr_format=2, consolidated=True)


def other_format(place, blocks):
    blocks.to_zarr(place, zarr_format=3, consolidated=False)


def file_there(place, blocks):
    place.write_text("mine")


def link_to_store(place, blocks):
    gs.write(blocks, place.with_name("b.zarr"))
    place.symlink_to(place.with_name("b.zarr"))


STRANGERS = [folder_with_note, store_with_note, other_store, other_format, file_there,
             link_to_store]  # fmt: skip


@pytest.mark.parametrize("make", STRANGERS, ids=lambda make: make.__name__)
def test_law_what_is_no_block_model_stays(blocks, tmp_path, make):
    make(tmp_path / "a.zarr", blocks)
    before = bytes_of(tmp_path)
    with pytest.raises(OutputError, match=r"a\.zarr exists and is not, or not only, what geosurf"):
        gs.write(blocks.isel(elevation=slice(1)), tmp_path / "a.zarr")
    assert bytes_of(tmp_path) == before


@pytest.mark.skipif(sys.platform == "win32", reason="child processes are forked")
def test_law_killed_at_any_step_the_old_or_the_new_one_is_there(tmp_path):
    from benchmarks.stress.crash_writers import blocks, scenes

    scenes(), blocks(0), blocks(1)
    gs.write(blocks(0), tmp_path / "warm.zarr")
    (case,) = (one for one in OTHERS if one.name == "block model .zarr")
    rows = list(attack(case, tmp_path, every=29))
    assert rows
    assert not [row for row in rows if row[2].startswith("WRONG")]
