"""Sides of edges and what corners tell, against loops over everything."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from geosurf.kernels.sheets.sheet_trim import classify_parts, sides_of_edges

N = 6
TRIANGLES = st.lists(st.permutations(range(N)).map(lambda p: p[:3]), max_size=40)
EDGES = st.lists(st.sampled_from(list(combinations(range(N), 2))), unique=True)


@given(TRIANGLES, EDGES, st.randoms())
def test_sides_of_edges(triangles, edges, random):
    turned = [edge if random.random() < 0.5 else edge[::-1] for edge in edges]
    expected = []
    for row, t in enumerate(triangles):
        for k in range(3):
            side = tuple(sorted((t[k], t[(k + 1) % 3])))
            if side in edges:
                expected.append((edges.index(side), row))
    of = np.array(turned, dtype=np.int64).reshape(-1, 2)
    t = np.array(triangles, dtype=np.int64).reshape(-1, 3)
    edge, triangle = sides_of_edges(t, of, N)
    assert list(zip(edge.tolist(), triangle.tolist(), strict=True)) == expected


@given(TRIANGLES, st.lists(st.booleans(), min_size=N, max_size=N), st.integers(0, 2**32 - 1))
def test_what_corners_tell(triangles, outer, seed):
    random = np.random.default_rng(seed)
    n, outer = len(triangles), np.array(outer)
    ghost = outer | (random.random(N) < 0.4)
    on_fault = random.random(N) < 0.3
    t = np.array(triangles, dtype=np.int64).reshape(-1, 3)
    rows = np.flatnonzero(random.random(n) < 0.8)
    named = np.where(random.random((len(rows), 3)) < 0.3, -1, random.integers(0, N, (len(rows), 3)))
    faces, part = random.integers(0, N, (len(rows), 3)), random.integers(0, 3, len(rows))
    held, beyond = {0: False, 1: False, 2: False}, {0: False, 1: False, 2: False}
    for k, row in enumerate(rows.tolist()):
        p = int(part[k])
        held[p] |= not ghost[faces[k]].any()
        for c in range(3):
            v = named[k, c]
            if v >= 0 and not on_fault[t[row, c]]:
                held[p] |= not ghost[v]
                beyond[p] |= bool(outer[v])
    found = classify_parts(t, rows, named, faces, on_fault, ghost, outer, part, 3)
    assert [mask.tolist() for mask in found] == [list(held.values()), list(beyond.values())]
