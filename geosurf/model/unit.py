"""One unit: a closed piece of the model."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from geosurf.conventions import volume_text
from geosurf.conventions.card import Card
from geosurf.model.base import Shown, frozen, polydata
from geosurf.model.map_area import rows_of_contacts, upper_area

if TYPE_CHECKING:  # pragma: no cover - types only
    import pyvista


@dataclass(frozen=True, eq=False)
class Unit(Shown):
    """A closed piece of the model: one zone in one fault block, above or below a contact.

    Attributes
    ----------
    name : str
        Zone, the block where faults split the zone, and the contact interval where one counts.
    zone : str
        ``above Top``, ``Top/Base``, ``below Base``.
    zone_index : int
        0 above the first horizon, counting down.
    block : str
        Sides of the faults that separate it: ``F1+`` is the side into which
        the fault's normal points (the hanging wall of a dipping fault), ``F1-`` the
        other. ``whole`` where no fault separates the zone. Pieces that no fault
        separates are numbered by size, then by place: ``F1+``, ``F1+ #2``.
    local : ndarray of float64, shape (n_vertex, 3)
    triangles : ndarray of int64, shape (n_triangle, 3)
        Outward normals.
    surface_of_triangle : ndarray of int64, shape (n_triangle,)
        Row of `surface_names`.
    bounded_by : tuple of str
        Names of the surfaces on its boundary.
    volume, area : float
        [m3], [m2].
    contact : str
        ``above OWC``, ``GOC/OWC``, ``below OWC``; empty where no fluid contact counts.
    beneath : tuple of str
        Names of the fluid contacts that count in it and lie above it, from the top down.
    fault_sides : tuple of str
        Sides of faults that it lies on: those in `block`, and those of faults that part the model
        elsewhere. From a unit on ``F1+`` no way leads to the back of F1 but through F1.
    compartment_of : str
        Where virtual walls continue faults: the block that it would be a part of without them.
    """

    name: str
    zone: str
    zone_index: int
    block: str
    local: np.ndarray
    origin: np.ndarray
    triangles: np.ndarray
    surface_of_triangle: np.ndarray
    surface_names: tuple[str, ...]
    volume: float
    area: float
    contact: str = ""
    beneath: tuple[str, ...] = ()
    fault_sides: tuple[str, ...] = ()
    compartment_of: str = ""

    @cached_property
    def vertices(self) -> np.ndarray:
        """World coordinates [m], float64 (n_vertex, 3)."""
        return frozen(self.local + self.origin, np.float64)

    @cached_property
    def middle(self) -> tuple[float, float, float]:
        """Easting, northing and elevation of the middle of its bounds [m]."""
        # The middle of the bounds: cheap, the same for any triangulation, and inside for most
        # units.
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        east, north, up = (0.5 * (low + high)).tolist()
        return east, north, up

    @cached_property
    def bounded_by(self) -> tuple[str, ...]:
        """Names of the surfaces that bound the unit."""
        return tuple(self.surface_names[i] for i in np.unique(self.surface_of_triangle))

    @cached_property
    def map_area(self) -> float:
        """Area of its upper side in the map [m2]; where it lies above itself, that counts twice.

        Volume over it is the mean length of the pieces of vertical lines inside the unit.
        """
        return upper_area(self.local, self.triangles)

    @cached_property
    def n_triangle(self) -> int:
        """Number of triangles."""
        return len(self.triangles)

    @cached_property
    def zone_map_area(self) -> float:
        """Map area of its upper side where that is not a fluid contact [m2].

        Volume over it, summed over the units of a zone, is the mean thickness of the zone.
        """
        contacts = rows_of_contacts(self.surface_names, self.beneath)
        return upper_area(self.local, self.triangles[~np.isin(self.surface_of_triangle, contacts)])

    def to_pyvista(self) -> pyvista.PolyData:
        """Return the shell as `pyvista.PolyData` with the surface row as cell data."""
        labels = {"surface": self.surface_of_triangle}
        return polydata(self.vertices, self.triangles, cell_data=labels, crs=self.crs)

    def _card(self) -> Card:
        """Return zone, block, volume and what bounds the unit."""
        rows = [("zone", self.zone), ("block", self.block), ("volume", volume_text(self.volume, 5))]
        rows += [("contact", self.contact)] if self.contact else []
        rows.append(("bounded by", ", ".join(self.bounded_by)))
        return Card(f"Unit {self.name}", rows)

    def __repr__(self) -> str:
        return f"<Unit {self.name!r}: {volume_text(self.volume)}, {self.n_triangle} triangles>"
