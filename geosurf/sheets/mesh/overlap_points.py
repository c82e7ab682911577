"""Scattered points of an overlapping sheet that lie past the trace of their fault.

A reverse fault makes a horizon overlap itself: points of each wall go on past the trace, over the
other wall. They give the heights of the ghosts of their own wall between the four vertices of a
cell, as points in front of the trace do for the nodes (`geosurf.sheets.heights.point_solver`).
Ghosts and the nodes around them are solved for together, so that a wall is as smooth beyond its
trace as before it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.kernels.sheets.smooth_surface import energy_gradient
from geosurf.sheets.faults.fault_distance import NearTrace
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.lattice.drape import around
from geosurf.sheets.lattice.noise import scale_of
from geosurf.sheets.lattice.scattered import Scattered
from geosurf.sheets.lattice.solve import BEND, Graph, weights_of
from geosurf.sheets.lattice.sparse import CHOLESKY, EXACT, energy_of
from geosurf.sheets.mesh.ghosts import HOLD, JOINED, bends, mesh_graph
from geosurf.sheets.mesh.torn_mesh import Torn, Triangles


def points_beyond_trace(
    picks: Scattered, state: Heights, torn: Torn
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points past a trace whose cell has all four vertices on the sheet of their own wall.

    Returns
    -------
    vertex : ndarray of int64 (n, 4)
        Of `torn`: nodes of that wall, and its ghosts over those of the other one.
    share : ndarray (n, 4)
        Of each vertex in the height at the point.
    pick : ndarray of int64 (n,)
    """
    # each trace and side: points past the trace that belong to the wall of that side
    nodes, shares = picks.corners()
    found = [(np.empty((0, 4), np.int64), np.empty((0, 4)), np.empty(0, np.int64))]
    for trace, side in np.unique(state.beyond[:, 1:], axis=0).tolist():
        mine = (state.beyond[:, 1:] == (trace, side)).all(axis=1)
        pick = state.beyond[mine, 0]
        vertex = on_sheet(nodes[pick], state.near[trace], side, torn)
        whole = (vertex >= 0).all(axis=1)
        found.append((vertex[whole], shares[pick[whole]], pick[whole]))
    vertex, share, pick = (np.concatenate(part) for part in zip(*found, strict=True))
    return vertex, share, pick


def on_sheet(nodes: np.ndarray, near: NearTrace, side: int, torn: Torn) -> np.ndarray:
    """The vertex of one wall's sheet over each node, of any shape; -1 where there is not one."""
    # own nodes stay; over nodes of the other wall, the ghost whose anchor is on this side
    at = near.look_up(nodes.ravel())
    own = (at >= 0) & (near.side[at] == side)
    of = near.look_up(torn.anchor)
    ghosts = np.flatnonzero((of >= 0) & (near.side[of] == side))
    ghosts = ghosts[np.argsort(torn.node_of_ghost[ghosts], kind="stable")]
    over = torn.node_of_ghost[ghosts]

    # ghosts first to stop of the sorted list lie over each node
    first, stop = (np.searchsorted(over, nodes.ravel(), side=end) for end in ("left", "right"))
    out = np.full(nodes.size, -1)
    single = stop - first == 1  # where sectors meet a wall may have several
    out[single] = torn.n_node + ghosts[first[single]]
    out[own] = nodes.ravel()[own]
    return out.reshape(nodes.shape)


