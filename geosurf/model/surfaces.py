"""Surfaces: triangles, sticks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import checked_points, is_word
from geosurf.conventions.axes import COORDINATES
from geosurf.conventions.card import Card
from geosurf.conventions.checks import no_data_in
from geosurf.errors import SurfaceError
from geosurf.model.base import Shown, frozen, in_crs_of, polydata
from geosurf.model.expected import expect, listed, name_of
from geosurf.model.lattice import Lattice
from geosurf.model.torn_lattice import TornLattice

if TYPE_CHECKING:  # pragma: no cover - types only
    import pyvista


# ---- exact ----------------------------------------
# Exact numbers of single triangles, for the few that floating point leaves in doubt.


def exact_normal(corners: np.ndarray) -> tuple[Any, Any, Any]:
    """Return the normal of a triangle, twice as long as its area, without rounding.

    Parameters
    ----------
    corners : ndarray of float64, (3, 3)
        Finite coordinates [m].

    Returns
    -------
    tuple of fractions.Fraction
        ``(b - a) x (c - a)`` [m2]; all are zero if the corners lie on one line.

    Examples
    --------
    >>> exact_normal(np.array([[0.0, 0, 0], [0.5, 0, 0], [0, 3, 1]]))
    (Fraction(0, 1), Fraction(-1, 2), Fraction(3, 2))
    """
    from fractions import Fraction  # loaded by those who ask for exact normals

    # floats are fractions with a power of two below: nothing is rounded from here on
    a, b, c = ([Fraction(value) for value in corner] for corner in corners.tolist())
    u = [q - p for p, q in zip(a, b, strict=True)]
    v = [q - p for p, q in zip(a, c, strict=True)]
    return (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])


# ---- content ----------------------------------------
# A surface as a key of results that are remembered: equal surfaces have equal ones.


_KEPT = "_content"
CUTOFF = "cut-off on "  # and a horizon: vertex data of a fault on the lines of its polygon, 1 and 2


class Content:
    """A surface as a key: equal if name, vertices, triangles and cut-offs of polygons are.

    Examples
    --------
    >>> from geosurf import TriSurface
    >>> corners = [[0, 0, 0], [9, 0, 0], [0, 9, 0]]
    >>> one, two = (Content(TriSurface("F1", "fault", corners, [[0, 1, 2]])) for _ in range(2))
    >>> one == two, hash(one) == hash(two)
    (True, True)
    """

    def __init__(self, surface: TriSurface) -> None:
        self.surface = surface
        # remembered on the surface, with its name: a renamed twin has the same attributes
        known = surface.__dict__.get(_KEPT)
        if known is None or known[0] != surface.name:
            digest = sha256(f"{surface.name} {surface.n_vertex} ".encode())
            digest.update(surface.vertices.data)
            digest.update(surface.triangles.data)
            for key, marks in surface.vertex_data.items():
                if key.startswith(CUTOFF):
                    digest.update(key.encode() + marks.tobytes())
            known = surface.__dict__[_KEPT] = surface.name, digest.digest()
        self.key: bytes = known[1]

    def __hash__(self) -> int:
        return hash(self.key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Content) and self.key == other.key


def cutoffs_among(
    faults: Iterable[TriSurface], horizon: str
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return both lines (n, 3) of the polygons of a horizon, along strike, by fault."""
    cutoffs = {}
    for fault in faults:
        marks = fault.vertex_data.get(CUTOFF + horizon)
        if marks is not None and (marks == 1).any() and (marks == 2).any():
            xy = fault.vertices[marks > 0, :2]
            strike = np.linalg.svd(xy - xy.mean(axis=0), full_matrices=False)[2][0]
            lines = (fault.vertices[marks == number] for number in (1, 2))
            one, two = (line[np.argsort(line[:, :2] @ strike)] for line in lines)
            cutoffs[fault.name] = one, two
    return cutoffs


def cutoffs_kept(fault: TriSurface, vertices: np.ndarray) -> dict[str, np.ndarray]:
    """Return the marks of cut-off lines for other vertices (n, 3): 0 where the fault has none."""
    kept = {}
    for key, marks in fault.vertex_data.items():
        if key.startswith(CUTOFF):
            kept[key] = np.zeros(len(vertices), dtype=np.int8)
            for number in (1, 2):
                kept[key][are_among(vertices, fault.vertices[marks == number])] = number
    return kept


