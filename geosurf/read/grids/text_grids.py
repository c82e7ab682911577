"""Grids in text: ESRI, GXF, CPS-3 and ZMAP+."""

from __future__ import annotations

import itertools
import re
import sys
from pathlib import Path

import numpy as np

from geosurf.conventions.checks import HUGE, NO_DATA
from geosurf.errors import FormatError
from geosurf.read._common import TextBlocks, integer, is_number, noted, number
from geosurf.read._guard import damaged
from geosurf.read._placed import crs_of_prj
from geosurf.read._table import words_per_line
from geosurf.read.grids import (
    Decoded,
    GridHeader,
    check_step,
    from_corners,
    grid_reader,
    text_values,
)

# ---- esri ----------------------------------------
# ESRI grids in text: rows of a map from north to south, each from west to east.
#
# ``xllcorner`` and ``yllcorner`` are the corner of the lowest left cell, ``xllcenter`` and
# ``yllcenter`` its centre. Nodes of the horizon are the centres of cells. A file ``.prj`` of the
# same name states the coordinate reference system.


LINE = re.compile(r"[ \t]*([A-Za-z_]+)[ \t]+(\S+)[ \t]*\n")
NAN = re.compile(r"[+-]?\bnan\b", re.IGNORECASE)
ESRI_NULL = "-9999"  # where the header states none


@grid_reader
def read_esri(path: Path) -> Decoded:
    r"""
    Read an ESRI grid in text.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from geosurf import read_horizon
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.asc"
    >>> head = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 10\nNODATA_value -9999\n"
    >>> _ = file.write_text(head + "1 2\n3 -9999\n")
    >>> top = read_horizon(file, positive="up")
    >>> top.values.tolist(), top.coords["easting"].values.tolist()
    ([[3.0, nan], [1.0, 2.0]], [5.0, 15.0])
    """
    blocks = TextBlocks(path)

    # keys come in any case and order; values begin at the first line that is no key
    keys_read: dict[str, tuple[int, str]] = {}
    start = 0
    while match := LINE.match(blocks.head, start):
        keys_read[match[1].lower()] = (len(keys_read) + 1, match[2])
        start = match.end()

    def word(*keys: str) -> tuple[int, str]:
        """Line and value of the one key that the header has."""
        present = [key for key in keys if key in keys_read]
        if len(present) != 1:
            raise FormatError(
                f"{path}: the header has {len(present)} of {', '.join(keys)}, expected 1. "
                "Correct the header of the ESRI grid or export the file again."
            )
        return keys_read[present[0]]

    def real(*keys: str) -> float:
        """Value of a key as a number."""
        i, value = word(*keys)
        return number(value, path, i, keys[0])

    ncol, nrow = (integer(word(key)[1], path, word(key)[0], key) for key in ("ncols", "nrows"))
    dx, dy = (real("cellsize", key) for key in ("dx", "dy"))
    # a corner lies half a cell from the centre of its cell
    half_x = 0.5 * dx if "xllcorner" in keys_read else 0.0
    half_y = 0.5 * dy if "yllcorner" in keys_read else 0.0
    x0 = real("xllcorner", "xllcenter") + half_x
    y0 = real("yllcorner", "yllcenter") + half_y
    header = GridHeader(ncol, nrow, x0, y0, dx, dy).checked(path, "header")

    i, null = keys_read.get("nodata_value", (0, ESRI_NULL))
    noted("null", null)
    noted("kind", "nodes are the centres of cells")
    blocks.skip(start)
    if NAN.fullmatch(null):  # as GDAL writes it; elsewhere the word is an error
        null = repr(sys.float_info.max)
        values = text_values(blocks, header, lambda piece: NAN.sub(null, piece))
    else:
        values = text_values(blocks, header)
    values[values == number(null, path, i, "NODATA_value")] = np.nan
    grid = values.reshape(nrow, ncol)[::-1]
    order = "rows from the north, each from the west"
    return Decoded(header, grid, order, crs=crs_of_prj(path))


# ---- gxf ----------------------------------------
# GXF grids (Grid eXchange Format, version 3) in text.
#
# Each key is a line that begins with ``#``; its value stands on the line after it. ``#GRID`` comes
# last, and values follow it row by row. ``#SENSE`` states where the first row begins and where it
# goes; only rows that run east (1 and -2) are read. ``#ROTATION`` is counter-clockwise, about the
# origin. Values are multiplied and shifted by ``#TRANSFORM``.


GRID = re.compile(r"^[ \t]*#GRID[^\n]*\n", re.MULTILINE | re.IGNORECASE)
SENSES = {1: 1, -2: -1}  # rows from the south, from the north

