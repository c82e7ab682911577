"""Distance of each node of a lattice graph from a set of nodes, in links.

`east` and `north` are the neighbours of each node, -1 where the link is cut or missing; no node is
the neighbour of two nodes in one direction.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry


@entry("l1 l1 b1 l -> l1")
def steps_from(east, north, start, longest):
    """Number of links (n,) from each node to the nearest of `start`, at most `longest`."""
    n = east.shape[0]

    # Links in all four directions.
    neighbours = np.full((n, 4), -1, dtype=np.int64)
    for v in range(n):
        if east[v] >= 0:
            neighbours[v, 0] = east[v]
            neighbours[east[v], 1] = v
        if north[v] >= 0:
            neighbours[v, 2] = north[v]
            neighbours[north[v], 3] = v

    # Breadth-first search from all start nodes at once.
    # Nodes that are never reached stay at `longest`.
    steps = np.full(n, longest, dtype=np.int64)
    queue = np.empty(n, dtype=np.int64)
    count = done = 0
    for v in range(n):
        if start[v]:
            steps[v] = 0
            queue[count] = v
            count += 1
    while done < count:
        v = queue[done]
        done += 1
        ahead = steps[v] + 1
        for k in range(4):
            u = neighbours[v, k]
            # Nodes come in order of their distance, so the first visit is final.
            if u >= 0 and ahead < steps[u]:
                steps[u] = ahead
                queue[count] = u
                count += 1
    return steps
