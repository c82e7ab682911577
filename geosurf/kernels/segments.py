"""Segments into a triangulated face: cavities, crossings, constraints.

A segment is inserted by cavity: the crossed triangles are removed and both sides, seen from
the segment, are triangulated in linear time by Graham's scan (Toussaint & Avis 1982), since
flipping (Sloan 1993) is quadratic in the number of crossed edges. Where it crosses a
constraint, a point is constructed there: three planes, or an edge and a plane. Notation as
in `delaunay`; a, b are the ends of the segment under way.
"""

from __future__ import annotations

from geosurf.kernels._jit import scalar
from geosurf.kernels.byname import add_line
from geosurf.kernels.delaunay import following, link, preceding, put, split_edge
from geosurf.kernels.exact import N_TRIANGLE
from geosurf.kernels.points import FULL, LPI, TPI, named_point
from geosurf.kernels.signs import (
    FACE_ID,
    POINTS,
    SEGMENT,
    TRIANGLES,
    add_local,
    same_way,
    turn,
)


@scalar
def _crossing(x, t, e, d, m, w, names, places, s, one, two):
    """Id of the point of the face where constraints with two support planes cross."""
    face = s[FACE_ID]
    n = m[N_TRIANGLE]
    if one >= n:  # an edge in the face: the line is the edge itself
        return named_point(x, t, e, d, m, w, names, places, LPI, e[one - n, 0], e[one - n, 1], two)
    if two >= n:
        return named_point(x, t, e, d, m, w, names, places, LPI, e[two - n, 0], e[two - n, 1], one)
    return named_point(x, t, e, d, m, w, names, places, TPI, face, one, two)


@scalar
def _side(x, t, e, d, m, w, q, f, s, a, b, p):
    """Side of p of the line of the segment under way, from a to b."""
    if q[p, 3] == s[SEGMENT]:
        return 0
    return turn(x, t, e, d, m, w, q, f, s, a, b, p)


@scalar
def _first_crossed(x, t, e, d, m, w, h, q, f, s, a, b, p, goal):
    """From p towards goal: (half-edge crossed, -1), or (half-edge along the line, its far end)."""
    start = q[p, 2]
    i = start
    forward = True
    while True:
        y, z = h[following(i), 0], h[preceding(i), 0]
        if y == goal:
            return i, y
        if z == goal:
            return preceding(i), z
        sy = _side(x, t, e, d, m, w, q, f, s, a, b, y)
        if sy == 0 and same_way(x, t, e, d, m, w, q, f, s, a, b, p, y):
            return i, y
        sz = _side(x, t, e, d, m, w, q, f, s, a, b, z)
        if sz == 0 and same_way(x, t, e, d, m, w, q, f, s, a, b, p, z):
            return preceding(i), z
        if sy < 0 and sz > 0:
            return following(i), -1
        if forward:
            i = h[preceding(i), 1]
            if i < 0:
                forward = False
                i = start
            elif i == start:
                return -1, -1
        if not forward:
            i = h[i, 1]
            if i < 0:
                return -1, -1
            i = following(i)


@scalar
def _fan(x, t, e, d, m, w, h, q, f, s, k, low, high, free, tri):
    """Triangulate the chain k[low:high] seen from its base: (base half-edge, next triangle).

    Rows of k: point, twin and support of the link to the next row, old half-edge of
    the link. Triangles are written to the slots k[free + n, 3]. Graham's scan, the stack at `low`.
    """
    top = low
    for c in range(low + 1, high):
        point, twin, support, old = k[c, 0], k[c, 1], k[c, 2], k[c, 3]
        while top > low and turn(x, t, e, d, m, w, q, f, s, k[top - 1, 0], k[top, 0], point) > 0:
            slot = k[free + tri, 3]
            tri += 1
            i = 3 * slot
            put(h, q, slot, k[top - 1, 0], k[top, 0], point)
            _join(h, i, k[top - 1, 1], k[top - 1, 2], k[top - 1, 3])
            _join(h, i + 1, k[top, 1], k[top, 2], k[top, 3])
            top -= 1
            k[top, 1], k[top, 2], k[top, 3] = i + 2, -1, -1
        top += 1
        k[top, 0], k[top, 1], k[top, 2], k[top, 3] = point, twin, support, old
    return k[low, 1], tri


