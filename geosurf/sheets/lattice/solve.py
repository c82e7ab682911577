"""The smoothest sheet through trusted data: only the nodes near faults are unknown.

See `geosurf.kernels.sheets.smooth_surface` for the energy. Differences across cut links do not
exist, so each side is built from its own side only, bends freely at the fault, and heals past a
tip.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.sparse import csc_array, csr_array

from geosurf.errors import InvariantError
from geosurf.kernels.lattices.sets import distinct
from geosurf.kernels.sheets.node_bands import dilate_nodes
from geosurf.kernels.sheets.smooth_surface import (
    add_squares,
    factorise,
    fill_envelope,
    normal_equations,
    places_in_order,
    steps_from,
    substitute,
)

if TYPE_CHECKING:  # pragma: no cover - types only
    from scipy.sparse import csc_array, csr_array


# ---- sparse ----------------------------------------
# The energy of a surface as a sparse matrix, for solves in which data are rows of the equations.
#
# On grids the unknowns are nodes in a band, and `geosurf.sheets.lattice.solve` factorises an
# envelope. Rows of scattered points couple nodes in any order: there SuperLU solves.


EXACT = 1.0  # weight of points without noise: bilinear cells cannot meet them better
# SuperLU in the order of a symmetric matrix: pivots off the diagonal would fill it seven times over
CHOLESKY = {
    "permc_spec": "MMD_AT_PLUS_A",
    "diag_pivot_thresh": 0.0,
    "options": {"SymmetricMode": True},
}


def energy_of(graph: Graph, unknown: np.ndarray, weights: np.ndarray) -> csc_array:
    """Sparse matrix (n_unknown, n_unknown) of the energy; `unknown` as for `smoothest`."""
    # one row per unknown: weights, and the columns that they belong to, -1 for none
    matrix, column = normal_equations(
        graph.east, graph.north, graph.square, graph.cell, unknown, weights
    )
    present = column >= 0
    where = np.repeat(np.arange(len(column)), present.sum(axis=1)), column[present]
    return csc_array((matrix[present], where), shape=(len(column), len(column)))


# ---- drape ----------------------------------------
# The horizon filled across its faults without any tear, and which absent nodes may be filled.


def around(nodes: np.ndarray, shape: tuple[int, int], steps: int) -> np.ndarray:
    """Nodes within some steps, rows and columns, of given ones; increasing."""
    return dilate_nodes(distinct(nodes), *shape, steps)


def narrow_gaps(present: np.ndarray, width: float) -> np.ndarray:
    """Absent nodes in gaps and holes up to `width` cells across, bool like `present` (2-D)."""
    if present.all():
        return np.zeros_like(present)
    # a closing with a disk: absent nodes into which no disk of that width fits between data
    r = int(np.ceil(0.5 * width)) + 1
    reached = distance_transform_edt(~np.pad(present, r)) <= 0.5 * width
    # nodes outside the lattice count as reached, so that a gap may run out of it
    inner = np.zeros_like(reached)
    inner[r:-r, r:-r] = True
    closed = distance_transform_edt(reached | ~inner) > 0.5 * width
    return closed[r:-r, r:-r] & ~present


def draped(
    heights: np.ndarray,
    fill: np.ndarray,
    shape: tuple[int, int],
    stretch: np.ndarray,
    bend: float = 0.0,
) -> np.ndarray:
    """Heights (n,) of the nodes of `fill` through the others; NaN where no link leads to any.

    A membrane, which never overshoots; `bend` is the share of second differences.
    """
    # first differences reach one node, second ones two: a rim so wide holds the fill
    band = around(fill, shape, 2 if bend else 1)
    graph = lattice_graph(band, shape)
    unknown = np.full(len(band), -1)
    at = np.searchsorted(band, fill)
    unknown[at] = np.arange(len(fill))
    value = heights[band]

    # nodes that no link ties to a height stay NaN
    graph = without_absent(graph, np.isfinite(value) | (unknown >= 0))
    tied = grounded(graph, unknown)
    keep = np.full(len(band), -1)
    keep[at[tied]] = np.arange(tied.sum())
    graph = without_absent(graph, np.isfinite(value) & (unknown < 0) | (keep >= 0))

    value = np.where(np.isfinite(value), value, 0.0)
    out = np.full(len(fill), np.nan)
    out[tied] = smoothest(graph, keep, value, stretch, bend=bend, third=0.0)
    return out


def without_absent(graph: Graph, present: np.ndarray) -> Graph:
    """The graph without nodes that do not exist."""
    # a link needs both of its nodes
    east, north = (
        np.where(present & (to >= 0) & present[to], to, -1) for to in (graph.east, graph.north)
    )
    return Graph(east, north, graph.square & present, graph.cell)


BEND, STRETCH = 0.3, 0.01  # shares of second and first differences, against third ones
# shares of second and third differences, against fourth ones
BEND_OF_FOURTH, THIRD_OF_FOURTH = 0.03, 0.3


@dataclass(frozen=True, eq=False)
class Graph:
    """Nodes with their neighbours across uncut links.

    Attributes
    ----------
    east, north : ndarray of int64 (n,)
        Neighbour, or -1.
    square : ndarray of bool (n,)
        Whether both diagonals of the block north-east of the node are uncut.
    cell : ndarray of int64 (n, 2)
        Row and column.
    """

    east: np.ndarray
    north: np.ndarray
    square: np.ndarray
    cell: np.ndarray


def lattice_graph(
    nodes: np.ndarray, shape: tuple[int, int], cut: np.ndarray | None = None
) -> Graph:
    """The graph of some nodes of a lattice, increasing; `cut` as from `Cuts.bits`, if any is."""
    # bits 1 and 2: east and north link cut; 4 and 8: a diagonal, so that the cell has no twist
    bits = np.zeros(len(nodes), dtype=np.int64) if cut is None else cut[nodes].astype(np.int64)
    place, n = np.stack(np.divmod(nodes, shape[1]), axis=1), len(nodes)
    # the row of each node's neighbour among the nodes, -1 where it is missing or the link is cut
    to_east = np.append(nodes[1:] == nodes[:-1] + 1, False) & (place[:, 1] < shape[1] - 1)
    east = np.where(to_east & (bits & 1 == 0), np.arange(1, n + 1), -1)
    above = np.searchsorted(nodes, nodes + shape[1])
    to_north = np.append(nodes, -1)[above] == nodes + shape[1]
    north = np.where(to_north & (bits & 2 == 0), above, -1)
    return Graph(east, north, bits & 12 == 0, place)


@dataclass(frozen=True, eq=False)
class Common:
    """Rows of the energy that reach across traces, over nodes and coefficients of throws.

    Attributes
    ----------
    start, column, weight : ndarray
        Row k has columns column[start[k] : start[k + 1]]: nodes first, then coefficients.
    place : ndarray of int64 (n_unknown,)
        Of nodes and coefficients in the order in which they are solved for.
    n_coefficient : int
    """

    start: np.ndarray
    column: np.ndarray
    weight: np.ndarray
    place: np.ndarray
    n_coefficient: int

    @property
    def matrix(self) -> csr_array:
        """The rows as a sparse matrix."""
        shape = len(self.start) - 1, len(self.place)
        return csr_array((self.weight, self.column, self.start), shape=shape)


def smoothest(
    graph: Graph,
    unknown: np.ndarray,
    value: np.ndarray,
    stretch: np.ndarray,
    bend: float = BEND,
    third: float = 1.0,
    pull: np.ndarray | None = None,
    target: np.ndarray | None = None,
    scale: float = 1.0,
    order: int = 3,
    loose: Callable[[int], Exception] | None = None,
) -> np.ndarray:
    """Solve for the unknown nodes.

    Parameters
    ----------
    graph : Graph
    unknown : ndarray of int64 (n,)
        Number of each unknown node, 0 .. n_unknown - 1; -1 where `value` holds.
    value : ndarray (n,)
        Heights of the known nodes.
    pull, target : ndarray (n_unknown,), optional
        Weight and height of data that an unknown is drawn to, for noisy ones.
    scale : float
        Cells over which such data are averaged.
    order : int
        Of the highest differences: 3, or 4 for data without noise.
    loose : callable, optional
        Makes the error if data do not hold an unknown, by its number.

    Returns
    -------
    ndarray (n_unknown,)
    """
    n = int(unknown.max(initial=-1)) + 1
    if n == 0:
        return np.empty(0)
    weights, fourth = weights_of(stretch, bend, third, scale), None
    if order == 4:
        weights, fourth = fourth_order(graph, stretch)
    system, right, level = equations(graph, unknown, value, weights, pull, target, fourth=fourth)
    return system.solved([right], loose)[0] + level


@dataclass(frozen=True, eq=False)
class System:
    """A symmetric matrix in its envelope; see `geosurf.kernels.sheets.smooth_surface`.

    Attributes
    ----------
    place : ndarray of int64 (n_unknown,)
        Of each unknown, in the order in which it is solved for.
    first, start : ndarray of int64
    lower : ndarray
    """

    place: np.ndarray
    first: np.ndarray
    lower: np.ndarray
    start: np.ndarray

    def solved(
        self, rights: Sequence[np.ndarray], loose: Callable[[int], Exception] | None = None
    ) -> list[np.ndarray]:
        """Solve for some right sides (n_unknown,); once, since the matrix becomes its factor.

        `loose` makes the error if data do not hold an unknown, by its number.
        """
        # a pivot of 0 means an unknown that nothing ties, which callers rule out by `grounded`
        stuck = factorise(self.first, self.lower, self.start)
        if stuck >= 0:
            number = int(np.flatnonzero(self.place == stuck)[0])
            if loose is not None:
                raise loose(number)
            raise InvariantError(
                f"the sheet's equations are singular at unknown {number} of {len(self.place)}; "
                "please report this with the horizon and its faults."
            )
        solutions, placed = [], np.empty(len(self.place))
        for right in rights:
            placed[self.place] = right
            solutions.append(substitute(self.first, self.lower, self.start, placed)[self.place])
        return solutions


def equations(
    graph: Graph,
    unknown: np.ndarray,
    value: np.ndarray,
    weights: np.ndarray,
    pull: np.ndarray | None = None,
    target: np.ndarray | None = None,
    common: Common | None = None,
    fourth: FourthDifferences | None = None,
) -> tuple[System, np.ndarray, float]:
    """Matrix, right side, and the level that heights are counted from; see `smoothest`.

    With what walls have in `common` no node is known, and its coefficients are unknowns, too.
    `fourth` differences are added to those that `weights` stand for.
    """
    # heights count from their mean: digits go to the relief, not to the depth
    known = value[unknown < 0]
    if pull is not None and target is not None:
        known = np.append(known, target[pull > 0])
    level = float(known.mean()) if len(known) else 0.0
    if common is None:
        place = places_in_order(graph.east, graph.north, unknown)
    else:
        place = common.place

    # rows of the smoothness energy (Briggs 1974), then those that reach across traces
    first, lower, start, right = fill_envelope(
        graph.east, graph.north, graph.square, unknown, value - level, weights, place
    )
    if common is not None:
        row, column, weight = common.start, common.column, common.weight
        first, lower, start = add_squares(first, lower, start, row, column, weight, place)

    right = right[place]
    if fourth is not None:
        # known nodes draw the unknown ones that share a difference with them
        row, column, weight = fourth.of_unknown(unknown)
        first, lower, start = add_squares(first, lower, start, row, column, weight, place)
        held = np.where(unknown < 0, value - level, 0.0)
        drawn = fourth.gradient(held[:, None])[:, 0]
        right[unknown[unknown >= 0]] -= drawn[unknown >= 0]

    # data: a weight on the diagonal, and the weighted height on the right side
    if pull is not None and target is not None:
        lower[start[place + 1] - 1] += pull
        right += pull * np.where(pull > 0, target - level, 0.0)
    return System(place, first, lower, start), right, level


def weights_of(
    stretch: np.ndarray, bend: float, third: float = 1.0, scale: float = 1.0
) -> np.ndarray:
    """Weights of first, second and third differences, and of the two ways of a cell.

    Noise that is averaged over `scale` cells leaves a sheet as on a lattice with cells that wide:
    there a second difference weighs, against a third one, as `scale` times less does here.
    """
    return np.array([STRETCH / scale**2, bend / scale, third, *(1.0 / stretch)])


def fourth_order(graph: Graph, stretch: np.ndarray) -> tuple[np.ndarray, FourthDifferences]:
    """Weights of lower differences next to fourth ones, and those: for data without noise."""
    weights = weights_of(stretch, BEND_OF_FOURTH, THIRD_OF_FOURTH)
    return weights, fourth_differences(graph.east, graph.north, graph.square, stretch)


def with_more(graph: Graph, n: int) -> Graph:
    """A graph with n more nodes that no link joins to any."""
    none = np.full(n, -1)
    return Graph(
        np.concatenate([graph.east, none]),
        np.concatenate([graph.north, none]),
        np.concatenate([graph.square, np.zeros(n, dtype=bool)]),
        np.concatenate([graph.cell, np.zeros((n, 2), dtype=np.int64)]),
    )


def grounded(graph: Graph, unknown: np.ndarray) -> np.ndarray:
    """Whether each unknown is tied to a known node by uncut links, bool (n_unknown,)."""
    # breadth first from known nodes: what is not reached is not tied
    far = len(unknown) + 1
    steps = steps_from(graph.east, graph.north, unknown < 0, far)
    out = np.zeros(int(unknown.max(initial=-1)) + 1, dtype=bool)
    mine = np.flatnonzero(unknown >= 0)
    out[unknown[mine]] = steps[mine] < far
    return out


def reached(graph: Graph, free: np.ndarray) -> np.ndarray:
    """Nodes that hold a height, and `free` ones, bool (n,), that uncut links tie to such a node."""
    out = ~free
    out[free] = grounded(graph, np.where(free, np.cumsum(free) - 1, -1))
    return out


def steps_to_known(graph: Graph, unknown: np.ndarray) -> np.ndarray:
    """Number of uncut links from each node to the nearest known one, at most 64."""
    return steps_from(graph.east, graph.north, unknown < 0, 64)


def on_the_way(graph: Graph, steps: np.ndarray, far: int) -> np.ndarray:
    """Nodes more than `far` steps from known ones, and those on shortest ways there; increasing.

    `steps` (n,) as from `steps_to_known`: each step of a shortest way is one less.
    """
    # the four neighbours of each node: ahead by its links, back by those of the nodes behind
    beside = []
    for ahead in (graph.east, graph.north):
        back = np.full(len(ahead), -1)
        linked = np.flatnonzero(ahead >= 0)
        back[ahead[linked]] = linked
        beside += [ahead, back]

    # walk back from the border of the far nodes, one step nearer to known ones each time
    layers = [np.flatnonzero(steps > far)]
    front = layers[0][steps[layers[0]] == far + 1]
    for level in range(far, 0, -1):
        front = distinct(*(neighbour[front] for neighbour in beside))
        front = front[front >= 0]
        front = front[steps[front] == level]
        layers.append(front)
    return distinct(*layers)


LINE = (1.0, -4.0, 6.0, -4.0, 1.0)
# binomials of the mixed ones: three steps one way and one the other, and two each way; the roots
# are those of how often each comes among all fourth derivatives
RAMP = tuple(2.0 * np.array([1.0, -3.0, 3.0, -1.0, -1.0, 3.0, -3.0, 1.0]))
SADDLE = tuple(np.sqrt(6.0) * np.array([1.0, -2.0, 1.0, -2.0, 4.0, -2.0, 1.0, -2.0, 1.0]))


@dataclass(frozen=True, eq=False)
class FourthDifferences:
    """All fourth differences on a graph: those with all nodes there and no cut link inside.

    Attributes
    ----------
    blocks : list of (ndarray of int64 (n, k), ndarray (k,))
        Nodes of the differences of one kind, and their weights.
    """

    blocks: list[tuple[np.ndarray, np.ndarray]]

    def gradient(self, heights: np.ndarray) -> np.ndarray:
        """Derivatives (n, k) of half the energy by heights (n, k)."""
        out = np.zeros_like(heights)
        for nodes, weights in self.blocks:
            left = sum(w * heights[at] for at, w in zip(nodes.T, weights, strict=True))
            for at, w in zip(nodes.T, weights, strict=True):
                for k in range(heights.shape[1]):
                    out[:, k] += np.bincount(at, w * left[:, k], len(heights))
        return out

    def of_unknown(self, number: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows over unknowns: row k has columns column[start[k] : start[k + 1]] and weights.

        `number` (n_node,) of each unknown, -1 for known nodes, which have no column.
        """
        counts, columns, weights = [], [], []
        for nodes, weight in self.blocks:
            at = number[nodes]
            is_unknown = at >= 0
            counts.append(is_unknown.sum(axis=1))
            columns.append(at[is_unknown])
            weights.append(np.broadcast_to(weight, at.shape)[is_unknown])
        start = np.concatenate([[0], np.cumsum(np.concatenate(counts))])
        return start, np.concatenate(columns), np.concatenate(weights)


