"""The unique constrained Delaunay triangulation of one cut face: point insertion and flips.

Notation
    h        half-edges, int32 (n, 4): origin (local point), twin (-1 at the border), support
             plane of a constraint (-1: none), mark; half-edge i belongs to triangle i // 3
    v        a half-edge that starts at each local point, int32 (n,)
    q        local points, int32 (n, 8): global id, bits of the face's edges that hold it,
             offset of its integers (`cached_predicates`), number of the last segment known to hold
             it, four lines known to hold it (-1: none)
    f        local points, float64 (n, 5): rounded coordinates (u, v), the larger of their errors,
             both errors
    k        scratch rows, int32 (n, 4)
    s        state, int64 (9,): numbers of points and triangles, axis, segment number, face, start,
             used part of the cache, number of recorded lines, sign of the normal on the axis

Points are inserted first, then segments (see `constraints`), which split the constraints that they
cross. Lawson flips follow until every unconstrained edge is Delaunay. Of four points on one circle
the diagonal at the lexicographically smallest point is taken, a regular perturbation. So the result
is unique: it depends on points and segments only, and overlapping faces agree independently.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.cutting.face_signs import (
    START,
    TRIANGLES,
    exact_in_circle,
    exact_turn,
    filtered_circle,
    filtered_turn,
)


class FaceMesh(NamedTuple):
    """The triangulation of one face: see the notation above."""

    h: np.ndarray  # half-edges
    v: np.ndarray  # a half-edge at each point
    k: np.ndarray  # scratch rows


@scalar
def next_half_edge(i):
    """The next half-edge of the triangle."""
    return i - 2 if i % 3 == 2 else i + 1


@scalar
def previous_half_edge(i):
    """The previous half-edge of the triangle."""
    return i + 2 if i % 3 == 0 else i - 1


@scalar
def link(h, a, b, support):
    """Make half-edges a and b twins (b may be -1)."""
    h[a, 1] = b
    h[a, 2] = support
    if b >= 0:
        h[b, 1] = a
        h[b, 2] = support


@scalar
def set_triangle(h, v, tri, a, b, c):
    """Write the corners of a triangle."""
    i = 3 * tri
    h[i, 0], h[i + 1, 0], h[i + 2, 0] = a, b, c
    v[a], v[b], v[c] = i, i + 1, i + 2


@scalar
def _write(h, i, origin, twin, support):
    """Write an unmarked half-edge."""
    h[i, 0], h[i, 1], h[i, 2], h[i, 3] = origin, twin, support, 0


@scalar
def _lead_back(h, twin, i):
    """Make half-edge i the twin of `twin`, unless that is -1."""
    if twin >= 0:
        h[twin, 1] = i


@scalar
def flip(h, v, i):
    """Replace the edge of half-edge i by the other diagonal."""
    # Remember the four outer edges before the corners change.
    j = h[i, 1]
    i1, i2 = next_half_edge(i), previous_half_edge(i)
    j1, j2 = next_half_edge(j), previous_half_edge(j)
    a, b, c, o = h[i, 0], h[j, 0], h[i2, 0], h[j2, 0]
    ti1, ci1 = h[i1, 1], h[i1, 2]
    ti2, ci2 = h[i2, 1], h[i2, 2]
    tj1, cj1 = h[j1, 1], h[j1, 2]
    tj2, cj2 = h[j2, 1], h[j2, 2]
    # triangle of i: c, o, b; triangle of j: o, c, a
    h[i, 0], h[j, 0] = c, o
    h[i1, 0], h[i1, 1], h[i1, 2] = o, tj2, cj2
    h[i2, 0], h[i2, 1], h[i2, 2] = b, ti1, ci1
    h[j1, 0], h[j1, 1], h[j1, 2] = c, ti2, ci2
    h[j2, 0], h[j2, 1], h[j2, 2] = a, tj1, cj1
    _lead_back(h, tj2, i1)
    _lead_back(h, ti1, i2)
    _lead_back(h, ti2, j1)
    _lead_back(h, tj1, j2)
    v[c], v[o], v[b], v[a] = i, i1, i2, j2


@scalar
def _legalize(frame, mesh, points, p, n):
    """Lawson flips around a new point p, from the n edges opposite to it in k[:, 0].

    A flip makes one edge at p, which is Delaunay, and exposes two edges opposite to p.
    """
    f = points.f
    h, v, k = mesh.h, mesh.v, mesh.k
    while n > 0:
        n -= 1
        i = k[n, 0]
        j = h[i, 1]
        # Neither the border nor a constraint is ever flipped.
        if j < 0 or h[i, 2] >= 0:
            continue

        # The edge is legal unless the opposite point lies inside the circle.
        a, b, o = h[i, 0], h[j, 0], h[previous_half_edge(j), 0]
        side = filtered_circle(f, a, b, p, o)
        if side > 0 or (side == 0 and exact_in_circle(frame, points, a, b, p, o)):
            flip(h, v, i)
            k[n, 0], k[n + 1, 0] = next_half_edge(i), previous_half_edge(j)
            n += 2


@scalar
def _split_triangle(h, v, s, tri, p):
    """Insert p inside a triangle: 1 -> 3."""
    i = 3 * tri

    # The old triangle keeps edge a-b; two new ones take the other edges.
    a, b, c = h[i, 0], h[i + 1, 0], h[i + 2, 0]
    tb, cb = h[i + 1, 1], h[i + 1, 2]
    tc, cc = h[i + 2, 1], h[i + 2, 2]
    n = s[TRIANGLES]
    s[TRIANGLES] = n + 2
    y, z = 3 * n, 3 * n + 3  # of b, c, p and of c, a, p; a, b, p stays here
    _write(h, y, b, tb, cb)
    _write(h, y + 1, c, z + 2, -1)
    _write(h, y + 2, p, i + 1, -1)
    _write(h, z, c, tc, cc)
    _write(h, z + 1, a, i + 2, -1)
    _write(h, z + 2, p, y + 1, -1)
    _write(h, i + 1, b, y + 2, -1)
    _write(h, i + 2, p, z + 1, -1)
    _lead_back(h, tb, y)
    _lead_back(h, tc, z)
    v[a], v[b], v[c], v[p] = i, i + 1, z, i + 2


@scalar
def _split_half(h, v, s, i, p, twin):
    """Split the triangle on one side of an edge at p; the part behind p is a new triangle.

    `twin` is that of the new half-edge from p to the old end of half-edge i; returns that
    half-edge.
    """
    i1, i2 = next_half_edge(i), previous_half_edge(i)
    b, c = h[i1, 0], h[i2, 0]
    t1, c1 = h[i1, 1], h[i1, 2]
    new = 3 * s[TRIANGLES]
    s[TRIANGLES] += 1
    # The part behind p inherits the constraint of the edge.
    _write(h, new, p, twin, h[i, 2])
    _write(h, new + 1, b, t1, c1)
    _write(h, new + 2, c, i1, -1)
    _write(h, i1, p, new + 2, -1)
    _lead_back(h, t1, new + 1)
    v[p], v[b], v[c] = new, new + 1, new + 2
    return new


@scalar
def split_edge(h, v, s, i, p):
    """Insert p on the edge of half-edge i: 2 -> 4, or 1 -> 2 at the border.

    Afterwards half-edge i runs from its origin to p, and so does its twin.
    """
    # Both triangles at the edge are split; at the border there is one.
    j = h[i, 1]
    new = _split_half(h, v, s, i, p, j)
    if j >= 0:
        other = _split_half(h, v, s, j, p, i)
        h[i, 1], h[j, 1] = other, new
        v[p], v[h[j, 0]], v[h[i, 0]] = new, j, i


@scalar
def _locate(frame, mesh, points, p, scan):
    """Triangle that holds point p, and the half-edge that it lies on (-1: inside); tri -1: not
    found.

    Exact signs are computed only where doubles place p behind none of the edges.
    """
    f, s = points.f, points.s
    h = mesh.h
    tri = 0 if scan else s[START] // 3
    entered = -1  # the half-edge that was crossed last: p is on its left
    first = 0  # start with another edge at each step, so that the walk cannot cycle among ties
    # More steps than this would mean a broken triangulation; the point is then not found.
    for _ in range(4 * s[TRIANGLES] + 9):
        # Test the three edges in doubles; edges with sign 0 stay open.
        on, out, is_open = -1, -1, 0
        for r in range(first, first + 3):
            c = r if r < 3 else r - 3
            i = 3 * tri + c
            # p is certainly on the inner side of the edge just crossed.
            if i == entered:
                continue
            side = filtered_turn(f, h[i, 0], h[i + 1 if c < 2 else i - 2, 0], p)
            if side < 0:
                out = i
                break
            is_open |= int(side == 0) << c

        # Decide the open edges exactly.
        if out < 0 and is_open != 0:
            for c in range(3):
                i = 3 * tri + c
                if (is_open >> c) & 1 == 0:
                    continue
                a, b = h[i, 0], h[next_half_edge(i), 0]
                side = exact_turn(frame, points, a, b, p)
                if side < 0:
                    out = i
                    break
                if side == 0:
                    on = i
        if out < 0:
            return tri, on
        first = 0 if first == 2 else first + 1

        # Continue with the next triangle, or with the neighbour across the edge.
        if scan:
            tri += 1
            if tri >= s[TRIANGLES]:
                break
        else:
            entered = h[out, 1]
            # The walk left the face.
            if entered < 0:
                break
            tri = entered // 3
    return -1, -1


@scalar
def insert_point(frame, mesh, points, p, scan):
    """Insert local point p; False if it is not in the face, which breaks an invariant."""
    s = points.s
    h, v, k = mesh.h, mesh.v, mesh.k
    tri, on = _locate(frame, mesh, points, p, scan)
    if tri < 0:
        return False

    # Split a triangle or an edge, then collect the edges opposite to p.
    new = 3 * s[TRIANGLES]
    n = 3
    if on < 0:
        _split_triangle(h, v, s, tri, p)
        # The three edges of the old triangle are opposite to p now.
        k[0, 0], k[1, 0], k[2, 0] = 3 * tri, new, new + 3
    else:
        split_edge(h, v, s, on, p)
        k[0, 0], k[1, 0] = new + 1, previous_half_edge(on)
        n = 2
        if h[new, 1] >= 0:
            k[2, 0], k[3, 0] = new + 4, previous_half_edge(h[new, 1])
            n = 4

    # With few points one round of flips follows at the end.
    if not scan:
        _legalize(frame, mesh, points, p, n)
    s[START] = v[p]
    return True


@scalar
def legalize_all(frame, mesh, points):
    """Flip until every free edge is Delaunay, in rounds that flip each triangle once at most.

    A cavity often leaves a fan. Flipping edge by edge from fan to fan is quadratic; flipping every
    other edge of a fan first halves the open triangles in each round. k[:, 0] and k[:, 1] are
    the edges of this round and of the next one, k[:, 2] is the round of a triangle's last flip.
    """
    f, s = points.f, points.s
    h, v, k = mesh.h, mesh.v, mesh.k

    # The first round: each free inner edge once.
    n = 0
    for i in range(3 * s[TRIANGLES]):
        h[i, 3] = 0
        k[i, 2] = 0
        # Once per edge, from its lower half-edge.
        if h[i, 1] > i and h[i, 2] < 0:
            h[i, 3] = 1
            k[n, 0] = i
            n += 1
    lap = 0
    while n > 0:
        # Two columns of scratch take the queue of this round and of the next in turns.
        this, other = lap % 2, (lap + 1) % 2
        lap += 1
        later = 0
        for row in range(n):
            i = k[row, this]
            h[i, 3] = 0
            # A flip queues its outer edges, also the border and constraints.
            if h[i, 1] < 0 or h[i, 2] >= 0:
                continue
            j = h[i, 1]

            # A triangle that was flipped in this round waits for the next one.
            if k[i // 3, 2] == lap or k[j // 3, 2] == lap:
                later = _queue(h, k, i, later, other)
                continue

            # Flip an illegal edge; its four neighbours are tested in the next round.
            a, b = h[i, 0], h[j, 0]
            c, o = h[previous_half_edge(i), 0], h[previous_half_edge(j), 0]
            side = filtered_circle(f, a, b, c, o)
            if side > 0 or (side == 0 and exact_in_circle(frame, points, a, b, c, o)):
                flip(h, v, i)
                k[i // 3, 2] = k[j // 3, 2] = lap
                later = _queue(h, k, next_half_edge(i), later, other)
                later = _queue(h, k, previous_half_edge(i), later, other)
                later = _queue(h, k, next_half_edge(j), later, other)
                later = _queue(h, k, previous_half_edge(j), later, other)
        n = later


@scalar
def _queue(h, k, i, n, column):
    """Queue half-edge i for a round, unless it is queued; returns the length of the queue."""
    if h[i, 3] == 0:
        h[i, 3] = 1
        k[n, column] = i
        n += 1
    return n
