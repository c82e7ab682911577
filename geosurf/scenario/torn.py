"""Horizons of a scenario that are torn at its faults: as they were picked, or by throw."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

from geosurf.conventions.checks import are_points
from geosurf.conventions.crs import crs_of
from geosurf.model import Sheet, TriSurface
from geosurf.model.column import data_of_made, zones_of
from geosurf.model.sheets import TearPlan
from geosurf.scenario.keys import Scenario, ThrowInput
from geosurf.scenario.step_log import OnStep, pictured
from geosurf.scenario.validate import (
    faults_reaching,
    filling_of,
    horizon_rules_of,
    is_torn_as_picked,
)
from geosurf.scene import Scene
from geosurf.scene.faults import LongerFaults
from geosurf.scene.given import sheets_in_time, torn_scene
from geosurf.scene.result_cache import ResultCache
from geosurf.scene.tearing import (
    Tear,
    as_long_as,
    as_truncations,
    outcome_of,
    sheets_on,
    warnings_of,
)
from geosurf.scene.zones import warnings_of_throw
from geosurf.triangulate import triangulate_horizon
from geosurf.warning import warn

Remember = Callable[[str, tuple[Any, ...], Callable[[], Sheet]], Sheet]


def torn_horizons(
    scenario: Scenario,
    scene: Scene,
    horizons: Mapping[str, Any],
    on_step: OnStep,
    out: Path | None = None,
    on_start: OnStep = lambda *_: None,
    cache: ResultCache | None = None,
    *,
    longer: LongerFaults = MappingProxyType({}),
    plans: Mapping[str, TearPlan] = MappingProxyType({}),
    remember: Remember = lambda name, inputs, make: make(),
    in_time: Scene | None = None,
) -> Scene:
    """
    Return the scene with horizons torn at its faults, as these are after extension and truncation.

    Parameters
    ----------
    scenario : Scenario
    scene : Scene
        With horizons that are not torn.
    horizons : mapping of str to xarray.DataArray
    on_step : callable
        Is called after each tear: stage, horizon, outcome, and its seconds.
    out : pathlib.Path, optional
        Where a picture goes of the place where a horizon cannot be torn.
    on_start : callable, optional
        Is called before each horizon is torn: stage, horizon, its number.
    cache : ResultCache, optional
        Has sheets of earlier runs.
    longer : mapping of str to (TriSurface, TriSurface), optional
        Faults, and how long tears of another scene needed them: tears begin with these.
    plans : mapping of str to TearPlan, optional
        How horizons of another scene were torn: tears begin with these.
    remember : callable, optional
        Takes a horizon, what its sheet is made of beside its data (faults, what fills its empty
        blocks, throws) and a function that makes it; it may return what they gave before.
    in_time : Scene, optional
        As from `scene_in_time`: horizons are torn as they are there.

    Returns
    -------
    Scene
        The same one where nothing is to be torn.
    """
    reaching = {name: faults_reaching(scenario, name) for name in horizons}
    throws = {name: _throws_of(scenario, name, reaching[name]) for name in horizons}

    # horizons that [tear] names, from data; others are torn by given throws
    picked = [name for name in horizons if is_torn_as_picked(scenario, name)]
    given = {name: scene.whole_surface(name) for name in scene.fault_names} if picked else {}

    # by its place among all horizons; those that [tear] leaves out are not there to end on
    filling = filling_of(scenario, picked)

    # horizons whose data are those of another one, moved
    with_data = [entry.name for entry in scenario.horizons if entry.file]
    made_of = data_of_made(zones_of(scenario.zones or {}, with_data), with_data)
    moved = {} if in_time is None else sheets_in_time(in_time)

    # tearing may extend faults: sheets and scene must have the same ones
    def one(tear: Tear) -> Sheet:
        """One horizon at the faults that reach it."""
        name, plan = tear.name, plans.get(tear.name)
        if name in moved:
            tear = replace(tear, like=(moved[name],))
        some = {key: tear.faults[key] for key in reaching[name]}
        made = partial(_as_picked, scenario, scene, tear, horizons[name], some, plan, cache)
        return remember(name, (*some.values(), *_contents(tear.fill)), made)

    def make(tear: Tear) -> Sheet:
        """One horizon; a picture where it cannot be torn."""
        start = time.perf_counter()
        with pictured(scene, out, (tear.name, *scene.fault_names)):
            found = one(tear)
        done(tear.name, found, time.perf_counter() - start)
        return found

    def done(name: str, found: Sheet, seconds: float | None = None) -> None:
        """Report a tear; a second line where longer faults tear a horizon again."""
        on_step("tear", name, outcome_of(found), seconds)

    def starts(stage: str, name: str, number: int, count: int) -> None:
        """Report a tear that begins."""
        on_start(stage, name, f"{number} of {count}")

    start = as_long_as(longer, given)
    sheets, faults = sheets_on(start, filling, make, scene.whole_surface, starts, made_of)
    found = warnings_of(given, faults, sheets) + warnings_of_throw(sheets, made_of)
    for warning in found:
        warn(warning)
    for name, horizon in horizons.items():
        if name not in sheets and throws[name]:
            on_start("tear", name, "by its throws")
            with pictured(scene, out, (name, *scene.fault_names)):
                some = throws[name]
                cuts = [scene.whole_surface(one.fault) for one in some]
                make_it = partial(_by_throw, cuts, some, name, horizon, cache)
                sheets[name] = remember(name, (repr(some), *cuts), make_it)
            done(name, sheets[name])
    if not sheets:
        return scene

    changes: dict[str, Any] = {}
    if keeps_area(scenario, horizons) and scenario.box is None:
        changes = _kept_area(scene, on_step)
    if any(faults[name] is not given[name] for name in given):
        # all of them as the sheets have them: rules would change them again
        changes |= {"faults": faults, "extend": (), "lengthen": None}
        changes |= {"truncations": as_truncations(horizon_rules_of(scenario))}
    torn = torn_scene(scene, sheets, **changes)
    torn._take_warnings(found)
    return torn


def _kept_area(scene: Scene, on_step: OnStep) -> dict[str, Any]:
    """Box and area of a scene for its torn one, which would not state them.

    Sheets reach farther up and down than smeared grids: the default box would grow, and with it the
    extended faults, which the sheets end on.
    """
    for step in scene.steps:
        if step.stage == "area":
            on_step(step.stage, step.subject, step.detail)
    return {"box": scene.box, "aoi": scene.aoi}


def _throws_of(scenario: Scenario, name: str, reaching: Collection[str]) -> list[ThrowInput]:
    """The throws that move a horizon: one without a list moves those that its fault reaches."""
    return [
        one
        for one in scenario.throws
        if name in one.horizons or (not one.horizons and one.fault in reaching)
    ]


def keeps_area(scenario: Scenario, horizons: Iterable[str]) -> bool:
    """
    Return whether a default box and area are those of horizons that are not torn.

    Parameters
    ----------
    scenario : Scenario
    horizons : iterable of str
    """
    extended = any(f.extend for f in scenario.faults) or any(t.extend for t in scenario.truncations)
    picked = any(is_torn_as_picked(scenario, name) for name in horizons)
    return extended or scenario.network.apply or picked


def _as_picked(
    scenario: Scenario,
    scene: Scene,
    tear: Tear,
    horizon: Any,
    faults: dict[str, TriSurface],
    plan: TearPlan | None,
    cache: ResultCache | None,
) -> Sheet:
    """A sheet from data that smear the horizon over its faults."""
    settings = scenario.tear
    assert settings is not None
    # One set of settings for all horizons, as [tear] is one table.
    words: dict[str, Any] = {
        "trim": settings.trim_cells,
        "noise": settings.noise_m,
        "keep_outliers": settings.keep_outliers,
    }
    name, surfaces = tear.name, [*faults.values()]
    tie = None if scenario.tops is None else scenario.tops.settings
    torn = partial(tear.sheet, horizon, surfaces, plan, scene.tops, tie, **words)

    # A plan comes from another model, which the name of a stored result would have to state.
    if cache is None or plan is not None:
        return torn()
    tops = None if tie is None else scene.tops
    inputs = (
        name, *_data_of(name, horizon), *surfaces, repr(words["trim"]), words["noise"],
        settings.keep_outliers,
        *_contents(tear.fill),
        *(() if tops is None else (repr(tie), tops.wells, tops.horizons, tops.points)),
        *tear.key,
    )  # fmt: skip
    return cache.get_or_compute("sheet", inputs, torn)


def _data_of(name: str, horizon: Any) -> tuple[Any, ...]:
    """What a tear reads of a horizon, in whatever form: realisations have other ones than runs."""
    from geosurf.sheets.lattice.data import points_of

    if are_points(horizon):
        return (str(crs_of(horizon)), points_of(horizon, name, None, None)[1])
    return (
        horizon if isinstance(horizon, TriSurface) else triangulate_horizon(horizon, name=name),
    )


def _contents(fill: bool | Sheet) -> tuple[Any, ...]:
    """How empty blocks are filled, as inputs of a stored result."""
    if not isinstance(fill, Sheet):
        return (fill,)
    arrays = fill.lattice.elevation, fill.divided, fill.copies, fill.ghosts, fill.outer
    return (fill.name, fill.surface, *arrays, *fill.faults)


def _by_throw(
    faults: list[TriSurface],
    throws: list[ThrowInput],
    name: str,
    horizon: Any,
    cache: ResultCache | None,
) -> Sheet:
    """A sheet from a continuous horizon and the throws that move it, youngest fault first."""
    from geosurf.sheets import EllipticThrow, throw_horizon  # loaded by those who tear

    throw: dict[str, Any] = {}
    for entry in throws:
        # One of three forms, as `validate` has made sure.
        throw[entry.fault] = entry.throw_m if entry.profile_m is None else entry.profile_m
        if entry.elliptic_m is not None:
            centre = entry.centre_along_m, entry.centre_elevation_m
            throw[entry.fault] = EllipticThrow(
                entry.elliptic_m, entry.half_length_m, entry.half_height_m, centre
            )

    reach = {entry.fault: entry.reach_m for entry in throws if entry.reach_m is not None}
    across = {entry.fault: entry.direction for entry in throws}
    shares = {entry.fault: entry.hanging_wall for entry in throws}
    words: dict[str, Any] = {"reach": reach, "hanging_wall": shares, "direction": across}
    torn = partial(throw_horizon, horizon, faults, throw, name=name, **words)
    if cache is None:
        return torn()
    inputs = (name, *_data_of(name, horizon), *faults, repr(throws))
    return cache.get_or_compute("sheet", inputs, torn)
