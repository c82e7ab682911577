"""Which triangles are near one that is far wider than the others? Those along its plane.

A wall of a model fills the box of a whole map with its own, although it is a sheet. So voxels that
its plane misses are passed over, and triangles that are surely apart from it (`apart`). Floats
decide, with a bound of their rounding to the safe side: what is left out cannot meet.

Voxels are those of `geosurf.kernels.search.voxels`, filled with the triangles that are not wide.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.search.separation import separated_triangles
from geosurf.kernels.search.tree import boxes_apart
from geosurf.kernels.search.voxels import _cell_range

ROUNDING = 1e-14  # of sums of three products of differences, relative: 45 units in the last place
LARGER = 1.0 + 1e-6  # voxels are taken a little larger than they are


@scalar
def _plane(x, t, f, p):
    """Normal of a triangle in p[0:3], bounds of its parts in p[3:6], a corner in p[6:9]."""
    a, b, c = t[f, 0], t[f, 1], t[f, 2]
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        one = (x[b, i] - x[a, i]) * (x[c, j] - x[a, j])
        two = (x[b, j] - x[a, j]) * (x[c, i] - x[a, i])
        p[k] = one - two
        p[3 + k] = abs(one) + abs(two)
        p[6 + k] = x[a, k]


@scalar
def _misses(p, bounds, size, i, j, k):
    """Whether a plane passes a voxel by."""
    h = 0.5 * size * LARGER
    s = reach = 0.0
    for axis in range(3):
        at = i if axis == 0 else (j if axis == 1 else k)
        d = bounds[axis] + (at + 0.5) * size - p[6 + axis]
        s += p[axis] * d
        reach += abs(p[axis]) * h + ROUNDING * p[3 + axis] * (abs(d) + h)
    return abs(s) > reach


@scalar
def _append(pairs, n, a, b):
    """Append a pair, lower row first; the array, twice as long where it was full, and the count."""
    if n == pairs.shape[0]:
        pairs = np.concatenate((pairs, np.empty_like(pairs)))
    pairs[n, 0], pairs[n, 1] = min(a, b), max(a, b)
    return pairs, n + 1


@entry("d2 l2 d2 l1 d1 d l1 l1 l1 -> l2")
def large_triangle_pairs(x, t, boxes, large, bounds, size, shape, offsets, filled):
    """Pairs (n, 2) of wide triangles and others, not surely apart; lower row first, each once."""
    pairs = np.empty((64, 2), dtype=np.int64)
    n = 0
    seen = np.full(t.shape[0], -1, dtype=np.int64)
    span = np.empty(6, dtype=np.int64)
    p, common = np.empty(9), np.empty((2, 9), dtype=np.int64)
    for r in range(large.shape[0]):
        a = large[r]
        _plane(x, t, a, p)
        for s in range(r):
            if not (
                boxes_apart(boxes, a, boxes, large[s])
                or separated_triangles(x, t, a, large[s], common)
            ):
                pairs, n = _append(pairs, n, a, large[s])
        _cell_range(boxes, a, bounds, size, shape, span)
        for i in range(span[0], span[3] + 1):
            for j in range(span[1], span[4] + 1):
                for k in range(span[2], span[5] + 1):
                    c = (i * shape[1] + j) * shape[2] + k
                    if offsets[c] == offsets[c + 1] or _misses(p, bounds, size, i, j, k):
                        continue
                    for at in range(offsets[c], offsets[c + 1]):
                        b = filled[at]
                        if seen[b] == a:
                            continue
                        seen[b] = a
                        if not (
                            boxes_apart(boxes, a, boxes, b)
                            or separated_triangles(x, t, a, b, common)
                        ):
                            pairs, n = _append(pairs, n, a, b)
    return pairs[:n].copy()
