"""Contacts, near misses and dangling ends of faults, each with a proposal and its reason.

What meets what, along which curve, and which parts a curve cuts off are exact. Sizes, distances
and angles are floats, and so are the rules of thumb below: proposals are for people to judge.
"""

from __future__ import annotations

import hashlib
import math
from collections import OrderedDict
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product
from typing import Any

import numpy as np

from geosurf.conventions import area_text, is_number
from geosurf.errors import InputError, SurfaceError
from geosurf.faults.dangling import Fault, NotOpen, dangling_ends, edge_keys
from geosurf.faults.distance import Approach, nearest_of
from geosurf.faults.extend import extend_to
from geosurf.faults.rim import (
    Rim,
    clip_steps,
    directions,
    find_rim,
    find_rims,
    guides_of,
    normals_of,
    segments_meet_box,
)
from geosurf.faults.sides import Adjacency, adjacency
from geosurf.faults.truncate import main_side
from geosurf.model import Patches, TriSurface
from geosurf.model.expected import box_of_sides, expect
from geosurf.model.network import SIDES, ExtendedFault, FaultNetwork, NetworkRow

# ---- bridge ----------------------------------------
# A fault that stops short of its main fault -> a fault that reaches beyond it.


def bridge_to(
    fault: TriSurface, main: TriSurface, keep: str, split: Callable[[Sequence[TriSurface]], Patches]
) -> ExtendedFault:
    """Continue a fault beyond another one, from the side that faces it.

    Parameters
    ----------
    fault, main : TriSurface
    keep : str
        The part of `fault` that is to stay, see `truncate_faults`.
    split : callable
        Surfaces -> their patches, as `rebuild_surfaces`.

    Returns
    -------
    ExtendedFault
        Only one side is longer: the one of which the whole line comes nearest to the main fault. It
        is as long as is needed to pass the main fault, up to a factor of two, or leaves the
        bounds of the main fault where that never happens. Nothing is added to a
        fault that passes the main one with a whole side already.

    Raises
    ------
    GeometryError
        If no line of that side leads past the main fault, or it would cross itself.

    Examples
    --------
    >>> from geosurf import rebuild_surfaces
    >>> main = TriSurface("F1", "fault", [[5, -9, -9], [5, 9, -9], [5, 0, 9]], [[0, 1, 2]])
    >>> corners = [[0, 0, 0], [0, 0, 2], [3, 0, 2], [3, 0, 0]]
    >>> short = TriSurface("F2", "fault", corners, [[0, 1, 2], [0, 2, 3]])
    >>> (made,) = bridge_to(short, main, "left", rebuild_surfaces).extensions
    >>> made.side, round(made.distance, 2)
    ('start', 2.08)
    """
    if lies_beyond(split([fault, main]), fault.name, main.name, keep):
        return ExtendedFault(fault, fault.n_triangle, ())

    # distances are floats: they only choose the side to extend, and `lies_beyond` decides exactly
    rim = find_rim(fault)
    corners = main.vertices[main.triangles]
    gaps = {side: side_gaps(fault.vertices[rim.arcs[side]], corners) for side in SIDES}
    side = min(SIDES, key=lambda side: (gaps[side][0], SIDES.index(side)))

    # start with twice the largest gap; an oblique or curved approach needs more, so the length
    # doubles until the fault has passed
    length = 2.0 * gaps[side][1]
    while True:
        made = extend_to(fault, main, side, length)

        # a continuation shorter than asked has left the bounds of the main fault: more would not
        # meet it
        beyond_bounds = made.extensions[0].distance < length
        if beyond_bounds or lies_beyond(split([made.surface, main]), fault.name, main.name, keep):
            return made
        length *= 2.0


