"""Trees of boxes over a lattice or a list of triangles, and the candidate pairs of two of them.

A lattice needs no list: its leaves are blocks of BLOCK x BLOCK cells, each node above holds 2 x 2
nodes, and a box follows from the extremes of the nodes in it (a min/max pyramid). Triangles of
other meshes are sorted by the Morton code of their middle (counting sort, linear); a leaf holds
LEAF consecutive triangles, and each node above holds FAN nodes. Both trees have no pointers, so one
traversal serves both. Where one side is a leaf of a list, the planes of its triangles are tested
against the box of the other side: the box of a large planar fault meets half a horizon, its plane
passes few blocks.

Notation, for each of two trees
    p, q, r  easting, northing, elevation of nodes, float64, flat
    a        layout, int64 (N_PLACE,); coordinate k of node (i, j) is at
             ``a[3 * k] + i * a[3 * k + 1] + j * a[3 * k + 2]``
    t        triangles of a list, rows of nodes (0, j); empty for a lattice
    order    triangles of a list in Morton order; empty for a lattice
    nodes    boxes of tree nodes, float64 (n_node, 6): leaves first, then level by level
    levels   int64 (n_level, 3): first node, rows and columns of nodes of each level
A triangle of a lattice has the key ``2 * cell + half``, one of a list its row.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.exact.predicates import TINY

LEAF = 8
FAN = 8
BLOCK = 8
# indices into `a`, after three times offset and strides of rows and columns
N_ROW, N_COL, RISING, TURNED, IS_LATTICE, N_PLACE = 9, 10, 11, 12, 13, 14
_ROOM = 2 * BLOCK * BLOCK


class Tree(NamedTuple):
    """One tree and the triangles below it: see the notation above."""

    p: np.ndarray
    q: np.ndarray
    r: np.ndarray
    a: np.ndarray
    t: np.ndarray
    order: np.ndarray
    nodes: np.ndarray
    levels: np.ndarray


class Loaded(NamedTuple):
    """Scratch for the triangles of a leaf: corners, boxes and keys."""

    c: np.ndarray
    boxes: np.ndarray
    keys: np.ndarray


@scalar
def _grow(nodes, i, j):
    for k in range(3):
        nodes[i, k] = min(nodes[i, k], nodes[j, k])
        nodes[i, 3 + k] = max(nodes[i, 3 + k], nodes[j, 3 + k])


@scalar
def clear_boxes(nodes, first, last):
    """Make boxes first to last empty."""
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

    # Each level has one node per fan_row x fan_col nodes below, down to one root.
    while True:
        levels[n, 0], levels[n, 1], levels[n, 2] = first, n_row, n_col
        # Levels are stored one after the other, leaves first.
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
def boxes_apart(p, i, q, j):
    """Whether box i of p and box j of q have no common point."""
    for k in range(3):
        # Written so that boxes with NaN are apart.
        if not (p[i, k] <= q[j, 3 + k] and q[j, k] <= p[i, 3 + k]):
            return True
    return False


@scalar
def append_pair(pairs, n, first, second):
    """Write a pair while there is capacity; the number of pairs with this one counted."""
    if n < pairs.shape[0]:
        pairs[n, 0], pairs[n, 1] = first, second
    return n + 1


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
def _has_all_nodes(c, row):
    """Whether all three nodes exist."""
    # NaN in any coordinate makes the sum NaN.
    total = 0.0
    for k in range(9):
        total += c[row, k]
    return total == total


@scalar
def low_high(values, offset, row_step, col_step):
    """Extremes over the four nodes of a cell; NaN nodes are skipped."""
    u, v = values[offset], values[offset + col_step]
    w, s = values[offset + row_step], values[offset + row_step + col_step]
    # Start with a node that exists; at least one of the first three does if a triangle does.
    low = high = u if u == u else (v if v == v else w)
    low = v if v < low else low
    high = v if v > high else high
    low = w if w < low else low
    high = w if w > high else high
    low = s if s < low else low
    high = s if s > high else high
    return low, high


@scalar
def _load_list_leaf(tree, leaf, near, j, loaded):
    """`_load_leaf` for a list of triangles."""
    n = 0
    for k in range(LEAF * leaf, min(LEAF * leaf + LEAF, tree.order.shape[0])):
        row = tree.order[k]
        for corner in range(3):
            _load_node(tree.p, tree.q, tree.r, tree.a, 0, tree.t[row, corner], loaded.c, n, corner)
        _box_corners(loaded.c, n, loaded.boxes)
        loaded.keys[n] = row
        # A triangle that is not near is overwritten by the next one.
        if not boxes_apart(loaded.boxes, n, near, j):
            n += 1
    return n


@scalar
def _cell_is_near(tree, row, col, near, j):
    """Whether the box of a cell of a lattice meets box j of `near`, elevation first."""
    a = tree.a
    low, high = low_high(tree.r, a[6] + row * a[7] + col * a[8], a[7], a[8])
    # Elevation first: horizons lie above each other and share the map.
    if low > near[j, 5] or high < near[j, 2]:
        return False
    low, high = low_high(tree.p, a[0] + row * a[1] + col * a[2], a[1], a[2])
    if low > near[j, 3] or high < near[j, 0]:
        return False
    low, high = low_high(tree.q, a[3] + row * a[4] + col * a[5], a[4], a[5])
    return not (low > near[j, 4] or high < near[j, 1])


@scalar
def _load_half(tree, row, col, half, c, n):
    """Corners of one triangle of a cell into row n of c."""
    a = tree.a
    # corners a, b, c, d around the cell: abc + acd where diagonals rise, or abd + bcd
    second = 2 if half == 1 else 1
    start = 0 if a[RISING] == 1 or half == 0 else 1
    third = 3 if half == 1 else (2 if a[RISING] == 1 else 3)
    for corner in range(3):
        at = start if corner == 0 else (second if corner == 1 else third)
        _load_node(
            tree.p, tree.q, tree.r, a, row + (1 if at >= 2 else 0),
            col + (1 if at == 1 or at == 2 else 0), c, n, corner,
        )  # fmt: skip


@scalar
def _load_leaf(tree, leaf, near, j, loaded):
    """Load the triangles of a leaf whose boxes meet box j of `near`; their number."""
    a, levels = tree.a, tree.levels
    if a[IS_LATTICE] == 0:
        return _load_list_leaf(tree, leaf, near, j, loaded)
    n = 0
    first_row = BLOCK * (leaf // levels[0, 2])
    first_col = BLOCK * (leaf % levels[0, 2])
    for row in range(first_row, min(first_row + BLOCK, a[N_ROW] - 1)):
        for col in range(first_col, min(first_col + BLOCK, a[N_COL] - 1)):
            if not _cell_is_near(tree, row, col, near, j):
                continue
            for half in range(2):
                _load_half(tree, row, col, half, loaded.c, n)
                if not _has_all_nodes(loaded.c, n):
                    continue
                _box_corners(loaded.c, n, loaded.boxes)
                loaded.keys[n] = 2 * (row * (a[N_COL] - 1) + col) + half
                # As for a list: the row is used again unless the triangle is near.
                if not boxes_apart(loaded.boxes, n, near, j):
                    n += 1
    return n


@scalar
def _box_misses_plane(c, row, boxes, j):
    """Whether box j certainly lies strictly on one side of a loaded triangle's plane."""
    ox, oy, oz = c[row, 0], c[row, 1], c[row, 2]
    ax, ay, az = c[row, 3] - ox, c[row, 4] - oy, c[row, 5] - oz
    bx, by, bz = c[row, 6] - ox, c[row, 7] - oy, c[row, 8] - oz

    # Normal of the triangle, and the magnitudes of its terms.
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    sx = abs(ay * bz) + abs(az * by)
    sy = abs(az * bx) + abs(ax * bz)
    sz = abs(ax * by) + abs(ay * bx)

    # Centre of the box relative to the triangle, and its half-sizes.
    mx = 0.5 * (boxes[j, 0] + boxes[j, 3]) - ox
    my = 0.5 * (boxes[j, 1] + boxes[j, 4]) - oy
    mz = 0.5 * (boxes[j, 2] + boxes[j, 5]) - oz
    rx = 0.5 * (boxes[j, 3] - boxes[j, 0])
    ry = 0.5 * (boxes[j, 4] - boxes[j, 1])
    rz = 0.5 * (boxes[j, 5] - boxes[j, 2])

    # The box misses the plane if its centre is higher than its extent along the normal.
    height = abs(nx * mx + ny * my + nz * mz)
    reach = abs(nx) * rx + abs(ny) * ry + abs(nz) * rz
    # coordinates bound every rounding of middles and differences
    size = abs(boxes[j, 0]) + abs(boxes[j, 3]) + abs(boxes[j, 1]) + abs(boxes[j, 4])
    size += abs(boxes[j, 2]) + abs(boxes[j, 5]) + abs(ox) + abs(oy) + abs(oz)
    span = abs(ax) + abs(ay) + abs(az) + abs(bx) + abs(by) + abs(bz)
    far = abs(mx) + abs(my) + abs(mz) + rx + ry + rz
    # where products underflow, the bound does too: nothing below TINY is certain
    return height > reach + size * (1e-14 * (sx + sy + sz) + 4e-15 * far * span) + TINY


