"""Ray casting along an axis: which surface does a ray hit first after leaving its own?

A ray starts inside a triangle and runs up one axis. It leaves its own set of triangles (a piece of
a surface) at the topmost triangle that it passes; the next surface that it hits encloses that
piece. Triangles come from a tree of boxes, nearest first. Each is missed or hit at a height, with
error bounds for both. Where bounds do not decide (a ray through an edge, two hits at one height),
the ray is aimed again; after a few attempts the question is left to exact arithmetic.

Notation
    x, t          points (n, 3), triangles (m, 3)
    order         triangles as they lie in leaves; nodes, levels: boxes of the tree, see `tree`
    set_of        the set of each triangle (m,)
    seen          whether a triangle may enclose others; if not, only its own set uses it
    u, v, axis    the two axes after `axis`, and the axis of a ray
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.exact.predicates import TINY
from geosurf.kernels.search.tree import FAN, LEAF

NO_HIT, UNDECIDED = -1, -2
_AIMS = 4
_MISSED, _MET, _UNDECIDED = 0, 1, 2
_AREA = 3.4e-16  # Shewchuk's bound for a turn of three points in the plane is 3.33e-16
_HEIGHT = 1e-14  # of a coordinate: ten times what sums of three can lose


class _Scene(NamedTuple):
    """All triangles with their tree, and scratch of a ray: where it is aimed at, nodes to visit."""

    x: np.ndarray
    t: np.ndarray
    order: np.ndarray
    nodes: np.ndarray
    levels: np.ndarray
    set_of: np.ndarray
    seen: np.ndarray
    aim: np.ndarray
    stack: np.ndarray


@scalar
def _signed_area(px, py, qx, qy, ax, ay):
    """Twice the signed area of a, p, q, and a bound of its error."""
    left = (px - ax) * (qy - ay)
    right = (py - ay) * (qx - ax)
    return left - right, _AREA * (abs(left) + abs(right)) + TINY


@scalar
def _height(scene, row, axis):
    """(_MISSED, _MET or _UNDECIDED, height of the hit, its error, +1 where the front faces up)."""
    x, t = scene.x, scene.t
    u, v = (axis + 1) % 3, (axis + 2) % 3
    ax, ay = scene.aim[u], scene.aim[v]
    p, q, r = t[row, 0], t[row, 1], t[row, 2]

    # The signs of three areas say whether the ray passes inside the triangle.
    a, ea = _signed_area(x[q, u], x[q, v], x[r, u], x[r, v], ax, ay)
    b, eb = _signed_area(x[r, u], x[r, v], x[p, u], x[p, v], ax, ay)
    c, ec = _signed_area(x[p, u], x[p, v], x[q, u], x[q, v], ax, ay)
    # Two certain signs differ: the ray passes outside an edge.
    if (a > ea or b > eb or c > ec) and (a < -ea or b < -eb or c < -ec):
        return _MISSED, 0.0, 0.0, 0
    # Through an edge, or too near to one: aim again.
    if not ((a > ea and b > eb and c > ec) or (a < -ea and b < -eb and c < -ec)):
        return _UNDECIDED, 0.0, 0.0, 0

    # Interpolate the height from the areas; a nearly vertical triangle is undecided.
    total, error = a + b + c, ea + eb + ec
    if abs(total) < 8.0 * error:
        return _UNDECIDED, 0.0, 0.0, 0
    z, zq, zr = x[p, axis], x[q, axis] - x[p, axis], x[r, axis] - x[p, axis]
    size = abs(x[p, axis]) + abs(x[q, axis]) + abs(x[r, axis])
    span = abs(zq) + abs(zr)
    # The error of the areas over the triangle, and the rounding of the height itself.
    reach = 8.0 * error / abs(total) * span + _HEIGHT * size + TINY
    return _MET, z + (b * zq + c * zr) / total, reach, 1 if total > 0.0 else -1


@scalar
def _push_children(scene, node, level, axis, low, high, top):
    """Push the children that a ray passes between two heights, the lowest on top."""
    nodes, levels, stack = scene.nodes, scene.levels, scene.stack
    u, v = (axis + 1) % 3, (axis + 2) % 3
    ax, ay = scene.aim[u], scene.aim[v]
    first = levels[level - 1, 0] + (node - levels[level, 0]) * FAN
    begin = top
    for child in range(first, min(first + FAN, levels[level, 0])):
        # Outside the height interval, or beside the ray.
        if nodes[child, 3 + axis] < low or nodes[child, axis] > high:
            continue
        if nodes[child, u] > ax or nodes[child, 3 + u] < ax:
            continue
        if nodes[child, v] > ay or nodes[child, 3 + v] < ay:
            continue

        # Insertion sort by the lower end of the boxes.
        k = top
        while k > begin and nodes[stack[k - 1, 0], axis] < nodes[child, axis]:
            stack[k, 0], stack[k, 1] = stack[k - 1, 0], stack[k - 1, 1]
            k -= 1
        stack[k, 0], stack[k, 1] = child, level - 1
        top += 1
    return top


@scalar
def _side_of_top(scene, mine, axis, low, high):
    """Topmost side of a set that a ray passes, and bounds of its height; or UNDECIDED."""
    order, stack = scene.order, scene.stack
    side, best_low, best_high = UNDECIDED, -np.inf, -np.inf
    extreme, next_extreme = -np.inf, -np.inf  # the highest that any may be, and the one after it
    stack[0, 0], stack[0, 1], top = scene.nodes.shape[0] - 1, scene.levels.shape[0] - 1, 1
    while top > 0:
        top -= 1
        node, level = stack[top, 0], stack[top, 1]

        # Descend: only nodes that the ray passes are pushed.
        if level > 0:
            top = _push_children(scene, node, level, axis, low, high, top)
            continue
        for k in range(LEAF * node, min(LEAF * node + LEAF, order.shape[0])):
            if scene.set_of[order[k]] != mine:
                continue
            met, z, reach, facing = _height(scene, order[k], axis)
            # Whatever is undecided could be the topmost.
            if met == _UNDECIDED:
                return UNDECIDED, 0.0, 0.0
            if met == _MISSED:
                continue

            # Keep the two highest upper bounds, and the hit with the highest lower bound.
            if z + reach > extreme:
                extreme, next_extreme = z + reach, extreme
            elif z + reach > next_extreme:
                next_extreme = z + reach
            if z - reach > best_low:
                best_low, best_high = z - reach, z + reach
                side = 2 * order[k] + (0 if facing > 0 else 1)

    # Decided only if one hit has both the highest lower and the highest upper bound, and no other
    # hit reaches it.
    if (
        side == UNDECIDED
        or (best_high == extreme and next_extreme >= best_low)
        or best_high != extreme
    ):
        return UNDECIDED, 0.0, 0.0
    return side, best_low, best_high


@scalar
def _side_above(scene, mine, axis, below, above):
    """First side of another set that a ray hits above [below, above]; or NO_HIT, UNDECIDED."""
    x, t, order, stack = scene.x, scene.t, scene.order, scene.stack
    side, best_low, best_high = NO_HIT, np.inf, np.inf
    extreme, next_extreme = np.inf, np.inf  # the lowest that any may be, and the one after it
    stack[0, 0], stack[0, 1], top = scene.nodes.shape[0] - 1, scene.levels.shape[0] - 1, 1
    while top > 0:
        top -= 1
        node, level = stack[top, 0], stack[top, 1]

        # Nodes above the best hit so far cannot improve it.
        if scene.nodes[node, axis] > best_high:
            continue
        if level > 0:
            top = _push_children(scene, node, level, axis, below, best_high, top)
            continue
        for k in range(LEAF * node, min(LEAF * node + LEAF, order.shape[0])):
            row = order[k]
            if scene.set_of[row] == mine or not scene.seen[row]:
                continue
            # All of the triangle is below the start.
            if max(x[t[row, 0], axis], x[t[row, 1], axis], x[t[row, 2], axis]) < below:
                continue
            met, z, reach, facing = _height(scene, row, axis)
            if met == _UNDECIDED:
                return UNDECIDED
            if met == _MISSED or z + reach < below:
                continue

            # A hit that may lie at or below the start is not decided.
            if z - reach <= above:
                return UNDECIDED

            # Keep the two lowest lower bounds, and the hit with the lowest upper bound.
            if z - reach < extreme:
                extreme, next_extreme = z - reach, extreme
            elif z - reach < next_extreme:
                next_extreme = z - reach
            if z + reach < best_high:
                best_low, best_high = z - reach, z + reach
                side = 2 * row + (1 if facing > 0 else 0)

    # One hit has to be the lowest by both bounds, and no other hit may reach down to it.
    if side != NO_HIT and (best_low != extreme or next_extreme <= best_high):
        return UNDECIDED
    return side


@entry("d2 l2 l1 d2 l2 l1 b1 l1 l1 d1 l2* -> .")
def cast_rays(x, t, order, nodes, levels, set_of, seen, starts, axes, tops, sides):
    """Write for each ray the side where it leaves its set, and the first side of others that it
    hits.

    Ray i starts in triangle `starts[i]` along `axes[i]`; no triangle of its set reaches above
    `tops[i]`. Sides are ``2 * triangle`` for the front and one more for the back. NO_HIT: nothing
    is hit; UNDECIDED in both: floats do not decide.
    """
    stack = np.empty((FAN * (levels.shape[0] + 1) + 8, 2), dtype=np.int64)
    aim = np.empty(3)
    scene = _Scene(x, t, order, nodes, levels, set_of, seen, aim, stack)
    for i in range(starts.shape[0]):
        row, axis = starts[i], axes[i]
        a, b, c = t[row, 0], t[row, 1], t[row, 2]

        # The own triangle bounds the search from below.
        low = min(x[a, axis], x[b, axis], x[c, axis])
        sides[i, 0] = sides[i, 1] = UNDECIDED
        mine = set_of[row]
        for attempt in range(_AIMS):
            # Aim at another inner point of the triangle in each attempt.
            # Weights 1, r and r squared: an inner point, another one in each attempt.
            ratio = (31.0 + attempt) / 40.0
            total = 1.0 + ratio + ratio * ratio
            for k in range(3):
                aim[k] = (x[a, k] + ratio * x[b, k] + ratio * ratio * x[c, k]) / total
            outer, below, above = _side_of_top(scene, mine, axis, low, tops[i])
            if outer == UNDECIDED:
                continue
            holding = _side_above(scene, mine, axis, below, above)
            if holding != UNDECIDED:
                sides[i, 0], sides[i, 1] = outer, holding
                break


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
