"""A fault that stops short of its main fault -> a fault that reaches beyond it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from geosurf.faults.distance import nearest_of
from geosurf.faults.extend import extend_to
from geosurf.faults.rim import find_rim
from geosurf.faults.sides import adjacency
from geosurf.faults.truncate import main_side
from geosurf.model import Patches, TriSurface
from geosurf.model.faults import SIDES, ExtendedFault


def bridge_to(
    fault: TriSurface,
    main: TriSurface,
    keep: str,
    split: Callable[[Sequence[TriSurface]], Patches],
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
    ('start', 2.25)
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
