"""Intersect vertical lines with closed shells: where they enter and leave, and the length inside.

A line meets a triangle where its foot is inside the triangle's shadow on the map. Whether it is, is
decided by exact signs. A foot on the rim of a shadow counts for exactly one of the triangles there:
each foot is thought to be moved, infinitely little, towards the middle of the model, east or
west and then, infinitely less, north or south (simulation of simplicity, Edelsbrunner & Mücke
1990, doi 10.1145/77635.77639). So a line enters a closed shell as often as it leaves it, triangles
that are vertical are never met, and lines on the rim of the box see what is inside.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geosurf.kernels.exact.predicates import ORIENT2D_BOUND, TINY, frame_of, orient2d_rows
from geosurf.kernels.search.rays import feet_in_shadows
from geosurf.model import Patches, TriSurface


@dataclass(frozen=True, eq=False)
class Crossings:
    """Where vertical lines cross the triangles of a shell.

    Attributes
    ----------
    foot : ndarray of int64, shape (n,)
        Row of the feet.
    triangle : ndarray of int64, shape (n,)
    way : ndarray of int64, shape (n,)
        +1 where the triangle faces up, -1 where it faces down.
    elevation : ndarray of float64, shape (n,)
        As the vertices have it [m].
    """

    foot: np.ndarray
    triangle: np.ndarray
    way: np.ndarray
    elevation: np.ndarray


def cross_columns(
    x: np.ndarray, triangles: np.ndarray, feet: np.ndarray, middle: np.ndarray | None = None
) -> Crossings:
    """
    Find where vertical lines cross triangles.

    Parameters
    ----------
    x : ndarray of float64, shape (n_vertex, 3)
    triangles : ndarray of int64, shape (n_triangle, 3)
    feet : ndarray of float64, shape (n_foot, 2)
        In the frame of `x` [m].
    middle : ndarray of float64, shape (2,), optional
        Feet on the rim of a shadow count as if they were a little nearer to this. Default: the
        middle of the triangles; lines on their rim then see their inside.

    Returns
    -------
    Crossings
        Triangle by triangle.

    Examples
    --------
    >>> x = np.array([[0.0, 0, 1], [4, 0, 1], [4, 4, 5], [0, 4, 5]])
    >>> found = cross_columns(x, np.array([[0, 1, 2], [0, 2, 3]]), np.array([[2.0, 2]]), np.ones(2))
    >>> found.triangle.tolist(), found.way.tolist(), found.elevation.tolist()
    ([1], [1], [3.0])
    """
    if middle is None:
        used = x[triangles.ravel(), :2]
        middle = 0.5 * (used.min(axis=0) + used.max(axis=0)) if len(used) else np.zeros(2)

    # +1 counter-clockwise on the map, so the triangle faces up; -1 down; 0 for an upright one,
    # which has no shadow and is skipped
    facing = signs_of_turns(x[:, :2], triangles)
    face, foot, is_sure = _near(x, triangles, facing, feet, middle)

    # which way feet on rims move, east-west and north-south: +1 or -1, never 0
    rows = np.flatnonzero(~is_sure)
    push = np.where(feet[foot[rows]] <= middle, 1.0, -1.0)
    # feet are numbered after the vertices: one array for the sign of any three points
    points = np.concatenate([x[:, :2], feet[foot[rows]]])
    inside = np.ones(len(face), dtype=bool)
    for k in range(3):
        a, b = (triangles[face[rows], i % 3] for i in (k, k + 1))
        side = _seen_from(points, a, b, len(x) + np.arange(len(rows)), push)
        inside[rows] &= side == facing[face[rows]]
    face, foot = face[inside], foot[inside]
    return Crossings(foot, face, facing[face], elevations(x[triangles[face]], feet[foot]))


def signs_of_turns(x: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Sign of the turn of three points (n, 3): a float filter first, exact integers behind it."""
    a, b, c = (x[rows[:, k]] for k in range(3))

    # the filter of Shewchuk (1997), section 4: a determinant larger than the bound on its own
    # rounding has the right sign; TINY guards the bound against underflow
    u, v = b - a, c - a
    left, right = u[:, 0] * v[:, 1], u[:, 1] * v[:, 0]
    det, size = left - right, np.abs(left) + np.abs(right)
    sure = (np.abs(det) > ORIENT2D_BOUND * size) & (size > TINY)
    sign = np.sign(det).astype(np.int64)
    # on a corner, or along an axis: differences are 0 where coordinates are equal, and only there
    zero = (b == c).all(axis=1)
    zero |= ((u[:, 0] == 0) | (v[:, 1] == 0)) & ((u[:, 1] == 0) | (v[:, 0] == 0))
    sign[zero] = 0
    sure |= zero

    # the rest, a small share, is decided by exact integers; only their points are scaled
    open_rows = np.flatnonzero(~sure)
    if len(open_rows):
        used, mine = np.unique(rows[open_rows], return_inverse=True)
        points = np.zeros((len(used), 3))
        points[:, :2] = x[used, :2]
        m, w = frame_of(points)
        out = np.empty(len(open_rows), dtype=np.int64)
        orient2d_rows(points, mine.reshape(-1, 3), m, w, out)
        sign[open_rows] = out
    return sign


