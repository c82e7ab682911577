"""What readers of gridded formats share: values in bulk, counts, headers of keys, the result."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from geosurf.errors import FormatError
from geosurf.read._blocks import TextBlocks
from geosurf.read._common import agreed_scale, agreed_sign, block_numbers, piece_numbers
from geosurf.read._noted import noted
from geosurf.read.grids.nodes import GridHeader, GridNodes, nodes_from_grid


def scale_of(path: Path, name: str, positive: str | None, length_unit: str | None) -> float:
    """Metres of elevation per unit of a file that states neither direction nor unit."""
    what = f"{path.name}: horizon {name!r}"
    return agreed_sign(None, positive, what) * agreed_scale(None, length_unit, "m", what)


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
    path: Path, name: str, header: GridHeader, values: np.ndarray, scale: float, order: str
) -> GridNodes:
    """Nodes of values (nrow, ncol), rows from the origin on; their order and rotation are noted."""
    noted("order of values", order)
    return nodes_from_grid(header, scaled(values, scale), name=name, source=path.name)


def scaled(values: np.ndarray, scale: float) -> np.ndarray:
    """Values times a factor, without negative zeros; in place, as maps are large."""
    values = np.require(values, np.float64, ["W"])
    values *= scale
    values += 0.0
    return values
