"""Candidate pairs of triangles by boxes in equal voxels (after Lo & Wang 2004).

A pair is reported once, in the voxel that holds the lower corner of the common part of the two
boxes. Order: by first triangle, then voxel, then second triangle.

Notation
    boxes    float64 (n, 6): lower x, y, z, upper x, y, z of each triangle
    bounds   float64 (6,): the global box
    shape    int64 (3,): number of voxels along each axis
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.search.tree import append_pair


@entry("d2 l2 -> d2")
def triangle_boxes(x, t):
    """Boxes of all triangles."""
    boxes = np.empty((t.shape[0], 6), dtype=np.float64)
    for i in range(t.shape[0]):
        a, b, c = t[i, 0], t[i, 1], t[i, 2]
        for axis in range(3):
            p, q, r = x[a, axis], x[b, axis], x[c, axis]
            boxes[i, axis] = min(p, min(q, r))
            boxes[i, 3 + axis] = max(p, max(q, r))
    return boxes


def faces_in_box(boxes: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """Rows of the boxes that overlap the global box."""
    apart = np.zeros(len(boxes), dtype=bool)
    for axis in range(3):  # numpy is slow along short rows
        apart |= (boxes[:, axis] > bounds[3 + axis]) | (boxes[:, 3 + axis] < bounds[axis])
    return np.flatnonzero(~apart)


@scalar
def _cell(value, low, size, n):
    c = (value - low) / size
    if c >= n:  # before the cast: a huge face over tiny voxels is beyond int64
        return n - 1
    return int(c) if c > 0.0 else 0


@scalar
def _cell_range(boxes, i, bounds, size, shape, out):
    """First and last voxel of a box along each axis."""
    for axis in range(3):
        # Boxes beyond the bounds are clamped to the outermost voxels.
        out[axis] = _cell(boxes[i, axis], bounds[axis], size, shape[axis])
        out[3 + axis] = _cell(boxes[i, 3 + axis], bounds[axis], size, shape[axis])


@entry("d2 l1 d1 d l1 -> l1 l1")
def fill_voxels(boxes, rows, bounds, size, shape):
    """Triangles of each voxel: offsets (n_voxel + 1,), and rows voxel by voxel."""
    n_voxel = shape[0] * shape[1] * shape[2]
    offsets = np.zeros(n_voxel + 2, dtype=np.int64)
    span = np.empty(6, dtype=np.int64)

    # Count the triangles of each voxel, two places further on.
    for r in range(rows.shape[0]):
        _cell_range(boxes, rows[r], bounds, size, shape, span)
        for i in range(span[0], span[3] + 1):
            for j in range(span[1], span[4] + 1):
                for k in range(span[2], span[5] + 1):
                    offsets[(i * shape[1] + j) * shape[2] + k + 2] += 1

    # Sum up the counts: offsets, shifted by one voxel.
    for c in range(2, n_voxel + 2):
        offsets[c] += offsets[c - 1]

    # Fill: each offset moves to the start of the next voxel.
    filled = np.empty(offsets[n_voxel + 1], dtype=np.int64)
    for r in range(rows.shape[0]):
        _cell_range(boxes, rows[r], bounds, size, shape, span)
        for i in range(span[0], span[3] + 1):
            for j in range(span[1], span[4] + 1):
                for k in range(span[2], span[5] + 1):
                    c = (i * shape[1] + j) * shape[2] + k + 1
                    filled[offsets[c]] = rows[r]
                    offsets[c] += 1
    return offsets[: n_voxel + 1].copy(), filled


@entry("d2 l1 d2 d1 d l1 l1 l1 b l2* -> l")
def voxel_pairs(boxes_a, rows_a, boxes_b, bounds, size, shape, offsets, filled, same, pairs):
    """Pairs of triangles with overlapping boxes, written up to capacity; their number.

    With `same`, the two surfaces are one, and each pair is reported with the lower row first.
    """
    n = 0
    span = np.empty(6, dtype=np.int64)
    for r in range(rows_a.shape[0]):
        a = rows_a[r]
        _cell_range(boxes_a, a, bounds, size, shape, span)
        for i in range(span[0], span[3] + 1):
            for j in range(span[1], span[4] + 1):
                for k in range(span[2], span[5] + 1):
                    # Voxels are numbered with k fastest, so that a row of them is adjacent in
                    # memory.
                    c = (i * shape[1] + j) * shape[2] + k
                    for s in range(offsets[c], offsets[c + 1]):
                        b = filled[s]
                        # In one surface each pair once, and no triangle with itself.
                        if same and b <= a:
                            continue

                        # The common part has its lower corner in this voxel, or the pair is left
                        # to another.
                        here = True
                        for axis in range(3):
                            low = max(boxes_a[a, axis], boxes_b[b, axis])
                            if low > boxes_a[a, 3 + axis] or low > boxes_b[b, 3 + axis]:
                                here = False
                                break
                            at = i if axis == 0 else (j if axis == 1 else k)
                            # The same expression as in `_cell_range`, so that exactly one voxel has
                            # the corner.
                            if _cell(low, bounds[axis], size, shape[axis]) != at:
                                here = False
                                break
                        if here:
                            n = append_pair(pairs, n, a, b)
    return n
