"""A horizon and its faults -> a closed sheet: with trims as given, or with those that lose least.

Trims as given come first, without any loss of throw. If the sheet stays open, it may lose some; but
other trims may do without. What none of them closes is refused, with a remedy that was tried.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from geosurf.conventions import counted, place
from geosurf.errors import GeometryError, GeosurfError
from geosurf.model import FaultCut, TriSurface
from geosurf.model.tear_plan import TearPlan
from geosurf.sheets.faults.network import faults_in_words
from geosurf.sheets.heights.inputs import Trims
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.lattice.scattered import Scattered
from geosurf.sheets.mesh.close import Closed, Filling, close, close_at_any_cost
from geosurf.sheets.mesh.finish import lost_cutoffs, open_faults, remedy_of_overlap
from geosurf.sheets.mesh.planned import close_as_planned
from geosurf.sheets.mesh.tear_ends import lost_throw
from geosurf.sheets.report.describe import fault_cuts
from geosurf.sheets.report.propose_trim import shows_smear, trims_alike, trims_of

TRIM_CHANGES = (1.0, -0.5, 2.0)  # cells by which trims are changed where a sheet stays open
FORCED = 1  # other trims with which a sheet is closed at a loss, if it closes without them
MOST_CUTS = 150  # of the meshes of one horizon, after which no other trims are tried at a loss
SINGLE = 3  # open faults that are left out one by one for a remedy, before all of them are
EARLY = 1  # links by which a tear may end early before third differences are tried
WIDER = 0.5  # cells: measured trims count where they are wider than those given by this much


@dataclass(frozen=True, eq=False)
class Torn:
    """A sheet with its cut-offs.

    Attributes
    ----------
    closed : Closed
    cuts : dict of str to FaultCut
    bad : frozenset of int
        Numbers of the faults at which it is open, or that it does not reach; empty if it is closed.
    """

    closed: Closed
    cuts: dict[str, FaultCut]
    bad: frozenset[int]

    @classmethod
    def of(cls, closed: Closed) -> Torn:
        """The cut-offs of a mesh, and where it is open."""
        cuts = fault_cuts(closed.picks.frame, closed.built, closed.faults)
        bad = open_faults(closed.built) | lost_cutoffs(closed.built, cuts)
        return cls(closed, cuts, frozenset(bad))

    @property
    def loss(self) -> float:
        """Throw that is lost where it is not torn [m times cells]; infinite if it is open."""
        built = self.closed.built
        return np.inf if self.bad else lost_throw(built.state, built.repairs.untorn)

    @property
    def most_early(self) -> int:
        """The most links by which a tear ends earlier than its fault."""
        return max(self.closed.built.repairs.shortened.values(), default=0)


@dataclass(eq=False)
class Search:
    """Sheets of one horizon as they are tried.

    Attributes
    ----------
    close : callable
        Gives the sheet of some faults with some trims, without any loss; it may stay open.
    n_cut : int
        How often meshes were cut so far.
    """

    close: Callable[..., Torn]
    n_cut: int = 0

    def torn(self, faults: Sequence[TriSurface], used: Trims, **options: Any) -> Torn:
        """The sheet of some faults with some trims, without any loss; it may stay open."""
        return self._counted(self.close(faults, used, **options))

    def forced(self, one: Torn) -> Torn:
        """The same sheet, closed at a loss where it is open; it may stay open."""
        if not one.bad or one.closed.built.is_hopeless:
            return one
        return self._counted(Torn.of(close_at_any_cost(one.closed)))

    def _counted(self, one: Torn) -> Torn:
        self.n_cut += one.closed.n_cut
        return one


def torn_sheet(
    picks: Picks | Scattered,
    faults: Sequence[TriSurface],
    trims: Trims,
    noise: float | None,
    filling: Filling,
    asking: bool = False,
) -> Torn:
    """A closed mesh with cut-offs on all faults: with the trims as given, or those that lose least.

    Raises
    ------
    GeometryError
        If none of them does. The message has the faults, the place, and a remedy that works.
    TooShort
        If `asking`, where the first attempts need longer faults.
    """
    search = Search(partial(_torn, picks, noise=noise, filling=filling, given=trims))
    first = _first(search, faults, trims, asking)
    best = search.forced(first)
    if best.loss == 0.0:
        return best

    # other trims may do without a loss; if not, the smallest loss of all
    others: list[Torn] = []
    for used in _other_trims(trims, first.bad or best.bad, picks, faults):
        try:
            other = search.torn(faults, used)
        except GeometryError:  # a block has no data beyond them
            continue
        best = min(best, other, key=lambda one: one.loss)
        if best.loss == 0.0:
            return best
        if other.bad and not other.closed.built.is_hopeless:
            others.append(other)
    others.sort(key=lambda one: len(one.closed.built.cut.holes))
    for other in others[:FORCED]:
        best = min(best, search.forced(other), key=lambda one: one.loss)

    # for a sheet that would be refused: trims that the data show, then all others
    if best.bad:
        best = _as_data_show(best, trims, picks, faults, search)
    untried = 0
    for other in others[FORCED:]:
        if not best.bad:
            break
        if search.n_cut < MOST_CUTS:
            best = min(best, search.forced(other), key=lambda one: one.loss)
        else:
            untried += 1
    if best.bad:
        _refuse(best, faults, search, untried)
    return best


def torn_as_planned(
    picks: Picks | Scattered,
    faults: Sequence[TriSurface],
    plan: TearPlan,
    noise: float | None,
    filling: Filling,
) -> Torn | None:
    """The sheet with the trims and remedies of another one, if these close it; else None.

    None as well where it loses throw, and the sheet of the plan lost none.
    """
    try:
        closed = close_as_planned(picks, faults, plan, noise, filling)
    except GeosurfError:  # other trims may do: they are searched for
        return None
    found = None if closed is None or closed.built.is_open else Torn.of(closed)
    if found is None or found.bad or (found.loss > 0.0 and plan.loss == 0.0):
        return None
    return found


def _first(search: Search, faults: Sequence[TriSurface], trims: Trims, asking: bool) -> Torn:
    """The sheet with the trims as given; it may stay open.

    Exact data go on with the change of their curvature (fourth differences). That is kept only if
    it closes, and if no tear has to end earlier than with third differences.
    """
    found = search.torn(faults, trims, highest=4, asking=asking)
    is_fourth = found.closed.rebuilt.solver.noise.order == 4
    if not is_fourth or (found.loss == 0.0 and found.most_early <= EARLY):
        return found
    plain = search.torn(faults, trims)
    is_better = plain.loss == 0.0 and plain.most_early < found.most_early
    return plain if found.loss > 0.0 or is_better else found


def _torn(
    picks: Picks | Scattered,
    faults: Sequence[TriSurface],
    used: Trims,
    *,
    noise: float | None,
    filling: Filling,
    given: Trims,
    highest: int = 3,
    asking: bool = False,
) -> Torn:
    """The sheet with some faults and trims, without any loss of throw; it may stay open."""
    words: dict[str, Any] = {"highest": highest, "asking": asking}
    found = Torn.of(close(picks, faults, used, noise, filling, given, **words))
    if found.bad and not found.closed.built.is_open:  # a wall passes above or below its fault
        again = close(picks, faults, used, noise, filling, given, found.bad, **words)
        found = Torn.of(replace(again, n_cut=again.n_cut + found.closed.n_cut))
    return found


def _other_trims(
    trims: Trims, bad: frozenset[int], picks: Picks | Scattered, faults: Sequence[TriSurface]
) -> Iterator[Trims]:
    """Trims to try at some faults, by number: those that the data show, and others."""
    if shows_smear(picks):
        measured = trims_of("auto", picks, faults)
        wider = {
            k: trim
            for k, trim in enumerate(measured.of_fault)
            if k in bad and trim >= trims.of_fault[k] + WIDER
        }
        if wider:
            trims = trims.with_trims(wider.get(k, t) for k, t in enumerate(trims.of_fault))
            yield trims
    for change in TRIM_CHANGES:
        yield trims.changed(bad, change)


def _refuse(torn: Torn, faults: Sequence[TriSurface], search: Search, untried: int) -> None:
    """Refuse a sheet that stays open: where, by how much, and which fault to leave out.

    `untried` counts other trims that the limit of cuts left out.
    """
    closed, bad = torn.closed, sorted(torn.bad)
    built, picks, names = closed.built, closed.picks, [faults[k].name for k in bad]
    if built.cut.holes:
        worst = max(built.cut.holes, key=lambda hole: hole.length)
        at = worst.place
        n = len(built.cut.holes)
        what = (
            f"{counted(n, 'hole')} {'stays' if n == 1 else 'stay'} open, the largest "
            f"{worst.length:.0f} m long near {place(at)}"
        )
    else:
        stations = torn.cuts[names[0]].stations
        at = stations[len(stations) // 2]
        what = f"a wall does not reach the fault near {place(at)}"
    tried = f"other trims than {closed.given_trims.widest:g} cells of {picks.frame.cell:.3g} m"
    if untried:
        tried += f" (all but {untried}: a search ends after {MOST_CUTS} cuts)"
    remedy = remedy_of_overlap(picks, built) or _what_works(bad, faults, closed, search)
    raise GeometryError(
        f"horizon {picks.name!r} could not be cut at {faults_in_words(names)}: {what}. Longer "
        f"faults and {tried} were tried. {remedy}",
        place=at,
        surfaces=(picks.name, *names),
    )


def _as_data_show(
    open_sheet: Torn,
    trims: Trims,
    picks: Picks | Scattered,
    faults: Sequence[TriSurface],
    search: Search,
) -> Torn:
    """The sheet with the trims that the data show at all faults, if it closes; else as it was.

    They may be narrower than those given: a wide trim takes the data away between faults that meet
    at acute angles. Faults with little throw do not show how far the gridder smeared: all get the
    trim of those that do.
    """
    for shown in (trims_of("auto", picks, faults), trims_alike(picks, faults)):
        if shown is None or shown == trims:
            continue
        try:
            other = search.forced(search.torn(faults, shown))
        except GeometryError:  # a block has no data beyond them
            continue
        if not other.bad:
            return other
    return open_sheet


def _what_works(
    bad: Sequence[int],
    faults: Sequence[TriSurface],
    closed: Closed,
    search: Search,
) -> str:
    """Which faults to leave out so that the others close, as it was tried.

    Each open fault alone, then all of them, then those as well that are open without these. Each
    of the last steps leaves out more, and a horizon that nothing tears is closed.
    """
    trims = closed.given_trims.of_fault

    def still_open(gone: Collection[int]) -> set[int]:
        """Faults at which the sheet is open without some others."""
        rest = [k for k in range(len(faults)) if k not in gone]
        return _open_at(rest, faults, trims, search)

    single = next((k for k in bad[:SINGLE] if len(bad) > 1 and not still_open({k})), None)
    without = set(bad) if single is None else {single}
    while single is None and (more := still_open(without)):
        without |= more
    gone = sorted(without)
    words = faults_in_words([faults[k].name for k in gone])
    return (
        f"Without {words} the horizon closes, and bends there over "
        f"{_throw_at(closed, gone):.3g} m of throw: leave {'it' if len(gone) == 1 else 'them'} out."
    )


def _open_at(
    rest: Sequence[int],
    faults: Sequence[TriSurface],
    trims: Sequence[float],
    search: Search,
) -> set[int]:
    """Faults, of the `rest` that tears a sheet, at which it stays open; all if it has no sheet."""
    if not rest:
        return set()
    used = Trims(tuple(trims[k] for k in rest))
    try:
        other = search.forced(search.torn([faults[k] for k in rest], used, given=used))
    except GeosurfError:
        return set(rest)
    return {rest[k] for k in other.bad}


def _throw_at(closed: Closed, faults: Sequence[int]) -> float:
    """Largest throw of some faults, by number [m]."""
    state = closed.built.state
    throws = [
        np.abs(walls.throw).max(initial=0.0)
        for trace, walls in zip(state.network.traces, state.walls, strict=True)
        if trace.fault in faults
    ]
    return float(max(throws, default=0.0))
