"""Parts of sheets between faults, and their walls, against plain loops over all pairs."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.meshes.parts import balance_at_fault, join_past_others


def half_edges(rng, n_triangle, n_edge):
    """Random half-edges, triangle by triangle; surfaces, patches and parents of the triangles."""
    triangle = np.sort(rng.integers(0, n_triangle, 3 * n_triangle))
    edge = rng.integers(0, n_edge, len(triangle))
    surface = np.sort(rng.integers(0, 3, n_triangle))
    return edge, triangle, surface, rng.integers(0, 9, n_triangle)


@pytest.mark.parametrize("seed", range(6))
def test_patches_are_joined_past_edges_without_a_fault(seed):
    rng = np.random.default_rng([88, seed])
    n_edge = (6, 30)[seed % 2]
    edge, triangle, surface, parent = half_edges(rng, 20, n_edge)
    patch, fault = rng.permutation(20), rng.random(n_edge) < 0.3
    found = join_past_others(edge, triangle, fault, surface, patch, parent, 1, 20)

    label = np.arange(20)
    for _ in range(20):
        for e in np.flatnonzero(~fault):
            rows = triangle[(edge == e) & (surface[triangle] == 1)]
            for a in rows:
                for b in rows:
                    if len(rows) == 2 or parent[a] == parent[b]:
                        low = min(label[patch[a]], label[patch[b]])
                        label[patch[a]] = label[patch[b]] = low
    # numbered by the first patch of each
    assert np.array_equal(found, np.unique(label, return_inverse=True)[1])
    assert seed % 2 or len(np.unique(found)) < 20


@pytest.mark.parametrize("seed", range(6))
def test_edges_count_by_the_side_of_the_fault_that_their_triangle_is_on(seed):
    rng = np.random.default_rng([89, seed])
    x, n_edge = rng.integers(-9, 9, (12, 3)).astype(float), 8
    ends = np.array([rng.choice(12, 2, replace=False) for _ in range(n_edge)])
    edge, triangle, surface, _ = half_edges(rng, 20, n_edge)
    # each triangle has one edge, and a third corner
    edge = rng.integers(0, n_edge, 20)[triangle]
    t = np.array([
        [*ends[e], rng.choice(np.setdiff1d(np.arange(12), ends[e]))]
        for e in [edge[np.searchsorted(triangle, k) % len(edge)] for k in range(20)]
    ])  # fmt: skip
    t = np.array([np.roll(row, rng.integers(3)) for row in t])
    part, parent = rng.integers(0, 4, 20), rng.integers(0, 5, 20)
    faces, wall = rng.integers(0, 12, (5, 3)), rng.choice([-1, 1], 12)
    faces[:3] = faces[:3, :1]  # corners in one wall
    given = x, t, ends, edge, triangle, surface, part, parent, wall, faces
    found = balance_at_fault(*given, 1, 2, 4, *frame_of(x))

    expected = np.zeros(4)
    for e, a in zip(edge, triangle, strict=True):
        walls = {int(wall[v]) for v in faces[parent[a]]}
        if surface[a] != 1 or len(walls) > 1:
            continue
        corner = x[next(v for v in t[a] if v not in ends[e])]
        for f, b in zip(edge, triangle, strict=True):
            if f == e and surface[b] == 2:
                p, q, r = x[t[b]]
                side = np.sign(np.rint(np.dot(np.cross(q - p, r - p), corner - p)))
                length = np.linalg.norm(x[ends[e, 1]] - x[ends[e, 0]])
                expected[part[a]] += length * side * sum(walls)
    assert found == pytest.approx(expected)
    assert expected.any() or seed
