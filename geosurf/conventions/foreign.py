"""Places and lines in objects of other packages: by what they have, without importing anything.

xtgeo `Polygons`, geopandas `GeoDataFrame` and `GeoSeries`, geometries of shapely, and points of
pyvista. Third coordinates are elevations. Those of xtgeo are depths more often than not, and it
does not state it: they are refused where they count.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

# ---- outlines ----------------------------------------
# Polygons on the map: which sides are one straight line, since exports have many short ones.


def straight_runs(outline: np.ndarray, near: float) -> list[list[int]]:
    """
    Return the sides of a polygon in runs that are straight to within a distance.

    Parameters
    ----------
    outline : ndarray of float64, shape (n, 2)
        Corners.
    near : float
        How far corners of a run may be off its line.

    Returns
    -------
    list of list of int
        Numbers of sides; side k follows corner k.

    Examples
    --------
    >>> square = np.array([[0.0, 0], [2, 0], [4, 0], [4, 4], [0, 4], [0, 2]])
    >>> straight_runs(square, 0.1)
    [[3], [4, 5], [0, 1], [2]]
    """
    n = len(outline)
    # begin at the corner that is farthest from the first one: no run goes on across it
    start = int(np.hypot(*(outline - outline[0]).T).argmax())
    ring = [(start + k) % n for k in range(n + 1)]
    runs, first = [], 0
    for last in range(1, n + 1):
        if last < n and _off(outline[ring[first : last + 2]]) <= near:
            continue
        runs.append(ring[first:last])
        first = last
    return runs


def _off(corners: np.ndarray) -> float:
    """Largest distance of corners from the line between the first and last of them [m]."""
    chord = corners[-1] - corners[0]
    from_first = corners[1:-1] - corners[0]
    length = np.hypot(*chord)
    if not length:
        return np.inf
    along = from_first @ chord / length
    # a line that turns back is not straight
    if (np.diff(along, prepend=0.0, append=length) < 0).any():
        return np.inf
    return float(np.abs(chord[0] * from_first[:, 1] - chord[1] * from_first[:, 0]).max() / length)


MANY = "geoms"  # of a geometry with several parts
UNSTATED = (
    "does not state whether z is elevation or depth; give an array of its columns, positive up"
)


def points_of_foreign(value: Any) -> np.ndarray | None:
    """
    Return the points of an object of another package (n, 3); None for anything else.

    Parameters
    ----------
    value : object

    Raises
    ------
    ValueError
        If it holds something else than points in space.

    Examples
    --------
    >>> class Cloud:  # as pyvista has it
    ...     points, n_points = [[0, 0, 5], [1, 0, 6]], 2
    >>> points_of_foreign(Cloud()).tolist()
    [[0.0, 0.0, 5.0], [1.0, 0.0, 6.0]]
    >>> points_of_foreign([[0, 0, 5]]) is None
    True
    """
    if _is_xtgeo(value):
        raise ValueError(f"{type(value).__name__} of xtgeo {UNSTATED}")
    if hasattr(value, "points") and hasattr(value, "n_points"):
        return np.asarray(value.points, dtype=np.float64).reshape(-1, 3)
    geometries = _geometries(value)
    if geometries is None:
        return None
    rows = [np.asarray(one.coords, dtype=np.float64) for one in geometries if _is(one, "Point")]
    if len(rows) < len(geometries) or any(row.shape != (1, 3) for row in rows):
        raise ValueError(f"{type(value).__name__} holds something else than points in space")
    return np.concatenate(rows) if rows else np.empty((0, 3))


def lines_of_foreign(value: Any, *, on_map: bool = False) -> list[np.ndarray] | None:
    """
    Return lines and rings of an object of another package; None for anything else.

    Parameters
    ----------
    value : object
    on_map : bool
        Whether third coordinates do not count.

    Returns
    -------
    list of ndarray of float64, each (n, 2) or (n, 3)
        Of polygons the ring around them.

    Raises
    ------
    ValueError
        If it holds something else than lines and polygons, or a polygon has holes.

    Examples
    --------
    >>> class Line:  # as shapely has it
    ...     geom_type, coords = "LineString", [(0, 0), (5, 0)]
    >>> lines_of_foreign(Line())[0].tolist()
    [[0.0, 0.0], [5.0, 0.0]]
    """
    if _is_xtgeo(value):
        if not hasattr(value, "pname"):
            raise ValueError("Points of xtgeo are not lines")
        table = value.get_dataframe()
        points, ids = _columns(value, table), np.asarray(table[value.pname])
        if points[:, 2].any() and not on_map:
            raise ValueError(f"{type(value).__name__} of xtgeo {UNSTATED}")
        return [points[ids == k] for k in dict.fromkeys(ids.tolist())]
    geometries = _geometries(value)
    if geometries is None:
        return None
    found = []
    for one in geometries:
        if _is(one, "Polygon") and len(one.interiors):
            raise ValueError("a polygon has holes")
        if not _is(one, "Polygon", "LineString", "LinearRing"):
            raise ValueError(f"a geometry is a {one.geom_type}, not a line or polygon")
        ring = one.exterior if _is(one, "Polygon") else one
        found.append(np.asarray(ring.coords, dtype=np.float64))
    return found


def crs_of_foreign(value: Any) -> str | None:
    """
    Return the reference system of an object of geopandas, as a text; None without one.

    Parameters
    ----------
    value : object

    Examples
    --------
    >>> crs_of_foreign([[0, 0, 5]]) is None
    True
    """
    crs = getattr(value, "crs", None) if hasattr(value, "geometry") else None
    return None if crs is None else str(crs.to_string() if hasattr(crs, "to_string") else crs)


def _is_xtgeo(value: Any) -> bool:
    return all(hasattr(value, name) for name in ("get_dataframe", "xname", "yname", "zname"))


def _columns(value: Any, table: Any) -> np.ndarray:
    """Places (n, 3) of a table of xtgeo."""
    names = (value.xname, value.yname, value.zname)
    return np.column_stack([np.asarray(table[name], dtype=np.float64) for name in names])


def _geometries(value: Any) -> list[Any] | None:
    """Geometries of a table, a column or a single one, each with one part."""
    if hasattr(value, "geometry") and hasattr(value, "crs"):
        return list(_parts(value.geometry))
    return list(_parts([value])) if isinstance(getattr(value, "geom_type", None), str) else None


def _parts(geometries: Any) -> Iterator[Any]:
    for one in geometries:
        if hasattr(one, MANY):
            yield from _parts(one.geoms)
        else:
            yield one


def _is(one: Any, *kinds: str) -> bool:
    return getattr(one, "geom_type", None) in kinds
