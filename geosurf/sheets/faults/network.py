"""Traces of all faults and how each ends: at a tip, at the rim of the data, or on another fault.

An end that reaches another trace, or passes it by a little, is a branch: its tear ends there. The
solve tears one cell past a tip, so that throw can die at it, and some cells past the rim of
the data, so that it does not heal there.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from copy import copy
from functools import cached_property

import numpy as np

from geosurf.arrangement.threads import map_threads
from geosurf.kernels.lattices.sets import distinct, is_among, ranges
from geosurf.kernels.sheets.fault_trace import block_bounds
from geosurf.kernels.sheets.link_lines import UNIT, line_crossings
from geosurf.sheets.faults.cut_edges import (
    Cuts,
    Joint,
    Walls,
    cut_at_joints,
    cuts_of,
    last_link,
    whole_units,
)
from geosurf.sheets.faults.fault_distance import NearTrace, mesh_blocks, side_at_own_height
from geosurf.sheets.faults.traces import FaultMesh, Trace, extended, sample, trace_lines
from geosurf.sheets.lattice.picks import Frame
from geosurf.sheets.lattice.solve import draped

EXTENSION = 3.0  # cells that every end is drawn out by, to see what it runs into
TIP = 1.0  # cells past a free tip that the solve tears: less, and the last link may be whole
REACHES = 1.0  # cells that a branch may stop short of its main fault
OVERSHOOT = 6.0  # cells that a branch may run past its main fault
SHARE_PAST = 0.3  # of its length that a branch may run past its main fault
NO_THROW_PAST = 0.25  # of the throw before another fault, below which the part past it shows none
SHORTEST = 1.5  # cells: shorter traces tear nothing


class Network:
    """Traces, and between which places the solve and the mesh are torn.

    Of the nodes of a drape, those in `filled` (increasing) had no value to trust; with them, faults
    that end on others are traced on the wall that they are in.

    Attributes
    ----------
    traces : list of Trace
    solve, mesh : ndarray (n_trace, 2)
        First and last place (vertex number along the line) that is torn.
    joints : list of (int, int, float, int, float)
        Where branches end on traces: see `cut_edges.Joint`.
    dropped : list of (int, float)
        Fault and length [cells] of traces too short to tear anything.
    """

    def __init__(
        self,
        meshes: list[FaultMesh],
        drape: np.ndarray,
        frame: Frame,
        filled: np.ndarray | None = None,
    ) -> None:
        self.frame = frame
        self.traces: list[Trace] = []
        self.dropped: list[tuple[int, float]] = []
        stretch = frame.stretch

        # the drape's height ranges are found once, for all faults
        bounds = block_bounds(drape)
        found = map_threads(trace_lines, [(mesh, drape, stretch, bounds) for mesh in meshes])
        for number, lines in enumerate(found):
            self._add(number, lines, stretch)
        self.on: list[TraceContact] = []
        self.joints: list[Joint] = []
        self._names = [mesh.name for mesh in meshes]
        if filled is not None:
            self._trace_branches(meshes, drape, frame, filled)

        # the solve tears the extensions as well, the mesh only where the fault really is: a tear
        # that is longer than its fault would be a hole
        self.solve = np.array([[0.0, len(t.line) - 1] for t in self.traces]).reshape(-1, 2)
        self.mesh = np.array([[t.start, t.stop] for t in self.traces]).reshape(-1, 2)
        self._at_rims(drape, stretch)
        self._at_faults()
        self._at_tips()

    def _add(self, number: int, lines: list[np.ndarray], stretch: np.ndarray) -> None:
        """Make traces of the lines of one fault, drawn out at their ends."""
        for line in lines:
            length = float(np.hypot(*np.diff(line[:, :2], axis=0).T).sum())
            if length < SHORTEST:
                self.dropped.append((number, length))
                continue

            # a closed trace, as of a fault around a dome, has no ends
            closed = bool((line[0, :2] == line[-1, :2]).all())
            longer, start, stop = extended(line, *([0.0 if closed else EXTENSION] * 2))
            ends = ["closed", "closed"] if closed else ["tip", "tip"]
            self.traces.append(Trace(number, on_units(longer, stretch), start, stop, ends))

    def _trace_branches(
        self, meshes: list[FaultMesh], drape: np.ndarray, frame: Frame, filled: np.ndarray
    ) -> None:
        """Trace each fault that ends on another on the wall that it is in."""
        branch_ends = contacts(self.traces, meshes)
        if not branch_ends:
            return

        # main faults of each branch; mains come first, so that branches meet their new traces
        mains: dict[int, set[int]] = {}
        for i, _, main in branch_ends:
            mains.setdefault(self.traces[i].fault, set()).add(main)
        for fault in mains_first(mains):
            others = [(main, meshes[main]) for main in sorted(mains[fault])]
            field = wall_field(
                drape.ravel(), filled, frame, self.traces, meshes[fault], fault, others
            )
            lines = trace_lines(meshes[fault], field, frame.stretch)
            if lines:
                self.traces = [trace for trace in self.traces if trace.fault != fault]
                self._add(fault, lines, frame.stretch)
        self.traces.sort(key=lambda trace: trace.fault)
        for i, k, main in contacts(self.traces, meshes):
            if self.traces[i].fault in mains and main in mains[self.traces[i].fault]:
                self._lead(i, k, main, frame.stretch)

    def _lead(self, i: int, k: int, main: int, stretch: np.ndarray) -> None:
        """Draw out the end of a branch to the trace of its main fault."""
        trace = self.traces[i]

        # keep the real part of the trace, and add the piece that leads to the nearest main trace
        choice = [other for other in self.traces if other.fault == main]
        if not choice:
            return

        # places are vertex numbers, which shift by the vertices that are added and left out
        first, last = int(np.ceil(trace.start)), int(np.floor(trace.stop))
        line = trace.line[first:] if k == 0 else trace.line[: last + 1]
        tip = line[0 if k == 0 else -1, :2]
        best = min(choice, key=lambda other: float(other.far_from(tip).min()))
        longer = on_units(led_to(line, k, best), stretch)
        new = len(longer) - len(line)
        start = float(new) if k == 0 else trace.start
        stop = trace.stop - first + new if k == 0 else trace.stop
        self.traces[i] = Trace(trace.fault, longer, start, stop, trace.ends)
        self.on.append((i, k, main))

    def _at_rims(self, drape: np.ndarray, stretch: np.ndarray) -> None:
        """An end that has no data within a cell beyond it leaves the data."""
        for i, trace in enumerate(self.traces):
            for k in range(2):
                if trace.ends[k] != "tip":
                    continue
                beyond = trace.inside[k] + (-1.0 if k == 0 else 1.0)
                xy = trace.at_length(beyond)[:2] / stretch

                # no data a cell beyond: mesh and solve are torn to the end of the extension, so
                # that the walls do not heal at the border
                if np.isnan(sample(drape, xy[None])[0]):
                    trace.ends[k] = "rim"
                    self.mesh[i, k] = self.solve[i, k]

    @cached_property
    def _crossed(self) -> list[tuple[int, int, float, float]]:
        """Each crossing of two traces, for each of both: number, other, place, place on that."""
        crossed = []
        for i in range(len(self.traces)):
            for j in range(i + 1, len(self.traces)):
                for p, q in crossings(self.traces[i], self.traces[j]):
                    crossed += [(i, j, p, q), (j, i, q, p)]
        return crossed

    def _at_faults(self) -> None:
        """An end that runs into another fault's trace, or a little past it, is a branch."""
        # ends that were led to their main fault by the mesh itself
        for i, k, main in self.on:
            met = [p for a, j, p, _ in self._crossed if a == i and self.traces[j].fault == main]
            self.traces[i].ends[k] = f"branch of {self._names[main]}"
            if met:  # torn up to the main fault, through the gap between both walls of that
                self.solve[i, k] = self.mesh[i, k] = min(met) if k == 0 else max(met)
                continue
            mains = [j for j, trace in enumerate(self.traces) if trace.fault == main]
            if mains:  # it ends exactly on the trace of its main fault, and crosses nothing
                tip = self.traces[i].line[-k, :2]
                j = min(mains, key=lambda j: nearest(tip, self.traces[j])[:2])
                place = nearest(tip, self.traces[j])[1]
                self.joints.append((i, k, float(self.mesh[i, k]), j, place))
        # an end counts as a branch if it runs past the other fault by OVERSHOOT at most
        self._end([one for one in self._past() if one[-1] <= OVERSHOOT])

    def _past(self) -> Iterator[Past]:
        """Ends that cross another fault near its real part, or stop short of it by REACHES."""
        for i, j, p, q in self._crossed:
            trace, other = self.traces[i], self.traces[j]
            if trace.fault == other.fault:
                continue

            # the other trace is only an extension there
            if not other.start - 0.5 * EXTENSION <= q <= other.stop + 0.5 * EXTENSION:
                continue
            at, *ends = other.length_at([q, other.start, other.stop])
            rest = float(np.abs(at - ends).min())
            along = trace.length_at([p, trace.start, trace.stop])
            gap = along[1] - along[0], along[0] - along[2]  # beyond the real ends if positive
            for k in range(2):
                if (i, k, other.fault) in self.on:
                    continue
                # farther short of it the end is a tip; the longer part is none past the other
                if not -SHARE_PAST * (along[2] - along[1]) < gap[k] <= REACHES:
                    continue
                # far past it: to the rim of the data, or where the other fault ends itself
                if -gap[k] > OVERSHOOT and (rest < OVERSHOOT or trace.ends[k] == "rim"):
                    continue
                yield i, k, j, p, -gap[k]

    def _end(self, parts: Sequence[Past]) -> None:
        """End traces at others instead of past them."""
        for i, k, j, p, _ in parts:
            one = self.traces[i]
            if not one.ends[k].startswith("branch"):
                one.ends[k] = f"branch of {self._names[self.traces[j].fault]}"
                self.solve[i, k] = p

            # of several faults that it crosses, the first one met from inside ends it
            inner = max if k == 0 else min
            self.solve[i, k] = inner(self.solve[i, k], p)
            self.mesh[i, k] = inner(self.mesh[i, k], self.solve[i, k])

        # where links may go around the end: see `cut_at_joints`
        more = [
            (i, k, p, j, q)
            for i, j, p, q in self._crossed
            for k in range(2)
            if p == self.solve[i, k] and self.traces[i].ends[k].startswith("branch")
        ]
        self.joints += [joint for joint in more if joint not in self.joints]

    def end_at(self, mains: Collection[tuple[int, int]], meshes: Sequence[FaultMesh]) -> None:
        """End faults at others, by the numbers of both, however far they go past them."""
        self._end([one for one in self._past() if self._faults(one) in mains])
        for fault, main in sorted(mains):
            fault_traces = [i for i, trace in enumerate(self.traces) if trace.fault == fault]
            if len(fault_traces) < 2:
                continue
            # traces on the other side than the longest one are wholly past the other fault
            side = {i: _side_of_trace(self.traces[i], meshes[main]) for i in fault_traces}
            longest = max(fault_traces, key=lambda i: float(self.traces[i].along[-1]))
            for i in fault_traces:
                if side[i] * side[longest] < 0:
                    self.traces[i].ends[:] = [f"branch of {self._names[main]}"] * 2
                    self.solve[i] = self.mesh[i] = np.inf, -np.inf

    def ended(self, walls: Sequence[Walls]) -> set[tuple[int, int]]:
        """Faults that end at others, by the numbers of both: they go past them by little, or show
        next to no throw there, or one of the other sense.
        """
        pairs = set()
        for end in self._past():
            i, k, _, p, past = end
            trace, place = self.traces[i], walls[i].place
            # as far before the other fault as past it, or a few cells
            far = (trace.length_at(place) - trace.length_at(p)) * (-1) ** k
            inside, beyond = (far > 0.0) & (far < max(past, OVERSHOOT)), far < 0.0
            if past > OVERSHOOT and inside.any() and beyond.any():
                before, after = (np.median(walls[i].throw[some]) for some in (inside, beyond))
                if after * np.sign(before) >= NO_THROW_PAST * abs(before):
                    continue
            pairs.add(self._faults(end))
        return pairs

    def _faults(self, past: Past) -> tuple[int, int]:
        """The fault that goes past another one, and that."""
        return self.traces[past[0]].fault, self.traces[past[2]].fault

    def _at_tips(self) -> None:
        for i, trace in enumerate(self.traces):
            for k in range(2):
                if trace.ends[k] == "tip":
                    self.solve[i, k] = beyond_tip(trace, k, (trace.start, trace.stop)[k])

    def with_traces(self, traces: list[Trace], mesh: np.ndarray, solve: np.ndarray) -> Network:
        """Other traces and limits, on the same lattice; this network stays what it is."""
        out = copy(self)
        out.__dict__.pop("cuts", None)  # the links of the old traces, if they were looked up
        out.traces, out.mesh, out.solve, out.joints = traces, mesh, solve, []
        return out

    @cached_property
    def cuts(self) -> Cuts:
        """All links that the traces cut, drawn out as they are."""
        return cut_at_joints(cuts_of(self.traces, self.frame), self.joints, self.traces, self.frame)

    def last_nodes(self, limits: np.ndarray, rising: bool) -> Iterator[tuple[int, int]]:
        """Traces, and nodes of the links at which their tears end within limits (n_trace, 2).

        Only ends whose limits are not those of the network count.
        """
        for i, k in np.argwhere(limits != self.solve).tolist():
            link = last_link(self.cuts, i, k, limits[i, k], rising, self.frame.shape[1])
            yield from ((i, node) for node in link)

    @property
    def declared_tips(self) -> int:
        """Number of ends that are free."""
        return sum(end == "tip" for trace in self.traces for end in trace.ends)


