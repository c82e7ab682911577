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
from geosurf.model.column import ELSEWHERE
from geosurf.model.compartments import read_compartments
from geosurf.model.expected import path_of
from geosurf.read._guard import opened
from geosurf.scenario.ensemble_keys import check_uncertain
from geosurf.scenario.fault_keys import check_faults
from geosurf.scenario.keys import Scenario
from geosurf.scenario.settings import with_settings
from geosurf.scenario.tables import read_table
from geosurf.scenario.tear_checks import check_tears
from geosurf.scenario.toml_mistakes import mistake_of_toml
from geosurf.scenario.truncations import rules_of, with_halves
from geosurf.scenario.values import KeyPath

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
    check_tears(scenario, at)

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


__all__ = ["checked_scenario", "parsed", "read_scenario", "text_of"]
