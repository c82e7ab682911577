"""Where a tear ends early, both nodes of its last link go to their own sides of the fault.

A node between the cut-offs of both walls has a height that is extrapolated past the fault. Where
throw dies at it, the sheet would go around the fault there: by centimetres, as the fault passes
close to the node. Ending the tear yet earlier would lose the throw of another cell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geosurf.sheets.faults.last_edges import last_link, on_own_side
from geosurf.sheets.faults.traces import FaultMesh
from geosurf.sheets.heights.state import Heights

MOST = 0.1  # cells by which a node goes up or down


def with_last_links(
    state: Heights, limits: np.ndarray, meshes: Sequence[FaultMesh], rising: bool
) -> Heights:
    """Heights with which tears can end at the last links outside of limits (n_trace, 2).

    Only ends whose limits are not those of the network count. `meshes` are the faults in the frame
    of the lattice.
    """
    network, values = state.network, state.values.copy()
    frame = network.frame
    for i, k in np.argwhere(limits != network.solve).tolist():
        link = last_link(network.cuts, i, k, limits[i, k], rising, frame.shape[1])
        row = state.near[i].look_up(np.array(link, dtype=np.int64))
        for node, side in zip(link, state.near[i].side[row].tolist(), strict=True):
            old = float(values[node])
            # the side changes upwards or downwards, whichever wall the node was extrapolated from
            for other in (old + MOST * frame.cell, old - MOST * frame.cell):
                new = on_own_side(meshes[network.traces[i].fault], frame, node, side, old, other)
                if new != old:
                    values[node] = new
                    break
    return replace(state, values=values)
