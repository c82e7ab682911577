"""From one point of a smooth curve to the whole of it: predictor along the tangent, Newton back.

For curves that the triangles of a lattice do not show. A step is taken along the tangent, brought
back in the plane across it, kept if its chord is near enough to the curve (as in `resample`) and
halved otherwise. The walk ends at its start, or at a rim, where the rim's own line is met.

Letters as in `lift`; `beside` (n_triangle, 3): the triangle across sides s t = 0 .. : side 0
joins corners 0 and 1 (t = 0), side 1 corners 1 and 2, side 2 corners 2 and 0 (s = 0); -1 at a rim.
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
    meet,
    meet_line,
)
from geosurf.kernels.smooth.resample import SAFETY, from_chord, measure

CLOSED, AT_RIM, LOST = 1, 2, 3
_MOST = 200_000
_SHORTEST = 1e-6  # of the first step


@scalar
def passed(za, zb, w):
    """Which rim parameters have passed first, as what to hold there; 0 if none."""
    hold, worst = 0, 0.0
    for k in range(4):
        z = za if k < 2 else zb
        top = 1.0
        if z.shape[0] > 1:
            top = (z.shape[1] if k % 2 == 0 else z.shape[0]) - 1.0
        past = max(-w[k], w[k] - top if (k < 2 or z.shape[0] > 1) else 0.0)
        if past > worst:
            hold, worst = k + 1, past
    if zb.shape[0] == 1 and w[2] + w[3] - 1.0 > worst:
        hold = HOLD_SUM
    return hold


@scalar
def put_on(za, zb, hold, w):
    """Move parameters on the rim that is held."""
    if hold == HOLD_SUM:
        more = 0.5 * (w[2] + w[3] - 1.0)
        w[2] -= more
        w[3] -= more
        return
    k = hold - 1
    z = za if k < 2 else zb
    top = 1.0
    if z.shape[0] > 1:
        top = (z.shape[1] if k % 2 == 0 else z.shape[0]) - 1.0
    w[k] = 0.0 if w[k] < 0.5 * top else top


@scalar
def _across(c, beside, tri, hold, x, y, z, w):
    """Change to the triangle across the side that is held; its number, or -1 at a rim."""
    side = 0 if hold == HOLD_VB else (1 if hold == HOLD_SUM else 2)
    other = beside[tri, side]
    if other < 0:
        return -1
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
    uu, uv, vv = (
        ux * ux + uy * uy + uz * uz,
        ux * vx + uy * vy + uz * vz,
        vx * vx + vy * vy + vz * vz,
    )
    du, dv = ux * x + uy * y + uz * z, vx * x + vy * y + vz * z
    size = uu * vv - uv * uv
    w[2], w[3] = (du * vv - dv * uv) / size, (dv * uu - du * uv) / size
    return other


@scalar
def _ahead(direction, f):
    """Turn a tangent the way the walk goes."""
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
def _append(out, n, row, error, tri):
    if n == out.shape[0]:
        more = np.empty((2 * n, 9))
        more[:n] = out
        out = more
    out[n, :7] = row
    out[n, 7] = SAFETY * error
    out[n, 8] = tri
    return out, n + 1


@entry("d2 d2 d2 d2 d2 d2 d3 l2 d1 l d d d -> d2 l")
def trace_curve(xa, ya, za, xb, yb, zb, c, beside, seed, tri, way, step, target):
    """Rows (n, 9) as in `resample`, from a seed (7: point, parameters), and how the walk ended.

    `way` is +1 or -1, `step` the first step [m], `target` the largest distance of a chord.
    """
    out = np.empty((64, 9))
    f = np.empty(N_WORK)
    here, goal, middle = seed.copy(), np.empty(7), np.empty(7)
    direction = np.zeros(3)
    first_tri, shortest = tri, _SHORTEST * step
    if meet(xa, ya, za, xb, yb, zb, c, tri, here[3:], here[0], here[1], here[2], 0.0, 0.0, 0.0, f):
        return out[:0].copy(), LOST
    for k in range(3):
        direction[k] = way * f[F_TANGENT + k]
    out, n = _append(out, 0, here, 0.0, tri)
    while n < _MOST and step > shortest:
        ax, ay, az = seed[0] - here[0], seed[1] - here[1], seed[2] - here[2]
        away = math.sqrt(ax * ax + ay * ay + az * az)
        ahead = ax * direction[0] + ay * direction[1] + az * direction[2]
        if n > 3 and away < 1.2 * step and ahead > 0.5 * away:
            if tri == first_tri:
                error = measure(xa, ya, za, xb, yb, zb, c, tri, here, seed, target, middle, f)
                if 0.0 <= error <= target:
                    out, n = _append(out, n, seed, error, tri)
                    return out[:n].copy(), CLOSED
            step = min(step, 0.4 * away)
        goal[3:] = here[3:]
        dx, dy, dz = direction
        x, y, z = here[0] + step * dx, here[1] + step * dy, here[2] + step * dz
        found = meet(xa, ya, za, xb, yb, zb, c, tri, goal[3:], x, y, z, dx, dy, dz, f)
        hold = 0
        if found == OUTSIDE:
            hold = passed(za, zb, goal[3:])
            put_on(za, zb, hold, goal[3:])
            found = meet_line(xa, ya, za, xb, yb, zb, c, tri, goal[3:], hold, f)
        if found != LIFTED:
            step *= 0.5
            continue
        goal[:3] = f[F_POINT : F_POINT + 3]
        turn = f[F_TANGENT] * dx + f[F_TANGENT + 1] * dy + f[F_TANGENT + 2] * dz
        gone = (goal[0] - here[0]) * dx + (goal[1] - here[1]) * dy + (goal[2] - here[2]) * dz
        error = measure(xa, ya, za, xb, yb, zb, c, tri, here, goal, target, middle, f)
        # the tangent turns by 37 degrees at most, and the walk goes on
        if error < 0.0 or error > target or abs(turn) < 0.8 or gone < 0.0 or gone > 2.0 * step:
            step *= 0.5
            continue
        meet(xa, ya, za, xb, yb, zb, c, tri, goal[3:], goal[0], goal[1], goal[2], 0.0, 0.0, 0.0, f)
        _ahead(direction, f)
        out, n = _append(out, n, goal, error, tri)
        here[:] = goal
        if error < 0.25 * target and hold == 0:
            step *= 1.6
        if hold > 0:
            crossed = -1
            if zb.shape[0] == 1 and hold >= HOLD_UB:
                crossed = _across(c, beside, tri, hold, here[0], here[1], here[2], here[3:])
            if crossed < 0:
                return out[:n].copy(), AT_RIM
            tri = crossed
            out[n - 1, 3:7] = here[3:]
    return out[:n].copy(), LOST


@entry("d2 d2 d2 -> d1")
def distances(x, one, two):
    """Distance of each point (n, 3) from the nearest of some segments, ends (m, 3) each."""
    out = np.full(x.shape[0], np.inf)
    for i in range(x.shape[0]):
        for k in range(one.shape[0]):
            away = from_chord(one[k], two[k], x[i, 0], x[i, 1], x[i, 2])
            if away < out[i]:
                out[i] = away
        out[i] = math.sqrt(out[i])
    return out
