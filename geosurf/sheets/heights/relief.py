"""What both walls of a fault have in common under noise: the relief that was there before it tore.

A wall that is rebuilt from its own noisy data alone is least sure at its end, which is its cut-off.
But a horizon was whole once, and what moved it apart is smoother along the fault than its relief.
So differences that reach across one trace are differences of what is left when the throw is taken
out: of u - sign / 2 (t0(s) + t1(s) d + t2(s) d^2 / 2), at s along the trace and d across it. t0 is
the throw, t1 and t2 are the differences of slopes and bends of the walls; they are cubic splines
along the trace, solved for with the heights. Heights have the smooth prior of a graph without the
cut, and throw one of its own: a partial spline (Wahba 1990, Spline Models for
Observational Data, ch. 9).

Data may contradict it: then walls are rebuilt apart (`geosurf.sheets.heights.tip_solve`).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.spatial import cKDTree

from geosurf.kernels.sheets.smooth_surface import places_in_order
from geosurf.sheets.faults.cut_edges import Cuts
from geosurf.sheets.faults.fault_distance import NearTrace
from geosurf.sheets.faults.network import Network
from geosurf.sheets.lattice.solve import Common, lattice_graph

KNOT = 4.0  # cells between the knots of a throw
# times as far as relief throw is averaged along its fault: see docs/validation/torn_sheets.md
LONGER = 4.0
CLEAR = 1.5  # cells from another trace within which walls have nothing in common
HOLD = 1e-4  # weight that keeps a coefficient which no difference holds
ORDERS = 3  # of the derivative across the fault, up to which walls may differ
SEEN = 6.0  # cells from a trace within which data may contradict it
FREE = 0.06  # degrees of freedom that walls lose for each node so near, averaged over one cell
MANY = np.iinfo(np.int64).max

Rows = tuple[np.ndarray, np.ndarray, np.ndarray]  # row, column and weight of each entry


@dataclass(frozen=True, eq=False)
class _Throw:
    """Splines along one trace: pieces between the places where it meets others.

    `piece` (n_vertex,) is -1 close to another trace; each piece has its first coefficient, the
    number of one order's, and the length along the trace at which it starts.
    """

    along: np.ndarray
    piece: np.ndarray
    first: np.ndarray
    number: np.ndarray
    origin: np.ndarray


def common_relief(
    nodes: np.ndarray,
    cuts: Cuts,
    network: Network,
    near: Sequence[NearTrace],
    shape: tuple[int, int],
    weights: np.ndarray,
    apart: Collection[int] = (),
) -> Common | None:
    """The rows that walls have in common, None if there are none.

    Parameters
    ----------
    nodes : ndarray of int64 (n,)
        Nodes that are solved for, increasing: columns 0 .. n - 1.
    cuts, network, near
        Of the solve.
    shape : (int, int)
    weights : ndarray (5,)
        As from `weights_of`.
    apart : collection of int
        Traces whose walls have nothing in common.
    """
    # unknowns: heights of `nodes`, then three splines for each piece of a trace
    throws = _throws(network, len(nodes), apart)
    limits = _limits(network, cuts)
    parts = _across(nodes, cuts, limits, near, throws, shape, weights)
    if not parts:
        return None
    parts += _stiffness(throws)

    # each part counts its rows from 0: number them on
    n_row = 0
    for row, _, _ in parts:
        row += n_row
        n_row = int(row.max(initial=n_row - 1)) + 1
    row, column, weight = (np.concatenate(part) for part in zip(*parts, strict=True))
    total = len(nodes) + sum(int(ORDERS * t.number.sum()) for t in throws)
    matrix = coo_array((weight, (row, column)), shape=(n_row, total)).tocsr()
    matrix.sum_duplicates()
    start, column = (a.astype(np.int64) for a in (matrix.indptr, matrix.indices))
    place = _places(start, column, total - len(nodes), nodes, shape)
    return Common(start, column, matrix.data, place, total - len(nodes))


def _places(
    start: np.ndarray,
    column: np.ndarray,
    n_coefficient: int,
    nodes: np.ndarray,
    shape: tuple[int, int],
) -> np.ndarray:
    """Places of all unknowns: nodes as if nothing were cut, coefficients after all they meet.

    They are few and meet many: rows of nodes stay short that way.
    """
    uncut = lattice_graph(nodes, shape)

    # the envelope is narrow if unknowns that meet are close in the order: uncut, both walls of a
    # trace are next to each other
    place_of_node = places_in_order(uncut.east, uncut.north, np.arange(len(nodes)))

    # most (n_row,): last place of a node in each row; last: the largest of a coefficient
    row = np.repeat(np.arange(len(start) - 1), np.diff(start))
    node = column < len(nodes)
    most, last = np.full(len(start) - 1, -1), np.full(n_coefficient, -1)
    np.maximum.at(most, row[node], place_of_node[column[node]])
    np.maximum.at(last, column[~node] - len(nodes), most[row[~node]])

    # a coefficient in no row goes with the next one that is in one
    known = np.flatnonzero(last >= 0)
    after = np.searchsorted(known, np.arange(n_coefficient))

    # stable: coefficients come right after the last node that they meet
    keys = np.concatenate([place_of_node, last[known[np.minimum(after, len(known) - 1)]]])
    place = np.empty(len(keys), dtype=np.int64)
    place[np.argsort(keys, kind="stable")] = np.arange(len(keys))
    return place


def _throws(network: Network, first: int, apart: Collection[int]) -> list[_Throw]:
    """Splines of all traces, their coefficients numbered from `first` on."""
    # torn parts of the traces in the map: near another one, it is not clear which throw counts
    torn = []
    for trace, (low, high) in zip(network.traces, network.solve, strict=True):
        vertex = np.arange(len(trace.line))
        torn.append(trace.line[(vertex >= np.ceil(low)) & (vertex <= np.floor(high)), :2])
    throws = []
    for k, trace in enumerate(network.traces):
        others = np.concatenate([np.empty((0, 2)), *(torn[:k] + torn[k + 1 :])])
        clear = np.full(len(trace.line), k not in apart)
        if len(others):
            clear &= cKDTree(others).query(trace.line[:, :2])[0] >= CLEAR

        # each run of clear vertices, one cell longer at both ends, has splines of its own
        # piece (n_vertex,): number of the run that a vertex is in, -1 where walls share nothing
        begins = clear & ~np.append(False, clear[:-1])
        piece = np.where(clear, np.cumsum(begins) - 1, -1)
        ends = np.flatnonzero(clear & ~np.append(clear[1:], False))
        origin = trace.along[begins] - 1.0
        length = trace.along[ends] + 1.0 - origin

        # cubic splines over n intervals have n + 3 coefficients
        number = np.ceil(length / KNOT).astype(np.int64) + 3
        starts = first + ORDERS * (np.cumsum(number) - number)
        first += ORDERS * int(number.sum())
        throws.append(_Throw(trace.along, piece, starts, number, origin))
    return throws


def _limits(network: Network, cuts: Cuts) -> np.ndarray:
    """Places (n_trace, 2) between which walls are torn: a tear may end before its tip."""
    limits = network.solve.copy()
    for k, trace in enumerate(network.traces):
        places = cuts.place[cuts.trace == k]

        # past the last cut link the sheet is whole: there is no throw to take out
        for end, last in enumerate((np.min, np.max)):
            if trace.ends[end] == "tip" and len(places):
                limits[k, end] = last(places)
    return limits


def _across(
    nodes: np.ndarray,
    cuts: Cuts,
    limits: np.ndarray,
    near: Sequence[NearTrace],
    throws: Sequence[_Throw],
    shape: tuple[int, int],
    weights: np.ndarray,
) -> list[Rows]:
    """Rows, columns and weights of all differences that reach across one trace and no other."""
    key, owner = _owners(cuts)
    if not len(key):
        return []
    start = _beside(cuts, shape)
    i, j = np.divmod(start, shape[1])
    parts: list[Rows] = []
    for offsets, ws, links, powers, order in DIFFERENCES:
        # nodes and links of this difference, at each place where it lies in the lattice
        wide, tall = (max(o[k] for o in offsets) for k in range(2))
        inside = (i + tall < shape[0]) & (j + wide < shape[1])
        base = start[inside]
        node = np.stack([base + y * shape[1] + x for x, y in offsets], axis=1)
        at = np.minimum(np.searchsorted(nodes, node), len(nodes) - 1)
        crossed = np.stack([4 * (base + y * shape[1] + x) + k for x, y, k in links], axis=1)

        # those that cross exactly one trace
        slot = np.minimum(np.searchsorted(key, crossed), len(key) - 1)

        # of (n, n_link): the trace that cuts each link, -1 for none; MANY fails the test below
        of = np.where(key[slot] == crossed, owner[slot], -1)
        trace = of.max(axis=1)
        single = ((of == trace[:, None]) | (of < 0)).all(axis=1) & (trace >= 0) & (trace < MANY)
        use = np.flatnonzero(single & (nodes[at] == node).all(axis=1))

        # rows of heights and of the throw of that trace
        # the weight of the order, over the step along columns and rows to their powers
        scale = weights[order - 1] * weights[3] ** powers[0] * weights[4] ** powers[1]
        for number in np.unique(trace[use]):
            rows = use[trace[use] == number]
            found = _place(node[rows], limits[number], near[number], throws[number])
            keep, piece, along, side, away = found
            if keep.any():
                columns = at[rows[keep]]
                w = scale * np.broadcast_to(np.array(ws), columns.shape)
                parts += _rows(columns, w, piece, along, side, away, throws[number])
    return parts


def _owners(cuts: Cuts) -> tuple[np.ndarray, np.ndarray]:
    """Cut links (node * 4 + kind), increasing, and the trace that cuts each; MANY: several do."""
    key, first = 4 * cuts.node + cuts.kind, np.empty(0, dtype=np.int64)

    # several traces may cut one link: such differences reach across both and are left out
    order = np.argsort(key, kind="stable")
    key, trace = key[order], cuts.trace[order]
    if not len(key):
        return key, trace
    first = np.flatnonzero(np.append(True, key[1:] != key[:-1]))
    least, most = np.minimum.reduceat(trace, first), np.maximum.reduceat(trace, first)
    return key[first], np.where(least == most, least, MANY)


def _beside(cuts: Cuts, shape: tuple[int, int]) -> np.ndarray:
    """Nodes, increasing, at which a difference may start that has a cut link in it."""
    # the widest difference has four nodes: it starts three before the link, or one after
    i, j = np.divmod(np.unique(cuts.node), shape[1])
    nodes = []
    for y in range(-3, 2):
        for x in range(-3, 2):
            inside = (i + y >= 0) & (i + y < shape[0]) & (j + x >= 0) & (j + x < shape[1])
            nodes.append((i[inside] + y) * shape[1] + j[inside] + x)
    return np.unique(np.concatenate(nodes))


def _place(
    node: np.ndarray, limits: np.ndarray, near: NearTrace, throw: _Throw
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Differences (n, m) all of whose nodes lie beside one piece of a trace, and how they do."""
    # row (n, m): of each node among those near the trace, -1 if it is none
    row = near.look_up(node.ravel()).reshape(node.shape)
    place, side = near.place[row], near.side[row]
    low, high = limits
    vertex = np.where(row >= 0, np.rint(np.where(row >= 0, place, 0.0)), 0).astype(np.int64)
    piece = throw.piece[vertex]
    keep = ((row >= 0) & (place > low) & (place < high)).all(axis=1)
    keep &= (piece[:, 0] >= 0) & (piece == piece[:, :1]).all(axis=1)

    # s and d of the method (see the top), both in cells; d has the sign of the side
    along = np.interp(place[keep], np.arange(len(throw.along)), throw.along)
    side = side[keep]
    return keep, piece[keep, 0], along, side, side * near.distance[row[keep]]


