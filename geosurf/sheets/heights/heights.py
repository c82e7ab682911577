"""Picks and faults -> heights of all nodes, each side built from its own side only.

Two passes. The first distrusts generously; the heights of its two walls at each trace tell
where the horizon has a gap (normal) or an overlap (reverse), and how wide. The second has the
trim that was asked for, and knows more: values inside a gap belong to nobody, and values beyond
the trace belong to the other side's sheet where it overlaps.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from geosurf.arrangement.threads import map_threads
from geosurf.sheets.faults.cut_edges import Cuts, within
from geosurf.sheets.faults.fault_distance import (
    NearTrace,
    blocks_between,
    near_traces,
    rows_near,
    side_at_own_height,
    window,
)
from geosurf.sheets.faults.heave import Walls, throw_beside, walls_of
from geosurf.sheets.faults.network import Network
from geosurf.sheets.faults.tips import tips_of
from geosurf.sheets.faults.traces import FaultMesh
from geosurf.sheets.heights.overlap import widest_overlap
from geosurf.sheets.heights.relief import common_relief
from geosurf.sheets.heights.smear import Doubts
from geosurf.sheets.heights.tip_residual import Bent
from geosurf.sheets.heights.tip_solve import Task
from geosurf.sheets.lattice.data import Picks
from geosurf.sheets.lattice.drape import around, draped, narrow_gaps, without_absent
from geosurf.sheets.lattice.frame import Frame
from geosurf.sheets.lattice.noise import noise_of, scale_of
from geosurf.sheets.lattice.sets import distinct, is_among
from geosurf.sheets.lattice.solve import (
    BEND,
    grounded,
    lattice_graph,
    smoothest,
    steps_to_known,
    weights_of,
)
from geosurf.sheets.lattice.working_grid import Canvas

FIRST_TRIM = 3.0  # cells
FILL = 16.0  # cells: absent nodes beside a trace are filled in gaps up to this width
MAP_REACH = 12.0  # cells: how far from a trace sides are looked at in the map
WEDGE = 1.5  # trims, and at least
FEWEST = 4.0  # steps of extrapolation, from which distrusted data are listened to
UNSEEN_PULL = 0.1  # and how much, before it is seen how far off they are
HOLDS = 0.5  # trims from a fault beyond which a distrusted datum will do for a block without others
SLIVER = 12  # nodes: blocks without data up to this size are carried on without asking
BESIDE = 1.5  # cells from a trace within which noise is smoothed whatever was distrusted
BRIDGE = 0.75  # cells beside the cut-offs that are bridged to find the trace between them
SENSE = 0.25  # cells of heave below which gap and overlap are not told apart


@dataclass(eq=False)
class Settings:
    """What the user chose, in cells."""

    trim: float = 2.0
    first_trim: float = FIRST_TRIM
    noise_weight: float | None = None
    noise: float = 0.0
    collar: int = 16
    carry: bool = False

    @property
    def doubt(self) -> float:
        """Energy of one deviation of noise, 0 for data that are met exactly."""
        return 0.0 if self.noise_weight is None else self.noise_weight * self.noise**2

    @property
    def scale(self) -> float:
        """Over how many cells noisy data are meant, 1 for data that are met exactly."""
        return scale_of(self.noise_weight)


@dataclass(eq=False)
class Near:
    """Picks near one fault: rows, distance at own height, side."""

    rows: np.ndarray
    far: np.ndarray
    side: np.ndarray


@dataclass(eq=False)
class Heights:
    """Heights of the nodes of a torn horizon, and how they came about.

    Attributes
    ----------
    values : ndarray (n_node,)
        NaN where there is no node. The next solve writes to it: see `Canvas`.
    network : Network
    cuts : Cuts
        Links cut in the solve.
    near : list of NearTrace
    walls : list of Walls
    unknown : ndarray of int64
        Nodes that were solved for, increasing.
    used, distrusted : ndarray of bool (n_pick,)
        Picks that hold a node; picks near a fault that hold none.
    beyond : ndarray of int64 (n, 3)
        Picks that belong to the overlapping sheet of the other side: pick, trace, their side.
    stray : ndarray of int64
        Nodes that no datum of their own side reaches: blocks without data.
    extrapolation : ndarray (len(unknown),)
        Steps from each unknown node to the nearest datum of its side.
    carried : list of dict
        Blocks without data, and over which fault they were carried on.
    in_gap : ndarray of int64
        Picks between the cut-offs of a fault that leaves a gap: they belong to nobody.
    bent : Bent or None
        How much of it bends around tips.
    """

    values: np.ndarray
    network: Network
    cuts: Cuts
    near: list[NearTrace]
    walls: list[Walls]
    unknown: np.ndarray
    used: np.ndarray
    distrusted: np.ndarray
    beyond: np.ndarray
    stray: np.ndarray
    extrapolation: np.ndarray
    carried: list[dict] = field(default_factory=list)
    in_gap: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    bent: Bent | None = None

    def find_walls(self, frame: Frame) -> None:
        """Read `walls` off the heights beside the traces."""
        self.walls = walls_of(self.values, self.cuts, self.network.traces, frame)


class Rebuild:
    """Picks and faults of one horizon, and the passes over them."""

    def __init__(self, picks: Picks, meshes: list[FaultMesh], settings: Settings) -> None:
        self.picks, self.meshes, self.settings = picks, meshes, settings
        self.shape, self.stretch = picks.frame.shape, picks.frame.stretch
        half = 0.5 * widest_overlap(picks, meshes)
        if half > max(settings.trim, settings.first_trim) + 1.0:
            settings.first_trim = half + 1.0  # no mean of both walls is taken for a datum
        self.reach = max(settings.trim, settings.first_trim) + 1.0
        self.levels = float(picks.z.min()), float(picks.z.max())
        self.nearby = map_threads(self._near, [(mesh,) for mesh in meshes])
        self.throws: list[float] | None = None  # largest of each trace: not known yet
        self.hiding = settings.trim
        self.doubts = Doubts(picks, self.nearby)
        self.apart: set[int] = set()  # traces whose walls have nothing in common
        self.apart_known = False
        self.canvas = Canvas(picks)
        self.present = np.isfinite(picks.means)
        gaps = narrow_gaps(self.present.reshape(self.shape), FILL)
        self.fillable = np.flatnonzero(gaps.ravel())

    def torn_between(self, state: Heights, limits: np.ndarray) -> Heights:
        """The last pass again, torn between other places (n_trace, 2) of the same traces."""
        doubted, sure, beyond = self._last
        cuts = self._cuts_within(state.network, limits)
        found = self._solve(doubted, sure, state.network, state.near, cuts, beyond)
        found.walls, found.in_gap = state.walls, state.in_gap
        return found

    def _near(self, mesh: FaultMesh) -> Near:
        mesh, blocks = blocks_between(mesh, self.reach, *self.levels)
        if blocks is None:
            return Near(np.empty(0, dtype=np.int64), np.empty(0), np.empty(0))
        near = self.picks.of_nodes(window(self.picks.frame, blocks))
        uv = self.picks.columns(near) * self.stretch
        rows, _ = blocks.of(uv)
        points = np.column_stack([uv[rows], self.picks.z[near[rows]]])
        far, side = side_at_own_height(mesh, blocks, points, self.reach)
        close = side != 0
        return Near(near[rows[close]], far[close], side[close])

    def noise(self) -> tuple[float, float]:
        """Noise of the data, and typical third difference of the surface [m]."""
        noise, self.doubts.signal = noise_of(self.trusted_grid())
        return noise, self.doubts.signal

    def trusted_grid(self) -> np.ndarray:
        """Heights (n_row, n_col) of the data that no pass distrusts."""
        doubted = np.zeros(len(self.picks.z), dtype=bool)
        for near in self.nearby:
            doubted[near.rows] = True
        self.canvas.without(doubted)
        return self.canvas.values.reshape(self.shape)

    def hidden(self, trim: float) -> Heights:
        """The first pass alone: what is nearer than `trim` is hidden, whichever side it is on."""
        return self._pass(trim, None)

    def run(self) -> Heights:
        """Both passes."""
        first = self._pass(self.settings.first_trim, None)
        if len(first.stray):  # the generous trim left nothing between two faults
            first = self._pass(self.settings.trim, None)
        first.find_walls(self.picks.frame)
        if self.picks.on_nodes:
            self.doubts.see(first, self.in_gap(first), self._far_from_data)
        first = self._retraced(first)
        self.throws = [float(np.abs(w.throw).max(initial=0.0)) for w in first.walls]
        heaves = [w.left + w.right for w in first.walls]
        # in an overlap, points past the trace tell of the walls' ends
        self.apart = {k for k, h in enumerate(heaves) if len(h) and np.median(h) < -SENSE}
        second = self._pass(self.settings.trim, first)
        self.apart_known = True
        second.find_walls(self.picks.frame)
        second.in_gap = self.in_gap(second)
        return second

    def _retraced(self, state: Heights) -> Heights:
        """The same heights with traces on them: bridged between both walls, no farther."""
        bridged = [state.unknown[:0]]
        for near, walls in zip(state.near, state.walls, strict=True):
            widest = max(walls.left.max(initial=0.0), walls.right.max(initial=0.0))
            at = near.within(widest + BRIDGE)
            gap = np.maximum(walls.gap(near.place[at], near.side[at]), 0.0)
            bridged.append(near.node[at[near.distance[at] < gap + BRIDGE]])
        lost = distinct(*bridged, state.unknown[np.isnan(state.values[state.unknown])])
        self.canvas.changing(lost)
        state.values[lost] = np.nan
        network = self._traced(state.values, lost[self.present[lost]])
        near = near_traces(self.picks.frame, network.traces, MAP_REACH)
        cuts = self._cuts_within(network, network.solve)
        doubted, sure, beyond = self._last
        found = self._solve(doubted, sure, network, near, cuts, beyond)
        found.find_walls(self.picks.frame)
        return found

    def in_gap(self, state: Heights) -> np.ndarray:
        """Picks that lie between the cut-offs of a fault in the map."""
        found = [np.empty(0, dtype=np.int64)]
        for trace, near, walls in zip(state.network.traces, state.near, state.walls, strict=True):
            rows = self.nearby[trace.fault].rows
            at = near.look_up(self.picks.nodes_of(rows))
            rows, at = rows[at >= 0], at[at >= 0]
            gap = walls.gap(near.place[at], near.side[at])
            found.append(rows[near.distance[at] < gap])
        return distinct(*found)

    def _pass(self, trim: float, before: Heights | None) -> Heights:
        self.hiding = trim
        doubted = np.zeros(len(self.picks.z), dtype=bool)
        for near in self.nearby:
            doubted[near.rows[near.far < trim]] = True
        if before is None:
            network = self._network(doubted)
            near = near_traces(self.picks.frame, network.traces, MAP_REACH)
            cuts = self._cuts_within(network, network.solve)
        else:
            network, near, cuts = before.network, before.near, before.cuts
        wrong = np.zeros_like(doubted)
        beyond = self._doubt_sides(doubted, wrong, network, near, before)
        sure = ~wrong
        if self.picks.several is not None:
            sure &= ~self.picks.several[self.picks.node]
        self._last = doubted | wrong, sure, beyond
        carried = () if before is None else before.carried
        return self._solve(doubted | wrong, sure, network, near, cuts, beyond, carried)

    def _cuts_within(self, network: Network, limits: np.ndarray) -> Cuts:
        """Links that traces cut between two places (n_trace, 2) of each."""
        return network.cuts.take(np.flatnonzero(within(network.cuts, *limits.T)))

    def _network(self, doubted: np.ndarray) -> Network:
        lost = self.canvas.without(doubted)
        return self._traced(self.canvas.values, lost)

    def _traced(self, heights: np.ndarray, lost: np.ndarray) -> Network:
        """Traces on a horizon drawn across the nodes of `lost` and narrow gaps; writes there."""
        fill = distinct(lost, self.fillable)
        filled = fill[np.isnan(heights[fill])]
        self.canvas.changing(fill)
        heights[fill] = draped(heights, fill, self.shape, self.stretch)
        return Network(self.meshes, heights.reshape(self.shape), self.picks.frame, filled)

    def _doubt_sides(self, doubted, wrong, network, near, before) -> np.ndarray:
        """Mark picks that are on the wrong side; return those of an overlapping sheet."""
        beyond = []
        nodes = [self.picks.nodes_of(self.nearby[t.fault].rows) for t in network.traces]
        for number, at in enumerate(rows_near(near, nodes)):
            own = self.nearby[network.traces[number].fault]
            rows, side = own.rows[at >= 0], own.side[at >= 0]
            far, at = own.far[at >= 0], at[at >= 0]
            place, here = near[number].place[at], near[number].side[at]
            first, last = network.mesh[number]  # past the rim of the data, where it leaves them
            inside = (place > first) & (place < last)
            across = inside & (side != here)
            if before is not None:
                walls = before.walls[number]
                reverse = walls.heave(place) < -SENSE
                normal = walls.heave(place) > SENSE
                # between the cut-offs of a gap there is no horizon: values there were carried
                empty = near[number].distance[at] < walls.gap(place, here)
                many = self.picks.several
                several = False if many is None else many[self.picks.nodes_of(rows)]
                close = near[number].distance[at] < 1.0 + np.abs(walls.heave(place))
                wrong[rows[inside & normal & (empty | (several & close))]] = True
                mine = across & reverse & (far >= self.settings.trim) & ~doubted[rows]
                number_of = np.full(mine.sum(), number)
                beyond.append(
                    np.stack([rows[mine], number_of, side[mine].astype(np.int64)], axis=1)
                )
            wrong[rows[across]] = True
        return np.concatenate([np.empty((0, 3), dtype=np.int64), *beyond])

    def _solve(self, doubted, sure, network, near, cuts, beyond, carried=()) -> Heights:
        unknown = self._unknown(self.canvas.without(doubted), near)
        heights = self.canvas.values
        weight = self.settings.noise_weight
        soft = np.empty(0, dtype=np.int64)
        if weight is not None:  # also where every node beside a trace has a datum of its side
            beside = [t.nodes_within(BESIDE) for t in near]
            collar = around(distinct(unknown, *beside), self.shape, self.settings.collar)
            soft = collar[np.isfinite(heights[collar]) & ~is_among(collar, unknown)]
        every = distinct(unknown, soft)
        # a collar's rim is free: held to noisy data beyond it, bit for bit, it would bend
        band = every if len(soft) else around(every, self.shape, 3)
        graph = lattice_graph(band, self.shape, cuts.bits(self.picks.n_node))
        at = np.searchsorted(band, every)
        value = heights[band]
        is_unknown = np.zeros(len(band), dtype=bool)
        is_unknown[np.searchsorted(band, unknown)] = True
        graph = without_absent(graph, np.isfinite(value) | is_unknown)
        every_step = steps_to_known(graph, np.where(is_unknown, 0, -1))
        steps = every_step[is_unknown]
        heard = band[self.doubts.heard(graph, every_step, int(self._far_from_data))]
        data, pull, alone = self._targets(heights, every, soft, heard, sure)
        held = is_unknown.copy()
        held[at[alone]] = False  # data that only draw a sheet ground it, too
        tied = np.ones(len(band), dtype=bool)
        tied[held] = grounded(graph, np.where(held, np.cumsum(held) - 1, -1))
        stray = band[~tied]
        if len(stray):
            bridge = self._bridge(stray, cuts, near, network)
            if bridge is not None:
                cuts, note = bridge
                found = (*carried, note)
                return self._solve(doubted, sure, network, near, cuts, beyond, found)
        solved = np.zeros(len(band), dtype=bool)
        solved[at] = True
        solved &= tied
        graph = without_absent(graph, np.isfinite(value) | solved)
        number = np.where(solved, np.cumsum(solved) - 1, -1)
        kept = solved[at]
        filled = np.where(np.isfinite(value), value, 0.0)
        self.canvas.changing(band[solved])
        if self.throws is None or weight is None:
            heights[band[solved]] = smoothest(
                graph, number, filled, self.stretch, pull=pull[kept], target=data[kept],
                scale=self.settings.scale,
            )  # fmt: skip
        bent = self._bent_at_tips(
            heights, band[solved], network, near, cuts, data[kept], pull[kept]
        )
        return Heights(
            heights, network, cuts, near, [], unknown, ~doubted, doubted, beyond, stray,
            steps.astype(np.float64), list(carried), bent=bent,
        )  # fmt: skip

    def _bent_at_tips(self, heights, nodes, network, near, cuts, data, pull) -> Bent | None:
        """Solve again with the shapes of a throw that dies at tips: see `tip_solve`."""
        if self.throws is None:
            return None
        settings = self.settings
        task = Task(
            self.picks.frame, heights, nodes, data, pull, cuts.bits(self.picks.n_node),
            tips_of(network.traces, near, cuts), self.throws, settings.doubt, settings.scale,
        )  # fmt: skip
        if settings.noise_weight is None:
            return task.near_tips()
        weights = weights_of(self.stretch, BEND, scale=settings.scale)
        shape = self.shape
        heights[nodes], bent = task.shared(
            near,
            self.apart,
            lambda: common_relief(nodes, cuts, network, near, shape, weights, self.apart),
            self.apart_known,
        )
        return bent

    @property
    def _far_from_data(self) -> float:
        """Steps of extrapolation from which distrusted data are listened to, in this pass."""
        return max(FEWEST, WEDGE * self.hiding)

    def _unknown(self, lost: np.ndarray, near: list[NearTrace]) -> np.ndarray:
        """Nodes without a trusted value, and absent ones in gaps beside a trace."""
        fill = self.fillable
        if len(fill):
            beside = [t.nodes_within(FILL) for t in near]
            fill = fill[is_among(fill, distinct(np.empty(0, np.int64), *beside))]
        return distinct(lost, fill)

    def _targets(self, heights, every, soft, heard, sure):
        """What draws each solved node, how much, and whether it may do so alone.

        Noisy data, and in wedges distrusted ones: between two faults that meet at an acute angle
        all data are near a fault. Where that would mean to extrapolate far, those that are on the
        right side are listened to (`Doubts.heard`), as hard as what is seen of their smear allows.
        """
        data, pull = np.zeros(len(every)), np.zeros(len(every))
        alone = np.zeros(len(every), dtype=bool)
        rows = np.searchsorted(every, soft)
        data[rows], pull[rows] = heights[soft], self.settings.noise_weight or 0.0
        alone[rows] = True
        heard = heard[self.present[heard]]
        if len(heard):
            values = self.picks.means_at(heard, sure)
            heard, values = heard[np.isfinite(values)], values[np.isfinite(values)]
            far, rows = self.doubts.far(heard), np.searchsorted(every, heard)
            alone[rows] = far >= HOLDS * self.hiding
            noise, most = self.settings.noise, self.settings.noise_weight
            unseen = np.where(alone[rows], UNSEEN_PULL, 0.0)
            data[rows], pull[rows] = values, self.doubts.pull(far, noise, most, unseen)
        return data, pull, alone & (pull > 0)

    def _bridge(self, stray, cuts: Cuts, near, network):
        """Join blocks without data to a neighbour, over the fault with the smaller throw.

        Slivers of a few nodes only, unless it was asked for; None otherwise.
        """
        if len(stray) > SLIVER and not self.settings.carry:
            return None
        first, second = cuts.ends(self.shape[1])
        inside = is_among(first, stray), is_among(second, stray)
        border = inside[0] != inside[1]
        if not border.any():
            return None
        choice = distinct(cuts.trace[border])
        throw = [throw_beside(self.picks.means, near[t], stray) for t in choice]
        trace = int(choice[int(np.argmin(throw))])
        gone = (cuts.trace == trace) & (inside[0] | inside[1])
        name = self.meshes[network.traces[trace].fault].name
        xy = self.picks.frame.node_places(stray[:1])[0]
        note = {"nodes": len(stray), "over": name, "place": [float(c) for c in xy]}
        return cuts.take(np.flatnonzero(~gone)), note
