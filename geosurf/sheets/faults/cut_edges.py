"""Links of the lattice that faults cut: one table, from which solve and mesh take their parts.

One predicate makes it (`geosurf.kernels.sheets.fault_distance.cut_links`), so that a triangle has
an odd number of cut edges exactly where a trace ends in it. The solve tears past the ends of a
fault, the mesh never does: a tear that is longer than its fault is a hole.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geosurf.kernels.sheets.fault_distance import UNIT, cut_links
from geosurf.sheets.faults.traces import Trace
from geosurf.sheets.lattice.frame import Frame

EAST, NORTH, RISING, FALLING = range(4)

Part = tuple[int, float, float]  # of a trace: its number, first and last place along it [cells]
# a branch and its end (0 or 1), the place at which it ends; its main trace, and the place on that
Joint = tuple[int, int, float, int, float]


@dataclass(frozen=True, eq=False)
class Cuts:
    """Cut links, one row each, every fault by itself.

    Attributes
    ----------
    node, kind : ndarray of int64 (n,)
        The link: its west or lower node (its cell's lower left one for diagonals), and which.
    trace : ndarray of int64 (n,)
        Row of the traces.
    place : ndarray of float64 (n,)
        Where along the trace, as a vertex number.
    left : ndarray of int64 (n,)
        +1 if the link's first node is left of the trace; FALLING starts at its east node.
    """

    node: np.ndarray
    kind: np.ndarray
    trace: np.ndarray
    place: np.ndarray
    left: np.ndarray

    def take(self, rows: np.ndarray) -> Cuts:
        """Some of the rows."""
        return Cuts(*(getattr(self, k)[rows] for k in ("node", "kind", "trace", "place", "left")))

    def ends(self, n_col: int) -> tuple[np.ndarray, np.ndarray]:
        """First and second node of each link."""
        # a falling link runs from the lower right node of its cell to the upper left one
        first = self.node + (self.kind == FALLING)
        second = self.node + np.array([1, n_col, n_col + 1, n_col])[self.kind]
        return first, second

    def bits(self, n_node: int) -> np.ndarray:
        """One byte per node: bit k is set if its link of kind k is cut."""
        out = np.zeros(n_node, dtype=np.uint8)
        np.bitwise_or.at(out, self.node, (1 << self.kind).astype(np.uint8))
        return out


def cuts_of(traces: list[Trace], frame: Frame) -> Cuts:
    """All links that are crossed an odd number of times by a trace."""
    tables = []
    for number, line in enumerate(trace.line for trace in traces):
        x, y = whole_units(line[:, :2] / frame.stretch).T
        ends = np.stack([x[:-1], y[:-1], x[1:], y[1:]], axis=1)
        rows, place = cut_links(ends, *frame.shape)

        # a link that is crossed twice is not cut: both ends are on the same side
        key = rows[:, 0] * 4 + rows[:, 1]
        order = np.lexsort((rows[:, 2] + place, key))
        rows, place, key = rows[order], place[order], key[order]
        _, first, times = np.unique(key, return_index=True, return_counts=True)
        first = first[times % 2 == 1]
        rows, place = rows[first], place[first]
        tables.append((rows, np.full(len(rows), number), rows[:, 2] + place))
    if not tables:
        none = np.empty(0, dtype=np.int64)
        return Cuts(none, none, none, np.empty(0), none)
    rows = np.concatenate([t[0] for t in tables])
    trace, place = (np.concatenate([t[k] for t in tables]) for k in (1, 2))
    return Cuts(rows[:, 0], rows[:, 1], trace, place, rows[:, 3])


def cut_at_joints(cuts: Cuts, joints: Sequence[Joint], traces: list[Trace], frame: Frame) -> Cuts:
    """The same links, right where a link goes around the end of a branch.

    A link that crosses a main trace before and after the place where a branch ends on it has both
    its ends on one side of the main trace, and counts as uncut by it. Its ends are on different
    sides of the branch if the branch is on their side and does not cross the link, and on the same
    side of it if the branch crosses the link: the other way round than crossings alone show.
    """
    drop: list[int] = []
    more: list[tuple[int, int, int, float, int]] = []
    for i, k, end, j, place in joints:
        for node, kind in _links_around(traces[j].line[:, :2] / frame.stretch, place, frame):
            # not crossed by the branch: it has to be cut; crossed: it must not, unless the crossing
            # lies past the main trace, where the branch does not exist
            found = np.flatnonzero((cuts.trace == i) & (cuts.node == node) & (cuts.kind == kind))
            beyond = cuts.place[found] < end if k == 0 else cuts.place[found] > end
            drop += found.tolist()
            if not len(found):
                left = _side_at(traces[i].line[:, :2] / frame.stretch, end, node, kind, frame)
                more.append((node, kind, i, end, left))
            elif beyond[0]:  # past its main trace
                more.append((node, kind, i, end, int(cuts.left[found[0]])))
    if not drop and not more:
        return cuts
    kept = cuts.take(np.setdiff1d(np.arange(len(cuts.node)), drop))
    columns = [kept.node, kept.kind, kept.trace, kept.place, kept.left]
    if more:
        columns = [np.append(c, d) for c, d in zip(columns, zip(*more, strict=True), strict=True)]

    # by trace, then node and kind, as `cuts_of` lists them
    order = np.lexsort((columns[1], columns[0], columns[2]))
    return Cuts(*columns).take(order)


def _links_around(line: np.ndarray, place: float, frame: Frame) -> list[tuple[int, int]]:
    """Links (node, kind) that a line [lattice] crosses once before and once after a place."""
    x, y = whole_units(line).T

    # no link is longer than a diagonal: pieces within two cells are all that can cross it
    near = (np.abs(line - _at(line, place)) <= 2.0).all(axis=1)
    pieces = np.flatnonzero(near[:-1] & near[1:])
    ends = np.stack([x[pieces], y[pieces], x[pieces + 1], y[pieces + 1]], axis=1)
    rows, share = cut_links(ends, *frame.shape)
    before: dict[tuple[int, int], list[bool]] = {}
    for (node, kind, piece, _), part in zip(rows.tolist(), share.tolist(), strict=True):
        before.setdefault((node, kind), []).append(float(pieces[piece]) + part < place)
    return [link for link, sides in before.items() if sorted(sides) == [False, True]]


def _side_at(line: np.ndarray, place: float, node: int, kind: int, frame: Frame) -> int:
    """+1 if the first node of a link is left of a line [lattice] next to a place."""
    first = node + (kind == FALLING)
    row, col = divmod(int(first), frame.shape[1])
    piece = min(int(place), len(line) - 2)

    # which side, from the sign of the cross product
    way, to = line[piece + 1] - line[piece], np.array([col, row]) - _at(line, place)
    return 1 if way[0] * to[1] - way[1] * to[0] > 0 else -1


def _at(line: np.ndarray, place: float) -> np.ndarray:
    """The point of a line at a place."""
    vertex = np.arange(len(line))
    return np.array([np.interp(place, vertex, column) for column in line.T])


def whole_units(xy: np.ndarray) -> np.ndarray:
    """Columns and rows (n, 2) in units of 2**-22, off all lines of the lattice; see `cut_links`."""
    # x is 2 modulo 4 and y odd: no vertex lies on a row, a column or a diagonal
    x = 2 * (2 * np.floor(xy[:, 0] * (UNIT // 4)).astype(np.int64) + 1)
    y = 2 * np.floor(xy[:, 1] * (UNIT // 2)).astype(np.int64) + 1
    return np.stack([x, y], axis=1)


def within(cuts: Cuts, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Rows whose place lies between limits given per trace."""
    return (cuts.place >= low[cuts.trace]) & (cuts.place <= high[cuts.trace])


def is_torn(cuts: Cuts, untorn: Sequence[Part], traces: Sequence[Trace]) -> np.ndarray:
    """Cut links, bool (n,), outside of parts (trace, first, last) of traces [cells] left out."""
    out = np.ones(len(cuts.place), dtype=bool)
    for trace, first, last in untorn:
        along = traces[trace].along
        vertex = np.arange(len(along))
        low, high = np.interp([first, last], along, vertex)
        out &= (cuts.trace != trace) | (cuts.place < low) | (cuts.place > high)
    return out
