"""Surfaces in VTK's legacy format (.vtk): PolyData in text or binary, versions 1 to 5.1.

The format is described in "VTK File Formats" of the VTK User's Guide. Honoured: float64 and
float32 points, polygons by counts (before 5.0) and by offsets (5.1), big-endian numbers, scalars,
vectors, normals and fields of points, the field ``crs``. Unstructured grids are read by meshio.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import unquote

import numpy as np

from geosurf.errors import FormatError
from geosurf.model import TriSurface
from geosurf.read._common import Request, noted, number_text, warn_of_end
from geosurf.read._guard import read_bytes
from geosurf.read._placed import surface_from_mesh, triangles_of_cells

# VTK writes its own ids as four bytes, however many they have in memory.
# names of number types in the file -> big-endian numpy types
TYPES = {
    "unsigned_char": "u1", "char": "i1", "unsigned_short": ">u2", "short": ">i2",
    "unsigned_int": ">u4", "int": ">i4", "unsigned_long": ">u8", "long": ">i8",
    "vtkidtype": ">i4", "vtktypeint64": ">i8", "vtktypeint32": ">i4", "vtktypeuint64": ">u8",
    "float": ">f4", "double": ">f8",
}  # fmt: skip
# a line that begins with a letter ends numbers in text
KEYWORD = re.compile(rb"^[ \t]*[A-Za-z_]", re.M)
WIDTHS = {"VECTORS": 3, "NORMALS": 3}  # values per point of attributes that do not state it
CELLS = ("VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS")


@dataclass
class Found:
    """What a file holds, as far as it was read.

    Attributes
    ----------
    points : ndarray of float64, shape (n, 3)
    triangles : ndarray of int64, shape (n, 3)
    data : dict of ndarray
        Numbers on points, each (n,) or (n, width).
    crs : str or None
    """

    points: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    triangles: np.ndarray = field(default_factory=lambda: np.empty((0, 3), dtype=np.int64))
    data: dict[str, np.ndarray] = field(default_factory=dict)
    crs: str | None = None


class Cursor:
    """A place in the bytes of a file, from which lines and arrays are taken."""

    def __init__(self, path: Path, data: bytes) -> None:
        self.path, self.data, self.at = path, data, 0
        self.binary = False
        self.new_cells = False  # offsets and connectivity, since version 5.1

    @property
    def line_number(self) -> int:
        """Line of the place, counted from 1; in binary files of little use."""
        return self.data.count(b"\n", 0, self.at) + 1

    def error(
        self, mistake: str, remedy: str = "The file is damaged; export it again."
    ) -> FormatError:
        """An error at this place."""
        where = f"byte {self.at}" if self.binary else f"line {self.line_number}"
        return FormatError(f"{self.path}, {where}: {mistake}. {remedy}")

    def words(self) -> list[str] | None:
        """Words of the next line that is not empty; None at the end of the file."""
        while self.at < len(self.data):
            end = self.data.find(b"\n", self.at)
            end = len(self.data) if end < 0 else end
            found = self.data[self.at : end].split()
            if found:
                words = [word.decode("latin-1") for word in found[:16]]
                self.at = end + 1
                return words
            self.at = end + 1
        return None

    def count(self, word: str, what: str) -> int:
        """A whole number that the rest of the file could hold."""
        if not re.fullmatch(r"[0-9]{1,18}", word):
            raise self.error(f"found {word!r} for {what}, expected a whole number")
        # each number takes a byte at least
        if int(word) > len(self.data) - self.at + 1:
            raise self.error(
                f"{word} {what} are announced, but {len(self.data) - self.at} bytes follow"
            )
        return int(word)

    def array(self, count: int, kind: str, what: str) -> np.ndarray:
        """Take `count` numbers of one type."""
        dtype = TYPES.get(kind.lower())
        if dtype is None:
            raise self.error(f"{what} are of the type {kind!r}, expected one of {', '.join(TYPES)}")
        if self.binary:
            size = count * np.dtype(dtype).itemsize
            piece = self.data[self.at : self.at + size]
            if len(piece) < size:
                raise self.error(f"{what} need {size} bytes, but {len(piece)} follow")
            self.at += size
            values = np.frombuffer(piece, dtype=dtype)
        else:
            end = KEYWORD.search(self.data, self.at)
            stop = end.start() if end else len(self.data)
            text = self.data[self.at : stop].decode("latin-1")
            values = number_text(text, self.path, self.line_number, what)
            if len(values) != count:
                raise self.error(f"{what} have {len(values)} numbers, expected {count}")
            self.at = stop
            # whole numbers stay whole, so that text and binary files give the same arrays
            if np.dtype(dtype).kind in "iu" and (values == np.rint(values)).all():
                values = values.astype(np.int64)
        return values

    def texts(self, count: int) -> list[str]:
        """Take texts: a line each, or with their length in front."""
        if not self.binary:
            return [unquote(" ".join(self.words() or [])) for _ in range(count)]
        texts_read = []
        for _ in range(count):
            head = self.data[self.at : self.at + 1]
            # two bits state how many bytes the length takes
            width = {3: 1, 2: 2, 1: 4, 0: 8}[head[0] >> 6] if head else 1
            length = int.from_bytes(self.data[self.at : self.at + width], "big")
            length &= (1 << (8 * width - 2)) - 1
            self.at += width
            if not head or self.at + length > len(self.data):
                raise self.error("a text is incomplete")
            text = self.data[self.at : self.at + length].decode("utf-8", "replace")
            texts_read.append(unquote(text))
            self.at += length
        return texts_read


def read_vtk(path: Path, request: Request) -> TriSurface:
    r"""
    Read a triangulated surface from PolyData in VTK's legacy format.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `name`: Default: the file name without suffix.
        `positive`: Default ``"up"``.
        `length_unit`: Unit of elevations. Default ``"m"``. Easting and northing are metres.

    Returns
    -------
    TriSurface
        Role ``"fault"``; quads are split, lines and points ignored, numbers on points kept.

    Raises
    ------
    FormatError
        If the file is damaged, cut short, or has strips or polygons of more than four corners.
    InputError
        If `positive` or `length_unit` is unknown.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "F1.vtk"
    >>> head = "# vtk DataFile Version 3.0\nF1\nASCII\nDATASET POLYDATA\n"
    >>> body = "POINTS 3 double\n0 0 0 9 0 0 0 9 9\nPOLYGONS 1 4\n3 0 1 2\n"
    >>> _ = file.write_text(head + body)
    >>> read_vtk(file, Request())
    <TriSurface 'F1' (fault): 3 vertices, 1 triangles>
    """
    at = Cursor(path, read_bytes(path))
    _take_header(at)
    mesh = Found()
    _take_sections(at, mesh)
    noted("kind", f"legacy VTK, {'binary' if at.binary else 'text'}")
    if mesh.crs:
        noted("crs", mesh.crs)
    bad = np.flatnonzero(~np.isfinite(mesh.points).all(axis=1))
    if len(bad):
        raise FormatError(
            f"{path}: point {bad[0]} is {mesh.points[bad[0]].tolist()}, expected finite numbers. "
            "Export the surface without undefined points."
        )
    name, triangles = request.named(path), mesh.triangles
    return surface_from_mesh(path, name, mesh.points, triangles, mesh.data, request, mesh.crs)


def _take_header(at: Cursor) -> None:
    """Version, title, ASCII or BINARY, and the kind of data."""
    # a last line without its end may end within a number
    version = re.match(rb"# vtk DataFile Version (\d+)\.(\d+)[^\n]*\n", at.data)
    if version is None:
        raise at.error("found another first line, expected '# vtk DataFile Version 3.0'")
    at.at = version.end()
    at.new_cells = (int(version[1][:4]), int(version[2][:4])) >= (5, 1)
    at.at = at.data.find(b"\n", at.at) + 1 or len(at.data)  # the title, which may be empty
    kind = " ".join(at.words() or []).upper()
    if kind not in ("ASCII", "BINARY"):
        raise at.error(f"found {kind!r}, expected ASCII or BINARY")
    if kind == "ASCII" and not at.data[-1:].isspace():
        last = at.data[at.data.rfind(b"\n") + 1 :].decode("latin-1")
        warn_of_end(at.path, at.data.count(b"\n") + 1, last)
    dataset = " ".join(at.words() or []).upper()
    at.binary = kind == "BINARY"
    if dataset != "DATASET POLYDATA":
        raise at.error(f"found {dataset!r}, expected DATASET POLYDATA", "Export a surface.")


def _take_sections(at: Cursor, mesh: Found) -> None:
    """Take points, cells and data up to the end of the file."""
    width = 0  # values in a row of data: points, or nothing that counts
    on_points = False
    while (words := at.words()) is not None:
        key = words[0].upper()
        short = len(words) < {"POINTS": 3, "FIELD": 3, "SCALARS": 3}.get(key, 2)
        if short and key not in ("METADATA", "ASCII", "BINARY"):
            raise at.error(f"the line {' '.join(words)!r} is incomplete")
        if key == "POINTS":
            width = at.count(words[1], "points")
            mesh.points = at.array(3 * width, words[2], "points").astype(float).reshape(-1, 3)
        elif key in CELLS:
            _take_cells(at, mesh, key, words)
        elif key in ("POINT_DATA", "CELL_DATA"):
            on_points = key == "POINT_DATA"
            width = at.count(words[1], "rows of data")
            if on_points and width != len(mesh.points):
                raise at.error(f"{width} rows of point data for {len(mesh.points)} points")
        elif key == "FIELD":
            _take_fields(at, mesh, on_points, at.count(words[2], "fields"))
        elif key == "METADATA":
            _pass_metadata(at)
        else:
            _take_attribute(at, mesh, key, words, width, on_points)
    if not len(mesh.points):
        raise at.error("the file has no POINTS", "Export a surface.")


def _take_cells(at: Cursor, mesh: Found, key: str, words: list[str]) -> None:
    """Polygons become triangles; points and lines have no area."""
    if len(words) < 3:
        raise at.error(f"the line {' '.join(words)!r} is incomplete")
    n_cell, size = (at.count(word, "cells") for word in words[1:3])
    if at.new_cells:
        # the first number counts offsets, one more than cells
        ends = _part(at, "OFFSETS", n_cell)
        corners = _part(at, "CONNECTIVITY", size)
        rises = len(ends) == 0 or (ends[0] == 0 and ends[-1] == size and (np.diff(ends) >= 0).all())
        if not rises:
            raise at.error(f"offsets of {key} do not rise from 0 to {size}")
        count = np.diff(ends)
        ends = ends[1:]
    else:
        corners, ends, count = _by_counts(at, key, n_cell, at.array(size, "int", key))
    if key == "TRIANGLE_STRIPS" and len(count):
        raise at.error("found triangle strips", "Triangulate the surface before saving it.")
    if key == "POLYGONS" and len(count):
        mesh.triangles = triangles_of_cells(at.path, corners, ends, count, len(mesh.points))


def _part(at: Cursor, key: str, count: int) -> np.ndarray:
    """Offsets or connectivity of cells."""
    words = at.words() or []
    if len(words) < 2 or words[0].upper() != key:
        raise at.error(f"found {' '.join(words)[:40]!r}, expected {key} and a type")
    return at.array(count, words[1], key).astype(np.int64)


def _by_counts(
    at: Cursor, key: str, n_cell: int, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Corners, ends and counts of cells that begin with the number of their corners."""
    rows = rows.astype(np.int64)
    # cells of one kind, as nearly always, need no walk from one to the next
    first = int(rows[0]) if len(rows) else 0
    if first > 0 and len(rows) == n_cell * (first + 1) and (rows[:: first + 1] == first).all():
        count = np.full(n_cell, first)
        return rows.reshape(n_cell, -1)[:, 1:].ravel(), np.cumsum(count), count
    starts = []
    place, listed = 0, rows.tolist()
    while place < len(listed) and listed[place] >= 0:
        starts.append(place)
        place += listed[place] + 1
    if place != len(listed) or len(starts) != n_cell:
        raise at.error(f"{key} have {len(starts)} cells, expected {n_cell}")
    count = rows[starts] if starts else np.empty(0, dtype=np.int64)
    is_corner = np.ones(len(rows), dtype=bool)
    is_corner[starts] = False
    return rows[is_corner], np.cumsum(count), count


