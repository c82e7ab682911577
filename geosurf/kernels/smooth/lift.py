"""Points of plain curves lifted onto the cubics of both surfaces, by Newton's method.

One step intersects three planes: the tangent planes of the two surfaces at the present parameters,
and a third that fixes the position along the curve. Parameters follow by projecting the step on the
tangents. Steps shrink quadratically: after a step e the error is e^2 / 2 R, with R the radius of
curvature of the surfaces, assumed to exceed a metre, or e^2 (e / d^2) with the previous step d. The
iteration ends when either is below that of a step `enough` with R = 1 m (the second tenfold); for
1e-6 m that is far below the resolution of float64 at a UTM northing. At the boundary of a surface
the curve ends; there the third plane is replaced by the boundary: the line on which one parameter
is fixed.

Letters as in `cubic_patch`, and
    a, b    as suffix: of the first surface (a lattice), of the second (a lattice or triangles)
    c       triangles (n_triangle, 3, 3) of the second surface, if its z has one row
    w       parameters (4,): u, v on a; u, v on b, or coordinates s, t in triangle `tri` of b
    f       workspace (25,): point and tangents of a, of b; point, tangent and sine of the meeting
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.smooth.cubic_patch import evaluate, interpolant_differences, unit_cross

LIFTED, ASTRAY, HOLE, OUTSIDE = 0, 1, 2, 3
F_POINT, F_TANGENT, F_SINE, N_WORK = 18, 21, 24, 25
# fixed parameter: none; u or v on a; u or v on b (or a side of its triangle); s + t on b
HOLD_UA, HOLD_VA, HOLD_UB, HOLD_VB, HOLD_SUM = 1, 2, 3, 4, 5
_STEP = 1e-6  # [m]: Newton ends when a step is shorter
_MARGIN = 400.0  # 4 (e^3 / d^2)^2, tenfold
_EDGE = 1e-6  # [cells]: tolerance for parameters beyond the boundary
_PARALLEL = 1e-6  # least sine of the angle between the surfaces
_ALONG = 0.05  # least cosine of the angle between the curve and the normal of the third plane


class SurfacePair(NamedTuple):
    """Coordinates of two surfaces: a lattice, and a lattice or the triangles `c`."""

    xa: np.ndarray
    ya: np.ndarray
    za: np.ndarray
    xb: np.ndarray
    yb: np.ndarray
    zb: np.ndarray
    c: np.ndarray


@scalar
def evaluate_second(xb, yb, zb, c, tri, s, t, f):
    """Point and tangents of the second surface into f[9 : 18]."""
    if zb.shape[0] > 1:
        evaluate(xb, yb, zb, s, t, f, 9)
        return

    # A triangle is linear in its parameters.
    for k in range(3):
        f[12 + k] = c[tri, 1, k] - c[tri, 0, k]
        f[15 + k] = c[tri, 2, k] - c[tri, 0, k]
        f[9 + k] = c[tri, 0, k] + s * f[12 + k] + t * f[15 + k]


@scalar
def _across(f, o):
    """Cross product of the tangents in f[o + 3 : o + 9]."""
    return (
        f[o + 4] * f[o + 8] - f[o + 5] * f[o + 7],
        f[o + 5] * f[o + 6] - f[o + 3] * f[o + 8],
        f[o + 3] * f[o + 7] - f[o + 4] * f[o + 6],
    )


@scalar
def normal(f, o):
    """Unit normal of the surface whose tangents are in f[o + 3 : o + 9]."""
    return unit_cross(f[o + 3], f[o + 4], f[o + 5], f[o + 6], f[o + 7], f[o + 8])


@scalar
def parameters_of(f, o, dx, dy, dz):
    """Changes of both parameters for a step along a surface (its normal part is ignored)."""
    return solve_tangents(f[o + 3], f[o + 4], f[o + 5], f[o + 6], f[o + 7], f[o + 8], dx, dy, dz)


@scalar
def solve_tangents(ux, uy, uz, vx, vy, vz, dx, dy, dz):
    """Coefficients of a vector d in two tangents u and v, by the 2 x 2 normal equations."""
    uu, uv, vv = (
        ux * ux + uy * uy + uz * uz,
        ux * vx + uy * vy + uz * vz,
        vx * vx + vy * vy + vz * vz,
    )
    du, dv = ux * dx + uy * dy + uz * dz, vx * dx + vy * dy + vz * dz
    # The determinant is the squared area between the tangents.
    size = uu * vv - uv * uv
    return (du * vv - dv * uv) / size, (dv * uu - du * uv) / size


@scalar
def _follow(f, o, p, q, r, size, dx, dy, dz, w, k):
    """Move parameters w[k], w[k + 1] so that the point moves by (dx, dy, dz); two cells at most.

    (p, q, r) the cross product of the tangents, `size` its square.
    """
    ux, uy, uz = f[o + 3], f[o + 4], f[o + 5]
    vx, vy, vz = f[o + 6], f[o + 7], f[o + 8]

    # Components along both tangents, by triple products; limited to two cells.
    du = (dy * vz - dz * vy) * p + (dz * vx - dx * vz) * q + (dx * vy - dy * vx) * r
    dv = (uy * dz - uz * dy) * p + (uz * dx - ux * dz) * q + (ux * dy - uy * dx) * r
    # A nearly tangent direction would throw the point out of the surface.
    w[k] += min(max(du / size, -2.0), 2.0)
    w[k + 1] += min(max(dv / size, -2.0), 2.0)


@scalar
def _set_point(f, x, y, z, tx, ty, tz, size, most):
    """Point, tangent (tx, ty, tz) of length `size`; `most`: that length, were the sine 1."""
    f[18], f[19], f[20] = x, y, z
    f[21], f[22], f[23], f[24] = tx / size, ty / size, tz / size, size / most


@scalar
def _crossing(f):
    """Normals of both surfaces and their cross product with its length."""
    ax, ay, az = normal(f, 0)
    bx, by, bz = normal(f, 9)
    tx, ty, tz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    return ax, ay, az, bx, by, bz, tx, ty, tz, math.sqrt(tx * tx + ty * ty + tz * tz)


@scalar
def newton_in_plane(surfaces, tri, w, px, py, pz, dx, dy, dz, f):
    """Newton in the plane through (px, py, pz) across (dx, dy, dz); zeros: across the curve."""
    return newton_in_plane_to(surfaces, tri, w, px, py, pz, dx, dy, dz, _STEP, f)


@scalar
def newton_in_plane_to(surfaces, tri, w, px, py, pz, dx, dy, dz, enough, f):
    """`newton_in_plane` with its own final step: see the head of this file."""
    xa, ya, za, xb, yb, zb, c = surfaces
    # Squares, so that no root is taken in the loop.
    left, before = enough * enough, 0.0
    for _ in range(16):
        evaluate(xa, ya, za, w[0], w[1], f, 0)
        evaluate_second(xb, yb, zb, c, tri, w[2], w[3], f)
        # normals are not normalised: roots and quotients would delay the step
        ax, ay, az = _across(f, 0)
        bx, by, bz = _across(f, 9)
        tx, ty, tz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        aa, bb = ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz
        tt = tx * tx + ty * ty + tz * tz

        # A hole in a stencil, or surfaces that are parallel.
        if math.isnan(f[0] + f[1] + f[2] + f[9] + f[10] + f[11]):
            return HOLE
        if not tt > _PARALLEL * _PARALLEL * aa * bb:
            return ASTRAY
        # No direction given: across the curve itself, which the normals tell.
        if dx == 0.0 and dy == 0.0 and dz == 0.0:
            dx, dy, dz = tx, ty, tz

        # The third plane must not contain the curve.
        det = dx * tx + dy * ty + dz * tz
        if det * det < _ALONG * _ALONG * tt * (dx * dx + dy * dy + dz * dz):
            return ASTRAY

        # The intersection of the three planes.
        # Cramer's rule for the three planes, with the third one through the start.
        a = (ax * (f[0] - px) + ay * (f[1] - py) + az * (f[2] - pz)) / det
        b = (bx * (f[9] - px) + by * (f[10] - py) + bz * (f[11] - pz)) / det
        x = px + a * (by * dz - bz * dy) + b * (dy * az - dz * ay)
        y = py + a * (bz * dx - bx * dz) + b * (dz * ax - dx * az)
        z = pz + a * (bx * dy - by * dx) + b * (dx * ay - dy * ax)
        ex, ey, ez = x - f[0], y - f[1], z - f[2]
        gx, gy, gz = x - f[9], y - f[10], z - f[11]
        _follow(f, 0, ax, ay, az, aa, ex, ey, ez, w, 0)
        _follow(f, 9, bx, by, bz, bb, gx, gy, gz, w, 2)

        # Converged: by length, or by the cubic estimate from the last two steps.
        size = ex * ex + ey * ey + ez * ez + gx * gx + gy * gy + gz * gz
        if size < left or _MARGIN * size * size * size < left * left * before * before:
            _set_point(f, x, y, z, tx, ty, tz, math.sqrt(tt), math.sqrt(aa * bb))
            return inside(za, zb, w)
        before = size
    return ASTRAY


@scalar
def newton_on_boundary(surfaces, tri, w, hold, f):
    """Newton with one parameter of one surface fixed: a line on it through the other surface."""
    xa, ya, za, xb, yb, zb, c = surfaces

    # The surface with the fixed parameter, and the direction of its free line.
    first = hold <= HOLD_VA
    # Offsets of tangents and parameters: o and k of the surface with the fixed parameter, g and m
    # of the other one.
    o, k, g, m = (0, 0, 9, 2) if first else (9, 2, 0, 0)
    # Direction of the free line in both parameters.
    eu = 0.0 if (hold == HOLD_UA or hold == HOLD_UB) else (-1.0 if hold == HOLD_SUM else 1.0)
    ev = 0.0 if (hold == HOLD_VA or hold == HOLD_VB) else 1.0
    for _ in range(16):
        evaluate(xa, ya, za, w[0], w[1], f, 0)
        evaluate_second(xb, yb, zb, c, tri, w[2], w[3], f)
        _, _, _, _, _, _, tx, ty, tz, sine = _crossing(f)
        if math.isnan(f[0] + f[1] + f[2] + f[9] + f[10] + f[11]):
            return HOLE
        if not sine > _PARALLEL:
            return ASTRAY

        # Step along the line to the tangent plane of the other surface.
        p, q, r = normal(f, g)
        lx = eu * f[o + 3] + ev * f[o + 6]
        ly = eu * f[o + 4] + ev * f[o + 7]
        lz = eu * f[o + 5] + ev * f[o + 8]
        across = p * lx + q * ly + r * lz
        if not abs(across) > _PARALLEL * math.sqrt(lx * lx + ly * ly + lz * lz):
            return ASTRAY
        step = (p * (f[g] - f[o]) + q * (f[g + 1] - f[o + 1]) + r * (f[g + 2] - f[o + 2])) / across
        x, y, z = f[o] + step * lx, f[o + 1] + step * ly, f[o + 2] + step * lz
        ex, ey, ez = x - f[g], y - f[g + 1], z - f[g + 2]
        size = step * step * (lx * lx + ly * ly + lz * lz) + ex * ex + ey * ey + ez * ez
        # Two cells at most, as in `_follow`.
        step = min(max(step, -2.0), 2.0)
        w[k] += step * eu
        w[k + 1] += step * ev
        du, dv = parameters_of(f, g, ex, ey, ez)
        w[m] += min(max(du, -2.0), 2.0)
        w[m + 1] += min(max(dv, -2.0), 2.0)
        if size < _STEP * _STEP:
            _set_point(f, x, y, z, tx, ty, tz, sine, 1.0)
            return inside(za, zb, w)
    return ASTRAY


@scalar
def inside(za, zb, w):
    """LIFTED if the parameters are on both surfaces; those within tolerance are clamped."""
    for k in range(4):
        # Upper limit of the parameter: the last node, or the side of the triangle.
        z = za if k < 2 else zb
        if z.shape[0] > 1:
            top = (z.shape[1] if k % 2 == 0 else z.shape[0]) - 1.0
        else:
            # In a triangle s + t is at most 1.
            top = 1.0 if k == 2 else 1.0 - w[2]
        if not (-_EDGE <= w[k] <= top + _EDGE):
            return OUTSIDE
        w[k] = min(max(w[k], 0.0), max(top, 0.0))
    return LIFTED


@scalar
def differences_at(surfaces, w, f, out):
    """`interpolant_differences` along the normals of a and b: three numbers each."""
    xa, ya, za, xb, yb, zb, _ = surfaces
    p, q, r = normal(f, 0)
    out[0], out[1], out[2] = interpolant_differences(xa, ya, za, w[0], w[1], p, q, r)
    out[3], out[4], out[5] = 0.0, 0.0, 0.0
    if zb.shape[0] > 1:
        p, q, r = normal(f, 9)
        out[3], out[4], out[5] = interpolant_differences(xb, yb, zb, w[2], w[3], p, q, r)


@entry("d2 d2 d2 d2 d2 d2 d3 l1 l1 d2 d2 d2 d2 d2 -> l1")
def lift_points(xa, ya, za, xb, yb, zb, c, tri, hold, start, w, p, tangents, differences):
    """Lift the points `start` (n, 3); w (n, 4) holds approximate parameters and returns exact ones.

    Fills p (n, 3), tangents (n, 4) with the sine of the angle between the surfaces last, and
    differences (n, 6). Returns LIFTED, ASTRAY, HOLE or OUTSIDE for each.
    """
    n = start.shape[0]
    status = np.empty(n, dtype=np.int64)
    surfaces = SurfacePair(xa, ya, za, xb, yb, zb, c)
    f = np.empty(N_WORK)
    for i in range(n):
        # No start, a fixed boundary parameter, or free along the curve.
        if hold[i] < 0:
            status[i] = HOLE
            continue
        if hold[i] > 0:
            found = newton_on_boundary(surfaces, tri[i], w[i], hold[i], f)
        else:
            q = start[i]
            found = newton_in_plane(surfaces, tri[i], w[i], q[0], q[1], q[2], 0.0, 0.0, 0.0, f)
        if found == LIFTED:
            p[i] = f[F_POINT : F_POINT + 3]
            tangents[i] = f[F_TANGENT:N_WORK]
            differences_at(surfaces, w[i], f, differences[i])
            if math.isnan(differences[i, 0] + differences[i, 3]):
                found = HOLE
        status[i] = found
    return status


@entry("d2 d2 d2 l1 l1 l1 l -> ")
def drop_reversals(start, p, tangents, must, offsets, status, dropped):
    """Drop lifted points that are not ahead of the previous one, in the direction of the plain
    curve.

    Points that must stay and are not ahead become ASTRAY.
    """
    for curve in range(offsets.shape[0] - 1):
        # The majority of tangents decides the sense of the curve.
        vote = 0
        for i in range(offsets[curve], offsets[curve + 1] - 1):
            if status[i] == LIFTED:
                along = 0.0
                for k in range(3):
                    along += (start[i + 1, k] - start[i, k]) * tangents[i, k]
                vote += 1 if along > 0.0 else -1
        sense = 1.0 if vote >= 0 else -1.0
        last = -1
        for i in range(offsets[curve], offsets[curve + 1]):
            if status[i] == dropped:
                continue
            if status[i] != LIFTED:
                # A gap: the next lifted point starts anew.
                last = -1
                continue
            if last >= 0:
                # Both tangents have to agree that the point is ahead.
                out, back = 0.0, 0.0
                for k in range(3):
                    out += (p[i, k] - p[last, k]) * tangents[last, k] * sense
                    back += (p[i, k] - p[last, k]) * tangents[i, k] * sense
                if not (out > 0.0 and back > 0.0):
                    # Of two points in the wrong order the one that may go is dropped.
                    if must[i] == 0:
                        status[i] = dropped
                        continue
                    if must[last] == 0:
                        status[last] = dropped
                    else:
                        status[i] = ASTRAY
                        last = -1
                        continue
            last = i
