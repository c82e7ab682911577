"""Numbering a few keys out of many, at the cost of the few."""

from __future__ import annotations

import numpy as np

from geosurf.kernels._jit import entry


def number_keys(keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distinct keys in rising order, and the number of each key among them.

    A table and a sort of the distinct ones: three times as fast as sorting all where each key comes
    five times, as triangles do in candidate pairs. numpy sorts three times as fast as compiled
    kernels do, with vector instructions.

    Parameters
    ----------
    keys : ndarray of int64, shape (n,)

    Returns
    -------
    found : ndarray of int64, shape (n_distinct,)
    number : ndarray of int64, shape (n,)

    Examples
    --------
    >>> number_keys(np.array([7, 3, 7]))
    (array([3, 7]), array([1, 0, 1]))
    """
    found, number = first_seen(keys)
    order = np.argsort(found)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return found[order], rank[number]


@entry("l1 -> l1 l1")
def first_seen(keys):
    """Distinct keys in the order in which they come, and the number of each key among them."""
    n = keys.shape[0]
    size = 16
    while size < 2 * n:
        size *= 2
    slots = np.full(size, -1, dtype=np.int64)
    number = np.empty(n, dtype=np.int64)
    found = np.empty(n, dtype=np.int64)
    count = 0
    for i in range(n):
        key = keys[i]
        h = (key & 0x3FFFFFFF) * 0x1E3779B1 + (key >> 30) * 8388593  # below 2**63
        slot = (h ^ (h >> 29)) & (size - 1)
        while slots[slot] >= 0 and found[slots[slot]] != key:
            slot = (slot + 1) & (size - 1)
        if slots[slot] < 0:
            slots[slot] = count
            found[count] = key
            count += 1
        number[i] = slots[slot]
    return found[:count].copy(), number
