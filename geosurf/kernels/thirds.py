"""Third differences of a grid, along some of its rows and columns, none of them across a hole."""

from __future__ import annotations

import numpy as np

from geosurf.kernels._jit import entry, scalar


@scalar
def _along(line, n, step, out, count):
    """Sizes of the third differences of a line of n heights, where none is missing between."""
    whole = 0  # heights without a hole up to here
    for k in range(n):
        whole = 0 if np.isnan(line[k]) else whole + 1
        if whole > 3 * step:
            a, b, c = line[k - 3 * step], line[k - 2 * step], line[k - step]
            out[count] = abs((line[k] - a) - 3.0 * (c - b))
            count += 1
    return count


@entry("d2 l l l -> d1")
def third_differences(heights, step, every_row, every_col):
    """Sizes |d - 3 c + 3 b - a| of heights a, b, c, d, `step` nodes apart."""
    n_row, n_col = heights.shape
    rows, cols = (n_row - 1) // every_row + 1, (n_col - 1) // every_col + 1
    out = np.empty(rows * max(n_col - 3 * step, 0) + cols * max(n_row - 3 * step, 0))
    line = np.empty(max(n_row, n_col))
    count = 0
    for i in range(rows):
        for j in range(n_col):
            line[j] = heights[i * every_row, j]
        count = _along(line, n_col, step, out, count)
    for j in range(cols):
        for i in range(n_row):
            line[i] = heights[i, j * every_col]
        count = _along(line, n_row, step, out, count)
    return out[:count].copy()
