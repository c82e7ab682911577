"""Volume, area and bounds of faces: sums over triangles and over runs of a lattice.

The volume between a triangle and a level is its map area times its mean height. Over a closed shell
these add up to the volume inside. A triangle that reaches across the level is cut by it: with one
corner at height p above the level and the others at q and r below it, the tip above has map area
A p^2 / ((p - q) (p - r)) and mean height p / 3; the rest of the triangle has the rest.

A sum is kept as two numbers where digits matter; the second collects all rounding errors of the
first (Knuth's two-sum; Ogita, Rump & Oishi 2005). Heights are measured from a level, to preserve
digits. A certificate has sums of its own (`checks`), so that no mistake here is one there, too.
Letters as in `strips`. Each row of `out` (n_face, N_SUM) belongs to a face.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.strips import FIRST, LAST, ROW, load
from geosurf.kernels.meshes.checks import two_sum
from geosurf.kernels.search.tree import RISING, TURNED

# columns of sums. Six times the volume between triangles and the level, above it and below it, and
# twice the area in the map: below 0, above 0 and below 0 where normals look down. Area; lower and
# upper corner; twice the area in the map of triangles that look up, and of those that look down
ABOVE, BELOW, FLAT, AREA, LOWER, UPPER, LOOKS_UP, LOOKS_DOWN, N_SUM = 0, 2, 4, 5, 7, 10, 13, 15, 17


@scalar
def _lowest(x, t, i):
    """Corner of a triangle that comes first by its coordinates, independent of its numbering."""
    low = 0
    for corner in range(1, 3):
        # Lexicographic comparison of coordinates.
        for k in range(3):
            if x[t[i, corner], k] != x[t[i, low], k]:
                if x[t[i, corner], k] < x[t[i, low], k]:
                    low = corner
                break
    return low


@scalar
def _add_volume(flat, p, q, r, i, out):
    """Add six times the volume between a triangle and the level to what is above it, or below.

    `flat` is twice the map area; p, q and r are the heights of the corners.
    """
    whole = flat * (p + q + r)
    if min(p, min(q, r)) >= 0.0:
        two_sum(out, i, ABOVE, whole)
    elif max(p, max(q, r)) <= 0.0:
        two_sum(out, i, BELOW, whole)
    else:
        # the corner that is alone on its side; one at the level counts to the two others
        above = (1 if p > 0.0 else 0) + (1 if q > 0.0 else 0) + (1 if r > 0.0 else 0)
        sign = 1.0 if above == 1 else -1.0
        if sign * q > 0.0:
            p, q, r = q, r, p
        elif sign * r > 0.0:
            p, q, r = r, p, q
        tip = flat * p * (p / (p - q)) * (p / (p - r))
        two_sum(out, i, ABOVE if above == 1 else BELOW, tip)
        two_sum(out, i, BELOW if above == 1 else ABOVE, whole - tip)


@scalar
def _add(ax, ay, az, bx, by, bz, cx, cy, cz, level, sign, i, out):
    """Add the triangle a, b, c to row i; `sign` is -1 if it has to be turned."""
    ux, uy, uz = bx - ax, by - ay, bz - az
    vx, vy, vz = cx - ax, cy - ay, cz - az
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, sign * (ux * vy - uy * vx)
    _add_volume(nz, az - level, bz - level, cz - level, i, out)
    out[i, FLAT] += nz
    two_sum(out, i, AREA, 0.5 * np.sqrt(nx * nx + ny * ny + nz * nz))
    two_sum(out, i, LOOKS_UP if nz > 0.0 else LOOKS_DOWN, abs(nz))
    out[i, LOWER] = min(out[i, LOWER], min(ax, min(bx, cx)))
    out[i, LOWER + 1] = min(out[i, LOWER + 1], min(ay, min(by, cy)))
    out[i, LOWER + 2] = min(out[i, LOWER + 2], min(az, min(bz, cz)))
    out[i, UPPER] = max(out[i, UPPER], max(ax, max(bx, cx)))
    out[i, UPPER + 1] = max(out[i, UPPER + 1], max(ay, max(by, cy)))
    out[i, UPPER + 2] = max(out[i, UPPER + 2], max(az, max(bz, cz)))


@entry("d2 l2 l1 b1 d d2* -> .")
def add_triangles(x, t, face, asked, level, out):
    """Add triangles to the rows of their faces, of those that are asked for."""
    for i in range(t.shape[0]):
        if face[i] < 0 or not asked[face[i]]:
            continue
        # A canonical first corner makes the result independent of numbering.
        low = _lowest(x, t, i)
        a, b, c = t[i, low], t[i, (low + 1) % 3], t[i, (low + 2) % 3]
        _add(
            x[a, 0], x[a, 1], x[a, 2], x[b, 0], x[b, 1], x[b, 2], x[c, 0], x[c, 1], x[c, 2],
            level, 1.0, face[i], out,
        )  # fmt: skip


@scalar
def _node(p, q, r, a, origin, row, col):
    """A node of a lattice, local."""
    x, y = load(p, a, 0, row, col) - origin[0], load(q, a, 1, row, col) - origin[1]
    return x, y, load(r, a, 2, row, col) - origin[2]


@entry("d1 d1 d1 l1 l2 l1 d1 d d2* -> .")
def add_runs(p, q, r, a, runs, face, origin, level, out):
    """Add the triangles of runs; `origin` is subtracted from their nodes."""
    sign = -1.0 if a[TURNED] != 0 else 1.0
    rising = a[RISING] != 0
    for i in range(runs.shape[0]):
        row, first, last, f = runs[i, ROW], runs[i, FIRST], runs[i, LAST], face[i]
        # corners 0, 1, 2, 3 around a cell: 0 and 3 are 1 and 2 of the one before
        x1, y1, z1 = _node(p, q, r, a, origin, row, first >> 1)
        x2, y2, z2 = _node(p, q, r, a, origin, row + 1, first >> 1)
        for col in range(first >> 1, (last >> 1) + 1):
            x0, y0, z0, x3, y3, z3 = x1, y1, z1, x2, y2, z2
            x1, y1, z1 = _node(p, q, r, a, origin, row, col + 1)
            x2, y2, z2 = _node(p, q, r, a, origin, row + 1, col + 1)
            # 0 2 3 and 0 1 2 where diagonals rise, else 0 1 3 and 1 2 3
            if 2 * col >= first:
                x, y, z = (x2, y2, z2) if rising else (x1, y1, z1)
                _add(x0, y0, z0, x, y, z, x3, y3, z3, level, sign, f, out)
            if 2 * col < last and rising:
                _add(x0, y0, z0, x1, y1, z1, x2, y2, z2, level, sign, f, out)
            elif 2 * col < last:
                _add(x1, y1, z1, x2, y2, z2, x3, y3, z3, level, sign, f, out)
