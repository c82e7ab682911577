"""Heights of solved nodes again, with the shapes of a throw that dies at tips.

Without noise around the tips alone. Under noise everywhere, first each wall from its own data, then
with what walls have in common (`geosurf.sheets.heights.relief`), unless data speak against that.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.kernels.sheets.node_bands import products_of_columns, sums_of_columns
from geosurf.kernels.sheets.smooth_surface import energy_gradient
from geosurf.sheets.faults.fault_distance import NearTrace
from geosurf.sheets.faults.tips import Tips
from geosurf.sheets.heights.relief import FREE, SEEN
from geosurf.sheets.lattice.picks import Frame, Noise
from geosurf.sheets.lattice.solve import (
    BEND,
    Common,
    Graph,
    around,
    equations,
    fourth_order,
    lattice_graph,
    weights_of,
    with_more,
    without_absent,
)

# ---- tip residual ----------------------------------------
# The smoothest residual: a sheet around the tips of its faults, less the shapes that bend it.
#
# With heights u = v + B a, v what is smooth, B the shapes of `geosurf.sheets.faults.tips` and a
# their shares, the energy is v' K v, and data draw u. So unknown heights obey K u - K B a = data,
# and shares B' K (B a - u) + hold a = 0; both come from one factor of K. Shares are thought to be
# about as large as half the throw (`likely`); a fault has its shapes only if the sheet is
# likelier with them than without, in the sense of Bayes (MacKay 1992, Neural Comput. 4, 415-447):
# gain > log det(1 + S likely^2), both in units of noise, or, without noise, of the energy that a
# node has without them.


AT_MOST = 10.0  # times the likely size: what shares are held by where data have no noise
AROUND = 16.0  # cells from a tip within which the sheet is solved with its shapes


@dataclass(frozen=True, eq=False)
class Bent:
    """How much of each shape a sheet has.

    Attributes
    ----------
    tips : list of Tips
    share : ndarray (k,)
        Of the shapes of all tips, one after another [m].
    """

    tips: list[Tips]
    share: np.ndarray

    def of(self, frame: Frame, nodes: np.ndarray, anchors: np.ndarray | None = None) -> np.ndarray:
        """By how much nodes (n,) are bent [m], on the wall of each or on that of its anchor."""
        # shapes with a share of 0 are left out: most faults have no tip that pays
        parts = np.split(self.share, np.cumsum([tip.n_shape for tip in self.tips])[:-1])
        bent = [(tip, part) for tip, part in zip(self.tips, parts, strict=True) if part.any()]
        shapes = shapes_of([tip for tip, _ in bent], frame, nodes, anchors)
        share = np.concatenate([np.empty(0), *(part for _, part in bent)])
        return sums_of_columns(shapes, share)

    def only(self, traces: Sequence[int]) -> Bent:
        """Of some traces only."""
        mine = [np.full(tip.n_shape, tip.trace in traces) for tip in self.tips]
        return Bent(self.tips, np.where(np.concatenate(mine), self.share, 0.0))


def shapes_of(
    tips: Sequence[Tips], frame: Frame, nodes: np.ndarray, anchors: np.ndarray | None = None
) -> np.ndarray:
    """Shapes (n, k) of all tips at nodes, on the wall of each or on that of its anchor."""
    places = frame.cells_of_node(nodes)
    columns = [np.empty((len(nodes), 0))]
    for tip in tips:
        # ghosts bend with the wall of their anchor, on past the fault; wall is 0 ahead of the tip
        wall = None
        if anchors is not None:
            side, beside = tip.side(anchors, frame.cells_of_node(anchors))
            wall = np.where(beside, side, 0.0)
        columns.append(tip.shapes(nodes, places, wall))
    return np.concatenate(columns, axis=1)


def close_to(tip: Tips, frame: Frame, nodes: np.ndarray) -> np.ndarray:
    """Which nodes are within reach of a tip, bool (n,)."""
    places = frame.cells_of_node(nodes)
    far = [np.hypot(*(places - at).T) for at in tip.tips]
    return np.min(far, axis=0) < AROUND


def groups_of(
    tips: Sequence[Tips], frame: Frame, nodes: np.ndarray
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Columns of the shapes of each fault, and which of some nodes are around its tips."""
    last = np.cumsum([tip.n_shape for tip in tips])
    return [
        (np.arange(end - tip.n_shape, end), close_to(tip, frame, nodes))
        for tip, end in zip(tips, last, strict=True)
    ]


