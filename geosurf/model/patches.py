"""Patches: surfaces split along their curves, sharing one vertex per point."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import check_name, counted, is_whole, length_text, number_text, volume_text
from geosurf.conventions.card import Card
from geosurf.errors import InputError
from geosurf.lazy import xarray
from geosurf.model.base import Noun, Shown, frozen, in_crs_of, polydata, tet_grid
from geosurf.model.pieces import FREE, PAIRED, Pieces
from geosurf.model.surfaces import TriSurface

if TYPE_CHECKING:  # pragma: no cover - types only
    import pyvista


# ---- curves ----------------------------------------
# What surfaces do to each other: contacts and curves.


@dataclass(frozen=True, eq=False)
class TriangleSteps(Noun):
    """The textbook's way to the contact of two triangles P and Q (Möller 1997), step by step.

    All numbers are doubles, to look at; `sides` are exact. Where both triangles lie in one plane,
    and where one lies on one side of the other's plane, there is no common line: what belongs to
    it is None or has no rows.

    Attributes
    ----------
    normals : ndarray of float64, shape (2, 3)
        ``(p1 - p0) x (p2 - p0)`` of P, and the same of Q.
    heights : ndarray of float64, shape (2, 3)
        ``n . (corner - first corner of the other)``: corners of P over the plane of Q, then
        corners of Q over the plane of P.
    sides : ndarray of int64, shape (2, 3)
        Exact signs of `heights`: 1 above, -1 below, 0 in the plane.
    rejected : str or None
        ``"P"`` if all corners of P lie on one side of the plane of Q, ``"Q"`` the other way around.
    direction : ndarray of float64, shape (3,), or None
        Unit vector along the common line of both planes, ``n_P x n_Q``.
    cut_points : (ndarray of float64, shape (k, 3), ndarray of float64, shape (m, 3))
        Where the edges of P, and those of Q, meet the common line: 0 to 2 points each.
    intervals : ndarray of float64, shape (2, 2), or None
        Lowest and highest place of the cut points of P, and of those of Q, along `direction` from
        the first cut point of P [m].
    overlap : (float, float) or None
        What both intervals have in common; None where it is empty.
    """

    normals: np.ndarray
    heights: np.ndarray
    sides: np.ndarray
    rejected: str | None
    direction: np.ndarray | None
    cut_points: tuple[np.ndarray, np.ndarray]
    intervals: np.ndarray | None
    overlap: tuple[float, float] | None


@dataclass(frozen=True, eq=False)
class TriangleContact(Noun):
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
    steps : TriangleSteps or None
        The textbook's way to it, if requested.
    """

    kind: str
    points: np.ndarray
    coplanar: bool
    features: tuple[tuple[str, str], ...]
    crossing: bool
    steps: TriangleSteps | None = None


@dataclass(frozen=True, eq=False)
class Touch(Noun):
    """A contact other than a curve: a touching point or an overlap area.

    Attributes
    ----------
    kind : {"point", "area"}
    surfaces : (int, int)
        Rows of `Curves.names`.
    points : ndarray of float64, shape (n, 3)
        World coordinates [m]; one point, or the points of the outline of the overlap; all of its
        vertices where it has none, as of two bodies that are the same.
    area : float
        Overlapping area [m2]; 0 for a point.
    """

    kind: str
    surfaces: tuple[int, int]
    points: np.ndarray
    area: float = 0.0


