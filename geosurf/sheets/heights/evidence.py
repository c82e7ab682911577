"""What a finished pass shows: picks in gaps, and how far off the data are that it ignored."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.kernels.lattices.sets import distinct
from geosurf.sheets.heights.inputs import Inputs, NearPicks
from geosurf.sheets.heights.smear import Smear, distances, smear_of
from geosurf.sheets.heights.state import SENSE, Heights
from geosurf.sheets.lattice.picks import Picks


def picks_in_gaps(inputs: Inputs, state: Heights) -> np.ndarray:
    """Picks that lie between the cut-offs of a fault in the map."""
    found = [np.empty(0, dtype=np.int64)]
    for trace, near, walls in zip(state.network.traces, state.near, state.walls, strict=True):
        # in the gap: nearer to the trace than the cut-off of the wall on its own side of the map
        rows = inputs.nearby[trace.fault].rows
        at = near.look_up(inputs.picks.nodes_of(rows))
        rows, at = rows[at >= 0], at[at >= 0]
        gap = walls.gap(near.place[at], near.side[at])
        found.append(rows[near.distance[at] < gap])
    return distinct(*found)


def ignored_misfits(
    picks: Picks, near: Sequence[NearPicks], state: Heights, in_gap: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Misfits of ignored data outside of gaps, of nodes with a single pick.

    Returns
    -------
    rows : ndarray of int64 (n,)
        Picks.
    far : ndarray (n,)
        Distance from the nearest fault, at their own height [cells].
    misfit : ndarray (n,)
        From the sheet of their side of the map [m].
    """
    # only data that were not used can test the sheet; several picks of a node are of two walls
    rows, far = distances(near)
    empty = np.zeros(len(picks.z), dtype=bool)
    empty[in_gap] = True
    chosen = state.ignored[rows] & ~empty[rows]
    if picks.several is not None:
        chosen &= ~picks.several[picks.nodes_of(rows)]
    rows, far = rows[chosen], far[chosen]
    misfit = picks.misfit(state.values, rows)
    known = np.isfinite(misfit)
    return rows[known], far[known], misfit[known]


def smear_seen(inputs: Inputs, state: Heights, reach: float) -> Smear | None:
    """The smear of ignored data at nodes within some steps of trusted data of their side."""
    if not len(state.unknown):
        return None
    in_gap = picks_in_gaps(inputs, state)
    rows, far, misfit = ignored_misfits(inputs.picks, inputs.nearby, state, in_gap)

    # far extrapolation errs by itself, and would be taken for smear
    nodes = inputs.picks.nodes_of(rows)
    at = np.minimum(np.searchsorted(state.unknown, nodes), len(state.unknown) - 1)
    close = (state.unknown[at] == nodes) & (state.extrapolation[at] <= reach)
    return smear_of(far[close], misfit[close])


def overlapping_traces(state: Heights) -> frozenset[int]:
    """Traces at which the horizon overlaps: picks beyond the trace show the ends of the walls."""
    heaves = [walls.left + walls.right for walls in state.walls]
    return frozenset(k for k, h in enumerate(heaves) if len(h) and np.median(h) < -SENSE)
