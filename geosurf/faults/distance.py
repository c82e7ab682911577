"""The closest approach of two surfaces, or of an open end to a surface.

Nothing is decided by these distances: messages report them. Floats in
coordinates around the middle of both; the result is right to a part in 10^9 of their size.
Blocks of triangles are compared by their boxes first, nearest first, until no block can be nearer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.kernels.meshes.mesh import edges

_BLOCK = 32


@dataclass(frozen=True)
class Approach:
    """The closest approach: its distance [m], and the place on either surface, (3,)."""

    distance: float
    at: np.ndarray
    there: np.ndarray


def open_edges(t: np.ndarray, n_vertex: int) -> np.ndarray:
    """Vertices (n, 2) of the edges of triangles that have one triangle only."""
    ring, _ = edges(t, n_vertex)
    half = np.flatnonzero(ring == np.arange(len(ring)))
    return np.stack([t[half // 3, half % 3], t[half // 3, (half + 1) % 3]], axis=1)


def closest_approach(x: np.ndarray, one: np.ndarray, two: np.ndarray) -> Approach:
    """Find where two surfaces over the same vertices are closest.

    Parameters
    ----------
    x : ndarray of float64, shape (n_vertex, 3)
    one, two : ndarray of int64, shape (n, 3)
        Triangles. Surfaces that cross are 0 apart, up to rounding.

    Returns
    -------
    Approach

    Examples
    --------
    >>> x = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, 3], [1, 1, 9], [2, 1, 9.0]])
    >>> closest_approach(x, np.array([[3, 4, 5]]), np.array([[0, 1, 2]])).distance
    3.0
    """
    # two triangles are closest between an edge of one and the other triangle, or an edge passes
    # through it: edges of each against triangles of the other cover all cases
    sides = [np.unique(np.sort(_sides(t), axis=1), axis=0) for t in (one, two)]
    there = nearest_of(x[sides[0]], x[two])
    back = nearest_of(x[sides[1]], x[one])
    if back.distance < there.distance:
        return Approach(back.distance, back.there, back.at)
    return there


def _sides(t: np.ndarray) -> np.ndarray:
    return np.stack([t, np.roll(t, -1, axis=1)], axis=2).reshape(-1, 2)


def nearest_of(segments: np.ndarray, triangles: np.ndarray, limit: float = np.inf) -> Approach:
    """Find where segments (n, 2, 3) come closest to triangles (m, 3, 3); `at` is on the segments.

    Of several places as close as each other, the one with the least coordinates. What is farther
    than `limit` is not measured: then the distance is infinite.
    """
    # around the middle: UTM northings of 6 million m would cost seven digits
    middle = 0.5 * (triangles.min(axis=(0, 1)) + triangles.max(axis=(0, 1)))
    s, t = segments - middle, triangles - middle
    if limit < np.inf:
        t = t[_gaps(t.min(axis=1), t.max(axis=1), s.reshape(-1, 3)) <= limit]
        if len(t):
            s = s[_gaps(s.min(axis=1), s.max(axis=1), t.reshape(-1, 3)) <= limit]
        if len(t) == 0 or len(s) == 0:
            return Approach(np.inf, middle, middle)

    # along a space-filling curve, so that blocks of 32 in a row are compact
    s, t = s[_along_curve(s)], t[_along_curve(t)]
    s_blocks, t_blocks = (np.arange(0, len(v), _BLOCK) for v in (s, t))
    low_s, high_s = _boxes(s, s_blocks)
    low_t, high_t = _boxes(t, t_blocks)

    # lower bound of the distance of two blocks: that of their boxes, (n_s_block, n_t_block)
    gap = np.maximum(low_s[:, None] - high_t, low_t - high_s[:, None])
    bound = np.sqrt((np.maximum(gap, 0.0) ** 2).sum(axis=2))
    best: tuple[float, tuple[float, ...], tuple[float, ...]] = (
        np.inf,
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0),
    )

    # branch and bound, nearest boxes first: stop as soon as no box can be nearer
    for flat in np.argsort(bound, axis=None, kind="stable"):
        i, j = np.unravel_index(flat, bound.shape)
        if bound[i, j] > best[0]:
            break

        # tuples compare by distance, then by place: ties do not depend on the order of blocks
        here = s[s_blocks[i] : s_blocks[i] + _BLOCK], t[t_blocks[j] : t_blocks[j] + _BLOCK]
        best = min(best, _closest_pair(*here))
    return Approach(best[0], np.array(best[1]) + middle, np.array(best[2]) + middle)


def _gaps(low: np.ndarray, high: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Distance of each of some boxes to the bounds of points (n, 3)."""
    gap = np.maximum(low - points.max(axis=0), points.min(axis=0) - high)
    gaps: np.ndarray = np.linalg.norm(np.maximum(gap, 0.0), axis=1)
    return gaps


