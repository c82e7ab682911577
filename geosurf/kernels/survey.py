"""What a lattice is like, in one pass over its nodes: boxes of blocks, holes, how cells lie.

Whoever reads a grid asks the same few things of all of its nodes: are they numbers, how far do they
reach, which diagonal fits, has each triangle an area, which way does the surface face. Here all
of that costs little more than reading the numbers once: blocks of rows stay in the cache
while they are asked, and loops run over scratch rows, so that they become vector code.

Sums over cells decide only what is clear from them; where it is not, `geosurf.triangulate` asks
exactly.

Notation, beside that of `tree` (p, q, r, a)
    a b c d  corners of a cell, counter-clockwise: (i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)
    e g      lower and upper edge of a cell: b - a, c - d
    u        edges across: d - a at column j, c - b at column j + 1
    tile     TILE columns of one row of blocks
    work     scratch rows of ROW_SIZE numbers, one after the other
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels._jit import entry, scalar
from geosurf.kernels.tree import BLOCK, N_COL, N_ROW, _build_above, _levels

TILE = 32 * BLOCK
ROW_SIZE = TILE + BLOCK
N_SCRATCH = 25
# places in `marks`: triangles with either diagonal; 1 where one is not a number, or -0.0
N_RISING, N_FALLING, NAN_X, NAN_Y, NAN_Z, MINUS_ZERO, N_MARK = 0, 1, 2, 3, 4, 5, 6
# places in `sums`: over whole cells, differences of the products of diagonals, a to c less b to d
# (x z and y z); normals of both diagonals together (three); squared edges, beside holes those of
# each triangle; the least of
# |u|^2 |v|^2 - (u v)^2 over all corners; normals of triangles that only one diagonal has (2 x 3)
GAIN_XZ, GAIN_YZ, NORMAL, EDGES, MARGIN, ONLY_RISING, ONLY_FALLING, N_SUM = 0, 1, 2, 5, 6, 7, 10, 13
_NEARLY = 1.0 - 1e-10  # a corner of 1e-5 radians or less is left to exact arithmetic
# scratch rows: nodes of the row below and above; e, g and u, each with its square; sums by column
_BELOW, _ABOVE, _E, _G, _U, _SUMS = 0, 3, 6, 10, 14, 18


@scalar
def _rows_extremes(values, start, step, n, low, high):
    """Widen extremes by column with three rows; how many columns have what is not a number."""
    one = values[start : start + n]
    two = values[start + step : start + step + n]
    three = values[start + 2 * step : start + 2 * step + n]
    n_nan = 0
    for j in range(n):  # plain selections: they become vector code
        least, most = low[j], high[j]
        least = one[j] if one[j] < least else least
        most = one[j] if one[j] > most else most
        least = two[j] if two[j] < least else least
        most = two[j] if two[j] > most else most
        least = three[j] if three[j] < least else least
        most = three[j] if three[j] > most else most
        low[j], high[j] = least, most
        total = one[j] + two[j] + three[j]  # of infinite ones, too, but boxes tell those
        n_nan += 1 if total != total else 0
    return n_nan


@scalar
def _has_minus_zero(values, a, axis, block, first, n):
    """Whether -0.0 is among the values of a tile."""
    last = min(block * BLOCK + BLOCK, a[N_ROW] - 1) if a[3 * axis + 1] > 0 else block * BLOCK
    for i in range(block * BLOCK, last + 1):
        for j in range(first, first + (n if a[3 * axis + 2] > 0 else 1)):
            value = values[a[3 * axis] + i * a[3 * axis + 1] + j * a[3 * axis + 2]]
            if value == 0.0 and math.copysign(1.0, value) < 0.0:
                return True
    return False


@scalar
def _tile_extremes(values, a, axis, block, first, n, low, high, boxes, n_block):
    """Extremes of one coordinate in the blocks of a tile of n columns.

    Returns 1 if there is something that is not a number, plus 2 if there is a -0.0.
    """
    row_step, col_step = a[3 * axis + 1], a[3 * axis + 2]
    low[:] = np.inf
    high[:] = -np.inf
    n_nan = 0
    # all rows are alike, or all columns
    n_row = 1 if row_step == 0 else min(BLOCK, a[N_ROW] - 1 - block * BLOCK) + 1
    n_col = n if col_step == 1 else 1
    start = a[3 * axis] + block * BLOCK * row_step + first * col_step
    for i in range(0, n_row, 3):
        step = row_step if i + 3 <= n_row else 0
        n_nan += _rows_extremes(values, start + i * row_step, step, n_col, low, high)
        if step == 0 and i + 2 == n_row:
            n_nan += _rows_extremes(values, start + (i + 1) * row_step, 0, n_col, low, high)
    if col_step == 0:
        low[1:] = low[0]
        high[1:] = high[0]
    lowest, highest = np.inf, -np.inf
    for b in range(first // BLOCK, min((first + TILE) // BLOCK, n_block)):
        lower, upper = np.inf, -np.inf
        for j in range(b * BLOCK - first, min(b * BLOCK - first + BLOCK + 1, n)):
            lower = low[j] if low[j] < lower else lower
            upper = high[j] if high[j] > upper else upper
        boxes[block * n_block + b, axis] = lower
        boxes[block * n_block + b, 3 + axis] = upper
        lowest, highest = min(lowest, lower), max(highest, upper)
    found = 1 if n_nan > 0 else 0
    if lowest <= 0.0 <= highest and _has_minus_zero(values, a, axis, block, first, n):
        found += 2
    return found


@scalar
def _load_row(values, a, axis, i, first, n, work, slot):
    """One coordinate of n nodes of a row into a scratch row."""
    start = a[3 * axis] + i * a[3 * axis + 1] + first * a[3 * axis + 2]
    target = work[slot * ROW_SIZE : slot * ROW_SIZE + n]
    source = values[start : start + (n - 1) * a[3 * axis + 2] + 1]
    if a[3 * axis + 2] == 1:
        for j in range(n):
            target[j] = source[j]
    else:
        target[:] = source[0]


@scalar
def _across(work, n_node):
    """Edges from the row below to the row above, which is then the row below."""
    for j in range(min(n_node, TILE + 1)):
        x = work[_ABOVE * ROW_SIZE + j]
        y = work[(_ABOVE + 1) * ROW_SIZE + j]
        z = work[(_ABOVE + 2) * ROW_SIZE + j]
        ux = x - work[_BELOW * ROW_SIZE + j]
        uy = y - work[(_BELOW + 1) * ROW_SIZE + j]
        uz = z - work[(_BELOW + 2) * ROW_SIZE + j]
        work[_U * ROW_SIZE + j] = ux
        work[(_U + 1) * ROW_SIZE + j] = uy
        work[(_U + 2) * ROW_SIZE + j] = uz
        work[(_U + 3) * ROW_SIZE + j] = ux * ux + uy * uy + uz * uz
        work[_BELOW * ROW_SIZE + j] = x
        work[(_BELOW + 1) * ROW_SIZE + j] = y
        work[(_BELOW + 2) * ROW_SIZE + j] = z


@scalar
def _along(work, n_cell):
    """Edges along the row that was loaded last."""
    for j in range(min(n_cell, TILE)):
        gx = work[_BELOW * ROW_SIZE + j + 1] - work[_BELOW * ROW_SIZE + j]
        gy = work[(_BELOW + 1) * ROW_SIZE + j + 1] - work[(_BELOW + 1) * ROW_SIZE + j]
        gz = work[(_BELOW + 2) * ROW_SIZE + j + 1] - work[(_BELOW + 2) * ROW_SIZE + j]
        work[_G * ROW_SIZE + j] = gx
        work[(_G + 1) * ROW_SIZE + j] = gy
        work[(_G + 2) * ROW_SIZE + j] = gz
        work[(_G + 3) * ROW_SIZE + j] = gx * gx + gy * gy + gz * gz


@scalar
def _add_cells(work, n_cell):
    """Add a row of cells to the sums by column; its upper edges become the lower ones."""
    for j in range(min(n_cell, TILE)):
        ex, ey = work[_E * ROW_SIZE + j], work[(_E + 1) * ROW_SIZE + j]
        ez, ee = work[(_E + 2) * ROW_SIZE + j], work[(_E + 3) * ROW_SIZE + j]
        gx, gy = work[_G * ROW_SIZE + j], work[(_G + 1) * ROW_SIZE + j]
        gz, gg = work[(_G + 2) * ROW_SIZE + j], work[(_G + 3) * ROW_SIZE + j]
        ux, uy = work[_U * ROW_SIZE + j], work[(_U + 1) * ROW_SIZE + j]
        uz, uu = work[(_U + 2) * ROW_SIZE + j], work[(_U + 3) * ROW_SIZE + j]
        vx, vy = work[_U * ROW_SIZE + j + 1], work[(_U + 1) * ROW_SIZE + j + 1]
        vz, vv = work[(_U + 2) * ROW_SIZE + j + 1], work[(_U + 3) * ROW_SIZE + j + 1]
        sx, sy, sz = ex + vx, ey + vy, ez + vz  # diagonal a to c
        tx, ty, tz = ux - ex, uy - ey, uz - ez  # diagonal b to d
        work[_SUMS * ROW_SIZE + j] += sx * sz - tx * tz
        work[(_SUMS + 1) * ROW_SIZE + j] += sy * sz - ty * tz
        work[(_SUMS + 2) * ROW_SIZE + j] += sy * tz - sz * ty
        work[(_SUMS + 3) * ROW_SIZE + j] += sz * tx - sx * tz
        work[(_SUMS + 4) * ROW_SIZE + j] += sx * ty - sy * tx
        work[(_SUMS + 5) * ROW_SIZE + j] += (ee + gg) + (uu + vv)
        eu, ev = ex * ux + ey * uy + ez * uz, ex * vx + ey * vy + ez * vz
        gu, gv = gx * ux + gy * uy + gz * uz, gx * vx + gy * vy + gz * vz
        f, h = _NEARLY * ee, _NEARLY * gg
        one, two = f * uu - eu * eu, f * vv - ev * ev
        three, four = h * uu - gu * gu, h * vv - gv * gv
        one = one if one < two else two
        three = three if three < four else four
        one = one if one < three else three
        least = work[(_SUMS + 6) * ROW_SIZE + j]
        work[(_SUMS + 6) * ROW_SIZE + j] = one if one < least else least
        work[_E * ROW_SIZE + j], work[(_E + 1) * ROW_SIZE + j] = gx, gy
        work[(_E + 2) * ROW_SIZE + j], work[(_E + 3) * ROW_SIZE + j] = gz, gg


@scalar
def _whole_tile(p, q, r, a, block, first, n_cell, work, sums):
    """Add the cells of a tile that has no hole."""
    for k in range(_SUMS, N_SCRATCH):
        work[k * ROW_SIZE : (k + 1) * ROW_SIZE] = np.inf if k == _SUMS + MARGIN else 0.0
    for i in range(block * BLOCK, min(block * BLOCK + BLOCK, a[N_ROW] - 1) + 1):
        _load_row(p, a, 0, i, first, n_cell + 1, work, _ABOVE)
        _load_row(q, a, 1, i, first, n_cell + 1, work, _ABOVE + 1)
        _load_row(r, a, 2, i, first, n_cell + 1, work, _ABOVE + 2)
        _across(work, n_cell + 1)
        _along(work, n_cell)
        if i > block * BLOCK:
            _add_cells(work, n_cell)
        else:
            for j in range(4 * ROW_SIZE):
                work[_E * ROW_SIZE + j] = work[_G * ROW_SIZE + j]
    for j in range(n_cell):
        for k in range(MARGIN):
            sums[k] += work[(_SUMS + k) * ROW_SIZE + j]
        sums[MARGIN] = min(sums[MARGIN], work[(_SUMS + MARGIN) * ROW_SIZE + j])


@scalar
def _add_corner(c, one, two, three, sums):
    """Squared edges and margin of the corner at `two`; half the normal of the triangle there."""
    ax, ay, az = c[two, 0] - c[one, 0], c[two, 1] - c[one, 1], c[two, 2] - c[one, 2]
    bx, by, bz = c[three, 0] - c[two, 0], c[three, 1] - c[two, 1], c[three, 2] - c[two, 2]
    aa, bb = ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz
    ab = ax * bx + ay * by + az * bz
    sums[EDGES] += aa + bb
    sums[MARGIN] = min(sums[MARGIN], _NEARLY * aa * bb - ab * ab)
    return 0.5 * (ay * bz - az * by), 0.5 * (az * bx - ax * bz), 0.5 * (ax * by - ay * bx)


@scalar
def _add_cell(c, missing, sums):
    """Add one cell: whole (missing is -1), or with one corner missing."""
    if missing >= 0:
        nx, ny, nz = _add_corner(c, (missing + 1) % 4, (missing + 2) % 4, (missing + 3) % 4, sums)
        place = ONLY_FALLING if missing % 2 == 0 else ONLY_RISING
        sums[place] += nx
        sums[place + 1] += ny
        sums[place + 2] += nz
        return
    for k in range(4):
        nx, ny, nz = _add_corner(c, k, (k + 1) % 4, (k + 2) % 4, sums)
        sums[NORMAL] += nx
        sums[NORMAL + 1] += ny
        sums[NORMAL + 2] += nz
    sz, tz = c[2, 2] - c[0, 2], c[3, 2] - c[1, 2]
    sums[GAIN_XZ] += (c[2, 0] - c[0, 0]) * sz - (c[3, 0] - c[1, 0]) * tz
    sums[GAIN_YZ] += (c[2, 1] - c[0, 1]) * sz - (c[3, 1] - c[1, 1]) * tz


@scalar
def _load_cell(values, a, axis, i, j, c):
    up, on = a[3 * axis + 1], a[3 * axis + 2]
    at = a[3 * axis] + i * up + j * on
    c[0, axis] = values[at]
    c[1, axis] = values[at + on]
    c[2, axis] = values[at + up + on]
    c[3, axis] = values[at + up]


@scalar
def _torn_tile(p, q, r, a, block, first, n_cell, quads, c, marks, sums):
    """Count the triangles of a tile with holes, and add its cells."""
    for i in range(block * BLOCK, min(block * BLOCK + BLOCK, a[N_ROW] - 1)):
        for j in range(first, first + n_cell):
            _load_cell(p, a, 0, i, j, c)
            _load_cell(q, a, 1, i, j, c)
            _load_cell(r, a, 2, i, j, c)
            missing = -1
            n = 0
            for k in range(4):
                if not (abs(c[k, 0]) < np.inf and abs(c[k, 1]) < np.inf and abs(c[k, 2]) < np.inf):
                    missing = k
                    n += 1
            if n > 1:
                continue
            if n == 0:
                marks[N_RISING] += 2
                marks[N_FALLING] += 2
            elif missing % 2 == 0:
                marks[N_FALLING] += 1
            else:
                marks[N_RISING] += 1
            if quads:
                _add_cell(c, missing, sums)


@scalar
def _widen(box, boxes):
    """Widen a box; whether one of those that are new to it is empty or has no end."""
    far = False
    for i in range(boxes.shape[0]):
        for k in range(3):
            lower, upper = boxes[i, k], boxes[i, 3 + k]
            box[k] = lower if lower < box[k] else box[k]
            box[3 + k] = upper if upper > box[3 + k] else box[3 + k]
            far = far or not (lower > -np.inf and upper < np.inf and lower <= upper)
    return far


@entry("d1 d1 d1 l1 b -> d2 d1 l1 d1")
def survey_lattice(p, q, r, a, quads):
    """Boxes of all blocks, row by row; that of all; `marks`; and `sums`, if they are asked for."""
    n_row, n_col = max((a[N_ROW] + BLOCK - 2) // BLOCK, 1), max((a[N_COL] + BLOCK - 2) // BLOCK, 1)
    boxes = np.empty((n_row * n_col, 6), dtype=np.float64)
    box = np.array([np.inf, np.inf, np.inf, -np.inf, -np.inf, -np.inf])
    marks = np.zeros(N_MARK, dtype=np.int64)
    sums = np.zeros(N_SUM, dtype=np.float64)
    sums[MARGIN] = np.inf
    low = np.empty(TILE + 1)
    high = np.empty(TILE + 1)
    work = np.zeros(N_SCRATCH * ROW_SIZE)
    c = np.empty((4, 3))
    for block in range(n_row):
        for first in range(0, n_col * BLOCK, TILE):
            n = min(TILE + 1, a[N_COL] - first)
            found = _tile_extremes(p, a, 0, block, first, n, low, high, boxes, n_col)
            also = _tile_extremes(q, a, 1, block, first, n, low, high, boxes, n_col)
            last = _tile_extremes(r, a, 2, block, first, n, low, high, boxes, n_col)
            marks[NAN_X] |= found & 1
            marks[NAN_Y] |= also & 1
            marks[NAN_Z] |= last & 1
            marks[MINUS_ZERO] |= (found | also | last) >> 1
            start, stop = first // BLOCK, min((first + TILE) // BLOCK, n_col)
            far = _widen(box, boxes[block * n_col + start : block * n_col + stop])
            if ((found | also | last) & 1) == 1 or far:
                _torn_tile(p, q, r, a, block, first, n - 1, quads, c, marks, sums)
                continue
            n_cell = (n - 1) * max(min(BLOCK, a[N_ROW] - 1 - block * BLOCK), 0)
            marks[N_RISING] += 2 * n_cell
            marks[N_FALLING] += 2 * n_cell
            if quads and n_cell > 0:
                _whole_tile(p, q, r, a, block, first, n - 1, work, sums)
    return boxes, box, marks, sums


@entry("d2 l l l l l -> d2 l2")
def build_tree_of_blocks(boxes, n_block, first_row, last_row, first_col, last_col):
    """Boxes of all tree nodes over some rows and columns of blocks, and the levels: see `tree`."""
    levels, n_node = _levels(last_row - first_row, last_col - first_col, 2, 2)
    nodes = np.empty((n_node, 6), dtype=np.float64)
    n_col = last_col - first_col
    for i in range(last_row - first_row):
        start = (first_row + i) * n_block + first_col
        nodes[i * n_col : (i + 1) * n_col] = boxes[start : start + n_col]
    _build_above(nodes, levels, 2, 2)
    return nodes, levels
