"""Heights of data that differ little from those of another sheet: one solve in place of three.

The first two solves of a horizon serve to find its traces, its walls, and the smear of its data.
Data of an ensemble's realisations are those of the base case, moved up or down. So its rebuilt
nodes are moved as their data are, and traces are drawn on these heights. Walls and smear stay.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.lattices.sets import distinct
from geosurf.model import frozen
from geosurf.model.sheets import BaseHeights, TearPlan
from geosurf.sheets.faults.fault_distance import near_traces
from geosurf.sheets.faults.heave import Walls
from geosurf.sheets.faults.traces import Trace
from geosurf.sheets.heights.grid_solver import GridSolver
from geosurf.sheets.heights.passes import MAP_REACH, Rebuilt, Solver, bridged_nodes
from geosurf.sheets.heights.selection import select
from geosurf.sheets.heights.smear import Smear
from geosurf.sheets.heights.state import Evidence, Heights, Tears


def base_heights(rebuilt: Rebuilt) -> BaseHeights | None:
    """What realisations need of a sheet; None for scattered points and where blocks were filled."""
    state, solver = rebuilt.state, rebuilt.solver
    if not isinstance(solver, GridSolver) or state.filled_blocks:
        return None
    smear, nodes = rebuilt.evidence.smear, state.unknown
    pairs = zip(state.network.traces, state.walls, strict=True)
    walls = [[_share(trace, w.place), w.left, w.right, w.throw] for trace, w in pairs]
    return BaseHeights(
        frozen(nodes, np.int64),
        frozen(state.values[nodes] - solver.inputs.picks.means[nodes], np.float64),
        frozen(bridged_nodes(state), np.int64),
        tuple(frozen(of, np.float64) for of in walls),
        None if smear is None else frozen(smear.spread, np.float64),
        tuple(sorted(int(k) for k in rebuilt.evidence.apart)),
    )


def on_base_heights(solver: Solver, plan: TearPlan) -> Rebuilt | None:
    """What the last pass is given, with traces on moved heights; these are not solved for.

    None for a plan without them, and where the traces are others.
    """
    base, inputs = plan.base, solver.inputs
    if base is None or not isinstance(solver, GridSolver):
        return None
    picks, grid = inputs.picks, solver.grid

    # data that the base case used hold their nodes; those that it solved for move as their data
    grid.without(plan.use.ignored)
    grid.mark(base.nodes)
    grid.values[base.nodes] = picks.means[base.nodes] + base.off_data
    nothing = np.zeros(len(picks.z), dtype=bool)
    lost = distinct(base.bridged, base.nodes[np.isnan(grid.values[base.nodes])])
    network = solver.network_on(grid.values, lost)
    if plan.traces != tuple((int(t.fault), *map(str, t.ends)) for t in network.traces):
        return None

    near = near_traces(picks.frame, network.traces, MAP_REACH)
    tears = Tears(network, near, network.cuts).between(network.solve)
    walls = [
        Walls(_place(trace, share), left, right, throw)
        for trace, (share, left, right, throw) in zip(network.traces, base.walls, strict=True)
    ]
    throws = [float(np.abs(one.throw).max(initial=0.0)) for one in walls]
    smear = None if base.smear is None else Smear(base.smear)
    evidence = Evidence(throws, smear, frozenset(base.apart), apart_is_final=True)
    before = Heights(values=grid.values, tears=tears, used=nothing, ignored=nothing, walls=walls)
    return Rebuilt(solver, select(inputs, inputs.trim, tears, before), evidence, before)


def _share(trace: Trace, place: np.ndarray) -> np.ndarray:
    """Places along a trace as shares of the part on its fault."""
    first, last = np.interp([trace.start, trace.stop], np.arange(len(trace.along)), trace.along)
    along: np.ndarray = np.interp(place, np.arange(len(trace.along)), trace.along)
    return (along - first) / (last - first)


def _place(trace: Trace, share: np.ndarray) -> np.ndarray:
    """The inverse of `_share`."""
    vertex = np.arange(len(trace.along))
    first, last = np.interp([trace.start, trace.stop], vertex, trace.along)
    found: np.ndarray = np.interp(first + share * (last - first), trace.along, vertex)
    return found
