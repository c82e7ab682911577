"""The stratigraphic column: how horizons yield to each other, and what that took away."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

from geosurf.conventions import (
    area_text,
    check_name,
    check_word,
    did_you_mean,
    grouped,
    is_word,
    length_text,
    place,
    volume_text,
)
from geosurf.errors import InputError
from geosurf.model.base import Noun
from geosurf.model.expected import name_of

CONFORMABLE, EROSIONAL, BASE, DISCONTINUOUS = "conformable", "erosional", "base", "discontinuous"
YIELDING = "yielding"
RULES = (CONFORMABLE, EROSIONAL, BASE, DISCONTINUOUS, YIELDING)
# what the field calls them, or what they are rules of
FIELD_WORDS = {
    **dict.fromkeys(("unconformity", "erosion", "eroded", "eroding", "truncation"), EROSIONAL),
    **dict.fromkeys(("onlap", "downlap", "baselap", "lap"), BASE),
}
# Horizons below end on these, horizons above end on those of `IS_LAPPED`; a discontinuity does
# both. What yields ends on all others.
ERODES = (EROSIONAL, DISCONTINUOUS)
IS_LAPPED = (BASE, DISCONTINUOUS)
ELSEWHERE = "elsewhere"  # the block of a fluid contact that stands for all that no other names


def names_of_zones(horizons: Sequence[str]) -> list[str]:
    """
    Names of the zones between horizons, youngest first.

    Raises
    ------
    InputError
        If two would have one name.

    Examples
    --------
    >>> names_of_zones(["Top", "Base"])
    ['above Top', 'Top/Base', 'below Base']
    """
    if not horizons:
        return ["box"]
    between = [f"{a}/{b}" for a, b in pairwise(horizons)]
    names = [f"above {horizons[0]}", *between, f"below {horizons[-1]}"]

    # 'A/B' between 'A' and 'B' may also be the name of a horizon
    for name in names:
        if names.count(name) > 1:
            raise InputError(
                f"two zones would have the name {name!r} because names of horizons contain '/'. "
                "Rename one of the horizons."
            )
    return names


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
    tuple of {"conformable", "erosional", "base", "discontinuous", "yielding"}

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
        refusal = f"`column` names {name!r}, which is not a horizon. The horizons are"
        check_name(name, horizons, refusal)
        if not is_word(rule, RULES):
            raise InputError(
                f"`column`: the rule of horizon {name!r} is {rule!r}. Use one of "
                f"{', '.join(RULES)}.{rule_meant(rule)}"
            )

    # one rule per horizon, in the order of horizons; names are checked by then
    return tuple(str(column.get(name, CONFORMABLE)) for name in horizons)


def rule_meant(word: Any) -> str:
    """Return ' Did you mean ...?' for a word of the field, or a misspelt rule; else ''.

    Examples
    --------
    >>> rule_meant("Unconformity"), rule_meant("erosionl")
    (" Did you mean 'erosional'?", " Did you mean 'erosional'?")
    """
    return did_you_mean(FIELD_WORDS.get(str(word).casefold(), str(word)), RULES)


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
        of_it = f"{area_text(self.area)} of it and " if self.area > 0 else ""
        return (
            f"{self.horizon} is clipped by {self.by} ({self.rule}): {of_it}"
            f"{volume_text(self.volume)} in {count}, up to "
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
        ``"Top/Base"``, ``"above Top"`` ...: units of other zones are not split by it. Empty:
        those of the reservoir.
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


def each_level(value: Any, at: Callable[[Any], Any]) -> Any:
    """Return a contact with each of its levels replaced; see ``Scene(contacts=)`` for its forms.

    Examples
    --------
    >>> each_level({"F1+": [-1700.0, -1720.0]}, lambda level: level - 10.0)
    {'F1+': [-1710.0, -1730.0]}
    """
    # a list may hold contacts, and a mapping may have lists; an xarray object is one level
    if isinstance(value, FluidContact):
        return replace(value, at=each_level(value.at, at))
    if isinstance(value, list | tuple):
        return [each_level(one, at) for one in value]
    if isinstance(value, Mapping) and not hasattr(value, "dims"):
        return {block: each_level(one, at) for block, one in value.items()}
    return at(value)


def levels_of(value: Any) -> list[Any]:
    """Return all levels of a contact."""
    found: list[Any] = []
    each_level(value, found.append)
    return found


# ---- compartments ----------------------------------------
# Compartments: which faults virtual walls continue, to where, and what came of it.


NEAREST, BOUNDARY = "nearest", "boundary"
EITHER = "either"  # end, of a fault that dies at one of them
ENDS = ("start", "end")  # of strike by the right-hand rule, as for `Extension`
_SUFFIX = " (virtual)"
HOW = (
    'Write compartments=True for all faults, or by fault: compartments={"F3": "boundary", '
    '"F4": "F1", "F5": {"end": "nearest"}}; in a scenario, F3 = "boundary" in [compartments]'
)


def virtual_name(fault: str) -> str:
    """Return what the virtual wall of a fault is called.

    Examples
    --------
    >>> virtual_name("F3")
    'F3 (virtual)'
    """
    return fault + _SUFFIX


def fault_of(surface: str) -> str:
    """Return the fault that a virtual wall continues; the name of a fault itself.

    Examples
    --------
    >>> fault_of("F3 (virtual)"), fault_of("F1")
    ('F3', 'F1')
    """
    return surface.removesuffix(_SUFFIX)


def separators(names: Sequence[str], roles: Sequence[str]) -> dict[str, list[int]]:
    """Return faults in order, and the rows of each with those of its virtual wall.

    Examples
    --------
    >>> separators(["Top", "F1", "F3", "F3 (virtual)"], ["horizon", "fault", "fault", "virtual"])
    {'F1': [1], 'F3': [2, 3]}
    """
    return grouped(
        (fault_of(name) if role == "virtual" else name, i)
        for i, (name, role) in enumerate(zip(names, roles, strict=True))
        if role in ("fault", "virtual")
    )


@dataclass(frozen=True)
class VirtualWall(Noun):
    """One part of the wall that continues a fault: no rock moved there.

    Attributes
    ----------
    fault : str
    side : {"start", "end", "up", "down"}
        Of the fault, as for `Extension`.
    target : str
        The fault that it ends at, ``"boundary"``, or ``"top"`` and ``"base"`` of the model.
    length : float
        Shortest distance from the tip line to the target, at equal elevation inside the model;
        upward and downward the largest distance [m].
    area : float
        Inside the model [m2].
    place : (easting, northing, elevation)
        Where the join is shortest, on the tip line [m].
    facing : str
        Side of the target that it ends at, where two tip lines face each other; else ''.
    """

    fault: str
    side: str
    target: str
    length: float
    area: float
    place: tuple[float, float, float]
    facing: str = ""

    def __str__(self) -> str:
        """One sentence, as for a log."""
        to = {BOUNDARY: "the boundary of the model"}.get(self.target, self.target)
        if self.side in ("up", "down"):
            to = f"the {self.target} of the model"
        if self.facing:
            to += f" ({self.facing})"
        return f"{self.fault} ({self.side}) is joined to {to}: {length_text(self.length)}"


def read_compartments(given: Any, faults: Sequence[str]) -> dict[str, dict[str, str]]:
    """
    Return the faults that virtual walls continue, and where each end goes.

    Parameters
    ----------
    given : bool, sequence of str, or mapping of str to target
        A target is True or ``"nearest"``, ``"boundary"``, a fault, or these by end:
        ``{"start": "F1", "end": "boundary"}``.
    faults : sequence of str
        Names that exist.

    Returns
    -------
    dict of str to dict of str to str
        In the order of `faults`; ends that are left out are not continued. A fault as the only
        target is that of ``"either"`` end: the fault dies at one of them.

    Raises
    ------
    InputError
        For an unknown fault, end or target.

    Examples
    --------
    >>> read_compartments({"F3": "boundary", "F4": {"end": "F3"}}, ["F3", "F4"])
    {'F3': {'start': 'boundary', 'end': 'boundary'}, 'F4': {'end': 'F3'}}
    >>> read_compartments({"F4": "F3"}, ["F3", "F4"])
    {'F4': {'either': 'F3'}}
    """
    if given is None or given is False:
        return {}
    if given is True:
        given = dict.fromkeys(faults, NEAREST)
    elif isinstance(given, str):
        given = {given: NEAREST}
    elif isinstance(given, Iterable) and not isinstance(given, Mapping):
        given = dict.fromkeys(given, NEAREST)
    if not isinstance(given, Mapping):
        raise InputError(f"compartments is {given!r}. {HOW}.")
    for name in given:
        _known(name, faults, "compartments names")
    reserved = [name for name in faults if name in (NEAREST, BOUNDARY)]
    if reserved:
        raise InputError(
            f"compartments use the words {NEAREST!r} and {BOUNDARY!r}, and a fault is called "
            f"{reserved[0]!r}. Rename that fault."
        )
    return {name: _targets(name, given[name], faults) for name in faults if name in given}


def _targets(name: str, value: Any, faults: Sequence[str]) -> dict[str, str]:
    """Where each end of one fault goes."""
    ends = value if isinstance(value, Mapping) else dict.fromkeys(ENDS, value)
    if isinstance(value, str) and value not in (NEAREST, BOUNDARY):
        ends = {EITHER: value}
    targets = {}
    for end, target in ends.items():
        refusal = f"compartments of {name!r} has end {end!r}; the ends of a fault are 'start' and"
        check_word(end, (*ENDS, EITHER), f"{refusal} 'end'.", f" {HOW}.")
        if target is True or (isinstance(target, str) and target == NEAREST):
            target = NEAREST
        elif not (isinstance(target, str) and target == BOUNDARY):
            _known(target, faults, f"compartments joins {name!r} to")
        if target == name:
            raise InputError(
                f"compartments joins {name!r} to itself. Name another fault, or 'boundary'."
            )
        targets[end] = str(target)
    return targets


def _known(name: Any, faults: Sequence[str], what: str) -> None:
    """Refuse a name that is not a fault's."""
    if not faults:
        raise InputError(
            f"{what} {name!r}, and the scene has no faults. Give them, or leave compartments out; "
            "in a scenario, uncomment [[faults]], or comment [compartments] out."
        )
    refusal = f"{what} {name!r}, which is not a fault. The faults are"
    check_name(name, faults, refusal, f" {HOW}.")


