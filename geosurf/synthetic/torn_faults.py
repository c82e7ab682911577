"""Faults of worlds with a torn horizon: traces, throw profiles, and the worlds that have a name."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from geosurf.conventions import did_you_mean
from geosurf.errors import InputError

DATUM = -1800.0
STEP = 25.0
DYING = ("parabola", "ellipse", "bell")
PROFILES = (*DYING, "constant", "scissors")


@dataclass(frozen=True)
class Fault:
    """One fault of a torn world: places in m, angles in degrees.

    `strike` with the dip to its right; `half` its half length (inf: through-going); `throw` at
    its centre, negative for reverse; `profile`: of the throw along strike, "parabola", "ellipse",
    "bell" (not that of a crack), "constant" or "scissors"; `flatten` bends it with depth [1/m];
    `branch`: the main fault and the side of it on which this one is.
    """

    x: float
    y: float
    strike: float = 20.0
    dip: float = 60.0
    half: float = 700.0
    throw: float = 60.0
    profile: str = "parabola"
    flatten: float = 0.0
    wave: float = 20.0
    branch: tuple[str, int] | None = None

    def __post_init__(self) -> None:
        if self.profile not in PROFILES:
            raise InputError(
                f"profile of a torn world's fault is {self.profile!r}; it must be one of "
                f"{', '.join(PROFILES)}.{did_you_mean(str(self.profile), PROFILES)}"
            )
        if self.profile in DYING and not np.isfinite(self.half):
            raise InputError(
                f"a torn world's fault has no end (half = {self.half}), but its throw, of profile "
                f"{self.profile!r}, dies there. Give half in metres, or another profile."
            )

    def along_across(self, x: Any, y: Any) -> tuple[Any, Any]:
        """Coordinates along strike and across it, down dip."""
        # x = s sin(strike) + r cos(strike), y = s cos(strike) - r sin(strike): strike is clockwise
        # from north.
        a = np.radians(self.strike)
        dx, dy = x - self.x, y - self.y
        return dx * np.sin(a) + dy * np.cos(a), dx * np.cos(a) - dy * np.sin(a)

    def place(self, s: Any, r: Any) -> tuple[Any, Any]:
        """The inverse of `along_across`."""
        a = np.radians(self.strike)
        return self.x + s * np.sin(a) + r * np.cos(a), self.y + s * np.cos(a) - r * np.sin(a)

    def across(self, s: Any, z: Any) -> Any:
        """Where the fault is, across strike, at a place along it and an elevation."""
        # The cotangent of the dip is heave per depth; `flatten` makes it grow with depth.
        down = DATUM - z
        cot = 0.0 if self.dip == 90 else 1.0 / np.tan(np.radians(self.dip))
        return self.wave * np.sin(s / 450.0) + down * (cot + self.flatten * (down + 300.0))

    def moved(self, s: Any, r: Any, sign: int, level: float) -> Any:
        """How far a wall (+1 hanging) has gone down at places along and across [m]."""
        # each wall moves by half: the fault stays where it is, and the trace does not depend on
        # throw
        half = 0.5 * self.throw
        if self.profile == "constant":
            return sign * half * np.ones_like(s)
        if self.profile == "scissors":
            return sign * half * s / 1000.0

        # distance from the trace at this level, in half lengths: the crack is straight in these
        # coordinates
        away = (r - np.interp(s, *trace(self, level))) / self.half
        if self.profile == "bell":  # no crack: both walls die away as they do along strike
            dies = np.maximum(1.0 - (s / self.half) ** 2, 0.0) ** 2
            return sign * half * dies * np.exp(-2.0 * away**2)
        return sign * half * displacement(self.profile, s / self.half, sign * away)


@lru_cache(maxsize=32)
def trace(fault: Fault, level: float) -> tuple[np.ndarray, np.ndarray]:
    """Where, across strike, a fault meets the horizon as it was before: along and across [m]."""
    s = np.arange(-2.5 * fault.half, 2.5 * fault.half + 1.0, 0.25)  # linear between, to 1e-8 m

    # Bisection: elevations above the horizon come down, others go up; 60 halvings reach rounding.
    low, high = np.full(len(s), DATUM - 330.0), np.full(len(s), DATUM + 330.0)
    for _ in range(60):
        z = 0.5 * (low + high)
        above = z > relief(*fault.place(s, fault.across(s, z))) + level
        low, high = np.where(above, low, z), np.where(above, z, high)
    return s, fault.across(s, z)


def displacement(profile: str, s: Any, r: Any) -> Any:
    """Share of half the largest throw by which a wall moves, next to a fault from s = -1 to 1.

    The real part of an analytic function of s + i r: harmonic, 0 far away and straight on past
    the tips, and on the fault (r = 0) the square root of 1 - s^2 (``"ellipse"``, a crack in
    anti-plane shear, Pollard & Segall 1987) or 1 - s^2 itself (``"parabola"``). The wall is on
    the side where r > 0, and goes on analytically past the fault.
    """
    inside = np.abs(s) < 1.0
    side = np.where(inside | (r >= 0), 1.0, -1.0)  # past the tips both walls are one
    tiny = np.finfo(np.float64).tiny
    zeta = s + 1j * np.where(inside, r, np.maximum(np.abs(r), tiny))
    # On the fault (r = 0) this is sqrt(1 - s^2), an ellipse.
    if profile == "ellipse":
        found = np.sqrt(1.0 - zeta * zeta).real - zeta.imag
        return side * found

    # On the fault this is 1 - s^2, a parabola; beyond the tips its limit is 0.
    # log is singular at both tips, where the product with 1 - zeta^2 is 0: replaced below
    with np.errstate(divide="ignore", invalid="ignore"):
        log = np.where(
            inside,
            np.log(1.0 + zeta) - np.log(1.0 - zeta) - 1j * np.pi,
            np.log((zeta + 1.0) / (zeta - 1.0)),
        )
        found = -((1.0 - zeta * zeta) * log + 2.0 * zeta).imag / np.pi
    return side * np.where(np.abs(zeta * zeta - 1.0) > 0, found, 0.0)


def named_faults(side: float) -> dict[str, dict[str, Fault]]:
    """Faults of each kind of world, for a square of a given side."""
    c = 0.5 * side
    through: dict[str, Any] = {"half": np.inf, "profile": "constant"}
    return {
        "normal": {"F1": Fault(c, c)},
        "gentle": {"F1": Fault(c, c, dip=35.0)},
        "vertical": {"F1": Fault(c, c, dip=90.0)},
        "ellipse": {"F1": Fault(c, c, profile="ellipse")},
        "through": {"F1": Fault(c, c, **through)},
        "listric": {"F1": Fault(c, c, dip=55.0, flatten=4e-4)},
        "scissors": {"F1": Fault(c, c, half=np.inf, profile="scissors")},
        "reverse": {"F1": Fault(c, c, dip=45.0, throw=-60.0)},
        "thrust": {"F1": Fault(c, c, dip=30.0, throw=-100.0)},
        "Y": {
            "F1": Fault(c, c, **through),
            "F2": Fault(c, c, strike=95.0, throw=40.0, branch=("F1", -1), **through),
        },
        "X": {
            "F1": Fault(c, c, dip=70.0, **through),
            "F2": Fault(c, c, strike=100.0, dip=70.0, throw=40.0, **through),
        },
        "acute Y": {
            "F1": Fault(c, c, **through),
            "F2": Fault(c, c, strike=40.0, throw=40.0, branch=("F1", -1), **through),
        },
        "acute X": {
            "F1": Fault(c, c, dip=70.0, **through),
            "F2": Fault(c, c, strike=42.0, dip=70.0, throw=40.0, **through),
        },
        "parallel": {
            "F1": Fault(c - 2.2 * STEP, c, strike=12.0, dip=80.0, wave=0.0, **through),
            "F2": Fault(c + 2.2 * STEP, c, strike=12.0, dip=80.0, wave=0.0, throw=40.0, **through),
        },
    }


def relief(x: Any, y: Any) -> Any:
    """The horizon before it was faulted [m]."""
    # a broad relief and a finer oblique one, so that no axis of the grid is special
    k, m = 2 * np.pi / 4000.0, 2 * np.pi / 1200.0
    broad = 60.0 * np.sin(k * x + 0.3) * np.cos(k * y - 0.4)
    return DATUM + broad + 15.0 * np.sin(m * (0.8 * x + 0.6 * y))


def sectors(faults: dict[str, Fault]) -> list[tuple[int, ...]]:
    """Sides of all faults, 0 for a branch on the side of its main fault where it is not."""
    names = list(faults)
    found = []

    # A branch ends at its main fault: beyond it, its two sides are one.
    for signs in itertools.product((1, -1), repeat=len(names)):
        # off: the sign of the main fault is not the side that the branch is on
        branch = [faults[name].branch for name in names]
        off = [b is not None and signs[names.index(b[0])] != b[1] for b in branch]
        signs = tuple(0 if gone else s for s, gone in zip(signs, off, strict=True))
        if signs not in found:
            found.append(signs)
    return found


def side_of(fault: Fault, x: Any, y: Any, z: Any) -> Any:
    """Return on which side of a fault places are: 1 hanging wall, -1 footwall."""
    s, r = fault.along_across(x, y)
    return np.where(r > fault.across(s, z), 1, -1)


def exists(
    faults: Mapping[str, Fault], signs: Sequence[int], x: np.ndarray, y: np.ndarray, z: np.ndarray
) -> np.ndarray:
    """Where a sheet is on its own side of all faults; beyond tips all sheets are one."""
    there = np.ones(np.shape(x), dtype=bool)

    # 0: the sector does not touch this fault
    for fault, sign in zip(faults.values(), signs, strict=True):
        if sign:
            there &= side_of(fault, x, y, z) == sign
    return there
