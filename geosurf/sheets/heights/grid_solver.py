"""Heights of gridded picks: only the nodes near faults are unknown, all others keep their datum."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geosurf.errors import GeometryError
from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.sheets.faults.cut_edges import throw_beside
from geosurf.sheets.faults.network import Network, faults_in_words
from geosurf.sheets.faults.tips import tips_of
from geosurf.sheets.heights.relief import common_relief
from geosurf.sheets.heights.state import (
    SENSE,
    Evidence,
    Heights,
    Inputs,
    Selection,
    Tears,
    distance_of_nodes,
    wedge_nodes,
)
from geosurf.sheets.heights.tip_solve import Bent, Task
from geosurf.sheets.lattice.picks import Noise, Picks, noise_of
from geosurf.sheets.lattice.solve import (
    BEND,
    Common,
    Graph,
    around,
    lattice_graph,
    narrow_gaps,
    reached,
    smoothest,
    steps_to_known,
    weights_of,
    without_absent,
)

# ---- empty blocks ----------------------------------------
# Blocks between faults without data of their own: joined to a neighbour, or refused.


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


FILL = 16.0  # cells: absent nodes next to a trace are filled in gaps up to this width
WEDGE = 1.5  # trims, and at least
BETWEEN = 3.0  # trims from each of two faults within which a node is in a wedge between them
FEWEST = 4.0  # steps of extrapolation, from which ignored data are used in wedges
UNSEEN_PULL = 0.1  # and their weight, while the smear is not known
DRAWN = 0.1  # weight of fault polygons: averages over one and a half cells, as they are digitised
HOLDS = 0.5  # trims from a fault beyond which an ignored datum will do for a block without others
BESIDE = 1.5  # cells from a trace within which noise is smoothed whatever was ignored
COLLAR = 16  # nodes around the faults in which noise is smoothed


def far_from_data(trim: float) -> float:
    """Steps of extrapolation from which ignored data are used, in a pass with some trim."""
    return max(FEWEST, WEDGE * trim)


@dataclass(frozen=True, eq=False)
class Targets:
    """Data that draw solved nodes (n,): heights, weights, and whether they may do so alone."""

    data: np.ndarray
    pull: np.ndarray
    alone: np.ndarray


@dataclass(frozen=True, eq=False)
class GridSolver:
    """Solves for the heights of one gridded horizon.

    Attributes
    ----------
    inputs : Inputs
    noise : Noise
    fill_empty_blocks : bool
        Whether blocks without data, larger than slivers, are joined to a neighbour.
    grid : WorkingGrid
        Its values are those of all heights that `solve` returns.
    present : ndarray of bool (n_node,)
        Nodes with a pick.
    fillable : ndarray of int64
        Absent nodes in narrow gaps.
    """

    inputs: Inputs
    noise: Noise
    fill_empty_blocks: bool
    grid: WorkingGrid
    present: np.ndarray
    fillable: np.ndarray

    @classmethod
    def over(cls, inputs: Inputs) -> GridSolver:
        """A solver that meets data exactly, until `replace` gives it their noise."""
        # holes of the data stay holes, except for gaps next to a trace that are FILL wide at most
        present = np.isfinite(inputs.picks.means)
        gaps = narrow_gaps(present.reshape(inputs.picks.frame.shape), FILL)
        grid = WorkingGrid(inputs.picks)
        return cls(inputs, Noise(), False, grid, present, np.flatnonzero(gaps.ravel()))

    def trusted_grid(self) -> np.ndarray:
        """Heights (n_row, n_col) of the picks that no pass ignores."""
        self.grid.without(self.inputs.within(np.inf))
        return self.grid.values.reshape(self.inputs.picks.frame.shape)

    def estimate_noise(self) -> tuple[float, float]:
        """Noise of the data, and typical third difference of the surface [m]."""
        return noise_of(self.trusted_grid())

    def first_network(self, ignored: np.ndarray) -> Network:
        """Traces on the picks that are used, drawn across those that are ignored."""
        lost = self.grid.without(ignored)
        return self._network_across(lost)

    def network_on(self, heights: np.ndarray, lost: np.ndarray) -> Network:
        """Traces on the heights of the grid, drawn again across some nodes: writes there."""
        self.grid.mark(lost)
        heights[lost] = np.nan
        return self._network_across(lost[self.present[lost]])

    def _network_across(self, lost: np.ndarray) -> Network:
        # the drape is drawn across ignored data and gaps alike, so that a trace does not end in a
        # gap
        fill = distinct(lost, self.fillable)
        self.grid.mark(fill)
        return self.inputs.network_across(self.grid.values, fill)

    def solve(
        self,
        selection: Selection,
        tears: Tears,
        evidence: Evidence,
        filled_blocks: tuple[dict, ...] = (),
    ) -> Heights:
        """Solve for all nodes that no chosen pick holds, and for noisy ones around the faults."""
        frame = self.inputs.picks.frame
        n_node, heights = self.inputs.picks.n_node, self.grid.values

        # a band of nodes: unknown ones, noisy ones around them, and a rim that holds both
        unknown = self._unknown(self.grid.without(selection.ignored), tears)
        noisy = self._noisy(unknown, tears)
        every = distinct(unknown, noisy)
        # a noisy rim is free: held to data beyond it, bit for bit, the surface would bend
        band = every if len(noisy) else around(every, frame.shape, self.noise.order)
        graph = lattice_graph(band, frame.shape, tears.cuts.bits(n_node))
        at = np.searchsorted(band, every)
        value = heights[band]

        # nodes without a value that are not solved for do not exist
        is_unknown = np.zeros(len(band), dtype=bool)
        is_unknown[np.searchsorted(band, unknown)] = True
        graph = without_absent(graph, np.isfinite(value) | is_unknown)

        # data that draw nodes: noisy ones, and in wedges ignored ones
        # steps (n_band,): uncut links to the nearest known node, so that a datum behind a fault is
        # far; third differences run away over long extrapolation, so that bad data are better than
        # none
        steps = steps_to_known(graph, np.where(is_unknown, 0, -1))
        reach = int(far_from_data(selection.trim))
        lonely = (steps > reach) & ~_is_between_faults(band, tears, selection.trim)
        wedge = wedge_nodes(graph, np.where(lonely, 0, steps), reach, evidence.smear)
        targets = self._targets(every, noisy, band[wedge], selection, evidence)

        # blocks that no datum reaches are joined to a neighbour, if they may
        # a block is what uncut links join; one without any datum would make the matrix singular
        free = is_unknown.copy()
        free[at[targets.alone]] = False  # a datum that only draws the surface reaches it, too
        tied = reached(graph, free)
        stray = band[~tied]
        bridged = bridge(self.inputs, stray, tears, self.fill_empty_blocks)
        if bridged is not None:
            tears, note = bridged
            return self.solve(selection, tears, evidence, (*filled_blocks, note))

        # the smoothest heights of the others
        # solved: unknown and noisy nodes, less those that nothing ties
        solved = np.zeros(len(band), dtype=bool)
        solved[at] = True
        solved &= tied
        graph = without_absent(graph, np.isfinite(value) | solved)
        own = solved[at]
        targets = Targets(targets.data[own], targets.pull[own], targets.alone[own])
        nodes = band[solved]
        self.grid.mark(nodes)

        # under noise the solve with shapes of tips makes these heights anew
        if evidence.throws is None or self.noise.weight is None:
            heights[nodes] = self._smoothest(graph, value, solved, targets, nodes)
        bent, apart = self._bend_at_tips(nodes, tears, targets, evidence)
        return Heights(
            values=heights,
            tears=tears,
            used=~selection.ignored,
            ignored=selection.ignored,
            unknown=unknown,
            extrapolation=steps[is_unknown].astype(np.float64),
            beyond=selection.beyond,
            stray=stray,
            filled_blocks=filled_blocks,
            bent=bent,
            apart=apart,
        )

    def with_data(self, state: Heights) -> Heights:
        """The same heights, but at nodes with data in use these data, unless noise was given.

        Not next to faults and within overlaps: noise there would go into the throw.
        """
        if self.noise.weight is None or self.noise.is_given:
            return state
        picks, beside = self.inputs.picks, [np.empty(0, dtype=np.int64)]
        rows = zip(state.network.mesh, state.near, state.walls, strict=True)
        for (first, last), near, walls in rows:
            widest = -min(walls.left.min(initial=0.0), walls.right.min(initial=0.0))
            at = near.within(widest + BESIDE)
            place = near.place[at]
            reach = np.maximum(-walls.gap(place, near.side[at]), 0.0) + BESIDE
            at = at[(near.distance[at] < reach) & (place > first) & (place < last)]
            beside.append(near.node[at])
        nodes = distinct(picks.nodes_of(picks.missed(state.values, state.used)))
        nodes = nodes[~is_among(nodes, distinct(*beside))]
        values = state.values.copy()
        values[nodes] = picks.means_at(nodes, state.used)
        return replace(state, values=values)

    def _smoothest(
        self,
        graph: Graph,
        value: np.ndarray,
        solved: np.ndarray,
        targets: Targets,
        nodes: np.ndarray,
    ) -> np.ndarray:
        """Smoothest heights of the solved nodes of a band, bool (n,), without shapes of tips."""
        number = np.where(solved, np.cumsum(solved) - 1, -1)
        filled = np.where(np.isfinite(value), value, 0.0)
        picks = self.inputs.picks

        def loose(unknown: int) -> GeometryError:
            """The error for a block that has data, but too few."""
            at = picks.frame.node_places(nodes[unknown : unknown + 1])[0]
            return GeometryError(
                f"horizon {picks.name!r}: too few data beyond the trim hold the block at (easting "
                f"{at[0]:.3f}, northing {at[1]:.3f}). Give a smaller trim, or add data there.",
                place=(*at, float(np.median(picks.z))),
                surfaces=(picks.name,),
            )

        return smoothest(
            graph, number, filled, picks.frame.stretch, pull=targets.pull, target=targets.data,
            scale=self.noise.scale, order=self.noise.order, loose=loose,
        )  # fmt: skip

    def _unknown(self, lost: np.ndarray, tears: Tears) -> np.ndarray:
        """Nodes without a trusted value, and absent ones in gaps next to a trace."""
        fill = self.fillable
        # the nodes of gaps are looked up, not all within reach of a trace
        beside = np.zeros(len(fill), dtype=bool)
        for near in tears.near:
            row = near.look_up(fill)
            beside |= (row >= 0) & (near.distance[row] <= FILL)
        fill = fill[beside]
        return distinct(lost, fill)

    def _noisy(self, unknown: np.ndarray, tears: Tears) -> np.ndarray:
        """Nodes with a noisy datum that are solved for as well; none if data are met exactly."""
        if self.noise.weight is None:
            return np.empty(0, dtype=np.int64)
        # also where every node next to a trace has a datum of its side
        beside = [near.nodes_within(BESIDE) for near in tears.near]
        shape = self.inputs.picks.frame.shape
        collar = around(distinct(unknown, *beside), shape, COLLAR)
        return collar[np.isfinite(self.grid.values[collar]) & ~is_among(collar, unknown)]

    def _targets(
        self,
        every: np.ndarray,
        noisy: np.ndarray,
        wedge: np.ndarray,
        selection: Selection,
        evidence: Evidence,
    ) -> Targets:
        """Data that draw solved nodes: noisy ones, and in wedges ignored ones.

        Between two faults that meet at an acute angle all data are near a fault. Where the surface
        would be extrapolated far, ignored data on the right side are used, with the weight that
        their smear allows.
        """
        data, pull = np.zeros(len(every)), np.zeros(len(every))
        alone = np.zeros(len(every), dtype=bool)

        # row of each noisy node; `grid.values` has the mean of the picks of its own wall
        rows = np.searchsorted(every, noisy)
        data[rows], pull[rows] = self.grid.values[noisy], self.noise.weight or 0.0
        alone[rows] = True

        wedge = wedge[self.present[wedge]]
        if len(wedge):
            picks = self.inputs.picks

            # picks on their own side whose node has no other: means of two walls are no data
            values = picks.means_at(wedge, selection.single)
            wedge, values = wedge[np.isfinite(values)], values[np.isfinite(values)]
            far = distance_of_nodes(picks, self.inputs.nearby, wedge)

            # a datum on the fault itself lies between both walls, where a grid drapes the gap
            off = far >= SENSE
            wedge, values, far = wedge[off], values[off], far[off]
            rows = np.searchsorted(every, wedge)

            # a datum right at the fault may belong to the other wall: it cannot hold a block by
            # itself
            alone[rows] = far >= HOLDS * selection.trim
            data[rows] = values
            pull[rows] = (
                np.where(alone[rows], UNSEEN_PULL, 0.0)
                if evidence.smear is None
                else evidence.smear.weight(far, self.noise)
            )

        # fault polygons, where no datum is trusted
        if evidence.drawn is not None:
            given = is_among(evidence.drawn.node, every)
            rows = np.searchsorted(every, evidence.drawn.node[given])
            data[rows], pull[rows], alone[rows] = evidence.drawn.height[given], DRAWN, True
        return Targets(data, pull, alone & (pull > 0))

    def _bend_at_tips(
        self, nodes: np.ndarray, tears: Tears, targets: Targets, evidence: Evidence
    ) -> tuple[Bent | None, frozenset[int]]:
        """Solve again with the shapes of a throw that dies at tips: see `tip_solve`."""
        if evidence.throws is None:
            return None, evidence.apart
        frame, network, cuts = self.inputs.picks.frame, tears.network, tears.cuts
        task = Task(
            frame=frame,
            heights=self.grid.values,
            nodes=nodes,
            data=targets.data,
            pull=targets.pull,
            bits=cuts.bits(self.inputs.picks.n_node),
            tips=tips_of(network.traces, tears.near, cuts),
            throws=evidence.throws,
            noise=self.noise,
        )
        if self.noise.weight is None:
            return task.near_tips(), evidence.apart
        weights = weights_of(frame.stretch, BEND, scale=self.noise.scale)

        def common_of(apart: frozenset[int]) -> Common | None:
            """What the walls have in common that are not apart."""
            return common_relief(nodes, cuts, network, tears.near, frame.shape, weights, apart)

        (self.grid.values[nodes], bent), apart = task.shared(
            tears.near, evidence.apart, common_of, evidence.apart_is_final
        )
        return bent, apart


def _is_between_faults(nodes: np.ndarray, tears: Tears, trim: float) -> np.ndarray:
    """Nodes (n,), bool, that are near two faults: what both ignore leaves wedges without data."""
    # faults, not traces: a fault with two traces next to each other leaves no wedge
    count = np.zeros(len(nodes), dtype=np.int64)
    nodes_by_fault: dict[int, list[np.ndarray]] = {}
    for trace, near in zip(tears.network.traces, tears.near, strict=True):
        nodes_by_fault.setdefault(trace.fault, []).append(near.nodes_within(BETWEEN * trim))
    for found in nodes_by_fault.values():
        count += is_among(nodes, distinct(*found))
    return count >= 2


class WorkingGrid:
    """The means of all picks, changed in a band: each change costs as much as its band has nodes.

    It is the one thing that passes over a grid share and write to: a copy of all nodes for each
    pass would cost more than the pass.

    Attributes
    ----------
    values : ndarray (n_node,)
        NaN where there is no value. One array throughout: its holders see the next change.
    """

    def __init__(self, picks: Picks) -> None:
        self.picks = picks
        self.values = picks.means.copy()
        self._changed = [np.empty(0, dtype=np.int64)]

    def without(self, left_out: np.ndarray) -> np.ndarray:
        """Undo all changes and leave out some picks, bool (n_pick,).

        Returns the nodes that lose all their picks, increasing; their values are NaN.
        """
        # only what changed since the last call is written again: a pass costs its band, not the
        # grid
        for nodes in self._changed:
            self.values[nodes] = self.picks.means[nodes]
        nodes = distinct(self.picks.nodes_of(np.flatnonzero(left_out)))

        # a node with other picks keeps their mean; one without is lost
        several = self.picks.several is not None
        self.values[nodes] = self.picks.means_at(nodes, ~left_out) if several else np.nan
        self._changed = [nodes]
        return nodes[np.isnan(self.values[nodes])]

    def mark(self, nodes: np.ndarray) -> None:
        """Note nodes whose values the caller is about to change."""
        self._changed.append(nodes)
