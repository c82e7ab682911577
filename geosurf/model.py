"""The nouns that travel between stages: surfaces, curves, patches, units.

All are immutable and hold read-only arrays. Coordinates of inputs are world
metres; results keep local coordinates (`local`, exact to the frame) and an
`origin`, and add the two for people and files (`vertices`, `points`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.errors import InputError, SurfaceError

if TYPE_CHECKING:  # pragma: no cover - types only
    import pyvista
    import xarray

ROLES = ("horizon", "fault", "wall", "surface")


def frozen(array: Any, dtype: Any, shape: tuple[int, ...] | None = None) -> np.ndarray:
    """Return a read-only, C-contiguous array of one dtype (a view where possible)."""
    out = np.ascontiguousarray(array, dtype=dtype)
    if shape is not None:
        out = out.reshape(shape)
    view: np.ndarray = out.view()
    view.flags.writeable = False
    return view


@dataclass(frozen=True, eq=False)
class Lattice:
    """Nodes of a gridded surface, before anyone asks for triangles.

    Attributes
    ----------
    easting, northing : ndarray of float64
        World coordinates [m]: 1-D ``(n_col,)`` and ``(n_row,)`` for an unrotated
        grid, or both 2-D ``(n_row, n_col)`` for rotated and curvilinear ones.
    elevation : ndarray of float64, shape (n_row, n_col)
        [m], positive up; NaN where there is no node.
    rising : bool
        Which diagonal splits each cell: True joins node ``(i, j)`` to
        ``(i + 1, j + 1)``, False ``(i, j + 1)`` to ``(i + 1, j)``.
        `geosurf.conventions.rising_diagonal` is the rule for horizons.
    reverse : bool or None
        How triangles turn. None (horizons): so that normals point up. False:
        from columns to rows; True: from rows to columns (faults, which may be
        vertical, so that the map cannot tell).
    """

    easting: np.ndarray
    northing: np.ndarray
    elevation: np.ndarray
    rising: bool = True
    reverse: bool | None = None

    def __post_init__(self) -> None:
        for key in ("easting", "northing", "elevation"):
            object.__setattr__(self, key, frozen(getattr(self, key), np.float64))

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and columns of nodes."""
        n_row, n_col = self.elevation.shape
        return n_row, n_col

    @cached_property
    def present(self) -> np.ndarray:
        """Mask (n_row, n_col) of the nodes that exist."""
        easting, northing = self.horizontal()
        mask: np.ndarray = (
            np.isfinite(self.elevation) & np.isfinite(easting) & np.isfinite(northing)
        )
        return mask

    @cached_property
    def vertex_of_node(self) -> np.ndarray:
        """Vertex number of each node, int64 (n_row, n_col); -1 where absent."""
        number = np.cumsum(self.present.ravel()) - 1
        return frozen(np.where(self.present, number.reshape(self.shape), -1), np.int64)

    def horizontal(self) -> tuple[np.ndarray, np.ndarray]:
        """Easting and northing of all nodes, each (n_row, n_col)."""
        if self.easting.ndim == 2:
            return self.easting, self.northing
        easting, northing = np.broadcast_arrays(self.easting[None, :], self.northing[:, None])
        return easting, northing

    def build_vertices(self) -> np.ndarray:
        """World coordinates (n_vertex, 3) of the nodes that exist, row by row."""
        easting, northing = self.horizontal()
        keep = self.present
        return np.stack([easting[keep], northing[keep], self.elevation[keep]], axis=1)

    def build_triangles(self) -> np.ndarray:
        """Triangles (n_triangle, 3), cell by cell; normals point up, or as `reverse` says.

        A triangle exists only where its three nodes do.
        """
        number = self.vertex_of_node
        a, b = number[:-1, :-1], number[:-1, 1:]
        d, c = number[1:, :-1], number[1:, 1:]
        pair = ((a, b, c), (a, c, d)) if self.rising else ((a, b, d), (b, c, d))
        faces = np.stack([np.stack(t, axis=-1) for t in pair], axis=2).reshape(-1, 3)
        faces = faces[(faces >= 0).all(axis=1)]
        return faces[:, [0, 2, 1]] if self.turned else faces

    @property
    def turned(self) -> bool:
        """Whether triangles turn from rows to columns."""
        return not self.right_handed if self.reverse is None else self.reverse

    @property
    def right_handed(self) -> bool:
        """Whether columns, rows and up make a right-handed system."""
        if min(self.shape) < 2:
            return True
        x, y = self.easting, self.northing
        if x.ndim == 1:
            return bool((x[-1] > x[0]) == (y[-1] > y[0]))
        cell = (x[:-1, 1:] - x[:-1, :-1]) * (y[1:, :-1] - y[:-1, :-1]) - (
            y[:-1, 1:] - y[:-1, :-1]
        ) * (x[1:, :-1] - x[:-1, :-1])
        return bool(np.nansum(np.sign(cell)) >= 0)


