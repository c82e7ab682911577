"""Parts of a torn sheet between faults, and on which side of a fault they lie.

Notation
    edge, triangle   half-edges on curves, triangle by triangle: number of the curve edge, triangle
    surface, patch   of each triangle
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.exact.predicates import orient3d
from geosurf.kernels.meshes.mesh import find, join


@scalar
def _by_edge(edge, triangle, surface, of, n_edge):
    """Half-edges of one surface by their edge, in order: start of each edge, and the half-edges."""
    start = np.zeros(n_edge + 1, dtype=np.int64)
    for h in range(edge.shape[0]):
        if surface[triangle[h]] == of:
            start[edge[h] + 1] += 1
    for e in range(n_edge):
        start[e + 1] += start[e]
    free = start[:n_edge].copy()
    halves = np.empty(start[n_edge], dtype=np.int64)
    for h in range(edge.shape[0]):
        if surface[triangle[h]] == of:
            halves[free[edge[h]]] = h
            free[edge[h]] += 1
    return start, halves


@entry("l1 l1 b1 l1 l1 l1 l l -> l1")
def join_past_others(edge, triangle, fault, surface, patch, parent, of, n_patch):
    """A label for each patch: the same where only walls and horizons part patches of a surface.

    Half-edges `of` the surface at an edge without a `fault` join their patches where there are two.
    Where a sheet crosses itself there are more: then those of one input triangle, `parent`.
    Labels are numbered by the first patch of each.
    """
    start, halves = _by_edge(edge, triangle, surface, of, fault.shape[0])
    root = np.arange(n_patch)
    for e in range(fault.shape[0]):
        first, last = start[e], start[e + 1]
        if fault[e] or last - first < 2:
            continue
        for i in range(first, last):
            one = triangle[halves[i]]
            for j in range(i + 1, last):
                two = triangle[halves[j]]
                if last - first == 2 or parent[one] == parent[two]:
                    join(root, patch[one], patch[two])

    # the lowest patch of a set is its root
    label = np.empty(n_patch, dtype=np.int64)
    n = 0
    for i in range(n_patch):
        lowest = find(root, i)
        if lowest == i:
            label[i] = n
            n += 1
        else:
            label[i] = label[lowest]
    return label


@entry("d2 l2 l2 l1 l1 l1 l1 l1 l1 l2 l l l l1* l1* -> d1")
def balance_at_fault(
    x, t, ends, edge, triangle, surface, part, parent, wall, faces, of, fault, n_part, m, w
):  # fmt: skip
    """By how much more of the edges at a fault parts lie in the wall that they belong to [m].

    Parameters
    ----------
    ends : int64 (n_edge, 2)
        Points of each curve edge.
    part : int64 (n_triangle,)
        Of the triangles of the sheet `of`.
    wall : int64 (n_vertex,)
        Wall of the vertices of the sheet, 1 or -1; `faces` are its triangles, `parent` rows of it.

    Returns
    -------
    float64 (n_part,)
        Below 0 where the longer part of the edges is on the other side.
    """
    start, halves = _by_edge(edge, triangle, surface, fault, ends.shape[0])
    balance = np.zeros(n_part)
    for h in range(edge.shape[0]):
        a, e = triangle[h], edge[h]
        if surface[a] != of or start[e] == start[e + 1]:
            continue
        # a triangle of one wall only: around a tip the two are one
        face = parent[a]
        belongs = wall[faces[face, 0]]
        if wall[faces[face, 1]] != belongs or wall[faces[face, 2]] != belongs:
            continue

        # the corner that is not on the edge, seen from the fault: in front of it or behind
        one, two = ends[e, 0], ends[e, 1]
        corner = t[a, 0]
        for c in range(1, 3):
            if corner == one or corner == two:
                corner = t[a, c]
        dx, dy, dz = x[two, 0] - x[one, 0], x[two, 1] - x[one, 1], x[two, 2] - x[one, 2]
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        for k in range(start[e], start[e + 1]):
            b = triangle[halves[k]]
            lies = orient3d(x, m, w, t[b, 0], t[b, 1], t[b, 2], corner, 0.0)
            balance[part[a]] += length * lies * belongs
    return balance
