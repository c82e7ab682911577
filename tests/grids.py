"""Small gridded horizons as people have them: arrays over easting and northing."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr


def gridded(values: Any, x: Any, y: Any = None, **attrs: Any) -> xr.DataArray:
    """Values at nodes, over two axes or where each node lies; elevations in metres, if not said.

    Attributes replace those of the same name, or are added.
    """
    y = x if y is None else y
    dims = ("northing", "easting") if np.ndim(x) == 1 else ("row", "column")
    places = {"northing": y, "easting": x}
    if np.ndim(x) == 2:
        places = {name: (dims, place) for name, place in places.items()}
    return xr.DataArray(values, places, dims, attrs={"units": "m", "positive": "up"} | attrs)


def lines_of(found: xr.Dataset, *axes: str) -> list[np.ndarray]:
    """Points (n, axes) of each line of a dataset in which lines follow each other."""
    points = np.stack([found[axis].values for axis in axes], axis=1)
    return np.split(points, np.cumsum(found["count"].values)[:-1])


def turned(degrees: float, shape: tuple[int, int], cell: float, corner=(0.0, 0.0)) -> Any:
    """Places of the nodes of a grid that is turned about its corner, and before the turn."""
    i, j = np.meshgrid(np.arange(shape[1]) * cell, np.arange(shape[0]) * cell)
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return corner[0] + i * c - j * s, corner[1] + i * s + j * c, i, j


def nodes_of(horizon: xr.DataArray) -> np.ndarray:
    """Easting, northing and value of all nodes (n_row, n_col, 3)."""
    x, y = np.asarray(horizon.easting), np.asarray(horizon.northing)
    x, y = np.meshgrid(x, y) if x.ndim == 1 else (x, y)
    return np.stack([x, y, horizon.values], axis=-1)


def ring_area(ring: Any) -> float:
    """Area of a ring of points (n, 2), negative where it runs clockwise."""
    x, y = (np.asarray(ring, dtype=float) - ring[0]).T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
