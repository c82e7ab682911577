"""Regular grids: IRAP in text and binary; ZMAP+, CPS-3 and ESRI, which have no rotation; points.

All state their null value, so one is chosen that no node has. Numbers give the same float64 back.
Only ZMAP+ has fields of one width: eight decimals or more, as many as fit.
"""

from __future__ import annotations

import itertools
import math
import struct
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from geosurf.conventions.axes import is_time_unit
from geosurf.conventions.crs import crs_of, label
from geosurf.errors import OutputError
from geosurf.lazy import xarray as xr
from geosurf.write.written import SMALLEST, Loss, name_lost, precision_lost

# ---- decimals ----------------------------------------
# Numbers to text: decimals that give the same float64 back, as Python writes them.


AT_ONCE = 16384  # rows at a time: words take many times the memory of numbers
SHORT = (1, 3, 6, 9, 12)  # decimals that are tried first
LARGEST = 1e8
MOST_FIXED = 13

Part = np.ndarray | bytes


def rows_text(parts: Sequence[Part], head: bytes = b"") -> bytearray:
    r"""
    Return lines of text: in each row one word of every part, one after another.

    Parameters
    ----------
    parts : sequence of bytes or ndarray, shape (n,)
        Bytes stand in every row. Floats become decimals that give the same float64 back, whole
        numbers digits.
    head : bytes
        What stands before the rows: a header added later would copy the whole text.

    Returns
    -------
    bytearray

    Examples
    --------
    >>> rows_text([np.array([1, 20]), b" ", np.array([0.5, np.nan]), b"\n"])
    bytearray(b'1 0.5\n20 nan\n')
    """
    n = max(len(part) for part in parts if isinstance(part, np.ndarray))
    text = bytearray(head)
    for start in range(0, n, AT_ONCE):
        columns = (
            itertools.repeat(part.decode())
            if isinstance(part, bytes)
            else _words(part[start : start + AT_ONCE], repr, b"nan")
            for part in parts
        )
        text += "".join(itertools.chain.from_iterable(zip(*columns, strict=False))).encode()
    return text


def lines_text(
    values: np.ndarray,
    per_line: int,
    undefined: bytes,
    head: bytes = b"",
    form: Callable[[float], str] = repr,
    between: str = " ",
) -> bytearray:
    r"""
    Return numbers in lines: each row begins a line, and has at most `per_line` numbers on one.

    Parameters
    ----------
    values : ndarray of float64, shape (n_row, n)
    per_line : int
    undefined : bytes
        What stands for NaN.
    head : bytes
        What stands before the rows.
    form : callable
        Makes the word of a number.
    between : str
        What stands between two words of a line.

    Returns
    -------
    bytearray

    Examples
    --------
    >>> lines_text(np.arange(6.0).reshape(2, 3), 2, b"nan")
    bytearray(b'0.0 1.0\n2.0\n3.0 4.0\n5.0\n')
    """
    n = values.shape[1]
    last = [(k + 1) % per_line == 0 or k == n - 1 for k in range(n)]
    ends: Iterator[str] = itertools.cycle("\n" if one else between for one in last)
    text, values = bytearray(head), values.ravel()
    for start in range(0, len(values), AT_ONCE):
        words = _words(values[start : start + AT_ONCE], form, undefined)
        pairs = zip(words, ends, strict=False)
        text += "".join(itertools.chain.from_iterable(pairs)).encode()
    return text


def n_fixed(values: np.ndarray, width: int) -> int:
    """Return how many decimals fields of a width need to be exact, or else have room for."""
    size = np.abs(values[~np.isnan(values)])
    largest = float(size.max(initial=0.0))
    room = width - 2 - len(str(int(min(largest, LARGEST)) + 1)) - 1  # blank, sign, point
    for n in SHORT:
        # a few values show that most maps have more decimals
        if n <= room and _is_short(size[:1000], n) and _is_short(size, n):
            return n
    return max(1, min(room, MOST_FIXED))


def _is_short(size: np.ndarray, n: int) -> bool:
    """Whether all values are decimals with n places, exactly."""
    scaled = np.rint(size * 10.0**n)
    return bool(((scaled / 10.0**n == size) & (scaled < 2.0**53)).all())


def _words(values: np.ndarray, form: Callable[[float], str], undefined: bytes) -> list[str]:
    """A word for each number."""
    if values.dtype.kind in "iu":
        return [*map(str, values.tolist())]
    words = [*map(form, values.astype(np.float64, copy=False).tolist())]
    for k in np.flatnonzero(np.isnan(values)).tolist():
        words[k] = undefined.decode()
    return words


