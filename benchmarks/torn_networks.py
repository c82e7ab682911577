"""Tearing on random fault networks with known truth: ``python -m benchmarks.tears networks``."""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import geosurf as gs
from benchmarks.random_networks import GROUPS, random_network
from geosurf.sheets.report.describe import FAR
from tests.sheets import junctions
from tests.sheets.table import CELL, Measured, distances, measure

FAMILIES = (*GROUPS, *junctions.KINDS, "mixed")
TRIMS = ((1.5, 0), (1.75, 0), (2.0, 0), (2.25, 1), (2.5, 1), (3.0, 1))  # cells, and nodes of smear
MARGINS = (0.5, 2.0, 6.0)  # cells from tips, other faults and the rim
CRASHES = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    LookupError,
    RuntimeError,
    TypeError,
    ValueError,
)
POSITION, MEAN, WORST = 0.1, 1.0, 5.0  # cells, and per cent of the largest throw


@dataclass
class Errors:
    """Errors at one fault, from some margin on: cut-offs in cells, throw in % of the largest."""

    position: float
    mean: float
    worst: float
    lost: int  # places where data show throw, and the sheet has none

    @property
    def is_met(self) -> bool:
        """Whether all that is asked for is met."""
        return (
            not self.lost
            and self.position <= POSITION
            and self.mean <= MEAN
            and self.worst <= WORST
        )


@dataclass
class Outcome:
    """What became of one network."""

    number: int
    family: str
    trim: float
    n_fault: int
    seconds: float = 0.0
    refused: str = ""
    crashed: str = ""
    remedies: Counter[str] = field(default_factory=Counter)
    errors: dict[str, dict[float, Errors]] = field(default_factory=dict)
    # beyond two cells: where the report lists no gap of data, and where it lists one
    by_gap: dict[str, dict[bool, Errors]] = field(default_factory=dict)

    @property
    def is_built(self) -> bool:
        """Whether there is a sheet."""
        return not (self.refused or self.crashed)

    def line(self) -> str:
        """One line of progress."""
        head = f"{self.number:4d} {self.family:<20}{self.n_fault:3d} faults, trim {self.trim:<5g}"
        head += f"{self.seconds:6.1f} s "
        if not self.is_built:
            return head + (f"REFUSED {self.refused}" if self.refused else f"CRASH {self.crashed}")
        taken = ", ".join(f"{kind} {n}" for kind, n in self.remedies.items())
        bad = [
            f"{name}: {e.position:.2f} cells, {e.mean:.1f} %, {e.worst:.1f} %, {e.lost} lost"
            for name, by_margin in self.errors.items()
            if 2.0 in by_margin and not (e := by_margin[2.0]).is_met
        ]
        return head + "; ".join([taken or "as it is", *bad])


def run_networks(
    count: int, seed: int = 1, only: Sequence[int] | None = None, progress: bool = True
) -> list[Outcome]:
    """
    Tear random networks and compare them with the truth.

    Network k of a seed is always the same, whatever `count` is.

    Parameters
    ----------
    count, seed : int
    only : sequence of int, optional
        Run these networks only.
    progress : bool
        Write a line for each to stderr.

    Returns
    -------
    list of Outcome
    """
    found = []
    for number in range(count) if only is None else only:
        found.append(run_network(number, seed))
        if progress:
            sys.stderr.write(f"{found[-1].line()}\n")
            sys.stderr.flush()
    return found


def run_network(number: int, seed: int) -> Outcome:
    """Tear one network and compare it with the truth."""
    rng = np.random.default_rng([seed, number])
    family = FAMILIES[number % len(FAMILIES)]
    trim, smear = TRIMS[int(rng.integers(len(TRIMS)))]
    if family in junctions.KINDS:
        grid, faults, *truth = junctions.junction(family, rng)
    else:
        network = random_network(family, rng, smear)
        grid, faults = network.horizon, network.faults
    outcome = Outcome(number, family, trim, len(faults))
    start = time.perf_counter()
    try:
        sheet = gs.tear_horizon(grid, faults, name="Top", trim=trim)
    except gs.errors.GeosurfError as error:
        outcome.refused = str(error)
    except CRASHES as error:  # a result here
        outcome.crashed = f"{type(error).__name__}: {error}"
    outcome.seconds = time.perf_counter() - start
    if not outcome.is_built:
        return outcome
    outcome.remedies = Counter(warning.kind for warning in sheet.report.remedies)
    if family in junctions.KINDS:
        outcome.errors = _errors_at_junction(sheet, *truth)
        outcome.by_gap = {name: {False: e[2.0]} for name, e in outcome.errors.items() if 2.0 in e}
    else:
        outcome.errors = {name: _errors_of(network, sheet, name) for name in faults}
        outcome.by_gap = {name: _errors_by_gap(network, sheet, name) for name in faults}
    return outcome


