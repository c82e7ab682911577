"""What depends on what in a scene, on one page.

::

    inputs
      │ read, triangulate              surfaces.py
      ├── horizons ──┐
      └── faults     ├─> box, area     area.py       the outline that horizons share, by default
            │        │       │
            └────────┼───────┴─> faults, extended and truncated            faults.py
                     v                │
                     └─> surfaces <───┘
                           │    │
              curves  <────┘    └─────> enclosed <── fluid contacts, walls of the box
        pair by pair                       │
                                        patches, faults ended at horizons      horizon_ends.py
                                           │
                                         units ──> measures                measures.py

A torn horizon needs the faults that tear it. A pair with a torn horizon, or a fault that a horizon
truncates, takes its curves from the patches. Every result is computed when it is first requested.
`Memory` finds it again by what went into it, also for other scenes that were made by
`Scene.replace`.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Hashable, Mapping, Sequence
from functools import cached_property, partial
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.arrangement import KnownPairs, find_contacts
from geosurf.arrangement.candidates import is_torn
from geosurf.carve import carve_cells, find_cells
from geosurf.carve.cells import Cells
from geosurf.carve.column import reservoir_of
from geosurf.carve.fluids import parts_at_levels
from geosurf.carve.units import warnings_of_order, warnings_of_slivers, warnings_of_thin_units
from geosurf.conventions import check_word, counted, is_number, shared_name
from geosurf.conventions.axes import vertical_axis
from geosurf.errors import GeosurfWarning
from geosurf.faults.distance import lies_beside, warning_of_fault, warnings_of_rims
from geosurf.faults.truncate import past_mains
from geosurf.intersect import curves_of, merge_curves
from geosurf.intersect.link import shared_curves
from geosurf.lazy import xarray
from geosurf.model import Curves, FluidContact, Patches, Sheet, TriSurface, Units, check_column
from geosurf.model.base import in_crs_of
from geosurf.model.column import VirtualWall, fault_of, names_of_zones
from geosurf.model.expected import name_of, outline_of
from geosurf.model.network import Extension, Truncation
from geosurf.model.regions import KnownRegions
from geosurf.model.units import units_in
from geosurf.rebuild import drop_triangles, patches_from, trim_sheets
from geosurf.rebuild.ghosts import warnings_of_moves
from geosurf.scene import area
from geosurf.scene.area import NamedRegions, boxes_meet, coverage_in_words, share_inside
from geosurf.scene.faults import FaultStage, LongerFaults, TearPlans
from geosurf.scene.input_checks import in_time, warn_of_inputs, warnings_of_topology
from geosurf.scene.inputs import Box, SceneInputs
from geosurf.scene.memory import Memory
from geosurf.scene.surfaces import (
    InputSurfaces,
    decimated,
    fluids_of,
    grid_of_sheet,
    horizons_in_map,
    opened_outline,
    opened_tops,
    remembered_tie,
    warnings_of_extrapolation,
)
from geosurf.triangulate import build_walls
from geosurf.triangulate.decimate import bound_of_change

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.faults.rules import Rule
    from geosurf.faults.virtual_walls import Wall
    from geosurf.model.tops import TieReport, Tops
    from geosurf.triangulate.shared_area import SharedArea

# patches, what faults lost by ending at horizons, warnings of that, and virtual walls
Ended = tuple[Patches, tuple[Truncation, ...], tuple[GeosurfWarning, ...], tuple[VirtualWall, ...]]


class Graph:
    """
    The results of one scene, each computed when it is first requested.

    Parameters
    ----------
    inputs : SceneInputs
    memory : Memory
        Of this scene; its results may be shared with other scenes.
    prepared_by : FaultStage, optional
        What has extended and truncated the faults, if they come prepared.

    Attributes
    ----------
    longer : mapping of str to (TriSurface, TriSurface)
        Faults, and how long tears of another scene needed them: tears begin with these.
    plans : mapping of str to TearPlan
        How horizons of another scene were torn, which is tried first.
    still : mapping of str to Sheet
        Horizons that are the same in that scene, as they were torn there.
    converted_from : Graph or None
        Of the model in the other domain: horizons are torn like those there, and a model in depth
        should have the units of the one in time.
    passed : mapping of Rule to str
        Rules of faults that tears have made longer since, and how to lengthen these before.
    known_regions : KnownRegions or None
        Regions that the scene had from which this one was made: names go on.

    Examples
    --------
    >>> from geosurf.synthetic import tilted_planes
    >>> world = tilted_planes()
    >>> graph = Graph(SceneInputs(world.horizons, world.faults, world.box), Memory())
    >>> graph.curves.n_curve, len(graph.units)
    (2, 6)
    """

    def __init__(
        self, inputs: SceneInputs, memory: Memory, prepared_by: FaultStage | None = None
    ) -> None:
        self.inputs, self.memory, self.prepared_by = inputs, memory, prepared_by
        self.longer: LongerFaults = {}
        self.plans: TearPlans = {}
        self.still: Mapping[str, Sheet] = {}
        self.passed: Mapping[Rule, str] = {}
        self.known_regions: KnownRegions | None = None
        self.converted_from: Graph | None = None
        self.zone_rows: list[Any] = []  # how zones from thickness were corrected
        self.made_of: dict[str, tuple[str, ...]] = {}  # horizons of zones: see `data_of_made`
        self._regions: NamedRegions | None = None  # of units, with level contacts or without
        self.read = InputSurfaces(inputs, memory)

    # ---- inputs -> surfaces --------------------------------------------------------------

    def surface(self, name: str) -> TriSurface:
        """Return a horizon or fault as the model has it."""
        name = name_of(name, "surface")
        virtual = fault_of(name) in self.inputs.compartments and name not in self.inputs.names
        ends = name in self.ending_inside or virtual
        return self.patches.surface(name) if ends else self._in_model(name)

    def _in_model(self, name: str) -> TriSurface:
        """Return a horizon or fault with the nodes that the model has, before it is split."""
        few = self._decimated
        return few[name] if name in few else self.whole(name)

    @cached_property
    def _decimated(self) -> dict[str, TriSurface]:
        """Horizons of which the model has every k-th node only, by name."""
        return decimated(self.inputs, self.memory, self.whole)

    def whole(self, name: str) -> TriSurface:
        """Return a horizon or fault before horizons truncate faults: so it is split."""
        # horizons as tied to tops, faults as extended and truncated, with all nodes
        name = name_of(name, "surface")
        if name in self.inputs.horizons:
            return self.tied(name)[0]
        known = self.inputs.names
        check_word(name, known, f"no surface is called {name!r}; there are {', '.join(known)}.")
        return self.faults.surface(name)

    @property
    def faults(self) -> FaultStage:
        """The faults, extended and truncated. Not stored: it refers back to this graph."""
        return FaultStage(
            self.inputs, self.memory, given=self.read.fault,
            limits=self._limits, extent=partial(getattr, self, "extent"),
        )  # fmt: skip

    def _limits(self) -> tuple[Box, np.ndarray | None]:
        """Box and area as they are given; a default box is as wide as the area of the model."""
        return self.given_box, self.aoi if self.inputs.box is None else self.given_area

    @property
    def ruled_faults(self) -> FaultStage:
        """What extends and truncates the faults; tears may have made them longer since."""
        return self.prepared_by or self.faults

    @property
    def surfaces(self) -> tuple[TriSurface, ...]:
        """All horizons, then all faults."""
        return tuple(self.surface(name) for name in self.inputs.names)

    @property
    def wholes(self) -> tuple[TriSurface, ...]:
        """All horizons, then all faults, before horizons truncate faults."""
        return tuple(self.whole(name) for name in self.inputs.names)

    @cached_property
    def ending_inside(self) -> frozenset[str]:
        """Names of the faults that are truncated in the split mesh."""
        return frozenset(rule.fault for rule in (*self.inputs.horizon_rules, *self.passed))

    # ---- box and area --------------------------------------------------------------------

    @cached_property
    def box(self) -> Box:
        """West, east, south, north, bottom, top of the model [m]."""
        if self.inputs.box is None or self.aoi is not None:
            return self._box_around(self.aoi)
        return area.box_off_rims(self.given_box, self._untorn_horizons(), self.memory)

    @cached_property
    def given_box(self) -> Box:
        """The box before its sides are moved off rims: a given box needs no horizon."""
        return self.box if self.inputs.box is None else self._box_around(self.given_area)

    @property
    def extent(self) -> Box:
        """The box that extended faults leave: a given box holds the horizons around the area."""
        return self.box if self.inputs.box is None else self.inputs.box

    @cached_property
    def aoi(self) -> np.ndarray | None:
        """Corners of the area of the model (n, 2), counter-clockwise [m]; None if it is the box."""
        if self.given_area is None or self.inputs.aoi is None:
            return self.given_area
        horizons = self._untorn_horizons()
        return area.outline_off_rims(self.given_area, horizons, "area of interest", self.memory)

    @cached_property
    def given_area(self) -> np.ndarray | None:
        """The area as it is given, or the default one; None if it is an axis-parallel rectangle."""
        # by default the outline that horizons share; None where that is a rectangle along the axes,
        # which the box describes alone
        if self.inputs.aoi is None:
            default = self.default_area
            return None if default is None or default.axis_parallel else default.outline
        if self.inputs.takes_rectangle:
            return None
        self.read.unchanged(("aoi",))
        with self.memory.collecting():
            return opened_outline(self.inputs.aoi)

    @cached_property
    def default_area(self) -> SharedArea | None:
        """What all horizons share, if neither box nor area is given; None for unrotated grids."""
        given = self.inputs.box is not None or self.inputs.aoi is not None
        if given or not self.inputs.horizons:
            return None
        return area.default_area(self._lattices(), self.memory)

    def _box_around(self, outline: np.ndarray | None) -> Box:
        """The given box, or the default one, as wide as an area in it."""
        if outline is None and self.inputs.box is None and self.default_area is not None:
            outline = self.default_area.outline
        horizons = self._untorn_horizons, self._lattices
        west, east, south, north, bottom, top = area.box_around(
            self.inputs.box, outline, *horizons, self.memory
        )
        # horizons end on walls, never on the top or the bottom of the box: throws move them
        reach = 0.0 if self.inputs.box is not None else self._largest_throw()
        return west, east, south, north, bottom - reach, top + reach

    def _largest_throw(self) -> float:
        """How far throws may move a horizon, one upon the other [m]."""
        by_fault: dict[str, float] = {}
        for throw in self.inputs.throws:
            low, high = self.read.fault(throw.fault).extent
            largest = throw.largest(math.dist(low, high))
            by_fault[throw.fault] = max(largest, by_fault.get(throw.fault, 0.0))
        return sum(by_fault.values())

    @cached_property
    def coverage(self) -> dict[str, float]:
        """Share of each input that is inside the model, by name."""
        box, outline = self.box, self.aoi
        shares = {one.name: share_inside(one, box, outline) for one in self.wholes}
        self.memory.note("area", "inside", "ran", coverage_in_words([*shares.items()]))
        return shares

    def _lattices(self) -> list[TriSurface]:
        """All horizons as they lie in the map; torn ones as grids, without gaps at faults."""
        # gaps at faults are not holes of the area
        return horizons_in_map(self.inputs, grid_of_sheet, self.untied)

    def nodes_in_map(self, horizon: str) -> xarray.Dataset | None:
        """Easting and northing of the nodes of a gridded horizon; None for all others."""
        lattice = next((one.lattice for one in self._lattices() if one.name == horizon), None)
        if lattice is None:
            return None
        plane = ("row", "column")
        turned = lattice.easting.ndim == 2
        easting = plane if turned else ("easting",), lattice.easting
        northing = plane if turned else ("northing",), lattice.northing
        return xarray.Dataset(coords={"easting": easting, "northing": northing})

    def _untorn_horizons(self) -> list[TriSurface]:
        """All horizons; torn ones as they were given, which needs no fault that leaves the box."""
        return horizons_in_map(self.inputs, lambda sheet: sheet.surface, self.untied)

    def origin_for(self, surfaces: Sequence[TriSurface]) -> np.ndarray:
        """Return the origin of the local frame: the box's where exact, so that results share it."""
        box = None if self.inputs.box is None else self.given_box
        return area.shared_origin(box, surfaces)

    # ---- well tops -----------------------------------------------------------------------

    @cached_property
    def tops(self) -> Tops | None:
        """Well tops, read from their file; None if the scene has none."""
        self.read.unchanged(("tops",))
        with self.memory.collecting():
            return opened_tops(self.inputs.tops, self.inputs.options)

    def untied(self, name: str) -> TriSurface:
        """A horizon with all its nodes before it is tied to tops.

        Box and area follow from these: a tie needs the faults, and faults may need the box.
        """
        return self.read.horizon(name, self.whole)

    def tied(self, name: str) -> tuple[TriSurface, TieReport | None]:
        """A horizon with all its nodes, tied to its tops if that is requested; and how."""
        # no settings or no tops of this horizon: the surface itself, no copy
        plain, settings = self.untied(name), self.inputs.tie
        if settings is None or self.tops is None or not len(self.tops.of(name)):
            return plain, None

        # all faults that reach it: a correction must not cross any of them
        faults = [self.faults.surface(fault) for fault in self.inputs.faults_at(name)]
        sheet = self.sheets.get(name)
        return remembered_tie(self.memory, name, plain, sheet, faults, self.tops, settings)

    # ---- column and fluid contacts -------------------------------------------------------

    @property
    def reservoir(self) -> tuple[str, ...]:
        """Zones of the reservoir, youngest first."""
        return reservoir_of(names_of_zones(tuple(self.inputs.horizons)), self.inputs.reservoir)

    @property
    def column(self) -> dict[str, str]:
        """The rule of each horizon, youngest first."""
        rules = check_column(tuple(self.inputs.horizons), self.inputs.column)
        return dict(zip(self.inputs.horizons, rules, strict=True))

    @cached_property
    def fluids(self) -> tuple[list[TriSurface], list[FluidContact]]:
        """Surfaces of fluid contacts, and the zones and blocks in which they count."""
        for name in self.inputs.contacts:
            self.read.unchanged(name)
        return fluids_of(self.inputs, self.memory, self.box, self.read.crs)

    # ---- surfaces -> curves --------------------------------------------------------------

    @cached_property
    def curves(self) -> Curves:
        """Curves of all pairs of surfaces, and of each with itself if that was requested."""
        names, alone = self.inputs.names, self.inputs.self_intersections
        surfaces = tuple(map(self._in_model, names))
        inside = [self._ends_inside(name) for name in names]
        plain = tuple(one for one, ends in zip(surfaces, inside, strict=True) if not ends)
        parts = [self._searched(plain, counted(len(plain), "surface"), alone)] if plain else []
        if len(plain) == len(names):
            return in_crs_of(parts[0], surfaces)

        # those of sheets, from the mesh that decides where they end
        parts += [
            shared_curves(self.patches, names[i], names[j])
            for i, j in combinations(range(len(names)), 2)
            if inside[i] or inside[j]
        ]
        return in_crs_of(merge_curves(names, self.origin_for(surfaces), parts), surfaces)

    def curves_between(self, first: str, second: str) -> Curves | None:
        """Return the curves of two surfaces; None where their boxes do not meet."""
        first, second = name_of(first, "surface"), name_of(second, "surface")
        pair = tuple(self._in_model(name) for name in dict.fromkeys((first, second)))
        if self._ends_inside(first) or self._ends_inside(second):
            return shared_curves(self.patches, first, second)
        subject = f"{first} x {second}"
        if not boxes_meet(pair[0].bounds, pair[-1].bounds):
            self.memory.note("curves", subject, "skipped", "boxes do not meet")
            return None
        return self._searched(pair, subject, len(pair) == 1)

    def _searched(self, surfaces: tuple[TriSurface, ...], subject: str, alone: bool) -> Curves:
        """Curves of some surfaces, in one search; `alone`: of each with itself, too."""
        # the key: the surfaces, their frame, and the voxels of the search
        origin, voxels = self.origin_for(surfaces), self.inputs.voxel_size
        key = ("curves", *map(self.memory.key_of, surfaces), origin.tobytes(), voxels, alone)
        return self.memory.get_or_compute(
            "curves", subject, key,
            lambda: curves_of(
                find_contacts(
                    surfaces, self_intersections=alone, origin=origin, voxel_size=voxels
                )
            ),
            lambda curves: counted(curves.n_curve, "curve"),
        )  # fmt: skip

    def _ends_inside(self, name: str) -> bool:
        """Whether the split mesh decides where a surface ends: at its faults, or at horizons."""
        return name in self.ending_inside or is_torn(self.whole(name))

    # ---- surfaces -> patches -------------------------------------------------------------

    @cached_property
    def _virtual(self) -> list[Wall]:
        """Virtual walls of compartments, before they are cut at their targets."""
        if not self.inputs.compartments:
            return []
        from geosurf.scene.horizon_ends import find_virtual_walls  # loaded by those who have some

        faults = list(map(self.whole, self.inputs.faults))
        return find_virtual_walls(self.inputs, self.memory, faults, self.box, self.aoi)

    @property
    def virtual_walls(self) -> tuple[VirtualWall, ...]:
        """Virtual walls as they end in the model."""
        return self._patches_and_ends[3]

    @property
    def patches(self) -> Patches:
        """All surfaces and the walls of the box, split along their curves."""
        return self._patches_and_ends[0]

    @cached_property
    def _patches_and_ends(self) -> Ended:
        """The patches, what faults lost by ending at horizons, and warnings of that."""
        # warnings about inputs come before minutes of computation
        self.prepare()
        n_surface = len(self.enclosed) - len(self._walls)
        place = "box" if self.aoi is None else "area"
        ended: Ended = self.memory.get_or_compute(
            "rebuild", f"{counted(n_surface, 'surface')} and the {place}", self._patches_key,
            lambda: self._rebuilt(self.memory.known_pairs(self.enclosed)),
            lambda ended: "; ".join([counted(ended[0].n_patch, "patch"), *map(str, ended[1])]),
        )  # fmt: skip

        # outside `get_or_compute`: a result from memory warns as a new one does
        self.memory.warn(*warnings_of_moves(self.enclosed, ended[0]), *ended[2])
        return ended

    def rebuild(self) -> Patches:
        """Split all that is enclosed, without memory; a certificate compares it with `patches`."""
        return self._rebuilt()[0]

    def _rebuilt(self, known: KnownPairs | None = None) -> Ended:
        """The same, what faults lost by ending at horizons, warnings of that, virtual walls."""
        contacts = find_contacts(
            self.enclosed, known=known, origin=self._origin, voxel_size=self.inputs.voxel_size,
            self_intersections=self.inputs.self_intersections,
        )  # fmt: skip
        patches, inputs = trim_sheets(patches_from(contacts)), self.inputs
        lost: tuple[Truncation, ...] = ()
        warnings: tuple[GeosurfWarning, ...] = ()
        parts: tuple[VirtualWall, ...] = ()
        if self.passed:
            keep, lost, warnings = past_mains(patches, self.passed)
            patches = patches if keep.all() else drop_triangles(patches, keep)
        if inputs.horizon_rules:
            from geosurf.scene.horizon_ends import end_at_horizons  # loaded by those who have some

            rules = inputs.horizon_rules, self.ruled_faults.rules
            patches, ends, told = end_at_horizons(patches, self.column, *rules)
            lost, warnings = (*lost, *ends), (*warnings, *told)
        if inputs.compartments:
            from geosurf.scene.horizon_ends import end_virtual_walls  # and these, too

            patches, parts, more = end_virtual_walls(patches, self._virtual, inputs.compartments)
            warnings = (*warnings, *more)
        return patches, lost, warnings, parts

    def fault_actions(self) -> tuple[Extension | Truncation, ...]:
        """Return what was done to all faults: extended, truncated by faults, by horizons."""
        ended = self._patches_and_ends[1] if self.ending_inside else ()
        return (*self.ruled_faults.actions(), *ended)

    @cached_property
    def _walls(self) -> list[TriSurface]:
        return build_walls(self.box, self.aoi)

    @cached_property
    def enclosed(self) -> tuple[TriSurface, ...]:
        """All that is split: surfaces, fluid contacts and walls."""
        given = (*map(self._in_model, self.inputs.names), *(wall.surface for wall in self._virtual))
        return (*given, *self.fluids[0], *self._walls)

    @cached_property
    def _origin(self) -> np.ndarray:
        return self.origin_for(self.enclosed)

    @cached_property
    def _patches_key(self) -> Hashable:
        """What patches depend on."""
        # walls follow from box and area, which the key has; surfaces count by their own keys
        surfaces = self.enclosed[: len(self.enclosed) - len(self._walls)]
        ring = None if self.aoi is None else self.aoi.tobytes()
        options = self.inputs.voxel_size, self.inputs.self_intersections
        shape: tuple[Hashable, ...] = (self.box, ring, self._origin.tobytes(), *options)
        shape = (*shape, *self.passed.items())
        if self.inputs.compartments:
            shape = (*shape, str(self.inputs.compartments))
        if self.inputs.horizon_rules:  # sides of horizons follow the column
            names = (*self.inputs.names, *self.column.values())
            shape = (*shape, self.inputs.horizon_rules, names, self.ruled_faults.rules)
        return ("patches", *(self.memory.key_of(s) for s in surfaces), shape)

    # ---- patches -> units ----------------------------------------------------------------

    @cached_property
    def units(self) -> Units:
        """Closed units: zone x fault block (x fluid contact), in regions."""
        units = self._carved
        self._regions, with_regions = self.memory.stored_for(
            units, ("regions", self.regions_key), lambda: self._in_regions(units)
        )
        return with_regions

    def _in_regions(self, units: Units) -> tuple[NamedRegions, Units]:
        """What finds the regions of units, and the units that ask it."""
        regions = NamedRegions(self.patches, units, self.inputs.regions, self.known_regions)
        return regions, units_in(units, regions, self.inputs.time)

    @cached_property
    def regions_key(self) -> Hashable:
        """What the names of regions depend on, beside the units."""
        return self.memory.hold(self.inputs.regions), self.known_regions

    @property
    def found_regions(self) -> KnownRegions | None:
        """Regions that users have seen, of this scene or of the one that it was made from."""
        if self._regions is None or not self._regions.found_already:
            return self.known_regions
        return self._regions.known_as(self.units_key)

    @cached_property
    def _carved(self) -> Units:
        """All units, without regions."""
        patches, contacts = self.patches, self.fluids[1]
        with vertical_axis(self.inputs.time):
            units = self.memory.get_or_compute(
                "carve", "the box" if self.aoi is None else "the area", self.units_key,
                lambda: carve_cells(
                    self._cells, patches, self.column, contacts, self.inputs.slivers,
                    self.reservoir,
                ),
                lambda u: "; ".join(filter(None, [counted(len(u), "unit"), u.merged_in_words])),
            )  # fmt: skip

        # faults that bound no unit are named: their names may be missing in blocks
        where = "model box" if self.aoi is None else "area of interest"
        for fault in units.report["outside"]:
            words = f"does not reach the {where}, and parts nothing"
            self.memory.note("carve", fault, "skipped", words)
            self._warn_of_outside(fault)
        zones = {
            horizon: (zone, start)
            for zone, start, horizon, *_ in self.zone_rows
            if len(self.made_of.get(horizon, ())) == 1  # fitted zones have two
        }
        with vertical_axis(self.inputs.time):
            found = *warnings_of_order(units, zones), *warnings_of_thin_units(units)
            self.memory.warn(*found, *warnings_of_slivers(units))
        if self.converted_from is not None and self.inputs.time is None:
            self.memory.warn(
                *warnings_of_topology(
                    self.converted_from.units,
                    units,
                    self.reservoir,
                    [
                        name not in self.converted_from.inputs.horizons
                        for name in self.inputs.horizons
                    ],
                )
            )
        return units

    def _cells(self) -> Cells:
        """Cells of the patches: names, rules and contacts do not change them."""
        key = "cells", self._patches_key
        return self.memory.stored_for(self.patches, key, lambda: find_cells(self.patches))

    @property
    def measured_units(self) -> Units:
        """Units for labels and volumes: parts at level contacts, where these will do."""
        found = self.units_at_levels
        return self.units if found is None else found

    @property
    def units_at_levels(self) -> Units | None:
        """Labels and volumes of all units of a scene with level contacts, without cutting it.

        The model without contacts is the same for all contacts, and comes from memory once a scene
        of the family has built it. A moved contact then passes over the units that it cuts, and
        nothing else. None where only the arrangement with contacts has them.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.tilted_planes(n=9)
        >>> scene = gs.Scene(world.horizons, world.faults, world.box, contacts={"OWC": -2000.0})
        >>> _ = scene.volumes
        >>> deeper = scene.replace(contacts={"OWC": -2010.0})
        >>> found = deeper.volumes
        >>> [step.stage for step in deeper.steps if step.outcome == "ran"]
        ['contacts']
        """
        inputs = self.inputs
        if not inputs.contacts or inputs.compartments or inputs.slivers.merge:
            return None
        surfaces, contacts = self.fluids
        named = [("contact", surface.name) for surface in surfaces]
        named += [("input", name) for name in inputs.names]
        if not all(is_number(contact.at) for contact in contacts) or shared_name(named):
            return None

        # the same inputs without contacts, read once
        without = copy.copy(inputs)
        without.__dict__["contacts"] = {}
        base = Graph(without, self.memory, self.prepared_by)
        base.read, base.known_regions, base.passed = self.read, self.known_regions, self.passed
        for place in ("box", "aoi", "given_area", "default_area"):  # no contact changes these
            base.__dict__[place] = getattr(self, place)
        units, patches = base.units, base.patches
        if units.report["thin"]:
            return None
        self._regions = base._regions
        fluids = tuple(
            (contact.name, contact.block, contact.zones, float(contact.at)) for contact in contacts
        )
        parts_of_units: Units | None = self.memory.get_or_compute(
            "contacts", ", ".join(surface.name for surface in surfaces),
            ("level parts", base.units_key, base.regions_key, fluids),
            lambda: parts_at_levels(patches, units, contacts),
            lambda parts: (
                "cut with the surfaces" if parts is None else counted(len(parts), "unit")
            ),
        )  # fmt: skip
        return parts_of_units

    @cached_property
    def units_key(self) -> Hashable:
        """What units, and all that is measured of them, depend on."""
        # surfaces of contacts are in the key of the patches; names and places are not
        fluids = tuple((one.name, one.block, one.zones) for one in self.fluids[1])
        rules = tuple(self.column.values())
        return ("units", self._patches_key, rules, fluids, self.inputs.slivers, self.reservoir)

    def volume_error_bound(self) -> float:
        """Return by how much volumes may differ from those of all nodes: see `Scene`."""
        horizons = self.inputs.horizons
        if any(isinstance(surface, Sheet) and surface.fewer_nodes for surface in horizons.values()):
            return math.inf
        few = [
            surface
            for surface in map(self.surface, horizons)
            if "volume_error" in surface.vertex_data
        ]
        names = {surface.name for surface in few}
        others = (
            [surface for surface in self.enclosed if surface.name not in names] + few if few else []
        )
        bounds = (
            bound_of_change(
                surface, [other for other in others if other is not surface], self.box[:4]
            )
            for surface in few
        )
        return sum(bounds, 0.0)

    # ---- checks and warnings -------------------------------------------------------------

    def prepare(self) -> None:
        """Read all inputs, check them against each other, and warn of what looks wrong."""
        _ = self.wholes, self.fluids
        for name in self.inputs.faults:
            if lies_beside(self.whole(name), self.box):
                self._warn_of_outside(name)
        for one in warnings_of_rims(map(self.whole, self.inputs.faults), self.box, self.aoi):
            self.memory.warn(in_time(one, self.inputs.time))
        horizons = [self.surface(name) for name in self.inputs.horizons]
        outline = outline_of(self.box, self.aoi)
        warn_of_inputs(self.inputs, self.memory, self.read, horizons, self.tops, outline)
        for horizon in self._lattices():
            if getattr(self.inputs.horizons[horizon.name], "mesh", None) is not None:
                continue  # it is pinched out: its sheet warns of that
            self.memory.warn(*warnings_of_extrapolation(horizon))

    @property
    def sheets(self) -> dict[str, Sheet]:
        """Horizons that are torn at their faults, by name."""
        horizons = self.inputs.horizons.items()
        return {name: one for name, one in horizons if isinstance(one, Sheet)}

    def _warn_of_outside(self, name: str) -> None:
        """Warn of a fault that does not reach the model."""
        found = warning_of_fault(self.whole(name), self.box, self.aoi)
        self.memory.warn(in_time(found, self.inputs.time))

    def warnings(self) -> tuple[GeosurfWarning, ...]:
        """Return all warnings so far: first of the whole model, then by surface."""
        # in the order of the inputs, whatever ran first; those of the whole model lead
        rank = {name: i for i, name in enumerate(self.inputs.names)}
        found = [*self.memory.warnings, *(self._regions.warnings if self._regions else ())]
        return tuple(sorted(found, key=lambda one: (rank.get(one.subject, -1), str(one))))
