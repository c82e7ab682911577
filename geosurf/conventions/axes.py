"""Axes of grids, the sign of elevation, and the diagonal that splits grid cells."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

import numpy as np

from geosurf.conventions.checks import is_word, real_numbers
from geosurf.errors import InputError

# ---- length units ----------------------------------------
# Length units that geosurf accepts, and their size in metres.


# metres per unit, for every spelling that is accepted in files and attributes
METRES_PER_UNIT = {
    "m": 1.0,
    "metre": 1.0,
    "metres": 1.0,
    "meter": 1.0,
    "meters": 1.0,
    "km": 1000.0,
    "ft": 0.3048,
    "foot": 0.3048,
    "feet": 0.3048,
    # By its definition of 1893: 1200/3937 m, longer than a foot by two parts in a million.
    "us_survey_foot": 1200.0 / 3937.0,
    "ftus": 1200.0 / 3937.0,
    "u.s. ft": 1200.0 / 3937.0,
    "us ft": 1200.0 / 3937.0,
}


# milliseconds per unit of time, in scenes that are in time
MS_PER_UNIT = {"ms": 1.0, "msec": 1.0, "s": 1000.0, "sec": 1000.0}


class TimeUnit(str):
    """A unit of time in place of a length unit: inside, milliseconds stand for metres.

    Only a scene that states ``time=`` makes one, so nothing else takes times for lengths.
    """

    __slots__ = ()


def is_time_unit(unit: object) -> bool:
    """Return whether a unit is one of time.

    Examples
    --------
    >>> is_time_unit("ms"), is_time_unit("m"), is_time_unit(None)
    (True, False, False)
    """
    return isinstance(unit, str) and unit.strip().lower() in MS_PER_UNIT


def need_depth(time: str | None, what: str) -> None:
    """Refuse what milliseconds have not."""
    if time is not None:
        raise InputError(
            f"the scene is in time, and {what} need depth. Give velocities: "
            "scene.replace(velocity={...}), in m/s by zone."
        )


VERTICAL = ("elevation", "depth", "two-way", "one-way")
_shown: ContextVar[str] = ContextVar("shown", default="elevation")


@contextmanager
def vertical_axis(shown: str | None) -> Iterator[None]:
    """Let pictures inside the ``with`` block show one of `VERTICAL`; None: as they do already."""
    token = _shown.set(shown or _shown.get())
    try:
        yield
    finally:
        _shown.reset(token)


def vertical_words(what: str = "Elevation") -> tuple[str, str]:
    """
    Return the name of a vertical quantity, and its unit.

    Examples
    --------
    >>> with vertical_axis("two-way"):
    ...     vertical_words(), vertical_words("Throw")
    (('Two-way time', 'ms'), ('Throw', 'ms'))
    >>> vertical_words()
    ('Elevation', 'm')
    """
    shown = _shown.get()
    unit = "m" if shown in VERTICAL[:2] else "ms"
    if what != "Elevation":
        return what, unit
    return shown.capitalize() if unit == "m" else f"{shown.capitalize()} time", unit


def vertical_label(what: str = "Elevation") -> str:
    """Return the label of a vertical axis, with its unit."""
    return "{} [{}]".format(*vertical_words(what))


def vertical_sign(label: str) -> float:
    """Return -1 if numbers next to a label grow downwards, as depths and times do; else 1.

    Examples
    --------
    >>> with vertical_axis("depth"):
    ...     vertical_sign("Depth [m]"), vertical_sign("Throw [m]")
    (-1.0, 1.0)
    """
    return -1.0 if label == vertical_label() and _shown.get() != VERTICAL[0] else 1.0


def metres_per_unit(length_unit: str | None, what: str) -> float:
    """Return the factor from a length unit to metres; from a `TimeUnit` to milliseconds.

    Parameters
    ----------
    length_unit : str or None
        Its name, as in CF attributes: ``"m"``, ``"ft"``, ``"km"`` ...
    what : str
        Name of the object that carries the unit, for the message: ``"horizon 'Top'"``.

    Returns
    -------
    float

    Raises
    ------
    InputError
        If the unit is missing or unknown.

    Examples
    --------
    >>> metres_per_unit("ft", "horizon 'Top'")
    0.3048
    """
    if length_unit is None:
        raise InputError(
            f"{what}: the length unit is missing. Set attrs['units'] = 'm' or length_unit='m'."
        )
    # Case and spaces do not matter; anything but text is refused like an unknown word.
    factor = (
        METRES_PER_UNIT.get(length_unit.strip().lower()) if isinstance(length_unit, str) else None
    )
    if isinstance(length_unit, TimeUnit):
        return MS_PER_UNIT[length_unit.strip().lower()]
    if is_time_unit(length_unit):
        raise InputError(
            f"{what} is in time ({length_unit}). State how it counts, and give velocities: "
            'geosurf.Scene(..., time="two-way", length_unit="ms", velocity={...}), or "one-way". '
            "Give files as paths."
        )
    if factor is None:
        known = ", ".join(sorted(METRES_PER_UNIT))
        raise InputError(
            f"{what}: unknown length unit {length_unit!r}. "
            f"Set attrs['units'] or length_unit= to one of {known}."
        )
    return factor


def metres_of(part: Any, what: str) -> np.ndarray:
    """Values of a DataArray [m], by its own unit of length; without one they are metres."""
    factor = metres_per_unit(part.attrs.get("units", "m"), what)
    try:
        return real_numbers(part.values) * factor
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{what} has values of dtype {part.dtype}, expected metres. Convert them to float."
        ) from error


# ---- feet taken for metres ----------------------------------------
# Horizons of one field have much the same shape: where one has three times the relief of another,
# its heights are probably in feet.


FOOT = METRES_PER_UNIT["ft"]
RELIEF_IN_FEET = (2.6, 4.0)  # ratio of reliefs that a foot taken for a metre explains
ALIKE = 0.9  # correlation from which one horizon follows another
CELLS = 40  # along each side of the rectangle that horizons are compared in
FEWEST_CELLS = 10


def cell_means(points: np.ndarray, frame: tuple[float, float, float, float]) -> np.ndarray:
    """Mean z in each cell of a frame (west, south, width, height); NaN in cells without points."""
    west, south, width, height = frame
    # Points on the last rim belong to the last cell.
    column = np.clip((points[:, 0] - west) / width * CELLS, 0, CELLS - 1).astype(np.int64)
    row = np.clip((points[:, 1] - south) / height * CELLS, 0, CELLS - 1).astype(np.int64)
    at = row * CELLS + column
    count = np.bincount(at, minlength=CELLS * CELLS)
    total = np.bincount(at, weights=points[:, 2], minlength=CELLS * CELLS)
    # Empty cells are NaN, so that comparisons leave them out.
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def frame_around(clouds: Sequence[np.ndarray]) -> tuple[float, float, float, float]:
    """West, south, width and height around points."""
    low = np.min([p[:, :2].min(axis=0) for p in clouds], axis=0)
    high = np.max([p[:, :2].max(axis=0) for p in clouds], axis=0)
    # A line of points still gets cells.
    width, height = np.maximum(high - low, 1.0)
    return float(low[0]), float(low[1]), float(width), float(height)


def likeness(one: np.ndarray, other: np.ndarray) -> float:
    """Correlation of two horizons, of both: `cell_means`; 0 where these tell nothing."""
    both = np.isfinite(one) & np.isfinite(other)
    # Too few shared cells, or a flat horizon, tell nothing about relief.
    if both.sum() < FEWEST_CELLS or not np.ptp(one[both]) or not np.ptp(other[both]):
        return 0.0
    return float(np.corrcoef(one[both], other[both])[0, 1])


def relief_in_feet(means: np.ndarray, others: Iterable[np.ndarray]) -> float:
    """How many times larger the relief of a horizon is than that of another one of the same shape,
    0 if not as feet are. Of both: `cell_means`.
    """
    for other in others:
        both = np.isfinite(means + other)
        low, high = RELIEF_IN_FEET
        # In depth or in elevation: whether a horizon is upside down is another question.
        if abs(likeness(means, other)) > ALIKE:
            ratio = np.std(means[both]) / np.std(other[both])
            if low < ratio < high:
                return float(ratio)
    return 0.0


# ---- column names ----------------------------------------
# Usual names of columns of tables of points and lines, in lower case.


# easting, northing and z
USUAL = {
    "x": ("x", "x_utme", "easting", "east"),
    "y": ("y", "y_utmn", "northing", "north"),
    "z": ("z", "z_tvdss", "tvdss", "elevation", "depth"),
}
# number of the line that a point belongs to
LABELS = ("poly_id", "stick_id", "stick", "segment_id", "segment")


# Rows before columns, as in the arrays of numpy: the first dimension runs north.
HORIZON_DIMS = ("northing", "easting")
FAULT_DIMS = ("down_dip", "along_strike")


def meaning(words: str, unit: str = "") -> dict[str, str]:
    """Return the attributes of a variable: its unit of measure, if it has one, and what it is."""
    return {"units": unit, "long_name": words} if unit else {"long_name": words}


COORDINATES = ("easting", "northing", "elevation")  # in the order of the columns of points


def points_in(data: Any) -> np.ndarray:
    """Return the places (n, 3) of what has its coordinates by name: a table, or a Dataset."""
    return np.stack([np.ravel(np.asarray(data[axis])) for axis in COORDINATES], axis=1)


# names of the two coordinates of a grid, in lower case; CF has x and y for their axes, too
MAP_NAMES = {
    "easting": ("easting", "x", "e", "utm_easting", "projection_x_coordinate"),
    "northing": ("northing", "y", "n", "utm_northing", "projection_y_coordinate"),
}


def map_coordinates(data: Any) -> dict[str, list[Any]]:
    """Return the coordinates of a grid of xarray that are easting and northing, by what they state.

    By their name, ``standard_name``, ``long_name`` or ``axis``, the first of these that any has.
    Of ``easting`` and ``x`` it is ``easting``: the other one may count rows.
    """
    by_axis: dict[str, list[Any]] = {}
    said = [(str(name).lower(), coord.attrs, coord) for name, coord in data.coords.items()]
    for key, names in MAP_NAMES.items():
        named = [[coord for word, _, coord in said if word == name] for name in names]
        stated = [
            [coord for _, attrs, coord in said if str(attrs.get(what, "")).lower() in names]
            for what in ("standard_name", "long_name", "axis")
        ]
        by_axis[key] = next(filter(None, [*named, *stated]), [])
    return by_axis


def on_map_axes(data: Any) -> Any:
    """Return a grid of xarray over northing and easting, where its coordinates say which they are.

    Rows run north; anything else is returned as it is, for those who say what is wrong with it.
    """
    if tuple(data.dims) == HORIZON_DIMS:
        return data
    places = {key: found for key, found in map_coordinates(data).items() if len(found) == 1}
    if len(places) < 2:
        return data
    for key, (coord,) in places.items():
        if coord.ndim == 1 and coord.name not in data.dims:
            data = data.drop_vars(coord.dims[0], errors="ignore").swap_dims(
                {coord.dims[0]: coord.name}
            )
        data = data if coord.name == key else data.rename({coord.name: key})
    return data.transpose(*HORIZON_DIMS) if set(data.dims) == set(HORIZON_DIMS) else data


def elevation_sign(positive: str | None, what: str) -> float:
    """Return the factor from values to elevation: +1.0 for elevations, -1.0 for depths.

    Parameters
    ----------
    positive : {"up", "down"} or None
        Direction in which the values grow, as in the CF attribute.
    what : str
        Name of the object that carries the values, for the message.

    Returns
    -------
    float

    Raises
    ------
    InputError
        If the direction is missing or unknown.

    Examples
    --------
    >>> elevation_sign("down", "horizon 'Top'")
    -1.0
    """
    # Depth or elevation is never guessed: the wrong sign would mirror the field.
    if is_word(positive, ("up", "down")):
        return 1.0 if positive == "up" else -1.0
    question = (
        "are the values depth or elevation?" if positive is None else f"positive is {positive!r}."
    )
    raise InputError(
        f"{what}: {question} Set positive='down' (depth) or positive='up' (elevation): an "
        "argument, attrs['positive'], a key of the scenario, or --positive."
    )


def rising_diagonal(easting: np.ndarray, northing: np.ndarray) -> bool:
    """Return which diagonal splits the cells of a gridded horizon: the diagonal rule.

    The rule takes the diagonal that runs from south-west to north-east: the one with the larger
    ``dx * dy``, summed over all cells. If the two agree to a part in a million (square cells,
    rotated by 45 degrees), it takes the one that runs north, with the larger ``dy * dy``. If that
    ties too (a full ring), the westernmost cell decides. The rule depends on directions in the
    world only, so rows and columns may be reversed or transposed.

    Parameters
    ----------
    easting, northing : ndarray of float64
        World coordinates [m]: 1-D ``(n_col,)`` and ``(n_row,)``, or both 2-D
        ``(n_row, n_col)``; nodes that are not finite are left out.

    Returns
    -------
    bool
        True for node ``(i, j)`` to ``(i + 1, j + 1)``, as in `Lattice.rising`.

    Examples
    --------
    >>> rising_diagonal(np.array([0.0, 50.0]), np.array([0.0, 50.0]))
    True
    >>> rising_diagonal(np.array([50.0, 0.0]), np.array([0.0, 50.0]))
    False
    """
    x, y = easting, northing
    # Straight axes: all cells are alike, and the end nodes tell how both axes run.
    if x.ndim == 1:
        n, m = len(x) - 1, len(y) - 1
        return bool((x.item(n) > x.item(0)) == (y.item(m) > y.item(0)))
    # Both diagonals of each cell as vectors in the map.
    rising = np.stack([part[1:, 1:] - part[:-1, :-1] for part in (x, y)])
    falling = np.stack([part[1:, :-1] - part[:-1, 1:] for part in (x, y)])
    whole = np.isfinite(rising[0] + rising[1] + falling[0] + falling[1])
    # No cell, no triangle: either answer will do.
    if not whole.any():
        return True
    choice = _compare_diagonals(rising[:, whole], falling[:, whole])
    # Both rules tie: the westernmost cell, and of several the southernmost, decides for all.
    if choice == 0:
        # sums over pairs of opposite corners do not depend on the order of corners
        west = ((x[1:, 1:] + x[:-1, :-1]) + (x[1:, :-1] + x[:-1, 1:]))[whole]
        south = ((y[1:, 1:] + y[:-1, :-1]) + (y[1:, :-1] + y[:-1, 1:]))[whole]
        first = np.lexsort((south, west))[:1]
        choice = _compare_diagonals(rising[:, whole][:, first], falling[:, whole][:, first])
    return choice >= 0


def _compare_diagonals(rising: np.ndarray, falling: np.ndarray) -> int:
    """Return +1 or -1 for the diagonals (2, n_cell) that run more to the north-east; 0 for a tie.

    Where the two agree to a part in a million, the diagonals that run more to the north win.
    """
    terms = ((rising[0] * rising[1], falling[0] * falling[1]), (rising[1] ** 2, falling[1] ** 2))
    # The scale of a part in a million.
    size = float((rising**2).sum() + (falling**2).sum())
    # First the diagonal that runs more to the north-east, then the one more to the north.
    for plus, minus in terms:
        gain = float(plus.sum() - minus.sum())
        if abs(abs(gain) - 1e-6 * size) < 1e-9 * size:
            # close to the limit, the order of cells could decide: sum with one rounding only
            size = math.fsum((rising**2).ravel()) + math.fsum((falling**2).ravel())
            gain = math.fsum(plus) - math.fsum(minus)
        if abs(gain) > 1e-6 * size:
            return 1 if gain > 0 else -1
    return 0
