"""GOCAD SGrid of one layer: a header, and its points in a second file."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import FormatError, GeosurfWarning, InputError

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
    with pytest.raises(InputError, match="positive='up'"):
        gs.read_horizon(path, positive="up")


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
    with pytest.raises(FormatError, match=r"top\.dat: found 5 points, expected 6"):
        gs.read_horizon(path)


def test_flags_that_differ_are_named(tmp_path):
    path = written(tmp_path, more="FLAGS_FILE flags@@\n")
    (tmp_path / "flags@@").write_bytes(np.array([0, 0, 8, 0, 0, 0], ">u4").tobytes())
    with pytest.warns(GeosurfWarning, match=r"'flags@@' marks 1 of 6 nodes of 'top\.sg'"):
        gs.read_horizon(path)
    assert gs.info(path).notes["flags"] == "not used; 1 of 6 nodes differ from the others"


DAMAGES = {
    "layers": ({"n": "3 2 4"}, "has 3 x 2 x 4 nodes, expected one layer"),
    "counts": ({"n": "3 9 1"}, r"top__points@@: found 6 points of 12 bytes, expected 27"),
    "huge": ({"n": "999999999 999999999 1"}, "expected 999999998000000001"),
    "zero": ({"n": "3 0 1"}, "AXIS_N is '3 0 1'"),
    "cut": ({"data": POINTS.astype(">f4").tobytes()[:-2]}, "found 5.83333 points"),
    "nan": ({"data": np.full(18, np.nan, ">f4").tobytes()}, "point 0 is not finite"),
    "undefined": ({"data": np.full(18, 1e30, ">f4").tobytes()}, "all nodes of the SGrid are undef"),
    "elsewhere": ({"head": HEAD.replace("top__", "../top__")}, "expected a file of the same"),
    "no end": ({"head": HEAD.replace("END\n", "\n")}, "has no END"),
    "no points": ({"head": HEAD.replace("POINTS_FILE", "POINTS_FILM")}, "or no file of points"),
}  # fmt: skip


@pytest.mark.parametrize("case", DAMAGES)
def test_damaged_grids_get_one_sentence(tmp_path, case):
    words, message = DAMAGES[case]
    with pytest.raises(FormatError, match=message):
        gs.read_horizon(written(tmp_path, **words))


def test_missing_points_are_named(tmp_path):
    path = written(tmp_path)
    (tmp_path / "top__points@@").unlink()
    with pytest.raises(InputError, match=r"top__points@@: cannot be read"):
        gs.read_horizon(path)
