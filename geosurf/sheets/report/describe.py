"""The `SheetReport` of a sheet, and cut-offs and profiles of each fault."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from geosurf.arrangement.threads import map_threads
from geosurf.conventions import place
from geosurf.errors import GeosurfWarning
from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.kernels.meshes.linking import link_segments
from geosurf.kernels.sheets.link_lines import CHUNK, first_hits
from geosurf.model import FaultCut, SheetReport, TriSurface
from geosurf.model.sheets import ThrowAudit
from geosurf.sheets.faults.cut_edges import EAST, FALLING, NORTH, RISING, Cuts
from geosurf.sheets.faults.traces import Trace
from geosurf.sheets.heights.state import SENSE, Heights, NearPicks, Trims
from geosurf.sheets.lattice.picks import Frame, Picks
from geosurf.sheets.mesh.build import Built
from geosurf.sheets.mesh.close import Closed
from geosurf.sheets.mesh.cut import Cut
from geosurf.sheets.mesh.finish import on_sheet
from geosurf.sheets.mesh.torn_mesh import Torn
from geosurf.sheets.report.audit import audit_throw, warnings_of_throw
from geosurf.sheets.report.fault_ends import throw_at_tips
from geosurf.sheets.report.remedies import remedies

# ---- cutoffs ----------------------------------------
# Cut-off lines of both walls after the exact cut, and throw and heave along the fault.
#
# A cut-off line is where the sheet ends on the fault: edges of one remaining triangle of the sheet
# that a fault shares. Throw and heave are measured between the two lines in the dip direction of
# the fault at each station of its trace: throw is positive where the hanging wall is down, heave
# where there is a gap.


LONGEST = 12.0  # cells from a station within which a cut-off is looked for, and
BESIDE = 2.0  # cells more than the widest wall is from its trace


def longest(state: Heights) -> float:
    """Cells from a station within which its cut-offs are."""
    widest = [np.abs([walls.left, walls.right]).max(initial=0.0) for walls in state.walls]
    return max(LONGEST, max(widest, default=0.0) + BESIDE)


def fault_edges(cut: Cut, fault: int) -> tuple[np.ndarray, np.ndarray]:
    """Edges (n, 2) of remaining sheet triangles that a fault shares, and their triangles (n,)."""
    # curve_sides[0] has the sheet, the others its faults; a key is two vertices of an edge
    keys, triangle = cut.curve_sides[0]
    mine = cut.keep[triangle]
    keys, triangle = keys[mine], triangle[mine]
    shared = is_among(keys, cut.curve_sides[1 + fault][0])
    keys, triangle = keys[shared], triangle[shared]
    return np.stack(np.divmod(keys, len(cut.patches.local)), axis=1), triangle


def cutoff_lines(cut: Cut, state: Heights, torn: Torn, fault: int) -> dict[str, list[np.ndarray]]:
    """Cut-off lines (n, 3) of a fault by wall, world coordinates; "+" is the hanging wall."""
    patches = cut.patches
    edges, triangle = fault_edges(cut, fault)

    # real (n_edge, 3): nodes on the wall of each edge's triangle, ghosts replaced by anchors
    parent = cut.corners[patches.parent_of_triangle[triangle]]
    real = torn.anchored(parent)
    # all corners of a parent are on sheets of one side, but where a tear has healed
    side = state.sides_of(fault, real)

    # an edge of both walls is found twice
    lines: dict[str, list[np.ndarray]] = {}
    key = edges[:, 0] * len(patches.local) + edges[:, 1]
    _, inverse, times = np.unique(key, return_inverse=True, return_counts=True)
    both = times[inverse] > 1  # the sheet is whole there: both walls share the line
    total = side.sum(axis=1)
    for wall, sign in (("+", 1), ("-", -1)):
        # the majority of the three corners names the wall
        mine = distinct(key[both | (np.sign(total) == sign)])
        mine = np.stack(np.divmod(mine, len(patches.local)), axis=1)
        lines[wall] = [patches.vertices[line] for line in undirected_chains(mine)]
    return lines


def undirected_chains(edges: np.ndarray) -> list[np.ndarray]:
    """Edges (n, 2) in any direction, each once -> lines, longest runs between ends and branches."""
    if len(edges) == 0:
        return []

    points, ends = np.unique(edges, return_inverse=True)
    whole = np.array([0, len(edges)])
    chains, offsets, _ = link_segments(ends.reshape(-1, 2), whole, len(points))
    return np.split(points[chains], offsets[1:-1])


def profile(
    stations: np.ndarray, direction: np.ndarray, walls: dict[str, list[np.ndarray]], reach: float
) -> tuple[np.ndarray, np.ndarray]:
    """Throw and heave (n,) [m] at stations (n, 2), along their dip directions; NaN where none."""
    # t: distance from the station along the dip direction; z: elevation, both of each wall
    at = {wall: met(stations, direction, lines, reach) for wall, lines in walls.items()}
    (t_plus, z_plus), (t_minus, z_minus) = at["+"], at["-"]
    return z_minus - z_plus, t_plus - t_minus


def met(
    stations: np.ndarray, direction: np.ndarray, lines: Sequence[np.ndarray], reach: float
) -> tuple[np.ndarray, np.ndarray]:
    """Distance along the direction and third coordinate (n,) where the nearest line is met."""
    n = len(stations)

    # pieces (n, 6): first and second end of each
    each = [np.hstack([line[:-1], line[1:]]) for line in lines if len(line) > 1]
    if not each or n == 0:
        return np.full(n, np.nan), np.full(n, np.nan)
    pieces = np.concatenate(each)

    # boxes in the map of runs of CHUNK pieces: most of them cannot be met
    first = np.arange(0, len(pieces), CHUNK)
    low = np.minimum.reduceat(np.minimum(pieces[:, :2], pieces[:, 3:5]), first)
    high = np.maximum.reduceat(np.maximum(pieces[:, :2], pieces[:, 3:5]), first)
    return first_hits(stations, direction, pieces, np.hstack([low, high]), reach)


# share of the largest throw, but metres at least and at most, by which one datum in twenty may be
# missed; and how many times as far the worst one
OF_THROW, MOVED, FARTHEST_MOVED = 0.1, (0.1, 1.0), 10.0
FAR = 4.0  # cells of extrapolation from which a place is listed
OVERLAP = 0.5  # cells of overlap from which a note says that data do not show it
LINKS = 3  # side by side that overlap: a single one at a contact may reach over the other fault


def fault_cuts(frame: Frame, built: Built, faults: Sequence[TriSurface]) -> dict[str, FaultCut]:
    """Cut-offs and profiles of all faults."""
    state = built.state

    def cut_by(number: int, fault: TriSurface) -> FaultCut:
        """Cut-offs and profiles of one fault."""
        # stations, directions and places of all traces of the fault, one after the other
        walls = cutoff_lines(built.cut, state, built.torn, number)
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
    along = trace.stations
    line = trace.at_length(along)
    xy = frame.from_cells(line[:, :2])

    # unit vectors of the lattice turn the horizontal part of normals into world directions
    axes = frame.step / frame.spacing[:, None]
    direction = line[:, 3:5] @ axes
    direction /= np.maximum(np.hypot(*direction.T), 1e-12)[:, None]
    return np.column_stack([xy, line[:, 2]]), direction, (along - along[0]) * frame.cell


def make_report(closed: Closed, cuts: dict[str, FaultCut], measured: Trims | None) -> SheetReport:
    """All numbers of a sheet; `measured`: trims beyond which the data show no smear.

    None for data that were drawn, which show nothing: throw is not compared with them.
    """
    picks, built, solver = closed.picks, closed.built, closed.rebuilt.solver
    state = built.state
    names = list(cuts)
    trim = closed.trims.widest
    notes = [
        f"Fault {name!r} does not meet the horizon." for name in names if not len(cuts[name].along)
    ]
    notes += _overlap_notes(picks, state, names, trim)
    noise = None if solver.noise.weight is None else solver.noise.deviation
    misfit, moved = _misfit_in_use(picks, state, cuts, noise)
    # what closed the sheet, throw that it does not have, and data that it does not meet
    audits: dict[str, ThrowAudit] = {}
    differing: list[GeosurfWarning] = []
    tips = throw_at_tips(picks, state, closed.faults, trim)
    if measured is not None:
        audits, polygons = audit_throw(closed, cuts, measured), solver.inputs.cutoffs.keys()
        differing = warnings_of_throw(picks.name, audits, closed.trims.of_fault, tips, polygons)
    warnings = (*remedies(closed), *differing, *tips, *moved)
    notes += map(str, warnings)
    return SheetReport(
        trim=trim,
        trims=dict(zip(names, closed.trims.of_fault, strict=False)),
        cell=picks.frame.cell,
        n_data=len(picks.z),
        n_ignored=int(state.ignored.sum()),
        n_solved=len(state.unknown),
        misfit=misfit,
        holdout_misfit=_misfit(holdout_misfit(picks, solver.inputs.nearby, built)),
        extrapolation=_far_places(picks.frame, state, names),
        throw=audits,
        sign_changes={name: _sign_changes(cut.throw) for name, cut in cuts.items()},
        tips=count_tips(built),
        declared_tips=state.network.declared_tips,
        shortened=shortened_by_fault(built, names),
        noise=noise,
        filled_blocks=[*closed.rebuilt.filled, *state.filled_blocks],
        notes=notes,
        warnings=warnings,
    )


def shortened_by_fault(built: Built, names: Sequence[str]) -> dict[str, int]:
    """By how many links the tears of each fault end early."""
    links: dict[str, int] = {}
    for (trace, _), n in built.repairs.shortened.items():
        name = names[built.state.network.traces[trace].fault]
        links[name] = links.get(name, 0) + n
    return links


def _overlap_notes(picks: Picks, state: Heights, names: Sequence[str], trim: float) -> list[str]:
    """A sentence for each fault over which the horizon overlaps where its data do not."""
    overlaps: dict[str, float] = {}
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
            overlaps[name] = max(overlaps.get(name, 0.0), overlap)
    cell = picks.frame.cell
    return [
        f"Fault {name!r} is reverse: the horizon overlaps by up to {cells * cell:.0f} m "
        "there, which one value per node cannot show. Give points of both walls"
        + (f", or trim={0.5 * cells + 2.25:.1f}." if trim < 0.5 * cells + 2.0 else ".")
        for name, cells in overlaps.items()
    ]


def _misfit_in_use(
    picks: Picks, state: Heights, cuts: Mapping[str, FaultCut], noise: float | None
) -> tuple[dict[str, float], list[GeosurfWarning]]:
    """Misfit at data in use: most are met bit for bit, and only counted; a warning if it counts."""
    missed = picks.missed(state.values, state.used)
    off = picks.misfit(state.values, missed)
    misfit = _misfit(off, int(state.used.sum()) - len(missed))
    throws = [np.abs(cut.throw[np.isfinite(cut.throw)]).max(initial=0.0) for cut in cuts.values()]
    limit = float(np.clip(OF_THROW * max(throws, default=np.inf), *MOVED))
    if not misfit or (misfit["p95"] <= limit and misfit["max"] <= FARTHEST_MOVED * limit):
        return misfit, []
    worst = missed[[np.nanargmax(off)]]
    at = (*picks.frame.to_world(picks.columns(worst))[0].tolist(), float(picks.z[worst[0]]))
    why = "Several points share a node or a cell."
    how = (
        "Leave out those that are wrong, or tear with gs.tear_horizon(..., spacing=) below "
        f"{picks.frame.cell:.3g} m"
    )
    if noise is not None:
        why = f"They are taken to have noise of {noise:.3g} m, which is averaged."
        how = (
            "If they are exact, gs.tear_horizon(..., noise=0) or noise_m = 0 in [tear] meets them. "
            "Noise then goes into the throw"
        )
    p95 = misfit["p95"]
    often = f"by {p95:.3g} m or more at one point in twenty, " if p95 > 0 else ""
    warning = GeosurfWarning(
        "moved data",
        picks.name,
        f"Horizon {picks.name!r} does not pass through its data: it is off by "
        f"{misfit['mean']:.3g} m on average, {often}and by "
        f"{misfit['max']:.3g} m at {place(at)}. {why}",
        f"{how}. report.misfit has these figures.",
        at,
    )
    return misfit, [warning]


def _misfit(values: np.ndarray, met: int = 0) -> dict[str, float]:
    """Figures of some misfits and of `met` that are 0."""
    values = np.sort(values[np.isfinite(values)])
    n = met + len(values)
    if n == 0:
        return {}

    def share(part: float) -> float:
        """The value below which a share of all lies, linear between two."""
        # the sorted list begins with `met` zeros, which are not stored
        at = part * (n - 1)
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
    entries = []
    for k in order.tolist():
        at = frame.uv_of_node(state.unknown[k : k + 1])[0]
        if any(np.abs(at - other).max() < 10 for other in places):
            continue
        places.append(at)
        node = state.unknown[k : k + 1]
        xy = frame.node_places(node)[0]
        world = [float(xy[0]), float(xy[1]), float(state.values[node[0]])]
        fault = _nearest_fault(state, int(node[0]), names)
        entries.append({"cells": float(steps[k]), "place": world, "fault": fault})
        if len(entries) == 20:
            break
    return entries


def _nearest_fault(state: Heights, node: int, names: Sequence[str]) -> str:
    best, name = np.inf, ""
    for trace, near in zip(state.network.traces, state.near, strict=True):
        at = int(near.look_up(np.array([node]))[0])
        if at >= 0 and near.distance[at] < best:
            best, name = near.distance[at], names[trace.fault]
    return name


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


def holdout_misfit(picks: Picks, near: Sequence[NearPicks], built: Built) -> np.ndarray:
    """Misfit (n,) of ignored data against the sheet of their wall [m].

    Without those in gaps, where there is nothing to meet, those that ghosts are drawn to, those of
    nodes with several on a grid, and those where no single sheet goes: next to other faults.
    """
    state = built.state

    # ignored data that lie on exactly one sheet
    hidden = state.ignored.copy()
    hidden[state.in_gap] = False
    hidden[state.beyond[:, 0]] = False
    rows = np.flatnonzero(hidden)
    if picks.several is not None:
        rows = rows[~picks.several[picks.node[rows]]]

    # trace (n,) and side (n,) of each; plain (n,): its nodes are on its own wall already
    trace, side, plain = _walls_of(picks, near, state, rows)
    vertex, share = picks.corners_of(rows)

    # cells that a fault cuts have nodes of both walls; with several faults none is certain
    if not picks.on_nodes:
        cells, trace_of_cell = _cells_cut(built.cuts, picks.frame.shape[1])
        cut = is_among(vertex[:, 0], cells)
        plain &= ~cut
        for number in np.unique(trace[cut]).tolist():
            at_trace = cut & (trace == number)
            vertex[at_trace & is_among(vertex[:, 0], cells[trace_of_cell != number])] = -1

    # data past the trace: their wall is there as ghosts, which take the place of nodes
    aside = ~plain & (vertex[:, 0] >= 0)
    vertex[aside & (trace < 0)] = -1
    for number, wall in np.unique(np.stack([trace, side])[:, aside & (trace >= 0)], axis=1).T:
        at_trace = aside & (trace == number) & (side == wall)
        vertex[at_trace] = on_sheet(vertex[at_trace], state.near[number], int(wall), built.torn)

    # vertices are nodes first, then ghosts
    there = (vertex >= 0).all(axis=1)
    heights = np.concatenate([state.values, built.ghosts])
    return np.abs((heights[vertex[there]] * share[there]).sum(axis=1) - picks.z[rows[there]])


def _walls_of(
    picks: Picks, near: Sequence[NearPicks], state: Heights, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The nearest trace (n,) of picks beside one, -1 without; which side of it; if their node's."""
    # per pick, of the nearest fault so far: distance at own height, trace, side, and whether its
    # node is on the same wall
    far = np.full(len(rows), np.inf)
    trace, side = np.full(len(rows), -1), np.zeros(len(rows), dtype=np.int64)
    plain = np.ones(len(rows), dtype=bool)
    for number, (line, beside) in enumerate(zip(state.network.traces, state.near, strict=True)):
        near_fault = near[line.fault]
        at, k = beside.look_up(picks.nodes_of(rows)), np.searchsorted(near_fault.rows, rows)
        members = np.flatnonzero((at >= 0) & is_among(rows, near_fault.rows))
        at, k = at[members], k[members]

        # only beside the torn part of the trace, and only where no other fault is nearer
        first, last = state.network.mesh[number]
        along = beside.place[at]
        inside = (along > first) & (along < last) & (near_fault.far[k] < far[members])
        members, at, k = members[inside], at[inside], k[inside]
        here, there = beside.side[at].astype(np.int64), near_fault.side[k].astype(np.int64)

        # on grids the side in the map is the datum's, except in overlaps, where both walls are
        # there
        if picks.on_nodes:
            there = np.where(state.walls[number].heave(beside.place[at]) < -SENSE, there, here)
        far[members], trace[members], side[members] = near_fault.far[k], number, there
        plain[members] = here == there
    return trace, side, plain


def _cells_cut(cuts: Cuts, n_col: int) -> tuple[np.ndarray, np.ndarray]:
    """Cells, by their lower left nodes, that cut links bound or cross, and the trace of each."""
    # a cell has its own links; an east link also bounds the cell below, a north link that west
    below = cuts.kind == EAST
    west = cuts.kind == NORTH
    cells = [cuts.node, cuts.node[below] - n_col, cuts.node[west] - 1]
    traces = [cuts.trace, cuts.trace[below], cuts.trace[west]]
    order = np.argsort(np.concatenate(cells), kind="stable")
    return np.concatenate(cells)[order], np.concatenate(traces)[order]
