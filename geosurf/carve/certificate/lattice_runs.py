"""What a certificate reads from the runs of one lattice, some rows at a time.

Rows are read once, for sums and for the triangles that have to be listed; edges and nodes are then
counted from the runs alone. So grids need no label for each triangle.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from geosurf.carve.certificate.elements import N_SUM
from geosurf.kernels.lattices.run_checks import (
    count_private,
    count_unusable,
    keys_at_shared,
    label_runs,
    mark_runs,
    sums_of_runs,
)
from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.kernels.lattices.strips import FIRST, LAST, ROW, runs_of_keys
from geosurf.kernels.search.tree import N_ROW
from geosurf.model import Lattice
from geosurf.model.pieces import Pieces, Strips
from geosurf.model.torn_lattice import TornLattice

EPS = 2.0**-53
_AT_ONCE = 1 << 18  # cells of which labels are in memory


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
    step = max(_AT_ONCE // n_col, 1)
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
