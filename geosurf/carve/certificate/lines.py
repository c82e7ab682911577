"""The lines of a certificate in their order, and halves of them in threads that are free."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from geosurf.arrangement.threads import in_turn
from geosurf.carve.certificate.checks import Size, adds_up, closed
from geosurf.carve.certificate.elements import Elements
from geosurf.carve.certificate.merged import merged
from geosurf.carve.certificate.names import named
from geosurf.carve.certificate.partition import Matched, partition
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
