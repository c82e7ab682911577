"""What passes over a horizon exchange: picks in use, tears, evidence, and heights.

All of them are frozen: a pass takes some and returns new ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from geosurf.sheets.faults.cut_edges import Cuts, Part, Walls, is_torn, walls_of, within
from geosurf.sheets.faults.fault_distance import NearTrace
from geosurf.sheets.faults.network import Network
from geosurf.sheets.heights.inputs import NearPicks
from geosurf.sheets.heights.tip_solve import Bent
from geosurf.sheets.lattice.frame import Frame
from geosurf.sheets.lattice.picks import GAIN, Noise, Picks
from geosurf.sheets.lattice.solve import Graph, on_the_way

# ---- smear ----------------------------------------
# How far off ignored data are, by distance from a fault, and how much weight that leaves them.
#
# Gridding smears a horizon over its faults: a datum is off by a share of the throw, the less the
# farther it is from the fault. A sheet that was rebuilt without such data shows how much, near all
# faults alike. Where two faults leave a wedge without trusted data, the ignored data there are used
# with the weight that data at their distance from a fault deserve elsewhere.


BIN = 0.25  # cells of distance from a fault over which data are taken together
FEWEST = 8  # data that a bin has to have
TENTH = 1.645  # a tenth of normal errors is larger than this many standard deviations


@dataclass(frozen=True, eq=False)
class Smear:
    """Spread of the errors of ignored data [m], by distance from the nearest fault.

    Attributes
    ----------
    spread : ndarray (n,)
        Of data from k to k + 1 bins away; never smaller nearer to the fault.
    """

    spread: np.ndarray

    def weight(self, far: np.ndarray, noise: Noise) -> np.ndarray:
        """Weight (n,) of data at some distances from a fault [cells].

        An average over h cells errs by about signal h^3. Errors that neighbours share, unlike
        noise (`geosurf.sheets.lattice.picks.weight_of`), do not average out: both are equal at
        h^-6 = (signal / spread)^2.
        """
        # the square of what neighbours share: noise averages out and is taken off
        # bin of each datum; beyond the last bin its spread goes on
        at = np.minimum(far / BIN, len(self.spread) - 1).astype(np.int64)
        shared = np.maximum(self.spread[at] ** 2 - noise.deviation**2, 0.0)
        most = 1.0 if noise.weight is None else noise.weight

        # where the spread is less than noise allows for, the usual weight holds; 1 avoids 0 / 0
        hard = most * shared <= GAIN * noise.signal**2
        shared = np.where(hard, 1.0, shared)
        return np.where(hard, most, GAIN * noise.signal**2 / shared)


def smear_of(far: np.ndarray, misfit: np.ndarray) -> Smear | None:
    """Spread of misfits (n,) at some distances from a fault [cells]; None if they are too few."""
    # 90th percentile of the misfit in each bin, as a standard deviation
    number = (far / BIN).astype(np.int64)
    spread = np.full(int(number.max(initial=-1)) + 1, np.nan)
    for k in range(len(spread)):
        mine = misfit[number == k]
        if len(mine) >= FEWEST:
            spread[k] = float(np.percentile(mine, 90)) / TENTH
    known = np.flatnonzero(np.isfinite(spread))
    if not len(known):
        return None

    # bins with too few data lie between their neighbours; nearer to the fault is never better
    spread = np.interp(np.arange(len(spread)), known, spread[known])
    return Smear(np.maximum.accumulate(spread[::-1])[::-1])


def distances(near: Sequence[NearPicks]) -> tuple[np.ndarray, np.ndarray]:
    """Picks near any fault, increasing, and how far each is from the nearest one [cells]."""
    rows = np.concatenate([np.empty(0, np.int64), *(fault.rows for fault in near)])
    far = np.concatenate([np.empty(0), *(fault.far for fault in near)])

    # a pick near several faults counts with the nearest one
    order = np.lexsort((far, rows))
    rows, far = rows[order], far[order]
    first = np.append(True, rows[1:] != rows[:-1])[: len(rows)]
    return rows[first], far[first]


def distance_of_nodes(picks: Picks, near: Sequence[NearPicks], nodes: np.ndarray) -> np.ndarray:
    """Distance (n,) of the nearest pick of some nodes from any fault, at its own height."""
    rows, far = distances(near)

    # the nearest pick of each node counts; infinite for nodes without picks near a fault
    found = np.full(picks.n_node, np.inf)
    np.minimum.at(found, picks.nodes_of(rows), far)
    return found[nodes]


def wedge_nodes(graph: Graph, steps: np.ndarray, reach: int, smear: Smear | None) -> np.ndarray:
    """Nodes of a graph, so many steps (n,) from trusted data, at which ignored data are used.

    Those farther than `reach`. Once the smear is known also those on shortest ways there: good data
    near trusted ones keep a wedge from turning about those. The worst place of 72 acute faults
    (docs/validation/torn_sheets.md) misses 1.2 % instead of 1.7, with a trim of two cells.
    """
    if smear is None or not (steps > reach).any():
        return np.flatnonzero(steps > reach)
    return on_the_way(graph, steps, reach)


SENSE = 0.25  # cells of heave below which gap and overlap are not distinguished


@dataclass(frozen=True, eq=False)
class Tears:
    """Traces of the faults, the nodes near them, and the lattice links that they cut."""

    network: Network
    near: list[NearTrace]
    cuts: Cuts

    def between(self, limits: np.ndarray) -> Tears:
        """The same traces, torn between two places (n_trace, 2) of each."""
        # from all links of the traces, not from those cut now: a tear may become longer again
        every = self.network.cuts
        return replace(self, cuts=every.take(np.flatnonzero(within(every, *limits.T))))

    def without(self, untorn: Sequence[Part]) -> Tears:
        """The same except some parts of traces, between two places along them [cells]."""
        torn = is_torn(self.cuts, untorn, self.network.traces)
        return replace(self, cuts=self.cuts.take(np.flatnonzero(torn)))


@dataclass(frozen=True, eq=False)
class Selection:
    """Which picks one pass uses.

    Attributes
    ----------
    trim : float
        Picks closer to a fault than this are ignored [cells].
    ignored : ndarray of bool (n_pick,)
        Those, and picks on the wrong side of a trace.
    single : ndarray of bool (n_pick,)
        Picks on their own side, whose nodes have no other pick.
    beyond : ndarray of int64 (n, 3)
        Picks that belong to the overlapping sheet of the other side: pick, trace, their side.
    """

    trim: float
    ignored: np.ndarray
    single: np.ndarray
    beyond: np.ndarray


@dataclass(frozen=True)
class Evidence:
    """What earlier passes showed; the default is what is known before the first.

    Attributes
    ----------
    throws : list of float or None
        The largest throw of each trace [m].
    smear : Smear or None
        How far off ignored data are; None before it is seen, or if too few data show it.
    apart : frozenset of int
        Traces whose walls are rebuilt without each other.
    apart_is_final : bool
        Whether data have been compared with that already.
    """

    throws: list[float] | None = None
    smear: Smear | None = None
    apart: frozenset[int] = frozenset()
    apart_is_final: bool = False


@dataclass(frozen=True, eq=False, kw_only=True)
class Heights:
    """Heights of the nodes of a torn horizon, and how they came about.

    Attributes
    ----------
    values : ndarray (n_node,)
        NaN where there is no node. On grids the next solve writes to it: see `WorkingGrid`.
    tears : Tears
        Traces, and the links that were cut in the solve.
    walls : list of Walls
        For each trace; empty until `with_walls`.
    unknown : ndarray of int64
        Nodes that were solved for, increasing.
    used, ignored : ndarray of bool (n_pick,)
        Picks that hold a node; picks near a fault that hold none.
    beyond : ndarray of int64 (n, 3)
        As in `Selection`.
    stray : ndarray of int64
        Nodes that no datum of their own side reaches: blocks without data.
    extrapolation : ndarray (len(unknown),)
        Steps from each unknown node to the nearest datum of its side.
    filled_blocks : tuple of dict
        Blocks without data that were joined to a neighbour, and across which fault.
    in_gap : ndarray of int64
        Picks between the cut-offs of a fault that leaves a gap: they belong to neither wall.
    bent : Bent or None
        How much of it bends around tips.
    apart : frozenset of int
        Traces whose walls were rebuilt without each other.
    """

    values: np.ndarray
    tears: Tears
    used: np.ndarray
    ignored: np.ndarray
    unknown: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    extrapolation: np.ndarray = field(default_factory=lambda: np.empty(0))
    beyond: np.ndarray = field(default_factory=lambda: np.empty((0, 3), dtype=np.int64))
    stray: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    walls: list[Walls] = field(default_factory=list)
    in_gap: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    filled_blocks: tuple[dict, ...] = ()
    bent: Bent | None = None
    apart: frozenset[int] = frozenset()

    @property
    def network(self) -> Network:
        """Traces of the faults and how they end."""
        return self.tears.network

    @property
    def near(self) -> list[NearTrace]:
        """Nodes near each trace."""
        return self.tears.near

    @property
    def cuts(self) -> Cuts:
        """Links that were cut in the solve."""
        return self.tears.cuts

    def sides_of(self, fault: int, nodes: np.ndarray) -> np.ndarray:
        """Sides of nodes (n, k) at the nearest trace of a fault: 1 hanging wall, 0 far away."""
        side = np.zeros(nodes.shape)
        nearest = np.full(nodes.shape, np.inf)
        for trace, near in zip(self.network.traces, self.near, strict=True):
            if trace.fault != fault:
                continue
            at = near.look_up(nodes.ravel()).reshape(nodes.shape)
            close = (at >= 0) & (near.distance[at] < nearest)
            side = np.where(close, near.side[at], side)
            nearest = np.where(close, near.distance[at], nearest)
        return side

    def with_walls(self, frame: Frame) -> Heights:
        """The same with `walls`, read from the heights next to the traces."""
        return replace(self, walls=walls_of(self.values, self.cuts, self.network.traces, frame))
