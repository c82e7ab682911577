"""Vertical lines through wells: where they cross a horizon, and which faults lie between.

A top is compared with the horizon straight above or below it. Whether a vertical line meets a
triangle is decided by exact signs (`geosurf.kernels.search.columns`), so each place has one answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geosurf.kernels.search.columns import Crossings, cross_columns
from geosurf.model import Patches, TriSurface


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
    crossings = cross_columns(patches.local, patches.triangles[rows], feet)

    # by point, then from the bottom up; triangles that coincide come in the order of their rows
    order = np.lexsort((crossings.triangle, crossings.elevation, crossings.foot))
    triangle = rows[crossings.triangle[order]]
    return Columns(
        crossings.foot[order],
        triangle,
        crossings.way[order],
        crossings.elevation[order] + patches.origin[2],
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
    crossings = cross_columns(x, surface.triangles, feet[:, :2])
    off = feet[crossings.foot, 2] - crossings.elevation
    nearest = np.full(len(points), np.nan)
    # the smallest distance is written last
    order = np.argsort(-np.abs(off), kind="stable")
    nearest[crossings.foot[order]] = off[order]
    return nearest
