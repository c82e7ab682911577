"""How to close the holes of a sheet: the smallest repair that may do is tried first.

The ghosts at the hole get another ring. If that does not close a hole at a tip, the tear ends a
link earlier. Where the data show no throw, the tear is left out. At any cost the nearest end of a
tear is moved, the sheet goes on level past the fault (one that is extrapolated along the dip of its
fault never meets it), or a part of the trace with the smallest throw there is left out.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

import numpy as np

from geosurf.sheets.faults.cut_edges import Part
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.lattice.frame import Frame
from geosurf.sheets.mesh.cut import Cut
from geosurf.sheets.mesh.holes import Hole
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
from geosurf.sheets.mesh.torn_mesh import Torn

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


def repaired(
    repairs: Repairs,
    state: Heights,
    torn: Torn,
    cut: Cut,
    stuck: Collection[Hole],
    rising: bool,
    at_any_cost: bool,
) -> Repairs | None:
    """Repairs for the next attempt; None if nothing is left to try.

    Holes that are stuck get no further ring. `at_any_cost` allows what changes cut-offs: a level
    sheet, ends of tears that are moved far, and parts of traces that are left out.
    """
    # All holes of one attempt are planned for together: each attempt costs a cut.
    frame, plan = state.network.frame, Plan(set(), set(), [], repairs.untorn)
    tears = Ends(state, torn_limits(state, repairs.shortened, rising))
    for hole in cut.holes:
        is_stuck = any(hole is one for one in stuck)
        _plan_for(hole, plan, repairs, tears, torn, cut, is_stuck, at_any_cost)
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
            mine = {pair for pair, one in zip(pairs, nearest, strict=True) if one == end}
            rings[k] = ring - mine

        # at a tip 0 comes first: the tear ends where it did, but throw dies at its last link
        is_tip = state.network.traces[end[0]].ends[end[1]] == "tip"
        shortened[end] = shortened.get(end, -1) + (1 if is_tip else 3)
    # One ring per attempt, at all holes that ask for one.
    if plan.links:
        rings.append(frozenset(plan.links))
    return Repairs(shortened, tuple(rings), (*repairs.level, *plan.level), plan.untorn)


def _plan_for(
    hole: Hole,
    plan: Plan,
    repairs: Repairs,
    tears: Ends,
    torn: Torn,
    cut: Cut,
    is_stuck: bool,
    at_any_cost: bool,
) -> None:
    """Add to a plan what may close one hole."""
    state, frame = tears.state, tears.state.network.frame
    at = frame.to_lattice(hole.place[None, :2])[0] * frame.stretch
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
        leaks = _leaks_near(at, cut, torn, frame)
        plan.links |= leaks
        if not leaks or tried > 1:
            # no outer edge leaks here, or rings did not help: one at all ghosts behind the hole
            nodes = torn.node_of(hole.ghosts).tolist()
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


def _leaks_near(at: np.ndarray, cut: Cut, torn: Torn, frame: Frame) -> set[Pair]:
    """Pairs of nodes at outer edges that leak near a hole [cells]."""
    if not cut.leaks:
        return set()
    # Pairs of nodes, since vertices are numbered anew in each attempt.
    pairs = torn.node_of(np.array([leak[:2] for leak in cut.leaks]).ravel()).reshape(-1, 2)
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
    middles: np.ndarray = frame.uv_of_node(nodes).reshape(-1, 2, 2).mean(axis=1) * frame.stretch
    return middles
