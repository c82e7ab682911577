"""Places in the map near which a model is listed: vertical lines, boxes, a line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.kernels.lattices.sets import distinct
from geosurf.model.chunked import ChunkedLattice
from geosurf.model.chunked_map import ChunkedMap
from geosurf.model.lattice import Lattice

_SLACK = 1e-9  # of the size of coordinates: far more than rounding
_ROUNDING = 2.0**-48  # of the largest coordinate: more than rounding moves a foot


@dataclass(frozen=True, eq=False)
class Feet:
    """
    Vertical lines.

    Attributes
    ----------
    places : ndarray of float64, shape (n, 2)
        Easting and northing [m].

    Examples
    --------
    A line through a node is near all four cells around it.

    >>> grid = Lattice(np.arange(4.0), np.arange(3.0), np.zeros((3, 4)))
    >>> Feet(np.array([[1.0, 1.0], [2.5, 0.5], [9.0, 9.0]])).cells(grid).tolist()
    [0, 1, 2, 3, 4]
    """

    places: np.ndarray

    @classmethod
    def rounded(cls, places: np.ndarray) -> Feet:
        """Lines at places whose local coordinates are rounded: some around each of them.

        Examples
        --------
        >>> grid = Lattice(np.arange(4.0), np.arange(3.0), np.zeros((3, 4)))
        >>> Feet.rounded(np.array([[1.0 + 1e-15, 0.5]])).cells(grid).tolist()
        [0, 1]
        """
        slack = _ROUNDING * float(np.abs(places).max(initial=0.0))
        around = [(-slack, -slack), (-slack, slack), (slack, -slack), (slack, slack)]
        return cls(np.concatenate([places + np.array(to) for to in around]))

    def cells(self, lattice: Lattice) -> np.ndarray:
        """All cells that a line goes through, their rims included."""
        if isinstance(lattice, ChunkedLattice) and lattice.moved is not None:
            return distinct(self.cells(lattice.unmoved), lattice.moved.cells(lattice.shape))
        if isinstance(lattice, ChunkedMap):
            return lattice.cells_around(self.places)
        if lattice.easting.ndim == 2:
            return lattice.cells_where(self._are_in)
        n_col = lattice.shape[1]
        ranges = []
        for axis, values in ((lattice.northing, 1), (lattice.easting, 0)):
            x, turn = self.places[:, values], axis[0] > axis[-1]
            axis = -axis if turn else axis
            x = -x if turn else x
            low = np.searchsorted(axis, x, side="left") - 1
            high = np.searchsorted(axis, x, side="right") - 1
            ranges.append((np.maximum(low, 0), np.minimum(high, len(axis) - 2)))
        (south, north), (west, east) = ranges
        found = []
        for i in (0, 1):  # on a node the cell before it and that behind it
            for j in (0, 1):
                row, col = south + i, west + j
                some = (row <= north) & (col <= east)
                found.append(row[some] * (n_col - 1) + col[some])
        return distinct(*found)

    def meets(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Which boxes meet the box around all lines."""
        if not len(self.places):
            return np.zeros(len(low), dtype=bool)
        mask: np.ndarray = (
            (low <= self.places.max(axis=0)) & (high >= self.places.min(axis=0))
        ).all(axis=1)
        return mask

    def _are_in(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Which boxes a line goes through, their rims included."""
        mask = np.zeros(len(low), dtype=bool)
        within = np.flatnonzero(self.meets(low, high))
        low, high = low[within], high[within]
        for places in np.array_split(self.places, max(len(self.places) * len(low) >> 22, 1)):
            met = (low[:, None] <= places) & (places <= high[:, None])
            mask[within] |= (met[:, :, 0] & met[:, :, 1]).any(axis=1)
        return mask


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
        if isinstance(lattice, ChunkedLattice) and lattice.moved is not None:
            return distinct(self.cells(lattice.unmoved), lattice.moved.cells(lattice.shape))
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
        if isinstance(lattice, ChunkedLattice) and lattice.moved is not None:
            return distinct(self.cells(lattice.unmoved), lattice.moved.cells(lattice.shape))
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


__all__ = ["Boxes", "Feet", "Line"]
