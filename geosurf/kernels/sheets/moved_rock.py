"""Places of faults and of beds, for each particle of rock that throw moves.

The same sums in the same order as numpy would do them, one particle at a time: numpy makes twenty
arrays for each of these questions, which take most of its time.

Notation
    table     a fault across strike, over its length and its height, float64 (n_s, n_z)
    s, z      places along strike and elevations [m]
    u, v      rows and columns of the table
    grid      elevations of the horizon before it was moved, float64 (n_row, n_col)
    x, y      columns and rows of places in it
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar


@scalar
def _bilinear(table, u, v):
    """Value of a table at row u and column v, which may be broken and lie within it."""
    i = min(int(u), table.shape[0] - 2)
    j = min(int(v), table.shape[1] - 2)
    f, g = u - i, v - j
    lower = table[i, j] * (1.0 - f) + table[i + 1, j] * f
    upper = table[i, j + 1] * (1.0 - f) + table[i + 1, j + 1] * f
    return lower * (1.0 - g) + upper * g


@entry("d2 d1 d1 d1 -> .")
def values_in_table(table, u, v, out):
    """Write the values of a table at broken rows and columns."""
    for k in range(u.shape[0]):
        out[k] = _bilinear(table, u[k], v[k])


@entry("d2 d d d d d1 d1 d1 -> .")
def across_fault(table, low, high, length, slope, s, z, out):
    """Write where a fault is across strike: straight on past its ends, sloping on beyond."""
    n_s, n_z = table.shape
    for k in range(s.shape[0]):
        within = min(max(z[k], low), high)
        u = min(max(s[k] / length, 0.0), 1.0) * (n_s - 1)
        v = (within - low) / (high - low) * (n_z - 1)
        out[k] = _bilinear(table, u, v) + slope * (z[k] - within)


@entry("d2 b d1 d1 d1 -> .")
def heights_on_triangles(grid, rising, x, y, out):
    """Write elevations of the triangles of a grid; those at its rim go on beyond it."""
    n_row, n_col = grid.shape
    for k in range(x.shape[0]):
        j = int(min(max(np.floor(x[k]), 0.0), n_col - 2.0))
        i = int(min(max(np.floor(y[k]), 0.0), n_row - 2.0))
        f, g = x[k] - j, y[k] - i

        # corners a b c d anticlockwise, a at the lower left; a node comes back bit for bit
        if rising:  # a joins c
            base = grid[i, j]
            large, small = max(f, g), min(f, g)
            middle = grid[i, j + 1] if f >= g else grid[i + 1, j]
            first, second = large - small, small
            one, two = middle - base, grid[i + 1, j + 1] - base
        else:
            low = f + g <= 1.0
            base = grid[i, j] if low else grid[i + 1, j + 1]
            first = f if low else 1 - g
            second = g if low else 1 - f
            one, two = grid[i, j + 1] - base, grid[i + 1, j] - base
        out[k] = base + first * one + second * two
