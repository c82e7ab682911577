"""Bounds of local cubics over blocks of cells: where can two smooth surfaces meet?

The bounds come from second differences of nodes, which are small where a surface is smooth. Let D
be the largest along rows, plus the largest along columns, of all nodes that the stencils of some
cells reach. Then

- nodes of s x s cells leave the bilinear patch between the four outermost by ``h D`` at most, with
  ``h = s^2 / 8``, rounded down to ``k (s - k) / 2`` for ``k = s // 2``;
- the cubic of a cell leaves the bilinear patch between its own four nodes by ``1.25 / 8 D`` at
  most: on nodes -1, 0, 1, 2 it is the chord plus ``t (t - 1) / 2`` times a mean of the second
  differences at 0 and 1, and 4-point weights across have absolute values that add up to 1.25. At a
  boundary the stencil is shifted: 7/3 of a mean, and 1.632.

So four nodes and D bound all cubics of a block, of a part of it, of a cell, along any direction.
Where a block lacks a node, or is as rough as noise, all its nodes are used instead of four. A cell
without a complete stencil counts as its triangles, which lie between its nodes. Excluded pairs have
neither a contact of the cubics nor one of the triangles.

Letters as in `cubic_patch`; boxes (n, 6) lower, upper; bend (4,) of a block: D of x, y, z, and 1
where four nodes suffice.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.smooth.cubic_patch import node

BLOCK = 8
SLACK = 1e-9  # [m], above the rounding of coordinates
_INSIDE = 1.25 / 8.0
_AT_RIM = 1.632 * 7.0 / 24.0
_ROUGH = 0.1  # blocks that may bend by more than this part of their diagonal: all nodes


# ---- second differences ------------------------------------------------------------------


@scalar
def _beyond(most, size):
    """The larger of two; a NaN `size` of a missing node is ignored."""
    return size if size > most else most


@scalar
def _along_rows(q, i0, i1, j0, j1, out):
    """Largest second difference along rows i0 to i1, at the middle of three columns, less one, from
    j0 to j1.

    Four rows at a time, the last one repeated if needed: the loop over columns has no branches and
    is vectorised, and four rows hardly take longer than one.
    """
    out[j0:j1] = 0.0
    for i in range(i0, i1, 4):
        a, b = q[i], q[min(i + 1, i1 - 1)]
        c, d = q[min(i + 2, i1 - 1)], q[min(i + 3, i1 - 1)]
        for j in range(j0, j1):
            most = _beyond(out[j], abs(a[j] - 2.0 * a[j + 1] + a[j + 2]))
            most = _beyond(most, abs(b[j] - 2.0 * b[j + 1] + b[j + 2]))
            most = _beyond(most, abs(c[j] - 2.0 * c[j + 1] + c[j + 2]))
            out[j] = _beyond(most, abs(d[j] - 2.0 * d[j + 1] + d[j + 2]))


@scalar
def _along_columns(q, i0, i1, j0, j1, out):
    """Largest second difference along columns j0 to j1, at the middle of three rows, i0 to i1.

    Three at a time, since a whole block has nine.
    """
    out[j0:j1] = 0.0
    # Rows in full groups of three; the rest follows one by one.
    threes = i0 + (i1 - i0) // 3 * 3
    for i in range(i0, threes, 3):
        a, b, c, d, e = q[i - 1], q[i], q[i + 1], q[i + 2], q[i + 3]
        for j in range(j0, j1):
            most = _beyond(out[j], abs(a[j] - 2.0 * b[j] + c[j]))
            most = _beyond(most, abs(b[j] - 2.0 * c[j] + d[j]))
            out[j] = _beyond(most, abs(c[j] - 2.0 * d[j] + e[j]))
    for i in range(threes, i1):
        a, b, c = q[i - 1], q[i], q[i + 1]
        for j in range(j0, j1):
            out[j] = _beyond(out[j], abs(a[j] - 2.0 * b[j] + c[j]))


@scalar
def _largest(values, first, last):
    """The largest of some of values, none of them NaN."""
    largest = 0.0
    for k in range(first, last):
        if values[k] > largest:
            largest = values[k]
    return largest


@scalar
def _centres(n, first, last):
    """First and last middle of the second differences that the cubics of some cells depend on."""
    # Second differences exist at nodes 1 to n - 2; shifted stencils reach further inwards.
    return max(1, min(first, n - 3)), min(n - 2, max(last, 2)) + 1


@scalar
def _bend_row(q, n_row, n_col, r0, r1, first, last, axis, along_rows, along_columns, bends):
    """D of one coordinate for blocks `first` to `last` of a row, whose cells have rows r0 to r1."""
    # Columns of all stencils of these blocks: one more on each side, four at least.
    j0 = max(min(first * BLOCK - 1, n_col - 4), 0)
    j1 = min(max(last * BLOCK + 2, 4), n_col)
    # Second differences along rows, then along columns.
    if q.shape[1] > 1:
        rows = q.shape[0] > 1
        # Rows of all stencils of the block: one more on each side, four at least.
        i0, i1 = max(min(r0 - 1, n_row - 4), 0), min(max(r1 + 2, 4), n_row)
        _along_rows(q, i0 if rows else 0, i1 if rows else 1, j0, j1 - 2, along_rows)
    if q.shape[0] > 1:
        i0, i1 = _centres(n_row, r0, r1)
        wide = q.shape[1] > 1
        _along_columns(q, i0, i1, j0 if wide else 0, j1 if wide else 1, along_columns)
    for block in range(first, last):
        c0, c1 = block * BLOCK, min(block * BLOCK + BLOCK, n_col - 1)
        bend = 0.0
        if q.shape[1] > 1:
            j0, j1 = _centres(n_col, c0, c1)
            bend += _largest(along_rows, j0 - 1, j1 - 1)
        if q.shape[0] > 1:
            bend += _largest(along_columns, c0, c1 + 1) if q.shape[1] > 1 else along_columns[0]
        bends[block, axis] = bend


@scalar
def is_present(x, y, z, i, j):
    """Whether a node has all coordinates."""
    return math.isfinite(node(x, i, j) + node(y, i, j) + node(z, i, j))


@scalar
def _corners_suffice(x, y, z, whole, r0, r1, c0, c1, bend):
    """Whether bounds from the four outermost nodes of a block are tight."""
    if not whole:
        for i in range(r0, r1 + 1):
            for j in range(c0, c1 + 1):
                if not is_present(x, y, z, i, j):
                    return False
    size, most = 0.0, 0.0
    for axis in range(3):
        q = x if axis == 0 else (y if axis == 1 else z)
        one, two = node(q, r0, c0), node(q, r0, c1)
        far, up = node(q, r1, c1) - one, node(q, r1, c0) - two
        size += max(far * far, up * up)
        most += bend[axis] * bend[axis]
    # The bound of the head of this file against the size of the block.
    return math.sqrt(most) * (BLOCK * BLOCK / 8.0) <= _ROUGH * math.sqrt(size)


# ---- bounds ------------------------------------------------------------------------------


@scalar
def bulge(z, r0, r1, c0, c1):
    """Largest distance of the cubics of cells from their bilinear patches, in units of D."""
    # A cell at the boundary has a shifted stencil and a larger factor.
    shifted = r0 == 0 or c0 == 0 or r1 == z.shape[0] - 1 or c1 == z.shape[1] - 1
    return _AT_RIM if shifted else _INSIDE


@scalar
def _walk_through(z, bend, r0, r1, c0, c1):
    """Steps between the nodes to read, down and across; and the remaining deviation in D."""
    more = bulge(z, r0, r1, c0, c1)
    # A rough block, or one with holes: read every node.
    if bend[3] == 0.0:
        return 1, 1, more
    size = max(r1 - r0, c1 - c0)
    # The nodes in between may leave the bilinear patch by h D.
    return r1 - r0, c1 - c0, more + 0.5 * (size // 2) * (size - size // 2)


@scalar
def span_along(x, y, z, bend, r0, r1, c0, c1, p, q, r):
    """Bounds of p x + q y + r z over the cubics of cells of a block, rows r0 to r1, columns c0 to
    c1; reversed if there is no node.
    """
    down, over, more = _walk_through(z, bend, r0, r1, c0, c1)
    more = more * (abs(p) * bend[0] + abs(q) * bend[1] + abs(r) * bend[2]) + SLACK
    low, high = np.inf, -np.inf

    # All nodes of a rough block, four corners of a smooth one.
    for i in range(r0, r1 + 1, down):
        for j in range(c0, c1 + 1, over):
            value = p * node(x, i, j) + q * node(y, i, j) + r * node(z, i, j)
            # comparisons with NaN are false, so a missing node changes nothing
            if value < low:
                low = value
            if value > high:
                high = value
    return low - more, high + more


@scalar
def box_of(x, y, z, bend, r0, r1, c0, c1, box):
    """Box around the cubics of cells of a block into the first six of `box`."""
    down, over, more = _walk_through(z, bend, r0, r1, c0, c1)
    for axis in range(3):
        q = x if axis == 0 else (y if axis == 1 else z)
        low, high = np.inf, -np.inf
        for i in range(r0, r1 + 1, down):
            for j in range(c0, c1 + 1, over):
                value = node(q, i, j)
                if value < low:
                    low = value
                if value > high:
                    high = value
        box[axis], box[3 + axis] = low - more * bend[axis] - SLACK, high + more * bend[axis] + SLACK


# ---- the pyramid -------------------------------------------------------------------------


@scalar
def _shape_of(n_row, n_col):
    """(offset, n_row, n_col) of each level of blocks, the finest first, and how many boxes."""
    shape = np.empty((40, 3), dtype=np.int64)
    r, c, total, n_level = (n_row + BLOCK - 1) // BLOCK, (n_col + BLOCK - 1) // BLOCK, 0, 0

    # Halve rows and columns until one block is left.
    while True:
        shape[n_level, 0], shape[n_level, 1], shape[n_level, 2] = total, r, c
        n_level += 1
        total += r * c
        if r * c == 1:
            return shape[:n_level].copy(), total
        r, c = (r + 1) // 2, (c + 1) // 2


@scalar
def join_boxes(boxes, shape, level):
    """Boxes of one level around those of the level below."""
    before, _, below = shape[level - 1]
    for i in range(shape[level, 1]):
        for j in range(shape[level, 2]):
            box = boxes[shape[level, 0] + i * shape[level, 2] + j]
            box[:3], box[3:] = np.inf, -np.inf

            # Up to four children.
            for k in range(2 * i, min(2 * i + 2, shape[level - 1, 1])):
                for col in range(2 * j, min(2 * j + 2, below)):
                    for axis in range(3):
                        child = boxes[before + k * below + col]
                        box[axis] = min(box[axis], child[axis])
                        box[3 + axis] = max(box[3 + axis], child[3 + axis])


@scalar
def _row_of_blocks(x, y, z, whole, i, near, along_rows, along_columns, boxes, bends):
    """Bends and boxes of row i of the finest blocks: of those that are near, the others empty."""
    n_row, n_col = z.shape
    r0, r1 = i * BLOCK, min(i * BLOCK + BLOCK, n_row - 1)
    boxes[:, :3], boxes[:, 3:], bends[:] = np.inf, -np.inf, 0.0

    # From the first near block to the last: what is before and after them is not read.
    first, last = near.shape[0], 0
    for j in range(near.shape[0]):
        if near[j]:
            first, last = min(first, j), j + 1
    for axis in range(3):
        q = x if axis == 0 else (y if axis == 1 else z)
        if first < last:
            _bend_row(q, n_row, n_col, r0, r1, first, last, axis, along_rows, along_columns, bends)
    for j in range(first, last):
        if not near[j]:
            continue
        c0, c1 = j * BLOCK, min(j * BLOCK + BLOCK, n_col - 1)

        # Decide first whether four nodes suffice, since the box depends on it.
        tell = _corners_suffice(x, y, z, whole, r0, r1, c0, c1, bends[j])
        bends[j, 3] = 1.0 if tell else 0.0
        box_of(x, y, z, bends[j], r0, r1, c0, c1, boxes[j])


@entry("d2 d2 d2 b b1 -> d2 l2 d2")
def lattice_pyramid(x, y, z, whole, near):
    """Boxes of all levels, the finest first, (offset, n_row, n_col) of each level, and bends of the
    finest blocks.

    `whole`: whether all nodes are known to be there. `near` (n_block,): which blocks to describe;
    the others get empty boxes.
    """
    n_row, n_col = z.shape
    shape, total = _shape_of(n_row - 1, n_col - 1)
    across = shape[0, 2]
    boxes, bends = np.empty((total, 6)), np.empty((shape[0, 1] * across, 4))
    along_rows, along_columns = np.empty(n_col), np.empty(n_col)
    for i in range(shape[0, 1]):
        one, two = i * across, i * across + across
        # a helper does not count references of its arrays, block by block
        _row_of_blocks(
            x,
            y,
            z,
            whole,
            i,
            near[one:two],
            along_rows,
            along_columns,
            boxes[one:two],
            bends[one:two],
        )

    # Coarser levels join four boxes.
    for level in range(1, shape.shape[0]):
        join_boxes(boxes, shape, level)
    return boxes, shape, bends


@scalar
def boxes_meet(p, i, q, j):
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
    middle, reach = -planes[item, 3], SLACK
    for axis in range(3):
        # Distance of the centre, and extent along the normal.
        middle += planes[item, axis] * 0.5 * (boxes[row, axis] + boxes[row, 3 + axis])
        reach += abs(planes[item, axis]) * 0.5 * (boxes[row, 3 + axis] - boxes[row, axis])
    return abs(middle) > reach


@scalar
def block_pairs(boxes, shape, items, planes):
    """Pairs (finest block, item) whose boxes meet, item by item.

    `planes` (n_item, 4): unit normal and distance of items that are flat; none for a lattice.
    """
    out = np.empty((256, 2), dtype=np.int64)
    n, flat = 0, planes.shape[0] > 0
    stack = np.empty((256, 3), dtype=np.int64)
    # Depth first from the root for each item; results come item by item.
    for item in range(items.shape[0]):
        stack[0, 0], stack[0, 1], stack[0, 2] = shape.shape[0] - 1, 0, 0
        top = 1
        while top > 0:
            top -= 1
            level, i, j = stack[top, 0], stack[top, 1], stack[top, 2]
            row = shape[level, 0] + i * shape[level, 2] + j
            if not boxes_meet(boxes, row, items, item):
                continue
            if flat and _off_plane(boxes, row, planes, item):
                continue

            # Finest level: append the pair; otherwise push the children.
            if level == 0:
                if n == out.shape[0]:
                    more = np.empty((2 * n, 2), dtype=np.int64)
                    more[:n] = out
                    out = more
                out[n, 0], out[n, 1] = row, item
                n += 1
                continue
            for k in range(2 * i, min(2 * i + 2, shape[level - 1, 1])):
                for col in range(2 * j, min(2 * j + 2, shape[level - 1, 2])):
                    stack[top, 0], stack[top, 1], stack[top, 2] = level - 1, k, col
                    top += 1
    return out[:n]
