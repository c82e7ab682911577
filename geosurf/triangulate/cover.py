"""Where all horizons are: the default box inside it, and how much of it that box leaves out."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from geosurf.conventions import area_text
from geosurf.errors import GeosurfWarning, InputError
from geosurf.model import Lattice, TriSurface

SAMPLES = 192  # along the longer side, for rotated and holed grids
_MUCH = 0.9  # of the common area: a box that covers less is worth a word
_GAIN = 1.1  # an area along the rows of the grids is proposed if it covers this much more

Box = tuple[float, float, float, float, float, float]


def warning_of_area(horizons: Sequence[TriSurface], box: Box) -> GeosurfWarning | None:
    """Return a warning if a default box leaves out much of the area of all horizons, or None.

    The remedy is the largest rectangle along the rows of the first grid, ready to be typed.

    Examples
    --------
    >>> east, north = np.meshgrid(np.arange(21.0), np.arange(41.0))
    >>> turned = Lattice((east - north) * 50.0, (east + north) * 50.0, np.zeros((41, 21)))
    >>> top = TriSurface("Top", "horizon", lattice=turned)
    >>> print(warning_of_area([top], (-1000, 0, 700, 1700, -1, 1)).effect)
    The default box covers 25 % of the area of all horizons (1 km² of 4 km²).
    """
    lattices = [h.lattice for h in horizons if h.lattice is not None]
    if all(lattice.easting.ndim == 1 and lattice.present.all() for lattice in lattices):
        return None  # the box is the area
    west, east, south, north = box[:4]
    corners, share_of_turned, area = _along_the_rows(lattices)
    share = (east - west) * (north - south) / area if area > 0 else 1.0
    if share >= _MUCH:
        return None
    digits = max(0, 2 - math.floor(math.log10(max(east - west, north - south))))
    sides = f"box=({', '.join(f'{value:.{digits}f}' for value in box)})"
    remedy = f"Pass {sides} to keep this box, or aoi= with the outline of your model."
    if corners is not None and share_of_turned > _GAIN * share:
        typed = ", ".join(f"({x:.{digits}f}, {y:.{digits}f})" for x, y in corners.tolist())
        remedy = (
            f"aoi=[{typed}] covers {100 * share_of_turned:.0f} %; you can also pass another "
            f"outline. Pass {sides} to keep this box."
        )
    words = f"{area_text(share * area)} of {area_text(area)}"
    return GeosurfWarning(
        "area",
        "box",
        f"The default box covers {100 * share:.0f} % of the area of all horizons ({words}).",
        remedy,
    )


def _along_the_rows(lattices: Sequence[Lattice]) -> tuple[np.ndarray | None, float, float]:
    """Corners (4, 2) of the largest rectangle along the rows of the first grid that all horizons
    cover, one sample inside; its share of the area that they cover; and that area [m2].
    """
    n_row, n_col = lattices[0].shape
    easting, northing = lattices[0].horizontal()
    along = np.array([easting[0, -1] - easting[0, 0], northing[0, -1] - northing[0, 0]])
    up = np.array([easting[-1, 0] - easting[0, 0], northing[-1, 0] - northing[0, 0]])
    corner = np.array([easting[0, 0], northing[0, 0]])
    longest = max(np.hypot(*along), np.hypot(*up))
    n_along = max(int(SAMPLES * np.hypot(*along) / longest), min(n_col - 1, SAMPLES), 4)
    n_up = max(int(SAMPLES * np.hypot(*up) / longest), min(n_row - 1, SAMPLES), 4)
    s, t = (np.arange(n_along) + 0.5) / n_along, (np.arange(n_up) + 0.5) / n_up
    s, t = np.meshgrid(s, t)
    x, y = (corner[k] + s * along[k] + t * up[k] for k in (0, 1))
    covered = np.ones(x.shape, dtype=bool)
    for lattice in lattices:
        covered &= covers(lattice, x, y)
    cell = abs(along[0] * up[1] - along[1] * up[0]) / (n_along * n_up)
    _, left, right, first, last = largest_of(covered)
    if right - left < 3 or last - first < 3:
        return None, 0.0, covered.sum() * cell
    spots = [(first + 1, left + 1), (first + 1, right - 1), (last - 1, right - 1)]
    spots.append((last - 1, left + 1))
    corners = np.array([(x[spot], y[spot]) for spot in spots])
    area = (right - left - 2) * (last - first - 2) * cell
    return corners, area / (covered.sum() * cell), covered.sum() * cell


def largest_of(covered: np.ndarray) -> tuple[int, int, int, int, int]:
    """Area, first and last column, first and last row of the largest rectangle that is covered."""
    best = (0, 0, 0, 0, 0)
    heights = np.zeros(covered.shape[1], dtype=np.int64)
    for row in range(len(covered)):
        heights = np.where(covered[row], heights + 1, 0)
        best = max(best, _best_in_histogram(heights, row))
    return best


def _best_in_histogram(heights: np.ndarray, row: int) -> tuple[int, int, int, int, int]:
    """(area, left, right, first row, last row) of the largest rectangle that ends in a row."""
    best = (0, 0, 0, 0, 0)
    stack: list[tuple[int, int]] = []
    for i, height in enumerate([*heights.tolist(), 0]):
        start = i
        while stack and stack[-1][1] >= height:
            start, tall = stack.pop()
            best = max(best, (tall * (i - start), start, i - 1, row - tall + 1, row))
        stack.append((start, height))
    return best


def covers(lattice: Lattice, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Whether places lie in a cell with four nodes, for lattices with even steps."""
    easting, northing = lattice.horizontal()
    n_row, n_col = lattice.shape
    corner = np.array([easting[0, 0], northing[0, 0]])
    along = (np.array([easting[0, -1], northing[0, -1]]) - corner) / (n_col - 1)
    up = (np.array([easting[-1, 0], northing[-1, 0]]) - corner) / (n_row - 1)
    far = corner + along * (n_col - 1) + up * (n_row - 1)
    size = np.hypot(*along) + np.hypot(*up)
    if np.hypot(*(far - (easting[-1, -1], northing[-1, -1]))) > 1e-3 * size:
        raise InputError(
            "a horizon is a curvilinear grid, for which geosurf cannot propose a box. Give "
            "box=(west, east, south, north, bottom, top)."
        )
    det = along[0] * up[1] - along[1] * up[0]
    dx, dy = x - corner[0], y - corner[1]
    j = np.floor((dx * up[1] - dy * up[0]) / det).astype(np.int64)
    i = np.floor((along[0] * dy - along[1] * dx) / det).astype(np.int64)
    inside = (i >= 0) & (i < n_row - 1) & (j >= 0) & (j < n_col - 1)
    i, j = np.where(inside, i, 0), np.where(inside, j, 0)
    present = lattice.present
    four = present[i, j] & present[i + 1, j] & present[i, j + 1] & present[i + 1, j + 1]
    return inside & four
