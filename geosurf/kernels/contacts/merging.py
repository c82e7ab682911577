"""Points that are one by several names, or a vertex, get one number.

Few points have the coordinates of another one, and none is told from all others without a look at
all. A filter of bits comes first, so small that it stays in a cache: what is alone with its bit
has coordinates of its own. Only the rest, one in twenty, goes into a table of places (`points`).

Letters as in `exact`.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.exact.constructed_points import (
    hash_of_row,
    id_after_collision,
    slot_at_coordinates,
)
from geosurf.kernels.exact.exact_signs import N_POINT, N_VERTEX

_WORD = 32
_BITS_OF_A_POINT = 16  # in the filter: then one in sixteen is suspected for nothing
_FOLDED = 0xFFFFFFFF


@scalar
def _short_hash(x, bits, i):
    """Hash of 62 bits of the coordinates of point i, alike for 0.0 and -0.0; its upper bits count.

    `bits` are all of x as whole numbers: a view of each row alone takes as long as the products.

    Three products that do not wait for each other, where `hash_of_row` has six that do. A filter
    may spread worse than a table: what it mixes up costs time only.
    """
    h = 0
    if x[i, 0] != 0.0:
        h += ((bits[i, 0] ^ (bits[i, 0] >> 32)) & _FOLDED) * 0x1E3779B1
    if x[i, 1] != 0.0:
        h += ((bits[i, 1] ^ (bits[i, 1] >> 32)) & _FOLDED) * 0x165667B5
    if x[i, 2] != 0.0:
        h += ((bits[i, 2] ^ (bits[i, 2] >> 32)) & _FOLDED) * 0x0AC564B5
    return h ^ (h >> 31)


@scalar
def _bit_of(x, bits, i, size):
    """Place of point i in a filter of `size` bits, a power of two."""
    return (_short_hash(x, bits, i) >> 8) & (size - 1)


@scalar
def _filter(x, first, n):
    """Bits that n points from `first` on set, those set more than once, and the bit of each."""
    size, bits = 1024, x.view(np.int64)
    while size < _BITS_OF_A_POINT * n:
        size *= 2
    once = np.zeros(size // _WORD, dtype=np.uint32)
    twice = np.zeros(size // _WORD, dtype=np.uint32)
    place = np.empty(n, dtype=np.int64)
    for k in range(n):
        place[k] = _bit_of(x, bits, first + k, size)
        word, bit = place[k] // _WORD, np.uint32(1 << (place[k] % _WORD))
        twice[word] |= once[word] & bit
        once[word] |= bit
    return once, twice, place


@entry("d2 -> l1")
def may_coincide(x):
    """Rows of places that may be those of another row; nearly all others are left out."""
    n = x.shape[0]
    _, twice, place = _filter(x, 0, n)
    m = 0
    for k in range(n):
        if twice[place[k] // _WORD] & np.uint32(1 << (place[k] % _WORD)) != 0:
            place[m] = k  # at or before row k
            m += 1
    return place[:m].copy()


@scalar
def _suspects(x, t, m, count):
    """Vertices and points that may lie where a point lies: ids, vertices first, and how many.

    `count` is 0 for faces without a contact: their corners are left alone.
    """
    n_vertex, n_point = m[N_VERTEX], m[N_POINT]
    once, twice, place = _filter(x, n_vertex, n_point)
    size, bits = once.shape[0] * _WORD, x.view(np.int64)
    found = np.empty(n_vertex + n_point, dtype=np.int64)
    n = 0
    asked = np.zeros(n_vertex, dtype=np.bool_)
    for face in range(t.shape[0]):
        if count[face] > 0:
            asked[t[face, 0]] = asked[t[face, 1]] = asked[t[face, 2]] = True
    for i in range(n_vertex):
        if asked[i]:
            h = _bit_of(x, bits, i, size)
            word, bit = h // _WORD, np.uint32(1 << (h % _WORD))
            if once[word] & bit != 0:
                twice[word] |= bit
                found[n] = i
                n += 1
    n_corner = n
    for k in range(n_point):
        if twice[place[k] // _WORD] & np.uint32(1 << (place[k] % _WORD)) != 0:
            found[n] = n_vertex + k
            n += 1
    return found[:n], n_corner


@scalar
def _compact(x, d, m, same):
    """Move points to where those before them have left room; the new id of each."""
    n_vertex = m[N_VERTEX]
    n = 0
    for row in range(same.shape[0]):
        if same[row] != n_vertex + row:  # a vertex, or a point before it
            i = same[row]
            same[row] = i if i < n_vertex else same[i - n_vertex]
            continue
        d[n, 0], d[n, 1], d[n, 2], d[n, 3] = d[row, 0], d[row, 1], d[row, 2], d[row, 3]
        i, j = n_vertex + n, n_vertex + row
        x[i, 0], x[i, 1], x[i, 2] = x[j, 0], x[j, 1], x[j, 2]
        same[row] = i
        n += 1
    m[N_POINT] = n


@scalar
def merge_points(frame, count):
    """Make points that are one, or a vertex, one; the new id of each, or nothing if none was.

    `count` is the number of contacts of each face. Of points that are one, the first one stays;
    those that stay keep their order.
    """
    x, t, d, m = frame.x, frame.t, frame.d, frame.m
    suspects, n_corner = _suspects(x, t, m, count)
    n_vertex, n_point = m[N_VERTEX], m[N_POINT]
    none = np.empty(0, dtype=np.int64)
    if suspects.shape[0] == n_corner:
        return none
    size = 16
    while size < 2 * suspects.shape[0] + 2:
        size *= 2
    places = np.full(size, -1, dtype=np.int64)
    same = np.arange(n_vertex, n_vertex + n_point)
    merged = 0
    for k in range(suspects.shape[0]):
        i = suspects[k]
        slot = slot_at_coordinates(x, places, i, hash_of_row(x, i) & (size - 1))
        if places[slot] < 0:
            places[slot] = i
        else:  # no vertex: corners differ from each other
            same[i - n_vertex] = id_after_collision(frame, places, i, slot)
            merged += 1 if same[i - n_vertex] != i else 0
    if merged == 0:
        return none
    _compact(x, d, m, same)
    return same
