"""Points and lines: text, tables, GeoJSON, GOCAD VSet."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.conventions import elevation_sign, metres_per_unit
from geosurf.conventions.axes import COORDINATES, points_in
from geosurf.conventions.checks import no_data_in
from geosurf.conventions.crs import crs_of, epsg_of, label
from geosurf.conventions.machine import need
from geosurf.errors import InputError, OutputError
from geosurf.lazy import pandas as pd
from geosurf.lazy import xarray
from geosurf.model import Curves, FaultSticks
from geosurf.write.datasets import csv_of_rows
from geosurf.write.gocad import _head as head_of
from geosurf.write.text_grids import regular_grid, rows_text
from geosurf.write.written import Loss, declared_crs

# ---- polylines ----------------------------------------
# Polylines: ``.pol``, ``.csv`` and GeoJSON of curves, cut-offs, fault polygons, outlines, sticks.
#
# ``.pol`` has ``x y z`` per line, each polyline ended by ``999 999 999``; ``.csv`` a row for each
# point, with the number of its line and all words and numbers of the line. GeoJSON has a feature
# for each line. RFC 7946 knows degrees of WGS 84 only; programs for maps know the member ``crs``
# of the standard before it, and without one they take metres for degrees. So geosurf writes that
# member, and refuses lines without an EPSG code.


END_OF_LINE = 999.0
DIRECTION = Loss(
    "direction",
    "z is elevation in metres, which the format does not store: read the file with positive='up'.",
)
NAMES = Loss("name", "The format does not store names of lines and surfaces; .csv and .geojson do.")
OLD_STANDARD = Loss(
    "other",
    "Coordinates are those of the member 'crs' of GeoJSON 2008, which GIS programs read. RFC 7946 "
    "knows degrees of WGS 84 only.",
)


@dataclass(frozen=True)
class LineSet:
    """
    Lines in space, whatever they come from.

    Attributes
    ----------
    parts : list of ndarray of float64, each (n, 3)
        Easting, northing, elevation [m]; closed lines end with their first point.
    words : dict of str to list
        Names and numbers of each line.
    """

    parts: list[np.ndarray]
    words: dict[str, list[Any]]


def pol_of_lines(lines: Any, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return polylines as text; what is known of each line is lost."""
    line_parts = line_set(lines)
    pieces = []
    for part in line_parts.parts:
        x, y, z = part.T
        pieces.append(rows_text([x, b" ", y, b" ", z, b"\n"]) + b"999.0 999.0 999.0\n")
    return b"".join(pieces), [DIRECTION, *([NAMES] if line_parts.words else [])]


