"""The faults of a scene, made ready: read, extended, then truncated by each other.

Faults that truncation links, directly or over others, are one group and are split in one
arrangement; a change of one fault touches its own group only. Each fault is extended by itself.
`Memory` finds every result by what went into it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from geosurf import measure
from geosurf.arrangement import find_contacts
from geosurf.conventions import grouped
from geosurf.conventions.text import check_name
from geosurf.errors import GeometryError
from geosurf.faults import extend_fault, lengthen_fault, truncate_faults
from geosurf.faults.propose import bridge_to, check_reach, propose_network
from geosurf.faults.rules import Rule
from geosurf.lazy import xarray
from geosurf.measure.closures import find_closures, rules_of_closures, warnings_of_spill
from geosurf.measure.rock import roofs_of
from geosurf.measure.seal import checked_seal, fault_seal, warnings_of_seal
from geosurf.model import Patches, TriSurface
from geosurf.model.expected import name_of, number_of
from geosurf.model.network import (
    SIDES,
    ExtendedFault,
    Extension,
    FaultNetwork,
    TruncatedFaults,
    Truncation,
)
from geosurf.model.sheets import TearPlan
from geosurf.rebuild import patches_from
from geosurf.scene.inputs import Box, SceneInputs
from geosurf.scene.memory import Memory
from geosurf.triangulate import build_walls, orient_fault

TearPlans = Mapping[str, TearPlan]  # by horizon
LongerFaults = Mapping[str, tuple[TriSurface, TriSurface]]  # a fault, and longer as tears needed it


class FaultStage:
    """Faults of a scene from their inputs and rules, each when it is first requested.

    Parameters
    ----------
    inputs : SceneInputs
        Names of the faults, how they end at each other, and which sides are continued.
    memory : Memory
        Of the scene.
    given : callable
        Name of a fault -> its surface as given.
    limits : callable
        () -> the model box, and the area of interest or None; asked only where a fault is
        truncated.
    extent : callable
        () -> the box that extended faults leave.
    """

    def __init__(
        self,
        inputs: SceneInputs,
        memory: Memory,
        *,
        given: Callable[[str], TriSurface],
        limits: Callable[[], tuple[Box, np.ndarray | None]],
        extent: Callable[[], Box],
    ) -> None:
        self.names, self.rules = tuple(inputs.faults), inputs.rules
        self.sides = _with_horizons(inputs)
        self.truncations, self.extend, self.distances = (
            inputs.truncations, inputs.extend, inputs.lengthen,
        )  # fmt: skip
        self._given, self._limits, self._extent = given, limits, extent
        self._remember, self._key = memory.get_or_compute, memory.key_of

    def surface(self, name: str) -> TriSurface:
        """Return one fault as the model has it."""
        # a fault without a rule is not split from others: no arrangement is made
        if not any(name in (rule.fault, rule.main) for rule in self.rules):
            return self._extended(name).surface
        return self._truncated(name).surfaces[name]

    def actions(self) -> tuple[Extension | Truncation, ...]:
        """Return what was done to all faults: extensions, then truncations, by fault."""
        out: list[Extension | Truncation] = []
        for name in self.names:
            out += self._extended(name).extensions
            for rule in self.rules:
                if rule.fault == name and rule.extend:
                    out += self._bridged(rule).extensions
        for name in self.names:
            if any(rule.fault == name for rule in self.rules):
                out += [cut for cut in self._truncated(name).truncations if cut.fault == name]
        return tuple(out)

    def propose(self, reach: float | None) -> FaultNetwork:
        """Return contacts, near misses and dangling ends of the faults, before horizons are torn.

        Tears make a fault as long as a horizon needs it, wherever it ends.
        """
        check_reach(reach)

        # as extension and truncation leave them: proposals add to the rules that are there
        surfaces = [self.surface(name) for name in self.names]
        box, _ = self._limits()
        key = ("network", *map(self._key, surfaces), box, reach)
        return self._remember(
            "propose", f"{len(surfaces)} faults", key,
            lambda: propose_network(_split(list(map(orient_fault, surfaces))), box, reach=reach),
            lambda network: f"{len(network.rows)} contacts, near misses and dangling ends",
        )  # fmt: skip

    # ------------------------------------------------------------------ steps
    def _extended(self, name: str) -> ExtendedFault:
        """One fault beyond the model box, on the sides that were asked for."""
        longer, sides = self._lengthened(name), self.sides.get(name, ())
        if not sides:
            return longer

        # asked only if a side is extended: the default box needs all horizons
        box = self._extent()
        return self._remember(
            "extend", name, ("extend", self._key(longer.surface), longer.n_given, sides, box),
            lambda: _joined(longer, extend_fault(longer.surface, box, sides=sides)),
            _describe_extension, again=False,
        )  # fmt: skip

    def _lengthened(self, name: str) -> ExtendedFault:
        """One fault, longer by the distances that were given for it."""
        given, distances = self._given(name), self.distances.get(name, {})
        if not distances:
            return ExtendedFault(given, given.n_triangle, ())
        return self._remember(
            "lengthen", name, ("lengthen", self._key(given), *distances.items()),
            lambda: lengthen_fault(given, distances), _describe_extension, again=False,
        )  # fmt: skip

    def _bridged(self, rule: Rule) -> ExtendedFault:
        """One fault beyond its main fault, from its nearest side, after its other bridges."""
        fault, main = self._extended(rule.fault).surface, self._extended(rule.main).surface

        # bridges to main faults that come before this one are part of the fault
        for earlier in self.rules:
            if earlier == rule:
                break
            if earlier.fault == rule.fault and earlier.extend:
                fault = self._bridged(earlier).surface
        key = ("bridge", self._key(fault), self._key(main), rule.keep)
        subject = f"{rule.fault} to {rule.main}"
        return self._remember(
            "extend", subject, key, lambda: bridge_to(fault, main, rule.keep, _split),
            _describe_extension, again=False,
        )  # fmt: skip

    def _truncated(self, name: str) -> TruncatedFaults:
        """The group of a fault, split and truncated."""
        # faults that rules link are truncated together; others are not touched by a change here
        group = self._group(name)

        # each member as it is before truncation: extended, and continued to its main faults
        rules = tuple(rule for rule in self.rules if rule.fault in group)
        surfaces = []
        for member in sorted(group):
            bridges = [r for r in rules if r.fault == member and r.extend]
            made = self._bridged(bridges[-1]) if bridges else self._extended(member)
            surfaces.append(made.surface)

        # rules by fault, in the order in which they apply
        by_fault = grouped((rule.fault, (rule.main, rule.keep, rule.extend)) for rule in rules)
        cuts = {fault: tuple(of) for fault, of in by_fault.items()}

        # the key: surfaces, limits and rules decide the result
        box, aoi = self._limits()
        area = None if aoi is None else aoi.tobytes()
        key = ("truncate", *map(self._key, surfaces), box, area, *cuts.items())
        return self._remember(
            "truncate", ", ".join(sorted(group)), key,
            lambda: truncate_faults(
                _split([*surfaces, *build_walls(box, aoi)]), cuts, whole=lambda: _split(surfaces)
            ),
            _describe_truncation, again=False,
        )  # fmt: skip

    def _group(self, name: str) -> set[str]:
        """The faults that truncation links with one."""
        group, grown = {name}, True
        while grown:
            # grow the group until no rule links another fault to it
            linked = {
                other
                for rule in self.rules
                if rule.fault in group or rule.main in group
                for other in (rule.fault, rule.main)
            }
            grown, group = not linked <= group, group | linked
        return group


def known_fault(name: str, known: Sequence[str]) -> str:
    """Return the name of a fault, if there is such a one."""
    check_name(name_of(name, "fault"), known, f"no fault is called {name!r}; there are")
    return name


def _with_horizons(inputs: SceneInputs) -> dict[str, tuple[str, ...]]:
    """The sides on which faults are extended, with those that reach for a horizon."""
    sides = {name: set(words) for name, words in inputs.extend.items()}
    for rule in inputs.horizon_rules:
        if rule.extend:
            sides.setdefault(rule.fault, set()).add("up" if rule.keep == "below" else "down")
    return {name: tuple(side for side in SIDES if side in some) for name, some in sides.items()}


def _split(surfaces: Sequence[TriSurface]) -> Patches:
    """Surfaces in one arrangement in world coordinates.

    What is cut out of it is handed on as surfaces in world coordinates; with an origin of its own
    the points would be rounded once more, after all checks.
    """
    return patches_from(find_contacts(surfaces, origin=np.zeros(3)))


def _joined(first: ExtendedFault, then: ExtendedFault) -> ExtendedFault:
    """Two extensions of one fault as one."""
    return ExtendedFault(then.surface, first.n_given, (*first.extensions, *then.extensions))


def _describe_extension(made: ExtendedFault) -> str:
    words = [f"{e.side} {e.distance:.1f} m ({e.lines} lines)" for e in made.extensions]
    return ", ".join(words) if words else "leaves the box already"


def _describe_truncation(made: TruncatedFaults) -> str:
    words = [
        f"{t.fault} at {t.main}: removed {t.dropped_area:.6g} of "
        f"{t.kept_area + t.dropped_area:.6g} m2"
        for t in made.truncations
    ]
    moved = f"; vertices moved by up to {made.largest_move:.1e} m" if made.largest_move else ""
    ends = "; cut at the model box, where one of them has to end" if made.cut_by_walls else ""
    return "; ".join(words) + ends + moved


# ---- measures at faults ----------------------------------------
# What `Scene.throw` and `Scene.closures` do.


def throw_of(scene: Any, horizon: str, fault: str, direction: str) -> xarray.Dataset:
    """Return throw and heave: of both walls across the mean strike, then down the local dip."""
    from geosurf.sheets.faults.fault_profile import cell_of, to_level  # loaded by those who ask

    # distance along strike counts from the end of the fault, in world coordinates
    faces = measure.faces_of(scene.patches, scene.units, fault, "fault")
    hanging, foot = (scene.cutoffs(horizon, fault, side) for side in ("+", "-"))
    azimuth = math.degrees(math.atan2(*faces.strike[1].tolist())) % 360.0
    start = -float(faces.along(-faces.origin[None])[0])

    # first across the mean strike; its elevations say at which level walls are compared
    throw = measure.separation(hanging, foot, azimuth, start=start)
    if direction == "local" and throw.sizes["point"]:
        # cut-offs are compared at their mean elevation, down lines of steepest dip
        sources = {source.name: source for source in scene.patches.sources}
        cell = cell_of(scene.sheets.get(horizon, sources[horizon]))
        walls = throw.hanging_wall_elevation, throw.footwall_elevation
        mean, largest = 0.5 * sum(float(wall.mean()) for wall in walls), abs(throw.throw).max()
        try:
            level = to_level(sources[fault], float(largest), cell, mean, hanging, foot)
        except GeometryError as error:
            error.add_note("With direction='mean' throw is read across the mean strike.")
            raise
        if level is not None:  # None where the fault is straight
            throw = measure.separation(hanging, foot, azimuth, start=start, level=level)
    return throw.assign_attrs(horizon=horizon, fault=fault, direction=direction)


def closures_of(
    scene: Any, horizon: str | None, faults: Any, horizons: Any, min_height: float, vshale: Any
) -> xarray.Dataset:
    """Return closures: see `Scene.closures`."""
    # loaded by those who ask for closures
    given = rules_of_closures(scene, faults, horizons, vshale)
    least = number_of(min_height, "min_height", "give metres")
    names = roofs_of(scene.patches, scene.units, horizon)
    closures: xarray.Dataset = scene._measured(
        f"closures of {', '.join(names)}",
        lambda: find_closures(scene.patches, scene.units, names, given[0], least, *given[1:]),
        tuple(names), repr(given), least, scene._graph.regions_key,
    )  # fmt: skip
    warnings = warnings_of_spill(closures, scene.patches, scene.units, scene.contacts)
    scene._graph.memory.warn(*warnings)
    return closures


def seal_of(scene: Any, fault: str, *arguments: Any) -> xarray.Dataset:
    """Return what a fault holds: see `Scene.seal`."""
    # loaded by those who ask for seals

    name, given = name_of(fault, "fault"), checked_seal(scene, *arguments)
    seal: xarray.Dataset = scene._measured(
        f"seal {name}", lambda: fault_seal(scene.patches, scene.units, name, *given),
        name, repr(given), scene.units.reservoir, scene._graph.regions_key,
    )  # fmt: skip
    scene._graph.memory.warn(*warnings_of_seal(seal))
    return seal
