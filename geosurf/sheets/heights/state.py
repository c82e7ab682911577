"""Picks and faults of one horizon, and what passes over it exchange.

All that is exchanged is frozen (picks in use, tears, evidence, heights): a pass takes some and
returns new ones.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from geosurf.arrangement.threads import map_threads
from geosurf.conventions import place
from geosurf.errors import GeometryError
from geosurf.kernels.lattices.sets import ranges
from geosurf.model.sheets import DataUse
from geosurf.sheets.faults.cut_edges import Cuts, Part, Walls, is_torn, walls_of, within
from geosurf.sheets.faults.fault_distance import (
    Blocks,
    NearTrace,
    blocks_between,
    mesh_blocks,
    side_at_own_height,
    window,
)
from geosurf.sheets.faults.network import Network
from geosurf.sheets.faults.traces import FaultMesh
from geosurf.sheets.heights.tip_solve import Bent
from geosurf.sheets.lattice.picks import GAIN, Frame, Noise, Picks
from geosurf.sheets.lattice.solve import Graph, draped, on_the_way

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


Cutoffs = Mapping[str, tuple[np.ndarray, np.ndarray]]


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
    cutoffs : mapping of str to (ndarray, ndarray)
        By fault: both lines (n, 3) of its polygon of this horizon [m].
    """

    picks: Picks
    meshes: list[FaultMesh]
    nearby: list[NearPicks]
    trim: float
    first_trim: float
    shares: list[float]
    use: DataUse | None = None
    cutoffs: Cutoffs = field(default_factory=dict)

    def within(self, trim: float) -> np.ndarray:
        """Picks closer to any fault than its share of some cells, bool (n_pick,)."""
        close_picks = np.zeros(len(self.picks.z), dtype=bool)
        if self.use is not None:
            close_picks |= self.use.ignored
            trim *= NEARER
        for near, share in zip(self.nearby, self.shares, strict=True):
            close_picks[near.rows[near.far < trim * share]] = True
        return close_picks

    def misplaced(self) -> np.ndarray:
        """Picks that are wrong in the base case, or on another side than there, bool (n_pick,)."""
        wrong_picks = np.zeros(len(self.picks.z), dtype=bool)
        if self.use is not None:
            wrong_picks |= self.use.wrong
            for number, near in enumerate(self.nearby):
                wrong_picks[self.use.flipped(number, near.rows, near.side)] = True
        return wrong_picks

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
        return near_picks(picks, mesh, reach, levels)

    nearby = map_threads(near, [(mesh,) for mesh in meshes])
    return Inputs(picks, meshes, nearby, trim, first_trim, trims.shares, trims.use)


def near_picks(
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


def data_moved(use: DataUse, picks: Picks, meshes: Sequence[FaultMesh], trim: float) -> DataUse:
    """A use, of data that have moved up or down from there: those that passed a fault are wrong.

    A fault that dips is elsewhere in the map at another level: what lay in its hanging wall may lie
    in its footwall now, and is no datum of that.
    """
    wrong = use.wrong.copy()
    shift = float(np.abs(picks.z - use.elevation).max(initial=0.0))
    before = replace(picks, z=use.elevation)
    for mesh in meshes:
        along, up = np.hypot(*mesh.across.T), np.abs(mesh.normals[:, 2])
        gentlest = float((up / np.maximum(along, 1e-9)).max(initial=0.0))
        reach = max(FIRST_TRIM, trim) + 1.0 + min(SEEN, shift / mesh.cell * gentlest)
        sides = np.zeros((2, len(picks.z)))
        for side, of in zip(sides, (before, picks), strict=True):
            near = near_picks(of, mesh, reach, (float(of.z.min()), float(of.z.max())))
            side[near.rows] = near.side
        wrong |= sides[0] * sides[1] < 0
    return replace(use, wrong=wrong)


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
    of, at = ranges(blocks.starts[block], count)
    point, t = rows[of], blocks.items[at]

    # most triangles are above both picks, or below both
    foot, top = corners[..., 2].min(axis=1), corners[..., 2].max(axis=1)
    between = np.flatnonzero((foot[t] <= upper[point, 2]) & (top[t] >= lower[point, 2]))
    point, t = point[between], t[between]
    a, b, c = corners[t, 0], corners[t, 1], corners[t, 2]

    # height z of the fault under the upper pick, by barycentric weights v and w
    to_b, to_c, to = (v[:, :2] - a[:, :2] for v in (b, c, upper[point]))
    det = to_b[:, 0] * to_c[:, 1] - to_b[:, 1] * to_c[:, 0]
    known = np.where(det == 0.0, 1.0, det)  # upright triangles have no point between
    v = (to[:, 0] * to_c[:, 1] - to[:, 1] * to_c[:, 0]) / known
    w = (to_b[:, 0] * to[:, 1] - to_b[:, 1] * to[:, 0]) / known
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


def two_nearest(
    near: Sequence[NearPicks], n: int, trims: Sequence[float] | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The nearest fault of each pick (n,), -1 for none; its side of it; distances (2, n) [cells].

    Distances are those of the nearest and of the next fault, from their `trims` if given.
    """
    fault, side, far = np.full(n, -1), np.zeros(n), np.full((2, n), np.inf)
    for number, near_fault in enumerate(near):
        rows = near_fault.rows
        away = near_fault.far - (trims[number] if trims is not None else 0.0)
        closer = away < far[0, rows]
        far[1, rows] = np.where(closer, far[0, rows], np.minimum(away, far[1, rows]))
        rows = rows[closer]
        fault[rows], side[rows], far[0, rows] = number, near_fault.side[closer], away[closer]
    return fault, side, far


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


@dataclass(frozen=True, eq=False)
class Drawn:
    """Nodes (n,), increasing, heights that fault polygons draw them to [m], and their walls.

    `trace` is a number, `side` 1 or -1 as in `NearTrace`.
    """

    node: np.ndarray
    height: np.ndarray
    trace: np.ndarray
    side: np.ndarray


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
    drawn : Drawn or None
        What fault polygons draw.
    """

    throws: list[float] | None = None
    smear: Smear | None = None
    apart: frozenset[int] = frozenset()
    apart_is_final: bool = False
    drawn: Drawn | None = None


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
