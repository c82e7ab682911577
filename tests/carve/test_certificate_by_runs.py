"""A certificate by runs has the lines of one by single triangles, for sound and damaged models."""

from __future__ import annotations

import re
import threading
from collections import Counter
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

import geosurf as gs
from geosurf import Lattice, TriSurface, build_walls, carve_units, rebuild_surfaces
from geosurf.carve.certificate import certify, certify_repeated, same_bytes
from geosurf.carve.certificate_lines import euler_in_words
from geosurf.carve.shells import CarvedUnit
from geosurf.errors import OpenUnitError
from geosurf.kernels.lattices.strips import FIRST, LAST, ROW
from geosurf.model import Patches, Units
from geosurf.model.torn_lattice import TornLattice
from tests.rebuild.worlds import boxed_world
from tests.strategies import BOX

FIELDS = (
    "name", "zone", "zone_index", "block", "contact", "beneath", "origin", "surface_names",
    "volume", "area", "fault_sides",
)  # fmt: skip


def level(name, z, n=22, rising=True):
    """A bent horizon over the box [0, 4] x [0, 4] and beyond."""
    axis = np.linspace(-0.6, 4.7, n)
    x, y = np.meshgrid(axis, axis)
    bent = z + 0.2 * np.sin(x + z) * np.cos(1.3 * y)
    return TriSurface(name, "horizon", lattice=Lattice(axis, axis, bent, rising))


def fault(name, low, high, south=-1.0, north=5.0, n=9):
    """A fault between two eastings at its top and base."""
    s, t = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n))
    x, z = low + (high - low) * s + 0.1 * np.sin(3 * t), 9.0 - 14.0 * s
    return TriSurface(
        name, "fault", lattice=Lattice(x, south + (north - south) * t, z, True, False)
    )


def surfaces(seed=0):
    rng = np.random.default_rng(seed)
    tops = [level("Top", 3 + rng.random()), level("Base", rng.random(), rising=bool(seed % 2))]
    if seed % 3 == 1:
        tops.append(level("Low", -2.0, 17))
    faults = [fault("F1", 1.1 + rng.random(), 2.3)]
    if seed % 3:
        faults.append(fault("F2", 2.6, 1.7 + rng.random(), south=1.0 + seed % 2))  # ends inside
    return [*tops, *faults, *build_walls(BOX)]


@pytest.fixture(scope="module")
def model():
    patches = rebuild_surfaces(surfaces())
    return patches, carve_units(patches)


def lines(checks):
    """Lines without the digits that depend on the order of sums."""
    digits = r"[-\d.]+e[-+]\d+|(?<=units )[\d.]+"
    return [(c.name, c.passed, re.sub(digits, "#", c.detail)) for c in checks]


def listed(patches, units):
    """The same model with every triangle by itself."""

    def of(some):
        parts = [replace(unit, triangles=unit.triangles) for unit in some.values()]
        return Units(
            parts, some.box, slivers=some.sliver_settings, merged=some.merged,
            unmerged=None if some.unmerged is None else of(some.unmerged),
        )  # fmt: skip

    return patches.changed(), of(units)


def assert_runs_say_what_triangles_say(patches, units):
    fast = certify(patches, units)
    assert fast.ok
    assert "local" not in patches.__dict__  # nothing was listed
    assert lines(fast.checks) == lines(certify(*listed(patches, units)).checks)


@pytest.mark.parametrize("seed", [1, 3, 5])
def test_lines_by_runs_are_those_by_triangles(seed):
    patches = rebuild_surfaces(surfaces(seed))
    units = carve_units(patches, slivers={"merge": True} if seed == 5 else None)
    assert_runs_say_what_triangles_say(patches, units)
    assert same_bytes(patches, rebuild_surfaces(surfaces(seed))).passed


@pytest.mark.parametrize("lacking", [None, 1])
def test_the_second_run_waits_where_memory_holds_one_only(monkeypatch, lacking):
    certificate = import_module("geosurf.carve.certificate")
    monkeypatch.setattr(certificate, "MANY", 0)
    monkeypatch.setenv("GEOSURF_THREADS", "2")
    patches = rebuild_surfaces(surfaces(1))
    room = certificate.ROOM * len(patches.pieces.triangles)
    monkeypatch.setattr(certificate, "lack_of_room", lambda n: lacking if n > room else None)
    units, ran_in = carve_units(patches), []

    def rebuild():
        ran_in.append(threading.current_thread())
        return rebuild_surfaces(surfaces(1))

    found = certify_repeated(patches, units, rebuild)
    assert (ran_in == [threading.main_thread()]) == (lacking is not None)
    assert found.ok
    monkeypatch.setenv("GEOSURF_THREADS", "1")
    assert certify_repeated(patches, units, rebuild) == found


def test_random_worlds_of_lattices_and_lists():
    for seed in range(12):
        patches = rebuild_surfaces([*boxed_world(seed), *build_walls(BOX)], self_intersections=True)
        try:
            units = carve_units(patches)
        except OpenUnitError:
            continue
        fast = certify(patches, units).checks
        assert lines(fast) == lines(certify(*listed(patches, units)).checks), seed


