"""Places in groups by the chunks below them, where horizons stay in their store."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from geosurf.model import Units
from geosurf.model.chunked import ChunkedLattice
from geosurf.model.chunked_map import ChunkedMap
from geosurf.model.pieces import Pieces

AT_ONCE = 1 << 17  # places whose part of the model is in memory


def stays_in_store(units: Units) -> bool:
    """Whether a horizon of a model stays in its store."""
    return units.has_pieces and _first_chunked(units.piece_sides[0]) is not None


def groups_by_tile(pieces: Pieces, feet: np.ndarray) -> Iterator[np.ndarray]:
    """
    Yield rows of places in the map, tile by tile of the first horizon in its store.

    Each group has `AT_ONCE` places, and the last one fewer. A group reads each chunk below it once;
    what curves touch is listed once for each group, so that few places make one.
    """
    lattice = _first_chunked(pieces)
    assert lattice is not None
    lattice = lattice.unmoved
    starts = lattice.store.row_starts[:-1], lattice.store.col_starts[:-1]
    if isinstance(lattice, ChunkedMap):
        at = lattice.cells_at(feet)
        i, j = (
            np.searchsorted(of, part, side="right") for of, part in zip(starts, at, strict=True)
        )
    else:
        i = np.searchsorted(lattice.northing[starts[0]], feet[:, 1], side="right")
        j = np.searchsorted(lattice.easting[starts[1]], feet[:, 0], side="right")
    tile = i * (len(starts[1]) + 1) + j
    order = np.argsort(tile, kind="stable")
    for first in range(0, len(order), AT_ONCE):
        yield order[first : first + AT_ONCE]


def _first_chunked(pieces: Pieces) -> ChunkedLattice | None:
    for source in pieces.sources:
        if isinstance(source.lattice, ChunkedLattice):
            return source.lattice
    return None


__all__ = ["groups_by_tile", "stays_in_store"]
