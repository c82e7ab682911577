"""What realisations are made of: a scene whose inputs change, or a function that builds a scene."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import asdict, is_dataclass
from functools import cached_property, partial
from typing import Any, Protocol

import numpy as np

from geosurf.ensemble.change import Change, stream_of
from geosurf.ensemble.horizon_data import HorizonData
from geosurf.ensemble.uncertain_faults import Factor
from geosurf.errors import InputError
from geosurf.measure.velocity import scaled
from geosurf.model import Sheet, TriSurface
from geosurf.model.regions import KnownRegions
from geosurf.model.sheets import TearPlan
from geosurf.model.tops import Tops
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
from geosurf.scene.tearing import longer_faults
from geosurf.sheets.throw.throw_horizon import throw_horizon

OWN_NUMBERS = "a function that builds scenes draws its own numbers. Leave out uncertain=."


class Model(Protocol):
    """A model that realisations change."""

    is_data: bool  # whether it is data alone: a function may have effects in its own process

    def build(self, change: Change) -> Scene:
        """Return the scene of one realisation."""

    def outline(self, change: Change) -> Scene:
        """Return a scene with the area and box that `build` gives, from as little as that needs."""

    def framed(self, outline: Callable[[], Scene], reach: float) -> None:
        """Keep area and box of the base case, taller by a reach [m]; `outline` gives them."""

    def started(self, base: Scene) -> None:
        """Take what all realisations share from the base case in the final box."""

    def name_regions(self, known: KnownRegions | None) -> None:
        """Let regions of realisations have the names of those of the base case."""

    def identity(self) -> str:
        """Return a hash of all inputs: the same in every process."""


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

    is_data = True

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.horizon_names, self.fault_names = scene.horizon_names, scene.fault_names
        # Data of a horizon are read once and shared by all realisations.
        self._data: dict[str, HorizonData] = {}
        self._frame: dict[str, Any] = {}
        self.longer: LongerFaults = {}
        self._in_time_longer: dict[str, TriSurface] | None = None
        self.plans: dict[str, TearPlan] = {}
        # Of horizons that throws tear: the last sheet of each that does not move, by what it was
        # made from.
        self._thrown_sheets: dict[str, tuple[str, Sheet]] = {}

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
        contacts = {**self.contacts, **change.contacts}
        changes: dict[str, Any] = {"contacts": contacts} if change.contacts else {}
        if change.velocity:
            changes["velocity"] = scaled(self.velocity, change.velocity)
        return self.scene.replace(
            horizons=change.horizons(), faults=change.faults, **changes, **self._frame
        )

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

        sheets = {
            name: self.thrown_before(change, name, throws, partial(sheet_of, name))
            for name in self.horizon_names
        }
        # Sheets replace the continuous horizons that they were made from.
        return scene.replace(horizons=sheets)

    def thrown_before(
        self, change: Change, name: str, throws: Any, make: Callable[[], Sheet]
    ) -> Sheet:
        """The sheet of a horizon: that of the last realisation if all it is made from stays."""
        if name in change.up or change.faults:
            return make()
        digest = hashlib.sha256()
        add_to(digest, throws)
        known = self._thrown_sheets.get(name)
        if known is not None and known[0] == digest.hexdigest():
            return known[1]
        made = make()
        self._thrown_sheets[name] = digest.hexdigest(), made
        return made

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
            value, words = given_horizon(self.scene, name)
            # A sheet counts as its mesh, other horizons as their points.
            surface = value.surface if isinstance(value, Sheet) else None
            points = surface.vertices if surface else HorizonData.of(name, value, words).points
            add_to(digest, (name, points))
        for name in self.fault_names:
            fault = self.fault(name)
            add_to(digest, (name, fault.vertices, fault.triangles))
        add_to(digest, (self.contacts, given_settings(self.scene)))
        return digest.hexdigest()


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
