"""Checks of ``[tear]`` and ``[[throws]]``: with each other, and with the rest of a scenario."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from geosurf.conventions import did_you_mean
from geosurf.errors import InputError
from geosurf.faults.rules import Rule, faults_at, halves_of, read_truncations
from geosurf.model.faults import filling_by_horizon
from geosurf.scenario.fault_keys import FaultInput
from geosurf.scenario.keys import Scenario, ThrowInput, TruncationInput
from geosurf.scenario.values import KeyPath

# ---- truncations ----------------------------------------
# Truncations of a scenario; older faults that a younger one splits become two faults.


def truncations_of(scenario: Scenario) -> dict[str, tuple[tuple[str, str, bool], ...]]:
    """Return the truncations of a scenario as `Scene` takes them."""
    # A fault may end at several others: rules add up in the order of the file.
    found: dict[str, tuple[tuple[str, str, bool], ...]] = {}
    for entry in scenario.truncations:
        rule = (entry.main, entry.keep, entry.extend)
        found[entry.fault] = (*found.get(entry.fault, ()), rule)
    return found


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
    halves = halves_of(truncations_of(scenario), [entry.name for entry in scenario.faults])
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
    with at.of("tops", "tie").noting():
        if scenario.tops is not None and scenario.tops.tie and scenario.throws:
            at.of("tops", "tie").refuse(
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
    with at.of("tear").noting():
        try:
            filling_of(scenario, scenario.tear.horizons or known["horizon"])
        except InputError as error:
            at.of("tear", "fill_empty_blocks").refuse(f"[tear]: {error}")
    with at.of("tear").noting():
        if not known["fault"]:
            at.of("tear").refuse(
                "[tear] needs at least one fault. Add a table [[faults]], or remove [tear]."
            )
    trims = scenario.tear.trim_cells
    named = {"fault": trims if isinstance(trims, dict) else (), "horizon": scenario.tear.horizons}
    for (kind, names), key in zip(named.items(), ("trim_cells", "horizons"), strict=True):
        for name in names:
            with at.of("tear", key).noting():
                _refuse_unknown(at.of("tear", key), f"tear.{key}", kind, name, known[kind])

    # a horizon is torn from its data or by throws, never both
    for row, entry in enumerate(scenario.throws):
        with at.of(f"throws[number {row + 1}]").noting():
            for name in entry.horizons or known["horizon"]:
                if is_torn_as_picked(scenario, name):
                    at.of(f"throws[number {row + 1}]").refuse(
                        f"horizon {name!r} is torn twice: by [tear], and by the throw of "
                        f"{entry.fault!r}. Select the horizons of each with horizons = [...]."
                    )


def _refuse_unknown(at: KeyPath, label: str, kind: str, name: str, known: Sequence[str]) -> None:
    """Refuse a name that no fault or horizon has."""
    if name not in known:
        guess = did_you_mean(name, known)
        at.refuse(f"{label}: unknown {kind} {name!r}; name one of the {kind}s.{guess}")


def _check_throws(scenario: Scenario, known: Mapping[str, list[str]], at: KeyPath) -> None:
    """Each throw is given once, in one form, for a fault and horizons that exist."""
    # Pairs of fault and horizon that have a throw already.
    given: set[tuple[str, str]] = set()
    for row, entry in enumerate(scenario.throws):
        place = at.of(f"throws[number {row + 1}]")
        with place.noting():
            _check_throw(scenario, entry, known, given, place)


def _check_throw(
    scenario: Scenario,
    entry: ThrowInput,
    known: Mapping[str, list[str]],
    given: set[tuple[str, str]],
    at: KeyPath,
) -> None:
    """One throw: see `_check_throws`."""
    label = f"throws of {entry.fault!r}"
    _refuse_unknown(at.inside("fault"), label, "fault", entry.fault, known["fault"])
    for name in entry.horizons:
        _refuse_unknown(at.inside("horizons"), label, "horizon", name, known["horizon"])

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


def filling_of(scenario: Scenario, torn: Sequence[str]) -> dict[str, bool | str]:
    """Return what becomes of torn horizons in blocks without data, see `filling_by_horizon`."""
    # Without [tear] nothing is filled.
    fill = False if scenario.tear is None else scenario.tear.fill_empty_blocks
    return filling_by_horizon(fill, torn)
