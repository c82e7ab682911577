"""Arrays with room for more rows than they have yet, or got."""

from __future__ import annotations

import numpy as np


def shortened(array: np.ndarray, n: int) -> np.ndarray:
    """
    Shorten an array to its first rows, in place: what lay behind them is given back.

    A view would keep all of the memory, a copy needs as much again. Nothing else may look into the
    array.

    Parameters
    ----------
    array : ndarray
        Owns its memory.
    n : int
        Rows that remain, at most all.

    Returns
    -------
    ndarray
        The same array.

    Examples
    --------
    >>> shortened(np.arange(5), 2)
    array([0, 1])
    """
    if n < len(array):
        # without a check, since it counts names of this array, too, which stay valid
        array.resize((n, *array.shape[1:]), refcheck=False)
    return array
