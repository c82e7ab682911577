"""A continuous horizon and the throw of its faults -> a sheet that is torn there.

No datum is ignored and nothing is solved for: each wall is the horizon itself, moved along its
faults (`slip`, `displacement`), so that ghosts are known as well as nodes. Traces, tearing and the
exact cut are those of sheets as picked.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations, product
from typing import Any

import numpy as np

from geosurf.conventions import check_word, did_you_mean, place
from geosurf.conventions.running import running
from geosurf.errors import GeometryError, HorizonError, InputError
from geosurf.model import FaultCut, Lattice, LostThrow, Sheet, ThrowReport, TriSurface, frozen
from geosurf.model.surfaces import Sector
from geosurf.sheets.faults import DIRECTIONS
from geosurf.sheets.faults.fault_profile import FAR_STEPS, Section, beyond, section_of
from geosurf.sheets.faults.fault_profile import SPARE as FAULT_SPARE
from geosurf.sheets.faults.slip import Slip, slips_of
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.lattice.data import read_data
from geosurf.sheets.lattice.picks import Frame
from geosurf.sheets.mesh.build import SPARE, Attempts, Built, build
from geosurf.sheets.mesh.finish import (
    check_crs,
    fault_surfaces,
    lost_cutoffs,
    refuse_leaks,
    refuse_lost_cutoffs,
    sheet_of,
)
from geosurf.sheets.report.describe import (
    count_tips,
    fault_cuts,
    longest,
    met,
    no_cuts,
    shortened_by_fault,
)
from geosurf.sheets.throw.attempt import Attempt, attempt, throw_at_early_ends
from geosurf.sheets.throw.displacement import Movement, movement_of

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
    # the horizon before faulting: one value per node of a lattice
    surfaces = fault_surfaces(faults)
    read = read_data(horizon, name, positive, length_unit, on_lattice=True)
    picks = read.picks
    if picks.several is not None:
        raise HorizonError(
            f"horizon {picks.name!r} has several values at one node, so that it is torn already. "
            "Give it as it was before faulting, or use tear_horizon."
        )
    check_crs(picks.name, read.crs, surfaces)
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
    ordered = [torn_by[slip.section.name] for slip in slips]
    across = dict.fromkeys(throw, direction) if isinstance(direction, str) else direction
    turning = [across.get(fault.name, "local") == "local" for fault in ordered]
    made = _sheet(movement_of(picks, ordered, slips, turning, sizes))
    return replace(made, crs=read.crs, fewer_nodes=read.fewer_nodes)


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
        check_word(one, DIRECTIONS, f"direction is {one!r}, expected one of {DIRECTIONS}.")


def _sheet(movement: Movement) -> Sheet:
    """Trace, move, tear and cut."""
    best, built = best_attempt(movement)
    if built is None:
        return _untorn(best)
    state, faults = built.state, movement.faults
    built_cuts = fault_cuts(movement.frame, built, faults)
    _refuse_lost_cutoffs(best, built, built_cuts)

    # throw as it was requested, between both cut-offs down the dip
    cuts, lost = {}, []
    for slip, largest in zip(movement.slips, movement.largest, strict=True):
        name = slip.section.name
        cuts[name], requested = down_dip(built_cuts[name], slip, movement.frame, longest(state))
        lost += lost_at_tips(cuts[name], requested, largest, movement.frame.cell)

    # what did not come out as requested
    early = throw_at_early_ends(movement, state.network, built.cuts, built.repairs.shortened)
    report = replace(
        _report(best, state, cuts),
        tips=count_tips(built),
        declared_tips=state.network.declared_tips,
        attempts=built.n_cut,
        shortened=shortened_by_fault(built, list(cuts)),
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
    throws = {}
    for name, largest in zip(cuts, movement.largest, strict=True):
        throw = cuts[name].throw
        most = np.abs(throw[np.isfinite(throw)]).max(initial=0.0)
        throws[name] = {"requested": largest, "measured": float(most)}

    # main faults of each branch, by name
    branches = {
        fault.name: tuple(movement.faults[main].name for main in sorted(mains))
        for fault, mains in zip(movement.faults, best.branches.mains, strict=True)
        if mains
    }
    return ThrowReport(
        throw=throws,
        branches=branches,
        n_outside=int((outside > FAR).sum()),
        farthest_outside=float(outside.max(initial=0.0)) * movement.frame.cell,
        notes=list(best.notes),
    )


LEANS = (0.5, 0.3, 0.7)  # shares of the movement at which traces are tried
SPARES = (1.0, 0.5, 1.5, 0.0)  # cells beyond an overlap that rings are tried to cover


def best_attempt(movement: Movement) -> tuple[Attempt, Built | None]:
    """The first mesh that closes without an early end, else the one that ends least early.

    Where traces run between both cut-offs, and how far rings reach beyond an overlap, is free;
    at a tip it decides on which side of the fault the last nodes are.

    Returns
    -------
    attempt : Attempt
        The one that the mesh was made from.
    built : Built or None
        The torn mesh; None where no fault has throw. It counts the cuts of all attempts.
    """
    n_cut = 0
    best: tuple[tuple[bool, int], Attempt, Built] | None = None
    branches = movement.first_branches()
    for lean in LEANS:
        tried = attempt(movement, lean, branches)
        branches = tried.branches  # the next one starts with what this one has found
        if not len(tried.state.cuts.node):
            return tried, None
        for state in _with_spare_rings(tried.state):
            attempts = Attempts(
                movement.picks, state, movement.faults, movement.rising, tried.ghosts,
                walls=tried.walls_by_name,
            )  # fmt: skip
            built = build(attempts, state, tried.end_at)
            n_cut += built.n_cut

            # a closed sheet beats an open one; among these, the one with the fewest links left
            # untorn
            failed = built.is_open, sum(built.repairs.shortened.values())
            if best is None or failed < best[0]:
                best = failed, tried, built
            if failed == (False, 0):
                return tried, replace(built, n_cut=n_cut)
    assert best is not None
    _, tried, built = best
    refuse_leaks(movement.picks, built, movement.faults)
    return tried, replace(built, n_cut=n_cut)


def _with_spare_rings(state: Heights) -> Iterator[Heights]:
    """The same heights with overlaps widened, so that rings of ghosts reach beyond them."""
    overlaps = any((np.minimum(w.left, w.right) < -SPARE).any() for w in state.walls)

    # only overlaps need rings: a gap has one attempt for each share of the movement
    for spare in SPARES if overlaps else SPARES[:1]:
        walls = [
            replace(w, left=_wider(w.left, spare), right=_wider(w.right, spare))
            for w in state.walls
        ]
        yield replace(state, walls=walls)


def _wider(gap: np.ndarray, spare: float) -> np.ndarray:
    """Overlaps (gaps below 0) made larger, the small ones near tips by no more than they are."""
    return np.where(gap < 0, gap - spare * np.minimum(-gap, 1.0), gap)


LOST = 0.02  # of the largest throw: less than this may be missing next to a tip without a report
BESIDE = 2.0  # cells from a tip within which it is looked for
DYING = 1.5  # throw that dies at a tip is lost on a lattice as this power of its cell


def down_dip(cut: FaultCut, slip: Slip, frame: Frame, reach: float) -> tuple[FaultCut, np.ndarray]:
    """Throw and heave along the lines down the dip of a fault; and the requested throw (n,).

    `reach` is how far cut-offs may be from their stations [cells]. Requested is what the rock had
    to move by that is the footwall cut-off now; NaN where none is.
    """
    section, n = slip.section, len(cut.stations)
    if n == 0:
        return cut, np.empty(0)

    # a line down the dip is named by its s at this level, so that cut-offs of one line match
    level = float(cut.stations[:, 2].mean())

    def named(points: np.ndarray) -> np.ndarray:
        """Where the lines through points (n, 3) are at one level; across strike; elevation."""
        s, r = section.of(points[:, :2] - frame.corner)
        z = points[:, 2]
        at = slip.along(s, z, np.full(len(z), level), FAR_STEPS)
        return np.column_stack([at, r, z])

    # where the line of each station meets both cut-offs: s and r along strike and across, z
    stations = named(cut.stations)
    across = np.broadcast_to([0.0, 1.0], (n, 2))
    by_wall = {}
    for wall, lines in cut.cutoffs.items():
        t, z = met(stations[:, :2], across, [named(line) for line in lines], reach * frame.cell)
        known = np.isfinite(z)
        s = np.full(n, np.nan)
        s[known] = slip.along(stations[known, 0], np.full(known.sum(), level), z[known], FAR_STEPS)
        by_wall[wall] = np.column_stack([s, t, z])

    # heave is the gap in the map, negative where walls overlap; throw is positive down
    plus, minus = by_wall["+"], by_wall["-"]
    gap = plus - minus
    heave = np.copysign(np.hypot(gap[:, 0], gap[:, 1]), gap[:, 1])
    throw = -gap[:, 2]
    known = np.isfinite(throw)

    # the requested throw belongs to the rock that is the footwall cut-off now
    z = (minus[:, 2] - (1.0 - slip.share) * throw)[known]  # before the footwall rose
    s = slip.along(stations[known, 0], np.full(len(z), level), z, FAR_STEPS)
    requested = np.full(n, np.nan)
    rock = section.places(s, section.across(s, z))
    requested[known] = slip.amount(np.clip(s, 0.0, section.length), z, rock)
    return replace(cut, throw=throw, heave=heave), requested


def lost_at_tips(
    cut: FaultCut, requested: np.ndarray, largest: float, cell: float
) -> list[LostThrow]:
    """Places next to tips where more of the requested throw is missing than may go unreported.

    Throw that dies at a tip as its distance to the power of 3/2 is read from nodes of a lattice:
    what is lost is largest next to the tip, and falls as the cell to that power.
    """
    if len(cut.along) == 0:
        return []  # this fault tears nothing, while others do
    losses = []

    # `along` starts at 0 for each trace: stations between two zeros are one trace
    first = np.flatnonzero(cut.along == 0.0)
    for k, rows in enumerate(np.split(np.arange(len(cut.along)), first[1:])):
        for end, at in zip(cut.ends[2 * k : 2 * k + 2], (rows[0], rows[-1]), strict=True):
            if end != "tip":
                continue
            near = rows[np.abs(cut.along[rows] - cut.along[at]) <= BESIDE * cell]

            # what is missing of the throw, in its direction: more than requested is below 0
            lost = np.copysign(1.0, requested[near]) * (requested[near] - cut.throw[near])

            # stations without a cut-off count as no loss
            lost = np.where(np.isfinite(lost), lost, 0.0)
            worst = int(near[lost.argmax()])
            if lost.max() > LOST * largest:
                # the loss falls as cell**DYING: the cell at which it would be as small as LOST
                finer = cell * (LOST * largest / float(lost.max())) ** (1.0 / DYING)
                where = tuple(cut.stations[worst].tolist())
                amounts = float(requested[worst]), float(cut.throw[worst])
                losses.append(LostThrow(cut.fault, where, *amounts, cell, finer))
    return losses


LEVELS = 65  # elevations at which faults are looked at, over what the horizon can reach
STATIONS = 513  # places along strike, at most


def cutoffs_to_expect(best: Attempt, fault: int, wall: float) -> np.ndarray:
    """Places (n, 3), from the corner, where the horizon ends on a fault from one wall, 1 hanging.

    Walls of all other faults are those of the place: what these cut away does not count.
    """
    movement = best.movement
    xyz, shape = _on_fault(movement, fault)
    walls = movement.in_hanging_walls(xyz[:, :2], xyz[:, 2])
    walls[fault] = wall
    heights, _ = movement.heights(best.branches, xyz[:, :2], walls)
    above = (xyz[:, 2] - heights).reshape(shape)
    other = walls.reshape(-1, *shape)

    # between two levels of the same walls the fault goes through the horizon
    same = (other[:, :, 1:] == other[:, :, :-1]).all(axis=0)
    with np.errstate(invalid="ignore"):
        through = above[:, 1:] * above[:, :-1] <= 0.0
    row, at = np.nonzero(same & through)
    return xyz.reshape(*shape, 3)[row, at]


def too_coarse(best: Attempt, fault: int, places: np.ndarray) -> GeometryError | None:
    """The error where a wedge at a fault is narrower than a cell; None where none is so narrow.

    `places` (n, 3) are on the fault: cut-offs that the sheet should have.
    """
    movement = best.movement
    cell, name, horizon = movement.frame.cell, movement.faults[fault].name, movement.picks.name
    narrowest: tuple[float, int, int] | None = None
    for k in range(len(movement.slips)):
        far = np.abs(movement.distance(k, places[:, :2], places[:, 2]))
        if k != fault and best.branches.acts[k] and far.max() < cell:
            at = int(far.argmax())
            narrowest = min(narrowest or (np.inf, 0, 0), (float(far[at]), k, at))
    if narrowest is None:
        return None
    width, other, at = narrowest
    where = places[at] + np.append(movement.frame.corner, 0.0)
    names = name, movement.faults[other].name
    return GeometryError(
        f"horizon {horizon!r} is {width:.3g} m wide between faults {names[0]!r} and {names[1]!r} "
        f"at {place(where)}, and cells of {cell:.3g} m have no node there. Give the horizon on "
        f"cells of {0.9 * width:.2g} m, as from its .interp(easting=..., northing=...), or move a "
        "fault.",
        place=where,
        surfaces=(horizon, *names),
    )


def sectors_of(best: Attempt) -> tuple[Sector, ...]:
    """The wedges between faults that cross so close to the horizon that one may be without it."""
    movement, frame = best.movement, best.movement.frame
    sectors = []
    for pair in combinations(range(len(movement.slips)), 2):
        if not all(best.branches.acts[k] for k in pair) or not _is_close(best, *pair):
            continue
        unclear = _beside_others(movement, pair)
        for first, second in product((True, False), repeat=2):
            walls = best.walls.copy()
            walls[pair[0]], walls[pair[1]] = float(first), float(second)
            heights, _ = movement.heights(best.branches, movement.xy, walls)
            heights[unclear] = np.nan
            sectors.append(
                Sector(
                    faults=(movement.faults[pair[0]].name, movement.faults[pair[1]].name),
                    front=(first, second),
                    corner=frozen(frame.corner, np.float64),
                    step=frozen(frame.step, np.float64),
                    elevation=frozen(heights.reshape(frame.shape), np.float64),
                    rising=movement.rising,
                )
            )
    return tuple(sectors)


def _reach(movement: Movement) -> tuple[float, float]:
    """Lowest and highest elevation that the horizon can have [m]."""
    most = sum(movement.largest) + movement.frame.cell
    return float(movement.picks.z.min()) - most, float(movement.picks.z.max()) + most


def _on_fault(movement: Movement, fault: int) -> tuple[np.ndarray, tuple[int, int]]:
    """Places (n, 3) on a fault, from the corner, as stations (rows) and levels (columns)."""
    section = movement.slips[fault].section
    low, high = _reach(movement)
    low, high = max(low, float(section.z[0])), min(high, float(section.z[1]))
    n = int(np.clip(np.ceil(section.length / movement.frame.cell) + 1, 2, STATIONS))
    shape = (n, LEVELS)
    s, z = (
        part.ravel()
        for part in np.meshgrid(
            np.linspace(0.0, section.length, n), np.linspace(low, high, LEVELS), indexing="ij"
        )
    )
    return np.column_stack([section.places(s, section.across(s, z)), z]), shape


def _is_close(best: Attempt, first: int, second: int) -> bool:
    """Whether two faults cross within a cell of the horizon in one wedge, or between two wedges."""
    movement = best.movement
    xyz, shape = _on_fault(movement, first)
    section = movement.slips[second].section
    s, _ = section.of(xyz[:, :2])
    inside = (s >= 0.0) & (s <= section.length)
    inside &= (xyz[:, 2] >= section.z[0]) & (xyz[:, 2] <= section.z[1])
    far = np.where(inside, movement.distance(second, xyz[:, :2], xyz[:, 2]), np.nan).reshape(shape)

    # along each line down the fault: where it passes from one wall of the other to the next
    with np.errstate(invalid="ignore"):
        row, at = np.nonzero(far[:, 1:] * far[:, :-1] <= 0.0)
    if len(row) == 0:
        return False
    a, b = np.abs(far[row, at]), np.abs(far[row, at + 1])
    share = np.divide(a, a + b, out=np.full_like(a, 0.5), where=a + b > 0)[:, None]
    grid = xyz.reshape(*shape, 3)
    crossing = grid[row, at] + share * (grid[row, at + 1] - grid[row, at])

    # the horizon in all four wedges there
    walls = movement.in_hanging_walls(crossing[:, :2], crossing[:, 2])
    above = []  # by how much [m]
    for front in product((1.0, 0.0), repeat=2):
        walls[first], walls[second] = front
        heights, _ = movement.heights(best.branches, crossing[:, :2], walls)
        above.append(heights - crossing[:, 2])

    # within a cell: a piece that is narrower may have no node, and be missing as well
    cell = movement.frame.cell
    return bool(((np.max(above, axis=0) > -cell) & (np.min(above, axis=0) < cell)).any())


def _beside_others(movement: Movement, pair: tuple[int, int]) -> np.ndarray:
    """Nodes (n,) over or under which another fault passes: there its wall depends on the depth."""
    unclear = np.zeros(len(movement.xy), dtype=bool)
    for k, slip in enumerate(movement.slips):
        if k in pair:
            continue
        levels = np.linspace(slip.section.z[0], slip.section.z[1], 17)
        sides = [
            movement.distance(k, movement.xy, np.full(len(movement.xy), z)) > 0.0 for z in levels
        ]
        unclear |= np.any(sides, axis=0) & ~np.all(sides, axis=0)
    return unclear
