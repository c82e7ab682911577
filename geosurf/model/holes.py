"""Absent nodes of a grid as intervals of columns, row by row: little memory where holes are large.

Numbers of triangles follow from the intervals, so a grid that stays in its store needs no mask.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geosurf.model.base import Noun, frozen

ROW, FIRST, LAST = 0, 1, 2


def holes_in(absent: np.ndarray, first_row: int = 0) -> np.ndarray:
    """
    Return the intervals of absent nodes in some rows.

    Parameters
    ----------
    absent : ndarray of bool, shape (n_row, n_col)
    first_row : int
        Number of the first of these rows.

    Returns
    -------
    ndarray of int64, shape (n, 3)
        Row, first and last column, in order.

    Examples
    --------
    >>> holes_in(np.array([[True, True, False, True], [False] * 4])).tolist()
    [[0, 0, 1], [0, 3, 3]]
    """
    edge = np.zeros((absent.shape[0], absent.shape[1] + 1), dtype=bool)
    edge[:, 0], edge[:, -1] = absent[:, 0], absent[:, -1]
    edge[:, 1:-1] = absent[:, 1:] != absent[:, :-1]

    # in each row beginnings and ends take turns
    row, column = np.nonzero(edge)
    return np.stack([row[::2] + first_row, column[::2], column[1::2] - 1], axis=1).astype(np.int64)


@dataclass(frozen=True, eq=False)
class Holes(Noun):
    """
    Absent nodes of a grid.

    Attributes
    ----------
    shape : (int, int)
        Rows and columns of the grid.
    intervals : ndarray of int64, shape (n, 3)
        As `holes_in` returns them.

    Examples
    --------
    >>> holes = Holes((3, 4), np.array([[0, 1, 2], [2, 3, 3]]))
    >>> holes.n_absent, holes.count((0, 2), (2, 4)), holes.present((2, 3)).tolist()
    (3, 1, [[True, True, True, False]])
    >>> holes.is_present(np.array([0, 1, 11])).tolist(), holes.present_nodes(np.array([0, 1]))
    ([True, False, False], array([0, 3]))
    """

    shape: tuple[int, int]
    intervals: np.ndarray

    @property
    def n_absent(self) -> int:
        """Number of absent nodes."""
        return int((self.intervals[:, LAST] - self.intervals[:, FIRST] + 1).sum())

    @cached_property
    def start(self) -> np.ndarray:
        """First interval of each row, and their number, int64 (n_row + 1,)."""
        found = np.searchsorted(self.intervals[:, ROW], np.arange(self.shape[0] + 1))
        return frozen(found, np.int64)

    def count(self, rows: tuple[int, int], cols: tuple[int, int]) -> int:
        """Number of absent nodes in some rows and columns (first, last + 1)."""
        some = self.intervals[self.start[rows[0]] : self.start[rows[1]]]
        width = np.minimum(some[:, LAST] + 1, cols[1]) - np.maximum(some[:, FIRST], cols[0])
        return int(np.maximum(width, 0).sum())

    def uneven_columns(self, rows: tuple[int, int]) -> list[tuple[int, int]]:
        """
        Return ranges of columns (first, last + 1) where a rim may be in some rows.

        Columns outside have all nodes of these rows and so have both neighbours, or all three have
        none. The first and the last column are always inside.

        Examples
        --------
        >>> Holes((2, 9), np.array([[1, 4, 4]])).uneven_columns((0, 2))
        [(0, 1), (3, 6), (8, 9)]
        """
        some = self.intervals[self.start[rows[0]] : self.start[rows[1]]]
        n_col = self.shape[1]
        steps = np.bincount(some[:, FIRST], minlength=n_col + 1)
        steps -= np.bincount(some[:, LAST] + 1, minlength=n_col + 1)
        n_absent = np.pad(np.cumsum(steps[:-1]), 1, constant_values=-1)  # beyond the grid: neither
        around = np.stack([n_absent[:-2], n_absent[1:-1], n_absent[2:]])
        even = (around == 0).all(axis=0) | (around == rows[1] - rows[0]).all(axis=0)

        edge = np.flatnonzero(np.diff(np.pad(~even, 1).astype(np.int8)))
        return list(zip(edge[::2].tolist(), edge[1::2].tolist(), strict=True))

    def present(self, rows: tuple[int, int], cols: tuple[int, int] | None = None) -> np.ndarray:
        """Mask of the nodes that exist in some rows and columns (first, last + 1), bool."""
        some = self.intervals[self.start[rows[0]] : self.start[rows[1]]]
        left, right = cols or (0, self.shape[1])
        some = some[(some[:, LAST] >= left) & (some[:, FIRST] < right)]
        first, last = np.maximum(some[:, FIRST], left), np.minimum(some[:, LAST] + 1, right)

        # +1 where a hole begins, -1 behind it: sums along the rows are 1 in holes
        steps = np.zeros((rows[1] - rows[0], right - left + 1), dtype=np.int8)
        steps[some[:, ROW] - rows[0], first - left] += 1
        steps[some[:, ROW] - rows[0], last - left] -= 1
        mask: np.ndarray = np.cumsum(steps[:, :-1], axis=1, dtype=np.int8) == 0
        return mask

    @cached_property
    def _nodes(self) -> tuple[np.ndarray, np.ndarray]:
        """First and last node of each interval, numbered row by row."""
        row, first, last = self.intervals.T
        return row * self.shape[1] + first, row * self.shape[1] + last

    def is_present(self, nodes: np.ndarray) -> np.ndarray:
        """Whether nodes exist, numbered row by row."""
        first, last = self._nodes
        if not len(first):
            return np.ones(np.shape(nodes), dtype=bool)
        at = np.searchsorted(first, nodes, side="right") - 1
        mask: np.ndarray = (at < 0) | (nodes > last[at])
        return mask

    def present_nodes(self, numbers: np.ndarray) -> np.ndarray:
        """The nodes with some numbers, counted over those that exist."""
        first, last = self._nodes
        gone = np.cumsum(last - first + 1)
        before = first - np.concatenate([[0], gone[:-1]]) if len(first) else first
        holes = np.searchsorted(before, numbers, side="right")
        found: np.ndarray = numbers + np.concatenate([[0], gone])[holes]
        return found

    def gaps(self, rising: bool) -> np.ndarray:
        """Absent triangles in the form of `geosurf.kernels.lattices.strips`, int64 (n,)."""
        from geosurf.kernels.lattices.strips import gaps_of_holes

        if not len(self.intervals):
            return np.empty(0, dtype=np.int64)
        found: np.ndarray = gaps_of_holes(*self.shape, rising, self.start, self.intervals)
        return found


@dataclass(frozen=True, eq=False)
class TriangleNumbers:
    """
    Keys and rows of the triangles of a grid with holes, without a list of them.

    Attributes
    ----------
    shape : (int, int)
        Rows and columns of nodes.
    rising : bool
    gaps : ndarray of int64
        As `Holes.gaps`.

    Examples
    --------
    The first node is absent: without it, one triangle is left of its cell.

    >>> holes = Holes((2, 3), np.array([[0, 0, 0]]))
    >>> numbers = TriangleNumbers((2, 3), False, holes.gaps(False))
    >>> numbers.keys_of_rows(np.arange(3)).tolist()
    [1, 2, 3]
    >>> numbers.rows_of_keys(np.array([1, 3])).tolist()
    [0, 2]
    """

    shape: tuple[int, int]
    rising: bool
    gaps: np.ndarray

    @property
    def _width(self) -> int:
        """Places in a row of cells."""
        return 2 * (self.shape[1] - 1)

    @cached_property
    def _ends(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """First and last place of each gap, counted over all rows, and what is gone up to it."""
        n_row = self.shape[0] - 1
        if not len(self.gaps):
            return (np.empty(0, dtype=np.int64),) * 2 + (np.zeros(1, dtype=np.int64),)
        row = np.repeat(np.arange(n_row), np.diff(self.gaps[: n_row + 1]) // 2)
        first, last = self.gaps[n_row + 1 :].reshape(-1, 2).T + self._width * row
        return first, last, np.concatenate([[0], np.cumsum(last - first + 1)])

    def _is_there(self, place: np.ndarray) -> np.ndarray:
        first, last, _ = self._ends
        if not len(first):
            return np.ones(len(place), dtype=bool)
        at = np.searchsorted(first, place, side="right") - 1
        there: np.ndarray = (at < 0) | (place > last[at])
        return there

    def _before(self, place: np.ndarray) -> np.ndarray:
        """Number of triangles before some places."""
        first, last, gone = self._ends
        at = np.searchsorted(first, place)  # gaps that begin before the place
        cut = np.zeros(len(place), dtype=np.int64)
        if len(first):  # the last of them may reach beyond it
            cut = np.where(at > 0, np.maximum(last[at - 1] + 1 - place, 0), 0)
        found: np.ndarray = place - (gone[at] - cut)
        return found

    def rows_of_keys(self, keys: np.ndarray) -> np.ndarray:
        """Rows among all triangles, for keys of triangles that exist."""
        # cells in order, then their halves: the places of a rising cell run the other way
        place = keys & ~1
        other = place + (1 if self.rising else 0)  # the place of half 0
        found: np.ndarray = self._before(place) + np.where(keys & 1, self._is_there(other), 0)
        return found

    def keys_of_rows(self, rows: np.ndarray) -> np.ndarray:
        """Keys of triangles for rows among all of them."""
        first, _, gone = self._ends
        at = np.searchsorted(first - gone[:-1], rows, side="right")
        place = rows + gone[at]
        cell = place & ~1
        both = self._is_there(cell) & self._is_there(cell + 1)
        half = place & 1
        if self.rising:
            half = np.where(both, half, 1 - half)
        found: np.ndarray = cell + half
        return found


__all__ = ["FIRST", "LAST", "ROW", "Holes", "TriangleNumbers", "holes_in"]
