"""Links of a lattice that faults cut: the triangles they divide, and the steps that none parts.

Links are named as in `Cuts`: node and kind, 0 east, 1 north, 2 rising and 3 falling diagonal. A
link as one number is ``4 * node + kind``. Triangle ``2 * node + half`` lies in the cell whose lower
left node that is.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar

EAST, NORTH, RISING, FALLING = range(4)


@entry("d2 l1 l1 l l -> l2 l2")
def uncut_steps(walls, node, kind, n_row, n_col):
    """Neighbours (n, 2) to the east, then to the north, in different walls that no link parts.

    `walls` (n_slip, n_node) are compared exactly; `node` and `kind` are the links that are cut.
    """
    cut = np.zeros((2, n_row * n_col), dtype=np.bool_)
    for k in range(node.shape[0]):
        if kind[k] <= NORTH:
            cut[kind[k], node[k]] = True
    size = 256
    east, north = np.empty((size, 2), dtype=np.int64), np.empty((size, 2), dtype=np.int64)
    n_east = n_north = 0
    for i in range(n_row):
        for j in range(n_col):
            a = i * n_col + j
            for side in range(2):
                if (j if side == EAST else i) + 1 == (n_col if side == EAST else n_row):
                    continue
                b = a + (1 if side == EAST else n_col)
                differ = False
                for k in range(walls.shape[0]):
                    differ = differ or walls[k, a] != walls[k, b]
                if not differ or cut[side, a]:
                    continue
                if max(n_east, n_north) + 1 > size:
                    east = np.concatenate((east, np.empty_like(east)))
                    north = np.concatenate((north, np.empty_like(north)))
                    size *= 2
                if side == EAST:
                    east[n_east, 0], east[n_east, 1] = a, b
                    n_east += 1
                else:
                    north[n_north, 0], north[n_north, 1] = a, b
                    n_north += 1
    return east[:n_east].copy(), north[:n_north].copy()


@scalar
def _corner(t, k, rising, n_col):
    """Corner k of a triangle: anticlockwise, from the lower left of its cell where that is one."""
    a = t // 2
    if k == 0:
        return a + 1 if t % 2 == 1 and not rising else a
    if t % 2 == 0:
        return a + 1 if k == 1 else (a + n_col + 1 if rising else a + n_col)
    return a + n_col + 1 if k == 1 else a + n_col


@scalar
def _link(one, two, n_col):
    """Number of the link between two corners of a triangle."""
    low, step = min(one, two), abs(one - two)
    if step == 1:
        return 4 * low + EAST
    if step == n_col:
        return 4 * low + NORTH
    if step == n_col + 1:
        return 4 * low + RISING
    return 4 * (low - 1) + FALLING


@scalar
def _beside(link, turn, rising, n_col):
    """One of the two triangles of a link (turn 0 or 1), -1 if it would be outside."""
    node, kind = link // 4, link % 4
    if kind == EAST:
        if turn == 0:
            return 2 * node
        return 2 * (node - n_col) + 1 if node >= n_col else -1
    if kind == NORTH:
        left = 1 if rising else 0
        if turn == 0:
            return 2 * node + left
        return 2 * (node - 1) + 1 - left if node % n_col > 0 else -1
    return 2 * node + turn


@scalar
def _exists(t, rising, present, n_row, n_col):
    """Whether a triangle is in the lattice and has its three nodes."""
    a = t // 2
    if t < 0 or a // n_col >= n_row - 1 or a % n_col >= n_col - 1:
        return False
    for k in range(3):
        if not present[_corner(t, k, rising, n_col)]:
            return False
    return True


@entry("l1 b b1 l l -> l1")
def triangles_beside(links, rising, present, n_row, n_col):
    """Triangles beside some links that exist, in any order and more than once."""
    beside, n = np.empty(2 * links.shape[0], dtype=np.int64), 0
    for k in range(links.shape[0]):
        for turn in range(2):
            t = _beside(links[k], turn, rising, n_col)
            if _exists(t, rising, present, n_row, n_col):
                beside[n] = t
                n += 1
    return beside[:n].copy()


@entry("l1 l1 b b1 l l -> l1 l2 b2 l2 b2")
def divided_triangles(near, cut, rising, present, n_row, n_col):
    """Copies of the triangles that two cut links or more divide: one for each fragment.

    Parameters
    ----------
    near : int64 (n,)
        Triangles that exist, rising.
    cut : int64 (n_cut,)
        Links, rising.

    Returns
    -------
    triangle : int64 (n_copy,)
        Rising.
    corners : int64 (n_copy, 3)
        Nodes.
    real : bool (n_copy, 3)
        Corners of the fragment; the copies of one triangle by these, what is false first.
    across : int64 (n_copy, 3)
        The triangle beyond each edge, from a corner to the next.
    exists : bool (n_copy, 3)
        Whether there is one.
    """
    most = 3 * near.shape[0]
    triangle, real = np.empty(most, dtype=np.int64), np.empty((most, 3), dtype=np.bool_)
    corners, across = np.empty((most, 3), dtype=np.int64), np.empty((most, 3), dtype=np.int64)
    exists, is_cut = np.empty((most, 3), dtype=np.bool_), np.empty(3, dtype=np.bool_)
    link = np.empty(3, dtype=np.int64)
    n = 0
    for i in range(near.shape[0]):
        t, times = near[i], 0
        for k in range(3):
            one = _corner(t, k, rising, n_col)
            two = _corner(t, 0 if k == 2 else k + 1, rising, n_col)
            link[k] = _link(one, two, n_col)
            at = np.searchsorted(cut, link[k])
            is_cut[k] = at < cut.shape[0] and cut[at] == link[k]
            times += 1 if is_cut[k] else 0
        if times < 2:
            continue  # one cut edge alone ends inside the triangle: the tip goes through it

        # the corner that is alone lies between two cut edges; with three cut edges all are alone
        for turn in range(times):
            for k in range(3):
                if times == 3:
                    real[n, k] = k == 2 - turn
                    continue
                # the fragment without corner 0 comes first
                other = (turn == 1) != (is_cut[0] and is_cut[2])
                real[n, k] = (is_cut[k] and is_cut[2 if k == 0 else k - 1]) != other
            triangle[n] = t
            for k in range(3):
                corners[n, k] = _corner(t, k, rising, n_col)
                over = _beside(link[k], 0, rising, n_col)
                if over == t:
                    over = _beside(link[k], 1, rising, n_col)
                across[n, k] = over
                exists[n, k] = _exists(over, rising, present, n_row, n_col)
            n += 1
    return (
        triangle[:n].copy(), corners[:n].copy(), real[:n].copy(), across[:n].copy(),
        exists[:n].copy(),
    )  # fmt: skip


# ---- sheet corners ----------------------------------------
# Which triangles of a torn sheet may cross each other: vertices over nodes, edges next to ghosts.
#
# Vertices of a sheet lie over nodes of its lattice, next to its faults several over one.


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
    edges = np.empty((3, size), dtype=np.int64)
    for i in range(t.shape[0]):
        if n + 3 > size:
            longer = np.empty((3, 2 * size), dtype=np.int64)
            longer[:, :n] = edges[:, :n]
            edges, size = longer, 2 * size
        for c in range(3):
            a, b = t[i, c], t[i, 0 if c == 2 else c + 1]
            if near[a] and near[b]:
                back = node[a] > node[b]
                edges[0, n], edges[1, n], edges[2, n] = i, b if back else a, a if back else b
                n += 1
    return edges[0, :n].copy(), edges[1, :n].copy(), edges[2, :n].copy()


# ---- sheet trim ----------------------------------------
# Which triangles of a torn sheet are at a curve, and what do corners say about its parts?.


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


@entry("d2 l2 l1 l2 d2 d1 b1 b1 b1 l1 l1 l2* -> b1 b1")
def classify_parts(
    local, triangles, parent, faces, vertices, origin, on_fault, ghost, outer, patch, part_of,
    named,
):  # fmt: skip
    """Whether each part holds original data, and whether it holds something beyond a fault.

    For the triangles of a sheet in patches: `parent` are their rows in its own `faces`,
    `vertices` its vertices in the world, `part_of` the part of each patch. A point on a fault is
    on the boundary of both parts and decides nothing. If `named` (n, 3) has rows, the vertex at
    each corner is written to it, -1 for points that were made.
    """
    n = part_of.shape[0]  # parts are numbered by patches
    held, beyond = np.zeros(n, dtype=np.bool_), np.zeros(n, dtype=np.bool_)
    for k in range(triangles.shape[0]):
        face, part = parent[k], part_of[patch[k]]
        a, b, c = faces[face, 0], faces[face, 1], faces[face, 2]
        # A parent without ghost corners is original.
        if not (ghost[a] or ghost[b] or ghost[c]):
            held[part] = True

        # Nearly all triangles can tell nothing more: what they hold is known.
        if named.shape[0] == 0 and held[part] and not (outer[a] or outer[b] or outer[c]):
            continue
        for i in range(3):
            # Corners off the faults: real ones hold the part, outer ones lie beyond.
            p = triangles[k, i]
            v = _vertex_at(local, p, vertices, origin, faces, face)
            if named.shape[0] > 0:
                named[k, i] = v
            if v >= 0 and not on_fault[p]:
                if outer[v]:
                    beyond[part] = True
                if not ghost[v]:
                    held[part] = True
    return held, beyond
