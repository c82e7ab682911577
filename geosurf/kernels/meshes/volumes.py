"""Volume, area and bounds of faces: sums over triangles and over runs of a lattice.

The volume between a triangle and a level is its map area times its mean height. Over a closed shell
these add up to the volume inside. A triangle that reaches across the level is cut by it: with one
corner at height p above the level and the others at q and r below it, the tip above has map area
A p^2 / ((p - q) (p - r)) and mean height p / 3; the rest of the triangle has the rest.

A sum is kept as two numbers where digits matter; the second collects all rounding errors of the
first (Knuth's two-sum; Ogita, Rump & Oishi 2005). Heights are measured from a level, to preserve
digits. Letters as in `strips`. Each row of `out` (n_face, N_SUM) belongs to a face.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.strips import FIRST, LAST, ROW
from geosurf.kernels.meshes.checks import load_half, load_side, two_sum
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
def _add(c, level, sign, i, out):
    """Add a triangle with corners c to row i; `sign` is -1 if it has to be turned."""
    ux, uy, uz = c[1, 0] - c[0, 0], c[1, 1] - c[0, 1], c[1, 2] - c[0, 2]
    vx, vy, vz = c[2, 0] - c[0, 0], c[2, 1] - c[0, 1], c[2, 2] - c[0, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, sign * (ux * vy - uy * vx)
    _add_volume(nz, c[0, 2] - level, c[1, 2] - level, c[2, 2] - level, i, out)
    out[i, FLAT] += nz
    two_sum(out, i, AREA, 0.5 * np.sqrt(nx * nx + ny * ny + nz * nz))
    two_sum(out, i, LOOKS_UP if nz > 0.0 else LOOKS_DOWN, abs(nz))
    for k in range(3):
        out[i, LOWER + k] = min(out[i, LOWER + k], min(c[0, k], min(c[1, k], c[2, k])))
        out[i, UPPER + k] = max(out[i, UPPER + k], max(c[0, k], max(c[1, k], c[2, k])))


@entry("d2 l2 l1 b1 d d2* -> .")
def add_triangles(x, t, face, asked, level, out):
    """Add triangles to the rows of their faces, of those that are asked for."""
    c = np.empty((3, 3))
    for i in range(t.shape[0]):
        if face[i] < 0 or not asked[face[i]]:
            continue
        # A canonical first corner makes the result independent of numbering.
        low = _lowest(x, t, i)
        for corner in range(3):
            for k in range(3):
                c[corner, k] = x[t[i, (low + corner) % 3], k]
        _add(c, level, 1.0, face[i], out)


@entry("d1 d1 d1 l1 l2 l1 d1 d d2* -> .")
def add_runs(p, q, r, a, runs, face, origin, level, out):
    """Add the triangles of runs; `origin` is subtracted from their nodes."""
    sign = -1.0 if a[TURNED] != 0 else 1.0
    c, cell = np.empty((3, 3)), np.empty((4, 3))
    for i in range(runs.shape[0]):
        row, first, last = runs[i, ROW], runs[i, FIRST], runs[i, LAST]
        load_side(p, q, r, a, origin, row, first >> 1, cell)
        for col in range(first >> 1, (last >> 1) + 1):
            load_side(p, q, r, a, origin, row, col + 1, cell)
            for place in range(max(first, 2 * col), min(last, 2 * col + 1) + 1):
                load_half(cell, (place & 1) ^ a[RISING], a[RISING], c)
                _add(c, level, sign, face[i], out)
