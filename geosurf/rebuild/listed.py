"""Patches as their listed triangles: all but the runs of gridded surfaces that no curve touches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geosurf.kernels.meshes.numbering import number_below
from geosurf.kernels.sheets.sheet_trim import sides_of_edges
from geosurf.model import Patches, TriSurface
from geosurf.model.torn_lattice import TornLattice


@dataclass(frozen=True, eq=False)
class SheetFaces:
    """The triangles of a torn sheet that have parts in patches.

    Attributes
    ----------
    parent : ndarray of int64, shape (n,)
        Of each listed triangle of the sheet, as row of `faces`.
    faces : ndarray of int64, shape (n_face, 3)
        As rows of `places`.
    places : ndarray of float64, shape (n_vertex, 3)
        World coordinates.
    vertex : ndarray of int64, shape (n_vertex,)
        Vertices of the sheet, rising.
    """

    parent: np.ndarray
    faces: np.ndarray
    places: np.ndarray
    vertex: np.ndarray


@dataclass(frozen=True, eq=False)
class Listed:
    """Triangles of patches, surface by surface; names of arrays are those of `Patches`.

    Attributes
    ----------
    sources : sequence of TriSurface
    origin : ndarray of float64, shape (3,)
    local : ndarray of float64, shape (n_vertex, 3)
    triangles : ndarray of int64, shape (n_triangle, 3)
    surface_of_triangle, parent_of_triangle, patch_of_triangle : ndarray of int64
    curve_edges : ndarray of int64, shape (n_edge, 2)
    n_patch : int
    """

    sources: Sequence[TriSurface]
    origin: np.ndarray
    local: np.ndarray
    triangles: np.ndarray
    surface_of_triangle: np.ndarray
    parent_of_triangle: np.ndarray
    patch_of_triangle: np.ndarray
    curve_edges: np.ndarray
    n_patch: int

    @classmethod
    def all_of(cls, patches: Patches) -> Listed:
        """Every triangle of some patches."""
        return cls(
            patches.sources, patches.origin, patches.local, patches.triangles,
            patches.surface_of_triangle, patches.parent_of_triangle, patches.patch_of_triangle,
            patches.curve_edges, patches.n_patch,
        )  # fmt: skip

    @classmethod
    def without_runs(cls, patches: Patches) -> Listed:
        """The triangles that are listed already; parents in a grid are keys, not rows.

        Of torn sheets they are rows.
        """
        pieces = patches.pieces
        parent = pieces.key.copy()
        cut = np.searchsorted(pieces.surface, np.arange(len(patches.sources) + 1))
        for i, source in enumerate(patches.sources):
            if isinstance(source.lattice, TornLattice):
                mine = slice(cut[i], cut[i + 1])
                parent[mine] = source.rows_of_keys(parent[mine])
        return cls(
            patches.sources, patches.origin, pieces.x, pieces.triangles, pieces.surface,
            parent, pieces.patch[: len(pieces.triangles)], patches.curve_edges, patches.n_patch,
        )  # fmt: skip

    @cached_property
    def _first(self) -> list[int]:
        found: list[int] = np.searchsorted(
            self.surface_of_triangle, np.arange(len(self.sources) + 1)
        ).tolist()
        return found

    def rows(self, surface: int) -> slice:
        """The triangles of a surface: they follow each other."""
        return slice(self._first[surface], self._first[surface + 1])

    def sheet(self, surface: int) -> SheetFaces:
        """The triangles of a torn sheet that have parts here, without a list of all."""
        known = self._sheets.get(surface)
        if known is not None:
            return known
        source, parent = self.sources[surface], self.parent_of_triangle[self.rows(surface)]
        used, row = number_below(parent, source.n_triangle)
        if source.lattice is None:
            corners = source.corners_of_keys(used)
        else:  # parents are rows
            nodes = source.lattice.corners_of_keys(source.lattice.keys_of_rows(used))
            corners = source.lattice.vertex_of_node.ravel()[nodes]
        vertex, number = number_below(corners.ravel(), source.n_vertex)
        node = vertex
        if isinstance(source.lattice, TornLattice):
            node = source.lattice.node_of_vertex[vertex]
        found = SheetFaces(
            row, number.reshape(-1, 3), source.places_of_nodes(node), vertex,
        )  # fmt: skip
        self._sheets[surface] = found
        return found

    @cached_property
    def _sheets(self) -> dict[int, SheetFaces]:
        return {}

    @cached_property
    def is_fault(self) -> np.ndarray:
        """Whether each surface is a fault, bool (n_surface,)."""
        return np.array([source.role == "fault" for source in self.sources], dtype=bool)

    @cached_property
    def on_fault(self) -> np.ndarray:
        """Vertices on any fault: there a sheet may end, bool (n_vertex,)."""
        found = np.zeros(len(self.local), dtype=bool)
        for i in np.flatnonzero(self.is_fault).tolist():
            found[self.triangles[self.rows(i)]] = True
        return found

    @cached_property
    def at_curves(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Half-edges on curves: number of the curve edge, triangle; and whether a fault is there.

        The third is by curve edge.
        """
        edge, triangle = sides_of_edges(self.triangles, self.curve_edges, len(self.local))
        fault = np.zeros(len(self.curve_edges), dtype=bool)
        fault[edge[self.is_fault[self.surface_of_triangle[triangle]]]] = True
        return edge, triangle, fault
