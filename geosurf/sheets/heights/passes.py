"""Picks and faults -> heights of all nodes, each side of a fault from its own side only.

Two passes. The first ignores data generously. The heights of its two walls at each trace show where
the horizon has a gap (normal fault) or an overlap (reverse fault), and how wide. The second has the
trim that the user chose, and uses this: values inside a gap belong to neither wall, and where the
sheet of the other side overlaps, values beyond the trace belong to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geosurf.kernels.lattices.sets import distinct
from geosurf.sheets.faults.cut_edges import Part
from geosurf.sheets.faults.fault_distance import near_traces
from geosurf.sheets.faults.traces import FaultMesh
from geosurf.sheets.heights.evidence import overlapping_traces, picks_in_gaps, smear_seen
from geosurf.sheets.heights.grid_solver import GridSolver, far_from_data
from geosurf.sheets.heights.inputs import Trims, inputs_of
from geosurf.sheets.heights.point_solver import PointSolver
from geosurf.sheets.heights.selection import select
from geosurf.sheets.heights.state import Evidence, Heights, Selection, Tears
from geosurf.sheets.lattice.noise import Noise, weight_of
from geosurf.sheets.lattice.picks import Picks

MAP_REACH = 12.0  # cells: how far from a trace sides are looked at in the map
BRIDGE = 0.75  # cells next to the cut-offs that are bridged to find the trace between them

Solver = GridSolver | PointSolver


@dataclass(frozen=True, eq=False)
class Rebuilt:
    """Heights of all nodes after both passes, with what the second pass was given.

    Attributes
    ----------
    solver : GridSolver or PointSolver
    selection : Selection
    evidence : Evidence
        With the traces whose walls the second pass rebuilt without each other.
    state : Heights
    """

    solver: Solver
    selection: Selection
    evidence: Evidence
    state: Heights

    def torn_between(
        self, state: Heights, limits: np.ndarray, untorn: Sequence[Part] = ()
    ) -> Heights:
        """The second pass again, torn between other places (n_trace, 2) of the same traces.

        `untorn` are parts of traces, between two places along them [cells], that are left out.
        """
        # walls and gaps stay those of the whole tear: they say what a datum is, not where it is
        # torn
        tears = state.tears.between(limits).without(untorn)
        found = self.solver.solve(self.selection, tears, self.evidence)
        return replace(found, walls=state.walls, in_gap=state.in_gap)


def solver_of(
    picks: Picks,
    meshes: list[FaultMesh],
    trims: Trims,
    noise: float | None = None,
    fill_empty_blocks: bool = False,
    highest: int = 4,
) -> Solver:
    """The solver that fits the data.

    `noise` is its standard deviation [m], None to estimate it; `highest` the most that the order of
    small differences may be: see `geosurf.sheets.lattice.solve`.
    """
    inputs = inputs_of(picks, meshes, trims)
    solver = GridSolver.over(inputs) if picks.on_nodes else PointSolver.over(inputs)

    # the signal is needed even where the noise is given: the weight is their ratio
    estimate, signal = solver.estimate_noise()
    deviation = estimate if noise is None else float(noise)
    weight = weight_of(deviation, signal, picks.frame.cell)
    if picks.several is not None:  # where sheets overlap they are extrapolated too far for fourth
        highest = 3
    noise_of_data = Noise(deviation, weight, signal, highest)
    return replace(solver, noise=noise_of_data, fill_empty_blocks=fill_empty_blocks)


def rebuild(solver: Solver) -> Rebuilt:
    """Run both passes."""
    inputs = solver.inputs
    frame = inputs.picks.frame

    # first pass: how wide are gaps and overlaps, how far off is what it ignored
    selection, state = single_pass(solver, inputs.first_trim)
    if len(state.stray):  # the generous trim left nothing between two faults
        selection, state = single_pass(solver, inputs.trim)
    state = state.with_walls(frame)

    # scattered points are not smeared by a gridder
    smear = None
    if inputs.picks.on_nodes:
        smear = smear_seen(inputs, state, far_from_data(selection.trim))
    state = _retraced(solver, selection, Evidence(smear=smear), state)

    # second pass, with what the first one showed
    # now known: throw and sense of each fault, so overlap or gap, smear, and better traces
    throws = [float(np.abs(walls.throw).max(initial=0.0)) for walls in state.walls]
    evidence = Evidence(throws, smear, overlapping_traces(state))
    selection = select(inputs, inputs.trim, state.tears, state)
    state = solver.solve(selection, state.tears, evidence, state.filled_blocks)
    state = state.with_walls(frame)
    state = replace(state, in_gap=picks_in_gaps(inputs, state))

    # whether walls are shared is decided once: later solves, which close the mesh, must agree
    evidence = replace(evidence, apart=state.apart, apart_is_final=True)
    return Rebuilt(solver, selection, evidence, state)


def single_pass(solver: Solver, trim: float) -> tuple[Selection, Heights]:
    """A pass that knows nothing of an earlier one: what is nearer than `trim` is ignored."""
    inputs = solver.inputs
    network = solver.first_network(inputs.within(trim))
    near = near_traces(inputs.picks.frame, network.traces, MAP_REACH)
    tears = Tears(network, near, network.cuts).between(network.solve)
    selection = select(inputs, trim, tears, None)
    return selection, solver.solve(selection, tears, Evidence())


def _retraced(solver: Solver, selection: Selection, evidence: Evidence, state: Heights) -> Heights:
    """The same heights with traces on them: bridged between both walls, no farther."""
    frame = solver.inputs.picks.frame

    lost = distinct(bridged_nodes(state), state.unknown[np.isnan(state.values[state.unknown])])
    network = solver.network_on(state.values, lost)
    near = near_traces(frame, network.traces, MAP_REACH)
    tears = Tears(network, near, network.cuts).between(network.solve)
    return solver.solve(selection, tears, evidence).with_walls(frame)


def bridged_nodes(state: Heights) -> np.ndarray:
    """Nodes between both walls of traces, where a gap has no rock: drapes are drawn across them."""
    bridged = [state.unknown[:0]]
    for beside, walls in zip(state.near, state.walls, strict=True):
        widest = max(walls.left.max(initial=0.0), walls.right.max(initial=0.0))
        at = beside.within(widest + BRIDGE)
        gap = np.maximum(walls.gap(beside.place[at], beside.side[at]), 0.0)
        bridged.append(beside.node[at[beside.distance[at] < gap + BRIDGE]])
    return distinct(*bridged)
