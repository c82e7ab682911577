"""Properties of a lattice in one pass over its nodes: boxes of blocks, and holes.

Every reader of a grid needs the same facts about all of its nodes: are they numbers, what are the
extremes, which triangles are there. Here all of them cost little more than reading the numbers
once: tiles of a few rows stay in the cache, and loops run over scratch rows, so that they are
vectorised.

Notation, in addition to that of `tree` (p, q, r, a)
    a b c d  corners of a cell, counter-clockwise: (i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)
    tile     TILE columns of one row of blocks
    work     scratch rows of ROW_SIZE numbers, one after the other
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.strips import load
from geosurf.kernels.search.tree import BLOCK, N_COL, N_ROW, build_above, levels_of

TILE = 16 * BLOCK
ROW_SIZE = TILE + 2 * BLOCK
# indices into `marks`: triangles with either diagonal; 1 if a coordinate (three of them) is not a
# number, if one is -0.0, or if easting and northing are increasing axes
N_RISING, N_FALLING, NOT_A_NUMBER, MINUS_ZERO, AXES_RISE, N_MARK = 0, 1, 2, 5, 6, 7
# two bits for each coordinate
_NOT_A_NUMBER, _MINUS_ZEROS = 0b010101, 0b101010
# scratch rows: extremes of nodes by column
_LOW, _HIGH = 0, 1


@scalar
def fill(work, first, last, value):
    """Fill some scratch rows with one value."""
    for k in range(first * ROW_SIZE, last * ROW_SIZE):
        work[k] = value


@scalar
def least(low, p, q, r, s, t):
    """The least of six numbers; NaN among the last five is skipped."""
    low = p if p < low else low
    low = q if q < low else low
    low = r if r < low else low
    low = s if s < low else low
    return t if t < low else low


@scalar
def most(high, p, q, r, s, t):
    """The largest of six numbers, like `least`."""
    high = p if p > high else high
    high = q if q > high else high
    high = r if r > high else high
    high = s if s > high else high
    return t if t > high else high


@scalar
def _is_minus_zero(value):
    return value == 0.0 and math.copysign(1.0, value) < 0.0


@scalar
def _has_minus_zero(values, a, axis, block, first, n):
    """Whether -0.0 is among the values of a tile."""
    for i in range(block * BLOCK, min(block * BLOCK + BLOCK, a[N_ROW] - 1) + 1):
        for j in range(first, first + n):
            if _is_minus_zero(load(values, a, axis, i, j)):
                return True
    return False


@scalar
def _five_rows(values, start, step, last, n, work):
    """Extend extremes by column with rows 0 to `last`, at most 4; number of columns with a NaN."""
    row_a = values[start : start + n]
    # Rows beyond the last one repeat it: extremes stay the same.
    row_b = values[start + min(1, last) * step : start + min(1, last) * step + n]
    row_c = values[start + min(2, last) * step : start + min(2, last) * step + n]
    row_d = values[start + min(3, last) * step : start + min(3, last) * step + n]
    row_e = values[start + last * step : start + last * step + n]
    n_nan = 0
    for j in range(min(n, ROW_SIZE)):  # selections without branches are vectorised
        p, q, r, s, t = row_a[j], row_b[j], row_c[j], row_d[j], row_e[j]
        low, high = work[_LOW * ROW_SIZE + j], work[_HIGH * ROW_SIZE + j]
        work[_LOW * ROW_SIZE + j] = least(low, p, q, r, s, t)
        work[_HIGH * ROW_SIZE + j] = most(high, p, q, r, s, t)
        total = ((p + q) + (r + s)) + t  # also of infinite values, which boxes reveal
        n_nan += 1 if total != total else 0
    return n_nan


@scalar
def _least(work, j):
    """The least of nine numbers: those of a block with its boundary in a row."""
    # Blocks share the nodes at their boundary: eight cells have nine nodes.
    a, b, c, d = work[j], work[j + 1], work[j + 2], work[j + 3]
    e, f, g, h = work[j + 4], work[j + 5], work[j + 6], work[j + 7]

    # A tree of selections, without branches.
    a, b = a if a < b else b, c if c < d else d
    e, f = e if e < f else f, g if g < h else h
    a, e = a if a < b else b, e if e < f else f
    a = a if a < e else e
    return a if a < work[j + 8] else work[j + 8]


@scalar
def _most(work, j):
    """The largest of nine numbers."""
    a, b, c, d = work[j], work[j + 1], work[j + 2], work[j + 3]
    e, f, g, h = work[j + 4], work[j + 5], work[j + 6], work[j + 7]
    a, b = a if a > b else b, c if c > d else d
    e, f = e if e > f else f, g if g > h else h
    a, e = a if a > b else b, e if e > f else f
    a = a if a > e else e
    return a if a > work[j + 8] else work[j + 8]


@scalar
def _tile_extremes(values, a, axis, block, first, work, boxes, n_block):
    """Extremes of one coordinate, with a number for each node, in the blocks of a tile.

    Returns 1 if a value is NaN, plus 2 if there is a -0.0.
    """
    fill(work, _LOW, _LOW + 1, np.inf)
    fill(work, _HIGH, _HIGH + 1, -np.inf)
    step = a[3 * axis + 1]
    start = a[3 * axis] + block * BLOCK * step + first
    last = min(BLOCK, a[N_ROW] - 1 - block * BLOCK)
    n = min(TILE + BLOCK, a[N_COL] - first)  # whole vectors of columns, without a remainder

    # Two groups of rows, then the extremes of each block.
    n_nan = _five_rows(values, start, step, min(last, 4), n, work)
    if last > 4:
        n_nan += _five_rows(values, start + 4 * step, step, last - 4, n, work)
    lowest, highest = np.inf, -np.inf
    for b in range(first // BLOCK, min((first + TILE) // BLOCK, n_block)):
        lower = _least(work, _LOW * ROW_SIZE + b * BLOCK - first)
        upper = _most(work, _HIGH * ROW_SIZE + b * BLOCK - first)
        boxes[block * n_block + b, axis] = lower
        boxes[block * n_block + b, 3 + axis] = upper
        lowest, highest = min(lowest, lower), max(highest, upper)

    # -0.0 can only be among values of a range that includes zero.
    bits = 1 if n_nan > 0 else 0
    n = min(TILE + 1, a[N_COL] - first)
    if lowest <= 0.0 <= highest and _has_minus_zero(values, a, axis, block, first, n):
        bits += 2
    return bits


@scalar
def _axis_extremes(values, a, axis, boxes, n_block):
    """The same in all blocks, of a coordinate that is equal in all rows or in all columns."""
    # A coordinate along columns or along rows.
    along = a[3 * axis + 1] == 0
    n = a[N_COL] if along else a[N_ROW]
    step = a[3 * axis + 2] if along else a[3 * axis + 1]
    n_row = boxes.shape[0] // n_block
    bits = 0
    for b in range(n_block if along else n_row):
        low, high = np.inf, -np.inf
        for k in range(b * BLOCK, min(b * BLOCK + BLOCK + 1, n)):
            value = values[a[3 * axis] + k * step]
            low = value if value < low else low
            high = value if value > high else high
            bits |= (1 if value != value else 0) | (2 if _is_minus_zero(value) else 0)
        # All blocks of that column, or row, of blocks have these extremes.
        for k in range(n_row if along else n_block):
            row = k * n_block + b if along else b * n_block + k
            boxes[row, axis], boxes[row, 3 + axis] = low, high
    return bits


@scalar
def _axis_rises(values, first, step, n):
    """Whether n values are strictly increasing, and both ends finite."""
    for k in range(1, n):
        if not values[first + k * step] > values[first + (k - 1) * step]:
            return False
    return values[first] > -np.inf and values[first + (n - 1) * step] < np.inf


@scalar
def _axes_rise(p, q, a):
    """Whether easting increases by column only and northing by row only."""
    if a[1] != 0 or a[2] == 0 or a[4] == 0 or a[5] != 0:
        return False
    return _axis_rises(p, a[0], a[2], a[N_COL]) and _axis_rises(q, a[3], a[4], a[N_ROW])


@scalar
def _is_node(p, q, r, a, i, j):
    """Whether a node has three numbers; infinite ones count as missing."""
    x, y, z = load(p, a, 0, i, j), load(q, a, 1, i, j), load(r, a, 2, i, j)
    return abs(x) < np.inf and abs(y) < np.inf and abs(z) < np.inf


@scalar
def _count_triangles(p, q, r, a, block, first, n_cell, marks):
    """Count the triangles of a tile cell by cell."""
    for i in range(block * BLOCK, min(block * BLOCK + BLOCK, a[N_ROW] - 1)):
        for j in range(first, first + n_cell):
            # corners on the diagonal that rises, and on the one that falls
            rising = _is_node(p, q, r, a, i, j) + _is_node(p, q, r, a, i + 1, j + 1)
            falling = _is_node(p, q, r, a, i, j + 1) + _is_node(p, q, r, a, i + 1, j)
            # a diagonal with both its corners has a triangle at each other corner
            marks[N_RISING] += falling if rising == 2 else 0
            marks[N_FALLING] += rising if falling == 2 else 0


@scalar
def _is_far(boxes):
    """Whether one of some boxes is empty or infinite."""
    far = False
    for i in range(boxes.shape[0]):
        for k in range(3):
            # NaN comparisons are false, so NaN counts as infinite.
            lower, upper = boxes[i, k], boxes[i, 3 + k]
            far = far or not (lower > -np.inf and upper < np.inf and lower <= upper)
    return far


@scalar
def _extremes(p, q, r, a, block, first, work, boxes, n_block):
    """Extremes of all coordinates with a number for each node: bits of findings, by axis."""
    bits = 0
    # Coordinates that are equal in all rows or columns are left to `_axes`, once for all tiles.
    if a[1] != 0 and a[2] != 0:
        bits |= _tile_extremes(p, a, 0, block, first, work, boxes, n_block)
    if a[4] != 0 and a[5] != 0:
        bits |= _tile_extremes(q, a, 1, block, first, work, boxes, n_block) << 2
    if a[7] != 0 and a[8] != 0:
        bits |= _tile_extremes(r, a, 2, block, first, work, boxes, n_block) << 4
    return bits


@scalar
def _axes(p, q, r, a, boxes, n_block):
    """The same for coordinates that are equal in all rows or columns."""
    bits = 0
    if a[1] == 0 or a[2] == 0:
        bits |= _axis_extremes(p, a, 0, boxes, n_block)
    if a[4] == 0 or a[5] == 0:
        bits |= _axis_extremes(q, a, 1, boxes, n_block) << 2
    if a[7] == 0 or a[8] == 0:
        bits |= _axis_extremes(r, a, 2, boxes, n_block) << 4
    return bits


@entry("d1 d1 d1 l1 -> d2 l2 l1")
def survey_lattice(p, q, r, a):
    """Boxes of blocks and of all nodes above them, and levels (see `tree`); and `marks`."""
    n_row, n_col = max((a[N_ROW] + BLOCK - 2) // BLOCK, 1), max((a[N_COL] + BLOCK - 2) // BLOCK, 1)
    levels, n_node = levels_of(n_row, n_col, 2, 2)
    nodes = np.empty((n_node, 6), dtype=np.float64)
    boxes = nodes[: n_row * n_col]
    marks = np.zeros(N_MARK, dtype=np.int64)

    work = np.empty(2 * ROW_SIZE)  # scratch rows of a tile
    axes = _axes(p, q, r, a, boxes, n_col)
    # Two bits per axis: a value is not a number; a value is -0.0.
    bits = axes
    for block in range(n_row):
        for first in range(0, n_col * BLOCK, TILE):
            # Extremes and holes first: a tile without holes has all its triangles.
            tile_bits = _extremes(p, q, r, a, block, first, work, boxes, n_col) | axes
            bits |= tile_bits
            n = min(TILE, a[N_COL] - 1 - first)
            start, stop = first // BLOCK, min((first + TILE) // BLOCK, n_col)
            if tile_bits & _NOT_A_NUMBER == 0 and not _is_far(
                boxes[block * n_col + start : block * n_col + stop]
            ):
                n_cell = n * max(min(BLOCK, a[N_ROW] - 1 - block * BLOCK), 0)
                marks[N_RISING] += 2 * n_cell
                marks[N_FALLING] += 2 * n_cell
            else:
                _count_triangles(p, q, r, a, block, first, n, marks)
    # Flags per axis for the caller, who repairs or rejects the coordinates.
    for axis in range(3):
        marks[NOT_A_NUMBER + axis] = (bits >> 2 * axis) & 1
    marks[MINUS_ZERO] = 1 if bits & _MINUS_ZEROS != 0 else 0
    marks[AXES_RISE] = 1 if _axes_rise(p, q, a) else 0
    build_above(nodes, levels, 2, 2)
    return nodes, levels, marks
