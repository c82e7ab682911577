"""The default model box: where all horizons are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.errors import InputError
from geosurf.model import Lattice, TriSurface

_SAMPLES = 192  # along the longer side, for rotated and holed grids
_MARGIN = 0.25  # of the relief, above and below

Box = tuple[float, float, float, float, float, float]


def propose_box(horizons: Sequence[TriSurface], aoi: np.ndarray | None = None) -> Box:
    """
    Propose a model box inside the area that all horizons cover.

    For unrotated grids without holes this is where their edges overlap, exactly. For rotated
    or holed grids it is the largest upright rectangle among sampled places that all horizons
    cover, one sample inside; carving still checks that nothing leaks.

    Parameters
    ----------
    horizons : sequence of TriSurface
        At least one, each with its lattice.
    aoi : ndarray of float64, shape (n, 2), optional
        Corners of an area of interest: then the box is around it, and horizons may be meshes.

    Returns
    -------
    (west, east, south, north, bottom, top)
        [m]. A quarter of the relief is added above and below.

    Raises
    ------
    InputError
        If there are no horizons, one has no lattice, or they have no area in common.

    Examples
    --------
    >>> z = np.zeros((3, 4))
    >>> flat = Lattice(np.arange(4.0), np.arange(3.0), z)
    >>> propose_box([TriSurface("Top", "horizon", lattice=flat)])
    (0.0, 3.0, 0.0, 2.0, -1.0, 1.0)
    """
    if not horizons:
        raise InputError("a box cannot be proposed without horizons; give box=(west, ..., top).")
    for horizon in horizons:
        if horizon.lattice is None and aoi is None:
            raise InputError(
                f"horizon {horizon.name!r} is a mesh, so that its cover is not known; give "
                "box=(west, east, south, north, bottom, top)."
            )
    bounds = np.array([horizon.bounds for horizon in horizons])
    low, high = bounds[:, 0::2].max(axis=0), bounds[:, 1::2].min(axis=0)
    if aoi is None and (low[:2] >= high[:2]).any():
        raise InputError("the horizons have no area in common; give box=(west, ..., top).")
    bottom, top = bounds[:, 4].min(), bounds[:, 5].max()
    margin = max(_MARGIN * (top - bottom), 1.0)
    if aoi is not None:
        low[:2], high[:2] = aoi.min(axis=0), aoi.max(axis=0)
    lattices = [h.lattice for h in horizons if h.lattice is not None]
    upright = all(lattice.easting.ndim == 1 and lattice.present.all() for lattice in lattices)
    if aoi is not None or upright:
        west, east, south, north = low[0], high[0], low[1], high[1]
    else:
        west, east, south, north = _largest_rectangle(lattices, low, high)
    box = (west, east, south, north, bottom - margin, top + margin)
    w, e, s, n, b, t = (float(value) for value in box)
    return w, e, s, n, b, t


def _largest_rectangle(lattices: Sequence[Lattice], low: np.ndarray, high: np.ndarray):
    """Largest rectangle of sampled places that all lattices cover, one sample inside."""
    step = float((high[:2] - low[:2]).max()) / _SAMPLES
    x = np.arange(low[0] + 0.5 * step, high[0], step)
    y = np.arange(low[1] + 0.5 * step, high[1], step)
    covered = np.ones((len(y), len(x)), dtype=bool)
    for lattice in lattices:
        covered &= _covers(lattice, *np.meshgrid(x, y))
    best = (0, 0, 0, 0, 0)
    heights = np.zeros(len(x), dtype=np.int64)
    for row in range(len(y)):
        heights = np.where(covered[row], heights + 1, 0)
        best = max(best, _best_in_histogram(heights, row))
    area, left, right, first, last = best
    if area == 0 or right - left < 3 or last - first < 3:
        raise InputError(
            "the horizons cover no common rectangle worth a model; give box=(west, ..., top)."
        )
    return x[left + 1], x[right - 1], y[first + 1], y[last - 1]


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


def _covers(lattice: Lattice, x: np.ndarray, y: np.ndarray) -> np.ndarray:
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
            "a horizon is a curvilinear grid, so that its cover is not simply known; give "
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
