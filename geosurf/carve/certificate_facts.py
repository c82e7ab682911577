"""The facts of a certificate: what is read from a model as it is stored, runs of lattices as runs.

An element is a triangle, or a run of lattice triangles that no curve touches. Triangles with a
corner that other elements have, too, are listed; edges, vertices, sums and pairs of all others
follow from their lattice. A model of triangles alone has no runs: all of it is listed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geosurf.arrangement.threads import map_threads
from geosurf.carve.certificate_shells import (
    VERTICES,
    Matched,
    count_borders,
    number_corners,
    rows_on,
)
from geosurf.carve.outside import box_of
from geosurf.errors import InputError
from geosurf.kernels.lattices.sets import distinct, first_rows
from geosurf.kernels.lattices.strips import FIRST, LAST, ROW, lowest_keys, runs_of_keys
from geosurf.kernels.meshes.checks import N_SUM, copies_of_parents, sums_of_runs, sums_of_triangles
from geosurf.kernels.meshes.mesh import edge_keys, edges, number_keys
from geosurf.kernels.search.tree import faces_in_box, triangle_boxes
from geosurf.model import Lattice, Patches, TriSurface
from geosurf.model.excerpt import Boxes
from geosurf.model.pieces import Pieces, Strips, corners_of
from geosurf.model.torn_lattice import TornLattice

# ---- lattice runs ----------------------------------------
# What a certificate reads from the runs of one lattice, some rows at a time.


EPS = 2.0**-53
_RUNS_AT_ONCE = 1 << 18  # cells of which labels are in memory

# row and column of the corners of the two halves of a cell, where diagonals fall and where they
# rise; then the nodes that the diagonal joins
_CORNERS = (
    (((0, 0), (0, 1), (1, 0)), ((0, 1), (1, 1), (1, 0))),
    (((0, 0), (0, 1), (1, 1)), ((0, 0), (1, 1), (1, 0))),
)
_DIAGONAL = (((0, 1), (1, 0)), ((0, 0), (1, 1)))


@dataclass(frozen=True, eq=False)
class LatticeRuns:
    """What is read from the runs of one lattice.

    A node is private if no other triangle of the model has it as a corner. An edge between two
    private nodes belongs to the two triangles of the lattice next to it only.

    Attributes
    ----------
    surface : int
    first : int
        Element that its first run is.
    lattice : Lattice
    strips : Strips
    shared : ndarray of bool, shape (n_node,)
        Whether each node is not private.
    free : ndarray of bool
        Whether each triangle, by key, is in a run and has no shared corner.
    listed : ndarray of int64
        Keys of the triangles in runs that have a shared corner, rising.
    graph : bool
        Whether the map does not fold.
    sums : ndarray of float64, shape (n_run + 1, N_SUM)
        Sums over the triangles of each run, then over those in no run.
    n_node : ndarray of int64, shape (n_run,)
        Private nodes: each is counted for one of the runs around it.
    borders : ndarray of int64, shape (n, 3)
        Two runs with common private edges, -1 for triangles in no run; and how many these are.
    """

    surface: int
    first: int
    lattice: Lattice
    strips: Strips
    shared: np.ndarray
    free: np.ndarray
    listed: np.ndarray
    graph: bool
    sums: np.ndarray
    n_node: np.ndarray
    borders: np.ndarray

    @property
    def runs(self) -> slice:
        """Elements that its runs are."""
        return slice(self.first, self.first + len(self.strips.runs))

    def run_of(self, keys: np.ndarray) -> np.ndarray:
        """Run that holds each triangle; -1 for none."""
        strips = self.strips
        return runs_of_keys(strips.places, strips.runs, strips.start, keys)

    def count(self, sides: np.ndarray, counts: np.ndarray) -> int:
        """Add private nodes and open edges to the counts of units, given those on both sides of
        each run; the nodes of shells.
        """
        alone = sides[:, 0] != sides[:, 1]
        for side in sides.T:
            rows = np.flatnonzero(alone & (side >= 0))
            times = np.bincount(side[rows], self.n_node[rows], len(counts))
            counts[:, VERTICES] += times.astype(np.int64)
        count_borders(self.borders, sides, counts)
        return int(self.n_node[alone].sum())

    def rows_of(self, elements: np.ndarray) -> np.ndarray:
        """Those of some elements that are its runs, as rows of these."""
        rows: np.ndarray = elements[(elements >= self.runs.start) & (elements < self.runs.stop)]
        return rows - self.first

    def corners(self, keys: np.ndarray, origin: np.ndarray) -> np.ndarray:
        """Local corners (n, 3, 3) of triangles."""
        return corners_of(self.lattice, keys, origin)


def read_runs(
    pieces: Pieces, i: int, keys: np.ndarray, strips: Strips, level: float
) -> LatticeRuns | None:
    """Read the runs of one lattice; None if they are not what a certificate depends on.

    `keys` are those of its triangles that are listed.
    """
    lattice = pieces.sources[i].lattice
    assert lattice is not None  # only lattices have strips
    n_run, (n_row, n_col) = len(strips.runs), lattice.shape
    if not _in_rows(strips, lattice) or (
        len(keys) and (runs_of_keys(strips.places, strips.runs, strips.start, keys) >= 0).any()
    ):
        return None

    # a node with a point is in the same place, to the last bit
    nodes, points = strips.nodes, strips.points
    if not _in_order(nodes, lattice.n_node):
        return None
    if len(np.unique(points)) < len(points) or not _in_order(np.sort(points), len(pieces.x)):
        return None
    if not np.array_equal(lattice.places_of_nodes(nodes) - pieces.origin, pieces.x[points]):
        return None

    # where the map may fold, all triangles are listed and compared with each other; copies at tears
    # are in no run
    graph = is_graph(lattice, pieces.origin)
    shared = np.full(lattice.n_node, not graph)
    shared[nodes] = True
    corners = lattice.corners_of_keys(keys)
    shared[corners[corners < lattice.n_node]] = True

    sums, n_node = np.zeros((n_run + 1, N_SUM)), np.zeros(n_run, dtype=np.int64)
    sums[:, 8:11], sums[:, 11:14] = np.inf, -np.inf
    free, listed = np.zeros((2, max(n_row - 1, 0), 2 * max(n_col - 1, 0)), dtype=bool)
    borders = [np.empty(0, dtype=np.int64)]
    for low, high in _ranges(lattice.shape):
        # nodes have cells on both sides of their row, so that labels begin with the row before
        before = max(low - 1, 0)
        label = strips.labels(before, high)
        marks = shared.reshape(n_row, n_col)[before : high + 1]
        rows = slice(low - before, high - before + int(high == n_row - 1))
        own = label[low - before :]
        sums_of_runs(*lattice.coordinates, strips.places, own, low, pieces.origin, level, sums)
        touched = _touched(own, marks[low - before :], lattice.rising)
        free[low:high] = ((own >= 0) & ~touched).reshape(len(own), -1)
        listed[low:high] = ((own >= 0) & touched).reshape(len(own), -1)
        n_node += _count_nodes(label, ~marks, lattice.rising, rows, n_run)
        borders.append(_borders(label, ~marks, lattice.rising, rows) @ [n_run + 1, 1] + n_run + 2)
    if not np.isfinite(sums[:-1]).all() or (sums[:-1, 7] != _lengths(strips)).any():
        return None
    pairs, number = number_keys(np.concatenate(borders))
    one, two = np.divmod(pairs, n_run + 1)
    element = len(pieces.triangles) + int(pieces.first_run[i])
    return LatticeRuns(
        i, element, lattice, strips, shared, free.ravel(), np.flatnonzero(listed), graph, sums,
        n_node, np.stack([one - 1, two - 1, np.bincount(number, minlength=len(pairs))], axis=1),
    )  # fmt: skip


def height_in_map(lattice: Lattice) -> float:
    """A lower bound of the heights in the map of triangles whose corners are nodes [m]; 0: they
    may fold. Copies at tears have other corners.
    """
    return lattice.node_height if isinstance(lattice, TornLattice) else lattice.map_height


def is_graph(lattice: Lattice, origin: np.ndarray) -> bool:
    """Whether triangles whose corners are nodes lie side by side on the map."""
    # local coordinates are rounded: a triangle that is higher than that does not turn over
    size = max(np.abs(lattice.extent).max(), np.abs(origin).max())
    return bool(height_in_map(lattice) > 16 * EPS * size)


def _ranges(shape: tuple[int, int]) -> Iterator[tuple[int, int]]:
    """Ranges of rows of cells (first, last + 1) of a lattice."""
    n_row, n_col = shape
    step = max(_RUNS_AT_ONCE // n_col, 1)
    for low in range(0, n_row - 1, step):
        yield low, min(low + step, n_row - 1)


def _lengths(strips: Strips) -> np.ndarray:
    """Number of triangles of each run."""
    return strips.runs[:, LAST] - strips.runs[:, FIRST] + 1


def _touched(label: np.ndarray, shared: np.ndarray, rising: bool) -> np.ndarray:
    """Whether each triangle has a shared corner, bool (row, col, half)."""
    n_row, n_col, _ = label.shape
    found = np.zeros(label.shape, dtype=bool)
    for half, corners in enumerate(_CORNERS[rising]):
        for row, col in corners:
            found[:, :, half] |= shared[row : row + n_row, col : col + n_col]
    return found


def _count_nodes(
    label: np.ndarray, private: np.ndarray, rising: bool, rows: slice, n_run: int
) -> np.ndarray:
    """Private nodes of some rows, each counted for the last of the runs around it."""
    n_row, n_col, _ = label.shape
    run = np.full(private.shape, -1)
    for half, corners in enumerate(_CORNERS[rising]):
        for row, col in corners:
            around = run[row : row + n_row, col : col + n_col]
            np.maximum(around, label[:, :, half], out=around)
    counted = run[rows][private[rows]]
    return np.bincount(counted[counted >= 0], minlength=n_run)


def _borders(label: np.ndarray, private: np.ndarray, rising: bool, rows: slice) -> np.ndarray:
    """The runs (n, 2) on both sides of each private edge that two runs have, or a run and none.

    An edge belongs to the row of its lower node.
    """
    around = np.pad(label, ((1, 1), (1, 1), (0, 0)), constant_values=-1)
    east, west = (0, 1) if rising else (1, 0)  # halves with an eastern and a western edge
    cells = slice(rows.start, None)
    ends = [
        private[row : row + len(label), col : col + label.shape[1]]
        for row, col in _DIAGONAL[rising]
    ]
    pairs = []
    for one, two, is_private in (
        (label[cells, :, 0], label[cells, :, 1], (ends[0] & ends[1])[cells]),
        (around[:-1, 1:-1, 1][rows], around[1:, 1:-1, 0][rows],
         (private[:, :-1] & private[:, 1:])[rows]),
        (around[1:-1, :-1, east][cells], around[1:-1, 1:, west][cells],
         (private[:-1] & private[1:])[cells]),
    ):  # fmt: skip
        some = is_private & (one != two)
        pairs.append(np.stack([one[some], two[some]], axis=1))
    return np.concatenate(pairs)


def _in_rows(strips: Strips, lattice: Lattice) -> bool:
    """Whether runs are sorted, `start` has the first one of each row, and none leaves the rows."""
    runs, start = strips.runs, strips.start
    n_row, n_col = lattice.shape
    step, along = np.diff(runs[:, ROW]), runs[1:, FIRST] > runs[:-1, LAST]
    if not np.array_equal(strips.places, lattice.places):
        return False
    if len(start) != n_row or ((step < 0) | ((step == 0) & ~along)).any():
        return False
    if (_lengths(strips) < 1).any() or (runs[:, FIRST] < 0).any():
        return False
    if (runs[:, LAST] >= 2 * (n_col - 1)).any():
        return False
    expected = np.searchsorted(runs[:, ROW], np.arange(n_row))
    return bool((expected == start).all() and start[0] == 0 and start[-1] == len(runs))


def _in_order(rows: np.ndarray, n: int) -> bool:
    """Whether rows rise strictly and are below n."""
    return not len(rows) or bool((np.diff(rows) > 0).all() and rows[0] >= 0 and rows[-1] < n)


# ---- facts ----------------------------------------


_AT_ONCE = 1 << 17  # triangles that are compared with their input triangles, of several surfaces
_MANY_RUNS = 1000  # of all lattices, from which they are read in two threads
_MOST = 1 << 26  # rays times triangles, up to which the boxes of all are compared
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
        rows = [
            (pieces, i, pieces.key[cut[i] : cut[i + 1]], of, level)
            for i, of in enumerate(pieces.strips)
            if of is not None
        ]
        lattices = map_threads(read_runs, rows, worth=bool(pieces.first_run[-1] > _MANY_RUNS))
        if any(one is None for one in lattices):
            return None
        local, triangles, n_shared = _listed(pieces, lattices)
        run_of = (one.first + one.run_of(one.listed) for one in lattices)
        element = np.concatenate([np.arange(len(pieces.triangles)), *run_of])
        ring, _ = edges(triangles, len(local))
        if _runs_meet_others(len(local), triangles, element, ring, len(pieces.triangles)):
            return None

        # a triangle of a run with the corners of another triangle: both have to be compared
        n = len(pieces.triangles)
        key, rising, n_key = number_corners(triangles, len(local))
        n_own = int(key[:n].max(initial=-1)) + 1
        if n_key - n_own < len(triangles) - n:
            return None
        keys = key[:n], rising[:n], n_own
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
        runs = (np.full(len(one.n_node), one.surface) for one in self.lattices)
        return np.concatenate([self.pieces.surface, *runs])

    @cached_property
    def n_triangle(self) -> np.ndarray:
        """Number of triangles of each element."""
        n = np.ones(len(self.pieces.triangles), dtype=np.int64)
        return np.concatenate([n, *(_lengths(one.strips) for one in self.lattices)])

    @cached_property
    def bounds_of_runs(self) -> np.ndarray:
        """Lower, then upper corner of each run, local, float64 (n_run, 6)."""
        return np.concatenate([np.empty((0, 6)), *(one.sums[:-1, 8:14] for one in self.lattices)])

    @cached_property
    def within(self) -> np.ndarray:
        """Whether all corners of each element are within the bounds of the walls."""
        low, high = _bounds(self.patches)
        x, t, runs = self.pieces.x, self.pieces.triangles, self.bounds_of_runs
        inside = ((x >= low) & (x <= high)).all(axis=1)
        of_runs = (runs[:, :3] >= low).all(axis=1) & (runs[:, 3:] <= high).all(axis=1)
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
        rise: np.ndarray = self._sums[:, 1, 6].copy()
        for one in self.lattices:
            rise[one.surface] += one.sums[:-1, 6][self.within[one.runs]].sum()
        return rise

    @cached_property
    def joined(self) -> np.ndarray:
        """Runs with a common edge that no other triangle has, int64 (n, 2)."""
        pairs = [np.empty((0, 2), dtype=np.int64)]
        for one in self.lattices:
            both = one.borders[:, :2]
            pairs.append(one.first + both[(both >= 0).all(axis=1)])
        return np.concatenate(pairs)

    def matched(self, sides: np.ndarray, named: np.ndarray) -> Matched:
        """Elements of shells among those of the patches; `sides` and `named` as of `sides_of`."""
        n, n_all = len(self.pieces.triangles), len(sides)

        # runs have a corner that no other element has: each has a key of its own
        key, rising, n_key = self.keys
        key = np.concatenate([key, n_key + np.arange(n_all - n)])
        turn = np.concatenate([rising, np.zeros(n_all - n, dtype=bool)])
        alone = sides[:, 0] != sides[:, 1]
        rows, units, turns = [], [], []
        for s in range(2):
            mine = np.flatnonzero(alone & (sides[:, s] >= 0))
            rows.append(mine)
            units.append(sides[mine, s])
            turns.append(turn[mine] == (s == 1))
        of, unit, turned = map(np.concatenate, (rows, units, turns))
        order = np.argsort(unit, kind="stable")
        of, unit, turned = of[order], unit[order], turned[order]
        surface = named[of]
        row = rows_on(self.surface_of_triangle, key, surface, key[of], n_key + n_all - n)
        behind = turned == turn[row]
        return Matched(
            unit, surface, key[of], row, behind, turned, key, turn, n_key + n_all - n,
            self.n_triangle[of], lambda i: self.middle_of(of[i : i + 1]),
        )  # fmt: skip

    def corners_of_unit(self, sides: np.ndarray, unit: int) -> np.ndarray:
        """Corners (n, 3, 3) of the shell of a unit, turned outward."""
        mine = np.flatnonzero((sides == unit).any(axis=1) & (sides[:, 0] != sides[:, 1]))
        some = mine[mine < len(self.pieces.triangles)]
        corners, of = [self.pieces.x[self.pieces.triangles[some]]], [some]
        for one in self.lattices:
            keys, row = one.strips.keys_of(one.rows_of(mine))
            corners.append(one.corners(keys, self.patches.origin))
            of.append(one.first + row)
        found, inward = np.concatenate(corners), sides[np.concatenate(of), 0] == unit
        found[inward] = found[inward][:, [0, 2, 1]]
        return found

    def middle_of(self, element: np.ndarray) -> np.ndarray:
        """The middle of the first triangle of an element (1,)."""
        return self.first_corners(element)[0].mean(axis=0) + self.patches.origin

    def first_corners(self, elements: np.ndarray) -> np.ndarray:
        """Corners (n, 3, 3) of the triangle with the lowest key of each of some elements, which
        rise.
        """
        some = elements[elements < len(self.pieces.triangles)]
        parts = [self.pieces.x[self.pieces.triangles[some]]]
        for one in self.lattices:
            rows = one.rows_of(elements)
            keys = lowest_keys(one.strips.places, one.strips.runs[rows])
            parts.append(one.corners(keys, self.patches.origin))
        return np.concatenate(parts)

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
        some = self.first_corners(distinct(starts))
        low, high = some.min(axis=1) - _SLIP, some.max(axis=1) + _SLIP
        boxes = np.concatenate([low, high], axis=1)
        a, b, c = (some[:, k] for k in range(3))
        ray, axes = np.arange(len(some)), np.abs(np.cross(b - a, c - a)).argmax(axis=1)
        boxes[ray, axes], boxes[ray, 3 + axes] = -np.inf, np.inf

        # most triangles are far from all rays; those of many rays and triangles are all taken
        x, t = self.pieces.x, self.pieces.triangles
        listed = np.flatnonzero(wanted[: len(t)])
        if len(boxes) * len(listed) <= _MOST:
            around = triangle_boxes(x, t[listed])
            listed = listed[distinct(*(faces_in_box(around, box) for box in boxes))]
        corners, of = [x[t[listed]]], [listed]
        for one, keys, elements in self._runs_near(boxes, wanted):
            corners.append(one.corners(keys, self.patches.origin))
            of.append(elements)
        x, element = np.concatenate(corners).reshape(-1, 3), np.concatenate(of)
        first = first_rows(element, len(wanted))[starts]
        return x, np.arange(len(x)).reshape(-1, 3), element, first

    def _runs_near(
        self, boxes: np.ndarray, wanted: np.ndarray
    ) -> Iterator[tuple[LatticeRuns, np.ndarray, np.ndarray]]:
        """Lattices, the keys of their triangles in wanted runs near boxes, and the runs."""
        low, high = self.bounds_of_runs[:, :3], self.bounds_of_runs[:, 3:]
        some = np.zeros(len(wanted), dtype=bool)
        of_runs = some[len(self.pieces.triangles) :]
        for box in boxes:
            of_runs |= ((low <= box[3:]) & (high >= box[:3])).all(axis=1)
        some &= wanted
        world = boxes + np.tile(self.patches.origin, 2)
        region = Boxes(world[:, :2] - _SLIP, world[:, 3:5] + _SLIP)
        for one in self.lattices:
            if some[one.runs].any():
                cells = region.cells(one.lattice)
                keys = np.stack([2 * cells, 2 * cells + 1], axis=1).ravel()
                run = one.run_of(keys)
                mine = np.flatnonzero((run >= 0) & some[one.runs][run])
                yield one, keys[mine], one.first + run[mine]

    def new_triangles(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Rows of listed triangles that are not copies of their input triangle, and its corners.

        Some surfaces at once, in their order. Triangles in runs are copies: their corners are read
        from the lattice.
        """
        pieces, first = self.pieces, 0
        while first < len(pieces.sources):
            last = int(np.searchsorted(self.cut, self.cut[first] + _AT_ONCE, "right")) - 1
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
        heights = (height_in_map(one.lattice) for one in self.lattices if one.graph)
        return min(heights, default=math.inf)

    def areas(self) -> list[tuple[float, float, float]]:
        """Area of each surface, that of its input, and the sum of all sides of its triangles."""
        of_lattice = {one.surface: one for one in self.lattices}
        found = []
        for i, source in enumerate(self.sources):
            one, mine = of_lattice.get(i), self._sums[i]
            runs = np.empty((0, N_SUM)) if one is None else one.sums[:-1]
            rim = float(mine[:, 5].sum() + runs[:, 5].sum())
            if one is None:
                before = self._area_of(source.vertices - self.patches.origin, source.triangles)
            else:
                before = _area(one.sums)
                if isinstance(one.lattice, TornLattice):  # copies are in the place of what is gone
                    for sign, keys in ((1, one.lattice.keys_of_copies), (-1, one.lattice.gone)):
                        x = one.corners(keys, self.patches.origin).reshape(-1, 3)
                        before += sign * self._area_of(x, np.arange(len(x)).reshape(-1, 3))
            found.append((_area(np.concatenate([mine, runs])), before, rim))
        return found

    def _area_of(self, x: np.ndarray, triangles: np.ndarray) -> float:
        """Area of some triangles [m2]."""
        sums, row = np.zeros((1, N_SUM)), np.zeros(len(triangles), dtype=np.int64)
        sums_of_triangles(x, triangles, row, self.level, sums)
        return _area(sums)