Keys = dict[str, tuple[int, str]]


@grid_reader
def read_gxf(path: Path) -> Decoded:
    r"""
    Read a GXF grid.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from geosurf import read_horizon
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.gxf"
    >>> head = "#POINTS\n2\n#ROWS\n2\n#PTSEPARATION\n10\n#RWSEPARATION\n20\n#DUMMY\n-99\n"
    >>> _ = file.write_text(head + "#GRID\n1 2\n3 -99\n")
    >>> read_horizon(file, positive="up").values
    array([[ 1.,  2.],
           [ 3., nan]])
    """
    blocks = TextBlocks(path)
    start = GRID.search(blocks.head)
    if start is None:
        raise damaged(f"{path}: the file has no line #GRID")
    keys = _keys(blocks.head[: start.start()])
    header = _geometry(path, keys)
    if _real(path, keys, "GTYPE", 0.0):
        raise FormatError(
            f"{path}, line {keys['GTYPE'][0]}: #GTYPE is {keys['GTYPE'][1]}, so the values are "
            "compressed. Export the grid uncompressed (#GTYPE 0)."
        )
    sense = _real(path, keys, "SENSE", 1.0)
    if sense not in SENSES:
        raise FormatError(
            f"{path}, line {keys['SENSE'][0]}: #SENSE is {sense:g}, expected 1 or -2 (rows that "
            "run east). Export the grid with #SENSE 1."
        )

    blocks.skip(start.end())
    values = text_values(blocks, header)
    # the dummy value counts before the transform
    if "DUMMY" in keys:
        noted("null", keys["DUMMY"][1])
        values[values == _real(path, keys, "DUMMY", 0.0)] = np.nan
    factor, shift = _pair(path, keys)
    if (factor, shift) != (1.0, 0.0):
        noted("transform", f"{factor:g} x value + {shift:g}")
        values = factor * values + shift
    rows = SENSES[int(sense)]
    order = f"rows from the {'south' if rows > 0 else 'north'}, each from the west"
    grid = values.reshape(header.nrow, header.ncol)[::rows]
    return Decoded(header, grid, order)


def _keys(head: str) -> Keys:
    """Line and value of each key of the header."""
    keys: Keys = {}
    key = ""
    for i, line in enumerate(head.split("\n"), start=1):
        words = line.strip()
        if words.startswith("#"):
            key = words[1:].split()[0].upper() if words[1:].split() else ""
        elif words and key and not words.startswith("!"):
            quoted = re.fullmatch(r'"([^",]*)"', words)
            keys.setdefault(key, (i, quoted[1].strip() if quoted else words))
    return keys


def _real(path: Path, keys: Keys, key: str, default: float | None = None) -> float:
    """Value of a key as a number."""
    if key not in keys and default is not None:
        return default
    if key not in keys:
        raise damaged(f"{path}: the header has no #{key}")
    i, text = keys[key]
    return number(text.split()[0], path, i, f"#{key}")


def _pair(path: Path, keys: Keys) -> tuple[float, float]:
    """Factor and shift of ``#TRANSFORM``."""
    if "TRANSFORM" not in keys:
        return 1.0, 0.0
    i, text = keys["TRANSFORM"]
    words = [*text.replace(",", " ").split(), "0"]
    return number(words[0], path, i, "#TRANSFORM"), number(words[1], path, i, "#TRANSFORM")


def _geometry(path: Path, keys: Keys) -> GridHeader:
    """Nodes in metres; ``#UNIT_LENGTH`` is a name and the metres of one unit."""
    ncol, nrow = (
        integer(keys.get(key, (0, ""))[1], path, keys.get(key, (0, ""))[0], f"#{key}")
        for key in ("POINTS", "ROWS")
    )
    metres = 1.0
    if "UNIT_LENGTH" in keys:
        i, text = keys["UNIT_LENGTH"]
        words = text.replace('"', "").split(",")
        metres = number(words[1].strip(), path, i, "#UNIT_LENGTH") if len(words) > 1 else 1.0
        noted("unit of x and y", text)
    if "MAP_PROJECTION" in keys:
        noted("crs", keys["MAP_PROJECTION"][1].strip('"'))

    x, y = (_real(path, keys, key, 0.0) for key in ("XORIGIN", "YORIGIN"))
    dx, dy = (_real(path, keys, key, 1.0) for key in ("PTSEPARATION", "RWSEPARATION"))
    turn = _real(path, keys, "ROTATION", 0.0)
    return GridHeader(ncol, nrow, x * metres, y * metres, dx * metres, dy * metres, turn).checked(
        path, "header"
    )


