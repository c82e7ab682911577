"""Named points from contacts of triangles, and the records of what cuts each triangle.

A point is named by its definition: a corner, or an edge and a face, or two edges in one plane.
Names come first, from integers alone. Then all points are placed (`place_points`), and
points with several names are merged (`merging`): `geosurf.arrangement.arrange` has all steps.

A record is (triangle, p, q, support): a segment p-q inside the triangle and a plane that holds it,
or a single point (q = support = -1). Both triangles of a contact get the point or segment. So
neighbours have the same points on a common edge, and the children conform without communication.

Letters as in `exact_signs`, contacts as in `triangle_contact`, and
    names    hash table (`constructed_points`): edge planes, and points that no list holds
    heads    first point of each list, -1 if empty: lists of faces, then lists of vertices
    onward   the next point in the list of each
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.contacts.triangle_contact import (
    EDGE_OF_SECOND,
    FACE,
    HOW,
    TRIANGLE_A,
    TRIANGLE_B,
    code_of,
    is_corner,
    lies_in_plane,
    n_corner_of,
)
from geosurf.kernels.exact.constructed_points import (
    EDGE_PLANE,
    FULL,
    LPI,
    edge_plane,
    hash_of_row,
    id_after_collision,
    insert_name,
    round_point,
    slot_at_coordinates,
    slot_of,
)
from geosurf.kernels.exact.exact_signs import (
    N_EDGE_PLANE,
    N_NAME,
    N_POINT,
    N_TRIANGLE,
    N_VERTEX,
    Frame,
)
from geosurf.kernels.exact.predicates import normal_axis


@scalar
def _edge_and_face(t, a, b, code):
    """The edge (lower vertex first) and the face that define a corner of a contact."""
    # Features of A and of B: a corner below 3, an edge 3 + i, or FACE.
    fa, fb = (code >> 3) & 7, code & 7

    # The edge of A defines the point, unless the code says that of B.
    if fa < FACE and (code >> 3) < EDGE_OF_SECOND:
        edge_face, i, face = a, fa - 3, b
    else:
        edge_face, i, face = b, fb - 3, a
    # The lower vertex first: both triangles of an edge name its points alike.
    p, q = t[edge_face, i], t[edge_face, 0 if i == 2 else i + 1]
    return min(p, q), max(p, q), face


@scalar
def _count_corners(rows):
    """Number of corners of all contacts."""
    n_corner = 0
    for k in range(rows.shape[0]):
        n_corner += n_corner_of(rows[k, HOW])
    return n_corner


@scalar
def _grown_table(m, names):
    """The table of names, rebuilt at twice the size if one more contact could fill it."""
    # One contact adds fewer than 16 names.
    if 2 * (m[N_NAME] + 16) < names.shape[0]:
        return names

    # Insert all names again: slots depend on the size.
    larger = np.zeros((2 * names.shape[0], 5), dtype=np.int64)
    m[N_NAME] = 0
    for i in range(names.shape[0]):
        if names[i, 0] != 0:
            kind, a, b, c = names[i, 0], names[i, 1], names[i, 2], names[i, 3]
            insert_name(m, larger, slot_of(larger, kind, a, b, c), kind, a, b, c, names[i, 4])
    return larger


@scalar
def _new_point(d, m, p, q, plane):
    """Define the next point as edge p-q through a plane; its row in `d`."""
    row = m[N_POINT]
    d[row, 0], d[row, 1], d[row, 2], d[row, 3] = LPI, p, q, plane
    m[N_POINT] += 1
    return row


@scalar
def _point_by_table(d, m, names, p, q, plane):
    """Row in `d` of a point from the table of names, defined if it is new."""
    slot = slot_of(names, LPI, p, q, plane)
    if names[slot, 0] == 0:
        insert_name(m, names, slot, LPI, p, q, plane, _new_point(d, m, p, q, plane))
    return names[slot, 4]


@scalar
def _corner_in_plane(t, e, d, m, names, a, b, axis, code):
    """Id of the common point of two features in one plane."""
    fa = (code >> 3) & 7
    fb = code & 7

    # A corner of either triangle is a vertex.
    if fa < 3:
        return t[a, fa]
    if fb < 3:
        return t[b, fb]

    # Two edges: the edge of A and the plane through the edge of B along the axis.
    support = edge_plane(e, m, names, t[b, fb - 3], t[b, (fb - 2) % 3], axis)
    if support == FULL:
        return FULL
    p, q = t[a, fa - 3], t[a, (fa - 2) % 3]
    return m[N_VERTEX] + _point_by_table(d, m, names, min(p, q), max(p, q), support)


@scalar
def _name_corners(frame, rows, ids):
    """Ids of the corners of all contacts, by names alone; False if a table is full."""
    x, t, e, d, m, w = frame.x, frame.t, frame.e, frame.d, frame.m, frame.w

    names = np.zeros((64, 5), dtype=np.int64)
    for k in range(rows.shape[0]):
        a, b = rows[k, TRIANGLE_A], rows[k, TRIANGLE_B]
        names = _grown_table(m, names)
        coplanar = lies_in_plane(rows[k, HOW])
        # The axis along which coplanar triangles are projected.
        axis = 0
        if coplanar:
            axis, _ = normal_axis(x, m, w, t[a, 0], t[a, 1], t[a, 2])

        # Corners that are vertices need no new name.
        for c in range(n_corner_of(rows[k, HOW])):
            code = code_of(rows[k, HOW], c)
            if coplanar:
                ids[k, c] = _corner_in_plane(t, e, d, m, names, a, b, axis, code)
                if ids[k, c] == FULL:
                    return False
            elif (code >> 3) & 7 < 3:
                ids[k, c] = t[a, (code >> 3) & 7]
            elif code & 7 < 3:
                ids[k, c] = t[b, code & 7]
            else:
                p, q, face = _edge_and_face(t, a, b, code)
                ids[k, c] = m[N_VERTEX] + _point_by_table(d, m, names, p, q, face)
    return True


@scalar
def _append_record(records, n, t, tri, p, q, support):
    """Append a segment or a point (q = -1) for a triangle, unless its own edges hold it."""
    # Points and segments on the own corners or edges cut nothing.
    if q < 0:
        if is_corner(t, tri, p):
            return n
    elif is_corner(t, tri, p) and is_corner(t, tri, q):
        return n
    records[n, 0] = tri
    # Both triangles of a contact write the segment alike: lower id first.
    if 0 <= q < p:
        p, q = q, p
    records[n, 1], records[n, 2], records[n, 3] = p, q, support
    return n + 1


@scalar
def _edge_records(frame, names, how, ids, tri, other, shift, axis, records, n):
    """Segments in `tri` along the edges of the coplanar triangle `other`; -1 if a table is full.

    `shift` selects the features of `of` from a code: 3 for the first triangle, 0 for the second.
    """
    t = frame.t
    for i in range(3):
        # Two different corners on edge i make a segment along it.
        first = -1
        second = -1
        for c in range(n_corner_of(how)):
            feature = (code_of(how, c) >> shift) & 7
            # On edge i: one of its corners, or the edge itself.
            if feature == i or feature == (i + 1) % 3 or feature == 3 + i:
                if first < 0:
                    first = ids[c]
                elif ids[c] != first:
                    # The outline is convex: an edge has no more than two different points of it.
                    second = ids[c]
        if second >= 0 and not (is_corner(t, tri, first) and is_corner(t, tri, second)):
            support = edge_plane(frame.e, frame.m, names, t[other, i], t[other, (i + 1) % 3], axis)
            if support == FULL:
                return -1
            n = _append_record(records, n, t, tri, first, second, support)
    return n


@scalar
def _records_in_plane(frame, names, row, ids, axis, records, n):
    """Corners and edges of two faces of one plane for each other; -1 if a table is full."""
    t, how = frame.t, row[HOW]
    a, b = row[TRIANGLE_A], row[TRIANGLE_B]

    # Corners first, then the edges of each triangle inside the other.
    # Points of the common outline, for both faces; those on own corners are left out.
    for c in range(n_corner_of(how)):
        n = _append_record(records, n, t, a, ids[c], -1, -1)
        n = _append_record(records, n, t, b, ids[c], -1, -1)
    n = _edge_records(frame, names, how, ids, a, b, 0, axis, records, n)
    if n >= 0:
        n = _edge_records(frame, names, how, ids, b, a, 3, axis, records, n)
    return n


@entry("d2 l2 l2* l2* l1* l1* l2 l2* -> l")
def name_corners(x, t, e, d, m, w, rows, ids):
    """Write the ids of all points of contact, by names alone, to `ids`; their number or FULL.

    `x` and `d` need room for one point per corner behind the vertices.
    """
    frame = Frame(x, t, e, d, m, w)
    n_corner = _count_corners(rows)
    # Room for the worst case, one point per corner: the loops below need no test.
    if min(d.shape[0], x.shape[0] - m[N_VERTEX]) < n_corner:
        return FULL
    if not _name_corners(frame, rows, ids):
        return FULL
    m[N_NAME] = 0  # the table is not used again
    return m[N_POINT]


@entry("d2* l2 l2 l2 l1* l1* l l -> .")
def place_points(x, t, e, d, m, w, low, high):
    """Correctly rounded coordinates of constructed points `low` to `high` - 1, each of an edge and
    a plane.
    """
    frame = Frame(x, t, e, d, m, w)
    for row in range(low, high):
        round_point(frame, m[N_VERTEX] + row)


@scalar
def _edge_planes(e, m):
    """Table of the names of all edge planes."""
    m[N_NAME] = 0
    names = np.zeros((64, 5), dtype=np.int64)
    for row in range(m[N_EDGE_PLANE]):
        names = _grown_table(m, names)
        a, b, axis = e[row, 0], e[row, 1], e[row, 2]
        slot = slot_of(names, EDGE_PLANE, a, b, axis)
        insert_name(m, names, slot, EDGE_PLANE, a, b, axis, m[N_TRIANGLE] + row)
    return names


@entry("d2 l2 l2* l1* l1* l2 l2 l2* -> l")
def write_records(x, t, e, m, w, rows, ids, records):
    """Write which segments and points cut which face; the number of records, or FULL.

    `records` needs room for two per contact and twelve more for a coplanar one, `e` for six of
    these.
    """
    # The table of the naming is gone: edge planes are entered again, to be found by name.
    names = _edge_planes(e, m)
    frame = Frame(x, t, e, rows, m, w)  # without definitions of points
    n = 0
    for k in range(rows.shape[0]):
        a, b = rows[k, TRIANGLE_A], rows[k, TRIANGLE_B]

        # Coplanar: both outlines cut each other. Otherwise a segment or a touching point.
        if lies_in_plane(rows[k, HOW]):
            names = _grown_table(m, names)
            axis, _ = normal_axis(x, m, w, t[a, 0], t[a, 1], t[a, 2])
            n = _records_in_plane(frame, names, rows[k], ids[k], axis, records, n)
            if n < 0:
                return FULL
        elif n_corner_of(rows[k, HOW]) == 2:
            n = _append_record(records, n, t, a, ids[k, 0], ids[k, 1], b)
            n = _append_record(records, n, t, b, ids[k, 0], ids[k, 1], a)
        else:
            n = _append_record(records, n, t, a, ids[k, 0], -1, -1)
            n = _append_record(records, n, t, b, ids[k, 0], -1, -1)
    m[N_NAME] = 0
    return n


# ---- merging ----------------------------------------
# Points with several names, or equal to a vertex, get one id.
#
# Few points have the coordinates of another point. A bit filter comes first, small enough for the
# cache: a point alone on its bit has unique coordinates. Only the others, one in twenty, are
# entered into a table by coordinates (`constructed_points`) and compared exactly.
#
# Letters as in `exact_signs`.


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


@entry("d2 l2 l1 l2 -> l1 l")
def find_suspects(x, t, m, rows):
    """Vertices and points that may have equal coordinates: ids, vertices first, and their number.

    Corners of faces without a contact, of `rows`, are skipped.
    """
    n_vertex, n_point = m[N_VERTEX], m[N_POINT]
    # Constructed points only; there are many more vertices, and they differ from each other.
    once, twice, place = _filter(x, n_vertex, n_point)
    size, bits = once.shape[0] * _WORD, x.view(np.int64)
    suspects = np.empty(n_vertex + n_point, dtype=np.int64)
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
                suspects[n] = i
                n += 1

    # Points whose bit was set twice.
    n_corner = n
    for k in range(n_point):
        if twice[place[k] // _WORD] & np.uint32(1 << (place[k] % _WORD)) != 0:
            suspects[n] = n_vertex + k
            n += 1
    return suspects[:n].copy(), n_corner


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
