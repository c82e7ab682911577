"""How triangles of one cell meet those of a patch of another grid: heights of corners, few signs.

The height of a corner over a triangle's plane, and its distances from the triangle's edges in a
projection along an axis, are linear. So the point where an edge of another triangle passes the
plane follows from the heights of its ends, and whether it lies inside follows from two products.
All rounding bounds hold for the whole patch. Mostly both edges that pass the plane pass the face,
or one passes beyond one edge, which then ends the contact (`contact_by_heights`). Where both pass
outside, by a corner, or a sign is undecided, `decide_contact` computes the signs of
`triangle_contact`.

Notation
    c      corners in the local frame, float64 (8, 3): of a cell of the patch, then of the one cell
    v      corners (rows of c) of triangles, int64 (4, 3): 0 and 1 of the patch, 2 and 3 of the cell
    f      plane of each triangle, float64 (4, 7): see `predicates.plane_terms`
    reach  largest distance of corners of the patch from those of the one cell, by axis
    h      query for triangles 2 and 3, plane and edges: float64 (2, N_TERM)
    w      answers for corners 0 to 3: heights, then distances from each edge, float64 (4, 4)
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.contacts.contact_table import N_SIDE, UNDECIDED, UNKNOWN_SIDE, code_of_edge
from geosurf.kernels.contacts.triangle_contact import lone_corner
from geosurf.kernels.exact.predicates import ORIENT2D_BOUND, ORIENT3D_BOUND, TINY, filtered_side
from geosurf.kernels.search.tree import RISING, TURNED

NEEDS_EXACT = -1  # instead of the codes of a pair
# indices into h: a corner, normal, bound; axis of projection; for each edge a corner, steps, and
# the error bounds of a distance and of a product of height and distance
CORNER, NORMAL, BOUND, _AXIS, _EDGE, N_TERM = 0, 3, 6, 7, 8, 26
_OFF, _BOTH, _STEP = 4, 5, 6
_SLACK = 1.0 + 1e-9  # covers the rounding of the bounds themselves
_EPS = 2.0**-53


@scalar
def corners_of_cell(a, v, first):
    """Write the corners of both triangles of a cell into two rows of v: see `strips.corner_of`."""
    rising = a[RISING] == 1
    # Triangles 0 and 1 belong to the patch, 2 and 3 to the cell.
    for half in range(2):
        tri = half if first == 0 else 2 + half
        v[tri, 0] = first + (1 if half == 1 and not rising else 0)
        two = first + (2 if half == 1 else 1)
        three = first + (2 if half == 0 and rising else 3)
        v[tri, 1] = three if a[TURNED] == 1 else two
        v[tri, 2] = two if a[TURNED] == 1 else three


@scalar
def plane_of(c, f, tri, v):
    """Write the plane terms of a triangle; whether all its corners exist."""
    o, p, q = v[tri, 0], v[tri, 1], v[tri, 2]
    ax, ay, az = c[p, 0] - c[o, 0], c[p, 1] - c[o, 1], c[p, 2] - c[o, 2]
    bx, by, bz = c[q, 0] - c[o, 0], c[q, 1] - c[o, 1], c[q, 2] - c[o, 2]
    p0, q0 = ay * bz, az * by
    p1, q1 = az * bx, ax * bz
    p2, q2 = ax * by, ay * bx
    f[tri, 0], f[tri, 1], f[tri, 2] = p0 - q0, p1 - q1, p2 - q2
    f[tri, 3], f[tri, 4], f[tri, 5] = abs(p0) + abs(q0), abs(p1) + abs(q1), abs(p2) + abs(q2)
    f[tri, 6] = abs(ax) + abs(ay) + abs(az) + abs(bx) + abs(by) + abs(bz)

    # NaN marks a missing corner.
    total = ax + ay + az + bx + by + bz
    return total == total


@scalar
def _main_axis(f, tri, slip):
    """Axis of the largest component of a normal, and its sign; 0 if undecided."""
    # The sign is certain if the component exceeds its rounding error and any slip.
    axis = 0
    for k in range(1, 3):
        axis = k if abs(f[tri, k]) > abs(f[tri, axis]) else axis
    bound = _SLACK * (ORIENT2D_BOUND * f[tri, 3 + axis] + 2.0 * slip * f[tri, 6]) + TINY
    if not abs(f[tri, axis]) > bound:
        return axis, 0
    return axis, (1 if f[tri, axis] > 0.0 else -1)


@scalar
def set_plane_query(c, f, v, tri, reach, slip, h):
    """Write the query for the plane of a triangle, with the rounding bound of its answers.

    An answer beyond the bound holds under any move of all coordinates by up to `slip`. False where
    a corner is missing.
    """
    if not plane_of(c, f, tri, v):
        return False

    # One bound for all corners of the patch, from their largest distances.
    far = reach[0] + reach[1] + reach[2]
    own = f[tri, 3] + f[tri, 4] + f[tri, 5]
    height = _largest_height(f, tri, reach)
    h[BOUND] = _SLACK * (ORIENT3D_BOUND * height + 2.0 * slip * (own + far * f[tri, 6])) + TINY
    for k in range(3):
        h[CORNER + k], h[NORMAL + k] = c[v[tri, 0], k], f[tri, k]
    return True


@scalar
def _largest_height(f, tri, reach):
    """Upper bound of the terms of a height over a triangle."""
    return reach[0] * f[tri, 3] + reach[1] * f[tri, 4] + reach[2] * f[tri, 5]


@scalar
def set_edge_query(c, f, v, tri, reach, slip, h):
    """Write the query for the edges of a triangle, in a projection; after `set_plane_query`."""
    # Orient the edges so that inside is positive.
    height, off = _largest_height(f, tri, reach), h[BOUND]
    axis, turn = _main_axis(f, tri, slip)
    h[_AXIS] = axis
    # Along the largest component of its normal, a triangle projects without collapsing.
    u, w = (axis + 1) % 3, (axis + 2) % 3
    for k in range(3):
        p, q = v[tri, k], v[tri, (k + 1) % 3]
        at = _EDGE + _STEP * k
        on, up = turn * (c[q, u] - c[p, u]), turn * (c[q, w] - c[p, w])
        h[at], h[at + 1], h[at + 2], h[at + 3] = c[p, u], c[p, w], on, up

        # Largest distance from the edge, and its rounding error.
        inside = abs(on) * reach[w] + abs(up) * reach[u]
        far = abs(on) + abs(up) + reach[u] + reach[w] + 4.0 * slip
        error = _SLACK * (ORIENT2D_BOUND * inside + 2.0 * slip * far) + TINY
        # of a difference of two products of a height and a distance
        both = height * error + off * (inside + error) + 4.0 * _EPS * height * inside
        # Without a certain direction of the normal every answer counts as undecided.
        h[at + _OFF] = np.inf if turn == 0 else error
        h[at + _BOTH] = np.inf if turn == 0 else 2.0 * _SLACK * both + TINY


@scalar
def edge_distances(c, h, w):
    """Distances of corners 0 to 3 inside each edge of a triangle, in a projection along an axis.

    False if all of them are certainly beyond one edge.
    """
    # The columns are constants, so that the loop can be specialised for each projection.
    if h[_AXIS] == 0.0:
        return _insides(c, 1, 2, h, w)
    if h[_AXIS] == 1.0:
        return _insides(c, 2, 0, h, w)
    return _insides(c, 0, 1, h, w)


@scalar
def _insides(c, u, v, h, w):
    for k in range(3):
        at = _EDGE + _STEP * k
        p, q, on, up, off = h[at], h[at + 1], h[at + 2], h[at + 3], h[at + _OFF]
        one = on * (c[0, v] - q) - up * (c[0, u] - p)
        two = on * (c[1, v] - q) - up * (c[1, u] - p)
        three = on * (c[2, v] - q) - up * (c[2, u] - p)
        four = on * (c[3, v] - q) - up * (c[3, u] - p)
        # `&` evaluates all four: branches could be mispredicted.
        if (one < -off) & (two < -off) & (three < -off) & (four < -off):
            return False
        w[1 + k, 0], w[1 + k, 1], w[1 + k, 2], w[1 + k, 3] = one, two, three, four
    return True


@scalar
def _side(c, f, tri, o, corner, slip):
    """Side of the plane of a triangle with corner o on which another corner lies, or 0."""
    cx, cy, cz = c[corner, 0] - c[o, 0], c[corner, 1] - c[o, 1], c[corner, 2] - c[o, 2]
    return filtered_side(
        cx, cy, cz, f[tri, 0], f[tri, 1], f[tri, 2], f[tri, 3], f[tri, 4], f[tri, 5], f[tri, 6],
        slip,
    )  # fmt: skip


@scalar
def _order(c, p, p1, q, q1, slip):
    """Sign that orders, on the common line, the points of edges p-p1 and q-q1; or 0."""
    ax, ay, az = c[p1, 0] - c[p, 0], c[p1, 1] - c[p, 1], c[p1, 2] - c[p, 2]
    bx, by, bz = c[q, 0] - c[p, 0], c[q, 1] - c[p, 1], c[q, 2] - c[p, 2]
    # Plane of p, p1, q; q1 lies on the side that tells which edge passes first.
    g, h = ay * bz, az * by
    r, s = az * bx, ax * bz
    u, v = ax * by, ay * bx
    span = abs(ax) + abs(ay) + abs(az) + abs(bx) + abs(by) + abs(bz)
    cx, cy, cz = c[q1, 0] - c[p, 0], c[q1, 1] - c[p, 1], c[q1, 2] - c[p, 2]
    return filtered_side(
        cx, cy, cz, g - h, r - s, u - v, abs(g) + abs(h), abs(r) + abs(s), abs(u) + abs(v), span,
        slip,
    )  # fmt: skip


@scalar
def _outside(w, p, q, h):
    """Edges of a triangle, as bits, beyond which an edge p-q passes its plane; or UNKNOWN_SIDE.

    The heights of p and q over the plane have opposite signs.
    """
    # Interpolate the distances at the plane, multiplied by the heights of both ends.
    one, two = abs(w[0, p]), abs(w[0, q])
    first, second, third = (
        one * w[1, q] + two * w[1, p],
        one * w[2, q] + two * w[2, p],
        one * w[3, q] + two * w[3, p],
    )
    certified = (
        (abs(first) > h[_EDGE + _BOTH])
        & (abs(second) > h[_EDGE + _STEP + _BOTH])
        & (abs(third) > h[_EDGE + 2 * _STEP + _BOTH])
    )

    # Bit k is set where the edge passes outside edge k of the triangle.
    out = (1 if first < 0.0 else 0) + (2 if second < 0.0 else 0) + (4 if third < 0.0 else 0)
    return out if certified else UNKNOWN_SIDE


@scalar
def contact_by_heights(w, v, one, h, codes_table):
    """How triangle `one` meets that of h: 0 if not, UNDECIDED, or two codes in one number.

    `codes_table` is from `contact_codes`: a table lookup has no branch to mispredict.
    """
    # All heights have to be certain; two edges pass the plane or none.
    p, q, r = v[one, 0], v[one, 1], v[one, 2]
    a, b, c = w[0, p], w[0, q], w[0, r]
    if not ((abs(a) > h[BOUND]) & (abs(b) > h[BOUND]) & (abs(c) > h[BOUND])):
        return UNDECIDED
    one_two, two_three = (a > 0.0) != (b > 0.0), (b > 0.0) != (c > 0.0)
    if not (one_two | two_three):
        return 0
    # edge k joins corner k to the next; two of them pass the plane
    if one_two & two_three:
        i, first, last = 1, _outside(w, q, r, h), _outside(w, p, q, h)
    elif one_two:
        i, first, last = 0, _outside(w, p, q, h), _outside(w, r, p, h)
    else:
        i, first, last = 2, _outside(w, r, p, h), _outside(w, q, r, h)
    return codes_table[(N_SIDE * i + first) * N_SIDE + last]


@scalar
def _apart_on(c, axis, o, p, q, r, s, t):
    """Whether triangles o p q and r s t are apart on one axis, by more than a distance."""
    low = min(c[o, axis], min(c[p, axis], c[q, axis]))
    high = max(c[o, axis], max(c[p, axis], c[q, axis]))
    least = min(c[r, axis], min(c[s, axis], c[t, axis]))
    most = max(c[r, axis], max(c[s, axis], c[t, axis]))
    return low > most or least > high


@scalar
def _boxes_apart(c, v, one, two):
    """Whether the boxes of two triangles do not meet."""
    o, p, q = v[one, 0], v[one, 1], v[one, 2]
    r, s, t = v[two, 0], v[two, 1], v[two, 2]
    return (
        _apart_on(c, 2, o, p, q, r, s, t)
        or _apart_on(c, 0, o, p, q, r, s, t)
        or _apart_on(c, 1, o, p, q, r, s, t)
    )


@scalar
def _add_codes(codes, i, i2, on_first, on_last, of_first):
    """Append the codes of a triangle's edges i and i2 through the face of the other."""
    for k in range(3):
        if (k == i and on_first) or (k == i2 and on_last):
            codes = 64 * codes + code_of_edge(k, of_first)
    return codes


