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
from geosurf.read._common import (
    agreed_scale,
    agreed_sign,
    integer,
    is_number,
    line_blocks,
    number,
    numbers,
    plain_numbers,
    read_text,
)
from geosurf.read._noted import noted
from geosurf.read.grids.nodes import GridHeader, GridNodes, nodes_from_grid

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
    text = read_text(path)
    system = SYSTEM.search(text[: text.find("@") + 1])

    # values are millions of words, and rarely have comments among them
    cut = text.find("@", text.find("@") + 1) + 1
    body = text[cut:]
    if "!" in body or "+" in body:
        body = PASSED_OVER.sub("", body)
    text = PASSED_OVER.sub("", text[:cut]) + body

    # The header lies between two lines that begin with @.
    marks = list(itertools.islice(re.finditer(r"^[ \t]*@", text, re.MULTILINE), 2))
    head = text[: marks[-1].start()] if marks else ""
    lines = [(i, line) for i, line in enumerate(head.split("\n"), start=1) if line.strip()]
    if len(marks) < 2 or text[: marks[0].start()].strip() or len(lines) < 3:
        raise FormatError(
            f"{path}: expected a header of at least two lines between two '@', found "
            f"{len(marks)} '@'. This is not a ZMAP+ grid, or the file is truncated."
        )

    header, nulls, decimals = _header(path, lines[1], lines[2])

    # values begin on the line after the second @
    start = (text.find("\n", marks[1].end()) + 1) or len(text)
    first = text.count("\n", 0, start) + 1

    # Null values are compared as words first, then as numbers.
    values, has_point = _values(path, text[start:], first, nulls)
    if len(values) != header.ncol * header.nrow:
        raise FormatError(
            f"{path}: found {len(values)} values, expected {header.ncol * header.nrow} "
            f"({header.ncol} columns x {header.nrow} rows). The file is truncated or its "
            "header is wrong; export it again."
        )
    if decimals and not has_point:
        # old programs then read 12345 as 1.2345, newer ones do not
        raise FormatError(
            f"{path}, line {lines[1][0]}: the header announces {decimals} decimals, but no "
            "value has a decimal point. Export the file with decimal points."
        )
    noted("null", " or ".join(sorted(nulls)) or "none stated")
    noted("order of values", "columns from the west, each from the north")
    # columns from the north-west corner -> rows from the south-west one
    grid = values.reshape(header.ncol, header.nrow).T[::-1]
    nodes = nodes_from_grid(header, scale * grid + 0.0, name=name, source=path.name)
    if system is not None:
        nodes.attrs["crs"] = system[1]
    return nodes


def _values(path: Path, text: str, first: int, nulls: set[str]) -> tuple[np.ndarray, bool]:
    """All values, NaN where undefined, and whether one of the others has a decimal point."""
    parts, has_point = [np.empty(0)], False
    for line, piece in line_blocks(text):
        # all are numbers: undefined ones are known by their value, at the end
        plain = plain_numbers(piece)
        if plain is not None:
            parts.append(plain)
            has_point = has_point or "." in piece
            continue

        # words that mean no value are taken out, and the others become numbers at once
        words = piece.split()

        # kept (n,): words that are numbers
        kept = np.array([word not in nulls for word in words], dtype=bool)
        real = words if kept.all() else list(itertools.compress(words, kept.tolist()))
        has_point = has_point or any("." in word for word in real)
        found = numbers(real)

        # one of them is no number: look for it line by line, so that the error names its place
        if found is None:
            for i, row in enumerate(piece.split("\n"), start=first + line - 1):
                for word in row.split():
                    if word not in nulls:
                        number(word, path, i, "value of a node")
            raise AssertionError(f"{path}: a number was refused, and then not")

        values = np.full(len(words), np.nan)
        values[kept] = found
        parts.append(values)
    values = np.concatenate(parts)

    values[np.isin(values, [float(null) for null in nulls if is_number(null)])] = np.nan
    return values, has_point


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
