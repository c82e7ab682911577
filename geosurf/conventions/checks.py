"""Checks of values that users pass in: words, whole numbers, numbers, arrays."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Iterator, Sequence
from numbers import Real
from typing import Any

import numpy as np

from geosurf.errors import InputError

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
        numbers: np.ndarray = np.asarray(array, dtype=np.float64)
    except CONVERSION_ERRORS as error:
        raise ValueError(f"{type(error).__name__}: {error}") from error
    return numbers


def checked_points(
    values: Any,
    what: str,
    how: str,
    *,
    widths: Sequence[int] = (3,),
    least: int = 0,
    error: type[Exception] = InputError,
) -> np.ndarray:
    """
    Return points as float64 (n, width), finite; or an error with what is wrong, and where.

    Parameters
    ----------
    values : array_like
    what : str
        What messages call it, such as ``"stick 3"``.
    how : str
        A sentence on what to give instead.
    widths : sequence of int
        How many columns there may be.
    least : int
        Fewer points are refused.
    error : type

    Examples
    --------
    >>> checked_points([[1, 2]], "stick 3", "Give easting, northing, elevation.")
    Traceback (most recent call last):
    geosurf.errors.InputError: stick 3 has shape (1, 2), expected (n, 3). Give easting, northing, \
elevation.
    """
    try:
        points = real_numbers(values)
    except (TypeError, ValueError) as reason:
        raise error(f"{what} is not a numeric array ({reason}). {how}") from reason
    if points.ndim != 2 or points.shape[1] not in widths or len(points) < least:
        allowed = " or ".join(f"(n, {width})" for width in widths)
        allowed += f" with {least} points or more" if least > 1 else ""
        raise error(f"{what} has shape {points.shape}, expected {allowed}. {how}")
    if not np.isfinite(points).all():  # at once: row by row takes ten times as long
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        raise error(
            f"{what} has values that are not finite: {len(bad)} of {len(points)} points, the first "
            f"is point {bad[0]}, {points[bad[0]].tolist()}. Leave out points that are undefined."
        )

    # + 0.0 turns -0.0 into 0.0, so that equal coordinates have equal bytes
    return points + 0.0


# ---- no data ----------------------------------------
# What programs write for an absent value, whichever sign and unit it has been read with.


NO_DATA = (999.0, 999.25, 9999.0, 9999.25, 32767.0, 32768.0, 99999.0, 999999.0, 9999900.0)
HUGE = 1e19  # no length is larger: 1e20, 1e30, 1.70141e38 and the like
UNITS_OF_MARKS = (1.0, 0.3048, 1200.0 / 3937.0, 1000.0)
DEEPEST = 2e4  # m: nothing is measured below
ALONE = 1000.0  # m, and ten times the range of all others: as far from them a mark is no easting


def are_marks(values: np.ndarray, mark: float) -> np.ndarray:
    """Whether sizes of numbers are a usual mark, in some unit."""
    made: np.ndarray = np.isclose(
        values[..., None], np.multiply(mark, UNITS_OF_MARKS), 1e-7, 0.0
    ).any(axis=-1)
    return made


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


# ---- foreign ----------------------------------------
# Places and lines in objects of other packages: by what they have, without importing anything.
#
# xtgeo `Polygons`, geopandas `GeoDataFrame` and `GeoSeries`, geometries of shapely, and points of
# pyvista. Third coordinates are elevations. Those of xtgeo are depths more often than not, and it
# does not state it: they are refused where they count.


# ---- outlines ----------------------------------------
# Polygons on the map: which sides are one straight line, since exports have many short ones.


def straight_runs(outline: np.ndarray, near: float) -> list[list[int]]:
    """
    Return the sides of a polygon in runs that are straight to within a distance.

    Parameters
    ----------
    outline : ndarray of float64, shape (n, 2)
        Corners.
    near : float
        How far corners of a run may be off its line.

    Returns
    -------
    list of list of int
        Numbers of sides; side k follows corner k.

    Examples
    --------
    >>> square = np.array([[0.0, 0], [2, 0], [4, 0], [4, 4], [0, 4], [0, 2]])
    >>> straight_runs(square, 0.1)
    [[3], [4, 5], [0, 1], [2]]
    """
    n = len(outline)
    # begin at the corner that is farthest from the first one: no run goes on across it
    start = int(np.hypot(*(outline - outline[0]).T).argmax())
    ring = [(start + k) % n for k in range(n + 1)]
    runs, first = [], 0
    for last in range(1, n + 1):
        if last < n and _off(outline[ring[first : last + 2]]) <= near:
            continue
        runs.append(ring[first:last])
        first = last
    return runs


def _off(corners: np.ndarray) -> float:
    """Largest distance of corners from the line between the first and last of them [m]."""
    chord = corners[-1] - corners[0]
    from_first = corners[1:-1] - corners[0]
    length = np.hypot(*chord)
    if not length:
        return np.inf
    along = from_first @ chord / length
    # a line that turns back is not straight
    if (np.diff(along, prepend=0.0, append=length) < 0).any():
        return np.inf
    return float(np.abs(chord[0] * from_first[:, 1] - chord[1] * from_first[:, 0]).max() / length)


MANY = "geoms"  # of a geometry with several parts
UNSTATED = (
    "does not state whether z is elevation or depth; give an array of its columns, positive up"
)


def points_of_foreign(value: Any) -> np.ndarray | None:
    """
    Return the points of an object of another package (n, 3); None for anything else.

    Parameters
    ----------
    value : object

    Raises
    ------
    ValueError
        If it holds something else than points in space.

    Examples
    --------
    >>> class Cloud:  # as pyvista has it
    ...     points, n_points = [[0, 0, 5], [1, 0, 6]], 2
    >>> points_of_foreign(Cloud()).tolist()
    [[0.0, 0.0, 5.0], [1.0, 0.0, 6.0]]
    >>> points_of_foreign([[0, 0, 5]]) is None
    True
    """
    if _is_xtgeo(value):
        raise ValueError(f"{type(value).__name__} of xtgeo {UNSTATED}")
    if hasattr(value, "points") and hasattr(value, "n_points"):
        return np.asarray(value.points, dtype=np.float64).reshape(-1, 3)
    geometries = _geometries(value)
    if geometries is None:
        return None
    rows = [np.asarray(one.coords, dtype=np.float64) for one in geometries if _is(one, "Point")]
    if len(rows) < len(geometries) or any(row.shape != (1, 3) for row in rows):
        raise ValueError(f"{type(value).__name__} holds something else than points in space")
    return np.concatenate(rows) if rows else np.empty((0, 3))


def lines_of_foreign(value: Any, *, on_map: bool = False) -> list[np.ndarray] | None:
    """
    Return lines and rings of an object of another package; None for anything else.

    Parameters
    ----------
    value : object
    on_map : bool
        Whether third coordinates do not count.

    Returns
    -------
    list of ndarray of float64, each (n, 2) or (n, 3)
        Of polygons the ring around them.

    Raises
    ------
    ValueError
        If it holds something else than lines and polygons, or a polygon has holes.

    Examples
    --------
    >>> class Line:  # as shapely has it
    ...     geom_type, coords = "LineString", [(0, 0), (5, 0)]
    >>> lines_of_foreign(Line())[0].tolist()
    [[0.0, 0.0], [5.0, 0.0]]
    """
    if _is_xtgeo(value):
        if not hasattr(value, "pname"):
            raise ValueError("Points of xtgeo are not lines")
        table = value.get_dataframe()
        points, ids = _columns(value, table), np.asarray(table[value.pname])
        if points[:, 2].any() and not on_map:
            raise ValueError(f"{type(value).__name__} of xtgeo {UNSTATED}")
        return [points[ids == k] for k in dict.fromkeys(ids.tolist())]
    geometries = _geometries(value)
    if geometries is None:
        return None
    lines = []
    for geometry in geometries:
        if _is(geometry, "Polygon") and len(geometry.interiors):
            raise ValueError("a polygon has holes")
        if not _is(geometry, "Polygon", "LineString", "LinearRing"):
            raise ValueError(f"a geometry is a {geometry.geom_type}, not a line or polygon")
        ring = geometry.exterior if _is(geometry, "Polygon") else geometry
        lines.append(np.asarray(ring.coords, dtype=np.float64))
    return lines


def crs_of_foreign(value: Any) -> str | None:
    """
    Return the reference system of an object of geopandas, as a text; None without one.

    Parameters
    ----------
    value : object

    Examples
    --------
    >>> crs_of_foreign([[0, 0, 5]]) is None
    True
    """
    crs = getattr(value, "crs", None) if hasattr(value, "geometry") else None
    return None if crs is None else str(crs.to_string() if hasattr(crs, "to_string") else crs)


def _is_xtgeo(value: Any) -> bool:
    return all(hasattr(value, name) for name in ("get_dataframe", "xname", "yname", "zname"))


def _columns(value: Any, table: Any) -> np.ndarray:
    """Places (n, 3) of a table of xtgeo."""
    names = (value.xname, value.yname, value.zname)
    return np.column_stack([np.asarray(table[name], dtype=np.float64) for name in names])


def _geometries(value: Any) -> list[Any] | None:
    """Geometries of a table, a column or a single one, each with one part."""
    if hasattr(value, "geometry") and hasattr(value, "crs"):
        return list(_parts(value.geometry))
    return list(_parts([value])) if isinstance(getattr(value, "geom_type", None), str) else None


def _parts(geometries: Any) -> Iterator[Any]:
    for geometry in geometries:
        if hasattr(geometry, MANY):
            yield from _parts(geometry.geoms)
        else:
            yield geometry


def _is(one: Any, *kinds: str) -> bool:
    return getattr(one, "geom_type", None) in kinds