class TriSurface:
    """A triangulated surface.

    Parameters
    ----------
    name : str
        Name of the horizon or fault.
    role : {"horizon", "fault", "wall", "surface"}
        What it is in a model. Decides how units are named, never where curves run.
    vertices : array_like of float, shape (n_vertex, 3)
        Easting, northing, elevation [m], world coordinates. Elevation is positive up.
    triangles : array_like of int, shape (n_triangle, 3)
        Rows of `vertices`. Normals (counter-clockwise) point up for horizons
        and into the hanging wall for faults.
    lattice : Lattice, optional
        The grid that the surface comes from. With it, `vertices` and
        `triangles` may be left out; they are then made when first asked for.
    vertex_data : mapping of str to array_like, optional
        Values on vertices, each ``(n_vertex, ...)``.

    Raises
    ------
    SurfaceError
        If arrays have the wrong shape, values are not finite, or an index is
        out of range.

    Examples
    --------
    >>> ramp = TriSurface("F1", "fault", [[0, 0, 0], [9, 0, 0], [0, 9, 9]], [[0, 1, 2]])
    >>> ramp.n_triangle, ramp.bounds
    (1, (0.0, 9.0, 0.0, 9.0, 0.0, 9.0))
    """

    def __init__(
        self,
        name: str,
        role: str = "surface",
        vertices: Any = None,
        triangles: Any = None,
        *,
        lattice: Lattice | None = None,
        vertex_data: Mapping[str, Any] | None = None,
    ) -> None:
        if role not in ROLES:
            raise SurfaceError(f"surface {name!r}: role is {role!r}, expected one of {ROLES}.")
        self.name = str(name)
        self.role = role
        self.lattice = lattice
        if vertices is None or triangles is None:
            if lattice is None or not (vertices is None and triangles is None):
                raise SurfaceError(
                    f"surface {name!r}: give both vertices and triangles, or a lattice."
                )
        else:
            self.__dict__["vertices"] = _checked_vertices(name, vertices)
            self.__dict__["triangles"] = _checked_triangles(name, triangles, len(self.vertices))
        self.vertex_data: dict[str, np.ndarray] = {}
        for key, value in (vertex_data or {}).items():
            array = np.asarray(value)
            if array.shape[:1] != (len(self.vertices),):
                raise SurfaceError(
                    f"surface {name!r}: vertex_data[{key!r}] has shape {array.shape}, "
                    f"expected ({len(self.vertices)}, ...): one value per vertex."
                )
            self.vertex_data[key] = array

    @cached_property
    def vertices(self) -> np.ndarray:
        """World coordinates [m], float64 (n_vertex, 3)."""
        assert self.lattice is not None
        return frozen(self.lattice.build_vertices(), np.float64)

    @cached_property
    def triangles(self) -> np.ndarray:
        """Rows of `vertices`, int64 (n_triangle, 3)."""
        assert self.lattice is not None
        return frozen(self.lattice.build_triangles(), np.int64)

    @property
    def n_vertex(self) -> int:
        """Number of vertices."""
        return len(self.vertices)

    @property
    def n_triangle(self) -> int:
        """Number of triangles."""
        return len(self.triangles)

    @cached_property
    def bounds(self) -> tuple[float, float, float, float, float, float]:
        """West, east, south, north, bottom, top of the vertices in use [m]."""
        if self.n_triangle == 0:
            raise SurfaceError(f"surface {self.name!r} has no triangles, so it has no bounds.")
        used = self.vertices[np.unique(self.triangles)]
        (w, s, b), (e, n, t) = used.min(axis=0).tolist(), used.max(axis=0).tolist()
        return w, e, s, n, b, t

    def renamed(self, name: str, role: str | None = None) -> TriSurface:
        """Return the same surface under another name, sharing its arrays."""
        twin = TriSurface.__new__(TriSurface)
        twin.__dict__.update(self.__dict__)
        twin.name, twin.role = str(name), self.role if role is None else role
        return twin

    def to_pyvista(self) -> pyvista.PolyData:
        """Return a `pyvista.PolyData` in world coordinates (float64)."""
        return _polydata(self.vertices, triangles=self.triangles, point_data=self.vertex_data)

    def __repr__(self) -> str:
        size = f"{self.n_vertex} vertices, {self.n_triangle} triangles"
        return f"<TriSurface {self.name!r} ({self.role}): {size}>"


