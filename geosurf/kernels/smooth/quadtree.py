"""Blocks of cells, their quarters, and triangles: in which box and which slab they lie.

Letters as in `patch_pyramid`; s facts (11,) of a block, quarter or cell: box, normal, least and
largest height along it; side (x, y, z, c, bends): one of two surfaces, c its triangles (n, 3, 3)
if z has one row.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.smooth.cubic_patch import node, unit_cross
from geosurf.kernels.smooth.patch_pyramid import BLOCK, SLACK, box_of, span_along

HALF = BLOCK // 2
PARTS = 5  # a block and its quarters
N_FACT = 11


@scalar
def cells_of(z, block, part):
    """First and last row and column of the cells of a block (part 0) or a quarter; maybe none."""
    n_row, n_col = z.shape[0] - 1, z.shape[1] - 1
    across = (n_col + BLOCK - 1) // BLOCK

    # First cell of the block; quarters are numbered row by row.
    r0, c0, size = block // across * BLOCK, block % across * BLOCK, BLOCK
    if part > 0:
        size = HALF
        r0 += (part - 1) // 2 * HALF
        c0 += (part - 1) % 2 * HALF
    return r0, min(r0 + size, n_row), c0, min(c0 + size, n_col)


@scalar
def _span(side, block, part, p, q, r):
    """Bounds of p x + q y + r z over a part of a block, or a triangle."""
    x, y, z, c, bends = side
    if z.shape[0] > 1:
        r0, r1, c0, c1 = cells_of(z, block, part)
        return span_along(x, y, z, bends[block], r0, r1, c0, c1, p, q, r)
    low, high = np.inf, -np.inf

    # A triangle: its three corners.
    for k in range(3):
        value = p * c[block, k, 0] + q * c[block, k, 1] + r * c[block, k, 2]
        low, high = min(low, value - SLACK), max(high, value + SLACK)
    return low, high


@scalar
def _normal_of(side, block, part):
    """Unit normal from the diagonals of a part, or of a triangle; NaN if there is none."""
    x, y, z, c, _ = side
    if z.shape[0] == 1:
        t = c[block]
        return unit_cross(
            t[1, 0] - t[0, 0], t[1, 1] - t[0, 1], t[1, 2] - t[0, 2],
            t[2, 0] - t[0, 0], t[2, 1] - t[0, 1], t[2, 2] - t[0, 2],
        )  # fmt: skip

    # Diagonals of the four outermost nodes.
    r0, r1, c0, c1 = cells_of(z, block, part)
    return unit_cross(
        node(x, r1, c1) - node(x, r0, c0), node(y, r1, c1) - node(y, r0, c0), z[r1, c1] - z[r0, c0],
        node(x, r1, c0) - node(x, r0, c1), node(y, r1, c0) - node(y, r0, c1), z[r1, c0] - z[r0, c1],
    )  # fmt: skip


@scalar
def _describe(side, block, part, s):
    """Facts of a part; its box is empty if it has no cells, or is a whole block."""
    x, y, z, c, bends = side

    # Empty until proven otherwise.
    for k in range(3):
        s[k], s[3 + k], s[6 + k] = np.inf, -np.inf, np.nan

    # A triangle has one part with a box.
    if z.shape[0] == 1:
        if part > 1:
            return
        if part == 1:
            for k in range(3):
                s[k] = min(c[block, 0, k], c[block, 1, k], c[block, 2, k]) - SLACK
                s[3 + k] = max(c[block, 0, k], c[block, 1, k], c[block, 2, k]) + SLACK
    else:
        r0, r1, c0, c1 = cells_of(z, block, part)
        # At the upper boundaries a quarter may lie outside of the lattice.
        if r0 >= r1 or c0 >= c1:
            return
        if part > 0:
            box_of(x, y, z, bends[block], r0, r1, c0, c1, s)

    # The slab along the own normal.
    s[6], s[7], s[8] = _normal_of(side, block, part)
    if math.isfinite(s[6]):
        s[9], s[10] = _span(side, block, part, s[6], s[7], s[8])


@scalar
def describe_to(side, block, wanted, known, s, place):
    """Compute the facts of the first parts of a block that are not known; updates `known`."""
    # Parts are described in order: the block, then its quarters.
    for part in range(known[place], wanted):
        _describe(side, block, part, s[place * PARTS + part])
    known[place] = max(known[place], wanted)


@scalar
def outside_slab(side, block, part, slab):
    """Whether a part lies outside the slab of another one."""
    if not math.isfinite(slab[6]):
        return False
    low, high = _span(side, block, part, slab[6], slab[7], slab[8])
    return low > slab[10] or high < slab[9]


@scalar
def boxes_disjoint(s, t):
    """Whether two boxes are disjoint; an empty or undefined one is disjoint from all."""
    return not (
        s[0] <= t[3] and t[0] <= s[3]
        and s[1] <= t[4] and t[1] <= s[4]
        and s[2] <= t[5] and t[2] <= s[5]
    )  # fmt: skip
