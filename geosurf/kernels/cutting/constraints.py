"""Segments become constrained edges of a triangulated face, with their crossings.

A segment is inserted by cavity (see `cavity`); flipping the crossed edges (Sloan 1993) would be
quadratic in their number. Where it crosses another constraint, a point is constructed: three
planes, or an edge and a plane. Notation as in `delaunay`; a, b are the ends of the current segment.
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
from geosurf.kernels.exact.constructed_points import (
    FULL,
    LPI,
    TPI,
    id_of_coordinates,
    insert_name,
    named_point,
    slot_of,
)
from geosurf.kernels.exact.exact_signs import COLLISIONS, N_NAME, N_SLOT, N_TRIANGLE, UNINDEXED

_SLOTS = 1 << 10  # of the table of names at first, 40 kB; it grows where that is too little


@scalar
def _index_points(frame, names, places):
    """Enter the points that existed before, all distinct, into the table of places, once.

    Most faces create no points and need no tables: both tables are cleared here on first use.
    """
    m = frame.m
    if m[UNINDEXED] == 0:
        return
    collisions = m[COLLISIONS]

    # Clear both tables; collisions of known points do not count.
    m[N_NAME], m[N_SLOT] = 0, min(_SLOTS, names.shape[0])
    for slot in range(m[N_SLOT]):
        names[slot, 0] = 0
    for slot in range(places.shape[0]):
        places[slot] = -1
    for i in range(m[UNINDEXED]):
        id_of_coordinates(frame, places, i)
    m[UNINDEXED], m[COLLISIONS] = 0, collisions


@scalar
def _names_in_use(m, names):
    """The slots in use, twice as many if one more name could fill half of them.

    There is room for the names of every crossing that may be; memory is used for those that are.
    """
    size = m[N_SLOT]
    if 2 * m[N_NAME] + 2 < size or size == names.shape[0]:
        return names[:size]
    held, larger = names[:size].copy(), names[: 2 * size]
    for slot in range(2 * size):
        larger[slot, 0] = 0
    m[N_NAME], m[N_SLOT] = 0, 2 * size
    for i in range(size):
        if held[i, 0] != 0:
            kind, a, b, c = held[i, 0], held[i, 1], held[i, 2], held[i, 3]
            insert_name(m, larger, slot_of(larger, kind, a, b, c), kind, a, b, c, held[i, 4])
    return larger


@scalar
def point_in_tables(frame, names, places, kind, a, b, c):
    """Id of the point with this definition, made if it is new; FULL if there is no room."""
    _index_points(frame, names, places)
    return named_point(frame, _names_in_use(frame.m, names), places, kind, a, b, c)


@scalar
def _crossing(frame, names, places, s, one, two):
    """Id of the point where constraints with two support planes cross in the face."""
    e, m = frame.e, frame.m

    # Choose the definition with the lowest degree.
    # Edges through planes need shorter integers than three planes.
    face = s[FACE_ID]
    n = m[N_TRIANGLE]
    if one >= n:  # an edge plane: the line is that edge
        return point_in_tables(frame, names, places, LPI, e[one - n, 0], e[one - n, 1], two)
    if two >= n:
        return point_in_tables(frame, names, places, LPI, e[two - n, 0], e[two - n, 1], one)
    return point_in_tables(frame, names, places, TPI, face, one, two)


@scalar
def _first_crossed(frame, mesh, points, a, b, p, goal):
    """From p towards goal: (half-edge crossed, -1), or (half-edge along the line, its far end)."""
    h, v = mesh.h, mesh.v
    start = v[p]
    i = start
    # Triangles around p are visited counter-clockwise; at the border of the face, the rest from the
    # start on clockwise.
    forward = True
    while True:
        # The other two corners of the triangle: is one the goal, or on the line?
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

        # The line leaves through the edge opposite to p.
        if sy < 0 and sz > 0:
            return next_half_edge(i), -1

        # Rotate counter-clockwise; at the border start again clockwise.
        if forward:
            i = h[previous_half_edge(i), 1]
            if i < 0:
                forward = False
                i = start
            # A full turn without an exit: the caller reports the broken invariant.
            elif i == start:
                return -1, -1
        if not forward:
            i = h[i, 1]
            if i < 0:
                return -1, -1
            i = next_half_edge(i)


@scalar
def _rotate(h, start, i, sense):
    """The next half-edge around the origin of i, and the sense of rotation, 0 at the end."""
    if sense > 0:
        i = h[previous_half_edge(i), 1]
        if i == start:
            return i, 0
        if i >= 0:
            return i, 1
        i = start  # the border: continue clockwise from the start
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

    The triangles around both points are visited in turns, so the smaller degree determines the
    cost.
    """
    i, j = v[a], v[b]
    one = two = 1
    while one != 0 and two != 0:
        # Look at one triangle of each end per round.
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
    # A constraint keeps its first plane: coplanar faces define equal points with either.
    if h[i, 2] < 0 and h[i, 1] >= 0:
        link(h, i, h[i, 1], support)


@scalar
def _has_lower_degree(h, v, a, b):
    """Whether no more triangles meet at point a than at b, by rotating around both in turns."""
    i, j = v[a], v[b]
    one = two = 1
    while True:
        # The rotation that ends first belongs to the lower degree.
        i, one = _rotate(h, v[a], i, one)
        if one == 0:
            return True
        j, two = _rotate(h, v[b], j, two)
        if two == 0:
            return False


@scalar
def _constrain_next(frame, names, places, mesh, points, a, b, p, other, support):
    """Constrain the line from a to b, from its point p to the next one towards `other`.

    Returns that point; -1 if there is none, which breaks an invariant; FULL if a table is full.
    """
    q, s = points.q, points.s
    h, v = mesh.h, mesh.v
    goal = other
    while True:
        i, far = _first_crossed(frame, mesh, points, a, b, p, goal)
        if i < 0:
            return -1

        # An existing edge lies on the line.
        if far >= 0:
            _constrain(h, i, support)
            return far
        reached, wall = insert_by_cavity(frame, mesh, points, p, i, a, b, goal, support)
        if wall < 0:
            return reached

        # A crossing adds a point and two triangles: check the capacity first.
        if s[POINTS] >= q.shape[0] or 3 * (s[TRIANGLES] + 2) > h.shape[0]:
            return FULL

        # A constraint is crossed: construct the point, split the constraint there, try again.
        number = _crossing(frame, names, places, s, support, np.int64(h[wall, 2]))
        if number == FULL:
            return FULL
        goal = add_local(frame, points, number, 0)

        # The point lies on both lines, which proves later turns without arithmetic.
        add_line(q, goal, support)
        add_line(q, goal, h[wall, 2])
        q[goal, 3] = s[SEGMENT]
        split_edge(h, v, s, wall, goal)


@scalar
def insert_segment(frame, names, places, mesh, points, a, b, support):
    """Make the segment of local points a, b a chain of constraints; 0, FULL, or -1 (broken).

    It is inserted from both ends, always at the end of lower degree: thousands of segments with a
    common end would otherwise each search all triangles around it.
    """
    q, s = points.q, points.s
    h, v = mesh.h, mesh.v

    # Points known to lie on this segment carry its number.
    # A new number replaces clearing the marks of the segment before.
    s[SEGMENT] += 1
    q[a, 3] = q[b, 3] = s[SEGMENT]
    low, high = a, b
    while low != high:
        # Advance from the end with fewer triangles until both ends meet.
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