def _boxes(shapes: np.ndarray, starts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    low, high = shapes.min(axis=1), shapes.max(axis=1)
    return np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)


def _along_curve(shapes: np.ndarray) -> np.ndarray:
    """Order that keeps near shapes together: bits of the three coordinates, interleaved."""
    centre = shapes.mean(axis=1)
    span = np.maximum(np.ptp(centre, axis=0).max(), np.finfo(float).tiny)

    # ten bits for each axis, interleaved: the Morton order
    cell = ((centre - centre.min(axis=0)) / span * 1023).astype(np.int64)
    key = np.zeros(len(shapes), dtype=np.int64)
    for bit in range(10):
        for axis in range(3):
            key |= ((cell[:, axis] >> bit) & 1) << (3 * bit + axis)
    return np.argsort(key, kind="stable")


def _closest_pair(
    s: np.ndarray, t: np.ndarray
) -> tuple[float, tuple[float, ...], tuple[float, ...]]:
    """(distance, point on a segment, point on a triangle) of all pairs of two blocks."""
    n, m = len(s), len(t)
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(n), np.arange(m), indexing="ij"))

    # the closest points are at an end of the segment, where it passes through the plane, or on it
    # and an edge of the triangle
    found = [_of_ends(p, t[j]) for p in (s[i, 0], s[i, 1], _on_planes(s[i], t[j]))]
    found += [_of_lines(s[i], t[j][:, [k, (k + 1) % 3]]) for k in range(3)]
    on_s, on_t = (np.concatenate([f[k] for f in found]) for k in range(2))
    distance = np.linalg.norm(on_s - on_t, axis=1)
    near = np.flatnonzero(distance == distance.min())
    row = near[np.lexsort(on_s[near].T[::-1])[0]]
    return float(distance[row]), tuple(on_s[row].tolist()), tuple(on_t[row].tolist())


def _on_planes(s: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Where segments come closest to the planes of triangles: in them, or at an end."""
    a, b, c = t.swapaxes(0, 1)
    start, end = s.swapaxes(0, 1)
    n = np.cross(b - a, c - a)
    one, two = (((place - a) * n).sum(axis=1) for place in (start, end))
    apart = one - two
    share = np.clip(np.where(apart == 0, 0.0, one / np.where(apart == 0, 1.0, apart)), 0.0, 1.0)
    return start + share[:, None] * (end - start)


def _of_ends(p: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points and their feet in the insides of triangles; corners where the foot is outside.

    Feet on edges are found by `_of_lines`.
    """
    a, b, c = t[:, 0], t[:, 1], t[:, 2]
    n = np.cross(b - a, c - a)
    size = np.maximum((n * n).sum(axis=1), np.finfo(float).tiny)
    foot = p - (((p - a) * n).sum(axis=1) / size)[:, None] * n
    inside = (n * n).sum(axis=1) > 0  # rounding may leave a triangle no area
    for u, v in ((a, b), (b, c), (c, a)):
        inside &= (np.cross(v - u, foot - u) * n).sum(axis=1) >= 0
    return p, np.where(inside[:, None], foot, a)


def _of_lines(s: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Closest points of segments s and r, both (n, 2, 3) (Ericson, Real-Time Collision, 5.1.9)."""
    (p, to), (o, onward) = s.swapaxes(0, 1), r.swapaxes(0, 1)
    d, e, w = to - p, onward - o, p - o
    a, b, c = (d * d).sum(axis=1), (d * e).sum(axis=1), (e * e).sum(axis=1)
    f, g = (d * w).sum(axis=1), (e * w).sum(axis=1)
    tiny = np.finfo(float).tiny
    det = a * c - b * b
    k = np.clip(np.where(det > 1e-12 * a * c, (b * g - c * f) / np.maximum(det, tiny), 0.0), 0, 1)
    q = (b * k + g) / np.maximum(c, tiny)
    back = np.clip(q, 0.0, 1.0)
    k = np.where(q == back, k, np.clip((b * back - f) / np.maximum(a, tiny), 0.0, 1.0))
    return p + k[:, None] * d, o + back[:, None] * e
