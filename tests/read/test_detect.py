"""Files are read by their content: gridded formats node by node, damaged ones as one sentence."""

from __future__ import annotations

import itertools
import struct

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import FormatError, InputError
from geosurf.read.registry import SIGNATURES, detect, head_of

# one map in all formats: 3 columns x 2 rows, steps 10 and 20, from (500, 1000); one undefined node
Z = np.array([[1.25, 2.5, 3.0], [4.0, np.nan, 6.125]])


def words(values, null):
    return " ".join(repr(float(v)) if np.isfinite(v) else null for v in np.ravel(values)) + "\n"


def surfer_7(**changed):
    head = {"nrow": 2, "ncol": 3, "turn": 0.0, "size": 48} | changed
    grid = struct.pack(
        "<2i8d", head["nrow"], head["ncol"], 500, 1000, 10, 20, 0, 9, head["turn"], 1.70141e38
    )
    data = np.nan_to_num(Z, nan=1.70141e38).astype("<f8").tobytes()
    parts = ((b"DSRB", struct.pack("<i", 2)), (b"GRID", grid))
    packed = b"".join(tag + struct.pack("<i", len(body)) + body for tag, body in parts)
    return packed + b"DATA" + struct.pack("<i", head["size"]) + data


def surfer_6():
    head = struct.pack("<4s2h6d", b"DSBB", 3, 2, 500, 520, 1000, 1020, 0, 9)
    return head + np.nan_to_num(Z, nan=1.70141e38).astype("<f4").tobytes()


COLUMNS = Z[::-1].T  # from the north, column by column
GXF = (
    "#TITLE\nA map\n#POINTS\n3\n#ROWS\n2\n#PTSEPARATION\n10\n#RWSEPARATION\n20\n#XORIGIN\n500\n"
    "#YORIGIN\n1000\n#DUMMY\n-1e12\n{more}#GRID\n"
)
EARTHVISION = (
    "# Type: scattered data\n# Field: 1 x\n# Field: 2 y\n# Field: 3 z meters\n# Field: 4 column\n"
    "# Field: 5 row\n# Grid_size: 3 x 2\n# Grid_space: 500,520,1000,1020\n# End:\n"
) + "".join(
    f"{500 + 10 * j} {1000 + 20 * i} {float(Z[i, j])!r} {j + 1} {i + 1}\n"
    for i, j in itertools.product(range(2), range(3))
    if np.isfinite(Z[i, j])
)
STORM = "STORMGRID_{}\n\n3 2 10.0 20.0\n500 520 1000 1020\n"
CPS3 = "FSASCI 0 1 COMPUTED 0 1.0E30 0\nFSATTR 0 0\nFSLIMI 500 520 1000 1020 1 7\nFSNROW 2 3\n"
ESRI = "ncols 3\nnrows 2\nxllcenter 500\nyllcenter 1000\ndx 10\ndy 20\nNODATA_value -99\n"
FILES = {
    "irap": "-996 2 10 20\n500 520 1000 1020\n3 0 500 1000\n0 0 0 0 0 0 0\n"
    + words(Z, "9999900.0"),
    "zmap": "! map\n@top, GRID, 3\n15, -99, , 4, 1\n2, 3, 500, 520, 1000, 1020\n0, 0, 0\n@\n"
    + words(COLUMNS, "-99"),
    "cps3": CPS3 + "FSXINC 10 20\n-> MODEL\n" + words(COLUMNS, "0.1E31"),
    "surfer text": "DSAA\n3 2\n500 520\n1000 1020\n1 7\n" + words(Z, "1.70141e38"),
    "surfer 6": surfer_6(),
    "surfer 7": surfer_7(),
    "storm text": STORM.format("ASCII") + words(Z, "-999"),
    "storm": STORM.format("BINARY").encode() + np.nan_to_num(Z, nan=-999.0).astype(">f8").tobytes(),
    "esri": ESRI + words(Z[::-1], "-99"),
    "gxf": GXF.format(more="") + words(Z, "-1e12"),
    "gxf north": GXF.format(more="#SENSE\n-2\n") + words(Z[::-1], "-1e12"),
    "earthvision": EARTHVISION,
}


def written(tmp_path, content, name="map.bin"):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@pytest.mark.parametrize("kind", FILES)
def test_every_grid_is_read_by_content_under_any_suffix(tmp_path, kind):
    for name in ("map", "map.txt", "map.gri"):
        path = written(tmp_path, FILES[kind], name)
        assert detect(path) == kind.split()[0]
        top = gs.read_horizon(path, positive="up")
        np.testing.assert_array_equal(top.values, Z)
        assert top.easting.values.tolist() == [500, 510, 520]
        assert top.northing.values.tolist() == [1000, 1020]


def test_law_signatures_exclude_each_other(tmp_path):
    for content in FILES.values():
        head = head_of(written(tmp_path, content))
        assert sum(fits(head) for fits in SIGNATURES.values()) == 1


def test_gxf_is_rotated_transformed_and_scaled(tmp_path):
    more = '#ROTATION\n90\n#TRANSFORM\n2,1\n#UNIT_LENGTH\n"ftUS",0.5\n'
    top = gs.read_horizon(
        written(tmp_path, GXF.format(more=more) + words(Z, "-1e12")), positive="up"
    )
    np.testing.assert_array_equal(top.values, 2 * Z + 1)
    # 10 units of half a metre along rows that run north, 20 across, which run west
    assert (top.easting.values[0, 2], top.northing.values[0, 2]) == (250, 510)
    assert (top.easting.values[1, 0], top.northing.values[1, 0]) == (240, 500)


