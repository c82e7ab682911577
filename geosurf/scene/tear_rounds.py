"""Horizons that are torn until all of them end on the same faults, in as few tears as possible.

A tear may need a longer fault. First the outermost horizons, one after the other, give up where a
fault is too short for them, and the fault is made longer. Then all horizons are torn.
Those that need still longer faults make them so, and others are torn again where these come near.
Each horizon takes its faults without what others have added far away from it.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from geosurf.errors import GeosurfError, InvariantError
from geosurf.model import Sheet, TriSurface
from geosurf.model.network import in_order
from geosurf.model.sheets import NeededFaults
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
    asking : bool
        Whether the tear ends where it needs longer faults.
    needed : NeededFaults or None
        What it needed when it asked; faults are as long now.

    See Also
    --------
    geosurf.sheets.tear.tear_from : takes the last two.
    """

    name: str
    faults: Faults
    fill: bool | Sheet
    asking: bool = False
    needed: NeededFaults | None = None


Made = Sheet | NeededFaults
Make = Callable[[Tear], Made]


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
) -> tuple[dict[str, Sheet], Faults]:
    """Return sheets that all end on the same faults, and these: longer ones where one needs it.

    Parameters
    ----------
    faults : dict of str to TriSurface
    filling : mapping of str to bool or str
        Horizons, and what becomes of blocks without data: see `filling_by_horizon`.
    make : callable
        Makes a tear: the sheet, or the faults that one needs that asks. Warnings of a sheet are its
        own.
    untorn : callable
        Gives a horizon as it is before it is torn.
    on_start : callable, optional
        Is called before each tear: see `OnStart`.
    """
    order = in_order(_outermost_first(filling))
    torn: dict[str, _Torn] = {}
    needed: dict[str, NeededFaults] = {}
    lengths = _Lengths(faults)
    n_torn = 0

    def made(tears: Sequence[Tear], count: int) -> list[Made]:
        """Make some tears, of so many that are known to be left."""
        nonlocal n_torn
        before, found = n_torn, []
        for tear in tears:
            n_torn += 1
            on_start("tear", tear.name, n_torn, before + count)
            with collected():
                found.append(make(tear))
        return found

    # faults as long as the outermost horizons need them, before any horizon is torn in vain
    for name in order[:OUTERMOST] if len(order) > 1 else ():
        if isinstance(fill := filling[name], bool):
            found: Made | None = None
            for some in (lengths.near(name, untorn), lengths.now):
                (found,) = made([Tear(name, some, fill, asking=True)], len(order) - len(torn))
                if isinstance(found, NeededFaults):
                    found = lengths.added(some, found)
                if found is not None:
                    break
            if isinstance(found, Sheet):
                torn[name] = _Torn(found, some, fill)
            else:
                assert found is not None
                needed[name] = found
                lengths.take({**lengths.now, **found.faults})

    for _ in range(ROUNDS + len(order)):
        faults = lengths.now
        again = [name for name in order if not _is_valid(torn, name, filling[name], faults)]
        if not again:
            return {name: _ending_on(torn[name], faults) for name in filling}, faults
        tears = []
        for name in again:
            # those that are pinched out onto a sheet wait for it
            if filling[name] not in again:
                own = needed.get(name)
                some = faults if name in torn else lengths.near(name, untorn, own)
                tears.append(Tear(name, some, _fill(torn, filling[name]), needed=own))
        for tear, sheet in zip(tears, made(tears, len(again)), strict=True):
            assert isinstance(sheet, Sheet)  # none of these asks
            longer = _as_needed(tear.faults, sheet)
            torn[tear.name] = _Torn(sheet, longer, tear.fill)
            # of two that make a fault longer the first one does: the other is torn again at that
            lengths.take(
                {
                    name: longer[name] if one is tear.faults[name] else one
                    for name, one in lengths.now.items()
                }
            )
    raise InvariantError(f"horizons {again} were torn {ROUNDS} times, each time at longer faults.")


class _Lengths:
    """Faults, each as it was given and as it became longer."""

    def __init__(self, faults: Faults) -> None:
        self.now = faults
        self._known = {name: [fault] for name, fault in faults.items()}

    def take(self, faults: Faults) -> None:
        """Take faults, of which some are longer."""
        self.now = faults
        for name, fault in faults.items():
            if fault is not self._known[name][-1]:
                self._known[name].append(fault)

    def added(self, some: Faults, needed: NeededFaults) -> NeededFaults | None:
        """What a horizon needs that had some of the faults, added to the faults as they are now.

        None where one cannot be continued as it is now.
        """
        from geosurf.sheets.mesh.tear_ends import extended  # loaded by those who tear

        longer = {}
        for one in needed.extensions:
            name = one.fault
            if some[name] is self.now[name]:
                longer[name] = needed.faults[name]
                continue
            try:
                longer[name] = extended(self.now[name], one.lengths)
            except GeosurfError:  # the horizon finds another remedy if it asks at this fault
                return None
        return replace(needed, faults=longer)

    def near(
        self, horizon: str, untorn: Callable[[str], TriSurface], needed: NeededFaults | None = None
    ) -> Faults:
        """Faults for a horizon, as short as it can take them, but as long as it has needed them.

        What another horizon needs far away then makes no difference: a sheet is found in memory
        whatever that is.
        """
        own = {} if needed is None else needed.faults
        some = {
            name: known[known.index(own[name]) if name in own else 0 :]
            for name, known in self._known.items()
        }
        if all(len(known) == 1 for known in some.values()):
            return self.now
        from geosurf.sheets.faults.tips import as_near  # loaded by those who tear

        return as_near(untorn(horizon), some)


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


def outcome_of(found: Made) -> str:
    """Return in words what came of a tear."""
    if isinstance(found, Sheet):
        return f"at {', '.join(found.cuts)}" if found.cuts else "without faults"
    return f"needs longer {', '.join(found.faults)}"


def needs_as_key(needed: NeededFaults | None) -> tuple[Hashable, ...]:
    """Return what a tear takes from an earlier one of its horizon, as part of a key of results."""
    if needed is None:
        return ()
    longer = [(one.fault, *sorted(one.lengths.items())) for one in needed.extensions]
    return (repr((longer, [*needed.trims.items()])),)


def same(one: TriSurface, other: TriSurface) -> bool:
    """Whether two faults are equal, vertex by vertex."""
    return np.array_equal(one.vertices, other.vertices) and np.array_equal(
        one.triangles, other.triangles
    )
