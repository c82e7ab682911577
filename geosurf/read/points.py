"""Scattered points: ``x y z`` per line of text, or csv with a header."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from geosurf.errors import FormatError
from geosurf.read._common import agreed_scale, agreed_sign, number_rows, read_text

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

# spellings of the three columns, lower case
COLUMNS = {
    "x": ("x", "x_utme", "easting", "east"),
    "y": ("y", "y_utmn", "northing", "north"),
    "z": ("z", "z_tvdss", "elevation", "depth"),
}


def read_xyz(path: Path, *, positive: str | None = None, units: str | None = None) -> xr.Dataset:
    r"""
    Read points from text or csv.

    Parameters
    ----------
    path : pathlib.Path
        ``.csv`` has a header with the columns ``X_UTME,Y_UTMN,Z_TVDSS`` or ``X,Y,Z``,
        among others in any order; other text has x, y, z first on each line.
    positive : {"up", "down"}
        The formats do not say, so the caller must. (The column name Z_TVDSS is
        no promise: it is written for elevations and for times, too.)
    units : str, optional
        Unit of z (x and y are metres). Default ``"m"``.

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
        If `positive` is missing or `units` unknown.

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
    points = columns_of_csv(path)[0] if path.suffix.lower() == ".csv" else _columns_of_text(path)
    metre = {"units": "m"}
    return xr.Dataset(
        {
            "easting": ("point", points[:, 0].copy(), metre),
            "northing": ("point", points[:, 1].copy(), metre),
            "elevation": ("point", scale * points[:, 2] + 0.0, metre | {"positive": "up"}),
        },
        attrs={"source": path.name},
    )


def _columns_of_text(path: Path) -> np.ndarray:
    """Float64 (n_point, 3) of the first three values of each line."""
    rows: list[list[str]] = []
    lines: list[int] = []
    for i, line in enumerate(read_text(path).splitlines(), start=1):
        tokens = line.replace(",", " ").split()
        if not tokens or tokens[0].startswith(("#", "!")):
            continue
        if len(tokens) < 3:
            raise FormatError(
                f"{path}, line {i}: found {len(tokens)} values, expected x y z. "
                "Mend that line or export the file again."
            )
        rows.append(tokens[:3])
        lines.append(i)
    if not rows:
        raise FormatError(f"{path}: found no points, expected x y z per line.")
    points = number_rows(rows, lines, path, "x y z")
    ends = np.flatnonzero((points == 999.0).all(axis=1))
    if len(ends):
        raise FormatError(
            f"{path}, line {lines[ends[0]]}: '999 999 999' ends a polyline, expected a point. "
            "Read sticks with read_fault and outlines with read_polygons (suffix .pol)."
        )
    return points


def columns_of_csv(
    path: Path, label: str | None = None
) -> tuple[np.ndarray, list[str] | None, list[int]]:
    """Return points (n, 3), the `label` column if there is one, and line numbers."""
    reader = csv.reader(read_text(path).splitlines())
    header = [word.strip().lower() for word in next(reader, [])]
    at = []
    for axis, spellings in COLUMNS.items():
        found = [i for i, word in enumerate(header) if word in spellings]
        if len(found) != 1:
            raise FormatError(
                f"{path}, line 1: found {len(found)} columns for {axis} in {header}, expected "
                f"one of {', '.join(spellings)} (in any case). Rename the columns."
            )
        at.append(found[0])
    named = header.index(label) if label in header else None
    rows, lines, labels = [], [], []
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
                labels.append(row[named].strip())
    except csv.Error as error:
        raise FormatError(f"{path}, line {reader.line_num}: no csv ({error}).") from error
    if not rows:
        raise FormatError(f"{path}: found a header only, expected points below it.")
    points = number_rows(rows, lines, path, "x, y, z")
    return points, labels if named is not None else None, lines
