"""Pieces of an arrangement, as far as an earlier one has them: edges and patches are carried over.

Triangles of faces that are cut alike are the same in both, in the same order. Around an edge of
which all triangles are in both, nothing changes. The other edges are matched again, and patches
that lose or gain something are joined again.

Letters as in `mesh` and `parts`; a 0 marks what is of the earlier pieces, and
    before   for each triangle (run) the earlier one that it is, or -1
    after    for each earlier triangle (run) the one that it is now, or -1
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.strips import FIRST, LAST
from geosurf.kernels.meshes.merged_pieces import number_in_order
from geosurf.kernels.meshes.mesh import join, match_in_buckets

_FREE, _PAIRED = -1, -2  # of `link`


@entry("l1 l1 l1 l1 l1 l1 l1 b1 -> l1 l1")
def same_triangles(surface0, key0, face0, surface, key, face, new_face, changed):
    """`before` and `after` of triangles, by the faces that they are of.

    `surface0` are the new surfaces of the earlier triangles, or -1; `new_face` those of the faces
    of contacts, and `changed` are faces that are cut again.
    """
    n0, n = surface0.shape[0], surface.shape[0]
    before, after = np.full(n, -1, dtype=np.int64), np.full(n0, -1, dtype=np.int64)
    i = j = 0
    while j < n:
        while i < n0 and (
            surface0[i] < 0
            or surface0[i] < surface[j]
            or (surface0[i] == surface[j] and key0[i] < key[j])
        ):
            i += 1
        s, k, f = surface[j], key[j], face[j]
        same = i < n0 and surface0[i] == s and key0[i] == k
        if same:
            same = face0[i] < 0 if f < 0 else face0[i] >= 0 and new_face[face0[i]] == f
            same = same and (f < 0 or not changed[f])
        while j < n and surface[j] == s and key[j] == k:
            if same:
                before[j], after[i] = i, j
                i += 1
            j += 1
    return before, after


@entry("l2 l1 l2 l1 -> l1")
def same_runs(runs0, start0, runs, start):
    """Run that each earlier run of a lattice is now, or -1: those with the same triangles."""
    after = np.full(runs0.shape[0], -1, dtype=np.int64)
    for row in range(start.shape[0] - 1):
        k = start[row]
        for i in range(start0[row], start0[row + 1]):
            while k < start[row + 1] and runs[k, FIRST] < runs0[i, FIRST]:
                k += 1
            if k == start[row + 1]:
                break
            if runs[k, FIRST] == runs0[i, FIRST] and runs[k, LAST] == runs0[i, LAST]:
                after[i] = k
    return after


@scalar
def _all_stay(ring0, after, start):
    """Whether all triangles around an earlier edge are there still."""
    j = ring0[start]
    while j != start:
        if after[j // 3] < 0:
            return False
        j = ring0[j]
    return True


@entry("l1 l1 l1 l1 l1 -> l1 l1 l1")
def carry_rings(before, after, ring0, link0, run_after):
    """Rings and links of half-edges that are carried over, and all others, which are alone yet.

    `run_after` tells which earlier run is which run now, over all lattices.
    """
    n = 3 * before.shape[0]
    ring, link = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    others = np.empty(n, dtype=np.int64)
    n_other = 0
    for i in range(before.shape[0]):
        for c in range(3):
            h = 3 * i + c
            ring[h], link[h] = h, _FREE
            carried = before[i] >= 0
            if carried:
                old = 3 * before[i] + c
                j = ring0[old]
                if j == old:
                    # what is behind may be listed now
                    if link0[old] >= 0:
                        link[h] = run_after[link0[old]]
                        carried = link[h] >= 0
                else:
                    carried = _all_stay(ring0, after, old)
                    if carried:
                        ring[h], link[h] = 3 * after[j // 3] + j % 3, _PAIRED
            if not carried:
                link[h] = _FREE
                others[n_other] = h
                n_other += 1
    return ring, link, others[:n_other].copy()


@entry("l2 l l1 l1 l1 -> .")
def match_half_edges(t, n_vertex, halves, ring, link):
    """Put some half-edges, which rise, into rings, as `edges` does with all."""
    start = np.zeros(n_vertex + 2, dtype=np.int64)
    for k in range(halves.shape[0]):
        i, c = halves[k] // 3, halves[k] % 3
        start[min(t[i, c], t[i, (c + 1) % 3]) + 2] += 1
    for v in range(2, n_vertex + 2):
        start[v] += start[v - 1]
    half, upper = np.empty_like(halves), np.empty_like(halves)
    for k in range(halves.shape[0]):
        i, c = halves[k] // 3, halves[k] % 3
        a, b = t[i, c], t[i, (c + 1) % 3]
        v = min(a, b) + 1
        half[start[v]], upper[start[v]] = halves[k], max(a, b)
        start[v] += 1

    match_in_buckets(start, half, upper, n_vertex, ring)
    for k in range(halves.shape[0]):
        if ring[halves[k]] != halves[k]:
            link[halves[k]] = _PAIRED


@scalar
def _settle(before, patch0, first0, touched, parent, offset, first, settled):
    """Give elements of patches that stay the first element of their patch, from `offset` on."""
    for i in range(before.shape[0]):
        if before[i] >= 0:
            p = patch0[first0 + before[i]]
            if not touched[p]:
                if first[p] < 0:
                    first[p] = offset + i
                parent[offset + i] = first[p]
                settled[offset + i] = True


@entry("l1 l1 l1 l1 l l1 l2 l1 l1 l1 l1 l2 l1 l1 -> l1 l2")
def carry_patches(
    before, after, run_before, run_after, n_patch0, patch0, t, surface, key, ring, link, joined,
    lowest, first_run,
):  # fmt: skip
    """Patch of each element, as `number_patches` gives them, and the edges between patches.

    No two triangles coincide. Elements of a patch that is as it was are not joined again.
    """
    n, n_run = before.shape[0], run_before.shape[0]
    touched = np.zeros(n_patch0, dtype=np.bool_)
    for i in range(after.shape[0]):
        if after[i] < 0:
            touched[patch0[i]] = True
    for i in range(run_after.shape[0]):
        if run_after[i] < 0:
            touched[patch0[after.shape[0] + i]] = True
    parent, first = np.arange(n + n_run), np.full(n_patch0, -1, dtype=np.int64)
    settled = np.zeros(n + n_run, dtype=np.bool_)
    _settle(before, patch0, 0, touched, parent, 0, first, settled)
    _settle(run_before, patch0, after.shape[0], touched, parent, n, first, settled)

    # rings rise: the last half-edge of an edge leads back to the first one
    rim = np.empty((1024, 2), dtype=np.int64)
    n_rim = 0
    for h in range(3 * n):
        j = ring[h]
        if j > h:
            continue
        i, other = h // 3, j // 3
        if j == h:
            if link[h] >= 0 and not (settled[i] and settled[n + link[h]]):
                join(parent, i, n + link[h])
        elif ring[j] == h and surface[i] == surface[other]:
            if not (settled[i] and settled[other]):
                join(parent, i, other)
        else:
            if n_rim == rim.shape[0]:
                longer = np.empty((2 * n_rim, 2), dtype=np.int64)
                longer[:n_rim] = rim
                rim = longer
            a, b = t[i, h % 3], t[i, (h + 1) % 3]
            rim[n_rim, 0], rim[n_rim, 1] = min(a, b), max(a, b)
            n_rim += 1
    for k in range(joined.shape[0]):
        a, b = n + joined[k, 0], n + joined[k, 1]
        if not (settled[a] and settled[b]):
            join(parent, a, b)
    patch = number_in_order(parent, np.arange(n), n, surface, key, lowest, first_run)
    return patch, rim[:n_rim].copy()