# ---- cps3 ----------------------------------------
# CPS-3 grids (text): columns of a map, west to east, each from north to south.
#
# Lines of the header begin with ``FSASCI`` (null value), ``FSLIMI`` (west, east, south, north,
# lowest, highest), ``FSNROW`` (rows, columns) and ``FSXINC`` (steps); values follow a line ``->``.
# The format knows no rotation.


CPS3_NULL = 1e30  # where the header states none

Lines = dict[str, tuple[int, list[str]]]


@grid_reader
def read_cps3(path: Path) -> Decoded:
    r"""
    Read a CPS-3 grid in text.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from geosurf import read_horizon
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.cps3"
    >>> head = "FSASCI 0 1 COMPUTED 0 1.0E30 0\nFSLIMI 0 10 0 20 1 6\nFSNROW 2 2\nFSXINC 10 20\n"
    >>> _ = file.write_text(head + "-> MODEL\n1 2\n3 1.0E30\n")
    >>> read_horizon(file, positive="up").values
    array([[ 2., nan],
           [ 1.,  3.]])
    """
    blocks = TextBlocks(path)
    lines, start = _cps3_header(path, blocks.head)

    # rows first, then columns; limits are those of the outer nodes
    i, words = _line(path, lines, "FSNROW", 2)
    nrow, ncol = (integer(word, path, i, "number of rows or columns") for word in words[:2])
    k, words = _line(path, lines, "FSLIMI", 4)
    west, east, south, north = (number(word, path, k, "limit of x or y") for word in words[:4])
    header = from_corners(path, f"lines {i} and {k}", (ncol, nrow), (west, east), (south, north))
    if "FSXINC" in lines:
        i, words = _line(path, lines, "FSXINC", 2)
        steps = [number(word, path, i, "step") for word in words[:2]]
        check_step(path, header, steps[0], steps[1], f"line {i}")

    # the null value is the one number of the first line that is a usual mark
    _, words = lines.get("FSASCI", (0, []))
    sizes = {word: abs(float(word)) for word in words if is_number(word)}
    nulls = [float(word) for word, size in sizes.items() if size >= HUGE or size in NO_DATA]
    null = nulls[0] if nulls else CPS3_NULL
    noted("null", f"{null:g}")

    blocks.skip(start)
    counts: list[np.ndarray] = []  # of values, line by line

    def counted(piece: str) -> str:
        counts.append(words_per_line(piece))
        return piece

    values = text_values(blocks, header, counted)
    _refuse_rows(path, header, np.concatenate(counts))
    values[values == null] = np.nan
    grid = values.reshape(header.ncol, header.nrow).T[::-1]
    return Decoded(header, grid, "columns from the west, each from the north")


def _refuse_rows(path: Path, header: GridHeader, count: np.ndarray) -> None:
    """Refuse values that begin a new line with each row of the map, not with each column.

    Some programs write rows, and do not agree whether the first is in the north or in the south.
    """
    nrow, ncol = header.nrow, header.ncol
    ends = np.cumsum(count[count > 0])
    by_rows, by_columns = (np.count_nonzero(ends % size == 0) for size in (ncol, nrow))
    if nrow != ncol and by_rows == nrow and by_columns < ncol:
        raise FormatError(
            f"{path}: a new line begins after every {ncol} values, so they run along rows. "
            "CPS-3 has columns from the north. Export the grid as IRAP or ZMAP+."
        )


def _cps3_header(path: Path, text: str) -> tuple[Lines, int]:
    """Lines of the header by their first word, and where values begin."""
    lines: Lines = {}
    at = 0
    for i, line in enumerate(text.split("\n", 100)[:100], start=1):
        words = line.replace(",", " ").split()
        key = words[0].upper() if words else "!"

        # `-> name` is the last line of the header; some programs leave it out
        if key.startswith("->"):
            return lines, at + len(line) + 1
        if is_number(key):
            return lines, at
        if key.startswith("FS"):
            lines[key] = (i, words[1:])
        at += len(line) + 1
    raise damaged(f"{path}: the header has no values after it")


def _line(path: Path, lines: Lines, key: str, count: int) -> tuple[int, list[str]]:
    """Line and words of one key, at least `count` words."""
    i, words = lines.get(key, (0, []))
    if len(words) < count:
        where = f", line {i}" if i else ""
        raise damaged(f"{path}{where}: {key} has {len(words)} values, expected {count}")
    return i, words


# ---- zmap ----------------------------------------
# ZMAP+ grids (text): columns of a map, west to east, each from north to south.
#
# Comments begin with ``!``. Between two ``@`` stand: field width, null value as a
# number, null value as text, decimals, first column of a field / number of rows and
# columns, west, east, south, north / three numbers nobody uses. The format knows no
# rotation.


