"""Exact signs and correctly rounded points in multi-limb integers: the last stage of every filter.

Notation
    x          coordinates, float64 (n_point, 3): vertices first, then constructed points
    t          corners of the triangles, int64 (n_triangle, 3)
    e          edge planes, int64 (n, 3): vertices a, b and an axis
    d          definitions of constructed points, int64 (n, 4), see below
    m          integers that describe the frame, int64 (16,): indices below
    w          limb workspace, int64 (WORK * limbs,)

A point is a vertex, an **LPI** (line a-b through plane p: ``[1, a, b, p]``) or a **TPI** (three
planes: ``[2, p, q, r]``), after Attene (2020, arXiv 2105.09772). Plane p is that of triangle p, or
for ``p >= n_triangle`` the plane through an edge parallel to an axis. The homogeneous coordinates
(X, Y, Z, W) with W > 0 are integers, because all coordinates are multiples of 2**-k.
Their degrees in the input: X has 1, 4, 7 and W has 0, 3, 6 for vertex, LPI, TPI.

Lengths of numbers in `w` are counted in units of ``m[LIMBS]`` limbs: one unit holds a coordinate.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.exact.bigint import (
    BITS,
    accumulate,
    clear,
    leading,
    load,
    mul,
    mul_add,
    negate,
    shift_left,
    sign,
    sub,
)


class Frame(NamedTuple):
    """The six arrays of one frame, handed from helper to helper as one bundle."""

    x: np.ndarray  # coordinates
    t: np.ndarray  # triangles
    e: np.ndarray  # edge planes
    d: np.ndarray  # definitions of constructed points
    m: np.ndarray  # integers of the frame
    w: np.ndarray  # limb workspace


# rows of m
N_VERTEX, N_TRIANGLE, LIMBS, SCALE, N_POINT, N_EDGE_PLANE = 0, 1, 2, 3, 4, 5
EXACT_ORIENT2D, EXACT_INCIRCLE, EXACT_ORIENT3D, EXACT_ROUND = 6, 7, 8, 9
EQUALITY_TESTS, COLLISIONS, N_NAME, NEAR, UNINDEXED, N_SLOT = 10, 11, 12, 13, 14, 15
N_META = 16

# regions of w, in units of LIMBS
_POINT = 28  # X, Y, Z of 7 and W of 6 (+ 1) units
# Four points, then three planes (normal 3 x 2 units, offset 3), then scratch space.
_PLANES = 4 * _POINT
_MISC = _PLANES + 27
WORK = 900
_LEAST = 5e-324


@scalar
def _vector(x, m, w, r, p, q):
    """Three coordinates of q - p at r, one unit each."""
    n = m[LIMBS]
    # Coordinates are multiples of 2**-k: times 2**k they are integers.
    k = m[SCALE]
    s = (_MISC + 60) * n
    for i in range(3):
        load(w, s, n, x[q, i], k)
        load(w, s + n, n, x[p, i], k)
        sub(w, r + i * n, s, s + n, n)


@scalar
def _cross(w, r, n, a, la, b, lb):
    """r = a x b for vectors of la and lb limbs a coordinate; result of la + lb, spaced n."""
    for i in range(3):
        j = (i + 1) % 3
        k = (i + 2) % 3
        clear(w, r + i * n, n)
        mul_add(w, r + i * n, n, a + j * la, la, b + k * lb, lb, 1)
        mul_add(w, r + i * n, n, a + k * la, la, b + j * lb, lb, -1)


@scalar
def _dot(w, r, n, a, la, b, lb):
    """r = a . b in n >= la + lb limbs."""
    clear(w, r, n)
    for i in range(3):
        mul_add(w, r, n, a + i * la, la, b + i * lb, lb, 1)


@scalar
def plane(x, t, e, m, w, r, p):
    """Normal (3 x 2 units) and offset n . p0 (3 units, at r + 6 units) of plane p."""
    n = m[LIMBS]
    u = _MISC * n

    # Two edges span the plane: of a triangle, or one edge and a unit axis vector.
    if p < m[N_TRIANGLE]:
        a = t[p, 0]
        _vector(x, m, w, u, a, t[p, 1])
        _vector(x, m, w, u + 3 * n, a, t[p, 2])
    else:
        row = p - m[N_TRIANGLE]
        a = e[row, 0]
        _vector(x, m, w, u, a, e[row, 1])
        clear(w, u + 3 * n, 3 * n)
        # The direction matters, not the length: an integer 1 keeps the numbers short.
        w[u + (3 + e[row, 2]) * n] = 1

    # The offset is the scalar product of the normal and a vertex.
    _cross(w, r, 2 * n, u, n, u + 3 * n, n)
    for i in range(3):
        load(w, u + i * n, n, x[a, i], m[SCALE])
    _dot(w, r + 6 * n, 3 * n, r, 2 * n, u, n)


@scalar
def _lpi(x, t, e, m, w, r, a, b, p):
    """Line a-b through plane p: X (4 units) = a W + (b - a) num; W (3 units) = n . (b - a)."""
    n = m[LIMBS]
    q = _PLANES * n
    plane(x, t, e, m, w, q, p)

    # u: the start of the line; v: its direction.
    u = (_MISC + 10) * n
    for i in range(3):
        load(w, u + i * n, n, x[a, i], m[SCALE])
    v = u + 3 * n
    _vector(x, m, w, v, a, b)

    # W is the height gained along the line, num the height of the plane over its start.
    below = r + 21 * n
    _dot(w, below, 3 * n, q, 2 * n, v, n)
    num = v + 3 * n
    _dot(w, num + 3 * n, 3 * n, q, 2 * n, u, n)
    sub(w, num, q + 6 * n, num + 3 * n, 3 * n)
    for i in range(3):
        top = r + i * 7 * n
        clear(w, top, 4 * n)
        mul_add(w, top, 4 * n, u + i * n, n, below, 3 * n, 1)
        mul_add(w, top, 4 * n, v + i * n, n, num, 3 * n, 1)


@scalar
def _tpi(x, t, e, m, w, r, d, row):
    """Three planes: X (7 units) = sum of d_i (n_j x n_k); W (6 units) = n_1 . (n_2 x n_3)."""
    n = m[LIMBS]
    q = _PLANES * n

    # The normals and offsets of the three planes.
    for i in range(3):
        plane(x, t, e, m, w, q + i * 9 * n, d[row, 1 + i])
    for i in range(3):
        clear(w, r + i * 7 * n, 7 * n)

    # Cramer: X is the sum of each offset times the cross product of the other normals.
    c = _MISC * n
    for i in range(3):
        j = (i + 1) % 3
        k = (i + 2) % 3
        _cross(w, c, 4 * n, q + j * 9 * n, 2 * n, q + k * 9 * n, 2 * n)
        for axis in range(3):
            mul_add(
                w, r + axis * 7 * n, 7 * n, q + i * 9 * n + 6 * n, 3 * n, c + axis * 4 * n, 4 * n, 1
            )
        if i == 0:
            _dot(w, r + 21 * n, 6 * n, q, 2 * n, c, 4 * n)


@scalar
def point(frame, r, i):
    """Homogeneous coordinates of point i at r: X, Y, Z at 0, 7, 14 units, W > 0 at 21.

    Returns the lengths of X and W in limbs.
    """
    x, t, e, d, m, w = frame.x, frame.t, frame.e, frame.d, frame.m, frame.w
    n = m[LIMBS]
    if i < m[N_VERTEX]:
        for axis in range(3):
            load(w, r + axis * 7 * n, n, x[i, axis], m[SCALE])
        w[r + 21 * n] = 1
        return n, 1

    # Constructed: build it from its definition, then make W positive.
    row = i - m[N_VERTEX]
    if d[row, 0] == 1:
        _lpi(x, t, e, m, w, r, d[row, 1], d[row, 2], d[row, 3])
        lx, lw = 4 * n, 3 * n
    else:
        _tpi(x, t, e, m, w, r, d, row)
        lx, lw = 7 * n, 6 * n
    # All four signs may be turned together; callers rely on W > 0.
    if sign(w, r + 21 * n, lw) < 0:
        negate(w, r + 21 * n, lw)
        for axis in range(3):
            negate(w, r + axis * 7 * n, lx)
    return lx, lw


@scalar
def exact_orient2d(frame, a, b, c, u, v):
    """Sign of the turn a, b, c seen on axes (u, v)."""
    m, w = frame.m, frame.w
    m[EXACT_ORIENT2D] += 1
    n = m[LIMBS]
    step = _POINT * n
    la, wa = point(frame, 0, a)
    lb, wb = point(frame, step, b)
    lc, wc = point(frame, 2 * step, c)

    # The determinant of the three rows (U, V, W), expanded by the column W.
    u7, v7, w7 = u * 7 * n, v * 7 * n, 21 * n
    total = la + lb + lc + 1
    acc = (_MISC + 100) * n
    minor = acc + total
    clear(w, acc, total)
    for i in range(3):
        if i == 0:
            p, lp, q, lq, o, lo = step, lb, 2 * step, lc, 0, wa
        elif i == 1:
            p, lp, q, lq, o, lo = 2 * step, lc, 0, la, step, wb
        else:
            p, lp, q, lq, o, lo = 0, la, step, lb, 2 * step, wc
        clear(w, minor, lp + lq)
        mul_add(w, minor, lp + lq, p + u7, lp, q + v7, lq, 1)
        mul_add(w, minor, lp + lq, p + v7, lp, q + u7, lq, -1)
        mul_add(w, acc, total, minor, lp + lq, o + w7, lo, 1)
    return sign(w, acc, total)


@scalar
def exact_orient2d_vertices(x, m, w, a, b, c, u, v):
    """Sign of the turn of the vertices a, b, c seen on axes (u, v)."""
    m[EXACT_ORIENT2D] += 1
    n = m[LIMBS]

    # The cross product of b - a and c - a, one component.
    p = _MISC * n
    q = p + 3 * n
    acc = q + 3 * n
    _vector(x, m, w, p, a, b)
    _vector(x, m, w, q, a, c)
    clear(w, acc, 2 * n)
    mul_add(w, acc, 2 * n, p + u * n, n, q + v * n, n, 1)
    mul_add(w, acc, 2 * n, p + v * n, n, q + u * n, n, -1)
    return sign(w, acc, 2 * n)


@scalar
def exact_compare(frame, a, b, axis):
    """Sign of coordinate `axis` of point a minus that of point b."""
    m, w = frame.m, frame.w
    m[EQUALITY_TESTS] += 1
    n = m[LIMBS]
    step = _POINT * n
    la, wa = point(frame, 0, a)
    lb, wb = point(frame, step, b)

    # Coordinates differ as X_a W_b - X_b W_a, since both W are positive.
    total = max(la + wb, lb + wa) + 1
    acc = (_MISC + 100) * n
    clear(w, acc, total)
    mul_add(w, acc, total, axis * 7 * n, la, step + 21 * n, wb, 1)
    mul_add(w, acc, total, step + axis * 7 * n, lb, 21 * n, wa, -1)
    return sign(w, acc, total)


@scalar
def exact_orient3d(x, m, w, a, b, c, o):
    """Sign of (b - a) x (c - a) . (o - a), for vertices."""
    m[EXACT_ORIENT3D] += 1
    n = m[LIMBS]
    u = _MISC * n
    _vector(x, m, w, u, a, b)
    _vector(x, m, w, u + 3 * n, a, c)

    # Normal of the first three vertices, then its product with the last edge.
    _cross(w, u + 9 * n, 2 * n, u, n, u + 3 * n, n)
    _vector(x, m, w, u + 6 * n, a, o)
    _dot(w, u + 15 * n, 3 * n, u + 9 * n, 2 * n, u + 6 * n, n)
    return sign(w, u + 15 * n, 3 * n)


@scalar
def exact_normal_axis(x, m, w, a, b, c):
    """Axis of the largest component of the normal of vertices a, b, c, and its sign.

    The first one wins a tie, so that coplanar triangles agree. (-1, 0) for zero area.
    """
    n = m[LIMBS]
    u = _MISC * n
    _vector(x, m, w, u, a, b)
    _vector(x, m, w, u + 3 * n, a, c)
    normal = u + 9 * n
    _cross(w, normal, 2 * n, u, n, u + 3 * n, n)

    # Compare magnitudes component by component; a strict > lets the first axis win ties.
    best = -1
    best_sign = 0
    for axis in range(3):
        s = sign(w, normal + axis * 2 * n, 2 * n)
        if s < 0:
            negate(w, normal + axis * 2 * n, 2 * n)
        if s == 0:
            continue
        larger = best < 0
        if not larger:
            sub(w, u, normal + axis * 2 * n, normal + best * 2 * n, 2 * n)
            larger = sign(w, u, 2 * n) > 0
        if larger:
            best = axis
            best_sign = s
    return best, best_sign


@scalar
def _compare_to_half(w, m, scratch, top, lx, below, lw, mantissa, exponent):
    """Sign of X / W * 2**-k minus mantissa * 2**exponent, all positive."""
    # Compare X with mantissa * W * 2**shift; the mantissa takes three limbs.
    shift = exponent + m[SCALE]
    w[scratch] = mantissa & ((1 << BITS) - 1)
    w[scratch + 1] = (mantissa >> BITS) & ((1 << BITS) - 1)
    w[scratch + 2] = mantissa >> (2 * BITS)
    product = scratch + 3
    mul(w, product, below, lw, scratch, 3)
    lp = lw + 3

    # Shift the side with the smaller exponent, so that both stay integers.
    left, ll = top, lx
    right, lr = product, lp
    free = product + lp
    if shift < 0:
        ll = shift_left(w, free, top, lx, -shift)
        left = free
    else:
        lr = shift_left(w, free, product, lp, shift)
        right = free

    # Subtract with one limb to spare for the sign.
    total = max(ll, lr) + 1
    acc = free + max(ll, lr)
    clear(w, acc, total)
    accumulate(w, acc, total, left, ll, 1)
    accumulate(w, acc, total, right, lr, -1)
    return sign(w, acc, total)


@scalar
def exact_round(m, w, top, lx, below, lw):
    """The double nearest to X / W * 2**-k, ties to even; 0.0 only if X is zero.

    X is destroyed where it is negative.
    """
    m[EXACT_ROUND] += 1
    s = sign(w, top, lx)
    if s == 0:
        return 0.0
    # Rounding to even is symmetric: round the absolute value.
    if s < 0:
        negate(w, top, lx)

    # A guess from the leading limbs is off by a few units in the last place at most.
    mx, ex = leading(w, top, lx)
    mw, ew = leading(w, below, lw)
    guess, shift = math.frexp(mx / mw)
    mantissa = int(guess * 9007199254740992.0)
    exponent = shift - 53 + ex - ew - m[SCALE]
    scratch = (_MISC + 100) * m[LIMBS]

    # Move to the neighbour until the exact value lies within half a step: round to even.
    for _ in range(8):
        if mantissa >= 9007199254740992:
            mantissa >>= 1
            exponent += 1
        # Is the value above the middle between this double and the next one?
        up = _compare_to_half(w, m, scratch, top, lx, below, lw, 2 * mantissa + 1, exponent - 1)
        if up > 0 or (up == 0 and (mantissa & 1) == 1):
            mantissa += 1
            continue
        if mantissa == 4503599627370496:  # at a power of two the step below is half as long
            down = _compare_to_half(
                w, m, scratch, top, lx, below, lw, 4 * mantissa - 1, exponent - 2
            )
            if down < 0:
                mantissa = 9007199254740991
                exponent -= 1
                continue
        # Is it below the middle between this double and the one before?
        else:
            down = _compare_to_half(
                w, m, scratch, top, lx, below, lw, 2 * mantissa - 1, exponent - 1
            )
            if down < 0 or (down == 0 and (mantissa & 1) == 1):
                mantissa -= 1
                continue
        break
    # only an exact zero becomes 0.0: a coordinate of 0.0 counts as known exactly
    return s * max(math.ldexp(float(mantissa), int(exponent)), _LEAST)


@scalar
def exact_position(frame, i, axis):
    """Correctly rounded coordinate of constructed point i; call `point` at 0 first."""
    d, m, w = frame.d, frame.m, frame.w
    n = m[LIMBS]
    kind = d[i - m[N_VERTEX], 0]
    # Units of X and W: 4 and 3 for a line through a plane (kind 1), 7 and 6 for three planes.
    return exact_round(m, w, axis * 7 * n, (1 + 3 * kind) * n, 21 * n, 3 * kind * n)


def workspace(limbs: int) -> np.ndarray:
    """Return a limb workspace for coordinates of this many limbs."""
    return np.zeros(WORK * max(int(limbs), 4), dtype=np.int64)