def ghosts_by_points(
    picks: Scattered, weight: float | None
) -> Callable[[Torn, Triangles, np.ndarray, Heights, Callable | None], dict[int, float]]:
    """Make the function that gives heights of the ghosts that points determine; it writes nodes."""

    def found(
        torn: Torn, triangles: Triangles, bits: np.ndarray, state: Heights, bent: Callable | None
    ) -> dict[int, float]:
        """Heights of ghosts, by number."""
        vertex, share, pick = points_beyond_trace(picks, state, torn)
        # No overlap: ghosts follow from the energy alone.
        if not len(pick):
            return {}

        # nodes near these ghosts move with them; farther ones hold the sheet
        fixed = distinct(vertex[vertex >= torn.n_node]) - torn.n_node
        shape = picks.frame.shape
        inner = around(distinct(torn.node_of_ghost[fixed]), shape, JOINED)
        nodes = distinct(around(inner, shape, 3), around(torn.node_of_ghost, shape, 3))
        nodes = nodes[np.isfinite(state.values[nodes])]

        # points of the wall itself in that region are rows as well
        used = np.flatnonzero(state.used)
        own, shares = picks.corners()
        used = used[is_among(own[used].ravel(), nodes).reshape(-1, 4).all(axis=1)]
        vertex, pick = np.concatenate([own[used], vertex]), np.concatenate([used, pick])

        # rows whose four vertices are in the graph; slot (n, 4): their rows there
        known = is_among(vertex.ravel(), nodes).reshape(-1, 4) | (vertex >= torn.n_node)
        rows = known.all(axis=1)
        vertex, pick, share = vertex[rows], pick[rows], np.concatenate([shares[used], share])[rows]
        slot = np.where(
            vertex >= torn.n_node,
            len(nodes) + vertex - torn.n_node,
            np.searchsorted(nodes, vertex),
        )

        # solve for what is left without the bend at tips, nodes first, then ghosts
        graph, _ = mesh_graph(torn, triangles, nodes, bits)
        bend = bends(bent, torn, nodes)
        start = state.values[torn.anchor] - (0.0 if bent is None else bent(torn.anchor))
        value = np.concatenate([state.values[nodes] - bend[: len(nodes)], start])
        moves = np.concatenate([is_among(nodes, inner), np.ones(len(torn.anchor), dtype=bool)])
        z = picks.z[pick] - (share * bend[slot]).sum(axis=1)
        value = _drawn_to(graph, value, moves, slot, share, z, picks.frame.stretch, weight) + bend
        moved = moves[: len(nodes)]
        state.values[nodes[moved]] = value[: len(nodes)][moved]
        return dict(zip(fixed.tolist(), value[len(nodes) + fixed].tolist(), strict=True))

    return found


def _drawn_to(
    graph: Graph,
    value: np.ndarray,
    moves: np.ndarray,
    slot: np.ndarray,
    share: np.ndarray,
    z: np.ndarray,
    stretch: np.ndarray,
    weight: float | None,
) -> np.ndarray:
    """Heights (n,) that are smooth where they move, bool (n,), and near points z (m,).

    Each point lies between the vertices `slot` (m, 4), by `share` (m, 4). What no point and no
    fixed height reaches stays about where it was.
    """
    from scipy.sparse import csc_array, eye_array
    from scipy.sparse.linalg import splu

    # heights from the mean of the points: digits go to the relief, not to the depth
    level = float(z.mean())
    free = np.flatnonzero(moves)
    # Unknowns are the vertices that move; the others enter the right-hand side.
    number = np.where(moves, np.cumsum(moves) - 1, -1)
    weights = weights_of(stretch, BEND, scale=scale_of(weight))
    fixed = np.where(moves, 0.0, value - level)
    held = energy_gradient(graph.east, graph.north, graph.square, fixed[:, None], weights)[free, 0]

    # rows of points (m, n_vertex); left: what the fixed vertices leave over
    where = np.repeat(np.arange(len(z)), 4), slot.ravel()
    points = csc_array((share.ravel(), where), shape=(len(z), len(value)))
    left = z - level - points @ fixed
    points = csc_array(points[:, free])

    # energy, plus the square of the misfits, plus a very small pull to where vertices were
    pull = weight or EXACT
    matrix = energy_of(graph, number, weights) + pull * (points.T @ points)
    factor = splu(csc_array(matrix + HOLD * eye_array(len(free))), **CHOLESKY)
    right = pull * (points.T @ left) - held + HOLD * (value[free] - level)
    out = value.copy()
    out[free] = factor.solve(right) + level
    return out
