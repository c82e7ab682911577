"""Polylines in text: fault sticks and polygons, ``x y z`` per line.

RMS and Petrel end each polyline with a line ``999 999 999``. A file that does not
end with one was cut short. In csv, or where ``columns=`` has a fourth, a column holds the number of
the polyline of each point, and another one may hold the name of its fault.
"""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions.axes import COORDINATES, LABELS, USUAL
from geosurf.errors import FormatError, InputError, warn_of
from geosurf.lazy import xarray as xr
from geosurf.model import FaultSticks
from geosurf.read._common import (
    Request,
    check_name,
    chosen,
    is_looking,
    is_number,
    noted,
    number,
    number_rows,
    read_text,
    warn_of_end,
    with_point,
)
from geosurf.read._guard import damaged
from geosurf.read._placed import points_dataset
from geosurf.read._table import (
    END_MARK,
    Table,
    checked_columns,
    checked_decimal,
    columns_of_places,
    first_column,
    read_table,
)
from geosurf.read.features import features
from geosurf.read.tops import Layout, layout_of

# ---- attributes ----------------------------------------
# Points, polygons and sticks with attributes, as RMS and Petrel export them.
#
# RMS begins with a line for each attribute (``Float dip``, ``String fault``), then writes x, y, z
# and the attributes. Petrel names its columns between BEGIN HEADER and END HEADER. Lines of
# polygons are separated by ``999 999 999`` or by a column with their number; texts with blanks
# are in quotes.


UNDEFINED = ("undef", "undefined", "nan", "null")


def read_attribute_points(path: Path, request: Request) -> xr.Dataset:
    r"""
    Read points with their attributes.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `positive`: The formats do not state it, so this argument is required.
        `length_unit`: Unit of z, if a comment of Petrel does not state it. Default ``"m"``.
        `columns`: Names of easting, northing and z, if they are not X, Y and Z.

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` and all attributes over ``point``; undefined
        numbers are NaN.

    Raises
    ------
    FormatError
        If a line has more or fewer words than there are columns, or a coordinate is not a number.
    InputError
        If `positive` is missing.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "picks.dat"
    >>> _ = file.write_text("Float dip\nString well\n1 2 30 5.5 \"W 1\"\n3 4 50 UNDEF W2\n")
    >>> picks = read_attribute_points(file, Request(positive="down"))
    >>> picks.elevation.values, picks.dip.values, picks.well.values.tolist()
    (array([-30., -50.]), array([5.5, nan]), ['W 1', 'W2'])
    """
    layout, table = _table(path, request.columns, request.decimal)
    inside = ~(table.points == END_MARK).all(axis=1)
    what = f"{path.name}: points"
    scale = request.scale(what, unit=layout.length_unit)
    points = table.points[inside] * [1.0, 1.0, scale] + 0.0
    others: dict[str, Any] = {}
    rows = [words for (_, words), take in zip(layout.rows, inside.tolist(), strict=True) if take]
    for k, name in enumerate(layout.header or ()):
        # coordinates are there already, also under other names
        taken = name.lower() in (*COORDINATES, *others)
        if k not in _places(path, layout, request.columns) and not taken:
            others[name] = ("point", _column([words[k] for words in rows]))
    noted("attributes", ", ".join(str(key) for key in others) or "none")
    return points_dataset(points, path.name, others=others)


def read_attribute_polygons(path: Path, request: Request) -> list[np.ndarray]:
    """
    Read polygons or lines with attributes.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `positive`, `length_unit`, `columns`, `decimal`: As for `read_attribute_points`; `positive`
        may be left out where all z are 0.
        `name`: Only lines whose attribute ``name`` or ``fault`` is this one.

    Returns
    -------
    list of ndarray of float64, each (n, 3)

    Raises
    ------
    FormatError, InputError
        As `read_attribute_points`.
    """
    return polylines_from(path, *_attribute_parts(path, request))


def read_attribute_sticks(path: Path, request: Request) -> FaultSticks:
    """
    Read the sticks of a fault from lines with attributes.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `positive`, `length_unit`, `columns`, `decimal`: As for `read_attribute_points`.
        `name`: Which fault, if there are several; else the name of the fault.

    Returns
    -------
    FaultSticks

    Raises
    ------
    FormatError, InputError
        As `read_attribute_points`.
    """
    return sticks_from(path, *_attribute_parts(path, request))


