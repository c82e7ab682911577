"""Which triangles are near: a tree of boxes over triangles in Morton order.

Triangles are sorted by the Morton code of their middle (counting sort, linear), leaves hold
LEAF of them in a row, and each node above holds FAN nodes; so the tree needs no pointers. Two
trees are walked together. Where one side is a leaf, its triangles' planes are tested against the
box of the other side as well: a huge flat face (a planar fault, a wall) reaches the boxes of half
a horizon, but its plane passes few of them.

Notation
    boxes    float64 (n, 6) of triangles: lower x, y, z, upper x, y, z
    order    triangles in Morton order, int64 (n,)
    nodes    boxes of nodes, float64 (n_node, 6): leaves first, then level by level
    levels   first node of each level, int64 (n_level + 1,)
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels._jit import entry, scalar

LEAF = 8
FAN = 8


@scalar
def _spread(v):
    """Bits of v < 2**10 at every third place."""
    v = (v | (v << 16)) & 0x030000FF
    v = (v | (v << 8)) & 0x0300F00F
    v = (v | (v << 4)) & 0x030C30C3
    return (v | (v << 2)) & 0x09249249


@entry("d2 -> l1")
def morton_order(boxes):
    """Triangles sorted by the Morton code of the middle of their box; equal codes by row."""
    n = boxes.shape[0]
    low = np.full(3, np.inf)
    high = np.full(3, -np.inf)
    for i in range(n):
        for a in range(3):
            middle = boxes[i, a] + boxes[i, 3 + a]
            low[a] = min(low[a], middle)
            high[a] = max(high[a], middle)
    bits = 1
    while bits < 8 and (1 << (3 * bits)) < n:
        bits += 1
    span = max(high[0] - low[0], max(high[1] - low[1], high[2] - low[2]))
    scale = (1 << bits) / span if span > 0.0 else 0.0
    code = np.empty(n, dtype=np.int64)
    top = (1 << bits) - 1
    for i in range(n):
        key = 0
        for a in range(3):
            cell = int((boxes[i, a] + boxes[i, 3 + a] - low[a]) * scale)
            key |= _spread(min(cell, top)) << a
        code[i] = key
    start = np.zeros((1 << (3 * bits)) + 1, dtype=np.int64)
    for i in range(n):
        start[code[i] + 1] += 1
    for c in range(1, start.shape[0]):
        start[c] += start[c - 1]
    order = np.empty(n, dtype=np.int64)
    for i in range(n):
        order[start[code[i]]] = i
        start[code[i]] += 1
    return order


@scalar
def _grow(nodes, i, boxes, j):
    for a in range(3):
        nodes[i, a] = min(nodes[i, a], boxes[j, a])
        nodes[i, 3 + a] = max(nodes[i, 3 + a], boxes[j, 3 + a])


@entry("d2 l1 -> d2 l1")
def build_tree(boxes, order):
    """Boxes of all nodes, and the first node of each level."""
    n = order.shape[0]
    levels = np.zeros(40, dtype=np.int64)
    count = (n + LEAF - 1) // LEAF
    n_level = 1
    levels[1] = count
    while count > 1:
        count = (count + FAN - 1) // FAN
        levels[n_level + 1] = levels[n_level] + count
        n_level += 1
    nodes = np.empty((levels[n_level], 6), dtype=np.float64)
    for i in range(nodes.shape[0]):
        for a in range(3):
            nodes[i, a] = np.inf
            nodes[i, 3 + a] = -np.inf
    for k in range(n):
        _grow(nodes, k // LEAF, boxes, order[k])
    for level in range(1, n_level):
        below = levels[level - 1]
        for i in range(below, levels[level]):
            _grow(nodes, levels[level] + (i - below) // FAN, nodes, i)
    return nodes, levels[: n_level + 1].copy()


@scalar
def _apart(p, i, q, j):
    """Whether two boxes do not meet."""
    for a in range(3):
        if p[i, a] > q[j, 3 + a] or q[j, a] > p[i, 3 + a]:
            return True
    return False


@scalar
def _beside(x, t, tri, boxes, j):
    """Whether a box lies strictly on one side of a triangle's plane, for sure."""
    o, b, c = t[tri, 0], t[tri, 1], t[tri, 2]
    ax, ay, az = x[b, 0] - x[o, 0], x[b, 1] - x[o, 1], x[b, 2] - x[o, 2]
    bx, by, bz = x[c, 0] - x[o, 0], x[c, 1] - x[o, 1], x[c, 2] - x[o, 2]
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    sx = abs(ay * bz) + abs(az * by)
    sy = abs(az * bx) + abs(ax * bz)
    sz = abs(ax * by) + abs(ay * bx)
    mx = 0.5 * (boxes[j, 0] + boxes[j, 3]) - x[o, 0]
    my = 0.5 * (boxes[j, 1] + boxes[j, 4]) - x[o, 1]
    mz = 0.5 * (boxes[j, 2] + boxes[j, 5]) - x[o, 2]
    rx = 0.5 * (boxes[j, 3] - boxes[j, 0])
    ry = 0.5 * (boxes[j, 4] - boxes[j, 1])
    rz = 0.5 * (boxes[j, 5] - boxes[j, 2])
    height = abs(nx * mx + ny * my + nz * mz)
    reach = abs(nx) * rx + abs(ny) * ry + abs(nz) * rz
    # coordinates of the frame bound every rounding of middles and differences
    size = abs(boxes[j, 0]) + abs(boxes[j, 3]) + abs(boxes[j, 1]) + abs(boxes[j, 4])
    size += abs(boxes[j, 2]) + abs(boxes[j, 5]) + abs(x[o, 0]) + abs(x[o, 1]) + abs(x[o, 2])
    span = abs(ax) + abs(ay) + abs(az) + abs(bx) + abs(by) + abs(bz)
    far = abs(mx) + abs(my) + abs(mz) + rx + ry + rz
    return height > reach + size * (1e-14 * (sx + sy + sz) + 4e-15 * far * span)


