"""What each cell is: its zone by its layer, its block by what a line through its column meets."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.grid.barriers import Below
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
) -> tuple[np.ndarray, np.ndarray]:
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
    (ndarray of int64, ndarray of float64), each (n_layer of all zones, n_column)
        Region, -1 where no line through the column meets the zone; and its elevation on the middle
        line, NaN where that does not meet the zone: all cells of the zone are in one region there.
    """
    out, heights = [], []
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
            heights.append(np.full(depths[k].shape, np.nan))
            continue
        of, length = pieces.line[rows], pieces.length[rows]
        first = np.flatnonzero(np.diff(of, prepend=-1))
        end = np.cumsum(length)
        start = np.repeat(end[first] - length[first], np.diff(np.append(first, len(of))))
        total = np.bincount(of, length, minlength=len(thick))[of]
        share = np.minimum((end - start) / total, 1.0)
        share[np.append(first[1:], len(of)) - 1] = 1.0
        central = best == PER_COLUMN - 1
        depth = np.where(central, np.clip(depths[k], 0.0, 1.0 - 1e-9), 0.5)
        at = np.minimum(np.searchsorted(of + share, line + depth, "left"), len(rows) - 1)
        out.append(np.where(found, pieces.region[rows[at]], -1))
        below_top = depth * total[at] - (end - start - length)[at]
        z = pieces.top[rows[at]] - np.clip(below_top, 0.0, length[at])
        heights.append(np.where(found & central, z, np.nan))
    return np.concatenate(out), np.concatenate(heights)


def faces_of(
    between: tuple[np.ndarray, np.ndarray],
    faults: Sequence[Below],
    middles: np.ndarray,
    height: np.ndarray,
    zone: np.ndarray,
    block: np.ndarray,
) -> GridFaces:
    """
    Return the faces on faults, with layers in a row joined.

    Parameters
    ----------
    between : (ndarray of bool, ndarray of bool)
        As `faults_between` returns them, one level for each zone.
    faults : sequence of Below
    middles : ndarray of float64, shape (n_zone, ny, nx)
        Elevation of the middle of each zone in each column, as for `between` [m].
    height : ndarray of float64, shape (nz, ny, nx)
        Elevation of the middle of each cell [m]; NaN: as the middle of its zone.
    zone : ndarray of int64, shape (nz,)
        Row of `middles` of each layer.
    block : ndarray of int64, shape (nz, ny, nx)
        -1 in cells that are not active.

    Returns
    -------
    GridFaces
    """
    height = np.where(np.isnan(height), middles[zone], height)
    live = np.asarray((block >= 0).any(axis=0))
    sides = (live[:, :-1] & live[:, 1:], live[:-1] & live[1:], live)
    found: list[list[np.ndarray]] = [[], [], []]
    for fault, below in enumerate(faults):
        # a fault may cut a column: cells above it and below it have other neighbours than the
        # middle of their zone, and a face between them
        here = below(height)
        turned = here ^ below(middles)[zone]
        apart_i = between[0][fault][zone] ^ turned[:, :, :-1] ^ turned[:, :, 1:]
        apart_j = between[1][fault][zone] ^ turned[:, :-1] ^ turned[:, 1:]
        for axis, apart in enumerate((apart_i, apart_j, here[:-1] ^ here[1:])):
            found[axis].append(apart & sides[axis])
    if faults:
        _at_blocks(found, block)
    parts = []
    for axis, of_fault in enumerate(found):
        for fault, apart in enumerate(of_fault):
            step = np.diff(np.moveaxis(apart, 0, -1).astype(np.int8), axis=-1, prepend=0, append=0)
            j, i, start = np.nonzero(step == 1)
            layers = np.stack([start, np.nonzero(step == -1)[-1]], 1)
            parts.append((*np.full((2, len(j)), [[fault], [axis]]), np.stack([i, j], 1), layers))
    if not parts:
        none = np.empty(0, np.int64)
        return GridFaces(none, none, np.empty((0, 2), np.int64), np.empty((0, 2), np.int64))
    of, axis_of, column, layers = (np.concatenate(part) for part in zip(*parts, strict=True))
    order = np.lexsort((layers[:, 0], column[:, 0], column[:, 1], axis_of, of))
    return GridFaces(of[order], axis_of[order], column[order], layers[order])


def _at_blocks(found: list[list[np.ndarray]], block: np.ndarray) -> None:
    """Add faces between blocks that rays missed by rounding of tilted pillars, in place.

    They belong to the fault that most other faces between the same two blocks are on.
    """
    n_block = int(block.max(initial=0)) + 1
    ends = [
        (block[..., :-1], block[..., 1:]), (block[:, :-1], block[:, 1:]), (block[:-1], block[1:])
    ]  # fmt: skip
    pairs = [np.minimum(a, b) * n_block + np.maximum(a, b) for a, b in ends]
    other = [(a != b) & (np.minimum(a, b) >= 0) for a, b in ends]
    count = np.zeros((len(found[0]), n_block * n_block), dtype=np.int64)
    for of_fault, pair, differ in zip(found, pairs, other, strict=True):
        for fault, apart in enumerate(of_fault):
            count[fault] += np.bincount(pair[apart & differ], minlength=n_block * n_block)
    owner = np.where(count.any(axis=0), count.argmax(axis=0), -1)
    for of_fault, pair, differ in zip(found, pairs, other, strict=True):
        missed = differ & ~np.any(of_fault, axis=0)
        for fault, apart in enumerate(of_fault):
            apart |= missed & (owner[np.where(missed, pair, 0)] == fault)