def beyond_tip(trace: Trace, end: int, place: float) -> float:
    """The place one cell past a tip at some place: throw dies there, not before."""
    return float(trace.place_at(trace.length_at(place) + (-TIP if end == 0 else TIP)))


def on_units(line: np.ndarray, stretch: np.ndarray) -> np.ndarray:
    """A line on whole units: sides of nodes and cut links are asked of one and the same line."""
    out = line.copy()
    out[:, :2] = whole_units(line[:, :2] / stretch) / UNIT * stretch
    return out


def nearest(point: np.ndarray, trace: Trace) -> tuple[float, float, np.ndarray]:
    """Distance of a point from a trace in the map [cells], the nearest place, and where that is."""
    # foot of the perpendicular on each piece, clipped to the piece
    a, step = trace.line[:-1, :2], np.diff(trace.line[:, :2], axis=0)
    length = np.maximum((step**2).sum(axis=1), 1e-30)
    t = np.clip(((point - a) * step).sum(axis=1) / length, 0.0, 1.0)
    foot = a + t[:, None] * step
    far = np.hypot(*(foot - point).T)
    k = int(far.argmin())
    return float(far[k]), k + float(t[k]), foot[k]


def crossings(one: Trace, two: Trace) -> list[tuple[float, float]]:
    """Places (on one, on two) where two traces cross in the map."""
    return [(p, q) for p, q in line_crossings(one.segments, two.segments).tolist()]


