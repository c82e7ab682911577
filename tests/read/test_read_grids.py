"""Gridded horizons: IRAP, ZMAP+, NetCDF, GOCAD SGrid; synthetic files and the real ones."""

from __future__ import annotations

import gc
import struct
import sys

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import DependencyError, FormatError, GeosurfWarning, InputError
from tests.grids import nodes_of
from tests.messages import refused

CLASSIC = "-996 2 10 20\n500 520 1000 1020\n3 {rotation} 500 1000\n0 0 0 0 0 0 0\n1 2 3\n4 5 6\n"


def classic(tmp_path, text=CLASSIC, rotation=0, name="top.irap"):
    path = tmp_path / name
    path.write_text(text.format(rotation=rotation))
    return path


def binary(nrow=2, ncol=3, values=(1, 2, 3, 4, 5, 6), yinc=20.0, rotation=0.0):
    records = [
        struct.pack(">ii6f", -996, nrow, 500, 520, 1000, 1020, 10, yinc),
        struct.pack(">i3f", ncol, rotation, 500, 1000),
        struct.pack(">7i", *[0] * 7),
        np.array(values, dtype=">f4").tobytes(),
    ]
    return b"".join(struct.pack(">i", len(r)) + r + struct.pack(">i", len(r)) for r in records)


@pytest.mark.parametrize("yinc", [20, -20])
@pytest.mark.parametrize("rotation", [30, 90, 140, 180, 271.5])
def test_rotated_grid_keeps_every_node_and_is_right_handed(tmp_path, yinc, rotation):
    text = CLASSIC.replace("10 20\n", f"10 {yinc}\n")
    top = gs.read_horizon(classic(tmp_path, text, rotation), positive="up")
    assert top.dims == ("row", "column")
    turn = np.radians(rotation)
    along = np.array([np.cos(turn), np.sin(turn)])
    across = np.array([-np.sin(turn), np.cos(turn)])
    found = {
        z: (x, y)
        for x, y, z in zip(
            top.easting.values.ravel(), top.northing.values.ravel(), top.values.ravel(), strict=True
        )
    }
    for row in range(2):
        for column in range(3):
            node = [500, 1000] + column * 10 * along + row * yinc * across
            np.testing.assert_allclose(found[1 + 3 * row + column], node, atol=1e-9)
    surface = gs.Lattice(top.easting.values, top.northing.values, top.values)
    assert surface.right_handed
    assert top.attrs["yinc"] == 20
    assert (top.attrs["ncol"], top.attrs["nrow"]) == (3, 2)


ZMAP = "! made by hand\n@top, GRID, 3\n 8, -99, , 1, 1,\n 3, 2, 0, 10, 0, 20\n 0, 0, 0\n@\n"
PLAIN = CLASSIC.format(rotation=0)


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("top.irap", PLAIN.replace("2 10 20", "2 x 20"),
         r"top.irap, line 1: found 'x', expected a number \(xinc\)"),
        ("top.irap", PLAIN.replace("2 10 20", "2 0 20"),
         r"header: xinc is 0.0, expected a finite number other than 0"),
        ("top.irap", PLAIN.replace("-996 2 10", "-996 2000000000 10"), r"header is damaged"),
        ("top.irap", PLAIN.replace("4 5 6", "4 five 6"),
         r"line 6: found 'five', expected a number.*Correct"),
        ("top.irap", PLAIN.replace("3 0 500", "3 30 0"),
         r"rotated by 30.0 degrees about \(0.0, 1000.0\).*Set xrot"),
        ("b.gri", binary()[:-1], r"byte 100: found a record length of 24.*truncated.*export"),
        ("b.gri", binary(values=(1, 2, 3, 4, np.nan, 6)),
         r"node \(row 1, column 1\) is nan.*null value"),
        ("b.gri", b"", r"the file is empty \(0 bytes\).*export"),
        ("a.zmap", ZMAP + "1. 2. 3.\n4. x 6.\n", r"line 8: found 'x', expected a number"),
        ("a.zmap", ZMAP + "1 2 3\n4 5 6\n",
         r"line 3: the header announces 1 decimals, but no value"),
        ("a.zmap", "1 2 3\n",
         r"expected a header of at least two lines between two '@', found 0"),
        ("a.zmap", ZMAP.replace(" 3, 2, 0,", " 3, 2,"), r"line 4: found 5 values, expected 6"),
        ("a.zmap", ZMAP.replace(" 3, 2, 0,", " 1, 2, 0,"), r"line 4: 2 columns x 1 rows, expected"),
    ],
)  # fmt: skip
def test_a_wrong_file_is_named_by_line_or_byte(tmp_path, name, data, message):
    (tmp_path / name).write_bytes(data if isinstance(data, bytes) else data.encode())
    refused(FormatError, message, gs.read_horizon, tmp_path / name, positive="up")


