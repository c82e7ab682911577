"""Cells of a lattice whose boxes meet other boxes: pyramids of boxes, joined four by four."""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar

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
