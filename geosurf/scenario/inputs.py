"""A scenario file -> `Scenario`, and a `Scenario` -> `Scene`."""

from __future__ import annotations

import os
import tomllib
from pathlib import Path
from typing import Any

from geosurf.carve.column import names_of_zones
from geosurf.carve.fluids import parse_sides
from geosurf.conventions import counted, did_you_mean
from geosurf.errors import InputError, ScenarioError
from geosurf.faults.rules import read_truncations
from geosurf.model import FluidContact
from geosurf.model.column import ELSEWHERE
from geosurf.model.expected import path_of
from geosurf.read import read_fault, read_horizon
from geosurf.read._guard import opened
from geosurf.scenario.keys import Scenario
from geosurf.scenario.sealed import scene_of_sealed
from geosurf.scenario.torn import Told, check_sheets, torn_horizons
from geosurf.scenario.values import Place, read_table
from geosurf.scene import Scene


def read_scenario(path: str | os.PathLike[str]) -> Scenario:
    r"""
    Read and check a scenario; no surface is read yet.

    Parameters
    ----------
    path : path-like
        A TOML file; docs/scenario.md has its keys.

    Returns
    -------
    Scenario

    Raises
    ------
    ScenarioError
        If the file is not there or no TOML (with the line), or has an unknown key, a
        missing one, a value of the wrong kind, or a name used twice.

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
    scenario: Scenario = read_table(Scenario, Place(path), _load(path), path=path)
    _check_names(scenario)
    return scenario


def _load(path: Path) -> dict[str, Any]:
    try:
        with opened(path) as (file, _):
            text = file.read().decode("utf-8-sig")
        return tomllib.loads(text.replace("\r\n", "\n").replace("\r", "\n"))
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(
            f"{path}: this is no TOML: {error}. Mend that line; text stands between quotes."
        ) from error
    except UnicodeDecodeError as error:
        raise ScenarioError(
            f"{path}: byte {error.start} is no UTF-8 text. Save the scenario as UTF-8."
        ) from error
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise ScenarioError(f"{path}: cannot be read ({reason}). Check the path.") from error
    except InputError as error:  # no file, or a pipe, a folder, a device
        raise ScenarioError(str(error)) from error


def _check_names(scenario: Scenario) -> None:
    """Names are unique over horizons and faults, and there is a horizon."""
    place = Place(scenario.path)
    if scenario.model is not None:
        _check_model(scenario, place)
        return
    if not scenario.horizons:
        place.refuse("there are no horizons; give at least one table [[horizons]], or [model].")
    _check_places(scenario, place)
    seen: dict[str, str] = {}
    for kind, entries in (("horizon", scenario.horizons), ("fault", scenario.faults)):
        for entry in entries:
            if entry.name in seen:
                place.refuse(
                    f"{entry.name!r} is the name of a {seen[entry.name]} and of another {kind}; "
                    "rename one."
                )
            seen[entry.name] = kind
    _check_contacts(scenario, place)
    try:
        read_truncations(truncations_of(scenario), [entry.name for entry in scenario.faults])
    except InputError as error:
        place.refuse(str(error))
    check_sheets(scenario, place)
    for name in scenario.output.search or ():
        if name not in seen:
            known = ", ".join(repr(word) for word in seen)
            place.refuse(
                f"output.search names {name!r}, which is no surface; there are {known}."
                f"{did_you_mean(name, seen)}"
            )


def _check_model(scenario: Scenario, place: Place) -> None:
    """A sealed model comes alone: it has its surfaces, its box, and its faults as they are."""
    for word in ("horizons", "faults", "truncations", "tear", "throws", "box"):
        if getattr(scenario, word):
            place.refuse(
                f"there is a [model] and {word}, too; a sealed model has its own. Leave one out."
            )
    _check_places(scenario, place)


def truncations_of(scenario: Scenario) -> dict[str, tuple[tuple[str, str, bool], ...]]:
    """Return the truncations of a scenario as `Scene` takes them."""
    found: dict[str, tuple[tuple[str, str, bool], ...]] = {}
    for entry in scenario.truncations:
        rule = (entry.main, entry.keep, entry.extend)
        found[entry.fault] = (*found.get(entry.fault, ()), rule)
    return found


def _check_places(scenario: Scenario, place: Place) -> None:
    """A contact and an area of interest are each given once, in one way."""
    given = set()
    for entry in scenario.contacts:
        label = f"contacts[{entry.name!r}]"
        if (entry.elevation_m is None) == (entry.file is None):
            place.refuse(f"{label}: give elevation_m or file, one of them.")
        where = entry.name, entry.block, tuple(sorted(entry.zones))
        if where in given:
            block = "without a block" if entry.block is None else f"for block {entry.block!r}"
            zones = f" of {', '.join(entry.zones)}" if entry.zones else ""
            place.refuse(f"{label} is given {block}{zones} twice; delete one.")
        given.add(where)
    aoi = scenario.aoi
    if aoi is not None and (aoi.file is None) == (aoi.corners_m is None):
        place.refuse("aoi: give file or corners_m, one of them.")


def _check_contacts(scenario: Scenario, place: Place) -> None:
    """Zones and sides of faults that contacts are given for exist, before anything is read."""
    if not scenario.contacts:
        return
    try:
        zones = names_of_zones([entry.name for entry in scenario.horizons])
    except InputError as error:
        place.refuse(str(error))
    faults = [entry.name for entry in scenario.faults]
    sides = [name + sign for name in faults for sign in "+-"]
    for entry in scenario.contacts:
        label = f"contacts[{entry.name!r}]"
        for zone in entry.zones:
            if zone not in zones:
                known = ", ".join(map(repr, zones))
                guess = did_you_mean(zone, zones)
                place.refuse(f"{label}: {zone!r} is no zone; there are {known}.{guess}")
        if entry.block not in (None, ELSEWHERE) and parse_sides(entry.block, faults) is None:
            known = ", ".join(map(repr, sides)) or "none"
            place.refuse(
                f"{label}: block {entry.block!r} is not made of sides of faults; there are {known}."
                f"{did_you_mean(entry.block, sides)}"
            )


def _contacts(scenario: Scenario) -> dict[str, list[FluidContact]]:
    """Fluid contacts by name, from the top down, each with its zones and block."""
    found: dict[str, list[FluidContact]] = {}
    for entry in scenario.contacts:
        value: Any = entry.elevation_m
        if entry.file is not None:
            value = read_horizon(
                entry.file, name=entry.name, positive=entry.positive, length_unit=entry.length_unit
            )
        found.setdefault(entry.name, []).append(FluidContact(value, entry.zones, entry.block or ""))
    return found


def build_scene(scenario: Scenario, told: Told = lambda *_: None, out: Path | None = None) -> Scene:
    """Read the surfaces of a scenario, and tear what is to be torn; see `Scenario.scene`.

    `told` is called after each step: stage, what, outcome. A horizon that cannot be torn is drawn
    into the folder `out`, if it is given.
    """
    aoi = None if scenario.aoi is None else scenario.aoi.file or scenario.aoi.corners_m
    shared: dict[str, Any] = {
        "contacts": _contacts(scenario),
        "aoi": aoi,
        "voxel_size": scenario.search.voxel_size_m,
        "tolerance": scenario.tolerance_m,
    }
    if scenario.model is not None:
        scene = scene_of_sealed(scenario, scenario.model, **shared)
        told("read", _numbers(scene), "")
        return scene
    horizons = {
        entry.name: read_horizon(
            entry.file,
            name=entry.name,
            positive=entry.positive,
            length_unit=entry.length_unit,
            variable=entry.variable,
        )
        for entry in scenario.horizons
    }
    faults = {
        entry.name: read_fault(
            entry.file, name=entry.name, positive=entry.positive, length_unit=entry.length_unit
        )
        for entry in scenario.faults
    }
    box = scenario.box.sides if scenario.box is not None else None
    scene = Scene(
        horizons,
        faults,
        box,
        column={entry.name: entry.rule for entry in scenario.horizons},
        extend={entry.name: entry.extend for entry in scenario.faults if entry.extend},
        truncations=truncations_of(scenario),
        **shared,
    )
    told("read", _numbers(scene), "")
    return torn_horizons(scenario, scene, horizons, told, out)


def _numbers(scene: Scene) -> str:
    """How many surfaces there are, in words."""
    horizons, faults = len(scene.horizon_names), len(scene.fault_names)
    return f"{counted(horizons, 'horizon')}, {counted(faults, 'fault')}"
