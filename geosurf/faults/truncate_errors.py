"""Errors of truncations: a fault that goes around its main fault, or does not reach it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeometryError
from geosurf.faults.distance import closest_approach, open_edges
from geosurf.faults.rules import Rule
from geosurf.faults.sides import Adjacency
from geosurf.model import Patches


def goes_around(patches: Patches, rule: Rule, beside: Adjacency, mine: np.ndarray) -> Exception:
    """Describe where the curve ends inside the truncated fault."""
    used, times = np.unique(beside.edges, return_counts=True)
    rim = np.unique(open_edges(patches.triangles[mine], len(patches.local)))
    tips = np.setdiff1d(used[times == 1], rim)
    at = patches.vertices[tips[0] if len(tips) else used[0]]
    return GeometryError(
        f"fault {rule.main!r} does not cut {rule.fault!r} through: {rule.fault!r} goes on around "
        f"the end of {rule.main!r} at {place(at)}, so that no part can be dropped. Extend "
        f"{rule.main!r}.",
        place=at,
        surfaces=(rule.fault, rule.main),
    )


def not_reached(
    patches: Patches, rule: Rule, rows: Mapping[str, np.ndarray], inside: np.ndarray
) -> Exception:
    """Describe how far a fault stays off its main one in the model box, and where."""
    for name in (rule.fault, rule.main):
        if not inside[rows[name]].any():
            x = patches.vertices[patches.triangles[rows[name]]].reshape(-1, 3)
            (w, s, b), (e, n, t) = x.min(axis=0), x.max(axis=0)
            return GeometryError(
                f"nothing of fault {name!r} (easting {w:.6g} to {e:.6g}, northing {s:.7g} to "
                f"{n:.7g}, elevation {b:.6g} to {t:.6g}) lies in the model box, so that "
                f"{rule.fault!r} cannot end at {rule.main!r} there. Leave the rule out, enlarge "
                "the box, or check positive= and length_unit= of the fault.",
                surfaces=(rule.fault, rule.main),
            )
    one, two = (patches.triangles[r[inside[r]]] for r in (rows[rule.fault], rows[rule.main]))
    gap = closest_approach(patches.local, one, two)
    at = gap.at + patches.origin
    where = f"nearest at {place(at)}"
    if gap.distance == 0:
        return GeometryError(
            f"fault {rule.fault!r} only touches {rule.main!r}, {where}, and cannot end there. "
            "Leave the rule out, or keep another part of one of them.",
            place=at,
            surfaces=(rule.fault, rule.main),
        )
    remedy = (
        "Leave the rule out: they do not meet in the model box, even extended."
        if rule.extend
        else f"Extend it to {rule.main!r}: "
        f"truncations={{{rule.fault!r}: ({rule.main!r}, {rule.keep!r}, True)}}."
    )
    return GeometryError(
        f"fault {rule.fault!r} ends {gap.distance:.6g} m short of {rule.main!r}, {where}, and "
        f"cannot end there. {remedy}",
        place=at,
        surfaces=(rule.fault, rule.main),
    )
