"""Heights -> a torn mesh that its faults close: rings of ghosts and ends of tears, checked exactly.

The mesh is cut by the real faults. Where an outer edge would stay, the tear is ended one link
earlier if a tip is near, otherwise the ghosts get another ring there; then it is cut again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from geosurf.model import TriSurface
from geosurf.sheets.faults.cut_edges import FALLING, RISING, Cuts, within
from geosurf.sheets.faults.fault_distance import mesh_blocks, side_at_own_height
from geosurf.sheets.faults.traces import mesh_in_frame
from geosurf.sheets.heights.heights import Heights
from geosurf.sheets.lattice.data import Picks
from geosurf.sheets.lattice.frame import Frame
from geosurf.sheets.lattice.noise import scale_of
from geosurf.sheets.lattice.sets import distinct, is_among
from geosurf.sheets.mesh.cut import Cut, band_of, cut_band
from geosurf.sheets.mesh.ghosts import ghost_heights, grow, joined_heights
from geosurf.sheets.mesh.torn_mesh import Torn, Triangles, tear

ROUNDS = 20  # attempts to close a sheet before it is said where it stays open
RING = 0.3  # cells that a further ring of triangles reaches at least
SPARE = 0.25  # cells of overlap that the first ring covers for certain; further rings go past by it
CLEARLY = 0.3  # cells from a fault at which a node's side is clear
PATIENCE = 3  # rings that are tried before a tear is ended early where it need not be
MOST = 40  # links by which a tear may end early
AT_TIP = 2.0  # cells from the end of a tear within which a leak is a matter of that end


@dataclass(eq=False)
class Built:
    """A torn mesh with heights.

    Attributes
    ----------
    torn : Torn
    ghosts : ndarray (n_ghost,)
        Heights of the ghosts.
    cut : Cut
    shortened : dict of (trace, end) to int
        Links by which tears end earlier than their faults.
    cuts : Cuts
        Links cut in the mesh.
    outer : ndarray of int64
        Outermost ghosts, as vertices of `torn`.
    rounds : int
        Exact cuts that were made.
    """

    torn: Torn
    ghosts: np.ndarray
    cut: Cut
    cuts: Cuts
    outer: np.ndarray
    shortened: dict[tuple[int, int], int]
    rounds: int


class Builder:
    """Tears the mesh of one horizon and closes it against its faults."""

    def __init__(
        self,
        picks: Picks,
        state: Heights,
        faults: Sequence[TriSurface],
        rising: bool,
        carry_on: Callable[[Torn, Triangles, np.ndarray, Heights], np.ndarray],
        solve_again: Callable[[Heights, np.ndarray], Heights] | None = None,
    ) -> None:
        self.picks, self.state, self.faults = picks, state, list(faults)
        self.frame = picks.frame
        present = np.isfinite(state.values)
        self.triangles = Triangles(self.frame.shape, rising, present)
        meshes = [mesh_in_frame(fault, self.frame) for fault in self.faults]
        self.carry_on, self.solve_again = carry_on, solve_again
        self.joined = {(i, k) for i, k, _ in state.network.on}
        self.solved_for: dict[tuple[int, int], int] = {}
        every = state.network.cuts
        diagonal = RISING if rising else FALLING
        self.every = every
        self.in_mesh = np.flatnonzero((every.kind < 2) | (every.kind == diagonal))
        widest = [np.abs([w.left, w.right]).max(initial=0.0) for w in state.walls]
        self.reach = int(np.ceil(max(widest, default=0.0))) + 3
        self.meshes = [(mesh, mesh_blocks(mesh, float(self.reach))) for mesh in meshes]

    @property
    def reverse(self) -> set[tuple[int, int]]:
        """Ends of traces near which the horizon overlaps."""
        found = set()
        for i, walls in enumerate(self.state.walls):
            heave = walls.left + walls.right
            for k, part in enumerate((heave[:10], heave[-10:])):
                if len(part) and np.median(part) < 0:
                    found.add((i, k))
        return found

    def cuts(self, shortened: dict[tuple[int, int], int]) -> Cuts:
        """Links cut in the mesh: those inside the faults, less some at their ends."""
        return self.every.take(np.flatnonzero(within(self.every, *self._limits(shortened))))

    def _limits(self, shortened: dict[tuple[int, int], int]) -> tuple[np.ndarray, np.ndarray]:
        """First and last place of each trace that is torn in the mesh."""
        low, high = self.state.network.mesh.T.copy()
        mine = self.every.take(self.in_mesh)
        for (trace, end), n in shortened.items():
            place = np.sort(mine.place[(mine.trace == trace)])
            place = place[(place >= low[trace]) & (place <= high[trace])]
            if n >= len(place):
                low[trace], high[trace] = np.inf, -np.inf
            elif end == 0:
                low[trace] = place[n]
            else:
                high[trace] = place[-1 - n]
        return low, high

    def run(self) -> Built:
        """Tear, carry on, cut, and mend until nothing leaks."""
        shortened: dict[tuple[int, int], int] = {}
        extra: list[set[tuple[int, int]]] = []
        for attempt in range(1, ROUNDS + 1):
            built = self._attempt(shortened, extra)
            built.rounds = attempt
            if not (built.cut.leaks or built.cut.dead_ends):
                break
            self._mend(built, shortened, extra)
        return built

    def _die_at_tips(self, shortened: dict[tuple[int, int], int]) -> None:
        """Where a tear would leak at its end, throw has to die there: its last link is not torn."""
        if self.solve_again is None or shortened == self.solved_for:
            return
        self.solved_for = dict(shortened)
        limits = self.state.network.solve.copy()
        mesh = self._limits(shortened)
        for i, k in shortened:
            limits[i, k] = np.nextafter(mesh[k][i], np.inf if k == 0 else -np.inf)
        self.state = self.solve_again(self.state, limits)

    def _attempt(self, shortened, extra) -> Built:
        self._die_at_tips(shortened)
        cuts = self.cuts(shortened)
        torn = tear(cuts, self.triangles)
        torn = self._grown_over(torn)
        for links in extra:
            torn = self._grown_at(torn, links)
        bits = cuts.bits(self.picks.n_node)
        ghosts = self.carry_on(torn, self.triangles, bits, self.state)
        heights = self.state.values
        band = band_of(torn, self.triangles, self.frame, heights, ghosts, self.reach)
        blocks = [blocks for _, blocks in self.meshes]
        cut = cut_band(band, torn, self.triangles, self.faults, self.frame, blocks, self._is_own)
        return Built(torn, ghosts, cut, cuts, band.outer, dict(shortened), 0)

    def _is_own(self, nodes: np.ndarray, faults: Sequence[int]) -> np.ndarray:
        """Whether nodes are clearly on their own side of some faults, at their solved heights."""
        points = np.column_stack([self.frame.cells_of_node(nodes), self.state.values[nodes]])
        out = np.ones(len(nodes), dtype=bool)
        reach = float(self.reach)
        sides = {k: side_at_own_height(*self.meshes[k], points, reach) for k in faults}
        network = self.state.network
        for trace, limits, near in zip(network.traces, network.mesh, self.state.near, strict=True):
            if trace.fault not in sides:
                continue
            far, side = sides[trace.fault]
            at = near.look_up(nodes)
            inside = (at >= 0) & (side != 0)
            inside &= (near.place[at] > limits[0]) & (near.place[at] < limits[1])
            out &= ~inside | ((side == near.side[at]) & (far > CLEARLY))
        return out

    def _grown_over(self, torn: Torn) -> Torn:
        """Further rings where a reverse fault makes the horizon overlap its own trace."""
        widest = max(
            (-np.minimum(w.left, w.right).min(initial=0.0) for w in self.state.walls), default=0.0
        )
        if widest <= SPARE:
            return torn
        for _ in range(int(np.ceil((widest + SPARE) / RING))):
            needy = self._short_of_overlap(torn)
            if not needy.any():
                break
            torn = self._grown_from(torn, torn.n_node + np.flatnonzero(needy))
        return torn

    def _short_of_overlap(self, torn: Torn) -> np.ndarray:
        """Ghosts that do not lie past their sheet's cut-off yet, bool (n_ghost,)."""
        short = np.zeros(len(torn.anchor), dtype=bool)
        for near, walls in zip(self.state.near, self.state.walls, strict=True):
            of, at = near.look_up(torn.anchor), near.look_up(torn.node_of_ghost)
            rows = np.flatnonzero((of >= 0) & (at >= 0))
            own, at = near.side[of[rows]], at[rows]
            past = near.side[at] != own  # around a tip rings may come back over their own wall
            overlap = -walls.gap(near.place[at], own)
            far = near.distance[at]
            short[rows] |= past & (overlap > SPARE) & (far < overlap + SPARE)
        return short

    def _grown_from(self, torn: Torn, ghosts: np.ndarray) -> Torn:
        """Another ring along the outer edges that have one of these ghosts."""
        one, two = torn.corners.ravel(), np.roll(torn.corners, -1, axis=1).ravel()
        mine = is_among(one, ghosts) | is_among(two, ghosts)
        pairs = zip(one[mine].tolist(), two[mine].tolist(), strict=True)
        chosen = {(min(a, b), max(a, b)) for a, b in pairs}
        return grow(torn, self.triangles, chosen) if chosen else torn

    def _grown_at(self, torn: Torn, places: set[tuple[int, int]]) -> Torn:
        """Another ring where outer edges lie over given pairs of nodes, or beside them."""
        near = {node for pair in places for node in pair}
        vertices = torn.node_of(torn.corners.ravel()).reshape(-1, 3)
        chosen = set()
        for k in range(3):
            one, two = torn.corners[:, k], torn.corners[:, (k + 1) % 3]
            touched = np.isin(vertices[:, k], list(near)) | np.isin(
                vertices[:, (k + 1) % 3], list(near)
            )
            pairs = zip(one[touched].tolist(), two[touched].tolist(), strict=True)
            chosen |= {(min(a, b), max(a, b)) for a, b in pairs}
        return grow(torn, self.triangles, chosen)

    def _mend(self, built: Built, shortened, extra) -> None:
        """End tears earlier where faults end inside copies or leak at a tip; else grow a ring."""
        ends, links = set(), set()
        leaks = self._own_first(built)
        dead_ends = self._apart(built, leaks)
        found = (leaks, AT_TIP, ("tip",)), (dead_ends, 4 * AT_TIP, ("tip", "branch"))
        for pairs, reach, kinds in found:
            for a, b in pairs:
                nodes = built.torn.node_of(np.array([a, b]))
                end = self._end_near(nodes, shortened, reach, kinds)
                # a reverse fault overlaps right up to its tip, which another ring may cover
                if end in self.reverse and pairs is leaks and len(extra) < PATIENCE:
                    end = None
                if end is None and len(extra) >= PATIENCE:  # a branch that is too acute to tear
                    end = self._end_near(nodes, shortened, 3 * AT_TIP, ("branch",))
                if end is not None and shortened.get(end, 0) < MOST:
                    ends.add(end)
                else:
                    links.add((int(nodes[0]), int(nodes[1])))
        for end in ends:
            self._forget_rings(end, shortened, extra)
            is_tip = self.state.network.traces[end[0]].ends[end[1]] == "tip"
            shortened[end] = shortened.get(end, -1) + (1 if is_tip else 3)
        if links:
            extra.append(links)

    def _forget_rings(self, end: tuple[int, int], shortened, extra) -> None:
        """Rings that were tried at an end and did not close it are gone once it is ended early.

        Around a tip they come to lie over the whole sheet beyond it, where no fault cuts them.
        """
        for links in extra:
            mine = [
                pair
                for pair in links
                if self._end_near(np.array(pair), shortened, 3 * AT_TIP, ("tip",)) == end
            ]
            links.difference_update(mine)

    def _apart(self, built: Built, leaks) -> list[tuple[int, int]]:
        """Dead ends far from all leaks: near one they may be nothing but what it joins."""
        if not leaks or not built.cut.dead_ends:
            return built.cut.dead_ends
        node = built.torn.node_of(np.array(leaks).ravel())
        at = self.frame.uv_of_node(node)
        here = built.torn.node_of(np.array([a for a, _ in built.cut.dead_ends]))
        far = np.abs(self.frame.uv_of_node(here)[:, None] - at[None]).max(axis=2).min(axis=1)
        pairs = zip(built.cut.dead_ends, far, strict=True)
        return [pair for pair, cells in pairs if cells > 5 * AT_TIP]

    def _own_first(self, built: Built) -> list[tuple[int, int]]:
        """Leaks through the fault that a ghost was made for, if there are any; else all.

        Once a leak joins both walls, crossings of other faults look like leaks, too.
        """
        torn, own, every = built.torn, [], []
        for a, b, faults in built.cut.leaks:
            every.append((a, b))
            vertex = np.array([a, b])
            node, anchor = torn.node_of(vertex), torn.anchored(vertex)
            for trace, near in zip(self.state.network.traces, self.state.near, strict=True):
                at, of = near.look_up(node), near.look_up(anchor)
                both = (at >= 0) & (of >= 0)
                if trace.fault in faults and (both & (near.side[at] != near.side[of])).any():
                    own.append((a, b))
                    break
        return own or every

    def _end_near(self, nodes, shortened, reach, kinds) -> tuple[int, int] | None:
        """The end of a tear that is nearest to some nodes, if one is within reach [cells]."""
        best, found = reach, None
        limits = self._limits(shortened)
        at = self.frame.uv_of_node(nodes).mean(axis=0) * self.frame.stretch
        for i, trace in enumerate(self.state.network.traces):
            for k, end in enumerate(trace.ends):
                if not end.startswith(kinds) or (i, k) in self.joined:
                    continue
                place = limits[k][i]
                tip = [
                    np.interp(place, np.arange(len(trace.line)), trace.line[:, c]) for c in (0, 1)
                ]
                far = float(np.hypot(*(at - tip)))
                if far < best:
                    best, found = far, (i, k)
        return found


