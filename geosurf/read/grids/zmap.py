"""ZMAP+ grids (text): columns of a map, west to east, each from north to south.

Comments begin with ``!``. Between two ``@`` stand: field width, null value as a
number, null value as text, decimals, first column of a field / number of rows and
columns, west, east, south, north / three numbers nobody uses. The format knows no
rotation.
"""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import numpy as np

from geosurf.errors import FormatError
from geosurf.read._blocks import TextBlocks
from geosurf.read._common import (
    agreed_scale,
    agreed_sign,
    block_numbers,
    integer,
    is_number,
    number,
    numbers,
)
from geosurf.read._noted import noted
from geosurf.read.grids.nodes import GridHeader, GridNodes, nodes_from_grid
from geosurf.read.grids.text import check_count, scaled

SYSTEM = re.compile(r"^![ \t]*CRS:[ \t]*(\S[^\n]*\S)[ \t]*$", re.MULTILINE)  # as geosurf writes it
PASSED_OVER = re.compile(r"^[ \t]*[!+].*", re.MULTILINE)  # comments and extensions


def read_zmap(
    path: Path, *, name: str, positive: str | None = None, length_unit: str | None = None
) -> GridNodes:
    r"""
    Read a ZMAP+ grid.

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
        If the header is incomplete, or values are missing, too many or not numbers.
    InputError
        If `positive` is missing or `length_unit` unknown.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.zmap"
    >>> _ = file.write_text("@top, GRID, 2\n 8, -99, , 1, 1\n"
    ...     " 2, 2, 0, 10, 0, 10\n 0, 0, 0\n@\n 1.0 2.0\n 3.0 -99\n")
    >>> read_zmap(file, name="Top", positive="up").values
    array([[ 2., nan],
           [ 1.,  3.]])
    """
    what = f"{path.name}: horizon {name!r}"
    scale = agreed_sign(None, positive, what) * agreed_scale(None, length_unit, "m", what)
    blocks = TextBlocks(path)

    # The header lies between two lines that begin with @.
    head = blocks.head
    marks = list(itertools.islice(re.finditer(r"^[ \t]*@", head, re.MULTILINE), 2))
    before, within = (
        PASSED_OVER.sub("", head[: marks[k].start()]) if len(marks) == 2 else "" for k in (0, 1)
    )
    lines = [(i, line) for i, line in enumerate(within.split("\n"), start=1) if line.strip()]
    if before.strip() or len(lines) < 3:
        raise FormatError(
            f"{path}: expected a header of at least two lines between two '@', found "
            f"{len(marks)} '@'. This is not a ZMAP+ grid, or the file is truncated."
        )
    system = SYSTEM.search(head[: marks[0].start()])

    header, nulls, decimals = _header(path, lines[1], lines[2])

    # values begin on the line after the second @
    blocks.skip((head.find("\n", marks[1].end()) + 1) or len(head))

    # Null values are compared as words first, then as numbers.
    pieces = _Pieces(path, nulls)
    values, n = block_numbers(blocks, header.ncol * header.nrow, pieces.values)
    check_count(path, n, header)
    values[np.isin(values, [float(null) for null in nulls if is_number(null)])] = np.nan
    if decimals and not pieces.has_point and not np.isnan(values).all():
        # old programs then read 12345 as 1.2345, newer ones do not
        raise FormatError(
            f"{path}, line {lines[1][0]}: the header announces {decimals} decimals, but no "
            "value has a decimal point. Export the file with decimal points."
        )
    noted("null", " or ".join(sorted(nulls)) or "none stated")
    noted("order of values", "columns from the west, each from the north")
    # columns from the north-west corner -> rows from the south-west one
    grid = values.reshape(header.ncol, header.nrow).T[::-1]
    nodes = nodes_from_grid(header, scaled(grid, scale), name=name, source=path.name)
    if system is not None:
        nodes.attrs["crs"] = system[1]
    return nodes


class _Pieces:
    """
    Values of pieces of a file, NaN where undefined.

    Parameters
    ----------
    path : pathlib.Path
    nulls : set of str
        Words that stand for 'undefined'.

    Attributes
    ----------
    has_point : bool
        Whether a value has had a decimal point.
    """

    def __init__(self, path: Path, nulls: set[str]) -> None:
        self.path, self.nulls = path, nulls
        self.has_point = False

    def values(self, piece: str, first: int) -> np.ndarray:
        """Values of a piece that begins on line `first`."""
        # comments among values are rare
        if "!" in piece or "+" in piece:
            piece = PASSED_OVER.sub("", piece)

        # words that mean no value are taken out, and the others become numbers at once;
        # kept (n,): words that are numbers
        words = piece.split()
        kept = np.array([word not in self.nulls for word in words], dtype=bool)
        real = words if kept.all() else list(itertools.compress(words, kept.tolist()))
        self.has_point = self.has_point or any("." in word for word in real)
        found = numbers(real)

        # one of them is no number: look for it line by line, so that the error names its place
        if found is None:
            for i, row in enumerate(piece.split("\n"), start=first):
                for word in row.split():
                    if word not in self.nulls:
                        number(word, self.path, i, "value of a node")
            raise AssertionError(f"{self.path}: a number was refused, and then not")

        values = np.full(len(words), np.nan)
        values[kept] = found
        return values


def _header(
    path: Path, format_line: tuple[int, str], extent_line: tuple[int, str]
) -> tuple[GridHeader, set[str], int]:
    """Geometry, the words that stand for 'undefined', and the number of decimals."""
    # width, null as number, null as text, decimals, first column of a field
    i, line = format_line
    fields = [field.strip() for field in line.rstrip().rstrip(",").split(",")]
    nulls = {field for field in fields[1:3] if field}
    decimals = integer(fields[3], path, i, "decimals") if len(fields) > 3 and fields[3] else 0

    # nrow, ncol, then west, east, south, north of the outer nodes.
    i, line = extent_line
    fields = [field.strip() for field in line.rstrip().rstrip(",").split(",")]
    if len(fields) != 6:
        raise FormatError(
            f"{path}, line {i}: found {len(fields)} values, expected 6 (rows, columns, west, "
            "east, south, north). This is not a ZMAP+ grid."
        )
    nrow, ncol = (integer(fields[k], path, i, "number of rows or columns") for k in (0, 1))
    west, east, south, north = (number(field, path, i, "extent") for field in fields[2:])

    # steps are not in the file: they follow from the outer nodes, so two of each are needed
    if nrow < 2 or ncol < 2:
        raise FormatError(f"{path}, line {i}: {nrow} rows x {ncol} columns, expected at least 2.")

    header = GridHeader(
        ncol, nrow, west, south, (east - west) / (ncol - 1), (north - south) / (nrow - 1)
    )
    return header.checked(path, f"line {i}"), nulls, decimals