def _attribute_parts(path: Path, request: Request) -> tuple[list[Part], Request]:
    """Lines as they stand in the file, and what is asked, with the unit that the file states."""
    layout, table = _table(path, request.columns, request.decimal)
    unit = request.length_unit if layout.length_unit is None else layout.length_unit
    return parts_of(path, table), replace(request, length_unit=unit)


def _table(path: Path, columns: Any, decimal: Any) -> tuple[Layout, Table]:
    """The file as it stands, and its coordinates, numbers of lines and names."""
    sign = checked_decimal(decimal)
    layout = layout_of(path, sign, ends=True)
    if not layout.rows:
        raise damaged(f"{path}: the file has no points below its header")
    places = _places(path, layout, columns)
    lines = [line for line, _ in layout.rows]
    flat = [with_point(words[place], sign) for _, words in layout.rows for place in places]
    points = number_rows(flat, lines, path, "x, y or z")
    header = [word.lower() for word in layout.header or ()]
    more: list[list[str] | None] = []
    for usual in (LABELS, NAMES):
        place = first_column(header, usual)
        more.append(None if place is None else [_word(words, place) for _, words in layout.rows])
    noted("columns", f"easting, northing, z are columns {', '.join(str(k + 1) for k in places)}")
    noted("attributes", ", ".join((layout.header or [])[3:]) or "none")
    return layout, Table(points, np.array(lines), *more)


def _word(words: list[str], place: int) -> str:
    """A word of a row; end marks may be shorter than the header."""
    return words[place] if place < len(words) else ""


def _places(path: Path, layout: Layout, columns: Any) -> list[int]:
    """Columns of x, y and z."""
    header = [word.lower() for word in layout.header or ()]
    if columns is None:
        return columns_of_places(f"{path}, line 1", header, USUAL)
    words = checked_columns(columns, ("easting", "northing", "z"), "('X', 'Y', 'Z')")
    if not set(words or ()) <= set(header):
        raise InputError(f"{path}: columns is {columns!r}, expected names of {', '.join(header)}.")
    return [header.index(str(word)) for word in words or ()]


def _column(words: list[str]) -> np.ndarray:
    """Numbers with NaN where undefined, or texts."""
    numeric = all(is_number(word) or word.lower() in UNDEFINED for word in words)
    if numeric and any(is_number(word) for word in words):
        return np.array([float(word) if is_number(word) else np.nan for word in words])
    return np.array(words, dtype=object)


# ---- points ----------------------------------------
# Scattered points: ``x y z`` per line of text, or under a header that names the columns.


# further columns that are kept: they part the paths of several wells
WELL = ("well", "wellname", "well_name", "wellbore", "uwi", "borehole")
MEASURED = ("md", "mdepth")


def read_xyz(path: Path, request: Request) -> xr.Dataset:
    r"""
    Read points from text or csv.

    Parameters
    ----------
    path : pathlib.Path
        ``.csv`` has a header with the columns ``X_UTME,Y_UTMN,Z_TVDSS`` or ``X,Y,Z``,
        among others in any order. Other text may have one, too; without it, x, y, z are
        the only numbers on each line. RMS ends points with ``999 999 999``.
    request : Request
        `positive`: The formats do not state it, so this argument is required. (The column name
        Z_TVDSS is no promise: it is written for elevations and for times, too.)
        `length_unit`: Unit of z (x and y are metres). Default ``"m"``.
        `columns`: Names of easting, northing and z in the header, or numbers of their columns from
        1.
        `decimal`: Decimal sign of the file.

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` over ``point`` [m], positive up.
        Several points may share a position. Columns of wells and measured depths become ``well``
        and ``md``.

    Raises
    ------
    FormatError
        If a line is not three numbers, or a column is missing.
    InputError
        If `positive` is missing, `length_unit` unknown, or `columns` are not three names or
        numbers.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.poi"
    >>> _ = file.write_text("0 0 1500\n0 50 1600\n")
    >>> read_xyz(file, Request(positive="down")).elevation.values
    array([-1500., -1600.])
    """
    what = f"{path.name}: points"
    scale = request.scale(what)
    table = read_table(path, request.columns, request.decimal, (WELL, MEASURED), ("well", "md"))
    points = _without_end(path, table)
    x, y, z = points.T
    if len(z) and NORTHINGS[0] < np.median(np.abs(scale * z)) < NORTHINGS[1]:
        raise FormatError(
            f"{path}: z is around {np.median(z):.0f}, so these columns are not x, y and z. Name "
            "those, by number or header: columns=[2, 3, 1]."
        )
    others: dict[str, Any] = {}
    has_header = int(table.lines[0]) > 1
    several = several_objects(read_text(path, final_line_end=False)) if has_header else ""
    if several:
        noted("objects", several)
    if several and request.columns is None and not is_looking():
        effect = f"{path}: all points are read as one horizon, but {several}."
        how = "Or name the columns, if these are one: columns=[x, y, z]."
        warn_of("objects", path.name, effect, how)
    if table.labels is not None:
        others["well"] = ("point", np.array(table.labels[: len(points)], dtype=object))
    if table.names is not None:
        depths = _measured(path, table, len(points), request.decimal)
        others["md"] = ("point", abs(scale) * depths, {"units": "m"})
    return points_dataset(np.column_stack([x, y, scale * z + 0.0]), path.name, others=others)


