"""Horizons that stay in their store: which grids do, and one pass over their chunks.

The pass finds a box around each tile and around blocks of 64 x 64 cells in it. The boxes are kept
in a file next to the store (`chunk_files`): the next session reads only the chunks that it needs.
"""

from __future__ import annotations

import secrets
from dataclasses import replace
from typing import Any

import numpy as np

from geosurf.conventions import rising_diagonal
from geosurf.conventions.memory import share_one_heap
from geosurf.errors import HorizonError
from geosurf.kernels.exact.predicates import MAX_COORDINATE
from geosurf.model import Lattice, TriSurface
from geosurf.model.chunk_store import STAYS, ChunkBounds, Store
from geosurf.model.chunked import ChunkedLattice
from geosurf.model.chunked_map import ChunkedMap
from geosurf.model.holes import holes_in
from geosurf.triangulate.chunk_files import key_of_store, load_bounds, save_bounds
from geosurf.triangulate.chunked_map import MapSurvey

LEAST = 512  # nodes along a side: smaller chunks are read in groups
MOST = 1 << 28  # nodes in a row of chunks, 2 GB
_LEVEL = 3  # of the pyramid over blocks of 8 x 8 cells: 64 x 64
Axes = tuple[np.ndarray | Store, np.ndarray | Store]
Coordinates = tuple[tuple[Any, float], tuple[Any, float]]


def stays_in_store(da: Any) -> bool:
    """Whether a grid is so large that its elevations stay in its store."""
    data = getattr(getattr(da, "variable", da), "_data", None)  # `.data` would load other arrays
    return getattr(da, "size", 0) > STAYS and hasattr(data, "chunks") and hasattr(data, "dask")


def chunked_lattice(
    da: Any, axes: tuple[np.ndarray, np.ndarray], scale: float, name: str
) -> ChunkedLattice:
    """Return the lattice of a grid that stays in its store.

    Parameters
    ----------
    da : xarray.DataArray
        Of Dask, over northing and easting.
    axes : (ndarray, ndarray)
        Easting and northing [m], strictly rising or falling.
    scale : float
        From values to metres above the datum.
    name : str
        Of the horizon.

    Returns
    -------
    ChunkedLattice

    Raises
    ------
    HorizonError
        If chunks are too long, values are infinite or too large, or the store cannot be read.
    """
    turned = bool(axes[1][0] > axes[1][-1]), bool(axes[0][0] > axes[0][-1])
    store = Store(name, da.data, *_groups(da, turned), turned, scale)
    _refuse_long(store, 1)
    easting, northing = (axis[::-1] if axis[0] > axis[-1] else axis for axis in axes)
    both = np.ascontiguousarray(easting + 0.0), np.ascontiguousarray(northing + 0.0)
    store, bounds, key = _opened(store, both)
    return ChunkedLattice.of(both, store, bounds, key)


def chunked_map(da: Any, coordinates: Coordinates, scale: float, name: str) -> ChunkedMap:
    """Return the lattice of a grid with 2-D coordinates that stays in its store.

    Parameters
    ----------
    da, scale, name
        As for `chunked_lattice`; two dimensions of any name.
    coordinates : two pairs of (array, float)
        Easting and northing over the dimensions of `da`, and from their values to metres.

    Returns
    -------
    ChunkedMap

    Raises
    ------
    HorizonError
        As `chunked_lattice`, or if coordinates are not those of a rotated grid with even steps.
    """
    upright = False, False
    groups = _groups(da, upright)
    easting, northing = (
        Store(name, data, *groups, upright, factor, as_is=True) for data, factor in coordinates
    )
    store = Store(name, da.data, *groups, upright, scale)
    _refuse_long(store, 3)
    store, bounds, key = _opened(store, (easting, northing))
    return ChunkedMap.of_stores((easting, northing, store), bounds, key)


