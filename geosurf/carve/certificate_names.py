"""Check the names of units: recompute zones, blocks, fault sides and contacts.

Everything is recomputed from the triangles of shells and from all surfaces that each triangle lies
on (see `geosurf.carve.certificate_shells`), not from the cells that made the units.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from geosurf.carve.certificate_facts import Facts
from geosurf.carve.certificate_shells import Matched
from geosurf.carve.fluids import parse_sides
from geosurf.carve.outside import NO_HIT, Rays
from geosurf.carve.shells import unit_name
from geosurf.carve.zones import WHOLE
from geosurf.kernels.lattices.sets import distinct, first_rows, is_among, ranges
from geosurf.kernels.meshes.mesh import edge_keys, join_pairs, number_keys
from geosurf.model import Check, Unit, Units
from geosurf.model.column import names_of_zones, separators

# ---- adjacency ----------------------------------------
# Recompute the adjacency of units from the triangles of their shells.
#
# Units with a common triangle are neighbours across all surfaces that lie on it (see
# `check_partition`). Some triangles belong to no shell: a fault that ends inside a unit, or a
# horizon that the column removed. A ray finds the unit around them.


ABOVE, BELOW = 1, -1


@dataclass(frozen=True)
class Around:
    """Units, and the surfaces between them.

    Attributes
    ----------
    facts : Facts
    matched : Matched
    n_unit : int
    """

    facts: Facts
    matched: Matched
    n_unit: int

    @cached_property
    def on(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Triangles of shells, each surface they lie on, and whether the unit is behind it.

        Where surfaces coincide, a shell names only one of them, and each has its own orientation.
        """
        matched = self.matched

        # keys are sets of corners; those of a single triangle name their surface directly
        times = np.bincount(matched.of_patches, minlength=matched.n_key)
        once = np.flatnonzero((matched.row >= 0) & (times[matched.key] <= 1))

        # where surfaces coincide, list every triangle with the corners of the shell's one
        several = np.flatnonzero(times[matched.key] > 1)
        rows = np.flatnonzero(times[matched.of_patches] > 1)
        rows = rows[np.argsort(matched.of_patches[rows], kind="stable")]
        start = np.searchsorted(matched.of_patches[rows], matched.key[several])
        number, at = ranges(start, times[matched.key[several]])

        # one row for each pair of shell triangle and surface; behind if both turn alike
        row = np.concatenate([matched.row[once], rows[at]])
        shell = np.concatenate([once, several[number]])
        behind = matched.turn[shell] == matched.turn_of_patches[row]
        return shell, self.facts.surface_of_triangle[row], behind

    def on_each_side(self, values: np.ndarray) -> np.ndarray:
        """Value of `values` for the shell on either side of each triangle; -1 without a shell."""
        beside = np.full((self.matched.n_key, 2), -1)
        beside[self.matched.key, self.matched.turn.astype(np.int64)] = values
        return beside

    @cached_property
    def _beside(self) -> np.ndarray:
        return self.on_each_side(self.matched.unit)

    @cached_property
    def _links(self) -> tuple[np.ndarray, np.ndarray]:
        """Pairs of neighbours (n, 2), and the pair of each triangle; n if it has fewer than two."""
        # triangles with a unit on both sides link these two; the pair is coded as one number
        one, other = self._beside.T
        inner = np.flatnonzero((one >= 0) & (other >= 0))
        low, high = np.minimum(one, other)[inner], np.maximum(one, other)[inner]
        codes, code = number_keys(low * self.n_unit + high)
        link = np.full(self.matched.n_key, len(codes))
        link[inner] = code
        return np.stack(np.divmod(codes, self.n_unit), axis=1), link

    @cached_property
    def _times(self) -> np.ndarray:
        """Number of triangles of each surface between each pair of neighbours (n_surface, n)."""
        link, surface, _ = self._inner
        shape = len(self.facts.sources), len(self._links[0])
        times = np.bincount(surface * shape[1] + link, minlength=shape[0] * shape[1])
        return times.reshape(shape)

    @cached_property
    def _inner(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Each set of corners between two neighbours with each surface on it: pair of neighbours,
        surface, and key.
        """
        shell, surface, _ = self.on

        # the shell on one side lists all surfaces
        turned = np.flatnonzero(self.matched.turn[shell])
        key = self.matched.key[shell[turned]]
        link = self._links[1][key]
        inner = np.flatnonzero(link < len(self._links[0]))
        link, key, surface = link[inner], key[inner], surface[turned[inner]]

        # where surfaces coincide, one may lie on itself: it counts once
        several = np.flatnonzero(self._several[key])
        _, first = np.unique(key[several] * len(self.facts.sources) + surface[several], True)
        once = ~self._several[key]
        once[several[first]] = True
        return link[once], surface[once], key[once]

    @cached_property
    def _several(self) -> np.ndarray:
        """Whether several triangles of the facts have the corners of a key."""
        return np.bincount(self.matched.of_patches, minlength=self.matched.n_key) > 1

    def _times_of(self, surfaces: list[int]) -> np.ndarray:
        """Number of triangles between each pair of neighbours that lie on one of some surfaces."""
        times: np.ndarray = self._times[surfaces].sum(axis=0)

        # each set of corners counts once, however many of the surfaces have it
        wanted = np.zeros(len(self.facts.sources), dtype=bool)
        wanted[surfaces] = True
        link, surface, key = self._coinciding
        mine = np.flatnonzero(wanted[surface])
        _, first = np.unique(key[mine], return_index=True)
        again = np.delete(mine, first)
        return times - np.bincount(link[again], minlength=len(times))

    @cached_property
    def _coinciding(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Those of `_inner` that lie where surfaces coincide."""
        link, surface, key = self._inner
        several = np.flatnonzero(self._several[key])
        return link[several], surface[several], key[several]

    @cached_property
    def _all(self) -> np.ndarray:
        return self._times_of(list(range(len(self.facts.sources))))

    @cached_property
    def _level(self) -> np.ndarray:
        """Number of triangles of horizons and contacts between each pair of neighbours."""
        level = [*self.facts.rows_of("horizon"), *self.facts.rows_of("contact")]
        return self._times_of(level)

    def neighbours_except_across(self, surface: int, *, level: bool = False) -> np.ndarray:
        """Pairs of neighbours across a triangle that is not on `surface`.

        With `level`, only across horizons and contacts.
        """
        times = self._level if level else self._all
        return self._links[0][times > self._times[surface]]

    @cached_property
    def touched(self) -> np.ndarray:
        """Whether units touch front and back of each surface, bool (2, n_surface, n_unit, 2).

        First by all triangles, then by those that are not on walls.
        """
        shell, surface, behind = self.on
        out = np.zeros((2, len(self.facts.sources), self.n_unit, 2), dtype=bool)
        unit, side = self.matched.unit[shell], behind.astype(np.int64)
        out[0, surface, unit, side] = True
        walls = lie_on(self.facts, self.matched, self.facts.rows_of("wall"))
        off = ~walls[self.matched.key[shell]]
        out[1, surface[off], unit[off], side[off]] = True
        return out

    def seen(self, surfaces: list[int]) -> np.ndarray:
        """Whether front and back of a fault are reachable without crossing it, bool (n_unit, 2).

        Both are reachable from a unit that contains a part of it. A fault may have several
        surfaces: its own, and its virtual wall.
        """
        # regions: units that are connected without passing through the surfaces
        links = self._links[0][self._all > self._times_of(surfaces)]
        region = join_pairs(links, self.n_unit)
        seen = _gathered(np.logical_or.reduce(self.touched[0, surfaces]), region)
        if (seen[:, 0] != seen[:, 1]).any():
            for surface in surfaces:
                seen[np.isin(region, region[self.holding(surface)])] = True
        return seen

    def side_of_horizon(self, horizon: int, front: int) -> np.ndarray:
        """Side of a horizon that each unit is on: ABOVE, BELOW, or 0 if it is unknown.

        The side holds across all other horizons. It holds across faults for stacks of units
        without this horizon, if all stacks around them agree: as in `zones`.

        Parameters
        ----------
        horizon : int
        front : int
            The side that its front faces.
        """
        # stacks: units between which only other horizons and contacts lie share a side
        stack = join_pairs(self.neighbours_except_across(horizon, level=True), self.n_unit)
        touched = _gathered(self.touched[1, horizon], stack)
        side = front * (touched[:, 0].astype(np.int64) - touched[:, 1])
        torn = touched[:, 0] & touched[:, 1]

        # stacks that touch neither side take what all stacks across the faults say, if they agree
        links = self.neighbours_except_across(horizon)
        links = links[~torn[links].any(axis=1)]
        links = np.concatenate([links, links[:, ::-1]])  # from a known unit to an open one
        while True:
            open_ = links[(side[links[:, 0]] != 0) & (side[links[:, 1]] == 0)]
            says = np.zeros((self.n_unit, 2), dtype=bool)
            says[open_[:, 1], (side[open_[:, 0]] == BELOW).astype(np.int64)] = True
            says = _gathered(says, stack)
            new = (side == 0) & (says[:, 0] != says[:, 1])
            if not new.any():
                return side
            side[new] = np.where(says[new, 0], ABOVE, BELOW)

    def holding(self, one: int) -> np.ndarray:
        """Units that contain a part of a surface which belongs to no shell."""
        mine = self._bare[self.matched.of_patches] & (self.facts.surface_of_triangle == one)
        rows = np.flatnonzero(mine & self.facts.within)
        if len(rows) == 0:
            return np.empty(0, dtype=np.int64)

        # one ray from each connected piece is enough: a piece crosses no shell
        _, first, piece = np.unique(self._pieces(rows), return_index=True, return_inverse=True)
        set_of = np.full(len(self.matched.of_patches), -2)
        set_of[self._shell_rows] = -1
        set_of[rows] = piece.ravel()
        x, t, element, starts = self.facts.triangles_near(rows[first], set_of > -2)
        set_of = set_of[element]
        side = Rays(x, t).shoot(starts, set_of, set_of < 0)[:, 1]
        side = side[side != NO_HIT]
        row, behind = element[side // 2], side % 2 == 1
        turn = (self.matched.turn_of_patches[row] == behind).astype(np.int64)
        units = self._beside[self.matched.of_patches[row], turn]
        return distinct(units[units >= 0])

    @cached_property
    def _bare(self) -> np.ndarray:
        """Whether each triangle belongs to no shell."""
        bare = np.ones(self.matched.n_key, dtype=bool)
        bare[self.matched.key] = False
        return bare

    @cached_property
    def _shell_rows(self) -> np.ndarray:
        """Triangles of the facts that belong to shells, one per set of corners."""
        first = first_rows(self.matched.of_patches, self.matched.n_key)
        first[self._bare] = -1
        return first[first >= 0]

    def _pieces(self, rows: np.ndarray) -> np.ndarray:
        """Connected piece of each element: joined by edges that belong to no shell."""
        facts = self.facts
        n = len(facts.local)
        number = np.full(len(self.matched.of_patches), -1)
        number[rows] = np.arange(len(rows))
        is_shell = np.zeros(len(number), dtype=bool)
        is_shell[self._shell_rows] = True

        rows_here = np.flatnonzero(number[facts.element] >= 0)
        t, element = facts.triangles[rows_here], number[facts.element[rows_here]]
        used = np.zeros(n, dtype=bool)
        used[t] = True
        beside = facts.triangles[is_shell[facts.element]]
        one, two, three = (used.take(beside[:, k]) for k in range(3))
        beside = beside[(one & two) | (one & three) | (two & three)]
        edges = edge_keys(t, n)

        # edges of shells part pieces: what is on their two sides may be in two units
        edges[is_among(edges, distinct(edge_keys(beside, n)))] = -1
        order = np.argsort(edges, kind="stable")
        same = np.flatnonzero((np.diff(edges[order]) == 0) & (edges[order[1:]] >= 0))
        pairs = element[np.stack([order[same], order[same + 1]], axis=1) // 3]
        joined = number[facts.joined]
        joined = joined[(joined >= 0).all(axis=1)]
        return join_pairs(np.concatenate([pairs, joined]), len(rows))


def lie_on(facts: Facts, matched: Matched, surfaces: list[int]) -> np.ndarray:
    """Whether each key is a triangle of one of the surfaces."""
    out = np.zeros(matched.n_key, dtype=bool)
    out[matched.of_patches[np.isin(facts.surface_of_triangle, surfaces)]] = True
    return out


def _gathered(marks: np.ndarray, region: np.ndarray) -> np.ndarray:
    """Marks (n, 2), combined over all elements of each region."""
    whole = np.zeros_like(marks)
    for k in range(2):
        whole[region[marks[:, k]], k] = True
    return whole[region]


NAME = "unit names match their bounding surfaces"


def named(facts: Facts, units: Units, matched: Matched, divided: bool) -> Check:
    """Zone, block and contact in each name match the bounding surfaces of the unit.

    Blocks depend on all units of a zone; sides of faults and horizons depend on all units. These
    are only checked if units fill the box (`divided`), see `partition`.

    Merged slivers may be of other zones and contact intervals than their unit. So these are checked
    on the units before, which are called that way, and blocks on those after.
    """
    parts = list(units.values())
    faults, virtual = tuple(_faults(facts)), bool(facts.rows_of("virtual"))
    zones = names_of_zones([facts.names[i] for i in facts.rows_of("horizon")])
    wrong = [unit.name for unit in parts if not _spelt(zones, faults, virtual, unit)]
    # whether the front of each surface faces up as a whole, by its map area inside the box
    upward, merged = facts.rise >= 0.0, units.unmerged is not None
    if not merged:
        wrong += [parts[u].name for u in _in_other_zones(facts, parts, matched, upward)]

    # each side of a surface that a unit touches, once
    around = Around(facts, matched, len(parts))
    fault = list(facts.names)
    for name, rows in _faults(facts).items():
        for row in rows:
            fault[row] = name
    for surface, u, back in np.argwhere(around.touched[0]).tolist():
        if fault[surface] + ("+" if back else "-") in parts[u].fault_sides:
            wrong.append(parts[u].name)
    if divided:
        if not merged:
            wrong += [parts[u].name for u in _beyond_horizons(facts, parts, around, upward)]
        wrong += _in_other_blocks(facts, parts, around)
        wrong += _on_other_sides(facts, parts, around)
    if not merged:
        wrong += _contacts_apart(facts, parts, matched, upward)
        wrong += _offset_at_virtual(facts, parts, around)
    wrong = list(dict.fromkeys(wrong))
    detail = f"zone, block and contact of {len(parts)} units recomputed from their surfaces"
    if wrong:
        detail = f"bounding surfaces give another zone, block or contact: {', '.join(wrong[:8])}"
    return Check(NAME, not wrong, float(len(wrong)), detail)


def _in_other_blocks(facts: Facts, parts: list[Unit], around: Around) -> Iterable[str]:
    """Units whose block name differs from the recomputed sides of faults.

    The sides are recomputed from all triangles of shells: a fault separates units that touch only
    its front from units that touch only its back. Fluid contacts do not separate blocks.
    """
    blocks = dict.fromkeys((unit.zone, unit.block) for unit in parts)

    # blocks instead of units: contacts split units, not blocks
    number = {block: k for k, block in enumerate(blocks)}
    block_of_unit = np.array([number[unit.zone, unit.block] for unit in parts], dtype=np.int64)
    zones = list(dict.fromkeys(unit.zone for unit in parts))
    zone = np.array([zones.index(block_of_shell) for block_of_shell, _ in blocks], dtype=np.int64)
    matched, (shell, surface, behind) = around.matched, around.on

    # block in front and behind of each triangle, -1 outside
    inside = around.on_each_side(block_of_unit[matched.unit])[matched.key[shell]]
    apart = inside[:, 0] != inside[:, 1]  # others are slits

    # (n_surface, n_block, 2): whether a block touches the front, the back of a surface
    touched = np.zeros((len(facts.sources), len(blocks), 2), dtype=bool)
    block_of_shell = block_of_unit[matched.unit[shell[apart]]]
    touched[surface[apart], block_of_shell, behind[apart].astype(np.int64)] = True
    recomputed: list[set[str]] = [set() for _ in blocks]
    faults = _faults(facts)
    for fault, surfaces in faults.items():
        # a fault names a block that has it on one side only, if the zone has such blocks on both
        at_fault = np.logical_or.reduce(touched[surfaces])
        alone = at_fault & ~at_fault[:, ::-1]
        both = np.isin(zone, zone[alone[:, 0]]) & np.isin(zone, zone[alone[:, 1]])
        for block, side in np.argwhere(alone & both[:, None]).tolist():
            recomputed[block].add(fault + "+-"[side])
    stated = [_stated_sides(block, tuple(faults)) for _, block in blocks]
    for unit, k in zip(parts, block_of_unit.tolist(), strict=True):
        if stated[k] != recomputed[k]:
            yield unit.name


def _on_other_sides(facts: Facts, parts: list[Unit], around: Around) -> Iterable[str]:
    """Units whose `fault_sides` differ from the recomputed sides.

    The region that is reachable from a unit without crossing a fault touches only its front, or
    only its back; otherwise the fault does not bound the region.
    """
    faults = _faults(facts)
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
    facts: Facts, parts: list[Unit], around: Around, upward: np.ndarray
) -> list[int]:
    """Units that lie above the horizon at the top of their zone, or below that at its base.

    A horizon that the column removed in some unit is skipped: the rules of the column, which are
    unknown here, could extend the removal to other units.
    """
    zone = np.array([unit.zone_index for unit in parts])
    wrong = np.zeros(len(parts), dtype=bool)
    for rank, i in enumerate(facts.rows_of("horizon")):
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


def _faults(facts: Facts) -> dict[str, list[int]]:
    """Faults, and the surfaces of each: its own, and its virtual wall."""
    return separators(facts.names, [source.role for source in facts.sources])


def _in_other_zones(
    facts: Facts, parts: list[Unit], matched: Matched, upward: np.ndarray
) -> list[int]:
    """Units above a horizon in a zone below it, or the reverse.

    Where horizons coincide, the column may have removed all of them except one. Where a horizon
    lies on a wall, or on a fault or contact within one zone, the column may have removed the
    horizon, and the other surface still bounds the units.
    """
    horizons = facts.rows_of("horizon")
    zone = np.array([unit.zone_index for unit in parts])[matched.unit]

    # zone in front and behind of each set of corners, -1 where no unit is
    beside = np.full((matched.n_key, 2), -1)
    beside[matched.key, matched.turn.astype(np.int64)] = zone
    roles = ("fault", "virtual", "contact")
    others = [row for role in roles for row in facts.rows_of(role)]
    bound = lie_on(facts, matched, others) & (beside[:, 0] == beside[:, 1])
    bound |= lie_on(facts, matched, facts.rows_of("wall"))
    open_ = np.isin(matched.surface, horizons) & (matched.row >= 0) & ~bound[matched.key]
    open_ = np.flatnonzero(open_)

    # nearly all fit the only surface that they are on, so horizons do not look at them one by one
    row, level = matched.row[open_], np.full(len(facts.sources), -1)
    level[horizons] = np.arange(len(horizons))
    alone = np.bincount(matched.of_patches, minlength=matched.n_key)[matched.key[open_]] == 1
    below = (matched.turn_of_patches[row] == matched.turn[open_]) == upward[matched.surface[open_]]
    open_ = open_[~(alone & (below == (zone[open_] > level[matched.surface[open_]])))]
    if len(open_) == 0:
        return []

    # a triangle stays in `open_` if no horizon on it fits; what remains has no excuse
    order = np.argsort(facts.surface_of_triangle, kind="stable")
    cut = np.searchsorted(facts.surface_of_triangle[order], np.arange(len(facts.sources) + 1))
    turn = np.zeros(matched.n_key, dtype=np.int8)  # 1 or 2 for keys on a horizon
    for rank, i in enumerate(horizons):
        rows = order[cut[i] : cut[i + 1]]
        turn[matched.of_patches[rows]] = 1 + matched.turn_of_patches[rows]
        turned = turn[matched.key[open_]]
        turn[matched.of_patches[rows]] = 0
        below = (turned == 1 + matched.turn[open_]) == upward[i]
        open_ = open_[(turned == 0) | (below != (zone[open_] > rank))]
    return np.unique(matched.unit[open_]).tolist()


def _offset_at_virtual(facts: Facts, parts: list[Unit], around: Around) -> Iterable[str]:
    """Units that only a virtual wall separates, although zone or block differ."""
    rows = [facts.rows_of(role) for role in ("horizon", "fault", "contact", "wall")]
    only = lie_on(facts, around.matched, facts.rows_of("virtual"))
    only &= ~lie_on(facts, around.matched, [row for some in rows for row in some])

    # the units in front and behind; a wall that ends inside a unit has none
    beside = around.on_each_side(around.matched.unit)[only]
    beside = beside[(beside >= 0).all(axis=1)]
    for u, v in np.unique(beside, axis=0).tolist():
        one, two = parts[u], parts[v]
        if (one.zone, one.compartment_of) != (two.zone, two.compartment_of):
            yield from (one.name, two.name)


def _contacts_apart(
    facts: Facts, parts: list[Unit], matched: Matched, upward: np.ndarray
) -> Iterable[str]:
    """Names of units that a fluid contact separates although their names do not show it."""
    on_contacts = np.flatnonzero(
        np.isin(matched.surface, facts.rows_of("contact")) & (matched.row >= 0)
    )

    # units below a contact see it from its back, if it faces up
    below = matched.behind[on_contacts] == upward[matched.surface[on_contacts]]
    order = np.lexsort((below, matched.key[on_contacts]))  # above, then below
    on_contacts, below = on_contacts[order], below[order]

    # neighbours in this order with one key: the units above and below one triangle
    two = np.flatnonzero(matched.key[on_contacts[1:]] == matched.key[on_contacts[:-1]])
    pairs = np.stack([matched.unit[on_contacts[two]], matched.unit[on_contacts[two + 1]]], axis=1)
    for u, v in np.unique(pairs, axis=0).tolist():  # above, below
        high, low = parts[u], parts[v]
        same = (high.zone, high.block) == (low.zone, low.block) and high.contact != low.contact
        if not same or _begins(high, "below ") or _begins(low, "above "):
            yield from (high.name, low.name)


def _begins(unit: Unit, word: str) -> bool:
    """Whether a unit is the lowest or uppermost of its block; contact names may have the word."""
    return unit.contact.startswith(word) and "/" not in unit.contact
