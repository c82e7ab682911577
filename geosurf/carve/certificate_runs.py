"""What a certificate reads from the runs of one lattice, some rows at a time.

Most triangles of a large model are in runs of lattice triangles that no curve touches. They are
never listed: labels of cells say which run has a triangle, and sums, nodes and borders follow.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from geosurf.carve.certificate_shells import EPS, VERTICES, count_borders
from geosurf.kernels.lattices.strips import FIRST, LAST, ROW, runs_of_keys
from geosurf.kernels.meshes.checks import COUNT, LOWER, N_SUM, UPPER, sums_of_runs
from geosurf.kernels.meshes.mesh import number_keys
from geosurf.model import Lattice
from geosurf.model.pieces import Pieces, Strips, corners_of
from geosurf.model.torn_lattice import TornLattice

_CELLS_AT_ONCE = 1 << 18  # of which labels are in memory

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
        each run; return the number of nodes of shells.
        """
        bounds_units = sides[:, 0] != sides[:, 1]
        for side in sides.T:
            rows = np.flatnonzero(bounds_units & (side >= 0))
            n_node = np.bincount(side[rows], self.n_node[rows], len(counts))
            counts[:, VERTICES] += n_node.astype(np.int64)
        count_borders(self.borders, sides, counts)
        return int(self.n_node[bounds_units].sum())

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
    if not _are_sound(strips, lattice, keys, pieces):
        return None

    # where the map may fold, all triangles are listed and compared with each other; copies at tears
    # are in no run
    graph = is_graph(lattice, pieces.origin)
    shared = np.full(lattice.n_node, not graph)
    shared[strips.nodes] = True
    corners = lattice.corners_of_keys(keys)
    shared[corners[corners < lattice.n_node]] = True

    sums, n_node = np.zeros((n_run + 1, N_SUM)), np.zeros(n_run, dtype=np.int64)
    sums[:, LOWER], sums[:, UPPER] = np.inf, -np.inf
    free, listed = np.zeros((2, max(n_row - 1, 0), 2 * max(n_col - 1, 0)), dtype=bool)
    borders = [np.empty(0, dtype=np.int64)]
    for low, high in _ranges_of_rows(lattice.shape):
        # nodes have cells on both sides of their row, so that labels begin with the row before
        before = max(low - 1, 0)
        with_row_before = strips.labels(before, high)
        marks = shared.reshape(n_row, n_col)[before : high + 1]
        rows = slice(low - before, high - before + int(high == n_row - 1))
        label = with_row_before[low - before :]
        sums_of_runs(*lattice.coordinates, strips.places, label, low, pieces.origin, level, sums)
        touched = _touched(label, marks[low - before :], lattice.rising)
        free[low:high] = ((label >= 0) & ~touched).reshape(len(label), -1)
        listed[low:high] = ((label >= 0) & touched).reshape(len(label), -1)
        n_node += _count_nodes(with_row_before, ~marks, lattice.rising, rows, n_run)
        pairs = _borders(with_row_before, ~marks, lattice.rising, rows)
        borders.append(pairs @ [n_run + 1, 1] + n_run + 2)
    if not np.isfinite(sums[:-1]).all() or (sums[:-1, COUNT] != lengths_of(strips)).any():
        return None
    keys_of_pairs, number = number_keys(np.concatenate(borders))
    first, second = np.divmod(keys_of_pairs, n_run + 1)
    times = np.bincount(number, minlength=len(keys_of_pairs))
    element = len(pieces.triangles) + int(pieces.first_run[i])
    return LatticeRuns(
        i, element, lattice, strips, shared, free.ravel(), np.flatnonzero(listed), graph, sums,
        n_node, np.stack([first - 1, second - 1, times], axis=1),
    )  # fmt: skip


def _are_sound(strips: Strips, lattice: Lattice, keys: np.ndarray, pieces: Pieces) -> bool:
    """Whether runs lie in their rows, hold no triangle that is listed, and nodes with a point are
    in its place, to the last bit.
    """
    if not _in_rows(strips, lattice):
        return False
    if len(keys) and (runs_of_keys(strips.places, strips.runs, strips.start, keys) >= 0).any():
        return False
    nodes, points = strips.nodes, strips.points
    if not _in_order(nodes, lattice.n_node):
        return False
    if len(np.unique(points)) < len(points) or not _in_order(np.sort(points), len(pieces.x)):
        return False
    places = lattice.places_of_nodes(nodes) - pieces.origin
    return np.array_equal(places, pieces.x[points])


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


def _ranges_of_rows(shape: tuple[int, int]) -> Iterator[tuple[int, int]]:
    """Ranges of rows of cells (first, last + 1) of a lattice."""
    n_row, n_col = shape
    step = max(_CELLS_AT_ONCE // n_col, 1)
    for low in range(0, n_row - 1, step):
        yield low, min(low + step, n_row - 1)


def lengths_of(strips: Strips) -> np.ndarray:
    """Number of triangles of each run."""
    return strips.runs[:, LAST] - strips.runs[:, FIRST] + 1


def _touched(label: np.ndarray, shared: np.ndarray, rising: bool) -> np.ndarray:
    """Whether each triangle has a shared corner, bool (row, col, half)."""
    n_row, n_col, _ = label.shape
    touched = np.zeros(label.shape, dtype=bool)
    for half, corners in enumerate(_CORNERS[rising]):
        for row, col in corners:
            touched[:, :, half] |= shared[row : row + n_row, col : col + n_col]
    return touched


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
    start, end = (
        private[row : row + len(label), col : col + label.shape[1]]
        for row, col in _DIAGONAL[rising]
    )
    diagonals = label[cells, :, 0], label[cells, :, 1], (start & end)[cells]
    along_rows = (
        around[:-1, 1:-1, 1][rows], around[1:, 1:-1, 0][rows],
        (private[:, :-1] & private[:, 1:])[rows],
    )  # fmt: skip
    along_columns = (
        around[1:-1, :-1, east][cells], around[1:-1, 1:, west][cells],
        (private[:-1] & private[1:])[cells],
    )  # fmt: skip
    pairs = []
    for run, other, is_private in (diagonals, along_rows, along_columns):
        is_border = is_private & (run != other)
        pairs.append(np.stack([run[is_border], other[is_border]], axis=1))
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
    if (lengths_of(strips) < 1).any() or (runs[:, FIRST] < 0).any():
        return False
    if (runs[:, LAST] >= 2 * (n_col - 1)).any():
        return False
    expected = np.searchsorted(runs[:, ROW], np.arange(n_row))
    return bool((expected == start).all() and start[0] == 0 and start[-1] == len(runs))


def _in_order(rows: np.ndarray, n: int) -> bool:
    """Whether rows rise strictly and are below n."""
    return not len(rows) or bool((np.diff(rows) > 0).all() and rows[0] >= 0 and rows[-1] < n)
