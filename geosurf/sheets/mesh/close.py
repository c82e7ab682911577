"""Data of one horizon and its faults -> a torn mesh that ends on them, by the smallest remedy.

First the faults are taken as they are. If a hole is next to the upper or lower rim of a fault, or
to the end of a branch, the fault is extended there, each time by twice as much, and the horizon is
torn again. What is still open after that can be closed at any cost (`geosurf.sheets.mesh.repairs`).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np

from geosurf.conventions import rising_diagonal
from geosurf.errors import GeosurfError
from geosurf.kernels.lattices.sets import distinct
from geosurf.model import TriSurface
from geosurf.model.sheets import Extended, NeededFaults
from geosurf.sheets.faults.cut_edges import Part
from geosurf.sheets.faults.traces import mesh_in_frame
from geosurf.sheets.heights.empty_blocks import refuse_empty_blocks
from geosurf.sheets.heights.grid_solver import GridSolver
from geosurf.sheets.heights.inputs import Trims
from geosurf.sheets.heights.missing import continued, missing_blocks, refuse_missing
from geosurf.sheets.heights.passes import Rebuilt, rebuild, solver_of
from geosurf.sheets.heights.stand_in import StandIn, nodes_to_stand_in, stood_in
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.lattice.scattered import Scattered
from geosurf.sheets.mesh.build import Built, NeedsMore, SolveAgain, build
from geosurf.sheets.mesh.carry_on import carry_on_by, ghosts_by_picks
from geosurf.sheets.mesh.holes import Hole
from geosurf.sheets.mesh.last_links import with_last_links
from geosurf.sheets.mesh.overlap_points import ghosts_by_points
from geosurf.sheets.mesh.repairs import NO_REPAIRS, Repairs
from geosurf.sheets.mesh.too_short import (
    VERTICAL,
    Short,
    TooShort,
    added_up,
    extended,
    too_short,
)

REACH = 4.0  # cells from the rim of a fault within which a hole is a matter of that
LEAST = 0.5  # of its height by which a fault is extended along its dip at first
MOST = 4.0  # and at most
LEAST_ALONG, MOST_ALONG = 3.0, 6.0  # cells by which a branch is extended along strike

Longer = dict[int, tuple[Extended, TriSurface]]  # by fault: the list entry and the surface
Make = Callable[[int, tuple[tuple[str, float], ...]], TriSurface]  # of a fault, longer by lengths


@dataclass(frozen=True, eq=False)
class Closed:
    """A torn mesh, and what it took to close it.

    Attributes
    ----------
    picks : Picks or Scattered
        With blocks that were filled.
    rebuilt : Rebuilt
    built : Built
        Open only if no remedy closes it.
    faults : tuple of TriSurface
        As given, or extended.
    extensions : tuple of Extended
    trims, given_trims : Trims
        In use, and as they were at first.
    filled : list of dict
        Blocks at faults without data that were filled.
    pinched : ndarray of int64, shape (n,)
        Nodes of blocks without data that have heights of another horizon.
    n_cut : int
        How often the mesh was cut in the last step: without a loss, or at any cost.
    """

    picks: Picks | Scattered
    rebuilt: Rebuilt
    built: Built
    faults: tuple[TriSurface, ...]
    extensions: tuple[Extended, ...]
    trims: Trims
    given_trims: Trims
    filled: list[dict]
    pinched: np.ndarray
    n_cut: int


@dataclass(frozen=True, eq=False)
class Filling:
    """What becomes of blocks without data: refused, continued, or as another horizon is there."""

    carry: bool = False
    other: StandIn | None = None


def close(
    picks: Picks | Scattered,
    faults: Sequence[TriSurface],
    trims: Trims,
    noise: float | None,
    filling: Filling,
    given_trims: Trims,
    known_short: Collection[int] = (),
    highest: int = 4,
    asking: bool = False,
) -> Closed:
    """Rebuild heights, tear the mesh, and close it without any loss of throw; it may stay open.

    `known_short` are numbers of faults that are extended up and down from the start; `highest` is
    the order of small differences at most. Who is `asking` is told which faults are too short
    instead.

    Raises
    ------
    GeometryError
        If a block has no data.
    TooShort
        If `asking`, where a fault would be extended.
    """
    # faults that are known to be short are extended before the first attempt
    given, found = tuple(faults), dict[int, Extended]()
    surfaces = given
    short = {k: Short(frozenset(VERTICAL), given[k].vertices.mean(axis=0)) for k in known_short}
    # once for each fault and length: attempts ask for the same ones again and again
    make = cache(lambda number, lengths: extended(given[number], dict(lengths)))
    more = _lengthened(given, short, found, picks.frame.cell, make)
    n_cut = 0
    first: Closed | None = None
    while True:
        if more and asking:
            raise TooShort(_as_needed(more, given, given_trims))
        # each round extends faults next to holes, twice as far as before; MOST ends it
        found |= {k: one for k, (one, _) in more.items()}
        surfaces = tuple(more[k][1] if k in more else one for k, one in enumerate(surfaces))
        filled_picks, rebuilt, filled, pinched = rebuilt_of(
            picks, surfaces, trims, noise, filling, highest
        )
        # A block that is empty only because its data were ignored near faults gets some of them
        # back.
        narrower = _narrower(trims, rebuilt.state)
        if narrower is not None:
            trims, more = narrower, {}
            continue
        # What is still empty now has no data at all.
        refuse_empty_blocks(filled_picks, rebuilt.state, [surface.name for surface in surfaces])
        ends = _branch_ends(rebuilt.state)
        # Which faults the holes ask for is tested during the attempts too, so that these end early.
        asked = partial(_longer, given, surfaces, ends, dict(found), picks.frame.cell, make)
        built = built_of(filled_picks, rebuilt, surfaces, needs_more=asked)
        n_cut += built.n_cut
        closed = Closed(
            filled_picks, rebuilt, built, surfaces, tuple(found.values()), trims, given_trims,
            filled, pinched, n_cut,
        )  # fmt: skip
        # so many holes are a matter of the data, not of a fault that is too short
        more = asked(built.cut.holes) if built.is_open and not built.is_hopeless else {}
        # Closed, or no fault can be extended any further.
        if not more:
            break
        first = first or closed
    # longer faults that have closed no hole stay as they were: other horizons would end on them
    if first is not None and built.is_open and _are_left(first.built, built, picks.frame.cell):
        closed = first
    return replace(closed, n_cut=n_cut)


def _are_left(before: Built, now: Built, cell: float) -> bool:
    """Whether a mesh has all holes of another one."""
    return all(any(one.is_like(old, cell) for one in now.cut.holes) for old in before.cut.holes)


def close_at_any_cost(closed: Closed) -> Closed:
    """Go on from a sheet that is open with remedies that change cut-offs; it may stay open."""
    # From the repairs that were found: they hold at any cost too.
    built = built_of(
        closed.picks, closed.rebuilt, closed.faults, at_any_cost=True, start=closed.built.repairs
    )
    return replace(closed, built=built, n_cut=built.n_cut)


def with_needed(closed: Closed, needed: NeededFaults | None) -> Closed:
    """The same with extensions that came before its faults were given."""
    if needed is None:
        return closed
    return replace(closed, extensions=added_up((*needed.extensions, *closed.extensions)))


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
    frame, found = state.network.frame, dict[int, list[np.ndarray]]()
    for trace in state.network.traces:
        # `start` and `stop` are places between vertices of the line.
        for end, place in zip(trace.ends, (trace.start, trace.stop), strict=True):
            if end.startswith("branch"):
                vertex = np.arange(len(trace.line))
                at = np.array([np.interp(place, vertex, trace.line[:, c]) for c in (0, 1)])
                found.setdefault(trace.fault, []).append(at / frame.stretch)
    return {fault: frame.to_world(np.array(places)) for fault, places in found.items()}


def _longer(
    given: Sequence[TriSurface],
    surfaces: Sequence[TriSurface],
    ends: Mapping[int, np.ndarray],
    before: Mapping[int, Extended],
    cell: float,
    make: Make,
    holes: Sequence[Hole],
) -> Longer:
    """Faults to extend because of some holes: `surfaces`, as they are now, end next to them."""
    return _lengthened(given, too_short(holes, surfaces, REACH * cell, ends), before, cell, make)


def _lengthened(
    given: Sequence[TriSurface],
    short: Mapping[int, Short],
    before: Mapping[int, Extended],
    cell: float,
    make: Make,
) -> Longer:
    """Faults that are too short, longer than before; none that cannot be."""
    found: Longer = {}
    for number, one in short.items():
        fault, old = given[number], before.get(number)
        lengths = {} if old is None else dict(old.lengths)
        # Twice as far as before at each side, until the most is reached.
        # in one order: that of a set of words is another one in each run of Python
        sides = (
            (side, _next_length(fault, side, lengths.get(side), cell)) for side in sorted(one.sides)
        )
        more = {side: length for side, length in sides if length is not None}
        if not more:
            continue

        # from the fault as given, not from its last extension: dip lines are continued once
        lengths |= more
        try:
            surface = make(number, tuple(lengths.items()))
        except GeosurfError:  # its dip lines cross there: another remedy has to do
            continue
        place = one.place if old is None else old.place
        found[number] = Extended(fault.name, lengths, place), surface
    return found


def _as_needed(more: Longer, given: Sequence[TriSurface], trims: Trims) -> NeededFaults:
    """Longer faults, and the trims of all, for those who know faults by their names."""
    faults = {one.fault: surface for one, surface in more.values()}
    by_name = {fault.name: trim for fault, trim in zip(given, trims.of_fault, strict=True)}
    return NeededFaults(tuple(one for one, _ in more.values()), faults, by_name)


def _next_length(fault: TriSurface, side: str, before: float | None, cell: float) -> float | None:
    """By how much a fault is extended at a side next [m]; None if it cannot be longer."""
    # Along the dip in shares of the fault's height, along strike in cells.
    height = float(fault.bounds[5] - fault.bounds[4])
    least, most = LEAST * height, MOST * height
    if side not in VERTICAL:
        least, most = LEAST_ALONG * cell, MOST_ALONG * cell
    length = least if before is None else 2.0 * before
    return length if length <= most else None


def rebuilt_of(
    picks: Picks | Scattered,
    surfaces: Sequence[TriSurface],
    trims: Trims,
    noise: float | None,
    filling: Filling,
    highest: int,
) -> tuple[Picks | Scattered, Rebuilt, list[dict], np.ndarray]:
    """Heights of all nodes, once more where blocks at a fault without data were filled.

    Returns the picks with those blocks, the heights, notes of the blocks, and the nodes that have
    heights of another horizon.
    """
    meshes = [mesh_in_frame(surface, picks.frame) for surface in surfaces]
    rebuilt = rebuild(solver_of(picks, meshes, trims, noise, filling.carry, highest))

    # blocks at a fault without data are known only once heights have shown which nodes stay empty
    missing = missing_blocks(picks, rebuilt.state, meshes)
    filled: list[dict] = []
    pinched = np.empty(0, dtype=np.int64)
    # Once is enough: what is filled has data afterwards.
    if missing and filling.carry:
        picks, filled = continued(picks, missing)
        rebuilt = rebuild(solver_of(picks, meshes, trims, noise, True, highest))
        missing = missing_blocks(picks, rebuilt.state, meshes)
    while filling.other is not None and (missing or len(rebuilt.state.stray)):
        # block by block: the one beyond the next fault shows once the first has heights
        more = nodes_to_stand_in(picks, rebuilt.state, missing, meshes, filling.other)
        if not len(more):
            break
        pinched = distinct(pinched, more)
        picks = stood_in(picks, more, filling.other)
        rebuilt = rebuild(solver_of(picks, meshes, trims, noise, False, highest))
        missing = missing_blocks(picks, rebuilt.state, meshes)
    # Blocks that were neither filled nor pinched out are an error with their place.
    refuse_missing(picks, missing)
    return picks, rebuilt, filled, pinched


def built_of(
    picks: Picks | Scattered,
    rebuilt: Rebuilt,
    surfaces: Sequence[TriSurface],
    at_any_cost: bool = False,
    start: Repairs = NO_REPAIRS,
    needs_more: NeedsMore | None = None,
    is_solved: bool = False,
) -> Built:
    """The torn mesh, with ghosts on the sheets of their walls; see `build`."""
    # The diagonal rule of gridded horizons, so that a torn sheet equals its untorn part.
    rising = rising_diagonal(picks.frame.easting, picks.frame.northing)
    solver, weight = rebuilt.solver, rebuilt.solver.noise.weight
    # Points lie between nodes and share their heights; grids have a height at each node.
    if isinstance(picks, Scattered):
        known, order = ghosts_by_points(picks, weight), 3
    else:
        assert isinstance(solver, GridSolver)
        known, order = ghosts_by_picks(picks, weight, solver.grid.mark), solver.noise.order
    carry_on = carry_on_by(picks.frame, weight, known, order)
    return build(
        picks, rebuilt.state, surfaces, rising, carry_on, solved_again(rebuilt, surfaces),
        at_any_cost, start, needs_more, is_solved,
    )  # fmt: skip


def solved_again(rebuilt: Rebuilt, surfaces: Sequence[TriSurface]) -> SolveAgain:
    """Gives heights in which throw dies where tears end early."""
    frame = rebuilt.solver.inputs.picks.frame
    meshes = [mesh_in_frame(surface, frame) for surface in surfaces]
    rising = rising_diagonal(frame.easting, frame.northing)

    def again(state: Heights, limits: np.ndarray, untorn: Sequence[Part]) -> Heights:
        """The second pass, torn between other places; see `with_last_links`."""
        return with_last_links(rebuilt.torn_between(state, limits, untorn), limits, meshes, rising)

    return again
