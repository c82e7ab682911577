"""Blocks of cells of a lattice whose triangles are all of one kind, from its runs.

A picture draws two triangles for each of them. Intervals of equal kinds in the rows of a block are
intersected, so the cost is that of runs and blocks, not of cells.

Notation
    runs, start   as in `geosurf.kernels.lattices.strips`
    kind          of each run, 0 for those that are left out
    sizes         cells along the side of blocks; each is twice the next one
    blocks        row of `sizes`, first row and column of cells, and kind of each block
    fine          row, place and kind of each triangle that no block has
    found, at     intervals (first and last place, kind) of some rows, and the first one of each row
    taken         whether each block of one size, in these rows, has one kind
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.lattices.strips import FIRST, LAST

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
