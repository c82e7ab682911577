"""What each cell is: its zone by its layer, its block by what a line through its column meets."""

from __future__ import annotations

import numpy as np

from geosurf.grid.lines import Pieces
from geosurf.model.grids import GridFaces

PER_COLUMN = 5  # lines: four at Gauss points, one through the middle


def lengths_in(pieces: Pieces, n_line: int, zones: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Length of each line in each zone (n_line, n_zone), and the highest point of each line."""
    thick = np.zeros((n_line, len(zones)))
    for k, zone in enumerate(zones):
        rows = pieces.zone == zone
        thick[:, k] = np.bincount(pieces.line[rows], pieces.length[rows], minlength=n_line)
    top = np.full(n_line, -np.inf)
    np.maximum.at(top, pieces.line, pieces.top)
    return thick, top


def regions_of_cells(
    pieces: Pieces, thick: np.ndarray, zones: list[int], depths: list[np.ndarray]
) -> np.ndarray:
    """
    Return the region of each cell: that of the same share of its zone on the line through it.

    Parameters
    ----------
    pieces : Pieces
        Of `PER_COLUMN` lines for each column, the middle one last.
    thick : ndarray of float64, shape (n_column * PER_COLUMN, n_zone)
        Lengths of the lines in the zones.
    zones : list of int
    depths : list of ndarray, each (n_layer, n_column)
        Depth of the middle of the cells of each zone, as a share of the zone.

    Returns
    -------
    ndarray of int64, shape (n_layer of all zones, n_column)
        -1 where no line through the column meets the zone.
    """
    out = []
    for k, zone in enumerate(zones):
        # the middle line where it meets the zone, else that which meets most of it
        of_line = thick[:, k].reshape(-1, PER_COLUMN)
        best = np.where(of_line[:, -1] > 0.0, PER_COLUMN - 1, of_line.argmax(axis=1))
        column = np.arange(len(of_line))
        line, found = column * PER_COLUMN + best, of_line[column, best] > 0.0

        # pieces of the zone from the top down, each up to a share of the whole length
        rows = np.flatnonzero(pieces.zone == zone)
        if not len(rows):
            out.append(np.full(depths[k].shape, -1))
            continue
        of, length = pieces.line[rows], pieces.length[rows]
        first = np.flatnonzero(np.diff(of, prepend=-1))
        end = np.cumsum(length)
        start = np.repeat(end[first] - length[first], np.diff(np.append(first, len(of))))
        total = np.bincount(of, length, minlength=len(thick))[of]
        share = np.minimum((end - start) / total, 1.0)
        share[np.append(first[1:], len(of)) - 1] = 1.0
        at = np.searchsorted(of + share, line + np.clip(depths[k], 0.0, 1.0 - 1e-9), "left")
        region = pieces.region[rows[np.minimum(at, len(rows) - 1)]]
        out.append(np.where(found, region, -1))
    return np.concatenate(out)


def faces_of(
    between: tuple[np.ndarray, np.ndarray], first: np.ndarray, actnum: np.ndarray
) -> GridFaces:
    """
    Return the faces on faults, with the layers of all zones in a row joined.

    Parameters
    ----------
    between : (ndarray of bool, ndarray of bool)
        As `faults_between` returns them, one level for each zone.
    first : ndarray of int64, shape (n_zone + 1,)
        First layer of each zone, and the number of layers.
    actnum : ndarray of bool, shape (nz, ny, nx)

    Returns
    -------
    GridFaces
        Where there are active cells on both sides.
    """
    parts = []
    for axis, apart in enumerate(between):
        n = apart.shape[-1 - (axis == 1)]
        live = np.asarray(actnum.any(axis=0))
        ends = live[:, :n] & live[:, 1:] if axis == 0 else live[:n] & live[1:]
        crossed = np.moveaxis(apart & ends, 1, -1)  # (fault, j, i, zone)
        step = np.diff(crossed.astype(np.int8), axis=-1, prepend=0, append=0)
        fault, j, i, start = np.nonzero(step == 1)
        stop = np.nonzero(step == -1)[-1]
        of = np.full(len(fault), axis)
        parts.append((fault, of, np.stack([i, j], 1), np.stack([first[start], first[stop]], 1)))
    fault, axis_of, column, layers = (np.concatenate(part) for part in zip(*parts, strict=True))
    order = np.lexsort((column[:, 0], column[:, 1], axis_of, fault))
    return GridFaces(fault[order], axis_of[order], column[order], layers[order])


__all__ = ["PER_COLUMN", "faces_of", "lengths_in", "regions_of_cells"]