# ---- irap ----------------------------------------
# IRAP grids, classic (text) and binary.
#
# Both hold one origin, two increments and a rotation, so only regular grids fit. The
# binary one is float32 throughout, header included: at a northing of 6 000 000 m that
# is a step of 0.5 m. What was lost is measured and stated.
#
# Suffixes follow xtgeo, which goes by them: ``.gri``, ``.irap`` and ``.irapbin`` are binary,
# ``.irapasc``, ``.irapascii`` and ``.fgr`` text.


UNDEFINED_CLASSIC = b"9999900.0"
UNDEFINED_BINARY = 1e30
UNDEFINED_FROM = 9.9e29  # readers take these for undefined: 1e30 is rounded
IRAP_PER_LINE = 6  # RMS reads at most 9


def irap_classic(horizon: xr.DataArray, name: str) -> tuple[bytes | bytearray, list[Loss]]:
    """Return IRAP classic text; numbers give the same float64 back."""
    (x, y, xinc, yinc, rotation), values, moved = regular_grid(horizon, name, off=ROUNDED)
    nrow, ncol = values.shape
    xmax, ymax = x + (ncol - 1) * xinc, y + (nrow - 1) * yinc
    refuse_value(values, float(UNDEFINED_CLASSIC), name, "IRAP")

    # The header has four lines: sizes and steps, limits, columns and rotation with its pivot,
    # zeros.
    head = (
        f"-996 {nrow} {xinc!r} {yinc!r}\n{x!r} {xmax!r} {y!r} {ymax!r}\n{ncol} {rotation!r} {x!r} "
        f"{y!r}\n0 0 0 0 0 0 0\n"
    )
    text = lines_text(values.reshape(1, -1), IRAP_PER_LINE, UNDEFINED_CLASSIC, head.encode("ascii"))
    return text, not_stored(horizon, "IRAP", moved)


def irap_binary(horizon: xr.DataArray, name: str) -> tuple[bytes | bytearray, list[Loss]]:
    """Return IRAP binary, and how far float32 moved nodes and values."""
    (x, y, xinc, yinc, rotation), values, moved = regular_grid(horizon, name, off=ROUNDED)
    nrow, ncol = values.shape
    xmax, ymax = x + (ncol - 1) * xinc, y + (nrow - 1) * yinc

    if (values >= UNDEFINED_FROM).any():
        raise OutputError(
            f"horizon {name!r} has values of {UNDEFINED_FROM:g} or more, which mean 'undefined' in "
            "IRAP. Write .nc instead."
        )

    # Records of Fortran, big-endian: header fields, then one record of float32 for each row.
    single = np.where(np.isnan(values), UNDEFINED_BINARY, values).astype(">f4")
    records = [
        struct.pack(">ii6f", -996, nrow, x, xmax, y, ymax, xinc, yinc),
        struct.pack(">i3f", ncol, rotation, x, y),
        struct.pack(">7i", *[0] * 7),
        *(row.tobytes() for row in single),
    ]
    data = b"".join(struct.pack(">i", len(r)) + r + struct.pack(">i", len(r)) for r in records)
    rounding = _rounding((x, y, xinc, yinc, rotation), single, values)
    return data, [*rounding, *not_stored(horizon, "IRAP", moved)]


def _rounding(exact: Geometry, single: np.ndarray, values: np.ndarray) -> list[Loss]:
    """What float32 moved: nodes, farthest in a corner of the grid, and values."""
    nrow, ncol = values.shape
    rounded: Geometry = tuple(float(np.float32(value)) for value in exact)  # type: ignore[assignment]
    moved = max(
        math.dist(node_of(exact, row, column), node_of(rounded, row, column))
        for row in (0, nrow - 1)
        for column in (0, ncol - 1)
    )

    # values: rounding of float32, away from undefined nodes
    lost = np.abs(single.astype(np.float64) - values)
    largest = float(np.nanmax(lost)) if np.isfinite(lost).any() else 0.0
    if moved == largest == 0.0:
        return []
    sentence = (
        f"IRAP binary stores float32: nodes moved by up to {moved:.3g} m and values by up to "
        f"{largest:.3g}. Write .irapasc or .nc for exact values."
    )
    return [Loss("precision", sentence, max(moved, largest))]


