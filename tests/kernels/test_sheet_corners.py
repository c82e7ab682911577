"""Triangles of a torn sheet over one another in the map, against clipping in rationals."""

from __future__ import annotations

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.sheets.torn_links import are_over_nodes, edges_over_ghosts, overlap_in_map
from tests import oracles
from tests.strategies import UTM, triangles

BOTH = np.array([[0, 1]])


def lie_over_one_another(P, Q) -> bool:
    """Ask the kernel; equal corners are one vertex."""
    x = np.concatenate([P, Q])
    first = np.array([np.flatnonzero((x == point).all(axis=1))[0] for point in x])
    found = overlap_in_map(x, first.reshape(2, 3), BOTH, *frame_of(x))
    return bool(found[0])


def has_more_in_common(P, Q) -> bool:
    """In the map: an area, or a segment that is not an edge of both, with its heights."""
    corners = oracles.meet_triangles(P * (1, 1, 0), Q * (1, 1, 0))
    if len(corners) != 2:
        return len(corners) > 2
    ends = {(float(x), float(y)) for x, y, _ in corners}
    shared = set(map(tuple, P.tolist())) & set(map(tuple, Q.tolist()))
    return not ends <= {(x, y) for x, y, _ in shared}


@settings(max_examples=400, deadline=None)
@given(triangles(), triangles(), st.booleans())
def test_over_one_another_in_the_map(P, Q, far):
    P, Q = (np.array(corners, dtype=float) for corners in (P, Q))
    flat = P * (1, 1, 0), Q * (1, 1, 0)
    upright = any(oracles.flat(corners) for corners in flat)
    shift = np.array(UTM) if far else 0.0
    found = lie_over_one_another(P + shift, Q + shift)
    assert found == (upright or has_more_in_common(P, Q))


@settings(max_examples=200, deadline=None)
@given(triangles(), triangles(), st.integers(0, 2))
def test_triangles_with_a_corner_in_common_in_the_map(P, Q, k):
    P, Q = (np.array(corners, dtype=float) for corners in (P, Q))
    Q += (*(P[0] - Q[k])[:2], 0.0)
    flat = P * (1, 1, 0), Q * (1, 1, 0)
    assume(not any(oracles.flat(corners) for corners in flat))
    assert lie_over_one_another(P, Q) == has_more_in_common(P, Q)


def test_neighbours_on_a_turned_lattice_are_beside_one_another():
    step = np.array([[31.7, 12.3], [-12.3, 31.7]])
    uv = np.stack(np.meshgrid(np.arange(4), np.arange(4)), axis=-1).reshape(-1, 2)
    x = np.column_stack([uv @ step + UTM[:2], np.arange(16.0) % 5])
    lower_left = (np.arange(3)[:, None] * 4 + np.arange(3)).ravel()
    t = np.concatenate([lower_left[:, None] + (0, 1, 4), lower_left[:, None] + (1, 5, 4)])
    i, j = np.triu_indices(len(t), 1)
    assert not overlap_in_map(x, t, np.stack([i, j], axis=1), *frame_of(x)).any()


@given(st.integers(0, 2**32 - 1))
def test_edges_over_nodes_below_ghosts(seed):
    rng = np.random.default_rng(seed)
    n, n_node = 9, 6
    node, ghost = rng.integers(0, n_node, n), rng.random(n) < 0.2
    t = np.array([rng.permutation(n)[:3] for _ in range(12)])
    under = {int(node[v]) for row in t if ghost[row].any() for v in row}
    expected = []
    for i, row in enumerate(t.tolist()):
        for a, b in zip(row, row[1:] + row[:1], strict=True):
            if node[a] in under and node[b] in under:
                expected.append((i, b, a) if node[a] > node[b] else (i, a, b))
    found = edges_over_ghosts(t, node, ghost, n_node)
    assert list(zip(*(part.tolist() for part in found), strict=True)) == expected

    # one place for each node, until one vertex moves
    vertices = rng.normal(size=(n_node, 3))[node]
    vertices[:, 2] = rng.normal(size=n)
    assert are_over_nodes(node, vertices, n_node).all()
    vertices[0, 1] += 1.0
    alone = (node == node[0]).sum() == 1
    assert bool(are_over_nodes(node, vertices, n_node)[0]) == alone
