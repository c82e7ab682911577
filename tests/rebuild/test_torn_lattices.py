"""Torn sheets as lattices with gaps give what their lists of triangles give, bit for bit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import geosurf as gs
from geosurf.model.torn_lattice import TornLattice
from geosurf.rebuild import repair


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


def surfaces_of(world):
    """The torn meshes made anew, so that nothing is remembered on them, and the faults."""
    sheets, faults, _ = world
    return [gs.model.Sheet.surface.func(one) for one in sheets.values()] + [
        gs.triangulate_fault(fault, name=name) for name, fault in faults.items()
    ]


@pytest.mark.parametrize("kind", WORLDS)
def test_patches_of_lattices_are_those_of_lists(kind, monkeypatch):
    world = WORLDS[kind]()
    found = rebuild(world)
    assert sum(isinstance(one.lattice, TornLattice) for one in found.sources) == len(world[0])
    # runs hold most of it, also after the parts beyond the faults are gone
    assert len(found.pieces.triangles) < 0.8 * found.n_triangle
    as_lists(monkeypatch)
    expected = rebuild(world)
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


def rebuild(world):
    return gs.trim_sheets(gs.rebuild_surfaces(surfaces_of(world)))


@pytest.mark.parametrize("kind", WORLDS)
def test_units_and_their_certificate_are_those_of_lists(kind, monkeypatch):
    sheets, faults, box = WORLDS[kind]()

    def results():
        scene = gs.Scene({k: replace(one) for k, one in sheets.items()}, faults, box)
        units = [(u.name, u.zone, u.block, u.volume, u.area, u.map_area) for u in
                 scene.units.values()]  # fmt: skip
        certificate = scene.check()
        return scene, units, [(check.name, check.passed) for check in certificate.checks]

    scene, units, checks = results()
    assert all(passed for _, passed in checks)
    assert any(strips is not None and len(strips.runs)
               for source, strips in zip(scene.patches.sources, scene.patches.pieces.strips,
                                         strict=True)
               if isinstance(source.lattice, TornLattice))  # fmt: skip
    as_lists(monkeypatch)
    _, expected, expected_checks = results()
    assert [one[:3] for one in units] == [one[:3] for one in expected]
    # sums of areas and volumes are in another order
    for one, two in zip(units, expected, strict=True):
        assert one[3:] == pytest.approx(two[3:], rel=1e-13)
    assert checks == expected_checks
