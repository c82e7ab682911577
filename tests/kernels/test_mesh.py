"""Rings of half-edges, against a dictionary of edges."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf.kernels.meshes.mesh import edges, ends_of, join_patches


def assert_rings(t: np.ndarray, n_vertex: int) -> None:
    """Walking along `ring` from a half-edge visits all those between the same two vertices."""
    expected = defaultdict(set)
    for i in range(3 * len(t)):
        expected[frozenset((t[i // 3, i % 3], t[i // 3, (i + 1) % 3]))].add(i)
    ring, count = edges(t, n_vertex)
    assert count == len(expected)
    for members in expected.values():
        start = i = min(members)
        visited = {start}
        while ring[i] != start:
            i = int(ring[i])
            assert i not in visited
            visited.add(i)
        assert visited == members


triangles = st.lists(st.permutations(range(9)).map(lambda p: p[:3]), max_size=80)


@given(triangles)
def test_any_triangles(rows):
    assert_rings(np.array(rows, dtype=np.int64).reshape(-1, 3), 9)


@pytest.mark.parametrize("hub", [0, 70, 199])
def test_a_corner_of_many_triangles(hub):
    """A fan, once open, once with every triangle twice: the hub's edges are too many to search."""
    rim = np.setdiff1d(np.arange(200), [hub])
    fan = np.stack([np.full(len(rim) - 1, hub), rim[:-1], rim[1:]], axis=1)
    for t in (fan, np.concatenate([fan, fan[::-1, ::-1]]), np.concatenate([fan, fan[50:90]])):
        assert_rings(np.ascontiguousarray(t), 200)


def oracle_of_patches(t, owners):
    """Patches and rim by a dictionary of edges, for triangles no two of which coincide."""
    around = defaultdict(list)
    for i, corners in enumerate(t.tolist()):
        for c in range(3):
            around[frozenset((corners[c], corners[(c + 1) % 3]))].append(i)
    label = list(range(len(t)))
    rim = set()
    for edge, of in around.items():
        if len(of) == 2 and owners[of[0]] == owners[of[1]]:
            label = [min(label[of[0]], label[of[1]]) if x in (label[of[0]], label[of[1]]) else x
                     for x in label]  # fmt: skip
        if len(of) > 2 or len({owners[i] for i in of}) > 1:
            rim.add(tuple(sorted(edge)))
    numbers = {}
    return [numbers.setdefault(x, len(numbers)) for x in label], rim


@given(st.sets(st.frozensets(st.integers(0, 6), min_size=3, max_size=3), min_size=1, max_size=30))
def test_patches_end_where_owners_change_or_sheets_meet(triangles):
    t = np.array([sorted(corners) for corners in sorted(triangles, key=sorted)], dtype=np.int64)
    owners = t.sum(axis=1) % 2
    ring, _ = edges(t, 7)
    expected, edges_of_rim = oracle_of_patches(t, owners)
    found = join_patches(owners, owners, ring, np.arange(len(t)))
    none = join_patches(owners, owners, ring, np.empty(0, dtype=np.int64))
    assert [one.tolist() for one in none] == [one.tolist() for one in found]
    assert found[0].tolist() == expected
    assert len(found[1]) == len(edges_of_rim)
    assert (np.diff(found[1]) > 0).all()
    assert set(map(tuple, ends_of(t, found[1]).tolist())) == edges_of_rim