def _errors_of(network: Any, sheet: Any, name: str) -> dict[float, Errors]:
    """Errors at a fault with curved walls, by margin."""
    found = {}
    for margin in MARGINS:
        m = _measured(network, sheet, name, margin)
        if m is not None:
            found[margin] = _errors_among(m, np.ones(len(m.places), dtype=bool))
    return found


def _errors_by_gap(network: Any, sheet: Any, name: str) -> dict[bool, Errors]:
    """Errors two cells from all that ends a fault, by whether its report lists a gap of data."""
    m = _measured(network, sheet, name, 2.0)
    if m is None:
        return {}

    # the report lists the farthest node of each gap: around it others are too far from data, too
    fault = network.truth["faults"][name]
    line = network.truth["cutoffs"][name, "+"]
    s = fault.along_across(line[:, 0], line[:, 1])[0]
    order = np.argsort(s)
    x, y = (np.interp(m.places, s[order], line[order, c]) for c in (0, 1))
    gap = np.zeros(len(m.places), dtype=bool)
    for one in sheet.report.extrapolation:
        far = np.hypot(x - one["place"][0], y - one["place"][1]) / CELL
        gap |= far <= one["cells"] - FAR + 1.0
    return {
        value: _errors_among(m, gap == value) for value in (False, True) if (gap == value).any()
    }


def _measured(network: Any, sheet: Any, name: str, margin: float) -> Measured | None:
    """What is found at a fault beyond a margin; None if no place is that far from everything."""
    try:
        m = measure(network, sheet, name, margin)
    except ValueError:
        return None
    return m if len(m.places) else None


def _errors_among(m: Measured, some: np.ndarray) -> Errors:
    """Errors at some of the places of a fault, bool (n,)."""
    # a place without a cut-off is wrong by all of its throw
    lost = np.isnan(m.throw[some])
    throw = np.where(lost, 100.0, m.throw[some])
    position = m.position[np.tile(some, 2)]
    return Errors(float(position.max()), throw.mean(), throw.max(), int(lost.sum()))


def _errors_at_junction(
    sheet: Any, middle: np.ndarray, azimuth: np.ndarray, throw: np.ndarray
) -> dict[str, dict[float, Errors]]:
    """Errors at the rays of an upright junction, by margin; a ray is a fault or half of one."""
    found: dict[str, dict[float, Errors]] = {}
    cell = junctions.CELL
    for cut in sheet.cuts.values():
        away = cut.stations[:, :2] - middle
        far = np.hypot(*away.T) / cell
        inside = (abs(cut.stations[:, :2] - (2000.0, 1500.0)) < (2100.0, 1600.0)).all(axis=1)
        off = np.abs((np.degrees(np.arctan2(*away.T))[:, None] - azimuth + 180.0) % 360.0 - 180.0)
        ray = off.argmin(axis=1)
        for k in range(len(azimuth)):
            for margin in MARGINS:
                mine = inside & (ray == k) & (far > margin)
                if not mine.any():
                    continue
                miss = np.abs(np.abs(cut.throw[mine]) - throw[k]) / throw.max() * 100.0
                lost = int(np.isnan(miss).sum()) if throw[k] > 0 else 0
                miss = np.where(np.isnan(miss), 100.0 if throw[k] > 0 else 0.0, miss)
                lines = [line for wall in "+-" for line in cut.cutoffs[wall]]
                position = distances(cut.stations[mine], lines).max() / cell
                found.setdefault(f"{cut.fault} ray {k + 1}", {})[margin] = Errors(
                    float(position), float(miss.mean()), float(miss.max()), lost
                )
    return found


