"""Points, lines and sticks: CPS-3, GOCAD, RMS and Petrel, Charisma, GeoJSON, shapefiles."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import geosurf as gs
from geosurf.conventions.checks import no_data_in
from geosurf.errors import FormatError, GeosurfWarning, InputError
from geosurf.read.registry import SIGNATURES
from tests.messages import refused

HEAD = "FFASCI 0 0 COMPUTED 0 1.0E+30\nFFATTR 0 0\n"
LINES = f"{HEAD}-> 1\n0 0 1500\n0 50 1600\n-> 2\n90 0 1500\n95 50 1600\n->\n"


def written(tmp_path, content, name="a.txt"):
    path = tmp_path / name
    if isinstance(content, dict):
        content = json.dumps(content)
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def test_lines_are_polygons_or_sticks(tmp_path):
    path = written(tmp_path, LINES, "lines.dat")
    assert [line.tolist() for line in gs.read_polygons(path, positive="down")] == [
        [[0, 0, -1500], [0, 50, -1600]],
        [[90, 0, -1500], [95, 50, -1600]],
    ]
    assert len(gs.read_polygons(path, positive="down", name="2")) == 1
    fault = gs.read_fault(path, positive="down")
    assert (fault.name, [len(stick) for stick in fault.sticks]) == ("lines", [2, 2])
    said = gs.info(path)
    assert (said.format, said.read_with) == ("cps3_lines", "read_polygons or read_fault")


# ---- GOCAD VSet and PLine: points and lines, also those that geosurf wrote.
HEAD_GOCAD_LINES = (
    "GOCAD {}\nGOCAD_ORIGINAL_COORDINATE_SYSTEM\nZPOSITIVE Depth\nEND_ORIGINAL_COORDINATE_SYSTEM\n"
)
VERTICES = "VRTX 7 0 0 10\nPVRTX 8 5 0 20\nVRTX 3 5 5 30\n"


def test_points_of_several_vsets_are_elevations(tmp_path):
    one = HEAD_GOCAD_LINES.format("VSet 1") + VERTICES + "END\n"
    points = gs.read_points(written(tmp_path, one + "GOCAD PLine 1\nEND\n" + one))
    assert points.elevation.values.tolist() == [-10, -20, -30] * 2
    assert points.easting.values.tolist() == [0, 5, 5] * 2
    refused(InputError, "positive='up'", gs.read_points, tmp_path / "a.txt", positive="up")


def test_lines_are_parts_and_chains_of_segments(tmp_path):
    body = f"ILINE\n{VERTICES}SEG 7 8\nSEG 8 3\nILINE\nATOM 9 3\nVRTX 4 9 9 0\nSEG 9 4\nSEG 4 9\n"
    path = written(tmp_path, HEAD_GOCAD_LINES.format("PLine 1") + body + "END\n")
    assert [line.tolist() for line in gs.read_polygons(path)] == [
        [[0, 0, -10], [5, 0, -20], [5, 5, -30]],
        [[5, 5, -30], [9, 9, 0], [5, 5, -30]],
    ]
    sticks = gs.read_fault(path)
    assert isinstance(sticks, gs.FaultSticks)
    assert [len(stick) for stick in sticks.sticks] == [3, 3]


def test_law_curves_come_back_from_a_pline(tmp_path):
    """Two curves of one pair: ids go on from one to the next."""
    steep = np.array([[1.0, 1, -1], [3, 1, 2], [1, 4, 2]])
    one = gs.TriSurface("A", "fault", [[0.0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]])
    both = np.concatenate([steep, steep + np.array([3.0, 0, 0])])
    two = gs.TriSurface("B", "fault", both, [[0, 1, 2], [3, 4, 5]])
    curves = gs.intersect_surfaces([one, two])
    gs.write(curves, tmp_path / "c.pl")
    back = gs.read_polygons(tmp_path / "c.pl")
    assert len(back) == curves.n_curve == 2
    found = {tuple(point) for line in back for point in line.tolist()}
    assert found == {tuple(point) for point in curves.points.tolist()}


# ---- Points, polygons and sticks with attributes, as RMS and Petrel write them.
RMS = 'Float dip\nString "fault"\nDiscrete n\n1 2 30 5.5 "F 1" 7\n3 4 50 UNDEF F2 8\n'
PETREL = (
    "# Petrel Points with attributes\n# Unit in X and Y direction: m\n# Unit in depth: ft\n"
    'VERSION 1\nBEGIN HEADER\nX\nY\nZ\nFLOAT,dip\nSTRING "fault"\nINT   n\nEND HEADER\n'
    '1 2 30 5.5 "F 1" 7\n3 4 50 UNDEF F2 8\n'
)
LINES_ATTRIBUTES = (
    "String fault\n1 2 30 F1\n1 2 40 F1\n999 999 999\n3 4 30 F1\n3 4 50 F1\n999.0 999.0 999.0 F1\n"
    "5 6 30 F2\n5 6 70 F2\n999 999 999\n"
)
NUMBERED = "Discrete STICK_ID\nString name\n1 2 30 0 F1\n1 2 40 0 F1\n3 4 30 0 F2\n3 4 50 0 F2\n"


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
    refused(InputError, "positive='down'", gs.read_points, path)


def test_lines_between_end_marks_and_by_number_are_sticks_of_faults(tmp_path):
    path = written(tmp_path, LINES_ATTRIBUTES)
    fault = gs.read_fault(path, name="F1", positive="down")
    assert [stick[:, 2].tolist() for stick in fault.sticks] == [[-30, -40], [-30, -50]]
    assert len(gs.read_polygons(path, positive="down")) == 3
    (line,) = gs.read_polygons(path, positive="up", name="F2")
    assert line.tolist() == [[5, 6, 30], [5, 6, 70]]
    refused(InputError, r"has 2 faults: F1, F2\.", gs.read_fault, path, positive="down")
    found = gs.info(path)
    assert (found.read_with, found.count) == ("read_polygons or read_fault", 6)
    assert gs.read_fault(written(tmp_path, NUMBERED), name="F2", positive="up").name == "F2"


def test_what_xtgeo_writes_comes_back(tmp_path):
    xtgeo = pytest.importorskip("xtgeo", reason="xtgeo is not installed")
    pandas = pytest.importorskip("pandas")
    columns = {"X_UTME": [1.5, 2], "Y_UTMN": [3, 4.25], "Z_TVDSS": [5.0, 6], "fault": ["A B", "C"]}
    made = xtgeo.Points(values=pandas.DataFrame(columns), attributes={"fault": "str"})
    made.to_file(tmp_path / "p.rmsattr", fformat="rms_attr")
    back = gs.read_points(tmp_path / "p.rmsattr", positive="up")
    assert back.easting.values.tolist() == [1.5, 2]
    assert back.fault.values.tolist() == ["A B", "C"]


# ---- Fault sticks with names: Charisma, tables with a header, and columns that a caller names
CHARISMA = (
    "INLINE-   1201  3405  461000.10 5932000.50  1500.25 F1 1\n"
    "INLINE-   1201  3410  461050.00 5932000.00  1600.00 F1 1\n"
    "INLINE-\t1211\t3405\t461000.1\t5932100.5\t1500.25\tF1\t2\n"
    "INLINE- 1211 3410 461050 5932100 1600 F1 2\n"
    "XLINE- 0 0 461500 5932000 1500 Main fault 2b 1\n"
    "XLINE- 0 0 461550 5932000 1700 Main fault 2b 1\n"
)
# as Kingdom and SeisWorks write them: more columns, no header
COLUMNS = (
    "12 7 K 461000.10 5932000.50 1500.25 F1 1 x\n12 8 K 461050 5932000 1600 F1 1 x\n"
    "12 7 K 461000 5932100 1500 F2 1 x\n12 8 K 461050 5932100 1600 F2 1 x\n"
)
TABLE = (
    "X_UTME{0}Y_UTMN{0}Z_TVDSS{0}POLY_ID{0}NAME\n461000.1{0}5932000.5{0}1500.25{0}0{0}F1\n"
    "461050{0}5932000{0}1600{0}0{0}F1\n461000{0}5932100{0}1500{0}0{0}F2\n"
    "461050{0}5932100{0}1600{0}0{0}F2\n"
)


def test_charisma_is_recognised_and_asks_for_the_fault(tmp_path):
    path = written(tmp_path, CHARISMA, "faults")
    fault = gs.read_fault(path, name="F1", positive="down")
    assert [len(stick) for stick in fault.sticks] == [2, 2]
    assert fault.sticks[0].tolist() == [[461000.1, 5932000.5, -1500.25], [461050, 5932000, -1600]]
    assert gs.read_fault(path, name="Main fault 2b", positive="up").sticks[0][1, 2] == 1700
    with pytest.raises(InputError, match=r"has 2 faults: F1, Main fault 2b\. Choose one"):
        gs.read_fault(path, positive="down")
    found = gs.info(path)
    assert (found.format, found.read_with, found.count) == ("charisma", "read_fault", 6)
    assert found.notes["names"] == "2 faults: F1, Main fault 2b"
    assert sum(fits(CHARISMA.encode()) for fits in SIGNATURES.values()) == 1


@pytest.mark.parametrize(
    ("text", "name", "columns"),
    [
        (COLUMNS, "a.dat", (4, 5, 6, 8, 7)),
        (TABLE.format(","), "a.csv", None),
        (TABLE.format("\t"), "a.txt", None),
        (TABLE.format(","), "a.csv", ("X_UTME", "Y_UTMN", "Z_TVDSS", "POLY_ID", "NAME")),
        (TABLE.format(","), "a.csv", (1, 2, 3, 4, 5)),
    ],
)
def test_tables_with_names_hold_several_faults(tmp_path, text, name, columns):
    path = written(tmp_path, text, name)
    for key, y in (("F1", 5932000.0), ("F2", 5932100.0)):
        fault = gs.read_fault(path, name=key, positive="down", columns=columns)
        assert (fault.name, len(fault.sticks), fault.sticks[0][1, 1]) == (key, 1, y)
        (line,) = gs.read_polygons(path, name=key, positive="down", columns=columns)
        assert (line == fault.sticks[0]).all()
    with pytest.raises(InputError, match=r"has 2 faults: F1, F2\. Choose one, as in name='F1'"):
        gs.read_fault(path, positive="down", columns=columns)
    assert len(gs.read_polygons(path, positive="down", columns=columns)) == 2


@given(
    st.dictionaries(
        st.text(st.characters(codec="ascii", categories=["L", "N"]), min_size=1, max_size=5),
        st.lists(
            st.lists(
                st.tuples(*[st.floats(-1e7, 1e7, allow_subnormal=False)] * 3),
                min_size=2, max_size=4,
            ).filter(lambda stick: no_data_in(np.array(stick)) is None),
            min_size=1, max_size=3,
        ),
        min_size=1, max_size=3,
    )
)  # fmt: skip
def test_law_sticks_come_back(tmp_path_factory, faults):
    path = tmp_path_factory.mktemp("s") / "a"
    path.write_text(
        "".join(
            f"INLINE- 1 2 {x!r} {y!r} {z!r} {name} {k}\n"
            for name, sticks in faults.items()
            for k, stick in enumerate(sticks)
            for x, y, z in stick
        )
    )
    for name, sticks in faults.items():
        back = gs.read_fault(path, name=name, positive="up")
        assert [np.array(s).tolist() for s in back.sticks] == [np.array(s).tolist() for s in sticks]


# ---- GeoJSON and shapefiles: places, attributes, systems, and damaged files.
LINE = [[461000.1, 5932000.5, 1500.25], [461050, 5932000, 1600]]
OTHER = [[461500, 5932000, 1500], [461550, 5932040, 1550], [461590, 5932090, 1700]]
RING = [[461000, 5932000], [461900, 5932000], [461900, 5932900], [461000, 5932000]]
CRS = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::23031"}}


def collection(*shapes, crs=CRS, **more):
    """A collection of (type, coordinates, properties)."""
    features = [
        {"type": "Feature", "properties": words, "geometry": {"type": kind, "coordinates": place}}
        for kind, place, words in shapes
    ]
    return {"type": "FeatureCollection", "crs": crs, "features": features} | more


FAULTS = collection(
    ("LineString", LINE, {"name": "F1"}), ("MultiLineString", [OTHER, LINE], {"name": "F2"})
)


# --------------------------------------------------------------------------- shapefiles
def shape(code, parts):
    """One shape of lines, polygons or points."""
    points = np.concatenate([np.array(part, dtype=float) for part in parts])
    flat = points[:, :2].tobytes()
    z = points[:, 2].tobytes() if code > 10 else b""
    if code in (1, 11):
        return struct.pack("<i", code) + flat + z
    starts = np.cumsum([0, *(len(part) for part in parts)])[:-1]
    head = struct.pack("<i4d2i", code, 0, 0, 0, 0, len(parts), len(points))
    return head + starts.astype("<i4").tobytes() + flat + (bytes(16) if z else b"") + z


def shp(*records):
    body = b"".join(struct.pack(">ii", k + 1, len(one) // 2) + one for k, one in enumerate(records))
    head = struct.pack(">i20xi", 9994, (100 + len(body)) // 2) + struct.pack("<ii", 1000, 13)
    return head.ljust(100, b"\0") + body


def dbf(rows, fields=(("NAME", "C", 6), ("DEPTH", "N", 8))):
    width = 1 + sum(size for *_, size in fields)
    head = struct.pack("<4xIHH20x", len(rows), 33 + 32 * len(fields), width)
    for name, kind, size in fields:
        head += (
            name.encode().ljust(11, b"\0")
            + kind.encode()
            + bytes(4)
            + bytes([size, 2 * (kind == "N")])
        )
        head = head.ljust(len(head) + 14, b"\0")
    body = b"".join(
        (" " + "".join(str(v).ljust(s) for v, (*_, s) in zip(row, fields, strict=True))).encode()
        for row in rows
    )
    return head + b"\r" + body


WKT = 'PROJCS["ED50_UTM_31N",GEOGCS["ED50",UNIT["Degree",0.0174]],UNIT["Meter",1.0]]'


def shapefile(tmp_path, records, rows=None, prj=WKT):
    path = written(tmp_path, shp(*records), "a.shp")
    if rows is not None:
        written(tmp_path, dbf(rows), "a.dbf")
    written(tmp_path, prj, "a.prj")
    return path


FORMS = {
    "geojson": lambda tmp_path: written(tmp_path, FAULTS),
    "shapefile": lambda tmp_path: shapefile(
        tmp_path, [shape(13, [LINE]), shape(13, [OTHER, LINE])], [("F1", 1), ("F2", 2)]
    ),
}


@pytest.mark.parametrize("form", FORMS)
def test_lines_are_sticks_of_named_faults(tmp_path, form):
    path = FORMS[form](tmp_path)
    fault = gs.read_fault(path, name="F2", positive="down")
    down = [1, 1, -1]
    assert [s.tolist() for s in fault.sticks] == [
        (np.array(p) * down).tolist() for p in (OTHER, LINE)
    ]
    assert fault.name == "F2"
    assert fault.crs in ("EPSG:23031", WKT)
    with pytest.raises(InputError, match=r"has 2 faults: F1, F2\. Choose one, as in name='F1'"):
        gs.read_fault(path, positive="down")
    assert len(gs.read_polygons(path, positive="up")) == 3
    (line,) = gs.read_polygons(path, positive="up", name="F1")
    assert line.tolist() == LINE
    with pytest.raises(InputError, match=r"no line is called 'F3'\. Names are F1, F2"):
        gs.read_polygons(path, positive="up", name="F3")
    refused(InputError, "positive='down'", gs.read_polygons, path)
    found = gs.info(path)
    assert (found.format, found.count) == (form, 7)
    assert found.notes["names"] == "2 faults: F1, F2" or found.notes["names"] == "F1, F2"


def test_polygons_without_elevations_lie_in_the_map(tmp_path):
    path = written(tmp_path, collection(("MultiPolygon", [[RING, RING]], {})), "a.geojson")
    assert [part[:, :2].tolist() for part in gs.read_polygons(path)] == [RING, RING]
    path = shapefile(tmp_path, [shape(5, [RING]), struct.pack("<i", 0)])
    (ring,) = gs.read_polygons(path)
    assert ring[:, :2].tolist() == RING
    assert not ring[:, 2].any()
    assert gs.info(path).notes["left out"] == "1 feature without a place"
    with pytest.raises(FormatError, match=r"holds 1 ring, which read_fault does not read\."):
        gs.read_fault(path, positive="up")


def test_points_keep_their_attributes_and_take_elevations_from_one(tmp_path):
    places = [("Point", p[:2], {"well": f"W{k}", "DEPTH": 9 * k}) for k, p in enumerate(OTHER)]
    points = gs.read_points(written(tmp_path, collection(*places)), positive="down")
    assert points.elevation.values.tolist() == [0, -9, -18]
    assert points.well.values.tolist() == ["W0", "W1", "W2"]
    assert points.attrs["crs"] == "EPSG:23031"
    records = [shape(1, [[p[:2]]]) for p in OTHER]
    path = shapefile(tmp_path, records, [("W", -7.5), ("æ", 8), ("", "")])
    with pytest.raises(FormatError, match=r"'DEPTH' of feature 2 .* is None, expected a number"):
        gs.read_points(path, positive="up")
    path = shapefile(tmp_path, records, [("W", -7.5), ("x", 8), ("", 1)])
    points = gs.read_points(path, positive="up", columns=("X", "Y", "DEPTH"))
    assert points.elevation.values.tolist() == [-7.5, 8, 1]
    with pytest.raises(InputError, match="third name, one of NAME, DEPTH"):
        gs.read_points(path, positive="up", columns=("X", "Y", "Z"))


def test_degrees_are_refused_or_named(tmp_path):
    line = [[2.5, 56.1, 0], [2.6, 56.2, 9]]
    for crs in ("urn:ogc:def:crs:OGC:1.3:CRS84", "EPSG:4326"):
        path = written(tmp_path, collection(("LineString", line, {}), crs=crs))
        refused(InputError, "coordinates are in degrees", gs.read_fault, path, positive="up")
    path = written(tmp_path, collection(("LineString", line, {}), crs=None))
    with pytest.warns(GeosurfWarning, match=r"2.5 to 2.6 by 56.1 to 56.2, which could be degrees"):
        gs.read_fault(path, positive="up")
    with pytest.raises(InputError, match="coordinates are in degrees"):
        gs.read_fault(
            shapefile(tmp_path, [shape(13, [LINE])], prj='GEOGCS["WGS84"]'), positive="up"
        )


def test_a_collection_may_state_direction_and_unit(tmp_path):
    more = {"positive": "down", "units": "ft"}
    path = written(tmp_path, collection(("LineString", LINE, {}), **more))
    assert gs.read_fault(path).sticks[0][1, 2] == pytest.approx(-1600 * 0.3048)


def bad(place, kind="LineString"):
    return collection((kind, place, {}))


PATCH = struct.pack("<i4d4i", 31, 0, 0, 0, 0, 1, 3, 0, 0) + bytes(3 * 24 + 16)


def test_attributes_of_another_export_are_refused(tmp_path):
    path = shapefile(tmp_path, [shape(13, [LINE])], [("F1", 1), ("F2", 2)])
    refused(FormatError, r"1 shapes, but 2 rows in the \.dbf", gs.read_fault, path, positive="up")
    (tmp_path / "a.dbf").write_bytes(dbf([("F1", 1)])[:-3])
    refused(FormatError, r"pyshp cannot read it", gs.read_fault, path, positive="up")


def test_the_index_of_a_shapefile_is_not_a_shapefile(tmp_path):
    index = shp()[:100] + struct.pack(">ii", 50, 64)
    assert gs.info(written(tmp_path, index, "a.shx")).format == "unknown"


def test_signatures_exclude_those_of_other_formats():
    for head in (json.dumps(FAULTS).encode(), shp(shape(13, [LINE]))):
        assert sum(fits(head[:8192]) for fits in SIGNATURES.values()) == 1


# ---- Damaged files of all kinds: reader, content, words that are passed, and what the error says.
PLINE = "GOCAD PLine 1\nILINE\nVRTX 1 0 0 0\n"
WHOLE = {"format": "attributes"}
DAMAGES = {
    "cps3 name": (gs.read_polygons, HEAD + "0 0 5\n", {},
                  "line 3: found '0 0 5', expected '-> name' or x y z"),
    "cps3 short": (gs.read_polygons, HEAD + "-> 1\n0 0\n", {}, "line 4: found '0 0'"),
    "cps3 word": (gs.read_polygons, HEAD + "-> 1\n0 0 x\n", {}, "line 4: found 'x', expected a"),
    "pline vertex": (gs.read_polygons, PLINE + "SEG 1 2\nEND\n", {},
                     "line 4: vertex 2 is used but"),
    "pline alone": (gs.read_polygons, PLINE + "END\n", {}, "no segments"),
    "pline word": (gs.read_polygons, PLINE.replace("0\n", "x\n") + "END\n", {},
                   "line 3: found 'x'"),
    "pline end": (gs.read_polygons, PLINE, {}, "has no END"),
    "rms width": (gs.read_points, RMS + "5 6 7 8\n", WHOLE, "line 6: found 4 values, expected 6"),
    "rms word": (gs.read_points, RMS.replace("30", "3o"), WHOLE, "line 4: found '(UNDEF|3o)'"),
    "petrel end": (gs.read_points, PETREL.replace("END HEADER\n", ""), WHOLE,
                   "BEGIN HEADER has no END HEADER"),
    "word": (gs.read_fault, CHARISMA.replace("1500.25 F1", "15oo F1", 1),
             {"name": "F1", "format": "charisma"}, "'15oo'"),
    "short": (gs.read_fault, CHARISMA + "INLINE- 1 2 3 4\n", {"name": "F1"},
              "line 7: found 'INLINE- 1 2 3 4', expected"),
    "again": (gs.read_fault, CHARISMA + CHARISMA[:56] + "\n", {"name": "F1"},
              "'F1 1' continues after another one began"),
    "one": (gs.read_fault, CHARISMA + "XLINE- 1 2 3 4 5 F9 1\n", {"name": "F9"},
            "line 7: stick 0 .* 1 point"),
    "open": (gs.read_fault, COLUMNS, {"name": "F1"},
             r"This line is: 1 '12', 2 '7', 3 'K', 4 '461000.10'"),
    "noise": (gs.read_fault, "\x01\x02\x7f\n" * 9, {"name": "F1"},
              r"line 1: found 0 columns for x.*or set columns="),
    "json cut": (gs.read_fault, json.dumps(FAULTS)[:-9], {}, "JSON parser cannot read it"),
    "json nan": (gs.read_fault, bad([[1, 2, np.nan], [3, 4, 5]]), {},
                 "found NaN, expected a number"),
    "json true": (gs.read_fault, bad([[True, 2], [3, 4]]), {}, "are not lists of two or three"),
    "json flat": (gs.read_fault, bad([1, 2, 3]), {}, "are not lists of two or three"),
    "json short": (gs.read_fault, bad([LINE[0]]), {},
                   "a LineString has 1 points, expected at least 2"),
    "json none": (gs.read_fault, collection(), {}, "no points and no lines"),
    "json kind": (gs.read_fault, bad(LINE, "Curve"), {}, "object of the type 'Curve'"),
    "json mixed": (gs.read_fault, collection(("Point", LINE[0], {}), ("LineString", LINE, {})), {},
                   "holds 1 point and 1 line, .* Write one file for each kind"),
    "json half": (gs.read_fault, bad([[461000, 5932000], LINE[1]]), {},
                  "1 of 2 points of a line have no elevation"),
    "shp cut": (gs.read_fault, shp(shape(13, [LINE]))[:-8], {},
                "header announces .* bytes, but the file has"),
    "shp type": (gs.read_fault, shp(PATCH), {}, "is of the type 31"),
    "shp nan": (gs.read_fault, shp(shape(13, [[[np.inf, 0, 0], LINE[0]]])), {},
                "a coordinate that is not finite"),
}  # fmt: skip


@pytest.mark.parametrize("case", DAMAGES)
def test_damaged_files_get_one_sentence(tmp_path, case):
    read, content, words, message = DAMAGES[case]
    path = written(tmp_path, content, "a.shp" if case.startswith("shp") else "a.dat")
    refused(FormatError, message, read, path, positive="up", **words)
