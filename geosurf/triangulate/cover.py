"""Places that a grid covers, and the largest axis-parallel rectangle among them."""

from __future__ import annotations

import numpy as np

from geosurf.errors import InputError
from geosurf.model import Lattice

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
