"""Rings of half-edges, against a dictionary of edges."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf.kernels.mesh import edges


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