PER_LINE = 5
WIDTH = 20  # of a field of ZMAP+, as other programs write it
ZMAP_NULLS = ("-99999.0", "1e30", "-3.4e38")
ESRI_NULLS = ("-9999", "-99999", "-3.4e38")
CPS3_NULL = "1.0E+30"


def zmap_of_horizon(horizon: xr.DataArray, name: str) -> tuple[bytes | bytearray, list[Loss]]:
    """Return ZMAP+ text: columns from the west, each from the north."""
    grid = _upright(horizon, name, "ZMAP+", at_least=2)
    null = null_for(grid.values, ZMAP_NULLS)
    decimals = n_fixed(grid.values, WIDTH)
    if np.abs(grid.values[~np.isnan(grid.values)]).max(initial=0.0) >= LARGEST:
        raise OutputError(
            f"horizon {name!r} has values of 1e8 or more, which the fields of ZMAP+ do not hold. "
            "Write .irapasc or .nc."
        )
    title = " ".join(name.replace(",", " ").split()) or "horizon"
    head = (
        f"! {_one_line(name)}, written by geosurf\n{_crs_line(horizon, '!')}"
        f"@{title}, GRID, {PER_LINE}\n"
        f"{WIDTH}, {null}, , {decimals}, 1\n"
        f"{grid.values.shape[0]}, {grid.values.shape[1]}, "
        f"{grid.west!r}, {grid.east!r}, {grid.south!r}, {grid.north!r}\n0.0, 0.0, 0.0\n@\n"
    )
    columns = grid.values[::-1].T
    form, undefined = f"%{WIDTH}.{decimals}f".__mod__, null.rjust(WIDTH).encode()
    text = lines_text(columns, PER_LINE, undefined, head.encode(), form, "")
    return text, [*name_lost(name, title), *not_stored(horizon, "ZMAP+", grid.moved)]


def cps3_of_horizon(horizon: xr.DataArray, name: str) -> tuple[bytes | bytearray, list[Loss]]:
    """Return CPS-3 text: columns from the west, each from the north."""
    grid = _upright(horizon, name, "CPS-3", at_least=2)
    refuse_value(grid.values, float(CPS3_NULL), name, "CPS-3")
    low = high = 0.0
    if not np.isnan(grid.values).all():
        low, high = float(np.nanmin(grid.values)), float(np.nanmax(grid.values))
    head = (
        f"FSASCI 0 1 COMPUTED 0 {CPS3_NULL} 0\nFSATTR 0 0\nFSLIMI {grid.west!r} {grid.east!r} "
        f"{grid.south!r} {grid.north!r} {low!r} {high!r}\nFSNROW {grid.values.shape[0]} "
        f"{grid.values.shape[1]}\nFSXINC {grid.dx!r} {grid.dy!r}\n-> {_one_line(name)}\n"
    )
    text = lines_text(grid.values[::-1].T, PER_LINE, CPS3_NULL.encode(), head.encode())
    lost = name_lost(name, _one_line(name))
    return text, [*lost, *not_stored(horizon, "CPS-3", grid.moved)]


def esri_of_horizon(horizon: xr.DataArray, name: str) -> tuple[bytes | bytearray, list[Loss]]:
    """Return ESRI text: rows from the north, nodes as centres of cells."""
    grid = _upright(horizon, name, "the ESRI grid", at_least=1)
    null = null_for(grid.values, ESRI_NULLS)
    lost = [Loss("name", "The format does not store names.")]

    # steps that are equal but for rounding are one cell size, if no node moves by it
    n = max(grid.values.shape)
    if abs(grid.dx - grid.dy) * n <= SMALLEST:
        cells = f"cellsize {grid.dx!r}"
    else:
        cells = f"dx {grid.dx!r}\ndy {grid.dy!r}"
        words = f"Cells are {grid.dx:g} x {grid.dy:g} m, stored as dx and dy: GDAL reads them"
        lost.append(Loss("grid", f"{words}, programs that know square cells only do not."))
    head = (
        f"ncols {grid.values.shape[1]}\nnrows {grid.values.shape[0]}\n"
        f"xllcenter {grid.west!r}\nyllcenter {grid.south!r}\n{cells}\nNODATA_value {null}\n"
    )
    text = lines_text(grid.values[::-1], grid.values.shape[1], null.encode(), head.encode())
    return text, [*lost, *not_stored(horizon, "the ESRI grid", grid.moved)]


