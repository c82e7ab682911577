"""Lines formed by links between numbered points; crossings of two lines in the map; distances to
lines.

Points are 0 .. n - 1. Lines are stored one after the other: points, and the start of each line.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar

# ---- fault distance ----------------------------------------
# Distance of a datum from a fault at its own elevation, and lattice edges that a trace cuts.
#
# Notation
#     x, y, z     a point; x and y in cells of the lattice, z in metres
#     a, b        ends of the segment in which a triangle meets the level of the point
#     p, q        ends of a piece of a trace, in units of 2**-22 cells: x is 2 mod 4, y is odd,
#                 so that no end lies on a line of the lattice or on a diagonal
#     m, n        nodes at the ends of a link; kinds of links: 0 east, 1 north, 2 north-east (from
#                 the lower left node), 3 north-west (from the lower right node, named by its left)
#
# Candidates come from blocks of the map: `starts` and `items` list what can be near each block. A
# trace cuts a link if it crosses the link an odd number of times. Signs are those of integers; a
# node on the trace counts as left of it. So a triangle has an odd number of cut edges exactly if an
# end of the trace lies in it.


UNIT = 4194304  # 2**22


@scalar
def distance_to_segment(x, y, ax, ay, bx, by):
    """Squared distance to a segment, parameter of the nearest point, and squared length."""
    tx, ty = bx - ax, by - ay
    length2 = tx * tx + ty * ty
    t = 0.0
    # A segment without length is its first end.
    if length2 > 0.0:
        t = ((x - ax) * tx + (y - ay) * ty) / length2

    # Clamp to the segment.
    t = min(1.0, max(0.0, t))
    dx, dy = x - ax - t * tx, y - ay - t * ty
    return dx * dx + dy * dy, t, length2


@scalar
def signed_offset(x, y, ax, ay, bx, by, length2):
    """Signed distance from the line of a segment, positive on its left; 0 if it is a point."""
    if length2 > 0.0:
        return ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / np.sqrt(length2)
    return 0.0


@scalar
def distance_to_box(x, y, box):
    """Squared distance to a box, 0 inside."""
    dx = max(box[0] - x, x - box[2], 0.0)
    dy = max(box[1] - y, y - box[3], 0.0)
    return dx * dx + dy * dy


@scalar
def _level_segment(corners, z):
    """Where a triangle meets a level: found, ax, ay, bx, by; half-open, so that edges agree."""
    n = 0
    ax = ay = bx = by = 0.0
    for i in range(3):
        j = (i + 1) % 3
        zi, zj = corners[3 * i + 2], corners[3 * j + 2]
        if (zi <= z) != (zj <= z):
            # Interpolate from the lower end, so that neighbours agree.
            lo, hi = (i, j) if zi < zj else (j, i)
            f = (z - corners[3 * lo + 2]) / (corners[3 * hi + 2] - corners[3 * lo + 2])
            px = corners[3 * lo] + f * (corners[3 * hi] - corners[3 * lo])
            py = corners[3 * lo + 1] + f * (corners[3 * hi + 1] - corners[3 * lo + 1])
            if n == 0:
                ax, ay = px, py
            else:
                bx, by = px, py
            n += 1
    return n == 2, ax, ay, bx, by


@entry("d2 l1 d2 d2 d2 l1 l1 d -> d1 d1")
def distance_at_elevation(points, block, corners, boxes, normals, starts, items, reach):
    """Distance (n,) of points to a fault at their own elevation, and side (n,): +1, -1, 0 if far.

    `corners` (m, 9), `boxes` in the map and horizontal `normals` (m, 2) of the fault's triangles.
    """
    n = points.shape[0]
    far = np.full(n, reach)
    side = np.zeros(n)

    # Elevation range of each triangle.
    low, high = np.empty(corners.shape[0]), np.empty(corners.shape[0])
    for f in range(corners.shape[0]):
        low[f] = min(corners[f, 2], corners[f, 5], corners[f, 8])
        high[f] = max(corners[f, 2], corners[f, 5], corners[f, 8])
    for k in range(n):
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        best, lead = reach * reach, -1.0
        for at in range(starts[block[k]], starts[block[k] + 1]):
            f = items[at]
            if z < low[f] or z >= high[f]:  # half-open, as `_level_segment` is
                continue
            # A box is never farther than its triangle; the margin covers rounding.
            if distance_to_box(x, y, boxes[f]) > best * (1.0 + 1e-8):
                continue

            # The segment at this level, and its distance in the map.
            found, ax, ay, bx, by = _level_segment(corners[f], z)
            if not found:
                continue
            d2, _, length2 = distance_to_segment(x, y, ax, ay, bx, by)
            if d2 > best * (1.0 + 1e-9):
                continue
            left = signed_offset(x, y, ax, ay, bx, by, length2)
            # at a corner of the slice both segments are equally near: the larger offset decides
            if d2 > best * (1.0 - 1e-9) and abs(left) <= lead:
                continue

            # Orient the segment by the normal of the fault.
            turn = (bx - ax) * normals[f, 1] - (by - ay) * normals[f, 0]
            best, lead = min(best, d2), abs(left)
            side[k] = 1.0 if (left >= 0.0) == (turn >= 0.0) else -1.0
        far[k] = np.sqrt(best)
    return far, side


@scalar
def _left(px, py, qx, qy, nx, ny):
    """Whether n is left of the line pq, or on it."""
    return (qx - px) * (ny - py) - (qy - py) * (nx - px) >= 0


@entry("l2 l l -> l2 d1")
def cut_links(ends, n_row, n_col):
    """Links that pieces of a trace cross: rows (node, kind, piece, +1 if the node's end is left).

    `ends` (n, 4) are p and q of each piece; also the parameter on the piece, 0 to 1, of each
    crossing.
    """
    size = 64
    rows = np.empty((size, 4), dtype=np.int64)
    place = np.empty(size)
    count = 0
    for s in range(ends.shape[0]):
        px, py, qx, qy = ends[s, 0], ends[s, 1], ends[s, 2], ends[s, 3]
        # most pieces lie inside one cell, where only diagonals can cross them
        south, west = min(py, qy) // UNIT, min(px, qx) // UNIT
        for row in range(south, max(py, qy) // UNIT + 1):
            for col in range(west, max(px, qx) // UNIT + 1):
                for kind in range(4):
                    if (kind == 0 and row == south) or (kind == 1 and col == west):
                        continue  # links on the near sides of the nearest cells

                    # Nodes at the ends of the link, inside the lattice.
                    m = col + (1 if kind == 3 else 0)
                    n = col + (1 if kind == 0 or kind == 2 else 0)
                    up = 0 if kind == 0 else 1
                    # Traces may leave the lattice.
                    if col < 0 or row < 0 or row + up >= n_row or max(m, n) >= n_col:
                        continue

                    # A crossing needs opposite sides for both segments.
                    mx, my, nx, ny = m * UNIT - px, row * UNIT - py, n * UNIT - px, 0
                    ny = (row + up) * UNIT - py
                    is_left = _left(0, 0, qx - px, qy - py, mx, my)
                    if is_left == _left(0, 0, qx - px, qy - py, nx, ny):
                        continue
                    if _left(mx, my, nx, ny, 0, 0) == _left(mx, my, nx, ny, qx - px, qy - py):
                        continue
                    if count == size:
                        rows = np.concatenate((rows, np.empty_like(rows)))
                        place = np.concatenate((place, np.empty_like(place)))
                        size *= 2
                    rows[count, 0] = row * n_col + col
                    rows[count, 1] = kind
                    rows[count, 2] = s
                    rows[count, 3] = 1 if is_left else -1
                    # in floats: only the order along the trace is read from it
                    over = float((nx - mx) * (0 - my) - (ny - my) * (0 - mx))
                    under = float((nx - mx) * (qy - py - my) - (ny - my) * (qx - px - mx))
                    place[count] = over / (over - under)
                    count += 1
    return rows[:count].copy(), place[:count].copy()


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
def line_crossings(first, second):
    """Places (n, 2) where pieces (n, 4) of two lines cross: piece plus fraction, on each."""
    out = np.empty((16, 2))
    n = 0
    n_chunk = (second.shape[0] + CHUNK - 1) // CHUNK
    boxes = np.empty((n_chunk, 4))
    for c in range(n_chunk):
        _box_of(second, c * CHUNK, min((c + 1) * CHUNK, second.shape[0]), boxes[c])
    whole, box, part = np.empty(4), np.empty(4), np.empty(4)
    # One comparison excludes most pieces of the other line.
    _box_of(second, 0, second.shape[0], whole)
    for i in range(first.shape[0]):
        _box_of(first, i, i + 1, box)
        if _apart(box, whole):
            continue

        # Boxes of chunks, then of pieces, then the intersection of two segments.
        rx, ry = first[i, 2] - first[i, 0], first[i, 3] - first[i, 1]
        for c in range(n_chunk):
            if _apart(box, boxes[c]):
                continue
            for j in range(c * CHUNK, min((c + 1) * CHUNK, second.shape[0])):
                _box_of(second, j, j + 1, part)
                if _apart(box, part):
                    continue
                sx, sy = second[j, 2] - second[j, 0], second[j, 3] - second[j, 1]
                det = rx * sy - ry * sx
                # Parallel pieces have no single crossing.
                if det == 0.0:
                    continue
                dx, dy = second[j, 0] - first[i, 0], second[j, 1] - first[i, 1]
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
                left, right = dx * ay - dy * ax, dx * by - dy * bx
                # Half-open, so that a joint of two pieces is hit once.
                if (left >= 0) == (right >= 0):
                    continue
                f = left / (left - right)
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