NORTHINGS = (1e6, 1e8)  # in size [m]: no elevation is so high
FEWEST = 3  # points of an object: more values than that are measurements
OBJECT_COLUMNS = ("feature_name", "formation", "horizon", "surface", "val", "name")


def several_objects(text: str) -> str:
    r"""
    Return the reason why a table holds more than one object, or nothing.

    Examples
    --------
    >>> several_objects("X,Y,Z,val\n" + 3 * "0,0,1,60\n" + 3 * "0,9,2,250\n")
    "its column 'val' has 2 values: write one file for each object"
    """
    header, _, body = text.lstrip().partition("\n")
    names = [word.strip().strip('"').lower() for word in header.split(",")]
    columns = [column for column in OBJECT_COLUMNS if column in names]
    if not columns or not {"x", "easting", "x_utme"} & set(names):
        return ""
    rows = [line.split(",") for line in body.split("\n") if line.strip()]
    for column in columns:
        k = names.index(column)
        values = {row[k] for row in rows if len(row) > k and row[k].strip()}
        if 1 < len(values) <= len(rows) / FEWEST:
            n = len(values)
            return f"its column {column!r} has {n} values: write one file for each object"
    return ""


def _measured(path: Path, table: Table, count: int, decimal: str) -> np.ndarray:
    """Measured depths along wells, NaN where the file has none."""
    words = [word.replace(decimal, ".", 1) for word in (table.names or [])[:count]]
    empty = ("", "nan", "undef")
    return np.array(
        [
            np.nan if word.lower() in empty else number(word, path, int(line), "measured depth")
            for word, line in zip(words, table.lines, strict=False)
        ]
    )


def _without_end(path: Path, table: Table) -> np.ndarray:
    """Points (n, 3); 999 999 999 on the last lines of a text ends them, as RMS writes it."""
    points = table.points
    if path.suffix.lower() == ".csv":
        return points
    ends = (points == END_MARK).all(axis=1)
    n_point = len(points) - int(np.argmin(ends[::-1])) if not ends.all() else 0
    inside = np.flatnonzero(ends[:n_point])
    if len(inside):
        raise FormatError(
            f"{path}, line {table.lines[inside[0]]}: '999 999 999' ends a polyline, but this "
            "file should hold points. Read sticks with read_fault and outlines with "
            "read_polygons (suffix .pol)."
        )
    if n_point == 0:
        raise FormatError(f"{path}: the file has end marks only, expected x y z on each line.")
    return points[:n_point]


# ---- line names ----------------------------------------
# Names of the faults that one file of lines holds, for functions that read them one by one.


# formats whose files may hold the sticks of several faults
NAMED_LINES = ("charisma", "geojson", "shapefile")


def fault_names(path: Path, key: str) -> list[str]:
    r"""
    Return the names of the faults in a file of lines, "" for lines without a name.

    Parameters
    ----------
    path : pathlib.Path
    key : {"charisma", "geojson", "shapefile"}

    Raises
    ------
    FormatError
        If the file is damaged, or holds points or areas.

    Examples
    --------
    >>> import tempfile
    >>> file = Path(tempfile.mkdtemp()) / "faults.dat"
    >>> rows = "INLINE- 1 2 0 0 5 F1 1\nINLINE- 1 2 0 0 9 F1 1\nINLINE- 1 2 5 0 5 F2 1\n"
    >>> _ = file.write_text(rows)
    >>> fault_names(file, "charisma")
    ['F1', 'F2']
    """
    if key == "charisma":
        return list(dict.fromkeys(read_charisma(path).names or []))
    found = features(path).checked()
    names = [one.name for one in found.only(("line",), "read_fault")]
    if not names:
        raise damaged(f"{path}: the file has no lines")
    return list(dict.fromkeys(names))