def _groups(da: Any, turned: tuple[bool, bool]) -> tuple[np.ndarray, np.ndarray]:
    """First row and column of each group of chunks, and the end."""
    share_one_heap()
    rows, cols = (
        _starts(sizes[::-1] if turn else sizes, LEAST)
        for sizes, turn in zip(da.data.chunks, turned, strict=True)
    )
    return rows, cols


def _refuse_long(store: Store, n_value: int) -> None:
    """Refuse rows of chunks that take too much memory, with some values for each node."""
    longest, n_col = int(np.diff(store.row_starts).max()), store.shape[1]
    if n_value * longest * n_col > MOST:
        raise HorizonError(
            f"horizon {store.name!r}: its chunks have {longest} rows of {n_col} nodes, which is "
            f"{8e-9 * n_value * longest * n_col:.2g} GB at once. Open it with shorter chunks, such "
            "as xr.open_zarr(path, chunks={'northing': 1000, 'easting': 1000})."
        )


def _opened(store: Store, axes: Axes) -> tuple[Store, ChunkBounds, str]:
    """The store with its files; bounds from an earlier session, or from one pass over all chunks.

    The text identifies the values.
    """
    known = key_of_store(store, axes)
    if known is None:
        return store, survey_chunks(store, axes), secrets.token_hex(16)
    key, place, files = known
    store = replace(store, files=files)
    bounds = load_bounds(place, key)
    if bounds is None:
        bounds = survey_chunks(store, axes)
        store.expect_unchanged()
        save_bounds(place, key, bounds)
    return store, bounds, key


def survey_chunks(store: Store, axes: Axes) -> ChunkBounds:
    """Return bounds of all tiles from one pass over a store, a row of chunks at a time.

    `axes` are easting and northing, or the stores of both where coordinates are 2-D.
    """
    boxes, blocks, sizes, holes = [], [], [], [np.empty((0, 3), dtype=np.int64)]
    triangles = np.zeros(2, dtype=np.int64)
    used: dict[bool, list[tuple[float, ...]]] = {False: [], True: []}
    reader = _Reader(store, axes)
    for i in range(len(store.row_starts) - 1):
        (first, last), _ = store.tile(i, 0)
        band = reader.band(i)
        complete = True
        for j in range(len(store.col_starts) - 1):
            _, (left, right) = store.tile(i, j)
            lattice = reader.part(band, (first, last), (left, right))
            seen, part = lattice.survey, lattice.elevation
            _refuse_values(store, seen.box, (first, left), part)
            if reader.map is not None:
                reader.map.check(lattice, (first, left))
            boxes.append(seen.box)
            triangles += seen.n_triangles
            for rising in reader.risings:  # of nodes in use, where some are absent
                turned = lattice.turned_as(rising, None)
                if turned.n_triangle:
                    used[rising].append(TriSurface(store.name, "horizon", lattice=turned).bounds)

            complete = complete and seen.numbers[2]

            # blocks of 64 x 64 cells; tiles without cells have none
            level = seen.levels[min(_LEVEL, len(seen.levels) - 1)].tolist()
            n = level[1] * level[2] if min(part.shape) > 1 else 0
            blocks.append(seen.nodes[level[0] : level[0] + n])
            sizes.append(n)
        if not complete:  # of its own rows: the first one may be that of the chunks before
            start = int(store.row_starts[i])
            holes.append(holes_in(np.isnan(reader.elevation(band)[start - first :]), start))
    starts = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    both = int(triangles[0]), int(triangles[1])
    of_map = np.empty(0) if reader.map is None else reader.map.found()
    rising = reader.risings[0] if reader.map is None else bool(of_map[2])
    box = np.full(6, np.nan)
    if used[rising]:
        west, east, south, north, bottom, top = zip(*used[rising], strict=True)
        low, high = map(min, (west, south, bottom)), map(max, (east, north, top))
        box = np.array([*low, *high])
    found = np.array(boxes), np.concatenate(blocks), starts, both, box, np.concatenate(holes)
    return ChunkBounds(*found, reader.last_rows, reader.last_cols, of_map)


