"""Positions of constructed points, 64 at a time: plain doubles first, then double-double
arithmetic.

These are the operations and bounds of `constructed_points.lpi_in_doubles` and
`double_double.lpi_dd` as loops without branches over the lanes of a block. They are vectorised,
and a point costs a fifth. Where edges are short compared to coordinates, as in grids, plain
doubles certify nine points in ten; with long edges they certify none.

Letters as in `exact_signs`, and
    f      a block: rows of `LANES` doubles, one after the other, at the offsets below
A pair (two rows) is a double-double. All rows lie in one array at constant offsets, so that the
compiler can prove that they do not overlap.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.exact.constructed_points import (
    UNDERFLOW,
    dd_add,
    dd_minor,
    dd_mul,
    round_point,
    rounds_to,
    two_sum,
)
from geosurf.kernels.exact.exact_signs import N_TRIANGLE, N_VERTEX, Frame
from geosurf.kernels.exact.predicates import (
    ORIENT3D_BOUND,
    TINY,
    filtered_side,
    orient3d,
    plane_terms,
)
from geosurf.kernels.lattices.lattice_corners import prefetch

LANES = 64
# the ends of the edge, the corners of the triangle: three coordinates each
_A0, _A1, _A2 = 0, LANES, 2 * LANES
_B0, _B1, _B2 = 3 * LANES, 4 * LANES, 5 * LANES
_O0, _O1, _O2 = 6 * LANES, 7 * LANES, 8 * LANES
_P0, _P1, _P2 = 9 * LANES, 10 * LANES, 11 * LANES
_Q0, _Q1, _Q2 = 12 * LANES, 13 * LANES, 14 * LANES
# the normal, pairs; the sizes of its terms
_N0, _N1, _N2 = 15 * LANES, 17 * LANES, 19 * LANES
_S0, _S1, _S2 = 21 * LANES, 22 * LANES, 23 * LANES
# heights of the ends over the plane, pairs, and the sum of the sizes of their terms
_HA, _HB, _SIZE = 24 * LANES, 26 * LANES, 28 * LANES
# the fraction of the edge, a pair; its error; 1.0 while all is certified
_FRACTION, _ERROR, _CERTIFIED = 29 * LANES, 31 * LANES, 32 * LANES
_ROWS = 33


@scalar
def _load(x, t, d, m, row, lane, f):
    """Load the edge and the triangle of a point; any triangle for an edge plane."""
    # Edge planes are placed one by one later; load any valid triangle instead.
    a, b, plane = d[row, 1], d[row, 2], d[row, 3] if d[row, 3] < m[N_TRIANGLE] else 0
    o, p, q = t[plane, 0], t[plane, 1], t[plane, 2]
    f[_A0 + lane], f[_A1 + lane], f[_A2 + lane] = x[a, 0], x[a, 1], x[a, 2]
    f[_B0 + lane], f[_B1 + lane], f[_B2 + lane] = x[b, 0], x[b, 1], x[b, 2]
    f[_O0 + lane], f[_O1 + lane], f[_O2 + lane] = x[o, 0], x[o, 1], x[o, 2]
    f[_P0 + lane], f[_P1 + lane], f[_P2 + lane] = x[p, 0], x[p, 1], x[p, 2]
    f[_Q0 + lane], f[_Q1 + lane], f[_Q2 + lane] = x[q, 0], x[q, 1], x[q, 2]


@scalar
def _prefetch_blocks(x, t, d, m, first, last):
    """Prefetch what the next block will load, and the triangles of the block after it.

    Edges and triangles of a point may lie anywhere in memory; this saves a tenth of the time.
    """
    for row in range(first + LANES, min(first + 2 * LANES, last)):
        plane = d[row, 3] if d[row, 3] < m[N_TRIANGLE] else 0
        prefetch(x, d[row, 1])
        prefetch(x, d[row, 2])
        prefetch(x, t[plane, 0])
        prefetch(x, t[plane, 1])
        prefetch(x, t[plane, 2])
    for row in range(first + 2 * LANES, min(first + 3 * LANES, last)):
        prefetch(t, d[row, 3])


@scalar
def _normals_double(f):
    """Normals of the planes in plain doubles, and the sizes of their terms."""
    for i in range(LANES):
        # Two sides of the triangle, from its corner o.
        g0, g1, g2 = f[_P0 + i] - f[_O0 + i], f[_P1 + i] - f[_O1 + i], f[_P2 + i] - f[_O2 + i]
        h0, h1, h2 = f[_Q0 + i] - f[_O0 + i], f[_Q1 + i] - f[_O1 + i], f[_Q2 + i] - f[_O2 + i]
        f[_N0 + i], f[_S0 + i] = g1 * h2 - g2 * h1, abs(g1 * h2) + abs(g2 * h1)
        f[_N1 + i], f[_S1 + i] = g2 * h0 - g0 * h2, abs(g2 * h0) + abs(g0 * h2)
        f[_N2 + i], f[_S2 + i] = g0 * h1 - g1 * h0, abs(g0 * h1) + abs(g1 * h0)


@scalar
def _fractions_double(f):
    """Fraction of each edge before the plane, and its error, as in `lpi_in_doubles`."""
    for i in range(LANES):
        n0, n1, n2 = f[_N0 + i], f[_N1 + i], f[_N2 + i]
        s0, s1, s2 = f[_S0 + i], f[_S1 + i], f[_S2 + i]

        # Height of the first end, and the sizes of its terms.
        c0, c1, c2 = f[_A0 + i] - f[_O0 + i], f[_A1 + i] - f[_O1 + i], f[_A2 + i] - f[_O2 + i]
        ha, fa = c0 * n0 + c1 * n1 + c2 * n2, abs(c0) * s0 + abs(c1) * s1 + abs(c2) * s2

        # Height of the second end.
        c0, c1, c2 = f[_B0 + i] - f[_O0 + i], f[_B1 + i] - f[_O1 + i], f[_B2 + i] - f[_O2 + i]
        hb, fb = c0 * n0 + c1 * n1 + c2 * n2, abs(c0) * s0 + abs(c1) * s1 + abs(c2) * s2
        below = ha - hb

        # Select instead of branching: an uncertified lane divides by 1.0.
        off = 4.0 * ORIENT3D_BOUND * (fa + fb)
        known = (min(fa, fb) > TINY) & (ha * hb <= 0.0) & (off < abs(below)) & (abs(below) < np.inf)
        below = below if known else 1.0
        f[_FRACTION + i] = ha / below
        f[_ERROR + i] = 1.34 * ORIENT3D_BOUND * max(fa, fb) / abs(below) + 2.0**-50
        f[_CERTIFIED + i] = 1.0 if known else 0.0


@scalar
def _along_double(start, end, part, error):
    """One coordinate, and 1.0 if it is certainly the correctly rounded one."""
    step = end - start
    s, r = two_sum(start, step * part)
    level = start == end
    # `|` and selections instead of branches: all lanes do the same work.
    certified = rounds_to(s, r, error * abs(step) + 1e-300) | level
    return (start if level else s) + 0.0, 1.0 if certified else 0.0


@scalar
def _positions_double(f):
    """Coordinates of the points in plain doubles, written over those of the first end."""
    for i in range(LANES):
        part, error = f[_FRACTION + i], f[_ERROR + i]
        # The first end is not needed any more: the point takes its place.
        f[_A0 + i], s0 = _along_double(f[_A0 + i], f[_B0 + i], part, error)
        f[_A1 + i], s1 = _along_double(f[_A1 + i], f[_B1 + i], part, error)
        f[_A2 + i], s2 = _along_double(f[_A2 + i], f[_B2 + i], part, error)
        f[_CERTIFIED + i] = f[_CERTIFIED + i] * s0 * s1 * s2


@scalar
def _normals_dd(f):
    """Normals of the planes in double-double, and the sizes of their terms."""
    for i in range(LANES):
        # Differences are exact as pairs.
        g0, g1 = two_sum(f[_P0 + i], -f[_O0 + i])
        g2, g3 = two_sum(f[_P1 + i], -f[_O1 + i])
        g4, g5 = two_sum(f[_P2 + i], -f[_O2 + i])
        h0, h1 = two_sum(f[_Q0 + i], -f[_O0 + i])
        h2, h3 = two_sum(f[_Q1 + i], -f[_O1 + i])
        h4, h5 = two_sum(f[_Q2 + i], -f[_O2 + i])
        f[_N0 + i], f[_N0 + LANES + i] = dd_minor(g2, g3, h4, h5, g4, g5, h2, h3)
        f[_N1 + i], f[_N1 + LANES + i] = dd_minor(g4, g5, h0, h1, g0, g1, h4, h5)
        f[_N2 + i], f[_N2 + LANES + i] = dd_minor(g0, g1, h2, h3, g2, g3, h0, h1)
        f[_S0 + i] = abs(g2 * h4) + abs(g4 * h2)
        f[_S1 + i] = abs(g4 * h0) + abs(g0 * h4)
        f[_S2 + i] = abs(g0 * h2) + abs(g2 * h0)


@scalar
def _step(hi, lo, end, start, nh, nl):
    """Add one term of a height to hi + lo; also the distance of the end from the start."""
    dh, dl = two_sum(end, -start)
    ph, pl = dd_mul(nh, nl, dh, dl)
    hi, lo = dd_add(hi, lo, ph, pl)
    return hi, lo, abs(dh)


@scalar
def _heights_dd(f):
    """Heights of both ends over the planes, and the sizes of all terms."""
    for i in range(LANES):
        n0, r0 = f[_N0 + i], f[_N0 + LANES + i]
        n1, r1 = f[_N1 + i], f[_N1 + LANES + i]
        n2, r2 = f[_N2 + i], f[_N2 + LANES + i]

        # Each height is a sum of three double-double products.
        hi, lo, d0 = _step(0.0, 0.0, f[_A0 + i], f[_O0 + i], n0, r0)
        hi, lo, d1 = _step(hi, lo, f[_A1 + i], f[_O1 + i], n1, r1)
        f[_HA + i], f[_HA + LANES + i], d2 = _step(hi, lo, f[_A2 + i], f[_O2 + i], n2, r2)
        size = f[_S0 + i] * d0 + f[_S1 + i] * d1 + f[_S2 + i] * d2

        # The other end of the edge.
        hi, lo, d0 = _step(0.0, 0.0, f[_B0 + i], f[_O0 + i], n0, r0)
        hi, lo, d1 = _step(hi, lo, f[_B1 + i], f[_O1 + i], n1, r1)
        f[_HB + i], f[_HB + LANES + i], d2 = _step(hi, lo, f[_B2 + i], f[_O2 + i], n2, r2)
        f[_SIZE + i] = size + f[_S0 + i] * d0 + f[_S1 + i] * d1 + f[_S2 + i] * d2


@scalar
def _fractions_dd(f):
    """Fraction of the edge before the plane: a quotient and one Newton step."""
    for i in range(LANES):
        ha, la = f[_HA + i], f[_HA + LANES + i]
        dh, dl = dd_add(ha, la, -f[_HB + i], -f[_HB + LANES + i])
        size = f[_SIZE + i]
        # The conditions of `lpi_dd`.
        known = (size > 1e-200) & (abs(dh) > 1e-24 * size) & (abs(ha) <= 2.0 * abs(dh))
        f[_CERTIFIED + i] = 1.0 if known else 0.0
        below = dh if known else 1.0
        part = ha / below

        # One Newton step on the quotient doubles its digits.
        ph, pl = dd_mul(dh, dl, part, 0.0)
        rh, rl = dd_add(ha, la, -ph, -pl)
        f[_FRACTION + i], f[_FRACTION + LANES + i] = two_sum(part, (rh + rl) / below)
        f[_ERROR + i] = 2.0**-94 * (size / abs(below))


@scalar
def _along_dd(start, end, o, p, q, th, tl, error):
    """One coordinate, and 1.0 if it is certified; exact where the plane is constant on the axis."""
    dh, dl = two_sum(end, -start)
    ph, pl = dd_mul(dh, dl, th, tl)
    s, r = dd_add(start, 0.0, ph, pl)
    slack = error * abs(dh) + 2.0**-98 * (abs(start) + abs(end)) + UNDERFLOW
    s = s + 0.0

    # A triangle that is constant on the axis, or a level edge, gives the coordinate exactly.
    flat = (p == o) & (q == o)
    level = start == end
    certified = rounds_to(s, r, slack) | flat | level
    s = start if level else s
    return (o if flat else s) + 0.0, 1.0 if certified else 0.0


@scalar
def _positions_dd(f):
    """Coordinates of the points, written over those of the first end."""
    for i in range(LANES):
        th, tl, error = f[_FRACTION + i], f[_FRACTION + LANES + i], f[_ERROR + i]
        f[_A0 + i], s0 = _along_dd(
            f[_A0 + i], f[_B0 + i], f[_O0 + i], f[_P0 + i], f[_Q0 + i], th, tl, error
        )
        f[_A1 + i], s1 = _along_dd(
            f[_A1 + i], f[_B1 + i], f[_O1 + i], f[_P1 + i], f[_Q1 + i], th, tl, error
        )
        f[_A2 + i], s2 = _along_dd(
            f[_A2 + i], f[_B2 + i], f[_O2 + i], f[_P2 + i], f[_Q2 + i], th, tl, error
        )
        f[_CERTIFIED + i] = f[_CERTIFIED + i] * s0 * s1 * s2


@scalar
def _store(x, m, row, lane, f):
    """Copy a point out of a block; False if it is not certified."""
    i = m[N_VERTEX] + row
    x[i, 0], x[i, 1], x[i, 2] = f[_A0 + lane], f[_A1 + lane], f[_A2 + lane]
    return f[_CERTIFIED + lane] != 0.0


@scalar
def _place_in_doubles(frame, f, low, high):
    """Place points `low` to `high` - 1 in plain doubles; the rows of those not certified.

    Points in edge planes are placed one by one.
    """
    x, t, d, m = frame.x, frame.t, frame.d, frame.m
    undecided = np.empty(high - low, dtype=np.int64)
    n = 0
    for first in range(low, high, LANES):
        _prefetch_blocks(x, t, d, m, first, high)

        # The last block repeats its last point.
        for lane in range(LANES):
            _load(x, t, d, m, min(first + lane, high - 1), lane, f)
        # Each step is a loop over all lanes; a block of 17 kB stays in the fastest cache.
        _normals_double(f)
        _fractions_double(f)
        _positions_double(f)
        for row in range(first, min(first + LANES, high)):
            # These lanes hold the results of an arbitrary triangle, which are ignored.
            if d[row, 3] >= m[N_TRIANGLE]:
                round_point(frame, m[N_VERTEX] + row)
            elif not _store(x, m, row, row - first, f):
                undecided[n] = row
                n += 1
    return undecided[:n]


@entry("d2* l2 l2 l2 l1* l1* l l -> .")
def place_points(x, t, e, d, m, w, low, high):
    """Correctly rounded coordinates of constructed points `low` to `high` - 1, each of an edge and
    a plane.
    """
    frame = Frame(x, t, e, d, m, w)
    f = np.empty(_ROWS * LANES)
    undecided = _place_in_doubles(frame, f, low, high)
    n = undecided.shape[0]

    # What is left goes through double-double, then through exact integers.
    # Blocks again, filled with undecided points only.
    for first in range(0, n, LANES):
        for lane in range(LANES):
            _load(x, t, d, m, undecided[min(first + lane, n - 1)], lane, f)
        _normals_dd(f)
        _heights_dd(f)
        _fractions_dd(f)
        _positions_dd(f)
        for k in range(first, min(first + LANES, n)):
            if not _store(x, m, undecided[k], k - first, f):
                round_point(frame, m[N_VERTEX] + undecided[k])


# ---- stable pairs ----------------------------------------
# Which pairs of triangles could change their contact if their points moved by a small distance?.
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
    found = np.empty(pairs.shape[0], dtype=np.bool_)
    for i in range(pairs.shape[0]):
        a, b = pairs[i, 0], pairs[i, 1]

        # The move is relative to the largest coordinate of the pair.
        slip = part * max(_largest(x, t, a), _largest(x, t, b))

        # Contacts: a corner must not be almost in the plane of the other triangle.
        if meet[i]:
            found[i] = _is_near_plane(x, t, m, w, a, b, slip) or _is_near_plane(
                x, t, m, w, b, a, slip
            )
        else:
            found[i] = not _stays_apart(x, t, a, b, slip)
    return found
