"""Horizons that stay in their store: which grids do, and one pass over their chunks.

The pass finds a box around each tile and around blocks of 64 x 64 cells in it. The boxes are kept
in a file next to the store (`chunk_files`): the next session reads only the chunks that it needs.
"""

from __future__ import annotations

import secrets
from typing import Any

import numpy as np

from geosurf.conventions import rising_diagonal
from geosurf.conventions.memory import share_one_heap
from geosurf.errors import HorizonError
from geosurf.kernels.exact.predicates import MAX_COORDINATE
from geosurf.model import Lattice, TriSurface
from geosurf.model.chunk_store import STAYS, ChunkBounds, Store
from geosurf.model.chunked import ChunkedLattice
from geosurf.model.holes import holes_in
from geosurf.triangulate.chunk_files import key_of_store, load_bounds, save_bounds

LEAST = 512  # nodes along a side: smaller chunks are read in groups
MOST = 1 << 28  # nodes in a row of chunks, 2 GB
_LEVEL = 3  # of the pyramid over blocks of 8 x 8 cells: 64 x 64


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
    share_one_heap()
    turned = bool(axes[1][0] > axes[1][-1]), bool(axes[0][0] > axes[0][-1])
    rows, cols = (
        _starts(sizes[::-1] if turn else sizes, LEAST)
        for sizes, turn in zip(da.data.chunks, turned, strict=True)
    )
    store = Store(name, da.data, rows, cols, turned, scale)
    longest, n_col = int(np.diff(rows).max()), store.shape[1]
    if longest * n_col > MOST:
        raise HorizonError(
            f"horizon {name!r}: its chunks have {longest} rows of {n_col} nodes, which is "
            f"{8e-9 * longest * n_col:.2g} GB at once. Open it with shorter chunks, such as "
            "xr.open_zarr(path, chunks={'northing': 1000, 'easting': 1000})."
        )

    easting, northing = (axis[::-1] if axis[0] > axis[-1] else axis for axis in axes)
    both = np.ascontiguousarray(easting + 0.0), np.ascontiguousarray(northing + 0.0)

    # bounds of the same data from an earlier session, or one pass over all chunks
    key, place = key_of_store(store, both)
    bounds = None if key is None or place is None else load_bounds(place, key)
    if bounds is None:
        bounds = survey_chunks(store, both)
        if key is not None and place is not None:
            save_bounds(place, key, bounds)
    return ChunkedLattice.of(both, store, bounds, key or secrets.token_hex(16))


def survey_chunks(store: Store, axes: tuple[np.ndarray, np.ndarray]) -> ChunkBounds:
    """Return bounds of all tiles from one pass over a store, a row of chunks at a time."""
    boxes, blocks, sizes, holes = [], [], [], [np.empty((0, 3), dtype=np.int64)]
    triangles, used = np.zeros(2, dtype=np.int64), []
    rising = rising_diagonal(*axes)
    longest, n_col = int(np.diff(store.row_starts).max()), store.shape[1]
    room = np.empty((longest + 1, n_col))
    last_rows = np.empty((len(store.row_starts) - 1, n_col))
    last_cols = np.empty((len(store.col_starts) - 1, store.shape[0]))
    for i in range(len(store.row_starts) - 1):
        # the last row of the band before makes the cells between both complete
        (first, last), _ = store.tile(i, 0)
        band = room[: last - first]
        if i:
            band[0] = last_rows[i - 1]
        store.read((int(store.row_starts[i]), last), (0, n_col), band[0 if i == 0 else 1 :])
        last_rows[i] = band[-1]
        last_cols[:, first:last] = band[:, store.col_starts[1:] - 1].T
        complete = True
        for j in range(len(store.col_starts) - 1):
            _, (left, right) = store.tile(i, j)
            part = np.ascontiguousarray(band[:, left:right])
            lattice = Lattice(axes[0][left:right], axes[1][first:last], part, rising)
            seen = lattice.survey
            _refuse_values(store, seen.box, (first, left), part)
            boxes.append(seen.box)
            triangles += seen.n_triangles
            if lattice.n_triangle:  # of its nodes in use, where some are absent
                used.append(TriSurface(store.name, "horizon", lattice=lattice).bounds)

            complete = complete and seen.numbers[2]

            # blocks of 64 x 64 cells; tiles without cells have none
            level = seen.levels[min(_LEVEL, len(seen.levels) - 1)].tolist()
            n = level[1] * level[2] if min(part.shape) > 1 else 0
            blocks.append(seen.nodes[level[0] : level[0] + n])
            sizes.append(n)
        if not complete:  # of its own rows: the first one may be that of the chunks before
            start = int(store.row_starts[i])
            holes.append(holes_in(np.isnan(band[start - first :]), start))
    starts = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    both = int(triangles[0]), int(triangles[1])
    box = np.full(6, np.nan)
    if used:
        west, east, south, north, bottom, top = zip(*used, strict=True)
        low, high = map(min, (west, south, bottom)), map(max, (east, north, top))
        box = np.array([*low, *high])
    found = np.array(boxes), np.concatenate(blocks), starts, both, box, np.concatenate(holes)
    return ChunkBounds(*found, last_rows, last_cols)


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


__all__ = ["chunked_lattice", "stays_in_store", "survey_chunks"]