class _Reader:
    """Reads bands of chunks, with elevations alone or with both coordinates before them.

    Attributes
    ----------
    map : MapSurvey or None
        Of 2-D coordinates.
    risings : tuple of bool
        Diagonals that cells may have: that of 2-D coordinates is found with the last band.
    last_rows, last_cols : ndarray
        As `ChunkBounds` has them.
    """

    def __init__(self, store: Store, axes: Axes) -> None:
        self.store, self.axes = store, axes
        self.stores: tuple[Store, ...] = (store,)
        self.map: MapSurvey | None = None
        self.risings: tuple[bool, ...]
        lead: tuple[int, ...] = ()
        if isinstance(axes[0], Store) and isinstance(axes[1], Store):
            lead, self.stores = (3,), (axes[0], axes[1], store)
            self.map, self.risings = MapSurvey(store.name, axes[0], axes[1]), (False, True)
        else:
            self.risings = (rising_diagonal(axes[0], axes[1]),)  # type: ignore[arg-type]
        n_row, n_col = store.shape
        longest = int(np.diff(store.row_starts).max())
        self.room = np.empty((*lead, longest + 1, n_col))
        self.last_rows = np.empty((*lead, len(store.row_starts) - 1, n_col))
        self.last_cols = np.empty((*lead, len(store.col_starts) - 1, n_row))

    def band(self, i: int) -> np.ndarray:
        """Values of a row of tiles; valid until the next one."""
        # the last row of the band before makes the cells between both complete
        (first, last), _ = self.store.tile(i, 0)
        band, start = self.room[..., : last - first, :], int(self.store.row_starts[i])
        if i:
            band[..., 0, :] = self.last_rows[..., i - 1, :]
        n_col = self.store.shape[1]
        new = band[..., start - first :, :].reshape(len(self.stores), -1, n_col)
        for of, out in zip(self.stores, new, strict=True):
            of.read((start, last), (0, n_col), out)
        self.last_rows[..., i, :] = band[..., -1, :]
        ends = band[..., self.store.col_starts[1:] - 1]
        self.last_cols[..., first:last] = np.swapaxes(ends, -1, -2)
        return band

    def elevation(self, band: np.ndarray) -> np.ndarray:
        """Elevations among the values of a band."""
        found: np.ndarray = band if self.map is None else band[2]
        return found

    def part(self, band: np.ndarray, rows: tuple[int, int], cols: tuple[int, int]) -> Lattice:
        """Some columns of a band, as a lattice in memory."""
        part = np.ascontiguousarray(band[..., cols[0] : cols[1]])
        if self.map is not None:
            return Lattice(part[0], part[1], part[2], self.risings[0])
        x, y = self.axes
        return Lattice(x[slice(*cols)], y[slice(*rows)], part, self.risings[0])  # type: ignore[index]


def _refuse_values(
    store: Store, box: np.ndarray, corner: tuple[int, int], part: np.ndarray
) -> None:
    """Refuse infinite elevations, and marks of absent nodes that are not NaN."""
    if box[2] > box[5] or np.abs(box[2::3]).max() <= MAX_COORDINATE:
        return  # the box around no node is inside out
    i, j = np.argwhere(np.abs(part) > MAX_COORDINATE)[0].tolist()
    raise HorizonError(
        f"horizon {store.name!r}: the elevation of node ({corner[0] + i}, {corner[1] + j}) is "
        f"{part[i, j]:g} m. Set missing nodes to NaN: da.where(abs(da) < {MAX_COORDINATE:g})."
    )


def _starts(sizes: Any, least: int) -> np.ndarray:
    """First node of each group of chunks with at least so many nodes, and the end."""
    ends = np.cumsum(sizes).tolist()
    starts = [0]
    for end in ends[:-1]:
        if end - starts[-1] >= least:
            starts.append(end)
    return np.array([*starts, ends[-1]], dtype=np.int64)


__all__ = ["chunked_lattice", "chunked_map", "stays_in_store", "survey_chunks"]
