"""Landings: from the middle of a pair of cells onto a curve of two lattices, or nowhere.

Newton's method starts in the middle of a pair of cells that bounds leave over (`near`), that is
transverse (`cover`: no closed curve lies inside), and that no walk runs through. In a transverse
pair a plane across meets the surfaces once at most, so a curve beside a walk has pairs of its own.

Letters as in `lift` and `arcs`; keys of pairs of cells as in `cover`.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels._jit import scalar
from geosurf.kernels.arcs import K_LENGTH, from_arc, on_arc
from geosurf.kernels.cover import are_transverse, key_of, round_cone
from geosurf.kernels.lift import F_POINT, meet_to

NOT_PASSED, LEFT = -1, -2  # in place of the knot where a walk has passed; LEFT: to be split
_PLACES = 6  # of an arc, at which is looked which pair of cells it runs through


@scalar
def _cone_once(cones, nets, k):
    """The cone of a net, made when it is first asked for."""
    if math.isnan(cones[k, 3]):
        cones[k, 0], cones[k, 1], cones[k, 2], cones[k, 3] = round_cone(nets[k])


@scalar
def open_pairs(pairs, cell_a, cell_b, nets_a, nets_b):
    """Sorted keys of pairs, their order; NOT_PASSED for each pair, LEFT if not transverse."""
    n_pair = pairs.shape[0]
    keys, knot_of = np.empty(n_pair, dtype=np.int64), np.empty(n_pair, dtype=np.int64)
    cones_a, cones_b = np.full((len(cell_a), 4), np.nan), np.full((len(cell_b), 4), np.nan)
    for k in range(n_pair):
        a, b = pairs[k, 0], pairs[k, 1]
        _cone_once(cones_a, nets_a, a)
        _cone_once(cones_b, nets_b, b)
        clear = are_transverse(nets_a[a], cones_a[a], nets_b[b], cones_b[b])
        knot_of[k] = NOT_PASSED if clear else LEFT
        keys[k] = cell_a[a] * (1 << 31) + cell_b[b]
    order = np.argsort(keys)
    return keys[order], order, knot_of


@scalar
def land(xa, ya, za, xb, yb, zb, c, net, cell_a, cell_b, enough, seed, f):
    """Newton from the middle of a pair of cells: point and parameters into `seed` (7,)."""
    n_col = za.shape[1] - 1
    seed[3], seed[4] = cell_a % n_col + 0.5, cell_a // n_col + 0.5
    n_col = zb.shape[1] - 1
    seed[5], seed[6] = cell_b % n_col + 0.5, cell_b // n_col + 0.5
    for k in range(3):
        seed[k] = 0.25 * (net[0, 0, k] + net[3, 0, k] + net[0, 3, k] + net[3, 3, k])
    x, y, z = seed[0], seed[1], seed[2]
    found = meet_to(xa, ya, za, xb, yb, zb, c, 0, seed[3:7], x, y, z, 0.0, 0.0, 0.0, enough, f)
    for k in range(3):
        seed[k] = f[F_POINT + k]
    return found


@scalar
def _place_of(keys, order, key):
    """Row of the pair with a key; -1: none."""
    k = np.searchsorted(keys, key)
    return order[k] if k < keys.shape[0] and keys[k] == key else -1


@scalar
def pass_through(za, zb, knots, first, n, keys, order, knot_of, row):
    """Tell the pairs of cells that knots first to n run through at which knot an arc does."""
    for i in range(first + 1, n):
        for place in range(_PLACES):
            on_arc(knots[i - 1], knots[i], place / _PLACES, row)
            k = _place_of(keys, order, key_of(za, zb, row[3:7], 0))
            if k >= 0 and knot_of[k] == NOT_PASSED:
                knot_of[k] = i


@scalar
def is_beside(za, zb, knots, n, seed, reach, keys, order, knot_of):
    """Whether a landing lies within reach [m] of an arc: that in its own pair of cells, or any."""
    x, y, z = seed[0], seed[1], seed[2]
    k = _place_of(keys, order, key_of(za, zb, seed[3:7], 0))
    if k >= 0 and knot_of[k] >= 0:
        i = knot_of[k]
        if from_arc(knots[i - 1], knots[i], x, y, z) <= reach * reach:
            return True
    for i in range(1, n):
        size = knots[i, K_LENGTH] + reach
        dx, dy, dz = x - knots[i, 0], y - knots[i, 1], z - knots[i, 2]
        if knots[i, K_LENGTH] < 0.0 or dx * dx + dy * dy + dz * dz > size * size:
            continue
        if from_arc(knots[i - 1], knots[i], x, y, z) <= reach * reach:
            return True
    return False