@scalar
def _leaf_beside(x, t, order, leaf, boxes, j):
    """Whether a box is beside the planes of all triangles of a leaf."""
    for k in range(LEAF * leaf, min(LEAF * leaf + LEAF, order.shape[0])):
        if not _beside(x, t, order[k], boxes, j):
            return False
    return True


@scalar
def _emit(xa, ta, ba, oa, leaf_a, xb, tb, bb, ob, leaf_b, same, pairs, n):
    """Pairs of the triangles of two leaves whose boxes meet."""
    for p in range(LEAF * leaf_a, min(LEAF * leaf_a + LEAF, oa.shape[0])):
        a = oa[p]
        for q in range(LEAF * leaf_b, min(LEAF * leaf_b + LEAF, ob.shape[0])):
            b = ob[q]
            if _apart(ba, a, bb, b):
                continue
            if same:
                if leaf_a == leaf_b and b <= a:
                    continue
            elif _beside(xa, ta, a, bb, b) or _beside(xb, tb, b, ba, a):
                continue
            if n < pairs.shape[0]:
                pairs[n, 0] = min(a, b) if same else a
                pairs[n, 1] = max(a, b) if same else b
            n += 1
    return n


@entry("d2 l2 d2 l1 d2 l1 d2 l2 d2 l1 d2 l1 b l2 -> l l")
def tree_pairs(xa, ta, ba, oa, na, la, xb, tb, bb, ob, nb, lb, same, pairs):
    """Pairs of triangles that may meet, as far as `pairs` has room; their number, nodes visited.

    With `same`, the two trees are one, and each pair has the lower row first.
    """
    stack = np.empty((4096, 4), dtype=np.int64)
    stack[0, 0], stack[0, 1] = na.shape[0] - 1, la.shape[0] - 2
    stack[0, 2], stack[0, 3] = nb.shape[0] - 1, lb.shape[0] - 2
    top = 1
    n = 0
    visited = 0
    while top > 0:
        top -= 1
        i, level_i, j, level_j = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3]
        visited += 1
        if _apart(na, i, nb, j):
            continue
        if not same:
            # against nodes above leaves only: between leaves, triangles are tested one by one
            if level_i == 0 and level_j > 0 and _leaf_beside(xa, ta, oa, i, nb, j):
                continue
            if level_j == 0 and level_i > 0 and _leaf_beside(xb, tb, ob, j, na, i):
                continue
        if level_i == 0 and level_j == 0:
            n = _emit(xa, ta, ba, oa, i, xb, tb, bb, ob, j, same, pairs, n)
            continue
        if top + 2 * FAN * FAN > stack.shape[0]:
            larger = np.empty((2 * stack.shape[0], 4), dtype=np.int64)
            larger[: stack.shape[0]] = stack
            stack = larger
        if same and i == j:  # one node with itself: each pair of its children once
            first = la[level_i - 1] + (i - la[level_i]) * FAN
            last = min(first + FAN, la[level_i])
            for p in range(first, last):
                for q in range(p, last):
                    stack[top, 0], stack[top, 1] = p, level_i - 1
                    stack[top, 2], stack[top, 3] = q, level_i - 1
                    top += 1
        elif level_i >= level_j:
            first = la[level_i - 1] + (i - la[level_i]) * FAN
            for p in range(first, min(first + FAN, la[level_i])):
                stack[top, 0], stack[top, 1] = p, level_i - 1
                stack[top, 2], stack[top, 3] = j, level_j
                top += 1
        else:
            first = lb[level_j - 1] + (j - lb[level_j]) * FAN
            for q in range(first, min(first + FAN, lb[level_j])):
                stack[top, 0], stack[top, 1] = i, level_i
                stack[top, 2], stack[top, 3] = q, level_j - 1
                top += 1
    return n, visited
