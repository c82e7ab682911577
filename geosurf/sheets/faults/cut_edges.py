"""Links of the lattice that faults cut: one table, from which solve and mesh take their parts.

One predicate makes it (`geosurf.kernels.sheets.link_lines.cut_links`), so that a triangle has
an odd number of cut edges exactly where a trace ends in it. The solve tears past the ends of a
fault, the mesh never does: a tear that is longer than its fault is a hole.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from geosurf.kernels.sheets.link_lines import UNIT, cut_links
from geosurf.sheets.faults.fault_distance import NearTrace, side_over
from geosurf.sheets.faults.traces import FaultMesh, Trace
from geosurf.sheets.lattice.picks import Frame

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
            rows = np.flatnonzero((cuts.trace == i) & (cuts.node == node) & (cuts.kind == kind))
            beyond = cuts.place[rows] < end if k == 0 else cuts.place[rows] > end
            drop += rows.tolist()
            if not len(rows):
                left = _side_at(traces[i].line[:, :2] / frame.stretch, end, node, kind, frame)
                more.append((node, kind, i, end, left))
            elif beyond[0]:  # past its main trace
                more.append((node, kind, i, end, int(cuts.left[rows[0]])))
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
        low, high = traces[trace].place_at([first, last])
        out &= (cuts.trace != trace) | (cuts.place < low) | (cuts.place > high)
    return out


# ---- heave ----------------------------------------
# Where the cut-offs of both walls of a fault lie: how wide the gap, or the overlap, along a
# trace.
#
# They are read off the heights of each side at the links that the trace cuts.


@dataclass(eq=False)
class Walls:
    """Along one trace: how far each wall's cut-off lies from it, into its own side [cells].

    `place` (vertex numbers); `left` and `right`, positive where the horizon has a gap on that
    side, negative where it overlaps the trace; `throw` [m], left side down positive.
    """

    place: np.ndarray
    left: np.ndarray
    right: np.ndarray
    throw: np.ndarray

    def gap(self, place: np.ndarray, side: np.ndarray) -> np.ndarray:
        """Signed gap at places on one side or the other."""
        if len(self.place) == 0:
            return np.zeros(len(place))
        left = np.interp(place, self.place, self.left)
        return np.where(side > 0, left, np.interp(place, self.place, self.right))

    def heave(self, place: np.ndarray) -> np.ndarray:
        """Gap of both sides together: negative where the horizon overlaps."""
        return self.gap(place, np.ones(len(place))) + self.gap(place, -np.ones(len(place)))


def walls_of(
    heights: np.ndarray, every: Cuts, traces: Sequence[Trace], frame: Frame
) -> list[Walls]:
    """Where the two walls' cut-offs lie, from the heights of each side at the cut links."""
    shape, stretch, cell = frame.shape, frame.stretch, frame.cell
    bits = every.bits(len(heights))
    walls = []
    for number, trace in enumerate(traces):
        rows = np.flatnonzero((every.trace == number) & (every.kind < RISING))
        cuts = every.take(rows[np.argsort(every.place[rows], kind="stable")])

        # at each cut link: place [cells], height of the trace [m], normal of the fault
        x, y, middle, nx, ny, nz = trace.at(cuts.place).T
        at = np.stack([x, y], axis=1) / stretch

        # height of both sheets where the trace cuts each link [m]
        left, right = (_at_cut(heights, bits, cuts, at, shape, side) for side in (1, -1))

        # a running median of 15 links: single links next to a contact or a tip do not count
        known = np.isfinite(left) & np.isfinite(right)
        left, right = _median(left[known], 15), _median(right[known], 15)

        # distance across strike = height above the trace times the slope [cells per m]
        slope = (nz / np.maximum(np.hypot(nx, ny), 1e-9) / cell)[known]
        left_gap, right_gap = (middle[known] - left) * slope, (right - middle[known]) * slope
        walls.append(Walls(cuts.place[known], left_gap, right_gap, right - left))
    return walls


def _at_cut(
    heights: np.ndarray,
    bits: np.ndarray,
    cuts: Cuts,
    at: np.ndarray,
    shape: tuple[int, int],
    side: int,
) -> np.ndarray:
    """Height of one side's sheet where a trace cuts each link, extrapolated along the link."""
    n_col = shape[1]
    first, second = cuts.ends(n_col)

    # here: the end of the link on the asked side, there: its other end, across the fault
    here = np.where(cuts.left == side, first, second)
    there = np.where(cuts.left == side, second, first)

    # extrapolate along the link, unless it is cut behind, too
    behind = 2 * here - there
    row, col = np.divmod(here, n_col)
    row2, col2 = np.divmod(np.clip(behind, 0, len(heights) - 1), n_col)

    # behind is one link further on the same row or column; at the border it may not be a node
    whole = (behind >= 0) & (behind < len(heights)) & (abs(row2 - row) + abs(col2 - col) == 1)
    behind = np.where(whole, behind, here)
    whole &= bits[np.minimum(here, behind)] & (1 << cuts.kind) == 0
    away = np.hypot(*(at - np.stack([col, row], axis=1)).T)
    return np.where(whole, heights[here] + away * (heights[here] - heights[behind]), np.nan)


