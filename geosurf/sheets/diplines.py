"""Lines down the dip of a fault: which way a wall moves along it where its strike turns.

On a plane they run across its strike. On a fault that is curved in the map they turn with it: the
steepest way down at a place is across the strike there.

Legend
    s, r, z    as in `section`: along the mean strike, across it, elevation [m]
    q          ds/dz along a line. With slopes r_s and r_z of the fault, the way down is at right
               angles to its strike line (1, r_s) in the map and stays on the fault, so that
               q = -r_s r_z / (1 + r_s**2)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from geosurf.model import Sheet, TriSurface
from geosurf.sheets.section import Section, bilinear, section_of

DIRECTIONS = ("local", "mean")  # in which walls move and throw is read
MOST_STRETCH = 0.5  # of rock along strike by its movement, between neighbouring lines
STRAIGHT = 1e-12  # q below this is rounding: a fault that does not turn
STEPS = 2  # of Runge and Kutta's fourth order, for one movement
SPARE = 2.0  # cells beyond the cut-offs, or the throw, up to which a fault is looked at
FAR_STEPS = 8  # and from a cut-off to the level at which lines are compared


@dataclass(frozen=True, eq=False)
class DipLines:
    """Slopes q of the lines, bilinear between nodes over s and z, constant beyond.

    Attributes
    ----------
    table : ndarray (n_s, n_z)
    length : float
        Largest s [m].
    z : ndarray (2,)
        Lowest and highest elevation [m].
    """

    table: np.ndarray
    length: float
    z: np.ndarray

    def slope(self, s: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Slope q (n,) at places; no line turns above or below the fault."""
        n_s, n_z = self.table.shape
        low, high = self.z
        u = np.clip(s / self.length, 0.0, 1.0) * (n_s - 1)
        v = (np.clip(z, low, high) - low) / (high - low) * (n_z - 1)
        return np.where((z < low) | (z > high), 0.0, bilinear(self.table, u, v))

    def moved(self, s: np.ndarray, z: np.ndarray, to: np.ndarray, steps: int = STEPS) -> np.ndarray:
        """Where the lines through places (s, z) are along strike at elevations `to`."""
        step = (to - z) / steps
        for k in range(steps):
            at = z + k * step
            one = self.slope(s, at)
            two = self.slope(s + 0.5 * step * one, at + 0.5 * step)
            three = self.slope(s + 0.5 * step * two, at + 0.5 * step)
            four = self.slope(s + step * three, at + step)
            s = s + step / 6.0 * (one + 2.0 * two + 2.0 * three + four)
        return s


def dip_lines(section: Section, throw: float, cell: float) -> DipLines | None:
    """
    Lines down the dip of a fault, or None where they all run across its mean strike.

    Parameters
    ----------
    section : Section
    throw : float
        The largest by size [m].
    cell : float
        Strike and dip are means over this far to both sides [m]; over twice as far, and so on,
        where rock would else be stretched along strike by more than a half, as at a crease.

    Returns
    -------
    DipLines or None
    """
    n_s, n_z = section.table.shape
    spacing = section.length / (n_s - 1)
    ends = np.stack(section.extent(np.linspace(*section.z, n_z)), axis=1)
    reach = cell
    while True:
        table = _slopes(section, ends, spacing, reach)
        stretch = np.abs(np.diff(table, axis=0)).max() / spacing * throw
        if stretch <= MOST_STRETCH or reach >= section.length:
            break
        reach *= 2.0
    if np.abs(table).max() <= STRAIGHT:
        return None
    return DipLines(table, section.length, section.z)


def cell_of(horizon: TriSurface | Sheet) -> float:
    """Mean step of the grid of a horizon, or mean size of its triangles in the map [m].

    Examples
    --------
    >>> cell_of(TriSurface("Top", "horizon", [[0, 0, 0], [50, 0, 0], [0, 50, 9]], [[0, 1, 2]]))
    50.0
    """
    grid = horizon.lattice
    if grid is None:  # a sheet has one
        a, b, c = horizon.vertices[horizon.triangles.T][:, :, :2]
        area = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
        return float(np.sqrt(area.mean()))
    x, y = grid.easting, grid.northing
    if x.ndim == 1:
        return 0.5 * float(np.ptp(x) / (len(x) - 1) + np.ptp(y) / (len(y) - 1))
    steps = [np.nanmean(np.hypot(np.diff(x, axis=k), np.diff(y, axis=k))) for k in (0, 1)]
    return 0.5 * float(steps[0] + steps[1])


def beyond(levels: tuple[float, float], cell: float, throw: float = 0.0) -> tuple[float, float]:
    """Levels between which a fault is looked at: those given, and its throw beyond them."""
    spare = max(SPARE * cell, throw)
    return levels[0] - spare, levels[1] + spare


def to_level(
    fault: TriSurface,
    throw: float,
    cell: float,
    level: float,
    levels: tuple[float, float] = (-np.inf, np.inf),
) -> Callable[[np.ndarray], np.ndarray] | None:
    """
    How lines down the dip of a fault lead from places on it to one level.

    Parameters
    ----------
    fault : TriSurface
        Normals into its hanging wall.
    throw, cell : float
        See `dip_lines` [m].
    level : float
        Elevation [m].
    levels : (float, float)
        Lowest and highest cut-off [m]: the fault is looked at between them, and a throw beyond.

    Returns
    -------
    callable or None
        Takes points (n, 3) and gives the places (n, 2) at which their lines are at that level,
        easting and northing; None where all lines run across the mean strike.

    Raises
    ------
    GeometryError
        See `section_of`.
    """
    corner = np.floor(fault.vertices[:, :2].min(axis=0))
    section = section_of(fault, corner, 0.5 * cell, beyond(levels, cell, throw))
    lines = dip_lines(section, throw, cell)
    if lines is None:
        return None

    def found(points: np.ndarray) -> np.ndarray:
        """Places (n, 2) of points (n, 3)."""
        s, _ = section.of(points[:, :2] - corner)
        there = np.full(len(points), level)
        s = lines.moved(s, points[:, 2], there, FAR_STEPS)
        places: np.ndarray = section.places(s, section.across(s, there)) + corner
        return places

    return found


def _slopes(section: Section, ends: np.ndarray, spacing: float, reach: float) -> np.ndarray:
    """Slopes q at the nodes of a section's table, of strike and dip as means over some reach.

    At each level only what lies between the ends of the fault counts, and it goes on beyond as it
    is there; a level on which it is hardly longer than a node has no strike of its own.
    """
    r = section.table
    n_s, n_z = r.shape
    at = np.arange(n_s) * spacing
    steep = np.gradient(r, float(np.ptp(section.z)) / (n_z - 1), axis=1)
    found = np.zeros_like(r)
    for j, (first, last) in enumerate(ends):
        if last - first <= 2.0 * spacing:
            continue
        s = np.clip(at, first, last)
        low, high = np.maximum(s - reach, first), np.minimum(s + reach, last)
        r_s = (np.interp(high, at, r[:, j]) - np.interp(low, at, r[:, j])) / (high - low)
        area = np.append(0.0, np.cumsum(0.5 * spacing * (steep[1:, j] + steep[:-1, j])))
        r_z = (np.interp(high, at, area) - np.interp(low, at, area)) / (high - low)
        found[:, j] = -r_s * r_z / (1.0 + r_s**2)
    return found
