"""Scattered points: ``x y z`` per line of text, or under a header that names the columns."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.errors import FormatError, InputError
from geosurf.read._common import agreed_scale, agreed_sign, is_number, number_rows, read_text

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

# spellings of the three columns, lower case
COLUMNS = {
    "x": ("x", "x_utme", "easting", "east"),
    "y": ("y", "y_utmn", "northing", "north"),
    "z": ("z", "z_tvdss", "elevation", "depth"),
}


def read_xyz(
    path: Path,
    *,
    positive: str | None = None,
    units: str | None = None,
    columns: Sequence[str] | None = None,
) -> xr.Dataset:
    r"""
    Read points from text or csv.

    Parameters
    ----------
    path : pathlib.Path
        ``.csv`` has a header with the columns ``X_UTME,Y_UTMN,Z_TVDSS`` or ``X,Y,Z``,
        among others in any order. Other text may have one, too; without it, x, y, z are
        first on each line.
    positive : {"up", "down"}
        The formats do not say, so the caller must. (The column name Z_TVDSS is
        no promise: it is written for elevations and for times, too.)
    units : str, optional
        Unit of z (x and y are metres). Default ``"m"``.
    columns : sequence of str, optional
        What the header calls easting, northing and z, where it uses other words.

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` over ``point`` [m], positive up.
        Several points may share a position.

    Raises
    ------
    FormatError
        If a line is not three numbers, or a column is missing.
    InputError
        If `positive` is missing, `units` unknown, or `columns` are not three words.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.poi"
    >>> _ = file.write_text("0 0 1500\n0 50 1600\n")
    >>> read_xyz(file, positive="down").elevation.values
    array([-1500., -1600.])
    """
    import xarray as xr

    what = f"{path.name}: points"
    scale = agreed_sign(None, positive, what) * agreed_scale(None, units, "m", what)
    words = _three_words(columns)
    if path.suffix.lower() == ".csv":
        points, _, _ = columns_of_csv(path, columns=words)
    else:
        points = _columns_of_text(path, words)
    metre = {"units": "m"}
    return xr.Dataset(
        {
            "easting": ("point", points[:, 0].copy(), metre),
            "northing": ("point", points[:, 1].copy(), metre),
            "elevation": ("point", scale * points[:, 2] + 0.0, metre | {"positive": "up"}),
        },
        attrs={"source": path.name},
    )


def _three_words(columns: Any) -> tuple[str, ...] | None:
    """What the caller says that columns are called, in lower case."""
    if columns is None:
        return None
    words = (columns,) if isinstance(columns, str) else tuple(columns)
    if len(words) != 3 or not all(isinstance(word, str) for word in words):
        raise InputError(
            f"columns are {columns!r}; give what the header calls easting, northing and z, as in "
            "columns=('X', 'Y', 'TVDSS')."
        )
    return tuple(word.strip().lower() for word in words)


def _columns_of_text(path: Path, columns: tuple[str, ...] | None) -> np.ndarray:
    """Float64 (n_point, 3) of the first three values of each line, or of those in a header."""
    rows: list[list[str]] = []
    lines: list[int] = []
    header: list[str] = []
    at = [0, 1, 2]
    for i, line in enumerate(read_text(path).splitlines(), start=1):
        tokens = line.replace(",", " ").split()
        if not tokens or tokens[0].startswith(("#", "!")):
            continue
        if not rows and not header and not any(map(is_number, tokens)):
            header = [word.lower() for word in tokens]
            at = _places_of(header, columns, path, i)
            continue
        if len(tokens) < 3 or (header and len(tokens) != len(header)):
            wanted = f"{len(header)} as in the header" if header else "x y z"
            raise FormatError(
                f"{path}, line {i}: found {len(tokens)} values, expected {wanted}. "
                "Mend that line or export the file again."
            )
        rows.append([tokens[k] for k in at])
        lines.append(i)
    if not rows:
        raise FormatError(f"{path}: found no points, expected x y z per line.")
    if columns is not None and not header:
        raise FormatError(
            f"{path}, line {lines[0]}: found numbers, expected a header with the columns "
            f"{', '.join(columns)}. Leave columns out if x, y, z come first."
        )
    points = number_rows(rows, lines, path, "x y z")
    ends = np.flatnonzero((points == 999.0).all(axis=1))
    if len(ends):
        raise FormatError(
            f"{path}, line {lines[ends[0]]}: '999 999 999' ends a polyline, expected a point. "
            "Read sticks with read_fault and outlines with read_polygons (suffix .pol)."
        )
    return points


def _places_of(
    header: list[str], columns: tuple[str, ...] | None, path: Path, line: int
) -> list[int]:
    """Where x, y and z are in a header of lower case, by their usual names or the caller's."""
    at = []
    for k, (axis, usual) in enumerate(COLUMNS.items()):
        spellings = usual if columns is None else columns[k : k + 1]
        found = [i for i, word in enumerate(header) if word in spellings]
        if len(found) != 1:
            raise FormatError(
                f"{path}, line {line}: found {len(found)} columns for {axis} in {header}, expected "
                f"one of {', '.join(spellings)} (in any case). Rename the columns, or, for points, "
                "say what they are called with columns=."
            )
        at.append(found[0])
    return at


def columns_of_csv(
    path: Path, labels: Sequence[str] = (), columns: tuple[str, ...] | None = None
) -> tuple[np.ndarray, list[str] | None, list[int]]:
    """Return points (n, 3), the first column of `labels` that is there, and line numbers."""
    reader = csv.reader(read_text(path).splitlines())
    header = [word.strip().lower() for word in next(reader, [])]
    at = _places_of(header, columns, path, 1)
    named = next((header.index(word) for word in labels if word in header), None)
    rows, lines, found = [], [], []
    try:
        for row in reader:
            if not row:
                continue
            if len(row) != len(header):
                raise FormatError(
                    f"{path}, line {reader.line_num}: found {len(row)} values, expected "
                    f"{len(header)} as in the header. Mend that line or export the file again."
                )
            rows.append([row[i] for i in at])
            lines.append(reader.line_num)
            if named is not None:
                found.append(row[named].strip())
    except csv.Error as error:
        raise FormatError(f"{path}, line {reader.line_num}: no csv ({error}).") from error
    if not rows:
        raise FormatError(f"{path}: found a header only, expected points below it.")
    points = number_rows(rows, lines, path, "x, y, z")
    return points, found if named is not None else None, lines