# ---- charisma ----------------------------------------
# Charisma fault sticks, as Petrel and others export them.
#
# Each line is ``INLINE- 1201 3405 461000.1 5932000.5 1600.0 F1 1``: the kind of seismic line,
# inline, crossline, x, y, z, the name of the fault, and the number of the stick. Names may
# contain blanks.


# kind, inline, crossline, x, y, z, the name, the stick
ROW = re.compile(
    r"[A-Za-z]+[ \t]*[-:]?[ \t]*-?\d\S*[ \t]+-?\d\S*[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)"
    r"(?:[ \t]+(\S.*?))?[ \t]+(\d+)[ \t]*"
)


def read_charisma(path: Path) -> Table:
    r"""
    Return the points of all sticks, with the numbers of sticks and names of faults.

    Parameters
    ----------
    path : pathlib.Path

    Returns
    -------
    Table

    Raises
    ------
    FormatError
        If a line is not that of a stick.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "faults.dat"
    >>> _ = file.write_text("INLINE- 1201 3405 461000.1 5932000.5 1600.0 Main fault 7\n")
    >>> found = read_charisma(file)
    >>> found.points.tolist(), found.names
    ([[461000.1, 5932000.5, 1600.0]], ['Main fault'])
    """
    points: list[list[float]] = []
    lines: list[int] = []
    labels: list[str] = []
    names: list[str] = []
    for i, line in enumerate(read_text(path).split("\n"), start=1):
        row = line.strip()
        if not row or row.startswith(("#", "!")):
            continue
        match = ROW.fullmatch(row)
        if match is None:
            raise damaged(
                f"{path}, line {i}: found {row[:60]!r}, expected INLINE-, inline, crossline, x, y, "
                "z, the name of the fault and the number of its stick"
            )
        points.append([number(word, path, i, "x, y or z") for word in match.groups()[:3]])
        names.append(" ".join((match[4] or "").strip("\"'").split()))
        labels.append(match[5])
        lines.append(i)
    if not points:
        raise damaged(f"{path}: the file has comments only")
    noted("columns", "x, y, z, name and stick follow inline and crossline, which are not used")
    return Table(np.array(points), np.array(lines), labels, names)


# ---- cps3 lines ----------------------------------------
# CPS-3 lines, as Petrel exports polygons and fault sticks.
#
# Lines of the header begin with ``FF``. ``-> name`` begins a line; its points ``x y z`` follow.


HEADER, BEGIN = "FF", "->"


def read_cps3_polygons(path: Path, request: Request) -> list[np.ndarray]:
    r"""
    Read the lines of a CPS-3 file.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `name`: Only the lines of this name.
        `positive`, `length_unit`: As for `read_polylines`.

    Returns
    -------
    list of ndarray of float64, each (n, 3)

    Raises
    ------
    FormatError, InputError
        If a line of the file is neither a header, a begin nor three numbers; or as
        `read_polylines`.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "outline.cps3"
    >>> _ = file.write_text("FFASCI 0 0 COMPUTED 0 1E30\nFFATTR 0 0\n-> 1\n0 0 0\n9 0 0\n9 9 0\n")
    >>> [len(line) for line in read_cps3_polygons(file, Request())]
    [3]
    """
    return polylines_from(path, _lines(path), request)


def read_cps3_sticks(path: Path, request: Request) -> FaultSticks:
    """
    Read the lines of a CPS-3 file as the sticks of one fault.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `name`: Name of the fault; names of lines are those of sticks here. Default: that of the
        file.
        `positive`, `length_unit`: As for `read_sticks`.

    Returns
    -------
    FaultSticks

    Raises
    ------
    FormatError, InputError
        As `read_cps3_polygons` and `read_sticks`.
    """
    parts = [Part(part.points, part.line) for part in _lines(path)]
    return sticks_from(path, parts, request)


