"""Cubic Hermite arcs between knots of a curve: points on them, distances from them, chords along
them.

An arc is the cubic with given ends and slopes. Its distance from a smooth curve is O(s^4), where a
chord has O(s^2), s its length. So Newton's method is needed at few knots, and chords are cut from
arcs. A chord deviates from its part of an arc by |B''| h^2 / 8 at most, with B'' the second
derivative by the arc's parameter and h the part of it: B'' is linear, so its larger end is a bound.

Notation
    B         the cubic; t from 0 to 1
    k         knots (N_KNOT,): point and parameters as in `lift` (7,), the same per metre along the
              curve (7,), length of the arc that ends here, distance of the curve from it, six error
              measures, sine
"""

from __future__ import annotations

import math

from geosurf.kernels.compile.jit import scalar

K_SLOPE, K_LENGTH, K_DISTANCE, K_ERROR, K_SINE, N_KNOT = 7, 14, 15, 16, 22, 23


@scalar
def _first_on_arc(n, one, two, t, row):
    """The first n numbers of `on_arc`."""
    s = 1.0 - t

    # Hermite basis: ends, then slopes times length.
    a, c = s * s * (1.0 + 2.0 * t), t * t * (3.0 - 2.0 * t)
    b, d = t * s * s * two[K_LENGTH], -t * t * s * two[K_LENGTH]
    for k in range(n):
        row[k] = a * one[k] + b * one[K_SLOPE + k] + c * two[k] + d * two[K_SLOPE + k]


@scalar
def on_arc(one, two, t, row):
    """Point and parameters (7,) at t on the arc to knot `two`; beyond 1 it extrapolates."""
    _first_on_arc(7, one, two, t, row)


@scalar
def point_on_arc(one, two, t, point):
    """The point alone (3,)."""
    _first_on_arc(3, one, two, t, point)


@scalar
def along_arc(one, two, t):
    """First derivative of the point."""
    # Derivatives of the Hermite basis.
    a = 6.0 * t * (1.0 - t)
    b, d = (1.0 - t) * (1.0 - 3.0 * t) * two[K_LENGTH], t * (3.0 * t - 2.0) * two[K_LENGTH]
    return (
        a * (two[0] - one[0]) + b * one[7] + d * two[7],
        a * (two[1] - one[1]) + b * one[8] + d * two[8],
        a * (two[2] - one[2]) + b * one[9] + d * two[9],
    )


@scalar
def set_length(one, two):
    """Set the length of the arc between two knots, from its chord and tangents, to O(s^5)."""
    chord, turn = 0.0, 0.0
    for k in range(3):
        chord += (two[k] - one[k]) ** 2
        turn += (two[K_SLOPE + k] - one[K_SLOPE + k]) ** 2

    # Chord times a correction by the turn of the tangents.
    two[K_LENGTH] = math.sqrt(chord) * (1.0 + turn / 24.0)


@scalar
def squared_distance_to_arc(one, two, x, y, z):
    """Squared distance of a point from an arc, for points near it."""
    # Start from the projection on the chord.
    dx, dy, dz = two[0] - one[0], two[1] - one[1], two[2] - one[2]
    size = dx * dx + dy * dy + dz * dz
    t = ((x - one[0]) * dx + (y - one[1]) * dy + (z - one[2]) * dz) / size if size > 0.0 else 0.0
    ex, ey, ez = 0.0, 0.0, 0.0

    # Two Newton-like steps of the parameter from the projection on the chord.
    for turn in range(3):
        t = min(max(t, 0.0), 1.0)
        s = 1.0 - t
        a, c = s * s * (1.0 + 2.0 * t), t * t * (3.0 - 2.0 * t)
        b, d = t * s * s * two[K_LENGTH], -t * t * s * two[K_LENGTH]
        ex = x - (a * one[0] + b * one[7] + c * two[0] + d * two[7])
        ey = y - (a * one[1] + b * one[8] + c * two[1] + d * two[8])
        ez = z - (a * one[2] + b * one[9] + c * two[2] + d * two[9])
        dx, dy, dz = along_arc(one, two, t)
        size = dx * dx + dy * dy + dz * dz
        if turn < 2 and size > 0.0:
            t += (ex * dx + ey * dy + ez * dz) / size
    return ex * ex + ey * ey + ez * ez


@scalar
def chords_of_arc(one, two, target):
    """Number of equal parts of an arc with chords within a target, and the bound of these."""
    first, last = 0.0, 0.0
    for k in range(3):
        # Second derivatives at both ends, component by component.
        step = 6.0 * (two[k] - one[k])
        a, b = two[K_LENGTH] * one[K_SLOPE + k], two[K_LENGTH] * two[K_SLOPE + k]
        first += (step - 4.0 * a - 2.0 * b) ** 2
        last += (2.0 * a + 4.0 * b - step) ** 2
    bend = math.sqrt(max(first, last)) / 8.0
    # n parts divide the deviation by n squared.
    n = max(math.ceil(math.sqrt(bend / target)), 1)
    return n, bend / (n * n)
