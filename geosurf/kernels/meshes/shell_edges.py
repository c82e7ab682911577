"""Edges and vertices of the shells of all units, counted in one pass over listed triangles.

Each triangle bounds the unit behind it as it is, and the unit in front of it turned over. A shell
is closed if it runs through each edge as often one way as the other.

Notation
    t        triangles, rows of vertices
    sides    units in front of and behind each triangle (n, 2); -1 outside the model
    row      the element (triangle or run) that each is a part of
    counts   int64 (n_unit, 3): vertices, edges and open edges of the shell of each unit
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.run_checks import EDGES, OPEN, VERTICES
from geosurf.kernels.meshes.mesh import half_edges_by_vertex, half_of, upper_of


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
