"""Numbering of the distinct keys of an array, at the cost of the distinct keys."""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar


def number_keys(keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distinct keys in increasing order, and the number of each key among them.

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


def renumbered(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The distinct numbers in an array (n, 3), rising, and the place of each number among them.

    Examples
    --------
    >>> [found.tolist() for found in renumbered(np.array([[4, 9, 7]]))]
    [[4, 7, 9], [[0, 2, 1]]]
    """
    first = int(np.min(t, initial=0))
    span = int(np.max(t, initial=0)) + 1 - first
    if span > 16 * t.size:  # a small unit in a large model
        used, place = np.unique(t, return_inverse=True)
        return used, np.reshape(place, t.shape)

    # a table over the range of numbers: a tenth of the time of a sort
    place = np.zeros(span, dtype=np.int64)
    place[t - first] = 1
    used = first + np.flatnonzero(place)
    place[used - first] = np.arange(len(used))
    return used, place[t - first]


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

        # Multiply both halves of the key; the result stays below 2**63.
        h = (key & 0x3FFFFFFF) * 0x1E3779B1 + (key >> 30) * 8388593  # below 2**63
        slot = (h ^ (h >> 29)) & (size - 1)
        # Linear probing in a table that is at most half full.
        while slots[slot] >= 0 and found[slots[slot]] != key:
            slot = (slot + 1) & (size - 1)
        if slots[slot] < 0:
            slots[slot] = count
            found[count] = key
            count += 1
        number[i] = slots[slot]
    return found[:count].copy(), number


_SHIFT = 5
WORD = 1 << _SHIFT  # keys per word: bits in the lower half, count of earlier keys above


@scalar
def _ones(v):
    """Number of bits of a word of 32 bits."""
    # Parallel count in 2, 4 and 8 bits.
    v = v - ((v >> 1) & 0x55555555)
    v = (v & 0x33333333) + ((v >> 2) & 0x33333333)
    v = (v + (v >> 4)) & 0x0F0F0F0F
    return ((v * 0x01010101) >> 24) & 0xFF


def number_below(keys: np.ndarray, limit: int) -> tuple[np.ndarray, np.ndarray]:
    """Distinct keys in increasing order, and the number of each: `number_keys` for keys below a
    limit.

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
    number = np.reshape(np.array(keys, dtype=np.int64), (-1, 1))
    return number_in_place(number, 1, limit), number[:, 0]


def number_in_place(table: np.ndarray, n_column: int, limit: int) -> np.ndarray:
    """Write the number among all distinct keys over each key in the first columns of a table.

    One bit for each possible key, and no sort: five times as fast as `number_keys`, which does it
    where keys are too few for so many bits.

    Parameters
    ----------
    table : ndarray of int64, shape (n, m)
        Written. Its first `n_column` columns hold keys, at least 0.
    n_column : int
    limit : int
        Above all keys.

    Returns
    -------
    ndarray of int64, shape (n_distinct,)
        The distinct keys, increasing.

    Examples
    --------
    >>> table = np.array([[7, 3, -1], [3, 9, -1]])
    >>> number_in_place(table, 2, 10), table.tolist()
    (array([3, 7, 9]), [[1, 0, -1], [0, 2, -1]])
    """
    # With more than 512 possible keys per entry, clearing and counting bits would take longer than
    # a hash table.
    if limit <= 512 * n_column * len(table) + (1 << 20):
        found: np.ndarray = number_by_bits(table, n_column, limit)
        return found
    found, number = number_keys(np.reshape(table[:, :n_column], -1))
    table[:, :n_column] = np.reshape(number, (-1, n_column))
    return found


@entry("l2* l l -> l1")
def number_by_bits(table, n_column, limit):
    """`number_in_place` by a bit for each possible key."""
    # One bit per possible key.
    words = np.zeros((limit >> _SHIFT) + 1, dtype=np.int64)
    for k in range(table.shape[0]):
        for column in range(n_column):
            key = table[k, column]
            words[key >> _SHIFT] |= 1 << (key & (WORD - 1))

    # Prefix sums of the set bits.
    count = 0
    for i in range(words.shape[0]):  # the count of earlier keys goes into the upper half
        bits = words[i]
        if bits != 0:
            words[i] = (count << WORD) + bits
            count += _ones(bits)

    # The number of a key: earlier words plus lower bits of its own word.
    found = np.empty(count, dtype=np.int64)
    for k in range(table.shape[0]):
        for column in range(n_column):
            key = table[k, column]
            word = words[key >> _SHIFT]
            number = (word >> WORD) + _ones(word & ((1 << (key & (WORD - 1))) - 1))
            found[number] = key
            table[k, column] = number
    return found
