"""Heights from scattered points: all nodes are unknown, and each point is a row of the equations.

A point is used if no link of its cell is cut: then all four nodes are on one wall. The surface is
the one with the smallest third differences that meets all points as well as their noise allows,
after Briggs (1974), Geophysics 39, 39-48. Shapes of tips are taken out of it as
`geosurf.sheets.heights.tip_residual` does on grids.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geosurf.kernels.sheets.column_products import products_of_columns, sums_of_columns
from geosurf.sheets.faults.cut_edges import Cuts
from geosurf.sheets.faults.network import Network
from geosurf.sheets.faults.tips import Tips, tips_of
from geosurf.sheets.heights.empty_blocks import bridge
from geosurf.sheets.heights.grid_solver import FILL
from geosurf.sheets.heights.inputs import Inputs
from geosurf.sheets.heights.relief import common_relief
from geosurf.sheets.heights.state import Evidence, Heights, Selection, Tears
from geosurf.sheets.heights.tip_residual import (
    Bent,
    groups_of,
    likely_shares,
    paying_shares,
    shapes_of,
)
from geosurf.sheets.heights.tip_solve import Solved, losing, shared_unless
from geosurf.sheets.lattice.drape import narrow_gaps, without_absent
from geosurf.sheets.lattice.noise import Noise, signal_of, weight_of
from geosurf.sheets.lattice.scattered import Scattered, noise_of_points
from geosurf.sheets.lattice.solve import (
    BEND,
    Common,
    Graph,
    lattice_graph,
    reached,
    steps_to_known,
    weights_of,
)
from geosurf.sheets.lattice.sparse import CHOLESKY, EXACT, energy_of

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
    """

    graph: Graph
    slot: np.ndarray
    rows: np.ndarray


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
        equations = Equations(_part_of(graph, tied, number), slot, rows)
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
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import splu

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
        whole = csc_array(energy + weight * (points.T @ points))
        factor = splu(whole, **CHOLESKY)
        found: np.ndarray = factor.solve(weight * (points.T @ z))
        if not tips:
            return found[:n] + level, None

        # shapes of tips that make what is left smoother
        frame, nodes = picks.frame, np.flatnonzero(equations.slot >= 0)
        shapes = shapes_of(tips, frame, nodes)
        shapes = np.concatenate([shapes, np.zeros((more, shapes.shape[1]))])
        drawn = energy @ shapes
        moved = factor.solve(drawn)
        doubt = self.noise.energy
        cost = found * (energy @ found) + weight * (points.T @ (z - points @ found) ** 2)
        groups = groups_of(tips, frame, nodes)
        share = paying_shares(
            own=products_of_columns(shapes, drawn) - products_of_columns(drawn, moved),
            wanted=products_of_columns(drawn, found[:, None])[:, 0],
            groups=[columns for columns, _ in groups],
            likely=likely_shares(tips, throws),
            doubt=doubt,
            units=[doubt or cost[around].mean() for _, around in groups],
            towards=[tip.throw_towards() for tip in tips],
        )
        found = found + sums_of_columns(moved, share)
        return found[:n] + level, Bent(list(tips), share) if share.any() else None


def _part_of(graph: Graph, chosen: np.ndarray, number: np.ndarray) -> Graph:
    """The part of a graph with chosen nodes, bool (n,); `number` is their new one, -1 elsewhere."""
    east, north = (np.where(to >= 0, number[to], -1)[chosen] for to in (graph.east, graph.north))
    return Graph(east, north, graph.square[chosen], graph.cell[chosen])
