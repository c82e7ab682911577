"""Axes, signs, units and the one frame: rules that every room obeys.

- Right-handed, metres, elevation positive up. Depth is turned at the reader.
- A gridded horizon is an `xarray.DataArray`; its first dimension runs north for
  an unrotated grid, its second runs east: dims ``("northing", "easting")``.
- One diagonal splits all cells of a grid: see `rising_diagonal`.
- Geometry is computed in a local frame: world coordinates minus one origin, a
  multiple of 1024 m on each horizontal axis, chosen so that the shift is exact.
"""

from __future__ import annotations

import difflib
import math
import sys
from collections.abc import Iterable
from numbers import Real
from typing import Any

import numpy as np

from geosurf.errors import InputError

HORIZON_DIMS = ("northing", "easting")
FAULT_DIMS = ("down_dip", "along_strike")
FRAME_STEP = 1024.0

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
    "us_survey_foot": 1200.0 / 3937.0,
    "ftus": 1200.0 / 3937.0,
}


def metres_per_unit(length_unit: str | None, what: str) -> float:
    """Return the factor from a length unit to metres.

    Parameters
    ----------
    length_unit : str or None
        Its name, as in CF attributes: ``"m"``, ``"ft"``, ``"km"`` ...
    what : str
        What carries the unit, for the message: ``"horizon 'Top'"``.

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
    factor = (
        METRES_PER_UNIT.get(length_unit.strip().lower()) if isinstance(length_unit, str) else None
    )
    if factor is None:
        known = ", ".join(sorted(METRES_PER_UNIT))
        raise InputError(
            f"{what}: unknown length unit {length_unit!r}. "
            f"Set attrs['units'] or length_unit= to one of {known}."
        )
    return factor


def elevation_sign(positive: str | None, what: str) -> float:
    """Return +1.0 for elevations and -1.0 for depths, or say how to tell which.

    Parameters
    ----------
    positive : {"up", "down"} or None
        Direction in which the values grow, as in the CF attribute.
    what : str
        What carries the values, for the message.

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
    if is_word(positive, ("up", "down")):
        return 1.0 if positive == "up" else -1.0
    found = "is not said" if positive is None else f"is {positive!r}"
    raise InputError(
        f"{what}: whether values are elevation or depth {found}. Say positive='up' (elevation) "
        "or positive='down' (depth), as an argument or as attrs['positive']."
    )


