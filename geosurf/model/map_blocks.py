"""Boxes in the map around blocks of cells of a grid with 2-D coordinates.

Columns and rows of such a grid do not follow from easting and northing, and rotated grids are what
most fields come with. Boxes around blocks find the cells near a place without reading every cell.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

_SIDE = 16  # cells along a side of a block
Meets = Callable[[np.ndarray, np.ndarray], np.ndarray]


class MapBlocks:
    """
    Boxes around blocks of cells.

    Parameters
    ----------
    easting, northing : ndarray of float64, shape (n_row, n_col)
        Of the nodes [m]; NaN where there is none.

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(40.0), np.arange(30.0))
    >>> blocks = MapBlocks(x + y, y - x)
    >>> blocks.cells_where(lambda low, high: low[:, 0] < 2).tolist()
    [0, 1, 39]
    """

    def __init__(self, easting: np.ndarray, northing: np.ndarray) -> None:
        self._map = easting, northing
        low, high = (
            np.stack([_blocks_of(of, extreme) for of in self._map], axis=-1)
            for extreme in (np.fmin, np.fmax)
        )
        self._shape = low.shape[:2]
        self._boxes = low.reshape(-1, 2), high.reshape(-1, 2)

    def cells_where(self, meets: Meets) -> np.ndarray:
        """Return all cells whose boxes in the map (low (n, 2), high (n, 2)) meet something."""
        n_row, n_col = (n - 1 for n in self._map[0].shape)
        row, col = np.divmod(np.flatnonzero(meets(*self._boxes)), self._shape[1])
        inside = np.arange(_SIDE)
        rows, cols = np.broadcast_arrays(
            (_SIDE * row[:, None] + inside)[:, :, None], (_SIDE * col[:, None] + inside)[:, None]
        )
        some = (rows < n_row) & (cols < n_col)
        rows, cols = rows[some], cols[some]

        # the four nodes of each cell of these blocks
        corners = [
            np.stack([of[rows + i, cols + j] for of in self._map], axis=-1)
            for i, j in ((0, 0), (0, 1), (1, 0), (1, 1))
        ]
        near = meets(np.fmin.reduce(corners), np.fmax.reduce(corners))
        found: np.ndarray = np.sort(rows[near] * n_col + cols[near])
        return found


def _blocks_of(values: np.ndarray, extreme: np.ufunc) -> np.ndarray:
    """Lowest or highest value (n_row_block, n_col_block) of the nodes of each block."""
    for axis in (0, 1):
        starts = np.arange(0, max(values.shape[axis] - 1, 1), _SIDE)
        of_blocks = extreme.reduceat(values, starts, axis=axis)

        # the last nodes of a block are the first ones of the next
        ends = np.take(values, np.minimum(starts + _SIDE, values.shape[axis] - 1), axis=axis)
        values = extreme(of_blocks, ends)
    return values


__all__ = ["MapBlocks", "Meets"]
