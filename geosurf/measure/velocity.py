"""Velocities of zones: how time becomes depth along a vertical line, and back.

Inside, time is what elevation is elsewhere: minus milliseconds, so that up is up. A point lies
below a start, a place of which both are known; the velocity of the rock between leads from one to
the other.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from geosurf.conventions import check_name, check_word, is_number, is_word, known_names
from geosurf.errors import InputError
from geosurf.model.base import Noun
from geosurf.model.lattice import Lattice

SLOWEST = 20.0  # of velocities [m/s]: what is slower was given in km/s
WAYS = {"two-way": 0.0005, "one-way": 0.001}  # seconds on the way down for each millisecond
ELSEWHERE = "elsewhere"
DATUM = "datum"
WELLS = "wells"
TOPS = "tops"  # in place of checkshots: depths of well tops, and times of their horizons there
COLUMNS = ("well", "easting", "northing", "depth", "time")
HOW = (
    'Write velocity={"above Top": 2000.0, "Top/Base": {"v0": 1800.0, "k": 0.6}, "elsewhere": '
    '3000.0} in m/s; a value may be a map, and "wells" takes checkshots or "tops"'
)


def time_word(time: Any) -> str | None:
    """Return how times count, or None; raise an error for another word."""
    if time is None or is_word(time, WAYS):
        return time
    raise InputError(
        f'time is {time!r}. Write time="two-way" if horizons and faults are in two-way time, '
        'time="one-way" if they are in one-way time, and leave it out if they are in depth.'
    )


class Scaled(NamedTuple):
    """A velocity as users write it, times a factor."""

    value: Any
    factor: float


def unscaled(value: Any) -> tuple[Any, float]:
    """Return a velocity as users write it, and its factor."""
    return value if isinstance(value, Scaled) else (value, 1.0)


def scaled(velocity: Any, factors: Mapping[str, float]) -> dict[str, Any]:
    """Return velocities, some times a factor."""
    entries = velocity if is_by_name(velocity) else {ELSEWHERE: velocity}
    return {k: Scaled(v, factors[k]) if k in factors else v for k, v in entries.items()}


@dataclass(frozen=True, eq=False)
class Field(Noun):
    """Values over the map: the same everywhere, those of a map, or those of wells.

    Attributes
    ----------
    value : float, Lattice or (ndarray (n, 2), ndarray (n,))
        A map is bilinear between its nodes; beyond it, and where it has none, the nearest value
        counts. Values of wells count by the inverse square of the distance: exact at wells, and
        between the lowest and the highest.
    factor : float
        Of all values.
    """

    value: Any
    factor: float = 1.0

    @property
    def smallest(self) -> float:
        """The smallest value."""
        value = self.value[1] if isinstance(self.value, tuple) else self.value
        values = value.elevation if isinstance(value, Lattice) else value
        return self.factor * float(np.nanmin(values))

    def at(self, places: np.ndarray) -> np.ndarray:
        """Values at places (n, 2) in world coordinates."""
        return self.factor * self._at(places)

    def _at(self, places: np.ndarray) -> np.ndarray:
        if isinstance(self.value, Lattice):
            return _bilinear(self.value, places)
        if isinstance(self.value, tuple):
            wells, values = self.value
            square = ((places[:, None] - wells[None]) ** 2).sum(axis=2)
            weights = 1.0 / np.maximum(square, 1e-12)
            return weights @ values / weights.sum(axis=1)
        return np.full(len(places), float(self.value))


def _bilinear(lattice: Lattice, places: np.ndarray) -> np.ndarray:
    """Values of a map at places (n, 2); the nearest ones where it has none."""
    from scipy.ndimage import distance_transform_edt, map_coordinates

    x, y, values = lattice.easting, lattice.northing, lattice.elevation
    lacking = np.isnan(values)
    if lacking.any():
        near = distance_transform_edt(lacking, return_distances=False, return_indices=True)
        values = values[tuple(near)]
    if x.ndim == 1:
        at = []
        for axis, along in ((y, places[:, 1]), (x, places[:, 0])):
            order = np.argsort(axis)
            at.append(np.interp(along, axis[order], np.arange(float(len(axis)))[order]))
    else:
        steps = lattice.map_frame.columns_and_rows("velocity")
        at = [*((places - [x[0, 0], y[0, 0]]) @ steps).T[::-1]]
    return map_coordinates(values, at, order=1, mode="nearest")


@dataclass(frozen=True, eq=False)
class Law(Noun):
    """The velocity of a zone: v = v0 + k z, z the depth below the datum; k is 0 for most.

    Attributes
    ----------
    v0 : Field
        [m/s]
    k : float
        [1/s]
    base : str or None
        The horizon below, if `v0` is the average velocity from the datum to it: the zone then has
        the interval velocity that follows.
    """

    v0: Field
    k: float = 0.0
    base: str | None = None

    def same_as(self, other: Law) -> bool:
        """Whether velocities of both are the same: nothing changes where rock does."""
        mine, others = self.v0.value, other.v0.value
        alike = mine is others or (is_number(mine) and is_number(others) and mine == others)
        alike &= self.v0.factor == other.v0.factor
        return alike and self.k == other.k and self.base is other.base is None


def checkshots_of(given: Any) -> dict[str, np.ndarray]:
    """
    Return checkshots by well, (n, 4): easting, northing, depth below sea level [m], time [ms].

    Parameters
    ----------
    given : table, mapping of columns, or path of a CSV file
        Columns ``well``, ``easting``, ``northing``, ``depth`` and ``time``, both positive down.

    Raises
    ------
    InputError
        If a column lacks, or depth and time do not rise together.
    """
    if isinstance(given, str | os.PathLike):
        import pandas as pd  # loaded by those who read checkshots

        try:
            given = pd.read_csv(given)
        except (OSError, ValueError) as error:
            raise InputError(
                f"velocity: checkshots {given}: {error}. Give a CSV file, or "
                '"tops" for the well tops of the scene.'
            ) from error
    try:
        columns = [np.ravel(np.asarray(given[name])) for name in COLUMNS]
        numbers = np.stack([np.asarray(one, dtype=np.float64) for one in columns[1:]], axis=1)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise InputError(
            f"checkshots need the columns {', '.join(COLUMNS)}, of numbers but for the first "
            f"({error})."
        ) from error
    shots = {}
    for well in dict.fromkeys(columns[0].tolist()):
        rows = numbers[columns[0] == well]
        rows = rows[np.argsort(rows[:, 3], kind="stable")]
        if not (np.isfinite(rows).all() and (np.diff(rows[:, 2:], axis=0) > 0.0).all()):
            raise InputError(
                f"velocity: at well {well!r} depth and time must rise together, each at most once. "
                "Leave out the checkshots or tops that repeat or fall. Depths are positive down, "
                "elevations of tops positive up."
            )
        shots[str(well)] = rows
    return shots


def from_datum(well: str, rows: np.ndarray, datum: float) -> np.ndarray:
    """Return checkshots of a well that begin at time zero; refuse one above that."""
    if rows[0, 3] <= 0.0:
        return rows
    if rows[0, 2] <= -datum:
        raise InputError(
            f"velocity: well {well!r} has an elevation of {-rows[0, 2]:g} m at {rows[0, 3]:g} ms, "
            f"and time zero is at {datum:g} m. Give depths positive down, and elevations of tops "
            "positive up."
        )
    return np.concatenate([[[*rows[0, :2], -datum, 0.0]], rows])


def deeper(v0: np.ndarray, k: Any, depth: np.ndarray, seconds: np.ndarray) -> np.ndarray:
    """Depth [m] some seconds below a depth: v = v0 + k z along the vertical."""
    with np.errstate(all="ignore"):
        below: np.ndarray = depth + np.where(
            np.equal(k, 0.0), v0 * seconds, (v0 + k * depth) * np.expm1(k * seconds) / k
        )
    return below


def later(v0: np.ndarray, k: Any, depth: np.ndarray, below: np.ndarray) -> np.ndarray:
    """Seconds from a depth to another one: the inverse of `deeper`."""
    with np.errstate(all="ignore"):
        thickness = below - depth
        seconds: np.ndarray = np.where(
            np.equal(k, 0.0), thickness / v0, np.log1p(k * thickness / (v0 + k * depth)) / k
        )
    return seconds


@dataclass(frozen=True, eq=False)
class Velocity(Noun):
    """The velocities of a model, checked.

    Attributes
    ----------
    zones : tuple of str
        Youngest first.
    laws : tuple of Law
        By zone.
    datum : float
        Elevation at time zero [m].
    """

    zones: tuple[str, ...]
    laws: tuple[Law, ...]
    datum: float = 0.0

    @property
    def averages(self) -> tuple[int, ...]:
        """Zones that have the average velocity to the horizon below."""
        return tuple(i for i, law in enumerate(self.laws) if law.base is not None)

    @property
    def groups(self) -> tuple[int, ...]:
        """For each zone the first one with the same velocity: boundaries are between groups."""
        return tuple(
            next(j for j, other in enumerate(self.laws) if j == i or law.same_as(other))
            for i, law in enumerate(self.laws)
        )


def velocity_of(
    given: Any, horizons: Sequence[str], zones: Sequence[str], open_map: Any,
    of_wells: Callable[[Any, float], Mapping[str, Any]] = lambda *_: {},
) -> Velocity:  # fmt: skip
    """
    Return velocities as users write them, checked.

    Parameters
    ----------
    given : float, map, or mapping
        One value for all zones, or by zone; by horizon: the average velocity from the datum to it.
        A value is a number [m/s], a map, or ``{"v0": ..., "k": ...}``.
    horizons, zones : sequence of str
        Youngest first.
    open_map : callable
        Map and its name -> `Lattice`.
    of_wells : callable
        Checkshots and datum -> interval velocities at wells, by zone.

    Raises
    ------
    InputError
        For an unknown name, a zone without velocity or with two, or values not above 0.

    Examples
    --------
    >>> zones = ["above Top", "Top/Base", "below Base"]
    >>> found = velocity_of({"Top": 2000.0, "elsewhere": 3000}, ["Top", "Base"], zones, None)
    >>> [law.base for law in found.laws], found.groups
    (['Top', None, None], (0, 1, 1))
    """
    entries = given if is_by_name(given) else {ELSEWHERE: given}
    if isinstance(given, str) and given in (TOPS, WELLS):
        raise InputError(f"velocity is {given!r}, which gives none below the wells. {HOW}.")
    known = (*zones, *horizons, ELSEWHERE, DATUM, WELLS)
    datum = entries.get(DATUM, 0.0)
    if not is_number(datum):
        raise InputError(f"velocity: datum is {datum!r}; give the elevation at time zero [m].")
    laws: dict[str, Law] = {}
    for name, value in entries.items():
        refusal = (
            f"velocity names {name!r}, which is neither a horizon nor a zone between horizons (a "
            "zone from thickness has the velocity of that which it divides). Names are"
        )
        check_name(name, known, refusal)
        if name in (DATUM, WELLS):
            continue
        zone = zones[horizons.index(name)] if name in horizons and name not in zones else name
        if zone in laws:
            raise InputError(
                f"velocity has both {zone!r} and the average velocity to the horizon below it. "
                "Leave one of them out."
            )
        laws[zone] = _law(value, name, None if zone == name else name, open_map)
    shots, factor = unscaled(entries.get(WELLS))
    at_wells = {} if shots is None else of_wells(shots, float(datum))
    for zone, values in at_wells.items():
        laws.setdefault(zone, Law(Field(values, factor)))
    lacking = [zone for zone in zones if zone not in laws]
    if lacking and ELSEWHERE not in laws:
        raise InputError(
            f"velocity has nothing for {known_names(lacking)} Add the zone, or a value for "
            f"{ELSEWHERE!r}."
        )
    found = tuple(laws[zone] if zone in laws else laws[ELSEWHERE] for zone in zones)
    return Velocity(tuple(zones), found, float(datum))


def is_by_name(given: Any) -> bool:
    """Return whether velocities are given by name, and not one for all zones."""
    return isinstance(given, Mapping) and not hasattr(given, "dims") and "v0" not in given


def _law(value: Any, name: str, base: str | None, open_map: Any) -> Law:
    """One velocity, checked."""
    what = f"velocity of {name!r}"
    value, factor = unscaled(value)
    k = 0.0
    if isinstance(value, Mapping) and not hasattr(value, "dims"):
        for key in value:
            check_word(key, ("v0", "k"), f"{what} has no {key!r}.", f" {HOW}.")
        if base is not None or not {"v0", "k"} <= set(value) or not is_number(value["k"]):
            raise InputError(
                f"{what} is {dict(value)!r}. A zone takes v0 [m/s] and k [1/s], both, and k a "
                "number; a horizon takes its average velocity, a number or a map."
            )
        value, k = value["v0"], value["k"]
    if not is_number(value) and isinstance(value, bool | list | tuple | float | None):
        raise InputError(f"{what} cannot be {value!r}. {HOW}.")
    field = Field(float(value) if is_number(value) else open_map(value, what), factor)
    if not field.smallest >= SLOWEST:
        raise InputError(
            f"{what} is {field.smallest:g} m/s; velocities are above 0, and those of rock above "
            f"{SLOWEST:g}. Multiply km/s by 1000. {HOW}."
        )
    return Law(field, float(k) * factor, base)
