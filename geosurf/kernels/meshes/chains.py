"""Chains of segments with equal end points, in one canonical order.

The pairs of surfaces are processed one by one. All arrays of a pair have its own size, so twenty
pairs cost as much as one with as many segments.

Notation
    segments   points (n, 2), lower first; grouped by pair, sorted by their lower points
    nodes      points of one pair, increasing; `number` is the index of a point among them, or -1
    offsets    first link of each node, and the end of the last
    links      node at the other end of each link; partner: the same link seen from there
Indices of nodes and links have 32 bits, so that the tables stay in the nearer cache.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar

_LOWER, _UPPER = -2, -3  # marks of points while nodes are gathered


@scalar
def _nodes_of(segments, number):
    """Points of the segments of one pair, increasing; writes `number`."""
    n = segments.shape[0]

    # Mark lower points, collect those that occur as upper points only.
    for s in range(n):
        number[segments[s, 0]] = _LOWER
    upper = np.empty(n, dtype=np.int32)
    n_upper = 0
    for s in range(n):
        # Lower points are in the other list already.
        if number[segments[s, 1]] == -1:
            number[segments[s, 1]] = _UPPER
            upper[n_upper] = segments[s, 1]
            n_upper += 1
    upper = np.sort(upper[:n_upper])  # mostly few: lower points are sorted already

    # Merge the two sorted lists.
    nodes = np.empty(n + n_upper, dtype=np.int32)
    count, k = 0, 0
    for s in range(n):
        point = segments[s, 0]
        # A lower point comes with each of its segments; the first one numbers it.
        if number[point] != _LOWER:
            continue
        while k < n_upper and upper[k] < point:
            nodes[count], number[upper[k]] = upper[k], count
            count += 1
            k += 1
        nodes[count], number[point] = point, count
        count += 1
    for i in range(k, n_upper):
        nodes[count], number[upper[i]] = upper[i], count
        count += 1
    return nodes[:count]


@scalar
def _links_of(segments, number, n_node):
    """Links of the nodes of one pair: offsets, links, partner."""
    n = segments.shape[0]
    offsets = np.zeros(n_node + 1, dtype=np.int32)
    for s in range(n):
        offsets[number[segments[s, 0]] + 1] += 1
        offsets[number[segments[s, 1]] + 1] += 1
    for i in range(n_node):
        offsets[i + 1] += offsets[i]

    # Fill both directions of each segment.
    fill = offsets[:-1].copy()
    links = np.empty(2 * n, dtype=np.int32)
    partner = np.empty(2 * n, dtype=np.int32)
    for s in range(n):
        a, b = number[segments[s, 0]], number[segments[s, 1]]
        # Places of both directions know each other, so that a walk marks both as used.
        p = fill[a]
        fill[a] += 1
        q = fill[b]
        fill[b] += 1
        links[p], links[q] = b, a
        partner[p], partner[q] = q, p
    return offsets, links, partner


@scalar
def _walk(start, first, offsets, links, partner, used, out, n):
    """Follow a chain from a node along one link until a node that does not have two links."""
    out[n] = start
    n += 1
    link = first
    while True:
        used[link] = True
        used[partner[link]] = True
        node = links[link]
        out[n] = node
        n += 1
        # A loop is closed, or an end or a branch is reached.
        if node == start or offsets[node + 1] - offsets[node] != 2:
            return n

        # Of the two links take the one that does not lead back.
        onward = offsets[node]
        if onward == partner[link]:
            onward += 1
        link = onward


@scalar
def _chains_of(offsets, links, partner, out, starts):
    """Chains of one pair as nodes, written to `out` and `starts`; their number and length."""
    used = np.zeros(links.shape[0], dtype=np.bool_)
    count, size = 0, 0

    # First chains from ends and branches, then closed loops.
    for plain in range(2):
        for node in range(offsets.shape[0] - 1):
            passage = offsets[node + 1] - offsets[node] == 2
            if passage != (plain == 1):
                continue
            while True:
                # The link to the lowest neighbour, for a canonical direction.
                best = -1
                for link in range(offsets[node], offsets[node + 1]):
                    if not used[link] and (best < 0 or links[link] < links[best]):
                        best = link
                # Every link at this node is used.
                if best < 0:
                    break
                starts[count] = size
                count += 1
                size = _walk(node, best, offsets, links, partner, used, out, size)
    return count, size


@entry("l2 l1 l -> l1 l1 l1")
def link_segments(segments, first, n_point):
    """Chains of points: points chain by chain, offsets, and the pair of each.

    The segments of pair i are those from `first[i]` on. A chain ends where other than two segments
    of its pair meet; one that returns to its start is closed and repeats it. Order: by pair; then
    chains from points with ends or branches, by their first point, then plain loops from their
    lowest point towards its lower neighbour.
    """
    n = segments.shape[0]
    # One table for all pairs: each pair clears what it has set.
    number = np.full(n_point, -1, dtype=np.int32)
    out = np.empty(2 * n, dtype=np.int64)
    offsets = np.empty(n + 1, dtype=np.int64)
    pair_of_chain = np.empty(n, dtype=np.int64)
    n_out, n_chain = 0, 0
    for pair in range(first.shape[0] - 1):
        # Chains of one pair as nodes; then nodes are replaced by points.
        mine = segments[first[pair] : first[pair + 1]]
        nodes = _nodes_of(mine, number)
        of_node, links, partner = _links_of(mine, number, nodes.shape[0])
        chains, starts = out[n_out:], offsets[n_chain:]
        count, size = _chains_of(of_node, links, partner, chains, starts)
        for k in range(size):
            chains[k] = nodes[chains[k]]
        for k in range(count):
            starts[k] += n_out
            pair_of_chain[n_chain + k] = pair

        # Clear only what was set.
        for node in nodes:
            number[node] = -1
        n_out += size
        n_chain += count
    offsets[n_chain] = n_out
    return out[:n_out].copy(), offsets[: n_chain + 1].copy(), pair_of_chain[:n_chain].copy()
