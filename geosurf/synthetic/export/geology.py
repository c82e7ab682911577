"""The field that `field_export` writes: its faults, its horizons, and the frame of its grids.

All formulas use a local frame: x along the columns of the grids, y along their rows, z elevation.
Each side of the faults (a sector) has a smooth sheet of its own, defined everywhere. A horizon is
each sheet on its own side of the faults.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from geosurf.conventions import check_word
from geosurf.errors import InputError
from geosurf.synthetic.torn_horizon import DATUM, Fault, exists, sectors, side_of

STEP = 40.0  # nodes of the grids [m]
SHAPE = (81, 101)  # rows, columns
ROTATION = 30.0  # of the columns, counter-clockwise from east [degrees]
ORIGIN = (462000.0, 5931000.0)  # exact in float32, which IRAP binary stores

# what all horizons cover: a bay in the south, and a corner that is missing in the north-east
OUTLINE = np.array(
    [
        (200, 200),
        (2400, 200),
        (2600, 520),
        (3000, 520),
        (3200, 200),
        (3800, 200),
        (3800, 2500),
        (3300, 3000),
        (200, 3000),
    ],
    dtype=np.float64,
)


@dataclass(frozen=True)
class Horizon:
    """A horizon before faulting: a level, and how much of the relief it has."""

    name: str
    level: float
    share: float

    def before(self, x: Any, y: Any) -> Any:
        """Its elevation before faulting [m]."""
        return self.level + self.share * relief(x, y)


@dataclass(frozen=True)
class Block:
    """A fault block: its name lists its sides."""

    name: str

    def holds(self, signs: Mapping[str, int]) -> bool:
        """Whether a sector belongs to it."""
        return all(signs[side[:-1]] == (1 if side[-1] == "+" else -1) for side in self.name.split())


@dataclass(frozen=True, eq=False)
class Geology:
    """Horizons, youngest first; faults, main ones first; blocks."""

    horizons: tuple[Horizon, ...]
    faults: Mapping[str, Fault]
    blocks: tuple[Block, ...]

    @cached_property
    def sectors(self) -> list[tuple[int, ...]]:
        """Signs of each sector, in the order of the faults; 0: the fault is not there."""
        return sectors(dict(self.faults))

    def horizon(self, name: str) -> Horizon:
        """A horizon by its name."""
        return next(h for h in self.horizons if h.name == name)

    def sheets(self, horizon: Horizon, x: Any, y: Any) -> dict[tuple[int, ...], Any]:
        """Elevation of the sheet of each sector, as if it continued beyond the faults."""
        # each wall once, then combined: sectors share them
        moves = {
            (name, sign): moved(fault, horizon, *fault.along_across(x, y), sign)
            for name, fault in self.faults.items()
            for sign in (1, -1)
        }
        base = horizon.before(x, y)
        elevations = {}
        for signs in self.sectors:
            pairs = [(name, sign) for name, sign in zip(self.faults, signs, strict=True) if sign]
            elevations[signs] = base - sum(moves[pair] for pair in pairs)
        return elevations

    def sheet(self, horizon: Horizon, signs: tuple[int, ...], x: Any, y: Any) -> Any:
        """Elevation of the sheet of one sector."""
        z = horizon.before(x, y)
        for fault, sign in zip(self.faults.values(), signs, strict=True):
            if sign:
                z = z - moved(fault, horizon, *fault.along_across(x, y), sign)
        return z


def relief(x: Any, y: Any) -> Any:
    """Height of the structure above its datum [m]."""
    dome = 95.0 * np.exp(-(((x - 2100.0) / 1500.0) ** 2) - ((y - 1700.0) / 1150.0) ** 2)
    shoulder = 30.0 * np.exp(-(((x - 700.0) / 700.0) ** 2) - ((y - 800.0) / 800.0) ** 2)
    tilt = 0.008 * (x - 2000.0) - 0.006 * (y - 1600.0)
    return dome + shoulder + tilt + 5.0 * np.sin(x / 420.0 + 0.4) * np.cos(y / 510.0)


def moved(fault: Fault, horizon: Horizon, s: Any, r: Any, sign: int) -> Any:
    """How far a wall (+1 hanging) went down, at places along strike and across it [m].

    Throw of a through-going fault is largest in the middle. That of a fault with two tips dies
    there, and away from the fault within its half length.
    """
    half = 0.5 * fault.throw
    if not np.isfinite(fault.half):
        return sign * half * (0.85 + 0.15 * np.cos(s / 700.0))

    # shares that die at the tips and away from the fault, with a smooth end at both
    away = (r - fault.across(s, horizon.level)) / fault.half
    along = np.maximum(1.0 - (s / fault.half) ** 2, 0.0)
    return sign * half * along * np.sqrt(along) * np.maximum(1.0 - away**2, 0.0) ** 2


def fault_elevation(fault: Fault, x: Any, y: Any) -> Any:
    """Elevation of a dipping fault in the map; infinite where it is above all horizons."""
    s, r = fault.along_across(x, y)
    cot = 1.0 / np.tan(np.radians(fault.dip))

    # `Fault.across` solved for depth: a quadratic where the fault flattens
    linear = cot + 300.0 * fault.flatten
    across = r - fault.wave * np.sin(s / 450.0)
    if fault.flatten == 0.0:
        return DATUM - across / linear
    inside = linear**2 + 4.0 * fault.flatten * across
    root = np.sqrt(np.maximum(inside, 0.0))

    # beyond the lowest point of the parabola the fault does not exist
    return np.where(inside > 0, DATUM - (root - linear) / (2.0 * fault.flatten), np.inf)


def reach(fault: Fault, beyond: float) -> tuple[float, float]:
    """First and last place along strike of a fault in the rectangle of the grids."""
    east, north = STEP * (SHAPE[1] - 1) + beyond, STEP * (SHAPE[0] - 1) + beyond
    x, y = np.array([-beyond, east, east, -beyond]), np.array([-beyond, -beyond, north, north])

    # along strike from corner to corner of the grids
    s = fault.along_across(x, y)[0]
    return max(float(s.min()), -fault.half), min(float(s.max()), fault.half)


def branch_ends(fault: Fault, faults: Mapping[str, Fault], z: np.ndarray) -> np.ndarray:
    """Distance along strike at which a branch meets its main fault, at some elevations."""
    assert fault.branch is not None
    main, sign = faults[fault.branch[0]], fault.branch[1]
    low, high = np.full(np.shape(z), -4000.0), np.full(np.shape(z), 4000.0)
    for _ in range(60):  # the branch is where s is small
        s = 0.5 * (low + high)
        there = side_of(main, *fault.place(s, fault.across(s, z)), z) == sign
        low, high = np.where(there, s, low), np.where(there, high, s)
    return 0.5 * (low + high)


def to_world(x: Any, y: Any) -> tuple[Any, Any]:
    """Easting and northing of places in the local frame."""
    c, s = np.cos(np.radians(ROTATION)), np.sin(np.radians(ROTATION))

    # a rotation about the first node, and back below
    return ORIGIN[0] + c * x - s * y, ORIGIN[1] + s * x + c * y


def to_local(easting: Any, northing: Any) -> tuple[Any, Any]:
    """The inverse of `to_world`."""
    c, s = np.cos(np.radians(ROTATION)), np.sin(np.radians(ROTATION))
    east, north = np.asarray(easting) - ORIGIN[0], np.asarray(northing) - ORIGIN[1]
    return c * east + s * north, c * north - s * east


# ---- the fields ----------------------------------------------------------------------

_HORIZONS = (
    Horizon("Top", -1775.0, 1.0),
    Horizon("Middle", -1840.0, 0.92),
    Horizon("Base", -1930.0, 0.8),
)
_THREE = {
    "F1": Fault(1750, 1600, strike=8, dip=60, half=np.inf, throw=70, profile="constant",
                flatten=2e-4, wave=30),
    "F2": Fault(2900, 1050, strike=278, dip=62, half=np.inf, throw=45, profile="constant",
                branch=("F1", 1)),
    "F3": Fault(800, 1550, strike=18, dip=64, half=850, throw=60),
}  # fmt: skip
_SIX = _THREE | {
    "F4": Fault(2000, 2450, strike=95, dip=66, half=np.inf, throw=40, profile="constant"),
    "F5": Fault(2800, 1850, strike=22, dip=63, half=420, throw=36, wave=0),
    "F6": Fault(3150, 1650, strike=16, dip=67, half=380, throw=32, wave=0),
}


@lru_cache(maxsize=3)
def geology_of(variant: str) -> Geology:
    """The geology of a variant."""
    if variant == "network":
        names = "F1- F4-", "F1- F4+", "F1+ F4-", "F1+ F2+ F4+", "F1+ F2-"
        return Geology(_HORIZONS, _SIX, tuple(map(Block, names)))
    return Geology(_HORIZONS, _THREE, tuple(map(Block, ("F1-", "F1+ F2+", "F1+ F2-"))))


# ---- truth ----------------------------------------
# What is true of an exported field: elevations, cut-offs, throw, volumes.


# ---- areas ----------------------------------------
# Polygons in the map: what is inside, how far away it is, and a rule to integrate over it.


def inside(polygon: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Whether places are inside a polygon (n, 2), by the parity of crossings to the east."""
    is_inside = np.zeros(np.broadcast(x, y).shape, dtype=bool)
    for (x0, y0), (x1, y1) in _edges(polygon):
        # even-odd rule; level edges are never crossed by a level ray
        if y0 != y1:
            crossing = x0 + (y - y0) * (x1 - x0) / (y1 - y0)
            is_inside ^= ((y0 <= y) != (y1 <= y)) & (x < crossing)
    return is_inside


