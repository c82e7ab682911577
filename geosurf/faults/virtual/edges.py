"""Edges of arrangements, by which virtual walls and faults are cut into pieces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.kernels.meshes.mesh import join_pairs
from geosurf.model import Patches


def rows_of(patches: Patches, name: str) -> np.ndarray:
    """Triangles of a surface; none if the arrangement does not have it."""
    if name not in patches.names:
        return np.empty(0, dtype=np.int64)
    return np.flatnonzero(patches.surface_of_triangle == patches.names.index(name))


def edge_keys(patches: Patches, rows: np.ndarray) -> np.ndarray:
    """A number for each edge of some triangles, int64 (n, 3)."""
    t = patches.triangles[rows]
    ends = np.stack([t, np.roll(t, -1, axis=1)], axis=2)
    keys: np.ndarray = ends.min(axis=2) * len(patches.local) + ends.max(axis=2)
    return keys


def edges_of(patches: Patches, names: Sequence[str]) -> np.ndarray:
    """Edges of some surfaces, each once."""
    rows = [rows_of(patches, name) for name in names]
    return np.unique(edge_keys(patches, np.concatenate([np.empty(0, dtype=np.int64), *rows])))


def areas_of(patches: Patches, rows: np.ndarray) -> np.ndarray:
    """Area of some triangles [m2]."""
    a, b, c = (patches.local[patches.triangles[rows, k]] for k in range(3))
    areas: np.ndarray = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return areas


def pieces_between(keys: np.ndarray, stops: np.ndarray) -> np.ndarray:
    """Number the pieces of triangles, whose edges (n, 3) are given, between some edges."""
    free = np.flatnonzero(~np.isin(keys, stops).ravel())
    order = free[np.argsort(keys.ravel()[free], kind="stable")]
    same = keys.ravel()[order][1:] == keys.ravel()[order][:-1]
    pairs = np.stack([order[:-1][same] // 3, order[1:][same] // 3], axis=1)
    found: np.ndarray = join_pairs(pairs, len(keys))
    return found


def crossed_by(patches: Patches, name: str) -> set[str]:
    """Return the faults that cut a fault into pieces; one that it only ends at does not."""
    rows = rows_of(patches, name)
    keys = edge_keys(patches, rows)
    others = [one.name for one in patches.sources if one.name != name]
    piece = pieces_between(keys, edges_of(patches, others))
    found = set()
    for other in others:
        at = np.flatnonzero(np.isin(keys, edges_of(patches, [other])).ravel())
        order = at[np.argsort(keys.ravel()[at], kind="stable")]
        same = keys.ravel()[order][1:] == keys.ravel()[order][:-1]
        if (piece[order[:-1][same] // 3] != piece[order[1:][same] // 3]).any():
            found.add(other)
    return found
