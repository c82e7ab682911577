"""A `Scenario` -> its `Scene`: surfaces are read, all else is what a scene takes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import counted, did_you_mean
from geosurf.conventions.axes import TimeUnit
from geosurf.conventions.running import running
from geosurf.errors import FormatError, ScenarioError
from geosurf.faults import split_fault
from geosurf.kernels.search.columns import cross_columns
from geosurf.measure.places import sample_units
from geosurf.model import FluidContact, TriSurface, Units
from geosurf.model.column import CONFORMABLE
from geosurf.model.network import fault_words, proposal_words
from geosurf.model.tears import TearSettings
from geosurf.read import otherwise, read_fault, read_horizon, read_points, read_polygons, read_tops
from geosurf.read.model3d import read_model3d
from geosurf.scenario.keys import FaultInput, HorizonInput, ModelInput, PolygonInput, Scenario
from geosurf.scenario.step_log import SILENT, StepLog
from geosurf.scenario.validate import faults_reaching, is_torn_as_picked, truncations_of
from geosurf.scene import Scene
from geosurf.scene.given import keep_on_disk
from geosurf.scene.inputs import as_milliseconds
from geosurf.scene.result_cache import ResultCache
from geosurf.scene.surfaces import holds_points, opened_outline
from geosurf.scene.zones import correction_in_words
from geosurf.triangulate import fault_from_polygons, triangulate_fault

# ---- sealed ----------------------------------------
# A sealed model of another program -> a `Scene`: horizons, faults, and a box for its walls.


def scene_of_sealed(scenario: Scenario, model: ModelInput, **options: object) -> Scene:
    """
    Read a sealed model as a scene.

    Parameters
    ----------
    scenario : Scenario
        For messages.
    model : ModelInput
    **options
        Of `Scene`: contacts, area of interest, voxel size.

    Returns
    -------
    Scene

    Raises
    ------
    ScenarioError
        If a horizon is named that the file does not have, or one is left out.
    FormatError
        If the file cannot be read, a surface has no kind, or the boundary is not a box.
    """
    surfaces = read_model3d(model.file, positive=model.positive, length_unit=model.length_unit)
    # The kind of each surface is stated in the model; nothing is guessed from names.
    roles: dict[str, dict[str, TriSurface]] = {"horizon": {}, "fault": {}, "wall": {}}
    for surface in surfaces.values():
        if surface.role not in roles:
            raise FormatError(
                f"{model.file}: surface {surface.name!r} is not marked as a horizon, a fault or a "
                "boundary. Set its kind in the model and export it again."
            )
        roles[surface.role][surface.name] = surface

    # the order of horizons is geology: the file's own, or the user's
    order = model.horizons or tuple(roles["horizon"])
    # Both ways: a name that is missing, and one that is unknown.
    for name in (*order, *roles["horizon"]):
        if name not in roles["horizon"] or name not in order:
            known = list(roles["horizon"])
            raise ScenarioError(
                f"{scenario.path}: model.horizons has {list(order)}, and {model.file.name} has "
                f"{known}; name each of these once, youngest first.{did_you_mean(name, known)}"
            )

    # in the order of the list, which is the stratigraphic one
    horizons = {name: roles["horizon"][name] for name in order}
    box = box_of_walls(list(roles["wall"].values()), str(model.file))
    return Scene(horizons, roles["fault"], box, **options)  # type: ignore[arg-type]


def box_of_walls(walls: list[TriSurface], file: str) -> tuple[float, ...]:
    """
    Return the box whose sides some walls are, exactly.

    Examples
    --------
    >>> from geosurf import build_walls
    >>> box_of_walls(build_walls((0, 9, 0, 8, -7, 0)), "model.ml")
    (0.0, 9.0, 0.0, 8.0, -7.0, 0.0)
    """
    bounds = np.array([wall.bounds for wall in walls]).reshape(-1, 6)
    if len(bounds):
        # each wall is flat in one axis and lies on one side of the box; all six sides occur
        low, high = bounds[:, ::2].min(axis=0), bounds[:, 1::2].max(axis=0)
        flat = bounds[:, ::2] == bounds[:, 1::2]
        sides = {
            (k, float(row[2 * k]))
            for row, f in zip(bounds, flat, strict=True)
            for k in range(3)
            if f[k]
        }
        wanted = {(k, float(value)) for k in range(3) for value in (low[k], high[k])}
        if flat.any(axis=1).all() and sides == wanted and len(wanted) == 6:
            return tuple(float(v) for pair in zip(low, high, strict=True) for v in pair)
    raise FormatError(
        f"{file}: its boundary is not a box with vertical and horizontal sides, which [model] "
        "needs. Export its surfaces, and give them as [[horizons]] and [[faults]] with an [aoi]."
    )


# ---- region units ----------------------------------------
# Which unit of a model holds a closed body of another program: by a point inside.


LINES = 64  # that are tried for one body; the first of a sound one will do


def point_inside(corners: np.ndarray) -> np.ndarray | None:
    """
    Return a point inside a body: the middle of the longest part of a vertical line through it.

    Parameters
    ----------
    corners : ndarray of float64, shape (n, 3, 3)
        Corners of the triangles around the body, in any order [m].

    Returns
    -------
    ndarray of float64, shape (3,), or None
        None where no line decides, as for a body that is not closed.

    Examples
    --------
    >>> from geosurf import build_walls
    >>> walls = build_walls((0, 9, 0, 8, -7, 0))
    >>> point_inside(np.concatenate([wall.vertices[wall.triangles] for wall in walls]))[2].item()
    -3.5
    """
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    size = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    rows = np.arange(corners.size // 3).reshape(-1, 3)
    for widest in np.argsort(-size, kind="stable")[:LINES].tolist():
        # not quite the middle of a triangle: less likely on an edge of another surface
        foot = np.array([0.36, 0.33, 0.31]) @ corners[widest, :, :2]
        # elevations where the line enters and leaves the body, in pairs
        cut = np.sort(cross_columns(corners.reshape(-1, 3), rows, foot[None], foot).elevation)
        if len(cut) and len(cut) % 2 == 0 and (cut[1::2] > cut[::2]).any():
            # the longest part, so that the point is farthest from the shell
            k = 2 * int(np.argmax(cut[1::2] - cut[::2]))
            return np.array([*foot, 0.5 * (cut[k] + cut[k + 1])])
    return None


def units_of_bodies(bodies: Mapping[str, np.ndarray], units: Units) -> dict[str, str]:
    """Return the unit that holds a point of each body, or '' where none does; see `point_inside`.

    Examples
    --------
    >>> import geosurf as gs
    >>> units = gs.Scene({"Top": gs.synthetic.tilted_planes(n=3).horizons["Top"]}).units
    >>> unit = units["below Top"]
    >>> units_of_bodies({"A": unit.vertices[unit.triangles]}, units)
    {'A': 'below Top'}
    """
    inside = {name: point_inside(corners) for name, corners in bodies.items()}
    points = {name: point for name, point in inside.items() if point is not None}
    if not points:
        return dict.fromkeys(bodies, "")
    found = sample_units(units, np.array(list(points.values()))).unit.values.tolist()
    return dict.fromkeys(bodies, "") | dict(zip(points, found, strict=True))


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
        rings = {one.horizon: _polygon(one, entry.name, words | table) for one in entry.polygons}
        return fault_from_polygons(rings, name=entry.name, dip=entry.dip)
    assert entry.file is not None
    fault = read_fault(entry.file, name=entry.name_in_file or entry.name, **words, **table)
    return fault if entry.piece is None else _piece(fault, entry, entry.piece, entry.file)


def _piece(fault: Any, entry: FaultInput, number: int, path: Path) -> Any:
    """One piece of a mesh, under the name of the fault."""
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


@running("read")
def build_scene(
    scenario: Scenario, log: StepLog = SILENT, cache: ResultCache | None = None
) -> Scene:
    """
    Read the surfaces of a scenario as a scene.

    Parameters
    ----------
    scenario : Scenario
    log : StepLog, optional
        Gets a line for each step.
    cache : ResultCache, optional
        Has sheets of earlier runs.

    Returns
    -------
    Scene
        It tears its horizons, as ``[tear]`` and ``[[throws]]`` say, when it is asked.

    Raises
    ------
    InputError
        If a surface cannot be read, or neither file nor scenario declares its unit or direction.
    """
    # A sealed model brings horizons, faults and box along; nothing is torn or extended.
    if scenario.model is not None:
        scene = scene_of_sealed(scenario, scenario.model, **_shared(scenario))
        log.step("read", _numbers(scene))
        return scene

    # read here rather than by the scene: files of a scenario have their own units
    horizons = {entry.name: _horizon(scenario, entry) for entry in scenario.horizons if entry.file}
    faults = {entry.name: fault_of(entry, _words(scenario, entry)) for entry in scenario.faults}
    shared = _shared(scenario)
    horizons = _extended(scenario, horizons, faults, shared["aoi"])
    if scenario.time is not None:
        faults = {name: triangulate_fault(surface, name=name) for name, surface in faults.items()}
        horizons = {
            name: surface if isinstance(surface, TriSurface) else as_milliseconds(surface)
            for name, surface in horizons.items()
        }
    scene = Scene(
        horizons, faults,
        box=None if scenario.box is None else scenario.box.sides,
        column={one.name: one.rule for one in scenario.horizons if one.rule != CONFORMABLE},
        extend={entry.name: entry.extend for entry in scenario.faults if entry.extend},
        truncations=truncations_of(scenario),
        lengthen={entry.name: entry.lengthen_m for entry in scenario.faults if entry.lengthen_m},
        throws=tuple(entry.settings for entry in scenario.throws),
        time=scenario.time, velocity=scenario.velocity, zones=scenario.zones,
        **_tears(scenario), **shared,
    )  # fmt: skip
    keep_on_disk(scene, cache)
    log.step("read", _numbers(scene))
    scene = _with_network(scenario, scene, log)
    if scenario.zones:
        with log.watching(scene):
            corrections = scene.zone_corrections
        for zone in corrections.zone.values:
            log.step("zones", str(zone), correction_in_words(corrections.sel(zone=zone)))
    return scene


def _tears(scenario: Scenario) -> dict[str, Any]:
    """How horizons are torn as they were picked."""
    tear = scenario.tear
    if tear is None:
        return {}
    return {
        "tear": TearSettings(tear.trim_cells, tear.noise_m, tear.keep_outliers, tear.horizons),
        "fill_empty_blocks": tear.fill_empty_blocks,
    }


def _with_network(scenario: Scenario, scene: Scene, log: StepLog) -> Scene:
    """The scene with the proposals for its faults, where these are to be applied."""
    if not scenario.network.apply:
        return scene
    trial = scene.propose_fault_network(reach=scenario.network.reach_m).trial(scene)
    for decision in trial.decisions:
        at = f" at {decision.row.other}" if decision.row.other else ""
        verdict = "accepted" if decision.accepted else "dropped"
        words = f"{verdict}: {proposal_words(decision.row)}; {decision.reason}"
        log.step("network", f"{fault_words(decision.row)}{at}", words)
    applied: Scene = trial.scene
    return applied


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
        "reservoir": scenario.reservoir,
        "regions": scenario.regions,
        **_tops(scenario),
    }


def _horizon(scenario: Scenario, entry: HorizonInput) -> Any:
    """A grid or mesh; points where the horizon is torn as it was picked."""
    words = _words(scenario, entry)
    assert entry.file is not None
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
    unit, in_time = scenario.length_unit, isinstance(entry, HorizonInput | FaultInput)
    if scenario.time is not None:  # tops and contacts are in depth
        unit = TimeUnit(unit or "ms") if in_time else None
    given = otherwise({"positive": scenario.positive, "length_unit": unit})
    stated = {"positive": entry.positive, "length_unit": entry.length_unit}
    if in_time and scenario.time is not None and entry.length_unit is not None:
        stated["length_unit"] = TimeUnit(entry.length_unit)
    return {key: given[key] if word is None else word for key, word in stated.items()}


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
    tops = read_tops(entry.file, **_words(scenario, entry))
    # Without `tie` the tops are only compared.
    return {"tops": tops, "tie": entry.settings}


def _contacts(scenario: Scenario) -> dict[str, list[FluidContact]]:
    """Fluid contacts by name, from the top down, each with its zones and block."""
    # Mappings keep the order of the file, which is the order of contacts from the top down.
    contacts: dict[str, list[FluidContact]] = {}
    for entry in scenario.contacts:
        value: Any = entry.elevation_m
        if entry.file is not None:
            value = read_horizon(entry.file, name=entry.name, **_words(scenario, entry))

        # several tables of one name are one contact with values by zone and block
        contacts.setdefault(entry.name, []).append(
            FluidContact(value, entry.zones, entry.block or "")
        )
    return contacts


def _numbers(scene: Scene) -> str:
    """How many surfaces there are, in words."""
    horizons, faults = len(scene.horizon_names), len(scene.fault_names)
    return f"{counted(horizons, 'horizon')}, {counted(faults, 'fault')}"