def distance_from(polygon: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Distance of places from a polygon [its unit], 0 inside."""
    distance = np.full(np.broadcast(x, y).shape, np.inf)
    for (x0, y0), (x1, y1) in _edges(polygon):
        dx, dy = x1 - x0, y1 - y0

        # foot on the edge, as a share of it
        part = np.clip(((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy), 0.0, 1.0)
        distance = np.minimum(distance, np.hypot(x - x0 - part * dx, y - y0 - part * dy))
    return np.where(inside(polygon, x, y), 0.0, distance)


def quadrature(polygon: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places x, y inside a polygon and their weights (areas): midpoints, along rows cut exactly.

    Rows begin and end at the corners of the polygon, so that the rule is of second order.
    """
    # strips between corners: within one, no edge of the polygon begins or ends
    levels = np.unique(polygon[:, 1])
    places = []
    for low, high in pairwise(levels.tolist()):
        rows = max(int(np.ceil((high - low) / step)), 1)
        for y in low + (high - low) * (np.arange(rows) + 0.5) / rows:
            places += _row(polygon, float(y), (high - low) / rows, step)
    if not places:
        return np.empty(0), np.empty(0), np.empty(0)
    x, y, weight = np.concatenate(places, axis=1)
    return x, y, weight


def _row(polygon: np.ndarray, y: float, height: float, step: float) -> list[np.ndarray]:
    """Places and weights (3, n) of one row, for each part of it that is inside."""
    crossings = sorted(
        x0 + (y - y0) * (x1 - x0) / (y1 - y0)
        for (x0, y0), (x1, y1) in _edges(polygon)
        if (y0 <= y) != (y1 <= y)
    )
    parts = []

    # inside is between the first and the second crossing, the third and the fourth ...
    for west, east in zip(crossings[::2], crossings[1::2], strict=True):
        n = max(int(np.ceil((east - west) / step)), 1)
        x = west + (east - west) * (np.arange(n) + 0.5) / n
        parts.append(np.stack([x, np.full(n, y), np.full(n, height * (east - west) / n)]))
    return parts


def _edges(polygon: np.ndarray) -> list[tuple[list[float], list[float]]]:
    closed = polygon[:, :2].tolist()
    return list(pairwise([*closed, closed[0]]))


# ---- cutoffs ----------------------------------------
# Cut-off lines and throw of the field, sector by sector.


ALONG = 5.0  # between points of a line [m]
MARGIN = 200.0  # of lines beyond the grids [m]
MOST_ROUNDS = 60
CLOSE = 1e-9  # [m]

Signs = tuple[int, ...]


class Wall(NamedTuple):
    """A wall of a fault in one sector: places of its cut-off, and where the sector exists."""

    signs: Signs
    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    there: np.ndarray


@lru_cache(maxsize=128)
def walls(
    geology: Geology, horizon: Horizon, name: str, sign: int
) -> tuple[np.ndarray, list[Wall]]:
    """Distances along strike, and the cut-offs of a wall (1 hanging, -1 foot) in each sector."""
    fault, which = geology.faults[name], list(geology.faults).index(name)
    first, last = reach(fault, MARGIN)
    s = np.linspace(first, last, int((last - first) / ALONG) + 1)
    cutoffs = []

    # one line for each sector that touches this wall
    for signs in _relevant(geology, horizon, name, s):
        if signs[which] != sign:
            continue
        x, y, z = _meeting(geology, horizon, name, signs, s)

        # 0 for the fault itself: on its own plane the side is undecided
        others = tuple(0 if k == which else v for k, v in enumerate(signs))
        cutoffs.append(Wall(signs, x, y, z, exists(geology.faults, others, x, y, z)))
    return s, cutoffs


def cutoff_line(
    geology: Geology, horizon: Horizon, name: str, wall: str
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Distance along strike, x, y, z of a cut-off line wherever its wall exists."""
    s, sectors = walls(geology, horizon, name, 1 if wall == "+" else -1)

    # sectors take turns along the fault; sorted by s they make one line
    parts = [np.stack([s, w.x, w.y, w.z])[:, w.there] for w in sectors]
    line = np.concatenate(parts, axis=1)
    s, x, y, z = line[:, np.argsort(line[0], kind="stable")]
    return s, x, y, z


def throw_line(geology: Geology, horizon: Horizon, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Throw at distances along strike; NaN where the walls are not in the same sector."""
    s, hanging = walls(geology, horizon, name, 1)
    which = list(geology.faults).index(name)
    throw = np.full(len(s), np.nan)
    for foot in walls(geology, horizon, name, -1)[1]:
        for hang in hanging:
            # a footwall and a hanging wall face each other if they agree on all other faults; 0 is
            # no side
            pairs = [
                p for k, p in enumerate(zip(foot.signs, hang.signs, strict=True)) if k != which
            ]
            if all(a == b or not a or not b for a, b in pairs):
                both = foot.there & hang.there
                throw = np.where(both, foot.z - hang.z, throw)
    return s, throw


def _relevant(geology: Geology, horizon: Horizon, name: str, s: np.ndarray) -> list[Signs]:
    """Sectors that differ along a fault: others that die elsewhere move nothing there."""
    fault = geology.faults[name]
    x, y = fault.place(s, fault.across(s, horizon.level))
    near = []

    # faults that are far away do not split the sheets of this one: fewer sectors to solve
    for key, other in geology.faults.items():
        along, r = other.along_across(x, y)
        close = (np.abs(along) < other.half + MARGIN) & (np.abs(r) < other.half + 2 * MARGIN)
        near.append(key == name or bool(close.any()))
    signs = [
        tuple(v if here else 0 for v, here in zip(row, near, strict=True))
        for row in geology.sectors
    ]
    return list(dict.fromkeys(signs))


def _meeting(
    geology: Geology, horizon: Horizon, name: str, signs: Signs, s: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where a fault meets the sheet of a sector: the slope of both makes a contraction."""
    fault = geology.faults[name]
    z = np.full(len(s), horizon.level)

    # fixed point: fault at this elevation, sheet there, and again; the sheet is much flatter than
    # the fault
    for _ in range(MOST_ROUNDS):
        x, y = fault.place(s, fault.across(s, z))
        last, z = z, geology.sheet(horizon, signs, x, y)
        if np.abs(z - last).max() < CLOSE:
            return x, y, z
    raise AssertionError(f"cut-offs of {horizon.name} at {name} do not converge")


@dataclass(frozen=True, eq=False)
class FieldTruth:
    """What is true of a field that `field_export` wrote; metres, elevation positive up.

    Attributes
    ----------
    variant : str
    files : mapping of str to pathlib.Path
        By the name of the horizon or fault; ``"outline"`` and ``"scenario"``, too.
    horizons, faults : tuple of str
        Horizons youngest first.
    missing : mapping of str to mapping of str to float
        By how much faults were picked too short [m]: ``{"F1": {"down": 30.0}, ...}``. ``"up"``
        and ``"down"``: between the end of the sticks and the farthest horizon; ``"start"`` and
        ``"end"``, along strike by the right-hand rule: between sticks and the main fault.
    outline : ndarray (n, 2)
        Easting and northing of a polygon inside of which all horizons have data.
    """

    variant: str
    files: Mapping[str, Path]
    geology: Geology = field(repr=False)
    missing: Mapping[str, Mapping[str, float]]

    @property
    def horizons(self) -> tuple[str, ...]:
        """Names of the horizons, youngest first."""
        return tuple(horizon.name for horizon in self.geology.horizons)

    @property
    def faults(self) -> tuple[str, ...]:
        """Names of the faults, main faults first."""
        return tuple(self.geology.faults)

    @property
    def outline(self) -> np.ndarray:
        """A polygon (n, 2) inside of which all horizons have data."""
        return np.stack(to_world(*OUTLINE.T), axis=1)

    def elevation(self, horizon: str, easting: Any, northing: Any) -> np.ndarray:
        """
        Elevation of a horizon at places in the map.

        Parameters
        ----------
        horizon : str
        easting, northing : array_like
            [m]

        Returns
        -------
        ndarray of float64
            [m], positive up; NaN in the gap between the two cut-offs of a fault.

        Raises
        ------
        InputError
            If the horizon is unknown.

        Examples
        --------
        >>> import tempfile
        >>> from geosurf.synthetic import field_export
        >>> truth = field_export(tempfile.mkdtemp())
        >>> float(truth.elevation("Top", 463000.0, 5933000.0).round(1))
        -1743.9
        """
        # formulas are in the frame of the grids
        x, y = np.broadcast_arrays(*to_local(easting, northing))
        highest = np.full(x.shape, np.nan)

        # where sheets overlap (a reverse fault) the highest counts; no sheet, as in a gap, leaves
        # NaN
        for signs, z in self.geology.sheets(self._horizon(horizon), x, y).items():
            there = exists(self.geology.faults, signs, x, y, z)
            highest = np.where(there, np.fmax(highest, z), highest)
        return highest

    def cutoff(self, horizon: str, fault: str, wall: str) -> np.ndarray:
        """
        Cut-off line of a horizon on one wall of a fault, inside the outline.

        Parameters
        ----------
        horizon, fault : str
        wall : {"+", "-"}
            Hanging wall or footwall.

        Returns
        -------
        ndarray (n, 3) of float64
            Easting, northing, elevation [m], every 5 m along strike.

        Raises
        ------
        InputError
            If a name is unknown.

        Examples
        --------
        >>> import tempfile
        >>> from geosurf.synthetic import field_export
        >>> truth = field_export(tempfile.mkdtemp())
        >>> truth.cutoff("Top", "F1", "+").shape[1]
        3
        """
        if wall not in ("+", "-"):
            raise InputError(f'wall is {wall!r}; give "+" (hanging wall) or "-" (footwall).')

        # the line runs past the grids; what is outside the outline is cut off here
        _, x, y, z = cutoff_line(self.geology, self._horizon(horizon), self._fault(fault), wall)
        here = inside(OUTLINE, x, y)
        return np.stack([*to_world(x[here], y[here]), z[here]], axis=1)

    def throw(self, horizon: str, fault: str, easting: Any, northing: Any) -> np.ndarray:
        """
        Throw of a fault at places along it: footwall minus hanging wall, across its mean strike.

        Parameters
        ----------
        horizon, fault : str
        easting, northing : array_like
            Places on the fault or next to it [m], such as the ``stations`` of a `FaultCut`.

        Returns
        -------
        ndarray of float64
            [m]; 0 beyond the tips of a fault. NaN beyond its main fault, and where another fault
            lies between its walls.

        Raises
        ------
        InputError
            If a name is unknown.

        Examples
        --------
        >>> import tempfile
        >>> from geosurf.synthetic import field_export
        >>> truth = field_export(tempfile.mkdtemp())
        >>> east, north, _ = truth.cutoff("Top", "F1", "-").T
        >>> round(float(np.nanmax(truth.throw("Top", "F1", east, north))))
        86
        """
        name = self._fault(fault)

        # read by the distance along the fault, so that places next to it do
        s = self.geology.faults[name].along_across(*to_local(easting, northing))[0]
        throws = np.interp(
            s, *throw_line(self.geology, self._horizon(horizon), name), left=np.nan, right=np.nan
        )
        return np.where(np.abs(s) >= self.geology.faults[name].half, 0.0, throws)

    def volumes(self, area: Any = None, *, step: float = 10.0) -> dict[tuple[str, str], float]:
        """
        Volumes of the zones between horizons, block by block, within an area.

        Each column is divided exactly; columns are added up by a rule of second order.

        Parameters
        ----------
        area : array_like (n, 2), optional
            Polygon of easting and northing [m]. Default: the outline.
        step : float
            Between columns [m].

        Returns
        -------
        dict
            ``{(zone, block): m3}``, for ``scene.units[zone, block].volume``.

        Raises
        ------
        InputError
            If the area is not a polygon.

        Examples
        --------
        >>> import tempfile
        >>> from geosurf.synthetic import field_export
        >>> truth = field_export(tempfile.mkdtemp())
        >>> round(truth.volumes()["Top/Middle", "F1+ F2-"] / 1e6)
        117
        """
        polygon = OUTLINE if area is None else _polygon(area)
        x, y, weight = quadrature(polygon, _positive(step))

        # for each horizon its sheets by sector, each defined everywhere in the map
        sheets = [self.geology.sheets(h, x, y) for h in self.geology.horizons]
        planes = {n: fault_elevation(f, x, y) for n, f in self.geology.faults.items()}
        zones = [f"{upper}/{lower}" for upper, lower in pairwise(self.horizons)]
        totals = {(zone, block.name): 0.0 for zone in zones for block in self.geology.blocks}
        for signs in self.geology.sectors:
            by_name = dict(zip(self.faults, signs, strict=True))

            # the block of the sector in each column: hanging walls lie above their fault, footwalls
            # below
            floor = np.full(x.shape, -np.inf)
            roof = np.full(x.shape, np.inf)
            for name, sign in by_name.items():
                if sign > 0:
                    floor = np.maximum(floor, planes[name])
                elif sign < 0:
                    roof = np.minimum(roof, planes[name])
            block = next(b for b in self.geology.blocks if b.holds(by_name))
            for zone, (upper, lower) in zip(zones, pairwise(sheets), strict=True):
                # each column of each zone, cut by the faults: exact in z, so that only the sum over
                # columns has an error
                top, base = np.minimum(upper[signs], roof), np.maximum(lower[signs], floor)
                totals[zone, block.name] += float((weight * np.maximum(top - base, 0.0)).sum())
        return totals

    def _horizon(self, name: str) -> Horizon:
        return self.geology.horizon(_known(name, "horizon", self.horizons))

    def _fault(self, name: str) -> str:
        return _known(name, "fault", self.faults)


def _known(name: str, kind: str, names: tuple[str, ...]) -> str:
    """A name, or an error where nothing of this kind has it."""
    here = f"no {kind} of the field is called {name!r}; it has {', '.join(names)}."
    check_word(name, names, here)
    return name


def _polygon(area: Any) -> np.ndarray:
    """A polygon in the local frame."""
    try:
        corners = np.asarray(area, dtype=np.float64)
    except (TypeError, ValueError):
        corners = np.empty(0)
    if corners.ndim != 2 or corners.shape[0] < 3 or corners.shape[1] not in (2, 3):
        raise InputError("area takes a polygon of three corners or more: (easting, northing) each.")
    if not np.isfinite(corners).all():
        raise InputError("area has a corner that is not finite; give (easting, northing) each.")
    return np.stack(to_local(corners[:, 0], corners[:, 1]), axis=1)


def _positive(step: float) -> float:
    if not (np.isfinite(step) and step >= 0.1):
        raise InputError(f"step is {step!r}; give metres, 0.1 or more.")
    return float(step)
