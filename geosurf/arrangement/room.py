"""Arrays with room for more rows than they have yet, or got."""

from __future__ import annotations

import numpy as np

from geosurf.arrangement.threads import in_ranges, map_threads

_ROWS = 50_000  # of a thread, at least: a millisecond, most of it for pages that nobody had before


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


def copy_rows(source: np.ndarray, target: np.ndarray) -> None:
    """
    Copy rows to as many others, in threads if these are many.

    Parameters
    ----------
    source, target : ndarray
        Of one shape. They may overlap if the target begins first.

    Examples
    --------
    >>> rows = np.arange(5)
    >>> copy_rows(rows[2:], rows[:3])
    >>> rows.tolist()
    [2, 3, 4, 3, 4]
    """
    if np.may_share_memory(source, target):
        target[:] = source
        return
    rows = in_ranges(len(source), _ROWS)
    map_threads(np.copyto, [(target[i:j], source[i:j]) for i, j in rows])
