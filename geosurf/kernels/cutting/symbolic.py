"""What the definitions of a face's points prove without arithmetic on the points themselves.

Letters as in `delaunay`. A line is the number of a plane that cuts the face, or a negative number
of a line found by arithmetic. Points proven to be collinear record that line, so that n points on
one line cost n proofs instead of one for each triple.
"""

from __future__ import annotations

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.exact.double_double import plane_is_level
from geosurf.kernels.exact.exact_signs import N_TRIANGLE, N_VERTEX
from geosurf.kernels.exact.predicates import coplanar_by_zeros, normal_axis, orient3d

POINTS, AXIS, LINES = 0, 2, 7  # of the state s
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
