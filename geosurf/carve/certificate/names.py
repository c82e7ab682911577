"""Check the names of units: recompute zones, blocks, fault sides and contacts.

Everything is recomputed from the triangles of shells and from all surfaces that each triangle lies
on (see `geosurf.carve.certificate.partition`), not from the cells that made the units.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import lru_cache

import numpy as np

from geosurf.carve.blocks import WHOLE
from geosurf.carve.certificate.adjacency import ABOVE, BELOW, Around, lie_on
from geosurf.carve.certificate.elements import Elements
from geosurf.carve.certificate.partition import Matched, rows_of
from geosurf.carve.column import names_of_zones
from geosurf.carve.fluids import parse_sides
from geosurf.carve.shells import unit_name
from geosurf.model import Check, Patches, Unit, Units
from geosurf.model.compartments import separators

NAME = "unit names match their bounding surfaces"


def named(patches: Patches | Elements, units: Units, found: Matched, divided: bool) -> Check:
    """Zone, block and contact in each name match the bounding surfaces of the unit.

    Blocks depend on all units of a zone; sides of faults and horizons depend on all units. These
    are only checked if units fill the box (`divided`), see `partition`.

    Merged slivers may be of other zones and contact intervals than their unit. So these are checked
    on the units before, which are called that way, and blocks on those after.
    """
    patches = Elements.of(patches)
    parts = list(units.values())
    faults, virtual = tuple(_faults(patches)), bool(rows_of(patches, "virtual"))
    zones = names_of_zones([patches.names[i] for i in rows_of(patches, "horizon")])
    wrong = [unit.name for unit in parts if not _spelt(zones, faults, virtual, unit)]
    upward, merged = _upward(patches), units.unmerged is not None
    if not merged:
        wrong += [parts[u].name for u in _in_other_zones(patches, parts, found, upward)]

    # each side of a surface that a unit touches, once
    around = Around(patches, found, len(parts))
    fault = list(patches.names)
    for name, rows in _faults(patches).items():
        for row in rows:
            fault[row] = name
    for one, u, back in np.argwhere(around.touched_all).tolist():
        if fault[one] + ("+" if back else "-") in parts[u].fault_sides:
            wrong.append(parts[u].name)
    if divided:
        if not merged:
            wrong += [parts[u].name for u in _beyond_horizons(patches, parts, around, upward)]
        wrong += _in_other_blocks(patches, parts, around)
        wrong += _on_other_sides(patches, parts, around)
    if not merged:
        wrong += _contacts_apart(patches, parts, found, upward)
        wrong += _offset_at_virtual(patches, parts, around)
    wrong = list(dict.fromkeys(wrong))
    detail = f"zone, block and contact of {len(parts)} units recomputed from their surfaces"
    if wrong:
        detail = f"bounding surfaces give another zone, block or contact: {', '.join(wrong[:8])}"
    return Check(NAME, not wrong, float(len(wrong)), detail)


def _in_other_blocks(patches: Elements, parts: list[Unit], around: Around) -> Iterable[str]:
    """Units whose block name differs from the recomputed sides of faults.

    The sides are recomputed from all triangles of shells: a fault separates units that touch only
    its front from units that touch only its back. Fluid contacts do not separate blocks.
    """
    blocks = dict.fromkeys((unit.zone, unit.block) for unit in parts)

    # blocks instead of units: contacts split units, not blocks
    number = {block: k for k, block in enumerate(blocks)}
    of_unit = np.array([number[unit.zone, unit.block] for unit in parts], dtype=np.int64)
    zones = list(dict.fromkeys(unit.zone for unit in parts))
    zone = np.array([zones.index(of) for of, _ in blocks], dtype=np.int64)
    found, (shell, surface, behind) = around.found, around.on

    # block in front and behind of each triangle, -1 outside
    inside = around.on_each_side(of_unit[found.unit])[found.key[shell]]
    apart = inside[:, 0] != inside[:, 1]  # others are slits

    # (n_surface, n_block, 2): whether a block touches the front, the back of a surface
    touched = np.zeros((len(patches.sources), len(blocks), 2), dtype=bool)
    of = of_unit[found.unit[shell[apart]]]
    touched[surface[apart], of, behind[apart].astype(np.int64)] = True
    recomputed: list[set[str]] = [set() for _ in blocks]
    faults = _faults(patches)
    for fault, surfaces in faults.items():
        # a fault names a block that has it on one side only, if the zone has such blocks on both
        mine = np.logical_or.reduce(touched[surfaces])
        alone = mine & ~mine[:, ::-1]
        both = np.isin(zone, zone[alone[:, 0]]) & np.isin(zone, zone[alone[:, 1]])
        for block, side in np.argwhere(alone & both[:, None]).tolist():
            recomputed[block].add(fault + "+-"[side])
    stated = [_stated_sides(block, tuple(faults)) for _, block in blocks]
    for unit, k in zip(parts, of_unit.tolist(), strict=True):
        if stated[k] != recomputed[k]:
            yield unit.name


def _on_other_sides(patches: Elements, parts: list[Unit], around: Around) -> Iterable[str]:
    """Units whose `fault_sides` differ from the recomputed sides.

    The region that is reachable from a unit without crossing a fault touches only its front, or
    only its back; otherwise the fault does not bound the region.
    """
    faults = _faults(patches)
    recomputed = [set(_stated_sides(unit.block, tuple(faults)) or ()) for unit in parts]

    # the region around a unit that is connected without the fault: on one side only, or none
    for name, surfaces in faults.items():
        seen = around.seen(surfaces)
        for u, side in np.argwhere(seen & ~seen[:, ::-1]).tolist():
            recomputed[u].add(name + "+-"[side])
    for unit, sides in zip(parts, recomputed, strict=True):
        if set(unit.fault_sides) != sides or len(unit.fault_sides) != len(sides):
            yield unit.name


def _beyond_horizons(
    patches: Elements, parts: list[Unit], around: Around, upward: np.ndarray
) -> list[int]:
    """Units that lie above the horizon at the top of their zone, or below that at its base.

    A horizon that the column removed in some unit is skipped: the rules of the column, which are
    unknown here, could extend the removal to other units.
    """
    zone = np.array([unit.zone_index for unit in parts])
    wrong = np.zeros(len(parts), dtype=bool)
    for rank, i in enumerate(rows_of(patches, "horizon")):
        # `holding`: units that have the horizon inside, where the column removed it
        if len(around.holding(i)) == 0:
            side = around.side_of_horizon(i, ABOVE if upward[i] else BELOW)
            wrong |= (zone == rank + 1) & (side == ABOVE) | (zone == rank) & (side == BELOW)
    return np.flatnonzero(wrong).tolist()


@lru_cache(maxsize=4096)  # zones share their blocks: 13 767 units have 459
def _stated_sides(block: str, faults: tuple[str, ...]) -> frozenset[str] | None:
    """Sides of faults in the name of a block; None if the name has other parts."""
    name = re.sub(r" #\d+$", "", block)
    return frozenset() if name == WHOLE else parse_sides(name, faults)


def _spelt(zones: list[str], faults: tuple[str, ...], virtual: bool, unit: Unit) -> bool:
    """Whether a name consists of zone, block and contact, and these of existing names."""
    sides = _stated_sides(unit.block, faults)
    within = re.sub(r" #\d+$", "", unit.compartment_of)
    return (
        unit.name == unit_name(unit.zone, unit.block, unit.contact)
        and 0 <= unit.zone_index < len(zones)
        and unit.zone == zones[unit.zone_index]
        and sides is not None
        and sides <= set(unit.fault_sides)
        and (_stated_sides(within, faults) is not None if virtual else not within)
    )


def _faults(patches: Elements) -> dict[str, list[int]]:
    """Faults, and the surfaces of each: its own, and its virtual wall."""
    return separators(patches.names, [source.role for source in patches.sources])


def _upward(patches: Elements) -> np.ndarray:
    """Whether the front of each surface faces up, within the bounds of the walls."""
    # signed map area of each surface inside the box: up or down as a whole
    upward: np.ndarray = patches.rise >= 0.0
    return upward


def _in_other_zones(
    patches: Elements, parts: list[Unit], found: Matched, upward: np.ndarray
) -> list[int]:
    """Units above a horizon in a zone below it, or the reverse.

    Where horizons coincide, the column may have removed all of them except one. Where a horizon
    lies on a wall, or on a fault or contact within one zone, the column may have removed the
    horizon, and the other surface still bounds the units.
    """
    horizons = rows_of(patches, "horizon")
    zone = np.array([unit.zone_index for unit in parts])[found.unit]

    # zone in front and behind of each set of corners, -1 where no unit is
    beside = np.full((found.n_key, 2), -1)
    beside[found.key, found.turn.astype(np.int64)] = zone
    roles = ("fault", "virtual", "contact")
    others = [row for role in roles for row in rows_of(patches, role)]
    bound = lie_on(patches, found, others) & (beside[:, 0] == beside[:, 1])
    bound |= lie_on(patches, found, rows_of(patches, "wall"))
    open_ = np.isin(found.surface, horizons) & (found.row >= 0) & ~bound[found.key]
    open_ = np.flatnonzero(open_)

    # nearly all fit the only surface that they are on, so horizons do not look at them one by one
    row, level = found.row[open_], np.full(len(patches.sources), -1)
    level[horizons] = np.arange(len(horizons))
    alone = np.bincount(found.of_patches, minlength=found.n_key)[found.key[open_]] == 1
    below = (found.turn_of_patches[row] == found.turn[open_]) == upward[found.surface[open_]]
    open_ = open_[~(alone & (below == (zone[open_] > level[found.surface[open_]])))]
    if len(open_) == 0:
        return []

    # a triangle stays in `open_` if no horizon on it fits; what remains has no excuse
    order = np.argsort(patches.surface_of_triangle, kind="stable")
    cut = np.searchsorted(patches.surface_of_triangle[order], np.arange(len(patches.sources) + 1))
    turn = np.zeros(found.n_key, dtype=np.int8)  # 1 or 2 for keys on a horizon
    for rank, i in enumerate(horizons):
        rows = order[cut[i] : cut[i + 1]]
        turn[found.of_patches[rows]] = 1 + found.turn_of_patches[rows]
        mine = turn[found.key[open_]]
        turn[found.of_patches[rows]] = 0
        below = (mine == 1 + found.turn[open_]) == upward[i]
        open_ = open_[(mine == 0) | (below != (zone[open_] > rank))]
    return np.unique(found.unit[open_]).tolist()


def _offset_at_virtual(patches: Elements, parts: list[Unit], around: Around) -> Iterable[str]:
    """Units that only a virtual wall separates, although zone or block differ."""
    rows = [rows_of(patches, role) for role in ("horizon", "fault", "contact", "wall")]
    only = lie_on(patches, around.found, rows_of(patches, "virtual"))
    only &= ~lie_on(patches, around.found, [row for some in rows for row in some])

    # the units in front and behind; a wall that ends inside a unit has none
    beside = around.on_each_side(around.found.unit)[only]
    beside = beside[(beside >= 0).all(axis=1)]
    for u, v in np.unique(beside, axis=0).tolist():
        one, two = parts[u], parts[v]
        if (one.zone, one.compartment_of) != (two.zone, two.compartment_of):
            yield from (one.name, two.name)


def _contacts_apart(
    patches: Elements, parts: list[Unit], found: Matched, upward: np.ndarray
) -> Iterable[str]:
    """Names of units that a fluid contact separates although their names do not show it."""
    mine = np.flatnonzero(np.isin(found.surface, rows_of(patches, "contact")) & (found.row >= 0))

    # units below a contact see it from its back, if it faces up
    below = found.behind[mine] == upward[found.surface[mine]]
    order = np.lexsort((below, found.key[mine]))  # above, then below
    mine, below = mine[order], below[order]

    # neighbours in this order with one key: the units above and below one triangle
    two = np.flatnonzero(found.key[mine[1:]] == found.key[mine[:-1]])
    pairs = np.stack([found.unit[mine[two]], found.unit[mine[two + 1]]], axis=1)
    for u, v in np.unique(pairs, axis=0).tolist():  # above, below
        high, low = parts[u], parts[v]
        same = (high.zone, high.block) == (low.zone, low.block) and high.contact != low.contact
        if not same or _begins(high, "below ") or _begins(low, "above "):
            yield from (high.name, low.name)


def _begins(unit: Unit, word: str) -> bool:
    """Whether a unit is the lowest or uppermost of its block; contact names may have the word."""
    return unit.contact.startswith(word) and "/" not in unit.contact
