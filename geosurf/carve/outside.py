"""Which cells lie outside the walls: the six sides of a box, or a fence.

Whether a piece of space is inside can change at walls only. So cells are joined across all
other surfaces, and the caps, which lie in the planes of the bounds, tell which side is which.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeometryError, InvariantError, OpenUnitError
from geosurf.kernels.mesh import join_pairs
from geosurf.model import Patches


def box_of(patches: Patches) -> np.ndarray:
    """Lower and upper corner of the model box, local, from the walls among the surfaces."""
    walls = [s for s in patches.sources if s.role == "wall"]
    if not walls:
        raise GeometryError(
            "there are no walls among the surfaces, so that no unit can close. Add the six "
            "sides of the model box: surfaces + build_walls(box)."
        )
    corners = np.concatenate([wall.vertices for wall in walls]) - patches.origin
    return np.stack([corners.min(axis=0), corners.max(axis=0)])


def walls_are_a_box(patches: Patches, bounds: np.ndarray) -> bool:
    """Whether all walls lie in the six planes of their bounds (2, 3), local."""
    for wall in (s for s in patches.sources if s.role == "wall"):
        corners = (wall.vertices - patches.origin)[wall.triangles]
        flush = (corners[:, :, None, :] == bounds[None, None]).all(axis=1)
        if not flush.any(axis=(1, 2)).all():
            return False
    return True


def owned_by_walls(patches: Patches, owners: Sequence[tuple[tuple[int, int], ...]]) -> np.ndarray:
    """Whether a wall is among the surfaces of each set."""
    wall = [source.role == "wall" for source in patches.sources]
    return np.array([any(wall[i] for i, _ in of) for of in owners])


def outside_of_box(
    patches: Patches,
    is_wall: np.ndarray,
    owners: Sequence[tuple[tuple[int, int], ...]],
    owner: np.ndarray,
    sides: np.ndarray,
    parents: np.ndarray,
    corners: np.ndarray,
) -> np.ndarray:
    """
    Sides that see the outside of the six walls of a box.

    Parameters
    ----------
    patches : Patches
    is_wall : ndarray of bool, shape (n,)
        Elements that a wall owns, perhaps among others; all of them are triangles.
    owners : sequence of tuple of (int, int)
        Sets of surfaces, with how they are turned.
    owner : ndarray of int64, shape (n,)
        The set that owns each element.
    sides : ndarray of int64, shape (n, 2)
        What is seen from the front and the back of each element.
    parents, corners : ndarray of float64, shape (n_triangle, 3, 3)
        Of the input triangle of each of the first elements, triangles all, and of itself.

    Returns
    -------
    ndarray of int64

    Raises
    ------
    OpenUnitError
        If they are seen from within, too.
    """
    rows = np.flatnonzero(is_wall)
    lower, upper = box_of(patches)
    a, b, c = (parents[rows, k] - 0.5 * (lower + upper) for k in range(3))
    inward = (np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) < 0).astype(np.int64)
    outside = np.unique(sides[rows, inward])
    leaks = rows[np.isin(sides[rows, 1 - inward], outside)]
    if len(leaks):
        of = owners[owner[leaks[0]]]
        name = next(patches.names[i] for i, _ in of if patches.sources[i].role == "wall")
        where = corners[leaks[0]].mean(axis=0) + patches.origin
        raise OpenUnitError(
            f"the model box is open: wall {name!r} has the outside on both of its sides at "
            f"{place(where)}. Give all six sides without holes, as build_walls(box) makes them.",
            place=where, surfaces=(name,),
        )  # fmt: skip
    return outside


def outside_of_fence(
    patches: Patches,
    bounds: np.ndarray,
    is_wall: np.ndarray,
    sides: np.ndarray,
    parents: np.ndarray,
    corners: np.ndarray,
) -> np.ndarray:
    """
    Sides that see the outside of walls that are no box.

    Parameters
    ----------
    patches : Patches
    bounds : ndarray of float64, shape (2, 3)
        Lower and upper corner of all walls, local.
    is_wall : ndarray of bool, shape (n,)
        Elements that a wall owns, perhaps among others.
    sides, parents, corners
        As for `outside_of_box`.

    Returns
    -------
    ndarray of int64

    Raises
    ------
    OpenUnitError
        If a way leads around the walls.
    """
    numbers, at = np.unique(sides, return_inverse=True)
    sides = at.reshape(-1, 2)
    root = join_pairs(sides[~is_wall], len(numbers))
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