@scalar
def decide_contact(c, f, v, one, two, slip, swapped):
    """How two triangles meet: 0 if not, NEEDS_EXACT, or two codes in one number.

    The same signs in the same order as in `triangle_contact._meet_filtered`.
    """
    # Boxes first, then sides of corners over both planes.
    if _boxes_apart(c, v, one, two) or not plane_of(c, f, one, v):
        return 0
    o, p = v[two, 0], v[one, 0]
    a0 = _side(c, f, two, o, v[one, 0], slip)
    a1 = _side(c, f, two, o, v[one, 1], slip)
    a2 = _side(c, f, two, o, v[one, 2], slip)
    # A zero means undecided here: exact signs tell touching from near.
    if a0 * a1 * a2 == 0:
        return NEEDS_EXACT
    if a0 == a1 and a1 == a2:
        return 0
    b0 = _side(c, f, one, p, v[two, 0], slip)
    b1 = _side(c, f, one, p, v[two, 1], slip)
    b2 = _side(c, f, one, p, v[two, 2], slip)
    if b0 * b1 * b2 == 0:
        return NEEDS_EXACT
    if b0 == b1 and b1 == b2:
        return 0

    # Each triangle has one lone corner; four signs order the ends on the common line.
    i, j = lone_corner(a0, a1, a2), lone_corner(b0, b1, b2)
    i2, j2 = (i + 2) % 3, (j + 2) % 3
    p, p1, p2 = v[one, i], v[one, (i + 1) % 3], v[one, i2]
    q, q1, q2 = v[two, j], v[two, (j + 1) % 3], v[two, j2]
    s11, s12 = _order(c, p, p1, q, q1, slip), _order(c, p, p1, q, q2, slip)
    s21, s22 = _order(c, p, p2, q, q1, slip), _order(c, p, p2, q, q2, slip)
    if s11 * s12 * s21 * s22 == 0:
        return NEEDS_EXACT
    # Both ends of one part come before both ends of the other: the parts do not overlap.
    if s11 == s12 and s21 == s22 and s11 == s21:
        return 0

    # Codes of the ends: edges of both triangles in the order of `triangle_contact`.
    if swapped:
        codes = _add_codes(0, j, j2, s11 != s21, s12 != s22, True)
        return _add_codes(codes, i, i2, s11 != s12, s21 != s22, False)
    codes = _add_codes(0, i, i2, s11 != s12, s21 != s22, True)
    return _add_codes(codes, j, j2, s11 != s21, s12 != s22, False)
