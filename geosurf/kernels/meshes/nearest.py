"""Distance from points to the nearest of many triangles, by a tree of boxes.

The tree is that of `geosurf.kernels.search.tree` for a list of triangles. The search descends into
the nearest box first and leaves out boxes that are farther away than the best triangle so far. The
triangle that was nearest to the point before is tried first: points next to each other then visit a
few boxes only, so points come in Morton order. In a leaf, the box of a triangle is tested first.

Notation
    x, t                   points (n, 3) and triangles (m, 3)
    order, nodes, levels   the tree
    d                      squared distances
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.lattice_corners import spread_bits
from geosurf.kernels.search.tree import FAN, LEAF

_CELLS = 1023.0  # ten bits along each axis
_SLIP = 1e-12  # of the largest coordinate: more than distances are off by rounding


@scalar
def _box_distance(nodes, i, px, py, pz):
    """Squared distance to a box; 0 inside it."""
    dx = max(nodes[i, 0] - px, 0.0, px - nodes[i, 3])
    dy = max(nodes[i, 1] - py, 0.0, py - nodes[i, 4])
    dz = max(nodes[i, 2] - pz, 0.0, pz - nodes[i, 5])
    return dx * dx + dy * dy + dz * dz


@scalar
def _edge_distance(px, py, pz, ux, uy, uz):
    """Squared distance from p to the edge from the origin to u."""
    length = ux * ux + uy * uy + uz * uz
    at = px * ux + py * uy + pz * uz
    at = min(max(at / length, 0.0), 1.0) if length > 0.0 else 0.0
    dx, dy, dz = px - at * ux, py - at * uy, pz - at * uz
    return dx * dx + dy * dy + dz * dz


@scalar
def _triangle_distance(x, t, row, px, py, pz):
    """Squared distance to a triangle."""
    a, b, c = t[row, 0], t[row, 1], t[row, 2]
    ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    vx, vy, vz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
    qx, qy, qz = px - x[a, 0], py - x[a, 1], pz - x[a, 2]

    # Inside the prism over the triangle the distance is that to the plane.
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    area = nx * nx + ny * ny + nz * nz
    if area > 0.0:
        # barycentric weights of the foot of the perpendicular, times `area`
        wx, wy, wz = uy * qz - uz * qy, uz * qx - ux * qz, ux * qy - uy * qx
        third = wx * nx + wy * ny + wz * nz
        wx, wy, wz = qy * vz - qz * vy, qz * vx - qx * vz, qx * vy - qy * vx
        second = wx * nx + wy * ny + wz * nz
        if second >= 0.0 and third >= 0.0 and second + third <= area:
            height = qx * nx + qy * ny + qz * nz
            return height * height / area

    # Otherwise it is that to the nearest edge.
    d = _edge_distance(qx, qy, qz, ux, uy, uz)
    d = min(d, _edge_distance(qx, qy, qz, vx, vy, vz))
    return min(d, _edge_distance(qx - ux, qy - uy, qz - uz, vx - ux, vy - uy, vz - uz))


@scalar
def _widened(best, slip):
    """Squared distance that is farther than the best one by a slip."""
    far = np.sqrt(best) + slip
    return far * far * (1.0 + _SLIP)


@scalar
def _is_beyond(x, t, row, px, py, pz, wide):
    """Whether the box of a triangle is no nearer than a distance: a cheap test."""
    a, b, c = t[row, 0], t[row, 1], t[row, 2]
    total = 0.0
    for k in range(3):
        p = (px, py, pz)[k]
        low, high = min(x[a, k], min(x[b, k], x[c, k])), max(x[a, k], max(x[b, k], x[c, k]))
        d = max(low - p, max(0.0, p - high))
        total += d * d
    return total >= wide


@scalar
def _push_nearer(nodes, levels, node, level, px, py, pz, wide, stack, far, top):
    """Push the children of a node that are nearer than a distance, the nearest on top."""
    first = levels[level - 1, 0] + (node - levels[level, 0]) * FAN
    begin = top
    for child in range(first, min(first + FAN, levels[level, 0])):
        d = _box_distance(nodes, child, px, py, pz)
        if d >= wide:
            continue

        # insertion sort: the farthest at the bottom
        k = top
        while k > begin and far[k - 1] < d:
            stack[k, 0], stack[k, 1], far[k] = stack[k - 1, 0], stack[k - 1, 1], far[k - 1]
            k -= 1
        stack[k, 0], stack[k, 1], far[k] = child, level - 1, d
        top += 1
    return top


@entry("d2 l2 l1 d2 l2 d2 d1* -> .")
def nearest_distance(x, t, order, nodes, levels, p, out):
    """Write the distance from each point to the nearest triangle; there is at least one."""
    # a little farther than the best one is looked at, too: rounding then decides nothing, and the
    # distance is the least of all triangles, whatever the order
    slip = 0.0
    for k in range(6):
        slip = max(slip, _SLIP * abs(nodes[nodes.shape[0] - 1, k]))
    stack = np.empty((FAN * (levels.shape[0] + 1) + 8, 2), dtype=np.int64)
    far = np.empty(stack.shape[0])
    nearest = 0
    for i in range(p.shape[0]):
        px, py, pz = p[i, 0], p[i, 1], p[i, 2]
        best = _triangle_distance(x, t, nearest, px, py, pz)
        wide = _widened(best, slip)
        stack[0, 0], stack[0, 1], far[0], top = nodes.shape[0] - 1, levels.shape[0] - 1, 0.0, 1
        while top > 0:
            top -= 1
            if far[top] >= wide:
                continue
            node, level = stack[top, 0], stack[top, 1]
            if level > 0:
                top = _push_nearer(nodes, levels, node, level, px, py, pz, wide, stack, far, top)
                continue
            for k in range(LEAF * node, min(LEAF * node + LEAF, order.shape[0])):
                if _is_beyond(x, t, order[k], px, py, pz, wide):
                    continue
                d = _triangle_distance(x, t, order[k], px, py, pz)
                if d < best:
                    best, nearest = d, order[k]
                    wide = _widened(best, slip)
        out[i] = np.sqrt(best)


@entry("d2 d1 -> l1")
def point_codes(p, box):
    """Morton codes of points in cubes; `box` is their common box."""
    span = max(box[3] - box[0], max(box[4] - box[1], box[5] - box[2]))
    scale = _CELLS / span if 1e-290 < span < 1e290 else 0.0
    codes = np.empty(p.shape[0], dtype=np.int64)
    for i in range(p.shape[0]):
        code = 0
        for k in range(3):
            cell = min(max((p[i, k] - box[k]) * scale, 0.0), _CELLS)
            code |= spread_bits(int(cell)) << k
        codes[i] = code
    return codes
