"""Files as programs and editors leave them: read as their regular twin, or named by their kind."""

import re

import pytest

import geosurf as gs
from geosurf.errors import FormatError, GeosurfWarning

LAS = """~VERSION INFORMATION
VERS.   2.0 : CWLS LOG ASCII STANDARD
WRAP.    NO : ONE LINE PER STEP
~WELL INFORMATION
NULL. -999.25 : NULL
WELL.  W-1 : WELL
~CURVE INFORMATION
MD   .M : measured depth
X    .M : easting
Y    .M : northing
TVDSS.M : depth
{}~A  MD X Y TVDSS
0.0   461000.0 5931000.0 -25.0
900.0 461150.0 5931060.0 850.0
"""
GXF = """#POINTS
3
#ROWS
2
#PTSEPARATION
25.0
#RWSEPARATION
25.0
#XORIGIN
427391.5
#YORIGIN
7250373.5
#ROTATION
30.0
#DUMMY
9999999.0
#GRID
2100.5 2101.5 2102.5
2103.5 9999999.0 2105.5
"""
ESRI = """ncols 2
nrows 2
xllcorner 0
yllcorner 0
cellsize 10
NODATA_value {0}
1.5 {0}
3.5 4.5
"""
QUOTED = "".join(
    f'"{line}"\n' if line[:1].isdigit() and " " not in line else f"{line}\n"
    for line in GXF.splitlines()
)
POINTS = "461000.0 5930000.0 1700.0\n461100.0 5930000.0 1701.0\n461100.0 5930100.0 1702.0\n"
STICKS = "10 20 1500\n30 20 1600\n999 999 999\n60 20 1500\n80 20 1600\n999 999 999\n"
NODES = "".join(f"{i} {j} {25 * i} {50 * j} {1700 + i + j}\n" for j in range(4) for i in range(5))
TOPS = "Well,Surface,X,Y,Z\nW-1,Top,461000,5931000,-275\n"
RMS = """1.0
Undefined
W-{0} 461000.0 5931000.0 25.0
1
MD UNK lin
461000.0 5931000.0 -25.0 0
461150.0 5931060.0 850.0 900
"""
TWO = "Well,X,Y,Z,MD\n" + "".join(
    f"W-{k},461000,5931000,-25,0\nW-{k},461150,5931060,850,900\n" for k in (1, 2)
)
LOGS = "2\nPHI UNK lin\nMD UNK lin\n461000 5931000 -25 0.3 0\n461150 5931060 850 0.2 900\n"
INSIGHT = "name Well Path A\n373.27\t463.61\t413.5\t0\n389.64\t465.71\t414.22\t162.7\n"
END = "no line end follows"
PETREL = (
    "# Petrel well tops\nVERSION 2\nBEGIN HEADER\nFLOAT,X\nFLOAT,Y\nZ\nSTRING,Surface\nWell\n"
    'FLOAT,Dip angle\nEND HEADER\n461000 5931000 -275 "Top" "W-1" 12.5\n'
)
# reader, regular file and its name, odd file and its name, warning
CASES = {
    "las other": (gs.read_wells, "a.las", LAS.format(""), "a.las",
                  LAS.format("~Other\n3.5 inch tool stuck\n----\n"), None),
    "las o": (gs.read_wells, "a.las", LAS.format(""), "a.las", LAS.format("~O\n1 2\n"), None),
    "gxf quoted": (gs.read_horizon, "a.gxf", GXF, "a.gxf", QUOTED, None),
    "gxf comment": (gs.read_horizon, "a.gxf", GXF, "a.gxf", "Words, 1 2 3\n" * 999 + GXF, None),
    "gxf end": (gs.read_horizon, "a.gxf", GXF, "a.gxf", GXF[:-1], END),
    "ijxyz head": (gs.read_horizon, "a.ijxyz", NODES, "a.ijxyz",
                   "@File_Version: 4\n@Attributes: I J X Y Z\n" + NODES[:-1], END),
    "ijxyz dat": (gs.read_horizon, "a.ijxyz", NODES, "a.dat", "@ 3 words\n" + NODES, None),
    "esri -nan": (gs.read_horizon, "a.asc", ESRI.format(-9999), "a.asc",
                  ESRI.format("-nan").replace("-nan", "nan", 1), None),
    "esri nan": (gs.read_horizon, "a.asc", ESRI.format(-9999), "a.asc", ESRI.format("nan"), None),
    "points 999": (gs.read_points, "a.poi", POINTS, "a.poi", POINTS + "999 999 999\n", None),
    "points end": (gs.read_points, "a.poi", POINTS, "a.poi", POINTS[:-1], END),
    "points bare": (gs.read_points, "a.poi", POINTS, "a", POINTS, None),
    "sticks bare": (gs.read_fault, "a.pol", STICKS, "a", STICKS, None),
    "sticks xyz": (gs.read_fault, "a.pol", STICKS, "a.xyz", STICKS, None),
    "sticks 999": (gs.read_fault, "a.pol", STICKS, "a.pol", STICKS[:-12],
                   "line 5: no line 999 999 999 follows '80 20 1600'"),
    "lines 999": (gs.read_polygons, "a.pol", STICKS[12:], "a.pol", STICKS[12:-12], "line 999"),
    "rms stacked": (gs.read_wells, "a.csv", TWO, "a.rmswell", RMS.format(1) + RMS.format(2), None),
    "rms bodies": (gs.read_wells, "a.csv", TWO, "a.rmswell",
                   RMS.format(1) + "".join(RMS.format(2).splitlines(True)[2:]), None),
    "rms logs": (gs.read_wells, "a.csv", TWO, "a.rmswell",
                 RMS.format(1) + "W-2 461000 5931000\n" + LOGS, None),
    "tops mixed": (gs.read_tops, "a.csv", TOPS, "a.txt", TOPS.replace(",", " ", 4), None),
    "tops other mix": (gs.read_tops, "a.csv", TOPS, "a.txt",
                       TOPS[:19] + TOPS[19:].replace(",", " "), None),
    "tops quoted": (gs.read_tops, "a.csv", TOPS.replace("Top", '"Top, A"'), "a.txt",
                    TOPS.replace(",", " ").replace("Top", '"Top, A"'), None),
    "tops year": (gs.read_tops, "a.csv", TOPS, "a.csv",
                  TOPS.replace("Z\n", "Z,2019\n").replace("275\n", "275,1\n"), None),
    "tops comment": (gs.read_tops, "a.csv", TOPS, "a.txt", "# " + TOPS.replace(",", " "), None),
    "tops titles": (gs.read_tops, "a.csv", TOPS, "a.csv",
                    "Tops of 3 wells;;;\nUnits : m;;\n" + TOPS.replace(",", ";"), None),
    "wells titles": (gs.read_wells, "a.csv", TWO, "a.csv", "An Oil & Gas,,,,\n,,,,\n" + TWO, None),
    "wells tabs": (gs.read_wells, "a.dev", INSIGHT, "a.dev",
                   INSIGHT.replace("A\n", "A\t\t\n"), None),
    "openworks": (gs.read_points, "a.xyz", POINTS, "a.dat",
                  f"@File_Version: 4\n#Type --> X\nA grid of 13:42:10\n{POINTS}EOD\n", None),
    "tops typed": (gs.read_tops, "a.csv", TOPS, "a.txt", PETREL, None),
}  # fmt: skip


