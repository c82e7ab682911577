"""Faults that a torn sheet leaves at a rim: the smallest extension that closes it.

Sticks are often picked no farther than the cut-offs that the interpreter sees. The sheet of a wall
is extrapolated past the fault, a little above or below its cut-off, and leaves the fault there.
A branch may stop a cell short of its main fault: the sheet passes through between the two.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from geosurf.errors import GeosurfError
from geosurf.faults import lengthen_fault
from geosurf.faults.rim import find_rim
from geosurf.model import TriSurface
from geosurf.model.sheets import Extended, NeededFaults
from geosurf.sheets.mesh.holes import Hole

VERTICAL, LATERAL = ("up", "down"), ("start", "end")
CORNER = 1.5  # times the distance of the nearest rim, up to which an upper or lower one counts


@dataclass(frozen=True, eq=False)
class Short:
    """Sides on which a fault is too short, and the first place of a hole there [m]."""

    sides: frozenset[str]
    place: np.ndarray


class TooShort(Exception):
    """A sheet needs longer faults. Raised only for those who ask, and who go on from there."""

    def __init__(self, longer: NeededFaults) -> None:
        super().__init__(", ".join(longer.faults))
        self.longer = longer


def added_up(extensions: Sequence[Extended]) -> tuple[Extended, ...]:
    """One for each fault: those that came one after the other, with the place of the first."""
    found: dict[str, Extended] = {}
    for one in extensions:
        before = found.get(one.fault)
        if before is not None:
            sides = {*before.lengths, *one.lengths}
            sums = {k: before.lengths.get(k, 0.0) + one.lengths.get(k, 0.0) for k in sorted(sides)}
            one = Extended(one.fault, sums, before.place)
        found[one.fault] = one
    return tuple(found.values())


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
    found: dict[int, Short] = {}
    for number, fault in enumerate(faults) if holes else ():
        try:
            arcs = find_rim(fault).arcs
        except GeosurfError:  # several pieces, or a closed rim: it has no upper side
            continue
        # A hole is tall where a sheet leaves a steep fault: its ends count as well as its middle.
        places = [place for one in holes for place in (one.place, one.lowest, one.highest)]
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
                before = found.get(number, Short(frozenset(), place))
                found[number] = Short(before.sides | sides, before.place)
    return found


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
