"""A horizon that its faults move: which wall each node belongs to, and where its sheets are.

A node belongs to a wall by the trace of the fault, near it, and by the fault itself far away. In a
wall, a fault acts by its part of the throw; beyond the fault that it ends on, a branch has one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from geosurf.conventions import place, rising_diagonal
from geosurf.errors import GeometryError
from geosurf.kernels.sheets.fault_distance import UNIT
from geosurf.model import TriSurface
from geosurf.sheets.faults.cut_edges import Cuts, within
from geosurf.sheets.faults.dip_lines import dip_lines
from geosurf.sheets.faults.fault_distance import NearTrace, near_traces
from geosurf.sheets.faults.last_edges import last_link, on_own_side
from geosurf.sheets.faults.network import Network
from geosurf.sheets.faults.slip import Slip
from geosurf.sheets.faults.traces import Trace, mesh_in_frame
from geosurf.sheets.heights.passes import MAP_REACH
from geosurf.sheets.heights.state import Heights, Tears
from geosurf.sheets.lattice.frame import Frame
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.mesh.ghosts import ghost_heights
from geosurf.sheets.mesh.torn_mesh import Torn, Triangles
from geosurf.sheets.throw.displacement import Before, refuse_folds, sheet_heights

TOUCH = 0.01  # cells from a fault within which the rim of another one lies on it
NIL = 1e-4  # cells: less throw than this tears nothing
DIES = 0.01  # of the largest throw: what may be left at a tip
STEP = 0.05  # and between two neighbours that no fault parts, as at a tip, within a cell


class Thrown:
    """One horizon, its faults from the youngest to the oldest, and how they move it.

    Attributes
    ----------
    state : Heights
        Of the sheets; see `run`.
    was : ndarray (n_node, 2)
        Where the rock of each node was, from the corner of the frame [m].
    mains : list of dict
        For each fault the main faults that it ends on, and its wall of them: 1 hanging wall.
    notes : list of str
    """

    def __init__(
        self, picks: Picks, faults: list[TriSurface], slips: list[Slip], turning: list[bool]
    ) -> None:
        self.picks, self.faults = picks, faults
        self.frame: Frame = picks.frame
        values = np.full(picks.n_node, np.nan)
        values[picks.node] = picks.z
        self.rising = rising_diagonal(self.frame.easting, self.frame.northing)
        grid = values.reshape(self.frame.shape)
        self.before = Before(picks.name, grid, self.frame, self.rising)
        self.xy = self.frame.uv_of_node(np.arange(picks.n_node)) @ self.frame.step
        low, high = float(picks.z.min()), float(picks.z.max())
        sizes = [slip.extremes(low, high) for slip in slips]
        self.largest = [throw for throw, _ in sizes]
        self.slips = [
            replace(slip, lines=dip_lines(slip.section, throw, self.frame.cell) if turns else None)
            for slip, throw, turns in zip(slips, self.largest, turning, strict=True)
        ]
        # a wall reaches past its trace by a part of the heave, `lean`
        widest = max((heave for _, heave in sizes), default=0.0) / self.frame.cell
        self.reach = max(MAP_REACH, np.ceil(widest) + 3.0)
        self.blend = [max(2.0 * heave, self.frame.cell) for _, heave in sizes]
        self.mains = self._touching()
        self.acts = [True] * len(slips)

    def run(self, lean: float) -> Heights:
        """Trace the faults where a share `lean` of the movement is done, and move the horizon."""
        self.lean = lean
        unmoved = self.before.at(self.xy)
        walls = [self._hanging(k, self.xy, unmoved) for k in range(len(self.slips))]
        parts = self._parts(np.array(walls, dtype=float).reshape(len(walls), len(self.xy)))
        refuse_folds(self.before, self.slips, self.xy, parts)
        network = self._network()
        self._die_at_tips(network)
        self._where_there_is_throw(network)
        near = near_traces(self.frame, network.traces, self.reach)
        self.labels = self._labels(network, near)
        values, self.was = self._moved(np.arange(self.picks.n_node), self.labels)
        self.values = values
        every = network.cuts
        self._torn_only_at_faults(every.take(np.flatnonzero(within(every, *network.mesh.T))))
        tears = Tears(network, near, every).between(network.solve)
        used = np.ones(len(self.picks.z), dtype=bool)
        state = Heights(values=values, tears=tears, used=used, ignored=~used)
        return state.with_walls(self.picks.frame)

    def _network(self) -> Network:
        """Traces on the horizon as it is moved, blended over each fault; twice, for branches."""
        meshes = [mesh_in_frame(fault, self.frame) for fault in self.faults]
        names = [fault.name for fault in self.faults]
        for _ in range(2):
            self.drape, was = sheet_heights(
                self.before, self.slips, self.xy, self._blended, self.frame.cell
            )
            drape = np.where(self.before.lost(was), np.nan, self.drape)
            network = Network(meshes, drape.reshape(self.frame.shape), self.frame)
            found = self._touching()
            for trace in network.traces:
                for end in trace.ends:
                    if end.startswith("branch of "):
                        main = names.index(end.removeprefix("branch of "))
                        found[trace.fault][main] = self._wall_of(main, trace)
            met = {trace.fault for trace in network.traces}
            acts = [k in met or bool(mains) for k, mains in enumerate(found)]
            if (found, acts) == (self.mains, self.acts):
                break
            self.mains, self.acts = found, acts
        return network

    def _touching(self) -> list[dict[int, float]]:
        """For each fault the faults that its rim lies on, with its other points on one side."""
        found: list[dict[int, float]] = [{} for _ in self.slips]
        for k, fault in enumerate(self.faults):
            points = fault.vertices - np.append(self.frame.corner, 0.0)
            for main, slip in enumerate(self.slips):
                s, _ = slip.section.of(points[:, :2])
                z = points[:, 2]
                here = (s >= 0) & (s <= slip.section.length)
                here &= (z >= slip.section.z[0]) & (z <= slip.section.z[1])
                far = self._beyond(main, points[:, :2], z)
                near = TOUCH * self.frame.cell
                if main == k or not (here & (np.abs(far) <= near)).any():
                    continue
                if (far >= -near).all() != (far <= near).all():
                    found[k][main] = float((far >= -near).all())
        return found

    def _wall_of(self, main: int, trace: Trace) -> float:
        """Wall of a main fault on which the middle of a branch's trace is: 1 hanging wall."""
        line = trace.line[int(0.5 * (trace.start + trace.stop))]
        xy = (line[None, :2] / self.frame.stretch) @ self.frame.step
        return float(self._beyond(main, xy, line[2:3])[0] > 0)

    def _beyond(self, fault: int, xy: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Distance (n,) across strike from a fault at their elevation, into its hanging wall."""
        section = self.slips[fault].section
        s, r = section.of(xy)
        return r - section.across(s, z)

    def _hanging(self, fault: int, xy: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Whether places (n, 2) are in the hanging wall of a fault; those on it are not.

        Distances are rounded to the units that traces are on: on a fault they are noise.
        """
        found: np.ndarray = np.rint(self._beyond(fault, xy, z) / self.frame.cell * UNIT) > 0
        return found

    def _blended(self, xy: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Parts (n_slip, n) that change gradually across each fault."""
        ramp = [
            np.clip(self.lean + self._beyond(k, xy, z) / (2.0 * width), 0.0, 1.0)
            for k, width in enumerate(self.blend)
        ]
        return self._parts(np.array(ramp).reshape(len(self.slips), len(xy)))

    def _parts(self, walls: np.ndarray) -> np.ndarray:
        """Parts of the throw (see `Slip.move`) in walls, 1 hanging, 0 foot.

        Beyond its main fault a branch has one wall only: the one that lies in that direction.
        """
        out = np.empty_like(walls)
        for k, (slip, mains) in enumerate(zip(self.slips, self.mains, strict=True)):
            wall = walls[k] if self.acts[k] else np.full_like(walls[k], 1.0 - slip.share)
            for main, own in mains.items():
                away = self.slips[main].section.axes[1] * (1.0 - 2.0 * own)
                beyond = float(away @ slip.section.axes[1] > 0)
                here = walls[main] if own > 0.5 else 1.0 - walls[main]
                wall = wall * here + beyond * (1.0 - here)
            out[k] = wall - 1.0 + slip.share
        return out

    def _labels(self, network: Network, near: list[NearTrace]) -> np.ndarray:
        """Wall (n_slip, n_node) of each node, 1 or 0: by the trace near it, else by the fault.

        Links are cut by the line of a trace, and past a free end that line goes on: a node beside
        it is on the side of the line there, too, also one that lies on the fault itself.
        """
        out = np.array(
            [self._hanging(k, self.xy, self.drape) for k in range(len(self.slips))], dtype=float
        ).reshape(len(self.slips), len(self.xy))
        nearest = np.full(out.shape, np.inf)
        for trace, close, ends in zip(network.traces, near, network.mesh, strict=True):
            first, last = (
                at if end.startswith("branch") else drawn
                for at, end, drawn in zip(ends, trace.ends, (0, len(trace.line) - 1), strict=True)
            )
            at = close.within(self.reach)
            at = at[(close.place[at] > first) & (close.place[at] < last)]
            at = at[close.distance[at] < nearest[trace.fault, close.node[at]]]
            nearest[trace.fault, close.node[at]] = close.distance[at]
            out[trace.fault, close.node[at]] = close.side[at] > 0
        return out

    def _moved(self, node: np.ndarray, labels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Heights over nodes of the sheets with labels (n_slip, n), and where particles were."""
        z, was = sheet_heights(
            self.before, self.slips, self.xy[node], self._parts(labels), self.frame.cell
        )
        z[self.before.lost(was)] = np.nan
        return z, was

    def carry_on(self, torn: Torn, triangles: Triangles, bits: np.ndarray, state: Heights):
        """Ghosts are on the sheet of their anchor; the energy fills in where that has a hole."""
        heights, _ = self._moved(torn.node_of_ghost, self.labels[:, torn.anchor])
        fixed = {int(g): float(heights[g]) for g in np.flatnonzero(np.isfinite(heights))}
        return ghost_heights(
            torn, triangles, bits, state.values, self.frame.stretch, self.frame.cell, fixed
        )

    def end_at(self, state: Heights, limits: np.ndarray) -> Heights:
        """Heights with which tears can end at the last links outside of limits (n_trace, 2)."""
        network, values = state.network, self.values.copy()
        for i, k in np.argwhere(limits != network.solve).tolist():
            fault = network.traces[i].fault
            link = last_link(network.cuts, i, k, limits[i, k], self.rising, self.frame.shape[1])
            for node in link:
                flipped = self.labels[:, [node]]
                side = 2.0 * flipped[fault, 0] - 1.0
                flipped[fault] = 1.0 - flipped[fault]
                other = float(self._moved(np.array([node]), flipped)[0][0])
                mesh = mesh_in_frame(self.faults[fault], self.frame)
                if np.isfinite(other):
                    values[node] = on_own_side(
                        mesh, self.frame, node, side, float(values[node]), other
                    )
        return replace(state, values=values)

    def _die_at_tips(self, network: Network) -> None:
        """Refuse throw that is left where a fault ends inside the horizon."""
        for trace in network.traces:
            slip, largest = self.slips[trace.fault], self.largest[trace.fault]
            for end, at in zip(trace.ends, (trace.start, trace.stop), strict=True):
                if end != "tip":
                    continue
                where, left = self._throw_along(trace, int(at))
                if abs(left[0]) > DIES * largest:
                    name, horizon = slip.section.name, self.picks.name
                    raise GeometryError(
                        f"fault {name!r} ends inside horizon {horizon!r} at {place(where[0])}, "
                        f"where its throw is still {left[0]:.3g} m. Let throw die there, or extend "
                        "the fault to the edge of the horizon or to another fault.",
                        place=where[0],
                        surfaces=(name, horizon),
                    )

    def _throw_along(self, trace: Trace, at: int | slice) -> tuple[np.ndarray, np.ndarray]:
        """World coordinates (n, 3) of vertices of a trace, and the throw (n,) asked for there."""
        line, section = np.atleast_2d(trace.line[at]), self.slips[trace.fault].section
        xy = (line[:, :2] / self.frame.stretch) @ self.frame.step
        s = section.of(xy)[0].clip(0.0, section.length)
        throw = self.slips[trace.fault].amount(s, line[:, 2], xy)
        return np.column_stack([xy + self.frame.corner, line[:, 2]]), throw

    def _where_there_is_throw(self, network: Network) -> None:
        """End tears where throw has died, before their faults do; there a horizon is whole."""
        met, keep = {trace.fault for trace in network.traces}, []
        for i, trace in enumerate(network.traces):
            throw = self._throw_along(trace, slice(None))[1]
            some = np.flatnonzero(np.abs(throw) > NIL * self.frame.cell)
            if len(some) == 0:
                continue
            keep.append(i)
            for k, first, outer in ((0, some[0] - 1, max), (1, some[-1] + 1, min)):
                if outer(float(first), network.mesh[i, k]) != network.mesh[i, k]:
                    network.mesh[i, k] = network.solve[i, k] = float(first)
                    trace.ends[k] = "tip"
        self.notes = [
            f"Fault {slip.section.name!r} does not meet the horizon."
            for k, slip in enumerate(self.slips)
            if k not in met
        ]
        self.notes += [
            f"Fault {self.slips[trace.fault].section.name!r} has no throw at the horizon."
            for i, trace in enumerate(network.traces)
            if i not in keep
        ]
        network.traces = [network.traces[i] for i in keep]
        network.solve, network.mesh = network.solve[keep], network.mesh[keep]

    def left_at(self, cuts: Cuts, state: Heights, shortened: Mapping) -> list[str]:
        """How much throw is left where tears end early: the horizon is dragged over there."""
        found = []
        for trace, end in sorted(shortened):
            line, mine = state.network.traces[trace], cuts.place[cuts.trace == trace]
            if len(mine) == 0:
                continue
            where, throw = self._throw_along(line, int(mine.min() if end == 0 else mine.max()))
            found.append(
                f"The tear of fault {self.faults[line.fault].name!r} ends early, at "
                f"{place(where[0])}, where its throw is still {throw[0]:.3g} m."
            )
        return found

    def _torn_only_at_faults(self, cuts: Cuts) -> None:
        """Refuse a step between neighbours that no fault parts: a fault that is too short."""
        parts = self._parts(self.labels)
        node = np.arange(self.picks.n_node).reshape(self.frame.shape)
        bits = cuts.bits(self.picks.n_node).reshape(self.frame.shape)
        for a, b, bit in (
            (node[:, :-1], node[:, 1:], bits[:, :-1] & 1),
            (node[:-1], node[1:], bits[:-1] & 2),
        ):
            i, j = a[bit == 0], b[bit == 0]
            for k, slip in enumerate(self.slips):
                rows = np.flatnonzero(parts[k, i] != parts[k, j])
                xyz = self._crossing(k, i[rows], j[rows])
                s = slip.section.of(xyz[:, :2])[0].clip(0.0, slip.section.length)
                left = np.abs(slip.amount(s, xyz[:, 2], xyz[:, :2]))
                left *= np.abs(parts[k, i[rows]] - parts[k, j[rows]])
                bad = np.flatnonzero(left > STEP * self.largest[k])
                if len(bad) == 0:
                    continue
                at = bad[0]
                where = xyz[at] + np.append(self.frame.corner, 0.0)
                name, horizon = slip.section.name, self.picks.name
                raise GeometryError(
                    f"fault {name!r} does not reach horizon {horizon!r} at {place(where)}, where "
                    f"its throw is {left[at]:.3g} m. Extend the fault there, or let throw die "
                    "before.",
                    place=where,
                    surfaces=(name, horizon),
                )

    def _crossing(self, fault: int, one: np.ndarray, two: np.ndarray) -> np.ndarray:
        """Places (n, 3) between pairs of nodes, one in each wall, at which they meet a fault."""
        xyz = np.column_stack([self.xy, self.drape])
        far = [np.abs(self._beyond(fault, xyz[k, :2], xyz[k, 2])) for k in (one, two)]
        both = far[0] + far[1]
        share = np.divide(far[0], both, out=np.full_like(both, 0.5), where=both > 0)[:, None]
        found: np.ndarray = xyz[one] + share * (xyz[two] - xyz[one])
        return found
