"""Throw in any form that users give -> throw at places along a fault, and its slip."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from geosurf.conventions import (
    HORIZON_DIMS,
    is_number,
    metres_per_unit,
    real_numbers,
)
from geosurf.errors import InputError
from geosurf.sheets.faults.fault_profile import Section
from geosurf.sheets.faults.slip import Amount, EllipticThrow, EvenThrow, Slip


def slips_of(
    throw: Mapping[str, Any],
    sections: Mapping[str, Section],
    corner: np.ndarray,
    reach: Any,
    hanging_wall: Any,
) -> list[Slip]:
    """Movements in the order of `throw`, which is from the youngest to the oldest."""
    found = []
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
        found.append(Slip(section, amount, np.inf if far is None else float(far), float(share)))
    return found


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
        return EvenThrow(float(values))
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
    found = np.asarray(function(s), dtype=np.float64)
    if found.shape not in (s.shape, ()):
        raise InputError(
            f"{what}: the function gave shape {found.shape} for distances of shape {s.shape}. Let "
            "it return one throw for each distance."
        )
    bad = np.flatnonzero(~np.isfinite(np.broadcast_to(found, s.shape)))
    if len(bad):
        raise InputError(
            f"{what}: the function is not finite at {s[bad[0]]:.3f} m along strike. Let it be 0 "
            "where the fault has no throw."
        )
    return np.broadcast_to(found, s.shape)


def _profile_of(given: Any, what: str) -> tuple[np.ndarray, np.ndarray]:
    """Distances and throws of a DataArray over distance along strike [m]."""
    name = "along_strike"
    if given.ndim != 1 or (name not in given.coords and given.dims[0] not in given.coords):
        raise InputError(
            f"{what} has dimensions {tuple(map(str, given.dims))}; expected a map over northing "
            f"and easting, or a profile with coordinate {name!r}."
        )
    along = given[name] if name in given.coords else given[given.dims[0]]
    found = [_metres_of(part, what) for part in (along, given)]
    return found[0], found[1]


def _metres_of(part: Any, what: str) -> np.ndarray:
    """Values of a DataArray [m]."""
    factor = metres_per_unit(part.attrs.get("units", "m"), what)
    try:
        return real_numbers(part.values) * factor
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{what}: {part.name or 'values'} have dtype {part.dtype}, expected metres. Convert "
            "them to float."
        ) from error


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
    values = _metres_of(grid, what)
    if min(values.shape) < 2 or not np.isfinite(values).all():
        raise InputError(
            f"{what}: a map needs 2 x 2 finite values or more, this is {values.shape[0]} x "
            f"{values.shape[1]}. Fill it with 0 where there is no throw."
        )
    axes = [_metres_of(grid[key], what) - corner[k] for k, key in enumerate(HORIZON_DIMS[::-1])]
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
        found: np.ndarray = low * (1.0 - g) + high * g
        return found

    return amount
