"""Horizon data and faults -> a sheet that is torn at the faults: `tear_horizon`."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial, reduce
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.ndimage import distance_transform_edt

from geosurf.conventions import area_text, did_you_mean, is_number, place
from geosurf.conventions.running import running
from geosurf.errors import GeometryError, GeosurfError, GeosurfWarning, InputError, warn
from geosurf.model import FaultCut, Sheet, SheetReport, TriSurface
from geosurf.model.expected import flag_of
from geosurf.model.lattice import Lattice
from geosurf.model.sheets import DataUse, TearPlan
from geosurf.model.surfaces import cutoffs_among
from geosurf.sheets.faults.network import faults_in_words
from geosurf.sheets.faults.traces import FaultMesh, mesh_in_frame
from geosurf.sheets.heights.missing import StandIn, parts_of
from geosurf.sheets.heights.state import Trims, data_moved
from geosurf.sheets.heights.wrong_side import warning_of, without_wrong_picks
from geosurf.sheets.lattice.data import Scattered, read_data
from geosurf.sheets.lattice.picks import Picks, frame_of_lattice
from geosurf.sheets.mesh.close import (
    MOST_ROUNDS,
    Closed,
    Data,
    close,
    close_again,
    close_as_planned,
    close_at_any_cost,
    fits,
    plan_of,
)
from geosurf.sheets.mesh.finish import (
    check_crs,
    close_up,
    fault_surfaces,
    faults_at,
    largest_hole,
    lost_cutoffs,
    open_faults,
    remedy_of_overlap,
    sheet_of,
)
from geosurf.sheets.mesh.tear_ends import early_parts, lost_throw
from geosurf.sheets.report.describe import fault_cuts, make_report
from geosurf.sheets.report.propose_trim import by_wall, shows_smear, trims_of

TRIM_CHANGES = (1.0, -0.5, 2.0)  # cells by which trims are changed where a sheet stays open
FORCED = 1  # other trims with which a sheet is closed at a loss, if it closes without them
MOST_CUTS = 120  # of the meshes of one horizon, after which one that is open is refused
FEW = 16  # for each of the other trims, before it is closed at a loss
ENOUGH = 20  # after which one that is closed at a loss stays as it is
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
        early = early_parts(built.state, built.repairs.shortened, built.triangles.rising)
        return np.inf if self.bad else lost_throw(built.state, (*built.repairs.untorn, *early))

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
        trims = ", ".join(f"{trim:g}" for trim in sorted(set(used.of_fault)))
        with running(f"{len(faults)} faults, trim {trims}"):
            return self._counted(self.close(faults, used, **{"most": FEW, **options}))

    def forced(self, torn: Torn) -> Torn:
        """The same sheet, closed at a loss where it is open; it may stay open."""
        if not torn.bad or torn.closed.built.is_hopeless:
            return torn
        with running("at a loss"):
            return self._counted(Torn.of(close_at_any_cost(torn.closed)))

    def is_over(self, best: Torn) -> bool:
        """Whether no more is tried, after so many cuts."""
        return self.n_cut >= (MOST_CUTS if best.bad else ENOUGH)

    def _counted(self, one: Torn) -> Torn:
        self.n_cut += one.closed.n_cut
        return one


def torn_sheet(data: Data, faults: Sequence[TriSurface], trims: Trims) -> Torn:
    """A closed mesh with cut-offs on all faults: with the trims as given, or those that lose least.

    Raises
    ------
    GeometryError
        If none of them does. The message has the faults, the place, and a remedy that works.
    """
    search = Search(partial(_torn, data, given=trims))
    first = _first(search, faults, trims, FEW if data.cutoffs else MOST_ROUNDS)
    best = first if data.cutoffs else search.forced(first)
    # polygons may contradict the data: without those at the largest hole, at open faults, any
    for number in range(3):
        if best.bad and data.cutoffs:
            kept = sorted(data.cutoffs.keys() - _open_polygons(first, faults, data, number))
            data = replace(data, cutoffs={name: data.cutoffs[name] for name in kept})
            search = Search(partial(_torn, data, given=trims), search.n_cut)
            first = _first(search, faults, trims, FEW if kept else MOST_ROUNDS)
            best = search.forced(first) if number or not kept else first
    bad = first.bad or best.bad
    # other trims may do without a loss; if not, the smallest loss of all within the limit
    for other in _others(search, faults, trims, bad, data) if bad and best.loss > 0.0 else ():
        best = min(best, other, key=lambda one: one.loss)
        if best.loss == 0.0 or search.is_over(best):
            break
    if best.bad:
        _refuse(best, faults, search)
    return best


def _open_polygons(torn: Torn, faults: Sequence[TriSurface], data: Data, number: int) -> set[str]:
    """Faults with polygons: at the largest hole of a sheet; from 1 on where it is open; 2: all."""
    built = torn.closed.built
    worst = max(built.cut.holes, key=lambda hole: hole.length, default=None)
    near = torn.bad if worst is None else faults_at(worst, built)
    names = [{faults[k].name for k in bad} & data.cutoffs.keys() for bad in (near, torn.bad)]
    return next(filter(None, names[number:]), set(data.cutoffs))


def _others(
    search: Search, faults: Sequence[TriSurface], trims: Trims, bad: frozenset[int], data: Data
) -> Iterator[Torn]:
    """What is tried after the trims as given, the smallest change first; each when it is asked for.

    Other trims without a loss; the most promising of them at a loss; trims that the data show at
    all faults, which may be narrower than those given: a wide trim takes the data away between
    faults that meet at acute angles; at last all others at a loss.
    """
    others: list[Torn] = []
    for used in _other_trims(trims, bad, data, faults):
        with suppress(GeometryError):  # a block has no data beyond them
            others.append(search.torn(faults, used))
            yield others[-1]
    others = [one for one in others if one.bad and not one.closed.built.is_hopeless]
    others.sort(key=lambda one: len(one.closed.built.cut.holes))
    yield from map(search.forced, others[:FORCED])
    shown = trims_of("auto", data.picks, faults, data.cutoffs)
    if shows_smear(data.picks) and shown != trims:
        with suppress(GeometryError):
            yield search.forced(search.torn(faults, shown))
    yield from map(search.forced, others[FORCED:])


def torn_as_planned(
    data: Data, faults: Sequence[TriSurface], plan: TearPlan, close: Callable[..., Closed | None]
) -> Torn | None:
    """The sheet with the trims and remedies of another one, if these close it; else None.

    None as well where it loses throw, and the sheet of the plan lost none.
    """
    try:
        closed = close(data, faults, plan)
    except GeosurfError:  # other trims may do: they are searched for
        return None
    torn = None if closed is None or closed.built.is_open else Torn.of(closed)
    if torn is None or torn.bad or (torn.loss > 0.0 and plan.loss == 0.0):
        return None
    return torn


def _first(search: Search, faults: Sequence[TriSurface], trims: Trims, most: int) -> Torn:
    """The sheet with the trims as given; it may stay open.

    Exact data go on with the change of their curvature (fourth differences). That is kept only if
    it closes, and if no tear has to end earlier than with third differences.
    """
    fourth = search.torn(faults, trims, highest=4, most=most)
    is_fourth = fourth.closed.rebuilt.solver.noise.order == 4
    if not is_fourth or (fourth.loss == 0.0 and fourth.most_early <= EARLY):
        return fourth
    plain = search.torn(faults, trims, most=most)
    is_better = plain.loss == 0.0 and plain.most_early < fourth.most_early
    return plain if fourth.loss > 0.0 or is_better else fourth


def _torn(
    data: Data,
    faults: Sequence[TriSurface],
    used: Trims,
    *,
    given: Trims,
    highest: int = 3,
    most: int = MOST_ROUNDS,
) -> Torn:
    """The sheet with some faults and trims, without any loss of throw; it may stay open."""
    again = partial(close, data, faults, used, given, highest=highest, most=most)
    torn = Torn.of(again())
    if torn.bad and not torn.closed.built.is_open:  # a wall passes above or below its fault
        longer = again(known_short=torn.bad)
        torn = Torn.of(replace(longer, n_cut=longer.n_cut + torn.closed.n_cut))
    return torn


def _other_trims(
    trims: Trims, bad: frozenset[int], data: Data, faults: Sequence[TriSurface]
) -> Iterator[Trims]:
    """Trims to try at some faults, by number: those that the data show, and others."""
    if shows_smear(data.picks):
        measured = trims_of("auto", data.picks, faults, data.cutoffs)
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


def _refuse(torn: Torn, faults: Sequence[TriSurface], search: Search) -> None:
    """Refuse a sheet that stays open: where, by how much, and which fault to leave out."""
    closed, bad = torn.closed, sorted(torn.bad)
    built, picks = closed.built, closed.picks
    seen, names = None, [faults[k].name for k in bad]
    if built.cut.holes:
        worst, what = largest_hole(built)
        at = worst.place
        # through the hole the sheet may be open at other faults, too: they are not its cause
        near = sorted(faults_at(worst, built))
        bad, names = [*near, *(set(bad) - set(near))], [faults[k].name for k in near]
        seen = close_up(picks, built, closed.faults, worst)
    else:
        stations = torn.cuts[names[0]].stations
        at = stations[len(stations) // 2]
        what = f"a wall does not reach the fault near {place(at)}"
    tried = f"other trims than {closed.given_trims.widest:g} cells of {picks.frame.cell:.3g} m"
    if search.is_over(torn):
        tried += f" (until {MOST_CUTS} cuts)"
    remedy = remedy_of_overlap(picks, built) or _what_works(bad, faults, closed, search)
    raise GeometryError(
        f"horizon {picks.name!r} could not be cut at {faults_in_words(names)}: {what}. Longer "
        f"faults and {tried} were tried. {remedy}",
        place=at,
        surfaces=(picks.name, *names),
        close_up=seen,
    )


def _what_works(
    bad: Sequence[int], faults: Sequence[TriSurface], closed: Closed, search: Search
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
    rest: Sequence[int], faults: Sequence[TriSurface], trims: Sequence[float], search: Search
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


NEAR = 16  # cells: how far a block of one horizon may go beyond that of the other, at its faults


def pinched_out(sheet: Sheet, nodes: np.ndarray, data: np.ndarray, other: StandIn) -> Sheet:
    """
    Return a sheet that coincides with another one in blocks where it has no data.

    Parameters
    ----------
    sheet : Sheet
        Torn, with heights of the other one at `nodes`.
    nodes : ndarray of int64, shape (n,)
        Nodes of these blocks.
    data : ndarray of bool, shape (n_node,)
        Nodes with data of its own.
    other : StandIn

    Raises
    ------
    GeometryError
        If faults do not close these blocks off.
    """
    # Parts of the mesh by vertex; nodes without one have no part.
    number = sheet.lattice.vertex_of_node.ravel()
    part_of_vertex = parts_of(sheet.surface)
    part = np.where(number >= 0, part_of_vertex[np.maximum(number, 0)], -1)
    with_data = np.unique(part[data])
    # Parts without any data are exchanged as a whole.
    without_data = np.setdiff1d(part[nodes], with_data)
    theirs = np.unique(other.block[nodes])

    # next to faults that dip, a few of the nodes are on the side of the data at their own height
    open_ = nodes[np.isin(part[nodes], with_data)]
    _refuse_open(sheet, open_[_far_from(np.flatnonzero(data), sheet)[open_]])
    inside = np.flatnonzero(data & np.isin(other.block, theirs))
    _refuse_open(sheet, inside[_far_from(nodes, sheet)[inside]])
    nodes = nodes[np.isin(part[nodes], without_data)]

    # the rest of this sheet, and the part of the other one
    surface, second = sheet.surface, other.sheet.surface
    kept = surface.triangles[~np.isin(part_of_vertex, without_data)[surface.triangles[:, 0]]]
    added = second.triangles[np.isin(other.block_of_vertex, theirs)[second.triangles[:, 0]]]
    # Vertices of both meshes, those of the other one behind; nothing is welded, as faults lie
    # between.
    used = [np.unique(kept), np.unique(added)]
    corners = [np.searchsorted(used[0], kept), len(used[0]) + np.searchsorted(used[1], added)]
    vertices = np.concatenate([surface.vertices[used[0]], second.vertices[used[1]]])
    marks = {
        key: np.concatenate([surface.vertex_data[key][used[0]], second.vertex_data[key][used[1]]])
        for key in ("ghost", "outer")
    }
    # What comes from the other horizon counts as extrapolated, except for its ghosts.
    ghost = second.vertex_data["ghost"][used[1]]
    marks["extrapolated"] = np.concatenate([_marks(surface)[used[0]], ~ghost])
    triangles = np.concatenate(corners)
    mesh = TriSurface(sheet.name, "horizon", vertices, triangles, vertex_data=marks)
    mesh.crs = sheet.crs

    # the grid for maps and areas
    z = sheet.lattice.elevation.copy()
    # Maps and areas read the grid, so it has to agree with the mesh.
    z.ravel()[nodes] = other.heights[nodes]
    lattice = Lattice(sheet.lattice.easting, sheet.lattice.northing, z, sheet.lattice.rising)
    mark = np.zeros(z.shape, bool) if sheet.extrapolated is None else sheet.extrapolated.copy()
    mark.ravel()[nodes] = True
    report = sheet.report
    if isinstance(report, SheetReport):
        warning = _warning(sheet, nodes, other)
        report = replace(report, warnings=(*report.warnings, warning))
    return replace(sheet, lattice=lattice, extrapolated=mark, report=report, mesh=mesh)


def _marks(surface: TriSurface) -> np.ndarray:
    """Vertices that are marked as extrapolated; none if nothing is."""
    none = np.zeros(surface.n_vertex, dtype=bool)
    return surface.vertex_data.get("extrapolated", none)


def _far_from(nodes: np.ndarray, sheet: Sheet) -> np.ndarray:
    """Nodes farther than `NEAR` cells from some nodes, bool (n_node,)."""
    # A distance transform: one pass, however many nodes there are.
    away = np.ones(sheet.lattice.shape, dtype=bool)
    away.ravel()[nodes] = False
    return distance_transform_edt(away).ravel() > NEAR


def _refuse_open(sheet: Sheet, nodes: np.ndarray) -> None:
    """Raise an error if there are nodes where blocks with and without data are connected."""
    if len(nodes):
        frame, _ = frame_of_lattice(sheet.lattice, f"horizon {sheet.name!r}")
        at = frame.node_places(nodes[:1])[0]
        raise GeometryError(
            f"horizon {sheet.name!r} ends near {place(at)}, and no faults close the part without "
            "data off from the rest, so it cannot be pinched out there. Extend the faults until "
            "they cut through, or set fill_empty_blocks=True to continue the horizon.",
            place=(*at, float(np.nanmedian(sheet.lattice.elevation))),
            surfaces=(sheet.name,),
        )


def _warning(sheet: Sheet, nodes: np.ndarray, other: StandIn) -> GeosurfWarning:
    """How large the blocks are in which the horizon is pinched out."""
    frame, _ = frame_of_lattice(sheet.lattice, f"horizon {sheet.name!r}")
    # In cells times their area: near enough for a message.
    size = area_text(len(nodes) * float(np.prod(frame.spacing)))
    middle = frame.node_places(nodes).mean(axis=0)
    # A place on the horizon: the middle of a ring of blocks may be outside.
    nearest = nodes[np.hypot(*(frame.node_places(nodes) - middle).T).argmin()]
    at = frame.node_places(np.array([nearest]))[0]
    return GeosurfWarning(
        "pinched out",
        sheet.name,
        f"Horizon {sheet.name!r} has no data over {size}, beyond faults. It coincides with "
        f"{other.sheet.name!r} there, and the zone between the two is absent.",
        "Check it on the map, where it is hatched. fill_empty_blocks=True continues it from its "
        "neighbouring block instead.",
        (*at.tolist(), float(other.heights[nearest])),
    )


@running("tear horizon")
def tear_horizon(
    data: Any,
    faults: Mapping[str, Any] | Sequence[TriSurface],
    *,
    name: str | None = None,
    trim: float | str | Mapping[str, float] = "auto",
    noise: float | None = None,
    keep_outliers: bool = False,
    spacing: float | None = None,
    fill_empty_blocks: bool | Sheet = False,
    positive: str | None = None,
    length_unit: str | None = None,
) -> Sheet:
    """
    Tear a horizon at its faults, so that throw and juxtaposition there can be trusted.

    Gridding smears a horizon across its faults, so data near a fault are ignored. Each wall is
    rebuilt from data of its own side only, extended to the fault, and cut by it.

    Parameters
    ----------
    data : xarray.DataArray, xarray.Dataset, pandas.DataFrame or array_like (n, 3)
        A grid as for `triangulate_horizon`, or points: easting, northing, elevation. Points on a
        regular lattice, rotated or not, may share a node, one for each wall; others are scattered.
    faults : mapping of str to fault, or sequence of TriSurface
        Anything that `triangulate_fault` takes. They tear the horizon exactly as far as they reach.
    name : str, optional
        Default: the name of the data.
    trim : "auto", float or mapping of str to float
        Ignore data closer to a fault than this, measured at their own height [cells of the grid].
        ``"auto"`` estimates it from data that are held out (`propose_trim`), 2 to 9.5 cells, for
        all faults together and for one that shows another smear. A mapping sets it by fault, and
        the others are estimated.
    noise : float, optional
        Standard deviation of the data's noise [m]: data around faults are averaged. 0 also goes on
        to the faults from data as they are. Default: estimated for what is beyond the data; nodes
        with data in use keep these, but within 1.5 cells of a fault. Scattered points share cells
        and are averaged, which a warning states.
    keep_outliers : bool, default False
        Keep points that fit the other wall of a fault and contradict their neighbours on their own
        side. They are left out otherwise, with a warning that names them.
    spacing : float, optional
        Width of the lattice on which scattered points are solved for [m]. Default: points on a
        lattice keep theirs, scattered ones get one cell for each point.
    fill_empty_blocks : bool or Sheet
        True fills a block between faults that has no data from its neighbour across the fault with
        the smaller throw there; the report lists it. A sheet on the same grid, torn at the same
        faults: the horizon is pinched out there, and coincides with this one. Default: an error
        names the block.
    positive : {"up", "down"}, optional
        Whether values are elevation or depth. Default: ``attrs["positive"]`` of a grid, or of the
        elevations of a Dataset of points; arrays and tables without it need the argument.
    length_unit : str, optional
        As for `triangulate_horizon`; points are in metres by default.

    Returns
    -------
    Sheet
        With cut-offs, throw and heave for each fault, and a report that should be read.

    Raises
    ------
    HorizonError
        If the data cannot be used.
    InputError
        If data and faults have different coordinate reference systems.
    GeometryError
        If a block has no data, or its sheet does not end on the faults. Names the place.

    Warns
    -----
    GeosurfWarning
        If the data still show throw where a fault ends: kind ``"throw at tip"``. If points are left
        out: ``"wrong side"``. `Sheet.warnings` has the same.

    See Also
    --------
    rebuild_surfaces : takes the sheet's surface; `Scene` takes the sheet itself.

    Notes
    -----
    The surface minimises its third differences (``geosurf.kernels.sheets.smooth_surface``), is torn
    by virtual nodes (Molino, Bao & Fedkiw 2004), and cut exactly. See docs/guides/tearing.md.

    Examples
    --------
    >>> import numpy as np, geosurf as gs
    >>> world = gs.synthetic.torn("normal", n=41)
    >>> sheet = gs.tear_horizon(world.horizons["Top"], world.faults)
    >>> bool(55 < np.nanmax(sheet.cuts["F1"].throw) < 57)
    True
    >>> sheet.report.tips, sheet.report.declared_tips
    (2, 2)
    """
    return tear_from(
        None, data, faults, name=name, trim=trim, noise=noise, keep_outliers=keep_outliers,
        spacing=spacing, fill_empty_blocks=fill_empty_blocks, positive=positive,
        length_unit=length_unit,
    )  # fmt: skip


def tear_from(
    plan: TearPlan | None,
    data: Any,
    faults: Mapping[str, Any] | Sequence[TriSurface],
    *,
    name: str | None = None,
    trim: float | str | Mapping[str, float] = "auto",
    noise: float | None = None,
    keep_outliers: bool = False,
    spacing: float | None = None,
    fill_empty_blocks: bool | Sheet = False,
    positive: str | None = None,
    length_unit: str | None = None,
    before: TearPlan | None = None,
    like: Sequence[Sheet] = (),
    faults_moved: bool = False,
    given: Mapping[str, tuple[TriSurface, Mapping[str, float]]] = MappingProxyType({}),
) -> Sheet:
    """
    Tear a horizon first with what closed a sheet of slightly other data.

    Trims and remedies of the plan are used as they are. If they do not close the sheet, or not
    without losing more throw, it is torn as `tear_horizon` does.

    Parameters
    ----------
    plan : TearPlan or None
        `Sheet.plan` of a sheet on the same lattice, at faults of the same names.
    data, faults, name, trim, noise, keep_outliers, spacing, fill_empty_blocks, positive,
    length_unit
        As for `tear_horizon`.
    before : TearPlan, optional
        `Sheet.plan` of this horizon at shorter faults: its trims stay, and its remedies come first.
    like : sequence of Sheet, optional
        Of the horizons whose data were moved to make these: their trims stay, and what they ignored
        is ignored.
    faults_moved : bool
        Whether the faults have moved with the data, as from time to depth: none was passed.
    given : mapping of str to (TriSurface, mapping of str to float), optional
        Faults that are longer than they were given: as given, and by how much at each side [m].

    Returns
    -------
    Sheet
        ``plan.searched`` is False where the plan closed it.

    Raises
    ------
    GeosurfError
        As `tear_horizon`.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.torn("normal", n=41)
    >>> base = gs.tear_horizon(world.horizons["Top"], world.faults)
    >>> sheet = tear_from(base.plan, world.horizons["Top"] + 3.0, world.faults)
    >>> sheet.plan.searched, len(sheet.report.remedies)
    (False, 0)
    """
    if noise is not None and not (is_number(noise) and noise >= 0):
        raise InputError(f"noise is {noise!r}, expected metres, 0 or more.")
    if not isinstance(fill_empty_blocks, Sheet):
        flag_of(fill_empty_blocks, "fill_empty_blocks")
    flag_of(keep_outliers, "keep_outliers")

    # read horizon and faults
    surfaces = fault_surfaces(faults)
    _check_trim(trim, surfaces)
    read = read_data(data, name, positive, length_unit, spacing)
    picks, wrong = read.picks, list[dict[str, Any]]()
    meshes = [mesh_in_frame(surface, picks.frame) for surface in surfaces]
    if read.are_points and not keep_outliers:
        picks, wrong = without_wrong_picks(picks, meshes, like)
    check_crs(picks.name, read.crs, surfaces)

    # heights of all nodes, a torn mesh that the faults close, cut-offs and report
    cutoffs = by_wall(picks, meshes, cutoffs_among(surfaces, picks.name))
    horizon = replace(_data(picks, noise, fill_empty_blocks), cutoffs=cutoffs, given=given)
    torn, moved = None, _trims_like(like, faults_moved, picks, surfaces, meshes)
    plan_fits = plan is not None and fits(plan, picks, surfaces)
    known = plan if before is None else before
    if known is not None:  # polygons that were left out stay so
        used = {name: both for name, both in cutoffs.items() if name in known.polygons}
        as_known = replace(horizon, cutoffs=used)
        again = partial(close_again, use=None if moved is None else moved.use)
        how = close_as_planned if before is None else again
        torn = torn_as_planned(as_known, surfaces, known, how)
        horizon = as_known if before is not None or plan_fits else horizon
    searched = torn is None
    if torn is None:
        if before is not None:
            trims = Trims(before.given_trims, None if moved is None else moved.use)
        else:
            trims = moved or trims_of(trim, picks, surfaces, cutoffs)
        # data that were ignored are as little trusted now
        if plan is not None and plan_fits:
            trims = replace(trims, use=plan.use)
        torn = torn_sheet(horizon, surfaces, trims)
    closed, cuts = torn.closed, torn.cuts
    if before is not None:
        searched = before.searched
        extensions = {one.fault: one for one in (*before.extensions, *closed.extensions)}
        closed = replace(closed, extensions=tuple(extensions.values()))
    measured = closed.given_trims if plan is None else None
    if trim != "auto" and plan is None:
        measured = trims_of("auto", picks, surfaces, cutoffs)
    report = make_report(closed, cuts, measured)
    if wrong:
        told = warning_of(picks.name, wrong)
        report.notes.append(str(told))
        report = replace(report, left_out=wrong, warnings=(told, *report.warnings))
    sheet = sheet_of(closed.picks, closed.built, closed.faults, cuts, report)
    sheet = replace(
        sheet, crs=read.crs, extrapolated=read.extrapolated,
        plan=plan_of(closed, torn.loss, searched), fewer_nodes=read.fewer_nodes,
    )  # fmt: skip
    if horizon.other is not None and len(closed.rebuilt.pinched):
        present = np.isfinite(picks.means)
        sheet = pinched_out(sheet, closed.rebuilt.pinched, present, horizon.other)
    for warning in sheet.warnings:
        warn(warning)
    return sheet


def _data(picks: Picks | Scattered, noise: float | None, fill: bool | Sheet) -> Data:
    """Data of a horizon, and what becomes of blocks without any."""
    if not isinstance(fill, Sheet):
        return Data(picks, noise, carry=fill)
    if isinstance(picks, Scattered):
        raise InputError(
            f"horizon {picks.name!r} is given as scattered points, and only grids can be pinched "
            "out. Set fill_empty_blocks=True to continue it, or grid it first."
        )
    return Data(picks, noise, other=StandIn.of(fill, picks))


def _trims_like(
    like: Sequence[Sheet],
    faults_moved: bool,
    picks: Picks | Scattered,
    faults: Sequence[TriSurface],
    meshes: Sequence[FaultMesh],
) -> Trims | None:
    """Trims of sheets of as many data at the same faults, and what they made of their data."""
    names = [fault.name for fault in faults]
    plans = [
        sheet.plan
        for sheet in like
        if sheet.plan is not None
        and [fault.name for fault in sheet.faults] == names
        and fits(sheet.plan, picks, faults)
    ]
    if not plans or len(plans) < len(like):
        return None
    trims = np.max([plan.given_trims for plan in plans], axis=0)
    uses = [plan.use for plan in plans]
    if not faults_moved:
        uses = [data_moved(use, picks, meshes, float(trims.max())) for use in uses]
    return Trims(tuple(trims.tolist()), reduce(DataUse.joined, uses))


def _check_trim(trim: Any, faults: Sequence[TriSurface]) -> None:
    """Refuse a trim that is neither "auto" nor a number of cells, for all faults or by fault."""
    if isinstance(trim, Mapping) and trim:
        names = [fault.name for fault in faults]
        for name, value in trim.items():
            if name not in names:
                raise InputError(
                    f"trim names {name!r}, which is not a fault.{did_you_mean(str(name), names)} "
                    f"The faults are {', '.join(map(repr, names))}."
                )
            _check_trim(value, faults)
    elif not (isinstance(trim, str) and trim == "auto") and not (is_number(trim) and trim > 0):
        raise InputError(f'trim is {trim!r}, expected "auto", cells above 0, or {{fault: cells}}.')
