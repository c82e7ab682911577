"""Third differences of a grid, along some of its rows and columns, none of them across a hole."""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry


@entry("d2 l l l -> d1")
def third_differences(heights, step, every_row, every_col):
    """Absolute values |d - 3 c + 3 b - a| of heights a, b, c, d, `step` nodes apart, in any order.

    Columns are evaluated row by row too, in memory order.
    """
    n_row, n_col = heights.shape
    rows, cols = (n_row - 1) // every_row + 1, (n_col - 1) // every_col + 1
    # A line of n nodes has n - 3 step differences, fewer where it has holes.
    out = np.empty(rows * max(n_col - 3 * step, 0) + cols * max(n_row - 3 * step, 0))
    whole = np.zeros(cols, dtype=np.int64)  # heights without a hole up to here
    one, two, three = step, 2 * step, 3 * step
    count = 0
    for i in range(n_row):
        # Along the row: count consecutive nodes without a hole.
        if i % every_row == 0:
            along = 0
            for j in range(n_col):
                d = heights[i, j]
                along = 0 if np.isnan(d) else along + 1
                if along > three:
                    a, b, c = heights[i, j - three], heights[i, j - two], heights[i, j - one]
                    out[count] = abs((d - a) - 3.0 * (c - b))
                    count += 1

        # Along the columns: one count per column.
        for k in range(cols):
            j = k * every_col
            d = heights[i, j]
            whole[k] = 0 if np.isnan(d) else whole[k] + 1
            if whole[k] > three:
                a, b, c = heights[i - three, j], heights[i - two, j], heights[i - one, j]
                out[count] = abs((d - a) - 3.0 * (c - b))
                count += 1
    return out[:count].copy()