@scalar
def _box_misses_leaf(tree, leaf, loaded, nodes, j):
    """Whether box j misses the planes of all triangles of a leaf that has few of them."""
    a, levels = tree.a, tree.levels
    if a[IS_LATTICE] == 1:
        n_row = min(BLOCK, a[N_ROW] - 1 - BLOCK * (leaf // levels[0, 2]))
        n_col = min(BLOCK, a[N_COL] - 1 - BLOCK * (leaf % levels[0, 2]))
        # Testing more triangles than a leaf of a list has would cost more than it saves.
        if 2 * n_row * n_col > LEAF:
            return False
    for k in range(_load_leaf(tree, leaf, nodes, j, loaded)):
        # One plane that passes the box is enough to go on.
        if not _box_misses_plane(loaded.c, k, nodes, j):
            return False
    return True


@scalar
def _children(a, levels, node, level, kids):
    """Nodes below a node, and how many."""
    # Row and column of the node in its level give those of its children.
    above, below = levels[level], levels[level - 1]
    # A lattice joins 2 x 2 nodes, a list FAN consecutive ones.
    fan_row, fan_col = (2, 2) if a[IS_LATTICE] == 1 else (1, FAN)
    row, col = (node - above[0]) // above[2], (node - above[0]) % above[2]
    n = 0
    for i in range(row * fan_row, min(row * fan_row + fan_row, below[1])):
        for j in range(col * fan_col, min(col * fan_col + fan_col, below[2])):
            kids[n] = below[0] + i * below[2] + j
            n += 1
    return n


@scalar
def push_pair(stack, top, i, level_i, j, level_j):
    """Push a pair of tree nodes and their levels; the new height of the stack."""
    stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3] = i, level_i, j, level_j
    return top + 1


@scalar
def extent(nodes, i):
    """Sum of the three edge lengths of a box."""
    return (nodes[i, 3] - nodes[i, 0]) + (nodes[i, 4] - nodes[i, 1]) + (nodes[i, 5] - nodes[i, 2])


@scalar
def _emit(first, count_a, second, count_b, same_leaf, same, pairs, n):
    """Pairs of loaded triangles whose boxes meet and whose planes pass the other's box."""
    for i in range(count_a):
        for j in range(count_b):
            # Boxes first, then the plane of each triangle against the other box.
            key_a, key_b = first.keys[i], second.keys[j]
            # In one leaf each pair comes twice: the one with the lower key first is taken.
            if boxes_apart(first.boxes, i, second.boxes, j) or (same_leaf and key_b <= key_a):
                continue
            if not same and (
                _box_misses_plane(first.c, i, second.boxes, j)
                or _box_misses_plane(second.c, j, first.boxes, i)
            ):
                continue
            if same:
                n = append_pair(pairs, n, min(key_a, key_b), max(key_a, key_b))
            else:
                n = append_pair(pairs, n, key_a, key_b)
    return n


@scalar
def _leaf_pairs(a, i, first, b, j, second, hull, same, pairs, n):
    """Pairs of triangles of leaf i of tree a and leaf j of tree b."""
    count_a = _load_leaf(a, i, b.nodes, j, first)
    if count_a == 0:
        return n

    # Only triangles of b near the common box of those of a are loaded.
    clear_boxes(hull, 0, 1)
    for k in range(count_a):
        for axis in range(3):
            hull[0, axis] = min(hull[0, axis], first.boxes[k, axis])
            hull[0, 3 + axis] = max(hull[0, 3 + axis], first.boxes[k, 3 + axis])
    count_b = _load_leaf(b, j, hull, 0, second)
    return _emit(first, count_a, second, count_b, same and i == j, same, pairs, n)


@scalar
def _is_excluded(a, i, level_i, first, b, j, level_j, second):
    """Whether the planes of one side's leaf miss the other side's node above its leaves.

    Between two leaves, triangles are tested one by one instead.
    """
    # The plane of a large triangle passes few nodes of the other tree; its box meets many.
    if level_i == 0 and level_j > 0 and _box_misses_leaf(a, i, first, b.nodes, j):
        return True
    return level_j == 0 and level_i > 0 and _box_misses_leaf(b, j, second, a.nodes, i)


@entry("d1 d1 d1 l1 l2 l1 d2 l2 d1 d1 d1 l1 l2 l1 d2 l2 b l2* -> l l")
def tree_pairs(pa, qa, ra, aa, ta, oa, na, la, pb, qb, rb, ab, tb, ob, nb, lb, same, pairs):
    """Candidate pairs of triangles, while `pairs` has capacity; their number, nodes visited.

    With `same`, the two trees are one, and each pair has the lower key first.
    """
    a, b = Tree(pa, qa, ra, aa, ta, oa, na, la), Tree(pb, qb, rb, ab, tb, ob, nb, lb)
    ca, ba, ka = np.empty((_ROOM, 9)), np.empty((_ROOM, 6)), np.empty(_ROOM, dtype=np.int64)
    cb, bb, kb = np.empty((_ROOM, 9)), np.empty((_ROOM, 6)), np.empty(_ROOM, dtype=np.int64)
    first, second = Loaded(ca, ba, ka), Loaded(cb, bb, kb)
    stack = np.empty((4096, 4), dtype=np.int64)
    kids, hull = np.empty(FAN, dtype=np.int64), np.empty((1, 6))

    # Both roots; the stack grows where needed.
    top = push_pair(stack, 0, na.shape[0] - 1, la.shape[0] - 1, nb.shape[0] - 1, lb.shape[0] - 1)
    n = 0
    visited = 0
    while top > 0:
        top -= 1
        i, level_i, j, level_j = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3]
        # Every pair of nodes that is compared counts: it tells how well boxes exclude.
        visited += 1
        if boxes_apart(na, i, nb, j):
            continue
        if not same and _is_excluded(a, i, level_i, first, b, j, level_j, second):
            continue
        if level_i == 0 and level_j == 0:
            n = _leaf_pairs(a, i, first, b, j, second, hull, same, pairs, n)
            continue

        # room for all pairs of children of two nodes
        if top + FAN * FAN > stack.shape[0]:
            larger = np.empty((2 * stack.shape[0], 4), dtype=np.int64)
            larger[: stack.shape[0]] = stack
            stack = larger

        # descend on the side whose box is larger
        if same and i == j:  # one node with itself: each pair of its children once
            count = _children(aa, la, i, level_i, kids)
            for k in range(count):
                for other in range(k, count):
                    top = push_pair(stack, top, kids[k], level_i - 1, kids[other], level_i - 1)
        elif level_j == 0 or (level_i > 0 and extent(na, i) >= extent(nb, j)):
            count = _children(aa, la, i, level_i, kids)
            for k in range(count):
                top = push_pair(stack, top, kids[k], level_i - 1, j, level_j)
        else:
            count = _children(ab, lb, j, level_j, kids)
            for k in range(count):
                top = push_pair(stack, top, i, level_i, kids[k], level_j - 1)
    return n, visited


