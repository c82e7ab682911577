"""Horizons that are torn until all of them end on the same faults, in as few tears as possible.

A tear may need a longer fault. The outermost horizons come first, one after the other, then all
others. Those that came before a fault became longer near them are torn again, with what closed them
then. Each horizon takes its faults without what others have added far away from it.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from types import MappingProxyType

import numpy as np

from geosurf.errors import GeosurfError, InvariantError
from geosurf.model import Sheet, TriSurface
from geosurf.model.network import in_order
from geosurf.model.sheets import TearPlan
from geosurf.scene.memory import OnStart, silent
from geosurf.warning import collected

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

    See Also
    --------
    geosurf.sheets.tear.tear_from : takes the last one.
    """

    name: str
    faults: Faults
    fill: bool | Sheet
    before: TearPlan | None = None
    like: tuple[Sheet, ...] = ()

    @property
    def key(self) -> tuple[Hashable, ...]:
        """What it takes from other tears, as part of a key of results."""
        moved: list[str] = []
        for sheet in self.like:
            if sheet.plan is not None:
                use, names = sheet.plan.use, [fault.name for fault in sheet.faults]
                data = b"".join(a.tobytes() for a in (use.ignored, use.wrong, *use.near, *use.side))
                moved += [repr((sheet.plan.given_trims, names)), sha256(data).hexdigest()]
        one = self.before
        if one is None:
            return tuple(moved)
        lengths = [(x.fault, *sorted(x.lengths.items())) for x in one.extensions]
        tears = (one.traces, one.early, one.rings, one.level, one.left_out, one.loss)
        return (repr((one.trims, one.given_trims, one.order, *tears, lengths)), *moved)


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
            some = lengths.near(name, untorn) if known is None else faults
            before = None if known is None else known.sheet.plan
            like = tuple(torn[of].sheet for of in models[name] if of in torn)
            tears.append(Tear(name, some, _fill(torn, filling[name]), before, like))
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

    def add(self, tear: Tear, torn: _Torn) -> None:
        """Take the faults that a tear has made longer."""
        from geosurf.sheets.mesh.tear_ends import extended  # loaded by those who tear

        plan = torn.sheet.plan
        by_name = {} if plan is None else {one.fault: one.lengths for one in plan.extensions}
        for name, fault in torn.faults.items():
            now = self.now[name]
            if fault is tear.faults[name]:
                continue
            # of two that make one longer at a time the second continues it, or is torn again
            if now is not tear.faults[name]:
                if tear.before is not None or name not in by_name:
                    continue
                try:
                    fault = extended(now, by_name[name])
                except GeosurfError:
                    continue
            self.now = {**self.now, name: fault}
            self._known[name].append(fault)

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


def same(one: TriSurface, other: TriSurface) -> bool:
    """Whether two faults are equal, vertex by vertex."""
    return np.array_equal(one.vertices, other.vertices) and np.array_equal(
        one.triangles, other.triangles
    )
