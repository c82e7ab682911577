"""Where the elevations of a grid that stays in its store come from, and what one pass found."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from geosurf.errors import HorizonError
from geosurf.model.store_files import StoreFiles

STAYS = 1 << 26  # nodes: smaller grids are read as a whole, which takes half a GB
_BROKEN = (  # what libraries of stores raise for files that are damaged or gone
    OSError, EOFError, ValueError, TypeError, LookupError, RuntimeError, ImportError,
    ArithmeticError, AttributeError,
)  # fmt: skip
_AT_ONCE = 1 << 22  # nodes that are read at once


@dataclass(frozen=True, eq=False)
class Store:
    """Where elevations come from.

    Attributes
    ----------
    name : str
        Of the horizon, for messages.
    data : array over rows and columns
        Sliced and turned into numpy arrays when needed; a Dask array, mostly.
    row_starts, col_starts : ndarray of int64
        First node of each chunk, south-west first, and the number of nodes at last.
    turned : (bool, bool)
        Whether rows and columns of `data` run the other way.
    scale : float
        From values to metres above the datum.
    as_is : bool
        Whether -0.0 stays: of coordinates, as for grids in memory.
    files : StoreFiles or None
        Those of elevations and coordinates as they were opened; None if they are not known.
    """

    name: str
    data: Any
    row_starts: np.ndarray
    col_starts: np.ndarray
    turned: tuple[bool, bool]
    scale: float
    as_is: bool = False
    files: StoreFiles | None = None

    def holds_values_of(self, other: Store | AxisStore) -> bool:
        """Whether two are known to have the same values: those of one Dask array."""
        if isinstance(other, AxisStore):
            return False
        mine, theirs = (getattr(of.data, "name", None) for of in (self, other))
        same = self.data is other.data or (mine is not None and mine == theirs)
        return same and (self.turned, self.scale) == (other.turned, other.scale)

    def expect_unchanged(self) -> None:
        """Refuse files that have changed since they were opened; see `StoreFiles`."""
        if self.files is not None:
            self.files.expect_unchanged(self.name)

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and columns of nodes."""
        return int(self.row_starts[-1]), int(self.col_starts[-1])

    def read(
        self, rows: tuple[int, int], cols: tuple[int, int], out: np.ndarray | None = None
    ) -> np.ndarray:
        """Elevations [m] of some rows and columns (first, last + 1), float64; written to `out`."""
        if out is None:
            out = np.empty((rows[1] - rows[0], cols[1] - cols[0]))

        # some chunks at a time: Dask holds what it has read twice, and reads it in threads
        step = max(_AT_ONCE // max(rows[1] - rows[0], 1), 1)
        ends = self.col_starts[1:][np.diff(self.col_starts // step) > 0].tolist()
        bounds = [cols[0], *(end for end in ends if cols[0] < end < cols[1]), cols[1]]
        for first, last in pairwise(bounds):
            part = out[:, first - cols[0] : last - cols[0]]
            values = self._values(rows, (first, last))

            # as for grids in memory: scaled as float64, and no -0.0
            if self.scale != 1.0:
                values = np.multiply(values, self.scale, dtype=np.float64)
            if self.as_is:
                part[...] = values
            else:
                np.add(values, 0.0, out=part, dtype=np.float64)
        return out

    def _values(self, rows: tuple[int, int], cols: tuple[int, int]) -> np.ndarray:
        """Values as the store has them, from the south-west."""
        source = [
            slice(n - last, n - first) if turn else slice(first, last)
            for (first, last), n, turn in zip((rows, cols), self.shape, self.turned, strict=True)
        ]
        try:
            values = np.asarray(self.data[tuple(source)])
        except _BROKEN as error:
            raise HorizonError(
                f"horizon {self.name!r}: rows {rows[0]} to {rows[1] - 1} cannot be read from the "
                f"store ({type(error).__name__}: {error}). Check that its files are complete."
            ) from error
        found: np.ndarray = values[tuple(slice(None, None, -1 if t else 1) for t in self.turned)]
        return found

    def tile(self, i: int, j: int) -> tuple[tuple[int, int], tuple[int, int]]:
        """Rows and columns (first, last + 1) of chunk (i, j), and of its neighbours before it.

        Each cell of the grid belongs to one tile.
        """
        (r, s), (c, d) = self.row_starts[i : i + 2].tolist(), self.col_starts[j : j + 2].tolist()
        return (max(r - 1, 0), s), (max(c - 1, 0), d)


@dataclass(frozen=True, eq=False)
class AxisStore:
    """Eastings or northings of all nodes of a grid with axes, as a `Store` has coordinates.

    Attributes
    ----------
    axis : ndarray of float64
        [m].
    along : int
        0: one for each row; 1: one for each column.
    shape : (int, int)
        Number of rows and columns of nodes.
    """

    axis: np.ndarray
    along: int
    shape: tuple[int, int]

    def holds_values_of(self, other: Store | AxisStore) -> bool:
        """Whether two have the same values."""
        if not isinstance(other, AxisStore) or self.along != other.along:
            return False
        return self.shape == other.shape and np.array_equal(self.axis, other.axis)

    def read(
        self, rows: tuple[int, int], cols: tuple[int, int], out: np.ndarray | None = None
    ) -> np.ndarray:
        """Coordinates [m] of some rows and columns (first, last + 1), float64; written to `out`."""
        if out is None:
            out = np.empty((rows[1] - rows[0], cols[1] - cols[0]))
        out[...] = self.axis[slice(*cols)] if self.along else self.axis[slice(*rows), None]
        return out


@dataclass(frozen=True, eq=False)
class ChunkBounds:
    """What one pass over all chunks found.

    Attributes
    ----------
    boxes : ndarray of float64, shape (n_tile, 6)
        Lower, then upper corner around each tile, row by row.
    blocks : ndarray of float64, shape (n_block, 6)
        The same around blocks of 64 x 64 cells of each tile.
    starts : ndarray of int64, shape (n_tile + 1,)
        First block of each tile.
    n_triangles : (int, int)
        As `Survey.n_triangles`.
    in_use : ndarray of float64, shape (6,)
        Box around the nodes that triangles use.
    holes : ndarray of int64, shape (n_hole, 3)
        Absent nodes: row, first and last column, as `geosurf.model.holes.holes_in` returns them.
    last_rows : ndarray of float64, shape (n_tile_row, n_col)
        Elevations of the last row of each row of chunks [m]: the tiles after it begin there.
    last_cols : ndarray of float64, shape (n_tile_col, n_row)
        The same for columns. Both have a first axis of three for grids with 2-D coordinates.
    of_map : ndarray of float64, shape (10,)
        Of a grid with 2-D coordinates: the least height of a triangle in the map [m], whether the
        map is right-handed and diagonals rise, how far nodes are from even steps at most [cells],
        the first node, and the mean steps along columns and rows [m]; else empty.
    """

    boxes: np.ndarray
    blocks: np.ndarray
    starts: np.ndarray
    n_triangles: tuple[int, int]
    in_use: np.ndarray
    holes: np.ndarray
    last_rows: np.ndarray
    last_cols: np.ndarray
    of_map: np.ndarray


__all__ = ["STAYS", "AxisStore", "ChunkBounds", "Store"]
