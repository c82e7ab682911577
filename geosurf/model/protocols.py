"""What stages ask of a scene: drawing, reporting and gridding take objects with these members.

`geosurf.Scene` has them all. Stages lie below it and do not import it.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from geosurf.errors import GeosurfWarning
from geosurf.lazy import xarray
from geosurf.model.column import FluidContact, VirtualWall
from geosurf.model.network import Extension, Truncation
from geosurf.model.patches import Curves, Patches, VoxelSearch
from geosurf.model.sheets import Sheet
from geosurf.model.surfaces import TriSurface
from geosurf.model.tops import Tops
from geosurf.model.units import Certificate, Units

# ---- view3d ----------------------------------------
# What an interactive view shows: bodies with few enough triangles, their colours and numbers.


@dataclass(frozen=True, eq=False)
class Body:
    """One unit or surface of an interactive view.

    Attributes
    ----------
    name : str
    group : str
        Bodies of one group can be shown and hidden together: a zone, or a role.
    colour : (red, green, blue)
        From 0 to 1.
    points : ndarray of float64, shape (n_point, 3)
        World coordinates [m].
    triangles : ndarray of int64, shape (n_triangle, 3)
        Outward normals, where the body is closed.
    surface : ndarray of int64, shape (n_triangle,)
        Triangles of different surfaces meet at a sharp edge.
    lines : ndarray of int64, shape (n_line, 2)
        Edges that are drawn as lines.
    facts : tuple of (str, str)
        What a reader learns who picks it: ``(("Zone", "Top/Base"), ...)``.
    shift : (float, float, float)
        By how much it moves where the view is exploded in full [m].
    closed : bool
        Whether the triangles bound a volume.
    shown : bool
        Whether it is visible at first.
    """

    name: str
    group: str
    colour: tuple[float, float, float]
    points: np.ndarray
    triangles: np.ndarray
    surface: np.ndarray
    lines: np.ndarray
    facts: tuple[tuple[str, str], ...] = ()
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    closed: bool = True
    shown: bool = True


@dataclass(frozen=True, eq=False)
class View3D:
    """The content of an interactive view.

    Attributes
    ----------
    bodies : tuple of Body
    box : (west, east, south, north, bottom, top)
        Whose edges are drawn [m].
    exaggeration : float
        Vertical exaggeration at first.
    explode : float
        Of the shifts of bodies, from 0 to 1, at first.
    """

    bodies: tuple[Body, ...]
    box: tuple[float, ...]
    exaggeration: float = 1.0
    explode: float = 0.0


# West, east, south, north, bottom, top [m].
Box = tuple[float, float, float, float, float, float]


class ReportedModel(Protocol):
    """A model as pictures, reports and grids take it, which ask for what they show only."""

    @property
    def surfaces(self) -> tuple[TriSurface, ...]:
        """All horizons, then all faults."""

    @property
    def curves(self) -> Curves:
        """Curves of all pairs of surfaces."""

    @property
    def patches(self) -> Patches:
        """All surfaces and the walls of the box, split along their curves."""

    @property
    def units(self) -> Units:
        """Closed units."""

    @property
    def box(self) -> Box:
        """West, east, south, north, bottom, top [m]."""

    @property
    def aoi(self) -> np.ndarray | None:
        """Corners of the area of interest (n, 2) [m]; None if it is the box."""

    # Names and measures: what maps, sections and diagrams are drawn of.
    @property
    def sheets(self) -> dict[str, Sheet]:
        """Horizons that are torn at their faults, by name."""

    @property
    def horizon_names(self) -> tuple[str, ...]:
        """Names of the horizons, youngest first."""

    @property
    def fault_names(self) -> tuple[str, ...]:
        """Names of the faults."""

    @property
    def horizons_inside(self) -> tuple[str, ...]:
        """Names of the horizons that reach into the model."""

    @property
    def faults_inside(self) -> tuple[str, ...]:
        """Names of the faults that reach into the model."""

    @property
    def virtual_walls(self) -> tuple[VirtualWall, ...]:
        """Virtual walls that continue faults."""

    @property
    def contacts(self) -> tuple[FluidContact, ...]:
        """Fluid contacts, from the top down."""

    def surface(self, name: str) -> TriSurface:
        """Return one surface by name."""

    def search(self, first: str, second: str) -> VoxelSearch | None:
        """Return what the voxel search found for two surfaces."""

    def cutoffs(self, horizon: str, fault: str) -> list[np.ndarray]:
        """Return the lines where a horizon meets a fault."""

    def thickness(
        self, zone: str, grid: Any = None, *, contact: str | None = None
    ) -> xarray.DataArray:
        """Return a thickness map of a zone."""

    def fault_polygons(self, horizon: str) -> xarray.Dataset:
        """Return the fault polygons of a horizon."""

    def juxtaposition(self, fault: str, include: str = "reservoir") -> xarray.Dataset:
        """Return the areas of pairs of units across a fault."""

    def allan(self, fault: str) -> xarray.Dataset:
        """Return the Allan diagram of a fault."""

    def throw(self, horizon: str, fault: str) -> xarray.Dataset:
        """Return throw and heave of a horizon along a fault."""

    def section(self, line: Any) -> xarray.Dataset:
        """Return a vertical section along a line in the map."""

    @property
    def tops(self) -> Tops | None:
        """Well tops; None without."""

    def misfit(self) -> xarray.Dataset:
        """Return the well tops compared with the horizons."""

    # Further contents of a report: inputs, warnings, certificate and run log.
    @property
    def fault_actions(self) -> tuple[Extension | Truncation, ...]:
        """Every extension and truncation."""

    @property
    def tolerance(self) -> float | None:
        """The largest error of curves and of horizons in the model [m]; None: all is exact."""

    @property
    def volume_error_bound(self) -> float:
        """By how much horizons with fewer nodes may change the volume of units [m3]."""

    @property
    def coverage(self) -> dict[str, float]:
        """Share of each input that is inside the model."""

    @property
    def warnings(self) -> tuple[GeosurfWarning, ...]:
        """What was assumed, each with its effect and a remedy."""

    @property
    def input_files(self) -> dict[str, Path]:
        """Inputs that are paths, by name."""

    # Actions of a report: they compute or write.
    def view_3d(self) -> View3D | None:
        """Return an interactive view of the units; None without."""

    def render_pictures(
        self,
        folder: str | os.PathLike[str],
        *,
        on_file: Callable[[str], object] | None = None,
        **choice: Any,
    ) -> dict[str, Path]:
        """Draw pictures into a folder; return captions and files."""

    def check(self) -> Certificate:
        """Return the certificate of the model."""

    @property
    def steps(self) -> tuple[Any, ...]:
        """What ran, what came from memory, and what was skipped."""


def missing_members(thing: object, wanted: type) -> tuple[str, ...]:
    """
    Return the members of a protocol that an object does not have; no property is computed.

    Examples
    --------
    >>> missing_members("text", ReportedModel)[:6]
    ('surfaces', 'curves', 'patches', 'units', 'box', 'aoi')
    """
    # in the order in which they are defined
    members = [name for name in vars(wanted) if not name.startswith("_")]
    own: Mapping[str, Any] = getattr(thing, "__dict__", {})
    # The class is asked, not the object: a property of a scene would be computed.
    return tuple(n for n in members if n not in own and not hasattr(type(thing), n))
