"""Seeds: from the middle of a pair of cells onto a curve of two lattices, by Newton's method.

Newton's method starts in the middle of a pair of cells that bounds do not exclude (`patch_pairs`),
that is transverse (`coverage`: no closed curve lies inside), and that no walk runs through. In a
transverse pair a plane across meets the surfaces once at most, so a curve next to a walk has pairs
of its own.

Letters as in `lift` and `hermite_arcs`; keys of pairs of cells as in `coverage`; patches as in
`patch_pairs`.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.smooth.control_nets import separated
from geosurf.kernels.smooth.coverage import cone, key_of, transverse
from geosurf.kernels.smooth.cubic_patch import cell_net
from geosurf.kernels.smooth.hermite_arcs import K_LENGTH, on_arc, squared_distance_to_arc
from geosurf.kernels.smooth.lift import F_POINT, newton_in_plane_to
from geosurf.kernels.smooth.patch_pairs import M_BULGE, M_CORNER

# instead of the knot where a walk passed; TO_SPLIT: not settled; CROSSED: not settled, but passed
NOT_PASSED, TO_SPLIT, CROSSED = -1, -2, -3
_PLACES = 8  # places of an arc at which its pair of cells is determined


@scalar
def patch_cone(m):
    """Axis and half angle [radians] of a cone that holds all normals of a patch; pi if none.

    Tangents lie in balls around their means u0, v0, whose radii are half of what opposite sides
    differ by, and four times the deviation of the cubic from the bilinear patch (`patch_pyramid`):
    the slope of ``t (t - 1) / 2`` is at most four times its value. |u x v - u0 x v0| <= (|u0| +
    |v0| + r) r.
    """
    u, v, far = M_CORNER + 3, M_CORNER + 6, M_CORNER + 9
    ux, uy, uz, vx, vy, vz, radius = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        # Mean tangents and their deviation, by coordinate.
        a, b, c, d = m[M_CORNER + k], m[u + k], m[v + k], m[far + k]
        more = 0.5 * abs(a - b - c + d) + 4.0 * m[M_BULGE + k]
        radius += more * more
        along, up = 0.5 * (b - a + d - c), 0.5 * (c - a + d - b)
        if k == 0:
            ux, vx = along, up
        elif k == 1:
            uy, vy = along, up
        else:
            uz, vz = along, up

    # Cross product of the mean tangents, and how far others deviate from it.
    radius = math.sqrt(radius)
    p, q, r = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    size = math.sqrt(p * p + q * q + r * r)
    away = math.sqrt(ux * ux + uy * uy + uz * uz) + math.sqrt(vx * vx + vy * vy + vz * vz)
    away = (away + radius) * radius
    # The deviation may turn the normal anywhere.
    if not away < size:
        return 0.0, 0.0, 0.0, math.pi
    return p / size, q / size, r / size, math.asin(away / size)


@scalar
def _cone_once(cones, patches, k):
    """Compute the cone of a patch on first use."""
    # NaN: not computed yet.
    if math.isnan(cones[k, 3]):
        cones[k, 0], cones[k, 1], cones[k, 2], cones[k, 3] = patch_cone(patches[k])


@scalar
def _are_transverse(surfaces, cell_a, p, cell_b, q, nets, half):
    """Whether two cells are transverse, by their cones p, q, or by those of their nets."""
    xa, ya, za, xb, yb, zb, _ = surfaces
    if transverse(p[0], p[1], p[2], p[3], q[0], q[1], q[2], q[3]):
        return True

    # The cones of the nets are tighter.
    cell_net(xa, ya, za, cell_a // (za.shape[1] - 1), cell_a % (za.shape[1] - 1), nets[0], half)
    cell_net(xb, yb, zb, cell_b // (zb.shape[1] - 1), cell_b % (zb.shape[1] - 1), nets[1], half)
    ap, aq, ar, aw = cone(nets[0])
    bp, bq, br, bw = cone(nets[1])
    return transverse(ap, aq, ar, aw, bp, bq, br, bw)


@scalar
def _rows_transverse(
    surfaces, cell_a, cell_b, patches_a, patches_b, a, b, cones_a, cones_b, nets, half
):
    """Whether the cells of rows a, b are transverse; `nets`, `half`: room for Bernstein nets."""
    _cone_once(cones_a, patches_a, a)
    _cone_once(cones_b, patches_b, b)
    return _are_transverse(surfaces, cell_a[a], cones_a[a], cell_b[b], cones_b[b], nets, half)


@scalar
def classify_pairs(surfaces, pairs, cell_a, cell_b, patches_a, patches_b):
    """Sorted keys of pairs, their order; NOT_PASSED for each pair, TO_SPLIT if not transverse."""
    n_pair = pairs.shape[0]
    keys, knot_of = np.empty(n_pair, dtype=np.int64), np.empty(n_pair, dtype=np.int64)
    # Most patches are in several pairs; cones are computed on first use.
    cones_a, cones_b = np.full((len(cell_a), 4), np.nan), np.full((len(cell_b), 4), np.nan)
    nets, half = np.empty((2, 4, 4, 3)), np.empty((4, 4))
    for k in range(n_pair):
        a, b = pairs[k, 0], pairs[k, 1]
        # a helper that makes no array: others count references of each array, pair by pair
        clear = _rows_transverse(
            surfaces, cell_a, cell_b, patches_a, patches_b, a, b, cones_a, cones_b, nets, half
        )
        knot_of[k] = NOT_PASSED if clear else TO_SPLIT
        keys[k] = cell_a[a] * (1 << 31) + cell_b[b]

    # Sorted keys allow bisection.
    order = np.argsort(keys)
    return keys[order], order, knot_of


@scalar
def find_seed(surfaces, m, cell_a, cell_b, enough, seed, f):
    """Newton from the middle of a pair of cells: point and parameters into `seed` (7,).

    m: the patch of the first cell.
    """
    za, zb = surfaces.za, surfaces.zb

    # Parameters and point of the middle of both cells.
    n_col = za.shape[1] - 1
    seed[3], seed[4] = cell_a % n_col + 0.5, cell_a // n_col + 0.5
    n_col = zb.shape[1] - 1
    seed[5], seed[6] = cell_b % n_col + 0.5, cell_b // n_col + 0.5
    for k in range(M_CORNER, M_CORNER + 3):
        seed[k - M_CORNER] = 0.25 * (m[k] + m[k + 3] + m[k + 6] + m[k + 9])
    x, y, z = seed[0], seed[1], seed[2]
    found = newton_in_plane_to(surfaces, 0, seed[3:7], x, y, z, 0.0, 0.0, 0.0, enough, f)
    for k in range(3):
        seed[k] = f[F_POINT + k]
    return found


@scalar
def is_disjoint_pair(surfaces, cell_a, cell_b, seed):
    """Whether a seed lies in other cells than those it started from, and nets separate those."""
    xa, ya, za, xb, yb, zb, _ = surfaces
    # Still in the pair of cells where it started.
    if key_of(za, zb, seed[3:7], 0) == cell_a * (1 << 31) + cell_b:
        return False
    nets, half = np.empty((2, 4, 4, 3)), np.empty((4, 4))
    cell_net(xa, ya, za, cell_a // (za.shape[1] - 1), cell_a % (za.shape[1] - 1), nets[0], half)
    cell_net(xb, yb, zb, cell_b // (zb.shape[1] - 1), cell_b % (zb.shape[1] - 1), nets[1], half)
    return separated(nets[0], nets[1])


@scalar
def _place_of(keys, order, key):
    """Row of the pair with a key; -1 if none."""
    k = np.searchsorted(keys, key)
    return order[k] if k < keys.shape[0] and keys[k] == key else -1


@scalar
def mark_passed(za, zb, knots, first, n, keys, order, knot_of, row):
    """Store for each pair of cells that knots first to n run through the knot of its arc."""
    last = -1
    for i in range(first + 1, n):
        for place in range(_PLACES):
            # Sample the arc at fixed places; skip repeated keys.
            on_arc(knots[i - 1], knots[i], place / _PLACES, row)
            key = key_of(za, zb, row[3:7], 0)
            if key == last:
                continue
            last = key
            k = _place_of(keys, order, key)
            # The first arc through a pair of cells represents the curve there.
            if k >= 0 and knot_of[k] < 0:
                knot_of[k] = i if knot_of[k] == NOT_PASSED else CROSSED


@scalar
def keys_passed(keys, order, knot_of):
    """Keys of the pairs that walks run through."""
    out, n = np.empty(keys.shape[0], dtype=np.int64), 0
    for k in range(keys.shape[0]):
        if knot_of[order[k]] >= 0 or knot_of[order[k]] == CROSSED:
            out[n] = keys[k]
            n += 1
    return out[:n].copy()


@scalar
def is_near_curve(za, zb, knots, n, seed, reach, keys, order, knot_of):
    """Whether a seed lies within reach [m] of an arc: that in its own pair of cells, or any."""
    x, y, z = seed[0], seed[1], seed[2]

    # The arc in the same pair of cells first, then all arcs by distance.
    k = _place_of(keys, order, key_of(za, zb, seed[3:7], 0))
    if k >= 0 and knot_of[k] >= 0:
        i = knot_of[k]
        if squared_distance_to_arc(knots[i - 1], knots[i], x, y, z) <= reach * reach:
            return True
    for i in range(1, n):
        # Knots farther away than the arc is long exclude it.
        size = knots[i, K_LENGTH] + reach
        dx, dy, dz = x - knots[i, 0], y - knots[i, 1], z - knots[i, 2]
        if knots[i, K_LENGTH] < 0.0 or dx * dx + dy * dy + dz * dz > size * size:
            continue
        if squared_distance_to_arc(knots[i - 1], knots[i], x, y, z) <= reach * reach:
            return True
    return False
