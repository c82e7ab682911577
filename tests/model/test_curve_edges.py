"""Which curve edges each surface has: triangles in runs have none."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf import Lattice, TriSurface, rebuild_surfaces


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


def test_curves_of_a_torn_scene_list_no_triangles():
    world = gs.synthetic.torn("normal", n=41)
    scene = gs.Scene(world.horizons, world.faults, world.box, tear=True)
    assert scene.curves.n_curve
    assert min(scene.coverage.values()) > 0
    assert not {"local", "triangles"} & set(scene.patches.__dict__)
    for source in scene.patches.sources:
        assert source.role != "horizon" or not {"vertices", "triangles"} & set(source.__dict__)
    found = scene.patches.curve_edges_by_surface
    assert [rows.tolist() for rows in found] == by_triangles(scene.patches)


@pytest.mark.parametrize("kind", ["normal", "reverse", "acute Y"])
def test_bounds_of_a_torn_horizon_list_no_triangles(kind):
    world = gs.synthetic.torn(kind, n=41)
    scene = gs.Scene(world.horizons, world.faults, world.box, tear=True)
    found = scene.whole_surface(scene.horizon_names[0])
    bounds = found.bounds
    assert not {"vertices", "triangles"} & set(found.__dict__)
    assert bounds == TriSurface("Top", "horizon", found.vertices, found.triangles).bounds
