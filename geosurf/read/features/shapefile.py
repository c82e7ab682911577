"""ESRI shapefiles: places in .shp, attributes in .dbf, the reference system in .prj.

The format is ESRI's white paper of July 1998. Points, lines and polygons are read, with z or
without; measures (m) are not used. Records that the .dbf marks as deleted are left out.
"""

from __future__ import annotations

import itertools
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.errors import FormatError
from geosurf.model import FaultSticks
from geosurf.read._guard import read_bytes
from geosurf.read._noted import noted
from geosurf.read._prj import crs_of_prj
from geosurf.read.features.collection import (
    Feature,
    Features,
    points_of,
    polygons_of,
    sticks_of,
)

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

HEADER = 100  # bytes
# kind and whether it has z, by the type of a shape
SHAPES = {
    1: ("point", False), 3: ("line", False), 5: ("ring", False), 8: ("points", False),
    11: ("point", True), 13: ("line", True), 15: ("ring", True), 18: ("points", True),
    21: ("point", False), 23: ("line", False), 25: ("ring", False), 28: ("points", False),
}  # fmt: skip
NO_DATA = -1e38  # values below mean "none"


def read_shapefile_points(
    path: Path,
    *,
    positive: str | None = None,
    length_unit: str | None = None,
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
) -> xr.Dataset:
    """
    Read points from a shapefile.

    Parameters
    ----------
    path : pathlib.Path
        The .shp; .dbf, .prj and .cpg of the same name are read where they exist.
    positive : {"up", "down"}
        Whether z is elevation or depth; the format does not state it.
    length_unit : str, optional
        Unit of z. Default ``"m"``.
    columns : sequence of str, optional
        The third name is the attribute that holds z.
    decimal : str
        Has no effect.

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` and all attributes over ``point``.

    Raises
    ------
    FormatError
        If a file is damaged, or holds lines.
    InputError
        If coordinates are degrees, or `positive` is missing.
    """
    return points_of(features(path), positive, length_unit, columns)


def read_shapefile_polygons(
    path: Path,
    *,
    positive: str | None = None,
    length_unit: str | None = None,
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
    name: str | None = None,
) -> list[np.ndarray]:
    """
    Read lines and the borders of polygons from a shapefile.

    Parameters
    ----------
    path, positive, length_unit, columns, decimal
        As for `read_shapefile_points`.
    name : str, optional
        Only lines of this name.

    Returns
    -------
    list of ndarray of float64, each (n, 3)

    Raises
    ------
    FormatError, InputError
        As `read_shapefile_points`.
    """
    return polygons_of(features(path), positive, length_unit, columns, name)


def read_shapefile_sticks(
    path: Path,
    *,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
) -> FaultSticks:
    """
    Read the sticks of a fault from the lines of a shapefile.

    Parameters
    ----------
    path, positive, length_unit, columns, decimal
        As for `read_shapefile_points`.
    name : str, optional
        Which fault, if the attribute ``name`` has several values; else the name of the fault.

    Returns
    -------
    FaultSticks

    Raises
    ------
    FormatError, InputError
        As `read_shapefile_points`.
    """
    return sticks_of(features(path), name, positive, length_unit, columns)


def features(path: Path) -> Features:
    """Return all points and lines of a shapefile."""
    shapes = list(_records(path, read_bytes(path)))
    rows = _rows(path)
    if rows is None:
        rows = [{} for _ in shapes]
    if len(rows) != len(shapes):
        raise FormatError(
            f"{path}: {len(shapes)} shapes, but {len(rows)} rows in the .dbf. Copy .shp and .dbf "
            "of one export."
        )
    items: list[Feature] = []
    empty = 0
    for parts, words in zip(shapes, rows, strict=True):
        if words is not None:  # else the row is deleted
            empty += not parts
            items += [Feature(kind, points, words) for kind, points in parts]
    return Features(path, items, crs_of_prj(path), empty)


def _beside(path: Path, suffix: str) -> bytes | None:
    """Bytes of the file of the same name with another suffix, or None."""
    for name in (path.with_suffix(suffix), path.with_suffix(suffix.upper())):
        if name.exists():
            return read_bytes(name)
    return None


# --------------------------------------------------------------------------- shapes
def _records(path: Path, data: bytes) -> Iterator[list[tuple[str, np.ndarray]]]:
    """Parts of each shape: kind and points (n, 3)."""
    words = struct.unpack_from(">i20xi", data.ljust(HEADER, b"\0"))
    if words[0] != 9994 or 2 * words[1] != len(data):
        raise FormatError(
            f"{path}: the header announces {2 * words[1]} bytes, but the file has {len(data)}. It "
            "is truncated or not a shapefile; export it again."
        )
    at = HEADER
    while at < len(data):
        number, size = struct.unpack_from(">ii", data.ljust(at + 8, b"\0"), at)
        piece = data[at + 8 : at + 8 + 2 * size]
        if size < 2 or len(piece) < 2 * size:
            raise FormatError(
                f"{path}: byte {at}: shape {number} announces {2 * size} bytes, but {len(piece)} "
                "follow. The file is damaged; export it again."
            )
        yield _shape(path, number, piece)
        at += 8 + 2 * size


