"""Nodes of a grid in its store that a repair has moved: they replace what is read."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from geosurf.model.chunk_store import ChunkBounds, Store

BLOCK = 64  # cells along a side of a block
_LARGEST = 0.1  # part of the least height in the map by which steps may change: no cell folds
Span = tuple[int, int]


@dataclass(frozen=True, eq=False)
class MovedNodes:
    """
    Some nodes and their new places.

    Attributes
    ----------
    nodes : ndarray of int64, shape (n,)
        Rising, row by row.
    places : ndarray of float64, shape (n, 3)
        World coordinates [m].
    """

    nodes: np.ndarray
    places: np.ndarray

    def among(self, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """
        Return which of some nodes (n,) are moved, and the row of each of these.

        Examples
        --------
        >>> moved = MovedNodes(np.array([3, 8]), np.zeros((2, 3)))
        >>> mask, row = moved.among(np.array([8, 5, 3, 8]))
        >>> mask.tolist(), row.tolist()
        ([True, False, True, True], [1, 0, 1])
        """
        at = np.minimum(np.searchsorted(self.nodes, nodes), len(self.nodes) - 1)
        mask = self.nodes[at] == nodes
        return mask, at[mask]

    def within(self, rows: Span, cols: Span, n_col: int) -> tuple[np.ndarray, np.ndarray]:
        """
        Return the rows of nodes in a window of a grid of `n_col` columns, and their places in it.

        These count row by row over the window.

        Examples
        --------
        >>> moved = MovedNodes(np.array([3, 8]), np.zeros((2, 3)))
        >>> of, at = moved.within((1, 3), (2, 5), n_col=5)
        >>> of.tolist(), at.tolist()
        ([1], [1])
        """
        low, high = np.searchsorted(self.nodes, [rows[0] * n_col, rows[1] * n_col])
        row, col = np.divmod(self.nodes[low:high], n_col)
        some = np.flatnonzero((col >= cols[0]) & (col < cols[1]))
        at = (row[some] - rows[0]) * (cols[1] - cols[0]) + col[some] - cols[0]
        return low + some, at

    def cells(self, shape: tuple[int, int]) -> np.ndarray:
        """
        Return all cells of a grid around the nodes, rising.

        Examples
        --------
        >>> MovedNodes(np.array([4]), np.zeros((1, 3))).cells((3, 3)).tolist()
        [0, 1, 2, 3]
        """
        return cells_around(self.nodes, shape)


def cells_around(nodes: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """
    Return all cells of a grid that have one of some nodes as a corner, rising.

    Examples
    --------
    >>> cells_around(np.array([0, 5]), (3, 3)).tolist()
    [0, 1, 3]
    """
    n_row, n_col = shape
    row, col = np.divmod(nodes, n_col)
    found = []
    for i in (-1, 0):
        for j in (-1, 0):
            r, c = row + i, col + j
            some = (r >= 0) & (c >= 0) & (r < n_row - 1) & (c < n_col - 1)
            found.append(r[some] * (n_col - 1) + c[some])
    return np.unique(np.concatenate(found))


def height_after(height: float, before: np.ndarray, after: np.ndarray) -> float:
    """
    Return a lower bound of heights of triangles in the map [m] once nodes have moved.

    Parameters
    ----------
    height : float
        The bound for the grid before.
    before, after : ndarray of float64, shape (n, 3)
        Places of the nodes.

    Returns
    -------
    float
        0 if nodes move so far that the map might fold.

    Examples
    --------
    >>> height_after(10.0, np.zeros((1, 3)), np.array([[0.1, 0.0, 5.0]]))
    9.7
    """
    # what moves is linear on each triangle, and changes by a move over each height at most: lengths
    # in the map change by 3 moves over the least height
    far = float(np.hypot(*(after - before)[:, :2].T).max(initial=0.0))
    if far == 0.0:
        return height
    change = 3.0 * far / height if height > 0.0 else np.inf
    return height * (1.0 - change) if change <= _LARGEST else 0.0


def widened(bounds: ChunkBounds, store: Store, moved: MovedNodes) -> ChunkBounds:
    """Return the bounds of a store with boxes that hold moved nodes, too."""
    boxes, blocks = bounds.boxes.copy(), bounds.blocks.copy()
    row, col = np.divmod(moved.nodes, store.shape[1])
    starts = store.row_starts, store.col_starts
    for di in (0, 1):  # a tile begins with the last row and column of the chunks before it
        for dj in (0, 1):
            i, r, n_up, up = _in_tiles(row, starts[0], di)
            j, c, n_along, along = _in_tiles(col, starts[1], dj)
            some = np.flatnonzero(up & along)
            tile = i[some] * (len(starts[1]) - 1) + j[some]
            _widen(boxes, tile, moved.places[some])
            first, n = bounds.starts[tile], np.diff(bounds.starts)[tile]
            n_up, n_along, one = n_up[some], n_along[some], n == 1  # a small tile is one block
            for p in (0, 1):  # a node on the border of blocks is in both
                for q in (0, 1):
                    k, o = (r[some] - p) // BLOCK, (c[some] - q) // BLOCK
                    there = (n > 0) & (k >= 0) & (o >= 0) & (k < n_up) & (o < n_along)
                    block = first + np.where(one, 0, k * n_along + o)
                    here = np.flatnonzero(there | (one & (p + q == 0)))
                    _widen(blocks, block[here], moved.places[some[here]])
    low, high = bounds.in_use[:3], bounds.in_use[3:]
    ends = np.minimum(low, moved.places.min(axis=0)), np.maximum(high, moved.places.max(axis=0))
    return replace(bounds, boxes=boxes, blocks=blocks, in_use=np.concatenate(ends))


def _in_tiles(
    at: np.ndarray, starts: np.ndarray, more: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Tile of some rows or columns, the number in it, its number of blocks, and whether it is one.

    With `more`, the tile after it, of which they may be the first.
    """
    tile = np.searchsorted(starts, at, side="right") - 1 + more
    valid = tile < len(starts) - 1
    tile = np.minimum(tile, len(starts) - 2)
    first = np.maximum(starts[tile] - 1, 0)
    n_block = -(-(starts[tile + 1] - first - 1) // BLOCK)
    return tile, at - first, n_block, valid & (at >= first)


def _widen(boxes: np.ndarray, rows: np.ndarray, places: np.ndarray) -> None:
    """Make some boxes hold places."""
    for k in range(3):
        np.minimum.at(boxes[:, k], rows, places[:, k])
        np.maximum.at(boxes[:, k + 3], rows, places[:, k])


__all__ = ["MovedNodes", "cells_around", "height_after", "widened"]
