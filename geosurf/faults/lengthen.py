"""A fault that was picked too short -> one that is longer by a given distance, without a box."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from geosurf.conventions import is_number
from geosurf.errors import InputError
from geosurf.faults.extend import continue_side
from geosurf.faults.lines import guides_of
from geosurf.faults.rim import find_rim
from geosurf.faults.rules import read_names, read_sides
from geosurf.model import TriSurface
from geosurf.model.expected import expect
from geosurf.model.faults import SIDES, ExtendedFault

UNTIL = "the given distance"
LONGEST = 1e7  # [m], a quarter of the equator: more is a slip
_HOW = "Give a distance in metres above 0 for all sides, or for some, as {'up': 50, 'strike': 200}."


def lengthen_fault(surface: TriSurface, distance: Any) -> ExtendedFault:
    """Continue a fault along strike and dip by a distance.

    Sticks, and the dip and strike lines of grids, go on by their last step; other meshes go on in
    the tangent plane at the rim. See `extend_fault`, which continues a fault to the model box.

    Parameters
    ----------
    surface : TriSurface
        One connected piece; `triangulate_fault` makes one of sticks.
    distance : float, or mapping of str to float
        [m], along the new lines: for all sides, or for some of ``"strike"`` (both ends),
        ``"start"``, ``"end"``, ``"up"``, ``"down"``.

    Returns
    -------
    ExtendedFault
        Strike comes first, then up and down, so that the new corners are filled. Vertices and
        triangles as given come first, bit for bit.

    Raises
    ------
    InputError
        For an unknown side, or a distance that is not a length.
    SurfaceError
        If the fault is in several pieces, or its rim is not one line.
    GeometryError
        If the continuation would cross itself or the fault; the message has the place.

    Examples
    --------
    Two sticks that end 20 m above a horizon at -1620 m:

    >>> from geosurf import FaultSticks, triangulate_fault
    >>> sticks = [[[0, 0, -1500], [60, 0, -1600]], [[0, 200, -1500], [60, 200, -1600]]]
    >>> fault = triangulate_fault(FaultSticks("F1", sticks))
    >>> longer = lengthen_fault(fault, {"down": 50}).surface
    >>> longer.n_vertex, round(longer.bounds[4], 1)
    (6, -1642.9)
    """
    how = "triangulate_fault makes one"
    expect(surface, TriSurface, "lengthen_fault takes a TriSurface", how)
    distances = read_distances(distance, f"lengthen_fault of {surface.name!r}")
    longer, guides, found = surface, guides_of(surface), []
    axes = find_rim(surface).axes  # as it was given: a long continuation could turn the mean
    waiting = list(distances)

    # strike, then dip: the sides of `SIDES` in turn, each from the rim as it is by then
    while waiting:
        rim = find_rim(longer, axes)
        # a side that is but a point waits until its neighbours make it a line
        side = next((s for s in waiting if len(rim.arcs[s]) > 1), waiting[0])
        waiting.remove(side)

        def reach(start: np.ndarray, _: np.ndarray, length: float = distances[side]) -> np.ndarray:
            return np.full(len(start), length)

        longer, guides, made = continue_side(longer, rim, guides, side, reach, UNTIL)
        found.append(made)
    return ExtendedFault(longer, surface.n_triangle, tuple(found))


def read_distances(distance: Any, what: str) -> dict[str, float]:
    """Return the distance [m] of each side that is to be continued, in the order of work.

    Examples
    --------
    >>> read_distances({"down": 50, "strike": 200}, "lengthen of 'F1'")
    {'start': 200.0, 'end': 200.0, 'down': 50.0}
    """
    # one number for all sides, or a mapping that may say "strike" for both ends
    given = distance if isinstance(distance, Mapping) else dict.fromkeys(SIDES, distance)
    if not given:
        raise InputError(f"{what} is {distance!r}. {_HOW}")
    found: dict[str, float] = {}
    for word, length in given.items():
        if not (is_number(length) and 0 < length < LONGEST):
            raise InputError(f"{what} is {distance!r}. {_HOW}")
        for side in read_sides((word,), what):
            if side in found:
                raise InputError(
                    f"{what} gives side {side!r} twice. Leave out 'strike' or the end."
                )
            found[side] = float(length)
    return {side: found[side] for side in SIDES if side in found}


def read_lengthen(lengthen: Any, faults: Any) -> dict[str, dict[str, float]]:
    """Check which faults are to be lengthened, on which sides, by which distances.

    Parameters
    ----------
    lengthen : float, or mapping of str to distance
        One distance for all faults [m], or for some by name, each as for `lengthen_fault`.
    faults : sequence of str
        Names that exist.

    Returns
    -------
    dict of str to dict of str to float
        In the order of `faults`.

    Raises
    ------
    InputError
        For an unknown name or side, or a distance that is not a length.

    Examples
    --------
    >>> read_lengthen({"F1": {"up": 50}}, ["F1", "F2"])
    {'F1': {'up': 50.0}}
    """
    if lengthen is None:
        return {}
    given = lengthen if isinstance(lengthen, Mapping) else dict.fromkeys(faults, lengthen)
    if not isinstance(lengthen, Mapping):
        read_distances(lengthen, "lengthen")
    read_names(given, "lengthen", faults)
    return {
        name: read_distances(given[name], f"lengthen of {name!r}")
        for name in faults
        if name in given
    }