@dataclass(frozen=True, eq=False)
class Curves(Shown):
    """The curves along which surfaces meet.

    Attributes
    ----------
    names : tuple of str
        Names of the surfaces, in the order in which they were given.
    local : ndarray of float64, shape (n_point, 3)
        Points in the local frame [m]; `points` adds `origin`.
    origin : ndarray of float64, shape (3,)
        World coordinates of the origin of the local frame [m].
    segments : ndarray of int64, shape (n_segment, 2)
        Rows of `points`.
    surfaces_of_segment : ndarray of int64, shape (n_segment, 2)
        The two surfaces (rows of `names`, smaller first) that meet there.
    curves : tuple of ndarray of int64
        Rows of `points`, in order; a closed curve repeats its first row.
    surfaces_of_curve : ndarray of int64, shape (n_curve, 2)
        The two surfaces (rows of `names`, smaller first) that meet there.
    closed : ndarray of bool, shape (n_curve,)
    contacts : tuple of Touch
        Touching points and overlap areas.
    cost : dict
        What it took: numbers of voxels, candidate faces, pairs tested, pairs meeting.
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

    def _card(self) -> Card:
        """Return a row for each pair of surfaces: number of curves and their length."""
        pairs, of = np.unique(np.sort(self.surfaces_of_curve), axis=0, return_inverse=True)
        counts = np.bincount(of.ravel(), minlength=len(pairs))
        lengths = np.bincount(of.ravel(), self.length_of_curve, len(pairs))
        rows = [
            (self.names[a], self.names[b], str(count), length_text(length, 4))
            for (a, b), count, length in zip(pairs, counts, lengths, strict=True)
        ]
        title = f"Curves: {self.n_curve}, {length_text(self.length, 4)}"
        return Card(title, rows, ("surface", "other", "curves", "length"))

    def __repr__(self) -> str:
        # Names tell which model this is; numbers alone would not.
        surfaces = ", ".join(self.names)
        return f"<Curves: {self.n_curve} of {surfaces}, {self.length:.6g} m>"

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
        # in local coordinates: differences of world coordinates lose digits to the northing
        # One polyline at a time: they have different lengths.
        steps = [np.diff(self.local[curve], axis=0) for curve in self.curves]
        return np.array([np.linalg.norm(step, axis=1).sum() for step in steps])

    @cached_property
    def length(self) -> float:
        """Total length of all segments [m]."""
        # Segments count once, however many curves pass them.
        ends = self.local[self.segments]
        return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())

    def between(self, first: str, second: str) -> list[np.ndarray]:
        """Return the curves of two named surfaces.

        Parameters
        ----------
        first, second : str
            Names of two surfaces, in any order; one name twice for where it crosses itself.

        Returns
        -------
        list of ndarray of float64, each (n, 3)
            Polylines in world coordinates [m]; a closed one repeats its first point.

        Raises
        ------
        InputError
            For an unknown name.
        """
        # names first, so that an unknown one is an error and not an empty list
        for name in (first, second):
            check_name(name, self.names, f"there is no surface {name!r}. The surfaces are")

        # pairs are stored with the smaller row first
        wanted = sorted((self.names.index(first), self.names.index(second)))
        # A closed curve repeats its first point, as it is stored.
        return [
            self.points[curve]
            for curve, pair in zip(self.curves, self.surfaces_of_curve, strict=True)
            if pair.tolist() == wanted
        ]

    def to_pyvista(self) -> pyvista.PolyData:
        """Return the curves as polylines.

        Returns
        -------
        pyvista.PolyData
            World coordinates [m]; the rows of both surfaces as cell data ``surfaces``.
        """
        # Rows of `names`, since cell data are numbers.
        labels = {"surfaces": self.surfaces_of_curve}
        return polydata(self.points, lines=self.curves, cell_data=labels, crs=self.crs)


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

    def __repr__(self) -> str:
        return (
            f"<VoxelSearch: {len(self.occupied)} of {int(np.prod(self.n_cell))} voxels of "
            f"{self.size:.6g} m hold faces of both, {len(self.faces_a)} and {len(self.faces_b)}>"
        )


LARGEST_CUBE = 1 << 21  # numbers below it have a cube that fits into int64


class Patches(Shown):
    """Surfaces split along their common curves, sharing one vertex per point.

    Large arrays are computed when they are first used: until then, what no curve touches of a
    gridded surface is only known as runs of its lattice (`Pieces`).

    Parameters
    ----------
    sources : sequence of TriSurface
        The surfaces as they were handed in, or as they were moved where rounding broke a
        triangle (``report["largest_move"]``); slivers that a move shuts are left out.
    local : array_like of float, shape (n_vertex, 3)
        Vertices in the local frame [m]; `vertices` adds `origin`.
    origin : array_like of float, shape (3,)
    triangles : array_like of int, shape (n_triangle, 3)
        All surfaces, one after the other. Where surfaces coincide, each lists
        the same triangle (the same three vertices).
    surface_of_triangle : array_like of int, shape (n_triangle,)
        Row of `sources`.
    parent_of_triangle : array_like of int, shape (n_triangle,)
        Row of that surface's own triangles, which this one is a part of.
    patch_of_triangle : array_like of int, shape (n_triangle,)
        Connected pieces between curves, numbered from 0 over all surfaces.
    curve_edges : array_like of int, shape (n_edge, 2)
        Vertices of the edges along which different surfaces (or more than two
        sheets) meet.
    report : dict, optional
        What was done: cut triangles, children, constructed points, points that
        rounding put in one place, triangles that rounding turned over.
    """

    def __init__(
        self,
        sources: Sequence[TriSurface],
        local: Any,
        origin: Any,
        triangles: Any,
        surface_of_triangle: Any,
        parent_of_triangle: Any,
        patch_of_triangle: Any,
        curve_edges: Any,
        report: dict[str, Any] | None = None,
    ) -> None:
        # Handed in complete: there are no runs, and `pieces` is derived from arrays if it is
        # needed.
        self.sources = tuple(sources)
        self.origin = frozen(origin, np.float64)
        self.report = dict(report or {})
        self.__dict__["local"] = frozen(local, np.float64)

        # straight into the slots of the cached properties: arrays that were handed in win over
        # `pieces`
        for name, value in (
            ("triangles", triangles),
            ("surface_of_triangle", surface_of_triangle),
            ("parent_of_triangle", parent_of_triangle),
            ("patch_of_triangle", patch_of_triangle),
            ("curve_edges", curve_edges),
        ):
            self.__dict__[name] = frozen(value, np.int64)
        in_crs_of(self, self.sources)

    @classmethod
    def of_pieces(
        cls,
        pieces: Pieces,
        curve_edges: np.ndarray | None,
        report: dict[str, Any],
        *,
        rim: np.ndarray | None = None,
    ) -> Patches:
        """Return patches whose arrays are computed on first use.

        Curve edges are given, or by their last half-edges: the `rim`.
        """
        # Without __init__: arrays stay unknown until somebody asks.
        self = cls.__new__(cls)
        self.sources = tuple(pieces.sources)
        self.origin = frozen(pieces.origin, np.float64)
        self.report = dict(report)
        self.__dict__["pieces"] = pieces
        if curve_edges is None:
            self.__dict__["_rim"] = rim
        else:
            self.__dict__["curve_edges"] = frozen(curve_edges, np.int64)
        return in_crs_of(self, self.sources)

    @cached_property
    def curve_edges(self) -> np.ndarray:
        """Vertices of the edges along which surfaces meet, by the first, then by the second."""
        from geosurf.kernels.meshes.mesh import ends_of

        ends, n = ends_of(self.pieces.triangles, self.__dict__["_rim"]), len(self.pieces.x)
        order = np.divmod(np.sort(ends[:, 0] * n + ends[:, 1]), n)
        return frozen(np.stack(order, axis=1), np.int64)

    @cached_property
    def curve_edges_by_surface(self) -> tuple[np.ndarray, ...]:
        """Rows of `curve_edges` that edges of triangles of each surface are, rising."""
        pieces = self.pieces
        n = len(pieces.x)
        keys = self.curve_edges.min(axis=1) * n + self.curve_edges.max(axis=1)
        order = np.argsort(keys)
        keys = keys[order]

        # triangles that touch another surface are in no run; of most no two corners are on curves
        on_curve = np.zeros(n, dtype=bool)
        on_curve[self.curve_edges] = True
        near = np.flatnonzero(np.count_nonzero(on_curve[pieces.triangles], axis=1) >= 2)
        t, surface_of = pieces.triangles[near], pieces.surface[near]
        ends = np.stack([t, np.roll(t, -1, axis=1)], axis=2)
        wanted = ends.min(axis=2) * n + ends.max(axis=2)
        at = np.minimum(np.searchsorted(keys, wanted), max(len(keys) - 1, 0))
        known = keys[at] == wanted if len(keys) else np.zeros(wanted.shape, dtype=bool)
        surface = np.broadcast_to(surface_of[:, None], at.shape)[known]
        rows = order[at[known]]
        owned = (np.unique(rows[surface == i]) for i in range(len(self.sources)))
        return tuple(frozen(mine, np.int64) for mine in owned)

    @cached_property
    def pieces(self) -> Pieces:
        """The same without runs: every triangle by itself."""
        from geosurf.kernels.meshes.mesh import edges

        # keys are cells and halves of a lattice; a triangle surface's own rows are its keys
        parent = self.parent_of_triangle.copy()
        for i, source in enumerate(self.sources):
            if source.lattice is not None:
                mine = self.surface_of_triangle == i
                parent[mine] = source.lattice.keys_of_rows(parent[mine])

        # a half-edge that is alone in its ring is at the rim
        ring, _ = edges(self.triangles, len(self.local))
        alone = ring == np.arange(len(ring))

        # triangles with the same three corners share a group: coinciding surfaces list each of
        # them, and `twin` names the first
        keys = corner_keys(self.triangles, len(self.local))
        _, first, group = np.unique(keys, return_index=True, return_inverse=True)
        return Pieces(
            sources=self.sources,
            origin=self.origin,
            x=self.local,
            triangles=self.triangles,
            surface=self.surface_of_triangle,
            key=parent,
            twin=first[group],
            ring=ring,
            link=np.where(alone, FREE, PAIRED),
            strips=[None] * len(self.sources),
            first_run=np.zeros(len(self.sources) + 1, dtype=np.int64),
            patch=self.patch_of_triangle,
        )

    def changed(self, **arrays: Any) -> Patches:
        """Return the same patches, no runs, with some arrays exchanged."""
        # All that __init__ takes, by the names of the properties.
        names = (
            "sources", "local", "origin", "triangles", "surface_of_triangle",
            "parent_of_triangle", "patch_of_triangle", "curve_edges", "report",
        )  # fmt: skip
        return Patches(**{name: arrays.get(name, getattr(self, name)) for name in names})

    @cached_property
    def local(self) -> np.ndarray:
        """Vertices in the local frame [m], float64 (n_vertex, 3)."""
        return self.pieces.expanded.local

    @cached_property
    def triangles(self) -> np.ndarray:
        """Corners of all triangles, rows of `local`, int64 (n_triangle, 3)."""
        return self.pieces.expanded.triangles

    @cached_property
    def surface_of_triangle(self) -> np.ndarray:
        """Row of `sources` of each triangle, int64 (n_triangle,)."""
        return self.pieces.expanded.surface

    @cached_property
    def parent_of_triangle(self) -> np.ndarray:
        """Row of the input triangle that each is a part of, int64 (n_triangle,)."""
        return self.pieces.expanded.parent

    @cached_property
    def patch_of_triangle(self) -> np.ndarray:
        """Patch of each triangle, int64 (n_triangle,)."""
        return frozen(self.pieces.patch[self.pieces.expanded.element], np.int64)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the surfaces: one tuple, which all units have."""
        return tuple(source.name for source in self.sources)

    @property
    def n_triangle(self) -> int:
        """Number of triangles."""
        # counting lists none
        listed: np.ndarray | None = self.__dict__.get("triangles")
        return self.pieces.expanded.n_triangle if listed is None else len(listed)

    @property
    def n_patch(self) -> int:
        """Number of patches."""
        return self.pieces.n_patch

    @cached_property
    def vertices(self) -> np.ndarray:
        """World coordinates [m], float64 (n_vertex, 3)."""
        return frozen(self.local + self.origin, np.float64)

    def surface(self, i: int | str) -> TriSurface:
        """Return one surface of the split mesh, by row or by name."""
        from geosurf.kernels.meshes.mesh import renumbered

        # of the pieces, so that no other surface is listed
        i = self._row(i)
        source, part = self.sources[i], self.pieces.listed(i)
        used, faces = renumbered(part.triangles)
        found = TriSurface(source.name, source.role, part.local(used) + self.origin, faces)
        return in_crs_of(found, [self])

    def patch(self, i: int) -> TriSurface:
        """Return one patch as a surface of its own."""
        # A wrong number finds no rows, and the message names the range.
        rows = np.flatnonzero(self.patch_of_triangle == i) if is_whole(i) else np.empty(0, int)
        if len(rows) == 0:
            raise InputError(f"there is no patch {i!r}; patches are 0 to {self.n_patch - 1}.")
        source = self.sources[self.surface_of_triangle[rows[0]]]
        return self._part(rows, f"{source.name} patch {i}", source.role)

    def _row(self, i: int | str) -> int:
        if isinstance(i, str):
            check_name(i, self.names, f"there is no surface {i!r}. The surfaces are")
            return self.names.index(i)
        if not is_whole(i) or not 0 <= i < len(self.sources):
            raise InputError(f"there is no surface {i!r}; rows are 0 to {len(self.sources) - 1}.")
        return i

    def _part(self, rows: np.ndarray, name: str, role: str) -> TriSurface:
        # vertices in use, renumbered; sorted, so the same vertex order in each part
        used, faces = np.unique(self.triangles[rows], return_inverse=True)
        part = TriSurface(name, role, self.vertices[used], faces.reshape(-1, 3))
        return in_crs_of(part, [self])

    def _card(self) -> Card:
        """Return a row for each surface: its patches and their triangles."""
        counts = np.bincount(self.surface_of_triangle, minlength=len(self.sources))
        rows = [
            (source.name, source.role, number_text(count))
            for source, count in zip(self.sources, counts.tolist(), strict=True)
        ]
        title = f"Patches: {self.n_patch}, {number_text(self.n_triangle)} triangles"
        return Card(title, rows, ("surface", "role", "triangles"))

    def __repr__(self) -> str:
        surfaces = counted(len(self.sources), "surface")
        return f"<Patches: {self.n_patch} of {surfaces}, {self.n_triangle} triangles>"

    def to_pyvista(self) -> pyvista.PolyData:
        """Return all patches as one `pyvista.PolyData` with labels as cell data."""
        labels = labels_of_triangles(self)
        return polydata(self.vertices, self.triangles, cell_data=labels, crs=self.crs)


