"""Segments of curves that cannot overlap.

Where triangles meet in segments that cross their faces, no segment can hold a point of another one
inside, unless both lie in one face. For let p, an end of the segment of faces a' and b',
lie inside that of a and b. Then p is in a and in b', which therefore meet, too: in a segment that
ends at p, and lies in a beside the first; or p is inside that segment. Likewise for a' and
b. But p is on the rim of a' or of b', and a segment with a point of the rim inside runs along it.
So it is enough to look at the segments of each face, and at none where some run along edges.

All of this is asked of two surfaces at a time. Where one of them has one point at most for each
place in the map, two segments in a face of the other one need not be compared: they lie inside two
triangles of the first, and no point inside one of these lies in another.

Letters as in `exact`; contacts as in `packed`.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.contacts.near_segments import is_near_segment
from geosurf.kernels.contacts.packed_contact import (
    HOW,
    TRIANGLE_A,
    TRIANGLE_B,
    code_of,
    lies_in_plane,
    n_corner_of,
)
from geosurf.kernels.contacts.triangle_contact import FACE

_MANY = 64  # segments of a face, above which the general way is faster than comparing all
_REACH = 64 * 2.0**-52  # of the largest coordinate; rounding moves points by less than two


@scalar
def _on_edge(feature, edge):
    """Whether a feature of a triangle, not its face, lies on an edge."""
    return feature == edge or feature == (edge + 1) % 3 or feature == 3 + edge


@scalar
def _on_one_edge(one, two):
    """Whether two features of a triangle lie on one of its edges."""
    if one == FACE or two == FACE:  # nearly all
        return False
    for edge in range(3):
        if _on_edge(one, edge) and _on_edge(two, edge):
            return True
    return False


@scalar
def _crosses_faces(rows, k):
    """Whether a contact is a segment that runs along no edge."""
    how = rows[k, HOW]
    if n_corner_of(how) != 2 or lies_in_plane(how):
        return False
    one, two = code_of(how, 0), code_of(how, 1)
    return not (_on_one_edge((one >> 3) & 7, (two >> 3) & 7) or _on_one_edge(one & 7, two & 7))


@scalar
def _turns_away(x, p, a, q, reach):
    """Whether p and q lie on two sides of a, for sure: no segment from a to one holds the other.

    Where the true points lie on one ray from a, the product of their ways from a is above 0, and
    it is off by less than `reach` times both ways: `reach` is more than ten times what roundings
    move points by, and far above the errors of these products.
    """
    ux, uy, uz = x[p, 0] - x[a, 0], x[p, 1] - x[a, 1], x[p, 2] - x[a, 2]
    vx, vy, vz = x[q, 0] - x[a, 0], x[q, 1] - x[a, 1], x[q, 2] - x[a, 2]
    lengths = abs(ux) + abs(uy) + abs(uz) + abs(vx) + abs(vy) + abs(vz)
    return ux * vx + uy * vy + uz * vz < -reach * lengths


@scalar
def _are_apart(x, a, b, p, q, reach):
    """Whether the boxes of segments a-b and p-q are farther apart than reach."""
    for axis in range(3):
        low, high = min(x[a, axis], x[b, axis]) - reach, max(x[a, axis], x[b, axis]) + reach
        if max(x[p, axis], x[q, axis]) < low or min(x[p, axis], x[q, axis]) > high:
            return True
    return False


@scalar
def _reach(x, a, b, p, q):
    """More than rounding moves any of four points by."""
    size = 0.0
    for axis in range(3):
        size = max(size, max(abs(x[a, axis]), abs(x[b, axis])))
        size = max(size, max(abs(x[p, axis]), abs(x[q, axis])))
    return _REACH * size + 1e-300


@scalar
def _may_overlap(x, ids, i, k):
    """Whether an end of one of two contacts' segments could lie inside the other one, or they are
    one segment twice.
    """
    a, b, p, q = ids[i, 0], ids[i, 1], ids[k, 0], ids[k, 1]
    reach = _reach(x, a, b, p, q)
    if a == p or a == q:
        a, b = b, a
    if b == q:
        p, q = q, p
    if b == p:  # they go on from each other, as nearly all of one face do
        if a == q:
            return True
        if _turns_away(x, a, b, q, reach):
            return False
    elif _are_apart(x, a, b, p, q, reach):
        return False
    return (
        is_near_segment(x, a, b, p, reach)
        or is_near_segment(x, a, b, q, reach)
        or is_near_segment(x, p, q, a, reach)
        or is_near_segment(x, p, q, b, reach)
    )


@entry("l1 l2 l -> l1")
def pairs_of_surfaces(surface, rows, n_surface):
    """Number of the pair of surfaces of each contact: ``n_surface * lower + upper``."""
    out = np.empty(rows.shape[0], dtype=np.int64)
    for k in range(rows.shape[0]):
        one, two = surface[rows[k, TRIANGLE_A]], surface[rows[k, TRIANGLE_B]]
        out[k] = n_surface * min(one, two) + max(one, two)
    return out


@entry("d2 l1 b1 l2 l2 -> l")
def overlap_free(x, surface, graph, rows, ids):
    """1 if contacts are segments, each once, that can hold no end of another one inside, else 0.

    Of another one of its two surfaces, that is. 0 also where a surface meets itself, and where a
    face has so many segments that it is dear to say. `surface` is that of each face, `graph` tells
    which of them have one point at most for each place in the map; contacts are sorted by their
    faces, and these by surfaces.
    """
    last = np.full(surface.shape[0], -1, dtype=np.int64)  # of those with it as their second face
    before = np.empty(rows.shape[0], dtype=np.int64)
    run = 0  # the first one with this first face and this second surface
    for k in range(rows.shape[0]):
        a, b = rows[k, TRIANGLE_A], rows[k, TRIANGLE_B]
        one, two = surface[a], surface[b]
        if one == two or not _crosses_faces(rows, k):
            return 0
        if a != rows[run, TRIANGLE_A] or two != surface[rows[run, TRIANGLE_B]]:
            run = k
        if not graph[two]:
            if k - run > _MANY:
                return 0
            for i in range(run, k):
                if _may_overlap(x, ids, i, k):
                    return 0
        if not graph[one]:
            before[k] = i = last[b]
            last[b] = k
            n_seen = 0
            while i >= 0 and surface[rows[i, TRIANGLE_A]] == one:
                n_seen += 1
                if n_seen > _MANY or _may_overlap(x, ids, i, k):
                    return 0
                i = before[i]
    return 1
