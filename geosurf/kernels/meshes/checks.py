"""What a certificate adds up over triangles, and whether these lie on their input triangles.

Sums over runs are read from one label for each triangle of a lattice. Some rows at a time have
labels, which then take little memory.

Notation, in addition to that of `geosurf.kernels.lattices.strips` (a, runs)
    p, q, r     easting, northing, elevation of nodes
    label       run of each triangle (row, column, half); -1 for none
    x, t        vertices (n_vertex, 3) and triangles (n, 3) of a list
    parents     corners of the input triangle of each, one after the other (n, 9)
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.strips import load
from geosurf.kernels.search.tree import RISING, TURNED

# columns of sums: see `_add_sums`
VOLUME, AREA, PRODUCTS, SIDES, RISE, COUNT = slice(0, 2), slice(2, 4), 4, 5, 6, 7
LOWER, UPPER = slice(8, 11), slice(11, 14)
N_SUM = 14


@scalar
def two_sum(out, i, k, term):
    """Add a term to the pair of numbers at out[i, k]; the second collects rounding errors."""
    total = out[i, k] + term
    back = total - out[i, k]
    out[i, k + 1] += (out[i, k] - (total - back)) + (term - back)
    out[i, k] = total


@scalar
def _load_side(p, q, r, a, origin, row, col, cell):
    """Load the next column of nodes in two rows, local, as corners 1 and 2 of a cell.

    Corners 0, 1, 2, 3 are around the cell: 0 and 3 are 1 and 2 of the one before.
    """
    for k in range(3):
        cell[0, k], cell[3, k] = cell[1, k], cell[2, k]
    for k in range(2):
        cell[1 + k, 0] = load(p, a, 0, row + k, col) - origin[0]
        cell[1 + k, 1] = load(q, a, 1, row + k, col) - origin[1]
        cell[1 + k, 2] = load(r, a, 2, row + k, col) - origin[2]


@scalar
def _load_half(cell, half, rising, c):
    """Load the corners of one triangle of a cell: of 0 1 2 and 0 2 3, or of 0 1 3 and 1 2 3."""
    first = 1 if half == 1 and rising == 0 else 0
    third = 2 if half == 0 and rising == 1 else 3
    for k in range(3):
        c[0, k], c[1, k], c[2, k] = cell[first, k], cell[1 + half, k], cell[third, k]


@scalar
def _add_sums(c, level, sign, i, out):
    """Add a triangle with corners c to row i of the sums; none that lacks a node.

    Columns: six times the volume over a level (two numbers), twice the area (two numbers), products
    of the two longest sides, all sides (both in the norm of absolute values), twice the area in the
    map, the number of triangles, lower and upper corner. Volume and area in the map are below 0
    where normals look down.
    """
    ux, uy, uz = c[1, 0] - c[0, 0], c[1, 1] - c[0, 1], c[1, 2] - c[0, 2]
    vx, vy, vz = c[2, 0] - c[0, 0], c[2, 1] - c[0, 1], c[2, 2] - c[0, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    area = np.sqrt(nx * nx + ny * ny + nz * nz)
    if not area == area:
        return
    u, v = abs(ux) + abs(uy) + abs(uz), abs(vx) + abs(vy) + abs(vz)
    w = abs(ux - vx) + abs(uy - vy) + abs(uz - vz)
    height = (c[0, 2] - level) + (c[1, 2] - level) + (c[2, 2] - level)
    two_sum(out, i, 0, sign * nz * height)
    two_sum(out, i, 2, area)
    out[i, 4] += max(u * v, max(u, v) * w)
    out[i, 5] += u + v + w
    out[i, 6] += sign * nz
    out[i, 7] += 1.0
    for k in range(3):
        out[i, 8 + k] = min(out[i, 8 + k], min(c[0, k], min(c[1, k], c[2, k])))
        out[i, 11 + k] = max(out[i, 11 + k], max(c[0, k], max(c[1, k], c[2, k])))


@entry("d1 d1 d1 l1 l3 l d1 d d2* -> .")
def sums_of_runs(p, q, r, a, label, first_row, origin, level, out):
    """Add to the rows of runs (n_run + 1, N_SUM) the sums over their triangles in some rows, and to
    the last row those of triangles without a label, which exist.
    """
    sign = -1.0 if a[TURNED] != 0 else 1.0
    c, cell = np.empty((3, 3)), np.empty((4, 3))
    none = out.shape[0] - 1
    for row in range(label.shape[0]):
        _load_side(p, q, r, a, origin, first_row + row, 0, cell)
        for col in range(label.shape[1]):
            _load_side(p, q, r, a, origin, first_row + row, col + 1, cell)
            for half in range(2):
                _load_half(cell, half, a[RISING], c)
                i = label[row, col, half]
                _add_sums(c, level, sign, i if i >= 0 else none, out)


@entry("d2 l2 l1 d d2* -> .")
def sums_of_triangles(x, t, row, level, out):
    """Add each triangle to a row of the sums."""
    c = np.empty((3, 3))
    for i in range(t.shape[0]):
        for corner in range(3):
            for k in range(3):
                c[corner, k] = x[t[i, corner], k]
        _add_sums(c, level, 1.0, row[i], out)


# ---- input triangles ----------------------------------------


_LEAST = 2.0**-106  # in place of widths and lengths of 0


@scalar
def _larger(one, two):
    """The larger of two numbers; not a number if one of them is not."""
    return two if two > one or two != two else one


@scalar
def _unit_normal(c, unit):
    """Normal of a triangle with corners c (3, 3), of length 1; and its length before."""
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        one = (c[1, i] - c[0, i]) * (c[2, j] - c[0, j])
        unit[k] = one - (c[1, j] - c[0, j]) * (c[2, i] - c[0, i])
    width = np.sqrt(unit[0] * unit[0] + unit[1] * unit[1] + unit[2] * unit[2])
    width = _larger(_LEAST, width)
    for k in range(3):
        unit[k] /= width
    return width


@scalar
def _beyond(c, unit, point):
    """How far a point is off a triangle: from its plane, or beyond one of its sides."""
    px, py, pz = point[0] - c[0, 0], point[1] - c[0, 1], point[2] - c[0, 2]
    off = abs(px * unit[0] + py * unit[1] + pz * unit[2])
    for i in range(3):
        j = (i + 1) % 3
        ex, ey, ez = c[j, 0] - c[i, 0], c[j, 1] - c[i, 1], c[j, 2] - c[i, 2]
        nx = unit[1] * ez - unit[2] * ey
        ny = unit[2] * ex - unit[0] * ez
        nz = unit[0] * ey - unit[1] * ex
        length = _larger(_LEAST, np.sqrt(nx * nx + ny * ny + nz * nz))
        px, py, pz = point[0] - c[i, 0], point[1] - c[i, 1], point[2] - c[i, 2]
        off = _larger(off, -(px * nx + py * ny + pz * nz) / length)
    return off


@entry("d2 l2 d2 -> d1 d1")
def distances_from_parents(x, t, parents):
    """Largest distance of the corners of each triangle from its input triangle [m], and the size of
    that over its height: slivers have planes with large rounding errors.
    """
    far, slack = np.empty(t.shape[0]), np.empty(t.shape[0])
    c, unit, point = np.empty((3, 3)), np.empty(3), np.empty(3)
    for i in range(t.shape[0]):
        # by the size of each: products of tiny sides underflow
        size = 0.0
        for k in range(3):
            one, two, three = parents[i, k], parents[i, 3 + k], parents[i, 6 + k]
            size = _larger(size, max(one, max(two, three)) - min(one, min(two, three)))
        for corner in range(3):
            for k in range(3):
                c[corner, k] = parents[i, 3 * corner + k] / size
        width = _unit_normal(c, unit)
        off = 0.0
        for corner in range(3):
            for k in range(3):
                point[k] = x[t[i, corner], k] / size
            off = _larger(off, _beyond(c, unit, point))
        far[i], slack[i] = off * size, size / width
    return far, slack


@entry("d2 l2 d2 -> b1")
def copies_of_parents(x, t, parents):
    """Whether each triangle has the corners of its input triangle, in this order, to the bit."""
    is_copy = np.zeros(t.shape[0], dtype=np.bool_)
    for i in range(t.shape[0]):
        for turn in range(3):
            same = True
            for corner in range(3):
                place = 3 * ((corner + turn) % 3)
                for k in range(3):
                    same = same and x[t[i, corner], k] == parents[i, place + k]
            is_copy[i] = is_copy[i] or same
    return is_copy
