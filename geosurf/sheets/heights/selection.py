"""Which picks a pass uses: neither those near a fault nor those of the other wall."""

from __future__ import annotations

import numpy as np

from geosurf.sheets.faults.fault_distance import rows_near
from geosurf.sheets.heights.inputs import Inputs
from geosurf.sheets.heights.state import SENSE, Heights, Selection, Tears


def select(inputs: Inputs, trim: float, tears: Tears, before: Heights | None) -> Selection:
    """Choose the picks of one pass; `before`: heights of an earlier one, with walls."""
    # two reasons to ignore a pick: near a fault at its own height, or across the trace in the map.
    # Either alone fails: gridded data carried into a gap are on a wrong side in 3-D, overlaps in
    # the map
    ignored = inputs.within(trim)
    wrong, beyond = _wrong_side(inputs, ignored, tears, before)
    single = ~wrong
    if inputs.picks.several is not None:
        single &= ~inputs.picks.several[inputs.picks.node]
    return Selection(trim, ignored | wrong, single, beyond)


def _wrong_side(
    inputs: Inputs, ignored: np.ndarray, tears: Tears, before: Heights | None
) -> tuple[np.ndarray, np.ndarray]:
    """Picks on the wrong side of a trace, bool (n_pick,); those of an overlapping sheet (n, 3)."""
    picks, network = inputs.picks, tears.network
    wrong, beyond = inputs.misplaced(), []
    nodes = [picks.nodes_of(inputs.nearby[trace.fault].rows) for trace in network.traces]
    for number, at in enumerate(rows_near(tears.near, nodes)):
        near = tears.near[number]
        own = inputs.nearby[network.traces[number].fault]
        rows, side, far, at = (values[at >= 0] for values in (own.rows, own.side, own.far, at))

        # a pick is across where its side at its own height is not that of its node in the map
        place, here = near.place[at], near.side[at]
        first, last = network.mesh[number]  # beyond the rim of the data, where it leaves them
        inside = (place > first) & (place < last)
        across = inside & (side != here)

        if before is not None:
            walls = before.walls[number]
            heave = walls.heave(place)

            # there is no horizon between the cut-offs of a gap: values there were interpolated
            in_gap = near.distance[at] < walls.gap(place, here)
            several = False if picks.several is None else picks.several[picks.nodes_of(rows)]
            close = near.distance[at] < 1.0 + np.abs(heave)
            wrong[rows[inside & (heave > SENSE) & (in_gap | (several & close))]] = True

            # in an overlap, picks across belong to the sheet of the other side
            mine = (
                across
                & (heave < -SENSE)
                & (far >= inputs.trim * inputs.shares[network.traces[number].fault])
                & ~ignored[rows]
            )
            number_of = np.full(mine.sum(), number)
            beyond.append(np.stack([rows[mine], number_of, side[mine].astype(np.int64)], axis=1))
        wrong[rows[across]] = True
    return wrong, np.concatenate([np.empty((0, 3), dtype=np.int64), *beyond])