def lies_beyond(patches: Patches, fault: str, main: str, keep: str) -> bool:
    """Whether a fault lies beyond its main one with a whole side: nothing is left to bridge.

    Parameters
    ----------
    patches : Patches
        Of both.
    fault, main, keep : str
        As in a rule.
    """
    rows = [
        np.flatnonzero(patches.surface_of_triangle == patches.names.index(n)) for n in (fault, main)
    ]

    # (n_piece, 2) bool: whether each piece of the fault touches the front and the back of the main
    # one
    beside = adjacency(patches, *rows)
    side = main_side(patches.sources[patches.names.index(main)], keep)
    unwanted = beside.beside[:, 1 if side > 0 else 0]

    # a piece on both sides is not cut through yet; no unwanted piece means that nothing crossed
    if (beside.beside.all(axis=1)).any() or not unwanted.any():
        return False

    # past it is the fault of which a whole side is cut off: none of the arc's vertices is on a part
    # that stays. Splitting keeps input vertices bit for bit, so coordinates identify them
    gone = unwanted[beside.piece]
    t = patches.triangles[rows[0]]
    source = patches.sources[patches.names.index(fault)]
    rim = find_rim(source)
    stays = {tuple(p) for p in patches.vertices[np.unique(t[~gone])].tolist()}
    return any(
        len(arc) > 1 and not stays.intersection(map(tuple, source.vertices[arc].tolist()))
        for arc in rim.arcs.values()
    )


def side_gaps(line: np.ndarray, corners: np.ndarray) -> tuple[float, float]:
    """Mean and largest distance of the points of a line (n, 3) to triangles (m, 3, 3)."""
    if len(line) < 2:
        return np.inf, np.inf
    far = np.array([nearest_of(point[None, None].repeat(2, 1), corners).distance for point in line])

    # trapezoidal weights: half of each step beside a point, so that dense picks do not count more
    step = np.linalg.norm(np.diff(line, axis=0), axis=1)
    weight = np.r_[step, 0.0] + np.r_[0.0, step]
    return float(np.average(far, weights=weight)), float(far.max())


STUB = 0.2  # a part of a fault beyond another one up to this share of its area is cut off


def propose_network(
    patches: Patches, box: Sequence[float] | None = None, *, reach: float | None = None
) -> FaultNetwork:
    """List how faults meet, miss each other and end, with a proposal for each.

    Parameters
    ----------
    patches : Patches
        Of all faults, from one `rebuild_surfaces`.
    box : (west, east, south, north, bottom, top), optional
        The model box [m]: near misses and truncations outside are not proposed. Without it
        there are no dangling ends.
    reach : float, optional
        Largest distance [m] of a near miss. Default: a fifth of the square root of
        the area of the smaller fault of each pair.

    Returns
    -------
    FaultNetwork
        Contacts come first, by length; then near misses and dangling ends, by distance, which
        are right to 1e-6 m for faults of up to 1000 km.

    Raises
    ------
    InputError
        If `reach` is not a length.

    Notes
    -----
    Of two faults that cross, the one of which less sticks out is to be truncated, if that is
    at most a fifth of its area; otherwise they cross (X). An end that stops short of a fault
    which lies ahead of it (within 60 degrees) is to be extended and truncated. An end inside the
    model box is to be extended where a quarter of the fault's own length is missing along strike,
    or its own width along dip; otherwise it is left to die out. What these truncations drop, and
    what lies on another fault, is not an end. Ends of a fault that is closed, or touches itself,
    are unknown: one row states the place.

    Examples
    --------
    >>> from geosurf import TriSurface, rebuild_surfaces
    >>> main = [[0, 0, 0], [0, 80, 0], [80, 80, -80], [80, 0, -80]]
    >>> other = [[10, 40, -60], [80, 40, -60], [80, 40, -20], [10, 40, -20]]
    >>> faults = [
    ...     TriSurface("F1", "fault", main, [[0, 2, 1], [0, 3, 2]]),
    ...     TriSurface("F2", "fault", other, [[0, 1, 2], [0, 2, 3]]),
    ... ]
    >>> (row,) = propose_network(rebuild_surfaces(faults)).rows
    >>> row.kind, row.fault, row.other, row.proposal
    ('contact', 'F2', 'F1', 'cross')
    """
    how = "rebuild_surfaces of the faults makes them"
    expect(patches, Patches, "propose_network takes Patches", how)
    check_reach(reach)
    faults = [_fault(patches, i) for i, s in enumerate(patches.sources) if s.role == "fault"]
    faults.sort(key=lambda f: f.name)
    limits = None if box is None else box_of_sides(box)

    # every pair: either it meets along a curve, or an end may stop short of it
    contacts, misses = [], []
    met: dict[tuple[str, str], list[_Cut]] = {}
    meeting = _meeting_pairs(patches, faults)
    for first, second in combinations(faults, 2):
        if (first.name, second.name) in meeting:
            cuts = [_cut(patches, first, second), _cut(patches, second, first)]
            contacts.append(_contact(patches, cuts, limits))
            met[first.name, second.name] = cuts
            continue
        limit = REACH * math.sqrt(min(first.area, second.area)) if reach is None else reach
        row = near_miss(first, second, limit, limits)
        if row is not None:
            misses.append(row)

    # the longest contact is judged first, so that it wins where truncations form a circle
    contacts.sort(key=lambda row: (-row.length, row.fault, row.other))
    misses.sort(key=_by_distance)
    rows = _without_circles([*contacts, *misses])

    # ends are those of what these truncations leave
    ends = []
    if limits is not None:
        not_open = _find_not_open(patches, faults, rows, met)
        near = {(row.fault, row.side) for row in misses if row.proposal != "leave"}
        ends = dangling_ends(patches, faults, not_open, near, limits)
    surfaces = tuple(s for s in patches.sources if s.role == "fault")
    every = (*rows, *sorted(ends, key=_by_distance))
    return FaultNetwork(every, reach, faults=surfaces)


