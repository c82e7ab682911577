"""Which cells lie outside the walls, where these are not the six sides of a box.

Whether a piece of space is inside can change at walls only. So cells are joined across all
other surfaces, and the caps, which lie in the planes of the bounds, tell which side is which.
"""

from __future__ import annotations

import numpy as np

from geosurf.carve.links import joined
from geosurf.conventions import place
from geosurf.errors import InvariantError, OpenUnitError
from geosurf.model import Patches


def walls_are_a_box(patches: Patches, bounds: np.ndarray) -> bool:
    """Whether all walls lie in the six planes of their bounds (2, 3), local."""
    for wall in (s for s in patches.sources if s.role == "wall"):
        corners = (wall.vertices - patches.origin)[wall.triangles]
        flush = (corners[:, :, None, :] == bounds[None, None]).all(axis=1)
        if not flush.any(axis=(1, 2)).all():
            return False
    return True


def outside_of_fence(
    patches: Patches,
    bounds: np.ndarray,
    is_wall: np.ndarray,
    shell: np.ndarray,
    parents: np.ndarray,
    corners: np.ndarray,
) -> np.ndarray:
    """
    Shells outside the walls.

    Parameters
    ----------
    patches : Patches
    bounds : ndarray of float64, shape (2, 3)
        Lower and upper corner of all walls, local.
    is_wall : ndarray of bool, shape (n,)
        Faces that a wall owns, perhaps among others.
    shell : ndarray of int64, shape (2 n,)
        Shell of each side of each face.
    parents, corners : ndarray of float64, shape (n_triangle, 3, 3)
        Of the input triangle of each of the first faces, triangles all, and of itself.

    Returns
    -------
    ndarray of int64

    Raises
    ------
    OpenUnitError
        If a way leads around the walls.
    """
    numbers, at = np.unique(shell, return_inverse=True)
    sides = at.reshape(-1, 2)
    root = joined(len(numbers), np.unique(sides[~is_wall], axis=0))
    a, b, c = (parents[:, k] for k in range(3))
    rise = np.cross(b - a, c - a)[:, 2]
    inner, outer = [], []
    for z, out in zip(bounds[:, 2], (-1.0, 1.0), strict=True):
        cap = is_wall[: len(corners)] & (corners[:, :, 2] == z).all(axis=1) & (rise != 0)
        cap = np.flatnonzero(cap)
        front_is_out = (rise[cap] > 0) == (out > 0)
        outer.append(sides[cap, np.where(front_is_out, 0, 1)])
        inner.append(sides[cap, np.where(front_is_out, 1, 0)])
    beyond, within = (np.unique(root[np.concatenate(part)]) for part in (outer, inner))
    leaks = np.flatnonzero(is_wall & np.isin(root[sides], beyond).all(axis=1))
    if len(leaks) or len(within) == 0:
        where = corners[leaks[0]].mean(axis=0) if len(leaks) else bounds.mean(axis=0)
        raise OpenUnitError(
            f"the walls of the model are open: one has the outside on both of its sides at "
            f"{place(where + patches.origin)}. Give all of them without holes, as "
            "build_walls(box, aoi) makes them.",
            place=where + patches.origin,
        )
    if not np.isin(root, np.concatenate([beyond, within])).all():
        raise InvariantError(
            "a piece of space is neither inside nor outside the walls; please report this with "
            "the surfaces."
        )
    outside: np.ndarray = numbers[np.isin(root, beyond)]
    return outside


def footprint_of(patches: Patches, bounds: np.ndarray) -> float:
    """Area of the model in map view [m2]: of the walls in the plane of the lower bound."""
    total = 0.0
    for wall in (s for s in patches.sources if s.role == "wall"):
        corners = (wall.vertices - patches.origin)[wall.triangles]
        corners = corners[(corners[:, :, 2] == bounds[0, 2]).all(axis=1)]
        a, b, c = (corners[:, k, :2] for k in range(3))
        turn = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
        total += float(np.abs(turn).sum()) / 2.0
    return total
