"""Coverage: does each contact of two smooth surfaces lie on a known curve? Seeds for those that do
not.

Pairs of patches that may touch (`patch_pyramid`) are split (de Casteljau) until each part is

- separated, by its Bernstein coefficients; or
- transverse, that is, no normal of one patch is parallel to one of the other, so that no closed
  curve lies inside, and a known curve runs through the pair of cells, or Newton's method from its
  middle ends in a pair of cells with a known curve; or
- the start of an unknown curve: a seed; or
- so nearly tangent that it cannot be decided at 1/32 of a cell: a point to report.

Normals of a patch are sums, with positive weights, of cross products of control differences
(Sederberg & Meyers 1988), so a cone around those holds them all.

Letters as in `lift`; g, h nets (4, 4, 3) of a part of a and of b; r ranges (8,) of its parameters.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.smooth.control_nets import lies_beside, net_normal, separated
from geosurf.kernels.smooth.lift import (
    ASTRAY,
    F_POINT,
    LIFTED,
    N_WORK,
    OUTSIDE,
    SurfacePair,
    newton_in_plane,
)

SEED, NEAR_SEED, TOUCH, TOO_CLOSE = 0, 1, 2, 3
_SMALLEST = 1.0 / 32.0  # [cells]
_MOST = 1500  # largest number of parts of one pair of cells
_IN_ALL = 100_000  # largest number of parts in all: coinciding surfaces would never end


@scalar
def cone(net):
    """Axis and half angle [radians] of a cone that holds all normals; pi if there is none."""
    p, q, r = net_normal(net)

    # The largest angle between the axis and any cross product of control differences.
    least = 1.0
    # Every difference along u with every difference along v: all cross products of the source.
    for i in range(4):
        for j in range(3):
            ux = net[i, j + 1, 0] - net[i, j, 0]
            uy = net[i, j + 1, 1] - net[i, j, 1]
            uz = net[i, j + 1, 2] - net[i, j, 2]
            for k in range(3):
                for col in range(4):
                    vx = net[k + 1, col, 0] - net[k, col, 0]
                    vy = net[k + 1, col, 1] - net[k, col, 1]
                    vz = net[k + 1, col, 2] - net[k, col, 2]
                    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
                    size = math.sqrt(x * x + y * y + z * z)
                    # Parallel differences have no normal and bound nothing.
                    if size > 0.0:
                        least = min(least, (p * x + q * y + r * z) / size)
    # A cone of a right angle or more separates nothing.
    if not least > 0.0 or math.isnan(p):
        return p, q, r, math.pi
    return p, q, r, math.acos(min(least, 1.0))


@entry("d4 -> d2")
def cones_of(nets):
    """Axis and half angle (n, 4) of the cones of normals of patches."""
    out = np.empty((nets.shape[0], 4))
    for n in range(nets.shape[0]):
        out[n, 0], out[n, 1], out[n, 2], out[n, 3] = cone(nets[n])
    return out


@scalar
def transverse(ap, aq, ar, aw, bp, bq, br, bw):
    """Whether two double cones have no direction in common."""
    # Normals have no sign here, hence double cones.
    between = math.acos(min(abs(ap * bp + aq * bq + ar * br), 1.0))
    return between > aw + bw + 1e-9


@scalar
def _halve(net, along_u, low, high):
    """De Casteljau at the middle: both halves of a net."""
    for i in range(4):
        for axis in range(3):
            if along_u:
                a, b, c, d = net[i, 0, axis], net[i, 1, axis], net[i, 2, axis], net[i, 3, axis]
            else:
                a, b, c, d = net[0, i, axis], net[1, i, axis], net[2, i, axis], net[3, i, axis]

            # Three rounds of midpoints give the coefficients of both halves.
            e, f, g = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + d)
            h, k = 0.5 * (e + f), 0.5 * (f + g)
            m = 0.5 * (h + k)
            for n in range(4):
                one = a if n == 0 else (e if n == 1 else (h if n == 2 else m))
                two = m if n == 0 else (k if n == 1 else (g if n == 2 else d))
                if along_u:
                    low[i, n, axis], high[i, n, axis] = one, two
                else:
                    low[n, i, axis], high[n, i, axis] = one, two


@scalar
def _length(net, along_u):
    # Both sides of the net along the parameter.
    i, j = (0, 3) if along_u else (3, 0)
    x, y, z = net[i, j, 0] - net[0, 0, 0], net[i, j, 1] - net[0, 0, 1], net[i, j, 2] - net[0, 0, 2]
    i, j = (3, 0) if along_u else (0, 3)
    p = net[3, 3, 0] - net[i, j, 0]
    q = net[3, 3, 1] - net[i, j, 1]
    r = net[3, 3, 2] - net[i, j, 2]
    return max(x * x + y * y + z * z, p * p + q * q + r * r)


@scalar
def _size(net):
    """Square of the longest side of a net [m2]."""
    return max(_length(net, True), _length(net, False))


@scalar
def _split(g, h, r, n, n_side):
    """Split the longest of the first sides of part n into parts n and n + 1; False if all are
    smallest.
    """
    # Choose the parameter with the longest side in space.
    best, longest = -1, 0.0
    for k in range(n_side):
        # Parameters whose range is smallest already are not split again.
        if r[n, 2 * k + 1] - r[n, 2 * k] > _SMALLEST:
            size = _length(g[n] if k < 2 else h[n], k % 2 == 0)
            if size > longest:
                best, longest = k, size
    if best < 0:
        return False

    # Halve the range and the net of that parameter.
    r[n + 1] = r[n]
    middle = 0.5 * (r[n, 2 * best] + r[n, 2 * best + 1])
    r[n, 2 * best + 1], r[n + 1, 2 * best] = middle, middle
    if best < 2:
        # Both halves overwrite the part, so they are computed from a copy.
        net = g[n].copy()
        _halve(net, best == 0, g[n], g[n + 1])
        h[n + 1] = h[n]
    else:
        net = h[n].copy()
        _halve(net, best == 2, h[n], h[n + 1])
        g[n + 1] = g[n]
    return True


@scalar
def key_of(za, zb, w, tri):
    """Key of the pair of cells that holds parameters."""
    # Clamp parameters on the boundary into the last cell.
    n_col = za.shape[1] - 1
    j = min(max(int(w[0]), 0), n_col - 1)
    i = min(max(int(w[1]), 0), za.shape[0] - 2)
    a = i * n_col + j
    if zb.shape[0] == 1:
        # Two cell numbers in one key; a surface has fewer than 2**31 cells.
        return a * (1 << 31) + tri
    n_col = zb.shape[1] - 1
    j = min(max(int(w[2]), 0), n_col - 1)
    i = min(max(int(w[3]), 0), zb.shape[0] - 2)
    return a * (1 << 31) + i * n_col + j


@entry("d2 d2 d2 l1 -> l1")
def keys_of(za, zb, w, tri):
    """`key_of` for rows."""
    out = np.empty(w.shape[0], dtype=np.int64)
    for k in range(w.shape[0]):
        out[k] = key_of(za, zb, w[k], tri[k])
    return out


@scalar
def _known(keys, key):
    k = np.searchsorted(keys, key)
    return k < keys.shape[0] and keys[k] == key


@scalar
def _within(w, r, n):
    """Whether parameters are in part n, or within its own size of it."""
    for k in range(4):
        # Newton may end just outside of a part and still belong to it.
        more = r[n, 2 * k + 1] - r[n, 2 * k]
        if w[k] < r[n, 2 * k] - more or w[k] > r[n, 2 * k + 1] + more:
            return False
    return True


@scalar
def _middle_of(g, r, n, mesh, w):
    """Parameters in the middle of part n, and its point."""
    for k in range(4):
        w[k] = 0.5 * (r[n, 2 * k] + r[n, 2 * k + 1])
    if mesh:  # a triangle is the patch (s, t) = (p (1 - q), p q)
        p, q = w[2], w[3]
        w[2], w[3] = p * (1.0 - q), p * q
    x = 0.25 * (g[n, 0, 0, 0] + g[n, 3, 0, 0] + g[n, 0, 3, 0] + g[n, 3, 3, 0])
    y = 0.25 * (g[n, 0, 0, 1] + g[n, 3, 0, 1] + g[n, 0, 3, 1] + g[n, 3, 3, 1])
    z = 0.25 * (g[n, 0, 0, 2] + g[n, 3, 0, 2] + g[n, 0, 3, 2] + g[n, 3, 3, 2])
    return x, y, z


@scalar
def _set_ranges(za, zb, cell_a, cell_b, r):
    """Ranges of the parameters of a pair of cells, into the first row of r."""
    n_col = za.shape[1] - 1
    # A range starts at the column or row of the cell and is one cell long.
    r[0, 0], r[0, 2] = cell_a % n_col, cell_a // n_col
    r[0, 4], r[0, 6] = 0.0, 0.0
    if zb.shape[0] > 1:
        r[0, 4], r[0, 6] = cell_b % (zb.shape[1] - 1), cell_b // (zb.shape[1] - 1)
    for col in range(4):
        r[0, 2 * col + 1] = r[0, 2 * col] + 1.0


@scalar
def _append_found(out, n, kind, tri, w, x, y, z):
    """Append a row of `check_pairs`: rows, longer if full, and their number."""
    if n == out.shape[0]:
        more = np.empty((2 * n, 9))
        more[:n] = out
        out = more
    out[n, 0], out[n, 1] = kind, tri
    out[n, 2:6] = w
    out[n, 6], out[n, 7], out[n, 8] = x, y, z
    return out, n + 1


@entry("d2 d2 d2 d2 d2 d2 d3 l2 l1 l1 d4 d4 d2 d2 l1 -> d2")
def check_pairs(xa, ya, za, xb, yb, zb, c, pairs, cell_a, cell_b, nets_a, nets_b, cones_a,
                cones_b, keys):  # fmt: skip
    """Contacts of pairs of patches that no known curve covers; `keys` are its pairs of cells.

    Returns rows (n, 9): kind (SEED, NEAR_SEED, TOUCH, TOO_CLOSE), triangle of b, parameters,
    point. A near seed is so close to tangency that only its distance from the known curves decides
    whether it is on one of them.
    """
    surfaces = SurfacePair(xa, ya, za, xb, yb, zb, c)
    mesh = zb.shape[0] == 1
    out = np.empty((16, 9))
    n_out, looked_in_all = 0, 0
    g, h, r = np.empty((64, 4, 4, 3)), np.empty((64, 4, 4, 3)), np.empty((64, 8))
    w, f = np.empty(4), np.empty(N_WORK)
    for k in range(pairs.shape[0]):
        a, b = pairs[k]
        key = cell_a[a] * (1 << 31) + cell_b[b]
        seen = _known(keys, key)
        ca, cb = cones_a[a], cones_b[b]

        # A transverse pair with a known curve holds no other one.
        if seen and transverse(ca[0], ca[1], ca[2], ca[3], cb[0], cb[1], cb[2], cb[3]):
            continue
        # Triangles of one plane are near the same cells; their edges tell them apart.
        if mesh and not seen and lies_beside(nets_a[a], c[cell_b[b]]):
            continue
        g[0], h[0] = nets_a[a], nets_b[b]
        _set_ranges(za, zb, cell_a[a], cell_b[b], r)

        # Parts of this pair on a stack. A triangle larger than the cell stays whole: its edges
        # exclude more than its parts do.
        top, looked, n_side = 1, 0, 4
        tri = cell_b[b] if mesh else 0
        if mesh and _size(h[0]) > _size(g[0]):
            n_side = 2
        while top > 0:
            # The part on top of the stack.
            n = top - 1
            looked += 1
            looked_in_all += 1
            if separated(g[n], h[n]) or (n_side == 2 and lies_beside(g[n], c[tri])):
                top -= 1
                continue
            ap, aq, ar, aw = cone(g[n])
            bp, bq, br, bw = cone(h[n])
            clear = transverse(ap, aq, ar, aw, bp, bq, br, bw)
            # Nothing but the known curve of this pair of cells.
            if clear and seen:
                top -= 1
                continue

            # Newton from the middle of a transverse part: a known curve, a seed, or undecided.
            x, y, z = _middle_of(g, r, n, mesh, w)
            kind = -1
            found = ASTRAY
            if clear:
                found = newton_in_plane(surfaces, tri, w, x, y, z, 0.0, 0.0, 0.0, f)
                if found == LIFTED and _known(keys, key_of(za, zb, w, tri)):
                    top -= 1
                    continue
                if found == LIFTED and (mesh or _within(w, r, n)):
                    kind = SEED

            # Split undecided parts until they are smallest or too many.
            enough = looked >= _MOST or looked_in_all >= _IN_ALL
            if kind < 0 and not enough and _split(g, h, r, n, n_side):
                top += 1
                continue

            # Report what is left.
            # Too many parts: the rest of this pair is reported as one place.
            if kind < 0 and enough:
                kind, top = TOO_CLOSE, 1
            elif kind < 0:
                x, y, z = _middle_of(g, r, n, mesh, w)
                found = newton_in_plane(surfaces, tri, w, x, y, z, 0.0, 0.0, 0.0, f)
                # The surfaces come close only beyond their boundaries.
                if found == OUTSIDE:
                    top -= 1
                    continue
                kind = TOUCH if found != LIFTED else (SEED if clear else NEAR_SEED)
            if found == LIFTED:
                x, y, z = f[F_POINT], f[F_POINT + 1], f[F_POINT + 2]
            out, n_out = _append_found(out, n_out, kind, tri, w, x, y, z)
            top -= 1
    return out[:n_out].copy()
