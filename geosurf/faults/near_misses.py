"""Ends of faults that stop short of another fault: near misses, each with a proposal."""

from __future__ import annotations

import hashlib
import math
from collections import OrderedDict
from collections.abc import Hashable
from itertools import product

import numpy as np

from geosurf.errors import InputError
from geosurf.faults.box_exits import clip_steps
from geosurf.faults.bridge import side_gaps
from geosurf.faults.dangling import Fault
from geosurf.faults.distance import Approach, nearest_of
from geosurf.faults.lines import directions, guides_of
from geosurf.faults.rim import Rim, normals_of
from geosurf.faults.truncate import main_side
from geosurf.model.faults import SIDES
from geosurf.model.network_rows import NetworkRow

REACH = 0.2  # default reach of near misses, of the square root of the area of the smaller fault
AHEAD = 0.5  # cosine of the angle within which an end must point at the fault that it misses


# rows of pairs by what they follow from: a network is proposed again after each change of a few
# faults, and most pairs stay as they were
_KNOWN: OrderedDict[Hashable, NetworkRow | None] = OrderedDict()
_MOST_KNOWN = 20_000


def near_miss(
    one: Fault, two: Fault, limit: float, box: np.ndarray | None = None
) -> NetworkRow | None:
    """The row of two faults that do not meet, if an end of one points at the other in the box."""
    key = (_content(one), _content(two), limit, None if box is None else box.tobytes())
    if key in _KNOWN:
        return _KNOWN[key]
    row = _KNOWN[key] = _near_miss(one, two, limit, box)
    while len(_KNOWN) > _MOST_KNOWN:
        _KNOWN.popitem(last=False)
    return row


def _content(fault: Fault) -> tuple[Hashable, ...]:
    """All of a fault that the row of a pair depends on."""
    surface, guides, found = fault.surface, guides_of(fault.surface), hashlib.sha256()
    for array in (surface.vertices, surface.triangles, guides.dip, guides.strike):
        found.update(array.tobytes())
    return fault.name, surface.n_vertex, guides.exact, found.digest()


def _near_miss(one: Fault, two: Fault, limit: float, box: np.ndarray | None) -> NetworkRow | None:
    """The same, from both surfaces."""
    found = []

    # either may be the one that stops short; the nearer end wins, then the smaller fault, then the
    # name, so the order of faults does not matter
    for fault, main in ((one, two), (two, one)):
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
            found.append((gap.distance, fault.area, fault.name, side, fault, main, gap))
    if not found:
        return None
    distance, _, _, side, fault, main, gap = min(found, key=lambda entry: entry[:4])

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
    own = fault.surface.vertices[fault.surface.triangles]
    near = np.linalg.norm(own.mean(axis=1) - gap.at, axis=1).argmin()
    mine = unit_vector(normals_of(own[[near]])[0])
    middle = own.mean(axis=(0, 1))
    angle = math.degrees(math.acos(min(1.0, abs(float(mine @ normal)))))
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
