"""Trace of a smooth curve from one of its points: predictor along the tangent, Newton corrector.

This is for curves that the triangles of a lattice do not show. A step along the tangent is
corrected in the plane across it, accepted if its chord is near enough to the curve (as in
`resample`), and halved otherwise. The trace ends at its start, or at a boundary, where it meets
the boundary line.

Letters as in `lift`; `neighbours` (n_triangle, 3): the triangle across each side: side 0 joins
corners 0 and 1 (t = 0), side 1 corners 1 and 2, side 2 corners 2 and 0 (s = 0); -1 at a boundary.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.smooth.lift import (
    F_POINT,
    F_TANGENT,
    HOLD_SUM,
    HOLD_UB,
    HOLD_VB,
    LIFTED,
    N_WORK,
    OUTSIDE,
    SurfacePair,
    newton_in_plane,
    newton_on_boundary,
    solve_tangents,
)
from geosurf.kernels.smooth.resample import (
    SAFETY,
    append_row,
    measure_chord,
    squared_distance_to_chord,
)

CLOSED, AT_RIM, LOST = 1, 2, 3
MAX_STEPS = 200_000
MIN_STEP = 1e-6  # of the first step


@scalar
def boundary_crossed(za, zb, w):
    """The boundary that the parameters crossed farthest, as the parameter to hold; 0 if none."""
    hold, worst = 0, 0.0
    for k in range(4):
        # Upper limit of each parameter.
        z = za if k < 2 else zb
        top = 1.0
        if z.shape[0] > 1:
            top = (z.shape[1] if k % 2 == 0 else z.shape[0]) - 1.0
        # For a triangle the sum of both parameters is tested below.
        excess = max(-w[k], w[k] - top if (k < 2 or z.shape[0] > 1) else 0.0)
        if excess > worst:
            hold, worst = k + 1, excess
    if zb.shape[0] == 1 and w[2] + w[3] - 1.0 > worst:
        hold = HOLD_SUM
    return hold


@scalar
def clamp_to_boundary(za, zb, hold, w):
    """Move parameters onto the boundary that is held."""
    if hold == HOLD_SUM:
        # Both parameters give up half of the excess.
        more = 0.5 * (w[2] + w[3] - 1.0)
        w[2] -= more
        w[3] -= more
        return
    k = hold - 1
    z = za if k < 2 else zb
    top = 1.0
    if z.shape[0] > 1:
        top = (z.shape[1] if k % 2 == 0 else z.shape[0]) - 1.0
    # The limit that was crossed is the nearer one.
    w[k] = 0.0 if w[k] < 0.5 * top else top


@scalar
def _across(c, neighbours, tri, hold, x, y, z, w):
    """Change to the triangle across the held side; its number, or -1 at a boundary."""
    side = 0 if hold == HOLD_VB else (1 if hold == HOLD_SUM else 2)
    other = neighbours[tri, side]
    if other < 0:
        return -1

    # Edges of the other triangle, and the point relative to its first corner.
    ux, uy, uz = (
        c[other, 1, 0] - c[other, 0, 0],
        c[other, 1, 1] - c[other, 0, 1],
        c[other, 1, 2] - c[other, 0, 2],
    )
    vx, vy, vz = (
        c[other, 2, 0] - c[other, 0, 0],
        c[other, 2, 1] - c[other, 0, 1],
        c[other, 2, 2] - c[other, 0, 2],
    )
    x, y, z = x - c[other, 0, 0], y - c[other, 0, 1], z - c[other, 0, 2]
    w[2], w[3] = solve_tangents(ux, uy, uz, vx, vy, vz, x, y, z)
    return other


@scalar
def _orient_tangent(direction, f):
    """Set the direction to the tangent, oriented along the walk."""
    # Newton returns a tangent of either sign.
    turn = (
        direction[0] * f[F_TANGENT]
        + direction[1] * f[F_TANGENT + 1]
        + direction[2] * f[F_TANGENT + 2]
    )
    sign = 1.0 if turn >= 0.0 else -1.0
    for k in range(3):
        direction[k] = sign * f[F_TANGENT + k]
    return abs(turn)


@scalar
def step_direction(here, direction, step, f):
    """+1 or -1, the sense of the tangent that Newton found; 0 where the step is rejected.

    The tangent may turn by 37 degrees, and the point has to move forward by two steps at most.
    """
    gone, along = 0.0, 0.0
    for k in range(3):
        gone += (f[F_POINT + k] - here[k]) * direction[k]
        along += f[F_TANGENT + k] * direction[k]
    # Another branch of the curve, a step back, or a jump.
    if abs(along) < 0.8 or gone < 0.0 or gone > 2.0 * step:
        return 0.0
    return 1.0 if along > 0.0 else -1.0


@entry("d2 d2 d2 d2 d2 d2 d3 l2 d1 l d d d -> d2 l")
def trace_curve(xa, ya, za, xb, yb, zb, c, neighbours, seed, tri, sense, step, target):
    """Rows (n, 9) as in `resample`, from a seed (7: point, parameters), and how the walk ended.

    `sense` is +1 or -1, `step` the first step [m], `target` the largest distance of a chord.
    """
    surfaces = SurfacePair(xa, ya, za, xb, yb, zb, c)
    out = np.empty((64, 9))
    f = np.empty(N_WORK)
    here, goal, middle = seed.copy(), np.empty(7), np.empty(7)
    direction = np.zeros(3)
    first_tri, shortest = tri, MIN_STEP * step

    # Start exactly on the curve.
    # Any status but LIFTED is not 0.
    if newton_in_plane(surfaces, tri, here[3:], here[0], here[1], here[2], 0.0, 0.0, 0.0, f):
        return out[:0].copy(), LOST
    for k in range(3):
        direction[k] = sense * f[F_TANGENT + k]
    out, n = append_row(out, 0, here, 0.0, tri)
    while n < MAX_STEPS and step > shortest:
        # Try to close: the start is ahead and within reach of a step.
        ax, ay, az = seed[0] - here[0], seed[1] - here[1], seed[2] - here[2]
        away = math.sqrt(ax * ax + ay * ay + az * az)
        ahead = ax * direction[0] + ay * direction[1] + az * direction[2]
        if n > 3 and away < 1.2 * step and ahead > 0.5 * away:
            # Parameters of different triangles cannot be compared.
            if tri == first_tri:
                error = measure_chord(surfaces, tri, here, seed, target, middle, f)
                if 0.0 <= error <= target:
                    out, n = append_row(out, n, seed, SAFETY * error, tri)
                    return out[:n].copy(), CLOSED
            step = min(step, 0.4 * away)

        # Predict along the tangent, correct by Newton.
        goal[3:] = here[3:]
        dx, dy, dz = direction
        x, y, z = here[0] + step * dx, here[1] + step * dy, here[2] + step * dz
        found = newton_in_plane(surfaces, tri, goal[3:], x, y, z, dx, dy, dz, f)
        hold = 0

        # Beyond a boundary: meet its line instead.
        if found == OUTSIDE:
            hold = boundary_crossed(za, zb, goal[3:])
            clamp_to_boundary(za, zb, hold, goal[3:])
            found = newton_on_boundary(surfaces, tri, goal[3:], hold, f)
        if found != LIFTED:
            step *= 0.5
            continue
        goal[:3] = f[F_POINT : F_POINT + 3]
        if step_direction(here, direction, step, f) == 0.0:
            step *= 0.5
            continue
        error = measure_chord(surfaces, tri, here, goal, target, middle, f)
        if error < 0.0 or error > target:
            step *= 0.5
            continue

        # Accepted: the tangent at the new point, and a longer step after a flat chord.
        newton_in_plane(surfaces, tri, goal[3:], goal[0], goal[1], goal[2], 0.0, 0.0, 0.0, f)
        _orient_tangent(direction, f)
        out, n = append_row(out, n, goal, SAFETY * error, tri)
        here[:] = goal
        # The chord error grows with the square of the step: 1.6 steps stay within the target.
        if error < 0.25 * target and hold == 0:
            step *= 1.6

        # At a side of a triangle the walk continues in its neighbour.
        if hold > 0:
            crossed = -1
            if zb.shape[0] == 1 and hold >= HOLD_UB:
                crossed = _across(c, neighbours, tri, hold, here[0], here[1], here[2], here[3:])
            if crossed < 0:
                return out[:n].copy(), AT_RIM
            tri = crossed
            # The point has parameters in the new triangle from now on.
            out[n - 1, 3:7] = here[3:]
    return out[:n].copy(), LOST


@entry("d2 d2 d2 -> d1")
def distances_to_segments(x, one, two):
    """Distance of each point (n, 3) from the nearest of some segments, ends (m, 3) each."""
    out = np.full(x.shape[0], np.inf)
    for i in range(x.shape[0]):
        for k in range(one.shape[0]):
            # Least squared distance, then one root.
            away = squared_distance_to_chord(one[k], two[k], x[i, 0], x[i, 1], x[i, 2])
            if away < out[i]:
                out[i] = away
        out[i] = math.sqrt(out[i])
    return out
