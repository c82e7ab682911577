"""Constructed points: named by what makes them, placed by correct rounding, one id each.

A point's name is its definition (see `exact`). Two names may be one point (coplanar
faces, three surfaces through a line): points whose correctly rounded coordinates are equal
are compared exactly and become one id. Rounding is a function of the value alone and
monotone, so unequal rounded coordinates decide order and inequality exactly.

Letters as in `exact`, and
    names      hash table of names, int64 (size, 5): definition and id, first word 0 if empty
    places     hash table of ids by rounded coordinates, int64 (size,), -1 if empty
Both sizes are powers of two and never more than half full: the front door makes `places` large
enough for all points that `x` has room for, and `names` tells when it is full.
"""

from __future__ import annotations

import math

from geosurf.kernels._jit import scalar
from geosurf.kernels.doubled import point_doubled, rounds
from geosurf.kernels.exact import (
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

LPI, TPI, EDGE_PLANE = 1, 2, 3
_MASK = (1 << 38) - 1
FULL = -9  # a table is full: the front door starts again with larger ones


@scalar
def _mixed(h, key):
    """A hash of 38 bits with a key of up to 62 bits mixed in; no product passes 2**62.

    Coordinates of grids differ in their upper bits only, names in their lower ones: both have to
    reach all bits, or tables of a million grid nodes are one long chain.
    """
    h = (h ^ key ^ (key >> 38)) & _MASK
    h *= 0xB5297B
    h = (h ^ (h >> 27)) & _MASK
    h *= 0x9E3779
    return (h ^ (h >> 25)) & _MASK


@scalar
def hash_of_place(px, py, pz):
    """Hash of three coordinates."""
    h = 0
    for value in (px, py, pz):
        fraction, exponent = math.frexp(value)
        h = _mixed(h + 7919 * exponent, int(fraction * 9007199254740992.0))
    return h


@scalar
def hash_of_name(kind, a, b, c):
    """Hash of a definition."""
    return _mixed(_mixed(_mixed(kind, a), b), c)


@scalar
def same_point(x, t, e, d, m, w, a, b):
    """Whether points a and b, whose rounded coordinates are equal, are one point."""
    if a < m[N_VERTEX] and b < m[N_VERTEX]:
        return True
    for axis in range(3):
        if exact_compare(x, t, e, d, m, w, a, b, axis) != 0:
            return False
    return True


@scalar
def id_at_place(x, t, e, d, m, w, places, i):
    """Id of the point that is exactly point i (i itself if it is new, and then filed)."""
    size = places.shape[0]
    slot = hash_of_place(x[i, 0], x[i, 1], x[i, 2]) & (size - 1)
    collided = 0
    while places[slot] >= 0:
        j = places[slot]
        if x[j, 0] == x[i, 0] and x[j, 1] == x[i, 1] and x[j, 2] == x[i, 2]:
            if j == i or same_point(x, t, e, d, m, w, i, j):
                return j
            collided = 1
        slot = (slot + 1) & (size - 1)
    places[slot] = i
    m[COLLISIONS] += collided
    return i


@scalar
def _slot_of(names, kind, a, b, c):
    """Slot of a definition in the table of names, or the empty one where it belongs."""
    size = names.shape[0]
    slot = hash_of_name(kind, a, b, c) & (size - 1)
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
def _file_name(m, names, slot, kind, a, b, c, i):
    """Enter a definition and what it stands for into an empty slot."""
    names[slot, 0], names[slot, 1], names[slot, 2], names[slot, 3] = kind, a, b, c
    names[slot, 4] = i
    m[N_NAME] += 1


@scalar
def edge_plane(e, m, names, a, b, axis):
    """Id of the plane through edge a-b along an axis; FULL if there is no room."""
    if a > b:
        a, b = b, a
    slot = _slot_of(names, EDGE_PLANE, a, b, axis)
    if names[slot, 0] != 0:
        return names[slot, 4]
    row = m[N_EDGE_PLANE]
    if row >= e.shape[0] or 2 * m[N_NAME] >= names.shape[0]:
        return FULL
    e[row, 0], e[row, 1], e[row, 2] = a, b, axis
    m[N_EDGE_PLANE] += 1
    _file_name(m, names, slot, EDGE_PLANE, a, b, axis, m[N_TRIANGLE] + row)
    return m[N_TRIANGLE] + row


@scalar
def named_point(x, t, e, d, m, w, names, places, kind, a, b, c):
    """Id of the point with this definition, made if it is new; FULL if there is no room."""
    if a > b:
        a, b = b, a
    if kind == TPI:
        if b > c:
            b, c = c, b
        if a > b:
            a, b = b, a
    slot = _slot_of(names, kind, a, b, c)
    if names[slot, 0] != 0:
        return names[slot, 4]
    row = m[N_POINT]
    i = m[N_VERTEX] + row
    if i >= x.shape[0] or 2 * m[N_NAME] >= names.shape[0]:
        return FULL
    d[row, 0], d[row, 1], d[row, 2], d[row, 3] = kind, a, b, c
    known, p, rest, slack = point_doubled(x, t, e, m, kind, a, b, c)
    x[i, 0], x[i, 1], x[i, 2] = p[0], p[1], p[2]
    if not (
        known
        and rounds(p[0], rest[0], slack[0])
        and rounds(p[1], rest[1], slack[1])
        and rounds(p[2], rest[2], slack[2])
    ):
        point(x, t, e, d, m, w, 0, i)
        for axis in range(3):
            x[i, axis] = exact_position(x, t, e, d, m, w, i, axis)
    found = id_at_place(x, t, e, d, m, w, places, i)
    if found == i:
        m[N_POINT] += 1
    _file_name(m, names, slot, kind, a, b, c, found)
    return found
