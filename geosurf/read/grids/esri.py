"""ESRI grids in text: rows of a map from north to south, each from west to east.

``xllcorner`` and ``yllcorner`` are the corner of the lowest left cell, ``xllcenter`` and
``yllcenter`` its centre. Nodes of the horizon are the centres of cells. A file ``.prj`` of the same
name states the coordinate reference system.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from geosurf.errors import FormatError
from geosurf.read._blocks import TextBlocks
from geosurf.read._common import integer, number
from geosurf.read._noted import noted
from geosurf.read._prj import crs_of_prj
from geosurf.read.grids.nodes import GridHeader, GridNodes
from geosurf.read.grids.text import finished, scale_of, text_values

LINE = re.compile(r"[ \t]*([A-Za-z_]+)[ \t]+(\S+)[ \t]*\n")
NULL = "-9999"  # where the header states none


def read_esri(
    path: Path, *, name: str, positive: str | None = None, length_unit: str | None = None
) -> GridNodes:
    r"""
    Read an ESRI grid in text.

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
        Elevation [m] at the centres of cells, positive up, NaN where undefined.

    Raises
    ------
    FormatError
        If the header is incomplete, or values are missing, too many or not numbers.
    InputError
        If `positive` is missing or `length_unit` unknown.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.asc"
    >>> head = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 10\nNODATA_value -9999\n"
    >>> _ = file.write_text(head + "1 2\n3 -9999\n")
    >>> top = read_esri(file, name="Top", positive="up")
    >>> top.values.tolist(), top.coords["easting"].values.tolist()
    ([[3.0, nan], [1.0, 2.0]], [5.0, 15.0])
    """
    scale = scale_of(path, name, positive, length_unit)
    blocks = TextBlocks(path)

    # keys come in any case and order; values begin at the first line that is no key
    found: dict[str, tuple[int, str]] = {}
    start = 0
    while match := LINE.match(blocks.head, start):
        found[match[1].lower()] = (len(found) + 1, match[2])
        start = match.end()

    def word(*keys: str) -> tuple[int, str]:
        """Line and value of the one key that the header has."""
        present = [key for key in keys if key in found]
        if len(present) != 1:
            raise FormatError(
                f"{path}: the header has {len(present)} of {', '.join(keys)}, expected 1. "
                "Correct the header of the ESRI grid or export the file again."
            )
        return found[present[0]]

    def real(*keys: str) -> float:
        """Value of a key as a number."""
        i, value = word(*keys)
        return number(value, path, i, keys[0])

    ncol, nrow = (integer(word(key)[1], path, word(key)[0], key) for key in ("ncols", "nrows"))
    dx, dy = (real("cellsize", key) for key in ("dx", "dy"))
    # a corner lies half a cell from the centre of its cell
    half_x = 0.5 * dx if "xllcorner" in found else 0.0
    half_y = 0.5 * dy if "yllcorner" in found else 0.0
    x0 = real("xllcorner", "xllcenter") + half_x
    y0 = real("yllcorner", "yllcenter") + half_y
    header = GridHeader(ncol, nrow, x0, y0, dx, dy).checked(path, "header")

    i, null = found.get("nodata_value", (0, NULL))
    noted("null", null)
    noted("kind", "nodes are the centres of cells")
    blocks.skip(start)
    values = text_values(blocks, header)
    values[values == number(null, path, i, "NODATA_value")] = np.nan
    grid = values.reshape(nrow, ncol)[::-1]
    nodes = finished(path, name, header, grid, scale, "rows from the north, each from the west")
    if (crs := crs_of_prj(path)) is not None:
        nodes.attrs["crs"] = crs
    return nodes
