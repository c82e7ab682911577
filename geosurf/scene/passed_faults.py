"""Faults that go on beyond the fault that they end at, because a tear made one of them longer.

Rules cut faults before horizons are torn. What a tear adds to them is cut by no rule.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np

from geosurf.conventions import area_text
from geosurf.errors import GeosurfWarning
from geosurf.faults.rules import Rule
from geosurf.faults.sides import adjacency
from geosurf.faults.truncate import main_side
from geosurf.model import TriSurface
from geosurf.rebuild import rebuild_surfaces
from geosurf.sheets.report.lengthening import how_to_lengthen, longer_by

Faults = Mapping[str, TriSurface]


def warnings_of_passed_faults(
    rules: Iterable[Rule], given: Faults, faults: Faults
) -> list[GeosurfWarning]:
    """
    Return a warning for each fault that passes the fault that it ends at by a rule.

    Parameters
    ----------
    rules : iterable of Rule
        Faults that end at faults.
    given, faults : mapping of str to TriSurface
        All faults as rules left them, and as tears made them longer.
    """
    found = []
    for rule in rules:
        both = [name for name in (rule.fault, rule.main) if faults[name] is not given[name]]
        area = _area_beyond(rule, faults) if both else 0.0
        if area == 0.0:
            continue
        ways = [how_to_lengthen(name, longer_by(given[name], faults[name])) for name in both]
        found.append(
            GeosurfWarning(
                "fault passes another",
                rule.fault,
                f"Fault {rule.fault!r} ends at {rule.main!r} by its rule, but a horizon that is "
                f"torn there needed longer faults. What was added is not cut: {area_text(area)} "
                f"of {rule.fault!r} lie beyond {rule.main!r} in the model.",
                "Lengthen them yourself, so that the rule cuts what you add: "
                f"{', and '.join(ways)}.",
            )
        )
    return found


def _area_beyond(rule: Rule, faults: Faults) -> float:
    """Area of a fault on the side of its main fault that its rule drops [m2]."""
    fault, main = faults[rule.fault], faults[rule.main]
    patches = rebuild_surfaces([fault, main])
    mine, other = (np.flatnonzero(patches.surface_of_triangle == k) for k in range(2))
    beside = adjacency(patches, mine, other, strict=False)
    kept, dropped = beside.beside.T if main_side(main, rule.keep) > 0 else beside.beside.T[::-1]
    corners = patches.local[patches.triangles[mine[(dropped & ~kept)[beside.piece]]]]
    edges = corners[:, 1:] - corners[:, :1]
    return 0.5 * math.fsum(np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1))


__all__ = ["warnings_of_passed_faults"]
