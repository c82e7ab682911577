"""Elements -> their sides, joined where they see each other across an edge.

An element is a triangle, or a run of triangles that no curve touches; it has two sides as one
triangle has: 2 i in front of it, where its normal points, and 2 i + 1 behind.
"""

from __future__ import annotations

import numpy as np

from geosurf.conventions import place
from geosurf.errors import InvariantError
from geosurf.kernels.mesh import connected
from geosurf.kernels.predicates import frame_of
from geosurf.kernels.radial import join_run_sides, join_sides
from geosurf.kernels.strips import RIM, lowest_keys
from geosurf.model import Patches
from geosurf.model.pieces import Pieces


def surface_of_elements(pieces: Pieces) -> np.ndarray:
    """Surface of each triangle and run."""
    of_run = np.repeat(np.arange(len(pieces.sources)), np.diff(pieces.first_run))
    return np.concatenate([pieces.surface, of_run])


def kept_inside(pieces: Pieces, bounds: np.ndarray) -> np.ndarray:
    """Whether each element is in the box, and the first of those with the same corners.

    The walls cut at the sides of the box: a run lies on one side of each, as any of its triangles.
    """
    beyond = _beyond(pieces.x, bounds)
    a, b, c = pieces.triangles.T
    kept = [~(beyond[a] | beyond[b] | beyond[c]) & (pieces.twin == np.arange(len(pieces.twin)))]
    for source, strips in zip(pieces.sources, pieces.strips, strict=True):
        if strips is not None:
            keys = lowest_keys(strips.places, strips.runs)
            corners = source.places_of_nodes(source.corners_of_keys(keys).ravel()) - pieces.origin
            kept.append(~_beyond(corners, bounds).reshape(-1, 3).any(axis=1))
    return np.concatenate(kept)


def _beyond(points: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """Whether points (n, 3) lie outside of bounds (2, 3); axis by axis, which is quicker."""
    out = np.zeros(len(points), dtype=bool)
    for axis, (low, high) in enumerate(bounds.T):
        out |= points[:, axis] < low
        out |= points[:, axis] > high
    return out


def connected_pieces(pieces: Pieces, kept: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Connected piece of each element inside, and the pieces that hold a wall."""
    n_core = len(pieces.triangles)
    linked = np.flatnonzero(pieces.link >= 0)
    pairs = [np.stack([linked // 3, n_core + pieces.link[linked]], axis=1)]
    for i, strips in enumerate(pieces.strips):
        if strips is not None:
            pairs.append(strips.joined + n_core + pieces.first_run[i])
    piece = connected(pieces.ring, kept, np.concatenate(pairs))
    wall = np.array([source.role == "wall" for source in pieces.sources])
    # where a wall coincides with another surface, the first of them stands for both
    first = np.concatenate([pieces.twin, np.arange(n_core, len(kept))])
    rows = first[wall[surface_of_elements(pieces)]]
    return piece, np.unique(piece[rows[kept[rows]]])


def joined_sides(patches: Patches, pieces: Pieces, kept: np.ndarray):
    """
    Join the sides of elements around every edge.

    Parameters
    ----------
    patches : Patches
    pieces : Pieces
    kept : ndarray of bool, shape (n,)
        Elements that take part.

    Returns
    -------
    ndarray of int64, shape (2 n,)
        One side for all those that see the same, and each of them.
    ndarray of float64, shape (n_triangle, 3, 3)
        Corners of the input triangle that each triangle is a part of, local.

    Raises
    ------
    InvariantError
        If two different triangles lie in one half-plane of an edge.
    """
    sides = np.arange(2 * len(kept))
    parent, px = _parents(pieces)
    m, w = frame_of(px)
    of = np.arange(len(px)).reshape(-1, 3)
    bad = join_sides(
        pieces.x, pieces.triangles, pieces.ring, pieces.link, kept, parent, px, of, m, w, sides
    )
    if bad >= 0:
        name = patches.names[pieces.surface[bad // 3]]
        where = place(pieces.x[pieces.triangles[bad // 3, bad % 3]] + patches.origin)
        raise InvariantError(
            f"two triangles of surface {name!r} and another lie in one half-plane at {where}; "
            "please report this with the surfaces."
        )
    joined = [np.empty((0, 2), dtype=np.int64)]
    rims = [np.empty(0, dtype=np.int64)]
    for i, strips in enumerate(pieces.strips):
        if strips is not None:
            joined.append(strips.joined + pieces.first_run[i])
            rims.append(strips.runs[:, RIM])
    join_run_sides(np.concatenate(joined), np.concatenate(rims), kept, sides)
    return _roots(sides), px[of[parent]] if len(parent) else np.empty((0, 3, 3))


def _parents(pieces: Pieces) -> tuple[np.ndarray, np.ndarray]:
    """For each triangle its input triangle, and the corners of those, three rows each.

    The parts of one follow each other.
    """
    surface, key = pieces.surface, pieces.key
    new = np.ones(len(key), dtype=bool)
    new[1:] = (key[1:] != key[:-1]) | (surface[1:] != surface[:-1])
    number, first = np.cumsum(new) - 1, np.flatnonzero(new)
    px = np.empty((len(first), 3, 3))
    for i, source in enumerate(pieces.sources):
        mine = surface[first] == i
        corners = source.corners_of_keys(key[first[mine]])
        px[mine] = source.places_of_nodes(corners.ravel()).reshape(-1, 3, 3) - pieces.origin
    return number, px.reshape(-1, 3)


def _roots(sides: np.ndarray) -> np.ndarray:
    """The root of each element of a union-find forest, by pointer jumping."""
    while True:
        onward = sides[sides]
        if np.array_equal(onward, sides):
            return sides
        sides = onward
