"""Grids as lists of nodes, one on each line: seismic grids (IJXYZ) and EarthVision."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.errors import FormatError
from geosurf.lazy import xarray as xr
from geosurf.read._common import Request, integer, noted, number, number_text, read_text
from geosurf.read._guard import damaged, refuse_large
from geosurf.read._table import words_per_line
from geosurf.read.grids import Decoded, GridHeader, from_corners, grid_array, grid_reader

# ---- ijxyz ----------------------------------------
# Seismic grids in text: inline, crossline, x, y, z on each line, in any order of lines.
#
# OpendTect, OpenWorks, Petrel and RMS export horizons so (IJXYZ). Comments begin with ``#``,
# ``!`` or ``@``; a header of words is ignored, as are the words ``INLINE :`` and ``XLINE :`` of
# Charisma. Undefined nodes are absent. That the columns are these is not guessed: x and y of all
# lines have to be the same linear function of the two line numbers.


IGNORED = re.compile(r"^[ \t]*[#!@].*|^[^\d\n]*$|\b(?:in|x|cross)line\b[ \t]*:?", re.M | re.I)
WIDTH = 5
FEWEST = 3  # lines that show a plane
SLACK = 0.01  # of a step: rounding of x and y in the text
UNDEFINED = 9999900.0  # and above

LINE = re.compile(
    rb"\s*[+-]?\d+(?:\.0*)?\s+[+-]?\d+(?:\.0*)?(?:\s+[+-]?[\d.]+(?:[eE][+-]?\d+)?){3}\s*\Z"
)


def looks_like_ijxyz(head: bytes) -> bool:
    """Return whether all lines of a beginning have two whole numbers and three numbers."""
    text = IGNORED.sub("", head.decode("latin-1").replace("\r\n", "\n"))
    # the last line may be cut where the beginning ends
    lines = [line.encode("latin-1") for line in text.split("\n")[:-1] if line.strip()]
    return len(lines) >= FEWEST and all(LINE.match(line) for line in lines)


def read_ijxyz(path: Path, request: Request) -> xr.DataArray:
    r"""
    Read a grid of inlines and crosslines.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `name`: Name of the horizon.
        `positive`: The format does not state it, so this argument is required.
        `length_unit`: Unit of the values (z only; x and y are metres). Default ``"m"``.

    Returns
    -------
    xarray.DataArray
        Elevation [m], positive up, NaN at nodes that are absent. Easting and northing of nodes with
        a value are those of the text; others follow from the line numbers.

    Raises
    ------
    FormatError
        If a line has other than five numbers, a node occurs twice, or x and y do not follow from
        the line numbers.
    InputError
        If `positive` is missing or `length_unit` unknown.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.dat"
    >>> _ = file.write_text("10 7 0 0 1\n12 7 5 0 2\n10 8 0 9 3\n")
    >>> top = read_ijxyz(file, Request(name="Top", positive="up"))
    >>> top.values.tolist(), top.coords["easting"].values.tolist()
    ([[1.0, 2.0], [3.0, nan]], [0.0, 5.0])
    """
    scale = request.scale(f"{path.name}: horizon {request.named(path)!r}")
    text = read_text(path)
    # most files hold numbers only: looking for words in them takes longer than reading them
    words = bool(text.encode().translate(None, b"0123456789+-.eE \t\n"))
    count = words_per_line(text)
    if words or ((count != 0) & (count != WIDTH)).any():
        text = IGNORED.sub("", text)
        count = words_per_line(text)
    wrong = np.flatnonzero((count != 0) & (count != WIDTH))
    if len(wrong):
        raise FormatError(
            f"{path}, line {wrong[0] + 1}: found {count[wrong[0]]} values, expected inline, "
            "crossline, x, y, z. Correct that line, or read the file with read_points and columns=."
        )
    table = number_text(text, path, 1, "inline, crossline, x, y or z").reshape(-1, WIDTH)
    index, steps = _indices(path, table[:, :2])
    corner, along = _fitted(path, index, table[:, 2:4])

    # columns, rows and up are right-handed: the two directions change places where they are not
    first = 0 if along[0, 0] * along[1, 1] > along[0, 1] * along[1, 0] else 1
    column, row = index[:, first], index[:, 1 - first]
    shape = (int(row.max()) + 1, int(column.max()) + 1)
    refuse_large(path, 40 * shape[0] * shape[1], len(text), f"a grid of {shape[1]} x {shape[0]}")
    seen = np.zeros(shape, dtype=bool)
    seen[row, column] = True
    if seen.sum() < len(row):
        raise FormatError(
            f"{path}: {len(row) - seen.sum()} nodes occur more than once. Read the file with "
            "read_points(columns=(3, 4, 5)) and pass it to tear_horizon."
        )

    i, j = np.arange(shape[1])[None, :, None], np.arange(shape[0])[:, None, None]
    places = corner + i * along[first] + j * along[1 - first]
    places[row, column] = table[:, 2:4]
    values = np.full(shape, np.nan)
    values[row, column] = np.where(table[:, 4] >= UNDEFINED, np.nan, table[:, 4])
    _note(along, first, shape, steps)
    return _nodes(places, scale * values + 0.0, (row, column), request.named(path), path)


def _indices(path: Path, numbers: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """Positions (n, 2) of nodes from 0 by their line numbers, and the steps of these."""
    whole = np.floor(numbers) == numbers
    if not whole.all() or np.abs(numbers).max() > 2**31:
        raise FormatError(
            f"{path}: inlines and crosslines are not whole numbers. Read the file with read_points "
            "and columns=(3, 4, 5)."
        )
    lines = numbers.astype(np.int64)
    lines -= lines.min(axis=0)
    steps = [int(np.gcd.reduce(lines[:, k])) for k in range(2)]
    if 0 in steps:
        raise FormatError(
            f"{path}: all nodes lie on one line, expected a grid. Read the file with read_points "
            "and columns=(3, 4, 5)."
        )
    return lines // steps, steps


def _fitted(path: Path, index: np.ndarray, xy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corner (2,) and the steps of x and y (2, 2) by position, which all nodes have to follow."""
    # relative to the mean, so that products of large coordinates do not lose digits
    middle, centre = index.mean(axis=0), xy.mean(axis=0)
    along, _, rank, _ = np.linalg.lstsq(index - middle, xy - centre, rcond=None)
    off = np.abs((index - middle) @ along + centre - xy).max(axis=1)
    step = np.hypot(along[:, 0], along[:, 1]).min()
    k = int(np.argmax(off))
    if rank < 2 or off[k] > SLACK * step:
        raise FormatError(
            f"{path}: node {k + 1} lies at ({xy[k, 0]:g}, {xy[k, 1]:g}), {off[k]:.3g} m from the "
            "place that its two line numbers give. If columns 3 to 5 are x, y, z, read the file "
            "with read_points and columns=(3, 4, 5)."
        )
    noted("fit", f"x and y follow from inline and crossline within {off[k]:.2g} m")
    return centre - middle @ along, along


