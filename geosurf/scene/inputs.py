"""What a scene is made of: a frozen description of its inputs, checked once."""

from __future__ import annotations

import operator
import os
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, NoReturn, TypeVar

from geosurf.arrangement.voxels import check_voxel_size
from geosurf.carve.column import reservoir_of
from geosurf.conventions import (
    check_word,
    did_you_mean,
    elevation_sign,
    is_number,
    metres_per_unit,
    shared_name,
)
from geosurf.conventions.axes import TimeUnit, is_time_unit
from geosurf.conventions.crs import refuse_other_crs
from geosurf.errors import InputError
from geosurf.faults.extend import read_lengthen
from geosurf.faults.rules import Halves, Rule, faults_at, halves_of, read_extend, read_truncations
from geosurf.measure.velocity import time_word
from geosurf.measure.volumetrics import ARGUMENTS, Factor, factors_of
from geosurf.model import FaultSticks, Lattice, Sheet, check_column
from geosurf.model.column import MadeHorizon, in_column, names_of_zones, read_compartments, zones_of
from geosurf.model.distributions import is_distribution
from geosurf.model.expected import box_of_sides, flag_of, name_of, outline_of
from geosurf.model.network import filling_by_horizon
from geosurf.model.regions import check_regions, sliver_settings
from geosurf.model.tears import FaultThrow, TearSettings, check_tears, tear_settings, throws_of
from geosurf.model.tops import tie_settings
from geosurf.read import read_horizon
from geosurf.read._common import Otherwise, Ratio, check_ratio
from geosurf.triangulate.horizon import horizon_over
from geosurf.triangulate.neighbours import own_form

Box = tuple[float, float, float, float, float, float]
Entry = TypeVar("Entry")

# what an input is like, in messages
SAMPLES = {
    "horizons": "{'Top': 'Top.gri'}",
    "faults": "{'F1': 'F1.ts'}",
    "contacts": "{'OWC': -1705.0}",
    "truncations": "{'F2': ('F1', 'hanging wall')}",
}


RECTANGLE = "rectangle"  # as an area: the largest axis-parallel one that all horizons cover


def _refuse_together(
    tear: TearSettings | None,
    throws: tuple[FaultThrow, ...],
    tolerance: float | None,
    at_horizons: tuple[Rule, ...],
    filling: Mapping[str, bool | str],
) -> None:
    """Refuse settings that exclude each other, and one that would have no effect."""
    for word, given in {"tear": tear, "throws": throws}.items():
        if given and tolerance is not None:
            raise InputError(
                f"{word} and tolerance={tolerance:g} exclude each other: torn horizons keep "
                "all of their nodes. Leave one of them out."
            )
    if at_horizons and tolerance is not None:
        raise InputError(
            f"tolerance={tolerance:g} cannot be combined with the truncation of "
            f"{at_horizons[0].fault!r} by horizon {at_horizons[0].main!r}: a tolerance would "
            "move the curve in which the fault ends. Leave one of them out."
        )
    if any(filling.values()) and tear is None:
        raise InputError(
            "fill_empty_blocks applies to horizons that are torn. Give tear=True as well, or "
            "tear_horizon(..., fill_empty_blocks=...)."
        )


def _refuse_ends_at_horizons(
    compartments: Mapping[str, Any], at_horizons: tuple[Rule, ...]
) -> None:
    """Refuse virtual walls of faults that horizons truncate: there is nothing to continue."""
    for rule in at_horizons:
        if rule.fault in compartments:
            raise InputError(
                f"compartments names {rule.fault!r}, which ends at horizon {rule.main!r}. Leave it "
                "out of compartments, or leave the truncation by the horizon out."
            )


