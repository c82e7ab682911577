"""Follow curves of two smooth lattices from cell to cell, without their triangles.

What does not go smoothly (a hole, noise, tangency, a curve that ends inside) is not decided
here: the plain curve is taken then, and lifted where it can be (`geosurf.intersect.lift`).
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from geosurf.intersect.loops import find_lost
from geosurf.intersect.sides import Candidates, Side
from geosurf.intersect.strand import Line
from geosurf.kernels.smooth.trace import AT_RIM, CLOSED


def walk_curves(sides: tuple[Side, Side], near: Candidates, tolerance: float) -> list[Line] | None:
    """All curves of two lattices to a tolerance, or None where the plain curve has to help.

    Parameters
    ----------
    sides : (Side, Side)
    near : Candidates
        All pairs of patches that may touch, and what was walked through them.
    tolerance : float
        [m]

    Returns
    -------
    list of Line or None
    """
    if near.walked is None:
        return None

    # A walk that stops inside a surface is not trusted: the exact triangles decide.
    rows, offsets, ends, figures, unsettled, keys = near.walked
    if not {CLOSED, AT_RIM}.issuperset(ends.tolist()):
        return None

    found = []
    for k, (a, b) in enumerate(pairwise(offsets.tolist())):
        bound, doubt = figures[k].tolist()
        points = rows[a:b]
        places = [("interpolation", points, doubt)] if bound > tolerance else []
        found.append(Line(points, bool(ends[k] == CLOSED), bound, places))

    # Pairs that the walk did not settle may hold another curve.
    return None if _more_beside(sides, near, unsettled, found, keys, tolerance) else found


def _more_beside(
    sides: tuple[Side, Side],
    near: Candidates,
    unsettled: np.ndarray,
    lines: list[Line],
    keys: np.ndarray,
    tolerance: float,
) -> bool:
    """Whether pairs of cells that are not settled hold a curve, or may hold one."""
    if not len(unsettled):
        return False
    rest = replace(near, pairs=near.pairs[unsettled])
    return any(find_lost(sides, rest, lines, keys, tolerance))
