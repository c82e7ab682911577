"""What a certificate adds up over triangles, in one pass without copies of their corners.

Notation
    x    vertices, float64 (n_vertex, 3)
    t    triangles, int64 (n, 3)
    out  the first columns of `geosurf.kernels.lattices.run_checks.sums_of_runs`, float64 (n, 8)
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar


@scalar
def _steps(x, i, j):
    """Sum of the steps along the axes from one vertex to another."""
    return abs(x[j, 0] - x[i, 0]) + abs(x[j, 1] - x[i, 1]) + abs(x[j, 2] - x[i, 2])


@entry("d2 l2 d d1 d1 d2 b1 ->")
def facts_of_triangles(x, t, level, lower, upper, out, within):
    """Fill the columns of all triangles, and whether each lies in a box.

    Columns 1 and 3, of second sums, stay as they are. Boxes of triangles would be as large as all
    columns, so they are compared here.
    """
    for i in range(t.shape[0]):
        a, b, c = t[i, 0], t[i, 1], t[i, 2]
        ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
        vx, vy, vz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        height = (x[a, 2] - level) + (x[b, 2] - level) + (x[c, 2] - level)
        one, two = _steps(x, a, b), _steps(x, a, c)
        three = abs(ux - vx) + abs(uy - vy) + abs(uz - vz)

        # six volumes below it down to the level, twice its area, sizes of rounding errors
        out[i, 0] = nz * height
        out[i, 2] = np.sqrt(nx * nx + ny * ny + nz * nz)
        out[i, 4] = one * two
        out[i, 5] = one + two + three
        out[i, 6] = nz
        out[i, 7] = 1.0
        inside = True
        for k in range(3):
            low = min(min(x[a, k], x[b, k]), x[c, k])
            high = max(max(x[a, k], x[b, k]), x[c, k])
            inside = inside and low >= lower[k] and high <= upper[k]
        within[i] = inside
