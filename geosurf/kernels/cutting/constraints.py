"""Segments into a triangulated face: cavities, crossings, constraints.

A segment is inserted by cavity (see `cavity`), since flipping its way free (Sloan 1993) is
quadratic in the number of crossed edges. Where it crosses a
constraint, a point is constructed there: three planes, or an edge and a plane. Notation as
in `delaunay`; a, b are the ends of the segment under way.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.cutting.cavity import insert_by_cavity, side_of_segment
from geosurf.kernels.cutting.delaunay import link, next_half_edge, previous_half_edge, split_edge
from geosurf.kernels.cutting.face_signs import (
    FACE_ID,
    POINTS,
    SEGMENT,
    TRIANGLES,
    add_local,
    same_direction,
)
from geosurf.kernels.cutting.symbolic import add_line
from geosurf.kernels.exact.constructed_points import FULL, LPI, TPI, id_of_coordinates, named_point
from geosurf.kernels.exact.exact_signs import COLLISIONS, N_NAME, N_TRIANGLE, UNINDEXED


@scalar
def _index_points(frame, names, places):
    """Enter the points that were there before, all distinct, into the table of places, once.

    Most scenes make no more points, and then need no tables: both are emptied here.
    """
    m = frame.m
    if m[UNINDEXED] == 0:
        return
    collisions = m[COLLISIONS]
    m[N_NAME] = 0
    for slot in range(names.shape[0]):
        names[slot, 0] = 0
    for slot in range(places.shape[0]):
        places[slot] = -1
    for i in range(m[UNINDEXED]):
        id_of_coordinates(frame, places, i)
    m[UNINDEXED], m[COLLISIONS] = 0, collisions


@scalar
def _crossing(frame, names, places, s, one, two):
    """Id of the point of the face where constraints with two support planes cross."""
    e, m = frame.e, frame.m
    _index_points(frame, names, places)
    face = s[FACE_ID]
    n = m[N_TRIANGLE]
    if one >= n:  # an edge in the face: the line is the edge itself
        return named_point(frame, names, places, LPI, e[one - n, 0], e[one - n, 1], two)
    if two >= n:
        return named_point(frame, names, places, LPI, e[two - n, 0], e[two - n, 1], one)
    return named_point(frame, names, places, TPI, face, one, two)


@scalar
def _first_crossed(frame, mesh, points, a, b, p, goal):
    """From p towards goal: (half-edge crossed, -1), or (half-edge along the line, its far end)."""
    h, v = mesh.h, mesh.v
    start = v[p]
    i = start
    forward = True
    while True:
        y, z = h[next_half_edge(i), 0], h[previous_half_edge(i), 0]
        if y == goal:
            return i, y
        if z == goal:
            return previous_half_edge(i), z
        sy = side_of_segment(frame, points, a, b, y)
        if sy == 0 and same_direction(frame, points, a, b, p, y):
            return i, y
        sz = side_of_segment(frame, points, a, b, z)
        if sz == 0 and same_direction(frame, points, a, b, p, z):
            return previous_half_edge(i), z
        if sy < 0 and sz > 0:
            return next_half_edge(i), -1
        if forward:
            i = h[previous_half_edge(i), 1]
            if i < 0:
                forward = False
                i = start
            elif i == start:
                return -1, -1
        if not forward:
            i = h[i, 1]
            if i < 0:
                return -1, -1
            i = next_half_edge(i)


@scalar
def _rotate(h, start, i, sense):
    """The next half-edge around the origin of i, and the way of turning; way 0: all were seen."""
    if sense > 0:
        i = h[previous_half_edge(i), 1]
        if i == start:
            return i, 0
        if i >= 0:
            return i, 1
        i = start  # the border: the rest, the other way round
    i = h[i, 1]
    if i < 0:
        return i, 0
    return next_half_edge(i), -1


@scalar
def _edge_around(h, i, a, b):
    """The half-edge between points a and b in the triangle of i, which starts at a, or -1."""
    if h[next_half_edge(i), 0] == b:
        return i
    return previous_half_edge(i) if h[previous_half_edge(i), 0] == b else -1


@scalar
def constrain_edge(h, v, a, b, support):
    """Whether points a and b are the ends of an edge, which then becomes a constraint.

    Triangles around both are looked at by turns, so that the smaller number of them counts.
    """
    i, j = v[a], v[b]
    one = two = 1
    while one != 0 and two != 0:
        edge = _edge_around(h, i, a, b)
        if edge < 0:
            edge = _edge_around(h, j, b, a)
        if edge >= 0:
            _constrain(h, edge, support)
            return True
        i, one = _rotate(h, v[a], i, one)
        j, two = _rotate(h, v[b], j, two)
    return False


@scalar
def _constrain(h, i, support):
    """Make the edge of half-edge i a constraint, unless it is one or lies on the border."""
    if h[i, 2] < 0 and h[i, 1] >= 0:
        link(h, i, h[i, 1], support)


@scalar
def _has_lower_degree(h, v, a, b):
    """Whether no more triangles meet at point a than at b, by turning around both at once."""
    i, j = v[a], v[b]
    one = two = 1
    while True:
        i, one = _rotate(h, v[a], i, one)
        if one == 0:
            return True
        j, two = _rotate(h, v[b], j, two)
        if two == 0:
            return False


@scalar
def _constrain_next(frame, names, places, mesh, points, a, b, p, other, support):
    """Constrain the line from a to b, from its point p to the next one towards `other`.

    Returns that point; -1 if there is none, which breaks a promise; FULL.
    """
    q, s = points.q, points.s
    h, v = mesh.h, mesh.v
    goal = other
    while True:
        i, far = _first_crossed(frame, mesh, points, a, b, p, goal)
        if i < 0:
            return -1
        if far >= 0:
            _constrain(h, i, support)
            return far
        reached, wall = insert_by_cavity(frame, mesh, points, p, i, a, b, goal, support)
        if wall < 0:
            return reached
        if s[POINTS] >= q.shape[0] or 3 * (s[TRIANGLES] + 2) > h.shape[0]:
            return FULL
        number = _crossing(frame, names, places, s, support, np.int64(h[wall, 2]))
        if number == FULL:
            return FULL
        goal = add_local(frame, points, number, 0)
        add_line(q, goal, support)
        add_line(q, goal, h[wall, 2])
        q[goal, 3] = s[SEGMENT]
        split_edge(h, v, s, wall, goal)


@scalar
def insert_segment(frame, names, places, mesh, points, a, b, support):
    """Make the segment of local points a, b a chain of constraints; FULL, -1 (broken) or 0.

    From both ends, always where fewer triangles meet: thousands of segments with one end in common,
    or through one point, would search all around it each time.
    """
    q, s = points.q, points.s
    h, v = mesh.h, mesh.v
    s[SEGMENT] += 1
    q[a, 3] = q[b, 3] = s[SEGMENT]
    low, high = a, b
    while low != high:
        upward = _has_lower_degree(h, v, low, high)
        p, other = (low, high) if upward else (high, low)
        one, two = (a, b) if upward else (b, a)
        p = _constrain_next(frame, names, places, mesh, points, one, two, p, other, support)
        if p < 0:
            return p
        q[p, 3] = s[SEGMENT]
        if upward:
            low = p
        else:
            high = p
    return 0
