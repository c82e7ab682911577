"""Parts of surfaces, and the cells that they bound: sides that face each other around common edges.

Notation
    t         triangles, int64 (n, 3); x their rounded vertices
    elements  the triangles, then runs of a lattice, which face as it does
    ring      next half-edge around the same edge
    link      for a half-edge that is alone: the run behind it (counted after the triangles), or < 0
    part      of each element, -1 for one that is left out
    sides     union-find: part p has the sides 2 p (front, where normals point) and 2 p + 1 (back)

Nearly all edges are inside parts. The others, a few curves, are sorted radially: a model of a
million triangles has some dozens of parts.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.prefetch import prefetch
from geosurf.kernels.meshes.mesh import find, join
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
    Triangles outside the bounds, and all but the first (`twin`) of those with the same corners,
    are left out.
    """
    n = t.shape[0]
    included = np.ones(n + n_run, dtype=np.bool_)
    for i in range(n):
        # Of coinciding triangles one stands for all.
        included[i] = twin[i] == i and _within(x, t, i, bounds)
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
def _is_inner_edge(t, ring, link, part, last):
    """Whether an edge, by its last half-edge, lies inside a part: its triangles have been joined.

    So do edges of triangles that are left out.
    """
    i, j = last // 3, ring[last]
    if j == last:
        return part[i] < 0 or (link[last] >= 0 and part[t.shape[0] + link[last]] >= 0)
    # More than two triangles, or two parts: sides have to be found by their order.
    if ring[j] != last or part[i] != part[j // 3]:
        return False
    return part[i] < 0 or t[i, last % 3] != t[j // 3, j % 3]


@entry("l2 l1 l1 l1 -> l1")
def open_edges(t, ring, link, part):
    """First half-edges of all edges that are not inside a part."""
    first = np.empty(1024, dtype=np.int64)
    n = 0
    for last in range(3 * t.shape[0]):
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


@entry("l1 l1 b1 -> .")
def mark_around(ring, first, marked):
    """Mark the triangles around some edges, by a half-edge of each."""
    for k in range(first.shape[0]):
        j = first[k]
        while True:
            marked[j // 3] = True
            j = ring[j]
            if j == first[k]:
                break


@scalar
def _look_ahead(t, ring, part, parent, px, first, low, halves):
    """Bring what lies around a block of edges into the cache, ring by ring in step."""
    n = min(_BLOCK, first.shape[0] - low)
    for k in range(n):
        halves[k] = first[low + k]
    for _ in range(_AROUND):
        turning = False
        for k in range(n):
            i = halves[k] // 3
            prefetch(t, i)
            prefetch(part, i)
            prefetch(parent, i)
            following = ring[halves[k]]
            if following != first[low + k]:
                halves[k] = following
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


@scalar
def _side_after(part, direction):
    """The side of a part that faces forward when rotating counter-clockwise around an edge."""
    return 2 * part if direction > 0 else 2 * part + 1


@entry("l1 l1 b1 -> l1 l1")
def number_parents(surface, key, wanted):
    """Number of the input triangle of each triangle, and the first triangle of each.

    Triangles of one input triangle follow each other. Only those that are wanted are numbered; the
    others have -1.
    """
    number, first = np.full(key.shape[0], -1, dtype=np.int64), np.empty_like(key)
    n = 0
    for i in range(key.shape[0]):
        if not wanted[i]:
            continue
        if n == 0 or key[i] != key[first[n - 1]] or surface[i] != surface[first[n - 1]]:
            first[n] = i
            n += 1
        number[i] = n - 1
    return number, first[:n].copy()


@entry("d2 l2 l1 l1 l1 l1 d2 l2 l1 l1 l1 l1 -> l")
def join_parts(x, t, ring, first, part, parent, px, pt, m, w, sides, pieces):
    """Unite sides that face each other across edges, and in `pieces` all parts that touch.

    `first` are the edges that are not inside a part (`open_edges`).

    Returns `DONE`; `NEEDS_EXACT` if `m` is empty and doubles do not decide: call again with it; or
    a half-edge at which two triangles lie in one half-plane.
    """
    # Sixteen triangles around an edge are plenty for most models; the arrays grow.
    order = np.empty(16, dtype=np.int64)
    directions, turns, around = np.empty_like(order), np.empty(16), np.empty((16, N_AROUND))
    halves = np.empty(_BLOCK, dtype=np.int64)
    for k in range(first.shape[0]):
        if k % _BLOCK == 0:
            _look_ahead(t, ring, part, parent, px, first, k, halves)
        start = first[k]

        # Enlarge the arrays until all triangles around the edge fit.
        n = _gather_around(t, ring, part, start, order, directions)
        while n == _FULL:
            order = np.empty(2 * order.shape[0], dtype=np.int64)
            directions, turns = np.empty_like(order), np.empty(order.shape[0])
            around = np.empty((order.shape[0], N_AROUND))
            n = _gather_around(t, ring, part, start, order, directions)

        # Up to two triangles need no order; doubles first, then exact signs.
        if n > 2:
            u, v = t[start // 3, start % 3], t[start // 3, (start + 1) % 3]
            axis, heading = main_axis(x, u, v)
            told = n == 4 and sort_two_by_floats(px, parent, axis, heading, order, directions)
            if not told and not sort_by_floats(
                px, parent, axis, heading, order, directions, n, turns
            ):
                if m.shape[0] == 0:
                    return NEEDS_EXACT
                if not sort_around(x, u, v, order, directions, around, n, parent, px, pt, m, w):
                    return start

        # Each side faces the next triangle in the order.
        for a in range(n):
            # The last triangle faces the first: the order is cyclic.
            b = (a + 1) % n
            one, other = part[order[a]], part[order[b]]
            join(sides, _side_after(one, directions[a]), _side_after(other, -directions[b]))
            join(pieces, one, other)
    return DONE
