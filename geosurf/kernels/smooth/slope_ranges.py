"""Ranges of the slopes and heights of local cubics and of triangles through the nodes of a lattice.

A cubic through four nodes differs from the chord between two of them by a known part of the second
differences of the four, in height and in slope. Across, cubics of rows are joined by cubics, so
second differences along the other axis count, too.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import scalar

_EVEN = 1e-3  # of a step of an axis, by which steps may differ
_UNEVEN = 0.01  # of a slope, by which uneven steps may change it
_STENCIL = 4  # nodes beyond a cell that its cubic reads, and one
# How far slopes and heights of cubics through 4 nodes are from those of chords: parts of second
# differences along the same axis and along the other one; largest at the rim.
_SLOPE, _SLOPE_ACROSS = 1.2, 1.75
_HEIGHT, _HEIGHT_ACROSS = 0.26, 0.42


@scalar
def window(axis, low, high):
    """First and last node of an axis whose cells and stencils reach from low to high, and its
    step; 0 for the step where nodes are not even, and last before first where nothing is there.
    """
    n = axis.shape[0]
    step = (axis[n - 1] - axis[0]) / (n - 1)
    for k in range(n - 1):
        if not abs(axis[k + 1] - axis[k] - step) <= _EVEN * abs(step):
            return 0, 0, 0.0
    one, two = (low - axis[0]) / step, (high - axis[0]) / step
    first, last = min(one, two), max(one, two)
    if last < 0.0 or first > n - 1.0:
        return 1, 0, step
    first, last = max(first - _STENCIL, 0.0), min(last + _STENCIL, n - 1.0)
    return math.floor(first), math.ceil(last), step


@scalar
def extremes(z, i, j, m, n, range_, heights):
    """Differences of nodes (i to j, m to n) along columns and rows, widened to cubics', and
    heights.
    """
    # an entry for each column: these loops run on several at once
    width = n - m + 1
    most = np.full((8, width), -np.inf)
    for row in range(i, j + 1):
        here, above, after = z[row], z[min(row + 1, j)], z[min(row + 2, j)]
        for k in range(width - 2):
            a, b, c = here[m + k], here[m + k + 1], here[m + k + 2]
            rise, bend = b - a, abs(a - 2.0 * b + c)
            most[0, k] = rise if rise > most[0, k] else most[0, k]
            most[1, k] = -rise if -rise > most[1, k] else most[1, k]
            most[2, k] = bend if bend > most[2, k] else most[2, k]
        a, b = here[n - 1], here[n]
        most[0, width - 1] = max(most[0, width - 1], b - a if math.isfinite(b - a) else -np.inf)
        most[1, width - 1] = max(most[1, width - 1], a - b if math.isfinite(b - a) else -np.inf)
        for k in range(width):
            a = here[m + k]
            most[6, k] = a if a > most[6, k] else most[6, k]
            most[7, k] = -a if -a > most[7, k] else most[7, k]
        if row < j:
            for k in range(width):
                rise = above[m + k] - here[m + k]
                most[3, k] = rise if rise > most[3, k] else most[3, k]
                most[4, k] = -rise if -rise > most[4, k] else most[4, k]
        if row + 1 < j:
            for k in range(width):
                bend = abs(here[m + k] - 2.0 * above[m + k] + after[m + k])
                most[5, k] = bend if bend > most[5, k] else most[5, k]
    worst = np.full(8, -np.inf)
    for k in range(8):
        for column in range(width):
            worst[k] = max(worst[k], most[k, column])
    bend, across = max(worst[2], 0.0), max(worst[5], 0.0)
    wide = _SLOPE * bend + _SLOPE_ACROSS * across
    range_[0], range_[1] = -worst[1] - wide, worst[0] + wide
    wide = _SLOPE * across + _SLOPE_ACROSS * bend
    range_[2], range_[3] = -worst[4] - wide, worst[3] + wide
    wide = max(_HEIGHT * bend + _HEIGHT_ACROSS * across, _HEIGHT * across + _HEIGHT_ACROSS * bend)
    heights[0], heights[1] = -worst[7] - wide, worst[6] + wide


@scalar
def per_metre(range_, k, step):
    """Differences of nodes to slopes."""
    one, two = range_[k] / step, range_[k + 1] / step
    wide = _UNEVEN * max(abs(one), abs(two))
    range_[k], range_[k + 1] = min(one, two) - wide, max(one, two) + wide
