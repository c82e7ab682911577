"""Noise of data on a lattice, and the weight of noisy data against the smoothness of the surface.

Third differences are taken at steps of one node and more. Those of a smooth signal grow with the
cube of the step, those of noise do not: this separates the two.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.arrangement.threads import map_threads
from geosurf.kernels.lattices.third_differences import third_differences

ROWS = 400  # rows and columns that are looked at
STEPS = (1, 2, 4, 8)  # nodes
SEEN = 3.0  # variance of third differences, in those of noise, from which there is a signal
LOUD = 0.01  # cells: noise below this does not move a cut-off, data are then met exactly
# of the weight: docs/validation/torn_sheets.md has what 5 to 40 do on known worlds
GAIN = 10.0
# of the signal: noise below this leaves fourth differences, docs/decisions/0053 has what more does
FAINT = 0.15
LEAST = 1e-4  # weight: means over five cells, a third of the collar in which noise is smoothed


@dataclass(frozen=True)
class Noise:
    """Noise of the data of a horizon, and what follows for a solve.

    Attributes
    ----------
    deviation : float
        Standard deviation of the noise [m].
    weight : float or None
        Weight of data against the smoothness of the surface; None: data are met exactly.
    signal : float
        Typical third difference of the surface itself [m].
    highest : int
        Order of differences that is not exceeded, whatever data allow: 3 or 4.
    """

    deviation: float = 0.0
    weight: float | None = None
    signal: float = 0.0
    highest: int = 4

    @property
    def energy(self) -> float:
        """Energy of one standard deviation of noise; 0 for data that are met exactly."""
        return 0.0 if self.weight is None else self.weight * self.deviation**2

    @property
    def scale(self) -> float:
        """Cells over which noisy data are averaged; 1 for data that are met exactly."""
        return scale_of(self.weight)

    @property
    def order(self) -> int:
        """Of the highest differences that are small in the surface: 4 where data allow it, or 3."""
        is_exact = self.weight is None and self.deviation < FAINT * self.signal
        return min(4 if is_exact else 3, self.highest)


def noise_of(heights: np.ndarray) -> tuple[float, float]:
    """Standard deviation of noise, and typical third difference of the signal, of a grid [m]."""
    # Variance of third differences over 1 and 2 cells: noise gives both the same, a smooth
    # signal gives the second one 2**6 = 64 times as much.
    single, double = map_threads(_spread, [(heights, step) for step in STEPS[:2]])
    if not np.isfinite(double):
        return 0.0, 0.0
    signal = max((double - single) / 63.0, 0.0)
    noise = max(single - signal, 0.0)

    # wider steps see a faint signal under strong noise: it grows as step**6, noise does not
    for step in STEPS[1:]:
        now = double if step == STEPS[1] else _spread(heights, step)
        if np.isfinite(now):  # the first step at which the signal stands out measures it best
            signal = max((now - noise) / (step**6 - 1), 0.0)
            if now > SEEN * noise:
                break

    # a third difference of independent noise has 1 + 9 + 9 + 1 = 20 times its variance
    return float(np.sqrt(noise / 20.0)), float(np.sqrt(signal))


def signal_of(heights: np.ndarray) -> float:
    """Typical third difference of a grid that noise was taken out of [m], by its widest steps."""
    for step in STEPS[::-1]:
        spread = _spread(heights, step)
        if np.isfinite(spread):
            return float(np.sqrt(spread)) / step**3
    return 0.0


def _spread(heights: np.ndarray, step: int) -> float:
    """Variance of third differences over rows and columns, none of them across a hole."""
    # a sample of rows and columns is enough for two variances
    every = [max(n // ROWS, 1) for n in heights.shape]
    sizes = third_differences(heights, step, *every)
    if not len(sizes):
        return np.nan
    # medians, since data beside faults may have outliers: 1.4826 makes them deviations
    return float((1.4826 * np.median(sizes, overwrite_input=True)) ** 2)


def weight_of(noise: float, signal: float, cell: float) -> float | None:
    """Weight of noisy data against the smoothness of the sheet; None to meet them exactly.

    An average over h cells errs by about signal h^3 and noise / h. Both are equal at
    h^-6 = (signal / noise)^1.5, and h^-6 is the weight at which third differences average over h.
    """
    # the ratio of signal to noise sets over how many cells data are averaged
    if noise <= LOUD * cell:
        return None
    return float(np.clip(GAIN * (signal / noise) ** 1.5, LEAST, 1.0))


def scale_of(weight: float | None) -> float:
    """Cells over which data of a weight are averaged; 1 where they are met exactly."""
    return 1.0 if weight is None else weight ** (-1.0 / 6.0)
