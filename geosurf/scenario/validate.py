"""A scenario file -> `Scenario`, with all names and rules checked before a surface is read."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from geosurf.carve.column import names_of_zones
from geosurf.carve.fluids import parse_sides
from geosurf.conventions import did_you_mean, shared_name
from geosurf.errors import InputError, ScenarioError
from geosurf.faults.rules import Rule, faults_at, read_truncations
from geosurf.model.column import ELSEWHERE
from geosurf.model.compartments import read_compartments
from geosurf.model.empty_blocks import filling_by_horizon
from geosurf.model.expected import path_of
from geosurf.read._guard import opened
from geosurf.scenario.ensemble_keys import check_uncertain
from geosurf.scenario.fault_keys import check_faults
from geosurf.scenario.keys import Scenario
from geosurf.scenario.settings import with_settings
from geosurf.scenario.toml_mistakes import mistake_of_toml
from geosurf.scenario.truncations import truncations_of, with_halves
from geosurf.scenario.values import KeyPath, read_table

# Keys that describe the ellipse of `elliptic_m`, and nothing else.
ELLIPSE = ("half_length_m", "half_height_m", "centre_along_m", "centre_elevation_m")

OF_SEVERAL = (".epc", ".ts")  # files that hold several surfaces
OF_VARIABLES = (".nc", ".zarr")  # files that hold several variables


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
        If the file does not exist or is not TOML (with the line), or has an unknown key, a
        missing one, a value of the wrong type, or a name used twice.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "scenario.toml"
    >>> _ = file.write_text("[box]\neasting_m = [0, 6000]\nnorthing = [0, 5000]\n")
    >>> try:
    ...     read_scenario(file)
    ... except ScenarioError as error:
    ...     str(error).partition("; ")[0].removeprefix(f"{file}: ")
    "unknown key 'northing' in box"
    """
    path = path_of(path, "a scenario")
    data = with_settings(parsed(path, text_of(path)), settings, path)
    return checked_scenario(path, data, tuple(settings))


def checked_scenario(
    path: Path, data: Mapping[str, Any], settings: tuple[str, ...] = ()
) -> Scenario:
    """Return the scenario that a file holds, or raise a `ScenarioError` at its first mistake."""
    # two passes: each value by itself (`read_table`), then values against each other
    scenario: Scenario = read_table(Scenario, KeyPath(path), data, path=path, settings=settings)
    try:
        # Before names are checked: other tables may refer to halves.
        scenario = with_halves(scenario)
    except InputError as error:
        KeyPath(path).refuse(str(error))
    _check_names(scenario)
    check_uncertain(scenario, KeyPath(path))
    return scenario


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


