"""What surfaces do to each other: contacts, curves, patches."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import place
from geosurf.errors import InputError
from geosurf.model.base import frozen, polydata
from geosurf.model.surfaces import TriSurface

if TYPE_CHECKING:  # pragma: no cover - types only
    import pyvista


@dataclass(frozen=True, eq=False)
class TriangleContact:
    """How two triangles meet.

    Attributes
    ----------
    kind : {"disjoint", "point", "segment", "area"}
    points : ndarray of float64, shape (n, 3)
        0, 1, 2 or 3 to 6 corners of the intersection, in order around an area.
    coplanar : bool
        Whether the triangles lie in one plane.
    features : tuple of (str, str), length n
        The feature pair of each point: ``("vertex 0", "face")``,
        ``("edge 2", "edge 1")`` ... of the first and the second triangle. Edge
        ``i`` joins corner ``i`` to the next.
    crossing : bool
        Whether each triangle has points strictly on both sides of the other's
        plane (False for touching and for coplanar contact).
    """

    kind: str
    points: np.ndarray
    coplanar: bool
    features: tuple[tuple[str, str], ...]
    crossing: bool


@dataclass(frozen=True, eq=False)
class Touch:
    """A contact that is no curve: a touching point or an overlap area.

    Attributes
    ----------
    kind : {"point", "area"}
    surfaces : (int, int)
        Rows of `Curves.names`.
    points : ndarray of float64, shape (n, 3)
        World coordinates [m]; one point, or the corners of the overlap.
    area : float
        Overlapping area [m2]; 0 for a point.
    """

    kind: str
    surfaces: tuple[int, int]
    points: np.ndarray
    area: float = 0.0


@dataclass(frozen=True, eq=False)
class Place:
    """Where a curve is not what its tolerance asked for, and why.

    Attributes
    ----------
    reason : str
        In words: ``"noise"``, ``"hole"``, ``"tangency"``, ``"rim"``, ``"interpolation"``,
        ``"touching"``, ``"coarse lattice"``, ``"overlap"``; `docs/accuracy.md` explains them.
    surfaces : (int, int)
        Rows of `Curves.names`.
    points : ndarray of float64, shape (n, 3)
        World coordinates [m]: the part of the curve, or the place of a possible contact.
    error_bound : float
        Estimated error there [m]; inf where no rule gives one.
    curve : int
        Row of `Curves.curves`, or -1 where there is none.
    """

    reason: str
    surfaces: tuple[int, int]
    points: np.ndarray
    error_bound: float
    curve: int = -1

    def __str__(self) -> str:
        where = place(self.points[len(self.points) // 2])
        size = "unknown" if np.isinf(self.error_bound) else f"about {self.error_bound:.2g} m"
        return f"{self.reason} at {where}: error {size}"


@dataclass(frozen=True, eq=False)
class Curves:
    """The curves along which surfaces meet.

    Attributes
    ----------
    names : tuple of str
        Names of the surfaces, in the order in which they were given.
    local : ndarray of float64, shape (n_point, 3)
        Points in the local frame [m]; `points` adds `origin`.
    segments : ndarray of int64, shape (n_segment, 2)
        Rows of `points`.
    surfaces_of_segment : ndarray of int64, shape (n_segment, 2)
        The two surfaces (rows of `names`, smaller first) that meet there.
    curves : tuple of ndarray of int64
        Rows of `points`, in order; a closed curve repeats its first row.
    surfaces_of_curve : ndarray of int64, shape (n_curve, 2)
    closed : ndarray of bool, shape (n_curve,)
    contacts : tuple of Touch
        Touching points and overlap areas.
    cost : dict
        What it took: numbers of voxels, candidate faces, pairs tested, pairs meeting.
    error_bound : ndarray of float64, shape (n_curve,), or None
        With a tolerance: how far each curve can be from that of the smooth surfaces [m]; 0 for
        plain curves of surfaces that are no lattices, inf where a part is not known. None for
        plain curves.
    places : tuple of Place
        With a tolerance: where it is not met, or not known to be, and why.
    """

    names: tuple[str, ...]
    local: np.ndarray
    origin: np.ndarray
    segments: np.ndarray
    surfaces_of_segment: np.ndarray
    curves: tuple[np.ndarray, ...]
    surfaces_of_curve: np.ndarray
    closed: np.ndarray
    contacts: tuple[Touch, ...] = ()
    cost: dict[str, int] = field(default_factory=dict)
    error_bound: np.ndarray | None = None
    places: tuple[Place, ...] = ()

    @property
    def n_curve(self) -> int:
        """Number of curves."""
        return len(self.curves)

    @cached_property
    def points(self) -> np.ndarray:
        """World coordinates [m], float64 (n_point, 3)."""
        return frozen(self.local + self.origin, np.float64)

    @cached_property
    def length_of_curve(self) -> np.ndarray:
        """Length of each curve [m], float64 (n_curve,)."""
        steps = [np.diff(self.local[curve], axis=0) for curve in self.curves]
        return np.array([np.linalg.norm(step, axis=1).sum() for step in steps])

    @cached_property
    def length(self) -> float:
        """Total length of all segments [m]."""
        ends = self.local[self.segments]
        return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())

    def between(self, first: str, second: str) -> list[np.ndarray]:
        """Return the curves of two named surfaces as world polylines (n, 3) [m]."""
        for name in (first, second):
            if name not in self.names:
                raise InputError(f"no surface is called {name!r}; there are {list(self.names)}.")
        wanted = sorted((self.names.index(first), self.names.index(second)))
        return [
            self.points[curve]
            for curve, pair in zip(self.curves, self.surfaces_of_curve, strict=True)
            if pair.tolist() == wanted
        ]

    def to_pyvista(self) -> pyvista.PolyData:
        """Return the curves as polylines, with the surface pair as cell data."""
        return polydata(self.points, lines=self.curves)


@dataclass(frozen=True, eq=False)
class VoxelSearch:
    """What the voxels found for two surfaces: material for a picture.

    Attributes
    ----------
    lower, upper : ndarray of float64, shape (3,)
        Corners of the global box, where both surfaces can be [m], world coordinates.
    n_cell : ndarray of int64, shape (3,)
        Number of voxels along each axis.
    size : float
        Edge of a voxel [m].
    occupied : ndarray of int64, shape (n, 3)
        Voxels that hold faces of both surfaces, counted from `lower`.
    faces_a, faces_b : ndarray of int64, shape (n_face,)
        Candidate faces of the first and of the second surface: rows of `triangles`.
    """

    lower: np.ndarray
    upper: np.ndarray
    n_cell: np.ndarray
    size: float
    occupied: np.ndarray
    faces_a: np.ndarray
    faces_b: np.ndarray


@dataclass(frozen=True, eq=False)
class Patches:
    """Surfaces split along their common curves, sharing one vertex per point.

    Attributes
    ----------
    sources : tuple of TriSurface
        The surfaces as they were handed in.
    local : ndarray of float64, shape (n_vertex, 3)
        Vertices in the local frame [m]; `vertices` adds `origin`.
    triangles : ndarray of int64, shape (n_triangle, 3)
        All surfaces, one after the other. Where surfaces coincide, each lists
        the same triangle (the same three vertices).
    surface_of_triangle : ndarray of int64, shape (n_triangle,)
        Row of `sources`.
    parent_of_triangle : ndarray of int64, shape (n_triangle,)
        Row of that surface's own triangles, which this one is a part of.
    patch_of_triangle : ndarray of int64, shape (n_triangle,)
        Connected pieces between curves, numbered from 0 over all surfaces.
    curve_edges : ndarray of int64, shape (n_edge, 2)
        Vertices of the edges along which different surfaces (or more than two
        sheets) meet.
    report : dict
        What was done: cut triangles, children, constructed points, points that
        rounding put in one place, triangles that rounding turned over.
    """

    sources: tuple[TriSurface, ...]
    local: np.ndarray
    origin: np.ndarray
    triangles: np.ndarray
    surface_of_triangle: np.ndarray
    parent_of_triangle: np.ndarray
    patch_of_triangle: np.ndarray
    curve_edges: np.ndarray
    report: dict[str, Any] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the surfaces."""
        return tuple(source.name for source in self.sources)

    @property
    def n_triangle(self) -> int:
        """Number of triangles."""
        return len(self.triangles)

    @property
    def n_patch(self) -> int:
        """Number of patches."""
        return int(self.patch_of_triangle.max(initial=-1)) + 1

    @cached_property
    def vertices(self) -> np.ndarray:
        """World coordinates [m], float64 (n_vertex, 3)."""
        return frozen(self.local + self.origin, np.float64)

    def surface(self, i: int | str) -> TriSurface:
        """Return one surface of the split mesh, by row or by name."""
        i = self._row(i)
        rows = np.flatnonzero(self.surface_of_triangle == i)
        source = self.sources[i]
        return self._part(rows, source.name, source.role)

    def patch(self, i: int) -> TriSurface:
        """Return one patch as a surface of its own."""
        rows = np.flatnonzero(self.patch_of_triangle == i)
        if len(rows) == 0:
            raise InputError(f"there is no patch {i}; patches are 0 to {self.n_patch - 1}.")
        source = self.sources[self.surface_of_triangle[rows[0]]]
        return self._part(rows, f"{source.name} patch {i}", source.role)

    def _row(self, i: int | str) -> int:
        if isinstance(i, str):
            if i not in self.names:
                raise InputError(f"no surface is called {i!r}; there are {list(self.names)}.")
            return self.names.index(i)
        if not 0 <= i < len(self.sources):
            raise InputError(f"there is no surface {i}; rows are 0 to {len(self.sources) - 1}.")
        return i

    def _part(self, rows: np.ndarray, name: str, role: str) -> TriSurface:
        used, faces = np.unique(self.triangles[rows], return_inverse=True)
        return TriSurface(name, role, self.vertices[used], faces.reshape(-1, 3))

    def to_pyvista(self) -> pyvista.PolyData:
        """Return all patches as one `pyvista.PolyData` with labels as cell data."""
        labels = {
            "surface": self.surface_of_triangle,
            "parent": self.parent_of_triangle,
            "patch": self.patch_of_triangle,
        }
        return polydata(self.vertices, triangles=self.triangles, cell_data=labels)
