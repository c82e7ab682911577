"""Contacts of triangles -> named points, and what each triangle has to be cut by.

A record is (triangle, p, q, support): a segment p-q inside the triangle and a plane that
holds it, or a single point (q = support = -1). Both triangles of a contact get
the point or the segment, so neighbours see the same points on a common edge by
themselves, and the children conform without any exchange between faces.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels._jit import entry, scalar
from geosurf.kernels.contact import (
    BY_SECOND,
    COPLANAR,
    FACE,
    FIRST_CODE,
    N_CORNER,
    TRIANGLE_A,
    TRIANGLE_B,
)
from geosurf.kernels.exact import N_NAME, N_POINT, N_VERTEX
from geosurf.kernels.points import (
    FULL,
    LPI,
    edge_plane,
    file_name,
    hash_of_row,
    id_beside,
    lpi_plainly,
    named_point,
    place_exactly,
    slot_at_place,
    slot_of,
)
from geosurf.kernels.predicates import normal_axis

FEW = 4  # contacts of a face, up to which its points are listed by face, else by vertex
_LONG = 16  # points in a list, above which names go into a table
# columns of a listed name: edge, face, what it stands for, the next in the list
_EDGE_LOW, _EDGE_HIGH, _FACE, _ID, _NEXT = 0, 1, 2, 3, 4


@scalar
def _edge_and_face(t, rows, k, code):
    """The edge (lower vertex first) and the face that make a corner of a contact."""
    fa, fb = (code >> 3) & 7, code & 7
    if fa < FACE and (code >> 3) < BY_SECOND:
        of, i, face = rows[k, TRIANGLE_A], fa - 3, rows[k, TRIANGLE_B]
    else:
        of, i, face = rows[k, TRIANGLE_B], fb - 3, rows[k, TRIANGLE_A]
    p, q = t[of, i], t[of, 0 if i == 2 else i + 1]
    return min(p, q), max(p, q), face


@scalar
def _count_rows(t, rows):
    """Number of contacts of each face."""
    count = np.zeros(t.shape[0], dtype=np.int64)
    for k in range(rows.shape[0]):
        count[rows[k, TRIANGLE_A]] += 1
        count[rows[k, TRIANGLE_B]] += 1
    return count


@scalar
def _with_room(m, names):
    """The table of names, made anew and larger if one more contact could fill it."""
    if 2 * (m[N_NAME] + 16) < names.shape[0]:
        return names
    larger = np.zeros((2 * names.shape[0], 5), dtype=np.int64)
    m[N_NAME] = 0
    for i in range(names.shape[0]):
        if names[i, 0] != 0:
            kind, a, b, c = names[i, 0], names[i, 1], names[i, 2], names[i, 3]
            file_name(m, larger, slot_of(larger, kind, a, b, c), kind, a, b, c, names[i, 4])
    return larger


@scalar
def _find_listed(heads, listed, head, p, q, face):
    """Number of a listed name, or -1; and how many the list has, as far as it was read."""
    i = heads[head]
    length = 0
    while i >= 0 and length < _LONG:
        if listed[i, _EDGE_LOW] == p and listed[i, _EDGE_HIGH] == q and listed[i, _FACE] == face:
            return i, length
        i = listed[i, _NEXT]
        length += 1
    return -1, length


@scalar
def _enter(heads, listed, head, n, p, q, face, made):
    """Put a name in front of a list, as number n."""
    listed[n, _EDGE_LOW], listed[n, _EDGE_HIGH], listed[n, _FACE] = p, q, face
    listed[n, _ID], listed[n, _NEXT] = made, heads[head]
    heads[head] = n


@scalar
def _define(x, t, d, m, p, q, face):
    """Make the next point that of an edge and a face; whether doubles place it for sure."""
    row = m[N_POINT]
    i = m[N_VERTEX] + row
    d[row, 0], d[row, 1], d[row, 2], d[row, 3] = LPI, p, q, face
    sure, x[i, 0], x[i, 1], x[i, 2] = lpi_plainly(x, t, p, q, face)
    return sure


@scalar
def _corner_in_plane(x, t, e, d, m, w, names, places, a, b, axis, code):
    """Id of the point of two features in one plane."""
    fa = (code >> 3) & 7
    fb = code & 7
    if fa < 3:
        return t[a, fa]
    if fb < 3:
        return t[b, fb]
    support = edge_plane(e, m, names, t[b, fb - 3], t[b, (fb - 2) % 3], axis)
    if support == FULL:
        return FULL
    p, q = t[a, fa - 3], t[a, (fa - 2) % 3]
    return named_point(x, t, e, d, m, w, names, places, LPI, p, q, support)


@scalar
def _has(t, tri, p):
    return t[tri, 0] == p or t[tri, 1] == p or t[tri, 2] == p


@scalar
def _record(records, n, t, tri, p, q, support):
    """File a segment or a point (q = -1) for a triangle, unless it is there already."""
    if q < 0:
        if _has(t, tri, p):
            return n
    elif _has(t, tri, p) and _has(t, tri, q):
        return n
    records[n, 0] = tri
    if 0 <= q < p:
        p, q = q, p
    records[n, 1], records[n, 2], records[n, 3] = p, q, support
    return n + 1


@scalar
def _edge_records(rows, k, ids, t, e, m, names, tri, of, shift, axis, records, n):
    """Segments in `tri` along the edges of the coplanar triangle `of`; -1 if a table is full.

    `shift` picks the features of `of` from a code: 3 for the first triangle, 0 for the second.
    """
    for i in range(3):
        first = -1
        second = -1
        for c in range(rows[k, N_CORNER]):
            feature = (rows[k, FIRST_CODE + c] >> shift) & 7
            if feature == i or feature == (i + 1) % 3 or feature == 3 + i:
                if first < 0:
                    first = ids[k, c]
                elif ids[k, c] != first:
                    second = ids[k, c]
        if second >= 0 and not (_has(t, tri, first) and _has(t, tri, second)):
            support = edge_plane(e, m, names, t[of, i], t[of, (i + 1) % 3], axis)
            if support == FULL:
                return -1
            n = _record(records, n, t, tri, first, second, support)
    return n


@scalar
def _file_corners(x, t, n_vertex, places, rows):
    """Enter the corners of all faces in contact, no two of them alike, into the table of places."""
    filed = np.zeros(n_vertex, dtype=np.bool_)
    for k in range(rows.shape[0]):
        for side in range(2):
            for c in range(3):
                i = t[rows[k, side], c]
                if not filed[i]:
                    filed[i] = True
                    slot = slot_at_place(x, places, i, hash_of_row(x, i) & (places.shape[0] - 1))
                    places[slot] = i


@scalar
def _records_in_plane(rows, k, ids, t, e, m, names, axis, records, n):
    """Corners and edges of two faces of one plane for each other; -1 if a table is full."""
    a, b = rows[k, TRIANGLE_A], rows[k, TRIANGLE_B]
    for c in range(rows[k, N_CORNER]):
        n = _record(records, n, t, a, ids[k, c], -1, -1)
        n = _record(records, n, t, b, ids[k, c], -1, -1)
    n = _edge_records(rows, k, ids, t, e, m, names, a, b, 0, axis, records, n)
    if n >= 0:
        n = _edge_records(rows, k, ids, t, e, m, names, b, a, 3, axis, records, n)
    return n


@entry("d2 l2 l2 l2 l1 l1 l1 l2 l2 l2 -> l")
def name_contacts(x, t, e, d, m, w, places, rows, ids, records):
    """Ids of all points of contact (rows of `ids`), and records; returns their number or FULL.

    `x` has room behind the vertices, `records` room for eight a contact.
    """
    _file_corners(x, t, m[N_VERTEX], places, rows)
    count = _count_rows(t, rows)
    names = np.zeros((64, 5), dtype=np.int64)
    heads = np.full(t.shape[0] + m[N_VERTEX], -1, dtype=np.int64)
    listed = np.empty((x.shape[0] - m[N_VERTEX], 5), dtype=np.int64)
    n_listed = 0
    n = 0
    for k in range(rows.shape[0]):
        a, b = rows[k, TRIANGLE_A], rows[k, TRIANGLE_B]
        coplanar = rows[k, COPLANAR] == 1
        names = _with_room(m, names)
        axis = 0
        if coplanar:
            axis, _ = normal_axis(x, m, w, t[a, 0], t[a, 1], t[a, 2])
        for c in range(rows[k, N_CORNER]):
            code = rows[k, FIRST_CODE + c]
            if coplanar:
                i = _corner_in_plane(x, t, e, d, m, w, names, places, a, b, axis, code)
            elif (code >> 3) & 7 < 3:
                i = t[a, (code >> 3) & 7]
            elif code & 7 < 3:
                i = t[b, code & 7]
            else:
                # Neighbours name it, too: a short list of the face, if few meet it, or else of the
                # edge's lower vertex has them side by side, a table of all names in no cache.
                p, q, face = _edge_and_face(t, rows, k, code)
                head = face if count[face] <= FEW else t.shape[0] + p
                number, length = _find_listed(heads, listed, head, p, q, face)
                if number >= 0:
                    i = listed[number, _ID]
                elif length == _LONG:
                    i = named_point(x, t, e, d, m, w, names, places, LPI, p, q, face)
                else:
                    i = m[N_VERTEX] + m[N_POINT]
                    if i >= x.shape[0]:
                        return FULL
                    if not _define(x, t, d, m, p, q, face):
                        place_exactly(x, t, e, d, m, w, i)
                    slot = hash_of_row(x, i) & (places.shape[0] - 1)
                    slot = slot_at_place(x, places, i, slot)
                    if places[slot] < 0:
                        places[slot] = i
                        m[N_POINT] += 1
                    else:
                        made = id_beside(x, t, e, d, m, w, places, i, slot)
                        m[N_POINT] += 1 if made == i else 0
                        i = made
                    _enter(heads, listed, head, n_listed, p, q, face, i)
                    n_listed += 1
            if i == FULL:
                return FULL
            ids[k, c] = i
        if coplanar:
            n = _records_in_plane(rows, k, ids, t, e, m, names, axis, records, n)
            if n < 0:
                return FULL
        elif rows[k, N_CORNER] == 2:
            n = _record(records, n, t, a, ids[k, 0], ids[k, 1], b)
            n = _record(records, n, t, b, ids[k, 0], ids[k, 1], a)
        else:
            n = _record(records, n, t, a, ids[k, 0], -1, -1)
            n = _record(records, n, t, b, ids[k, 0], -1, -1)
    return n
