"""The facts of a certificate from runs of lattices, without a list of all triangles.

Runs are read from the model as it is stored: which triangles of a lattice they list, which corners
and edges these have in common with other triangles, and which units lie on their sides. Triangles
with a corner that others have, too, are listed; edges, vertices, sums and pairs of all others
follow from the lattice. `Facts.of` returns None for a model that this does not hold for:
`geosurf.carve.certificate` lists all its triangles.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from geosurf.arrangement.threads import map_threads
from geosurf.carve.certificate_elements import N_SUM, Elements, Matched, keys_of_runs, rows_on
from geosurf.carve.outside import box_of
from geosurf.carve.shells import Shells
from geosurf.kernels.lattices.run_checks import (
    add_to_units,
    count_private,
    count_unusable,
    keys_at_shared,
    label_runs,
    mark_runs,
    sums_of_runs,
)
from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.kernels.lattices.strips import FIRST, LAST, ROW, runs_of_keys
from geosurf.kernels.meshes.shells import (
    add_triangles_to_units,
    copies_of_parents,
    count_shared,
    number_triangles,
    rises_of_triangles,
    sizes_of_triangles,
    sums_of_triangles,
)
from geosurf.kernels.search.tree import N_ROW
from geosurf.model import Lattice, Patches, Units
from geosurf.model.excerpt import Boxes
from geosurf.model.pieces import Pieces, Strips
from geosurf.model.torn_lattice import TornLattice

# ---- lattice runs ----------------------------------------
# What a certificate reads from the runs of one lattice, some rows at a time.
#
# Rows are read once, for sums and for the triangles that have to be listed; edges and nodes are
# then counted from the runs alone. So grids need no label for each triangle.


EPS = 2.0**-53
_RUNS_AT_ONCE = 1 << 18  # cells of which labels are in memory


@dataclass(frozen=True, eq=False)
class LatticeRuns:
    """What is read from the runs of one lattice; see `geosurf.kernels.lattices.run_checks`.

    Attributes
    ----------
    surface : int
    first : int
        Element that its first run is.
    lattice : Lattice
    strips : Strips
    shared : ndarray of int64, or None
        Nodes that other triangles have as corners, too, rising; None for all nodes.
    listed : ndarray of int64
        Keys of the triangles in runs that have such a corner, rising.
    graph : bool
        Whether the map does not fold.
    sums : ndarray of float64, shape (n_run, 14)
    missing : (float, float)
        Area of the triangles in no run, and the sum of all their sides.
    """

    surface: int
    first: int
    lattice: Lattice
    strips: Strips
    shared: np.ndarray | None
    listed: np.ndarray
    graph: bool
    sums: np.ndarray
    missing: tuple[float, float]

    @property
    def runs(self) -> slice:
        """Elements that its runs are."""
        return slice(self.first, self.first + len(self.strips.runs))

    def run_of(self, keys: np.ndarray) -> np.ndarray:
        """Run that holds each triangle; -1 for none."""
        strips = self.strips
        found: np.ndarray = runs_of_keys(strips.places, strips.runs, strips.start, keys)
        return found

    def is_shared(self, nodes: np.ndarray) -> np.ndarray:
        """Whether other triangles have some nodes as corners."""
        if self.shared is None:
            return np.ones(len(nodes), dtype=bool)
        return is_among(nodes, self.shared)

    def unlisted(self) -> np.ndarray:
        """Whether each triangle is in a run and not listed, bool, by keys."""
        n_row, n_col = self.lattice.shape
        marks = np.zeros(2 * max(n_row - 1, 0) * max(n_col - 1, 0), dtype=bool)
        mark_runs(self.strips.places, self.strips.runs, marks)
        marks[self.listed] = False
        return marks

    def corners(self, keys: np.ndarray, origin: np.ndarray) -> np.ndarray:
        """Local corners (n, 3, 3) of triangles."""
        nodes = self.lattice.corners_of_keys(keys).ravel()
        return (self.lattice.places_of_nodes(nodes) - origin).reshape(-1, 3, 3)

    def count(self, sides: np.ndarray, counts: np.ndarray) -> tuple[int, np.ndarray]:
        """Add private nodes and edges to the counts of units; see `count_private`.

        Returns
        -------
        n : int
            Nodes of shells.
        joined : ndarray of int64, shape (n, 2)
            Runs with a common private edge.
        """
        n_used, joined = 0, [np.empty((0, 2), dtype=np.int64)]
        n_row = self.lattice.shape[0]
        for low, high in _ranges(n_row - 1, self.lattice.shape[1]):
            # nodes have cells on both sides of their row
            before = max(low - 1, 0)
            a, runs = _some_rows(self.strips, before, high)
            start = int(self.strips.start[before])
            shared = _marks(self.shared, before, high, self.lattice.shape[1])
            last = high - before - (0 if high == n_row - 1 else 1)
            n, pairs = count_private(
                a, label_runs(a, runs)[0], shared, sides[start : start + len(runs)],
                low - before, last, counts,
            )  # fmt: skip
            n_used += n
            joined.append(pairs + start)
        return n_used, np.concatenate(joined)


def read_runs(
    pieces: Pieces, i: int, keys: np.ndarray, strips: Strips, level: float
) -> LatticeRuns | None:
    """Read the runs of one lattice; None if they are not what checks by runs depend on.

    `keys` are those of its triangles that are listed.
    """
    lattice = pieces.sources[i].lattice
    assert lattice is not None  # only lattices have strips
    if not _in_rows(strips) or (
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
    size = max(np.abs(lattice.extent).max(), np.abs(pieces.origin).max())
    graph = bool(height_in_map(lattice) > 16 * EPS * size)
    shared = distinct(nodes, lattice.corners_of_keys(distinct(keys))) if graph else None
    sums, rest, listed = np.zeros((len(strips.runs), N_SUM)), np.zeros((1, 3)), []
    sums[:, 8:11], sums[:, 11:14] = np.inf, -np.inf
    n_row, n_col = lattice.shape
    for low, high in _ranges(n_row - 1, n_col):
        a, runs = _some_rows(strips, low, high)
        label, n_bad = label_runs(a, runs)
        if n_bad or count_unusable(*lattice.coordinates, a, runs):
            return None
        start = int(strips.start[low])
        keys = keys_at_shared(a, label, _marks(shared, low, high, n_col))
        listed.append(keys + low * 2 * (n_col - 1))
        sums_of_runs(
            *lattice.coordinates, a, label, pieces.origin, level,
            sums[start : start + len(runs)], rest,
        )  # fmt: skip
    found = np.concatenate([np.empty(0, dtype=np.int64), *listed])
    missing = 0.5 * float(rest[0, 0] + rest[0, 1]), float(rest[0, 2])
    element = len(pieces.triangles) + int(pieces.first_run[i])
    return LatticeRuns(i, element, lattice, strips, shared, found, graph, sums, missing)


def height_in_map(lattice: Lattice) -> float:
    """A lower bound of the heights in the map of triangles whose corners are nodes [m]; 0: they
    may fold. Copies at tears have other corners.
    """
    return lattice.node_height if isinstance(lattice, TornLattice) else lattice.map_height


def _ranges(n_row: int, n_col: int) -> Iterator[tuple[int, int]]:
    """Ranges of rows of cells (first, last + 1), of which there are `n_row`."""
    step = max(_RUNS_AT_ONCE // n_col, 1)
    for low in range(0, n_row, step):
        yield low, min(low + step, n_row)


def _some_rows(strips: Strips, low: int, high: int) -> tuple[np.ndarray, np.ndarray]:
    """Layout of rows of cells (first, last + 1), and their runs; rows count from there."""
    a = strips.places.copy()
    for axis in range(3):
        a[3 * axis] += low * a[3 * axis + 1]
    a[N_ROW] = high - low + 1
    runs = strips.runs[strips.start[low] : strips.start[high]].copy()
    runs[:, ROW] -= low
    return a, runs


def _marks(nodes: np.ndarray | None, low: int, high: int, n_col: int) -> np.ndarray:
    """Whether each node of some rows of cells (first, last + 1) is among some that rise."""
    marks = np.full((high - low + 1) * n_col, nodes is None)
    if nodes is not None:
        some = slice(*np.searchsorted(nodes, (low * n_col, (high + 1) * n_col)))
        marks[nodes[some] - low * n_col] = True
    return marks


def _in_rows(strips: Strips) -> bool:
    """Whether runs are sorted, `start` has the first one of each row, and none leaves the rows."""
    runs, start = strips.runs, strips.start
    step, along = np.diff(runs[:, ROW]), runs[1:, FIRST] > runs[:-1, LAST]
    if len(start) != strips.places[N_ROW] or ((step < 0) | ((step == 0) & ~along)).any():
        return False
    expected = np.searchsorted(runs[:, ROW], np.arange(len(start)))
    return bool((expected == start).all() and start[0] == 0 and start[-1] == len(runs))


def _in_order(rows: np.ndarray, n: int) -> bool:
    """Whether rows rise strictly and are below n."""
    return not len(rows) or bool((np.diff(rows) > 0).all() and rows[0] >= 0 and rows[-1] < n)


_AT_ONCE = 1 << 17  # triangles that are compared with their input triangles, of several surfaces
_MANY_RUNS = 1000  # of all lattices, from which they are read in two threads


def sides_of(patches: Patches, units: Units) -> tuple[np.ndarray, np.ndarray] | None:
    """Units in front of and behind each element (n, 2), -1 outside, and the surfaces that shells
    name there; None if units are not stored by elements of these patches.
    """
    stored = [one for one in (u.__dict__.get("_shell") for u in units.values()) if one is not None]
    if not stored or len(stored) < len(units):
        return None
    shells: Shells = stored[0][0]
    rows = [u for of, u in stored if of is shells]
    cells = shells.cells
    if len(set(rows)) < len(stored) or cells.pieces is not patches.pieces:
        return None

    # numbers of shells become those of units, in their order; the last is that of the outside
    number = np.full(len(shells.volumes) + 1, -1)
    number[rows] = np.arange(len(rows))
    faces = np.concatenate([number[shells.sides], [[-1, -1]]])
    named = np.append(cells.surface_of, -1)
    return faces[cells.face_of_element], named[cells.face_of_element]


@dataclass(frozen=True, eq=False)
class Facts:
    """What the checks of a certificate read.

    Attributes
    ----------
    elements : Elements
    cut : ndarray of int64, shape (n_surface + 1,)
        First triangle of each surface among those of the pieces.
    keys : (ndarray, ndarray, int)
        As `number_triangles` returns them for the triangles of the pieces.
    lattices : list of LatticeRuns
    level : float
        Local elevation that volumes are measured from [m].
    n_shared : int
        Vertices of `elements.local` up to this one belong to triangles that are all listed.
    heights : float
        Smallest height of a triangle in the map, of all lattices whose runs are not all listed.
    """

    patches: Patches
    elements: Elements
    cut: np.ndarray
    keys: tuple[np.ndarray, np.ndarray, int]
    lattices: list[LatticeRuns]
    level: float
    n_shared: int
    heights: float

    @classmethod
    def of(cls, patches: Patches) -> Facts | None:
        """The facts of a rebuilt mesh; None if its triangles have to be listed."""
        pieces = patches.__dict__.get("pieces")
        if pieces is None or all(strips is None for strips in pieces.strips):
            return None
        if not len(pieces.triangles):
            return None  # surfaces that nothing touches: there is no model to speak of
        if (np.diff(pieces.surface) < 0).any():
            return None
        cut = np.searchsorted(pieces.surface, np.arange(len(pieces.sources) + 1))
        level = _level(patches, pieces)
        rows = [
            (pieces, i, pieces.key[cut[i] : cut[i + 1]], of, level)
            for i, of in enumerate(pieces.strips)
            if of is not None
        ]
        found = map_threads(read_runs, rows, worth=bool(pieces.first_run[-1] > _MANY_RUNS))
        lattices = [one for one in found if one is not None]
        return (
            _listed(patches, pieces, cut, lattices, level) if len(lattices) == len(rows) else None
        )

    def counts(self, sides: np.ndarray, n_unit: int) -> tuple[np.ndarray, int, bool]:
        """Vertices, edges and open edges of each unit (n_unit, 3); vertices of all shells; whether
        the triangles of each run are connected in it alone.
        """
        counts = np.zeros((n_unit, 3), dtype=np.int64)
        elements = self.elements
        n_used, conflicts = count_shared(
            elements.triangles, elements.element, len(self.patches.pieces.triangles),
            sides[elements.element], len(elements.local), self.n_shared, counts,
        )  # fmt: skip
        for one in self.lattices:
            n_used += one.count(sides[one.runs], counts)[0]
        return counts, n_used, conflicts == 0

    def sizes(self, sides: np.ndarray, n_unit: int) -> np.ndarray:
        """Sums over the shells of units, see `add_to_units`."""
        pieces: Pieces = self.patches.pieces
        out = np.zeros((n_unit, 6))
        n = len(pieces.triangles)
        add_triangles_to_units(pieces.x, pieces.triangles, self.level, sides[:n], out)
        for one in self.lattices:
            add_to_units(sides[one.runs], one.sums, out)
        return out

    def matched(self, sides: np.ndarray, named: np.ndarray) -> Matched:
        """Elements of shells among those of the patches."""
        pieces: Pieces = self.patches.pieces
        n, n_all = len(pieces.triangles), len(sides)

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
        row = rows_on(self.elements.surface_of_triangle, key, surface, key[of], n_key + n_all - n)
        behind = turned == turn[row]
        return Matched(unit, surface, key[of], row, behind, turned, key, turn, n_key + n_all - n)

    def corners_of_unit(self, sides: np.ndarray, unit: int) -> np.ndarray:
        """Corners (n, 3, 3) of the shell of a unit, turned outward."""
        pieces: Pieces = self.patches.pieces
        mine = (sides == unit).any(axis=1) & (sides[:, 0] != sides[:, 1])
        n = len(pieces.triangles)
        some = np.flatnonzero(mine[:n])
        corners, of = [pieces.x[pieces.triangles[some]]], [some]
        for part, rows in self._triangles_of_runs(np.flatnonzero(mine[n:]) + n):
            corners.append(part)
            of.append(rows)
        found, row = np.concatenate(corners), np.concatenate(of)
        inward = sides[row, 0] == unit
        found[inward] = found[inward][:, [0, 2, 1]]
        return found

    def _triangles_of_runs(self, rows: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """Corners and elements of the triangles of some runs, lattice by lattice."""
        out = []
        for one in self.lattices:
            mine = rows[(rows >= one.runs.start) & (rows < one.runs.stop)]
            if len(mine):
                runs = one.strips.runs[mine - one.first]
                keys = keys_of_runs(one.lattice.places, runs)
                of = np.repeat(mine, runs[:, LAST] - runs[:, FIRST] + 1)
                out.append((one.corners(keys, self.patches.origin), of))
        return out

    def new_triangles(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Rows of listed triangles that are not copies of their input triangle, and its corners.

        Some surfaces at once, in their order. Triangles in runs are copies: their corners are read
        from the lattice.
        """
        pieces: Pieces = self.patches.pieces
        first = 0
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
        pieces, source = self.patches.pieces, self.patches.sources[i]
        nodes = source.corners_of_keys(pieces.key[self.cut[i] : self.cut[i + 1]]).ravel()
        corners: np.ndarray = source.places_of_nodes(nodes) - pieces.origin
        return corners.reshape(-1, 3, 3)

    def copies_of(self, one: LatticeRuns) -> np.ndarray:
        """Rows of listed triangles that are parts of copies at tears: these may lie over others."""
        if not isinstance(one.lattice, TornLattice):
            return np.empty(0, dtype=np.int64)
        first = self.cut[one.surface]
        keys = self.patches.pieces.key[first : self.cut[one.surface + 1]]
        rows: np.ndarray = first + np.flatnonzero(keys >= one.lattice.n_key)
        return rows

    def areas(self) -> list[tuple[float, float, float]]:
        """Area of each surface, that of its input, and the sum of all sides of its triangles."""
        of_lattice = {one.surface: one for one in self.lattices}
        pieces: Pieces = self.patches.pieces
        found = []
        for i, source in enumerate(pieces.sources):
            mine = pieces.triangles[self.cut[i] : self.cut[i + 1]]
            areas, around = sizes_of_triangles(pieces.x, mine)
            area, rim = 0.5 * math.fsum(areas.tolist()), float(around.sum())
            one = of_lattice.get(i)
            if one is None:
                x = source.vertices - self.patches.origin
                before = sums_of_triangles(x, source.triangles)[1]
            else:
                runs = 0.5 * math.fsum(one.sums[:, 2:4].ravel().tolist())
                area, before = area + runs, one.missing[0] + runs
                if isinstance(one.lattice, TornLattice):  # copies are in the place of what is gone
                    before += self._area_of(one, one.lattice.keys_of_copies)
                    before -= self._area_of(one, one.lattice.gone)
                rim += float(one.sums[:, 5].sum())
            found.append((area, before, rim))
        return found

    def _area_of(self, one: LatticeRuns, keys: np.ndarray) -> float:
        """Area of some triangles of a lattice [m2]."""
        x = one.corners(keys, self.patches.origin).reshape(-1, 3)
        area: float = sums_of_triangles(x, np.arange(len(x)).reshape(-1, 3))[1]
        return area


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


