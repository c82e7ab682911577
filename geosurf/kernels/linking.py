"""Segments of curves: which cannot overlap, and all of them in one order.

Where triangles meet in segments that cross their faces, no segment can hold a point of another one
inside, unless both lie in one face. For let p, an end of the segment of faces a' and b',
lie inside that of a and b. Then p is in a and in b', which therefore meet, too: in a segment that
ends at p, and lies in a beside the first; or p is inside that segment. Likewise for a' and
b. But p is on the rim of a' or of b', and a segment with a point of the rim inside runs along it.
So it is enough to look at the segments of each face, and at none where some run along edges.

Letters as in `exact`; contacts as in `contact`.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels._jit import entry, scalar
from geosurf.kernels.contact import (
    COPLANAR,
    FACE,
    FIRST_CODE,
    N_CORNER,
    TRIANGLE_A,
    TRIANGLE_B,
)

_SHORT = 32  # segments of a bucket that are sorted by insertion
_MANY = 64  # segments of a face, above which the general way is faster than comparing all


@scalar
def _on_edge(feature, edge):
    """Whether a feature of a triangle, not its face, lies on an edge."""
    return feature == edge or feature == (edge + 1) % 3 or feature == 3 + edge


@scalar
def _on_one_edge(one, two):
    """Whether two features of a triangle lie on one of its edges."""
    if one == FACE or two == FACE:  # nearly all
        return False
    for edge in range(3):
        if _on_edge(one, edge) and _on_edge(two, edge):
            return True
    return False


@scalar
def _crosses_faces(rows, k):
    """Whether a contact is a segment that runs along no edge."""
    if rows[k, N_CORNER] != 2 or rows[k, COPLANAR] == 1:
        return False
    one, two = rows[k, FIRST_CODE], rows[k, FIRST_CODE + 1]
    return not (_on_one_edge((one >> 3) & 7, (two >> 3) & 7) or _on_one_edge(one & 7, two & 7))


@scalar
def _is_near(x, a, b, p, reach):
    """Whether point p, no end of it, could lie on segment a-b."""
    if p == a or p == b:
        return False
    for axis in range(3):
        low, high = min(x[a, axis], x[b, axis]), max(x[a, axis], x[b, axis])
        if x[p, axis] < low - reach or x[p, axis] > high + reach:
            return False
    ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    vx, vy, vz = x[p, 0] - x[a, 0], x[p, 1] - x[a, 1], x[p, 2] - x[a, 2]
    wx, wy, wz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return wx * wx + wy * wy + wz * wz <= reach * reach * (ux * ux + uy * uy + uz * uz)


@scalar
def _turns_away(x, p, a, q, reach):
    """Whether p and q lie on two sides of a, for sure: no segment from a to one holds the other.

    Where the true points lie on one ray from a, the product of their ways from a is above 0, and
    it is off by less than `reach` times both ways: `reach` is more than ten times what roundings
    move points by, and far above the errors of these products.
    """
    ux, uy, uz = x[p, 0] - x[a, 0], x[p, 1] - x[a, 1], x[p, 2] - x[a, 2]
    vx, vy, vz = x[q, 0] - x[a, 0], x[q, 1] - x[a, 1], x[q, 2] - x[a, 2]
    ways = abs(ux) + abs(uy) + abs(uz) + abs(vx) + abs(vy) + abs(vz)
    return ux * vx + uy * vy + uz * vz < -reach * ways


@scalar
def _are_apart(x, a, b, p, q, reach):
    """Whether the boxes of segments a-b and p-q are farther apart than reach."""
    for axis in range(3):
        low, high = min(x[a, axis], x[b, axis]) - reach, max(x[a, axis], x[b, axis]) + reach
        if max(x[p, axis], x[q, axis]) < low or min(x[p, axis], x[q, axis]) > high:
            return True
    return False


@scalar
def _may_overlap(x, a, b, p, q, reach):
    """Whether an end of one of two segments could lie inside the other one."""
    if a == p or a == q:
        a, b = b, a
    if b == q:
        p, q = q, p
    if b == p and a != q:  # they go on from each other, as nearly all of one face do
        if _turns_away(x, a, b, q, reach):
            return False
    elif _are_apart(x, a, b, p, q, reach):
        return False
    return (
        _is_near(x, a, b, p, reach)
        or _is_near(x, a, b, q, reach)
        or _is_near(x, p, q, a, reach)
        or _is_near(x, p, q, b, reach)
    )


@entry("d2 l l2 l2 d -> l")
def overlap_free(x, n_face, rows, ids, reach):
    """1 if contacts are segments none of which can hold an end of another one inside, else 0.

    0 also where a face has so many that it is dear to say.
    `reach` is above what rounding moves points by; contacts are sorted by their first faces.
    """
    last = np.full(n_face, -1, dtype=np.int64)  # of those with it as their second face
    before = np.empty(rows.shape[0], dtype=np.int64)
    first = 0
    for k in range(rows.shape[0]):
        if not _crosses_faces(rows, k):
            return 0
        if rows[k, TRIANGLE_A] != rows[first, TRIANGLE_A]:
            first = k
        if k - first > _MANY:
            return 0
        a, b = ids[k, 0], ids[k, 1]
        for i in range(first, k):
            if _may_overlap(x, a, b, ids[i, 0], ids[i, 1], reach):
                return 0
        before[k] = i = last[rows[k, TRIANGLE_B]]
        last[rows[k, TRIANGLE_B]] = k
        n_seen = 0
        while i >= 0:
            n_seen += 1
            if n_seen > _MANY or _may_overlap(x, a, b, ids[i, 0], ids[i, 1], reach):
                return 0
            i = before[i]
    return 1


@scalar
def _place_after(x, i, j):
    """Whether place i comes after place j of the same easting."""
    if x[i, 1] != x[j, 1]:
        return x[i, 1] > x[j, 1]
    return x[i, 2] > x[j, 2]


@scalar
def _insert(x, order, low, high):
    """Sort a short part of an order by northing and elevation."""
    for k in range(low + 1, high):
        i = order[k]
        j = k - 1
        while j >= low and _place_after(x, order[j], i):
            order[j + 1] = order[j]
            j -= 1
        order[j + 1] = i


@scalar
def _sort_by(x, axis, order, low, high):
    """Sort a long part of an order by one coordinate."""
    part = order[low:high].copy()
    values = np.empty(high - low)
    for k in range(high - low):
        values[k] = x[part[k], axis]
    places = np.argsort(values)
    for k in range(high - low):
        order[low + k] = part[places[k]]


@entry("d2 l1 -> .")
def break_ties(x, order):
    """Order places by northing, then elevation, where an order by easting has equal ones."""
    n = order.shape[0]
    low = 0
    while low < n:
        high = low + 1
        while high < n and x[order[high], 0] == x[order[low], 0]:
            high += 1
        if high - low <= _SHORT:
            _insert(x, order, low, high)
        else:
            _sort_by(x, 1, order, low, high)
            start = low
            while start < high:
                end = start + 1
                while end < high and x[order[end], 1] == x[order[start], 1]:
                    end += 1
                if end - start <= _SHORT:
                    _insert(x, order, start, end)
                else:
                    _sort_by(x, 2, order, start, end)
                start = end
        low = high


@entry("d2 l1 -> l1 l1")
def rank_places(x, order):
    """Rank of each place among the distinct ones, and the first row of each, from their order."""
    rank = np.empty(order.shape[0], dtype=np.int64)
    first = np.empty(order.shape[0], dtype=np.int64)
    n = 0
    for k in range(order.shape[0]):
        i = order[k]
        j = order[k - 1] if k > 0 else i
        if k == 0 or x[i, 0] != x[j, 0] or x[i, 1] != x[j, 1] or x[i, 2] != x[j, 2]:
            first[n] = i
            n += 1
        rank[i] = n - 1
    return rank, first[:n].copy()


@scalar
def _comes_after(segments, i, j):
    """Whether segment i has a higher upper point than j."""
    return max(segments[i, 0], segments[i, 1]) > max(segments[j, 0], segments[j, 1])


@scalar
def _by_upper_point(segments, order, low, high):
    """Sort a part of an order."""
    if high - low > _SHORT:
        upper = np.empty(high - low, dtype=np.int64)
        for k in range(low, high):
            upper[k - low] = max(segments[order[k], 0], segments[order[k], 1])
        part = order[low:high].copy()
        places = np.argsort(upper)
        for k in range(low, high):
            order[k] = part[places[k - low]]
        return
    for k in range(low + 1, high):
        row = order[k]
        j = k - 1
        while j >= low and _comes_after(segments, order[j], row):
            order[j + 1] = order[j]
            j -= 1
        order[j + 1] = row


@scalar
def _buckets(keys, rows, n):
    """Rows in the order of their keys below n; those of one key stay as they were."""
    start = np.zeros(n + 1, dtype=np.int64)
    for k in range(keys.shape[0]):
        start[keys[k] + 1] += 1
    for k in range(n):
        start[k + 1] += start[k]
    fill = start.copy()
    order = np.empty(rows.shape[0], dtype=np.int64)
    for k in range(rows.shape[0]):
        key = keys[rows[k]]
        order[fill[key]] = rows[k]
        fill[key] += 1
    return order, start


@entry("l2 l1 l l -> l2 l1")
def sort_segments(segments, pair, n_point, n_pair):
    """Each segment of each pair once, lower point first, by pair, then points; and its pair."""
    n = segments.shape[0]
    lower = np.empty(n, dtype=np.int64)
    for k in range(n):
        lower[k] = min(segments[k, 0], segments[k, 1])
    order, start = _buckets(lower, np.arange(n), n_point)
    for point in range(n_point):
        if start[point + 1] - start[point] > 1:
            _by_upper_point(segments, order, start[point], start[point + 1])
    order, _ = _buckets(pair, order, n_pair)
    out, of = np.empty((n, 2), dtype=np.int64), np.empty(n, dtype=np.int64)
    m = 0
    for k in range(n):
        i = order[k]
        low, high = lower[i], max(segments[i, 0], segments[i, 1])
        if m > 0 and of[m - 1] == pair[i] and out[m - 1, 0] == low and out[m - 1, 1] == high:
            continue
        out[m, 0], out[m, 1], of[m] = low, high, pair[i]
        m += 1
    return out[:m].copy(), of[:m].copy()
