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
from geosurf.kernels.exact.predicates import orient3d
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


# ---- sheet parts ----------------------------------------
# Parts of a torn sheet between faults, and on which side of a fault they lie.
#
# Notation edge, triangle   half-edges on curves, triangle by triangle: number of the curve edge,
# triangle surface, patch   of each triangle


@scalar
def _by_edge(edge, triangle, surface, wanted, n_edge):
    """Half-edges of one surface by their edge, in order: start of each edge, and the half-edges."""
    start = np.zeros(n_edge + 1, dtype=np.int64)
    for h in range(edge.shape[0]):
        if surface[triangle[h]] == wanted:
            start[edge[h] + 1] += 1
    for e in range(n_edge):
        start[e + 1] += start[e]
    free = start[:n_edge].copy()
    halves = np.empty(start[n_edge], dtype=np.int64)
    for h in range(edge.shape[0]):
        if surface[triangle[h]] == wanted:
            halves[free[edge[h]]] = h
            free[edge[h]] += 1
    return start, halves


@entry("l1 l1 b1 l1 l1 l1 l l -> l1")
def join_past_others(edge, triangle, fault, surface, patch, parent, sheet, n_patch):
    """A label for each patch: the same where only walls and horizons part patches of a surface.

    Half-edges of the `sheet` at an edge without a `fault` join their patches where there are two.
    Where a sheet crosses itself there are more: then those of one input triangle, `parent`.
    Labels are numbered by the first patch of each.
    """
    start, halves = _by_edge(edge, triangle, surface, sheet, fault.shape[0])
    root = np.arange(n_patch)
    for e in range(fault.shape[0]):
        first, last = start[e], start[e + 1]
        if fault[e] or last - first < 2:
            continue
        for i in range(first, last):
            first_face = triangle[halves[i]]
            for j in range(i + 1, last):
                second_face = triangle[halves[j]]
                if last - first == 2 or parent[first_face] == parent[second_face]:
                    join(root, patch[first_face], patch[second_face])

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
    x, t, ends, edge, triangle, surface, part, parent, wall, faces, sheet, fault, n_part, m, w
):  # fmt: skip
    """By how much more of the edges at a fault parts lie in the wall that they belong to [m].

    Parameters
    ----------
    ends : int64 (n_edge, 2)
        Points of each curve edge.
    part : int64 (n_triangle,)
        Of the triangles of the sheet.
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
        if surface[a] != sheet or start[e] == start[e + 1]:
            continue
        # a triangle of one wall only: around a tip the two are one
        face = parent[a]
        belongs = wall[faces[face, 0]]
        if wall[faces[face, 1]] != belongs or wall[faces[face, 2]] != belongs:
            continue

        # the corner that is not on the edge, seen from the fault: in front of it or behind
        start_point, end_point = ends[e, 0], ends[e, 1]
        corner = t[a, 0]
        for c in range(1, 3):
            if corner == start_point or corner == end_point:
                corner = t[a, c]
        dx, dy, dz = (
            x[end_point, 0] - x[start_point, 0],
            x[end_point, 1] - x[start_point, 1],
            x[end_point, 2] - x[start_point, 2],
        )
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        for k in range(start[e], start[e + 1]):
            b = triangle[halves[k]]
            lies = orient3d(x, m, w, t[b, 0], t[b, 1], t[b, 2], corner, 0.0)
            balance[part[a]] += length * lies * belongs
    return balance


# ---- glued copies ----------------------------------------
# Which corners of the copies of torn triangles are one vertex?.


@scalar
def _join_node(parent, element, node_of_element, count, n, corner, node):
    """Unite a corner with the element of its node; elements follow the corners."""
    if element[node] < 0:
        element[node] = count
        node_of_element[count - 3 * n] = node
        count += 1
    join(parent, corner, element[node])
    return count


@scalar
def _has_real(corners, real, copy, node):
    """Whether a node is a real corner of a copy."""
    for k in range(3):
        if real[copy, k] and corners[copy, k] == node:
            return True
    return False


@entry("l1 l2 b2 l2 b2 l -> l2 l1 l1")
def glue_copies(triangle, corners, real, across, exists, n_node):
    """Number the ghosts of torn copies: corners of copies that are glued are one.

    Two copies are glued over a common edge if an end of it is real in both.

    Parameters
    ----------
    triangle : int64 (n,)
        Of the lattice, rising: the copies of one follow each other.
    corners : int64 (n, 3)
        Its nodes.
    real : bool (n, 3)
    across : int64 (n, 3)
        The triangle beyond each edge, from a corner to the next, and whether it `exists`.
    n_node : int
        Of the lattice: ghosts are numbered from here on, as they first appear.

    Returns
    -------
    vertex : int64 (n, 3)
    anchor, node : int64 (n_ghost,)
        A real corner of the first copy that has each ghost, and the node below it.
    """
    n = triangle.shape[0]
    element = np.full(n_node, -1, dtype=np.int64)
    parent = np.arange(6 * n)
    node_of_element = np.empty(3 * n, dtype=np.int64)
    count = 3 * n
    for i in range(n):
        for k in range(3):
            # a real corner is its node; so is one that an untorn neighbour shares
            if real[i, k]:
                count = _join_node(
                    parent, element, node_of_element, count, n, 3 * i + k, corners[i, k]
                )
            e = 0 if k == 2 else k + 1
            if not exists[i, k]:
                continue
            first = np.searchsorted(triangle, across[i, k])
            is_whole = first == n or triangle[first] != across[i, k]
            for turn in range(2):
                here, there = (k, e) if turn == 0 else (e, k)
                if not real[i, here]:
                    continue
                if is_whole:
                    if not real[i, there]:
                        at = 3 * i + there
                        count = _join_node(
                            parent, element, node_of_element, count, n, at, corners[i, there]
                        )
                    continue
                m = first
                while m < n and triangle[m] == across[i, k]:
                    if _has_real(corners, real, m, corners[i, here]):
                        for shared in (here, there):
                            for twin in range(3):
                                if corners[m, twin] == corners[i, shared]:
                                    join(parent, 3 * i + shared, 3 * m + twin)
                                    break
                    m += 1

    # corners with a node in their set are that node
    node_of = np.full(6 * n, -1, dtype=np.int64)
    for j in range(count - 3 * n):
        root = find(parent, 3 * n + j)
        node_of[root] = max(node_of[root], node_of_element[j])
    vertex = np.empty((n, 3), dtype=np.int64)
    number = np.full(6 * n, -1, dtype=np.int64)
    anchor, node = np.empty(3 * n, dtype=np.int64), np.empty(3 * n, dtype=np.int64)
    n_ghost = 0
    for i in range(n):
        for k in range(3):
            root = find(parent, 3 * i + k)
            if node_of[root] >= 0:
                vertex[i, k] = node_of[root]
                continue
            if number[root] < 0:
                number[root] = n_ghost
                at = 0 if real[i, 0] else 1 if real[i, 1] else 2 if real[i, 2] else 0
                anchor[n_ghost], node[n_ghost] = corners[i, at], corners[i, k]
                n_ghost += 1
            vertex[i, k] = n_node + number[root]
    return vertex, anchor[:n_ghost].copy(), node[:n_ghost].copy()
