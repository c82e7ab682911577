"""Faces that are cut as in an earlier arrangement: their children are renumbered, not made again.

Two arrangements have some surfaces in common. A face of these is unchanged if all that meets it
belongs to common surfaces, and all points there have the same definitions and coordinates.
Numbers differ, but their order does not: so the triangulation of such a face is the same, too.

Letters as in `naming`; a 0 marks what is of the earlier arrangement, and
    face     for each earlier face its new number, or -1
    point    for each earlier point its new number, or -1: vertices first
    changed  whether each new face has to be cut
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.contacts.packed_contact import HOW, TRIANGLE_A, TRIANGLE_B, n_corner_of


@entry("l1 l1 -> l1")
def places_among(numbers, others):
    """Place of each of some rising numbers among other rising numbers, or -1."""
    place = np.full(numbers.shape[0], -1, dtype=np.int64)
    k = 0
    for i in range(numbers.shape[0]):
        while k < others.shape[0] and others[k] < numbers[i]:
            k += 1
        if k < others.shape[0] and others[k] == numbers[i]:
            place[i] = k
    return place


@scalar
def _match_points(ids0, ids, i, k, n_corner, point):
    """Enter the points of one contact that is in both; False if they contradict earlier ones."""
    for c in range(n_corner):
        one = point[ids0[i, c]]
        if one < 0:
            point[ids0[i, c]] = ids[k, c]
        elif one != ids[k, c]:
            return False
    return True


@scalar
def _is_same_point(x0, d0, x, d, n_vertex0, n_vertex, face, point, p):
    """Whether an earlier point has the same coordinates and definition now."""
    q = point[p]
    for c in range(3):
        if x0[p, c] != x[q, c]:
            return False
    if p < n_vertex0:
        return q < n_vertex
    if q < n_vertex:
        return False
    one, other = p - n_vertex0, q - n_vertex
    same = d0[one, 0] == d[other, 0] and face[d0[one, 3]] == d[other, 3]
    return same and point[d0[one, 1]] == d[other, 1] and point[d0[one, 2]] == d[other, 2]


@scalar
def _same_points(x0, d0, x, d, n_vertex0, n_vertex, face, point):
    """Whether each new point is a known one, as it was; False too if the order is another."""
    known = np.zeros(x.shape[0], dtype=np.bool_)
    last = -1
    for p in range(point.shape[0]):
        if point[p] < 0:
            continue
        if point[p] <= last:
            return False, known
        last = point[p]
        known[last] = _is_same_point(x0, d0, x, d, n_vertex0, n_vertex, face, point, p)
    return True, known


@entry("l2 l2 d2 l2 b1 l1 l1 l2 l2 d2 l2 b1 l l -> b1 l")
def changed_faces(
    rows0, ids0, x0, d0, common0, face, point, rows, ids, x, d, common, n_vertex0, n_vertex
):
    """Which faces have to be cut, and 1; or 0 if the two arrangements have no common order.

    `common` tells which faces are of common surfaces. `point` has the vertices, and -1 for all
    constructed points, which are entered.
    """
    changed = np.zeros(common.shape[0], dtype=np.bool_)
    k = 0
    for i in range(rows0.shape[0]):
        a, b = rows0[i, TRIANGLE_A], rows0[i, TRIANGLE_B]
        if not (common0[a] and common0[b]):
            # what met a face met it earlier, and is gone
            if face[a] >= 0:
                changed[face[a]] = True
            if face[b] >= 0:
                changed[face[b]] = True
            continue

        # contacts of common surfaces come in the same order
        while k < rows.shape[0] and not (
            common[rows[k, TRIANGLE_A]] and common[rows[k, TRIANGLE_B]]
        ):
            changed[rows[k, TRIANGLE_A]] = changed[rows[k, TRIANGLE_B]] = True
            k += 1
        if k == rows.shape[0]:
            return changed, 0
        same = rows[k, TRIANGLE_A] == face[a] and rows[k, TRIANGLE_B] == face[b]
        if not same or rows[k, HOW] != rows0[i, HOW]:
            return changed, 0
        if not _match_points(ids0, ids, i, k, n_corner_of(rows[k, HOW]), point):
            return changed, 0
        k += 1
    for j in range(k, rows.shape[0]):
        a, b = rows[j, TRIANGLE_A], rows[j, TRIANGLE_B]
        if common[a] and common[b]:
            return changed, 0
        changed[a] = changed[b] = True

    # a point with another name or place changes all faces that have it
    ordered, known = _same_points(x0, d0, x, d, n_vertex0, n_vertex, face, point)
    if not ordered:
        return changed, 0
    for j in range(rows.shape[0]):
        for c in range(n_corner_of(rows[j, HOW])):
            if not known[ids[j, c]]:
                changed[rows[j, TRIANGLE_A]] = changed[rows[j, TRIANGLE_B]] = True
    return changed, 1


@entry("l2 l1 l1 l l1 b1 -> .")
def mark_crossed(t0, face0, id0, n, face, changed):
    """Mark faces as changed of which an earlier piece has a point with a number from n on.

    `id0` are numbers of the points of pieces, and `face0` the faces of these, or -1.
    """
    for i in range(t0.shape[0]):
        of = face[face0[i]] if face0[i] >= 0 else -1
        if of >= 0 and max(id0[t0[i, 0]], max(id0[t0[i, 1]], id0[t0[i, 2]])) >= n:
            changed[of] = True
