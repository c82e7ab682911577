"""Children of all cut faces: each face on its own, all with the same exact decisions.

Neighbouring faces agree on their common edges without communication, because all signs are exact
and ties are broken by coordinates (see `delaunay`).
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.contacts.triangle_contact import (
    HOW,
    TRIANGLE_A,
    TRIANGLE_B,
    lies_in_plane,
    lies_on_boundaries,
)
from geosurf.kernels.cutting.constraints import constrain_edge, insert_segment, point_in_tables
from geosurf.kernels.cutting.delaunay import FaceMesh, insert_point, legalize_all
from geosurf.kernels.cutting.face_signs import (
    AXIS,
    FACE_ID,
    LINES,
    N_STATE,
    POINTS,
    SEGMENT,
    SIDE,
    START,
    TRIANGLES,
    USED,
    FacePoints,
    add_corner,
    add_line,
    add_local,
    in_circle,
)
from geosurf.kernels.exact.constructed_points import FULL
from geosurf.kernels.exact.exact_signs import N_VERTEX, Frame
from geosurf.kernels.exact.predicates import ORIENT2D_BOUND, TINY, normal_axis, orient2d

# ---- record groups ----------------------------------------
# Records by the faces that they cut: each segment and point once, in one order.
#
# Notation
#     records   int64 (n, 4): a face, the first point of a segment, its second point (-1: a point
#               alone), and the plane that cuts; see `naming`


_FEW_RECORDS = 32  # records of a face that are sorted by insertion
_POINT = 31  # bits of the number of a point


@scalar
def _sort(keys, rows, n):
    """Sort the first n keys, and rows with them."""
    if n > _FEW_RECORDS:
        order = np.argsort(keys[:n])
        some, of = keys[:n].copy(), rows[:n].copy()
        for k in range(n):
            keys[k], rows[k] = some[order[k]], of[order[k]]
        return
    for k in range(1, n):
        key, row, j = keys[k], rows[k], k
        while j > 0 and keys[j - 1] > key:
            keys[j], rows[j] = keys[j - 1], rows[j - 1]
            j -= 1
        keys[j], rows[j] = key, row


@entry("l2 l l l -> l2 l1")
def group_records(records, low, high, n_point):
    """Records of faces `low` to `high` - 1 by face, first point and second point, each once; and
    the offsets of the faces.

    Of several with the same points, the one with the lowest plane is kept. A point is left out
    where it ends a segment of its face: contacts with more neighbours than are needed add no more
    than such points.
    """
    n_face = high - low
    # entry face + 1 counts the records of a face; sums make it the first place of each
    start = np.zeros(n_face + 1, dtype=np.int64)
    for k in range(records.shape[0]):
        if low <= records[k, 0] < high:
            start[records[k, 0] - low + 1] += 1
    most = 0
    for face in range(n_face):
        most = max(most, start[face + 1])
        start[face + 1] += start[face]
    n = start[n_face]
    by_face = np.empty(n, dtype=np.int64)
    for k in range(records.shape[0]):  # each start moves to where the next one begins
        if low <= records[k, 0] < high:
            face = records[k, 0] - low
            by_face[start[face]] = k
            start[face] += 1

    out, offsets = np.empty((n, 4), dtype=np.int64), np.empty(n + 1, dtype=np.int64)
    keys, rows = np.empty(most, dtype=np.int64), np.empty(most, dtype=np.int64)
    ends = np.full(n_point, -1, dtype=np.int64)  # the last face with a segment that ends there
    n_out = n_group = begin = 0
    for face in range(n_face):
        end = start[face]
        if begin == end:  # most faces of a change
            continue
        for k in range(begin, end):
            r = by_face[k]
            if records[r, 2] >= 0:
                ends[records[r, 1]] = ends[records[r, 2]] = face
        m = 0
        for k in range(begin, end):
            r = by_face[k]
            if records[r, 2] >= 0 or ends[records[r, 1]] != face:
                keys[m] = (records[r, 1] << _POINT) + records[r, 2] + 1
                rows[m] = r
                m += 1
        if m > 1:
            _sort(keys, rows, m)

        if m > 0:
            offsets[n_group] = n_out
            n_group += 1
        for k in range(m):
            if k > 0 and keys[k] == keys[k - 1]:
                out[n_out - 1, 3] = min(out[n_out - 1, 3], records[rows[k], 3])
                continue
            for column in range(4):
                out[n_out, column] = records[rows[k], column]
            n_out += 1
        begin = end
    offsets[n_group] = n_out
    return out[:n_out].copy(), offsets[: n_group + 1].copy()


BROKEN = -8
_BLOCK = 8  # consecutive points along the curve that are inserted together
_SMALL = 16  # faces with fewer points are searched triangle by triangle


@scalar
def _bits_on_edges(t, d, m, tri, i):
    """Edges of a face that hold constructed point i according to its definition: bits 1, 2, 4."""
    row = i - m[N_VERTEX]
    # Vertices have no definition, and points of three planes lie on no edge.
    if row < 0 or d[row, 0] != 1:
        return 0
    for k in range(3):
        a, b = t[tri, k], t[tri, (k + 1) % 3]
        if (d[row, 1] == a and d[row, 2] == b) or (d[row, 1] == b and d[row, 2] == a):
            return 1 << k
    return 0


@scalar
def _start_face(x, t, points, mesh):
    """Make the face itself the first triangle, counter-clockwise on its axis."""
    q, f, s = points.q, points.f, points.s
    h, v = mesh.h, mesh.v
    tri = s[FACE_ID]
    s[POINTS], s[TRIANGLES], s[SEGMENT] = 0, 1, 0
    s[START], s[USED], s[LINES] = 0, 0, 0

    # The triangulation is counter-clockwise on its axis, whichever way the face looks.
    second, third = (1, 2) if s[SIDE] > 0 else (2, 1)
    # bits: edge k joins corners k and k + 1
    add_corner(x, q, f, s, t[tri, 0], 1 | 4)
    add_corner(x, q, f, s, t[tri, second], 3 if second == 1 else 6)
    add_corner(x, q, f, s, t[tri, third], 3 if third == 1 else 6)
    for k in range(3):
        h[k, 0], h[k, 1], h[k, 2], h[k, 3] = k, -1, -1, 0
        v[k] = k


@scalar
def _local_of(local, frame, points, tri, i):
    """Local index of global id i, added if it is new."""
    t, d, m = frame.t, frame.d, frame.m
    if local[i] < 0:
        local[i] = add_local(frame, points, i, _bits_on_edges(t, d, m, tri, i))
    return local[i]


@scalar
def _cut_by_one_segment(frame, mesh, points, i, j):
    """A face with one segment between two of its edges: three children; False if it is not so.

    Half of all cut faces are of this kind. Only the diagonal of the part with four corners has to
    be chosen, by the same rule as in `delaunay`.
    """
    x, t, d, m = frame.x, frame.t, frame.d, frame.m
    q, f, s = points.q, points.f, points.s
    h = mesh.h
    tri = s[FACE_ID]
    bits_i, bits_j = _bits_on_edges(t, d, m, tri, i), _bits_on_edges(t, d, m, tri, j)
    # Ends inside the face, or on one edge, take the general way.
    if bits_i == 0 or bits_j == 0 or bits_i == bits_j:
        return False

    # The lone corner is between the two cut edges; orient the segment from its side.
    both = bits_i | bits_j  # edges k and k - 1 meet at corner k
    lone = 0 if both == 5 else (1 if both == 3 else 2)
    first = i if bits_i == 1 << lone else j
    second = j if bits_i == 1 << lone else i

    # Local points: the lone corner, first cut, two corners, second cut.
    s[POINTS], s[TRIANGLES], s[USED], s[LINES] = 0, 3, 0, 0
    add_corner(x, q, f, s, t[tri, lone], 0)
    add_local(frame, points, first, 0)
    add_corner(x, q, f, s, t[tri, (lone + 1) % 3], 0)
    add_corner(x, q, f, s, t[tri, (lone + 2) % 3], 0)
    add_local(frame, points, second, 0)
    # the part with four corners, counter-clockwise on the axis
    a, b, c, o = (1, 2, 3, 4) if s[SIDE] > 0 else (4, 3, 2, 1)

    # The triangle at the lone corner, then the quadrilateral by its Delaunay diagonal.
    # Only corners are written: no flip or walk follows.
    h[0, 0], h[1, 0], h[2, 0] = 0, a, o
    if in_circle(frame, points, a, c, o, b):
        h[3, 0], h[4, 0], h[5, 0] = a, b, o
        h[6, 0], h[7, 0], h[8, 0] = b, c, o
    else:
        h[3, 0], h[4, 0], h[5, 0] = a, b, c
        h[6, 0], h[7, 0], h[8, 0] = a, c, o
    return True


@scalar
def _insert_points(frame, mesh, points, scratch):
    """Insert all local points except the corners; False if one is not in the face.

    Few points are located triangle by triangle, and flips come last. Many points are sorted along
    the Hilbert curve and inserted in rounds of doubling size, as in BRIO (Amenta, Choi & Rote 2003)
    but evenly spaced in rank: the first, then the middle, then the quarters. Each walk starts at
    the inserted point nearest in rank. The last rounds run block by block, for locality of memory.
    """
    f, s = points.f, points.s

    # Few points: scan all triangles, then legalize once.
    n = s[POINTS]
    if n <= _SMALL:
        for p in range(3, n):
            if not insert_point(frame, mesh, points, p, True):
                return False
        legalize_all(frame, mesh, points)
        return True

    # Many points: coarse to fine along the curve.
    rank_points(f, 3, n, scratch)
    n -= 3
    step = 1
    while step < n:
        step *= 2
    if not insert_point(frame, mesh, points, scratch[0], False):
        return False
    while step > _BLOCK:  # the first of each block, coarse to fine
        if not _insert_between(frame, mesh, points, scratch, 0, n, step):
            return False
        step //= 2
    for low in range(0, n, _BLOCK):
        step = _BLOCK
        while step > 1:
            high = min(low + _BLOCK, n)
            if not _insert_between(frame, mesh, points, scratch, low, high, step):
                return False
            step //= 2
    return True


@scalar
def _insert_between(frame, mesh, points, scratch, low, high, step):
    """Insert the points half-way between every step-th rank, from low on below high."""
    s = points.s
    v = mesh.v
    for c in range(low + step // 2, high, step):
        # The walk starts at a point that is near in rank, hence near in space.
        s[START] = v[scratch[c - step // 2]]
        if not insert_point(frame, mesh, points, scratch[c], False):
            return False
    return True


@scalar
def _insert_segments(frame, names, places, records, low, high, local, mesh, points, scratch):
    """Insert the segments of a face: 0, FULL, or -1 (broken).

    Segments that are edges already are only marked. The others come in a fixed shuffle, which keeps
    corridors short on average.
    """
    h, v = mesh.h, mesh.v

    # Edges first; what is left goes into the scratch list.
    n = 0
    for r in range(low, high):
        # Records without a second point are single points, which are inserted already.
        if records[r, 2] >= 0:
            a, b = local[records[r, 1]], local[records[r, 2]]
            if not constrain_edge(h, v, a, b, records[r, 3]):
                scratch[n] = r
                n += 1

    # A prime stride visits each segment once in shuffled order.
    stride = 7919 if n % 7919 != 0 else 7907
    for c in range(n):
        r = scratch[(c * stride) % n]
        a, b = local[records[r, 1]], local[records[r, 2]]
        done = insert_segment(frame, names, places, mesh, points, a, b, records[r, 3])
        if done < 0:
            return done
    if n > 0:
        legalize_all(frame, mesh, points)
    return 0


@scalar
def _cut_face(frame, names, places, records, low, high, local, mesh, points, scratch, tri):
    """Triangulate one face with its records; 0, FULL or BROKEN."""
    x, t, m, w = frame.x, frame.t, frame.m, frame.w
    q, s = points.q, points.s
    s[FACE_ID] = tri
    s[AXIS], s[SIDE] = normal_axis(x, m, w, t[tri, 0], t[tri, 1], t[tri, 2])

    # The most common case without a triangulation.
    if (
        high - low == 1
        and records[low, 2] >= 0
        and _cut_by_one_segment(frame, mesh, points, records[low, 1], records[low, 2])
    ):
        return 0

    # General case: corners, points of all records, then segments.
    _start_face(x, t, points, mesh)
    for c in range(3):
        # Corners come first; records may refer to them.
        local[q[c, 0]] = c
    for r in range(low, high):
        a = _local_of(local, frame, points, tri, records[r, 1])
        if records[r, 2] >= 0:
            b = _local_of(local, frame, points, tri, records[r, 2])
            add_line(q, a, records[r, 3])
            add_line(q, b, records[r, 3])
    if not _insert_points(frame, mesh, points, scratch):
        return BROKEN
    done = _insert_segments(frame, names, places, records, low, high, local, mesh, points, scratch)
    return done if done >= 0 or done == FULL else BROKEN


@scalar
def _turns_left(f, a, b, c):
    """Whether a triangle certainly turns left after its corners are rounded."""
    left = (f[b, 0] - f[a, 0]) * (f[c, 1] - f[a, 1])
    right = (f[b, 1] - f[a, 1]) * (f[c, 0] - f[a, 0])
    size = abs(left) + abs(right)

    # Collinear or undecided children count as suspects: exact arithmetic tests them later.
    return size > TINY and left - right > ORIENT2D_BOUND * size


@scalar
def _write_children(points, mesh, local, children, parents, out, suspect, n_suspect):
    """Write the triangles of a face, oriented as the face, and clear `local`.

    Returns the number of children, and of those that rounding may have inverted.
    """
    q, s, f = points.q, points.s, points.f
    h = mesh.h
    for c in range(s[TRIANGLES]):
        # Restore the orientation of the face, which was counter-clockwise on its axis.
        p0, p1, p2 = h[3 * c, 0], h[3 * c + 1, 0], h[3 * c + 2, 0]
        if not _turns_left(f, p0, p1, p2):
            suspect[n_suspect] = out
            n_suspect += 1
        children[out, 0] = q[p0, 0]
        children[out, 1] = q[p1 if s[SIDE] > 0 else p2, 0]
        children[out, 2] = q[p2 if s[SIDE] > 0 else p1, 0]
        parents[out] = s[FACE_ID]
        out += 1

    # Clear only what this face has set: the table has an entry for each point of the model.
    for c in range(s[POINTS]):
        if q[c, 0] < local.shape[0]:
            local[q[c, 0]] = -1
    return out, n_suspect


@entry("d2* l2 l2 l2* l1* l1* l2* l1* l2 l1 l l2* l1* -> l l1")
def cut_faces(x, t, e, d, m, w, names, places, records, offsets, n_local, children, parents):
    """Children of all cut faces: their number, FULL, or BROKEN - (face number); and suspect rows.

    ``records[offsets[i]:offsets[i + 1]]`` belong to one face, which has room for `n_local` points.
    `names` and `places`, with two slots in each of its numbers, need no initial values: what is
    used of both is cleared, and the ``m[UNINDEXED]`` points are entered, when the first point is
    created.
    Suspect children are those for which doubles do not prove the orientation of their parents.
    """
    s = np.zeros(N_STATE, dtype=np.int64)
    slots = places.view(np.int32)  # half the memory of int64, as below
    half = 6 * n_local + 64
    h = np.empty((half, 4), dtype=np.int32)  # half the memory traffic of int64
    v = np.empty(n_local, dtype=np.int32)
    k = np.empty((2 * half + 256, 4), dtype=np.int32)  # corridors need five rows per triangle
    q = np.empty((n_local, 8), dtype=np.int32)
    f = np.empty((n_local, 5), dtype=np.float64)
    frame, points, mesh = Frame(x, t, e, d, m, w), FacePoints(q, f, s), FaceMesh(h, v, k)
    local = np.full(x.shape[0], -1, dtype=np.int32)  # local index of each id
    scratch = np.empty(2 * n_local + N_EXTRA, dtype=np.int64)
    suspect = np.empty(children.shape[0], dtype=np.int64)

    # One pass over the faces; arrays of a face are used again for the next one.
    out, n_suspect = 0, 0
    for g in range(offsets.shape[0] - 1):
        # The face needs at most two points per record and its corners.
        low, high = offsets[g], offsets[g + 1]
        tri = records[low, 0]
        need = 3 + 2 * (high - low)
        if need >= n_local or 6 * need + 6 >= half:
            # The caller repeats the call with larger arrays.
            return FULL, suspect[:0].copy()
        status = _cut_face(
            frame, names, slots, records, low, high, local, mesh, points, scratch, tri
        )
        if status == FULL or out + s[TRIANGLES] > children.shape[0]:
            return FULL, suspect[:0].copy()
        if status == BROKEN:
            return BROKEN - g, suspect[:0].copy()
        out, n_suspect = _write_children(
            points, mesh, local, children, parents, out, suspect, n_suspect
        )
    return out, suspect[:n_suspect].copy()


@entry("d2* l2 l2 l2* l1* l1* l2* l1* l2* -> l1")
def adopt_points(x, t, e, d, m, w, names, places, made):
    """Ids of points that another call of `cut_faces` made, given as their definitions in order.

    They are made here unless this call has them, by this name or another one: as if it had cut the
    other faces, too, after its own. A single FULL if there is no room.
    """
    ids = np.empty(made.shape[0], dtype=np.int64)
    frame, slots = Frame(x, t, e, d, m, w), places.view(np.int32)
    for i in range(made.shape[0]):
        kind, a, b, c = made[i, 0], made[i, 1], made[i, 2], made[i, 3]
        ids[i] = point_in_tables(frame, names, slots, kind, a, b, c)
        if ids[i] == FULL:
            ids[0] = FULL
            return ids[:1].copy()
    return ids


# ---- order of the points of a face along the Hilbert curve: neighbours in the order are near in th
#
# face.
#
# Letters as in `delaunay`. Only speed depends on this order.


_DIGIT = 8  # bits that are sorted at a time
_NUMBER = 31  # lower bits of a key: index of the point
_FEW = 256  # up to this many points the curve has 8 levels, else 16
_TURNS = 64  # entries of the table of orientations
N_EXTRA = (1 << _DIGIT) + _TURNS  # scratch numbers of `rank_points` in addition to two per point


@scalar
def _write_turns(scratch, at):
    """Write a table of two levels of the curve at once, 64 entries of `scratch` from `at` on.

    The orientation of the curve in a square is one of four: bit 1 swaps the coordinates, bit 0
    reverses both. Entry 16 orientation + 4 i + j, with two bits of each coordinate, is 16 times the
    orientation below plus the two digits of the place.
    """
    for number in range(_TURNS):
        orientation, place = number >> 4, 0
        for level in range(1, -1, -1):
            one, two = (number >> 2 + level) & 1, (number >> level) & 1
            right = (two if orientation & 2 else one) ^ (orientation & 1)
            up = (one if orientation & 2 else two) ^ (orientation & 1)
            place = 4 * place + (3 * right if up == 0 else 1 + right)
            if up == 0:
                orientation ^= 2 + right
        scratch[at + number] = 16 * orientation + place


@scalar
def _place_by_turns(scratch, at, u, v, n_level):
    """Place of a point of the unit square on the curve, below 4**n_level; `n_level` is even."""
    # Cell of the point in a grid of 2**n_level by 2**n_level cells.
    last = (1 << n_level) - 1
    i, j = int(u * last), int(v * last)
    orientation, place = 0, 0
    for level in range(n_level - 2, -1, -2):
        # Two levels of the curve per lookup.
        found = scratch[at + 16 * orientation + 4 * ((i >> level) & 3) + ((j >> level) & 3)]
        place = 16 * place + (found & 15)
        orientation = found >> 4
    return place


@scalar
def _sort_digit(scratch, source, to, n, shift):
    """Copy n keys from one part of `scratch` to another, sorted by one digit (radix sort)."""
    mask = (1 << _DIGIT) - 1
    places = 2 * n  # where `scratch` holds the places of the digits
    for i in range(places, places + mask + 1):
        scratch[i] = 0

    # Count the digits, turn counts into starts, then copy.
    for i in range(source, source + n):
        scratch[places + ((scratch[i] >> shift) & mask)] += 1
    place = to
    for i in range(places, places + mask + 1):
        count = scratch[i]
        scratch[i] = place
        place += count
    # In order, so that keys with equal digits keep theirs: the next digit relies on it.
    for i in range(source, source + n):
        digit = places + ((scratch[i] >> shift) & mask)
        scratch[scratch[digit]] = scratch[i]
        scratch[digit] += 1


@scalar
def rank_points(f, low, high, scratch):
    """Write local points low..high, fewer than 2**31, into `scratch` in curve order."""
    n = high - low

    # Scale the bounding square to the unit square.
    u0, u1, v0, v1 = f[low, 0], f[low, 0], f[low, 1], f[low, 1]
    for p in range(low + 1, high):
        u0, u1 = min(u0, f[p, 0]), max(u1, f[p, 0])
        v0, v1 = min(v0, f[p, 1]), max(v1, f[p, 1])
    size = max(u1 - u0, v1 - v0)
    # Without extent all points share one place, and their index orders them.
    scale = 1.0 / size if size > 1e-290 else 0.0
    n_level = 8 if n <= _FEW else 16
    turns = 2 * n + (1 << _DIGIT)
    _write_turns(scratch, turns)

    # Key: place on the curve, then index of the point.
    for i in range(n):
        u, v = (f[low + i, 0] - u0) * scale, (f[low + i, 1] - v0) * scale
        scratch[i] = (_place_by_turns(scratch, turns, u, v, n_level) << _NUMBER) + low + i
    source, to = 0, n
    for digit in range(2 * n_level // _DIGIT):  # an even number: they end where they began
        _sort_digit(scratch, source, to, n, _NUMBER + _DIGIT * digit)
        source, to = to, source
    for i in range(n):
        scratch[i] &= (1 << _NUMBER) - 1


# ---- thin pieces ----------------------------------------
# Which pieces of faces are thinner than the displacement that rounding can cause?.
#
# A piece is thin if its height, times the sine of the flattest contact of its face, is below a
# limit. Contacts of faces that are adjacent in the map, with only edges and corners in common, do
# not count: the vertical plane between them meets both at an angle, and search methods differ in
# which of them they list. Letters as in `exact_signs`, contacts as in `triangle_contact`.


_LEAST = 1e-300  # avoids division by 0
_UPRIGHT = 2.0**-9  # faces with a smaller vertical part of the normal are nearly vertical


@scalar
def _cross(ax, ay, az, bx, by, bz):
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@scalar
def _cross_of_sides(x, i, j, k):
    """Cross product of sides i-j and i-k, its square, and the square of the longest side."""
    ax, ay, az = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
    bx, by, bz = x[k, 0] - x[i, 0], x[k, 1] - x[i, 1], x[k, 2] - x[i, 2]
    cx, cy, cz = bx - ax, by - ay, bz - az

    # The height of a triangle is its doubled area over the longest side.
    longest = max(ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz)
    longest = max(longest, cx * cx + cy * cy + cz * cz)
    nx, ny, nz = _cross(ax, ay, az, bx, by, bz)
    return nx, ny, nz, nx * nx + ny * ny + nz * nz, longest


@scalar
def _write_normals(x, t, normal):
    """Unit normals of faces."""
    for i in range(t.shape[0]):
        nx, ny, nz, square, _ = _cross_of_sides(x, t[i, 0], t[i, 1], t[i, 2])
        size = max(np.sqrt(square), _LEAST)
        normal[i, 0], normal[i, 1], normal[i, 2] = nx / size, ny / size, nz / size


@scalar
def _beyond_an_edge(x, t, m, w, i, j):
    """Whether in the map all of face j lies beyond an edge of face i, or on its line."""
    # Orientation of the face in the map.
    turn = orient2d(x, m, w, t[i, 0], t[i, 1], t[i, 2], 0, 1)
    for k in range(3):
        a, b = t[i, k], t[i, 0 if k == 2 else k + 1]

        # Corners on the line of the edge count as beyond.
        inside = False
        for c in range(3):
            p = t[j, c]
            if p != a and p != b:
                side = orient2d(x, m, w, a, b, p, 0, 1)
                inside = inside or side * turn > 0
        if not inside:
            return True
    return False


@scalar
def _counts(x, t, m, w, rows, k, normal):
    """Whether a contact can bring pieces of its faces close to each other."""
    i, j = rows[k, TRIANGLE_A], rows[k, TRIANGLE_B]
    if lies_in_plane(rows[k, HOW]):
        return False

    # Nearly vertical faces and contacts inside faces always count.
    if min(abs(normal[i, 2]), abs(normal[j, 2])) < _UPRIGHT or not lies_on_boundaries(rows[k, HOW]):
        return True
    return not (_beyond_an_edge(x, t, m, w, i, j) or _beyond_an_edge(x, t, m, w, j, i))


@entry("d2 l2 l1* l1* l2 d2 l2 l1 d -> l1")
def thin_children(x, t, m, w, rows, y, children, parent, limit):
    """Rows of the thin children of faces.

    Corners of faces are in `x`, those of children in `y`; `rows` are all contacts of these faces;
    the limit is a height [m].
    """
    normal = np.empty((t.shape[0], 3))
    _write_normals(x, t, normal)

    # The flattest contact of each face, as a squared sine.
    flattest = np.ones(t.shape[0])  # squares of sines
    for k in range(rows.shape[0]):
        if _counts(x, t, m, w, rows, k, normal):
            i, j = rows[k, TRIANGLE_A], rows[k, TRIANGLE_B]
            nx, ny, nz = _cross(
                normal[i, 0], normal[i, 1], normal[i, 2], normal[j, 0], normal[j, 1], normal[j, 2]
            )
            square = nx * nx + ny * ny + nz * nz
            flattest[i], flattest[j] = min(flattest[i], square), min(flattest[j], square)

    reach = limit**2

    # Squared height = squared cross product / squared longest side.
    thin = np.empty(children.shape[0], dtype=np.int64)
    n = 0
    for c in range(children.shape[0]):
        _, _, _, square, longest = _cross_of_sides(
            y, children[c, 0], children[c, 1], children[c, 2]
        )
        # Written so that NaN counts as thin.
        if not square * flattest[parent[c]] > reach * longest:  # heights are square / longest
            thin[n] = c
            n += 1
    return thin[:n].copy()
