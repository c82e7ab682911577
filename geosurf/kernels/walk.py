"""All curves of two smooth lattices at once: a landing in each pair of cells, a walk from each.

From the middle of every pair of cells that bounds leave over (`near`), Newton's method lands on a
curve, or finds none. From a landing that no walk has passed yet, the curve is walked both ways
until it closes or leaves a surface. One step goes along the parabola through the last two
tangents, comes back by Newton's method in the plane across, and is kept if its chord, measured at
its quarters as in `resample`, is near enough to the curve; its length follows the square root of
that error.

A pair of cells is settled if its surfaces are transverse (`cover`: no closed curve lies inside) and
its landing lies beside a walk. All other pairs are handed back, to be split.

Newton's method stops once the next step can no longer matter: a step e leaves e^2 / 2 R, with R the
radius of curvature of the surfaces, which is taken to be more than a metre or the size of a cell.

Letters as in `lift`; k rows (8,) of landings: parameters, point, whether a walk has passed (1), or
nothing is there (2); rows of walks (15,): point, parameters, chord error, six doubts, sine.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels._jit import entry, scalar
from geosurf.kernels.cover import cone, transverse
from geosurf.kernels.lift import (
    ASTRAY,
    F_POINT,
    F_SINE,
    F_TANGENT,
    LIFTED,
    N_WORK,
    OUTSIDE,
    doubt,
    meet_line,
    meet_to,
)
from geosurf.kernels.resample import SAFETY, from_chord
from geosurf.kernels.trace import AT_RIM, CLOSED, LOST, passed, put_on

W_CHORD, W_DOUBT, W_SINE, N_ROW = 7, 8, 14, 15
_OPEN, _PASSED, _NOWHERE = 0.0, 1.0, 2.0
_FARTHEST = 2.0  # [cells] of one step
_MOST = 200_000
_SHORTEST = 1e-6  # of the first step
_SAME = 4.0  # [tolerances]: what is nearer to a walk is on it
_TOLD = 4  # one of so many landings tells how good the cubics are; along walks all is looked at


@scalar
def _cell(z, u, v):
    n_col = z.shape[1] - 1
    j = min(max(math.floor(u), 0), n_col - 1)
    return min(max(math.floor(v), 0), z.shape[0] - 2) * n_col + j


@scalar
def _land(xa, ya, za, xb, yb, zb, c, net, cell_a, cell_b, enough, f, land):
    """Newton from the middle of a pair of cells."""
    w = land[:4]
    n_col = za.shape[1] - 1
    w[0], w[1] = cell_a % n_col + 0.5, cell_a // n_col + 0.5
    n_col = zb.shape[1] - 1
    w[2], w[3] = cell_b % n_col + 0.5, cell_b // n_col + 0.5
    x = 0.25 * (net[0, 0, 0] + net[3, 0, 0] + net[0, 3, 0] + net[3, 3, 0])
    y = 0.25 * (net[0, 0, 1] + net[3, 0, 1] + net[0, 3, 1] + net[3, 3, 1])
    z = 0.25 * (net[0, 0, 2] + net[3, 0, 2] + net[0, 3, 2] + net[3, 3, 2])
    found = meet_to(xa, ya, za, xb, yb, zb, c, 0, w, x, y, z, 0.0, 0.0, 0.0, enough, f)
    land[4], land[5], land[6] = f[F_POINT], f[F_POINT + 1], f[F_POINT + 2]
    land[7] = _OPEN if found == LIFTED else _NOWHERE
    return found


@scalar
def _pass_by(za, one, two, tolerance, f, cells, order, land):
    """Mark the landings that lie on a chord of a walk."""
    size = math.sqrt(f[3] * f[3] + f[4] * f[4] + f[5] * f[5])
    reach = _SAME * tolerance
    more = reach / size
    n_row, n_col = za.shape[0] - 1, za.shape[1] - 1
    j0 = max(math.floor(min(one[3], two[3]) - more), 0)
    j1 = min(math.floor(max(one[3], two[3]) + more), n_col - 1)
    size = math.sqrt(f[6] * f[6] + f[7] * f[7] + f[8] * f[8])
    more = reach / size
    i0 = max(math.floor(min(one[4], two[4]) - more), 0)
    i1 = min(math.floor(max(one[4], two[4]) + more), n_row - 1)
    for i in range(i0, i1 + 1):
        k = np.searchsorted(cells, i * n_col + j0)
        while k < cells.shape[0] and cells[k] <= i * n_col + j1:
            q = land[order[k]]
            if q[7] == _OPEN and from_chord(one, two, q[4], q[5], q[6]) <= reach * reach:
                q[7] = _PASSED
            k += 1


@scalar
def _chord(xa, ya, za, xb, yb, zb, c, one, two, target, enough, w, f):
    """Largest distance of the curve from a chord at its quarters; inf if it cannot be measured."""
    dx, dy, dz = two[0] - one[0], two[1] - one[1], two[2] - one[2]
    if dx == 0.0 and dy == 0.0 and dz == 0.0:
        return 0.0
    largest = 0.0
    for k in range(3):
        t = 0.5 if k == 0 else (0.25 if k == 1 else 0.75)
        for col in range(4):
            w[col] = one[3 + col] + t * (two[3 + col] - one[3 + col])
        x, y, z = one[0] + t * dx, one[1] + t * dy, one[2] + t * dz
        found = meet_to(xa, ya, za, xb, yb, zb, c, 0, w, x, y, z, dx, dy, dz, enough, f)
        if found != LIFTED:
            return np.inf
        x, y, z = f[F_POINT] - x, f[F_POINT + 1] - y, f[F_POINT + 2] - z
        largest = max(largest, math.sqrt(x * x + y * y + z * z))
        if largest > target:
            break
    return largest


@scalar
def _add(out, n, row, error, xa, ya, za, xb, yb, zb, f, fresh):
    """Append a row; how far its cells are to be trusted is looked up where cells change."""
    if n == out.shape[0]:
        more = np.empty((2 * n, N_ROW))
        more[:n] = out
        out = more
    for k in range(7):
        out[n, k] = row[k]
    out[n, W_CHORD], out[n, W_SINE] = SAFETY * error, f[F_SINE]
    same = not fresh
    if same:
        same = _cell(za, row[3], row[4]) == _cell(za, out[n - 1, 3], out[n - 1, 4])
    if same:
        same = _cell(zb, row[5], row[6]) == _cell(zb, out[n - 1, 5], out[n - 1, 6])
    if same:
        for k in range(W_DOUBT, W_SINE):
            out[n, k] = out[n - 1, k]
    else:
        doubt(xa, ya, za, xb, yb, zb, row[3:7], f, out[n, W_DOUBT:W_SINE])
    return out, n + 1


@scalar
def _rates(f, rate):
    """Parameters per metre along the tangent; the largest of them."""
    largest = 0.0
    for k in range(2):
        o = 9 * k
        ux, uy, uz = f[o + 3], f[o + 4], f[o + 5]
        vx, vy, vz = f[o + 6], f[o + 7], f[o + 8]
        uu, uv, vv = (
            ux * ux + uy * uy + uz * uz,
            ux * vx + uy * vy + uz * vz,
            vx * vx + vy * vy + vz * vz,
        )
        du = ux * f[F_TANGENT] + uy * f[F_TANGENT + 1] + uz * f[F_TANGENT + 2]
        dv = vx * f[F_TANGENT] + vy * f[F_TANGENT + 1] + vz * f[F_TANGENT + 2]
        size = uu * vv - uv * uv
        rate[2 * k], rate[2 * k + 1] = (du * vv - dv * uv) / size, (dv * uu - du * uv) / size
        largest = max(largest, abs(rate[2 * k]), abs(rate[2 * k + 1]))
    return largest


@scalar
def _ahead(xa, ya, za, xb, yb, zb, c, work, step, enough, f):
    """Newton from a step along the parabola into `goal`; how it ended, and whether at a rim."""
    here, goal, d, turn, rate, bend = work[0], work[1], work[2], work[3], work[4], work[5]
    for k in range(4):
        goal[3 + k] = here[3 + k] + step * (rate[k] + 0.5 * step * bend[k])
    half = 0.5 * step
    x = here[0] + step * (d[0] + half * turn[0])
    y = here[1] + step * (d[1] + half * turn[1])
    z = here[2] + step * (d[2] + half * turn[2])
    found = meet_to(xa, ya, za, xb, yb, zb, c, 0, goal[3:], x, y, z, d[0], d[1], d[2], enough, f)
    if found != OUTSIDE:
        return found, False
    hold = passed(za, zb, goal[3:])
    put_on(za, zb, hold, goal[3:])
    return meet_line(xa, ya, za, xb, yb, zb, c, 0, goal[3:], hold, f), True


@scalar
def _gone(work, step, shortest, f):
    """How far a step went, with its tangent and turn in rows 7 and 8; -1 if it is not to be kept.

    The tangent turns by 37 degrees at most, and the walk goes on.
    """
    here, goal, d = work[0], work[1], work[2]
    gone, along = 0.0, 0.0
    for k in range(3):
        goal[k] = f[F_POINT + k]
        gone += (goal[k] - here[k]) * d[k]
        along += f[F_TANGENT + k] * d[k]
    if abs(along) < 0.8 or gone < 0.0 or gone > 2.0 * step:
        return -1.0
    sign = 1.0 if along > 0.0 else -1.0
    for k in range(3):
        tangent = sign * f[F_TANGENT + k]
        work[7, k], work[8, k] = tangent, (tangent - d[k]) / max(gone, shortest)
        f[F_TANGENT + k] = tangent
    return gone


@scalar
def _walk(xa, ya, za, xb, yb, zb, c, seed, way, step, target, tolerance, enough, cells, order,
          land, out, n, work, f):  # fmt: skip
    """Append the rows from a seed, itself included, to where the walk ends; that end.

    `work` (10, 7): here, goal, direction and its turn, rates of parameters and theirs, parameters
    of chords; then what a step finds: tangent, turn, rates.
    """
    here, goal, d, turn, rate, bend, w = (
        work[0], work[1], work[2], work[3], work[4], work[5], work[6],
    )  # fmt: skip
    for k in range(7):
        here[k], turn[k], bend[k] = seed[k], 0.0, 0.0
    found = meet_to(
        xa, ya, za, xb, yb, zb, c, 0, here[3:], here[0], here[1], here[2], 0.0, 0.0, 0.0, enough, f
    )
    if found != LIFTED:
        return out, n, LOST
    for k in range(3):
        d[k] = way * f[F_TANGENT + k]
        f[F_TANGENT + k] = d[k]
    steepest = _rates(f, rate)
    shortest, first = _SHORTEST * step, n
    out, n = _add(out, n, here, 0.0, xa, ya, za, xb, yb, zb, f, True)
    loose = math.sqrt(0.01 * target * min(1.0, step))
    while n - first < _MOST and step > shortest:
        step = min(step, _FARTHEST / steepest)
        ax, ay, az = seed[0] - here[0], seed[1] - here[1], seed[2] - here[2]
        away = math.sqrt(ax * ax + ay * ay + az * az)
        if n - first > 3 and away < 1.2 * step and ax * d[0] + ay * d[1] + az * d[2] > 0.5 * away:
            for k in range(7):
                goal[k] = seed[k]
            error = _chord(xa, ya, za, xb, yb, zb, c, here, goal, target, loose, w, f)
            if error <= target:
                _pass_by(za, here, goal, tolerance, f, cells, order, land)
                out, n = _add(out, n, goal, error, xa, ya, za, xb, yb, zb, f, False)
                return out, n, CLOSED
            step = min(step, 0.4 * away)
        found, at_rim = _ahead(xa, ya, za, xb, yb, zb, c, work, step, enough, f)
        if found != LIFTED:
            step *= 0.5
            continue
        gone = _gone(work, step, shortest, f)
        if gone < 0.0:
            step *= 0.5
            continue
        sine = f[F_SINE]
        steepest_there = _rates(f, work[9])
        error = _chord(xa, ya, za, xb, yb, zb, c, here, goal, target, loose, w, f)
        if error > target:
            step *= max(0.3, 0.9 * math.sqrt(target / error))
            continue
        _pass_by(za, here, goal, tolerance, f, cells, order, land)
        f[F_SINE] = sine
        out, n = _add(out, n, goal, error, xa, ya, za, xb, yb, zb, f, False)
        if at_rim:
            return out, n, AT_RIM
        for k in range(4):
            bend[k] = (work[9, k] - rate[k]) / max(gone, shortest)
            rate[k] = work[9, k]
        for k in range(3):
            turn[k], d[k] = work[8, k], work[7, k]
        for k in range(7):
            here[k] = goal[k]
        steepest = steepest_there
        step *= min(1.6, 0.94 * math.sqrt(target / max(error, 1e-3 * target)))
    return out, n, LOST


@scalar
def _turn_round(out, a, b):
    """Reverse rows a to b; the chord errors go with either end."""
    while a < b - 1:
        b -= 1
        for k in range(out.shape[1]):
            out[a, k], out[b, k] = out[b, k], out[a, k]
        a += 1


@scalar
def _worst(xa, ya, za, xb, yb, zb, row, rough, f, six):
    """Upper estimate [m] of the distance of both cubics from what was sampled, at a landing."""
    doubt(xa, ya, za, xb, yb, zb, row[:4], f, six)
    total = six[0] / (1.0 - rough) + six[2] + six[3] / (1.0 - rough) + six[5]
    return total / f[F_SINE]


@scalar
def _land_all(xa, ya, za, xb, yb, zb, c, pairs, cell_a, cell_b, nets_a, nets_b, enough, rough, f,
              land, key):  # fmt: skip
    """Land in all pairs that are transverse: `land`, the cells of a there (-1: none) in `key`.

    Returns how far the cubics may be from what was sampled, at every fourth landing.
    """
    six = np.empty(6)
    cones_a, cones_b = np.full((len(cell_a), 4), np.nan), np.full((len(cell_b), 4), np.nan)
    worst, landed = 0.0, 0
    for k in range(pairs.shape[0]):
        a, b = pairs[k]
        if math.isnan(cones_a[a, 3]):
            cones_a[a, 0], cones_a[a, 1], cones_a[a, 2], cones_a[a, 3] = cone(nets_a[a])
        if math.isnan(cones_b[b, 3]):
            cones_b[b, 0], cones_b[b, 1], cones_b[b, 2], cones_b[b, 3] = cone(nets_b[b])
        p, q = cones_a[a], cones_b[b]
        found = ASTRAY
        if transverse(p[0], p[1], p[2], p[3], q[0], q[1], q[2], q[3]):
            found = _land(
                xa, ya, za, xb, yb, zb, c, nets_a[a], cell_a[a], cell_b[b], enough, f, land[k]
            )
        key[k] = -1
        if found == LIFTED:
            key[k] = _cell(za, land[k, 0], land[k, 1])
            if landed % _TOLD == 0:
                worst = max(worst, _worst(xa, ya, za, xb, yb, zb, land[k], rough, f, six))
            landed += 1
        else:
            land[k, 7] = _NOWHERE
    return worst


@entry("d2 d2 d2 d2 d2 d2 d3 l2 l1 l1 d4 d4 d d d d -> d2 l1 l1 l1")
def walk_all(xa, ya, za, xb, yb, zb, c, pairs, cell_a, cell_b, nets_a, nets_b, step, tolerance,
             doubted, rough):  # fmt: skip
    """Curves of two lattices: rows (n, 15), offsets, how each ends, and the pairs not settled.

    `step` is the first step [m], `doubted` the part of the tolerance [m] that the cubics take; if
    it is negative, the landings tell, with interpolants that differ by `rough` from order to order.
    """
    n_pair = pairs.shape[0]
    f, work = np.empty(N_WORK), np.zeros((10, 7))
    land, key = np.empty((n_pair, 8)), np.empty(n_pair, dtype=np.int64)
    near = math.sqrt(0.25 * tolerance * min(1.0, step))  # an eighth of the tolerance is left
    worst = _land_all(xa, ya, za, xb, yb, zb, c, pairs, cell_a, cell_b, nets_a, nets_b, near, rough,
                      f, land, key)  # fmt: skip
    enough = math.sqrt(min(1e-6, 1e-3 * tolerance) * min(1.0, step))
    if doubted < 0.0:
        doubted = worst
    target = max(tolerance - doubted, 0.25 * tolerance) / SAFETY
    order = np.argsort(key)
    cells = key[order]
    out, n = np.empty((64, N_ROW)), 0
    offsets, ends = np.zeros(n_pair + 1, dtype=np.int64), np.zeros(n_pair, dtype=np.int64)
    count = 0
    seed = np.empty(7)
    for k in range(n_pair):
        if land[k, 7] != _OPEN:
            continue
        land[k, 7] = _PASSED
        for col in range(3):
            seed[col] = land[k, 4 + col]
        for col in range(4):
            seed[3 + col] = land[k, col]
        start = n
        out, n, end = _walk(xa, ya, za, xb, yb, zb, c, seed, -1.0, step, target, tolerance, enough,
                            cells, order, land, out, n, work, f)  # fmt: skip
        if end == AT_RIM:
            _turn_round(out, start, n)
            n -= 1  # the seed comes once more
            out, n, end = _walk(xa, ya, za, xb, yb, zb, c, seed, 1.0, step, target, tolerance,
                                enough, cells, order, land, out, n, work, f)  # fmt: skip
            end = AT_RIM if end == AT_RIM else LOST
        ends[count] = end
        count += 1
        offsets[count] = n
        if end == LOST:
            break
    return out[:n].copy(), offsets[: count + 1].copy(), ends[:count].copy(), np.where(key < 0)[0]