Known = Callable[[Torn, Triangles, np.ndarray, Heights, Callable | None], dict[int, float]]


def carry_on_by(
    frame: Frame, weight: float | None, known: Known
) -> Callable[[Torn, Triangles, np.ndarray, Heights], np.ndarray]:
    """How ghosts of picked sheets get their heights: by the energy, and by data beyond a trace.

    `known` gives the heights of ghosts that data tell of.
    """

    def carry_on(torn: Torn, triangles: Triangles, bits: np.ndarray, state: Heights):
        """Heights of the ghosts of one sheet."""
        bent = None if state.bent is None else partial(state.bent.of, frame)
        fixed = known(torn, triangles, bits, state, bent)
        past = None
        if state.bent is not None:
            past = partial(state.bent.only(_overlapping(state)).of, frame)
        return ghost_heights(
            torn, triangles, bits, state.values, frame.stretch, frame.cell, fixed, past,
            scale_of(weight),
        )  # fmt: skip

    return carry_on


def ghosts_by_picks(
    picks: Picks, weight: float | None, changing: Callable[[np.ndarray], None]
) -> Known:
    """Function that gives heights of the ghosts that picks tell of.

    Where data are noisy the sheet changes with them; `changing` is told its nodes.
    """

    def found(torn: Torn, triangles: Triangles, bits: np.ndarray, state: Heights, bent):
        """Heights of ghosts, by number."""
        fixed = _beyond(picks, state, torn)
        if weight is not None and fixed:  # the sheet is one with what it has past the trace
            nodes, fixed = joined_heights(
                torn, triangles, bits, state.values, picks.frame.stretch, fixed,
                lambda nodes: picks.means_at(nodes, state.used), weight, bent,
            )  # fmt: skip
            changing(nodes)
        return fixed

    return found


