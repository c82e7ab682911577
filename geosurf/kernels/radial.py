"""Sides of triangles -> cells: exact radial order around edges, and union-find.

Notation
    t        triangles, int64 (n, 3); x their rounded vertices
    keep     1 for triangles that take part
    parent   row of the input triangle (in pt) that each triangle is a part of
    px, pt   corners of the input triangles
    d        direction of an edge u -> v; n the normal of a triangle
    forward  +1 where the triangle runs along u -> v, -1 where it runs back
    around   a row for each triangle around an edge: normal, magnitudes, parent, half turn

Triangle i has the sides 2 i (front, where the normal points) and 2 i + 1 (back). Around an
edge, half-planes h = forward n x d are sorted by angle: sin has the sign of (n1 x n2) . d, and as
n1 x n2 is parallel to d, one component decides, with the sign of that component of d;
cos has the sign of n1 . n2. So only input coordinates enter (degree 4), no constructed point.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels._jit import entry, scalar
from geosurf.kernels.exact import _MISC, LIMBS, _cross, _dot, _vector
from geosurf.kernels.limbs import clear, mul_add, sign
from geosurf.kernels.mesh import join
from geosurf.kernels.predicates import TINY

OF, HALF, N_AROUND = 6, 7, 8  # columns of `around` behind the normal


@scalar
def _normal(x, t, i):
    """Normal of a triangle and the sum of the magnitudes of its terms, as six doubles."""
    a, b, c = t[i, 0], t[i, 1], t[i, 2]
    px, py, pz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    qx, qy, qz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
    return (
        py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx,
        abs(py * qz) + abs(pz * qy), abs(pz * qx) + abs(px * qz), abs(px * qy) + abs(py * qx),
    )  # fmt: skip


@scalar
def _exact_normals(x, t, m, w, i, j, r):
    """Exact normals of triangles i and j, 3 x 2 units each, at r."""
    n = m[LIMBS]
    u = _MISC * n
    for k in range(2):
        tri = i if k == 0 else j
        _vector(x, m, w, u, t[tri, 0], t[tri, 1])
        _vector(x, m, w, u + 3 * n, t[tri, 0], t[tri, 2])
        _cross(w, r + k * 6 * n, 2 * n, u, n, u + 3 * n, n)


@scalar
def _exact_cross(x, t, m, w, i, j, axis):
    """Sign of component `axis` of n_i x n_j, in exact numbers."""
    k, o = (axis + 1) % 3, (axis + 2) % 3
    n = m[LIMBS]
    r = (_MISC + 100) * n
    _exact_normals(x, t, m, w, i, j, r)
    acc = r + 12 * n
    clear(w, acc, 4 * n + 1)
    mul_add(w, acc, 4 * n + 1, r + k * 2 * n, 2 * n, r + (3 + o) * 2 * n, 2 * n, 1)
    mul_add(w, acc, 4 * n + 1, r + o * 2 * n, 2 * n, r + (3 + k) * 2 * n, 2 * n, -1)
    return sign(w, acc, 4 * n + 1)


@scalar
def _exact_dot(x, t, m, w, i, j):
    """Sign of n_i . n_j, in exact numbers."""
    n = m[LIMBS]
    r = (_MISC + 100) * n
    _exact_normals(x, t, m, w, i, j, r)
    acc = r + 12 * n
    _dot(w, acc, 4 * n + 1, r, 2 * n, r + 6 * n, 2 * n)
    return sign(w, acc, 4 * n + 1)


@scalar
def _cross_sign(x, t, m, w, around, a, b, axis):
    """Sign of component `axis` of the cross product of the normals of two triangles `around`."""
    i, j = int(around[a, OF]), int(around[b, OF])
    if i == j:  # two parts of one triangle, as beside each curve: no need of exact numbers
        return 0
    k, o = (axis + 1) % 3, (axis + 2) % 3
    value = around[a, k] * around[b, o] - around[a, o] * around[b, k]
    size = around[a, 3 + k] * around[b, 3 + o] + around[a, 3 + o] * around[b, 3 + k]
    if size > TINY and abs(value) > 2e-15 * size:
        return 1 if value > 0 else -1
    return _exact_cross(x, t, m, w, i, j, axis)


@scalar
def _dot_sign(x, t, m, w, around, a, b):
    """Sign of the scalar product of the normals of two triangles `around`."""
    i, j = int(around[a, OF]), int(around[b, OF])
    if i == j:
        return 1
    value = size = 0.0
    for k in range(3):
        value += around[a, k] * around[b, k]
        size += around[a, 3 + k] * around[b, 3 + k]
    if size > TINY and abs(value) > 2e-15 * size:
        return 1 if value > 0 else -1
    return _exact_dot(x, t, m, w, i, j)


@scalar
def _measure_around(px, pt, m, w, order, ways, n, parent, around, axis, heading):
    """Fill `around`: normals, and the half turn behind the first that each half-plane is in."""
    for a in range(n):
        i = parent[order[a]]
        normal = _normal(px, pt, i)
        for k in range(6):
            around[a, k] = normal[k]
        around[a, OF] = i
        half = 0
        if a > 0:
            way = ways[0] * ways[a]
            s = way * heading * _cross_sign(px, pt, m, w, around, 0, a, axis)
            if s < 0 or (s == 0 and way * _dot_sign(px, pt, m, w, around, 0, a) < 0):
                half = 1
        around[a, HALF] = half


@scalar
def _swap(order, ways, around, a, b):
    order[a], order[b] = order[b], order[a]
    ways[a], ways[b] = ways[b], ways[a]
    for k in range(N_AROUND):
        around[a, k], around[b, k] = around[b, k], around[a, k]


@scalar
def _side_after(tri, way):
    """The side of a triangle met when turning on counter-clockwise around the edge."""
    return 2 * tri if way > 0 else 2 * tri + 1


@scalar
def _doubled(values):
    larger = np.empty(2 * values.shape[0], dtype=np.int64)
    larger[: values.shape[0]] = values
    return larger


@scalar
def _sort_around(x, u, v, order, ways, around, n, parent, px, pt, m, w):
    """Sort n triangles around edge u-v behind the first; False if two share a half-plane."""
    axis = 0
    for k in range(1, 3):
        if abs(x[v, k] - x[u, k]) > abs(x[v, axis] - x[u, axis]):
            axis = k
    heading = 1 if x[v, axis] > x[u, axis] else -1
    _measure_around(px, pt, m, w, order, ways, n, parent, around, axis, heading)
    for a in range(2, n):
        b = a
        while b > 1 and around[b, HALF] <= around[b - 1, HALF]:
            if around[b, HALF] == around[b - 1, HALF]:
                turn = ways[b - 1] * ways[b] * heading
                turn *= _cross_sign(px, pt, m, w, around, b - 1, b, axis)
                if turn == 0:
                    return False
                if turn > 0:
                    break
            _swap(order, ways, around, b - 1, b)
            b -= 1
    return True


@entry("l2 l1 l1 l1 -> .")
def join_run_sides(pairs, on_rim, keep, sides):
    """Unite the sides of runs that share an edge, and both sides of runs on a rim.

    Runs follow the `keep.shape[0] - on_rim.shape[0]` triangles, and face as their lattice does.
    """
    first = keep.shape[0] - on_rim.shape[0]
    for i in range(pairs.shape[0]):
        a, b = first + pairs[i, 0], first + pairs[i, 1]
        if keep[a] == 1 and keep[b] == 1:
            join(sides, 2 * a, 2 * b)
            join(sides, 2 * a + 1, 2 * b + 1)
    for i in range(on_rim.shape[0]):
        if on_rim[i] == 1 and keep[first + i] == 1:
            join(sides, 2 * (first + i), 2 * (first + i) + 1)


@entry("d2 l2 l1 l1 l1 l1 d2 l2 l1 l1 l1 -> l")
def join_sides(x, t, ring, link, keep, parent, px, pt, m, w, sides):
    """Unite sides that see each other across edges; returns -1, or a half-edge of a place where
    two triangles lie in one half-plane.

    Behind a half-edge that is alone lies the run `link` (counted behind the triangles), which
    faces the same way, or nothing (-1).
    """
    order = np.empty(64, dtype=np.int64)
    ways = np.empty(64, dtype=np.int64)
    around = np.empty((64, N_AROUND))
    for start in range(3 * t.shape[0]):
        if keep[start // 3] == 0:
            continue
        n = 0
        u = t[start // 3, start % 3]
        j = start
        while True:
            if keep[j // 3] != 0:
                if j < start:
                    n = 0  # this edge has had its turn
                    break
                if n == order.shape[0]:
                    order, ways = _doubled(order), _doubled(ways)
                    around = np.empty((order.shape[0], N_AROUND))
                order[n] = j // 3
                ways[n] = 1 if t[j // 3, j % 3] == u else -1
                n += 1
            j = ring[j]
            if j == start:
                break
        if n == 0:
            continue
        run = t.shape[0] + link[start]
        if link[start] >= 0 and keep[run] == 1:
            join(sides, 2 * order[0], 2 * run)
            join(sides, 2 * order[0] + 1, 2 * run + 1)
            continue
        if n > 2:
            v = t[start // 3, (start + 1) % 3]
            if not _sort_around(x, u, v, order, ways, around, n, parent, px, pt, m, w):
                return start
        for k in range(n):
            other = (k + 1) % n
            here = _side_after(order[k], ways[k])
            there = _side_after(order[other], -ways[other])
            join(sides, here, there)
    return -1
