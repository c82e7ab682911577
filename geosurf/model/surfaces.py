"""Surfaces: lattices, triangles, sticks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.errors import SurfaceError
from geosurf.model.base import frozen, polydata

if TYPE_CHECKING:  # pragma: no cover - types only
    import pyvista

ROLES = ("horizon", "fault", "wall", "contact", "surface")


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
    role : {"horizon", "fault", "wall", "contact", "surface"}
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
        return polydata(self.vertices, triangles=self.triangles, point_data=self.vertex_data)

    def __repr__(self) -> str:
        size = f"{self.n_vertex} vertices, {self.n_triangle} triangles"
        return f"<TriSurface {self.name!r} ({self.role}): {size}>"


def _checked_vertices(name: str, vertices: Any) -> np.ndarray:
    """Float64 (n, 3), finite, or a SurfaceError."""
    try:
        if np.iscomplexobj(vertices):
            raise TypeError("complex")
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
