"""Heights -> a torn mesh that its faults close: rings of ghosts and ends of tears, checked exactly.

The mesh is cut by the real faults. Where an outer edge would stay open, `repairs` ends the tear
one link earlier if a tip is near, otherwise it gives the ghosts another ring there. Then the mesh
is cut again.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from threading import Lock

import numpy as np

from geosurf.kernels.lattices.sets import distinct
from geosurf.model import TriSurface
from geosurf.sheets.faults.cut_edges import Cuts, Part, is_torn, within
from geosurf.sheets.faults.fault_distance import Blocks, mesh_blocks, side_at_own_height
from geosurf.sheets.faults.traces import FaultMesh, mesh_in_frame
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.lattice.frame import Frame
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.mesh.carry_on import CarryOn
from geosurf.sheets.mesh.cut import Cut, band_of, cut_band
from geosurf.sheets.mesh.holes import Hole
from geosurf.sheets.mesh.repairs import NO_REPAIRS, Repairs, repaired
from geosurf.sheets.mesh.rings import grown_at, grown_over, levelled
from geosurf.sheets.mesh.tear_ends import End, torn_limits
from geosurf.sheets.mesh.torn_mesh import Torn, Triangles, tear

ROUNDS = 24  # attempts to close a sheet before an error names where it stays open
MANY = 20  # holes
HOPELESS = 8  # attempts in a row that leave as many
STUCK = 3  # attempts after which a hole of the same size at the same place is stuck

SolveAgain = Callable[[Heights, np.ndarray, Sequence[Part]], Heights]
NeedsMore = Callable[[Sequence[Hole]], object]


@dataclass(frozen=True, eq=False)
class Built:
    """A torn mesh with heights.

    Attributes
    ----------
    state : Heights
        Of the nodes; tears that end early may have changed them.
    triangles : Triangles
        Of the lattice.
    torn : Torn
    ghosts : ndarray (n_ghost,)
        Heights of the ghosts.
    cut : Cut
    cuts : Cuts
        Links cut in the mesh.
    outer : ndarray of int64
        Outermost ghosts, as vertices of `torn`.
    repairs : Repairs
        What closed the sheet, or was tried last.
    n_cut : int
        How many attempts there were until then.
    walls : dict of str to ndarray of int8 (n_node,), or None
        Of the nodes at each fault, if throw moved them: 1 hanging wall, -1 footwall.
    """

    state: Heights
    triangles: Triangles
    torn: Torn
    ghosts: np.ndarray
    cut: Cut
    cuts: Cuts
    outer: np.ndarray
    repairs: Repairs
    n_cut: int = 1
    walls: dict[str, np.ndarray] | None = None

    @property
    def is_open(self) -> bool:
        """Whether the sheet ends anywhere but on its faults."""
        return bool(self.cut.leaks or self.cut.dead_ends)

    @property
    def is_hopeless(self) -> bool:
        """Whether there are so many holes that the data contradict the faults."""
        return len(self.cut.holes) > MANY


@dataclass(frozen=True, eq=False)
class Setting:
    """What stays the same in all attempts to close one sheet.

    Attributes
    ----------
    picks : Picks
    faults : list of TriSurface
    triangles : Triangles
    reach : int
        Cells from a trace within which the mesh is cut.
    carry_on : callable
        Gives the heights of ghosts.
    known : Known
        What attempts have found out.
    walls : dict or None
        See `Built`.
    """

    picks: Picks
    faults: list[TriSurface]
    triangles: Triangles
    reach: int
    carry_on: CarryOn
    known: Known
    walls: dict[str, np.ndarray] | None


def build(
    picks: Picks,
    state: Heights,
    faults: Sequence[TriSurface],
    rising: bool,
    carry_on: CarryOn,
    solve_again: SolveAgain,
    at_any_cost: bool = False,
    start: Repairs = NO_REPAIRS,
    needs_more: NeedsMore | None = None,
    is_solved: bool = False,
    walls: dict[str, np.ndarray] | None = None,
) -> Built:
    """Tear the mesh of one horizon, and repair it until its faults close it.

    Parameters
    ----------
    picks, state, faults
        The horizon, the heights of its nodes with walls, and its faults.
    rising : bool
        Whether the diagonals of the lattice rise to the north-east.
    carry_on : callable
        Gives the heights of ghosts: see `carry_on_by`.
    solve_again : callable
        Gives heights in which throw dies where tears end early.
    at_any_cost : bool
        Whether cut-offs may change where nothing else closes the sheet: see `repaired`.
    start : Repairs
        What earlier attempts have found to be necessary.
    needs_more : callable, optional
        Whether holes that attempts have not changed need a longer fault: then the attempts end.
    is_solved : bool
        Whether the heights are those of the ends of tears in `start`.
    walls : dict, optional
        See `Built`.

    Returns
    -------
    Built
        The first that is closed, or the last attempt.
    """
    setting = _setting(picks, state, faults, rising, carry_on, walls)

    # Attempts: solve where ends have changed, tear, cut, then plan repairs from the holes.
    repairs = start
    solved_for: tuple[dict[End, int], tuple[Part, ...]] = ({}, ())
    if is_solved:
        solved_for = start.shortened, start.untorn
    fewest, since = len(setting.triangles.present), 0
    before: list[Sequence[Hole]] = []
    for n_before in range(ROUNDS):
        # heights change with the ends of tears only: rings and level ghosts need no new solve
        if (repairs.shortened, repairs.untorn) != solved_for:
            solved_for = repairs.shortened, repairs.untorn
            state = die_at_tips(state, repairs, rising, solve_again)
        built = replace(_cut(setting, state, repairs), n_cut=n_before + 1)
        if not built.is_open:
            break

        # many holes that do not become fewer: the data contradict the faults
        n_hole = len(built.cut.holes)
        fewest, since = (n_hole, 0) if n_hole < fewest else (fewest, since + 1)
        if built.is_hopeless and since > HOPELESS:
            break
        before.append(built.cut.holes)
        stuck = _stuck(before, picks.frame.cell)
        # A fault that is too short cannot be repaired in the mesh: the caller extends it.
        if needs_more is not None and needs_more(stuck):
            break
        more = repaired(repairs, state, built.torn, built.cut, stuck, rising, at_any_cost)
        # No repair is left: the last attempt is handed back, open.
        if more is None:
            break
        repairs = more
    return built


def _setting(
    picks: Picks,
    state: Heights,
    faults: Sequence[TriSurface],
    rising: bool,
    carry_on: CarryOn,
    walls: dict[str, np.ndarray] | None,
) -> Setting:
    """What stays the same in all attempts, for the arguments of `build`."""
    triangles = Triangles(picks.frame.shape, rising, np.isfinite(state.values))

    # cut-offs lie as far from their trace as the widest gap or overlap: the band holds them all
    widest = [np.abs([w.left, w.right]).max(initial=0.0) for w in state.walls]
    reach = int(np.ceil(max(widest, default=0.0))) + 3
    meshes = [mesh_in_frame(fault, picks.frame) for fault in faults]
    blocks = [(mesh, mesh_blocks(mesh, float(reach))) for mesh in meshes]
    known = Known(picks.frame, triangles, blocks, float(reach))
    return Setting(picks, list(faults), triangles, reach, carry_on, known, walls)


def _stuck(holes: Sequence[Sequence[Hole]], cell: float) -> list[Hole]:
    """The last holes that were the same some attempts ago; `holes` has those of each attempt."""
    # Too few attempts to compare with.
    if len(holes) <= STUCK:
        return []
    return [hole for hole in holes[-1] if any(hole.is_like(old, cell) for old in holes[-1 - STUCK])]


def die_at_tips(state: Heights, repairs: Repairs, rising: bool, solve_again: SolveAgain) -> Heights:
    """Where a tear would leak at its end, throw has to die there: its last link is not torn."""
    limits = state.network.solve.copy()
    # The ends as the mesh tears them, with the repairs so far.
    ends = torn_limits(state, repairs.shortened, rising)
    for i, k in repairs.shortened:
        # one float past the last torn link: the mesh tears that link, the solve keeps it whole, so
        # that both its ends are on one sheet and throw dies there
        limits[i, k] = np.nextafter(ends[k][i], np.inf if k == 0 else -np.inf)
    return solve_again(state, limits, repairs.untorn)


def _meshed(setting: Setting, state: Heights, repairs: Repairs) -> tuple[Torn, np.ndarray, Cuts]:
    """The mesh with some repairs, heights of its ghosts, and the links that it is torn at."""
    triangles, picks = setting.triangles, setting.picks
    every = state.network.cuts
    limits = torn_limits(state, repairs.shortened, triangles.rising)

    # links between the ends of the tears, without the parts of traces that are left out
    torn_rows = within(every, *limits) & is_torn(every, repairs.untorn, state.network.traces)
    cuts = every.take(np.flatnonzero(torn_rows))

    # the mesh, with rings of ghosts where they are needed
    torn = setting.known.mesh(cuts, state, repairs.rings)
    # Traces whose tears end before their faults: their ghosts do not bend at the tip.
    early = {trace for (trace, _), n_link in repairs.shortened.items() if n_link > 0}
    ghosts = setting.carry_on(torn, triangles, cuts.bits(picks.n_node), state, early)
    return torn, levelled(torn, ghosts, state.values, repairs.level, picks.frame), cuts


def _cut(setting: Setting, state: Heights, repairs: Repairs) -> Built:
    """Cut the mesh with some repairs exactly."""
    triangles, frame = setting.triangles, setting.picks.frame
    torn, ghosts, cuts = _meshed(setting, state, repairs)
    band = band_of(torn, triangles, frame, state.values, ghosts, setting.reach, setting.walls)

    def is_own(nodes: np.ndarray) -> np.ndarray:
        """Which nodes are clearly on their own side of all faults."""
        return setting.known.is_own(nodes, state)

    cut = cut_band(band, torn, triangles, setting.faults, frame, is_own)
    return Built(state, triangles, torn, ghosts, cut, cuts, band.outer, repairs, 1, setting.walls)


CLEARLY = 0.3  # cells from a fault at which a node's side is clear
Ring = Collection[tuple[int, int]]


class Known:
    """What attempts to close one sheet have found out.

    Attributes
    ----------
    frame : Frame
    triangles : Triangles
    meshes : list of (FaultMesh, Blocks)
        The faults in the frame of the lattice, and blocks to search them by.
    reach : float
        Cells from a trace within which sides are looked at.
    """

    def __init__(
        self,
        frame: Frame,
        triangles: Triangles,
        meshes: Sequence[tuple[FaultMesh, Blocks]],
        reach: float,
    ) -> None:
        self.frame, self.triangles = frame, triangles
        self.meshes, self.reach = list(meshes), reach
        # what all of this follows from, besides links, rings and heights
        self._state: Heights | None = None
        # links that tear the last mesh, and the mesh without rings, with one, with two ..
        self._cuts: Cuts | None = None
        self._rings: list[Ring] = []
        self._torn: list[Torn] = []
        # heights at which nodes were asked for, NaN for others, and what came of it
        self._height = np.full(len(triangles.present), np.nan)
        self._is_own = np.zeros(len(triangles.present), dtype=bool)
        self._lock = Lock()

    def mesh(self, cuts: Cuts, state: Heights, rings: Sequence[Ring]) -> Torn:
        """The mesh torn by some links, with rings of ghosts.

        It starts from the last one, with as many of its rings as are the same.
        """
        self._forget_unless_like(state)
        if self._cuts is None or not _same(cuts, self._cuts):
            torn = grown_over(tear(cuts, self.triangles), self.triangles, state)
            self._cuts, self._rings, self._torn = cuts, [], [torn]
        pairs = zip(self._rings, rings, strict=False)
        n = next((k for k, (old, new) in enumerate(pairs) if old != new), None)
        n = min(len(self._rings), len(rings)) if n is None else n
        del self._rings[n:], self._torn[n + 1 :]
        for ring in rings[n:]:
            self._torn.append(grown_at(self._torn[-1], self.triangles, ring))
            self._rings.append(ring)
        return self._torn[-1]

    def is_own(self, nodes: np.ndarray, state: Heights) -> np.ndarray:
        """Whether nodes are clearly on their own side of all faults, at their solved heights.

        `state` is that of the last mesh.
        """
        # islands ask side by side
        with self._lock:
            changed = nodes[state.values[nodes] != self._height[nodes]]
            if len(changed):
                changed = distinct(changed)
                self._is_own[changed] = self._asked(changed, state)
                self._height[changed] = state.values[changed]
            return self._is_own[nodes]

    def _forget_unless_like(self, state: Heights) -> None:
        """Forget everything if traces or walls are others; their heights may change."""
        old, self._state = self._state, state
        if old is None or (
            old.network is state.network
            and old.walls is state.walls
            and all(a is b for a, b in zip(old.near, state.near, strict=True))
        ):
            return
        self._cuts = None
        self._height[:] = np.nan

    def _asked(self, nodes: np.ndarray, state: Heights) -> np.ndarray:
        points = np.column_stack([self.frame.cells_of_node(nodes), state.values[nodes]])
        out = np.ones(len(nodes), dtype=bool)
        # Sides at the solved height: a fault that dips is elsewhere at another elevation.
        network = state.network
        sides = {
            k: side_at_own_height(*self.meshes[k], points, self.reach)
            for k in {trace.fault for trace in network.traces}
        }
        for trace, limits, near in zip(network.traces, network.mesh, state.near, strict=True):
            far, side = sides[trace.fault]

            # rows of nodes near the trace (-1: far); off the torn part, or where the fault is out
            # of reach (side 0), a node has no wrong side
            at = near.look_up(nodes)
            inside = (at >= 0) & (side != 0)
            inside &= (near.place[at] > limits[0]) & (near.place[at] < limits[1])
            out &= ~inside | ((side == near.side[at]) & (far > CLEARLY))
        return out


def _same(one: Cuts, other: Cuts) -> bool:
    """Whether the same links are cut, by the same traces at the same places."""
    return (
        np.array_equal(one.node, other.node)
        and np.array_equal(one.kind, other.kind)
        and np.array_equal(one.trace, other.trace)
    )
