"""One unit of elevations for every format, and one coordinate reference system in a scene."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.conventions.crs import are_same, crs_of
from geosurf.errors import InputError

FT = 0.3048
BOX = (0, 150, 0, 100, -300, 0)
LINES = [[(3000.0, v, -4000.0), (3000.0, v, -10000.0)] for v in (-900.0, 0.0, 900.0)]
POINTS = np.array(LINES).reshape(-1, 3)
FACES = [f for i in (0, 2) for f in ((i, i + 1, i + 2), (i + 1, i + 3, i + 2))]


def in_feet(kind, folder):
    """One fault, heights in feet, in a format that does not declare units."""
    path = folder / f"F1.{kind}"
    nodes = [" ".join(map(str, p)) for p in POINTS.tolist()]
    if kind == "ts":
        body = [f"VRTX {i} {node}" for i, node in enumerate(nodes)]
        body += [f"TRGL {a} {b} {c}" for a, b, c in FACES]
        path.write_text(
            "\n".join(["GOCAD TSurf 1", "HEADER {", "name:F1", "}", "TFACE", *body, "END\n"])
        )
    elif kind == "obj":
        body = [f"v {node}" for node in nodes] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in FACES]
        path.write_text("\n".join(body) + "\n")
    elif kind == "pol":
        rows = [" ".join(map(str, p)) + "\n" for line in LINES for p in [*line, (999, 999, 999)]]
        path.write_text("".join(rows))
    elif kind == "vtp":
        gs.write(gs.TriSurface("F1", "fault", POINTS, FACES), path)
    elif kind == "nc":
        rows = np.array(LINES).transpose(1, 0, 2)
        names = ("easting", "northing", "elevation")
        dims = ("down_dip", "along_strike")
        table = {name: (dims, rows[..., i]) for i, name in enumerate(names)}
        xr.Dataset(table).to_netcdf(path, engine="h5netcdf")
    else:
        return POINTS, FACES
    return path


@pytest.mark.parametrize("kind", ["ts", "obj", "pol", "vtp", "nc", "arrays"])
def test_units_are_those_of_elevations(kind, tmp_path):
    """Whatever the format: heights are scaled, easting and northing stay metres."""
    given = in_feet(kind, tmp_path)
    scene = gs.Scene({}, {"F1": given}, (0, 9000, -9, 9, -9, 9), length_unit="ft", positive="up")
    wall = scene.surface("F1").vertices
    assert set(wall[:, 0]) == {3000.0}
    assert (wall[:, 1].min(), wall[:, 1].max()) == (-900.0, 900.0)
    np.testing.assert_allclose([wall[:, 2].min(), wall[:, 2].max()], [-10000 * FT, -4000 * FT])


# ---- coordinate reference systems ----------------------------------------------------------


def wkt(code, name="WGS 84 / UTM zone 31N", own=True):
    """A description whose parts have codes of their own."""
    last = f',AUTHORITY["EPSG","{code}"]' if own else ""
    return (
        f'PROJCS["{name}",GEOGCS["WGS 84",AUTHORITY["EPSG","4326"]],'
        f'UNIT["metre",1,AUTHORITY["EPSG","9001"]]{last}]'
    )


ONE = [
    "EPSG:32631",
    "epsg:32631",
    "32631",
    "urn:ogc:def:crs:EPSG::32631",
    "urn:ogc:def:crs:EPSG:9.8:32631",
    "http://www.opengis.net/def/crs/EPSG/0/32631",
    "+init=epsg:32631",
    "EPSG:32631+5714",
    wkt(32631),
    'PROJCRS["a",BASEGEOGCRS["b",ID["EPSG",4326]],CONVERSION["c",ID["EPSG",16031]],ID["EPSG",32631]]',
    f'COMPD_CS["x",{wkt(32631)},VERT_CS["h",AUTHORITY["EPSG","5714"]],AUTHORITY["EPSG","9"]]',
]


@pytest.mark.parametrize("text", ONE)
def test_codes_are_found_in_all_their_spellings(text):
    for other in ONE:
        assert are_same(text, other) is True
        assert are_same(text.replace("32631", "23031"), other) is False
    for name in ("UTM31", wkt(0, own=False), "", "[", "]]", 'PROJCS["', '"', "EPSG:"):
        assert are_same(text, name) is None


def grid(**attrs):
    coords = {"northing": [0.0, 50, 100], "easting": [0.0, 50, 100, 150]}
    attrs = {"units": "m", "positive": "up", **attrs}
    return xr.DataArray(
        np.full((3, 4), -100.0), coords, ("northing", "easting"), "elevation", attrs
    )


def declared(how, text):
    """A grid that declares its reference system in one of the usual ways."""
    if how == "attribute":
        return grid(crs=text)
    if how == "extended grid mapping":
        return grid(grid_mapping="here: easting northing").assign_coords(here=mark(crs_wkt=text))
    if how == "encoding":
        made = grid().assign_coords(here=mark(spatial_ref=text))
        made.encoding["grid_mapping"] = "here"
        return made
    if how == "epsg number":
        return grid(grid_mapping="here").assign_coords(here=mark(epsg_code=int(text[5:])))
    return grid().assign_coords(spatial_ref=mark(crs_wkt=text, spatial_ref=text))


def mark(**attrs):
    return xr.DataArray(0, attrs=attrs)


WAYS = ["attribute", "extended grid mapping", "encoding", "epsg number", "rioxarray"]


@pytest.mark.parametrize("how", WAYS)
def test_wherever_it_is_declared(how):
    made = declared(how, "EPSG:23031")
    assert crs_of(made) == crs_of(made.to_dataset()) == "EPSG:23031"
    assert gs.triangulate_horizon(made, name="A").crs == "EPSG:23031"
    base = (declared("attribute", "EPSG:32631") - 100.0).assign_attrs(grid(crs="EPSG:32631").attrs)
    scene = gs.Scene({"A": made, "B": base}, {}, BOX)
    with pytest.raises(InputError, match=r"'B' is in EPSG:32631, but 'A' is in EPSG:23031\."):
        _ = scene.units
    twin = gs.Scene({"A": grid()}, {}, BOX)
    assert twin.surface("A").crs is None
    assert twin.replace(horizons={"A": made}).surface("A").crs == "EPSG:23031"


def test_what_cannot_be_compared_is_a_warning():
    base = (grid() - 100.0).assign_attrs(grid(crs="UTM zone 31").attrs)
    scene = gs.Scene({"A": grid(crs="EPSG:32631"), "B": base}, {}, BOX)
    with pytest.warns(gs.GeosurfWarning, match=r"'B' declares .*'UTM zone 31'.*cannot compare"):
        (found,) = scene.warnings
    assert (found.kind, found.subject) == ("crs", "B")


FOOT = 'UNIT["Foot_US",0.304800609601219]'
TEXAS = f'PROJCS["Texas",GEOGCS["a",SPHEROID["b",6378137,298.2],UNIT["Degree",0.017]],{FOOT}]'


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        (TEXAS, "feet"),
        (f'COMPD_CS["both",{TEXAS},VERT_CS["h",UNIT["metre",1]]]', "feet"),
        ("NAD83 / Texas North Central (ftUS)", "feet"),
        ("+proj=lcc +lat_1=32 +units=us-ft +no_defs", "feet"),
        ('GEOGCS["WGS 84",UNIT["degree",0.0174532925199433]]', "degrees"),
        ("urn:ogc:def:crs:OGC:1.3:CRS84", "degrees"),
        ("EPSG:4326", "degrees"),
        ("+proj=longlat +datum=WGS84", "degrees"),
        ('GEODCRS["WGS 84",DATUM["a"],UNIT["degree",0.0174532925199433]]', "degrees"),
        ('PROJCS["a",UNIT["Foot",.3048]]', "feet"),
    ],
)
@pytest.mark.parametrize("how", ["attribute", "extended grid mapping", "mesh", "prj", "geojson"])
def test_systems_in_feet_or_degrees_are_refused_in_every_input(tmp_path, text, unit, how):
    with pytest.raises(InputError, match=rf"in {unit}.*metres. Convert"):
        taken_in(how, text, tmp_path)


def taken_in(how, text, folder):
    """An input that states a reference system, as a user would give it."""
    if how == "prj":
        gs.write(grid(), folder / "top.asc")
        (folder / "top.prj").write_text(text)
        return gs.read_horizon(folder / "top.asc", positive="up", length_unit="m")
    if how == "geojson":
        line = {"type": "LineString", "coordinates": [[0, 0, -1], [1000, 0, -1]]}
        words = {"type": "name", "properties": {"name": text}}
        (folder / "a.geojson").write_text(json.dumps({**line, "crs": words}))
        return gs.read_polygons(folder / "a.geojson", positive="up")
    if how == "mesh":
        surface = gs.TriSurface("F1", "fault", POINTS, FACES)
        surface.crs = text
        return gs.Scene({"Top": grid()}, {"F1": surface}).curves
    return gs.Scene({"Top": declared(how, text)}).units


@pytest.mark.parametrize(
    "text",
    [
        f'COMPD_CS["x",{wkt(32631)},VERT_CS["h",{FOOT}]]',
        "EPSG:32631",
        "UTM 31",
        'PROJCS["a",UNIT["x",.]]',
    ],
)
def test_metres_with_feet_of_another_kind_are_taken(text):
    assert gs.Scene({"Top": grid(crs=text)}).surface("Top").crs