def values(found):
    """What a reader returns, in plain lists."""
    if isinstance(found, gs.FaultSticks):
        found = list(found.sticks)
    if isinstance(found, list):
        return [line.tolist() for line in found]
    if hasattr(found, "data_vars"):
        return {key: found[key].values.tolist() for key in found.data_vars}
    return [found.fillna(0).values.tolist()] + [found[a].values.tolist() for a in found.coords]


@pytest.mark.parametrize("case", CASES)
@pytest.mark.filterwarnings("always")
def test_an_odd_file_is_its_regular_twin(tmp_path, recwarn, case):
    read, regular, text, odd, other, warning = CASES[case]
    (tmp_path / "one").mkdir()
    (tmp_path / "one" / regular).write_text(text)
    (tmp_path / odd).write_text(other)
    positive = "up" if read is gs.read_tops else "down"
    expected = values(read(tmp_path / "one" / regular, positive=positive))
    assert not recwarn.list
    assert values(read(tmp_path / odd, positive=positive)) == expected
    assert [one.message.kind for one in recwarn.list] == ["file end"] * (warning is not None)
    assert all(isinstance(one.message, GeosurfWarning) for one in recwarn.list)
    assert all(warning in str(one.message) for one in recwarn.list)


DXF = "0\nSECTION\n2\nENTITIES\n0\nPOLYLINE\n8\nF1\n0\nENDSEC\n0\nEOF\n"
OTHERS = {
    "GOCAD object other than TSurf, Model3d, PLine, VSet and SGrid": "GOCAD Voxet 1\nHEADER {\n",
    "ZMAP+ points or lines": "! RMS\n@FREE POINT , DATA, 80, 1\n X , 1, 1, 1\n@\n 1 2 3 0\n",
    "OpendTect": "dTect V6.4\nPickSet Group\n616522.7 6081982.0 1.78\n",
    "grid of cells": "-- a comment\nSPECGRID\n2 3 4 1 F /\n",
    "XML": '<?xml version="1.0"?>\n<kml>1 2 3\n</kml>\n',
}
IESX = "PROFILE TopA      TYPE 1  4 m ms\n  3 461000.0 5931000.0 1 2 1700.5\nEOD\n"