def test_unknown_suffix_lists_known_ones_and_format(tmp_path):
    with pytest.raises(FormatError, match=r"'.grj'; it reads .gri.*Did you mean '.gri'.*format="):
        gs.read_horizon(tmp_path / "top.grj", positive="up")
    with pytest.raises(FormatError, match=r"format='iraq' is unknown.*Did you mean 'irap'"):
        gs.read_horizon(tmp_path / "top.grj", format="iraq")


def depth_grid(**attrs):
    return xr.DataArray(
        [[1.0, 2.0], [3.0, np.nan]],
        dims=("y", "x"),
        coords={"y": [20.0, 10.0], "x": [5.0, 6.0]},
        name="depth",
        attrs=attrs,
    )


def stored(tmp_path, data, **kwargs):
    path = tmp_path / "top.nc"
    data.to_netcdf(path, engine="h5netcdf", **kwargs)
    return path


STATED = {"positive": "down", "units": "m"}
TWO = xr.Dataset({"depth": depth_grid(**STATED), "time": 2 * depth_grid(**STATED)})
NETCDF = [
    (depth_grid(), {}, "variable 'depth'.*positive='up'"),
    (depth_grid(), {"positive": "down"},
     "variable 'depth': the length unit is missing.*length_unit='m'"),
    (depth_grid(**STATED), {"positive": "up"},
     "file has positive='down', but the argument is.*'up'"),
    (depth_grid(**STATED), {"length_unit": "ft"},
     "file has the length unit 'm', but length_unit='ft' was given"),
    (TWO, {}, r"2 variables.*\['depth', 'time'\].*variable="),
    (TWO, {"variable": "dept"}, "'dept' is not one of them. Did you mean 'depth'"),
    (depth_grid(**STATED).rename(x="column"), {}, "0 coordinates called one of easting.*Rename"),
    (depth_grid(**STATED).assign_coords(y=[10.0, 10.0]), {},
     "northing is not monotonic: 10.0 follows 10.0.*Sort"),
]  # fmt: skip


@pytest.mark.parametrize(("data", "words", "message"), NETCDF)
def test_netcdf_that_is_open_or_contradicts_is_refused(tmp_path, data, words, message):
    refused(InputError, message, gs.read_horizon, stored(tmp_path, data), **words)


def test_netcdf_that_says_nothing_takes_arguments(tmp_path):
    path = stored(tmp_path, depth_grid())
    assert gs.read_horizon(path, positive="down", length_unit="m").values[1, 0] == -1
    assert gs.read_horizon(stored(tmp_path, TWO), variable="depth").shape == (2, 2)


def test_a_damaged_netcdf_is_told_and_prints_nothing(tmp_path, monkeypatch):
    """Bytes where the head of the root group is: h5netcdf, failing there, prints at its end."""
    printed = []
    monkeypatch.setattr(sys, "unraisablehook", printed.append)
    gc.collect()
    gc.freeze()
    printed.clear()  # what tests before this one left
    gs.write(gs.synthetic.tilted_planes(n=3).horizons["Top"], tmp_path / "top.nc")
    whole, told = (tmp_path / "top.nc").read_bytes(), 0
    for k in range(150, 400, 50):
        damaged = bytearray(whole)
        damaged[k] ^= 0xFF
        (tmp_path / "top.nc").write_bytes(bytes(damaged))
        try:
            gs.read_horizon(tmp_path / "top.nc")
        except FormatError as error:
            told += "The file is damaged, or has parts that are not read" in str(error)
    gc.collect()
    assert told > 2
    assert printed == []


@pytest.mark.parametrize("there", [(), ("h5netcdf",), ("h5py",)])
def test_missing_engine_gives_the_install_line(tmp_path, monkeypatch, there):
    """h5netcdf may be installed without h5py, which it reads with."""
    path = stored(tmp_path, depth_grid(positive="down", units="m"))
    missing = "geosurf.conventions.machine.find_spec"
    monkeypatch.setattr(missing, lambda name: name in there or None)
    refused(DependencyError, r'needs h5.*pip install "geosurf\[io\]"', gs.read_horizon, path)


