"""The field that `field_export` writes: its faults, its horizons, and the frame of its grids.

All formulas use a local frame: x along the columns of the grids, y along their rows, z elevation.
Each side of the faults (a sector) has a smooth sheet of its own, defined everywhere. A horizon is
each sheet on its own side of the faults.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from geosurf.synthetic.torn_horizon import DATUM, Fault, sectors, side_of

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
        found = {}
        for signs in self.sectors:
            pairs = [(name, sign) for name, sign in zip(self.faults, signs, strict=True) if sign]
            found[signs] = base - sum(moves[pair] for pair in pairs)
        return found

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