def _note(along: np.ndarray, first: int, shape: tuple[int, int], steps: list[int]) -> None:
    """Notes for `geosurf.info`."""
    noted("columns", "inline, crossline, easting, northing, z are columns 1, 2, 3, 4, 5")
    noted("nodes", f"{shape[1]} columns x {shape[0]} rows; inline step {steps[0]}, "
          f"crossline step {steps[1]}")  # fmt: skip
    size = np.hypot(along[:, 0], along[:, 1])
    noted("steps", f"{size[0]:g} m per inline step, {size[1]:g} m per crossline step")
    turn = np.degrees(np.arctan2(along[first, 1], along[first, 0]))
    noted("rotation", f"{turn:.6g} degrees counter-clockwise from east")
    noted("null", "absent lines, 9999900 and above")


def _nodes(
    places: np.ndarray, elevation: np.ndarray, at: tuple[Any, Any], name: str, path: Path
) -> xr.DataArray:
    """Nodes with one coordinate per axis where the text has straight axes, else one per node."""
    # straight axes: all nodes of a column have the very same x, those of a row the same y
    x, y = np.full(elevation.shape[1], np.nan), np.full(elevation.shape[0], np.nan)
    x[at[1]], y[at[0]] = places[at][:, 0], places[at][:, 1]
    straight = (x[at[1]] == places[at][:, 0]).all() and (y[at[0]] == places[at][:, 1]).all()
    if not straight or not (np.diff(x) > 0).all() or not (np.diff(y) > 0).all():
        x, y = places[..., 0].copy(), places[..., 1].copy()
    return grid_array(elevation, x, y, name, path)


