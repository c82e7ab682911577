"""Readers of gridded horizons: each turns one format into a DataArray.

===============  ==================================================================
__init__.py      `GridHeader` and `grid_array`: what all of them return; what text formats share
text_grids.py    ESRI text, GXF, CPS-3, ZMAP+
binary_grids.py  IRAP classic and binary, STORM, Surfer 6 and 7
node_lists.py    a node on each line: seismic grids (IJXYZ), EarthVision
===============  ==================================================================
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from geosurf.errors import FormatError
from geosurf.lazy import xarray as xr
from geosurf.read._common import Request, TextBlocks, block_numbers, noted, piece_numbers
from geosurf.read._guard import damaged

# ---- text ----------------------------------------
# What readers of gridded formats share: values in bulk, counts, headers of keys, the result.


def text_values(
    blocks: TextBlocks, header: GridHeader, prepare: Callable[[str], str] = str
) -> np.ndarray:
    """
    All words of a text as one value for each node.

    Parameters
    ----------
    blocks : TextBlocks
        Without the header.
    header : GridHeader
    prepare : callable, optional
        Gets each piece of the text, and returns what is read of it.

    Returns
    -------
    ndarray of float64, shape (ncol * nrow,)
    """

    def take(piece: str, line: int) -> np.ndarray:
        """Values of a piece."""
        return piece_numbers(prepare(piece), blocks.path, line, "value of a node")

    values, n = block_numbers(blocks, header.ncol * header.nrow, take)
    check_count(blocks.path, n, header)
    return values


def check_count(path: Path, count: float, header: GridHeader) -> None:
    """Refuse a file with more or fewer values than its header announces."""
    expected = header.ncol * header.nrow
    if count != expected:
        raise damaged(
            f"{path}: found {count:g} values, expected {expected} ({header.ncol} columns x "
            f"{header.nrow} rows)"
        )


def binary_values(path: Path, data: bytes, dtype: str, header: GridHeader) -> np.ndarray:
    """Return the bytes behind a header as one float64 for each node; NaN is refused."""
    check_count(path, len(data) / np.dtype(dtype).itemsize, header)
    values = np.frombuffer(data, dtype=dtype).astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        row, column = divmod(int(bad[0]), header.ncol)
        raise damaged(
            f"{path}: node (row {row}, column {column}) is {values[bad[0]]}, expected a finite "
            "number or the null value of the format"
        )
    return values


def check_step(path: Path, header: GridHeader, xinc: float, yinc: float, where: str) -> None:
    """Refuse a stated step that differs from the one that the corners give."""
    for key, stated, derived in (("x", xinc, header.xinc), ("y", yinc, header.yinc)):
        # a header with few digits rounds its step; over the whole grid that is below half a cell
        if abs(abs(stated) - abs(derived)) * max(header.ncol, header.nrow) > 0.5 * abs(derived):
            raise FormatError(
                f"{path}, {where}: the step in {key} is {stated:g}, but the corners and counts "
                f"give {derived:g}. Correct the header or export the file again."
            )


def from_corners(
    path: Path, where: str, shape: tuple[int, int], x: tuple[float, float], y: tuple[float, float]
) -> GridHeader:
    """Header of a grid from (ncol, nrow) and the first and last node in x and y."""
    ncol, nrow = shape
    if ncol < 2 or nrow < 2:
        raise damaged(f"{path}, {where}: {ncol} columns x {nrow} rows, expected at least 2 of each")
    header = GridHeader(
        ncol, nrow, x[0], y[0], (x[1] - x[0]) / (ncol - 1), (y[1] - y[0]) / (nrow - 1)
    )
    return header.checked(path, where)


@dataclass(frozen=True)
class Decoded:
    """What the file of a regular grid holds.

    Attributes
    ----------
    header : GridHeader
    values : ndarray of float64, shape (nrow, ncol)
        Rows from the origin on, in the unit and direction of the file; NaN where undefined.
    order : str
        Order of the values in the file, for `geosurf.info`.
    crs, unit : str or None
        Reference system and unit of the values, where the file states them.
    """

    header: GridHeader
    values: np.ndarray
    order: str
    crs: str | None = None
    unit: str | None = None


def grid_reader(decode: Callable[[Path], Decoded]) -> Callable[[Path, Request], xr.DataArray]:
    """
    Make a reader of horizons from what decodes the files of one format.

    The reader takes a path and a `Request` with the name of the horizon, `positive`, which no such
    format states, and `length_unit`: unit of the values (z only; x and y are metres), default
    ``"m"``. It returns elevations [m], positive up, NaN where undefined, and raises a FormatError
    if the header is incomplete, or values are missing, too many or not finite; an InputError if
    `positive` is missing or `length_unit` unknown. Coordinates have one dimension if the grid is
    not rotated, else two.
    """

    @functools.wraps(decode)
    def read(path: Path, request: Request) -> xr.DataArray:
        what = f"{path.name}: horizon {request.named(path)!r}"
        request.scale(what)  # what the caller has to state is missed before the file is read
        decoded = decode(path)
        noted("order of values", decoded.order)
        # in place, as maps are large; adding 0 makes -0 to 0
        values = np.require(decoded.values, np.float64, ["W"])
        values *= request.scale(what, unit=decoded.unit)
        values += 0.0
        header, values = decoded.header.upright(values)
        noted("rotation", f"{header.rotation:g} degrees counter-clockwise from east")
        noted("nodes", f"{header.ncol} columns x {header.nrow} rows")
        noted("steps", f"{decoded.header.xinc:g} x {decoded.header.yinc:g} m")
        grid = grid_array(np.ascontiguousarray(values), *header.places(), request.named(path), path)

        # The header stays in the attributes, so that a grid can be written as it was read.
        for key in ("rotation", "xori", "yori", "xinc", "yinc", "ncol", "nrow"):
            grid.attrs[key] = getattr(header, key)
        if decoded.crs is not None:
            grid.attrs["crs"] = decoded.crs
        return grid

    return read


# what a header may claim before we refuse to allocate for it
MAX_NODES = 2**31


@dataclass(frozen=True)
class GridHeader:
    """Where the nodes of a regular grid are.

    Node ``(row, column)`` lies at the origin, plus ``column * xinc`` along
    `rotation`, plus ``row * yinc`` along `rotation` + 90 degrees.

    Attributes
    ----------
    ncol, nrow : int
    xori, yori, xinc, yinc : float
        [m]; increments may be negative in a file.
    rotation : float
        Degrees, counter-clockwise from east.
    """

    ncol: int
    nrow: int
    xori: float
    yori: float
    xinc: float
    yinc: float
    rotation: float = 0.0

    def checked(self, path: Path, where: str) -> GridHeader:
        """Return self, or raise an error that names the impossible header value."""
        for key in ("ncol", "nrow"):
            if getattr(self, key) < 1:
                raise damaged(
                    f"{path}, {where}: {key} is {getattr(self, key)}, expected at least 1"
                )

        # checked before arrays are made: a damaged header may ask for any amount of memory
        if self.ncol * self.nrow > MAX_NODES:
            raise FormatError(
                f"{path}, {where}: {self.ncol} x {self.nrow} nodes, expected fewer than "
                f"{MAX_NODES}. The header is damaged, or the byte order is wrong."
            )
        for key in ("xori", "yori", "xinc", "yinc", "rotation"):
            value = getattr(self, key)
            if not math.isfinite(value) or (key in ("xinc", "yinc") and value == 0.0):
                raise damaged(
                    f"{path}, {where}: {key} is {value}, expected a finite "
                    f"number{' other than 0' if key in ('xinc', 'yinc') else ''}"
                )
        return self

    def axes(self) -> tuple[np.ndarray, np.ndarray]:
        """Unit vectors of columns and rows, exact for quarter turns."""
        # Quarter turns are exact, so that such grids have straight axes.
        turn = self.rotation % 360.0
        quarter = {0.0: (1.0, 0.0), 90.0: (0.0, 1.0), 180.0: (-1.0, 0.0), 270.0: (0.0, -1.0)}
        cos, sin = quarter.get(turn, (math.cos(math.radians(turn)), math.sin(math.radians(turn))))
        return np.array([cos, sin]), np.array([-sin, cos])

    def places(self) -> tuple[np.ndarray, np.ndarray]:
        """Easting and northing of columns and rows, or of all nodes where the grid is rotated."""
        column, row = np.arange(self.ncol, dtype=np.float64), np.arange(self.nrow, dtype=np.float64)
        step_x, step_y = column * self.xinc, row * self.yinc
        if self.rotation % 360.0 == 0.0:
            return self.xori + step_x, self.yori + step_y
        # along the turned easting axis, and across it
        along, across = self.axes()
        step_y = step_y[:, None]
        x = self.xori + (step_x * along[0] + step_y * across[0])
        return x, self.yori + (step_x * along[1] + step_y * across[1])

    def upright(self, values: np.ndarray) -> tuple[GridHeader, np.ndarray]:
        """Return the same nodes with both increments positive, so right-handed."""
        # A negative step runs from the other end: move the origin there and reverse the array.
        along, across = self.axes()
        x, y = self.xori, self.yori
        xinc, yinc = self.xinc, self.yinc
        if xinc < 0:
            x, y = np.array([x, y]) + (self.ncol - 1) * xinc * along
            values, xinc = values[:, ::-1], -xinc
        if yinc < 0:
            x, y = np.array([x, y]) + (self.nrow - 1) * yinc * across
            values, yinc = values[::-1, :], -yinc
        return replace(self, xori=float(x), yori=float(y), xinc=xinc, yinc=yinc), values


METRE = {"units": "m"}


def grid_array(
    values: np.ndarray, easting: np.ndarray, northing: np.ndarray, name: str, path: Path
) -> xr.DataArray:
    """Elevations [m] of nodes (row, column), with one coordinate for each axis or each node."""
    axes = ("northing", "easting") if easting.ndim == 1 else ("row", "column")
    dims = (axes[:1], axes[1:]) if easting.ndim == 1 else (axes, axes)
    coords = {"northing": (dims[0], northing, METRE), "easting": (dims[1], easting, METRE)}
    attrs = {"units": "m", "positive": "up", "long_name": name, "source": path.name}
    return xr.DataArray(values, dims=axes, coords=coords, name=name, attrs=attrs)


def nodes_from_places(
    nodes: np.ndarray, name: str, path: Path, crs: str | None = None
) -> xr.DataArray:
    """Return a grid of which each node (n_row, n_column, 3) has its own place [m].

    Coordinates have one dimension where rows run east and columns north, else two.
    """
    # columns, rows and up are right-handed, as in all grids
    along, across = np.diff(nodes, axis=1)[:-1], np.diff(nodes, axis=0)[:, :-1]
    turn = along[..., 0] * across[..., 1] - along[..., 1] * across[..., 0]
    if np.nansum(turn) < 0:
        nodes = nodes[::-1]
    x, y, z = (np.ascontiguousarray(nodes[..., k]) for k in range(3))
    if min(z.shape) and (x == x[:1]).all() and (y == y[:, :1]).all():
        east, north = x[0], y[:, 0]
        if (np.diff(east) > 0).all() and (np.diff(north) > 0).all():
            x, y = east, north
    grid = grid_array(z, x, y, name, path)
    return grid if crs is None else grid.assign_attrs(crs=crs)
