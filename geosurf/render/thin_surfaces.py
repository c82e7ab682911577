"""Surfaces with few enough triangles to draw: as many as the pixels of a picture can show."""

from __future__ import annotations

import math

import numpy as np

from geosurf.model import Lattice, TriSurface
from geosurf.render.views import SIZE

# triangles of all surfaces of a picture, and of one, whatever its size
MAX_TRIANGLE = 1_000_000
MOST, LEAST = 400_000, 60_000
PIXELS = 10  # of a picture for each triangle of a surface: a cell of a grid is two or three wide


def thinned(surface: TriSurface, max_triangle: int = MOST) -> TriSurface:
    """Return a surface with few enough triangles to draw.

    Of a gridded surface with more than `max_triangle` triangles, rows and columns are left out at
    even distances. A surface without a lattice is returned unchanged.

    Parameters
    ----------
    surface : TriSurface
    max_triangle : int

    Returns
    -------
    TriSurface
    """
    lattice = surface.lattice
    if lattice is None:
        return surface
    n_row, n_col = lattice.shape

    # two triangles for each cell: half of the rows and columns leaves a quarter of them
    share = math.sqrt(max_triangle / (2.0 * max(n_row - 1, 1) * max(n_col - 1, 1)))
    if share >= 1.0:
        return surface
    rows, columns = _spread(n_row, share), _spread(n_col, share)
    some = np.ix_(rows, columns)
    if lattice.easting.ndim == 1:
        easting, northing = lattice.easting[columns], lattice.northing[rows]
    else:
        easting, northing = lattice.easting[some], lattice.northing[some]
    elevation = lattice.elevation[some]
    coarse = Lattice(easting, northing, elevation, lattice.rising, lattice.reverse)
    return TriSurface(surface.name, surface.role, lattice=coarse)


def most_of_each(n: int, size: tuple[int, int] = SIZE, zoom: float = 1.0) -> int:
    """How many triangles each of n surfaces may have, about: as many as pixels can show.

    Parameters
    ----------
    n : int
    size : (int, int)
        Width and height of the picture in pixels.
    zoom : float
        2 shows the middle at twice the scale.

    Examples
    --------
    >>> most_of_each(2), most_of_each(12), most_of_each(2, (3840, 2160))
    (102400, 83333, 400000)
    """
    resolved = int(size[0] * size[1] * zoom**2) // PIXELS
    return min(MOST, max(LEAST, min(resolved, MAX_TRIANGLE // max(n, 1))))


def _spread(n: int, share: float) -> np.ndarray:
    """Some of n rows at even distances; the first and the last one stay, and so the border.

    Examples
    --------
    >>> _spread(10, 0.7).tolist()
    [0, 2, 3, 4, 6, 8, 9]
    """
    n_cell = max(int((n - 1) * min(share, 1.0)), min(n - 1, 1))
    rows: np.ndarray = np.round(np.linspace(0.0, n - 1.0, n_cell + 1)).astype(np.int64)
    return rows


__all__ = ["most_of_each", "thinned"]