def _median(values: np.ndarray, width: int) -> np.ndarray:
    """Running median; beyond the ends the last value goes on, so that throw may die there."""
    n = len(values)
    if n == 0:
        return values
    half = min(width // 2, (n - 1) // 2)
    windows = sliding_window_view(np.pad(values, half, mode="edge"), 2 * half + 1)
    return np.partition(windows, half, axis=1)[:, half]


def throw_beside(heights: np.ndarray, near: NearTrace, block: np.ndarray) -> float:
    """Size of a fault's throw next to some nodes, from the data on its two sides [m]."""
    at = near.look_up(block)

    # 20 vertices more to both sides, and data within six cells: enough for a median
    places = near.place[at[at >= 0]]
    if len(places) == 0:
        return np.inf
    low, high = places.min() - 20.0, places.max() + 20.0
    beside = near.within(6.0)
    beside = beside[(near.place[beside] >= low) & (near.place[beside] <= high)]
    beside = beside[np.isfinite(heights[near.node[beside]])]
    sides = [heights[near.node[beside[near.side[beside] == side]]] for side in (1.0, -1.0)]
    if not len(sides[0]) or not len(sides[1]):
        return np.inf
    return float(abs(np.median(sides[0]) - np.median(sides[1])))


# ---- last edges ----------------------------------------
# The last link of a tear: both of its nodes on their own sides of the fault, or the sheet leaks.
#
# There the walls are one again, so that throw dies there. Between the cut-offs of a fault that
# leaves a gap, neither wall has rock, and a node has the height of one of them extrapolated past
# the fault. That is cut off again, except at the last link, whose nodes both walls have: one that
# is beyond the fault, or on it, goes to the fault, on its own side. A trace along a line of nodes
# has such nodes only.


CLEAR = 1e-4  # cells above and below a node within which it is still on its own side
HALVINGS = 60  # of the way between both walls, until the fault is found


def last_link(
    cuts: Cuts, trace: int, end: int, limit: float, rising: bool, n_col: int
) -> tuple[int, ...]:
    """Both nodes of the link of the mesh at which a tear ends: the first one outside of a limit."""
    rows = np.flatnonzero((cuts.trace == trace) & (cuts.kind != (FALLING if rising else RISING)))

    # distance of each link outside of the limit, as vertex numbers; the nearest one is the last
    past = limit - cuts.place[rows] if end == 0 else cuts.place[rows] - limit
    rows, past = rows[past > 0], past[past > 0]
    if not len(rows) or not np.isfinite(limit):
        return ()
    one, two = cuts.take(rows[[past.argmin()]]).ends(n_col)
    return int(one[0]), int(two[0])


def on_own_side(
    mesh: FaultMesh, frame: Frame, node: int, side: float, height: float, other: float
) -> float:
    """Height at which a node is on a side (+1 hanging wall) of a fault, as near as can be.

    `height` is that of its own wall, `other` that of the other one, extrapolated to it.
    """
    cells = frame.cells_of_node(np.array([node]))[0]
    reach = 1.0 + abs(other - height) / frame.cell
    clear = CLEAR * frame.cell

    side_at = side_over(mesh, cells, reach)
    above, below = (side_at(np.array([height + clear, height - clear])) == side).tolist()

    # on its side, or within `clear` of the fault: a small step away from it decides
    if above and below:
        return height
    if above or below:
        return height + 2.0 * clear if above else height - 2.0 * clear

    def is_on_side(z: float) -> bool:
        """Whether the node is on its side at an elevation."""
        return bool(side_at(np.array([z]))[0] == side)

    if not is_on_side(other):
        return height

    # bisection: the side changes once between both heights; 60 halvings reach the last digit
    good, bad = other, height
    for _ in range(HALVINGS):
        middle = 0.5 * (good + bad)
        if middle in (good, bad):
            break
        good, bad = (middle, bad) if is_on_side(middle) else (good, middle)
    return good + float(np.clip(other - good, -2.0 * clear, 2.0 * clear))
