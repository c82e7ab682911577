"""A regular grid, rotated or not: its header, its nodes, and the one kind of DataArray of them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.errors import FormatError
from geosurf.read._blocks import TextBlocks
from geosurf.read._common import Request, block_numbers, piece_numbers
from geosurf.read._noted import noted

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr


# ---- text ----------------------------------------
# What readers of gridded formats share: values in bulk, counts, headers of keys, the result.


def scale_of(path: Path, request: Request) -> float:
    """Metres of elevation per unit of a file that states neither direction nor unit."""
    what = f"{path.name}: horizon {request.named(path)!r}"
    return request.scale(what)


def text_values(
    blocks: TextBlocks, header: GridHeader, look: Callable[[str], object] | None = None
) -> np.ndarray:
    """
    All words of a text as one value for each node.

    Parameters
    ----------
    blocks : TextBlocks
        Without the header.
    header : GridHeader
    look : callable, optional
        Gets each piece of the text.

    Returns
    -------
    ndarray of float64, shape (ncol * nrow,)
    """

    def take(piece: str, line: int) -> np.ndarray:
        """Values of a piece."""
        if look is not None:
            look(piece)
        return piece_numbers(piece, blocks.path, line, "value of a node")

    values, n = block_numbers(blocks, header.ncol * header.nrow, take)
    check_count(blocks.path, n, header)
    return values


def check_count(path: Path, found: float, header: GridHeader) -> None:
    """Refuse a file with more or fewer values than its header announces."""
    expected = header.ncol * header.nrow
    if found != expected:
        raise FormatError(
            f"{path}: found {found:g} values, expected {expected} ({header.ncol} columns x "
            f"{header.nrow} rows). The file is truncated or its header is wrong; export it "
            "again."
        )


def binary_values(path: Path, data: bytes, dtype: str, header: GridHeader) -> np.ndarray:
    """Return the bytes behind a header as one float64 for each node; NaN is refused."""
    check_count(path, len(data) / np.dtype(dtype).itemsize, header)
    values = np.frombuffer(data, dtype=dtype).astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        row, column = divmod(int(bad[0]), header.ncol)
        raise FormatError(
            f"{path}: node (row {row}, column {column}) is {values[bad[0]]}, expected a finite "
            "number or the null value of the format. Export the file again."
        )
    return values


def check_step(path: Path, header: GridHeader, xinc: float, yinc: float, where: str) -> None:
    """Refuse a stated step that differs from the one that the corners give."""
    for key, stated, found in (("x", xinc, header.xinc), ("y", yinc, header.yinc)):
        # a header with few digits rounds its step; over the whole grid that is below half a cell
        if abs(abs(stated) - abs(found)) * max(header.ncol, header.nrow) > 0.5 * abs(found):
            raise FormatError(
                f"{path}, {where}: the step in {key} is {stated:g}, but the corners and counts "
                f"give {found:g}. Correct the header or export the file again."
            )


def from_corners(
    path: Path, where: str, shape: tuple[int, int], x: tuple[float, float], y: tuple[float, float]
) -> GridHeader:
    """Header of a grid from (ncol, nrow) and the first and last node in x and y."""
    ncol, nrow = shape
    if ncol < 2 or nrow < 2:
        raise FormatError(
            f"{path}, {where}: {ncol} columns x {nrow} rows, expected at least 2 of each. This is "
            "not the header of a grid; export the file again."
        )
    header = GridHeader(
        ncol, nrow, x[0], y[0], (x[1] - x[0]) / (ncol - 1), (y[1] - y[0]) / (nrow - 1)
    )
    return header.checked(path, where)


def finished(
    path: Path, request: Request, header: GridHeader, values: np.ndarray, scale: float, order: str
) -> GridNodes:
    """Nodes of values (nrow, ncol), rows from the origin on; their order and rotation are noted."""
    noted("order of values", order)
    return nodes_from_grid(
        header, scaled(values, scale), name=request.named(path), source=path.name
    )


def scaled(values: np.ndarray, scale: float) -> np.ndarray:
    """Values times a factor, without negative zeros; in place, as maps are large."""
    values = np.require(values, np.float64, ["W"])
    values *= scale
    values += 0.0
    return values


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
                raise FormatError(
                    f"{path}, {where}: {key} is {getattr(self, key)}, expected at least 1. "
                    "This is not the header of a grid; export the file again."
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
                raise FormatError(
                    f"{path}, {where}: {key} is {value}, expected a finite number"
                    f"{' other than 0' if key in ('xinc', 'yinc') else ''}. "
                    "Export the file again."
                )
        return self

    def axes(self) -> tuple[np.ndarray, np.ndarray]:
        """Unit vectors of columns and rows, exact for quarter turns."""
        # Quarter turns are exact, so that such grids have straight axes.
        turn = self.rotation % 360.0
        quarter = {0.0: (1.0, 0.0), 90.0: (0.0, 1.0), 180.0: (-1.0, 0.0), 270.0: (0.0, -1.0)}
        cos, sin = quarter.get(turn, (math.cos(math.radians(turn)), math.sin(math.radians(turn))))
        return np.array([cos, sin]), np.array([-sin, cos])

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


@dataclass(frozen=True, eq=False)
class Axis:
    """A coordinate of `GridNodes`; its attributes are those of one of xarray.

    Attributes
    ----------
    values : ndarray of float64
    dims : tuple of str
    attrs : dict
    """

    values: np.ndarray
    dims: tuple[str, ...]
    attrs: dict[str, str]

    @property
    def ndim(self) -> int:
        """Number of dimensions."""
        return self.values.ndim

    @property
    def dtype(self) -> np.dtype:
        """Type of the values."""
        return self.values.dtype

    def transpose(self, *dims: str) -> Axis:
        """Return the same with dimensions in another order."""
        order = [self.dims.index(dim) for dim in dims]
        return Axis(self.values.transpose(order), dims, self.attrs)


@dataclass(frozen=True, eq=False)
class GridNodes:
    """A grid as a file has it: what `triangulate_horizon` asks a DataArray for, without xarray.

    Importing xarray takes longer than all that is done to a small grid.

    Attributes
    ----------
    values : ndarray of float64, shape (n_row, n_col)
        Elevation [m], NaN where absent.
    dims : (str, str)
    coords : dict of Axis
    name : str
    attrs : dict
    """

    values: np.ndarray
    dims: tuple[str, str]
    coords: dict[str, Axis]
    name: str
    attrs: dict[str, Any]

    @property
    def dtype(self) -> np.dtype:
        """Type of the values."""
        return self.values.dtype

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of rows and columns."""
        return self.values.shape

    def copy(self, deep: bool = True) -> GridNodes:
        """Return the same with arrays of its own."""
        coords = {
            key: replace(axis, values=axis.values.copy()) for key, axis in self.coords.items()
        }
        return replace(self, values=self.values.copy(), coords=coords)

    def to_xarray(self) -> xr.DataArray:
        """Return the same as a DataArray."""
        import xarray as xr

        coords = {key: (axis.dims, axis.values, axis.attrs) for key, axis in self.coords.items()}
        return xr.DataArray(
            self.values, dims=self.dims, coords=coords, name=self.name, attrs=self.attrs
        )


