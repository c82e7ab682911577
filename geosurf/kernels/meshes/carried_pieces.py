"""Pieces of an arrangement, as far as an earlier one has them: edges and patches are carried over.

Triangles of faces that are cut alike are the same in both, in the same order. Around an edge of
which all triangles are in both, nothing changes. The other edges are matched again, and patches
that lose or gain something are joined again.

Triangles keep their order, and what is new lies together along the curves of what has moved. So
the triangles that stay are a few hundred blocks, in each of which numbers grow by the same.

Letters as in `mesh` and `parts`; a 0 marks what is of the earlier pieces, and
    before   for each run the earlier one that it is, or -1
    after    for each earlier triangle (run) the one that it is now, or -1
    blocks   rows (n, 3): first earlier triangle, the triangle that it is now, how many follow
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.strips import FIRST, LAST
from geosurf.kernels.meshes.merged_pieces import number_in_order
from geosurf.kernels.meshes.mesh import find, join

_FREE, _PAIRED = -1, -2  # of `link`
FIRST0, FIRST_NOW, COUNT = 0, 1, 2  # of `blocks`


@scalar
def _longer(rows):
    """The same rows, with room for as many more."""
    found = np.empty((2 * rows.shape[0], rows.shape[1]), dtype=np.int64)
    found[: rows.shape[0]] = rows
    return found


@entry("l1 l1 l1 l1 l1 l1 l1 l1 b1 l l l l l1 -> l2")
def same_triangles(
    new_surface, surface0, key0, face0, surface, key, face, new_face, changed, i, n0, j, n, after
):  # fmt: skip
    """`blocks`, and `after` of triangles, by the faces that they are of: of some whole surfaces.

    These have the earlier triangles `i` to `n0` - 1, and `j` to `n` - 1 now. `new_surface` has the
    surfaces that earlier ones are now, or -1; `new_face` has the same of faces of contacts, and
    `changed` are faces that are cut again.
    """
    for k in range(i, n0):
        after[k] = -1
    blocks = np.empty((512, 3), dtype=np.int64)
    n_block = 0
    while j < n:
        s, k, f = surface[j], key[j], face[j]
        while i < n0:
            s0 = new_surface[surface0[i]]
            if s0 > s or (s0 == s and key0[i] >= k):
                break
            i += 1
        same = i < n0 and new_surface[surface0[i]] == s and key0[i] == k
        if same:
            same = face0[i] < 0 if f < 0 else face0[i] >= 0 and new_face[face0[i]] == f
            same = same and (f < 0 or not changed[f])
        low0, low = i, j
        while j < n and surface[j] == s and key[j] == k:
            if same:
                after[i] = j
                i += 1
            j += 1
        if not same:
            continue
        last = n_block - 1
        if (
            n_block > 0
            and blocks[last, FIRST0] + blocks[last, COUNT] == low0
            and blocks[last, FIRST_NOW] + blocks[last, COUNT] == low
        ):
            blocks[last, COUNT] += j - low
            continue
        if n_block == blocks.shape[0]:
            blocks = _longer(blocks)
        blocks[n_block, FIRST0], blocks[n_block, FIRST_NOW] = low0, low
        blocks[n_block, COUNT] = j - low
        n_block += 1
    return blocks[:n_block].copy()


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


@scalar
def _carry_block(
    ring0, link0, rim0, after, run_after, low, high, shift, ring, link, others, n_other, rim, at,
    n_rim,
):  # fmt: skip
    """The same for the half-edges of one block, earlier ones `low` to `high` - 1."""
    while at < rim0.shape[0] and rim0[at] < low:
        at += 1
    of_rim = rim0[at] if at < rim0.shape[0] else -1
    for g in range(low, high):
        h, j = g + shift, ring0[g]
        is_rim = g == of_rim
        if is_rim:
            at += 1
            of_rim = rim0[at] if at < rim0.shape[0] else -1
        if j != g and low <= j < high and ring0[j] == g:  # nearly all
            ring[h], link[h] = j + shift, _PAIRED
            if is_rim:
                rim[n_rim] = h
                n_rim += 1
            continue
        ring[h], link[h] = h, _FREE
        if j == g:
            # what is behind may be listed now
            run = link0[g]
            stays = run < 0 or run_after[run] >= 0
            if run >= 0 and stays:
                link[h] = run_after[run]
        else:
            stays = _all_stay(ring0, after, g)
            if stays:
                ring[h], link[h] = 3 * after[j // 3] + j % 3, _PAIRED
        if not stays:
            others[n_other] = h
            n_other += 1
        elif is_rim:
            rim[n_rim] = h
            n_rim += 1
    return n_other, at, n_rim


@entry("l2 l l l l l1 l1 l1 l1 l1 l1 l1 l1 -> l l1")
def carry_rings(
    blocks, of, until, end, n, others, after, ring0, link0, rim0, run_after, ring, link
):  # fmt: skip
    """Write rings and links of half-edges that are carried over; others are alone yet.

    Of the blocks `of` to `until` - 1, and of the new triangles around them: `end` to `n` - 1 in
    all. Writes these others, and returns how many they are; and those of the last half-edges
    `rim0` of which all triangles stay, where they are now. All rise.

    `run_after` tells which earlier run is which run now, over all lattices.
    """
    low = 3 * blocks[of, FIRST0] if of < until else 0
    at = n_rim = n_other = 0
    if of < until:
        at = int(np.searchsorted(rim0, low))
    rim = np.empty(rim0.shape[0] - at, dtype=np.int64)
    for b in range(of, until + 1):
        # new triangles between blocks
        begin = blocks[b, FIRST_NOW] if b < until else n
        for h in range(3 * end, 3 * begin):
            ring[h], link[h] = h, _FREE
            others[n_other] = h
            n_other += 1
        if b == until:
            break
        end = begin + blocks[b, COUNT]
        low = 3 * blocks[b, FIRST0]
        n_other, at, n_rim = _carry_block(
            ring0, link0, rim0, after, run_after, low, low + 3 * blocks[b, COUNT], 3 * begin - low,
            ring, link, others, n_other, rim, at, n_rim,
        )  # fmt: skip
    return n_other, rim[:n_rim].copy()


@scalar
def _left(blocks, run_after, n0, patch0, n_patch0):
    """Earlier patches that have lost a triangle or a run."""
    touched = np.zeros(n_patch0, dtype=np.bool_)
    end = 0
    for b in range(blocks.shape[0] + 1):
        begin = blocks[b, FIRST0] if b < blocks.shape[0] else n0
        for i in range(end, begin):
            touched[patch0[i]] = True
        if b < blocks.shape[0]:
            end = begin + blocks[b, COUNT]
    for i in range(run_after.shape[0]):
        if run_after[i] < 0:
            touched[patch0[n0 + i]] = True
    return touched


@scalar
def _nodes(blocks, run_before, n0, patch0, touched, n, node):
    """What each element is joined as: the patch of which nothing is lost, or alone, from there on.

    Returns how many numbers are in use.
    """
    count, end = touched.shape[0], 0
    for b in range(blocks.shape[0] + 1):
        begin = blocks[b, FIRST_NOW] if b < blocks.shape[0] else n
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
    for i in range(run_before.shape[0]):
        node[n + i] = patch0[n0 + run_before[i]] if run_before[i] >= 0 else 0
        if run_before[i] < 0 or touched[node[n + i]]:
            node[n + i] = count
            count += 1
    return count


@scalar
def _join_across(surface, ring, link, node, parent, h):
    """Join what lies on both sides of an edge, by its last half-edge; True if it is a curve."""
    i, j = h // 3, ring[h]
    if j == h:
        if link[h] >= 0:
            join(parent, node[i], node[surface.shape[0] + link[h]])
        return False
    if ring[j] != h or surface[i] != surface[j // 3]:
        return True
    one, other = node[i], node[j // 3]
    if parent[one] != parent[other]:  # a third of them are
        join(parent, one, other)
    return False


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


@entry("l2 l l1 l1 l l1 l1 l1 l1 l1 l1 l1 l2 l1 l1 -> l1 l1 l1")
def carry_patches(
    blocks, n0, run_before, run_after, n_patch0, patch0, surface, key, ring, link, halves, rim0,
    joined, lowest, first_run,
):  # fmt: skip
    """Patch of each element, as `number_patches` gives them, the last half-edges of the edges
    between patches, and the patch that each earlier one is, or -1 if it lost or gained something.

    No two triangles coincide. Elements of a patch that has lost nothing are not joined again:
    what is new beside them has its edges among `halves`. `rim0` are last half-edges that are taken
    over, of n0 earlier triangles.
    """
    n, n_run = surface.shape[0], run_before.shape[0]
    touched = _left(blocks, run_after, n0, patch0, n_patch0)
    node = np.empty(n + n_run, dtype=np.int64)
    parent = np.arange(_nodes(blocks, run_before, n0, patch0, touched, n, node))

    # triangles that stay of a patch that has lost something: edges inside, and runs beside them
    for b in range(blocks.shape[0]):
        begin = blocks[b, FIRST_NOW]
        for i in range(begin, begin + blocks[b, COUNT]):
            if node[i] < n_patch0:
                continue
            for c in range(3):
                if ring[3 * i + c] <= 3 * i + c:
                    _join_across(surface, ring, link, node, parent, 3 * i + c)

    # then what is new; rings rise: the last half-edge of an edge leads back to the first one
    rim = np.empty(rim0.shape[0] + halves.shape[0], dtype=np.int64)
    n_rim = at = 0
    for k in range(halves.shape[0]):
        h = halves[k]
        if ring[h] <= h and _join_across(surface, ring, link, node, parent, h):
            while at < rim0.shape[0] and rim0[at] < h:
                rim[n_rim] = rim0[at]
                n_rim, at = n_rim + 1, at + 1
            rim[n_rim] = h
            n_rim += 1
    for k in range(at, rim0.shape[0]):
        rim[n_rim] = rim0[k]
        n_rim += 1
    for k in range(joined.shape[0]):
        join(parent, node[n + joined[k, 0]], node[n + joined[k, 1]])
    numbers = number_in_order(parent, node, surface, key, lowest, first_run)
    return node, rim[:n_rim].copy(), _alone(parent, touched, numbers)
