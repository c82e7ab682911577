"""Tetrahedra that fill the units of a model."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from geosurf.conventions import volume_text
from geosurf.model.base import Shown, frozen, tet_grid

if TYPE_CHECKING:  # pragma: no cover - types only
    import pyvista
    import xarray


@dataclass(frozen=True, eq=False)
class TetMesh(Shown):
    """One conforming mesh of tetrahedra of all units, from `mesh_units`.

    Neighbouring tetrahedra share whole faces, inside units and across their boundaries.

    Attributes
    ----------
    local : ndarray of float64, shape (n_vertex, 3)
        Vertices [m], relative to `origin`. Those of the model come first.
    origin : ndarray of float64, shape (3,)
        Easting, northing and elevation [m].
    tetrahedra : ndarray of int64, shape (n_tetrahedron, 4)
        Rows of `local`. Seen from the fourth corner, the first three run counterclockwise (VTK).
    region : ndarray of int64, shape (n_tetrahedron,)
        Unit of each: row of `unit_names`.
    unit_names : tuple of str
        In the order of the units that were meshed.
    faces : ndarray of int64, shape (n_face, 3)
        Faces between two units or on the sides of the model; each is a triangle of the
        model, or a part of one.
    surface_of_face : ndarray of int64, shape (n_face,)
        Row of `surface_names`.
    face_sides : ndarray of int64, shape (n_face, 2)
        Unit in front of and behind each face; -1 outside the model.
    surface_names : tuple of str
        Names of horizons, faults, fluid contacts and walls.
    volumes : xarray.DataArray
        Volume of each unit, summed over its tetrahedra [m3].
    """

    local: np.ndarray
    origin: np.ndarray
    tetrahedra: np.ndarray
    region: np.ndarray
    unit_names: tuple[str, ...]
    faces: np.ndarray
    surface_of_face: np.ndarray
    face_sides: np.ndarray
    surface_names: tuple[str, ...]

    def __post_init__(self) -> None:
        for name in ("tetrahedra", "region", "faces", "surface_of_face", "face_sides"):
            object.__setattr__(self, name, frozen(getattr(self, name), np.int64))
        object.__setattr__(self, "local", frozen(self.local, np.float64))

    @cached_property
    def vertices(self) -> np.ndarray:
        """World coordinates [m], float64 (n_vertex, 3)."""
        return frozen(self.local + self.origin, np.float64)

    @cached_property
    def cell_volumes(self) -> np.ndarray:
        """Volume of each tetrahedron [m3], float64 (n_tetrahedron,)."""
        a, b, c, d = (self.local[self.tetrahedra[:, k]] for k in range(4))
        return frozen(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6.0, np.float64)

    @cached_property
    def volumes(self) -> xarray.DataArray:
        """Volume of each unit, summed over its tetrahedra [m3]."""
        import xarray as xr

        order = np.argsort(self.region, kind="stable")
        ends = np.cumsum(np.bincount(self.region, minlength=len(self.unit_names)))
        parts = np.split(self.cell_volumes[order], ends[:-1])
        attrs = {"units": "m3", "long_name": "bulk volume"}
        names = {"unit": ("unit", np.array(self.unit_names, dtype=object))}
        # fsum: thin tetrahedra next to large ones lose no digits
        found = np.array([math.fsum(part.tolist()) for part in parts])
        return xr.DataArray(found, names, "unit", "volume", attrs)

    def to_pyvista(self) -> pyvista.UnstructuredGrid:
        """Return the mesh as `pyvista.UnstructuredGrid` with cell data ``unit``, the region."""
        grid = tet_grid(self.vertices, self.tetrahedra, {"unit": self.region})
        if self.crs is not None:
            grid.field_data["crs"] = [self.crs]
        return grid

    def __repr__(self) -> str:
        total = math.fsum(self.cell_volumes.tolist())
        return (
            f"<TetMesh: {len(self.tetrahedra)} tetrahedra in {len(self.unit_names)} units, "
            f"{len(self.local)} vertices, {volume_text(total)}>"
        )
