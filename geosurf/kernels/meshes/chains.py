"""Chains of segments with equal end points, in one canonical order.

Notation
    nodes      points of one pair of surfaces after another, each pair's increasing
    offsets    first link of each node, and the end of the last
    links      node at the other end of each link; partner: the same link seen from there
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar


def link_segments(
    segments: np.ndarray, first: np.ndarray, n_point: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Chains of points: points chain by chain, offsets, and the pair of each.

    The segments of pair i are those from `first[i]` on. A chain ends where other than two segments
    of its pair meet; one that returns to its start is closed and repeats it. Order: by pair; then
    chains from points with ends or branches, by their first point, then plain loops from their
    lowest point towards its lower neighbour.
    """
    n_pair = len(first) - 1
    pair = np.repeat(np.arange(n_pair), np.diff(first))
    nodes, ends = np.unique((n_point * pair)[:, None] + segments, return_inverse=True)
    begin = np.searchsorted(nodes, n_point * np.arange(n_pair + 1))
    chains, offsets, pair_of_chain = link_nodes(ends.reshape(-1, 2), begin)
    return nodes[chains] % max(n_point, 1), offsets, pair_of_chain


@scalar
def _links_of(ends, n_node):
    """Links of all nodes: offsets, links, partner."""
    n = ends.shape[0]
    offsets = np.zeros(n_node + 1, dtype=np.int64)
    for s in range(n):
        offsets[ends[s, 0] + 1] += 1
        offsets[ends[s, 1] + 1] += 1
    for i in range(n_node):
        offsets[i + 1] += offsets[i]

    # Fill both directions of each segment.
    fill = offsets[:-1].copy()
    links = np.empty(2 * n, dtype=np.int64)
    partner = np.empty(2 * n, dtype=np.int64)
    for s in range(n):
        a, b = ends[s, 0], ends[s, 1]
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


@entry("l2 l1 -> l1 l1 l1")
def link_nodes(ends, begin):
    """Chains of nodes, see `link_segments`: nodes chain by chain, offsets, and the pair of each.

    `ends` are the nodes of each segment; those of pair i are from `begin[i]` to `begin[i + 1]`.
    """
    n = ends.shape[0]
    offsets, links, partner = _links_of(ends, begin[begin.shape[0] - 1])
    used = np.zeros(2 * n, dtype=np.bool_)
    out, starts = np.empty(2 * n, dtype=np.int64), np.empty(n + 1, dtype=np.int64)
    pair_of_chain = np.empty(n, dtype=np.int64)
    count, size = 0, 0
    for pair in range(begin.shape[0] - 1):
        # First chains from ends and branches, then closed loops.
        for plain in range(2):
            for node in range(begin[pair], begin[pair + 1]):
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
                    starts[count], pair_of_chain[count] = size, pair
                    count += 1
                    size = _walk(node, best, offsets, links, partner, used, out, size)
    starts[count] = size
    return out[:size].copy(), starts[: count + 1].copy(), pair_of_chain[:count].copy()
