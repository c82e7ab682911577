"""The data of a horizon as points whose elevations can be corrected."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from geosurf.conventions.checks import are_points
from geosurf.conventions.crs import crs_of
from geosurf.model import TriSurface, frozen
from geosurf.sheets.lattice.data import points_of
from geosurf.triangulate import triangulate_horizon
from geosurf.triangulate.spikes import check_spikes


def data_to_tie(
    data: Any, name: str, positive: str | None = None, length_unit: str | None = None
) -> Any:
    """
    Return the data of a horizon as a surface or as a dataset of points, in metres, positive up.

    Parameters
    ----------
    data : xarray.DataArray, xarray.Dataset, pandas.DataFrame, array_like (n, 3) or TriSurface
        As for `tear_horizon`.
    name : str
    positive, length_unit : str, optional

    Returns
    -------
    TriSurface or xarray.Dataset
    """
    if isinstance(data, TriSurface):
        return data
    if not are_points(data):
        surface = triangulate_horizon(data, name=name, positive=positive, length_unit=length_unit)
        check_spikes(surface)
        return surface
    import xarray as xr

    _, points = points_of(data, name, positive, length_unit)
    attrs = {"units": "m", "positive": "up"}
    crs = crs_of(data)
    return xr.Dataset(
        {
            key: ("point", points[:, k].copy(), attrs if key == "elevation" else {"units": "m"})
            for k, key in enumerate(("easting", "northing", "elevation"))
        },
        attrs={"name": name} if crs is None else {"name": name, "crs": crs},
    )


def points_of_data(data: Any) -> np.ndarray:
    """World coordinates (n, 3) of the data: vertices of a surface, or the points of a dataset."""
    if isinstance(data, TriSurface):
        return data.vertices
    return np.stack(
        [np.ravel(data[name].values) for name in ("easting", "northing", "elevation")], axis=1
    )


def corrected_data(data: Any, change: np.ndarray) -> Any:
    """
    Return the data with changed elevations, in the form they had.

    Parameters
    ----------
    data : TriSurface or xarray.Dataset
        A grid or mesh, or points over one dimension: easting, northing, elevation [m], positive up.
    change : ndarray of float64, shape (n,)
        Added to the elevations of `points_of_data` [m].

    Returns
    -------
    TriSurface or xarray.Dataset
    """
    if not isinstance(data, TriSurface):
        elevation = data["elevation"]
        changed = elevation.copy(data=elevation.values + change.reshape(elevation.shape))
        return data.assign(elevation=changed)
    if data.lattice is None:
        vertices = data.vertices.copy()
        vertices[:, 2] += change
        made = TriSurface(data.name, data.role, vertices, data.triangles)
    else:
        grid = data.lattice
        z = grid.elevation.copy()
        present = np.isfinite(z)
        z[present] += change[grid.vertex_of_node[present]]
        made = TriSurface(
            data.name, data.role, lattice=replace(grid, elevation=frozen(z, np.float64))
        )
    made.crs = data.crs
    return made


__all__ = ["corrected_data", "data_to_tie", "points_of_data"]
