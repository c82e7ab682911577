"""Landings: from the middle of a pair of cells onto a curve of two lattices, or nowhere.

Newton's method starts in the middle of every pair of cells that bounds leave over (`near`) and
that is transverse (`cover`: no closed curve lies inside). Landings are kept in the order of the
cells of the first lattice, so that a walk finds those beside it.

Letters as in `lift`; k rows (8,) of landings: parameters, point, and whether a walk has passed
(1), or nothing is there (2).
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels._jit import scalar
from geosurf.kernels.arcs import from_arc
from geosurf.kernels.cover import are_transverse, round_cone
from geosurf.kernels.lift import ASTRAY, F_POINT, LIFTED, meet_to

OPEN, PASSED, NOWHERE = 0.0, 1.0, 2.0
_BULGE = 0.25  # [cells]: how far an arc leaves the range of its ends


@scalar
def cell_of(z, u, v):
    """Number of the cell that holds parameters."""
    n_col = z.shape[1] - 1
    j = min(max(math.floor(u), 0), n_col - 1)
    return min(max(math.floor(v), 0), z.shape[0] - 2) * n_col + j


@scalar
def _land(xa, ya, za, xb, yb, zb, c, net, cell_a, cell_b, enough, f, land):
    """Newton from the middle of a pair of cells."""
    w = land[:4]
    n_col = za.shape[1] - 1
    w[0], w[1] = cell_a % n_col + 0.5, cell_a // n_col + 0.5
    n_col = zb.shape[1] - 1
    w[2], w[3] = cell_b % n_col + 0.5, cell_b // n_col + 0.5
    x = 0.25 * (net[0, 0, 0] + net[3, 0, 0] + net[0, 3, 0] + net[3, 3, 0])
    y = 0.25 * (net[0, 0, 1] + net[3, 0, 1] + net[0, 3, 1] + net[3, 3, 1])
    z = 0.25 * (net[0, 0, 2] + net[3, 0, 2] + net[0, 3, 2] + net[3, 3, 2])
    found = meet_to(xa, ya, za, xb, yb, zb, c, 0, w, x, y, z, 0.0, 0.0, 0.0, enough, f)
    land[4], land[5], land[6] = f[F_POINT], f[F_POINT + 1], f[F_POINT + 2]
    return found


@scalar
def _cone_once(cones, nets, k):
    """The cone of a net, made when it is first asked for."""
    if math.isnan(cones[k, 3]):
        cones[k, 0], cones[k, 1], cones[k, 2], cones[k, 3] = round_cone(nets[k])


@scalar
def land_all(xa, ya, za, xb, yb, zb, c, pairs, cell_a, cell_b, nets_a, nets_b, enough, f):
    """Land in all pairs: rows, cells of a where they are (-1: no landing)."""
    n_pair = pairs.shape[0]
    land, cells = np.empty((n_pair, 8)), np.empty(n_pair, dtype=np.int64)
    cones_a, cones_b = np.full((len(cell_a), 4), np.nan), np.full((len(cell_b), 4), np.nan)
    for k in range(n_pair):
        a, b = pairs[k]
        _cone_once(cones_a, nets_a, a)
        _cone_once(cones_b, nets_b, b)
        found = ASTRAY
        if are_transverse(nets_a[a], cones_a[a], nets_b[b], cones_b[b]):
            found = _land(
                xa, ya, za, xb, yb, zb, c, nets_a[a], cell_a[a], cell_b[b], enough, f, land[k]
            )
        cells[k] = cell_of(za, land[k, 0], land[k, 1]) if found == LIFTED else -1
        land[k, 7] = OPEN if found == LIFTED else NOWHERE
    return land, cells


@scalar
def pass_by(za, one, two, reach, f, cells, order, land):
    """Mark the landings that lie within reach [m] of an arc of a walk."""
    n_row, n_col = za.shape[0] - 1, za.shape[1] - 1
    more = _BULGE + reach / math.sqrt(f[3] * f[3] + f[4] * f[4] + f[5] * f[5])
    j0 = max(math.floor(min(one[3], two[3]) - more), 0)
    j1 = min(math.floor(max(one[3], two[3]) + more), n_col - 1)
    more = _BULGE + reach / math.sqrt(f[6] * f[6] + f[7] * f[7] + f[8] * f[8])
    i0 = max(math.floor(min(one[4], two[4]) - more), 0)
    i1 = min(math.floor(max(one[4], two[4]) + more), n_row - 1)
    for i in range(i0, i1 + 1):
        k = np.searchsorted(cells, i * n_col + j0)
        while k < cells.shape[0] and cells[k] <= i * n_col + j1:
            q = land[order[k]]
            if q[7] == OPEN and from_arc(one, two, q[4], q[5], q[6]) <= reach * reach:
                q[7] = PASSED
            k += 1
