"""Faults that end on another fault: their traces, on the wall of the main fault that they are in.

A branch meets the horizon on one wall of its main fault only. Across the heave of the main fault
the drape lies between both walls, at another height, so that the trace of the branch there would
be somewhere else: at an acute contact, cells away from where branch and horizon really part. Here
the wall of the branch is extrapolated past the main fault, and the branch is traced on that.
From its real end the trace is led straight to the trace of the main fault, through the gap.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.sheets.faults.fault_distance import (
    NearTrace,
    mesh_blocks,
    side_at_own_height,
    side_of_few,
)
from geosurf.sheets.faults.traces import FaultMesh, Trace
from geosurf.sheets.lattice.drape import around, without_absent
from geosurf.sheets.lattice.frame import Frame
from geosurf.sheets.lattice.solve import grounded, lattice_graph, smoothest

ON = 0.02  # cells from its main fault within which a fault ends on it
CARRY = 6.0  # cells that a wall is extrapolated past its main fault
FAR = 30.0  # cells from a main fault within which it is asked on which side a branch is
WALL = 12.0  # cells from the trace of the main fault within which its walls are distinguished
EVERY = 0.5  # cells between the places of a branch that are asked for their side
MOST = 4000  # of them on an edge
PAST = 0.5  # cells that a branch is led past the trace of its main fault

# trace number, end (0 or 1), main fault
TraceContact = tuple[int, int, int]


def contacts(traces: list[Trace], meshes: list[FaultMesh]) -> list[TraceContact]:
    """Ends of traces that lie on another fault, at their own height."""
    if not traces:
        return []

    # rows 2 i and 2 i + 1: both ends of trace i
    ends = np.concatenate([real_ends(trace) for trace in traces])
    far = [side_of_few(mesh, ends, 1.0)[0] for mesh in meshes]
    return [
        (i, k, j)
        for i, trace in enumerate(traces)
        for j in range(len(meshes))
        if j != trace.fault
        for k in range(2)
        if far[j][2 * i + k] <= ON and trace.ends[k] != "closed"
    ]


def real_ends(trace: Trace) -> np.ndarray:
    """Where a trace really starts and stops (2, 3)."""
    vertex = np.arange(len(trace.line))
    ends = [[np.interp(p, vertex, c) for c in trace.line.T[:3]] for p in (trace.start, trace.stop)]
    return np.array(ends)


def mains_first(branches: dict[int, set[int]]) -> list[int]:
    """Faults that end on others, each after those that it ends on (circles as they come)."""
    order: list[int] = []

    def visit(fault: int, above: tuple[int, ...]) -> None:
        """List a fault after those that it ends on."""
        # `above`: the faults that led here; one of them again closes a circle, which is not
        # followed
        if fault in order or fault in above:
            return
        for main in sorted(branches.get(fault, ())):
            visit(main, (*above, fault))
        if fault in branches:
            order.append(fault)

    for fault in sorted(branches):
        visit(fault, ())
    return order


def wall_field(
    drape: np.ndarray,
    filled: np.ndarray,
    frame: Frame,
    traces: list[Trace],
    branch: FaultMesh,
    number: int,
    mains: list[tuple[int, FaultMesh]],
) -> np.ndarray:
    """Heights (n_row, n_col) of the wall that a branch is in, extrapolated past its main faults.

    `filled` are the nodes without a trusted value, increasing; `number` is that of the branch.
    """
    out = drape.copy()
    none = np.empty(0, dtype=np.int64)

    # nodes near the branch; only these get new heights
    beside = [
        near.nodes_within(WALL)
        for near in (NearTrace(frame, trace, WALL) for trace in traces if trace.fault == number)
    ]
    nodes = distinct(none, *beside)

    # carried: nodes to extrapolate to; beyond: nodes on the other wall of a main fault, which are
    # taken away. A branch has to be traced on its own wall, or its end lies a heave away
    carried, beyond = [nodes[is_among(nodes, filled)]], [none]
    for main, mesh in mains:
        side = _side_of(branch, mesh)
        for trace in traces:
            if trace.fault == main:
                near = NearTrace(frame, trace, WALL)
                at = near.within(WALL)
                # beyond its own ends a main fault has no walls
                inside = (near.place[at] > trace.start) & (near.place[at] < trace.stop)
                other = at[inside & (near.side[at] != side)]
                beyond.append(near.node[other])
                carried.append(near.node[other[near.distance[other] <= CARRY]])
    out[np.concatenate(beyond)] = np.nan
    fill = distinct(*carried)
    fill = fill[is_among(fill, nodes)]
    # nodes in no gap that the drape may fill stay absent
    fill = fill[np.isfinite(drape[fill])]
    return _carried(out, fill, frame).reshape(frame.shape)


def _side_of(branch: FaultMesh, main: FaultMesh) -> float:
    """Side of a main fault on which most of a branch is near it, +1 or -1.

    Its edges are asked every half cell: the triangles of a fault may be as wide as itself. What is
    on the main fault has no side.
    """
    # each edge is sampled, however long: middles of wide triangles may lie far from the main fault
    ends = np.stack([branch.triangles, np.roll(branch.triangles, -1, axis=1)], axis=2)
    a, b = branch.points[ends.reshape(-1, 2)].transpose(1, 0, 2)
    number = np.minimum(np.hypot(*(b - a)[:, :2].T) / EVERY, MOST).astype(np.int64) + 1
    edge = np.repeat(np.arange(len(a)), number)
    step = np.arange(len(edge)) - np.repeat(np.cumsum(number) - number, number)
    share = (step + 0.5) / number[edge]
    places = a[edge] + share[:, None] * (b - a)[edge]

    # the majority of places decides; those nearer than EVERY lie on the contact itself
    far, side = side_at_own_height(main, mesh_blocks(main, FAR), places, FAR)
    return 1.0 if side[far >= EVERY].sum() >= 0 else -1.0


def _carried(heights: np.ndarray, fill: np.ndarray, frame: Frame) -> np.ndarray:
    """Heights with the nodes of `fill` carried on by the least bending."""
    heights[fill] = np.nan

    # second differences reach two nodes: with these, the band holds all that fixes the fill
    band = around(fill, frame.shape, 2)
    graph = lattice_graph(band, frame.shape)
    value = heights[band]
    number = np.full(len(band), -1)
    at = np.searchsorted(band, fill)
    number[at] = np.arange(len(fill))
    graph = without_absent(graph, np.isfinite(value) | (number >= 0))

    # unknowns that no link ties to data would make the matrix singular: they stay NaN
    tied = grounded(graph, number)
    keep = np.full(len(band), -1)
    keep[at[tied]] = np.arange(tied.sum())
    graph = without_absent(graph, (np.isfinite(value) & (number < 0)) | (keep >= 0))
    value = np.where(np.isfinite(value), value, 0.0)
    heights[fill[tied]] = smoothest(graph, keep, value, frame.stretch, bend=1.0, third=0.0)
    return heights


def led_to(line: np.ndarray, end: int, main: Trace) -> np.ndarray:
    """A trace drawn out from one of its ends straight past the nearest point of another trace."""
    tip = line[0 if end == 0 else -1]
    a, b = main.line[:-1, :2], main.line[1:, :2]
    step = b - a
    length = np.maximum((step**2).sum(axis=1), 1e-30)
    t = np.clip(((tip[:2] - a) * step).sum(axis=1) / length, 0.0, 1.0)
    foot = a + t[:, None] * step
    foot = foot[np.hypot(*(foot - tip[:2]).T).argmin()]
    way = foot - tip[:2]

    # a trace that touches already needs no piece; otherwise one to the foot, and PAST beyond it
    far = float(np.hypot(*way))
    if far < 1e-6:
        return line
    more = np.repeat(tip[None], 2, axis=0)
    more[0, :2], more[1, :2] = 0.5 * (tip[:2] + foot), foot + way / far * PAST
    return np.concatenate([more[::-1], line]) if end == 0 else np.concatenate([line, more])
