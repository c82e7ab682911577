"""Points, polygons and sticks with attributes, as RMS and Petrel export them.

RMS begins with a line for each attribute (``Float dip``, ``String fault``), then writes x, y, z and
the attributes. Petrel names its columns between BEGIN HEADER and END HEADER. Lines of polygons are
separated by ``999 999 999`` or by a column with their number; texts with blanks are in quotes.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions.column_names import LABELS
from geosurf.errors import FormatError, InputError
from geosurf.model import FaultSticks
from geosurf.read._common import agreed_scale, agreed_sign, is_number, number
from geosurf.read._noted import noted
from geosurf.read._placed import points_dataset
from geosurf.read._table import END_MARK, Table, checked_decimal, named_column
from geosurf.read._tops_layout import Layout, layout_of
from geosurf.read.polylines import NAMES, parts_of, polylines_from, sticks_from

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

COORDINATES = ("easting", "northing", "elevation")
UNDEFINED = ("undef", "undefined", "nan", "null")


def read_attribute_points(
    path: Path,
    *,
    positive: str | None = None,
    length_unit: str | None = None,
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
) -> xr.Dataset:
    r"""
    Read points with their attributes.

    Parameters
    ----------
    path : pathlib.Path
    positive : {"up", "down"}
        The formats do not state it, so this argument is required.
    length_unit : str, optional
        Unit of z, if a comment of Petrel does not state it. Default ``"m"``.
    columns : sequence of str, optional
        Names of easting, northing and z, if they are not X, Y and Z.
    decimal : {".", ","}

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` and all attributes over ``point``; undefined
        numbers are NaN.

    Raises
    ------
    FormatError
        If a line has more or fewer words than there are columns, or a coordinate is not a number.
    InputError
        If `positive` is missing.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "picks.dat"
    >>> _ = file.write_text("Float dip\nString well\n1 2 30 5.5 \"W 1\"\n3 4 50 UNDEF W2\n")
    >>> picks = read_attribute_points(file, positive="down")
    >>> picks.elevation.values, picks.dip.values, picks.well.values.tolist()
    (array([-30., -50.]), array([5.5, nan]), ['W 1', 'W2'])
    """
    layout, table = _table(path, columns, decimal)
    inside = ~(table.points == END_MARK).all(axis=1)
    what = f"{path.name}: points"
    scale = agreed_sign(None, positive, what)
    scale *= agreed_scale(layout.length_unit, length_unit, "m", what)
    points = table.points[inside] * [1.0, 1.0, scale] + 0.0
    others: dict[str, Any] = {}
    rows = [words for (_, words), take in zip(layout.rows, inside.tolist(), strict=True) if take]
    for k, name in enumerate(layout.header or ()):
        # coordinates are there already, also under other names
        taken = name.lower() in (*COORDINATES, *others)
        if k not in _places(path, layout, columns) and not taken:
            others[name] = ("point", _column([words[k] for words in rows]))
    noted("attributes", ", ".join(str(key) for key in others) or "none")
    return points_dataset(points, path.name, others=others)


def read_attribute_polygons(
    path: Path,
    *,
    positive: str | None = None,
    length_unit: str | None = None,
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
    name: str | None = None,
) -> list[np.ndarray]:
    """
    Read polygons or lines with attributes.

    Parameters
    ----------
    path, positive, length_unit, columns, decimal
        As for `read_attribute_points`; `positive` may be left out where all z are 0.
    name : str, optional
        Only lines whose attribute ``name`` or ``fault`` is this one.

    Returns
    -------
    list of ndarray of float64, each (n, 3)

    Raises
    ------
    FormatError, InputError
        As `read_attribute_points`.
    """
    layout, table = _table(path, columns, decimal)
    unit = length_unit if layout.length_unit is None else layout.length_unit
    return polylines_from(path, parts_of(path, table), positive, unit, name)


def read_attribute_sticks(
    path: Path,
    *,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
    columns: Sequence[str] | Sequence[int] | None = None,
    decimal: str = ".",
) -> FaultSticks:
    """
    Read the sticks of a fault from lines with attributes.

    Parameters
    ----------
    path, positive, length_unit, columns, decimal
        As for `read_attribute_points`.
    name : str, optional
        Which fault, if there are several; else the name of the fault.

    Returns
    -------
    FaultSticks

    Raises
    ------
    FormatError, InputError
        As `read_attribute_points`.
    """
    layout, table = _table(path, columns, decimal)
    unit = length_unit if layout.length_unit is None else layout.length_unit
    return sticks_from(path, parts_of(path, table), name, positive, unit)


def _table(path: Path, columns: Any, decimal: Any) -> tuple[Layout, Table]:
    """The file as it stands, and its coordinates, numbers of lines and names."""
    sign = checked_decimal(decimal)
    layout = layout_of(path, sign, typed=True)
    if not layout.rows:
        raise FormatError(f"{path}: the file has no points below its header. Export it again.")
    places = _places(path, layout, columns)
    points = np.empty((len(layout.rows), 3))
    for k, (line, words) in enumerate(layout.rows):
        found = [words[place] for place in places]
        if sign == ",":
            found = [word.replace(",", ".", 1) for word in found]
        points[k] = [number(word, path, line, "x, y or z") for word in found]
    lines = np.array([line for line, _ in layout.rows])
    header = [word.lower() for word in layout.header or ()]
    more: list[list[str] | None] = []
    for usual in (LABELS, NAMES):
        place = next((header.index(word) for word in usual if word in header), None)
        more.append(None if place is None else [_word(words, place) for _, words in layout.rows])
    noted("columns", f"easting, northing, z are columns {', '.join(str(k + 1) for k in places)}")
    noted("attributes", ", ".join((layout.header or [])[3:]) or "none")
    return layout, Table(points, lines, *more)


def _word(words: list[str], place: int) -> str:
    """A word of a row; end marks may be shorter than the header."""
    return words[place] if place < len(words) else ""


def _places(path: Path, layout: Layout, columns: Any) -> list[int]:
    """Columns of x, y and z."""
    header = [word.lower() for word in layout.header or ()]
    if columns is None:
        return [named_column(path, header, axis) for axis in "xyz"]
    words = [str(word).strip().lower() for word in columns]
    if isinstance(columns, str) or len(words) != 3 or not set(words) <= set(header):
        raise InputError(
            f"{path}: columns is {columns!r}, expected three names among {', '.join(header)}, as "
            "in columns=('X', 'Y', 'Z')."
        )
    return [header.index(word) for word in words]


def _column(words: list[str]) -> np.ndarray:
    """Numbers with NaN where undefined, or texts."""
    numeric = all(is_number(word) or word.lower() in UNDEFINED for word in words)
    if numeric and any(is_number(word) for word in words):
        return np.array([float(word) if is_number(word) else np.nan for word in words])
    return np.array(words, dtype=object)
