"""Truncations of a scenario; older faults that a younger one splits become two faults."""

from __future__ import annotations

from dataclasses import replace

from geosurf.faults.halves import halves_of
from geosurf.faults.rules import Rule, faults_at, read_truncations
from geosurf.scenario.fault_keys import FaultInput
from geosurf.scenario.keys import Scenario, TruncationInput


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
        As `geosurf.faults.halves.halves_of`.
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
