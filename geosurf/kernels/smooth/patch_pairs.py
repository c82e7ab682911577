"""Pairs of patches that may meet, from pairs of blocks whose boxes overlap.

A block of 8 x 8 cells, each quarter of it and each cell lies in its box and in a slab across its
own diagonals. Blocks are compared by slabs, quarters by boxes and slabs, then cells: with the other
quarter, then with each other. A cell is evaluated once and stored as a row of a table: a patch.

Letters as in `patch_pyramid` and `quadtree`, and
    m         a patch (N_PATCH,): the facts of a cell, deviation of its cubic from the bilinear
    patch
              of its corners (x, y, z), those four corners, column by column, then row by row
    cache     (facts, known, rows, patches, marks, count) of one side, its blocks numbered by first
              use: facts of their parts and the number known, rows of their cells in the table of
              patches (-1: none), that table, the cell of each, their number
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.smooth.cubic_patch import node, unit_cross
from geosurf.kernels.smooth.patch_pyramid import BLOCK, SLACK, block_pairs, bulge, is_present
from geosurf.kernels.smooth.quadtree import (
    HALF,
    N_FACT,
    PARTS,
    boxes_disjoint,
    cells_of,
    describe_to,
    outside_slab,
)

M_BULGE = N_FACT
M_CORNER = M_BULGE + 3
N_PATCH = M_CORNER + 12
_MOST_PAIRS = BLOCK**4  # of patches of two blocks
_PAIRS = np.array([(i, j) for i in range(1, PARTS) for j in range(1, PARTS)])  # of quarters


# ---- patches -----------------------------------------------------------------------------


@scalar
def _shadow(m, p, q, r):
    """Bounds of p x + q y + r z over a patch; reversed if it has no corner."""
    low, high = np.inf, -np.inf
    for k in range(M_CORNER, N_PATCH, 3):
        value = p * m[k] + q * m[k + 1] + r * m[k + 2]
        # comparisons with NaN are false, so a missing corner changes nothing
        if value < low:
            low = value
        if value > high:
            high = value
    more = abs(p) * m[M_BULGE] + abs(q) * m[M_BULGE + 1] + abs(r) * m[M_BULGE + 2] + SLACK
    return low - more, high + more


@scalar
def _outside(m, slab):
    """Whether a patch is outside of a slab."""
    # No normal, no slab: nothing is excluded.
    if not math.isfinite(slab[6]):
        return False
    low, high = _shadow(m, slab[6], slab[7], slab[8])
    return low > slab[10] or slab[9] > high


@scalar
def _describe(m):
    """Box and slab of a patch with corners."""
    for axis in range(3):
        # Box, widened by the deviation of the cubic.
        low, high = np.inf, -np.inf
        for k in range(M_CORNER + axis, N_PATCH, 3):
            if m[k] < low:
                low = m[k]
            if m[k] > high:
                high = m[k]
        more = m[M_BULGE + axis] + SLACK
        m[axis], m[3 + axis] = low - more, high + more

    # Slab across the diagonals.
    a, b, c, d = M_CORNER, M_CORNER + 3, M_CORNER + 6, M_CORNER + 9
    m[6], m[7], m[8] = unit_cross(
        m[d] - m[a], m[d + 1] - m[a + 1], m[d + 2] - m[a + 2],
        m[c] - m[b], m[c + 1] - m[b + 1], m[c + 2] - m[b + 2],
    )  # fmt: skip
    m[9], m[10] = _shadow(m, m[6], m[7], m[8])


@scalar
def _make_patch(side, block, i, j, m):
    """Write cell (i, j) of a block, or a triangle, as a patch; its number."""
    x, y, z, c, bends = side
    if z.shape[0] == 1:
        # A triangle is a patch with three corners.
        for k in range(4):  # the last corner twice
            for axis in range(3):
                m[M_CORNER + 3 * k + axis] = c[block, min(k, 2), axis]
                m[M_BULGE + axis] = 0.0
        _describe(m)
        return block
    for k in range(4):
        # Four corners; NaN in any coordinate removes the corner.
        row, col, at = i + k // 2, j + k % 2, M_CORNER + 3 * k
        m[at], m[at + 1], m[at + 2] = node(x, row, col), node(y, row, col), z[row, col]
        if not math.isfinite(m[at] + m[at + 1] + m[at + 2]):
            m[at], m[at + 1], m[at + 2] = np.nan, np.nan, np.nan
    # The cubic leaves the bilinear patch of its corners by at most this.
    more = bulge(z, i, i + 1, j, j + 1)
    for axis in range(3):
        m[M_BULGE + axis] = more * bends[block, axis]
    _describe(m)
    return i * (z.shape[1] - 1) + j


@scalar
def _is_whole(x, y, z, cell):
    """1 if the stencil of a cell has 16 nodes, or for a triangle; else 0."""
    if z.shape[0] == 1:
        return 1
    i, j = cell // (z.shape[1] - 1), cell % (z.shape[1] - 1)

    # First node of the stencil, shifted inwards at the boundary.
    i, j = min(max(i - 1, 0), z.shape[0] - 4), min(max(j - 1, 0), z.shape[1] - 4)
    for row in range(i, i + 4):
        for col in range(j, j + 4):
            if not is_present(x, y, z, row, col):
                return 0
    return 1


@scalar
def _heights(side, r0, r1, c0, c1, s, heights):
    """Write the heights of the nodes of a quarter along the normal of a slab s."""
    x, y, z, _, _ = side
    for i in range(r0, r1 + 1):
        for j in range(c0, c1 + 1):
            value = s[6] * node(x, i, j) + s[7] * node(y, i, j) + s[8] * z[i, j]
            heights[i - r0, j - c0] = value


@scalar
def _cell_outside(heights, i, j, more, s):
    """Whether cell (i, j) of a quarter, thicker by `more`, is outside of a slab s."""
    low, high = np.inf, -np.inf
    for k in range(2):
        for col in range(2):
            # Extremes of four corners against the slab.
            value = heights[i + k, j + col]
            if value < low:
                low = value
            if value > high:
                high = value
    return low - more > s[10] or high + more < s[9]


@scalar
def _patches_in(side, block, part, s, cache, place, out, heights):
    """Write rows of the patches of a part that are near a part s of the other side; their number.

    Missing patches are computed.
    """
    z, bends = side[2], side[4]
    _, _, rows, patches, marks, n = cache
    count = 0
    r0, r1, c0, c1 = 0, 1, 0, 1
    lattice = z.shape[0] > 1
    # Without a slab only boxes exclude.
    sloping, bend = lattice and math.isfinite(s[6]), 0.0
    if lattice:
        r0, r1, c0, c1 = cells_of(z, block, part)
    if sloping:
        _heights(side, r0, r1, c0, c1, s, heights)
        for axis in range(3):
            bend += abs(s[6 + axis]) * bends[block, axis]
    for i in range(r0, r1):
        for j in range(c0, c1):
            # Number of the cell in its block; a triangle has one.
            at = i % BLOCK * BLOCK + j % BLOCK if lattice else 0

            # Not cached: exclude it by its four nodes before computing the patch.
            if rows[place, at] < 0:
                if sloping:
                    more = bulge(z, i, i + 1, j, j + 1) * bend + SLACK
                    if _cell_outside(heights, i - r0, j - c0, more, s):
                        continue
                marks[n[0]] = _make_patch(side, block, i, j, patches[n[0]])
                rows[place, at] = n[0]
                n[0] += 1
            k = rows[place, at]
            if not boxes_disjoint(patches[k], s) and not _outside(patches[k], s):
                out[count] = k
                count += 1
    return count


@scalar
def _meet_patches(rows_a, n_a, patches_a, rows_b, n_b, patches_b, out, n):
    """Append the pairs of some patches of a with some of b that are not apart."""
    # Sixteen cells by sixteen at most, so all pairs.
    for e in range(n_a):
        a = patches_a[rows_a[e]]
        for g in range(n_b):
            b = patches_b[rows_b[g]]
            if not (boxes_disjoint(a, b) or _outside(a, b) or _outside(b, a)):
                out[n, 0], out[n, 1] = rows_a[e], rows_b[g]
                n += 1
    return n


# ---- all pairs ---------------------------------------------------------------------------


@scalar
def _numbered(pairs, side, n_block):
    """Number of each block among those in use (-1: none), and their count."""
    places, count = np.full(n_block, -1, dtype=np.int64), 0
    for k in range(pairs.shape[0]):
        if places[pairs[k, side]] < 0:
            places[pairs[k, side]] = count
            count += 1
    return places, count


@scalar
def _empty_cache(n_block, n_cell):
    """An empty cache for this many blocks of this many cells."""
    facts, known = np.empty((n_block * PARTS, N_FACT)), np.zeros(n_block, dtype=np.int64)
    rows, n = np.full((n_block, n_cell), -1, dtype=np.int64), n_block * n_cell
    # upper bound of the size: untouched memory costs nothing
    patches, marks = np.empty((n, N_PATCH)), np.empty(n, dtype=np.int64)
    return facts, known, rows, patches, marks, np.zeros(1, dtype=np.int64)


@scalar
def _renumber_used(side, cache, pairs, column):
    """Renumber one column of pairs by first use; cells, patches and `whole` of the rows in use."""
    x, y, z, _, _ = side
    _, _, _, patches, marks, n = cache

    # New numbers in order of first use.
    place, rows, count = np.full(n[0], -1, dtype=np.int64), np.empty(n[0], dtype=np.int64), 0
    for k in range(pairs.shape[0]):
        row = pairs[k, column]
        if place[row] < 0:
            place[row], rows[count] = count, row
            count += 1
        pairs[k, column] = place[row]
    names, found = np.empty(count, dtype=np.int64), np.empty((count, N_PATCH))
    flags = np.empty(count, dtype=np.int64)
    for k in range(count):
        found[k], names[k] = patches[rows[k]], marks[rows[k]]
        flags[k] = _is_whole(x, y, z, names[k])
    return names, found, flags


@scalar
def _largest_diagonal(patches):
    """Of the patches that have both ends of it [m]."""
    largest = 0.0
    for k in range(patches.shape[0]):
        size = 0.0
        for axis in range(3):
            # A missing corner makes the diagonal NaN, which no comparison takes.
            step = patches[k, M_CORNER + 9 + axis] - patches[k, M_CORNER + axis]
            size += step * step
        largest = size if size > largest else largest
    return math.sqrt(largest)


@scalar
def _all_set(flags):
    """1 if all flags are, else 0."""
    for k in range(flags.shape[0]):
        if flags[k] == 0:
            return 0
    return 1


@scalar
def _near_blocks(a, g, cache_a, u, b, h, cache_b, v):
    """Whether slabs do not separate two blocks; then their quarters are described."""
    facts_a, known_a, _, _, _, _ = cache_a
    facts_b, known_b, _, _, _, _ = cache_b
    # The slab of the whole block first: it excludes most pairs, and quarters cost more.
    describe_to(a, g, 1, known_a, facts_a, u)
    describe_to(b, h, 1, known_b, facts_b, v)
    if outside_slab(a, g, 0, facts_b[v * PARTS]) or outside_slab(b, h, 0, facts_a[u * PARTS]):
        return False
    describe_to(a, g, PARTS, known_a, facts_a, u)
    describe_to(b, h, PARTS, known_b, facts_b, v)
    return True


@scalar
def _meet_blocks(a, g, cache_a, u, b, h, cache_b, v, rows_a, rows_b, heights, out, n):
    """Append the pairs of patches of two blocks that are not apart, quarter by quarter."""
    for k in range(_PAIRS.shape[0]):
        i, j = _PAIRS[k, 0], _PAIRS[k, 1]

        # Facts of the two quarters exclude most of the 16 pairs.
        s, t = cache_a[0][u * PARTS + i], cache_b[0][v * PARTS + j]
        if boxes_disjoint(s, t) or outside_slab(a, g, i, t) or outside_slab(b, h, j, s):
            continue
        n_a = _patches_in(a, g, i, t, cache_a, u, rows_a, heights)
        n_b = _patches_in(b, h, j, s, cache_b, v, rows_b, heights)
        n = _meet_patches(rows_a, n_a, cache_a[3], rows_b, n_b, cache_b[3], out, n)
    return n


@scalar
def _with_capacity(out, n):
    """Pairs with capacity for all of two blocks, so that inner loops make no arrays."""
    if n + _MOST_PAIRS <= out.shape[0]:
        return out
    more = np.empty((2 * n + _MOST_PAIRS, 2), dtype=np.int64)
    more[:n] = out[:n]
    return more


@scalar
def near_patches(a, b, boxes, shape, items, planes):
    """Pairs of patches of two sides that are not separated, from the pyramid of a (`boxes`,
    `shape`) and the boxes and planes of the blocks of b (`block_pairs`).

    Returns cells, patches (n, N_PATCH) and `whole` (1: cubic or triangle; 0: lacks nodes) of both
    sides, pairs of rows of them, the largest diagonal of a patch of a [m], and whether all are
    whole. A block of b is a triangle where its z has one row.
    """
    # Pairs of blocks by boxes; everything else is computed on first use.
    pairs = block_pairs(boxes, shape, items, planes)
    # Only blocks in some pair get a place in the cache.
    of_a, na = _numbered(pairs, 0, shape[0, 1] * shape[0, 2])
    of_b, nb = _numbered(pairs, 1, items.shape[0])
    cache_a = _empty_cache(na, BLOCK * BLOCK)
    cache_b = _empty_cache(nb, BLOCK * BLOCK if b[2].shape[0] > 1 else 1)
    rows_a, rows_b = np.empty(HALF * HALF, dtype=np.int64), np.empty(HALF * HALF, dtype=np.int64)
    heights, n = np.empty((HALF + 1, HALF + 1)), 0
    out = np.empty((_MOST_PAIRS, 2), dtype=np.int64)
    for k in range(pairs.shape[0]):
        g, h = pairs[k, 0], pairs[k, 1]
        u, v = of_a[g], of_b[h]
        if _near_blocks(a, g, cache_a, u, b, h, cache_b, v):
            out = _with_capacity(out, n)
            n = _meet_blocks(a, g, cache_a, u, b, h, cache_b, v, rows_a, rows_b, heights, out, n)
    out = out[:n].copy()
    cells_a, patches_a, flags_a = _renumber_used(a, cache_a, out, 0)
    cells_b, patches_b, flags_b = _renumber_used(b, cache_b, out, 1)
    size, whole = _largest_diagonal(patches_a), min(_all_set(flags_a), _all_set(flags_b))
    return cells_a, cells_b, patches_a, patches_b, flags_a, flags_b, out, size, whole