def likely_shares(tips: Sequence[Tips], throw: Sequence[float]) -> np.ndarray:
    """How large the shares of all shapes may well be (k,) [m]; `throw`: the largest of each trace.

    Half the throw is one wall's; later terms of a smooth profile are smaller.
    """
    # half the throw on each wall; the k-th term of a series is about k times smaller
    found = [0.5 * throw[tip.trace] / np.arange(1, tip.n_shape + 1) for tip in tips]
    return np.concatenate([np.empty(0), *found])


class Shapes(NamedTuple):
    """Shapes of throw at tips, and what decides whether they pay.

    Attributes
    ----------
    drawn : ndarray (n, k)
        Of all nodes.
    groups : sequence of (ndarray of int64, ndarray of bool (n,))
        Columns of the shapes of each fault, and the nodes around its tips.
    likely : ndarray (k,)
        How large shares may well be [m].
    towards : sequence of ndarray (n_tip, 2, k)
        Of each group: see `Tips.throw_towards`.
    """

    drawn: np.ndarray
    groups: Sequence[tuple[np.ndarray, np.ndarray]]
    likely: np.ndarray
    towards: Sequence[np.ndarray] = ()


def smoothest_residual(
    graph: Graph,
    unknown: np.ndarray,
    value: np.ndarray,
    stretch: np.ndarray,
    shapes: Shapes,
    doubt: float,
    pull: np.ndarray,
    target: np.ndarray,
    scale: float = 1.0,
    common: Common | None = None,
    order: int = 3,
) -> tuple[np.ndarray, np.ndarray]:
    """Solve for unknown nodes, and for the shapes that leave the smoothest residual.

    Parameters
    ----------
    graph, unknown, value, stretch, pull, target, scale
        As for `smoothest`.
    shapes : Shapes
    doubt : float
        Energy of one deviation of noise; 0 for data without.
    common : Common, optional
        What walls have in common. Every node is unknown then, node k number k, and coefficients
        follow as nodes that no link joins to any.
    order : int
        Of the highest differences, as for `smoothest`; 3 with what walls have in common.

    Returns
    -------
    ndarray (n_unknown,), ndarray (k,)
        Heights, and the share of each shape in them: 0 where it does not pay.
    """
    weights, fourth = weights_of(stretch, BEND, scale=scale), None
    if order == 4:
        weights, fourth = fourth_order(graph, stretch)
    system, right, level = equations(graph, unknown, value, weights, pull, target, common, fourth)

    def bent(heights: np.ndarray) -> np.ndarray:
        """Derivatives (n, k) of half the energy by heights (n, k)."""
        slopes = energy_gradient(graph.east, graph.north, graph.square, heights, weights)
        if fourth is not None:
            slopes += fourth.gradient(heights)
        if common is not None:
            slopes += common.matrix.T @ (common.matrix @ heights)
        return slopes

    # at (n_unknown,): node of each unknown; moves: how heights answer to each shape
    drawn = bent(shapes.drawn)
    free = unknown >= 0
    at = np.empty(len(right), dtype=np.int64)
    at[unknown[free]] = np.flatnonzero(free)
    plain, *moves = system.solved([right, *drawn[at].T])
    moved = np.stack(moves, axis=1) if moves else np.empty((len(plain), 0))
    heights = np.where(free, 0.0, value - level)
    heights[at] = plain

    # normal equations of the shares once heights are eliminated (Schur complement)
    shape_energy = products_of_columns(shapes.drawn, drawn) - products_of_columns(drawn[at], moved)
    wanted = products_of_columns(drawn, heights[:, None])[:, 0]
    units = [doubt] * len(shapes.groups)

    # without noise the unit is what the energy of a free node is without shapes, near the tips
    if not doubt:
        missed = pull * np.where(pull > 0, target - level - plain, 0.0) ** 2
        for k, (_, near) in enumerate(shapes.groups):
            part = without_absent(graph, near)  # its differences lie among these nodes
            slopes = energy_gradient(part.east, part.north, part.square, heights[:, None], weights)
            if order == 4:
                slopes += fourth_order(part, stretch)[1].gradient(heights[:, None])
            energy = heights @ slopes[:, 0] + missed[near[at]].sum()
            units[k] = energy / max((near & free).sum(), 1)
    columns = [columns for columns, _ in shapes.groups]
    share = paying_shares(
        shape_energy, wanted, columns, shapes.likely, doubt, units, shapes.towards
    )
    if order == 4 and share.any():
        # fourth differences know best whether throw dies like that, but weigh most what is next to
        # the tip, where shapes are least exact: third ones measure by how much
        _, measured = smoothest_residual(
            graph, unknown, value, stretch, shapes, doubt, pull, target, scale
        )
        for group in columns:
            if len(group) > 2 and share[group].any():
                share[group] = measured[group]
    return plain + sums_of_columns(moved, share) + level, share


