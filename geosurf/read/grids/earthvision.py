"""EarthVision grids (text): one node per line, with its column and row; undefined ones are absent.

The geometry stands in comments: ``# Grid_size: 5 x 4`` (columns x rows) and ``# Grid_space: xmin,
xmax, ymin, ymax``. ``# Field: 1 x`` names the columns of the lines. Columns and rows count from 1.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from geosurf.errors import FormatError
from geosurf.read._common import integer, number, number_text, read_text
from geosurf.read._guard import refuse_large
from geosurf.read._noted import noted
from geosurf.read.grids.nodes import GridHeader, GridNodes
from geosurf.read.grids.text import finished, from_corners, scale_of

SIZE = re.compile(r"^#\s*Grid_size:\s*(\S+)\s*x\s*(\S+)", re.MULTILINE | re.IGNORECASE)
SPACE = re.compile(r"^#\s*Grid_space:\s*([^\n]*)", re.MULTILINE | re.IGNORECASE)
FIELD = re.compile(r"^#\s*Field:\s*(\d{1,2})\s+(\S+)", re.MULTILINE | re.IGNORECASE)
COMMENT = re.compile(r"^[ \t]*#[^\n]*\n", re.MULTILINE)
NEEDED = ("x", "y", "z", "column", "row")


def read_earthvision(
    path: Path, *, name: str, positive: str | None = None, length_unit: str | None = None
) -> GridNodes:
    r"""
    Read an EarthVision grid.

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
        Elevation [m], positive up, NaN at nodes that are absent, shape (nrow, ncol).

    Raises
    ------
    FormatError
        If the header is incomplete, a node lies elsewhere than the header puts it, occurs twice
        or lies outside the grid.
    InputError
        If `positive` is missing or `length_unit` unknown.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.dat"
    >>> head = "# Type: scattered data\n# Grid_size: 2 x 2\n# Grid_space: 0,10,0,20\n# End:\n"
    >>> _ = file.write_text(head + "0 0 1 1 1\n10 0 2 2 1\n0 20 3 1 2\n")
    >>> read_earthvision(file, name="Top", positive="up").values
    array([[ 1.,  2.],
           [ 3., nan]])
    """
    scale = scale_of(path, name, positive, length_unit)
    text = read_text(path)
    header = _geometry(path, text)
    refuse_large(path, 24 * header.ncol * header.nrow, len(text), f"{header.ncol} x {header.nrow}")
    places = _places(path, text)

    # comments become empty lines, so that lines keep their numbers
    values = number_text(COMMENT.sub("\n", text), path, 1, "x, y, z, column or row")
    width = max(len(FIELD.findall(text)), len(NEEDED))
    if len(values) % width:
        raise FormatError(
            f"{path}: found {len(values)} values, expected {width} on each line. The file is "
            "truncated; export it again."
        )
    x, y, z, column, row = (values.reshape(-1, width)[:, k] for k in places)
    grid = _placed(path, header, (column, row), (x, y), z)
    noted("columns", f"x, y, z, column, row are columns {[k + 1 for k in places]}")
    noted("null", "absent lines, 1e20 and above")
    return finished(path, name, header, grid, scale, "by the column and row of each line")


def _geometry(path: Path, text: str) -> GridHeader:
    """Nodes by the comments of the header."""
    size, space = SIZE.search(text), SPACE.search(text)
    if size is None or space is None:
        raise FormatError(
            f"{path}: the comments have no 'Grid_size:' and 'Grid_space:'. Read the file with "
            "read_points, or export it as an EarthVision grid."
        )
    i, k = (text.count("\n", 0, match.start()) + 1 for match in (size, space))
    shape = (integer(size[1], path, i, "columns"), integer(size[2], path, i, "rows"))
    words = space[1].replace(",", " ").split()
    if len(words) != 4:
        raise FormatError(
            f"{path}, line {k}: Grid_space has {len(words)} values, expected xmin,xmax,ymin,ymax."
            " Correct that line or export the file again."
        )
    x0, x1, y0, y1 = (number(word, path, k, "Grid_space") for word in words)
    return from_corners(path, f"lines {i} and {k}", shape, (x0, x1), (y0, y1))


def _places(path: Path, text: str) -> list[int]:
    """Columns of x, y, z, column and row on each line, from 0."""
    fields = {word.lower(): int(i) - 1 for i, word in FIELD.findall(text)}
    if not fields:
        return list(range(len(NEEDED)))
    absent = [word for word in NEEDED if word not in fields]
    if absent or sorted(fields.values()) != list(range(len(fields))):
        raise FormatError(
            f"{path}: the fields are {list(fields)}, expected {', '.join(NEEDED)} among them. "
            "Export the file as an EarthVision grid, with columns and rows."
        )
    return [fields[word] for word in NEEDED]


def _placed(
    path: Path,
    header: GridHeader,
    at: tuple[np.ndarray, np.ndarray],
    xy: tuple[np.ndarray, np.ndarray],
    z: np.ndarray,
) -> np.ndarray:
    """Values (nrow, ncol) by columns and rows from 1, NaN elsewhere."""
    column, row = at
    inside = (column >= 1) & (column <= header.ncol) & (row >= 1) & (row <= header.nrow)
    whole = (column == np.floor(column)) & (row == np.floor(row))
    for good, what in ((inside, "outside the grid"), (whole, "between nodes")):
        if not good.all():
            k = int(np.argmin(good))
            raise FormatError(
                f"{path}: node {k + 1} has column {column[k]:g} and row {row[k]:g}, which is "
                f"{what} of {header.ncol} x {header.nrow} nodes. Export the file again."
            )

    # x and y repeat what the header states; a grid that was rotated contradicts it
    off_x = np.abs(header.xori + (column - 1) * header.xinc - xy[0])
    off_y = np.abs(header.yori + (row - 1) * header.yinc - xy[1])
    off = np.maximum(off_x / abs(header.xinc), off_y / abs(header.yinc))
    if len(off) and off.max() > 0.01:
        k = int(np.argmax(off))
        raise FormatError(
            f"{path}: node (column {column[k]:g}, row {row[k]:g}) lies at ({xy[0][k]:g}, "
            f"{xy[1][k]:g}), {max(off_x[k], off_y[k]):g} m from where Grid_space puts it. Correct "
            "Grid_space, or export the grid without rotation."
        )
    number_of = (row.astype(np.int64) - 1) * header.ncol + column.astype(np.int64) - 1
    seen = np.zeros(header.ncol * header.nrow, dtype=bool)
    seen[number_of] = True
    if seen.sum() < len(number_of):
        raise FormatError(
            f"{path}: {len(number_of) - seen.sum()} nodes occur twice. Export the file again."
        )
    grid = np.full(header.ncol * header.nrow, np.nan)
    grid[number_of] = np.where(z >= 1e20, np.nan, z)
    return grid.reshape(header.nrow, header.ncol)