def counts_of(t):
    """Open edges and Euler number of some triangles, by dictionaries."""
    ways = Counter()
    for one, two in zip(t.ravel().tolist(), t[:, [1, 2, 0]].ravel().tolist(), strict=True):
        ways[min(one, two), max(one, two)] += 1 if one < two else -1
    return sum(map(abs, ways.values())), len(np.unique(t)) - len(ways) + len(t)


@pytest.mark.parametrize("seed", range(4))
def test_open_edges_and_euler_numbers_are_those_of_dictionaries(seed):
    """Of worlds with handles and with surfaces that touch in edges and corners."""
    patches = rebuild_surfaces(surfaces(seed))
    units = carve_units(patches)
    true = {name: counts_of(unit.triangles) for name, unit in units.items()}
    assert not any(n_open for n_open, _ in true.values())
    words = euler_in_words({name: euler for name, (_, euler) in true.items()})
    for found in (certify(patches, units), certify(*listed(patches, units))):
        assert found.checks[0].detail == f"{len(units)} units, 0 open edges; {words}"
    torn = {name: unit.triangles[3 * (k % 2) :] for k, (name, unit) in enumerate(units.items())}
    parts = [replace(unit, triangles=torn[name]) for name, unit in units.items()]
    n_open = sum(counts_of(t)[0] for t in torn.values())
    detail = certify(patches, Units(parts, units.box)).checks[0].detail
    assert detail.startswith(f"{n_open} open edges in {', '.join(list(units)[1::2])}")


def built(patches, units, *, face=None, order=None, **arrays):
    """A model with other arrays in its pieces; units state what they stated."""
    pieces = replace(patches.pieces, **arrays)
    new = Patches.of_pieces(pieces, patches.curve_edges, patches.report)
    shells = next(iter(units.values()))._shell[0]
    cells = replace(
        shells.cells, patches=new, pieces=pieces,
        face_of_element=shells.cells.face_of_element if face is None else face,
    )  # fmt: skip
    shells = replace(shells, cells=cells)
    rows = [unit._shell[1] for unit in units.values()]
    rows = rows if order is None else [rows[k] for k in order]
    made = [
        CarvedUnit((shells, u), None, **{name: getattr(unit, name) for name in FIELDS})
        for u, unit in zip(rows, units.values(), strict=True)
    ]
    return new, Units(made, units.box)


def longest_run(patches, surface=0):
    """A run in the middle of a surface."""
    runs = patches.pieces.strips[surface].runs
    length = np.where(np.abs(runs[:, ROW] - 10) < 4, runs[:, LAST] - runs[:, FIRST], -1)
    return int(length.argmax())


def with_runs(patches, end, by):
    """Strips of the first surface, a run with another end."""
    strips = list(patches.pieces.strips)
    runs = strips[0].runs.copy()
    runs[longest_run(patches), end] += by
    strips[0] = replace(strips[0], runs=runs)
    return {"strips": strips}


def rows_changed(patches, units, change):
    """Arrays of triangles with rows deleted or repeated."""
    pieces, shells = patches.pieces, next(iter(units.values()))._shell[0]
    names = ("triangles", "surface", "key", "patch")
    arrays = {name: change(getattr(pieces, name)) for name in names}
    return {**arrays, "face": change(shells.cells.face_of_element)}


def inner(patches, units):
    """A listed triangle of the first surface that bounds units."""
    shells = next(iter(units.values()))._shell[0]
    face = shells.cells.face_of_element[: len(patches.pieces.triangles)]
    return int(np.flatnonzero((patches.pieces.surface == 0) & (face >= 0))[7])


