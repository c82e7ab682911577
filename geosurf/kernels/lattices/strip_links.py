"""What lies behind the edges of listed triangles of a lattice: runs that no curve touches.

Letters as in `strips`; half-edge 3 * i + c of triangle i runs from corner c to the next.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.strips import key_across, run_of_key
from geosurf.kernels.search.tree import N_COL, N_ROW

NONE = -1  # of `link`: the rim of the lattice


@scalar
def _whole_edge(corners, number, face, one, two):
    """The edge of a face that runs between two points; -1 if none does."""
    for k in range(3):
        if number[corners[face, k]] == one and number[corners[face, (k + 1) % 3]] == two:
            return k
    return -1


@entry("l2 l1 l1 l1 l l l2 l1 l1 l1 b l2 l1 l l1* -> l l2")
def link_runs(
    t, key, face, ring, low, high, corners, number, a, absent, turned, runs, start,
    first_run, link,
):  # fmt: skip
    """Write the run behind each half-edge that is alone, of `low` to `high` - 1.


    `face` is the row of `corners` that each triangle is a part of, and `number` the point of each
    corner. Returns a triangle that has no neighbour although its edge is inside the lattice, or -1;
    and the half-edges (n, 2) with the runs behind them.
    """
    linked, n = np.empty((1024, 2), dtype=np.int64), 0
    for h in range(low, high):
        if ring[h] != h:
            continue
        i, c = h // 3, h % 3
        # at the rim of a torn sheet, past a fault: keys of its copies follow the lattice's
        if key[i] >= 2 * (a[N_ROW] - 1) * (a[N_COL] - 1):
            continue
        # a triangle in no contact, next to a gap, is whole
        edge = c
        if face[i] >= 0:
            edge = _whole_edge(corners, number, face[i], t[i, c], t[i, (c + 1) % 3])
        if edge < 0:
            # a part of an edge: of the rim, or its neighbour would be cut, too
            behind = 0
            for k in range(3):
                behind = min(behind, key_across(a, absent, turned, key[i], k))
            if behind >= 0:
                return i, linked[:0].copy()
            continue

        # the triangle behind is in a run; otherwise the mesh would have a gap
        behind = key_across(a, absent, turned, key[i], edge)
        if behind >= 0:
            run = run_of_key(a, runs, start, behind)
            if run < 0:
                return i, linked[:0].copy()
            if n == linked.shape[0]:
                more = np.empty((2 * n, 2), dtype=np.int64)
                more[:n] = linked
                linked = more
            link[h] = first_run + run
            linked[n, 0], linked[n, 1] = h, link[h]
            n += 1
    return NONE, linked[:n].copy()
