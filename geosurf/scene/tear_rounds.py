"""Horizons that are torn one after another until all of them end on the same faults.

A tear may make a fault longer. The horizons after it are torn at the longer fault at once, and
those before it again if the longer fault comes near them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from geosurf.errors import InvariantError
from geosurf.model import Sheet, TriSurface
from geosurf.model.empty_blocks import in_order
from geosurf.scene.progress import OnStart, silent
from geosurf.warning import collected

ROUNDS = 16  # each makes a fault longer, which a horizon does at most four times at each side

Faults = dict[str, TriSurface]
Make = Callable[[str, Faults, bool | Sheet], Sheet]


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
    on_start: OnStart = silent,
) -> tuple[dict[str, Sheet], Faults]:
    """Return sheets that all end on the same faults, and these: longer ones where one needs it.

    Parameters
    ----------
    faults : dict of str to TriSurface
    filling : mapping of str to bool or str
        Horizons, and what becomes of blocks without data: see `filling_by_horizon`.
    make : callable
        (horizon, faults, bool or sheet that it is pinched out onto) -> its sheet; its warnings are
        those of the sheet.
    on_start : callable, optional
        Is called before each tear: see `OnStart`.
    """
    order = in_order(_outermost_first(filling))
    torn: dict[str, _Torn] = {}
    n_torn = 0
    for _ in range(ROUNDS):
        again = [name for name in order if not _is_valid(torn, name, filling[name], faults)]
        if not again:
            return {name: _ending_on(torn[name], faults) for name in filling}, faults
        for place, name in enumerate(again):
            on_start("tear", name, n_torn + 1, n_torn + len(again) - place)
            fill = _fill(torn, filling[name])
            with collected():
                sheet = make(name, faults, fill)
            faults = _as_needed(faults, sheet)
            torn[name] = _Torn(sheet, faults, fill)
            n_torn += 1
    raise InvariantError(f"horizons {again} were torn {ROUNDS} times, each time at longer faults.")


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
    from geosurf.sheets.faults.longer_faults import is_unchanged  # loaded by those who tear

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


def same(one: TriSurface, other: TriSurface) -> bool:
    """Whether two faults are equal, vertex by vertex."""
    return np.array_equal(one.vertices, other.vertices) and np.array_equal(
        one.triangles, other.triangles
    )
