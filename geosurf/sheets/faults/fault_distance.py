"""How far is a datum from a fault at its own height; how far is a node from a trace in the map.

The distance at the datum's own height does not depend on heave: a value that was gridded across
a normal fault lies on the fault itself, wherever it is in the heave zone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from geosurf.arrangement.threads import map_threads
from geosurf.kernels.lattices.sets import distinct
from geosurf.kernels.sheets.link_lines import NEAR, distance_at_elevation, nearest_on_line
from geosurf.kernels.sheets.node_bands import boxes_in_blocks
from geosurf.sheets.faults.traces import FaultMesh, Trace
from geosurf.sheets.lattice.picks import Frame

# ---- node table ----------------------------------------
# Numbers of lattice nodes, as a table that grows where nodes are put, by square tiles.
#
# Node = row * n_col + column. A sorted list costs a binary search for each node: 0.2 us, a fifth of
# the tear of a large field. A tile costs a division.


SIDE = 16  # nodes along a tile
NOT_ASKED = -2  # in place of the number of a node that was never put


class NodeTable:
    """
    A number for each node of a lattice that was put.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns of the lattice.

    Examples
    --------
    >>> table = NodeTable((100, 200))
    >>> table.put(np.array([3, 19999]), np.array([7, 8]))
    >>> table.look_up(np.array([19999, 3, -1, 4]))
    (array([ 8,  7, -1, -2]), 1)
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        n_row, self.n_col = shape
        tiles = -(-n_row // SIDE) * -(-self.n_col // SIDE)
        # tiles without a node share the first block of numbers
        self._tile_of = np.zeros(tiles, dtype=np.int64)
        self._numbers = np.full(SIDE**2, NOT_ASKED)

    def _places(self, node: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Tile of each node, and its place in it."""
        row, col = np.divmod(node, self.n_col)
        tiles = row // SIDE * -(-self.n_col // SIDE) + col // SIDE
        return tiles, row % SIDE * SIDE + col % SIDE

    def look_up(self, node: np.ndarray) -> tuple[np.ndarray, int]:
        """Number of each node, -1 for nodes below 0, `NOT_ASKED` for others that were not put.

        Parameters
        ----------
        node : ndarray of int64 (n,)

        Returns
        -------
        (ndarray of int64 (n,), int)
            Also how many were not put.
        """
        tile, inside = self._places(np.maximum(node, 0))
        found = self._numbers.take(self._tile_of.take(tile) * SIDE**2 + inside)
        found[node < 0] = -1
        return found, int(np.count_nonzero(found == NOT_ASKED))

    def put(self, node: np.ndarray, number: np.ndarray) -> None:
        """Put numbers of nodes (n,); those that were put before get the new ones."""
        tile, inside = self._places(node)
        new = np.unique(tile[self._tile_of[tile] == 0])
        if len(new):
            self._tile_of[new] = len(self._numbers) // SIDE**2 + np.arange(len(new))
            more = np.full(len(new) * SIDE**2, NOT_ASKED)
            self._numbers = np.concatenate([self._numbers, more])
        self._numbers[self._tile_of[tile] * SIDE**2 + inside] = number


BLOCK = 8.0  # cells: what can be near is listed by blocks of this size
REACHES = 5  # of which blocks of a fault are remembered
ROUNDED = 1e-6  # cells and shares of edges by which boxes are wider than what was computed


class Blocks:
    """Boxes in the map, listed by the blocks of some size that they come within reach of."""

    def __init__(
        self, low: np.ndarray, high: np.ndarray, reach: float, size: float = BLOCK
    ) -> None:
        self.boxes, self.size = np.hstack([low, high]), size

        given = np.ascontiguousarray(low), np.ascontiguousarray(high)
        self.corner, self.shape, self.items, self.starts = boxes_in_blocks(*given, reach, size)

    def of(self, xy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows of the points (n, 2 or more) in a block with anything, and their blocks."""
        at = np.floor(xy[:, :2] / self.size) - self.corner
        rows = np.flatnonzero(((at >= 0.0) & (at < self.shape)).all(axis=1))
        block = at[rows].astype(np.int64) @ [1, self.shape[0]]
        some = self.starts[block + 1] > self.starts[block]
        return rows[some], block[some]


def window(frame: Frame, blocks: Blocks) -> np.ndarray:
    """Nodes in the blocks that hold anything, increasing: all that can be near."""
    n_row, n_col = frame.shape
    limits = []
    for k, most in enumerate((n_col, n_row)):
        edge = (blocks.corner[k] + np.arange(blocks.shape[k] + 1)) * blocks.size / frame.stretch[k]
        limits.append(np.clip(np.ceil(edge).astype(np.int64), 0, most))
    wide, tall = map(np.diff, limits)
    some = np.diff(blocks.starts).reshape(blocks.shape[::-1]) > 0
    row, col = np.nonzero(np.repeat(np.repeat(some, tall, axis=0), wide, axis=1))
    return (limits[1][0] + row) * n_col + limits[0][0] + col


def mesh_blocks(mesh: FaultMesh, reach: float) -> Blocks:
    """Blocks of the triangles of a fault, as wide as reach: each triangle is in a few.

    The last ones are remembered: horizons and realisations ask for the same few reaches.
    """
    known: dict[float, Blocks] = mesh.__dict__.get("_blocks", {})
    blocks = known.get(reach)
    if blocks is None:
        blocks = Blocks(*_boxes(mesh), reach, max(BLOCK, reach))
        # a new mapping: other threads may read the old one
        mesh.__dict__["_blocks"] = {**dict([*known.items()][1 - REACHES :]), reach: blocks}
    return blocks


def _boxes(mesh: FaultMesh) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corner (n, 2) in the map of the triangles of a fault."""
    a, b, c = (mesh.points[mesh.triangles[:, k], :2] for k in range(3))
    return np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)


def blocks_between(
    mesh: FaultMesh, reach: float, low: float, high: float
) -> tuple[FaultMesh, Blocks | None]:
    """The triangles of a fault that have something between two levels, and blocks of that part."""
    # triangles below or above both levels play no part
    z = mesh.points[mesh.triangles, 2]
    rows = np.flatnonzero((z.min(axis=1) <= high) & (z.max(axis=1) >= low))
    part = replace(mesh, triangles=mesh.triangles[rows], normals=mesh.normals[rows])
    if not len(rows):
        return part, None

    # a box around what the three edges have between the levels
    least, most = zip(*(_between(part, k, low, high) for k in range(3)), strict=True)
    boxes = np.fmin.reduce(least) - ROUNDED, np.fmax.reduce(most) + ROUNDED
    return part, Blocks(*boxes, reach)


def _between(mesh: FaultMesh, k: int, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    """Boxes in the map of what edge k of each triangle has between two levels; NaN without."""
    p, q = (mesh.points[mesh.triangles[:, i % 3]] for i in (k, k + 1))

    # shares of the edge at which it crosses both levels; level edges count as a whole
    rise = q[:, 2] - p[:, 2]
    level = rise == 0.0
    ends = np.sort((np.array([[low], [high]]) - p[:, 2]) / np.where(level, 1.0, rise), axis=0)
    first, last = np.where(level, [[0.0], [1.0]], ends)
    out = (first > 1.0 + ROUNDED) | (last < -ROUNDED)
    out |= level & ((p[:, 2] < low) | (p[:, 2] > high))
    away = (q - p)[:, :2]
    one, two = (p[:, :2] + np.clip(t, 0.0, 1.0)[:, None] * away for t in (first, last))
    one[out] = two[out] = np.nan
    return np.fmin(one, two), np.fmax(one, two)


def side_at_own_height(
    mesh: FaultMesh, blocks: Blocks, points: np.ndarray, reach: float
) -> tuple[np.ndarray, np.ndarray]:
    """Distance (n,) [cells], at most `reach`, and side (n,): +1 hanging wall, -1, 0 far."""
    far, side = np.full(len(points), reach), np.zeros(len(points))
    rows, block = blocks.of(points)
    if len(rows):
        far[rows], side[rows] = distance_at_elevation(
            points[rows], block, mesh.corners, blocks.boxes, mesh.across, blocks.starts,
            blocks.items, reach,
        )  # fmt: skip
    return far, side


def side_over(mesh: FaultMesh, at: np.ndarray, reach: float) -> Callable[[np.ndarray], np.ndarray]:
    """The function that gives sides (n,) at elevations (n,) over one place."""
    low, high = _boxes(mesh)
    near = (at >= low - reach) & (at <= high + reach)
    rows = np.flatnonzero(near[:, 0] & near[:, 1])
    corners = mesh.points[mesh.triangles[rows]].reshape(-1, 9)
    boxes, normals = np.hstack([low[rows], high[rows]]), mesh.normals[rows, :2]
    starts, items = np.array([0, len(rows)]), np.arange(len(rows))

    def sides(z: np.ndarray) -> np.ndarray:
        """Sides at some elevations."""
        points = np.column_stack([np.tile(at, (len(z), 1)), z])
        block = np.zeros(len(z), dtype=np.int64)
        return distance_at_elevation(points, block, corners, boxes, normals, starts, items, reach)[
            1
        ]

    return sides


def near_traces(frame: Frame, traces: Sequence[Trace], reach: float) -> list[NearTrace]:
    """What is near each of some traces."""
    return [NearTrace(frame, trace, reach) for trace in traces]


def rows_near(near: Sequence[NearTrace], nodes: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Rows of nodes near each of some traces, as from `NearTrace.look_up`."""
    return map_threads(NearTrace.look_up, list(zip(near, nodes, strict=True)))


class NearTrace:
    """Nodes within reach of a trace, with distance, side and place along it.

    Nodes are measured when they are first requested, and get the next rows; rows stay what they
    are.

    Attributes
    ----------
    node : ndarray of int64 (n,)
    distance, side, place : ndarray (n,)
        [cells]; +1 left (the fault's front); vertex number along the line. Row 0 is empty.
    """

    def __init__(self, frame: Frame, trace: Trace, reach: float) -> None:
        self.frame, self.reach, self.pieces = frame, reach, trace.segments
        first = np.arange(0, len(self.pieces), NEAR)
        one, two = self.pieces[:, :2], self.pieces[:, 2:]
        self._low = np.minimum.reduceat(np.minimum(one, two), first)
        self._high = np.maximum.reduceat(np.maximum(one, two), first)
        self._blocks = Blocks(self._low, self._high, reach)
        self.node = np.array([-1])
        self.distance, self.side, self.place = np.array([[np.inf], [0.0], [np.nan]])
        self._searched = -1.0  # cells: all nodes up to here are measured
        # rows of `within` by distance: what is measured later is farther
        self._within: dict[float, np.ndarray] = {}
        # rows of nodes, -1 for those that are far
        self._rows = NodeTable(frame.shape)

    def look_up(self, node: np.ndarray) -> np.ndarray:
        """Row of each node here, -1 where it is not near, or no node."""
        # nodes that were not asked for yet are measured all at once, then looked up again
        rows, n_new = self._rows.look_up(node)
        if n_new:
            self._measure(distinct(node[rows == NOT_ASKED]), self._blocks, self.reach)
            rows, _ = self._rows.look_up(node)
        return rows

    def nodes_within(self, far: float) -> np.ndarray:
        """All nodes within `far` cells and within reach; increasing."""
        rows = self.within(far)
        return self.node[rows]

    def within(self, far: float) -> np.ndarray:
        """Rows of `nodes_within`."""
        far = min(far, self.reach)
        if far in self._within:
            return self._within[far]

        # the search grows only when asked for more than before
        if far > self._searched:
            blocks = Blocks(self._low, self._high, far, 0.5 * BLOCK)
            new = window(self.frame, blocks)
            self._measure(new[self._rows.look_up(new)[0] == NOT_ASKED], blocks, far)
            self._searched = far
        rows = np.flatnonzero(self.distance <= far)
        self._within[far] = rows[np.argsort(self.node[rows])]
        return self._within[far]

    def _measure(self, node: np.ndarray, blocks: Blocks, far: float) -> None:
        """Append nodes, increasing, that were not asked for yet."""
        points = self.frame.cells_of_node(node)
        beside, block = blocks.of(points)
        distance, side, nearest, t = nearest_on_line(
            points[beside], block, self.pieces, blocks.boxes, blocks.starts, blocks.items, far
        )
        near = nearest >= 0
        beside, nearest = beside[near], nearest[near]
        row = np.full(len(node), -1)
        row[beside] = len(self.node) + np.arange(len(beside))
        if far < self.reach:  # the others may yet be near
            node, row = node[beside], row[beside]
            beside = np.arange(len(beside))
        self.node = np.concatenate([self.node, node[beside]])
        self.distance = np.concatenate([self.distance, distance[near]])
        self.side = np.concatenate([self.side, side[near]])
        self.place = np.concatenate([self.place, nearest + t[near]])

        self._rows.put(node, row)