def networks_table(found: Sequence[Outcome]) -> str:
    """
    Results as Markdown: by family, errors by margin, remedies, and networks that miss a target.

    Parameters
    ----------
    found : sequence of Outcome

    Returns
    -------
    str
    """
    parts = (
        _by_family(found),
        _by_trim(found),
        _by_margin(found),
        _by_gap(found),
        _kinds(found),
        _misses(found),
    )
    return "\n\n".join("\n".join(part) for part in parts)


def _by_family(found: Sequence[Outcome]) -> Iterator[str]:
    yield from _groups(found, "family", lambda one: one.family, FAMILIES)


def _by_trim(found: Sequence[Outcome]) -> Iterator[str]:
    yield from _groups(found, "trim [cells]", lambda one: one.trim, [trim for trim, _ in TRIMS])


def _groups(
    found: Sequence[Outcome], title: str, key: Callable[[Outcome], Any], values: Sequence[Any]
) -> Iterator[str]:
    """A line for each group of networks, and one for all: faults beyond two cells."""
    yield (
        f"| {title} | networks | built | with remedies | refused | crashed | faults "
        "| cut-off, worst [cells] | throw, mean [%] | throw, worst [%] | faults within targets |"
    )
    yield "|" + "---|" * 11
    for value in [*values, None]:
        mine = [one for one in found if value is None or key(one) == value]
        if not mine:
            continue
        clean = [e[2.0] for o in mine if not o.remedies for e in o.errors.values() if 2.0 in e]
        built = sum(one.is_built for one in mine)
        helped = sum(bool(one.remedies) for one in mine)
        refused, crashed = (sum(bool(getattr(o, w)) for o in mine) for w in ("refused", "crashed"))
        yield (
            f"| {'**all**' if value is None else value} | {len(mine)} | {built} | {helped} "
            f"| {refused} | {crashed} | {sum(one.n_fault for one in mine)} | {_figures(clean)} "
            f"| {sum(e.is_met for e in clean)} of {len(clean)} |"
        )


def _figures(errors: Sequence[Errors]) -> str:
    """Worst cut-off, mean of the mean errors of throw, and the worst."""
    if not errors:
        return "| |"
    return (
        f"{max(e.position for e in errors):.2f} | {np.mean([e.mean for e in errors]):.2f} "
        f"| {max(e.worst for e in errors):.1f}"
    )


def _by_margin(found: Sequence[Outcome]) -> Iterator[str]:
    """Errors from some distance of tips, other faults and the rim on; without remedies."""
    yield "| from ... on | faults | cut-off, worst [cells] | throw, mean [%] | throw, worst [%] |"
    yield "|---|---|---|---|---|"
    for margin in MARGINS:
        errors = [
            e[margin] for o in found if not o.remedies for e in o.errors.values() if margin in e
        ]
        yield f"| {margin:g} cells | {len(errors)} | {_figures(errors)} |"


def _by_gap(found: Sequence[Outcome]) -> Iterator[str]:
    """Errors where data are near, and where the report lists a gap of data; without remedies."""
    yield (
        "| places | faults | cut-off, worst [cells] | throw, mean [%] | throw, worst [%] "
        "| faults within targets |"
    )
    yield "|---|---|---|---|---|---|"
    for gap, title in ((False, "data near"), (True, "gap of data, listed by the report")):
        errors = [e[gap] for o in found if not o.remedies for e in o.by_gap.values() if gap in e]
        met = sum(e.is_met for e in errors)
        yield f"| {title} | {len(errors)} | {_figures(errors)} | {met} of {len(errors)} |"


def _kinds(found: Sequence[Outcome]) -> Iterator[str]:
    """How often each kind of remedy was needed."""
    kinds: Counter[str] = Counter()
    for one in found:
        kinds += one.remedies
    taken = ", ".join(f"{kind} {n}" for kind, n in sorted(kinds.items()))
    yield f"Remedies: {taken or 'none'}."


def _misses(found: Sequence[Outcome]) -> Iterator[str]:
    """Networks that were refused, crashed, or miss a target at some fault."""
    yield "```text"
    for one in found:
        missed = any(2.0 in e and not e[2.0].is_met for e in one.errors.values())
        if missed or one.remedies or not one.is_built:
            yield one.line()
    yield "```"
