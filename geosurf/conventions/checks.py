"""Checks of values that users pass in: words, whole numbers, numbers, arrays."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable
from numbers import Real
from typing import Any

import numpy as np

# ---- frame ----------------------------------------
# The local frame: one origin per model, subtracted from world coordinates without rounding.


# A power of two: the lowest bits of the origin are zero, so subtracting it needs no rounding.
FRAME_STEP = 1024.0
_AT_ONCE = 1 << 15  # coordinates


def frame_origin(*vertex_arrays: np.ndarray) -> np.ndarray:
    """Return the origin of the local frame of vertices, or of the corners of their box.

    The origin is a multiple of 1024 m along each horizontal axis. It is never farther from zero
    than any coordinate, and it is 0 where coordinates have both signs, so subtracting it is exact.
    The origin of elevations is always 0.

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
    # Two corners stand for a large array.
    spans = [a if len(a) <= 2 else np.stack([a.min(axis=0), a.max(axis=0)]) for a in vertex_arrays]
    rows = [row for span in spans for row in span.tolist()]  # faster than numpy for a few rows
    for axis in (0, 1) if rows else ():
        column = [row[axis] for row in rows]
        low, high = min(column), max(column)
        if math.isnan(sum(column)):  # an array without finite values
            continue
        # Towards zero from the lowest coordinate: differences have no more bits than coordinates.
        if low > 0:
            origin[axis] = low // FRAME_STEP * FRAME_STEP
        # The mirror image; with both signs the origin stays 0.
        elif high < 0:
            origin[axis] = -(-high // FRAME_STEP * FRAME_STEP)
    return origin


def shift_is_exact(values: np.ndarray, shift: float) -> bool:
    """Return whether all coordinates minus a shift are exact in float64.

    Parameters
    ----------
    values : ndarray of float64
        World coordinates along one axis [m]; NaN values are ignored.
    shift : float
        Length to subtract [m].

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

    # some rows at a time: what is made of them stays in the caches
    step = max(_AT_ONCE * len(values) // max(values.size, 1), 1)
    for first in range(0, len(values), step):
        part = values[first : first + step]
        local = part - shift
        # the rounding error of a difference, exactly (Knuth's two-sum)
        back = local - part
        error = (part - (local - back)) + (-shift - back)
        if not ((error == 0.0) | np.isnan(error)).all():
            return False
    return True


def are_points(data: Any) -> bool:
    """Whether data are a table or an array of points."""
    table = hasattr(data, "data_vars") or hasattr(data, "columns")
    return table or isinstance(data, np.ndarray | list | tuple)


def first_given(*words: Any) -> Any:
    """Return the first value that is given: neither None nor an empty text.

    Examples
    --------
    >>> first_given(None, "", "m")
    'm'
    """
    # 0 and False are given values; an empty text is what empty cells of tables contain.
    given = (word for word in words if word is not None and not (type(word) is str and not word))
    return next(given, None)


def is_word(value: Any, known: Iterable[str]) -> bool:
    """Return whether a value is a text and one of the known words; arrays and lists never are.

    Examples
    --------
    >>> is_word("up", ("up", "down")), is_word(np.array(["up", "up"]), ("up", "down"))
    (True, False)
    """
    # The type first: an array would be compared element by element.
    return isinstance(value, str) and value in known


# errors that objects of other packages raise when they are converted to an array, list or path
CONVERSION_ERRORS = (ArithmeticError, AttributeError, LookupError, RuntimeError, UserWarning)


def is_whole(value: Any) -> bool:
    """Return whether a value is an integer; booleans and time spans are not.

    Examples
    --------
    >>> is_whole(3), is_whole(np.int8(3)), is_whole(3.0), is_whole(True)
    (True, True, False, False)
    """
    # bool is a subclass of int in Python, and numpy counts time spans as integers.
    return isinstance(value, int | np.integer) and not isinstance(value, bool | np.timedelta64)


def is_number(value: Any) -> bool:
    """Return whether a value is one finite real number; booleans and texts are not.

    Examples
    --------
    >>> is_number(25), is_number(np.float32(0.5)), is_number("25"), is_number(float("nan"))
    (True, True, False, False)
    """
    plain = type(value) in (float, int)  # the usual case, and a faster check
    excluded = (bool, np.timedelta64)  # both count as numbers in Python
    known = plain or (isinstance(value, Real) and not isinstance(value, excluded))
    try:
        return known and math.isfinite(value)
    except OverflowError:  # an integer too large for a float
        return False


def real_numbers(values: Any) -> np.ndarray:
    """
    Return values as float64; refuse complex numbers, dates and time spans.

    numpy would convert those silently.

    Parameters
    ----------
    values : array_like

    Returns
    -------
    ndarray of float64
        The same object if it is a float64 array already; masked values become NaN.

    Raises
    ------
    TypeError
        For complex numbers, dates and time spans.
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
    # The usual case costs nothing: the array itself is returned.
    if type(values) is np.ndarray and values.dtype == np.float64:
        return values
    try:
        array = np.asarray(values)
        # Complex numbers, time spans and dates: numpy would drop the imaginary part, or count days.
        if array.dtype.kind in "cmM":
            raise TypeError(array.dtype)
        if "numpy.ma" in sys.modules and np.ma.isMaskedArray(values):  # importing numpy.ma is slow
            # NaN is how every stage marks a missing node.
            array = np.ma.filled(values.astype(np.float64), np.nan)
        found: np.ndarray = np.asarray(array, dtype=np.float64)
    except CONVERSION_ERRORS as error:
        raise ValueError(f"{type(error).__name__}: {error}") from error
    return found


# ---- no data ----------------------------------------
# What programs write for an absent value, whichever sign and unit it has been read with.


NO_DATA = (999.0, 999.25, 9999.0, 9999.25, 32767.0, 32768.0, 99999.0, 999999.0, 9999900.0)
HUGE = 1e19  # no length is larger: 1e20, 1e30, 1.70141e38 and the like
UNITS_OF_MARKS = (1.0, 0.3048, 1200.0 / 3937.0, 1000.0)
DEEPEST = 2e4  # m: nothing is measured below
ALONE = 1000.0  # m, and ten times the range of all others: as far from them a mark is no easting


def are_marks(values: np.ndarray, mark: float) -> np.ndarray:
    """Whether sizes of numbers are a usual mark, in some unit."""
    return np.isclose(values[..., None], np.multiply(mark, UNITS_OF_MARKS), 1e-7, 0.0).any(axis=-1)


def no_data_in(points: np.ndarray, elevations: bool = True) -> tuple[int, float] | None:
    """Return the first of some places that holds a usual mark of no data, and the mark; or None.

    A huge number counts everywhere, another mark as elevation. 999 and 9999 may be measured: they
    count if easting and northing are the same, and 9999 also if no other point is within 100 m in
    depth. As easting or northing a mark counts if it lies far from all others.

    Parameters
    ----------
    points : ndarray of float64, shape (n, 3)
    elevations : bool
        Whether marks count as elevation that may be measured, such as 999.25.

    Examples
    --------
    >>> no_data_in(np.array([[500.0, 520, -999.0], [500, 560, -999.25]]))
    (1, 999.25)
    >>> no_data_in(np.array([[500.0, 520, -999.0], [-999, -999, -999]]))
    (1, 999.0)
    >>> no_data_in(np.array([[500.0, 520, -3040.1], [500, 560, -3047.6952]]))  # 9999 ft
    >>> no_data_in(np.array([[460100.0, 520, -2000.0], [-999.25, 560, -2010.0]]))
    (1, 999.25)
    """
    size = np.abs(points)
    huge = size >= HUGE
    if huge.any():
        row = int(np.flatnonzero(huge.any(axis=1))[0])
        return row, float(size[row].max())
    alike = (np.ptp(size, axis=1) == 0.0) if len(size) else np.zeros(0, dtype=bool)
    for mark in NO_DATA:
        held = are_marks(size[:, 2], mark)
        if mark == 9999.0:
            others, z = np.sort(points[~held, 2]), points[held, 2]
            alike[held] |= np.searchsorted(others, z - 100.0) == np.searchsorted(others, z + 100.0)
        wrong = held & (alike if mark in (999.0, 9999.0) else True)
        if not (elevations or mark > DEEPEST):
            wrong[:] = False
        for axis in (0, 1):
            wrong |= _are_alone(points[:, axis], are_marks(size[:, axis], mark))
        rows = np.flatnonzero(wrong)
        if len(rows):
            return int(rows[0]), mark
    return None


def _are_alone(values: np.ndarray, held: np.ndarray) -> np.ndarray:
    """Which of some held values are far from all others, in the range of these."""
    rest = values[~held]
    if not held.any() or not len(rest):
        return np.zeros(len(values), dtype=bool)
    low, high = float(rest.min()), float(rest.max())
    far = np.maximum(low - values, values - high)
    found: np.ndarray = held & (far > max(10.0 * (high - low), ALONE))
    return found
