"""Ends of tears: at the ends of traces, and at parts of traces that are left out."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from geosurf.errors import GeosurfError
from geosurf.faults import lengthen_fault
from geosurf.faults.rim import find_rim
from geosurf.model import TriSurface
from geosurf.sheets.faults.cut_edges import FALLING, RISING, Part, Walls
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.mesh.cut import Hole

End = tuple[int, int]  # a trace, and 0 for its first or 1 for its last end

NEAR_HOLE = 5.0  # cells from a hole within which a trace may be left out
LEFT_OUT = 3.0  # cells of a trace to each side of a hole that are left out at first
LONGER = 0.25  # of its length by which a part that is left out becomes longer, or a cell
AGAIN = 8.0  # cells from a part that was left out, within which a hole asks for more of it
MOST_LEFT_OUT = 24.0  # cells: the longest part with throw that is left out
NO_THROW = 0.05  # cells of throw up to which the heights on both sides of a fault agree
USUAL = 3  # links by which a tear may end early at a tip: throw has died there anyway
LITTLE = 0.1  # of the largest throw of a trace: where it has less, it is left out as a whole


def torn_limits(
    state: Heights, shortened: dict[End, int], rising: bool
) -> tuple[np.ndarray, np.ndarray]:
    """First and last place of each trace that is torn in the mesh."""
    # Copies: limits of the network stay as they are.
    low, high = state.network.mesh.T.copy()
    every = state.network.cuts
    diagonal = RISING if rising else FALLING
    in_mesh = (every.kind < 2) | (every.kind == diagonal)
    for (trace, end), n in shortened.items():
        # places of the links that the mesh tears; the n-th from this end is the new end
        place = np.sort(every.place[in_mesh & (every.trace == trace)])
        place = place[(place >= low[trace]) & (place <= high[trace])]
        # The tear has no link left: it is empty.
        if n >= len(place):
            low[trace], high[trace] = np.inf, -np.inf
        elif end == 0:
            low[trace] = place[n]
        else:
            high[trace] = place[-1 - n]
    return low, high


def early_parts(state: Heights, shortened: dict[End, int], rising: bool) -> list[Part]:
    """Parts of traces past the ends of tears that end early by more than a few links."""
    limits, parts = torn_limits(state, shortened, rising), []
    for (number, end), n in shortened.items():
        trace = state.network.traces[number]
        if n > USUAL:
            at = np.clip([limits[end][number], state.network.mesh[number, end]], 0, len(trace.line))
            first, last = np.sort(trace.length_at(at))
            parts.append((number, float(first), float(last)))
    return parts


@dataclass(frozen=True, eq=False)
class Ends:
    """Where tears end: the places (vertex numbers) of each trace between which it is torn."""

    state: Heights
    limits: tuple[np.ndarray, np.ndarray]

    def nearest(self, at: np.ndarray, reach: float, kinds: tuple[str, ...]) -> End | None:
        """The end of some kind that is nearest to a place [cells], if one is within reach."""
        return self.nearest_of(at[None], reach, kinds)[0]

    def nearest_of(self, at: np.ndarray, reach: float, kinds: tuple[str, ...]) -> list[End | None]:
        """The same for each of some places (n, 2)."""
        ends, words, places = self._movable
        rows = [row for row, word in enumerate(words) if word.startswith(kinds)]
        if not rows:
            return [None] * len(at)
        far = np.hypot(*(at[:, None] - places[rows]).transpose(2, 0, 1))
        # the first of those that are as near as each other
        best = far.argmin(axis=1)
        near = far[np.arange(len(at)), best] < reach
        return [ends[rows[k]] if ok else None for k, ok in zip(best, near, strict=True)]

    @cached_property
    def _movable(self) -> tuple[list[End], list[str], np.ndarray]:
        """Ends that may be moved, their kinds, and their places (n, 2) [cells]."""
        network = self.state.network
        joined: Collection[End] = {(i, k) for i, k, _ in network.on}
        ends: list[End] = []
        words: list[str] = []
        places: list[np.ndarray] = []
        for i, trace in enumerate(network.traces):
            for k, end in enumerate(trace.ends):
                # a branch that was led to its main fault ends there, and is not moved
                if (i, k) in joined:
                    continue
                ends.append((i, k))
                words.append(end)
                places.append(trace.at(self.limits[k][i])[:2])
        return ends, words, np.array(places).reshape(-1, 2)


def reverse_ends(state: Heights) -> set[End]:
    """Ends of traces near which the horizon overlaps."""
    ends = set()
    for i, walls in enumerate(state.walls):
        heave = walls.left + walls.right

        # a median of ten places near the end: a single odd one does not decide
        for k, part in enumerate((heave[:10], heave[-10:])):
            if len(part) and np.median(part) < 0:
                ends.add((i, k))
    return ends


def is_overlapping(state: Heights, at: np.ndarray) -> bool:
    """Whether the horizon overlaps at the trace that is nearest to a place [cells]."""
    # The nearest trace decides, as the hole belongs to it.
    traces = state.network.traces
    nearest = min(range(len(traces)), key=lambda i: float(traces[i].far_from(at).min()))
    walls = state.walls[nearest]
    heave = walls.left + walls.right
    return bool(len(heave)) and float(np.median(heave)) < 0.0


def longer_part(
    untorn: tuple[Part, ...], state: Heights, at: np.ndarray, reach: float
) -> tuple[Part, ...] | None:
    """The parts that are left out, one of them longer at its end near a place [cells].

    None if there is no such end within reach, or the part is as long as it may be.
    """
    for part in untorn:
        number, *ends = part
        trace = state.network.traces[number]
        # A long part with throw is not made longer; one without throw costs nothing.
        if ends[1] - ends[0] > MOST_LEFT_OUT and throw_of(state, part) > NO_THROW * _cell(state):
            continue
        for k, end in enumerate(ends):
            tip = trace.at_length(end)[:2]
            # Ends of the trace itself cannot be moved further.
            inside = 0.0 < end < trace.along[-1]
            if inside and np.hypot(*(at - tip)) <= reach:
                step = max(1.0, LONGER * (ends[1] - ends[0]))
                longer = (number, end - step, ends[1]) if k == 0 else (number, ends[0], end + step)
                return tuple(longer if one is part else one for one in untorn)
    return None


def with_part_at(untorn: tuple[Part, ...], state: Heights, at: np.ndarray) -> tuple[Part, ...]:
    """Parts that are left out, with one more around a place [cells], or with a longer one.

    Of the traces near the place the one with the smallest throw there is left out.
    """
    choice: list[tuple[float, int, float]] = []
    # Every trace near the place, with its throw there.
    for number, (trace, walls) in enumerate(zip(state.network.traces, state.walls, strict=True)):
        far = trace.far_from(at)
        vertex = int(far.argmin())
        if far[vertex] <= NEAR_HOLE:
            choice.append((_throw_at(walls, vertex), number, float(trace.along[vertex])))

    # smallest throw first; a trace that gave up enough of itself gives way to the next one
    for _, number, place in sorted(choice):
        near_parts = [p for p in untorn if p[0] == number and p[1] - AGAIN <= place <= p[2] + AGAIN]
        if sum(last - first for _, first, last in near_parts) > MOST_LEFT_OUT:
            continue
        first, last = _between_throw(state, number, place, LITTLE * _largest(state, number))
        first, last = min(first, place - LEFT_OUT), max(last, place + LEFT_OUT)
        for _, one, two in near_parts:  # it was not enough
            first, last = min(first, one - LEFT_OUT), max(last, two + LEFT_OUT)
        return (*(part for part in untorn if part not in near_parts), (number, first, last))
    return untorn


def without_throw(
    untorn: tuple[Part, ...], state: Heights, at: np.ndarray
) -> tuple[Part, ...] | None:
    """The parts that are left out, and the part around a place [cells] where there is no throw.

    None if the heights on both sides of the nearest trace differ there, or it is left out already.
    """
    traces = state.network.traces
    apart = [trace.far_from(at) for trace in traces]
    number = min(range(len(traces)), key=lambda i: float(apart[i].min()))
    trace, far = traces[number], apart[number]
    place = float(trace.along[int(far.argmin())])
    if far.min() > NEAR_HOLE or any(p[0] == number and p[1] <= place <= p[2] for p in untorn):
        return None
    least = NO_THROW * _cell(state)
    first, last = _between_throw(state, number, place, least)
    # Throw close by: the fault does move the horizon here.
    if min(place - first, last - place) < LEFT_OUT and _largest(state, number) > least:
        return None
    return (*untorn, (number, first, last))


def throw_of(state: Heights, part: Part) -> float:
    """Largest throw of a part of a trace [m]."""
    number, first, last = part
    trace, walls = state.network.traces[number], state.walls[number]
    along = trace.length_at(walls.place)
    return float(np.abs(walls.throw[(along >= first) & (along <= last)]).max(initial=0.0))


def lost_throw(state: Heights, untorn: Sequence[Part]) -> float:
    """Throw that is lost where parts of traces are left out: metres times cells of trace.

    Parts at which the heights on both sides agree lose nothing.
    """
    lost = 0.0
    for part in untorn:
        # Only what lies on the trace is lost.
        length = float(np.ptp(np.clip(part[1:], 0.0, state.network.traces[part[0]].along[-1])))
        throw = throw_of(state, part)
        lost += length * throw if throw > NO_THROW * _cell(state) else 0.0
    return lost


def _cell(state: Heights) -> float:
    """Size of a cell [m]."""
    return state.network.frame.cell


def _throw_at(walls: Walls, vertex: float) -> float:
    """Size of the throw at a place of a trace [m]."""
    # A trace without walls has no throw.
    if not len(walls.place):
        return 0.0
    return float(np.interp(vertex, walls.place, np.abs(walls.throw)))


def _largest(state: Heights, number: int) -> float:
    """Size of the largest throw of a trace [m]."""
    return float(np.abs(state.walls[number].throw).max(initial=0.0))


def _between_throw(state: Heights, number: int, place: float, least: float) -> tuple[float, float]:
    """The part of a trace around a length along it [cells] whose throw is `least` at most [m]."""
    # Throw is known at places of the walls; distance along the trace compares them.
    trace, walls = state.network.traces[number], state.walls[number]
    high = trace.length_at(walls.place)[np.abs(walls.throw) > least]
    first = float(high[high < place].max(initial=trace.along[0]))
    return first, float(high[high > place].min(initial=trace.along[-1]))


# ---- too short ----------------------------------------
# Faults that a torn sheet leaves at a rim: the smallest extension that closes it.
#
# Sticks are often picked no farther than the cut-offs that the interpreter sees. The sheet of a
# wall is extrapolated past the fault, a little above or below its cut-off, and leaves the fault
# there. A branch may stop a cell short of its main fault: the sheet passes through between the
# two.


VERTICAL, LATERAL = ("up", "down"), ("start", "end")
MOST = 4.0  # of its height by which a fault is extended along its dip at most
DIPPING = 2.0  # metres along the dip for each metre of elevation: dips of 30 degrees and more
CORNER = 1.5  # times the distance of the nearest rim, up to which an upper or lower one counts


@dataclass(frozen=True, eq=False)
class Short:
    """Sides on which a fault is too short, and the first place of a hole there [m]."""

    sides: frozenset[str]
    place: np.ndarray


def too_short(
    holes: Sequence[Hole],
    faults: Sequence[TriSurface],
    reach: float,
    branches: Mapping[int, np.ndarray],
) -> dict[int, Short]:
    """Faults, by number, whose rim is nearest to a hole and within `reach` [m].

    The upper and the lower rim count, and at holes near the ends of branches the lateral one.
    `branches` has the places (n, 2) of these ends by fault.
    """
    short: dict[int, Short] = {}
    for number, fault in enumerate(faults) if holes else ():
        try:
            arcs = find_rim(fault).arcs
        except GeosurfError:  # several pieces, or a closed rim: it has no upper side
            continue
        # A hole is tall where a sheet leaves a steep fault: its ends count as well as its middle.
        places = [place for hole in holes for place in (hole.place, hole.lowest, hole.highest)]
        for place in places:
            # distance [m] from each side of the rim: the sheet got out at the nearest
            far = {side: distance_to(place, fault.vertices[arc]) for side, arc in arcs.items()}
            nearest = min(far.values())
            # at a corner the end of a fault may be a little nearer than its upper or lower rim
            close = min(reach, CORNER * nearest + 0.125 * reach)
            sides = frozenset(side for side in VERTICAL if far.get(side, np.inf) <= close)
            if not sides and _is_near(place, branches.get(number), reach):
                sides = frozenset(side for side in LATERAL if far.get(side, np.inf) == nearest)
            if nearest <= reach and sides:
                # Sides of all holes add up; the first place is the one that messages name.
                before = short.get(number, Short(frozenset(), place))
                short[number] = Short(before.sides | sides, before.place)
    # faults that are tall enough first: what is open then at the end of a branch is short along it
    tall = {k: replace(one, sides=one.sides & {*VERTICAL}) for k, one in short.items()}
    return {k: one for k, one in tall.items() if one.sides} or short


def tall(fault: TriSurface, low: float, high: float) -> TriSurface:
    """A fault that goes on along its dip lines past two elevations [m], where these can go on."""
    try:
        arcs = find_rim(fault).arcs
    except GeosurfError:  # several pieces, or a closed rim: it has no upper side
        return fault
    z, most = fault.vertices[:, 2], MOST * (fault.bounds[5] - fault.bounds[4])
    up, down = high - z[arcs["up"]].min(), z[arcs["down"]].max() - low
    for side, missing in (("up", up), ("down", down)):
        if missing > 0.0:
            with suppress(GeosurfError):  # its dip lines cross there
                fault = extended(fault, {side: min(DIPPING * float(missing), most)})
    return fault


def extended(fault: TriSurface, lengths: Mapping[str, float]) -> TriSurface:
    """A fault that goes on at some sides by a length along its dip or strike lines [m].

    Raises
    ------
    GeosurfError
        If it cannot be continued there.
    """
    return lengthen_fault(fault, {side: lengths[side] for side in sorted(lengths)}).surface


def _is_near(place: np.ndarray, ends: np.ndarray | None, reach: float) -> bool:
    """Whether one of some ends is within reach of a place in the map."""
    return ends is not None and bool((np.hypot(*(ends - place[:2]).T) <= reach).any())


def distance_to(place: np.ndarray, line: np.ndarray) -> float:
    """Distance of a place from a line of points (n, 3) [m]; infinite for a single point."""
    if len(line) < 2:
        return np.inf
    # Nearest point of each segment, clamped to its ends.
    a, step = line[:-1], np.diff(line, axis=0)
    length = np.maximum((step**2).sum(axis=1), 1e-30)
    t = np.clip(((place - a) * step).sum(axis=1) / length, 0.0, 1.0)
    return float(np.linalg.norm(a + t[:, None] * step - place, axis=1).min())
