"""The local frame: one origin per model, subtracted from world coordinates without rounding."""

from __future__ import annotations

import math

import numpy as np

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
