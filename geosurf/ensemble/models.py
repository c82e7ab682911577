"""What realisations are made of: a scene whose inputs change, or a function that builds a scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from geosurf.ensemble.change import Change, HorizonData, Uncertainty, stream_of
from geosurf.ensemble.uncertain import TOPS, ContactLevel, DepthError, DepthShift, VelocityFactor
from geosurf.ensemble.uncertain_faults import FaultDip, FaultShift, Throw
from geosurf.errors import InputError
from geosurf.measure.velocity import scaled
from geosurf.model import Sheet, TriSurface
from geosurf.model.regions import KnownRegions
from geosurf.model.sheets import TearPlan
from geosurf.model.tears import FaultThrow
from geosurf.model.tops import Tops
from geosurf.scenario.output_keys import UncertainInput, distribution_of
from geosurf.scene import Scene
from geosurf.scene.depth import converted
from geosurf.scene.faults import LongerFaults
from geosurf.scene.given import (
    frame_of,
    given_contacts,
    given_fault,
    given_horizon,
    given_settings,
    keep_on_disk,
    longer_in_depth,
    named_like,
    prepared_faults,
    torn_like,
)
from geosurf.scene.memory import fingerprint
from geosurf.scene.tearing import longer_faults

OWN_NUMBERS = "a function that builds scenes draws its own numbers. Leave out uncertain=."


class SceneModel:
    """
    A scene whose horizons, faults and contacts change.

    Parameters
    ----------
    scene : Scene

    Examples
    --------
    >>> from geosurf.ensemble.change import Draws
    >>> from geosurf.synthetic import tilted_planes
    >>> world = tilted_planes(n=5)
    >>> model = SceneModel(Scene(world.horizons, world.faults, world.box))
    >>> change = Change(model, Draws(0, None))
    >>> change.lift("Top", 10.0)
    >>> scene = model.build(change)
    >>> scene.surface("Top").bounds[4] - model.scene.surface("Top").bounds[4]
    10.0
    """

    is_data = True  # alone: a function may have effects in its own process

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.horizon_names, self.fault_names = scene.horizon_names, scene.fault_names
        # Data of a horizon are read once and shared by all realisations.
        self._data: dict[str, HorizonData] = {}
        self._frame: dict[str, Any] = {}
        self.longer: LongerFaults = {}
        self.base_sheets: dict[str, Sheet] = {}
        self.longer_in_time: dict[str, TriSurface] = {}
        self.plans: dict[str, TearPlan] = {}  # how horizons were torn as picked in the base case

    # ---- what is given -------------------------------------------------------------------

    def horizon(self, name: str) -> HorizonData:
        """Return the data of a horizon, before it is torn or thrown."""
        if name not in self._data:
            self._data[name] = HorizonData.of(name, *given_horizon(self.scene, name))
        return self._data[name]

    def fault(self, name: str) -> TriSurface:
        """Return a fault, before it is extended and truncated."""
        return given_fault(self.scene, name)

    @cached_property
    def contacts(self) -> dict[str, Any]:
        """Fluid contacts by name, as a scene takes them."""
        return given_contacts(self.scene)

    @property
    def deepest(self) -> float:
        """Depth of the floor of the model [m]."""
        return abs(frame_of(self.scene)[0][4])

    @property
    def velocity(self) -> Any:
        """Velocities as they were given."""
        return given_settings(self.scene)["velocity"]

    @property
    def tops(self) -> Tops | None:
        """Well tops of the scene."""
        return self.scene.tops

    # ---- realisations --------------------------------------------------------------------

    def build(self, change: Change) -> Scene:
        """Return the scene of one realisation; it shares with the others what does not change."""
        # What did not change is not handed over: the scene keeps its results.
        changes: dict[str, Any] = dict(self._frame)
        if change.contacts:
            changes["contacts"] = {**self.contacts, **change.contacts}
        if change.velocity:
            changes["velocity"] = scaled(self.velocity, change.velocity)
        if change.throws:
            changes["throws"] = _changed(self.scene._inputs.throws, change.throws)
        scene = self.scene.replace(horizons=change.horizons(), faults=change.faults, **changes)
        longer = self.longer
        if change.velocity and longer:
            longer = longer_in_depth(scene, self.longer_in_time)
        if not self.base_sheets:
            return scene
        still = {} if change.faults or change.velocity else self.base_sheets
        still = {name: sheet for name, sheet in still.items() if name not in change.up}
        return torn_like(scene, longer, self.plans, still)

    def framed(self, base: Callable[[], Scene], reach: float) -> None:
        """Keep area and box of the base case, taller by a reach [m]; nothing is torn for it."""
        given = given_settings(self.scene)
        # A box that the user gave holds for all realisations as it is.
        if given["box"] is not None:
            return
        # Without one, each realisation would get its own area, and volumes could not be compared.
        (west, east, south, north, bottom, top), area = frame_of(base())
        self._frame = {"box": (west, east, south, north, bottom - reach, top + reach)}
        # A word such as "rectangle" is not an area: the box is enough then.
        if not isinstance(given["aoi"], str):
            self._frame["aoi"] = area

    def started(self, base: Scene) -> None:
        """Keep how horizons were torn, and faults as long as they need them: not uncertain."""
        keep_on_disk(self.scene, None)  # sheets of realisations are nobody else's
        self.base_sheets = dict(base.sheets)
        # Read once: all realisations take over what this scene has read.
        for name in self.fault_names:
            self.fault(name)
        before = prepared_faults(base)
        self.longer = longer_faults(before, {name: base.whole_surface(name) for name in before})
        if base._inputs.becomes_depth:
            # faults go on beyond the horizons
            pair = converted(base._in_time, base._inputs, str(base._inputs.time), True)
            for name, (_, after) in self.longer.items():
                x = pair.convert(after.vertices, False)
                self.longer_in_time[name] = TriSurface(name, "fault", x, after.triangles)
        # The base case as planned: repairs that it needs beside its plan, all realisations need.
        self.plans = plans = _plans_of(self.base_sheets)
        if plans:
            again = torn_like(self.scene.replace(**self._frame), self.longer, plans, {})
            for name, more in _plans_of(again.sheets).items():
                self.plans[name] = plans[name].with_repairs_of(more)

    def name_regions(self, known: KnownRegions | None) -> None:
        """Let regions of realisations have the names of those of the base case."""
        self.scene = named_like(self.scene, known)

    def identity(self) -> str:
        """Return a hash of all inputs: the same in every process."""
        # Names and arrays: a store must not be continued with other data.
        horizons = [(name, self._points(name)) for name in self.horizon_names]
        faults = [self.fault(name) for name in self.fault_names]
        return content_of(horizons, faults, self.contacts, given_settings(self.scene))

    def _points(self, name: str) -> np.ndarray:
        """Points of a horizon, of a sheet those of its mesh."""
        value, words = given_horizon(self.scene, name)
        if isinstance(value, Sheet):
            return value.surface.vertices
        return HorizonData.of(name, value, words).points


class BuiltModel:
    """A function of a random number generator that returns a scene."""

    is_data = False
    horizon_names: tuple[str, ...] = ()
    fault_names: tuple[str, ...] = ()
    velocity: Any = None
    deepest = 0.0
    tops: Tops | None = None

    def __init__(self, function: Callable[[np.random.Generator], Scene], seed: int) -> None:
        self.function, self.seed = function, seed
        self.contacts: dict[str, Any] = {}
        self._known: KnownRegions | None = None

    def horizon(self, name: str) -> HorizonData:
        """Refuse: a function has no inputs to change."""
        raise InputError(OWN_NUMBERS)

    def fault(self, name: str) -> TriSurface:
        """Refuse: a function has no inputs to change."""
        raise InputError(OWN_NUMBERS)

    def build(self, change: Change) -> Scene:
        """Return the scene of one realisation."""
        # One stream for all that the function draws.
        scene = self.function(stream_of(self.seed, change.draws.realisation or 0, "build"))
        if not isinstance(scene, Scene):
            raise InputError(
                f"the function that builds a realisation returned {type(scene).__name__}. Return "
                "a geosurf.Scene."
            )
        return scene if self._known is None else named_like(scene, self._known)

    def framed(self, base: Callable[[], Scene], reach: float) -> None:
        """Change nothing: the function chooses the box."""

    def started(self, base: Scene) -> None:
        """Nothing: the function builds all of each realisation."""

    def name_regions(self, known: KnownRegions | None) -> None:
        """Let regions of realisations have the names of those of the base case."""
        self._known = known

    def identity(self) -> str:
        """Return the name of the function: what it does cannot be compared."""
        # Two functions of one name count as one: their code is not compared.
        return f"{self.function.__module__}.{getattr(self.function, '__qualname__', '')}"


def content_of(*values: Any) -> str:
    """Return a hash of values by their content: the same in every process.

    Examples
    --------
    >>> content_of({"a": [1.0, np.arange(3)]}) == content_of({"a": [1.0, np.arange(3)]})
    True
    """
    # in a mapping words are words, not paths of files
    return fingerprint({"": values}, _by_name)


def _by_name(value: Any) -> str:
    """What stands for an object in every process: its repr, of a function its name."""
    if is_dataclass(value) and not isinstance(value, type):
        numbers = {one.name: getattr(value, one.name) for one in fields(value)}
        return content_of(type(value).__qualname__, numbers)
    # a frozen distribution of scipy.stats and a partial hold what they call with arguments
    called = getattr(value, "dist", getattr(value, "func", value))
    if not callable(called):
        return repr(value)
    name = getattr(called, "__qualname__", type(called).__name__)
    words = getattr(value, "kwds", getattr(value, "keywords", {}))
    return content_of(name, getattr(value, "args", ()), words)


def _plans_of(sheets: Mapping[str, Sheet]) -> dict[str, TearPlan]:
    """How sheets were torn, by horizon; those that throw moved have no plan."""
    return {name: sheet.plan for name, sheet in sheets.items() if sheet.plan is not None}


def _changed(
    given: tuple[FaultThrow, ...], throws: Mapping[str, tuple[Any, float]]
) -> tuple[FaultThrow, ...]:
    """The throws of a scene as a realisation has them: each of a form, multiplied by a factor."""
    known = [throw.fault for throw in given]
    added = [FaultThrow(name, None) for name in throws if name not in known]
    changed = []
    for throw in (*given, *added):
        if throw.fault in throws:
            shape, by = throws[throw.fault]
            if shape is None and throw.throw is None:
                raise InputError(
                    f"the scene has no throw of {throw.fault!r} to multiply. Give one, as in "
                    f"Throw({throw.fault!r}, 60.0, factor=...)."
                )
            throw = (throw if shape is None else replace(throw, throw=shape)).times(by)
        changed.append(throw)
    return tuple(changed)


def uncertainty_of(entry: UncertainInput) -> Uncertainty:
    """Return the uncertainty of one table of a scenario.

    Examples
    --------
    >>> uncertainty_of(UncertainInput(kind="fault dip", of=("F1",), normal=(0.0, 2.0)))
    FaultDip(faults=('F1',), by=Normal(mean=0.0, sd=2.0, low=None, high=None), name='')
    """
    if entry.kind == "depth error":
        assert entry.sd_m is not None
        assert entry.range_m is not None
        picks = TOPS if entry.meet_tops else None
        return DepthError(entry.of, entry.sd_m, entry.range_m, entry.model, picks)
    by: Any = distribution_of(entry)
    # Made on demand: names may be missing for other kinds.
    makers: dict[str, Any] = {
        "depth shift": lambda: DepthShift(entry.of, by),
        "contact shift": lambda: ContactLevel(entry.of[0], shift=by),
        "contact level": lambda: ContactLevel(entry.of[0], elevation=by),
        "throw": lambda: Throw(entry.of[0], by),
        "throw factor": lambda: Throw(entry.of[0], factor=by),
        "fault position": lambda: FaultShift(entry.of, by),
        "fault dip": lambda: FaultDip(entry.of, by),
        "velocity factor": lambda: VelocityFactor(entry.of, by),
    }
    made: Uncertainty = makers[entry.kind]()
    return made
