"""How far the data of a horizon overlap at its faults, before anything is rebuilt.

Where a horizon overlaps itself, a node has a value of each wall, and the fault passes between the
two. A mean of both belongs to neither wall, so all of them have to be known to be near the fault:
by half the overlap, at the trace.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeometryError
from geosurf.sheets.faults.fault_distance import Blocks, mesh_blocks, side_at_own_height
from geosurf.sheets.faults.traces import FaultMesh
from geosurf.sheets.lattice.picks import Picks

WIDEST = 22.0  # cells of overlap: walls are distinguished up to 12 cells from a trace
SEEN = 64.0  # cells from a fault within which distances are asked for


def widest_overlap(picks: Picks, meshes: Sequence[FaultMesh]) -> float:
    """The widest overlap of the data at any fault [cells], 0 where no node has both walls.

    Raises
    ------
    GeometryError
        If it is wider than can be torn: names fault and place.
    """
    high, low = _highest_and_lowest(picks)
    widest = 0.0
    for mesh in meshes if len(high) else ():
        # cheap bound first: only nodes whose two picks have the fault between them
        at_dip = _overlap_at_dip(picks, mesh, high, low)
        both = at_dip > 0.0
        if not both.any():
            continue
        blocks = mesh_blocks(mesh, SEEN)

        # distances of both picks to the fault, at their own heights, add up to the overlap
        overlap = sum(
            side_at_own_height(mesh, blocks, _points(picks, rows[both]), SEEN)[0]
            for rows in (high, low)
        )
        # where the fault ends above or below a pick, its dip gives how far it would be
        overlap = np.minimum(overlap, at_dip[both])
        most = int(np.argmax(overlap))
        if overlap[most] > WIDEST:
            where = picks.places(high[both][most : most + 1])[0]
            coarser = picks.frame.cell * overlap[most] / WIDEST
            raise GeometryError(
                f"horizon {picks.name!r} overlaps itself by {overlap[most]:.0f} cells at fault "
                f"{mesh.name!r}, near {place(where)}; {WIDEST:g} cells are the most that can be "
                f"torn. Give points on a lattice of {coarser:.3g} m or more, one for each wall.",
                place=where,
                surfaces=(picks.name, mesh.name),
            )
        widest = max(widest, float(overlap[most]))
    return widest


def _highest_and_lowest(picks: Picks) -> tuple[np.ndarray, np.ndarray]:
    """Highest and lowest pick of each node that has several."""
    none = np.empty(0, dtype=np.int64)
    if picks.one_each:
        return none, none

    # picks of such nodes by node, then by height: the first is the lowest, the last the highest
    several = np.flatnonzero(np.bincount(picks.node)[picks.node] > 1)
    order = several[np.lexsort((picks.z[several], picks.node[several]))]
    node = picks.node[order]
    is_last = np.ones(len(node), dtype=bool)
    is_last[:-1] = node[1:] != node[:-1]
    return order[is_last], order[np.roll(is_last, 1)]


def _points(picks: Picks, rows: np.ndarray) -> np.ndarray:
    """Some picks (n, 3) in the frame of fault meshes."""
    return np.column_stack([picks.columns(rows) * picks.frame.stretch, picks.z[rows]])


def _overlap_at_dip(picks: Picks, mesh: FaultMesh, high: np.ndarray, low: np.ndarray) -> np.ndarray:
    """Overlap (n,) [cells] of two picks of each node at the dip of the fault between them.

    It is 0 where no fault passes between the two, straight down.
    """
    # all pairs (pick, triangle of the fault in the same block of the map)
    corners = mesh.points[mesh.triangles]
    box = corners[..., :2].min(axis=1), corners[..., :2].max(axis=1)
    blocks = Blocks(*box, 0.0)
    upper, lower = _points(picks, high), _points(picks, low)
    rows, block = blocks.of(upper)
    count = blocks.starts[block + 1] - blocks.starts[block]
    point = np.repeat(rows, count)
    k = np.arange(len(point)) - np.repeat(np.cumsum(count) - count, count)
    t = blocks.items[np.repeat(blocks.starts[block], count) + k]

    # most triangles are above both picks, or below both
    foot, top = corners[..., 2].min(axis=1), corners[..., 2].max(axis=1)
    between = np.flatnonzero((foot[t] <= upper[point, 2]) & (top[t] >= lower[point, 2]))
    point, t = point[between], t[between]
    a, b, c = corners[t, 0], corners[t, 1], corners[t, 2]

    # height z of the fault under the upper pick, by barycentric weights v and w
    one, two, to = (v[:, :2] - a[:, :2] for v in (b, c, upper[point]))
    det = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
    known = np.where(det == 0.0, 1.0, det)  # upright triangles have no point between
    v = (to[:, 0] * two[:, 1] - to[:, 1] * two[:, 0]) / known
    w = (one[:, 0] * to[:, 1] - one[:, 1] * to[:, 0]) / known
    z = a[:, 2] + v * (b[:, 2] - a[:, 2]) + w * (c[:, 2] - a[:, 2])
    met = (det != 0.0) & (v >= 0) & (w >= 0) & (v + w <= 1)
    met &= (z < upper[point, 2]) & (z > lower[point, 2])

    # run: cells across strike for each cell of height, by the dip of the triangle
    normal = mesh.normals[t[met]]
    run = np.abs(normal[:, 2]) / np.maximum(np.hypot(*normal[:, :2].T), 1e-9)
    out = np.zeros(len(high))
    apart = (upper[point[met], 2] - lower[point[met], 2]) / mesh.cell
    np.maximum.at(out, point[met], apart * run)
    return out
