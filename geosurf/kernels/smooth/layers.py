"""Whether the cubics of one lattice are above those of another with the same nodes in the map.

On one map the difference of two cubics is the cubic of the differences of their nodes: weights are
the same. Weights of four nodes along one direction have absolute values that add up to 1.25 at
most, and to 1.632 in cells at a rim; so a cubic leaves the range of its 4 x 4 nodes by at most 0.83
of that range, ``(1.632^2 - 1) / 2``. Where differences stay away from zero by more than this, block
by block, the surfaces have no point in common. Triangles lie between their nodes, too.

That reads each node once. Boxes of blocks exclude less: relief makes them high, while the distance
of two layers changes little.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.smooth.patch_pyramid import SLACK

BLOCK = 16  # cells of a block along both directions
# nodes around a block in stencils of its cells; where a block at a rim has one cell, the stencil of
# that reaches two, which are in the block before with those around it
_REACH = 1
_BEYOND = 0.5 * (1.632 * 1.632 - 1.0)


@scalar
def _add_row(one, two, n, low, high):
    """Extend the extremes of differences by column with one row."""
    for j in range(n):  # selections without branches are vectorised
        off = one[j] - two[j]
        low[j] = off if off < low[j] else low[j]
        high[j] = off if off > high[j] else high[j]


@entry("d2 d2 -> l")
def surely_apart(one, two):
    """1 if cubics and triangles over elevations of two whole lattices do not meet, 0 if unknown."""
    n_row, n_col = one.shape
    low, high = np.empty(n_col), np.empty(n_col)
    for i in range(0, n_row - 1, BLOCK):
        low[:], high[:] = np.inf, -np.inf
        for row in range(max(i - _REACH, 0), min(i + BLOCK + _REACH + 1, n_row)):
            _add_row(one[row], two[row], n_col, low, high)
        for j in range(0, n_col - 1, BLOCK):
            least, most = np.inf, -np.inf
            for col in range(max(j - _REACH, 0), min(j + BLOCK + _REACH + 1, n_col)):
                least, most = min(least, low[col]), max(most, high[col])
            beyond = _BEYOND * (most - least) + SLACK
            # comparisons with not-a-number are false
            if not (least > beyond or most < -beyond):
                return 0
    return 1
