"""Faults, points and polygons in text: GOCAD TSurf, sticks, xyz, csv."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import FormatError, InputError
from geosurf.model import FaultSticks
from geosurf.read import read_tsurf
from tests.messages import refused

FRAME = """GOCAD_ORIGINAL_COORDINATE_SYSTEM
NAME " some name "
AXIS_NAME "X" "Y" "Z"
AXIS_UNIT "m" "m" {unit}
ZPOSITIVE {direction}
END_ORIGINAL_COORDINATE_SYSTEM
"""
BODY = """TFACE
VRTX 0 0 0 10 CNXYZ
VRTX 7 9 0 20
VRTX 8 9 9 30 CNXYZ
TRGL 0 7 8
TFACE
VRTX 12 0 9 40
ATOM 13 8
TRGL 0 13 12
BSTONE 0
BORDER 14 0 7
END
"""


def tsurf(tmp_path, body=BODY, unit="m", direction="Depth", name="F1", frame=FRAME):
    path = tmp_path / "fault.ts"
    path.write_text(
        f"GOCAD TSurf 1\nHEADER {{\nname: {name}\n*solid*color: 1 0 0 1\n}}\n"
        + frame.format(unit=unit, direction=direction)
        + body
    )
    return path


def test_tsurf_quirks(tmp_path):
    """Ids that start at 0 and skip, two TFACE, an alias, trailing words, depth."""
    fault = gs.read_fault(tsurf(tmp_path))
    assert (fault.name, fault.role) == ("F1", "fault")
    assert fault.vertices.tolist() == [[0, 0, -10], [9, 0, -20], [9, 9, -30], [0, 9, -40]]
    assert fault.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]


def test_tsurf_properties(tmp_path):
    body = (
        'PROPERTIES throw "unit normal"\nNO_DATA_VALUES -99999 -1\nESIZES 1 3\nTFACE\n'
        "PVRTX 1 0 0 0 5 0 0 1 CNXYZ\nPVRTX 2 9 0 0 -99999 1 0 0\nVRTX 3 0 9 0\n"
        "TRGL 1 2 3\nEND\n"
    )
    data = gs.read_fault(tsurf(tmp_path, body)).vertex_data
    np.testing.assert_array_equal(data["throw"], [5, np.nan, np.nan])
    np.testing.assert_array_equal(data["unit normal"][:2], [[0, 0, 1], [1, 0, 0]])
    assert np.isnan(data["unit normal"][2]).all()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"body": BODY.replace("VRTX 7 9 0", "VRTX 7 9 zero")},
         "fault.ts, line 14: found 'zero', expected a number"),
        ({"body": BODY.replace("VRTX 7", "VRTX 0")}, "line 14: vertex id 0 occurs twice.*export"),
        ({"body": BODY.replace("TRGL 0 7 8", "TRGL 0 7 99")},
         "line 16: vertex 99 is used but not defined above"),
        ({"body": BODY.replace("END\n", "")},
         "object that begins on line 1 has no END.*incomplete"),
        ({"body": BODY.replace("END\n", "GOCAD TSurf 1\n")},
         "line 23: a new object begins before the END of .*line 1"),
        ({"direction": "Sideways"}, "line 10: ZPOSITIVE is 'Sideways', expected Elevation"),
        ({"unit": "m m"}, "line 9: AXIS_UNIT has 4 words, expected 3"),
        ({"body": "PROPERTIES a b\nESIZES 1\n" + BODY},
         r"2 PROPERTIES but ESIZES \[1\]; each property needs one"),
        ({"body": "TFACE\nVRTX 1 0 0 0\nEND\n"},
         "surface 'F1', which begins on line 1, has no TRGL"),
    ],
)  # fmt: skip
def test_a_wrong_tsurf_is_named_by_line(tmp_path, given, message):
    refused(FormatError, message, gs.read_fault, tsurf(tmp_path, **given))


def test_a_file_of_points_is_no_tsurf(tmp_path):
    (tmp_path / "p.ts").write_text("GOCAD VSet 1\nVRTX 1 0 0 0\nEND\n")
    words = r"format 'vset'.* Read it with read_points"
    refused(FormatError, words, gs.read_fault, tmp_path / "p.ts")
    refused(FormatError, r"has no GOCAD TSurf", read_tsurf, tmp_path / "p.ts")


def test_several_surfaces_in_one_file(tmp_path):
    one, two = (tsurf(tmp_path, name=name).read_text() for name in ("North", "South"))
    path = tmp_path / "both.ts"
    path.write_text(one + two)
    assert [s.name for s in read_tsurf(path)] == ["North", "South"]
    assert gs.read_fault(path, name="South").name == "South"
    refused(InputError, r"2 surfaces: North, South. Choose one, as in name=", gs.read_fault, path)
    with pytest.raises(InputError, match=r"none is called 'Nort'. Did you mean 'North'.*name="):
        gs.read_fault(path, name="Nort")


STICKS = "0 0 1500\n0 50 1600\n999 999 999\n9 0 1500 x\n9 50 1600\n9 60 1700\n999.0 999.0 999.0\n"


def write(tmp_path, text, name="F1.pol"):
    path = tmp_path / name
    path.write_text(text)
    return path


def test_sticks(tmp_path):
    fault = gs.read_fault(write(tmp_path, STICKS), positive="down")
    assert isinstance(fault, FaultSticks)
    assert [len(stick) for stick in fault.sticks] == [2, 3]
    assert fault.sticks[0].tolist() == [[0, 0, -1500], [0, 50, -1600]]
    feet = gs.read_fault(write(tmp_path, STICKS), positive="down", length_unit="ft")
    assert feet.sticks[0][1].tolist() == [0, 50, -1600 * 0.3048]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("0 50 1600\n999", "999"), r"F1.pol, line 1: stick 0 .* has 1 point, expected at least 2"),
        (("9 50 1600", "9 fifty 1600"), r"line 5: found 'fifty', expected a number"),
        ((STICKS, "999 999 999\n"), r"the file has end marks only"),
    ],
)
def test_wrong_sticks_are_named_by_line(tmp_path, change, message):
    with pytest.raises(FormatError, match=message):
        gs.read_fault(write(tmp_path, STICKS.replace(*change)), positive="down")


def test_sticks_in_csv_are_those_of_the_text(tmp_path):
    """Columns in any order; whichever column tells the sticks apart."""
    text = gs.read_fault(write(tmp_path, STICKS), positive="down")
    for label in ("POLY_ID", "stick_id"):
        rows = [
            f"{k},{z},{y},{x}" for k, s in enumerate(text.sticks) for x, y, z in (s * [1, 1, -1])
        ]
        table = write(tmp_path, "\n".join([f"{label},Z,Y,X", *rows, ""]), "F1.csv")
        found = gs.read_fault(table, positive="down")
        assert found.name == text.name
        for one, two in zip(found.sticks, text.sticks, strict=True):
            np.testing.assert_array_equal(one, two)
    short = write(tmp_path, "X,Y,Z,POLY_ID\n1,2,3,0\n1,3,4,0\n5,6,7,1\n", "F1.csv")
    with pytest.raises(FormatError, match=r"F1.csv, line 4: stick 1 .* has 1 point"):
        gs.read_fault(short, positive="down")


def test_polygons(tmp_path):
    flat = write(tmp_path, "0 0 0\n9 0 0\n999 999 999\n", "a.pol")
    assert gs.read_polygons(flat)[0].tolist() == [[0, 0, 0], [9, 0, 0]]
    refused(InputError, r"F1.pol: polygons: .*positive=", gs.read_polygons, write(tmp_path, STICKS))
    table = write(tmp_path, "X_UTME,Y_UTMN,Z_TVDSS,POLY_ID\n1,2,3,0\n4,5,6,0\n7,8,9,1\n", "a.csv")
    lines = gs.read_polygons(table, positive="down")
    assert [line.tolist() for line in lines] == [[[1, 2, -3], [4, 5, -6]], [[7, 8, -9]]]


@pytest.mark.parametrize("suffix", ["csv", "xyz", "txt"])
def test_a_header_says_which_column_is_which(tmp_path, suffix):
    blank = "," if suffix == "csv" else " "
    body = f"7{blank}30{blank}1{blank}2\n8{blank}40{blank}3{blank}4\n"
    header = blank.join(["well", "Z", "X_UTME", "Northing"])
    points = gs.read_points(write(tmp_path, f"{header}\n{body}", f"a.{suffix}"), positive="down")
    assert points.easting.values.tolist() == [1, 3]
    assert points.northing.values.tolist() == [2, 4]
    assert points.elevation.values.tolist() == [-30, -40]
    header = blank.join(["well", "TVDSS", "X", "Y2"])
    path = write(tmp_path, f"{header}\n{body}", f"b.{suffix}")
    with pytest.raises(FormatError, match=r"line 1: found 0 columns for y in .*columns="):
        gs.read_points(path, positive="down")
    named = gs.read_points(path, positive="down", columns=("x", "Y2", "tvdss"))
    assert named.equals(points)
    with pytest.raises(FormatError, match=r"found 0 columns for z.*expected one of tvd "):
        gs.read_points(path, positive="down", columns=("x", "Y2", "tvd"))
    with pytest.raises(InputError, match=r"columns is 'x'. Give 3 names of the header"):
        gs.read_points(path, positive="down", columns="x")


@pytest.mark.parametrize("order", list(itertools.permutations(range(3))))
@pytest.mark.parametrize("names", [("X", "Y", "Z"), ("Easting", "Northing", "Depth")])
def test_law_names_of_axes_are_their_order(tmp_path, order, names):
    """A surface written with its columns, axis names and units in any order is the same surface."""
    corners = np.array([[0.0, 0, 0], [9, 0, 0], [0, 8, 7]])
    units = ("m", "km", "ft")
    lines = [
        "gocad tsurf 1", "header {", 'NAME: "My Fault"', "}",
        "Gocad_Original_Coordinate_System", 'Name "NAD27 / UTM zone 11N"',
        "axis_name " + " ".join(f'"{names[k]}"' for k in order),
        "Axis_Unit " + " ".join(units[k] for k in order),
        "zpositive ELEVATION", "end_original_coordinate_system", "tface",
        *(f"vrtx {i} " + " ".join(str(p[k]) for k in order) for i, p in enumerate(corners)),
        "trgl 0 01 2", "end",
    ]  # fmt: skip
    path = tmp_path / "F.ts"
    path.write_text("\n".join(lines) + "\n")
    found = gs.read_fault(path)
    assert (found.name, found.crs) == ("My Fault", "NAD27 / UTM zone 11N")
    np.testing.assert_allclose(found.vertices, corners * [1, 1000, 0.3048])


@pytest.mark.parametrize(
    ("system", "crs"),
    [
        ("NAME Default", None),
        ('NAME " gocad Local"\nPROJECTION Unknown\nDATUM Unknown', None),
        ('NAME Default\nPROJECTION "UTM zone 31"\nDATUM ED50', "ED50 / UTM zone 31"),
        ('NAME "EPSG:23031"\nPROJECTION "UTM zone 31"', "EPSG:23031"),
        ('PROJECTION "UTM zone 31"', "UTM zone 31"),
    ],
)
def test_the_coordinate_system_of_gocad_is_kept(tmp_path, system, crs):
    path = tmp_path / "F.ts"
    path.write_text(
        f"GOCAD TSurf 1\nGOCAD_ORIGINAL_COORDINATE_SYSTEM\n{system}\n"
        "END_ORIGINAL_COORDINATE_SYSTEM\nNAME Elsewhere\n"
        "VRTX 1 0 0 0\nVRTX 2 9 0 0\nVRTX 3 0 9 9\nTRGL 1 2 3\nEND\n"
    )
    found = gs.read_fault(path, name="B")
    assert (found.name, found.crs) == ("B", crs)


def test_axes_that_contradict_are_refused(tmp_path):
    body = "VRTX 1 0 0 0\nVRTX 2 9 0 0\nVRTX 3 0 9 9\nTRGL 1 2 3\nEND\n"
    text = "GOCAD TSurf 1\nAXIS_NAME {}\n" + body
    path = tmp_path / "F.ts"
    for names in ("Y U Z", "X X Z", "Z Z Z"):
        path.write_text(text.format(names))
        refused(FormatError, r"F\.ts.*AXIS_NAME is .*Write AXIS_NAME", gs.read_fault, path)
    path.write_text(text.format("X Y Depth"))
    refused(InputError, r"third axis is called 'Depth'.*positive='down'", gs.read_fault, path)
    assert gs.read_fault(path, positive="down").vertices[2].tolist() == [0, 9, -9]
    path.write_text(text.format("U V W"))  # labels that contradict nothing
    assert gs.read_fault(path).vertices[2].tolist() == [0, 9, 9]


@pytest.mark.parametrize(
    "head", ["HEADER {name:F1}", "HEADER {\nname:F1}", "header\n{\nNAME:F1\n}"]
)
def test_braces_of_a_header_stand_anywhere(tmp_path, head):
    path = tmp_path / "A.ts"
    body = "VRTX 1 0 0 0\nVRTX 2 9 0 0\nVRTX 3 0 9 9\nTRGL 1 2 3\nEND\n"
    path.write_text(f"GOCAD TSurf 1\n{head}\n{body}")
    assert gs.read_fault(path).name == "F1"