def test_parametric_fault(tmp_path):
    rows, columns = np.meshgrid([0.0, 1.0], [0.0, 1.0, 2.0], indexing="ij")
    data = xr.Dataset(
        {
            "easting": (("down_dip", "along_strike"), columns),
            "northing": (("down_dip", "along_strike"), rows),
            "depth": (("down_dip", "along_strike"), rows, {"units": "ft", "positive": "down"}),
        }
    )
    fault = gs.read_fault(stored(tmp_path, data.transpose("along_strike", "down_dip")), name="F1")
    assert fault.elevation.dims == ("down_dip", "along_strike")
    assert fault.elevation.values[1].tolist() == [-0.3048] * 3
    assert fault.attrs["long_name"] == "F1"
    with pytest.raises(FormatError, match=r"expected one variable 'elevation'.*read_horizon"):
        gs.read_fault(stored(tmp_path, data.drop_vars("depth")))
    with pytest.raises(FormatError, match=r"found 3 variables .* this is a fault, use read_fault"):
        gs.read_horizon(stored(tmp_path, data))


def test_reek_grid_agrees_with_its_unrotated_twin(shared):
    """The same horizon as IRAP rotated by 140 degrees and as unrotated ZMAP+."""
    rotated = gs.read_horizon(
        shared / "data/reek/horizons_gri/01_topreek_rota.gri", positive="down"
    )
    plain = gs.read_horizon(shared / "data/reek/topreek_nonrota.zmap", positive="down")
    assert rotated.shape == (451, 554)
    assert round(float(np.isnan(rotated).mean()), 3) == 0.284
    assert plain.shape == (209, 205)
    # where in the rotated grid is each node of the plain one?
    a = rotated.attrs
    turn = np.radians(a["rotation"])
    dx = plain.easting.values[None, :] - a["xori"]
    dy = plain.northing.values[:, None] - a["yori"]
    column = np.rint((dx * np.cos(turn) + dy * np.sin(turn)) / a["xinc"]).astype(int)
    row = np.rint((dy * np.cos(turn) - dx * np.sin(turn)) / a["yinc"]).astype(int)
    inside = (column >= 0) & (column < a["ncol"]) & (row >= 0) & (row < a["nrow"])
    near = np.full(plain.shape, np.nan)
    near[inside] = rotated.values[row[inside], column[inside]]
    difference = np.abs(near - plain.values)
    assert np.isfinite(difference).mean() > 0.6
    # nearest node is up to 14 m away: a fraction of a metre on these slopes
    assert np.nanmedian(difference) < 1.0


# ---- GOCAD SGrid of one layer: a header, and its points in a second file.
X, Y = np.meshgrid([461000.0, 461010, 461020], [5932000.0, 5932020])
Z = np.array([[1600.5, 1601, 1602], [1603, 1604.25, 1605]])
POINTS = np.stack([X, Y, Z], axis=-1)
HEAD = (
    "GOCAD SGrid 1 \nHEADER {{\nname: Top\nascii: off\ndouble_precision_binary: {wide}\n}}\n"
    'GOCAD_ORIGINAL_COORDINATE_SYSTEM\nNAME "ED50 / UTM 31N"\nAXIS_NAME "X" "Y" "Z"\n'
    'AXIS_UNIT "m" "m" "m"\nZPOSITIVE Depth\nEND_ORIGINAL_COORDINATE_SYSTEM\nAXIS_N {n}\n'
    "PROP_ALIGNMENT CELLS\nPOINTS_OFFSET 0\nPOINTS_FILE top__points@@\n{more}END\n"
)


def written(tmp_path, data=None, wide="off", n="3 2 1", more="", head=HEAD):
    path = tmp_path / "top.sg"
    path.write_text(head.format(wide=wide, n=n, more=more))
    kind = ">f8" if wide == "on" else ">f4"
    data = POINTS.astype(kind).tobytes() if data is None else data
    (tmp_path / "top__points@@").write_bytes(data)
    return path


