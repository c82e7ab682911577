"""The lines of a certificate in their order, and halves of them in threads that are free."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from geosurf.arrangement.threads import in_turn
from geosurf.carve.certificate.checks import Size, adds_up, closed
from geosurf.carve.certificate.elements import Elements
from geosurf.carve.certificate.names import named
from geosurf.carve.certificate.partition import Matched, partition
from geosurf.conventions import volume_text
from geosurf.model import Check, Patches, Units

if TYPE_CHECKING:
    from concurrent.futures import Executor

MANY = 100_000  # triangles, from which units and mesh are checked in two threads
Half = Callable[[], list[Check] | None]


def lines_of_units(
    patches: Patches,
    elements: Patches | Elements,
    units: Units,
    edges: dict[str, tuple[int, int]],
    sizes: dict[str, Size],
    shared: Check,
    found: Matched,
    parts: Matched | None,
) -> list[Check]:
    """The lines of units from their facts, which runs or triangles gave.

    `edges` are open edges and Euler number of each unit. `found` has the triangles of the
    patches that its shell has, `parts` the same of units before slivers were merged.
    """
    divided = partition(elements, units, found)
    lines = [
        closed(edges, sizes),
        adds_up(patches, units, sizes),
        shared,
        divided,
        named(elements, units, found, divided.passed),
    ]
    if units.unmerged is None or parts is None:
        return lines

    # units as they were before slivers were merged have names of their own
    lines.append(merged(patches, units, found, parts))
    full = partition(elements, units.unmerged, parts)
    names = named(elements, units.unmerged, parts, full.passed)
    return [*lines, replace(names, name="names before slivers were merged match")]


def lines_of(halves: list[Half], spare: Executor | None) -> list[Check] | None:
    """Lines of all halves in their order, or None if one half has no answer."""
    found = in_turn(halves, spare)
    whole = [half for half in found if half is not None]
    return list(itertools.chain.from_iterable(whole)) if len(whole) == len(found) else None


# ---- check merged slivers: each unit is the union of its parts, and nothing is lost ------
#
# The shells of units before and after are compared triangle by triangle. Where two parts of a unit
# met, the triangles between them are gone; all other triangles are there as before.


MOST = 8  # slivers that are listed
ROUNDING = 2.0**-48  # of the model's volume: what sums over faces may differ by


def merged(patches: Patches, units: Units, found: Matched, before: Matched) -> Check:
    """Each unit is the union of its parts, each sliver touches them, and volumes add up.

    Parameters
    ----------
    patches : Patches
    units : Units
        With `Units.unmerged`.
    found, before : Matched
        Triangles of the units, and of those before slivers were merged.
    """
    unmerged = units.unmerged
    assert unmerged is not None
    wrong: list[str] = []
    names, old = list(units), list(unmerged)
    into = {one.name: one.into for one in units.merged}
    small = {one.name for one in unmerged.slivers}
    wrong += [name for name, to in into.items() if name not in small or to not in units]
    home = _homes(units, unmerged, found, before, into)
    wrong += [old[u] for u in np.flatnonzero(home < 0).tolist()]
    if not wrong:
        wrong += [names[u] for u in _differ(found, before, home)]
        wrong += [old[u] for u in _apart(before, home, {old.index(name) for name in into})]
        slack = ROUNDING * units.box_volume
        for k, unit in enumerate(units.values()):
            parts = [unmerged[old[u]].volume for u in np.flatnonzero(home == k).tolist()]
            if abs(math.fsum(parts) - unit.volume) > slack:
                wrong.append(unit.name)
    wrong = list(dict.fromkeys(wrong))
    name = "merged slivers are parts of their neighbours"
    if wrong:
        return Check(name, False, float(len(wrong)), f"not so for {', '.join(wrong[:MOST])}")
    return Check(name, True, 0.0, _in_words(units, unmerged))


def _in_words(units: Units, unmerged: Units) -> str:
    """What was merged into what, with volumes, and that none of the volume is lost."""
    listed = [f"{m.name} ({volume_text(m.volume)}) into {m.into}" for m in units.merged[:MOST]]
    more = len(units.merged) - MOST
    difference = (units.volume - unmerged.volume) / units.box_volume
    return (
        f"{units.merged_in_words}: {'; '.join(listed)}{f'; and {more} more' if more > 0 else ''}; "
        f"relative difference of the sum of all units {difference:.1e}"
    )


def _homes(
    units: Units, unmerged: Units, found: Matched, before: Matched, into: dict[str, str]
) -> np.ndarray:
    """Number of the unit that each unit before is a part of now; -1 if it is not found.

    Slivers state it. Others may have another name now, since fault sides that only slivers had are
    gone: a triangle that they share with their unit tells.
    """
    number = {name: k for k, name in enumerate(units)}
    home = np.full(len(unmerged), -1)
    _, now, then = np.intersect1d(_codes(found), _codes(before), return_indices=True)
    home[before.unit[then]] = found.unit[now]
    for u, name in enumerate(unmerged):
        if name in into:
            home[u] = number.get(into[name], -1)
    return home


def _codes(found: Matched) -> np.ndarray:
    """One number for each triangle of a shell and the side of it that the unit is on."""
    first = np.full(found.n_key, -1)
    n = len(found.of_patches)
    first[found.of_patches[::-1]] = np.arange(n)[::-1]
    codes: np.ndarray = 2 * first[found.key] + found.turn
    return codes


def _differ(found: Matched, before: Matched, home: np.ndarray) -> list[int]:
    """Units with other triangles than their parts have on the outside."""
    turn = before.turn.astype(np.int64)
    beside = np.full((before.n_key, 2), -1)
    beside[before.key, turn] = home[before.unit]
    outer = beside[before.key, 0] != beside[before.key, 1]
    n = int(home.max(initial=0)) + 1
    want = _codes(before)[outer] * n + home[before.unit[outer]]
    differ = np.setxor1d(want, _codes(found) * n + found.unit)
    return np.unique(differ % n).tolist()


def _apart(before: Matched, home: np.ndarray, slivers: set[int]) -> list[int]:
    """Slivers that share no triangle with another part of their unit."""
    beside = np.full((before.n_key, 2), -1)
    beside[before.key, before.turn.astype(np.int64)] = before.unit
    inner = beside[(beside >= 0).all(axis=1)]
    one, two = home[inner].T
    return sorted(slivers - set(inner[one == two].ravel().tolist()))
