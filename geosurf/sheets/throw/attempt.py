"""One attempt to tear a moved horizon: traces, walls of nodes, and heights, by explicit arguments.

A node belongs to a wall by the trace of the fault, near it, and by the fault itself far away.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from geosurf.sheets.faults.cut_edges import Part, within
from geosurf.sheets.faults.fault_distance import NearTrace, near_traces
from geosurf.sheets.faults.last_edges import last_link, on_own_side
from geosurf.sheets.faults.network import Network
from geosurf.sheets.faults.traces import Trace, mesh_in_frame
from geosurf.sheets.heights.state import Heights, Tears
from geosurf.sheets.mesh.ghosts import ghost_heights, kept_apart
from geosurf.sheets.mesh.torn_mesh import Torn, Triangles
from geosurf.sheets.throw.displacement import (
    InWalls,
    moved_places,
    refuse_folds,
    sheet_heights,
)
from geosurf.sheets.throw.movement import Branches, Movement
from geosurf.sheets.throw.tear_ends import refuse_steps, refuse_throw_at_tips, torn_by_throw


@dataclass(frozen=True, eq=False)
class Attempt:
    """A horizon moved by its faults, traced at one share of the movement.

    Attributes
    ----------
    movement : Movement
    branches : Branches
        As the traces show them.
    walls : ndarray (n_slip, n_node)
        Wall of each node: 1 hanging wall, 0 footwall.
    was : ndarray (n_node, 2)
        Where the rock of each node was, from the corner of the frame [m].
    state : Heights
        Of the nodes, with tears.
    notes : tuple of str
        Faults that tear nothing.
    """

    movement: Movement
    branches: Branches
    walls: np.ndarray
    was: np.ndarray
    state: Heights
    notes: tuple[str, ...]

    @property
    def walls_by_name(self) -> dict[str, np.ndarray]:
        """Walls of the nodes by fault, int8 (n_node,): 1 hanging wall, -1 footwall."""
        names = [fault.name for fault in self.movement.faults]
        return dict(zip(names, np.where(self.walls > 0.5, 1, -1).astype(np.int8), strict=True))

    def ghosts(
        self,
        torn: Torn,
        triangles: Triangles,
        bits: np.ndarray,
        state: Heights,
        _: Collection[int],
    ) -> np.ndarray:
        """Heights (n_ghost,) on the sheets of their anchors; the energy fills in at holes."""
        frame = self.movement.frame
        heights, _ = self.movement.heights(
            self.branches, torn.node_of_ghost, self.walls[:, torn.anchor]
        )
        if np.isfinite(heights).all():
            return kept_apart(torn, state.values, heights, frame.cell)
        fixed = {int(g): float(heights[g]) for g in np.flatnonzero(np.isfinite(heights))}
        return ghost_heights(torn, triangles, bits, state.values, frame.stretch, frame.cell, fixed)

    def end_at(self, state: Heights, limits: np.ndarray, _: Sequence[Part] = ()) -> Heights:
        """Heights with which tears can end at the last links outside of limits (n_trace, 2)."""
        movement, network = self.movement, state.network
        frame, values = movement.frame, self.state.values.copy()
        for i, k in np.argwhere(limits != network.solve).tolist():
            fault = network.traces[i].fault
            mesh = mesh_in_frame(movement.faults[fault], frame)
            link = last_link(network.cuts, i, k, limits[i, k], movement.rising, frame.shape[1])
            for node in link:
                # the height that the node would have in the other wall of this fault
                flipped = self.walls[:, [node]]
                side = 2.0 * flipped[fault, 0] - 1.0
                flipped[fault] = 1.0 - flipped[fault]
                other = movement.heights(self.branches, np.array([node]), flipped)[0].item()
                if np.isfinite(other):
                    values[node] = on_own_side(mesh, frame, node, side, values[node].item(), other)
        return replace(state, values=values)


def attempt(movement: Movement, lean: float, branches: Branches) -> Attempt:
    """Trace the faults where a share `lean` of the movement is done, and move the horizon.

    Parameters
    ----------
    movement : Movement
    lean : float
        Part of the throw that the drape has on the fault itself: traces run between the cut-offs.
    branches : Branches
        What is known of them before; the result has those that its traces show.

    Raises
    ------
    GeometryError
        If beds would fold over, or throw is left where a fault ends. Names the place.
    """
    frame, picks = movement.frame, movement.picks

    # traces on the drape, torn where there is throw
    drape, network, branches, in_walls = _traced(movement, lean, branches)
    refuse_throw_at_tips(movement, network)
    network, notes = torn_by_throw(movement, network)

    # each node belongs to a wall of each fault, and moves with it
    near = near_traces(frame, network.traces, movement.reach)
    walls = _walls(movement, drape, network, near, in_walls)
    values, was = _moved(movement, branches, walls, in_walls)
    every = network.cuts
    drawn = every.take(np.flatnonzero(within(every, *network.mesh.T)))
    refuse_steps(movement, branches, drawn, walls, drape)

    # every datum is used: nothing near a fault is smeared here
    used = np.ones(len(picks.z), dtype=bool)
    tears = Tears(network, near, every).between(network.solve)
    state = Heights(values=values, tears=tears, used=used, ignored=~used).with_walls(frame)
    return Attempt(movement, branches, walls, was, state, notes)


def _moved(
    movement: Movement, branches: Branches, walls: np.ndarray, known: InWalls
) -> tuple[np.ndarray, np.ndarray]:
    """Heights of all nodes in their walls (n_slip, n_node), and where their rock was.

    Nodes that the drape has found in the same walls are not moved again.
    """
    others = np.flatnonzero((known.walls != walls).any(axis=0))
    values, was = known.elevation, known.was
    values[others], was[others] = movement.heights(branches, others, walls[:, others])
    return movement.before.without_lost(values, was), was


def _traced(
    movement: Movement, lean: float, branches: Branches
) -> tuple[np.ndarray, Network, Branches, InWalls]:
    """Drape (n_node,) [m], the traces on it, the branches that these show, and nodes in walls.

    The drape is the horizon as it is moved, blended over each fault. Where the traces show other
    branches than those that it was moved by, it is moved and traced once more.
    """
    frame, slips = movement.frame, movement.slips
    meshes = [mesh_in_frame(fault, frame) for fault in movement.faults]

    # which wall a branch is in follows from its trace, and its trace from the drape: once more
    # where the second network shows other branches
    for turn in range(2):
        known = branches
        parts = movement.gradual_parts(lean, known)
        found = InWalls.unknown(len(slips), len(movement.xy))
        try:
            drape, was = sheet_heights(
                movement.before, slips, movement.xy, parts, frame.cell, found
            )
        finally:
            # beds that fold over may have no fixed point, either: this error names the cell
            if turn == 0:
                _refuse_folds(movement, known, found)

        # nodes whose rock came from a hole of the horizon have no height
        grid = movement.before.without_lost(drape, was).reshape(frame.shape)
        network = Network(meshes, grid, frame)
        branches = _branches_of(movement, network)
        if branches == known:
            break
    if branches != known:  # other parts of the throw belong to the walls
        found = InWalls.unknown(len(slips), len(movement.xy))
    return drape, network, branches, found


def _refuse_folds(movement: Movement, branches: Branches, known: InWalls) -> None:
    """Raise an error where beds would fold over; `known` on the way to the drape needs no more."""
    walls, now = known.walls, known.moved
    others = np.flatnonzero(np.isnan(walls).any(axis=0))
    if len(others):
        walls, now = walls.copy(), now.copy()
        xy = movement.xy[others]
        z = movement.before.at(xy)
        walls[:, others] = movement.in_hanging_walls(xy, z)
        parts = movement.parts(branches, walls[:, others])
        now[others] = moved_places(movement.slips, xy, z, parts)
    # nodes differ in their parts as they do in their walls, unless a fault has one wall only
    even = all(branches.acts) and not any(branches.mains)
    parts = walls if even else movement.parts(branches, walls)
    refuse_folds(movement.before, movement.xy, now, parts)


def _branches_of(movement: Movement, network: Network) -> Branches:
    """Branches by the rims of faults and by the ends of traces."""
    names = [fault.name for fault in movement.faults]

    # rims of faults first; ends of traces, which are more certain at the horizon, replace them
    mains = movement.touching()
    for trace in network.traces:
        for end in trace.ends:
            if end.startswith("branch of "):
                main = names.index(end.removeprefix("branch of "))
                mains[trace.fault][main] = _wall_of_branch(movement, main, trace)
    met = {trace.fault for trace in network.traces}
    return Branches(mains, tuple(k in met or bool(on) for k, on in enumerate(mains)))


def _wall_of_branch(movement: Movement, main: int, trace: Trace) -> float:
    """Wall of a main fault on which the middle of a branch's trace is: 1 hanging wall."""
    # the middle: near the contact itself the side is rounding
    line = trace.line[int(0.5 * (trace.start + trace.stop))]
    xy = (line[None, :2] / movement.frame.stretch) @ movement.frame.step
    return float(movement.distance(main, xy, line[2:3])[0] > 0)