# ---- zones from thickness ----------------------------------------
# Horizons that are made of another one, and how thick the zone between is.


ZONE_KEYS = ("below", "above", "thickness", "base", "top", "kind")
KINDS = ("isochore", "isopach")  # vertical, or normal to the reference
ZONE_HOW = 'Write zones={"Upper": {"below": "Top", "thickness": 20.0}}; a thickness may be a map'


@dataclass(frozen=True, eq=False)
class MadeHorizon:
    """A horizon of a scene that is made of another one: the other end of a zone.

    Attributes
    ----------
    zone : str
    start : str
        The horizon that the thickness is counted from.
    horizon : str
        The horizon at the other end.
    down : bool
        Whether that is the base of the zone.
    thickness : object
        A number, a map, or values at wells [m].
    kind : {"isochore", "isopach"}
    """

    zone: str
    start: str
    horizon: str
    down: bool
    thickness: Any = field(repr=False)
    kind: str


def zones_of(given: Mapping[str, Any], horizons: Sequence[str]) -> list[MadeHorizon]:
    """
    Return the zones that have a thickness, each after the one that it counts from.

    Parameters
    ----------
    given : mapping of str to mapping
        As for `Scene`.
    horizons : sequence of str
        Names of the horizons that have data.

    Raises
    ------
    InputError
        For another key, an unknown reference, or two zones on one side of a horizon.

    Examples
    --------
    >>> given = {"A": {"below": "Top", "thickness": 9.0}, "B": {"below": "A", "thickness": 5.0}}
    >>> [(one.start, one.horizon) for one in zones_of(given, ["Top"])]
    [('Top', 'base A'), ('base A', 'base B')]
    """
    ends = {zone: _ends(zone, entry) for zone, entry in given.items()}
    # a zone may count from another one, by its name or that of its far end
    zone_of = {end: zone for zone, (_, _, end) in ends.items() if end not in horizons}
    made: dict[str, MadeHorizon] = {}
    while len(made) < len(given):
        n = len(made)
        for zone, (reference, down, end) in ends.items():
            before = made.get(zone_of.get(reference, reference))
            follows = before is not None and before.down == down and before.horizon not in horizons
            if zone in made or not (reference in horizons or follows):
                continue
            start = reference if before is None or reference in horizons else before.horizon
            entry = given[zone]
            kind = entry.get("kind", KINDS[0])
            made[zone] = MadeHorizon(zone, start, end, down, entry["thickness"], kind)
        if len(made) == n:
            zone, (reference, _, _) = next((z, end) for z, end in ends.items() if z not in made)
            raise InputError(
                f"zone {zone!r} counts from {reference!r}, which is neither a horizon with data "
                f"nor a zone on the same side of one."
                f"{did_you_mean(reference, [*horizons, *given])} {ZONE_HOW}."
            )
    sides = [(horizon.start, horizon.down) for horizon in made.values()]
    for horizon in made.values():
        if sides.count((horizon.start, horizon.down)) > 1:
            side = "below" if horizon.down else "above"
            raise InputError(
                f"two zones lie {side} {horizon.start!r}. Let the second count from the first: "
                f'{{"{side}": {horizon.zone!r}}}.'
            )
    return list(made.values())


