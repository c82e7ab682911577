"""The regular lattice that a random field is simulated on: nodes of a horizon, or its own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.model import Lattice

REGULAR = 1e-6  # of a cell: how far nodes may be off for distances, which decide nothing else


@dataclass(frozen=True, eq=False)
class FieldGrid:
    """
    Nodes in rows and columns of equal steps, at any angle.

    Attributes
    ----------
    corner : ndarray of float64, shape (2,)
        Easting and northing of the first node [m].
    steps : ndarray of float64, shape (2, 2)
        From row to row, and from column to column [m]; at right angles.
    shape : (n_row, n_col)

    Examples
    --------
    >>> grid = FieldGrid.around(np.array([[0.0, 0.0], [100.0, 40.0]]), 20.0)
    >>> float(grid.cell[0]), (grid.weights_at(np.array([[50.0, 20.0]])).sum().round(12)).item()
    (20.0, 1.0)
    """

    corner: np.ndarray
    steps: np.ndarray
    shape: tuple[int, int]

    @classmethod
    def of_lattice(cls, lattice: Lattice) -> FieldGrid | None:
        """Return the grid of a horizon's nodes; None if these are not in equal steps."""
        n_row, n_col = lattice.shape
        # A single row has no step across.
        if min(n_row, n_col) < 2:
            return None
        x, y = lattice.horizontal()
        # Steps from the first to the last node average what rounding did to each.
        corner = np.array([x[0, 0], y[0, 0]])
        last_row = np.array([x[-1, 0], y[-1, 0]]) - corner
        last_col = np.array([x[0, -1], y[0, -1]]) - corner
        steps = np.stack([last_row / (n_row - 1), last_col / (n_col - 1)])
        cell = np.hypot(*steps.T)
        # Absent corners: the grid may be regular, but nothing proves it.
        if not (np.isfinite(steps).all() and cell.min() > 0):
            return None

        # every node where the steps lead, and rows at right angles to columns
        i, j = np.arange(n_row)[:, None], np.arange(n_col)[None, :]
        off = max(
            float(np.abs(values - (corner[k] + i * steps[0, k] + j * steps[1, k])).max())
            for k, values in enumerate((x, y))
        )
        skew = abs(float(steps[0] @ steps[1])) / float(cell[0] * cell[1])
        if not (off <= REGULAR * cell.min() and skew <= REGULAR):
            return None
        return cls(corner, steps, (n_row, n_col))

    @classmethod
    def around(cls, places: np.ndarray, cell: float) -> FieldGrid:
        """Return an axis-parallel grid around places (n, 2), two nodes wider on each side."""
        low, high = places.min(axis=0), places.max(axis=0)
        # Two nodes more on each side, so that cubic interpolation finds its neighbours.
        n_col, n_row = (np.ceil((high - low) / cell).astype(int) + 5).tolist()
        # Rows run north, columns east.
        steps = np.array([[0.0, cell], [cell, 0.0]])
        return cls(low - 2.0 * cell, steps, (n_row, n_col))

    @property
    def cell(self) -> np.ndarray:
        """Distance between rows and between columns [m], float64 (2,)."""
        lengths: np.ndarray = np.hypot(*self.steps.T)
        return lengths

    @property
    def n_node(self) -> int:
        """Number of nodes."""
        return self.shape[0] * self.shape[1]

    def weights_at(self, places: np.ndarray) -> Any:
        """
        Return the weights of nodes in the values at places, by cubic convolution.

        Parameters
        ----------
        places : ndarray of float64, shape (n, 2)
            Inside of the grid.

        Returns
        -------
        scipy.sparse.csr_matrix
            (n, n_node): 1 for one node where a place is a node.
        """
        from scipy.sparse import csr_matrix

        # Rows and columns as real numbers, also for a rotated lattice.
        offset = (places - self.corner) @ np.linalg.inv(self.steps)
        # The last node belongs to the last cell.
        base = np.clip(np.floor(offset), 0, np.array(self.shape) - 2).astype(np.int64)
        rows, rising = _cubic(offset[:, 0] - base[:, 0], base[:, 0], self.shape[0])
        cols, across = _cubic(offset[:, 1] - base[:, 1], base[:, 1], self.shape[1])
        nodes = rows[:, :, None] * self.shape[1] + cols[:, None, :]
        # The weights of a product of two cubics.
        weights = rising[:, :, None] * across[:, None, :]
        n = len(places)
        indptr = np.arange(n + 1) * 16
        found = csr_matrix((weights.ravel(), nodes.ravel(), indptr), shape=(n, self.n_node))
        # At the boundary a node stands for several: its weights add up.
        found.sum_duplicates()
        found.eliminate_zeros()
        return found


def _cubic(t: np.ndarray, base: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Four nodes along one axis and their weights (n, 4); beyond an end, the end itself."""
    # Outside, the value at the boundary.
    t = np.clip(t, 0.0, 1.0)
    # Cubic convolution (Keys 1981) with a = -1/2: exact at nodes and for parabolas.
    weights = 0.5 * np.stack(
        [
            t * (t * (2.0 - t) - 1.0),
            t * t * (3.0 * t - 5.0) + 2.0,
            t * (t * (4.0 - 3.0 * t) + 1.0),
            t * t * (t - 1.0),
        ],
        axis=1,
    )
    return np.clip(base[:, None] + np.arange(-1, 3), 0, n - 1), weights
