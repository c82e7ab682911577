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
    for i in range(runs.shape[0]):
        row = runs[i, ROW]
        high = low = flat = area = 0.0
        west = south = bottom = np.inf
        east = north = top = -np.inf
        for place in range(runs[i, FIRST], runs[i, LAST] + 1):
            col = place >> 1
            half = place & 1 if a[RISING] == 0 else 1 - (place & 1)
            # corners 0, 1, 2, 3 around the cell: 0 1 2 + 0 2 3, or 0 1 3 + 1 2 3
            v0 = col + (half if a[RISING] == 0 else 0)
            u1 = row + half
            u2 = row + 1
            v2 = col + 1 if a[RISING] == 1 and half == 0 else col
            x0, y0, z0 = load(p, a, 0, row, v0), load(q, a, 1, row, v0), load(r, a, 2, row, v0)
            x1, y1 = load(p, a, 0, u1, col + 1), load(q, a, 1, u1, col + 1)
            z1 = load(r, a, 2, u1, col + 1)
            x2, y2, z2 = load(p, a, 0, u2, v2), load(q, a, 1, u2, v2), load(r, a, 2, u2, v2)
            ax, ay, az = x1 - x0, y1 - y0, z1 - z0
            bx, by, bz = x2 - x0, y2 - y0, z2 - z0
            nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
            height = (z0 - middle[2]) + (z1 - middle[2]) + (z2 - middle[2])
            term = 0.5 * nz * (height / 3.0)
            total = high + term
            back = total - high
            low += (high - (total - back)) + (term - back)
            high = total
            flat += 0.5 * nz
            area += 0.5 * np.sqrt(nx * nx + ny * ny + nz * nz)
            west, east = min(west, min(x0, min(x1, x2))), max(east, max(x0, max(x1, x2)))
            south, north = min(south, min(y0, min(y1, y2))), max(north, max(y0, max(y1, y2)))
            bottom, top = min(bottom, min(z0, min(z1, z2))), max(top, max(z0, max(z1, z2)))
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = high, low, flat, area
        out[i, 4], out[i, 5], out[i, 6] = west, south, bottom
        out[i, 7], out[i, 8], out[i, 9] = east, north, top
    return out
