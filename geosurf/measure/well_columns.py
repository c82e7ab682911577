"""Vertical lines through wells: where they cross a horizon, and which faults lie between.

A top is compared with the horizon straight above or below it. Whether a vertical line meets a
triangle is decided by exact signs (`geosurf.measure.columns`), so each place has one answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geosurf.measure.columns import cross_columns
from geosurf.model import Patches


@dataclass(frozen=True, eq=False)
class Columns:
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

    foot: np.ndarray
    triangle: np.ndarray
    way: np.ndarray
    elevation: np.ndarray
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

    # the middle of what is asked for; lines on the rim of a model then see its inside
    used = patches.local[patches.triangles[rows].ravel(), :2]
    middle = 0.5 * (used.min(axis=0) + used.max(axis=0)) if len(used) else np.zeros(2)
    found = cross_columns(patches.local, patches.triangles[rows], feet, middle)

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
