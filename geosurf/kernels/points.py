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
FULL = -9  # a table is full: the front door starts again with larger ones
_SPLIT = 134217729.0  # 2**27 + 1 (Dekker 1971)


@scalar
def _two_sum(a, b):
    s = a + b
    c = s - a
    return s, (a - (s - c)) + (b - c)


@scalar
def _two_product(a, b):
    p = a * b
    c = _SPLIT * a
    ah = c - (c - a)
    al = a - ah
    c = _SPLIT * b
    bh = c - (c - b)
    bl = b - bh
    return p, ((ah * bh - p) + ah * bl + al * bh) + al * bl


@scalar
def _dd_add(ah, al, bh, bl):
    s, r = _two_sum(ah, bh)
    return _two_sum(s, r + (al + bl))


@scalar
def _dd_mul(ah, al, bh, bl):
    p, r = _two_product(ah, bh)
    return _two_sum(p, r + (ah * bl + al * bh))


@scalar
def _dd_minor(ah, al, bh, bl, ch, cl, dh, dl):
    """a b - c d."""
    p, q = _dd_mul(ah, al, bh, bl)
    r, s = _dd_mul(ch, cl, dh, dl)
    return _dd_add(p, q, -r, -s)


@scalar
def _dd_height(x, n, a, o):
    """n . (x[o] - x[a]) in double-double, and the sum of the magnitudes of its terms."""
    hi = 0.0
    lo = 0.0
    size = 0.0
    for i in range(3):
        dh, dl = _two_sum(x[o, i], -x[a, i])
        ph, pl = _dd_mul(n[2 * i], n[2 * i + 1], dh, dl)
        hi, lo = _dd_add(hi, lo, ph, pl)
        size += n[6 + i] * abs(dh)
    return hi, lo, size


@scalar
def quick_lpi(x, a, b, c0, c1, c2):
    """Line a-b through the plane of vertices c0, c1, c2, correctly rounded in double-double.

    Returns (certain, x, y, z). Double-double carries 104 bits; where the error bound leaves
    the rounding open (one case in 2**40 in general position) the caller goes the exact way.
    """
    g = _two_sum(x[c1, 0], -x[c0, 0])
    h = _two_sum(x[c1, 1], -x[c0, 1])
    i = _two_sum(x[c1, 2], -x[c0, 2])
    p = _two_sum(x[c2, 0], -x[c0, 0])
    q = _two_sum(x[c2, 1], -x[c0, 1])
    r = _two_sum(x[c2, 2], -x[c0, 2])
    n0 = _dd_minor(h[0], h[1], r[0], r[1], i[0], i[1], q[0], q[1])
    n1 = _dd_minor(i[0], i[1], p[0], p[1], g[0], g[1], r[0], r[1])
    n2 = _dd_minor(g[0], g[1], q[0], q[1], h[0], h[1], p[0], p[1])
    s0 = abs(h[0] * r[0]) + abs(i[0] * q[0])
    s1 = abs(i[0] * p[0]) + abs(g[0] * r[0])
    s2 = abs(g[0] * q[0]) + abs(h[0] * p[0])
    n = (n0[0], n0[1], n1[0], n1[1], n2[0], n2[1], s0, s1, s2)
    ha, la, size_a = _dd_height(x, n, c0, a)
    hb, lb, size_b = _dd_height(x, n, c0, b)
    dh, dl = _dd_add(ha, la, -hb, -lb)
    size = size_a + size_b
    if not (size > 1e-200 and abs(dh) > 1e-24 * size):
        return False, 0.0, 0.0, 0.0
    # t = ha / (ha - hb), by one Newton step on the double quotient
    t0 = ha / dh
    ph, pl = _dd_mul(dh, dl, t0, 0.0)
    rh, rl = _dd_add(ha, la, -ph, -pl)
    th, tl = _two_sum(t0, (rh + rl) / dh)
    # every dd operation errs by less than 2**-100 of its operands; about thirty of them
    relative = 2.0**-94 * (size / abs(dh))
    out0, ok0 = _along(x, a, b, c0, c1, c2, 0, th, tl, relative)
    out1, ok1 = _along(x, a, b, c0, c1, c2, 1, th, tl, relative)
    out2, ok2 = _along(x, a, b, c0, c1, c2, 2, th, tl, relative)
    return ok0 and ok1 and ok2, out0, out1, out2


@scalar
def _along(x, a, b, c0, c1, c2, axis, th, tl, relative):
    """One coordinate of the point at t between a and b, and whether its rounding is certain.

    A plane that is level on this axis (a contact, a wall of the box) gives it exactly; without
    this, every point on the level 0 would go the exact way.
    """
    level = x[c0, axis]
    if x[c1, axis] == level and x[c2, axis] == level:
        return level, True
    start, end = x[a, axis], x[b, axis]
    dh, dl = _two_sum(end, -start)
    ph, pl = _dd_mul(dh, dl, th, tl)
    s, r = _dd_add(start, 0.0, ph, pl)
    slack = relative * abs(dh) + 2.0**-98 * (abs(start) + abs(end))
    return s + 0.0, (s + (r - slack)) == s and (s + (r + slack)) == s


@scalar
def hash_of_place(px, py, pz):
    """Hash of three coordinates."""
    h = 1469598103934665603
    for value in (px, py, pz):
        fraction, exponent = math.frexp(value)
        h = (h ^ int(fraction * 9007199254740992.0)) & 0x7FFFFFFFFFFF
        h = (h * 31321 + exponent * 7919 + (h >> 17)) & 0x7FFFFFFFFFFF
    return h ^ (h >> 23)


@scalar
def hash_of_name(kind, a, b, c):
    """Hash of a definition."""
    h = (kind * 1000003 + a) & 0x3FFFFFFFFF
    h = (h * 8388593 + b) & 0x3FFFFFFFFF
    h = (h * 8388593 + c) & 0x3FFFFFFFFF
    return h ^ (h >> 19)


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
    certain = False
    if kind == LPI and c < m[N_TRIANGLE]:
        certain, px, py, pz = quick_lpi(x, a, b, t[c, 0], t[c, 1], t[c, 2])
        x[i, 0], x[i, 1], x[i, 2] = px, py, pz
    if not certain:
        for axis in range(3):
            point(x, t, e, d, m, w, 0, i)
            x[i, axis] = exact_position(x, t, e, d, m, w, i, axis)
    found = id_at_place(x, t, e, d, m, w, places, i)
    if found == i:
        m[N_POINT] += 1
    _file_name(m, names, slot, kind, a, b, c, found)
    return found
