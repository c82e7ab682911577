"""Sums of products of columns, in row order: the same bits with any number of cores.

A multithreaded matrix library adds in an order that depends on the number of threads, and its
threads synchronise for longer than matrices of a few columns take.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry


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
