"""Shells with fewer triangles: points of the same surfaces that are close together become one.

A point belongs to the set of surfaces that meet in it: points inside a surface become one with
each other, points of a line where two surfaces meet with others of that line. So a unit stays
closed, units that share a surface go on sharing it, and the ends of lines stay where they are. On a
plane the volume of a shell does not change. Lines stay as they are unless their triangles alone
take more than half of what may be drawn.

Source: vertex clustering after Rossignac & Borrel (1993), "Multi-resolution 3D approximations for
rendering complex scenes", in cells of the map; unlike them we never merge points of two surfaces.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from geosurf.kernels.meshes.numbering import first_seen, number_keys
from geosurf.kernels.meshes.point_surfaces import codes_of_points, highest_of_points
from geosurf.render.thin_units import UnitMesh

STEP, TRIES = 1.25, 16  # by how much cells grow at least in each attempt
LARGEST = 1 << 62  # number of a cell


def clustered(mesh: UnitMesh, max_triangle: int, exaggeration: float = 1.0) -> UnitMesh:
    """Return a mesh whose shells have about `max_triangle` triangles in all.

    Parameters
    ----------
    mesh : UnitMesh
    max_triangle : int
    exaggeration : float
        Vertical exaggeration of the picture: cells are lower by that.

    Returns
    -------
    UnitMesh
    """
    n = mesh.n_drawn
    if n <= max_triangle:
        return mesh
    points, triangles = mesh.points, mesh.triangles
    drawn = mesh.sides >= 0  # column by column: along rows of two or three numpy is slow
    sides = drawn[:, 0].astype(np.int64) + drawn[:, 1]  # how many shells draw each triangle
    meeting, several = surfaces_at(len(points), triangles, mesh.surface)

    # an edge on a line stays, whatever happens around it
    a, b, c = (several.take(triangles[:, k]) for k in range(3))
    rigid = a & b | b & c | c & a
    moves = ~several if 2 * sides[rigid].sum() <= max_triangle else np.ones(len(points), dtype=bool)

    # the first size is right for a regular mesh
    x, y = (
        points[:, k].take(triangles[:, 0]) - points[:, k].take(triangles[:, 1]) for k in range(2)
    )
    size = float(np.median(np.hypot(x, y))) * math.sqrt(n / max_triangle) or 1.0
    for _ in range(TRIES):
        of_point = _clusters(points, meeting, moves, size, exaggeration)
        corners = of_point.take(triangles)
        kept = _distinct(corners)
        n = int(sides[kept].sum())
        if n <= max_triangle:
            break
        size *= max(STEP, math.sqrt(n / max_triangle))
    means = _means(points, of_point)
    return replace(
        mesh,
        points=means,
        triangles=corners[kept],
        sides=mesh.sides[kept],
        surface=mesh.surface[kept],
    )


def surfaces_at(
    n_point: int, triangles: np.ndarray, surface: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return a number for the set of surfaces at each point, and whether there are several.

    Examples
    --------
    >>> triangles = np.array([[0, 1, 2], [1, 2, 3], [3, 2, 4]])
    >>> meeting, several = surfaces_at(5, triangles, np.array([7, 7, 8]))
    >>> meeting.tolist(), several.tolist()
    ([0, 0, 2, 2, 1], [False, False, True, True, False])
    """
    meeting, several = highest_of_points(triangles, surface, n_point)

    # the surfaces of a point join its set one after the other, each set with a number of its own
    n_surface = int(surface.max(initial=0)) + 2
    pairs = np.sort(first_seen(codes_of_points(triangles, surface, several, n_surface))[0])
    point, one = np.divmod(pairs, n_surface)
    first = np.flatnonzero(np.append(True, point[1:] != point[:-1]))[: len(pairs)]
    place = np.arange(len(pairs)) - np.repeat(first, np.diff(np.append(first, len(pairs))))
    joined = np.full(n_point, -1)
    for k in range(int(place.max(initial=-1)) + 1):
        now = place == k
        joined[point[now]] = (joined[point[now]] + 1) * n_surface + one[now]
        joined[several] = number_keys(joined[several])[1]
    meeting[several] = n_surface + joined[several]
    return number_keys(meeting)[1], several


def _clusters(
    points: np.ndarray, meeting: np.ndarray, moves: np.ndarray, size: float, exaggeration: float
) -> np.ndarray:
    """The cluster of each point: a cell of one set of surfaces, or the point itself."""
    low = [points[:, k].min() for k in range(3)]
    steps = (size, size, size / exaggeration)
    code = meeting.copy()
    for k in range(3):
        cell = ((points[:, k] - low[k]) / steps[k]).astype(np.int64)
        n_cell = int(cell.max()) + 1
        if (int(code.max()) + 1) * n_cell > LARGEST:
            code = number_keys(code)[1]
        code = code * n_cell + cell
    code[~moves] = -1 - np.flatnonzero(~moves)
    return number_keys(code)[1]


def _distinct(triangles: np.ndarray) -> np.ndarray:
    """Whether each triangle still has three corners."""
    a, b, c = triangles.T
    result: np.ndarray = (a != b) & (b != c) & (c != a)
    return result


def _means(points: np.ndarray, of_point: np.ndarray) -> np.ndarray:
    """Mean (n_cluster, 3) of the points of each cluster."""
    count = np.bincount(of_point)
    start = points[0]
    sums = [np.bincount(of_point, (points[:, k] - start[k])) for k in range(3)]
    result: np.ndarray = np.column_stack(sums) / count[:, None] + start
    return result


__all__ = ["clustered"]
