"""Dip of points and triangles, and mean elevations of the cells of a coarse grid."""

from __future__ import annotations

import numpy as np

CELLS = 40  # along each axis of the area
MOST_POINTS = 4000  # that a plane is fitted to


def thinned(points: np.ndarray, most: int) -> np.ndarray:
    """Every n-th point, so that there are about this many."""
    # Evenly through the file: grids stay grids, and no random numbers are needed.
    return points[:: max(len(points) // most, 1)]


def plane_dip(points: np.ndarray) -> float:
    """Dip [degrees] of the plane that lies nearest to points (n, 3).

    Examples
    --------
    >>> round(plane_dip(np.array([[0, 0, 0], [1, 0, 1], [0, 1, 0], [1, 1, 1.0]])))
    45
    """
    few = thinned(points, MOST_POINTS)
    # The direction of least variance is the normal of the plane.
    normal = np.linalg.svd(few - few.mean(axis=0), full_matrices=False)[2][-1]
    return float(np.degrees(np.arccos(min(abs(normal[2]), 1.0))))


def mean_dip(vertices: np.ndarray, triangles: np.ndarray) -> float:
    """Mean dip [degrees] of triangles, by area."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    # Weighted by area: small steep triangles at rims count little.
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    level = np.abs(normal[:, 2]).sum() / max(area.sum(), np.finfo(float).tiny)
    return float(np.degrees(np.arccos(min(level, 1.0))))


def cell_means(points: np.ndarray, frame: tuple[float, float, float, float]) -> np.ndarray:
    """Mean z in each cell of a frame (west, south, width, height); NaN in cells without points."""
    west, south, width, height = frame
    # Points on the last rim belong to the last cell.
    column = np.clip((points[:, 0] - west) / width * CELLS, 0, CELLS - 1).astype(np.int64)
    row = np.clip((points[:, 1] - south) / height * CELLS, 0, CELLS - 1).astype(np.int64)
    at = row * CELLS + column
    count = np.bincount(at, minlength=CELLS * CELLS)
    total = np.bincount(at, weights=points[:, 2], minlength=CELLS * CELLS)
    # Empty cells are NaN, so that comparisons leave them out.
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def frame_of(clouds: list[np.ndarray]) -> tuple[float, float, float, float]:
    """West, south, width and height around points."""
    low = np.min([p[:, :2].min(axis=0) for p in clouds], axis=0)
    high = np.max([p[:, :2].max(axis=0) for p in clouds], axis=0)
    # A line of points still gets cells.
    width, height = np.maximum(high - low, 1.0)
    return float(low[0]), float(low[1]), float(width), float(height)


def overlap_in_map(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether the rectangles around two clouds overlap in the map."""
    # Rectangles are enough: a wrong yes only asks for a tear that cuts nothing.
    low = np.maximum(a[:, :2].min(axis=0), b[:, :2].min(axis=0))
    high = np.minimum(a[:, :2].max(axis=0), b[:, :2].max(axis=0))
    return bool((low <= high).all())


__all__ = ["cell_means", "frame_of", "mean_dip", "overlap_in_map", "plane_dip", "thinned"]
