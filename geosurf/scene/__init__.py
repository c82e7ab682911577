"""Scene: horizons, faults and a box; every result when it is first asked for."""

from __future__ import annotations

import weakref
from collections.abc import Hashable, Mapping
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from geosurf.arrangement import find_contacts
from geosurf.arrangement.search import check_voxel_size
from geosurf.carve import carve_units
from geosurf.carve.certificate import certify, same_bytes
from geosurf.carve.order import warnings_of_order
from geosurf.carve.thin import warnings_of_thin_units
from geosurf.conventions import counted, did_you_mean, elevation_sign, metres_per_unit
from geosurf.errors import GeosurfWarning, InputError
from geosurf.model import Certificate, Patches, TriSurface, Units, check_column
from geosurf.model.expected import box_of_sides, flag_of
from geosurf.rebuild import patches_from, trim_sheets
from geosurf.rebuild.moves import warnings_of_moves
from geosurf.scene.curves import check_scene_tolerance
from geosurf.scene.faults import FaultStage
from geosurf.scene.inputs import (
    INPUTS,
    as_mapping,
    exchanged,
    only_of,
    refuse_assignment,
    refuse_namesakes,
)
from geosurf.scene.memory import Memory, Step
from geosurf.scene.provided import Box, Provided
from geosurf.triangulate import build_walls


