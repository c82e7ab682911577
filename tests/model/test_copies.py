"""Copies, pickles and threads: what is handed out can be handed on."""

from __future__ import annotations

import copy
import html
import pickle
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import geosurf as gs
from geosurf import Lattice, TriSurface, rebuild_surfaces
from geosurf.carve.certificate import certify
from geosurf.conventions import volume_text
from tests import laws

WAYS = {"pickled": lambda one: pickle.loads(pickle.dumps(one)), "copied": copy.deepcopy}


def made():
    world = gs.synthetic.graben(n=9)
    height = world.box[4] + 0.6 * (world.box[5] - world.box[4])
    return gs.Scene(world.horizons, world.faults, world.box, contacts={"OWC": height})


def told(scene):
    """Volumes, curves and the sides of faults of a scene."""
    units = {name: (unit.volume, unit.area, unit.fault_sides) for name, unit in scene.units.items()}
    return units, laws.curve_bytes(scene.curves), scene.units.sides.tobytes()


@pytest.fixture(scope="module")
def scene():
    return made()


@pytest.fixture(params=WAYS)
def again(request):
    return WAYS[request.param]


@pytest.mark.parametrize("asked", [False, True])
def test_scenes(again, asked, scene):
    """Also one that nobody has asked anything: its copies work by themselves."""
    other = again(scene if asked else made())
    assert other.explain() == ""
    assert told(other) == told(scene)
    assert told(other.replace(faults={"F1": None})) == told(scene.replace(faults={"F1": None}))


class Area:
    """A polygon as shapely has it."""

    geom_type, interiors, has_z = "Polygon", (), False

    def __init__(self, ring):
        self.exterior = self
        self.coords = ring
        self.__geo_interface__ = {"type": "Polygon", "coordinates": [ring]}


@cache
def inputs_of_kinds():
    """Inputs of a graben in the forms that users have, by name."""
    world = gs.synthetic.graben(n=9)
    top, box = world.horizons["Top"], world.box
    fault = gs.triangulate_fault(world.faults["F1"], name="F1")
    table = {"well": ["A", "B"], "horizon": ["Top", "Top"], "easting": [900.0, 2000.0]}
    table |= {"northing": [900.0, 700.0], "elevation": [-2100.0, -2200.0]}
    flat = (top * 0.0 - 2100.0).assign_attrs(top.attrs)
    area = [(500.0, 300.0), (3500.0, 300.0), (3500.0, 1700.0), (500.0, 1700.0)]
    return {
        "contact object": {"box": box, "contacts": {"OWC": gs.FluidContact(flat, "Top/Middle")}},
        "table of tops": {"box": box, "tops": pd.DataFrame(table), "tie": {"range": 2000}},
        "polygon": {"aoi": Area(area)},
        "pyvista": {"box": box, "faults": {"F1": fault.to_pyvista()}},
        "compartments": {"box": box, "compartments": True},
    }


@pytest.mark.parametrize("kind", inputs_of_kinds())
@pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
def test_scenes_of_any_inputs_travel_with_their_results(kind):
    world = gs.synthetic.graben(n=9)
    given = {"faults": world.faults} | inputs_of_kinds()[kind]
    scene = gs.Scene(world.horizons, **given)
    assert scene.check().ok
    _ = scene.section([(600, 600), (2000, 900)]), scene.thickness("Top/Middle"), scene.tops
    one = scene.replace(tolerance=0.5)
    for again in WAYS.values():
        other = again(scene)
        assert other.volumes.identical(scene.volumes)
        two = other.replace(tolerance=0.5)
        assert two.volumes.identical(one.volumes)
        assert [str(w) for w in two.warnings] == [str(w) for w in one.warnings]


def test_units(again):
    fresh = made()
    units = again(fresh.units)
    for name, unit in fresh.units.items():
        one = units[name]
        assert (one.volume, one.area, one.fault_sides) == (unit.volume, unit.area, unit.fault_sides)
        np.testing.assert_array_equal(one.vertices, unit.vertices)
        np.testing.assert_array_equal(one.triangles, unit.triangles)
        assert again(unit).fault_sides == unit.fault_sides
    np.testing.assert_array_equal(units.sides, fresh.units.sides)
    assert units.table.identical(fresh.units.table)


