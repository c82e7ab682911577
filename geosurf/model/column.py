"""The stratigraphic column: how horizons yield to each other, and what that took away."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from geosurf.conventions import (
    area_text,
    did_you_mean,
    is_word,
    length_text,
    place,
    volume_text,
)
from geosurf.errors import InputError
from geosurf.model.expected import name_of

CONFORMABLE, EROSIONAL, BASE, DISCONTINUOUS = "conformable", "erosional", "base", "discontinuous"
RULES = (CONFORMABLE, EROSIONAL, BASE, DISCONTINUOUS)
# Horizons below end on these, horizons above end on those of `IS_LAPPED`; a discontinuity does
# both.
ERODES = (EROSIONAL, DISCONTINUOUS)
IS_LAPPED = (BASE, DISCONTINUOUS)
ELSEWHERE = "elsewhere"  # the block of a fluid contact that stands for all that no other names


def check_column(horizons: Sequence[str], column: Mapping[str, Any] | None) -> tuple[str, ...]:
    """Return the rule of each horizon, youngest first.

    Parameters
    ----------
    horizons : sequence of str
        Names, youngest first.
    column : mapping of str to str, or None
        The rule of some of them; the others are conformable.

    Returns
    -------
    tuple of {"conformable", "erosional", "base", "discontinuous"}

    Raises
    ------
    InputError
        For an unknown horizon or rule.

    Examples
    --------
    >>> check_column(["Top", "Base"], {"Base": "erosional"})
    ('conformable', 'erosional')
    """
    # Without a column all horizons are conformable: the older one yields where two cross.
    if column is None:
        return (CONFORMABLE,) * len(horizons)
    if not isinstance(column, Mapping):
        raise InputError(
            f"`column` must be a mapping {{horizon: rule}}, not {type(column).__name__}. The "
            f"rules are {', '.join(RULES)}."
        )

    # unknown names and rules are errors here, before a cell is computed
    for name, rule in column.items():
        if name not in horizons:
            raise InputError(
                f"`column` names {name!r}, which is not a horizon. The horizons are "
                f"{list(horizons)}.{did_you_mean(str(name), horizons)}"
            )
        if not is_word(rule, RULES):
            raise InputError(
                f"`column`: the rule of horizon {name!r} is {rule!r}. Use one of "
                f"{', '.join(RULES)}.{did_you_mean(str(rule), RULES)}"
            )

    # one rule per horizon, in the order of horizons; names are checked by then
    return tuple(str(column.get(name, CONFORMABLE)) for name in horizons)


@dataclass(frozen=True)
class Clipped:
    """What the column took away of one horizon because of another.

    Attributes
    ----------
    horizon, by : str
        The horizon that was clipped, and the one that it ends on.
    rule : {"erosional", "base", "conformable"}
        Why: `by` erodes it, it laps onto `by`, or both are conformable and cross all the
        same, so that the older one yields and the zone between them has no thickness there.
    area : float
        Of the pieces of the horizon that are gone, along it [m2].
    volume : float
        Between these pieces and what the horizon ends on [m3].
    thickness : float
        Largest vertical distance between the two, at the corners of both [m].
    place : (easting, northing, elevation)
        Where that is [m].
    places : tuple of (easting, northing, elevation, volume)
        The middle of each separate piece of that volume, the largest first [m, m3].
    """

    horizon: str
    by: str
    rule: str
    area: float
    volume: float
    thickness: float
    place: tuple[float, float, float]
    places: tuple[tuple[float, float, float, float], ...]

    def __str__(self) -> str:
        n = len(self.places)
        count = "one place" if n == 1 else f"{n} places"
        return (
            f"{self.horizon} is clipped by {self.by} ({self.rule}): {area_text(self.area)} of "
            f"it and {volume_text(self.volume)} in {count}, up to "
            f"{length_text(self.thickness)} thick at {place(self.place)}"
        )


@dataclass(frozen=True)
class Remnant:
    """A unit too small to be named by faults alone, or smaller than somebody cares for.

    Attributes
    ----------
    name : str
        Of the unit.
    volume : float
        [m3].
    place : (easting, northing, elevation)
        Middle of its bounds [m].
    """

    name: str
    volume: float
    place: tuple[float, float, float]

    def __str__(self) -> str:
        return f"{self.name}: {volume_text(self.volume)} at {place(self.place)}"


@dataclass(frozen=True, eq=False)
class FluidContact:
    """
    Where a fluid contact is, and in which zones and block it counts.

    Parameters
    ----------
    at : float, xarray.DataArray, TriSurface or path
        Elevation [m, positive up], or a gridded horizon, or a surface.
    zones : str or sequence of str
        ``"Top/Base"``, ``"above Top"`` ...: units of other zones are not split by it. Empty: all.
    block : str
        Sides of faults, ``"F1+ F2-"``: units that do not lie on them are not split by it. Empty or
        ``"elsewhere"``: all zones that no other contact of the same name lists.
    name : str
        ``"OWC"`` ...: `build_contacts` fills in what it is called among the contacts of a model.

    Raises
    ------
    InputError
        If ``zones`` or ``block`` are not names.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=9)
    >>> (_, _, _, _, bottom, top) = world.box
    >>> level = FluidContact(0.5 * (bottom + top), zones="Top/Base")
    >>> scene = gs.Scene(world.horizons, world.faults, world.box, contacts={"OWC": level})
    >>> sorted({unit.zone for unit in scene.units.values() if unit.contact})
    ['Top/Base']
    """

    at: Any
    zones: tuple[str, ...] = ()
    block: str = ""
    name: str = ""

    @property
    def surface(self) -> str:
        """What its surface is called among the patches, where it has the role ``"contact"``."""
        where = [part for part in (self.block, ", ".join(self.zones)) if part]
        return f"{self.name} in {' of '.join(where)}" if where else self.name

    def __post_init__(self) -> None:
        # a single word is a common slip for a list of one
        given = (self.zones,) if isinstance(self.zones, str) else self.zones
        listed = given if isinstance(given, list | tuple) else (None,)
        # `None` stands for whatever was no list, so that one test covers all cases.
        if not all(isinstance(zone, str) and zone.strip() for zone in listed):
            raise InputError(
                f"FluidContact: `zones` is {self.zones!r}. Give names of zones, as in "
                "zones=['Top/Base']."
            )
        if not isinstance(self.block, str):
            raise InputError(
                f"FluidContact: `block` is {self.block!r}. Give sides of faults, as in "
                "block='F1+ F2-'."
            )
        # Frozen dataclass: cleaned values are set here, once.
        object.__setattr__(self, "name", name_of(self.name, "fluid contact"))
        object.__setattr__(self, "zones", tuple(dict.fromkeys(listed)))
        object.__setattr__(self, "block", "" if self.block == ELSEWHERE else self.block)
