"""Sides of edges and what corners tell, against loops over everything."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf.kernels.meshes.mesh import edges, kept_triangles
from geosurf.kernels.sheets.torn_links import classify_parts, sides_of_edges
from geosurf.model.pieces import FREE, PAIRED

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


@pytest.mark.parametrize("is_named", [True, False])
@given(TRIANGLES, st.lists(st.booleans(), min_size=N, max_size=N), st.integers(0, 2**32 - 1))
def test_what_corners_tell(is_named, triangles, outer, seed):
    # as in patches: points have numbers of their own, and are vertices of the sheet by place
    random = np.random.default_rng(seed)
    n, outer = len(triangles), np.array(outer)
    ghost, on_fault = outer | (random.random(N) < 0.4), random.random(N) < 0.3
    vertices = random.permutation(3 * N).reshape(N, 3).astype(np.float64)
    point, origin = random.permutation(N), np.array([1.0, 2.0, 0.0])
    local = vertices[point] - origin
    local[random.random(N) < 0.3, 2] += 0.5  # a point that was made
    t = np.array(triangles, dtype=np.int64).reshape(-1, 3)
    faces = np.array([random.permutation(N)[:3] for _ in range(4)])
    parent, patch = random.integers(0, 4, n), random.integers(0, 5, n)
    part_of = random.integers(0, 3, 5)
    held, beyond, expected = [False] * 5, [False] * 5, np.full((n, 3), -1)
    for k in range(n):
        face, p = faces[parent[k]], int(part_of[patch[k]])
        held[p] |= not ghost[face].any()
        for c in range(3):
            same = [v for v in face.tolist() if (local[t[k, c]] == vertices[v] - origin).all()]
            if same:
                expected[k, c] = same[0]
                if not on_fault[t[k, c]]:
                    held[p] |= not ghost[same[0]]
                    beyond[p] |= bool(outer[same[0]])
    named = np.zeros((n if is_named else 0, 3), dtype=np.int64)
    found = classify_parts(
        local, t, parent, faces, vertices, origin, on_fault, ghost, outer, patch, part_of, named
    )
    assert [mask.tolist() for mask in found] == [held, beyond]
    if is_named:
        assert named.tolist() == expected.tolist()


@given(TRIANGLES, st.integers(0, 2**32 - 1))
def test_rings_of_what_stays(triangles, seed):
    t = np.array(triangles, dtype=np.int64).reshape(-1, 3)
    keep = np.random.default_rng(seed).random(len(t)) < 0.6
    ring, _ = edges(t, N)
    link = np.where(ring == np.arange(len(ring)), FREE, PAIRED)
    link[(link == FREE) & (np.arange(len(ring)) % 5 == 0)] = 7  # a run goes on there
    rows = np.flatnonzero(keep)
    surface, key, patch = np.random.default_rng(seed).integers(0, 6, (3, len(t)))
    patch_of = np.array([3, 0, 5, 1, 1, 2])
    corners, *named, found, onward, number = kept_triangles(
        keep, t, surface, key, patch, patch_of, ring, link, N
    )
    used = np.unique(t[rows])
    assert np.flatnonzero(number >= 0).tolist() == used.tolist()
    assert number[used].tolist() == list(range(len(used)))
    assert corners.tolist() == number[t[rows]].tolist()
    assert [one.tolist() for one in named] == [
        one.tolist() for one in (surface[rows], key[rows], patch_of[patch[rows]])
    ]
    expected, _ = edges(np.ascontiguousarray(t[rows]), N)
    assert found.tolist() == expected.tolist()
    before = link.reshape(-1, 3)[rows].ravel()
    alone = expected == np.arange(len(expected))
    assert onward.tolist() == np.where(alone & (before == PAIRED), FREE, before).tolist()
