"""Knots of a walk: their contents, and at the end the chords between them.

Letters as in `lift` and `hermite_arcs`.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.smooth.coverage import key_of
from geosurf.kernels.smooth.error_estimate import error_at
from geosurf.kernels.smooth.hermite_arcs import (
    K_DISTANCE,
    K_ERROR,
    K_LENGTH,
    K_SINE,
    K_SLOPE,
    N_KNOT,
    chords_of_arc,
    point_on_arc,
)
from geosurf.kernels.smooth.lift import F_POINT, F_SINE, F_TANGENT, differences_at, parameters_of

_LEAST = 0.05  # of the tolerance: if less is left for a chord,
_BEYOND = 0.25  # the chord gets this part, since the tolerance cannot be met
# tangents jump from cell to cell: between the places where it was measured, the curve has been up
# to 1.8 times as far from an arc
ARC_SAFETY = 2.0


@scalar
def set_knot(sense, f, knot):
    """Write point, tangent in direction `sense`, parameters per metre and sine from Newton's
    result.

    `knot` holds its parameters already. Returns the largest rate.
    """
    for k in range(3):
        knot[k] = f[F_POINT + k]
        knot[K_SLOPE + k] = sense * f[F_TANGENT + k]
    knot[K_SINE] = f[F_SINE]

    # Parameters per metre on each surface.
    p, q, r = knot[K_SLOPE], knot[K_SLOPE + 1], knot[K_SLOPE + 2]
    largest = 0.0
    # First surface a, then b: their tangents are nine numbers apart in `f`.
    for k in range(2):
        du, dv = parameters_of(f, 9 * k, p, q, r)
        knot[K_SLOPE + 3 + 2 * k], knot[K_SLOPE + 4 + 2 * k] = du, dv
        largest = max(largest, abs(du), abs(dv))
    return largest


@scalar
def set_knot_errors(surfaces, f, before, knot):
    """Write the error measures of the cells of a knot; copied while cells do not change."""
    za, zb = surfaces.za, surfaces.zb
    # The first knot of a walk has no arc yet, hence no errors to copy.
    same = before[K_LENGTH] >= 0.0
    if same and key_of(za, zb, knot[3:7], 0) == key_of(za, zb, before[3:7], 0):
        for k in range(K_ERROR, K_SINE):
            knot[k] = before[k]
    else:
        differences_at(surfaces, knot[3:7], f, knot[K_ERROR:K_SINE])


@scalar
def with_room(knots, n):
    """Knots with capacity for one more."""
    if n < knots.shape[0]:
        return knots
    more = np.empty((2 * n, N_KNOT))
    more[:n] = knots
    return more


@scalar
def reverse_knots(knots, a, b):
    """Reverse knots a to b and their tangents; an arc belongs to its new end."""
    low, high = a, b - 1
    while low < high:
        for k in range(N_KNOT):
            knots[low, k], knots[high, k] = knots[high, k], knots[low, k]
        low += 1
        high -= 1

    # Slopes change sign; lengths move to the new end of each arc.
    for i in range(b - 1, a - 1, -1):
        for k in range(K_SLOPE, K_LENGTH):
            knots[i, k] = -knots[i, k]
        knots[i, K_LENGTH] = knots[i - 1, K_LENGTH] if i > a else -1.0
        knots[i, K_DISTANCE] = knots[i - 1, K_DISTANCE] if i > a else 0.0


@scalar
def _largest(values, first, last):
    """The largest of some values, or NaN; numba's version of `max` cannot be frozen."""
    largest = values[first]
    for k in range(first + 1, last):
        if values[k] > largest or math.isnan(values[k]):
            largest = values[k]
    return largest


@scalar
def cut_chords(knots, a, b, tolerance, rows, n):
    """Append points (3,) along knots a to b; rows, count, bound, estimate in it, and whether noisy.

    Chords get what the errors at both ends of their arc and at neighbouring knots leave of the
    tolerance.
    """
    errors = np.empty(b - a)
    noisy = False
    for k in range(a, b):
        errors[k - a], rough = error_at(knots, K_ERROR, k, a, b)
        noisy = noisy or not (rough <= 0.5 * tolerance and math.isfinite(errors[k - a]))

    # Each arc: what is left of the tolerance decides the number of chords.
    worst, bound = _largest(errors, 0, b - a), 0.0
    for k in range(a, b):
        if k == a:
            count = 1
        elif knots[k, K_LENGTH] < 0.0:
            count = 0  # the same point on the next triangle: nothing joins both
        else:
            # Between the places where it was measured an arc may be farther away.
            arc_error = ARC_SAFETY * knots[k, K_DISTANCE]
            # Errors of this arc's ends and of the knots next to them.
            used = _largest(errors, max(k - a - 2, 0), min(k - a + 2, b - a)) + arc_error
            left = tolerance - used
            left = left if left > _LEAST * tolerance else _BEYOND * tolerance
            count, error = chords_of_arc(knots[k - 1], knots[k], left)
            bound = max(bound, used + error)
        if n + count > rows.shape[0]:
            more = np.empty((2 * (n + count), 3))
            more[:n] = rows[:n]
            rows = more

        # Inner points on the arc, then the knot itself.
        for i in range(1, count):
            point_on_arc(knots[k - 1], knots[k], i / count, rows[n + i - 1])
        n += count
        rows[n - 1] = knots[k, :3]
    return rows, n, bound, worst, noisy
