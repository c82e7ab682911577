"""Block models as Zarr: equal to the dataset, same bytes, nothing of others replaced, kills."""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest
import xarray as xr
from hypothesis import example, given
from hypothesis import strategies as st

import geosurf as gs
from benchmarks.stress.crash_points import attack
from benchmarks.stress.crash_writers import OTHERS
from geosurf.errors import OutputError
from geosurf.write.text_grids import lines_text, n_fixed, rows_text
from geosurf.write.written import SMALLEST
from tests.folders import bytes_in
from tests.grids import gridded, nodes_of
from tests.messages import refused

pytest.importorskip("zarr", reason="zarr is not installed")
CRS = "EPSG:23031"


@pytest.fixture(scope="module")
def scene():
    world = gs.synthetic.graben(n=7)
    return gs.Scene(world.horizons, world.faults, world.box, crs=CRS)


@pytest.fixture(scope="module")
def blocks(scene):
    return scene.sample(cell=(700, 600, 90), codes=True)


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
    first = bytes_in(tmp_path / "a.zarr")
    gs.write(blocks.isel(elevation=slice(1)), tmp_path / "a.zarr")
    assert bytes_in(tmp_path / "a.zarr") != first
    gs.write(blocks, tmp_path / "a.zarr")
    assert bytes_in(tmp_path) == {f"a.zarr/{name}": data for name, data in first.items()}


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
    before = bytes_in(tmp_path)
    with pytest.raises(OutputError, match=r"a\.zarr exists and is not, or not only, what geosurf"):
        gs.write(blocks.isel(elevation=slice(1)), tmp_path / "a.zarr")
    assert bytes_in(tmp_path) == before


@pytest.mark.skipif(sys.platform == "win32", reason="child processes are forked")
def test_law_killed_at_any_step_the_old_or_the_new_one_is_there(tmp_path):
    from benchmarks.stress.crash_writers import blocks, scenes

    scenes(), blocks(0), blocks(1)
    gs.write(blocks(0), tmp_path / "warm.zarr")
    (case,) = (one for one in OTHERS if one.name == "block model .zarr")
    rows = list(attack(case, tmp_path, every=193))
    assert rows
    assert not [row for row in rows if row[2].startswith("WRONG")]


# ---- Grids in text come back as they were, or are refused in one sentence; losses are measured.
UPRIGHT = (".zmap", ".cps3", ".asc")
STATED = (".nc", ".epc")
ROTATED = (".irapasc", ".gri", *STATED)


def grid(values, rotation=0.0, x=0.0, y=0.0, dx=10.0, dy=20.0, **attrs):
    """A regular grid; unrotated ones have one coordinate for each axis."""
    values = np.array(values, dtype=float)
    row, column = np.indices(values.shape)
    if rotation == 0.0:
        return gridded(values, x + dx * column[0], y + dy * row[:, 0], **attrs)
    quarter = {90.0: (0.0, 1.0), 180.0: (-1.0, 0.0), 270.0: (0.0, -1.0)}
    turn = math.radians(rotation)
    cos, sin = quarter.get(rotation, (math.cos(turn), math.sin(turn)))
    easting = x + dx * column * cos - dy * row * sin
    return gridded(values, easting, y + dx * column * sin + dy * row * cos, **attrs)


def nodes(horizon):
    """Places of all nodes with a value, to the millimetre, and their values."""
    found = nodes_of(horizon).reshape(-1, 3)
    return {(round(a, 3) + 0.0, round(b, 3) + 0.0): z for a, b, z in found if not math.isnan(z)}


def is_turned(horizon):
    """Whether rows or columns lie neither along east nor along north."""
    if horizon.easting.ndim == 1:
        return False
    x, y = horizon.easting.values, horizon.northing.values
    steps = [(x[0, -1] - x[0, 0], y[0, -1] - y[0, 0]), (x[-1, 0] - x[0, 0], y[-1, 0] - y[0, 0])]
    return any(min(abs(dx), abs(dy)) > 1e-6 for dx, dy in steps)


size = st.integers(1, 5)
numbers = st.floats(-9000, 9000).map(lambda x: x + 0.0)
values = st.one_of(st.integers(-3, 3).map(float), numbers, st.just(math.nan))


@st.composite
def lattices(draw):
    """Small grids: lattice values and wide ones, rims without values, one node wide, turned."""
    n_row, n_column = draw(size), draw(size)
    z = draw(st.lists(values, min_size=n_row * n_column, max_size=n_row * n_column))
    z = np.reshape(z, (n_row, n_column))
    if draw(st.booleans()):
        z[:, :1] = math.nan
    turn = draw(st.sampled_from([0.0, 0.0, 90.0, 180.0, 270.0, 30.0, 359.5]))
    x, y = draw(st.sampled_from([(0.0, 0.0), (461500.25, 5926500.1), (-7.5, -1e5)]))
    dx, dy = draw(st.sampled_from([10.0, 12.5, 1 / 3])), draw(st.sampled_from([10.0, 20.0]))
    return grid(z, turn, x, y, dx, dy)