def faults_in_words(names: Sequence[str]) -> str:
    """Quoted names of faults after the word for one or several."""
    if not names:
        return "its faults"
    return ("fault " if len(names) == 1 else "faults ") + ", ".join(map(repr, names))


ON = 0.02  # cells from its main fault within which a fault ends on it
CARRY = 6.0  # cells that a wall is extrapolated past its main fault
FAR = 30.0  # cells from a main fault within which it is asked on which side a branch is
WALL = 12.0  # cells from the trace of the main fault within which its walls are distinguished
EVERY = 0.5  # cells between the places of a branch that are asked for their side
MOST = 4000  # of them on an edge
PAST = 0.5  # cells that a branch is led past the trace of its main fault
# trace number, end (0 or 1), main fault
TraceContact = tuple[int, int, int]
# trace number, end, trace that it crosses, place of that, and how far it goes on [cells]
Past = tuple[int, int, int, float, float]


def contacts(traces: list[Trace], meshes: list[FaultMesh]) -> list[TraceContact]:
    """Ends of traces that lie on another fault, at their own height."""
    if not traces:
        return []

    # rows 2 i and 2 i + 1: both ends of trace i
    ends = np.concatenate([trace.at([trace.start, trace.stop])[:, :3] for trace in traces])
    far = [side_at_own_height(mesh, mesh_blocks(mesh, 1.0), ends, 1.0)[0] for mesh in meshes]
    return [
        (i, k, j)
        for i, trace in enumerate(traces)
        for j in range(len(meshes))
        if j != trace.fault
        for k in range(2)
        if far[j][2 * i + k] <= ON and trace.ends[k] != "closed"
    ]


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

    # carried on by the least bending
    out[fill] = np.nan
    out[fill] = draped(out, fill, frame.shape, frame.stretch, bend=1.0)
    return out.reshape(frame.shape)


