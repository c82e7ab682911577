"""Where a grid with straight axes meets another grid: pairs of triangles, decided where floats can.

In the map, cells of a grid with rising axes are found by bisection. So each cell of the other grid
asks only the cells below or above it, a patch of them at its height; blocks of it that
the pyramid of the first grid (`tree`) shows to be above or below are passed over as a whole. Which
triangles of the patch meet those of the cell is seen from the sides of its nodes (`sided`).

Notation, beside that of `tree` and `sided`: side A has the axes, side B any coordinates
    box  float64 (6,): of a block, then of a cell of B
    at   a cell of B, int64 (6,): its row and column, and first and last (one more) row and column
         of the cells of A below or above it
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels._jit import entry, scalar
from geosurf.kernels.sided import (
    DOUBT,
    N_TERM,
    OPEN,
    ask,
    corners_of_cell,
    decide,
    heights_of_cell,
    insides_of_cell,
    meet_by_heights,
)
from geosurf.kernels.tree import BLOCK, FIRST_COL, FIRST_ROW, N_COL, N_ROW, low_high

__all__ = ["OPEN", "upright_pairs"]

_FINE = 7  # nodes of a pyramid in a row, less one, that are asked for a block


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
def _heights_over(nodes, levels, a, r0, r1, c0, c1, most):
    """Lowest and highest node over a rectangle of cells, from few nodes of a pyramid.

    At most `most` and one of them in a row or column.
    """
    r0, r1 = r0 // BLOCK - a[FIRST_ROW], (r1 - 1) // BLOCK - a[FIRST_ROW]
    c0, c1 = c0 // BLOCK - a[FIRST_COL], (c1 - 1) // BLOCK - a[FIRST_COL]
    r0, c0 = max(r0, 0), max(c0, 0)
    r1, c1 = min(r1, levels[0, 1] - 1), min(c1, levels[0, 2] - 1)
    level = 0
    while r1 - r0 > most or c1 - c0 > most:
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
def _load_cell(p, q, r, a, i, j, origin, c, first):
    """Corners of a cell into four rows of c."""
    _load_axis(p, a, 0, i, j, origin[0], c, first)
    _load_axis(q, a, 1, i, j, origin[1], c, first)
    _load_axis(r, a, 2, i, j, origin[2], c, first)


@scalar
def _set_reach(x, y, at, floor, roof, box, slip, reach):
    """How far nodes of a patch may be from corners of a cell with a box, by axis."""
    reach[0] = max(x[at[5]], box[3]) - min(x[at[4]], box[0]) + 8.0 * slip
    reach[1] = max(y[at[3]], box[4]) - min(y[at[2]], box[1]) + 8.0 * slip
    reach[2] = max(roof, box[5]) - min(floor, box[2]) + 8.0 * slip


@scalar
def _fill(pairs, n, key_a, key_b, codes, swapped):
    if n < pairs.shape[0]:
        pairs[n, 0] = key_b if swapped else key_a
        pairs[n, 1] = key_a if swapped else key_b
        pairs[n, 2] = codes
    return n + 1


@scalar
def _pairs_of_cells(c, f, v, h, w, there, key_a, key_b, slip, swapped, pairs, n):
    """Pairs of triangles of two cells whose corners are loaded."""
    for other in range(2):
        if there & (1 + other) == 0 or not heights_of_cell(c, h[other], w):
            continue
        insides_of_cell(c, h[other], w)
        for half in range(2):
            codes = meet_by_heights(w, v, half, h[other], swapped)
            if codes == DOUBT:
                codes = decide(c, f, v, half, 2 + other, slip, swapped)
            if codes != 0:
                n = _fill(pairs, n, key_a + half, key_b + other, codes, swapped)
    return n


@scalar
def _pairs_of_cell(
    pa, qa, ra, aa, pb, qb, rb, ab, at, box, reach, origin, slip, swapped, c, f, v, h, w, pairs, n
):
    """Pairs of triangles of a cell of B and the cells of A below or above it, `at`."""
    up, on = aa[7], aa[8]
    key_b = 2 * (at[0] * (ab[N_COL] - 1) + at[1])
    there = -1  # which triangles of B have three nodes, once they are loaded
    for i in range(at[2], at[3]):
        for j in range(at[4], at[5]):
            least, most = low_high(ra, aa[6] + i * up + j * on, up, on)
            if not (least <= box[5] and box[2] <= most):
                continue
            if there < 0:
                _load_cell(pb, qb, rb, ab, at[0], at[1], origin, c, 4)
                there = ask(c, f, v, 2, reach, slip, h[0])
                there += 2 * ask(c, f, v, 3, reach, slip, h[1])
            _load_cell(pa, qa, ra, aa, i, j, origin, c, 0)
            key_a = 2 * (i * (aa[N_COL] - 1) + j)
            n = _pairs_of_cells(c, f, v, h, w, there, key_a, key_b, slip, swapped, pairs, n)
    return n


@scalar
def _near_heights(pa, qa, aa, na, la, nb, block, pace_x, pace_y):
    """Lowest and highest node of A near a block of B, from few; none (inf, -inf) if it is beyond.

    First from the fewest, which tell of most blocks that they are far from A.
    """
    c0, c1 = _range_on(pa, aa[N_COL] - 1, pace_x, nb[block, 0], nb[block, 3])
    r0, r1 = _range_on(qa, aa[N_ROW] - 1, pace_y, nb[block, 1], nb[block, 4])
    if not (c0 < c1 and r0 < r1 and nb[block, 2] <= nb[block, 5]):
        return np.inf, -np.inf
    for most in (1, _FINE):
        low, high = _heights_over(na, la, aa, r0, r1, c0, c1, most)
        if not (low <= nb[block, 5] and nb[block, 2] <= high):
            return np.inf, -np.inf
    return low, high


@scalar
def _patch_near(pa, qa, aa, na, la, box, pace_x, pace_y, at):
    """Cells of A below or above a box, into `at`; lowest and highest node there."""
    at[2], at[3] = _range_on(qa, aa[N_ROW] - 1, pace_y, box[1], box[4])
    at[4], at[5] = _range_on(pa, aa[N_COL] - 1, pace_x, box[0], box[3])
    return _heights_over(na, la, aa, at[2], at[3], at[4], at[5], 1)


@entry("d1 d1 d1 l1 d2 l2 d1 d1 d1 l1 d2 l2 d1 d b l2 -> l l")
def upright_pairs(pa, qa, ra, aa, na, la, pb, qb, rb, ab, nb, lb, origin, slip, swapped, pairs):
    """Pairs (key of A, key of B, codes or OPEN) that meet or may, and how many cells were asked.

    Tells how many there are; `pairs` takes as many as it has room for. `codes` are those of the
    two corners of a contact, ``64 * first + second``. With `swapped`, B comes first in all of it.
    """
    c, f, v = np.empty((8, 3)), np.empty((4, 7)), np.empty((4, 3), dtype=np.int64)
    box, reach, h, w = np.empty(6), np.empty(3), np.empty((2, N_TERM)), np.empty((4, 4))
    at = np.empty(6, dtype=np.int64)
    corners_of_cell(aa, v, 0)
    corners_of_cell(ab, v, 4)
    pace_x = (aa[N_COL] - 1) / (pa[aa[N_COL] - 1] - pa[0])
    pace_y = (aa[N_ROW] - 1) / (qa[aa[N_ROW] - 1] - qa[0])
    n = 0
    asked = 0
    for block in range(lb[0, 1] * lb[0, 2]):
        low, high = _near_heights(pa, qa, aa, na, la, nb, block, pace_x, pace_y)
        if not low <= high:
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
                floor, roof = _patch_near(pa, qa, aa, na, la, box, pace_x, pace_y, at)
                if floor <= box[5] and box[2] <= roof:
                    at[0], at[1] = i, j
                    _set_reach(pa, qa, at, floor, roof, box, slip, reach)
                    n = _pairs_of_cell(
                        pa, qa, ra, aa, pb, qb, rb, ab, at, box, reach, origin, slip, swapped,
                        c, f, v, h, w, pairs, n,
                    )  # fmt: skip
    return n, asked
