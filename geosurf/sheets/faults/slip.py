"""How much throw a fault has, and how its walls move along it.

A particle of the hanging wall goes down by its throw, and in the map as the line down the dip of
the fault does between the elevation that it leaves and the one that it comes to. On a plane that is
a translation; on any fault, what lay on it stays on it, so that a block neither detaches nor sinks
in, and the throw between both cut-offs, along such a line, is the throw that was requested.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.conventions import CONVERSION_ERRORS, HORIZON_DIMS, is_number, metres_of, real_numbers
from geosurf.errors import InputError
from geosurf.kernels.sheets.moved_rock import move_rock
from geosurf.sheets.faults.fault_profile import STEPS, DipLines, Section

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
        return (
            self.largest * 2.0 * (1.0 - q) * np.sqrt(np.maximum((0.5 + 0.5 * q) ** 2 - q * q, 0.0))
        )


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
        s, _ = section.of(xy)
        throw = self.amount(np.clip(s, 0.0, section.length), z, xy)
        moved, lower = np.empty_like(xy), np.empty_like(z)
        move_rock(
            section.axes, section.table, section.shape, lines, STEPS, self.reach,
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


# ---- given throw ----------------------------------------
# Throw in any form that users give -> throw at places along a fault, and its slip.


def slips_of(
    throw: Mapping[str, Any],
    sections: Mapping[str, Section],
    corner: np.ndarray,
    reach: Any,
    hanging_wall: Any,
) -> list[Slip]:
    """Movements in the order of `throw`, which is from the youngest to the oldest."""
    slips = []
    for name, given in throw.items():
        far = reach.get(name) if isinstance(reach, Mapping) else reach
        if far is not None and not (is_number(far) and far > 0):
            raise InputError(f"reach of {name!r} is {far!r}, expected metres above 0, or None.")
        share = hanging_wall.get(name, 1.0) if isinstance(hanging_wall, Mapping) else hanging_wall
        if not (is_number(share) and 0.0 <= share <= 1.0):
            raise InputError(
                f"hanging_wall is {share!r}, expected the part of the throw that the hanging wall "
                "takes, 0 to 1."
            )
        section = sections[name]
        amount = amount_of(given, section, corner)
        slips.append(Slip(section, amount, np.inf if far is None else float(far), float(share)))
    return slips


def amount_of(given: Any, section: Section, corner: np.ndarray) -> Amount:
    """
    Throw in any form, as a function.

    Parameters
    ----------
    given : float, EllipticThrow, callable, array_like (n, 2) or xarray.DataArray
    section : Section
    corner : ndarray (2,)
        Easting and northing that places are counted from [m].

    Returns
    -------
    callable

    Raises
    ------
    InputError
        If it is in none of these forms, or has values that are not finite.
    """
    what = f"throw of {section.name!r}"
    if isinstance(given, EllipticThrow):
        return lambda s, z, xy: given.at(s, z, section)
    if callable(given) and not hasattr(given, "dims"):
        return lambda s, z, xy: _called(given, s, what)

    # a DataArray: its dimensions say whether it is a map or a profile
    if hasattr(given, "dims"):
        if {"northing", "easting"} <= set(given.dims):
            return _of_map(given, corner, what)
        return _of_profile(*_profile_of(given, what), what)
    try:  # numpy would read a number from text
        values = real_numbers(None if isinstance(given, str | bytes) else given)
    except (TypeError, ValueError):
        values = np.empty((0, 0, 0))
    if values.ndim == 0 and np.isfinite(values) and not isinstance(given, bool):
        return lambda s, z, xy: np.full(s.shape, float(values))
    if values.ndim == 2 and values.shape[1] == 2 and len(values):
        return _of_profile(values[:, 0], values[:, 1], what)
    raise InputError(
        f"{what} is {_short(given)}; give metres, an array (n, 2) of distance along strike and "
        "throw, a function of the distance, a DataArray, or an EllipticThrow."
    )


def _short(given: Any) -> str:
    words = repr(given)
    return words if len(words) < 60 else f"a {type(given).__name__}"


def _called(function: Callable, s: np.ndarray, what: str) -> np.ndarray:
    """Throw from a user's function, checked."""
    throw = np.asarray(function(s), dtype=np.float64)
    if throw.shape not in (s.shape, ()):
        raise InputError(
            f"{what}: the function gave shape {throw.shape} for distances of shape {s.shape}. Let "
            "it return one throw for each distance."
        )
    bad = np.flatnonzero(~np.isfinite(np.broadcast_to(throw, s.shape)))
    if len(bad):
        raise InputError(
            f"{what}: the function is not finite at {s[bad[0]]:.3f} m along strike. Let it be 0 "
            "where the fault has no throw."
        )
    return np.broadcast_to(throw, s.shape)