def _area(sums: np.ndarray) -> float:
    """The area that some rows of sums have [m2]."""
    return 0.5 * math.fsum(sums[:, 2:4].ravel().tolist())


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
    """Vertices and triangles of the pieces, and of those of runs with a shared corner. Private
    vertices come last; how many come before.
    """
    count, places, private = len(pieces.x), [pieces.x], []
    for one in lattices:
        corners = one.lattice.corners_of_keys(one.listed)
        used = np.zeros(one.lattice.n_node, dtype=bool)
        used[corners] = True
        own = np.full(one.lattice.n_node, -1)
        own[one.strips.nodes] = one.strips.points
        new = np.flatnonzero(used & one.shared & (own < 0))
        own[new] = count + np.arange(len(new))
        count += len(new)
        places.append(one.lattice.places_of_nodes(new) - pieces.origin)
        private.append((one, corners, np.flatnonzero(used & ~one.shared), own))
    n_shared, triangles = count, [pieces.triangles]
    for one, corners, new, own in private:
        own[new] = count + np.arange(len(new))
        count += len(new)
        places.append(one.lattice.places_of_nodes(new) - pieces.origin)
        triangles.append(own[corners])
    return np.concatenate(places), np.concatenate(triangles), n_shared


def _runs_meet_others(
    n_vertex: int, triangles: np.ndarray, element: np.ndarray, ring: np.ndarray, first_run: int
) -> bool:
    """Whether an edge between two triangles of one run belongs to other triangles, too."""
    several = np.flatnonzero(ring[ring] != np.arange(len(ring)))
    several = several[element[several // 3] >= first_run]
    edge = edge_keys(triangles[several // 3], n_vertex).reshape(-1, 3)
    edge = edge[np.arange(len(several)), several % 3]
    order = np.lexsort((element[several // 3], edge))
    same = (np.diff(edge[order]) == 0) & (np.diff(element[several // 3][order]) == 0)
    return bool(same.any())
