"""Rock and fluids of realisations: the arguments of `Scene.volumetrics`, some of them uncertain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from geosurf.conventions import did_you_mean
from geosurf.ensemble.change import Change, Given
from geosurf.ensemble.record import UnitKey
from geosurf.errors import InputError
from geosurf.measure.volumetrics import (
    ARGUMENTS,
    SIZES,
    Factor,
    amounts_of,
    check_range,
    check_system,
    columns_of,
    fluids_rule,
    refuse_unknown_words,
)
from geosurf.model import Lattice, Units
from geosurf.model.column import ELSEWHERE
from geosurf.model.distributions import distribution_of, is_distribution
from geosurf.scene.inputs import factors_of_rock

KEYS = (*ARGUMENTS, "fluids", "units")


@dataclass(frozen=True)
class RockProperty:
    """One number of `Scene.volumetrics` that is drawn: an uncertainty, which moves no surface.

    Attributes
    ----------
    parameter : str
        Name of its number: ``"porosity Top/Middle"``.
    by : distribution
    """

    parameter: str
    by: Any

    unit = "1"

    def prepare(self, given: Given) -> RockProperty:
        """Return itself: units of the base case decide whether there are such words."""
        return self

    def reach(self) -> float:
        """Return how far horizons may move [m]."""
        return 0.0

    def apply(self, change: Change) -> None:
        """Draw the number."""
        made = distribution_of(self.by, self.parameter)
        change.numbers[self.parameter] = change.draws.number(self.parameter, made)


@dataclass(frozen=True, eq=False)
class Rock:
    """What an ensemble counts of the units of its realisations.

    Attributes
    ----------
    factors : tuple of Factor
        With numbers, maps and distributions; empty: gross rock volume only.
    rule : Factor
        Fluids by words of units.
    system : str
        Units of measure.
    """

    factors: tuple[Factor, ...] = ()
    rule: Factor = field(default_factory=lambda: fluids_rule(None))
    system: str = "metric"

    @classmethod
    def of(cls, given: Any, crs: str | None) -> Rock:
        """Make one of the ``volumetrics=`` of users, checked, with maps as grids.

        Raises
        ------
        InputError
            For what `Scene.volumetrics` refuses.
        """
        if given is None:
            return cls()
        if not isinstance(given, Mapping):
            raise InputError(
                f"volumetrics is {given!r}; give the arguments of Scene.volumetrics, as in "
                "{'net_to_gross': 0.8, 'porosity': Normal(0.22, 0.02)}."
            )
        for key in given:
            if key not in KEYS:
                hint = did_you_mean(str(key), KEYS)
                raise InputError(f"volumetrics has {key!r}; its keys are {', '.join(KEYS)}.{hint}")
        system = given.get("units", "metric")
        check_system(system)
        rule, values = fluids_rule(given.get("fluids")), [given.get(key) for key in ARGUMENTS]
        if all(value is None for value in values):
            return cls((), rule, system)
        return cls(tuple(factors_of_rock(values, crs, drawn=True)), rule, system)

    @property
    def uncertain(self) -> tuple[RockProperty, ...]:
        """What is drawn."""
        return tuple(
            RockProperty(_parameter(factor, words), value)
            for factor in self.factors
            for words, value in factor.entries.items()
            if is_distribution(value)
        )

    @property
    def has_maps(self) -> bool:
        """Whether volumes are not enough: maps are integrated over the units themselves."""
        return any(isinstance(one, Lattice) for of in self.factors for one in of.entries.values())

    @property
    def columns(self) -> dict[str, dict[str, str]]:
        """Attributes of what is counted, by name."""
        return columns_of(len(self.factors), self.system)

    @property
    def identity(self) -> tuple[Any, ...]:
        """All that amounts depend on, as `add_to` takes it."""
        return (self.rule.entries, self.system, [
            (factor.name, sorted(words), (one.easting, one.northing, one.elevation)
             if isinstance(one, Lattice) else one)
            for factor in self.factors for words, one in factor.entries.items()
        ])  # fmt: skip

    def check(self, base: Units) -> None:
        """Refuse words that no unit of the base case has; those of a realisation may be fewer."""
        refuse_unknown_words(base, self.factors, self.rule)

    def amounts(
        self, units: Units, numbers: Mapping[str, float]
    ) -> dict[UnitKey, tuple[float, ...]]:
        """Return the columns of each unit; over- and underburden have a rock volume only."""
        factors = [self._drawn(factor, numbers) for factor in self.factors]
        part = units.included()
        fluids, values = amounts_of(part, factors, self.rule, self.system)
        of = dict(zip(part, zip(fluids, map(tuple, values.tolist()), strict=True), strict=True))
        size, none = SIZES[self.columns["bulk"]["units"]], (0.0,) * (len(self.columns) - 1)
        for name, unit in units.items():
            if name not in of:
                of[name] = "", (unit.volume / size, *none)
        return {
            UnitKey(unit.name, unit.zone, unit.region, unit.block, unit.contact, of[name][0]):
            of[name][1]
            for name, unit in units.items()
        }  # fmt: skip

    @staticmethod
    def _drawn(factor: Factor, numbers: Mapping[str, float]) -> Factor:
        """A factor with numbers in place of its distributions."""
        entries = dict(factor.entries)
        for words, value in factor.entries.items():
            if is_distribution(value):
                name = _parameter(factor, words)
                entries[words] = numbers[name]
                check_range(numbers[name], numbers[name], name)
        return replace(factor, entries=entries)


def _parameter(factor: Factor, words: frozenset[str]) -> str:
    """Name of the number that an argument has for some words, or for all other units."""
    others = [ELSEWHERE] if len(factor.entries) > 1 else []
    return " ".join([factor.name, *(sorted(words) or others)])