def _shape(path: Path, number: int, piece: bytes) -> list[tuple[str, np.ndarray]]:
    """Parts of one shape."""
    (code,) = struct.unpack_from("<i", piece)
    if code == 0:
        return []
    if code not in SHAPES:
        raise FormatError(
            f"{path}: shape {number} is of the type {code}, expected points, lines or polygons. "
            "Export triangles as .vtp or GOCAD .ts."
        )
    kind, solid = SHAPES[code]
    counts, start = _counts(path, number, piece, kind)
    n = counts[-1]
    need = start + n * (24 if solid else 16) + (16 if solid and kind != "point" else 0)
    if len(piece) < need:
        raise FormatError(
            f"{path}: shape {number} announces {n} points, which need {need} bytes; it has "
            f"{len(piece)}. The file is damaged; export it again."
        )
    points = np.full((n, 3), np.nan)
    points[:, :2] = np.frombuffer(piece, "<f8", 2 * n, start).reshape(n, 2)
    if solid:
        # z of lines follow their lowest and highest
        points[:, 2] = np.frombuffer(piece, "<f8", n, need - 8 * n)
        points[points[:, 2] < NO_DATA, 2] = np.nan
    if not np.isfinite(points[:, :2]).all() or np.isinf(points).any():
        raise FormatError(
            f"{path}: shape {number} has a coordinate that is not finite. Export it again."
        )
    kind = "point" if kind == "points" else kind
    parts = np.split(points, counts[1:-1])
    short = [len(part) for part in parts if kind != "point" and len(part) < 2]
    if short:
        raise FormatError(
            f"{path}: shape {number} has a line of {short[0]} points, expected at least 2. Delete "
            "or complete it."
        )
    return [(kind, part) for part in parts]


def _counts(path: Path, number: int, piece: bytes, kind: str) -> tuple[list[int], int]:
    """Where parts begin and the last ends, and the byte of the first point."""
    if kind == "point":
        return [0, 1], 4
    n_part, n = 1, 0
    if kind == "points" and len(piece) >= 40:
        (n,) = struct.unpack_from("<i", piece, 36)
        starts, start = [0], 40
    elif len(piece) >= 44:
        n_part, n = struct.unpack_from("<ii", piece, 36)
        start = 44 + 4 * n_part
        fits = n_part > 0 and start <= len(piece)
        starts = np.frombuffer(piece, "<i4", n_part, 44).tolist() if fits else [-1]
    else:
        starts, start = [-1], 0
    counts = [*starts, n]
    if counts[0] != 0 or any(a > b for a, b in itertools.pairwise(counts)):
        raise FormatError(
            f"{path}: shape {number} announces {n_part} parts and {n} points, which do not fit its "
            f"{len(piece)} bytes. The file is damaged; export it again."
        )
    return counts, start


# ----------------------------------------------------------------------- attributes
def _rows(path: Path) -> list[dict[str, Any] | None] | None:
    """Attributes of each shape; None for deleted ones, or altogether without a .dbf."""
    data = _beside(path, ".dbf")
    if data is None:
        noted("attributes file", "none: there is no .dbf")
        return None
    n_row, head, width = struct.unpack_from("<IHH", data.ljust(12, b"\0"), 4)
    fields = []
    at, column = 32, 1
    while at + 32 <= min(head, len(data)) and data[at] != 0x0D:
        name = data[at : at + 11].split(b"\0")[0].decode("latin-1").strip()
        size = data[at + 16]
        fields.append((name, chr(data[at + 11]), column, column + size))
        at, column = at + 32, column + size
    if column != width or len(data) < head + n_row * width:
        raise FormatError(
            f"{path.with_suffix('.dbf')}: the header announces {n_row} rows of {width} bytes and "
            f"fields of {column}, but the file has {len(data)} bytes. Export it again."
        )
    coding = (_beside(path, ".cpg") or b"").decode("latin-1").strip().lower()
    utf8 = coding in ("", "utf-8", "utf8")
    found: list[dict[str, Any] | None] = []
    for k in range(n_row):
        row = data[head + k * width : head + (k + 1) * width]
        if row[:1] == b"*":
            found.append(None)
            continue
        found.append({name: _value(row[a:b], kind, utf8) for name, kind, a, b in fields})
    return found


def _value(word: bytes, kind: str, utf8: bool) -> Any:
    """A text, a number or a truth value; None where there is none."""
    word = word.strip(b" \0")
    if kind in "NF":
        if not word or word.startswith(b"*"):
            return None
        text = word.decode("latin-1").replace(",", ".")
        try:
            return int(text) if text.lstrip("+-").isdigit() else float(text)
        except ValueError:
            return None
    if kind == "L":
        return {b"t": True, b"y": True, b"f": False, b"n": False}.get(word.lower())
    try:
        return word.decode("utf-8" if utf8 else "latin-1")
    except UnicodeDecodeError:
        return word.decode("latin-1")
