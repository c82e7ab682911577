"""Wrong things for what builds a model: grids, faults, sheets, scenes and the nouns.

What is called: (with what, wrong things): a list, or a function of `g`, the model
of test_wrong_things.py.
"""

from __future__ import annotations

import numpy as np

import geosurf as gs
from tests.invalid_input import wrong

TRIANGLE = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0]])
FLAGS = ["abc", 5, np.nan, None, [], np.array([1, 2])]


def throw(g, **words):
    return gs.throw_horizon(g.grid, g.faults, {"F1": 20.0}, **words)


def no_mappings(values):
    return [value for value in values if not isinstance(value, dict)]


def model(g, **words):
    return gs.Scene(g.world.horizons, g.world.faults, g.box, **words).units


BUILDING = {
    "triangulate_horizon": (lambda g, v: gs.triangulate_horizon(v),
                            lambda g: wrong.horizons(g.top)),
    "triangulate_horizon.name": (lambda g, v: gs.triangulate_horizon(g.top, name=v),
                                 [["F1"], ("F1",), object(), 1.5, {"a": 1}]),
    "triangulate_horizon.units": (lambda g, v: gs.triangulate_horizon(g.top, length_unit=v),
                                  wrong.WORDS),
    "triangulate_horizon.positive": (lambda g, v: gs.triangulate_horizon(g.top, positive=v),
                                     wrong.WORDS),
    "triangulate_horizon.tolerance": (lambda g, v: gs.triangulate_horizon(g.top, tolerance=v),
                                      wrong.LENGTHS),
    "triangulate_fault": (lambda g, v: gs.triangulate_fault(v, name="F"),
                          lambda g: wrong.faults(g.fault)),
    "triangulate_sticks": (lambda g, v: gs.triangulate_sticks(v, name="F"), wrong.ARRAYS),
    "build_walls": (lambda g, v: gs.build_walls(v), [*wrong.BOXES, None]),
    "build_walls.aoi": (
        lambda g, v: gs.build_walls(g.box, v),
        lambda g: [v for v in wrong.ARRAYS if v is not None]
        + [np.zeros((5, 2)), [[0, 0], [1, 1], [0, 1], [1, 0]], [[0, 0], [1e9, 0], [0, 1e9]]],
    ),
    "build_contacts": (
        lambda g, v: gs.build_contacts(v, g.box),
        lambda g: [*wrong.MAPPINGS[:4], None, *({"OWC": v} for v in wrong.NUMBERS),
                   {"OWC": {"F1+": None}}, {"OWC": g.top[0]}, {"OWC": [-2100.0, -2100.0]}],
    ),
    "build_contacts.box": (lambda g, v: gs.build_contacts({"OWC": -2100.0}, v),
                           [*wrong.BOXES, None]),
    "FluidContact.zones": (lambda g, v: gs.FluidContact(-1.0, v),
                           [5, None, [5], {}, [None], object()]),
    "FluidContact.block": (lambda g, v: gs.FluidContact(-1.0, block=v),
                           [5, None, [5], {}, object()]),
    "FluidContact.name": (lambda g, v: gs.FluidContact(-1.0, name=v), [None, [5], {}, object()]),
    "extend_fault": (lambda g, v: gs.extend_fault(v, g.box), wrong.things),
    "extend_fault.box": (lambda g, v: gs.extend_fault(g.f1, v), [*wrong.BOXES, None]),
    "fault_from_polygons": (
        lambda g, v: gs.fault_from_polygons(v, name="F1"),
        [None, 5, "abc", {}, [], {"Top": None}, {"Top": [[0, 0]]}, {"Top": "abc"}],
    ),
    "fault_from_polygons.lengthen": (
        lambda g, v: gs.fault_from_polygons(
            {"Top": [[0, 0, 0], [-1, 5, 1], [0, 9, 0], [1, 5, -1]]}, name="F1", lengthen=v
        ),
        lambda g: ["abc", -1, {}, [1]],
    ),
    "lengthen_fault": (lambda g, v: gs.lengthen_fault(v, 5.0), wrong.things),
    "split_fault": (lambda g, v: gs.split_fault(v), wrong.things),
    "lengthen_fault.distance": (lambda g, v: gs.lengthen_fault(g.f1, v), [*wrong.LENGTHS, 0, None]),
    "extend_fault.sides": (lambda g, v: gs.extend_fault(g.f1, g.box, sides=v),
                           [5, None, True, "abc", ["abc"], [5], [None], object()]),
    "truncate_faults": (lambda g, v: gs.truncate_faults(v, {"F1": ("F2", "footwall")}),
                        wrong.things),
    "truncate_faults.truncations": (
        lambda g, v: gs.truncate_faults(g.patches, v),
        lambda g: [5, "abc", {"F1": 5}, {"F1": ("F9", "footwall")}, {"F1": ("F1", "footwall")},
                   {"F1": (None, None)}, {"Top": ("F1", "footwall")}, {5: ("F1", "footwall")}],
    ),
    "truncate_faults.whole": (lambda g, v: gs.truncate_faults(g.patches, {}, whole=v),
                              lambda g: [v for v in wrong.things(g) if v is not None]),
    "propose_network": (lambda g, v: gs.propose_network(v), wrong.things),
    "propose_network.box": (lambda g, v: gs.propose_network(g.patches, v), wrong.BOXES),
    "propose_network.reach": (lambda g, v: gs.propose_network(g.patches, reach=v),
                              [*wrong.LENGTHS, 0]),
    "tear_horizon": (lambda g, v: gs.tear_horizon(v, g.faults), lambda g: wrong.horizons(g.grid)),
    "tear_horizon.faults": (
        lambda g, v: gs.tear_horizon(g.grid, v),
        lambda g: ["abc", 5, None, object(), [None], ["F1"], {"F1": "no.vtp"}, {"F1": None},
                   *({"F1": v} for v in wrong.faults(g.fault)[2:9])],
    ),
    "tear_horizon.trim": (lambda g, v: gs.tear_horizon(g.grid, g.faults, trim=v), wrong.LENGTHS),
    "tear_horizon.noise": (lambda g, v: gs.tear_horizon(g.grid, g.faults, noise=v), wrong.LENGTHS),
    "tear_horizon.spacing": (lambda g, v: gs.tear_horizon(g.grid, g.faults, spacing=v),
                             wrong.LENGTHS),
    "tear_horizon.fill_empty_blocks": (
        lambda g, v: gs.tear_horizon(g.grid, g.faults, fill_empty_blocks=v),
        FLAGS,
    ),
    "extend_horizon": (lambda g, v: gs.extend_horizon(v, distance=9.0),
                       lambda g: wrong.horizons(g.grid)),
    "extend_horizon.area": (lambda g, v: gs.extend_horizon(g.grid, v, distance=9.0),
                            [v for v in (*wrong.BOXES, *wrong.ARRAYS) if v is not None]),
    "extend_horizon.distance": (lambda g, v: gs.extend_horizon(g.grid, distance=v),
                                [*wrong.LENGTHS, 0]),
    "extend_horizon.fill_holes": (
        lambda g, v: gs.extend_horizon(g.grid, distance=9.0, fill_holes=v),
        FLAGS,
    ),
    "extend_horizon.faults": (
        lambda g, v: gs.extend_horizon(g.grid, distance=9.0, faults=v),
        ["abc", 5, None, object(), [None], ["F1"], {"F1": "no.vtp"}, {"F1": None}],
    ),
    "propose_trim": (lambda g, v: gs.propose_trim(v, g.faults), lambda g: wrong.horizons(g.grid)),
    "throw_horizon": (lambda g, v: gs.throw_horizon(v, g.faults, {"F1": 20.0}),
                      lambda g: wrong.horizons(g.grid)),
    "throw_horizon.throw": (
        lambda g, v: gs.throw_horizon(g.grid, g.faults, v),
        ["abc", 5, None, [("F1", 5.0)], {"F9": 5.0}, {5: 5.0},
         *({"F1": v} for v in wrong.throws())],
    ),
    "throw_horizon.reach": (lambda g, v: throw(g, reach=v),
                            [*no_mappings(wrong.LENGTHS), {"F9": 9.0}, {"F1": "x"}]),
    "throw_horizon.hanging_wall": (lambda g, v: throw(g, hanging_wall=v),
                                   [*no_mappings(wrong.LENGTHS), 1.5, {"F9": 0.5}, {"F1": "x"}]),
    "throw_horizon.direction": (lambda g, v: throw(g, direction=v),
                                [*wrong.WORDS, {"F1": "x"}, None]),
    "EllipticThrow.largest": (lambda g, v: gs.EllipticThrow(v), [*wrong.NUMBERS, None]),
    "EllipticThrow.half_length": (lambda g, v: gs.EllipticThrow(9.0, v), [*wrong.LENGTHS, 0]),
    "EllipticThrow.half_height": (lambda g, v: gs.EllipticThrow(9.0, None, v), [*wrong.LENGTHS, 0]),
    "EllipticThrow.centre": (
        lambda g, v: gs.EllipticThrow(9.0, centre=v),
        ["abc", 5, None, (1,), (1, 2, 3), ("a", "b"), (np.nan, 1.0), {}, [1j, 2]],
    ),
    "intersect_triangles": (lambda g, v: gs.intersect_triangles(v, TRIANGLE), wrong.ARRAYS),
    "intersect_surfaces": (lambda g, v: gs.intersect_surfaces(v), wrong.things),
    "intersect_surfaces.method": (lambda g, v: gs.intersect_surfaces(g.surfaces, method=v),
                                  wrong.WORDS),
    "intersect_surfaces.voxel_size": (lambda g, v: gs.intersect_surfaces(g.surfaces, voxel_size=v),
                                      [*wrong.LENGTHS, 0]),
    "intersect_surfaces.self_intersections": (
        lambda g, v: gs.intersect_surfaces(g.surfaces, self_intersections=v),
        FLAGS,
    ),
    "rebuild_surfaces": (lambda g, v: gs.rebuild_surfaces(v), wrong.things),
    "trim_sheets": (lambda g, v: gs.trim_sheets(v), wrong.things),
    "carve_units": (lambda g, v: gs.carve_units(v), wrong.things),
    "carve_units.column": (lambda g, v: gs.carve_units(g.patches, v),
                           [5, "abc", [], {"Top": "x"}, {"Top": 5}, {"Nope": "erosional"}]),
    "carve_units.contacts": (
        lambda g, v: gs.carve_units(g.patches, None, v),
        ["abc", 5, None, [5], {"OWC": -1.0}, [gs.FluidContact(-1.0, name="x")], object()],
    ),
    "carve_units.slivers": (lambda g, v: gs.carve_units(g.patches, slivers=v),
                            [v for v in wrong.LENGTHS if not isinstance(v, dict)]),
    "run_ensemble": (lambda g, v: gs.run_ensemble(v, 2, uncertain=[5], progress=False),
                     [None, 5, [], {}, object()]),
    "Scene": (lambda g, v: gs.Scene(v), [*wrong.MAPPINGS[:5], {}]),
    "Scene.horizon": (lambda g, v: gs.Scene({"Top": v}, {}, g.box).surfaces,
                      lambda g: [v for v in wrong.horizons(g.top) if v is not None]),
    "Scene.fault": (lambda g, v: gs.Scene(g.world.horizons, {"F1": v}, g.box).surface("F1"),
                    lambda g: [v for v in wrong.faults(g.fault) if v is not None]),
    "Scene.box": (lambda g, v: gs.Scene(g.world.horizons, {}, v), wrong.BOXES),
    "Scene.column": (lambda g, v: model(g, column=v),
                     [5, "abc", {"Top": "x"}, {"Top": None}, {5: "erosional"}]),
    "Scene.contacts": (
        lambda g, v: model(g, contacts=v),
        lambda g: [*wrong.MAPPINGS[:6], {"Top": -2100.0}, {"OWC": "no.nc"}, {"OWC": g.top[0]},
                   {"OWC": {"F9+": -2100.0}}, {"OWC": gs.FluidContact(None)}, {"OWC": g.scene}],
    ),
    "Scene.aoi": (lambda g, v: model(g, aoi=v), [v for v in wrong.ARRAYS if v is not None]),
    "Scene.positive": (lambda g, v: model(g, positive=v), wrong.WORDS),
    "Scene.length_unit": (lambda g, v: model(g, length_unit=v), wrong.WORDS),
    "Scene.voxel_size": (lambda g, v: model(g, voxel_size=v), wrong.LENGTHS),
    "Scene.self_intersections": (lambda g, v: model(g, self_intersections=v), FLAGS),
    "Scene.lengthen": (lambda g, v: model(g, lengthen=v),
                       [-1, "abc", {"F9": 1}, {"F1": None}, [5]]),
    "Scene.slivers": (lambda g, v: model(g, slivers=v),
                      [-1, "abc", [5], True, {"x": 1}, {"merge": 5}, {"min_volume": "5"}]),
    "Scene.reservoir": (lambda g, v: model(g, reservoir=v),
                        [5, "abc", "Top/Base", [], ["abc"], [5], [None], object()]),
    "Scene.regions": (
        lambda g, v: model(g, regions=v).regions,
        [5, "abc", [], {"A": 5}, {"A": None}, {"A": "no.pol"}, {"A": ("F1",)}, {"A": ("F9+",)},
         {"A": (-9e9, 0.0)}, {"A": [[0, 0], [1, 1]]}, {"": (0, 0)}, {"A": object()}],
    ),
    "Scene.table.by": (lambda g, v: g.scene.table(by=v),
                       [5, "abc", [], ["abc"], ["zone", "zone"], [None], object()]),
    "Scene.table": (lambda g, v: g.scene.table(v), wrong.WORDS),
    "Scene.extend": (lambda g, v: model(g, extend=v),
                     [5, "abc", ["abc"], [5], [None], object(), {"F9": "strike"}, {"F1": 5}]),
    "Scene.truncations": (lambda g, v: model(g, truncations=v),
                          [5, "abc", {"F1": 5}, {"F1": ("F9", "footwall")}, {"F1": (None, None)}]),
    "Scene.tolerance": (lambda g, v: gs.Scene(g.world.horizons, tolerance=v), [*wrong.LENGTHS, 0]),
    "Scene.replace": (
        lambda g, v: g.scene.replace(**v),
        lambda g: [{"x": 1}, {"horizons": 5}, {"faults": []}, {"faults": {"x": None}},
                   {"box": "abc"}, {"column": 5}, {"extend": {"F9": 1}}],
    ),
    **{
        f"Scene.{method}": (
            lambda g, v, method=method: getattr(g.scene, method)(v), wrong.NAMES
        )
        for method in ("surface", "allan", "juxtaposition", "orientation", "thickness",
                       "fault_polygons")
    },
    "Scene.curves_between": (lambda g, v: g.scene.curves_between("Top", v), wrong.NAMES),
    "Scene.search": (lambda g, v: g.scene.search(v, "Top"), wrong.NAMES),
    "Scene.cutoffs": (lambda g, v: g.scene.cutoffs(v, "F1"), [*wrong.NAMES, "F1"]),
    "Scene.cutoffs.fault": (lambda g, v: g.scene.cutoffs("Top", v), [*wrong.NAMES, "Top"]),
    "Scene.cutoffs.side": (lambda g, v: g.scene.cutoffs("Top", "F1", v), wrong.WORDS),
    "Scene.throw": (lambda g, v: g.scene.throw("Top", v), [*wrong.NAMES, "Top"]),
    "Scene.throw.direction": (lambda g, v: g.scene.throw("Top", "F1", direction=v),
                              [*wrong.WORDS, None]),
    "Scene.section": (lambda g, v: g.scene.section(v),
                      [*wrong.ARRAYS, [(0, 0)], [(0, 0), (0, 0)], [(9e9, 0), (9e9, 9)]]),
    "Scene.thickness.grid": (
        lambda g, v: g.scene.thickness("Top/Base", v),
        lambda g: [*wrong.LENGTHS, 0, 1e-9, g.top.drop_vars("easting"),
                   g.top.assign_coords(easting=g.top.easting.values * np.nan),
                   g.top.assign_coords(easting=np.array(list("abcde")))],
    ),
    "Scene.thickness.kind": (lambda g, v: g.scene.thickness("Top/Base", 1000.0, kind=v),
                             [*wrong.WORDS, None]),
    "Scene.thickness.contact": (lambda g, v: g.scene.thickness("Top/Base", 1000.0, contact=v),
                                ["above OWC", 5, ["x"], {}]),
    "Scene.propose_fault_network": (lambda g, v: g.scene.propose_fault_network(reach=v),
                                    [*wrong.LENGTHS, 0]),
    "Scene.render_pictures": (
        lambda g, v: g.scene.render_pictures(**{"folder": "no", **v}),
        [{"folder": None}, {"folder": 5}, {"x": 1}, {"views": 5}, {"views": "abc"}, {"views": [5]}],
    ),
    "FaultNetwork.without": (lambda g, v: g.network.without(v), [*wrong.NUMBERS[:8], None, 99, -1]),
    "FaultNetwork.apply": (lambda g, v: g.network.apply(v), wrong.things),
    "FaultNetwork.trial": (lambda g, v: g.network.trial(v), wrong.things),
    "Units.on": (lambda g, v: g.units.on(v), wrong.NAMES),
    "Units.remnants": (lambda g, v: g.units.remnants(v), [*wrong.NUMBERS, None]),
    "Patches.surface": (lambda g, v: g.patches.surface(v),
                        [*(v for v in wrong.NAMES if v != 5), 99, -1]),
    "Patches.patch": (lambda g, v: g.patches.patch(v), ["Nope", None, -1, 9999]),
    "Curves.between": (lambda g, v: g.scene.curves.between("Top", v), wrong.NAMES),
    "TriSurface.vertices": (lambda g, v: gs.TriSurface("A", "surface", v, [[0, 1, 2]]),
                            wrong.ARRAYS),
    "TriSurface.triangles": (
        lambda g, v: gs.TriSurface("A", "surface", TRIANGLE, v),
        lambda g: [None, "abc", 5, {}, object(), np.zeros(3), [[0, 1, 9]], [[0, 1, -1]],
                   [[0, 1, 0.5]], [[0, 1]], [["a", "b", "c"]], [[0, 1, 2], [0, 1]], [[None] * 3]],
    ),
    "TriSurface.name": (lambda g, v: gs.TriSurface(v, "surface", TRIANGLE, [[0, 1, 2]]),
                        [None, [], {}, object(), 1.5, True]),
    "TriSurface.role": (lambda g, v: gs.TriSurface("A", v, TRIANGLE, [[0, 1, 2]]), wrong.WORDS),
    "TriSurface.lattice": (lambda g, v: gs.TriSurface("A", "surface", lattice=v),
                           lambda g: ["abc", 5, g.top, {}]),
    "TriSurface.vertex_data": (
        lambda g, v: gs.TriSurface("A", "surface", TRIANGLE, [[0, 1, 2]], vertex_data=v),
        ["abc", 5, {"x": 5}, {"x": [1, 2]}, {"x": None}],
    ),
    "FaultSticks": (lambda g, v: gs.FaultSticks("F", v),
                    [v for v in wrong.ARRAYS if getattr(v, "shape", ()) != (3, 3, 3)]),
}  # fmt: skip