@pytest.mark.parametrize("wide", ["off", "on"])
@pytest.mark.parametrize("n", ["3 2 1", "3 1 2", "1 3 2"])
def test_a_layer_is_a_horizon_and_a_fault(tmp_path, wide, n):
    path = written(tmp_path, wide=wide, n=n)
    top = gs.read_horizon(path)
    np.testing.assert_array_equal(top.values, -Z)
    assert top.dims == ("northing", "easting")
    np.testing.assert_array_equal(top.easting.values, X[0])
    np.testing.assert_array_equal(top.northing.values, Y[:, 0])
    assert top.attrs["crs"] == "ED50 / UTM 31N"
    fault = gs.triangulate_fault(gs.read_fault(path))
    assert (fault.name, fault.n_triangle, fault.crs) == ("Top", 4, "ED50 / UTM 31N")
    found = gs.info(path)
    assert (found.format, found.count) == ("sgrid", 6)
    refused(InputError, "positive='up'", gs.read_horizon, path, positive="up")


def test_rows_are_turned_so_that_up_is_up_and_undefined_nodes_are_nan(tmp_path):
    points = POINTS[::-1].copy()
    points[0, 0, 2] = 1e30
    top = gs.read_horizon(written(tmp_path, points.astype(">f8").tobytes(), "on"))
    assert gs.Lattice(top.easting.values, top.northing.values, top.values).right_handed
    assert np.isnan(top.values).sum() == 1
    assert np.nanmax(-top.values) == 1605


def test_points_in_text(tmp_path):
    head = HEAD.replace("POINTS_FILE top__points@@", "ASCII_DATA_FILE top.dat")
    path = written(tmp_path, head=head)
    lines = [f"{x!r} {y!r} {z!r} 0.5 0 0 0\n" for x, y, z in POINTS.reshape(-1, 3).tolist()]
    (tmp_path / "top.dat").write_text("*\n* X Y Z\n" + "".join(lines))
    np.testing.assert_array_equal(gs.read_horizon(path).values, -Z)
    (tmp_path / "top.dat").write_text("".join(lines[1:]))
    refused(FormatError, r"top\.dat: found 5 points, expected 6", gs.read_horizon, path)


def test_flags_that_differ_are_named(tmp_path):
    path = written(tmp_path, more="FLAGS_FILE flags@@\n")
    (tmp_path / "flags@@").write_bytes(np.array([0, 0, 8, 0, 0, 0], ">u4").tobytes())
    with pytest.warns(GeosurfWarning, match=r"'flags@@' marks 1 of 6 nodes of 'top\.sg'"):
        gs.read_horizon(path)
    assert gs.info(path).notes["flags"] == "not used; 1 of 6 nodes differ from the others"


DAMAGES = {
    "layers": ({"n": "3 2 4"}, "has 3 x 2 x 4 nodes, expected one layer"),
    "huge": ({"n": "999999999 999999999 1"}, "expected 999999998000000001"),
    "cut": ({"data": POINTS.astype(">f4").tobytes()[:-2]}, "found 5.83333 points"),
    "nan": ({"data": np.full(18, np.nan, ">f4").tobytes()}, "point 0 is not finite"),
    "undefined": ({"data": np.full(18, 1e30, ">f4").tobytes()}, "all nodes of the SGrid are undef"),
    "elsewhere": ({"head": HEAD.replace("top__", "../top__")}, "expected a file of the same"),
}  # fmt: skip


@pytest.mark.parametrize("case", DAMAGES)
def test_damaged_grids_get_one_sentence(tmp_path, case):
    words, message = DAMAGES[case]
    refused(FormatError, message, lambda: gs.read_horizon(written(tmp_path, **words)))


def test_missing_points_are_named(tmp_path):
    path = written(tmp_path)
    (tmp_path / "top__points@@").unlink()
    refused(InputError, r"top__points@@: cannot be read", gs.read_horizon, path)


# ---- GeoTIFF through rasterio: placed exactly, rotated or not; damaged files in one sentence.
BAND = np.array([[1.25, 2.5, 3.0], [4.0, np.nan, 6.125]], dtype=np.float32)


def made(path, place, values=BAND, **words):
    """A GeoTIFF as rasterio writes it."""
    rasterio = pytest.importorskip("rasterio", reason="rasterio is not installed (extra gis)")
    words = {"crs": "EPSG:32631", "nodata": -999.0, "dtype": values.dtype} | words
    layers = values if values.ndim == 3 else values[None]
    count, height, width = layers.shape
    scale = words.pop("scale", None)
    with rasterio.open(
        path, "w", driver="GTiff", width=width, height=height, count=count,
        transform=rasterio.Affine(*place), **words,
    ) as file:  # fmt: skip
        file.write(np.where(np.isnan(layers), -999.0, layers).astype(values.dtype))
        if scale:
            file.scales, file.offsets, file.units = (scale,), (10.0,), ("ft",)
    return path


