"""Grids in text or binary: IRAP classic and binary, STORM, Surfer 6 and 7, GeoTIFF."""

from __future__ import annotations

import itertools
import math
import re
import struct
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions.crs import label, refuse_other_units
from geosurf.conventions.machine import need
from geosurf.errors import FormatError
from geosurf.read._common import TextBlocks, integer, noted, number
from geosurf.read._guard import damaged, opened, read_bytes, read_some, reading_with, refuse_large
from geosurf.read.grids import (
    Decoded,
    GridHeader,
    binary_values,
    check_step,
    from_corners,
    grid_reader,
    text_values,
)

# ---- irap ----------------------------------------
# IRAP grids, classic (text) and binary: the map formats of RMS.
#
# Both headers hold the same: ``-996 nrow xinc yinc``, ``xmin xmax ymin ymax``,
# ``ncol rotation xrot yrot`` and seven zeros (the binary one has the increments last in
# its first record). Mind that the number of rows comes second and that of columns
# ninth. Values run along x fastest. Neither states whether it holds elevation or
# depth, nor in which unit.


UNDEFINED_CLASSIC = 9999900.0
UNDEFINED_BINARY = 9.9e29  # 1e30 as float32, and all above
MARK = -996
N_HEADER = 19  # values of the header of a text file
# the three header records: length in bytes, then the fields
HEADER_RECORDS = (">ii6f", ">i3f", ">7i")


@grid_reader
def read_irap(path: Path) -> Decoded:
    r"""
    Read an IRAP grid, classic or binary, whichever the content is.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from geosurf import read_horizon
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.irap"
    >>> header = "-996 2 10 10\n0 10 0 10\n2 0 0 0\n0 0 0 0 0 0 0\n"
    >>> _ = file.write_text(header + "1 2\n3 9999900.0\n")
    >>> read_horizon(file, positive="down").values
    array([[-1., -2.],
           [-3., nan]])
    """
    # Both kinds share suffixes, so the first bytes decide.
    with opened(path) as (file, _):
        classic = read_some(path, file, 64).lstrip().startswith(b"-996")
    header, values = _read_classic(path) if classic else _read_binary(path)
    noted("kind", "IRAP classic (text)" if classic else "IRAP binary (float32)")
    noted("null", f"{UNDEFINED_CLASSIC:g}" if classic else "1e30")
    return Decoded(header, values, "rows from the origin, each along the rotation")


def _read_classic(path: Path) -> tuple[GridHeader, np.ndarray]:
    """Header and values (nrow, ncol) of a text file, NaN where undefined."""
    blocks = TextBlocks(path)
    text = blocks.head

    # only the header's words one by one: the nodes are millions, and are taken in bulk
    words = list(itertools.islice(re.finditer(r"\S+", text), N_HEADER))
    if len(words) < N_HEADER:
        raise damaged(
            f"{path}: found {len(words)} header values, expected 19 (-996 nrow xinc yinc ...)"
        )

    # lines of the header's words, for errors only
    tokens = [word[0] for word in words]
    line_of_token = [text.count("\n", 0, word.start()) + 1 for word in words]

    def whole(i: int, what: str) -> int:
        """Header value i as a whole number."""
        return integer(tokens[i], path, line_of_token[i], what)

    def real(i: int, what: str) -> float:
        """Header value i as a number."""
        return number(tokens[i], path, line_of_token[i], what)

    whole(0, "-996")
    # Order of the file: -996 nrow xinc yinc / xmin xmax ymin ymax / ncol rotation xrot yrot.
    header = GridHeader(
        ncol=whole(8, "number of columns"),
        nrow=whole(1, "number of rows"),
        xori=real(4, "xmin"),
        yori=real(6, "ymin"),
        xinc=real(2, "xinc"),
        yinc=real(3, "yinc"),
        rotation=real(9, "rotation"),
    ).checked(path, "header")
    _refuse_pivot(path, header, real(10, "xrot"), real(11, "yrot"))
    for i in range(12, 19):
        whole(i, "the last header line, seven zeros")

    # all that follows are values, wherever lines end
    blocks.skip(words[-1].end())
    values = text_values(blocks, header)
    values[values == UNDEFINED_CLASSIC] = np.nan
    return header, values.reshape(header.nrow, header.ncol)


