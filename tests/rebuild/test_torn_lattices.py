"""Torn sheets as lattices with gaps give what their lists of triangles give, bit for bit."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import geosurf as gs
from geosurf import (
    Lattice,
    Scene,
    TriSurface,
    rebuild_surfaces,
    throw_horizon,
    triangulate_fault,
    trim_sheets,
)
from geosurf.model.torn_lattice import TornLattice
from geosurf.rebuild import repair
from geosurf.rebuild.repair import moved_surface, rounded, shifted
from geosurf.synthetic import graben
from tests.strategies import as_list


def holed(horizon):
    """A horizon without the nodes of one corner, and without one near a side."""
    z = horizon.copy()
    z[:4, :3] = np.nan
    z[2, 12] = np.nan
    return z


def thrown(n, holes):
    """A graben whose horizons are thrown by both faults, which cut them in different places."""
    world = gs.synthetic.graben(n=n)
    faults = {name: world.faults[name] for name in ("F1", "F2")}
    sheets = {}
    for k, name in enumerate(("Top", "Base")):
        horizon = holed(world.horizons[name]) if holes else world.horizons[name]
        throw = {"F1": 40.0 + 11.0 * k, "F2": 25.0}
        sheets[name] = gs.throw_horizon(horizon, faults, throw, name=name)
    west, east, south, north, bottom, top = world.box
    if holes:  # inside of what is left
        west, south = west + 0.3 * (east - west), south + 0.3 * (north - south)
    return sheets, faults, (west, east, south, north, bottom, top)


def torn(n, kind="normal"):
    """A world whose gridded horizons were smeared over faults with tips inside."""
    world = gs.synthetic.torn(kind, n=n)
    sheets = {
        name: gs.tear_horizon(horizon, world.faults, name=name)
        for name, horizon in world.horizons.items()
    }
    return sheets, world.faults, world.box


WORLDS = {
    "thrown": lambda: thrown(25, False),
    "absent nodes": lambda: thrown(25, True),
    "torn": lambda: torn(31),
    # whole triangles between both walls, which are dropped in runs
    "wide gap": lambda: torn(31, "gentle"),
}


def as_lists(monkeypatch):
    monkeypatch.setattr(repair, "with_torn_lattices", lambda contacts: contacts)


def results_of(sheets, faults, box):
    """A scene of sheets of which nothing is remembered, its units, and lines of its certificate."""
    scene = gs.Scene({name: replace(one) for name, one in sheets.items()}, faults, box)
    units = [(u.name, u.zone, u.block, u.volume, u.area, u.map_area) for u in scene.units.values()]
    return scene, units, [(check.name, check.passed) for check in scene.check().checks]


@pytest.mark.parametrize("kind", WORLDS)
def test_models_of_lattices_are_those_of_lists(kind, monkeypatch):
    world = WORLDS[kind]()
    scene, units, checks = results_of(*world)
    found = scene.patches
    assert sum(isinstance(one.lattice, TornLattice) for one in found.sources) == len(world[0])
    # runs hold most of it, also after the parts beyond the faults are gone
    assert len(found.pieces.triangles) < 0.8 * found.n_triangle
    assert all(passed for _, passed in checks)

    as_lists(monkeypatch)
    scene, expected_units, expected_checks = results_of(*world)
    expected = scene.patches
    assert not any(isinstance(one.lattice, TornLattice) for one in expected.sources)
    for name in ("surface_of_triangle", "parent_of_triangle", "patch_of_triangle"):
        assert np.array_equal(getattr(found, name), getattr(expected, name)), name
    assert np.array_equal(found.local[found.triangles], expected.local[expected.triangles])
    assert found.report == expected.report
    # the same edges of curves, and each place is one vertex in both
    assert len(found.local) == len(expected.local) == len(np.unique(found.local, axis=0))
    edges = [
        np.unique(np.sort(one.local.view("f8,f8,f8").ravel()[one.curve_edges], axis=1))
        for one in (found, expected)
    ]
    assert np.array_equal(*edges)
    assert [one[:3] for one in units] == [one[:3] for one in expected_units]
    # sums of areas and volumes are in another order
    for one, two in zip(units, expected_units, strict=True):
        assert one[3:] == pytest.approx(two[3:], rel=1e-13)
    assert checks == expected_checks


# ---- Surfaces with vertices that a repair moved: grids stay grids, and nothing else changes.
NONE = [np.empty(0)] * 3


def grid(easting, northing, **words):
    z = np.add.outer(np.sin(northing.mean(axis=-1) if northing.ndim == 2 else northing),
                     np.cos(easting.mean(axis=0) if easting.ndim == 2 else easting))  # fmt: skip
    z.flat[3] = np.nan
    return TriSurface("H", "horizon", lattice=Lattice(easting, northing, z / 3.0, **words))


def grids():
    axis = np.arange(6) / 3.0
    x, y = np.meshgrid(axis, axis)
    yield grid(axis, axis)
    yield grid(axis[::-1].copy(), axis, rising=False)
    yield grid(0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y)
    yield grid(x, y, reverse=True)


@pytest.mark.parametrize("surface", list(grids()))
@pytest.mark.parametrize("step", [2.0**-28, 2.0**-4])
def test_a_moved_grid_is_the_moved_list(surface, step):
    marked = np.random.default_rng(3).random(surface.n_vertex) < 0.2
    rows = np.flatnonzero(marked)
    ours = moved_surface(surface, rows, rounded, step, NONE)
    theirs = moved_surface(as_list(surface), rows, rounded, step, NONE)
    assert ours.lattice is not None
    assert theirs.lattice is None
    np.testing.assert_array_equal(ours.vertices, theirs.vertices)
    np.testing.assert_array_equal(ours.triangles, theirs.triangles)
    still = (ours.vertices == surface.vertices).all(axis=1)
    assert still[~marked].all()
    assert not still[marked].all()


def test_a_grid_with_a_shut_triangle_becomes_a_list():
    axis = np.array([0.0, 0.26, 0.3, 1.0])
    surface = TriSurface("H", "horizon", lattice=Lattice(axis, axis, np.zeros((4, 4))))
    made = moved_surface(surface, np.arange(16), rounded, 0.25, NONE)
    assert made.lattice is None
    assert made.n_triangle < surface.n_triangle


def test_what_is_held_stays_and_what_is_near_comes_to_it():
    axis = np.arange(4) / 3.0
    surface = TriSurface("H", "horizon", lattice=Lattice(axis, axis, np.ones((4, 4)) / 3.0))
    held = [axis[1:2] + 2.0**-40, np.empty(0), np.array([0.0, 1.0 / 3.0])]
    made = moved_surface(surface, np.arange(16), rounded, 2.0**-4, held)
    np.testing.assert_array_equal(made.vertices[:, 2], 1.0 / 3.0)
    x, y = (np.unique(made.vertices[:, k]).tolist() for k in (0, 1))
    assert x == [0.0, axis[1] + 2.0**-40, 0.6875, 1.0]
    assert y == [0.0, 0.3125, 0.6875, 1.0]


def test_a_model_with_a_repair_keeps_its_grids_and_their_reference_system():
    """The box lies next to nodes at thirds: only the last digit differs."""
    axis = np.arange(31) * (10.0 / 30.0)
    z = np.add.outer(0.1 * np.sin(axis), 0.1 * np.cos(axis))
    top = TriSurface("Top", "horizon", lattice=Lattice(axis, axis, z))
    low = TriSurface("Low", "horizon", lattice=Lattice(axis, axis, z - 2.0))
    tilted = [[3.1, -1, -6], [3.1, 11, -6], [5.3, 11, 6], [5.3, -1, 6]]
    fault = TriSurface("F", "fault", tilted, [[0, 1, 2], [0, 2, 3]])
    top.crs = low.crs = "EPSG:23031"
    box = (axis[3] + 2.0**-52, 9.0, 1.0, 9.0, -5.0, 5.0)
    scene = Scene({"Top": top, "Low": low}, {"F": fault}, box)
    assert scene.patches.report["moved_vertices"] > 0
    for source in scene.patches.sources[:2]:
        assert source.lattice is not None
        assert source.crs == "EPSG:23031"
    assert scene.check().ok


def torn_sheet(holes):
    """A horizon that a fault tears, its ghosts, and the fault."""
    world = graben(n=25)
    data = world.horizons["Top"].copy()
    if holes:
        data[:4, :3] = np.nan
    fault = world.faults["F1"]
    return throw_horizon(data, {"F1": fault}, {"F1": 40.0}, name="Top").surface, fault


@pytest.mark.parametrize("holes", [False, True])
@pytest.mark.parametrize("step", [2.0**-28, 2.0**-4])
def test_a_moved_torn_sheet_is_the_moved_list_and_stays_a_lattice(holes, step):
    surface, fault = torn_sheet(holes)
    rng = np.random.default_rng(7)
    n_ghost = len(surface.torn.ghosts)
    rows = np.sort(rng.choice(surface.n_vertex, 30, replace=False))
    rows = np.union1d(rows, surface.n_vertex - n_ghost + rng.choice(n_ghost, 9, replace=False))

    shaken = shifted if step < 1e-3 else rounded  # nodes are on round numbers
    move = partial(shaken, draw=1) if shaken is shifted else shaken
    ours = moved_surface(surface, rows, move, step, NONE)
    marks, arrays = surface.vertex_data, (surface.vertices, surface.triangles)
    given = TriSurface("Top", "horizon", *arrays, vertex_data=marks)
    theirs = moved_surface(given, rows, move, step, NONE)
    assert isinstance(ours.torn, TornLattice)
    assert theirs.torn is None
    assert ours.vertices.tobytes() == theirs.vertices.tobytes()
    assert (ours.vertices != surface.vertices).any()
    assert ours.triangles.tobytes() == theirs.triangles.tobytes()
    assert all(np.array_equal(of, theirs.vertex_data[key]) for key, of in ours.vertex_data.items())

    # and so is what a model makes of it
    one, two = (trim_sheets(rebuild_surfaces([sheet, triangulate_fault(fault, name="F1")]))
                for sheet in (ours, theirs))  # fmt: skip
    assert one.pieces.strips[0] is not None
    ends = [mesh.local[mesh.curve_edges].tobytes() for mesh in (one, two)]
    assert ends[0] == ends[1]
    assert one.local[one.triangles].tobytes() == two.local[two.triangles].tobytes()
    for part in ("surface_of_triangle", "patch_of_triangle"):
        assert getattr(one, part).tobytes() == getattr(two, part).tobytes()