# ---- boxes ----------------------------------------
# The triangles of one tree whose boxes meet a box.


@entry("l1 d2 l2 d2 d1 l1* -> l")
def rows_in_box(order, nodes, levels, boxes, box, rows):
    """Write the triangles whose boxes meet a box, up to capacity; their number."""
    stack = np.empty((FAN * (levels.shape[0] + 1) + 8, 2), dtype=np.int64)
    stack[0, 0], stack[0, 1], top = nodes.shape[0] - 1, levels.shape[0] - 1, 1
    n = 0
    while top > 0:
        top -= 1
        node, level = stack[top, 0], stack[top, 1]
        if level > 0:
            first = levels[level - 1, 0] + (node - levels[level, 0]) * FAN
            for child in range(first, min(first + FAN, levels[level, 0])):
                # A node or box is skipped if it lies outside on one axis.
                apart = False
                for k in range(3):
                    apart |= nodes[child, k] > box[3 + k] or nodes[child, 3 + k] < box[k]
                if not apart:
                    stack[top, 0], stack[top, 1] = child, level - 1
                    top += 1
            continue
        for k in range(LEAF * node, min(LEAF * node + LEAF, order.shape[0])):
            row = order[k]
            apart = False
            for axis in range(3):
                apart |= boxes[row, axis] > box[3 + axis] or boxes[row, 3 + axis] < box[axis]
            if not apart:
                # Beyond the capacity rows are only counted.
                if n < rows.shape[0]:
                    rows[n] = row
                n += 1
    return n


