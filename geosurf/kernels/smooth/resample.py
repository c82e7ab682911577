"""Polylines with as few points as a chord error allows, from lifted points.

Points near enough to a chord are left out (Douglas & Peucker 1973). Then each chord is measured
against the curve itself: at a quarter, a half and three quarters, by Newton in the plane across the
chord. A chord that is too far away gets a point in its middle. The bound of a chord is 4/3 of the
largest of the three distances: on an arc of constant curvature the middle one is the largest and
the others three quarters of it; an inflection shows at the quarters.

Letters as in `lift`.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.smooth.lift import F_POINT, LIFTED, N_WORK, SurfacePair, newton_in_plane

SAFETY = 4.0 / 3.0
_DEEPEST = 24


@scalar
def squared_distance_to_chord(p, q, x, y, z):
    """Squared distance of a point from the segment p, q."""
    dx, dy, dz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    ex, ey, ez = x - p[0], y - p[1], z - p[2]
    size = dx * dx + dy * dy + dz * dz

    # Clamp the projection to the segment.
    t = 0.0
    if size > 0.0:
        t = min(max((dx * ex + dy * ey + dz * ez) / size, 0.0), 1.0)
    ex, ey, ez = ex - t * dx, ey - t * dy, ez - t * dz
    return ex * ex + ey * ey + ez * ez


@scalar
def measure_chord(surfaces, tri, one, two, target, wm, f):
    """Largest distance of the curve from a chord at three places, or -1; wm gets the middle.

    one, two: rows (7,) of point and parameters. wm (7,) is the point of the curve over the middle.
    The measurement stops at the first distance beyond the target.
    """
    dx, dy, dz = two[0] - one[0], two[1] - one[1], two[2] - one[2]
    # Both ends are one point: there is no direction to measure across.
    if dx == 0.0 and dy == 0.0 and dz == 0.0:
        return 0.0
    largest = 0.0
    aside = np.empty(4)
    for k in range(3):
        t = 0.5 if k == 0 else (0.25 if k == 1 else 0.75)

        # Parameters on the chord are the start of Newton.
        for col in range(4):
            aside[col] = one[3 + col] + t * (two[3 + col] - one[3 + col])
        x, y, z = one[0] + t * dx, one[1] + t * dy, one[2] + t * dz
        found = newton_in_plane(surfaces, tri, aside, x, y, z, dx, dy, dz, f)
        if found != LIFTED:
            return -1.0

        # The middle may become a new point.
        if k == 0:
            wm[:3] = f[F_POINT : F_POINT + 3]
            wm[3:] = aside
        x, y, z = f[F_POINT] - x, f[F_POINT + 1] - y, f[F_POINT + 2] - z
        largest = max(largest, x * x + y * y + z * z)
        if largest > target * target:
            break
    return math.sqrt(largest)


@scalar
def append_row(rows, n, at, error, tri):
    """Append point and parameters `at` (7,), chord error and triangle: rows, longer if full."""
    if n == rows.shape[0]:
        more = np.empty((2 * n + 16, 9))
        more[:n] = rows
        rows = more
    rows[n, :7] = at
    rows[n, 7] = error
    rows[n, 8] = tri
    return rows, n + 1


@scalar
def _refine(surfaces, tri, one, two, target, out, n, stack, f):
    """Append the points after `one` up to `two`; column 7: chord error, -1 unknown; 8: triangle.

    Appends nothing if the first chord cannot be measured.
    """
    first = n
    here = one.copy()
    stack[0] = two
    top = 1
    wm = np.empty(7)
    while top > 0:
        # Split the chord at its middle until it is within the target.
        goal = stack[top - 1]
        error = measure_chord(surfaces, tri, here, goal, target, wm, f)
        # The depth bounds the stack; what is left then is reported with its error.
        if error > target and top < _DEEPEST:
            stack[top] = wm
            top += 1
            continue
        # The caller halves the run, or keeps the lifted point.
        if error < 0.0 and n == first and top == 1:
            break
        out, n = append_row(out, n, goal, SAFETY * error if error >= 0.0 else -1.0, tri)
        here[:] = goal
        top -= 1
    return out, n


@entry("d2 d2 d2 d2 d2 d2 d3 d2 l2 l1 d1 -> d2 l1")
def resample_runs(xa, ya, za, xb, yb, zb, c, rows, runs, tri, target):
    """Polylines for runs (n_run, 2) of lifted rows (n, 7), the last row of a run included.

    Returns rows (n, 9) of point, parameters, chord error and triangle, run by run, and offsets.
    The first row of each run has chord error 0.
    """
    surfaces = SurfacePair(xa, ya, za, xb, yb, zb, c)
    out = np.empty((rows.shape[0] + 16, 9))
    offsets = np.zeros(runs.shape[0] + 1, dtype=np.int64)
    stack = np.empty((_DEEPEST + 1, 7))
    pending = np.empty(rows.shape[0] + 2, dtype=np.int64)
    f = np.empty(N_WORK)
    n = 0
    for r in range(runs.shape[0]):
        here = runs[r, 0]

        # First point of the run.
        out, n = append_row(out, n, rows[here], 0.0, tri[r])
        # Goals wait on a stack, the nearest on top.
        pending[0] = runs[r, 1]
        top = 1
        while top > 0:
            # The farthest point from the chord becomes an intermediate goal.
            goal = pending[top - 1]
            far, worst = -1, target[r] * target[r]
            for k in range(here + 1, goal):
                away = squared_distance_to_chord(
                    rows[here], rows[goal], rows[k, 0], rows[k, 1], rows[k, 2]
                )
                if away > worst:
                    far, worst = k, away
            if far >= 0:
                pending[top] = far
                top += 1
                continue

            # Refine the chord; if it cannot be measured, halve the run or keep the lifted point.
            before = n
            out, n = _refine(surfaces, tri[r], rows[here], rows[goal], target[r], out, n, stack, f)
            if n == before and goal > here + 1:
                pending[top] = (here + goal) // 2
                top += 1
                continue
            if n == before:
                out, n = append_row(out, n, rows[goal], -1.0, tri[r])
            here = goal
            top -= 1
        offsets[r + 1] = n
    return out, offsets
