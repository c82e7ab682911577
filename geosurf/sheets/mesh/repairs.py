"""How to close a sheet that leaks: end tears earlier, or give their ghosts another ring."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

import numpy as np

from geosurf.sheets.faults.cut_edges import FALLING, RISING
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.lattice.frame import Frame
from geosurf.sheets.mesh.cut import Cut
from geosurf.sheets.mesh.torn_mesh import Torn

PATIENCE = 3  # rings that are tried before a tear is ended early where it need not be
MOST = 40  # links by which a tear may end early
AT_TIP = 2.0  # cells from the end of a tear within which a leak is a matter of that end

End = tuple[int, int]  # a trace, and 0 for its first or 1 for its last end
Pair = tuple[int, int]


@dataclass(frozen=True)
class Repairs:
    """What one attempt to close a sheet is made with.

    Attributes
    ----------
    shortened : dict of (trace, end) to int
        Links by which tears end earlier than their faults.
    rings : tuple of set of (int, int)
        For each further ring the pairs of nodes at whose edges it is.
    """

    shortened: dict[End, int] = field(default_factory=dict)
    rings: tuple[frozenset[Pair], ...] = ()


def torn_limits(
    state: Heights, shortened: dict[End, int], rising: bool
) -> tuple[np.ndarray, np.ndarray]:
    """First and last place of each trace that is torn in the mesh."""
    low, high = state.network.mesh.T.copy()
    every = state.network.cuts
    diagonal = RISING if rising else FALLING
    in_mesh = (every.kind < 2) | (every.kind == diagonal)
    for (trace, end), n in shortened.items():
        # places of the cut links of this trace in order: n of them are not cut
        place = np.sort(every.place[in_mesh & (every.trace == trace)])
        place = place[(place >= low[trace]) & (place <= high[trace])]
        if n >= len(place):
            low[trace], high[trace] = np.inf, -np.inf
        elif end == 0:
            low[trace] = place[n]
        else:
            high[trace] = place[-1 - n]
    return low, high


def repaired(
    repairs: Repairs, state: Heights, torn: Torn, cut: Cut, frame: Frame, rising: bool
) -> Repairs:
    """End tears earlier where faults end inside copies or leak at a tip; else grow a ring."""
    ends, links = _ends_and_links(repairs, state, torn, cut, frame, rising)
    shortened, rings = dict(repairs.shortened), list(repairs.rings)
    for end in ends:
        # rings that were tried at an end and did not close it go once it is ended early: around
        # a tip they come to lie over the whole sheet beyond it, where no fault cuts them
        tears = Ends(state, torn_limits(state, shortened, rising), frame)
        for k, ring in enumerate(rings):
            mine = {
                pair for pair in ring if tears.nearest(np.array(pair), 3 * AT_TIP, ("tip",)) == end
            }
            rings[k] = ring - mine
        is_tip = state.network.traces[end[0]].ends[end[1]] == "tip"
        shortened[end] = shortened.get(end, -1) + (1 if is_tip else 3)
    if links:
        rings.append(frozenset(links))
    return Repairs(shortened, tuple(rings))


def _ends_and_links(
    repairs: Repairs, state: Heights, torn: Torn, cut: Cut, frame: Frame, rising: bool
) -> tuple[set[End], set[Pair]]:
    """Ends of tears that shall be earlier, and pairs of nodes at which a ring shall be added."""
    ends: set[End] = set()
    links: set[Pair] = set()
    tears = Ends(state, torn_limits(state, repairs.shortened, rising), frame)
    reverse, rings = _reverse_ends(state), len(repairs.rings)
    leaks = _own_leaks(state, torn, cut)
    dead_ends = _far_dead_ends(torn, cut, leaks, frame)
    for is_leak, pairs, reach, kinds in (
        (True, leaks, AT_TIP, ("tip",)),
        (False, dead_ends, 4 * AT_TIP, ("tip", "branch")),
    ):
        for a, b in pairs:
            nodes = torn.node_of(np.array([a, b]))
            end = tears.nearest(nodes, reach, kinds)
            # a reverse fault overlaps right up to its tip, which another ring may cover
            if end in reverse and is_leak and rings < PATIENCE:
                end = None
            if end is None and rings >= PATIENCE:  # a branch that is too acute to tear
                end = tears.nearest(nodes, 3 * AT_TIP, ("branch",))
            if end is not None and repairs.shortened.get(end, 0) < MOST:
                ends.add(end)
            else:
                links.add((int(nodes[0]), int(nodes[1])))
    return ends, links


@dataclass(frozen=True, eq=False)
class Ends:
    """Where tears end: the places of each trace between which it is torn."""

    state: Heights
    limits: tuple[np.ndarray, np.ndarray]
    frame: Frame

    def nearest(self, nodes: np.ndarray, reach: float, kinds: tuple[str, ...]) -> End | None:
        """The end of some kind that is nearest to some nodes, if one is within reach [cells]."""
        best, found = reach, None
        network = self.state.network
        joined: Collection[End] = {(i, k) for i, k, _ in network.on}
        at = self.frame.uv_of_node(nodes).mean(axis=0) * self.frame.stretch
        for i, trace in enumerate(network.traces):
            vertex = np.arange(len(trace.line))
            for k, end in enumerate(trace.ends):
                if not end.startswith(kinds) or (i, k) in joined:
                    continue
                place = self.limits[k][i]
                tip = [np.interp(place, vertex, trace.line[:, c]) for c in (0, 1)]
                far = float(np.hypot(*(at - tip)))
                if far < best:
                    best, found = far, (i, k)
        return found


def _reverse_ends(state: Heights) -> set[End]:
    """Ends of traces near which the horizon overlaps."""
    found = set()
    for i, walls in enumerate(state.walls):
        heave = walls.left + walls.right
        for k, part in enumerate((heave[:10], heave[-10:])):
            if len(part) and np.median(part) < 0:
                found.add((i, k))
    return found


def _own_leaks(state: Heights, torn: Torn, cut: Cut) -> Sequence[Pair]:
    """Leaks through the fault that a ghost was made for, if there are any; else all.

    Once a leak joins both walls, crossings of other faults look like leaks, too.
    """
    own, every = [], []
    for a, b, faults in cut.leaks:
        every.append((a, b))
        vertex = np.array([a, b])
        node, anchor = torn.node_of(vertex), torn.anchored(vertex)
        for trace, near in zip(state.network.traces, state.near, strict=True):
            at, of = near.look_up(node), near.look_up(anchor)
            both = (at >= 0) & (of >= 0)
            if trace.fault in faults and (both & (near.side[at] != near.side[of])).any():
                own.append((a, b))
                break
    return own or every


def _far_dead_ends(torn: Torn, cut: Cut, leaks: Sequence[Pair], frame: Frame) -> Sequence[Pair]:
    """Dead ends far from all leaks: one near a leak may only be what that leak joins."""
    if not leaks or not cut.dead_ends:
        return cut.dead_ends

    # distance of each dead end to the nearest leak, rows or columns [cells]
    at = frame.uv_of_node(torn.node_of(np.array(leaks).ravel()))
    here = frame.uv_of_node(torn.node_of(np.array([a for a, _ in cut.dead_ends])))
    far = np.abs(here[:, None] - at[None]).max(axis=2).min(axis=1)
    return [pair for pair, cells in zip(cut.dead_ends, far, strict=True) if cells > 5 * AT_TIP]
