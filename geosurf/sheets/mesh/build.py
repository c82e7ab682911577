"""Heights -> a torn mesh that its faults close: rings of ghosts and ends of tears, checked exactly.

The mesh is cut by the real faults. Where an outer edge would stay open, `repairs` ends the tear
one link earlier if a tip is near, otherwise it gives the ghosts another ring there. Then the mesh
is cut again.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from geosurf.kernels.lattices.sets import is_among
from geosurf.model import TriSurface
from geosurf.sheets.faults.cut_edges import Cuts, Part, is_torn, within
from geosurf.sheets.faults.fault_distance import mesh_blocks, side_at_own_height
from geosurf.sheets.faults.traces import mesh_in_frame
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.lattice.picks import Frame, Picks
from geosurf.sheets.mesh.cut import Cut, Hole, band_of, cut_band
from geosurf.sheets.mesh.ghosts import CarryOn, grow, kept_apart
from geosurf.sheets.mesh.tear_ends import (
    End,
    Ends,
    is_overlapping,
    longer_part,
    reverse_ends,
    torn_limits,
    with_part_at,
    without_throw,
)
from geosurf.sheets.mesh.torn_mesh import Torn, Triangles, tear

# ---- repairs ----------------------------------------
# How to close the holes of a sheet: the smallest repair that may do is tried first.
#
# The ghosts at the hole get another ring. If that does not close a hole at a tip, the tear ends a
# link earlier. Where the data show no throw, the tear is left out. At any cost the nearest end of
# a tear is moved, the sheet goes on level past the fault (one that is extrapolated along the dip
# of its fault never meets it), or a part of the trace with the smallest throw there is left out.


PATIENCE = 3  # rings that are tried before a reverse tear ends early, or a part without throw
AT_END = 1  # rings that are tried before any tear ends early, by its first two links each
# cells: an edge that leaks is as long as that. A shorter hole at a tip passes through a triangle
# which the fault divides, and no ring closes it: 80 of 80 on 400 random networks
SHORTEST = 1.0
RINGS, RINGS_OVER = 6, 12  # that are tried at a hole: at a gap, and where the horizon overlaps
LEVELLED = 2  # further ones, which are level
NEAR_LEAK = 4.0  # cells from a hole within which an outer edge that leaks gets a ring with it
MOST_LINKS = 40  # by which a tear may end early
AT_TIP = 2.0  # cells from the end of a tear within which a hole is a matter of that end

Pair = tuple[int, int]


@dataclass(frozen=True)
class Repairs:
    """What one attempt to close a sheet is made with.

    Attributes
    ----------
    shortened : dict of (trace, end) to int
        Links by which tears end earlier than their faults.
    rings : tuple of frozenset of (int, int)
        For each further ring the pairs of nodes at whose edges it is.
    level : tuple of (float, float)
        Places [cells] around which sheets go on level past their faults.
    untorn : tuple of (int, float, float)
        Parts of traces that are left out: trace, first and last place along it [cells].
    """

    shortened: dict[End, int] = field(default_factory=dict)
    rings: tuple[frozenset[Pair], ...] = ()
    level: tuple[tuple[float, float], ...] = ()
    untorn: tuple[Part, ...] = ()


NO_REPAIRS = Repairs()


@dataclass
class Plan:
    """What to change before the next attempt, hole by hole."""

    ends: set[End]
    links: set[Pair]
    level: list[tuple[float, float]]
    untorn: tuple[Part, ...]


def repaired(built: Built, stuck: Collection[Hole], at_any_cost: bool) -> Repairs | None:
    """Repairs for the attempt after this one; None if nothing is left to try.

    Holes that are stuck get no further ring. `at_any_cost` allows what changes cut-offs: a level
    sheet, ends of tears that are moved far, and parts of traces that are left out.
    """
    repairs, state, rising = built.repairs, built.state, built.triangles.rising
    # All holes of one attempt are planned for together: each attempt costs a cut.
    frame, plan = state.network.frame, Plan(set(), set(), [], repairs.untorn)
    tears = Ends(state, torn_limits(state, repairs.shortened, rising))
    for hole in built.cut.holes:
        is_stuck = any(hole is other for other in stuck)
        _plan_for(hole, plan, built, tears, is_stuck, at_any_cost)
    # Nothing changes: another attempt would find the same holes.
    if not (plan.ends or plan.links or plan.untorn != repairs.untorn):
        return None

    shortened, rings = dict(repairs.shortened), list(repairs.rings)
    for end in plan.ends:
        # rings that were tried at an end and did not close it go once it is ended early: around
        # a tip they come to lie over the whole sheet beyond it, where no fault cuts them
        tears = Ends(state, torn_limits(state, shortened, rising))
        for k, ring in enumerate(rings):
            pairs = list(ring)
            nearest = tears.nearest_of(_middles(frame, pairs), 3 * AT_TIP, ("tip",))
            mine = {pair for pair, near in zip(pairs, nearest, strict=True) if near == end}
            rings[k] = ring - mine

        # at a tip 0 comes first: the tear ends where it did, but throw dies at its last link
        is_tip = state.network.traces[end[0]].ends[end[1]] == "tip"
        n = shortened.get(end, -1)
        shortened[end] = n + max(1 if is_tip else 3, n // 2)  # farther each time: each costs a cut
    # One ring per attempt, at all holes that ask for one.
    if plan.links:
        rings.append(frozenset(plan.links))
    return Repairs(shortened, tuple(rings), (*repairs.level, *plan.level), plan.untorn)


def _plan_for(
    hole: Hole, plan: Plan, built: Built, tears: Ends, is_stuck: bool, at_any_cost: bool
) -> None:
    """Add to a plan what may close one hole."""
    repairs, state, frame = built.repairs, tears.state, tears.state.network.frame
    at = frame.to_cells(hole.place[None, :2])[0]
    tried = _rings_near(repairs, frame, at)

    # an end of a tear that is near
    end = tears.nearest(at, AT_TIP, ("tip",))
    if end is not None and tried < _rings_first(end, repairs, state, hole):
        end = None  # another ring may cover it, without any loss of throw
    over = is_overlapping(state, at)
    most = RINGS_OVER if over else RINGS
    if is_stuck and not over:
        tried = max(tried, most)
    level = [place for place in repairs.level if np.hypot(*(at - place)) <= 2 * AT_TIP]
    if end is None and tried >= (PATIENCE if over else most) and (over or at_any_cost):
        end = tears.nearest(at, 4 * AT_TIP, ("tip", "branch"))
    longer = longer_part(plan.untorn, state, at, AT_TIP)
    if longer is None and tried >= PATIENCE:
        longer = without_throw(plan.untorn, state, at)

    # the cheapest remedy that is left: more of a part that is left out already, an earlier end,
    # a ring, and at any cost a level ring, at last a part of the trace
    if longer is not None:
        plan.untorn = longer
    elif end is not None and repairs.shortened.get(end, 0) < MOST_LINKS:
        plan.ends.add(end)
    elif tried < most or (at_any_cost and len(level) < LEVELLED):
        leaks = _leaks_near(at, built, frame)
        plan.links |= leaks
        if not leaks or tried > 1:
            # no outer edge leaks here, or rings did not help: one at all ghosts behind the hole
            nodes = built.torn.node_of(hole.ghosts).tolist()
            plan.links.update(zip(nodes, nodes, strict=True))
        if tried >= most:
            plan.level.append((float(at[0]), float(at[1])))
    elif at_any_cost:
        plan.untorn = with_part_at(plan.untorn, state, at)


def _rings_first(end: End, repairs: Repairs, state: Heights, hole: Hole) -> int:
    """How many rings are tried at a hole before a tear ends earlier, at an end."""
    if end in reverse_ends(state):
        return PATIENCE
    if hole.length < SHORTEST * state.network.frame.cell:
        return 0
    # a hole that moves with the end of a tear would take a ring at each link
    return AT_END if repairs.shortened.get(end, -1) < 1 else 0


def _leaks_near(at: np.ndarray, built: Built, frame: Frame) -> set[Pair]:
    """Pairs of nodes at outer edges that leak near a hole [cells]."""
    if not built.cut.leaks:
        return set()
    # Pairs of nodes, since vertices are numbered anew in each attempt.
    nodes = np.array([leak[:2] for leak in built.cut.leaks]).ravel()
    pairs = built.torn.node_of(nodes).reshape(-1, 2)
    places = frame.cells_of_node(pairs.ravel()).reshape(-1, 2, 2).mean(axis=1)
    near = np.hypot(*(places - at).T) <= NEAR_LEAK
    return {(int(a), int(b)) for a, b in pairs[near]}


def _rings_near(repairs: Repairs, frame: Frame, at: np.ndarray) -> int:
    """How many rings were tried near a place [cells]."""
    count = 0
    # A ring near the hole counts whatever its shape.
    for ring in repairs.rings:
        nodes = np.array(sorted({node for pair in ring for node in pair}), dtype=np.int64)
        uv = frame.uv_of_node(nodes) * frame.stretch
        count += bool(len(nodes)) and bool(np.hypot(*(uv - at).T).min() <= 2 * AT_TIP)
    return count


def _middles(frame: Frame, pairs: Sequence[Pair]) -> np.ndarray:
    """The middles (n, 2) of pairs of nodes [cells]."""
    nodes = np.array(pairs, dtype=np.int64).ravel()
    return frame.uv_of_node(nodes).reshape(-1, 2, 2).mean(axis=1) * frame.stretch


# ---- rings ----------------------------------------
# Further rings of ghosts: where the horizon overlaps its own trace, and at edges that leak.


RING = 0.3  # cells that a further ring of triangles reaches at least
LEVEL_REACH = 4.0  # cells from a place within which ghosts are level with their anchors
SPARE = 0.25  # cells of overlap that the first ring covers for certain; further rings go past by it


def grown_over(torn: Torn, triangles: Triangles, state: Heights) -> Torn:
    """Further rings where a reverse fault makes the horizon overlap its own trace."""
    # The widest overlap decides whether any ring is needed at all.
    widest = max((-np.minimum(w.left, w.right).min(initial=0.0) for w in state.walls), default=0.0)
    if widest <= SPARE:
        return torn

    # each ring goes on by RING at least: so many are enough, and rings stop once one adds nothing
    for _ in range(int(np.ceil((widest + SPARE) / RING))):
        needy = np.flatnonzero(_short_of_overlap(torn, state))
        longer = _grown_from(torn, triangles, torn.n_node + needy) if len(needy) else torn
        # none is short, or those that are end at the rim of the lattice
        if len(longer.corners) == len(torn.corners):
            break
        torn = longer
    return torn


def grown_at(torn: Torn, triangles: Triangles, places: Iterable[tuple[int, int]]) -> Torn:
    """Another ring where outer edges lie over given pairs of nodes, or next to them."""
    # vertices over a given node are touched
    near = np.zeros(torn.n_node, dtype=bool)
    near[list({node for pair in places for node in pair})] = True
    touched = near[torn.node_of(torn.corners.ravel())].reshape(-1, 3)
    # one end over a given node is enough: the ring goes on a link to each side of the leak
    return grow(torn, triangles, touched | np.roll(touched, -1, axis=1))


def levelled(
    torn: Torn,
    ghosts: np.ndarray,
    heights: np.ndarray,
    places: Collection[tuple[float, float]],
    frame: Frame,
) -> np.ndarray:
    """Heights of ghosts (n_ghost,): near some places [cells] those of their anchors.

    A sheet that is extrapolated along the dip of its fault may never meet it; a level one does.
    """
    if not places:
        return ghosts
    # Places are given in cells of the lattice.
    at = frame.cells_of_node(torn.node_of_ghost)
    near = np.zeros(len(at), dtype=bool)
    for place in places:
        near |= np.hypot(*(at - place).T) <= LEVEL_REACH
    level = np.where(near, heights[torn.anchor], ghosts)
    # Level sheets may coincide with others: they are kept apart as everywhere.
    return kept_apart(torn, heights, level, frame.cell)


def _short_of_overlap(torn: Torn, state: Heights) -> np.ndarray:
    """Ghosts that do not lie past their sheet's cut-off yet, bool (n_ghost,)."""
    short = np.zeros(len(torn.anchor), dtype=bool)
    for near, walls in zip(state.near, state.walls, strict=True):
        # side of the anchor is the wall of the ghost; distance of the ghost itself [cells]
        of, at = near.look_up(torn.anchor), near.look_up(torn.node_of_ghost)
        rows = np.flatnonzero((of >= 0) & (at >= 0))
        own, at = near.side[of[rows]], at[rows]
        beyond = near.side[at] != own  # around a tip rings may come back over their own wall
        overlap = -walls.gap(near.place[at], own)
        far = near.distance[at]
        short[rows] |= beyond & (overlap > SPARE) & (far < overlap + SPARE)
    return short


