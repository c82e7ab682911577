"""The facts of a certificate: what is read from a model as it is stored, runs of lattices as runs.

An element is a triangle, or a run of lattice triangles that no curve touches. Triangles with a
corner that other elements have, too, are listed; edges, vertices, sums and pairs of all others
follow from their lattice (`certificate_runs`). A model of triangles alone has no runs: all of it is
listed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geosurf.arrangement.threads import map_threads
from geosurf.carve.certificate_runs import LatticeRuns, height_in_map, lengths_of, read_runs
from geosurf.carve.certificate_shells import Matched, number_corners, rows_on
from geosurf.carve.outside import box_of
from geosurf.errors import InputError
from geosurf.kernels.lattices.sets import distinct, first_rows
from geosurf.kernels.lattices.strips import lowest_keys
from geosurf.kernels.meshes.checks import (
    AREA,
    LOWER,
    N_SUM,
    RISE,
    SIDES,
    UPPER,
    copies_of_parents,
    sums_of_triangles,
)
from geosurf.kernels.meshes.mesh import edge_keys, edges
from geosurf.kernels.search.tree import faces_in_box, triangle_boxes
from geosurf.model import Patches, TriSurface
from geosurf.model.excerpt import Boxes
from geosurf.model.pieces import Pieces, corners_of
from geosurf.model.torn_lattice import TornLattice

_COMPARED_AT_ONCE = (
    1 << 17
)  # triangles that are compared with their input triangles, of several surfaces
_MANY_RUNS = 1000  # of all lattices, from which they are read in two threads
_MOST_BOXES = 1 << 26  # rays times triangles, up to which the boxes of all are compared
_SLIP = 1e-3  # [m] around boxes and rays; far more than rounding in a frame moves them by


@dataclass(frozen=True, eq=False)
class Facts:
    """What the checks of a certificate read.

    Attributes
    ----------
    patches : Patches
    pieces : Pieces
        Its triangles are the first elements, and the first that are listed.
    cut : ndarray of int64, shape (n_surface + 1,)
        First triangle of each surface among those of the pieces.
    lattices : list of LatticeRuns
    level : float
        Local elevation that volumes are measured from [m].
    local : ndarray of float64, shape (n_vertex, 3)
    triangles : ndarray of int64, shape (n_listed, 3)
        Triangles that are listed: those of the pieces, then those in runs that have a corner in
        common with others.
    element : ndarray of int64, shape (n_listed,)
        The element that each is a part of.
    n_shared : int
        Vertices up to this one belong to triangles that are all listed.
    ring : ndarray of int64, shape (3 * n_listed,)
        Next half-edge around the same edge.
    keys : (ndarray, ndarray, int)
        Number of the corners of each triangle of the pieces, whether these go round in rising
        order, and how many numbers there are.
    """

    patches: Patches
    pieces: Pieces
    cut: np.ndarray
    lattices: list[LatticeRuns]
    level: float
    local: np.ndarray
    triangles: np.ndarray
    element: np.ndarray
    n_shared: int
    ring: np.ndarray
    keys: tuple[np.ndarray, np.ndarray, int]

    @classmethod
    def of(cls, patches: Patches) -> Facts | None:
        """The facts of a rebuilt mesh; None if its runs are not what these depend on.

        Patches without runs always have facts.
        """
        pieces: Pieces = patches.pieces
        if (np.diff(pieces.surface) < 0).any():
            raise InputError("patches list their triangles surface by surface; sort these.")
        cut = np.searchsorted(pieces.surface, np.arange(len(pieces.sources) + 1))
        level = _level(patches, pieces)
        tasks = [
            (pieces, i, pieces.key[cut[i] : cut[i + 1]], strips, level)
            for i, strips in enumerate(pieces.strips)
            if strips is not None
        ]
        many = bool(pieces.first_run[-1] > _MANY_RUNS)
        lattices = map_threads(read_runs, tasks, worth=many)
        if any(runs is None for runs in lattices):
            return None
        n = len(pieces.triangles)
        local, triangles, n_shared = _listed(pieces, lattices)
        elements = (runs.first + runs.run_of(runs.listed) for runs in lattices)
        element = np.concatenate([np.arange(n), *elements])
        ring, _ = edges(triangles, len(local))
        if _runs_meet_others(len(local), triangles, element, ring, n):
            return None

        # a triangle of a run with the corners of another triangle: both have to be compared
        key, rising, n_key = number_corners(triangles, len(local))
        n_key_of_pieces = int(key[:n].max(initial=-1)) + 1
        if n_key - n_key_of_pieces < len(triangles) - n:
            return None
        keys = key[:n], rising[:n], n_key_of_pieces
        return cls(
            patches, pieces, cut, lattices, level, local, triangles, element, n_shared, ring, keys
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the surfaces."""
        return self.patches.names

    @property
    def sources(self) -> tuple[TriSurface, ...]:
        """Surfaces."""
        return self.patches.sources

    def rows_of(self, role: str) -> list[int]:
        """Surfaces of one role."""
        return [i for i, source in enumerate(self.sources) if source.role == role]

    @cached_property
    def surface_of_triangle(self) -> np.ndarray:
        """Surface of each element."""
        of_runs = (np.full(len(runs.n_node), runs.surface) for runs in self.lattices)
        return np.concatenate([self.pieces.surface, *of_runs])

    @cached_property
    def n_triangle(self) -> np.ndarray:
        """Number of triangles of each element."""
        listed = np.ones(len(self.pieces.triangles), dtype=np.int64)
        return np.concatenate([listed, *(lengths_of(runs.strips) for runs in self.lattices)])

    @cached_property
    def bounds_of_runs(self) -> np.ndarray:
        """Lower, then upper corner of each run, local, float64 (n_run, 6)."""
        bounds = (runs.sums[:-1, LOWER.start : UPPER.stop] for runs in self.lattices)
        return np.concatenate([np.empty((0, 6)), *bounds])

    @cached_property
    def within(self) -> np.ndarray:
        """Whether all corners of each element are within the bounds of the walls."""
        low, high = _bounds(self.patches)
        x, t, bounds = self.pieces.x, self.pieces.triangles, self.bounds_of_runs
        inside = ((x >= low) & (x <= high)).all(axis=1)
        of_runs = (bounds[:, :3] >= low).all(axis=1) & (bounds[:, 3:] <= high).all(axis=1)
        return np.concatenate([inside[t[:, 0]] & inside[t[:, 1]] & inside[t[:, 2]], of_runs])

    @cached_property
    def _sums(self) -> np.ndarray:
        """Sums over the triangles of the pieces of each surface: beyond the walls, and within."""
        n = len(self.pieces.triangles)
        row = 2 * self.pieces.surface + self.within[:n]
        sums = np.zeros((2 * len(self.sources), N_SUM))
        sums_of_triangles(self.pieces.x, self.pieces.triangles, row, self.level, sums)
        return sums.reshape(-1, 2, N_SUM)

    @cached_property
    def rise(self) -> np.ndarray:
        """Twice the area of each surface in the map, of what is within the bounds of the walls;
        below 0 where normals look down [m2].
        """
        rise: np.ndarray = self._sums[:, 1, RISE].copy()
        for of_lattice in self.lattices:
            is_within = self.within[of_lattice.runs]
            rise[of_lattice.surface] += of_lattice.sums[:-1, RISE][is_within].sum()
        return rise

    @cached_property
    def joined(self) -> np.ndarray:
        """Runs with a common edge that no other triangle has, int64 (n, 2)."""
        pairs = [np.empty((0, 2), dtype=np.int64)]
        for of_lattice in self.lattices:
            runs = of_lattice.borders[:, :2]
            pairs.append(of_lattice.first + runs[(runs >= 0).all(axis=1)])
        return np.concatenate(pairs)

    def matched(self, sides: np.ndarray, named: np.ndarray) -> Matched:
        """Elements of shells among those of the patches; `sides` and `named` as of `sides_of`."""
        n, n_element = len(self.pieces.triangles), len(sides)

        # runs have a corner that no other element has: each has a key of its own
        key, rising, n_key = self.keys
        n_key_of_all = n_key + n_element - n
        key = np.concatenate([key, n_key + np.arange(n_element - n)])
        turn = np.concatenate([rising, np.zeros(n_element - n, dtype=bool)])
        bounds_units = sides[:, 0] != sides[:, 1]
        elements, units, turns = [], [], []
        for side in range(2):
            on_side = np.flatnonzero(bounds_units & (sides[:, side] >= 0))
            elements.append(on_side)
            units.append(sides[on_side, side])
            turns.append(turn[on_side] == (side == 1))
        element, unit, turned = map(np.concatenate, (elements, units, turns))
        order = np.argsort(unit, kind="stable")
        element, unit, turned = element[order], unit[order], turned[order]
        surface = named[element]
        row = rows_on(self.surface_of_triangle, key, surface, key[element], n_key_of_all)
        behind = turned == turn[row]
        return Matched(
            unit, surface, key[element], row, behind, turned, key, turn, n_key_of_all,
            self.n_triangle[element], lambda i: self.middle_of(element[i : i + 1]),
        )  # fmt: skip

    def corners_of_unit(self, sides: np.ndarray, unit: int) -> np.ndarray:
        """Corners (n, 3, 3) of the shell of a unit, turned outward."""
        shell = np.flatnonzero((sides == unit).any(axis=1) & (sides[:, 0] != sides[:, 1]))
        listed = shell[shell < len(self.pieces.triangles)]
        corners, elements = [self.pieces.x[self.pieces.triangles[listed]]], [listed]
        for lattice_runs in self.lattices:
            keys, row = lattice_runs.strips.keys_of(lattice_runs.rows_of(shell))
            corners.append(lattice_runs.corners(keys, self.patches.origin))
            elements.append(lattice_runs.first + row)
        every, inward = np.concatenate(corners), sides[np.concatenate(elements), 0] == unit
        every[inward] = every[inward][:, [0, 2, 1]]
        return every

    def middle_of(self, element: np.ndarray) -> np.ndarray:
        """The middle of the first triangle of an element (1,)."""
        return self.first_corners(element)[0].mean(axis=0) + self.patches.origin

    def first_corners(self, elements: np.ndarray) -> np.ndarray:
        """Corners (n, 3, 3) of the triangle with the lowest key of each of some elements, which
        rise.
        """
        listed = elements[elements < len(self.pieces.triangles)]
        corners = [self.pieces.x[self.pieces.triangles[listed]]]
        for lattice_runs in self.lattices:
            runs = lattice_runs.strips.runs[lattice_runs.rows_of(elements)]
            keys = lowest_keys(lattice_runs.strips.places, runs)
            corners.append(lattice_runs.corners(keys, self.patches.origin))
        return np.concatenate(corners)

    def triangles_near(
        self, starts: np.ndarray, wanted: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Triangles of wanted elements that rays along axes from some elements may meet.

        Parameters
        ----------
        starts : ndarray of int64
            Elements that rays start from: wanted ones.
        wanted : ndarray of bool, shape (n,)

        Returns
        -------
        x, triangles, element : ndarray
        first : ndarray of int64
            The triangle that each ray starts from.
        """
        # a ray runs along the axis on which its first triangle is widest
        at_start = self.first_corners(distinct(starts))
        low, high = at_start.min(axis=1) - _SLIP, at_start.max(axis=1) + _SLIP
        boxes = np.concatenate([low, high], axis=1)
        a, b, c = (at_start[:, k] for k in range(3))
        ray, axes = np.arange(len(at_start)), np.abs(np.cross(b - a, c - a)).argmax(axis=1)
        boxes[ray, axes], boxes[ray, 3 + axes] = -np.inf, np.inf

        # most triangles are far from all rays; those of many rays and triangles are all taken
        x, t = self.pieces.x, self.pieces.triangles
        listed = np.flatnonzero(wanted[: len(t)])
        if len(boxes) * len(listed) <= _MOST_BOXES:
            around = triangle_boxes(x, t[listed])
            listed = listed[distinct(*(faces_in_box(around, box) for box in boxes))]
        corners, elements = [x[t[listed]]], [listed]
        for of_lattice, keys, runs in self._runs_near(boxes, wanted):
            corners.append(of_lattice.corners(keys, self.patches.origin))
            elements.append(runs)
        x, element = np.concatenate(corners).reshape(-1, 3), np.concatenate(elements)
        first = first_rows(element, len(wanted))[starts]
        return x, np.arange(len(x)).reshape(-1, 3), element, first

    def _runs_near(
        self, boxes: np.ndarray, wanted: np.ndarray
    ) -> Iterator[tuple[LatticeRuns, np.ndarray, np.ndarray]]:
        """Lattices, the keys of their triangles in wanted runs near boxes, and the runs."""
        low, high = self.bounds_of_runs[:, :3], self.bounds_of_runs[:, 3:]
        is_near = np.zeros(len(low), dtype=bool)
        for box in boxes:
            is_near |= ((low <= box[3:]) & (high >= box[:3])).all(axis=1)
        first_run = len(self.pieces.triangles)
        is_near &= wanted[first_run:]
        world = boxes + np.tile(self.patches.origin, 2)
        region = Boxes(world[:, :2] - _SLIP, world[:, 3:5] + _SLIP)
        for lattice_runs in self.lattices:
            first = lattice_runs.first - first_run
            near_runs = is_near[first : first + len(lattice_runs.strips.runs)]
            if near_runs.any():
                cells = region.cells(lattice_runs.lattice)
                keys = np.stack([2 * cells, 2 * cells + 1], axis=1).ravel()
                run = lattice_runs.run_of(keys)
                rows = np.flatnonzero((run >= 0) & near_runs[run])
                yield lattice_runs, keys[rows], lattice_runs.first + run[rows]

    def new_triangles(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Rows of listed triangles that are not copies of their input triangle, and its corners.

        Some surfaces at once, in their order. Triangles in runs are copies: their corners are read
        from the lattice.
        """
        pieces, first = self.pieces, 0
        while first < len(pieces.sources):
            last = int(np.searchsorted(self.cut, self.cut[first] + _COMPARED_AT_ONCE, "right")) - 1
            last = min(max(last, first + 1), len(pieces.sources))
            parent = np.concatenate([self._parents(i) for i in range(first, last)])
            rows = np.arange(self.cut[first], self.cut[last])
            new = ~copies_of_parents(pieces.x, pieces.triangles[rows], parent.reshape(-1, 9))
            yield rows[new], parent[new]
            first = last

    def _parents(self, i: int) -> np.ndarray:
        """Local corners (n, 3, 3) of the input triangles of the listed triangles of a surface."""
        keys = self.pieces.key[self.cut[i] : self.cut[i + 1]]
        return corners_of(self.sources[i], keys, self.patches.origin)

    def copies_of(self, i: int) -> np.ndarray:
        """Rows of listed triangles of a surface that are parts of copies at tears: these may lie
        over others.
        """
        lattice = self.sources[i].lattice
        if not isinstance(lattice, TornLattice):
            return np.empty(0, dtype=np.int64)
        keys = self.pieces.key[self.cut[i] : self.cut[i + 1]]
        return self.cut[i] + np.flatnonzero(keys >= lattice.n_key)

    @property
    def height(self) -> float:
        """Smallest height in the map of a triangle of a run that is not listed; infinite if there
        is none.
        """
        heights = (height_in_map(runs.lattice) for runs in self.lattices if runs.graph)
        return min(heights, default=math.inf)

    def areas(self) -> list[tuple[float, float, float]]:
        """Area of each surface, that of its input, and the sum of all sides of its triangles."""
        runs_of = {runs.surface: runs for runs in self.lattices}
        areas = []
        for i, source in enumerate(self.sources):
            runs, listed = runs_of.get(i), self._sums[i]
            if runs is None:
                x, in_runs = source.vertices - self.patches.origin, np.empty((0, N_SUM))
                area_of_input = self._area_of(x, source.triangles)
            else:
                in_runs, area_of_input = runs.sums[:-1], self._area_of_input(runs)
            rim = float(listed[:, SIDES].sum() + in_runs[:, SIDES].sum())
            areas.append((_area(np.concatenate([listed, in_runs])), area_of_input, rim))
        return areas

    def _area_of_input(self, runs: LatticeRuns) -> float:
        """Area of a lattice [m2]; copies at its tears are in the place of what is gone."""
        area = _area(runs.sums)
        if isinstance(runs.lattice, TornLattice):
            for sign, keys in ((1, runs.lattice.keys_of_copies), (-1, runs.lattice.gone)):
                x = runs.corners(keys, self.patches.origin).reshape(-1, 3)
                area += sign * self._area_of(x, np.arange(len(x)).reshape(-1, 3))
        return area

    def _area_of(self, x: np.ndarray, triangles: np.ndarray) -> float:
        """Area of some triangles [m2]."""
        sums, row = np.zeros((1, N_SUM)), np.zeros(len(triangles), dtype=np.int64)
        sums_of_triangles(x, triangles, row, self.level, sums)
        return _area(sums)


def _area(sums: np.ndarray) -> float:
    """The area that some rows of sums have [m2]."""
    return 0.5 * math.fsum(sums[:, AREA].ravel().tolist())


def _bounds(patches: Patches) -> np.ndarray:
    """The model box (2, 3), local; all of space if the mesh has no walls."""
    if any(source.role == "wall" for source in patches.sources):
        return box_of(patches)
    return np.array([[-np.inf] * 3, [np.inf] * 3])


def _level(patches: Patches, pieces: Pieces) -> float:
    """Local elevation that volumes are measured from: amid the model."""
    low, high = _bounds(patches)[:, 2].tolist()
    if math.isfinite(low):
        return 0.5 * (low + high)
    return float(pieces.x[:, 2].mean()) if len(pieces.x) else 0.0


def _listed(pieces: Pieces, lattices: list[LatticeRuns]) -> tuple[np.ndarray, np.ndarray, int]:
    """Vertices and triangles: of the pieces, and those of runs that have a shared corner; and how
    many vertices there are before the private ones, which come last.
    """
    n_vertex, places, triangles_of_runs = len(pieces.x), [pieces.x], []
    for runs in lattices:
        corners = runs.lattice.corners_of_keys(runs.listed)
        used = np.zeros(runs.lattice.n_node, dtype=bool)
        used[corners] = True
        vertex = np.full(runs.lattice.n_node, -1)
        vertex[runs.strips.nodes] = runs.strips.points
        new = np.flatnonzero(used & runs.shared & (vertex < 0))
        vertex[new] = n_vertex + np.arange(len(new))
        n_vertex += len(new)
        places.append(runs.lattice.places_of_nodes(new) - pieces.origin)
        private = np.flatnonzero(used & ~runs.shared)
        triangles_of_runs.append((runs.lattice, corners, private, vertex))
    n_shared, triangles = n_vertex, [pieces.triangles]
    for lattice, corners, private, vertex in triangles_of_runs:
        vertex[private] = n_vertex + np.arange(len(private))
        n_vertex += len(private)
        places.append(lattice.places_of_nodes(private) - pieces.origin)
        triangles.append(vertex[corners])
    return np.concatenate(places), np.concatenate(triangles), n_shared


def _runs_meet_others(
    n_vertex: int, triangles: np.ndarray, element: np.ndarray, ring: np.ndarray, first_run: int
) -> bool:
    """Whether an edge between two triangles of one run belongs to other triangles, too."""
    # half-edges of runs whose edge has three triangles or more
    half = np.flatnonzero(ring[ring] != np.arange(len(ring)))
    half = half[element[half // 3] >= first_run]
    run = element[half // 3]
    edge = edge_keys(triangles[half // 3], n_vertex).reshape(-1, 3)
    edge = edge[np.arange(len(half)), half % 3]
    order = np.lexsort((run, edge))
    are_of_one_run = (np.diff(edge[order]) == 0) & (np.diff(run[order]) == 0)
    return bool(are_of_one_run.any())