def rows_near(
    tree: tuple[np.ndarray, np.ndarray, np.ndarray], boxes: np.ndarray, box: np.ndarray
) -> np.ndarray:
    """The triangles of a tree whose boxes meet a box, rising."""
    rows = np.empty(256, dtype=np.int64)
    n = rows_in_box(*tree, boxes, box, rows)

    # asked once more with room for all, if the first array was too short
    if n > len(rows):
        rows = np.empty(n, dtype=np.int64)
        rows_in_box(*tree, boxes, box, rows)
    return np.sort(rows[:n])


# ---- voxels ----------------------------------------
# Candidate pairs of triangles by boxes in equal voxels (after Lo & Wang 2004).
#
# A pair is reported once, in the voxel that holds the lower corner of the common part of the two
# boxes. Order: by first triangle, then voxel, then second triangle.
#
# Notation
#     boxes    float64 (n, 6): lower x, y, z, upper x, y, z of each triangle
#     bounds   float64 (6,): the global box
#     shape    int64 (3,): number of voxels along each axis


@entry("d2 l2 -> d2")
def triangle_boxes(x, t):
    """Boxes of all triangles."""
    boxes = np.empty((t.shape[0], 6), dtype=np.float64)
    for i in range(t.shape[0]):
        a, b, c = t[i, 0], t[i, 1], t[i, 2]
        for axis in range(3):
            p, q, r = x[a, axis], x[b, axis], x[c, axis]
            boxes[i, axis] = min(p, min(q, r))
            boxes[i, 3 + axis] = max(p, max(q, r))
    return boxes


