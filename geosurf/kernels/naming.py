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
from geosurf.kernels.exact import N_VERTEX
from geosurf.kernels.points import FULL, LPI, edge_plane, id_at_place, named_point
from geosurf.kernels.predicates import normal_axis


@scalar
def _corner_point(x, t, e, d, m, w, names, places, a, b, coplanar, axis, code):
    """Id of the point of one feature pair."""
    fa = (code >> 3) & 7
    fb = code & 7
    if fa < 3:
        return t[a, fa]
    if fb < 3:
        return t[b, fb]
    if fa < FACE and (code >> 3) < BY_SECOND:
        p, q = t[a, fa - 3], t[a, (fa - 2) % 3]
        if not coplanar:
            return named_point(x, t, e, d, m, w, names, places, LPI, p, q, b)
        support = edge_plane(e, m, names, t[b, fb - 3], t[b, (fb - 2) % 3], axis)
        if support == FULL:
            return FULL
        return named_point(x, t, e, d, m, w, names, places, LPI, p, q, support)
    p, q = t[b, fb - 3], t[b, (fb - 2) % 3]
    return named_point(x, t, e, d, m, w, names, places, LPI, p, q, a)


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


@entry("d2 l2 l2 l2 l1 l1 l2 l1 l2 l2 l2 -> l")
def name_contacts(x, t, e, d, m, w, names, places, rows, ids, records):
    """Ids of all points of contact (rows of `ids`), and records; returns their number or FULL.

    `x` has room behind the vertices, `records` room for eight a contact.
    """
    filed = np.zeros(m[N_VERTEX], dtype=np.bool_)
    for k in range(rows.shape[0]):
        for side in range(2):
            for c in range(3):
                i = t[rows[k, side], c]
                if not filed[i]:
                    filed[i] = True
                    id_at_place(x, t, e, d, m, w, places, i)
    n = 0
    for k in range(rows.shape[0]):
        a, b = rows[k, TRIANGLE_A], rows[k, TRIANGLE_B]
        coplanar = rows[k, COPLANAR] == 1
        axis = 0
        if coplanar:
            axis, _ = normal_axis(x, m, w, t[a, 0], t[a, 1], t[a, 2])
        for c in range(rows[k, N_CORNER]):
            i = _corner_point(
                x, t, e, d, m, w, names, places, a, b, coplanar, axis, rows[k, FIRST_CODE + c]
            )
            if i == FULL:
                return FULL
            ids[k, c] = i
        if coplanar:
            for c in range(rows[k, N_CORNER]):
                n = _record(records, n, t, a, ids[k, c], -1, -1)
                n = _record(records, n, t, b, ids[k, c], -1, -1)
            n = _edge_records(rows, k, ids, t, e, m, names, a, b, 0, axis, records, n)
            if n >= 0:
                n = _edge_records(rows, k, ids, t, e, m, names, b, a, 3, axis, records, n)
            if n < 0:
                return FULL
        elif rows[k, N_CORNER] == 2:
            n = _record(records, n, t, a, ids[k, 0], ids[k, 1], b)
            n = _record(records, n, t, b, ids[k, 0], ids[k, 1], a)
        else:
            n = _record(records, n, t, a, ids[k, 0], -1, -1)
            n = _record(records, n, t, b, ids[k, 0], -1, -1)
    return n
