"""Voxels that lie in one unit: most points of a model need no search.

A voxel that no surface meets lies in one unit as a whole, or outside the model. The voxel of a
coordinate never falls where the coordinate rises, whatever rounding does, so a voxel holds all
floating-point numbers between two, along each axis, and the first and the last one reach to
infinity. A triangle has no point in a voxel that is outside the range of voxels of its corners.

Notation
    grid      lowest coordinate, then voxels per metre, along each axis, float64 (6,)
    shape     number of voxels along each axis, int64 (3,)
    met       whether a surface may meet a voxel, bool (n_voxel,); the last axis runs fastest
    slip      by how much a point between corners may be off, through rounding [m]
    words     what each voxel holds, four in one int64, so that all stay in the cache: the row of
              the unit plus 2, 1 outside the model, 0 where a surface may meet the voxel or the row
              is above `MOST_ROWS`
    others    as in `lattice_units` and `triangle_bins`
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.strips import load
from geosurf.kernels.location.lattice_units import corner_nodes
from geosurf.kernels.search.tree import N_COL, N_ROW

OPEN = -2
MOST_ROWS = (1 << 15) - 3  # bits 0 to 14 of a part of a word: no sign comes in the way
_DEPTH = 64  # halvings of a triangle: each second one halves its longest edge
_SMALL = 0.5  # voxels: pieces with shorter edges are not halved any more


@scalar
def _voxel(value, grid, shape, k):
    """Voxel of a coordinate along axis k."""
    return int(min(max((value - grid[k]) * grid[3 + k], 0.0), shape[k] - 1.0))


@scalar
def _range(s, row, k, slip, grid, shape):
    """First and last voxel of a triangle along axis k."""
    a, b, c = s[row, k], s[row, 3 + k], s[row, 6 + k]
    first = _voxel(min(a, min(b, c)) - slip, grid, shape, k)
    return first, _voxel(max(a, max(b, c)) + slip, grid, shape, k)


@scalar
def _length(s, row, a, b, grid):
    """Square of the length of the edge between two corners [voxels]."""
    total = 0.0
    for k in range(3):
        d = (s[row, 3 * b + k] - s[row, 3 * a + k]) * grid[3 + k]
        total += d * d
    return total


@scalar
def _mark(s, slip, grid, shape, met):
    """Mark the voxels that the triangle in row 0 of the scratch may meet.

    A triangle that spans many voxels is cut in two at the middle of its longest edge.
    """
    n = 1
    while n > 0:
        n -= 1
        # corners are exact; points in the middle of edges are rounded
        x0, x1 = _range(s, n, 0, slip, grid, shape)
        y0, y1 = _range(s, n, 1, slip, grid, shape)
        z0, z1 = _range(s, n, 2, slip, grid, shape)
        lengths = (
            _length(s, n, 0, 1, grid),
            _length(s, n, 1, 2, grid),
            _length(s, n, 2, 0, grid),
        )
        longest = max(lengths[0], max(lengths[1], lengths[2]))
        n_met = (x1 - x0 + 1) * (y1 - y0 + 1) * (z1 - z0 + 1)
        if n_met <= 2 or longest <= _SMALL * _SMALL or n + 2 > _DEPTH:
            for i in range(x0, x1 + 1):
                for j in range(y0, y1 + 1):
                    for k in range(z0, z1 + 1):
                        met[(i * shape[1] + j) * shape[2] + k] = True
            continue

        # both halves take the middle of the longest edge in place of one of its ends
        a = 0 if lengths[0] == longest else (1 if lengths[1] == longest else 2)
        b = (a + 1) % 3
        for k in range(9):
            s[n + 1, k] = s[n, k]
        for k in range(3):
            middle = 0.5 * (s[n, 3 * a + k] + s[n, 3 * b + k])
            s[n, 3 * b + k] = middle
            s[n + 1, 3 * a + k] = middle
        n += 2


@entry("d2 d d1 l1 b1* -> .")
def mark_triangles(c, slip, grid, shape, met):
    """Mark the voxels that triangles may meet."""
    s = np.empty((_DEPTH, 9))
    for t in range(c.shape[0]):
        for k in range(9):
            s[0, k] = c[t, k]
        _mark(s, slip, grid, shape, met)


@entry("d1 d1 l1 d2 l1 l2 d d1 l1 b1* -> .")
def mark_lattice(x, y, a, z, column, steps, slip, grid, shape, met):
    """Mark the voxels that the whole cells of gridded surfaces may meet."""
    s = np.empty((_DEPTH, 9))
    for i in range(a[N_ROW] - 1):
        for j in range(a[N_COL] - 1):
            for half in range(2):
                of = column[2 * (i * (a[N_COL] - 1) + j) + half]
                if of == 0:  # no surface of the group is whole here
                    continue
                i0, j0, i1, j1, i2, j2 = corner_nodes(a, i, j, half)
                for surface in range(steps.shape[1]):
                    if steps[of, surface] == 0:
                        continue
                    s[0, 0], s[0, 1] = load(x, a, 0, i0, j0), load(y, a, 1, i0, j0)
                    s[0, 3], s[0, 4] = load(x, a, 0, i1, j1), load(y, a, 1, i1, j1)
                    s[0, 6], s[0, 7] = load(x, a, 0, i2, j2), load(y, a, 1, i2, j2)
                    s[0, 2] = z[i0 * a[N_COL] + j0, surface]
                    s[0, 5] = z[i1 * a[N_COL] + j1, surface]
                    s[0, 8] = z[i2 * a[N_COL] + j2, surface]
                    _mark(s, slip, grid, shape, met)


@entry("l1 l1* -> .")
def pack_voxels(inside, words):
    """Write the units of voxels as words; they are -1 outside the model, `OPEN` at surfaces."""
    for v in range(inside.shape[0]):
        code = inside[v] - OPEN if inside[v] <= MOST_ROWS else 0
        words[v >> 2] |= code << (16 * (v & 3))


@entry("d2 d1 d1 l1 l1 l1* l1* -> l")
def units_of_voxels(p, origin, grid, shape, words, unit, others):
    """Write the unit of each point whose voxel has one; list the others, and return their number.

    `p` has world coordinates (n, 3). `unit` and `others` have room for one more than all points.
    """
    n = 0
    for q in range(p.shape[0]):
        i = _voxel(p[q, 0] - origin[0], grid, shape, 0)
        j = _voxel(p[q, 1] - origin[1], grid, shape, 1)
        k = _voxel(p[q, 2] - origin[2], grid, shape, 2)
        v = (i * shape[1] + j) * shape[2] + k
        found = ((words[v >> 2] >> (16 * (v & 3))) & 0x7FFF) + OPEN
        unit[q] = found
        others[n] = q
        n += found == OPEN
    return n