@dataclass(frozen=True, eq=False)
class SceneInputs:
    """
    The inputs of a `Scene`, checked and in one form; nothing is read from files yet.

    Parameters
    ----------
    horizons, faults, box, column, contacts, aoi, positive, length_unit
        As for `Scene`.
    voxel_size, self_intersections, extend, truncations, tolerance, tops, tie, lengthen, slivers,
    fill_empty_blocks, compartments, crs, reservoir, regions, time, velocity, zones, throws
        As for `Scene`.

    Attributes
    ----------
    rules : tuple of Rule
        `truncations` by faults, checked, main faults first.
    horizon_rules : tuple of Rule
        `truncations` by horizons.
    halves : Halves
        Faults that younger ones split; `faults` has the halves.
    settings : dict
        Settings by horizon or fault as they were given: what "all" means follows the inputs, and
        what is stated of an input counts again when the input comes back.

    Raises
    ------
    InputError
        If an input cannot be used.

    Examples
    --------
    >>> SceneInputs({"Top": "top.gri"}, {"F1": "F1.ts"}, extend=True).extend
    {'F1': ('start', 'end', 'up', 'down')}
    """

    horizons: Mapping[str, Any]
    faults: Mapping[str, Any] = field(default_factory=dict)
    box: Box | None = None
    column: Mapping[str, str] = field(default_factory=dict)
    contacts: Mapping[str, Any] = field(default_factory=dict)
    aoi: Any = None
    positive: str | None = None
    length_unit: str | None = None
    voxel_size: float | None = None
    self_intersections: bool = False
    extend: Any = ()
    truncations: Mapping[str, Any] = field(default_factory=dict)
    tolerance: float | None = None
    tops: Any = None
    tie: Any = None
    lengthen: Any = None
    tear: Any = None
    slivers: Any = None
    fill_empty_blocks: Any = None
    compartments: Any = None
    crs: str | None = None
    reservoir: Any = None
    regions: Mapping[str, Any] = field(default_factory=dict)
    time: str | None = None
    velocity: Any = None
    zones: Mapping[str, Any] = field(default_factory=dict)
    throws: Any = ()
    made: tuple[MadeHorizon, ...] = field(init=False, repr=False)
    rules: tuple[Rule, ...] = field(init=False, repr=False)
    horizon_rules: tuple[Rule, ...] = field(init=False, repr=False)
    halves: Halves = field(init=False, repr=False)
    given_faults: dict[str, Any] = field(init=False, repr=False)
    settings: dict[str, Any] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Check every input, alone and against the others."""
        # fields are checked, brought into one form and set; from then on the object is frozen
        settings = {key: _held(getattr(self, key)) for key in _OF_FAULTS + _OF_HORIZONS}
        self.__dict__.update(settings)
        if time_word(self.time) is not None and self.tolerance is not None:
            raise InputError(
                f"tolerance={self.tolerance} is in metres, and the scene is in time. Leave one of "
                "them out."
            )
        if (
            self.time is not None
            and self.velocity is None
            and (self.tops is not None or self.contacts)
        ):
            raise InputError(
                "well tops and fluid contacts need depth, and the scene is in time. Give "
                "velocities, velocity={...}, or leave them out."
            )
        known = {
            name: value for name, value in as_mapping("horizons", self.horizons).items()
            if not isinstance(value, MadeHorizon)
        }  # fmt: skip
        with_data = self._opened("horizon", known)
        zones = as_mapping("zones", self.zones)
        if zones and self.time is not None and self.velocity is None:
            raise InputError(
                "zones take metres, and the scene is in time. Give velocities: velocity={...}."
            )
        if self.throws and self.time is not None:
            raise InputError("throws take metres, and the scene is in time. Leave one of them out.")
        made = zones_of(zones, tuple(with_data))
        horizons = in_column(made, with_data)
        faults = self._opened("fault", as_mapping("faults", self.faults))
        if not horizons and not faults:
            raise InputError(
                "a scene needs at least one horizon or fault; give horizons={name: ...}."
            )

        # a tuple of floats: inputs are compared and hashed by value
        box = None if self.box is None else tuple(box_of_sides(self.box).tolist())
        if box is not None and self.takes_rectangle:
            raise InputError(
                "aoi='rectangle' proposes a box, and box= is given as well. Leave one of them out."
            )

        # each input alone, then against the others
        check_column(tuple(horizons), self.column)
        reservoir = None
        if self.reservoir is not None:  # None stays: the default follows the horizons
            reservoir = reservoir_of(names_of_zones(tuple(horizons)), self.reservoir)
        contacts = as_mapping("contacts", self.contacts)
        refuse_namesakes(horizon=horizons, fault=faults, contact=contacts)
        if self.positive is not None:
            elevation_sign(self.positive, "the scene")
        if self.length_unit is not None:
            metres_per_unit(self.options["length_unit"], "the scene")
        crs = None if self.crs is None else name_of(self.crs, "coordinate reference system")
        check_voxel_size(self.voxel_size)
        crossing = flag_of(self.self_intersections, "self_intersections")
        tolerance = check_scene_tolerance(self.tolerance, with_data)
        truncations = as_mapping("truncations", self.truncations)

        # from here on, halves stand for the faults that younger ones split
        halves, given = halves_of(truncations, tuple(faults)), faults
        faults = halves.spread(faults)
        faults = {name: faults[name] for name in halves.names(tuple(given))}
        if halves.parts:
            refuse_namesakes(horizon=horizons, fault=faults, contact=contacts)

        # settings that exclude each other are refused here, before a file is read
        tear = tear_settings(self.tear, (*given, *faults))
        if tear is not None:
            tear = replace(tear, trim=halves.spread(tear.trim))
        throws = tuple(
            replace(one, fault=part)
            for one in throws_of(self.throws)
            for part in halves.names([one.fault])
        )
        check_tears(tear, throws, tuple(faults), tuple(horizons))
        rules = read_truncations(halves.truncations, tuple(faults), tuple(horizons))
        at_horizons = tuple(rule for rule in rules if rule.main in horizons)
        filling = filling_by_horizon(self.fill_empty_blocks, tuple(horizons))
        _refuse_together(tear, throws, tolerance, at_horizons, filling)
        compartments = read_compartments(halves.spread(self.compartments), tuple(faults))
        _refuse_ends_at_horizons(compartments, at_horizons)

        # a tie without tops would silently do nothing
        tie = tie_settings(self.tie)
        if tie is not None and self.tops is None:
            raise InputError("tie needs well tops. Give them, too: tops=geosurf.read_tops(path).")
        if tie is not None and throws:
            raise InputError(
                "tie and throws exclude each other: throw moves horizons off their tops. Leave tie "
                "out; scene.misfit() lists all tops."
            )

        self.__dict__.update(  # frozen from here on
            horizons=horizons,
            zones=zones,
            made=tuple(made),
            faults=faults,
            box=box,
            column=dict(self.column),
            contacts=contacts,
            self_intersections=crossing,
            tolerance=tolerance,
            truncations=truncations,
            tie=tie,
            tear=tear,
            throws=throws,
            slivers=sliver_settings(self.slivers),
            compartments=compartments,
            crs=crs,
            reservoir=reservoir,
            regions=check_regions(self.regions),
            rules=tuple(rule for rule in rules if rule.main not in horizons),
            horizon_rules=at_horizons,
            halves=halves,
            given_faults=given,
            settings=settings,
            extend=read_extend(halves.spread(self.extend), tuple(faults)),
            lengthen=read_lengthen(halves.spread(self.lengthen), tuple(faults)),
        )
        self._refuse_torn_beyond()

    def _opened(self, role: str, inputs: dict[str, Any]) -> dict[str, Any]:
        """Inputs by name, with objects of other packages in geosurf's own form."""
        opened = {
            name: own_form(value, name, role, self.positive) for name, value in inputs.items()
        }
        if self.time is None:
            return opened
        return {
            name: in_time_unit(value, f"{role} {name!r}", self.length_unit)
            for name, value in opened.items()
        }

    def _refuse_torn_beyond(self) -> None:
        """Refuse sheets that are torn at a fault which ends at a horizon before it reaches them."""
        for name, value in self.horizons.items():
            if not isinstance(value, Sheet):
                continue
            for rule in self.horizon_rules:
                if rule.fault in value.cuts and rule.fault not in self.faults_at(name):
                    what = "it" if rule.main == name else f"horizon {rule.main!r}"
                    raise InputError(
                        f"horizon {name!r} is torn at {rule.fault!r}, and truncations keep only "
                        f"what lies {rule.keep} {what} of that fault. Tear {name!r} without "
                        f"{rule.fault!r}, or leave the rule out."
                    )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the horizons, youngest first, then of the faults."""
        return (*self.horizons, *self.faults)

    def faults_at(self, horizon: str) -> tuple[str, ...]:
        """Names of the faults that may cut a horizon: those that no horizon ends before it."""
        ending = faults_at(horizon, tuple(self.horizons), self.horizon_rules)
        return tuple(name for name in self.faults if name not in ending)

    def throws_at(self, horizon: str) -> tuple[FaultThrow, ...]:
        """The throws that move a horizon: those without a list move what their fault reaches."""
        reaching = self.faults_at(horizon)
        return tuple(
            one
            for one in self.throws
            if horizon in one.horizons or (not one.horizons and one.fault in reaching)
        )

    @property
    def torn(self) -> tuple[str, ...]:
        """Names of the horizons that are torn as they were picked."""
        if self.tear is None:
            return ()
        return tuple(
            name for name in self.horizons if name in (self.tear.horizons or self.horizons)
        )

    @property
    def filling(self) -> dict[str, bool | str]:
        """What becomes of torn horizons in blocks without data, see `filling_by_horizon`."""
        return filling_by_horizon(self.fill_empty_blocks, self.torn)

    @property
    def takes_rectangle(self) -> bool:
        """Whether the area is the largest axis-parallel rectangle that all horizons cover."""
        return isinstance(self.aoi, str) and self.aoi == RECTANGLE

    @property
    def options(self) -> dict[str, str | None]:
        """What counts for inputs that do not declare it themselves."""
        unit = self.length_unit
        if self.time is not None and is_time_unit(unit):
            unit = TimeUnit(unit)
        return {"positive": self.positive, "length_unit": unit}

    @property
    def becomes_depth(self) -> bool:
        """Whether inputs are in time, and velocities make a model in depth of them."""
        return self.time is not None and self.velocity is not None

    @property
    def to_build(self) -> SceneInputs:
        """The inputs of the model that is built from what was given, in its own domain."""
        return self.in_time if self.becomes_depth else self

    @property
    def in_time(self) -> SceneInputs:
        """The same inputs without velocity, and without what is in metres: a scene in time."""
        ring = self.aoi
        if self.box is not None and ring is None:
            ring = outline_of(self.box)
        return self.replaced(
            velocity=None,
            box=None,
            aoi=ring,
            contacts=None,
            tops=None,
            tie=None,
            slivers=None,
            zones=None,
            throws=None,
        )

    def replaced(self, **changes: Any) -> SceneInputs:
        """
        Return these inputs with some changed.

        `horizons` and `faults` are merged by name, and None as a value removes one. What was stated
        of it counts again when it comes back, and a setting for all counts for what is added. All
        else is replaced; a box also replaces ``aoi="rectangle"``, which proposes one.

        Examples
        --------
        >>> inputs = SceneInputs({"Top": "top.gri"}, {"F1": "F1.ts"}, extend=["F1"])
        >>> inputs.replaced(horizons={"Base": "base.gri"}, faults={"F1": None}).names
        ('Top', 'Base')
        """
        for key in changes:
            refusal = f"a scene has no input {key!r}; its inputs are {', '.join(INPUTS)}."
            check_word(key, INPUTS, refusal)

        other = (changes.get("velocity", self.velocity) is None) != (self.velocity is None)
        if self.time is not None and other and self.box is not None and "box" not in changes:
            raise InputError(
                "velocity decides whether the box is in metres or in minus milliseconds. Give "
                "box=, too; scene.in_time() leaves it out."
            )

        # merged by name: replace(horizons={'Top': new}) leaves the others as they are
        horizons = exchanged("horizons", self.horizons, changes.get("horizons"))
        faults = exchanged("faults", self.given_faults, changes.get("faults"))

        settings = {key: changes.get(key, value) for key, value in self.settings.items()}
        merged = {
            **({"aoi": None} if self.takes_rectangle and changes.get("box") else {}),
            **self._of(settings, horizons, faults),
            **changes,
            "horizons": horizons,
            "faults": faults,
        }
        merged.update((key, or_empty(merged[key])) for key in OPTIONAL if key in merged)
        made = replace(self, **merged)
        made.settings.update(settings)
        return made

    def _of(
        self, settings: Mapping[str, Any], horizons: Mapping[str, Any], faults: Mapping[str, Any]
    ) -> dict[str, Any]:
        """Settings of some inputs alone: those of others wait until these come back."""

        def left(setting: Any, names: Container[str]) -> Any:
            """A setting of the names that are there; of whole faults where halves are gone."""
            if isinstance(setting, Mapping):
                at = {n: n if n in names else self.halves.whole_of(n) for n in setting}
                return {at[n]: value for n, value in setting.items() if at[n] in names}
            if isinstance(setting, tuple | list | set | frozenset):
                return tuple(n for n in setting if n in names)
            # one name alone, in place of names
            gone = (
                isinstance(setting, str) and setting in self.given_faults and setting not in names
            )
            return () if gone else setting

        kept_settings = {key: left(settings[key], horizons) for key in _OF_HORIZONS}
        kept_settings["truncations"] = left(or_empty(settings["truncations"]), faults)
        names = {
            *faults,
            *halves_of(kept_settings["truncations"], tuple(faults)).names(tuple(faults)),
        }
        kept_settings |= {key: left(settings[key], names) for key in _OF_NAMED_FAULTS}

        # where all trims are of faults that are gone, horizons are torn all the same; where all
        # horizons that were named are gone, the others stay as they are
        tear = tear_settings(settings["tear"], (*self.given_faults, *faults))
        if tear is not None:
            torn = replace(tear, trim=left(tear.trim, names) or "auto")
            tear = replace(torn, horizons=left(tear.horizons, horizons))
            kept_settings["tear"] = None if torn.horizons and not tear.horizons else tear
        throws = [
            replace(throw, horizons=left(throw.horizons, horizons))
            for throw in throws_of(settings["throws"])
            if not throw.horizons or left(throw.horizons, horizons)
        ]
        kept = left(dict.fromkeys(throw.fault for throw in throws), names)
        kept_settings["throws"] = [throw for throw in throws if throw.fault in kept]
        return kept_settings


_OF_NAMED_FAULTS = ("extend", "lengthen", "compartments")
_OF_FAULTS = ("truncations", "tear", "throws", *_OF_NAMED_FAULTS)
_OF_HORIZONS = ("column", "fill_empty_blocks")
# as `Scene` and `Scene.replace` call them
INPUTS = tuple(one.name for one in fields(SceneInputs) if one.init)
OPTIONAL = (
    "column",
    "contacts",
    "truncations",
    "regions",
    "zones",
)  # for which `Scene` takes None as well as {}


def refuse_assignment(name: str) -> NoReturn:
    """Refuse to change a scene in place, and name what to type instead."""
    if name in INPUTS:
        raise InputError(
            f"a scene cannot be changed, so scene.{name} cannot be set. Make a new one, which "
            f"shares all results that are still valid: scene = scene.replace({name}=...)."
        )
    raise InputError(
        f"a scene cannot be changed, and {name!r} is not one of its inputs. scene.replace takes "
        f"{', '.join(INPUTS)}.{did_you_mean(name, INPUTS)}"
    )


def or_empty(entries: Mapping[str, Entry] | None) -> Mapping[str, Entry]:
    """Return named inputs that may be left out; none of them instead of None."""
    return {} if entries is None else entries


def as_mapping(what: str, inputs: Any) -> dict[str, Any]:
    """Return named inputs, or raise an InputError that shows how to name them."""
    if not isinstance(inputs, Mapping):
        raise InputError(
            f"`{what}` must be a mapping such as {SAMPLES[what]}, not {type(inputs).__name__}."
        )
    named: dict[str, Any] = {}
    for key, value in inputs.items():
        # 1 and '1' are different keys, but one name
        name = str(key)
        if not name.strip() or name in named:
            fault = f"{name!r} twice, as text and as a number" if name.strip() else "an empty name"
            raise InputError(f"{what} has {fault}; give each a name of its own.")
        named[name] = value
    return named


def refuse_namesakes(**kinds: Mapping[str, Any]) -> None:
    """Refuse a name that two inputs have: results are requested by name."""
    if fault := shared_name((kind, name) for kind, inputs in kinds.items() for name in inputs):
        raise InputError(fault)


def check_scene_tolerance(tolerance: Any, horizons: Mapping[str, Any]) -> float | None:
    """Return the tolerance of a scene [m] or None; raise an InputError if it cannot be used."""
    if tolerance is None:
        return None
    if not (is_number(tolerance) and tolerance > 0):
        raise InputError(
            f"tolerance is {tolerance!r}; give a length above 0 m, or None for all nodes."
        )

    # ghosts mark a torn mesh that came as triangles
    for name, value in horizons.items():
        if isinstance(value, Sheet) or "ghost" in getattr(value, "vertex_data", ()):
            raise InputError(
                f"horizon {name!r} is a sheet torn at faults, and keeps all of its nodes. "
                "Leave tolerance out, or give the horizon as a grid that is not torn."
            )
    return float(tolerance)


def _held(setting: Any) -> Any:
    """A setting that nobody else can change: a mapping or names, else as it is."""
    if isinstance(setting, Mapping):
        return dict(setting)
    return type(setting)(setting) if isinstance(setting, list | set) else setting


def exchanged(what: str, inputs: Mapping[str, Any], changes: Any) -> dict[str, Any]:
    """Return named inputs with some exchanged, added, or (None) removed."""
    # None as a value removes an input, so a missing name is a slip
    changed = as_mapping(what, {} if changes is None else changes)
    for name, value in changed.items():
        if value is None:
            refusal = f"{what} has no {name!r} to remove; there are {list(inputs)}."
            check_word(name, inputs, refusal)
    return {name: one for name, one in {**inputs, **changed}.items() if one is not None}


def changing(inputs: SceneInputs) -> dict[Any, Any]:
    """Return all inputs that are read, by name; tops and area by tuples: names are words."""
    named = {**inputs.contacts, **inputs.faults, **inputs.horizons}
    named = {name: one for name, one in named.items() if not isinstance(one, MadeHorizon)}
    return {**named, ("tops",): inputs.tops, ("aoi",): inputs.aoi}


def are_one(first: Any, second: Any) -> bool:
    """Return whether two inputs are one object, or tuples of the same objects."""
    if isinstance(first, tuple | list) and isinstance(second, tuple | list):
        return len(first) == len(second) and all(map(operator.is_, first, second))
    return first is second


def paths_of(inputs: SceneInputs) -> dict[str, Path]:
    """Return the inputs that were given as paths, by name."""
    area = {} if inputs.takes_rectangle else {"area": inputs.aoi}
    surfaces = {**inputs.horizons, **inputs.given_faults, **inputs.contacts}
    regions = {f"region: {name}": one for name, one in inputs.regions.items()}
    files = {**surfaces, "well tops": inputs.tops, **area, **regions}.items()
    return {name: Path(one) for name, one in files if isinstance(one, str | os.PathLike)}


def as_milliseconds(value: Any) -> Any:
    """Return data that a reader has turned into milliseconds, marked as such."""
    if hasattr(value, "data_vars"):
        return value.assign(elevation=value["elevation"].assign_attrs(units="ms"))
    return value.assign_attrs(units="ms")


def in_time_unit(value: Any, what: str, unit: str | None) -> Any:
    """
    Return an input of a scene in time; its declared unit as one that readers take.

    Raises
    ------
    InputError
        If it declares a length, or holds bare numbers and the scene is not in ms.
    """
    if isinstance(value, str | Path):
        return value
    if not hasattr(value, "attrs"):
        if unit is not None and unit.strip().lower() not in ("ms", "msec"):
            raise InputError(
                f"{what} has no unit of its own, and the scene is in {unit!r}. Give its elevations "
                'as minus milliseconds, and length_unit="ms".'
            )
        return value
    vertical = value
    if hasattr(value, "data_vars"):
        key = "elevation" if "elevation" in value.variables else "depth"
        vertical = value[key] if key in value.variables else value
    stated = vertical.attrs.get("units")
    if stated is None:
        return value
    if not is_time_unit(stated):
        raise InputError(
            f"{what} is in {stated!r}, and the scene is in time. Set attrs['units'] = 'ms' if it "
            "is in time, too; else leave time= out."
        )
    if vertical is value:
        return value.assign_attrs(units=TimeUnit(stated))
    return value.assign({key: vertical.assign_attrs(units=TimeUnit(stated))})


def undeclared(value: Any, options: Mapping[str, Any]) -> dict[str, Any]:
    """The options of a scene that an input does not declare itself."""
    if isinstance(value, FaultSticks):
        return {}  # metres, elevation positive up: a reader has turned what a file held
    attrs = dict(getattr(value, "attrs", {}))
    if hasattr(value, "data_vars"):  # a fault: the name of its third variable states the direction
        height = "elevation" if "elevation" in value.variables else "depth"
        # its attributes count, as for triangulate_fault; those of the whole do not
        attrs = {"positive": None, **(value[height].attrs if height in value.variables else {})}

    attribute = {"length_unit": "units"}  # the name that CF gives it
    return {
        key: word
        for key, word in options.items()
        if word is not None and attribute.get(key, key) not in attrs
    }


# ---- maps ----------------------------------------
# Maps of properties, given or read as horizons are.


def factors_of_rock(values: Sequence[Any], crs: str | None, *, drawn: bool = False) -> list[Factor]:
    """Return the first four arguments of `Scene.volumetrics`, checked, with maps as grids.

    Distributions are refused unless numbers are drawn from them.
    """
    given = dict(zip(ARGUMENTS, values, strict=True))
    factors = factors_of(given, lambda value, name: opened_map(value, name, crs))
    for factor in factors:
        if not drawn and any(map(is_distribution, factor.entries.values())):
            raise InputError(
                f"{factor.name} has a distribution, but one scene has one value. Give a number, or "
                "draw many: run_ensemble(scene, volumetrics={...})."
            )
    return factors


def opened_map(value: Any, name: str, crs: str | None, *, unit: str = "1") -> Lattice:
    """
    Return the grid of a map of a property, given or read as a horizon is.

    Parameters
    ----------
    value : xarray.DataArray or path
        Fractions or other ratios, in place of elevations.
    name : str
        Of the argument, for messages.
    crs : str or None
        Of the scene.
    unit : {"1", "m", "m/s"}
        Of the values: ratios; lengths, which a map may have in another unit; or velocities.

    Raises
    ------
    InputError
        For other things, values with another unit, or another reference system.
    """
    if isinstance(value, str | Path):
        length_unit = Otherwise("m") if unit == "m" else Ratio(unit)
        words: Any = {"positive": Otherwise("up"), "length_unit": length_unit}
        value = read_horizon(value, **words)
    stated = getattr(value, "attrs", {}).get("units", "m")
    if unit != "m":
        check_ratio(stated, f"the map of {name}", unit)
        stated = "m"
    surface = horizon_over(value, (), name=name, positive="up", length_unit=stated, noun="map of")
    if surface.lattice is None:
        raise InputError(f"the map of {name} is a mesh. Give a grid over easting and northing.")
    if crs is not None and surface.crs is not None:
        refuse_other_crs(f"map of {name}", surface.crs, {"scene": crs})
    return surface.lattice