def _read_binary(path: Path) -> tuple[GridHeader, np.ndarray]:
    """Header and values (nrow, ncol) of a binary file, NaN where undefined."""
    records = _fortran_records(path, read_bytes(path))
    if len(records) < 3:
        raise damaged(
            f"{path}: found {len(records)} records, expected 3 header records and the values"
        )

    # Big-endian records of fixed lengths: six floats hold limits and steps.
    fields = []
    for i, layout in enumerate(HEADER_RECORDS):
        if len(records[i]) != struct.calcsize(layout):
            raise FormatError(
                f"{path}: header record {i + 1} has {len(records[i])} bytes, expected "
                f"{struct.calcsize(layout)}. This is not an IRAP binary grid."
            )
        fields.append(struct.unpack(layout, records[i]))

    # the upper limits are not used: they follow from origin, steps and numbers
    (mark, nrow, xmin, _, ymin, _, xinc, yinc), (ncol, rotation, xrot, yrot) = fields[:2]
    if mark != MARK:
        raise FormatError(
            f"{path}, byte 4: found {mark}, expected {MARK}. This is not an IRAP binary grid."
        )

    header = GridHeader(ncol, nrow, xmin, ymin, xinc, yinc, rotation).checked(path, "header")
    _refuse_pivot(path, header, xrot, yrot)
    # The nodes are float32, row by row from the south, in records of any length.
    values = binary_values(path, b"".join(records[3:]), ">f4", header)
    values[values >= UNDEFINED_BINARY] = np.nan
    return header, values.reshape(nrow, ncol)


def _fortran_records(path: Path, data: bytes) -> list[bytes]:
    """Split big-endian Fortran records: length, payload, length again."""
    records, at = [], 0
    # Each Fortran record has its length in bytes before and after it.
    while at < len(data):
        if at + 4 > len(data):
            raise damaged(f"{path}, byte {at}: the file ends inside a record length")

        # the same number has to stand at both ends, or this is no record
        size = struct.unpack_from(">i", data, at)[0]
        end = at + 4 + size
        if size < 0 or end + 4 > len(data) or struct.unpack_from(">i", data, end)[0] != size:
            what = "This is not an IRAP grid" if at == 0 else "The file is damaged or truncated"
            raise FormatError(
                f"{path}, byte {at}: found a record length of {size}, expected the same length "
                f"after that many bytes ({len(data) - at - 4} are left). {what}; export it "
                "again, or set the right format=."
            )
        records.append(data[at + 4 : end])
        at = end + 4
    return records


def _refuse_pivot(path: Path, header: GridHeader, xrot: float, yrot: float) -> None:
    """Refuse a rotation about another point than the origin: programs disagree on it."""
    # A pivot other than the origin would move the whole grid; a thousandth of a cell is rounding.
    slack = 1e-3 * (abs(header.xinc) + abs(header.yinc))
    off = abs(xrot - header.xori) > slack or abs(yrot - header.yori) > slack
    if header.rotation % 360.0 and off:
        raise FormatError(
            f"{path}, header: rotated by {header.rotation} degrees about ({xrot}, {yrot}), "
            f"expected about the origin ({header.xori}, {header.yori}). Set xrot and yrot to the "
            "origin of the rotated grid."
        )


# ---- storm ----------------------------------------
# STORM grids: a header in text, then float64 in big-endian order, or values in text.
#
# The header is ``STORMGRID_BINARY`` (or ``STORMGRID_ASCII``), columns, rows, steps in x and y, then
# xmin, xmax, ymin, ymax. Values run along x fastest, from the south-west corner. Undefined is -999.
# The format knows no rotation.


HEAD = re.compile(rb"\s*STORMGRID_(BINARY|ASCII)" + rb"\s+([^\s]+)" * 8 + rb"[ \t]*\r?\n")
UNDEFINED = -999.0


@grid_reader
def read_storm(path: Path) -> Decoded:
    r"""
    Read a STORM grid, binary or text.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from geosurf import read_horizon
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.storm"
    >>> _ = file.write_text("STORMGRID_ASCII\n\n2 2 10 20\n0 10 0 20\n1 2\n3 -999\n")
    >>> read_horizon(file, positive="up").values
    array([[ 1.,  2.],
           [ 3., nan]])
    """
    data = read_bytes(path)
    match = HEAD.match(data)
    if match is None:
        raise damaged(
            f"{path}: the first bytes are {data[:16]!r}, expected STORMGRID_BINARY or "
            "STORMGRID_ASCII and eight numbers"
        )
    # lines of a header of nine words serve for messages only
    words = [word.decode("latin-1") for word in match.groups()[1:]]
    ncol, nrow = (integer(word, path, 3, "number of columns or rows") for word in words[:2])
    dx, dy, x0, x1, y0, y1 = (number(word, path, 4, "step or limit") for word in words[2:])
    header = from_corners(path, "header", (ncol, nrow), (x0, x1), (y0, y1))
    check_step(path, header, dx, dy, "header")

    if match[1] == b"BINARY":
        values = binary_values(path, data[match.end() :], ">f8", header)
    else:
        blocks = TextBlocks(path)
        rest = blocks.head.split("\n", match[0].count(b"\n"))[-1]
        blocks.skip(len(blocks.head) - len(rest))
        values = text_values(blocks, header)
    noted("null", f"{UNDEFINED:g}")
    values[values == UNDEFINED] = np.nan
    grid = values.reshape(nrow, ncol)
    return Decoded(header, grid, "rows from the south, each from the west")