def _lines(path: Path) -> list[Part]:
    """Lines as they stand in the file."""
    lines: list[tuple[str, int, list[list[float]]]] = []
    for i, line in enumerate(read_text(path).split("\n"), start=1):
        words = line.split()
        if not words or words[0].startswith("!"):
            continue
        if line.lstrip().startswith(BEGIN):
            lines.append((line.strip()[len(BEGIN) :].strip(), i, []))
        elif words[0].upper().startswith(HEADER) and not lines:
            continue
        elif len(words) != 3 or not lines:
            raise damaged(
                f"{path}, line {i}: found {line.strip()[:60]!r}, expected '-> name' or x y z"
            )
        else:
            lines[-1][2].append([number(word, path, i, "x, y or z") for word in words])
    # a begin without points ends some files
    parts = [Part(np.array(points), line, name) for name, line, points in lines if points]
    if not parts:
        raise damaged(f"{path}: the file has no lines with points")
    return parts


# columns with the name of the fault of a polyline, lower case
NAMES = ("name", "fault", "fault_name", "faultname")


@dataclass(frozen=True)
class Part:
    """One polyline as it stands in the file: points (n, 3), its first line, the name it has."""

    points: np.ndarray
    line: int
    name: str = ""


def read_sticks(path: Path, request: Request) -> FaultSticks:
    r"""
    Read fault sticks: each ended by ``999 999 999``, or a table with ``POLY_ID`` or ``STICK_ID``.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `name`: Which fault, if the file names several; else the name of the fault. Default: the
        name in the file, else the file name without suffix.
        `positive`: The format does not state it, so this argument is required.
        `length_unit`: Unit of z (x and y are metres). Default ``"m"``.
        `columns`, `decimal`: Which columns x, y and z are, and the decimal sign, as for points. A
        fourth column has the number of the stick, a fifth the name of the fault.

    Returns
    -------
    FaultSticks
        Sticks in file order, each (n, 3): easting, northing, elevation [m].

    Raises
    ------
    FormatError
        If a line is not three numbers, a stick has one point, or the last is not ended.
    InputError
        If `positive` is missing or `length_unit` unknown.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "F1.pol"
    >>> _ = file.write_text("0 0 1500\n0 50 1600\n999 999 999\n")
    >>> read_sticks(file, Request(name="F1", positive="down")).sticks[0][:, 2]
    array([-1500., -1600.])
    """
    return sticks_from(path, _parts(path, request), request)


def read_charisma_sticks(path: Path, request: Request) -> FaultSticks:
    """
    Read the sticks of a fault from a Charisma file.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `name`: Which fault, if there are several; else the name of the fault.
        `positive`, `length_unit`: As for `read_sticks`.

    Returns
    -------
    FaultSticks

    Raises
    ------
    FormatError, InputError
        As `read_sticks`.
    """
    parts = _by_label(path, read_charisma(path))
    return sticks_from(path, parts, request)


def sticks_from(path: Path, parts: list[Part], request: Request) -> FaultSticks:
    """Sticks of the one fault that is meant."""
    title, sticks = chosen(path, [(one.name, one) for one in parts], request.name, "faults")
    title = request.name or title or path.stem
    what = f"{path.name}: fault {title!r}"
    scale = request.scale(what)
    for i, stick in enumerate(sticks):
        if len(stick.points) < 2:
            raise FormatError(
                f"{path}, line {stick.line}: stick {i} (counted from 0) has 1 point, expected at "
                "least 2. Delete the point, or add another to its stick."
            )
    noted("lines", f"{len(sticks)} with {sum(len(stick.points) for stick in sticks)} points")
    return FaultSticks(title, tuple(_elevated(stick.points, scale) for stick in sticks))


def read_polylines(path: Path, request: Request) -> list[np.ndarray]:
    r"""
    Read polygons or lines: 999-terminated text, or csv with a ``POLY_ID`` column.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `positive`: May be left out only where all z are 0 (outlines drawn on a map).
        `length_unit`: Unit of z (x and y are metres). Default ``"m"``.
        `columns`, `decimal`: Which columns x, y and z are, and the decimal sign, as for points. A
        fourth column has the number of the polyline, a fifth its name.
        `name`: Only the lines of this name.

    Returns
    -------
    list of ndarray of float64, each (n, 3)
        Easting, northing, elevation [m].

    Raises
    ------
    FormatError
        If a line is not three numbers, or the last polygon is not ended.
    InputError
        If `positive` is missing while some z is not 0, or `length_unit` is unknown.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "outline.pol"
    >>> _ = file.write_text("0 0 0\n9 0 0\n9 9 0\n999 999 999\n")
    >>> [len(line) for line in read_polylines(file, Request())]
    [3]
    """
    return polylines_from(path, _parts(path, request), request)


