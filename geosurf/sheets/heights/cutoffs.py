"""Fault polygons as data: nodes next to a fault whose heights make the walls end on its lines.

A polygon states where both walls of a fault end, and so its throw, where a grid has smeared it
away. A node next to the fault gets its height on the straight line from the polygon to the nearest
datum that is used: the slope of a sheet between the two is not known yet.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.sheets.faults.fault_distance import NearTrace
from geosurf.sheets.faults.traces import Trace
from geosurf.sheets.heights.state import Drawn, Heights, Inputs

STEP = 0.5  # cells between places along a line of a polygon
REACH = 8.0  # cells from the trace within which lines are its cut-offs
TRUSTED = 12.0  # cells from the trace within which a datum in use is looked for
OTHERS = 4.0  # cells from the trace of another fault within which polygons are not used


class Wall(NamedTuple):
    """Nodes of one wall that a line draws, their heights, and how far off the sheet was [m]."""

    node: np.ndarray
    height: np.ndarray
    off: np.ndarray
    trace: int
    side: float


def drawn_by_polygons(inputs: Inputs, state: Heights) -> Drawn | None:
    """Nodes that fault polygons draw, with their heights; None without any."""
    walls: list[Wall] = []
    for number, trace in enumerate(state.network.traces):
        lines = inputs.cutoffs.get(inputs.meshes[trace.fault].name)
        if lines is not None:
            walls += walls_at(inputs, state, number, lines)
    if not sum(len(wall.node) for wall in walls):
        return None

    # several places of a line may draw one node: their mean does
    count = [len(wall.node) for wall in walls]
    nodes, first, at = np.unique(
        np.concatenate([wall.node for wall in walls]), return_index=True, return_inverse=True
    )
    total = np.bincount(at, np.concatenate([wall.height for wall in walls]))
    numbers, sides = (np.repeat([wall[k] for wall in walls], count)[first] for k in (3, 4))
    return Drawn(nodes, total / np.bincount(at), numbers, sides)


def drawn_again(base: np.ndarray, near: Sequence[NearTrace], heights: np.ndarray) -> Drawn:
    """Nodes of `BaseHeights.drawn` that are on the same walls still, at heights of all nodes."""
    node, trace, side = base[:, np.isfinite(heights[base[0]])]
    stays = np.zeros(len(node), dtype=bool)
    for number, near_trace in enumerate(near):
        mine = np.flatnonzero(trace == number)
        row = near_trace.look_up(node[mine])
        stays[mine] = (row >= 0) & (near_trace.side[row] == side[mine])
    node = node[stays]
    return Drawn(node, heights[node], trace[stays], side[stays])


def walls_at(
    inputs: Inputs, state: Heights, number: int, lines: Sequence[np.ndarray]
) -> list[Wall]:
    """Both walls of a trace, the hanging wall first, if `lines` are theirs."""
    traces, trace = state.network.traces, state.network.traces[number]
    beside = [
        near.nodes_within(OTHERS)
        for other, near in zip(traces, state.near, strict=True)
        if other.fault != trace.fault
    ]
    others = distinct(state.unknown[:0], *beside)
    sides = zip(lines, (1.0, -1.0), strict=True)
    return [
        _wall(inputs, state, number, others, _places_on(inputs, trace, line), side)
        for line, side in sides
    ]


def _places_on(inputs: Inputs, trace: Trace, line: np.ndarray) -> np.ndarray:
    """Places (n, 3) along a line [cells, cells, m], where the trace is on its fault."""
    frame = inputs.picks.frame
    points = np.column_stack([frame.to_cells(line[:, :2]), line[:, 2]])
    along = np.r_[0.0, np.hypot(*np.diff(points[:, :2], axis=0).T).cumsum()]
    steps = np.linspace(0.0, along[-1], max(int(along[-1] / STEP), 1) + 1)
    places = np.stack([np.interp(steps, along, points[:, k]) for k in range(3)], axis=1)
    far, vertex = cKDTree(trace.line[:, :2]).query(places[:, :2])
    return places[(far <= REACH) & (vertex > trace.start) & (vertex < trace.stop)]


def _wall(
    inputs: Inputs, state: Heights, number: int, others: np.ndarray, places: np.ndarray, side: float
) -> Wall:
    """Nodes of the wall on one side of a trace that the places of its line draw."""
    near = state.near[number]
    rows = near.within(TRUSTED)
    nodes = near.node[rows[near.side[rows] == side]]
    nodes = nodes[np.isfinite(state.values[nodes])]
    is_solved = is_among(nodes, state.unknown)
    if is_solved.all() or not is_solved.any() or not len(places):
        return Wall(nodes[:0], np.empty(0), np.empty(0), number, side)

    # a straight line from each place to the nearest datum in use: its height at the nearest node
    cells = inputs.picks.frame.cells_of_node(nodes)
    solved, known = np.flatnonzero(is_solved), np.flatnonzero(~is_solved)
    _, row = cKDTree(cells[solved]).query(places[:, :2])
    _, far = cKDTree(cells[known]).query(places[:, :2])
    row, far = solved[row], known[far]
    ahead, to = cells[far] - places[:, :2], cells[row] - places[:, :2]
    share = (to * ahead).sum(axis=1) / (ahead * ahead).sum(axis=1)
    height = places[:, 2] + share * (state.values[nodes[far]] - places[:, 2])
    clear = ~is_among(nodes[row], others) & (share > -1.0) & (share < 1.0)
    node, height = nodes[row[clear]], height[clear]
    return Wall(node, height, height - state.values[node], number, side)