def nodes_from_places(
    nodes: np.ndarray, *, name: str, source: str, crs: str | None = None
) -> GridNodes:
    """Return the nodes of a grid of which each has its own place.

    Parameters
    ----------
    nodes : ndarray of float64, shape (n_row, n_column, 3)
        Easting, northing, elevation [m]; NaN where absent.
    name, source : str
        Name of the horizon, and of the file (without folder).
    crs : str, optional
        Coordinate reference system.

    Returns
    -------
    GridNodes
        With 1-D coordinates where rows run east and columns north, else 2-D ones.
    """
    # columns, rows and up are right-handed, as in all grids
    along, across = np.diff(nodes, axis=1)[:-1], np.diff(nodes, axis=0)[:, :-1]
    turn = along[..., 0] * across[..., 1] - along[..., 1] * across[..., 0]
    if np.nansum(turn) < 0:
        nodes = nodes[::-1]
    x, y, z = (np.ascontiguousarray(nodes[..., k]) for k in range(3))
    dims: tuple[str, str] = ("row", "column")
    metre = {"units": "m"}
    attrs = {"units": "m", "positive": "up", "long_name": name, "source": source}
    if crs is not None:
        attrs["crs"] = crs
    if min(z.shape) and (x == x[:1]).all() and (y == y[:, :1]).all():
        east, north = x[0], y[:, 0]
        if (np.diff(east) > 0).all() and (np.diff(north) > 0).all():
            dims = ("northing", "easting")
            axes = {
                "northing": Axis(north, dims[:1], metre),
                "easting": Axis(east, dims[1:], metre),
            }
            return GridNodes(z, dims, axes, name, attrs)
    places = {"easting": Axis(x, dims, metre), "northing": Axis(y, dims, metre)}
    return GridNodes(z, dims, places, name, attrs)


def nodes_from_grid(
    header: GridHeader, elevation: np.ndarray, *, name: str, source: str
) -> GridNodes:
    """Return the nodes of a grid: 1-D coordinates if unrotated, 2-D if rotated.

    Parameters
    ----------
    header : GridHeader
    elevation : ndarray of float64, shape (nrow, ncol)
        [m], positive up; NaN where absent.
    name, source : str
        Name of the horizon, and of the file (without folder).

    Returns
    -------
    GridNodes
    """
    noted("rotation", f"{header.rotation:g} degrees counter-clockwise from east")
    noted("nodes", f"{header.ncol} columns x {header.nrow} rows")
    noted("steps", f"{header.xinc:g} x {header.yinc:g} m")
    header, elevation = header.upright(elevation)
    attrs: dict[str, Any] = {"units": "m", "positive": "up", "long_name": name, "source": source}
    column = np.arange(header.ncol, dtype=np.float64)
    row = np.arange(header.nrow, dtype=np.float64)
    metre = {"units": "m"}
    dims: tuple[str, str] = ("row", "column")

    # unrotated grids have one coordinate per axis; rotated ones one per node
    if header.rotation % 360.0 == 0.0:
        dims = ("northing", "easting")
        coords = {
            "northing": Axis(header.yori + row * header.yinc, dims[:1], metre),
            "easting": Axis(header.xori + column * header.xinc, dims[1:], metre),
        }
    else:
        # Node = origin + column * step along the turned easting axis + row * step across it [m].
        along, across = header.axes()
        step_x, step_y = column * header.xinc, row[:, None] * header.yinc
        x = header.xori + (step_x * along[0] + step_y * across[0])
        y = header.yori + (step_x * along[1] + step_y * across[1])
        coords = {"easting": Axis(x, dims, metre), "northing": Axis(y, dims, metre)}

    # The header stays in the attributes, so that a grid can be written as it was read.
    for key in ("rotation", "xori", "yori", "xinc", "yinc", "ncol", "nrow"):
        attrs[key] = getattr(header, key)
    values = np.ascontiguousarray(elevation, dtype=np.float64)
    return GridNodes(values, dims, coords, name, attrs)