def _meeting_pairs(patches: Patches, faults: list[Fault]) -> set[tuple[str, str]]:
    """Names of the faults that have an edge in common, in the order of the faults."""
    keys = [np.unique(edge_keys(patches, fault.rows)) for fault in faults]
    key, owner = np.concatenate(keys), np.repeat(np.arange(len(keys)), [len(own) for own in keys])

    # a stable sort: faults of one edge stay in their order; several may share it
    order = np.argsort(key, kind="stable")
    key, owner = key[order], owner[order]
    pairs = set()
    step = 1
    while True:
        same = key[step:] == key[:-step]
        if not same.any():
            break
        pairs |= {*zip(owner[:-step][same].tolist(), owner[step:][same].tolist(), strict=True)}
        step += 1
    return {(faults[a].name, faults[b].name) for a, b in pairs}


def check_reach(reach: Any) -> None:
    """Refuse a largest distance of near misses that is not a length."""
    if reach is not None and not (is_number(reach) and reach > 0):
        raise InputError(f"reach is {reach!r}; give a length in metres above 0.")


def _by_distance(row: NetworkRow) -> tuple[float, str, str, str]:
    return row.distance, row.fault, row.other, row.side


def _find_not_open(
    patches: Patches,
    faults: list[Fault],
    rows: list[NetworkRow],
    met: dict[tuple[str, str], list[_Cut]],
) -> dict[str, NotOpen]:
    """For each fault what the proposals drop of it, and where it lies on another fault."""
    n_vertex = len(patches.local)
    drops = {(row.fault, row.other) for row in rows if row.proposal == "truncate"}
    not_open = {
        fault.name: NotOpen(np.zeros(len(fault.rows), dtype=bool), np.empty(0, np.int64))
        for fault in faults
    }
    for cut in (cut for cuts in met.values() for cut in cuts):
        parts = not_open[cut.fault.name]
        low, high = cut.beside.edges.T
        parts.edges = np.union1d(parts.edges, low * n_vertex + high)
        if (cut.fault.name, cut.main.name) in drops:
            beyond = cut.beside.beside[:, 1 if cut.front else 0] | cut.beside.within
            parts.triangles |= beyond[cut.beside.piece]
    return not_open


def _without_circles(rows: list[NetworkRow]) -> list[NetworkRow]:
    """Rows in which truncations that would close a circle with those above them are left."""
    mains: dict[str, set[str]] = {}

    def leads(start: str, goal: str) -> bool:
        """Whether truncations lead from one fault to another."""
        return start == goal or any(leads(main, goal) for main in mains.get(start, ()))

    out = []
    for row in rows:
        if "truncate" in row.proposal:
            if leads(row.other, row.fault):
                reason = f"{row.other} ends, by rows above, at {row.fault}; {row.reason}"
                row = replace(row, proposal="leave", keep="", reason=reason)
            else:
                mains.setdefault(row.fault, set()).add(row.other)
        out.append(row)
    return out