def xyz_of_horizon(horizon: xr.DataArray, name: str) -> tuple[bytes | bytearray, list[Loss]]:
    """Return ``x y z`` of each node that has a value, row by row; any grid fits."""
    refuse_other_axes(horizon, name)
    refuse_odd_nodes(horizon, name)

    # one easting and northing for each node, in the order of the values
    places = (horizon[key].broadcast_like(horizon) for key in ("easting", "northing"))
    easting, northing = (place.transpose(*horizon.dims).values for place in places)
    values = np.asarray(horizon.values, dtype=np.float64)
    known = ~np.isnan(values)
    if not known.any():
        raise OutputError(f"horizon {name!r} has no values, and a file of points needs one.")
    columns = [np.asarray(part, dtype=np.float64)[known] for part in (easting, northing, values)]
    lost = [Loss("grid", "The file holds points: rows, columns and steps of the grid are lost.")]
    if not known.all():
        n = int((~known).sum())
        lost.append(Loss("undefined", f"{n} of {known.size} nodes have no value and are left out."))
    body = rows_text([columns[0], b" ", columns[1], b" ", columns[2], b"\n"])
    lost.append(Loss("name", "The format does not store names."))
    return body, [*lost, *not_stored(horizon, "a file of points")]


def _upright(horizon: xr.DataArray, name: str, title: str, at_least: int) -> UprightGrid:
    """A grid without rotation; formats without steps need two nodes along each axis."""
    grid = upright_grid(horizon, name, title)
    n_row, n_column = grid.values.shape
    if min(n_row, n_column) < at_least:
        raise OutputError(
            f"horizon {name!r} has {n_row} rows and {n_column} columns, and {title} needs "
            f"{at_least} of each, since it stores no steps. Write .irapasc or .nc."
        )
    return grid


def _crs_line(horizon: xr.DataArray, mark: str) -> str:
    """A comment with the reference system, if there is one."""
    crs = crs_of(horizon)
    return "" if crs is None else f"{mark} CRS: {_one_line(label(crs) if '[' in crs else crs)}\n"


def _one_line(text: str) -> str:
    return " ".join(text.split()) or "horizon"


# nodes may be off the regular grid by this much of an increment
SLACK = 1e-6
ROUNDED = 0.01  # m: and by this much in files, as those of other programs round them
Geometry = tuple[float, float, float, float, float]


def regular_grid(
    horizon: xr.DataArray, name: str, title: str = "IRAP", off: float = 0.0
) -> tuple[Geometry, np.ndarray, float]:
    """Return origin, increments and rotation of a regular grid, and its values.

    Parameters
    ----------
    horizon : DataArray
    name : str
        Name of the horizon, for errors.
    title : str
        Name of the format, for errors.
    off : float
        How far nodes may lie off the grid [m]: of a thousandth of a step at most.

    Returns
    -------
    geometry : tuple of float
        x and y of the first node, step along columns, step along rows [m], and the rotation
        (degrees, counter-clockwise from east).
    values : ndarray of float64, shape (n_row, n_column)
    moved : float
        How far a node lies from where the geometry puts it, at most [m].

    Raises
    ------
    OutputError
        If nodes are not on a regular, right-angled grid.
    """
    refuse_other_axes(horizon, name)

    # rows from the south, columns from the west, whatever order the array has
    if horizon.easting.ndim == horizon.northing.ndim == 1:
        across = (*horizon.northing.dims, *horizon.easting.dims)
        horizon = horizon.transpose(*across)
        falling = [key for key in ("northing", "easting") if (np.diff(horizon[key]) < 0).any()]
        horizon = horizon.sortby(falling) if falling else horizon  # sorting copies all values

    refuse_odd_nodes(horizon, name)
    values = np.asarray(horizon.values, dtype=np.float64)
    easting = np.asarray(horizon.easting.values, dtype=np.float64)
    northing = np.asarray(horizon.northing.values, dtype=np.float64)
    if easting.ndim == northing.ndim == 1:
        # one line of nodes for each axis: a mesh of all would take more memory than the values
        easting, northing = easting[None], northing[:, None]

    # The stated geometry is exact; one fitted to the nodes has rounding, that of float64 at least.
    scale = 8 * np.finfo(np.float64).eps * max(abs(easting[0, 0]), abs(northing[0, 0]), 1.0)
    stated = _stated(horizon)
    if stated is not None:
        moved = _misfit(stated, easting, northing)
        if moved <= 1e-9 * min(abs(stated[2]), abs(stated[3])) + scale:
            return stated, values, 0.0

    fitted = _fitted(easting, northing)
    moved, step = _misfit(fitted, easting, northing), min(abs(fitted[2]), abs(fitted[3]))
    if step == 0.0 or moved > max(SLACK * step, min(off, 1e-3 * step)) + scale:
        raise OutputError(
            f"horizon {name!r}: its nodes are not on a regular rectangular grid, and {title} "
            "stores no other grids. Write .nc, or resample the horizon."
        )
    return fitted, values, moved