# ---- earthvision ----------------------------------------
# EarthVision grids (text): one node per line, with its column and row; undefined ones are absent.
#
# The geometry stands in comments: ``# Grid_size: 5 x 4`` (columns x rows) and ``# Grid_space:
# xmin, xmax, ymin, ymax``. ``# Field: 1 x`` names the columns of the lines. Columns and rows
# count from 1.


SIZE = re.compile(r"^#\s*Grid_size:\s*(\S+)\s*x\s*(\S+)", re.MULTILINE | re.IGNORECASE)
SPACE = re.compile(r"^#\s*Grid_space:\s*([^\n]*)", re.MULTILINE | re.IGNORECASE)
FIELD = re.compile(r"^#\s*Field:\s*(\d{1,2})\s+(\S+)", re.MULTILINE | re.IGNORECASE)
COMMENT = re.compile(r"^[ \t]*#[^\n]*\n", re.MULTILINE)
NEEDED = ("x", "y", "z", "column", "row")


@grid_reader
def read_earthvision(path: Path) -> Decoded:
    r"""
    Read an EarthVision grid.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from geosurf import read_horizon
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.dat"
    >>> head = "# Type: scattered data\n# Grid_size: 2 x 2\n# Grid_space: 0,10,0,20\n# End:\n"
    >>> _ = file.write_text(head + "0 0 1 1 1\n10 0 2 2 1\n0 20 3 1 2\n")
    >>> read_horizon(file, positive="up").values
    array([[ 1.,  2.],
           [ 3., nan]])
    """
    text = read_text(path)
    header = _geometry(path, text)
    refuse_large(path, 24 * header.ncol * header.nrow, len(text), f"{header.ncol} x {header.nrow}")
    places = _places(path, text)

    # comments become empty lines, so that lines keep their numbers
    values = number_text(COMMENT.sub("\n", text), path, 1, "x, y, z, column or row")
    width = max(len(FIELD.findall(text)), len(NEEDED))
    if len(values) % width:
        raise damaged(f"{path}: found {len(values)} values, expected {width} on each line")
    x, y, z, column, row = (values.reshape(-1, width)[:, k] for k in places)
    grid = _placed(path, header, (column, row), (x, y), z)
    noted("columns", f"x, y, z, column, row are columns {[k + 1 for k in places]}")
    noted("null", "absent lines, 1e20 and above")
    return Decoded(header, grid, "by the column and row of each line")


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
        raise damaged(
            f"{path}, line {k}: Grid_space has {len(words)} values, expected xmin,xmax,ymin,ymax"
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
            raise damaged(
                f"{path}: node {k + 1} has column {column[k]:g} and row {row[k]:g}, which is "
                f"{what} of {header.ncol} x {header.nrow} nodes"
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
        raise damaged(f"{path}: {len(number_of) - seen.sum()} nodes occur twice")
    grid = np.full(header.ncol * header.nrow, np.nan)
    grid[number_of] = np.where(z >= 1e20, np.nan, z)
    return grid.reshape(header.nrow, header.ncol)
