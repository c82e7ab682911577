"""The triangles of a lattice that no curve touches: runs, row by row, without a list of triangles.

The triangles of one row of cells form a strip, each sharing an edge with the next. A triangle has a
place in it: ``2 * col + half`` where diagonals fall, ``2 * col + 1 - half`` where they rise.
Removed triangles (cut, or touched by a curve) and missing ones divide a strip into runs; runs of
neighbouring rows that share an edge are joined. A lattice of a million triangles has a few
thousand runs, and its patches, sides and volumes follow from those.

Notation
    a        layout, as in `tree`
    keys     removed triangles (``2 * cell + half``), increasing
    absent   gaps: places without a triangle. First where the gaps of each row begin in this array,
             (n_row,) with the end, then first and last place of each; empty if there are none
    runs     int64 (n_run, 4): row, first place, last place, and 1 if the run is at the boundary
    start    int64 (n_row + 1,): first run of each row
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.search.tree import N_COL, N_ROW, RISING

ROW, FIRST, LAST, RIM = 0, 1, 2, 3


@scalar
def key_at(a, row, place):
    """Key of the triangle at a place of a strip."""
    half = place % 2 if a[RISING] == 0 else 1 - place % 2
    return 2 * (row * (a[N_COL] - 1) + place // 2) + half


@scalar
def _place_of(a, key):
    """Place of a triangle in its strip."""
    col = (key >> 1) % (a[N_COL] - 1)
    half = key & 1
    return 2 * col + (half if a[RISING] == 0 else 1 - half)


@scalar
def _across(a, row, place):
    """Row and place of the triangle that shares the edge along the rows."""
    half = place % 2 if a[RISING] == 0 else 1 - place % 2

    # The neighbour is in the same column of its row, in the other half of its cell.
    # half 0 has the lower edge, half 1 the upper one, with either diagonal
    other = place + 1 if place % 2 == 0 else place - 1
    return (row - 1 if half == 0 else row + 1), other


@scalar
def _is_missing(a, absent, row, place):
    """Whether there is no triangle: outside the lattice, or without its nodes."""
    if row < 0 or row >= a[N_ROW] - 1 or place < 0 or place >= 2 * (a[N_COL] - 1):
        return True
    if absent.shape[0] == 0:
        return False
    gap = _gap_from(absent, row, place)
    return gap < absent[row + 1] and absent[gap] <= place


@scalar
def _gap_from(absent, row, place):
    """Where the first gap of a row is that does not end before a place."""
    low, high = absent[row] // 2, absent[row + 1] // 2
    odd = absent[row] % 2
    while low < high:
        middle = (low + high) // 2
        if absent[2 * middle + odd + 1] < place:
            low = middle + 1
        else:
            high = middle
    return 2 * low + odd


@scalar
def _misses_across(a, absent, row, first, last, parity):
    """Whether a place of one parity between two others has no triangle across the rows."""
    half = parity if a[RISING] == 0 else 1 - parity
    first += (first + parity) % 2
    last -= (last + parity) % 2
    if first > last:
        return False
    other = row - 1 if half == 0 else row + 1
    if other < 0 or other >= a[N_ROW] - 1:
        return True
    if absent.shape[0] == 0:
        return False

    # across an even place is the odd one after it, across an odd place the even one before
    step = 1 - 2 * parity
    gap = _gap_from(absent, other, first + step)
    while gap < absent[other + 1] and absent[gap] <= last + step:
        begin = max(first + step, absent[gap])
        begin += (begin + parity + 1) % 2
        if begin <= min(last + step, absent[gap + 1]):
            return True
        gap += 2
    return False


@scalar
def _is_at_boundary(a, absent, row, first, last):
    """Whether a run has an edge that no other triangle of the surface shares."""
    if _is_missing(a, absent, row, first - 1) or _is_missing(a, absent, row, last + 1):
        return True

    # Neighbours in the strip were tested; now those across the rows.
    for parity in range(2):
        if _misses_across(a, absent, row, first, last, parity):
            return True
    return False


@scalar
def _add_run(a, absent, runs, n, row, first, last):
    """Write a run while there is capacity; the number of runs."""
    # Beyond the capacity runs are only counted: the caller repeats with larger arrays.
    if n < runs.shape[0]:
        runs[n, ROW], runs[n, FIRST], runs[n, LAST] = row, first, last
        runs[n, RIM] = 1 if _is_at_boundary(a, absent, row, first, last) else 0
    return n + 1


@scalar
def _runs_of_row(a, absent, row, taken, n_taken, runs, n):
    """Runs between the removed places (sorted) of a strip."""
    first = 0
    width = 2 * (a[N_COL] - 1)
    gap, end = 0, 0
    if absent.shape[0] > 0:
        gap, end = absent[row], absent[row + 1]

    # The last turn takes what follows the last removed place.
    for k in range(n_taken + 1):
        # Between two removed places, gaps divide runs further; no removed place is in a gap.
        stop = taken[k] if k < n_taken else width
        while gap < end and absent[gap] < stop:
            if absent[gap] > first:
                n = _add_run(a, absent, runs, n, row, first, absent[gap] - 1)
            first = absent[gap + 1] + 1
            gap += 2
        if stop > first:
            n = _add_run(a, absent, runs, n, row, first, stop - 1)
        first = stop + 1
    return n


@scalar
def _add_gap(gaps, n, begin, first, last):
    """Write a gap, joined to the one before in its row if they meet; the new length."""
    if n > begin and first <= gaps[n - 1] + 1:
        gaps[n - 1] = max(gaps[n - 1], last)
        return n
    gaps[n], gaps[n + 1] = first, last
    return n + 2


@entry("l l b l1 l2 -> l1")
def gaps_of_holes(n_row, n_col, rising, start, holes):
    """The gaps (`absent`) of a lattice with holes: row, first and last column of absent nodes."""
    gaps = np.zeros(n_row + 4 * holes.shape[0], dtype=np.int64)
    n = n_row
    gaps[0] = n
    width = 2 * (n_col - 1)
    for row in range(n_row - 1):
        begin = n
        i, j = start[row], start[row + 1]

        # Nodes of the lower row take out other places than those of the upper row.
        while i < start[row + 1] or j < start[row + 2]:
            low, high = 2 * width, 2 * width
            if i < start[row + 1]:
                low = 2 * holes[i, 1] - (1 if rising else 2)
            if j < start[row + 2]:
                high = 2 * holes[j, 1] - (2 if rising else 1)
            if low <= high:
                first, last = low, 2 * holes[i, 2] + (1 if rising else 0)
                i += 1
            else:
                first, last = high, 2 * holes[j, 2] + (0 if rising else 1)
                j += 1
            first, last = max(first, 0), min(last, width - 1)
            if first <= last:
                n = _add_gap(gaps, n, begin, first, last)
        gaps[row + 1] = n
    return gaps[:n].copy()


@entry("l1 l1 l1 l2* -> l1 l")
def find_runs(a, keys, absent, runs):
    """Fill `runs` up to capacity; start of each row, and the number of runs."""
    n_row = max(a[N_ROW] - 1, 0)
    start = np.zeros(n_row + 1, dtype=np.int64)
    taken = np.empty(2 * max(a[N_COL] - 1, 1), dtype=np.int64)
    n = 0
    p = 0
    for row in range(n_row):
        count = 0

        # Removed places of this row, sorted by insertion.
        # Keys are increasing, so those of one row are adjacent.
        while p < keys.shape[0] and (keys[p] >> 1) // (a[N_COL] - 1) == row:
            place = _place_of(a, keys[p])
            k = count  # halves of one cell may come in the other order
            while k > 0 and taken[k - 1] > place:
                taken[k] = taken[k - 1]
                k -= 1
            taken[k] = place
            count += 1
            p += 1
        n = _runs_of_row(a, absent, row, taken, count, runs, n)
        start[row + 1] = n
    return start, n


@scalar
def _columns(a, runs, i, half):
    """First and last column of the triangles of one half in a run; (1, 0) if none."""
    parity = half if a[RISING] == 0 else 1 - half
    first = (runs[i, FIRST] - parity + 1) // 2
    last = (runs[i, LAST] - parity) // 2
    return first, last


@entry("l1 l2 l1 -> l2")
def join_runs(a, runs, start):
    """Pairs of runs of neighbouring rows that share an edge."""
    # The merge below ends a run with each step, and a run takes part in two merges.
    pairs = np.empty((2 * runs.shape[0] + 1, 2), dtype=np.int64)
    n = 0
    for row in range(start.shape[0] - 2):
        i, j = start[row], start[row + 1]

        # Two sorted lists of runs: compare column ranges, advance the one that ends first.
        while i < start[row + 1] and j < start[row + 2]:
            # Half 1 of this row has its edge above, half 0 of the next row has that edge below.
            upper_first, upper_last = _columns(a, runs, i, 1)
            lower_first, lower_last = _columns(a, runs, j, 0)
            if max(upper_first, lower_first) <= min(upper_last, lower_last):
                pairs[n, 0], pairs[n, 1] = i, j
                n += 1
            if upper_last < lower_last:
                i += 1
            elif lower_last < upper_last:
                j += 1
            elif runs[i, LAST] <= runs[j, LAST]:
                i += 1
            else:
                j += 1
    return pairs[:n].copy()


@scalar
def run_of_key(a, runs, start, key):
    """The run that holds a triangle; -1 if none does."""
    row = (key >> 1) // (a[N_COL] - 1)
    if row >= start.shape[0] - 1:  # a triangle of a torn sheet at a fault
        return -1
    place = _place_of(a, key)

    # Bisection among the runs of the row.
    low, high = start[row], start[row + 1]
    while low < high:  # the first run that ends at or behind the place
        middle = (low + high) // 2
        if runs[middle, LAST] < place:
            low = middle + 1
        else:
            high = middle
    return low if low < start[row + 1] and runs[low, FIRST] <= place else -1


@entry("l1 l2 l1 l1 -> l1")
def runs_of_keys(a, runs, start, keys):
    """The run that holds each triangle; -1 if none does."""
    out = np.empty(keys.shape[0], dtype=np.int64)
    for k in range(keys.shape[0]):
        out[k] = run_of_key(a, runs, start, keys[k])
    return out


@scalar
def key_across(a, absent, turned, key, edge):
    """The triangle on the other side of an edge of a triangle; -1 if none."""
    row = (key >> 1) // (a[N_COL] - 1)
    place = _place_of(a, key)
    start, end = edge, (edge + 1) % 3

    # Corners 1 and 2 are exchanged in a turned lattice.
    if turned:
        start, end = (3 - start) % 3, (3 - end) % 3
    i, j = corner_of(a, key, start)
    u, v = corner_of(a, key, end)

    # An edge along the rows, at the side of the cell, or the diagonal.
    if i == u:
        row, place = _across(a, row, place)
    elif j == v:  # the edge at the side of the cell
        place += 1 if j > place // 2 else -1
    else:  # the diagonal
        place += 1 if place % 2 == 0 else -1
    return -1 if _is_missing(a, absent, row, place) else key_at(a, row, place)


@entry("l1 l1 b l1 l1 -> l1")
def keys_across(a, absent, turned, keys, edge):
    """The triangle on the other side of an edge of each triangle; -1 if none.

    Edge k joins corner k to the next; a turned lattice has its corners 1 and 2 exchanged.
    """
    out = np.empty(keys.shape[0], dtype=np.int64)
    for k in range(keys.shape[0]):
        out[k] = key_across(a, absent, turned, keys[k], edge[k])
    return out


@entry("l1 l2 -> l1")
def lowest_keys(a, runs):
    """The lowest key in each run."""
    out = np.empty(runs.shape[0], dtype=np.int64)
    for i in range(runs.shape[0]):
        # The first or second place of a run has its lowest key.
        low = key_at(a, runs[i, ROW], runs[i, FIRST])
        if runs[i, LAST] > runs[i, FIRST]:
            low = min(low, key_at(a, runs[i, ROW], runs[i, FIRST] + 1))
        out[i] = low
    return out


@scalar
def corner_of(a, key, corner):
    """Row and column of a corner of a triangle, before it is turned."""
    cell = key >> 1
    half = key & 1
    row, col = cell // (a[N_COL] - 1), cell % (a[N_COL] - 1)
    # corners 0, 1, 2, 3 around the cell: 0 1 2 + 0 2 3, or 0 1 3 + 1 2 3
    # `at` counts the corners around the cell: 0 lower left, 1 lower right, 2 upper right, 3 upper
    # left.
    if corner == 0:
        at = 1 if half == 1 and a[RISING] == 0 else 0
    elif corner == 1:
        at = 2 if half == 1 else 1
    else:
        at = 2 if half == 0 and a[RISING] == 1 else 3
    return row + (1 if at >= 2 else 0), col + (1 if at == 1 or at == 2 else 0)


@scalar
def load(values, a, axis, i, j):
    """A coordinate of a node."""
    return values[a[3 * axis] + i * a[3 * axis + 1] + j * a[3 * axis + 2]]


# ---- strip links ----------------------------------------
# What lies behind the edges of listed triangles of a lattice: runs that no curve touches.
#
# Letters as in `strips`; half-edge 3 * i + c of triangle i runs from corner c to the next.


NONE = -1  # of `link`: the rim of the lattice


@scalar
def _whole_edge(corners, number, face, start, end):
    """The edge of a face that runs between two points; -1 if none does."""
    for k in range(3):
        if number[corners[face, k]] == start and number[corners[face, (k + 1) % 3]] == end:
            return k
    return -1


@entry("l2 l1 l1 l1 l l l2 l1 l1 l1 b l2 l1 l l1* -> l l2")
def link_runs(
    t, key, face, ring, low, high, corners, number, a, absent, turned, runs, start,
    first_run, link,
):  # fmt: skip
    """Write the run behind each half-edge that is alone, of `low` to `high` - 1.


    `face` is the row of `corners` that each triangle is a part of, and `number` the point of each
    corner. Returns a triangle that has no neighbour although its edge is inside the lattice, or -1;
    and the half-edges (n, 2) with the runs behind them.
    """
    linked, n = np.empty((1024, 2), dtype=np.int64), 0
    for h in range(low, high):
        if ring[h] != h:
            continue
        i, c = h // 3, h % 3
        # at the rim of a torn sheet, past a fault: keys of its copies follow the lattice's
        if key[i] >= 2 * (a[N_ROW] - 1) * (a[N_COL] - 1):
            continue
        # a triangle in no contact, next to a gap, is whole
        edge = c
        if face[i] >= 0:
            edge = _whole_edge(corners, number, face[i], t[i, c], t[i, (c + 1) % 3])
        if edge < 0:
            # a part of an edge: of the rim, or its neighbour would be cut, too
            behind = 0
            for k in range(3):
                behind = min(behind, key_across(a, absent, turned, key[i], k))
            if behind >= 0:
                return i, linked[:0].copy()
            continue

        # the triangle behind is in a run; otherwise the mesh would have a gap
        behind = key_across(a, absent, turned, key[i], edge)
        if behind >= 0:
            run = run_of_key(a, runs, start, behind)
            if run < 0:
                return i, linked[:0].copy()
            if n == linked.shape[0]:
                more = np.empty((2 * n, 2), dtype=np.int64)
                more[:n] = linked
                linked = more
            link[h] = first_run + run
            linked[n, 0], linked[n, 1] = h, link[h]
            n += 1
    return NONE, linked[:n].copy()