def upright_grid(horizon: xr.DataArray, name: str, title: str) -> UprightGrid:
    """Return a grid for a format without rotation; quarter turns become rows and columns.

    Parameters
    ----------
    horizon : DataArray
    name, title : str
        Names of the horizon and of the format, for errors.

    Returns
    -------
    UprightGrid

    Raises
    ------
    OutputError
        If the grid is rotated by another angle, or is not regular.
    """
    (x, y, xinc, yinc, rotation), values, moved = regular_grid(horizon, name, title, ROUNDED)
    n_row, n_column = values.shape

    # the far ends of the first row and of the first column, measured along both axes
    turn = math.radians(rotation)
    along = np.array([math.cos(turn), math.sin(turn)]) * xinc
    across = np.array([-math.sin(turn), math.cos(turn)]) * yinc
    turned = abs(along[1]) > abs(along[0])
    if turned:
        along, across, values = across, along, values.T
    n_row, n_column = values.shape
    skew = max(abs(along[1]) * (n_column - 1), abs(across[0]) * (n_row - 1))
    step = min(abs(along[0]), abs(across[1]))
    if skew > max(SLACK * step, min(ROUNDED, 1e-3 * step)):
        raise OutputError(
            f"horizon {name!r} is rotated by {rotation:.6g} degrees, and {title} stores no "
            "rotation. Write .irapasc, .gri or .nc, which do, or resample the horizon onto a grid "
            "along east and north."
        )

    # steps against the axes: begin at the other end
    west, south = x, y
    if along[0] < 0:
        west, values = x + (n_column - 1) * along[0], values[:, ::-1]
    if across[1] < 0:
        south, values = y + (n_row - 1) * across[1], values[::-1]
    return UprightGrid(
        float(west), float(south), float(abs(along[0])), float(abs(across[1])), values, moved + skew
    )


@dataclass(frozen=True)
class UprightGrid:
    """
    A grid along east and north.

    Attributes
    ----------
    west, south : float
        The first node [m].
    dx, dy : float
        Steps [m].
    values : ndarray of float64, shape (n_row, n_column)
        Rows from the south, each from the west.
    moved : float
        How far a node lies from where the grid has it, at most [m].
    """

    west: float
    south: float
    dx: float
    dy: float
    values: np.ndarray
    moved: float

    @property
    def east(self) -> float:
        """Easting of the last column [m]."""
        return float(self.west + (self.values.shape[1] - 1) * self.dx)

    @property
    def north(self) -> float:
        """Northing of the last row [m]."""
        return float(self.south + (self.values.shape[0] - 1) * self.dy)


def refuse_other_axes(horizon: xr.DataArray, name: str) -> None:
    """Refuse what has no two dims of nodes with eastings and northings."""
    if horizon.ndim != 2 or "easting" not in horizon.coords or "northing" not in horizon.coords:
        raise OutputError(
            f"horizon {name!r} has dims {horizon.dims} and coordinates {list(horizon.coords)}; a "
            "file of its nodes needs two dims and the coordinates easting and northing. Add them."
        )


def refuse_odd_nodes(horizon: xr.DataArray, name: str) -> None:
    """Refuse infinite values, and nodes that have no place or share one: readers would fail."""
    if np.isinf(np.asarray(horizon.values, dtype=np.float64)).any():
        raise OutputError(
            f"horizon {name!r} has infinite values. Set missing nodes to NaN instead."
        )
    for key in ("easting", "northing"):
        if key not in horizon.coords:
            continue
        axis = np.asarray(horizon[key].values, dtype=np.float64)
        if not np.isfinite(axis).all():
            raise OutputError(
                f"horizon {name!r}: {key} has values that are not finite. Give each node a place."
            )
        if axis.ndim == 1 and len(np.unique(axis)) < len(axis):
            raise OutputError(
                f"horizon {name!r}: {key} has the same value twice. Drop one of the rows or "
                "columns there."
            )


