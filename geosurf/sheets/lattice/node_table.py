"""Numbers of lattice nodes, as a table that grows where nodes are put."""

from __future__ import annotations

import numpy as np

from geosurf.kernels.sheets.node_tiles import (
    NOT_ASKED,
    SIDE,
    numbers_of_nodes,
    open_tiles,
    put_numbers,
)


class NodeTable:
    """
    A number for each node of a lattice that was put.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns of the lattice.

    Examples
    --------
    >>> table = NodeTable((100, 200))
    >>> table.put(np.array([3, 19999]), np.array([7, 8]))
    >>> table.look_up(np.array([19999, 3, -1, 4]))
    (array([ 8,  7, -1, -2]), 1)
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        n_row, self.n_col = shape
        tiles = -(-n_row // SIDE) * -(-self.n_col // SIDE)
        self._tile_of, self._n_tile = np.full(tiles, -1), 0
        self._numbers = np.empty(0, dtype=np.int64)

    def look_up(self, node: np.ndarray) -> tuple[np.ndarray, int]:
        """Number of each node, -1 for nodes below 0, `NOT_ASKED` for others that were not put.

        Parameters
        ----------
        node : ndarray of int64 (n,)

        Returns
        -------
        (ndarray of int64 (n,), int)
            Also how many were not put.
        """
        found: tuple[np.ndarray, int] = numbers_of_nodes(
            node, self.n_col, self._tile_of, self._numbers
        )
        return found

    def put(self, node: np.ndarray, number: np.ndarray) -> None:
        """Put numbers of nodes (n,); those that were put before get the new ones."""
        n_tile = open_tiles(node, self.n_col, self._tile_of, self._n_tile)
        if n_tile > self._n_tile:
            new = np.full((n_tile - self._n_tile) * SIDE**2, NOT_ASKED)
            self._numbers, self._n_tile = np.concatenate([self._numbers, new]), n_tile
        put_numbers(node, number, self.n_col, self._tile_of, self._numbers)


__all__ = ["NodeTable"]
