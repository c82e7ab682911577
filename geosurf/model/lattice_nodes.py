"""Which node of a lattice a place is over."""

from __future__ import annotations

import numpy as np

from geosurf.model.lattice import Lattice


def nodes_at(lattice: Lattice, places: np.ndarray) -> np.ndarray | None:
    """
    Return the nodes of a regular lattice at some places.

    Parameters
    ----------
    lattice : Lattice
    places : ndarray of float64, shape (n, 2)
        Easting and northing [m].

    Returns
    -------
    ndarray of int64, shape (n,), or None
        Row by row. None if some place is at no node, to the last digit.

    Examples
    --------
    >>> lattice = Lattice(np.array([0.0, 5.0, 10.0]), np.array([0.0, 5.0]), np.zeros((2, 3)))
    >>> nodes_at(lattice, np.array([[10.0, 0.0], [0.0, 5.0]])).tolist()
    [2, 3]
    """
    east, north = lattice.horizontal()
    n_row, n_col = lattice.shape
    if min(n_row, n_col) < 2:
        return None

    # column and row from the steps between corners of the lattice, then exact comparison
    origin = np.array([east[0, 0], north[0, 0]])
    along = np.array([east[0, -1], north[0, -1]]) - origin
    up = np.array([east[-1, 0], north[-1, 0]]) - origin
    steps = np.stack([along / (n_col - 1), up / (n_row - 1)], axis=1)
    if not np.isfinite(steps).all() or np.linalg.det(steps) == 0.0:
        return None
    at = np.rint(np.linalg.solve(steps, (places - origin).T)).astype(np.int64)
    col, row = np.clip(at[0], 0, n_col - 1), np.clip(at[1], 0, n_row - 1)
    if not (np.array_equal(east[row, col], places[:, 0])
            and np.array_equal(north[row, col], places[:, 1])):  # fmt: skip
        return None
    found: np.ndarray = row * n_col + col
    return found
