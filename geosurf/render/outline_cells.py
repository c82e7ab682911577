"""Which triangles and lines are certainly inside or outside of an outline, by cells of a raster.

Outlines of rotated grids are not convex. Clipped part by part, each part would ask for the side of
every point. Cells of a raster that no side of the outline is near are inside or outside as a whole,
and nearly all triangles lie in such cells. Sums over the raster answer for many cells at once.
"""

from __future__ import annotations

import numpy as np

_CELLS = 256  # along the longer side of the outline
_PER_CELL = 4  # points along a side in the length of a cell, so that it skips no cell by much
OUTSIDE, NEAR, INSIDE = 0, 1, 2


class OutlineCells:
    """
    A raster over an outline.

    Parameters
    ----------
    outline : ndarray of float64, shape (n, 2)
        Corners in order; it does not meet itself.

    Examples
    --------
    >>> cells = OutlineCells(np.array([[0.0, 0], [9, 0], [9, 9], [5, 1], [0, 9]]))
    >>> points = np.array([[1.0, 1], [1.1, 1], [1, 1.1], [5, 5], [5.1, 5], [5, 5.1], [0, 0]])
    >>> cells.sort(points, np.array([[0, 1, 2], [3, 4, 5], [0, 1, 6]])).tolist()
    [2, 0, 1]
    """

    def __init__(self, outline: np.ndarray) -> None:
        low, size = outline.min(axis=0), np.ptp(outline, axis=0)
        self._step = float(size.max()) / _CELLS
        # cells around the outline stand for all that is beyond
        self._low = low - 4.0 * self._step
        self._shape = tuple((np.ceil(size / self._step) + 8).astype(int).tolist())
        codes = self._coded(outline)
        self._sums = {
            code: np.pad(np.cumsum(np.cumsum(codes == code, axis=0), axis=1), ((1, 0), (1, 0)))
            for code in (OUTSIDE, INSIDE)
        }

    def sort(self, points: np.ndarray, elements: np.ndarray) -> np.ndarray:
        """
        Return OUTSIDE, INSIDE, or NEAR where it is not certain, for each triangle or segment.

        Parameters
        ----------
        points : ndarray of float64, shape (n, 2 or 3)
        elements : ndarray of int64, shape (m, 3 or 2)
        """
        # beyond the raster its last cells count, which are outside
        at = (points[:, :2] - self._low) / self._step
        cell = np.clip(at, 0, np.array(self._shape) - 1).astype(np.int32)
        corners = [cell[column] for column in elements.T]
        (i, j), (k, m) = np.minimum.reduce(corners).T, np.maximum.reduce(corners).T + 1
        n_cell = (k - i) * (m - j)
        found = np.full(len(elements), NEAR)
        for code, sums in self._sums.items():
            number = sums[k, m] - sums[i, m] - sums[k, j] + sums[i, j]
            found[number == n_cell] = code
        return found

    def _coded(self, outline: np.ndarray) -> np.ndarray:
        """The code of each cell."""
        start, way = outline, np.roll(outline, -1, axis=0) - outline
        n = np.ceil(_PER_CELL * np.abs(way).max(axis=1) / self._step).astype(int) + 1
        of = np.repeat(np.arange(len(n)), n)
        part = (np.arange(len(of)) - np.repeat(np.cumsum(n) - n, n)) / n[of]
        i, j = ((start[of] + part[:, None] * way[of] - self._low) / self._step).astype(int).T

        # the cells around each point, too: between two points a side passes no others
        codes = np.where(self._middles_inside(outline), INSIDE, OUTSIDE)
        for row in (-1, 0, 1):
            for col in (-1, 0, 1):
                codes[i + row, j + col] = NEAR
        return codes

    def _middles_inside(self, outline: np.ndarray) -> np.ndarray:
        """Whether the middle of each cell is inside: sides to the left of it, even or odd."""
        n_x, n_y = self._shape
        y = self._low[1] + (np.arange(n_y) + 0.5) * self._step
        (x1, y1), (x2, y2) = outline.T, np.roll(outline, -1, axis=0).T
        row, side = np.nonzero((y1 <= y[:, None]) != (y2 <= y[:, None]))
        at = x1[side] + (y[row] - y1[side]) / (y2[side] - y1[side]) * (x2[side] - x1[side])
        first = np.ceil((at - self._low[0]) / self._step - 0.5).astype(int)
        steps = np.zeros((n_x + 1, n_y), dtype=np.int64)
        np.add.at(steps, (np.clip(first, 0, n_x), row), 1)
        inside: np.ndarray = np.cumsum(steps[:-1], axis=0) % 2 == 1
        return inside


__all__ = ["INSIDE", "NEAR", "OUTSIDE", "OutlineCells"]
