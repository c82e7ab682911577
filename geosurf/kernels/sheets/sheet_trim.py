"""Which triangles of a torn sheet are at a curve, and what do corners say about its parts?"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar


@entry("l2 l2 l -> l1 l1")
def sides_of_edges(triangles, edges, n_point):
    """Edge (row of `edges`, in either direction) and triangle of each side that is one of the
    edges.

    `edges` (n, 2) are distinct pairs of points 0 .. n_point - 1; sides come triangle by triangle.
    """
    n = edges.shape[0]

    # Few points are ends of an edge: most triangles are passed over by these marks.
    end = np.zeros(n_point, dtype=np.bool_)
    for e in range(n):
        end[edges[e, 0]] = end[edges[e, 1]] = True

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
        one, two, three = end[triangles[t, 0]], end[triangles[t, 1]], end[triangles[t, 2]]
        if not ((one and two) or (one and three) or (two and three)):
            continue
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


@scalar
def _vertex_at(local, p, vertices, origin, faces, face):
    """The corner of a triangle of the sheet that a point is, to the last digit, or -1."""
    for d in range(3):
        v = faces[face, d]
        if (
            local[p, 0] == vertices[v, 0] - origin[0]
            and local[p, 1] == vertices[v, 1] - origin[1]
            and local[p, 2] == vertices[v, 2] - origin[2]
        ):
            return v
    return -1


@entry("d2 l2 l1 l2 d2 d1 b1 b1 b1 l1 l1 l l2* -> b1 b1")
def classify_parts(
    local, triangles, parent, faces, vertices, origin, on_fault, ghost, outer, patch, part_of,
    n_part, named,
):  # fmt: skip
    """Whether each part holds original data, and whether it holds something beyond a fault.

    For the triangles of a sheet in patches: `parent` are their rows in its own `faces`,
    `vertices` its vertices in the world, `part_of` the part of each patch. A point on a fault is
    on the boundary of both parts and decides nothing. If `named` (n, 3) has rows, the vertex at
    each corner is written to it, -1 for points that were made.
    """
    held, beyond = np.zeros(n_part, dtype=np.bool_), np.zeros(n_part, dtype=np.bool_)
    for k in range(triangles.shape[0]):
        of, part = parent[k], part_of[patch[k]]
        a, b, c = faces[of, 0], faces[of, 1], faces[of, 2]
        # A parent without ghost corners is original.
        if not (ghost[a] or ghost[b] or ghost[c]):
            held[part] = True

        # Nearly all triangles can tell nothing more: what they hold is known.
        if named.shape[0] == 0 and held[part] and not (outer[a] or outer[b] or outer[c]):
            continue
        for i in range(3):
            # Corners off the faults: real ones hold the part, outer ones lie beyond.
            p = triangles[k, i]
            v = _vertex_at(local, p, vertices, origin, faces, of)
            if named.shape[0] > 0:
                named[k, i] = v
            if v >= 0 and not on_fault[p]:
                if outer[v]:
                    beyond[part] = True
                if not ghost[v]:
                    held[part] = True
    return held, beyond