# ---- surfer ----------------------------------------
# Surfer grids: version 6 in text (``DSAA``) and binary (``DSBB``), version 7 (``DSRB``).
#
# All of them hold rows of a map from south to north, each from west to east. Nodes without a value
# hold 1.70141e38. Version 7 consists of sections, each a tag and a length before its bytes.


BLANK = 1.70141e38  # and above
HEAD_6 = "<4s2h6d"
HEAD_7 = "<2i8d"


@grid_reader
def read_surfer(path: Path) -> Decoded:
    r"""
    Read a Surfer grid: version 6, text or binary, or version 7.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from geosurf import read_horizon
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.grd"
    >>> _ = file.write_text("DSAA\n2 2\n0 10\n0 20\n1 3\n1 2\n3 1.70141e38\n")
    >>> read_horizon(file, positive="up").values
    array([[ 1.,  2.],
           [ 3., nan]])
    """
    data = read_bytes(path)
    kinds = {b"DSAA": _text, b"DSBB": _version_6, b"DSRB": _version_7}
    if data[:4] not in kinds:
        raise FormatError(
            f"{path}: the first bytes are {data[:4]!r}, expected DSAA, DSBB or DSRB. This is not "
            "a Surfer grid."
        )
    noted("kind", f"Surfer {'7' if data[:4] == b'DSRB' else '6'} ({data[:4].decode()})")
    header, values, blank = kinds[data[:4]](path, data)
    noted("null", f"{blank:g} and above")
    values[values >= blank] = np.nan
    grid = values.reshape(header.nrow, header.ncol)
    return Decoded(header, grid, "rows from the south, each from the west")


def _text(path: Path, _: bytes) -> tuple[GridHeader, np.ndarray, float]:
    """Header, values and blank value of a text."""
    blocks = TextBlocks(path)
    lines = blocks.head.split("\n", 5)
    rows = [line.split() for line in lines[1:5]]
    if len(lines) < 6 or any(len(row) != 2 for row in rows):
        raise damaged(
            f"{path}, lines 2 to 5: expected two values on each (columns and rows, limits of x, y "
            "and z)"
        )
    ncol, nrow = (integer(word, path, 2, "number of columns or rows") for word in rows[0])
    x0, x1 = (number(word, path, 3, "limit of x") for word in rows[1])
    y0, y1 = (number(word, path, 4, "limit of y") for word in rows[2])
    header = from_corners(path, "header", (ncol, nrow), (x0, x1), (y0, y1))
    blocks.skip(len(blocks.head) - len(lines[5]))
    return header, text_values(blocks, header), BLANK


def _version_6(path: Path, data: bytes) -> tuple[GridHeader, np.ndarray, float]:
    """Header, values and blank value of a binary file of version 6."""
    size = struct.calcsize(HEAD_6)
    if len(data) < size:
        raise damaged(f"{path}: found {len(data)} bytes, expected a header of {size}")
    _, ncol, nrow, x0, x1, y0, y1, _, _ = struct.unpack_from(HEAD_6, data)
    header = from_corners(path, "header", (ncol, nrow), (x0, x1), (y0, y1))
    return header, binary_values(path, data[size:], "<f4", header), float(np.float32(BLANK))


def _version_7(path: Path, data: bytes) -> tuple[GridHeader, np.ndarray, float]:
    """Header, values and blank value of a file of version 7."""
    parts: dict[bytes, bytes] = {}
    at = 0
    while at < len(data):
        tag, size = data[at : at + 4], int.from_bytes(data[at + 4 : at + 8], "little")
        if at + 8 + size > len(data):
            raise damaged(
                f"{path}, byte {at}: section {tag!r} announces {size} bytes, but "
                f"{max(0, len(data) - at - 8)} are left"
            )
        parts.setdefault(tag, data[at + 8 : at + 8 + size])
        at += 8 + size

    head = parts.get(b"GRID", b"")
    if len(head) < struct.calcsize(HEAD_7) or b"DATA" not in parts:
        raise damaged(
            f"{path}: the sections are {sorted(parts)}, expected a complete GRID and DATA among "
            "them"
        )
    nrow, ncol, x0, y0, dx, dy, _, _, rotation, blank = struct.unpack_from(HEAD_7, head)
    if rotation:
        raise FormatError(
            f"{path}: the grid is rotated by {rotation:g} degrees, and Surfer does not define "
            "about which point. Export it without rotation, or as IRAP classic."
        )
    header = GridHeader(ncol, nrow, x0, y0, dx, dy).checked(path, "section GRID")
    return header, binary_values(path, parts[b"DATA"], "<f8", header), blank


