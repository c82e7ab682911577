"""Files are read with default words, and read again to find out what they state themselves."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from geosurf.read import GRID_FORMATS, otherwise
from geosurf.scenario.new.found import Found
from geosurf.scenario.new.shape import thinned

MOST_POINTS = 250_000  # that are kept of a horizon
# Words for readers that apply only where a file is silent: reading twice with different words shows
# whether it is.
UP: dict[str, Any] = otherwise({"positive": "up", "length_unit": "m"})
NEXT_UNIT: dict[str, Any] = otherwise({"positive": "up", "length_unit": "ft"})
DOWN: dict[str, Any] = otherwise({"positive": "down", "length_unit": "m"})


def surface_of_file(path: Path, read: Any, form: str, kind: str, note: str) -> Found:
    """Read a file with direction and unit as defaults; find out whether it states them."""
    first = read(path, **UP)
    one = Found(path, kind, form, note, points=points_in(first), data=first)
    one.note = note or str(one.points.shape[0])
    # Formats with attributes may state direction and unit; the others never do.
    silent = path.suffix.lower() not in (*GRID_FORMATS["netcdf"][2], ".vtp", ".vtk", ".vtu")
    # Equal points under both words: the file has the last word.
    if not silent:
        one.states_direction = are_equal(one.points, points_in(read(path, **DOWN)))
        one.states_unit = are_equal(one.points, points_in(read(path, **NEXT_UNIT)))
    one.points = thinned(one.points, MOST_POINTS)
    return one


def points_in(data: Any) -> np.ndarray:
    """Points (n, 3) of a DataArray, a Dataset or a TriSurface, without undefined ones."""
    if hasattr(data, "vertices"):
        return np.asarray(data.vertices, dtype=np.float64)
    z = data.elevation if hasattr(data, "data_vars") else data
    x, y = data.easting, data.northing
    # Axes become node coordinates.
    if x.ndim == 1 and z.ndim == 2:
        x, y = np.meshgrid(x.values, y.values)
    points = np.column_stack([np.ravel(v) for v in (x, y, z)]).astype(np.float64)
    return points[np.isfinite(points).all(axis=1)]


def are_equal(a: np.ndarray, b: np.ndarray) -> bool:
    """Return whether two arrays have the same values."""
    return a.shape == b.shape and bool((a == b).all())


__all__ = ["DOWN", "MOST_POINTS", "UP", "are_equal", "surface_of_file"]
