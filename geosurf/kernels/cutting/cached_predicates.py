"""Exact signs for the points of one face, with the integers of each point computed once and
shortened.

Letters as in `exact_signs` and `delaunay`. A point of the face has integer homogeneous coordinates
(U, V, W) on the two axes of its projection, W > 0. `exact_signs` computes them again for every
sign, at the length that the worst input needs. Here they are cached in the part of `w` behind the
scratch of `exact_signs`, without zero limbs at either end: most coordinates have few digits, and
so have their differences.

Only signs are needed, so each point may have its own positive factor. U and V are stored as
integers times 2**(26 shift), where shift may be negative, and W as an integer. A row holds the
shift, the lengths of U, V and W, and their limbs. When the cache is full, all rows are dropped; a
row that is needed again is computed again.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.exact.bigint import BITS, clear, mul_add, sign
from geosurf.kernels.exact.exact_signs import (
    EQUALITY_TESTS,
    EXACT_INCIRCLE,
    EXACT_ORIENT2D,
    LIMBS,
    WORK,
    point,
)

POINTS, AXIS, USED = 0, 2, 6  # of the state s
CACHED = 2  # column of q: offset of the row of a point, -1: not cached
_HEAD = 4
_SCRATCH = 240  # units of w from here on are free scratch
_MOST = 1 << 20


def face_workspace(limbs: int, n_local: int) -> np.ndarray:
    """Return a limb workspace with a cache for the points of a face of this size."""
    n = max(int(limbs), 4)
    rows = min(_MOST, 24 * n * n_local)

    # However few points a face has, the rows that one sign needs always fit.
    return np.empty(WORK * n + max(rows, 5 * (20 * n + _HEAD)), dtype=np.int64)


@scalar
def _zeros_below(w, a, n):
    """Number of lowest limbs that are zero; n if all are."""
    for i in range(n):
        if w[a + i] != 0:
            return i
    return n


@scalar
def _shortened(w, a, n):
    """Length of a number without upper limbs that only repeat its sign."""
    while n > 1 and (w[a + n - 1] == 0 or w[a + n - 1] == -1):
        # A top limb of -1 only repeats the sign: the limb below takes it over.
        w[a + n - 2] += w[a + n - 1] << BITS
        n -= 1
    return n


@scalar
def _store(w, to, a, n):
    """Copy a number; returns the offset behind it."""
    for i in range(n):
        w[to + i] = w[a + i]
    return to + n


@scalar
def _row(frame, points, p):
    """Offset of the row of local point p, computed if it is not cached."""
    m, w = frame.m, frame.w
    q, s = points.q, points.s
    if q[p, CACHED] >= 0:
        return q[p, CACHED]
    n = m[LIMBS]

    # U and V share one shift, so that they remain comparable; W has its own.
    lx, lw = point(frame, 0, q[p, 0])
    u, v, below = ((s[AXIS] + 1) % 3) * 7 * n, ((s[AXIS] + 2) % 3) * 7 * n, 21 * n

    # Drop zero limbs below and sign limbs above.
    low = min(_zeros_below(w, u, lx), _zeros_below(w, v, lx))
    low = min(low, lx - 1)  # if both are zero, keep one limb of each
    low_w = _zeros_below(w, below, lw)
    nu = _shortened(w, u + low, lx - low)
    nv = _shortened(w, v + low, lx - low)
    nw = _shortened(w, below + low_w, lw - low_w)

    # Append the row to the cache.
    at = WORK * max(n, 4) + s[USED]
    # A factor common to U, V and W changes no sign: the shift is stored relative to that of W.
    w[at], w[at + 1], w[at + 2], w[at + 3] = low - low_w, nu, nv, nw
    to = _store(w, at + _HEAD, u + low, nu)
    to = _store(w, to, v + low, nv)
    to = _store(w, to, below + low_w, nw)
    s[USED] = to - WORK * max(n, 4)
    q[p, CACHED] = at
    return at


@scalar
def _ensure_capacity(m, w, q, s):
    """Ensure that four more rows fit; otherwise drop all."""
    n = m[LIMBS]
    if WORK * max(n, 4) + s[USED] + 4 * (20 * n + _HEAD) > w.shape[0]:
        for p in range(s[POINTS]):
            q[p, CACHED] = -1
        s[USED] = 0


@scalar
def _minor(w, r, a, b):
    """r = U_a V_b - V_a U_b for the rows a, b, without their shifts; returns its length."""
    ua, va = a + _HEAD, a + _HEAD + w[a + 1]
    ub, vb = b + _HEAD, b + _HEAD + w[b + 1]
    # One limb to spare for the difference.
    n = max(w[a + 1] + w[b + 2], w[a + 2] + w[b + 1]) + 1
    clear(w, r, n)
    mul_add(w, r, n, ua, w[a + 1], vb, w[b + 2], 1)
    mul_add(w, r, n, va, w[a + 2], ub, w[b + 1], -1)
    return n


@scalar
def _below(w, a):
    """Offset of W of a row."""
    return a + _HEAD + w[a + 1] + w[a + 2]


@scalar
def cached_orient2d(frame, points, a, b, c):
    """Sign of the turn of local points a, b, c."""
    m, w = frame.m, frame.w
    q, s = points.q, points.s
    m[EXACT_ORIENT2D] += 1
    _ensure_capacity(m, w, q, s)
    i = _row(frame, points, a)
    j = _row(frame, points, b)
    k = _row(frame, points, c)
    # det of the rows (U, V, W), by W: shifts of the three terms are those of the other rows
    # The smallest of the three shifts is a common factor and does not change the sign.
    shift = min(w[j] + w[k], min(w[k] + w[i], w[i] + w[j]))

    # Length of the accumulator: the longest product, shifted by the largest difference.
    acc = _SCRATCH * m[LIMBS]
    longest = max(w[i + 1], w[i + 2]) + w[i + 3]
    longest += max(w[j + 1], w[j + 2]) + w[j + 3]
    longest += max(w[k + 1], w[k + 2]) + w[k + 3]
    total = longest + max(w[j] + w[k], max(w[k] + w[i], w[i] + w[j])) - shift + 2
    minor = acc + total
    clear(w, acc, total)

    # Three terms: a minor of two rows times W of the third, in cyclic order.
    for _ in range(3):
        n = _minor(w, minor, i, j)
        # Limbs by which this term is above the common shift.
        up = w[i] + w[j] - shift
        mul_add(w, acc + up, total - up, minor, n, _below(w, k), w[k + 3], 1)
        i, j, k = j, k, i
    return sign(w, acc, total)


@scalar
def cached_compare(frame, points, a, b, second):
    """Sign of a coordinate of local point a minus that of b: U, or V with `second` = 1."""
    m, w = frame.m, frame.w
    q, s = points.q, points.s
    m[EQUALITY_TESTS] += 1
    _ensure_capacity(m, w, q, s)
    i = _row(frame, points, a)
    j = _row(frame, points, b)
    at, n = i + _HEAD + second * w[i + 1], w[i + 1 + second]
    other, n_other = j + _HEAD + second * w[j + 1], w[j + 1 + second]

    # Bring both sides to the smaller shift, then compare U_a W_b with U_b W_a.
    shift = min(w[i], w[j])
    up, lift = w[i] - shift, w[j] - shift
    total = max(n + w[j + 3] + up, n_other + w[i + 3] + lift) + 1
    acc = _SCRATCH * m[LIMBS]
    clear(w, acc, total)
    mul_add(w, acc + up, total - up, at, n, _below(w, j), w[j + 3], 1)
    # Both W are positive, so the sign is that of the difference of coordinates.
    mul_add(w, acc + lift, total - lift, other, n_other, _below(w, i), w[i + 3], -1)
    return sign(w, acc, total)


@scalar
def _lifted(w, r, a, b):
    """r = (U_a^2 + V_a^2) W_b^2 - (U_b^2 + V_b^2) W_a^2, and its length and shift."""
    shift = 2 * min(w[a], w[b])
    na, nb = 2 * max(w[a + 1], w[a + 2]) + 1, 2 * max(w[b + 1], w[b + 2]) + 1
    la, lb = 2 * w[a + 3], 2 * w[b + 3]
    up, lift = 2 * w[a] - shift, 2 * w[b] - shift
    n = max(na + lb + up, nb + la + lift) + 1
    square = r + n
    below = square + max(na, nb)
    clear(w, r, n)

    # First product, then the second one is subtracted.
    _square(w, square, na, a)
    clear(w, below, lb)
    mul_add(w, below, lb, _below(w, b), w[b + 3], _below(w, b), w[b + 3], 1)
    mul_add(w, r + up, n - up, square, na, below, lb, 1)
    _square(w, square, nb, b)
    clear(w, below, la)
    mul_add(w, below, la, _below(w, a), w[a + 3], _below(w, a), w[a + 3], 1)
    mul_add(w, r + lift, n - lift, square, nb, below, la, -1)
    return n, shift


@scalar
def _square(w, r, n, a):
    """r = U_a^2 + V_a^2, without its shift."""
    u, v = a + _HEAD, a + _HEAD + w[a + 1]
    clear(w, r, n)
    mul_add(w, r, n, u, w[a + 1], u, w[a + 1], 1)
    mul_add(w, r, n, v, w[a + 2], v, w[a + 2], 1)


@scalar
def cached_incircle(frame, points, a, b, c, o):
    """Sign > 0 if local point o is inside the circle of counter-clockwise a, b, c.

    Rows (U W, V W, U^2 + V^2, W^2), by 2 x 2 minors of the first two columns (i, j) and of the
    last two (k, the fourth): (U_i V_j - V_i U_j) W_i W_j ((U_k^2 + V_k^2) W^2 - ...).
    """
    m, w = frame.m, frame.w
    q, s = points.q, points.s
    m[EXACT_INCIRCLE] += 1
    _ensure_capacity(m, w, q, s)
    rows = (
        _row(frame, points, a),
        _row(frame, points, b),
        _row(frame, points, c),
        _row(frame, points, o),
    )

    # Bounds of shifts and lengths size the accumulator.
    low, high, longest, longest_w = w[rows[0]], w[rows[0]], 0, 0
    for r in rows:
        low, high = min(low, w[r]), max(high, w[r])
        longest = max(longest, max(w[r + 1], w[r + 2]))
        longest_w = max(longest_w, w[r + 3])
    total = 4 * (longest + longest_w + high - low) + 8
    acc = _SCRATCH * m[LIMBS]
    minor = acc + total
    clear(w, acc, total)

    # Laplace expansion: six pairs of rows (i, j), complements (k, 6 - i - j - k).
    for i in range(3):
        # Two rows give the minor of U and V, the other two that of the lifted columns.
        for j in range(i + 1, 4):
            k = 0
            while k == i or k == j:
                k += 1

            # Left factor: the minor times W_i W_j.
            p, r = rows[i], rows[j]
            n = _minor(w, minor, p, r)
            product = minor + n
            n_product = n + w[p + 3]
            clear(w, product, n_product)
            mul_add(w, product, n_product, minor, n, _below(w, p), w[p + 3], 1)
            left = product + n_product
            n_left = n_product + w[r + 3]
            clear(w, left, n_left)
            mul_add(w, left, n_left, product, n_product, _below(w, r), w[r + 3], 1)

            # Right factor: the lifted minor of the other two rows; the sign alternates.
            right = left + n_left
            n_right, shift = _lifted(w, right, rows[k], rows[6 - i - j - k])
            up = w[p] + w[r] + shift - 4 * low
            factor = 1 - 2 * ((i + j + 1) % 2)
            mul_add(w, acc + up, total - up, left, n_left, right, n_right, factor)
    return sign(w, acc, total)
