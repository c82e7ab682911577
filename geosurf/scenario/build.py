"""A `Scenario` -> its `Scene`: surfaces are read, and horizons torn where that is requested."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import counted
from geosurf.conventions.checks import are_points
from geosurf.errors import ScenarioError
from geosurf.model import FluidContact
from geosurf.read import otherwise, read_fault, read_horizon, read_points, read_polygons
from geosurf.scenario.fault_keys import FaultInput, PolygonInput
from geosurf.scenario.keys import HorizonInput, Scenario
from geosurf.scenario.step_log import OnStep
from geosurf.scenario.tear_checks import (
    faults_reaching,
    filling_of,
    is_torn_as_picked,
    truncations_of,
)
from geosurf.scenario.torn import torn_horizons
from geosurf.scene import Scene
from geosurf.scene.footprint import footprint, holds_points, with_empty_blocks
from geosurf.scene.result_cache import ResultCache
from geosurf.scene.surfaces import opened_outline
from geosurf.triangulate import triangulate_fault, triangulate_horizon

# ---- fault inputs ----------------------------------------
# One ``[[faults]]`` -> a fault: a file, a piece of its mesh, or polygons on horizons.


def fault_of(entry: FaultInput, words: dict[str, Any]) -> Any:
    """
    Read one fault.

    Parameters
    ----------
    entry : FaultInput
    words : dict of str to str or None
        ``positive`` and ``length_unit`` of its files.

    Returns
    -------
    TriSurface, FaultSticks or xarray.Dataset

    Raises
    ------
    InputError
        If a file cannot be read, or has no such piece or polygon.
    """
    table: dict[str, Any] = {}
    if entry.columns is not None or entry.decimal != ".":
        table = {"columns": entry.columns, "decimal": entry.decimal}
    if entry.polygons:
        from geosurf.triangulate import fault_from_polygons  # loaded by those who have polygons

        rings = {one.horizon: _polygon(one, entry.name, words | table) for one in entry.polygons}
        return fault_from_polygons(rings, name=entry.name)
    assert entry.file is not None
    fault = read_fault(entry.file, name=entry.name_in_file or entry.name, **words, **table)
    return fault if entry.piece is None else _piece(fault, entry, entry.piece, entry.file)


def _piece(fault: Any, entry: FaultInput, number: int, path: Path) -> Any:
    """One piece of a mesh, under the name of the fault."""
    from geosurf.faults import split_fault  # loaded by those who take a piece

    parts = list(split_fault(triangulate_fault(fault, name=entry.name)).values())
    if number > len(parts):
        raise ScenarioError(
            f"{path}: piece {number} is requested for fault {entry.name!r}, and the mesh has "
            f"{counted(len(parts), 'piece')}. Give a piece from 1 to {len(parts)}."
        )
    return parts[number - 1].renamed(entry.name, "fault")


def _polygon(entry: PolygonInput, fault: str, words: dict[str, Any]) -> np.ndarray:
    """One polygon of a file."""
    rings = read_polygons(entry.file, **words)
    if entry.polygon is None and len(rings) == 1:
        return rings[0]
    if entry.polygon is None or entry.polygon > len(rings):
        asked = "which one is not stated"
        if entry.polygon is not None:
            asked = f"{entry.polygon} is requested"
        raise ScenarioError(
            f"{entry.file}: the file has {counted(len(rings), 'polygon')}, and {asked} for fault "
            f"{fault!r}. Give polygon = 1 to {len(rings)} in [[faults.polygons]]."
        )
    return rings[entry.polygon - 1]


def build_scene(
    scenario: Scenario,
    on_step: OnStep = lambda *_: None,
    out: Path | None = None,
    on_start: OnStep = lambda *_: None,
    cache: ResultCache | None = None,
) -> Scene:
    """
    Read the surfaces of a scenario, and tear the horizons that ``[tear]`` and ``[[throws]]`` name.

    Parameters
    ----------
    scenario : Scenario
    on_step : callable, optional
        Is called after each step: stage, subject, outcome.
    out : pathlib.Path, optional
        A folder for a picture of the place where a horizon cannot be torn.
    on_start : callable, optional
        Is called before each horizon is torn, which may take long: stage, horizon, its number.
    cache : ResultCache, optional
        Has sheets of earlier runs.

    Returns
    -------
    Scene
        Its curves and units are not computed yet.

    Raises
    ------
    InputError
        If a surface cannot be read, or neither file nor scenario declares its unit or direction.
    """
    # A sealed model brings horizons, faults and box along; nothing is torn or extended.
    if scenario.model is not None:
        from geosurf.scenario.sealed import scene_of_sealed  # loaded by those who have one

        scene = scene_of_sealed(scenario, scenario.model, **_shared(scenario))
        on_step("read", _numbers(scene), "")
        return scene
    scene, horizons = untorn_scene(scenario, on_step)
    return torn_horizons(scenario, scene, horizons, on_step, out, on_start, cache)


def untorn_scene(
    scenario: Scenario, on_step: OnStep = lambda *_: None
) -> tuple[Scene, dict[str, Any]]:
    """
    Read the surfaces of a scenario.

    Parameters
    ----------
    scenario : Scenario
        Without a sealed model.
    on_step : callable, optional
        As in `build_scene`.

    Returns
    -------
    (Scene, dict of str to object)
        The scene before its horizons are torn, and the data of these: `torn_horizons` takes both.

    Raises
    ------
    InputError
        As `build_scene`.
    """
    # read here rather than by the scene: files of a scenario have their own units
    horizons = {entry.name: _horizon(scenario, entry) for entry in scenario.horizons}
    faults = {entry.name: fault_of(entry, _words(scenario, entry)) for entry in scenario.faults}

    shared = _shared(scenario)
    horizons = _extended(scenario, horizons, faults, shared["aoi"])

    # not torn yet: sheets need the faults as extension and truncation leave them
    box = scenario.box.sides if scenario.box is not None else None
    plain = {
        # points have no grid yet: their outline stands for them until they are torn
        name: footprint(name, data, {}) if are_points(data) else data
        for name, data in horizons.items()
    }
    scene = Scene(
        _with_empty_blocks(scenario, plain),
        faults,
        box,
        column={entry.name: entry.rule for entry in scenario.horizons},
        extend={entry.name: entry.extend for entry in scenario.faults if entry.extend},
        truncations=truncations_of(scenario),
        lengthen={entry.name: entry.distances for entry in scenario.faults if entry.distances},
        **shared,
    )
    on_step("read", _numbers(scene), "")
    return _with_network(scenario, scene, on_step), horizons


def _with_network(scenario: Scenario, scene: Scene, on_step: OnStep) -> Scene:
    """The scene with the proposals for its faults, where these are to be applied."""
    if not scenario.network.apply:
        return scene
    from geosurf.model.network import fault_words, proposal_words  # loaded by those who apply

    trial = scene.propose_fault_network(reach=scenario.network.reach_m).trial(scene)
    for one in trial.decisions:
        at = f" at {one.row.other}" if one.row.other else ""
        verdict = "accepted" if one.accepted else "dropped"
        words = f"{verdict}: {proposal_words(one.row)}; {one.reason}"
        on_step("network", f"{fault_words(one.row)}{at}", words)
    found: Scene = trial.scene
    return found


def _shared(scenario: Scenario) -> dict[str, Any]:
    """What a scene has, wherever its surfaces come from."""
    # One place for both ways to a scene, so that no key is lost on one of them.
    return {
        "contacts": _contacts(scenario),
        "aoi": None if scenario.aoi is None else scenario.aoi.value,
        "voxel_size": scenario.search.voxel_size_m,
        "tolerance": scenario.tolerance_m,
        "slivers": scenario.slivers.settings,
        "compartments": scenario.compartments,
        "crs": scenario.crs,
        **_tops(scenario),
    }


def _with_empty_blocks(scenario: Scenario, plain: dict[str, Any]) -> dict[str, Any]:
    """The horizons; where they will be pinched out they have the nodes of the other one."""
    filling = filling_of(scenario, [name for name in plain if is_torn_as_picked(scenario, name)])
    # Only pinch-outs need the other horizon's nodes.
    if not any(isinstance(onto, str) for onto in filling.values()):
        return plain
    surfaces = {name: triangulate_horizon(one, name=name) for name, one in plain.items()}
    return {**with_empty_blocks(surfaces, filling)}


def _horizon(scenario: Scenario, entry: HorizonInput) -> Any:
    """A grid or mesh; points where the horizon is torn as it was picked."""
    words = _words(scenario, entry)
    # A file with a grid is read as a grid even if it is torn: its nodes are its data.
    if is_torn_as_picked(scenario, entry.name) and holds_points(entry.file):
        return read_points(entry.file, columns=entry.columns, decimal=entry.decimal, **words)
    if holds_points(entry.file):
        tear = "add it to [tear]" if scenario.tear is not None else "add a table [tear]"
        raise ScenarioError(
            f"{entry.file}: horizon {entry.name!r} is in points, and these become a surface where "
            f"the horizon is torn: {tear}."
        )
    if entry.columns is not None or entry.decimal != ".":
        raise ScenarioError(
            f"{entry.file}: columns and decimal of horizon {entry.name!r} apply to points that are "
            "torn, and this is a grid, a mesh, or not torn. Leave them out, or add [tear]."
        )
    return read_horizon(entry.file, variable=entry.variable, name=entry.name, **words)


def _words(scenario: Scenario, entry: Any) -> dict[str, Any]:
    """Direction and unit of one file; those of the scenario apply where the file states none."""
    # The file itself has the last word, then its table, then the top of the scenario.
    given = otherwise({"positive": scenario.positive, "length_unit": scenario.length_unit})
    own = {"positive": entry.positive, "length_unit": entry.length_unit}
    return {key: given[key] if word is None else word for key, word in own.items()}


def _extended(
    scenario: Scenario, horizons: dict[str, Any], faults: dict[str, Any], aoi: Any
) -> dict[str, Any]:
    """Horizons continued to the box or area, and their holes filled, where that is asked."""
    # the area that extension has to reach: of the box, or the outline itself if it is no rectangle
    area: Any = None if scenario.box is None else scenario.box.sides
    if aoi is not None and scenario.aoi is not None and not scenario.aoi.rectangle:
        area = opened_outline(aoi)
    # Horizons are continued from their data, before tearing and before the box cuts them.
    made = dict(horizons)
    for entry in scenario.horizons:
        if entry.extend_m is not None or entry.fill_holes:
            from geosurf.sheets import extend_horizon  # loaded by those who need it

            made[entry.name] = extend_horizon(
                horizons[entry.name], area, distance=entry.extend_m or 0.0,
                fill_holes=entry.fill_holes, name=entry.name,
                # Across a fault the smoothest surface would bridge its throw.
                faults={name: faults[name] for name in faults_reaching(scenario, entry.name)},
            )  # fmt: skip
    return made


def _tops(scenario: Scenario) -> dict[str, Any]:
    """Well tops, and how horizons are tied to them."""
    entry = scenario.tops
    if entry is None:
        return {}
    from geosurf.read import read_tops  # loaded by those who have tops

    tops = read_tops(entry.file, **_words(scenario, entry))
    # Without `tie` the tops are only compared.
    return {"tops": tops, "tie": entry.settings}


def _contacts(scenario: Scenario) -> dict[str, list[FluidContact]]:
    """Fluid contacts by name, from the top down, each with its zones and block."""
    # Mappings keep the order of the file, which is the order of contacts from the top down.
    found: dict[str, list[FluidContact]] = {}
    for entry in scenario.contacts:
        value: Any = entry.elevation_m
        if entry.file is not None:
            value = read_horizon(entry.file, name=entry.name, **_words(scenario, entry))

        # several tables of one name are one contact with values by zone and block
        found.setdefault(entry.name, []).append(FluidContact(value, entry.zones, entry.block or ""))
    return found


def _numbers(scene: Scene) -> str:
    """How many surfaces there are, in words."""
    horizons, faults = len(scene.horizon_names), len(scene.fault_names)
    return f"{counted(horizons, 'horizon')}, {counted(faults, 'fault')}"
