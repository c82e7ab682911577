"""Points, polygons and sticks with attributes, as RMS and Petrel write them."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import FormatError, InputError
from geosurf.read.registry import SIGNATURES

RMS = 'Float dip\nString "fault"\nDiscrete n\n1 2 30 5.5 "F 1" 7\n3 4 50 UNDEF F2 8\n'
PETREL = (
    "# Petrel Points with attributes\n# Unit in X and Y direction: m\n# Unit in depth: ft\n"
    'VERSION 1\nBEGIN HEADER\nX\nY\nZ\nFLOAT,dip\nSTRING "fault"\nINT   n\nEND HEADER\n'
    '1 2 30 5.5 "F 1" 7\n3 4 50 UNDEF F2 8\n'
)
LINES = (
    "String fault\n1 2 30 F1\n1 2 40 F1\n999 999 999\n3 4 30 F1\n3 4 50 F1\n999.0 999.0 999.0 F1\n"
    "5 6 30 F2\n5 6 70 F2\n999 999 999\n"
)
NUMBERED = "Discrete STICK_ID\nString name\n1 2 30 0 F1\n1 2 40 0 F1\n3 4 30 0 F2\n3 4 50 0 F2\n"


def written(tmp_path, text, name="a.txt"):
    (tmp_path / name).write_text(text)
    return tmp_path / name


@pytest.mark.parametrize(("text", "scale"), [(RMS, 1.0), (PETREL, 0.3048)])
def test_points_keep_their_attributes(tmp_path, text, scale):
    path = written(tmp_path, text)
    points = gs.read_points(path, positive="down")
    assert points.elevation.values.tolist() == [-30 * scale, -50 * scale]
    assert points.fault.values.tolist() == ["F 1", "F2"]
    np.testing.assert_array_equal(points.dip.values, [5.5, np.nan])
    assert points.n.values.tolist() == [7, 8]
    found = gs.info(path)
    assert (found.format, found.read_with, found.count) == ("attributes", "read_points", 2)
    assert found.notes["attributes"] == "dip, fault, n"
    assert sum(fits(text.encode()) for fits in SIGNATURES.values()) == 1
    with pytest.raises(InputError, match="positive='down'"):
        gs.read_points(path)


def test_lines_between_end_marks_and_by_number_are_sticks_of_faults(tmp_path):
    path = written(tmp_path, LINES)
    fault = gs.read_fault(path, name="F1", positive="down")
    assert [stick[:, 2].tolist() for stick in fault.sticks] == [[-30, -40], [-30, -50]]
    assert len(gs.read_polygons(path, positive="down")) == 3
    (line,) = gs.read_polygons(path, positive="up", name="F2")
    assert line.tolist() == [[5, 6, 30], [5, 6, 70]]
    with pytest.raises(InputError, match=r"has 2 faults: F1, F2\."):
        gs.read_fault(path, positive="down")
    found = gs.info(path)
    assert (found.read_with, found.count) == ("read_polygons or read_fault", 6)
    assert gs.read_fault(written(tmp_path, NUMBERED), name="F2", positive="up").name == "F2"


DAMAGES = {
    "width": (RMS + "5 6 7 8\n", r"line 6: found 4 values, expected 6"),
    "word": (RMS.replace("30", "3o"), "line 4: found 'UNDEF'|line 4: found '3o'"),
    "comma": (RMS.replace("30 5.5", "30,5 5.5"), "line 4: found '30,5'"),
    "empty": ("Float dip\n", "no points below its header"),
    "no end": (PETREL.replace("END HEADER\n", ""), "BEGIN HEADER has no END HEADER"),
    "no z": (PETREL.replace("\nZ\n", "\nH\n"), "found 0 columns for z"),
}


@pytest.mark.parametrize("case", DAMAGES)
def test_damaged_attributes_get_one_sentence(tmp_path, case):
    text, message = DAMAGES[case]
    with pytest.raises(FormatError, match=message):
        gs.read_points(written(tmp_path, text), positive="up", format="attributes")


def test_what_xtgeo_writes_comes_back(tmp_path):
    xtgeo = pytest.importorskip("xtgeo", reason="xtgeo is not installed")
    pandas = pytest.importorskip("pandas")
    columns = {"X_UTME": [1.5, 2], "Y_UTMN": [3, 4.25], "Z_TVDSS": [5.0, 6], "fault": ["A B", "C"]}
    made = xtgeo.Points(values=pandas.DataFrame(columns), attributes={"fault": "str"})
    made.to_file(tmp_path / "p.rmsattr", fformat="rms_attr")
    back = gs.read_points(tmp_path / "p.rmsattr", positive="up")
    assert back.easting.values.tolist() == [1.5, 2]
    assert back.fault.values.tolist() == ["A B", "C"]