class Scene(Provided):
    """
    Horizons and faults in a model box: a small graph of stages with memory.

    Nothing is computed until it is asked for, and nothing twice: results are found
    by what went into them. Asking for the curves of one pair reads and intersects that pair only.
    A scene never changes: `replace` gives another one, with some inputs changed.

    Parameters
    ----------
    horizons : mapping of str to horizon
        Youngest first. A horizon is an `xarray.DataArray`, a `TriSurface`, (vertices, triangles),
        a `Sheet`, or a path.
    faults : mapping of str to fault, optional
        A fault is an `xarray.Dataset`, `FaultSticks`, a `TriSurface`, (vertices, triangles), or a
        path.
    box : (west, east, south, north, bottom, top), optional
        The model box [m]. Default: the largest upright rectangle that all horizons cover, with a
        margin above and below; it moves with them, so give a box to compare scenes.
    column : mapping of str to str, optional
        How horizons that cross yield: ``"erosional"`` removes what lies below, ``"base"``
        what lies above, ``"discontinuous"`` both. The others are ``"conformable"``: of two
        that cross, the older one ends on the younger. ``units.report["clipped"]`` lists it all.
    contacts : mapping of str to contact, optional
        Fluid contacts from the top down, which split units: ``{"OWC": -1705.0}``, also by
        block and zone; see `build_contacts` and `FluidContact`. A path is a gridded horizon.
    aoi : array_like of float, shape (n, 2), or path, optional
        Area of interest: easting and northing around a polygon, which the model then fills.
    positive : {"up", "down"}, optional
        Whether inputs that do not say so hold elevations or depths.
    length_unit : str, optional
        Length unit of elevations (or depths) of inputs that do not declare theirs. Easting and
        northing are metres, unless an input declares another unit for them.
    voxel_size : float, optional
        Edge of the search voxels [m]. Changes the cost, never the result.
    self_intersections : bool
        Whether surfaces are also split where they cross themselves.
    extend : bool, sequence of str, or mapping of str to sides, optional
        Faults that are continued until they leave the model box (that which is given, where `aoi`
        is smaller): all, some, or some of their sides (``"strike"``, ``"start"``, ``"end"``,
        ``"up"``, ``"down"``).
    truncations : mapping of str to (main, keep[, extend]), optional
        Faults that end at others: ``{"F2": ("F1", "hanging wall")}``. A third word True
        first continues F2 to F1. See docs/faults.md.
    tolerance : float, optional
        [m], for pictures and quick volumes: horizons from grids become as few triangles as stay
        this near, above and below, and `volume_error_bound` tells what that does to volumes;
        `curves` are those of smooth surfaces through all nodes, to this error: docs/accuracy.md.

    Raises
    ------
    InputError
        For a missing horizon, a name used twice, an input of an unknown kind, a box that is
        none, or a tolerance that is no length or meets a torn horizon. Later, where they are asked
        for: inputs that cannot be used, or are in different coordinate reference systems.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes()
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> scene.curves.n_curve, len(scene.units)
    (2, 6)
    >>> round(scene.units["Top/Base F1+"].volume / world.truth["volumes"]["Top/Base", ("F1+",)], 12)
    1.0
    """

    def __init__(
        self,
        horizons: Mapping[str, Any],
        faults: Mapping[str, Any] | None = None,
        box: Box | None = None,
        *,
        column: Mapping[str, str] | None = None,
        contacts: Mapping[str, Any] | None = None,
        aoi: Any = None,
        positive: str | None = None,
        length_unit: str | None = None,
        voxel_size: float | None = None,
        self_intersections: bool = False,
        extend: Any = (),
        truncations: Mapping[str, Any] | None = None,
        tolerance: float | None = None,
    ) -> None:
        self._horizons = as_mapping("horizons", horizons)
        self._faults = as_mapping("faults", {} if faults is None else faults)
        if not self._horizons and not self._faults:
            raise InputError(
                "a scene needs at least one horizon or fault; give horizons={name: ...}."
            )
        self._box = None if box is None else tuple(box_of_sides(box).tolist())
        check_column(tuple(self._horizons), column)
        self._column = dict(column or {})
        self._contacts = as_mapping("contacts", {} if contacts is None else contacts)
        refuse_namesakes(horizon=self._horizons, fault=self._faults, contact=self._contacts)
        self._aoi = aoi
        if positive is not None:
            elevation_sign(positive, "the scene")
        if length_unit is not None:
            metres_per_unit(length_unit, "the scene")
        check_voxel_size(voxel_size)
        self._positive, self._length_unit, self._voxel_size = positive, length_unit, voxel_size
        self._self = flag_of(self_intersections, "self_intersections")
        self._tolerance = check_scene_tolerance(tolerance, self._horizons)
        self._memory = Memory()
        self._read: dict[str, str] = {}
        self._crs: dict[str, str] = {}
        self._truncations = dict(
            as_mapping("truncations", {} if truncations is None else truncations)
        )
        self._extend = extend
        network = self._stage_of_faults()
        self._extend = network.sides
        self._network = network  # the last: from here on nothing can be set

    def _stage_of_faults(self) -> FaultStage:
        """The faults, made ready; it knows the scene weakly, which so ends with its last name."""
        me = weakref.proxy(self)
        return FaultStage(
            tuple(self._faults), self._truncations, self._extend,
            given=lambda name: me._given_fault(name), limits=lambda: me._limits(),
            extent=lambda: me._extent(), memory=self._memory,
        )  # fmt: skip

    def __setattr__(self, name: str, value: Any) -> None:
        """Refuse: results would stay those of the inputs that there were."""
        if "_network" in self.__dict__:
            refuse_assignment(name)
        super().__setattr__(name, value)

    def __delattr__(self, name: str) -> None:
        """Refuse: results would stay those of the inputs that there were."""
        refuse_assignment(name)

    def __getstate__(self) -> dict[str, Any]:
        return {key: value for key, value in self.__dict__.items() if key != "_network"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.__dict__["_network"] = self._stage_of_faults()

    @property
    def truncations(self) -> Mapping[str, Any]:
        """Faults that end at others, as they were given; read-only."""
        return MappingProxyType(self._truncations)

    @property
    def extend(self) -> Mapping[str, tuple[str, ...]]:
        """Faults that are continued, and on which sides; read-only."""
        return MappingProxyType(self._extend)

    def replace(self, **changes: Any) -> Scene:
        """Return a new scene with some inputs changed, which shares all results that still hold.

        Parameters
        ----------
        horizons, faults : mapping, optional
            Named inputs to exchange or add; None as a value removes one, and with a fault its
            own extension and truncations. New horizons come last, as the oldest.
        box, column, contacts, aoi, extend, truncations : optional
            As for `Scene`; they replace those that there were.
        positive, length_unit, voxel_size, self_intersections, tolerance : optional
            As for `Scene`.

        Returns
        -------
        Scene

        Raises
        ------
        InputError
            For an unknown word, or the name of something to remove that is not there.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.tilted_planes()
        >>> scene = gs.Scene(world.horizons, world.faults, world.box)
        >>> scene.replace(faults={"F1": None}).fault_names
        ()
        """
        for key in changes:
            if key not in INPUTS:
                raise InputError(
                    f"a scene has no {key!r}; it has {INPUTS}.{did_you_mean(key, INPUTS)}"
                )
        inputs = {
            "horizons": exchanged("horizons", self._horizons, changes.get("horizons")),
            "faults": exchanged("faults", self._faults, changes.get("faults")),
        }
        twin = Scene(
            inputs["horizons"],
            inputs["faults"],
            changes.get("box", self._box),
            column=changes.get("column", only_of(self._column, inputs["horizons"])),
            contacts=changes.get("contacts", self._contacts),
            aoi=changes.get("aoi", self._aoi),
            positive=changes.get("positive", self._positive),
            length_unit=changes.get("length_unit", self._length_unit),
            voxel_size=changes.get("voxel_size", self._voxel_size),
            self_intersections=changes.get("self_intersections", self._self),
            extend=changes.get("extend", only_of(self.extend, inputs["faults"])),
            truncations=changes.get("truncations", only_of(self.truncations, inputs["faults"])),
            tolerance=changes.get("tolerance", self._tolerance),
        )
        twin._memory.share(self._memory)
        return twin

    # ----------------------------------------------------------------- results
    @cached_property
    def patches(self) -> Patches:
        """All surfaces and the walls of the box, split along their curves."""
        self._prepare()
        n, place = len(self._enclosed) - len(self._walls), "box" if self.aoi is None else "area"
        found: Patches = self._memory.get_or_compute(
            "rebuild", f"{counted(n, 'surface')} and the {place}", self._patches_key, self._rebuild,
            lambda p: counted(p.n_patch, "patch"),
        )  # fmt: skip
        self._memory.warn(*warnings_of_moves(self._enclosed, found))
        return found

    @cached_property
    def _walls(self) -> list[TriSurface]:
        return build_walls(self.box, self.aoi)

    @cached_property
    def _enclosed(self) -> tuple[TriSurface, ...]:
        """All that is split: surfaces, fluid contacts and the walls."""
        return (*self.surfaces, *self._fluids[0], *self._walls)

    @cached_property
    def _origin(self) -> np.ndarray:
        return self._frame(self._enclosed)

    @cached_property
    def _patches_key(self) -> Hashable:
        """What patches depend on."""
        surfaces = self._enclosed[: len(self._enclosed) - len(self._walls)]
        ring = None if self.aoi is None else self.aoi.tobytes()
        shape = (self.box, ring, self._origin.tobytes(), self._voxel_size, self._self)
        return ("patches", *(self._memory.key_of(s) for s in surfaces), shape)

    def _rebuild(self) -> Patches:
        surfaces, origin = self._enclosed, self._origin
        options = {"voxel_size": self._voxel_size, "self_intersections": self._self}
        return trim_sheets(patches_from(find_contacts(surfaces, origin=origin, **options)))

    @cached_property
    def units(self) -> Units:
        """Closed units: zone x fault block (x fluid contact)."""
        patches, contacts = self.patches, self._fluids[1]
        subject = "the box" if self.aoi is None else "the area"
        found: Units = self._memory.get_or_compute(
            "carve", subject, self._units_key,
            lambda: carve_units(patches, self.column, contacts), lambda u: counted(len(u), "unit"),
        )  # fmt: skip
        for fault in found.report["outside"]:
            where = "model box" if self.aoi is None else "area of interest"
            words = f"does not reach the {where}, and parts nothing"
            self._memory.note("carve", fault, "skipped", words)
            self._warn_of_outside(fault)
        self._memory.warn(*warnings_of_order(found), *warnings_of_thin_units(found))
        return found

    @cached_property
    def _units_key(self) -> Hashable:
        """What units, and all that is measured of them, depend on."""
        fluids = tuple((one.name, one.block, one.zones) for one in self._fluids[1])
        return ("units", self._patches_key, tuple(self.column.values()), fluids)

    @property
    def volumes(self) -> Any:
        """Volume of each unit, an `xarray.DataArray` with zone and block as coordinates [m3].

        Where fluid contacts are given, ``contact`` is one more.
        """
        return self.units.table["volume"]

    def check(self) -> Certificate:
        """Return the certificate of the model: what was promised, checked anew.

        Returns
        -------
        Certificate
            See `geosurf.carve.certificate.certify`; the last line repeats the rebuild and
            compares bytes.
        """
        repeat = same_bytes(self.patches, self._rebuild())
        return Certificate((*certify(self.patches, self.units).checks, repeat))

    def explain(self, *, seconds: bool = True) -> str:
        """Return what ran, what came from memory, and what was skipped and why.

        Parameters
        ----------
        seconds : bool
            Whether to say how long each step took, and how much memory results take that scenes
            share; without, two runs explain the same.

        Returns
        -------
        str
            One line per step.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.tilted_planes()
        >>> scene = gs.Scene(world.horizons, world.faults, world.box)
        >>> lines = scene.cutoffs("Top", "F1")
        >>> [line.split()[:2] for line in scene.explain(seconds=False).splitlines()]
        [['triangulate', 'Top'], ['triangulate', 'F1'], ['curves', 'Top']]
        """
        seconds = flag_of(seconds, "seconds")
        steps = list(self.steps)
        if seconds and steps:
            steps.append(self._memory.summary())
        width = max((len(step.subject) for step in steps), default=0)
        return "\n".join(step.words(width, seconds) for step in steps)

    @property
    def warnings(self) -> tuple[GeosurfWarning, ...]:
        """What geosurf assumed and you could not know, each with its effect and a remedy.

        Asking prepares all inputs: they are read, faults are extended and truncated, the box is
        chosen. What later stages (units, measures, pictures) warn of is there once they have run.
        Each warning is also issued once by Python's `warnings`; docs/warnings.md lists the kinds.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.tilted_planes()
        >>> gs.Scene(world.horizons, world.faults, world.box).warnings
        ()
        """
        self._prepare()
        order = [*self._horizons, *self._faults]
        rank = {
            name: i for i, name in enumerate(order)
        }  # what is about the whole model comes first
        return tuple(sorted(self._memory.warnings, key=lambda w: (rank.get(w.subject, -1), str(w))))

    @property
    def steps(self) -> tuple[Step, ...]:
        """The lines of `explain`, as data."""
        return tuple(self._memory.steps)

    def __repr__(self) -> str:
        return f"<Scene: horizons {list(self._horizons)}, faults {list(self._faults)}>"