def paying_shares(
    shape_energy: np.ndarray,
    wanted: np.ndarray,
    groups: Sequence[np.ndarray],
    likely: np.ndarray,
    doubt: float,
    units: Sequence[float],
    towards: Sequence[np.ndarray] = (),
) -> np.ndarray:
    """Shares (k,) of shapes that leave the smoothest residual, 0 of those that do not pay.

    Parameters
    ----------
    shape_energy, wanted : ndarray (k, k), ndarray (k,)
        Energy of the shapes and how much the sheet has of it, both less what it could take itself.
    groups : sequence of ndarray of int64
        Columns of the shapes of each fault.
    likely, doubt, towards
        As for `smoothest_residual` and its `Shapes`.
    units : sequence of float
        Energy in which what each group gains is counted: that of one deviation of noise, or, where
        data are exact, of a node.
    """
    paying, unit_of = np.zeros(len(likely), dtype=bool), np.zeros(len(likely))

    # each fault by itself: whether all its shapes together pay for their freedom
    for columns, unit in zip(groups, units, strict=True):
        some = np.ix_(columns, columns)
        paying[columns] = _pays(shape_energy[some], wanted[columns], likely[columns], unit)
        unit_of[columns] = doubt or unit / AT_MOST**2
    share = np.zeros(len(likely))
    used = np.flatnonzero(paying)
    # data decide, except for shares that the nodes could take as well: free, those run away
    held = shape_energy[np.ix_(used, used)] + np.diag(unit_of[used] / likely[used] ** 2)
    share[used] = np.linalg.lstsq(held, wanted[used], rcond=None)[0]

    # throw must not change its sign between a tip and farther in: where it would, a constraint
    # makes it 0 close to the tip, by Lagrange multipliers; each round adds rows, so that it ends
    rows: list[np.ndarray] = []
    while len(new := _turning_over(share, groups, towards, rows)):
        rows += new
        none = np.stack(rows)[:, used]
        inverse = np.linalg.pinv(held)
        much = np.linalg.lstsq(none @ inverse @ none.T, none @ share[used], rcond=None)[0]
        share[used] -= inverse @ none.T @ much
    return share


