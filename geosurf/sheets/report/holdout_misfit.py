"""Misfit of ignored data, each against the wall of the finished sheet that it is on.

The rebuild ignores data near a fault, so they test it. On grids a datum is on the wall of
its side of the trace; where walls overlap, and for scattered points, on that of its
side of the fault at its own height. There its own wall's sheet goes on over the other one, by
ghosts, and the sheet between the nodes of its cell would be a mixture of both.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.kernels.lattices.sets import is_among
from geosurf.sheets.faults.cut_edges import EAST, NORTH, Cuts
from geosurf.sheets.heights.inputs import NearPicks
from geosurf.sheets.heights.state import SENSE, Heights
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.mesh.build import Built
from geosurf.sheets.mesh.overlap_points import on_sheet


def holdout_misfit(picks: Picks, near: Sequence[NearPicks], built: Built) -> np.ndarray:
    """Misfit (n,) of ignored data against the sheet of their wall [m].

    Without those in gaps, where there is nothing to meet, those that ghosts are drawn to, those of
    nodes with several on a grid, and those where no single sheet goes: next to other faults.
    """
    state = built.state

    # ignored data that lie on exactly one sheet
    hidden = state.ignored.copy()
    hidden[state.in_gap] = False
    hidden[state.beyond[:, 0]] = False
    rows = np.flatnonzero(hidden)
    if picks.several is not None:
        rows = rows[~picks.several[picks.node[rows]]]

    # trace (n,) and side (n,) of each; plain (n,): its nodes are on its own wall already
    trace, side, plain = _walls_of(picks, near, state, rows)
    vertex, share = picks.corners_of(rows)

    # cells that a fault cuts have nodes of both walls; with several faults none is certain
    if not picks.on_nodes:
        cells, of = _cells_cut(built.cuts, picks.frame.shape[1])
        cut = is_among(vertex[:, 0], cells)
        plain &= ~cut
        for number in np.unique(trace[cut]).tolist():
            mine = cut & (trace == number)
            vertex[mine & is_among(vertex[:, 0], cells[of != number])] = -1

    # data past the trace: their wall is there as ghosts, which take the place of nodes
    aside = ~plain & (vertex[:, 0] >= 0)
    vertex[aside & (trace < 0)] = -1
    for number, wall in np.unique(np.stack([trace, side])[:, aside & (trace >= 0)], axis=1).T:
        mine = aside & (trace == number) & (side == wall)
        vertex[mine] = on_sheet(vertex[mine], state.near[number], int(wall), built.torn)

    # vertices are nodes first, then ghosts
    there = (vertex >= 0).all(axis=1)
    heights = np.concatenate([state.values, built.ghosts])
    found: np.ndarray = np.abs(
        (heights[vertex[there]] * share[there]).sum(axis=1) - picks.z[rows[there]]
    )
    return found


def _walls_of(
    picks: Picks, near: Sequence[NearPicks], state: Heights, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The nearest trace (n,) of picks beside one, -1 without; which side of it; if their node's."""
    # per pick, of the nearest fault so far: distance at own height, trace, side, and whether its
    # node is on the same wall
    far = np.full(len(rows), np.inf)
    trace, side = np.full(len(rows), -1), np.zeros(len(rows), dtype=np.int64)
    plain = np.ones(len(rows), dtype=bool)
    for number, (line, beside) in enumerate(zip(state.network.traces, state.near, strict=True)):
        own = near[line.fault]
        at, k = beside.look_up(picks.nodes_of(rows)), np.searchsorted(own.rows, rows)
        mine = np.flatnonzero((at >= 0) & is_among(rows, own.rows))
        at, k = at[mine], k[mine]

        # only beside the torn part of the trace, and only where no other fault is nearer
        first, last = state.network.mesh[number]
        inside = (beside.place[at] > first) & (beside.place[at] < last) & (own.far[k] < far[mine])
        mine, at, k = mine[inside], at[inside], k[inside]
        here, there = beside.side[at].astype(np.int64), own.side[k].astype(np.int64)

        # on grids the side in the map is the datum's, except in overlaps, where both walls are
        # there
        if picks.on_nodes:
            there = np.where(state.walls[number].heave(beside.place[at]) < -SENSE, there, here)
        far[mine], trace[mine], side[mine] = own.far[k], number, there
        plain[mine] = here == there
    return trace, side, plain


def _cells_cut(cuts: Cuts, n_col: int) -> tuple[np.ndarray, np.ndarray]:
    """Cells, by their lower left nodes, that cut links bound or cross, and the trace of each."""
    # a cell has its own links; an east link also bounds the cell below, a north link that west
    below = cuts.kind == EAST
    west = cuts.kind == NORTH
    cells = [cuts.node, cuts.node[below] - n_col, cuts.node[west] - 1]
    traces = [cuts.trace, cuts.trace[below], cuts.trace[west]]
    order = np.argsort(np.concatenate(cells), kind="stable")
    return np.concatenate(cells)[order], np.concatenate(traces)[order]
