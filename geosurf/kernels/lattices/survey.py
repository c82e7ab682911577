"""Properties of a lattice in one pass over its nodes: boxes of blocks, holes, shapes of cells.

Every reader of a grid needs the same facts about all of its nodes: are they numbers, what are the
extremes, which diagonal fits, has each triangle an area, which way does the surface face. Here all
of them cost little more than reading the numbers once: tiles of a few rows stay in the cache, and
loops run over scratch rows, so that they are vectorised.

The shape of the cells of a tile follows from bounds of their edges (`cell_bounds`), or cell by cell
where there are holes, or noise as large as cells. Only certain facts are reported; where floats do
not decide, `geosurf.triangulate` computes exactly.

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

# ---- cell bounds ----------------------------------------
# What bounds of edges prove about the cells of a tile of a lattice.
#
# Within eight rows, the edges of one column of cells differ little. Their deviation from the
# middle bounds all products of two of them. In the plane of two coordinates, e x u of a corner is
# twice an area; where it cannot be zero, no corner of that column is degenerate. The gain of one
# diagonal over the other is 2 (e_x u_z + e_z u_x) for mean e and u of a cell. The sum of all
# normals follows from the boundary (Stokes). With noise as large as cells, the bounds prove
# nothing.
#
# Notation, in addition to that of `tree` (p, q, r, a) and of `survey` (a b c d, tile) e
# edges along rows: b - a, c - d u        edges across: d - a at column j, c - b at column j + 1
# steps    scratch rows, for each coordinate: extremes of e and u, then middle and half-width of
# each out      scratch rows, for each of two planes: the bounds by column totals   rows of sums,
# by column of a tile, over all tiles: sums along a row are not vectorised


TILE = 16 * BLOCK
ROW_SIZE = TILE + 2 * BLOCK
PART = 4 * ROW_SIZE
FIVE = 5  # rows at once; loops over more than eight arrays are not vectorised
# indices into `sums`: over whole cells, differences of the products of diagonals, a to c minus b
# to d (x z and y z), and their errors; normals of both diagonals together (three); an upper bound
# of the squared edges, next to holes those of each triangle; the minimum of |u|^2 |v|^2 - (u v)^2
# over the corners computed one by one; normals of triangles that only one diagonal has (2 x 3)
GAIN, REACH, NORMAL, EDGES, MARGIN, ONLY_RISING, ONLY_FALLING, N_SUM = 0, 2, 4, 7, 8, 9, 12, 15
_ROUNDING = 1e-10  # relative, of products; their errors are below 1e-15
_UNDERFLOW = 1e-290
# indices into `steps` and `out`: distance of corners from degeneracy, gains, errors of gains
_E_LOW, _E_HIGH, _U_LOW, _U_HIGH = 0, 1, 2, 3
_E, _E_REACH, _U, _U_REACH = 0, 1, 2, 3
_OPEN, _GAIN, _REACH = 0, 1, 2
# rows of `totals`: gains and their errors in two planes, then squared edges
_SQUARES, N_TOTAL = 4, 5


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
def _along(one, two, three, four, five, n, steps):
    """Extend the extremes of edges along five rows, by column."""
    for j in range(min(n, TILE)):
        p, q, r = one[j + 1] - one[j], two[j + 1] - two[j], three[j + 1] - three[j]
        s, t = four[j + 1] - four[j], five[j + 1] - five[j]
        low, high = steps[_E_LOW * ROW_SIZE + j], steps[_E_HIGH * ROW_SIZE + j]
        steps[_E_LOW * ROW_SIZE + j] = least(low, p, q, r, s, t)
        steps[_E_HIGH * ROW_SIZE + j] = most(high, p, q, r, s, t)


@scalar
def _across(one, two, three, four, five, n, steps):
    """Extend the extremes of edges from each of five rows to the next, by column."""
    for j in range(min(n, TILE + 1)):
        p, q, r, s = two[j] - one[j], three[j] - two[j], four[j] - three[j], five[j] - four[j]
        low, high = steps[_U_LOW * ROW_SIZE + j], steps[_U_HIGH * ROW_SIZE + j]
        steps[_U_LOW * ROW_SIZE + j] = least(low, p, q, r, s, s)
        steps[_U_HIGH * ROW_SIZE + j] = most(high, p, q, r, s, s)


@scalar
def _steps_of_rows(values, start, step, n, steps):
    """Extend the extremes of edges by those between five rows of n + 1 nodes."""
    one = values[start : start + n + 1]
    two = values[start + step : start + step + n + 1]
    three = values[start + 2 * step : start + 2 * step + n + 1]
    four = values[start + 3 * step : start + 3 * step + n + 1]
    five = values[start + 4 * step : start + 4 * step + n + 1]
    _along(one, two, three, four, five, n, steps)
    _across(one, two, three, four, five, n + 1, steps)


@scalar
def _steps_of_tile(values, a, axis, block, first, n, rows, steps):
    """Extremes of one coordinate of all edges of the cells of a tile, by column.

    In the last row of blocks, edges of earlier rows may be among them.
    """
    for k in range(0, 4, 2):
        fill(steps, k, k + 1, np.inf)
        fill(steps, k + 1, k + 2, -np.inf)

    # Near the last row, the groups begin earlier, so that each has five rows.
    # Two groups of five rows cover the nine rows of nodes of a block.
    step = a[3 * axis + 1]
    start = a[3 * axis] + first * a[3 * axis + 2]
    for part in range(2):
        begin = start + min(block * BLOCK + 4 * part, a[N_ROW] - FIVE) * step
        if a[3 * axis + 2] == 1:
            _steps_of_rows(values, begin, step, n, steps)
        else:  # all columns are equal: make rows of one value
            for k in range(FIVE):
                fill(rows, k, k + 1, values[begin + k * step])
            _steps_of_rows(rows, 0, ROW_SIZE, n, steps)

    # Middle and half-width of e; of u over both sides of a cell.
    for j in range(min(n, TILE)):
        low, high = steps[_E_LOW * ROW_SIZE + j], steps[_E_HIGH * ROW_SIZE + j]
        steps[_E * ROW_SIZE + j] = 0.5 * low + 0.5 * high
        steps[_E_REACH * ROW_SIZE + j] = 0.5 * high - 0.5 * low
    for j in range(min(n, TILE)):
        low, other = steps[_U_LOW * ROW_SIZE + j], steps[_U_LOW * ROW_SIZE + j + 1]
        low = other if other < low else low
        high, other = steps[_U_HIGH * ROW_SIZE + j], steps[_U_HIGH * ROW_SIZE + j + 1]
        high = other if other > high else high
        steps[_U * ROW_SIZE + j] = 0.5 * low + 0.5 * high
        steps[_U_REACH * ROW_SIZE + j] = 0.5 * high - 0.5 * low


@scalar
def _bound_cells(p, q, n, out):
    """Bounds for the cells of each column from two coordinates of edges.

    The difference of the products of e and u is twice the area of a corner. Their sum is half of
    the difference between the products of both diagonals.
    """
    for j in range(min(n, TILE)):
        # First product, and the largest deviation of any cell from it.
        a, b = p[_E * ROW_SIZE + j], q[_U * ROW_SIZE + j]
        one, far, wide = a * b, abs(a), q[_U_REACH * ROW_SIZE + j]
        reach = far * wide + p[_E_REACH * ROW_SIZE + j] * (abs(b) + wide)
        a, b = q[_E * ROW_SIZE + j], p[_U * ROW_SIZE + j]
        two, far, wide = a * b, abs(a), p[_U_REACH * ROW_SIZE + j]
        reach += far * wide + q[_E_REACH * ROW_SIZE + j] * (abs(b) + wide)

        # Certainly not degenerate where the difference exceeds all deviations.
        turn = abs(one - two) - reach - _ROUNDING * (abs(one) + abs(two) + reach)
        least = out[_OPEN * ROW_SIZE + j]
        out[_OPEN * ROW_SIZE + j] = turn if turn > least else least
        out[_GAIN * ROW_SIZE + j] = one + two
        out[_REACH * ROW_SIZE + j] = reach


@scalar
def _add_gains(out, n, weight, row, totals):
    """Add the gains of a tile in one of two planes, and their errors, by column."""
    for j in range(min(n, TILE)):
        totals[row * ROW_SIZE + j] += weight * out[_GAIN * ROW_SIZE + j]
        totals[(row + 1) * ROW_SIZE + j] += weight * out[_REACH * ROW_SIZE + j]


@scalar
def _add_squares(steps, n, weight, totals):
    """Add the squares of the longest e and u of each column."""
    for j in range(min(n, TILE)):
        e = abs(steps[_E * ROW_SIZE + j]) + steps[_E_REACH * ROW_SIZE + j]
        u = abs(steps[_U * ROW_SIZE + j]) + steps[_U_REACH * ROW_SIZE + j]
        totals[_SQUARES * ROW_SIZE + j] += weight * (e * e + u * u)


@scalar
def add_totals(totals, sums):
    """Add the sums by column to `sums`."""
    for j in range(TILE):
        for k in range(2):
            sums[GAIN + k] += totals[2 * k * ROW_SIZE + j]
            sums[REACH + k] += totals[(2 * k + 1) * ROW_SIZE + j]
        sums[EDGES] += totals[_SQUARES * ROW_SIZE + j]


@scalar
def _all_open(out, n):
    """Whether the bounds prove that no corner of a cell is degenerate."""
    n_open = 0
    for j in range(min(n, TILE)):  # a count becomes vector code, the least of all does not
        n_open += 1 if out[_OPEN * ROW_SIZE + j] > _UNDERFLOW else 0
    return n_open == n


@scalar
def bound_tile(p, q, r, a, block, first, n, rows, steps, out, totals):
    """Add the cells of a tile without holes, if bounds prove that none of their corners is
    degenerate.

    Normals are left to the boundary.
    """
    if a[N_ROW] < FIVE:
        return False

    # Bounds of all edges of the tile.
    one, two, three = steps[:PART], steps[PART : 2 * PART], steps[2 * PART :]
    _steps_of_tile(p, a, 0, block, first, n, rows, one)
    _steps_of_tile(q, a, 1, block, first, n, rows, two)
    _steps_of_tile(r, a, 2, block, first, n, rows, three)

    # Degeneracy in the xz, yz planes; in xy only where these do not decide.
    xz, yz = out[:PART], out[PART:]
    fill(xz, _OPEN, _OPEN + 1, 0.0)
    _bound_cells(one, three, n, xz)
    for j in range(ROW_SIZE):
        yz[j] = xz[j]
    _bound_cells(two, three, n, yz)

    # The xy plane decides where cells are vertical, or nearly so. It borrows the scratch rows of
    # yz, whose gains are then computed again.
    if not _all_open(yz, n):
        _bound_cells(one, two, n, yz)
        if not _all_open(yz, n):
            return False
        _bound_cells(two, three, n, yz)

    # The sums count both triangles of each row.
    weight = 2.0 * min(BLOCK, a[N_ROW] - 1 - block * BLOCK)
    _add_gains(xz, n, weight, 0, totals)
    _add_gains(yz, n, weight, 2, totals)
    _add_squares(one, n, weight, totals)
    _add_squares(two, n, weight, totals)
    _add_squares(three, n, weight, totals)
    return True


@scalar
def add_boundary_normals(p, q, r, a, first, last, left, right, sums):
    """Add twice the vector area of some cells, rows first to last, columns left to right.

    By Stokes' theorem the sum of all their normals is that of the fan from one corner to the
    boundary.
    """
    x, y, z = load(p, a, 0, first, left), load(q, a, 1, first, left), load(r, a, 2, first, left)
    ux, uy, uz = 0.0, 0.0, 0.0

    # Walk around the cells counter-clockwise; each step spans a triangle with the first corner.
    i, j, up, on = first, left, 0, 1
    for _ in range(2 * (last - first + right - left)):
        # Turn at each corner of the rectangle.
        if on == 1 and j == right:
            up, on = 1, 0
        elif up == 1 and i == last:
            up, on = 0, -1
        elif on == -1 and j == left:
            up, on = -1, 0
        i, j = i + up, j + on
        vx, vy, vz = load(p, a, 0, i, j) - x, load(q, a, 1, i, j) - y, load(r, a, 2, i, j) - z
        sums[NORMAL] += uy * vz - uz * vy
        sums[NORMAL + 1] += uz * vx - ux * vz
        sums[NORMAL + 2] += ux * vy - uy * vx
        ux, uy, uz = vx, vy, vz


# indices into `marks`: triangles with either diagonal; 1 if a coordinate (three of them) is not a
# number, if one is -0.0, or if easting and northing are increasing axes
N_RISING, N_FALLING, NOT_A_NUMBER, MINUS_ZERO, AXES_RISE, N_MARK = 0, 1, 2, 5, 6, 7
# two bits for each coordinate
_NOT_A_NUMBER, _MINUS_ZEROS = 0b010101, 0b101010
_NEARLY = 1.0 - 1e-10  # a corner of 1e-5 radians or less is left to exact arithmetic
# scratch rows: extremes of nodes by column
_LOW, _HIGH = 0, 1


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
    one = values[start : start + n]
    # Rows beyond the last one repeat it: extremes stay the same.
    two = values[start + min(1, last) * step : start + min(1, last) * step + n]
    three = values[start + min(2, last) * step : start + min(2, last) * step + n]
    four = values[start + min(3, last) * step : start + min(3, last) * step + n]
    five = values[start + last * step : start + last * step + n]
    n_nan = 0
    for j in range(min(n, ROW_SIZE)):  # selections without branches are vectorised
        p, q, r, s, t = one[j], two[j], three[j], four[j], five[j]
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
    found = 1 if n_nan > 0 else 0
    n = min(TILE + 1, a[N_COL] - first)
    if lowest <= 0.0 <= highest and _has_minus_zero(values, a, axis, block, first, n):
        found += 2
    return found


@scalar
def _axis_extremes(values, a, axis, boxes, n_block):
    """The same in all blocks, of a coordinate that is equal in all rows or in all columns."""
    # A coordinate along columns or along rows.
    along = a[3 * axis + 1] == 0
    n = a[N_COL] if along else a[N_ROW]
    step = a[3 * axis + 2] if along else a[3 * axis + 1]
    n_row = boxes.shape[0] // n_block
    found = 0
    for b in range(n_block if along else n_row):
        low, high = np.inf, -np.inf
        for k in range(b * BLOCK, min(b * BLOCK + BLOCK + 1, n)):
            value = values[a[3 * axis] + k * step]
            low = value if value < low else low
            high = value if value > high else high
            found |= (1 if value != value else 0) | (2 if _is_minus_zero(value) else 0)
        # All blocks of that column, or row, of blocks have these extremes.
        for k in range(n_row if along else n_block):
            row = k * n_block + b if along else b * n_block + k
            boxes[row, axis], boxes[row, 3 + axis] = low, high
    return found


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
def _add_corner(c, one, two, three, sums):
    """Squared edges and margin of the corner at `two`; half the normal of the triangle there."""
    ax, ay, az = c[two, 0] - c[one, 0], c[two, 1] - c[one, 1], c[two, 2] - c[one, 2]
    bx, by, bz = c[three, 0] - c[two, 0], c[three, 1] - c[two, 1], c[three, 2] - c[two, 2]

    # Squared lengths and the squared area: the margin from degeneracy.
    aa, bb = ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz
    ab = ax * bx + ay * by + az * bz
    sums[EDGES] += aa + bb
    sums[MARGIN] = min(sums[MARGIN], _NEARLY * aa * bb - ab * ab)
    return 0.5 * (ay * bz - az * by), 0.5 * (az * bx - ax * bz), 0.5 * (ax * by - ay * bx)


@scalar
def _add_cell(c, missing, sums):
    """Add one cell: whole (missing is -1), or with one corner missing."""
    # Without a or c the three others form the triangle at the diagonal b-d, which falls; without b
    # or d, the one at a-c.
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

    # Gain of one diagonal over the other.
    sz, tz = c[2, 2] - c[0, 2], c[3, 2] - c[1, 2]
    sums[GAIN] += (c[2, 0] - c[0, 0]) * sz - (c[3, 0] - c[1, 0]) * tz
    sums[GAIN + 1] += (c[2, 1] - c[0, 1]) * sz - (c[3, 1] - c[1, 1]) * tz


@scalar
def _load_cell(values, a, axis, i, j, c):
    # Strides of a step to the next row and to the next column.
    up, on = a[3 * axis + 1], a[3 * axis + 2]
    at = a[3 * axis] + i * up + j * on
    c[0, axis] = values[at]
    c[1, axis] = values[at + on]
    c[2, axis] = values[at + up + on]
    c[3, axis] = values[at + up]


@scalar
def _add_cells(p, q, r, a, block, first, n_cell, quads, c, marks, sums):
    """Count the triangles of a tile one by one, and add its cells."""
    for i in range(block * BLOCK, min(block * BLOCK + BLOCK, a[N_ROW] - 1)):
        for j in range(first, first + n_cell):
            _load_cell(p, a, 0, i, j, c)
            _load_cell(q, a, 1, i, j, c)
            _load_cell(r, a, 2, i, j, c)

            # Cells with two or more missing corners have no triangle.
            missing = -1
            n = 0
            # A corner is missing if any of its coordinates is; infinite ones count as missing.
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


@scalar
def _add_boundaries(p, q, r, a, clear, sums):
    """Add the normals of bounded tiles: around all of them if all are, else around each."""
    # One walk around the lattice instead of one around every tile.
    if clear.all():
        add_boundary_normals(p, q, r, a, 0, a[N_ROW] - 1, 0, a[N_COL] - 1, sums)
        return
    for block in range(clear.shape[0]):
        for tile in range(clear.shape[1]):
            if clear[block, tile]:
                i, j = block * BLOCK, tile * TILE
                last, right = min(i + BLOCK, a[N_ROW] - 1), min(j + TILE, a[N_COL] - 1)
                add_boundary_normals(p, q, r, a, i, last, j, right, sums)


@entry("d1 d1 d1 l1 b -> d2 l2 l1 d1")
def survey_lattice(p, q, r, a, quads):
    """Boxes of blocks and of all nodes above them, and levels (see `tree`); `marks`; and `sums`, if
    `quads` asks for them.
    """
    n_row, n_col = max((a[N_ROW] + BLOCK - 2) // BLOCK, 1), max((a[N_COL] + BLOCK - 2) // BLOCK, 1)
    levels, n_node = levels_of(n_row, n_col, 2, 2)
    nodes = np.empty((n_node, 6), dtype=np.float64)
    boxes = nodes[: n_row * n_col]
    marks = np.zeros(N_MARK, dtype=np.int64)
    sums = np.zeros(N_SUM, dtype=np.float64)
    # A minimum over all corners starts at infinity.
    sums[MARGIN] = np.inf

    # Scratch rows of a tile.
    work, rows = np.empty(2 * ROW_SIZE), np.empty(FIVE * ROW_SIZE)
    steps, out, c = np.empty(3 * PART), np.empty(2 * PART), np.empty((4, 3))
    totals = np.zeros(N_TOTAL * ROW_SIZE)
    clear = np.zeros((n_row, (n_col * BLOCK + TILE - 1) // TILE), dtype=np.bool_)
    axes = _axes(p, q, r, a, boxes, n_col)
    # Two bits per axis: a value is not a number; a value is -0.0.
    bits = axes
    for block in range(n_row):
        for first in range(0, n_col * BLOCK, TILE):
            # Extremes and holes first; only complete tiles can be bounded.
            found = _extremes(p, q, r, a, block, first, work, boxes, n_col) | axes
            bits |= found
            n = min(TILE, a[N_COL] - 1 - first)
            n_cell = n * max(min(BLOCK, a[N_ROW] - 1 - block * BLOCK), 0)
            start, stop = first // BLOCK, min((first + TILE) // BLOCK, n_col)
            whole = found & _NOT_A_NUMBER == 0 and not _is_far(
                boxes[block * n_col + start : block * n_col + stop]
            )
            if whole and quads and n_cell > 0:
                whole = bound_tile(p, q, r, a, block, first, n, rows, steps, out, totals)
                clear[block, first // TILE] = whole

            # A bounded tile counts all triangles; otherwise cell by cell.
            if whole:
                marks[N_RISING] += 2 * n_cell
                marks[N_FALLING] += 2 * n_cell
            else:
                _add_cells(p, q, r, a, block, first, n, quads, c, marks, sums)
    if quads:
        add_totals(totals, sums)
        _add_boundaries(p, q, r, a, clear, sums)
    # Flags per axis for the caller, who repairs or rejects the coordinates.
    for axis in range(3):
        marks[NOT_A_NUMBER + axis] = (bits >> 2 * axis) & 1
    marks[MINUS_ZERO] = 1 if bits & _MINUS_ZEROS != 0 else 0
    marks[AXES_RISE] = 1 if _axes_rise(p, q, a) else 0
    build_above(nodes, levels, 2, 2)
    return nodes, levels, marks, sums
