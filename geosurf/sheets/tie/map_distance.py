"""Distances in the map from a point, along a triangulated horizon that faults cut.

Where no wall of a fault crosses the straight line, the distance is Euclidean. Behind the tip of a
fault it is that of the way around the tip. There, distances spread from triangle to triangle: from
two corners with known distances follows the image of the point in their plane, and from it the
distance of the third corner (Novotni & Klein 2002, WSCG). This is repeated until no distance
becomes shorter.
"""

from __future__ import annotations

import numpy as np

SETTLED = 1e-10  # of the reach: gains below this end the spreading
SLIGHT = 1e-9  # [rad] and of lengths: a line that passes a wall so closely is taken as crossing it


def map_distances(
    x: np.ndarray,
    triangles: np.ndarray,
    walls: np.ndarray,
    start: int,
    source: np.ndarray,
    reach: float,
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the vertices nearer than `reach` to a point of the mesh, and their distances.

    Parameters
    ----------
    x : ndarray of float64, shape (n_vertex, 3) or (n_vertex, 2)
        Only easting and northing count [m].
    triangles : ndarray of int64, shape (n, 3)
        Rows of `x`.
    walls : ndarray of int64, shape (n_wall, 2)
        Edges along which a fault cuts the mesh, rows of `x`.
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
    >>> nothing = np.empty((0, 2), dtype=np.int64)
    >>> vertices, far = map_distances(x, square, nothing, 0, np.zeros(2), 10.0)
    >>> vertices.tolist(), far.round(9).tolist()
    ([0, 1, 2, 3], [0.0, 4.0, 3.0, 5.0])
    """
    # p (n_vertex, 2): from the point, so that it is the origin of all lines of sight
    p = x[:, :2] - source
    straight = np.hypot(*p.T)

    # no way along the sheet is shorter than the straight one: nothing else can be in reach
    near = straight < reach
    near[triangles[start]] = True
    used = np.flatnonzero(near)

    # hidden: vertices behind a wall; those of the start's own triangle never are
    hidden = _hidden(p[used], p[walls[near[walls].any(axis=1)]])
    hidden &= ~np.isin(used, triangles[start])
    far = np.full(len(x), np.inf)
    far[used[~hidden]] = straight[used[~hidden]]
    if hidden.any():
        # only triangles with a hidden corner can shorten anything: spread in these alone
        behind = np.zeros(len(x), dtype=bool)
        behind[used[hidden]] = True
        _spread(p, triangles[behind[triangles].any(axis=1)], far, reach)
    inside = np.flatnonzero(far < reach)
    return inside, far[inside]


def _hidden(p: np.ndarray, walls: np.ndarray) -> np.ndarray:
    """Whether a wall (n, 2, 2) lies between the origin and points (n, 2), or touches the line.

    Only points in the angle of a wall are compared with it.
    """
    hidden = np.zeros(len(p), dtype=bool)
    if not len(walls):
        return hidden

    # points by angle: each wall is compared only with those between the angles of its ends
    angle = np.arctan2(p[:, 1], p[:, 0])
    order = np.argsort(angle, kind="stable")
    sorted_angle = angle[order]
    ends = np.arctan2(walls[:, :, 1], walls[:, :, 0])
    low, high = ends.min(axis=1) - SLIGHT, ends.max(axis=1) + SLIGHT

    # a wall that crosses due west, where angles jump, is looked at in two parts
    around = high - low > np.pi  # the angle goes across west
    pairs = [
        (np.flatnonzero(~around), low[~around], high[~around]),
        (np.flatnonzero(around), np.full(around.sum(), -np.inf), low[around] + 2 * SLIGHT),
        (np.flatnonzero(around), high[around] - 2 * SLIGHT, np.full(around.sum(), np.inf)),
    ]
    for which, left, right in pairs:
        first = np.searchsorted(sorted_angle, left, "left")
        count = np.searchsorted(sorted_angle, right, "right") - first

        # all pairs (wall, point in its angle), one row each
        wall = np.repeat(which, count)
        point = order[np.arange(len(wall)) + np.repeat(first - np.cumsum(count) + count, count)]

        # beyond: on the other side of the wall's line than the origin, or within rounding of it
        a, b, v = walls[wall, 0], walls[wall, 1], p[point]
        along, size = b - a, np.hypot(*(b - a).T)
        of_point = along[:, 0] * (v - a)[:, 1] - along[:, 1] * (v - a)[:, 0]
        of_origin = along[:, 1] * a[:, 0] - along[:, 0] * a[:, 1]
        beyond = of_point * np.sign(of_origin) <= SLIGHT * size * (size + np.hypot(*v.T))
        hidden[point[beyond]] = True
    return hidden


def _spread(p: np.ndarray, faces: np.ndarray, far: np.ndarray, reach: float) -> None:
    """Shorten distances `far` of the corners of faces until no way through a face is shorter."""
    # corner: vertices at all corners, sorted; order // 3: the triangles that have each
    flat = faces.ravel()
    order = np.argsort(flat, kind="stable")
    corner = flat[order]

    # the front: vertices whose distance is known or has become shorter
    changed = np.unique(flat)
    changed = changed[np.isfinite(far[changed])]
    best = far.copy()
    while len(changed):
        # triangles around the front, and what they give for each of their corners
        first, last = (np.searchsorted(corner, changed, side) for side in ("left", "right"))
        count = last - first
        at = np.arange(count.sum()) + np.repeat(first - np.cumsum(count) + count, count)
        corners, found = _across(p, faces[np.unique(order[at] // 3)], far)
        np.minimum.at(best, corners, found)
        touched = np.unique(corners)

        # gains below the last digits end it: distances fall and are bounded, so that it ends
        gained = best[touched] < np.minimum(far[touched] - SETTLED * reach, reach)
        changed = touched[gained]
        far[changed] = best[changed]
        best[touched] = far[touched]


def _across(p: np.ndarray, faces: np.ndarray, far: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners, and the distance of each through its triangle or along its edges."""
    corners, found = [], []
    for k in range(3):
        # each corner from the other two: along an edge, or straight through the triangle
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

    # coordinates along ab and away from it; triangles without area give NaN, which counts as
    # no way
    with np.errstate(invalid="ignore", divide="ignore"):
        along = base / length[:, None]
        to_c = c - a
        cx = (to_c * along).sum(axis=1)
        cy = np.abs(along[:, 0] * to_c[:, 1] - along[:, 1] * to_c[:, 0])
        # the image of the point: where circles around a and b meet, on the side away from c
        sx = (far_a * far_a - far_b * far_b + length * length) / (2.0 * length)
        sy = np.sqrt(far_a * far_a - sx * sx)

        # the straight line from the image to c crosses ab here; outside of it, the edges are
        # shorter
        crossing = sx + (cx - sx) * sy / (cy + sy)
        straight = (crossing >= 0.0) & (crossing <= length) & (cy > 0.0)
        found = np.hypot(cx - sx, cy + sy)
    return np.where(straight & np.isfinite(found), found, np.inf)


__all__ = ["map_distances"]
