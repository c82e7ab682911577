"""A sheet as a plan, and a plan as the start of a sheet of slightly other data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geosurf.conventions import rising_diagonal
from geosurf.model import TriSurface, frozen
from geosurf.model.sheets import DataUse, TearPlan
from geosurf.sheets.faults.network import Network
from geosurf.sheets.faults.traces import mesh_in_frame
from geosurf.sheets.heights.base_case import base_heights, on_base_heights
from geosurf.sheets.heights.empty_blocks import refuse_empty_blocks
from geosurf.sheets.heights.evidence import picks_in_gaps
from geosurf.sheets.heights.inputs import Trims
from geosurf.sheets.heights.missing import missing_blocks
from geosurf.sheets.heights.passes import Rebuilt, solver_of
from geosurf.sheets.lattice.drape import around
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.lattice.scattered import Scattered
from geosurf.sheets.mesh.build import die_at_tips
from geosurf.sheets.mesh.close import Closed, Filling, built_of, rebuilt_of, solved_again
from geosurf.sheets.mesh.holes import Hole
from geosurf.sheets.mesh.repairs import Pair, Repairs

RINGS = 3  # that ends of branches get: with fewer, most sheets of Drogon need another cut
AROUND = 5  # cells around them
LARGE = 2.0  # cells: larger holes that are stuck are not those at the ends of tears


def plan_of(closed: Closed, loss: float, searched: bool) -> TearPlan:
    """What closed a sheet."""
    built, repairs = closed.built, closed.built.repairs
    rows, columns = closed.picks.frame.shape
    picks, nearby = closed.picks, closed.rebuilt.solver.inputs.nearby
    wrong = ~closed.rebuilt.selection.single
    if picks.several is not None:  # there data of both walls are no single ones, on either side
        wrong &= ~picks.several[picks.node]
    return TearPlan(
        shape=(int(rows), int(columns)),
        trims=tuple(map(float, closed.trims.of_fault)),
        given_trims=tuple(map(float, closed.given_trims.of_fault)),
        use=DataUse(
            frozen(built.state.ignored, np.bool_),
            frozen(wrong, np.bool_),
            tuple(frozen(near.rows, np.int64) for near in nearby),
            tuple(frozen(near.side, np.int8) for near in nearby),
        ),
        order=int(closed.rebuilt.solver.noise.order),
        traces=traces_of(built.state.network),
        early=tuple((int(i), int(k), int(n)) for (i, k), n in sorted(repairs.shortened.items())),
        # sorted: sets have no order of their own
        rings=tuple(tuple((int(a), int(b)) for a, b in sorted(one)) for one in repairs.rings),
        level=tuple((float(x), float(y)) for x, y in repairs.level),
        left_out=tuple((int(i), float(a), float(b)) for i, a, b in repairs.untorn),
        loss=float(loss),
        searched=searched,
        base=None if closed.filled or len(closed.pinched) else base_heights(closed.rebuilt),
    )


def close_as_planned(
    picks: Picks | Scattered,
    faults: Sequence[TriSurface],
    plan: TearPlan,
    noise: float | None,
    filling: Filling,
) -> Closed | None:
    """Rebuild heights and tear the mesh with the trims and remedies of a plan; it may stay open.

    Where holes are left, attempts go on from there until one of them is stuck. None if the plan is
    of other data, or of other traces.

    Raises
    ------
    GeometryError
        If a block has no data.
    """
    if not fits(plan, picks, faults):
        return None
    surfaces, given = tuple(faults), Trims(plan.given_trims)
    trims = Trims(plan.trims, plan.use)

    def closed(rebuilt: Rebuilt, start: Repairs, is_solved: bool = False) -> Closed:
        """The mesh with the repairs of the plan, and those that go on from there."""
        built = built_of(picks, rebuilt, surfaces, False, start, is_beyond, is_solved)
        return Closed(
            picks, rebuilt, built, surfaces, (), trims, given, filled, pinched, built.n_cut
        )  # fmt: skip

    def is_beyond(stuck: Sequence[Hole]) -> bool:
        """Whether holes that attempts have not changed are a matter for the search."""
        return any(hole.length > LARGE * picks.frame.cell for hole in stuck)

    # first with the walls of the plan, and traces on its heights
    filled: list[dict] = []
    pinched = np.empty(0, dtype=np.int64)
    if not filling.carry and filling.other is None:
        known = _on_base_heights(picks, surfaces, plan, noise, trims)
        if known is not None:
            found = closed(*known, is_solved=True)
            if not found.built.is_open:
                return found

    # then from these data alone
    picks, rebuilt, filled, pinched = rebuilt_of(picks, surfaces, trims, noise, filling, plan.order)
    refuse_empty_blocks(picks, rebuilt.state, [surface.name for surface in surfaces])
    start = repairs_of(plan, rebuilt.state.network)
    return None if start is None else closed(rebuilt, start)


def _on_base_heights(
    picks: Picks | Scattered,
    surfaces: Sequence[TriSurface],
    plan: TearPlan,
    noise: float | None,
    trims: Trims,
) -> tuple[Rebuilt, Repairs] | None:
    """Heights with the walls of a plan and throw that dies where its tears end, and its repairs.

    None if it has no heights, if traces are others, or a block has no data.
    """
    meshes = [mesh_in_frame(surface, picks.frame) for surface in surfaces]
    known = on_base_heights(solver_of(picks, meshes, trims, noise, highest=plan.order), plan)
    start = None if known is None else repairs_of(plan, known.state.network)
    if known is None or start is None:
        return None
    rising = rising_diagonal(picks.frame.easting, picks.frame.northing)
    state = die_at_tips(known.state, start, rising, solved_again(known, surfaces))
    state = state.with_walls(picks.frame)
    if len(state.stray) or state.filled_blocks or missing_blocks(picks, state, meshes):
        return None
    state = replace(state, in_gap=picks_in_gaps(known.solver.inputs, state))
    return replace(known, state=state), start


def fits(plan: TearPlan, picks: Picks | Scattered, faults: Sequence[TriSurface]) -> bool:
    """Whether a plan is of as many data on the same lattice, and of as many faults."""
    sizes = len(plan.trims), len(plan.use.ignored), plan.shape
    return sizes == (len(faults), len(picks.z), tuple(picks.frame.shape))


def repairs_of(plan: TearPlan, network: Network) -> Repairs | None:
    """The repairs of a plan, and those that most moved data need; None for other traces.

    Most holes of moved data are at tips and where branches end on their main faults. Throw dies at
    the last link of each tip, and ends of branches get further rings, which lose no throw.
    """
    if traces_of(network) != plan.traces:
        return None
    ends = [(i, k) for i, (_, *two) in enumerate(plan.traces) for k in (0, 1) if two[k] == "tip"]
    return Repairs(
        dict.fromkeys(ends, 0) | {(i, k): n for i, k, n in plan.early},
        (*(frozenset(ring) for ring in plan.rings), *_at_branches(network)),
        plan.level,
        plan.left_out,
    )


def _at_branches(network: Network) -> list[frozenset[Pair]]:
    """Further rings of ghosts around the ends of branches, by nodes."""
    frame, places = network.frame, []
    for trace, limits in zip(network.traces, network.mesh, strict=True):
        for end, place in zip(trace.ends, limits, strict=True):
            if end.startswith("branch"):
                vertex = np.arange(len(trace.line))
                places.append([np.interp(place, vertex, trace.line[:, c]) for c in (0, 1)])
    if not places:
        return []
    # the node next to each end, and those around it
    n_row, n_col = frame.shape
    col, row = np.rint(np.array(places) / frame.stretch).astype(np.int64).T
    ends = np.clip(row, 0, n_row - 1) * n_col + np.clip(col, 0, n_col - 1)
    nodes = around(ends, frame.shape, AROUND).tolist()
    return [frozenset(zip(nodes, nodes, strict=True))] * RINGS


def traces_of(network: Network) -> tuple[tuple[int, str, str], ...]:
    """The fault of each trace, and how it ends."""
    return tuple((int(t.fault), str(t.ends[0]), str(t.ends[1])) for t in network.traces)
