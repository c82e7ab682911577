"""Constructed points: defined by symbols, placed by correct rounding, one id each.

A point's name is its definition (see `exact_signs`). Several names may denote one point: faces may
be coplanar, and three surfaces may share a line. Points with equal correctly rounded coordinates
are compared exactly and share one id. Rounding depends on the value alone and is monotone,
so unequal rounded coordinates already decide order and inequality exactly (compare Levy 2024).

Letters as in `exact_signs`, and
    names      hash table of names, int64 (size, 5): definition and id; first word 0 if empty
    places     hash table of ids by rounded coordinates, int64 (size,); -1 if empty
Both sizes are powers of two, and the tables are at most half full. The caller sizes `places` for
all points that fit into `x`; `FULL` is returned when `names` is full.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.exact.exact_signs import (
    COLLISIONS,
    N_EDGE_PLANE,
    N_NAME,
    N_POINT,
    N_TRIANGLE,
    N_VERTEX,
    exact_compare,
    exact_position,
    point,
)
from geosurf.kernels.exact.predicates import ORIENT3D_BOUND, TINY, plane_terms

# ---- double double ----------------------------------------
# Constructed points in double-double arithmetic, each with a bound of its error.
#
# Letters as in `exact_signs`. A double-double is an unevaluated sum (high, low) of two doubles
# with at least 104 bits. The operations are the fast ones of Dekker (1971) and Joldes, Muller &
# Popescu (2017, ACM TOMS 44). A sum has an error of at most 2**-104 (|a| + |b|), a product
# 2**-103 |a b|, and a b - c d has 2**-101 (|a b| + |c d|). Under cancellation a sum's error is
# still bounded by the sizes of its operands, so all bounds below are made of sums of absolute
# values.
#
# A point is returned as rounded coordinates, their low parts, and a bound of the error of
# high + low. `constructed_points` accepts the rounded coordinates where the bound proves the
# rounding. Exact integers follow where they cannot.


_SPLIT = 134217729.0  # 2**27 + 1 (Dekker 1971)
_UNKNOWN = (0.0, 0.0, 0.0)
UNDERFLOW = 1e-300  # larger than the loss where products underflow


@scalar
def two_sum(a, b):
    """a + b as (rounded, error), exact (Knuth)."""
    s = a + b
    # c is the part of b that the sum holds, s - c the part of a: what is missing is the error.
    c = s - a
    return s, (a - (s - c)) + (b - c)


@scalar
def two_product(a, b):
    """a * b as (rounded, error), exact without overflow and underflow (Dekker)."""
    p = a * b

    # Split both factors into halves of 26 bits, whose products are exact.
    c = _SPLIT * a
    ah = c - (c - a)
    al = a - ah
    c = _SPLIT * b
    bh = c - (c - b)
    bl = b - bh
    return p, ((ah * bh - p) + ah * bl + al * bh) + al * bl


@scalar
def dd_add(ah, al, bh, bl):
    """a + b."""
    # Exact sum of the high parts, then the low parts as a correction, then normalised.
    s, r = two_sum(ah, bh)
    return two_sum(s, r + (al + bl))


@scalar
def dd_mul(ah, al, bh, bl):
    """a b."""
    p, r = two_product(ah, bh)
    return two_sum(p, r + (ah * bl + al * bh))


@scalar
def dd_minor(ah, al, bh, bl, ch, cl, dh, dl):
    """a b - c d."""
    p, q = dd_mul(ah, al, bh, bl)
    r, s = dd_mul(ch, cl, dh, dl)
    return dd_add(p, q, -r, -s)


@scalar
def _span(x, p, q):
    """x[q] - x[p]: three pairs."""
    a = two_sum(x[q, 0], -x[p, 0])
    b = two_sum(x[q, 1], -x[p, 1])
    c = two_sum(x[q, 2], -x[p, 2])
    return a[0], a[1], b[0], b[1], c[0], c[1]


@scalar
def plane_dd(x, t, e, m, p):
    """A vertex of plane p, and its normal: three pairs, and the sizes of their terms."""
    if p < m[N_TRIANGLE]:
        a = t[p, 0]
        # Differences of doubles are exact as pairs, so all error is in the products below.
        g = _span(x, a, t[p, 1])
        h = _span(x, a, t[p, 2])
    else:
        row = p - m[N_TRIANGLE]
        a = e[row, 0]
        g = _span(x, a, e[row, 1])

        # The second span of an edge plane is the unit vector of its axis.
        axis = e[row, 2]
        one, two, three = 1.0 * (axis == 0), 1.0 * (axis == 1), 1.0 * (axis == 2)
        h = (one, 0.0, two, 0.0, three, 0.0)

    # The normal and, component by component, the sizes of its terms.
    n0 = dd_minor(g[2], g[3], h[4], h[5], g[4], g[5], h[2], h[3])
    n1 = dd_minor(g[4], g[5], h[0], h[1], g[0], g[1], h[4], h[5])
    n2 = dd_minor(g[0], g[1], h[2], h[3], g[2], g[3], h[0], h[1])
    # Sizes are sums of absolute values: error bounds made of them hold under cancellation.
    s0 = abs(g[2] * h[4]) + abs(g[4] * h[2])
    s1 = abs(g[4] * h[0]) + abs(g[0] * h[4])
    s2 = abs(g[0] * h[2]) + abs(g[2] * h[0])
    return a, (n0[0], n0[1], n1[0], n1[1], n2[0], n2[1], s0, s1, s2)


@scalar
def _plane_height(x, n, a, p):
    """n . (p - x[a]) as a pair, and the sum of the sizes of its terms; p: three doubles."""
    hi = 0.0
    lo = 0.0
    size = 0.0
    for i in range(3):
        # Exact difference, double-double product, accumulated sum.
        dh, dl = two_sum(p[i], -x[a, i])
        ph, pl = dd_mul(n[2 * i], n[2 * i + 1], dh, dl)
        hi, lo = dd_add(hi, lo, ph, pl)
        size += n[6 + i] * abs(dh)
    return hi, lo, size


@scalar
def plane_is_level(x, t, e, m, p, axis):
    """Whether all points of plane p have one coordinate on an axis."""
    if p < m[N_TRIANGLE]:
        level = x[t[p, 0], axis]
        return x[t[p, 1], axis] == level and x[t[p, 2], axis] == level
    row = p - m[N_TRIANGLE]
    return e[row, 2] != axis and x[e[row, 0], axis] == x[e[row, 1], axis]


@scalar
def lpi_dd(x, t, e, m, a, b, c):
    """Line a-b through plane c: (known, coordinates, low parts, bounds)."""
    o, n = plane_dd(x, t, e, m, c)
    ha, la, size_a = _plane_height(x, n, o, (x[a, 0], x[a, 1], x[a, 2]))
    hb, lb, size_b = _plane_height(x, n, o, (x[b, 0], x[b, 1], x[b, 2]))

    # The denominator; reject it where it is mostly cancellation.
    dh, dl = dd_add(ha, la, -hb, -lb)
    size = size_a + size_b
    if not (size > 1e-200 and abs(dh) > 1e-24 * size and abs(ha) <= 2.0 * abs(dh)):
        return False, _UNKNOWN, _UNKNOWN, _UNKNOWN
    # t = ha / (ha - hb), by one Newton step on the double quotient
    t0 = ha / dh
    ph, pl = dd_mul(dh, dl, t0, 0.0)
    rh, rl = dd_add(ha, la, -ph, -pl)
    th, tl = two_sum(t0, (rh + rl) / dh)
    # about thirty operations stand behind ha and hb, each off by less than 2**-100 of `size`
    relative = 2.0**-94 * (size / abs(dh))

    # Interpolate each coordinate along the edge.
    p0, r0, e0 = _along(x, t, e, m, a, b, c, 0, th, tl, relative)
    p1, r1, e1 = _along(x, t, e, m, a, b, c, 1, th, tl, relative)
    p2, r2, e2 = _along(x, t, e, m, a, b, c, 2, th, tl, relative)
    return True, (p0, p1, p2), (r0, r1, r2), (e0, e1, e2)


@scalar
def _along(x, t, e, m, a, b, c, axis, th, tl, relative):
    """One coordinate of the point at th + tl between a and b: rounded, low part, bound.

    A plane that is constant on this axis (a contact, a wall of the box) gives the coordinate
    exactly. The result is never -0.0, which would depend on the order of the surfaces.
    """
    if plane_is_level(x, t, e, m, c, axis):
        o = t[c, 0] if c < m[N_TRIANGLE] else e[c - m[N_TRIANGLE], 0]
        return x[o, axis] + 0.0, 0.0, 0.0
    start, end = x[a, axis], x[b, axis]
    if start == end:
        # The edge runs across the axis: its coordinate is exact whatever the fraction is.
        return start + 0.0, 0.0, 0.0
    dh, dl = two_sum(end, -start)
    ph, pl = dd_mul(dh, dl, th, tl)
    # Error of the fraction over the whole span, then that of the product and the sum.
    s, r = dd_add(start, 0.0, ph, pl)
    return s + 0.0, r, relative * abs(dh) + 2.0**-98 * (abs(start) + abs(end)) + UNDERFLOW


@scalar
def _cofactor(j, k):
    """Cross product of the normals of two planes in doubles: components and sizes of terms."""
    # Entries 0, 2, 4 are the high parts of a normal; 6, 7, 8 are the sizes of its terms.
    c0, c1, c2 = j[2] * k[4] - j[4] * k[2], j[4] * k[0] - j[0] * k[4], j[0] * k[2] - j[2] * k[0]
    s0 = j[7] * k[8] + j[8] * k[7]
    s1 = j[8] * k[6] + j[6] * k[8]
    s2 = j[6] * k[7] + j[7] * k[6]
    return c0, c1, c2, s0, s1, s2


@scalar
def _fits(n):
    """Whether products of a normal neither overflow nor underflow by an amount that matters."""
    largest = max(n[6], max(n[7], n[8]))
    return 1e-15 < largest < 1e40


@scalar
def _floored(n):
    """A normal whose term sizes are at least 2**-40 of the largest: covers underflow."""
    floor = 2.0**-40 * max(n[6], max(n[7], n[8]))
    return n[0], n[1], n[2], n[3], n[4], n[5], n[6] + floor, n[7] + floor, n[8] + floor


@scalar
def tpi_dd(x, t, e, m, first, second, third):
    """The point of three planes: (known, coordinates, low parts, bounds).

    Newton from a vertex of the first plane: p moves by the d with n_i . d = -n_i . (p - a_i).
    Heights over the planes are computed in double-double and nearly vanish at the end. Doubles
    suffice for everything else (iterative refinement, Wilkinson 1963).

    With S_i the sizes of the terms of n_i and C_i = n_j x n_k with terms of size SC_i, in
    doubles: C_i errs by less than 2**-50 SC_i, W = n_1 . C_1 by less than 2**-48 SW, a height h_i
    by less than 2**-95 S_i . |p - a_i| + 2**-52 |h_i|. So d = -sum(h_i C_i) / W errs by less than
    ``sum((2**-95 S_i . |p - a_i| + 2**-48 |h_i|) SC_i) + 2**-48 SW |d|``, over |W|, and twice that
    if W is known to half its size.
    """
    # Normals of the three planes in double-double.
    a1, n1 = plane_dd(x, t, e, m, first)
    a2, n2 = plane_dd(x, t, e, m, second)
    a3, n3 = plane_dd(x, t, e, m, third)
    if not (_fits(n1) and _fits(n2) and _fits(n3)):
        return False, _UNKNOWN, _UNKNOWN, _UNKNOWN
    n1, n2, n3 = _floored(n1), _floored(n2), _floored(n3)

    # Cofactors and determinant W in doubles; reject a badly conditioned W.
    c1, c2, c3 = _cofactor(n2, n3), _cofactor(n3, n1), _cofactor(n1, n2)
    below = n1[0] * c1[0] + n1[2] * c1[1] + n1[4] * c1[2]
    size = n1[6] * c1[3] + n1[7] * c1[4] + n1[8] * c1[5]
    if not (abs(below) > 1e-100 and abs(below) > 2.0**-46 * size):
        return False, _UNKNOWN, _UNKNOWN, _UNKNOWN
    slack_w = 2.0**-48 * size

    # Start at a vertex of the first plane. Any start converges, as the equations are linear.
    p0, p1, p2 = x[a1, 0], x[a1, 1], x[a1, 2]
    r0, r1, r2 = 0.0, 0.0, 0.0
    e0, e1, e2 = 0.0, 0.0, 0.0

    # Newton steps: each gains about 48 bits until the bound is below 2**-90.
    for _ in range(4):
        # Heights of the current point over the three planes.
        g1, _, s1 = _plane_height(x, n1, a1, (p0, p1, p2))
        g2, _, s2 = _plane_height(x, n2, a2, (p0, p1, p2))
        g3, _, s3 = _plane_height(x, n3, a3, (p0, p1, p2))

        # Bounds of the heights, the step by Cramer, and the bound of the result.
        f1 = 2.0**-95 * s1 + 2.0**-48 * abs(g1) + 1e-250
        f2 = 2.0**-95 * s2 + 2.0**-48 * abs(g2) + 1e-250
        f3 = 2.0**-95 * s3 + 2.0**-48 * abs(g3) + 1e-250
        d0 = -(g1 * c1[0] + g2 * c2[0] + g3 * c3[0]) / below
        d1 = -(g1 * c1[1] + g2 * c2[1] + g3 * c3[1]) / below
        d2 = -(g1 * c1[2] + g2 * c2[2] + g3 * c3[2]) / below
        e0 = (
            2.0 * (f1 * c1[3] + f2 * c2[3] + f3 * c3[3] + slack_w * abs(d0)) / abs(below)
            + UNDERFLOW
        )
        e1 = (
            2.0 * (f1 * c1[4] + f2 * c2[4] + f3 * c3[4] + slack_w * abs(d1)) / abs(below)
            + UNDERFLOW
        )
        e2 = (
            2.0 * (f1 * c1[5] + f2 * c2[5] + f3 * c3[5] + slack_w * abs(d2)) / abs(below)
            + UNDERFLOW
        )

        # Low parts of earlier steps are dropped: the next step computes heights at p alone and
        # finds them again.
        p0, r0 = two_sum(p0, d0)
        p1, r1 = two_sum(p1, d1)
        p2, r2 = two_sum(p2, d2)
        if max(e0, max(e1, e2)) < 2.0**-90 * max(abs(p0), max(abs(p1), abs(p2))):
            break
    # a plane that is constant on an axis gives that coordinate exactly
    for p in (first, second, third):
        o = t[p, 0] if p < m[N_TRIANGLE] else e[p - m[N_TRIANGLE], 0]
        if plane_is_level(x, t, e, m, p, 0):
            p0, r0, e0 = x[o, 0], 0.0, 0.0
        if plane_is_level(x, t, e, m, p, 1):
            p1, r1, e1 = x[o, 1], 0.0, 0.0
        if plane_is_level(x, t, e, m, p, 2):
            p2, r2, e2 = x[o, 2], 0.0, 0.0
    return True, (p0 + 0.0, p1 + 0.0, p2 + 0.0), (r0, r1, r2), (e0, e1, e2)


@scalar
def point_dd(x, t, e, m, kind, a, b, c):
    """The point with this definition: (known, coordinates, low parts, bounds)."""
    if kind == 1:
        return lpi_dd(x, t, e, m, a, b, c)
    return tpi_dd(x, t, e, m, a, b, c)


@scalar
def rounds_to(p, r, slack):
    """Whether p is the double nearest to every number within p + r +- slack."""
    return (p + (r - slack)) == p and (p + (r + slack)) == p


LPI, TPI, EDGE_PLANE = 1, 2, 3
_MASK = (1 << 38) - 1
FULL = -9  # a table is full: the caller repeats with larger ones


@scalar
def _mixed(h, key):
    """Mix a key of up to 62 bits into a hash of 38 bits; no product exceeds 2**62.

    Grid coordinates differ in their upper bits only, names in their lower bits. Both have to reach
    all bits, or a table of a million grid nodes becomes one long chain.
    """
    h = (h ^ key ^ (key >> 38)) & _MASK
    h *= 0xB5297B
    h = (h ^ (h >> 27)) & _MASK
    h *= 0x9E3779
    return (h ^ (h >> 25)) & _MASK


@scalar
def hash_of_row(x, i):
    """Hash of the coordinates of point i, from their bits; equal for 0.0 and -0.0."""
    bits = x[i].view(np.int64)
    h = 0
    for axis in range(3):
        # 0.0 and -0.0 are equal numbers with different bits: zeros do not change the hash. The
        # lowest 16 bits enter through h, the other 48 as the key.
        if x[i, axis] != 0.0:
            h = _mixed(h + (bits[axis] & 0xFFFF), (bits[axis] >> 16) & 0xFFFFFFFFFFFF)
    return h


@scalar
def hash_of_name(kind, a, b, c):
    """Hash of a definition."""
    return _mixed(_mixed(_mixed(kind, a), b), c)


@scalar
def same_point(frame, a, b):
    """Whether points a and b, whose rounded coordinates are equal, are one point."""
    m = frame.m

    # Vertices are defined by their coordinates: equal coordinates mean equal points.
    if a < m[N_VERTEX] and b < m[N_VERTEX]:
        return True
    for axis in range(3):
        if exact_compare(frame, a, b, axis) != 0:
            return False
    return True


@scalar
def slot_at_coordinates(x, places, i, slot):
    """First slot, from one on, that is empty or holds a point with the coordinates of point i.

    Short and with few arrays, so that it is inlined: a call with seven arrays would take longer.
    """
    while places[slot] >= 0:
        j = places[slot]
        if x[j, 0] == x[i, 0] and x[j, 1] == x[i, 1] and x[j, 2] == x[i, 2]:
            break
        slot = (slot + 1) & (places.shape[0] - 1)
    return slot


@scalar
def id_after_collision(frame, places, i, slot):
    """Id of point i where another point has equal rounded coordinates."""
    x, m = frame.x, frame.m

    # Compare exactly with each point of equal coordinates.
    collided = 0
    while places[slot] >= 0:
        j = places[slot]
        if j == i or same_point(frame, i, j):
            return j
        collided = 1
        slot = slot_at_coordinates(x, places, i, (slot + 1) & (places.shape[0] - 1))

    # A new point at coordinates that another point has: both round to the same doubles.
    places[slot] = i
    m[COLLISIONS] += collided
    return i


@scalar
def id_of_coordinates(frame, places, i):
    """Id of the point that equals point i; point i itself is entered if it is new."""
    x = frame.x
    slot = slot_at_coordinates(x, places, i, hash_of_row(x, i) & (places.shape[0] - 1))
    if places[slot] >= 0:
        return id_after_collision(frame, places, i, slot)
    places[slot] = i
    return i


@scalar
def slot_of(names, kind, a, b, c):
    """Slot of a definition in the table of names, or the empty one where it belongs."""
    size = names.shape[0]
    slot = hash_of_name(kind, a, b, c) & (size - 1)

    # Linear probing ends at an empty slot: the table is at most half full.
    while names[slot, 0] != 0:
        if (
            names[slot, 0] == kind
            and names[slot, 1] == a
            and names[slot, 2] == b
            and names[slot, 3] == c
        ):
            break
        slot = (slot + 1) & (size - 1)
    return slot


@scalar
def insert_name(m, names, slot, kind, a, b, c, i):
    """Enter a definition and its id into an empty slot."""
    names[slot, 0], names[slot, 1], names[slot, 2], names[slot, 3] = kind, a, b, c
    names[slot, 4] = i
    m[N_NAME] += 1


@scalar
def edge_plane(e, m, names, a, b, axis):
    """Id of the plane through edge a-b along an axis; FULL if there is no room."""
    # Both directions of an edge name the same plane.
    if a > b:
        a, b = b, a
    slot = slot_of(names, EDGE_PLANE, a, b, axis)
    if names[slot, 0] != 0:
        return names[slot, 4]
    row = m[N_EDGE_PLANE]
    if row >= e.shape[0] or 2 * m[N_NAME] >= names.shape[0]:
        return FULL
    e[row, 0], e[row, 1], e[row, 2] = a, b, axis
    m[N_EDGE_PLANE] += 1
    insert_name(m, names, slot, EDGE_PLANE, a, b, axis, m[N_TRIANGLE] + row)
    return m[N_TRIANGLE] + row


@scalar
def _height(x, n, o, p):
    """Height of vertex p over the plane at o with terms n, and a bound of its error."""
    c0, c1, c2 = x[p, 0] - x[o, 0], x[p, 1] - x[o, 1], x[p, 2] - x[o, 2]
    size = abs(c0) * n[3] + abs(c1) * n[4] + abs(c2) * n[5]
    bound = ORIENT3D_BOUND * size if size > TINY else np.inf
    return c0 * n[0] + c1 * n[1] + c2 * n[2], bound


@scalar
def lpi_in_doubles(x, t, a, b, c):
    """Intersection of edge a-b and triangle c in plain doubles: (certified, x, y, z).

    `certified` means that each coordinate is the correctly rounded one. Let h be the computed
    heights of the ends over the plane, each with an error of at most f, and H the true ones. Then
    ``ha / (ha
    - hb)`` has an error of at most ``max(fa, fb) / |Ha - Hb|``. The last sum's rounding error is
    known, so coordinates can be certified where edges are short compared to coordinates: in grids
    nine of ten.
    """
    # Heights of both ends over the plane, with error bounds.
    o = t[c, 0]
    n = plane_terms(x, o, t[c, 1], t[c, 2])
    ha, fa = _height(x, n, o, a)
    hb, fb = _height(x, n, o, b)
    below = ha - hb
    # Certify only where the ends are on different sides, or one on the plane, and where their
    # heights differ by much more than their errors. Otherwise the fraction has too few certain
    # digits.
    if not (ha * hb <= 0.0 and 4.0 * (fa + fb) < abs(below) < np.inf):
        return False, 0.0, 0.0, 0.0

    # Interpolate; every coordinate has to be certified.
    part = ha / below
    # 4/3 for H beside h; five roundings of 2**-53 follow
    relative = 1.34 * max(fa, fb) / abs(below) + 2.0**-50
    s0, p0 = _interpolate(x[a, 0], x[b, 0], part, relative)
    s1, p1 = _interpolate(x[a, 1], x[b, 1], part, relative)
    s2, p2 = _interpolate(x[a, 2], x[b, 2], part, relative)
    return s0 and s1 and s2, p0, p1, p2


@scalar
def _interpolate(start, end, part, relative):
    """Point at a fraction of the way from start to end: (certified, coordinate)."""
    if start == end:
        return True, start + 0.0

    # The rounding error of this last sum is known exactly and takes nothing from the bound.
    p, low = two_sum(start, (end - start) * part)
    return rounds_to(p, low, relative * abs(end - start) + 1e-300), p + 0.0


@scalar
def round_point(frame, i):
    """Write the correctly rounded coordinates of constructed point i: by doubles, double-doubles or
    integers.

    None is -0.0, see `double_double`.
    """
    x, t, e, d, m = frame.x, frame.t, frame.e, frame.d, frame.m
    row = i - m[N_VERTEX]

    # Doubles serve lines through triangles; edge planes and points of three planes start with
    # double-doubles.
    if d[row, 0] == LPI and d[row, 3] < m[N_TRIANGLE]:
        certified, x[i, 0], x[i, 1], x[i, 2] = lpi_in_doubles(x, t, d[row, 1], d[row, 2], d[row, 3])
        if certified:
            return

    # Integers follow only where the bound of double-doubles allows two roundings.
    known, p, low, slack = point_dd(x, t, e, m, d[row, 0], d[row, 1], d[row, 2], d[row, 3])
    x[i, 0], x[i, 1], x[i, 2] = p[0], p[1], p[2]
    if not (
        known
        and rounds_to(p[0], low[0], slack[0])
        and rounds_to(p[1], low[1], slack[1])
        and rounds_to(p[2], low[2], slack[2])
    ):
        point(frame, 0, i)
        for axis in range(3):
            # + 0.0 turns -0.0 into 0.0, as the other routes do
            x[i, axis] = exact_position(frame, i, axis) + 0.0


@scalar
def named_point(frame, names, places, kind, a, b, c):
    """Id of the point with this definition, made if it is new; FULL if there is no room."""
    d, m = frame.d, frame.m

    # Sort the symbols, so that each definition has one name.
    if a > b:
        a, b = b, a
    if kind == TPI:
        if b > c:
            b, c = c, b
        if a > b:
            a, b = b, a

    # A known name returns its id.
    slot = slot_of(names, kind, a, b, c)
    if names[slot, 0] != 0:
        return names[slot, 4]
    row = m[N_POINT]

    # Constructed points are stored after the vertices.
    i = m[N_VERTEX] + row
    if i >= frame.x.shape[0] or 2 * m[N_NAME] >= names.shape[0]:
        return FULL

    # Write the definition, then place the point.
    d[row, 0], d[row, 1], d[row, 2], d[row, 3] = kind, a, b, c
    round_point(frame, i)

    # The point may be known by another name; then its row is used again.
    number = id_of_coordinates(frame, places, i)
    if number == i:
        m[N_POINT] += 1
    insert_name(m, names, slot, kind, a, b, c, number)
    return number
