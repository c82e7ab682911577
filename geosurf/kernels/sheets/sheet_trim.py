"""Which triangles of a torn sheet are at a curve, and what do corners say about its parts?"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry


@entry("l2 l2 l -> l1 l1")
def sides_of_edges(triangles, edges, n_point):
    """Edge (row of `edges`, in either direction) and triangle of each side that is one of the
    edges.

    `edges` (n, 2) are distinct pairs of points 0 .. n_point - 1; sides come triangle by triangle.
    """
    n = edges.shape[0]

    # Edges by their lower point.
    start = np.zeros(n_point + 1, dtype=np.int64)
    for e in range(n):
        start[min(edges[e, 0], edges[e, 1]) + 1] += 1
    for v in range(n_point):
        start[v + 1] += start[v]
    free = start[:n_point].copy()
    row, other = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    for e in range(n):
        v = min(edges[e, 0], edges[e, 1])
        row[free[v]], other[free[v]] = e, max(edges[e, 0], edges[e, 1])
        free[v] += 1
    size = 4 * n + 64
    edge, triangle = np.empty(size, dtype=np.int64), np.empty(size, dtype=np.int64)
    count = 0
    for t in range(triangles.shape[0]):
        # Grow both arrays; each triangle adds at most three sides.
        if count + 3 > size:
            edge = np.concatenate((edge, np.empty_like(edge)))
            triangle = np.concatenate((triangle, np.empty_like(triangle)))
            size *= 2
        for k in range(3):
            a, b = triangles[t, k], triangles[t, (k + 1) % 3]
            v, w = min(a, b), max(a, b)
            # Few edges have the same lower point.
            for at in range(start[v], start[v + 1]):
                if other[at] == w:
                    edge[count], triangle[count] = row[at], t
                    count += 1
    return edge[:count].copy(), triangle[:count].copy()


@entry("l2 l1 l2 l2 b1 b1 b1 l1 l -> b1 b1")
def classify_parts(triangles, rows, named, faces, on_fault, ghost, outer, part, n_part):
    """Whether each part holds original data, and whether it holds something beyond a fault.

    For some triangles (rows of `triangles`): `named` (n, 3) are the vertices of the sheet at their
    corners, -1 for constructed points, `faces` (n, 3) the corners of their parents, `part` the
    part of each. A point on a fault is on the boundary of both parts and decides nothing.
    """
    held, beyond = np.zeros(n_part, dtype=np.bool_), np.zeros(n_part, dtype=np.bool_)
    for k in range(rows.shape[0]):
        # A parent without ghost corners is original.
        if not (ghost[faces[k, 0]] or ghost[faces[k, 1]] or ghost[faces[k, 2]]):
            held[part[k]] = True
        for c in range(3):
            # Corners off the faults: real ones hold the part, outer ones lie beyond.
            v = named[k, c]
            if v >= 0 and not on_fault[triangles[rows[k], c]]:
                if outer[v]:
                    beyond[part[k]] = True
                if not ghost[v]:
                    held[part[k]] = True
    return held, beyond