def csv_of_lines(lines: Any, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return the same as a table: one row for each point, closed lines with their first again."""
    checked = line_set(lines)
    header = ["X", "Y", "Z", "POLY_ID", *(word.upper() for word in checked.words)]
    rows: list[list[Any]] = []
    for row, part in enumerate(checked.parts):
        labels = [values[row] for values in checked.words.values()]
        rows += [[*point, row + 1, *labels] for point in part.tolist()]
    data, lost = csv_of_rows(header, rows)
    return data, [DIRECTION, *lost]


def geojson_of_lines(lines: Any, name: str | None, crs: str | None) -> tuple[bytes, list[Loss]]:
    """Return a feature for each line, in projected metres with the member ``crs``."""
    checked = line_set(lines)
    features = []
    for row, part in enumerate(checked.parts):
        if len(part) < 2:
            raise OutputError("a line has 1 point, and GeoJSON needs 2. Write .csv.")
        closed = len(part) > 3 and bool((part[0] == part[-1]).all())
        points = part.tolist()
        shape = {
            "type": "Polygon" if closed else "LineString",
            "coordinates": [points] if closed else points,
        }
        words = {key: _plain(values[row]) for key, values in checked.words.items()}
        features.append({"type": "Feature", "properties": words, "geometry": shape})
    return collection(features, name, crs), [OLD_STANDARD]


def collection(features: list[dict[str, Any]], name: str | None, crs: str | None) -> bytes:
    """Return the bytes of a feature collection with its reference system."""
    code = None if crs is None else epsg_of(crs)
    if code is None:
        found = "no coordinate reference system" if crs is None else f"{label(crs)!r}, no EPSG code"
        raise OutputError(
            f"GeoJSON needs a coordinate reference system with an EPSG code, and found {found}. "
            "Without one, programs take metres for degrees. Give it: crs='EPSG:23031'."
        )
    head: dict[str, Any] = {"type": "FeatureCollection"}
    if name:
        head["name"] = name
    head["crs"] = {"type": "name", "properties": {"name": f"urn:ogc:def:crs:EPSG::{code}"}}
    head |= {"positive": "up", "units": "m"}  # members of our own, which `read_polygons` knows
    lines = ",\n".join(json.dumps(feature, allow_nan=False) for feature in features)
    body = json.dumps(head, ensure_ascii=False)[:-1] + f', "features": [\n{lines}\n]}}\n'
    return body.encode("utf-8")


def line_set(lines: Any) -> LineSet:
    """Return the lines of a Dataset of lines, Curves, FaultSticks or a list of arrays (n, 3).

    Raises
    ------
    OutputError
        If there are none, or a point has no place or holds a usual mark of no data.
    """
    checked = _line_set(lines)
    for row, part in enumerate(checked.parts):
        if not np.isfinite(part).all():
            raise OutputError(
                f"line {row} (counted from 0) has coordinates that are not finite. Drop these "
                "points."
            )
        if absent := no_data_in(part):
            raise OutputError(
                f"point {absent[0]} of line {row} (counted from 0) has {absent[1]:g}, a usual mark "
                "of no data, which readers do not take for a place. Drop this point."
            )
    return checked


def _line_set(lines: Any) -> LineSet:
    """The lines as they are."""
    if isinstance(lines, Curves):
        if lines.n_curve == 0:
            raise OutputError(
                "there are no curves to write, and the file needs at least one. Write .vtp instead."
            )
        pairs = lines.surfaces_of_curve.tolist()
        names = {
            key: [lines.names[pair[k]] for pair in pairs]
            for k, key in enumerate(("surface", "other"))
        }
        return LineSet([lines.points[curve] for curve in lines.curves], names)
    if isinstance(lines, FaultSticks):
        return LineSet(list(lines.sticks), {})
    if isinstance(lines, list | tuple):
        return LineSet([_points(part) for part in lines], {})
    words = [str(key) for key in lines.data_vars if lines[key].dims == ("line",) and key != "count"]
    parts = [part for _, part in lines_in_space(lines)]
    return LineSet(parts, {word: lines[word].values.tolist() for word in words})


def lines_in_space(lines: xarray.Dataset) -> list[tuple[int, np.ndarray]]:
    """Number and points (n, 3) of each line."""
    if not {*COORDINATES, "count"} <= set(lines.variables) or not lines.sizes.get("line"):
        raise OutputError(
            "this Dataset has no lines in space such as those of Scene.fault_polygons. Write "
            ".nc instead."
        )

    # The points of all lines follow one another; `count` has how many each line has.
    points = points_in(lines)
    ends = np.cumsum(lines["count"].values)
    parts = np.split(points, ends[:-1])

    # rings are stored without their first point again; text has no other way to close them
    closed = bool(lines.attrs.get("closed", False))
    return list(enumerate(np.concatenate([p, p[:1]]) if closed else p for p in parts))


def _points(part: Any) -> np.ndarray:
    """One line of a list as an array (n, 3)."""
    points = np.asarray(part, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise OutputError(
            f"a line has the shape {points.shape}, expected (n, 3): easting, northing, elevation. "
            "Give a list of such arrays, as read_polygons and Scene.cutoffs return."
        )
    return points


def _plain(value: Any) -> Any:
    """A word or number that JSON holds; what is not finite becomes null."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value if isinstance(value, str | int | float | bool) or value is None else str(value)


# ---- points ----------------------------------------
# Scattered points: ``.xyz``, ``.csv``, GOCAD VSet and GeoJSON of a Dataset over one dimension.


def xyz_of_points(points: xarray.Dataset, name: str | None) -> tuple[bytes | bytearray, list[Loss]]:
    """Return ``x y z`` of each point."""
    x, y, z = columns_of(points).T
    if ((x == END_OF_LINE) & (y == END_OF_LINE) & (z == END_OF_LINE)).any():
        raise OutputError(
            "a point is (999, 999, 999), which ends the points in files of x y z. Write .csv."
        )
    return rows_text([x, b" ", y, b" ", z, b"\n"]), [*_others_lost(points), DIRECTION]


def csv_of_points(points: xarray.Dataset, name: str | None) -> tuple[bytes | bytearray, list[Loss]]:
    """Return a table with the columns X, Y, Z and those of all other variables."""
    place = columns_of(points)
    others = _others(points)
    if not others:
        x, y, z = place.T
        return rows_text([x, b",", y, b",", z, b"\n"], head=b"X,Y,Z\n"), [DIRECTION]
    rows = zip(*place.T.tolist(), *(points[key].values.tolist() for key in others), strict=True)
    data, lost = csv_of_rows(["X", "Y", "Z", *others], (list(row) for row in rows))
    return data, [DIRECTION, *lost]


def vset_of_points(
    points: xarray.Dataset, name: str | None
) -> tuple[bytes | bytearray, list[Loss]]:
    """Return a GOCAD VSet."""
    x, y, z = columns_of(points).T
    head = "\n".join(head_of("VSet", name or "points", crs_of(points))) + "\n"
    ids = np.arange(1, len(x) + 1)
    body = rows_text([b"VRTX ", ids, b" ", x, b" ", y, b" ", z, b"\n"])
    return head.encode("utf-8") + body + b"END\n", _others_lost(points)


def geojson_of_points(
    points: xarray.Dataset, name: str | None, crs: str | None
) -> tuple[bytes | bytearray, list[Loss]]:
    """Return a feature for each point, with all other variables as properties."""
    others = {key: points[key].values.tolist() for key in _others(points)}
    features = [
        {
            "type": "Feature",
            "properties": {key: _plain(values[row]) for key, values in others.items()},
            "geometry": {"type": "Point", "coordinates": place},
        }
        for row, place in enumerate(columns_of(points).tolist())
    ]
    return collection(features, name, crs), [OLD_STANDARD]


def columns_of(points: xarray.Dataset) -> np.ndarray:
    """Easting, northing and elevation [m], positive up, of each point, shape (n, 3)."""
    z = points["elevation"]
    scale = elevation_sign(z.attrs.get("positive", "up"), "points") * metres_per_unit(
        z.attrs.get("units", "m"), "points"
    )
    columns = points_in(points).astype(np.float64)
    columns[:, 2] *= scale
    if not len(columns):
        raise OutputError("there are no points to write. Write .nc instead.")
    bad = np.flatnonzero(~np.isfinite(columns).all(axis=1))
    if len(bad):
        raise OutputError(
            f"point {bad[0]} (counted from 0) has coordinates {columns[bad[0]].tolist()}, not all "
            "of them finite. Drop such points, or write .nc."
        )
    return columns + 0.0


def _others(points: xarray.Dataset) -> list[str]:
    """Names of the variables that are not coordinates in space."""
    (dim,) = points["elevation"].dims
    return [
        str(key)
        for key, variable in points.variables.items()
        if key not in COORDINATES and variable.dims == (dim,)
    ]


def _others_lost(points: xarray.Dataset) -> list[Loss]:
    others = _others(points)
    if not others:
        return []
    return [Loss("data", f"The columns {others} were left out; .csv and .nc store them.")]


# ---- objects of other libraries ----------------------------------------
# Grids, surfaces, points and lines -> objects of other packages, imported in the functions.


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
    lines = _holds_lines(obj)
    points = not grid and {*COORDINATES} <= set(getattr(obj, "data_vars", ()))
    mesh = hasattr(obj, "vertices") and hasattr(obj, "triangles")
    if not (grid or lines or points or mesh):
        raise InputError(f"cannot turn {type(obj).__name__} into an object of xtgeo. {TAKEN}")
    need("to_xtgeo needs", "xtgeo")
    import xtgeo

    if mesh:
        vertices, triangles = np.array(obj.vertices), np.array(obj.triangles)
        return xtgeo.TriangulatedSurface(vertices, triangles, name=str(obj.name))
    if lines:
        return _polygons(xtgeo, obj)
    return _surface(xtgeo, obj) if grid else _points_of_xtgeo(xtgeo, obj)


def _holds_lines(obj: Any) -> bool:
    """Whether an object is sticks, a Dataset of lines, or a list of arrays (n, 3)."""
    if isinstance(obj, list | tuple) and obj:
        return all(isinstance(part, np.ndarray) and part.shape[1:] == (3,) for part in obj)
    return isinstance(obj, FaultSticks) or "count" in getattr(obj, "data_vars", ())


def _words(data: xarray.Dataset, dim: str) -> list[str]:
    """Words and numbers of each point or line."""
    own = (*COORDINATES, "count")
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


def _points_of_xtgeo(xtgeo: Any, points: xarray.Dataset) -> Any:
    """A table of points as Points."""
    dim = str(points["easting"].dims[0])
    words = _words(points, dim)
    names = dict(zip(COORDINATES, ("X_UTME", "Y_UTMN", "Z_TVDSS"), strict=True))
    table = pd.DataFrame(
        {names.get(key, key): points[key].values for key in (*COORDINATES, *words)}
    )
    return xtgeo.Points(values=table, attributes={word: _kind(table[word]) for word in words})


def _polygons(xtgeo: Any, lines: Any) -> Any:
    """Lines as Polygons, numbered from 0."""
    checked, name = _line_set(lines), str(getattr(lines, "name", None) or "poly")
    sizes = list(map(len, checked.parts))
    table = pd.DataFrame(np.concatenate(checked.parts), columns=["X_UTME", "Y_UTMN", "Z_TVDSS"])
    table["POLY_ID"] = np.repeat(np.arange(len(sizes)), sizes)
    words = {word.upper(): values for word, values in checked.words.items()}
    if isinstance(lines, FaultSticks):
        words["NAME"] = [lines.name] * len(sizes)
    for word, values in words.items():
        table[word] = np.repeat(np.array(values), sizes)
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
    need("to_geodataframe needs", "geopandas", "shapely")
    import geopandas
    from shapely.geometry import LineString, Point

    crs = declared_crs(obj)
    if table and "count" not in obj.variables and {*COORDINATES} <= set(obj.data_vars):
        dim = str(obj["easting"].dims[0])
        points = points_in(obj)
        words: dict[str, Any] = {word: obj[word].values for word in _words(obj, dim)}
        return geopandas.GeoDataFrame(words, geometry=list(map(Point, points)), crs=crs)
    checked = line_set(obj)
    words = {**checked.words}
    if isinstance(obj, FaultSticks):
        words["name"] = [obj.name] * len(checked.parts)
    return geopandas.GeoDataFrame(words, geometry=list(map(LineString, checked.parts)), crs=crs)
