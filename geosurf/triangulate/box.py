"""The default model box: around the default area, or the largest axis-parallel rectangle in it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.errors import InputError
from geosurf.model import Lattice, TriSurface

_MARGIN = 0.25  # of the relief, above and below


def propose_box(
    horizons: Sequence[TriSurface],
    outline: np.ndarray | None = None,
    in_map: Sequence[TriSurface] | None = None,
) -> Box:
    """
    Return the model box around an outline, or around the largest rectangle inside all horizons.

    For unrotated grids without holes that is where their edges overlap, exactly. For rotated
    or holed grids it is the largest axis-parallel rectangle among sampled places that all horizons
    cover, one sample inside; carving still checks that nothing leaks.

    Parameters
    ----------
    horizons : sequence of TriSurface
        At least one.
    outline : ndarray of float64, shape (n, 2), optional
        Corners of the area of the model. Without it each horizon needs a lattice.
    in_map : sequence of TriSurface, optional
        Horizons as they lie in the map, without gaps at faults; default: `horizons`.

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
        raise InputError(
            "geosurf needs horizons to propose a box. Give box=(west, east, south, north, "
            "bottom, top)."
        )

    # Bounds are west, east, south, north, bottom, top [m].
    bounds = np.array([horizon.bounds for horizon in horizons])
    bottom, top = bounds[:, 4].min(), bounds[:, 5].max()

    # horizons have to end on walls, never on the top or the bottom of the box
    margin = max(_MARGIN * (top - bottom), 1.0)

    if outline is not None:
        (west, south), (east, north) = outline.min(axis=0), outline.max(axis=0)
    else:
        west, east, south, north = _rectangle(in_map or horizons)
    box = (west, east, south, north, bottom - margin, top + margin)
    w, e, s, n, b, t = (float(value) for value in box)
    return w, e, s, n, b, t


def are_unrotated(horizons: Sequence[TriSurface]) -> bool:
    """Return whether all horizons are unrotated grids without holes."""
    lattices = [horizon.lattice for horizon in horizons]
    return all(
        lattice is not None and lattice.easting.ndim == 1 and lattice.whole for lattice in lattices
    )


def _rectangle(horizons: Sequence[TriSurface]) -> tuple[float, float, float, float]:
    """West, east, south, north of the largest axis-parallel rectangle that all horizons cover."""
    for horizon in horizons:
        if horizon.lattice is None:
            raise InputError(
                f"horizon {horizon.name!r} is a mesh, and aoi='rectangle' is for grids only. "
                "Leave aoi out, or give box=(west, east, south, north, bottom, top)."
            )

    bounds = np.array([horizon.bounds for horizon in horizons])

    # The common box of all bounds; rotated or holed grids cover only a part of it.
    low, high = bounds[:, 0::2].max(axis=0), bounds[:, 1::2].min(axis=0)
    if (low[:2] >= high[:2]).any():
        raise InputError(
            "the horizons have no area in common, so geosurf cannot propose a box. Give "
            "box=(west, east, south, north, bottom, top)."
        )

    if are_unrotated(horizons):
        return low[0], high[0], low[1], high[1]
    lattices = [horizon.lattice for horizon in horizons if horizon.lattice is not None]
    return _largest_rectangle(lattices, low, high)


def _largest_rectangle(
    lattices: Sequence[Lattice], low: np.ndarray, high: np.ndarray
) -> tuple[float, float, float, float]:
    """Largest rectangle of sampled places that all lattices cover, one sample inside."""
    # Sample cells of equal size; centres of samples.
    step = float((high[:2] - low[:2]).max()) / SAMPLES
    x = np.arange(low[0] + 0.5 * step, high[0], step)
    y = np.arange(low[1] + 0.5 * step, high[1], step)
    covered = np.ones((len(y), len(x)), dtype=bool)

    for lattice in lattices:
        covered &= covers(lattice, *np.meshgrid(x, y))
    area, left, right, first, last = largest_of(covered)
    if area == 0 or right - left < 3 or last - first < 3:
        raise InputError(
            "the horizons have no rectangle in common that is large enough for a model. "
            "Give box=(west, east, south, north, bottom, top)."
        )
    # One sample further inside on each side, since samples are covered at their centres only.
    return x[left + 1], x[right - 1], y[first + 1], y[last - 1]


SAMPLES = 192  # along the longer side, for rotated and holed grids
Box = tuple[float, float, float, float, float, float]


def largest_of(covered: np.ndarray) -> tuple[int, int, int, int, int]:
    """Area, first and last column, first and last row of the largest rectangle that is covered."""
    # `heights`: covered samples from each row downwards in the order of rows, one per column.
    best = (0, 0, 0, 0, 0)
    heights = np.zeros(covered.shape[1], dtype=np.int64)
    for row in range(len(covered)):
        heights = np.where(covered[row], heights + 1, 0)
        best = max(best, _best_in_histogram(heights, row))
    return best


def _best_in_histogram(heights: np.ndarray, row: int) -> tuple[int, int, int, int, int]:
    """(area, left, right, first row, last row) of the largest rectangle that ends in a row."""
    # The stack holds (start, height) of rectangles that are still open, heights rising; a lower
    # column closes all that are taller. The last height, 0, closes all.
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
    # Two steps span the lattice: along rows and along columns [m].
    n_row, n_col = lattice.shape
    corners = np.array([0, n_col - 1, (n_row - 1) * n_col, n_row * n_col - 1])
    first, east, north, opposite = lattice.map_places(corners)
    along, up = (east - first) / (n_col - 1), (north - first) / (n_row - 1)
    # Four corners of a parallelogram; otherwise steps cannot be even.
    far = first + along * (n_col - 1) + up * (n_row - 1)
    size = np.hypot(*along) + np.hypot(*up)
    if np.hypot(*(far - opposite)) > 1e-3 * size:
        raise InputError(
            "a horizon is a curvilinear grid, for which geosurf cannot propose a box. Give "
            "box=(west, east, south, north, bottom, top)."
        )

    # Invert the two steps: row and column of the cell below each place.
    det = along[0] * up[1] - along[1] * up[0]
    dx, dy = x - first[0], y - first[1]
    j = np.floor((dx * up[1] - dy * up[0]) / det).astype(np.int64)
    i = np.floor((along[0] * dy - along[1] * dx) / det).astype(np.int64)

    inside = (i >= 0) & (i < n_row - 1) & (j >= 0) & (j < n_col - 1)
    i, j = np.where(inside, i, 0), np.where(inside, j, 0)

    # All four nodes of the cell have to exist.
    node = i * n_col + j
    four = np.ones(inside.shape, dtype=bool)
    if not lattice.whole:
        for corner in (node, node + n_col, node + 1, node + n_col + 1):
            four &= lattice.present.ravel()[corner]
    return inside & four
