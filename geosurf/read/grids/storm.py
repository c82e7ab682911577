"""STORM grids: a header in text, then float64 in big-endian order, or values in text.

The header is ``STORMGRID_BINARY`` (or ``STORMGRID_ASCII``), columns, rows, steps in x and y, then
xmin, xmax, ymin, ymax. Values run along x fastest, from the south-west corner. Undefined is -999.
The format knows no rotation.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from geosurf.errors import FormatError
from geosurf.read._blocks import TextBlocks
from geosurf.read._common import integer, number
from geosurf.read._guard import read_bytes
from geosurf.read._noted import noted
from geosurf.read.grids.nodes import GridNodes
from geosurf.read.grids.text import (
    binary_values,
    check_step,
    finished,
    from_corners,
    scale_of,
    text_values,
)

HEAD = re.compile(rb"\s*STORMGRID_(BINARY|ASCII)" + rb"\s+([^\s]+)" * 8 + rb"[ \t]*\r?\n")
UNDEFINED = -999.0


def read_storm(
    path: Path, *, name: str, positive: str | None = None, length_unit: str | None = None
) -> GridNodes:
    r"""
    Read a STORM grid, binary or text.

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
        Elevation [m], positive up, NaN where undefined, shape (nrow, ncol).

    Raises
    ------
    FormatError
        If the header is incomplete, or values are missing, too many or not finite.
    InputError
        If `positive` is missing or `length_unit` unknown.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.storm"
    >>> _ = file.write_text("STORMGRID_ASCII\n\n2 2 10 20\n0 10 0 20\n1 2\n3 -999\n")
    >>> read_storm(file, name="Top", positive="up").values
    array([[ 1.,  2.],
           [ 3., nan]])
    """
    scale = scale_of(path, name, positive, length_unit)
    data = read_bytes(path)
    match = HEAD.match(data)
    if match is None:
        raise FormatError(
            f"{path}: the first bytes are {data[:16]!r}, expected STORMGRID_BINARY or "
            "STORMGRID_ASCII and eight numbers. The header is incomplete; export the file again."
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
    return finished(path, name, header, grid, scale, "rows from the south, each from the west")
