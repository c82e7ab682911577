"""Blocks between faults without data of their own: joined to a neighbour, or refused."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geosurf.errors import GeometryError
from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.sheets.faults.heave import throw_beside
from geosurf.sheets.faults.network import faults_in_words
from geosurf.sheets.heights.inputs import Inputs
from geosurf.sheets.heights.state import Heights, Tears
from geosurf.sheets.lattice.picks import Picks

SLIVER = 60  # nodes: blocks without data up to this size are always filled


def bridge(
    inputs: Inputs, stray: np.ndarray, tears: Tears, fill_empty_blocks: bool
) -> tuple[Tears, dict] | None:
    """Join a block without data to a neighbour, across the fault with the smaller throw.

    Returns the tears that stay, and a note; None if there is no such block, if it is larger than
    a sliver and `fill_empty_blocks` is not set, or if no fault bounds it.
    """
    if len(stray) == 0 or (len(stray) > SLIVER and not fill_empty_blocks):
        return None

    # links between the block and others: the traces that cut these are its borders
    cuts, frame = tears.cuts, inputs.picks.frame
    first, second = cuts.ends(frame.shape[1])
    inside = is_among(first, stray), is_among(second, stray)
    border = inside[0] != inside[1]
    if not border.any():
        return None
    choice = distinct(cuts.trace[border])
    throw = [throw_beside(inputs.picks.means, tears.near[t], stray) for t in choice]

    # the least throw is the least error, should the block not have been faulted with its neighbour
    trace = int(choice[int(np.argmin(throw))])

    # its links over that trace are whole now: the next solve continues the neighbour into it
    gone = (cuts.trace == trace) & (inside[0] | inside[1])
    name = inputs.meshes[tears.network.traces[trace].fault].name
    xy = frame.node_places(stray[:1])[0]
    note = {"nodes": len(stray), "over": name, "place": [float(c) for c in xy]}
    return replace(tears, cuts=cuts.take(np.flatnonzero(~gone))), note


def refuse_empty_blocks(picks: Picks, state: Heights, names: Sequence[str]) -> None:
    """Raise an error that names a block between faults without data of its own."""
    if len(state.stray) == 0:
        return
    at = picks.frame.node_places(state.stray[:1])[0]
    beside = sorted(
        {
            names[trace.fault]
            for trace, near in zip(state.network.traces, state.near, strict=True)
            if (near.look_up(state.stray) >= 0).any()
        }
    )
    level = float(np.median(picks.z))  # the block has no height of its own
    raise GeometryError(
        f"horizon {picks.name!r}: a block next to {faults_in_words(beside)} has no data beyond "
        f"the trim. It has {len(state.stray)} nodes, the first at (easting {at[0]:.3f}, northing "
        f"{at[1]:.3f}). Give a smaller trim, add data there, or set fill_empty_blocks=True to fill "
        "it from its neighbour.",
        place=(*at, level),
        surfaces=(picks.name, *beside),
    )