SYSTEM = re.compile(r"^![ \t]*CRS:[ \t]*(\S[^\n]*\S)[ \t]*$", re.MULTILINE)  # as geosurf writes it
NULL_WORD = "1e30"  # what a null value that is no number is read as
PASSED_OVER = re.compile(r"^[ \t]*[!+].*", re.MULTILINE)  # comments and extensions


@grid_reader
def read_zmap(path: Path) -> Decoded:
    r"""
    Read a ZMAP+ grid.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from geosurf import read_horizon
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.zmap"
    >>> _ = file.write_text("@top, GRID, 2\n 8, -99, , 1, 1\n"
    ...     " 2, 2, 0, 10, 0, 10\n 0, 0, 0\n@\n 1.0 2.0\n 3.0 -99\n")
    >>> read_horizon(file, positive="up").values
    array([[ 2., nan],
           [ 1.,  3.]])
    """
    blocks = TextBlocks(path)

    # The header lies between two lines that begin with @.
    head = blocks.head
    marks = list(itertools.islice(re.finditer(r"^[ \t]*@", head, re.MULTILINE), 2))
    before, within = (
        PASSED_OVER.sub("", head[: marks[k].start()]) if len(marks) == 2 else "" for k in (0, 1)
    )
    lines = [(i, line) for i, line in enumerate(within.split("\n"), start=1) if line.strip()]
    if before.strip() or len(lines) < 3:
        raise FormatError(
            f"{path}: expected a header of at least two lines between two '@', found "
            f"{len(marks)} '@'. This is not a ZMAP+ grid, or the file is truncated."
        )
    system = SYSTEM.search(head[: marks[0].start()])

    header, nulls, decimals = _zmap_header(path, lines[1], lines[2])

    # values begin on the line after the second @
    blocks.skip((head.find("\n", marks[1].end()) + 1) or len(head))

    # nulls that are words become a number, and numbers are compared when all are there
    has_point, words = False, [null for null in nulls if not is_number(null)]

    def prepared(piece: str) -> str:
        nonlocal has_point
        if "!" in piece or "+" in piece:  # comments among values are rare
            piece = PASSED_OVER.sub("", piece)
        for word in words:
            piece = re.sub(rf"(?<!\S){re.escape(word)}(?!\S)", NULL_WORD, piece)
        if not has_point:
            has_point = any("." in word for word in piece.split() if word not in nulls)
        return piece

    values = text_values(blocks, header, prepared)
    undefined = [float(NULL_WORD if null in words else null) for null in nulls]
    values[np.isin(values, undefined)] = np.nan
    if decimals and not has_point and not np.isnan(values).all():
        # old programs then read 12345 as 1.2345, newer ones do not
        raise FormatError(
            f"{path}, line {lines[1][0]}: the header announces {decimals} decimals, but no "
            "value has a decimal point. Export the file with decimal points."
        )
    noted("null", " or ".join(sorted(nulls)) or "none stated")
    # columns from the north-west corner -> rows from the south-west one
    grid = values.reshape(header.ncol, header.nrow).T[::-1]
    order = "columns from the west, each from the north"
    return Decoded(header, grid, order, crs=None if system is None else system[1])


def _zmap_header(
    path: Path, format_line: tuple[int, str], extent_line: tuple[int, str]
) -> tuple[GridHeader, set[str], int]:
    """Geometry, the words that stand for 'undefined', and the number of decimals."""
    # width, null as number, null as text, decimals, first column of a field
    i, line = format_line
    fields = [field.strip() for field in line.rstrip().rstrip(",").split(",")]
    nulls = {field for field in fields[1:3] if field}
    decimals = integer(fields[3], path, i, "decimals") if len(fields) > 3 and fields[3] else 0

    # nrow, ncol, then west, east, south, north of the outer nodes.
    i, line = extent_line
    fields = [field.strip() for field in line.rstrip().rstrip(",").split(",")]
    if len(fields) != 6:
        raise FormatError(
            f"{path}, line {i}: found {len(fields)} values, expected 6 (rows, columns, west, "
            "east, south, north). This is not a ZMAP+ grid."
        )
    nrow, ncol = (integer(fields[k], path, i, "number of rows or columns") for k in (0, 1))
    west, east, south, north = (number(field, path, i, "extent") for field in fields[2:])
    # steps are not in the file: they follow from the outer nodes
    header = from_corners(path, f"line {i}", (ncol, nrow), (west, east), (south, north))
    return header, nulls, decimals
