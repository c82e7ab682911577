"""Edges and patches by ranges of triangles or vertices, for threads; letters as in `mesh`.

Every range writes what no other one reads, and results are those of one range: half-edges come
into their buckets in their order, each bucket is matched as a whole, and sets are numbered after
all ranges have joined theirs.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.meshes.mesh import find, join, match_in_buckets, numbered, with_upper


@entry("l2 l l l1* -> .")
def count_lower(t, low, high, count):
    """Count half-edges by their lower vertex, of triangles `low` to `high` - 1."""
    for i in range(low, high):
        a, b, c = t[i, 0], t[i, 1], t[i, 2]
        count[min(a, b)] += 1
        count[min(b, c)] += 1
        count[min(c, a)] += 1


@entry("l2* -> l1")
def begin_buckets(count):
    """First place of each vertex, and the end; `count` (n_range, n_vertex) becomes the first place
    of each range in the bucket of each vertex.
    """
    start = np.empty(count.shape[1] + 1, dtype=np.int64)
    place = 0
    for v in range(count.shape[1]):
        start[v] = place
        for k in range(count.shape[0]):
            place, count[k, v] = place + count[k, v], place
    start[count.shape[1]] = place
    return start


@entry("l2 l l l1* l1* l1* -> .")
def fill_buckets(t, low, high, place, bucket, ring):
    """Put half-edges into buckets from the places of this range on; each is a ring of its own."""
    for i in range(low, high):
        for c in range(3):
            a, b = t[i, c], t[i, 0 if c == 2 else c + 1]
            v = min(a, b)
            bucket[place[v]] = with_upper(3 * i + c, max(a, b))
            place[v] += 1
            ring[3 * i + c] = 3 * i + c


@entry("l1 l1 l l l1* -> l")
def match_buckets(start, bucket, low, high, ring):
    """Put half-edges in the buckets of vertices `low` to `high` - 1 into rings; number of edges."""
    return match_in_buckets(start, bucket, low, high, start.shape[0] - 1, ring)


@entry("l1 l l l l l1* -> .")
def mark_alone(ring, low, high, free, paired, link):
    """Write to `link` which of the half-edges `low` to `high` - 1 are alone."""
    for h in range(low, high):
        link[h] = free if ring[h] == h else paired


@scalar
def _is_first(twin, i):
    """Whether no earlier triangle has the corners of triangle i; `twin` may be empty."""
    return twin.shape[0] == 0 or twin[i] == i


@scalar
def _around(owners, ring, twin, i):
    """Of the distinct triangles around an edge: number, last two, and whether owners differ."""
    count = 0
    one = other = -1
    mixed = False
    j = i
    while True:
        # Coinciding triangles count once, by their first copy.
        if _is_first(twin, j // 3):
            count += 1
            one, other = other, j // 3
            mixed = mixed or (one >= 0 and owners[one] != owners[other])
        j = ring[j]
        if j == i:
            return count, one, other, mixed


@scalar
def _join_coinciding(parent, surface, ring, twin):
    """Join coinciding triangles like their twins, surface by surface."""
    for i in range(twin.shape[0]):
        # A triangle without an earlier copy is joined above.
        if twin[i] == i:
            continue
        if surface[twin[i]] == surface[i]:  # a surface that lies on itself: one patch, any order
            join(parent, i, twin[i])

        # Neighbours of a copy are joined if their originals are.
        for c in range(3):
            j = ring[3 * i + c]
            while j != 3 * i + c:
                if surface[j // 3] == surface[i] and _same_patch(parent, twin, i, j // 3):
                    join(parent, i, j // 3)
                j = ring[j]


@scalar
def _same_patch(parent, twin, i, j):
    """Whether triangles i and j both coincide with others that lie in one patch."""
    return twin[j] != j and find(parent, twin[i]) == find(parent, twin[j])


@scalar
def _longer(pairs):
    """The same pairs, with room for as many more."""
    found = np.empty((2 * pairs.shape[0], 2), dtype=np.int64)
    found[: pairs.shape[0]] = pairs
    return found


@entry("l1 l1 l1 l l l1* -> l2 l1")
def join_range(owners, ring, twin, low, high, parent):
    """Join triangles `low` to `high` - 1 with each other over the edges inside patches.

    `twin` is empty if no triangles coincide.

    `parent` of these triangles is written. An edge is visited at its last half-edge. Returns pairs
    of triangles that belong together, of which one is below `low`; and the edges between patches,
    each by its last half-edge.
    """
    across, n_across = np.empty((256, 2), dtype=np.int64), 0
    rim, n_rim = np.empty(3 * (high - low), dtype=np.int64), 0
    for i in range(low, high):
        parent[i] = i
    for i in range(3 * low, 3 * high):
        # Rings rise: the last half-edge of an edge leads back to the first one, `j`.
        j = ring[i]
        if j >= i:
            continue  # alone, or not the last

        # The common case: two distinct triangles.
        one, other = i // 3, j // 3
        if ring[j] == i and _is_first(twin, one) and _is_first(twin, other):  # nearly all
            # Two triangles of the same surfaces belong to one patch.
            same = owners[one] == owners[other]
            count, mixed = 2, not same
        else:  # once per edge: thousands of triangles may share it
            count, one, other, mixed = _around(owners, ring, twin, j)
            same = count == 2 and owners[one] == owners[other]
        if same:
            if min(one, other) >= low:
                join(parent, one, other)
            else:
                if n_across == across.shape[0]:
                    across = _longer(across)
                across[n_across, 0], across[n_across, 1] = one, other
                n_across += 1
        if mixed or count > 2:
            rim[n_rim] = i
            n_rim += 1
    return across[:n_across].copy(), rim[:n_rim].copy()


@entry("l1* l2 l1 l1 l1 -> l1")
def join_ranges(parent, across, surface, ring, twin):
    """Patch of each triangle, numbered by first triangle, once the ranges have been joined."""
    for k in range(across.shape[0]):
        join(parent, across[k, 0], across[k, 1])
    _join_coinciding(parent, surface, ring, twin)
    return numbered(parent)[0]