def test_scenes_in_threads_and_one_scene_in_threads(scene):
    with ThreadPoolExecutor(4) as pool:
        apart = list(pool.map(lambda _: told(made()), range(4)))
        shared = made()
        common = list(pool.map(told, [shared] * 4))
    assert apart == common == [told(scene)] * 4


def arrays_of(one, path="", seen=None):
    """Arrays that can be reached by public names, by path."""
    seen = set() if seen is None else seen
    if id(one) in seen:
        return
    seen.add(id(one))
    if isinstance(one, np.ndarray):
        yield path, one
    elif isinstance(one, list | tuple | dict):
        for key, part in one.items() if isinstance(one, dict) else enumerate(one):
            yield from arrays_of(part, f"{path}[{key}]", seen)
    elif type(one).__module__.startswith("geosurf.model"):
        for key, part in vars(one).items():
            if not key.startswith("_") and key not in ("survey", "pieces"):
                yield from arrays_of(part, f"{path}.{key}", seen)


def test_what_is_handed_out_cannot_be_changed(again):
    """Also what a sheet knows of its faults, masks of vertices and of nodes."""
    world = gs.synthetic.graben(n=21)
    sheet = gs.throw_horizon(world.horizons["Top"], world.faults, {"F1": 30.0})
    faults = {fault.name: fault for fault in sheet.faults}
    own = np.zeros(4)
    plain = gs.TriSurface(
        "A", "surface", np.eye(4, 3), [[0, 1, 2], [0, 1, 3]], vertex_data={"own": own}
    )
    own[:] = 1.0
    assert not plain.vertex_data["own"].any()
    scene = gs.Scene({"Top": sheet}, faults, world.box)
    assert sheet.lattice.present.all()
    assert sheet.ghost.any()
    for one in (sheet, scene.patches, scene.curves, plain):
        for twin in (one, again(one)):
            found = dict(arrays_of(twin))
            assert len(found) > 2
            assert [path for path, array in found.items() if array.flags.writeable] == []
    for one in (next(iter(scene.units.values())), scene.surface("F1")):
        for twin in (one, again(one)):
            assert not twin.vertices.flags.writeable
            assert not twin.triangles.flags.writeable


# ---- Which curve edges each surface has: triangles in runs have none.
def by_triangles(patches):
    """A slow oracle: all edges of all triangles of each surface."""
    edges = {tuple(sorted(edge)): row for row, edge in enumerate(patches.curve_edges.tolist())}
    found = [set() for _ in patches.sources]
    for of, (a, b, c) in zip(
        patches.surface_of_triangle.tolist(), patches.triangles.tolist(), strict=True
    ):
        for edge in ((a, b), (b, c), (c, a)):
            row = edges.get(tuple(sorted(edge)))
            if row is not None:
                found[of].add(row)
    return [sorted(rows) for rows in found]


def steps(seed: int) -> list[TriSurface]:
    """Horizons of whole elevations, and vertical faults along lines of their nodes, or not."""
    rng = np.random.default_rng(seed)
    axis = np.arange(9.0)
    made = []
    for k in range(2):
        z = rng.integers(-1, 2, (9, 9)) + 2.0 * k
        made.append(
            TriSurface(f"H{k}", "horizon", lattice=Lattice(axis, axis, z, bool(rng.integers(2))))
        )
    for k in range(2):
        x, y = rng.integers(1, 8, (2, 2)) + rng.choice([0.0, 0.5])
        corners = [[x[0], -1, -9], [x[1], 10, -9], [x[1], 10, 9], [x[0], -1, 9]]
        if k:
            corners = [[-1, y[0], -9], [10, y[1], -9], [10, y[1], 9], [-1, y[0], 9]]
        made.append(TriSurface(f"F{k}", "fault", corners, [[0, 1, 2], [0, 2, 3]]))
    return made


@pytest.mark.parametrize("seed", range(12))
def test_edges_of_each_surface_are_those_of_all_its_triangles(seed):
    patches = rebuild_surfaces(steps(seed))
    found = patches.curve_edges_by_surface
    assert "triangles" not in patches.__dict__
    assert [rows.tolist() for rows in found] == by_triangles(patches)


