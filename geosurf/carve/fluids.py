"""Split units at fluid contacts: above, between and below them.

Contacts are surfaces of the arrangement like any other, so that the parts of a unit add up
to it exactly. A contact counts in the zones and blocks that it is given for, and leaves no trace
elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from geosurf.carve.blocks import WHOLE
from geosurf.carve.cells import Cells
from geosurf.carve.leaks import raise_leak
from geosurf.carve.zones import ABOVE, UNKNOWN
from geosurf.conventions import did_you_mean, place
from geosurf.errors import GeometryError, InputError
from geosurf.model import FluidContact, Patches
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
    found = set()
    rest = block.strip()
    while rest:
        fits = [side for side in sides if rest == side or rest.startswith(side + " ")]
        if not fits:
            return None
        longest = max(fits, key=len)
        found.add(longest)
        rest = rest[len(longest) :].strip()
    return frozenset(found)


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
            if zone not in zones:
                raise InputError(
                    f"fluid contact {contact.name!r}: unknown zone {zone!r}. Zones are "
                    f"{list(zones)}.{did_you_mean(zone, zones)}"
                )


def contacts_of_units(
    contacts: Sequence[FluidContact],
    zones: Sequence[str],
    words: Sequence[tuple[str, ...]],
    fault_sides: Sequence[tuple[str, ...]],
    faults: Sequence[str],
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
        if not any(_fits(contact, sides, z, on) for z, on in zip(zones, fault_sides, strict=True)):
            raise InputError(
                f"fluid contact {contact.name!r}: block {contact.block or WHOLE!r} has no unit "
                f"in {', '.join(contact.zones)}. Leave the zones out, or name a block that has "
                "them."
            )
        wanted.append(sides)
    names = list(dict.fromkeys(contact.name for contact in contacts))
    found: list[list[int]] = []
    for zone, word, on in zip(zones, words, fault_sides, strict=True):
        rows = []

        # weight: (names the zone?, (sides in the unit's name, sides in all)); compared part by part
        for name in names:
            fits = {
                row: (bool(contact.zones), (len(wanted[row] & set(word)), len(wanted[row])))
                for row, contact in enumerate(contacts)
                if contact.name == name and _fits(contact, wanted[row], zone, on)
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
        found.append(rows)
    return found


def _fits(contact: FluidContact, sides: frozenset[str], zone: str, on: Sequence[str]) -> bool:
    """Whether an entry for some sides of faults applies to a unit on other sides."""
    return sides <= set(on) and (not contact.zones or zone in contact.zones)


def _undecided(
    name: str, rivals: Sequence[FluidContact], zone: str, on: Sequence[str]
) -> InputError:
    """Return the error for two entries of which neither is more specific than the other."""
    block = " ".join(on) or WHOLE
    if any(contact.zones for contact in rivals):
        given = " and for ".join(
            f"block {contact.block or WHOLE!r} of {', '.join(contact.zones) or 'all zones'}"
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
) -> dict[str, list[int]]:
    """
    Units that no entry of a contact fits, by the name of the contact; only where there are some.

    Zones for which no contact is given are left out: that is a choice of the user.

    Examples
    --------
    >>> entries = [FluidContact(-5.0, name="GOC"), FluidContact(-9.0, block="F1+", name="OWC")]
    >>> not_reached(entries, [[0, 1], [0]], ["Top/Base", "Top/Base"])
    {'OWC': [1]}
    >>> not_reached([FluidContact(-9.0, "A/B", name="OWC")], [[0], []], ["A/B", "B/C"])
    {}
    """
    left: dict[str, list[int]] = {}

    # an entry for all zones makes every zone count
    for name in dict.fromkeys(contact.name for contact in contacts):
        mine = [contact.zones for contact in contacts if contact.name == name]
        for u, rows in enumerate(rows_of_unit):
            meant = any(not of or zones[u] in of for of in mine)
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
        mine = unit_of_cell == u
        for row in rows:
            torn = mine & (side[row] == UNKNOWN)
            if torn.any():
                raise_leak(patches, cells, level_of(patches, contacts[row]), torn)

        # (n_row, n_cell + 1), from the top down: a cell above a contact is above all lower ones
        above = side[rows] == ABOVE
        wrong = mine & (above[:-1] & ~above[1:]).any(axis=0)
        if wrong.any():
            _raise_out_of_order(patches, cells, wrong, above, [contacts[row] for row in rows])
        level[mine] = (~above).sum(axis=0)[mine]

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
