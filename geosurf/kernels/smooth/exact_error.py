"""How far exact curves are from those of local cubics, and how far triangles will be, from samples.

Both are asked before or instead of cubics, on small lattices too, so each is one call.

Letters as in `cubic_patch` and `lift`; nodes have coordinates of the world: 1e-9 m do not matter to
an error, and nothing is copied.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.contacts.packed_contact import HOW, n_corner_of
from geosurf.kernels.smooth.cubic_patch import evaluate, interpolant_differences, node
from geosurf.kernels.smooth.error_estimate import ROUGH, error_at
from geosurf.kernels.smooth.lift import (
    ASTRAY,
    F_POINT,
    F_SINE,
    HOLE,
    LIFTED,
    N_WORK,
    SurfacePair,
    differences_at,
    newton_in_plane,
    normal,
    solve_tangents,
)

_SOME = 8  # segments that may tell the error of all
_HARDLY = 0.1  # part of the tolerance: noise below it does not matter


@scalar
def _sampled(n, k, most):
    """Node k of `most` nodes that are spread over n, with two more on either side."""
    return 2 + ((n - 5) * k) // (most - 1)


@scalar
def _bends(q, i, j, sums):
    """Add squares of second differences of a coordinate along column j and along row i."""
    here = 2.0 * node(q, i, j)
    if q.shape[0] > 1:
        bend = node(q, i - 1, j) - here + node(q, i + 1, j)
        sums[0] += bend * bend
    if q.shape[1] > 1:
        bend = node(q, i, j - 1) - here + node(q, i, j + 1)
        sums[1] += bend * bend


@scalar
def _judge(x, y, z, most, f):
    """Second differences of a lattice, and its noise: root mean squares over samples [m].

    Samples next to absent nodes do not count; where none is left, nothing is foreseen: inf.
    """
    n_row, n_col = z.shape
    sums, here = np.zeros((3, 2)), np.zeros((3, 2))
    fine, finer, noise, n = 0.0, 0.0, 0.0, 0
    for k in range(most):
        i = _sampled(n_row, k, most)
        for m in range(most):
            j = _sampled(n_col, m, most)
            here[:] = 0.0
            if x.shape[0] > 1:  # axes are even, or nearly so
                _bends(x, i, j, here[0])
                _bends(y, i, j, here[1])
            _bends(z, i, j, here[2])
            evaluate(x, y, z, j + 0.5, i + 0.5, f, 0)
            p, q, r = normal(f, 0)
            d, e, g = interpolant_differences(x, y, z, j + 0.5, i + 0.5, p, q, r)
            if not math.isfinite(here.sum() + d + e + g):
                continue
            sums += here
            fine += d * d
            finer += e * e
            noise += g * g
            n += 1
    if n == 0:
        return np.inf, 0.0
    bends = 0.0
    for k in range(3):
        bends += math.sqrt(sums[k, 0] / n) + math.sqrt(sums[k, 1] / n)

    # as in `error_estimate`: what does not converge is noise
    rough = not math.sqrt(finer) <= ROUGH * math.sqrt(fine)
    return bends, math.sqrt(noise / n) if rough else 0.0


@entry("d2 d2 d2 d2 d2 d2 l -> d d")
def judge_lattices(xa, ya, za, xb, yb, zb, most):
    """Sums of second differences and of noise of lattices, from `most`² nodes of each [m].

    Triangles leave a surface by an eighth of its second differences. A second lattice of one row is
    none.
    """
    f = np.empty(N_WORK)
    bends, noise = _judge(xa, ya, za, most, f)
    if zb.shape[0] > 1:
        more, louder = _judge(xb, yb, zb, most, f)
        bends, noise = bends + more, noise + louder
    return bends, noise


@scalar
def _corners_of(x, y, z, key, rising, c):
    """Corners of a triangle into c (3, 3), and rows and columns of its nodes into c (3, 3 : 5)."""
    cells = z.shape[1] - 1
    i, j = (key >> 1) // cells, (key >> 1) % cells
    second = key & 1 == 1

    # Where diagonals rise, both triangles have corners 0 and 2 of their cell, else 1 and 3.
    for k in range(3):
        if rising == 1:
            corner = (0 if k == 0 else k + 1) if second else k
        else:
            corner = k + 1 if second else (3 if k == 2 else k)
        row, column = i + (1 if corner >= 2 else 0), j + (1 if corner == 1 or corner == 2 else 0)
        c[k, 0], c[k, 1], c[k, 2] = node(x, row, column), node(y, row, column), z[row, column]
        c[k, 3], c[k, 4] = row, column


@scalar
def parameters_in(c, x):
    """Barycentric coordinates of a point in the plane of a triangle: those of corners 1 and 2."""
    return solve_tangents(
        c[1, 0] - c[0, 0], c[1, 1] - c[0, 1], c[1, 2] - c[0, 2],
        c[2, 0] - c[0, 0], c[2, 1] - c[0, 1], c[2, 2] - c[0, 2],
        x[0] - c[0, 0], x[1] - c[0, 1], x[2] - c[0, 2],
    )  # fmt: skip


@scalar
def on_lattice(x, y, z, key, rising, place, c, w, first):
    """Column and row of a point in a triangle of a lattice, into w[first : first + 2]."""
    _corners_of(x, y, z, key, rising, c)
    s, t = parameters_in(c, place)
    w[first] = c[0, 4] + s * (c[1, 4] - c[0, 4]) + t * (c[2, 4] - c[0, 4])
    w[first + 1] = c[0, 3] + s * (c[1, 3] - c[0, 3]) + t * (c[2, 3] - c[0, 3])


@scalar
def corners_of_face(x, t, face, origin, c):
    """World coordinates of the corners of a face into c (3, 3)."""
    for k in range(3):
        for axis in range(3):
            c[k, axis] = x[t[face, k], axis] + origin[axis]


@scalar
def _in_lines(rows):
    """Number of contacts that are lines."""
    n = 0
    for k in range(rows.shape[0]):
        n += 1 if n_corner_of(rows[k, HOW]) == 2 else 0
    return n


@scalar
def error_of_exact(
    xa, ya, za, xb, yb, zb, rising_a, rising_b, rows, ids, x, t, surface_of_face, key_of_face,
    origin, most, enough,
):  # fmt: skip
    """Largest error of the exact curves of two surfaces [m], noise at half of its segments [m], and
    two numbers.

    At most `most` segments are looked at; they are contacts as in `geosurf.arrangement.search`.
    The numbers are of segments that were measured, and of those astray. None was measured where
    less than half can be; segments next to holes do not count. Where some show an error above
    `enough` [m] and hardly any noise, no more are looked at, and noise is 0.
    """
    n_line = _in_lines(rows)
    step = max(1, (n_line + most - 1) // most)
    n = (n_line + step - 1) // step
    c = np.zeros((max(n, 1), 3, 3))
    surfaces = SurfacePair(xa, ya, za, xb, yb, zb, c)
    f, w, corners = np.empty(N_WORK), np.empty(4), np.empty((3, 5))
    measured, moved, loud, middle = np.empty((n, 7)), 0.0, 0.0, np.empty(3)
    line, tri, good, astray, unknown = -1, -1, 0, 0, 0
    for k in range(rows.shape[0]):
        if n_corner_of(rows[k, HOW]) != 2:
            continue
        line += 1
        if line % step != 0:
            continue
        tri += 1
        one, two = rows[k, 0], rows[k, 1]
        if surface_of_face[one] > 0:
            one, two = two, one
        for axis in range(3):
            middle[axis] = 0.5 * (x[ids[k, 0], axis] + x[ids[k, 1], axis]) + origin[axis]
        on_lattice(xa, ya, za, key_of_face[one], rising_a, middle, corners, w, 0)
        if zb.shape[0] > 1:
            on_lattice(xb, yb, zb, key_of_face[two], rising_b, middle, corners, w, 2)
        else:
            corners_of_face(x, t, two, origin, c[tri])
            w[2], w[3] = parameters_in(c[tri], middle)
        px, py, pz = middle[0], middle[1], middle[2]
        found = newton_in_plane(surfaces, tri, w, px, py, pz, 0.0, 0.0, 0.0, f)
        if found == LIFTED:
            differences_at(surfaces, w, f, measured[good])
            measured[good, 6] = f[F_SINE]
            if math.isnan(measured[good, 0] + measured[good, 3]):
                found = HOLE
        if found == HOLE:
            unknown += 1
        if found == LIFTED:
            dx, dy, dz = f[F_POINT] - px, f[F_POINT + 1] - py, f[F_POINT + 2] - pz
            moved = max(moved, math.sqrt(dx * dx + dy * dy + dz * dz))
            loud = max(loud, (measured[good, 2] + measured[good, 5]) / measured[good, 6])
            good += 1
            if good >= _SOME and 2.0 * moved > enough and loud < _HARDLY * enough:
                return 2.0 * moved, 0.0, 0.0, good, astray
        elif found == ASTRAY:
            astray += 1
    if good == 0 or 2 * good < n - unknown:
        return 0.0, 0.0, 0.0, 0, astray
    worst, noise = 0.0, np.empty(good)
    for k in range(good):
        total, noise[k] = error_at(measured, 0, k, 0, good)
        worst = max(worst, total)

    # halfway along a segment is not always where it is farthest, and others are not looked at
    noise = np.sort(noise)
    return 2.0 * moved + worst, noise[good // 2], noise[good - 1], good, astray
