"""Lines down the dip of a fault: which way a wall moves along it where its strike turns.

On a plane they run across its strike. On a fault that is curved in the map they turn with it: the
steepest way down at a place is across the strike there.

Legend
    s, r, z    as in `fault_profile`: along the mean strike, across it, elevation [m]
    q          ds/dz along a line. With slopes r_s and r_z of the fault, the way down is at right
               angles to its strike line (1, r_s) in the map and stays on the fault, so that
               q = -r_s r_z / (1 + r_s**2)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeometryError
from geosurf.model import Sheet, TriSurface, frozen
from geosurf.sheets.faults.fault_profile import KEPT, Section, bilinear, overlapping, section_of

MOST_STRETCH = 0.5  # of rock along strike by its movement, between neighbouring lines
STRAIGHT = 1e-12  # q below this is rounding: a fault that does not turn
STEPS = 2  # of Runge and Kutta's fourth order, for one movement
SPARE = 2.0  # cells beyond a horizon, or the throw, up to which a fault is looked at
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
        return self.way(s, z, to, steps)[-1]

    def way(self, s: np.ndarray, z: np.ndarray, to: np.ndarray, steps: int) -> list[np.ndarray]:
        """Where they are along strike after each step, from where they start."""
        step = (to - z) / steps
        found = [s]

        # Runge and Kutta's fourth order: slopes at the start, twice in the middle, and at the end
        for k in range(steps):
            at = z + k * step
            one = self.slope(s, at)
            two = self.slope(s + 0.5 * step * one, at + 0.5 * step)
            three = self.slope(s + 0.5 * step * two, at + 0.5 * step)
            four = self.slope(s + step * three, at + step)
            s = s + step / 6.0 * (one + 2.0 * two + 2.0 * three + four)
            found.append(s)
        return found


def dip_lines(
    section: Section, throw: float, cell: float, levels: tuple[float, float] | None = None
) -> DipLines | None:
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
    levels : (float, float), optional
        Elevations between which stretching counts [m]; default: everywhere.

    Returns
    -------
    DipLines or None
    """
    n_s, n_z = section.table.shape
    spacing = section.length / (n_s - 1)
    # stretching counts between these levels of the table; others may be as uneven as they are
    rows = slice(None)
    if levels is not None:
        node = np.linspace(section.z[0], section.z[1], n_z)
        low, high = np.searchsorted(node, levels[0], "right"), np.searchsorted(node, levels[1])
        rows = slice(max(min(low, n_z) - 1, 0), high + 1)

    # wider means until neighbouring lines stretch rock by MOST_STRETCH at most
    reach = cell
    while True:
        table = _slopes(section, reach)
        steps = np.diff(table[:, rows], axis=0)
        stretch = np.abs(steps).max() / spacing * throw
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
    if grid is None:
        assert isinstance(horizon, TriSurface)  # a sheet has a lattice
        a, b, c = horizon.vertices[horizon.triangles.T][:, :, :2]
        area = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
        return float(np.sqrt(area.mean()))
    x, y = grid.easting, grid.northing
    if x.ndim == 1:
        return 0.5 * float(np.ptp(x) / (len(x) - 1) + np.ptp(y) / (len(y) - 1))
    if grid.is_graph:  # each step is near the mean one: corners show it, in a store as in memory
        n_row, n_col = grid.shape
        corners = grid.map_places(np.array([0, n_col - 1, (n_row - 1) * n_col]))
        along, up = np.hypot(*(corners[1:] - corners[0]).T).tolist()
        return 0.5 * (along / (n_col - 1) + up / (n_row - 1))
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
    hanging_wall: Sequence[np.ndarray],
    footwall: Sequence[np.ndarray],
) -> Callable[[np.ndarray], np.ndarray] | None:
    """
    How lines down the dip of a fault lead from its cut-offs to one level.

    Parts of the fault that turn back are left out, unless these lines pass through them on their
    way from one wall to the other: so a fault may turn back above and below its cut-offs, as where
    its dip lines were continued. Lines are then smoothed for the levels of the cut-offs alone.
    Beyond both cut-offs, lines lead both walls to the same place, whatever the fault does there.

    Parameters
    ----------
    fault : TriSurface
        Normals into its hanging wall.
    throw, cell : float
        See `dip_lines` [m].
    level : float
        Elevation [m].
    hanging_wall, footwall : sequence of ndarray, each (n, 3)
        Cut-off lines [m], in order along the fault.

    Returns
    -------
    callable or None
        Takes points (n, 3) of cut-offs and gives the places (n, 2) at which their lines are at that
        level, easting and northing; None where all lines run across the mean strike.

    Raises
    ------
    GeometryError
        If the fault has no strike, or turns back between its cut-offs.
    """
    corner = np.floor(fault.vertices[:, :2].min(axis=0))
    section = section_of(fault, corner, 0.5 * cell, None)

    # where the fault turns back somewhere, only the levels of the cut-offs have to be smooth
    z = np.concatenate([*(line[:, 2] for line in (*hanging_wall, *footwall)), [level]])
    levels = (float(z.min()), float(z.max())) if len(section.turned) else None
    lines = dip_lines(section, throw, cell, levels)
    if len(section.turned):
        _check_between(section, lines, corner, level, (hanging_wall, footwall))
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


