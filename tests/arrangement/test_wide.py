"""Wide triangles are followed along their planes: no pair that meets is left out."""

from __future__ import annotations

import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from geosurf.arrangement import triangles
from geosurf.arrangement.candidates import fit_voxels
from geosurf.kernels.contacts.triangle_contact import N_COLUMN, meet_pairs
from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.search.separation import large_triangle_pairs
from geosurf.kernels.search.voxels import fill_voxels, triangle_boxes

corner = st.tuples(*[st.integers(0, 12)] * 3)


@st.composite
def meshes(draw):
    """Small triangles and large ones over whole numbers, none without area."""
    small = [
        [
            tuple(np.add(at, step))
            for step in draw(st.tuples(*[st.tuples(*[st.integers(0, 1)] * 3)] * 3))
        ]
        for at in draw(st.lists(corner, max_size=12))
    ]
    large = draw(st.lists(st.tuples(corner, corner, corner), min_size=1, max_size=4))
    x = np.array([*small, *large], dtype=float).reshape(-1, 3)
    t = np.arange(len(x)).reshape(-1, 3)
    area = np.cross(x[t[:, 1]] - x[t[:, 0]], x[t[:, 2]] - x[t[:, 0]])
    return x, t[area.any(axis=1)]


def meets(x, t, pairs):
    m, w = frame_of(x, len(t))
    rows = np.empty((len(pairs) + 1, N_COLUMN), dtype=np.int64)
    n, _ = meet_pairs(x, t, pairs, m, w, 0.0, rows, np.empty(0, dtype=np.int64))
    return {tuple(pair) for pair in rows[:n, :2].tolist()}


@settings(deadline=None)
@given(meshes(), st.sampled_from([0.7, 2.0, 5.0]), st.sampled_from([0.0, 500_000.25]))
def test_every_pair_that_meets_is_found_once(mesh, size, shift):
    x, t = mesh
    x = x + shift
    if len(t) == 0:
        return
    boxes = triangle_boxes(x, t)
    grid = fit_voxels(boxes, boxes, size)
    wide = (boxes[:, 3:] - boxes[:, :3]).max(axis=1) > 1.5
    offsets, filled = fill_voxels(boxes, np.flatnonzero(~wide), grid.bounds, grid.size, grid.shape)
    found = large_triangle_pairs(
        x, t, boxes, np.flatnonzero(wide), grid.bounds, grid.size, grid.shape, offsets, filled
    )  # fmt: skip
    named = [tuple(pair) for pair in found.tolist()]
    assert len(set(named)) == len(named)
    every = [p for p in itertools.combinations(range(len(t)), 2) if wide[p[0]] or wide[p[1]]]
    assert meets(x, t, np.array(every, dtype=np.int64).reshape(-1, 2)) <= set(named)


def test_walls_of_a_turned_area_ask_few_triangles():
    """Two upright walls across a plane of small triangles: pairs follow the walls' length."""
    n = 60
    a = np.arange(n * n)
    x = np.stack([a % n, a // n, 0.01 * (a % 7)], axis=1).astype(float)
    cell = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    low = np.stack([cell, cell + 1, cell + n], axis=1)
    high = np.stack([cell + 1, cell + n + 1, cell + n], axis=1)
    wall = np.array(
        [[0, 30, -9], [59, 31.5, -9], [30, 30, 9], [30, 0, -9], [31, 59, -9], [29, 30, 9.0]]
    )
    x = np.concatenate([x, wall])
    t = np.concatenate([low, high, n * n + np.arange(6).reshape(2, 3)])
    pairs = triangles._near_pairs(x, t, len(t), np.full(len(t), -1))
    walls = (pairs >= len(t) - 2).any(axis=1).sum()
    assert n < walls < 12 * n
    assert len(triangles.crossing_pairs(x, t)) > n
