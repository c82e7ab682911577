"""Shells with fewer triangles: points of one surface that are close together become one.

Points where surfaces meet stay as they are, so outlines and cut-off lines are exact, and units that
share a surface go on sharing it. On a plane the volume of a shell does not change.

Source: vertex clustering after Rossignac & Borrel (1993), "Multi-resolution 3D approximations for
rendering complex scenes", in cells of the map; unlike them we never merge points of two surfaces.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.render.thin_units import Shell

STEP, TRIES = 1.25, 16  # by how much cells grow in each attempt: to 35 times the first size


def clustered(shells: list[Shell], max_triangle: int, exaggeration: float = 1.0) -> list[Shell]:
    """Return shells with about `max_triangle` triangles in all.

    Parameters
    ----------
    shells : list of Shell
    max_triangle : int
        The result has more where that many lie along the lines where surfaces meet.
    exaggeration : float
        Vertical exaggeration of the picture: cells are lower by that.

    Returns
    -------
    list of Shell
    """
    n = sum(len(shell.triangles) for shell in shells)
    if n <= max_triangle:
        return shells
    points, rows = _shared_points([shell.points for shell in shells])
    triangles = [row[shell.triangles] for row, shell in zip(rows, shells, strict=True)]
    alone, surface = _one_surface(len(points), triangles, shells)

    # the first size is right for a regular mesh
    edges = np.concatenate([points[t[:, 0], :2] - points[t[:, 1], :2] for t in triangles])
    size = float(np.median(np.hypot(*edges.T))) * math.sqrt(n / max_triangle) or 1.0
    for _ in range(TRIES):
        of_point = _clusters(points, surface, alone, size, exaggeration)
        kept = [_distinct(of_point[t]) for t in triangles]
        if sum(int(rows_kept.sum()) for rows_kept in kept) <= max_triangle:
            break
        size *= STEP
    means = _means(points, of_point)
    return [
        _shell(means, of_point[t[k]], shell.surface[k])
        for t, k, shell in zip(triangles, kept, shells, strict=True)
    ]


def _shared_points(parts: list[np.ndarray]) -> tuple[np.ndarray, list[np.ndarray]]:
    """Distinct points (n, 3) of all shells, and the row of each point of each shell."""
    points, rows = np.unique(np.concatenate(parts), axis=0, return_inverse=True)
    ends = np.cumsum([len(part) for part in parts])[:-1]
    return points, np.split(rows.ravel(), ends)


def _one_surface(
    n_point: int, triangles: list[np.ndarray], shells: list[Shell]
) -> tuple[np.ndarray, np.ndarray]:
    """Whether each point lies on a single surface, and the first surface of each point."""
    low = np.full(n_point, np.iinfo(np.int64).max)
    high = np.full(n_point, -1)
    for t, shell in zip(triangles, shells, strict=True):
        surface = np.repeat(shell.surface, 3)
        np.minimum.at(low, t.ravel(), surface)
        np.maximum.at(high, t.ravel(), surface)
    return low == high, high


def _clusters(
    points: np.ndarray, surface: np.ndarray, alone: np.ndarray, size: float, exaggeration: float
) -> np.ndarray:
    """The cluster of each point: a cell of one surface, or the point itself."""
    cell = np.floor((points - points.min(axis=0)) / (size, size, size / exaggeration))
    cell = cell.astype(np.int64)
    key = np.column_stack([surface, cell])

    # one number for each cell: rows of numbers are slower to sort
    spans = key.max(axis=0) + 1
    code = np.ravel_multi_index(tuple(key.T), tuple(spans.tolist()))
    code[~alone] = -1 - np.flatnonzero(~alone)
    return np.unique(code, return_inverse=True)[1].ravel()


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


def _shell(points: np.ndarray, triangles: np.ndarray, surface: np.ndarray) -> Shell:
    """A shell without unused points."""
    used, rows = np.unique(triangles, return_inverse=True)
    return Shell(points[used], rows.reshape(-1, 3), surface)


__all__ = ["clustered"]
