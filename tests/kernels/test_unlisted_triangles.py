"""Triangles of a lattice near another surface are marked: at least those that meet it."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf.arrangement.tree import Tree, tree_of_list
from geosurf.kernels.contacts.triangle_contact import N_COLUMN, meet_pairs
from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.lattices.unlisted_triangles import mark_near, unlisted_boxes
from geosurf.model import Lattice

NONE = np.empty(0, dtype=bool)


def tree_over(lattice, free):
    none = np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=np.int64)
    boxes = unlisted_boxes(*lattice.coordinates, lattice.places, free)
    return Tree(lattice.coordinates, lattice.places, *none, *boxes)


def corners(lattice, n):
    nodes = lattice.corners_of_keys(np.arange(n)).ravel()
    return lattice.places_of_nodes(nodes).reshape(-1, 3, 3)


def pairs_that_meet(one, two):
    """Rows of both that meet, by exact signs, each with each."""
    both = np.concatenate([one, two])
    x, t = both.reshape(-1, 3), np.arange(3 * len(both)).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(len(one)), np.arange(len(two)), indexing="ij")
    pairs = np.column_stack([i.ravel(), len(one) + j.ravel()])
    m, w = frame_of(x, len(t))
    rows = np.empty((len(pairs) + 1, N_COLUMN), dtype=np.int64)
    n, _ = meet_pairs(x, t, pairs, m, w, 0.0, rows, np.empty(0, dtype=np.int64))
    return rows[:n, 0], rows[:n, 1] - len(one)


@pytest.mark.parametrize("seed", range(3))
def test_what_meets_is_marked(seed):
    rng = np.random.default_rng(seed)
    n_row, n_col = rng.integers(3, 12, 2)
    x, y = np.meshgrid(np.arange(n_col) / 4, np.arange(n_row) / 4)
    flat = Lattice(x[0], y[:, 0], rng.integers(0, 8, x.shape) / 8, bool(seed % 2))
    steep = Lattice(2.0 + rng.integers(0, 8, x.shape) / 8, y, x - 1.0, True, False)
    n = 2 * (n_row - 1) * (n_col - 1)
    free_flat, free_steep = rng.random(n) < 0.6, rng.random(n) < 0.6
    one, two = tree_over(flat, free_flat), tree_over(steep, free_steep)
    i, j = pairs_that_meet(corners(flat, n), corners(steep, n))

    # two lattices: pairs of unlisted triangles
    hit, hit_steep = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool)
    given = *one.coordinates, one.places, one.nodes, one.levels, free_flat
    mark_near(*given, hit, *two.arguments(), free_steep, hit_steep)
    both = free_flat[i] & free_steep[j]
    assert hit[i[both]].all()
    assert hit_steep[j[both]].all()
    assert not (hit & ~free_flat).any()
    assert not (hit_steep & ~free_steep).any()

    # a list: all of its triangles
    listed = corners(steep, n)
    hit = np.zeros(n, dtype=bool)
    as_list = tree_of_list(listed.reshape(-1, 3), np.arange(3 * n).reshape(-1, 3))
    mark_near(*given, hit, *as_list.arguments(), NONE, NONE)
    assert hit[i[free_flat[i]]].all()
    assert not (hit & ~free_flat).any()
