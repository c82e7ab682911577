"""Shells as meshes: their order, their open edges, their sums, and triangles with equal corners.

A certificate runs these over all triangles of a model, twice for those between two units. Each is
one pass without a global sort: triangles are put into buckets by their lowest corner.

Notation as in `mesh`: x coordinates, t triangles.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.meshes.mesh import half_edges_by_vertex, half_of, upper_of

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


@scalar
def _two_sum(high, low, term):
    """A sum as two numbers, the second one with all rounding errors of the first (Knuth)."""
    total = high + term
    back = total - high
    return total, low + ((high - (total - back)) + (term - back))


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
        volume, volume_rest = _two_sum(volume, volume_rest, term)
        area, area_rest = _two_sum(area, area_rest, np.sqrt(nx * nx + ny * ny + nz * nz))
        u, v = abs(ux) + abs(uy) + abs(uz), abs(vx) + abs(vy) + abs(vz)
        # Sums for the error bound that the certificate reports.
        products += u * v
        sides += u + v + abs(ux - vx) + abs(uy - vy) + abs(uz - vz)
    return (volume + volume_rest) / 6.0, 0.5 * (area + area_rest), products, sides
