"""Signs of the local points of a face: turns and lexicographic order (circles: `face_circles`).

Letters as in `delaunay`. Each sign is computed in stages: doubles, definitions (`symbolic`),
integers. Each stage returns a certain sign or passes on to the next.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.cutting.cached_predicates import (
    cached_compare,
    cached_incircle,
    cached_orient2d,
)
from geosurf.kernels.exact.constructed_points import plane_is_level
from geosurf.kernels.exact.exact_signs import N_VERTEX
from geosurf.kernels.exact.predicates import INCIRCLE_BOUND, ORIENT2D_BOUND, TINY, certified_sign

# ---- symbolic ----------------------------------------
# What the definitions of a face's points prove without arithmetic on the points themselves.
#
# Letters as in `delaunay`. A line is the number of a plane that cuts the face, or a negative number
# of a line found by arithmetic. Points proven to be collinear record that line, so that n points on
# one line cost n proofs instead of one for each triple.


POINTS, TRIANGLES, AXIS, SEGMENT, FACE_ID, START, USED, LINES, SIDE = 0, 1, 2, 3, 4, 5, 6, 7, 8
_FIRST_LINE, _LAST_LINE = 4, 7


@scalar
def is_exact(frame, row, axis):
    """Whether a constructed point is exact on an axis: a plane or edge of it is constant there."""
    x, t, e, d, m = frame.x, frame.t, frame.e, frame.d, frame.m
    a, b, c = d[row, 1], d[row, 2], d[row, 3]
    # The whole edge, or the whole plane, has this coordinate.
    if d[row, 0] == 1:
        return x[a, axis] == x[b, axis] or plane_is_level(x, t, e, m, c, axis)
    return (
        plane_is_level(x, t, e, m, a, axis)
        or plane_is_level(x, t, e, m, b, axis)
        or plane_is_level(x, t, e, m, c, axis)
    )


@scalar
def _holds(q, p, line):
    """Whether a local point is known to lie on a line."""
    return q[p, 4] == line or q[p, 5] == line or q[p, 6] == line


@scalar
def add_line(q, p, line):
    """Record that a local point lies on a line; False if no slot is free."""
    for i in range(_FIRST_LINE, _LAST_LINE + 1):
        if q[p, i] == line:
            return True
        # Slots are filled in order: the first free one ends the list.
        if q[p, i] == -1:
            q[p, i] = line
            return True
    return False


@scalar
def _line_of(q, a, b):
    """A recorded line of both points, or -1."""
    for i in range(_FIRST_LINE, _LAST_LINE + 1):
        if q[a, i] != -1 and _holds(q, b, q[a, i]):
            return q[a, i]
    return -1


@scalar
def collinear_by_name(q, a, b, c):
    """Whether three local points share a recorded line."""
    for i in range(_FIRST_LINE, _LAST_LINE + 1):
        if q[a, i] != -1 and _holds(q, b, q[a, i]) and _holds(q, c, q[a, i]):
            return True
    return False


@scalar
def record_line(q, s, a, b, c):
    """Record that three distinct points are collinear; each gets the line that the others have.

    Returns the line, or -1 where no slot is free for a new one.
    """
    # Use a line that two of them share already.
    line = _line_of(q, a, b)
    if line == -1:
        line = _line_of(q, b, c)
    if line == -1:
        line = _line_of(q, c, a)
    if line == -1:
        if q[a, _LAST_LINE] != -1 or q[b, _LAST_LINE] != -1 or q[c, _LAST_LINE] != -1:
            return -1
        # Lines found by arithmetic have numbers below -1, planes from 0 on.
        line = -2 - s[LINES]
        s[LINES] += 1
    add_line(q, a, line)
    add_line(q, b, line)
    add_line(q, c, line)
    return line


N_STATE = 9
_HALF_ULP = 1.12e-16
_LEAST = 5e-324  # absolute rounding error below the least normal number


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
    # No cached integers, no segment, no line.
    q[p, 0], q[p, 1], q[p, 2], q[p, 3] = i, bits, -1, -1
    q[p, 4], q[p, 5], q[p, 6], q[p, 7] = -1, -1, -1, -1
    f[p, 0], f[p, 1] = x[i, (s[AXIS] + 1) % 3], x[i, (s[AXIS] + 2) % 3]
    f[p, 2], f[p, 3], f[p, 4] = 0.0, 0.0, 0.0
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
    """Sign of a turn where doubles are undecided: definitions, then integers."""
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

    # Integers; a new collinear triple is recorded.
    sign = cached_orient2d(frame, points, a, b, c)
    if sign == 0:
        record_line(q, s, a, b, c)
    return sign


@scalar
def precedes(frame, points, a, b):
    """Whether local point a comes before b, by u and then v."""
    f = points.f
    for i in range(2):
        if f[a, i] != f[b, i]:
            return f[a, i] < f[b, i]

        # Equal after rounding: the integers decide.
        if f[a, 3 + i] > 0.0 or f[b, 3 + i] > 0.0:
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


# ---- face circles ----------------------------------------
# Circles through the local points of a face: is a fourth point inside? Ties are broken uniquely.
#
# Letters as in `delaunay`. The stages are those of `face_signs`: doubles, definitions, integers.


@scalar
def in_circle(frame, points, a, b, c, o):
    """Whether o is inside the circle of a, b, c; a tie is decided by the lowest of the four."""
    f = points.f
    sign = filtered_circle(f, a, b, c, o)
    if sign == 0:
        return exact_in_circle(frame, points, a, b, c, o)
    return sign > 0


@scalar
def exact_in_circle(frame, points, a, b, c, o):
    """Whether o is inside the circle of a, b, c, where doubles are undecided."""
    sign = exact_circle(frame, points, a, b, c, o)
    if sign != 0:
        return sign > 0
    # the current diagonal is a-b, the other one c-o
    # A tie: the diagonal at the lowest point wins.
    lowest_end = a if precedes(frame, points, a, b) else b
    other = c if precedes(frame, points, c, o) else o
    return precedes(frame, points, other, lowest_end)


@scalar
def filtered_circle(f, a, b, c, o):
    """Sign > 0 where o is inside the circle of counter-clockwise a, b, c; 0 if undecided.

    With a single array, for the same reason as `filtered_turn`.
    """
    # The determinant relative to o, which removes one row.
    au, av = f[a, 0] - f[o, 0], f[a, 1] - f[o, 1]
    bu, bv = f[b, 0] - f[o, 0], f[b, 1] - f[o, 1]
    cu, cv = f[c, 0] - f[o, 0], f[c, 1] - f[o, 1]
    la, lb, lc = au * au + av * av, bu * bu + bv * bv, cu * cu + cv * cv
    p, r = bu * cv, cu * bv
    g, y = cu * av, au * cv
    i, j = au * bv, bu * av
    det = la * (p - r) + lb * (g - y) + lc * (i - j)
    size = la * (abs(p) + abs(r)) + lb * (abs(g) + abs(y)) + lc * (abs(i) + abs(j))

    # The bound: rounding of the arithmetic, then errors of the points.
    # Vertices have no error, so most faces skip this term.
    slip = f[a, 2] + f[b, 2] + f[c, 2] + f[o, 2]
    bound = INCIRCLE_BOUND * size
    if slip > 0.0:
        z = max(max(abs(au), abs(av)), max(max(abs(bu), abs(bv)), max(abs(cu), abs(cv))))
        bound += _incircle_slip(z, slip)
    return certified_sign(det, bound) if size > TINY else 0


@scalar
def exact_circle(frame, points, a, b, c, o):
    """Side of the circle where doubles are undecided: definitions, then integers."""
    # Four points of a grid lie on one circle: proven without the determinant.
    if _rectangle(frame, points, a, b, c, o):
        return 0
    return cached_incircle(frame, points, a, b, c, o)


@scalar
def _incircle_slip(z, slip):
    """Error of the determinant for differences of size <= z with errors below slip.

    It has twelve terms of degree four in these differences.
    """
    return (
        1.1
        * slip
        * (z * (z * (48.0 * z + 72.0 * slip) + 48.0 * slip * slip) + 12.0 * slip * slip * slip)
    )


@scalar
def _rectangle(frame, points, a, b, c, o):
    """Whether a-b and c-o are the diagonals of an axis-parallel rectangle.

    Model grids contain many; equal coordinates are cheaper to prove than one circle.
    """
    f = points.f
    # Which of c, o shares the first coordinate with a, by rounded values.
    beside_a, beside_b = (
        (c, o) if f[a, 0] == f[c, 0] else (o, c)
    )  # `one` has the first coordinate of a
    if (
        f[a, 0] != f[beside_a, 0]
        or f[b, 0] != f[beside_b, 0]
        or f[a, 1] != f[beside_b, 1]
        or f[b, 1] != f[beside_a, 1]
    ):
        return False
    return (
        _equal(frame, points, a, beside_a, 0)
        and _equal(frame, points, b, beside_b, 0)
        and _equal(frame, points, a, beside_b, 1)
        and _equal(frame, points, b, beside_a, 1)
    )


@scalar
def _equal(frame, points, a, b, second):
    """Whether coordinates U or V with equal rounded values are equal."""
    f = points.f
    # Neither has an error on this axis: equal doubles are equal numbers.
    if f[a, 3 + second] == 0.0 and f[b, 3 + second] == 0.0:
        return True
    return cached_compare(frame, points, a, b, second) == 0
