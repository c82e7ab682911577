"""A scenario whose horizons, faults, throws and contacts change from realisation to realisation."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from geosurf.conventions.checks import are_points
from geosurf.ensemble.change import Change, Uncertainty
from geosurf.ensemble.horizon_data import HorizonData
from geosurf.ensemble.models import SceneModel, add_to
from geosurf.ensemble.rock import Rock
from geosurf.ensemble.uncertain import TOPS, ContactLevel, DepthError, DepthShift, VelocityFactor
from geosurf.ensemble.uncertain_faults import Factor, FaultDip, FaultShift, Throw
from geosurf.errors import InputError
from geosurf.measure.velocity import scaled
from geosurf.model import Sheet, TriSurface
from geosurf.scenario import read_scenario
from geosurf.scenario.build import scene_in_time, untorn_scene
from geosurf.scenario.keys import Scenario, ThrowInput
from geosurf.scenario.output_keys import UncertainInput, distribution_of
from geosurf.scenario.torn import keeps_area, torn_horizons
from geosurf.scene import Scene
from geosurf.scene.faults import LongerFaults
from geosurf.scene.given import given_settings, longer_in_depth
from geosurf.scene.memory import fingerprint
from geosurf.scene.result_cache import ResultCache
from geosurf.scene.surfaces import footprint


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
        self._sheets: dict[str, tuple[tuple[str, ...], Sheet]] = {}
        self._cache = cache
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
        contacts = {"contacts": {**self.contacts, **change.contacts}} if change.contacts else {}
        return self.scene.replace(horizons=plain, faults=change.faults, **contacts, **self._frame)

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
        contacts = {"contacts": {**self.contacts, **change.contacts}} if change.contacts else {}
        scene = scene.replace(**contacts, **self._frame)
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

        def remember(
            name: str, faults: dict[str, TriSurface], fill: bool | Sheet, make: Callable[[], Sheet]
        ) -> Sheet:
            """The sheet of a horizon; that of the last realisation if nothing has changed."""
            if name in change.up or change.velocity:
                return make()
            filled = str(fill) if isinstance(fill, bool) else fingerprint(fill)
            key = (*map(fingerprint, faults.values()), filled)
            known = self._sheets.get(name)
            if known is None or known[0] != key:
                known = self._sheets[name] = key, make()
            return known[1]

        def remember_thrown(
            name: str, throws: Sequence[ThrowInput], make: Callable[[], Sheet]
        ) -> Sheet:
            """The same of a horizon that throws tear."""
            return self.thrown_before(change, name, tuple(throws), make)

        return torn_horizons(
            scenario,
            scene,
            values,
            lambda *_: None,
            cache=self._cache,
            longer=longer,
            plans=self.plans,
            remember=remember,
            remember_thrown=remember_thrown,
            in_time=in_time,
        )

    def identity(self) -> str:
        """Return a hash of all inputs: the same in every process."""
        digest = hashlib.sha256()
        for name in self.horizon_names:
            add_to(digest, (name, self.horizon(name).points))
        for name in self.fault_names:
            fault = self.fault(name)
            add_to(digest, (name, fault.vertices, fault.triangles))
        # Settings of tearing change results as data do.
        settings = (self.scenario.tear, self.scenario.throws)
        add_to(digest, (self.contacts, given_settings(self.scene), settings))
        return digest.hexdigest()


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
    return makers[entry.kind]()
