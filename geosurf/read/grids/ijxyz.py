"""Seismic grids in text: inline, crossline, x, y, z on each line, in any order of lines.

OpendTect, OpenWorks, Petrel and RMS export horizons so (IJXYZ). Comments begin with ``#``, ``!`` or
``@``; a header of words is ignored, as are the words ``INLINE :`` and ``XLINE :`` of Charisma.
Undefined nodes are absent. That the columns are these is not guessed: x and y of all lines have to
be the same linear function of the two line numbers.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.errors import FormatError
from geosurf.read._common import number_text, read_text
from geosurf.read._guard import refuse_large
from geosurf.read._noted import noted
from geosurf.read._table import words_per_line
from geosurf.read.grids.nodes import Axis, GridNodes
from geosurf.read.grids.text import scale_of

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


def read_ijxyz(
    path: Path, *, name: str, positive: str | None = None, length_unit: str | None = None
) -> GridNodes:
    r"""
    Read a grid of inlines and crosslines.

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
    >>> top = read_ijxyz(file, name="Top", positive="up")
    >>> top.values.tolist(), top.coords["easting"].values.tolist()
    ([[1.0, 2.0], [3.0, nan]], [0.0, 5.0])
    """
    scale = scale_of(path, name, positive, length_unit)
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
    return _nodes(places, scale * values + 0.0, (row, column), name, path.name)


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
    places: np.ndarray, elevation: np.ndarray, at: tuple[Any, Any], name: str, source: str
) -> GridNodes:
    """Nodes with one coordinate per axis where the text has straight axes, else one per node."""
    metre = {"units": "m"}
    attrs = {"units": "m", "positive": "up", "long_name": name, "source": source}
    dims: tuple[str, str] = ("northing", "easting")

    # straight axes: all nodes of a column have the very same x, those of a row the same y
    x, y = np.full(elevation.shape[1], np.nan), np.full(elevation.shape[0], np.nan)
    x[at[1]], y[at[0]] = places[at][:, 0], places[at][:, 1]
    straight = (x[at[1]] == places[at][:, 0]).all() and (y[at[0]] == places[at][:, 1]).all()
    if straight and (np.diff(x) > 0).all() and (np.diff(y) > 0).all():
        coords = {"northing": Axis(y, dims[:1], metre), "easting": Axis(x, dims[1:], metre)}
        return GridNodes(elevation, dims, coords, name, attrs)
    dims = ("row", "column")
    coords = {
        "easting": Axis(places[..., 0].copy(), dims, metre),
        "northing": Axis(places[..., 1].copy(), dims, metre),
    }
    return GridNodes(elevation, dims, coords, name, attrs)
