"""Welding, edges, patches and connected pieces of triangle meshes, by integer keys.

Notation
    x      coordinates, float64 (n_vertex, 3)
    t      triangles, int64 (n_triangle, 3)
    half-edge 3 * i + c of triangle i runs from corner c to the next
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.exact.constructed_points import hash_of_row
from geosurf.kernels.exact.predicates import normal_axis, orient2d

# ---- numbering ----------------------------------------
# Numbering of the distinct keys of an array, at the cost of the distinct keys.


def edge_keys(triangles: np.ndarray, n: int) -> np.ndarray:
    """One number for each of the three edges of each triangle (3 m,), whose corners are below n."""
    start, end = np.ravel(triangles), np.ravel(triangles[:, [1, 2, 0]])
    return np.minimum(start, end) * n + np.maximum(start, end)


def number_keys(keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distinct keys in increasing order, and the number of each key among them.

    A table and a sort of the distinct ones: three times as fast as sorting all where each key comes
    five times, as triangles do in candidate pairs. numpy sorts three times as fast as compiled
    kernels do, with vector instructions.

    Parameters
    ----------
    keys : ndarray of int64, shape (n,)

    Returns
    -------
    found : ndarray of int64, shape (n_distinct,)
    number : ndarray of int64, shape (n,)

    Examples
    --------
    >>> number_keys(np.array([7, 3, 7]))
    (array([3, 7]), array([1, 0, 1]))
    """
    distinct_keys, number = first_seen(keys)
    order = np.argsort(distinct_keys)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return distinct_keys[order], rank[number]