def polylines_from(path: Path, parts: list[Part], request: Request) -> list[np.ndarray]:
    """Lines of one name, or all, as elevations."""
    check_name(path, (part.name for part in parts), request.name)
    lines = [part.points for part in parts if request.name in (None, part.name)]
    noted("lines", f"{len(lines)} with {sum(map(len, lines))} points")

    # polygons in a plane need no direction: their z is 0
    if request.positive is None and not any(line[:, 2].any() for line in lines):
        return lines
    what = f"{path.name}: polygons"
    scale = request.scale(what)
    return [_elevated(line, scale) for line in lines]


def _parts(path: Path, request: Request) -> list[Part]:
    """Polylines as they stand in the file."""
    # csv has a column of labels; other text has one, or end marks
    return parts_of(path, read_table(path, request.columns, request.decimal, (LABELS, NAMES)))


def parts_of(path: Path, table: Table) -> list[Part]:
    """Polylines of a table, by their numbers or between end marks."""
    labelled = path.suffix.lower() == ".csv" or table.labels is not None
    return _by_label(path, table) if labelled else _terminated(path, table)


def _elevated(line: np.ndarray, scale: float) -> np.ndarray:
    """Return x, y and scaled z; plain 0 rather than -0."""
    return line * [1.0, 1.0, scale] + 0.0


def _terminated(path: Path, table: Table) -> list[Part]:
    """Polylines that end marks separate."""
    points, lines = table.points, table.lines

    # the mark in all three columns; a file cut short lacks the last one
    ends = np.flatnonzero((points == END_MARK).all(axis=1))
    if len(ends) == 0 and path.suffix.lower() != ".pol":
        raise FormatError(
            f"{path}: no line '999 999 999' ends a polyline, and no column numbers them, so the "
            "polyline of each point is unknown. Read points with read_points, or add such lines."
        )
    if len(ends) == 0 or ends[-1] != len(points) - 1:
        last = " ".join(f"{value:.12g}" for value in points[-1])
        warn_of_end(path, int(lines[-1]), last, "line 999 999 999")
        ends = np.append(ends, len(points))

    # each polyline begins after the end mark before it
    starts = np.concatenate([[0], ends[:-1] + 1])
    # two end marks in a row enclose nothing and mean nothing
    parts = [
        Part(points[start:end], int(lines[start]), _name(table, start))
        for start, end in zip(starts.tolist(), ends.tolist(), strict=True)
        if end > start
    ]
    if not parts:
        raise FormatError(f"{path}: the file has end marks only, expected x y z on each line.")
    return parts


def _name(table: Table, row: int) -> str:
    """Name of the fault of one point, or nothing."""
    return table.names[row] if table.names is not None else ""


def _by_label(path: Path, table: Table) -> list[Part]:
    """Points of a table, split where the number of the polyline or the name changes."""
    points, labels, lines = table.points, table.labels, table.lines
    if labels is None:
        raise InputError(
            f"{path}, line 1: the column POLY_ID (or STICK_ID) is missing, so the polyline of "
            "each point is unknown. Add the column, or read the file with read_points."
        )
    # faults may count their sticks from 1 each
    if table.names is not None:
        labels = [f"{one} {other}" for one, other in zip(table.names, labels, strict=True)]

    # polylines by runs of equal labels, in the order of the file
    breaks = [0, *(i for i in range(1, len(labels)) if labels[i] != labels[i - 1]), len(labels)]
    pieces = [
        Part(points[a:b], int(lines[a]), _name(table, a)) for a, b in itertools.pairwise(breaks)
    ]
    firsts = [labels[a] for a in breaks[:-1]]

    # A label that comes again would join two lines without order.
    begun: set[str] = set()
    for k, first in enumerate(firsts):
        if first in begun:
            raise FormatError(
                f"{path}, line {lines[breaks[k]]}: polyline {first!r} continues after another "
                "one began. Sort the file by that column."
            )
        begun.add(first)
    return pieces
