"""Which triangles of a torn sheet overlap in the map, and which may cross there?

Vertices of a sheet lie over nodes of its lattice, next to its faults several over one.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.exact.predicates import orient2d


@entry("l1 d2 l -> b1")
def are_over_nodes(node, vertices, n_node):
    """Whether all vertices over one node are at one place in the map, (1,)."""
    out = np.ones(1, dtype=np.bool_)
    first = np.full(n_node, -1, dtype=np.int64)
    for i in range(node.shape[0]):
        j = first[node[i]]
        if j < 0:
            first[node[i]] = i
        elif vertices[i, 0] != vertices[j, 0] or vertices[i, 1] != vertices[j, 1]:
            out[0] = False
    return out


@entry("l2 l1 b1 l -> l1 l1 l1")
def edges_over_ghosts(t, node, ghost, n_node):
    """Half-edges of a sheet over nodes below some triangle with a ghost.

    Nothing overlaps elsewhere. Their triangles, and both vertices, that over the lower node first.
    """
    under = np.zeros(n_node, dtype=np.bool_)
    for i in range(t.shape[0]):
        if ghost[t[i, 0]] or ghost[t[i, 1]] or ghost[t[i, 2]]:
            for c in range(3):
                under[node[t[i, c]]] = True
    near = np.empty(node.shape[0], dtype=np.bool_)
    for v in range(node.shape[0]):
        near[v] = under[node[v]]
    size, n = 1024, 0
    found = np.empty((3, size), dtype=np.int64)
    for i in range(t.shape[0]):
        if n + 3 > size:
            longer = np.empty((3, 2 * size), dtype=np.int64)
            longer[:, :n] = found[:, :n]
            found, size = longer, 2 * size
        for c in range(3):
            a, b = t[i, c], t[i, 0 if c == 2 else c + 1]
            if near[a] and near[b]:
                back = node[a] > node[b]
                found[0, n], found[1, n], found[2, n] = i, b if back else a, a if back else b
                n += 1
    return found[0, :n].copy(), found[1, :n].copy(), found[2, :n].copy()


@scalar
def _continues(x, a, b, p, q):
    """Whether pq, on the line of ab, has only a corner of the mesh in common with ab."""
    # The same edge.
    if (p == a or p == b) and (q == a or q == b):
        return True
    if q == a or q == b:
        p, q = q, p
    if p != a and p != b:
        return False

    # Both segments leave the common corner in opposite directions.
    end = b if p == a else a
    axis = 0 if x[a, 0] != x[b, 0] else 1
    return (x[q, axis] > x[p, axis]) != (x[end, axis] > x[p, axis])


@scalar
def _separated_by_edge(x, t, m, w, f, own, g):
    """Whether an edge of triangle f, with turn `own`, has g on its other side.

    There g may share a corner with that edge, or the edge itself, but no other edge on the same
    line.
    """
    for k in range(3):
        a, b = t[f, k], t[f, (k + 1) % 3]
        separated, on = True, 0
        p = q = -1
        for i in range(3):
            c = t[g, i]

            # Corners of the edge itself are on its line; others have an exact sign.
            turn = 0
            if c != a and c != b:
                turn = orient2d(x, m, w, a, b, c, 0, 1)
            # On the side of f: the edge does not separate.
            if turn == own:
                separated = False
                break
            if turn == 0:
                p, q = q, c
                on += 1

        # Two corners on the line: an edge of g over the line of this edge.
        if separated and (on < 2 or _continues(x, a, b, p, q)):
            return True
    return False


@entry("d2 l2 l2 l1* l1* -> b1")
def overlap_in_map(x, t, pairs, m, w):
    """Whether two triangles (rows of `t`) may overlap except in a corner or an edge of the mesh.

    In the map they share an area, or part of an edge that is not an edge of the mesh. Exact: two
    disjoint triangles of the plane are separated by a line along an edge of one of them. True if
    one is vertical.
    """
    out = np.ones(pairs.shape[0], dtype=np.bool_)
    for k in range(pairs.shape[0]):
        # A vertical triangle has no turn in the map and stays True.
        f, g = pairs[k, 0], pairs[k, 1]
        one = orient2d(x, m, w, t[f, 0], t[f, 1], t[f, 2], 0, 1)
        two = orient2d(x, m, w, t[g, 0], t[g, 1], t[g, 2], 0, 1)
        if one != 0 and two != 0:
            out[k] = not (
                _separated_by_edge(x, t, m, w, f, one, g)
                or _separated_by_edge(x, t, m, w, g, two, f)
            )
    return out
