"""What a certificate adds up over triangles, in passes without copies of their corners.

What a pass finds of a triangle is added at once, where it belongs: a table of all of it would be
the largest array of a certificate.

Notation
    x    vertices, float64 (n_vertex, 3)
    t    triangles, int64 (n, 3)
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.run_checks import two_sum


@scalar
def _steps(x, i, j):
    """Sum of the steps along the axes from one vertex to another."""
    return abs(x[j, 0] - x[i, 0]) + abs(x[j, 1] - x[i, 1]) + abs(x[j, 2] - x[i, 2])


@scalar
def _normal(x, a, b, c):
    """Normal of a triangle, as long as twice its area."""
    ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    vx, vy, vz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


@entry("d2 l2 l1 d1 d1 d1* b1* -> .")
def rises_of_triangles(x, t, surface, lower, upper, rise, within):
    """Write whether each triangle lies in a box. If so, add twice its area in the map, below 0
    where it looks down, to that of its surface.
    """
    for i in range(t.shape[0]):
        a, b, c = t[i, 0], t[i, 1], t[i, 2]
        inside = True
        for k in range(3):
            low = min(min(x[a, k], x[b, k]), x[c, k])
            high = max(max(x[a, k], x[b, k]), x[c, k])
            inside = inside and low >= lower[k] and high <= upper[k]
        within[i] = inside
        if inside:
            rise[surface[i]] += _normal(x, a, b, c)[2]


@entry("d2 l2 -> d1 d1")
def sizes_of_triangles(x, t):
    """Twice the area of each triangle, and all its sides (in the norm of absolute values)."""
    area, around = np.empty(t.shape[0]), np.empty(t.shape[0])
    for i in range(t.shape[0]):
        a, b, c = t[i, 0], t[i, 1], t[i, 2]
        nx, ny, nz = _normal(x, a, b, c)
        area[i] = np.sqrt(nx * nx + ny * ny + nz * nz)
        ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
        vx, vy, vz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
        three = abs(ux - vx) + abs(uy - vy) + abs(uz - vz)
        around[i] = _steps(x, a, b) + _steps(x, a, c) + three
    return area, around


@entry("d2 l2 d l2 d2* -> .")
def add_triangles_to_units(x, t, level, sides, out):
    """Add triangles to the sums of the units that they bound, as `run_checks.add_to_units` does
    for runs. Volumes are measured from an elevation, `level`.
    """
    for i in range(t.shape[0]):
        if sides[i, 0] == sides[i, 1]:
            continue
        a, b, c = t[i, 0], t[i, 1], t[i, 2]
        nx, ny, nz = _normal(x, a, b, c)
        height = (x[a, 2] - level) + (x[b, 2] - level) + (x[c, 2] - level)
        area = np.sqrt(nx * nx + ny * ny + nz * nz)
        products = _steps(x, a, b) * _steps(x, a, c)
        for s in range(2):
            unit = sides[i, s]
            if unit < 0:
                continue
            two_sum(out, unit, 0, nz * height if s == 1 else -(nz * height))
            two_sum(out, unit, 2, area)
            out[unit, 4] += products
            out[unit, 5] += 1.0
