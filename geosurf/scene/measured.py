"""What users measure of a scene: maps, places, wells, sections and separations.

Each method is a function of `measures`, with the scene's graph.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from geosurf.scene import measures
from geosurf.scene.graph import Graph

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray


class HasGraph(Protocol):
    """What the measures need of a scene."""

    @property
    def _graph(self) -> Graph: ...


class SceneMeasures:
    """The measures of a `Scene`: each computes only what it needs."""

    def thickness(
        self: HasGraph,
        zone: str,
        grid: Any = None,
        *,
        kind: str = "isochore",
        contact: str | None = None,
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
        return measures.thickness(self._graph, zone, grid, kind, contact)

    def sample(
        self: HasGraph,
        where: Any = None,
        *,
        cell: Any = None,
        codes: bool = False,
        distance: bool = False,
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
        return measures.sample(self._graph, where, cell, codes, distance)

    def well_intervals(self: HasGraph, path: Any, *, md: Any = None) -> xarray.Dataset:
        """Return the units that wells go through, with entry and exit points.

        Parameters
        ----------
        path : array_like, table or xarray object
            Points along the well, in order: easting, northing and elevation [m], as for `sample`. A
            column ``md`` of a table is the measured depth. Many wells: a mapping such as ``{"W-1":
            path}``, or a table with a column ``well``.
        md : array_like of float, shape (n,), optional
            Measured depth of each point of one well [m]. Default: that column, else the length of
            the path.

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
        return measures.well_intervals(self._graph, path, md)

    def juxtaposition(self: HasGraph, fault: str) -> xarray.Dataset:
        """Return the areas of all pairs of units that face each other across a fault [m2].

        Parameters
        ----------
        fault : str

        Returns
        -------
        xarray.Dataset
            ``area`` over ``pair``; see ``geosurf.measure.juxtaposition_table``.

        Raises
        ------
        InputError
            For an unknown fault.
        """
        return measures.juxtaposition(self._graph, fault)

    def allan(self: HasGraph, fault: str) -> xarray.Dataset:
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
        return measures.allan(self._graph, fault)

    def section(self: HasGraph, line: Any) -> xarray.Dataset:
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
        return measures.section(self._graph, line)

    def cutoffs(
        self: HasGraph, horizon: str, fault: str, side: str | None = None
    ) -> list[np.ndarray]:
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
        return measures.cutoffs(self._graph, horizon, fault, side)

    def fault_polygons(self: HasGraph, horizon: str) -> xarray.Dataset:
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
        return measures.fault_polygons(self._graph, horizon)

    def throw(
        self: HasGraph, horizon: str, fault: str, *, direction: str = "local"
    ) -> xarray.Dataset:
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
        return measures.throw(self._graph, horizon, fault, direction)

    def orientation(self: HasGraph, name: str) -> xarray.Dataset:
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
        return measures.orientation(self._graph, name)

    def misfit(self: HasGraph, tops: Any = None) -> xarray.Dataset:
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
        return measures.misfit(self._graph, tops)
