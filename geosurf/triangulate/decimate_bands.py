"""How far some rows and columns of a grid in its store are from all nodes: band by band.

A band of chunks begins with the last row of the band before. A block between two rows that are
kept mostly lies in one band. Of one that does not, the rows so far are carried to the next band.
"""

from __future__ import annotations

import numpy as np

from geosurf.model.chunked import ChunkedLattice

Kept = tuple[np.ndarray, np.ndarray]  # rows and columns
Found = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, int]


def differences_in_bands(
    lattice: ChunkedLattice, rows: np.ndarray, cols: np.ndarray, limit: float
) -> Found:
    """
    Return what the kernel `differences_of_rows_and_columns` returns for all nodes, from one pass.

    Parameters
    ----------
    lattice : ChunkedLattice
        With axes, and without absent nodes.
    rows, cols : ndarray of int64
        That are kept, with both ends.
    limit : float
        [m]. What is farther off ends the pass.

    Returns
    -------
    few : ndarray of float64, shape (n_row, n_col)
        Elevations of the nodes that are kept [m].
    above, below, change : ndarray of float64, shape (n_row - 1, n_col - 1)
        How far all nodes are above and below these, at most in each coarse cell [m]; the integral
        of what they are above, in cells of the grid [m].
    failed : int
        First block of rows that is farther off than the limit, or -1.
    """
    n_block, n_cell = len(rows) - 1, len(cols) - 1
    few = np.empty((n_block + 1, n_cell + 1))
    above, below, change = (np.zeros((n_block, n_cell)) for _ in range(3))
    done, carried = 0, np.empty((0, lattice.shape[1]))
    for first, band in lattice.bands():
        z, last = band.elevation, first + len(band.elevation)
        parts = []  # nodes, the row that they begin with, and the blocks that end there
        if len(carried):
            carried = np.concatenate([carried, z[1 : int(rows[done + 1]) + 1 - first]])
            if rows[done + 1] >= last:
                continue
            parts.append((carried, int(rows[done]), done + 1))
        parts.append((z, first, int(np.searchsorted(rows, last)) - 1))
        for nodes, start, end in parts:
            if end > done:
                found = _blocks(nodes, rows[done : end + 1] - start, cols, limit)
                few[done : end + 1] = found[0]
                above[done:end], below[done:end], change[done:end] = found[1:4]
                if found[4] >= 0:
                    return few, above, below, change, done + found[4]
                done = end
        # a copy: the next band takes the memory of this one
        carried = z[int(rows[done]) - first :].copy()
    return few, above, below, change, -1


def are_near_in_band(
    lattice: ChunkedLattice, kept: list[Kept], limit: float, place: float
) -> list[bool]:
    """
    Return which rows and columns are within a limit in one band: a first look, for all at once.

    Parameters
    ----------
    lattice : ChunkedLattice
        As for `differences_in_bands`.
    kept : list of (ndarray, ndarray)
        Rows and columns, with both ends, in turn.
    limit : float
        [m].
    place : float
        Which band is read: the one there, from 0 (first row) to below 1 (last row).

    Returns
    -------
    list of bool
        Also true where no block is complete in the band.
    """
    n_row = lattice.shape[0]
    wanted = np.zeros(n_row - 1, dtype=bool)
    wanted[min(int(place * (n_row - 1)), n_row - 2)] = True
    first, band = next(iter(lattice.bands(wanted)))
    last = first + len(band.elevation)
    near = []
    for rows, cols in kept:
        inside = rows[(rows >= first) & (rows < last)] - first
        few = len(inside) < 2
        near.append(few or _blocks(band.elevation, inside, cols, limit)[4] < 0)
    return near


def _blocks(z: np.ndarray, rows: np.ndarray, cols: np.ndarray, limit: float) -> Found:
    """The kernel for blocks of rows that some nodes hold."""
    from geosurf.kernels.lattices.decimate import differences_of_rows_and_columns

    order = np.arange(len(rows) - 1)
    found: Found = differences_of_rows_and_columns(z, rows, cols, order, limit)
    return found


__all__ = ["are_near_in_band", "differences_in_bands"]