def _grown_from(torn: Torn, triangles: Triangles, ghosts: np.ndarray) -> Torn:
    """Another ring along the outer edges that have one of these ghosts."""
    # Inner edges among them are dropped by `grow`, which looks at outer edges only.
    mine = is_among(torn.corners.ravel(), ghosts).reshape(-1, 3)
    return grow(torn, triangles, mine | np.roll(mine, -1, axis=1))


ROUNDS = 24  # attempts to close a sheet before an error names where it stays open
MANY = 20  # holes
HOPELESS = 8  # attempts in a row that leave as many
# attempts after which a hole of the same size at the same place is stuck, and a large one: rings
# may close a small one late, but a large one is seldom a matter of rings
STUCK, STUCK_LARGE = 3, 2
LARGE = 2.0  # cells

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
    n_cut: int
    walls: dict[str, np.ndarray] | None

    @property
    def is_open(self) -> bool:
        """Whether the sheet ends anywhere but on its faults."""
        return bool(self.cut.leaks or self.cut.dead_ends)

    @property
    def is_hopeless(self) -> bool:
        """Whether there are so many holes that the data contradict the faults."""
        return len(self.cut.holes) > MANY


def build(
    attempts: Attempts,
    state: Heights,
    solve_again: SolveAgain,
    at_any_cost: bool = False,
    start: Repairs = NO_REPAIRS,
    needs_more: NeedsMore | None = None,
    is_solved: bool = False,
    most: int | None = None,
) -> Built:
    """Tear the mesh of one horizon, and repair it until its faults close it.

    Parameters
    ----------
    attempts : Attempts
        New ones.
    state : Heights
        Of the nodes, with walls.
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
    most : int, optional
        Attempts at most, fewer than usual.

    Returns
    -------
    Built
        The first that is closed, or the last attempt.
    """
    # Attempts: solve where ends have changed, tear, cut, then plan repairs from the holes.
    repairs = start
    solved_for: tuple[dict[End, int], tuple[Part, ...]] = ({}, ())
    if is_solved:
        solved_for = start.shortened, start.untorn
    fewest, since = attempts.frame.shape[0] * attempts.frame.shape[1], 0
    before: list[Sequence[Hole]] = []
    for n_before in range(ROUNDS if most is None else min(most, ROUNDS)):
        # heights change with the ends of tears only: rings and level ghosts need no new solve
        if (repairs.shortened, repairs.untorn) != solved_for:
            solved_for = repairs.shortened, repairs.untorn
            state = die_at_tips(state, repairs, attempts.triangles.rising, solve_again)
        built = attempts.cut(state, repairs, n_before + 1)
        if not built.is_open:
            break

        # many holes that do not become fewer: the data contradict the faults
        n_hole = len(built.cut.holes)
        fewest, since = (n_hole, 0) if n_hole < fewest else (fewest, since + 1)
        if built.is_hopeless and since > HOPELESS:
            break
        before.append(built.cut.holes)
        stuck = _stuck(before, attempts.frame.cell)
        # A fault that is too short cannot be repaired in the mesh: the caller extends it.
        if needs_more is not None and needs_more(stuck):
            break
        more = repaired(built, stuck, at_any_cost)
        # No repair is left: the last attempt is handed back, open.
        if more is None:
            break
        repairs = more
    return built


