"""What surfaces do to each other: contacts and curves."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from geosurf.conventions import is_word, known_names, length_text
from geosurf.conventions.card import Card
from geosurf.errors import InputError
from geosurf.model.base import Noun, Shown, frozen, polydata

if TYPE_CHECKING:  # pragma: no cover - types only
    import pyvista


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
            if not is_word(name, self.names):
                raise InputError(
                    f"there is no surface {name!r}. The surfaces are "
                    f"{known_names(self.names, name)}"
                )

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