def _listed(
    patches: Patches, pieces: Pieces, cut: np.ndarray, lattices: list[LatticeRuns], level: float
) -> Facts | None:
    """List the triangles with shared corners; their vertices first, private ones last."""
    n = len(pieces.triangles)
    places, corners, private = [], [], []
    count = len(pieces.x)
    for one in lattices:
        nodes, at = np.unique(one.lattice.corners_of_keys(one.listed), return_inverse=True)
        own = np.full(len(nodes), -1)
        where = np.searchsorted(one.strips.nodes, nodes)
        where = np.minimum(where, max(len(one.strips.nodes) - 1, 0))
        if len(one.strips.nodes):
            known = one.strips.nodes[where] == nodes
            own[known] = one.strips.points[where[known]]
        new = np.flatnonzero((own < 0) & one.is_shared(nodes))
        own[new] = count + np.arange(len(new))
        count += len(new)
        places.append(one.lattice.places_of_nodes(nodes[new]) - pieces.origin)
        private.append((one, nodes, at.reshape(-1, 3), own))
    n_shared = count
    for one, nodes, at, own in private:
        new = np.flatnonzero(own < 0)
        own[new] = count + np.arange(len(new))
        count += len(new)
        places.append(one.lattice.places_of_nodes(nodes[new]) - pieces.origin)
        corners.append(own[at])
    local = np.concatenate([pieces.x, *places])
    element = [np.arange(n), *(one.first + one.run_of(one.listed) for one in lattices)]

    # elements: triangles first, then runs
    n_run = int(pieces.first_run[-1])
    bounds = _bounds(patches)
    rise, within = np.zeros(len(pieces.sources)), np.zeros(n + n_run, dtype=bool)
    rises_of_triangles(pieces.x, pieces.triangles, pieces.surface, *bounds, rise, within[:n])
    boxes, n_triangle = np.zeros((n_run, 6)), np.ones(n + n_run, dtype=np.int32)
    surface = np.concatenate([pieces.surface, np.zeros(n_run, dtype=np.int64)])
    joined = [np.empty((0, 2), dtype=np.int64)]
    no_units = np.empty((0, 3), dtype=np.int64)
    for one in lattices:
        surface[one.runs], n_triangle[one.runs] = one.surface, one.sums[:, 7]
        own = one.sums[:, 8:]
        boxes[one.runs.start - n : one.runs.stop - n] = own
        inside = (own[:, :3] >= bounds[0]) & (own[:, 3:] <= bounds[1])
        within[one.runs] = inside.all(axis=1)
        rise[one.surface] += one.sums[within[one.runs], 6].sum()
        none = np.full((len(one.strips.runs), 2), -1)
        joined.append(one.first + one.count(none, no_units)[1])
    near = NearRuns(n, lattices, boxes, pieces.origin)
    elements = Elements(
        pieces.sources, pieces.origin, surface, n_triangle, rise, within,
        local, np.concatenate([pieces.triangles, *corners]), np.concatenate(element),
        np.concatenate(joined), near,
    )  # fmt: skip
    # a triangle of a run with the corners of another triangle: both have to be compared
    number, rising, n_number, n_all = number_triangles(elements.triangles, n)
    if n_all - n_number < len(elements.triangles) - n:
        return None
    keys = number, rising, n_number
    heights = min((height_in_map(one.lattice) for one in lattices if one.graph), default=math.inf)
    return Facts(patches, elements, cut, keys, lattices, level, n_shared, heights)


