"""The smoothest sheet through trusted data: only the nodes near faults are unknown.

See `geosurf.kernels.bending` for the energy. Differences across cut links do not exist, so each
side is built from its own side only, bends freely at the fault, and heals past a tip.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geosurf.contact.threads import side_by_side
from geosurf.errors import InvariantError
from geosurf.kernels.envelope import factorise, fill_envelope, places_in_order, substitute
from geosurf.kernels.nodes import links_between
from geosurf.kernels.reach import steps_from
from geosurf.sheets.islands import in_order, tiled

LEAST = 8_000  # nodes: smaller islands are solved with the next one
BEND, STRETCH = 0.3, 0.01  # shares of second and first differences, against third ones


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
    bits = np.zeros(len(nodes), dtype=np.int64) if cut is None else cut[nodes].astype(np.int64)
    east, north = links_between(nodes, bits, shape[1])
    return Graph(east, north, bits & 12 == 0, np.stack(np.divmod(nodes, shape[1]), axis=1))


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
        Over how many cells such data are meant.

    Returns
    -------
    ndarray (n_unknown,)
    """
    n = int(unknown.max(initial=-1)) + 1
    if n == 0:
        return np.empty(0)
    weights = weights_of(stretch, bend, third, scale)
    level = level_of(unknown, value, pull, target)
    found = np.empty(n)

    def solve(rows: np.ndarray | None) -> None:
        """Solve for the unknowns of one island; each writes its own."""
        part, number, mine = _only(graph, unknown, rows)
        if not len(mine):
            return
        of_data = (None, None) if pull is None or target is None else (pull[mine], target[mine])
        held = value if rows is None else value[rows]
        system, right = equations(part, number, held, weights, level, *of_data)
        found[mine] = system.solved([right])[0] + level

    side_by_side(solve, [(rows,) for rows in _islands(graph)])
    return found


def _islands(graph: Graph) -> list[np.ndarray | None]:
    """Rows of the nodes of each island of a large graph; None is all of a small one."""
    if len(graph.cell) < 2 * LEAST:
        return [None]
    island, n = in_order(tiled(*graph.cell.T)[1], LEAST)
    return [np.flatnonzero(island == k) for k in range(n)] if n > 1 else [None]


def _only(graph: Graph, unknown: np.ndarray, rows: np.ndarray | None):
    """The graph of some nodes, their unknowns counted anew, and which those were.

    Links lead to neighbouring nodes of the lattice, which are never of another island.
    """
    if rows is None:
        return graph, unknown, np.arange(int(unknown.max(initial=-1)) + 1)
    number = np.full(len(unknown), -1)
    number[rows] = np.arange(len(rows))
    east, north = (
        np.where(to >= 0, number[to], -1) for to in (graph.east[rows], graph.north[rows])
    )
    mine = unknown[rows]
    free = mine >= 0
    counted = np.where(free, np.cumsum(free) - 1, -1)
    return Graph(east, north, graph.square[rows], graph.cell[rows]), counted, mine[free]


@dataclass(frozen=True, eq=False)
class System:
    """A symmetric matrix in its envelope; see `geosurf.kernels.envelope`.

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

    def solved(self, rights: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Solve for some right sides (n_unknown,); once, since the matrix becomes its factor."""
        stuck = factorise(self.first, self.lower, self.start)
        if stuck >= 0:
            number = int(np.flatnonzero(self.place == stuck)[0])
            raise InvariantError(
                f"the sheet's equations are singular at unknown {number} of {len(self.place)}; "
                "please report this with the horizon and its faults."
            )
        found, placed = [], np.empty(len(self.place))
        for right in rights:
            placed[self.place] = right
            found.append(substitute(self.first, self.lower, self.start, placed)[self.place])
        return found


def level_of(unknown, value, pull=None, target=None) -> float:
    """The level that heights are counted from: a mean, so that digits go to what differs."""
    known = value[unknown < 0]
    if pull is not None and target is not None:
        known = np.append(known, target[pull > 0])
    return float(known.mean()) if len(known) else 0.0


def equations(
    graph: Graph, unknown, value, weights, level: float, pull=None, target=None
) -> tuple[System, np.ndarray]:
    """Matrix and right side of heights above a level; see `smoothest`."""
    place = places_in_order(graph.east, graph.north, unknown)
    first, lower, start, right = fill_envelope(
        graph.east, graph.north, graph.square, unknown, value - level, weights, place
    )
    right = right[place]
    if pull is not None and target is not None:
        lower[start[place + 1] - 1] += pull
        right += pull * np.where(pull > 0, target - level, 0.0)
    return System(place, first, lower, start), right


def weights_of(
    stretch: np.ndarray, bend: float, third: float = 1.0, scale: float = 1.0
) -> np.ndarray:
    """Weights of first, second and third differences, and of the two ways of a cell.

    Noise that is meant over `scale` cells leaves a sheet as on a lattice with cells so wide: there
    a second difference weighs, against a third one, as `scale` times less does here.
    """
    return np.array([STRETCH / scale**2, bend / scale, third, *(1.0 / stretch)])


def grounded(graph: Graph, unknown: np.ndarray) -> np.ndarray:
    """Whether each unknown is tied to a known node by uncut links, bool (n_unknown,)."""
    far = len(unknown) + 1
    steps = steps_from(graph.east, graph.north, unknown < 0, far)
    out = np.zeros(int(unknown.max(initial=-1)) + 1, dtype=bool)
    mine = np.flatnonzero(unknown >= 0)
    out[unknown[mine]] = steps[mine] < far
    return out


def steps_to_known(graph: Graph, unknown: np.ndarray, longest: int = 64) -> np.ndarray:
    """Number of uncut links from each node to the nearest known one, at most `longest`."""
    return steps_from(graph.east, graph.north, unknown < 0, longest)