def labels_of_triangles(patches: Patches) -> dict[str, np.ndarray]:
    """Return surface, parent and patch of each triangle, as meshes for other programs name them."""
    return {
        "surface": patches.surface_of_triangle,
        "parent": patches.parent_of_triangle,
        "patch": patches.patch_of_triangle,
    }


def corner_keys(t: np.ndarray, n: int) -> np.ndarray:
    """One number for each triangle (n_triangle, 3) of n vertices; equal for equal corners.

    Rows are sorted ten times as slowly as numbers.
    """
    a, b, c = t.T
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    pair = low * n + (a + b + c - low - high)
    if n > LARGEST_CUBE:
        pair = np.unique(pair, return_inverse=True)[1]
    keys: np.ndarray = pair * n + high
    return keys


# ---- tet mesh ----------------------------------------
# Tetrahedra that fill the units of a model.


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
        order = np.argsort(self.region, kind="stable")
        ends = np.cumsum(np.bincount(self.region, minlength=len(self.unit_names)))
        parts = np.split(self.cell_volumes[order], ends[:-1])
        attrs = {"units": "m3", "long_name": "bulk volume"}
        names = {"unit": ("unit", np.array(self.unit_names, dtype=object))}
        # fsum: thin tetrahedra next to large ones lose no digits
        found = np.array([math.fsum(part.tolist()) for part in parts])
        return xarray.DataArray(found, names, "unit", "volume", attrs)

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
