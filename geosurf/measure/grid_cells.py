"""Find the triangles of grids that vertical lines pass, by coordinates: nothing is searched."""

from __future__ import annotations

import numpy as np

from geosurf.kernels.location.lattice_units import OFF, find_keys
from geosurf.kernels.location.pushed import digits_of, frame_with
from geosurf.model import Lattice
from geosurf.model.pieces import Strips
from geosurf.model.torn_lattice import TornLattice

MOST_DEVIATION = 0.25  # of a cell, of nodes from a grid of equal cells: a guess is one cell off
ROW, FIRST, LAST = 0, 1, 2  # columns of runs


def keys_at(
    lattice: Lattice, origin: np.ndarray, feet: np.ndarray, middle: np.ndarray
) -> np.ndarray | None:
    """
    Return the key of the triangle of a grid that each vertical line passes; of those with nodes.

    Parameters
    ----------
    lattice : Lattice
    origin : ndarray of float64, shape (3,)
    feet : ndarray of float64, shape (n, 2)
        Local [m].
    middle : ndarray of float64, shape (2,)
        Feet on the rim of a triangle count as if they were a little nearer to this.

    Returns
    -------
    ndarray of int64, shape (n,), or None
        -1 outside of the grid. None for a grid that may fold on the map, or whose cells are far
        from equal. Triangles of a torn grid that are gone have their keys, too; its copies do not
        count.

    Examples
    --------
    >>> lattice = Lattice(np.array([0.0, 5.0, 10.0]), np.array([0.0, 5.0]), np.zeros((2, 3)))
    >>> keys_at(lattice, np.zeros(3), np.array([[9.0, 1.0], [11.0, 1.0]]), np.ones(2)).tolist()
    [2, -1]
    """
    torn = isinstance(lattice, TornLattice) and lattice.nodes_lie_apart
    guess = _guess(lattice, origin) if torn else cell_guess(lattice, origin)
    if guess is None:
        return None
    x, y = lattice.easting.ravel() - origin[0], lattice.northing.ravel() - origin[1]
    m, w = frame_with(digits_of(x, y), digits_of(feet))
    keys = np.full(len(feet), OFF, dtype=np.int64)
    turn, rule = 1 if lattice.right_handed else -1, np.append(middle, 0.0)
    find_keys(x, y, lattice.places, guess, turn, np.ascontiguousarray(feet), rule, m, w, keys)
    return keys


def runs_of_keys(lattice: Lattice, strips: Strips, keys: np.ndarray) -> np.ndarray:
    """Run of each triangle by key (n,), -1 where a curve touches it or a node is absent."""
    n_col = 2 * (lattice.shape[1] - 1)
    row, place = np.divmod(keys, n_col)
    if lattice.rising:  # halves of a cell come in the other order along a strip
        place ^= 1
    runs = strips.runs
    if not len(runs):
        return np.full(len(keys), -1)

    # runs come row by row and from west to east: the last one that starts at or before a place
    at = np.searchsorted(runs[:, ROW] * n_col + runs[:, FIRST], row * n_col + place, "right") - 1
    held = (keys >= 0) & (at >= 0) & (runs[at, ROW] == row) & (runs[at, LAST] >= place)
    return np.where(held, at, -1)


def cell_guess(lattice: Lattice, origin: np.ndarray) -> np.ndarray | None:
    """How easting and northing lead to rows and columns: empty for axes along those of the map.

    None if the grid may fold on the map, or its cells are too far from equal for a guess.
    """
    return _guess(lattice, origin) if lattice.is_graph else None


def _guess(lattice: Lattice, origin: np.ndarray) -> np.ndarray | None:
    """`cell_guess` of nodes that do not fold."""
    if lattice.easting.ndim == 1:
        return np.empty(0)
    x, y = lattice.easting - origin[0], lattice.northing - origin[1]
    if min(lattice.shape) < 2 or not (np.isfinite(x).all() and np.isfinite(y).all()):
        return None

    # mean steps along rows and columns, from corner to corner
    n_row, n_col = lattice.shape
    first = np.array([x[0, 0], y[0, 0]])
    along = np.array([[x[-1, 0], x[0, -1]], [y[-1, 0], y[0, -1]]]) - first[:, None]
    back = np.linalg.inv(along / [n_row - 1, n_col - 1])
    row, col = (back[k, 0] * (x - first[0]) + back[k, 1] * (y - first[1]) for k in (0, 1))
    off = max(
        float(np.abs(row - np.arange(n_row)[:, None]).max()),
        float(np.abs(col - np.arange(n_col)).max()),
    )
    if off > MOST_DEVIATION:
        return None
    start = -back @ first
    return np.array([start[0], *back[0], start[1], *back[1]])
