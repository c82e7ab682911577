"""Where a grid with straight axes meets another grid: pairs of triangles, decided where floats can.

In the map, cells of a grid with rising axes are found by bisection. So each cell of the other grid
asks only the cells below or above it, and of these only those at its height; blocks of it that
the pyramid of the first grid (`tree`) shows to be above or below are passed over as a whole. The
corners of both triangles are at hand then, and signs that floats are sure of settle nearly all
pairs at once, the way `contact` does it.

Notation, beside that of `tree`: side A has the axes, side B any coordinates
    c    corners in the local frame, float64 (8, 3): of a cell of A, then of one of B
    v    corners (rows of c) of triangles, int64 (4, 3): 0 and 1 of A, 2 and 3 of B
    f    plane of each triangle, float64 (4, 7): see `predicates.plane_terms`
    signs  sides of a triangle of B on which corners of a cell of A lie, 0 where floats doubt
    box  float64 (6,): of a block, then of a cell of B
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels._jit import entry, scalar
from geosurf.kernels.contact import FACE, lone
from geosurf.kernels.predicates import plain_side
from geosurf.kernels.tree import (
    BLOCK,
    FIRST_COL,
    FIRST_ROW,
    N_COL,
    N_ROW,
    RISING,
    TURNED,
    low_high,
)

OPEN = -1  # in place of the codes of a pair: exact signs are needed


@scalar
def _guess(axis, n, value, pace):
    """Where a value would be among n cells of even steps."""
    return int(min(max((value - axis[0]) * pace, 0.0), 1.0 * n))


@scalar
def _range_on(axis, n, pace, low, high):
    """First and last cell (one more) of n on a rising axis that reach an interval.

    `pace` is cells per metre: where steps are even, a guess by it is right or nearly so.
    """
    first = _guess(axis, n, low, pace)  # the first cell that ends at `low` or after
    if first > 0 and axis[first] >= low:
        first -= 1
    elif first < n and axis[first + 1] < low:
        first += 1
    if (first > 0 and axis[first] >= low) or (first < n and axis[first + 1] < low):
        first, end = 0, n
        while first < end:
            middle = (first + end) >> 1
            if axis[middle + 1] < low:
                first = middle + 1
            else:
                end = middle
    last = _guess(axis, n, high, pace) + 1  # the first cell that begins after `high`
    last = min(last, n)
    if last > 0 and axis[last - 1] > high:
        last -= 1
    elif last < n and axis[last] <= high:
        last += 1
    if (last > 0 and axis[last - 1] > high) or (last < n and axis[last] <= high):
        last, end = 0, n
        while last < end:
            middle = (last + end) >> 1
            if axis[middle] <= high:
                last = middle + 1
            else:
                end = middle
    return first, last


@scalar
def _heights_over(nodes, levels, a, r0, r1, c0, c1):
    """Lowest and highest node over a rectangle of cells, from few nodes of a pyramid."""
    r0, r1 = r0 // BLOCK - a[FIRST_ROW], (r1 - 1) // BLOCK - a[FIRST_ROW]
    c0, c1 = c0 // BLOCK - a[FIRST_COL], (c1 - 1) // BLOCK - a[FIRST_COL]
    r0, c0 = max(r0, 0), max(c0, 0)
    r1, c1 = min(r1, levels[0, 1] - 1), min(c1, levels[0, 2] - 1)
    level = 0
    while r1 - r0 > 1 or c1 - c0 > 1:
        r0, r1, c0, c1 = r0 >> 1, r1 >> 1, c0 >> 1, c1 >> 1
        level += 1
    low, high = np.inf, -np.inf
    for i in range(r0, r1 + 1):
        for j in range(c0, c1 + 1):
            node = levels[level, 0] + i * levels[level, 2] + j
            low = min(low, nodes[node, 2])
            high = max(high, nodes[node, 5])
    return low, high


@scalar
def _cell_box(values, a, axis, i, j, box):
    up, on = a[3 * axis + 1], a[3 * axis + 2]
    low, high = low_high(values, a[3 * axis] + i * up + j * on, up, on)
    box[axis], box[3 + axis] = low, high


@scalar
def _load_axis(values, a, axis, i, j, origin, c, first):
    """One coordinate of the four corners of a cell, counter-clockwise, in the local frame."""
    up, on = a[3 * axis + 1], a[3 * axis + 2]
    at = a[3 * axis] + i * up + j * on
    c[first, axis] = values[at] - origin
    c[first + 1, axis] = values[at + on] - origin
    c[first + 2, axis] = values[at + up + on] - origin
    c[first + 3, axis] = values[at + up] - origin


@scalar
def _corners(a, v, first):
    """Rows of corners of both triangles of a cell into two rows of v: see `strips.corner_of`."""
    rising = a[RISING] == 1
    for half in range(2):
        tri = half if first == 0 else 2 + half
        v[tri, 0] = first + (1 if half == 1 and not rising else 0)
        two = first + (2 if half == 1 else 1)
        three = first + (2 if half == 0 and rising else 3)
        v[tri, 1] = three if a[TURNED] == 1 else two
        v[tri, 2] = two if a[TURNED] == 1 else three


@scalar
def _plane(c, f, tri, v):
    """Plane terms of a triangle; whether all its corners are there."""
    o, p, q = v[tri, 0], v[tri, 1], v[tri, 2]
    ax, ay, az = c[p, 0] - c[o, 0], c[p, 1] - c[o, 1], c[p, 2] - c[o, 2]
    bx, by, bz = c[q, 0] - c[o, 0], c[q, 1] - c[o, 1], c[q, 2] - c[o, 2]
    p0, q0 = ay * bz, az * by
    p1, q1 = az * bx, ax * bz
    p2, q2 = ax * by, ay * bx
    f[tri, 0], f[tri, 1], f[tri, 2] = p0 - q0, p1 - q1, p2 - q2
    f[tri, 3], f[tri, 4], f[tri, 5] = abs(p0) + abs(q0), abs(p1) + abs(q1), abs(p2) + abs(q2)
    f[tri, 6] = abs(ax) + abs(ay) + abs(az) + abs(bx) + abs(by) + abs(bz)
    total = ax + ay + az + bx + by + bz
    return total == total


@scalar
def _side(c, f, tri, o, corner, slip):
    """Side of a triangle with a corner o on which another corner lies, or 0."""
    cx, cy, cz = c[corner, 0] - c[o, 0], c[corner, 1] - c[o, 1], c[corner, 2] - c[o, 2]
    return plain_side(
        cx, cy, cz, f[tri, 0], f[tri, 1], f[tri, 2], f[tri, 3], f[tri, 4], f[tri, 5], f[tri, 6],
        slip,
    )  # fmt: skip


@scalar
def _order(c, p, p1, q, q1, slip):
    """Sign that orders, on the common line, the points of edges p-p1 and q-q1, or 0."""
    ax, ay, az = c[p1, 0] - c[p, 0], c[p1, 1] - c[p, 1], c[p1, 2] - c[p, 2]
    bx, by, bz = c[q, 0] - c[p, 0], c[q, 1] - c[p, 1], c[q, 2] - c[p, 2]
    g, h = ay * bz, az * by
    r, s = az * bx, ax * bz
    u, v = ax * by, ay * bx
    span = abs(ax) + abs(ay) + abs(az) + abs(bx) + abs(by) + abs(bz)
    cx, cy, cz = c[q1, 0] - c[p, 0], c[q1, 1] - c[p, 1], c[q1, 2] - c[p, 2]
    return plain_side(
        cx, cy, cz, g - h, r - s, u - v, abs(g) + abs(h), abs(r) + abs(s), abs(u) + abs(v), span,
        slip,
    )  # fmt: skip


@scalar
def _apart_on(c, axis, o, p, q, r, s, t):
    """Whether triangles o p q and r s t are apart on one axis."""
    low = min(c[o, axis], min(c[p, axis], c[q, axis]))
    high = max(c[o, axis], max(c[p, axis], c[q, axis]))
    least = min(c[r, axis], min(c[s, axis], c[t, axis]))
    most = max(c[r, axis], max(c[s, axis], c[t, axis]))
    return low > most or least > high


@scalar
def _apart(c, v, one, two):
    """Whether the boxes of two triangles do not meet."""
    o, p, q = v[one, 0], v[one, 1], v[one, 2]
    r, s, t = v[two, 0], v[two, 1], v[two, 2]
    return (
        _apart_on(c, 2, o, p, q, r, s, t)
        or _apart_on(c, 0, o, p, q, r, s, t)
        or _apart_on(c, 1, o, p, q, r, s, t)
    )


@scalar
def _add_codes(codes, i, i2, on_first, on_last, second):
    """Codes of a triangle's edges i and i2 through the face of the other, behind other codes."""
    for k in range(3):
        if (k == i and on_first) or (k == i2 and on_last):
            codes = 64 * codes + (8 * FACE + 3 + k if second else 8 * (3 + k) + FACE)
    return codes


