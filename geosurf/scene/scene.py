"""`Scene`: what users build and ask. All work is done in `Graph` and in functions of it."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Hashable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from geosurf import measure
from geosurf.arrangement import search_voxels
from geosurf.carve.certificate import certify_repeated
from geosurf.conventions import HORIZON_DIMS, check_word, counted, is_number, is_word
from geosurf.conventions.axes import need_depth, vertical_axis
from geosurf.conventions.running import running
from geosurf.errors import GeosurfWarning, InputError
from geosurf.lazy import xarray
from geosurf.measure.locate import boundaries_of, locator_of
from geosurf.measure.places import intervals_of_wells, well_intervals, wells_of
from geosurf.measure.regions import region_labels
from geosurf.measure.section import check_line
from geosurf.measure.thickness import horizon_on_grid
from geosurf.measure.volumetrics import fluids_in_place
from geosurf.model import Certificate, FluidContact, Patches, Sheet, TriSurface, Units
from geosurf.model.base import multiblock, need_pyvista
from geosurf.model.column import VirtualWall
from geosurf.model.expected import flag_of, name_of
from geosurf.model.network import Extension, FaultNetwork, Truncation
from geosurf.model.patches import Curves, VoxelSearch
from geosurf.model.protocols import View3D
from geosurf.model.regions import Regions
from geosurf.model.tops import TieReport, Tops, doubtful_top
from geosurf.model.units import sums_of
from geosurf.rebuild import trim_sheets
from geosurf.scene.depth import convert_points, in_milliseconds, inputs_in_time
from geosurf.scene.faults import closures_of, known_fault, seal_of, throw_of
from geosurf.scene.graph import Graph
from geosurf.scene.input_checks import (
    check_system_of_places,
    refuse_other_systems,
    warnings_of_places,
)
from geosurf.scene.inputs import (
    Box,
    SceneInputs,
    factors_of_rock,
    or_empty,
    paths_of,
    refuse_assignment,
)
from geosurf.scene.memory import Memory, OnStart, Step, on_start_of
from geosurf.scene.shown import InteractiveView, card_of, show
from geosurf.scene.surfaces import opened_tops, warnings_of_names
from geosurf.scene.tearing import torn_or_plain
from geosurf.scene.zones import corrections, plain_graph
from geosurf.sheets.faults import DIRECTIONS

if TYPE_CHECKING:  # pragma: no cover - types only
    import pyvista

    from geosurf.measure.locate import Boundaries, Locator
    from geosurf.scene.plots import ScenePlots

Labelled = TypeVar("Labelled", "xarray.DataArray", "xarray.Dataset")


class Scene:
    """
    Horizons and faults in a model box: a small graph of stages with memory.

    Nothing is computed until it is requested, and nothing twice: results are found
    by what went into them. Asking for the curves of one pair reads and intersects that pair only.
    A scene never changes: `replace` gives another one, with some inputs changed.

    Parameters
    ----------
    horizons : mapping of str to horizon
        Youngest first. A horizon is an `xarray.DataArray`, a `TriSurface`, (vertices, triangles),
        a `Sheet`, or a path. Coordinates of an array are easting and northing by their name (or
        ``x`` and ``y``), ``standard_name``, ``long_name`` or ``axis``. Arrays in a store (Dask,
        Zarr, NetCDF) are read into memory; what does not fit needs `tolerance` or `aoi`.
    faults : mapping of str to fault, optional
        A fault is an `xarray.Dataset`, `FaultSticks` or a list of sticks (arrays (n, 3)), a
        `TriSurface`, (vertices, triangles), or a path.
    box : (west, east, south, north, bottom, top), optional
        The model box [m]. Default: the outline that all horizons share (see `aoi`), with a
        margin above and below; it moves with them, so give a box to compare scenes.
    column : mapping of str to str, optional
        Which of two crossing horizons ends at the other: ``"erosional"`` removes what lies below,
        ``"base"`` what lies above, ``"discontinuous"`` both; a ``"yielding"`` one ends at all
        others. The default is ``"conformable"``: of two that cross, the older one ends on the
        younger. ``units.report["clipped"]`` lists all.
    contacts : mapping of str to contact, optional
        Fluid contacts from the top down, which split the reservoir: ``{"OWC": -1705.0}``, also by
        block and zone; see `build_contacts` and `FluidContact`. A path is a gridded horizon.
    aoi : array_like of float, shape (n, 2), path, or "rectangle", optional
        Area of interest: easting and northing around a polygon, which the model then fills.
        Default, without a box: the outline that all horizons share, rotated and not convex as it
        may be. ``"rectangle"``: the largest axis-parallel rectangle inside it.
    positive : {"up", "down"}, optional
        Whether inputs hold elevations or depths, for those that do not declare it.
    length_unit : str, optional
        Length unit of elevations (or depths), for inputs that do not declare theirs. Easting and
        northing are metres, unless an input declares another unit for them.
    voxel_size : float, optional
        Edge of the search voxels [m]. Changes the cost, never the result.
    self_intersections : bool
        Whether surfaces are also split where they cross themselves.
    extend : bool, sequence of str, or mapping of str to sides, optional
        Faults that are continued until they leave the model box (the given box, where `aoi` is
        smaller): all, some, or some of their sides (``"strike"``, ``"start"``, ``"end"``,
        ``"up"``, ``"down"``).
    lengthen : float, or mapping of str to distance, optional
        Faults that are first continued by a distance [m]: all, or some by name, each on all sides
        or on some: ``{"F1": 50, "F2": {"down": 80, "strike": 200}}``.
    tear : bool, "auto", float, or mapping, optional
        True tears all horizons at every fault, which are extended and truncated first. Horizons may
        then be points, too. A number is the trim in cells, a mapping has it by fault; or it sets
        some of ``{"trim": 3, "noise": 2.0, "keep_outliers": True, "horizons": ["Top"]}``: see
        `tear_horizon`. `sheets` has cut-offs and reports; `warnings` lists remedies.
    fill_empty_blocks : bool, {"lower", "upper", "pinch out"}, or mapping of str to these, optional
        What becomes of torn horizons in blocks without data; by default an error names the block.
        True continues them from the neighbouring block. ``"lower"`` pinches them out onto the
        horizon below, as ``"pinch out"`` does, ``"upper"`` onto the one above: the zone between is
        absent there.
    truncations : mapping of str to (main, keep[, extend]), optional
        Faults that end at others, ``{"F2": ("F1", "hanging wall")}``, or at horizons:
        ``("Unconformity", "below")`` keeps what lies below. A third word True first continues F2 to
        F1, or up or down to the horizon. ``("F1", "both")`` keeps both parts of an older fault, as
        faults ``F2 (1)`` and ``F2 (2)``. See docs/guides/fault_ends.md.
    tolerance : float, optional
        [m]. The model has only every k-th node of large horizons, which are nowhere farther than
        this from all of their nodes, vertically; `volume_error_bound` states the effect.
        See docs/how_it_works/tolerance.md.
    tops : xarray.Dataset, table or path, optional
        Well tops, as from `read_tops`: `misfit` compares them with the horizons.
    slivers : float, "merge" or mapping, optional
        Units below this volume [m3] are slivers, which tables and legends list apart. Default:
        units below 1/10 000 of their zone. ``"merge"`` merges each into the neighbour with the
        largest shared area; ``{"min_volume": 5000.0, "merge": True}`` does both.
    tie : bool or mapping, optional
        True corrects each horizon smoothly so that it meets its tops, within 1000 m of a well and
        on its side of every fault, to 0.1 m; ``{"range": 500.0, "tolerance": 0.05}`` sets both [m].

    compartments : bool, sequence of str, or mapping of str to target, optional
        Faults that die inside the model and separate regions all the same: a virtual wall continues
        each by the shortest join that separates, and above and below it. True joins all faults to
        another one or to the boundary of the model;
        ``{"F3": "boundary", "F4": "F1", "F5": {"end": True}}``
        names targets, also by end. No horizon is offset there. `virtual_walls` lists them; see
        docs/guides/compartments.md.
    crs : str, optional
        Coordinate reference system, such as ``"EPSG:23031"``, of all inputs that declare none.
        Inputs that declare another are refused.
    reservoir : sequence of str, optional
        Zones of the reservoir, as in ``["Top/Middle"]``: fluid contacts that name no zones split
        these, and `volumes`, tables and pictures show these; `units` has all. Default: the zones
        between the first and the last horizon. With fewer than two horizons nothing lies between,
        and all zones count.
    regions : mapping of str to place, polygon or sides of faults, optional
        Names of parts of the field that run through all zones: ``{"North": (461000.0, 5934000.0),
        "Terrace": polygon, "Block": ("F1+", "F2-")}``. A place names the region that it lies in; a
        polygon (corners or a file, as for `aoi`) all regions with most of their horizon area
        inside; sides of faults those on them. Others have letters, the largest A: see `regions`.
    time : {"two-way", "one-way"}, optional
        Horizons and faults are in time: in ms or s (`length_unit`, or as they declare), numbers
        without a unit in minus ms. Without `velocity` the model is in time: its vertical axis is
        in minus ms, and volumes are refused.
    zones : mapping of str to mapping, optional
        Zones from thickness, which make horizons: ``{"Upper": {"below": "Top", "thickness": 20.0,
        "base": "Middle"}}``; a thickness may be a map or values at wells. See docs/guides/zones.md.
    throws : mapping of str to throw, optional
        Horizons that are still continuous are torn by the throw of faults, the youngest first:
        ``{"F1": 60.0}``, or for some horizons, and with the words of `throw_horizon`,
        ``{"F1": {"throw": 60.0, "horizons": ["Top"], "reach": 900.0}}``. The default box is taller
        by the throws.
    velocity : float, map or mapping, optional
        [m/s]. The model becomes one in depth; box, contacts and tops are in metres. By zone a
        number, a map (`xarray.DataArray` or path) or ``{"v0": 1800.0, "k": 0.6}``, v0 + k times
        the depth below the datum; by horizon the average velocity to it; ``"wells"`` for
        checkshots or ``"tops"``, for those of the scene, ``"elsewhere"`` for all other zones,
        ``"datum"`` for the elevation at time zero. One value alone counts for all zones. See
        docs/guides/time_and_depth.md.
    on_start : callable, optional
        Is called before each step: stage, subject, its number, and how many there are, as in
        ``("tear", "Top", 2, 4)``. Scenes made by `replace` call it, too; copies do not. Default:
        terminals and notebooks show what has been running for two seconds (`show_progress`).

    Raises
    ------
    InputError
        If an input is missing, has an unknown type, or its name is used twice; if the box or the
        tolerance cannot be used, or a torn horizon meets a tolerance. Later, when results are
        requested: inputs that cannot be read, or are in different coordinate reference systems.

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

    _inputs: SceneInputs
    _given: Graph

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
        tops: Any = None,
        tie: Any = None,
        lengthen: Any = None,
        tear: Any = None,
        slivers: Any = None,
        fill_empty_blocks: Any = None,
        compartments: Any = None,
        crs: str | None = None,
        reservoir: Sequence[str] | None = None,
        regions: Mapping[str, Any] | None = None,
        time: str | None = None,
        velocity: Any = None,
        zones: Mapping[str, Any] | None = None,
        throws: Any = None,
        on_start: OnStart | None = None,
    ) -> None:
        inputs = SceneInputs(
            horizons, or_empty(faults), box, or_empty(column), or_empty(contacts), aoi, positive,
            length_unit, voxel_size, self_intersections, extend, or_empty(truncations), tolerance,
            tops, tie, lengthen, tear, slivers,
            fill_empty_blocks, compartments, crs, reservoir, or_empty(regions), time, velocity,
            or_empty(zones), throws,
        )  # fmt: skip
        memory = Memory(on_start=on_start_of(on_start))
        self.__dict__.update(_inputs=inputs, _given=Graph(inputs.to_build, memory))

    @cached_property
    def _plain(self) -> Graph:
        """The inputs, horizons not yet torn; in depth, where they are in time and become depth."""
        return plain_graph(self._given, lambda: self._in_time, self._inputs)

    @cached_property
    def _in_time(self) -> Graph:
        """The model in time, of a scene that becomes depth."""
        return torn_or_plain(self._given)

    @cached_property
    def _graph(self) -> Graph:
        """The results; with `tear` of horizons that are torn when something is first requested."""
        return torn_or_plain(self._plain)

    def replace(self, **changes: Any) -> Scene:
        """Return a new scene with some inputs changed, which shares all results still valid.

        Parameters
        ----------
        **changes
            Inputs of `Scene`, by name. `horizons` and ``faults`` are exchanged or added one by one;
            None as a value removes one, and with a fault its own extension and truncations. New
            horizons come last, as the oldest. All other inputs replace the previous ones.

        Returns
        -------
        Scene

        Raises
        ------
        InputError
            For an unknown input, the name of something to remove that does not exist, or a value
            that `Scene` refuses.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.tilted_planes()
        >>> scene = gs.Scene(world.horizons, world.faults, world.box)
        >>> scene.replace(faults={"F1": None}).fault_names
        ()
        """
        inputs, twin = self._inputs.replaced(**changes), object.__new__(Scene)
        plain = Graph(inputs.to_build, self._given.memory.twin())
        plain.read.take_over(self._given.read, changes)
        known = vars(self).get("_graph", self._given).found_regions
        if known is not None and "regions" in changes:  # new names; letters stay
            known = dataclasses.replace(known, labels=tuple((one, one) for _, one in known.labels))
        plain.known_regions = known
        if inputs.time is None:  # the data of one in time, converted
            plain.converted_from = self._given.converted_from
        twin.__dict__.update(_inputs=inputs, _given=plain)
        return twin

    def __setattr__(self, name: str, value: Any) -> None:
        """Refuse: results would stay those of the previous inputs."""
        refuse_assignment(name)

    def __delattr__(self, name: str) -> None:
        """Refuse: results would stay those of the previous inputs."""
        refuse_assignment(name)

    def __repr__(self) -> str:
        return f"<Scene: horizons {list(self.horizon_names)}, faults {list(self.fault_names)}>"

    def _repr_html_(self) -> str:
        """Return inputs, what is computed already, and warnings; nothing is computed for it."""
        return card_of(self)

    # ---- inputs --------------------------------------------------------------------------

    @property
    def horizon_names(self) -> tuple[str, ...]:
        """Names of the horizons, youngest first."""
        return tuple(self._inputs.horizons)

    @property
    def fault_names(self) -> tuple[str, ...]:
        """Names of the faults."""
        return tuple(self._inputs.faults)

    @property
    def zone_corrections(self) -> xarray.Dataset:
        """Zones from thickness: mean thickness as given and in the model, and how they were fitted.

        Over ``zone``: ``start``, ``horizon``, ``given``, ``model`` [m], ``least_factor`` and
        ``largest_factor``, by which thickness was multiplied between two given horizons.
        """
        return corrections(self._plain.zone_rows)

    @property
    def truncations(self) -> Mapping[str, Any]:
        """Faults that end at others, as they were given; read-only.

        Of a scenario that tears its horizons, those that made its faults ready, as `extend` and
        `lengthen` are: the scene itself takes its faults as they are.
        """
        return MappingProxyType(self._plain.ruled_faults.truncations)

    @property
    def extend(self) -> Mapping[str, tuple[str, ...]]:
        """Faults that are continued, and on which sides; read-only."""
        return MappingProxyType(self._plain.ruled_faults.extend)

    @property
    def lengthen(self) -> Mapping[str, Mapping[str, float]]:
        """Faults that are continued by a distance, on which sides, and how far [m]; read-only."""
        return MappingProxyType(self._plain.ruled_faults.distances)

    @property
    def tolerance(self) -> float | None:
        """The largest error of curves and of horizons in the model [m]; None: all is exact."""
        return self._inputs.tolerance

    @property
    def virtual_walls(self) -> tuple[VirtualWall, ...]:
        """Virtual walls of `compartments`: what each end of a fault is joined to, how far."""
        return self._graph.virtual_walls

    @property
    def sheets(self) -> dict[str, Sheet]:
        """Horizons that are torn at their faults, by name, each with its cut-offs and report."""
        return self._graph.sheets

    @property
    def column(self) -> dict[str, str]:
        """The rule of each horizon, youngest first."""
        return self._graph.column

    @property
    def reservoir(self) -> tuple[str, ...]:
        """Names of the zones of the reservoir, youngest first."""
        return self._graph.reservoir

    @property
    def box(self) -> Box:
        """West, east, south, north, bottom, top of the model [m]."""
        return self._graph.box

    @property
    def aoi(self) -> np.ndarray | None:
        """Corners of the area of the model (n, 2), counter-clockwise [m]; None if it is the box."""
        return self._graph.aoi

    # ---- time and depth ------------------------------------------------------------------

    def in_time(self, time: str | None = None) -> Scene:
        """Return the model in time: its vertical axis is in minus milliseconds.

        Parameters
        ----------
        time : {"two-way", "one-way"}, optional
            Of a scene whose inputs are in depth; others have stated it.

        Returns
        -------
        Scene
            Without fluid contacts and tops, which are in depth. It shares results with this one.

        Raises
        ------
        InputError
            If the scene has no velocity, or `time` is not stated.
        """
        made = inputs_in_time(self._inputs, lambda: (self._plain, self._graph), time)
        if made is self._inputs:
            return self
        twin = object.__new__(Scene)
        twin.__dict__.update(_inputs=made, _given=Graph(made, self._given.memory.twin()))
        twin._given.converted_from = self._graph if self._inputs.time is None else None
        return twin

    def to_depth(self, points: Any) -> np.ndarray:
        """Return points in depth that are given in time, in the columns of the model.

        Parameters
        ----------
        points : array_like of float, shape (n, 3)
            Easting, northing and minus milliseconds.

        Returns
        -------
        ndarray of float64, shape (n, 3)
            Easting, northing and elevation [m].

        Raises
        ------
        InputError
            If the scene has no velocity, or was not given in time. If all places lie above the
            datum, or the velocity gives no finite depth.

        Warns
        -----
        GeosurfWarning
            If places lie outside of the horizons, where the velocity of the first zone counts.
        """
        return convert_points(self._inputs, lambda: self._in_time, points, True)

    def to_time(self, points: Any) -> np.ndarray:
        """Return points in time that are given in depth: the inverse of `to_depth`.

        Parameters
        ----------
        points : array_like of float, shape (n, 3)
            Easting, northing and elevation [m].

        Returns
        -------
        ndarray of float64, shape (n, 3)
            Easting, northing and minus milliseconds.

        Raises
        ------
        InputError
            As for `to_depth`.
        """
        return convert_points(self._inputs, lambda: self._in_time, points, False)

    @property
    def time(self) -> str | None:
        """How times count, ``"two-way"`` or ``"one-way"``; None of a model in depth."""
        return None if self._inputs.becomes_depth else self._inputs.time

    # ---- surfaces ------------------------------------------------------------------------

    def surface(self, name: str) -> TriSurface:
        """Return one horizon or fault by name, as the model has it; reads only what it needs.

        Parameters
        ----------
        name : str
            Of a horizon or a fault.

        Returns
        -------
        TriSurface
            Faults are extended and truncated. A fault that a horizon truncates is taken from
            `patches`. With a tolerance, horizons may have every k-th node only, and their largest
            error in ``vertex_data["vertical_error"]`` [m].

        Raises
        ------
        InputError
            For an unknown name.
        """
        return self._graph.surface(name)

    def whole_surface(self, name: str) -> TriSurface:
        """Return one horizon or fault by name with all nodes, before horizons truncate faults.

        Parameters
        ----------
        name : str
            Of a horizon or a fault.

        Returns
        -------
        TriSurface
            As `surface`, but with the part of a fault beyond the horizon that it ends at: this is
            what is split, and what tears other horizons.

        Raises
        ------
        InputError
            For an unknown name.
        """
        return self._graph.whole(name)

    def prepared_fault(self, name: str) -> TriSurface:
        """Return one fault, extended and truncated, before tears make it longer.

        Parameters
        ----------
        name : str
            Of a fault.

        Returns
        -------
        TriSurface
            As `whole_surface`, but where a torn horizon needed a longer fault. No horizon is torn
            for it.

        Raises
        ------
        InputError
            For an unknown name.
        """
        return self._plain.ruled_faults.surface(known_fault(name, self.fault_names))

    @property
    def given_sheets(self) -> Mapping[str, Sheet]:
        """Horizons that were given torn, by name: the faults at which they end cannot change."""
        return MappingProxyType(self._plain.sheets)

    @property
    def surfaces(self) -> tuple[TriSurface, ...]:
        """All horizons, then all faults, triangulated."""
        return self._graph.surfaces

    @property
    def contacts(self) -> tuple[FluidContact, ...]:
        """Fluid contacts, from the top down, each with its name, zones and block."""
        return tuple(self._graph.fluids[1])

    @property
    def tops(self) -> Tops | None:
        """Well tops of the scene, checked: wells, horizons and points; None without."""
        return self._plain.tops

    @property
    def ties(self) -> dict[str, TieReport]:
        """What tying horizons to their well tops did, by name: tops in use, misfit, change."""
        found = {name: self._graph.tied(name)[1] for name in self.horizon_names}
        return {name: report for name, report in found.items() if report is not None}

    @property
    def fault_actions(self) -> tuple[Extension | Truncation, ...]:
        """What was done to the faults: every extension and truncation, with its size."""
        return self._graph.fault_actions()

    def propose_fault_network(self, *, reach: float | None = None) -> FaultNetwork:
        """Return every contact, near miss and dangling end of the faults, with proposals.

        Parameters
        ----------
        reach : float, optional
            Largest distance of a near miss [m]; see `propose_network`.

        Returns
        -------
        FaultNetwork
            Prints as a table; its method `apply` gives the scene with the proposals.

        Notes
        -----
        Proposals are for the faults as `prepared_fault` returns them, so `tear` changes none, and
        no horizon is torn for them.
        """
        return self._plain.ruled_faults.propose(reach)

    # ---- curves, patches, units ----------------------------------------------------------

    @property
    def curves(self) -> Curves:
        """Curves of all pairs of surfaces.

        With `self_intersections` also of each surface with itself, but not of torn sheets.
        """
        return self._graph.curves

    def curves_between(self, first: str, second: str) -> Curves | None:
        """Return the curves of two surfaces; None where their boxes do not meet.

        Parameters
        ----------
        first, second : str
            Names of two surfaces. One name twice: the curves along which it crosses itself.

        Returns
        -------
        Curves or None

        Raises
        ------
        InputError
            For an unknown name.
        """
        return self._graph.curves_between(first, second)

    def search(self, first: str, second: str) -> VoxelSearch | None:
        """Return what the voxel search found for two surfaces, as reports draw it.

        Parameters
        ----------
        first, second : str
            Names of two surfaces.

        Returns
        -------
        VoxelSearch
            None where their boxes do not meet.
        """
        return search_voxels(self.surface(first), self.surface(second), self._inputs.voxel_size)

    @property
    def patches(self) -> Patches:
        """All surfaces and the walls of the box, split along their curves."""
        return self._graph.patches

    @property
    def units(self) -> Units:
        """Closed units: zone x fault block (x fluid contact)."""
        return self._graph.units

    @property
    def regions(self) -> Regions:
        """Regions by name: parts of the field that run through all zones, the largest first.

        Blocks of different zones belong together where they share the largest horizon area; each
        zone has one block in a region. Regions below 1/1000 of the reservoir are remnants: they
        become parts of what they share most horizon area with, or else of what they touch most.
        Names are those of `Scene`, or letters. A scene made by `replace` keeps the names that this
        one has shown, by the largest volume on the same sides of faults.

        Raises
        ------
        InputError
            If a name stands for no region, or two names for one; or for an unknown side of a fault.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.graben(n=9)
        >>> scene = gs.Scene(world.horizons, world.faults, world.box)
        >>> list(scene.regions), scene.regions["A"].blocks
        (['A', 'B', 'C'], (('Top/Middle', 'F1+ F2+'), ('Middle/Base', 'F1+ F2+')))
        >>> scene.replace(regions={"West": ("F1-",)}).units["Top/Middle F1-"].region
        'West'
        """
        return self._graph.measured_units.regions

    def region_labels(self, horizon: str) -> dict[str, np.ndarray]:
        """Return a place for the name of each region on a horizon, far from its rim.

        Parameters
        ----------
        horizon : str

        Returns
        -------
        dict of str to ndarray of float64, shape (1, 3)
            Easting, northing and elevation [m], by name; as `PictureOverlay` takes labels.

        Raises
        ------
        InputError
            For an unknown horizon.
        """
        return region_labels(self.patches, self.units, horizon)

    @property
    def volumes(self) -> xarray.DataArray:
        """Gross rock volume (GRV) of each unit of the reservoir [m3].

        By zone and block, and contact where there are some. ``units.volumes`` has all units. Two
        scenes are compared by ``one.to_series().sub(other.to_series(), fill_value=0.0)``:
        ``one - other`` leaves out units that only one of them has.
        """
        need_depth(self.time, "volumes")
        return self._graph.measured_units.included().volumes

    def table(
        self, include: str = "reservoir", by: str | Sequence[str] | None = None
    ) -> xarray.Dataset:
        """Return volumes and areas of units by zone, block, region and contact, or sums of volumes.

        Parameters
        ----------
        include : {"reservoir", "all"}
            ``"all"``: also over- and underburden, which close the model; ``reservoir`` marks units.
        by : str or sequence of str, optional
            ``"region"``, ``"zone"``, ``"block"`` and ``"contact"``: volumes are summed up by these.

        Returns
        -------
        xarray.Dataset
            As `Units.table`: ``volume`` is the gross rock volume (GRV) [m3]. With `by` only the
            volume, along these names; 0 where there is no unit.

        Raises
        ------
        InputError
            For another word.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.tilted_planes()
        >>> scene = gs.Scene(world.horizons, world.faults, world.box)
        >>> scene.table().unit.values.tolist(), scene.table(include="all").sizes["unit"]
        (['Top/Base F1+', 'Top/Base F1-'], 6)
        >>> dict(scene.table(by=("region", "zone")).sizes)
        {'region': 2, 'zone': 1}
        """
        need_depth(self.time, "tables of volumes")
        units = self.units.included(include)
        return units.table if by is None else sums_of(units, by)

    @property
    def volume_error_bound(self) -> float:
        """By how much the volume of units, one or several, may differ from that of all nodes [m3].

        Of horizons of which `tolerance`, or ``triangulate_horizon(..., tolerance=)``, has left out
        nodes; 0 if there are none. With `tolerance`, what a horizon gains cancels what it loses in
        each part of the map that no other surface divides. It holds where both models have the
        same units. Infinite if a horizon was torn from data whose nodes a tolerance has left out.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.waves(n=301)
        >>> exact = gs.Scene(world.horizons, world.faults, world.box)
        >>> few = {name: gs.triangulate_horizon(world.horizons[name], tolerance=5.0)
        ...        for name in world.horizons}
        >>> scene = exact.replace(horizons=few)
        >>> off = abs(scene.volumes - exact.volumes).max().item()
        >>> 0.0 < off <= scene.volume_error_bound, exact.volume_error_bound
        (True, 0.0)
        """
        return self._graph.volume_error_bound()

    @property
    def faults_inside(self) -> tuple[str, ...]:
        """Names of the faults that reach into the model."""
        return self._inside("fault")

    @property
    def coverage(self) -> dict[str, float]:
        """Share of each input that is inside the model: horizons in the map, faults on their area.

        From 0 to 1, to within about 0.01. Nothing is cut for it.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.tilted_planes()
        >>> scene = gs.Scene(world.horizons, world.faults, (0, 2000, 0, 3000, -2500, -1500))
        >>> {name: round(share, 1) for name, share in scene.coverage.items()}
        {'Top': 0.5, 'Base': 0.5, 'F1': 0.4}
        """
        return self._graph.coverage

    @property
    def crs(self) -> str | None:
        """Coordinate reference system of the scene: of its inputs, or as given; None if unknown.

        Results and files carry it. Inputs in two systems are refused; `gs.reproject` converts.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.tilted_planes()
        >>> scene = gs.Scene(world.horizons, world.faults, world.box, crs="EPSG:23031")
        >>> scene.crs, scene.volumes.attrs["crs"]
        ('EPSG:23031', 'EPSG:23031')
        """
        inputs = self._plain.inputs
        if inputs.crs is not None:
            return inputs.crs
        found = (self._plain.whole(name).crs for name in inputs.names)
        return next((one for one in found if one is not None), None)

    @property
    def input_files(self) -> dict[str, Path]:
        """Horizons, faults, contacts, well tops and area that were given as paths, by name."""
        return paths_of(self._inputs)

    @property
    def horizons_inside(self) -> tuple[str, ...]:
        """Names of the horizons that reach into the model, youngest first."""
        return self._inside("horizon")

    def _inside(self, role: str) -> tuple[str, ...]:
        """Names of surfaces of a role that bound units, in the order of the scene."""
        inside, sources = self.units.rows_inside, self.patches.sources
        found = (source for i, source in enumerate(sources) if i in inside)
        return tuple(source.name for source in found if source.role == role)

    def to_pyvista(self) -> pyvista.MultiBlock:
        """Return horizons, faults, curves and units as named blocks of `pyvista`.

        Returns
        -------
        pyvista.MultiBlock
            ``"horizons"``, ``"faults"`` and ``"units"`` hold a block for each name; ``"curves"`` is
            one block. Surfaces are split where they meet, and end at the model.
        """
        need_pyvista()  # before the model is built
        surfaces = {
            role: multiblock({name: self.patches.surface(name).to_pyvista() for name in names})
            for role, names in (("horizons", self.horizon_names), ("faults", self.fault_names))
        }
        curves, units = self.curves.to_pyvista(), self.units.to_pyvista()
        return multiblock({**surfaces, "curves": curves, "units": units})

    # ---- measures ------------------------------------------------------------------------

    def _measured(self, what: str, run: Callable[[], Labelled], *more: Hashable) -> Labelled:
        """Return a measure of the units, from memory if it is there."""
        # a measure is found by its model and what was asked for
        measure = self._graph.memory.get_or_compute(
            "measure", what, ("measure", what, self._graph.units_key, *more), run,
            lambda made: ", ".join(counted(n, str(dim)) for dim, n in made.sizes.items()),
        )  # fmt: skip
        if self.time is not None:
            measure = in_milliseconds(measure)

        # declared on a copy: the memory may hold results of a model that differs in this word alone
        crs = self.units.crs
        return measure if crs is None else measure.assign_attrs(crs=crs)

    def _of_units(self, what: str, run: Callable[..., xarray.Dataset], name: str) -> xarray.Dataset:
        """Return a measure of patches and units for the name of a surface."""
        return self._measured(f"{what} {name}", lambda: run(self.patches, self.units, name))

    @property
    def _locator(self) -> Locator:
        """What finds the unit at a point, from memory if it is there."""
        return self._graph.memory.get_or_compute(
            "measure", "units by place", ("locator", self._graph.units_key),
            lambda: locator_of(self.units),
            lambda found: counted(len(found.listed.corners), "triangle"),
        )  # fmt: skip

    @property
    def _boundaries(self) -> Boundaries:
        """All triangles that bound units, from memory if they are there."""
        return self._graph.memory.get_or_compute(
            "measure", "boundaries of units", ("boundaries", self._graph.units_key),
            lambda: boundaries_of(self.patches, self.units),
            lambda found: counted(len(found.triangles), "triangle"),
        )  # fmt: skip

    def thickness(
        self, zone: str, grid: Any = None, *, kind: str = "isochore", contact: str | None = None
    ) -> xarray.DataArray:
        """Return a thickness map of a zone, block by block [m].

        Parameters
        ----------
        zone : str
            ``"Top/Base"``, ``"above Top"`` ...
        grid : None, float or xarray object
            Where: None for the middles of 100 cells along the longer side of the box; a number for
            cells about as wide [m]; anything with coordinates ``northing`` and ``easting``.
        kind : {"isochore", "isopach"}
            Vertical thickness, or that normal to bedding by the local dip.
        contact : str, optional
            One interval between fluid contacts, ``"above OWC"``; default: all together.

        Returns
        -------
        xarray.DataArray
            (block, northing, easting); NaN where a block has none of the zone.

        Raises
        ------
        InputError
            For an unknown zone, kind or contact interval, or a grid without both coordinates.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.graben(n=9)
        >>> scene = gs.Scene(world.horizons, world.faults, world.box)
        >>> thickness = scene.thickness("Top/Middle", 250.0)
        >>> thickness.sum("block").round(9).values.tolist()[0][:3]
        [70.0, 70.0, 70.0]
        """
        if is_word(kind, ("isopach",)):
            need_depth(self.time, "thickness normal to bedding")
        if contact is not None:
            contact = name_of(contact, "contact interval")

        # a cell size counts by its text
        nodes = repr(grid)
        if hasattr(grid, "coords"):  # of a map, only these count; and they may be changed in place
            axes = [grid.coords[name] for name in HORIZON_DIMS if name in grid.coords]
            nodes = self._graph.memory.hold(axes)
        words: dict[str, Any] = {"kind": kind, "contact": contact, "horizons": self.horizon_names}
        return self._measured(
            f"{kind} {zone}", lambda: measure.thickness_map(self.units, zone, grid, **words),
            nodes, contact,
        )  # fmt: skip

    def horizon_grid(self, horizon: str, grid: Any = None) -> xarray.DataArray:
        """Return a horizon of the model as a grid, which ``gs.write`` writes as one.

        Parameters
        ----------
        horizon : str
        grid : float or xarray object, optional
            The width of a cell [m], or anything with coordinates ``northing`` and ``easting`` [m],
            such as the grid of another horizon. Default: the nodes of the horizon as it was given;
            for points and meshes 100 cells along the longer side of the box.

        Returns
        -------
        xarray.DataArray
            Elevation [m, positive up] at the nodes; NaN in fault gaps and outside the model, the
            upper elevation where the horizon is doubled. ``attrs["lost"]`` states what a grid
            cannot have at the faults.

        Raises
        ------
        InputError
            For an unknown horizon, or a grid that has no coordinates.

        Warns
        -----
        GeosurfWarning
            Of what is lost at faults: kind ``"grid"``.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.tilted_planes()
        >>> scene = gs.Scene(world.horizons, world.faults, world.box)
        >>> scene.horizon_grid("Top", 500.0).shape
        (6, 8)
        """
        need_depth(self.time, "grids of horizons")
        if grid is None:
            grid = self._graph.nodes_in_map(horizon)
        on_grid, lost = horizon_on_grid(self.patches, self.units, horizon, grid)
        self._graph.memory.warn(*filter(None, [lost]))
        crs = self.units.crs
        return on_grid if crs is None else on_grid.assign_attrs(crs=crs)

    def sample(
        self, where: Any = None, *, cell: Any = None, codes: bool = False, distance: bool = False
    ) -> xarray.Dataset:
        """Return the zone, block, contact interval and unit at each of some places.

        Parameters
        ----------
        where : array_like, table or xarray object, optional
            World coordinates [m]: an array ``(..., 3)`` of easting, northing and elevation; a table
            with these columns; an xarray object with these coordinates, which may be the axes of a
            grid; or a map of elevations.
        cell : (dx, dy, dz), optional
            Instead: the middles of the cells of a regular grid that fills the model box, of about
            this size [m].
        codes : bool
            Whether to return whole numbers, which have their names in ``attrs``, not names.
        distance : bool
            Whether to add the distance to the nearest boundary of a unit [m].

        Returns
        -------
        xarray.Dataset
            ``unit``, ``zone``, ``block``, and ``contact`` where there are fluid contacts. Outside
            the model names are empty, and codes are -1. A point on a surface belongs to the unit
            below it, on a vertical surface to that on the side of the middle of the model.

        Raises
        ------
        InputError
            For places that are not numbers, not finite, or not three coordinates each.

        Warns
        -----
        GeosurfWarning
            If all points lie above the model: depths may have been given for elevations.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.tilted_planes()
        >>> scene = gs.Scene(world.horizons, world.faults, world.box)
        >>> scene.sample([1000.0, 1500.0, -2100.0]).unit.item()
        'Top/Base F1-'
        >>> dict(scene.sample(cell=(100, 100, 10), codes=True).sizes)
        {'elevation': 80, 'northing': 30, 'easting': 40}
        """
        if where is not None:
            check_system_of_places(lambda: self.crs, where, "places")
        boundaries = self._boundaries if flag_of(distance, "distance") else None
        samples = measure.sample_units(
            self.units, where, cell=cell, codes=codes, locator=self._locator, boundaries=boundaries
        )
        with vertical_axis(self.time):
            self._graph.memory.warn(*warnings_of_places(samples, self.box[5]))
        return samples

    def well_intervals(self, path: Any, *, md: Any = None) -> xarray.Dataset:
        """Return the units that wells go through, with entry and exit points.

        Parameters
        ----------
        path : array_like, table or xarray object
            Points along the well, in order: easting, northing and elevation [m], as for `sample`. A
            column ``md`` of a table is the measured depth. Many wells: a mapping such as ``{"W-1":
            path}``, or a table with a column ``well``.
        md : array_like of float, shape (n,), optional
            Measured depth of each point of one well [m]. Default: that column, else the length of
            the path; unknown (NaN) where this begins below sea level.

        Returns
        -------
        xarray.Dataset
            Along ``interval``: ``unit``, ``zone``, ``block``, and ``contact`` where there are fluid
            contacts, empty outside the model; ``md``, ``easting``, ``northing`` and ``elevation``
            at both ends of each. Of many wells also ``well``. ``gs.write(table, "wells.csv")``
            writes one row for each interval.

        Raises
        ------
        InputError
            For a path of fewer than two different points, a measured depth that falls, wells
            without names, or `md` with many wells.

        Warns
        -----
        GeosurfWarning
            If all points lie above the model, as for `sample`.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.tilted_planes()
        >>> scene = gs.Scene(world.horizons, world.faults, world.box)
        >>> well = scene.well_intervals([[1000, 1500, -1750], [1400, 1500, -2200]])
        >>> well.zone.values.tolist()
        ['above Top', 'Top/Base', 'below Base']
        >>> well.elevation.sel(end="entry").round(1).values.tolist()
        [-1750.0, -2067.7, -2165.6]
        >>> wells = {
        ...     "W-1": [[900, 1500, -1750], [900, 1500, -1760]],
        ...     "W-2": [[1000, 1500, -1750], [1400, 1500, -2200]],
        ... }
        >>> scene.well_intervals(wells).well.values.tolist()
        ['W-1', 'W-2', 'W-2', 'W-2']
        """
        wells, boundaries = wells_of(path), self._boundaries
        if wells is not None and md is not None:
            raise InputError("md= is for one well. Give many wells as tables with a column 'md'.")
        for name, well in {"path": path}.items() if wells is None else wells.items():
            check_system_of_places(lambda: self.crs, well, name)
        if wells is None:
            intervals = well_intervals(self.units, path, md, self._locator, boundaries)
        else:
            intervals = intervals_of_wells(self.units, wells, self._locator, boundaries)
        with vertical_axis(self.time):
            self._graph.memory.warn(*warnings_of_places(intervals, self.box[5]))
        return intervals

    def closures(
        self, horizon: str | None = None, *, faults: Any = "sealing", horizons: Any = "open",
        min_height: float = 5.0, vshale: Any = None,
    ) -> xarray.Dataset:  # fmt: skip
        """Return the closures of the reservoir: crest, spill point, height, area and volume.

        Parameters
        ----------
        horizon : str, optional
            A horizon with a zone of the reservoir directly below; default: all of these.
        faults : {"sealing", "open", "juxtaposition"} or mapping of str to these
            ``"sealing"``: no fault leaks. ``"open"``: a closure ends at its highest point on a
            fault. ``"juxtaposition"``: a fault holds where reservoir faces other rock, and is
            passed where reservoir faces reservoir. ``{"sgr": 0.2}``: there, too, it holds where
            its shale gouge ratio is at least 0.2. By fault: ``{"F1": {"sgr": 0.2}, "elsewhere":
            "juxtaposition"}``; ``"elsewhere"`` is ``"sealing"`` by default.
        horizons : {"open", "sealing"} or mapping of str to these
            What holds where the horizon ends on another one, by erosion, onlap or pinch-out. By
            name: ``{"Unconformity": "sealing"}``. What lies beneath a sealing one is part of the
            closure.
        min_height : float
            Lower closures are left out [m].
        vshale : number or mapping, optional
            Shale of the zones, as for `seal`: needed by faults that hold by their ratio.

        Returns
        -------
        xarray.Dataset
            Along ``closure``: ``horizon``, ``block``, ``crest_easting`` ..., ``spill_easting`` ...,
            ``height`` and ``area`` (in the map). ``volume`` is the rock between horizon and spill
            level, of the zones of the reservoir that follow each other below the horizon.
            ``spill_kind`` is ``"saddle"`` (to another closure), ``"edge"`` (of the model),
            ``"horizon"`` (the horizon ends on another one, ``spill_at``), ``"fault"`` (``spill_at``
            leaks) or ``"none"`` (nothing spills: faults close off the block). ``spills_into`` is
            the closure on the way up from the spill point. Closures that meet there are
            ``part_of`` one that is closed farther down. Along ``leak``: the highest point of each
            closure at which each fault leaks. Along ``line``, point after point: the ``outline`` of
            each closure, and the ``path`` of what spills.

        Raises
        ------
        InputError
            For an unknown horizon, or one with no reservoir directly below; for an unknown fault
            or rule; for a height that is no number.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.noisy()
        >>> scene = gs.Scene(world.horizons, world.faults, world.box)
        >>> found = scene.closures("Top", faults="open", min_height=3.0)
        >>> found.closure.values.tolist(), found.spill_kind.values.tolist()
        (['Top 1', 'Top 2'], ['saddle', 'saddle'])
        >>> round(float(found.crest_elevation[0] - found.height[0] - found.spill_elevation[0]), 9)
        0.0
        """
        need_depth(self.time, "closures")
        return closures_of(self, horizon, faults, horizons, min_height, vshale)

    def volumetrics(
        self, *, net_to_gross: Any = None, porosity: Any = None, water_saturation: Any = None,
        formation_volume_factor: Any = None, fluids: Any = None, units: str = "metric",
        include: str = "reservoir",
    ) -> xarray.Dataset:  # fmt: skip
        """Return rock and fluids in place of each unit: GRV to STOIIP and GIIP.

        Each of the first four arguments is a number, a map, or a mapping of these by zone, region,
        contact interval, fluid, or several of them: ``{"Top/Middle": 0.25, ("Top/Middle", "gas"):
        0.23, "elsewhere": 0.2}``. The entry with most names counts. Each needs those before it;
        columns that need one left out are left out.

        Parameters
        ----------
        net_to_gross, porosity, water_saturation : number, map or mapping
            Fractions, from 0 to 1. A map is an `xarray.DataArray` as of a horizon, or a path, and
            is bilinear between its nodes.
        formation_volume_factor : number, map or mapping
            Volume in the reservoir over volume at surface conditions, of oil (such as 1.3) or gas
            (0.005). Of a map the reciprocal is bilinear.
        fluids : {"oil", "gas", "water"} or mapping to these, optional
            What units hold. Contacts named OWC, GOC and GWC state it; a mapping, as in ``{"above
            FWL": "oil"}``, counts before them, and one word in the reservoir where no contact
            states it.
        units : {"metric", "field"}
            Metric: m3, and Sm3 at surface conditions. Field: acre-ft of rock, bbl of pores, stb,
            scf. Standard conditions are those of the formation volume factor.
        include : {"reservoir", "all"}
            ``"all"``: also over- and underburden. Columns are NaN there from the first that lacks
            a value or a fluid.

        Returns
        -------
        xarray.Dataset
            Along ``unit``, with labels as in `table` and ``fluid``: ``bulk`` (GRV), ``net``,
            ``pore``, ``hydrocarbon_pore``, ``stoiip`` (oil) and ``giip`` (free gas). Water holds
            none. Sums over units are those of the reservoir. Maps are integrated over the unit
            itself: exact but for rounding.

        Raises
        ------
        InputError
            For an unknown or ambiguous name, a value out of range, a unit of the reservoir without
            a value or fluid, or a map that does not cover a unit, with place and area.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.tilted_planes()
        >>> scene = gs.Scene(world.horizons, world.faults, world.box, contacts={"OWC": -2100.0})
        >>> found = scene.volumetrics(
        ...     net_to_gross=0.8, porosity={"oil": 0.25, "water": 0.2}, water_saturation=0.3,
        ...     formation_volume_factor=1.25,
        ... )
        >>> oil = found.groupby("fluid").sum().sel(fluid="oil")
        >>> round((oil.stoiip / oil.bulk).item(), 12), found.stoiip.attrs["units"]
        (0.112, 'Sm3')
        """
        need_depth(self.time, "volumetrics")
        values = net_to_gross, porosity, water_saturation, formation_volume_factor
        factors, words = factors_of_rock(values, self.crs), (fluids, units, include)
        given = (value for factor in factors for value in factor.entries.values())
        if all(map(is_number, given)):  # volumes will do: nothing is cut
            return fluids_in_place(self._graph.measured_units, factors, *words)
        run = lambda: fluids_in_place(self.units, factors, *words)  # noqa: E731
        key = self._graph.memory.hold((values, fluids))
        more = key, units, include, self._graph.regions_key
        return self._measured("volumetrics", run, *more)

    def juxtaposition(self, fault: str, include: str = "reservoir") -> xarray.Dataset:
        """Return the areas of pairs of units that face each other across a fault [m2].

        Parameters
        ----------
        fault : str
        include : {"reservoir", "all"}
            Pairs with the reservoir on one side at least, or all: areas of these add up to the
            fault inside the model.

        Returns
        -------
        xarray.Dataset
            ``area`` over ``pair``; see ``geosurf.measure.juxtaposition_table``.

        Raises
        ------
        InputError
            For an unknown fault, or another word.
        """
        need_depth(self.time, "areas of juxtaposition")
        inside = {unit.zone for unit in self.units.included(include).values()}
        found = self._of_units("juxtaposition", measure.juxtaposition_table, fault)
        zones = zip(found.zone_plus.values, found.zone_minus.values, strict=True)
        return found.isel(pair=[k for k, pair in enumerate(zones) if inside.intersection(pair)])

    def allan(self, fault: str) -> xarray.Dataset:
        """Return the Allan diagram of a fault: zones, cut-offs and contacts of both walls, on it.

        Parameters
        ----------
        fault : str

        Returns
        -------
        xarray.Dataset
            Lines with ``along_strike`` and ``elevation`` [m]; see
            ``geosurf.measure.allan_diagram``.

        Raises
        ------
        InputError
            For an unknown fault.
        GeometryError
            For a fault that is flat on average, and so has no strike.
        """
        return self._of_units("allan", measure.allan_diagram, fault)

    def seal(
        self, fault: str, *, vshale: Any, shale: float = 0.4,
        density_contrast: float | None = None, seabed: float = 0.0,
        classes: Sequence[float] = (0.15, 0.2, 0.4),
    ) -> xarray.Dataset:  # fmt: skip
        """Return what a fault holds: shale gouge ratio, smear, threshold pressure, column height.

        Parameters
        ----------
        fault : str
        vshale : number or mapping
            Shale or clay of the zones, fractions: ``{"Top/Base": 0.2, "elsewhere": 0.7}``. Zones
            without an entry take the mean of wells: ``{"wells": table}`` with the columns
            ``well``, ``md``, ``easting``, ``northing``, ``elevation`` and ``vshale``.
        shale : float
            Zones with this Vshale, or more, are source beds of smear, and no reservoir.
        density_contrast : float, optional
            Density of water less that of hydrocarbon [kg/m3]; without it no column heights.
        seabed : float
            Elevation from which burial depth counts [m].
        classes : sequence of float
            Bounds between the classes of ``class_area``.

        Returns
        -------
        xarray.Dataset
            As `juxtaposition` of all units, a polygon of the Allan diagram a ``pair``: also
            ``juxtaposition`` (reservoir on reservoir ...), ``mean_sgr``, ``min_sgr``, ``max_sgr``,
            ``mean_throw``, ``min_csp``, ``min_threshold_pressure``, ``min_column_height``,
            ``lowest_contact`` (which the weakest place still holds), and ``class_area`` over (pair,
            sgr_class). At corners of triangles: ``sgr``, ``sgr_plus``, ``sgr_minus``, ``throw``,
            ``csp`` ...

        Raises
        ------
        InputError
            For an unknown fault or zone, a zone at the fault without Vshale, or another number.

        Notes
        -----
        SGR = sum(Vshale * dz) / throw, over the rock between the layers that face each other
        (Yielding et al. 1997), by the rock of either wall; ``sgr`` is the mean of both. Values at
        corners are exact. Between them ``sgr`` is linear within 0.001, but on
        ``attrs["coarse_area"]`` [m2], where throw ends or layers pinch out; where zones are
        parallel, it is linear, and areas by class are exact.
        CSP = sum(thickness² / distance) over the source beds that slipped past (Bouvier et al.
        1989), both vertical, from the nearer end of the smear. Threshold pressure [bar] =
        10^(100 SGR / 27 - C), C = 0.5, 0.25 and 0 for burial depths below 3000 m, to 3500 m and
        above (Bretan et al. 2003). Column height = pressure / (density contrast * g).

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.torn("normal", n=41)
        >>> scene = gs.Scene(world.horizons, world.faults, tear=True)
        >>> found = scene.seal("F1", vshale={"below Top": 0.1, "elsewhere": 0.8})
        >>> bool((abs(found.sgr - 0.45) < 0.351).all())
        True
        """
        need_depth(self.time, "fault seal")
        return seal_of(self, fault, vshale, shale, density_contrast, seabed, classes)

    def section(self, line: Any) -> xarray.Dataset:
        """Return a vertical section of the model along a line in the map.

        Parameters
        ----------
        line : array_like of float, shape (n, 2)
            Easting and northing [m]: two points or more, from the left to the right.

        Returns
        -------
        xarray.Dataset
            Rings of units and lines of surfaces, with ``along_section`` and ``elevation`` [m]; see
            ``geosurf.measure.vertical_section``.

        Raises
        ------
        InputError
            If the line has fewer than two points, or two equal ones in a row.
        """
        # checked and turned into an array first, so that lists and arrays have one key
        corners = check_line(line)
        run = lambda: measure.vertical_section(self.patches, self.units, corners)  # noqa: E731
        return self._measured("section", run, corners.tobytes(), self._graph.regions_key)

    def cutoffs(self, horizon: str, fault: str, side: str | None = None) -> list[np.ndarray]:
        """Return the lines where a horizon meets a fault, or those on one wall of it.

        Parameters
        ----------
        horizon, fault : str
        side : {"+", "-", "hanging wall", "footwall"}, optional
            One wall, as in the model: only where the zone next to the fault changes there. By
            default the two surfaces alone are asked, and no model is built.

        Returns
        -------
        list of ndarray, each (n, 3)
            World coordinates [m], in order along the line.

        Raises
        ------
        InputError
            For an unknown horizon, fault or side.
        """
        for role, known, name in (
            ("horizon", self.horizon_names, horizon),
            ("fault", self.fault_names, fault),
        ):
            check_word(name, known, f"no {role} is called {name!r}; there are {list(known)}.")
        if side is None:  # of the two surfaces alone: no model is built
            found = self.curves_between(horizon, fault)
            return [] if found is None else [found.points[curve] for curve in found.curves]
        sign = measure.side_of_words(side)
        return measure.wall_lines(self.patches, self.units, horizon, fault, sign)

    def fault_polygons(self, horizon: str) -> xarray.Dataset:
        """Return the fault polygons of a horizon: rings of hanging-wall and footwall cut-offs.

        Parameters
        ----------
        horizon : str

        Returns
        -------
        xarray.Dataset
            Rings with the fault's name; see ``geosurf.measure.fault_polygons``.

        Raises
        ------
        InputError
            For an unknown horizon.
        """
        return self._of_units("fault polygons", measure.fault_polygons, horizon)

    def throw(self, horizon: str, fault: str, *, direction: str = "local") -> xarray.Dataset:
        """Return throw, heave and dip separation of a horizon along a fault.

        Parameters
        ----------
        horizon, fault : str
        direction : {"local", "mean"}
            Whether cut-offs are compared down the local dip of the fault, as `throw_horizon` moves
            walls, or everywhere across its mean strike. Equal on a fault that is straight in map.

        Returns
        -------
        xarray.Dataset
            Over ``point`` with ``along_strike``; see ``geosurf.measure.separation``.

        Raises
        ------
        InputError
            For another direction, or an unknown horizon or fault.
        GeometryError
            If a fault is flat on average, or turns back against its mean dip direction between its
            cut-offs (``"local"`` only), or a cut-off turns back along the strike.
        """
        if not is_word(direction, DIRECTIONS):
            raise InputError(f"direction is {direction!r}, expected one of {DIRECTIONS}.")
        horizon, fault = name_of(horizon, "horizon"), name_of(fault, "fault")
        run = lambda: throw_of(self, horizon, fault, direction)  # noqa: E731
        return self._measured(f"throw {horizon} x {fault}", run, horizon, fault, direction)

    def throw_audit(self) -> xarray.Dataset:
        """Return the throw of torn horizons beside what the data on both sides of faults show.

        Returns
        -------
        xarray.Dataset
            Over ``horizon`` and ``fault``; see ``geosurf.measure.throw_audit``. Values along a
            fault: ``scene.sheets["Top"].report.throw["F1"]``, a `ThrowAudit`.

        Raises
        ------
        InputError
            If no horizon is torn from its data.
        """
        return measure.throw_audit(self.sheets)

    def orientation(self, name: str) -> xarray.Dataset:
        """Return area, dip and azimuth of a horizon or fault, as a whole and by triangle.

        Parameters
        ----------
        name : str
            Of a horizon or a fault.

        Returns
        -------
        xarray.Dataset
            See ``geosurf.measure.orientation``.

        Raises
        ------
        InputError
            For an unknown name.
        """
        need_depth(self.time, "dip and area")
        return self._of_units("orientation", measure.orientation, name)

    def misfit(self, tops: Any = None) -> xarray.Dataset:
        """Return well tops compared with the horizons of the model, for each horizon and well.

        Parameters
        ----------
        tops : xarray.Dataset, table or path, optional
            As from `read_tops`. Default: the tops of the scene.

        Returns
        -------
        xarray.Dataset
            Over ``top``: ``picked``, ``model``, ``misfit`` (model minus picked) [m], ``block``,
            ``status``, ``fault``; see ``geosurf.measure.well_misfit``.

        Raises
        ------
        InputError
            If there are no tops, or they lack a column.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.graben(n=9)
        >>> scene = gs.Scene(world.horizons, world.faults, world.box)
        >>> tops = dict(well=["W1", "W2"], horizon=["Top", "Base"])
        >>> tops |= dict(easting=[800.0, 900.0], northing=[700.0, 9e9], elevation=[-1000.0] * 2)
        >>> scene.misfit(tops).status.values.tolist()
        ['found', 'outside']
        """
        need_depth(self.time, "misfits of well tops")
        memory, inputs = self._graph.memory, self._graph.inputs
        checked = self.tops
        if tops is not None:
            with memory.collecting():
                checked = opened_tops(tops, inputs.options)
        if checked is None:
            raise InputError(
                "the scene has no well tops. Give them: scene.misfit(geosurf.read_tops(path)), or "
                "Scene(..., tops=...)."
            )
        refuse_other_systems(self._graph.read.crs, inputs.crs, checked, None)
        memory.warn(*warnings_of_names(checked, self.horizon_names))
        run = lambda: measure.well_misfit(self.patches, self.units, checked)  # noqa: E731
        misfits: xarray.Dataset = self._measured(
            "misfit", run, checked.wells, checked.horizons, checked.points.tobytes()
        )
        doubt = doubtful_top(checked, np.arange(len(checked)), misfits.model.values)
        memory.warn(*filter(None, [doubt]))
        return misfits

    # ---- views and pictures --------------------------------------------------------------

    @property
    def plot(self) -> ScenePlots:
        """Pictures: maps, sections, diagrams and views, as figures or files.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.tilted_planes(n=5)
        >>> scene = gs.Scene(world.horizons, world.faults, world.box)
        >>> scene.plot.section([(0, 1500), (4000, 1500)], size=(640, 400)).axes[1].get_xlabel()
        'Distance along the section [km]'
        """
        from geosurf.scene.plots import ScenePlots

        return ScenePlots(self)

    def show(self, what: str = "units", max_triangle: int = 120_000) -> InteractiveView:
        """
        Return an interactive view: notebooks draw it, ``save("view.html")`` writes it.

        Parameters
        ----------
        what : {"units", "surfaces"}
            The sealed units, or horizons and faults as they are read, extended and torn.
        max_triangle : int
            About how many triangles all units have, or each gridded surface; blocks of grid cells
            are merged to get there.

        Returns
        -------
        InteractiveView

        Raises
        ------
        InputError
            For another word, or if `max_triangle` is not a number above 0.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.tilted_planes(n=5)
        >>> gs.Scene(world.horizons, world.faults, world.box).show()  # doctest: +ELLIPSIS
        <InteractiveView of '6 units', ... MB: save('view.html') writes it>
        """
        if not isinstance(what, str) or what not in ("units", "surfaces"):
            raise InputError(f"what is {what!r}; show 'units' or 'surfaces'.")
        if what == "units":
            return show(self, max_triangle=max_triangle)
        # a torn horizon ends on its faults where it is split along them, and not before
        split = trim_sheets(self.patches) if self.sheets else self
        names = (*self.horizon_names, *self.fault_names)
        return show(*(split.surface(name) for name in names), max_triangle=max_triangle)

    def view_3d(self) -> View3D:
        """Return what an interactive view of the units shows, as the report draws it."""
        from geosurf.render.interactive import view_of_units

        return view_of_units(self.units)

    def render_pictures(
        self,
        folder: str | os.PathLike[str],
        *,
        on_file: Callable[[str], object] | None = None,
        **choice: Any,
    ) -> dict[str, Path]:
        """Draw the pictures of the scene; a report shows them.

        Parameters
        ----------
        folder : path-like
            Files go into its folder ``pictures``.
        on_file : callable, optional
            Is called with the name of each file, when it is written.
        **choice
            Selects the pictures and their style; see ``geosurf.scene.pictures.PictureChoice``.

        Returns
        -------
        dict of str to pathlib.Path
            Captions and files. A picture that cannot be drawn is missing; `warnings` names it, with
            the reason.

        Raises
        ------
        InputError
            For an unknown choice.
        OutputError
            If the folder cannot be created.
        """
        from geosurf.scene.pictures import render_pictures

        with running("pictures"), self._graph.memory.collecting():
            return render_pictures(self, folder, on_file, choice)

    # ---- what was done -------------------------------------------------------------------

    @running("certificate")
    def check(self) -> Certificate:
        """Return the certificate of the model.

        Returns
        -------
        Certificate
            One line per promise, see ``geosurf.carve.certificate``. The last line repeats
            the rebuild and compares all bytes.
        """
        return self._take_certificate(
            certify_repeated(self.patches, self.units, self._graph.rebuild)
        )

    def _take_certificate(self, certificate: Certificate) -> Certificate:
        """Keep the certificate of this model."""
        self.__dict__["_checked"] = certificate
        return certificate

    @property
    def certificate(self) -> Certificate:
        """The certificate of the last `check`; without one, the check is run."""
        found: Certificate | None = self.__dict__.get("_checked")
        return self.check() if found is None else found

    def explain(self, *, seconds: bool = True) -> str:
        """Return what ran, what came from memory, and what was skipped and why.

        Parameters
        ----------
        seconds : bool
            Whether to add the run time of each step, and how much memory shared results take;
            without, two runs explain the same.

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
        return self._given.memory.explain(seconds)

    @property
    def steps(self) -> tuple[Step, ...]:
        """The lines of `explain`, as data."""
        return tuple(self._given.memory.steps)

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
        self._graph.prepare()
        return self._graph.warnings()
