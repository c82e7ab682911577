"""Sets of whole numbers, as increasing arrays: nodes, links, edges.

`np.unique` hashes, and loses by it: what is asked here is nearly sorted, or short to sort. Models
load this file, so that it has no kernel: what reads a surface does not load numba.
"""

from __future__ import annotations

import numpy as np


def distinct(*parts: np.ndarray) -> np.ndarray:
    """All numbers of some arrays, each once, increasing."""
    if not parts:
        return np.empty(0, dtype=np.int64)
    every = np.concatenate([np.ravel(part) for part in parts]) if len(parts) != 1 else parts[0]
    every = np.sort(every, axis=None)
    if len(every) < 2:
        return every

    # a number is new where it differs from the one before
    new = np.empty(len(every), dtype=bool)
    new[0] = True
    np.not_equal(every[1:], every[:-1], out=new[1:])
    return every[new]


def is_among(numbers: np.ndarray, rising: np.ndarray) -> np.ndarray:
    """Whether each number is one of some increasing ones, bool like `numbers`."""
    if len(rising) == 0:
        return np.zeros(np.shape(numbers), dtype=bool)
    at = np.searchsorted(rising, numbers)

    # past the end: any row will do, the comparison below fails
    at[at == len(rising)] = 0
    found: np.ndarray = rising[at] == numbers
    return found


def ranges(first: np.ndarray | int, count: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ranges of whole numbers one after the other: the row of each number's range, and the number.

    Examples
    --------
    >>> [found.tolist() for found in ranges(np.array([7, 2]), np.array([2, 3]))]
    [[0, 0, 1, 1, 1], [7, 8, 2, 3, 4]]
    """
    row = np.repeat(np.arange(len(count)), count)
    return row, np.arange(len(row)) + (first - np.cumsum(count) + count)[row]


def first_rows(numbers: np.ndarray, n: int) -> np.ndarray:
    """The first row of each of n numbers, int64 (n,); -1 where there is none."""
    first = np.full(n, -1)
    first[numbers[::-1]] = np.arange(len(numbers))[::-1]
    return first


def pairs_of_equal(numbers: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of some rows those with the same number: each one, and the next one that has it."""
    order = rows[np.argsort(numbers[rows], kind="stable")]
    same = np.flatnonzero(numbers[order[1:]] == numbers[order[:-1]])
    return order[same], order[same + 1]


def rim_edges(triangles: np.ndarray) -> np.ndarray:
    """Edges (n, 2) that one triangle only has, the lower vertex first."""
    start, end = np.ravel(triangles), np.ravel(np.roll(triangles, -1, axis=1))

    # as one number each: rows are sorted ten times as slowly
    n = int(np.max(triangles, initial=0)) + 1
    keys, times = np.unique(np.minimum(start, end) * n + np.maximum(start, end), return_counts=True)
    return np.stack(np.divmod(keys[times == 1], n), axis=1)