def test_esri_corners_are_those_of_cells(tmp_path):
    text = ESRI.replace("center", "corner") + words(Z[::-1], "-99")
    top = gs.read_horizon(written(tmp_path, text), positive="up")
    assert (top.easting.values[0], top.northing.values[0]) == (505, 1010)


HOSTILE = {
    "cps3 rows": (CPS3.replace("FSNROW 2", "FSNROW 9") + "->\n1 2\n", "2 values, expected 27"),
    "cps3 step": (FILES["cps3"].replace("FSXINC 10", "FSXINC 90"), "line 5: the step in x is 90"),
    "cps3 along rows": (CPS3 + "-> M\n1 2 3\n4 5 6\n", "begins after every 3 values, so they run"),
    "surfer size": (surfer_7(size=10**9), "section b'DATA' announces 1000000000 bytes"),
    "surfer turn": (surfer_7(turn=30.0), "rotated by 30 degrees"),
    "storm cut": (FILES["storm"][:-3], "found 5.625 values, expected 6"),
    "storm step": (FILES["storm text"].replace("3 2 10.0", "3 2 70.0"), "the step in x is 70"),
    "gxf sense": (GXF.format(more="#SENSE\n-1\n") + "1\n", "#SENSE is -1, expected 1 or -2"),
    "gxf packed": (GXF.format(more="#GTYPE\n3\n") + "!!!\n", "compressed.*#GTYPE 0"),
    "ev place": (EARTHVISION.replace("510 1000", "515 1000"), r"lies at \(515, 1000\), 5 m from"),
    "ev twice": (EARTHVISION + "500 1000 1 1 1\n", "1 nodes occur twice"),
    "ev fields": (EARTHVISION.replace("4 column", "4 dip"), "expected x, y, z, column, row"),
}  # fmt: skip


@pytest.mark.parametrize("case", HOSTILE)
def test_damaged_grids_get_one_sentence_each(tmp_path, case):
    content, message = HOSTILE[case]
    with pytest.raises(FormatError, match=message):
        gs.read_horizon(written(tmp_path, content), positive="up")


def test_a_file_of_another_kind_names_the_function_that_reads_it(tmp_path):
    path = written(tmp_path, FILES["irap"], "top.poi")
    with pytest.raises(FormatError, match=r"is a file of the format 'irap'.*with read_horizon"):
        gs.read_points(path, positive="up")
    for content in ("GOCAD Model3d 1\n", b"\x1f\x8b\b", b"PK\3\4"):
        with pytest.raises(
            FormatError, match=r"this is a (GOCAD Model3d|file of the kind (gzip|ZIP))"
        ):
            gs.read_horizon(written(tmp_path, content), positive="up")
    with pytest.raises(InputError, match="positive="):
        gs.read_horizon(written(tmp_path, FILES["cps3"]))


def seismic(turn):
    """Inline, crossline, x, y, z of 5 x 4 nodes; one is absent; shuffled."""
    cos, sin = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    rows = []
    for i, j in itertools.product(range(5), range(4)):
        x, y = 25 * i * cos - 12.5 * j * sin, 25 * i * sin + 12.5 * j * cos
        if (i, j) != (2, 1):
            place = np.round((461000 + x, 5932000 + y), 2)
            rows.append((100 + 2 * i, 900 + 3 * j, *place, 10 * i + j))
    return [rows[k] for k in np.random.default_rng(1).permutation(len(rows))]


@pytest.mark.parametrize(
    "line", ["{} {} {} {} {}", "INLINE : {} XLINE : {} {} {} {}", "{}\t{}\t{}\t{}\t{}"]
)
@pytest.mark.parametrize("turn", [0, 30, 200])
def test_seismic_grids_keep_every_node(tmp_path, line, turn):
    rows = seismic(turn)
    text = "# made by\nI J X Y Z\n" + "\n".join(line.format(*map(float, row)) for row in rows)
    for name in ("top", "top.dat"):
        top = gs.read_horizon(
            written(tmp_path, text.replace(".0 9", " 9") + "\n", name), positive="up"
        )
        x, y = top.easting.values, top.northing.values
        if turn == 0:
            assert top.dims == ("northing", "easting")
            x, y = np.meshgrid(x, y)
        present = np.isfinite(top.values)
        found = set(zip(x[present], y[present], top.values[present], strict=True))
        assert found == {tuple(map(float, row[2:])) for row in rows}
        assert top.shape == (4, 5)
        assert gs.Lattice(x, y, top.values).right_handed
    assert gs.info(tmp_path / "top.dat").format == "ijxyz"


def test_five_columns_that_are_no_seismic_grid_are_refused(tmp_path):
    rows = [list(map(float, row)) for row in seismic(30)]
    rows[7][2] += 3.0
    for change, message in (
        (rows, r"m from the place that its two line numbers give.*columns=\(3, 4, 5\)"),
        (seismic(30) + seismic(30)[:2], "2 nodes occur more than once.*tear_horizon"),
        ([row for row in seismic(30) if row[0] == 100], "all nodes lie on one line"),
    ):
        text = "".join(" ".join(map(str, map(float, row))) + "\n" for row in change)
        with pytest.raises(FormatError, match=message):
            gs.read_horizon(written(tmp_path, text, "top.dat"), positive="up")
    with pytest.raises(FormatError, match=r"give their columns|Give their columns"):
        gs.read_points(tmp_path / "top.dat", positive="up")