def _seen_from(
    points: np.ndarray, a: np.ndarray, b: np.ndarray, foot: np.ndarray, push: np.ndarray
) -> np.ndarray:
    """Whether feet, moved by nearly nothing, lie left (+1) or right (-1) of edges a -> b.

    Never 0, unless a and b are one place in the map.
    """
    # 0 means that the foot is on the line of the edge: its nudge decides. The change of the
    # determinant is -dy to the east and +dx to the north; north counts only where dy is 0, since it
    # is infinitely smaller
    sign = signs_of_turns(points, np.stack([a, b, foot], axis=1))
    on = np.flatnonzero(sign == 0)
    step = points[b[on]] - points[a[on]]
    east, north = np.sign(-step[:, 1] * push[on, 0]), np.sign(step[:, 0] * push[on, 1])
    sign[on] = np.where(east != 0, east, north).astype(np.int64)
    return sign


def _near(
    x: np.ndarray, triangles: np.ndarray, facing: np.ndarray, feet: np.ndarray, middle: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Triangles and feet in their shadows, and which of these pairs are sure.

    Feet lie in strips from south to north, sorted by easting in each.
    """
    northings, north = np.unique(feet[:, 1], return_inverse=True)
    # about sqrt(n) strips: a box then reads few strips that it only touches, and each strip holds
    # about sqrt(n) feet
    n_strip = min(len(northings), 1 + int(np.sqrt(len(feet))))
    strip_of = np.arange(len(northings)) * n_strip // max(len(northings), 1)
    first = np.searchsorted(strip_of, np.arange(n_strip + 1))
    limits = np.column_stack([northings[first[:-1]], northings[first[1:] - 1]])
    order = np.lexsort((feet[:, 0], strip_of[north]))
    start = np.searchsorted(strip_of[north[order]], np.arange(n_strip + 1))

    given = np.ascontiguousarray(x), triangles, facing, feet[order], start, limits, middle
    pairs = np.empty((2 * len(feet) + 64, 3), dtype=np.int64)
    n = feet_in_shadows(*given, pairs)
    if n > len(pairs):
        pairs = np.empty((n, 3), dtype=np.int64)
        feet_in_shadows(*given, pairs)
    face, foot, is_sure = pairs[:n].T
    return face, order[foot], is_sure == 1


def weights_at(corners: np.ndarray, feet: np.ndarray) -> np.ndarray:
    """Weights (n, 3) of the corners of triangles (n, 3, 3) at feet inside their shadows."""
    # barycentric weights: twice the area of the triangle of the foot and the other two corners
    p = [corners[:, k, :2] - feet for k in range(3)]
    weight = np.stack(
        [
            p[(k + 1) % 3][:, 0] * p[(k + 2) % 3][:, 1]
            - p[(k + 1) % 3][:, 1] * p[(k + 2) % 3][:, 0]
            for k in range(3)
        ],
        axis=1,
    )
    # all have one sign, but for rounding: the elevation stays between those of the corners
    weight = np.maximum(weight * np.sign(weight.sum(axis=1))[:, None], 0.0)
    weight[weight.sum(axis=1) == 0] = 1.0
    return weight


def shares_at(corners: np.ndarray, feet: np.ndarray) -> np.ndarray:
    """The same weights with a sum of 1: shares of the corners in values at the feet."""
    weight = weights_at(corners, feet)
    return weight / weight.sum(axis=1, keepdims=True)


def elevations(corners: np.ndarray, feet: np.ndarray) -> np.ndarray:
    """Elevation of triangles (n, 3, 3) at feet (n, 2) inside their shadows."""
    weight = weights_at(corners, feet)
    z = corners[:, :, 2]

    # sum of differences from the lowest corner: a level triangle gets its elevation exactly
    lowest = z.min(axis=1)
    return lowest + (weight * (z - lowest[:, None])).sum(axis=1) / weight.sum(axis=1)


# ---- well columns ----------------------------------------
# Vertical lines through wells: where they cross a horizon, and which faults lie between.
#
# A top is compared with the horizon straight above or below it. Whether a vertical line meets a
# triangle is decided by exact signs (`geosurf.measure.columns`), so each place has one answer.


@dataclass(frozen=True, eq=False)
class Columns(Crossings):
    """What the vertical lines through some points cross, sorted by point and elevation.

    Attributes
    ----------
    foot : ndarray of int64, shape (n,)
        Row of the point.
    triangle : ndarray of int64, shape (n,)
        Row of the triangles of the patches.
    way : ndarray of int64, shape (n,)
        +1 where the triangle faces up, -1 where it faces down.
    elevation : ndarray of float64, shape (n,)
        [m], in the world.
    surface : ndarray of int64, shape (n,)
        Row of the sources of the patches.
    """

    surface: np.ndarray

    def at(self, foot: int) -> slice:
        """Crossings of one point, from the bottom up."""
        start, stop = np.searchsorted(self.foot, [foot, foot + 1]).tolist()
        return slice(start, stop)


def columns_through(
    patches: Patches, points: np.ndarray, triangles: np.ndarray | None = None
) -> Columns:
    """
    Find what the vertical lines through points cross.

    Parameters
    ----------
    patches : Patches
    points : ndarray of float64, shape (n_point, 3)
        World coordinates [m].
    triangles : ndarray of int64, optional
        Rows of the triangles to look at; default: all.

    Returns
    -------
    Columns
    """
    rows = np.arange(patches.n_triangle) if triangles is None else triangles

    # only moved to the origin of the model: the crossing itself is decided in local coordinates
    feet = points[:, :2] - patches.origin[:2]
    found = cross_columns(patches.local, patches.triangles[rows], feet)

    # by point, then from the bottom up; triangles that coincide come in the order of their rows
    order = np.lexsort((found.triangle, found.elevation, found.foot))
    triangle = rows[found.triangle[order]]
    return Columns(
        found.foot[order],
        triangle,
        found.way[order],
        found.elevation[order] + patches.origin[2],
        patches.surface_of_triangle[triangle],
    )


def nearest_first(elevation: np.ndarray, picked: float) -> np.ndarray:
    """Order of elevations by their distance from a top; of two as near, the lower one first."""
    return np.lexsort((elevation, np.abs(elevation - picked)))


def fault_between(elevation: np.ndarray, names: Sequence[str], picked: float, model: float) -> str:
    """Name of the fault between a top and the horizon, next to the top; '' if none is there."""
    low, high = min(picked, model), max(picked, model)

    # a fault exactly at the top or at the horizon is not between them
    inside = np.flatnonzero((elevation > low) & (elevation < high))
    if not len(inside):
        return ""
    return names[inside[np.abs(elevation[inside] - picked).argmin()]]


def residuals(surface: TriSurface, points: np.ndarray) -> np.ndarray:
    """
    Return how far points lie above a surface [m], the nearest part of it; NaN where it has none.

    Parameters
    ----------
    surface : TriSurface
    points : ndarray of float64, shape (n, 3)

    Examples
    --------
    >>> flat = TriSurface("Top", "horizon", [[0, 0, 5], [9, 0, 5], [0, 9, 5]], [[0, 1, 2]])
    >>> residuals(flat, np.array([[1.0, 1, 7], [9, 9, 7]])).tolist()
    [2.0, nan]
    """
    x = surface.vertices - points[0]
    feet = points - points[0]
    found = cross_columns(x, surface.triangles, feet[:, :2])
    off = feet[found.foot, 2] - found.elevation
    nearest = np.full(len(points), np.nan)
    # the smallest distance is written last
    order = np.argsort(-np.abs(off), kind="stable")
    nearest[found.foot[order]] = off[order]
    return nearest
