"""GeoJSON (RFC 7946): points, lines and polygons with attributes.

Also honoured: the member ``crs`` of the format of 2008, and the members ``positive`` and
``units`` of a collection. Parts of multi-geometries become features of their own. The RFC takes
coordinates for degrees where a file states no system; large numbers cannot be degrees.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.errors import FormatError, InputError
from geosurf.model import FaultSticks
from geosurf.read._common import read_text
from geosurf.read.features.collection import (
    Feature,
    Features,
    crs_from,
    points_of,
    polygons_of,
    sticks_of,
)

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

# type of a geometry -> kind of its parts, and lists around the positions of a part
SHAPES = {
    "Point": ("point", 0), "MultiPoint": ("point", 1), "LineString": ("line", 1),
    "MultiLineString": ("line", 2), "Polygon": ("ring", 2), "MultiPolygon": ("ring", 3),
}  # fmt: skip
DEPTH = 8  # collections within one another
FEWEST = {"point": 1, "line": 2, "ring": 4}


def read_geojson_points(
    path: Path,
    *,
    positive: str | None = None,
    length_unit: str | None = None,
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
) -> xr.Dataset:
    r"""
    Read points from GeoJSON.

    Parameters
    ----------
    path : pathlib.Path
    positive : {"up", "down"}, optional
        Whether z is elevation or depth, if the file does not state it.
    length_unit : str, optional
        Unit of z. Default ``"m"``.
    columns : sequence of str, optional
        The third name is the attribute that holds z.
    decimal : str
        Has no effect: numbers in JSON have a point.

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` and all attributes over ``point``.

    Raises
    ------
    FormatError
        If the JSON is damaged, or holds lines.
    InputError
        If coordinates are degrees, or `positive` is missing.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "picks.geojson"
    >>> point = '{"type": "Point", "coordinates": [461000, 5932000, 1600]}'
    >>> text = '{"type": "Feature", "properties": {"well": "W1"}, "geometry": ' + point + "}"
    >>> _ = file.write_text(text)
    >>> picks = read_geojson_points(file, positive="down")
    >>> picks.elevation.values, picks.well.values.tolist()
    (array([-1600.]), ['W1'])
    """
    return points_of(features(path), positive, length_unit, columns)


def read_geojson_polygons(
    path: Path,
    *,
    positive: str | None = None,
    length_unit: str | None = None,
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
    name: str | None = None,
) -> list[np.ndarray]:
    """
    Read lines and the borders of polygons from GeoJSON.

    Parameters
    ----------
    path, positive, length_unit, columns, decimal
        As for `read_geojson_points`.
    name : str, optional
        Only lines of this name.

    Returns
    -------
    list of ndarray of float64, each (n, 3)
        Holes of polygons are lines of their own.

    Raises
    ------
    FormatError, InputError
        As `read_geojson_points`.
    """
    return polygons_of(features(path), positive, length_unit, columns, name)


def read_geojson_sticks(
    path: Path,
    *,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
) -> FaultSticks:
    """
    Read the sticks of a fault from lines in GeoJSON.

    Parameters
    ----------
    path, positive, length_unit, columns, decimal
        As for `read_geojson_points`.
    name : str, optional
        Which fault, if the attribute ``name`` has several values; else the name of the fault.

    Returns
    -------
    FaultSticks

    Raises
    ------
    FormatError, InputError
        As `read_geojson_points`.
    """
    return sticks_of(features(path), name, positive, length_unit, columns)


def features(path: Path) -> Features:
    """Return all points and lines of a file."""
    try:
        found = json.loads(read_text(path, final_line_end=False), parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:
        raise FormatError(
            f"{path}: the JSON is incomplete or damaged ({error}). Export it again."
        ) from error
    if not isinstance(found, dict):
        raise FormatError(f"{path}: this is not a GeoJSON object. Export it again.")
    items: list[Feature] = []
    empty = 0
    for shape, words in _geometries(path, found, {}, 0):
        parts = list(_parts(path, shape)) if shape else []
        empty += not parts
        items += [Feature(kind, points, words) for kind, points in parts]
    stated = {key: _word(path, found, key) for key in ("positive", "units")}
    return Features(path, items, _crs(found), empty, stated["positive"], stated["units"])


def _no_constant(word: str) -> float:
    raise ValueError(f"found {word}, expected a number")


def _word(path: Path, found: dict[str, Any], key: str) -> str | None:
    """A text at the top of the file, or None."""
    value = found.get(key)
    if value is not None and not isinstance(value, str):
        raise InputError(f"{path}: the member {key!r} is {value!r}, expected a text. Correct it.")
    return value


def _crs(found: dict[str, Any]) -> str | None:
    """The reference system in the form of 2008, or a plain text."""
    stated = found.get("crs")
    if isinstance(stated, dict):
        properties = stated.get("properties")
        stated = properties.get("name") if isinstance(properties, dict) else None
    return crs_from(stated) if isinstance(stated, str) else None


def _geometries(
    path: Path, found: Any, words: dict[str, Any], depth: int
) -> Iterator[tuple[dict[str, Any] | None, dict[str, Any]]]:
    """Each geometry with the attributes of its feature; None where a feature has none."""
    kind = found.get("type") if isinstance(found, dict) else None
    if found is None:
        yield None, words
    elif kind in SHAPES:
        yield found, words
    elif kind in ("FeatureCollection", "GeometryCollection") and depth < DEPTH:
        parts = found.get("features" if kind == "FeatureCollection" else "geometries")
        if not isinstance(parts, list):
            raise FormatError(f"{path}: a {kind} has no list of its parts. Export it again.")
        for part in parts:
            yield from _geometries(path, part, words, depth + 1)
    elif kind == "Feature" and depth < DEPTH:
        own = found.get("properties")
        yield from _geometries(
            path, found.get("geometry"), own if isinstance(own, dict) else {}, depth + 1
        )
    else:
        raise FormatError(
            f"{path}: found an object of the type {kind!r}, expected one of Feature, "
            f"FeatureCollection, {', '.join(SHAPES)}. Export it again."
        )


def _parts(path: Path, shape: dict[str, Any]) -> Iterator[tuple[str, np.ndarray]]:
    """Kind and points (n, 3) of each part of a geometry."""
    kind, depth = SHAPES[shape["type"]]
    coordinates = shape.get("coordinates")
    if not isinstance(coordinates, list):
        raise FormatError(f"{path}: a {shape['type']} has no coordinates. Export it again.")
    if kind == "point":
        lines = [coordinates] if depth else ([[coordinates]] if coordinates else [])
    else:
        lines = [coordinates]
        # lists of lists of lines become lines
        for _ in range(depth - 1):
            if not all(isinstance(part, list) for part in lines):
                raise _wrong(path, shape)
            lines = [line for part in lines for line in part]
    for line in lines:
        if line == []:
            continue
        points = _points(path, shape, line)
        if len(points) < FEWEST[kind]:
            raise FormatError(
                f"{path}: a {shape['type']} has {len(points)} points, expected at least "
                f"{FEWEST[kind]}. Delete or complete it."
            )
        yield kind, points


def _points(path: Path, shape: dict[str, Any], line: Any) -> np.ndarray:
    """Positions as x, y, z; NaN where there is no z."""
    if not isinstance(line, list) or not all(isinstance(p, list) and len(p) >= 2 for p in line):
        raise _wrong(path, shape)
    # numbers only: numpy would take texts and truth values, too
    values = [(p[0], p[1], p[2] if len(p) > 2 else np.nan) for p in line]
    if not all(type(v) in (int, float) for row in values for v in row):
        raise _wrong(path, shape)
    try:
        points = np.array(values, dtype=np.float64)
    except OverflowError as error:
        raise _wrong(path, shape) from error
    if not np.isfinite(points[:, :2]).all() or np.isinf(points).any():
        raise _wrong(path, shape)
    return points


def _wrong(path: Path, shape: dict[str, Any]) -> FormatError:
    return FormatError(
        f"{path}: coordinates of a {shape['type']} are not lists of two or three finite numbers: "
        f"{str(shape.get('coordinates'))[:60]}. Export the file again."
    )