@scalar
def _join(h, i, twin, support, old):
    """Link a new half-edge to what lies behind its link; note where an old one went."""
    link(h, i, twin, support)
    if old >= 0:
        h[old, 3] = i


@scalar
def _push_link(h, k, n, point, i):
    """Chain row: point, and the link that old half-edge i makes to the next row."""
    k[n, 0], k[n, 1], k[n, 2], k[n, 3] = point, h[i, 1], h[i, 2], i


@scalar
def _dig(x, t, e, d, m, w, h, q, f, s, k, p, first, a, b, goal, support):
    """Insert the constraint from p across half-edge `first` on to the next point of the line.

    Returns (point reached, -1), or (-1, constrained half-edge) where one has to be split first.
    """
    # corridor: crossed half-edges, right end to left end, in k[:, 0]
    n = 0
    i = first
    while True:
        if h[i, 2] >= 0:
            return -1, i
        k[n, 0] = i
        n += 1
        j = h[i, 1]
        apex = h[preceding(j), 0]
        side = 0 if apex == goal else _side(x, t, e, d, m, w, q, f, s, a, b, apex)
        if side == 0:
            break
        i = preceding(j) if side < 0 else following(j)
    reached = apex
    # chains, counter-clockwise: left one from `reached` to p, right one from p to `reached`
    left = n + 2
    right = left + n + 3
    free = right + n + 3
    _push_link(h, k, right, p, preceding(k[0, 0]))
    k[left + n + 1, 0] = p  # the left chain is filled from behind
    nl = n
    _push_link(h, k, left + nl, h[following(k[0, 0]), 0], following(k[0, 0]))
    nr = 1
    k[right + nr, 0] = h[k[0, 0], 0]
    k[free, 3] = k[0, 0] // 3
    for c in range(n):
        i = k[c, 0]
        j = h[i, 1]
        k[free + c + 1, 3] = j // 3
        y, z = following(j), preceding(j)  # y: right end -> apex, z: apex -> left end
        onward = k[c + 1, 0] if c + 1 < n else -1
        if onward != y:  # the edge y is on the right border
            _push_link(h, k, right + nr, h[i, 0], y)
            nr += 1
            k[right + nr, 0] = h[z, 0]
        if onward != z:
            nl -= 1
            _push_link(h, k, left + nl, h[z, 0], z)
    high_right = right + nr + 1
    low_left = left + nl
    k[right + nr, 1], k[right + nr, 2], k[right + nr, 3] = -1, -1, -1
    k[left + n + 1, 1], k[left + n + 1, 2], k[left + n + 1, 3] = -1, -1, -1
    for c in range(n + 1):  # a link may lead back into the corridor: mark its triangles
        slot = k[free + c, 3]
        h[3 * slot, 3] = h[3 * slot + 1, 3] = h[3 * slot + 2, 3] = -2
    inner = 0
    for c in range(low_left, left + n + 1):
        inner += 1 if k[c, 1] >= 0 and h[k[c, 1], 3] == -2 else 0
    for c in range(right, high_right - 1):
        inner += 1 if k[c, 1] >= 0 and h[k[c, 1], 3] == -2 else 0
    behind = free + n + 2
    if inner > 0:
        inner = _note_inner(h, k, low_left, left + n + 1, behind, 0)
        inner = _note_inner(h, k, right, high_right - 1, behind, inner)
    one, tri = _fan(x, t, e, d, m, w, h, q, f, s, k, low_left, left + n + 2, free, 0)
    two, tri = _fan(x, t, e, d, m, w, h, q, f, s, k, right, high_right, free, tri)
    link(h, one, two, support)
    for c in range(inner):
        link(h, h[k[behind + c, 0], 3], h[k[behind + c, 1], 3], k[behind + c, 2])
    for c in range(n + 1):
        slot = k[free + c, 3]
        h[3 * slot, 3] = h[3 * slot + 1, 3] = h[3 * slot + 2, 3] = 0
    return reached, -1


