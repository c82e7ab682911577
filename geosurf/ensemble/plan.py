"""One ensemble, prepared: everything that a worker needs to build and measure realisation k."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from geosurf import __version__
from geosurf.conventions import counted
from geosurf.conventions.running import silence
from geosurf.ensemble.change import Change, Draws, Prepared, Uncertainty
from geosurf.ensemble.models import content_of
from geosurf.ensemble.record import Layers, Record, Rock, RockProperty, areas_of
from geosurf.ensemble.uncertain import ContactLevel, VelocityFactor, words_of_uncertainty
from geosurf.ensemble.uncertain_faults import FaultShift
from geosurf.errors import GeosurfError, InputError, silenced
from geosurf.scene import Scene
from geosurf.scene.given import given_settings, keep_results_apart, known_regions, measured_units

_BROKEN = (ArithmeticError, AssertionError, LookupError, TypeError, ValueError)
KINDS = "DepthShift, DepthError, ContactLevel, Throw, FaultShift and FaultDip of geosurf.ensemble"
VARY_IN_TIME = VelocityFactor, ContactLevel, FaultShift, RockProperty  # no metre moves a time


@dataclass(eq=False)
class Plan:
    """
    A model, its uncertainties, and what is measured of each realisation.

    Attributes
    ----------
    model : SceneModel or BuiltModel
    uncertain : tuple of Uncertainty
        In the order in which they change the inputs.
    seed : int
    grid : float, xarray object or None
        Nodes of maps; None: no maps.
    rock : Rock
        What is counted of each unit; what is uncertain of it is drawn with the rest.
    """

    model: Any
    uncertain: tuple[Uncertainty, ...]
    seed: int
    grid: Any = None
    rock: Rock = field(default_factory=Rock)

    def __post_init__(self) -> None:
        self.uncertain = (*self.uncertain, *self.rock.uncertain)
        self.layers: Layers | None = None
        self.reservoir: tuple[str, ...] = ()
        self.regions: list[str] = []  # of the base case, the largest first
        # whether this process has the results that realisations share
        self._shared = False
        # Parameters are columns of the result, and select streams of random numbers.
        names = [uncertainty.parameter for uncertainty in self.uncertain]
        for name in names:
            if names.count(name) > 1:
                raise InputError(
                    f"two uncertainties are called {name!r}. Give one of them another name="
                )
        self.prepared: tuple[Prepared, ...] = tuple(
            uncertainty.prepare(self.model) for uncertainty in self.uncertain
        )
        # metres that move horizons would be taken for milliseconds
        scene = getattr(self.model, "scene", None)
        if scene is not None and given_settings(scene)["time"] is not None:
            for name, uncertainty in zip(names, self.uncertain, strict=True):
                if not isinstance(uncertainty, VARY_IN_TIME):
                    raise InputError(
                        f"{name!r} moves horizons by metres or turns faults, and those of this "
                        "scene are in time. Vary velocities, contacts, fault positions or rock, or "
                        "give horizons in depth."
                    )

    def __getstate__(self) -> dict[str, Any]:
        """What goes to other processes, where scenes begin without results."""
        return {**self.__dict__, "_shared": False}

    @property
    def parameters(self) -> list[str]:
        """Names of the numbers that are drawn."""
        return [one.parameter for one in self.uncertain]

    @property
    def units(self) -> list[str]:
        """Unit of each of them."""
        return [one.unit for one in self.uncertain]

    @property
    def distributions(self) -> list[str]:
        """Distribution of each of them, in words."""
        # For the store: workers need no tables of reports.
        return [words_of_uncertainty(one) for one in self.uncertain]

    @cached_property
    def identity(self) -> str:
        """A hash of everything that results depend on."""
        # The version counts: another geosurf may compute other volumes.
        layers = self.layers.identity if self.layers else ""
        model = self.model.identity()
        return content_of(__version__, self.seed, model, self.uncertain, layers, self.rock.identity)

    # ---- scenes --------------------------------------------------------------------------

    def start(self) -> Record:
        """Build the base case, keep its area for all realisations, and measure it."""
        change = self._change(None)
        base = self.base_case()
        self.regions = list(base.regions)
        self.rock.check(measured_units(base, whole=False))
        self.model.started(base)
        self.model.name_regions(known_regions(base))
        self._shared = True
        self.reservoir = base.reservoir
        if self.grid is not None:
            self.layers = Layers.of(base, self.grid)
        return self.measure(base, change.numbers)

    def base_case(self) -> Scene:
        """Return the scene in which each parameter has its median; the model keeps its area.

        The area is that of the base case by itself, and its box is taller by the reach of all
        uncertainties, unless the user gave the box.
        """
        reach = sum(one.reach for one in self.prepared)
        self.model.framed(partial(self.scene, None), reach)
        return self.scene(None)

    def scene(self, realisation: int | None) -> Scene:
        """Return the scene of a realisation; None: the base case."""
        made: Scene = self.model.build(self._change(realisation))
        return made

    def _change(self, realisation: int | None) -> Change:
        """What changes in a realisation, with the numbers that were drawn for it."""
        # Uncertainties act in the order in which they were given.
        change = Change(self.model, Draws(self.seed, realisation))
        for one in self.prepared:
            one.apply(change)
        return change

    # ---- results -------------------------------------------------------------------------

    def run(self, realisation: int) -> Record:
        """
        Build and measure a realisation; one that fails has its reason in place of volumes.

        Warnings are counted, not issued: those of the base case are issued once.
        """
        change = Change(self.model, Draws(self.seed, realisation))
        # One warning per realisation would fill the console; the ensemble has a line of its own.
        with silence(), silenced() as warnings:
            try:
                for one in self.prepared:
                    one.apply(change)
                scene = self.model.build(change)
                self._keep_apart(scene)
                record = self._with_tears(self.measure(scene, change.numbers), scene)
            except GeosurfError as error:
                record = Record.failed(change.numbers, str(error))
            # A realisation that breaks an invariant is a failed one, and the others go on.
            except _BROKEN as error:
                record = Record.failed(change.numbers, f"{type(error).__name__}: {error}")
        # Equal warnings count once.
        return replace(record, realisation=realisation, n_warning=len(set(warnings)))

    def _keep_apart(self, scene: Scene) -> None:
        """Let a realisation take shared results, and give none: nobody asks for its own.

        In another process than that of the base case the first one gives its results: those of
        what does not change serve all others.
        """
        if self.model.is_data:
            if self._shared:
                keep_results_apart(scene)
            self._shared = True

    def _with_tears(self, record: Record, scene: Scene) -> Record:
        """The same with how many horizons were torn as picked, and how many were cut anew."""
        plans = {name: sheet.plan for name, sheet in scene.sheets.items() if sheet.plan is not None}
        # one that nothing moves has the sheet of the base case, which was searched for once
        base = {id(sheet.plan) for sheet in getattr(self.model, "base_sheets", {}).values()}
        anew = sum(plan.searched and id(plan) not in base for plan in plans.values())
        return replace(record, n_torn=len(plans), n_searched=anew)

    def measure(self, scene: Scene, numbers: dict[str, float]) -> Record:
        """Return what all units hold, and maps if they are requested."""
        # Moved contacts cut known units for volumes; maps need the units themselves.
        units = measured_units(scene, whole=self.layers is not None or self.rock.has_maps)
        amounts = self.rock.amounts(units, numbers)
        if self.layers is None:
            return Record(amounts, numbers)
        return Record(amounts, numbers, self.layers.thickness(scene), juxtaposed=areas_of(scene))


def uncertainties(given: Any) -> tuple[Uncertainty, ...]:
    """Return uncertainties as a tuple, or raise an error that names their kinds."""
    # A single uncertainty is a list of one.
    if hasattr(given, "prepare"):
        given = (given,)
    if not isinstance(given, Sequence) or isinstance(given, str):
        raise InputError(f"uncertain is {given!r}; give a list of {KINDS}.")
    for one in given:
        if not (hasattr(one, "prepare") and hasattr(one, "parameter")):
            raise InputError(f"uncertain has {one!r}; give a list of {KINDS}.")
    return tuple(given)


def vector(numbers: dict[str, float], parameters: list[str]) -> np.ndarray:
    """Return drawn numbers in the order of the parameters; NaN where none was drawn."""
    # A failed realisation may have drawn some of its numbers only.
    return np.array([numbers.get(name, np.nan) for name in parameters])


def words_of(plan: Plan) -> str:
    """Return what is uncertain, in words."""
    return f"{counted(len(plan.uncertain), 'parameter')}: {', '.join(plan.parameters)}"
