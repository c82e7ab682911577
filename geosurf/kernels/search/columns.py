"""Intersect vertical lines with triangles: where they enter and leave closed shells.

A line meets a triangle where its foot is inside the triangle's shadow on the map. Whether it is, is
decided by exact signs. A foot on the rim of a shadow counts for exactly one of the triangles there:
each foot is thought to be moved, infinitely little, towards the middle of the model, east or
west and then, infinitely less, north or south (simulation of simplicity, Edelsbrunner & Mücke
1990, doi 10.1145/77635.77639). So a line enters a closed shell as often as it leaves it, triangles
that are vertical are never met, and lines on the rim of the box see what is inside.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.exact.predicates import ORIENT2D_BOUND, TINY, frame_of, orient2d_rows

# ---- shadows ----------------------------------------
# Which feet of vertical lines lie in the shadows of triangles on the map?
#
# Feet lie in strips from south to north, sorted by easting in each. A foot on an edge is thought to
# be moved, infinitely little, east or west, and then, infinitely less, north or south (`push`).
# Signs that float arithmetic leaves open are for the caller.


@scalar
def _seen_from_edge(x, a, b, east, north, push):
    """+1 if a foot lies left of edge a -> b, -1 if right, 0 if that is open or a is over b."""
    ux, uy = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1]
    vx, vy = east - x[a, 0], north - x[a, 1]
    left, right = ux * vy, uy * vx
    det, size = left - right, abs(left) + abs(right)
    if size > TINY and abs(det) > ORIENT2D_BOUND * size:
        return 1 if det > 0.0 else -1
    # on a corner, or along an axis: differences are 0 where coordinates are equal, and only there
    at_end = x[b, 0] == east and x[b, 1] == north
    if not (at_end or ((ux == 0.0 or vy == 0.0) and (uy == 0.0 or vx == 0.0))):
        return 0
    # the determinant changes by -uy to the east; to the north, infinitely less, by ux
    change = -uy * push[0] if uy != 0.0 else ux * push[1]
    return 1 if change > 0.0 else (-1 if change < 0.0 else 0)


@scalar
def _first_at_least(rows, column, low, high, value):
    """The first of some rows, rising in a column, that is not below a value; `high` if all are."""
    while low < high:
        half = (low + high) // 2
        if rows[half, column] < value:
            low = half + 1
        else:
            high = half
    return low


@entry("d2 l2 l1 d2 l1 d2 d1 l2* -> l")
def feet_in_shadows(x, t, facing, feet, start, limits, middle, pairs):
    """Write triangle, foot, and whether that is sure, for feet in shadows or on their rims; their
    number. Those beyond the capacity are counted only.

    Triangles that face 0 have no shadow. Strip k has feet from ``start[k]`` on, with northings
    from ``limits[k, 0]`` to ``limits[k, 1]``. Feet on a rim are moved towards `middle`.
    """
    n, n_strip = 0, limits.shape[0]
    push = np.empty(2)
    for f in range(t.shape[0]):
        if facing[f] == 0:
            continue
        a, b, c = t[f, 0], t[f, 1], t[f, 2]
        west = min(x[a, 0], x[b, 0], x[c, 0])
        east = max(x[a, 0], x[b, 0], x[c, 0])
        south = min(x[a, 1], x[b, 1], x[c, 1])
        north = max(x[a, 1], x[b, 1], x[c, 1])

        # strips that reach up to the box, and in each the feet that are not west of it
        strip = _first_at_least(limits, 1, 0, n_strip, south)
        while strip < n_strip and limits[strip, 0] <= north:
            foot = _first_at_least(feet, 0, start[strip], start[strip + 1], west)
            while foot < start[strip + 1] and feet[foot, 0] <= east:
                if south <= feet[foot, 1] <= north:
                    push[0] = 1.0 if feet[foot, 0] <= middle[0] else -1.0
                    push[1] = 1.0 if feet[foot, 1] <= middle[1] else -1.0
                    is_out, is_sure = False, 1
                    for k in range(3):
                        side = _seen_from_edge(
                            x, t[f, k], t[f, (k + 1) % 3], feet[foot, 0], feet[foot, 1], push
                        )
                        if side == -facing[f]:
                            is_out = True
                            break
                        if side == 0:
                            is_sure = 0
                    if not is_out:
                        if n < pairs.shape[0]:
                            pairs[n, 0], pairs[n, 1], pairs[n, 2] = f, foot, is_sure
                        n += 1
                foot += 1
            strip += 1
    return n


# ---- crossings ----------------------------------------


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
        used = x[np.ravel(triangles), :2]
        middle = 0.5 * (np.min(used, axis=0) + np.max(used, axis=0)) if len(used) else np.zeros(2)

    facing = signs_of_turns(x[:, :2], triangles)
    face, foot = met_by_columns(x, triangles, facing, feet, middle)
    return Crossings(foot, face, facing[face], elevations(x[triangles[face]], feet[foot]))


def met_by_columns(
    x: np.ndarray, triangles: np.ndarray, facing: np.ndarray, feet: np.ndarray, middle: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Triangles that vertical lines cross, and the feet of these, triangle by triangle.

    `facing` is +1 where a triangle goes round counter-clockwise on the map, so it faces up; -1
    where it faces down; 0 where it is upright: then it has no shadow and is skipped.
    """
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
    return face[inside], foot[inside]


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
        used, numbers = np.unique(rows[open_rows], return_inverse=True)
        points = np.zeros((len(used), 3))
        points[:, :2] = x[used, :2]
        m, w = frame_of(points)
        out = np.empty(len(open_rows), dtype=np.int64)
        orient2d_rows(points, np.reshape(numbers, (-1, 3)), m, w, out)
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
    pairs = np.empty((4 * len(feet) + 64, 3), dtype=np.int64)
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
    lowest = np.min(z, axis=1)
    return lowest + (weight * (z - lowest[:, None])).sum(axis=1) / weight.sum(axis=1)
