"""Constructed points: defined by symbols, placed by correct rounding, one id each.

A point's name is its definition (see `exact_signs`). Several names may denote one point: faces may
be coplanar, and three surfaces may share a line. Points with equal correctly rounded coordinates
are compared exactly and share one id. Rounding depends on the value alone and is monotone,
so unequal rounded coordinates already decide order and inequality exactly (compare Levy 2024).

Letters as in `exact_signs`, and
    names      hash table of names, int64 (size, 5): definition and id; first word 0 if empty
    places     hash table of ids by rounded coordinates, int64 (size,); -1 if empty
Both sizes are powers of two, and the tables are at most half full. The caller sizes `places` for
all points that fit into `x`; `FULL` is returned when `names` is full.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.exact.double_double import point_dd, rounds_to, two_sum
from geosurf.kernels.exact.exact_signs import (
    COLLISIONS,
    N_EDGE_PLANE,
    N_NAME,
    N_POINT,
    N_TRIANGLE,
    N_VERTEX,
    exact_compare,
    exact_position,
    point,
)
from geosurf.kernels.exact.predicates import ORIENT3D_BOUND, TINY, plane_terms

LPI, TPI, EDGE_PLANE = 1, 2, 3
_MASK = (1 << 38) - 1
FULL = -9  # a table is full: the caller repeats with larger ones


@scalar
def _mixed(h, key):
    """Mix a key of up to 62 bits into a hash of 38 bits; no product exceeds 2**62.

    Grid coordinates differ in their upper bits only, names in their lower bits. Both have to reach
    all bits, or a table of a million grid nodes becomes one long chain.
    """
    h = (h ^ key ^ (key >> 38)) & _MASK
    h *= 0xB5297B
    h = (h ^ (h >> 27)) & _MASK
    h *= 0x9E3779
    return (h ^ (h >> 25)) & _MASK


@scalar
def hash_of_row(x, i):
    """Hash of the coordinates of point i, from their bits; equal for 0.0 and -0.0."""
    bits = x[i].view(np.int64)
    h = 0
    for axis in range(3):
        # 0.0 and -0.0 are equal numbers with different bits: zeros do not change the hash. The
        # lowest 16 bits enter through h, the other 48 as the key.
        if x[i, axis] != 0.0:
            h = _mixed(h + (bits[axis] & 0xFFFF), (bits[axis] >> 16) & 0xFFFFFFFFFFFF)
    return h


@scalar
def hash_of_name(kind, a, b, c):
    """Hash of a definition."""
    return _mixed(_mixed(_mixed(kind, a), b), c)


@scalar
def same_point(frame, a, b):
    """Whether points a and b, whose rounded coordinates are equal, are one point."""
    m = frame.m

    # Vertices are defined by their coordinates: equal coordinates mean equal points.
    if a < m[N_VERTEX] and b < m[N_VERTEX]:
        return True
    for axis in range(3):
        if exact_compare(frame, a, b, axis) != 0:
            return False
    return True


@scalar
def slot_at_coordinates(x, places, i, slot):
    """First slot, from one on, that is empty or holds a point with the coordinates of point i.

    Short and with few arrays, so that it is inlined: a call with seven arrays would take longer.
    """
    while places[slot] >= 0:
        j = places[slot]
        if x[j, 0] == x[i, 0] and x[j, 1] == x[i, 1] and x[j, 2] == x[i, 2]:
            break
        slot = (slot + 1) & (places.shape[0] - 1)
    return slot


@scalar
def id_after_collision(frame, places, i, slot):
    """Id of point i where another point has equal rounded coordinates."""
    x, m = frame.x, frame.m

    # Compare exactly with each point of equal coordinates.
    collided = 0
    while places[slot] >= 0:
        j = places[slot]
        if j == i or same_point(frame, i, j):
            return j
        collided = 1
        slot = slot_at_coordinates(x, places, i, (slot + 1) & (places.shape[0] - 1))

    # A new point at coordinates that another point has: both round to the same doubles.
    places[slot] = i
    m[COLLISIONS] += collided
    return i


@scalar
def id_of_coordinates(frame, places, i):
    """Id of the point that equals point i; point i itself is entered if it is new."""
    x = frame.x
    slot = slot_at_coordinates(x, places, i, hash_of_row(x, i) & (places.shape[0] - 1))
    if places[slot] >= 0:
        return id_after_collision(frame, places, i, slot)
    places[slot] = i
    return i


@scalar
def slot_of(names, kind, a, b, c):
    """Slot of a definition in the table of names, or the empty one where it belongs."""
    size = names.shape[0]
    slot = hash_of_name(kind, a, b, c) & (size - 1)

    # Linear probing ends at an empty slot: the table is at most half full.
    while names[slot, 0] != 0:
        if (
            names[slot, 0] == kind
            and names[slot, 1] == a
            and names[slot, 2] == b
            and names[slot, 3] == c
        ):
            break
        slot = (slot + 1) & (size - 1)
    return slot


@scalar
def insert_name(m, names, slot, kind, a, b, c, i):
    """Enter a definition and its id into an empty slot."""
    names[slot, 0], names[slot, 1], names[slot, 2], names[slot, 3] = kind, a, b, c
    names[slot, 4] = i
    m[N_NAME] += 1


@scalar
def edge_plane(e, m, names, a, b, axis):
    """Id of the plane through edge a-b along an axis; FULL if there is no room."""
    # Both directions of an edge name the same plane.
    if a > b:
        a, b = b, a
    slot = slot_of(names, EDGE_PLANE, a, b, axis)
    if names[slot, 0] != 0:
        return names[slot, 4]
    row = m[N_EDGE_PLANE]
    if row >= e.shape[0] or 2 * m[N_NAME] >= names.shape[0]:
        return FULL
    e[row, 0], e[row, 1], e[row, 2] = a, b, axis
    m[N_EDGE_PLANE] += 1
    insert_name(m, names, slot, EDGE_PLANE, a, b, axis, m[N_TRIANGLE] + row)
    return m[N_TRIANGLE] + row


@scalar
def _height(x, n, o, p):
    """Height of vertex p over the plane at o with terms n, and a bound of its error."""
    c0, c1, c2 = x[p, 0] - x[o, 0], x[p, 1] - x[o, 1], x[p, 2] - x[o, 2]
    size = abs(c0) * n[3] + abs(c1) * n[4] + abs(c2) * n[5]
    bound = ORIENT3D_BOUND * size if size > TINY else np.inf
    return c0 * n[0] + c1 * n[1] + c2 * n[2], bound


@scalar
def lpi_in_doubles(x, t, a, b, c):
    """Intersection of edge a-b and triangle c in plain doubles: (certified, x, y, z).

    `certified` means that each coordinate is the correctly rounded one. Let h be the computed
    heights of the ends over the plane, each with an error of at most f, and H the true ones. Then
    ``ha / (ha
    - hb)`` has an error of at most ``max(fa, fb) / |Ha - Hb|``. The last sum's rounding error is
    known, so coordinates can be certified where edges are short compared to coordinates: in grids
    nine of ten.
    """
    # Heights of both ends over the plane, with error bounds.
    o = t[c, 0]
    n = plane_terms(x, o, t[c, 1], t[c, 2])
    ha, fa = _height(x, n, o, a)
    hb, fb = _height(x, n, o, b)
    below = ha - hb
    # Certify only where the ends are on different sides, or one on the plane, and where their
    # heights differ by much more than their errors. Otherwise the fraction has too few certain
    # digits.
    if not (ha * hb <= 0.0 and 4.0 * (fa + fb) < abs(below) < np.inf):
        return False, 0.0, 0.0, 0.0

    # Interpolate; every coordinate has to be certified.
    part = ha / below
    # 4/3 for H beside h; five roundings of 2**-53 follow
    relative = 1.34 * max(fa, fb) / abs(below) + 2.0**-50
    s0, p0 = _interpolate(x[a, 0], x[b, 0], part, relative)
    s1, p1 = _interpolate(x[a, 1], x[b, 1], part, relative)
    s2, p2 = _interpolate(x[a, 2], x[b, 2], part, relative)
    return s0 and s1 and s2, p0, p1, p2


@scalar
def _interpolate(start, end, part, relative):
    """Point at a fraction of the way from start to end: (certified, coordinate)."""
    if start == end:
        return True, start + 0.0

    # The rounding error of this last sum is known exactly and takes nothing from the bound.
    p, low = two_sum(start, (end - start) * part)
    return rounds_to(p, low, relative * abs(end - start) + 1e-300), p + 0.0


@scalar
def round_point(frame, i):
    """Write the correctly rounded coordinates of constructed point i, by double-doubles or
    integers.

    None is -0.0, see `double_double`.
    """
    x, t, e, d, m = frame.x, frame.t, frame.e, frame.d, frame.m

    # Double-doubles first. Integers follow only where the bound allows two roundings.
    row = i - m[N_VERTEX]
    known, p, low, slack = point_dd(x, t, e, m, d[row, 0], d[row, 1], d[row, 2], d[row, 3])
    x[i, 0], x[i, 1], x[i, 2] = p[0], p[1], p[2]
    if not (
        known
        and rounds_to(p[0], low[0], slack[0])
        and rounds_to(p[1], low[1], slack[1])
        and rounds_to(p[2], low[2], slack[2])
    ):
        point(frame, 0, i)
        for axis in range(3):
            # + 0.0 turns -0.0 into 0.0, as the other routes do
            x[i, axis] = exact_position(frame, i, axis) + 0.0


@scalar
def named_point(frame, names, places, kind, a, b, c):
    """Id of the point with this definition, made if it is new; FULL if there is no room."""
    x, t, d, m = frame.x, frame.t, frame.d, frame.m

    # Sort the symbols, so that each definition has one name.
    if a > b:
        a, b = b, a
    if kind == TPI:
        if b > c:
            b, c = c, b
        if a > b:
            a, b = b, a

    # A known name returns its id.
    slot = slot_of(names, kind, a, b, c)
    if names[slot, 0] != 0:
        return names[slot, 4]
    row = m[N_POINT]

    # Constructed points are stored after the vertices.
    i = m[N_VERTEX] + row
    if i >= x.shape[0] or 2 * m[N_NAME] >= names.shape[0]:
        return FULL

    # Write the definition, then place the point: doubles first.
    d[row, 0], d[row, 1], d[row, 2], d[row, 3] = kind, a, b, c
    certified = False
    # Doubles serve lines through triangles; edge planes and points of three planes start with
    # double-doubles.
    if kind == LPI and c < m[N_TRIANGLE]:
        certified, x[i, 0], x[i, 1], x[i, 2] = lpi_in_doubles(x, t, a, b, c)
    if not certified:
        round_point(frame, i)

    # The point may be known by another name; then its row is used again.
    found = id_of_coordinates(frame, places, i)
    if found == i:
        m[N_POINT] += 1
    insert_name(m, names, slot, kind, a, b, c, found)
    return found
