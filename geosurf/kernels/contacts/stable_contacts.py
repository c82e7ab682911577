"""Pairs of triangles whose contact a rounding of their points could change.

Certified signs with `slip` do not change under such a move (`predicates.filtered_side`). Two
triangles meet only where an edge of one meets the other. An edge misses a triangle if its ends
lie on one side of the plane, or if its line passes two edges of the triangle on different
sides. So some pairs are proven to stay apart. Letters as in `exact_signs`.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.exact.predicates import filtered_side, orient3d, plane_terms


@scalar
def _stable_side(x, a, b, c, o, slip):
    """Side of the plane of a, b, c on which vertex o lies; 0 where a move could change it.

    Floats may decide for one choice of the first corner and not for another. All three choices are
    tried, so the result does not depend on the numbering of corners.
    """
    for _ in range(3):
        n0, n1, n2, s0, s1, s2, span = plane_terms(x, a, b, c)
        cx, cy, cz = x[o, 0] - x[a, 0], x[o, 1] - x[a, 1], x[o, 2] - x[a, 2]
        side = filtered_side(cx, cy, cz, n0, n1, n2, s0, s1, s2, span, slip)
        if side != 0:
            return side

        # Rotate the corners and try again.
        a, b, c = b, c, a
    return 0


@scalar
def _stable_turn(x, p, q, a, b, slip):
    """Side of the plane of p, q, a on which vertex b lies, from any three of the four."""
    side = _stable_side(x, p, q, a, b, slip)
    if side == 0:
        # The same volume from another triple has the same sign and other rounding errors.
        side = _stable_side(x, q, p, b, a, slip)
    if side == 0:
        side = _stable_side(x, a, b, p, q, slip)
    if side == 0:
        side = _stable_side(x, b, a, q, p, slip)
    return side


@scalar
def _line_misses(x, t, p, q, b, slip):
    """Whether the line of vertices p, q certainly passes two edges of triangle b differently."""
    # A line that passes the edges on different sides misses the triangle.
    left = right = False
    # The side on which the line passes edge k, from the volume of both.
    for k in range(3):
        side = _stable_turn(x, p, q, t[b, k], t[b, (k + 1) % 3], slip)
        left = left or side > 0
        right = right or side < 0
    return left and right


@scalar
def _edges_miss(x, t, a, b, slip):
    """Whether no edge of triangle a can meet triangle b."""
    corners = t[b, 0], t[b, 1], t[b, 2]

    # Sides of the corners of a over the plane of b.
    s0 = _stable_side(x, corners[0], corners[1], corners[2], t[a, 0], slip)
    s1 = _stable_side(x, corners[0], corners[1], corners[2], t[a, 1], slip)
    s2 = _stable_side(x, corners[0], corners[1], corners[2], t[a, 2], slip)

    # Each edge stays on one side of the plane, or its line misses the triangle.
    return (
        (s0 * s1 > 0 or _line_misses(x, t, t[a, 0], t[a, 1], b, slip))
        and (s1 * s2 > 0 or _line_misses(x, t, t[a, 1], t[a, 2], b, slip))
        and (s2 * s0 > 0 or _line_misses(x, t, t[a, 2], t[a, 0], b, slip))
    )


@scalar
def _on_one_side(x, t, a, b, slip):
    """Whether all corners of triangle a certainly lie on one side of the plane of b."""
    # The other corners have to agree with the first one.
    side = _stable_side(x, t[b, 0], t[b, 1], t[b, 2], t[a, 0], slip)
    return side != 0 and (
        side == _stable_side(x, t[b, 0], t[b, 1], t[b, 2], t[a, 1], slip)
        and side == _stable_side(x, t[b, 0], t[b, 1], t[b, 2], t[a, 2], slip)
    )


@scalar
def _boxes_apart(x, t, a, b):
    """Whether the boxes of two triangles have no point in common."""
    for k in range(3):
        # Compare the intervals of both triangles on this axis.
        low = min(x[t[a, 0], k], min(x[t[a, 1], k], x[t[a, 2], k]))
        high = max(x[t[a, 0], k], max(x[t[a, 1], k], x[t[a, 2], k]))
        if max(x[t[b, 0], k], max(x[t[b, 1], k], x[t[b, 2], k])) < low:
            return True
        if min(x[t[b, 0], k], min(x[t[b, 1], k], x[t[b, 2], k])) > high:
            return True
    return False


@scalar
def _largest(x, t, a):
    """Largest absolute coordinate of a triangle."""
    size = 0.0
    for i in range(3):
        for k in range(3):
            size = max(size, abs(x[t[a, i], k]))
    return size


@scalar
def _stays_apart(x, t, a, b, slip):
    """Whether triangles stay apart; boxes are not widened, since rounded points stay in them."""
    return (
        _boxes_apart(x, t, a, b)
        or _on_one_side(x, t, a, b, slip)
        or _on_one_side(x, t, b, a, slip)
        or (_edges_miss(x, t, a, b, slip) and _edges_miss(x, t, b, a, slip))
    )


@scalar
def _is_near_plane(x, t, m, w, a, b, slip):
    """Whether a corner of triangle a is off the plane of b, but not certainly."""
    p, q, r = t[b, 0], t[b, 1], t[b, 2]
    for k in range(3):
        o = t[a, k]
        # Undecided by floats, but not exactly in the plane: a move could change its side.
        if _stable_side(x, p, q, r, o, slip) == 0 and orient3d(x, m, w, p, q, r, o, slip) != 0:
            return True
    return False


@entry("d2 l2 l1* l1* l2 b1 d -> b1")
def unstable_pairs(x, t, m, w, pairs, meet, part):
    """Pairs whose contact could change if points moved by a part of their coordinates.

    Of those that `meet`: pairs with a corner close to the other's plane, but not in it. Of the
    others: pairs that are not proven to stay apart.
    """
    found = np.empty(pairs.shape[0], dtype=np.bool_)
    for i in range(pairs.shape[0]):
        a, b = pairs[i, 0], pairs[i, 1]

        # The move is relative to the largest coordinate of the pair.
        slip = part * max(_largest(x, t, a), _largest(x, t, b))

        # Contacts: a corner must not be almost in the plane of the other triangle.
        if meet[i]:
            found[i] = _is_near_plane(x, t, m, w, a, b, slip) or _is_near_plane(
                x, t, m, w, b, a, slip
            )
        else:
            found[i] = not _stays_apart(x, t, a, b, slip)
    return found
