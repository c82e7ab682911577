"""Points and cells of a mesh file -> a surface in metres, elevation up; for every mesh format."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import first_given
from geosurf.errors import FormatError, SurfaceError
from geosurf.model import TriSurface
from geosurf.read._common import Request, agreed_scale, agreed_sign


def surface_from_mesh(
    path: Path,
    name: str,
    points: np.ndarray,
    triangles: np.ndarray,
    vertex_data: dict[str, Any],
    request: Request,
) -> TriSurface:
    """Turn what a mesh file holds into a surface in metres, elevation up."""
    what = f"{path}: surface {name!r}"

    # mesh formats state neither direction nor unit: elevation in metres, unless the caller does
    sign = agreed_sign(None, first_given(request.positive, "up"), what)
    scale = agreed_scale(None, request.length_unit, "m", what)
    if len(triangles) == 0:
        raise FormatError(
            f"{path}: the file has no triangles. Export the surface as a triangle mesh."
        )
    try:
        world = points * [1.0, 1.0, scale * sign]
        return TriSurface(name, "fault", world, triangles, vertex_data=vertex_data)
    except (SurfaceError, ValueError) as error:
        raise FormatError(f"{path}: {error}") from error


def split_quads(quads: np.ndarray) -> np.ndarray:
    """Triangles (2 n, 3) of quads (n, 4), each split from its first corner."""
    return np.asarray(quads)[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def triangles_of_cells(
    path: Path, corners: np.ndarray, ends: np.ndarray, count: np.ndarray, n_point: int
) -> np.ndarray:
    """
    Return triangles (n, 3) of cells with three or four corners, cell by cell.

    Parameters
    ----------
    path : pathlib.Path
    corners : ndarray of int64, shape (n_corner,)
        Points of all cells, one cell after the other.
    ends, count : ndarray of int64, shape (n_cell,)
        Where the corners of each cell end, and how many it has.
    n_point : int

    Raises
    ------
    FormatError
        If a cell has other than three or four corners, or names a point that is not there.
    """
    odd = np.flatnonzero((count != 3) & (count != 4))
    if len(odd):
        raise FormatError(
            f"{path}: cell {odd[0]} has {count[odd[0]]} corners, expected 3 or 4. "
            "Triangulate the surface before saving it."
        )

    # numpy would take negative rows from the end, without an error
    if len(corners) and (corners.min() < 0 or corners.max() >= n_point):
        bad = np.flatnonzero((corners < 0) | (corners >= n_point))
        raise FormatError(
            f"{path}: a cell names point {corners[bad[0]]}, expected 0 to {n_point - 1}. "
            "The file is damaged; export it again."
        )

    # triangles only, one after the other: they are there already
    if (count == 3).all() and len(corners) == 3 * len(count) and (np.diff(ends) == 3).all():
        return corners.reshape(-1, 3)

    # Two slots for each cell: quads fill both, triangles only the first.
    starts = ends - count
    quads = count == 4
    out = np.empty((len(count), 2, 3), dtype=np.int64)
    out[:, 0] = corners[starts[:, None] + np.arange(3)]
    out[quads] = split_quads(corners[starts[quads, None] + np.arange(4)]).reshape(-1, 2, 3)

    keep = np.ones((len(count), 2), dtype=bool)
    keep[:, 1] = quads
    return out[keep]