def _fault(patches: Patches, i: int) -> Fault:
    surface = patches.sources[i]
    rows = np.flatnonzero(patches.surface_of_triangle == i)
    areas = 0.5 * np.linalg.norm(normals_of(surface.vertices[surface.triangles]), axis=1)
    rims, unknown = [], ""
    try:
        rims = find_rims(surface)
    except SurfaceError as error:  # closed, or sheets that touch: it has contacts, but no ends
        unknown = str(error)
    return Fault(surface, rows, rims, math.fsum(areas), unknown)


# ---------------------------------------------------------------------- contacts
@dataclass
class _Cut:
    """What one fault does to another one where they meet."""

    fault: Fault
    main: Fault
    beside: Adjacency
    through: bool
    parts: tuple[float, float]

    @property
    def share(self) -> float:
        """Share of the area on the smaller side; 0 for a fault that ends there."""
        return min(self.parts) / sum(self.parts) if self.through else math.inf

    @property
    def front(self) -> bool:
        """Whether the larger part is on the front of the main fault."""
        return self.parts[0] >= self.parts[1]


def _cut(patches: Patches, fault: Fault, main: Fault) -> _Cut:
    beside = adjacency(patches, fault.rows, main.rows, strict=False)
    areas = 0.5 * np.linalg.norm(normals_of(patches.local[patches.triangles[fault.rows]]), axis=1)
    per_piece = np.bincount(beside.piece, areas, minlength=len(beside.within))
    front, back = beside.beside.T
    through = bool((front | back).any() and not (front & back).any())
    parts = float(per_piece[front].sum()), float(per_piece[back].sum())
    return _Cut(fault, main, beside, through, parts)


def _contact(patches: Patches, cuts: list[_Cut], box: np.ndarray | None) -> NetworkRow:
    """The row of two faults that meet along a curve."""
    ends = patches.vertices[cuts[0].beside.edges]
    steps = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    middle = ends.mean(axis=1)
    weight = middle.T @ steps / steps.sum()
    at = middle[np.argmin(np.linalg.norm(middle - weight, axis=1))]
    cut = min(cuts, key=lambda c: (c.share, c.fault.area, c.fault.name))
    proposal, reason = _judge(cut, cuts)
    if proposal == "truncate" and box is not None and not _meets_box(ends, box):
        proposal, reason = "leave", f"they meet outside the model box only; {reason}"
    angle = _angle(patches, cuts)
    keep = side_word(cut.main, cut.front) if proposal == "truncate" else ""
    return NetworkRow(
        "contact", cut.fault.name, cut.main.name, "", float(steps.sum()), 0.0,
        tuple(at.tolist()), proposal, keep, f"{reason}; {angle:.0f} degrees apart",
    )  # fmt: skip


def _meets_box(segments: np.ndarray, box: np.ndarray) -> bool:
    """Whether some of the segments (n, 2, 3) lie in the model box, in part at least."""
    low, high = box[::2], box[1::2]
    near = (segments.min(axis=1) <= high).all(axis=1) & (segments.max(axis=1) >= low).all(axis=1)
    return any(segments_meet_box(line, low, high).any() for line in segments[near])


def _judge(cut: _Cut, cuts: list[_Cut]) -> tuple[str, str]:
    """What to do with two faults that meet, and why."""
    fault, main = cut.fault.name, cut.main.name
    if not cut.through:
        return "leave", f"{fault} and {main} each end inside the other; extend one of them first"
    if cut.share == 0.0:
        return "leave", f"{fault} ends at {main} already"
    words = f"{100 * cut.share:.1f} % of {fault} ({area_text(min(cut.parts))}) are beyond {main}"
    if cut.share <= STUB:
        return "truncate", words
    other = next(c for c in cuts if c is not cut)
    if other.through:
        return "cross", f"{words}, and {100 * other.share:.1f} % of {main} beyond {fault}"
    return "cross", f"{words}, and {fault} ends inside {main}"


