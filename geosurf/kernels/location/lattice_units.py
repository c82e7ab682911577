"""Runs of gridded surfaces above points: all surfaces that share one map in one pass.

Most of a model is whole cells of grids that no curve touches. For those, the place of a point in
the grid says which triangles it has above or below it, and no search is needed. Cells have a
*column*: the differences between the units below and above each surface there. A model has few
distinct columns, so that a cell takes one number however many surfaces there are.

Notation
    x, y      coordinates of nodes as the lattice has them (axes, or all nodes), local
    a         layout, as in `tree`
    z         elevations of all surfaces of the group, local, float64 (n_node, n_surface)
    column    row of `steps` of each triangle, by key; row 0 is all zeros
    steps     unit below minus unit above, int64 (n_column, n_surface)
    p         eastings and northings of vertical lines, local, float64 (n, 2)
    levels    elevations of points on the lines, rising on each: of line i from ``i * each`` on,
              where `each` is their number, or 0 if all lines have the same ones
    unit      row of the unit of each point, line by line: see `sum_from_top`
    rule      [middle easting, middle northing, floor]: points move towards the middle on the map;
              those on the floor count as above what they lie on, all others as below
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
from geosurf.kernels.lattices.strips import FIRST, LAST, ROW, key_at, load
from geosurf.kernels.search.tree import N_COL, N_ROW, RISING

# ---- pushed ----------------------------------------
# Sides of edges and planes, for points that are moved infinitely little off what they lie on.
#
# A point on the boundary of two triangles' shadows has to count for exactly one of them. So each
# point is thought to be moved on the map: infinitely little east or west, and infinitely less north
# or south (simulation of simplicity, Edelsbrunner & Mücke 1990, doi 10.1145/77635.77639). The move
# only decides where the sign of the exact determinant is zero.
#
# Notation
#     s         scratch, float64 (4, 3): points for the exact predicates
#     m, w      frame of the exact predicates: it holds all coordinates of the model and the points
#     east      +1 or -1: which way the point is moved; `north` likewise


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


OFF = -1  # the key of a point beside the lattice
_NEIGHBOURS = 9  # cells around a guess, itself among them


@entry("l1 l2 l1 l1* -> .")
def spread_runs(a, runs, values, out):
    """Write the value of each run to all of its triangles, by key."""
    for i in range(runs.shape[0]):
        for place in range(runs[i, FIRST], runs[i, LAST] + 1):
            out[key_at(a, runs[i, ROW], place)] = values[i]


@scalar
def _step_of_axis(axis):
    """+1 for an axis that rises, -1 for one that falls."""
    return 1.0 if axis[axis.shape[0] - 1] > axis[0] else -1.0


@scalar
def _interval(axis, way, value, push):
    """Interval of an axis that holds a value, moved by nearly nothing; OFF beside the axis.

    A guess from equal steps is right for nearly all grids; others are searched by halves.
    """
    n = axis.shape[0]

    # positions are compared as `way * value`, so that the axis rises
    at, move = way * value, way * push
    first, last = way * axis[0], way * axis[n - 1]
    if at < first or at > last or (at == first and move < 0.0) or (at == last and move > 0.0):
        return OFF
    low = min(max(int((at - first) / (last - first) * (n - 1)), 0), n - 2)
    if not (_is_past(way * axis[low], at, move) and not _is_past(way * axis[low + 1], at, move)):
        low, high = 0, n - 1
        while high - low > 1:
            middle = (low + high) // 2
            if _is_past(way * axis[middle], at, move):
                low = middle
            else:
                high = middle
    return low


@scalar
def _is_past(node, at, move):
    """Whether a moved value lies past a node of a rising axis."""
    return at > node or (at == node and move > 0.0)


@scalar
def _edge(x, y, a, i, j, k, o, px, py, east, north, s, m, w):
    """Side of the edge from node (i, j) to node (k, o) on which a point lies."""
    ax, ay = load(x, a, 0, i, j), load(y, a, 1, i, j)
    bx, by = load(x, a, 0, k, o), load(y, a, 1, k, o)
    return side_of_edge(ax, ay, bx, by, px, py, east, north, s, m, w)


@scalar
def _is_in_cell(x, y, a, i, j, turn, px, py, east, north, s, m, w):
    """Whether a moved point lies inside all four edges of a cell."""
    return (
        turn * _edge(x, y, a, i, j, i, j + 1, px, py, east, north, s, m, w) > 0
        and turn * _edge(x, y, a, i, j + 1, i + 1, j + 1, px, py, east, north, s, m, w) > 0
        and turn * _edge(x, y, a, i + 1, j + 1, i + 1, j, px, py, east, north, s, m, w) > 0
        and turn * _edge(x, y, a, i + 1, j, i, j, px, py, east, north, s, m, w) > 0
    )


@scalar
def _cell_around(x, y, a, guess, turn, px, py, east, north, s, m, w):
    """Row and column of the cell of a point in a rotated grid, or OFF.

    `guess` maps the plane to rows and columns: offset, then factors of easting and northing, for
    the row and for the column. It is right to within one cell.
    """
    row = guess[0] + guess[1] * px + guess[2] * py
    col = guess[3] + guess[4] * px + guess[5] * py
    if not (-1.0 <= row <= a[N_ROW] and -1.0 <= col <= a[N_COL]):
        return OFF, OFF

    # the cell of the guess first, then those around it
    i0, j0 = int(np.floor(row)), int(np.floor(col))
    for k in range(_NEIGHBOURS):
        i = i0 + (0, 0, 0, -1, 1, -1, -1, 1, 1)[k]
        j = j0 + (0, -1, 1, 0, 0, -1, 1, -1, 1)[k]
        if i < 0 or j < 0 or i >= a[N_ROW] - 1 or j >= a[N_COL] - 1:
            continue
        if _is_in_cell(x, y, a, i, j, turn, px, py, east, north, s, m, w):
            return i, j
    return OFF, OFF


@scalar
def _half_cell(x, y, a, guess, turn, px, py, rule, s, m, w):
    """Row, column and half of the cell of a vertical line, or OFF three times."""
    east = 1 if px <= rule[0] else -1
    north = 1 if py <= rule[1] else -1

    # the cell
    if guess.shape[0] == 0:
        j = _interval(x, _step_of_axis(x), px, float(east))
        i = OFF if j == OFF else _interval(y, _step_of_axis(y), py, float(north))
    else:
        i, j = _cell_around(x, y, a, guess, turn, px, py, east, north, s, m, w)
    if i == OFF or j == OFF:
        return OFF, OFF, OFF

    # its half: left or right of the diagonal from corner 0 to 2, or from corner 1 to 3
    if a[RISING] == 1:
        left = _edge(x, y, a, i, j, i + 1, j + 1, px, py, east, north, s, m, w)
    else:
        left = -_edge(x, y, a, i, j + 1, i + 1, j, px, py, east, north, s, m, w)
    return i, j, 0 if turn * left < 0 else 1


@scalar
def _set_corner(x, y, z, a, k, i, j, row, s):
    """Put node (i, j) of surface k into a row of the scratch."""
    s[row, 0], s[row, 1] = load(x, a, 0, i, j), load(y, a, 1, i, j)
    s[row, 2] = z[i * a[N_COL] + j, k]


@scalar
def corner_nodes(a, i, j, half):
    """Rows and columns of the three corners of half a cell, in the order of `build_triangles`."""
    if a[RISING] == 1:
        # corners 0, 1, 2, 3 around the cell: 0 1 2 and 0 2 3
        if half == 0:
            return i, j, i, j + 1, i + 1, j + 1
        return i, j, i + 1, j + 1, i + 1, j
    # 0 1 3 and 1 2 3
    if half == 0:
        return i, j, i, j + 1, i + 1, j
    return i, j + 1, i + 1, j + 1, i + 1, j


@scalar
def _is_below(x, y, z, a, k, corners, px, py, pz, on_floor, turn, s, m, w):
    """Whether a point lies below a triangle of surface k; on it counts as below, off the floor."""
    i0, j0, i1, j1, i2, j2 = corners
    _set_corner(x, y, z, a, k, i0, j0, 0, s)
    _set_corner(x, y, z, a, k, i1, j1, 1, s)
    _set_corner(x, y, z, a, k, i2, j2, 2, s)
    s[3, 0], s[3, 1], s[3, 2] = px, py, pz
    side = side_of_plane(s, m, w, turn)
    return side < 0 or (side == 0 and not on_floor)


@scalar
def _n_below(x, y, z, a, k, corners, px, py, levels, first, n, floor, turn, s, m, w):
    """How many of the levels of a line are below a triangle of surface k."""
    i0, j0, i1, j1, i2, j2 = corners
    n_col = a[N_COL]
    z0, z1, z2 = z[i0 * n_col + j0, k], z[i1 * n_col + j1, k], z[i2 * n_col + j2, k]
    low, high = min(z0, min(z1, z2)), max(z0, max(z1, z2))

    # levels below all corners, and up to those above all; in between exact signs decide
    begin = count_levels(levels, first, n, low)
    end = begin
    while end < n and levels[first + end] <= high:
        end += 1
    while begin < end:
        middle = (begin + end) // 2
        pz = levels[first + middle]
        if _is_below(x, y, z, a, k, corners, px, py, pz, pz == floor, turn, s, m, w):
            begin = middle + 1
        else:
            end = middle
    return begin


@entry("d1 d1 l1 d2 l1 l2 d1 l d2 d1 l d1 l1* l1* l1* -> .")
def add_lattice_units(x, y, a, z, column, steps, guess, turn, p, levels, each, rule, m, w, unit):
    """Add the steps of all surfaces of a group to the highest level below each.

    `guess` is empty for grids whose axes are those of the map; `turn` is +1 where columns, rows and
    up make a right-handed system.
    """
    s = np.zeros((4, 3))
    n = unit.shape[0] // max(p.shape[0], 1)
    for q in range(p.shape[0]):
        px, py = p[q, 0], p[q, 1]
        i, j, half = _half_cell(x, y, a, guess, turn, px, py, rule, s, m, w)
        if i == OFF:
            continue
        of = column[2 * (i * (a[N_COL] - 1) + j) + half]
        if of == 0:  # no surface of the group is whole here
            continue
        corners = corner_nodes(a, i, j, half)
        for k in range(steps.shape[1]):
            step = steps[of, k]
            if step == 0:
                continue
            below = _n_below(
                x, y, z, a, k, corners, px, py, levels, q * each, n, rule[2], turn, s, m, w
            )
            if below > 0:
                unit[q * n + below - 1] += step


@entry("d1 d1 l1 d1 l d2 d1 l1* l1* l1* -> .")
def find_keys(x, y, a, guess, turn, p, rule, m, w, key):
    """Write the key of the triangle that each vertical line passes, or OFF beside the grid.

    Absent nodes are not looked at: where one is missing, no triangle has that key.
    """
    s = np.zeros((4, 3))
    for q in range(p.shape[0]):
        i, j, half = _half_cell(x, y, a, guess, turn, p[q, 0], p[q, 1], rule, s, m, w)
        key[q] = OFF if i == OFF else 2 * (i * (a[N_COL] - 1) + j) + half