def _side_of_trace(trace: Trace, main: FaultMesh) -> float:
    """Side of a fault on which most of a trace is near it: above 0 hanging wall, below 0, 0 far."""
    first, last = int(np.ceil(trace.start)), int(trace.stop) + 1
    places = trace.line[first:last, :3]
    return float(side_at_own_height(main, mesh_blocks(main, FAR), places, FAR)[1].sum())


def _side_of(branch: FaultMesh, main: FaultMesh) -> float:
    """Side of a main fault on which most of a branch is near it, +1 or -1.

    Its edges are asked every half cell: the triangles of a fault may be as wide as itself. What is
    on the main fault has no side.
    """
    # each edge is sampled, however long: middles of wide triangles may lie far from the main fault
    ends = np.stack([branch.triangles, np.roll(branch.triangles, -1, axis=1)], axis=2)
    a, b = branch.points[ends.reshape(-1, 2)].transpose(1, 0, 2)
    number = np.minimum(np.hypot(*(b - a)[:, :2].T) / EVERY, MOST).astype(np.int64) + 1
    edge, step = ranges(0, number)
    share = (step + 0.5) / number[edge]
    places = a[edge] + share[:, None] * (b - a)[edge]

    # the majority of places decides; those nearer than EVERY lie on the contact itself
    far, side = side_at_own_height(main, mesh_blocks(main, FAR), places, FAR)
    return 1.0 if side[far >= EVERY].sum() >= 0 else -1.0


def led_to(line: np.ndarray, end: int, main: Trace) -> np.ndarray:
    """A trace drawn out from one of its ends straight past the nearest point of another trace."""
    tip = line[0 if end == 0 else -1]
    far, _, foot = nearest(tip[:2], main)
    to_foot = foot - tip[:2]

    # a trace that touches already needs no piece; otherwise one to the foot, and PAST beyond it
    if far < 1e-6:
        return line
    more = np.repeat(tip[None], 2, axis=0)
    more[0, :2], more[1, :2] = 0.5 * (tip[:2] + foot), foot + to_foot / far * PAST
    return np.concatenate([more[::-1], line]) if end == 0 else np.concatenate([line, more])
