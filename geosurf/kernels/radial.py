"""Sides of triangles -> cells: exact radial order around edges, and union-find.

Notation
    t        triangles, int64 (n, 3); x their rounded vertices
    keep     1 for triangles that take part
    parent   row of the input triangle (in pt) that each triangle is a part of
    px, pt   corners of the input triangles
    d        direction of an edge u -> v; n the normal of a triangle
    forward  +1 where the triangle runs along u -> v, -1 where it runs back

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
def cross_sign(x, t, m, w, i, j, axis):
    """Sign of component `axis` of n_i x n_j."""
    p, q = _normal(x, t, i), _normal(x, t, j)
    k, o = (axis + 1) % 3, (axis + 2) % 3
    value = p[k] * q[o] - p[o] * q[k]
    size = p[3 + k] * q[3 + o] + p[3 + o] * q[3 + k]
    if size > TINY:
        if value > 2e-15 * size:
            return 1
        if -value > 2e-15 * size:
            return -1
    n = m[LIMBS]
    r = (_MISC + 100) * n
    _exact_normals(x, t, m, w, i, j, r)
    acc = r + 12 * n
    clear(w, acc, 4 * n + 1)
    mul_add(w, acc, 4 * n + 1, r + k * 2 * n, 2 * n, r + (3 + o) * 2 * n, 2 * n, 1)
    mul_add(w, acc, 4 * n + 1, r + o * 2 * n, 2 * n, r + (3 + k) * 2 * n, 2 * n, -1)
    return sign(w, acc, 4 * n + 1)


@scalar
def dot_sign(x, t, m, w, i, j):
    """Sign of n_i . n_j."""
    p, q = _normal(x, t, i), _normal(x, t, j)
    value = p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
    size = p[3] * q[3] + p[4] * q[4] + p[5] * q[5]
    if size > TINY:
        if value > 2e-15 * size:
            return 1
        if -value > 2e-15 * size:
            return -1
    n = m[LIMBS]
    r = (_MISC + 100) * n
    _exact_normals(x, t, m, w, i, j, r)
    acc = r + 12 * n
    _dot(w, acc, 4 * n + 1, r, 2 * n, r + 6 * n, 2 * n)
    return sign(w, acc, 4 * n + 1)


@scalar
def _before(px, pt, m, w, first, first_way, i, way_i, j, way_j, axis, heading):
    """1 if half-plane i comes before j, turning from the first; 0 if after, -1 if equal."""
    half_i = (
        0 if i == first else _turned_half(px, pt, m, w, first, first_way, i, way_i, axis, heading)
    )
    half_j = (
        0 if j == first else _turned_half(px, pt, m, w, first, first_way, j, way_j, axis, heading)
    )
    if half_i != half_j:
        return 1 if half_i < half_j else 0
    s = way_i * way_j * heading * cross_sign(px, pt, m, w, i, j, axis)
    if s == 0:
        return -1
    return 1 if s > 0 else 0


@scalar
def _turned_half(px, pt, m, w, first, first_way, i, way, axis, heading):
    s = first_way * way * heading * cross_sign(px, pt, m, w, first, i, axis)
    if s != 0:
        return 0 if s > 0 else 1
    return 0 if first_way * way * dot_sign(px, pt, m, w, first, i) > 0 else 1


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
def _sort_around(x, u, v, order, ways, n, parent, px, pt, m, w):
    """Sort n triangles around edge u-v behind the first; False if two share a half-plane."""
    axis = 0
    for k in range(1, 3):
        if abs(x[v, k] - x[u, k]) > abs(x[v, axis] - x[u, axis]):
            axis = k
    heading = 1 if x[v, axis] > x[u, axis] else -1
    for a in range(2, n):
        b = a
        while b > 1:
            p, q = parent[order[b - 1]], parent[order[b]]
            before = _before(
                px, pt, m, w, parent[order[0]], ways[0], q, ways[b], p, ways[b - 1], axis, heading
            )
            if before < 0:
                return False
            if before == 0:
                break
            order[b], order[b - 1] = order[b - 1], order[b]
            ways[b], ways[b - 1] = ways[b - 1], ways[b]
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
            if not _sort_around(x, u, v, order, ways, n, parent, px, pt, m, w):
                return start
        for k in range(n):
            other = (k + 1) % n
            here = _side_after(order[k], ways[k])
            there = _side_after(order[other], -ways[other])
            join(sides, here, there)
    return -1
