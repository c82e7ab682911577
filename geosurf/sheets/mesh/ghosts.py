"""Heights of ghosts: each sheet extrapolated past the fault, by the energy of the sheet itself.

A second, small solve on the torn mesh, with all real nodes fixed: ghosts must not draw on them.
Neighbours are taken in the mesh, so that each sector where faults meet is extrapolated by itself.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import partial

import numpy as np

from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.kernels.meshes.mesh import join_pairs
from geosurf.sheets.faults.cut_edges import EAST, NORTH
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.lattice.picks import Frame, Picks, scale_of
from geosurf.sheets.lattice.solve import STRETCH, Graph, around, lattice_graph, smoothest
from geosurf.sheets.mesh.torn_mesh import Torn, Triangles, outer_edges

HOLD = 1e-8  # weight that ties each ghost to the height of its anchor
JOINED = 8  # cells around ghosts with noisy data, in which real nodes are solved for with them
APART = 1e-6  # cells: a ghost stays this far from the other vertices of its node

Piece = tuple[int, dict[int, int]]  # lattice triangle, and the vertex over some of its nodes


def ghost_heights(
    torn: Torn,
    triangles: Triangles,
    cut: np.ndarray,
    heights: np.ndarray,
    stretch: np.ndarray,
    cell: float,
    fixed: dict[int, float],
    bent: Callable[..., np.ndarray] | None = None,
    scale: float = 1.0,
    order: int = 3,
) -> np.ndarray:
    """Heights (n_ghost,) of all ghosts; `fixed` has those that data give.

    `bent(nodes, anchors)` is what they and the sheet are bent by at tips: only the residual is
    smooth; `scale` and `order` are those of the sheet.
    """
    n_ghost = len(torn.anchor)
    # A sheet that no fault tears.
    if n_ghost == 0:
        return np.empty(0)
    shape = (triangles.n_row, triangles.n_col)
    # the mesh around the ghosts, with the bend at tips taken out
    nodes = around(torn.node_of_ghost, shape, order)
    nodes = nodes[np.isfinite(heights[nodes])]

    # vertices of the graph: nodes, then ghosts; value (n + n_ghost,) is what is left without bend
    graph, lost = mesh_graph(torn, triangles, nodes, cut)
    bend = bends(bent, torn, nodes)
    value = np.concatenate([heights[nodes], np.zeros(n_ghost)]) - bend

    # heights that data give
    known = np.zeros(n_ghost, dtype=bool)
    given = np.fromiter(fixed.keys(), dtype=np.int64, count=len(fixed))
    picked = np.fromiter(fixed.values(), dtype=np.float64, count=len(fixed))
    known[given] = True
    value[len(nodes) + given] += picked
    # Unknowns are numbered for the solver; -1 marks heights that are known.
    number = np.full(len(value), -1)
    free = np.flatnonzero(~known)
    number[len(nodes) + free] = np.arange(len(free))

    # each is drawn a very little to its anchor, and at tips to neighbours that have another
    pull = np.full(len(free), HOLD)
    anchor = torn.anchor[free]
    target = HOLD * (heights[anchor] - (0.0 if bent is None else bent(anchor)))
    rows = number[lost[:, 1]]
    lost, rows = lost[rows >= 0], rows[rows >= 0]
    drawn = (STRETCH / scale**2) ** 2
    np.add.at(pull, rows, drawn)
    np.add.at(target, rows, drawn * value[lost[:, 0]])
    out = value[len(nodes) :]
    out[free] = smoothest(
        graph, number, value, stretch, pull=pull, target=target / pull, scale=scale, order=order
    )
    # The bend that was taken out before comes back.
    out += bend[len(nodes) :]
    out[given] = picked
    return kept_apart(torn, heights, out, cell)


def bends(bent: Callable[..., np.ndarray] | None, torn: Torn, nodes: np.ndarray) -> np.ndarray:
    """By how much nodes, then all ghosts, are bent at tips [m]."""
    if bent is None:
        return np.zeros(len(nodes) + len(torn.anchor))
    return np.concatenate([bent(nodes), bent(torn.node_of_ghost, torn.anchor)])


def joined_heights(
    torn: Torn,
    triangles: Triangles,
    cut: np.ndarray,
    heights: np.ndarray,
    stretch: np.ndarray,
    fixed: dict[int, float],
    data: Callable[[np.ndarray], np.ndarray],
    weight: float,
    bent: Callable[..., np.ndarray] | None = None,
) -> tuple[np.ndarray, dict[int, float]]:
    """Where a sheet has noisy data past its trace, it and they are smoothed together.

    `data` gives those of some nodes, NaN where there are none; `bent(nodes, anchors)` is what they
    are bent by at tips, which is not smoothed. Writes new `heights` around the ghosts of `fixed`,
    and returns these nodes and smooth heights of the ghosts.
    """
    given = np.fromiter(fixed.keys(), dtype=np.int64, count=len(fixed))
    picked = np.fromiter(fixed.values(), dtype=np.float64, count=len(fixed))
    nodes, graph, value, bend, free = sheet_around(torn, triangles, cut, heights, given, bent)
    n = len(nodes)
    # As in `ghost_heights`, but real nodes next to the ghosts are unknowns as well.
    number = np.where(free, np.cumsum(free) - 1, -1)
    pull, target = np.full(len(value), HOLD), value.copy()

    # data of nodes and of ghosts, each with the weight that its noise allows
    known = data(nodes)
    seen = np.flatnonzero(np.isfinite(known))
    pull[seen], target[seen] = weight, known[seen] - bend[seen]
    pull[n + given], target[n + given] = weight, picked - bend[n + given]
    value[free] = smoothest(
        graph, number, value, stretch, pull=pull[free], target=target[free], scale=scale_of(weight)
    )
    value += bend
    moved = free[:n]
    heights[nodes[moved]] = value[:n][moved]
    return nodes[moved], dict(zip(given.tolist(), value[n + given].tolist(), strict=True))


def sheet_around(
    torn: Torn,
    triangles: Triangles,
    cut: np.ndarray,
    heights: np.ndarray,
    ghosts: np.ndarray,
    bent: Callable[..., np.ndarray] | None,
) -> tuple[np.ndarray, Graph, np.ndarray, np.ndarray, np.ndarray]:
    """The sheet around some ghosts, to be solved for with them: its nodes, then all ghosts.

    Nodes; the graph of both; heights without what they are bent by at tips, and that bend; which
    of them move.
    """
    shape = (triangles.n_row, triangles.n_col)

    # inner: nodes that move; three more cells of nodes hold them, as far as third differences reach
    inner = around(distinct(torn.node_of_ghost[ghosts]), shape, JOINED)
    nodes = distinct(around(inner, shape, 3), around(torn.node_of_ghost, shape, 3))
    nodes = nodes[np.isfinite(heights[nodes])]
    bend = bends(bent, torn, nodes)
    start = heights[torn.anchor] - (0.0 if bent is None else bent(torn.anchor))
    value = np.concatenate([heights[nodes] - bend[: len(nodes)], start])
    moves = np.concatenate([is_among(nodes, inner), np.ones(len(start), dtype=bool)])
    return nodes, mesh_graph(torn, triangles, nodes, cut)[0], value, bend, moves


def mesh_graph(
    torn: Torn, triangles: Triangles, nodes: np.ndarray, cut: np.ndarray
) -> tuple[Graph, np.ndarray]:
    """Real nodes, then ghosts, with their neighbours in the torn mesh.

    Also the pairs (real, ghost) that are neighbours, though the real one has another there.
    """
    shape = (triangles.n_row, triangles.n_col)

    # neighbours east and north: of nodes across uncut links, of ghosts in their copies
    base = lattice_graph(nodes, shape, cut)
    n, n_ghost = len(nodes), len(torn.anchor)

    # ways: row of the east and of the north neighbour of each vertex, -1 for none
    cell = np.stack(np.divmod(torn.node_of_ghost, triangles.n_col), axis=1)
    ways = [np.concatenate([to, np.full(n_ghost, -1)]) for to in (base.east, base.north)]
    real = [to >= 0 for to in ways]
    lost = []
    # East and north links only: diagonals carry no differences.
    _, kind = triangles.links(torn.node_of(torn.corners.ravel()).reshape(-1, 3))
    for direction, code in enumerate((EAST, NORTH)):
        # edges of copies of this kind with a ghost end, from their west or lower end
        copy, k = np.nonzero(kind == code)
        tail, head = torn.corners[copy, k], torn.corners[copy, (k + 1) % 3]
        back = torn.node_of(tail) > torn.node_of(head)
        tail, head = np.where(back, head, tail), np.where(back, tail, head)
        some = (tail >= torn.n_node) | (head >= torn.n_node)
        a, b = (_row(v[some], nodes, torn.n_node) for v in (tail, head))
        known = (a >= 0) & (b >= 0)
        a, b = a[known], b[known]
        free = ~real[direction][a]  # a real neighbour goes first: at a tip there are both
        ways[direction][a[free]] = b[free]
        lost.append(np.stack([a[~free], b[~free]], axis=1))
    east, north = ways

    # twists count where a ghost takes part: copies have no cut inside
    touches = np.zeros(len(east), dtype=bool)
    touches[n:] = True
    touches[:n] = (east[:n] >= n) | (north[:n] >= n)
    square = np.concatenate([base.square, np.ones(n_ghost, dtype=bool)]) | touches
    pairs = np.unique(np.concatenate(lost), axis=0)
    pairs = pairs[(pairs[:, 0] < n) & (pairs[:, 1] >= n)]
    return Graph(east, north, square, np.concatenate([base.cell, cell])), pairs


def _row(vertex: np.ndarray, nodes: np.ndarray, n_node: int) -> np.ndarray:
    """Row of each vertex: real nodes (increasing), then ghosts; -1 where it is neither."""
    at = np.searchsorted(nodes, vertex)
    at[at == len(nodes)] = 0
    # An empty list of nodes has no row 0 to compare with.
    found = nodes[at] == vertex if len(nodes) else np.zeros(len(vertex), dtype=bool)
    return np.where(vertex >= n_node, len(nodes) + vertex - n_node, np.where(found, at, -1))


def kept_apart(torn: Torn, heights: np.ndarray, ghosts: np.ndarray, cell: float) -> np.ndarray:
    """Where throw is nothing, sheets would coincide and be welded: keep them apart."""
    node, least = torn.node_of_ghost, APART * cell
    for _ in range(8):
        # ghosts go below the real node, then below each other: the lower of two that are too close
        # goes down by more than the least, which the next round checks again
        real = np.abs(ghosts - heights[node]) < least
        ghosts = np.where(real, heights[node] - least, ghosts)
        order = np.lexsort((ghosts, node))
        same = (np.diff(node[order]) == 0) & (np.diff(ghosts[order]) < least)
        if not real.any() and not same.any():
            break
        ghosts[order[:-1][same]] -= 1.5 * least
    return ghosts


def grow(torn: Torn, triangles: Triangles, chosen: np.ndarray) -> Torn:
    """One more ring of ghosts, along the outer edges among some edges of copies.

    `chosen` (n_copy, 3), bool: edges from each corner to the next.
    """
    seeds = _seeds(torn, triangles, chosen)
    pieces: list[Piece] = []
    at: dict[tuple[int, int], int] = {}
    for t, ends in seeds:
        # outer edges with a common vertex over one lattice triangle belong to one new triangle
        mates = {at[t, v] for v in ends.values() if (t, v) in at}
        mates_list = sorted(mates)
        if mates_list:
            piece = mates_list[0]
            pieces[piece][1].update(ends)
        else:
            piece = len(pieces)
            pieces.append((t, dict(ends)))
        for v in pieces[piece][1].values():
            at[t, v] = piece
    return _with_pieces(torn, triangles, pieces)


def _seeds(torn: Torn, triangles: Triangles, chosen: np.ndarray) -> list[Piece]:
    """(triangle beyond, {node: vertex}) of chosen outer edges."""
    copy, edge, beyond = outer_edges(torn, triangles)
    rows = np.flatnonzero(chosen[copy, edge])
    copy, edge, beyond = copy[rows], edge[rows], beyond[rows]
    one, two = torn.corners[copy, edge], torn.corners[copy, (edge + 1) % 3]
    at_one, at_two = torn.node_of(one).tolist(), torn.node_of(two).tolist()
    edges = zip(beyond.tolist(), one.tolist(), two.tolist(), at_one, at_two, strict=True)
    return [(t, {m: a, n: b}) for t, a, b, m, n in edges]


def _with_pieces(torn: Torn, triangles: Triangles, pieces: Sequence[Piece]) -> Torn:
    """Add pieces of new triangles; new corners over a common edge with a common end are one."""
    # New ghosts are numbered behind the old ones.
    n_old = torn.n_node + len(torn.anchor)
    corners = triangles.corners(np.array([t for t, _ in pieces], dtype=np.int64)).tolist()
    # (known node, other node, vertex over the known one) -> other corners of pieces with that edge
    edges: dict[tuple[int, int, int], list[int]] = {}
    for p, (_, known) in enumerate(pieces):
        for m, v in known.items():
            for k, n in enumerate(corners[p]):
                if m != n:
                    edges.setdefault((m, n, v), []).append(3 * p + k)

    # union of corners, 3 p + k for corner k of piece p: pieces that share an edge from a known end
    # share its other end
    pairs = [(first, other) for first, *others in edges.values() for other in others]
    lead = join_pairs(np.array(pairs, dtype=np.int64).reshape(-1, 2), 3 * len(pieces)).tolist()

    # known corners keep their vertex; each other group becomes one new ghost
    vertex: dict[int, int] = {}
    for p, (_, known) in enumerate(pieces):
        for k, n in enumerate(corners[p]):
            if n in known:
                vertex[lead[3 * p + k]] = known[n]
    anchors: list[int] = []
    nodes: list[int] = []
    rows = []
    for p, (_, known) in enumerate(pieces):
        row = []
        for k, n in enumerate(corners[p]):
            root = lead[3 * p + k]
            if root not in vertex:
                vertex[root] = n_old + len(nodes)
                # The anchor of a new ghost is that of a vertex next to it: it is on the same sheet.
                some = next(iter(known.values()))
                of = some if some < torn.n_node else int(torn.anchor[some - torn.n_node])
                anchors.append(of)
                nodes.append(n)
            row.append(vertex[root])
        rows.append(row)
    # No ring to add.
    if not rows:
        return torn
    return Torn(
        np.concatenate([torn.triangle, [t for t, _ in pieces]]),
        np.concatenate([torn.corners, np.array(rows, dtype=np.int64)]),
        np.concatenate([torn.anchor, np.array(anchors, dtype=np.int64)]),
        np.concatenate([torn.node_of_ghost, np.array(nodes, dtype=np.int64)]),
        torn.n_node,
        torn.divided,
    )


# ---- carry on ----------------------------------------
# Heights of the ghosts of picked sheets: by the energy, and by picks beyond the trace.


CarryOn = Callable[[Torn, Triangles, np.ndarray, Heights, Collection[int]], np.ndarray]
Known = Callable[[Torn, Triangles, np.ndarray, Heights, Callable | None], dict[int, float]]


def carry_on_by(frame: Frame, weight: float | None, known: Known, order: int = 3) -> CarryOn:
    """Make the function that gives the heights of all ghosts of one torn mesh.

    `weight` is that of noisy data, `order` that of the sheet's highest differences. `known` gives
    the heights of ghosts that picks determine.
    """

    def carry_on(
        torn: Torn, triangles: Triangles, bits: np.ndarray, state: Heights, early: Collection[int]
    ) -> np.ndarray:
        """Heights of the ghosts of one sheet; `early`: traces whose tears end early."""
        # The bend of throw at tips is known; only what is left is smooth and extrapolated.
        bent = None if state.bent is None else partial(state.bent.of, frame)
        fixed = known(torn, triangles, bits, state, bent)

        past = None
        # Ghosts bend only at traces where the sheet goes on beyond the fault as before it.
        if state.bent is not None:
            past = partial(state.bent.only(_bent_beyond(state, early)).of, frame)
        return ghost_heights(
            torn, triangles, bits, state.values, frame.stretch, frame.cell, fixed, past,
            scale_of(weight), order,
        )  # fmt: skip

    return carry_on


def ghosts_by_picks(
    picks: Picks, weight: float | None, mark: Callable[[np.ndarray], None]
) -> Known:
    """Make the function that gives the heights of the ghosts that picks determine.

    Where data are noisy the sheet changes with them: `mark` is called with its nodes.
    """

    def known(
        torn: Torn, triangles: Triangles, bits: np.ndarray, state: Heights, bent: Callable | None
    ) -> dict[int, float]:
        """Heights of ghosts, by number."""
        # Exact picks need no solve: they are the heights of their ghosts.
        fixed = _picked(picks, state, torn)
        if weight is not None and fixed:  # the sheet is one with its part beyond the trace
            nodes, fixed = joined_heights(
                torn, triangles, bits, state.values, picks.frame.stretch, fixed,
                lambda nodes: picks.means_at(nodes, state.used), weight, bent,
            )  # fmt: skip
            # The solver has to know which of its heights are no longer its own.
            mark(nodes)
        return fixed

    return known


def _bent_beyond(state: Heights, early: Collection[int]) -> list[int]:
    """Traces at whose tips ghosts bend as the sheet does: only what is left is extrapolated.

    Not where a tear ends early at a gap: bent ghosts have been tried there and left a hole.
    """
    # Gaps are positive, overlaps negative.
    heaves = [walls.left + walls.right for walls in state.walls]
    return [
        trace
        for trace, heave in enumerate(heaves)
        if trace not in early or (len(heave) and np.median(heave) < 0.0)
    ]


def _picked(picks: Picks, state: Heights, torn: Torn) -> dict[int, float]:
    """Ghosts whose heights were picked: an overlapping sheet beyond the trace."""
    heights: dict[int, list[float]] = {}

    # a node may have ghosts of several sheets: start to stop are those over the node of a pick
    order = np.argsort(torn.node_of_ghost, kind="stable")
    nodes = torn.node_of_ghost[order]
    # Trace by trace: sides are those of one trace.
    for trace in distinct(state.beyond[:, 1]):
        rows = state.beyond[state.beyond[:, 1] == trace]
        near = state.near[trace]
        at = near.look_up(torn.anchor)
        side = np.where(at >= 0, near.side[at], 0)
        start = np.searchsorted(nodes, picks.node[rows[:, 0]])
        stop = np.searchsorted(nodes, picks.node[rows[:, 0]], side="right")
        for pick, wall, a, b in zip(rows[:, 0], rows[:, 2], start, stop, strict=True):
            for ghost in order[a:b]:
                # the pick belongs to the ghost whose anchor lies on the pick's wall
                if side[ghost] == wall:
                    heights.setdefault(int(ghost), []).append(float(picks.z[pick]))
    # Several picks over one ghost: their mean.
    return {ghost: float(np.mean(z)) for ghost, z in heights.items()}
