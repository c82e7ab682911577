"""Data of one horizon and its faults -> a torn mesh that ends on them, by the smallest remedy.

First the faults are taken as they are. If a hole is next to the upper or lower rim of a fault, or
to the end of a branch, the fault is extended there, each time by twice as much, and the horizon is
torn again. What is still open after that can be closed at any cost (`geosurf.sheets.mesh.build`).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial

import numpy as np

from geosurf.errors import GeosurfError
from geosurf.kernels.lattices.sets import distinct
from geosurf.model import TriSurface, frozen
from geosurf.model.sheets import DataUse, Extended, TearPlan
from geosurf.sheets.faults.cut_edges import Part, on_own_side
from geosurf.sheets.faults.network import Network
from geosurf.sheets.faults.traces import FaultMesh, mesh_in_frame
from geosurf.sheets.heights.grid_solver import GridSolver, refuse_empty_blocks
from geosurf.sheets.heights.missing import (
    StandIn,
    continued,
    missing_blocks,
    nodes_to_stand_in,
    refuse_missing,
    stood_in,
)
from geosurf.sheets.heights.passes import (
    Rebuilt,
    base_heights,
    on_base_heights,
    picks_in_gaps,
    rebuild,
    solver_of,
)
from geosurf.sheets.heights.state import Cutoffs, Heights, Trims
from geosurf.sheets.lattice.data import Scattered
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.lattice.solve import around
from geosurf.sheets.mesh.build import (
    LARGE,
    NO_REPAIRS,
    Attempts,
    Built,
    NeedsMore,
    Pair,
    Repairs,
    SolveAgain,
    build,
    die_at_tips,
)
from geosurf.sheets.mesh.cut import Hole
from geosurf.sheets.mesh.finish import ghosts_by_points
from geosurf.sheets.mesh.ghosts import carry_on_by, ghosts_by_picks
from geosurf.sheets.mesh.tear_ends import MOST, VERTICAL, Short, extended, too_short

# ---- last links ----------------------------------------
# Where a tear ends early, both nodes of its last link go to their own sides of the fault.
#
# A node between the cut-offs of both walls has a height that is extrapolated past the fault. Where
# throw dies at it, the sheet would go around the fault there: by centimetres, as the fault passes
# close to the node. Ending the tear yet earlier would lose the throw of another cell.


NUDGE = 0.1  # cells by which a node goes up or down


def with_last_links(
    state: Heights, limits: np.ndarray, meshes: Sequence[FaultMesh], rising: bool
) -> Heights:
    """Heights with which tears can end at the last links outside of limits (n_trace, 2).

    `meshes` are the faults in the frame of the lattice.
    """
    network, values = state.network, state.values.copy()
    frame = network.frame
    for i, node in network.last_nodes(limits, rising):
        near, old = state.near[i], float(values[node])
        side = float(near.side[near.look_up(np.array([node]))[0]])
        # the side changes upwards or downwards, whichever wall the node was extrapolated from
        for other in (old + NUDGE * frame.cell, old - NUDGE * frame.cell):
            new = on_own_side(meshes[network.traces[i].fault], frame, node, side, old, other)
            if new != old:
                values[node] = new
                break
    return replace(state, values=values)


REACH = 4.0  # cells from the rim of a fault within which a hole is a matter of that
LEAST = 0.5  # of its height by which a fault is extended along its dip at first
LEAST_ALONG, MOST_ALONG = 3.0, 6.0  # cells by which a branch is extended along strike

MOST_ROUNDS = 72  # attempts in all, at longer and longer faults

Longer = dict[int, tuple[Extended, TriSurface]]  # by fault: the list entry and the surface


@dataclass(frozen=True, eq=False)
class Closed:
    """A torn mesh, and what it took to close it.

    Attributes
    ----------
    rebuilt : Rebuilt
    built : Built
        Open only if no remedy closes it.
    faults : tuple of TriSurface
        As given, or extended.
    extensions : tuple of Extended
    trims, given_trims : Trims
        In use, and as they were at first.
    n_cut : int
        How often the mesh was cut in the last step: without a loss, or at any cost.
    """

    rebuilt: Rebuilt
    built: Built
    faults: tuple[TriSurface, ...]
    extensions: tuple[Extended, ...]
    trims: Trims
    given_trims: Trims
    n_cut: int

    @property
    def picks(self) -> Picks | Scattered:
        """The data, with blocks that were filled."""
        return self.rebuilt.picks


@dataclass(frozen=True, eq=False)
class Data:
    """Data of one horizon, their noise [m] if it is given, and what becomes of blocks without any.

    Such blocks are refused, continued (`carry`), or as another horizon is there. `cutoffs` are the
    lines of fault polygons, `given` faults that are longer already: as given, and by how much [m].
    """

    picks: Picks | Scattered
    noise: float | None = None
    carry: bool = False
    other: StandIn | None = None
    cutoffs: Cutoffs = field(default_factory=dict)
    given: Mapping[str, tuple[TriSurface, Mapping[str, float]]] = field(default_factory=dict)


def close(
    data: Data,
    faults: Sequence[TriSurface],
    trims: Trims,
    given_trims: Trims,
    known_short: Collection[int] = (),
    highest: int = 4,
    most: int = MOST_ROUNDS,
) -> Closed:
    """Rebuild heights, tear the mesh, and close it without any loss of throw; it may stay open.

    `known_short` are numbers of faults that are extended up and down from the start; `highest` is
    the order of small differences at most, `most` how often the mesh is cut.

    Raises
    ------
    GeometryError
        If a block has no data.
    """
    # faults that are known to be short are extended before the first attempt
    surfaces = given = tuple(faults)
    cell = data.picks.frame.cell
    extensions = Extensions(given, cell, data.given)
    short = {k: Short(frozenset(VERTICAL), given[k].vertices.mean(axis=0)) for k in known_short}
    more = extensions.longer(short)
    n_cut = 0
    first: Closed | None = None
    while True:
        # each round extends faults next to holes, twice as far as before; MOST ends it
        extensions.found |= {k: extended for k, (extended, _) in more.items()}
        surfaces = tuple(more[k][1] if k in more else old for k, old in enumerate(surfaces))
        rebuilt = rebuilt_of(data, surfaces, trims, highest)
        # A block that is empty only because its data were ignored near faults gets some of them
        # back.
        narrower = _narrower(trims, rebuilt.state)
        if narrower is not None:
            trims, more = narrower, {}
            continue
        # What is still empty now has no data at all.
        refuse_empty_blocks(rebuilt.picks, rebuilt.state, [fault.name for fault in surfaces])
        ends = _branch_ends(rebuilt.state)
        # Which faults the holes ask for is tested during the attempts too, so that these end early.
        asked = partial(extensions.longer_at, surfaces, ends)
        built = built_of(rebuilt, surfaces, needs_more=asked, most=most - n_cut)
        n_cut += built.n_cut
        found = tuple(extensions.found.values())
        closed = Closed(rebuilt, built, surfaces, found, trims, given_trims, n_cut)
        # so many holes are a matter of the data, not of a fault that is too short
        more = asked(built.cut.holes) if built.is_open and not built.is_hopeless else {}
        # Closed, or no fault can be extended any further.
        if not more or n_cut >= most:
            break
        first = first or closed
    # longer faults that have closed no hole stay as they were: other horizons would end on them
    if first is not None and built.is_open and _are_left(first.built, built, cell):
        closed = first
    return replace(closed, n_cut=n_cut)


def _are_left(before: Built, now: Built, cell: float) -> bool:
    """Whether a mesh has all holes of another one."""
    return all(any(one.is_like(old, cell) for one in now.cut.holes) for old in before.cut.holes)


def close_at_any_cost(closed: Closed) -> Closed:
    """Go on from a sheet that is open with remedies that change cut-offs; it may stay open."""
    # From the repairs that were found: they hold at any cost too.
    built = built_of(closed.rebuilt, closed.faults, True, closed.built.repairs)
    return replace(closed, built=built, n_cut=built.n_cut)


def _narrower(trims: Trims, state: Heights) -> Trims | None:
    """Half the trims of faults next to a block without data beyond them; None if none is left."""
    if not len(state.stray):
        return None
    traces = zip(state.network.traces, state.near, strict=True)
    beside = {trace.fault for trace, near in traces if (near.look_up(state.stray) >= 0).any()}
    # Half, but never below one cell, within which data of the other wall reach.
    half = [max(0.5 * t, min(t, 1.0)) if k in beside else t for k, t in enumerate(trims.of_fault)]
    return trims.with_trims(half) if tuple(half) != trims.of_fault else None


def _branch_ends(state: Heights) -> dict[int, np.ndarray]:
    """Places (n, 2) at which traces end on another fault, by fault [m]."""
    frame, places_of_fault = state.network.frame, dict[int, list[np.ndarray]]()
    for trace in state.network.traces:
        # `start` and `stop` are places between vertices of the line.
        for end, place in zip(trace.ends, (trace.start, trace.stop), strict=True):
            if end.startswith("branch"):
                places_of_fault.setdefault(trace.fault, []).append(trace.at(place)[:2])
    return {fault: frame.from_cells(np.array(places)) for fault, places in places_of_fault.items()}


class Extensions:
    """Longer faults of one sheet, each time twice as far as before.

    Attributes
    ----------
    given : list of TriSurface
    by : list of mapping of str to float
        How far each was extended before [m].
    cell : float
        [m]
    found : dict of int to Extended
        By fault: how far it is extended now, from what was given.
    """

    def __init__(
        self,
        faults: Sequence[TriSurface],
        cell: float,
        given: Mapping[str, tuple[TriSurface, Mapping[str, float]]],
    ) -> None:
        pairs = [given.get(fault.name, (fault, {})) for fault in faults]
        self.given, self.by = [one for one, _ in pairs], [by for _, by in pairs]
        self.cell = cell
        self.found: dict[int, Extended] = {}
        # once for each fault and length: attempts ask for the same ones again and again
        self._made = cache(lambda number, lengths: extended(self.given[number], dict(lengths)))

    def longer_at(
        self, surfaces: Sequence[TriSurface], ends: Mapping[int, np.ndarray], holes: Sequence[Hole]
    ) -> Longer:
        """Faults to extend because of holes: `surfaces`, as they are now, end next to them."""
        return self.longer(too_short(holes, surfaces, REACH * self.cell, ends))

    def longer(self, short: Mapping[int, Short]) -> Longer:
        """Faults that are too short, longer than before; none that cannot be."""
        extended: Longer = {}
        for number, missing in short.items():
            old = self.found.get(number)
            lengths = dict(self.by[number] if old is None else old.lengths)
            # Twice as far as before at each side, until the most is reached.
            # in one order: that of a set of words is another one in each run of Python
            sides = (
                (side, self._next(number, side, lengths.get(side)))
                for side in sorted(missing.sides)
            )
            more = {side: length for side, length in sides if length is not None}
            if not more:
                continue

            # from the fault as given, not from its last extension: dip lines are continued once
            lengths |= more
            try:
                surface = self._made(number, tuple(lengths.items()))
            except GeosurfError:  # its dip lines cross there: another remedy has to do
                continue
            place = missing.place if old is None else old.place
            extended[number] = Extended(self.given[number].name, lengths, place), surface
        return extended

    def _next(self, number: int, side: str, before: float | None) -> float | None:
        """By how much a fault is extended at a side next [m]; None if it cannot be longer."""
        # Along the dip in shares of the fault's height, along strike in cells.
        low, high = self.given[number].bounds[4:]
        least, most = LEAST * float(high - low), MOST * float(high - low)
        if side not in VERTICAL:
            least, most = LEAST_ALONG * self.cell, MOST_ALONG * self.cell
        length = least if before is None else 2.0 * before
        return length if length <= most else None


def rebuilt_of(data: Data, surfaces: Sequence[TriSurface], trims: Trims, highest: int) -> Rebuilt:
    """Heights of all nodes, once more where blocks at a fault without data were filled."""
    picks, other = data.picks, data.other
    meshes = [mesh_in_frame(surface, picks.frame) for surface in surfaces]

    def again(picks: Picks | Scattered) -> Rebuilt:
        return rebuild(
            solver_of(picks, meshes, trims, data.noise, data.carry, highest, data.cutoffs)
        )

    # blocks at a fault without data are known only once heights have shown which nodes stay empty
    filled: list[dict] = []
    rebuilt, pinched = again(picks), np.empty(0, dtype=np.int64)
    missing = missing_blocks(picks, rebuilt.state, meshes)
    # Once is enough: what is filled has data afterwards.
    if missing and data.carry:
        picks, filled = continued(picks, missing)
        rebuilt = again(picks)
        missing = missing_blocks(picks, rebuilt.state, meshes)
    while other is not None and (missing or len(rebuilt.state.stray)):
        # block by block: the one beyond the next fault shows once the first has heights
        more = nodes_to_stand_in(picks, rebuilt.state, missing, meshes, other)
        if not len(more):
            break
        pinched = distinct(pinched, more)
        picks = stood_in(picks, more, other)
        rebuilt = again(picks)
        missing = missing_blocks(picks, rebuilt.state, meshes)
    # Blocks that were neither filled nor pinched out are an error with their place.
    refuse_missing(picks, missing)
    return replace(rebuilt, filled=filled, pinched=pinched)


def built_of(
    rebuilt: Rebuilt,
    surfaces: Sequence[TriSurface],
    at_any_cost: bool = False,
    start: Repairs = NO_REPAIRS,
    needs_more: NeedsMore | None = None,
    is_solved: bool = False,
    most: int | None = None,
) -> Built:
    """The torn mesh, with ghosts on the sheets of their walls; see `build`."""
    picks = rebuilt.picks
    solver, weight = rebuilt.solver, rebuilt.solver.noise.weight
    # Points lie between nodes and share their heights; grids have a height at each node.
    if isinstance(picks, Scattered):
        known, order = ghosts_by_points(picks, weight), 3
    else:
        assert isinstance(solver, GridSolver)
        known, order = ghosts_by_picks(picks, weight, solver.grid.mark), solver.noise.order
    carry_on = carry_on_by(picks.frame, weight, known, order)
    # The diagonal rule of gridded horizons, so that a torn sheet equals its untorn part.
    with_data = solver.with_data if isinstance(solver, GridSolver) else None
    attempts = Attempts(picks, rebuilt.state, surfaces, picks.frame.rising, carry_on, with_data)
    again = solved_again(rebuilt)
    return build(attempts, rebuilt.state, again, at_any_cost, start, needs_more, is_solved, most)


def solved_again(rebuilt: Rebuilt) -> SolveAgain:
    """Gives heights in which throw dies where tears end early."""
    frame, meshes = rebuilt.picks.frame, rebuilt.solver.inputs.meshes

    def again(state: Heights, limits: np.ndarray, untorn: Sequence[Part]) -> Heights:
        """The second pass, torn between other places; see `with_last_links`."""
        return with_last_links(
            rebuilt.torn_between(state, limits, untorn), limits, meshes, frame.rising
        )

    return again


# ---- planned ----------------------------------------
# A sheet as a plan, and a plan as the start of a sheet of slightly other data.


RINGS = 3  # that ends of branches get: with fewer, most sheets of Drogon need another cut
AROUND = 5  # cells around them


def plan_of(closed: Closed, loss: float, searched: bool) -> TearPlan:
    """What closed a sheet."""
    rebuilt, built, repairs = closed.rebuilt, closed.built, closed.built.repairs
    rows, columns = closed.picks.frame.shape
    picks, nearby = rebuilt.picks, rebuilt.solver.inputs.nearby
    wrong = ~rebuilt.selection.single
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
            frozen(picks.z, np.float64),
        ),
        order=int(rebuilt.solver.noise.order),
        traces=traces_of(built.state.network),
        early=tuple((int(i), int(k), int(n)) for (i, k), n in sorted(repairs.shortened.items())),
        # sorted: sets have no order of their own
        rings=tuple(tuple((int(a), int(b)) for a, b in sorted(one)) for one in repairs.rings),
        level=tuple((float(x), float(y)) for x, y in repairs.level),
        left_out=tuple((int(i), float(a), float(b)) for i, a, b in repairs.untorn),
        loss=float(loss),
        searched=searched,
        base=None if rebuilt.filled or len(rebuilt.pinched) else base_heights(rebuilt),
        extensions=closed.extensions,
        polygons=tuple(rebuilt.solver.inputs.cutoffs),
    )


def close_again(
    data: Data, faults: Sequence[TriSurface], before: TearPlan, use: DataUse | None = None
) -> Closed | None:
    """The mesh at longer faults, with trims and repairs that closed it before; it may stay open.

    None if its traces are others. `use` is that of `Trims`.

    Raises
    ------
    GeometryError
        If a block has no data.
    """
    surfaces, trims = tuple(faults), Trims(before.trims, use)
    rebuilt = rebuilt_of(data, surfaces, trims, before.order)
    refuse_empty_blocks(rebuilt.picks, rebuilt.state, [surface.name for surface in surfaces])
    if traces_of(rebuilt.state.network) != before.traces:
        return None
    start = Repairs(
        {(i, k): n for i, k, n in before.early},
        tuple(frozenset(ring) for ring in before.rings),
        before.level,
        before.left_out,
    )
    built = built_of(rebuilt, surfaces, start=start)
    return Closed(rebuilt, built, surfaces, (), trims, Trims(before.given_trims), built.n_cut)


def close_as_planned(data: Data, faults: Sequence[TriSurface], plan: TearPlan) -> Closed | None:
    """Rebuild heights and tear the mesh with the trims and remedies of a plan; it may stay open.

    Where holes are left, attempts go on from there until one of them is stuck. None if the plan is
    of other data, or of other traces.

    Raises
    ------
    GeometryError
        If a block has no data.
    """
    if not fits(plan, data.picks, faults):
        return None
    surfaces, given = tuple(faults), Trims(plan.given_trims)
    trims = Trims(plan.trims, plan.use)

    def closed(rebuilt: Rebuilt, start: Repairs, is_solved: bool = False) -> Closed:
        """The mesh with the repairs of the plan, and those that go on from there."""
        # where the sheet of the plan lost throw, this one may: a search ends there, too
        at_any_cost = plan.loss > 0.0
        built = built_of(rebuilt, surfaces, at_any_cost, start, is_beyond, is_solved)
        return Closed(rebuilt, built, surfaces, (), trims, given, built.n_cut)

    def is_beyond(stuck: Sequence[Hole]) -> bool:
        """Whether holes that are stuck are no longer those at the ends of tears."""
        return any(hole.length > LARGE * data.picks.frame.cell for hole in stuck)

    # first with the walls of the plan, and traces on its heights
    if not data.carry and data.other is None:
        known = _on_base_heights(data, surfaces, plan, trims)
        if known is not None:
            found = closed(*known, is_solved=True)
            if not found.built.is_open:
                return found

    # then from these data alone
    rebuilt = rebuilt_of(data, surfaces, trims, plan.order)
    refuse_empty_blocks(rebuilt.picks, rebuilt.state, [surface.name for surface in surfaces])
    start = repairs_of(plan, rebuilt.state.network)
    return None if start is None else closed(rebuilt, start)


def _on_base_heights(
    data: Data, surfaces: Sequence[TriSurface], plan: TearPlan, trims: Trims
) -> tuple[Rebuilt, Repairs] | None:
    """Heights with the walls of a plan and throw that dies where its tears end, and its repairs.

    None if it has no heights, if traces are others, or a block has no data.
    """
    picks = data.picks
    meshes = [mesh_in_frame(surface, picks.frame) for surface in surfaces]
    solver = solver_of(picks, meshes, trims, data.noise, False, plan.order, data.cutoffs)
    known = on_base_heights(solver, plan)
    start = None if known is None else repairs_of(plan, known.state.network)
    if known is None or start is None:
        return None
    state = die_at_tips(known.state, start, picks.frame.rising, solved_again(known))
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
    the last link of each tip, and ends of branches get further rings, which lose no throw. A plan
    of a sheet that was made by one has these.
    """
    if traces_of(network) != plan.traces:
        return None
    ends = [(i, k) for i, (_, *two) in enumerate(plan.traces) for k in (0, 1) if two[k] == "tip"]
    return Repairs(
        dict.fromkeys(ends, 0) | {(i, k): n for i, k, n in plan.early},
        (*map(frozenset, plan.rings), *(_at_branches(network) if plan.searched else ())),
        plan.level,
        plan.left_out,
    )


def _at_branches(network: Network) -> list[frozenset[Pair]]:
    """Further rings of ghosts around the ends of branches, by nodes."""
    frame, places = network.frame, []
    for trace, limits in zip(network.traces, network.mesh, strict=True):
        for end, place in zip(trace.ends, limits, strict=True):
            if end.startswith("branch"):
                places.append(trace.at(place)[:2])
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