@scalar
def _decide(c, f, v, one, two, signs, slip, swapped):
    """How two triangles meet: 0 not at all, OPEN, or the two codes of `contact` in one.

    The same questions in the same order as in `contact._meet_plainly`; `signs` has the sides of
    `two` on which the corners of the first cell lie. With `swapped`, codes are those of the second
    and the first triangle.
    """
    a0, a1, a2 = signs[v[one, 0]], signs[v[one, 1]], signs[v[one, 2]]
    if a0 * a1 * a2 == 0:
        return OPEN
    if a0 == a1 and a1 == a2:
        return 0
    o = v[one, 0]
    b0 = _side(c, f, one, o, v[two, 0], slip)
    b1 = _side(c, f, one, o, v[two, 1], slip)
    b2 = _side(c, f, one, o, v[two, 2], slip)
    if b0 * b1 * b2 == 0:
        return OPEN
    if b0 == b1 and b1 == b2:
        return 0
    i, j = lone(a0, a1, a2), lone(b0, b1, b2)
    i2, j2 = (i + 2) % 3, (j + 2) % 3
    p, p1, p2 = v[one, i], v[one, (i + 1) % 3], v[one, i2]
    q, q1, q2 = v[two, j], v[two, (j + 1) % 3], v[two, j2]
    s11, s12 = _order(c, p, p1, q, q1, slip), _order(c, p, p1, q, q2, slip)
    s21, s22 = _order(c, p, p2, q, q1, slip), _order(c, p, p2, q, q2, slip)
    if s11 * s12 * s21 * s22 == 0:
        return OPEN
    if s11 == s12 and s21 == s22 and s11 == s21:
        return 0
    if swapped:
        codes = _add_codes(0, j, j2, s11 != s21, s12 != s22, False)
        return _add_codes(codes, i, i2, s11 != s12, s21 != s22, True)
    codes = _add_codes(0, i, i2, s11 != s12, s21 != s22, False)
    return _add_codes(codes, j, j2, s11 != s21, s12 != s22, True)


