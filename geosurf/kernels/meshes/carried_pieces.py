"""Pieces of an arrangement, as far as an earlier one has them: edges and patches are carried over.

Triangles of faces that are cut alike are the same in both, in the same order. Around an edge of
which all triangles are in both, nothing changes. The other edges are matched again, and patches
that lose or gain something are joined again.

Triangles keep their order, and what is new lies together along the curves of what has moved. So
the triangles that stay are a few hundred blocks, in each of which numbers grow by the same.

Letters as in `mesh` and `parts`; a 0 marks what is of the earlier pieces, and
    before   for each run the earlier one that it is, or -1
    after    for each earlier triangle (run) the one that it is now, or -1
    blocks   triangles that stay: see `carried_triangles`

Threads have ranges of whole surfaces, and the triangles, blocks and half-edges of these.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.strips import FIRST, LAST
from geosurf.kernels.meshes.carried_triangles import COUNT, FIRST0, FIRST_NOW
from geosurf.kernels.meshes.merged_pieces import number_in_order
from geosurf.kernels.meshes.mesh import find, join

_FREE, _PAIRED = -1, -2  # of `link`


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


@entry("l2 l l l1 l1 b1 -> l")
def mark_halves(blocks, low0, high0, after, ring0, marked):
    """Mark half-edges of triangles that stay beside triangles that are gone.

    These are of `low0` to `high0` - 1, in which the blocks lie. Returns at least how many are
    marked.
    """
    end, n = low0, 0
    for b in range(blocks.shape[0] + 1):
        begin = blocks[b, FIRST0] if b < blocks.shape[0] else high0
        for g in range(3 * end, 3 * begin):
            j = ring0[g]
            while j != g:
                at = after[j // 3]
                if at >= 0:
                    marked[3 * at + j % 3] = True
                    n += 1
                j = ring0[j]
        if b < blocks.shape[0]:
            end = begin + blocks[b, COUNT]
    return n


@entry("l2 l l b1 l1 l1 -> l")
def list_halves(blocks, low, high, marked, words, halves):
    """Half-edges that are marked, and all of triangles that are new, rising.

    Of triangles `low` to `high` - 1, in which the blocks lie. `words` are the marks, eight in one
    number. Returns how many there are.
    """
    count, end = 0, low
    for b in range(blocks.shape[0] + 1):
        begin = blocks[b, FIRST_NOW] if b < blocks.shape[0] else high
        for h in range(3 * end, 3 * begin):
            halves[count] = h
            count += 1
        if b == blocks.shape[0]:
            break
        end = begin + blocks[b, COUNT]
        h = 3 * begin
        while h < 3 * end:
            if h % 8 == 0 and words[h // 8] == 0:
                h += 8
                continue
            if marked[h]:
                halves[count] = h
                count += 1
            h += 1
    return count


@entry("l1 l1 b1 -> l1")
def carry_rim(rim0, after, marked):
    """Where last half-edges of edges between patches are now, of those that have not changed."""
    rim, n = np.empty_like(rim0), 0
    for k in range(rim0.shape[0]):
        at = after[rim0[k] // 3]
        if at >= 0 and not marked[3 * at + rim0[k] % 3]:
            rim[n] = 3 * at + rim0[k] % 3
            n += 1
    return rim[:n].copy()


@entry("l2 l1 l1 -> l2 l1")
def carry_links(linked0, after, run_after):
    """Half-edges that are alone, and the runs behind them, of those that stay; and half-edges that
    stay while the runs behind them are gone.

    `linked0` are earlier half-edges that are alone, and the runs behind them.
    """
    linked, n = np.empty_like(linked0), 0
    bare, n_bare = np.empty(linked0.shape[0], dtype=np.int64), 0
    for k in range(linked0.shape[0]):
        at, run = after[linked0[k, 0] // 3], run_after[linked0[k, 1]]
        if at >= 0 and run >= 0:
            linked[n, 0], linked[n, 1] = 3 * at + linked0[k, 0] % 3, run
            n += 1
        elif at >= 0:
            bare[n_bare] = 3 * at + linked0[k, 0] % 3
            n_bare += 1
    return linked[:n].copy(), bare[:n_bare].copy()


@entry("l2 l1 l1 l1 l1 l1 l2 l1 l1 -> .")
def write_rings(blocks, after, ring0, halves, ring_of, link_of, linked, ring, link):
    """Write the rings and links of all half-edges, of which `halves` have those of their rows.

    `linked` are others that are alone, and the runs behind them.
    """
    for k in range(halves.shape[0]):
        ring[halves[k]], link[halves[k]] = halves[ring_of[k]], link_of[k]
    at = 0
    for b in range(blocks.shape[0]):
        shift = 3 * (blocks[b, FIRST_NOW] - blocks[b, FIRST0])
        low = 3 * blocks[b, FIRST0]
        high = low + 3 * blocks[b, COUNT]
        for g in range(low, high):
            h, j = g + shift, ring0[g]
            while at < halves.shape[0] and halves[at] < h:
                at += 1
            if at < halves.shape[0] and halves[at] == h:
                continue
            if j == g:
                ring[h], link[h] = h, _FREE
            elif low <= j < high:  # nearly all
                ring[h], link[h] = j + shift, _PAIRED
            else:
                ring[h], link[h] = 3 * after[j // 3] + j % 3, _PAIRED
    for k in range(linked.shape[0]):
        link[linked[k, 0]] = linked[k, 1]


@scalar
def _left(blocks, run_after, low0, high0, low_run0, n0, patch0, n_patch0):
    """Earlier patches that have lost a triangle or a run."""
    touched = np.zeros(n_patch0, dtype=np.bool_)
    end = low0
    for b in range(blocks.shape[0] + 1):
        begin = blocks[b, FIRST0] if b < blocks.shape[0] else high0
        for i in range(end, begin):
            touched[patch0[i]] = True
        if b < blocks.shape[0]:
            end = begin + blocks[b, COUNT]
    for k in range(run_after.shape[0]):
        if run_after[k] < 0:
            touched[patch0[n0 + low_run0 + k]] = True
    return touched


@scalar
def _nodes(blocks, run_before, low, high, low_run, n, n0, patch0, touched, node):
    """What each element is joined as: the patch of which nothing is lost, or alone, from there on.

    Returns how many numbers are in use.
    """
    count, end = touched.shape[0], low
    for b in range(blocks.shape[0] + 1):
        begin = blocks[b, FIRST_NOW] if b < blocks.shape[0] else high
        for i in range(end, begin):
            node[i] = count
            count += 1
        if b == blocks.shape[0]:
            break
        end = begin + blocks[b, COUNT]
        for i in range(begin, end):
            node[i] = patch0[blocks[b, FIRST0] + i - begin]
            if touched[node[i]]:
                node[i] = count
                count += 1
    for k in range(run_before.shape[0]):
        at = n + low_run + k
        node[at] = patch0[n0 + run_before[k]] if run_before[k] >= 0 else 0
        if run_before[k] < 0 or touched[node[at]]:
            node[at] = count
            count += 1
    return count


@scalar
def _join_across(surface, ring, link, halves, node, parent, k):
    """Join what lies on both sides of an edge, by its last half-edge; True if it is a curve."""
    i, j = halves[k] // 3, ring[k]
    if j == k:
        if link[k] >= 0:
            join(parent, node[i], node[surface.shape[0] + link[k]])
        return False
    if ring[j] != k or surface[i] != surface[halves[j] // 3]:
        return True
    one, other = node[i], node[halves[j] // 3]
    if parent[one] != parent[other]:  # a third of them are
        join(parent, one, other)
    return False


@scalar
def _join_inside(blocks, after, ring0, surface, halves, n_patch0, node, parent):
    """Join triangles that stay, of patches that have lost something, over edges that stay."""
    at = 0
    for b in range(blocks.shape[0]):
        for k in range(blocks[b, COUNT]):
            i, i0 = blocks[b, FIRST_NOW] + k, blocks[b, FIRST0] + k
            if node[i] < n_patch0:
                continue
            for c in range(3):
                j0 = ring0[3 * i0 + c]
                if j0 >= 3 * i0 + c or ring0[j0] != 3 * i0 + c:
                    continue  # alone, or not the last of two
                while at < halves.shape[0] and halves[at] < 3 * i + c:
                    at += 1
                if at < halves.shape[0] and halves[at] == 3 * i + c:
                    continue
                j = after[j0 // 3]
                if surface[i] == surface[j] and parent[node[i]] != parent[node[j]]:
                    join(parent, node[i], node[j])


@scalar
def _alone(parent, touched, numbers):
    """Number of each earlier patch that has lost nothing, and is a set of its own; or -1."""
    n_patch = touched.shape[0]
    size = np.zeros(n_patch, dtype=np.int64)
    for k in range(parent.shape[0]):
        root = find(parent, k)
        if root < n_patch:  # the lowest of its set
            size[root] += 1
    out = np.full(n_patch, -1, dtype=np.int64)
    for p in range(n_patch):
        if not touched[p] and size[p] == 1:
            out[p] = numbers[p]
    return out


@entry("l1 l2 l1 l1 l2 l1 l1 l l1 l1 l1 l1 l1 l1 l1 l2 l1 l1 l1 -> l l1 l1")
def carry_patches(
    place, blocks, after, ring0, linked, run_before, run_after, n_patch0, patch0, surface, key,
    ring, link, halves, rim0, joined, lowest, first_run, node,
):  # fmt: skip
    """Write the patch of each element of some surfaces, as `number_patches` gives them, from 0 on.

    Patches end where surfaces do, so each thread has surfaces of its own. No two triangles
    coincide. Elements of a patch that has lost nothing are not joined again: what is new beside
    them has its edges among `halves`, of which `ring` and `link` have one row each. `rim0` and
    `linked` are half-edges that are taken over.

    Parameters
    ----------
    place : int64 (12,)
        First and last + 1 of the surfaces, triangles, runs, earlier triangles, earlier runs and
        `halves`; `blocks` and `rim0` are those of the triangles, other arrays have all of them.
    node : int64 (n_element,)
        Written: the patches.

    Returns
    -------
    How many patches there are, the last half-edges of the edges between patches, and the patch that
    each earlier one is, or -1 if it lost or gained something, or is of other surfaces.
    """
    low_surface, high_surface, low, high, low_run, high_run = place[:6]
    low0, high0, low_run0, high_run0, low_half, high_half = place[6:]
    n, n0 = surface.shape[0], after.shape[0]
    lost = run_after[low_run0:high_run0]
    touched = _left(blocks, lost, low0, high0, low_run0, n0, patch0, n_patch0)
    known = run_before[low_run:high_run]
    parent = np.arange(_nodes(blocks, known, low, high, low_run, n, n0, patch0, touched, node))

    # triangles that stay of a patch that has lost something: edges inside, and runs beside them
    mine = halves[low_half:high_half]
    _join_inside(blocks, after, ring0, surface, mine, n_patch0, node, parent)
    for k in range(linked.shape[0]):
        i = linked[k, 0] // 3
        if low <= i < high and node[i] >= n_patch0:
            join(parent, node[i], node[n + linked[k, 1]])

    # then what is new; rings rise: the last half-edge of an edge leads back to the first one
    rim = np.empty(rim0.shape[0] + mine.shape[0], dtype=np.int64)
    n_rim = at = 0
    for k in range(low_half, high_half):
        h = halves[k]
        if ring[k] <= k and _join_across(surface, ring, link, halves, node, parent, k):
            while at < rim0.shape[0] and rim0[at] < h:
                rim[n_rim] = rim0[at]
                n_rim, at = n_rim + 1, at + 1
            rim[n_rim] = h
            n_rim += 1
    for k in range(at, rim0.shape[0]):
        rim[n_rim] = rim0[k]
        n_rim += 1
    for k in range(joined.shape[0]):
        if low_run <= joined[k, 0] < high_run:
            join(parent, node[n + joined[k, 0]], node[n + joined[k, 1]])
    numbers, count = number_in_order(
        parent, node, surface, key, lowest, first_run, low_surface, high_surface, low
    )
    return count, rim[:n_rim].copy(), _alone(parent, touched, numbers)


@entry("l1 l l l -> .")
def shift_patches(patch, low, high, by):
    """Add to the patches of some elements how many are before theirs."""
    for i in range(low, high):
        patch[i] += by
