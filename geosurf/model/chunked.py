"""A lattice whose elevations stay in a store (Zarr, NetCDF) and are read chunk by chunk.

It is a `Lattice` with the node numbers of the whole grid, so that points, curves and patches have
the same names as those of a grid in memory. Whoever needs all elevations at once gets an error that
names the size; what streams asks for `bands` or `window`.

Values of some nodes are elevations, over rows and columns; of a grid with 2-D coordinates they have
a first axis of three: easting, northing and elevation (`geosurf.model.chunked_map`).
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from geosurf.conventions.memory import give_back_memory
from geosurf.errors import HorizonError
from geosurf.model.base import frozen
from geosurf.model.chunk_store import ChunkBounds, Store
from geosurf.model.held_chunks import Held
from geosurf.model.holes import Holes, TriangleNumbers
from geosurf.model.lattice import Lattice
from geosurf.model.moved_nodes import MovedNodes
from geosurf.model.survey import Survey

if TYPE_CHECKING:  # pragma: no cover - types only
    from concurrent.futures import Future

KNOWN = 8_000_000  # nodes next to curves that are held one by one
_FEW = 1 << 14  # nodes that were looked up, and are held
AHEAD = 1 << 25  # nodes of a band that is read ahead: 256 MB


class ChunkedLattice(Lattice):
    """A lattice with straight axes and elevations in a store.

    Attributes
    ----------
    store : Store
    bounds : ChunkBounds
    fingerprint : str
        Of all nodes.
    moved : MovedNodes or None
        What a repair has moved (`geosurf.model.chunked_moves`). Chunks, and nodes that are held,
        are as the store has them: whatever leaves the lattice has nodes where they have moved to.
    """

    store: Store
    bounds: ChunkBounds
    fingerprint: str
    moved: MovedNodes | None = None

    @classmethod
    def of(
        cls,
        axes: tuple[np.ndarray, np.ndarray],
        store: Store,
        bounds: ChunkBounds,
        fingerprint: str,
    ) -> ChunkedLattice:
        """Make a lattice of rising axes (easting, northing), a store and its bounds."""
        easting, northing = (frozen(axis, np.float64) for axis in axes)
        return cls._made(
            easting=easting, northing=northing, rising=True, reverse=None, store=store,
            bounds=bounds, fingerprint=fingerprint, _held=Held(),
        )  # fmt: skip

    @classmethod
    def _made(cls, **parts: Any) -> Self:
        made = object.__new__(cls)
        made.__dict__.update(parts)
        return made

    _shared: ClassVar[tuple[str, ...]] = (
        "easting", "northing", "store", "bounds", "fingerprint", "moved", "given", "map_height",
        "_held",
    )  # fmt: skip

    def changed(self, **parts: Any) -> Self:
        """Return the lattice with other parts, and what is held of chunks and nodes."""
        same = {key: self.__dict__[key] for key in self._shared if key in self.__dict__}
        turn = {"rising": self.rising, "reverse": self.reverse}
        return self._made(**{**same, **turn, **parts})

    @property
    def unmoved(self) -> ChunkedLattice:
        """The lattice before a repair moved nodes."""
        given: ChunkedLattice = self.__dict__.get("given", self)
        return given

    def turned_as(self, rising: bool, reverse: bool | None) -> Self:
        """Return the lattice with another diagonal; what is known of nodes is shared."""
        if rising == self.rising and reverse is self.reverse:
            return self
        return self.changed(rising=rising, reverse=reverse)

    @property
    def elevation(self) -> np.ndarray:
        """All elevations: an error, since they may exceed the memory."""
        raise self.too_large()

    def corners_in_use(self) -> np.ndarray:
        """Corners around the nodes that triangles use, float64 (2, 3)."""
        return self.bounds.in_use.reshape(2, 3)

    @property
    def n_present(self) -> int:
        """Number of nodes that exist."""
        return self.n_node - self.holes.n_absent

    @cached_property
    def holes(self) -> Holes:
        """The absent nodes, as intervals of columns."""
        return Holes(self.shape, self.bounds.holes)

    def rows_of_keys(self, keys: np.ndarray) -> np.ndarray:
        """Rows of `build_triangles` for keys of triangles that exist."""
        return keys if self.whole else self._numbers.rows_of_keys(keys)

    def keys_of_rows(self, rows: np.ndarray) -> np.ndarray:
        """Keys of triangles for rows of `build_triangles`."""
        return rows if self.whole else self._numbers.keys_of_rows(rows)

    @cached_property
    def _numbers(self) -> TriangleNumbers:
        return TriangleNumbers(self.shape, self.rising, self.gaps)

    def elevations_at(self, rows: np.ndarray, cols: np.ndarray) -> np.ndarray:
        """Elevations [m] of some rows and columns, which rise: one pass over the chunks."""
        known: dict[bytes, np.ndarray] = self.__dict__["_held"].every
        key = self.fingerprint.encode() + rows.tobytes() + cols.tobytes()
        if key not in known:  # pictures of one size ask for the same nodes
            found = np.empty((len(rows), len(cols)))
            done = 0
            for first, band in self.bands():
                here = slice(done, int(np.searchsorted(rows, first + band.shape[0])))
                found[here] = band.elevation[np.ix_(rows[here] - first, cols)]
                done = here.stop
            known.clear()
            known[key] = found
        return known[key]

    def check_in_memory(self) -> None:
        """Raise the error of whoever lists all triangles."""
        raise self.too_large()

    def presence(self, rows: tuple[int, int], cols: tuple[int, int]) -> np.ndarray:
        """Mask of the nodes that exist in some rows and columns (first, last + 1)."""
        return self.holes.present(rows, cols)

    def rim_windows(self, at_once: int) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
        """Yield windows of nodes, rows and columns (first, last + 1), that hold all of its rim."""
        n_row = self.shape[0]
        for rows, cols in super().rim_windows(at_once):
            low, high = rows
            if low == 0 or high == n_row:  # the first and the last row are rim all along
                yield rows, cols
                continue
            for some in self.holes.uneven_columns((low - 1, high + 1)):
                yield rows, some

    @property
    def present(self) -> np.ndarray:
        """Mask of the nodes that exist: an error, as for elevations; `holes` has the same."""
        raise self.too_large()

    @property
    def keys(self) -> np.ndarray:
        """Keys of all triangles: an error, as for elevations."""
        raise self.too_large()

    def build_vertices(self) -> np.ndarray:
        """All nodes that exist: an error, as for elevations."""
        raise self.too_large()

    def build_triangles(self) -> np.ndarray:
        """All triangles: an error, as for elevations."""
        raise self.too_large()

    _bytes_of_node: ClassVar = 8
    _streamed: ClassVar = (
        "Curves, units, volumes, certificates, thickness maps, sections, samples and wells"
    )

    def too_large(self) -> HorizonError:
        """The error of whoever needs all nodes at once."""
        n_row, n_col = self.shape
        return HorizonError(
            f"horizon {self.store.name!r} stays in its store ({n_row} x {n_col} nodes, "
            f"{self._bytes_of_node * 1e-9 * self.n_node:.2g} GB), and this result needs all nodes "
            f"in memory. {self._streamed} do not. Load it with da.load(), select a part with "
            "da.isel(...), or keep fewer nodes: gs.triangulate_horizon(da, tolerance=1.0), in m.",
            surfaces=[self.store.name],
        )

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and columns of nodes."""
        return self.store.shape

    @property
    def n_node(self) -> int:
        """Number of nodes, absent ones too."""
        return self.shape[0] * self.shape[1]

    @cached_property
    def places(self) -> np.ndarray:
        """The layout of all coordinates, as `Lattice.places`; elevations are row by row."""
        rest = 0, self.shape[1], 1, *self.shape, self.rising, self.turned, 1
        return frozen(np.array([0, 0, 1, 0, 1, 0, *rest], dtype=np.int64), np.int64)

    @cached_property
    def survey(self) -> Survey:
        """What is known of all nodes; the pyramid is one box."""
        bounds = self.bounds
        low, high = bounds.boxes[:, :3].min(axis=0), bounds.boxes[:, 3:].max(axis=0)
        complete = len(bounds.holes) == 0
        unknown = np.full(2, np.nan), np.full(2, np.inf), np.inf, 0.0, np.full((2, 3), np.nan)
        return Survey(
            frozen(np.concatenate([low, high])[None], np.float64),
            frozen(np.array([[0, 1, 1]]), np.int64),
            bounds.n_triangles, (True, True, complete), False, True, *unknown,
        )  # fmt: skip

    @property
    def tile_shape(self) -> tuple[int, int]:
        """Number of tiles along rows and columns."""
        return len(self.store.row_starts) - 1, len(self.store.col_starts) - 1

    def places_of_nodes(self, nodes: np.ndarray) -> np.ndarray:
        """World coordinates (n, 3) of nodes, row by row."""
        flat = np.asarray(nodes, dtype=np.int64).reshape(-1)
        row, col = np.divmod(flat, self.shape[1])
        places = np.stack([self.easting[col], self.northing[row], self._values_of(flat)], axis=1)
        return self._with_moves(flat, places)

    def _with_moves(self, nodes: np.ndarray, places: np.ndarray) -> np.ndarray:
        """Places (n, 3) of nodes as the store has them, with those that have moved put in."""
        if self.moved is not None:
            mask, row = self.moved.among(nodes)
            places[mask] = self.moved.places[row]
        return places

    def values_at(self, part: Lattice, nodes: np.ndarray) -> np.ndarray:
        """Values of some nodes of a part in memory, as `remember` keeps them."""
        found: np.ndarray = part.elevation.ravel()[nodes]
        return found

    def remember(self, nodes: np.ndarray, values: np.ndarray) -> None:
        """Keep values of some nodes, one row each, which are then not read again."""
        if self.moved is not None:  # what is held is as in the store
            mask, _ = self.moved.among(nodes)
            nodes, values = nodes[~mask], values[~mask]
        self._hold(nodes, values)

    @property
    def held_nodes(self) -> np.ndarray:
        """Nodes whose values are known, rising."""
        held: Held = self.__dict__["_held"]
        return held.nodes[0]

    def _hold(self, nodes: np.ndarray, values: np.ndarray) -> None:
        """Keep values of some nodes as the store has them."""
        held: Held = self.__dict__["_held"]
        held.add_nodes(nodes, values, KNOWN // math.prod(self._lead))

    def _values_of(self, nodes: np.ndarray) -> np.ndarray:
        """Values of nodes, one row each: known ones, then chunk by chunk."""
        held: Held = self.__dict__["_held"]
        known, values = held.nodes
        wanted, inverse = np.unique(nodes, return_inverse=True)
        z = np.empty((len(wanted), *self._lead))
        at = np.minimum(np.searchsorted(known, wanted), max(len(known) - 1, 0))
        there = known[at] == wanted if len(known) else np.zeros(len(wanted), dtype=bool)
        if len(known):
            z[there] = values[at[there]]

        missing = np.flatnonzero(~there)
        if len(missing):
            row, col = np.divmod(wanted[missing], self.shape[1])
            i = np.searchsorted(self.store.row_starts, row, side="right") - 1
            j = np.searchsorted(self.store.col_starts, col, side="right") - 1
            tile = i * self.tile_shape[1] + j
            order = np.argsort(tile, kind="stable")
            for some in np.split(order, np.flatnonzero(np.diff(tile[order])) + 1):
                a, b = int(i[some[0]]), int(j[some[0]])
                chunk = self._chunk(a, b)
                r, c = self.store.row_starts[a], self.store.col_starts[b]
                picked = chunk[..., row[some] - r, col[some] - c]
                z[missing[some]] = np.moveaxis(picked, -1, 0)
            if len(missing) <= _FEW:  # many are a part of the model that is asked for once
                self._hold(wanted[missing], z[missing])
        found: np.ndarray = z[inverse.reshape(-1)]
        return found

    @property
    def _lead(self) -> tuple[int, ...]:
        """The axes of values before rows and columns."""
        return ()

    def _elevation_of(self, values: np.ndarray) -> np.ndarray:
        """Elevations among values."""
        return values

    def _read(
        self, rows: tuple[int, int], cols: tuple[int, int], out: np.ndarray | None = None
    ) -> np.ndarray:
        """Values of some rows and columns (first, last + 1)."""
        return self.store.read(rows, cols, out)

    def _chunk(self, i: int, j: int) -> np.ndarray:
        """Values of a chunk, from those that were used last if it is among them."""
        held: Held = self.__dict__["_held"]
        (r, s), (c, d) = (
            of[k : k + 2].tolist()
            for of, k in ((self.store.row_starts, i), (self.store.col_starts, j))
        )
        return held.chunk((i, j), lambda: self._same(self._read((r, s), (c, d)), (r, s), (c, d)))

    def forget_chunks(self) -> None:
        """Give up the chunks that were used last."""
        held: Held = self.__dict__["_held"]
        held.forget_chunks()

    def _same(self, values: np.ndarray, rows: tuple[int, int], cols: tuple[int, int]) -> np.ndarray:
        """Values that were read, or an error if nodes have gone since the store was opened."""
        # a chunk whose file is gone reads as NaN
        z = self._elevation_of(values)
        n_absent = self.holes.count(rows, cols)
        if (n_absent or np.isnan(z.sum())) and np.count_nonzero(np.isnan(z)) != n_absent:
            raise HorizonError(
                f"horizon {self.store.name!r}: in rows {rows[0]} to {rows[1] - 1} nodes are absent "
                "that were there when the store was opened. Check that its files are complete, and "
                "open it again.",
                surfaces=[self.store.name],
            )
        return values

    def window(self, rows: tuple[int, int], cols: tuple[int, int]) -> Lattice:
        """Return some rows and columns (first, last + 1) as a lattice in memory."""
        z = np.empty((*self._lead, rows[1] - rows[0], cols[1] - cols[0]))
        starts = self.store.row_starts, self.store.col_starts

        # the chunks that the window meets, each copied to its place
        spans = [
            range(
                int(np.searchsorted(of, first, side="right")) - 1,
                int(np.searchsorted(of, last, side="left")),
            )
            for of, (first, last) in zip(starts, (rows, cols), strict=True)
        ]
        for i in spans[0]:
            for j in spans[1]:
                (r, r_end), (c, c_end) = starts[0][i : i + 2], starts[1][j : j + 2]
                r0, r1 = max(r, rows[0]), min(r_end, rows[1])
                c0, c1 = max(c, cols[0]), min(c_end, cols[1])

                # of chunks before a tile only the last row or column, which is known
                if r1 - r0 == 1 and r1 == r_end:
                    part = self.bounds.last_rows[..., i : i + 1, c0:c1]
                elif c1 - c0 == 1 and c1 == c_end:
                    part = self.bounds.last_cols[..., j, r0:r1, None]
                else:
                    part = self._chunk(i, j)[..., r0 - r : r1 - r, c0 - c : c1 - c]
                z[..., r0 - rows[0] : r1 - rows[0], c0 - cols[0] : c1 - cols[0]] = part
        return self._part(rows, cols, z)

    def _part(self, rows: tuple[int, int], cols: tuple[int, int], z: np.ndarray) -> Lattice:
        """A lattice in memory of some rows and columns with their values, which it may change."""
        if self.moved is not None:  # their elevations: axes stay
            of, at = self.moved.within(rows, cols, self.shape[1])
            z.flat[at] = self.moved.places[of, 2]
        axes = self.easting[slice(*cols)], self.northing[slice(*rows)]
        return Lattice(*axes, z, self.rising, self.reverse)

    def bands(self, wanted: np.ndarray | None = None) -> Iterator[tuple[int, Lattice]]:
        """Yield all cells in order, as bands of chunks: first row of nodes, and a lattice.

        A lattice is valid until the next one: all of them use the same memory.

        Parameters
        ----------
        wanted : ndarray of bool, shape (n_row - 1,), optional
            Rows of cells; bands without any are not read.

        Raises
        ------
        HorizonError
            If the store cannot be read, or has changed by the end.
        """
        from concurrent.futures import ThreadPoolExecutor

        tiles = []
        for i in range(self.tile_shape[0]):
            (first, last), _ = self.store.tile(i, 0)
            some = wanted is None or wanted[first : last - 1].any()
            if some and last - first > 1:
                tiles.append(i)

        # the next band is read while this one is used, if there is room for both
        size = (*self._lead, 1 + int(np.diff(self.store.row_starts).max()), self.shape[1])
        ahead = 1 if math.prod(size) <= AHEAD and len(tiles) > 1 else 0
        self.forget_chunks()  # the bands take their memory
        give_back_memory()
        rooms = [np.empty(size) for _ in range(1 + ahead)]
        with ThreadPoolExecutor(1) as pool:
            reads: deque[Future[Lattice]] = deque()
            for n, i in enumerate(tiles):
                if not reads:
                    reads.append(pool.submit(self._band, i, rooms[n % len(rooms)]))
                band = reads.popleft().result()
                if ahead and n + 1 < len(tiles):
                    room = rooms[(n + 1) % len(rooms)]
                    reads.append(pool.submit(self._band, tiles[n + 1], room))
                yield self.store.tile(i, 0)[0][0], band
        self.store.expect_unchanged()

    def _band(self, i: int, room: np.ndarray) -> Lattice:
        """A row of tiles, read into `room`."""
        (first, last), _ = self.store.tile(i, 0)
        cols = 0, self.shape[1]
        z = room[..., : last - first, :]
        if i:
            z[..., 0, :] = self.bounds.last_rows[..., i - 1, :]
        start = int(self.store.row_starts[i])
        self._read((start, last), cols, z[..., start - first :, :])
        self._same(z, (first, last), cols)
        return self._part((first, last), cols, z)


def part_of(lattice: Lattice, rows: tuple[int, int], cols: tuple[int, int]) -> Lattice:
    """Return some rows and columns (first, last + 1) of any lattice, as one in memory."""
    if isinstance(lattice, ChunkedLattice):
        return lattice.window(rows, cols)
    r, c = slice(*rows), slice(*cols)
    x, y = lattice.easting, lattice.northing
    x, y = (x[c], y[r]) if x.ndim == 1 else (x[r, c], y[r, c])
    return Lattice(x, y, lattice.elevation[r, c], lattice.rising, lattice.reverse)


__all__ = ["ChunkedLattice", "part_of"]