def _take_attribute(
    at: Cursor, mesh: Found, key: str, words: list[str], rows: int, on_points: bool
) -> None:
    """Scalars, vectors, normals; others are passed over where their size is known."""
    if key == "SCALARS":
        width = at.count(words[3], "values per point") if len(words) > 3 else 1
        place = at.at
        if [word.upper() for word in (at.words() or [])[:1]] != ["LOOKUP_TABLE"]:
            at.at = place  # the line may be left out
    elif key in WIDTHS and len(words) > 2:
        width = WIDTHS[key]
    elif key == "TEXTURE_COORDINATES" and len(words) > 3:
        words, width = [key, words[1], words[3]], at.count(words[2], "values per point")
    elif key == "LOOKUP_TABLE" and len(words) > 2:
        at.array(4 * at.count(words[2], "colours"), "unsigned_char" if at.binary else "float", key)
        return
    else:
        raise at.error(f"found {key!r}, which geosurf does not read in PolyData")
    values = at.array(rows * width, words[2], words[1])
    if on_points:
        mesh.data[words[1]] = _native(values, rows, width)


def _take_fields(at: Cursor, mesh: Found, on_points: bool, count: int) -> None:
    """Arrays of a field: values on points, or the reference system of the file."""
    for _ in range(count):
        words = at.words() or []
        while words and words[0].upper() == "METADATA":
            _pass_metadata(at)
            words = at.words() or []
        if len(words) < 4:
            raise at.error(f"found {' '.join(words)!r}, expected name, width, count and type")
        width, rows = (at.count(word, "values") for word in words[1:3])
        if words[3].lower() in ("string", "utf8_string"):
            texts = at.texts(width * rows)
            if words[0].lower() == "crs" and texts:
                mesh.crs = texts[0]
            continue
        values = at.array(width * rows, words[3], words[0])
        if on_points and rows == len(mesh.points):
            mesh.data[unquote(words[0])] = _native(values, rows, width)


def _native(values: np.ndarray, rows: int, width: int) -> np.ndarray:
    """Numbers in the byte order of this machine, one row for each point."""
    values = values.astype(values.dtype.newbyteorder("="))
    return values if width == 1 else values.reshape(rows, width)


def _pass_metadata(at: Cursor) -> None:
    """Pass over lines up to an empty one."""
    end = re.compile(rb"\n[ \t\r]*\n").search(at.data, max(at.at - 1, 0))
    at.at = end.end() if end else len(at.data)
