"""A sparse matrix from the slots of `bending` to rows, and to the envelope that is factorised."""

from __future__ import annotations

import numpy as np

from geosurf.kernels._jit import entry


@entry("d2 l2 -> l1 l1 d1")
def rows_of_slots(matrix, column):
    """Start of each row (n + 1,), columns and values, in the order of the slots; -1 is empty."""
    n, m = column.shape
    start = np.zeros(n + 1, dtype=np.int64)
    for i in range(n):
        count = 0
        for s in range(m):
            if column[i, s] >= 0:
                count += 1
        start[i + 1] = start[i] + count
    columns, values = np.empty(start[n], dtype=np.int64), np.empty(start[n])
    at = 0
    for i in range(n):
        for s in range(m):
            if column[i, s] >= 0:
                columns[at], values[at] = column[i, s], matrix[i, s]
                at += 1
    return start, columns, values


@entry("l1 l1 d1 l1 -> l1 d1 l1")
def envelope_of(start, columns, values, place):
    """First column of each row, lower rows without gaps, where they start; `place` reorders."""
    n = place.shape[0]
    first = np.arange(n)
    for i in range(n):
        p = place[i]
        for at in range(start[i], start[i + 1]):
            first[p] = min(first[p], place[columns[at]])
    offset = np.zeros(n + 1, dtype=np.int64)
    for p in range(n):
        offset[p + 1] = offset[p] + p - first[p] + 1
    lower = np.zeros(offset[n])
    for i in range(n):
        p = place[i]
        for at in range(start[i], start[i + 1]):
            q = place[columns[at]]
            if q <= p:
                lower[offset[p] + q - first[p]] = values[at]
    return first, lower, offset
