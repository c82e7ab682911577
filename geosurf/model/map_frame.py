"""Steps of a grid with 2-D coordinates in the map, and how far nodes are from even ones."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class MapFrame:
    """
    What one pass over eastings and northings proves of a grid.

    Attributes
    ----------
    height : float
        No triangle is lower in the map [m], and none folds over another; 0: nothing is proven.
    column, row : (float, float)
        Mean steps to the next column and to the next row [m].
    off : float
        No node is farther from the first one and mean steps [m]; infinite where nothing is proven.

    Examples
    --------
    >>> MapFrame(10.0, (40.0, 30.0), (-30.0, 40.0), 1e-9).least_step
    (49.999999998, 49.999999998)
    """

    height: float
    column: tuple[float, float]
    row: tuple[float, float]
    off: float

    @classmethod
    def of(cls, found: np.ndarray) -> MapFrame:
        """Make one of what `geosurf.kernels.contacts.aligned_grids.map_frame` returns."""
        height, ux, uy, vx, vy, off = found.tolist()
        return cls(height, (ux, uy), (vx, vy), off)

    @property
    def determinant(self) -> float:
        """Of both steps, columns first [m2]."""
        return self.column[0] * self.row[1] - self.column[1] * self.row[0]

    @property
    def least_step(self) -> tuple[float, float]:
        """No step along columns, and along rows, is shorter [m]; below 0: nothing is proven."""
        return math.hypot(*self.column) - 2.0 * self.off, math.hypot(*self.row) - 2.0 * self.off