def _turning_over(
    share: np.ndarray,
    groups: Sequence[np.ndarray],
    towards: Sequence[np.ndarray],
    known: Sequence[np.ndarray],
) -> list[np.ndarray]:
    """Throw (k,) of all shapes close to each tip at which it would turn over before it dies.

    Without those of the tips that are `known` already.
    """
    rows = []
    for columns, ends in zip(groups, towards, strict=len(towards) > 0):
        for close, further in ends:
            row = np.zeros(len(share))
            row[columns] = close

            # a row that is known already holds to rounding: it is not added again
            turns = (close @ share[columns]) * (further @ share[columns]) < 0.0
            if turns and not any((row == one).all() for one in known):
                rows.append(row)
    return rows


def _pays(shape_energy: np.ndarray, wanted: np.ndarray, likely: np.ndarray, unit: float) -> bool:
    """Whether shares that are likely up to some size make the sheet likelier; energies in units."""
    if not (unit > 0.0 and (likely > 0.0).all()):
        return False

    # in units of likely sizes and energy: gain of the best shares against the log of the volume
    # that they may have had (the Occam factor)
    scaled = shape_energy * np.outer(likely, likely) / unit
    side = wanted * likely / unit
    whole = np.eye(len(likely)) + scaled
    return bool(side @ np.linalg.solve(whole, side) > np.linalg.slogdet(whole)[1])


Solved = tuple[np.ndarray, Bent | None]


@dataclass(frozen=True, eq=False)
class Task:
    """What is to be solved for.

    Attributes
    ----------
    frame : Frame
    heights : ndarray (n_node,)
        Of all nodes; NaN where there is none.
    nodes : ndarray of int64 (n,)
        To be solved for, increasing.
    data, pull : ndarray (n,)
        What draws each node, and with what weight; 0: nothing.
    bits : ndarray of uint8 (n_node,)
        Cut links.
    tips : list of Tips
    throws : list of float
        The largest of each trace [m].
    noise : Noise
    """

    frame: Frame
    heights: np.ndarray
    nodes: np.ndarray
    data: np.ndarray
    pull: np.ndarray
    bits: np.ndarray
    tips: list[Tips]
    throws: list[float]
    noise: Noise

    def near_tips(self) -> Bent | None:
        """Write heights of the nodes around the tips, all others held; what bends them."""
        # exact data: what is farther from tips is right already, and holds the rest of the solve
        close = [close_to(tip, self.frame, self.nodes) for tip in self.tips]
        near = np.any(close, axis=0) if close else np.zeros(len(self.nodes), dtype=bool)
        nodes = self.nodes[near]
        if not len(nodes):
            return None
        band = around(nodes, self.frame.shape, self.noise.order)
        found, bent = self._solved(band, np.searchsorted(band, nodes), np.flatnonzero(near))
        self.heights[nodes] = found
        return bent

    def everywhere(self, common: Common | None = None) -> Solved:
        """Heights (n,) of all nodes, none held, and what bends them."""
        every = np.arange(len(self.nodes))
        return self._solved(self.nodes, every, every, common)

    @cached_property
    def _shapes(self) -> np.ndarray:
        """Shapes (n, k) of all tips at the nodes."""
        return shapes_of(self.tips, self.frame, self.nodes)

    def _solved(
        self, band: np.ndarray, free: np.ndarray, rows: np.ndarray, common: Common | None = None
    ) -> Solved:
        """Heights of some rows of a band of nodes, which are `rows` of the task's."""
        # nodes without a height that are not solved for do not exist
        graph = lattice_graph(band, self.frame.shape, self.bits)
        value = self.heights[band]
        held = np.isfinite(value)
        held[free] = True
        graph = without_absent(graph, held)
        value = np.where(np.isfinite(value), value, 0.0)
        number = np.full(len(band), -1)
        number[free] = np.arange(len(free))

        # shapes (n, k) of a throw that dies at tips: only what they leave over is smooth
        pull, data = self.pull[rows], self.data[rows]
        every = band is self.nodes
        shapes = self._shapes if every else shapes_of(self.tips, self.frame, band)
        groups = groups_of(self.tips, self.frame, band)

        # coefficients of the throws are more unknowns, without links, data, or shapes
        if common is not None:
            more = common.n_coefficient
            graph, number = with_more(graph, more), np.arange(len(band) + more)
            pull, data, value = (np.append(a, np.zeros(more)) for a in (pull, data, value))
            shapes = np.concatenate([shapes, np.zeros((more, shapes.shape[1]))])
        likely = likely_shares(self.tips, self.throws)
        towards = [tip.throw_towards() for tip in self.tips]
        solution, share = smoothest_residual(
            graph, number, value, self.frame.stretch, Shapes(shapes, groups, likely, towards),
            self.noise.energy, pull, data, self.noise.scale, common, self.noise.order,
        )  # fmt: skip
        return solution[: len(free)], Bent(self.tips, share) if share.any() else None

    def shared(
        self,
        near: Sequence[NearTrace],
        apart: frozenset[int],
        common_of: Callable[[frozenset[int]], Common | None],
        final: bool,
    ) -> tuple[Solved, frozenset[int]]:
        """`everywhere`, with what walls have in common unless data contradict it."""
        # only nodes with a datum can speak for or against; misfits in units of noise
        drawn = self.pull > 0
        nodes, data = self.nodes[drawn], self.data[drawn]
        weight = self.pull[drawn] / self.noise.energy

        def against(found: np.ndarray, alone: np.ndarray) -> set[int]:
            """Traces next to which data are missed by too much."""
            missed, before = ((z[drawn] - data) ** 2 for z in (found, alone))
            return losing(near, nodes, weight * (missed - before), self.noise.scale)

        return shared_unless(against, self.everywhere, common_of, apart, final)


