"""The picks and faults of one horizon, with what every pass over them needs."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass, field

import numpy as np

from geosurf.arrangement.threads import map_threads
from geosurf.model.tear_plan import DataUse
from geosurf.sheets.faults.fault_distance import blocks_between, side_at_own_height, window
from geosurf.sheets.faults.network import Network
from geosurf.sheets.faults.traces import FaultMesh
from geosurf.sheets.heights.overlap import widest_overlap
from geosurf.sheets.lattice.drape import draped
from geosurf.sheets.lattice.picks import Picks

FIRST_TRIM = 3.0  # cells
NEARER = 0.5  # of a trim within which data are ignored that the base case of an ensemble used


@dataclass(frozen=True)
class Trims:
    """Distance from each fault within which data are ignored [cells].

    Attributes
    ----------
    of_fault : tuple of float
    use : DataUse, optional
        Of the base case of an ensemble. What it ignored is ignored, and of the other picks those
        nearer than half a trim: smear belongs to data, wherever a realisation has the fault. Picks
        on another side than there are wrong.
    """

    of_fault: tuple[float, ...]
    use: DataUse | None = field(default=None, compare=False)

    @property
    def widest(self) -> float:
        """The largest of them."""
        return max(self.of_fault, default=1.0)

    @property
    def shares(self) -> list[float]:
        """Each as a share of the widest."""
        return [trim / self.widest for trim in self.of_fault]

    def changed(self, faults: Collection[int], by: float) -> Trims:
        """The same with those of some faults, by number, wider or narrower; none below a cell."""
        # not below a cell; a trim that is smaller than that already becomes no smaller
        return self.with_trims(
            max(trim + by, min(trim, 1.0)) if k in faults else trim
            for k, trim in enumerate(self.of_fault)
        )

    def with_trims(self, of_fault: Iterable[float]) -> Trims:
        """The same with other trims."""
        return Trims(tuple(of_fault), self.use)


@dataclass(frozen=True, eq=False)
class NearPicks:
    """Picks near one fault.

    Attributes
    ----------
    rows : ndarray of int64 (n,)
        Picks, increasing.
    far : ndarray (n,)
        Distance from the fault, at their own height [cells].
    side : ndarray (n,)
        1 in the hanging wall, -1 in the footwall.
    """

    rows: np.ndarray
    far: np.ndarray
    side: np.ndarray


@dataclass(frozen=True, eq=False)
class Inputs:
    """One horizon before any pass.

    Attributes
    ----------
    picks : Picks
    meshes : list of FaultMesh
    nearby : list of NearPicks
        For each fault.
    trim, first_trim : float
        Picks closer to a fault than this are ignored, in the last pass and in the first [cells].
        For the fault with the widest trim.
    shares : list of float
        Trim of each fault as a share of the widest.
    use : DataUse or None
        See `Trims`.
    """

    picks: Picks
    meshes: list[FaultMesh]
    nearby: list[NearPicks]
    trim: float
    first_trim: float
    shares: list[float]
    use: DataUse | None = None

    def within(self, trim: float) -> np.ndarray:
        """Picks closer to any fault than its share of some cells, bool (n_pick,)."""
        found = np.zeros(len(self.picks.z), dtype=bool)
        if self.use is not None:
            found |= self.use.ignored
            trim *= NEARER
        for near, share in zip(self.nearby, self.shares, strict=True):
            found[near.rows[near.far < trim * share]] = True
        return found

    def misplaced(self) -> np.ndarray:
        """Picks that are wrong in the base case, or on another side than there, bool (n_pick,)."""
        found = np.zeros(len(self.picks.z), dtype=bool)
        if self.use is not None:
            found |= self.use.wrong
            for number, near in enumerate(self.nearby):
                found[self.use.flipped(number, near.rows, near.side)] = True
        return found

    def network(self, heights: np.ndarray, filled: np.ndarray) -> Network:
        """Traces of the faults on heights (n_node,), where those of `filled` are not data."""
        frame = self.picks.frame
        return Network(self.meshes, heights.reshape(frame.shape), frame, filled)

    def network_across(self, heights: np.ndarray, fill: np.ndarray) -> Network:
        """Traces on heights (n_node,) that are drawn across the nodes of `fill`: writes there."""
        frame = self.picks.frame
        filled = fill[np.isnan(heights[fill])]
        heights[fill] = draped(heights, fill, frame.shape, frame.stretch)
        return self.network(heights, filled)


def inputs_of(picks: Picks, meshes: list[FaultMesh], trims: Trims) -> Inputs:
    """Find the picks near each fault, and how many of them the first pass ignores."""
    # the first pass only has to find gaps and overlaps: its trim is generous, and at least as wide
    # as smear and half an overlap
    trim = trims.widest
    first_trim = max(FIRST_TRIM, trim)
    half = 0.5 * widest_overlap(picks, meshes)
    if half > first_trim + 1.0:
        first_trim = half + 1.0  # an average of both walls is not a datum of either

    # a cell beyond the trim: picks across the trace are looked for there as well
    reach = first_trim + 1.0
    if not picks.on_nodes and first_trim <= FIRST_TRIM:
        first_trim = trim  # scattered points are not smeared
    levels = float(picks.z.min()), float(picks.z.max())

    def near(mesh: FaultMesh) -> NearPicks:
        """Picks near one fault."""
        return _near_picks(picks, mesh, reach, levels)

    nearby = map_threads(near, [(mesh,) for mesh in meshes])
    return Inputs(picks, meshes, nearby, trim, first_trim, trims.shares, trims.use)


def _near_picks(
    picks: Picks, mesh: FaultMesh, reach: float, levels: tuple[float, float]
) -> NearPicks:
    """Picks within reach of a fault [cells]; `levels`: lowest and highest elevation of all [m]."""
    # only the part of the fault at levels of the horizon can be near a datum at its own height
    mesh, blocks = blocks_between(mesh, reach, *levels)
    if blocks is None:
        return NearPicks(np.empty(0, dtype=np.int64), np.empty(0), np.empty(0))
    near = picks.of_nodes(window(picks.frame, blocks))
    uv = picks.columns(near) * picks.frame.stretch
    rows, _ = blocks.of(uv)
    points = np.column_stack([uv[rows], picks.z[near[rows]]])
    far, side = side_at_own_height(mesh, blocks, points, reach)
    close = side != 0
    return NearPicks(near[rows[close]], far[close], side[close])
