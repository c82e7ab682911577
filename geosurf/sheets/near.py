"""How far is a datum from a fault at its own height; how far is a node from a trace in the map.

The distance at the datum's own height does not depend on heave: a value that was gridded across
a normal fault lies on the fault itself, wherever it is in the heave zone.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.contact.threads import side_by_side
from geosurf.kernels.lines import NEAR, to_line
from geosurf.kernels.nodes import in_blocks, nodes_of_blocks
from geosurf.kernels.sheets import own_height
from geosurf.sheets.frame import Frame
from geosurf.sheets.traces import FaultMesh, Trace

BLOCK = 8.0  # cells: what can be near is listed by blocks of this size


class Blocks:
    """Boxes in the map, listed by the blocks that they come within reach of."""

    def __init__(self, low: np.ndarray, high: np.ndarray, reach: float) -> None:
        self.boxes = np.hstack([low, high])
        self.corner = np.floor((low.min(axis=0) - reach) / BLOCK)
        last = np.floor((high.max(axis=0) + reach) / BLOCK)
        self.shape = (last - self.corner + 1).astype(np.int64)
        a = (np.floor((low - reach) / BLOCK) - self.corner).astype(np.int64)
        b = (np.floor((high + reach) / BLOCK) - self.corner).astype(np.int64)
        n = b - a + 1
        total = n.prod(axis=1)
        item = np.repeat(np.arange(len(low)), total)
        k = np.arange(len(item)) - np.repeat(np.cumsum(total) - total, total)
        x, y = a[item, 0] + k % n[item, 0], a[item, 1] + k // n[item, 0]
        block = y * self.shape[0] + x
        order = np.argsort(block, kind="stable")
        self.items = item[order]
        self.starts = np.searchsorted(block[order], np.arange(self.shape.prod() + 1))

    def of(self, xy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows of the points (n, 2 or more) in a block with anything, and their blocks."""
        return in_blocks(xy, self.corner, self.shape, self.starts, BLOCK)


def window(frame: Frame, blocks: Blocks) -> np.ndarray:
    """Nodes in the blocks that hold anything, increasing: all that can be near."""
    n_row, n_col = frame.shape
    limits = []
    for k, most in enumerate((n_col, n_row)):
        edge = (blocks.corner[k] + np.arange(blocks.shape[k] + 1)) * BLOCK / frame.stretch[k]
        limits.append(np.clip(np.ceil(edge).astype(np.int64), 0, most))
    return nodes_of_blocks(blocks.starts, limits[0], limits[1], n_col)


def mesh_blocks(mesh: FaultMesh, reach: float) -> Blocks:
    """Blocks of the triangles of a fault."""
    return Blocks(*_boxes(mesh), reach)


def _boxes(mesh: FaultMesh) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corner (n, 2) in the map of the triangles of a fault."""
    a, b, c = (mesh.points[mesh.triangles[:, k], :2] for k in range(3))
    return np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)


def side_at_own_height(mesh: FaultMesh, blocks: Blocks, points: np.ndarray, reach: float):
    """Distance (n,) [cells], at most `reach`, and side (n,): +1 hanging wall, -1, 0 far."""
    far, side = np.full(len(points), reach), np.zeros(len(points))
    rows, block = blocks.of(points)
    if len(rows):
        corners = mesh.points[mesh.triangles].reshape(-1, 9)
        far[rows], side[rows] = own_height(
            points[rows], block, corners, blocks.boxes, mesh.normals[:, :2], blocks.starts,
            blocks.items, reach,
        )  # fmt: skip
    return far, side


def side_of_few(mesh: FaultMesh, points: np.ndarray, reach: float):
    """`side_at_own_height` of a few points, for which no blocks are worth making."""
    corners = mesh.points[mesh.triangles]
    low, high = _boxes(mesh)
    x, y = points[:, 0, None], points[:, 1, None]
    close = (x >= low[:, 0] - reach) & (x <= high[:, 0] + reach)
    close &= (y >= low[:, 1] - reach) & (y <= high[:, 1] + reach)
    point, items = np.nonzero(close)
    starts = np.searchsorted(point, np.arange(len(points) + 1))
    every, boxes = np.arange(len(points)), np.hstack([low, high])
    return own_height(
        points, every, corners.reshape(-1, 9), boxes, mesh.normals[:, :2], starts, items, reach
    )


def near_traces(frame: Frame, traces: Sequence[Trace], reach: float) -> list[NearTrace]:
    """What is near each of some traces."""
    return side_by_side(NearTrace, [(frame, trace, reach) for trace in traces])


class NearTrace:
    """Nodes within reach of a trace, with distance, side and place along it.

    Attributes
    ----------
    node : ndarray of int64 (n,), increasing
    distance, side, place : ndarray (n,)
        [cells]; +1 left (the fault's front); vertex number along the line.
    """

    def __init__(self, frame: Frame, trace: Trace, reach: float) -> None:
        pieces = trace.segments
        first = np.arange(0, len(pieces), NEAR)
        low = np.minimum.reduceat(np.minimum(pieces[:, :2], pieces[:, 2:]), first)
        high = np.maximum.reduceat(np.maximum(pieces[:, :2], pieces[:, 2:]), first)
        blocks = Blocks(low, high, reach)
        node = window(frame, blocks)
        points = frame.cells_of_node(node)
        rows, block = blocks.of(points)
        far, side, nearest, t = to_line(
            points[rows], block, pieces, blocks.boxes, blocks.starts, blocks.items, reach
        )
        near = nearest >= 0
        self.node = node[rows][near]
        self.distance, self.side = far[near], side[near]
        self.place = nearest[near] + t[near]

    def look_up(self, node: np.ndarray) -> np.ndarray:
        """Row of each node here, -1 where it is not near."""
        at = np.searchsorted(self.node, node)
        at[at == len(self.node)] = 0
        if len(self.node) == 0:
            return np.full(len(node), -1)
        return np.where(self.node[at] == node, at, -1)
