"""Find the cells outside the walls: a box, a fence, or closed shells of any shape.

Whether a piece of space is inside can change at walls only. So cells are joined across all other
surfaces. The planes of a box decide which side is which; for other walls a ray decides.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from geosurf.carve.measures import volume_of
from geosurf.conventions import place
from geosurf.errors import GeometryError, InvariantError, OpenUnitError
from geosurf.kernels.meshes.mesh import join_pairs, renumbered
from geosurf.kernels.search.tree import triangle_boxes
from geosurf.model import Patches

# ---- rays ----------------------------------------
# Shoot rays along the axes through pieces of surfaces, to find what encloses them.
#
# Few models need any: pieces that touch nothing else, and walls that are no box. So each ray is one
# of exact fractions, over the triangles in the column of its first one.


NO_HIT = -1
_SLIP = 1e-6  # [m] beside a column; far more than rounding an aim moves it by
_AREA = 1e-15  # of products of lengths; three times what rounding takes from their difference


class Rays:
    """Rays through some triangles.

    Parameters
    ----------
    x, t : ndarray
        Points and triangles.

    Examples
    --------
    Three level triangles above one another; a ray leaves the lowest by its front (2 * 0), and meets
    the next one from behind (2 * 1 + 1):

    >>> corners = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0.0]])
    >>> x = np.concatenate([corners + [0, 0, z] for z in (0, 1, 2)])
    >>> rays = Rays(x, np.arange(9).reshape(3, 3))
    >>> rays.shoot(np.array([0, 2]), np.arange(3)).tolist()
    [[0, 3], [4, -1]]
    """

    def __init__(self, x: np.ndarray, t: np.ndarray) -> None:
        self.x, self.t = np.ascontiguousarray(x), np.ascontiguousarray(t)
        self.boxes = triangle_boxes(self.x, self.t)

    def shoot(
        self, starts: np.ndarray, set_of: np.ndarray, seen: np.ndarray | None = None
    ) -> np.ndarray:
        """Sides where rays leave their sets, and the first sides of others that they meet then.

        A ray runs along the axis on which its first triangle is widest.

        Parameters
        ----------
        starts : ndarray of int64, shape (n,)
            First triangle of each ray.
        set_of : ndarray of int64, shape (n_triangle,)
            The set of each triangle; a ray is of that of its first triangle.
        seen : ndarray of bool, shape (n_triangle,), optional
            Which triangles hold others. Default: all.

        Returns
        -------
        ndarray of int64, shape (n, 2)
            ``2 * triangle`` for a front, one more for a back; `NO_HIT` where a ray meets no more.
        """
        seen = np.ones(len(self.t), dtype=bool) if seen is None else seen
        a, b, c = (self.x[self.t[starts, k]] for k in range(3))

        # the axis along which the triangle's shadow is largest: rays meet it least obliquely
        axes = np.abs(np.cross(b - a, c - a)).argmax(axis=1)
        rays = zip(starts.tolist(), axes.tolist(), strict=True)
        return np.array([self._ray(*ray, set_of, seen) for ray in rays]).reshape(-1, 2)

    def _ray(self, start: int, axis: int, set_of: np.ndarray, seen: np.ndarray) -> tuple[int, int]:
        """Where one ray leaves its set, and what it meets then.

        It aims at rational points inside its first triangle until it misses all edges. The points
        lie on a conic: an edge is in the way of two of them at most, so one of 6 n + 1 is free.
        """
        u, v = (axis + 1) % 3, (axis + 2) % 3
        corners = self.x[self.t[start]]
        rows = self._column(start, axis)

        # only triangles that count: those that hold others, and those of the ray's own set
        rows = rows[seen[rows] | (set_of[rows] == set_of[start])]
        x = self.x[self.t[rows]][:, :, [u, v]]
        for step in range(1, 6 * len(rows) + 2):
            ratio = Fraction(step + 30, 40)
            total = 1 + ratio + ratio * ratio

            # points (1, r, r^2) / (1 + r + r^2): a conic inside the triangle
            weights = (1 / total, ratio / total, ratio * ratio / total)
            aim = [
                sum(f * Fraction(float(p[k])) for f, p in zip(weights, corners, strict=True))
                for k in (u, v)
            ]

            # left out in floats: triangles with the aim beyond one edge, by more than its rounding
            off = x - [float(at) for at in aim]
            ahead = np.roll(off, -1, axis=1)
            left, right = off[:, :, 0] * ahead[:, :, 1], off[:, :, 1] * ahead[:, :, 0]
            slip = _SLIP * np.abs(ahead - off).sum(axis=2) + _AREA * (np.abs(left) + np.abs(right))
            turn = left - right
            passed = rows[~((turn > slip).any(axis=1) & (turn < -slip).any(axis=1))]
            hits = [_hit(self.x[self.t[i]], axis, u, v, aim) for i in passed]
            if None in hits:
                continue  # the ray grazes an edge: aim elsewhere
            met = [(h[0], int(i), h[1]) for i, h in zip(passed, hits, strict=True) if h]
            top = max((hit for hit in met if set_of[hit[1]] == set_of[start]), key=_first)
            above = [hit for hit in met if set_of[hit[1]] != set_of[start] and hit[0] > top[0]]
            # the side towards +axis is the front where the normal points there
            outer = 2 * top[1] + (0 if top[2] > 0 else 1)
            if not above:
                return outer, NO_HIT
            first = min(above, key=_first)
            return outer, 2 * first[1] + (1 if first[2] > 0 else 0)
        raise InvariantError(
            f"no ray passes through the inside of a floating triangle at {place(corners[0])} in "
            "local coordinates; please report this with the surfaces."
        )

    def _column(self, start: int, axis: int) -> np.ndarray:
        """Triangles above a triangle along an axis, and beside those, in order."""
        low, high = np.split(self.boxes[start] + np.repeat([-_SLIP, _SLIP], 3), 2)
        high[axis] = np.inf
        return np.flatnonzero(
            (self.boxes[:, :3] <= high).all(axis=1) & (self.boxes[:, 3:] >= low).all(axis=1)
        )


def _first(hit: tuple[Fraction, int, int]) -> Fraction:
    return hit[0]


def _hit(
    corners: np.ndarray, axis: int, u: int, v: int, aim: Sequence[Fraction | int]
) -> tuple[Fraction, int] | tuple[()] | None:
    """(height, sign of the normal along the axis), () for a miss, None on an edge."""
    # twice the areas of the triangles of the aim and two corners: their signs say where it is
    p = [[Fraction(float(c[k])) for k in (u, v, axis)] for c in corners]
    areas = []
    for i in range(3):
        q, r = p[i], p[(i + 1) % 3]
        areas.append((q[0] - aim[0]) * (r[1] - aim[1]) - (q[1] - aim[1]) * (r[0] - aim[0]))
    if all(area > 0 for area in areas) or all(area < 0 for area in areas):
        total = sum(areas)
        height = Fraction(sum(areas[(i + 1) % 3] * p[i][2] for i in range(3)) / total)
        return height, 1 if total > 0 else -1

    # signs of both kinds: outside; a zero among equal signs: on an edge
    if any(area > 0 for area in areas) and any(area < 0 for area in areas):
        return ()
    return None


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


def _corners_of_walls(patches: Patches) -> np.ndarray:
    """Local corners (n, 3, 3) of the triangles of all walls."""
    walls = [source for source in patches.sources if source.role == "wall"]
    return np.concatenate([(wall.vertices - patches.origin)[wall.triangles] for wall in walls])


def walls_are_a_box(patches: Patches, bounds: np.ndarray) -> bool:
    """Whether all walls lie in the six planes of their bounds (2, 3), local."""
    # each triangle has its three corners in one of the six planes, to the last digit
    flush = (_corners_of_walls(patches)[:, :, None, :] == bounds[None, None]).all(axis=1)
    return bool(flush.any(axis=(1, 2)).all())


def walls_among(patches: Patches, owners: Sequence[tuple[tuple[int, int], ...]]) -> np.ndarray:
    """The first wall among the surfaces of each set, int64 (n,); -1 for none."""
    wall = [source.role == "wall" for source in patches.sources]
    return np.array([next((i for i, _ in of if wall[i]), -1) for of in owners])


def outside_of_walls(
    patches: Patches, wall_of: np.ndarray, sides: np.ndarray, x: np.ndarray, triangles: np.ndarray
) -> np.ndarray:
    """
    Sides that see the outside of walls of any shape.

    Inside is what walls part from the far distance, so that a shell in another one makes no
    hollow. How walls are turned does not matter.

    Parameters
    ----------
    patches : Patches
    wall_of : ndarray of int64, shape (n,)
        The wall that owns each element, perhaps among other surfaces; -1 for none.
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
    root = join_pairs(sides[wall_of < 0], len(numbers))
    walls = np.flatnonzero(wall_of[: len(triangles)] >= 0)
    # beyond the last wall that a ray meets is the outside
    outer = Rays(x, triangles[walls]).shoot(np.array([0]), np.full(len(walls), -1))[0, 0]
    beyond = root[sides[walls[outer // 2], outer % 2]]

    # a wall with the outside on both sides encloses nothing
    open_ = walls[(root[sides[walls]] == beyond).all(axis=1)]
    if len(open_):
        name = patches.names[wall_of[open_[0]]]
        where = x[triangles[open_[0]]].mean(axis=0) + patches.origin
        raise OpenUnitError(
            f"the walls of the model are open: wall {name!r} has no unit on either side at "
            f"{place(where)}. Pass all walls without holes, as from build_walls(box) with its six "
            "sides, or build_walls(box, aoi).",
            place=where,
            surfaces=(name,),
        )
    return numbers[root == beyond]


def is_fence(patches: Patches, bounds: np.ndarray) -> bool:
    """Whether all walls are vertical or lie in the planes of the lower and the upper bound."""
    # fences are upright, or level at the bottom and the top
    corners = _corners_of_walls(patches)
    level = (corners[:, :, None, 2] == bounds[None, None, :, 2]).all(axis=1).any(axis=1)
    return bool((level | (rise_of(corners) == 0)).all())


def footprint_of(patches: Patches, bounds: np.ndarray) -> float:
    """Area in map view of a model in a fence [m2]: of the walls in the plane of the lower bound."""
    corners = _corners_of_walls(patches)
    corners = corners[(corners[:, :, 2] == bounds[0, 2]).all(axis=1)]
    return float(np.abs(rise_of(corners)).sum()) / 2.0


def size_of_shells(x: np.ndarray, outward: np.ndarray) -> tuple[float, float]:
    """Area in map view [m2] and volume [m3] inside walls, given their triangles turned outward.

    The area is that of the walls that look down: a place over which the model is in several layers
    counts once for each.
    """
    rise = rise_of(x[outward])
    return float(np.abs(rise[rise < 0]).sum()) / 2.0, volume_of(x, outward)


def rise_of(corners: np.ndarray) -> np.ndarray:
    """Twice the area in the map of triangles (n, 3, 3), below 0 where they look down."""
    a, b, c = (corners[:, k, :2] for k in range(3))
    return (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]


__all__ = ["NO_HIT", "Rays"]
