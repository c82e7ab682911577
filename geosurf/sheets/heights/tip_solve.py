"""Heights of solved nodes again, with the shapes of a throw that dies at tips.

Without noise around the tips alone. Under noise everywhere, first each wall from its own data, then
with what walls have in common (`geosurf.sheets.heights.relief`), unless data speak against that.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.sheets.faults.fault_distance import NearTrace
from geosurf.sheets.faults.tips import Tips
from geosurf.sheets.heights.relief import FREE, SEEN
from geosurf.sheets.heights.tip_residual import (
    Bent,
    close_to,
    groups_of,
    likely_shares,
    shapes_of,
    smoothest_residual,
)
from geosurf.sheets.lattice.drape import around, without_absent
from geosurf.sheets.lattice.frame import Frame
from geosurf.sheets.lattice.noise import Noise
from geosurf.sheets.lattice.solve import Common, lattice_graph, with_more

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
        some = np.any(close, axis=0) if close else np.zeros(len(self.nodes), dtype=bool)
        nodes = self.nodes[some]
        if not len(nodes):
            return None
        band = around(nodes, self.frame.shape, self.noise.order)
        found, bent = self._solved(band, np.searchsorted(band, nodes), np.flatnonzero(some))
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
        found, share = smoothest_residual(
            graph, number, value, self.frame.stretch, shapes, groups,
            likely_shares(self.tips, self.throws), self.noise.energy, pull, data, self.noise.scale,
            [tip.throw_towards() for tip in self.tips], common, self.noise.order,
        )  # fmt: skip
        return found[: len(free)], Bent(self.tips, share) if share.any() else None

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
        found = solve(common)
        missed = against(found[0], alone[0])
        if missed <= apart:
            return found, apart
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
    lost = np.sum([is_among(every, some) for some in beside], axis=0) * FREE / scale**2
    found = set()
    for k, some in enumerate(beside):
        most = 2.0 * lost[is_among(every, some)].sum()
        if worse[is_among(nodes, some)].sum() > most:
            found.add(k)
    return found
