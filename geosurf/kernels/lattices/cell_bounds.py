"""What bounds of edges prove about the cells of a tile of a lattice.

Within eight rows, the edges of one column of cells differ little. Their deviation from the middle
bounds all products of two of them. In the plane of two coordinates, e x u of a corner is twice an
area; where it cannot be zero, no corner of that column is degenerate. The gain of one diagonal over
the other is 2 (e_x u_z + e_z u_x) for mean e and u of a cell. The sum of all normals follows from
the boundary (Stokes). With noise as large as cells, the bounds prove nothing.

Notation, in addition to that of `tree` (p, q, r, a) and of `survey` (a b c d, tile)
    e        edges along rows: b - a, c - d
    u        edges across: d - a at column j, c - b at column j + 1
    steps    scratch rows, for each coordinate: extremes of e and u, then middle and half-width of
    each out      scratch rows, for each of two planes: the bounds by column
    totals   rows of sums, by column of a tile, over all tiles: sums along a row are not vectorised
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.lattices.strips import load
from geosurf.kernels.search.tree import BLOCK, N_ROW

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
