"""Things joined in pairs: which of them hang together."""

from __future__ import annotations

import numpy as np


def joined(n: int, pairs: np.ndarray) -> np.ndarray:
    """Lowest member of the set that each of `n` things is in, after joining pairs (m, 2).

    Examples
    --------
    >>> joined(5, np.array([[3, 1], [4, 3]])).tolist()
    [0, 1, 2, 1, 1]
    """
    root = np.arange(n)
    while True:
        low = root[pairs].min(axis=1, initial=n)
        np.minimum.at(root, root[pairs[:, 0]], low)
        np.minimum.at(root, root[pairs[:, 1]], low)
        while not np.array_equal(root, root[root]):
            root = root[root]
        if (root[pairs[:, 0]] == root[pairs[:, 1]]).all():
            return root