# ---- What a notebook shows at the end of a cell: every noun in words, none as a heap of arrays.
@pytest.fixture(scope="module")
def shown():
    world = gs.synthetic.torn("normal", n=31)
    sheet = gs.tear_horizon(world.horizons["Top"], world.faults)
    planes = gs.synthetic.graben(n=9)
    contacts = {"OWC": planes.box[4] + 0.6 * (planes.box[5] - planes.box[4])}
    scene = gs.Scene(planes.horizons, planes.faults, planes.box, contacts=contacts)
    thrown = gs.throw_horizon(planes.horizons["Top"], planes.faults, {"F1": 20.0})
    return {
        "world": world,
        "sheet": sheet,
        "sheet report": sheet.report,
        "cut": sheet.cuts["F1"],
        "lattice": sheet.lattice,
        "trim": gs.TrimProposal(2.0, 1.0, (8.0, 3.0)),
        "throw report": thrown.report,
        "scene": scene,
        "surface": scene.surface("F1"),
        "curves": scene.curves,
        "search": scene.search("Top", "F1"),
        "patches": scene.patches,
        "units": scene.units,
        "unit": next(iter(scene.units.values())),
        "certificate": scene.check(),
    }


def test_every_noun_is_shown_in_words(shown):
    for key, noun in shown.items():
        words = repr(noun)
        assert "object at 0x" not in words, key
        assert "array(" not in words, key
        assert "float64" not in words, key
        assert len(words.splitlines()) <= 45, key
        assert max(map(len, words.splitlines())) <= 160, key


def test_units_are_a_table_that_adds_up(shown):
    units = shown["units"].included()
    head, *rows, total, slivers, left = str(shown["units"]).splitlines()
    assert head.split() == ["zone", "region", "block", "contact", "GRV"]
    assert len(rows) == len(units) - len(units.slivers) == len(units.without_slivers)
    assert slivers == units.slivers_in_words
    for row, unit in zip(rows, units.without_slivers, strict=True):
        assert row.startswith(unit.zone)
        assert unit.block in row
        assert unit.contact in row
        assert row.endswith(volume_text(unit.volume, 4))
    assert total == f"{len(units)} units, GRV {volume_text(units.volume)}"
    rest = volume_text(shown["units"].volume - units.volume)
    n_left = len(shown["units"]) - len(units)
    words = f"Not shown: {n_left} units outside the reservoir, {rest}. units.table lists them."
    assert left == words
    assert "contact" not in str(gs.carve_units(gs.rebuild_surfaces(gs.build_walls(units.box))))


def test_a_certificate_names_the_units_that_are_no_balls():
    """A ring around a shaft: Euler number 0, named beside those that have 2."""
    box, shaft = gs.build_walls((0, 9, 0, 9, -9, 0)), gs.build_walls((3, 6, 3, 6, -9, 0))[:4]
    walls = [gs.TriSurface(f"F{i}", "fault", s.vertices, s.triangles) for i, s in enumerate(shaft)]
    patches = gs.rebuild_surfaces([*walls, *box])
    closed = certify(patches, gs.carve_units(patches)).checks[0]
    assert closed.passed
    assert closed.detail.startswith("2 units, 0 open edges; Euler number 2, but ")
    assert closed.detail.endswith(" 0")


def test_volumes_that_end_at_the_box_are_told_with_the_box(tmp_path: Path) -> None:
    world = gs.synthetic.tilted_planes(n=5)
    one = gs.Scene({"Top": world.horizons["Top"]}, {}, world.box)
    words = (
        "'above Top' and 'below Top' end at the model box, elevation -2500 to -1700 m: their GRV"
    )
    page = gs.report_scene(one, tmp_path).read_text(encoding="utf-8")
    for shown in (str(one.units), one.units._repr_html_(), page):
        assert html.unescape(shown).count(words) == 1
    cut = one.replace(contacts={"OWC": -2050.0}).units
    assert "'above Top, above OWC' and 'below Top, below OWC' end at" in str(cut)
    several = gs.Scene(world.horizons, world.faults, world.box).units
    assert "end at the model box" not in str(several)
    assert "'above Top' and 'below Base' end at" in several.included("all").ends_at_box
