"""Candidate pairs of triangles that are far larger than the others: only those along their plane.

The box of a wall of a model covers the whole map, although the wall is a plane. So voxels that its
plane misses are skipped, and so are triangles that are certainly separated from it (`separation`).
Floats decide, with rounding bounds on the safe side: no pair that is left out can meet.

The voxels are those of `voxels`, filled with the triangles that are not large.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.search.separation import (
    ROUNDING,
    is_beside_plane,
    plane_of,
    separated_triangles,
)
from geosurf.kernels.search.tree import boxes_apart
from geosurf.kernels.search.voxels import _cell_range

LARGER = 1.0 + 1e-6  # voxels are enlarged a little, on the safe side


@scalar
def _misses(p, bounds, size, i, j, k):
    """Whether a plane certainly misses a voxel."""
    # Distance of the centre from the plane against the half-diagonal along its normal.
    h = 0.5 * size * LARGER
    s = reach = 0.0
    for axis in range(3):
        at = i if axis == 0 else (j if axis == 1 else k)
        d = bounds[axis] + (at + 0.5) * size - p[6 + axis]
        s += p[axis] * d
        # The half-diagonal along the normal, and the rounding of the plane.
        reach += abs(p[axis]) * h + ROUNDING * p[3 + axis] * (abs(d) + h)
    return abs(s) > reach


@scalar
def _steepest(p):
    """The axis along which a normal is longest."""
    axis = 0
    for k in range(1, 3):
        if abs(p[k]) > abs(p[axis]):
            axis = k
    return axis


@scalar
def _passed(p, bounds, size, axis, at, span):
    """First and last voxel along an axis that a plane may pass, given the two other indices in
    `at`; a few more, and all of `span` where the plane has no direction.
    """
    first, last = span[axis], span[3 + axis]
    if not abs(p[axis]) > 0.0:
        return first, last
    h = 0.5 * size * LARGER
    s, reach = 0.0, 0.0
    for k in range(3):
        # the farthest voxel along the axis bounds the rounding of all of them
        d = bounds[k] + (at[k] + 0.5) * size - p[6 + k]
        far = abs(d)
        if k == axis:
            far = abs(bounds[k] - p[6 + k]) + (last + 1) * size
        else:
            s += p[k] * d
        reach += abs(p[k]) * h + 4.0 * ROUNDING * p[3 + k] * (far + h)

    # |s + normal * d| <= reach, as an interval of d; then of voxels, one more at each end
    middle = (-s / p[axis] + p[6 + axis] - bounds[axis]) / size - 0.5
    half = reach / (abs(p[axis]) * size) + 1.0
    if not (abs(middle) < 1e9 and half < 1e9):
        return first, last
    return max(first, int(np.floor(middle - half))), min(last, int(np.ceil(middle + half)))


@scalar
def _is_beside(x, t, f, p, bounds, size, axis, at):
    """Whether a triangle, seen along an axis, certainly misses a column of voxels.

    Wide triangles are often slivers across their box: a side of them parts them from most of it.
    """
    u, v = (axis + 1) % 3, (axis + 2) % 3
    h = 0.5 * size * LARGER
    pu, pv = bounds[u] + (at[u] + 0.5) * size, bounds[v] + (at[v] + 0.5) * size
    turn = 1.0 if p[axis] > 0.0 else -1.0
    for i in range(3):
        one, two = t[f, i], t[f, (i + 1) % 3]
        du, dv = x[two, u] - x[one, u], x[two, v] - x[one, v]
        eu, ev = pu - x[one, u], pv - x[one, v]
        reach = (abs(du) + abs(dv)) * h
        reach += ROUNDING * (abs(du) * (abs(ev) + h) + abs(dv) * (abs(eu) + h))
        if turn * (du * ev - dv * eu) < -reach:
            return True
    return False


@scalar
def _append(pairs, n, a, b):
    """Append a pair, lower row first; the array, twice as long where it was full, and the count."""
    if n == pairs.shape[0]:
        pairs = np.concatenate((pairs, np.empty_like(pairs)))
    pairs[n, 0], pairs[n, 1] = min(a, b), max(a, b)
    return pairs, n + 1


@entry("d2 l2 d2 l1 d1 d l1 l1 l1 -> l2")
def large_triangle_pairs(x, t, boxes, large, bounds, size, shape, offsets, filled):
    """Pairs (n, 2) of large triangles with others that may meet; lower row first, each once."""
    pairs = np.empty((64, 2), dtype=np.int64)
    n = 0
    # The last large triangle that each triangle was compared with.
    seen = np.full(t.shape[0], -1, dtype=np.int64)
    span, cell = np.empty(6, dtype=np.int64), np.zeros(3, dtype=np.int64)
    p, common = np.empty(9), np.empty((2, 9), dtype=np.int64)
    for r in range(large.shape[0]):
        a = large[r]
        plane_of(x, t, a, p)

        # Large triangles among each other: all pairs.
        for other in range(r):
            if not (
                boxes_apart(boxes, a, boxes, large[other])
                or is_beside_plane(x, t, p, a, large[other])
                or separated_triangles(x, t, a, large[other], common)
            ):
                pairs, n = _append(pairs, n, a, large[other])

        # The others: only in voxels that the plane passes.
        # The box of a large triangle covers many voxels, its plane passes few of them.
        _cell_range(boxes, a, bounds, size, shape, span)
        axis = _steepest(p)
        u, v = (axis + 1) % 3, (axis + 2) % 3
        sharp = abs(p[axis]) > ROUNDING * p[3 + axis]  # else its sides may turn either way
        for one in range(span[u], span[3 + u] + 1):
            for two in range(span[v], span[3 + v] + 1):
                cell[u], cell[v] = one, two
                if sharp and _is_beside(x, t, a, p, bounds, size, axis, cell):
                    continue
                low, high = _passed(p, bounds, size, axis, cell, span)
                for three in range(low, high + 1):
                    cell[axis] = three
                    i, j, k = cell[0], cell[1], cell[2]
                    voxel = (i * shape[1] + j) * shape[2] + k
                    first, last = offsets[voxel], offsets[voxel + 1]
                    if first == last or _misses(p, bounds, size, i, j, k):
                        continue
                    for at in range(first, last):
                        b = filled[at]

                        # A triangle fills several voxels; it is tested once.
                        if seen[b] == a:
                            continue
                        seen[b] = a
                        if not (
                            boxes_apart(boxes, a, boxes, b)
                            or is_beside_plane(x, t, p, a, b)
                            or separated_triangles(x, t, a, b, common)
                        ):
                            pairs, n = _append(pairs, n, a, b)
    return pairs[:n].copy()
