"""Which neighbouring triangles of a mesh meet in common corners and edges only?

Two convex sets are disjoint if a plane separates them. A plane computed with rounding errors is as
good as any: the corners lie on its two sides for certain where their heights exceed the error
bounds. So the result does not depend on how the mesh was made, nor on the classification in
`triangle_contact`; that is used for the pairs that stay undecided here.

three corners in common   the same triangle
two                       separated if not coplanar, or if a projection has the third corners on two
                          sides of the edge
one, none                 separated if the plane half-way between them separates them, or the plane
                          of one has the other on one side, or an edge separates a projection

Notation
    x, t     corners and triangles
    order, nodes, levels   a tree over some triangles, as in `tree`; `order` has rows of t
    boxes    lower and upper corner of each of these, in that order
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.exact.predicates import TINY, filtered_side, orient2d, plane_terms
from geosurf.kernels.search.tree import FAN, LEAF, append_pair, boxes_apart, extent

# Rounding errors relative to the sum of magnitudes: below 8 units (2**-53) for three products of
# differences, below 16 for six products of three factors.
PLANE_BOUND, VOLUME_BOUND = 1e-15, 2e-15
ROUNDING = 1e-14  # relative, of sums of three products of differences: 45 units in the last place


@scalar
def _common(t, a, b, at):
    """Number of common corners; their indices in a and b come first in `at`, then the others."""
    # Nine comparisons of numbers; no coordinates.
    n = 0
    for i in range(3):
        for j in range(3):
            if t[a, i] == t[b, j]:
                at[0, n], at[1, n] = i, j
                n += 1

    # Fill the remaining places, so that every corner can be addressed.
    if n == 1:
        at[0, 1], at[0, 2] = (at[0, 0] + 1) % 3, (at[0, 0] + 2) % 3
        at[1, 1], at[1, 2] = (at[1, 0] + 1) % 3, (at[1, 0] + 2) % 3
    elif n == 2:
        at[0, 2] = 3 - at[0, 0] - at[0, 1]
        at[1, 2] = 3 - at[1, 0] - at[1, 1]
    return n


@scalar
def _turn_sign(x, p, q, r, u, v):
    """Sign of the turn p, q, r on axes u and v; 0 if undecided."""
    left = (x[q, u] - x[p, u]) * (x[r, v] - x[p, v])
    right = (x[q, v] - x[p, v]) * (x[r, u] - x[p, u])
    size = abs(left) + abs(right)
    if size > TINY and abs(left - right) > PLANE_BOUND * size:
        return 1 if left > right else -1
    return 0


@scalar
def _apart_at_edge(x, p, q, a, b):
    """Whether triangles p, q, a and p, q, b certainly meet in their common edge only."""
    ux, uy, uz = x[q, 0] - x[p, 0], x[q, 1] - x[p, 1], x[q, 2] - x[p, 2]
    ax, ay, az = x[a, 0] - x[p, 0], x[a, 1] - x[p, 1], x[a, 2] - x[p, 2]
    bx, by, bz = x[b, 0] - x[p, 0], x[b, 1] - x[p, 1], x[b, 2] - x[p, 2]

    # Four corners in space: not coplanar means separated.
    volume = bx * (uy * az - uz * ay) + by * (uz * ax - ux * az) + bz * (ux * ay - uy * ax)
    size = abs(bx) * (abs(uy * az) + abs(uz * ay)) + abs(by) * (abs(uz * ax) + abs(ux * az))
    size += abs(bz) * (abs(ux * ay) + abs(uy * ax))
    if size > TINY and abs(volume) > VOLUME_BOUND * size:
        return True
    for k in range(3):  # the map first
        u, v = k, (k + 1) % 3
        if _turn_sign(x, p, q, a, u, v) * _turn_sign(x, p, q, b, u, v) < 0:
            return True
    return False


@scalar
def _span(x, t, tri, o, nx, ny, nz):
    """Bounds of the heights of the corners of a triangle over the plane through o."""
    low, high = np.inf, -np.inf
    for i in range(3):
        v = t[tri, i]
        # The corner in the plane has height 0 exactly.
        if v == o:
            continue
        hx, hy, hz = nx * (x[v, 0] - x[o, 0]), ny * (x[v, 1] - x[o, 1]), nz * (x[v, 2] - x[o, 2])
        height = hx + hy + hz

        # Widen by the rounding error on both sides.
        slack = PLANE_BOUND * (abs(hx) + abs(hy) + abs(hz)) + TINY
        low, high = min(low, height - slack), max(high, height + slack)
    return low, high


@scalar
def _bisector(x, p, q, r):
    """Unit vector from p half-way between the directions to q and r."""
    ax, ay, az = x[q, 0] - x[p, 0], x[q, 1] - x[p, 1], x[q, 2] - x[p, 2]
    bx, by, bz = x[r, 0] - x[p, 0], x[r, 1] - x[p, 1], x[r, 2] - x[p, 2]
    a = 1.0 / max(np.sqrt(ax * ax + ay * ay + az * az), TINY)
    b = 1.0 / max(np.sqrt(bx * bx + by * by + bz * bz), TINY)
    cx, cy, cz = ax * a + bx * b, ay * a + by * b, az * a + bz * b
    c = 1.0 / max(np.sqrt(cx * cx + cy * cy + cz * cz), TINY)
    return cx * c, cy * c, cz * c


@scalar
def _off_plane(x, t, a, b, shared):
    """Whether triangle b, a shared corner excluded, is certainly on one side of the plane of a."""
    o = t[a, 0]
    n0, n1, n2, s0, s1, s2, span = plane_terms(x, o, t[a, 1], t[a, 2])

    # All corners have to lie on the same certified side.
    before = 0
    for i in range(3):
        v = t[b, i]
        if v == shared:
            continue
        cx, cy, cz = x[v, 0] - x[o, 0], x[v, 1] - x[o, 1], x[v, 2] - x[o, 2]
        side = filtered_side(cx, cy, cz, n0, n1, n2, s0, s1, s2, span, 0.0)
        # Undecided, or on the other side than a corner before.
        if side == 0 or side == -before:
            return False
        before = side
    return True


@scalar
def _off_edge(x, t, a, b, shared, u, v):
    """Whether an edge of a, on axes u and v, separates it from b, a shared corner excluded."""
    for i in range(3):
        p, q, r = t[a, i], t[a, (i + 1) % 3], t[a, (i + 2) % 3]
        # The shared corner is a corner of b too, on the inner side: this edge cannot separate b.
        if r == shared:
            continue

        # r is the corner of a opposite to the edge; b has to lie on the other side.
        side = _turn_sign(x, p, q, r, u, v)
        parted = side != 0
        for j in range(3):
            c = t[b, j]
            if parted and c != shared:
                parted = _turn_sign(x, p, q, c, u, v) == -side
        if parted:
            return True
    return False


@scalar
def _separated_by_face(x, t, a, b, shared):
    """Whether the plane or an edge of one of two triangles separates them."""
    if _off_plane(x, t, a, b, shared) or _off_plane(x, t, b, a, shared):
        return True
    for k in range(3):
        u, v = k, (k + 1) % 3
        if _off_edge(x, t, a, b, shared, u, v) or _off_edge(x, t, b, a, shared, u, v):
            return True
    return False


@scalar
def _apart_at_corner(x, t, a, b, at):
    """Whether a plane half-way separates triangles except for their common corner."""
    o = t[a, at[0, 0]]
    ax, ay, az = _bisector(x, o, t[a, at[0, 1]], t[a, at[0, 2]])
    bx, by, bz = _bisector(x, o, t[b, at[1, 1]], t[b, at[1, 2]])
    # Half-way between both bisectors: the plane across their difference.
    nx, ny, nz = ax - bx, ay - by, az - bz
    return _span(x, t, a, o, nx, ny, nz)[0] > 0.0 > _span(x, t, b, o, nx, ny, nz)[1]


@scalar
def _apart_midway(x, t, a, b):
    """Whether a plane half-way separates triangles without a common corner."""
    # Three times the vector between the middles of both triangles.
    nx = x[t[a, 0], 0] + x[t[a, 1], 0] + x[t[a, 2], 0]
    ny = x[t[a, 0], 1] + x[t[a, 1], 1] + x[t[a, 2], 1]
    nz = x[t[a, 0], 2] + x[t[a, 1], 2] + x[t[a, 2], 2]
    nx -= x[t[b, 0], 0] + x[t[b, 1], 0] + x[t[b, 2], 0]
    ny -= x[t[b, 0], 1] + x[t[b, 1], 1] + x[t[b, 2], 1]
    nz -= x[t[b, 0], 2] + x[t[b, 1], 2] + x[t[b, 2], 2]
    o = t[a, 0]  # its own height is 0
    return min(0.0, _span(x, t, a, o, nx, ny, nz)[0]) > _span(x, t, b, o, nx, ny, nz)[1]


@scalar
def separated_triangles(x, t, a, b, at):
    """Whether two triangles certainly meet in common corners and edges only."""
    n = _common(t, a, b, at)
    # The same corners: nothing of either triangle lies outside of what they have in common.
    if n == 3:
        return True
    if n == 2:
        p, q = t[a, at[0, 0]], t[a, at[0, 1]]
        return _apart_at_edge(x, p, q, t[a, at[0, 2]], t[b, at[1, 2]])
    if n == 1:
        return _apart_at_corner(x, t, a, b, at) or _separated_by_face(x, t, a, b, t[a, at[0, 0]])
    return _apart_midway(x, t, a, b) or _separated_by_face(x, t, a, b, -1)


@scalar
def plane_of(x, t, f, p):
    """Write normal, bounds of its terms, and a corner of a triangle to p (9,)."""
    a, b, c = t[f, 0], t[f, 1], t[f, 2]
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        left = (x[b, i] - x[a, i]) * (x[c, j] - x[a, j])
        right = (x[b, j] - x[a, j]) * (x[c, i] - x[a, i])
        p[k] = left - right
        p[3 + k] = abs(left) + abs(right)
        p[6 + k] = x[a, k]


@scalar
def is_beside_plane(x, t, p, a, b):
    """Whether triangle b is certainly on one side of the plane p of a, shared corners excluded.

    Then both meet in these corners only, and in the edge between two of them.
    """
    before = 0
    for i in range(3):
        v = t[b, i]
        if v == t[a, 0] or v == t[a, 1] or v == t[a, 2]:
            continue
        height = size = 0.0
        for k in range(3):
            d = x[v, k] - p[6 + k]
            height += p[k] * d
            size += p[3 + k] * abs(d)
        if not (size > TINY and abs(height) > ROUNDING * size):
            return False
        side = 1 if height > 0.0 else -1
        if side == -before:
            return False
        before = side
    return before != 0


@scalar
def _box_off_plane(p, boxes, i):
    """Whether a box is certainly on one side of a plane."""
    low = high = size = 0.0
    for k in range(3):
        near, far = boxes[i, k] - p[6 + k], boxes[i, 3 + k] - p[6 + k]
        low += min(p[k] * near, p[k] * far)
        high += max(p[k] * near, p[k] * far)
        size += p[3 + k] * max(abs(near), abs(far))
    return size > TINY and max(low, -high) > ROUNDING * size


@entry("d2 l2 d2 l1 d2 d2 l1 d2 l2 b l l l2* -> l")
def undecided_pairs(
    x, t, boxes, order, nodes, other_boxes, other_order, other_nodes, levels, same, first, last,
    pairs,
):  # fmt: skip
    """Pairs of triangles of two trees that are not certainly separated, lower row first; their
    number.

    Of triangles of the first tree at the places from `first` up to `last` in its order, as `boxes`
    are; `levels` is of the other tree. They are written up to capacity. With `same`, the two trees
    are one, and each pair is found from its first place.
    """
    common, stack = np.empty((2, 9), dtype=np.int64), np.empty((64 * FAN, 2), dtype=np.int64)
    p, n_all, n = np.empty(9), other_order.shape[0], 0
    root = other_nodes.shape[0] - 1
    for s in range(first, last):
        if boxes_apart(nodes, s // LEAF, other_nodes, root) or boxes_apart(
            boxes, s, other_nodes, root
        ):
            continue
        a = order[s]
        plane_of(x, t, a, p)
        begin = s + 1 if same else 0
        width = extent(boxes, s)
        stack[0, 0], stack[0, 1] = root, levels.shape[0] - 1
        top = 1
        while top > 0:
            top -= 1
            node, level = stack[top, 0], stack[top, 1]
            # The box of a large triangle meets many nodes, its plane passes few of them.
            if extent(other_nodes, node) < width and _box_off_plane(p, other_nodes, node):
                continue
            at = node - levels[level, 0]
            if level > 0:
                size, below = LEAF * FAN ** (level - 1), levels[level - 1, 0]
                low = max(at * FAN, begin // size)
                for k in range(low, min((at + 1) * FAN, levels[level - 1, 2])):
                    if not boxes_apart(boxes, s, other_nodes, below + k):
                        stack[top, 0], stack[top, 1] = below + k, level - 1
                        top += 1
                continue
            for k in range(max(at * LEAF, begin), min((at + 1) * LEAF, n_all)):
                if boxes_apart(boxes, s, other_boxes, k):
                    continue
                b = other_order[k]
                if not (is_beside_plane(x, t, p, a, b) or separated_triangles(x, t, a, b, common)):
                    n = append_pair(pairs, n, min(a, b), max(a, b))
    return n


# ---- graphs ----------------------------------------
# Most surfaces are graphs over a coordinate plane: no two triangles overlap there. Where all turn
# the same way and two at an edge run through it both ways, as many triangles lie over a place as
# the rim of the surface goes round it. So the rim bounds what two triangles cover: if anything
# overlaps, a triangle at the rim does.


_MIXED = 2


@entry("d2 l2 l1 l1 l l1* l1* -> l1 b1")
def planes_of_surfaces(x, t, surface, ring, n_surface, m, w):
    """The coordinate plane (axis k and the next) on which all triangles of a surface turn the same
    way, -1 for none; and whether each triangle has an edge that no other one of its surface has.

    `ring` is the next half-edge around the same edge. A surface with two triangles that run through
    an edge the same way has no plane; so there is none with three at an edge.
    """
    turn, rim = np.zeros((n_surface, 3), dtype=np.int64), np.zeros(t.shape[0], dtype=np.bool_)
    for i in range(t.shape[0]):
        turns = turn[surface[i]]
        for k in range(3):
            if turns[k] != _MIXED:
                side = orient2d(x, m, w, t[i, 0], t[i, 1], t[i, 2], k, (k + 1) % 3)
                turns[k] = _MIXED if side == 0 or side == -turns[k] else side
        for k in range(3):
            alone, half = True, ring[3 * i + k]
            while half != 3 * i + k:
                if surface[half // 3] == surface[i]:
                    alone = False
                    if t[half // 3, half % 3] == t[i, k]:
                        turns[:] = _MIXED
                half = ring[half]
            if alone:
                rim[i] = True

    plane = np.full(n_surface, -1)
    for s in range(n_surface):
        for k in range(3):
            if plane[s] < 0 and turn[s, k] != _MIXED:
                plane[s] = k
    return plane, rim
