"""A canonical order of points and segments, independent of the order in which they arrive.

Both are distributed into sorted buckets, as many as there are points. Where points are spread, a
bucket holds a few, which are sorted by insertion; crowded buckets are sorted as a whole. No
complete column of keys is ever sorted. Ranks and pair numbers have 32 bits, so that tables stay in
the nearer cache; 2**31 points would take fifty gigabytes.

Notation
    order     points in sequence; `start` of each bucket in it
    lower     the first of the two points of a segment; upper: the other one
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar

_SHORT = 32  # entries of a bucket that are sorted by insertion
_LEAST = 1e-290  # smallest divisor


# ---- points ------------------------------------------------------------------------------


@scalar
def _comes_after(x, i, j):
    """Whether point i comes after point j of equal easting: by northing, then elevation."""
    if x[i, 1] != x[j, 1]:
        return x[i, 1] > x[j, 1]
    return x[i, 2] > x[j, 2]


@scalar
def _insert(x, easting, order, low, high):
    """Insertion sort of a short range of an order; eastings are moved along for locality."""
    for k in range(low + 1, high):
        i, east = order[k], easting[k]
        j = k - 1
        while j >= low and (
            easting[j] > east or (easting[j] == east and _comes_after(x, order[j], i))
        ):
            order[j + 1], easting[j + 1] = order[j], easting[j]
            j -= 1
        order[j + 1], easting[j + 1] = i, east


@scalar
def _insert_alike(x, order, low, high):
    """Insertion sort of a short range of points with equal easting."""
    for k in range(low + 1, high):
        i = order[k]
        j = k - 1
        while j >= low and _comes_after(x, order[j], i):
            order[j + 1] = order[j]
            j -= 1
        order[j + 1] = i


@scalar
def _sort_by(x, axis, order, low, high):
    """Sort a range of an order by one coordinate."""
    part = order[low:high].copy()

    # Sort a copy of the coordinates, then permute the order.
    values = np.empty(high - low)
    for k in range(high - low):
        values[k] = x[part[k], axis]
    places = np.argsort(values)
    for k in range(high - low):
        order[low + k] = part[places[k]]


@scalar
def _end_of_ties(x, axis, order, low, high):
    """End of the entries from `low` on with an equal coordinate."""
    end = low + 1
    while end < high and x[order[end], axis] == x[order[low], axis]:
        end += 1
    return end


@scalar
def _sort_crowd(x, order, low, high):
    """Sort a range of any length: coordinate by coordinate, until ties are short."""
    _sort_by(x, 0, order, low, high)
    while low < high:
        # Only ties need the next coordinate.
        end = _end_of_ties(x, 0, order, low, high)

        # Few ties in easting: insertion. Many: sort by northing, then elevation.
        if end - low <= _SHORT:
            _insert_alike(x, order, low, end)
            low = end
            continue
        _sort_by(x, 1, order, low, end)
        while low < end:
            stop = _end_of_ties(x, 1, order, low, end)
            if stop - low <= _SHORT:
                _insert_alike(x, order, low, stop)
            else:
                _sort_by(x, 2, order, low, stop)
            low = stop


@scalar
def _points_in_use(x, segments):
    """Points of the segments, increasing, and their lowest and highest easting."""
    # Each used point once, in increasing order.
    used = np.zeros(x.shape[0], dtype=np.bool_)
    for k in range(segments.shape[0]):
        used[segments[k, 0]] = True
        used[segments[k, 1]] = True
    points = np.empty(min(x.shape[0], 2 * segments.shape[0]), dtype=np.int32)
    low, high = np.inf, -np.inf
    n = 0
    for i in range(x.shape[0]):
        if used[i]:
            low, high = min(low, x[i, 0]), max(high, x[i, 0])
            points[n] = i
            n += 1
    return points[:n], low, high


@scalar
def _ordered_points(x, segments):
    """Points of the segments, ordered by coordinates."""
    points, low, high = _points_in_use(x, segments)
    n = points.shape[0]
    pace = n / (high - low) if high - low > _LEAST else 0.0  # else one bucket

    # Counting sort into buckets by easting.
    start = np.zeros(n + 1, dtype=np.int32)
    for k in range(n):
        # The highest easting would get a bucket of its own: it joins the last one.
        start[min(int((x[points[k], 0] - low) * pace), n - 1) + 1] += 1
    for bucket in range(n):
        start[bucket + 1] += start[bucket]
    order, easting = np.empty(n, dtype=np.int32), np.empty(n)
    for k in range(n):  # each start moves to that of the next bucket
        east = x[points[k], 0]
        # The same expression as above, so that a point lands in the bucket that counted it.
        bucket = min(int((east - low) * pace), n - 1)
        at = start[bucket]
        order[at], easting[at] = points[k], east
        start[bucket] = at + 1

    # Then sort each bucket.
    begin = 0
    for bucket in range(n):
        end = start[bucket]
        if end - begin > _SHORT:
            _sort_crowd(x, order, begin, end)
        elif end - begin > 1:
            _insert(x, easting, order, begin, end)
        begin = end
    return order


@scalar
def _ranked_places(x, order):
    """Rank of each point among the distinct positions of an order, and these positions."""
    rank = np.empty(x.shape[0], dtype=np.int32)
    places = np.empty((order.shape[0], 3))
    # Distinct positions so far.
    n = 0
    for k in range(order.shape[0]):
        i = order[k]

        # Equal positions share a rank.
        if (
            n == 0
            or x[i, 0] != places[n - 1, 0]
            or x[i, 1] != places[n - 1, 1]
            or x[i, 2] != places[n - 1, 2]
        ):
            places[n, 0], places[n, 1], places[n, 2] = x[i, 0], x[i, 1], x[i, 2]
            n += 1
        rank[i] = n - 1
    return rank, places[:n]


# ---- segments ----------------------------------------------------------------------------


@scalar
def _sort_bucket(upper, pair, low, high):
    """Sort the segments of one lower point by their upper points."""
    if high - low > _SHORT:
        # Long buckets: sort indices. Short ones: insertion.
        # Equal segments of different pairs may come in any order: they are separated by pair next.
        places = np.argsort(upper[low:high])
        uppers, pairs = upper[low:high].copy(), pair[low:high].copy()
        for k in range(high - low):
            upper[low + k], pair[low + k] = uppers[places[k]], pairs[places[k]]
        return
    for k in range(low + 1, high):
        p, of = upper[k], pair[k]
        j = k - 1
        while j >= low and upper[j] > p:
            upper[j + 1], pair[j + 1] = upper[j], pair[j]
            j -= 1
        upper[j + 1], pair[j + 1] = p, of


@scalar
def _by_points(segments, rank, pair, n_rank):
    """Segments by their lower, then upper points: first of each lower one, uppers, pairs."""
    n = segments.shape[0]
    # Entry point + 1 counts the segments with this lower point.
    start = np.zeros(n_rank + 1, dtype=np.int32)
    for k in range(n):
        start[min(rank[segments[k, 0]], rank[segments[k, 1]]) + 1] += 1
    for point in range(n_rank):
        start[point + 1] += start[point]

    # Distribute the segments to their lower points.
    upper, of = np.empty(n, dtype=np.int32), np.empty(n, dtype=np.int32)
    for k in range(n):  # each start moves to that of the next
        p, q = rank[segments[k, 0]], rank[segments[k, 1]]
        lower = min(p, q)
        upper[start[lower]], of[start[lower]] = max(p, q), pair[k]
        start[lower] += 1
    # Segments of one lower point are few in most models.
    begin = 0
    for point in range(n_rank):
        end = start[point]
        if end - begin > 1:
            _sort_bucket(upper, of, begin, end)
        begin = end
    return start, upper, of


@scalar
def _by_pairs(start, upper, pair, n_pair):
    """Segments that are sorted by points, by pairs, each once; and the first one of each pair."""
    n = upper.shape[0]
    first = np.zeros(n_pair + 1, dtype=np.int64)
    for k in range(n):
        # Duplicates are counted too; the gaps that they leave are closed at the end.
        first[pair[k] + 1] += 1
    for i in range(n_pair):
        first[i + 1] += first[i]

    # Distribute to pairs in sorted order; repeated segments are adjacent.
    out = np.empty((n, 2), dtype=np.int64)
    fill = first[:-1].copy()
    k = 0
    for lower in range(start.shape[0] - 1):
        while k < start[lower]:
            i = pair[k]
            at = fill[i]
            # The previous segment of this pair is the same one: it came twice.
            if not (at > first[i] and out[at - 1, 0] == lower and out[at - 1, 1] == upper[k]):
                out[at, 0], out[at, 1] = lower, upper[k]
                fill[i] = at + 1
            k += 1
    m = 0
    for i in range(n_pair):  # close up where a segment came twice
        begin = first[i]
        first[i] = m
        for k in range(begin, fill[i]):
            out[m, 0], out[m, 1] = out[k, 0], out[k, 1]
            m += 1
    first[n_pair] = m
    return out[:m], first


@entry("l2 l1 l l -> l2 l1")
def sort_segments(segments, pair, n_point, n_pair):
    """Each segment of each pair once, lower point first, by pair, then points; first of each pair.

    `first` has one entry more than there are pairs.
    """
    start, upper, of = _by_points(segments, np.arange(n_point), pair, n_point)
    return _by_pairs(start, upper, of, n_pair)


@entry("d2 l2 l1 l -> d2 l2 l1")
def sort_places_and_segments(x, segments, pair, n_pair):
    """Distinct positions of the segments' points, in order; segments between them, sorted as by
    `sort_segments`; and the first one of each pair.
    """
    # Rank the positions, then sort segments by rank.
    rank, places = _ranked_places(x, _ordered_points(x, segments))
    start, upper, of = _by_points(segments, rank, pair, places.shape[0])
    out, first = _by_pairs(start, upper, of, n_pair)
    return places, out, first
