"""Inputs of a scene in all forms: units, directions, reference systems, made when asked for."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf import Lattice, Scene, TriSurface, synthetic
from geosurf.conventions.crs import are_same, crs_of
from geosurf.errors import InputError
from tests.grids import gridded
from tests.messages import refused
from tests.scene.conftest import level
from tests.strategies import BOX, sheet


def test_a_gridded_contact_takes_the_options_of_the_scene(scene):
    """As horizons do: depths in feet, where the array itself does not say."""
    x = np.array([-1.0, 5.0])
    owc = gridded(np.full((2, 2), -2.0 / 0.3048), x).drop_attrs()
    split = scene.replace(contacts={"OWC": {"F1+": owc}}, positive="down", length_unit="ft")
    assert "Top/Base F1+ below OWC" in split.units
    above = split.units["Top/Base F1+ above OWC"].vertices[:, 2]
    assert above.min() == pytest.approx(2.0, abs=1e-12)
    with pytest.raises(InputError, match=r"horizon 'OWC': are the values depth or elevation\?"):
        scene.replace(contacts={"OWC": owc}).units  # noqa: B018


@pytest.mark.parametrize("said", [{"units": "m"}, {"units": "m", "positive": "up"}])
def test_a_gridded_fault_that_declares_its_units_keeps_them(said):
    dims = ("down_dip", "along_strike")
    fault = xr.Dataset({
        "easting": (dims, [[1.0, 1.0], [2.0, 2.0]]),
        "northing": (dims, [[0.0, 9.0], [0.0, 9.0]]),
        "elevation": (dims, [[8.0, 8.0], [-8.0, -8.0]], said),
    })  # fmt: skip
    scene = Scene({}, {"F1": fault}, BOX, positive="down", length_unit="ft")
    assert scene.surface("F1").bounds == (1.0, 2.0, 0.0, 9.0, -8.0, 8.0)
    plain = fault.assign(elevation=fault.elevation.drop_attrs())
    for whole in ({}, {"units": "m"}):  # which once kept the word of the scene away
        feet = (
            Scene({}, {"F1": plain.assign_attrs(whole)}, BOX, length_unit="ft").surface("F1").bounds
        )
        assert feet[4:] == pytest.approx((-2.4384, 2.4384), abs=1e-12)


def test_a_scene_outlives_what_is_done_to_its_inputs():
    """Grids are lent to surfaces, not to scenes: boxes would be stale, and volumes mixed."""
    worlds = [synthetic.tilted_planes() for _ in range(2)]
    scenes = [Scene(world.horizons, world.faults, world.box) for world in worlds]
    for name in (*worlds[0].horizons, *worlds[0].faults):
        scenes[0].surface(name)
    for da in worlds[0].horizons.values():
        da.values[...] += 77.0
    for ds in worlds[0].faults.values():
        ds["easting"].values[...] -= 99.0
    first, second = ({name: unit.volume for name, unit in s.units.items()} for s in scenes)
    assert first == second


def test_a_frame_that_would_round_inputs_is_not_taken():
    """The box lies beyond 2048 m, but 1000.1 - 2048 has more digits than a double."""
    axis = np.arange(900.1, 3200.0, 200.0)
    top = TriSurface("Top", "horizon", lattice=Lattice(axis, axis, np.zeros((12, 12))))
    box = (2100.0, 2900.0, 2100.0, 2900.0, -300.0, 300.0)
    patches = Scene({"Top": top}, box=box).patches
    assert patches.origin.tolist() == [0.0, 0.0, 0.0]
    assert set(map(tuple, top.vertices.tolist())) <= set(map(tuple, patches.vertices.tolist()))
    even = TriSurface("Top", "horizon", lattice=Lattice(*[np.floor(axis)] * 2, np.zeros((12, 12))))
    assert Scene({"Top": even}, box=box).patches.origin.tolist() == [2048.0, 2048.0, 0.0]


def test_a_fault_has_its_front_in_the_hanging_wall_however_it_is_wound():
    dipping = sheet("F1", [(1, -1, 8), (1, 5, 8), (3, 5, -4), (3, -1, -4)])
    turned = TriSurface("F1", "fault", dipping.vertices, dipping.triangles[:, ::-1])
    for fault in (dipping, turned):
        volumes = {u.block: u.volume for u in Scene({}, {"F1": fault}, BOX).units.values()}
        assert volumes == {"F1+": 96.0, "F1-": 96.0}
        units = Scene({"Top": level(5)}, {"F1": fault}, BOX).units
        assert units["above Top F1+"].volume > units["above Top F1-"].volume


# ---- Inputs as people have them: made when they are asked for, in feet, outside, without name
@pytest.fixture(scope="module")
def world():
    return gs.synthetic.graben(n=9)


def scene(world, **more):
    return gs.Scene(world.horizons, world.faults, world.box, **more)


def test_grids_in_two_reference_systems_are_refused_by_name(world, tmp_path):
    """Both are metres: nothing else would tell."""
    here = {name: da.assign_attrs(crs="EPSG:32631") for name, da in world.horizons.items()}
    gs.write(here["Base"].assign_attrs(crs="EPSG:23031"), tmp_path / "Base.nc")
    for other in (here["Base"].assign_attrs(crs="EPSG:23031"), tmp_path / "Base.nc"):
        with pytest.raises(
            InputError,
            match=r"'Base' is in EPSG:23031, but 'Top' is in EPSG:32631\. Convert one of them",
        ):
            _ = gs.Scene({**here, "Base": other}, world.faults, world.box).units
    fault = world.faults["F1"].assign_attrs(crs="epsg:23031")
    mixed = gs.Scene(here, {"F1": fault}, world.box)
    with pytest.raises(InputError, match=r"'F1' is in epsg:23031, but 'Top' is in EPSG:32631"):
        _ = mixed.surfaces
    with pytest.raises(InputError, match=r"'F1' is in epsg:23031"):
        _ = mixed.replace(box=world.box).surfaces  # what is remembered is compared, too
    made = gs.triangulate_fault(fault)
    assert made.crs == "epsg:23031"
    assert gs.triangulate_horizon(here["Top"], tolerance=1.0).crs == "EPSG:32631"
    with pytest.raises(InputError, match=r"'F1' is in epsg:23031"):
        _ = gs.Scene(here, {"F1": made}, world.box).surfaces  # made by hand, turned or not
    same = {"F1": world.faults["F1"].assign_attrs(crs="epsg:32631")}
    assert len(gs.Scene({**here, "Base": world.horizons["Base"]}, same, world.box).surfaces) == 4


def test_contacts_of_zones_and_blocks_that_there_are_not(world):
    def wrong(contacts, words):
        refused(InputError, words, lambda: scene(world, contacts=contacts).units)

    wrong(
        {"OWC": gs.FluidContact(-2100.0, zones="Top/Bse")},
        r"'OWC': unknown zone 'Top/Bse'. Zones are \['above Top', ",
    )
    wrong(
        {"OWC": gs.FluidContact(-2100.0, block="F9+")},
        r"'OWC': no unit lies on 'F9\+'. Name a block or a side of a fault: \['F1\+', ",
    )
    wrong({"OWC": float("nan")}, r"the elevation of fluid contact 'OWC' is nan. Give a number")
    called = gs.FluidContact(-2100.0, name="GOC")
    wrong({"OWC": called}, r"'OWC' holds a FluidContact with another name, 'GOC'. Use one name")
    wrong({"OWC": -2.1}, r"'OWC' is at elevation -2\.1 m, outside the model box .*enlarge")


# ---- One unit of elevations for every format, and one coordinate reference system in a scene.
FT = 0.3048
BOX_CRS_AND_UNITS = (0, 150, 0, 100, -300, 0)
POINTS = np.array([(3000.0, y, z) for y in (-900.0, 0.0, 900.0) for z in (-4000.0, -10000.0)])
FACES = [f for i in (0, 2) for f in ((i, i + 1, i + 2), (i + 1, i + 3, i + 2))]


def test_units_are_those_of_elevations():
    """Heights are scaled, easting and northing stay metres."""
    scene = gs.Scene(
        {}, {"F1": (POINTS, FACES)}, (0, 9000, -9, 9, -9, 9), length_unit="ft", positive="up"
    )
    low, high = -10000 * FT, -4000 * FT
    assert scene.surface("F1").bounds == pytest.approx((3000, 3000, -900, 900, low, high))


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
    axes = [0.0, 50, 100, 150], [0.0, 50, 100]
    return gridded(np.full((3, 4), -100.0), *axes, **attrs).rename("elevation")


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
    scene = gs.Scene({"A": made, "B": base}, {}, BOX_CRS_AND_UNITS)
    refused(InputError, r"'B' is in EPSG:32631, but 'A' is in EPSG:23031\.", lambda: scene.units)
    twin = gs.Scene({"A": grid()}, {}, BOX_CRS_AND_UNITS)
    assert twin.surface("A").crs is None
    assert twin.replace(horizons={"A": made}).surface("A").crs == "EPSG:23031"


def test_what_cannot_be_compared_is_a_warning():
    base = (grid() - 100.0).assign_attrs(grid(crs="UTM zone 31").attrs)
    scene = gs.Scene({"A": grid(crs="EPSG:32631"), "B": base}, {}, BOX_CRS_AND_UNITS)
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
    refused(InputError, rf"in {unit}.*metres. Convert", taken_in, how, text, tmp_path)


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


@pytest.mark.parametrize("text", ["EPSG:32631", "UTM 31", 'PROJCS["a",UNIT["x",.]]'])
def test_metres_and_units_that_nobody_knows_are_taken(text):
    assert gs.Scene({"Top": grid(crs=text)}).surface("Top").crs
