"""Horizons of a scene, torn at its faults as these are after extension and truncation.

Faults come first. A sheet may need a longer fault than was given (see `tear_horizon`); all
horizons end on the longer one (`geosurf.scene.tearing`).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from hashlib import sha256
from types import MappingProxyType
from typing import Any

import numpy as np

from geosurf.conventions import grouped, known_names
from geosurf.conventions.axes import vertical_axis
from geosurf.conventions.checks import are_points
from geosurf.conventions.crs import crs_of
from geosurf.errors import GeosurfError, GeosurfWarning, InvariantError, collected
from geosurf.faults.rules import Rule
from geosurf.model import Sheet, TriSurface
from geosurf.model.expected import outline_of
from geosurf.model.network import in_order
from geosurf.model.sheets import TearPlan
from geosurf.model.surfaces import CUTOFF
from geosurf.model.tears import FaultThrow
from geosurf.scene.faults import LongerFaults
from geosurf.scene.graph import Graph
from geosurf.scene.input_checks import in_time, warnings_of_sheet
from geosurf.scene.inputs import undeclared
from geosurf.scene.memory import Memory, OnStart, silent
from geosurf.scene.surfaces import opened_horizon
from geosurf.scene.zones import warnings_of_throw
from geosurf.triangulate import triangulate_horizon

# ---- tear rounds ----------------------------------------
# Horizons that are torn until all of them end on the same faults, in as few tears as possible.
#
# A tear may need a longer fault. The outermost horizons come first, one after the other, then all
# others. Those that came before a fault became longer near them are torn again, with what closed
# them then. Each horizon takes its faults without what others have added far away from it.


ROUNDS = 16  # each makes a fault longer, which a horizon does at most four times at each side
OUTERMOST = 2  # horizons that say how long faults have to be: the highest and the lowest

Faults = dict[str, TriSurface]


@dataclass(frozen=True, eq=False)
class Tear:
    """What one tear is made of.

    Attributes
    ----------
    name : str
        The horizon.
    faults : dict of str to TriSurface
    fill : bool or Sheet
        What becomes of blocks without data; a sheet: the horizon is pinched out onto it.
    before : TearPlan or None
        What closed it at shorter faults.
    like : tuple of Sheet
        Of the horizons whose data were moved to make its own.
    faults_moved : bool
        Whether faults were moved with these data, as from time to depth.
    given : dict of str to (TriSurface, dict of str to float)
        Faults that other tears have made longer, as they were given, and by how much [m]: what is
        still missing is added to that, so that no order of tears makes a difference.

    See Also
    --------
    geosurf.sheets.tear.tear_from : takes the last one.
    """

    name: str
    faults: Faults
    fill: bool | Sheet
    before: TearPlan | None = None
    like: tuple[Sheet, ...] = ()
    faults_moved: bool = False
    given: Mapping[str, tuple[TriSurface, Mapping[str, float]]] = field(default_factory=dict)

    @property
    def key(self) -> tuple[Hashable, ...]:
        """What it takes from other tears, as part of a key of results."""
        moved = [repr((name, sorted(by.items()))) for name, (_, by) in sorted(self.given.items())]
        for sheet in self.like:
            if sheet.plan is not None:
                use, names = sheet.plan.use, [fault.name for fault in sheet.faults]
                arrays = (use.ignored, use.wrong, use.elevation, *use.near, *use.side)
                data = b"".join(a.tobytes() for a in arrays)
                moved += [repr((sheet.plan.given_trims, names)), sha256(data).hexdigest()]
        plan = self.before
        if plan is None:
            return tuple(moved)
        lengths = [(x.fault, *sorted(x.lengths.items())) for x in plan.extensions]
        tears = (plan.traces, plan.early, plan.rings, plan.level, plan.left_out, plan.loss)
        return (repr((plan.trims, plan.given_trims, plan.order, *tears, lengths)), *moved)

    def sheet(
        self,
        data: Any,
        faults: Sequence[TriSurface],
        plan: TearPlan | None,
        tops: Any,
        tie: Any,
        **words: Any,
    ) -> Sheet:
        """Return the sheet of some data at some faults, tied to its tops; `words` of the tear."""
        from geosurf.sheets.tear import tear_from  # loaded by those who tear
        from geosurf.sheets.tie import tied_sheet

        words |= {"name": self.name, "fill_empty_blocks": self.fill}
        words |= {"before": self.before, "like": self.like, "given": self.given}
        words["faults_moved"] = self.faults_moved

        def torn(some: Any) -> Sheet:
            """A sheet of these data."""
            return tear_from(plan, some, faults, **words)

        return tied_sheet(self.name, data, torn, faults, tops, tie)


Make = Callable[[Tear], Sheet]


@dataclass(frozen=True, eq=False)
class _Torn:
    """A sheet, the faults that it ends on, and the sheet that it was pinched out onto."""

    sheet: Sheet
    faults: Faults
    fill: bool | Sheet


def sheets_on(
    faults: Faults,
    filling: Mapping[str, bool | str],
    make: Make,
    untorn: Callable[[str], TriSurface],
    on_start: OnStart = silent,
    made_of: Mapping[str, Sequence[str]] = MappingProxyType({}),
) -> tuple[dict[str, Sheet], Faults]:
    """Return sheets that all end on the same faults, and these: longer ones where one needs it.

    Parameters
    ----------
    faults : dict of str to TriSurface
    filling : mapping of str to bool or str
        Horizons, and what becomes of blocks without data: see `filling_by_horizon`.
    make : callable
        Makes a tear. Warnings of a sheet are its own.
    untorn : callable
        Gives a horizon as it is before it is torn.
    on_start : callable, optional
        Is called before each tear: see `OnStart`.
    made_of : mapping of str to sequence of str, optional
        Horizons whose data are those of others, moved: they are torn like these, and after them.
    """
    order = in_order(_outermost_first(filling))
    torn: dict[str, _Torn] = {}
    lengths = _Lengths(faults)
    n_torn = 0
    for _ in range(ROUNDS + len(order)):
        faults = lengths.now
        again = [name for name in order if not _is_valid(torn, name, filling[name], faults)]
        if not again:
            return {name: _ending_on(torn[name], faults) for name in filling}, faults

        # those that are pinched out onto a sheet, or made of one, wait for it; outermost ones show
        # how long faults have to be, before others are torn in vain
        ready = [name for name in again if filling[name] not in again]
        models = {name: made_of.get(name, ()) for name in order}
        ready = [name for name in ready if not {*models[name]} & {*again}] or ready
        first = [name for name in ready if name in order[:OUTERMOST] and name not in torn]
        tears = []
        for name in first[:1] or ready:
            known = torn.get(name)
            faults_near = lengths.near(name, untorn) if known is None else faults
            before = None if known is None else known.sheet.plan
            like = tuple(torn[of].sheet for of in models[name] if of in torn)
            given = lengths.given(faults_near)
            tears.append(
                Tear(name, faults_near, _fill(torn, filling[name]), before, like, given=given)
            )
        count = n_torn + len(again)
        for tear in tears:
            n_torn += 1
            on_start("tear", tear.name, n_torn, count)
            with collected():
                sheet = make(tear)
            torn[tear.name] = _Torn(sheet, _as_needed(tear.faults, sheet), tear.fill)
            lengths.add(tear, torn[tear.name])
    raise InvariantError(f"horizons {again} were torn {ROUNDS} times, each time at longer faults.")


class _Lengths:
    """Faults, each as it was given and as it became longer."""

    def __init__(self, faults: Faults) -> None:
        self.now = faults
        self._known = {name: [fault] for name, fault in faults.items()}
        self._by: dict[str, list[Mapping[str, float]]] = {name: [{}] for name in faults}

    def given(self, faults: Faults) -> dict[str, tuple[TriSurface, Mapping[str, float]]]:
        """Faults that are longer than they were given: as given, and by how much [m]."""
        longer = {}
        for name, fault in faults.items():
            known = self._known[name]
            number = next(k for k, one in enumerate(known) if one is fault)
            if self._by[name][number]:
                longer[name] = known[0], self._by[name][number]
        return longer

    def add(self, tear: Tear, torn: _Torn) -> None:
        """Take the faults that a tear has made longer."""
        from geosurf.sheets.mesh.tear_ends import extended  # loaded by those who tear

        plan = torn.sheet.plan
        lengths = {} if plan is None else {one.fault: one.lengths for one in plan.extensions}
        for name, fault in torn.faults.items():
            if fault is tear.faults[name]:
                continue
            by = dict(lengths.get(name, {}))
            # of two tears that make one longer each has what both need, or is torn again
            if self.now[name] is not tear.faults[name]:
                for side, length in self._by[name][-1].items():
                    by[side] = max(by.get(side, 0.0), length)
                try:
                    fault = extended(self._known[name][0], by)
                except GeosurfError:
                    continue
            self.now = {**self.now, name: fault}
            self._known[name].append(fault)
            self._by[name].append(by)

    def near(self, horizon: str, untorn: Callable[[str], TriSurface]) -> Faults:
        """Faults for a horizon, as short as it can take them.

        What another horizon needs far away then makes no difference: a sheet is found in memory
        whatever that is.
        """
        if all(len(known) == 1 for known in self._known.values()):
            return self.now
        from geosurf.sheets.faults.tips import as_near  # loaded by those who tear

        return as_near(untorn(horizon), self._known)


def _outermost_first(filling: Mapping[str, bool | str]) -> dict[str, bool | str]:
    """The highest and the lowest horizon, then the others: faults are too short for those first."""
    names = list(filling)
    first = dict.fromkeys([*names[:1], *names[-1:], *names])
    return {name: filling[name] for name in first}


def _fill(torn: Mapping[str, _Torn], fill: bool | str) -> bool | Sheet:
    """What becomes of blocks without data, with the sheet of the horizon that is named."""
    return fill if isinstance(fill, bool) else torn[fill].sheet


def _is_valid(torn: Mapping[str, _Torn], name: str, fill: bool | str, faults: Faults) -> bool:
    """Whether a horizon is torn, at faults that are no longer near it than they were."""
    from geosurf.sheets.faults.tips import is_unchanged  # loaded by those who tear

    known = torn.get(name)
    if known is None or _fill(torn, fill) is not known.fill:
        return False
    mine = [fault.name for fault in known.sheet.faults if fault.name in faults]
    before, after = ({one: of[one] for one in mine} for of in (known.faults, faults))
    return is_unchanged(known.sheet, before, after)


def _as_needed(faults: Faults, sheet: Sheet) -> Faults:
    """Faults, as long as a sheet needs them."""
    longer = {
        fault.name: fault
        for fault in sheet.faults
        if fault.name in faults and fault.n_vertex > faults[fault.name].n_vertex
    }
    return {**faults, **longer} if longer else faults


def _ending_on(torn: _Torn, faults: Faults) -> Sheet:
    """The sheet with the faults of all horizons, parts of which are longer far away from it."""
    sheet, known = torn.sheet, torn.faults
    if any(fault.name not in known or not same(fault, known[fault.name]) for fault in sheet.faults):
        return sheet  # it was given, with faults of its own: the scene refuses them
    if all(known[fault.name] is faults[fault.name] for fault in sheet.faults):
        return sheet
    return replace(sheet, faults=tuple(faults[fault.name] for fault in sheet.faults))


def outcome_of(sheet: Sheet) -> str:
    """Return in words what came of a tear."""
    return f"at {', '.join(sheet.cuts)}" if sheet.cuts else "without faults"


def same(first: TriSurface, second: TriSurface) -> bool:
    """Whether two faults are equal, vertex by vertex."""
    return np.array_equal(first.vertices, second.vertices) and np.array_equal(
        first.triangles, second.triangles
    )


def torn_graph(plain: Graph) -> Graph:
    """
    Return the graph of a scene whose horizons are torn at its faults.

    Parameters
    ----------
    plain : Graph
        Of the same inputs, not torn: it has the faults, the box and the area.

    Returns
    -------
    Graph
        Of the sheets and of the faults that they end on; it shares the memory.

    Raises
    ------
    GeosurfError
        As `tear_horizon`.

    Examples
    --------
    >>> from geosurf.scene import Scene
    >>> from geosurf.synthetic import torn
    >>> world = torn("normal", n=41)
    >>> scene = Scene(world.horizons, world.faults, tear=True)
    >>> sorted(scene.sheets), len(scene.units) > 0
    (['Top'], True)
    """
    # faults as extended and truncated: a sheet ends on the surface that the model has
    inputs = plain.inputs
    given = {name: plain.faults.surface(name) for name in inputs.faults}
    start = as_long_as(plain.longer, given)
    sheets, faults = sheets_on(
        start, inputs.filling, partial(_torn, plain), plain.untied, plain.memory.on_start,
        plain.made_of,
    )  # fmt: skip
    # what the base case of an ensemble needed has been told there
    outline = outline_of(plain.given_box, plain.given_area)
    before, rules = start if plain.plans else given, plain.faults.rules
    found = warnings_of(before, faults, sheets, outline, rules)
    found += warnings_of_throw(sheets, plain.made_of)
    plain.memory.warn(*(in_time(one, inputs.time) for one in found))
    for name in inputs.horizons:
        if throws := inputs.throws_at(name):
            sheets[name] = _thrown(plain, name, throws, faults)

    # the box of the data: that of the sheets is taller, and extended faults would leave it later
    frame: dict[str, Any] = {"box": plain.box, "aoi": plain.aoi} if inputs.box is None else {}

    # all rules have been applied: the new scene takes faults and sheets as they are
    torn = replace(
        inputs, horizons={**inputs.horizons, **sheets}, faults=faults, extend=(), lengthen=None,
        tear=None, throws=None, truncations=as_truncations(inputs.horizon_rules),
        fill_empty_blocks=None, **frame,
    )  # fmt: skip
    graph = Graph(torn, plain.memory, prepared_by=plain.faults)
    graph.read.take_over(plain.read, {"horizons": sheets, "faults": faults})
    graph.known_regions, graph.converted_from = plain.known_regions, plain.converted_from
    graph.zone_rows, graph.made_of = plain.zone_rows, plain.made_of
    # tears add beyond main faults, too
    graph.passed = rules_to_repeat(rules, given, faults)
    return graph


def torn_or_plain(plain: Graph) -> Graph:
    """Return the graph of the model: of torn horizons, where they are to be torn."""
    inputs = plain.inputs
    with vertical_axis(inputs.time):
        return torn_graph(plain) if inputs.tear is not None or inputs.throws else plain


def as_truncations(rules: Iterable[Rule]) -> dict[str, tuple[tuple[str, str], ...]]:
    """Return rules as `Scene` takes them, for faults that are extended already."""
    found = grouped((rule.fault, (rule.main, rule.keep)) for rule in rules)
    return {fault: tuple(of) for fault, of in found.items()}


def as_long_as(longer: LongerFaults, faults: Faults) -> Faults:
    """Return faults, those that are longer in another scene as long as there.

    Parameters
    ----------
    longer : dict of str to (TriSurface, TriSurface)
        A fault there, and the longer one that tears needed. It counts where the fault is the same.
    faults : dict of str to TriSurface
    """
    lengthened = dict(faults)
    for name, (before, after) in longer.items():
        fault = faults.get(name)
        if fault is not None and same(fault, before):
            lengthened[name] = after
    return lengthened


def longer_faults(faults: Faults, torn: Faults) -> LongerFaults:
    """Return the faults that tears have made longer, as they were and as they are.

    Parameters
    ----------
    faults, torn : dict of str to TriSurface
        Before and after horizons were torn.
    """
    return {
        name: (fault, torn[name]) for name, fault in faults.items() if not same(fault, torn[name])
    }


def warnings_of(
    given: Faults,
    faults: Faults,
    sheets: Mapping[str, Sheet],
    outline: np.ndarray,
    rules: Iterable[Rule],
) -> list[GeosurfWarning]:
    """Return how much longer faults became, and the warnings of the sheets for an area."""
    mains = {rule.fault: rule.main for rule in rules}
    warnings: list[GeosurfWarning] = []
    sheet_warnings = [
        warning for sheet in sheets.values() for warning in warnings_of_sheet(sheet, outline)
    ]
    needed = {
        warning.subject: warning for warning in sheet_warnings if warning.kind == "fault extended"
    }
    for name, fault in faults.items():
        # how far the fault was continued beyond what was given, by the numbers that lengthen it
        if not np.array_equal(fault.vertices, given[name].vertices):
            from geosurf.sheets.mesh.tear_ends import VERTICAL  # loaded by those who tear
            from geosurf.sheets.report.remedies import WAYS, how_to_lengthen, longer_by

            far = longer_by(given[name], fault)
            ways = [f"{length:.0f} m {WAYS[side]}" for side, length in far.items()]
            # what passes a main fault along strike is cut again
            stays = {side: far[side] for side in far if name not in mains or side in VERTICAL}
            if far and not stays:
                continue
            past = f" What lies beyond {mains[name]!r} is cut off." if name in mains else ""
            how = how_to_lengthen(name, stays)
            middle = tuple(fault.vertices.mean(axis=0).tolist())
            at = needed[name].place or middle if name in needed else middle
            warnings.append(
                GeosurfWarning(
                    "fault extended",
                    name,
                    f"Fault {name!r} ends before the cut-offs of a horizon that is torn at it. It "
                    f"was extended{': ' if ways else ''}{', '.join(ways)}.{past}",
                    f"Lengthen it yourself: {how}, or pick longer sticks.",
                    at,
                )
            )
    # how much longer a fault became counts as a whole, not by the sheets that needed some of it
    warnings += [warning for warning in sheet_warnings if warning.kind != "fault extended"]
    warnings += _polygons_unused(given, tuple(sheets))
    return list(dict.fromkeys(warnings))


def _polygons_unused(faults: Faults, torn: tuple[str, ...]) -> Iterator[GeosurfWarning]:
    """Fault polygons on horizons that are not torn, or not there."""
    faults_of = grouped(
        (key.removeprefix(CUTOFF), name)
        for name, fault in faults.items()
        for key in fault.vertex_data
        if key.startswith(CUTOFF)
    )
    for horizon, names in faults_of.items():
        if torn and horizon not in torn:
            yield GeosurfWarning(
                "polygon left out",
                horizon,
                f"Polygons of {', '.join(map(repr, names))} are on {horizon!r}, and no horizon of "
                "that name is torn: they shape the faults, and give no throw.",
                f"Name them by the horizon that they show: {known_names(torn, horizon)}",
            )


def _torn(plain: Graph, tear: Tear) -> Sheet:
    """One sheet, from memory if it is there; one that was given stays as it is."""
    inputs, memory, name = plain.inputs, plain.memory, tear.name
    value = inputs.horizons[name]
    if isinstance(value, Sheet):
        return value
    still = plain.still.get(name)
    if still is not None and all(same(one, tear.faults[one.name]) for one in still.faults):
        return still
    settings, tops = inputs.tear, plain.tops if inputs.tie is not None else None
    tied: tuple[Hashable, ...] = ()
    if tops is not None:
        tied = tops.wells, tops.horizons, memory.hold(tops.points), repr(inputs.tie)
    faults = [tear.faults[fault] for fault in inputs.faults_at(name)]
    plan = plain.plans.get(name)
    if plain.converted_from is not None:
        known = plain.converted_from.inputs.horizons.get(name)
        if isinstance(known, Sheet):
            tear = replace(tear, like=(known,), faults_moved=True)

    # the horizon's content, all faults, and all settings that the sheet depends on
    words = {key: getattr(settings, key) for key in ("trim", "noise", "keep_outliers")}
    options = (repr(words), tied, *tear.key)
    key: tuple[Hashable, ...] = (
        "torn", name, plain.read.content(name, value), *map(memory.key_of, faults),
        *inputs.options.values(), plan, *options,
        tear.fill if isinstance(tear.fill, bool) else memory.key_of(tear.fill.surface),
    )  # fmt: skip

    def make() -> Sheet:
        """Read the data and tear them."""
        plain.read.unchanged(name)
        data = opened_horizon(value, inputs.options)
        declared = undeclared(data, inputs.options)
        run = partial(tear.sheet, data, faults, plan, tops, inputs.tie, **words, **declared)
        with collected():  # those of the sheet are enough: this one may not be the last
            # a plan comes from another model, which the name of a stored result does not state
            if plan is not None:
                return run()
            content = partial(_content, name, data, declared)
            return _stored(memory, lambda: (content(), *faults, tear.fill, *options), run)

    return memory.get_or_compute("tear", name, key, make, outcome_of, again=False, reports=False)


def _stored(memory: Memory, inputs: Callable[[], Any], run: Callable[[], Sheet]) -> Sheet:
    """A sheet, from an earlier run if its folder has it; `inputs` give all that it is made of."""
    disk = memory.store.disk
    found: Sheet = run() if disk is None else disk.get_or_compute("sheet", inputs(), run)
    return found


def _content(name: str, data: Any, words: Mapping[str, Any]) -> Any:
    """What a tear reads of a horizon, in whatever form: realisations have other ones than runs."""
    from geosurf.sheets.lattice.data import points_of  # loaded by those who tear

    if are_points(data):
        points = points_of(data, name, words.get("positive"), words.get("length_unit"))[1]
        return name, str(crs_of(data)), points
    return data if isinstance(data, TriSurface) else triangulate_horizon(data, name=name, **words)


def _thrown(plain: Graph, name: str, throws: Sequence[FaultThrow], faults: Faults) -> Sheet:
    """A sheet from a continuous horizon and the throws that move it, youngest fault first."""
    from geosurf.sheets.throw.throw_horizon import throw_horizon  # loaded by those who tear

    memory, horizon = plain.memory, plain.untied(name)
    moving = [faults[throw.fault] for throw in throws]

    def of_fault(word: str) -> dict[str, Any]:
        """A word of the throws, by fault."""
        return {throw.fault: getattr(throw, word) for throw in throws}

    words: dict[str, Any] = {
        word: of_fault(word) for word in ("reach", "hanging_wall", "direction")
    }
    run = partial(throw_horizon, horizon, moving, of_fault("throw"), name=name, **words)
    shapes = [throw.throw for throw in throws]
    return memory.get_or_compute(
        "tear", name,
        ("thrown", *map(memory.key_of, (horizon, *moving)), repr(words), memory.hold(shapes)),
        lambda: _stored(memory, lambda: (horizon, *moving, repr(words), *shapes), run),
        outcome_of, again=False,
    )  # fmt: skip


def rules_to_repeat(rules: Iterable[Rule], given: Faults, faults: Faults) -> dict[Rule, str]:
    """
    Return the rules whose faults tears have made longer, and how to lengthen these before.

    Parameters
    ----------
    rules : iterable of Rule
        Faults that end at faults.
    given, faults : mapping of str to TriSurface
        All faults as rules left them, and as tears made them longer.
    """
    from geosurf.sheets.report.remedies import how_to_lengthen, longer_by

    ways_by_rule = {}
    for rule in rules:
        both = [name for name in (rule.fault, rule.main) if faults[name] is not given[name]]
        ways = [how_to_lengthen(name, longer_by(given[name], faults[name])) for name in both]
        if ways:
            ways_by_rule[rule] = ", and ".join(ways)
    return ways_by_rule
