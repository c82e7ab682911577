"""Polygons on the map: which sides are one straight line, since exports have many short ones."""

from __future__ import annotations

import numpy as np


def straight_runs(outline: np.ndarray, near: float) -> list[list[int]]:
    """
    Return the sides of a polygon in runs that are straight to within a distance.

    Parameters
    ----------
    outline : ndarray of float64, shape (n, 2)
        Corners.
    near : float
        How far corners of a run may be off its line.

    Returns
    -------
    list of list of int
        Numbers of sides; side k follows corner k.

    Examples
    --------
    >>> square = np.array([[0.0, 0], [2, 0], [4, 0], [4, 4], [0, 4], [0, 2]])
    >>> straight_runs(square, 0.1)
    [[3], [4, 5], [0, 1], [2]]
    """
    n = len(outline)
    # begin at the corner that is farthest from the first one: no run goes on across it
    start = int(np.hypot(*(outline - outline[0]).T).argmax())
    ring = [(start + k) % n for k in range(n + 1)]
    runs, first = [], 0
    for last in range(1, n + 1):
        if last < n and _off(outline[ring[first : last + 2]]) <= near:
            continue
        runs.append(ring[first:last])
        first = last
    return runs


def _off(corners: np.ndarray) -> float:
    """Largest distance of corners from the line between the first and last of them [m]."""
    chord = corners[-1] - corners[0]
    from_first = corners[1:-1] - corners[0]
    length = np.hypot(*chord)
    if not length:
        return np.inf
    along = from_first @ chord / length
    # a line that turns back is not straight
    if (np.diff(along, prepend=0.0, append=length) < 0).any():
        return np.inf
    return float(np.abs(chord[0] * from_first[:, 1] - chord[1] * from_first[:, 0]).max() / length)


__all__ = ["straight_runs"]