def fourth_differences(
    to_east: np.ndarray, to_north: np.ndarray, square: np.ndarray, stretch: np.ndarray
) -> FourthDifferences:
    """All fourth differences of a graph.

    Parameters
    ----------
    to_east, to_north, square : ndarray (n,)
        As in `geosurf.sheets.lattice.solve.Graph`.
    stretch : ndarray (2,)
        Of its cells along columns and rows.
    """
    wx, wy = (1.0 / stretch).tolist()
    start = np.arange(len(to_east))
    blocks = []

    # straight ones, both ways
    east, north = (_steps(start, to, 4) for to in (to_east, to_north))
    for line, w in ((east, wx), (north, wy)):
        blocks.append((_whole(line), w**4 * np.array(LINE)))

    # mixed ones lie on whole blocks: `across` leads over the block north-east of a node
    one, two = _hop(to_north, east[1]), _hop(to_east, north[1])
    across = np.where(square & (one == two), one, -1)
    for line, w in ((east, wx**3 * wy), (north, wx * wy**3)):
        other = north if line is east else east
        beyond = [other[1], *(_hop(across, at) for at in line[:3])]
        blocks.append((_whole([*line[:4], *beyond]), w * np.array(RAMP)))
    upper = [north[1], across, _hop(across, east[1])]
    top = [north[2], _hop(across, north[1]), _hop(across, across)]
    saddle = _whole([*east[:3], *upper, *top])
    blocks.append((saddle, (wx * wy) ** 2 * np.array(SADDLE)))
    return FourthDifferences(blocks)


def _steps(start: np.ndarray, to: np.ndarray, n: int) -> list[np.ndarray]:
    """Nodes after 0 to n steps along links, -1 where there is none."""
    nodes = [start]
    for _ in range(n):
        nodes.append(_hop(to, nodes[-1]))
    return nodes


def _hop(to: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """The node that each leads to, -1 from none."""
    return np.where(nodes >= 0, to[nodes], -1)


def _whole(nodes: Sequence[np.ndarray]) -> np.ndarray:
    """Nodes (n, k) of the differences that exist."""
    every = np.stack(nodes, axis=1)
    return every[(every >= 0).all(axis=1)]
