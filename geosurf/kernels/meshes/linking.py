"""Segments of curves that cannot overlap, which need no general overlap test.

Where triangles meet in segments that cross their faces, no segment can hold an end point of another
one inside, unless both lie in one face. Proof: let p, an end of the segment of faces a' and b', lie
inside that of a and b. Then p is in a and in b', which therefore meet too: in a segment that ends
at p and lies in a next to the first; or p is inside that segment. Likewise for a' and b. But p is
on the boundary of a' or of b', and a segment with a boundary point inside runs along the boundary.
So it is enough to compare the segments of each face, if none runs along an edge.

The test is per pair of surfaces. If one of them is single-valued in the map, two segments in a face
of the other need no comparison: they lie inside two triangles of the first, and no point inside one
of these lies in another.

Letters as in `exact_signs`; contacts as in `packed_contact`.
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

_MANY = 64  # segments of a face above which the general test is faster
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

    # Both features have to belong to one edge.
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

    # A segment along an edge of either face may coincide with another one.
    one, two = code_of(how, 0), code_of(how, 1)
    return not (_on_one_edge((one >> 3) & 7, (two >> 3) & 7) or _on_one_edge(one & 7, two & 7))


@scalar
def _turns_away(x, p, a, q, reach):
    """Whether p and q certainly lie on two sides of a: segments a-p and a-q cannot overlap.

    If the true points lie on one ray from a, the scalar product of their differences from a is
    positive. Its error is below `reach` times both lengths: `reach` is more than ten times the
    rounding of points.
    """
    # The scalar product of both directions from a.
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
    """Upper bound of the rounding of any of four points."""
    size = 0.0
    for axis in range(3):
        size = max(size, max(abs(x[a, axis]), abs(x[b, axis])))
        size = max(size, max(abs(x[p, axis]), abs(x[q, axis])))
    return _REACH * size + 1e-300


@scalar
def _may_overlap(x, ids, i, k):
    """Whether an end of one of two contacts' segments could lie inside the other, or both segments
    are equal.
    """
    a, b, p, q = ids[i, 0], ids[i, 1], ids[k, 0], ids[k, 1]
    reach = _reach(x, a, b, p, q)

    # Order the ends so that a common end is b = p.
    if a == p or a == q:
        a, b = b, a
    if b == q:
        p, q = q, p
    if b == p:  # consecutive, as nearly all segments of one face
        # Both segments have the same ends.
        if a == q:
            return True
        if _turns_away(x, a, b, q, reach):
            return False
    elif _are_apart(x, a, b, p, q, reach):
        return False

    # Any end inside the other segment is an overlap.
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
    """1 if contacts are distinct segments without an end of another one inside, else 0.

    Only segments of the same two surfaces are compared. 0 also if a surface meets itself, or a
    face has very many segments. `surface` is that of each face; `graph` says which surfaces are
    single-valued in the map. Contacts are sorted by their faces, and these by surfaces.
    """
    last = np.full(surface.shape[0], -1, dtype=np.int64)  # last contact with each second face
    before = np.empty(rows.shape[0], dtype=np.int64)
    run = 0  # the first one with this first face and this second surface
    for k in range(rows.shape[0]):
        a, b = rows[k, TRIANGLE_A], rows[k, TRIANGLE_B]
        one, two = surface[a], surface[b]
        # The proof above needs two different surfaces and segments inside faces.
        if one == two or not _crosses_faces(rows, k):
            return 0

        # Contacts are sorted: a run shares the first face and the second surface.
        if a != rows[run, TRIANGLE_A] or two != surface[rows[run, TRIANGLE_B]]:
            run = k

        # Other contacts of the first face with this surface.
        # Inside two triangles of a single-valued surface, segments cannot overlap.
        if not graph[two]:
            if k - run > _MANY:
                return 0
            for i in range(run, k):
                if _may_overlap(x, ids, i, k):
                    return 0

        # Other contacts of the second face with this surface, as a linked list.
        if not graph[one]:
            before[k] = i = last[b]
            last[b] = k
            n_seen = 0
            # Contacts are sorted by surfaces: the first one of another surface ends the list.
            while i >= 0 and surface[rows[i, TRIANGLE_A]] == one:
                n_seen += 1
                if n_seen > _MANY or _may_overlap(x, ids, i, k):
                    return 0
                i = before[i]
    return 1
