"""Boxes along the rows and columns of rotated grids: along the axes of the map they are far larger.

The box of a wall or of a strip along the rim of a rotated grid covers much of the map, and so do
voxels that it fills. Along the grid's own axes it is thin. Coordinates are turned for the search
only: boxes are wider by what rounding may have moved, so that no pair that meets is left out. What
decides whether two triangles meet are their own coordinates.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from geosurf.kernels.search.voxels import triangle_boxes
from geosurf.model import TriSurface

Direction = tuple[float, float]

_ROUNDING = 2.0**-50  # of the sum of two coordinates: eight units in the last place


def direction_of(surfaces: Iterable[TriSurface]) -> Direction | None:
    """
    Return the direction of the columns of rotated grids, of about unit length; None without one.

    Of several grids the first one counts whose steps are even to a part in a thousand.

    Examples
    --------
    >>> from geosurf.model import Lattice
    >>> i, j = np.meshgrid(np.arange(3.0), np.arange(3.0))
    >>> top = TriSurface("Top", "horizon", lattice=Lattice(3 * i - 4 * j, 4 * i + 3 * j, 0 * i))
    >>> direction_of([top])
    (0.6, 0.8)
    """
    for surface in surfaces:
        lattice = surface.lattice
        if surface.role != "horizon" or lattice is None:
            continue
        if lattice.easting.ndim == 1:
            return None
        frame = lattice.map_frame
        along, length = frame.column, math.hypot(*frame.column)
        if frame.off > 1e-3 * length or not length > 0.0:
            continue
        x, y = along[0] / length, along[1] / length
        return None if min(abs(x), abs(y)) < 1e-6 else (x, y)
    return None


def turned_boxes(
    x: np.ndarray, triangles: np.ndarray, along: Direction | None
) -> tuple[np.ndarray, np.ndarray, float]:
    """
    Return turned coordinates, boxes of triangles in them, and how far turning may be off.

    Parameters
    ----------
    x : ndarray of float64, shape (n, 3)
    triangles : ndarray of int64, shape (m, 3)
    along : (float, float), optional
        Direction of the first axis in the map, about a unit vector; None: nothing is turned.

    Returns
    -------
    turned : ndarray of float64, shape (n, 3)
    boxes : ndarray of float64, shape (m, 6)
        They hold the triangles themselves, exactly turned.
    slack : float
        No turned coordinate is farther off.
    """
    if along is None:
        return x, triangle_boxes(x, triangles), 0.0
    c, s = along
    turned = np.empty_like(x)
    turned[:, 0] = c * x[:, 0] + s * x[:, 1]
    turned[:, 1] = c * x[:, 1] - s * x[:, 0]
    turned[:, 2] = x[:, 2]
    slack = _ROUNDING * float(sum(np.abs(x[:, k]).max(initial=0.0) for k in (0, 1)))
    boxes = triangle_boxes(turned, triangles)
    boxes[:, :2] -= 2.0 * slack  # twice, since these differences are rounded, too
    boxes[:, 3:5] += 2.0 * slack
    return turned, boxes, slack
