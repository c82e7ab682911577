"""Which neighbouring triangles of a mesh meet in common corners and edges only?

Two convex sets are disjoint if a plane separates them. A plane computed with rounding errors is as
good as any: the corners lie on its two sides for certain where their heights exceed the error
bounds. So the result does not depend on how the mesh was made, nor on the classification in
`triangle_contact`; that is used for the pairs that stay undecided here.

three corners in common   the same triangle
two                       separated if not coplanar, or if a projection has the third corners on two
                          sides of the edge
one, none                 separated if the plane half-way between them separates them, or the plane
                          of one has the other on one side, or an edge separates a projection

Notation
    x, t     corners and triangles
    boxes    lower and upper corner of each triangle
    bounds, size, shape, offsets, filled   voxels and the triangles of each, as in `voxels`
    graph    number of the graph over the map that each triangle is a part of, -1 for none: two
             parts of one graph meet in common corners and edges only
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.exact.predicates import TINY, filtered_side, plane_terms
from geosurf.kernels.search.tree import append_pair, boxes_apart
from geosurf.kernels.search.voxels import _cell, _cell_range

# ---- large triangles ----------------------------------------
# Candidate pairs of triangles that are far larger than the others: only those along their plane.
#
# The box of a wall of a model covers the whole map, although the wall is a plane. So voxels that
# its plane misses are skipped, and so are triangles that are certainly separated from it
# (`separation`). Floats decide, with rounding bounds on the safe side: no pair that is left out
# can meet.
#
# The voxels are those of `voxels`, filled with the triangles that are not large.


LARGER = 1.0 + 1e-6  # voxels are enlarged a little, on the safe side


@scalar
def _misses(p, bounds, size, i, j, k):
    """Whether a plane certainly misses a voxel."""
    # Distance of the centre from the plane against the half-diagonal along its normal.
    h = 0.5 * size * LARGER
    s = reach = 0.0
    for axis in range(3):
        at = i if axis == 0 else (j if axis == 1 else k)
        d = bounds[axis] + (at + 0.5) * size - p[6 + axis]
        s += p[axis] * d
        # The half-diagonal along the normal, and the rounding of the plane.
        reach += abs(p[axis]) * h + ROUNDING * p[3 + axis] * (abs(d) + h)
    return abs(s) > reach


@scalar
def _steepest(p):
    """The axis along which a normal is longest."""
    axis = 0
    for k in range(1, 3):
        if abs(p[k]) > abs(p[axis]):
            axis = k
    return axis


@scalar
def _passed(p, bounds, size, axis, at, span):
    """First and last voxel along an axis that a plane may pass, given the two other indices in
    `at`; a few more, and all of `span` where the plane has no direction.
    """
    first, last = span[axis], span[3 + axis]
    if not abs(p[axis]) > 0.0:
        return first, last
    h = 0.5 * size * LARGER
    s, reach = 0.0, 0.0
    for k in range(3):
        # the farthest voxel along the axis bounds the rounding of all of them
        d = bounds[k] + (at[k] + 0.5) * size - p[6 + k]
        far = abs(d)
        if k == axis:
            far = abs(bounds[k] - p[6 + k]) + (last + 1) * size
        else:
            s += p[k] * d
        reach += abs(p[k]) * h + 4.0 * ROUNDING * p[3 + k] * (far + h)

    # |s + normal * d| <= reach, as an interval of d; then of voxels, one more at each end
    middle = (-s / p[axis] + p[6 + axis] - bounds[axis]) / size - 0.5
    half = reach / (abs(p[axis]) * size) + 1.0
    if not (abs(middle) < 1e9 and half < 1e9):
        return first, last
    return max(first, int(np.floor(middle - half))), min(last, int(np.ceil(middle + half)))


@scalar
def _is_beside(x, t, f, p, bounds, size, axis, at):
    """Whether a triangle, seen along an axis, certainly misses a column of voxels.

    Wide triangles are often slivers across their box: a side of them parts them from most of it.
    """
    u, v = (axis + 1) % 3, (axis + 2) % 3
    h = 0.5 * size * LARGER
    pu, pv = bounds[u] + (at[u] + 0.5) * size, bounds[v] + (at[v] + 0.5) * size
    turn = 1.0 if p[axis] > 0.0 else -1.0
    for i in range(3):
        one, two = t[f, i], t[f, (i + 1) % 3]
        du, dv = x[two, u] - x[one, u], x[two, v] - x[one, v]
        eu, ev = pu - x[one, u], pv - x[one, v]
        reach = (abs(du) + abs(dv)) * h
        reach += ROUNDING * (abs(du) * (abs(ev) + h) + abs(dv) * (abs(eu) + h))
        if turn * (du * ev - dv * eu) < -reach:
            return True
    return False


@scalar
def _append(pairs, n, a, b):
    """Append a pair, lower row first; the array, twice as long where it was full, and the count."""
    if n == pairs.shape[0]:
        pairs = np.concatenate((pairs, np.empty_like(pairs)))
    pairs[n, 0], pairs[n, 1] = min(a, b), max(a, b)
    return pairs, n + 1


@entry("d2 l2 d2 l1 d1 d l1 l1 l1 -> l2")
def large_triangle_pairs(x, t, boxes, large, bounds, size, shape, offsets, filled):
    """Pairs (n, 2) of large triangles with others that may meet; lower row first, each once."""
    pairs = np.empty((64, 2), dtype=np.int64)
    n = 0
    # The last large triangle that each triangle was compared with.
    seen = np.full(t.shape[0], -1, dtype=np.int64)
    span, cell = np.empty(6, dtype=np.int64), np.zeros(3, dtype=np.int64)
    p, common = np.empty(9), np.empty((2, 9), dtype=np.int64)
    for r in range(large.shape[0]):
        a = large[r]
        plane_of(x, t, a, p)

        # Large triangles among each other: all pairs.
        for other in range(r):
            if not (
                boxes_apart(boxes, a, boxes, large[other])
                or is_beside_plane(x, t, p, a, large[other])
                or separated_triangles(x, t, a, large[other], common)
            ):
                pairs, n = _append(pairs, n, a, large[other])

        # The others: only in voxels that the plane passes.
        # The box of a large triangle covers many voxels, its plane passes few of them.
        _cell_range(boxes, a, bounds, size, shape, span)
        axis = _steepest(p)
        u, v = (axis + 1) % 3, (axis + 2) % 3
        sharp = abs(p[axis]) > ROUNDING * p[3 + axis]  # else its sides may turn either way
        for one in range(span[u], span[3 + u] + 1):
            for two in range(span[v], span[3 + v] + 1):
                cell[u], cell[v] = one, two
                if sharp and _is_beside(x, t, a, p, bounds, size, axis, cell):
                    continue
                low, high = _passed(p, bounds, size, axis, cell, span)
                for three in range(low, high + 1):
                    cell[axis] = three
                    i, j, k = cell[0], cell[1], cell[2]
                    voxel = (i * shape[1] + j) * shape[2] + k
                    first, last = offsets[voxel], offsets[voxel + 1]
                    if first == last or _misses(p, bounds, size, i, j, k):
                        continue
                    for at in range(first, last):
                        b = filled[at]

                        # A triangle fills several voxels; it is tested once.
                        if seen[b] == a:
                            continue
                        seen[b] = a
                        if not (
                            boxes_apart(boxes, a, boxes, b)
                            or is_beside_plane(x, t, p, a, b)
                            or separated_triangles(x, t, a, b, common)
                        ):
                            pairs, n = _append(pairs, n, a, b)
    return pairs[:n].copy()


# Rounding errors relative to the sum of magnitudes: below 8 units (2**-53) for three products of
# differences, below 16 for six products of three factors.
PLANE_BOUND, VOLUME_BOUND = 1e-15, 2e-15
ROUNDING = 1e-14  # relative, of sums of three products of differences: 45 units in the last place


@scalar
def _common(t, a, b, at):
    """Number of common corners; their indices in a and b come first in `at`, then the others."""
    # Nine comparisons of numbers; no coordinates.
    n = 0
    for i in range(3):
        for j in range(3):
            if t[a, i] == t[b, j]:
                at[0, n], at[1, n] = i, j
                n += 1

    # Fill the remaining places, so that every corner can be addressed.
    if n == 1:
        at[0, 1], at[0, 2] = (at[0, 0] + 1) % 3, (at[0, 0] + 2) % 3
        at[1, 1], at[1, 2] = (at[1, 0] + 1) % 3, (at[1, 0] + 2) % 3
    elif n == 2:
        at[0, 2] = 3 - at[0, 0] - at[0, 1]
        at[1, 2] = 3 - at[1, 0] - at[1, 1]
    return n


@scalar
def _turn_sign(x, p, q, r, u, v):
    """Sign of the turn p, q, r on axes u and v; 0 if undecided."""
    one = (x[q, u] - x[p, u]) * (x[r, v] - x[p, v])
    two = (x[q, v] - x[p, v]) * (x[r, u] - x[p, u])
    size = abs(one) + abs(two)
    if size > TINY and abs(one - two) > PLANE_BOUND * size:
        return 1 if one > two else -1
    return 0


@scalar
def _apart_at_edge(x, p, q, a, b):
    """Whether triangles p, q, a and p, q, b certainly meet in their common edge only."""
    ux, uy, uz = x[q, 0] - x[p, 0], x[q, 1] - x[p, 1], x[q, 2] - x[p, 2]
    ax, ay, az = x[a, 0] - x[p, 0], x[a, 1] - x[p, 1], x[a, 2] - x[p, 2]
    bx, by, bz = x[b, 0] - x[p, 0], x[b, 1] - x[p, 1], x[b, 2] - x[p, 2]

    # Four corners in space: not coplanar means separated.
    volume = bx * (uy * az - uz * ay) + by * (uz * ax - ux * az) + bz * (ux * ay - uy * ax)
    size = abs(bx) * (abs(uy * az) + abs(uz * ay)) + abs(by) * (abs(uz * ax) + abs(ux * az))
    size += abs(bz) * (abs(ux * ay) + abs(uy * ax))
    if size > TINY and abs(volume) > VOLUME_BOUND * size:
        return True
    for k in range(3):  # the map first
        u, v = k, (k + 1) % 3
        if _turn_sign(x, p, q, a, u, v) * _turn_sign(x, p, q, b, u, v) < 0:
            return True
    return False


@scalar
def _span(x, t, tri, o, nx, ny, nz):
    """Bounds of the heights of the corners of a triangle over the plane through o."""
    low, high = np.inf, -np.inf
    for i in range(3):
        v = t[tri, i]
        # The corner in the plane has height 0 exactly.
        if v == o:
            continue
        hx, hy, hz = nx * (x[v, 0] - x[o, 0]), ny * (x[v, 1] - x[o, 1]), nz * (x[v, 2] - x[o, 2])
        height = hx + hy + hz

        # Widen by the rounding error on both sides.
        slack = PLANE_BOUND * (abs(hx) + abs(hy) + abs(hz)) + TINY
        low, high = min(low, height - slack), max(high, height + slack)
    return low, high


@scalar
def _bisector(x, p, q, r):
    """Unit vector from p half-way between the directions to q and r."""
    ax, ay, az = x[q, 0] - x[p, 0], x[q, 1] - x[p, 1], x[q, 2] - x[p, 2]
    bx, by, bz = x[r, 0] - x[p, 0], x[r, 1] - x[p, 1], x[r, 2] - x[p, 2]
    a = 1.0 / max(np.sqrt(ax * ax + ay * ay + az * az), TINY)
    b = 1.0 / max(np.sqrt(bx * bx + by * by + bz * bz), TINY)
    cx, cy, cz = ax * a + bx * b, ay * a + by * b, az * a + bz * b
    c = 1.0 / max(np.sqrt(cx * cx + cy * cy + cz * cz), TINY)
    return cx * c, cy * c, cz * c


@scalar
def _off_plane(x, t, a, b, shared):
    """Whether triangle b, a shared corner excluded, is certainly on one side of the plane of a."""
    o = t[a, 0]
    n0, n1, n2, s0, s1, s2, span = plane_terms(x, o, t[a, 1], t[a, 2])

    # All corners have to lie on the same certified side.
    before = 0
    for i in range(3):
        v = t[b, i]
        if v == shared:
            continue
        cx, cy, cz = x[v, 0] - x[o, 0], x[v, 1] - x[o, 1], x[v, 2] - x[o, 2]
        side = filtered_side(cx, cy, cz, n0, n1, n2, s0, s1, s2, span, 0.0)
        # Undecided, or on the other side than a corner before.
        if side == 0 or side == -before:
            return False
        before = side
    return True


@scalar
def _off_edge(x, t, a, b, shared, u, v):
    """Whether an edge of a, on axes u and v, separates it from b, a shared corner excluded."""
    for i in range(3):
        p, q, r = t[a, i], t[a, (i + 1) % 3], t[a, (i + 2) % 3]
        # The shared corner is a corner of b too, on the inner side: this edge cannot separate b.
        if r == shared:
            continue

        # r is the corner of a opposite to the edge; b has to lie on the other side.
        side = _turn_sign(x, p, q, r, u, v)
        parted = side != 0
        for j in range(3):
            c = t[b, j]
            if parted and c != shared:
                parted = _turn_sign(x, p, q, c, u, v) == -side
        if parted:
            return True
    return False


@scalar
def _separated_by_face(x, t, a, b, shared):
    """Whether the plane or an edge of one of two triangles separates them."""
    if _off_plane(x, t, a, b, shared) or _off_plane(x, t, b, a, shared):
        return True
    for k in range(3):
        u, v = k, (k + 1) % 3
        if _off_edge(x, t, a, b, shared, u, v) or _off_edge(x, t, b, a, shared, u, v):
            return True
    return False


@scalar
def _apart_at_corner(x, t, a, b, at):
    """Whether a plane half-way separates triangles except for their common corner."""
    o = t[a, at[0, 0]]
    ax, ay, az = _bisector(x, o, t[a, at[0, 1]], t[a, at[0, 2]])
    bx, by, bz = _bisector(x, o, t[b, at[1, 1]], t[b, at[1, 2]])
    # Half-way between both bisectors: the plane across their difference.
    nx, ny, nz = ax - bx, ay - by, az - bz
    return _span(x, t, a, o, nx, ny, nz)[0] > 0.0 > _span(x, t, b, o, nx, ny, nz)[1]


@scalar
def _apart_midway(x, t, a, b):
    """Whether a plane half-way separates triangles without a common corner."""
    # Three times the vector between the middles of both triangles.
    nx = x[t[a, 0], 0] + x[t[a, 1], 0] + x[t[a, 2], 0]
    ny = x[t[a, 0], 1] + x[t[a, 1], 1] + x[t[a, 2], 1]
    nz = x[t[a, 0], 2] + x[t[a, 1], 2] + x[t[a, 2], 2]
    nx -= x[t[b, 0], 0] + x[t[b, 1], 0] + x[t[b, 2], 0]
    ny -= x[t[b, 0], 1] + x[t[b, 1], 1] + x[t[b, 2], 1]
    nz -= x[t[b, 0], 2] + x[t[b, 1], 2] + x[t[b, 2], 2]
    o = t[a, 0]  # its own height is 0
    return min(0.0, _span(x, t, a, o, nx, ny, nz)[0]) > _span(x, t, b, o, nx, ny, nz)[1]


@scalar
def separated_triangles(x, t, a, b, at):
    """Whether two triangles certainly meet in common corners and edges only."""
    n = _common(t, a, b, at)
    # The same corners: nothing of either triangle lies outside of what they have in common.
    if n == 3:
        return True
    if n == 2:
        p, q = t[a, at[0, 0]], t[a, at[0, 1]]
        return _apart_at_edge(x, p, q, t[a, at[0, 2]], t[b, at[1, 2]])
    if n == 1:
        return _apart_at_corner(x, t, a, b, at) or _separated_by_face(x, t, a, b, t[a, at[0, 0]])
    return _apart_midway(x, t, a, b) or _separated_by_face(x, t, a, b, -1)


@scalar
def plane_of(x, t, f, p):
    """Write normal, bounds of its terms, and a corner of a triangle to p (9,)."""
    a, b, c = t[f, 0], t[f, 1], t[f, 2]
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        one = (x[b, i] - x[a, i]) * (x[c, j] - x[a, j])
        two = (x[b, j] - x[a, j]) * (x[c, i] - x[a, i])
        p[k] = one - two
        p[3 + k] = abs(one) + abs(two)
        p[6 + k] = x[a, k]


@scalar
def is_beside_plane(x, t, p, a, b):
    """Whether triangle b is certainly on one side of the plane p of a, shared corners excluded.

    Then both meet in these corners only, and in the edge between two of them.
    """
    before = 0
    for i in range(3):
        v = t[b, i]
        if v == t[a, 0] or v == t[a, 1] or v == t[a, 2]:
            continue
        height = size = 0.0
        for k in range(3):
            d = x[v, k] - p[6 + k]
            height += p[k] * d
            size += p[3 + k] * abs(d)
        if not (size > TINY and abs(height) > ROUNDING * size):
            return False
        side = 1 if height > 0.0 else -1
        if side == -before:
            return False
        before = side
    return before != 0


@scalar
def _load_voxel(boxes, bounds, size, shape, graph, filled, low, high, at, near, marks):
    """What is asked of each pair of triangles of a voxel, side by side: boxes, graphs, and for each
    axis whether the box begins in this voxel (bits 1, 2, 4): each pair is tested in one voxel only.
    """
    for s in range(low, high):
        of = filled[s]
        for k in range(6):
            near[k, s - low] = boxes[of, k]
        bits = 0
        for axis in range(3):
            begins = _cell(boxes[of, axis], bounds[axis], size, shape[axis]) == at[axis]
            bits |= int(begins) << axis
        marks[0, s - low], marks[1, s - low] = bits, graph[of]


@scalar
def _meeting(near, marks, i, n, hits):
    """Places behind i whose boxes meet that of i here; how many.

    The common box begins here if one of the two does, on each axis; and two parts of one
    single-valued surface are separated in the map. Without branches: few of them are predicted.
    """
    x0, y0, z0, x1, y1, z1 = near[0, i], near[1, i], near[2, i], near[3, i], near[4, i], near[5, i]
    bits, graph = marks[0, i], marks[1, i]
    count = 0
    for j in range(i + 1, n):
        hits[count] = j
        meets = (near[0, j] <= x1) & (x0 <= near[3, j]) & (near[1, j] <= y1) & (y0 <= near[4, j])
        meets = meets & (near[2, j] <= z1) & (z0 <= near[5, j])
        meets = meets & ((bits | marks[0, j]) == 7) & ((graph < 0) | (marks[1, j] != graph))
        count += int(meets)
    return count


@scalar
def _is_one_graph(graph, filled, low, high):
    """Whether all triangles of a voxel are parts of one graph."""
    first = graph[filled[low]]
    if first < 0:
        return False
    for s in range(low + 1, high):
        if graph[filled[s]] != first:
            return False
    return True


@entry("d2 l2 l l1 d2 d1 d l1 l1 l1 l l l2* -> l")
def undecided_pairs(
    x, t, n_first, graph, boxes, bounds, size, shape, offsets, filled, first, last, pairs
):
    """Pairs of triangles that are not certainly separated, lower row first; their number.

    Of voxels from `first` up to `last`. They are written up to capacity. Triangles from row
    `n_first` on are not compared with each other.
    """
    common, at = np.empty((2, 9), dtype=np.int64), np.empty(3, dtype=np.int64)
    most = 0
    for voxel in range(first, last):
        most = max(most, offsets[voxel + 1] - offsets[voxel])
    near, marks = np.empty((6, most)), np.empty((2, most), dtype=np.int64)
    hits = np.empty(most + 1, dtype=np.int64)
    p, of = np.empty(9), -1  # the plane of a triangle, once for all that are near it
    n = 0
    for voxel in range(first, last):
        low, high = offsets[voxel], offsets[voxel + 1]
        # Most voxels next to no fault hold one surface only; rows are increasing in a voxel.
        if high - low < 2 or filled[low] >= n_first or _is_one_graph(graph, filled, low, high):
            continue
        # A pair belongs to the voxel of the lower corner of the common box.
        at[2] = voxel % shape[2]
        at[1] = voxel // shape[2] % shape[1]
        at[0] = voxel // (shape[1] * shape[2])
        _load_voxel(boxes, bounds, size, shape, graph, filled, low, high, at, near, marks)
        for s in range(low, high):
            a = filled[s]
            if a >= n_first:
                break
            for hit in range(_meeting(near, marks, s - low, high - low, hits)):
                b = filled[low + hits[hit]]
                if of != a:
                    plane_of(x, t, a, p)
                    of = a
                if is_beside_plane(x, t, p, a, b) or separated_triangles(x, t, a, b, common):
                    continue
                n = append_pair(pairs, n, a, b)
    return n


# ---- marked voxels ----------------------------------------
# Which triangles may meet some few others: those in the voxels that the few pass.
#
# A triangle that meets another one has a point in common with it, and this point is in one voxel.
# So the voxels of the few are marked, and all triangles without a marked voxel are apart from
# them. The search costs one pass over the others, and no memory for each of them.
#
# Notation
#     x, t     corners and triangles
#     boxes    lower and upper corner of each of the few
#     marks    whether the few pass a voxel, (n_voxel,), as `voxels` numbers them


_WIDE = 64  # voxels in its box, from which a triangle is followed along its plane, or not tested


@scalar
def _mark_along_plane(x, t, f, bounds, size, shape, span, marks):
    """Mark the voxels of a box that the plane of a triangle passes, and a few more."""
    p, at = np.empty(9), np.zeros(3, dtype=np.int64)
    plane_of(x, t, f, p)
    axis = _steepest(p)
    u, v = (axis + 1) % 3, (axis + 2) % 3
    for one in range(span[u], span[3 + u] + 1):
        for two in range(span[v], span[3 + v] + 1):
            at[u], at[v] = one, two
            low, high = _passed(p, bounds, size, axis, at, span)
            for three in range(low, high + 1):
                at[axis] = three
                marks[(at[0] * shape[1] + at[1]) * shape[2] + at[2]] = True


@scalar
def _n_voxel(span):
    """Number of voxels from the first to the last along all axes."""
    return (span[3] - span[0] + 1) * (span[4] - span[1] + 1) * (span[5] - span[2] + 1)


@scalar
def _has_mark(marks, shape, span):
    """Whether a voxel from the first to the last along all axes is marked."""
    for i in range(span[0], span[3] + 1):
        for j in range(span[1], span[4] + 1):
            row = (i * shape[1] + j) * shape[2]
            for k in range(span[2], span[5] + 1):
                if marks[row + k]:
                    return True
    return False


@entry("d2 l2 d2 d1 d l1 -> b1")
def mark_voxels(x, t, boxes, bounds, size, shape):
    """Whether triangles pass each voxel; some more voxels of wide ones."""
    marks = np.zeros(shape[0] * shape[1] * shape[2], dtype=np.bool_)
    span = np.empty(6, dtype=np.int64)
    for f in range(t.shape[0]):
        _cell_range(boxes, f, bounds, size, shape, span)
        if _n_voxel(span) > _WIDE:
            _mark_along_plane(x, t, f, bounds, size, shape, span, marks)
            continue
        for i in range(span[0], span[3] + 1):
            for j in range(span[1], span[4] + 1):
                for k in range(span[2], span[5] + 1):
                    marks[(i * shape[1] + j) * shape[2] + k] = True
    return marks


@entry("d2 l2 d1 d l1 b1 -> b1")
def have_marks(x, t, bounds, size, shape, marks):
    """Whether the box of each triangle reaches a marked voxel; wide ones inside the bounds do."""
    out = np.zeros(t.shape[0], dtype=np.bool_)
    box, span = np.empty((1, 6)), np.empty(6, dtype=np.int64)
    for f in range(t.shape[0]):
        meets = True
        for axis in range(3):
            p, q, r = x[t[f, 0], axis], x[t[f, 1], axis], x[t[f, 2], axis]
            box[0, axis], box[0, 3 + axis] = min(p, min(q, r)), max(p, max(q, r))
            meets &= box[0, axis] <= bounds[3 + axis] and bounds[axis] <= box[0, 3 + axis]
        if meets:
            _cell_range(box, 0, bounds, size, shape, span)
            out[f] = _n_voxel(span) > _WIDE or _has_mark(marks, shape, span)
    return out