@pytest.mark.parametrize("suffix", [".dxf", "", ".dat", ".txt"])
@pytest.mark.parametrize(("kind", "text"), [("DXF", DXF), ("IESX", IESX), *OTHERS.items()])
def test_files_of_other_programs_are_named(tmp_path, kind, text, suffix):
    path = tmp_path / f"a{suffix}"
    path.write_text(text)
    said = gs.info(path)
    assert (said.format, "Export" in said.doubts[0]) == (kind, True)
    readers = (gs.read_horizon, gs.read_fault, gs.read_points, gs.read_polygons, gs.read_wells)
    for read in (*readers, gs.read_tops):
        sentence = f"of the kind {kind}, which geosurf does not read. Export"
        with pytest.raises(FormatError, match=re.escape(sentence)):
            read(path, positive="down")


@pytest.mark.parametrize("row", ["461150 5931060 850", "W-2 461150 5931060", "1.0"])
def test_a_row_that_begins_no_well_is_refused_by_line(tmp_path, row):
    path = tmp_path / "a.rmswell"
    path.write_text(RMS.format(1) + row + "\n")
    with pytest.raises(FormatError, match=r"a.rmswell, line 8: found \d values, expected 4"):
        gs.read_wells(path, positive="down")


@pytest.mark.parametrize(
    ("name", "text", "md"),
    [
        ("a.csv", "Well,X,Y,Z\nA,0,0,-75\nA,0,0,-175\n", None),
        ("a.csv", "Well,X,Y,Z,KB\nA,0,0,-75,25\nA,0,0,-175,25\n", [100, 200]),
        ("a.csv", "Well,X,Y,Z,GL,KB\nA,0,0,-75,9,25\nA,0,30,-115,9,25\n", [100, 150]),
        ("a.csv", "Well,X,Y,Z,GL [ft]\nA,0,0,-75,100\nA,0,0,-175,100\n", [105.48, 205.48]),
        ("a.csv", "Well,X,Y,Z,RKB,MD\nA,0,0,-75,25,130\nA,0,0,-175,25,240\n", [130, 240]),
        ("a.rmswell", "1.0\nx\nA 0 0 25\n0\n0 0 -75\n0 0 -175\n", [100, 200]),
        ("a.rmswell", "1.0\nx\nA 0 0\n0\n0 0 -75\n0 0 -175\n", None),
        ("a.rmswell", "1.0\nx\nA 0 0 -99\n0\n0 0 -75\n0 0 -175\n", [0, 100]),
    ],
)
@pytest.mark.parametrize("positive", ["up", "down"])
def test_measured_depth_counts_from_a_datum_that_is_stated(tmp_path, name, text, md, positive):
    path = tmp_path / name
    path.write_text(text if positive == "up" else re.sub(r"-(75|115|175)", r"\1", text))
    wells = gs.read_wells(path, positive=positive)
    assert wells.elevation.values.tolist()[0] == -75
    assert ("md" in wells) == (md is not None)
    if md is not None:
        assert wells.md.values.tolist() == pytest.approx(md)


TETRA = [[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]]


def test_an_obj_file_may_have_colours_textures_and_numbers_from_the_end(tmp_path):
    points = "".join(f"v {x} {y} {z} 0.5 0.25 1\n" for x, y, z in TETRA)
    path = tmp_path / "a.obj"
    path.write_text(
        f"# by hand\no F1\n{points}vt 0 0\nvn 0 0 1\nf 1/1/1 2/1 \\\n3//1\nf -1 -2 -3\n"
    )
    fault = gs.read_fault(path)
    assert fault.vertices.tolist() == TETRA
    assert fault.triangles.tolist() == [[0, 1, 2], [3, 2, 1]]


def test_control_characters_of_a_file_do_not_reach_the_terminal(tmp_path):
    path = tmp_path / "a.xyz"
    path.write_text("\x1b]633;E;source\x07 Y Z\n1 2 3\n")
    with pytest.raises(FormatError) as told:
        gs.read_points(path, positive="up")
    assert str(told.value).isprintable()


def test_picks_with_the_name_of_a_well_are_points(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(",X,Y,Z,Well\n0,1,2,3,A\n1,4,5,6,B\n")
    assert gs.info(path).read_with == "read_points"
    path.write_text("X,Y,Z,Well\n1,2,3,A\n4,5,6,A\n")
    assert gs.info(path).read_with == "read_wells"
