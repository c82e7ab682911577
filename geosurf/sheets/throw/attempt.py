"""One attempt to tear a moved horizon: traces, walls of nodes, and heights, by explicit arguments.

A node belongs to a wall by the trace of the fault, near it, and by the fault itself far away.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeometryError
from geosurf.kernels.lattices.sets import distinct
from geosurf.kernels.sheets.torn_links import uncut_steps
from geosurf.sheets.faults.cut_edges import Cuts, Part, on_own_side, within
from geosurf.sheets.faults.fault_distance import NearTrace, near_traces
from geosurf.sheets.faults.network import Network
from geosurf.sheets.faults.traces import Trace, mesh_in_frame
from geosurf.sheets.heights.state import Heights, Tears
from geosurf.sheets.mesh.ghosts import ghost_heights, kept_apart
from geosurf.sheets.mesh.torn_mesh import Torn, Triangles
from geosurf.sheets.throw.displacement import Branches, Movement, refuse_folds, sheet_heights

# ---- tear ends ----------------------------------------
# Where the tears of a moved horizon end, and errors where throw would be left without a fault.


NIL = 1e-4  # cells: less throw than this tears nothing
DIES = 0.01  # of the largest throw: what may be left at a tip
STEP = 0.05  # and between two neighbours that no fault parts, as at a tip, within a cell


def throw_along(movement: Movement, trace: Trace, at: int | slice) -> tuple[np.ndarray, np.ndarray]:
    """World coordinates (n, 3) of vertices of a trace, and the throw (n,) requested there [m]."""
    slip, frame = movement.slips[trace.fault], movement.frame
    line = np.atleast_2d(trace.line[at])
    xy = (line[:, :2] / frame.stretch) @ frame.step
    s = slip.section.of(xy)[0].clip(0.0, slip.section.length)
    throw = slip.amount(s, line[:, 2], xy)
    return np.column_stack([xy + frame.corner, line[:, 2]]), throw


def refuse_throw_at_tips(movement: Movement, network: Network) -> None:
    """Raise an error where throw is left at the end of a fault inside the horizon."""
    for trace in network.traces:
        slip, largest = movement.slips[trace.fault], movement.largest[trace.fault]
        for end, at in zip(trace.ends, (trace.start, trace.stop), strict=True):
            if end != "tip":
                continue
            where, left = throw_along(movement, trace, int(at))
            if abs(left[0]) > DIES * largest:
                name, horizon = slip.section.name, movement.picks.name
                raise GeometryError(
                    f"fault {name!r} ends inside horizon {horizon!r} at {place(where[0])}, "
                    f"where its throw is still {left[0]:.3g} m. Let throw die there, or extend "
                    "the fault to the edge of the horizon or to another fault.",
                    place=where[0],
                    surfaces=(name, horizon),
                )


def torn_by_throw(movement: Movement, network: Network) -> tuple[Network, tuple[str, ...]]:
    """The traces that have throw, torn where they have it; and notes of faults that do not tear.

    Where throw has died before its fault does, the horizon is whole: the tear ends there.
    """
    rows: list[int] = []
    traces: list[Trace] = []
    mesh, solve = network.mesh.copy(), network.solve.copy()
    for i, trace in enumerate(network.traces):
        throw = throw_along(movement, trace, slice(None))[1]
        with_throw = np.flatnonzero(np.abs(throw) > NIL * movement.frame.cell)
        if len(with_throw) == 0:
            continue

        # one vertex past the throw at each end, unless the fault itself ends before
        ends = list(trace.ends)
        for k, first, outer in ((0, with_throw[0] - 1, max), (1, with_throw[-1] + 1, min)):
            if outer(float(first), mesh[i, k]) != mesh[i, k]:
                mesh[i, k] = solve[i, k] = float(first)
                ends[k] = "tip"
        rows.append(i)
        traces.append(replace(trace, ends=ends))

    met = {trace.fault for trace in network.traces}
    notes = [
        f"Fault {slip.section.name!r} does not meet the horizon."
        for k, slip in enumerate(movement.slips)
        if k not in met
    ]
    notes += [
        f"Fault {movement.slips[trace.fault].section.name!r} has no throw at the horizon."
        for i, trace in enumerate(network.traces)
        if i not in rows
    ]
    return network.with_traces(traces, mesh[rows], solve[rows]), tuple(notes)


def refuse_steps(
    movement: Movement, branches: Branches, cuts: Cuts, walls: np.ndarray, drape: np.ndarray
) -> None:
    """Raise an error for a step between neighbours that no fault parts: a fault is too short.

    `walls` (n_slip, n_node) and `drape` (n_node,) are those of one attempt, `cuts` its cut links.
    """
    frame, n_node = movement.frame, movement.picks.n_node
    # neighbours in different walls that no trace parts: the horizon has to be continuous there
    for pairs in uncut_steps(walls, cuts.node, cuts.kind, *frame.shape):
        if not len(pairs):
            continue
        i, j = pairs.T
        used = distinct(i, j)
        parts = np.zeros((len(walls), n_node))
        parts[:, used] = movement.parts(branches, walls[:, used])
        for k, slip in enumerate(movement.slips):
            # the throw of the fault between neighbours in different walls of it
            rows = np.flatnonzero(parts[k, i] != parts[k, j])
            xyz = _crossing(movement, drape, k, i[rows], j[rows])
            s = slip.section.of(xyz[:, :2])[0].clip(0.0, slip.section.length)
            left = np.abs(slip.amount(s, xyz[:, 2], xyz[:, :2]))
            left *= np.abs(parts[k, i[rows]] - parts[k, j[rows]])
            bad = np.flatnonzero(left > STEP * movement.largest[k])
            if len(bad) == 0:
                continue

            where = xyz[bad[0]] + np.append(frame.corner, 0.0)
            name, horizon = slip.section.name, movement.picks.name
            raise GeometryError(
                f"fault {name!r} does not reach horizon {horizon!r} at {place(where)}, where "
                f"its throw is {left[bad[0]]:.3g} m. Extend the fault there, or let throw die "
                "before.",
                place=where,
                surfaces=(name, horizon),
            )


def _crossing(
    movement: Movement, drape: np.ndarray, fault: int, first: np.ndarray, second: np.ndarray
) -> np.ndarray:
    """Places (n, 3) between pairs of nodes, one in each wall, at which they meet a fault."""
    here, there = (np.column_stack([movement.xy[k], drape[k]]) for k in (first, second))
    far = [np.abs(movement.distance(fault, at[:, :2], at[:, 2])) for at in (here, there)]
    both = far[0] + far[1]
    share = np.divide(far[0], both, out=np.full_like(both, 0.5), where=both > 0)[:, None]
    return here + share * (there - here)


def throw_at_early_ends(
    movement: Movement, network: Network, cuts: Cuts, shortened: Collection[tuple[int, int]]
) -> list[str]:
    """How much throw is left where tears end early: the horizon is continuous over it there."""
    notes = []
    for row, end in sorted(shortened):
        trace, places = network.traces[row], cuts.place[cuts.trace == row]
        if len(places) == 0:
            continue
        last = int(places.min() if end == 0 else places.max())
        where, throw = throw_along(movement, trace, last)
        notes.append(
            f"The tear of fault {movement.faults[trace.fault].name!r} ends early, at "
            f"{place(where[0])}, where its throw is still {throw[0]:.3g} m."
        )
    return notes


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
        self, torn: Torn, triangles: Triangles, bits: np.ndarray, state: Heights, _: Collection[int]
    ) -> np.ndarray:
        """Heights (n_ghost,) on the sheets of their anchors; the energy fills in at holes."""
        frame = self.movement.frame
        places = self.movement.xy[torn.node_of_ghost]
        heights, _ = self.movement.heights(self.branches, places, self.walls[:, torn.anchor])
        if np.isfinite(heights).all():
            return kept_apart(torn, state.values, heights, frame.cell)
        fixed = {int(g): float(heights[g]) for g in np.flatnonzero(np.isfinite(heights))}
        return ghost_heights(torn, triangles, bits, state.values, frame.stretch, frame.cell, fixed)

    def end_at(self, state: Heights, limits: np.ndarray, _: Sequence[Part] = ()) -> Heights:
        """Heights with which tears can end at the last links outside of limits (n_trace, 2)."""
        movement, network = self.movement, state.network
        frame, values = movement.frame, self.state.values.copy()
        for i, node in network.last_nodes(limits, movement.rising):
            # the height that the node would have in the other wall of this fault
            fault, flipped = network.traces[i].fault, self.walls[:, [node]]
            side = 2.0 * flipped[fault, 0] - 1.0
            flipped[fault] = 1.0 - flipped[fault]
            other = movement.heights(self.branches, movement.xy[[node]], flipped)[0].item()
            if np.isfinite(other):
                mesh = mesh_in_frame(movement.faults[fault], frame)
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
    drape, network, branches = _traced(movement, lean, branches)
    refuse_throw_at_tips(movement, network)
    network, notes = torn_by_throw(movement, network)

    # each node belongs to a wall of each fault, and moves with it
    near = near_traces(frame, network.traces, movement.reach)
    walls = _walls(movement, drape, network, near)
    values, was = movement.heights(branches, movement.xy, walls)
    every = network.cuts
    drawn = every.take(np.flatnonzero(within(every, *network.mesh.T)))
    refuse_steps(movement, branches, drawn, walls, drape)

    # every datum is used: nothing near a fault is smeared here
    used = np.ones(len(picks.z), dtype=bool)
    tears = Tears(network, near, every).between(network.solve)
    state = Heights(values=values, tears=tears, used=used, ignored=~used).with_walls(frame)
    return Attempt(movement, branches, walls, was, state, notes)


def _traced(
    movement: Movement, lean: float, branches: Branches
) -> tuple[np.ndarray, Network, Branches]:
    """Drape (n_node,) [m], the traces on it, and the branches that these show.

    The drape is the horizon as it is moved, blended over each fault. Where the traces show other
    branches than those that it was moved by, it is moved and traced once more.
    """
    frame, before = movement.frame, movement.before
    meshes = [mesh_in_frame(fault, frame) for fault in movement.faults]

    # which wall a branch is in follows from its trace, and its trace from the drape: once more
    # where the second network shows other branches
    for turn in range(2):
        known = branches
        parts = movement.gradual_parts(lean, known)
        try:
            drape, was = sheet_heights(before, movement.slips, movement.xy, parts, frame.cell)
        finally:
            # beds that fold over may have no fixed point, either: this error names the cell
            if turn == 0:
                walls = movement.in_hanging_walls(movement.xy, before.at(movement.xy))
                refuse_folds(before, movement.slips, movement.xy, movement.parts(known, walls))

        # nodes whose rock came from a hole of the horizon have no height
        grid = before.without_lost(drape, was).reshape(frame.shape)
        network = Network(meshes, grid, frame)
        branches = _branches_of(movement, network)
        if branches == known:
            break
    return drape, network, branches


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
    movement: Movement, drape: np.ndarray, network: Network, near: list[NearTrace]
) -> np.ndarray:
    """Wall (n_slip, n_node) of each node, 1 or 0: by the trace near it, else by the fault.

    Links are cut by the line of a trace, and past a free end that line goes on: a node beside
    it is on the side of the line there, too, also one that lies on the fault itself.
    """
    out = movement.in_hanging_walls(movement.xy, drape)
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
