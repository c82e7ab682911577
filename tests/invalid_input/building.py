"""Wrong things for what builds a model: grids, faults, sheets, scenes and the nouns.

Rows of `wrong.row`, by the name of what is called.
"""

from __future__ import annotations

import numpy as np

import geosurf as gs
from tests.invalid_input import wrong
from tests.invalid_input.wrong import FLAGS, row

TRIANGLE = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0]])
LENS = {"Top": [[0, 0, 0], [-1, 5, 1], [0, 9, 0], [1, 5, -1]]}
NO_FAULTS = ["abc", 5, None, object(), [None], ["F1"], {"F1": "no.vtp"}, {"F1": None}]
POINTS = [v for v in wrong.ARRAYS if v is not None]


def no_mappings(values):
    return [value for value in values if not isinstance(value, dict)]


def surface_of(**given):
    """A small surface, one argument exchanged."""
    whole = {"name": "A", "role": "surface", "vertices": TRIANGLE, "triangles": [[0, 1, 2]]}
    return gs.TriSurface(**whole | given)


def world_of(g):
    return {"horizons": g.world.horizons, "faults": g.world.faults, "box": g.box}


def torn_of(g):
    return {"horizon": g.grid, "faults": g.faults, "throw": {"F1": 20.0}}


BUILDING = {
    "triangulate_horizon": row(
        lambda g: {"da": g.top},
        da=lambda g: wrong.horizons(g.top), name=[["F1"], ("F1",), object(), 1.5, {"a": 1}],
        length_unit=wrong.WORDS, positive=wrong.WORDS, tolerance=wrong.LENGTHS,
    ),
    "triangulate_fault": row({"name": "F"}, obj=lambda g: wrong.faults(g.fault)),
    "triangulate_sticks": row({"name": "F"}, sticks=wrong.ARRAYS),
    "build_walls": row(
        lambda g: {"box": g.box}, box=[*wrong.BOXES, None],
        aoi=[*POINTS, np.zeros((5, 2)), [[0, 0], [1, 1], [0, 1], [1, 0]],
             [[0, 0], [1e9, 0], [0, 1e9]]],
    ),
    "build_contacts": row(
        lambda g: {"contacts": {"OWC": -2100.0}, "box": g.box}, box=[*wrong.BOXES, None],
        contacts=lambda g: [*wrong.MAPPINGS[:4], None, *({"OWC": v} for v in wrong.NUMBERS),
                            {"OWC": {"F1+": None}}, {"OWC": g.top[0]},
                            {"OWC": [-2100.0, -2100.0]}],
    ),
    "FluidContact": row(
        {"at": -1.0}, zones=[5, None, [5], {}, [None], object()],
        block=[5, None, [5], {}, object()], name=[None, [5], {}, object()],
    ),
    "extend_fault": row(
        lambda g: {"surface": g.f1, "box": g.box}, surface=wrong.things, box=[*wrong.BOXES, None],
        sides=[5, None, True, "abc", ["abc"], [5], [None], object()],
    ),
    "fault_from_polygons": row(
        {"polygons": LENS, "name": "F1"}, lengthen=["abc", -1, {}, [1]], dip=["abc", 0, 180, [1]],
        polygons=[None, 5, "abc", {}, [], {"Top": None}, {"Top": [[0, 0]]}, {"Top": "abc"}],
    ),
    "lengthen_fault": row(
        lambda g: {"surface": g.f1, "distance": 5.0},
        surface=wrong.things, distance=[*wrong.LENGTHS, 0, None],
    ),
    "split_fault": row({}, surface=wrong.things),
    "truncate_faults": row(
        lambda g: {"patches": g.patches, "truncations": {}},
        patches=wrong.things, whole=lambda g: [v for v in wrong.things(g) if v is not None],
        truncations=[5, "abc", {"F1": 5}, {"F1": ("F9", "footwall")}, {"F1": ("F1", "footwall")},
                     {"F1": (None, None)}, {"Top": ("F1", "footwall")}, {5: ("F1", "footwall")}],
    ),
    "propose_network": row(
        lambda g: {"patches": g.patches},
        patches=wrong.things, box=wrong.BOXES, reach=[*wrong.LENGTHS, 0],
    ),
    "tear_horizon": row(
        lambda g: {"data": g.grid, "faults": g.faults}, data=lambda g: wrong.horizons(g.grid),
        faults=lambda g: [*NO_FAULTS, *({"F1": v} for v in wrong.faults(g.fault)[2:9])],
        trim=wrong.LENGTHS, noise=wrong.LENGTHS, spacing=wrong.LENGTHS, fill_empty_blocks=FLAGS,
    ),
    "extend_horizon": row(
        lambda g: {"horizon": g.grid, "distance": 9.0},
        horizon=lambda g: wrong.horizons(g.grid), area=[*wrong.BOXES, *POINTS],
        distance=[*wrong.LENGTHS, 0], fill_holes=FLAGS, faults=NO_FAULTS,
    ),
    "propose_dip": row(
        lambda g: {"polygon": LENS["Top"], "horizons": [g.grid, g.grid]},
        polygon=[None, 5, "abc", [[0, 0]]],
        horizons=lambda g: [[v] for v in wrong.horizons(g.grid)],
    ),
    "propose_trim": row(lambda g: {"faults": g.faults}, data=lambda g: wrong.horizons(g.grid)),
    "throw_horizon": row(
        torn_of, horizon=lambda g: wrong.horizons(g.grid),
        throw=["abc", 5, None, [("F1", 5.0)], {"F9": 5.0}, {5: 5.0},
               *({"F1": v} for v in wrong.throws())],
        reach=[*no_mappings(wrong.LENGTHS), {"F9": 9.0}, {"F1": "x"}],
        hanging_wall=[*no_mappings(wrong.LENGTHS), 1.5, {"F9": 0.5}, {"F1": "x"}],
        direction=[*wrong.WORDS, {"F1": "x"}, None],
    ),
    "EllipticThrow": row(
        {"largest": 9.0}, largest=[*wrong.NUMBERS, None],
        half_length=[*wrong.LENGTHS, 0], half_height=[*wrong.LENGTHS, 0],
        centre=["abc", 5, None, (1,), (1, 2, 3), ("a", "b"), (np.nan, 1.0), {}, [1j, 2]],
    ),
    "intersect_triangles": row({"Q": TRIANGLE}, P=wrong.ARRAYS),
    "intersect_surfaces": row(
        lambda g: {"surfaces": g.surfaces}, surfaces=wrong.things, method=wrong.WORDS,
        voxel_size=[*wrong.LENGTHS, 0], self_intersections=FLAGS,
    ),
    "rebuild_surfaces": row({}, surfaces=wrong.things),
    "trim_sheets": row({}, patches=wrong.things),
    "carve_units": row(
        lambda g: {"patches": g.patches}, patches=wrong.things,
        column=[5, "abc", [], {"Top": "x"}, {"Top": 5}, {"Nope": "erosional"}],
        contacts=["abc", 5, None, [5], {"OWC": -1.0}, [gs.FluidContact(-1.0, name="x")], object()],
        slivers=no_mappings(wrong.LENGTHS),
    ),
    "run_ensemble": row({"n": 2, "uncertain": [5], "progress": False},
                        model=[None, 5, [], {}, object()]),
    "Scene": row(
        world_of, lambda **words: gs.Scene(**words).regions,
        box=wrong.BOXES, aoi=POINTS, positive=wrong.WORDS, length_unit=wrong.WORDS,
        voxel_size=wrong.LENGTHS, self_intersections=FLAGS, tolerance=[*wrong.LENGTHS, 0],
        horizons=lambda g: [*wrong.MAPPINGS[:5], *({"Top": v} for v in wrong.horizons(g.top)
                                                   if v is not None)],
        faults=lambda g: [{"F1": v} for v in wrong.faults(g.fault) if v is not None],
        column=[5, "abc", {"Top": "x"}, {"Top": None}, {5: "erosional"}],
        contacts=lambda g: [*wrong.MAPPINGS[:6], {"Top": -2100.0}, {"OWC": "no.nc"},
                            {"OWC": g.top[0]}, {"OWC": {"F9+": -2100.0}},
                            {"OWC": gs.FluidContact(None)}, {"OWC": g.scene}],
        lengthen=[-1, "abc", {"F9": 1}, {"F1": None}, [5]],
        slivers=[-1, "abc", [5], True, {"x": 1}, {"merge": 5}, {"min_volume": "5"}],
        reservoir=[5, "abc", "Top/Base", [], ["abc"], [5], [None], object()],
        regions=[5, "abc", [], {"A": 5}, {"A": None}, {"A": "no.pol"}, {"A": ("F1",)},
                 {"A": ("F9+",)}, {"A": (-9e9, 0.0)}, {"A": [[0, 0], [1, 1]]}, {"": (0, 0)},
                 {"A": object()}],
        extend=[5, "abc", ["abc"], [5], [None], object(), {"F9": "strike"}, {"F1": 5}],
        truncations=[5, "abc", {"F1": 5}, {"F1": ("F9", "footwall")}, {"F1": (None, None)}],
    ),
    "scene.table": row({}, include=wrong.WORDS,
                       by=[5, "abc", [], ["abc"], ["zone", "zone"], [None], object()]),
    "scene.replace": row({}, x=[1], horizons=[5], faults=[[], {"x": None}], box=["abc"],
                         column=[5], extend=[{"F9": 1}]),
    "scene.surface": row({}, name=wrong.NAMES),
    "scene.allan": row({}, fault=wrong.NAMES),
    "scene.juxtaposition": row({}, fault=wrong.NAMES),
    "scene.orientation": row({}, name=wrong.NAMES),
    "scene.fault_polygons": row({}, horizon=wrong.NAMES),
    "scene.curves_between": row({"first": "Top"}, second=wrong.NAMES),
    "scene.search": row({"second": "Top"}, first=wrong.NAMES),
    "scene.cutoffs": row({"horizon": "Top", "fault": "F1"}, horizon=[*wrong.NAMES, "F1"],
                         fault=[*wrong.NAMES, "Top"], side=wrong.WORDS),
    "scene.throw": row({"horizon": "Top", "fault": "F1"}, fault=[*wrong.NAMES, "Top"],
                       direction=[*wrong.WORDS, None]),
    "scene.section": row({}, line=[*wrong.ARRAYS, [(0, 0)], [(0, 0), (0, 0)],
                                   [(9e9, 0), (9e9, 9)]]),
    "scene.thickness": row(
        {"zone": "Top/Base", "grid": 1000.0}, zone=wrong.NAMES, kind=[*wrong.WORDS, None],
        contact=["above OWC", 5, ["x"], {}],
        grid=lambda g: [*wrong.LENGTHS, 0, 1e-9, g.top.drop_vars("easting"),
                        g.top.assign_coords(easting=g.top.easting.values * np.nan),
                        g.top.assign_coords(easting=np.array(list("abcde")))],
    ),
    "scene.propose_fault_network": row({}, reach=[*wrong.LENGTHS, 0]),
    "scene.render_pictures": row({"folder": "no"}, folder=[None, 5], x=[1],
                                 views=[5, "abc", [5]]),
    "network.without": row(
        lambda g: {"network": g.network}, lambda network, number: network.without(number),
        number=[*wrong.NUMBERS[:8], None, 99, -1],
    ),
    "network.apply": row({}, scene=wrong.things),
    "network.trial": row({}, scene=wrong.things),
    "units.on": row(lambda g: {"units": g.units}, lambda units, side: units.on(side),
                    side=wrong.NAMES),
    "units.remnants": row({}, min_volume=[*wrong.NUMBERS, None]),
    "patches.surface": row({}, i=[*(v for v in wrong.NAMES if v != 5), 99, -1]),
    "patches.patch": row({}, i=["Nope", None, -1, 9999]),
    "curves.between": row({"first": "Top"}, second=wrong.NAMES),
    "TriSurface": row(
        {}, surface_of, vertices=wrong.ARRAYS, role=wrong.WORDS,
        triangles=[None, "abc", 5, {}, object(), np.zeros(3), [[0, 1, 9]], [[0, 1, -1]],
                   [[0, 1, 0.5]], [[0, 1]], [["a", "b", "c"]], [[0, 1, 2], [0, 1]], [[None] * 3]],
        name=[None, [], {}, object(), 1.5, True], lattice=lambda g: ["abc", 5, g.top, {}],
        vertex_data=["abc", 5, {"x": 5}, {"x": [1, 2]}, {"x": None}],
    ),
    "FaultSticks": row({"name": "F"}, sticks=[v for v in wrong.ARRAYS
                                              if getattr(v, "shape", ()) != (3, 3, 3)]),
}  # fmt: skip
