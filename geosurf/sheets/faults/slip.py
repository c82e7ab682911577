"""How much throw a fault has, and how its walls move along it.

A particle of the hanging wall goes down by its throw, and in the map as the line down the dip of
the fault does between the elevation that it leaves and the one that it comes to. On a plane that is
a translation; on any fault, what lay on it stays on it, so that a block neither detaches nor sinks
in, and the throw between both cut-offs, along such a line, is the throw that was requested.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from geosurf.conventions import (
    CONVERSION_ERRORS,
    is_number,
)
from geosurf.errors import InputError
from geosurf.kernels.sheets.moved_rock import move_rock
from geosurf.sheets.faults.dip_lines import STEPS, DipLines
from geosurf.sheets.faults.fault_profile import Section

_STRAIGHT = np.empty((0, 0))  # slopes of lines that run across the mean strike

# throw [m] at distances along strike, elevations, and places (easting, northing)
Amount = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class EllipticThrow:
    """
    Throw of a fault that dies at its tip line: contours of equal throw are ellipses.

    Parameters
    ----------
    largest : float
        Throw at the centre [m]; below 0 for a reverse fault.
    half_length : float, optional
        From the centre to the tips along strike [m]. Default: half of the fault's length at each
        elevation.
    half_height : float, optional
        From the centre to the upper and the lower tip, vertically [m]. Default: throw does not
        change with elevation.
    centre : (float or None, float or None), optional
        Distance along strike from the fault's first end, by the right-hand rule, and elevation [m].
        Default: the middle of the fault, along strike at each elevation.

    Notes
    -----
    At a share q of the way from the centre to the tip line, throw is
    ``largest * 2 (1 - q) sqrt(((1 + q) / 2)**2 - q**2)`` (Walsh & Watterson 1987, J. Struct. Geol.
    9, 1039-1046).

    Examples
    --------
    >>> import numpy as np
    >>> field = EllipticThrow(60.0, half_length=500.0, centre=(500.0, None))
    >>> along = np.array([0.0, 250.0, 500.0])
    >>> field.at(along, np.zeros(3)).round(1).tolist()
    [0.0, 33.5, 60.0]
    """

    largest: float
    half_length: float | None = None
    half_height: float | None = None
    centre: tuple[float | None, float | None] = (None, None)

    def __post_init__(self) -> None:
        for key in ("half_length", "half_height"):
            value = getattr(self, key)
            if value is not None and not (is_number(value) and value > 0):
                raise InputError(
                    f"{key} of an elliptic throw is {value!r}, expected metres above 0."
                )
        self._check_centre()
        if not is_number(self.largest):
            raise InputError(f"largest of an elliptic throw is {self.largest!r}, expected metres.")

    def _check_centre(self) -> None:
        """Distance along strike and elevation; either may be left to the fault."""
        try:
            centre = tuple(self.centre)
        except (TypeError, ValueError, *CONVERSION_ERRORS):
            centre = ()
        if len(centre) != 2 or not all(one is None or is_number(one) for one in centre):
            raise InputError(
                f"centre of an elliptic throw is {self.centre!r}; give distance along strike and "
                "elevation [m], None for the middle of the fault."
            )
        object.__setattr__(self, "centre", centre)

    def at(self, s: np.ndarray, z: np.ndarray, section: Section | None = None) -> np.ndarray:
        """Throw [m] at distances along strike and elevations; sizes left out are a fault's."""
        # what was left out is taken from the fault at each elevation, so that throw dies at its
        # ends
        middle, level = self.centre
        half = self.half_length
        if section is not None:
            first, last = section.extent(z)
            middle = 0.5 * (first + last) if middle is None else middle
            half = 0.5 * (last - first) if half is None else half
            level = float(section.z.mean()) if level is None else level
        if half is None or middle is None or (level is None and self.half_height is not None):
            raise InputError(
                "this elliptic throw takes its size from a fault. Give half_length and centre."
            )
        off = np.abs(s - middle)
        # where the fault has no length, as above its upper tip, throw has died
        q2 = np.divide(off, half, out=np.ones_like(off), where=off < half) ** 2
        if self.half_height is not None:
            q2 = q2 + ((z - level) / self.half_height) ** 2
        q = np.sqrt(np.minimum(q2, 1.0))
        found: np.ndarray = (
            self.largest * 2.0 * (1.0 - q) * np.sqrt(np.maximum((0.5 + 0.5 * q) ** 2 - q * q, 0.0))
        )
        return found


@dataclass(frozen=True)
class EvenThrow:
    """The same throw everywhere [m]."""

    value: float

    @property
    def everywhere(self) -> np.ndarray:
        """One value (1,) that stands for all."""
        return np.array([self.value])

    def __call__(self, s: np.ndarray, z: np.ndarray, xy: np.ndarray) -> np.ndarray:
        """Throw (n,) at places."""
        return np.full(s.shape, self.value)


@dataclass(frozen=True, eq=False)
class Slip:
    """Movement along one fault.

    Attributes
    ----------
    section : Section
    amount : callable
    reach : float
        Distance across strike over which movement dies away from the fault [m]; may be infinite.
    share : float
        Part of the throw that the hanging wall takes; the footwall rises by the remainder.
    lines : DipLines or None
        Ways down its dip, along which its walls move; None: across its mean strike.
    """

    section: Section
    amount: Amount
    reach: float = np.inf
    share: float = 1.0
    lines: DipLines | None = None

    def move(
        self, xy: np.ndarray, z: np.ndarray, part: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Places and elevations after the movement, which is `part` of the throw, down.

        That is `share` in the hanging wall, and ``share - 1`` in the footwall, which rises.
        """
        if not part.any():
            return xy, z
        section = self.section
        lines = _STRAIGHT if self.lines is None else self.lines.table
        if isinstance(self.amount, EvenThrow):
            throw = self.amount.everywhere
        else:
            s, _ = section.of(xy)
            throw = self.amount(np.clip(s, 0.0, section.length), z, xy)
        moved, lower = np.empty_like(xy), np.empty_like(z)
        move_rock(
            section.axes, section.first, section.table.ravel(), *section.table.shape,
            section.shape, lines.ravel(), *lines.shape, STEPS, self.reach,
            xy, z, part, throw, moved, lower,
        )  # fmt: skip
        return moved, lower

    def along(self, s: np.ndarray, z: np.ndarray, to: np.ndarray, steps: int = STEPS) -> np.ndarray:
        """Where the lines down dip through places (s, z) are along strike at elevations `to`."""
        return s if self.lines is None else self.lines.moved(s, z, to, steps)

    def extremes(self, low: float, high: float) -> tuple[float, float]:
        """Largest throw and largest heave, by size, between two elevations [m]."""
        # sampled at 257 places along strike and 33 levels: reach, blends and limits follow from it
        s = np.linspace(0.0, self.section.length, 257)
        z = np.linspace(low, high, 33)
        s, z = (a.ravel() for a in np.meshgrid(s, z))
        here = self.section.across(s, z)
        throw = self.amount(s, z, self.section.places(s, here))
        heave = self.section.across(s, z - throw) - here
        return float(np.abs(throw).max()), float(np.abs(heave).max())