def renumbered(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The distinct numbers in an array (n, 3), rising, and the place of each number among them.

    Examples
    --------
    >>> [found.tolist() for found in renumbered(np.array([[4, 9, 7]]))]
    [[4, 7, 9], [[0, 2, 1]]]
    """
    first = int(np.min(t, initial=0))
    span = int(np.max(t, initial=0)) + 1 - first
    if span > 16 * t.size:  # a small unit in a large model
        used, place = np.unique(t, return_inverse=True)
        return used, np.reshape(place, t.shape)

    # a table over the range of numbers: a tenth of the time of a sort
    place = np.zeros(span, dtype=np.int64)
    place[t - first] = 1
    used = first + np.flatnonzero(place)
    place[used - first] = np.arange(len(used))
    return used, place[t - first]


@entry("l1 -> l1 l1")
def first_seen(keys):
    """Distinct keys in the order in which they come, and the number of each key among them."""
    n = keys.shape[0]
    size = 16
    while size < 2 * n:
        size *= 2
    slots = np.full(size, -1, dtype=np.int64)
    number = np.empty(n, dtype=np.int64)
    distinct_keys = np.empty(n, dtype=np.int64)
    count = 0
    for i in range(n):
        key = keys[i]

        # Multiply both halves of the key; the result stays below 2**63.
        h = (key & 0x3FFFFFFF) * 0x1E3779B1 + (key >> 30) * 8388593  # below 2**63
        slot = (h ^ (h >> 29)) & (size - 1)
        # Linear probing in a table that is at most half full.
        while slots[slot] >= 0 and distinct_keys[slots[slot]] != key:
            slot = (slot + 1) & (size - 1)
        if slots[slot] < 0:
            slots[slot] = count
            distinct_keys[count] = key
            count += 1
        number[i] = slots[slot]
    return distinct_keys[:count].copy(), number


_LONG = 32  # half-edges of one lower vertex that are matched by searching
_BITS = 32  # of a half-edge in a number that holds its upper vertex, too
_LOWER = (1 << _BITS) - 1


@scalar
def weld_rows(x):
    """Number of the first vertex with equal coordinates, renumbered from 0; `weld` for kernels."""
    n = x.shape[0]
    # A power of two, at most half full.
    size = 16
    while size < 2 * n:
        size *= 2
    slots = np.full(size, -1, dtype=np.int64)
    number = np.empty(n, dtype=np.int64)
    count = 0
    for i in range(n):
        # Open addressing; equal coordinates share a slot.
        slot = hash_of_row(x, i) & (size - 1)
        while slots[slot] >= 0:
            j = slots[slot]
            if x[j, 0] == x[i, 0] and x[j, 1] == x[i, 1] and x[j, 2] == x[i, 2]:
                break
            slot = (slot + 1) & (size - 1)
        if slots[slot] < 0:
            slots[slot] = i
            number[i] = count
            count += 1
        else:
            number[i] = number[slots[slot]]
    return number, count


@entry("d2 -> l1 l")
def weld(x):
    """Number of the first vertex with equal coordinates, renumbered from 0, and how many."""
    return weld_rows(x)


@scalar
def with_upper(half, upper):
    """A half-edge and its upper vertex in one number; half-edges stay below 2**32."""
    return (upper << _BITS) + half


@scalar
def half_of(both):
    """The half-edge of `with_upper`."""
    return both & _LOWER


@scalar
def upper_of(both):
    """The upper vertex of `with_upper`."""
    return both >> _BITS


@scalar
def half_edges_by_vertex(t, n_vertex):
    """Half-edges by their lower vertex: first place of each vertex, and half-edges `with_upper`."""
    # Entry v + 2 counts vertex v. The fill moves entry v + 1 from the begin to the end of v's
    # range, so that start[v] is its begin afterwards.
    start = np.zeros(n_vertex + 2, dtype=np.int64)
    for i in range(t.shape[0]):
        a, b, c = t[i, 0], t[i, 1], t[i, 2]
        start[min(a, b) + 2] += 1
        start[min(b, c) + 2] += 1
        start[min(c, a) + 2] += 1

    # Prefix sums, shifted by one vertex for the fill below.
    for v in range(2, n_vertex + 2):
        start[v] += start[v - 1]
    bucket = np.empty(3 * t.shape[0], dtype=np.int64)
    for i in range(t.shape[0]):
        for c in range(3):
            a, b = t[i, c], t[i, 0 if c == 2 else c + 1]
            v = min(a, b) + 1
            bucket[start[v]] = with_upper(3 * i + c, max(a, b))
            start[v] += 1
    return start, bucket


@scalar
def match_in_buckets(start, bucket, n_vertex, ring):
    """Put half-edges in the buckets of all vertices into rings; number of edges.

    `start` and `bucket` as from `half_edges_by_vertex`. In the long bucket of a vertex with
    thousands of triangles, each upper vertex stores the last half-edge that led to it.
    """
    last = np.empty(0, dtype=np.int64)
    count = 0
    for v in range(n_vertex):
        low, high = start[v], start[v + 1]

        # Short buckets are searched backwards, long ones use a table of upper vertices.
        long = high - low > _LONG
        if long and last.shape[0] == 0:
            last = np.full(n_vertex, -1, dtype=np.int64)
        for p in range(low, high):
            # Nearest first: half-edges of one edge mostly come close together.
            match, upper = p - 1, upper_of(bucket[p])
            if long:
                match = last[upper]  # below `low`: of an earlier bucket
                last[upper] = p
            else:
                while match >= low and upper_of(bucket[match]) != upper:
                    match -= 1

            # Insert into the ring of the matching half-edge, or start a new edge.
            if match >= low:
                half, other = half_of(bucket[p]), half_of(bucket[match])
                ring[half] = ring[other]
                ring[other] = half
            else:
                count += 1
    return count


def ends_of(t: np.ndarray, halves: np.ndarray) -> np.ndarray:
    """Both vertices (n, 2) of some half-edges, the lower one first."""
    i, c = np.divmod(halves, 3)
    return np.sort(np.stack([t[i, c], t[i, (c + 1) % 3]], axis=1), axis=1)


@entry("l2 l -> l1 l")
def edges(t, n_vertex):
    """A ring through the half-edges of each edge, and the number of edges.

    Half-edges of a ring rise, but for the last one, which leads back to the first.

    Half-edges are put into buckets by their lower vertex and matched inside a bucket: a hash table
    of all half-edges takes six times as long, since it jumps through memory.
    """
    start, bucket = half_edges_by_vertex(t, n_vertex)
    # A half-edge that stays alone is a ring of its own.
    ring = np.arange(3 * t.shape[0])
    return ring, match_in_buckets(start, bucket, n_vertex, ring)


@scalar
def find(parent, i):
    """Root of i, with path halving."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@scalar
def join(parent, i, j):
    """Unite two sets; the lower root wins, so that the result is unique."""
    i = find(parent, i)
    j = find(parent, j)
    if i < j:
        parent[j] = i
    elif j < i:
        parent[i] = j


@scalar
def numbered(parent):
    """Number of each element's set, in order of first elements, and the number of sets."""
    number = np.full(parent.shape[0], -1, dtype=np.int64)
    # Roots are the lowest elements, so numbers follow first elements.
    count = 0
    for i in range(parent.shape[0]):
        root = find(parent, i)
        if number[root] < 0:
            number[root] = count
            count += 1
        number[i] = number[root]
    return number, count


@entry("l2 l -> l1")
def join_pairs(pairs, n):
    """Set of each of n elements once all pairs are joined: its lowest element."""
    parent = np.arange(n)
    for i in range(pairs.shape[0]):
        join(parent, pairs[i, 0], pairs[i, 1])

    # Full path compression: each element gets its root.
    for i in range(n):
        parent[i] = find(parent, i)
    return parent


@scalar
def _is_first(twin, i):
    """Whether no earlier triangle has the corners of triangle i; `twin` may be empty."""
    return twin.shape[0] == 0 or twin[i] == i


@scalar
def _around(owners, ring, twin, i):
    """Of the distinct triangles around an edge: number, last two, and whether owners differ."""
    count = 0
    previous = last = -1
    mixed = False
    j = i
    while True:
        # Coinciding triangles count once, by their first copy.
        if _is_first(twin, j // 3):
            count += 1
            previous, last = last, j // 3
            mixed = mixed or (previous >= 0 and owners[previous] != owners[last])
        j = ring[j]
        if j == i:
            return count, previous, last, mixed


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


@entry("l1 l1 l1 l1 -> l1 l1")
def join_patches(surface, owners, ring, twin):
    """Patch of each triangle, numbered by first triangle; and the edges between patches, each by
    its last half-edge, rising.

    Triangles are joined over edges that two distinct ones share, if the same surfaces own both:
    `owners` has a number for the set of these. `twin` is the first triangle with the same corners,
    mostly itself; it is empty if no triangles coincide.
    """
    parent = np.arange(surface.shape[0])
    rim, n_rim = np.empty(ring.shape[0], dtype=np.int64), 0
    for i in range(ring.shape[0]):
        # Rings rise: the last half-edge of an edge leads back to the first one, `j`.
        j = ring[i]
        if j >= i:
            continue  # alone, or not the last

        # The common case: two distinct triangles.
        face, other = i // 3, j // 3
        if ring[j] == i and _is_first(twin, face) and _is_first(twin, other):  # nearly all
            # Two triangles of the same surfaces belong to one patch.
            same = owners[face] == owners[other]
            count, mixed = 2, not same
        else:  # once per edge: thousands of triangles may share it
            count, face, other, mixed = _around(owners, ring, twin, j)
            same = count == 2 and owners[face] == owners[other]
        if same:
            join(parent, face, other)
        if mixed or count > 2:
            rim[n_rim] = i
            n_rim += 1
    _join_coinciding(parent, surface, ring, twin)
    return numbered(parent)[0], rim[:n_rim].copy()


@entry("l2 l1 -> l1 l")
def pieces(t, ring):
    """Connected pieces over common edges: number of each triangle, and how many."""
    n = t.shape[0]
    parent = np.arange(n)

    # Triangles on one ring share an edge.
    for i in range(3 * n):
        join(parent, i // 3, ring[i] // 3)
    return numbered(parent)


@entry("d2 l2 l2 l1 l1* l1* -> l1")
def inverted_triangles(x, t, parents, parent, m, w):
    """Rows of the triangles that do not face as their parents do, on the same axis."""
    rows = np.empty(t.shape[0], dtype=np.int64)
    n = 0
    axis, side = 0, 0
    for i in range(t.shape[0]):
        p = parent[i]

        # Children of one parent are adjacent: its axis is computed once.
        if i == 0 or p != parent[i - 1]:
            axis, side = normal_axis(x, m, w, parents[p, 0], parents[p, 1], parents[p, 2])
        u, v = (axis + 1) % 3, (axis + 2) % 3
        # No area counts as inverted too.
        if side * orient2d(x, m, w, t[i, 0], t[i, 1], t[i, 2], u, v) <= 0:
            rows[n] = i
            n += 1
    return rows[:n].copy()


# ---- kept ----------------------------------------
# A mesh of which some triangles are left out.


FREE = -1  # as of `Pieces.link`


@entry("b1 l2 l1 l1 l1 l1 l1 l1 l -> l2 l1 l1 l1 l1 l1 l1")
def kept_triangles(keep, triangles, surface, key, patch, patch_of, ring, link, n_point):
    """All that pieces state of their triangles (see `Pieces`), of those that stay.

    Patches get the numbers `patch_of`, and triangles and points are numbered again. A half-edge
    that becomes the only one of its edge is free.

    Returns
    -------
    triangles, surface, key, patch, ring, link
        Of the triangles that stay.
    number : int64 (n_point,)
        New number of each point that they use, or -1.
    """
    row_of = np.empty(keep.shape[0], dtype=np.int64)
    number = np.full(n_point, -1, dtype=np.int64)
    n = 0
    for i in range(keep.shape[0]):
        if keep[i]:
            row_of[i] = n
            n += 1
            for c in range(3):
                number[triangles[i, c]] = 0
    count = 0
    for p in range(n_point):
        if number[p] == 0:
            number[p] = count
            count += 1

    corners = np.empty((n, 3), dtype=np.int64)
    of_surface, of_key = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    of_patch = np.empty(n, dtype=np.int64)
    onward, behind = np.empty(3 * n, dtype=np.int64), np.empty(3 * n, dtype=np.int64)
    k = 0
    for i in range(keep.shape[0]):
        if not keep[i]:
            continue
        of_surface[k], of_key[k], of_patch[k] = surface[i], key[i], patch_of[patch[i]]
        for c in range(3):
            corners[k, c] = number[triangles[i, c]]
            half = 3 * i + c
            j = ring[half]
            alone = j == half

            # past what is left out, to the next one that stays: itself in the end
            row = j // 3
            while not keep[row]:
                j = ring[j]
                row = j // 3
            onward[3 * k + c] = 3 * row_of[row] + j - 3 * row
            behind[3 * k + c] = FREE if j == half and not alone else link[half]
        k += 1
    return corners, of_surface, of_key, of_patch, onward, behind, number
