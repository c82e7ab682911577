"""The `SheetReport` of a sheet, and cut-offs and profiles of each fault."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from geosurf.arrangement.threads import map_threads
from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.model import FaultCut, SheetReport, TriSurface
from geosurf.sheets.faults.cut_edges import FALLING, RISING
from geosurf.sheets.faults.traces import Trace
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.lattice.frame import Frame
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.mesh.build import Built
from geosurf.sheets.mesh.close import Closed
from geosurf.sheets.report.cutoffs import cutoff_lines, longest, profile
from geosurf.sheets.report.holdout_misfit import holdout_misfit
from geosurf.sheets.report.remedies import remedies
from geosurf.sheets.report.tip_throw import throw_at_tips

FAR = 4.0  # cells of extrapolation from which a place is listed
OVERLAP = 0.5  # cells of overlap from which a note says that data do not show it
LINKS = 3  # side by side that overlap: a single one at a contact may reach over the other fault
STATION = 1.0  # cells between the stations of a profile


def fault_cuts(frame: Frame, built: Built, faults: Sequence[TriSurface]) -> dict[str, FaultCut]:
    """Cut-offs and profiles of all faults."""
    state = built.state

    def cut_by(number: int, fault: TriSurface) -> FaultCut:
        """Cut-offs and profiles of one fault."""
        # stations, directions and places of all traces of the fault, one after the other
        walls = cutoff_lines(built.cut.part_of(number), state, built.torn, number)
        traces = [t for t in state.network.traces if t.fault == number]
        parts = [_stations(trace, frame) for trace in traces]
        stations = np.concatenate([p[0] for p in parts]) if parts else np.empty((0, 3))
        direction = np.concatenate([p[1] for p in parts]) if parts else np.empty((0, 2))
        along = np.concatenate([p[2] for p in parts]) if parts else np.empty(0)
        throw, heave = profile(stations[:, :2], direction, walls, longest(state) * frame.cell)
        ends = tuple(end for trace in traces for end in trace.ends)
        lines = {wall: tuple(lines) for wall, lines in walls.items()}
        return FaultCut(fault.name, lines, stations, along, throw, heave, ends)

    found = map_threads(cut_by, list(enumerate(faults)))
    return {cut.fault: cut for cut in found}


def no_cuts(faults: Sequence[TriSurface]) -> dict[str, FaultCut]:
    """Empty cut-offs for each fault."""
    none = np.empty(0)
    return {
        fault.name: FaultCut(fault.name, {"+": (), "-": ()}, np.empty((0, 3)), none, none, none, ())
        for fault in faults
    }


def _stations(trace: Trace, frame: Frame) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stations (n, 3), dip directions (n, 2) and distance along the trace (n,), in metres."""
    vertex = np.arange(len(trace.line))
    first, last = np.interp([trace.start, trace.stop], vertex, trace.along)

    # about a cell apart, over the real part of the trace only
    n = max(int((last - first) / STATION), 1) + 1
    along = np.linspace(first, last, n)
    line = np.stack([np.interp(along, trace.along, c) for c in trace.line.T], axis=1)
    xy = frame.to_world(line[:, :2] / frame.stretch)

    # unit vectors of the lattice turn the horizontal part of normals into world directions
    axes = frame.step / frame.spacing[:, None]
    direction = line[:, 3:5] @ axes
    direction /= np.maximum(np.hypot(*direction.T), 1e-12)[:, None]
    return np.column_stack([xy, line[:, 2]]), direction, (along - first) * frame.cell


def make_report(closed: Closed, cuts: dict[str, FaultCut]) -> SheetReport:
    """All numbers of a sheet."""
    picks, built, solver = closed.picks, closed.built, closed.rebuilt.solver
    state = built.state
    names = list(cuts)
    traces = state.network.traces
    shortened: dict[str, int] = {}
    for (trace, _), n in built.repairs.shortened.items():
        name = names[traces[trace].fault]
        shortened[name] = shortened.get(name, 0) + n
    trim = closed.trims.widest
    notes = [
        f"Fault {name!r} does not meet the horizon." for name in names if not len(cuts[name].along)
    ]
    notes += _overlap_notes(picks, state, names, trim)
    # what closed the sheet, and throw that it does not have
    warnings = (*remedies(closed), *throw_at_tips(picks, state, closed.faults, trim))
    notes += map(str, warnings)
    return SheetReport(
        trim=trim,
        trims=dict(zip(names, closed.trims.of_fault, strict=False)),
        cell=picks.frame.cell,
        n_data=len(picks.z),
        n_ignored=int(state.ignored.sum()),
        n_solved=len(state.unknown),
        misfit=_misfit_in_use(picks, state),
        holdout_misfit=_misfit(holdout_misfit(picks, solver.inputs.nearby, built)),
        extrapolation=_far_places(picks.frame, state, names),
        sign_changes={name: _sign_changes(cut.throw) for name, cut in cuts.items()},
        tips=count_tips(built),
        declared_tips=state.network.declared_tips,
        shortened=shortened,
        noise=None if solver.noise.weight is None else solver.noise.deviation,
        filled_blocks=[*closed.filled, *state.filled_blocks],
        notes=notes,
        warnings=warnings,
    )


