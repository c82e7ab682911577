"""What a certificate asks of runs, without a list of their triangles: sums, edges and nodes.

A lattice has one label for each triangle: the run that lists it, or -1. Everything is read from
these labels, row by row, so a run that is too long, too short or listed twice is noticed. Some rows
at a time are a lattice of their own here, so that labels take little memory.

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
from geosurf.kernels.lattices.strips import FIRST, LAST, ROW, corner_of, load
from geosurf.kernels.search.tree import N_COL, N_ROW, RISING, TURNED

VERTICES, EDGES, OPEN = 0, 1, 2


@scalar
def _bad_numbers(values, a, axis, row, first, last):
    """How many coordinates of the nodes of some columns of a row are infinite or not a number."""
    n_bad = 0
    for col in range(first, last + 1):
        value = load(values, a, axis, row, col)
        n_bad += 0 if value - value == 0.0 else 1
    return n_bad


@entry("l1 l2 -> l1 l")
def label_runs(a, runs):
    """The label of each triangle, and the number of runs that leave the lattice, and of places in
    two runs.
    """
    n_row, n_col = max(a[N_ROW] - 1, 0), max(a[N_COL] - 1, 0)
    label = np.full(2 * n_row * n_col, -1, dtype=np.int64)
    flip = 1 if a[RISING] == 1 else 0
    n_bad = 0
    for i in range(runs.shape[0]):
        row, first, last = runs[i, ROW], runs[i, FIRST], runs[i, LAST]
        if row < 0 or row >= n_row or first < 0 or last >= 2 * n_col or last < first:
            n_bad += 1
            continue
        start = 2 * row * n_col
        for place in range(first, last + 1):
            key = start + (place ^ flip)
            if label[key] >= 0:
                n_bad += 1
            label[key] = i
    return label, n_bad


@entry("d1 d1 d1 l1 l2 -> l")
def count_unusable(p, q, r, a, runs):
    """How many coordinates of the nodes of runs are infinite or not a number."""
    flip = 1 if a[RISING] == 1 else 0
    n_bad = 0
    for i in range(runs.shape[0]):
        row, first, last = runs[i, ROW], runs[i, FIRST], runs[i, LAST]

        # the nodes of its triangles, row by row: a half cell at an end has one node of one row
        for k in range(2):
            left, right = first >> 1, (last >> 1) + 1
            if first & 1 and k == flip:
                left += 1
            if not last & 1 and k == 1 - flip:
                right -= 1
            n_bad += _bad_numbers(p, a, 0, row + k, left, right)
            n_bad += _bad_numbers(q, a, 1, row + k, left, right)
            n_bad += _bad_numbers(r, a, 2, row + k, left, right)
    return n_bad


@entry("l1 l2 b1* -> .")
def mark_runs(a, runs, marks):
    """Mark the triangles of runs, by key."""
    width = 2 * (a[N_COL] - 1)
    flip = 1 if a[RISING] == 1 else 0
    for i in range(runs.shape[0]):
        start = runs[i, ROW] * width
        for place in range(runs[i, FIRST], runs[i, LAST] + 1):
            marks[start + (place ^ flip)] = True


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
def two_sum(out, i, k, term):
    """Add a term to the pair of numbers at out[i, k]; the second collects rounding errors."""
    total = out[i, k] + term
    back = total - out[i, k]
    out[i, k + 1] += (out[i, k] - (total - back)) + (term - back)
    out[i, k] = total


@scalar
def _load_side(p, q, r, a, origin, row, col, cell, low, high):
    """Load the nodes of a column in two rows as corners of a cell, local."""
    for k in range(2):
        corner = low if k == 0 else high
        cell[corner, 0] = load(p, a, 0, row + k, col) - origin[0]
        cell[corner, 1] = load(q, a, 1, row + k, col) - origin[1]
        cell[corner, 2] = load(r, a, 2, row + k, col) - origin[2]


@scalar
def _add_sums(c, level, sign, i, out):
    """Add a triangle to row i of the sums, if that is not below 0; twice its area, and its sides.

    The area of a triangle that lacks a node is not a number.
    """
    ux, uy, uz = c[1, 0] - c[0, 0], c[1, 1] - c[0, 1], c[1, 2] - c[0, 2]
    vx, vy, vz = c[2, 0] - c[0, 0], c[2, 1] - c[0, 1], c[2, 2] - c[0, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    area = np.sqrt(nx * nx + ny * ny + nz * nz)
    u, v = abs(ux) + abs(uy) + abs(uz), abs(vx) + abs(vy) + abs(vz)
    around = u + v + abs(ux - vx) + abs(uy - vy) + abs(uz - vz)
    if i < 0 or not area == area:
        return area, around
    height = (c[0, 2] - level) + (c[1, 2] - level) + (c[2, 2] - level)
    two_sum(out, i, 0, sign * nz * height)
    two_sum(out, i, 2, area)
    out[i, 4] += u * v
    out[i, 5] += around
    out[i, 6] += sign * nz
    out[i, 7] += 1.0
    for k in range(3):
        out[i, 8 + k] = min(out[i, 8 + k], min(c[0, k], min(c[1, k], c[2, k])))
        out[i, 11 + k] = max(out[i, 11 + k], max(c[0, k], max(c[1, k], c[2, k])))
    return area, around


@entry("d1 d1 d1 l1 l1 d1 d d2* d2* -> .")
def sums_of_runs(p, q, r, a, label, origin, level, out, rest):
    """Add to the rows of runs (n_run, 14) the sums over their triangles; to `rest` (1, 3) twice the
    area (two numbers) and all sides of the triangles without a label, which exist.

    Columns: six times the volume over a level (two numbers), twice the area (two numbers), products
    of two sides, all sides (both in the norm of absolute values), twice the area in the map, the
    number of triangles, lower and upper corner. Volume and area in the map are below 0 where
    normals look down.
    """
    sign = -1.0 if a[TURNED] != 0 else 1.0
    n_row, n_col = max(a[N_ROW] - 1, 0), max(a[N_COL] - 1, 0)
    c, cell = np.empty((3, 3)), np.empty((4, 3))
    for row in range(n_row):
        _load_side(p, q, r, a, origin, row, 0, cell, 1, 2)
        for col in range(n_col):
            # corners 0, 1, 2, 3 around the cell: 0 and 3 are 1 and 2 of the one before
            for k in range(3):
                cell[0, k], cell[3, k] = cell[1, k], cell[2, k]
            _load_side(p, q, r, a, origin, row, col + 1, cell, 1, 2)
            for half in range(2):
                i = label[2 * (row * n_col + col) + half]
                # 0 1 2 + 0 2 3, or 0 1 3 + 1 2 3
                first = 1 if half == 1 and a[RISING] == 0 else 0
                third = 2 if half == 0 and a[RISING] == 1 else 3
                for k in range(3):
                    c[0, k], c[1, k], c[2, k] = cell[first, k], cell[1 + half, k], cell[third, k]
                area, around = _add_sums(c, level, sign, i, out)
                if i < 0 and area == area:
                    two_sum(rest, 0, 0, area)
                    rest[0, 2] += around


@scalar
def _add_edges(sides, one, two, n, counts):
    """Count n edges between two triangles of a lattice, by their labels, for the units around."""
    if one < 0 and two < 0:
        return
    if one >= 0 and two >= 0:
        front, behind = sides[one, 0], sides[one, 1]
        if front == sides[two, 0] and behind == sides[two, 1]:
            if front != behind:
                if front >= 0:
                    counts[front, EDGES] += n
                if behind >= 0:
                    counts[behind, EDGES] += n
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
            counts[unit, EDGES] += n
            counts[unit, OPEN] += n * abs(balance)


@scalar
def _add_nodes(around, sides, n, counts):
    """Count n nodes for each unit that has a triangle around them; n if there is one, else 0."""
    used = 0
    for k in range(6):
        of = around[k]
        if of < 0 or sides[of, 0] == sides[of, 1]:
            continue
        for s in range(2):
            unit = sides[of, s]
            if unit < 0:
                continue

            # each unit once, whichever of the triangles it has
            seen = False
            for m in range(k):
                before = around[m]
                if before >= 0 and sides[before, 0] != sides[before, 1]:
                    seen = seen or sides[before, 0] == unit or sides[before, 1] == unit
            if not seen:
                counts[unit, VERTICES] += n
            used = n
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


@scalar
def _add_around_node(a, label, shared, sides, i, j, around, counts, pairs, n_pair):
    """Count a private node, and the private edges to the next ones; as `count_private` returns."""
    n_row, n_col = a[N_ROW], a[N_COL]
    node = i * n_col + j
    right, left = (1, 0) if a[RISING] == 1 else (0, 1)
    n_used = 0
    if not shared[node]:
        _labels_around(a, label, i, j, around)
        n_used = _add_nodes(around, sides, 1, counts)

        # The edges to the next node of the row, and to the next row.
        if j + 1 < n_col and not shared[node + 1]:
            one, two = _label(a, label, i - 1, j, 1), _label(a, label, i, j, 0)
            _add_edges(sides, one, two, 1, counts)
            pairs, n_pair = _add_joined(one, two, pairs, n_pair)
        if i + 1 < n_row and not shared[node + n_col]:
            one, two = _label(a, label, i, j, right), _label(a, label, i, j - 1, left)
            _add_edges(sides, one, two, 1, counts)
            pairs, n_pair = _add_joined(one, two, pairs, n_pair)

    # The diagonal of the cell that begins here joins corners 0 and 3, or 1 and 2.
    if i + 1 < n_row and j + 1 < n_col:
        start = node + (0 if a[RISING] == 1 else 1)
        stop = node + n_col + (1 if a[RISING] == 1 else 0)
        if not shared[start] and not shared[stop]:
            one, two = _label(a, label, i, j, 0), _label(a, label, i, j, 1)
            _add_edges(sides, one, two, 1, counts)
            pairs, n_pair = _add_joined(one, two, pairs, n_pair)
    return n_used, pairs, n_pair


@scalar
def _alike_from(label, shared, n_col, i, j):
    """How many nodes of a row, from node j on, have one label on each side of the row.

    All that is counted with such a node is private, and lies in the cells above and below that end
    or begin there. 0 for the first and last row and column.
    """
    n = 0
    above, below = 2 * (i * (n_col - 1) + j), 2 * ((i - 1) * (n_col - 1) + j)
    one, two = label[above], label[below]
    node = i * n_col + j
    if label[above - 2] != one or label[above - 1] != one:
        return 0
    if label[below - 2] != two or label[below - 1] != two:
        return 0
    while j + n < n_col - 1:
        at, other = above + 2 * n, below + 2 * n
        alike = label[at] == one and label[at + 1] == one
        alike = alike and label[other] == two and label[other + 1] == two
        if not alike or shared[node + n] or shared[node + n + n_col]:
            break
        if shared[node + n + 1] or shared[node + n + n_col + 1]:
            break
        n += 1
    return n


@entry("l1 l1 b1 l2 l l l2* -> l l2")
def count_private(a, label, shared, sides, first, last, counts):
    """Add private nodes and edges of some rows of nodes (first, last) to the counts of units; the
    number of nodes of shells, and pairs of runs with a common private edge.

    An edge belongs to the row of its lower node.
    """
    n_row, n_col = a[N_ROW], a[N_COL]
    around = np.empty(6, dtype=np.int64)
    pairs, n_pair = np.empty((1024, 2), dtype=np.int64), 0
    n_used = 0
    for i in range(first, last + 1):
        j = 0
        while j < n_col:
            # Nearly all nodes: a run above the row, and one below it.
            n = 0
            if 0 < i < n_row - 1 and 0 < j < n_col - 1:
                n = _alike_from(label, shared, n_col, i, j)
            if n == 0:
                more, pairs, n_pair = _add_around_node(
                    a, label, shared, sides, i, j, around, counts, pairs, n_pair
                )
                n_used += more
                j += 1
                continue
            one = label[2 * (i * (n_col - 1) + j)]
            two = label[2 * ((i - 1) * (n_col - 1) + j)]
            around[:3], around[3:] = one, two
            n_used += _add_nodes(around, sides, n, counts)
            _add_edges(sides, two, one, n, counts)
            _add_edges(sides, one, one, 2 * n, counts)
            pairs, n_pair = _add_joined(two, one, pairs, n_pair)
            j += n
    return n_used, pairs[:n_pair].copy()


@entry("l2 d2 d2* -> .")
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
                two_sum(out, unit, 0, sign * sums[i, part])
                two_sum(out, unit, 2, sums[i, 2 + part])
            out[unit, 4] += sums[i, 4]
            out[unit, 5] += sums[i, 7]


# ---- run blocks ----------------------------------------
# Blocks of cells of a lattice whose triangles are all of one kind, from its runs.
#
# A picture draws two triangles for each of them. Intervals of equal kinds in the rows of a block
# are intersected, so the cost is that of runs and blocks, not of cells.
#
# Notation runs, start   as in `geosurf.kernels.lattices.strips` kind          of each run, 0 for
# those that are left out sizes         cells along the side of blocks; each is twice the next one
# blocks        row of `sizes`, first row and column of cells, and kind of each block fine
# row, place and kind of each triangle that no block has found, at     intervals (first and last
# place, kind) of some rows, and the first one of each row taken         whether each block of one
# size, in these rows, has one kind


OF = 2  # column of intervals: kind


@scalar
def _list_intervals(runs, start, kind, top, end, found, at):
    """List the intervals of some rows; runs of one kind that follow each other are one."""
    at[0] = 0
    for row in range(top, end):
        n = begin = at[row - top]
        for i in range(start[row], start[row + 1]):
            if kind[i] == 0:
                continue
            if n > begin and found[n - 1, OF] == kind[i] and found[n - 1, 1] + 1 == runs[i, FIRST]:
                found[n - 1, 1] = runs[i, LAST]
                continue
            found[n, 0], found[n, 1], found[n, OF] = runs[i, FIRST], runs[i, LAST], kind[i]
            n += 1
        at[row - top + 1] = n


@scalar
def _intersect(room, now, n, found, low, high):
    """Write what n intervals and those from `low` to `high` - 1 have in common; how many.

    The intervals are in columns `now` to ``now + 2`` of `room`, and the result in the other three.
    """
    then = 3 - now
    k, j, m = 0, low, 0
    while k < n and j < high:
        first, last = max(room[k, now], found[j, 0]), min(room[k, now + 1], found[j, 1])
        if first <= last and room[k, now + OF] == found[j, OF]:
            room[m, then], room[m, then + 1], room[m, then + OF] = first, last, found[j, OF]
            m += 1
        if room[k, now + 1] < found[j, 1]:
            k += 1
        else:
            j += 1
    return m


@scalar
def _take(found, at, first_row, size, width, room, taken, larger, level, top, blocks, n_block):
    """Take the blocks of one size in one row of blocks; return the number of all blocks.

    `first_row` counts from `top`; `larger` are the blocks of twice the size, empty if there are
    none.
    """
    n, now = at[first_row + 1] - at[first_row], 0
    for q in range(n):
        for k in range(3):
            room[q, k] = found[at[first_row] + q, k]
    for row in range(first_row + 1, first_row + size):
        n = _intersect(room, now, n, found, at[row], at[row + 1])
        now = 3 - now
    i = first_row // size
    for q in range(n):
        low = (room[q, now] + 2 * size - 1) // (2 * size)
        for col in range(low, min((room[q, now + 1] + 1) // (2 * size), width)):
            taken[i, col] = True
            inside = i // 2 < larger.shape[0] and col // 2 < larger.shape[1]
            if inside and larger[i // 2, col // 2]:
                continue
            if n_block < blocks.shape[0]:
                blocks[n_block, 0], blocks[n_block, 1] = level, top + first_row
                blocks[n_block, 2], blocks[n_block, 3] = col * size, room[q, now + OF]
            n_block += 1
    return n_block


@scalar
def _list_rest(found, at, n_row, size, taken, top, fine, n_fine):
    """List the triangles of some rows that no block has; return the number of all."""
    for row in range(n_row):
        i = row // size
        for q in range(at[row], at[row + 1]):
            place = found[q, 0]
            while place <= found[q, 1]:
                col = place // (2 * size)
                if i < taken.shape[0] and col < taken.shape[1] and taken[i, col]:
                    place = 2 * size * (col + 1)
                    continue
                if n_fine < fine.shape[0]:
                    fine[n_fine, 0], fine[n_fine, 1] = top + row, place
                    fine[n_fine, 2] = found[q, OF]
                n_fine += 1
                place += 1
    return n_fine


@entry("l2 l1 l1 l1 l l l2* l2* -> l l")
def find_blocks(runs, start, kind, sizes, n_row, n_col, blocks, fine):
    """Write all blocks, the largest ones that fit, and triangles beside them, while there is room.

    `n_row` and `n_col` count cells. Returns the numbers of both; they are counted on without room.
    """
    most, longest = sizes[0], 0
    for top in range(0, n_row, most):
        longest = max(longest, start[min(top + most, n_row)] - start[top])
    found = np.empty((longest, 3), dtype=np.int64)
    room = np.empty((longest, 6), dtype=np.int64)
    at = np.empty(most + 1, dtype=np.int64)

    n_block, n_fine = 0, 0
    for top in range(0, n_row, most):
        n_here = min(most, n_row - top)
        _list_intervals(runs, start, kind, top, top + n_here, found, at)
        larger = np.zeros((0, 0), dtype=np.bool_)
        for level in range(sizes.shape[0]):
            size = sizes[level]
            taken = np.zeros((n_here // size, n_col // size), dtype=np.bool_)
            for i in range(n_here // size):
                n_block = _take(
                    found, at, i * size, size, n_col // size, room, taken, larger, level, top,
                    blocks, n_block,
                )  # fmt: skip
            larger = taken
        n_fine = _list_rest(found, at, n_here, sizes[sizes.shape[0] - 1], larger, top, fine, n_fine)
    return n_block, n_fine
