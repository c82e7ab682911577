"""Points and lines with attributes, of GeoJSON (RFC 7946) and of ESRI shapefiles (through pyshp).

A file becomes `Features`, and these a table of points, polygons, or the sticks of a fault.
Elevations are third coordinates, or an attribute: one with a usual name (z, depth ...), or the one
that the third name of ``columns=`` states. Lines without elevations lie in the map, at z = 0.

GeoJSON: parts of multi-geometries become features of their own. The member ``crs`` of the format of
2008, and the members ``positive`` and ``units`` of a collection are honoured. The RFC takes
coordinates for degrees where a file states no system; large numbers cannot be degrees.

Shapefiles: .dbf, .prj and .cpg of the same name are read where they exist. Measures (m) are not
used. Records that the .dbf marks as deleted are left out.
"""

from __future__ import annotations

import io
import itertools
import json
import struct
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import counted
from geosurf.conventions.axes import USUAL
from geosurf.conventions.crs import label, warn_of_unclear_crs
from geosurf.conventions.machine import need
from geosurf.errors import FormatError, InputError, warn_of
from geosurf.lazy import xarray as xr
from geosurf.model import FaultSticks
from geosurf.model.base import in_crs_of
from geosurf.read._common import Request, check_name, chosen, is_looking, noted, read_text
from geosurf.read._guard import damaged, read_bytes, reading_with
from geosurf.read._placed import AXES, crs_from, crs_of_prj, points_dataset

# attributes that name the fault or horizon of a feature, lower case; the first that is there counts
NAMES = ("name", "fault", "fault_name", "faultname", "horizon", "surface")
KINDS = ("point", "line", "ring")


# type of a geometry of GeoJSON -> kind of its parts, and lists around the positions of a part
SHAPES = {
    "Point": ("point", 0), "MultiPoint": ("point", 1), "LineString": ("line", 1),
    "MultiLineString": ("line", 2), "Polygon": ("ring", 2), "MultiPolygon": ("ring", 3),
}  # fmt: skip
DEPTH = 8  # collections within one another
FEWEST = {"point": 1, "line": 2, "ring": 4}
# kind by the last digit of the type of a shape; types from 11 have z, those from 21 measures only
CODES = {1: "point", 3: "line", 5: "ring", 8: "point"}
HEADER = 100  # bytes of a shapefile before its shapes
NO_DATA = -1e38  # z below means "none"


