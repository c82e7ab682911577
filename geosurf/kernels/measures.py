"""Volume below, areas and bounds of triangles and of runs of a lattice.

The volume between a triangle and a level is its area in the map times its mean height. Over a
closed shell these add up to the volume inside, if nothing is lost on the way: sums of runs are
kept as two numbers (Knuth's two-sum).

Rows of results, ten numbers: volume (two), area in the map, area, lower and upper corner.
Letters as in `strips`.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels._jit import entry, scalar
from geosurf.kernels.strips import FIRST, LAST, ROW, load
from geosurf.kernels.tree import RISING


@scalar
def _start(out, i):
    for k in range(4):
        out[i, k] = 0.0
    for k in range(3):
        out[i, 4 + k] = np.inf
        out[i, 7 + k] = -np.inf


@scalar
def _add(out, i, c, o, middle):
    """Add the triangle with corners c[o], c[o + 1], c[o + 2] (cyclic) to row i."""
    p, q = (o + 1) % 3, (o + 2) % 3
    ax, ay, az = c[p, 0] - c[o, 0], c[p, 1] - c[o, 1], c[p, 2] - c[o, 2]
    bx, by, bz = c[q, 0] - c[o, 0], c[q, 1] - c[o, 1], c[q, 2] - c[o, 2]
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    height = (c[o, 2] - middle[2]) + (c[p, 2] - middle[2]) + (c[q, 2] - middle[2])
    term = 0.5 * nz * (height / 3.0)
    total = out[i, 0] + term
    back = total - out[i, 0]
    out[i, 1] += (out[i, 0] - (total - back)) + (term - back)
    out[i, 0] = total
    out[i, 2] += 0.5 * nz
    out[i, 3] += 0.5 * np.sqrt(nx * nx + ny * ny + nz * nz)
    for k in range(3):
        out[i, 4 + k] = min(out[i, 4 + k], min(c[0, k], min(c[1, k], c[2, k])))
        out[i, 7 + k] = max(out[i, 7 + k], max(c[0, k], max(c[1, k], c[2, k])))


@entry("d2 l2 d1 -> d2")
def measure_triangles(x, t, middle):
    """One row for each triangle; the same whatever corner it starts at."""
    out = np.empty((t.shape[0], 10))
    c = np.empty((3, 3))
    for i in range(t.shape[0]):
        low = 0
        for corner in range(3):
            for k in range(3):
                c[corner, k] = x[t[i, corner], k]
            for k in range(3):
                if c[corner, k] != c[low, k]:
                    if c[corner, k] < c[low, k]:
                        low = corner
                    break
        _start(out, i)
        _add(out, i, c, low, middle)
    return out


@entry("d1 d1 d1 l1 l2 d1 -> d2")
def measure_runs(p, q, r, a, runs, middle):
    """One row for each run; triangles are taken as they come, not turned."""
    out = np.empty((runs.shape[0], 10))
    c = np.empty((3, 3))
    for i in range(runs.shape[0]):
        _start(out, i)
        row = runs[i, ROW]
        for place in range(runs[i, FIRST], runs[i, LAST] + 1):
            col = place >> 1
            half = place & 1 if a[RISING] == 0 else 1 - (place & 1)
            for corner in range(3):
                # corners 0, 1, 2, 3 around the cell: 0 1 2 + 0 2 3, or 0 1 3 + 1 2 3
                at = corner + (half if a[RISING] == 0 or corner > 0 else 0)
                if a[RISING] == 0 and half == 0 and corner == 2:
                    at = 3
                u = row + (1 if at >= 2 else 0)
                v = col + (1 if at == 1 or at == 2 else 0)
                c[corner, 0], c[corner, 1] = load(p, a, 0, u, v), load(q, a, 1, u, v)
                c[corner, 2] = load(r, a, 2, u, v)
            _add(out, i, c, 0, middle)
    return out
