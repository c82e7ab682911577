"""Place pieces that touch nothing, among horizons that stay in their store.

A ray from each piece meets triangles in one column or row of the map: no others are listed.
"""

from __future__ import annotations

import numpy as np

from geosurf.carve.half_faces import Parts
from geosurf.carve.isolated import place_floating
from geosurf.kernels.lattices.strips import lowest_keys
from geosurf.model.excerpt import Excerpt, in_runs, list_triangles, near_of
from geosurf.model.pieces import Pieces
from geosurf.model.regions import Boxes


def place_in_store(
    pieces: Pieces, parts: Parts, piece: np.ndarray, fixed: np.ndarray, sides: np.ndarray
) -> np.ndarray:
    """
    Unite what floating pieces see outside with the cell that holds them.

    Parameters
    ----------
    pieces : Pieces
    parts : Parts
    piece : ndarray of int64, shape (n_part,)
        Connected piece of each part.
    fixed : ndarray of int64
        Pieces that do not float.
    sides : ndarray of int64, shape (n_part, 2)
        What each part sees in front of it and behind.

    Returns
    -------
    ndarray of int64, shape (n_part, 2)
    """
    none = np.empty((0, 2))
    seen, region = np.empty((0, 4)), Boxes(none, none)
    while True:
        listed = _with_all_parts(pieces, parts, region)
        part = parts.of_element[listed.element]
        inside = np.flatnonzero(part >= 0)
        t, part = listed.triangles[inside], part[inside]

        # rays start from the first triangle of each piece: their ways have to be listed
        _, first = np.unique(piece[part], return_index=True)
        ways = _ways(listed.x[t[first]] + pieces.origin)
        new = ways[~(ways[:, None] == seen).all(axis=2).any(axis=1)]
        if not len(new):
            break
        seen = np.concatenate([seen, new])
        region = Boxes(seen[:, :2], seen[:, 2:])
    found = place_floating(listed.x, t, piece[part], fixed, sides[part].ravel()).reshape(-1, 2)
    _, row = np.unique(part, return_index=True)
    placed: np.ndarray = found[row]
    return placed


def _with_all_parts(pieces: Pieces, parts: Parts, region: Boxes) -> Excerpt:
    """All triangles that are listed already, one of each other part, and runs in a region."""
    n_core = len(pieces.triangles)
    runs = parts.first[parts.first >= n_core] - n_core
    cut = np.searchsorted(pieces.surface, np.arange(len(pieces.sources) + 1))
    chosen = []
    for i, (_, keys, of) in enumerate(near_of(pieces, region)):
        strips = pieces.strips[i]
        if strips is not None:
            low, high = pieces.first_run[i : i + 2]
            mine = runs[(runs >= low) & (runs < high)] - low
            more = lowest_keys(strips.places, strips.runs[mine])
            keys, of = in_runs(pieces, i, np.union1d(keys, more))
        chosen.append((np.arange(cut[i], cut[i + 1]), keys, of))
    return list_triangles(pieces, chosen)


def _ways(corners: np.ndarray) -> np.ndarray:
    """Boxes in the map (n, 4) that hold rays from triangles (n, 3, 3): see `carve.rays`."""
    a, b, c = (corners[:, k] for k in range(3))
    axes = np.abs(np.cross(b - a, c - a)).argmax(axis=1)
    low, high = corners[:, :, :2].min(axis=1), corners[:, :, :2].max(axis=1)
    for axis in (0, 1):  # along easting or northing; others are upright
        low[axes == axis, axis], high[axes == axis, axis] = -np.inf, np.inf
    return np.concatenate([low, high], axis=1)


__all__ = ["place_in_store"]
