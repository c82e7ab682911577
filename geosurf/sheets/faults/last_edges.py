"""The last link of a tear: both of its nodes on their own sides of the fault, or the sheet leaks.

There the walls are one again, so that throw dies there. Between the cut-offs of a fault that leaves
a gap, neither wall has rock, and a node has the height of one of them extrapolated past the fault.
That is cut off again, except at the last link, whose nodes both walls have: one that is beyond
the fault, or on it, goes to the fault, on its own side. A trace along a line of nodes has such
nodes only.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from geosurf.sheets.faults.cut_edges import FALLING, RISING, Cuts
from geosurf.sheets.faults.fault_distance import side_over
from geosurf.sheets.faults.traces import FaultMesh
from geosurf.sheets.lattice.frame import Frame

CLEAR = 1e-4  # cells above and below a node within which it is still on its own side
HALVINGS = 60  # of the way between both walls, until the fault is found
AT_ONCE = 4  # halvings for which the fault is asked once


def last_link(
    cuts: Cuts, trace: int, end: int, limit: float, rising: bool, n_col: int
) -> tuple[int, ...]:
    """Both nodes of the link of the mesh at which a tear ends: the first one outside of a limit."""
    rows = np.flatnonzero((cuts.trace == trace) & (cuts.kind != (FALLING if rising else RISING)))

    # distance of each link outside of the limit, as vertex numbers; the nearest one is the last
    past = limit - cuts.place[rows] if end == 0 else cuts.place[rows] - limit
    rows, past = rows[past > 0], past[past > 0]
    if not len(rows) or not np.isfinite(limit):
        return ()
    one, two = cuts.take(rows[[past.argmin()]]).ends(n_col)
    return int(one[0]), int(two[0])


def on_own_side(
    mesh: FaultMesh, frame: Frame, node: int, side: float, height: float, other: float
) -> float:
    """Height at which a node is on a side (+1 hanging wall) of a fault, as near as can be.

    `height` is that of its own wall, `other` that of the other one, extrapolated to it.
    """
    cells = frame.cells_of_node(np.array([node]))[0]
    reach = 1.0 + abs(other - height) / frame.cell
    clear = CLEAR * frame.cell

    side_at = side_over(mesh, cells, reach)
    above, below = (side_at(np.array([height + clear, height - clear])) == side).tolist()

    # on its side, or within `clear` of the fault: a small step away from it decides
    if above and below:
        return height
    if above or below:
        return height + 2.0 * clear if above else height - 2.0 * clear

    def own(z: np.ndarray) -> list[bool]:
        """Whether the node is on its side at some elevations."""
        found: list[bool] = (side_at(z) == side).tolist()
        return found

    return _between(own, height, other, clear)


def _between(
    own: Callable[[np.ndarray], list[bool]], height: float, other: float, clear: float
) -> float:
    """The elevation nearest to a height, on the way to another one, that is on its own side."""
    if not own(np.array([other]))[0]:
        return height

    # bisection: the side changes once between both heights; 60 halvings reach the last digit
    good, bad = other, height
    for _ in range(HALVINGS // AT_ONCE):
        if 0.5 * (good + bad) in (good, bad):
            break
        # all elevations that the next halvings can come to; k is halved into 2 k + 1 and 2 k + 2
        ends, middles = [(good, bad)], list[float]()
        for one, two in ends:
            middles.append(0.5 * (one + two))
            if len(ends) < 2**AT_ONCE - 1:
                ends += [(middles[-1], two), (one, middles[-1])]
        is_own, k = own(np.array(middles)), 0
        while k < len(middles):
            good, bad = (middles[k], bad) if is_own[k] else (good, middles[k])
            k = 2 * k + (1 if is_own[k] else 2)
    return good + float(np.clip(other - good, -2.0 * clear, 2.0 * clear))
