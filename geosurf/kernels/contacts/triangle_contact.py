"""How two triangles meet: every case, by exact signs of their corners only.

Features of a triangle are numbered 0, 1, 2 for its corners, 3, 4, 5 for its edges (edge 3 + i joins
corner i to the next) and 6 for its face. A point of contact is a pair of features ``8 * fa + fb``:
the lowest-dimensional features of A and of B that hold it.

Generic case, after Guigue & Devillers (2003, J. Graphics Tools 8(1)): signs of corners over the
other's plane, then signs of edge against edge. Zeros are not perturbed: a corner with sign 0 is
located in the other triangle, and edge against edge with one zero is a point on both.

Letters as in `exact_signs`; A, B triangles, sa, sb the signs of their corners.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.exact.exact_signs import NEAR
from geosurf.kernels.exact.predicates import (
    filtered_side,
    normal_axis,
    orient2d,
    orient3d,
    plane_terms,
    side_of,
)

FACE = 6
EDGE_OF_SECOND = 8  # added to fa where edges cross and the edge of B defines the point
OUTSIDE = -1
# columns of a contact row
TRIANGLE_A, TRIANGLE_B, COPLANAR, CROSSING, N_CORNER, FIRST_CODE = 0, 1, 2, 3, 4, 5
N_COLUMN = 11


@scalar
def is_corner(t, tri, vertex):
    """Whether a vertex is a corner of a triangle."""
    return t[tri, 0] == vertex or t[tri, 1] == vertex or t[tri, 2] == vertex


@scalar
def _feature_of_zeros(s0, s1, s2):
    """Feature from the signs of a point against the three edges; OUTSIDE if one is -1."""
    if s0 < 0 or s1 < 0 or s2 < 0:
        return OUTSIDE

    # Two zeros: the point is the corner that both edges share; one zero: inside that edge.
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
def locate_in_plane(x, t, m, w, tri, axis, turn, vertex):
    """Feature of a triangle that holds a vertex of its plane, or OUTSIDE."""
    # Shared vertices are recognised by number, without arithmetic.
    if t[tri, 0] == vertex:
        return 0
    if t[tri, 1] == vertex:
        return 1
    if t[tri, 2] == vertex:
        return 2

    # Turns in the projection along the largest component of the normal.
    u = (axis + 1) % 3
    v = (axis + 2) % 3
    s0 = turn * orient2d(x, m, w, t[tri, 0], t[tri, 1], vertex, u, v)
    if s0 < 0:
        return OUTSIDE
    s1 = turn * orient2d(x, m, w, t[tri, 1], t[tri, 2], vertex, u, v)
    if s1 < 0:
        return OUTSIDE
    s2 = turn * orient2d(x, m, w, t[tri, 2], t[tri, 0], vertex, u, v)
    return _feature_of_zeros(s0, s1, s2)


@scalar
def _pierce(x, t, m, w, p, q, tri, slip):
    """Feature of a triangle hit by line p-q, whose ends lie on two sides of its plane."""
    signs = np.int64(0)
    zeros = 0
    last = -1
    for k in range(3):
        # The line has to pass all three edges on the same side; a shared corner is a zero.
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

    # All edges on one side: the line hits the face; one zero: it hits that edge.
    if zeros == 0:
        return FACE
    if zeros == 1:
        return 3 + last
    return 0  # through a corner: the test of that corner finds it


@scalar
def _add(rows, n, fa, fb):
    rows[n, FIRST_CODE + rows[n, N_CORNER]] = 8 * fa + fb
    rows[n, N_CORNER] += 1


@scalar
def _side_signs(x, t, m, w, tri, other, slip):
    """Signs of the corners of triangle `other` over the plane of triangle `tri`."""
    a, b, c = t[tri, 0], t[tri, 1], t[tri, 2]
    frame = plane_terms(x, a, b, c)
    # A shared corner lies in the plane by definition.
    s0 = (
        0 if is_corner(t, tri, t[other, 0]) else side_of(x, m, w, a, b, c, t[other, 0], frame, slip)
    )
    s1 = (
        0 if is_corner(t, tri, t[other, 1]) else side_of(x, m, w, a, b, c, t[other, 1], frame, slip)
    )
    s2 = (
        0 if is_corner(t, tri, t[other, 2]) else side_of(x, m, w, a, b, c, t[other, 2], frame, slip)
    )
    return s0, s1, s2


@scalar
def _coplanar(x, t, m, w, rows, n, a, b):
    """Corners of the intersection of two triangles of one plane."""
    # Coplanar triangles have the same axis, since the first one wins ties.
    axis, turn_a = normal_axis(x, m, w, t[a, 0], t[a, 1], t[a, 2])
    axis, turn_b = normal_axis(x, m, w, t[b, 0], t[b, 1], t[b, 2])
    u = (axis + 1) % 3
    v = (axis + 2) % 3

    # Corners of A in B.
    for i in range(3):
        feature = locate_in_plane(x, t, m, w, b, axis, turn_b, t[a, i])
        if feature != OUTSIDE:
            _add(rows, n, i, feature)

    # Corners of B in the interior or on edges of A; common corners are found already.
    for j in range(3):
        feature = locate_in_plane(x, t, m, w, a, axis, turn_a, t[b, j])
        if feature >= 3:
            _add(rows, n, feature, j)
    for i in range(3):
        # Crossings of two edges, inside both.
        p, q = t[a, i], t[a, (i + 1) % 3]
        for j in range(3):
            r, s = t[b, j], t[b, (j + 1) % 3]
            # Edges with a common corner meet there; the corner is in the list already.
            if p == r or p == s or q == r or q == s:
                continue
            # A zero is an end on the other edge, which is in the list as a corner.
            if orient2d(x, m, w, p, q, r, u, v) * orient2d(x, m, w, p, q, s, u, v) >= 0:
                continue
            if orient2d(x, m, w, r, s, p, u, v) * orient2d(x, m, w, r, s, q, u, v) < 0:
                _add(rows, n, 3 + i, 3 + j)


@scalar
def _point_side(ox, oy, oz, terms, px, py, pz, slip):
    """Side of point p of the plane through o with `terms`; 0 if undecided."""
    n0, n1, n2, s0, s1, s2, span = terms
    return filtered_side(px - ox, py - oy, pz - oz, n0, n1, n2, s0, s1, s2, span, slip)


@scalar
def lone_corner(s0, s1, s2):
    """The corner with a sign that differs from the two others."""
    if s1 == s2:
        return 0
    return 1 if s0 == s2 else 2


@scalar
def _before_on_line(x, p, p1, q, q1, slip):
    """Sign that orders, on the common line, the points of edges p-p1 and q-q1; 0 if undecided."""
    terms = plane_terms(x, p, p1, q)
    return _point_side(x[p, 0], x[p, 1], x[p, 2], terms, x[q1, 0], x[q1, 1], x[q1, 2], slip)


@scalar
def _meet_filtered(x, t, a, b, slip, rows, n):
    """The contact of two triangles where floats certify every sign and none is zero.

    1 if they meet, 0 if not, -1 if exact signs are needed. Each triangle has one corner alone on
    its side of the other's plane. The two edges there carry the ends of its part of the common
    line, and four signs order the four ends (Guigue & Devillers 2003).
    """
    pa, pb, pc = t[a, 0], t[a, 1], t[a, 2]
    qa, qb, qc = t[b, 0], t[b, 1], t[b, 2]

    # Corners of A over the plane of B.
    f = plane_terms(x, qa, qb, qc)
    ox, oy, oz = x[qa, 0], x[qa, 1], x[qa, 2]
    a0 = _point_side(ox, oy, oz, f, x[pa, 0], x[pa, 1], x[pa, 2], slip)
    a1 = _point_side(ox, oy, oz, f, x[pb, 0], x[pb, 1], x[pb, 2], slip)
    a2 = _point_side(ox, oy, oz, f, x[pc, 0], x[pc, 1], x[pc, 2], slip)
    if a0 * a1 * a2 == 0:
        return -1
    if a0 == a1 and a1 == a2:
        return 0

    # Corners of B over the plane of A.
    f = plane_terms(x, pa, pb, pc)
    ox, oy, oz = x[pa, 0], x[pa, 1], x[pa, 2]
    b0 = _point_side(ox, oy, oz, f, x[qa, 0], x[qa, 1], x[qa, 2], slip)
    b1 = _point_side(ox, oy, oz, f, x[qb, 0], x[qb, 1], x[qb, 2], slip)
    b2 = _point_side(ox, oy, oz, f, x[qc, 0], x[qc, 1], x[qc, 2], slip)
    if b0 * b1 * b2 == 0:
        return -1
    if b0 == b1 and b1 == b2:
        return 0
    i, j = lone_corner(a0, a1, a2), lone_corner(b0, b1, b2)
    i2, j2 = (i + 2) % 3, (j + 2) % 3  # edge i leaves the lone corner, edge i2 comes back to it
    p, p1, p2 = t[a, i], t[a, (i + 1) % 3], t[a, i2]
    q, q1, q2 = t[b, j], t[b, (j + 1) % 3], t[b, j2]

    # Order of the four ends on the common line.
    s11 = _before_on_line(x, p, p1, q, q1, slip)
    s12 = _before_on_line(x, p, p1, q, q2, slip)
    s21 = _before_on_line(x, p, p2, q, q1, slip)
    s22 = _before_on_line(x, p, p2, q, q2, slip)
    if s11 * s12 * s21 * s22 == 0:
        return -1
    if s11 == s12 and s21 == s22 and s11 == s21:
        return 0

    # Two of the four ends bound the contact: edges of A, then edges of B.
    rows[n, TRIANGLE_A], rows[n, TRIANGLE_B], rows[n, N_CORNER] = a, b, 0
    rows[n, COPLANAR], rows[n, CROSSING] = 0, 1
    for k in range(3):
        if (k == i and s11 != s12) or (k == i2 and s21 != s22):
            _add(rows, n, 3 + k, FACE)
    for k in range(3):
        if (k == j and s11 != s21) or (k == j2 and s12 != s22):
            _add(rows, n, FACE, 3 + k)
    return 1


@scalar
def intersect_triangles(x, t, m, w, a, b, slip, rows, n):
    """Write the contact of triangles a and b to rows[n]; True if they meet."""
    plain = _meet_filtered(x, t, a, b, slip, rows, n)
    if plain >= 0:
        return plain == 1

    # Exact signs of all corners over the other plane.
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

    # All corners of A in the plane of B.
    if a0 == 0 and a1 == 0 and a2 == 0:
        rows[n, COPLANAR] = 1
        _coplanar(x, t, m, w, rows, n, a, b)
        return rows[n, N_CORNER] > 0
    rows[n, COPLANAR] = 0

    # Corners of A in the plane of B.
    sa = (a0, a1, a2)
    sb = (b0, b1, b2)
    # Axes of projection are computed on first use: most contacts have no zeros.
    axis_b, turn_b = -1, 0
    axis_a, turn_a = -1, 0
    for i in range(3):
        if sa[i] == 0:
            if axis_b < 0:
                axis_b, turn_b = normal_axis(x, m, w, t[b, 0], t[b, 1], t[b, 2])
            feature = locate_in_plane(x, t, m, w, b, axis_b, turn_b, t[a, i])
            if feature != OUTSIDE:
                _add(rows, n, i, feature)

    # Edges of A that pass the plane of B.
    for i in range(3):
        if sa[i] * sa[(i + 1) % 3] < 0:
            feature = _pierce(x, t, m, w, t[a, i], t[a, (i + 1) % 3], b, slip)
            # A line through a corner of B is found from that corner below.
            if feature >= 3:
                _add(rows, n, 3 + i, feature)

    # Corners of B in the plane of A, then edges of B.
    for j in range(3):
        if sb[j] == 0:
            if axis_a < 0:
                axis_a, turn_a = normal_axis(x, m, w, t[a, 0], t[a, 1], t[a, 2])
            feature = locate_in_plane(x, t, m, w, a, axis_a, turn_a, t[b, j])
            # Corners of A at corners of B are in the list already.
            if feature >= 3:
                _add(rows, n, feature, j)
    for j in range(3):
        if sb[j] * sb[(j + 1) % 3] < 0:
            feature = _pierce(x, t, m, w, t[b, j], t[b, (j + 1) % 3], a, slip)
            if feature == FACE:
                _add(rows, n, FACE, 3 + j)
            elif feature >= 3:
                i = feature - 3
                if sa[i] * sa[(i + 1) % 3] >= 0:  # otherwise the edge of A has found the same point
                    _add(rows, n, EDGE_OF_SECOND + feature, 3 + j)

    # A segment is a crossing if both triangles extend to both sides.
    if rows[n, N_CORNER] == 2:
        both_a = min(a0, min(a1, a2)) < 0 and max(a0, max(a1, a2)) > 0
        both_b = min(b0, min(b1, b2)) < 0 and max(b0, max(b1, b2)) > 0
        rows[n, CROSSING] = 1 if both_a and both_b else 0
    return rows[n, N_CORNER] > 0


@entry("d2 l2 l2 l1* l1* d l2* l1* -> l l")
def meet_pairs(x, t, pairs, m, w, slip, rows, near):
    """Contacts of candidate pairs of triangles; the numbers of rows written and of near pairs.

    `rows` needs room for one row more than there are pairs. `near` takes the indices of pairs that
    a move of all coordinates by `slip` could change; those beyond its end are only counted.
    """
    n = 0
    n_near = 0
    for k in range(pairs.shape[0]):
        # This counter rises with each sign that a small move could change.
        before = m[NEAR]
        if intersect_triangles(x, t, m, w, pairs[k, 0], pairs[k, 1], slip, rows, n):
            n += 1
        if m[NEAR] != before:
            if n_near < near.shape[0]:
                near[n_near] = k
            n_near += 1
    return n, n_near


# ---- stable contacts ----------------------------------------
# Pairs of triangles whose contact a rounding of their points could change.
#
# Certified signs with `slip` do not change under such a move (`predicates.filtered_side`). Two
# triangles meet only where an edge of one meets the other. An edge misses a triangle if its ends
# lie on one side of the plane, or if its line passes two edges of the triangle on different
# sides. So some pairs are proven to stay apart. Letters as in `exact_signs`.


@scalar
def _stable_side(x, a, b, c, o, slip):
    """Side of the plane of a, b, c on which vertex o lies; 0 where a move could change it.

    Floats may decide for one choice of the first corner and not for another. All three choices are
    tried, so the result does not depend on the numbering of corners.
    """
    for _ in range(3):
        n0, n1, n2, s0, s1, s2, span = plane_terms(x, a, b, c)
        cx, cy, cz = x[o, 0] - x[a, 0], x[o, 1] - x[a, 1], x[o, 2] - x[a, 2]
        side = filtered_side(cx, cy, cz, n0, n1, n2, s0, s1, s2, span, slip)
        if side != 0:
            return side

        # Rotate the corners and try again.
        a, b, c = b, c, a
    return 0


@scalar
def _stable_turn(x, p, q, a, b, slip):
    """Side of the plane of p, q, a on which vertex b lies, from any three of the four."""
    side = _stable_side(x, p, q, a, b, slip)
    if side == 0:
        # The same volume from another triple has the same sign and other rounding errors.
        side = _stable_side(x, q, p, b, a, slip)
    if side == 0:
        side = _stable_side(x, a, b, p, q, slip)
    if side == 0:
        side = _stable_side(x, b, a, q, p, slip)
    return side


@scalar
def _line_misses(x, t, p, q, b, slip):
    """Whether the line of vertices p, q certainly passes two edges of triangle b differently."""
    # A line that passes the edges on different sides misses the triangle.
    left = right = False
    # The side on which the line passes edge k, from the volume of both.
    for k in range(3):
        side = _stable_turn(x, p, q, t[b, k], t[b, (k + 1) % 3], slip)
        left = left or side > 0
        right = right or side < 0
    return left and right


@scalar
def _edges_miss(x, t, a, b, slip):
    """Whether no edge of triangle a can meet triangle b."""
    corners = t[b, 0], t[b, 1], t[b, 2]

    # Sides of the corners of a over the plane of b.
    s0 = _stable_side(x, corners[0], corners[1], corners[2], t[a, 0], slip)
    s1 = _stable_side(x, corners[0], corners[1], corners[2], t[a, 1], slip)
    s2 = _stable_side(x, corners[0], corners[1], corners[2], t[a, 2], slip)

    # Each edge stays on one side of the plane, or its line misses the triangle.
    return (
        (s0 * s1 > 0 or _line_misses(x, t, t[a, 0], t[a, 1], b, slip))
        and (s1 * s2 > 0 or _line_misses(x, t, t[a, 1], t[a, 2], b, slip))
        and (s2 * s0 > 0 or _line_misses(x, t, t[a, 2], t[a, 0], b, slip))
    )


@scalar
def _on_one_side(x, t, a, b, slip):
    """Whether all corners of triangle a certainly lie on one side of the plane of b."""
    # The other corners have to agree with the first one.
    side = _stable_side(x, t[b, 0], t[b, 1], t[b, 2], t[a, 0], slip)
    return side != 0 and (
        side == _stable_side(x, t[b, 0], t[b, 1], t[b, 2], t[a, 1], slip)
        and side == _stable_side(x, t[b, 0], t[b, 1], t[b, 2], t[a, 2], slip)
    )


@scalar
def _boxes_apart(x, t, a, b):
    """Whether the boxes of two triangles have no point in common."""
    for k in range(3):
        # Compare the intervals of both triangles on this axis.
        low = min(x[t[a, 0], k], min(x[t[a, 1], k], x[t[a, 2], k]))
        high = max(x[t[a, 0], k], max(x[t[a, 1], k], x[t[a, 2], k]))
        if max(x[t[b, 0], k], max(x[t[b, 1], k], x[t[b, 2], k])) < low:
            return True
        if min(x[t[b, 0], k], min(x[t[b, 1], k], x[t[b, 2], k])) > high:
            return True
    return False


@scalar
def _largest(x, t, a):
    """Largest absolute coordinate of a triangle."""
    size = 0.0
    for i in range(3):
        for k in range(3):
            size = max(size, abs(x[t[a, i], k]))
    return size


@scalar
def _stays_apart(x, t, a, b, slip):
    """Whether triangles stay apart; boxes are not widened, since rounded points stay in them."""
    return (
        _boxes_apart(x, t, a, b)
        or _on_one_side(x, t, a, b, slip)
        or _on_one_side(x, t, b, a, slip)
        or (_edges_miss(x, t, a, b, slip) and _edges_miss(x, t, b, a, slip))
    )


@scalar
def _is_near_plane(x, t, m, w, a, b, slip):
    """Whether a corner of triangle a is off the plane of b, but not certainly."""
    p, q, r = t[b, 0], t[b, 1], t[b, 2]
    for k in range(3):
        o = t[a, k]
        # Undecided by floats, but not exactly in the plane: a move could change its side.
        if _stable_side(x, p, q, r, o, slip) == 0 and orient3d(x, m, w, p, q, r, o, slip) != 0:
            return True
    return False


@entry("d2 l2 l1* l1* l2 b1 d -> b1")
def unstable_pairs(x, t, m, w, pairs, meet, part):
    """Pairs whose contact could change if points moved by a part of their coordinates.

    Of those that `meet`: pairs with a corner close to the other's plane, but not in it. Of the
    others: pairs that are not proven to stay apart.
    """
    unstable = np.empty(pairs.shape[0], dtype=np.bool_)
    for i in range(pairs.shape[0]):
        a, b = pairs[i, 0], pairs[i, 1]

        # The move is relative to the largest coordinate of the pair.
        slip = part * max(_largest(x, t, a), _largest(x, t, b))

        # Contacts: a corner must not be almost in the plane of the other triangle.
        if meet[i]:
            unstable[i] = _is_near_plane(x, t, m, w, a, b, slip) or _is_near_plane(
                x, t, m, w, b, a, slip
            )
        else:
            unstable[i] = not _stays_apart(x, t, a, b, slip)
    return unstable


# ---- packed contact ----------------------------------------
# Contacts in three numbers: two faces, and how they meet, packed into the third.
#
# All stages after the search run over all contacts several times. Rows of `triangle_contact`, with
# room for six corners, have eleven numbers; three are read from memory in a quarter of the time.
#
# Notation
#     rows   contacts, int64 (n, 3), columns below
#     how    number of corners (3 bits), whether the faces are coplanar and whether they cross (1
#            bit each), and the code of each corner (7 bits), the first one lowest


HOW = 2
_CORNERS, _IN_PLANE, _CROSSING = 7, 8, 16  # masks
_FIRST, _CODE = 5, 7  # bits before the codes, and of each


@scalar
def n_corner_of(how):
    """Number of corners of a contact."""
    return how & _CORNERS


@scalar
def lies_in_plane(how):
    """Whether two faces are coplanar."""
    return how & _IN_PLANE != 0


@scalar
def code_of(how, corner):
    """Code of a corner of a contact, see `triangle_contact`."""
    return (how >> (_FIRST + _CODE * corner)) & ((1 << _CODE) - 1)


@scalar
def lies_on_boundaries(how):
    """Whether a contact is a point or a line on edges and corners of both faces."""
    # Three corners or more: an area.
    if n_corner_of(how) >= 3:
        return False
    for corner in range(n_corner_of(how)):
        code = code_of(how, corner)
        # A corner in the face of either triangle is not on its boundary.
        if (code >> 3) & 7 >= FACE or code & 7 >= FACE:
            return False
    return True


def n_corners(rows: np.ndarray) -> np.ndarray:
    """Number of corners of each contact, int64 (n,)."""
    return rows[:, HOW] & _CORNERS


def in_plane(rows: np.ndarray) -> np.ndarray:
    """Whether the faces of each contact lie in one plane, bool (n,)."""
    return rows[:, HOW] & _IN_PLANE != 0


def on_boundaries(rows: np.ndarray) -> np.ndarray:
    """Which contacts are points and lines on edges and corners of both faces, bool (n,)."""
    n = n_corners(rows)
    on_boundary: np.ndarray = n < 3
    for corner in range(2):
        code = code_of(rows[:, HOW], corner)
        inside = ((code >> 3) & 7 >= FACE) | (code & 7 >= FACE)
        on_boundary &= ~(inside & (corner < n))
    return on_boundary


@entry("l2 -> l2")
def pack_contacts(rows):
    """Pack rows of `triangle_contact` into three numbers."""
    out = np.empty((rows.shape[0], 3), dtype=np.int64)
    for k in range(rows.shape[0]):
        # Number of corners in the lowest bits, then flags, then codes.
        how = rows[k, N_CORNER]
        how += _IN_PLANE if rows[k, COPLANAR] == 1 else 0
        how += _CROSSING if rows[k, CROSSING] == 1 else 0
        for corner in range(rows[k, N_CORNER]):
            how += rows[k, FIRST_CODE + corner] << (_FIRST + _CODE * corner)
        out[k, TRIANGLE_A], out[k, TRIANGLE_B], out[k, HOW] = rows[k, 0], rows[k, 1], how
    return out


NEAR_BIT = 60  # of a settled code; corners need fewer bits
NOTHING = 0  # the settled code of a pair that does not meet: contacts have corners


@entry("l2 l2 l1 -> l1")
def settled(pairs, rows, near):
    """How each pair meets: the third number of its row, or NOTHING, and a bit for near pairs.

    `rows` are those of the pairs that meet, in the order of `pairs`; `near` are rows of `pairs`.
    """
    out = np.empty(pairs.shape[0], dtype=np.int64)
    n = 0
    for k in range(pairs.shape[0]):
        out[k] = NOTHING
        if n < rows.shape[0] and rows[n, 0] == pairs[k, 0] and rows[n, 1] == pairs[k, 1]:
            out[k] = rows[n, HOW]
            n += 1
    for k in range(near.shape[0]):
        out[near[k]] |= 1 << NEAR_BIT
    return out


def of_settled(pairs: np.ndarray, codes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Contacts (n, 3) and near pairs (n, 2) of settled pairs."""
    how = codes & ((1 << NEAR_BIT) - 1)
    meet = np.flatnonzero(how != NOTHING)
    rows = np.concatenate([pairs[meet], how[meet, None]], axis=1)
    return rows, pairs[(codes >> NEAR_BIT) & 1 == 1]