def _ends(zone: str, entry: Any) -> tuple[str, bool, str]:
    """What a zone counts from, whether down, and the horizon at its other end."""
    if not isinstance(entry, Mapping) or "thickness" not in entry:
        raise InputError(f"zone {zone!r} is {entry!r}, without a thickness. {ZONE_HOW}.")
    for key in entry:
        check_word(key, ZONE_KEYS, f"zone {zone!r} has no {key!r}.", f" {ZONE_HOW}.")
    down = "below" in entry
    end, wrong = ("base", "top") if down else ("top", "base")
    reference = entry.get("below" if down else "above")
    if ("above" in entry) == down or wrong in entry or not isinstance(reference, str):
        raise InputError(
            f"zone {zone!r} takes 'below' a horizon or zone, with the name of its 'base', or "
            f"'above' one, with the name of its 'top'. {ZONE_HOW}."
        )
    if not is_word(entry.get("kind", KINDS[0]), KINDS):
        raise InputError(f"zone {zone!r}: kind is {entry['kind']!r}, expected one of {KINDS}.")
    name = entry.get(end, f"{end} {zone}")
    if not isinstance(name, str) or not name:
        raise InputError(f"zone {zone!r}: {end} is {name!r}, expected the name of a horizon.")
    return reference, down, name