# ---- triangles of runs that rays of a certificate may meet: only these are listed --------


_SLIP = 1e-3  # [m] around boxes; far more than rounding in a frame moves them by


@dataclass(frozen=True, eq=False)
class NearRuns:
    """
    Lists triangles of runs: see `Elements.near`.

    It does not refer to the elements: what refers to itself stays in memory after its last use.

    Attributes
    ----------
    n_triangle : int
        Elements before the first run.
    lattices : sequence of LatticeRuns
    bounds : ndarray of float64, shape (n_run, 6)
        Lower, then upper corner of each run, local.
    origin : ndarray, shape (3,)
    """

    n_triangle: int
    lattices: Sequence[LatticeRuns]
    bounds: np.ndarray
    origin: np.ndarray

    def __call__(
        self, starts: np.ndarray, boxes: np.ndarray, wanted: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """A triangle of some runs, then those of wanted ones near boxes."""
        n = self.n_triangle
        some = np.zeros(len(wanted), dtype=bool)
        low, high = self.bounds[:, :3], self.bounds[:, 3:]
        for box in boxes:
            some[n:] |= ((low <= box[3:]) & (high >= box[:3])).all(axis=1) & wanted[n:]
        parts = [(np.empty((0, 3, 3)), np.empty(0, dtype=np.int64))]
        parts += self._first_triangles(np.unique(starts[starts >= n]))
        parts += self._triangles_near(some, boxes)
        corners, rows = zip(*parts, strict=True)
        return np.concatenate(corners), np.concatenate(rows)

    def _first_triangles(self, rows: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """Corners of the first triangle of some runs, and these runs, lattice by lattice."""
        out = []
        for one in self.lattices:
            mine = rows[(rows >= one.runs.start) & (rows < one.runs.stop)]
            runs = one.strips.runs[mine - one.first]
            runs[:, LAST] = runs[:, FIRST]
            keys = keys_of_runs(one.lattice.places, runs)
            out.append((one.corners(keys, self.origin), mine))
        return out

    def _triangles_near(
        self, some: np.ndarray, boxes: np.ndarray
    ) -> list[tuple[np.ndarray, np.ndarray]]:
        """Corners and runs of the triangles of some runs that may be near boxes."""
        out, world = [], boxes + np.tile(self.origin, 2)
        region = Boxes(world[:, :2] - _SLIP, world[:, 3:5] + _SLIP)
        for one in self.lattices:
            if not some[one.runs].any():
                continue
            cells = region.cells(one.lattice)
            keys = np.stack([2 * cells, 2 * cells + 1], axis=1).ravel()
            run = one.run_of(keys)
            mine = np.flatnonzero((run >= 0) & some[one.runs][run])
            corners = one.corners(keys[mine], self.origin)
            out.append((corners, one.first + run[mine]))
        return out
