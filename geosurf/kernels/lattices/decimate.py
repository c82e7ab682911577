"""How far a lattice of some rows and columns is from the lattice of all of them.

Both have diagonals that rise. In rows and columns (not in metres), triangles of a coarse cell of
p x p fine cells consist of whole fine triangles: the difference of the surfaces is linear on each
of these, and largest at a node. In a coarse cell of p x q cells it is linear on the parts into
which the coarse diagonal divides fine triangles: it is largest at a node, or where that diagonal
crosses a row, a column or a fine diagonal.

The integral of the difference needs no such parts: it is that of the fine triangles less that of
the coarse ones. Each is the area of a triangle times the mean of its corners. So nodes inside of a
coarse cell count for one fine cell, those on its sides for half of one, and its corners for a third
where both triangles meet, else for a sixth.

Where nodes are not at even steps, see `geosurf.triangulate.decimate`.

Notation
    z          elevation of nodes (n_row, n_col), all present
    rows cols  those that are kept, from the first to the last
    block      what lies between two rows that are kept
    a b c d    corners of a coarse cell, counter-clockwise from (i, j)
    s, t       part of a coarse cell along columns and along rows, 0 to 1
    work       scratch rows of WIDTH numbers
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar

WIDTH = 512  # columns that are looked at together: their scratch rows fit into the nearest cache

# scratch rows, by column: part s; heights at t = 0 and their change up to t = 1, below and above
# the diagonal; the largest differences, all nodes higher or lower; and the sum of elevations
_S, _BELOW, _BELOW_UP, _ABOVE, _ABOVE_UP, _HIGHER, _LOWEST, _SUM, _N_WORK = (
    0,
    1,
    2,
    3,
    4,
    5,
    6,
    7,
    8,
)


@scalar
def _prepare(z, i, k, cols, first, last, work, low, high):
    """Planes of the coarse cells `first` to `last` between rows i and k, column by column.

    `low` and `high` get the elevations of kept nodes in both rows.
    """
    start = cols[first]
    for cell in range(first, last):
        j, m = cols[cell], cols[cell + 1]
        a, b, c, d = z[i, j], z[i, m], z[k, m], z[k, j]
        low[cell], low[cell + 1], high[cell], high[cell + 1] = a, b, d, c
        # the last column of a cell is the first of the next one
        for col in range(j, m + 1 if cell == last - 1 else m):
            at, s = col - start, (col - j) / (m - j)
            work[_S * WIDTH + at] = s
            work[_BELOW * WIDTH + at] = a + s * (b - a)
            work[_BELOW_UP * WIDTH + at] = c - b
            work[_ABOVE * WIDTH + at] = a + s * (c - d)
            work[_ABOVE_UP * WIDTH + at] = d - a
            work[_HIGHER * WIDTH + at] = 0.0
            work[_LOWEST * WIDTH + at] = 0.0
            work[_SUM * WIDTH + at] = 0.0


@scalar
def _add_rows(row, next_row, t, u, first, second, n, work):
    """Compare two rows of nodes, at parts t and u, with the planes; these are read once."""
    for k in range(min(n, WIDTH)):  # selections without branches are vectorised
        s = work[_S * WIDTH + k]
        below, below_up = work[_BELOW * WIDTH + k], work[_BELOW_UP * WIDTH + k]
        above, above_up = work[_ABOVE * WIDTH + k], work[_ABOVE_UP * WIDTH + k]
        off = row[k] - (below + t * below_up if s >= t else above + t * above_up)
        more = next_row[k] - (below + u * below_up if s >= u else above + u * above_up)
        high, low = max(off, more), min(off, more)
        most, least = work[_HIGHER * WIDTH + k], work[_LOWEST * WIDTH + k]
        work[_HIGHER * WIDTH + k] = high if high > most else most
        work[_LOWEST * WIDTH + k] = low if low < least else least
        work[_SUM * WIDTH + k] += first * row[k] + second * next_row[k]


@scalar
def _at_diagonal(z, i, j, p, q, high, low):
    """Differences where the diagonal of a coarse cell crosses fine edges; their extremes.

    `high` and `low` are the extremes at its nodes.
    """
    start, end = z[i, j], z[i + p, j + q]
    for row in range(1, p):
        x = row * q / p
        on = min(int(x), q - 1)
        here, next_one = z[i + row, j + on], z[i + row, j + on + 1]
        off = here + (x - on) * (next_one - here) - (start + row / p * (end - start))
        high, low = max(high, off), min(low, off)
    for col in range(1, q):
        y = col * p / q
        on = min(int(y), p - 1)
        here, next_one = z[i + on, j + col], z[i + on + 1, j + col]
        off = here + (y - on) * (next_one - here) - (start + col / q * (end - start))
        high, low = max(high, off), min(low, off)

    # fine diagonals are `wide` columns farther on than rows, the coarse one by more and more
    for k in range(1, abs(q - p)):
        t = k / abs(q - p)
        wide = k if q > p else -k
        on = min(int(t * p), p - 1) if q > p else min(int(t * q), q - 1) + k
        here, next_one = z[i + on, j + on + wide], z[i + on + 1, j + on + wide + 1]
        off = here + (t * p - on) * (next_one - here) - (start + t * (end - start))
        high, low = max(high, off), min(low, off)
    return high, low


@scalar
def _cell_of_work(work, j, q):
    """Extremes of the differences of one coarse cell, and the sum of its elevations; its sides
    count for two cells.
    """
    high, low, total = 0.0, 0.0, 0.0
    for k in range(j, j + q + 1):
        high, low = max(high, work[_HIGHER * WIDTH + k]), min(low, work[_LOWEST * WIDTH + k])
        total += work[_SUM * WIDTH + k]
    return high, low, total - 0.5 * (work[_SUM * WIDTH + j] + work[_SUM * WIDTH + j + q])


@scalar
def _change(z, i, j, p, q, total):
    """Integral of the fine surface less the coarse one over a coarse cell, in fine cells [m].

    `total` counts corners as a quarter.
    """
    a, b, c, d = z[i, j], z[i, j + q], z[i + p, j + q], z[i + p, j]
    return total + (a - b + c - d) / 12.0 - p * q * (2.0 * a + b + 2.0 * c + d) / 6.0


@entry("d2 l1 l1 l1 d -> d2 d2 d2 d2 l")
def differences_of_rows_and_columns(z, rows, cols, order, limit):
    """Elevations of kept nodes [m]; how far all nodes are above and below the coarse surface at
    most, in each coarse cell [m]; the integral of what they are above it, over each, in fine cells
    [m]; and a block with a larger difference than the limit, or -1.

    Blocks are looked at in an order, up to the first with a larger one. Cells between kept columns
    are narrower than WIDTH.
    """
    n_block, n_cell = rows.shape[0] - 1, cols.shape[0] - 1
    few = np.empty((n_block + 1, n_cell + 1))
    above, below = np.zeros((n_block, n_cell)), np.zeros((n_block, n_cell))
    change = np.zeros((n_block, n_cell))
    work = np.empty(_N_WORK * WIDTH)
    for block in order:
        i, k = rows[block], rows[block + 1]
        worst, first = 0.0, 0
        while first < n_cell:
            # whole cells that fit into the scratch rows
            last = first + 1
            while last < n_cell and cols[last + 1] - cols[first] < WIDTH:
                last += 1
            start, n = cols[first], cols[last] - cols[first] + 1
            _prepare(z, i, k, cols, first, last, work, few[block], few[block + 1])
            for row in range(i, k + 1, 2):
                # the last of an odd number of rows stands for two, and counts once
                two = min(row + 1, k)
                weight = 0.5 if row == i or row == k else 1.0
                other = 0.0 if two == row else 0.5 if two == k else 1.0
                t, u = (row - i) / (k - i), (two - i) / (k - i)
                pair = z[row, start : start + n], z[two, start : start + n]
                _add_rows(pair[0], pair[1], t, u, weight, other, n, work)
            for cell in range(first, last):
                j, q = cols[cell], cols[cell + 1] - cols[cell]
                high, low, total = _cell_of_work(work, j - start, q)
                if q != k - i:
                    high, low = _at_diagonal(z, i, j, k - i, q, high, low)
                above[block, cell], below[block, cell] = high, -low
                change[block, cell] = _change(z, i, j, k - i, q, total)
                worst = max(worst, high, -low)
            first = last
        if worst > limit:
            return few, above, below, change, block
    return few, above, below, change, -1


@scalar
def _largest_steps(few):
    """The largest steps between neighbours along columns of nodes, and along rows of nodes."""
    n_row, n_col = few.shape
    up, over = 0.0, 0.0
    for i in range(n_row):
        for j in range(n_col):
            if i > 0:
                up = max(up, abs(few[i, j] - few[i - 1, j]))
            if j > 0:
                over = max(over, abs(few[i, j] - few[i, j - 1]))
    return up, over


@entry("d2 d2 d2 d2 l1 l1 d1 d1 d d d d d d -> d2 d2 d2 d2 d l")
def bounds_of_cells(
    few, above, below, change, rows, cols, high, wide, up, over, stretch, size, rounding, per_node
):
    """Bounds over the map from differences over rows and columns (for their names see
    `geosurf.triangulate.decimate`): the largest difference in each coarse cell [m]; the volume
    between both surfaces, that with its sign, and how unsure the latter is [m3]; the largest
    difference of all, and its block.

    high, wide: sides of coarse cells [m]; up, over: how far rows and columns are from even steps,
    as a part of a cell; size: the largest elevation [m]; rounding, per_node: of a difference and of
    a sum, as parts of `size`.
    """
    n_block, n_cell = above.shape
    step_up, step_over = _largest_steps(few)
    slack = up * step_up + over * step_over + rounding * size
    p, q = 0, 0
    for block in range(n_block):
        p = max(p, rows[block + 1] - rows[block])
    for cell in range(n_cell):
        q = max(q, cols[cell + 1] - cols[cell])
    unsure = slack + per_node * size * (p + 1) * (q + 1)

    largest, between = np.empty((n_block, n_cell)), np.empty((n_block, n_cell))
    signed, doubt = np.empty((n_block, n_cell)), np.empty((n_block, n_cell))
    most, worst = 0.0, 0
    for i in range(n_block):
        for j in range(n_cell):
            area, n = high[i] * wide[j], (rows[i + 1] - rows[i]) * (cols[j + 1] - cols[j])
            off = max(above[i, j], below[i, j])
            largest[i, j] = off + slack
            signed[i, j] = change[i, j] * (area / n)
            doubt[i, j] = area * (stretch * off + unsure)

            # what is above counts as much as what is below, where a cell has both
            both = abs(signed[i, j]) + 2.0 * area * min(above[i, j], below[i, j])
            between[i, j] = min(both + doubt[i, j], area * largest[i, j])
            if largest[i, j] > most:
                most, worst = largest[i, j], i
    return largest, between, signed, doubt, most, worst


# ---- near cells ----------------------------------------
# Cells of a lattice whose boxes meet other boxes: pyramids of boxes, joined four by four.


_SLACK = 1e-9  # [m], above the rounding of coordinates


@scalar
def _pyramid(cells, n_row, n_col):
    """(first box, rows, columns) of each level, the cells first, and the boxes of all levels."""
    levels = np.empty((40, 3), dtype=np.int64)
    total, n = 0, 0
    while True:
        levels[n, 0], levels[n, 1], levels[n, 2] = total, n_row, n_col
        n, total = n + 1, total + n_row * n_col
        if n_row * n_col <= 1:
            break
        n_row, n_col = (n_row + 1) // 2, (n_col + 1) // 2

    boxes = np.empty((total, 6))
    boxes[: cells.shape[0]] = cells
    boxes[cells.shape[0] :, :3], boxes[cells.shape[0] :, 3:] = np.inf, -np.inf
    for level in range(1, n):
        first, rows, cols = levels[level - 1]
        for i in range(rows):
            for j in range(cols):
                box = boxes[levels[level, 0] + i // 2 * levels[level, 2] + j // 2]
                for axis in range(3):
                    child = boxes[first + i * cols + j]
                    box[axis] = min(box[axis], child[axis])
                    box[3 + axis] = max(box[3 + axis], child[3 + axis])
    return levels[:n], boxes


@scalar
def _meet(p, i, q, j):
    """Whether box i of p meets box j of q; an empty or undefined box meets none."""
    # no short circuit: which comparison fails is unpredictable
    return (
        (p[i, 0] <= q[j, 3]) & (q[j, 0] <= p[i, 3])
        & (p[i, 1] <= q[j, 4]) & (q[j, 1] <= p[i, 4])
        & (p[i, 2] <= q[j, 5]) & (q[j, 2] <= p[i, 5])
    )  # fmt: skip


@scalar
def _off_plane(boxes, row, planes, item):
    """Whether a box lies on one side of a plane (a, b, c, d)."""
    middle, reach = -planes[item, 3], _SLACK
    for axis in range(3):
        # Distance of the centre, and extent along the normal.
        middle += planes[item, axis] * 0.5 * (boxes[row, axis] + boxes[row, 3 + axis])
        reach += abs(planes[item, axis]) * 0.5 * (boxes[row, 3 + axis] - boxes[row, axis])
    return abs(middle) > reach


@entry("d2 l l d2 d2 -> b2")
def near_cells(cells, n_row, n_col, items, planes):
    """Which cells (n_row, n_col) have boxes `cells` (n_row * n_col, 6) that meet one of `items`.

    `planes` (n_item, 4): unit normals and distances of items that are flat; none if they are not.
    """
    near = np.zeros((n_row, n_col), dtype=np.bool_)
    levels, boxes = _pyramid(cells, n_row, n_col)
    flat = planes.shape[0] > 0
    stack = np.empty((256, 3), dtype=np.int64)

    # depth first from the root for each item
    for item in range(items.shape[0]):
        stack[0, 0], stack[0, 1], stack[0, 2] = levels.shape[0] - 1, 0, 0
        top = 1
        while top > 0:
            top -= 1
            level, i, j = stack[top, 0], stack[top, 1], stack[top, 2]
            row = levels[level, 0] + i * levels[level, 2] + j
            if not _meet(boxes, row, items, item) or (
                flat and _off_plane(boxes, row, planes, item)
            ):
                continue
            if level == 0:
                near[i, j] = True
                continue
            for k in range(2 * i, min(2 * i + 2, levels[level - 1, 1])):
                for col in range(2 * j, min(2 * j + 2, levels[level - 1, 2])):
                    stack[top, 0], stack[top, 1], stack[top, 2] = level - 1, k, col
                    top += 1
    return near
