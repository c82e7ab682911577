"""Which unit of a model holds a closed body of another program: by a point inside, exactly.

A vertical line through one of the body's triangles is cut by its shell in places that come in
pairs: from below, inside is between the first and the second, and so on. The middle of the longest
of these is a point of the body, and a unit holds it if its shell lies above the point an odd number
of times. A line that meets an edge is skipped. All numbers are fractions.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction

import numpy as np

from geosurf.model import Unit

LINES = 64  # that are tried for one body; the first of a sound one will do


def unit_of_body(corners: np.ndarray, units: Mapping[str, Unit]) -> str:
    """
    Return the name of the unit that holds a point of a body.

    Parameters
    ----------
    corners : ndarray of float64, shape (n, 3, 3)
        Corners of the triangles around the body, in any order [m].
    units : mapping of str to Unit

    Returns
    -------
    str
        Empty where no unit holds it, or no line decides, as for a body that is not closed.

    Examples
    --------
    >>> import geosurf as gs
    >>> units = gs.Scene({"Top": gs.synthetic.tilted_planes(n=3).horizons["Top"]}).units
    >>> unit = units["below Top"]
    >>> unit_of_body(unit.vertices[unit.triangles], units)
    'below Top'
    """
    # corners (n, 3, 3) of the triangles around each unit
    shells = {name: unit.vertices[unit.triangles] for name, unit in units.items()}
    for x, y in _middles(corners):
        # elevations where the line enters and leaves the body, in pairs
        cut = _heights(corners, x, y)
        if cut is None or len(cut) < 2 or len(cut) % 2:
            continue

        # the middle of the thickest piece is surely inside the body
        # the longest piece, so that the point is farthest from the shell
        thickness, z = max((b - a, (a + b) / 2) for a, b in zip(cut[::2], cut[1::2], strict=True))
        found = {name: _heights(shell, x, y) for name, shell in shells.items()}
        above = {name: one for name, one in found.items() if one is not None}

        # a point on a shell decides nothing: the next line is tried
        if thickness == 0 or len(above) < len(found) or any(z in one for one in above.values()):
            continue

        # an odd number of crossings above the point: the point is inside
        holds = [name for name, one in above.items() if sum(level > z for level in one) % 2]
        return holds[0] if holds else ""
    return ""


def _middles(corners: np.ndarray) -> Iterator[tuple[Fraction, Fraction]]:
    """Easting and northing in the middle of the triangles that are widest on the map."""
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    size = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    for row in np.argsort(-size, kind="stable")[:LINES].tolist():
        # not quite the middle: less likely on an edge of another surface
        x, y = (np.array([0.36, 0.33, 0.31]) @ corners[row, :, :2]).tolist()
        yield Fraction(x), Fraction(y)


def _heights(corners: np.ndarray, x: Fraction, y: Fraction) -> list[Fraction] | None:
    """Where a vertical line meets triangles, lowest first; None if it meets an edge of one."""
    # only triangles whose rectangle on the map has the line in it
    low, high = corners[:, :, :2].min(axis=1), corners[:, :, :2].max(axis=1)
    at = np.array([float(x), float(y)])
    near = ((low <= at) & (at <= high)).all(axis=1)
    found: list[Fraction] = []
    for triangle in corners[near].tolist():
        a, b, c = ([Fraction(value) for value in corner] for corner in triangle)

        # barycentric coordinates of the line in the triangle, times twice its area
        turns = [_turn(x, y, p, q) for p, q in ((b, c), (c, a), (a, b))]

        # signs of both kinds: the line passes outside; a zero: through an edge, so this line
        # decides nothing
        if min(turns) < 0 < max(turns):
            continue
        if 0 in turns:
            return None
        height = sum(t * p[2] for t, p in zip(turns, (a, b, c), strict=True)) / sum(turns)
        found.append(Fraction(height))
    return sorted(found)


def _turn(x: Fraction, y: Fraction, p: list[Fraction], q: list[Fraction]) -> Fraction:
    """Twice the area of a triangle on the map: above 0 if (x, y), p, q turn to the left."""
    return (p[0] - x) * (q[1] - y) - (p[1] - y) * (q[0] - x)
