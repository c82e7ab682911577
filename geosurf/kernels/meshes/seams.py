"""Seams of cells: sides of parts that face each other around common edges.

Letters as in `parts`, and
    start    first place of each edge in `seams`, and the end
    seams    triangles around edges, in order: 2 * triangle, plus 1 if it runs along the edge
    sides    union-find: part p has the sides 2 p (front, where normals point) and 2 p + 1 (back)
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.exact.bigint import clear, mul_add, sign
from geosurf.kernels.exact.exact_signs import _MISC, LIMBS, _cross, _dot, _vector
from geosurf.kernels.exact.predicates import TINY
from geosurf.kernels.meshes.mesh import join

# ---- radial order ----------------------------------------
# In which order are triangles around an edge? Exactly, by the input triangles that contain them.
#
# Notation
#     x        rounded vertices
#     order    triangles around an edge, and `directions` in which they run along it
#     parent   row of the input triangle (in pt) that contains each triangle
#     px, pt   corners of the input triangles, three rows of px each
#     d        direction of an edge u -> v; n the normal of a triangle
#     direction  +1 where the triangle runs along u -> v, -1 where it runs back
#     around   a row for each triangle around an edge: normal, magnitudes, parent, half turn
#
# Half-planes h = direction n x d are sorted by angle. The sine has the sign of (n1 x n2) . d; as
# n1 x n2 is parallel to d, one component decides, with the sign of that component of d. The cosine
# has the sign of n1 . n2. So only input coordinates enter (degree 4), no constructed point (Weiler
# 1985).
#
# Doubles mostly suffice: projected along the axis on which d is longest, normals become plane
# vectors that turn as the half-planes do. A number that increases with their angle orders them
# where all are farther apart than the rounding error.


OF, HALF, N_AROUND = 6, 7, 8  # columns of `around` behind the normal
# Rounding with u = 2**-53: 4 u of the magnitudes for components of normals, twice that over the
# length plus 7 u for shares, so 46 u times the worst ratio for differences of pseudo-angles.
_TURN_BOUND = 1e-14


@scalar
def main_axis(x, u, v):
    """The axis on which an edge is longest, and whether it increases (1) or decreases (-1)."""
    axis = 0
    for k in range(1, 3):
        if abs(x[v, k] - x[u, k]) > abs(x[v, axis] - x[u, axis]):
            axis = k
    return axis, 1 if x[v, axis] > x[u, axis] else -1


@scalar
def _pseudo_angle(p, q):
    """A number in [0, 4) that increases with the angle of a vector."""
    # The L1 norm replaces the angle: monotone and without trigonometry.
    share = q / (abs(p) + abs(q))
    if p < 0.0:
        return 2.0 - share
    return share if share >= 0.0 else 4.0 + share


@scalar
def sort_by_floats(px, parent, axis, heading, order, directions, n, turns):
    """Sort n triangles around an edge behind the first; False if doubles do not decide."""
    k, o = (axis + 1) % 3, (axis + 2) % 3
    worst_ratio = 1.0
    first = 0.0
    for a in range(n):
        # Two components of the normal across the axis, and their error ratio.
        i = 3 * parent[order[a]]
        pk, po, pa = px[i + 1, k] - px[i, k], px[i + 1, o] - px[i, o], px[i + 1, axis] - px[i, axis]
        qk, qo, qa = px[i + 2, k] - px[i, k], px[i + 2, o] - px[i, o], px[i + 2, axis] - px[i, axis]
        normal_k, normal_o = po * qa - pa * qo, pa * qk - pk * qa
        length = abs(normal_k) + abs(normal_o)
        if not length > TINY:
            return False
        size = abs(po * qa) + abs(pa * qo) + abs(pa * qk) + abs(pk * qa)
        worst_ratio = max(worst_ratio, size / length)

        # Pseudo-angle relative to the first half-plane.
        # Turned by its direction along the edge, the normal is at a right angle to the half-plane,
        # the same for all triangles.
        turn = _pseudo_angle(directions[a] * normal_k, directions[a] * heading * normal_o)
        first = turn if a == 0 else first
        turns[a] = turn - first if turn >= first else turn - first + 4.0

    # Insertion sort; then the smallest gap has to exceed the error bound.
    for a in range(2, n):
        b = a
        while b > 1 and turns[b] < turns[b - 1]:
            turns[b - 1], turns[b] = turns[b], turns[b - 1]
            order[b - 1], order[b] = order[b], order[b - 1]
            directions[b - 1], directions[b] = directions[b], directions[b - 1]
            b -= 1

    # The gap between the last half-plane and the first counts too.
    least = 4.0 - turns[n - 1]
    for a in range(1, n):
        least = min(least, turns[a] - turns[a - 1])
    return least > _TURN_BOUND * worst_ratio


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

    # One component of the cross product of the two normals.
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
    if i == j:  # two parts of one triangle, as along each curve
        return 0
    k, o = (axis + 1) % 3, (axis + 2) % 3

    # Filter with the magnitudes of both normals, then exact integers.
    value = around[a, k] * around[b, o] - around[a, o] * around[b, k]
    size = around[a, 3 + k] * around[b, 3 + o] + around[a, 3 + o] * around[b, 3 + k]
    if size > TINY and abs(value) > 2e-15 * size:
        return 1 if value > 0 else -1
    return _exact_cross(x, t, m, w, i, j, axis)


@scalar
def _dot_sign(x, t, m, w, around, a, b):
    """Sign of the scalar product of the normals of two triangles `around`."""
    i, j = int(around[a, OF]), int(around[b, OF])
    # Two parts of one triangle have the same normal.
    if i == j:
        return 1

    # Filter, then exact integers.
    value = size = 0.0
    for k in range(3):
        value += around[a, k] * around[b, k]
        size += around[a, 3 + k] * around[b, 3 + k]
    if size > TINY and abs(value) > 2e-15 * size:
        return 1 if value > 0 else -1
    return _exact_dot(x, t, m, w, i, j)


@scalar
def _measure_around(px, pt, m, w, order, directions, n, parent, around, axis, heading):
    """Fill `around`: normals, and the half turn behind the first that holds each half-plane.

    False if one coincides with the first half-plane.
    """
    for a in range(n):
        i = parent[order[a]]
        normal = _normal(px, pt, i)
        for k in range(6):
            around[a, k] = normal[k]
        around[a, OF] = i
        half = 0
        if a > 0:
            # The side of the first half-plane decides the half turn.
            direction = directions[0] * directions[a]
            s = direction * heading * _cross_sign(px, pt, m, w, around, 0, a, axis)
            # Parallel and on the same side: one half-plane twice.
            if s == 0 and direction * _dot_sign(px, pt, m, w, around, 0, a) > 0:
                return False
            # Behind the first half-plane, or opposite to it.
            if s <= 0:
                half = 1
        around[a, HALF] = half
    return True


@scalar
def _swap(order, directions, around, a, b):
    order[a], order[b] = order[b], order[a]
    directions[a], directions[b] = directions[b], directions[a]
    for k in range(N_AROUND):
        around[a, k], around[b, k] = around[b, k], around[a, k]


@scalar
def sort_around(x, u, v, order, directions, around, n, parent, px, pt, m, w):
    """Sort n triangles around edge u-v behind the first; False if two share a half-plane."""
    axis, heading = main_axis(x, u, v)
    if not _measure_around(px, pt, m, w, order, directions, n, parent, around, axis, heading):
        return False

    # Insertion sort by half turn, then by the sign of the cross product.
    for a in range(2, n):
        b = a
        while b > 1 and around[b, HALF] <= around[b - 1, HALF]:
            if around[b, HALF] == around[b - 1, HALF]:
                turn = directions[b - 1] * directions[b] * heading
                turn *= _cross_sign(px, pt, m, w, around, b - 1, b, axis)
                if turn == 0:
                    return False
                if turn > 0:
                    break
            _swap(order, directions, around, b - 1, b)
            b -= 1
    return True


DONE, NEEDS_EXACT = -1, -2
_FULL = -1


@scalar
def _gather_around(t, ring, part, start, order, directions):
    """Triangles around the edge of a half-edge and their directions; their number.

    `_FULL` if the arrays are too short.
    """
    n = 0
    u = t[start // 3, start % 3]
    j = start
    while True:
        # Triangles that are left out bound nothing.
        if part[j // 3] >= 0:
            if n == order.shape[0]:
                return _FULL
            order[n] = j // 3
            directions[n] = 1 if t[j // 3, j % 3] == u else -1
            n += 1
        j = ring[j]
        if j == start:
            return n


@entry("d2 l2 l1 l1 l1 l1 d2 l2 l1 l1* l1* l1* -> l")
def sort_seams(x, t, ring, first, part, parent, px, pt, m, w, start, seams):
    """Write the order of the triangles around some edges, by a half-edge of each, to `seams`.

    A triangle counts twice, plus 1 if it runs along the edge as that half-edge does. `start` gets
    the place of the first one of each edge, and the end.

    Returns `DONE`; `NEEDS_EXACT` if `m` is empty and doubles do not decide: call again with it; or
    a half-edge at which two triangles lie in one half-plane.
    """
    # Sixteen triangles around an edge are plenty for most models; the arrays grow.
    order = np.empty(16, dtype=np.int64)
    directions, turns, around = np.empty_like(order), np.empty(16), np.empty((16, N_AROUND))
    n_seam = 0
    for k in range(first.shape[0]):
        edge = first[k]

        # Enlarge the arrays until all triangles around the edge fit.
        n = _gather_around(t, ring, part, first[k], order, directions)
        while n == _FULL:
            order = np.empty(2 * order.shape[0], dtype=np.int64)
            directions, turns = np.empty_like(order), np.empty(order.shape[0])
            around = np.empty((order.shape[0], N_AROUND))
            n = _gather_around(t, ring, part, first[k], order, directions)

        # Up to two triangles need no order; doubles first, then exact signs.
        if n > 2:
            u, v = t[edge // 3, edge % 3], t[edge // 3, (edge + 1) % 3]
            axis, heading = main_axis(x, u, v)
            if not sort_by_floats(px, parent, axis, heading, order, directions, n, turns):
                if m.shape[0] == 0:
                    return NEEDS_EXACT
                if not sort_around(x, u, v, order, directions, around, n, parent, px, pt, m, w):
                    return edge
        start[k] = n_seam
        for a in range(n):
            seams[n_seam] = 2 * order[a] + (1 if directions[a] > 0 else 0)
            n_seam += 1
    start[first.shape[0]] = n_seam
    return DONE


@entry("l1 l1 l1 l1* l1* -> .")
def join_seams(start, seams, part, sides, pieces):
    """Unite sides that face each other across edges, and in `pieces` all parts that touch."""
    for k in range(start.shape[0] - 1):
        low, high = start[k], start[k + 1]
        for a in range(low, high):
            # The last triangle faces the first: the order is cyclic.
            b = a + 1 if a + 1 < high else low
            one, other = part[seams[a] // 2], part[seams[b] // 2]
            join(sides, 2 * one + 1 - seams[a] % 2, 2 * other + seams[b] % 2)
            join(pieces, one, other)