def _checked_vertices(name: str, vertices: Any) -> np.ndarray:
    """Float64 (n, 3), finite, or a SurfaceError."""
    try:
        array = np.asarray(vertices, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise SurfaceError(
            f"surface {name!r}: vertices are not numbers ({error}). "
            "Give easting, northing, elevation, shape (n_vertex, 3)."
        ) from error
    if array.ndim != 2 or array.shape[1] != 3:
        raise SurfaceError(
            f"surface {name!r}: vertices have shape {array.shape}, expected (n_vertex, 3): "
            "easting, northing, elevation."
        )
    bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if len(bad):
        raise SurfaceError(
            f"surface {name!r}: {len(bad)} vertices are not finite, the first is vertex "
            f"{bad[0]}: {array[bad[0]].tolist()}. Leave out nodes that are undefined."
        )
    return frozen(array + 0.0, np.float64)


def _checked_triangles(name: str, triangles: Any, n_vertex: int) -> np.ndarray:
    """Int64 (n, 3), in range, or a SurfaceError."""
    array = np.asarray(triangles)
    if array.size == 0:
        array = array.reshape(0, 3).astype(np.int64)
    if array.ndim != 2 or array.shape[1] != 3 or array.dtype.kind not in "iu":
        raise SurfaceError(
            f"surface {name!r}: triangles have dtype {array.dtype} and shape {array.shape}, "
            "expected integers (n_triangle, 3): rows of vertices."
        )
    bad = np.flatnonzero(((array < 0) | (array >= n_vertex)).any(axis=1))
    if len(bad):
        raise SurfaceError(
            f"surface {name!r}: triangle {bad[0]} names vertices {array[bad[0]].tolist()}, but "
            f"there are {n_vertex} (0 to {n_vertex - 1}). Are the indices counted from 1?"
        )
    return frozen(array, np.int64)


@dataclass(frozen=True, eq=False)
class FaultSticks:
    """A fault as interpreters pick it: lines down the fault, side by side.

    Attributes
    ----------
    name : str
    sticks : tuple of ndarray of float64, each (n, 3), n >= 2
        World coordinates [m], elevation positive up, in file order.

    Raises
    ------
    SurfaceError
        If there is no stick, or one is not ``(n >= 2, 3)`` finite numbers.

    Examples
    --------
    >>> FaultSticks("F1", ([[0, 0, 0], [0, 9, -9]], [[9, 0, 0], [9, 9, -9]]))
    <FaultSticks 'F1': 2 sticks, 4 points>
    """

    name: str
    sticks: tuple[np.ndarray, ...]

    def __post_init__(self) -> None:
        if len(self.sticks) == 0:
            raise SurfaceError(f"fault {self.name!r} has no sticks; give at least one.")
        arrays = tuple(frozen(stick, np.float64) for stick in self.sticks)
        for i, stick in enumerate(arrays):
            if stick.ndim != 2 or stick.shape[1] != 3 or len(stick) < 2:
                raise SurfaceError(
                    f"fault {self.name!r}: stick {i} has shape {stick.shape}, expected (n, 3) "
                    "with at least 2 points: easting, northing, elevation."
                )
            if not np.isfinite(stick).all():
                raise SurfaceError(
                    f"fault {self.name!r}: stick {i} has values that are not finite. "
                    "Leave out points that are undefined."
                )
        object.__setattr__(self, "sticks", arrays)

    def __repr__(self) -> str:
        n_point = sum(len(stick) for stick in self.sticks)
        return f"<FaultSticks {self.name!r}: {len(self.sticks)} sticks, {n_point} points>"


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
        return _polydata(self.points, lines=self.curves)


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
        return _polydata(self.vertices, triangles=self.triangles, cell_data=labels)


@dataclass(frozen=True, eq=False)
class Unit:
    """A closed piece of the model: one zone in one fault block.

    Attributes
    ----------
    name : str
        Zone, and the block where faults split the zone.
    zone : str
        ``above Top``, ``Top/Base``, ``below Base``.
    zone_index : int
        0 above the first horizon, counting down.
    block : str
        Sides of the faults that separate it: ``F1+`` is the side into which
        the fault's normal points (the hanging wall of a dipping fault), ``F1-`` the
        other. ``whole`` where no fault separates the zone.
    local : ndarray of float64, shape (n_vertex, 3)
    triangles : ndarray of int64, shape (n_triangle, 3)
        Outward normals.
    surface_of_triangle : ndarray of int64, shape (n_triangle,)
        Row of `surface_names`.
    bounded_by : tuple of str
        Names of the surfaces on its boundary.
    volume, area : float
        [m3], [m2].
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

    @cached_property
    def vertices(self) -> np.ndarray:
        """World coordinates [m], float64 (n_vertex, 3)."""
        return frozen(self.local + self.origin, np.float64)

    @cached_property
    def bounded_by(self) -> tuple[str, ...]:
        """Names of the surfaces that bound the unit."""
        return tuple(self.surface_names[i] for i in np.unique(self.surface_of_triangle))

    def to_pyvista(self) -> pyvista.PolyData:
        """Return the shell as `pyvista.PolyData` with the surface row as cell data."""
        labels = {"surface": self.surface_of_triangle}
        return _polydata(self.vertices, triangles=self.triangles, cell_data=labels)

    def __repr__(self) -> str:
        return f"<Unit {self.name!r}: {self.volume:.6g} m3, {len(self.triangles)} triangles>"


class Units(Mapping[str, Unit]):
    """Units by name, or by ``(zone, block)``, in order: zone by zone, youngest first.

    Parameters
    ----------
    units : iterable of Unit
    box : (west, east, south, north, bottom, top)
        The model box [m].
    report : dict
        What carving found: slits, inner shells, the open rims of faults.
    """

    def __init__(
        self,
        units: Any,
        box: tuple[float, float, float, float, float, float],
        report: dict[str, Any] | None = None,
    ) -> None:
        self._units = {unit.name: unit for unit in units}
        self._by_pair = {(unit.zone, unit.block): unit for unit in self._units.values()}
        self.box = tuple(float(value) for value in box)
        self.report = dict(report or {})

    def __getitem__(self, key: Any) -> Unit:
        found: Unit | None = (
            self._by_pair.get(key) if isinstance(key, tuple) else self._units.get(key)
        )
        if found is None:
            raise KeyError(f"no unit {key!r}; there are {list(self._units)}")
        return found

    def __iter__(self) -> Iterator[str]:
        return iter(self._units)

    def __len__(self) -> int:
        return len(self._units)

    @property
    def volume(self) -> float:
        """Sum of all volumes [m3]."""
        import math

        return math.fsum(unit.volume for unit in self._units.values())

    @property
    def box_volume(self) -> float:
        """Volume of the model box [m3]."""
        w, e, s, n, b, t = self.box
        return (e - w) * (n - s) * (t - b)

    @cached_property
    def table(self) -> xarray.Dataset:
        """Volumes and areas of all units, with units in ``attrs``."""
        import xarray as xr

        units = list(self._units.values())
        footprint = (self.box[1] - self.box[0]) * (self.box[3] - self.box[2])
        columns = {
            "volume": ([u.volume for u in units], "m3", "bulk volume"),
            "area": ([u.area for u in units], "m2", "area of the closed shell"),
            "thickness_mean": (
                [u.volume / footprint for u in units],
                "m",
                "volume over the footprint of the model box",
            ),
        }
        data = {
            key: ("unit", np.array(values, dtype=np.float64), {"units": unit, "long_name": name})
            for key, (values, unit, name) in columns.items()
        }
        labels = {
            "zone": ("unit", np.array([u.zone for u in units], dtype=object)),
            "block": ("unit", np.array([u.block for u in units], dtype=object)),
            "zone_index": ("unit", np.array([u.zone_index for u in units], dtype=np.int64)),
        }
        coords = {"unit": ("unit", np.array([u.name for u in units], dtype=object)), **labels}
        return xr.Dataset(data, coords=coords, attrs={"box": list(self.box), "box_units": "m"})


@dataclass(frozen=True)
class Check:
    """One line of a certificate."""

    name: str
    passed: bool
    value: float
    detail: str


@dataclass(frozen=True)
class Certificate:
    """What `Scene.check` found, line by line.

    Attributes
    ----------
    checks : tuple of Check
    """

    checks: tuple[Check, ...]

    @property
    def ok(self) -> bool:
        """Whether every check passed."""
        return all(check.passed for check in self.checks)

    def __str__(self) -> str:
        width = max((len(check.name) for check in self.checks), default=0)
        return "\n".join(
            f"{'pass' if c.passed else 'FAIL'}  {c.name:<{width}}  {c.detail}" for c in self.checks
        )


def _polydata(
    points: np.ndarray,
    triangles: np.ndarray | None = None,
    lines: tuple[np.ndarray, ...] | None = None,
    point_data: Mapping[str, np.ndarray] | None = None,
    cell_data: Mapping[str, np.ndarray] | None = None,
) -> pyvista.PolyData:
    """A pyvista mesh; pyvista is imported here and nowhere else outside render."""
    import pyvista

    if triangles is not None:
        mesh: pyvista.PolyData = pyvista.PolyData.from_regular_faces(
            np.array(points), np.array(triangles)
        )
    else:
        cells = [np.concatenate([[len(line)], line]) for line in lines or ()]
        mesh = pyvista.PolyData(np.array(points))
        mesh.lines = np.concatenate(cells) if cells else np.empty(0, dtype=np.int64)
        mesh.verts = np.empty(0, dtype=np.int64)
    for key, value in (point_data or {}).items():
        mesh.point_data[key] = value
    for key, value in (cell_data or {}).items():
        mesh.cell_data[key] = value
    return mesh