def _rows(
    columns: np.ndarray,
    weights: np.ndarray,
    piece: np.ndarray,
    along: np.ndarray,
    side: np.ndarray,
    away: np.ndarray,
    throw: _Throw,
) -> list[Rows]:
    """Differences of heights less the throw, half of it on each side."""
    n, m = columns.shape
    row = np.repeat(np.arange(n), m)
    parts = [(row, columns.ravel(), weights.ravel())]

    # entries of t0, t1 and t2: half the throw each side, times 1, d and d**2 / 2
    knot, share = _cubic(((along - throw.origin[piece, None]) / KNOT).ravel())
    number = np.repeat(throw.number[piece], m)
    first = np.repeat(throw.first[piece], m)
    half, powers = -0.5 * (weights * side).ravel(), (1.0, away.ravel(), 0.5 * away.ravel() ** 2)
    row = np.repeat(row, 4)
    for order, power in enumerate(powers):
        column = (first + order * number + knot)[:, None] + np.arange(4)
        parts.append((row, column.ravel(), ((half * power)[:, None] * share).ravel()))
    # one block of rows: its parts share their numbers
    row, column, weight = (np.concatenate(part) for part in zip(*parts, strict=True))
    return [(row, column, weight)]


def _cubic(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First of the four cubic B-splines (de Boor 1978) that are not 0 at x, and their values."""
    knot = np.floor(x).astype(np.int64)
    t = x - knot
    values = (1.0 - t) ** 3, 3.0 * t**3 - 6.0 * t**2 + 4.0, 3.0 * t * (1.0 + t - t * t) + 1.0, t**3
    return knot, np.stack(values, axis=1) / 6.0


def _stiffness(throws: Sequence[_Throw]) -> list[Rows]:
    """Rows that keep a throw and how walls differ smooth along the fault."""
    parts = []

    # third differences of t0, second of t1, first of t2: each is a derivative across already
    steps = np.array([-1.0, 3.0, -3.0, 1.0]), np.array([1.0, -2.0, 1.0]), np.array([-1.0, 1.0])
    for throw in throws:
        for first, number in zip(throw.first, throw.number, strict=True):
            for order, step in enumerate(steps):
                begin = first + order * number
                n = number - len(step) + 1
                scale = LONGER**3 * np.sqrt((1.0, 3.0, 3.0)[order] / KNOT ** (5 - 2 * order))
                row = np.repeat(np.arange(n), len(step))
                column = begin + np.arange(n)[:, None] + np.arange(len(step))
                parts.append((row, column.ravel(), np.tile(scale * step, n)))
                held = np.arange(number)
                parts.append((held, begin + held, np.full(number, HOLD)))
    return parts


Node = tuple[int, int]  # column, row: offsets from the first node of a difference
Link = tuple[int, int, int]  # column, row, kind
# nodes, weights, links that it crosses, derivatives along columns and rows, order
Difference = tuple[tuple[Node, ...], tuple[float, ...], tuple[Link, ...], tuple[int, int], int]
# all links of a cell with its diagonals, and those of the cell east of it
CELL = ((0, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 0, 2), (0, 0, 3))
NEXT = tuple((j + 1, i, kind) for j, i, kind in CELL)


def _turned(
    nodes: Sequence[Node], links: Sequence[Link]
) -> tuple[tuple[Node, ...], tuple[Link, ...]]:
    """A difference the other way: rows for columns."""
    # east and north links change places; diagonals stay what they are
    turn = (1, 0, 2, 3)
    return tuple((j, i) for i, j in nodes), tuple((j, i, turn[k]) for i, j, k in links)


def _differences() -> list[Difference]:
    """Nodes, weights, links, powers of both ways, order: all second and third differences."""
    differences: list[Difference] = []
    # along columns, then along rows
    for order, weights in ((2, (1.0, -2.0, 1.0)), (3, (-1.0, 3.0, -3.0, 1.0))):
        nodes = tuple((k, 0) for k in range(order + 1))
        links = tuple((k, 0, 0) for k in range(order))
        differences.append((nodes, weights, links, (order, 0), order))
        nodes, links = _turned(nodes, links)
        differences.append((nodes, weights, links, (0, order), order))

    # the twist, twice in the energy of a plate: once for each order of the derivatives
    block = ((0, 0), (1, 0), (0, 1), (1, 1))
    twist = tuple(np.sqrt(2.0) * np.array([1.0, -1.0, -1.0, 1.0]))
    differences.append((block, twist, CELL, (1, 1), 2))

    # mixed third differences, which come three times
    nodes = tuple((k, i) for i in range(2) for k in range(3))
    ramp = tuple(np.sqrt(3.0) * np.array([1.0, -2.0, 1.0, -1.0, 2.0, -1.0]))
    differences.append((nodes, ramp, CELL + NEXT, (2, 1), 3))
    nodes, links = _turned(nodes, CELL + NEXT)
    differences.append((nodes, ramp, links, (1, 2), 3))
    return differences


DIFFERENCES = _differences()
