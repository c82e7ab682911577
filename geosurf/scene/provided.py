"""What a scene was given, as its stages take it: surfaces, the network of faults, box, column."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from geosurf.carve.column import names_of_zones
from geosurf.carve.fluids import check_zones
from geosurf.conventions import did_you_mean
from geosurf.conventions.crs import refuse_other_crs, warn_of_unclear_crs
from geosurf.errors import InputError
from geosurf.faults.outside import lies_beside, warning_of_fault
from geosurf.model import FluidContact, Sheet, TriSurface, check_column
from geosurf.model.expected import name_of
from geosurf.model.faults import Extension, FaultNetwork, Truncation
from geosurf.scene.curves import Joined
from geosurf.scene.faults import FaultStage
from geosurf.scene.inputs import (
    as_surface,
    box_in_words,
    opened_contacts,
    opened_outline,
    shared_origin,
)
from geosurf.triangulate import build_contacts, build_walls
from geosurf.triangulate.box import propose_box
from geosurf.triangulate.cover import warning_of_area
from geosurf.triangulate.rims import off_the_rims

Box = tuple[float, float, float, float, float, float]


class Provided(Joined):
    """What `geosurf.Scene` can be asked about its inputs."""

    _box: Box | None
    _aoi: Any
    _column: dict[str, str]
    _contacts: dict[str, Any]
    _positive: str | None
    _length_unit: str | None
    _network: FaultStage
    _read: dict[str, str]
    _crs: dict[str, str]

    @property
    def horizon_names(self) -> tuple[str, ...]:
        """Names of the horizons, youngest first."""
        return tuple(self._horizons)

    @property
    def fault_names(self) -> tuple[str, ...]:
        """Names of the faults."""
        return tuple(self._faults)

    def surface(self, name: str) -> TriSurface:
        """Return one surface by name, as the model has it; only what it depends on is read.

        Parameters
        ----------
        name : str
            Of a horizon or a fault.

        Returns
        -------
        TriSurface
        """
        plain = self._plain(name)
        return self._simplified(name, plain) if name in self._horizons else plain

    def _plain(self, name: str) -> TriSurface:
        """A surface with all its nodes."""
        name = name_of(name, "surface")
        if name in self._horizons:
            return self._triangulated(name, "horizon", self._horizons[name])
        if name in self._faults:
            return self._network.surface(name)
        known = [*self._horizons, *self._faults]
        raise InputError(
            f"no surface is called {name!r}; there are {known}.{did_you_mean(name, known)}"
        )

    def _given_fault(self, name: str) -> TriSurface:
        return self._triangulated(name, "fault", self._faults[name])

    @property
    def fault_actions(self) -> tuple[Extension | Truncation, ...]:
        """What was done to the faults: every extension and truncation, with its size."""
        return self._network.actions()

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
        """
        return self._network.propose(reach)

    @property
    def surfaces(self) -> tuple[TriSurface, ...]:
        """All horizons, then all faults, triangulated."""
        return tuple(self.surface(name) for name in (*self._horizons, *self._faults))

    @cached_property
    def box(self) -> Box:
        """West, east, south, north, bottom, top of the model [m]."""
        if self._box is None or self.aoi is not None:
            return self._around(self.aoi)
        w, e, s, n, *heights = self._given_box
        ring = np.array([(w, s), (e, s), (e, n), (w, n)])
        (w, s), _, (e, n), _ = self._off_rims(ring, "model box").tolist()
        return w, e, s, n, *heights

    @cached_property
    def _given_box(self) -> Box:
        """The box before its sides are moved off rims: horizons are not read for one that is given.

        The default box is where all horizons are, exactly.
        """
        return self.box if self._box is None else self._around(self._given_area)

    def _around(self, area: np.ndarray | None) -> Box:
        """The box that is given, or the default one, as wide as an area in it."""
        if self._box is not None:
            build_walls(self._box, area)
            w, e, s, n, b, t = (float(value) for value in self._box)
        else:
            horizons = [self._plain(name) for name in self._horizons]
            w, e, s, n, b, t = propose_box(horizons, area)
            words = box_in_words((w, e, s, n), horizons, area)
            self._memory.note("box", "all horizons", "ran", f"default: {words}")
            if area is None:
                warning = warning_of_area(horizons, (w, e, s, n, b, t))
                self._memory.warn(*filter(None, [warning]))
        if area is not None:
            (w, s), (e, n) = area.min(axis=0).tolist(), area.max(axis=0).tolist()
        return w, e, s, n, b, t

    @cached_property
    def aoi(self) -> np.ndarray | None:
        """Corners of the area of interest (n, 2), counter-clockwise [m]; None if it is the box."""
        area = self._given_area
        return None if area is None else self._off_rims(area, "area of interest")

    @cached_property
    def _given_area(self) -> np.ndarray | None:
        """The area of interest before its sides are moved off rims."""
        if self._aoi is None:
            return None
        with self._memory.collecting():
            return opened_outline(self._aoi)

    def _off_rims(self, outline: np.ndarray, what: str) -> np.ndarray:
        """An area that is not open along the rim of a horizon, for nothing but rounding."""
        given = self._horizons.items()  # a torn one does not ask for the faults that leave the box
        horizons = [v.surface if isinstance(v, Sheet) else self._plain(n) for n, v in given]
        with self._memory.collecting():
            return off_the_rims(outline, horizons, what)

    @property
    def column(self) -> dict[str, str]:
        """The rule of each horizon, youngest first."""
        rules = check_column(tuple(self._horizons), self._column)
        return dict(zip(self._horizons, rules, strict=True))

    @property
    def contacts(self) -> tuple[FluidContact, ...]:
        """Fluid contacts, from the top down, each with its name, zones and block."""
        return tuple(self._fluids[1])

    @cached_property
    def _fluids(self) -> tuple[list[TriSurface], list[FluidContact]]:
        """Surfaces of fluid contacts, and the zones and blocks in which they count."""
        options = {"positive": self._positive, "length_unit": self._length_unit}
        box = self.box
        with self._memory.collecting():
            surfaces, contacts = build_contacts(opened_contacts(self._contacts, options), box)
        check_zones(contacts, names_of_zones(self.horizon_names))  # before anything is cut
        return surfaces, contacts

    def _prepare(self) -> None:
        """Read all inputs and check them against each other; whatever is odd is warned of."""
        _ = self.surfaces, self._fluids
        for name in self._faults:
            if lies_beside(self.surface(name), self.box):
                self._warn_of_outside(name)
        with self._memory.collecting():
            names = [name for name in (*self._horizons, *self._faults) if name in self._crs]
            warn_of_unclear_crs({name: self._crs[name] for name in names})
        for sheet in self.sheets.values():
            self._memory.warn(*sheet.warnings, issued=True)

    def _warn_of_outside(self, name: str) -> None:
        """Warn of a fault that does not reach the model."""
        self._memory.warn(warning_of_fault(self.surface(name), self.box, self.aoi))

    def _limits(self) -> tuple[Any, Any]:
        """Box and area as given, for what asks when they are first needed."""
        return self._given_box, self._given_area

    def _extent(self) -> Box:
        """The box that extended faults leave: one that is given holds horizons around the area."""
        return self.box if self._box is None else self._box

    def _frame(self, surfaces: Sequence[TriSurface]) -> np.ndarray:
        """Origin of the local frame: the box's where exact, so that all results share it."""
        return shared_origin(None if self._box is None else self._given_box, surfaces)

    def _triangulated(self, name: str, role: str, value: Any) -> TriSurface:
        if name not in self._read:  # once: a scene stands for its inputs as it found them
            if isinstance(value, Sheet):
                value.surface_among(self.surface)  # with other faults it is not to be remembered
            self._read[name] = self._memory.hold(value)
        key = ("surface", name, role, self._read[name], self._positive, self._length_unit)

        def run() -> TriSurface:
            """Compute it; called unless it is remembered."""
            options = {"positive": self._positive, "length_unit": self._length_unit}
            return as_surface(name, role, value, options, self.surface)

        found: TriSurface = self._memory.get_or_compute(
            "triangulate", name, key, run, lambda s: f"{s.n_triangle} triangles", again=False
        )
        self._memory.made_of(found, key)
        refuse_other_crs(name, found.crs, self._crs)
        if found.crs is not None:
            self._crs[name] = found.crs
        return found
