"""Welding, edges and connected pieces of triangle meshes, by integer keys.

Notation
    x      coordinates, float64 (n_vertex, 3)
    t      triangles, int64 (n_triangle, 3)
    half-edge 3 * i + c of triangle i runs from corner c to the next
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels._jit import entry, scalar
from geosurf.kernels.points import hash_of_place


@entry("d2 -> l1 l")
def weld(x):
    """Number of the first vertex with equal coordinates, renumbered from 0, and how many."""
    n = x.shape[0]
    size = 16
    while size < 2 * n:
        size *= 2
    slots = np.full(size, -1, dtype=np.int64)
    number = np.empty(n, dtype=np.int64)
    count = 0
    for i in range(n):
        slot = hash_of_place(x[i, 0], x[i, 1], x[i, 2]) & (size - 1)
        while slots[slot] >= 0:
            j = slots[slot]
            if x[j, 0] == x[i, 0] and x[j, 1] == x[i, 1] and x[j, 2] == x[i, 2]:
                break
            slot = (slot + 1) & (size - 1)
        if slots[slot] < 0:
            slots[slot] = i
            number[i] = count
            count += 1
        else:
            number[i] = number[slots[slot]]
    return number, count


@entry("l2 -> l1 l1 l")
def edges(t):
    """Edge number of each half-edge, half-edges of each edge (linked), number of edges.

    (edge_of_half, next_half, n_edge): `next_half` leads round the half-edges of one edge.
    """
    n = 3 * t.shape[0]
    size = 16
    while size < 2 * n:
        size *= 2
    slots = np.full(size, -1, dtype=np.int64)
    edge = np.empty(n, dtype=np.int64)
    ring = np.empty(n, dtype=np.int64)
    count = 0
    for i in range(n):
        a = t[i // 3, i % 3]
        b = t[i // 3, (i + 1) % 3]
        if a > b:
            a, b = b, a
        key = ((a * 8388593) & 0x3FFFFFFFFFFF) + b
        slot = (key ^ (key >> 15)) & (size - 1)
        while slots[slot] >= 0:
            j = slots[slot]
            p = t[j // 3, j % 3]
            q = t[j // 3, (j + 1) % 3]
            if (p == a and q == b) or (p == b and q == a):
                break
            slot = (slot + 1) & (size - 1)
        if slots[slot] < 0:
            slots[slot] = i
            edge[i] = count
            ring[i] = i
            count += 1
        else:
            j = slots[slot]
            edge[i] = edge[j]
            ring[i] = ring[j]
            ring[j] = i
    return edge, ring, count


@scalar
def find(parent, i):
    """Root of i, halving the path."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@scalar
def join(parent, i, j):
    """Unite two sets; the lower number leads, so that the result has one order."""
    i = find(parent, i)
    j = find(parent, j)
    if i < j:
        parent[j] = i
    elif j < i:
        parent[i] = j


@entry("l2 l1 l1 l1 l1 -> l1 l")
def patches_of(t, surface, edge, ring, twin):
    """Patch number of each triangle, numbered by first triangle, and how many.

    Triangles of one surface are joined over edges that exactly two distinct triangles
    share. `twin` is the first triangle with the same corners (itself, mostly).
    """
    n = t.shape[0]
    parent = np.arange(n)
    for i in range(3 * n):
        tri = i // 3
        if twin[tri] != tri:
            continue
        # distinct triangles around the edge
        count = 0
        other = -1
        j = ring[i]
        while j != i:
            if twin[j // 3] == j // 3:
                count += 1
                other = j // 3
            j = ring[j]
        if count == 1 and surface[other] == surface[tri]:
            join(parent, tri, other)
    for i in range(n):  # coinciding triangles: joined as their twins are, surface by surface
        if twin[i] == i:
            continue
        for c in range(3):
            j = ring[3 * i + c]
            while j != 3 * i + c:
                if surface[j // 3] == surface[i] and _same_patch(parent, twin, i, j // 3, edge, ring, j):
                    join(parent, i, j // 3)
                j = ring[j]
    number = np.full(n, -1, dtype=np.int64)
    count = 0
    for i in range(n):
        root = find(parent, i)
        if number[root] < 0:
            number[root] = count
            count += 1
        number[i] = number[root]
    return number, count


@scalar
def _same_patch(parent, twin, i, j, edge, ring, half):
    """Whether triangles i and j, both coinciding with others, lie in one patch there."""
    return twin[j] != j and find(parent, twin[i]) == find(parent, twin[j])


@entry("l2 l1 l1 -> l1 l")
def pieces(t, edge, ring):
    """Connected pieces over common edges: number of each triangle, and how many."""
    n = t.shape[0]
    parent = np.arange(n)
    for i in range(3 * n):
        join(parent, i // 3, ring[i] // 3)
    number = np.full(n, -1, dtype=np.int64)
    count = 0
    for i in range(n):
        root = find(parent, i)
        if number[root] < 0:
            number[root] = count
            count += 1
        number[i] = number[root]
    return number, count