def data_of_made(
    made: Sequence[MadeHorizon], horizons: Collection[str]
) -> dict[str, tuple[str, ...]]:
    """
    Return the horizons that zones make, each with those whose data it is made of.

    The first one is moved; a second one is that to which a row of zones is fitted.

    Parameters
    ----------
    made : sequence of MadeHorizon
        As from `zones_of`.
    horizons : collection of str
        Names of the horizons that have data.

    Examples
    --------
    >>> given = {"A": {"below": "Top", "thickness": 9.0}, "B": {"below": "A", "thickness": 5.0}}
    >>> data_of_made(zones_of(given, ["Top"]), ["Top"])
    {'base A': ('Top',), 'base B': ('Top',)}
    """
    start: dict[str, str] = {}
    end: dict[str, str] = {}
    for horizon in made:
        if horizon.horizon not in horizons:
            start[horizon.horizon] = start.get(horizon.start, horizon.start)
    for horizon in reversed(made):
        last = horizon.horizon if horizon.horizon in horizons else end.get(horizon.horizon)
        if last is not None:
            end[horizon.start] = last
    return {name: (of, *([end[name]] if name in end else [])) for name, of in start.items()}


def in_column(made: Sequence[MadeHorizon], horizons: Mapping[str, Any]) -> dict[str, Any]:
    """Return horizons with those that are made, youngest first."""
    order = list(horizons)
    for horizon in made:
        if horizon.horizon not in horizons:
            order.insert(order.index(horizon.start) + horizon.down, horizon.horizon)
    by_name = {horizon.horizon: horizon for horizon in made}
    return {name: horizons.get(name, by_name.get(name)) for name in order}
