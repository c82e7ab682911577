"""A scenario file -> `Scenario`, or all of its mistakes with their lines; no surface is read.

First each value is checked by itself (`read_table`), then values against each other. A mistake is
noted with the path of its value, and the check goes on with what is right.
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from geosurf.carve.column import reservoir_of
from geosurf.carve.fluids import interval, parse_sides
from geosurf.conventions import did_you_mean, grouped, shared_name
from geosurf.errors import InputError, ScenarioError
from geosurf.faults.rules import Rule, faults_at, halves_of, read_truncations
from geosurf.measure.seal import vshale_of
from geosurf.measure.volumetrics import factors_of, fluid_of, fluids_rule, unknown_fluid
from geosurf.model.column import ELSEWHERE, in_column, read_compartments, zones_of
from geosurf.model.expected import path_of
from geosurf.model.network import filling_by_horizon
from geosurf.read._guard import opened
from geosurf.scenario.keys import (
    ContactInput,
    FaultInput,
    HorizonInput,
    Scenario,
    ThrowInput,
    TruncationInput,
    check_faults,
)
from geosurf.scenario.output_keys import check_uncertain
from geosurf.scenario.toml_text import lines_of_keys, mistake_of_toml, with_settings
from geosurf.scenario.values import KeyPath, Keys, Mistake, read_table

# ---- tear checks ----------------------------------------
# Checks of ``[tear]`` and ``[[throws]]``: with each other, and with the rest of a scenario.


# ---- truncations ----------------------------------------
# Truncations of a scenario; older faults that a younger one splits become two faults.


def truncations_of(scenario: Scenario) -> dict[str, tuple[tuple[str, str, bool], ...]]:
    """Return the truncations of a scenario as `Scene` takes them."""
    # A fault may end at several others: rules add up in the order of the file.
    rules = ((one.fault, (one.main, one.keep, one.extend)) for one in scenario.truncations)
    return {fault: tuple(of) for fault, of in grouped(rules).items()}


def with_halves(scenario: Scenario) -> Scenario:
    """
    Return the scenario with two halves for each fault that ends at another one on both sides.

    Parameters
    ----------
    scenario : Scenario

    Returns
    -------
    Scenario
        Halves have the file, extension, throws and trim of the fault. The same one where no
        fault is split.

    Raises
    ------
    InputError
        As `geosurf.faults.rules.halves_of`.
    """
    # `keep = "both"` splits the older fault; its name stands for both halves everywhere else.
    halves = halves_of(truncations_of(scenario), scenario.fault_names)
    if not halves.parts:
        return scenario
    faults = tuple(
        replace(entry, name=part, name_in_file=_in_file(entry))
        for entry in scenario.faults
        for part in halves.names([entry.name])
    )
    truncations = tuple(
        TruncationInput(fault=fault, main=main, keep=keep, extend=extend)
        for fault, rules in halves.truncations.items()
        for main, keep, extend in rules
    )
    # Both halves move as the whole fault did.
    throws = tuple(
        replace(entry, fault=part)
        for entry in scenario.throws
        for part in halves.names([entry.fault])
    )
    # A trim by fault applies to both halves.
    tear = scenario.tear
    if tear is not None:
        tear = replace(tear, trim_cells=halves.spread(tear.trim_cells))
    return replace(scenario, faults=faults, truncations=truncations, throws=throws, tear=tear)


def _in_file(entry: FaultInput) -> str | None:
    """What a half is called in the file of its fault."""
    return None if entry.file is None else entry.name_in_file or entry.name


def rules_of(scenario: Scenario) -> tuple[Rule, ...]:
    """Return the truncations of a scenario, checked: by faults and by horizons."""
    given = truncations_of(scenario)
    return read_truncations(given, scenario.fault_names, scenario.horizon_names)


def horizon_rules_of(scenario: Scenario) -> tuple[Rule, ...]:
    """Return the truncations of faults by horizons."""
    return tuple(rule for rule in rules_of(scenario) if rule.main in scenario.horizon_names)


def faults_reaching(scenario: Scenario, horizon: str) -> tuple[str, ...]:
    """Return the faults that no horizon ends before they reach a horizon."""
    # A fault that ends at a younger horizon does not reach the ones above it.
    ending = faults_at(horizon, scenario.horizon_names, horizon_rules_of(scenario))
    return tuple(name for name in scenario.fault_names if name not in ending)


# Keys that describe the ellipse of `elliptic_m`, and nothing else.
ELLIPSE = ("half_length_m", "half_height_m", "centre_along_m", "centre_elevation_m")


def check_tears(scenario: Scenario, at: KeyPath) -> None:
    """Refuse settings of ``[tear]`` and ``[[throws]]`` that contradict others."""
    # By kind, for messages that list them.
    known = {"fault": scenario.fault_names, "horizon": scenario.horizon_names}
    given: set[tuple[str, str]] = set()  # pairs of fault and horizon that have a throw already
    for row, entry in enumerate(scenario.throws):
        with at.of(f"throws[number {row + 1}]").noting() as place:
            _check_throw(scenario, entry, known, given, place)
    if scenario.tops is not None and scenario.tops.tie and scenario.throws:
        at.of("tops", "tie").note(
            "tops.tie cannot be combined with [[throws]]: throw moves horizons off their tops. "
            "Set tie = false; the report still lists the misfit of each top."
        )

    # curves of sheets are where the model has them; a tolerance would have no effect there
    place = at.of("tolerance_m")
    with place.noting():
        if scenario.tolerance_m is not None and (scenario.tear is not None or scenario.throws):
            table = "[tear]" if scenario.tear is not None else "[[throws]]"
            place.refuse(
                f"tolerance_m = {scenario.tolerance_m:g} cannot be combined with {table}: curves "
                "of torn horizons are exact, and end on their faults. Remove one of them."
            )
        if scenario.tolerance_m is not None and (ends := horizon_rules_of(scenario)):
            place.refuse(
                f"tolerance_m = {scenario.tolerance_m:g} cannot be combined with the truncation of "
                f"{ends[0].fault!r} by horizon {ends[0].main!r}: it would move the curve "
                "in which the fault ends. Remove one of them."
            )
    if scenario.tear is None:
        return
    with at.of("tear", "fill_empty_blocks").noting("[tear]: "):
        torn = scenario.tear.horizons or known["horizon"]
        filling_by_horizon(scenario.tear.fill_empty_blocks, torn)
    trims = scenario.tear.trim_cells
    named = {"fault": trims if isinstance(trims, dict) else (), "horizon": scenario.tear.horizons}
    for (kind, names), key in zip(named.items(), ("trim_cells", "horizons"), strict=True):
        for name in names:
            with at.of("tear", key).noting() as place:
                place.refuse_unknown(f"tear.{key}", kind, name, known[kind])

    # a horizon is torn from its data or by throws, never both
    for row, entry in enumerate(scenario.throws):
        with at.of(f"throws[number {row + 1}]").noting() as place:
            for name in entry.horizons or known["horizon"]:
                if is_torn_as_picked(scenario, name):
                    place.refuse(
                        f"horizon {name!r} is torn twice: by [tear], and by the throw of "
                        f"{entry.fault!r}. Select the horizons of each with horizons = [...]."
                    )


def _check_throw(
    scenario: Scenario,
    entry: ThrowInput,
    known: Mapping[str, tuple[str, ...]],
    given: set[tuple[str, str]],
    at: KeyPath,
) -> None:
    """A throw is given once, in one form, for a fault and horizons that exist."""
    label = f"throws of {entry.fault!r}"
    at.inside("fault").refuse_unknown(label, "fault", entry.fault, known["fault"])
    for name in entry.horizons:
        at.inside("horizons").refuse_unknown(label, "horizon", name, known["horizon"])

    # throw has one form; lengths of the ellipse need that form
    throws = (entry.throw_m, entry.profile_m, entry.elliptic_m)
    if sum(throw is not None for throw in throws) != 1:
        at.refuse(f"{label}: give exactly one of throw_m, profile_m and elliptic_m.")
    for name in entry.horizons:
        if entry.fault not in faults_reaching(scenario, name):
            at.inside("horizons").refuse(
                f"{label}: a truncation ends {entry.fault!r} at a horizon before it reaches "
                f"{name!r}. Leave {name!r} out of horizons, or remove the truncation."
            )
    for word in ELLIPSE if entry.elliptic_m is None else ():
        if getattr(entry, word) is not None:
            at.inside(word).refuse(
                f"{label}: {word} needs elliptic_m. Add elliptic_m, or remove {word}."
            )

    # without a list, the throw applies to all horizons
    for name in entry.horizons or known["horizon"]:
        if (entry.fault, name) in given:
            at.refuse(f"{label} are given twice for horizon {name!r}; delete one.")
        given.add((entry.fault, name))


def is_torn_as_picked(scenario: Scenario, name: str) -> bool:
    """Return whether ``[tear]`` tears a horizon as it was picked."""
    tear = scenario.tear
    return tear is not None and (not tear.horizons or name in tear.horizons)


OF_SEVERAL = (".epc", ".ts")  # files that hold several surfaces
OF_VARIABLES = (".nc", ".zarr")  # files that hold several variables
MOST_NOTED = 9  # mistakes in one error


@dataclass(frozen=True)
class MistakeOnLine:
    """One mistake.

    Attributes
    ----------
    line : int or None
        Where it is, counted from 1; None if it belongs to no line.
    sentence : str
        What is wrong, and what to write.
    """

    line: int | None
    sentence: str

    def in_file(self, path: str | os.PathLike[str]) -> str:
        """Return the sentence behind the place."""
        return f"{path}{'' if self.line is None else f', line {self.line}'}: {self.sentence}"


def read_scenario(path: str | os.PathLike[str], settings: Sequence[str] = ()) -> Scenario:
    r"""
    Read and check a scenario; no surface is read yet.

    Parameters
    ----------
    path : path-like
        A TOML file; docs/scenario.md has its keys.
    settings : sequence of str
        Keys that have another value than in the file, each ``key=value``: see `with_settings`.

    Returns
    -------
    Scenario

    Raises
    ------
    ScenarioError
        If the file does not exist or is not TOML, or has an unknown key, a missing one, a value of
        the wrong type, or a name used twice. Further mistakes are its notes, each with its line.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "scenario.toml"
    >>> _ = file.write_text("titel = 'A'\n[box]\neasting_m = [0, 6000]\n")
    >>> try:
    ...     read_scenario(file)
    ... except ScenarioError as error:
    ...     str(error).partition("; ")[0].removeprefix(str(file))
    ", line 1: unknown key 'titel'"
    """
    path = path_of(path, "a scenario")
    scenario, mistakes = _examined(path, settings)
    if scenario is None or mistakes:
        lines = [one.in_file(path) for one in mistakes]
        error = ScenarioError(lines[0])
        for line in lines[1:MOST_NOTED]:
            error.add_note(line)
        if len(lines) > MOST_NOTED:
            error.add_note(f"and {len(lines) - MOST_NOTED} more: geosurf validate lists all.")
        raise error
    return scenario


def find_mistakes(
    path: str | os.PathLike[str], settings: Sequence[str] = ()
) -> list[MistakeOnLine]:
    r"""
    Return all mistakes of a scenario, in the order of their lines.

    Parameters
    ----------
    path, settings
        As for `read_scenario`.

    Returns
    -------
    list of MistakeOnLine
        Empty if the scenario can be run. Files are only looked for, not read.

    Raises
    ------
    ScenarioError
        If the file does not exist.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "scenario.toml"
    >>> _ = file.write_text("titel = 'A'\n[[horizons]]\nname = 'Top'\nfile = 'Top.gri'\n")
    >>> [(one.line, one.sentence.split(";")[0].split(",")[0]) for one in find_mistakes(file)]
    [(1, "unknown key 'titel'"), (4, "horizons['Top'].file is 'Top.gri'")]
    """
    return _examined(path_of(path, "a scenario"), settings)[1]


def _examined(path: Path, settings: Sequence[str]) -> tuple[Scenario | None, list[MistakeOnLine]]:
    """The scenario, None if it lacks what it needs, and its mistakes."""
    text = text_of(path)
    try:
        written = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        return None, [MistakeOnLine(*mistake_of_toml(text, error))]
    data = with_settings(written, settings, path)
    scenario, mistakes = _checked(path, data, tuple(settings))

    # what --set gives has no line; a key is on the line of its table if it has none
    lines: dict[Keys, int | None] = {**lines_of_keys(text)}
    lines |= dict.fromkeys(_changes(written, data))
    located = []
    for mistake in mistakes:
        keys = mistake.keys
        while keys and keys not in lines:
            keys = keys[:-1]
        located.append(MistakeOnLine(lines.get(keys), mistake.sentence))
    return scenario, sorted(located, key=lambda mistake: (mistake.line is None, mistake.line))


def _changes(before: Any, after: Any, at: Keys = ()) -> Iterator[Keys]:
    """The keys whose values differ, those of new tables too."""
    if isinstance(before, dict) and isinstance(after, dict):
        for word in after:
            yield from _changes(before.get(word), after[word], (*at, word))
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for k, (old, new) in enumerate(zip(before, after, strict=True)):
            yield from _changes(old, new, (*at, k))
    elif before != after:
        yield at
        if isinstance(after, dict):
            yield from ((*at, word) for word in after)


def _checked(
    path: Path, data: Mapping[str, Any], settings: tuple[str, ...]
) -> tuple[Scenario, list[Mistake]]:
    """The scenario that a file holds, and its mistakes."""
    at = KeyPath(path)
    scenario: Scenario = read_table(Scenario, at, data, path=path, settings=settings)
    wrong = [*at.found]
    with at.of("truncations").noting():
        # Before names are checked: other tables may refer to halves.
        scenario = with_halves(scenario)
    with at.of("zones").noting():
        scenario = with_made_horizons(scenario)
    _check_names(scenario, at)
    check_uncertain(scenario, at)

    # what follows from a value that is wrong by itself is no mistake of its own
    later = [
        one
        for one in at.found[len(wrong) :]
        if not one.keys or not any(other.keys[: len(one.keys)] == one.keys for other in wrong)
    ]
    return scenario, [*wrong, *dict.fromkeys(later)]


def text_of(path: Path) -> str:
    """Return the text of a scenario, with line feeds at the ends of lines."""
    try:
        with opened(path) as (file, _):
            # utf-8-sig: Windows editors write a byte order mark; TOML knows two line ends, old
            # files a third
            text = file.read().decode("utf-8-sig")
        return text.replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        raise ScenarioError(
            f"{path}: byte {error.start} is not UTF-8 text. Give a scenario (TOML), saved as UTF-8."
        ) from error
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise ScenarioError(f"{path}: cannot be read ({reason}). Check the path.") from error
    except InputError as error:  # no file, or a pipe, a folder, a device
        inside = path / "scenario.toml"
        here = f" Did you mean '{inside}'?" if inside.is_file() else ""
        if not path.exists() and path.parent.is_dir():
            here = did_you_mean(path.name, [one.name for one in path.parent.glob("*.toml")])
        raise ScenarioError(f"{error}{here}") from error


def with_made_horizons(scenario: Scenario) -> Scenario:
    """The scenario with the horizons that its zones make: names are checked with them."""
    if not scenario.zones:
        return scenario
    given = {entry.name: entry for entry in scenario.horizons}
    order = in_column(zones_of(scenario.zones, tuple(given)), given)
    made = (given.get(name) or HorizonInput(name=name, file=None) for name in order)
    return replace(scenario, horizons=tuple(made))


def _check_names(scenario: Scenario, at: KeyPath) -> None:
    """Names are unique over horizons and faults, and there is a horizon."""
    # a sealed model brings surfaces and names of its own
    if scenario.model is not None:
        _check_model(scenario, at)
        return
    if not scenario.horizons:
        at.of("horizons").note("no horizons are given. Add a table [[horizons]] or [model].")
    check_faults(scenario.faults, at)
    _check_places(scenario, at)

    with at.noting():
        if (scenario.time is None) != (scenario.velocity is None):
            at.refuse(
                "time and [velocity] belong together: write how times count, as in "
                'time = "two-way", and a velocity for each zone.'
            )
        if scenario.time is not None and (scenario.throws or scenario.tolerance_m is not None):
            at.refuse("[[throws]] and tolerance_m cannot be combined with time. Leave them out.")

    # results are requested by name: no two surfaces share one
    lists = (("horizon", scenario.horizons), ("fault", scenario.faults))
    named = [(kind, entry.name) for kind, entries in lists for entry in entries]
    for k, (kind, name) in enumerate(named):
        if name in [one for _, one in named[:k]] and (fault := shared_name(named)):
            at.of(f"{kind}s[{name!r}]", "name").note(fault)
    _check_files(scenario, at)
    with at.of("compartments").noting():
        read_compartments(scenario.compartments, scenario.fault_names)
    _check_contacts(scenario, at)
    _check_volumetrics(scenario, at)
    _check_seal(scenario, at)
    _check_grid(scenario, at)
    with at.of("truncations").noting():
        rules_of(scenario)
        check_tears(scenario, at)

    # pictures refer to surfaces by name, too
    surfaces = [name for _, name in named]
    for name in scenario.output.search or ():
        with at.of("output", "search").noting() as place:
            place.refuse_unknown("output.search", "surface", name, surfaces)


def _check_files(scenario: Scenario, at: KeyPath) -> None:
    """Two horizons do not come from the same data: nothing would lie between them."""
    seen: dict[tuple[object, ...], str] = {}
    for entry in scenario.horizons:
        if entry.file is None:  # made by a zone
            continue
        data = entry.file.resolve(), entry.variable, entry.columns
        if data[0] == scenario.path.resolve():  # what stands for a file that is not there
            continue
        if data[0].suffix.lower() in OF_SEVERAL:  # the name of the horizon picks the surface
            continue
        place = at.of(f"horizons[{entry.name!r}]", "file")
        if data in seen:
            remedy = "Correct one of them."
            if data[0].suffix.lower() in OF_VARIABLES:
                remedy = "Correct one of them, or give each its variable, as in variable = 'Top'."
            place.note(
                f"horizons[{entry.name!r}].file is that of horizon {seen[data]!r}, "
                f"{entry.file}, so that nothing lies between them. {remedy}"
            )
        seen[data] = entry.name


def _check_model(scenario: Scenario, at: KeyPath) -> None:
    """A sealed model comes alone: it has its surfaces, its box, and its faults as they are."""
    for word in ("horizons", "zones", "faults", "truncations", "tear", "throws", "box"):
        if getattr(scenario, word) or (word == "truncations" and scenario.network.apply):
            at.of(word).note(
                f"[model] and {word} cannot be combined: a sealed model has its own. Remove one."
            )
    if scenario.tops is not None and scenario.tops.tie:
        at.of("tops", "tie").note(
            "[model] and tops.tie cannot be combined: a sealed model stays as it is."
        )
    _check_places(scenario, at)


def _check_places(scenario: Scenario, at: KeyPath) -> None:
    """A contact and an area of interest are each given once, in one way."""
    given = set()
    for entry in scenario.contacts:
        label = f"contacts[{entry.name!r}]"
        place = at.of(label)
        # one contact may have several tables, each for its own block and zones
        where = entry.name, entry.block, tuple(sorted(entry.zones))
        with place.noting():
            if (entry.elevation_m is None) == (entry.file is None):
                place.refuse(f"{label}: give either elevation_m or file.")
            if where in given:
                block = "without a block" if entry.block is None else f"for block {entry.block!r}"
                zones = f" of {', '.join(entry.zones)}" if entry.zones else ""
                place.refuse(f"{label} is given {block}{zones} twice; delete one.")
        given.add(where)
        with place.noting():
            _check_level(scenario, entry, place.inside("elevation_m"))

    # three ways to give an area, of which exactly one is set
    aoi, place = scenario.aoi, at.of("aoi")
    with place.noting():
        if aoi is not None and (aoi.file, aoi.corners_m, aoi.rectangle or None).count(None) != 2:
            place.refuse("aoi: give one of file, corners_m, rectangle.")
        if aoi is not None and aoi.rectangle and scenario.box is not None:
            place.refuse("aoi.rectangle proposes a box, and [box] is given as well; remove one.")


def _check_level(scenario: Scenario, entry: ContactInput, at: KeyPath) -> None:
    """A level contact is an elevation inside the box; a depth is refused, whatever files hold."""
    level = entry.elevation_m
    if level is None:
        return
    label = f"contacts[{entry.name!r}].elevation_m is {level:g}"
    if scenario.box is not None:
        low, high = scenario.box.elevation_m
        if not low < level < high:
            at.refuse(
                f"{label}, outside of the model ([box] elevation_m = [{low:g}, {high:g}]). "
                "Elevation is positive up, so depths are negative. Correct it, or enlarge the box."
            )
    elif level > 0 and "down" in (entry.positive, scenario.positive):
        at.refuse(
            f'{label}, above sea level, and positive = "down" states that files hold depths. '
            f"Elevation is positive up: write {-level:g}. If the contact is above sea level, give "
            "a [box] that reaches above it."
        )


def _check_contacts(scenario: Scenario, at: KeyPath) -> None:
    """Zones and sides of faults that are named exist, before anything is read."""
    if not scenario.contacts and scenario.reservoir is None and not scenario.regions:
        return

    # zones are named from the horizons before a grid is read: a misspelt zone costs no run
    with at.of("horizons").noting():
        zones = scenario.zone_names

        # the horizons of a sealed model are not known yet
        with at.of("reservoir").noting():
            if scenario.model is None:
                reservoir_of(zones, scenario.reservoir)

        # a block is named by sides of faults, such as 'F1+ F2-'
        faults = scenario.fault_names
        sides = [name + sign for name in faults for sign in "+-"]
        for name, named in (scenario.regions or {}).items():
            with at.of("regions", name).noting() as place:
                for side in named if isinstance(named, tuple) and isinstance(named[0], str) else ():
                    place.refuse_unknown(f"regions.{name}", "side", side, sides)
        for entry in scenario.contacts:
            label = f"contacts[{entry.name!r}]"
            with at.of(label, "zones").noting() as place:
                for zone in entry.zones:
                    place.refuse_unknown(label, "zone", zone, zones)
            with at.of(label, "block").noting() as place:
                if entry.block not in (None, ELSEWHERE) and not parse_sides(entry.block, faults):
                    known = ", ".join(map(repr, sides)) or "none"
                    place.refuse(
                        f"{label}: unknown block {entry.block!r}. Name sides of faults: {known}."
                        f"{did_you_mean(entry.block, sides)}"
                    )


def _check_volumetrics(scenario: Scenario, at: KeyPath) -> None:
    """Numbers of ``[volumetrics]`` can be, and none needs another key; maps are not read."""
    if scenario.volumetrics is None:
        return
    with at.of("volumetrics").noting():
        factors_of(vars(scenario.volumetrics), lambda *_: None)
        rule = fluids_rule(scenario.volumetrics.fluids)
        if scenario.volumetrics.water_saturation is None or scenario.model is not None:
            return

        # what units will be called; if fluids name regions or blocks, only the model can tell
        intervals: dict[str, list[tuple[str, ...]]] = {}
        for zone in reservoir_of(scenario.zone_names, scenario.reservoir):
            above = [one.name for one in scenario.contacts if zone in (one.zones or (zone,))]
            names = list(dict.fromkeys(above))
            intervals[zone] = [(interval(names, k), *names[:k]) for k in range(len(names) + 1)]
        known = {*intervals, *(part[0] for parts in intervals.values() for part in parts)}
        if set().union(*rule.entries) <= known:
            for zone, parts in intervals.items():
                for contact, *beneath in parts:
                    unit = SimpleNamespace(name=zone, contact=contact, beneath=beneath)
                    if not fluid_of(unit, {zone, contact}, rule):
                        raise unknown_fluid(f"{zone!r} {contact}".strip(), contact or zone)


def _check_seal(scenario: Scenario, at: KeyPath) -> None:
    """Zones of ``[seal]`` are those of the model."""
    if scenario.seal is not None:
        with at.of("seal").noting() as place:
            vshale_of(scenario, scenario.seal.vshale)
            if scenario.seal.permeability_md is not None and scenario.grid is None:
                place.refuse("permeability_md is of the cells of [grid]. Add [grid].")


def _check_grid(scenario: Scenario, at: KeyPath) -> None:
    """Layers of the simulation grid are of zones that exist: a misspelt zone costs no run."""
    if scenario.grid is None:
        return
    from geosurf.grid.pillars import layers_of  # loaded by those who want a grid

    with at.of("grid", "layers").noting("grid.layers: "):
        zones = scenario.zone_names
        layers_of(scenario.grid.layers, zones, zones[1:-1])