def _overlapping(state: Heights) -> list[int]:
    """Traces past which the sheets go on: there ghosts are part of them, and bend as they do."""
    heaves = [walls.left + walls.right for walls in state.walls]
    return [i for i, heave in enumerate(heaves) if len(heave) and np.median(heave) < 0.0]


def _beyond(picks: Picks, state: Heights, torn: Torn) -> dict[int, float]:
    """Ghosts whose heights were picked: an overlapping sheet beyond the trace."""
    found: dict[int, list[float]] = {}
    order = np.argsort(torn.node_of_ghost, kind="stable")
    nodes = torn.node_of_ghost[order]
    for trace in distinct(state.beyond[:, 1]):
        rows = state.beyond[state.beyond[:, 1] == trace]
        near = state.near[trace]
        at = near.look_up(torn.anchor)
        side = np.where(at >= 0, near.side[at], 0)
        start = np.searchsorted(nodes, picks.node[rows[:, 0]])
        stop = np.searchsorted(nodes, picks.node[rows[:, 0]], side="right")
        for pick, own, a, b in zip(rows[:, 0], rows[:, 2], start, stop, strict=True):
            for ghost in order[a:b]:
                if side[ghost] == own:
                    found.setdefault(int(ghost), []).append(float(picks.z[pick]))
    return {ghost: float(np.mean(z)) for ghost, z in found.items()}
