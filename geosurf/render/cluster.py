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

from geosurf.kernels.meshes.numbering import number_keys
from geosurf.model import Units
from geosurf.model.chunked import ChunkedLattice
from geosurf.render.thin_units import (
    MAX_UNIT_TRIANGLE,
    Shell,
    UnitMesh,
    mesh_to_draw,
    shells_to_draw,
)

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
    sides = (mesh.sides >= 0).sum(axis=1)  # how many shells draw each triangle
    meeting, several = surfaces_at(len(points), triangles, mesh.surface)

    # an edge on a line stays, whatever happens around it
    rigid = several[triangles].sum(axis=1) > 1
    moves = ~several if 2 * sides[rigid].sum() <= max_triangle else np.ones(len(points), dtype=bool)

    # the first size is right for a regular mesh
    edges = points[triangles[:, 0], :2] - points[triangles[:, 1], :2]
    size = float(np.median(np.hypot(*edges.T))) * math.sqrt(n / max_triangle) or 1.0
    for _ in range(TRIES):
        of_point = _clusters(points, meeting, moves, size, exaggeration)
        corners = of_point[triangles]
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


def shells_in_picture(units: Units, max_triangle: int = MAX_UNIT_TRIANGLE) -> list[Shell]:
    """Return the shell of each unit, as `shells_to_draw`.

    Of horizons in their store, points along curves become few, too: millions of triangles next to
    them are smaller than a pixel.

    Parameters
    ----------
    units : Units
    max_triangle : int
    """
    sources = units.piece_sides[0].sources if units.has_pieces else ()
    if not any(isinstance(source.lattice, ChunkedLattice) for source in sources):
        return shells_to_draw(units, max_triangle)
    mesh = mesh_to_draw(units, max_triangle)
    fewer = clustered(mesh, 2 * max_triangle)
    return [replace(shell, creases=fewer is mesh) for shell in fewer.shells]


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
    low = np.full(n_point, np.iinfo(np.int64).max)
    high = np.full(n_point, -1)
    for k in range(3):
        np.minimum.at(low, triangles[:, k], surface)
        np.maximum.at(high, triangles[:, k], surface)
    several = low < high
    meeting = high.copy()

    # the surfaces of a point join its set one after the other, each set with a number of its own
    n_surface = int(surface.max(initial=0)) + 2
    corner = np.flatnonzero(several[triangles].ravel())
    pairs = np.unique(triangles.ravel()[corner] * n_surface + surface[corner // 3])
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
    low = points.min(axis=0)
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


__all__ = ["clustered", "shells_in_picture"]
