"""Contacts of an earlier arrangement and of a new search, merged into one arrangement.

Two surfaces that both scenes have meet as before. So the contacts of a scene are those of an
earlier one, as far as they are of common surfaces, and those of the pairs that were searched anew.
All is numbered in the order that a search of all pairs gives: faces and vertices by surface, then
by key and node; points as contacts name them first.

Letters as in `naming`; a 0 marks what is of the earlier arrangement, a 1 what is of the new search,
and
    face0, face1     number of each face in the merged arrangement, or -1
    point0, point1   number of each vertex and point, or -1: vertices first
    kept             whether each earlier contact stays
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.contacts.merging import bits_of_rows, is_in_filter
from geosurf.kernels.contacts.packed_contact import HOW, TRIANGLE_A, TRIANGLE_B, n_corner_of

_NO = -1  # of a result: the two have no common numbering


@entry("l2 l2 b1 -> b1 b1")
def kept_contacts(rows, near, common):
    """Which contacts are of two faces that stay, and which faces these and near pairs have.

    `common` are faces of surfaces that stay.
    """
    kept = np.zeros(rows.shape[0], dtype=np.bool_)
    used = np.zeros(common.shape[0], dtype=np.bool_)
    for k in range(rows.shape[0]):
        a, b = rows[k, TRIANGLE_A], rows[k, TRIANGLE_B]
        if common[a] and common[b]:
            kept[k] = used[a] = used[b] = True
    for k in range(near.shape[0]):
        if common[near[k, 0]] and common[near[k, 1]]:
            used[near[k, 0]] = used[near[k, 1]] = True
    return kept, used


@entry("l1 l1 b1 l1 l1 -> l1 l1 l")
def merge_faces(surface0, key0, used, surface1, key1):
    """Numbers of earlier faces that are used, and of new ones, by surface and key; how many."""
    number0 = np.full(surface0.shape[0], -1, dtype=np.int64)
    number1 = np.empty(surface1.shape[0], dtype=np.int64)
    i = j = n = 0
    while True:
        while i < surface0.shape[0] and not used[i]:
            i += 1
        old, new = i < surface0.shape[0], j < surface1.shape[0]
        if not (old or new):
            return number0, number1, n
        if old and new and not (surface0[i] == surface1[j] and key0[i] == key1[j]):
            old = surface0[i] < surface1[j] or (surface0[i] == surface1[j] and key0[i] < key1[j])
            new = not old
        if old:
            number0[i] = n
            i += 1
        if new:
            number1[j] = n
            j += 1
        n += 1


@entry("l1 l1 l1 l1 l1 l1 b1 b1 l1 l1 -> l1 l1 l1 l")
def merge_nodes(surface0, node0, id0, surface1, node1, id1, used, changed, point0, point1):
    """Number vertices by the first node of each; returns surface, node and vertex of all nodes.

    `used` are earlier vertices that stay, and `changed` surfaces that were searched anew; numbers
    are written to `point0` and `point1`. The last result is the number of vertices; `_NO` if two
    nodes of one surface, or nodes of a changed surface and of another one, are in one place: their
    numbers need a search of all pairs.
    """
    n = surface0.shape[0] + surface1.shape[0]
    surface, node = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    vertex = np.empty(n, dtype=np.int64)
    last = np.empty(n, dtype=np.int64)  # surface of the last node at each vertex
    i = j = n = count = 0
    while True:
        while i < surface0.shape[0] and (surface0[i] < 0 or not used[id0[i]]):
            i += 1
        old, new = i < surface0.shape[0], j < surface1.shape[0]
        if not (old or new):
            return surface[:n].copy(), node[:n].copy(), vertex[:n].copy(), count
        if old and new and not (surface0[i] == surface1[j] and node0[i] == node1[j]):
            old = surface0[i] < surface1[j] or (surface0[i] == surface1[j] and node0[i] < node1[j])
            new = not old

        # a vertex has its number if an earlier node is in its place
        one, other = -1, -1
        if old:
            surface[n], node[n], one = surface0[i], node0[i], point0[id0[i]]
        if new:
            surface[n], node[n], other = surface1[j], node1[j], point1[id1[j]]
        if one >= 0 and other >= 0 and one != other:
            return surface, node, vertex, _NO
        number = max(one, other)
        if number >= 0:
            of = last[number]
            if of == surface[n] or changed[of] != changed[surface[n]]:
                return surface, node, vertex, _NO
        else:
            number = count
            count += 1
        last[number] = surface[n]
        vertex[n] = number
        if old:
            point0[id0[i]] = number
            i += 1
        if new:
            point1[id1[j]] = number
            j += 1
        n += 1


@scalar
def _number_points(ids, k, how, point, d, n_vertex, face, x, out_x, out_d, out_ids, row, n, first):
    """Enter the points of a contact, numbered as they come; the number of points, or `_NO`."""
    for c in range(n_corner_of(how)):
        p = ids[k, c]
        if point[p] < 0:
            # the name is that of a contact that is left, or the order would be another
            of = p - n_vertex
            if of < 0:
                return _NO
            a, b, by = point[d[of, 1]], point[d[of, 2]], face[d[of, 3]]
            if a < 0 or b < 0 or by < 0:
                return _NO
            # the lower vertex first, as names have it: vertices of walls may change places
            out_d[n, 0], out_d[n, 1], out_d[n, 2], out_d[n, 3] = d[of, 0], min(a, b), max(a, b), by
            for axis in range(3):
                out_x[first + n, axis] = x[p, axis]
            point[p] = first + n
            n += 1
        out_ids[row, c] = point[p]
    return n


@entry("l2 l2 b1 l1 l1 l2 l d2 l2 l2 l1 l1 l2 l d2 l d2 l2 -> l2 l2 l")
def merge_contacts(
    rows0, ids0, kept, face0, point0, d0, n_vertex0, x0,
    rows1, ids1, face1, point1, d1, n_vertex1, x1, n_vertex, x, d,
):  # fmt: skip
    """Contacts of both in the order of their faces, with the ids of their points; how many points.

    Points behind the `n_vertex` vertices are written to `x` and `d`. The last result is `_NO` if a
    point that stays is named by what is gone.
    """
    n = rows1.shape[0]
    for k in range(rows0.shape[0]):
        n += 1 if kept[k] else 0
    rows, ids = np.empty((n, 3), dtype=np.int64), np.full((n, 2), -1, dtype=np.int64)
    i = j = n_point = 0
    for row in range(n):
        while i < rows0.shape[0] and not kept[i]:
            i += 1
        new = i == rows0.shape[0]
        if not new and j < rows1.shape[0]:
            a0, a1 = face0[rows0[i, TRIANGLE_A]], face1[rows1[j, TRIANGLE_A]]
            b0, b1 = face0[rows0[i, TRIANGLE_B]], face1[rows1[j, TRIANGLE_B]]
            new = a1 < a0 or (a1 == a0 and b1 < b0)
        if new:
            rows[row, TRIANGLE_A] = face1[rows1[j, TRIANGLE_A]]
            rows[row, TRIANGLE_B] = face1[rows1[j, TRIANGLE_B]]
            rows[row, HOW] = rows1[j, HOW]
            n_point = _number_points(
                ids1, j, rows1[j, HOW], point1, d1, n_vertex1, face1, x1, x, d, ids, row, n_point,
                n_vertex,
            )  # fmt: skip
            j += 1
        else:
            rows[row, TRIANGLE_A] = face0[rows0[i, TRIANGLE_A]]
            rows[row, TRIANGLE_B] = face0[rows0[i, TRIANGLE_B]]
            rows[row, HOW] = rows0[i, HOW]
            n_point = _number_points(
                ids0, i, rows0[i, HOW], point0, d0, n_vertex0, face0, x0, x, d, ids, row, n_point,
                n_vertex,
            )  # fmt: skip
            i += 1
        if n_point == _NO:
            return rows, ids, _NO
    return rows, ids, n_point


@entry("l2 l1 l1 l1 l1 l2 l1 l1 -> .")
def move_faces(t, surface0, key0, face, point, out, surface, key):
    """Write the corners, surface and key of faces that have a new row there, with new numbers."""
    for i in range(t.shape[0]):
        at = face[i]
        if at >= 0:
            for c in range(3):
                out[at, c] = point[t[i, c]]
            surface[at], key[at] = surface0[i], key0[i]


@entry("d2 l1 l d2 -> .")
def move_vertices(x, point, n, out):
    """Write the coordinates of those of the first n points that have a new row there."""
    for p in range(n):
        if point[p] >= 0:
            for axis in range(3):
                out[point[p], axis] = x[p, axis]


@entry("l2 b1 b1 -> .")
def mark_corners(t, wanted, marked):
    """Mark the corners of the faces that are wanted."""
    for i in range(t.shape[0]):
        if wanted[i]:
            for c in range(3):
                marked[t[i, c]] = True


@entry("l2 b1 l1 l2 l1 b1 -> .")
def mark_changed(rows0, kept, face0, rows1, face1, changed):
    """Mark the faces of contacts that are gone, and of those that are new."""
    for k in range(rows0.shape[0]):
        if not kept[k]:
            for a in (face0[rows0[k, TRIANGLE_A]], face0[rows0[k, TRIANGLE_B]]):
                if a >= 0:
                    changed[a] = True
    for k in range(rows1.shape[0]):
        changed[face1[rows1[k, TRIANGLE_A]]] = changed[face1[rows1[k, TRIANGLE_B]]] = True


@entry("d2 b1 -> l1 l")
def filter_of(x, some):
    """A filter with the bits of some rows, two words in one number, and its size in bits."""
    n_some = 0
    for k in range(x.shape[0]):
        n_some += 1 if some[k] else 0
    filled, size = bits_of_rows(x, some, n_some)
    return filled.view(np.int64), size


@entry("d2 b1 l1 l l l -> l1")
def may_coincide_with(x, some, filled, size, low, high):
    """Of rows `low` to `high` - 1 all that are in `some`, and others that may have the coordinates
    of one of them, by `filter_of`.
    """
    bits, words = x.view(np.int64), filled.view(np.uint32)
    found = np.empty(high - low, dtype=np.int64)
    n = 0
    for k in range(low, high):
        if some[k] or is_in_filter(x, bits, words, k, size):
            found[n] = k
            n += 1
    return found[:n].copy()
