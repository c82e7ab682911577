"""What to type so that a fault is continued: for scripts and for scenarios."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from geosurf.errors import GeosurfError
from geosurf.faults.rim import find_rim
from geosurf.model import TriSurface
from geosurf.model.faults import SIDES
from geosurf.sheets.mesh.too_short import LATERAL, distance_to


def how_to_lengthen(name: str, lengths: Mapping[str, float]) -> str:
    """
    Return the words that continue a fault.

    Parameters
    ----------
    name : str
    lengths : mapping of {"up", "down", "start", "end"} to float
        How far at least [m]; empty where that is not known.

    Examples
    --------
    >>> how_to_lengthen("F3", {"end": 133.6})
    "lengthen={'F3': {'end': 134}}; in a scenario, lengthen_m = {end = 134} of 'F3'"
    >>> how_to_lengthen("F3", {})
    "lengthen={'F3': distance}, with a distance [m]"
    """
    if not lengths:
        return f"lengthen={{{name!r}: distance}}, with a distance [m]"
    whole = {side: math.ceil(length) for side, length in lengths.items()}
    typed = ", ".join(f"{side} = {length}" for side, length in whole.items())
    return f"lengthen={{{name!r}: {whole}}}; in a scenario, lengthen_m = {{{typed}}} of {name!r}"


def end_at(fault: TriSurface, place: np.ndarray) -> str | None:
    """Return which end of a fault is nearest to a place (3,) [m]; None if its rim has no ends."""
    try:
        arcs = find_rim(fault).arcs
    except GeosurfError:  # several pieces, or a closed rim
        return None
    far = {side: distance_to(place, fault.vertices[arcs[side]]) for side in LATERAL}
    side = min(far, key=lambda one: far[one])
    return side if math.isfinite(far[side]) else None


def longer_by(before: TriSurface, after: TriSurface) -> dict[str, float]:
    """Return how far a fault was continued at each side [m]; empty if its rim has no sides."""
    try:
        old, new = find_rim(before).arcs, find_rim(after).arcs
    except GeosurfError:
        return {}
    found = {}
    for side in SIDES:
        # the median: corners of the rim also move with the side next to them; but a side that has
        # old points was not continued, though the sides next to it may have made it longer
        rim = before.vertices[old[side]]
        away = [distance_to(place, rim) for place in after.vertices[new[side]]]
        far = float(np.median(away)) if min(away, default=0.0) > 0.0 else 0.0
        if far < math.inf and far > 0.0:
            found[side] = far
    return found
