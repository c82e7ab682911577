"""Seams of cells: sides of parts that face each other around common edges.

Letters as in `parts`, and
    start    first place of each edge in `seams`, and the end
    seams    triangles around edges, in order: 2 * triangle, plus 1 if it runs along the edge
    sides    union-find: part p has the sides 2 p (front, where normals point) and 2 p + 1 (back)
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.prefetch import prefetch
from geosurf.kernels.meshes.mesh import join
from geosurf.kernels.meshes.radial_order import (
    N_AROUND,
    main_axis,
    sort_around,
    sort_by_floats,
    sort_two_by_floats,
)

DONE, NEEDS_EXACT = -1, -2
_FULL = -1
_BLOCK = 256  # edges whose rings are walked together: memory answers many requests at once
_AROUND = 8  # triangles around an edge; those of more are gathered one by one


@scalar
def _gather_around(t, ring, part, start, order, directions):
    """Triangles around the edge of a half-edge and their directions; their number.

    `_FULL` if the arrays are too short.
    """
    n = 0
    u = t[start // 3, start % 3]
    j = start
    while True:
        # Triangles that are left out bound nothing.
        if part[j // 3] >= 0:
            if n == order.shape[0]:
                return _FULL
            order[n] = j // 3
            directions[n] = 1 if t[j // 3, j % 3] == u else -1
            n += 1
        j = ring[j]
        if j == start:
            return n


@scalar
def _look_ahead(t, ring, part, parent, px, first, low, at):
    """Bring what lies around a block of edges into the cache, ring by ring in step."""
    n = min(_BLOCK, first.shape[0] - low)
    for k in range(n):
        at[k] = first[low + k]
    for _ in range(_AROUND):
        turning = False
        for k in range(n):
            i = at[k] // 3
            prefetch(t, i)
            prefetch(part, i)
            prefetch(parent, i)
            following = ring[at[k]]
            if following != first[low + k]:
                at[k] = following
                turning = True
        if not turning:
            break
    for k in range(n):
        j = first[low + k]
        for _ in range(_AROUND):
            prefetch(px, 3 * parent[j // 3])
            j = ring[j]
            if j == first[low + k]:
                break


@entry("d2 l2 l1 l1 l1 l1 d2 l2 l1 l1* l1* l1* -> l")
def sort_seams(x, t, ring, first, part, parent, px, pt, m, w, start, seams):
    """Write the order of the triangles around some edges, by a half-edge of each, to `seams`.

    A triangle counts twice, plus 1 if it runs along the edge as that half-edge does. `start` gets
    the place of the first one of each edge, and the end.

    Returns `DONE`; `NEEDS_EXACT` if `m` is empty and doubles do not decide: call again with it; or
    a half-edge at which two triangles lie in one half-plane.
    """
    # Sixteen triangles around an edge are plenty for most models; the arrays grow.
    order = np.empty(16, dtype=np.int64)
    directions, turns, around = np.empty_like(order), np.empty(16), np.empty((16, N_AROUND))
    ahead = np.empty(_BLOCK, dtype=np.int64)
    n_seam = 0
    for k in range(first.shape[0]):
        if k % _BLOCK == 0:
            _look_ahead(t, ring, part, parent, px, first, k, ahead)
        edge = first[k]

        # Enlarge the arrays until all triangles around the edge fit.
        n = _gather_around(t, ring, part, first[k], order, directions)
        while n == _FULL:
            order = np.empty(2 * order.shape[0], dtype=np.int64)
            directions, turns = np.empty_like(order), np.empty(order.shape[0])
            around = np.empty((order.shape[0], N_AROUND))
            n = _gather_around(t, ring, part, first[k], order, directions)

        # Up to two triangles need no order; doubles first, then exact signs.
        if n > 2:
            u, v = t[edge // 3, edge % 3], t[edge // 3, (edge + 1) % 3]
            axis, heading = main_axis(x, u, v)
            told = n == 4 and sort_two_by_floats(px, parent, axis, heading, order, directions)
            if not told and not sort_by_floats(
                px, parent, axis, heading, order, directions, n, turns
            ):
                if m.shape[0] == 0:
                    return NEEDS_EXACT
                if not sort_around(x, u, v, order, directions, around, n, parent, px, pt, m, w):
                    return edge
        start[k] = n_seam
        for a in range(n):
            seams[n_seam] = 2 * order[a] + (1 if directions[a] > 0 else 0)
            n_seam += 1
    start[first.shape[0]] = n_seam
    return DONE


@entry("l1 l1 l1 l1* l1* -> .")
def join_seams(start, seams, part, sides, pieces):
    """Unite sides that face each other across edges, and in `pieces` all parts that touch."""
    for k in range(start.shape[0] - 1):
        low, high = start[k], start[k + 1]
        for a in range(low, high):
            # The last triangle faces the first: the order is cyclic.
            b = a + 1 if a + 1 < high else low
            one, other = part[seams[a] // 2], part[seams[b] // 2]
            join(sides, 2 * one + 1 - seams[a] % 2, 2 * other + seams[b] % 2)
            join(pieces, one, other)