@scalar
def _signs_of_cell(c, f, v, tri, slip, signs):
    """Sides of triangle `tri` of B on which the corners of a cell of A lie; whether all are one."""
    o = v[tri, 0]
    signs[0] = _side(c, f, tri, o, 0, slip)
    signs[1] = _side(c, f, tri, o, 1, slip)
    signs[2] = _side(c, f, tri, o, 2, slip)
    signs[3] = _side(c, f, tri, o, 3, slip)
    one = signs[0]
    return one != 0 and one == signs[1] and one == signs[2] and one == signs[3]


@scalar
def _fill(pairs, n, key_a, key_b, codes, swapped):
    if n < pairs.shape[0]:
        pairs[n, 0] = key_b if swapped else key_a
        pairs[n, 1] = key_a if swapped else key_b
        pairs[n, 2] = codes
    return n + 1


@entry("d1 d1 d1 l1 d2 l2 d1 d1 d1 l1 d2 l2 d1 d b l2 -> l l")
def upright_pairs(pa, qa, ra, aa, na, la, pb, qb, rb, ab, nb, lb, origin, slip, swapped, pairs):
    """Pairs (key of A, key of B, codes or OPEN) that meet or may, and how many cells were asked.

    Tells how many there are; `pairs` takes as many as it has room for. `codes` are those of the
    two corners of a contact, ``64 * first + second``. With `swapped`, B comes first in all of it.
    """
    c, f, box = np.empty((8, 3)), np.empty((4, 7)), np.empty(6)
    v, signs = np.empty((4, 3), dtype=np.int64), np.empty(4, dtype=np.int64)
    _corners(aa, v, 0)
    _corners(ab, v, 4)
    n_col, n_row = aa[N_COL] - 1, aa[N_ROW] - 1
    up, on = aa[7], aa[8]
    pace_x, pace_y = n_col / (pa[n_col] - pa[0]), n_row / (qa[n_row] - qa[0])
    n = 0
    asked = 0
    for block in range(lb[0, 1] * lb[0, 2]):
        if not (nb[block, 0] <= nb[block, 3] and nb[block, 2] <= nb[block, 5]):
            continue
        c0, c1 = _range_on(pa, n_col, pace_x, nb[block, 0], nb[block, 3])
        r0, r1 = _range_on(qa, n_row, pace_y, nb[block, 1], nb[block, 4])
        if c0 >= c1 or r0 >= r1:
            continue
        low, high = _heights_over(na, la, aa, r0, r1, c0, c1)
        if not (low <= nb[block, 5] and nb[block, 2] <= high):
            continue
        row0 = BLOCK * (ab[FIRST_ROW] + block // lb[0, 2])
        col0 = BLOCK * (ab[FIRST_COL] + block % lb[0, 2])
        for i in range(row0, min(row0 + BLOCK, ab[N_ROW] - 1)):
            for j in range(col0, min(col0 + BLOCK, ab[N_COL] - 1)):
                _cell_box(rb, ab, 2, i, j, box)
                if not (low <= box[5] and box[2] <= high):
                    continue
                asked += 1
                _cell_box(pb, ab, 0, i, j, box)
                _cell_box(qb, ab, 1, i, j, box)
                s0, s1 = _range_on(pa, n_col, pace_x, box[0], box[3])
                t0, t1 = _range_on(qa, n_row, pace_y, box[1], box[4])
                floor, roof = _heights_over(na, la, aa, t0, t1, s0, s1)
                if not (floor <= box[5] and box[2] <= roof):
                    continue
                there = -1  # which triangles of B exist, once they are loaded
                for row in range(t0, t1):
                    for col in range(s0, s1):
                        least, most = low_high(ra, aa[6] + row * up + col * on, up, on)
                        if not (least <= box[5] and box[2] <= most):
                            continue
                        if there < 0:
                            _load_axis(pb, ab, 0, i, j, origin[0], c, 4)
                            _load_axis(qb, ab, 1, i, j, origin[1], c, 4)
                            _load_axis(rb, ab, 2, i, j, origin[2], c, 4)
                            there = 1 if _plane(c, f, 2, v) else 0
                            there += 2 if _plane(c, f, 3, v) else 0
                        _load_axis(pa, aa, 0, row, col, origin[0], c, 0)
                        _load_axis(qa, aa, 1, row, col, origin[1], c, 0)
                        _load_axis(ra, aa, 2, row, col, origin[2], c, 0)
                        planes = -1
                        for other in range(2):
                            if there & (1 + other) == 0:
                                continue
                            if _signs_of_cell(c, f, v, 2 + other, slip, signs):
                                continue
                            if planes < 0:
                                planes = 1 if _plane(c, f, 0, v) else 0
                                planes += 2 if _plane(c, f, 1, v) else 0
                            for half in range(2):
                                if planes & (1 + half) == 0 or _apart(c, v, half, 2 + other):
                                    continue
                                codes = _decide(c, f, v, half, 2 + other, signs, slip, swapped)
                                if codes != 0:
                                    key_a = 2 * (row * n_col + col) + half
                                    key_b = 2 * (i * (ab[N_COL] - 1) + j) + other
                                    n = _fill(pairs, n, key_a, key_b, codes, swapped)
    return n, asked