def are_among(points: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return which points (n, 3) are some of others, to the bit."""
    known = set(map(tuple, others.tolist()))
    return np.array([tuple(point) in known for point in points.tolist()], dtype=bool)


ROLES = ("horizon", "fault", "virtual", "wall", "contact", "surface")


@dataclass(frozen=True, eq=False)
class Sector:
    """One of the four wedges between two faults, and the horizon in it as if it had no end.

    Where faults cross closer to a horizon than their throws, a wedge has no piece of the horizon.
    Whether it lies above or below follows from where the horizon would be.

    Attributes
    ----------
    faults : (str, str)
        Names of the faults.
    front : (bool, bool)
        Whether the wedge is on the front of each fault, its hanging wall.
    corner : ndarray of float64, shape (2,)
        Easting and northing of the first node [m].
    step : ndarray of float64, shape (2, 2)
        One column and one row on [m].
    elevation : ndarray of float64, shape (n_row, n_col)
        Of the horizon [m]; NaN where it is not known, such as next to further faults.
    rising : bool
        Which diagonal splits each cell, as in `Lattice`.
    """

    faults: tuple[str, str]
    front: tuple[bool, bool]
    corner: np.ndarray
    step: np.ndarray
    elevation: np.ndarray
    rising: bool

    def at(self, places: np.ndarray) -> np.ndarray:
        """Return the elevation at places in the map.

        Parameters
        ----------
        places : ndarray of float64, shape (n, 2)
            Easting and northing [m].

        Returns
        -------
        ndarray of float64, shape (n,)
            [m]; NaN where it is not known. Beyond the lattice its outermost triangles go on.
        """
        from geosurf.kernels.sheets.moved_rock import heights_on_triangles

        x, y = ((places - self.corner) @ np.linalg.inv(self.step)).T.copy()
        found = np.empty(len(places))
        heights_on_triangles(np.ascontiguousarray(self.elevation), self.rising, x, y, found)
        return found


class TriSurface(Shown):
    """A triangulated surface.

    Its attribute ``crs`` is the coordinate reference system that its grid said, if one did;
    ``sectors`` are wedges between faults with the elevation that a horizon has there.

    Parameters
    ----------
    name : str
        Name of the horizon or fault.
    role : {"horizon", "fault", "virtual", "wall", "contact", "surface"}
        What it is in a model; ``"virtual"`` continues a fault.
        Decides how units are named, never where curves run.
    vertices : array_like of float, shape (n_vertex, 3)
        Easting, northing, elevation [m], world coordinates. Elevation is positive up.
    triangles : array_like of int, shape (n_triangle, 3)
        Rows of `vertices`. Normals (counter-clockwise) point up for horizons
        and into the hanging wall for faults.
    lattice : Lattice, optional
        The grid that the surface comes from. With it, `vertices` and
        `triangles` may be left out; they are then computed on first use.
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
        if not is_word(role, ROLES):
            raise SurfaceError(f"surface {name!r}: role is {role!r}, expected one of {ROLES}.")

        # name before arrays: all messages below use it
        self.name = name = name_of(name, "surface")
        self.role = role
        if lattice is not None:
            expect(lattice, Lattice, f"surface {name!r} takes a Lattice", "geosurf.Lattice is one")
        self.lattice = lattice
        self.checked = False  # whether all triangles are known to have an area
        self.sectors: tuple[Sector, ...] = ()
        self.torn: TornLattice | None = None  # of a torn sheet: the lattice that most of it is

        # lattice without arrays: vertices and triangles follow by rule, when somebody reads them
        if vertices is None or triangles is None:
            if lattice is None or not (vertices is None and triangles is None):
                raise SurfaceError(
                    f"surface {name!r}: pass both vertices and triangles, or a lattice."
                )
        else:
            # into the slot of the cached property, which then never runs
            self.__dict__["vertices"] = _checked_vertices(name, vertices)
            self.__dict__["triangles"] = _checked_triangles(name, triangles, len(self.vertices))
        self.vertex_data: dict[str, np.ndarray] = {}
        if vertex_data is not None:
            self._take_vertex_data(vertex_data)

    def _take_vertex_data(self, given: Any) -> None:
        """Set values on vertices, or raise an error that names the wrong array."""
        how = "give a mapping of names to arrays"
        expect(given, Mapping, f"surface {self.name!r} takes a mapping as vertex_data", how)
        n = len(self.vertices) if "vertices" in self.__dict__ else self.n_vertex
        for key, value in given.items():
            # copied and frozen: vertex data must stay in step with vertices
            array = np.asarray(value)
            if array.shape[:1] != (n,):
                raise SurfaceError(
                    f"surface {self.name!r}: vertex_data[{key!r}] has shape {array.shape}, "
                    f"expected ({n}, ...): one value per vertex."
                )
            self.vertex_data[key] = frozen(np.array(array), array.dtype)

    @cached_property
    def vertices(self) -> np.ndarray:
        """World coordinates [m], float64 (n_vertex, 3)."""
        return frozen(self._by_rule.build_vertices(), np.float64)

    @cached_property
    def triangles(self) -> np.ndarray:
        """Rows of `vertices`, int64 (n_triangle, 3)."""
        return frozen(self._by_rule.build_triangles(), np.int64)

    @property
    def _by_rule(self) -> Lattice:
        """The lattice that arrays follow from: its own, or that of a torn sheet."""
        found = self.torn if self.lattice is None else self.lattice
        assert found is not None
        return found

    @property
    def n_vertex(self) -> int:
        """Number of vertices."""
        # Counting needs no vertices.
        if "vertices" in self.__dict__ and self.lattice is None:
            return len(self.vertices)
        return self._by_rule.n_present

    @property
    def n_triangle(self) -> int:
        """Number of triangles."""
        if "triangles" in self.__dict__ and self.lattice is None:
            return len(self.triangles)
        return self._by_rule.n_triangle

    @cached_property
    def extent(self) -> np.ndarray:
        """South-west and north-east corner around the vertices [m], float64 (2, 2).

        For lattices around all nodes, those without an elevation, too.
        """
        if self.lattice is not None:
            return self.lattice.extent
        x, y = self.vertices[:, 0], self.vertices[:, 1]  # one by one: ten times as fast as rows
        return frozen([[x.min(), y.min()], [x.max(), y.max()]], np.float64)

    def corners_of_keys(self, keys: np.ndarray) -> np.ndarray:
        """Return the corners of triangles.

        Parameters
        ----------
        keys : ndarray of int64, shape (n,)
            Rows of `triangles`; of a surface with a lattice, its keys (`Lattice.corners_of_keys`).

        Returns
        -------
        ndarray of int64, shape (n, 3)
            Rows of `vertices`, or nodes of the lattice.
        """
        if self.lattice is not None:
            return self.lattice.corners_of_keys(keys)
        if self.torn is not None and "triangles" not in self.__dict__:
            nodes = self.torn.corners_of_keys(self.torn.keys_of_rows(keys))
            found: np.ndarray = self.torn.vertex_of_node[nodes]
            return found
        rows: np.ndarray = self.triangles[keys]
        return rows

    def places_of_nodes(self, nodes: np.ndarray) -> np.ndarray:
        """Return where nodes are.

        Parameters
        ----------
        nodes : ndarray of int64, any shape
            As from `corners_of_keys`.

        Returns
        -------
        ndarray of float64, shape (..., 3)
            World coordinates [m].
        """
        if self.lattice is not None:
            return self.lattice.places_of_nodes(nodes)
        if self.torn is not None and "vertices" not in self.__dict__:
            return self.torn.places_of_nodes(self.torn.node_of_vertex[nodes])
        places: np.ndarray = self.vertices[nodes]
        return places

    def rows_of_keys(self, keys: np.ndarray) -> np.ndarray:
        """Return the rows of `triangles` that keys stand for.

        Parameters
        ----------
        keys : ndarray of int64, shape (n,)
            As for `corners_of_keys`.

        Returns
        -------
        ndarray of int64, shape (n,)
        """
        return keys if self.lattice is None else self.lattice.rows_of_keys(keys)

    @cached_property
    def bounds(self) -> tuple[float, float, float, float, float, float]:
        """West, east, south, north, bottom, top of the vertices in use [m].

        Raises
        ------
        SurfaceError
            If the surface has no triangles.
        """
        if self.n_triangle == 0:
            raise SurfaceError(f"surface {self.name!r} has no triangles and therefore no bounds.")

        # all nodes in use: the box that the survey has, no pass over the vertices
        listed = self.lattice is None and "triangles" in self.__dict__
        used = None if listed else self._by_rule.corners_in_use()
        if used is None:
            # vertices that no triangle uses do not count
            in_use = np.zeros(len(self.vertices), dtype=bool)
            in_use[self.triangles] = True
            used = self.vertices[in_use]
        (w, s, b), (e, n, t) = used.min(axis=0).tolist(), used.max(axis=0).tolist()
        return w, e, s, n, b, t

    def renamed(self, name: str, role: str | None = None) -> TriSurface:
        """Return the same surface under another name, sharing its arrays.

        Parameters
        ----------
        name : str
        role : str, optional
            As for `TriSurface`; default: its present role.

        Returns
        -------
        TriSurface

        Raises
        ------
        InputError
            If the name is not text, or is empty.
        """
        # same arrays, and the same checks: nothing is computed again
        twin = TriSurface.__new__(TriSurface)
        twin.__dict__.update(self.__dict__)
        twin.name, twin.role = name_of(name, self.role), self.role if role is None else role
        return twin

    def lifted(self, change: Callable[[np.ndarray], np.ndarray]) -> TriSurface:
        """Return the surface with changed elevations [m] of nodes or vertices; a grid stays one."""
        if self.lattice is not None:
            lattice = self.lattice.with_elevation(change(self.lattice.elevation))
            made = TriSurface(self.name, self.role, lattice=lattice)
        else:
            vertices = np.column_stack([self.vertices[:, :2], change(self.vertices[:, 2])])
            made = TriSurface(self.name, self.role, vertices, self.triangles)
        return in_crs_of(made, [self])

    def to_pyvista(self) -> pyvista.PolyData:
        """Return the surface as a mesh of pyvista.

        Returns
        -------
        pyvista.PolyData
            World coordinates [m], float64; `vertex_data` as point data.
        """
        return polydata(self.vertices, self.triangles, point_data=self.vertex_data, crs=self.crs)

    def _card(self) -> Card:
        """Return size, extent and reference system."""
        rows = [("vertices", f"{self.n_vertex}"), ("triangles", f"{self.n_triangle}")]
        if self.n_triangle:
            sides = self.bounds
            for k, axis in enumerate(COORDINATES):
                low, high = sides[2 * k : 2 * k + 2]
                rows.append((axis, f"{low:.2f} to {high:.2f} m"))
        rows.append(("reference system", self.crs or "not stated"))
        return Card(f"{self.role.capitalize()} {self.name}", rows)

    def __repr__(self) -> str:
        size = f"{self.n_vertex} vertices, {self.n_triangle} triangles"
        return f"<TriSurface {self.name!r} ({self.role}): {size}>"


def torn_sheet(
    name: str, torn: TornLattice, vertex_data: Mapping[str, Any], role: str = "horizon"
) -> TriSurface:
    """A torn sheet as a list of triangles, which is made when it is read."""
    made = TriSurface(name, role, lattice=torn, vertex_data=vertex_data)
    made.lattice, made.torn = None, torn
    return made


def _checked_vertices(name: str, vertices: Any) -> np.ndarray:
    """Float64 (n, 3), finite, or a SurfaceError."""
    what = f"surface {name!r}: the array of vertices"
    how = "Give easting, northing, elevation, shape (n_vertex, 3)."
    return frozen(checked_points(vertices, what, how, error=SurfaceError), np.float64)


def _checked_triangles(name: str, triangles: Any, n_vertex: int) -> np.ndarray:
    """Int64 (n, 3), in range, or a SurfaceError."""
    try:
        array = np.asarray(triangles)
    except ValueError as error:
        raise SurfaceError(
            f"surface {name!r}: triangles are rows of several lengths, expected integers "
            "(n_triangle, 3): rows of vertices."
        ) from error

    # an empty list is float64 for numpy
    if array.size == 0:
        array = array.reshape(0, 3).astype(np.int64)
    if array.ndim != 2 or array.shape[1] != 3 or array.dtype.kind not in "iu":
        raise SurfaceError(
            f"surface {name!r}: triangles have dtype {array.dtype} and shape {array.shape}, "
            "expected integers (n_triangle, 3): rows of vertices."
        )

    # once over all, and only in an error once over rows
    if array.size and not (array.min() >= 0 and array.max() < n_vertex):
        bad = np.flatnonzero(((array < 0) | (array >= n_vertex)).any(axis=1))
        raise SurfaceError(
            f"surface {name!r}: triangle {bad[0]} refers to vertices {array[bad[0]].tolist()}, "
            f"but there are {n_vertex} (0 to {n_vertex - 1}). Are the indices counted from 1?"
        )
    # what a caller can still write to is copied: trees and vertices rest on it
    return frozen(array.copy() if array.flags.writeable else array, np.int64)


def points_of_stick(stick: Any, what: str) -> np.ndarray:
    """Points (n, 3) of one stick, two or more; or a SurfaceError."""
    how = "Give easting, northing, elevation per point; join single points to a stick."
    return checked_points(stick, what, how, least=2, error=SurfaceError)


@dataclass(frozen=True, eq=False)
class FaultSticks(Shown):
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
        object.__setattr__(self, "name", name_of(self.name, "fault"))
        sticks = listed(self.sticks, "FaultSticks takes sticks", "give arrays (n_point, 3)")
        if len(sticks) == 0:
            raise SurfaceError(f"fault {self.name!r} has no sticks; give at least one.")
        arrays = []
        for i, stick in enumerate(sticks):
            what = f"fault {self.name!r}: stick {i}"
            arrays.append(frozen(points_of_stick(stick, what), np.float64))
            if absent := no_data_in(arrays[-1]):
                raise SurfaceError(
                    f"fault {self.name!r}: point {absent[0] + 1} of stick {i} has {absent[1]:g}, a "
                    "usual mark of no data. Leave that point out, or correct it."
                )
        object.__setattr__(self, "sticks", tuple(arrays))

    def __repr__(self) -> str:
        n_point = sum(len(stick) for stick in self.sticks)
        return f"<FaultSticks {self.name!r}: {len(self.sticks)} sticks, {n_point} points>"
