"""Orientation of the cells of a gridded fault, from bounds where they suffice.

`Lattice.survey` holds those bounds, made while the nodes were read. Each question here is answered
from them where the answer is clear by far, and otherwise from scratch, with the very numbers that
the rule speaks of (`Lattice.normals`, `rising_diagonal`).
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.conventions import rising_diagonal
from geosurf.model import Lattice

_CLEAR = 1e-3  # of squared edges; sums are off by less than a part in a billion of them
_UNDERFLOW = 1e-290
_OVERFLOW = 1e150


def fault_diagonal(lattice: Lattice) -> bool:
    """Return the diagonal of a fault: the one that climbs towards the east end of strike.

    Like the rule for horizons, but in the vertical plane along strike, which a
    vertical fault has and the map does not show. A flat fault takes the rule
    for horizons.

    Parameters
    ----------
    lattice : Lattice
        With `reverse`; its own diagonal does not matter.

    Returns
    -------
    bool
        As `Lattice.rising`.

    Examples
    --------
    >>> x, y = np.meshgrid([0.0, 50.0, 100.0], [0.0, 50.0])
    >>> fault_diagonal(Lattice(x, y, -y, True, False))
    False
    """
    survey = lattice.survey
    # with either diagonal, so that it is the same from whatever corner the grid is read
    east, north, up = (a + b for a, b in zip(*survey.normals.tolist(), strict=True))
    largest = max(abs(east), abs(north))
    if largest <= 1e-6 * abs(up):
        return rising_diagonal(lattice.easting, lattice.northing)
    x, y = -north / largest, east / largest  # along strike; squares of tiny ones underflow
    lead = x if abs(x) > 1e-6 else y

    # strike points east, or north where it has no easting: one direction whatever the grid's
    size = math.copysign(math.hypot(x, y), lead)
    strike = x / size, y / size
    # clear, as in `rising_diagonal`: squared diagonals of a cell are at most its squared edges
    (gain_x, gain_y), (reach_x, reach_y) = survey.gains.tolist(), survey.reach.tolist()
    gain = strike[0] * gain_x + strike[1] * gain_y
    reach = abs(strike[0]) * reach_x + abs(strike[1]) * reach_y
    if abs(gain) - reach > _CLEAR * survey.edges and survey.edges < _OVERFLOW:
        return gain > 0
    x = lattice.easting - np.nanmin(lattice.easting)
    y = lattice.northing - np.nanmin(lattice.northing)
    return rising_diagonal(x * strike[0] + y * strike[1], lattice.elevation)


def corners_are_open(lattice: Lattice) -> bool:
    """Return whether all triangles have an area, with either diagonal; False: perhaps.

    Every corner of a cell is then farther from a straight line than any rounding could hide:
    bounds of the edges around show it, or an angle that is 1e-5 radians off 0 and 180 degrees.

    Parameters
    ----------
    lattice : Lattice
        With `reverse`.

    Returns
    -------
    bool
    """
    return lattice.survey.margin > _UNDERFLOW and lattice.survey.edges < _OVERFLOW


def bounds_of_normals(lattice: Lattice) -> tuple[np.ndarray, float, float]:
    """Return the sum of all normals (length: area, not turned), and bounds of the sum of areas.

    Parameters
    ----------
    lattice : Lattice
        With `reverse`.

    Returns
    -------
    normal : ndarray of float64, shape (3,)
        [m2]
    least, most : float
        [m2]; far enough from the truth that no rounding matters.
    """
    normal = lattice.survey.normals[int(lattice.rising)]
    # two edges u, v of a triangle: its area is at most (u^2 + v^2) / 4
    return normal, (1.0 - _CLEAR) * math.hypot(*normal.tolist()), 0.2501 * lattice.survey.edges
