"""Which triangles may meet some few others: those in the voxels that the few pass.

A triangle that meets another one has a point in common with it, and this point is in one voxel. So
the voxels of the few are marked, and all triangles without a marked voxel are apart from them. The
search costs one pass over the others, and no memory for each of them.

Notation
    x, t     corners and triangles
    boxes    lower and upper corner of each of the few
    marks    whether the few pass a voxel, (n_voxel,), as `voxels` numbers them
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.search.large_triangles import _passed, _steepest
from geosurf.kernels.search.separation import plane_of
from geosurf.kernels.search.voxels import _cell_range

_WIDE = 64  # voxels in its box, from which a triangle is followed along its plane, or not tested


@scalar
def _mark_along_plane(x, t, f, bounds, size, shape, span, marks):
    """Mark the voxels of a box that the plane of a triangle passes, and a few more."""
    p, at = np.empty(9), np.zeros(3, dtype=np.int64)
    plane_of(x, t, f, p)
    axis = _steepest(p)
    u, v = (axis + 1) % 3, (axis + 2) % 3
    for one in range(span[u], span[3 + u] + 1):
        for two in range(span[v], span[3 + v] + 1):
            at[u], at[v] = one, two
            low, high = _passed(p, bounds, size, axis, at, span)
            for three in range(low, high + 1):
                at[axis] = three
                marks[(at[0] * shape[1] + at[1]) * shape[2] + at[2]] = True


@scalar
def _n_voxel(span):
    """Number of voxels from the first to the last along all axes."""
    return (span[3] - span[0] + 1) * (span[4] - span[1] + 1) * (span[5] - span[2] + 1)


@scalar
def _has_mark(marks, shape, span):
    """Whether a voxel from the first to the last along all axes is marked."""
    for i in range(span[0], span[3] + 1):
        for j in range(span[1], span[4] + 1):
            row = (i * shape[1] + j) * shape[2]
            for k in range(span[2], span[5] + 1):
                if marks[row + k]:
                    return True
    return False


@entry("d2 l2 d2 d1 d l1 -> b1")
def mark_voxels(x, t, boxes, bounds, size, shape):
    """Whether triangles pass each voxel; some more voxels of wide ones."""
    marks = np.zeros(shape[0] * shape[1] * shape[2], dtype=np.bool_)
    span = np.empty(6, dtype=np.int64)
    for f in range(t.shape[0]):
        _cell_range(boxes, f, bounds, size, shape, span)
        if _n_voxel(span) > _WIDE:
            _mark_along_plane(x, t, f, bounds, size, shape, span, marks)
            continue
        for i in range(span[0], span[3] + 1):
            for j in range(span[1], span[4] + 1):
                for k in range(span[2], span[5] + 1):
                    marks[(i * shape[1] + j) * shape[2] + k] = True
    return marks


@entry("d2 l2 d1 d l1 b1 -> b1")
def have_marks(x, t, bounds, size, shape, marks):
    """Whether the box of each triangle reaches a marked voxel; wide ones inside the bounds do."""
    out = np.zeros(t.shape[0], dtype=np.bool_)
    box, span = np.empty((1, 6)), np.empty(6, dtype=np.int64)
    for f in range(t.shape[0]):
        meets = True
        for axis in range(3):
            p, q, r = x[t[f, 0], axis], x[t[f, 1], axis], x[t[f, 2], axis]
            box[0, axis], box[0, 3 + axis] = min(p, min(q, r)), max(p, max(q, r))
            meets &= box[0, axis] <= bounds[3 + axis] and bounds[axis] <= box[0, 3 + axis]
        if meets:
            _cell_range(box, 0, bounds, size, shape, span)
            out[f] = _n_voxel(span) > _WIDE or _has_mark(marks, shape, span)
    return out