def _walls(
    movement: Movement,
    drape: np.ndarray,
    network: Network,
    near: list[NearTrace],
    known: InWalls,
) -> np.ndarray:
    """Wall (n_slip, n_node) of each node, 1 or 0: by the trace near it, else by the fault.

    Links are cut by the line of a trace, and past a free end that line goes on: a node beside
    it is on the side of the line there, too, also one that lies on the fault itself.
    """
    # where the drape came to rest in whole walls of all faults, each fault is at least the width of
    # a gradual wall away
    out = known.walls.copy()
    others = np.flatnonzero(np.isnan(out).any(axis=0) | (known.elevation != drape))
    out[:, others] = movement.in_hanging_walls(movement.xy[others], drape[others])
    nearest = np.full(out.shape, np.inf)  # cells to the trace that decides
    for trace, close, ends in zip(network.traces, near, network.mesh, strict=True):
        # at a branch the line goes on into the main fault, beyond which it decides nothing
        first, last = (
            at if end.startswith("branch") else drawn
            for at, end, drawn in zip(ends, trace.ends, (0, len(trace.line) - 1), strict=True)
        )
        at = close.within(movement.reach)
        at = at[(close.place[at] > first) & (close.place[at] < last)]

        # a fault may have several traces: the nearest one decides
        at = at[close.distance[at] < nearest[trace.fault, close.node[at]]]
        nearest[trace.fault, close.node[at]] = close.distance[at]
        out[trace.fault, close.node[at]] = close.side[at] > 0
    return out
