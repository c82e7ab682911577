"""GeoJSON and shapefiles: places, attributes, systems, and damaged files."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import FormatError, GeosurfWarning, InputError
from geosurf.read.registry import SIGNATURES

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


def written(tmp_path, content, name="a.txt"):
    path = tmp_path / name
    if isinstance(content, dict):
        content = json.dumps(content)
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


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
    with pytest.raises(InputError, match="positive='down'"):
        gs.read_polygons(path)
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
        with pytest.raises(InputError, match="coordinates are in degrees"):
            gs.read_fault(path, positive="up")
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


LONG = shp(shape(13, [LINE]))
HUGE = shape(13, [LINE])[:40] + struct.pack("<i", 2**31 - 1) + shape(13, [LINE])[44:]
PATCH = struct.pack("<i4d4i", 31, 0, 0, 0, 0, 1, 3, 0, 0) + bytes(3 * 24 + 16)
DAMAGES = {
    "cut": (json.dumps(FAULTS)[:-9], "JSON parser cannot read it"),
    "deep": ('{"type": "Feature", "a": ' + "[" * 90_000, "JSON parser cannot read it"),
    "nan": (json.dumps(bad([[1, 2, np.nan], [3, 4, 5]])), "found NaN, expected a number"),
    "text": (bad([["1", "2"], ["3", "4"]]), "are not lists of two or three finite numbers"),
    "true": (bad([[True, 2], [3, 4]]), "are not lists of two or three"),
    "huge": (bad([[10**400, 2], [3, 4]]), "are not lists of two or three"),
    "flat": (bad([1, 2, 3]), "are not lists of two or three"),
    "short": (bad([LINE[0]]), "a LineString has 1 points, expected at least 2"),
    "ring": (bad([RING[:3]], "Polygon"), "a Polygon has 3 points, expected at least 4"),
    "none": (collection(), "no points and no lines"),
    "kind": (bad(LINE, "Curve"), "object of the type 'Curve'"),
    "mixed": (collection(("Point", LINE[0], {}), ("LineString", LINE, {})),
              "holds 1 point and 1 line, .* Write one file for each kind"),
    "half": (bad([[461000, 5932000], LINE[1]]), "1 of 2 points of a line have no elevation"),
    "shp cut": (shp(shape(13, [LINE]))[:-8], "header announces .* bytes, but the file has"),
    "shp count": (shp(HUGE), "pyshp cannot read it"),
    "shp type": (shp(PATCH), "is of the type 31"),
    "shp size": (LONG[:104] + struct.pack(">i", 999) + LONG[108:], "pyshp cannot read it"),
    "shp nan": (shp(shape(13, [[[np.inf, 0, 0], LINE[0]]])), "a coordinate that is not finite"),
    "shp one": (shp(shape(13, [LINE[:1]])), "has a line of 1 points"),
    "shp empty": (shp(), "no points and no lines"),
}  # fmt: skip


@pytest.mark.parametrize("case", DAMAGES)
def test_damaged_features_get_one_sentence(tmp_path, case):
    content, message = DAMAGES[case]
    path = written(tmp_path, content, "a.shp" if case.startswith("shp") else "a.geojson")
    with pytest.raises(FormatError, match=message):
        gs.read_fault(path, positive="up")


def test_attributes_of_another_export_are_refused(tmp_path):
    path = shapefile(tmp_path, [shape(13, [LINE])], [("F1", 1), ("F2", 2)])
    with pytest.raises(FormatError, match=r"1 shapes, but 2 rows in the \.dbf"):
        gs.read_fault(path, positive="up")
    (tmp_path / "a.dbf").write_bytes(dbf([("F1", 1)])[:-3])
    with pytest.raises(FormatError, match=r"pyshp cannot read it"):
        gs.read_fault(path, positive="up")


def test_the_index_of_a_shapefile_is_not_a_shapefile(tmp_path):
    index = shp()[:100] + struct.pack(">ii", 50, 64)
    assert gs.info(written(tmp_path, index, "a.shx")).format == "unknown"


def test_signatures_exclude_those_of_other_formats():
    for head in (json.dumps(FAULTS).encode(), shp(shape(13, [LINE]))):
        assert sum(fits(head[:8192]) for fits in SIGNATURES.values()) == 1
