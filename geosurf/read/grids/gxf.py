"""GXF grids (Grid eXchange Format, version 3) in text.

Each key is a line that begins with ``#``; its value stands on the line after it. ``#GRID`` comes
last, and values follow it row by row. ``#SENSE`` states where the first row begins and where it
goes; only rows that run east (1 and -2) are read. ``#ROTATION`` is counter-clockwise, about the
origin. Values are multiplied and shifted by ``#TRANSFORM``.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from geosurf.errors import FormatError
from geosurf.read._blocks import TextBlocks
from geosurf.read._common import integer, number
from geosurf.read._noted import noted
from geosurf.read.grids.nodes import GridHeader, GridNodes
from geosurf.read.grids.text import finished, scale_of, text_values

GRID = re.compile(r"^[ \t]*#GRID[^\n]*\n", re.MULTILINE | re.IGNORECASE)
SENSES = {1: 1, -2: -1}  # rows from the south, from the north

Keys = dict[str, tuple[int, str]]


def read_gxf(
    path: Path, *, name: str, positive: str | None = None, length_unit: str | None = None
) -> GridNodes:
    r"""
    Read a GXF grid.

    Parameters
    ----------
    path : pathlib.Path
    name : str
        Name of the horizon.
    positive : {"up", "down"}
        The format does not state it, so this argument is required.
    length_unit : str, optional
        Unit of the values (z only). Default ``"m"``. ``#UNIT_LENGTH`` is that of x and y.

    Returns
    -------
    GridNodes
        Elevation [m], positive up, NaN where undefined, shape (nrow, ncol).

    Raises
    ------
    FormatError
        If the header is incomplete, the grid is compressed or runs in another direction, or
        values are missing, too many or not numbers.
    InputError
        If `positive` is missing or `length_unit` unknown.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.gxf"
    >>> head = "#POINTS\n2\n#ROWS\n2\n#PTSEPARATION\n10\n#RWSEPARATION\n20\n#DUMMY\n-99\n"
    >>> _ = file.write_text(head + "#GRID\n1 2\n3 -99\n")
    >>> read_gxf(file, name="Top", positive="up").values
    array([[ 1.,  2.],
           [ 3., nan]])
    """
    scale = scale_of(path, name, positive, length_unit)
    blocks = TextBlocks(path)
    start = GRID.search(blocks.head)
    if start is None:
        raise FormatError(
            f"{path}: the file has no line #GRID. It is truncated or not a GXF grid; export it "
            "again."
        )
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
    return finished(path, name, header, grid, scale, order)


def _keys(head: str) -> Keys:
    """Line and value of each key of the header."""
    found: Keys = {}
    key = ""
    for i, line in enumerate(head.split("\n"), start=1):
        words = line.strip()
        if words.startswith("#"):
            key = words[1:].split()[0].upper() if words[1:].split() else ""
        elif words and key and not words.startswith("!"):
            found.setdefault(key, (i, words))
    return found


def _real(path: Path, keys: Keys, key: str, default: float | None = None) -> float:
    """Value of a key as a number."""
    if key not in keys and default is not None:
        return default
    if key not in keys:
        raise FormatError(f"{path}: the header has no #{key}. Export the GXF grid again.")
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
