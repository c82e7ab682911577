"""Picks and faults -> heights of all nodes, each side of a fault from its own side only.

Two passes. The first ignores data generously. The heights of its two walls at each trace show where
the horizon has a gap (normal fault) or an overlap (reverse fault), and how wide. The second has the
trim that the user chose, and uses this: values inside a gap belong to neither wall, and where the
sheet of the other side overlaps, values beyond the trace belong to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import splu

from geosurf.kernels.lattices.sets import distinct
from geosurf.kernels.sheets.node_bands import products_of_columns, sums_of_columns
from geosurf.model import frozen
from geosurf.model.sheets import BaseHeights, TearPlan
from geosurf.sheets.faults.cut_edges import Cuts, Part, Walls
from geosurf.sheets.faults.fault_distance import near_traces, rows_near
from geosurf.sheets.faults.network import Network
from geosurf.sheets.faults.tips import Tips, tips_of
from geosurf.sheets.faults.traces import FaultMesh, Trace
from geosurf.sheets.heights.cutoffs import drawn_again, drawn_by_polygons
from geosurf.sheets.heights.grid_solver import DRAWN, FILL, GridSolver, bridge, far_from_data
from geosurf.sheets.heights.relief import common_relief
from geosurf.sheets.heights.state import (
    SENSE,
    Cutoffs,
    Drawn,
    Evidence,
    Heights,
    Inputs,
    NearPicks,
    Selection,
    Smear,
    Tears,
    Trims,
    distances,
    inputs_of,
    smear_of,
)
from geosurf.sheets.heights.tip_solve import (
    Bent,
    Solved,
    groups_of,
    likely_shares,
    losing,
    paying_shares,
    shapes_of,
    shared_unless,
)
from geosurf.sheets.lattice.data import Scattered, noise_of_points
from geosurf.sheets.lattice.picks import Noise, Picks, signal_of, weight_of
from geosurf.sheets.lattice.solve import (
    BEND,
    CHOLESKY,
    EXACT,
    Common,
    Graph,
    energy_of,
    lattice_graph,
    narrow_gaps,
    reached,
    steps_to_known,
    weights_of,
    without_absent,
)

# ---- evidence ----------------------------------------
# What a finished pass shows: picks in gaps, and how far off the data are that it ignored.


def picks_in_gaps(inputs: Inputs, state: Heights) -> np.ndarray:
    """Picks that lie between the cut-offs of a fault in the map."""
    in_gaps = [np.empty(0, dtype=np.int64)]
    for trace, near, walls in zip(state.network.traces, state.near, state.walls, strict=True):
        # in the gap: nearer to the trace than the cut-off of the wall on its own side of the map
        rows = inputs.nearby[trace.fault].rows
        at = near.look_up(inputs.picks.nodes_of(rows))
        rows, at = rows[at >= 0], at[at >= 0]
        gap = walls.gap(near.place[at], near.side[at])
        in_gaps.append(rows[near.distance[at] < gap])
    return distinct(*in_gaps)


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


# ---- selection ----------------------------------------
# Which picks a pass uses: neither those near a fault nor those of the other wall.


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
            overlapping = (
                across
                & (heave < -SENSE)
                & (far >= inputs.trim * inputs.shares[network.traces[number].fault])
                & ~ignored[rows]
            )
            number_of = np.full(overlapping.sum(), number)
            columns = rows[overlapping], number_of, side[overlapping].astype(np.int64)
            beyond.append(np.stack(columns, axis=1))
        wrong[rows[across]] = True
    return wrong, np.concatenate([np.empty((0, 3), dtype=np.int64), *beyond])


# ---- point solver ----------------------------------------
# Heights from scattered points: all nodes are unknown, and each point is a row of the equations.
#
# A point is used if no link of its cell is cut: then all four nodes are on one wall. The surface is
# the one with the smallest third differences that meets all points as well as their noise allows,
# after Briggs (1974), Geophysics 39, 39-48. Shapes of tips are taken out of it as
# `geosurf.sheets.heights.tip_solve` does on grids.


SMOOTH = 5e-3  # weight by which points are smoothed to see the surface below their noise


@dataclass(frozen=True, eq=False)
class Equations:
    """Nodes that are solved for, and the points that are rows of the equations.

    Attributes
    ----------
    graph : Graph
    slot : ndarray of int64 (n_node,)
        Row of each node of the lattice in the graph, -1 if it is not solved for.
    rows : ndarray of int64
        Points.
    drawn : Drawn or None
        What fault polygons draw.
    """

    graph: Graph
    slot: np.ndarray
    rows: np.ndarray
    drawn: Drawn | None = None


@dataclass(frozen=True, eq=False)
class PointSolver:
    """Solves for the heights of one horizon of scattered points.

    Attributes
    ----------
    inputs : Inputs
    noise : Noise
    fill_empty_blocks : bool
        Whether blocks without data, larger than slivers, are joined to a neighbour.
    corners : ndarray of int64 (n_point, 4)
        Nodes of the cell of each point.
    share : ndarray (n_point, 4)
        Of each corner in the height at the point.
    present : ndarray of bool (n_node,)
        Corners of cells with points, and nodes in narrow gaps between them.
    """

    inputs: Inputs
    noise: Noise
    fill_empty_blocks: bool
    corners: np.ndarray
    share: np.ndarray
    present: np.ndarray

    @classmethod
    def over(cls, inputs: Inputs) -> PointSolver:
        """A solver that meets points exactly, until `replace` gives it their noise."""
        picks = inputs.picks
        assert isinstance(picks, Scattered)
        corners, share = picks.corners()
        used = np.zeros(picks.n_node, dtype=bool)
        used[corners] = True
        grid = used.reshape(picks.frame.shape)
        present = (grid | narrow_gaps(grid, FILL)).ravel()
        return cls(inputs, Noise(), False, corners, share, present)

    def estimate_noise(self) -> tuple[float, float]:
        """Noise of the points, and typical third difference of the surface per cell [m]."""
        picks, ignored = self.inputs.picks, self.inputs.within(np.inf)
        assert isinstance(picks, Scattered)
        noise = noise_of_points(picks, ~ignored)
        if weight_of(noise, 0.0, picks.frame.cell) is None:
            return noise, 0.0
        smoothing = replace(self, noise=Noise(weight=SMOOTH))  # what is left then is the surface
        grid = np.where(self._touched(~ignored), smoothing.drape(ignored, BEND), np.nan)
        return noise, signal_of(grid.reshape(picks.frame.shape))

    def drape(self, ignored: np.ndarray, bend: float = 1.0) -> np.ndarray:
        """Heights (n_node,) of the surface through the points in use, not torn anywhere."""
        graph, slot = self._graph(None)
        rows = ~ignored & (slot[self.corners] >= 0).all(axis=1)
        found, _ = self._solved(Equations(graph, slot, np.flatnonzero(rows)), bend)
        out = np.full(self.inputs.picks.n_node, np.nan)
        out[slot >= 0] = found
        return out

    def first_network(self, ignored: np.ndarray) -> Network:
        """Traces on the surface through the points in use."""
        return self.inputs.network(self.drape(ignored), np.flatnonzero(~self._touched(~ignored)))

    def network_on(self, heights: np.ndarray, lost: np.ndarray) -> Network:
        """Traces on solved heights, drawn again across some nodes: writes there."""
        heights[lost] = np.nan
        return self.inputs.network_across(heights, lost[self.present[lost]])

    def _touched(self, used: np.ndarray) -> np.ndarray:
        """Nodes of the cells of some points, bool (n_node,)."""
        touched = np.zeros(self.inputs.picks.n_node, dtype=bool)
        touched[self.corners[used]] = True
        return touched

    def _graph(self, bits: np.ndarray | None) -> tuple[Graph, np.ndarray]:
        """Graph of all present nodes, and the row (n_node,) of each in it."""
        nodes = np.flatnonzero(self.present)
        slot = np.full(len(self.present), -1)
        slot[nodes] = np.arange(len(nodes))
        graph = lattice_graph(nodes, self.inputs.picks.frame.shape, bits)
        return without_absent(graph, np.ones(len(nodes), dtype=bool)), slot

    def solve(
        self,
        selection: Selection,
        tears: Tears,
        evidence: Evidence,
        filled_blocks: tuple[dict, ...] = (),
    ) -> Heights:
        """Solve for all nodes, from the points in use whose cell no cut link divides."""
        n_node = self.inputs.picks.n_node
        graph, slot = self._graph(tears.cuts.bits(n_node))
        rows = np.flatnonzero(~selection.ignored & self.whole(tears.cuts))

        # blocks that no point reaches are joined to a neighbour, if they may
        touched = np.zeros(len(graph.east), dtype=bool)
        touched[slot[self.corners[rows]]] = True
        if evidence.drawn is not None:
            drawn = slot[evidence.drawn.node]
            touched[drawn[drawn >= 0]] = True
        far = ~touched
        tied = reached(graph, far)
        nodes = np.flatnonzero(self.present)
        stray = nodes[~tied]
        bridged = bridge(self.inputs, stray, tears, self.fill_empty_blocks)
        if bridged is not None:
            tears, note = bridged
            return self.solve(selection, tears, evidence, (*filled_blocks, note))

        # all other nodes at once
        values = np.full(n_node, np.nan)
        number = np.where(tied, np.cumsum(tied) - 1, -1)
        slot[nodes] = number
        equations = Equations(_part_of(graph, tied, number), slot, rows, evidence.drawn)
        (values[nodes[tied]], bent), apart = self._shared(equations, tears, evidence)
        steps = steps_to_known(graph, np.where(far, 0, -1))[far]
        ignored = np.ones(len(selection.ignored), dtype=bool)
        ignored[rows] = False
        return Heights(
            values=values,
            tears=tears,
            used=~ignored,
            ignored=ignored,
            unknown=nodes[far],
            extrapolation=steps.astype(np.float64),
            beyond=selection.beyond,
            stray=stray,
            filled_blocks=filled_blocks,
            bent=bent,
            apart=apart,
        )

    def whole(self, cuts: Cuts) -> np.ndarray:
        """Points whose cell no cut link divides, bool (n_point,)."""
        bits = cuts.bits(self.inputs.picks.n_node)
        a, b, d = self.corners[:, 0], self.corners[:, 1], self.corners[:, 2]
        return (bits[a] == 0) & (bits[b] & 2 == 0) & (bits[d] & 1 == 0)

    def _shared(
        self, equations: Equations, tears: Tears, evidence: Evidence
    ) -> tuple[Solved, frozenset[int]]:
        """Heights of all nodes, under noise with what walls have in common."""
        if evidence.throws is None:
            return self._solved(equations), evidence.apart
        network, near, cuts = tears.network, tears.near, tears.cuts
        tips = tips_of(network.traces, near, cuts)
        throws = evidence.throws

        def solve(common: Common | None) -> Solved:
            """Heights of all nodes."""
            return self._solved(equations, tips=tips, throws=throws, common=common)

        if self.noise.weight is None:
            return solve(None), evidence.apart
        picks, slot, rows = self.inputs.picks, equations.slot, equations.rows
        nodes, at, share = np.flatnonzero(slot >= 0), slot[self.corners[rows]], self.share[rows]
        scale, z = self.noise.scale, picks.z[rows]
        weights = weights_of(picks.frame.stretch, BEND, scale=scale)

        def common_of(apart: frozenset[int]) -> Common | None:
            """What the walls have in common that are not apart."""
            return common_relief(nodes, cuts, network, near, picks.frame.shape, weights, apart)

        def against(found: np.ndarray, alone: np.ndarray) -> set[int]:
            """Traces next to which points are missed by too much."""
            missed, before = (((h[at] * share).sum(axis=1) - z) ** 2 for h in (found, alone))
            worse = (missed - before) / self.noise.deviation**2
            return losing(near, picks.node[rows], worse, scale)

        return shared_unless(against, solve, common_of, evidence.apart, evidence.apart_is_final)

    def _solved(
        self,
        equations: Equations,
        bend: float = BEND,
        tips: Sequence[Tips] = (),
        throws: Sequence[float] = (),
        common: Common | None = None,
    ) -> Solved:
        """Heights of all nodes of a graph, smooth except at tips, and near its points."""
        # the energy of nodes, and of coefficients of what walls have in common
        picks, graph, rows = self.inputs.picks, equations.graph, equations.rows
        n = len(graph.east)
        weights = weights_of(picks.frame.stretch, bend, scale=self.noise.scale)
        energy = energy_of(graph, np.arange(n), weights)
        more = 0
        if common is not None:
            more = common.n_coefficient
            energy.resize((n + more, n + more))
            energy = csc_array(energy + common.matrix.T @ common.matrix)

        # one row for each point
        weight = self.noise.weight or EXACT
        each = np.repeat(np.arange(len(rows)), 4), equations.slot[self.corners[rows]].ravel()
        points = csc_array((self.share[rows].ravel(), each), shape=(len(rows), n + more))
        level = float(picks.z[rows].mean())
        z = picks.z[rows] - level
        right = weight * (points.T @ z)
        pulled = np.zeros(n + more)
        if equations.drawn is not None:
            at = equations.slot[equations.drawn.node]
            pulled[at[at >= 0]] = DRAWN
            right[at[at >= 0]] += DRAWN * (equations.drawn.height[at >= 0] - level)
        whole = csc_array(energy + weight * (points.T @ points) + diags_array(pulled))
        factor = splu(whole, **CHOLESKY)
        heights: np.ndarray = factor.solve(right)
        if not tips:
            return heights[:n] + level, None

        # shapes of tips that make what is left smoother
        frame, nodes = picks.frame, np.flatnonzero(equations.slot >= 0)
        shapes = shapes_of(tips, frame, nodes)
        shapes = np.concatenate([shapes, np.zeros((more, shapes.shape[1]))])
        drawn = energy @ shapes
        moved = factor.solve(drawn)
        doubt = self.noise.energy
        cost = heights * (energy @ heights) + weight * (points.T @ (z - points @ heights) ** 2)
        groups = groups_of(tips, frame, nodes)
        share = paying_shares(
            shape_energy=products_of_columns(shapes, drawn) - products_of_columns(drawn, moved),
            wanted=products_of_columns(drawn, heights[:, None])[:, 0],
            groups=[columns for columns, _ in groups],
            likely=likely_shares(tips, throws),
            doubt=doubt,
            units=[doubt or cost[around].mean() for _, around in groups],
            towards=[tip.throw_towards() for tip in tips],
        )
        heights = heights + sums_of_columns(moved, share)
        return heights[:n] + level, Bent(list(tips), share) if share.any() else None


def _part_of(graph: Graph, chosen: np.ndarray, number: np.ndarray) -> Graph:
    """The part of a graph with chosen nodes, bool (n,); `number` is their new one, -1 elsewhere."""
    east, north = (np.where(to >= 0, number[to], -1)[chosen] for to in (graph.east, graph.north))
    return Graph(east, north, graph.square[chosen], graph.cell[chosen])


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
    filled : tuple of dict
        Notes of blocks at faults without data that were filled before.
    pinched : ndarray of int64, shape (n,)
        Nodes of blocks without data that have heights of another horizon.
    """

    solver: Solver
    selection: Selection
    evidence: Evidence
    state: Heights
    filled: Sequence[dict] = ()
    pinched: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=np.int64))

    @property
    def picks(self) -> Picks | Scattered:
        """The data, with blocks that were filled."""
        return self.solver.inputs.picks

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
    cutoffs: Cutoffs | None = None,
) -> Solver:
    """The solver that fits the data.

    `noise` is its standard deviation [m], None to estimate it; `highest` the most that the order of
    small differences may be: see `geosurf.sheets.lattice.solve`; `cutoffs` lines of polygons.
    """
    inputs = replace(inputs_of(picks, meshes, trims), cutoffs=cutoffs or {})
    solver = GridSolver.over(inputs) if picks.on_nodes else PointSolver.over(inputs)

    # the signal is needed even where the noise is given: the weight is their ratio
    estimate, signal = solver.estimate_noise()
    deviation = estimate if noise is None else float(noise)
    weight = weight_of(deviation, signal, picks.frame.cell)
    if picks.several is not None:  # where sheets overlap they are extrapolated too far for fourth
        highest = 3
    noise_of_data = Noise(deviation, weight, signal, highest, noise is not None)
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
    drawn = drawn_by_polygons(inputs, state)
    state = _retraced(solver, selection, Evidence(smear=smear, drawn=drawn), state)

    # second pass, with what the first one showed
    # now known: throw and sense of each fault, so overlap or gap, smear, and better traces
    throws = [float(np.abs(walls.throw).max(initial=0.0)) for walls in state.walls]
    drawn = drawn_by_polygons(inputs, state)
    evidence = Evidence(throws, smear, overlapping_traces(state), drawn=drawn)
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
    mains = state.network.ended(state.walls)
    network = solver.network_on(state.values, lost)
    network.end_at(mains, solver.inputs.meshes)
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


