"""Which triangles are near: trees of boxes, over blocks of a lattice or over a list of triangles.

A lattice needs no list: its leaves are blocks of BLOCK x BLOCK cells, each node above holds 2 x 2
nodes, and a box is known from the extremes of the nodes in it (a min/max pyramid). Triangles of
other meshes are sorted by the Morton code of their middle (counting sort, linear); leaves hold
LEAF of them in a row, and each node above holds FAN nodes. Both have no pointers, so that one walk
serves all. Where one side is a leaf of a list, its triangles' planes are tested against the box of
the other side: a huge flat face (a planar fault, a wall) reaches the boxes of half a horizon, but
its plane passes few of them.

Notation, for each of two trees
    p, q, r  easting, northing, elevation of nodes, float64, flat
    a        where what is, int64 (N_PLACE,); coordinate k of node (i, j) is at
             ``a[3 * k] + i * a[3 * k + 1] + j * a[3 * k + 2]``
    t        triangles of a list, rows of nodes (0, j); empty for a lattice
    order    triangles of a list in Morton order; empty for a lattice
    nodes    boxes of tree nodes, float64 (n_node, 6): leaves first, then level by level
    levels   int64 (n_level, 3): first node, rows and columns of nodes of each level
A triangle of a lattice has the key ``2 * cell + half``, one of a list its row.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.exact.predicates import TINY

LEAF = 8
FAN = 8
BLOCK = 8
# places in `a`, after three times offset and strides of rows and columns
N_ROW, N_COL, RISING, TURNED, IS_LATTICE, N_PLACE = 9, 10, 11, 12, 13, 14
_ROOM = 2 * BLOCK * BLOCK


@scalar
def _grow(nodes, i, j):
    for k in range(3):
        nodes[i, k] = min(nodes[i, k], nodes[j, k])
        nodes[i, 3 + k] = max(nodes[i, 3 + k], nodes[j, 3 + k])


@scalar
def clear_boxes(nodes, first, last):
    """Make some boxes empty."""
    for i in range(first, last):
        for k in range(3):
            nodes[i, k] = np.inf
            nodes[i, 3 + k] = -np.inf


@scalar
def levels_of(n_row, n_col, fan_row, fan_col):
    """First node, rows and columns of each level, and the number of nodes."""
    levels = np.zeros((64, 3), dtype=np.int64)
    n = 0
    first = 0
    while True:
        levels[n, 0], levels[n, 1], levels[n, 2] = first, n_row, n_col
        first += n_row * n_col
        n += 1
        if n_row * n_col <= 1:
            break
        n_row = (n_row + fan_row - 1) // fan_row
        n_col = (n_col + fan_col - 1) // fan_col
    return levels[:n].copy(), first


@scalar
def build_above(nodes, levels, fan_row, fan_col):
    """Boxes of all nodes above the leaves."""
    clear_boxes(nodes, levels[0, 1] * levels[0, 2], nodes.shape[0])
    for level in range(1, levels.shape[0]):
        below, above = levels[level - 1], levels[level]
        for i in range(below[1]):
            for j in range(below[2]):
                node = above[0] + (i // fan_row) * above[2] + j // fan_col
                _grow(nodes, node, below[0] + i * below[2] + j)


@scalar
def _apart(p, i, q, j):
    """Whether two boxes do not meet."""
    for k in range(3):
        if not (p[i, k] <= q[j, 3 + k] and q[j, k] <= p[i, 3 + k]):
            return True
    return False


@scalar
def _load_node(p, q, r, a, i, j, c, row, corner):
    c[row, 3 * corner] = p[a[0] + i * a[1] + j * a[2]]
    c[row, 3 * corner + 1] = q[a[3] + i * a[4] + j * a[5]]
    c[row, 3 * corner + 2] = r[a[6] + i * a[7] + j * a[8]]


@scalar
def _box_corners(c, row, boxes):
    """Box of a loaded triangle."""
    for k in range(3):
        u, v, w = c[row, k], c[row, 3 + k], c[row, 6 + k]
        boxes[row, k] = min(u, min(v, w))
        boxes[row, 3 + k] = max(u, max(v, w))


@scalar
def _whole(c, row):
    """Whether all three nodes exist."""
    total = 0.0
    for k in range(9):
        total += c[row, k]
    return total == total


@scalar
def low_high(values, offset, row_step, col_step):
    """Extremes over the four nodes of a cell; a node that is not a number is passed over."""
    u, v = values[offset], values[offset + col_step]
    w, s = values[offset + row_step], values[offset + row_step + col_step]
    low = high = u if u == u else (v if v == v else w)
    low = v if v < low else low
    high = v if v > high else high
    low = w if w < low else low
    high = w if w > high else high
    low = s if s < low else low
    high = s if s > high else high
    return low, high


@scalar
def _load_leaf(p, q, r, a, t, order, levels, leaf, near, j, c, boxes, keys):
    """Triangles of a leaf whose boxes meet box j of `near`: corners, boxes, keys; their number."""
    n = 0
    if a[IS_LATTICE] == 0:
        for k in range(LEAF * leaf, min(LEAF * leaf + LEAF, order.shape[0])):
            for corner in range(3):
                _load_node(p, q, r, a, 0, t[order[k], corner], c, n, corner)
            _box_corners(c, n, boxes)
            keys[n] = order[k]
            if not _apart(boxes, n, near, j):
                n += 1
        return n
    first_row = BLOCK * (leaf // levels[0, 2])
    first_col = BLOCK * (leaf % levels[0, 2])
    for row in range(first_row, min(first_row + BLOCK, a[N_ROW] - 1)):
        for col in range(first_col, min(first_col + BLOCK, a[N_COL] - 1)):
            low, high = low_high(r, a[6] + row * a[7] + col * a[8], a[7], a[8])
            if low > near[j, 5] or high < near[j, 2]:
                continue
            low, high = low_high(p, a[0] + row * a[1] + col * a[2], a[1], a[2])
            if low > near[j, 3] or high < near[j, 0]:
                continue
            low, high = low_high(q, a[3] + row * a[4] + col * a[5], a[4], a[5])
            if low > near[j, 4] or high < near[j, 1]:
                continue
            for half in range(2):
                # corners a, b, c, d around the cell: abc + acd, or abd + bcd
                second = 2 if half == 1 else 1
                start = 0 if a[RISING] == 1 or half == 0 else 1
                third = 3 if half == 1 else (2 if a[RISING] == 1 else 3)
                for corner in range(3):
                    at = start if corner == 0 else (second if corner == 1 else third)
                    _load_node(
                        p, q, r, a, row + (1 if at >= 2 else 0),
                        col + (1 if at == 1 or at == 2 else 0), c, n, corner,
                    )  # fmt: skip
                if not _whole(c, n):
                    continue
                _box_corners(c, n, boxes)
                keys[n] = 2 * (row * (a[N_COL] - 1) + col) + half
                if not _apart(boxes, n, near, j):
                    n += 1
    return n


@scalar
def _beside(c, row, boxes, j):
    """Whether a box lies strictly on one side of a loaded triangle's plane, for sure."""
    ox, oy, oz = c[row, 0], c[row, 1], c[row, 2]
    ax, ay, az = c[row, 3] - ox, c[row, 4] - oy, c[row, 5] - oz
    bx, by, bz = c[row, 6] - ox, c[row, 7] - oy, c[row, 8] - oz
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    sx = abs(ay * bz) + abs(az * by)
    sy = abs(az * bx) + abs(ax * bz)
    sz = abs(ax * by) + abs(ay * bx)
    mx = 0.5 * (boxes[j, 0] + boxes[j, 3]) - ox
    my = 0.5 * (boxes[j, 1] + boxes[j, 4]) - oy
    mz = 0.5 * (boxes[j, 2] + boxes[j, 5]) - oz
    rx = 0.5 * (boxes[j, 3] - boxes[j, 0])
    ry = 0.5 * (boxes[j, 4] - boxes[j, 1])
    rz = 0.5 * (boxes[j, 5] - boxes[j, 2])
    height = abs(nx * mx + ny * my + nz * mz)
    reach = abs(nx) * rx + abs(ny) * ry + abs(nz) * rz
    # coordinates bound every rounding of middles and differences
    size = abs(boxes[j, 0]) + abs(boxes[j, 3]) + abs(boxes[j, 1]) + abs(boxes[j, 4])
    size += abs(boxes[j, 2]) + abs(boxes[j, 5]) + abs(ox) + abs(oy) + abs(oz)
    span = abs(ax) + abs(ay) + abs(az) + abs(bx) + abs(by) + abs(bz)
    far = abs(mx) + abs(my) + abs(mz) + rx + ry + rz
    # where products underflow, the bound does too: nothing below TINY is sure
    return height > reach + size * (1e-14 * (sx + sy + sz) + 4e-15 * far * span) + TINY


