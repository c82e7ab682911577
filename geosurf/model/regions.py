"""Places in the map near which a model is listed: boxes, a line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.kernels.lattices.sets import distinct
from geosurf.model.lattice import Lattice

_SLACK = 1e-9  # of the size of coordinates: far more than rounding


@dataclass(frozen=True, eq=False)
class Line:
    """
    A straight line without ends, from a through b.

    Examples
    --------
    >>> grid = Lattice(np.arange(4.0), np.arange(3.0), np.zeros((3, 4)))
    >>> Line(np.array([0.5, 0.0]), np.array([0.5, 9.0])).cells(grid).tolist()
    [0, 3]
    """

    a: np.ndarray
    b: np.ndarray

    def cells(self, lattice: Lattice) -> np.ndarray:
        """All cells that the line meets, and some next to it."""
        if lattice.easting.ndim == 2:
            return lattice.cells_where(self.meets)
        x, y = lattice.easting, lattice.northing
        rows = np.stack([np.minimum(y[:-1], y[1:]), np.maximum(y[:-1], y[1:])])
        west, east = self._span(*rows)
        turn = x[0] > x[-1]
        axis = -x if turn else x
        west, east = (-east, -west) if turn else (west, east)
        first = np.maximum(np.searchsorted(axis, west, side="left") - 1, 0)
        last = np.minimum(np.searchsorted(axis, east, side="right") - 1, len(x) - 2)
        n = np.maximum(last - first + 1, 0)
        row = np.repeat(np.arange(len(n)), n)
        start = np.cumsum(n) - n
        found: np.ndarray = row * (len(x) - 1) + np.arange(len(row)) + (first - start)[row]
        return found

    def meets(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Which boxes the line may meet."""
        west, east = self._span(low[:, 1], high[:, 1])
        mask: np.ndarray = (low[:, 0] <= east) & (high[:, 0] >= west)
        return mask

    def _span(self, south: np.ndarray, north: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """From west to east, where the line is between two northings; inside out if it is not."""
        (ax, ay), (dx, dy) = self.a, self.b - self.a
        slack = _SLACK * float(np.abs([self.a, self.b]).max() + 1.0)
        if dy == 0:
            there = (south - slack <= ay) & (north + slack >= ay)
            return np.where(there, -np.inf, np.inf), np.where(there, np.inf, -np.inf)
        one, two = ((y - ay) * (dx / dy) for y in (south - slack, north + slack))
        more = slack + _SLACK * np.maximum(np.abs(one), np.abs(two))
        return ax + np.minimum(one, two) - more, ax + np.maximum(one, two) + more


@dataclass(frozen=True, eq=False)
class Boxes:
    """
    Boxes in the map.

    Attributes
    ----------
    low, high : ndarray of float64, shape (n, 2)
        South-west and north-east corners [m]; may be infinite.
    """

    low: np.ndarray
    high: np.ndarray

    def cells(self, lattice: Lattice) -> np.ndarray:
        """All cells that meet a box."""
        if lattice.easting.ndim == 2:
            return lattice.cells_where(self.meets)
        found = [np.empty(0, dtype=np.int64)]
        for low, high in zip(self.low, self.high, strict=True):
            (cols, rows) = (
                _between(axis, low[k], high[k])
                for k, axis in enumerate((lattice.easting, lattice.northing))
            )
            found.append((rows[:, None] * (lattice.shape[1] - 1) + cols).reshape(-1))
        return distinct(*found)

    def meets(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Which boxes meet one of these."""
        mask = np.zeros(len(low), dtype=bool)
        for south_west, north_east in zip(self.low, self.high, strict=True):
            mask |= ((low <= north_east) & (high >= south_west)).all(axis=1)
        return mask


def _between(axis: np.ndarray, low: float, high: float) -> np.ndarray:
    """Cells along an axis that meet an interval."""
    ends = np.minimum(axis[:-1], axis[1:]), np.maximum(axis[:-1], axis[1:])
    return np.flatnonzero((ends[0] <= high) & (ends[1] >= low))
