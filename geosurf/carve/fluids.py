"""Split units at fluid contacts: above, between and below them.

Contacts are surfaces of the arrangement like any other, so that the parts of a unit add up
to it exactly. A contact counts in the zones and blocks that it is given for, and leaves no trace
elsewhere.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from geosurf.carve.cells import Cells
from geosurf.carve.column import raise_leak
from geosurf.carve.measures import FLAT, VOLUME, doubtful_volume
from geosurf.carve.outside import box_of
from geosurf.carve.shells import Shells, unit_of_volume
from geosurf.carve.zones import ABOVE, UNKNOWN, WHOLE
from geosurf.conventions import check_name, did_you_mean, place
from geosurf.errors import GeometryError, InputError
from geosurf.kernels.lattices.sets import distinct
from geosurf.model import FluidContact, Patches, Unit, Units
from geosurf.model.column import separators
from geosurf.model.expected import expect, listed


def parse_sides(block: str, faults: Sequence[str]) -> frozenset[str] | None:
    """
    Take the name of a block apart: the sides of faults in it, or None for another kind of name.

    Names of faults may hold blanks.

    Examples
    --------
    >>> sorted(parse_sides("F1+ Main fault-", ["F1", "Main fault"]))
    ['F1+', 'Main fault-']
    >>> parse_sides("F9+", ["F1"]) is None
    True
    """
    return _parse_sides(block, tuple(faults))


@lru_cache(maxsize=4096)
def _parse_sides(block: str, faults: tuple[str, ...]) -> frozenset[str] | None:
    """The same; a moved contact asks for all blocks again."""
    sides = [name + sign for name in faults for sign in "+-"]
    parsed = set()
    rest = block.strip()
    while rest:
        fits = [side for side in sides if rest == side or rest.startswith(side + " ")]
        if not fits:
            return None
        longest = max(fits, key=len)
        parsed.add(longest)
        rest = rest[len(longest) :].strip()
    return frozenset(parsed)


def level_of(patches: Patches, contact: FluidContact) -> int:
    """Row of the surface of a contact; horizons and walls may have its name, too."""
    for i, source in enumerate(patches.sources):
        if source.role == "contact" and source.name == contact.surface:
            return i
    known = [source.name for source in patches.sources if source.role == "contact"]
    raise InputError(
        f"fluid contact {contact.name!r}: the patches have no contact surface "
        f"{contact.surface!r}; theirs are {known}. Rebuild the patches with the "
        "surfaces of build_contacts."
    )


def check_zones(contacts: Sequence[FluidContact], zones: Sequence[str]) -> None:
    """
    Raise an error for a contact in an unknown zone.

    Raises
    ------
    InputError

    Examples
    --------
    >>> check_zones([FluidContact(-9.0, "A/C", name="OWC")], ["above A", "A/B"])
    Traceback (most recent call last):
    geosurf.errors.InputError: fluid contact 'OWC': unknown zone 'A/C'. Zones are ['above A', 'A/B']. Did you mean 'A/B'?
    """  # noqa: E501 - a message
    how = "pass the result of build_contacts"
    takes = "carve_units takes a list of FluidContact"
    for contact in listed(contacts, takes, how):
        expect(contact, FluidContact, takes, how)
        for zone in contact.zones:
            refusal = f"fluid contact {contact.name!r}: unknown zone {zone!r}. Zones are"
            check_name(zone, zones, refusal)


def contacts_of_units(
    contacts: Sequence[FluidContact],
    zones: Sequence[str],
    words: Sequence[tuple[str, ...]],
    fault_sides: Sequence[tuple[str, ...]],
    faults: Sequence[str],
    reservoir: Sequence[str],
) -> list[list[int]]:
    """
    Rows of the contacts that apply to each unit, from the top down.

    Several entries of one name may fit a unit. Then the most specific entry applies: it names the
    zone and the most sides in the name of the unit, and among such entries the most sides.

    Parameters
    ----------
    contacts : sequence of FluidContact
        From the top down; entries of one name stand for different zones and blocks.
    zones : sequence of str
        Zone of each unit.
    words, fault_sides : sequence of tuple of str
        Sides of faults that name the block of each unit, and those that it lies on.
    faults : sequence of str
        Names of all faults.
    reservoir : sequence of str
        Zones that a contact cuts which names none.

    Returns
    -------
    list of list of int

    Raises
    ------
    InputError
        If a block has no unit, or no entry of a contact is the most specific for a unit.
    """
    # sides of faults of each entry, checked before anything is split
    wanted = []
    for contact in contacts:
        sides = parse_sides(contact.block, faults)

        # a block must exist: a misspelt one would silently split nothing
        if sides is None or not any(sides <= set(on) for on in fault_sides):
            blocks = {" ".join(word) or WHOLE for word in words}
            known = sorted(blocks.union(*fault_sides))
            raise InputError(
                f"fluid contact {contact.name!r}: no unit lies on {contact.block!r}. Name a "
                f"block or a side of a fault: {known}.{did_you_mean(contact.block, known)}"
            )

        # and the block must have one of the zones of the entry
        in_zones = contact.zones or reservoir
        if not any(_fits(in_zones, sides, z, on) for z, on in zip(zones, fault_sides, strict=True)):
            remedy = "Leave the zones out" if contact.zones else "Name the zones of the contact"
            raise InputError(
                f"fluid contact {contact.name!r}: block {contact.block or WHOLE!r} has no unit "
                f"in {', '.join(in_zones)}. {remedy}, or name a block that has them."
            )
        wanted.append(sides)
    names = list(dict.fromkeys(contact.name for contact in contacts))
    applied: list[list[int]] = []
    for zone, word, on in zip(zones, words, fault_sides, strict=True):
        rows = []

        # weight: (names the zone?, (sides in the unit's name, sides in all)); compared part by part
        for name in names:
            fits = {
                row: (bool(contact.zones), (len(wanted[row] & set(word)), len(wanted[row])))
                for row, contact in enumerate(contacts)
                if contact.name == name and _fits(contact.zones or reservoir, wanted[row], zone, on)
            }

            # the best in each part; one entry must be the best in both, or the user has to choose
            most = tuple(max(part) for part in zip(*fits.values(), strict=True))
            best = [row for row, weight in fits.items() if weight == most]

            # no single best: name the entries that compete
            if fits and len(best) != 1:
                rivals = best or [
                    next(row for row, weight in fits.items() if weight[k] == most[k])
                    for k in range(2)
                ]
                raise _undecided(name, [contacts[row] for row in rivals], zone, on)
            rows += best
        applied.append(rows)
    return applied


def _fits(zones: Sequence[str], sides: frozenset[str], zone: str, on: Sequence[str]) -> bool:
    """Whether an entry for some zones and sides of faults applies to a unit on other sides."""
    return zone in zones and sides <= set(on)


def _undecided(
    name: str, rivals: Sequence[FluidContact], zone: str, on: Sequence[str]
) -> InputError:
    """Return the error for two entries of which neither is more specific than the other."""
    block = " ".join(on) or WHOLE
    if any(contact.zones for contact in rivals):
        given = " and for ".join(
            f"block {contact.block or WHOLE!r} of {', '.join(contact.zones) or 'the reservoir'}"
            for contact in rivals
        )
        return InputError(
            f"fluid contact {name!r} has an entry for {given}, and block {block!r} of "
            f"{zone} belongs to both. Add an entry for that block and zone."
        )
    blocks = " and ".join(repr(contact.block) for contact in rivals)
    return InputError(
        f"fluid contact {name!r} has entries for the blocks {blocks}, and block "
        f"{block!r} belongs to both. Add an entry for block {block!r}."
    )


def not_reached(
    contacts: Sequence[FluidContact],
    rows_of_unit: Sequence[Sequence[int]],
    zones: Sequence[str],
    reservoir: Sequence[str],
) -> dict[str, list[int]]:
    """
    Units that no entry of a contact fits, by the name of the contact; only where there are some.

    Zones for which no contact is given are left out: that is a choice of the user. One that names
    no zones is given for the reservoir.

    Examples
    --------
    >>> entries = [FluidContact(-5.0, name="GOC"), FluidContact(-9.0, block="F1+", name="OWC")]
    >>> not_reached(entries, [[0, 1], [0]], ["Top/Base", "Top/Base"], ["Top/Base"])
    {'OWC': [1]}
    >>> zones = ["A/B", "B/C"]
    >>> not_reached([FluidContact(-9.0, "A/B", name="OWC")], [[0], []], zones, zones)
    {}
    """
    left: dict[str, list[int]] = {}

    for name in dict.fromkeys(contact.name for contact in contacts):
        mine = [contact.zones or reservoir for contact in contacts if contact.name == name]
        for u, rows in enumerate(rows_of_unit):
            meant = any(zones[u] in of for of in mine)
            if meant and not any(contacts[row].name == name for row in rows):
                left.setdefault(name, []).append(u)
    return left


def split_by_contacts(
    patches: Patches,
    cells: Cells,
    side: np.ndarray,
    contacts: Sequence[FluidContact],
    rows_of_unit: list[list[int]],
    unit_of_cell: np.ndarray,
) -> tuple[np.ndarray, list[int], list[str], list[tuple[str, ...]]]:
    """
    Split units at their contacts.

    Parameters
    ----------
    side : ndarray of int64, shape (n_contact, n_cell + 1)
        Side of each contact that each cell is on.
    contacts : sequence of FluidContact
    rows_of_unit : list of list of int
        See `contacts_of_units`.
    unit_of_cell : ndarray of int64, shape (n_cell + 1,)

    Returns
    -------
    part_of_cell : ndarray of int64, shape (n_cell + 1,)
    unit_of_part : list of int
    words : list of str
        ``above GOC``, ``GOC/OWC``, ``below OWC``; empty where no contact counts.
    beneath : list of tuple of str
        Contacts that count and lie above each part, from the top down.

    Raises
    ------
    OpenUnitError
        If a contact ends inside a unit that it counts in.
    GeometryError
        If contacts are out of order somewhere.
    """
    # number of contacts above each cell, for cells of the unit whose contacts these are
    level = np.zeros(len(unit_of_cell), dtype=np.int64)

    # unknown side: the contact has a hole there, and the intervals leak into each other
    for u, rows in enumerate(rows_of_unit):
        in_unit = unit_of_cell == u
        for row in rows:
            torn = in_unit & (side[row] == UNKNOWN)
            if torn.any():
                raise_leak(patches, cells, level_of(patches, contacts[row]), torn)

        # (n_row, n_cell + 1), from the top down: a cell above a contact is above all lower ones
        above = side[rows] == ABOVE
        wrong = in_unit & (above[:-1] & ~above[1:]).any(axis=0)
        if wrong.any():
            _raise_out_of_order(patches, cells, wrong, above, [contacts[row] for row in rows])
        level[in_unit] = (~above).sum(axis=0)[in_unit]

    # unit and level in one number: np.unique then numbers the parts, unit by unit
    n_level = len(contacts) + 1
    keys, part = np.unique(unit_of_cell[1:] * n_level + level[1:], return_inverse=True)
    unit_of_part = (keys // n_level).tolist()
    words, beneath = [], []

    # `beneath`: the contacts above the part, the first k of the unit
    for u, k in zip(unit_of_part, (keys % n_level).tolist(), strict=True):
        names = [contacts[row].name for row in rows_of_unit[u]]
        words.append(interval(names, k))
        beneath.append(tuple(names[:k]))
    return np.concatenate([[-1], part]), unit_of_part, words, beneath


def interval(names: list[str], level: int) -> str:
    """Name what is below some contacts of a unit and above the others; '' without contacts.

    Examples
    --------
    >>> [interval(["GOC", "OWC"], k) for k in range(3)]
    ['above GOC', 'GOC/OWC', 'below OWC']
    """
    if not names:
        return ""
    if level == 0:
        return f"above {names[0]}"
    if level == len(names):
        return f"below {names[-1]}"
    return f"{names[level - 1]}/{names[level]}"


def _raise_out_of_order(
    patches: Patches, cells: Cells, wrong: np.ndarray, above: np.ndarray, contacts: Sequence[Any]
) -> None:
    cells = cells.in_full
    cell = int(np.flatnonzero(wrong)[0])
    k = int(np.flatnonzero(above[:-1, cell] & ~above[1:, cell])[0])
    rows = (cells.cell_of_side == cell).any(axis=1)
    middle = patches.local[cells.triangles[rows]].mean(axis=(0, 1)) + patches.origin
    upper, lower = contacts[k].name, contacts[k + 1].name
    raise GeometryError(
        f"fluid contact {upper!r} lies below {lower!r} at {place(middle)}. List "
        "contacts from the top down; they must not cross inside units.",
        place=middle,
        surfaces=(contacts[k].surface, contacts[k + 1].surface),
    )


# ---- level parts ----------------------------------------
# Volumes of the parts that level fluid contacts make of finished units.
#
# A level cuts no surface here: each face of a unit has a volume above the level and one below it,
# and a moved contact passes over the faces that it crosses. Which parts exist follows from the
# heights of the units, since each unit is connected. Where rounding could decide that,
# `carve_units` has to do it, with the contacts among the surfaces.


_SURE = 2.0**20  # times a small volume: what its terms may sum up to, all taken as positive
_STEPS = 4096  # units in the last place of coordinates: nearer levels are left to the arrangement
_RANK = re.compile(r" #\d+$")


@dataclass(frozen=True)
class _Wholes:
    """What no contact changes of some units: kept with them, since contacts move often.

    Attributes
    ----------
    units : list of Unit
    faults : list of str
    zones : list of str
    words, on : list of tuple of str
        Sides of faults that name the block of each unit, and those that it lies on.
    ends : list of (float, float)
        Lowest and highest local elevation of each unit [m].
    margin, doubtful : float
        How near a level rounding may decide [m], and up to which volume [m3].
    """

    units: list[Unit]
    faults: list[str]
    zones: list[str]
    words: list[tuple[str, ...]]
    on: list[tuple[str, ...]]
    ends: list[tuple[float, float]]
    margin: float
    doubtful: float

    @classmethod
    def of(cls, patches: Patches, units: Units) -> _Wholes:
        """Return those of units, which are of these patches."""
        known: _Wholes | None = units.__dict__.get("_wholes")
        if known is not None:
            return known
        faults = list(separators(patches.names, [source.role for source in patches.sources]))
        listed, bounds = list(units.values()), box_of(patches)
        shells = [unit.__dict__["_shell"] for unit in listed]
        wholes = units.__dict__["_wholes"] = cls(
            listed, faults,
            [unit.zone for unit in listed],
            [_words(unit.block, faults) for unit in listed],
            [unit.fault_sides for unit in listed],
            [of.heights(row) for of, row in shells],
            _STEPS * float(np.spacing(np.abs(bounds).max())), doubtful_volume(bounds),
        )  # fmt: skip
        return wholes


@dataclass(frozen=True)
class _Split:
    """A unit, its contacts from the top down, how many lie above it, and those that cut it."""

    unit: Unit
    row: int
    names: list[str]
    first: int
    cuts: list[float]


def parts_at_levels(
    patches: Patches, units: Units, contacts: Sequence[FluidContact]
) -> Units | None:
    """
    Return the parts of units above, between and below level contacts: names, labels and volumes.

    Parameters
    ----------
    patches : Patches
    units : Units
        Of these patches, without contacts.
    contacts : sequence of FluidContact
        From the top down, each with an elevation as ``at``.

    Returns
    -------
    Units or None
        In the order and with the names of `carve_units`. None where a contact is within rounding
        error of the highest or lowest point of a unit, where contacts of a unit are out of order,
        where a part is so small against its terms that its volume needs exact arithmetic, and for
        contacts that `carve_units` refuses.

    Examples
    --------
    >>> from geosurf import TriSurface, build_contacts, build_walls, carve_units, rebuild_surfaces
    >>> box = (0, 10, 0, 10, -10, 0)
    >>> corners = [[-1, -1, -4], [11, -1, -4], [11, 11, -4], [-1, 11, -4]]
    >>> top = TriSurface("Top", "horizon", corners, [[0, 1, 2], [0, 2, 3]])
    >>> patches = rebuild_surfaces([top, *build_walls(box)])
    >>> _, contacts = build_contacts({"OWC": -6.0}, box)
    >>> parts = parts_at_levels(patches, carve_units(patches), contacts)
    >>> {name: round(unit.volume, 9) for name, unit in parts.items()}
    {'above Top above OWC': 400.0, 'below Top above OWC': 200.0, 'below Top below OWC': 400.0}
    """
    wholes = _Wholes.of(patches, units)
    splits = _splits(wholes, contacts, float(patches.origin[2]), units.reservoir)
    if splits is None or not splits:
        return None
    shells: Shells = wholes.units[0].__dict__["_shell"][0]
    volumes = _volumes(shells, splits, wholes.doubtful)
    if volumes is None:
        return None
    parts = [
        unit_of_volume(
            split.unit, interval(split.names, split.first + k),
            tuple(split.names[: split.first + k]), volume,
        )
        for split, of in zip(splits, volumes, strict=True)
        for k, volume in enumerate(of)
    ]  # fmt: skip
    w, e, s, n, low, high = units.box
    divided = Units(
        parts, (w, e, s, n, low, high), footprint=units.footprint, slivers=units.sliver_settings,
        reservoir=units.reservoir,
    )  # fmt: skip
    divided._regions = units._regions
    return divided


def _splits(
    wholes: _Wholes, contacts: Sequence[FluidContact], origin: float, reservoir: Sequence[str]
) -> list[_Split] | None:
    """What contacts do to each unit; None where rounding could decide it."""
    places = wholes.zones, wholes.words, wholes.on, wholes.faults
    try:
        applied = contacts_of_units(contacts, *places, reservoir)
    except InputError:  # of several blocks to name, `carve_units` names the one it comes to first
        return None

    margin, splits = wholes.margin, []
    for unit, rows, (lowest, highest) in zip(wholes.units, applied, wholes.ends, strict=True):
        levels = [float(contacts[k].at) - origin for k in rows]
        if any(low >= high - margin for high, low in pairwise(levels)):
            return None
        if any(min(abs(level - lowest), abs(level - highest)) <= margin for level in levels):
            return None
        cuts = [level for level in levels if lowest < level < highest]
        first = sum(level > highest for level in levels)
        row = unit.__dict__["_shell"][1]
        splits.append(_Split(unit, row, [contacts[k].name for k in rows], first, cuts))
    return splits


def _words(block: str, faults: Sequence[str]) -> tuple[str, ...]:
    """The sides of faults that name a block.

    Examples
    --------
    >>> sorted(_words("F1+ F2- #2", ["F1", "F2"])), _words("whole", ["F1"])
    (['F1+', 'F2-'], ())
    """
    sides = parse_sides("" if block == WHOLE else block, faults)
    if sides is None:  # the second block with these sides has a number
        rest = _RANK.sub("", block)
        sides = parse_sides("" if rest == WHOLE else rest, faults)
    return tuple(sides or ())


def _volumes(shells: Shells, splits: Sequence[_Split], doubtful: float) -> list[list[float]] | None:
    """Volumes of the parts of each unit, from the top down [m3]; None where rounding may matter.

    Up to a `doubtful` volume a part counts only if its terms are small as well: exact arithmetic
    has to find small sums of large terms.
    """
    by_level: dict[float, np.ndarray] = {}
    for level in sorted({level for split in splits for level in split.cuts}):
        cut = [shells.faces(split.row) for split in splits if level in split.cuts]
        by_level[level] = _beside(shells, distinct(*cut), level)

    volumes_of_parts = []
    for split in splits:
        if not split.cuts:
            volumes_of_parts.append([split.unit.volume])
            continue
        rows = shells.faces(split.row)
        sign = np.where(shells.sides[rows, 1] == split.row, 1.0, -1.0)[:, None]
        above = [sign * by_level[level][0, rows] for level in split.cuts]
        lowest = by_level[split.cuts[-1]]
        below = sign * lowest[1, rows]

        # what is above each contact, less what is above the one over it; then the lowest part
        sums = [above[0], *(np.hstack([b, -a]) for a, b in pairwise(above)), below]
        volumes = [math.fsum(part.ravel().tolist()) / 6.0 for part in sums]
        for volume, part in zip(volumes, sums, strict=True):
            if volume <= doubtful and volume * _SURE <= np.abs(part).sum() / 6.0:
                return None
        volumes_of_parts.append(volumes)
    return volumes_of_parts


def _beside(shells: Shells, faces: np.ndarray, level: float) -> np.ndarray:
    """Six times the volume of some faces above a level (five numbers, to be added) and below it.

    Faces that the level does not cross follow from the volume below them that is known.
    """
    cells = shells.cells
    volumes = np.zeros((2, len(cells.surface_of), 5))
    low, high = cells.heights[faces].T
    for k, some in enumerate((faces[low >= level], faces[high <= level])):
        shift = 3.0 * (cells.level - level) * cells.sums[some, FLAT]
        volumes[k, some] = np.column_stack([cells.sums[some, VOLUME], shift])

    rows = np.zeros(len(cells.surface_of), dtype=bool)
    rows[faces[(low < level) & (high > level)]] = True
    for k, part in enumerate(cells.beside_level(rows, level)):
        volumes[k, rows, :2] = part[rows]
    return volumes