def damage(kind, patches, units):
    """Keywords of `built` for one kind of damage."""
    pieces, row = patches.pieces, inner(patches, units)
    shells = next(iter(units.values()))._shell[0]
    if kind.startswith("run"):
        end = LAST if "end" in kind else FIRST
        way = 1 if ("long" in kind) == (end == LAST) else -1
        return with_runs(patches, end, way)
    if kind == "flipped":
        triangles = pieces.triangles.copy()
        triangles[row] = triangles[row, ::-1]
        return {"triangles": triangles}
    if kind == "removed":
        return rows_changed(patches, units, lambda a: np.delete(a, row, axis=0))
    if kind == "doubled":
        return rows_changed(patches, units, lambda a: np.insert(a, row, a[row], axis=0))
    if kind in ("point moved", "node moved"):
        x = pieces.x.copy()
        some = pieces.strips[0].points if kind == "node moved" else pieces.triangles[row]
        x[some[len(some) // 2]] += (0.0, 0.0, 1e-3)
        return {"x": x}
    if kind == "one copy moved":
        x, triangles = np.concatenate([pieces.x, pieces.x[:1]]), pieces.triangles.copy()
        x[-1] = pieces.x[triangles[row, 0]] + (0.0, 0.0, 1e-9)
        triangles[row, 0] = len(x) - 1
        return {"x": x, "triangles": triangles}
    if kind == "one vertex in two":
        x, triangles = np.concatenate([pieces.x, pieces.x[:1]]), pieces.triangles.copy()
        x[-1] = pieces.x[triangles[row, 0]]
        triangles[row, 0] = len(x) - 1
        return {"x": x, "triangles": triangles}
    if kind == "run of another unit":
        face = shells.cells.face_of_element.copy()
        at = len(pieces.triangles) + longest_run(patches)
        others = shells.sides[face[at]]
        far = np.flatnonzero((shells.sides != others).all(axis=1) & (shells.sides >= 0).all(axis=1))
        face[at] = far[0]
        return {"face": face}
    if kind == "units exchanged":
        return {"order": [1, 0, *range(2, len(units))]}

    # a horizon that crosses another one, or the roof, in the middle of a run
    sources, i = list(pieces.sources), int(kind == "crossing in a run")
    old = sources[i].lattice
    z = old.elevation.copy()
    z[10, 14] += 20.0
    lattice = Lattice(old.easting, old.northing, z, old.rising)
    sources[i] = TriSurface(sources[i].name, "horizon", lattice=lattice)
    return {"sources": sources}


KINDS = [
    "run too long at its end", "run too short at its end", "run too long", "run too short",
    "flipped", "removed", "doubled", "point moved", "node moved", "one copy moved",
    "one vertex in two", "run of another unit", "units exchanged", "crossing in a run",
    "horizon through the roof",
]  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_damage_is_found_by_runs_and_on_the_lines_of_triangles(model, kind):
    patches, units = built(*model, **damage(kind, *model))
    found = certify(patches, units)
    bad = {check.name for check in found.checks if not check.passed}
    assert bad
    slow = certify(*listed(patches, units)).checks
    assert {check.name for check in slow if not check.passed} == bad


# ---- Certificates of torn horizons by runs: copies at faults are listed, and what is near the
CROSSES = "surfaces meet only along shared edges"


def torn_scene(kind: str, n: int = 61) -> gs.Scene:
    world = gs.synthetic.torn(kind, n=n)
    return gs.Scene(world.horizons, world.faults, world.box, tear=True)


@pytest.mark.parametrize("kind", ["reverse", "scissors", "acute Y", "X"])
def test_lines_by_runs_are_those_by_triangles_certificate_of_torn(kind):
    scene = torn_scene(kind)
    patches, units = scene.patches, scene.units
    assert any(isinstance(source.lattice, TornLattice) for source in patches.sources)
    assert_runs_say_what_triangles_say(patches, units)


@pytest.mark.parametrize("side", [1, -1])
def test_a_copy_that_crosses_its_own_horizon_far_from_the_fault_is_found(side):
    sources = torn_scene("normal", 41).patches.sources
    lattice = next(one.lattice for one in sources if isinstance(one.lattice, TornLattice))
    step, z = lattice.easting[1] - lattice.easting[0], lattice.elevation

    # a ghost amid the fault, over or below the other wall, is moved along this wall by eight cells
    # and a little through it: its copies cross triangles there, and none next to the fault
    apart = side * (lattice.ghosts[:, 2] - z.ravel()[lattice.node_of_ghost])
    far = np.abs(lattice.ghosts[:, 1] - np.median(lattice.ghosts[:, 1]))
    ghost = np.where(apart > 0.5 * apart.max(), far, np.inf).argmin()
    row, col = np.divmod(lattice.node_of_ghost[ghost], z.shape[1])
    own = lattice.copies[(lattice.copies == z.size + ghost).any(axis=1)]
    nodes = own[own < z.size] % z.shape[1]
    col += 8 if nodes.mean() < col else -8
    ghosts = lattice.ghosts.copy()
    ghosts[ghost] = lattice.easting[col], lattice.northing[row], z[row, col]
    ghosts[ghost, 2] -= 0.2 * side * apart[ghost]
    plain = gs.Lattice(lattice.easting, lattice.northing, lattice.elevation, lattice.rising)
    spoiled = TornLattice.of(plain, lattice.gone, lattice.copies, ghosts)
    found = {}
    for name, of in (("good", lattice), ("spoiled", spoiled)):
        top = TriSurface("Top", "horizon", lattice=of)
        low, high = of.extent
        wall = TriSurface(
            "F1", "fault", [[low[0], low[1] - 9, -9e4], [high[0], low[1] - 9, -9e4],
                            [low[0], low[1] + 0.3 * step, 9e4]], [[0, 1, 2]],
        )  # fmt: skip
        patches = rebuild_surfaces([top, wall])  # the rim of the horizon is cut, nothing else
        found[name] = {check.name: check.passed for check in certify(patches).checks}
        slow = {c.name: c.passed for c in certify(patches.changed()).checks}
        assert found[name] == slow
    assert found["good"][CROSSES]
    assert not found["spoiled"][CROSSES]
