"""Shells as meshes: their order, their open edges, their sums, and triangles with equal corners.

A certificate runs these over all triangles of a model, twice for those between two units. Each is
one pass without a global sort: triangles are put into buckets by their lowest corner.

Notation as in `mesh`: x coordinates, t triangles.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.run_checks import EDGES, OPEN, VERTICES, two_sum
from geosurf.kernels.meshes.mesh import half_edges_by_vertex, half_of, upper_of
from geosurf.kernels.meshes.volumes import _sum

# ---- parent checks ----------------------------------------
# Do triangles lie on the input triangles that they are parts of?.
#
# Notation
#     x        vertices, float64 (n_vertex, 3)
#     t        triangles, int64 (n, 3)
#     parents  corners of the input triangle of each, one after the other, float64 (n, 9)


_LEAST = 2.0**-106  # in place of widths and lengths of 0


@scalar
def _larger(one, two):
    """The larger of two numbers; not a number if one of them is not."""
    return two if two > one or two != two else one


@scalar
def _unit_normal(c, unit):
    """Normal of a triangle with corners c (3, 3), of length 1; and its length before."""
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        one = (c[1, i] - c[0, i]) * (c[2, j] - c[0, j])
        unit[k] = one - (c[1, j] - c[0, j]) * (c[2, i] - c[0, i])
    width = np.sqrt(unit[0] * unit[0] + unit[1] * unit[1] + unit[2] * unit[2])
    width = _larger(_LEAST, width)
    for k in range(3):
        unit[k] /= width
    return width


@scalar
def _beyond(c, unit, point):
    """How far a point is off a triangle: from its plane, or beyond one of its sides."""
    px, py, pz = point[0] - c[0, 0], point[1] - c[0, 1], point[2] - c[0, 2]
    off = abs(px * unit[0] + py * unit[1] + pz * unit[2])
    for i in range(3):
        j = (i + 1) % 3
        ex, ey, ez = c[j, 0] - c[i, 0], c[j, 1] - c[i, 1], c[j, 2] - c[i, 2]
        nx = unit[1] * ez - unit[2] * ey
        ny = unit[2] * ex - unit[0] * ez
        nz = unit[0] * ey - unit[1] * ex
        length = _larger(_LEAST, np.sqrt(nx * nx + ny * ny + nz * nz))
        px, py, pz = point[0] - c[i, 0], point[1] - c[i, 1], point[2] - c[i, 2]
        off = _larger(off, -(px * nx + py * ny + pz * nz) / length)
    return off


@entry("d2 l2 d2 -> d1 d1")
def distances_from_parents(x, t, parents):
    """Largest distance of the corners of each triangle from its input triangle [m], and the size of
    that over its height: slivers have planes with large rounding errors.
    """
    far, slack = np.empty(t.shape[0]), np.empty(t.shape[0])
    c, unit, point = np.empty((3, 3)), np.empty(3), np.empty(3)
    for i in range(t.shape[0]):
        # by the size of each: products of tiny sides underflow
        size = 0.0
        for k in range(3):
            one, two, three = parents[i, k], parents[i, 3 + k], parents[i, 6 + k]
            size = _larger(size, max(one, max(two, three)) - min(one, min(two, three)))
        for corner in range(3):
            for k in range(3):
                c[corner, k] = parents[i, 3 * corner + k] / size
        width = _unit_normal(c, unit)
        off = 0.0
        for corner in range(3):
            for k in range(3):
                point[k] = x[t[i, corner], k] / size
            off = _larger(off, _beyond(c, unit, point))
        far[i], slack[i] = off * size, size / width
    return far, slack


@entry("d2 l2 d2 -> b1")
def copies_of_parents(x, t, parents):
    """Whether each triangle has the corners of its input triangle, in this order, to the bit."""
    found = np.zeros(t.shape[0], dtype=np.bool_)
    for i in range(t.shape[0]):
        for turn in range(3):
            same = True
            for corner in range(3):
                of = 3 * ((corner + turn) % 3)
                for k in range(3):
                    same = same and x[t[i, corner], k] == parents[i, of + k]
            found[i] = found[i] or same
    return found


_LONG = 32  # half-edges of one lower vertex that are matched by searching


@scalar
def _hash(a, b, c):
    """Hash of three vertices; every product stays below 2**63."""
    h = (a & 0x3FFFFFFF) * 0x1E3779B1
    h = (h ^ (h >> 31)) + (b & 0x3FFFFFFF) * 0x165667B1
    h = (h ^ (h >> 29)) + (c & 0x3FFFFFFF) * 0x0B55A4F5
    h = h & 0x7FFFFFFFFFFFFFFF
    return h ^ (h >> 32)


@scalar
def _sorted_corners(t, i):
    """The corners of a triangle, lowest first."""
    a, b, c = t[i, 0], t[i, 1], t[i, 2]
    low, high = min(a, min(b, c)), max(a, max(b, c))
    return low, a + b + c - low - high, high


@entry("l2 l -> l1 b1 l l")
def number_triangles(t, n):
    """Of each of the first n triangles: number of the first one with the same three corners,
    renumbered from 0, and whether its corners go round in rising order. How many numbers these
    have, and how many all triangles would have.
    """
    n_all = t.shape[0]
    size = 16
    while size < 2 * n_all:
        size *= 2
    slots = np.full(size, -1, dtype=np.int32)  # 32 bits: half the memory, which is new
    first = np.empty(n_all, dtype=np.int32)  # triangle that each number is of
    number = np.empty(n, dtype=np.int64)
    rising = np.empty(n, dtype=np.bool_)
    count = n_number = 0
    for i in range(n_all):
        low, mid, high = _sorted_corners(t, i)

        # Open addressing; equal sets of corners share a slot.
        slot = _hash(low, mid, high) & (size - 1)
        while slots[slot] >= 0:
            one, two, three = _sorted_corners(t, first[slots[slot]])
            if one == low and two == mid and three == high:
                break
            slot = (slot + 1) & (size - 1)
        if slots[slot] < 0:
            slots[slot] = count
            first[count] = i
            count += 1
        if i < n:
            # Two of three steps rise where an even permutation sorts the corners.
            a, b, c = t[i, 0], t[i, 1], t[i, 2]
            rising[i] = int(a < b) + int(b < c) + int(c < a) == 2
            number[i] = slots[slot]
            n_number = count
    return number, rising, n_number, count


@entry("l2 l -> l l l")
def count_open_edges(t, n_vertex):
    """Open edges (more triangles on one side than on the other), edges, and vertices in use.

    An edge that is run through twice more often one way than the other counts twice.
    """
    # Half-edges of an edge are in the bucket of its lower vertex.
    start, bucket = half_edges_by_vertex(t, n_vertex)
    used = np.zeros(n_vertex, dtype=np.bool_)
    for i in range(t.shape[0]):
        for c in range(3):
            used[t[i, c]] = True

    # 1 where a half-edge runs from its lower vertex, else -1.
    way = np.empty(bucket.shape[0], dtype=np.int64)
    for p in range(bucket.shape[0]):
        half = half_of(bucket[p])
        way[p] = 1 if t[half // 3, half % 3] < upper_of(bucket[p]) else -1

    # Each half-edge adds to the first one of its edge; long buckets find that by a table.
    first_of = np.empty(0, dtype=np.int64)
    n_open, n_edge, n_used = 0, 0, 0
    for v in range(n_vertex):
        low, high = start[v], start[v + 1]
        n_used += int(used[v])
        long = high - low > _LONG
        if long and first_of.shape[0] == 0:
            first_of = np.full(n_vertex, -1, dtype=np.int64)
        for p in range(low, high):
            upper = upper_of(bucket[p])
            if long:
                found = first_of[upper]  # below `low`: of an earlier bucket
                if found < low:
                    first_of[upper] = p
                    found = p
            else:
                found = low
                while upper_of(bucket[found]) != upper:
                    found += 1
            # Opposite directions cancel: an edge between two triangles ends at 0.
            if found < p:
                way[found] += way[p]
                way[p] = 0
            else:
                n_edge += 1

        # The first half-edge of each edge has its balance now, the others have none.
        for p in range(low, high):
            n_open += abs(way[p])
    return n_open, n_edge, n_used


@entry("d2 l2 -> d d d d")
def sums_of_triangles(x, t):
    """Volume inside a closed mesh, its area, and for bounds of rounding errors: the sum of products
    of two sides of each triangle, and the sum of all sides, in the norm of absolute values.

    The volume is that of pyramids from the middle of the mesh (the divergence theorem).
    """
    # The middle of the box as origin keeps radii short, and rounding errors with them.
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for i in range(t.shape[0]):
        for c in range(3):
            for k in range(3):
                low[k] = min(low[k], x[t[i, c], k])
                high[k] = max(high[k], x[t[i, c], k])
    mx, my, mz = 0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2])
    volume = area = volume_rest = area_rest = products = sides = 0.0
    for i in range(t.shape[0]):
        a, b, c = t[i, 0], t[i, 1], t[i, 2]

        # By sides, which are short: products of whole radii would lose digits.
        ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
        vx, vy, vz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        term = (x[a, 0] - mx) * nx + (x[a, 1] - my) * ny + (x[a, 2] - mz) * nz
        volume, volume_rest = _sum(volume, volume_rest, term)
        area, area_rest = _sum(area, area_rest, np.sqrt(nx * nx + ny * ny + nz * nz))
        u, v = abs(ux) + abs(uy) + abs(uz), abs(vx) + abs(vy) + abs(vz)
        # Sums for the error bound that the certificate reports.
        products += u * v
        sides += u + v + abs(ux - vx) + abs(uy - vy) + abs(uz - vz)
    return (volume + volume_rest) / 6.0, 0.5 * (area + area_rest), products, sides


# ---- shell edges ----------------------------------------
# Edges and vertices of the shells of all units, counted in one pass over listed triangles.
#
# Each triangle bounds the unit behind it as it is, and the unit in front of it turned over. A shell
# is closed if it runs through each edge as often one way as the other.
#
# Notation
#     t        triangles, rows of vertices
#     sides    units in front of and behind each triangle (n, 2); -1 outside the model
#     row      the element (triangle or run) that each is a part of
#     counts   int64 (n_unit, 3): vertices, edges and open edges of the shell of each unit


@scalar
def _add_edge(sides, chain, n, ways, touched, counts):
    """Count the edge of some half-edges, given as (triangle, 1 or -1), for the units around it."""
    n_touched = 0
    for k in range(n):
        front, behind = sides[chain[k, 0], 0], sides[chain[k, 0], 1]
        if front == behind:
            continue
        for s in range(2):
            unit = behind if s == 1 else front
            if unit < 0:
                continue

            # `ways` is 0 between calls; an offset of 2 n marks units that were met.
            if ways[unit] == 0:
                ways[unit] = 4 * n
                touched[n_touched] = unit
                n_touched += 1
            ways[unit] += chain[k, 1] if s == 1 else -chain[k, 1]
    for k in range(n_touched):
        unit = touched[k]
        counts[unit, EDGES] += 1
        counts[unit, OPEN] += abs(ways[unit] - 4 * n)
        ways[unit] = 0


@scalar
def _has_run_between(row, first_run, chain, n):
    """Whether two triangles of one run and a third triangle share an edge."""
    for k in range(n):
        for m in range(k):
            of = row[chain[k, 0]]
            if of >= first_run and of == row[chain[m, 0]]:
                return True
    return False


@entry("l2 l1 l l2 l l l2* -> l l")
def count_shared(t, row, first_run, sides, n_vertex, n_shared, counts):
    """Add vertices below `n_shared`, and edges with one of these, to the counts of units.

    Returns the number of vertices of shells, and the number of edges between two triangles of one
    run (elements from `first_run` on) that other triangles have, too.
    """
    start, bucket = half_edges_by_vertex(t, n_vertex)
    first_of = np.full(n_vertex, -1, dtype=np.int64)
    most = 0
    for v in range(min(n_shared, n_vertex)):
        most = max(most, start[v + 1] - start[v])
    after = np.empty(most, dtype=np.int64)  # by place in the bucket
    chain = np.empty((16, 2), dtype=np.int64)
    touched = np.empty(32, dtype=np.int64)
    ways = np.zeros(counts.shape[0], dtype=np.int64)
    n_conflict = 0
    for v in range(min(n_shared, n_vertex)):
        low, high = start[v], start[v + 1]

        # Half-edges of one edge form a chain, found by their upper vertex.
        for p in range(high - 1, low - 1, -1):
            u = upper_of(bucket[p])
            after[p - low] = first_of[u] if low <= first_of[u] < high else -1
            first_of[u] = p
        for p in range(low, high):
            if first_of[upper_of(bucket[p])] != p:
                continue
            n = 0
            at = p
            while at >= 0:
                if n == chain.shape[0]:
                    larger = np.empty((2 * n, 2), dtype=np.int64)
                    larger[:n] = chain
                    chain = larger
                    touched = np.empty(4 * n, dtype=np.int64)
                half = half_of(bucket[at])
                chain[n, 0] = half // 3
                chain[n, 1] = 1 if t[half // 3, half % 3] == v else -1
                n += 1
                at = after[at - low]
            _add_edge(sides, chain, n, ways, touched, counts)
            if n > 2 and _has_run_between(row, first_run, chain, n):
                n_conflict += 1
    return _count_vertices(t, sides, n_vertex, n_shared, counts), n_conflict


@scalar
def _count_vertices(t, sides, n_vertex, n_shared, counts):
    """Count vertices for the units that have them; the number of vertices of shells."""
    start = np.zeros(n_vertex + 2, dtype=np.int64)  # 32 bits for what is as long as triangles
    for i in range(t.shape[0]):
        for c in range(3):
            start[t[i, c] + 2] += 1
    for v in range(2, n_vertex + 2):
        start[v] += start[v - 1]
    at = np.empty(3 * t.shape[0], dtype=np.int32)
    for i in range(t.shape[0]):
        for c in range(3):
            at[start[t[i, c] + 1]] = i
            start[t[i, c] + 1] += 1

    # The last vertex that each unit was counted for.
    stamp = np.full(counts.shape[0], -1, dtype=np.int64)
    n_used = 0
    for v in range(min(n_shared, n_vertex)):
        used = False
        for p in range(start[v], start[v + 1]):
            front, behind = sides[at[p], 0], sides[at[p], 1]
            if front == behind:
                continue
            for s in range(2):
                unit = behind if s == 1 else front
                if unit >= 0 and stamp[unit] != v:
                    stamp[unit] = v
                    counts[unit, VERTICES] += 1
                    used = True
        n_used += int(used)
    return n_used


# ---- triangle facts ----------------------------------------
# What a certificate adds up over triangles, in passes without copies of their corners.
#
# What a pass finds of a triangle is added at once, where it belongs: a table of all of it would be
# the largest array of a certificate.
#
# Notation
#     x    vertices, float64 (n_vertex, 3)
#     t    triangles, int64 (n, 3)


@scalar
def _steps(x, i, j):
    """Sum of the steps along the axes from one vertex to another."""
    return abs(x[j, 0] - x[i, 0]) + abs(x[j, 1] - x[i, 1]) + abs(x[j, 2] - x[i, 2])


@scalar
def _normal(x, a, b, c):
    """Normal of a triangle, as long as twice its area."""
    ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    vx, vy, vz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


@entry("d2 l2 l1 d1 d1 d1* b1* -> .")
def rises_of_triangles(x, t, surface, lower, upper, rise, within):
    """Write whether each triangle lies in a box. If so, add twice its area in the map, below 0
    where it looks down, to that of its surface.
    """
    for i in range(t.shape[0]):
        a, b, c = t[i, 0], t[i, 1], t[i, 2]
        inside = True
        for k in range(3):
            low = min(min(x[a, k], x[b, k]), x[c, k])
            high = max(max(x[a, k], x[b, k]), x[c, k])
            inside = inside and low >= lower[k] and high <= upper[k]
        within[i] = inside
        if inside:
            rise[surface[i]] += _normal(x, a, b, c)[2]


@entry("d2 l2 -> d1 d1")
def sizes_of_triangles(x, t):
    """Twice the area of each triangle, and all its sides (in the norm of absolute values)."""
    area, around = np.empty(t.shape[0]), np.empty(t.shape[0])
    for i in range(t.shape[0]):
        a, b, c = t[i, 0], t[i, 1], t[i, 2]
        nx, ny, nz = _normal(x, a, b, c)
        area[i] = np.sqrt(nx * nx + ny * ny + nz * nz)
        ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
        vx, vy, vz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
        three = abs(ux - vx) + abs(uy - vy) + abs(uz - vz)
        around[i] = _steps(x, a, b) + _steps(x, a, c) + three
    return area, around


@entry("d2 l2 d l2 d2* -> .")
def add_triangles_to_units(x, t, level, sides, out):
    """Add triangles to the sums of the units that they bound, as `run_checks.add_to_units` does
    for runs. Volumes are measured from an elevation, `level`.
    """
    for i in range(t.shape[0]):
        if sides[i, 0] == sides[i, 1]:
            continue
        a, b, c = t[i, 0], t[i, 1], t[i, 2]
        nx, ny, nz = _normal(x, a, b, c)
        height = (x[a, 2] - level) + (x[b, 2] - level) + (x[c, 2] - level)
        area = np.sqrt(nx * nx + ny * ny + nz * nz)
        products = _steps(x, a, b) * _steps(x, a, c)
        for s in range(2):
            unit = sides[i, s]
            if unit < 0:
                continue
            two_sum(out, unit, 0, nz * height if s == 1 else -(nz * height))
            two_sum(out, unit, 2, area)
            out[unit, 4] += products
            out[unit, 5] += 1.0
