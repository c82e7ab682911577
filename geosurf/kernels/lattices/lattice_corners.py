"""Corners and normals of the triangles of a lattice, all at once.

Letters as in `strips`.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.prefetch import prefetch
from geosurf.kernels.lattices.strips import corner_of, load
from geosurf.kernels.search.tree import N_COL, N_ROW, RISING, TURNED

# error of each component of a cross product, relative to its terms (less than 4 rounding units),
# and an absolute bound for underflow
_ROUNDING = 8 * 2.0**-52
_UNDERFLOW = 1e-290
_DISTANCE = 24  # prefetch distance in nodes, as if they were in the same row


@scalar
def may_be_degenerate(ax, ay, az, bx, by, bz):
    """Whether a triangle with edges a and b may have zero area, within rounding."""
    xp, xm, yp, ym, zp, zm = ay * bz, az * by, az * bx, ax * bz, ax * by, ay * bx
    # Each component is a difference of two products. None of them differs from zero by more than
    # rounding: only exact arithmetic can tell.
    return (
        abs(xp - xm) <= _ROUNDING * (abs(xp) + abs(xm)) + _UNDERFLOW
        and abs(yp - ym) <= _ROUNDING * (abs(yp) + abs(ym)) + _UNDERFLOW
        and abs(zp - zm) <= _ROUNDING * (abs(zp) + abs(zm)) + _UNDERFLOW
    )


@scalar
def _add_steps(row, before, most):
    """Extend the largest steps by column with those along a row and from the row before."""
    for j in range(1, row.shape[0]):  # selections without branches are vectorised
        along, across = abs(row[j] - row[j - 1]), abs(row[j] - before[j])

        # comparisons with not-a-number are false
        step = most[j]
        step = along if along > step else step
        most[j] = across if across > step else step
    across = abs(row[0] - before[0])
    most[0] = across if across > most[0] else most[0]


@entry("d1 l1 -> d")
def steepest_step(r, a):
    """Largest step in elevation between two neighbours; absent nodes have none."""
    # rows of one value have no steps along them
    n = a[N_COL] if a[8] == 1 else 1
    most = np.zeros(n)
    for i in range(a[N_ROW]):
        here, before = a[6] + i * a[7], a[6] + max(i - 1, 0) * a[7]
        _add_steps(r[here : here + n], r[before : before + n], most)
    steepest = 0.0
    for j in range(n):
        steepest = max(steepest, most[j])
    return steepest


@entry("d1 d1 d1 l1 -> d1 l1")
def lattice_normals(p, q, r, a):
    """Sum of all normals (length: area) and of areas, and the keys of possibly degenerate
    triangles.

    Triangles without three nodes are left out, and none is turned.
    """
    out = np.zeros(4)
    suspects = np.empty(64, dtype=np.int64)
    n = 0
    for key in range(2 * max(a[N_ROW] - 1, 0) * max(a[N_COL] - 1, 0)):
        i, j = corner_of(a, key, 0)
        x, y, z = load(p, a, 0, i, j), load(q, a, 1, i, j), load(r, a, 2, i, j)
        # The edges from corner 0 to the other two corners.
        i, j = corner_of(a, key, 1)
        ax, ay, az = load(p, a, 0, i, j) - x, load(q, a, 1, i, j) - y, load(r, a, 2, i, j) - z
        i, j = corner_of(a, key, 2)
        bx, by, bz = load(p, a, 0, i, j) - x, load(q, a, 1, i, j) - y, load(r, a, 2, i, j) - z

        # NaN marks a missing node.
        nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        if not (nx + ny + nz == nx + ny + nz):
            continue
        out[0] += 0.5 * nx
        out[1] += 0.5 * ny
        out[2] += 0.5 * nz
        out[3] += 0.5 * np.sqrt(nx * nx + ny * ny + nz * nz)
        if may_be_degenerate(ax, ay, az, bx, by, bz):
            if n == suspects.shape[0]:
                larger = np.empty(2 * n, dtype=np.int64)
                larger[:n] = suspects
                suspects = larger
            suspects[n] = key
            n += 1
    return out, suspects[:n].copy()


@entry("l1 l1 -> l2")
def lattice_corners(a, keys):
    """Nodes (row by row) of triangles by key."""
    out = np.empty((keys.shape[0], 3), dtype=np.int64)
    n_col = a[N_COL]
    for i in range(keys.shape[0]):
        # Corners 0, 1, 2, 3 around the cell: 0 1 2 + 0 2 3 where diagonals rise, else 0 1 3 + 1 2
        # 3.
        cell = keys[i] >> 1
        low = cell + cell // (n_col - 1)  # one node more than cells in each row
        high = low + n_col
        # Where diagonals rise, both triangles have corner 0 and 2, else 1 and 3.
        if a[RISING] == 1:
            one, two, three = low, low + 1, high + 1
            if keys[i] & 1 == 1:
                two, three = high + 1, high
        else:
            one, two, three = low, low + 1, high
            if keys[i] & 1 == 1:
                one, two, three = low + 1, high + 1, high
        out[i, 0] = one
        out[i, 1] = three if a[TURNED] == 1 else two
        out[i, 2] = two if a[TURNED] == 1 else three
    return out


@entry("d1 d1 d1 l1 l1 -> d2")
def lattice_nodes(p, q, r, a, nodes):
    """World coordinates of nodes, counted row by row."""
    out = np.empty((nodes.shape[0], 3))
    n_col = a[N_COL]
    i = 0
    for k in range(nodes.shape[0]):
        # The node's row is not known yet; that of the current node is mostly the same.
        if k + _DISTANCE < nodes.shape[0]:
            j = nodes[k + _DISTANCE] - i * n_col
            prefetch(p, a[0] + i * a[1] + j * a[2])
            prefetch(q, a[3] + i * a[4] + j * a[5])
            prefetch(r, a[6] + i * a[7] + j * a[8])
        j = nodes[k] - i * n_col
        if not 0 <= j < n_col:  # most are in the previous row: divisions are slow
            i = nodes[k] // n_col
            j = nodes[k] - i * n_col
        out[k, 0] = load(p, a, 0, i, j)
        out[k, 1] = load(q, a, 1, i, j)
        out[k, 2] = load(r, a, 2, i, j)
    return out
