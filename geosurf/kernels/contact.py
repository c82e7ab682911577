"""How two triangles meet: every case, by exact signs of their corners only.

Features of a triangle are numbered 0, 1, 2 for its corners, 3, 4, 5 for its edges (edge 3 + i
joins corner i to the next) and 6 for its face. A point of contact is a pair of
features ``8 * fa + fb``: the lowest-dimensional features of A and of B that hold it.

Generic case, after Guigue & Devillers (2003, J. Graphics Tools 8(1)): signs of corners over
the other's plane, then signs of edge against edge. Zeros are not perturbed away: a corner with
sign 0 is located in the other triangle, and edge against edge with one zero is a point on both.

Letters as in `exact`; A, B triangles, sa, sb the signs of their corners.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels._jit import entry, scalar
from geosurf.kernels.exact import NEAR
from geosurf.kernels.predicates import normal_axis, orient2d, orient3d, plane_terms, side_of

FACE = 6
BY_SECOND = (
    8  # added to fa: edge meets edge, and A's edge lies in B's plane, so B's edge makes the point
)
OUTSIDE = -1
# columns of a contact row
TRIANGLE_A, TRIANGLE_B, COPLANAR, CROSSING, N_CORNER, FIRST_CODE = 0, 1, 2, 3, 4, 5
N_COLUMN = 11


@scalar
def _is_corner(t, tri, vertex):
    return t[tri, 0] == vertex or t[tri, 1] == vertex or t[tri, 2] == vertex


@scalar
def _feature_of_zeros(s0, s1, s2):
    """Feature from the signs of a point against the three edges; OUTSIDE if one is -1."""
    if s0 < 0 or s1 < 0 or s2 < 0:
        return OUTSIDE
    if s0 == 0:
        if s1 == 0:
            return 1
        if s2 == 0:
            return 0
        return 3
    if s1 == 0:
        return 2 if s2 == 0 else 4
    return 5 if s2 == 0 else FACE


@scalar
def locate_in_plane(x, t, e, d, m, w, tri, axis, turn, vertex):
    """Feature of a triangle that holds a vertex of its plane, or OUTSIDE."""
    if t[tri, 0] == vertex:
        return 0
    if t[tri, 1] == vertex:
        return 1
    if t[tri, 2] == vertex:
        return 2
    u = (axis + 1) % 3
    v = (axis + 2) % 3
    s0 = turn * orient2d(x, t, e, d, m, w, t[tri, 0], t[tri, 1], vertex, u, v)
    if s0 < 0:
        return OUTSIDE
    s1 = turn * orient2d(x, t, e, d, m, w, t[tri, 1], t[tri, 2], vertex, u, v)
    if s1 < 0:
        return OUTSIDE
    s2 = turn * orient2d(x, t, e, d, m, w, t[tri, 2], t[tri, 0], vertex, u, v)
    return _feature_of_zeros(s0, s1, s2)


@scalar
def _pierce(x, t, m, w, p, q, tri, slip):
    """Feature of a triangle where the line p-q passes, whose ends are on two sides of it."""
    signs = np.int64(0)
    zeros = 0
    last = -1
    for k in range(3):
        a = t[tri, k]
        b = t[tri, (k + 1) % 3]
        if p == a or p == b or q == a or q == b:
            s = 0
        else:
            s = orient3d(x, m, w, p, q, a, b, slip)
        if s == 0:
            zeros += 1
            last = k
        elif signs == 0:
            signs = s
        elif signs != s:
            return OUTSIDE
    if zeros == 0:
        return FACE
    if zeros == 1:
        return 3 + last
    return 0  # through a corner: that corner's own test finds it


@scalar
def _add(rows, n, fa, fb):
    rows[n, FIRST_CODE + rows[n, N_CORNER]] = 8 * fa + fb
    rows[n, N_CORNER] += 1


@scalar
def _side_signs(x, t, m, w, tri, of, slip):
    """Signs of the corners of triangle `of` over the plane of triangle `tri`."""
    a, b, c = t[tri, 0], t[tri, 1], t[tri, 2]
    frame = plane_terms(x, a, b, c)
    s0 = 0 if _is_corner(t, tri, t[of, 0]) else side_of(x, m, w, a, b, c, t[of, 0], frame, slip)
    s1 = 0 if _is_corner(t, tri, t[of, 1]) else side_of(x, m, w, a, b, c, t[of, 1], frame, slip)
    s2 = 0 if _is_corner(t, tri, t[of, 2]) else side_of(x, m, w, a, b, c, t[of, 2], frame, slip)
    return s0, s1, s2


@scalar
def _coplanar(x, t, e, d, m, w, rows, n, a, b):
    """Corners of the intersection of two triangles of one plane."""
    axis, turn_a = normal_axis(x, m, w, t[a, 0], t[a, 1], t[a, 2])
    axis, turn_b = normal_axis(x, m, w, t[b, 0], t[b, 1], t[b, 2])
    u = (axis + 1) % 3
    v = (axis + 2) % 3
    for i in range(3):
        feature = locate_in_plane(x, t, e, d, m, w, b, axis, turn_b, t[a, i])
        if feature != OUTSIDE:
            _add(rows, n, i, feature)
    for j in range(3):
        feature = locate_in_plane(x, t, e, d, m, w, a, axis, turn_a, t[b, j])
        if feature >= 3:
            _add(rows, n, feature, j)
    for i in range(3):
        p, q = t[a, i], t[a, (i + 1) % 3]
        for j in range(3):
            r, s = t[b, j], t[b, (j + 1) % 3]
            if p == r or p == s or q == r or q == s:
                continue
            if (
                orient2d(x, t, e, d, m, w, p, q, r, u, v)
                * orient2d(x, t, e, d, m, w, p, q, s, u, v)
                >= 0
            ):
                continue
            if (
                orient2d(x, t, e, d, m, w, r, s, p, u, v)
                * orient2d(x, t, e, d, m, w, r, s, q, u, v)
                < 0
            ):
                _add(rows, n, 3 + i, 3 + j)


@scalar
def meet(x, t, e, d, m, w, a, b, slip, rows, n):
    """Write the contact of triangles a and b to rows[n]; True if they meet."""
    a0, a1, a2 = _side_signs(x, t, m, w, b, a, slip)
    if a0 == a1 and a1 == a2 and a0 != 0:
        return False
    b0, b1, b2 = _side_signs(x, t, m, w, a, b, slip)
    if b0 == b1 and b1 == b2 and b0 != 0:
        return False
    rows[n, TRIANGLE_A] = a
    rows[n, TRIANGLE_B] = b
    rows[n, N_CORNER] = 0
    rows[n, CROSSING] = 0
    if a0 == 0 and a1 == 0 and a2 == 0:
        rows[n, COPLANAR] = 1
        _coplanar(x, t, e, d, m, w, rows, n, a, b)
        return rows[n, N_CORNER] > 0
    rows[n, COPLANAR] = 0
    sa = (a0, a1, a2)
    sb = (b0, b1, b2)
    axis_b, turn_b = -1, 0
    axis_a, turn_a = -1, 0
    for i in range(3):
        if sa[i] == 0:
            if axis_b < 0:
                axis_b, turn_b = normal_axis(x, m, w, t[b, 0], t[b, 1], t[b, 2])
            feature = locate_in_plane(x, t, e, d, m, w, b, axis_b, turn_b, t[a, i])
            if feature != OUTSIDE:
                _add(rows, n, i, feature)
    for i in range(3):
        if sa[i] * sa[(i + 1) % 3] < 0:
            feature = _pierce(x, t, m, w, t[a, i], t[a, (i + 1) % 3], b, slip)
            if feature >= 3:
                _add(rows, n, 3 + i, feature)
    for j in range(3):
        if sb[j] == 0:
            if axis_a < 0:
                axis_a, turn_a = normal_axis(x, m, w, t[a, 0], t[a, 1], t[a, 2])
            feature = locate_in_plane(x, t, e, d, m, w, a, axis_a, turn_a, t[b, j])
            if feature >= 3:
                _add(rows, n, feature, j)
    for j in range(3):
        if sb[j] * sb[(j + 1) % 3] < 0:
            feature = _pierce(x, t, m, w, t[b, j], t[b, (j + 1) % 3], a, slip)
            if feature == FACE:
                _add(rows, n, FACE, 3 + j)
            elif feature >= 3:
                i = feature - 3
                if sa[i] * sa[(i + 1) % 3] >= 0:  # else A's edge has found the same point
                    _add(rows, n, BY_SECOND + feature, 3 + j)
    if rows[n, N_CORNER] == 2:
        both_a = min(a0, min(a1, a2)) < 0 and max(a0, max(a1, a2)) > 0
        both_b = min(b0, min(b1, b2)) < 0 and max(b0, max(b1, b2)) > 0
        rows[n, CROSSING] = 1 if both_a and both_b else 0
    return rows[n, N_CORNER] > 0


@entry("d2 l2 l2 l1 l1 d l2 l1 -> l l")
def meet_pairs(x, t, pairs, m, w, slip, rows, near):
    """Contacts of candidate pairs of triangles; how many rows were written, and near pairs.

    `rows` has room for one row more than there are pairs. `near` takes the numbers of pairs
    that a move of all coordinates by `slip` could change; those beyond its end are only counted.
    """
    none = np.empty((0, 4), dtype=np.int64)
    n = 0
    n_near = 0
    for k in range(pairs.shape[0]):
        before = m[NEAR]
        if meet(x, t, none, none, m, w, pairs[k, 0], pairs[k, 1], slip, rows, n):
            n += 1
        if m[NEAR] != before:
            if n_near < near.shape[0]:
                near[n_near] = k
            n_near += 1
    return n, n_near
