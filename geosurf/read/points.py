"""Scattered points: ``x y z`` per line of text, or under a header that names the columns."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.errors import FormatError
from geosurf.read._common import agreed_scale, agreed_sign, number
from geosurf.read._placed import points_dataset
from geosurf.read._table import END_MARK, Table, read_table

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

# further columns that are kept: they part the paths of several wells
WELL = ("well", "wellname", "well_name", "wellbore", "uwi", "borehole")
MEASURED = ("md", "mdepth")


def read_xyz(
    path: Path,
    *,
    positive: str | None = None,
    length_unit: str | None = None,
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
) -> xr.Dataset:
    r"""
    Read points from text or csv.

    Parameters
    ----------
    path : pathlib.Path
        ``.csv`` has a header with the columns ``X_UTME,Y_UTMN,Z_TVDSS`` or ``X,Y,Z``,
        among others in any order. Other text may have one, too; without it, x, y, z are
        the only numbers on each line. RMS ends points with ``999 999 999``.
    positive : {"up", "down"}
        The formats do not state it, so this argument is required. (The column name Z_TVDSS is
        no promise: it is written for elevations and for times, too.)
    length_unit : str, optional
        Unit of z (x and y are metres). Default ``"m"``.
    columns : sequence of str or of int, optional
        Names of easting, northing and z in the header, or numbers of their columns from 1.
    decimal : {".", ","}, optional
        Decimal sign of the file.

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` over ``point`` [m], positive up.
        Several points may share a position. Columns of wells and measured depths become ``well``
        and ``md``.

    Raises
    ------
    FormatError
        If a line is not three numbers, or a column is missing.
    InputError
        If `positive` is missing, `length_unit` unknown, or `columns` are not three names or
        numbers.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.poi"
    >>> _ = file.write_text("0 0 1500\n0 50 1600\n")
    >>> read_xyz(file, positive="down").elevation.values
    array([-1500., -1600.])
    """
    what = f"{path.name}: points"
    unit = agreed_scale(None, length_unit, "m", what)
    scale = agreed_sign(None, positive, what) * unit
    table = read_table(path, columns, decimal, (WELL, MEASURED), ("well", "md"))
    points = _without_end(path, table)
    x, y, z = points.T
    others: dict[str, Any] = {}
    if table.labels is not None:
        others["well"] = ("point", np.array(table.labels[: len(points)], dtype=object))
    if table.names is not None:
        depths = _measured(path, table, len(points), decimal)
        others["md"] = ("point", unit * depths, {"units": "m"})
    return points_dataset(np.column_stack([x, y, scale * z + 0.0]), path.name, others=others)


def _measured(path: Path, table: Table, count: int, decimal: str) -> np.ndarray:
    """Measured depths along wells, NaN where the file has none."""
    words = [word.replace(decimal, ".", 1) for word in (table.names or [])[:count]]
    empty = ("", "nan", "undef")
    return np.array(
        [
            np.nan if word.lower() in empty else number(word, path, int(line), "measured depth")
            for word, line in zip(words, table.lines, strict=False)
        ]
    )


def _without_end(path: Path, table: Table) -> np.ndarray:
    """Points (n, 3); 999 999 999 on the last lines of a text ends them, as RMS writes it."""
    points = table.points
    if path.suffix.lower() == ".csv":
        return points
    ends = (points == END_MARK).all(axis=1)
    n_point = len(points) - int(np.argmin(ends[::-1])) if not ends.all() else 0
    inside = np.flatnonzero(ends[:n_point])
    if len(inside):
        raise FormatError(
            f"{path}, line {table.lines[inside[0]]}: '999 999 999' ends a polyline, but this "
            "file should hold points. Read sticks with read_fault and outlines with "
            "read_polygons (suffix .pol)."
        )
    if n_point == 0:
        raise FormatError(f"{path}: the file has end marks only, expected x y z on each line.")
    return points[:n_point]