def _angle(patches: Patches, cuts: list[_Cut]) -> float:
    """Mean angle between two faults along their curve, 0 to 90 degrees."""
    sides = []
    for cut in cuts:
        _, first = np.unique(cut.beside.edge_of_half, return_index=True)
        t = patches.triangles[cut.fault.rows[cut.beside.half_edges[first] // 3]]
        normals = normals_of(patches.local[t])
        sides.append(normals / np.linalg.norm(normals, axis=1, keepdims=True))
    ends = patches.local[cuts[0].beside.edges]
    weight = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    cosine = np.minimum(np.abs((sides[0] * sides[1]).sum(axis=1)), 1.0)
    return math.degrees(float(np.average(np.arccos(cosine), weights=weight)))


REACH = 0.2  # default reach of near misses, of the square root of the area of the smaller fault
AHEAD = 0.5  # cosine of the angle within which an end must point at the fault that it misses
# rows of pairs by what they follow from: a network is proposed again after each change of a few
# faults, and most pairs stay as they were
_KNOWN: OrderedDict[Hashable, NetworkRow | None] = OrderedDict()
_MOST_KNOWN = 20_000


def near_miss(
    first: Fault, second: Fault, limit: float, box: np.ndarray | None = None
) -> NetworkRow | None:
    """The row of two faults that do not meet, if an end of one points at the other in the box."""
    key = (_content(first), _content(second), limit, None if box is None else box.tobytes())
    if key in _KNOWN:
        return _KNOWN[key]
    row = _KNOWN[key] = _near_miss(first, second, limit, box)
    while len(_KNOWN) > _MOST_KNOWN:
        _KNOWN.popitem(last=False)
    return row


def _content(fault: Fault) -> tuple[Hashable, ...]:
    """All of a fault that the row of a pair depends on."""
    surface, guides, hasher = fault.surface, guides_of(fault.surface), hashlib.sha256()
    for array in (surface.vertices, surface.triangles, guides.dip, guides.strike):
        hasher.update(array.tobytes())
    return fault.name, surface.n_vertex, guides.exact, hasher.digest()


def _near_miss(
    first: Fault, second: Fault, limit: float, box: np.ndarray | None
) -> NetworkRow | None:
    """The same, from both surfaces."""
    candidates = []

    # either may be the one that stops short; the nearer end wins, then the smaller fault, then the
    # name, so the order of faults does not matter
    for fault, main in ((first, second), (second, first)):
        a, b = np.reshape(fault.surface.bounds, (3, 2)), np.reshape(main.surface.bounds, (3, 2))

        # distance of the bounds, a lower bound of the gap: most pairs end here
        (low, high), (least, most) = a.T, b.T
        apart = np.maximum(np.maximum(low - most, least - high), 0.0)
        if np.linalg.norm(apart) > limit:
            continue
        facing = []
        for rim, side in product(fault.rims, SIDES):
            gap = _facing_gap(fault, main, rim, side, limit, box)
            if gap is not None:
                facing.append((rim, side, gap))
        if facing:
            side, gap = _bridge_start(fault, main, facing)
            candidates.append((gap.distance, fault.area, fault.name, side, fault, main, gap))
    if not candidates:
        return None
    distance, _, _, side, fault, main, gap = min(candidates, key=lambda entry: entry[:4])

    # `keep` is the part on this side of the main fault: the one the fault comes from
    front, angle = _lies_in_front(fault, main, gap)
    reason = f"{distance:.1f} m short of {main.name}, {angle:.0f} degrees apart"
    proposal, keep = "extend then truncate", side_word(main, front)
    if len(fault.rims) > 1:  # the continuations of pieces would cross each other
        proposal, keep = "leave", ""
        reason += (
            f"; {fault.name} is in {len(fault.rims)} pieces, of which none can be extended: "
            "split_fault makes a fault of each"
        )
    return NetworkRow(
        "near miss", fault.name, main.name, side, 0.0, distance, tuple(gap.at.tolist()),
        proposal, keep, reason,
    )  # fmt: skip


def _bridge_start(
    fault: Fault, main: Fault, facing: list[tuple[Rim, str, Approach]]
) -> tuple[str, Approach]:
    """Of several sides that point at a main fault the one from which a bridge would start."""
    if len(facing) == 1:  # the mean distance of a whole side is slow
        return facing[0][1:]
    corners = main.surface.vertices[main.surface.triangles]
    gaps = [side_gaps(fault.surface.vertices[rim.arcs[s]], corners)[0] for rim, s, _ in facing]
    k = min(range(len(facing)), key=lambda k: (gaps[k], facing[k][1]))
    return facing[k][1:]


def _facing_gap(
    fault: Fault, main: Fault, rim: Rim, side: str, limit: float, box: np.ndarray | None
) -> Approach | None:
    """The closest approach of one side to another fault, if that is near and lies ahead.

    Of a side that leaves the model box only the part in it counts, and the other fault must be in
    the box there: what faults do outside does not divide the model.
    """
    x, arc = fault.surface.vertices, rim.arcs[side]
    if len(arc) < 2:
        return None
    line = x[arc]
    corners = main.surface.vertices[main.surface.triangles]
    steps = np.stack([line[:-1], line[1:]], axis=1)

    # what lies outside the model needs no bridge
    if box is not None:
        steps = _steps_in_box(steps, line, box[::2], box[1::2])
    if len(steps) == 0:
        return None
    gap = nearest_of(steps, corners, limit)
    if gap.distance > limit:
        return None
    if box is not None and ((gap.there < box[::2]) | (gap.there > box[1::2])).any():
        return None

    # an end must point at the other fault: a gap to one that runs alongside is intended
    if gap.distance > 0:
        t, guides = fault.surface.triangles, guides_of(fault.surface)
        nearest = arc[[np.linalg.norm(line - gap.at, axis=1).argmin()]]
        way = directions(x, t, nearest, side, rim.axes, guides)[0]
        if way @ (gap.there - gap.at) < AHEAD * gap.distance:
            return None
    return gap


def _steps_in_box(
    steps: np.ndarray, line: np.ndarray, low: np.ndarray, high: np.ndarray
) -> np.ndarray:
    """The parts (n, 2, 3) of the steps of a line that lie in a box; whole ones bit for bit."""
    # steps that are inside as a whole keep their vertices, so distances agree bit for bit with
    # those of no box
    enter, leave = clip_steps(line, low, high)
    meets = enter <= leave
    a, along = line[:-1][meets], np.diff(line, axis=0)[meets]
    enter, leave = enter[meets, None], leave[meets, None]
    first = np.where(enter > 0, a + enter * along, a)
    last = np.where(leave < 1, a + leave * along, steps[meets, 1])
    return np.stack([first, last], axis=1)


def _lies_in_front(fault: Fault, main: Fault, gap: Approach) -> tuple[bool, float]:
    """Whether a fault lies in front of another one it nearly meets, and their angle there."""
    corners = main.surface.vertices[main.surface.triangles]

    # the triangle of the main fault whose middle is nearest to the gap, and the same for the fault:
    # good enough for a word and an angle, which decide nothing exactly
    off = np.linalg.norm(corners.mean(axis=1) - gap.there, axis=1)
    normal = unit_vector(normals_of(corners[[off.argmin()]])[0])
    corners_of_fault = fault.surface.vertices[fault.surface.triangles]
    near = np.linalg.norm(corners_of_fault.mean(axis=1) - gap.at, axis=1).argmin()
    normal_of_fault = unit_vector(normals_of(corners_of_fault[[near]])[0])
    middle = corners_of_fault.mean(axis=(0, 1))
    angle = math.degrees(math.acos(min(1.0, abs(float(normal_of_fault @ normal)))))
    return bool((middle - gap.there) @ normal >= 0), angle


def unit_vector(vector: np.ndarray) -> np.ndarray:
    """Return a vector of length one in the same direction."""
    return vector / np.linalg.norm(vector)


def side_word(main: Fault, front: bool) -> str:
    """The word for one side of a main fault."""
    # vertical faults have no hanging wall, horizontal ones no strike: the first pair of words that
    # is defined, else the sign
    for yes, no in (("hanging wall", "footwall"), ("right", "left")):
        try:
            return yes if (main_side(main.surface, yes) > 0) == front else no
        except InputError:
            continue
    return "+" if front else "-"