@scalar
def _note_inner(h, k, low, high, behind, n):
    """Links whose other side is a link of the same corridor: cut them, to be joined later."""
    for c in range(low, high):
        if k[c, 1] >= 0 and h[k[c, 1], 3] == -2:
            if k[c, 3] < k[c, 1]:
                k[behind + n, 0], k[behind + n, 1], k[behind + n, 2] = k[c, 3], k[c, 1], k[c, 2]
                n += 1
            k[c, 1] = -1
    return n


@scalar
def _turned(h, start, i, way):
    """The next half-edge around the origin of i, and the way of turning; way 0: all were seen."""
    if way > 0:
        i = h[preceding(i), 1]
        if i == start:
            return i, 0
        if i >= 0:
            return i, 1
        i = start  # the border: the rest, the other way round
    i = h[i, 1]
    if i < 0:
        return i, 0
    return following(i), -1


@scalar
def _has_fewer(h, q, a, b):
    """Whether no more triangles meet at point a than at b, by turning around both at once."""
    i, j = q[a, 2], q[b, 2]
    one = two = 1
    while True:
        i, one = _turned(h, q[a, 2], i, one)
        if one == 0:
            return True
        j, two = _turned(h, q[b, 2], j, two)
        if two == 0:
            return False


@scalar
def _advance(x, t, e, d, m, w, names, places, h, q, f, s, k, a, b, p, other, support):
    """Constrain the line from a to b, from its point p to the next one towards `other`.

    Returns that point; -1 if there is none, which breaks a promise; FULL.
    """
    goal = other
    while True:
        i, far = _first_crossed(x, t, e, d, m, w, h, q, f, s, a, b, p, goal)
        if i < 0:
            return -1
        if far >= 0:
            if h[i, 2] < 0 and h[i, 1] >= 0:
                link(h, i, h[i, 1], support)
            return far
        reached, wall = _dig(x, t, e, d, m, w, h, q, f, s, k, p, i, a, b, goal, support)
        if wall < 0:
            return reached
        if s[POINTS] >= q.shape[0] or 3 * (s[TRIANGLES] + 2) > h.shape[0]:
            return FULL
        number = _crossing(x, t, e, d, m, w, names, places, s, support, h[wall, 2])
        if number == FULL:
            return FULL
        goal = add_local(x, t, e, d, m, q, f, s, number, 0)
        add_line(q, goal, support)
        add_line(q, goal, h[wall, 2])
        q[goal, 3] = s[SEGMENT]
        split_edge(h, q, s, wall, goal)


@scalar
def insert_segment(x, t, e, d, m, w, names, places, h, q, f, s, k, a, b, support):
    """Make the segment of local points a, b a chain of constraints; FULL, -1 (broken) or 0.

    From both ends, always where fewer triangles meet: thousands of segments with one end in common,
    or through one point, would search all around it each time.
    """
    s[SEGMENT] += 1
    q[a, 3] = q[b, 3] = s[SEGMENT]
    low, high = a, b
    while low != high:
        upward = _has_fewer(h, q, low, high)
        p, other = (low, high) if upward else (high, low)
        one, two = (a, b) if upward else (b, a)
        p = _advance(x, t, e, d, m, w, names, places, h, q, f, s, k, one, two, p, other, support)
        if p < 0:
            return p
        q[p, 3] = s[SEGMENT]
        if upward:
            low = p
        else:
            high = p
    return 0
