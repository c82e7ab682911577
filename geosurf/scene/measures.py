"""The measures of a scene: thin methods, each of which asks for what it needs and remembers it."""

from __future__ import annotations

import inspect
import math
import os
from collections.abc import Callable, Hashable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import HORIZON_DIMS, counted, did_you_mean, is_word
from geosurf.errors import GeometryError, GeosurfWarning, InputError
from geosurf.model import Curves, Patches, Sheet, Units
from geosurf.model.expected import name_of
from geosurf.scene.memory import Memory
from geosurf.warning import collected

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray


class Measured:
    """What `geosurf.Scene` can be asked about its model; see docs/measures.md."""

    _memory: Memory
    _horizons: dict[str, Any]
    _faults: dict[str, Any]
    patches: Patches
    units: Units
    _units_key: Hashable
    curves_between: Callable[[str, str], Curves | None]

    @property
    def sheets(self) -> dict[str, Sheet]:
        """Horizons that are torn at their faults, by name, each with its cut-offs and report."""
        return {name: one for name, one in self._horizons.items() if isinstance(one, Sheet)}

    @property
    def faults_inside(self) -> tuple[str, ...]:
        """Names of the faults that reach into the model."""
        return self._inside("fault")

    @property
    def horizons_inside(self) -> tuple[str, ...]:
        """Names of the horizons that reach into the model, youngest first."""
        return self._inside("horizon")

    def _inside(self, role: str) -> tuple[str, ...]:
        """Names of surfaces of a role that have units beside them, in the order of the scene."""
        patches = self.patches
        inside = np.unique(patches.surface_of_triangle[(self.units.sides >= 0).any(axis=1)])
        sources = [patches.sources[i] for i in inside.tolist()]
        return tuple(source.name for source in sources if source.role == role)

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
            Is called with the name of each file, when it is there.
        **choice
            Which pictures, and how; see `geosurf.scene.pictures.pictures_of`.

        Returns
        -------
        dict of str to pathlib.Path
            Captions and files. A picture that cannot be drawn is missing; `warnings` names it, with
            the reason.
        """
        from geosurf.scene.pictures import draw_pictures, pictures_of

        known = inspect.signature(pictures_of).parameters
        for key in choice:
            if key not in known or key == "scene":
                words = [word for word in known if word != "scene"]
                raise InputError(
                    f"pictures have no {key!r}; they have {words}.{did_you_mean(key, words)}"
                )
        if on_file is not None and not callable(on_file):
            raise InputError(f"on_file is {on_file!r}; give a function of one text, such as print.")
        found: list[GeosurfWarning] = []
        try:
            with collected() as found:
                return draw_pictures(pictures_of(self, **choice), folder, on_file)
        finally:
            self._memory.warn(*found)

    def _measured(self, what: str, run: Callable[[], Any], *more: Any) -> Any:
        size = lambda found: ", ".join(counted(n, dim) for dim, n in found.sizes.items())  # noqa: E731
        key = ("measure", what, self._units_key, *more)
        return self._memory.get_or_compute("measure", what, key, run, size)

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

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.graben(n=9)
        >>> scene = gs.Scene(world.horizons, world.faults, world.box)
        >>> found = scene.thickness("Top/Middle", 250.0)
        >>> found.sum("block").round(9).values.tolist()[0][:3]
        [70.0, 70.0, 70.0]
        """
        from geosurf.measure import thickness_map

        if contact is not None:
            contact = name_of(contact, "contact interval")
        nodes = repr(grid)
        if hasattr(grid, "coords"):  # of a map, only these count; and they may be changed in place
            axes = [grid.coords[name] for name in HORIZON_DIMS if name in grid.coords]
            nodes = self._memory.hold(axes)
        return self._measured(
            f"{kind} {zone}",
            lambda: thickness_map(
                self.units, zone, grid, kind=kind, contact=contact, horizons=tuple(self._horizons)
            ),
            nodes, contact,
        )  # fmt: skip

    def juxtaposition(self, fault: str) -> xarray.Dataset:
        """Return the areas of all pairs of units that face each other across a fault [m2].

        Parameters
        ----------
        fault : str

        Returns
        -------
        xarray.Dataset
            ``area`` over ``pair``; see `geosurf.measure.juxtaposition_table`.
        """
        from geosurf.measure import juxtaposition_table

        return self._measured(
            f"juxtaposition {fault}", lambda: juxtaposition_table(self.patches, self.units, fault)
        )

    def allan(self, fault: str) -> xarray.Dataset:
        """Return the Allan diagram of a fault: zones, cut-offs and contacts of both walls, on it.

        Parameters
        ----------
        fault : str

        Returns
        -------
        xarray.Dataset
            Lines with ``along_strike`` and ``elevation``; see `geosurf.measure.allan_diagram`.
        """
        from geosurf.measure import allan_diagram

        return self._measured(
            f"allan {fault}", lambda: allan_diagram(self.patches, self.units, fault)
        )

    def section(self, line: Any) -> xarray.Dataset:
        """Return a vertical section of the model along a line in the map.

        Parameters
        ----------
        line : array_like of float, shape (n, 2)
            Easting and northing [m]: two points or more, from the left to the right.

        Returns
        -------
        xarray.Dataset
            Rings of units, and lines of surfaces, with ``along_section`` and ``elevation``; see
            `geosurf.measure.vertical_section`.
        """
        from geosurf.measure import vertical_section
        from geosurf.measure.section import check_line

        corners = check_line(line)
        run = lambda: vertical_section(self.patches, self.units, corners)  # noqa: E731
        return self._measured("section", run, corners.tobytes())

    def cutoffs(self, horizon: str, fault: str, side: str | None = None) -> list[np.ndarray]:
        """Return the lines where a horizon meets a fault, or those on one wall of it.

        Parameters
        ----------
        horizon, fault : str
        side : {"+", "-", "hanging wall", "footwall"}, optional
            One wall, as in the model: only where the zone beside the fault changes there. By
            default the two surfaces alone are asked, and no model is built.

        Returns
        -------
        list of ndarray, each (n, 3)
            World coordinates [m], in order along the line.
        """
        for role, known, name in (
            ("horizon", self._horizons, horizon),
            ("fault", self._faults, fault),
        ):
            if not is_word(name, known):
                raise InputError(
                    f"no {role} is called {name!r}; there are {list(known)}."
                    f"{did_you_mean(name, known)}"
                )
        if side is None:
            found = self.curves_between(horizon, fault)
            return [] if found is None else [found.points[curve] for curve in found.curves]
        from geosurf.measure import side_of_words, wall_lines

        return wall_lines(self.patches, self.units, horizon, fault, side_of_words(side))

    def fault_polygons(self, horizon: str) -> xarray.Dataset:
        """Return the fault polygons of a horizon: rings of hanging-wall and footwall cut-offs.

        Parameters
        ----------
        horizon : str

        Returns
        -------
        xarray.Dataset
            Rings with the fault's name; see `geosurf.measure.fault_polygons`.
        """
        from geosurf.measure import fault_polygons

        return self._measured(
            f"fault polygons {horizon}", lambda: fault_polygons(self.patches, self.units, horizon)
        )

    def throw(self, horizon: str, fault: str, *, direction: str = "local") -> xarray.Dataset:
        """Return throw, heave and dip separation of a horizon along a fault.

        Parameters
        ----------
        horizon, fault : str
        direction : {"local", "mean"}
            Whether cut-offs are compared down the dip that the fault has at each place, as
            `throw_horizon` moves walls, or all across its mean strike. One and the same on a fault
            that does not turn in the map.

        Returns
        -------
        xarray.Dataset
            Over ``point`` with ``along_strike``; see `geosurf.measure.separation`.

        Raises
        ------
        InputError
            For another direction.
        GeometryError
            If a fault is flat on average, or turns back against its mean dip direction between its
            cut-offs (``"local"`` only), or a cut-off turns back along the strike.
        """
        from geosurf.measure import faces_of, separation
        from geosurf.sheets.faults.dip_lines import DIRECTIONS

        if not is_word(direction, DIRECTIONS):
            raise InputError(f"direction is {direction!r}, expected one of {DIRECTIONS}.")
        horizon, fault = name_of(horizon, "horizon"), name_of(fault, "fault")

        def run() -> xarray.Dataset:
            """Compute it; called unless it is remembered."""
            faces = faces_of(self.patches, self.units, fault, "fault")
            hanging, foot = (self.cutoffs(horizon, fault, side) for side in ("+", "-"))
            azimuth = math.degrees(math.atan2(*faces.strike[1].tolist())) % 360.0
            start = -float(faces.along(-faces.origin[None])[0])
            found = separation(hanging, foot, azimuth, start=start)
            if direction == "local" and found.sizes["point"]:
                level = self._down_dip(horizon, fault, found, hanging, foot)
                if level is not None:
                    found = separation(hanging, foot, azimuth, start=start, level=level)
            return found.assign_attrs(horizon=horizon, fault=fault, direction=direction)

        return self._measured(f"throw {horizon} x {fault}", run, horizon, fault, direction)

    def _down_dip(
        self,
        horizon: str,
        fault: str,
        found: xarray.Dataset,
        hanging: list[np.ndarray],
        foot: list[np.ndarray],
    ) -> Callable[[np.ndarray], np.ndarray] | None:
        """How lines down the dip of a fault lead to the mean level of cut-offs; None: straight."""
        from geosurf.sheets.faults.dip_lines import cell_of, to_level

        sources = {source.name: source for source in self.patches.sources}
        cell = cell_of(self.sheets.get(horizon, sources[horizon]))
        walls = found.hanging_wall_elevation, found.footwall_elevation
        level = 0.5 * sum(float(wall.mean()) for wall in walls)
        try:
            most = float(abs(found.throw).max())
            return to_level(sources[fault], most, cell, level, hanging, foot)
        except GeometryError as error:
            error.add_note("With direction='mean' throw is read across the mean strike.")
            raise

    def orientation(self, name: str) -> xarray.Dataset:
        """Return area, dip and azimuth of a horizon or fault, as a whole and by triangle.

        Parameters
        ----------
        name : str

        Returns
        -------
        xarray.Dataset
            See `geosurf.measure.orientation`.
        """
        from geosurf.measure import orientation

        return self._measured(
            f"orientation {name}", lambda: orientation(self.patches, self.units, name)
        )
