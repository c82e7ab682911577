"""How noisy are data on a lattice, and how hard may a sheet be held to them?

Third differences at steps of one and of two nodes: those of a smooth signal grow eightfold, those
of noise do not, so that the two can be told apart.
"""

from __future__ import annotations

import numpy as np

ROWS = 400  # rows and columns that are looked at
LOUD = 0.01  # cells: noise below this does not move a cut-off, data are then met exactly
GAIN = 10.0


def noise_of(heights: np.ndarray) -> tuple[float, float]:
    """Standard deviation of noise, and rms third difference of the signal, of a grid [m]."""
    squares: list[list[np.ndarray]] = [[], []]
    for grid in (heights, heights.T):
        part = grid[:: max(len(grid) // ROWS, 1)]
        for k, step in enumerate((1, 2)):
            if part.shape[1] > 3 * step:
                a, b, c, d = (part[:, i * step : part.shape[1] - (3 - i) * step] for i in range(4))
                third = (d - a) - 3.0 * (c - b)
                squares[k].append(third[np.isfinite(third)])
    if not squares[1] or not len(squares[1][0]):
        return 0.0, 0.0
    # medians, since the data left beside faults may have outliers: 1.4826 makes them deviations
    near, far = ((1.4826 * np.median(np.abs(np.concatenate(s)))) ** 2 for s in squares)
    signal = max((far - near) / 63.0, 0.0)
    return float(np.sqrt(max(near - signal, 0.0) / 20.0)), float(np.sqrt(signal))


def weight_of(noise: float, signal: float, cell: float) -> float | None:
    """Weight of noisy data against the smoothness of the sheet; None to meet them exactly."""
    if noise <= LOUD * cell:
        return None
    return float(np.clip(GAIN * (signal / noise) ** 2, 1e-3, 1.0))
