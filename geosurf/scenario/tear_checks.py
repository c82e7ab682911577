"""Checks of ``[tear]`` and ``[[throws]]``: with each other, and with the rest of a scenario."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from geosurf.conventions import did_you_mean
from geosurf.errors import InputError
from geosurf.model.empty_blocks import filling_by_horizon
from geosurf.scenario.keys import Scenario
from geosurf.scenario.truncations import faults_reaching, horizon_rules_of
from geosurf.scenario.values import KeyPath

# Keys that describe the ellipse of `elliptic_m`, and nothing else.
ELLIPSE = ("half_length_m", "half_height_m", "centre_along_m", "centre_elevation_m")


def check_tears(scenario: Scenario, at: KeyPath) -> None:
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


__all__ = ["check_tears", "filling_of", "is_torn_as_picked"]
