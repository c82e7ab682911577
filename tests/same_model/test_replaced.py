"""`replace` gives the scene that its inputs would have made afresh, for every input."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.scene.inputs import INPUTS
from geosurf.triangulate import decimate
from tests.same_model import worlds

# a model that is irregular on purpose is warned of
pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")

WEST, EAST, SOUTH, NORTH = worlds.BOX[:4]
AREA = [(WEST + 200, SOUTH + 100), (EAST - 300, SOUTH + 200), (EAST - 100, NORTH - 300),
        (WEST + 900, NORTH - 100)]  # fmt: skip


@pytest.fixture(autouse=True)
def _few_nodes_are_enough(monkeypatch):
    monkeypatch.setattr(decimate, "LEAST_NODES", 100)  # of a tolerance


def coarse(horizons: dict[str, xr.DataArray]) -> dict[str, xr.DataArray]:
    """Every fourth node: what has to be computed anew depends on keys, not on sizes."""
    return {name: one[::4, ::4] for name, one in horizons.items()}


def bare(values: xr.DataArray) -> xr.DataArray:
    """A horizon that declares neither its unit nor its sign."""
    return values.drop_attrs()


def tops() -> xr.Dataset:
    """Two wells, a top of each horizon, some metres off."""
    rows = [
        (well, horizon, east, north, base)
        for well, east, north in (("A", 2800.0, 3000.0), ("B", 4200.0, 5500.0))
        for horizon, base in (("Top", -1890.0), ("Middle", -1985.0))
    ]
    names = ("well", "horizon", "easting", "northing", "elevation")
    columns = dict(zip(names, zip(*rows, strict=True), strict=True))
    return xr.Dataset(
        {name: ("top", list(values)) for name, values in columns.items()},
        attrs={"units": "m", "positive": "up"},
    )


def start() -> dict[str, Any]:
    """A model with a bare horizon, so that `positive` and `length_unit` count."""
    horizons = coarse(worlds.uneven_horizons())
    horizons["Base"] = bare(horizons["Base"])
    words = {"positive": "up", "length_unit": "m", "tops": tops()}
    return {"horizons": horizons, "faults": worlds.faults(), "box": worlds.BOX, **words}


def torn() -> dict[str, Any]:
    """Two horizons of it, torn at one fault."""
    horizons = coarse(worlds.picked_horizons())
    del horizons["Base"]
    faults = {"W": worlds.faults()["W"]}
    return {"horizons": horizons, "faults": faults, "box": worlds.BOX, "tear": {"W": 2}}


def untorn() -> dict[str, Any]:
    """The upper one as it was gridded."""
    top = torn()["horizons"]["Top"]
    return torn() | {"horizons": {"Top": top}, "tear": None}


def in_time() -> dict[str, Any]:
    """Two horizons and a fault in milliseconds, and their velocities."""
    horizons = coarse(worlds.uneven_horizons())
    for one in horizons.values():
        one.attrs["units"] = "ms"
    faults = {"W": worlds.faults()["W"]}
    words = {"time": "two-way", "velocity": {"elsewhere": 2000.0}, "length_unit": "ms"}
    return {"horizons": horizons, "faults": faults, **words}


def raised(data: xr.DataArray) -> xr.DataArray:
    return data + xr.zeros_like(data).where(data.easting < 3000.0, 4.0)


def moved(fault: gs.TriSurface) -> gs.TriSurface:
    return gs.TriSurface(
        "E", "fault", fault.vertices + np.array([60.0, 0.0, 10.0]), fault.triangles
    )


# For every input: the model that it is changed in, its new value, and whether results differ.
CHANGES: dict[str, tuple[Any, Any, bool]] = {
    "horizons": (start, {"Middle": raised(start()["horizons"]["Middle"])}, True),
    "faults": (start, {"E": moved(worlds.faults()["E"])}, True),
    "box": (start, (*worlds.BOX[:2], 4200.0, 6000.0, -2400.0, -1700.0), True),  # another frame
    "column": (start, {"Middle": "erosional"}, True),
    "contacts": (start, {"GOC": -1920.0, "OWC": {"W-": -1990.0, "V+": -2010.0}}, True),
    "aoi": (start, AREA, True),
    "positive": (start, "down", True),
    "length_unit": (start, "ft", True),
    "voxel_size": (start, 333.0, False),
    "self_intersections": (start, True, False),
    "extend": (start, {"E": ("end", "down")}, True),
    "truncations": (start, {"E": ("V", "hanging wall", True)}, True),
    "tolerance": (start, 40.0, True),
    "tops": (start, tops().isel(top=[0, 3]), True),
    "tie": (start, {"range": 800.0}, True),
    "lengthen": (start, {"E": {"start": 120.0}}, True),
    "tear": (torn, {"W": 4}, True),
    "throws": (untorn, {"W": gs.EllipticThrow(30.0)}, True),
    "slivers": (start, 5e7, True),
    "fill_empty_blocks": (torn, {"Middle": True}, False),
    "compartments": (start, {"E": "boundary"}, True),
    "crs": (start, "EPSG:23031", True),
    "reservoir": (start, ["Middle/Base"], True),
    "time": (in_time, "one-way", True),
    "velocity": (in_time, {"elsewhere": {"v0": 1800.0, "k": 0.4}}, True),
    "zones": (start, {"Extra": {"below": "Base", "thickness": 20.0}}, True),
    "regions": (start, {"All": [[-1e6, -1e6], [1e7, -1e6], [1e7, 1e8], [-1e6, 1e8]]}, True),
}


def all_of(scene: gs.Scene) -> worlds.Answers:
    """What a model says, measures included."""
    line = [(WEST + 150, SOUTH + 450), (EAST - 150, NORTH - 350)]
    places = [(2000.0, 3000.0, -1950.0), (4400.0, 5000.0, -2100.0), (2230.0, 4000.0, -2050.0)]
    measures = {
        "sample": lambda: scene.sample(places),
        "section": lambda: scene.section(line),
        "thickness": lambda: scene.thickness("Top/Middle", 250.0),
        "throw": lambda: scene.throw("Base", "W"),
        "polygons": lambda: scene.fault_polygons("Base"),
        "juxtaposition": lambda: scene.juxtaposition("W", "all"),
    }
    return worlds.bytes_of(scene, measures)


@cache
def before_change(inputs: Callable[[], dict[str, Any]]) -> tuple[gs.Scene, worlds.Answers]:
    """A model with every result in memory."""
    scene = gs.Scene(**inputs())
    return scene, all_of(scene)


def changed(given: dict[str, Any], key: str, value: Any) -> dict[str, Any]:
    """Inputs with one changed; surfaces that are not named stay."""
    return given | {key: given[key] | value if key in ("horizons", "faults") else value}


def test_every_input_has_a_change():
    assert set(CHANGES) == set(INPUTS)


@pytest.mark.parametrize("key", CHANGES)
def test_law_replaced_equals_fresh_for_every_input(key):
    """There and back, with every result of the model before in memory."""
    inputs, value, differs = CHANGES[key]
    given = inputs()
    scene, before = before_change(inputs)
    assert "error" not in before

    twin = scene.replace(**{key: value})
    fresh = all_of(gs.Scene(**changed(given, key, value)))
    assert worlds.difference(all_of(twin), fresh) == ""
    assert ("error" in fresh) == (key in ("positive", "length_unit"))  # Base leaves the box
    assert not differs or worlds.difference(before, fresh)

    back = {n: given[key].get(n) for n in value} if key in ("horizons", "faults") else None
    again = twin.replace(**{key: given.get(key, SceneDefault[key]) if back is None else back})
    assert worlds.difference(all_of(again), before) == ""


SceneDefault = {one: gs.Scene.__init__.__kwdefaults__.get(one) for one in INPUTS} | {
    "column": None, "contacts": None, "aoi": None,
}  # fmt: skip


@pytest.mark.parametrize("seed", range(2))
def test_law_chains_of_changes_equal_the_scene_made_afresh(seed):
    """Several inputs at once, one after another: keys must not hold for combinations only."""
    rng = np.random.default_rng([4, seed])
    given = start()
    scene = gs.Scene(**given)
    known = [key for key, (make, _, _) in CHANGES.items() if make is start]
    for step in range(6):
        key = str(rng.choice(known))
        value = CHANGES[key][1] if rng.random() < 0.7 else given.get(key)
        if key in ("horizons", "faults"):
            value = CHANGES[key][1] if step % 2 else start()[key]
        try:
            twin = scene.replace(**{key: value})
        except gs.errors.InputError:
            continue
        after = changed(given, key, value)
        try:
            fresh = gs.Scene(**after)
        except gs.errors.InputError:
            continue  # a rule about a fault that `replace` dropped with it
        assert worlds.difference(worlds.bytes_of(twin), worlds.bytes_of(fresh)) == "", (step, key)
        given, scene = after, twin
