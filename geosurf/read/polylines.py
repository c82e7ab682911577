"""Polylines in text: fault sticks and polygons, ``x y z`` per line.

RMS and Petrel end each polyline with a line ``999 999 999``. A file that does not
end with one was cut short. In csv, a column holds the number of the polyline of each point.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from geosurf.errors import FormatError, InputError
from geosurf.model import FaultSticks
from geosurf.read._columns import END_MARK, Table
from geosurf.read._common import agreed_scale, agreed_sign
from geosurf.read._table import read_table

LABELS = ("poly_id", "stick_id")  # columns with the number of the polyline, lower case


def read_sticks(
    path: Path,
    *,
    name: str,
    positive: str | None = None,
    length_unit: str | None = None,
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
) -> FaultSticks:
    r"""
    Read fault sticks: each ended by ``999 999 999``, or csv with ``POLY_ID`` or ``STICK_ID``.

    Parameters
    ----------
    path : pathlib.Path
    name : str
        Name of the fault.
    positive : {"up", "down"}
        The format does not state it, so this argument is required.
    length_unit : str, optional
        Unit of z (x and y are metres). Default ``"m"``.
    columns, decimal
        Which columns x, y and z are, and the decimal sign, as for points.

    Returns
    -------
    FaultSticks
        Sticks in file order, each (n, 3): easting, northing, elevation [m].

    Raises
    ------
    FormatError
        If a line is not three numbers, a stick has one point, or the last is not ended.
    InputError
        If `positive` is missing or `length_unit` unknown.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "F1.pol"
    >>> _ = file.write_text("0 0 1500\n0 50 1600\n999 999 999\n")
    >>> read_sticks(file, name="F1", positive="down").sticks[0][:, 2]
    array([-1500., -1600.])
    """
    what = f"{path.name}: fault {name!r}"
    scale = agreed_sign(None, positive, what) * agreed_scale(None, length_unit, "m", what)
    sticks = _parts(path, columns, decimal)
    for i, (stick, line) in enumerate(sticks):
        if len(stick) < 2:
            raise FormatError(
                f"{path}, line {line}: stick {i} (counted from 0) has 1 point, expected at least "
                "2. Delete the point, or add another to its stick."
            )
    return FaultSticks(name, tuple(_elevated(stick, scale) for stick, _ in sticks))


def read_polylines(
    path: Path,
    *,
    positive: str | None = None,
    length_unit: str | None = None,
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
) -> list[np.ndarray]:
    r"""
    Read polygons or lines: 999-terminated text, or csv with a ``POLY_ID`` column.

    Parameters
    ----------
    path : pathlib.Path
    positive : {"up", "down"}, optional
        May be left out only where all z are 0 (outlines drawn on a map).
    length_unit : str, optional
        Unit of z (x and y are metres). Default ``"m"``.
    columns, decimal
        Which columns x, y and z are, and the decimal sign, as for points.

    Returns
    -------
    list of ndarray of float64, each (n, 3)
        Easting, northing, elevation [m].

    Raises
    ------
    FormatError
        If a line is not three numbers, or the last polygon is not ended.
    InputError
        If `positive` is missing while some z is not 0, or `length_unit` is unknown.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "outline.pol"
    >>> _ = file.write_text("0 0 0\n9 0 0\n9 9 0\n999 999 999\n")
    >>> [len(line) for line in read_polylines(file)]
    [3]
    """
    lines = [line for line, _ in _parts(path, columns, decimal)]

    # polygons in a plane need no direction: their z is 0
    if positive is None and not any(line[:, 2].any() for line in lines):
        return lines
    what = f"{path.name}: polygons"
    scale = agreed_sign(None, positive, what) * agreed_scale(None, length_unit, "m", what)
    return [_elevated(line, scale) for line in lines]


def _parts(path: Path, columns: object, decimal: str) -> list[tuple[np.ndarray, int]]:
    """Polylines (n, 3) as they stand in the file, each with its first line number."""
    # csv has a column of labels, other text has end marks
    table = read_table(path, columns, decimal, LABELS)
    return _by_label(path, table) if path.suffix.lower() == ".csv" else _terminated(path, table)


def _elevated(line: np.ndarray, scale: float) -> np.ndarray:
    """Return x, y and scaled z; plain 0 rather than -0."""
    return line * [1.0, 1.0, scale] + 0.0


def _terminated(path: Path, table: Table) -> list[tuple[np.ndarray, int]]:
    """Polylines (n, 3) as they stand in the file, each with its first line number."""
    points, lines = table.points, table.lines

    # the mark in all three columns; a file cut short lacks the last one
    ends = np.flatnonzero((points == END_MARK).all(axis=1))
    if len(ends) == 0 or ends[-1] != len(points) - 1:
        raise FormatError(
            f"{path}, line {lines[-1]}: the last line is not '999 999 999', so the last "
            "polyline may be truncated. Export the file again, or add that line if the file is "
            "complete."
        )

    # each polyline begins after the end mark before it
    starts = np.concatenate([[0], ends[:-1] + 1])
    # two end marks in a row enclose nothing and mean nothing
    found = [
        (points[start:end], int(lines[start]))
        for start, end in zip(starts.tolist(), ends.tolist(), strict=True)
        if end > start
    ]
    if not found:
        raise FormatError(f"{path}: the file has end marks only, expected x y z on each line.")
    return found


def _by_label(path: Path, table: Table) -> list[tuple[np.ndarray, int]]:
    """Points of a csv file, split where POLY_ID or STICK_ID changes; each with its first line."""
    points, labels, lines = table.points, table.labels, table.lines
    if labels is None:
        raise InputError(
            f"{path}, line 1: the column POLY_ID (or STICK_ID) is missing, so the polyline of "
            "each point is unknown. Add the column, or read the file with read_points."
        )

    # polylines by runs of equal labels, in the order of the file
    breaks = [0, *(i for i in range(1, len(labels)) if labels[i] != labels[i - 1]), len(labels)]
    pieces = [(points[a:b], int(lines[a])) for a, b in itertools.pairwise(breaks)]
    firsts = [labels[a] for a in breaks[:-1]]

    # A label that comes again would join two lines without order.
    begun: set[str] = set()
    for k, first in enumerate(firsts):
        if first in begun:
            raise FormatError(
                f"{path}, line {lines[breaks[k]]}: polyline {first!r} continues after another "
                "one began. Sort the file by that column."
            )
        begun.add(first)
    return pieces
