"""Find the cells outside the walls: a box, a fence, or closed shells of any shape.

Whether a piece of space is inside can change at walls only. So cells are joined across all other
surfaces. The planes of a box decide which side is which; for other walls a ray decides.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.carve.rays import Rays
from geosurf.carve.volume import volume_of
from geosurf.conventions import place
from geosurf.errors import GeometryError, OpenUnitError
from geosurf.kernels.lattices.sets import distinct
from geosurf.kernels.meshes.mesh import join_pairs
from geosurf.kernels.meshes.numbering import renumbered
from geosurf.model import Patches


def box_of(patches: Patches) -> np.ndarray:
    """Lower and upper corner of the model box, local, from the walls among the surfaces."""
    walls = [s for s in patches.sources if s.role == "wall"]
    if not walls:
        raise GeometryError(
            "the surfaces include no walls, so units cannot be closed. Add the six sides "
            "of the model box: surfaces + build_walls(box)."
        )

    # all vertices of walls lie on the box, so their bounds are the box
    corners = np.concatenate([wall.vertices for wall in walls]) - patches.origin
    return np.stack([corners.min(axis=0), corners.max(axis=0)])


def walls_are_a_box(patches: Patches, bounds: np.ndarray) -> bool:
    """Whether all walls lie in the six planes of their bounds (2, 3), local."""
    # each triangle has its three corners in one of the six planes, to the last digit
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
    # which side of a wall sees the outside: its normal against the way to the middle of the box
    rows = np.flatnonzero(is_wall)
    lower, upper = box_of(patches)
    a, b, c = (parents[rows, k] - 0.5 * (lower + upper) for k in range(3))
    inward = (np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) < 0).astype(np.int64)

    # what the wall sees beyond; nothing of the model may see the same, or the box is open
    outside = distinct(sides[rows, inward])
    leaks = rows[np.isin(sides[rows, 1 - inward], outside)]
    if len(leaks):
        of = owners[owner[leaks[0]]]
        name = next(patches.names[i] for i, _ in of if patches.sources[i].role == "wall")
        where = corners[leaks[0]].mean(axis=0) + patches.origin
        raise OpenUnitError(
            f"the model box is open: wall {name!r} has no unit on either side at "
f"{place(where)}. Pass all six sides without holes, as from build_walls(box).",
            place=where, surfaces=(name,),
        )  # fmt: skip
    return outside


def outside_of_shells(
    patches: Patches, is_wall: np.ndarray, sides: np.ndarray, x: np.ndarray, triangles: np.ndarray
) -> np.ndarray:
    """
    Sides that see the outside of walls of any shape.

    Inside is what walls part from the far distance, so that a shell in another one makes no
    hollow. How walls are turned does not matter.

    Parameters
    ----------
    patches : Patches
    is_wall : ndarray of bool, shape (n,)
        Elements that a wall owns, perhaps among others.
    sides : ndarray of int64, shape (n, 2)
        What is seen from the front and the back of each element.
    x, triangles : ndarray
        Points, local, and the first elements, triangles all.

    Returns
    -------
    ndarray of int64

    Raises
    ------
    OpenUnitError
        If a wall has the outside on both of its sides.
    """
    # joined across all other surfaces: inside and outside change at walls only
    numbers, sides = renumbered(sides)
    root = join_pairs(sides[~is_wall], len(numbers))
    walls = np.flatnonzero(is_wall[: len(triangles)])
    # beyond the last wall that a ray meets is the outside
    outer = Rays(x, triangles[walls]).shoot(np.array([0]), np.full(len(walls), -1))[0, 0]
    beyond = root[sides[walls[outer // 2], outer % 2]]

    # a wall with the outside on both sides encloses nothing
    open_ = walls[(root[sides[walls]] == beyond).all(axis=1)]
    if len(open_):
        where = x[triangles[open_[0]]].mean(axis=0) + patches.origin
        raise OpenUnitError(
            "the walls of the model are open: a wall has no unit on either side at "
            f"{place(where)}. Pass all walls without holes, as from build_walls(box, aoi).",
            place=where,
        )
    outside: np.ndarray = numbers[root == beyond]
    return outside


def is_fence(patches: Patches, bounds: np.ndarray) -> bool:
    """Whether all walls are vertical or lie in the planes of the lower and the upper bound."""
    # fences are upright, or level at the bottom and the top
    for wall in (s for s in patches.sources if s.role == "wall"):
        corners = (wall.vertices - patches.origin)[wall.triangles]
        level = (corners[:, :, None, 2] == bounds[None, None, :, 2]).all(axis=1).any(axis=1)
        if not (level | (_rise(corners) == 0)).all():
            return False
    return True


def footprint_of(patches: Patches, bounds: np.ndarray) -> float:
    """Area in map view of a model in a fence [m2]: of the walls in the plane of the lower bound."""
    total = 0.0
    for wall in (s for s in patches.sources if s.role == "wall"):
        corners = (wall.vertices - patches.origin)[wall.triangles]
        corners = corners[(corners[:, :, 2] == bounds[0, 2]).all(axis=1)]
        total += float(np.abs(_rise(corners)).sum()) / 2.0
    return total


def size_of_shells(x: np.ndarray, outward: np.ndarray) -> tuple[float, float]:
    """Area in map view [m2] and volume [m3] inside walls, given their triangles turned outward.

    The area is that of the walls that look down: a place over which the model is in several layers
    counts once for each.
    """
    rise = _rise(x[outward])
    return float(np.abs(rise[rise < 0]).sum()) / 2.0, volume_of(x, outward)


def _rise(corners: np.ndarray) -> np.ndarray:
    """Twice the area in the map of triangles (n, 3, 3), below 0 where they look down."""
    a, b, c = (corners[:, k, :2] for k in range(3))
    turn: np.ndarray = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    return turn
