"""The unique constrained Delaunay triangulation of one cut face: points and flips.

Notation
    h        half-edges, int32 (n, 4): origin (local point), twin (-1 at the border), support
             plane of a constraint (-1: none), mark; half-edge i belongs to triangle i // 3
    v        a half-edge that starts at each local point, int32 (n,)
    q        local points, int32 (n, 8): global id, bits of the face's edges that hold it,
             its row of integers (`kept`), number of the segment that it is known to lie on,
             four lines that it is known to lie on (-1: none)
    f        local points, float64 (n, 8): rounded coordinates (u, v), the larger of their errors,
             both errors; then what rounding left out of (u, v) and the error of that (-1: unknown)
    k        scratch rows, int32 (n, 4)
    s        state, int64 (15,): numbers of points and triangles, axis, segment number, face, start,
             room that is used (`kept`), number of learned lines, sign of the normal on the axis;
             the rest: `byname`

Points are inserted first, then segments (see `segments`), splitting what they cross; then
Lawson flips until every free edge is Delaunay. Of four points on one circle the diagonal
at the lexicographically smallest one wins, which is a regular perturbation, so the result is
unique: it depends on the points and segments only, and faces that overlap agree without
talking.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.cutting.face_circles import exact_in_circle, filtered_circle
from geosurf.kernels.cutting.face_signs import (
    START,
    TRIANGLES,
    exact_turn,
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
    """Write a half-edge that is not marked."""
    h[i, 0], h[i, 1], h[i, 2], h[i, 3] = origin, twin, support, 0


@scalar
def _lead_back(h, twin, i):
    """Half-edge i is the twin of another one now (of none where that is -1)."""
    if twin >= 0:
        h[twin, 1] = i


@scalar
def flip(h, v, i):
    """Replace the edge of half-edge i by the other diagonal."""
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
    """Lawson around a new point p: flip the n edges opposite to it in k[:, 0], and what follows.

    A flip makes an edge at p, which is right, and two opposite to it, which are looked at next.
    """
    f = points.f
    h, v, k = mesh.h, mesh.v, mesh.k
    while n > 0:
        n -= 1
        i = k[n, 0]
        j = h[i, 1]
        if j < 0 or h[i, 2] >= 0:
            continue
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
    """The triangle on one side of an edge that is split at p: what lies behind p is a new one.

    `twin` is that of the new half-edge from p to where half-edge i led; returns that half-edge.
    """
    i1, i2 = next_half_edge(i), previous_half_edge(i)
    b, c = h[i1, 0], h[i2, 0]
    t1, c1 = h[i1, 1], h[i1, 2]
    new = 3 * s[TRIANGLES]
    s[TRIANGLES] += 1
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
    j = h[i, 1]
    new = _split_half(h, v, s, i, p, j)
    if j >= 0:
        other = _split_half(h, v, s, j, p, i)
        h[i, 1], h[j, 1] = other, new
        v[p], v[h[j, 0]], v[h[i, 0]] = new, j, i


@scalar
def _locate(frame, mesh, points, p, scan):
    """Triangle that holds point p, and the half-edge it lies on (-1: inside); tri -1: lost.

    What doubles leave open is asked only where they see p behind none of the edges.
    """
    f, s = points.f, points.s
    h = mesh.h
    tri = 0 if scan else s[START] // 3
    entered = -1  # the half-edge that was crossed last: p is on its left
    first = 0  # another edge at each step, so that a walk among ties cannot run in a circle
    for _ in range(4 * s[TRIANGLES] + 9):
        on, out, is_open = -1, -1, 0
        for r in range(first, first + 3):
            c = r if r < 3 else r - 3
            i = 3 * tri + c
            if i == entered:
                continue
            side = filtered_turn(f, h[i, 0], h[i + 1 if c < 2 else i - 2, 0], p)
            if side < 0:
                out = i
                break
            is_open |= int(side == 0) << c
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
        if scan:
            tri += 1
            if tri >= s[TRIANGLES]:
                break
        else:
            entered = h[out, 1]
            if entered < 0:
                break
            tri = entered // 3
    return -1, -1


@scalar
def insert_point(frame, mesh, points, p, scan):
    """Insert local point p; False if it is not in the face (which breaks a promise)."""
    s = points.s
    h, v, k = mesh.h, mesh.v, mesh.k
    tri, on = _locate(frame, mesh, points, p, scan)
    if tri < 0:
        return False
    new = 3 * s[TRIANGLES]
    n = 3
    if on < 0:
        _split_triangle(h, v, s, tri, p)
        k[0, 0], k[1, 0], k[2, 0] = 3 * tri, new, new + 3
    else:
        split_edge(h, v, s, on, p)
        k[0, 0], k[1, 0] = new + 1, previous_half_edge(on)
        n = 2
        if h[new, 1] >= 0:
            k[2, 0], k[3, 0] = new + 4, previous_half_edge(h[new, 1])
            n = 4
    if not scan:
        _legalize(frame, mesh, points, p, n)
    s[START] = v[p]
    return True


@scalar
def legalize_all(frame, mesh, points):
    """Flip until every free edge is Delaunay, in rounds that flip each triangle once at most.

    What a cavity leaves is often a fan. From fan to fan, edge by edge, flipping is quadratic; where
    every other edge of a fan is flipped first, half of its triangles are done with in each round.
    k[:, 0] and k[:, 1] are the edges of this round and of the next one, k[:, 2] is the round in
    which a triangle was flipped last.
    """
    f, s = points.f, points.s
    h, v, k = mesh.h, mesh.v, mesh.k
    n = 0
    for i in range(3 * s[TRIANGLES]):
        h[i, 3] = 0
        k[i, 2] = 0
        if h[i, 1] > i and h[i, 2] < 0:
            h[i, 3] = 1
            k[n, 0] = i
            n += 1
    lap = 0
    while n > 0:
        this, other = lap % 2, (lap + 1) % 2
        lap += 1
        later = 0
        for row in range(n):
            i = k[row, this]
            h[i, 3] = 0
            if h[i, 1] < 0 or h[i, 2] >= 0:
                continue
            j = h[i, 1]
            if k[i // 3, 2] == lap or k[j // 3, 2] == lap:
                later = _queue(h, k, i, later, other)
                continue
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
    """File half-edge i for a round, unless it is; returns how many are filed."""
    if h[i, 3] == 0:
        h[i, 3] = 1
        k[n, column] = i
        n += 1
    return n
