"""Segments become constrained edges of a triangulated face, with their crossings.

A segment is inserted by cavity (see `cavity`); flipping the crossed edges (Sloan 1993) would be
quadratic in their number. Where it crosses another constraint, a point is constructed: three
planes, or an edge and a plane. Notation as in `delaunay`; a, b are the ends of the current segment.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.cutting.delaunay import (
    flip,
    link,
    next_half_edge,
    previous_half_edge,
    set_triangle,
    split_edge,
)
from geosurf.kernels.cutting.face_signs import (
    FACE_ID,
    POINTS,
    SEGMENT,
    TRIANGLES,
    add_line,
    add_local,
    in_circle,
    same_direction,
    turn,
)
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

# ---- cavity ----------------------------------------
# The cavity of a segment: the triangles that it crosses, removed and triangulated again.
#
# Each side of the segment is a polygon whose points are all visible from the segment. So each
# convex corner is an ear (Toussaint & Avis 1982). Ears are cut, every other one of a row at a
# time, and added again in the opposite order with flips after each, like the corners of a polygon
# inserted one by one (Chew 1990). Cutting consecutive ears would leave fans, which take quadratic
# time to flip. Notation as in `delaunay`.
#
# The *corridor* is the strip of triangles that the segment crosses; its two borders are *chains*.


_FEW = 8  # chains up to this length are cut consecutively
_IN_CAVITY, _ADDED = -2, -3  # marks of half-edges: in the corridor; of an added ear


@scalar
def side_of_segment(frame, points, a, b, p):
    """Side of p of the line of the current segment from a to b."""
    q, s = points.q, points.s
    # Points that were constructed on this segment lie on its line by definition.
    if q[p, 3] == s[SEGMENT]:
        return 0
    return turn(frame, points, a, b, p)


@scalar
def _cut_ear(mesh, free, tri, a, b, point):
    """Make the triangle of chain rows a, b and a point; row a then links to that point."""
    h, v, k = mesh.h, mesh.v, mesh.k
    slot = k[free + tri, 3]
    i = 3 * slot
    set_triangle(h, v, slot, k[a, 0], k[b, 0], point)
    _join(h, i, k[a, 1], k[a, 2], k[a, 3])
    _join(h, i + 1, k[b, 1], k[b, 2], k[b, 3])

    # Row a now links to the open edge of the ear, which has no twin and no constraint yet.
    k[a, 1], k[a, 2], k[a, 3] = i + 2, -1, -1


@scalar
def _move_row(k, to, c):
    """Copy a row of a chain."""
    k[to, 0], k[to, 1], k[to, 2], k[to, 3] = k[c, 0], k[c, 1], k[c, 2], k[c, 3]


@scalar
def _fill(frame, mesh, points, low, high, free, tri):
    """Triangulate the chain k[low:high] seen from its base: (base half-edge, next triangle).

    Rows of k: point, twin and support of the link to the next row, old half-edge of
    the link. Triangles are written to the slots k[free + n, 3], in the order of the ears.
    """
    k = mesh.k
    many = True
    # cut every other ear while at least a quarter of the chain disappears
    while many and high - low > _FEW:
        n = high - low
        # Rows are compacted in place: `top` is the last row that remains.
        top = low
        c = low + 1
        while c < high - 1:
            if turn(frame, points, k[top, 0], k[c, 0], k[c + 1, 0]) > 0:
                _cut_ear(mesh, free, tri, top, c, k[c + 1, 0])
                tri += 1
                # The corner after an ear is skipped: consecutive ears would make a fan.
                c += 1
            top += 1
            _move_row(k, top, c)
            c += 1
        if c < high:
            top += 1
            _move_row(k, top, c)
        high = top + 1
        many = 4 * (n - (high - low)) >= n
    top = low
    # cut what remains consecutively: Graham's scan, the stack starts at `low`
    for c in range(low + 1, high):
        point, twin, support, old = k[c, 0], k[c, 1], k[c, 2], k[c, 3]
        while top > low and turn(frame, points, k[top - 1, 0], k[top, 0], point) > 0:
            _cut_ear(mesh, free, tri, top - 1, top, point)
            tri += 1
            top -= 1
        top += 1
        k[top, 0], k[top, 1], k[top, 2], k[top, 3] = point, twin, support, old
    return k[low, 1], tri


@scalar
def _legalize_ears(frame, mesh, points, free, n):
    """Add n ears in the opposite order, and flip the edge opposite to the tip of each if needed.

    Only edges between added ears are flipped.
    """
    h, v, k = mesh.h, mesh.v, mesh.k
    for r in range(n - 1, -1, -1):
        slot = k[free + r, 3]
        # From now on flips may involve this ear.
        h[3 * slot, 3] = _ADDED
        k[0, 0] = 3 * slot + 2
        count = 1
        while count > 0:
            count -= 1

            # Only edges to ears that were added already can be illegal.
            i = k[count, 0]
            j = h[i, 1]
            # Borders and constraints are never flipped, nor edges to triangles outside of the
            # cavity.
            if j < 0 or h[i, 2] >= 0 or h[j - j % 3, 3] != _ADDED:
                continue

            # A flip exposes two more edges.
            a, b, c, o = h[i, 0], h[j, 0], h[previous_half_edge(i), 0], h[previous_half_edge(j), 0]
            if in_circle(frame, points, a, b, c, o):
                flip(h, v, i)
                k[count, 0], k[count + 1, 0] = next_half_edge(i), previous_half_edge(j)
                count += 2
    for r in range(n):
        h[3 * k[free + r, 3], 3] = 0


@scalar
def _join(h, i, twin, support, old):
    """Link a new half-edge to its twin; store in the old half-edge where it moved."""
    link(h, i, twin, support)
    if old >= 0:
        h[old, 3] = i


@scalar
def _push_link(h, k, n, point, i):
    """Write a chain row: a point, and the link of old half-edge i to the next row."""
    k[n, 0], k[n, 1], k[n, 2], k[n, 3] = point, h[i, 1], h[i, 2], i


@scalar
def _corridor(frame, mesh, points, first, a, b, goal):
    """Write the half-edges that the segment crosses, right end to left end, into k[:, 0].

    (number, point reached, -1), or (0, -1, half-edge) where a constraint is crossed.
    """
    h, k = mesh.h, mesh.k
    n = 0
    i = first
    while True:
        # A constraint in the way has to be split before the segment can pass.
        if h[i, 2] >= 0:
            return 0, -1, i
        k[n, 0] = i
        n += 1

        # The apex of the next triangle decides which of its edges is crossed.
        j = h[i, 1]
        apex = h[previous_half_edge(j), 0]
        side = 0 if apex == goal else side_of_segment(frame, points, a, b, apex)
        if side == 0:
            return n, apex, -1

        # An apex on the right: the segment leaves between the apex and the left end.
        i = previous_half_edge(j) if side < 0 else next_half_edge(j)


@scalar
def _build_chains(mesh, n, p, left, right, free):
    """Write both borders of a corridor, counter-clockwise, and the slots of its triangles,
    k[free:, 3].

    The left chain leads to p and ends at row left + n + 1, since it is filled from behind; the
    right one starts at p. Returns the first row of the left chain and the last row of the right
    chain.
    """
    h, k = mesh.h, mesh.k
    _push_link(h, k, right, p, previous_half_edge(k[0, 0]))
    k[left + n + 1, 0] = p
    nl = n
    _push_link(h, k, left + nl, h[next_half_edge(k[0, 0]), 0], next_half_edge(k[0, 0]))
    nr = 1
    k[right + nr, 0] = h[k[0, 0], 0]
    k[free, 3] = k[0, 0] // 3
    for c in range(n):
        # Walk along the corridor; each triangle adds one link to one of the borders.
        i = k[c, 0]
        j = h[i, 1]
        k[free + c + 1, 3] = j // 3
        y, z = next_half_edge(j), previous_half_edge(j)  # y: right end -> apex, z: apex -> left end
        # Both edges of the last triangle are on the borders.
        onward = k[c + 1, 0] if c + 1 < n else -1
        if onward != y:  # the edge y is on the right border
            _push_link(h, k, right + nr, h[i, 0], y)
            nr += 1
            k[right + nr, 0] = h[z, 0]
        if onward != z:
            nl -= 1
            _push_link(h, k, left + nl, h[z, 0], z)
    for last in (right + nr, left + n + 1):
        k[last, 1], k[last, 2], k[last, 3] = -1, -1, -1
    return left + nl, right + nr


@scalar
def _note_inner(h, k, low, high, behind, n):
    """Links with both sides on this corridor: cut them and list them, to be joined again later."""
    for c in range(low, high):
        if k[c, 1] >= 0 and h[k[c, 1], 3] == _IN_CAVITY:
            # Each inner link is seen from both sides; the lower half-edge lists it.
            if k[c, 3] < k[c, 1]:
                k[behind + n, 0], k[behind + n, 1], k[behind + n, 2] = k[c, 3], k[c, 1], k[c, 2]
                n += 1
            k[c, 1] = -1
    return n


@scalar
def _mark(h, k, free, n, value):
    """Mark the half-edges of n triangles."""
    for c in range(n):
        i = 3 * k[free + c, 3]
        h[i, 3] = h[i + 1, 3] = h[i + 2, 3] = value


@scalar
def insert_by_cavity(frame, mesh, points, p, first, a, b, goal, support):
    """Insert the constraint from p across half-edge `first` up to the next point of the line.

    Returns (point reached, -1), or (-1, constrained half-edge) where one has to be split first.
    """
    h, k = mesh.h, mesh.k
    n, reached, wall = _corridor(frame, mesh, points, first, a, b, goal)
    if wall >= 0:
        return -1, wall

    # Parts of the scratch rows: left chain, right chain, triangle slots, inner links.
    left = n + 2
    right = left + n + 3
    free = right + n + 3
    behind = free + n + 2
    low, last = _build_chains(mesh, n, p, left, right, free)
    _mark(h, k, free, n + 1, _IN_CAVITY)  # a link may lead into the corridor again
    inner = _note_inner(h, k, low, left + n + 1, behind, 0)
    inner = _note_inner(h, k, right, last, behind, inner)

    # Triangulate both sides; the constraint joins their bases.
    one, tri = _fill(frame, mesh, points, low, left + n + 2, free, 0)
    two, tri = _fill(frame, mesh, points, right, last + 1, free, tri)
    link(h, one, two, support)
    for c in range(inner):
        link(h, h[k[behind + c, 0], 3], h[k[behind + c, 1], 3], k[behind + c, 2])

    # Restore the Delaunay property of the new triangles.
    _mark(h, k, free, n + 1, 0)
    _legalize_ears(frame, mesh, points, free, n + 1)
    return reached, -1


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
def _crossing(frame, names, places, s, first, second):
    """Id of the point where constraints with two support planes cross in the face."""
    e, m = frame.e, frame.m

    # Choose the definition with the lowest degree.
    # Edges through planes need shorter integers than three planes.
    face = s[FACE_ID]
    n = m[N_TRIANGLE]
    if first >= n:  # an edge plane: the line is that edge
        return point_in_tables(frame, names, places, LPI, e[first - n, 0], e[first - n, 1], second)
    if second >= n:
        return point_in_tables(frame, names, places, LPI, e[second - n, 0], e[second - n, 1], first)
    return point_in_tables(frame, names, places, TPI, face, first, second)


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
    turn_i = turn_j = 1
    while turn_i != 0 and turn_j != 0:
        # Look at one triangle of each end per round.
        edge = _edge_around(h, i, a, b)
        if edge < 0:
            edge = _edge_around(h, j, b, a)
        if edge >= 0:
            _constrain(h, edge, support)
            return True
        i, turn_i = _rotate(h, v[a], i, turn_i)
        j, turn_j = _rotate(h, v[b], j, turn_j)
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
    turn_i = turn_j = 1
    while True:
        # The rotation that ends first belongs to the lower degree.
        i, turn_i = _rotate(h, v[a], i, turn_i)
        if turn_i == 0:
            return True
        j, turn_j = _rotate(h, v[b], j, turn_j)
        if turn_j == 0:
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
