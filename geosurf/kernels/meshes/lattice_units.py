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
    unit      sum of the steps at each point, line by line
    rule      [middle easting, middle northing, floor]: points move towards the middle on the map;
              those on the floor count as above what they lie on, all others as below
"""

from __future__ import annotations

from typing import NamedTuple

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
from geosurf.kernels.lattices.strips import load
from geosurf.kernels.search.tree import N_COL, N_ROW, RISING

# ---- pushed ----------------------------------------
# Sides of edges and planes, for points that are moved infinitely little off what they lie on.
#
# A point on the boundary of two triangles' shadows has to count for exactly one of them. So each
# point is thought to be moved on the map: infinitely little east or west, and infinitely less north
# or south (simulation of simplicity, Edelsbrunner & Mücke 1990, doi 10.1145/77635.77639). The move
# only decides where the sign of the exact determinant is zero.


class Lines(NamedTuple):
    """Vertical lines, one after the other, and what exact signs of their points need."""

    levels: np.ndarray  # elevations of all points
    n: int  # number of points of each line
    rule: np.ndarray
    s: np.ndarray  # scratch, float64 (6, 3), see below
    m: np.ndarray  # frame of the exact predicates: all coordinates of the model and the points
    w: np.ndarray


# rows of the scratch: corners of a triangle, a point; where the line is on the map, and which way
# its points are moved there: +1 or -1 east and north
_POINT, _PLACE, _PUSH, N_SCRATCH = 3, 4, 5, 6


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
def aim(s, rule, px, py):
    """Go to the line at a place; its points are moved towards the middle of the map."""
    s[_PLACE, 0], s[_PLACE, 1] = px, py
    s[_PUSH, 0], s[_PUSH, 1] = 1.0 if px <= rule[0] else -1.0, 1.0 if py <= rule[1] else -1.0


@scalar
def side_of_edge(ax, ay, bx, by, lines):
    """+1 where the line is left of the edge a -> b on the map, -1 right of it; 0 only if a = b."""
    # Shewchuk's filter, as in `predicates.orient2d`, on numbers in registers
    s = lines.s
    left = (bx - ax) * (s[_PLACE, 1] - ay)
    right = (by - ay) * (s[_PLACE, 0] - ax)
    size = abs(left) + abs(right)
    if size > TINY:
        if left - right > ORIENT2D_BOUND * size:
            return 1
        if right - left > ORIENT2D_BOUND * size:
            return -1

    # too near to call: exact integers
    s[0, 0], s[0, 1] = ax, ay
    s[1, 0], s[1, 1] = bx, by
    s[2, 0], s[2, 1] = s[_PLACE, 0], s[_PLACE, 1]
    sign = orient2d(s, lines.m, lines.w, 0, 1, 2, 0, 1)
    if sign != 0:
        return sign

    # On the line of the edge the move decides. The determinant changes by -dy to the east and by
    # +dx to the north; north counts only where dy is 0.
    if by != ay:
        return int(-s[_PUSH, 0] if by > ay else s[_PUSH, 0])
    if bx != ax:
        return int(s[_PUSH, 1] if bx > ax else -s[_PUSH, 1])
    return 0


@scalar
def _n_lower(levels, first, n, height):
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


@scalar
def n_below(lines, first, facing):
    """How many points of the line, from `first` on, are below the triangle in the scratch.

    `facing` is +1 where its corners go round counter-clockwise on the map, -1 where clockwise.
    """
    # points below all corners, and up to those above all; in between exact signs decide
    s, levels = lines.s, lines.levels
    low, high = min(s[0, 2], min(s[1, 2], s[2, 2])), max(s[0, 2], max(s[1, 2], s[2, 2]))
    begin = _n_lower(levels, first, lines.n, low)
    end = begin
    while end < lines.n and levels[first + end] <= high:
        end += 1
    while begin < end:
        middle = (begin + end) // 2
        pz = levels[first + middle]
        s[_POINT, 0], s[_POINT, 1], s[_POINT, 2] = s[_PLACE, 0], s[_PLACE, 1], pz
        plane = plane_terms(s, 0, 1, 2)
        side = facing * side_of(s, lines.m, lines.w, 0, 1, 2, _POINT, plane, 0.0)
        # on the triangle counts as below, except on the floor
        if side < 0 or (side == 0 and pz != lines.rule[2]):
            begin = middle + 1
        else:
            end = middle
    return begin


OFF = -1  # the key of a point beside the lattice
_NEIGHBOURS = 9  # cells around a guess, itself among them


@scalar
def _step_of_axis(axis):
    """+1 for an axis that rises, -1 for one that falls."""
    return 1.0 if axis[axis.shape[0] - 1] > axis[0] else -1.0


@scalar
def _interval(axis, sign, value, push):
    """Interval of an axis that holds a value, moved by nearly nothing; OFF beside the axis.

    A guess from equal steps is right for nearly all grids; others are searched by halves.
    """
    n = axis.shape[0]

    # positions are compared as `way * value`, so that the axis rises
    at, move = sign * value, sign * push
    first, last = sign * axis[0], sign * axis[n - 1]
    if at < first or at > last or (at == first and move < 0.0) or (at == last and move > 0.0):
        return OFF
    low = min(max(int((at - first) / (last - first) * (n - 1)), 0), n - 2)
    if not (_is_past(sign * axis[low], at, move) and not _is_past(sign * axis[low + 1], at, move)):
        low, high = 0, n - 1
        while high - low > 1:
            middle = (low + high) // 2
            if _is_past(sign * axis[middle], at, move):
                low = middle
            else:
                high = middle
    return low


@scalar
def _is_past(node, at, move):
    """Whether a moved value lies past a node of a rising axis."""
    return at > node or (at == node and move > 0.0)


@scalar
def _edge(x, y, a, i, j, k, o, lines):
    """Side of the edge from node (i, j) to node (k, o) on which the line lies."""
    ax, ay = load(x, a, 0, i, j), load(y, a, 1, i, j)
    bx, by = load(x, a, 0, k, o), load(y, a, 1, k, o)
    return side_of_edge(ax, ay, bx, by, lines)


@scalar
def _is_in_cell(x, y, a, i, j, turn, lines):
    """Whether the moved line lies inside all four edges of a cell."""
    return (
        turn * _edge(x, y, a, i, j, i, j + 1, lines) > 0
        and turn * _edge(x, y, a, i, j + 1, i + 1, j + 1, lines) > 0
        and turn * _edge(x, y, a, i + 1, j + 1, i + 1, j, lines) > 0
        and turn * _edge(x, y, a, i + 1, j, i, j, lines) > 0
    )


@scalar
def _cell_around(x, y, a, guess, turn, lines):
    """Row and column of the cell of the line in a rotated grid, or OFF.

    `guess` maps the plane to rows and columns: offset, then factors of easting and northing, for
    the row and for the column. It is right to within one cell.
    """
    s = lines.s
    row = guess[0] + guess[1] * s[_PLACE, 0] + guess[2] * s[_PLACE, 1]
    col = guess[3] + guess[4] * s[_PLACE, 0] + guess[5] * s[_PLACE, 1]
    if not (-1.0 <= row <= a[N_ROW] and -1.0 <= col <= a[N_COL]):
        return OFF, OFF

    # the cell of the guess first, then those around it
    i0, j0 = int(np.floor(row)), int(np.floor(col))
    for k in range(_NEIGHBOURS):
        i = i0 + (0, 0, 0, -1, 1, -1, -1, 1, 1)[k]
        j = j0 + (0, -1, 1, 0, 0, -1, 1, -1, 1)[k]
        if i < 0 or j < 0 or i >= a[N_ROW] - 1 or j >= a[N_COL] - 1:
            continue
        if _is_in_cell(x, y, a, i, j, turn, lines):
            return i, j
    return OFF, OFF


@scalar
def _half_cell(x, y, a, guess, turn, lines):
    """Row, column and half of the cell of the line, or OFF three times."""
    s = lines.s
    if guess.shape[0] == 0:
        j = _interval(x, _step_of_axis(x), s[_PLACE, 0], s[_PUSH, 0])
        i = OFF if j == OFF else _interval(y, _step_of_axis(y), s[_PLACE, 1], s[_PUSH, 1])
    else:
        i, j = _cell_around(x, y, a, guess, turn, lines)
    if i == OFF or j == OFF:
        return OFF, OFF, OFF

    # its half: left or right of the diagonal from corner 0 to 2, or from corner 1 to 3
    if a[RISING] == 1:
        left = _edge(x, y, a, i, j, i + 1, j + 1, lines)
    else:
        left = -_edge(x, y, a, i, j + 1, i + 1, j, lines)
    return i, j, 0 if turn * left < 0 else 1


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


@entry("d1 d1 l1 d2 l1 l2 d1 l d2 d1 l d1 l1* l1* l1* -> .")
def add_lattice_units(x, y, a, z, column, steps, guess, turn, p, levels, each, rule, m, w, unit):
    """Add the steps of all surfaces of a group to the highest level below each.

    `guess` is empty for grids whose axes are those of the map; `turn` is +1 where columns, rows and
    up make a right-handed system.
    """
    s = np.zeros((N_SCRATCH, 3))
    n = unit.shape[0] // max(p.shape[0], 1)
    lines = Lines(levels, n, rule, s, m, w)
    nodes = np.empty(3, dtype=np.int64)
    for q in range(p.shape[0]):
        aim(s, rule, p[q, 0], p[q, 1])
        i, j, half = _half_cell(x, y, a, guess, turn, lines)
        if i == OFF:
            continue
        row = column[2 * (i * (a[N_COL] - 1) + j) + half]
        if row == 0:  # no surface of the group is whole here
            continue

        # the triangle on the map is the same for all surfaces
        i0, j0, i1, j1, i2, j2 = corner_nodes(a, i, j, half)
        s[0, 0], s[0, 1] = load(x, a, 0, i0, j0), load(y, a, 1, i0, j0)
        s[1, 0], s[1, 1] = load(x, a, 0, i1, j1), load(y, a, 1, i1, j1)
        s[2, 0], s[2, 1] = load(x, a, 0, i2, j2), load(y, a, 1, i2, j2)
        nodes[0], nodes[1], nodes[2] = i0 * a[N_COL] + j0, i1 * a[N_COL] + j1, i2 * a[N_COL] + j2
        for k in range(steps.shape[1]):
            if steps[row, k] == 0:
                continue
            for corner in range(3):
                s[corner, 2] = z[nodes[corner], k]
            below = n_below(lines, q * each, turn)
            if below > 0:
                unit[q * n + below - 1] += steps[row, k]


@entry("d1 d1 l1 d1 l d2 d1 l1* l1* l1* -> .")
def find_keys(x, y, a, guess, turn, p, rule, m, w, key):
    """Write the key of the triangle that each vertical line passes, or OFF beside the grid.

    Absent nodes are not looked at: where one is missing, no triangle has that key.
    """
    s = np.zeros((N_SCRATCH, 3))
    lines = Lines(rule, 0, rule, s, m, w)  # no points
    for q in range(p.shape[0]):
        aim(s, rule, p[q, 0], p[q, 1])
        i, j, half = _half_cell(x, y, a, guess, turn, lines)
        key[q] = OFF if i == OFF else 2 * (i * (a[N_COL] - 1) + j) + half


# ---- single triangles ----------------------------------------
# Cut triangles, faults, contacts and walls: vertical lines that pass them are searched
# (`geosurf.kernels.search.columns`).


@entry("d2 l1 l1 l1 l1 d2 d1 l d1 l1* l1* l1* -> .")
def add_triangle_units(c, facing, step, met, line, p, levels, each, rule, m, w, unit):
    """Add the steps of triangles to the highest level below each, where a line passes one.

    Parameters
    ----------
    c : float64 (n, 9)
        Corners of the triangles, local; `facing` +1 where one goes round counter-clockwise on the
        map, -1 where clockwise; `step` the unit below it minus the unit above.
    met, line : int64 (n_pair,)
        A triangle, and a line that passes it.
    """
    s = np.zeros((N_SCRATCH, 3))
    n = unit.shape[0] // max(p.shape[0], 1)
    lines = Lines(levels, n, rule, s, m, w)
    for k in range(met.shape[0]):
        t, q = met[k], line[k]
        aim(s, rule, p[q, 0], p[q, 1])
        for corner in range(9):
            s[corner // 3, corner % 3] = c[t, corner]
        below = n_below(lines, q * each, facing[t])
        if below > 0:
            unit[q * n + below - 1] += step[t]
