"""What a certificate asks of runs, without a list of their triangles: sums, edges and nodes.

A lattice has one label for each triangle: the run that lists it, or -1. Everything is read from
these labels, row by row, so a run that is too long, too short or listed twice is noticed.

Nodes are private if no other triangle of the model has them as corners; `shared` marks the others.
An edge between two private nodes belongs to the two triangles of the lattice next to it only. Edges
and nodes that are not private are counted over listed triangles (`meshes.shell_edges`).

Notation, in addition to that of `strips` (a, runs)
    p, q, r     easting, northing, elevation of nodes
    label       run of each triangle, by key; -1 for none
    shared      whether each node is shared, row by row
    sides       units in front of and behind each run (n_run, 2); -1 outside the model
    counts      int64 (n_unit, 3): vertices, edges and open edges of the shell of each unit
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.strips import FIRST, LAST, ROW, corner_of, key_at, load
from geosurf.kernels.search.tree import N_COL, N_ROW, RISING, TURNED

VERTICES, EDGES, OPEN = 0, 1, 2


@entry("d1 d1 d1 l1 l2 -> l1 l")
def label_runs(p, q, r, a, runs):
    """The label of each triangle, and the number of places that runs must not have.

    These are places outside of the lattice, in two runs, or without three nodes.
    """
    n_row, n_col = max(a[N_ROW] - 1, 0), max(a[N_COL] - 1, 0)
    label = np.full(2 * n_row * n_col, -1, dtype=np.int64)
    n_bad = 0
    for i in range(runs.shape[0]):
        row, first, last = runs[i, ROW], runs[i, FIRST], runs[i, LAST]
        if row < 0 or row >= n_row or first < 0 or last >= 2 * n_col or last < first:
            n_bad += 1
            continue
        for place in range(first, last + 1):
            key = key_at(a, row, place)
            if label[key] >= 0:
                n_bad += 1
            label[key] = i

            # The sum of all coordinates is not a number if one of them is not.
            total = 0.0
            for corner in range(3):
                u, v = corner_of(a, key, corner)
                total += load(p, a, 0, u, v) + load(q, a, 1, u, v) + load(r, a, 2, u, v)
            if not total - total == 0.0:
                n_bad += 1
    return label, n_bad


@entry("l1 l1 b1 -> .")
def mark_nodes(a, keys, shared):
    """Mark the corners of some triangles as shared."""
    for k in range(keys.shape[0]):
        for corner in range(3):
            i, j = corner_of(a, keys[k], corner)
            shared[i * a[N_COL] + j] = True


@entry("l1 l1 b1 -> l1")
def keys_at_shared(a, label, shared):
    """Keys of the triangles in runs that have a shared corner, rising."""
    n_col = a[N_COL]
    found = np.empty(1024, dtype=np.int64)
    n = 0
    for row in range(a[N_ROW] - 1):
        for col in range(n_col - 1):
            at = row * n_col + col
            if not (shared[at] or shared[at + 1] or shared[at + n_col] or shared[at + n_col + 1]):
                continue
            for half in range(2):
                key = 2 * (row * (n_col - 1) + col) + half
                if label[key] < 0:
                    continue
                touched = False
                for corner in range(3):
                    i, j = corner_of(a, key, corner)
                    touched = touched or shared[i * n_col + j]
                if not touched:
                    continue
                if n == found.shape[0]:
                    larger = np.empty(2 * n, dtype=np.int64)
                    larger[:n] = found
                    found = larger
                found[n] = key
                n += 1
    return found[:n].copy()


@scalar
def _two_sum(out, i, k, term):
    """Add a term to the pair of numbers at out[i, k]; the second collects rounding errors."""
    total = out[i, k] + term
    back = total - out[i, k]
    out[i, k + 1] += (out[i, k] - (total - back)) + (term - back)
    out[i, k] = total


@entry("d1 d1 d1 l1 l1 d1 d d2 -> d d")
def sums_of_runs(p, q, r, a, label, origin, level, out):
    """Add to the rows of runs (n_run, 14) the sums over their triangles; the area and the sum of
    all sides of the triangles without a label, which exist.

    Columns: six times the volume over a level (two numbers), twice the area (two numbers), products
    of two sides, all sides (both in the norm of absolute values), twice the area in the map, the
    number of triangles, lower and upper corner. Volume and area in the map are below 0 where
    normals look down.
    """
    sign = -1.0 if a[TURNED] != 0 else 1.0
    c = np.empty((3, 3))
    rest = np.zeros((1, 2))
    rim = 0.0
    for key in range(label.shape[0]):
        for corner in range(3):
            i, j = corner_of(a, key, corner)
            c[corner, 0] = load(p, a, 0, i, j) - origin[0]
            c[corner, 1] = load(q, a, 1, i, j) - origin[1]
            c[corner, 2] = load(r, a, 2, i, j) - origin[2]
        ux, uy, uz = c[1, 0] - c[0, 0], c[1, 1] - c[0, 1], c[1, 2] - c[0, 2]
        vx, vy, vz = c[2, 0] - c[0, 0], c[2, 1] - c[0, 1], c[2, 2] - c[0, 2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        area = np.sqrt(nx * nx + ny * ny + nz * nz)
        if not area == area:
            continue
        u, v = abs(ux) + abs(uy) + abs(uz), abs(vx) + abs(vy) + abs(vz)
        around = u + v + abs(ux - vx) + abs(uy - vy) + abs(uz - vz)
        i = label[key]
        if i < 0:
            _two_sum(rest, 0, 0, area)
            rim += around
            continue
        height = (c[0, 2] - level) + (c[1, 2] - level) + (c[2, 2] - level)
        _two_sum(out, i, 0, sign * nz * height)
        _two_sum(out, i, 2, area)
        out[i, 4] += u * v
        out[i, 5] += around
        out[i, 6] += sign * nz
        out[i, 7] += 1.0
        for k in range(3):
            out[i, 8 + k] = min(out[i, 8 + k], min(c[0, k], min(c[1, k], c[2, k])))
            out[i, 11 + k] = max(out[i, 11 + k], max(c[0, k], max(c[1, k], c[2, k])))
    return 0.5 * (rest[0, 0] + rest[0, 1]), rim


@scalar
def _add_edge(sides, one, two, counts):
    """Count an edge between two triangles of a lattice, by their labels, for the units around."""
    if one < 0 and two < 0:
        return
    if one >= 0 and two >= 0:
        front, behind = sides[one, 0], sides[one, 1]
        if front == sides[two, 0] and behind == sides[two, 1]:
            if front != behind:
                if front >= 0:
                    counts[front, EDGES] += 1
                if behind >= 0:
                    counts[behind, EDGES] += 1
            return

    # One triangle runs through the edge one way, the other one the other way. A shell has a
    # triangle as it is if the unit lies behind it, and turned over if it lies in front.
    for which in range(4):
        of = one if which < 2 else two
        if of < 0 or sides[of, 0] == sides[of, 1]:
            continue
        unit = sides[of, which % 2]
        if unit < 0:
            continue
        balance = 0
        if one >= 0 and sides[one, 0] != sides[one, 1]:
            balance += int(sides[one, 1] == unit) - int(sides[one, 0] == unit)
        seen = which >= 2 and balance != 0  # counted with the first triangle
        if two >= 0 and sides[two, 0] != sides[two, 1]:
            balance -= int(sides[two, 1] == unit) - int(sides[two, 0] == unit)
        if not seen:
            counts[unit, EDGES] += 1
            counts[unit, OPEN] += abs(balance)


@scalar
def _add_node(around, sides, stamp, node, counts):
    """Count a node for each unit that has a triangle around it; 1 if there is one, else 0."""
    one = around[0]
    alike = one >= 0
    for k in range(1, 6):
        alike = alike and around[k] == one
    used = 0
    for k in range(1 if alike else 6):
        of = around[k]
        if of < 0 or sides[of, 0] == sides[of, 1]:
            continue
        for s in range(2):
            unit = sides[of, s]
            if unit >= 0 and stamp[unit] != node:
                stamp[unit] = node
                counts[unit, VERTICES] += 1
                used = 1
    return used


@scalar
def _label(a, label, row, col, half):
    """Label of a triangle; -1 outside of the lattice."""
    if row < 0 or col < 0 or row >= a[N_ROW] - 1 or col >= a[N_COL] - 1:
        return -1
    return label[2 * (row * (a[N_COL] - 1) + col) + half]


@scalar
def _labels_around(a, label, i, j, around):
    """Labels of the six triangles around a node."""
    # corners 0, 1, 2, 3 around a cell: 0 1 2 + 0 2 3 where diagonals rise, else 0 1 3 + 1 2 3
    if a[RISING] == 1:
        around[0] = _label(a, label, i, j, 0)
        around[1] = _label(a, label, i, j, 1)
        around[2] = _label(a, label, i, j - 1, 0)
        around[3] = _label(a, label, i - 1, j - 1, 0)
        around[4] = _label(a, label, i - 1, j - 1, 1)
        around[5] = _label(a, label, i - 1, j, 1)
        return
    around[0] = _label(a, label, i, j, 0)
    around[1] = _label(a, label, i, j - 1, 0)
    around[2] = _label(a, label, i, j - 1, 1)
    around[3] = _label(a, label, i - 1, j - 1, 1)
    around[4] = _label(a, label, i - 1, j, 0)
    around[5] = _label(a, label, i - 1, j, 1)


@scalar
def _add_joined(one, two, pairs, n):
    """Append two runs, unless they are one or were the last pair."""
    if one < 0 or two < 0 or one == two:
        return pairs, n
    if n > 0 and pairs[n - 1, 0] == one and pairs[n - 1, 1] == two:
        return pairs, n
    if n == pairs.shape[0]:
        larger = np.empty((2 * n, 2), dtype=np.int64)
        larger[:n] = pairs
        pairs = larger
    pairs[n, 0], pairs[n, 1] = one, two
    return pairs, n + 1


@entry("l1 l1 b1 l2 l2 -> l l2")
def count_private(a, label, shared, sides, counts):
    """Add private nodes and edges to the counts of units; the number of nodes of shells, and pairs
    of runs with a common private edge.
    """
    n_row, n_col = a[N_ROW], a[N_COL]
    around = np.empty(6, dtype=np.int64)
    stamp = np.full(counts.shape[0], -1, dtype=np.int64)
    pairs, n_pair = np.empty((1024, 2), dtype=np.int64), 0
    n_used = 0
    right, left = (1, 0) if a[RISING] == 1 else (0, 1)
    low, high = (0, 3) if a[RISING] == 1 else (1, 2)  # corners that the diagonal joins
    for i in range(n_row):
        for j in range(n_col):
            node = i * n_col + j
            if not shared[node]:
                _labels_around(a, label, i, j, around)
                n_used += _add_node(around, sides, stamp, node, counts)

                # The edges to the next node of the row, and to the next row.
                if j + 1 < n_col and not shared[node + 1]:
                    one, two = _label(a, label, i - 1, j, 1), _label(a, label, i, j, 0)
                    _add_edge(sides, one, two, counts)
                    pairs, n_pair = _add_joined(one, two, pairs, n_pair)
                if i + 1 < n_row and not shared[node + n_col]:
                    one, two = _label(a, label, i, j, right), _label(a, label, i, j - 1, left)
                    _add_edge(sides, one, two, counts)
                    pairs, n_pair = _add_joined(one, two, pairs, n_pair)

            # The diagonal of the cell that begins here.
            if i + 1 < n_row and j + 1 < n_col:
                start = node + (0 if low == 0 else 1)
                stop = node + n_col + (1 if high == 3 else 0)
                if not shared[start] and not shared[stop]:
                    one, two = _label(a, label, i, j, 0), _label(a, label, i, j, 1)
                    _add_edge(sides, one, two, counts)
                    pairs, n_pair = _add_joined(one, two, pairs, n_pair)
    return n_used, pairs[:n_pair].copy()


@entry("l2 d2 d2 -> .")
def add_to_units(sides, sums, out):
    """Add sums of elements (see `sums_of_runs`) to those of the units that they bound.

    `out` is (n_unit, 6): volume and area as in `sums_of_runs`, products, number of triangles. An
    element with one unit on both sides bounds none.
    """
    for i in range(sides.shape[0]):
        if sides[i, 0] == sides[i, 1]:
            continue
        for s in range(2):
            unit = sides[i, s]
            if unit < 0:
                continue
            sign = 1.0 if s == 1 else -1.0
            for part in range(2):
                _two_sum(out, unit, 0, sign * sums[i, part])
                _two_sum(out, unit, 2, sums[i, 2 + part])
            out[unit, 4] += sums[i, 4]
            out[unit, 5] += sums[i, 7]
