"""What passes over a horizon exchange: picks in use, tears, evidence, and heights.

All of them are frozen: a pass takes some and returns new ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from geosurf.sheets.faults.cut_edges import Cuts, Part, is_torn, within
from geosurf.sheets.faults.fault_distance import NearTrace
from geosurf.sheets.faults.heave import Walls, walls_of
from geosurf.sheets.faults.network import Network
from geosurf.sheets.heights.smear import Smear
from geosurf.sheets.heights.tip_residual import Bent
from geosurf.sheets.lattice.frame import Frame

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