def frame_origin(*vertex_arrays: np.ndarray) -> np.ndarray:
    """Return the origin of the local frame for some vertices, or for corners around them.

    The origin is a multiple of 1024 m, never farther from zero than any of the
    coordinates, and 0 where they straddle zero: so subtracting it is exact.
    Elevations keep their own zero.

    Parameters
    ----------
    *vertex_arrays : ndarray of float64, shape (n_vertex, 2 or 3)
        World coordinates [m], finite.

    Returns
    -------
    ndarray of float64, shape (3,)

    Examples
    --------
    >>> frame_origin(np.array([[456000.5, 6780000.25, -2000.0]]))
    array([ 455680., 6779904.,       0.])
    """
    origin = np.zeros(3)
    spans = [a if len(a) <= 2 else np.stack([a.min(axis=0), a.max(axis=0)]) for a in vertex_arrays]
    rows = [row for span in spans for row in span.tolist()]  # few: numpy takes longer
    for axis in (0, 1) if rows else ():
        column = [row[axis] for row in rows]
        low, high = min(column), max(column)
        if math.isnan(sum(column)):  # of nothing
            continue
        if low > 0:
            origin[axis] = low // FRAME_STEP * FRAME_STEP
        elif high < 0:
            origin[axis] = -(-high // FRAME_STEP * FRAME_STEP)
    return origin


def rising_diagonal(easting: np.ndarray, northing: np.ndarray) -> bool:
    """Return which diagonal splits the cells of a gridded horizon: the diagonal rule.

    Of the two diagonals of a cell, the one that runs from south-west to
    north-east: the one with the larger ``dx * dy``, summed over all cells. Where
    the two agree to a part in a million (square cells, turned by 45 degrees), the
    one that runs north, with the larger ``dy * dy``; where that ties too (a full
    ring), the westernmost cell decides. The rule asks for directions in the world,
    so rows and columns may be reversed or transposed.

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
    if x.ndim == 1:
        n, m = len(x) - 1, len(y) - 1
        return bool((x.item(n) > x.item(0)) == (y.item(m) > y.item(0)))
    gain, reach, size = _gain_of_diagonals(x, y)
    if abs(gain) - reach > 1e-3 * size and size < 1e150:  # so clear that no rounding matters
        return gain > 0
    return _rising_by_every_cell(x, y)


def _gain_of_diagonals(x: np.ndarray, y: np.ndarray) -> tuple[float, float, float]:
    """Sum over cells of ``dx * dy`` along one diagonal less the other; how far it may be off; and
    no less than all squares.
    """
    from geosurf.kernels.lattices.cell_bounds import EDGES, GAIN, REACH
    from geosurf.kernels.lattices.survey import survey_lattice
    from geosurf.kernels.search.tree import N_PLACE

    n_row, n_col = x.shape
    places = np.zeros(N_PLACE, dtype=np.int64)  # the second coordinate is one zero
    places[[1, 2, 7, 8, 9, 10]] = n_col, 1, n_col, 1, n_row, n_col
    flat = np.ascontiguousarray(x).reshape(-1), np.zeros(1), np.ascontiguousarray(y).reshape(-1)
    _, _, _, sums = survey_lattice(*flat, places, True)
    # squared diagonals of a cell are at most its squared edges (Euler)
    return float(sums[GAIN]), float(sums[REACH]), float(sums[EDGES])


def _rising_by_every_cell(x: np.ndarray, y: np.ndarray) -> bool:
    """The rule of `rising_diagonal`, word for word."""
    rising = np.stack([x[1:, 1:] - x[:-1, :-1], y[1:, 1:] - y[:-1, :-1]], axis=-1)
    falling = np.stack([x[1:, :-1] - x[:-1, 1:], y[1:, :-1] - y[:-1, 1:]], axis=-1)
    whole = np.isfinite(rising).all(axis=-1) & np.isfinite(falling).all(axis=-1)
    if not whole.any():
        return True
    choice = _compare_diagonals(rising[whole], falling[whole])
    if choice == 0:
        # summed in pairs of opposite corners, so that the order of corners is not seen
        west = ((x[1:, 1:] + x[:-1, :-1]) + (x[1:, :-1] + x[:-1, 1:]))[whole]
        south = ((y[1:, 1:] + y[:-1, :-1]) + (y[1:, :-1] + y[:-1, 1:]))[whole]
        first = np.lexsort((south, west))[:1]
        choice = _compare_diagonals(rising[whole][first], falling[whole][first])
    return choice >= 0


def _compare_diagonals(rising: np.ndarray, falling: np.ndarray) -> int:
    """+1 or -1: which diagonals (n_cell, 2) run more to the north-east, or else north; 0: a tie."""
    terms = (
        (rising[:, 0] * rising[:, 1], falling[:, 0] * falling[:, 1]),
        (rising[:, 1] ** 2, falling[:, 1] ** 2),
    )
    size = float((rising**2).sum() + (falling**2).sum())
    for plus, minus in terms:
        gain = float(plus.sum() - minus.sum())
        if abs(abs(gain) - 1e-6 * size) < 1e-9 * size:
            # so close to the limit that the order of cells could tell: sums of one rounding
            size = math.fsum((rising**2).ravel()) + math.fsum((falling**2).ravel())
            gain = math.fsum(plus) - math.fsum(minus)
        if abs(gain) > 1e-6 * size:
            return 1 if gain > 0 else -1
    return 0


def shift_is_exact(values: np.ndarray, shift: float) -> bool:
    """Return whether coordinates minus a shift are all representable without rounding.

    Parameters
    ----------
    values : ndarray of float64
        World coordinates along one axis [m]; those that are not numbers are passed over.
    shift : float
        [m]

    Returns
    -------
    bool

    Examples
    --------
    >>> shift_is_exact(np.array([456000.1]), 455680.0)
    True
    >>> shift_is_exact(np.array([1e-9]), 1024.0)
    False
    """
    if shift == 0.0:
        return True
    local = values - shift
    # the rounding error of a difference, exactly (Knuth's two-sum)
    back = local - values
    error = (values - (local - back)) + (-shift - back)
    return bool(((error == 0.0) | np.isnan(error)).all())


def did_you_mean(word: Any, known: Iterable[str]) -> str:
    """Return ' Did you mean ...?' for a misspelt word, or ''.

    Examples
    --------
    >>> did_you_mean("horizns", ["horizons", "faults"])
    " Did you mean 'horizons'?"
    """
    close = difflib.get_close_matches(str(word), [str(one) for one in known], n=1)
    return f" Did you mean {close[0]!r}?" if close else ""


def counted(n: int, word: str) -> str:
    """Return how many there are, with the word in the plural where it should be.

    Examples
    --------
    >>> counted(1, "curve"), counted(0, "fault"), counted(2, "patch")
    ('1 curve', '0 faults', '2 patches')
    """
    ending = "" if n == 1 else "es" if word.endswith("ch") else "s"
    return f"{n} {word}{ending}"


def first_said(*words: Any) -> Any:
    """Return the first of some words that is given: neither None nor an empty text.

    Examples
    --------
    >>> first_said(None, "", "m")
    'm'
    """
    said = (word for word in words if word is not None and not (type(word) is str and not word))
    return next(said, None)


def is_word(value: Any, known: Iterable[str]) -> bool:
    """Return whether a value is one of some words; arrays and lists are none, whatever they hold.

    Examples
    --------
    >>> is_word("up", ("up", "down")), is_word(np.array(["up", "up"]), ("up", "down"))
    (True, False)
    """
    return isinstance(value, str) and value in known


# what objects of other packages raise when they are taken for an array, a list, or a path
STRANGE = (ArithmeticError, AttributeError, LookupError, RuntimeError, UserWarning)


def is_whole(value: Any) -> bool:
    """Return whether a value is a whole number: no truth value, no span of time.

    Examples
    --------
    >>> is_whole(3), is_whole(np.int8(3)), is_whole(3.0), is_whole(True)
    (True, True, False, False)
    """
    return isinstance(value, int | np.integer) and not isinstance(value, bool | np.timedelta64)


def is_number(value: Any) -> bool:
    """Return whether a value is one finite real number (no truth value, no text).

    Examples
    --------
    >>> is_number(25), is_number(np.float32(0.5)), is_number("25"), is_number(float("nan"))
    (True, True, False, False)
    """
    plain = type(value) in (float, int)  # most are; a question to an abstract class costs more
    none = (bool, np.timedelta64)  # the one is an int, the other calls itself a number
    known = plain or (isinstance(value, Real) and not isinstance(value, none))
    try:
        return known and math.isfinite(value)
    except OverflowError:  # a whole number that no float holds
        return False


def real_numbers(values: Any) -> np.ndarray:
    """
    Return values as float64; what numpy would turn into some number, though it is none, is refused.

    Parameters
    ----------
    values : array_like

    Returns
    -------
    ndarray of float64
        The array itself if it is one; values under a mask are not-a-number.

    Raises
    ------
    TypeError
        For complex numbers, dates and spans of time.
    ValueError
        For words, and rows of several lengths.

    Examples
    --------
    >>> real_numbers([1, 2])
    array([1., 2.])
    >>> real_numbers(np.array(["2001-01-01"], dtype="datetime64[D]"))
    Traceback (most recent call last):
    TypeError: datetime64[D]
    """
    if type(values) is np.ndarray and values.dtype == np.float64:
        return values
    try:
        array = np.asarray(values)
        if array.dtype.kind in "cmM":
            raise TypeError(array.dtype)
        if "numpy.ma" in sys.modules and np.ma.isMaskedArray(values):  # takes long to import
            array = np.ma.filled(values.astype(np.float64), np.nan)
        found: np.ndarray = np.asarray(array, dtype=np.float64)
    except STRANGE as error:
        raise ValueError(f"{type(error).__name__}: {error}") from error
    return found


def place(point: Iterable[float]) -> str:
    """Return coordinates as people read them, for messages.

    Examples
    --------
    >>> place((456000.125, 6780000.5, -2000))
    '(easting 456000.125, northing 6780000.500, elevation -2000.000)'
    """
    x, y, z = (float(c) for c in point)
    return f"(easting {x:.3f}, northing {y:.3f}, elevation {z:.3f})"
