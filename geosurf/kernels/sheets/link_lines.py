"""Lines formed by links between numbered points; crossings of two lines in the map; distances to
lines.

Points are 0 .. n - 1. Lines are stored one after the other: points, and the start of each line.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.sheets.fault_distance import (
    distance_to_box,
    distance_to_segment,
    signed_offset,
)

CHUNK = 32  # pieces of a line with a common box, for crossings
NEAR = 8  # the same for distances


@entry("l1 l1 l -> l1 l1")
def directed_lines(tail, head, n_point):
    """Lines along links tail -> head, one out of each point; a closed line repeats its first point.

    Open lines first, in the order of their first links, then closed ones.
    """
    n = tail.shape[0]
    # The next point; -1 where no link leaves, and after it was followed.
    onward = np.full(n_point, -1, dtype=np.int64)
    entered = np.zeros(n_point, dtype=np.bool_)
    for k in range(n):
        onward[tail[k]] = head[k]
        entered[head[k]] = True
    out = np.empty(2 * n, dtype=np.int64)
    starts = np.empty(n + 1, dtype=np.int64)
    m = lines = 0

    # First from points that no link enters, then what is left: closed lines.
    for turn in range(2):
        for k in range(n):
            v = tail[k]
            # First only points where a line begins.
            if onward[v] < 0 or (turn == 0 and entered[v]):
                continue
            starts[lines] = m
            lines += 1
            out[m] = v
            m += 1
            while onward[v] >= 0:
                ahead = onward[v]
                # Each link is used once, so a closed line ends at its first point.
                onward[v] = -1
                v = ahead
                out[m] = v
                m += 1
    starts[lines] = m
    return out[:m].copy(), starts[: lines + 1].copy()


@entry("l1 l1 l1 l1 -> l1 l1")
def undirected_lines(first, other_end, link, order):
    """Longest lines between points that do not have exactly two links; then closed lines.

    Point v has links ``link[first[v] : first[v + 1]]`` to ``other_end[..]``, increasing. `order`:
    the points where lines may start, in sequence.
    """
    n_link = link.shape[0] // 2
    done = np.zeros(n_link, dtype=np.bool_)
    out = np.empty(2 * n_link, dtype=np.int64)
    starts = np.empty(n_link + 1, dtype=np.int64)
    m = lines = 0
    for k in range(order.shape[0]):
        start = order[k]
        for at in range(first[start], first[start + 1]):
            if done[link[at]]:
                continue
            done[link[at]] = True
            starts[lines] = m
            lines += 1
            out[m], out[m + 1] = start, other_end[at]
            m += 2

            # Continue while the point has exactly two links.
            before, v = start, other_end[at]
            while first[v + 1] - first[v] == 2:
                # Of two links the one that does not lead back.
                one = first[v] if other_end[first[v]] != before else first[v] + 1
                # The line has closed.
                if done[link[one]]:
                    break
                done[link[one]] = True
                before, v = v, other_end[one]
                out[m] = v
                m += 1
    starts[lines] = m
    return out[:m].copy(), starts[: lines + 1].copy()


@scalar
def _box_of(ends, first, last, box):
    # Lower and upper corner over both ends of each piece.
    box[0] = box[1] = np.inf
    box[2] = box[3] = -np.inf
    for k in range(first, last):
        box[0] = min(box[0], ends[k, 0], ends[k, 2])
        box[1] = min(box[1], ends[k, 1], ends[k, 3])
        box[2] = max(box[2], ends[k, 0], ends[k, 2])
        box[3] = max(box[3], ends[k, 1], ends[k, 3])


@scalar
def _apart(a, b):
    return a[0] > b[2] or b[0] > a[2] or a[1] > b[3] or b[1] > a[3]


@entry("d2 d2 -> d2")
def line_crossings(one, two):
    """Places (n, 2) where pieces (n, 4) of two lines cross: piece plus fraction, on each."""
    out = np.empty((16, 2))
    n = 0
    n_chunk = (two.shape[0] + CHUNK - 1) // CHUNK
    boxes = np.empty((n_chunk, 4))
    for c in range(n_chunk):
        _box_of(two, c * CHUNK, min((c + 1) * CHUNK, two.shape[0]), boxes[c])
    whole, mine, part = np.empty(4), np.empty(4), np.empty(4)
    # One comparison excludes most pieces of the other line.
    _box_of(two, 0, two.shape[0], whole)
    for i in range(one.shape[0]):
        _box_of(one, i, i + 1, mine)
        if _apart(mine, whole):
            continue

        # Boxes of chunks, then of pieces, then the intersection of two segments.
        rx, ry = one[i, 2] - one[i, 0], one[i, 3] - one[i, 1]
        for c in range(n_chunk):
            if _apart(mine, boxes[c]):
                continue
            for j in range(c * CHUNK, min((c + 1) * CHUNK, two.shape[0])):
                _box_of(two, j, j + 1, part)
                if _apart(mine, part):
                    continue
                sx, sy = two[j, 2] - two[j, 0], two[j, 3] - two[j, 1]
                det = rx * sy - ry * sx
                # Parallel pieces have no single crossing.
                if det == 0.0:
                    continue
                dx, dy = two[j, 0] - one[i, 0], two[j, 1] - one[i, 1]
                t, u = (dx * sy - dy * sx) / det, (dx * ry - dy * rx) / det
                # Half-open: a crossing at the joint of two pieces counts once.
                if not (t >= 0.0 and t < 1.0 and u >= 0.0 and u < 1.0):
                    continue
                if n == out.shape[0]:
                    out = np.concatenate((out, np.empty_like(out)))
                out[n, 0], out[n, 1] = i + t, j + u
                n += 1
    return out[:n].copy()


@scalar
def _to_piece(x, y, ends, k):
    """Squared distance to a piece, place on it, and its squared length."""
    return distance_to_segment(x, y, ends[k, 0], ends[k, 1], ends[k, 2], ends[k, 3])


@scalar
def _least(x, y, ends, first):
    """Least squared distance to NEAR pieces from one on."""
    least = np.inf
    for s in range(first, min(first + NEAR, ends.shape[0])):
        least = min(least, _to_piece(x, y, ends, s)[0])
    return least


@entry("d2 d2 d2 d2 d -> d1 d1")
def first_hits(stations, direction, pieces, boxes, reach):
    """Signed distance (n,) along a direction to the nearest of some pieces, and elevation there.

    `pieces` (m, 6) are two points each, `boxes` those of CHUNK pieces; NaN beyond `reach`.
    """
    n = stations.shape[0]
    where, height = np.full(n, np.nan), np.full(n, np.nan)
    for k in range(n):
        x, y, dx, dy = stations[k, 0], stations[k, 1], direction[k, 0], direction[k, 1]
        best = np.inf
        for c in range(boxes.shape[0]):
            if distance_to_box(x, y, boxes[c]) > reach * reach * (1.0 + 1e-9):
                continue
            for p in range(c * CHUNK, min((c + 1) * CHUNK, pieces.shape[0])):
                ax, ay, bx, by = pieces[p, 0] - x, pieces[p, 1] - y, pieces[p, 3] - x, 0.0
                by = pieces[p, 4] - y

                # The piece crosses the direction where its ends lie on two sides.
                one, two = dx * ay - dy * ax, dx * by - dy * bx
                # Half-open, so that a joint of two pieces is hit once.
                if (one >= 0) == (two >= 0):
                    continue
                f = one / (one - two)
                t = (ax + f * (bx - ax)) * dx + (ay + f * (by - ay)) * dy
                if abs(t) <= reach and abs(t) < best:
                    best = abs(t)
                    where[k], height[k] = t, pieces[p, 2] + f * (pieces[p, 5] - pieces[p, 2])
    return where, height


@entry("d2 l1 d2 d2 l1 l1 d -> d1 d1 l1 d1")
def nearest_on_line(points, block, ends, boxes, starts, items, reach):
    """Distance of points to a line, side (+1 left), nearest piece (-1 far), parameter on it.

    `boxes` are those of NEAR pieces each; `items` list the boxes near a block. Equally near pieces
    are compared in their order, so the result does not depend on what was skipped.
    """
    n = points.shape[0]
    far = np.full(n, reach)
    side = np.zeros(n)
    nearest = np.full(n, -1, dtype=np.int64)
    place = np.zeros(n)
    before = -1
    for k in range(n):
        x, y = points[k, 0], points[k, 1]
        # the piece nearest to the previous point, mostly its neighbour, limits the search
        # The limit is squared and only shrinks.
        limit = reach * reach
        if before >= 0:
            limit = min(limit, _least(x, y, ends, before))

        # Otherwise the nearest box gives a first limit.
        if before < 0 or limit >= reach * reach:
            first = -1
            for at in range(starts[block[k]], starts[block[k] + 1]):
                d2 = distance_to_box(x, y, boxes[items[at]])
                if d2 < limit:
                    first, limit = items[at] * NEAR, d2
            if first < 0:
                continue
            limit = min(reach * reach, _least(x, y, ends, first))

        # All boxes within the limit, piece by piece.
        limit *= 1.0 + 1e-6
        best, lead = reach * reach, -1.0
        for at in range(starts[block[k]], starts[block[k] + 1]):
            chunk = items[at]
            if distance_to_box(x, y, boxes[chunk]) > limit:
                continue
            for s in range(chunk * NEAR, min((chunk + 1) * NEAR, ends.shape[0])):
                d2, t, length2 = _to_piece(x, y, ends, s)
                if d2 > best * (1.0 + 1e-9):
                    continue
                # at a corner both pieces are equally near: the larger offset decides
                left = signed_offset(x, y, ends[s, 0], ends[s, 1], ends[s, 2], ends[s, 3], length2)
                if d2 > best * (1.0 - 1e-9) and abs(left) <= lead:
                    continue
                best, lead = min(best, d2), abs(left)
                side[k] = 1.0 if left >= 0.0 else -1.0
                nearest[k], place[k] = s, t
                limit = min(limit, best * (1.0 + 1e-6))
        # Points in order are near each other, and so are their nearest pieces.
        if nearest[k] >= 0:
            before = nearest[k] // NEAR * NEAR
        far[k] = np.sqrt(best)
    return far, side, nearest, place
