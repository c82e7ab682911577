"""Horizons of a scenario that are torn at its faults: as they were picked, or by throw."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from geosurf.conventions import did_you_mean
from geosurf.model import Sheet
from geosurf.scenario.failure import pictured
from geosurf.scenario.keys import Scenario, ThrowInput
from geosurf.scenario.values import Place
from geosurf.scene import Scene
from geosurf.sheets import EllipticThrow, tear_horizon, throw_horizon

Told = Callable[[str, str, str], object]
ELLIPSE = ("half_length_m", "half_height_m", "centre_along_m", "centre_elevation_m")


def check_sheets(scenario: Scenario, place: Place) -> None:
    """Say what of ``[tear]`` and ``[[throws]]`` makes no sense, before anything is read."""
    known = {
        "fault": [entry.name for entry in scenario.faults],
        "horizon": [entry.name for entry in scenario.horizons],
    }
    _check_throws(scenario, known, place)
    if scenario.tolerance_m is not None and (scenario.tear is not None or scenario.throws):
        table = "[tear]" if scenario.tear is not None else "[[throws]]"
        place.refuse(
            f"tolerance_m is {scenario.tolerance_m:g}, and {table} tears horizons, whose cut-offs "
            f"it would move. Leave tolerance_m out, or {table}."
        )
    if scenario.tear is None:
        return
    if not known["fault"]:
        place.refuse("there is a table [tear], and no fault to tear horizons at. Leave it out.")
    for name in scenario.tear.horizons:
        if name not in known["horizon"]:
            guess = did_you_mean(name, known["horizon"])
            place.refuse(f"tear.horizons: {name!r} is no horizon; name one of those.{guess}")
    for entry in scenario.throws:
        for name in entry.horizons or known["horizon"]:
            if _is_torn(scenario, name):
                place.refuse(
                    f"horizon {name!r} is torn as it was picked, by [tear], and by the throw of "
                    f"{entry.fault!r}, too. Give one of them: horizons = [...] names which."
                )


def _check_throws(scenario: Scenario, known: Mapping[str, list[str]], place: Place) -> None:
    """Each throw is given in one way, for a fault and horizons that there are, once."""
    given = set()
    for entry in scenario.throws:
        label = f"throws of {entry.fault!r}"
        for kind, names in (("fault", (entry.fault,)), ("horizon", entry.horizons)):
            for name in names:
                if name not in known[kind]:
                    guess = did_you_mean(name, known[kind])
                    place.refuse(f"{label}: {name!r} is no {kind}; name one of those.{guess}")
        ways = (entry.throw_m, entry.profile_m, entry.elliptic_m)
        if sum(way is not None for way in ways) != 1:
            place.refuse(f"{label}: give one of throw_m, profile_m and elliptic_m.")
        for word in ELLIPSE if entry.elliptic_m is None else ():
            if getattr(entry, word) is not None:
                place.refuse(f"{label}: {word} goes with elliptic_m. Give that, or leave it out.")
        for name in entry.horizons or known["horizon"]:
            if (entry.fault, name) in given:
                place.refuse(f"{label} are given twice for horizon {name!r}; delete one.")
            given.add((entry.fault, name))


def torn_horizons(
    scenario: Scenario,
    scene: Scene,
    horizons: Mapping[str, Any],
    told: Told,
    out: Path | None = None,
) -> Scene:
    """
    Return the scene with horizons torn at its faults, as these are after extension and truncation.

    Parameters
    ----------
    scenario : Scenario
    scene : Scene
        With horizons that are not torn.
    horizons : mapping of str to xarray.DataArray
    told : callable
        Is called after each sheet: stage, horizon, outcome.
    out : pathlib.Path, optional
        Where a picture goes of the place where a horizon cannot be torn.

    Returns
    -------
    Scene
        The same one where nothing is to be torn.
    """
    sheets: dict[str, Sheet] = {}
    for name, horizon in horizons.items():
        throws = [t for t in scenario.throws if name in t.horizons or not t.horizons]
        with pictured(scene, out, (name, *scene.fault_names)):
            if _is_torn(scenario, name):
                sheets[name] = _as_picked(scenario, scene, name, horizon)
            elif throws:
                sheets[name] = _by_throw(scene, throws, name, horizon)
            else:
                continue
        told("tear", name, f"at {', '.join(sheets[name].cuts)}")
    return scene.replace(horizons=sheets) if sheets else scene


def _is_torn(scenario: Scenario, name: str) -> bool:
    """Whether a horizon is torn as it was picked."""
    tear = scenario.tear
    return tear is not None and (not tear.horizons or name in tear.horizons)


def _as_picked(scenario: Scenario, scene: Scene, name: str, horizon: Any) -> Sheet:
    """A sheet from data that smear the horizon over its faults."""
    tear = scenario.tear
    faults = [scene.surface(fault) for fault in scene.fault_names]
    assert tear is not None
    words: dict[str, Any] = {
        "trim": tear.trim_cells,
        "noise": tear.noise_m,
        "fill_empty_blocks": tear.fill_empty_blocks,
    }
    return tear_horizon(horizon, faults, name=name, **words)


def _by_throw(scene: Scene, throws: list[ThrowInput], name: str, horizon: Any) -> Sheet:
    """A sheet from a continuous horizon and the throws that move it."""
    throw: dict[str, Any] = {}
    for entry in throws:
        throw[entry.fault] = entry.throw_m if entry.profile_m is None else entry.profile_m
        if entry.elliptic_m is not None:
            centre = entry.centre_along_m, entry.centre_elevation_m
            throw[entry.fault] = EllipticThrow(
                entry.elliptic_m, entry.half_length_m, entry.half_height_m, centre
            )
    faults = [scene.surface(entry.fault) for entry in throws]
    reach = {entry.fault: entry.reach_m for entry in throws if entry.reach_m is not None}
    across = {entry.fault: entry.direction for entry in throws}
    shares = {entry.fault: entry.hanging_wall for entry in throws}
    words: dict[str, Any] = {"reach": reach, "hanging_wall": shares, "direction": across}
    return throw_horizon(horizon, faults, throw, name=name, **words)


__all__ = ["Told", "check_sheets", "torn_horizons"]
