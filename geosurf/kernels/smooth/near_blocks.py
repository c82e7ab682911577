"""Blocks of a lattice that may meet another surface, before second differences are read.

Boxes of nodes are widened by what cubics leave them at most. Two lattices are compared from the
roots of both pyramids down; the blocks of a lattice and triangles by `block_pairs`.

Letters as in `patch_pyramid`; p, q are the boxes of all levels of two pyramids.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.smooth.cubic_patch import node
from geosurf.kernels.smooth.patch_pyramid import SLACK, block_pairs, boxes_meet, join_boxes


@scalar
def _with_coarser(finest, shape):
    """Boxes of all levels, from those of the finest blocks."""
    last = shape[shape.shape[0] - 1]
    boxes = np.empty((last[0] + last[1] * last[2], 6))
    boxes[: finest.shape[0]] = finest
    for level in range(1, shape.shape[0]):
        join_boxes(boxes, shape, level)
    return boxes


@scalar
def _meeting_parts(p, shape, level, i, j, q, other, rows):
    """Write rows and columns of up to four parts of block (i, j) of a level that meet a box of q;
    their number. At level 0 a block is its own part.
    """
    n, up = 0, 1 if level > 0 else 0
    below, two = level - up, 1 + up
    for k in range(two * i, min(two * i + two, shape[below, 1])):
        for col in range(two * j, min(two * j + two, shape[below, 2])):
            if boxes_meet(p, shape[below, 0] + k * shape[below, 2] + col, q, other):
                rows[n, 0], rows[n, 1] = k, col
                n += 1
    return n


@scalar
def _mark_meeting(p, shape_p, q, shape_q, near_p, near_q):
    """Mark the finest blocks of two pyramids that meet one of the other, from both roots down."""
    stack = np.empty((1024, 6), dtype=np.int64)  # levels, rows and columns of both blocks
    ours, theirs = np.empty((4, 2), dtype=np.int64), np.empty((4, 2), dtype=np.int64)
    stack[0] = shape_p.shape[0] - 1, 0, 0, shape_q.shape[0] - 1, 0, 0
    top = 1
    while top > 0:
        top -= 1
        a, i, j = stack[top, 0], stack[top, 1], stack[top, 2]
        b, k, m = stack[top, 3], stack[top, 4], stack[top, 5]
        row = shape_p[a, 0] + i * shape_p[a, 2] + j
        other = shape_q[b, 0] + k * shape_q[b, 2] + m

        # the larger of both is divided, or both: first each against the other as a whole
        n_p, n_q = 1, 1
        ours[0], theirs[0] = (i, j), (k, m)
        down_p, down_q = a >= b, b >= a
        if down_p:
            n_p = _meeting_parts(p, shape_p, a, i, j, q, other, ours)
            a -= 1 if a > 0 else 0
        if down_q:
            n_q = _meeting_parts(q, shape_q, b, k, m, p, row, theirs) if n_p > 0 else 0
            b -= 1 if b > 0 else 0
        for e in range(n_p):
            row = shape_p[a, 0] + ours[e, 0] * shape_p[a, 2] + ours[e, 1]
            for g in range(n_q):
                other = shape_q[b, 0] + theirs[g, 0] * shape_q[b, 2] + theirs[g, 1]
                if not boxes_meet(p, row, q, other):
                    continue
                if a == 0 and b == 0:
                    near_p[row], near_q[other] = True, True
                    continue
                stack[top, 0], stack[top, 1], stack[top, 2] = a, ours[e, 0], ours[e, 1]
                stack[top, 3], stack[top, 4], stack[top, 5] = b, theirs[g, 0], theirs[g, 1]
                top += 1


@entry("d2 l2 d2 l2 d2 -> b1 b1")
def near_blocks(finest, shape, items, shape_items, planes):
    """Which of the finest blocks, and which items, have boxes that meet.

    `shape` as that of `lattice_pyramid`, `planes` as those of `block_pairs`. `shape_items` is of
    the second lattice; it has no rows if the items are triangles.
    """
    boxes = _with_coarser(finest, shape)
    near_block = np.zeros(finest.shape[0], dtype=np.bool_)
    near_item = np.zeros(items.shape[0], dtype=np.bool_)
    if shape_items.shape[0] > 0:
        others = _with_coarser(items, shape_items)
        _mark_meeting(boxes, shape, others, shape_items, near_block, near_item)
        return near_block, near_item
    pairs = block_pairs(boxes, shape, items, planes)
    for k in range(pairs.shape[0]):
        near_block[pairs[k, 0]] = True
        near_item[pairs[k, 1]] = True
    return near_block, near_item


@entry("d2 d2 d2 l l l -> b1")
def blocks_at_holes(x, y, z, n_row, n_col, cells):
    """Whether a node is absent in a block (n_row * n_col,) of so many cells along a side, or in one
    of the eight around it.
    """
    out = np.zeros(n_row * n_col, dtype=np.bool_)
    for i in range(n_row):
        last = min((i + 1) * cells + 1, z.shape[0])
        for j in range(n_col):
            total, stop = 0.0, min((j + 1) * cells + 1, z.shape[1])
            for row in range(i * cells, last):
                for col in range(j * cells, stop):
                    total += node(x, row, col) + node(y, row, col) + z[row, col]
            if math.isfinite(total):
                continue
            for k in range(max(i - 1, 0), min(i + 2, n_row)):
                for m in range(max(j - 1, 0), min(j + 2, n_col)):
                    out[k * n_col + m] = True
    return out


@entry("d2 d b2 l d2 -> .")
def shift_near(values, origin, near, cells, out):
    """Write coordinates less an origin to `out`, for nodes of near blocks of so many cells along a
    side and of the eight blocks around each.
    """
    n_row, n_col = values.shape
    for i in range(near.shape[0]):
        rows = range(max((i - 1) * cells, 0), min((i + 2) * cells + 1, n_row))
        j = 0
        while j < near.shape[1]:
            if not near[i, j]:
                j += 1
                continue
            # all near blocks of a row that lie side by side
            start = j
            while j < near.shape[1] and near[i, j]:
                j += 1
            first, last = max((start - 1) * cells, 0), min((j + 1) * cells + 1, n_col)
            for row in rows:
                for col in range(first, last):
                    out[row, col] = values[row, col] - origin


@entry("d2 l l d1 d d -> d2")
def boxes_of_cubics(nodes, n_row, n_col, origin, beyond, at_rim):
    """Boxes (n_row * n_col, 6) around the cubics of blocks, from boxes `nodes` of their nodes.

    A cubic leaves the range of the nodes of its block and of the eight around it by at most
    `beyond` of that range, in blocks at the rim by `at_rim` of it. A missing block has an empty
    box.
    """
    out = np.empty((n_row * n_col, 6))
    across = np.empty((n_col, 6))
    for i in range(n_row):
        # extremes of up to three rows of blocks, column by column
        for j in range(n_col):
            for k in range(6):
                across[j, k] = nodes[i * n_col + j, k]
        for row in range(max(i - 1, 0), min(i + 2, n_row)):
            for j in range(n_col):
                for k in range(3):
                    across[j, k] = min(across[j, k], nodes[row * n_col + j, k])
                    across[j, 3 + k] = max(across[j, 3 + k], nodes[row * n_col + j, 3 + k])

        # then of up to three columns, widened
        for j in range(n_col):
            rim = i == 0 or j == 0 or i == n_row - 1 or j == n_col - 1
            box = out[i * n_col + j]
            for k in range(3):
                low, high = across[j, k], across[j, 3 + k]
                for col in range(max(j - 1, 0), min(j + 2, n_col)):
                    low, high = min(low, across[col, k]), max(high, across[col, 3 + k])
                more = (at_rim if rim else beyond) * (high - low) + SLACK if low <= high else 0.0
                box[k], box[3 + k] = low - more - origin[k], high + more - origin[k]
    return out