@dataclass(frozen=True)
class Feature:
    """One part of a feature.

    Attributes
    ----------
    kind : {"point", "line", "ring"}
        A ring is the border of an area.
    points : ndarray of float64, shape (n, 3)
        x, y, z; NaN where there is no z.
    words : dict
        Attributes of the feature.
    """

    kind: str
    points: np.ndarray
    words: dict[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name of the fault or horizon, or nothing."""
        words = {key.lower(): value for key, value in self.words.items()}
        found = (words[key] for key in NAMES if words.get(key) not in (None, ""))
        return str(next(found, ""))


@dataclass(frozen=True)
class Features:
    """What a file holds.

    Attributes
    ----------
    path : pathlib.Path
    items : list of Feature
    crs : str or None
    empty : int
        Features without a place, which are left out.
    positive, length_unit : str or None
        What the file states of z.
    """

    path: Path
    items: list[Feature]
    crs: str | None = None
    empty: int = 0
    positive: str | None = None
    length_unit: str | None = None

    def scale(self, request: Request, what: str) -> float:
        """Metres of elevation per unit of z."""
        what = f"{self.path.name}: {what}"
        return request.scale(what, positive=self.positive, unit=self.length_unit)

    def checked(self) -> Features:
        """Return self, or raise an error if there is nothing, or if places are in degrees."""
        if not self.items:
            raise damaged(f"{self.path}: the file has no points and no lines")
        noted("features", ", ".join(counted(n, kind) for kind, n in self._counts().items()))
        keys = list(dict.fromkeys(key for one in self.items for key in one.words))
        noted("attributes", ", ".join(keys) or "none")
        if self.empty:
            noted("left out", counted(self.empty, "feature") + " without a place")
        if self.crs is not None:
            noted("crs", label(self.crs))
            if not is_looking():
                warn_of_unclear_crs({self.path.name: self.crs})
        self._warn_of_degrees()
        return self

    def _counts(self) -> dict[str, int]:
        counts: Counter[str] = Counter()
        for feature in self.items:
            counts[feature.kind] += len(feature.points) if feature.kind == "point" else 1
        return {kind: counts[kind] for kind in KINDS if counts[kind]}

    def _warn_of_degrees(self) -> None:
        """Small numbers may be degrees, also in systems that are given by a code."""
        x, y = np.concatenate([one.points[:, :2] for one in self.items]).T
        # a plain model may begin at 0, but rarely lies below 90 in all
        if np.abs(x).max() <= 180 and np.abs(y).max() <= 90 and not is_looking():
            effect = (
                f"Coordinates of '{self.path.name}' are {x.min():g} to {x.max():g} by {y.min():g} "
                f"to {y.max():g}, which could be degrees. geosurf takes them as metres."
            )
            remedy = "If they are degrees, convert the file to a projected system."
            warn_of("crs", self.path.name, effect, remedy)

    def only(self, kinds: Sequence[str], caller: str) -> list[Feature]:
        """All features, if they are of some kinds."""
        if any(one.kind not in kinds for one in self.items):
            held = " and ".join(counted(n, kind) for kind, n in self._counts().items())
            readers = {
                "point": "read_points", "line": "read_fault or read_polygons",
                "ring": "read_polygons",
            }  # fmt: skip
            others = [readers[kind] for kind in self._counts() if kind not in kinds]
            remedy = (
                "Write one file for each kind."
                if len(self._counts()) > 1
                else f"Read it with {others[0]}."
            )
            raise FormatError(
                f"{self.path}: the file holds {held}, which {caller} does not read. {remedy}"
            )
        return self.items

    def raised(self, columns: Any) -> Features:
        """Return the same with z from an attribute, where there are no third coordinates."""
        flat = [feature for feature in self.items if np.isnan(feature.points[:, 2]).any()]
        if not flat and columns is None:
            noted("elevations", "third coordinates")
            return self
        key = self._attribute_of_z(columns, bool(flat))
        if key is None:
            return self
        noted("elevations", f"attribute {key}")
        items = []
        for k, feature in enumerate(self.items):
            value = feature.words.get(key)
            if (
                isinstance(value, bool)
                or not isinstance(value, int | float)
                or not np.isfinite(value)
            ):
                raise FormatError(
                    f"{self.path}: attribute {key!r} of feature {k} (counted from 0) is {value!r}, "
                    "expected a number. Complete it, or delete the feature."
                )
            points = feature.points.copy()
            points[:, 2] = value
            items.append(Feature(feature.kind, points, feature.words))
        return replace(self, items=items)

    def _attribute_of_z(self, columns: Any, flat: bool) -> str | None:
        """Name of the attribute that holds z."""
        keys = list(dict.fromkeys(key for one in self.items for key in one.words))
        if columns is not None:
            if isinstance(columns, str) or len(list(columns)) != 3 or list(columns)[2] not in keys:
                raise InputError(
                    f"{self.path}: columns is {columns!r}. x and y are coordinates here; give the "
                    f"attribute of z as the third name, one of {', '.join(keys) or 'none'}, as in "
                    "columns=('X', 'Y', 'DEPTH')."
                )
            return str(list(columns)[2])
        usual = [key for key in keys if key.lower() in (*USUAL["z"], "tvdss")]
        return usual[0] if flat and len(usual) == 1 else None

    def to_metres(self, feature: Feature, scale: float) -> np.ndarray:
        """Points of a feature with elevations."""
        missing = int(np.isnan(feature.points[:, 2]).sum())
        if missing:
            keys = ", ".join(feature.words) or "none"
            raise FormatError(
                f"{self.path}: {missing} of {counted(len(feature.points), 'point')} of a "
                f"{feature.kind} have no elevation (attributes: {keys}). Give the attribute that "
                "holds it, as in "
                "columns=('X', 'Y', 'DEPTH'), or export third coordinates."
            )
        return feature.points * [1.0, 1.0, scale] + 0.0


def read_feature_points(path: Path, request: Request) -> xr.Dataset:
    r"""
    Read points with their attributes.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `positive`: Whether z is elevation or depth, if the file does not state it.
        `length_unit`: Unit of z, if the file does not state it. Default ``"m"``.
        `columns`: The third name is the attribute that holds z.
        `decimal`: Has no effect.

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` and all attributes over ``point``.

    Raises
    ------
    FormatError
        If the file is damaged, or holds lines, or points without elevations.
    InputError
        If coordinates are degrees, or `positive` is missing.
    DependencyError
        If the file is a shapefile and pyshp is not installed.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "a.geojson"
    >>> _ = file.write_text('{"type": "Point", "coordinates": [461000, 5932000, 1500]}\n')
    >>> read_feature_points(file, Request(positive="down")).elevation.values
    array([-1500.])
    """
    read = features(path).checked().raised(request.columns)
    items = read.only(("point",), "read_points")
    scale = read.scale(request, "points")
    xyz = np.concatenate([read.to_metres(feature, scale) for feature in items])
    keys = dict.fromkeys(key for feature in items for key in feature.words)
    sizes = [len(feature.points) for feature in items]
    # an attribute called as a coordinate would hide it
    others: dict[str, Any] = {}
    for key in (key for key in keys if key.lower() not in (*AXES, *others)):
        others[key] = ("point", _column([feature.words.get(key) for feature in items], sizes))
    return points_dataset(xyz, read.path.name, read.crs, others)


def _column(values: list[Any], sizes: list[int]) -> np.ndarray:
    """One value for each point: numbers as float64, else objects."""
    numeric = all(
        value is None or (isinstance(value, int | float) and not isinstance(value, bool))
        for value in values
    )
    column = np.array([np.nan if numeric and v is None else v for v in values],
                      dtype=np.float64 if numeric else object)  # fmt: skip
    return np.repeat(column, sizes)


def read_feature_polygons(path: Path, request: Request) -> list[np.ndarray]:
    """
    Read lines and the borders of areas, in file order; holes are lines of their own.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `positive`, `length_unit`, `columns`, `decimal`: As for `read_feature_points`.
        `name`: Only lines of this name.

    Returns
    -------
    list of ndarray of float64, each (n, 3)

    Raises
    ------
    FormatError, InputError, DependencyError
        As `read_feature_points`; `positive` may be missing where all z are 0.
    """
    read = features(path).checked().raised(request.columns)
    items = read.only(("line", "ring"), "read_polygons")
    check_name(read.path, (feature.name for feature in items), request.name)
    items = [feature for feature in items if request.name in (None, feature.name)]
    z = np.concatenate([feature.points[:, 2] for feature in items])
    # lines drawn on a map have no z, or 0 throughout
    if np.isnan(z).all() or (request.positive is None and read.positive is None and not z.any()):
        noted("elevations", "none: lines lie in the map, z = 0")
        return [np.nan_to_num(feature.points) for feature in items]
    scale = read.scale(request, "polygons")
    return [read.to_metres(feature, scale) for feature in items]


def read_feature_sticks(path: Path, request: Request) -> FaultSticks:
    """
    Read lines as the sticks of a fault.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `positive`, `length_unit`, `columns`, `decimal`: As for `read_feature_points`.
        `name`: Which fault, if the attribute ``name`` has several values; else the name of the
        fault.

    Returns
    -------
    FaultSticks

    Raises
    ------
    FormatError, InputError, DependencyError
        As `read_feature_points`.
    """
    read = features(path).checked().raised(request.columns)
    lines = [(feature.name, feature) for feature in read.only(("line",), "read_fault")]
    title, items = chosen(read.path, lines, request.name, "faults")
    scale = read.scale(request, "fault sticks")
    sticks = tuple(read.to_metres(feature, scale) for feature in items)
    return in_crs_of(FaultSticks(request.name or title or read.path.stem, sticks), [read])


def features(path: Path) -> Features:
    """Return all points and lines of a file."""
    data = read_bytes(path)
    shapes = data.startswith(b"\x00\x00\x27\x0a") or path.suffix.lower() == ".shp"
    return _of_shapefile(path, data) if shapes else _of_geojson(path)


# ---- GeoJSON --------------------------------------------------------------------------


def _of_geojson(path: Path) -> Features:
    with reading_with(path, "the JSON parser"):
        document = json.loads(read_text(path, final_line_end=False), parse_constant=_no_constant)
    if not isinstance(document, dict):
        raise damaged(f"{path}: this is not a GeoJSON object")
    items: list[Feature] = []
    empty = 0
    for shape, words in _geometries(path, document, {}, 0):
        parts = list(_parts(path, shape)) if shape else []
        empty += not parts
        items += [Feature(kind, points, words) for kind, points in parts]
    stated = {key: _word(path, document, key) for key in ("positive", "units")}
    return Features(path, items, _crs(path, document), empty, stated["positive"], stated["units"])


def _no_constant(word: str) -> float:
    raise ValueError(f"found {word}, expected a number")


def _word(path: Path, found: dict[str, Any], key: str) -> str | None:
    """A text at the top of the file, or None."""
    value = found.get(key)
    if value is not None and not isinstance(value, str):
        raise InputError(f"{path}: the member {key!r} is {value!r}, expected a text. Correct it.")
    return value


def _crs(path: Path, found: dict[str, Any]) -> str | None:
    """The reference system in the form of 2008, or a plain text."""
    stated = found.get("crs")
    if isinstance(stated, dict):
        properties = stated.get("properties")
        stated = properties.get("name") if isinstance(properties, dict) else None
    return crs_from(stated, path) if isinstance(stated, str) else None


def _geometries(
    path: Path, node: Any, words: dict[str, Any], depth: int
) -> Iterator[tuple[dict[str, Any] | None, dict[str, Any]]]:
    """Each geometry with the attributes of its feature; None where a feature has none."""
    kind = node.get("type") if isinstance(node, dict) else None
    if node is None:
        yield None, words
    elif kind in SHAPES:
        yield node, words
    elif kind in ("FeatureCollection", "GeometryCollection") and depth < DEPTH:
        parts = node.get("features" if kind == "FeatureCollection" else "geometries")
        if not isinstance(parts, list):
            raise damaged(f"{path}: a {kind} has no list of its parts")
        for part in parts:
            yield from _geometries(path, part, words, depth + 1)
    elif kind == "Feature" and depth < DEPTH:
        own = node.get("properties")
        yield from _geometries(
            path, node.get("geometry"), own if isinstance(own, dict) else {}, depth + 1
        )
    else:
        raise damaged(
            f"{path}: found an object of the type {kind!r}, expected one of Feature, "
            f"FeatureCollection, {', '.join(SHAPES)}"
        )


def _parts(path: Path, shape: dict[str, Any]) -> Iterator[tuple[str, np.ndarray]]:
    """Kind and points (n, 3) of each part of a geometry."""
    kind, depth = SHAPES[shape["type"]]
    coordinates = shape.get("coordinates")
    if not isinstance(coordinates, list):
        raise damaged(f"{path}: a {shape['type']} has no coordinates")
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
    return damaged(
        f"{path}: coordinates of a {shape['type']} are not lists of two or three finite numbers: "
        f"{str(shape.get('coordinates'))[:60]}"
    )


# ---- shapefiles -----------------------------------------------------------------------


def _of_shapefile(path: Path, data: bytes) -> Features:
    """Shapes and their attributes."""
    need("Shapefiles need", "shapefile")
    import shapefile

    magic, size = struct.unpack_from(">i20xi", data.ljust(HEADER, b"\0"))
    if magic != 9994 or 2 * size != len(data):
        raise damaged(
            f"{path}: the header announces {2 * size} bytes, but the file has {len(data)}"
        )
    coding = (_beside(path, ".cpg") or b"").decode("latin-1").strip().lower()
    encodings = ("utf-8", "latin-1") if coding in ("", "utf-8", "utf8") else ("latin-1",)
    with reading_with(path, "pyshp"):
        shapes = [*shapefile.Reader(shp=io.BytesIO(data)).iterShapes()]
        rows = _rows(shapefile, path, encodings, len(shapes))
    if len(rows) != len(shapes):
        raise FormatError(
            f"{path}: {len(shapes)} shapes, but {len(rows)} rows in the .dbf. Copy .shp and .dbf "
            "of one export."
        )
    items: list[Feature] = []
    empty = 0
    for k, (shape, words) in enumerate(zip(shapes, rows, strict=True), start=1):
        if words is not None:  # else the row is deleted
            kind, parts = _parts_of_shape(path, k, shape)
            empty += not parts
            items += [Feature(kind, points, words) for points in parts]
    return Features(path, items, crs_of_prj(path), empty)


def _beside(path: Path, suffix: str) -> bytes | None:
    """Bytes of the file of the same name with another suffix, or None."""
    names = (path.with_suffix(suffix), path.with_suffix(suffix.upper()))
    return next((read_bytes(name) for name in names if name.exists()), None)


def _rows(
    shapefile: Any, path: Path, encodings: Sequence[str], count: int
) -> list[dict[str, Any] | None]:
    """Attributes of each shape, none without a .dbf; None for deleted shapes."""
    table = _beside(path, ".dbf")
    if table is None:
        noted("attributes file", "none: there is no .dbf")
        return [{}] * count
    try:
        found = shapefile.Reader(dbf=io.BytesIO(table), encoding=encodings[0])
        rows = [found.record(k) for k in range(found.numRecords)]
    except UnicodeDecodeError:
        return _rows(shapefile, path, encodings[1:], count)
    return [row and {key: _as_text(value) for key, value in row.as_dict().items()} for row in rows]


def _as_text(value: Any) -> Any:
    """A day as it is written in the file; other values as they are."""
    return f"{value:%Y%m%d}" if isinstance(value, date) else value


def _parts_of_shape(path: Path, number: int, shape: Any) -> tuple[str, list[np.ndarray]]:
    """Kind of a shape, and the points (n, 3) of each part."""
    code = shape.shapeType
    if code == 0:
        return "", []
    if code > 28 or code % 10 not in CODES:
        raise FormatError(
            f"{path}: shape {number} is of the type {code}, expected points, lines or polygons. "
            "Export triangles as .vtp or GOCAD .ts."
        )
    kind = CODES[code % 10]
    points = np.full((len(shape.points), 3), np.nan)
    points[:, :2] = [place[:2] for place in shape.points]
    if 10 < code < 20:
        points[:, 2] = shape.z
        points[points[:, 2] < NO_DATA, 2] = np.nan
    if not np.isfinite(points[:, :2]).all() or np.isinf(points).any():
        raise damaged(f"{path}: shape {number} has a coordinate that is not finite")
    if kind == "point":
        return kind, [points]
    ends = [*shape.parts, len(points)]
    parts = [points[a:b] for a, b in itertools.pairwise(ends)]
    short = [len(part) for part in parts if len(part) < 2]
    if short or ends[0] != 0:
        raise FormatError(
            f"{path}: shape {number} has a line of {[*short, 0][0]} points, expected at least 2. "
            "Delete or complete it."
        )
    return kind, parts
