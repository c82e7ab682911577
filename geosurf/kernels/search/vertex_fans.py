"""Triangles as seen from one point: boxes of their directions, and which of these overlap.

Two triangles meet only if they are seen in a common direction, from any point. Seen from a vertex
that thousands of triangles share, each of these is an arc on the sphere of directions. Their boxes
in space all meet at that vertex; the boxes of the arcs overlap only where the triangles meet or are
adjacent.

Notation
    x        points (n, 3); corners: rows of x (m, 3)
    boxes    lower and upper corners (m, 6)
    label    int64 (m,): rows with the same label >= 0 are not compared
    order    rows of boxes, LEAF in a leaf; nodes, levels: boxes of the tree above, see `tree`
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.search.tree import (
    FAN,
    LEAF,
    append_pair,
    boxes_apart,
    build_above,
    clear_boxes,
    extent,
    levels_of,
)

ROOM = 1e-6  # margin of a direction, far above rounding
_AREA_ERROR = 1e-14  # ten times the rounding error of an area on the sphere
_WIDE = 1.5  # squared chord between two corners from which the box is the whole sphere
_MIXED, _EMPTY = -1, -2


@scalar
def _bend(to, a, b, k):
    """Extremes of a coordinate inside the arc between two directions; those of one end if none.

    Along the arc it is ``to[a, k] cos(t) + q sin(t)``, with q the unit tangent at a.
    """
    # Slopes of the coordinate at both ends of the arc, in the plane of the arc.
    dot = to[a, 0] * to[b, 0] + to[a, 1] * to[b, 1] + to[a, 2] * to[b, 2]
    sine = math.sqrt(max(1.0 - dot * dot, 0.0))
    leaves, arrives = to[b, k] - dot * to[a, k], dot * to[b, k] - to[a, k]
    # the bend of a very short arc is far below the error
    # Without a change of sign the coordinate is monotone: its extremes are at the ends.
    if sine < 1e-7 or leaves * arrives >= 0.0:
        return to[a, k], to[a, k]
    size = math.sqrt(to[a, k] ** 2 + (leaves / sine) ** 2)
    return (to[a, k], size) if leaves > 0.0 else (-size, to[a, k])


@scalar
def _around_axis(to, k, chord):
    """1 if three directions may enclose an axis, -1 for its negative, else 0."""
    # the axis is farther away than the corners are from each other
    if abs(to[0, k]) < 1.0 - 0.5 * chord - 1e-9:
        return 0
    # Signed areas as seen along the axis: of one sign where the axis may be enclosed.
    u, v = (k + 1) % 3, (k + 2) % 3
    a = to[0, u] * to[1, v] - to[0, v] * to[1, u]
    b = to[1, u] * to[2, v] - to[1, v] * to[2, u]
    c = to[2, u] * to[0, v] - to[2, v] * to[0, u]
    if min(a, min(b, c)) < -_AREA_ERROR and max(a, max(b, c)) > _AREA_ERROR:
        return 0
    # each side is shorter than a quarter circle: all are on one side
    return 1 if to[0, k] + to[1, k] + to[2, k] > 0.0 else -1


@entry("d2 l2 d1 d -> d2")
def direction_boxes(x, corners, eye, slip):
    """Boxes of the directions in which triangles are seen from a point.

    A corner at the point itself is left out: the triangle is an arc then. Coordinates may have
    errors of `slip`. Triangles that are too near or too wide get the box of all directions.
    """
    boxes = np.empty((corners.shape[0], 6))
    to = np.empty((3, 3))
    for i in range(corners.shape[0]):
        # Unit vectors to the corners that differ from the eye.
        n = 0
        nearest = np.inf
        for corner in range(3):
            at = corners[i, corner]
            ux, uy, uz = x[at, 0] - eye[0], x[at, 1] - eye[1], x[at, 2] - eye[2]
            away = math.sqrt(ux * ux + uy * uy + uz * uz)
            # The corner at the eye has no direction: the triangle is an arc.
            if ux == 0.0 and uy == 0.0 and uz == 0.0:
                continue
            nearest = min(nearest, away)
            if 1e-140 < away < 1e140:
                to[n, 0], to[n, 1], to[n, 2] = ux / away, uy / away, uz / away
            else:
                nearest = 0.0
            n += 1

        # The box of all directions, kept where the triangle is too near or too wide.
        for k in range(3):
            boxes[i, k], boxes[i, 3 + k] = -2.0, 2.0
        if n < 2 or not 8.0 * slip < 0.01 * nearest:
            continue
        chord = 0.0
        for a in range(n):
            for b in range(a):
                square = 0.0
                for k in range(3):
                    square += (to[a, k] - to[b, k]) ** 2
                chord = max(chord, square)
        if chord >= _WIDE:
            continue

        # Corners, then extremes inside the sides, then an enclosed axis.
        room = ROOM + 16.0 * slip / nearest
        for k in range(3):
            low = high = to[0, k]
            for a in range(1, n):
                low, high = min(low, to[a, k]), max(high, to[a, k])
            # Three sides, or the single arc between two directions.
            for a in range(n if n == 3 else 1):
                least, most = _bend(to, a, (a + 1) % n, k)
                low, high = min(low, least), max(high, most)
            if n == 3:
                inside = _around_axis(to, k, chord)
                high, low = (1.0 if inside > 0 else high), (-1.0 if inside < 0 else low)
            boxes[i, k], boxes[i, 3 + k] = low - room, high + room
    return boxes


@entry("d2 l1 l1 -> d2 l2 l1")
def box_tree(boxes, order, label):
    """Boxes and levels of a tree over boxes in an order, and the common label below each node."""
    n = order.shape[0]
    levels, n_node = levels_of(1, (n + LEAF - 1) // LEAF, 1, FAN)
    nodes = np.empty((n_node, 6))
    common = np.full(n_node, _EMPTY, dtype=np.int64)

    # Leaves: boxes and the label that all rows of a leaf share.
    clear_boxes(nodes, 0, levels[0, 2])
    for place in range(n):
        leaf, i = place // LEAF, order[place]
        for k in range(3):
            nodes[leaf, k] = min(nodes[leaf, k], boxes[i, k])
            nodes[leaf, 3 + k] = max(nodes[leaf, 3 + k], boxes[i, 3 + k])
        if common[leaf] == _EMPTY:
            common[leaf] = label[i]
        elif common[leaf] != label[i]:
            common[leaf] = _MIXED
    build_above(nodes, levels, 1, FAN)

    # Labels of the nodes above.
    for level in range(1, levels.shape[0]):
        for i in range(levels[level - 1, 2]):
            below, node = levels[level - 1, 0] + i, levels[level, 0] + i // FAN
            if common[node] == _EMPTY:
                common[node] = common[below]
            elif common[node] != common[below]:
                common[node] = _MIXED
    return nodes, levels, common


@entry("d2 d2 l1 l1 d2 l2 l1 l2 -> l")
def overlapping_directions(boxes, spaces, label, order, nodes, levels, common, pairs):
    """Write rows of boxes that overlap, in `spaces` too, and have no common label; their number.

    Each pair once, the lower row first. Pairs beyond the capacity of `pairs` are counted only.
    """
    stack = np.empty((4096, 4), dtype=np.int64)
    stack[0, 0] = stack[0, 2] = nodes.shape[0] - 1
    stack[0, 1] = stack[0, 3] = levels.shape[0] - 1
    top = 1
    n = 0
    while top > 0:
        top -= 1
        i, level_i, j, level_j = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3]

        # Skip nodes with one common label, and nodes that do not overlap.
        if (common[i] >= 0 and common[i] == common[j]) or boxes_apart(nodes, i, nodes, j):
            continue
        if level_i == 0 and level_j == 0:
            for p in range(LEAF * i, min(LEAF * i + LEAF, order.shape[0])):
                one = order[p]
                # Within one leaf each pair once.
                start = p + 1 if i == j else LEAF * j
                for q in range(start, min(LEAF * j + LEAF, order.shape[0])):
                    two = order[q]
                    if label[one] >= 0 and label[one] == label[two]:
                        continue
                    if not (
                        boxes_apart(boxes, one, boxes, two) or boxes_apart(spaces, one, spaces, two)
                    ):
                        n = append_pair(pairs, n, min(one, two), max(one, two))
            continue
        # The stack grows before a split could overflow it.
        if top + FAN * FAN > stack.shape[0]:
            larger = np.empty((2 * stack.shape[0], 4), dtype=np.int64)
            larger[: stack.shape[0]] = stack
            stack = larger

        # Split the larger node; a node with itself gives each pair of children once.
        if level_j == 0 or (level_i > 0 and (i == j or extent(nodes, i) >= extent(nodes, j))):
            split, level, other, level_other = i, level_i, j, level_j
        else:
            split, level, other, level_other = j, level_j, i, level_i
        first = levels[level - 1, 0] + (split - levels[level, 0]) * FAN
        last = min(first + FAN, levels[level, 0])
        for child in range(first, last):
            if i != j:
                stack[top, 0], stack[top, 1] = child, level - 1
                stack[top, 2], stack[top, 3] = other, level_other
                top += 1
                continue
            for second in range(child, last):  # a node with itself: each pair of children once
                stack[top, 0], stack[top, 1] = child, level - 1
                stack[top, 2], stack[top, 3] = second, level - 1
                top += 1
    return n
