"""Do triangles lie on the input triangles that they are parts of?

Notation
    x        vertices, float64 (n_vertex, 3)
    t        triangles, int64 (n, 3)
    parents  corners of the input triangle of each, one after the other, float64 (n, 9)
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar

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
    found = np.zeros(t.shape[0], dtype=np.bool_)
    for i in range(t.shape[0]):
        for turn in range(3):
            same = True
            for corner in range(3):
                of = 3 * ((corner + turn) % 3)
                for k in range(3):
                    same = same and x[t[i, corner], k] == parents[i, of + k]
            found[i] = found[i] or same
    return found