def refuse_value(values: np.ndarray, mark: float, name: str, title: str) -> None:
    """Refuse a value that means 'undefined' in a format: it would be read as absent."""
    if (values == mark).any():
        raise OutputError(
            f"horizon {name!r} has a value of {mark!r}, which means 'undefined' in {title}. Write "
            ".nc instead."
        )


def null_for(values: np.ndarray, candidates: tuple[str, ...]) -> str:
    """Return the first null value that no node has; the formats state it in their headers."""
    return next(word for word in candidates if not (values == float(word)).any())


def not_stored(horizon: xr.DataArray, title: str, moved: float = 0.0) -> list[Loss]:
    """State what a format cannot: direction and unit of its values, and how far nodes moved."""
    positive = horizon.attrs.get("positive", "up")
    given = {"down": "depth", "up": "elevation"}.get(horizon.attrs.get("positive", ""))
    word = str(given or horizon.attrs.get("long_name") or horizon.name or "elevation")
    unit = horizon.attrs.get("units", "m")
    losses = [
        *precision_lost(moved, "Nodes are off a regular grid, and were moved"),
        Loss(
            "direction",
            f"Values are {word} in {unit}, which {title} does not store: "
            f"read the file with positive={positive!r}.",
        ),
    ]
    if unit != "m":
        how = f"read the file with length_unit={unit!r}"
        if is_time_unit(unit):
            how = f"give its path to Scene(..., time=..., length_unit={unit!r})"
        losses.append(Loss("unit", f"Values are in {unit}: {how}."))
    return losses


def node_of(grid: Geometry, row: int, column: int) -> tuple[float, float]:
    """Easting and northing of a node of a regular grid [m]."""
    x, y, xinc, yinc, rotation = grid
    cos, sin = math.cos(math.radians(rotation)), math.sin(math.radians(rotation))

    # The step along columns, turned by the rotation, and the one along rows at a right angle [m].
    return (x + column * xinc * cos - row * yinc * sin, y + column * xinc * sin + row * yinc * cos)


def _stated(horizon: xr.DataArray) -> Geometry | None:
    """Return the geometry in the attributes, if there is one."""
    try:
        x, y, xinc, yinc, rotation = (
            float(horizon.attrs[key]) for key in ("xori", "yori", "xinc", "yinc", "rotation")
        )
    except (KeyError, TypeError, ValueError):
        return None
    return x, y, xinc, yinc, rotation


def _fitted(easting: np.ndarray, northing: np.ndarray) -> Geometry:
    """Return the geometry that the corner nodes imply; single rows get a step of 1."""
    nrow, ncol = np.broadcast_shapes(easting.shape, northing.shape)
    x, y = float(easting[0, 0]), float(northing[0, 0])

    # Steps between corner nodes average the rounding of all columns and rows.
    along = (float(easting[0, -1]) - x, float(northing[0, -1]) - y)
    across = (float(easting[-1, 0]) - x, float(northing[-1, 0]) - y)

    xinc = math.hypot(*along) / (ncol - 1) if ncol > 1 else 1.0
    yinc = math.hypot(*across) / (nrow - 1) if nrow > 1 else 1.0

    # A negative step along rows where rows run clockwise from columns.
    if along[0] * across[1] - along[1] * across[0] < 0:
        yinc = -yinc
    # the direction between that of columns and that of rows, turned by a right angle
    u = np.array(along) / xinc if ncol > 1 else np.zeros(2)
    u += np.array([across[1], -across[0]]) / yinc if nrow > 1 else 0.0
    return x, y, xinc, yinc, math.degrees(math.atan2(u[1], u[0]))


def _misfit(grid: Geometry, easting: np.ndarray, northing: np.ndarray) -> float:
    """Largest distance between a node and the place where the geometry puts it [m]."""
    x, y, xinc, yinc, rotation = grid
    turn = math.radians(rotation)

    # places that the geometry gives all nodes, to compare with their own
    nrow, ncol = np.broadcast_shapes(easting.shape, northing.shape)
    column, row = np.arange(ncol), np.arange(nrow)[:, None]
    if easting.shape != northing.shape:
        # axes along east and north: other rotations do not fit
        if rotation % 360.0:
            return math.inf
        east, north = x + column * xinc, y + row * yinc
    else:
        east = x + (column * xinc * math.cos(turn) - row * yinc * math.sin(turn))
        north = y + (column * xinc * math.sin(turn) + row * yinc * math.cos(turn))
    made: float = np.hypot(np.abs(east - easting).max(), np.abs(north - northing).max())
    return made
