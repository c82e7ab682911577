"""Distances in the map from a point, along a triangulated horizon that faults cut.

Where the straight line is free the distance is Euclidean, up to rounding. Behind the tip of a fault
it is that of the way around the tip. Distances spread from triangle to triangle: from two corners
with known distances follows the image of the point in their plane, and from it the distance of the
third corner (Novotni & Klein 2002, WSCG). They are repeated until none becomes shorter.
"""

from __future__ import annotations

import numpy as np

SETTLED = 1e-10  # of the reach: gains below this end the spreading


def map_distances(
    x: np.ndarray, triangles: np.ndarray, start: int, source: np.ndarray, reach: float
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the vertices nearer than `reach` to a point of the mesh, and their distances.

    Parameters
    ----------
    x : ndarray of float64, shape (n_vertex, 3) or (n_vertex, 2)
        Only easting and northing count [m].
    triangles : ndarray of int64, shape (n, 3)
        Rows of `x`.
    start : int
        Row of the triangle that holds the point.
    source : ndarray of float64, shape (2,)
        Easting and northing of the point [m].
    reach : float
        [m]

    Returns
    -------
    (ndarray of int64, ndarray of float64)
        Vertices in increasing order, and distances [m].

    Examples
    --------
    >>> x = np.array([[0.0, 0], [4, 0], [0, 3], [4, 3]])
    >>> square = np.array([[0, 1, 2], [1, 3, 2]])
    >>> vertices, far = map_distances(x, square, 0, np.zeros(2), 10.0)
    >>> vertices.tolist(), far.round(9).tolist()
    ([0, 1, 2, 3], [0.0, 4.0, 3.0, 5.0])
    """
    p = x[:, :2] - source
    near = np.hypot(*p.T) < reach
    rows = np.flatnonzero(near[triangles].any(axis=1))
    if not (rows == start).any():  # a triangle wider than the reach
        rows = np.append(rows, start)
    used, faces = np.unique(triangles[rows], return_inverse=True)
    faces = faces.reshape(-1, 3)
    p = p[used]

    far = np.full(len(used), np.inf)
    seeds = np.searchsorted(used, triangles[start])
    far[seeds] = np.hypot(*p[seeds].T)
    order = np.argsort(faces.ravel(), kind="stable")
    first = np.searchsorted(faces.ravel()[order], np.arange(len(used) + 1))
    changed = np.unique(seeds)
    while len(changed):
        around = np.concatenate([order[first[v] : first[v + 1]] for v in changed.tolist()]) // 3
        corner, found = _across(p, faces[np.unique(around)], far)
        best = far.copy()
        np.minimum.at(best, corner, found)
        changed = np.flatnonzero((best < far - SETTLED * reach) & (best < reach))
        far[changed] = best[changed]
    inside = np.flatnonzero(far < reach)
    return used[inside], far[inside]


def _across(p: np.ndarray, faces: np.ndarray, far: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners, and the distance of each through its triangle or along its edges."""
    corners, found = [], []
    for k in range(3):
        c, a, b = (faces[:, (k + j) % 3] for j in range(3))
        along_a = far[a] + np.hypot(*(p[c] - p[a]).T)
        along_b = far[b] + np.hypot(*(p[c] - p[b]).T)
        through = _through(p[a], p[b], p[c], far[a], far[b])
        corners.append(c)
        found.append(np.minimum(np.minimum(along_a, along_b), through))
    return np.concatenate(corners), np.concatenate(found)


def _through(
    a: np.ndarray, b: np.ndarray, c: np.ndarray, far_a: np.ndarray, far_b: np.ndarray
) -> np.ndarray:
    """Distance of c by a straight line that crosses ab; infinite where there is no such line."""
    base = b - a
    length = np.hypot(*base.T)
    with np.errstate(invalid="ignore", divide="ignore"):
        along = base / length[:, None]
        to_c = c - a
        cx = (to_c * along).sum(axis=1)
        cy = np.abs(along[:, 0] * to_c[:, 1] - along[:, 1] * to_c[:, 0])
        # the image of the point: where circles around a and b meet, on the side away from c
        sx = (far_a * far_a - far_b * far_b + length * length) / (2.0 * length)
        sy = np.sqrt(far_a * far_a - sx * sx)
        crossing = sx + (cx - sx) * sy / (cy + sy)
        straight = (crossing >= 0.0) & (crossing <= length) & (cy > 0.0)
        found = np.hypot(cx - sx, cy + sy)
    return np.where(straight & np.isfinite(found), found, np.inf)


__all__ = ["map_distances"]
