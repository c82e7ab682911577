"""How far the nearest of many triangles is above or below each point.

Triangles and points are sorted into squares of the map. Squares of one column are next to each
other, so that the points in all squares of a column that a triangle touches are one run.

Notation
    corners       of the triangles, float64 (n_triangle, 9): x, y, z of each; none is vertical
    first, last   column and row of the first and the last square of each triangle, int64 (n, 2)
    order, begin  points square by square, and where those of each square begin
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar

_ROUNDED = 1e-9  # share of a triangle, and of an elevation, by which rounding may be off


@scalar
def _double_area(ax, ay, bx, by, cx, cy):
    """Twice the area of a triangle in the map, positive if it is counter-clockwise."""
    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)


@entry("d2 d1 d2 d l2 l2 l l1 l1 -> d1")
def vertical_distances(points, start, corners, way, first, last, n, order, begin):
    """Distance (n_point,) from a start to the nearest triangle; infinite where there is none.

    `points` (n_point, 2) in the map, `start` their elevations; `way` is 1 upwards, -1 downwards;
    `n` squares to a side.
    """
    found = np.full(points.shape[0], np.inf)
    for t in range(corners.shape[0]):
        ax, ay, az = corners[t, 0], corners[t, 1], corners[t, 2]
        bx, by, bz = corners[t, 3], corners[t, 4], corners[t, 5]
        cx, cy, cz = corners[t, 6], corners[t, 7], corners[t, 8]
        whole = _double_area(ax, ay, bx, by, cx, cy)
        if whole == 0.0:
            continue
        for column in range(first[t, 0], last[t, 0] + 1):
            run = column * n
            for k in range(begin[run + first[t, 1]], begin[run + last[t, 1] + 1]):
                p = order[k]
                x, y = points[p, 0], points[p, 1]
                a = _double_area(x, y, bx, by, cx, cy) / whole
                b = _double_area(ax, ay, x, y, cx, cy) / whole
                c = _double_area(ax, ay, bx, by, x, y) / whole
                if not (a >= -_ROUNDED and b >= -_ROUNDED and c >= -_ROUNDED):
                    continue
                # a point on the rim of a triangle sees it at no distance, up to rounding
                ahead = way * (a * az + b * bz + c * cz - start[p])
                if ahead >= -_ROUNDED * (1.0 + abs(start[p])):
                    found[p] = min(found[p], max(ahead, 0.0))
    return found
