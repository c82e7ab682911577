"""Parts of surfaces, and the edges at which they end.

Notation
    t         triangles, int64 (n, 3); x their rounded vertices
    elements  the triangles, then runs of a lattice, which face as it does
    ring      next half-edge around the same edge
    link      for a half-edge that is alone: the run behind it (counted after the triangles), or < 0
    part      of each element, -1 for one that is left out

Nearly all edges are inside parts. The others, a few curves, are seams (`seams`): a model of a
million triangles has some dozens of parts.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.meshes.mesh import find, join


@scalar
def _within(x, t, i, bounds):
    """Whether all corners of a triangle lie within bounds (2, 3)."""
    for c in range(3):
        for k in range(3):
            # Written so that NaN lies outside.
            if not bounds[0, k] <= x[t[i, c], k] <= bounds[1, k]:
                return False
    return True


@entry("d2 l2 l1 l1 l1 l1 l l2 d2 -> l1 l1")
def parts_of(x, t, surface, ring, link, twin, n_run, pairs, bounds):
    """Part of each element, and the first element of each.

    Triangles of one surface are joined over edges that two of them alone share in opposite
    directions; runs with the triangles linked to them, and as listed in `pairs` (elements).
    Triangles outside the bounds, and all but the first (`twin`, empty if no triangles coincide) of
    those with the same corners, are left out.
    """
    n = t.shape[0]
    included = np.ones(n + n_run, dtype=np.bool_)
    for i in range(n):
        # Of coinciding triangles one stands for all.
        included[i] = (twin.shape[0] == 0 or twin[i] == i) and _within(x, t, i, bounds)
    parent = np.arange(included.shape[0])
    for i in range(n):
        if not included[i]:
            continue
        for c in range(3):
            start = 3 * i + c

            # Alone: a run may continue. Two half-edges: the same surface, opposite directions.
            j = ring[start]
            if j == start:
                if link[start] >= 0:
                    join(parent, i, n + link[start])
            elif j > start and ring[j] == start:
                other = j // 3
                # Opposite directions: both triangles face the same way across the edge.
                if included[other] and surface[other] == surface[i] and t[other, j % 3] != t[i, c]:
                    join(parent, i, other)
    for k in range(pairs.shape[0]):
        join(parent, pairs[k, 0], pairs[k, 1])

    # Number the sets by their lowest element.
    part = np.full(included.shape[0], -1, dtype=np.int64)
    first = np.empty(included.shape[0], dtype=np.int64)
    count = 0
    for i in range(included.shape[0]):
        if not included[i]:
            continue
        root = find(parent, i)  # the lowest element
        if root == i:
            part[i] = count
            first[count] = i
            count += 1
        else:
            part[i] = part[root]
    return part, first[:count].copy()


@scalar
def _is_inner_edge(t, ring, link, part, last):
    """Whether an edge, by its last half-edge, lies inside a part: its triangles have been joined.

    So do edges of triangles that are left out.
    """
    j = ring[last]
    if j == last:
        return part[last // 3] < 0 or (link[last] >= 0 and part[t.shape[0] + link[last]] >= 0)
    # More than two triangles, or two parts: sides have to be found by their order.
    if ring[j] != last or part[last // 3] != part[j // 3]:
        return False
    return part[last // 3] < 0 or t[last // 3, last % 3] != t[j // 3, j % 3]


@entry("l2 l1 l1 l1 l l -> l1")
def open_edges(t, ring, link, part, low, high):
    """First half-edges of all edges that are not inside a part, and of which the last half-edge is
    one of `low` to `high` - 1.
    """
    first = np.empty(1024, dtype=np.int64)
    n = 0
    for last in range(low, high):
        # Rings rise: the last half-edge of an edge leads back to the first one.
        start = ring[last]
        if start > last or _is_inner_edge(t, ring, link, part, last):
            continue
        if n == first.shape[0]:
            longer = np.empty(2 * n, dtype=np.int64)
            longer[:n] = first
            first = longer
        first[n] = start
        n += 1
    return first[:n].copy()


@entry("l1 l1 b1* -> l")
def mark_around(ring, first, marked):
    """Mark the triangles around some edges, by a half-edge of each; returns how many marks."""
    n = 0
    for k in range(first.shape[0]):
        j = first[k]
        while True:
            marked[j // 3] = True
            n += 1
            j = ring[j]
            if j == first[k]:
                break
    return n
