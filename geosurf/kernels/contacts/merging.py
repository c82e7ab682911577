"""Points with several names, or equal to a vertex, get one id.

Few points have the coordinates of another point. A bit filter comes first, small enough for the
cache: a point alone on its bit has unique coordinates. Only the others, one in twenty, are entered
into a table by coordinates (`constructed_points`) and compared exactly.

Letters as in `exact_signs`.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.contacts.packed_contact import TRIANGLE_A, TRIANGLE_B
from geosurf.kernels.exact.constructed_points import (
    hash_of_row,
    id_after_collision,
    slot_at_coordinates,
)
from geosurf.kernels.exact.exact_signs import N_POINT, N_VERTEX, Frame

_WORD = 32
_BITS_OF_A_POINT = 16  # filter bits per point: one in sixteen is a false suspect
_FOLDED = 0xFFFFFFFF
# bits of a hash below those that part the suspects: a table for threads has no more slots
_PART = 24


@scalar
def short_hash(x, bits, i):
    """Hash of 62 bits of the coordinates of point i, equal for 0.0 and -0.0; use its upper bits.

    `bits` is x viewed as integers; a view per row would take as long as the products. The three
    products are independent, where `hash_of_row` has six in sequence. A filter may have more
    collisions than a table: they cost time only.
    """
    # 0.0 and -0.0 have different bits and must have one hash.
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
    """Bit of point i in a filter of `size` bits, a power of two."""
    return (short_hash(x, bits, i) >> 8) & (size - 1)


@scalar
def _filter(x, first, n):
    """Bits set by n points from `first` on, bits set more than once, and the bit of each."""
    size, bits = 1024, x.view(np.int64)
    while size < _BITS_OF_A_POINT * n:
        size *= 2
    once = np.zeros(size // _WORD, dtype=np.uint32)
    twice = np.zeros(size // _WORD, dtype=np.uint32)
    place = np.empty(n, dtype=np.int64)
    for k in range(n):
        place[k] = _bit_of(x, bits, first + k, size)

        # A bit that is set already goes into the second filter.
        word, bit = place[k] // _WORD, np.uint32(1 << (place[k] % _WORD))
        twice[word] |= once[word] & bit
        once[word] |= bit
    return once, twice, place


@entry("d2 -> l1")
def may_coincide(x):
    """Rows that may have the coordinates of another row; nearly all others are left out."""
    n = x.shape[0]
    _, twice, place = _filter(x, 0, n)

    # Reuse the array of bits for the result; m never exceeds k.
    m = 0
    for k in range(n):
        if twice[place[k] // _WORD] & np.uint32(1 << (place[k] % _WORD)) != 0:
            place[m] = k  # at or before row k
            m += 1
    return place[:m].copy()


@entry("d2* l2* l1 l1 -> l l1")
def drop_rows(x, t, some, of):
    """Drop rows of `some` (rising) that stand for earlier ones, `of`: what stays, and new rows.

    Rows and triangles are written in place. Of 0.0 and -0.0, which are equal, the last one remains.
    """
    row = np.empty(x.shape[0], dtype=np.int64)
    n = k = 0
    for i in range(x.shape[0]):
        to = n
        if k < some.shape[0] and some[k] == i:
            to = n if of[k] == i else row[of[k]]
            k += 1
        row[i] = to
        x[to, 0], x[to, 1], x[to, 2] = x[i, 0], x[i, 1], x[i, 2]
        n += 1 if to == n else 0
    for face in range(t.shape[0]):
        for c in range(3):
            t[face, c] = row[t[face, c]]
    return n, row


@entry("d2 l2 l1 l2 -> l1 l")
def find_suspects(x, t, m, rows):
    """Vertices and points that may have equal coordinates: ids, vertices first, and their number.

    Corners of faces without a contact, of `rows`, are skipped.
    """
    n_vertex, n_point = m[N_VERTEX], m[N_POINT]
    # Constructed points only; there are many more vertices, and they differ from each other.
    once, twice, place = _filter(x, n_vertex, n_point)
    size, bits = once.shape[0] * _WORD, x.view(np.int64)
    found = np.empty(n_vertex + n_point, dtype=np.int64)
    n = 0

    # Corners of faces with contacts whose bit a point has set.
    asked = np.zeros(n_vertex, dtype=np.bool_)
    for k in range(rows.shape[0]):
        a, b = rows[k, TRIANGLE_A], rows[k, TRIANGLE_B]
        asked[t[a, 0]] = asked[t[a, 1]] = asked[t[a, 2]] = True
        asked[t[b, 0]] = asked[t[b, 1]] = asked[t[b, 2]] = True
    for i in range(n_vertex):
        if asked[i]:
            h = _bit_of(x, bits, i, size)
            word, bit = h // _WORD, np.uint32(1 << (h % _WORD))
            if once[word] & bit != 0:
                twice[word] |= bit
                found[n] = i
                n += 1

    # Points whose bit was set twice.
    n_corner = n
    for k in range(n_point):
        if twice[place[k] // _WORD] & np.uint32(1 << (place[k] % _WORD)) != 0:
            found[n] = n_vertex + k
            n += 1
    return found[:n].copy(), n_corner


@entry("d2* l2* l1* l1* -> .")
def close_up_points(x, d, m, same):
    """Move points into the gaps of merged ones; writes the new id of each to `same`."""
    n_vertex = m[N_VERTEX]
    n = 0
    for row in range(same.shape[0]):
        # A merged point refers to a vertex or to an earlier point, which has moved already.
        if same[row] != n_vertex + row:  # a vertex, or a point before it
            # Ids of points before this one are final already.
            i = same[row]
            same[row] = i if i < n_vertex else same[i - n_vertex]
            continue

        # Move definition and coordinates forward.
        d[n, 0], d[n, 1], d[n, 2], d[n, 3] = d[row, 0], d[row, 1], d[row, 2], d[row, 3]
        i, j = n_vertex + n, n_vertex + row
        x[i, 0], x[i, 1], x[i, 2] = x[j, 0], x[j, 1], x[j, 2]
        same[row] = i
        n += 1
    m[N_POINT] = n


@entry("d2 l2 l2 l2 l1* l1* l1 l l l1* -> l")
def merge_suspects(x, t, e, d, m, w, suspects, part, n_part, same):
    """Merge equal points, and points equal to a vertex, of one part of the suspects; their number.

    Suspects of equal coordinates are in one part. Of equal points the first one remains: its id is
    written to `same` for the others.
    """
    # A table of the suspects only; equal coordinates are compared exactly.
    # At most half full, so that every search ends at an empty slot.
    frame, n_vertex, size = Frame(x, t, e, d, m, w), m[N_VERTEX], 16
    while size < 2 * suspects.shape[0] + 2:
        size *= 2
    places = np.full(size, -1, dtype=np.int64)
    merged = 0
    for k in range(suspects.shape[0]):
        i = suspects[k]
        place = hash_of_row(x, i)
        if (place >> _PART) % n_part != part:
            continue
        slot = slot_at_coordinates(x, places, i, place & (size - 1))
        if places[slot] < 0:
            places[slot] = i
        # The first suspect at these coordinates represents the others; vertices come first.
        else:  # no vertex: corners differ from each other
            same[i - n_vertex] = id_after_collision(frame, places, i, slot)
            merged += 1 if same[i - n_vertex] != i else 0
    return merged
