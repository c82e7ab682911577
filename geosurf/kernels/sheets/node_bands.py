"""Bands of lattice nodes, in increasing order, without the whole lattice.

Node = row * n_col + column. The cost is proportional to the nodes of the band.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar

# ---- column products ----------------------------------------
# Sums of products of columns, in row order: the same bits with any number of cores.
#
# A multithreaded matrix library adds in an order that depends on the number of threads, and its
# threads synchronise for longer than matrices of a few columns take.


@entry("d2 d2 -> d2")
def products_of_columns(a, b):
    """Sum over all rows of each column of `a` (n, k) times each column of `b` (n, m): (k, m)."""
    n, k = a.shape
    m = b.shape[1]
    out = np.zeros((k, m))
    # Rows in order: each sum has one order of additions.
    for row in range(n):
        for i in range(k):
            w = a[row, i]
            for j in range(m):
                out[i, j] += w * b[row, j]
    return out


@entry("d2 d1 -> d1")
def sums_of_columns(a, share):
    """Sum (n,) of the columns of `a` (n, k), each multiplied by `share` (k,)."""
    n, k = a.shape
    out = np.zeros(n)
    # One pass over memory; columns of a row are adjacent.
    for row in range(n):
        total = 0.0
        for i in range(k):
            total += a[row, i] * share[i]
        out[row] = total
    return out


@entry("d2 d2 d d -> d1 l1 l1 l1")
def boxes_in_blocks(low, high, reach, size):
    """List boxes by the blocks of some size that they come within reach of.

    Parameters
    ----------
    low, high : float64 (n_box, 2)

    Returns
    -------
    corner : float64 (2,)
        The first block, counted from that at 0.
    shape : int64 (2,)
    items : int64 (n_item,)
        Boxes of the blocks, row by row; those of a block rise.
    starts : int64 (n_block + 1,)
    """
    n = low.shape[0]
    corner, last = np.empty(2), np.empty(2)
    for c in range(2):
        least, most = np.inf, -np.inf
        for k in range(n):
            if low[k, c] > high[k, c] or not np.isfinite(high[k, c] - low[k, c]):
                raise ValueError("a box has no size")
            least, most = min(least, low[k, c]), max(most, high[k, c])
        if n == 0:
            raise ValueError("no boxes are given")
        corner[c] = np.floor((least - reach) / size)
        last[c] = np.floor((most + reach) / size)
    shape = np.empty(2, dtype=np.int64)
    for c in range(2):
        shape[c] = int(last[c] - corner[c] + 1.0)
    a, b = np.empty((n, 2), dtype=np.int64), np.empty((n, 2), dtype=np.int64)
    starts = np.zeros(shape[0] * shape[1] + 1, dtype=np.int64)
    for k in range(n):
        for c in range(2):
            a[k, c] = int(np.floor((low[k, c] - reach) / size) - corner[c])
            b[k, c] = int(np.floor((high[k, c] + reach) / size) - corner[c])
        for y in range(a[k, 1], b[k, 1] + 1):
            for x in range(a[k, 0], b[k, 0] + 1):
                starts[y * shape[0] + x + 1] += 1
    for at in range(1, starts.shape[0]):
        starts[at] += starts[at - 1]

    # box by box: so those of a block rise
    items, free = np.empty(starts[starts.shape[0] - 1], dtype=np.int64), starts.copy()
    for k in range(n):
        for y in range(a[k, 1], b[k, 1] + 1):
            for x in range(a[k, 0], b[k, 0] + 1):
                at = y * shape[0] + x
                items[free[at]] = k
                free[at] += 1
    return corner, shape, items, starts


@scalar
def _widened(first, last, n, low, high, reach):
    """Widen runs first[k] .. last[k] by reach, clip to low .. high, join them; their number."""
    m = 0
    for k in range(n):
        a, b = max(first[k] - reach, low), min(last[k] + reach, high)

        # Join runs that touch after widening.
        if m > 0 and a <= last[m - 1] + 1:
            last[m - 1] = max(last[m - 1], b)
        else:
            first[m], last[m] = a, b
            m += 1
    return m


@entry("l1 l l l -> l1")
def dilate_nodes(nodes, n_row, n_col, reach):
    """Nodes within some rows and columns of given increasing nodes, increasing."""
    n = nodes.shape[0]
    first, last = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    start = np.full(n_row + 1, n, dtype=np.int64)

    # Runs of each row, widened along the row.
    m = k = 0
    for row in range(n_row):
        start[row] = m
        runs = 0
        while k < n and nodes[k] < (row + 1) * n_col:
            # Adjacent nodes make one run.
            if runs > 0 and last[m + runs - 1] + 1 == nodes[k]:
                last[m + runs - 1] = nodes[k]
            else:
                first[m + runs] = last[m + runs] = nodes[k]
                runs += 1
            k += 1
        m += _widened(first[m:], last[m:], runs, row * n_col, (row + 1) * n_col - 1, reach)
    start[n_row] = m

    # Each row: union of the runs of rows within reach, by a difference array.
    mark = np.zeros(n_col + 1, dtype=np.int64)
    out = np.empty(max(16, 2 * n), dtype=np.int64)
    count = 0
    for row in range(n_row):
        low, high = max(row - reach, 0), min(row + reach, n_row - 1)
        a, b = n_col, 0
        for other in range(low, high + 1):
            for run in range(start[other], start[other + 1]):
                c, d = first[run] - other * n_col, last[run] - other * n_col + 1
                # A run adds 1 from its first column on, and takes it back behind its last.
                mark[c] += 1
                mark[d] -= 1
                a, b = min(a, c), max(b, d)
        inside = 0
        if count + n_col > out.shape[0]:
            out = np.concatenate((out, np.empty(out.shape[0] + n_col, dtype=np.int64)))
        for col in range(a, b + 1):
            inside += mark[col]
            # Clear for the next row what this one has set.
            mark[col] = 0
            if inside > 0:
                out[count] = row * n_col + col
                count += 1
    return out[:count].copy()
