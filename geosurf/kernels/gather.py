"""Numbering a few keys out of many, at the cost of the few."""

from __future__ import annotations

import numpy as np

from geosurf.kernels._jit import entry, scalar
from geosurf.kernels.contact import (
    CROSSING,
    FIRST_CODE,
    N_COLUMN,
    N_CORNER,
    TRIANGLE_A,
    TRIANGLE_B,
)


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


WORD = 32


@scalar
def _ones(v):
    """Number of bits of a word of 32 bits."""
    v = v - ((v >> 1) & 0x55555555)
    v = (v & 0x33333333) + ((v >> 2) & 0x33333333)
    v = (v + (v >> 4)) & 0x0F0F0F0F
    return ((v * 0x01010101) >> 24) & 0xFF


def number_below(keys: np.ndarray, limit: int) -> tuple[np.ndarray, np.ndarray]:
    """Distinct keys in rising order, and the number of each: `number_keys` for keys below a limit.

    One bit for each possible key, and no sort: five times as fast where keys are not too few.

    Parameters
    ----------
    keys : ndarray of int64, shape (n,)
        At least 0.
    limit : int
        Above all keys.

    Returns
    -------
    found : ndarray of int64, shape (n_distinct,)
    number : ndarray of int64, shape (n,)

    Examples
    --------
    >>> number_below(np.array([7, 3, 7]), 8)
    (array([3, 7]), array([1, 0, 1]))
    """
    if limit > 512 * len(keys) + (1 << 20):
        return number_keys(keys)
    return number_by_bits(keys, limit)


@entry("l1 l -> l1 l1")
def number_by_bits(keys, limit):
    """Distinct keys in rising order, and the number of each, by a bit for each possible key."""
    bits = np.zeros(limit // WORD + 1, dtype=np.uint32)
    for i in range(keys.shape[0]):
        bits[keys[i] // WORD] |= np.uint32(1 << (keys[i] % WORD))
    before = np.empty(bits.shape[0], dtype=np.int32)
    count = 0
    for word in range(bits.shape[0]):
        before[word] = count
        if bits[word] != 0:
            count += _ones(np.int64(bits[word]))
    found = np.empty(count, dtype=np.int64)
    number = np.empty(keys.shape[0], dtype=np.int64)
    for i in range(keys.shape[0]):
        word = keys[i] // WORD
        below = np.int64(bits[word]) & ((1 << (keys[i] % WORD)) - 1)
        number[i] = before[word] + _ones(below)
        found[number[i]] = keys[i]
    return found, number


@entry("l2 l2 l1 l1 -> l2")
def rows_in_order(rows, pairs, codes, order):
    """Contacts (`contact`), some as rows, some in two points as pairs of faces with known codes.

    `order` has places among the rows, followed by the pairs.
    """
    found = np.zeros((order.shape[0], N_COLUMN), dtype=np.int64)
    for i in range(order.shape[0]):
        k = order[i] - rows.shape[0]
        if k < 0:
            for column in range(N_COLUMN):
                found[i, column] = rows[order[i], column]
            continue
        found[i, TRIANGLE_A], found[i, TRIANGLE_B] = pairs[k, 0], pairs[k, 1]
        found[i, CROSSING], found[i, N_CORNER] = 1, 2
        found[i, FIRST_CODE], found[i, FIRST_CODE + 1] = codes[k] >> 6, codes[k] & 63
    return found


@entry("l2 l -> l1")
def order_by_faces(rows, n_face):
    """Order of rows by their first two numbers, faces: no row of one pair comes twice."""
    start = np.zeros(n_face + 1, dtype=np.int64)
    for i in range(rows.shape[0]):
        start[rows[i, 0] + 1] += 1
    for face in range(n_face):
        start[face + 1] += start[face]
    fill = start[:-1].copy()
    order = np.empty(rows.shape[0], dtype=np.int64)
    for i in range(rows.shape[0]):
        face = rows[i, 0]
        order[fill[face]] = i
        fill[face] += 1
    for face in range(n_face):
        low, high = start[face], start[face + 1]
        if high - low > 32:
            part = order[low:high]
            part[:] = part[np.argsort(rows[:, 1][part])]
            continue
        for i in range(low + 1, high):
            row = order[i]
            j = i - 1
            while j >= low and rows[order[j], 1] > rows[row, 1]:
                order[j + 1] = order[j]
                j -= 1
            order[j + 1] = row
    return order