def _check_between(
    section: Section,
    lines: DipLines | None,
    corner: np.ndarray,
    level: float,
    walls: tuple[Sequence[np.ndarray], Sequence[np.ndarray]],
) -> None:
    """Refuse a fault that turns back between its cut-offs, on a line down its dip.

    Looked at is all that these lines cover over s and z, as triangles between neighbouring ones,
    so that nothing is missed between two lines.
    """

    def leads(s: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        """Lines (steps + 1, n, 2) from s at one elevation to another."""
        way = [s] * (FAR_STEPS + 1) if lines is None else lines.way(s, start, end, FAR_STEPS)
        return np.stack([np.array(way), np.linspace(start, end, FAR_STEPS + 1)], axis=2)

    def profile(line: np.ndarray) -> np.ndarray:
        """Columns s at the level and elevation of a cut-off line, in the direction of strike."""
        s, _ = section.of(line[:, :2] - corner)
        s = leads(s, line[:, 2], np.full(len(s), level))[-1, :, 0]
        found: np.ndarray = np.column_stack([s, line[:, 2]])[np.argsort(s, kind="stable")]
        return found

    hanging, foot = ([profile(line) for line in wall] for wall in walls)
    met, length, first = 0.0, 0.0, None
    for h, f in product(hanging, foot):
        # compared where both walls have a cut-off, at the union of their points
        low, high = max(h[0, 0], f[0, 0]), min(h[-1, 0], f[-1, 0])
        if low >= high:
            continue
        s = np.unique(np.concatenate([h[:, 0], f[:, 0]]).clip(low, high))
        z_h, z_f = (np.interp(s, *line.T) for line in (h, f))
        top = leads(s, np.full(len(s), level), z_f)[-1, :, 0]

        # net (steps + 1, n, 2): lines from the footwall's to the hanging wall's cut-off; its cells,
        # halved, are all that lines between the cut-offs cover
        net = leads(top, z_f, z_h)
        a, b, c, d = net[:-1, :-1], net[:-1, 1:], net[1:, 1:], net[1:, :-1]
        covered = np.stack([np.stack([a, b, c], 2), np.stack([a, c, d], 2)]).reshape(-1, 3, 2)
        hit = np.zeros(len(covered), dtype=bool)

        # boxes first: most triangles that turn back are far away
        reaches = (section.turned.max(axis=1) >= covered.min(axis=(0, 1))).all(axis=1)
        reaches &= (section.turned.min(axis=1) <= covered.max(axis=(0, 1))).all(axis=1)
        for triangle in section.turned[reaches]:
            hit[overlapping(triangle, covered)] = True
        length += high - low
        met += float(np.diff(s)[hit.reshape(-1, len(s) - 1).any(axis=0)].sum())
        if first is None and hit.any():
            first = covered[hit.argmax()].mean(axis=0, keepdims=True)
    if first is None:
        return
    at = section.places(first[:, 0], section.across(*first.T)) + corner
    where = np.append(at, first[0, 1])
    raise GeometryError(
        f"fault {section.name!r} turns back against its mean dip direction between its cut-offs, "
        f"on {100.0 * met / length:.2g} % of their length, for one at {place(where)}, so that "
        "throw has two values there. Give the part beyond as a fault of its own.",
        place=where,
        surfaces=(section.name,),
    )


@lru_cache(maxsize=KEPT)  # all horizons ask the same of a fault
def _slopes(section: Section, reach: float) -> np.ndarray:
    """Slopes q at the nodes of a section's table, of strike and dip as means over some reach.

    At each level only what lies between the ends of the fault counts, and it goes on beyond as it
    is there; a level on which it is hardly longer than a node has no strike of its own.
    """
    r = section.table
    n_s, n_z = r.shape
    spacing = section.length / (n_s - 1)
    ends = np.stack(section.extent(np.linspace(section.z[0], section.z[1], n_z)), axis=1)
    at = np.arange(n_s) * spacing
    steep = np.gradient(r, float(np.ptp(section.z)) / (n_z - 1), axis=1)
    found = np.zeros_like(r)
    for j, (first, last) in enumerate(ends):
        if last - first <= 2.0 * spacing:
            continue
        s = np.clip(at, first, last)

        # means over the reach: differences of r along strike, and of the integral of its dip
        low, high = np.maximum(s - reach, first), np.minimum(s + reach, last)
        r_s = (np.interp(high, at, r[:, j]) - np.interp(low, at, r[:, j])) / (high - low)
        area = np.append(0.0, np.cumsum(0.5 * spacing * (steep[1:, j] + steep[:-1, j])))
        r_z = (np.interp(high, at, area) - np.interp(low, at, area)) / (high - low)
        found[:, j] = -r_s * r_z / (1.0 + r_s**2)
    return frozen(found, np.float64)
