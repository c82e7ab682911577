"""Surfer grids: version 6 in text (``DSAA``) and binary (``DSBB``), version 7 (``DSRB``).

All of them hold rows of a map from south to north, each from west to east. Nodes without a value
hold 1.70141e38. Version 7 consists of sections, each a tag and a length before its bytes.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from geosurf.errors import FormatError
from geosurf.read._blocks import TextBlocks
from geosurf.read._common import integer, number
from geosurf.read._guard import read_bytes
from geosurf.read._noted import noted
from geosurf.read.grids.nodes import GridHeader, GridNodes
from geosurf.read.grids.text import binary_values, finished, from_corners, scale_of, text_values

BLANK = 1.70141e38  # and above
HEAD_6 = "<4s2h6d"
HEAD_7 = "<2i8d"


def read_surfer(
    path: Path, *, name: str, positive: str | None = None, length_unit: str | None = None
) -> GridNodes:
    r"""
    Read a Surfer grid: version 6, text or binary, or version 7.

    Parameters
    ----------
    path : pathlib.Path
    name : str
        Name of the horizon.
    positive : {"up", "down"}
        The format does not state it, so this argument is required.
    length_unit : str, optional
        Unit of the values (z only; x and y are metres). Default ``"m"``.

    Returns
    -------
    GridNodes
        Elevation [m], positive up, NaN where blank, shape (nrow, ncol).

    Raises
    ------
    FormatError
        If the content is no Surfer grid, is cut short, rotated, or holds values that are not
        finite.
    InputError
        If `positive` is missing or `length_unit` unknown.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.grd"
    >>> _ = file.write_text("DSAA\n2 2\n0 10\n0 20\n1 3\n1 2\n3 1.70141e38\n")
    >>> read_surfer(file, name="Top", positive="up").values
    array([[ 1.,  2.],
           [ 3., nan]])
    """
    scale = scale_of(path, name, positive, length_unit)
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
    return finished(path, name, header, grid, scale, "rows from the south, each from the west")


def _text(path: Path, _: bytes) -> tuple[GridHeader, np.ndarray, float]:
    """Header, values and blank value of a text."""
    blocks = TextBlocks(path)
    lines = blocks.head.split("\n", 5)
    rows = [line.split() for line in lines[1:5]]
    if len(lines) < 6 or any(len(row) != 2 for row in rows):
        raise FormatError(
            f"{path}, lines 2 to 5: expected two values on each (columns and rows, limits of x, "
            "y and z). The header of the Surfer grid is incomplete; export the file again."
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
        raise FormatError(
            f"{path}: found {len(data)} bytes, expected a header of {size}. The file is "
            "truncated; export it again."
        )
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
            raise FormatError(
                f"{path}, byte {at}: section {tag!r} announces {size} bytes, but "
                f"{max(0, len(data) - at - 8)} are left. The file is truncated; export it again."
            )
        parts.setdefault(tag, data[at + 8 : at + 8 + size])
        at += 8 + size

    head = parts.get(b"GRID", b"")
    if len(head) < struct.calcsize(HEAD_7) or b"DATA" not in parts:
        raise FormatError(
            f"{path}: the sections are {sorted(parts)}, expected a complete GRID and DATA among "
            "them. Export the file again."
        )
    nrow, ncol, x0, y0, dx, dy, _, _, rotation, blank = struct.unpack_from(HEAD_7, head)
    if rotation:
        raise FormatError(
            f"{path}: the grid is rotated by {rotation:g} degrees, and Surfer does not define "
            "about which point. Export it without rotation, or as IRAP classic."
        )
    header = GridHeader(ncol, nrow, x0, y0, dx, dy).checked(path, "section GRID")
    return header, binary_values(path, parts[b"DATA"], "<f8", header), blank
