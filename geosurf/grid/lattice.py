"""The areal lattice of a grid: equal cells over the area of the model, along its longest side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.conventions import CONVERSION_ERRORS, is_number
from geosurf.errors import InputError

MOST_COLUMNS = 4_000_000


@dataclass(frozen=True, eq=False)
class ArealLattice:
    """Equal rectangles on the map.

    Attributes
    ----------
    corner : ndarray of float64, shape (2,)
        Easting and northing of the first corner [m].
    axes : ndarray of float64, shape (2, 2)
        Unit vectors along I and J, as rows.
    cell : ndarray of float64, shape (2,)
        Size of a cell along I and J [m].
    shape : (int, int)
        Number of rows (J) and columns (I).
    """

    corner: np.ndarray
    axes: np.ndarray
    cell: np.ndarray
    shape: tuple[int, int]

    def to_lattice(self, xy: np.ndarray) -> np.ndarray:
        """Coordinates in cells along I and J, of places relative to the corner (n, 2)."""
        # an unrotated lattice only scales: coordinates that are equal stay equal
        turned = xy if (self.axes == np.eye(2)).all() else xy @ self.axes.T
        return turned / self.cell

    def to_world(self, uv: np.ndarray) -> np.ndarray:
        """Easting and northing [m] of coordinates in cells (..., 2)."""
        return self.corner + (uv * self.cell) @ self.axes


def lattice_over(
    box: tuple[float, ...], aoi: np.ndarray | None, cell: Any, angle: Any
) -> ArealLattice:
    """
    Return the lattice that fills the area of a model with cells of about a size.

    Parameters
    ----------
    box : (west, east, south, north, ...)
        [m]
    aoi : ndarray of float64, shape (n, 2), or None
    cell : (dx, dy) or float
        [m]
    angle : float or None
        Direction of I, degrees counter-clockwise from east. Default: along the sides of the
        smallest rectangle around the area.

    Returns
    -------
    ArealLattice

    Raises
    ------
    InputError
        For a size or an angle that is not a number, or too many columns.
    """
    size = _size(cell)
    w, e, s, n = box[:4]
    outline = np.array([[w, s], [e, s], [e, n], [w, n]]) if aoi is None else np.asarray(aoi)
    if angle is None:
        axes = np.eye(2) if aoi is None else _best_axes(outline)
    elif is_number(angle) and np.isfinite(float(angle)):
        c, s = np.cos(np.radians(float(angle))), np.sin(np.radians(float(angle)))
        axes = np.array([[c, s], [-s, c]]) if angle else np.eye(2)
    else:
        raise InputError(f"angle is {angle!r}. Give degrees counter-clockwise from east.")

    # whole numbers of cells that fill the rectangle: each is about as large as asked
    along = (outline - outline[0]) @ axes.T
    low, span = along.min(axis=0), np.ptp(along, axis=0)
    count = np.maximum(np.round(span / size), 1)
    if count.prod() > MOST_COLUMNS:
        raise InputError(
            f"cells of {size[0]:g} x {size[1]:g} m give {count.prod():.3g} columns; the limit is "
            f"{MOST_COLUMNS:g}. Choose larger cells."
        )
    nx, ny = count.astype(np.int64).tolist()
    return ArealLattice(outline[0] + low @ axes, axes, span / count, (ny, nx))


def _size(cell: Any) -> np.ndarray:
    """Size of a cell along I and J [m]."""
    both = (cell, cell) if is_number(cell) else cell
    try:
        dx, dy = both
    except (TypeError, ValueError, *CONVERSION_ERRORS):
        dx = dy = None
    if not all(is_number(d) and np.isfinite(d) and d > 0 for d in (dx, dy)):
        raise InputError(f"cell is {cell!r}. Give the size of a cell in metres: cell=(100, 100).")
    return np.array([float(dx), float(dy)])


def _best_axes(outline: np.ndarray) -> np.ndarray:
    """Axes of the smallest rectangle around an outline, nearest to east and north."""
    step = np.roll(outline, -1, axis=0) - outline
    step = step[np.hypot(*step.T) > 0]
    step = step / np.hypot(*step.T)[:, None]
    best, smallest = np.eye(2), np.inf
    for x, y in step:
        # a side of the hull is a side of the smallest rectangle (Freeman & Shapira 1975)
        axes = np.array([[x, y], [-y, x]])
        area = float(np.ptp(outline @ axes.T, axis=0).prod())
        if area < smallest * (1.0 - 1e-12):
            best, smallest = axes, area

    # quarter turns: I within 45 degrees of east
    while not (best[0, 0] > abs(best[0, 1]) or best[0, 0] == best[0, 1] > 0):
        best = np.array([-best[1], best[0]])
    return best


def inside_outline(places: np.ndarray, outline: np.ndarray) -> np.ndarray:
    """Whether places (..., 2) are inside an outline (n, 2): a ray to the east leaves it once more.

    Examples
    --------
    >>> inside_outline(np.array([[1.0, 1.0], [3.0, 1.0]]), np.array([[0, 0], [2, 0], [2, 2]]) * 1.0)
    array([ True, False])
    """
    x, y = places[..., 0], places[..., 1]
    found = np.zeros(x.shape, dtype=bool)
    for a, b in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        if a[1] == b[1]:
            continue
        crosses = (y < a[1]) != (y < b[1])
        found ^= crosses & (x < a[0] + (y - a[1]) * (b[0] - a[0]) / (b[1] - a[1]))
    return found
