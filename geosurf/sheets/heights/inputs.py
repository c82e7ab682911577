"""The picks and faults of one horizon, with what every pass over them needs."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from geosurf.arrangement.threads import map_threads
from geosurf.conventions import place
from geosurf.errors import GeometryError
from geosurf.model.sheets import DataUse
from geosurf.sheets.faults.fault_distance import (
    Blocks,
    blocks_between,
    mesh_blocks,
    side_at_own_height,
    window,
)
from geosurf.sheets.faults.network import Network
from geosurf.sheets.faults.traces import FaultMesh
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.lattice.solve import draped

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


WIDEST = 22.0  # cells of overlap: walls are distinguished up to 12 cells from a trace
SEEN = 64.0  # cells from a fault within which distances are asked for


def widest_overlap(picks: Picks, meshes: Sequence[FaultMesh]) -> float:
    """The widest overlap of the data at any fault [cells], 0 where no node has both walls.

    Raises
    ------
    GeometryError
        If it is wider than can be torn: names fault and place.
    """
    high, low = _highest_and_lowest(picks)
    widest = 0.0
    for mesh in meshes if len(high) else ():
        # cheap bound first: only nodes whose two picks have the fault between them
        at_dip = _overlap_at_dip(picks, mesh, high, low)
        both = at_dip > 0.0
        if not both.any():
            continue
        blocks = mesh_blocks(mesh, SEEN)

        # distances of both picks to the fault, at their own heights, add up to the overlap
        overlap = sum(
            side_at_own_height(mesh, blocks, _points(picks, rows[both]), SEEN)[0]
            for rows in (high, low)
        )
        # where the fault ends above or below a pick, its dip gives how far it would be
        overlap = np.minimum(overlap, at_dip[both])
        most = int(np.argmax(overlap))
        if overlap[most] > WIDEST:
            where = picks.places(high[both][most : most + 1])[0]
            coarser = picks.frame.cell * overlap[most] / WIDEST
            raise GeometryError(
                f"horizon {picks.name!r} overlaps itself by {overlap[most]:.0f} cells at fault "
                f"{mesh.name!r}, near {place(where)}; {WIDEST:g} cells are the most that can be "
                f"torn. Give points on a lattice of {coarser:.3g} m or more, one for each wall.",
                place=where,
                surfaces=(picks.name, mesh.name),
            )
        widest = max(widest, float(overlap[most]))
    return widest


def _highest_and_lowest(picks: Picks) -> tuple[np.ndarray, np.ndarray]:
    """Highest and lowest pick of each node that has several."""
    none = np.empty(0, dtype=np.int64)
    if picks.one_each:
        return none, none

    # picks of such nodes by node, then by height: the first is the lowest, the last the highest
    several = np.flatnonzero(np.bincount(picks.node)[picks.node] > 1)
    order = several[np.lexsort((picks.z[several], picks.node[several]))]
    node = picks.node[order]
    is_last = np.ones(len(node), dtype=bool)
    is_last[:-1] = node[1:] != node[:-1]
    return order[is_last], order[np.roll(is_last, 1)]


def _points(picks: Picks, rows: np.ndarray) -> np.ndarray:
    """Some picks (n, 3) in the frame of fault meshes."""
    return np.column_stack([picks.columns(rows) * picks.frame.stretch, picks.z[rows]])


def _overlap_at_dip(picks: Picks, mesh: FaultMesh, high: np.ndarray, low: np.ndarray) -> np.ndarray:
    """Overlap (n,) [cells] of two picks of each node at the dip of the fault between them.

    It is 0 where no fault passes between the two, straight down.
    """
    # all pairs (pick, triangle of the fault in the same block of the map)
    corners = mesh.points[mesh.triangles]
    box = corners[..., :2].min(axis=1), corners[..., :2].max(axis=1)
    blocks = Blocks(*box, 0.0)
    upper, lower = _points(picks, high), _points(picks, low)
    rows, block = blocks.of(upper)
    count = blocks.starts[block + 1] - blocks.starts[block]
    point = np.repeat(rows, count)
    k = np.arange(len(point)) - np.repeat(np.cumsum(count) - count, count)
    t = blocks.items[np.repeat(blocks.starts[block], count) + k]

    # most triangles are above both picks, or below both
    foot, top = corners[..., 2].min(axis=1), corners[..., 2].max(axis=1)
    between = np.flatnonzero((foot[t] <= upper[point, 2]) & (top[t] >= lower[point, 2]))
    point, t = point[between], t[between]
    a, b, c = corners[t, 0], corners[t, 1], corners[t, 2]

    # height z of the fault under the upper pick, by barycentric weights v and w
    one, two, to = (v[:, :2] - a[:, :2] for v in (b, c, upper[point]))
    det = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
    known = np.where(det == 0.0, 1.0, det)  # upright triangles have no point between
    v = (to[:, 0] * two[:, 1] - to[:, 1] * two[:, 0]) / known
    w = (one[:, 0] * to[:, 1] - one[:, 1] * to[:, 0]) / known
    z = a[:, 2] + v * (b[:, 2] - a[:, 2]) + w * (c[:, 2] - a[:, 2])
    met = (det != 0.0) & (v >= 0) & (w >= 0) & (v + w <= 1)
    met &= (z < upper[point, 2]) & (z > lower[point, 2])

    # run: cells across strike for each cell of height, by the dip of the triangle
    normal = mesh.normals[t[met]]
    run = np.abs(normal[:, 2]) / np.maximum(np.hypot(*normal[:, :2].T), 1e-9)
    out = np.zeros(len(high))
    apart = (upper[point[met], 2] - lower[point[met], 2]) / mesh.cell
    np.maximum.at(out, point[met], apart * run)
    return out
