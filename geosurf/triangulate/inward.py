"""Polygons with fewer corners and a stated distance inside: they only shrink.

An ear is a corner that points outward, with its two neighbours; if no other corner lies in that
triangle, cutting it off leaves a polygon inside of the former one. Smallest ears go first
(Visvalingam & Whyatt 1993, who also cut corners that point inward).
"""

from __future__ import annotations

import heapq

import numpy as np

from geosurf.kernels.exact.predicates import frame_of, orient2d_rows


def with_fewer_corners(ring: np.ndarray, each: float, total: float) -> np.ndarray:
    """
    Return a polygon inside another one, with some of its corners.

    Parameters
    ----------
    ring : ndarray of int64, shape (n, 2)
        Whole numbers, counter-clockwise; it does not meet itself.
    each, total : float
        The largest area of an ear, and of all ears, that may be cut off.

    Returns
    -------
    ndarray of int64, shape (m, 2)

    Examples
    --------
    >>> stairs = np.array([[0, 0], [9, 0], [9, 8], [2, 8], [2, 7], [1, 7], [1, 6], [0, 6]])
    >>> with_fewer_corners(stairs, each=0.5, total=2.0).tolist()
    [[0, 0], [9, 0], [9, 8], [2, 8], [2, 7], [1, 6], [0, 6]]
    """
    n = len(ring)
    columns = np.ascontiguousarray(ring.T)

    # a linked ring: before and after of each corner that is still alive
    before, after = (np.arange(n) - 1) % n, (np.arange(n) + 1) % n
    alive, x, y = np.ones(n, dtype=bool), ring[:, 0], ring[:, 1]
    left, budget = n, 2.0 * total

    def doubled(k: int) -> int:
        """Twice the area of the ear at a corner; below 0 where it points inward."""
        i, j = before[k], after[k]
        return int((x[k] - x[i]) * (y[j] - y[i]) - (y[k] - y[i]) * (x[j] - x[i]))

    heap = [(ear, k) for k in range(n) if 0 <= (ear := doubled(k)) <= 2.0 * each]
    heapq.heapify(heap)
    while heap and left > 3:
        ear, k = heapq.heappop(heap)

        # entries of the heap go stale when a neighbour is cut: the current ear has another entry
        if not alive[k] or ear != doubled(k) or ear > budget:
            continue
        i, j = int(before[k]), int(after[k])
        if ear > 0 and _holds_any(columns, alive, (i, k, j)):
            continue

        # the two neighbours get new ears, which may be cut in turn
        alive[k], after[i], before[j] = False, j, i
        left, budget = left - 1, budget - ear
        for one in (i, j):
            if 0 <= (ear := doubled(one)) <= 2.0 * each:
                heapq.heappush(heap, (ear, one))
    return ring[alive]


def _holds_any(ring: np.ndarray, alive: np.ndarray, ear: tuple[int, int, int]) -> bool:
    """Whether any other corner of a ring (2, n) lies in a closed triangle, counter-clockwise."""
    corners = ring[:, ear]
    (west, south), (east, north) = corners.min(axis=1), corners.max(axis=1)

    # one coordinate after the other: pairs in rows take five times as long
    x, y = ring
    near = (x >= west) & (x <= east) & (y >= south) & (y <= north) & alive
    near[list(ear)] = False
    others = np.flatnonzero(near)
    if not len(others):
        return False
    inside = np.ones(len(others), dtype=bool)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        # whole numbers of cells: exact without further care
        (i, j), (u, v) = corners[:, a], corners[:, b] - corners[:, a]
        inside &= u * (y[others] - j) - v * (x[others] - i) >= 0
    return bool(inside.any())


def moved_inward(outline: np.ndarray, inward: np.ndarray) -> np.ndarray:
    """Corners (n, 2) of an area whose sides have moved inward by some lengths (n,) [m]."""
    # corner: where the two moved sides meet, unless they are parallel
    sides = np.roll(outline, -1, axis=0) - outline
    sides /= np.hypot(*sides.T)[:, None]
    normals = np.column_stack([-sides[:, 1], sides[:, 0]])
    corners = []
    for corner, n1, n2, d1, d2 in zip(
        outline, np.roll(normals, 1, axis=0), normals, np.roll(inward, 1), inward, strict=True
    ):
        if abs(n1[0] * n2[1] - n1[1] * n2[0]) > 1e-3:
            corners.append(corner + np.linalg.solve(np.stack([n1, n2]), [d1, d2]))
        else:  # the sides run on into each other
            corners.append(corner + max(d1, d2) * n2)
    return np.array(corners)


def lies_inside(outline: np.ndarray, rim: np.ndarray) -> bool:
    """
    Return whether an area is inside of a horizon, and its outline meets no rim; exact.

    Parameters
    ----------
    outline : ndarray of float64, shape (n, 2)
        Counter-clockwise.
    rim : ndarray of float64, shape (m, 2, 2)
        Segments with the horizon on their left.

    Examples
    --------
    >>> square = np.array([[0.0, 0], [4, 0], [4, 4], [0, 4]])
    >>> rim = np.stack([square, np.roll(square, -1, axis=0)], axis=1)
    >>> lies_inside(0.5 * square + 1, rim), lies_inside(square, rim), lies_inside(square + 9, rim)
    (True, False, False)
    """
    m, n = len(rim), len(outline)
    points = np.concatenate([rim.reshape(-1, 2), outline])
    here, there = 2 * m + np.arange(n), 2 * m + (np.arange(n) + 1) % n
    low, high = rim.min(axis=1), rim.max(axis=1)

    # pairs of a rim segment (a, b) and a side (p, q) whose boxes meet
    pairs = []
    for p, q in zip(here, there, strict=True):
        near = (high >= np.minimum(points[p], points[q])).all(axis=1)
        near &= (low <= np.maximum(points[p], points[q])).all(axis=1)
        of = np.flatnonzero(near)
        pairs.append(np.stack([2 * of, 2 * of + 1, 0 * of + p, 0 * of + q], axis=1))
    a, b, p, q = np.concatenate(pairs).T

    # two segments meet unless one lies strictly on one side of the other; touching counts as
    # meeting
    apart = _turns(points, p, q, a) * _turns(points, p, q, b) > 0
    apart |= _turns(points, a, b, p) * _turns(points, a, b, q) > 0
    if not apart.all():
        return False

    # the rim around one corner: upward on its right, downward on its left
    across = np.flatnonzero((low[:, 1] <= outline[0, 1]) & (outline[0, 1] < high[:, 1]))
    a, b = 2 * across, 2 * across + 1
    upward = points[a, 1] < points[b, 1]
    on_left = _turns(points, np.where(upward, a, b), np.where(upward, b, a), 0 * a + here[0]) > 0
    return int(np.where(upward, 1, -1)[on_left].sum()) >= 1


def _turns(points: np.ndarray, p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
    """On which side of the lines from p to q the points r lie, exactly: +1 is left."""
    x = np.zeros((len(points), 3))
    x[:, :2] = points
    m, w = frame_of(x)
    out = np.empty(len(p), dtype=np.int64)
    orient2d_rows(x, np.stack([p, q, r], axis=1).astype(np.int64), m, w, out)
    return out
