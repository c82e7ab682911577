"""Build closed shells from cells, and the units inside them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from geosurf.arrangement.threads import gigabytes, lack_of_room
from geosurf.arrangement.triangles import crossing_pairs
from geosurf.carve.cells import Cells, FullCells
from geosurf.carve.clipped import list_faces
from geosurf.carve.measures import (
    AREA,
    LOOKS_DOWN,
    LOOKS_UP,
    LOWER,
    UPPER,
    VOLUME,
    doubtful_volume,
    exact_volume,
    normals,
)
from geosurf.carve.outside import box_of
from geosurf.carve.zones import WHOLE
from geosurf.conventions import place
from geosurf.errors import GeometryError, InputError, RoundingError
from geosurf.model import Patches, Unit, frozen
from geosurf.model.excerpt import outward_shell
from geosurf.model.pieces import Pieces, by_unit, same_turn
from geosurf.model.regions import RegionFinder
from geosurf.model.units import rows_of_contacts

LISTED = 110  # bytes of memory for each triangle of a unit that is listed, measured


@dataclass(frozen=True)
class Shells:
    """Closed shells of all units.

    Attributes
    ----------
    cells : Cells
    unit_of_cell : ndarray of int64, shape (n_cell + 1,)
    sides : ndarray of int64, shape (n, 2)
        Unit in front of and behind each face; -1 outside.
    volumes : list of float
        [m3].
    thin : list of int
        Units whose volume is not larger than what moving each corner by one unit in the last place
        may do to it, rising.
    """

    cells: Cells
    unit_of_cell: np.ndarray
    sides: np.ndarray
    volumes: list[float]
    thin: list[int] = field(default_factory=list)

    def faces(self, u: int) -> np.ndarray:
        """Faces that a unit has on one side only."""
        rows, first = self._faces_of_units
        return rows[first[u] : first[u + 1]]

    @cached_property
    def _faces_of_units(self) -> tuple[np.ndarray, np.ndarray]:
        return by_unit(self.sides, len(self.volumes))

    def area(self, u: int) -> float:
        """Area of the shell of a unit [m2]."""
        return math.fsum(self.cells.sums[self.faces(u), AREA].ravel().tolist())

    def map_area(self, u: int, without: Sequence[int] = ()) -> float:
        """Area of the upper side of a unit in the map [m2], without some surfaces."""
        rows = self.faces(u)
        rows = rows[~np.isin(self.cells.surface_of[rows], without)]

        # with the unit behind it a face looks outward, with the unit in front it is turned over
        outward = self.sides[rows, 1] == u
        sums = self.cells.sums
        up, down = sums[rows[outward], LOOKS_UP], sums[rows[~outward], LOOKS_DOWN]
        return 0.5 * math.fsum([*up.ravel().tolist(), *down.ravel().tolist()])

    def n_triangle(self, u: int) -> int:
        """Number of triangles of the shell of a unit."""
        return int(self.cells.n_triangles[self.faces(u)].sum())

    def surfaces(self, u: int) -> tuple[str, ...]:
        """Names of the surfaces that a unit has on one side only, in their order."""
        rows = np.unique(self.cells.surface_of[self.faces(u)]).tolist()
        return tuple(self.cells.patches.names[i] for i in rows)

    def corner(self, u: int) -> tuple[float, float, float]:
        """Western, southern and lower bound of a unit, local."""
        west, south, bottom = self.cells.sums[self.faces(u), LOWER].min(axis=0).tolist()
        return west, south, bottom

    def middle(self, u: int) -> tuple[float, float, float]:
        """Middle of the bounds of a unit, in world coordinates."""
        sums, origin = self.cells.sums[self.faces(u)], self.cells.patches.origin
        low, high = sums[:, LOWER].min(axis=0) + origin, sums[:, UPPER].max(axis=0) + origin
        east, north, up = (0.5 * (low + high)).tolist()
        return east, north, up

    def heights(self, u: int) -> tuple[float, float]:
        """Lowest and highest local elevation of a unit [m]."""
        heights = self.cells.heights[self.faces(u)]
        return float(heights[:, 0].min()), float(heights[:, 1].max())

    @cached_property
    def _listed(self) -> _ListedShells:
        """All triangles of all units.

        Raises
        ------
        InputError
            If they need more memory than is free.
        """
        n = sum(map(self.n_triangle, range(len(self.volumes))))
        free = lack_of_room(n * LISTED)
        if free is not None:
            raise InputError(
                f"lists of the {n / 1e6:.3g} million triangles of the units need "
                f"{gigabytes(n * LISTED)} of memory, and {gigabytes(free)} are free. Volumes and "
                "the certificate need no lists. Keep fewer nodes: give coarser grids, or "
                "Scene(tolerance=1.0) where no horizon is torn; or use a larger machine."
            )
        return _ListedShells.of(self.cells.in_full, self.unit_of_cell, len(self.volumes))

    def triangles(self, u: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Vertices, outward triangles and the surface of each triangle of a unit.

        What the unit has on both sides is left out. Triangles start at their lowest corner, and
        they are sorted by corners.
        """
        return self._listed.triangles(u)

    def triangles_of(self, units: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Vertices and outward triangles of some units, as `triangles`; no others are listed."""
        wanted = np.zeros(len(self.sides), dtype=bool)
        wanted[[row for u in units.tolist() for row in self.faces(u).tolist()]] = True
        full = list_faces(self.cells, wanted)
        listed = _ListedShells.of(full, self.unit_of_cell, len(self.volumes))
        for u in units.tolist():
            yield listed.triangles(u)[:2]


@dataclass(frozen=True, eq=False)
class _ListedShells:
    """Triangles of the shells of units, one by one.

    Attributes
    ----------
    x : ndarray of float64, shape (n_vertex, 3)
        Sorted by coordinates, so that shells do not depend on the order of surfaces.
    corners : ndarray of int64, shape (n, 3)
        Rows of `x`.
    surface, front : ndarray of int64, shape (n,)
        Surface of each, and the unit in front of it.
    row, start : ndarray of int64
        As from `by_unit`.
    """

    x: np.ndarray
    corners: np.ndarray
    surface: np.ndarray
    front: np.ndarray
    row: np.ndarray
    start: np.ndarray

    @classmethod
    def of(cls, full: FullCells, unit_of_cell: np.ndarray, n_unit: int) -> _ListedShells:
        """List the shells of cells with a face for every triangle."""
        # rank of each vertex by x, then y, then z: no number of the input is left in the order
        order = np.lexsort(full.x.T[::-1])
        rank = np.empty(len(order), dtype=np.int64)
        rank[order] = np.arange(len(order))
        beside = _units_beside(full, unit_of_cell)
        of_units = by_unit(beside, n_unit)
        return cls(full.x[order], rank[full.triangles], full.surface_of, beside[:, 0], *of_units)

    def triangles(self, u: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Vertices, outward triangles and surfaces of one unit: see `Shells.triangles`."""
        rows = self.row[self.start[u] : self.start[u + 1]]

        # faces with the unit in front look inward
        used, faces, order = outward_shell(self.corners[rows], self.front[rows] == u)
        return self.x[used], faces, self.surface[rows[order]]


def beside_triangles(shells: Shells, number: np.ndarray) -> np.ndarray:
    """Unit in front of and behind each triangle of the patches, int64 (n_triangle, 2); -1 outside.

    Where surfaces coincide, each has the units on its own front and back.

    Parameters
    ----------
    shells : Shells
    number : ndarray of int64, shape (n_unit,)
        What each unit of the shells is called in the result.
    """
    full = shells.cells.in_full
    named = np.concatenate([number, [-1]])
    beside = named[_units_beside(full, shells.unit_of_cell)]

    # triangles that coincide with an earlier one see what that sees, turned as they are turned
    out = np.full((len(full.patches.triangles), 2), -1, dtype=np.int64)
    out[full.row] = beside
    others, first = _twins(full)
    alike = same_turn(full.patches.triangles[others], full.patches.triangles[first])
    out[others] = np.where(alike[:, None], out[first], out[first, ::-1])
    return out


def beside_pieces(shells: Shells, number: np.ndarray) -> tuple[Pieces, np.ndarray]:
    """The pieces of the model, and the unit in front of and behind each, int64 (n_piece, 2).

    -1 is outside; a triangle that coincides with an earlier one has -1 on both sides, since that
    one stands for it. No triangle of a grid is listed.

    Parameters
    ----------
    shells, number
        As for `beside_triangles`.
    """
    cells = shells.cells
    named = np.concatenate([number, [-1]])

    # the last row is for what belongs to no face
    of_face = np.concatenate([named[shells.sides], [[-1, -1]]])
    return cells.pieces, of_face[cells.face_of_element]


def _twins(full: FullCells) -> tuple[np.ndarray, np.ndarray]:
    """Triangles of the patches that have the corners of an earlier one, and these."""
    others, first = full.pieces.coinciding
    if not len(others):
        return others, others
    n = len(full.pieces.triangles)
    row = np.empty(n, dtype=np.int64)
    element = full.pieces.expanded.element
    alone = np.flatnonzero(element < n)  # others are of runs
    row[element[alone]] = alone
    return row[others], row[first]


def _units_beside(cells: Cells, unit_of_cell: np.ndarray) -> np.ndarray:
    return np.where(cells.cell_of_side > 0, unit_of_cell[cells.cell_of_side], -1)


def shells_of(cells: Cells, unit_of_cell: np.ndarray) -> Shells:
    """Close the shell of each unit, given the unit of each cell (-1 outside)."""
    sides = _units_beside(cells, unit_of_cell)
    n_unit = int(unit_of_cell.max(initial=-1)) + 1
    row, first = by_unit(sides, n_unit)

    # the divergence theorem: six times the volume is the sum below outward faces, with sign
    unit = np.repeat(np.arange(n_unit), np.diff(first))
    way = np.where(sides[row, 1] == unit, 1.0, -1.0)
    below = way[:, None] * cells.sums[row, VOLUME]
    parts, ends = below.ravel().tolist(), (below.shape[1] * first).tolist()
    volumes = [math.fsum(parts[begin:end]) / 6.0 for begin, end in pairwise(ends)]
    shells = Shells(cells, unit_of_cell, sides, volumes)
    _sum_exactly(shells)
    return shells


def _sum_exactly(shells: Shells) -> None:
    """Sum up the volumes of the smallest units without error, and note which of them are thin.

    Every cell of the exact arrangement is a cell here, however thin. That of its rounded corners
    has the same sign, since no triangle turns over and nothing crosses; sums of doubles may not.
    """
    bounds = box_of(shells.cells.patches)

    # the last digit of coordinates: a unit thinner than it may be rounding alone
    step = float(np.spacing(np.abs(bounds).max()))
    small = np.flatnonzero(np.array(shells.volumes) <= doubtful_volume(bounds))
    if not len(small):
        return
    for u, (x, triangles) in zip(small.tolist(), shells.triangles_of(small), strict=True):
        shells.volumes[u] = exact_volume(x, triangles)

        # thin: less than a step high over half of its shell
        a, b, c = (x[triangles[:, k]] for k in range(3))
        area = 0.5 * math.fsum(np.sqrt(np.sum(np.square(normals(b - a, c - a)), axis=0)).tolist())
        if shells.volumes[u] <= step * area:
            shells.thin.append(u)


class CarvedUnit(Unit):
    """A unit whose arrays, area and sides of faults are made when they are first requested."""

    _shell: tuple[Shells, int]
    _sides: Callable[[], tuple[str, ...]]

    def __init__(
        self,
        shell: tuple[Shells, int] | None = None,
        sides: Callable[[], tuple[str, ...]] | None = None,
        **fields: Any,
    ) -> None:
        object.__setattr__(self, "_shell", shell)
        object.__setattr__(self, "_sides", sides)
        for name, value in fields.items():
            object.__setattr__(self, name, value)

    @cached_property
    def _arrays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        shells, u = self._shell
        return shells.triangles(u)

    @cached_property
    def fault_sides(self) -> tuple[str, ...]:
        """Sides of faults that it lies on."""
        return self._sides()

    @cached_property
    def region(self) -> str:
        """Part of the field that it belongs to; '' where none is known."""
        regions: RegionFinder | None = self.__dict__.get("_regions")
        return "" if regions is None else regions.found.of(self.zone, self.block)

    def _of_faces(self, name: str, read: Callable[[Shells, int], Any]) -> Any:
        """What is read from faces, where no triangle is listed; else that of a `Unit`."""
        if self._shell is None:  # a copy with other triangles
            return getattr(Unit, name).func(self)
        return read(*self._shell)

    @cached_property
    def bounded_by(self) -> tuple[str, ...]:
        """Names of the surfaces that bound the unit."""
        return self._of_faces("bounded_by", Shells.surfaces)

    @cached_property
    def area(self) -> float:
        """Area of the shell [m2]."""
        shells, u = self._shell
        return shells.area(u)

    @cached_property
    def map_area(self) -> float:
        """Area of its upper side in the map [m2]."""
        return self._of_faces("map_area", Shells.map_area)

    @cached_property
    def zone_map_area(self) -> float:
        """The same where that is not a fluid contact [m2]."""
        contacts = rows_of_contacts(self.surface_names, self.beneath)
        return self._of_faces("zone_map_area", lambda shells, u: shells.map_area(u, contacts))

    @cached_property
    def n_triangle(self) -> int:
        """Number of triangles of the shell."""
        return self._of_faces("n_triangle", Shells.n_triangle)

    @cached_property
    def middle(self) -> tuple[float, float, float]:
        """Easting, northing and elevation of the middle of its bounds [m]."""
        return self._of_faces("middle", Shells.middle)

    @cached_property
    def local(self) -> np.ndarray:
        """Vertices in the scene's frame (n_vertex, 3) [m]."""
        return frozen(self._arrays[0], np.float64)

    @cached_property
    def triangles(self) -> np.ndarray:
        """Rows of `local` (n_triangle, 3), turned outward."""
        return frozen(self._arrays[1], np.int64)

    @cached_property
    def surface_of_triangle(self) -> np.ndarray:
        """The surface that each triangle lies on (n_triangle,)."""
        return frozen(self._arrays[2], np.int64)


def unit_name(zone: str, block: str, contact: str = "") -> str:
    """Zone, the block where faults split the zone, and the contact interval where one counts.

    Examples
    --------
    >>> unit_name("Top/Base", "F1+"), unit_name("Top/Base", WHOLE, "above OWC")
    ('Top/Base F1+', 'Top/Base above OWC')
    """
    return " ".join(word for word in (zone, "" if block == WHOLE else block, contact) if word)


def unit_of_volume(whole: Unit, contact: str, beneath: tuple[str, ...], volume: float) -> Unit:
    """Return a part of a unit by its volume: it has labels, and no shell."""
    kept = ("zone", "zone_index", "block", "compartment_of", "origin", "surface_names")
    part = CarvedUnit(
        name=unit_name(whole.zone, whole.block, contact), contact=contact, beneath=beneath,
        volume=volume, **{key: getattr(whole, key) for key in kept},
    )  # fmt: skip
    part.__dict__["_regions"] = whole.__dict__.get("_regions")
    return part


def turned_inside_out(patches: Patches, shells: Shells, u: int, name: str) -> GeometryError:
    """Say which unit is inside out, by rounding or since a surface crosses itself unsplit."""
    x, triangles, surface = shells.triangles(u)
    where = 0.5 * (x.min(axis=0) + x.max(axis=0)) + patches.origin
    names = [patches.names[i] for i in np.unique(surface).tolist()]
    if len(crossing_pairs(x, triangles)):
        return GeometryError(
            f"unit {name!r} at {place(where)} is inside out: one of {', '.join(names)} "
            "crosses itself and was not split there. Rebuild with self_intersections=True.",
            place=where,
            surfaces=names,
        )
    return RoundingError(
        f"unit {name!r} at {place(where)} is so thin that rounding its vertices to "
        f"float64 turns it inside out. It lies between {', '.join(names)}. Move one of "
        "them slightly.",
        place=where,
        surfaces=names,
    )
