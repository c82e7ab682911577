"""Passes over shells, each against a slow and obvious one, on small numbers with many ties."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from geosurf.arrangement.triangles import crossing_pairs
from geosurf.kernels.meshes.mesh import renumbered
from geosurf.kernels.meshes.shells import (
    copies_of_parents,
    count_open_edges,
    number_triangles,
    sums_of_triangles,
)

N = 6  # vertices: with so few, triangles and edges come several times


@st.composite
def triangles(draw, most=40):
    """Triangles of three different vertices below N."""
    t = draw(hnp.arrays(np.int64, st.tuples(st.integers(0, most), st.just(3)), elements=_vertex))
    return t[[len(set(row)) == 3 for row in t.tolist()]] if len(t) else t.reshape(0, 3)


_vertex = st.integers(0, N - 1)


def fan(n):
    """Triangles around one vertex: more than a short bucket holds."""
    return np.stack([np.zeros(n, int), 1 + np.arange(n), 1 + (1 + np.arange(n)) % n], axis=1)


@given(triangles())
def test_triangles_have_one_number_for_each_set_of_corners(t):
    number, rising, n, n_all = number_triangles(t, len(t))
    known: dict[frozenset, int] = {}
    wanted = [known.setdefault(frozenset(row), len(known)) for row in t.tolist()]
    assert number.tolist() == wanted
    assert n == n_all == len(known)

    # of the first ones alone, and how many more sets the others have
    half = len(t) // 2
    some = number_triangles(t, half)
    assert [one.tolist() for one in some[:2]] == [wanted[:half], rising.tolist()[:half]]
    assert some[2:] == (len(set(wanted[:half])), len(known))
    for row, up in zip(t.tolist(), rising.tolist(), strict=True):
        low = row.index(min(row))
        assert up == (row[(low + 1) % 3] < row[(low + 2) % 3])


def open_edges_by_counting(t):
    ways = Counter((row[c], row[(c + 1) % 3]) for row in t.tolist() for c in range(3))
    edges = {(min(edge), max(edge)) for edge in ways}
    off = sum(abs(ways[a, b] - ways[b, a]) for a, b in edges)
    return off, len(edges), len(set(t.ravel().tolist()))


@given(triangles())
def test_open_edges_are_those_run_through_more_often_one_way(t):
    assert count_open_edges(t, N) == open_edges_by_counting(t)


@pytest.mark.parametrize("closed", [False, True])
def test_open_edges_of_a_long_bucket(closed):
    t = fan(100)
    other = t[:, [0, 2, 1]].copy()
    other[other == 0] = 101  # the other pole of a spindle
    t = np.concatenate([t, other]) if closed else t
    assert count_open_edges(t, 102) == open_edges_by_counting(t)
    assert (count_open_edges(t, 102)[0] == 0) == closed


@given(triangles(12), hnp.arrays(np.float64, (N, 3), elements=st.integers(-9, 9).map(float)))
def test_sums_are_those_of_rational_numbers(t, x):
    t = np.concatenate([t, t[:, [0, 2, 1]][: len(t) // 2]])
    volume, area, products, sides = sums_of_triangles(x, t)
    corners = x[t]
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(u, v)
    lengths = [abs(u), abs(v), abs(u - v)]
    assert area == pytest.approx(0.5 * np.linalg.norm(normal, axis=1).sum(), rel=1e-14)
    assert products == (abs(u).sum(axis=1) * abs(v).sum(axis=1)).sum()
    assert sides == sum(length.sum() for length in lengths)

    # around the middle, in halves: exact
    used = x[t.ravel()]
    middle = 0.5 * (used.min(axis=0) + used.max(axis=0)) if len(t) else np.zeros(3)
    terms = ((corners[:, 0] - middle) * normal).ravel().tolist()
    assert volume == float(sum(map(Fraction, terms), Fraction(0)) / 6)


def test_copies_may_start_at_another_corner_but_not_be_turned_over():
    y = np.array([[5.0, 5, 5], [6, 5, 5], [5, 6, 5], [5, 5, 6]])
    x = np.concatenate([y - 5.0, [[1.0, 0, 2.0**-50]]])
    faces = np.array([[0, 1, 2], [0, 1, 3]])
    t = np.array([[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [0, 1, 3], [0, 4, 3], [0, 1, 2]])
    parent = np.array([0, 0, 0, 0, 1, 1, 1])
    found = copies_of_parents(x, t, (y[faces[parent]] - 5.0).reshape(-1, 9))
    assert found.tolist() == [True, True, True, False, True, False, False]


@pytest.mark.parametrize("span", [10, 10_000])
def test_numbers_are_renumbered_in_order_in_small_and_large_ranges(span):
    t = np.random.default_rng(7).integers(3, 3 + span, (9, 3))
    used, place = renumbered(t)
    np.testing.assert_array_equal(used, np.unique(t))
    np.testing.assert_array_equal(used[place], t)


@given(st.integers(0, 2**32 - 1))
def test_parts_of_a_graph_are_skipped_and_nothing_else(seed):
    """A bent grid and loose triangles through it: the same pairs with and without the graph."""
    rng = np.random.default_rng(seed)
    n = 6
    gx, gy = np.meshgrid(np.arange(n), np.arange(n))
    x = np.stack([gx, gy, rng.integers(0, 3, (n, n))], axis=2).reshape(-1, 3).astype(float)
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    grid = np.concatenate([np.stack([a, a + 1, a + n + 1], 1), np.stack([a, a + n + 1, a + n], 1)])
    loose = rng.integers(0, n, (5, 3, 3)).astype(float)
    flat = np.cross(loose[:, 1] - loose[:, 0], loose[:, 2] - loose[:, 0])
    loose = loose[(flat != 0).any(axis=1)]
    x = np.concatenate([x, loose.reshape(-1, 3)])
    t = np.concatenate([grid, n * n + np.arange(3 * len(loose)).reshape(-1, 3)])
    graph = np.where(np.arange(len(t)) < len(grid), 0, -1)
    np.testing.assert_array_equal(crossing_pairs(x, t, graph=graph), crossing_pairs(x, t))
