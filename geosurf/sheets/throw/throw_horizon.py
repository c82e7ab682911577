"""A continuous horizon and the throw of its faults -> a sheet that is torn there.

No datum is ignored and nothing is solved for: each wall is the horizon itself, moved along its
faults (`slip`, `displacement`), so that ghosts are known as well as nodes. Traces, tearing and the
exact cut are those of sheets as picked.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from geosurf.conventions import did_you_mean, is_word
from geosurf.conventions.running import running
from geosurf.errors import HorizonError, InputError
from geosurf.model import FaultCut, Lattice, Sheet, ThrowReport, TriSurface, frozen
from geosurf.sheets.faults import DIRECTIONS
from geosurf.sheets.faults.dip_lines import SPARE as FAULT_SPARE
from geosurf.sheets.faults.dip_lines import beyond
from geosurf.sheets.faults.fault_profile import Section, section_of
from geosurf.sheets.faults.given_throw import slips_of
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.lattice.data import has_fewer_nodes, picks_of
from geosurf.sheets.mesh.build import Built
from geosurf.sheets.mesh.finish import (
    crs_among,
    fault_surfaces,
    lost_cutoffs,
    refuse_lost_cutoffs,
    sheet_of,
)
from geosurf.sheets.report.cutoffs import longest
from geosurf.sheets.report.describe import count_tips, fault_cuts, no_cuts
from geosurf.sheets.throw.attempt import Attempt
from geosurf.sheets.throw.best_attempt import best_attempt
from geosurf.sheets.throw.measured_throw import down_dip, lost_at_tips
from geosurf.sheets.throw.movement import Movement, movement_of
from geosurf.sheets.throw.sectors import cutoffs_to_expect, sectors_of, too_coarse
from geosurf.sheets.throw.tear_ends import throw_at_early_ends

FAR = 1e-6  # cells outside of the data from which a particle is counted


@running("throw horizon")
def throw_horizon(
    horizon: Any,
    faults: Mapping[str, Any] | Sequence[TriSurface],
    throw: Mapping[str, Any],
    *,
    name: str | None = None,
    reach: float | Mapping[str, float] | None = None,
    hanging_wall: float | Mapping[str, float] = 1.0,
    direction: str | Mapping[str, str] = "local",
    positive: str | None = None,
    length_unit: str | None = None,
) -> Sheet:
    """
    Tear a horizon that is still continuous, by the throw of its faults.

    The hanging wall moves along each fault, also a curved or listric one, so that both cut-offs lie
    on it, one throw apart down its dip at each place.

    Parameters
    ----------
    horizon : xarray.DataArray or gridded TriSurface
        The horizon before it was faulted, as for `triangulate_horizon`.
    faults : mapping of str to fault, or sequence of TriSurface
        Anything that `triangulate_fault` takes, where they are today.
    throw : mapping of str to throw
        By fault, the youngest first; faults without an entry do not tear. Negative for reverse
        faults. Each is a number [m]; an array (n, 2) of distance along strike and throw, or a
        DataArray with coordinate ``along_strike``, linear between and constant beyond; a function
        of the distance; a DataArray over northing and easting; or an `EllipticThrow`.
        Distances count from the fault's first end by the right-hand rule, along its mean strike.
    name : str, optional
        Default: the name of the data.
    reach : float or mapping of str to float, optional
        Distance across strike over which the movement dies away from the fault [m], as its
        square: reverse drag. Default: never.
    hanging_wall : float or mapping of str to float
        Part of the throw that the hanging wall takes, 0 to 1; the footwall rises by the
        remainder. By fault; those without an entry have 1.
    direction : {"local", "mean"} or mapping of str to these
        Whether walls move down the dip that a fault has at each place, or all across its mean
        strike, as a block does that slides along the grooves of a corrugated fault; by fault, those
        left out are "local".
    positive, length_unit : str, optional
        As for `triangulate_horizon`.

    Returns
    -------
    Sheet
        With cut-offs, throw and heave for each fault, and a `ThrowReport`.

    Raises
    ------
    HorizonError, InputError
        If the data or a throw cannot be used, or reference systems differ.
    GeometryError
        If a fault turns back on itself, throw is left at a tip inside the horizon, beds would
        fold over, the sheet does not end on the faults, or two faults cross so that the piece
        between them is narrower than the cells. Names the place.

    See Also
    --------
    tear_horizon : for a horizon that was picked on both sides of its faults.

    Notes
    -----
    A fault that ends on another one acts on that side of it only, so that throws add up on the
    main fault beyond the contact. Where faults end on it from both sides, such as the halves of an
    older fault, each moves rock on its own side. Where faults cross, each is taken where it is
    today on both sides of the other: exact for planes. Where they cross closer to the horizon than
    their throws, a wedge between them has no horizon. See docs/guides/tearing.md.

    Examples
    --------
    >>> import numpy as np, geosurf as gs
    >>> world = gs.synthetic.graben(n=41)
    >>> sheet = gs.throw_horizon(world.horizons["Top"], world.faults, {"F1": 60.0, "F2": 40.0})
    >>> [bool(np.allclose(sheet.cuts[f].throw, t)) for f, t in (("F1", 60.0), ("F2", 40.0))]
    [True, True]
    """
    movement, crs = _movement(
        horizon, faults, throw, name, reach, hanging_wall, direction, positive, length_unit
    )
    return replace(_sheet(movement), crs=crs, fewer_nodes=has_fewer_nodes(horizon))


def _movement(
    horizon: Any,
    faults: Mapping[str, Any] | Sequence[TriSurface],
    throw: Mapping[str, Any],
    name: str | None,
    reach: float | Mapping[str, float] | None,
    hanging_wall: float | Mapping[str, float],
    direction: str | Mapping[str, str],
    positive: str | None,
    length_unit: str | None,
) -> tuple[Movement, str | None]:
    """How the faults move a horizon, and its coordinate reference system."""
    # the horizon before faulting: one value per node of a lattice
    surfaces = fault_surfaces(faults)
    picks = picks_of(horizon, name, positive, length_unit)
    if picks.several is not None:
        raise HorizonError(
            f"horizon {picks.name!r} has several values at one node, so that it is torn already. "
            "Give it as it was before faulting, or use tear_horizon."
        )
    crs = crs_among(picks.name, horizon, surfaces)
    frame = picks.frame
    _check_names(throw, reach, hanging_wall, direction, [surface.name for surface in surfaces])
    low, high = float(picks.z.min()), float(picks.z.max())
    most, sections = 0.0, dict[str, Section]()
    while True:  # the fault is read where its walls move, which depends on its throw
        # each round reads the faults over the throw that the last one found, until that covers it
        levels = beyond((low, high), frame.cell, most)
        before = sections
        sections = {
            s.name: section_of(s, frame.corner, 0.5 * frame.cell, levels)
            for s in surfaces
            if s.name in throw
        }
        if before and all(before[name] is one for name, one in sections.items()):
            break  # nothing that follows from them changes
        slips = slips_of(throw, sections, frame.corner, reach, hanging_wall)
        sizes = [slip.extremes(low, high) for slip in slips]
        largest = sum(throw for throw, _ in sizes)
        if largest <= max(most, FAULT_SPARE * frame.cell):
            break
        most = largest

    # faults and directions in the order of `throw`: the youngest first
    torn_by = {surface.name: surface for surface in surfaces}
    mine = [torn_by[slip.section.name] for slip in slips]
    across = dict.fromkeys(throw, direction) if isinstance(direction, str) else direction
    turning = [across.get(fault.name, "local") == "local" for fault in mine]
    return movement_of(picks, mine, slips, turning, sizes), crs


def _check_names(
    throw: Any, reach: Any, hanging_wall: Any, direction: Any, known: list[str]
) -> None:
    """Throw is given for faults that there are; the other words for some of these."""
    if not isinstance(throw, Mapping):
        raise InputError(
            f"throw is a {type(throw).__name__}; give a mapping {{fault: throw}}, as in "
            '{"F1": 60.0}.'
        )
    for key in throw:
        if key not in known:
            raise InputError(
                f"throw names {key!r}, which is not a fault. The faults are "
                f"{', '.join(map(repr, known))}.{did_you_mean(str(key), known)}"
            )
    options = {"reach": reach, "hanging_wall": hanging_wall, "direction": direction}
    for word, given in options.items():
        for key in given if isinstance(given, Mapping) else ():
            if key not in throw:
                raise InputError(
                    f"{word} names {key!r}, which has no throw. The faults with throw are "
                    f"{', '.join(map(repr, throw))}.{did_you_mean(str(key), throw)}"
                )
    for one in direction.values() if isinstance(direction, Mapping) else (direction,):
        if not is_word(one, DIRECTIONS):
            raise InputError(f"direction is {one!r}, expected one of {DIRECTIONS}.")


def _sheet(movement: Movement) -> Sheet:
    """Trace, move, tear and cut."""
    best, built = best_attempt(movement)
    if built is None:
        return _untorn(best)
    state, faults = built.state, movement.faults
    found = fault_cuts(movement.frame, built, faults)
    _refuse_lost_cutoffs(best, built, found)

    # throw as it was requested, between both cut-offs down the dip
    cuts, lost = {}, []
    for slip, largest in zip(movement.slips, movement.largest, strict=True):
        name = slip.section.name
        cuts[name], requested = down_dip(found[name], slip, movement.frame, longest(state))
        lost += lost_at_tips(cuts[name], requested, largest, movement.frame.cell)

    # what did not come out as requested
    shortened: dict[str, int] = {}
    for (trace, _), n in built.repairs.shortened.items():
        name = faults[state.network.traces[trace].fault].name
        shortened[name] = shortened.get(name, 0) + n
    early = throw_at_early_ends(movement, state.network, built.cuts, built.repairs.shortened)
    report = replace(
        _report(best, state, cuts),
        tips=count_tips(built),
        declared_tips=state.network.declared_tips,
        attempts=built.n_cut,
        shortened=shortened,
        lost=tuple(lost),
        notes=[*best.notes, *early, *map(str, lost)],
    )
    made = sheet_of(movement.picks, built, faults, cuts, report)
    return replace(made, sectors=sectors_of(best))


def _refuse_lost_cutoffs(best: Attempt, built: Built, cuts: Mapping[str, FaultCut]) -> None:
    """Refuse a sheet without a cut-off that it should have; other faults may cut one away."""
    names, lost = list(cuts), set()
    for fault in sorted(lost_cutoffs(built, cuts)):
        for wall, lines in cuts[names[fault]].cutoffs.items():
            if lines:
                continue
            missing = cutoffs_to_expect(best, fault, float(wall == "+"))
            if len(missing):
                error = too_coarse(best, fault, missing)
                if error is not None:
                    raise error
                lost.add(fault)
    refuse_lost_cutoffs(best.movement.picks, cuts, lost)


def _untorn(best: Attempt) -> Sheet:
    """The sheet where no fault has throw: the horizon itself."""
    movement, none = best.movement, np.empty(0)
    frame, values = movement.frame, best.state.values.reshape(movement.frame.shape)
    cuts = no_cuts(movement.faults)
    return Sheet(
        name=movement.picks.name,
        lattice=Lattice(frame.easting, frame.northing, values, movement.rising),
        divided=frozen(none, np.int64),
        copies=frozen(np.empty((0, 3)), np.int64),
        ghosts=frozen(np.empty((0, 3)), np.float64),
        outer=frozen(none, np.bool_),
        faults=tuple(movement.faults),
        cuts=cuts,
        report=_report(best, best.state, cuts),
    )


def _report(best: Attempt, state: Heights, cuts: Mapping[str, FaultCut]) -> ThrowReport:
    """What was requested and found, fault by fault, and where the horizon was extrapolated."""
    movement = best.movement

    # rock that came from outside the data, where the horizon is extrapolated [cells]
    outside = movement.before.outside(best.was[np.isfinite(state.values)])
    found = {}
    for name, largest in zip(cuts, movement.largest, strict=True):
        throw = cuts[name].throw
        most = np.abs(throw[np.isfinite(throw)]).max(initial=0.0)
        found[name] = {"requested": largest, "measured": float(most)}

    # main faults of each branch, by name
    branches = {
        fault.name: tuple(movement.faults[main].name for main in sorted(mains))
        for fault, mains in zip(movement.faults, best.branches.mains, strict=True)
        if mains
    }
    return ThrowReport(
        throw=found,
        branches=branches,
        n_outside=int((outside > FAR).sum()),
        farthest_outside=float(outside.max(initial=0.0)) * movement.frame.cell,
        notes=list(best.notes),
    )