@given(top=lattices(), suffix=st.sampled_from([*UPRIGHT, *ROTATED]))
def test_law_a_grid_comes_back_or_is_refused(tmp_path_factory, top, suffix):
    path = tmp_path_factory.mktemp("grid") / f"a{suffix}"
    narrow = min(top.shape) == 1 and suffix in (".zmap", ".cps3")
    if suffix in UPRIGHT and (narrow or is_turned(top)):
        refused(OutputError, r"Write .irapasc", gs.write, top, path)
        assert not path.exists()
        return
    written = gs.write(top, path)
    back = gs.read_horizon(path, positive=None if suffix in STATED else "up")
    old, new = nodes(top), nodes(back)
    slack = written.largest_difference
    if slack == 0.0 and suffix != ".zmap":
        assert old == new
    slack = max(slack, SMALLEST)  # fields of ZMAP+ have one width: what is less is no loss
    values = np.sort([*old.values()]), np.sort([*new.values()])
    np.testing.assert_allclose(*values, rtol=0, atol=slack)


@pytest.mark.parametrize("suffix", UPRIGHT)
def test_a_rotated_grid_is_never_resampled(tmp_path, suffix):
    with pytest.raises(OutputError, match=r"rotated by 30 degrees.*stores no rotation.*Write .ira"):
        gs.write(grid(np.zeros((2, 3)), 30.0), tmp_path / f"a{suffix}")
    assert not list(tmp_path.iterdir())
    for turn in (90.0, 180.0, 270.0):
        top = grid([[1, 2, math.nan], [4, 5, 6]], turn, 500.0, 700.0)
        (path,) = gs.write(top, tmp_path / f"a{suffix}")
        assert nodes(gs.read_horizon(path, positive="up")) == nodes(top)


def test_null_values_are_none_of_the_values(tmp_path):
    for suffix, null in ((".zmap", -99999.0), (".asc", -9999.0)):
        top = grid([[null, 2], [3, math.nan]])
        (path,) = gs.write(top, tmp_path / f"a{suffix}")
        assert nodes(gs.read_horizon(path, positive="up")) == nodes(top)
    with pytest.raises(OutputError, match=r"1e\+30, which means 'undefined' in CPS-3. Write .nc"):
        gs.write(grid([[1e30, 2], [3, 4]]), tmp_path / "a.cps3")
    with pytest.raises(OutputError, match=r"1e8 or more, which the fields of ZMAP\+ do not hold"):
        gs.write(grid([[1e9, 2], [3, 4]]), tmp_path / "b.zmap")


def test_a_grid_as_points(tmp_path):
    for turn in (0.0, 30.0):
        top = grid([[1.5, math.nan], [1 / 3, -2000.1]], turn, 500.0, 700.0)
        written = gs.write(top, tmp_path / "a.xyz")
        back = gs.read_points(written[0], positive="up")
        known = ~np.isnan(top.values.ravel())
        np.testing.assert_array_equal(back.elevation, top.values.ravel()[known])
        assert {"grid", "undefined", "direction"} <= {one.what for one in written.lost}
        assert "1 of 4 nodes" in " ".join(written.notes)
    refused(OutputError, "has no values", lambda: gs.write(grid([[math.nan]]), tmp_path / "b.xyz"))


doubles = st.floats(allow_infinity=False)


@given(st.lists(doubles, min_size=1))
@example([0.0, -0.0, 5e-324, 1.7976931348623157e308, 0.1, 1700.1, 512.0000000000001])
@example([511.99999999999994, 63.99999999999999, 99999999.99999999, 9999.99999999999])
@example([1 / 3, 10 / 3, 200 / 3, 2000 / 3, 1e6 / 3, 1e7 / 3, 8 - 1e-15, 0.99999999999999989])
def test_law_numbers_come_back_to_the_bit(found):
    text = rows_text([np.array(found), b"\n"])
    back = np.array([float(word) for word in text.split()])
    assert back.tobytes() == np.array([x if x == x else math.nan for x in found]).tobytes()


@given(st.lists(st.floats(-9e7, 9e7), min_size=1), st.integers(12, 24))
def test_law_fields_of_one_width_hold_what_they_say(found, width):
    values = np.array(found)
    n = n_fixed(values, width)
    form = f"%{width}.{n}f".__mod__
    text = lines_text(values[None], 5, b"-99", form=form, between="").decode()
    words = [line[k : k + width] for line in text.split("\n") for k in range(0, len(line), width)]
    assert [len(word) for word in words] == [width] * len(values)
    back = np.array([float(word) for word in words])
    assert (np.abs(back - values) <= 0.5001 * 10.0**-n + np.spacing(np.abs(values))).all()