# ---- base case ----------------------------------------
# Heights of data that differ little from those of another sheet: one solve in place of three.
#
# The first two solves of a horizon serve to find its traces, its walls, and the smear of its data.
# Data of an ensemble's realisations are those of the base case, moved up or down. So its rebuilt
# nodes are moved as their data are, and traces are drawn on these heights. Walls and smear stay.


def base_heights(rebuilt: Rebuilt) -> BaseHeights | None:
    """What realisations need of a sheet; None for scattered points and where blocks were filled."""
    state, solver = rebuilt.state, rebuilt.solver
    if not isinstance(solver, GridSolver) or state.filled_blocks:
        return None
    smear, nodes, drawn = rebuilt.evidence.smear, state.unknown, rebuilt.evidence.drawn
    pairs = zip(state.network.traces, state.walls, strict=True)
    walls = [[_share(trace, w.place), w.left, w.right, w.throw] for trace, w in pairs]
    return BaseHeights(
        frozen(nodes, np.int64),
        frozen(state.values[nodes] - solver.inputs.picks.means[nodes], np.float64),
        frozen(bridged_nodes(state), np.int64),
        tuple(frozen(of, np.float64) for of in walls),
        None if smear is None else frozen(smear.spread, np.float64),
        tuple(sorted(int(k) for k in rebuilt.evidence.apart)),
        frozen(
            np.empty((3, 0)) if drawn is None else [drawn.node, drawn.trace, drawn.side], np.int64
        ),
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
    moved = grid.values.copy()  # the network is drawn on bridged ones
    nothing = np.zeros(len(picks.z), dtype=bool)
    lost = distinct(base.bridged, base.nodes[np.isnan(grid.values[base.nodes])])
    network = solver.network_on(grid.values, lost)
    numbers = {f"branch of {mesh.name}": k for k, mesh in enumerate(inputs.meshes)}
    mains = {
        (fault, numbers[end]) for fault, *ends in plan.traces for end in ends if end in numbers
    }
    network.end_at(mains, inputs.meshes)
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
    # walls keep the height over their data that polygons gave them in the base case
    if base.drawn.size:
        evidence = replace(evidence, drawn=drawn_again(base.drawn, near, moved))
    return Rebuilt(solver, select(inputs, inputs.trim, tears, before), evidence, before)


def _share(trace: Trace, place: np.ndarray) -> np.ndarray:
    """Places along a trace as shares of the part on its fault."""
    first, last = trace.inside
    return (trace.length_at(place) - first) / (last - first)


def _place(trace: Trace, share: np.ndarray) -> np.ndarray:
    """The inverse of `_share`."""
    first, last = trace.inside
    return trace.place_at(first + share * (last - first))
