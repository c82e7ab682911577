"""Estimate of the distance between a curve of cubics and the true curve, from interpolants along
it.

Interpolants of 4, 6 and 8 points are compared (`cubic_patch.interpolant_differences`). Their
differences are summed like a geometric series, ``d / (1 - q)``, with q the ratio of the second to
the first over a window, at most ROUGH. The noise that would cause the second difference is added,
since noise passes through all of them. Where q exceeds ROUGH, interpolants do not converge: that is
noise. Errors of both surfaces are added and divided by the sine of the angle between them.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar

ROUGH = 0.3  # differences of interpolants that do not shrink to this part are noise
WINDOW = 8  # rows to each side over which they are compared


@scalar
def _mean(rows, column, a, b):
    """Root mean square of a column over rows a to b."""
    total = 0.0
    for k in range(a, b):
        total += rows[k, column] * rows[k, column]
    return math.sqrt(total / (b - a))


@scalar
def error_at(rows, first, k, a, b):
    """Estimate at row k of a curve, rows a to b, and the part of it that is noise [m].

    `first`: of seven columns, three lengths of `interpolant_differences` for each surface and the
    sine.
    """
    # A window averages the differences, which may vanish at single knots.
    low, high = max(k - WINDOW, a), min(k + WINDOW + 1, b)
    total, rough = 0.0, 0.0
    for column in (first, first + 3):
        d, after = _mean(rows, column, low, high), _mean(rows, column + 1, low, high)
        noise = _mean(rows, column + 2, low, high)
        # The ratio of one order to the next, as in a geometric series.
        q = after / d if d > 0.0 else 0.0
        total += rows[k, column] / (1.0 - min(q, ROUGH)) + noise
        # Differences that do not shrink are noise.
        if q > ROUGH:
            rough += noise
    return total / rows[k, first + 6], rough / rows[k, first + 6]


@entry("d2 -> d1 d1")
def errors_along(rows):
    """`error_at` for all rows (n, 7) of one curve."""
    n = rows.shape[0]
    total, rough = np.empty(n), np.empty(n)
    for k in range(n):
        total[k], rough[k] = error_at(rows, 0, k, 0, n)
    return total, rough
