"""Move some nodes of a grid that stays in its store."""

from __future__ import annotations

import hashlib

import numpy as np

from geosurf.model.base import frozen
from geosurf.model.chunked import ChunkedLattice
from geosurf.model.chunked_map import ChunkedMap
from geosurf.model.moved_nodes import MovedNodes, height_after, widened


def with_moved_nodes(
    lattice: ChunkedLattice, nodes: np.ndarray, places: np.ndarray
) -> ChunkedLattice | None:
    """
    Return a grid in its store of which some nodes are elsewhere.

    Parameters
    ----------
    lattice : ChunkedLattice
    nodes : ndarray of int64, shape (n,)
        Rising, row by row.
    places : ndarray of float64, shape (n, 3)
        World coordinates [m].

    Returns
    -------
    ChunkedLattice or None
        Axes stay where only elevations change; else each node has coordinates of its own. None if
        nodes move so far that the map might fold.
    """
    if lattice.moved is not None:  # moved once more
        every = np.union1d(lattice.moved.nodes, nodes)
        both = lattice.places_of_nodes(every)
        both[np.searchsorted(every, nodes)] = places
        return with_moved_nodes(lattice.unmoved, every, both)
    before = lattice.places_of_nodes(nodes)
    height = height_after(lattice.map_height, before, places)
    if height <= 0.0:
        return None
    base = lattice
    if (before[:, :2] != places[:, :2]).any() and not isinstance(lattice, ChunkedMap):
        base = ChunkedMap.of_axes(lattice)
    digest = hashlib.sha256(f"{lattice.fingerprint} moved".encode())
    moved = MovedNodes(frozen(nodes, np.int64), frozen(places + 0.0, np.float64))
    for part in (moved.nodes, moved.places):
        digest.update(part.tobytes())
    bounds = widened(base.bounds, lattice.store, moved)
    return base.changed(
        bounds=bounds, fingerprint=digest.hexdigest(), moved=moved, given=lattice,
        map_height=height,
    )  # fmt: skip


__all__ = ["with_moved_nodes"]