def parsed(path: Path, text: str) -> dict[str, Any]:
    """Return what the text of a scenario holds."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        line, sentence, _ = mistake_of_toml(text, error)
        where = "" if line is None else f" line {line}:"
        raise ScenarioError(f"{path}:{where} {sentence}") from error


def _check_names(scenario: Scenario) -> None:
    """Names are unique over horizons and faults, and there is a horizon."""
    at = KeyPath(scenario.path)

    # a sealed model brings surfaces and names of its own
    if scenario.model is not None:
        _check_model(scenario, at)
        return
    if not scenario.horizons:
        at.refuse("no horizons are given. Add a table [[horizons]] or [model].")
    check_faults(scenario.faults, at)
    _check_places(scenario, at)

    # results are requested by name: no two surfaces share one
    lists = (("horizon", scenario.horizons), ("fault", scenario.faults))
    named = [(kind, entry.name) for kind, entries in lists for entry in entries]
    if fault := shared_name(named):
        at.refuse(fault)
    _check_files(scenario, at)
    _check_compartments(scenario, at)
    _check_contacts(scenario, at)
    _check_grid(scenario, at)
    try:
        rules_of(scenario)
    except InputError as error:
        at.refuse(str(error))
    _check_sheets(scenario, at)

    # pictures refer to surfaces by name, too
    surfaces = [name for _, name in named]
    for name in scenario.output.search or ():
        if name not in surfaces:
            known = ", ".join(map(repr, surfaces))
            at.refuse(
                f"output.search: unknown surface {name!r}. Surfaces are {known}."
                f"{did_you_mean(name, surfaces)}"
            )


def _check_files(scenario: Scenario, at: KeyPath) -> None:
    """Two horizons do not come from the same data: nothing would lie between them."""
    seen: dict[tuple[object, ...], str] = {}
    for entry in scenario.horizons:
        data = entry.file.resolve(), entry.variable, entry.columns
        if data[0] == scenario.path.resolve():  # what stands for a file that is not there
            continue
        if data[0].suffix.lower() in OF_SEVERAL:  # the name of the horizon picks the surface
            continue
        if data in seen:
            remedy = "Correct one of them."
            if data[0].suffix.lower() in OF_VARIABLES:
                remedy = "Correct one of them, or give each its variable, as in variable = 'Top'."
            at.refuse(
                f"horizons[{entry.name!r}].file is that of horizon {seen[data]!r}, {entry.file}, "
                f"so that nothing lies between them. {remedy}"
            )
        seen[data] = entry.name


def _check_compartments(scenario: Scenario, at: KeyPath) -> None:
    """Faults that virtual walls continue exist, and what they end at."""
    try:
        read_compartments(scenario.compartments, [entry.name for entry in scenario.faults])
    except InputError as error:
        at.refuse(str(error))


def _check_model(scenario: Scenario, at: KeyPath) -> None:
    """A sealed model comes alone: it has its surfaces, its box, and its faults as they are."""
    # one at a time, so that the message can name the table to remove
    for word in ("horizons", "faults", "truncations", "tear", "throws", "box"):
        if getattr(scenario, word) or (word == "truncations" and scenario.network.apply):
            at.refuse(
                f"[model] and {word} cannot be combined: a sealed model has its own. Remove one."
            )
    if scenario.tops is not None and scenario.tops.tie:
        at.refuse("[model] and tops.tie cannot be combined: a sealed model stays as it is.")
    _check_places(scenario, at)


def _check_places(scenario: Scenario, at: KeyPath) -> None:
    """A contact and an area of interest are each given once, in one way."""
    given = set()
    for entry in scenario.contacts:
        label = f"contacts[{entry.name!r}]"
        if (entry.elevation_m is None) == (entry.file is None):
            at.refuse(f"{label}: give either elevation_m or file.")

        # one contact may have several tables, each for its own block and zones
        where = entry.name, entry.block, tuple(sorted(entry.zones))
        if where in given:
            block = "without a block" if entry.block is None else f"for block {entry.block!r}"
            zones = f" of {', '.join(entry.zones)}" if entry.zones else ""
            at.refuse(f"{label} is given {block}{zones} twice; delete one.")
        given.add(where)

    # three ways to give an area, of which exactly one is set
    aoi = scenario.aoi
    if aoi is not None and (aoi.file, aoi.corners_m, aoi.rectangle or None).count(None) != 2:
        at.refuse("aoi: give one of file, corners_m, rectangle.")
    if aoi is not None and aoi.rectangle and scenario.box is not None:
        at.refuse("aoi.rectangle proposes a box, and [box] is given as well; remove one.")


def _check_contacts(scenario: Scenario, at: KeyPath) -> None:
    """Zones and sides of faults that contacts are given for exist, before anything is read."""
    if not scenario.contacts:
        return

    # zones are named from the horizons before a grid is read: a misspelt zone costs no run
    try:
        zones = names_of_zones([entry.name for entry in scenario.horizons])
    except InputError as error:
        at.refuse(str(error))

    # a block is named by sides of faults, such as 'F1+ F2-'
    faults = [entry.name for entry in scenario.faults]
    sides = [name + sign for name in faults for sign in "+-"]
    for entry in scenario.contacts:
        label = f"contacts[{entry.name!r}]"
        for zone in entry.zones:
            if zone not in zones:
                known = ", ".join(map(repr, zones))
                guess = did_you_mean(zone, zones)
                at.refuse(f"{label}: unknown zone {zone!r}. Zones are {known}.{guess}")
        if entry.block not in (None, ELSEWHERE) and parse_sides(entry.block, faults) is None:
            known = ", ".join(map(repr, sides)) or "none"
            at.refuse(
                f"{label}: unknown block {entry.block!r}. Name sides of faults: {known}."
                f"{did_you_mean(entry.block, sides)}"
            )


def _check_grid(scenario: Scenario, at: KeyPath) -> None:
    """Layers of the simulation grid are of zones that exist: a misspelt zone costs no run."""
    if scenario.grid is None:
        return
    from geosurf.grid.layers import layers_of  # loaded by those who want a grid

    zones = names_of_zones([entry.name for entry in scenario.horizons])
    try:
        layers_of(scenario.grid.layers, zones, zones[1:-1])
    except InputError as error:
        at.refuse(f"grid.layers: {error}")


def _check_sheets(scenario: Scenario, at: KeyPath) -> None:
    """Refuse settings of ``[tear]`` and ``[[throws]]`` that contradict others."""
    # By kind, for messages that list them.
    known = {
        "fault": [entry.name for entry in scenario.faults],
        "horizon": [entry.name for entry in scenario.horizons],
    }
    _check_throws(scenario, known, at)
    if scenario.tops is not None and scenario.tops.tie and scenario.throws:
        at.refuse(
            "tops.tie cannot be combined with [[throws]]: throw moves horizons off their tops. Set "
            "tie = false; the report still lists the misfit of each top."
        )

    # curves of sheets are where the model has them; a tolerance would have no effect there
    if scenario.tolerance_m is not None and (scenario.tear is not None or scenario.throws):
        table = "[tear]" if scenario.tear is not None else "[[throws]]"
        at.refuse(
            f"tolerance_m = {scenario.tolerance_m:g} cannot be combined with {table}: curves "
            "of torn horizons are exact, and end on their faults. Remove one of them."
        )
    ends = horizon_rules_of(scenario)
    if scenario.tolerance_m is not None and ends:
        at.refuse(
            f"tolerance_m = {scenario.tolerance_m:g} cannot be combined with the truncation of "
            f"{ends[0].fault!r} by horizon {ends[0].main!r}: it would move the curve "
            "in which the fault ends. Remove one of them."
        )
    if scenario.tear is None:
        return
    try:
        filling_of(scenario, scenario.tear.horizons or known["horizon"])
    except InputError as error:
        at.refuse(f"[tear]: {error}")
    if not known["fault"]:
        at.refuse("[tear] needs at least one fault. Add a table [[faults]], or remove [tear].")
    trims = scenario.tear.trim_cells
    for name in trims if isinstance(trims, dict) else ():
        if name not in known["fault"]:
            guess = did_you_mean(name, known["fault"])
            at.refuse(f"tear.trim_cells: unknown fault {name!r}; name one of the faults.{guess}")
    for name in scenario.tear.horizons:
        if name not in known["horizon"]:
            guess = did_you_mean(name, known["horizon"])
            at.refuse(f"tear.horizons: unknown horizon {name!r}; name one of the horizons.{guess}")

    # a horizon is torn from its data or by throws, never both
    for entry in scenario.throws:
        for name in entry.horizons or known["horizon"]:
            if is_torn_as_picked(scenario, name):
                at.refuse(
                    f"horizon {name!r} is torn twice: by [tear], and by the throw of "
                    f"{entry.fault!r}. Select the horizons of each with horizons = [...]."
                )


def _check_throws(scenario: Scenario, known: Mapping[str, list[str]], at: KeyPath) -> None:
    """Each throw is given once, in one form, for a fault and horizons that exist."""
    # Pairs of fault and horizon that have a throw already.
    given = set()
    for entry in scenario.throws:
        label = f"throws of {entry.fault!r}"
        for kind, names in (("fault", (entry.fault,)), ("horizon", entry.horizons)):
            for name in names:
                if name not in known[kind]:
                    guess = did_you_mean(name, known[kind])
                    at.refuse(f"{label}: unknown {kind} {name!r}; name one of the {kind}s.{guess}")

        # throw has one form; lengths of the ellipse need that form
        throws = (entry.throw_m, entry.profile_m, entry.elliptic_m)
        if sum(throw is not None for throw in throws) != 1:
            at.refuse(f"{label}: give exactly one of throw_m, profile_m and elliptic_m.")
        for name in entry.horizons:
            if entry.fault not in faults_reaching(scenario, name):
                at.refuse(
                    f"{label}: a truncation ends {entry.fault!r} at a horizon before it reaches "
                    f"{name!r}. Leave {name!r} out of horizons, or remove the truncation."
                )
        for word in ELLIPSE if entry.elliptic_m is None else ():
            if getattr(entry, word) is not None:
                at.refuse(f"{label}: {word} needs elliptic_m. Add elliptic_m, or remove {word}.")

        # without a list, the throw applies to all horizons
        for name in entry.horizons or known["horizon"]:
            if (entry.fault, name) in given:
                at.refuse(f"{label} are given twice for horizon {name!r}; delete one.")
            given.add((entry.fault, name))


def is_torn_as_picked(scenario: Scenario, name: str) -> bool:
    """Return whether ``[tear]`` tears a horizon as it was picked."""
    tear = scenario.tear
    return tear is not None and (not tear.horizons or name in tear.horizons)


def filling_of(scenario: Scenario, torn: Sequence[str]) -> dict[str, bool | str]:
    """Return what becomes of torn horizons in blocks without data, see `filling_by_horizon`."""
    # Without [tear] nothing is filled.
    fill = False if scenario.tear is None else scenario.tear.fill_empty_blocks
    return filling_by_horizon(fill, torn)


def rules_of(scenario: Scenario) -> tuple[Rule, ...]:
    """Return the truncations of a scenario, checked: by faults and by horizons."""
    faults, horizons = (
        [entry.name for entry in entries] for entries in (scenario.faults, scenario.horizons)
    )
    return read_truncations(truncations_of(scenario), faults, horizons)


def horizon_rules_of(scenario: Scenario) -> tuple[Rule, ...]:
    """Return the truncations of faults by horizons."""
    horizons = [entry.name for entry in scenario.horizons]
    return tuple(rule for rule in rules_of(scenario) if rule.main in horizons)


def faults_reaching(scenario: Scenario, horizon: str) -> tuple[str, ...]:
    """Return the faults that no horizon ends before they reach a horizon."""
    horizons = [entry.name for entry in scenario.horizons]
    # A fault that ends at a younger horizon does not reach the ones above it.
    ending = faults_at(horizon, horizons, horizon_rules_of(scenario))
    return tuple(entry.name for entry in scenario.faults if entry.name not in ending)


__all__ = [
    "checked_scenario",
    "faults_reaching",
    "filling_of",
    "horizon_rules_of",
    "is_torn_as_picked",
    "parsed",
    "read_scenario",
    "text_of",
]