def _profile_of(given: Any, what: str) -> tuple[np.ndarray, np.ndarray]:
    """Distances and throws of a DataArray over distance along strike [m]."""
    name = "along_strike"
    if given.ndim != 1 or (name not in given.coords and given.dims[0] not in given.coords):
        raise InputError(
            f"{what} has dimensions {tuple(map(str, given.dims))}; expected a map over northing "
            f"and easting, or a profile with coordinate {name!r}."
        )
    along = given[name] if name in given.coords else given[given.dims[0]]
    found = [metres_of(part, what) for part in (along, given)]
    return found[0], found[1]


def _of_profile(s: np.ndarray, throw: np.ndarray, what: str) -> Amount:
    """Linear between distances along strike, constant beyond them."""
    if not (np.isfinite(s).all() and np.isfinite(throw).all()):
        raise InputError(f"{what}: a profile has values that are not finite. Leave such rows out.")
    back = np.flatnonzero(np.diff(s) < 0)
    if len(back):
        raise InputError(
            f"{what}: distances along strike fall from {s[back[0]]:g} to {s[back[0] + 1]:g} m at "
            f"row {back[0] + 1}. Sort the profile along the strike."
        )
    return lambda at, z, xy: np.interp(at, s, throw)


def _of_map(given: Any, corner: np.ndarray, what: str) -> Amount:
    """Bilinear on a map, by the place in the map; constant beyond its rim."""
    if given.ndim != 2 or any(key not in given.coords for key in HORIZON_DIMS):
        raise InputError(
            f"{what} has dimensions {tuple(map(str, given.dims))} and coordinates "
            f"{sorted(map(str, given.coords))}; a map has northing and easting [m] as both."
        )
    grid = given.transpose(*HORIZON_DIMS).sortby(list(HORIZON_DIMS))
    values = metres_of(grid, what)
    if min(values.shape) < 2 or not np.isfinite(values).all():
        raise InputError(
            f"{what}: a map needs 2 x 2 finite values or more, this is {values.shape[0]} x "
            f"{values.shape[1]}. Fill it with 0 where there is no throw."
        )
    axes = [metres_of(grid[key], what) - corner[k] for k, key in enumerate(HORIZON_DIMS[::-1])]
    for key, axis in zip(HORIZON_DIMS[::-1], axes, strict=True):
        if not (np.diff(axis) > 0).all():
            raise InputError(
                f"{what}: {key} of the map repeats, or is not finite. Keep one row of each with "
                f"da.drop_duplicates({key!r})."
            )

    def amount(s: np.ndarray, z: np.ndarray, xy: np.ndarray) -> np.ndarray:
        """Throw [m] at places in the map (n, 2)."""
        # i, j: row and column below each place; g, f: shares of the next ones
        places = (
            np.interp(x, axis, np.arange(len(axis))) for x, axis in zip(xy.T, axes, strict=True)
        )
        (j, f), (i, g) = (np.divmod(place, 1.0) for place in places)
        i, j = i.astype(np.int64), j.astype(np.int64)

        # on the last row and column the next one is the same, with a share of 0
        up, on = np.minimum(i + 1, len(axes[1]) - 1), np.minimum(j + 1, len(axes[0]) - 1)
        low = values[i, j] * (1.0 - f) + values[i, on] * f
        high = values[up, j] * (1.0 - f) + values[up, on] * f
        return low * (1.0 - g) + high * g

    return amount
