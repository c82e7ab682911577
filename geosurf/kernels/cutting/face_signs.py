"""Signs of the local points of a face: turns and lexicographic order (circles: `face_circles`).

Letters as in `delaunay`. Each sign is computed in stages: doubles, definitions (`symbolic`),
double-doubles, integers. Each stage returns a certain sign or passes on to the next.
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
from geosurf.kernels.exact.constructed_points import (
    dd_add,
    dd_minor,
    dd_mul,
    plane_is_level,
    point_dd,
    two_sum,
)
from geosurf.kernels.exact.exact_signs import N_TRIANGLE, N_VERTEX
from geosurf.kernels.exact.predicates import (
    INCIRCLE_BOUND,
    ORIENT2D_BOUND,
    TINY,
    certified_sign,
    coplanar_by_zeros,
    normal_axis,
    orient3d,
)

# ---- symbolic ----------------------------------------
# What the definitions of a face's points prove without arithmetic on the points themselves.
#
# Letters as in `delaunay`. A line is the number of a plane that cuts the face, or a negative number
# of a line found by arithmetic. Points proven to be collinear record that line, so that n points on
# one line cost n proofs instead of one for each triple.


POINTS, TRIANGLES, AXIS, SEGMENT, FACE_ID, START, USED, LINES, SIDE = 0, 1, 2, 3, 4, 5, 6, 7, 8
# state of the known line: its number (-1: none), the plane that cuts its edges, and three vertices
# that span the plane of these edges
KNOWN_LINE, _SUPPORT, _ONE, _TWO, _THREE = 9, 10, 11, 12, 13
N_SEARCH = 14  # lines for which all points of the face were tested
_FIRST_LINE, _LAST_LINE = 4, 7
_MANY = 64  # faces with more points test all of them for the first lines found
_FEW = 4  # number of such lines


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
def collinear_by_planes(x, d, m, w, points, a, b, c):
    """Whether three points are intersections of edges of one plane with another plane.

    Then they are collinear. A fault that is flat in parts, or extruded, cuts large triangles in
    such points. Their line becomes the known line.
    """
    q, s = points.q, points.s
    n = m[N_VERTEX]
    # Vertices are not intersections of edges, whatever plane they lie in.
    if q[a, 0] < n or q[b, 0] < n or q[c, 0] < n:
        return False

    # All three have to be edges cut by the same plane.
    i, j, k = q[a, 0] - n, q[b, 0] - n, q[c, 0] - n
    if d[i, 0] != 1 or d[j, 0] != 1 or d[k, 0] != 1:
        return False
    if d[i, 3] != d[j, 3] or d[j, 3] != d[k, 3]:
        return False

    # Three vertices of the edges that span a plane.
    one, two, three = d[i, 1], d[i, 2], d[j, 1]
    if normal_axis(x, m, w, one, two, three)[0] < 0:  # on the line of the first edge
        three = d[j, 2]
        if normal_axis(x, m, w, one, two, three)[0] < 0:
            return False

    # All other ends of the edges have to lie in that plane.
    for o in (d[j, 1], d[j, 2], d[k, 1], d[k, 2]):
        if o not in (one, two, three) and not _of_plane(x, m, w, one, two, three, o):
            return False
    s[KNOWN_LINE] = record_line(q, s, a, b, c)
    s[_SUPPORT], s[_ONE], s[_TWO], s[_THREE] = d[i, 3], one, two, three
    if s[KNOWN_LINE] != -1 and s[POINTS] > _MANY and s[N_SEARCH] < _FEW:
        # one after the other, as they lie in memory; one by one costs a miss of the cache for each
        s[N_SEARCH] += 1
        for p in range(s[POINTS]):
            _put_on_known_line(x, d, m, w, points, p)
    return True


@scalar
def on_known_line(x, d, m, w, points, a, b, c):
    """Whether one of three points is proven to lie on the known line, as the other two do.

    Points of one line mostly come consecutively, so only the new one is tested.
    """
    q, s = points.q, points.s
    line = s[KNOWN_LINE]
    if line == -1:
        return False

    # Exactly two points on the line: test the third.
    on_a, on_b, on_c = _holds(q, a, line), _holds(q, b, line), _holds(q, c, line)
    if int(on_a) + int(on_b) + int(on_c) != 2:
        return False
    return _put_on_known_line(x, d, m, w, points, c if not on_c else (b if not on_b else a))


@scalar
def _put_on_known_line(x, d, m, w, points, p):
    """Whether a point is the intersection of an edge of the known plane with the other plane."""
    q, s = points.q, points.s
    row = q[p, 0] - m[N_VERTEX]
    if row < 0 or d[row, 0] != 1 or d[row, 3] != s[_SUPPORT]:
        return False

    # Both ends of its edge in the known plane.
    for o in (d[row, 1], d[row, 2]):
        if o not in (s[_ONE], s[_TWO], s[_THREE]) and not _of_plane(
            x, m, w, s[_ONE], s[_TWO], s[_THREE], o
        ):
            return False
    add_line(q, p, s[KNOWN_LINE])
    return True


@scalar
def _of_plane(x, m, w, one, two, three, o):
    """Whether vertex o lies in the plane of three others; extruded surfaces need no arithmetic."""
    if coplanar_by_zeros(x, one, two, three, o):
        return True
    return orient3d(x, m, w, one, two, three, o, 0.0) == 0


@scalar
def equal_by_construction(frame, points, a, b, second):
    """Whether two points have the same U (V with `second` = 1) by construction.

    This holds for two lines through planes of one height that coincide in a side view. Model grids
    and surfaces extruded along an axis have thousands of such points.
    """
    x, t, e, d, m = frame.x, frame.t, frame.e, frame.d, frame.m
    q, s = points.q, points.s
    n = m[N_VERTEX]
    if q[a, 0] < n or q[b, 0] < n:
        return False
    i, j = q[a, 0] - n, q[b, 0] - n
    if d[i, 0] != 1 or d[j, 0] != 1:
        return False

    # Both planes have to be constant on another axis, at the same height.
    axis = (s[AXIS] + 1 + second) % 3
    for r in range(1, 3):
        level = (axis + r) % 3
        # Each plane has to be flat on this axis, so that its intersections have that height.
        if not plane_is_level(x, t, e, m, d[i, 3], level):
            continue
        if not plane_is_level(x, t, e, m, d[j, 3], level):
            continue
        if _corner_of(x, t, e, m, d[i, 3], level) != _corner_of(x, t, e, m, d[j, 3], level):
            continue

        # The two edges have to agree in the projection along the third axis.
        one, two = d[i, 1], d[i, 2]
        # The second edge may run either way.
        for three, four in ((d[j, 1], d[j, 2]), (d[j, 2], d[j, 1])):
            if (
                x[one, level] == x[three, level]
                and x[two, level] == x[four, level]
                and x[one, axis] == x[three, axis]
                and x[two, axis] == x[four, axis]
            ):
                return True
    return False


@scalar
def _corner_of(x, t, e, m, p, axis):
    """A coordinate of the first vertex of plane p."""
    o = t[p, 0] if p < m[N_TRIANGLE] else e[p - m[N_TRIANGLE], 0]
    return x[o, axis]


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


# ---- face circles ----------------------------------------
# Circles through the local points of a face: is a fourth point inside? Ties are broken uniquely.
#
# Letters as in `delaunay`. The stages are those of `face_signs`: doubles, definitions,
# double-doubles, integers.


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
    """Side of the circle where doubles are undecided: definitions, double-doubles, integers."""
    # Four points of a grid lie on one circle: proven without the determinant.
    if _rectangle(frame, points, a, b, c, o):
        return 0
    sign = _incircle_dd(frame, points, a, b, c, o)
    if sign == 0:
        sign = cached_incircle(frame, points, a, b, c, o)
    return sign


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
    one, two = (c, o) if f[a, 0] == f[c, 0] else (o, c)  # `one` has the first coordinate of a
    if f[a, 0] != f[one, 0] or f[b, 0] != f[two, 0] or f[a, 1] != f[two, 1] or f[b, 1] != f[one, 1]:
        return False
    return (
        _equal(frame, points, a, one, 0)
        and _equal(frame, points, b, two, 0)
        and _equal(frame, points, a, two, 1)
        and _equal(frame, points, b, one, 1)
    )


@scalar
def _equal(frame, points, a, b, second):
    """Whether coordinates U or V with equal rounded values are equal."""
    f = points.f
    # Neither has an error on this axis: equal doubles are equal numbers.
    if f[a, 3 + second] == 0.0 and f[b, 3 + second] == 0.0:
        return True
    if equal_by_construction(frame, points, a, b, second):
        return True
    return cached_compare(frame, points, a, b, second) == 0


@scalar
def _incircle_dd(frame, points, a, b, c, o):
    """Sign of the determinant in double-doubles, 0 if undecided.

    The arithmetic has an error of less than 2**-95 of the terms: products of four factors, each
    with an error of at most 2**-100, and their sums. Errors of the points are those of
    `refine_point`.
    """
    f = points.f
    refine_point(frame, points, a)
    refine_point(frame, points, b)
    refine_point(frame, points, c)
    refine_point(frame, points, o)

    # Differences, minors and squared lengths, then their three products.
    au, aul, av, avl = difference(f, a, o)
    bu, bul, bv, bvl = difference(f, b, o)
    cu, cul, cv, cvl = difference(f, c, o)
    one, one_low = dd_minor(bu, bul, cv, cvl, cu, cul, bv, bvl)
    two, two_low = dd_minor(cu, cul, av, avl, au, aul, cv, cvl)
    three, three_low = dd_minor(au, aul, bv, bvl, bu, bul, av, avl)
    la, lal = dd_minor(au, aul, au, aul, av, avl, -av, -avl)
    lb, lbl = dd_minor(bu, bul, bu, bul, bv, bvl, -bv, -bvl)
    lc, lcl = dd_minor(cu, cul, cu, cul, cv, cvl, -cv, -cvl)
    det, low = dd_mul(la, lal, one, one_low)
    more, more_low = dd_mul(lb, lbl, two, two_low)
    det, low = dd_add(det, low, more, more_low)
    more, more_low = dd_mul(lc, lcl, three, three_low)
    det, low = dd_add(det, low, more, more_low)

    # Bound of the determinant from the sizes of all terms.
    # The terms are larger than their sum; the bound has to follow the terms.
    size = la * (abs(bu * cv) + abs(cu * bv))
    size += lb * (abs(cu * av) + abs(au * cv))
    size += lc * (abs(au * bv) + abs(bu * av))
    slip = f[a, 7] + f[b, 7] + f[c, 7] + f[o, 7]
    z = max(max(abs(au), abs(av)), max(max(abs(bu), abs(bv)), max(abs(cu), abs(cv))))
    bound = 2.0**-95 * size + _incircle_slip(z, slip)
    return certified_sign(det, bound) if size > TINY_DD else 0