# ---- geotiff ----------------------------------------
# GeoTIFF through rasterio: one band of values, placed by an affine map, with its system.
#
# Nodes of the horizon are the centres of cells. Rotated maps are read; sheared ones and those that
# ground control points place are refused. The reference system, the null value, masks, scale and
# offset of the band count; overviews do not.


STRAIGHT = 1e-9  # cosine of the angle between rows and columns that is a right one, to rounding
UNITS = ("m", "metre", "meter", "metres", "meters", "ft", "foot", "feet", "km")


@grid_reader
def read_geotiff(path: Path) -> Decoded:
    """Read a GeoTIFF of one band."""
    data = read_bytes(path)
    need(f"{path}: GeoTIFF needs", "rasterio")
    import rasterio

    with (
        warnings.catch_warnings(),
        reading_with(path, "rasterio"),
        rasterio.MemoryFile(data) as memory,
        memory.open(driver="GTiff") as source,
    ):
        warnings.simplefilter("ignore")  # a map without a place is refused here
        header = _header(path, source)
        cells = header.ncol * header.nrow
        refuse_large(path, 24 * cells, len(data), f"a map of {header.ncol} x {header.nrow} cells")
        values = _values(path, source)
        unit = (source.units[0] or "").strip().lower()
        crs = _crs(path, source)
    noted("kind", "nodes are the centres of cells")
    if crs is not None:
        noted("crs", label(crs))
    order = "rows from the first corner of the file"
    return Decoded(header, values, order, crs=crs, unit=unit if unit in UNITS else None)


def _header(path: Path, source: Any) -> GridHeader:
    """Where the centres of cells are."""
    if source.count != 1:
        raise FormatError(
            f"{path}: the GeoTIFF has {source.count} bands, expected 1 of elevations or depths. "
            "Export that band alone."
        )
    place = source.transform
    if place.is_identity:
        raise FormatError(
            f"{path}: the TIFF states no place (or places cells by control points). Export it with "
            "an affine map, as in gdalwarp."
        )
    # a column goes along (a, d), a row along (b, e); a right angle is needed
    xinc, yinc = math.hypot(place.a, place.d), math.hypot(place.b, place.e)
    bent = abs(place.a * place.b + place.d * place.e) > STRAIGHT * xinc * yinc
    if bent or not xinc or not yinc:
        raise FormatError(
            f"{path}: rows and columns of the GeoTIFF are not at right angles. Warp it to a "
            "regular grid, as in gdalwarp."
        )
    x, y = place @ (0.5, 0.5) if hasattr(place, "__matmul__") else place * (0.5, 0.5)
    if place.b == 0.0 and place.d == 0.0:
        header = GridHeader(source.width, source.height, x, y, place.a, place.e)
    else:
        left = place.a * place.e - place.b * place.d > 0.0  # rows to the left of columns
        turn = math.degrees(math.atan2(place.d, place.a)) % 360.0
        header = GridHeader(source.width, source.height, x, y, xinc, yinc if left else -yinc, turn)
    return header.checked(path, "header")


def _values(path: Path, source: Any) -> np.ndarray:
    """Values (row, column) in the order of the file, NaN where undefined."""
    band = source.read(1, masked=True)
    if band.dtype.kind not in "iuf":
        raise FormatError(f"{path}: values are {band.dtype}, expected real numbers.")
    values: np.ndarray = np.ma.filled(band.astype(np.float64), np.nan)
    noted("null", "none stated" if source.nodata is None else f"{source.nodata:g}")
    if np.isinf(values).any():
        raise damaged(f"{path}: {np.isinf(values).sum()} values are infinite")
    scale, offset = source.scales[0], source.offsets[0]
    if (scale, offset) != (1.0, 0.0):
        noted("transform", f"{scale:g} x value + {offset:g}")
        values = values * scale + offset
    return values


def _crs(path: Path, source: Any) -> str | None:
    """The reference system, as a code where it has one."""
    if source.crs is None or not source.crs.to_wkt():
        return None
    code = source.crs.to_epsg()
    text = f"EPSG:{code}" if code else str(source.crs.to_wkt())
    refuse_other_units(str(source.crs.to_wkt()), str(path))
    return text
