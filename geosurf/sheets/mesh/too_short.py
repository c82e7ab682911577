"""Faults that a torn sheet leaves above or below: the smallest extension that closes it.

Sticks are often picked no farther than the cut-offs that the interpreter sees. The sheet of a wall
is extrapolated past the fault, a little above or below its cut-off, and leaves the fault there.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from geosurf.errors import GeosurfError
from geosurf.faults import lengthen_fault
from geosurf.faults.rim import find_rim
from geosurf.model import TriSurface
from geosurf.sheets.mesh.holes import Hole

VERTICAL = ("up", "down")
CORNER = 1.5  # times the distance of the nearest rim, up to which an upper or lower one counts


@dataclass(frozen=True, eq=False)
class Short:
    """Sides on which a fault is too short, and the first place of a hole there [m]."""

    sides: frozenset[str]
    place: np.ndarray


def too_short(
    holes: Sequence[Hole], faults: Sequence[TriSurface], reach: float
) -> dict[int, Short]:
    """Faults, by number, whose upper or lower rim is nearest to a hole and within `reach` [m]."""
    found: dict[int, Short] = {}
    for number, fault in enumerate(faults) if holes else ():
        try:
            arcs = find_rim(fault).arcs
        except GeosurfError:  # several pieces, or a closed rim: it has no upper side
            continue
        for hole in holes:
            # distance [m] of the hole from each side of the rim: the sheet got out at the nearest
            far = {side: _distance(hole.place, fault.vertices[arc]) for side, arc in arcs.items()}
            nearest = min(far.values())
            # at a corner the end of a fault may be a little nearer than its upper or lower rim
            close = min(reach, CORNER * nearest + 0.125 * reach)
            sides = frozenset(side for side in VERTICAL if far.get(side, np.inf) <= close)
            if nearest <= reach and sides:
                before = found.get(number, Short(frozenset(), hole.place))
                found[number] = Short(before.sides | sides, before.place)
    return found


def extended(fault: TriSurface, sides: Collection[str], distance: float) -> TriSurface:
    """A fault that goes on up or down by a distance along its dip lines [m].

    Raises
    ------
    GeosurfError
        If it cannot be continued there.
    """
    return lengthen_fault(fault, dict.fromkeys(sorted(sides), distance)).surface


def _distance(place: np.ndarray, line: np.ndarray) -> float:
    """Distance of a place from a line of points (n, 3) [m]; infinite for a single point."""
    if len(line) < 2:
        return np.inf
    a, step = line[:-1], np.diff(line, axis=0)
    length = np.maximum((step**2).sum(axis=1), 1e-30)
    t = np.clip(((place - a) * step).sum(axis=1) / length, 0.0, 1.0)
    return float(np.linalg.norm(a + t[:, None] * step - place, axis=1).min())
