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
from geosurf.kernels.exact.predicates import ORIENT2D_BOUND, TINY
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


# ---- shadows ----------------------------------------
# Which feet of vertical lines lie in the shadows of triangles on the map?
#
# Feet lie in strips from south to north, sorted by easting in each. A foot on an edge is thought to
# be moved, infinitely little, east or west, and then, infinitely less, north or south (`push`).
# Signs that float arithmetic leaves open are for the caller.


@scalar
def _seen_from_edge(x, a, b, east, north, push):
    """+1 if a foot lies left of edge a -> b, -1 if right, 0 if that is open or a is over b."""
    ux, uy = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1]
    vx, vy = east - x[a, 0], north - x[a, 1]
    left, right = ux * vy, uy * vx
    det, size = left - right, abs(left) + abs(right)
    if size > TINY and abs(det) > ORIENT2D_BOUND * size:
        return 1 if det > 0.0 else -1
    # on a corner, or along an axis: differences are 0 where coordinates are equal, and only there
    at_end = x[b, 0] == east and x[b, 1] == north
    if not (at_end or ((ux == 0.0 or vy == 0.0) and (uy == 0.0 or vx == 0.0))):
        return 0
    # the determinant changes by -uy to the east; to the north, infinitely less, by ux
    change = -uy * push[0] if uy != 0.0 else ux * push[1]
    return 1 if change > 0.0 else (-1 if change < 0.0 else 0)


@scalar
def _first_at_least(rows, column, low, high, value):
    """The first of some rows, rising in a column, that is not below a value; `high` if all are."""
    while low < high:
        half = (low + high) // 2
        if rows[half, column] < value:
            low = half + 1
        else:
            high = half
    return low


@entry("d2 l2 l1 d2 l1 d2 d1 l2* -> l")
def feet_in_shadows(x, t, facing, feet, start, limits, middle, pairs):
    """Write triangle, foot, and whether that is sure, for feet in shadows or on their rims; their
    number. Those beyond the capacity are counted only.

    Triangles that face 0 have no shadow. Strip k has feet from ``start[k]`` on, with northings
    from ``limits[k, 0]`` to ``limits[k, 1]``. Feet on a rim are moved towards `middle`.
    """
    n, n_strip = 0, limits.shape[0]
    push = np.empty(2)
    for f in range(t.shape[0]):
        if facing[f] == 0:
            continue
        a, b, c = t[f, 0], t[f, 1], t[f, 2]
        west = min(x[a, 0], x[b, 0], x[c, 0])
        east = max(x[a, 0], x[b, 0], x[c, 0])
        south = min(x[a, 1], x[b, 1], x[c, 1])
        north = max(x[a, 1], x[b, 1], x[c, 1])

        # strips that reach up to the box, and in each the feet that are not west of it
        strip = _first_at_least(limits, 1, 0, n_strip, south)
        while strip < n_strip and limits[strip, 0] <= north:
            foot = _first_at_least(feet, 0, start[strip], start[strip + 1], west)
            while foot < start[strip + 1] and feet[foot, 0] <= east:
                if south <= feet[foot, 1] <= north:
                    push[0] = 1.0 if feet[foot, 0] <= middle[0] else -1.0
                    push[1] = 1.0 if feet[foot, 1] <= middle[1] else -1.0
                    is_out, is_sure = False, 1
                    for k in range(3):
                        side = _seen_from_edge(
                            x, t[f, k], t[f, (k + 1) % 3], feet[foot, 0], feet[foot, 1], push
                        )
                        if side == -facing[f]:
                            is_out = True
                            break
                        if side == 0:
                            is_sure = 0
                    if not is_out:
                        if n < pairs.shape[0]:
                            pairs[n, 0], pairs[n, 1], pairs[n, 2] = f, foot, is_sure
                        n += 1
                foot += 1
            strip += 1
    return n