def shared_unless(
    against: Callable[[np.ndarray, np.ndarray], set[int]],
    solve: Callable[[Common | None], Solved],
    common_of: Callable[[frozenset[int]], Common | None],
    apart: frozenset[int],
    final: bool,
) -> tuple[Solved, frozenset[int]]:
    """Heights with what walls have in common, except at traces where that misses data too much.

    Parameters
    ----------
    against : callable
        Of heights with and without what is common: the traces at which data contradict it.
    solve : callable
        Of what is common, or None: heights.
    common_of : callable
        Of traces whose walls are apart: what the others have in common; None if nothing is.
    apart : frozenset of int
        Traces whose walls are apart.
    final : bool
        Whether data have been compared already, so that `apart` stays as it is.

    Returns
    -------
    Solved, frozenset of int
        Heights, and the traces whose walls are apart in them.
    """
    # earlier passes have compared already: the same walls again, for the same sheet
    if final:
        return solve(common_of(apart)), apart

    # walls apart are the measure; traces that lose too much leave, and the others try again. Each
    # round takes traces away, so that it ends
    alone = solve(None)
    while (common := common_of(apart)) is not None:
        shared = solve(common)
        missed = against(shared[0], alone[0])
        if missed <= apart:
            return shared, apart
        apart = apart | missed
    return alone, apart


def losing(
    near: Sequence[NearTrace], nodes: np.ndarray, worse: np.ndarray, scale: float
) -> set[int]:
    """Traces next to which data are missed by more than walls have freedom to lose.

    An information criterion (Akaike 1974, IEEE Trans. Autom. Control 19, 716-723): squared misfit,
    in noise, may grow by twice the degrees of freedom that are lost. Where there are several traces
    next to a node, all their walls lose some. `worse` (n,) is by how much squares grew, in those of
    noise, `nodes` (n,) where.
    """
    # freedom that shared walls lose: FREE for each node near a trace, more where it is
    # near several, less where data are averaged; twice that is too much
    every = distinct(nodes)
    beside = [trace.nodes_within(SEEN) for trace in near]
    lost = np.sum([is_among(every, seen) for seen in beside], axis=0) * FREE / scale**2
    traces = set()
    for k, seen in enumerate(beside):
        most = 2.0 * lost[is_among(every, seen)].sum()
        if worse[is_among(nodes, seen)].sum() > most:
            traces.add(k)
    return traces
