"""Segments -> chains by equal end points, in one canonical order."""

from __future__ import annotations

import numpy as np

from geosurf.kernels._jit import entry, scalar


@scalar
def _walk(start, first, offsets, links, partner, used, out, n):
    """Follow a chain from a node along one link until a node that is no plain passage."""
    out[n] = start
    n += 1
    link = first
    while True:
        used[link] = 1
        used[partner[link]] = 1
        node = links[link]
        out[n] = node
        n += 1
        if node == start or offsets[node + 1] - offsets[node] != 2:
            return n
        onward = offsets[node]
        if onward == partner[link]:
            onward += 1
        link = onward


@entry("l2 l -> l1 l1")
def link_segments(segments, n_node):
    """Chains of nodes: rows of nodes chain by chain, and offsets.

    A chain ends where other than two segments meet; one that returns to its start is closed
    and repeats it. Order: chains from nodes with ends or branches first, by node number, then
    plain loops from their lowest node towards its lower neighbour.
    """
    n = segments.shape[0]
    offsets = np.zeros(n_node + 1, dtype=np.int64)
    for s in range(n):
        offsets[segments[s, 0] + 1] += 1
        offsets[segments[s, 1] + 1] += 1
    for i in range(n_node):
        offsets[i + 1] += offsets[i]
    fill = offsets[:-1].copy()
    links = np.empty(2 * n, dtype=np.int64)
    partner = np.empty(2 * n, dtype=np.int64)
    for s in range(n):
        a, b = segments[s, 0], segments[s, 1]
        p = fill[a]
        fill[a] += 1
        q = fill[b]
        fill[b] += 1
        links[p], links[q] = b, a
        partner[p], partner[q] = q, p
    used = np.zeros(2 * n, dtype=np.int64)
    out = np.empty(2 * n + 2, dtype=np.int64)
    starts = np.empty(n + 1, dtype=np.int64)
    count = 0
    size = 0
    for plain in range(2):
        for node in range(n_node):
            passage = offsets[node + 1] - offsets[node] == 2
            if passage != (plain == 1):
                continue
            while True:
                best = -1
                for link in range(offsets[node], offsets[node + 1]):
                    if used[link] == 0 and (best < 0 or links[link] < links[best]):
                        best = link
                if best < 0:
                    break
                starts[count] = size
                count += 1
                size = _walk(node, best, offsets, links, partner, used, out, size)
    starts[count] = size
    return out[:size].copy(), starts[: count + 1].copy()
