"""Where a grid with straight axes meets another grid: pairs of triangles, decided where floats can.

In the map, the cells of a grid with increasing axes are found directly. So each cell of the other
grid is compared only with the cells below or above it, a patch at its own height. Whole parts of
its pyramid (`tree`) are skipped that lie above or below those of the first grid. Which triangles
of the patch meet those of the cell follows from the sides of nodes (`column_pairs`,
`cell_contacts`).

Notation, in addition to that of `tree` and `cell_contacts`: side A has the axes, side B any
coordinates
    box  float64 (6,): of a block, then of a cell of B
    at   cells of A below or above a cell of B, int64 (4,): first and last (one more) row, column
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.contacts.cell_contacts import (
    N_TERM,
    NEEDS_EXACT,
    AxisGrid,
    CellQuery,
    Work,
    contact_codes,
    corners_of_cell,
    pairs_in_columns,
)
from geosurf.kernels.search.tree import BLOCK, N_COL, N_ROW, low_high

__all__ = ["NEEDS_EXACT", "axis_grid_pairs"]

_FINE = 7  # nodes of a pyramid in a row, minus one, that are read for a block


@scalar
def _heights_over(nodes, levels, r0, r1, c0, c1, most):
    """Lowest and highest node over a rectangle of cells, from few nodes of a pyramid.

    At most `most` + 1 nodes per row and column are read.
    """
    # Blocks of the pyramid's lowest level that hold the rectangle.
    r0, r1, c0, c1 = r0 // BLOCK, (r1 - 1) // BLOCK, c0 // BLOCK, (c1 - 1) // BLOCK
    level = 0

    # Go up until the rectangle covers few nodes.
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
def _column_extremes(values, a, axis, first, last, j, ends):
    """Lowest and highest number of column j, rows first to last; inf, -inf if none."""
    low, high = np.inf, -np.inf
    for i in range(first, last + 1):
        value = values[a[3 * axis] + i * a[3 * axis + 1] + j * a[3 * axis + 2]]

        # Comparisons with NaN are false, so holes are skipped.
        low = value if value < low else low
        high = value if value > high else high
    ends[axis], ends[3 + axis] = low, high


@scalar
def _column_box(p, q, r, a, first, last, j, ends):
    """Box around the nodes of column j, rows first to last."""
    _column_extremes(p, a, 0, first, last, j, ends)
    _column_extremes(q, a, 1, first, last, j, ends)
    _column_extremes(r, a, 2, first, last, j, ends)


@scalar
def _hull(one, two, box):
    """The common box of two boxes."""
    for k in range(3):
        box[k], box[3 + k] = min(one[k], two[k]), max(one[3 + k], two[3 + k])


@scalar
def _cell_box(values, a, axis, i, j, box):
    up, on = a[3 * axis + 1], a[3 * axis + 2]
    low, high = low_high(values, a[3 * axis] + i * up + j * on, up, on)
    box[axis], box[3 + axis] = low, high


@scalar
def _load_axis(values, a, axis, i, j, origin, c):
    """One coordinate of the four corners of a cell, counter-clockwise, in the local frame."""
    # Strides of rows and columns of this coordinate.
    up, on = a[3 * axis + 1], a[3 * axis + 2]
    at = a[3 * axis] + i * up + j * on
    c[4, axis] = values[at] - origin
    c[5, axis] = values[at + on] - origin
    c[6, axis] = values[at + up + on] - origin
    c[7, axis] = values[at + up] - origin


@scalar
def _load_cell(p, q, r, a, i, j, origin, c):
    """Corners of a cell of B into the last four rows of c."""
    _load_axis(p, a, 0, i, j, origin[0], c)
    _load_axis(q, a, 1, i, j, origin[1], c)
    _load_axis(r, a, 2, i, j, origin[2], c)


@scalar
def _set_reach(x, y, at, floor, roof, box, slip, reach):
    """Largest distance of nodes of a patch from corners of a cell with a box, by axis."""
    # The terms with `slip` cover every move of a node and of a corner.
    reach[0] = max(x[at[3]], box[3]) - min(x[at[2]], box[0]) + 8.0 * slip
    reach[1] = max(y[at[1]], box[4]) - min(y[at[0]], box[1]) + 8.0 * slip
    reach[2] = max(roof, box[5]) - min(floor, box[2]) + 8.0 * slip


@scalar
def _near_heights(grid, boxes, block, fine):
    """Lowest and highest node of A near a node of B, from few; none (inf, -inf) if it is outside.

    First from the fewest nodes, which exclude most; then, with `fine`, from more.
    """
    c0, c1 = cells_in_interval(
        grid.x, grid.a[N_COL] - 1, grid.pace_x, boxes[block, 0], boxes[block, 3]
    )
    r0, r1 = cells_in_interval(
        grid.y, grid.a[N_ROW] - 1, grid.pace_y, boxes[block, 1], boxes[block, 4]
    )
    # Outside of A's map, or a block that consists of holes.
    if not (c0 < c1 and r0 < r1 and boxes[block, 2] <= boxes[block, 5]):
        return np.inf, -np.inf

    # Two nodes per axis exclude most blocks; up to eight sharpen the answer for the others.
    low, high = _heights_over(grid.nodes, grid.levels, r0, r1, c0, c1, 1)
    if fine and low <= boxes[block, 5] and boxes[block, 2] <= high:
        low, high = _heights_over(grid.nodes, grid.levels, r0, r1, c0, c1, _FINE)
    if low <= boxes[block, 5] and boxes[block, 2] <= high:
        return low, high
    return np.inf, -np.inf


@scalar
def _patch_near(grid, box, at):
    """Cells of A below or above a box, into `at`; lowest and highest node there."""
    at[0], at[1] = cells_in_interval(grid.y, grid.a[N_ROW] - 1, grid.pace_y, box[1], box[4])
    at[2], at[3] = cells_in_interval(grid.x, grid.a[N_COL] - 1, grid.pace_x, box[0], box[3])
    return _heights_over(grid.nodes, grid.levels, at[0], at[1], at[2], at[3], 1)


@scalar
def _push_children(levels, level, i, j, stack, top):
    """Push the nodes below a node of a pyramid."""
    for row in range(2 * i, min(2 * i + 2, levels[level - 1, 1])):
        for col in range(2 * j, min(2 * j + 2, levels[level - 1, 2])):
            stack[top, 0], stack[top, 1], stack[top, 2] = level - 1, row, col
            top += 1
    return top


@scalar
def _near_blocks(grid, nb, lb):
    """Blocks of B (row, column) with nodes of A near, and the lowest and highest of these nodes."""
    # Depth first: at most four children of each level wait.
    stack = np.empty((4 * lb.shape[0] + 4, 3), dtype=np.int64)
    stack[0, 0], stack[0, 1], stack[0, 2] = lb.shape[0] - 1, 0, 0
    blocks, levels = np.empty((64, 2), dtype=np.int64), np.empty((64, 2))
    top, n = 1, 0
    while top > 0:
        top -= 1
        level, row, col = stack[top, 0], stack[top, 1], stack[top, 2]
        node = lb[level, 0] + row * lb[level, 2] + col

        # Skip nodes of the pyramid of B without nodes of A at their height.
        low, high = _near_heights(grid, nb, node, level == 0)
        if not low <= high:
            continue
        if level > 0:
            top = _push_children(lb, level, row, col, stack, top)
            continue

        # Grow both result arrays together.
        if n == blocks.shape[0]:
            blocks = np.concatenate((blocks, np.empty((n, 2), dtype=np.int64)))
            levels = np.concatenate((levels, np.empty((n, 2))))
        blocks[n, 0], blocks[n, 1], levels[n, 0], levels[n, 1] = row, col, low, high
        n += 1
    return blocks[:n], levels[:n]


@scalar
def _near_columns(grid, pb, qb, rb, ab, block, low, high, box, ends, at, spans):
    """Lowest and highest node of A near each column of cells of a block, into `spans`.

    `block`: first and last (one more) row, first and last column of its cells. inf, -inf where no
    node is as high as the column.
    """
    row0, row1, col0, col1 = block
    # Boxes of the last two columns of nodes alternate in `ends`, by parity.
    _column_box(pb, qb, rb, ab, row0, row1, col0, ends[col0 & 1])
    for j in range(col0, col1):
        _column_box(pb, qb, rb, ab, row0, row1, j + 1, ends[(j + 1) & 1])

        # The box of a column of cells is that of its two columns of nodes.
        _hull(ends[0], ends[1], box)
        k = j - col0
        spans[k, 0], spans[k, 1] = np.inf, -np.inf
        if not (low <= box[5] and box[2] <= high):
            continue

        # The lowest and highest node of A below or above this column only, which exclude more.
        least, most = _patch_near(grid, box, at)
        if least <= box[5] and box[2] <= most:
            spans[k, 0], spans[k, 1] = least, most


@entry("d1 d1 d1 l1 d2 l2 d1 d1 d1 l1 d2 l2 d1 d b l2* -> l l")
def axis_grid_pairs(pa, qa, ra, aa, na, la, pb, qb, rb, ab, nb, lb, origin, slip, swapped, pairs):
    """Pairs (key of A, key of B, codes or NEEDS_EXACT) that meet or may meet; cells compared.

    Returns the number of pairs; they are written while `pairs` has capacity. `codes` are those of
    the two corners of a contact, ``64 * first + second``. With `swapped`, B comes first everywhere.
    Nodes may be off by `slip` in the frame of `origin`.
    """
    # Scratch of one cell, of one patch, and of rows of nodes.
    c, f, v = np.empty((8, 3)), np.empty((4, 7)), np.empty((4, 3), dtype=np.int64)
    box, reach, h, w = np.empty(6), np.empty(3), np.empty((2, N_TERM)), np.empty((4, 4))
    at, ends, spans = np.empty(4, dtype=np.int64), np.empty((2, 6)), np.empty((BLOCK, 2))
    rows = np.empty((2, aa[N_ROW]))  # a cell of B may be above all of A
    heights, marks = np.empty((4, aa[N_COL])), np.empty((2, aa[N_COL]), dtype=np.int64)
    codes_table = contact_codes(swapped)
    corners_of_cell(aa, v, 0)
    corners_of_cell(ab, v, 4)

    # Cells per metre turn a coordinate into a first guess of its cell.
    pace_x = (aa[N_COL] - 1) / (pa[aa[N_COL] - 1] - pa[0])
    pace_y = (aa[N_ROW] - 1) / (qa[aa[N_ROW] - 1] - qa[0])
    grid = AxisGrid(pa, qa, ra, aa, na, la, pace_x, pace_y)
    query = CellQuery(box, reach, origin, slip, swapped)
    work = Work(c, f, v, h, w, codes_table, heights, marks, rows)

    # Blocks of B that A may meet.
    blocks, levels = _near_blocks(grid, nb, lb)
    n, asked = 0, 0
    for b in range(blocks.shape[0]):
        row0, col0 = BLOCK * blocks[b, 0], BLOCK * blocks[b, 1]
        row1, col1 = min(row0 + BLOCK, ab[N_ROW] - 1), min(col0 + BLOCK, ab[N_COL] - 1)
        _near_columns(
            grid, pb, qb, rb, ab, (row0, row1, col0, col1), levels[b, 0], levels[b, 1],
            box, ends, at, spans,
        )  # fmt: skip

        # Column by column, then cell by cell: elevation first, then the map.
        for j in range(col0, col1):
            least, most = spans[j - col0, 0], spans[j - col0, 1]
            if not least <= most:
                continue
            for i in range(row0, row1):
                # Elevation excludes most cells and costs four loads.
                _cell_box(rb, ab, 2, i, j, box)
                if not (least <= box[5] and box[2] <= most):
                    continue
                asked += 1
                _cell_box(pb, ab, 0, i, j, box)
                _cell_box(qb, ab, 1, i, j, box)

                # The pyramid of A bounds the patch before its nodes are read.
                floor, roof = _patch_near(grid, box, at)
                if floor <= box[5] and box[2] <= roof:
                    _load_cell(pb, qb, rb, ab, i, j, origin, c)
                    _set_reach(pa, qa, at, floor, roof, box, slip, reach)
                    key = 2 * (i * (ab[N_COL] - 1) + j)
                    n = pairs_in_columns(grid, at, key, query, work, pairs, n)
    return n, asked


# ---- which cells of an increasing axis overlap an interval? By a guess, or by bisection where step
#
# differ.


@scalar
def _guess(axis, n, value, pace):
    """Cell of a value among n cells of even steps; 0 if that is not a number."""
    steps = (value - axis[0]) * pace
    # NaN and values before the axis give 0; the bound comes first, as int() of infinity is
    # undefined.
    return int(min(steps, 1.0 * n)) if steps > 0.0 else 0


@scalar
def cells_in_interval(axis, n, pace, low, high):
    """First and last cell (one more) of n on an increasing axis that overlap an interval.

    `pace` is cells per metre: where steps are even, the guess is off by one cell at most.
    """
    first = _guess(axis, n, low, pace)  # the first cell that ends at `low` or after
    # One step corrects the rounding of a guess.
    if first > 0 and axis[first] >= low:
        first -= 1
    elif first < n and axis[first + 1] < low:
        first += 1

    # The guess failed: bisection.
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

    # The same for the end of the interval.
    if (last > 0 and axis[last - 1] > high) or (last < n and axis[last] <= high):
        last, end = 0, n
        while last < end:
            middle = (last + end) >> 1
            if axis[middle] <= high:
                last = middle + 1
            else:
                end = middle
    return first, last
