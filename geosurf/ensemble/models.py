"""What realisations are made of: a scene whose inputs change, or a function that builds a scene."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Mapping
from dataclasses import asdict, is_dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from geosurf.conventions.checks import are_points
from geosurf.ensemble.change import Change, HorizonData, Uncertainty, stream_of
from geosurf.ensemble.record import Rock
from geosurf.ensemble.uncertain import (
    TOPS,
    ContactLevel,
    DepthError,
    DepthShift,
    Factor,
    FaultDip,
    FaultShift,
    Throw,
    VelocityFactor,
)
from geosurf.errors import InputError
from geosurf.measure.velocity import scaled
from geosurf.model import Sheet, TriSurface
from geosurf.model.regions import KnownRegions
from geosurf.model.sheets import TearPlan
from geosurf.model.tops import Tops
from geosurf.scenario import read_scenario
from geosurf.scenario.build import scene_in_time, untorn_scene
from geosurf.scenario.keys import Scenario, ThrowInput
from geosurf.scenario.output_keys import UncertainInput, distribution_of
from geosurf.scenario.torn import keeps_area, torn_horizons
from geosurf.scene import Scene
from geosurf.scene.faults import LongerFaults
from geosurf.scene.given import (
    frame_of,
    given_contacts,
    given_fault,
    given_horizon,
    given_settings,
    longer_in_depth,
    named_like,
    prepared_faults,
    torn_like,
)
from geosurf.scene.result_cache import ResultCache, name_of_result
from geosurf.scene.surfaces import footprint
from geosurf.scene.tearing import longer_faults
from geosurf.sheets.throw.throw_horizon import throw_horizon

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
    settings_of_tears: tuple[Any, ...] = ()

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.horizon_names, self.fault_names = scene.horizon_names, scene.fault_names
        # Data of a horizon are read once and shared by all realisations.
        self._data: dict[str, HorizonData] = {}
        self._frame: dict[str, Any] = {}
        self.longer: LongerFaults = {}
        self._in_time_longer: dict[str, TriSurface] | None = None
        self.plans: dict[str, TearPlan] = {}
        # The last sheet of each horizon that does not move, by what it was made from.
        self._sheets: dict[str, tuple[str, Sheet]] = {}

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
        return abs(self.scene.box[4])

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
        scene = self._unthrown(change)
        if change.throws:
            return self._thrown(scene, change)
        if not self.plans:
            return scene
        longer = self.longer
        if change.velocity:
            longer = longer_in_depth(scene, scene, self._longer_in_time(self.scene))
        return torn_like(scene, longer, self.plans)

    def _longer_in_time(self, in_time: Scene) -> dict[str, TriSurface]:
        """Faults as long as the base case needed them, in time; `in_time` has its velocities."""
        if self._in_time_longer is None:
            self._in_time_longer = {
                name: TriSurface(name, "fault", in_time.to_time(after.vertices), after.triangles)
                for name, (_, after) in self.longer.items()
            }
        return self._in_time_longer

    def _unthrown(self, change: Change) -> Scene:
        """A scene with the inputs of a realisation, without throws."""
        # What did not change is not handed over: the scene keeps its results.
        changes = self._contacts_and_frame(change)
        if change.velocity:
            changes["velocity"] = scaled(self.velocity, change.velocity)
        return self.scene.replace(horizons=change.horizons(), faults=change.faults, **changes)

    def _contacts_and_frame(self, change: Change) -> dict[str, Any]:
        """What a scene of a realisation takes for its fluid contacts, its box and its area."""
        if not change.contacts:
            return dict(self._frame)
        return {"contacts": {**self.contacts, **change.contacts}, **self._frame}

    def _thrown(self, scene: Scene, change: Change) -> Scene:
        """A scene with all horizons torn by the throws of a realisation."""
        # As the scene has them, extended and truncated: sheets have to end on these.
        faults = [scene.surface(name) for name in change.throws]
        throws = {
            name: given.of(None) if isinstance(given, Factor) else given
            for name, given in change.throws.items()
        }
        moved = change.horizons()

        def sheet_of(name: str) -> Sheet:
            """The sheet of a horizon."""
            horizon = moved.get(name) or self.horizon(name).surface
            return throw_horizon(horizon, faults, throws, name=name)

        digest = hashlib.sha256()
        add_to(digest, (throws, *faults))
        sheets = {
            name: self.remembered(change, name, digest.hexdigest(), partial(sheet_of, name))
            for name in self.horizon_names
        }
        # Sheets replace the continuous horizons that they were made from.
        return scene.replace(horizons=sheets)

    def remembered(
        self, change: Change, name: str, key: str | None, make: Callable[[], Sheet]
    ) -> Sheet:
        """The sheet of a horizon; that of the last realisation if its data stay, and the key."""
        if name in change.up or change.velocity or key is None:
            return make()
        known = self._sheets.get(name)
        if known is None or known[0] != key:
            known = self._sheets[name] = key, make()
        return known[1]

    def outline(self, change: Change) -> Scene:
        """Return the scene itself: nothing is torn before it is read."""
        return self.build(change)

    def framed(self, outline: Callable[[], Scene], reach: float) -> None:
        """Keep area and box of the base case, taller by a reach [m]; `outline` gives them."""
        given = given_settings(self.scene)
        # A box that the user gave holds for all realisations as it is.
        if given["box"] is not None:
            return
        # Without one, each realisation would get its own area, and volumes could not be compared.
        # It follows from the horizons as they are given: nothing is torn for it.
        (west, east, south, north, bottom, top), area = frame_of(outline())
        self._frame = {"box": (west, east, south, north, bottom - reach, top + reach)}
        # A word such as "rectangle" is not an area: the box is enough then.
        if not isinstance(given["aoi"], str):
            self._frame["aoi"] = area

    def started(self, base: Scene) -> None:
        """Keep how horizons were torn, and faults as long as they need them: not uncertain."""
        sheets = base.sheets.items()
        self.plans = {name: sheet.plan for name, sheet in sheets if sheet.plan is not None}
        # Read once: all realisations take over what this scene has read.
        for name in self.fault_names:
            self.fault(name)
        before = prepared_faults(self.scene.replace(**self._frame))
        self.longer = longer_faults(before, {name: base.whole_surface(name) for name in before})

    def name_regions(self, known: KnownRegions | None) -> None:
        """Let regions of realisations have the names of those of the base case."""
        self.scene = named_like(self.scene, known)

    def identity(self) -> str:
        """Return a hash of all inputs: the same in every process."""
        # Names and arrays: a store must not be continued with other data.
        digest = hashlib.sha256()
        for name in self.horizon_names:
            add_to(digest, (name, self._points(name)))
        for name in self.fault_names:
            fault = self.fault(name)
            add_to(digest, (name, fault.vertices, fault.triangles))
        add_to(digest, (self.contacts, given_settings(self.scene), *self.settings_of_tears))
        return digest.hexdigest()

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

    def outline(self, change: Change) -> Scene:
        """Return the scene of a realisation: only the function knows its box."""
        return self.build(change)

    def framed(self, outline: Callable[[], Scene], reach: float) -> None:
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


def add_to(digest: Any, value: Any) -> None:
    """Add a value to a hash, by its content: the same in every process.

    Examples
    --------
    >>> one, two = hashlib.sha256(), hashlib.sha256()
    >>> add_to(one, {"a": [1.0, np.arange(3)]})
    >>> add_to(two, {"a": [1.0, np.arange(3)]})
    >>> one.hexdigest() == two.hexdigest()
    True
    """
    # By kind: each value contributes its content and enough of its structure that no two are alike.
    if isinstance(value, TriSurface):
        add_to(digest, (value.name, value.vertices, value.triangles))
    elif hasattr(value, "to_dict") and hasattr(value, "coords"):
        add_to(digest, value.to_dict())
    elif is_dataclass(value) and not isinstance(value, type):
        digest.update(type(value).__name__.encode())
        try:
            add_to(digest, asdict(value))
        except TypeError:  # holds something that cannot be copied
            digest.update(repr(value).encode())
    # In the order of the mapping, which is part of the meaning.
    elif isinstance(value, Mapping):
        for key in value:
            digest.update(f"{key}:".encode())
            add_to(digest, value[key])
    elif isinstance(value, np.ndarray):
        digest.update(f"{value.dtype} {value.shape}".encode())
        # Bytes of a slice depend on its layout: one piece first.
        digest.update(np.ascontiguousarray(value))
    elif isinstance(value, tuple | list):
        digest.update(f"{len(value)}".encode())
        for part in value:
            add_to(digest, part)
    # A function counts by its name, a frozen distribution by its arguments.
    elif callable(value):
        name = getattr(value, "__qualname__", type(value).__name__)
        args = getattr(value, "args", ())
        add_to(digest, (name, tuple(args) if isinstance(args, tuple) else ()))
    else:
        digest.update(f"{type(value).__name__} {value!r}".encode())


# ---- scenario ----------------------------------------
# A scenario whose horizons, faults, throws and contacts change from realisation to realisation.


class ScenarioModel(SceneModel):
    """
    A scenario: its horizons are torn or thrown again in each realisation.

    Parameters
    ----------
    source : path-like or Scenario
        A file, or what `read_scenario` made of one.
    cache : ResultCache, optional
        Has sheets of the base case, from other commands on the same field.

    Attributes
    ----------
    scenario : Scenario
    uncertain : tuple of Uncertainty
        Of its tables ``[[uncertain]]``.
    rock : Rock
        Of its table ``[volumetrics]``.
    """

    def __init__(
        self, source: str | os.PathLike[str] | Scenario, cache: ResultCache | None = None
    ) -> None:
        self.scenario = source if isinstance(source, Scenario) else read_scenario(source)
        # Without tearing: that is repeated in each realisation.
        self._in_time = None if self.scenario.time is None else scene_in_time(self.scenario)
        scene, self._values = untorn_scene(self.scenario, in_time=self._in_time)
        given = self.scenario.volumetrics
        self.rock = Rock.of(None if given is None else vars(given), scene.crs)
        if not self.scenario.uncertain and not self.rock.uncertain:
            raise InputError(
                f"{self.scenario.path}: nothing is uncertain. Add a table [[uncertain]] for each "
                "input that is, for example these four lines:\n\n"
                '[[uncertain]]\nkind = "depth error"\nsd_m = 10.0\nrange_m = 1500.0'
            )
        if self.scenario.zones and any("depth" in one.kind for one in self.scenario.uncertain):
            raise InputError(
                f"{self.scenario.path}: horizons that [zones] make do not follow uncertain "
                "horizons of a scenario yet. Give run_ensemble the Scene: "
                "Scene(..., zones={...}), uncertain=[...]."
            )
        super().__init__(scene)
        self._cache = cache
        # Settings of tearing change results as data do.
        self.settings_of_tears = ((self.scenario.tear, self.scenario.throws),)
        self.uncertain = tuple(uncertainty_of(entry) for entry in self.scenario.uncertain)

    def horizon(self, name: str) -> HorizonData:
        """Return the data of a horizon, before it is torn or thrown."""
        # Points of a horizon stay points here, while the scene has an outline in their place.
        if name not in self._data:
            self._data[name] = HorizonData.of(name, self._values[name])
        return self._data[name]

    def started(self, base: Scene) -> None:
        """Keep what realisations begin with; their own sheets are nobody else's."""
        super().started(base)
        self._cache = None

    @property
    def velocity(self) -> Any:
        """Velocities as they were given."""
        return self.scenario.velocity

    def outline(self, change: Change) -> Scene:
        """Return a scene with the area of a realisation; nothing is torn that does not count."""
        if keeps_area(self.scenario, self.horizon_names):
            return self._untorn(change, {**self._values, **change.horizons()})
        return self.build(change)

    def _untorn(self, change: Change, values: dict[str, Any]) -> Scene:
        """The scene of a realisation before horizons are torn; `values` are data of all of them."""
        plain = {
            name: footprint(name, values[name], {}) if are_points(values[name]) else values[name]
            # Only what has moved is handed to the scene; points are an outline there until they are
            # torn.
            for name in change.up
        }
        more = self._contacts_and_frame(change)
        return self.scene.replace(horizons=plain, faults=change.faults, **more)

    def _converted(self, change: Change) -> tuple[Scene, dict[str, Any], LongerFaults, Scene]:
        """The scene of a realisation with other velocities, not torn, its data, longer faults."""
        assert self._in_time is not None
        if change.up or change.faults:
            raise InputError(
                "depths and faults cannot vary together with velocities, which move both. Leave "
                "one of them out."
            )
        velocity = scaled(self.velocity, change.velocity)
        in_time = self._in_time.replace(velocity=velocity)
        scene, values = untorn_scene(self.scenario, in_time=in_time)
        scene = scene.replace(**self._contacts_and_frame(change))
        longer = longer_in_depth(scene, in_time, self._longer_in_time(self._in_time))
        return scene, values, longer, in_time

    def build(self, change: Change) -> Scene:
        """Return the scene of one realisation."""
        # Data of all horizons; those that have moved replace their own.
        values = {**self._values, **change.horizons()}
        longer, in_time = self.longer, self._in_time
        if change.velocity:
            scene, values, longer, in_time = self._converted(change)
        else:
            scene = self._untorn(change, values)
        # Throws change in the scenario, so that tearing follows its usual way.
        throws = tuple(_changed(entry, change.throws) for entry in self.scenario.throws)
        scenario = replace(self.scenario, throws=throws)
        return torn_horizons(
            scenario,
            scene,
            values,
            lambda *_: None,
            cache=self._cache,
            longer=longer,
            plans=self.plans,
            remember=lambda name, inputs, make: self.remembered(
                change, name, name_of_result("sheet", inputs), make
            ),
            in_time=in_time,
        )

    def _points(self, name: str) -> np.ndarray:
        """Points of a horizon."""
        return self.horizon(name).points


def _changed(entry: ThrowInput, throws: dict[str, Any]) -> ThrowInput:
    """A throw of a scenario, as a realisation has it."""
    throw = throws.get(entry.fault)
    # A throw that is certain stays as the scenario has it.
    if throw is None:
        return entry
    if not isinstance(throw, Factor):
        return replace(entry, throw_m=throw)
    # A factor multiplies whatever form the throw has.
    words: dict[str, Any] = {}
    for word in ("throw_m", "elliptic_m"):
        if getattr(entry, word) is not None:
            words[word] = throw.by * getattr(entry, word)
    if entry.profile_m is not None:
        words["profile_m"] = tuple((along, throw.by * t) for along, t in entry.profile_m)
    return replace(entry, **words)


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
