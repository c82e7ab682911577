"""Sides of edges and planes, for points that are moved infinitely little off what they lie on.

A point on the boundary of two triangles' shadows has to count for exactly one of them. So each
point is thought to be moved on the map: infinitely little east or west, and infinitely less north
or south (simulation of simplicity, Edelsbrunner & Mücke 1990, doi 10.1145/77635.77639). The move
only decides where the sign of the exact determinant is zero.

Notation
    s         scratch, float64 (4, 3): points for the exact predicates
    m, w      frame of the exact predicates: it holds all coordinates of the model and the points
    east      +1 or -1: which way the point is moved; `north` likewise
"""

from __future__ import annotations

import numpy as np

from geosurf.errors import SurfaceError
from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.exact.bigint import BITS
from geosurf.kernels.exact.exact_signs import LIMBS, N_META, N_VERTEX, SCALE, workspace
from geosurf.kernels.exact.predicates import (
    MAX_BITS,
    ORIENT2D_BOUND,
    TINY,
    VALID_SIZES,
    orient2d,
    plane_terms,
    scale_of,
    side_of,
)


def digits_of(*parts: np.ndarray) -> tuple[int, int]:
    """Return binary digits of all numbers of some arrays: behind the point, and before it.

    Raises
    ------
    SurfaceError
        If a number is not finite.
    """
    behind, before = 0, 0
    for part in parts:
        k, bits = scale_of(np.ravel(part))
        if bits < 0:
            raise SurfaceError("a coordinate is not finite; leave out points that are undefined.")
        behind, before = max(behind, k), max(before, bits - k)
    return behind, before


def frame_with(*digits: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return the integers `m` and the limb workspace `w` for numbers with some `digits_of`.

    Raises
    ------
    SurfaceError
        If the numbers span too many binary digits.
    """
    behind, before = (max(part) for part in zip(*digits, strict=True))
    if behind + before > MAX_BITS:
        raise SurfaceError(
            f"coordinates span {behind + before} binary digits, from tiny to huge; {VALID_SIZES}."
        )

    # three bits to spare for sums of differences, as in `frame_of`
    m = np.zeros(N_META, dtype=np.int64)
    m[N_VERTEX] = 4
    m[LIMBS] = (behind + before + 3 + BITS - 1) // BITS
    m[SCALE] = behind
    return m, workspace(m[LIMBS])


@scalar
def side_of_edge(ax, ay, bx, by, px, py, east, north, s, m, w):
    """+1 where a point on the map lies left of the edge a -> b, -1 right of it; 0 only if a = b."""
    # Shewchuk's filter, as in `predicates.orient2d`, on numbers in registers
    left = (bx - ax) * (py - ay)
    right = (by - ay) * (px - ax)
    size = abs(left) + abs(right)
    if size > TINY:
        if left - right > ORIENT2D_BOUND * size:
            return 1
        if right - left > ORIENT2D_BOUND * size:
            return -1

    # too near to call: exact integers
    s[0, 0], s[0, 1] = ax, ay
    s[1, 0], s[1, 1] = bx, by
    s[2, 0], s[2, 1] = px, py
    sign = orient2d(s, m, w, 0, 1, 2, 0, 1)
    if sign != 0:
        return sign

    # On the line of the edge the move decides. The determinant changes by -dy to the east and by
    # +dx to the north; north counts only where dy is 0.
    if by != ay:
        return -east if by > ay else east
    if bx != ax:
        return north if bx > ax else -north
    return 0


@scalar
def side_of_plane(s, m, w, facing):
    """+1 where the point in row 3 of `s` is above the plane of rows 0 to 2, -1 below it, 0 on it.

    `facing` is +1 where the three rows go round counter-clockwise on the map, -1 where clockwise.
    """
    return facing * side_of(s, m, w, 0, 1, 2, 3, plane_terms(s, 0, 1, 2), 0.0)


@scalar
def count_levels(levels, first, n, height):
    """How many of n rising levels, from `first` on, are below a height."""
    if n == 1:
        return 1 if levels[first] < height else 0
    low, high = 0, n
    while low < high:
        middle = (low + high) // 2
        if levels[first + middle] < height:
            low = middle + 1
        else:
            high = middle
    return low


@entry("l1* l -> .")
def sum_from_top(unit, n):
    """Turn steps at the highest level below each surface into units, line by line of n levels.

    At the highest point of a line the sum is that of all surfaces above it, with the outside (-1)
    at the top; each lower point adds what is between.
    """
    for first in range(0, unit.shape[0], n):
        total = -1
        for k in range(first + n - 1, first - 1, -1):
            total += unit[k]
            unit[k] = total
