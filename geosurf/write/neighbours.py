"""Grids, surfaces, points and lines -> objects of other packages, imported in the functions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.errors import DependencyError, InputError
from geosurf.model import Curves, FaultSticks
from geosurf.write.points_and_lines import crs_of_any, line_set, lines_in_space
from geosurf.write.text_grids import regular_grid

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray


AXES = ("easting", "northing", "elevation")
TAKEN = "Give a DataArray, a TriSurface, FaultSticks, or a Dataset of points or lines."


def to_xtgeo(obj: Any) -> Any:
    """
    Return a horizon, fault, points or lines as an object of xtgeo.

    Parameters
    ----------
    obj : DataArray, TriSurface, FaultSticks, Dataset or list of ndarray
        A regular grid, rotated or not; a mesh; the sticks of a fault; points, as `read_points`
        reads them; lines, as `Scene.fault_polygons` makes them or `read_polygons` reads them.

    Returns
    -------
    xtgeo.RegularSurface, xtgeo.TriangulatedSurface, xtgeo.Points or xtgeo.Polygons
        Values stay as they are: elevations [m], positive up. xtgeo states no direction. Words and
        numbers of points and lines become attributes. Closed lines end where they begin.

    Raises
    ------
    DependencyError
        If xtgeo is not installed.
    InputError
        If it is something else.
    OutputError
        If a grid is not regular.

    Examples
    --------
    >>> import geosurf as gs
    >>> to_xtgeo(gs.synthetic.graben(n=9).faults)
    Traceback (most recent call last):
    geosurf.errors.InputError: cannot turn dict into an object of xtgeo. Give a DataArray, a \