@pytest.mark.parametrize("more", [{}, {"compress": "lzw", "predictor": 3, "tiled": True,
                                       "blockxsize": 16, "blockysize": 16}])  # fmt: skip
def test_a_map_lies_at_the_centres_of_its_cells(tmp_path, more):
    path = made(tmp_path / "top", (10, 0, 461000, 0, -20, 5932000), **more)
    top = gs.read_horizon(path, positive="up")
    np.testing.assert_array_equal(top.values, BAND[::-1])
    assert top.easting.values.tolist() == [461005, 461015, 461025]
    assert top.northing.values.tolist() == [5931970, 5931990]
    assert top.attrs["crs"] == "EPSG:32631"
    found = gs.info(path)
    assert (found.format, found.count) == ("geotiff", 5)
    assert (found.notes["null"], found.notes["crs"]) == ("-999", "EPSG:32631")


@pytest.mark.parametrize("flip", [1, -1])
def test_a_rotated_map_keeps_every_node(tmp_path, flip):
    cos, sin = np.cos(np.radians(30)), np.sin(np.radians(30))
    place = (10 * cos, -20 * sin * flip, 461000, 10 * sin, 20 * cos * flip, 5932000)
    top = gs.read_horizon(made(tmp_path / "t.tif", place), positive="down")
    j, i = np.meshgrid(np.arange(3) + 0.5, np.arange(2) + 0.5)
    x = place[0] * j + place[1] * i + place[2]
    y = place[3] * j + place[4] * i + place[5]
    wanted = np.stack([x, y, -BAND], axis=-1)[~np.isnan(BAND)]
    found = nodes_of(top)[~np.isnan(top.values)]
    found = found[np.lexsort(found.T[::-1])]
    assert np.abs(found - wanted[np.lexsort(wanted.T[::-1])]).max() < 1e-6
    assert gs.Lattice(top.easting.values, top.northing.values, top.values).right_handed


def test_scale_offset_and_unit_of_the_band_count(tmp_path):
    path = made(
        tmp_path / "t.tif", (10, 0, 0, 0, -10, 0), np.nan_to_num(BAND * 8).astype("i2"), scale=0.5
    )
    assert gs.read_horizon(path, positive="up").values[1, 0] == (10 * 0.5 + 10) * 0.3048


@pytest.mark.parametrize(
    ("place", "words", "error", "message"),
    [
        ((10, 0, 0, 0, -10, 0), {"values": np.stack([BAND, BAND])}, FormatError, "has 2 bands"),
        ((1, 0, 0, 0, 1, 0), {"crs": None}, FormatError, "states no place"),
        ((10, 5, 0, 0, -10, 0), {}, FormatError, "not at right angles"),
        ((0.1, 0, 2, 0, -0.1, 56), {"crs": "EPSG:4326"}, InputError, "are in degrees"),
        ((10, 0, 0, 0, -10, 0), {"values": np.full((2, 2), np.inf, "f4")}, FormatError, "infinite"),
    ],
)
@pytest.mark.filterwarnings("ignore::Warning")
def test_maps_that_cannot_be_used_get_one_sentence(tmp_path, place, words, error, message):
    path = made(tmp_path / "t.tif", place, **words)
    refused(error, message, gs.read_horizon, path, positive="up")


def test_damaged_files_get_one_sentence(tmp_path):
    path = made(tmp_path / "t.tif", (10, 0, 461000, 0, -20, 5932000))
    whole = path.read_bytes()
    for data in (whole[:150], whole[:9], b"II*\0" + bytes(100), whole[:8] + b"\xff" * 200):
        path.write_bytes(data)
        refused(FormatError, r"t\.tif: ", gs.read_horizon, path, positive="up")


def test_without_rasterio_the_extra_is_named(tmp_path, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "rasterio", None)
    (tmp_path / "t.tif").write_bytes(b"II*\0" + bytes(100))
    with pytest.raises(DependencyError, match=r"GeoTIFF needs rasterio.*geosurf\[gis\]"):
        gs.read_horizon(tmp_path / "t.tif", positive="up")
    assert gs.info(tmp_path / "t.tif").format == "geotiff"
