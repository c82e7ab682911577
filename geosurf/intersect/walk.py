"""Curves of two whole, smooth lattices, walked from cell to cell without their triangles.

What does not go smoothly (a hole, noise, tangency, a curve that ends inside) is not decided
here: the plain curve is taken then, and lifted where it can be (`geosurf.intersect.lift`).
"""

from __future__ import annotations

import numpy as np

from geosurf.intersect.lift import LIFTED, NOISE, ROUGH, Line, doubt_along
from geosurf.intersect.loops import cell_size, find_lost, pair_keys
from geosurf.intersect.sides import Candidates, Side
from geosurf.kernels.trace import CLOSED, LOST
from geosurf.kernels.walk import W_CHORD, W_DOUBT, W_SINE, walk_all

_COARSEST = 0.25  # [cells]: for more, the plain curve has more points than are needed
_FIRST_STEP = 0.25  # [cells]


def walk_curves(sides: tuple[Side, Side], near: Candidates, tolerance: float) -> list[Line] | None:
    """All curves of two lattices to a tolerance, or None where the plain curve has to help.

    Parameters
    ----------
    sides : (Side, Side)
    near : Candidates
        All pairs of patches that may touch.
    tolerance : float
        [m]

    Returns
    -------
    list of Line or None
    """
    one, two = sides
    if not two.smooth or not all((flags == 1).all() for flags in near.whole):
        return None
    if not len(near.pairs):
        return []
    size = cell_size(near)
    if tolerance > _COARSEST * size:
        return None
    arrays = (one.x, one.y, one.z, two.x, two.y, two.z, two.c)
    doubted = -1.0  # not known yet: the kernel looks at where it lands
    for _ in range(2):
        rows, offsets, ends, unsettled = walk_all(
            *arrays, near.pairs, *near.cells, *near.nets, _FIRST_STEP * size, tolerance, doubted,
            ROUGH,
        )  # fmt: skip
        lines = None if (ends == LOST).any() else _lines(rows, offsets, ends, tolerance)
        if lines is None:
            return None
        most = max((line.bound for line, _ in lines), default=0.0)
        doubted = 1.05 * max((line.bound - chord for line, chord in lines), default=0.0)
        if most <= tolerance or doubted > 0.75 * tolerance:  # or no shorter chord helps
            break
    found = [line for line, _ in lines]
    return None if _more_beside(sides, near, unsettled, found, rows, tolerance) else found


def _lines(rows, offsets, ends, tolerance) -> list[tuple[Line, float]] | None:
    """Walks as lines with the chord error of each; None where the data are noise."""
    out = []
    for a, b, end in zip(offsets[:-1], offsets[1:], ends, strict=True):
        part = rows[a:b]
        status = np.full(len(part), LIFTED)
        doubt = doubt_along(part[:, W_DOUBT:W_SINE], part[:, W_SINE], status, tolerance)
        if not np.isfinite(doubt).all() or (status == NOISE).any():
            return None
        worst, chord = float(doubt.max()), float(part[:, W_CHORD].max())
        places = [("interpolation", part[:, :3], worst)] if worst > tolerance else []
        tri = np.zeros(len(part), dtype=np.int64)
        line = Line(part[:, :3], part[:, 3:7], tri, end == CLOSED, chord + worst, places)
        out.append((line, chord))
    return out


def _more_beside(sides, near: Candidates, unsettled, lines, rows, tolerance) -> bool:
    """Whether pairs of cells that are not settled hold a curve, or may hold one."""
    if not len(unsettled):
        return False
    keys = pair_keys(sides, rows[:, 3:7], np.zeros(len(rows), dtype=np.int64))
    rest = Candidates(near.cells, near.nets, near.whole, near.pairs[unsettled])
    return any(find_lost(sides, rest, lines, keys, tolerance))
