"""Constructed points in double-double arithmetic, each with a bound of its error.

Letters as in `exact_signs`. A double-double is an unevaluated sum (high, low) of two doubles with
at least 104 bits. The operations are the fast ones of Dekker (1971) and Joldes, Muller & Popescu
(2017, ACM TOMS 44). A sum has an error of at most 2**-104 (|a| + |b|), a product 2**-103 |a b|, and
a b - c d has 2**-101 (|a b| + |c d|). Under cancellation a sum's error is still bounded by the
sizes of its operands, so all bounds below are made of sums of absolute values.

A point is returned as rounded coordinates, their low parts, and a bound of the error of
high + low. `constructed_points` accepts the rounded coordinates where the bound proves the
rounding; `face_signs` computes signs from both parts where plain doubles cannot decide. Exact
integers follow where double-doubles cannot decide either.
"""

from __future__ import annotations

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.exact.exact_signs import N_TRIANGLE

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
def _height(x, n, a, p):
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
    ha, la, size_a = _height(x, n, o, (x[a, 0], x[a, 1], x[a, 2]))
    hb, lb, size_b = _height(x, n, o, (x[b, 0], x[b, 1], x[b, 2]))

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
def tpi_dd(x, t, e, m, one, two, three):
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
    a1, n1 = plane_dd(x, t, e, m, one)
    a2, n2 = plane_dd(x, t, e, m, two)
    a3, n3 = plane_dd(x, t, e, m, three)
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
        g1, _, s1 = _height(x, n1, a1, (p0, p1, p2))
        g2, _, s2 = _height(x, n2, a2, (p0, p1, p2))
        g3, _, s3 = _height(x, n3, a3, (p0, p1, p2))

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
    for p in (one, two, three):
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
