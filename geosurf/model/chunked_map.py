"""Grids with 2-D coordinates whose nodes stay in a store: rotated ones.

Easting and northing of each node are read with its elevation, chunk by chunk, so that points have
the bytes of a grid in memory whatever made the coordinates.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from typing import Any, ClassVar, NoReturn

import numpy as np

from geosurf.kernels.lattices.sets import distinct
from geosurf.model.base import frozen
from geosurf.model.chunk_store import AxisStore, ChunkBounds, Store
from geosurf.model.chunked import ChunkedLattice
from geosurf.model.held_chunks import Held
from geosurf.model.lattice import Lattice
from geosurf.model.map_blocks import Meets

BLOCK = 64  # cells along a side of a block
_ASIDE = 1e-3  # cells; far more than rounding
Span = tuple[int, int]


class _Absent:
    """Stands for a coordinate that nobody has in memory: its form is known, not its values."""

    ndim = 2

    def __init__(self, whole: ChunkedMap) -> None:
        self.shape, self._whole = whole.shape, whole

    def __array__(self, *_: Any, **__: Any) -> NoReturn:
        raise self._whole.too_large()

    def __getattr__(self, name: str) -> NoReturn:
        if name.startswith("__"):
            raise AttributeError(name)
        raise self._whole.too_large()

    def __getitem__(self, _: Any) -> NoReturn:
        raise self._whole.too_large()

    def __sub__(self, _: Any) -> NoReturn:
        raise self._whole.too_large()


class ChunkedMap(ChunkedLattice):
    """A lattice with even steps, nearly, of which easting, northing and elevation are in a store.

    Attributes
    ----------
    stores : (Store, Store, Store)
        Of easting, northing and elevation. The first two may be axes (`of_axes`).
    """

    stores: tuple[Store | AxisStore, Store | AxisStore, Store]
    _shared: ClassVar[tuple[str, ...]] = (
        "store", "stores", "bounds", "fingerprint", "moved", "given", "map_height", "right_handed",
        "_held",
    )  # fmt: skip

    _bytes_of_node: ClassVar = 24

    @classmethod
    def of_stores(
        cls, stores: tuple[Store, Store, Store], bounds: ChunkBounds, fingerprint: str
    ) -> ChunkedMap:
        """Make a lattice of three stores and what one pass over them found."""
        height, right_handed, rising = bounds.of_map[:3].tolist()
        return cls._made(
            store=stores[2], stores=stores, bounds=bounds, fingerprint=fingerprint, _held=Held(),
            map_height=height, right_handed=bool(right_handed), rising=bool(rising), reverse=None,
        )  # fmt: skip

    @classmethod
    def of_axes(cls, lattice: ChunkedLattice) -> ChunkedMap:
        """Give each node of a lattice with axes an easting and a northing; steps may differ."""
        x, y, bounds = lattice.easting, lattice.northing, lattice.bounds
        stores = AxisStore(x, 1, lattice.shape), AxisStore(y, 0, lattice.shape), lattice.store
        rows, cols = (of[1:] - 1 for of in (lattice.store.row_starts, lattice.store.col_starts))
        last = (
            np.stack(np.broadcast_arrays(x, y[rows, None], bounds.last_rows)),
            np.stack(np.broadcast_arrays(x[cols, None], y, bounds.last_cols)),
        )
        made = cls._made(
            store=lattice.store, stores=stores, fingerprint=lattice.fingerprint, _held=Held(),
            bounds=replace(bounds, last_rows=last[0], last_cols=last[1]), right_handed=True,
            map_height=lattice.map_height, rising=lattice.rising, reverse=lattice.reverse,
        )  # fmt: skip
        known = lattice.held_nodes
        made.remember(known, lattice.places_of_nodes(known))
        return made

    @property
    def easting(self) -> Any:
        """Stands for all eastings: an error for whoever reads them."""
        return _Absent(self)

    @property
    def northing(self) -> Any:
        """Stands for all northings: an error for whoever reads them."""
        return _Absent(self)

    @cached_property
    def places(self) -> np.ndarray:
        """The layout of all coordinates, as `Lattice.places`: row by row."""
        step = 0, self.shape[1], 1
        rest = *self.shape, self.rising, self.turned, 1
        return frozen(np.array([*step, *step, *step, *rest], dtype=np.int64), np.int64)

    @property
    def reads_map(self) -> bool:
        """Whether easting and northing are 2-D and stay in a store: yes."""
        return True

    @property
    def has_rising_axes(self) -> bool:
        """Whether easting and northing are axes of their own: no."""
        return False

    def horizontal(self) -> NoReturn:
        """Easting and northing of all nodes: an error."""
        raise self.too_large()

    def places_of_nodes(self, nodes: np.ndarray) -> np.ndarray:
        """World coordinates (n, 3) of nodes, row by row."""
        flat = np.asarray(nodes, dtype=np.int64).reshape(-1)
        return self._with_moves(flat, self._values_of(flat))

    def values_at(self, part: Lattice, nodes: np.ndarray) -> np.ndarray:
        """Values of some nodes of a part in memory, as `remember` keeps them."""
        return part.places_of_nodes(nodes)

    def map_places(self, nodes: np.ndarray) -> np.ndarray:
        """Easting and northing (n, 2) of nodes, row by row."""
        flat = np.asarray(nodes, dtype=np.int64)
        found: np.ndarray = self.places_of_nodes(flat)[:, :2].reshape(*flat.shape, 2)
        return found

    def cells_at(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns of places (n, 2) in the map, as if steps were even."""
        x, y, ux, uy, vx, vy = self.bounds.of_map[4:].tolist()
        col, row = np.linalg.solve([[ux, vx], [uy, vy]], (places - [x, y]).T)
        return row, col

    def cells_around(self, places: np.ndarray) -> np.ndarray:
        """All cells that places (n, 2) in the map may be in or at the rim of, and some more."""
        off, spans = float(self.bounds.of_map[3]), []
        row, col = self.cells_at(places)
        for at, n in ((row, self.shape[0]), (col, self.shape[1])):
            low = np.floor(at - off - _ASIDE)
            spans.append((low, np.floor(at + off + _ASIDE) - low, n))
        (south, n_up, n_row), (west, n_along, n_col) = spans
        found = [np.empty(0, dtype=np.int64)]
        for i in range(int(n_up.max(initial=-1)) + 1):
            for j in range(int(n_along.max(initial=-1)) + 1):
                r, c = south + i, west + j
                some = (r >= 0) & (c >= 0) & (r < n_row - 1) & (c < n_col - 1)
                some &= (i <= n_up) & (j <= n_along)
                cells = r[some].astype(np.int64) * (n_col - 1) + c[some].astype(np.int64)
                found.append(cells)
        return distinct(*found)

    def cells_where(self, meets: Meets) -> np.ndarray:
        """All cells whose boxes in the map (low (n, 2), high (n, 2)) meet something, and some more.

        Boxes of blocks are asked first, then those of the cells in blocks that meet it.
        """
        boxes, found = self.bounds.boxes, [np.empty(0, dtype=np.int64)]
        for tile in np.flatnonzero(meets(boxes[:, :2], boxes[:, 3:5])).tolist():
            rows, cols = self.store.tile(*divmod(tile, self.tile_shape[1]))
            blocks = self.bounds.blocks[slice(*self.bounds.starts[tile : tile + 2])]
            n_row, n_col = (-(-(last - first - 1) // BLOCK) for first, last in (rows, cols))
            if len(blocks) != n_row * n_col:  # a small tile is one block
                row, col = (np.arange(first, last - 1) for first, last in (rows, cols))
                some = np.ones((len(row), len(col)), dtype=bool)
            else:
                met = meets(blocks[:, :2], blocks[:, 3:5]).reshape(n_row, n_col)
                some = np.repeat(np.repeat(met, BLOCK, axis=0), BLOCK, axis=1)
                row, col = (np.arange(first, last - 1) for first, last in (rows, cols))
                some = some[: len(row), : len(col)]
            i, j = np.nonzero(some)
            i, j = row[i], col[j]
            near = meets(*self._boxes_of_cells(i, j))
            found.append(i[near] * (self.shape[1] - 1) + j[near])
        return distinct(*found)

    def _boxes_of_cells(self, row: np.ndarray, col: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Boxes in the map that hold some cells (n,): low and high corners (n, 2)."""
        start, along, up = self.bounds.of_map[4:].reshape(3, 2)
        middle = start + (col[:, None] + 0.5) * along + (row[:, None] + 0.5) * up
        reach = (0.5 + float(self.bounds.of_map[3]) + _ASIDE) * (np.abs(along) + np.abs(up))
        return middle - reach, middle + reach

    def map_bands(self) -> Iterator[tuple[Span, np.ndarray, np.ndarray]]:
        """Yield rows (first, last + 1), and easting and northing of all of their nodes."""
        for rows in pairwise(self.store.row_starts.tolist()):
            yield rows, *self.map_of_rows(rows)

    def map_of_rows(self, rows: Span) -> tuple[np.ndarray, np.ndarray]:
        """Easting and northing of all nodes of some rows (first, last + 1)."""
        cols = 0, self.shape[1]
        x, y = (of.read(rows, cols) for of in self.stores[:2])
        if self.moved is not None:
            of, at = self.moved.within(rows, cols, self.shape[1])
            x.flat[at], y.flat[at] = self.moved.places[of, :2].T
        return x, y

    def map_at(self, rows: np.ndarray, cols: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Easting and northing [m] of some rows and columns, which rise, each (n_row, n_col)."""
        found = np.empty((2, len(rows), len(cols)))
        for (first, last), *both in self.map_bands():
            here = slice(*np.searchsorted(rows, (first, last)))
            for out, part in zip(found, both, strict=True):
                out[here] = part[np.ix_(rows[here] - first, cols)]
        return found[0], found[1]

    def shares_map(self, other: Lattice) -> bool:
        """Whether two graphs have the same nodes in the map, one by one."""
        if self.shape != other.shape or not other.is_graph:
            return False
        if isinstance(other, ChunkedMap):
            pairs = zip(self.stores[:2], other.stores[:2], strict=True)
            if all(one.holds_values_of(two) for one, two in pairs):
                return self._moves_map_as(other)
        elif other.easting.ndim == 1:
            return False

        # the first node differs for nearly all pairs of grids
        first = np.zeros(1, dtype=np.int64)
        if not np.array_equal(self.map_places(first), other.map_places(first)):
            return False
        known: dict[int, tuple[Lattice, bool]] = self.__dict__.setdefault("_same_map", {})
        if id(other) not in known:
            known[id(other)] = other, self._has_map_of(other)
        return known[id(other)][1]

    def _moves_map_as(self, other: ChunkedMap) -> bool:
        """Whether nodes that have moved are in the same places in the map."""
        some = [one.moved.nodes for one in (self, other) if one.moved is not None]
        if not some:
            return True
        nodes = distinct(*some)
        return np.array_equal(self.map_places(nodes), other.map_places(nodes))

    def _has_map_of(self, other: Lattice) -> bool:
        """Compare all nodes in the map."""
        for rows, x, y in self.map_bands():
            if isinstance(other, ChunkedMap):
                p, q = other.map_of_rows(rows)
            else:
                p, q = (of[slice(*rows)] for of in other.horizontal())
            if not (np.array_equal(x, p) and np.array_equal(y, q)):
                return False
        return True

    @property
    def _lead(self) -> tuple[int, ...]:
        return (3,)

    def _elevation_of(self, values: np.ndarray) -> np.ndarray:
        found: np.ndarray = values[2]
        return found

    def _read(self, rows: Span, cols: Span, out: np.ndarray | None = None) -> np.ndarray:
        if out is None:
            out = np.empty((3, rows[1] - rows[0], cols[1] - cols[0]))
        for store, part in zip(self.stores, out, strict=True):
            store.read(rows, cols, part)
        return out

    def _part(self, rows: Span, cols: Span, z: np.ndarray) -> Lattice:
        if self.moved is not None:
            of, at = self.moved.within(rows, cols, self.shape[1])
            row, col = np.divmod(at, cols[1] - cols[0])
            z[:, row, col] = self.moved.places[of].T
        part = Lattice(z[0], z[1], z[2], self.rising, self.reverse)
        # what was found for the whole holds for a part: steps of a few cells say less of it
        part.__dict__.update(map_height=self.map_height, right_handed=self.right_handed)
        return part


__all__ = ["ChunkedMap"]