@scalar
def _leaf_beside(p, q, r, a, t, order, levels, leaf, c, boxes, keys, nodes, j):
    """Whether a tree node is beside the planes of all triangles of a leaf that has few of them."""
    if a[IS_LATTICE] == 1:
        n_row = min(BLOCK, a[N_ROW] - 1 - BLOCK * (leaf // levels[0, 2]))
        n_col = min(BLOCK, a[N_COL] - 1 - BLOCK * (leaf % levels[0, 2]))
        if 2 * n_row * n_col > LEAF:
            return False
    for k in range(_load_leaf(p, q, r, a, t, order, levels, leaf, nodes, j, c, boxes, keys)):
        if not _beside(c, k, nodes, j):
            return False
    return True


@scalar
def _children(a, levels, node, level, kids):
    """Nodes below a node, and how many."""
    above, below = levels[level], levels[level - 1]
    fan_row, fan_col = (2, 2) if a[IS_LATTICE] == 1 else (1, FAN)
    row, col = (node - above[0]) // above[2], (node - above[0]) % above[2]
    n = 0
    for i in range(row * fan_row, min(row * fan_row + fan_row, below[1])):
        for j in range(col * fan_col, min(col * fan_col + fan_col, below[2])):
            kids[n] = below[0] + i * below[2] + j
            n += 1
    return n


@scalar
def _push(stack, top, i, level_i, j, level_j):
    stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3] = i, level_i, j, level_j
    return top + 1


@scalar
def _extent(nodes, i):
    return (nodes[i, 3] - nodes[i, 0]) + (nodes[i, 4] - nodes[i, 1]) + (nodes[i, 5] - nodes[i, 2])


@scalar
def _emit(ca, ba, ka, count_a, cb, bb, kb, count_b, same_leaf, same, pairs, n):
    """Pairs of loaded triangles whose boxes meet and whose planes pass the other's box."""
    for i in range(count_a):
        for j in range(count_b):
            if _apart(ba, i, bb, j) or (same_leaf and kb[j] <= ka[i]):
                continue
            if not same and (_beside(ca, i, bb, j) or _beside(cb, j, ba, i)):
                continue
            if n < pairs.shape[0]:
                pairs[n, 0] = min(ka[i], kb[j]) if same else ka[i]
                pairs[n, 1] = max(ka[i], kb[j]) if same else kb[j]
            n += 1
    return n


@entry("d1 d1 d1 l1 l2 l1 d2 l2 d1 d1 d1 l1 l2 l1 d2 l2 b l2 -> l l")
def tree_pairs(pa, qa, ra, aa, ta, oa, na, la, pb, qb, rb, ab, tb, ob, nb, lb, same, pairs):
    """Pairs of triangles that may meet, as far as `pairs` has room; their number, nodes visited.

    With `same`, the two trees are one, and each pair has the lower key first.
    """
    stack = np.empty((4096, 4), dtype=np.int64)
    ca, cb = np.empty((_ROOM, 9)), np.empty((_ROOM, 9))
    ba, bb = np.empty((_ROOM, 6)), np.empty((_ROOM, 6))
    ka, kb = np.empty(_ROOM, dtype=np.int64), np.empty(_ROOM, dtype=np.int64)
    kids = np.empty(FAN, dtype=np.int64)
    hull = np.empty((1, 6))
    top = _push(stack, 0, na.shape[0] - 1, la.shape[0] - 1, nb.shape[0] - 1, lb.shape[0] - 1)
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
            if level_i == 0 and level_j > 0:
                if _leaf_beside(pa, qa, ra, aa, ta, oa, la, i, ca, ba, ka, nb, j):
                    continue
            if level_j == 0 and level_i > 0:
                if _leaf_beside(pb, qb, rb, ab, tb, ob, lb, j, cb, bb, kb, na, i):
                    continue
        if level_i == 0 and level_j == 0:
            count_a = _load_leaf(pa, qa, ra, aa, ta, oa, la, i, nb, j, ca, ba, ka)
            if count_a == 0:
                continue
            clear_boxes(hull, 0, 1)
            for k in range(count_a):
                for axis in range(3):
                    hull[0, axis] = min(hull[0, axis], ba[k, axis])
                    hull[0, 3 + axis] = max(hull[0, 3 + axis], ba[k, 3 + axis])
            count_b = _load_leaf(pb, qb, rb, ab, tb, ob, lb, j, hull, 0, cb, bb, kb)
            n = _emit(ca, ba, ka, count_a, cb, bb, kb, count_b, same and i == j, same, pairs, n)
            continue
        if top + FAN * FAN > stack.shape[0]:
            larger = np.empty((2 * stack.shape[0], 4), dtype=np.int64)
            larger[: stack.shape[0]] = stack
            stack = larger
        if same and i == j:  # one node with itself: each pair of its children once
            count = _children(aa, la, i, level_i, kids)
            for k in range(count):
                for other in range(k, count):
                    top = _push(stack, top, kids[k], level_i - 1, kids[other], level_i - 1)
        elif level_j == 0 or (level_i > 0 and _extent(na, i) >= _extent(nb, j)):
            count = _children(aa, la, i, level_i, kids)
            for k in range(count):
                top = _push(stack, top, kids[k], level_i - 1, j, level_j)
        else:
            count = _children(ab, lb, j, level_j, kids)
            for k in range(count):
                top = _push(stack, top, i, level_i, kids[k], level_j - 1)
    return n, visited