def _overlap_notes(picks: Picks, state: Heights, names: Sequence[str], trim: float) -> list[str]:
    """A sentence for each fault over which the horizon overlaps where its data do not."""
    found: dict[str, float] = {}
    if not picks.on_nodes:
        return []

    # where nodes have picks of both walls, the data do show the overlap
    several = np.zeros(picks.n_node, dtype=bool) if picks.several is None else picks.several
    lines = zip(state.network.traces, state.near, state.walls, strict=True)
    for trace, near, walls in lines:
        heave = walls.left + walls.right
        if len(heave) < LINKS:
            continue

        # the widest overlap that LINKS neighbouring links have in common: one alone is noise
        overlap = -float(sliding_window_view(heave, LINKS).max(axis=1).min())
        if overlap > OVERLAP and not several[near.nodes_within(overlap)].any():
            name = names[trace.fault]
            found[name] = max(found.get(name, 0.0), overlap)
    cell = picks.frame.cell
    return [
        f"Fault {name!r} is reverse: the horizon overlaps by up to {cells * cell:.0f} m "
        "there, which one value per node cannot show. Give points of both walls"
        + (f", or trim={0.5 * cells + 2.25:.1f}." if trim < 0.5 * cells + 2.0 else ".")
        for name, cells in found.items()
    ]


def _misfit_in_use(picks: Picks, state: Heights) -> dict[str, float]:
    """Misfit at data in use: most are met bit for bit, and only counted."""
    missed = picks.missed(state.values, state.used)
    met = int(state.used.sum()) - len(missed)
    return _misfit(picks.misfit(state.values, missed), met)


def _misfit(values: np.ndarray, met: int = 0) -> dict[str, float]:
    """Figures of some misfits and of `met` that are 0."""
    values = np.sort(values[np.isfinite(values)])
    n = met + len(values)
    if n == 0:
        return {}

    def share(of: float) -> float:
        """The value below which a share of all lies, linear between two."""
        # the sorted list begins with `met` zeros, which are not stored
        at = of * (n - 1)
        k = np.array([np.floor(at), np.ceil(at)], dtype=np.int64) - met
        low, high = (float(values[i]) if i >= 0 else 0.0 for i in k)
        return float(low + (at - np.floor(at)) * (high - low))

    return {
        "mean": float(values.sum()) / n,
        "median": share(0.5),
        "p95": share(0.95),
        "max": float(values.max(initial=0.0)),
    }


def _sign_changes(throw: np.ndarray) -> int:
    throw = throw[np.isfinite(throw)]

    # a twentieth of the largest throw: smaller ones change sign by rounding
    large = throw[np.abs(throw) > 0.05 * np.abs(throw).max(initial=0.0)]
    return int((np.diff(np.sign(large)) != 0).sum())


def _far_places(frame: Frame, state: Heights, names: Sequence[str]) -> list[dict]:
    """Nodes that are farthest from data of their side, one for each ten cells around."""
    # farthest first; those within ten cells of one in the list are the same place
    steps = state.extrapolation
    order = np.argsort(-steps, kind="stable")
    order = order[steps[order] > FAR]
    places: list[np.ndarray] = []
    found = []
    for k in order.tolist():
        at = frame.uv_of_node(state.unknown[k : k + 1])[0]
        if any(np.abs(at - other).max() < 10 for other in places):
            continue
        places.append(at)
        node = state.unknown[k : k + 1]
        xy = frame.node_places(node)[0]
        world = [float(xy[0]), float(xy[1]), float(state.values[node[0]])]
        fault = _nearest_fault(state, int(node[0]), names)
        found.append({"cells": float(steps[k]), "place": world, "fault": fault})
        if len(found) == 20:
            break
    return found


def _nearest_fault(state: Heights, node: int, names: Sequence[str]) -> str:
    best, found = np.inf, ""
    for trace, near in zip(state.network.traces, state.near, strict=True):
        at = int(near.look_up(np.array([node]))[0])
        if at >= 0 and near.distance[at] < best:
            best, found = near.distance[at], names[trace.fault]
    return found


def count_tips(built: Built) -> int:
    """Tips of the mesh: cut links with a divided triangle on one side and a whole one beyond."""
    cuts, torn, triangles = built.cuts, built.torn, built.triangles

    # both triangles beside each cut link: at a tip one of them is whole
    links = distinct(cuts.node * 4 + cuts.kind)
    beside = triangles.beside(links // 4, links % 4)
    divided = is_among(beside, torn.divided)
    there = np.stack([triangles.exists(beside[:, k]) for k in (0, 1)], axis=1)
    mesh = (links % 4 < 2) | (links % 4 == (RISING if triangles.rising else FALLING))
    return int((mesh & (divided.sum(axis=1) == 1) & (there & ~divided).any(axis=1)).sum())