def _stuck(holes: Sequence[Sequence[Hole]], cell: float) -> list[Hole]:
    """The last holes that were the same some attempts ago; `holes` has those of each attempt."""

    def is_stuck(hole: Hole) -> bool:
        """Whether a hole has not changed for long enough."""
        ago = STUCK_LARGE if hole.length > LARGE * cell else STUCK
        return len(holes) > ago and any(hole.is_like(old, cell) for old in holes[-1 - ago])

    return [hole for hole in holes[-1] if is_stuck(hole)]


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


CLEARLY = 0.3  # cells from a fault at which a node's side is clear


class Attempts:
    """Attempts to close one sheet: what stays the same in all.

    Parameters
    ----------
    picks, state, faults
        The horizon, heights of its nodes with walls, and its faults.
    rising : bool
        Whether the diagonals of the lattice rise to the north-east.
    carry_on : callable
        Gives the heights of ghosts: see `carry_on_by`.
    with_data : callable, optional
        Gives heights that meet noisy data, once those of ghosts are known.
    walls : dict, optional
        See `Built`.

    Attributes
    ----------
    reach : int
        Cells from a trace within which the mesh is cut, and sides are looked at.
    meshes : list of (FaultMesh, Blocks)
        The faults in the frame of the lattice, and blocks to search them by.
    """

    def __init__(
        self,
        picks: Picks,
        state: Heights,
        faults: Sequence[TriSurface],
        rising: bool,
        carry_on: CarryOn,
        with_data: Callable[[Heights], Heights] | None = None,
        walls: dict[str, np.ndarray] | None = None,
    ) -> None:
        self.frame, self.faults, self.carry_on, self.walls = picks.frame, faults, carry_on, walls
        self.with_data = with_data
        self.triangles = Triangles(picks.frame.shape, rising, np.isfinite(state.values))

        # cut-offs lie as far from their trace as the widest gap or overlap: the band holds them all
        widest = [np.abs([w.left, w.right]).max(initial=0.0) for w in state.walls]
        self.reach = int(np.ceil(max(widest, default=0.0))) + 3
        meshes = [mesh_in_frame(fault, picks.frame) for fault in faults]
        self.meshes = [(mesh, mesh_blocks(mesh, float(self.reach))) for mesh in meshes]

    def cut(self, state: Heights, repairs: Repairs, n_cut: int) -> Built:
        """Cut the mesh with some repairs exactly."""
        triangles, frame, every = self.triangles, self.frame, state.network.cuts
        limits = torn_limits(state, repairs.shortened, triangles.rising)

        # links between the ends of the tears, without the parts of traces that are left out
        torn_rows = within(every, *limits) & is_torn(every, repairs.untorn, state.network.traces)
        cuts = every.take(np.flatnonzero(torn_rows))

        # the mesh, with rings of ghosts where they are needed
        torn = grown_over(tear(cuts, triangles), triangles, state)
        for ring in repairs.rings:
            torn = grown_at(torn, triangles, ring)
        # Traces whose tears end before their faults: their ghosts do not bend at the tip.
        early = {trace for (trace, _), n_link in repairs.shortened.items() if n_link > 0}
        ghosts = self.carry_on(torn, triangles, cuts.bits(torn.n_node), state, early)
        # ghosts go on from smooth heights: from data themselves they would take up their noise
        state = state if self.with_data is None else self.with_data(state)
        ghosts = levelled(torn, ghosts, state.values, repairs.level, frame)
        band = band_of(torn, triangles, frame, state.values, ghosts, self.reach, self.walls)
        own = partial(self.is_own, state=state)
        found = cut_band(band, torn, triangles, self.faults, frame, own)
        return Built(
            state, triangles, torn, ghosts, found, cuts, band.outer, repairs, n_cut, self.walls
        )

    def is_own(self, nodes: np.ndarray, state: Heights) -> np.ndarray:
        """Whether nodes are clearly on their own side of all faults, at their solved heights."""
        points = np.column_stack([self.frame.cells_of_node(nodes), state.values[nodes]])
        out = np.ones(len(nodes), dtype=bool)
        # Sides at the solved height: a fault that dips is elsewhere at another elevation.
        network = state.network
        sides = {
            k: side_at_own_height(*self.meshes[k], points, float(self.reach))
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
