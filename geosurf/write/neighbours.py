"""Grids and lines -> objects of other packages, which are imported in the functions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.errors import DependencyError, InputError
from geosurf.write.irap import regular_grid
from geosurf.write.polylines import lines_in_space

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray

__all__ = ["to_geodataframe", "to_xtgeo"]


def to_xtgeo(horizon: xarray.DataArray) -> Any:
    """
    Return a gridded horizon or map as `xtgeo.RegularSurface`.

    Parameters
    ----------
    horizon : DataArray
        A regular grid, rotated or not. Values stay as they are: xtgeo states no direction.

    Returns
    -------
    xtgeo.RegularSurface

    Raises
    ------
    DependencyError
        If xtgeo is not installed.
    InputError
        If it is not a DataArray.
    OutputError
        If the grid is not regular.

    Examples
    --------
    >>> import geosurf as gs
    >>> to_xtgeo(gs.synthetic.graben(n=9).faults)
    Traceback (most recent call last):
    geosurf.errors.InputError: cannot turn dict into a surface of xtgeo. Give a DataArray.
    """
    if not all(hasattr(horizon, key) for key in ("dims", "coords", "values")):
        raise InputError(
            f"cannot turn {type(horizon).__name__} into a surface of xtgeo. Give a DataArray."
        )
    try:
        import xtgeo
    except ImportError as error:
        raise DependencyError(
            "xtgeo is not installed. Install the extra: pip install 'geosurf[grid]'"
        ) from error
    name = str(horizon.name or "horizon")
    (x, y, xinc, yinc, rotation), values = regular_grid(horizon, name)

    # xtgeo flips the second axis by a sign of its own, and has columns first
    return xtgeo.RegularSurface(
        ncol=values.shape[1],
        nrow=values.shape[0],
        xinc=xinc,
        yinc=abs(yinc),
        yflip=-1 if yinc < 0 else 1,
        xori=x,
        yori=y,
        rotation=rotation,
        values=np.ma.masked_invalid(values.T),
        name=name,
    )


def to_geodataframe(lines: xarray.Dataset) -> Any:
    """
    Return fault polygons, or other lines in space, as `geopandas.GeoDataFrame`.

    Parameters
    ----------
    lines : Dataset
        As from `Scene.fault_polygons`.

    Returns
    -------
    geopandas.GeoDataFrame
        One row for each line, with elevations [m] as third coordinates: closed lines as LineString
        that end where they begin, words and numbers of the lines as columns, and the reference
        system.

    Raises
    ------
    DependencyError
        If geopandas is not installed.
    InputError
        If it is not a Dataset.
    OutputError
        If the Dataset holds no lines.

    Examples
    --------
    >>> to_geodataframe([])
    Traceback (most recent call last):
    geosurf.errors.InputError: cannot turn list into lines. Give a Dataset, as fault_polygons makes.
    """
    if not hasattr(lines, "data_vars"):
        raise InputError(
            f"cannot turn {type(lines).__name__} into lines. Give a Dataset, as fault_polygons "
            "makes."
        )
    try:
        import geopandas
        from shapely.geometry import LineString
    except ImportError as error:
        raise DependencyError(
            "geopandas is not installed. Install the extra: pip install 'geosurf[gis]'"
        ) from error
    words = [str(key) for key in lines.data_vars if lines[key].dims == ("line",) and key != "count"]
    shapes = [LineString(points) for _, points in lines_in_space(lines)]
    return geopandas.GeoDataFrame(
        {word: lines[word].values for word in words}, geometry=shapes, crs=lines.attrs.get("crs")
    )