def faces_in_box(boxes: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """Rows of the boxes that overlap the global box."""
    apart = np.zeros(len(boxes), dtype=bool)
    for axis in range(3):  # numpy is slow along short rows
        apart |= (boxes[:, axis] > bounds[3 + axis]) | (boxes[:, 3 + axis] < bounds[axis])
    return np.flatnonzero(~apart)


@scalar
def _cell(value, low, size, n):
    c = (value - low) / size
    if c >= n:  # before the cast: a huge face over tiny voxels is beyond int64
        return n - 1
    return int(c) if c > 0.0 else 0


@scalar
def _cell_range(boxes, i, bounds, size, shape, out):
    """First and last voxel of a box along each axis."""
    for axis in range(3):
        # Boxes beyond the bounds are clamped to the outermost voxels.
        out[axis] = _cell(boxes[i, axis], bounds[axis], size, shape[axis])
        out[3 + axis] = _cell(boxes[i, 3 + axis], bounds[axis], size, shape[axis])


@entry("d2 l1 d1 d l1 -> l1 l1")
def fill_voxels(boxes, rows, bounds, size, shape):
    """Triangles of each voxel: offsets (n_voxel + 1,), and rows voxel by voxel."""
    n_voxel = shape[0] * shape[1] * shape[2]
    offsets = np.zeros(n_voxel + 2, dtype=np.int64)
    span = np.empty(6, dtype=np.int64)

    # Count the triangles of each voxel, two places further on.
    for r in range(rows.shape[0]):
        _cell_range(boxes, rows[r], bounds, size, shape, span)
        for i in range(span[0], span[3] + 1):
            for j in range(span[1], span[4] + 1):
                for k in range(span[2], span[5] + 1):
                    offsets[(i * shape[1] + j) * shape[2] + k + 2] += 1

    # Sum up the counts: offsets, shifted by one voxel.
    for c in range(2, n_voxel + 2):
        offsets[c] += offsets[c - 1]

    # Fill: each offset moves to the start of the next voxel.
    filled = np.empty(offsets[n_voxel + 1], dtype=np.int64)
    for r in range(rows.shape[0]):
        _cell_range(boxes, rows[r], bounds, size, shape, span)
        for i in range(span[0], span[3] + 1):
            for j in range(span[1], span[4] + 1):
                for k in range(span[2], span[5] + 1):
                    c = (i * shape[1] + j) * shape[2] + k + 1
                    filled[offsets[c]] = rows[r]
                    offsets[c] += 1
    return offsets[: n_voxel + 1].copy(), filled


@entry("d2 l1 d2 d1 d l1 l1 l1 b l2* -> l")
def voxel_pairs(boxes_a, rows_a, boxes_b, bounds, size, shape, offsets, filled, same, pairs):
    """Pairs of triangles with overlapping boxes, written up to capacity; their number.

    With `same`, the two surfaces are one, and each pair is reported with the lower row first.
    """
    n = 0
    span = np.empty(6, dtype=np.int64)
    for r in range(rows_a.shape[0]):
        a = rows_a[r]
        _cell_range(boxes_a, a, bounds, size, shape, span)
        for i in range(span[0], span[3] + 1):
            for j in range(span[1], span[4] + 1):
                for k in range(span[2], span[5] + 1):
                    # Voxels are numbered with k fastest, so that a row of them is adjacent in
                    # memory.
                    c = (i * shape[1] + j) * shape[2] + k
                    for s in range(offsets[c], offsets[c + 1]):
                        b = filled[s]
                        # In one surface each pair once, and no triangle with itself.
                        if same and b <= a:
                            continue

                        # The common part has its lower corner in this voxel, or the pair is left
                        # to another.
                        here = True
                        for axis in range(3):
                            low = max(boxes_a[a, axis], boxes_b[b, axis])
                            if low > boxes_a[a, 3 + axis] or low > boxes_b[b, 3 + axis]:
                                here = False
                                break
                            at = i if axis == 0 else (j if axis == 1 else k)
                            # The same expression as in `_cell_range`, so that exactly one voxel has
                            # the corner.
                            if _cell(low, bounds[axis], size, shape[axis]) != at:
                                here = False
                                break
                        if here:
                            n = append_pair(pairs, n, a, b)
    return n
