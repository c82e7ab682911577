"""Which points are so near a segment that they may lie on it? Group by group.

A group holds the segments of one face and the points known to lie in the face. Small groups are
compared directly. The points of large groups are put into a tree, halved along the widest axis of
their box, and each segment visits the boxes that it passes. So the cost follows the number of near
pairs, also where thousands of segments cross one large face.

Notation
    x             coordinates, float64 (n, 3)
    segments      rows of x (n, 2); points: rows of x (m,)
    first_segment, first_point      start of each group, and the end of the last
    reach         [m], at least 0: points farther from a line are not near
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.search.tree import append_pair

LEAF = 8
_FEW = 256  # up to so many pairs in a group there is no tree


@scalar
def is_near_segment(x, a, b, p, reach):
    """Whether point p, not an end of segment a-b, is within reach of it."""
    if p == a or p == b:
        return False

    # Box test first.
    for k in range(3):
        low, high = min(x[a, k], x[b, k]), max(x[a, k], x[b, k])
        if x[p, k] < low - reach or x[p, k] > high + reach:
            return False

    # Squared distance from the line, times the squared length, by a cross product.
    ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    vx, vy, vz = x[p, 0] - x[a, 0], x[p, 1] - x[a, 1], x[p, 2] - x[a, 2]
    wx, wy, wz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    away, along = wx * wx + wy * wy + wz * wz, ux * ux + uy * uy + uz * uz
    # Both sides multiplied by the squared length: no division, also at length 0.
    most = reach * reach * along
    return away <= most or most < 1e-280  # squares of tiny numbers underflow: count as near


@scalar
def _widest(x, points, low, high, box, node):
    """Write the box of some points; returns its widest axis."""
    for k in range(3):
        box[node, k], box[node, 3 + k] = np.inf, -np.inf
    for i in range(low, high):
        for k in range(3):
            value = x[points[i], k]
            box[node, k] = min(box[node, k], value)
            box[node, 3 + k] = max(box[node, 3 + k], value)
    # Halving the widest axis keeps boxes compact.
    axis = 0
    for k in range(1, 3):
        if box[node, 3 + k] - box[node, k] > box[node, 3 + axis] - box[node, axis]:
            axis = k
    return axis


@scalar
def _halve(x, points, low, high, axis):
    """Partition points along an axis so that the lower half comes first (quickselect)."""
    middle = (low + high) // 2
    first, last = low, high - 1
    while first < last:
        # Hoare partition, then continue in the part that holds the middle.
        pivot = x[points[(first + last) // 2], axis]
        i, j = first, last
        while i <= j:
            while x[points[i], axis] < pivot:
                i += 1
            while x[points[j], axis] > pivot:
                j -= 1
            if i <= j:
                points[i], points[j] = points[j], points[i]
                i += 1
                j -= 1
        # Only one part holds the middle, so the cost is linear on average.
        if middle <= j:
            last = j
        elif middle >= i:
            first = i
        else:
            break
    return middle


@scalar
def _tree(x, points):
    """Boxes, and first and last point of each node, of a tree over points, which are reordered.

    The children of node i are 2 i + 1 and 2 i + 2.
    """
    # A complete binary tree with at most LEAF points per leaf.
    # As many leaves as the next power of two.
    n_node = 1
    while n_node * LEAF < points.shape[0]:
        n_node *= 2
    n_node = 2 * n_node - 1
    box = np.empty((n_node, 6))
    span = np.zeros((n_node, 2), dtype=np.int64)
    span[0, 1] = points.shape[0]
    for node in range(n_node):
        low, high = span[node, 0], span[node, 1]
        axis = _widest(x, points, low, high, box, node)
        if 2 * node + 2 < n_node:
            middle = _halve(x, points, low, high, axis)
            span[2 * node + 1, 0], span[2 * node + 1, 1] = low, middle
            span[2 * node + 2, 0], span[2 * node + 2, 1] = middle, high
    return box, span


@scalar
def _passes(x, a, b, box, node, reach):
    """Whether a segment may come within reach of a box."""
    first, last = 0.0, 1.0

    # Slab test: the part of the segment inside the box, widened by the reach.
    for k in range(3):
        low, high = box[node, k] - 2.0 * reach, box[node, 3 + k] + 2.0 * reach
        start, span_k = x[a, k], x[b, k] - x[a, k]
        if max(start, x[b, k]) < low or min(start, x[b, k]) > high:
            return False
        # A shorter span lies inside the widened slab anyway, and a quotient would overflow.
        if abs(span_k) > 4.0 * reach:
            one, two = (low - start) / span_k, (high - start) / span_k
            first, last = max(first, min(one, two)), min(last, max(one, two))

    # Room for rounding: a box too many costs time, one too few would lose a pair.
    return first <= last + 1e-9


@entry("d2 l2 l1 l1 l1 d l2* -> l")
def points_near_segments(x, segments, first_segment, points, first_point, reach, pairs):
    """Write pairs (segment, point): rows of `segments` and of x; their number.

    The ends of a segment are not listed with it. Pairs beyond the capacity are counted only.
    """
    n = 0
    stack = np.empty(128, dtype=np.int64)
    for group in range(first_segment.shape[0] - 1):
        start, stop = first_segment[group], first_segment[group + 1]
        low, high = first_point[group], first_point[group + 1]

        # Small groups: every segment with every point.
        if (stop - start) * (high - low) <= _FEW:
            for s in range(start, stop):
                for k in range(low, high):
                    if is_near_segment(x, segments[s, 0], segments[s, 1], points[k], reach):
                        n = append_pair(pairs, n, s, points[k])
            continue

        # Large groups: a tree over copies of the points.
        mine = points[low:high].copy()
        box, span = _tree(x, mine)
        for s in range(start, stop):
            a, b = segments[s, 0], segments[s, 1]

            # Depth-first through the boxes that the segment passes.
            top, stack[0] = 1, 0
            while top > 0:
                top -= 1
                node = stack[top]
                if not _passes(x, a, b, box, node, reach):
                    continue
                if 2 * node + 2 < span.shape[0]:
                    stack[top], stack[top + 1] = 2 * node + 1, 2 * node + 2
                    top += 2
                    continue
                for k in range(span[node, 0], span[node, 1]):
                    if is_near_segment(x, a, b, mine[k], reach):
                        n = append_pair(pairs, n, s, mine[k])
    return n
