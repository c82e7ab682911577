"""Signs of the local points of a face: turns and lexicographic order (circles: `face_circles`).

Letters as in `delaunay`. Each sign is computed in stages: doubles, definitions (`symbolic`),
double-doubles, integers. Each stage returns a certain sign or passes on to the next.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.cutting.cached_predicates import cached_compare, cached_orient2d
from geosurf.kernels.cutting.symbolic import (
    collinear_by_name,
    collinear_by_planes,
    equal_by_construction,
    is_exact,
    on_known_line,
    record_line,
)
from geosurf.kernels.exact.double_double import dd_minor, point_dd, two_sum
from geosurf.kernels.exact.exact_signs import N_VERTEX
from geosurf.kernels.exact.predicates import ORIENT2D_BOUND, TINY, certified_sign

POINTS, TRIANGLES, AXIS, SEGMENT, FACE_ID, START, USED, LINES, SIDE = 0, 1, 2, 3, 4, 5, 6, 7, 8
N_STATE = 15  # with the known line of `symbolic`
_HALF_ULP = 1.12e-16
_LEAST = 5e-324  # absolute rounding error below the least normal number
TINY_DD = 1e-180  # below it low parts of products may underflow


class FacePoints(NamedTuple):
    """The local points of one face: see the notation of `delaunay`."""

    q: np.ndarray  # integers of each point: id, edges, cache row, lines
    f: np.ndarray  # coordinates of each point and their errors
    s: np.ndarray  # state of the face


@scalar
def _half_ulp(coordinate):
    """Largest distance of a coordinate from its exact value; 0.0 is always exact."""
    return max(_HALF_ULP * abs(coordinate), _LEAST) if coordinate != 0.0 else 0.0


@scalar
def add_corner(x, q, f, s, i, bits):
    """Add a local point for id i that is exact: a vertex; returns its local index."""
    p = s[POINTS]
    s[POINTS] = p + 1
    # No cached integers, no segment, no known line.
    q[p, 0], q[p, 1], q[p, 2], q[p, 3] = i, bits, -1, -1
    q[p, 4], q[p, 5], q[p, 6], q[p, 7] = -1, -1, -1, -1
    f[p, 0], f[p, 1] = x[i, (s[AXIS] + 1) % 3], x[i, (s[AXIS] + 2) % 3]
    f[p, 2], f[p, 3], f[p, 4] = 0.0, 0.0, 0.0
    f[p, 5], f[p, 6], f[p, 7] = 0.0, 0.0, 0.0
    return p


@scalar
def add_local(frame, points, i, bits):
    """Add a local point for global id i; returns its local index."""
    x, m = frame.x, frame.m
    q, f, s = points.q, points.f, points.s
    p = add_corner(x, q, f, s, i, bits)

    # Constructed points carry the error of their rounding, unless a definition is exact.
    row = i - m[N_VERTEX]
    if row >= 0:
        if not is_exact(frame, row, (s[AXIS] + 1) % 3):
            f[p, 3] = _half_ulp(f[p, 0])
        if not is_exact(frame, row, (s[AXIS] + 2) % 3):
            f[p, 4] = _half_ulp(f[p, 1])
        f[p, 2] = max(f[p, 3], f[p, 4])
        # Low parts are computed on first use; a point that is exact needs none.
        if f[p, 2] > 0.0:
            f[p, 7] = -1.0
    return p


@scalar
def filtered_turn(f, a, b, c):
    """Sign of the turn of local points a, b, c; 0 if doubles are undecided.

    With a single array it is inlined. Calls with nine arrays take longer than this sign, so loops
    with many turns call this first and `exact_turn` where it returns 0.
    """
    bu, bv = f[b, 0] - f[a, 0], f[b, 1] - f[a, 1]
    cu, cv = f[c, 0] - f[a, 0], f[c, 1] - f[a, 1]
    left = bu * cv
    right = bv * cu
    det = left - right
    size = abs(left) + abs(right)

    # The bound: rounding of the arithmetic, then errors of the points.
    slip = f[a, 2] + f[b, 2] + f[c, 2]
    span = abs(bu) + abs(bv) + abs(cu) + abs(cv)
    # Both differences of each product may be off by the errors of two points.
    bound = ORIENT2D_BOUND * size + slip * (1.01 * span + 2.1 * slip)
    return certified_sign(det, bound) if size > TINY else 0


@scalar
def turn(frame, points, a, b, c):
    """Sign of the turn of local points a, b, c."""
    f = points.f
    sign = filtered_turn(f, a, b, c)
    if sign == 0:
        sign = exact_turn(frame, points, a, b, c)
    return sign


@scalar
def exact_turn(frame, points, a, b, c):
    """Sign of a turn where doubles are undecided: definitions, double-doubles, integers."""
    x, d, m, w = frame.x, frame.d, frame.m, frame.w
    q, f, s = points.q, points.f, points.s

    # Collinear by definition: equal points, one edge of the face, one recorded line.
    # The cheapest proofs come first: faces with thousands of collinear points stay fast.
    if a == b or b == c or a == c:
        return 0
    if q[a, 1] & q[b, 1] & q[c, 1] != 0:
        return 0  # three points of one edge of the face, by name
    if collinear_by_name(q, a, b, c):
        return 0
    for i in range(2):  # three points on a line of the grid, all known exactly on that axis
        if (
            f[a, 3 + i] + f[b, 3 + i] + f[c, 3 + i] == 0.0
            and f[a, i] == f[b, i]
            and f[b, i] == f[c, i]
        ):
            return 0
    if on_known_line(x, d, m, w, points, a, b, c) or collinear_by_planes(
        x, d, m, w, points, a, b, c
    ):
        return 0

    # Double-doubles, then integers; a new collinear triple is recorded.
    sign = _turn_dd(frame, points, a, b, c)
    if sign == 0:
        sign = cached_orient2d(frame, points, a, b, c)
    if sign == 0:
        record_line(q, s, a, b, c)
    return sign


@scalar
def _turn_dd(frame, points, a, b, c):
    """Sign of a turn in double-doubles, 0 if undecided.

    The arithmetic has an error of less than 2**-98 of the terms of the determinant. Errors of the
    points enter as in `filtered_turn`, each bounded by `refine_point`.
    """
    f = points.f
    refine_point(frame, points, a)
    refine_point(frame, points, b)
    refine_point(frame, points, c)

    # The determinant of the two differences, as in `filtered_turn`.
    bu, bul, bv, bvl = difference(f, b, a)
    cu, cul, cv, cvl = difference(f, c, a)
    det, _ = dd_minor(bu, bul, cv, cvl, bv, bvl, cu, cul)
    size = abs(bu * cv) + abs(bv * cu)
    slip = f[a, 7] + f[b, 7] + f[c, 7]
    span = abs(bu) + abs(bv) + abs(cu) + abs(cv)
    bound = 2.0**-98 * size + slip * (1.01 * span + 2.1 * slip)
    return certified_sign(det, bound) if size > TINY_DD else 0


@scalar
def difference(f, b, a):
    """b - a for refined local points: u (high, low), v (high, low)."""
    u, ul = two_sum(f[b, 0], -f[a, 0])
    v, vl = two_sum(f[b, 1], -f[a, 1])
    # low parts may exceed a small difference: normalise, so that u and v are double-doubles
    u, ul = two_sum(u, ul + (f[b, 5] - f[a, 5]))
    v, vl = two_sum(v, vl + (f[b, 6] - f[a, 6]))
    return u, ul, v, vl


@scalar
def refine_point(frame, points, p):
    """Compute the low parts of the coordinates of a point, once.

    The bound includes 2**-52 of the low part, which is rounded itself, and 2**-103 of the
    coordinates, for the sums in `difference`.
    """
    x, t, e, d, m = frame.x, frame.t, frame.e, frame.d, frame.m
    q, f, s = points.q, points.f, points.s
    # Computed before, or exact.
    if f[p, 7] >= 0.0:
        return

    # The full value in double-double, minus the stored rounded coordinates.
    row = q[p, 0] - m[N_VERTEX]
    known, at, low, slack = point_dd(x, t, e, m, d[row, 0], d[row, 1], d[row, 2], d[row, 3])
    u, v = (s[AXIS] + 1) % 3, (s[AXIS] + 2) % 3
    # Double-double may round to a neighbouring double: the step to it goes into the low part.
    low_u, low_v = (at[u] - f[p, 0]) + low[u], (at[v] - f[p, 1]) + low[v]
    bound = max(slack[u], slack[v]) + 2.0**-52 * max(abs(low_u), abs(low_v))

    # Without a better bound the rounding error of the coordinate is used.
    f[p, 5], f[p, 6], f[p, 7] = 0.0, 0.0, f[p, 2]
    if known and bound < f[p, 2]:
        f[p, 5], f[p, 6] = low_u, low_v
        f[p, 7] = bound + 2.0**-103 * max(abs(f[p, 0]), abs(f[p, 1]))


@scalar
def precedes(frame, points, a, b):
    """Whether local point a comes before b, by u and then v."""
    f = points.f
    for i in range(2):
        if f[a, i] != f[b, i]:
            return f[a, i] < f[b, i]

        # Equal after rounding: by definition, by low parts, by integers.
        if f[a, 3 + i] > 0.0 or f[b, 3 + i] > 0.0:
            if equal_by_construction(frame, points, a, b, i):
                continue
            refine_point(frame, points, a)
            refine_point(frame, points, b)
            gap = f[a, 5 + i] - f[b, 5 + i]
            # Low parts decide unless their errors could exchange the points.
            if abs(gap) > 1.01 * (f[a, 7] + f[b, 7]):
                return gap < 0.0
            order = cached_compare(frame, points, a, b, i)
            if order != 0:
                return order < 0
    return False


@scalar
def same_direction(frame, points, a, b, p, o):
    """Whether p to o has the direction of a to b, for points of one line of the face.

    Rounding preserves order: different rounded coordinates on an axis decide.
    """
    f = points.f
    for i in range(2):
        if f[a, i] != f[b, i] and f[p, i] != f[o, i]:
            return (f[a, i] < f[b, i]) == (f[p, i] < f[o, i])

    # Points that round to one place: the exact order decides.
    ahead = precedes(frame, points, a, b)
    return precedes(frame, points, p, o) == ahead