TriSurface, FaultSticks, or a Dataset of points or lines.
    """
    grid = all(hasattr(obj, key) for key in ("dims", "coords", "values", "name"))
    lines = _lines_of(obj)
    points = not grid and {*AXES} <= set(getattr(obj, "data_vars", ()))
    mesh = hasattr(obj, "vertices") and hasattr(obj, "triangles")
    if not (grid or lines or points or mesh):
        raise InputError(f"cannot turn {type(obj).__name__} into an object of xtgeo. {TAKEN}")
    try:
        import xtgeo
    except ImportError as error:
        raise DependencyError(
            "xtgeo is not installed. Install the extra: pip install 'geosurf[grid]'."
        ) from error

    if mesh:
        vertices, triangles = np.array(obj.vertices), np.array(obj.triangles)
        return xtgeo.TriangulatedSurface(vertices, triangles, name=str(obj.name))
    if lines:
        return _polygons(xtgeo, lines, str(getattr(obj, "name", None) or "poly"))
    return _surface(xtgeo, obj) if grid else _points(xtgeo, obj)


def _lines_of(obj: Any) -> list[tuple[np.ndarray, dict[str, Any]]]:
    """Points of each line with its words; nothing where an object holds no lines."""
    if hasattr(obj, "sticks"):
        return [(np.asarray(stick), {"NAME": obj.name}) for stick in obj.sticks]
    if hasattr(obj, "data_vars") and "count" in obj.data_vars:
        words = _words(obj, "line")
        return [
            (part, {word.upper(): obj[word].values[row] for word in words})
            for row, part in lines_in_space(obj)
        ]
    if not isinstance(obj, list | tuple) or not obj:
        return []
    arrays = [part for part in obj if isinstance(part, np.ndarray) and part.shape[1:] == (3,)]
    return [(part, {}) for part in arrays] if len(arrays) == len(obj) else []


def _words(data: xarray.Dataset, dim: str) -> list[str]:
    """Words and numbers of each point or line."""
    own = (*AXES, "count")
    return [str(key) for key in data.data_vars if data[key].dims == (dim,) and key not in own]


def _surface(xtgeo: Any, horizon: xarray.DataArray) -> Any:
    """A gridded horizon as RegularSurface."""
    name = str(horizon.name or "horizon")
    (x, y, xinc, yinc, rotation), values, _ = regular_grid(horizon, name)

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


def _points(xtgeo: Any, points: xarray.Dataset) -> Any:
    """A table of points as Points."""
    import pandas as pd

    dim = str(points["easting"].dims[0])
    words = _words(points, dim)
    names = dict(zip(AXES, ("X_UTME", "Y_UTMN", "Z_TVDSS"), strict=True))
    table = pd.DataFrame({names.get(key, key): points[key].values for key in (*AXES, *words)})
    return xtgeo.Points(values=table, attributes={word: _kind(table[word]) for word in words})


def _polygons(xtgeo: Any, lines: list[tuple[np.ndarray, dict[str, Any]]], name: str) -> Any:
    """Lines as Polygons, numbered from 0."""
    import pandas as pd

    sizes = [len(part) for part, _ in lines]
    places = np.concatenate([part for part, _ in lines])
    table = pd.DataFrame(places, columns=["X_UTME", "Y_UTMN", "Z_TVDSS"])
    table["POLY_ID"] = np.repeat(np.arange(len(lines)), sizes)
    words = list(dict.fromkeys(word for _, row in lines for word in row))
    for word in words:
        table[word] = np.repeat(np.array([row[word] for _, row in lines]), sizes)
    kinds = {word: _kind(table[word]) for word in words}
    return xtgeo.Polygons(values=table, name=name, attributes=kinds)


def _kind(column: Any) -> str:
    """Type of a column in the words of xtgeo."""
    return {"i": "int", "u": "int", "f": "float"}.get(column.dtype.kind, "str")


def to_geodataframe(obj: Any) -> Any:
    """
    Return points, lines, sticks or curves as `geopandas.GeoDataFrame`.

    Parameters
    ----------
    obj : Dataset, FaultSticks, Curves or list of ndarray
        Points, as `read_points` and `read_tops` read them; lines, as `Scene.fault_polygons` makes
        them or `read_polygons` reads them.

    Returns
    -------
    geopandas.GeoDataFrame
        One row for each point or line, with elevations [m] as third coordinates: closed lines as
        LineString that end where they begin, words and numbers as columns, and the reference
        system.

    Raises
    ------
    DependencyError
        If geopandas is not installed.
    InputError
        If it is something else.
    OutputError
        If the Dataset holds neither points nor lines.

    Examples
    --------
    >>> to_geodataframe(3)
    Traceback (most recent call last):
    geosurf.errors.InputError: cannot turn int into points or lines. Give a Dataset of points or \
lines, as read_points and fault_polygons make, FaultSticks, Curves or a list of arrays (n, 3).
    """
    table = hasattr(obj, "data_vars")
    lines = isinstance(obj, list | tuple) and obj and all(np.ndim(part) == 2 for part in obj)
    if not (table or lines or isinstance(obj, FaultSticks | Curves)):
        raise InputError(
            f"cannot turn {type(obj).__name__} into points or lines. Give a Dataset of points or "
            "lines, as read_points and fault_polygons make, FaultSticks, Curves or a list of "
            "arrays (n, 3)."
        )
    try:
        import geopandas
        from shapely.geometry import LineString, Point
    except ImportError as error:
        raise DependencyError(
            "geopandas is not installed. Install the extra: pip install 'geosurf[gis]'."
        ) from error
    crs = crs_of_any(obj)
    if table and "count" not in obj.variables and {*AXES} <= set(obj.data_vars):
        dim = str(obj["easting"].dims[0])
        points = np.stack([obj[axis].values for axis in AXES], axis=1)
        words: dict[str, Any] = {word: obj[word].values for word in _words(obj, dim)}
        return geopandas.GeoDataFrame(words, geometry=list(map(Point, points)), crs=crs)
    found = line_set(obj)
    words = {**found.words}
    if isinstance(obj, FaultSticks):
        words["name"] = [obj.name] * len(found.parts)
    return geopandas.GeoDataFrame(words, geometry=list(map(LineString, found.parts)), crs=crs)
