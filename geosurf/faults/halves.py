"""Older faults that a younger one offsets: one surface becomes two halves, each a fault of its own.

``truncations={"F2": ("F1", "both")}`` states that F1 is younger. It is whole; F2 ends at it on both
sides. The halves are ``F2 (1)``, on the side of the normal of F1 (its hanging wall, if it dips),
and ``F2 (2)``. Rules for F2 hold for both halves; a half may have rules of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from geosurf.errors import InputError

BOTH = "both"
SIDES_OF_HALVES = ("+", "-")


@dataclass(frozen=True)
class Halves:
    """Which faults are split, and the truncations of their halves.

    Attributes
    ----------
    parts : dict of str to tuple of str
        Fault as given -> its halves, or quarters where these are split again.
    truncations : dict of str to rules
        As for `Scene`, without ``"both"``.
    """

    parts: dict[str, tuple[str, ...]]
    truncations: dict[str, Any]

    def whole_of(self, name: str) -> str:
        """Name of the fault as given that a half is a part of; else the name itself."""
        return next((whole for whole, parts in self.parts.items() if name in parts), name)

    def names(self, faults: Sequence[str]) -> tuple[str, ...]:
        """Names of the faults with halves in the place of those that are split."""
        return tuple(part for name in faults for part in self.parts.get(name, (name,)))

    def spread(self, entries: Any) -> Any:
        """A mapping, list or single name by fault, with halves in the place of what is split.

        What is stated for one half beats what is stated for the whole.
        """
        if isinstance(entries, str):
            return self.parts.get(entries, entries)
        if isinstance(entries, Mapping):
            wide = {
                part: value for name, value in entries.items() for part in self.parts.get(name, ())
            }
            own = {name: value for name, value in entries.items() if name not in self.parts}
            return {**wide, **own}
        if isinstance(entries, list | tuple):
            return tuple(part for name in entries for part in self._parts_of(name))
        return entries

    def _parts_of(self, name: Any) -> tuple[Any, ...]:
        """The halves of a fault, or the fault."""
        return self.parts.get(name, (name,)) if isinstance(name, str) else (name,)


def halves_of(truncations: Mapping[str, Any], faults: Sequence[str]) -> Halves:
    """Return truncations with two halves for each fault that ends at another one on both sides.

    Parameters
    ----------
    truncations : mapping of str to rules
        As for `Scene`; rules that cannot be read stay as they are.
    faults : sequence of str
        Names of the faults as given.

    Raises
    ------
    InputError
        If a half has the name of a fault, or a fault is to end at one that is split.

    Examples
    --------
    >>> found = halves_of({"F2": ("F1", "both")}, ["F1", "F2"])
    >>> found.names(["F1", "F2"])
    ('F1', 'F2 (1)', 'F2 (2)')
    >>> found.truncations
    {'F2 (1)': (('F1', '+'),), 'F2 (2)': (('F1', '-'),)}
    """
    rules = {str(name): _entries(given) for name, given in truncations.items()}
    known = list(faults)
    halves: dict[str, tuple[str, ...]] = {}
    while True:
        found = [
            (name, entry)
            for name, entries in rules.items()
            for entry in entries
            if name in known and _splits(entry) and entry[0] in known
        ]
        if not found:
            break
        name, entry = found[0]
        others = tuple(one for one in rules.pop(name) if one is not entry)
        halves[name] = tuple(f"{name} ({k})" for k in (1, 2))
        for half, side in zip(halves[name], SIDES_OF_HALVES, strict=True):
            if half in known:
                raise InputError(
                    f"fault {name!r} is split by {entry[0]!r}, and its half would be called "
                    f"{half!r} as another fault is. Rename that one."
                )
            rules[half] = (*others, (entry[0], side, *entry[2:]), *rules.get(half, ()))
            known.append(half)
        known.remove(name)

    if not halves:
        return Halves({}, dict(truncations))
    _refuse_split_mains(rules, halves)
    return Halves({name: _leaves(name, halves) for name in faults if name in halves}, rules)


def _entries(given: Any) -> tuple[Any, ...]:
    """The rules of one fault, one or several, as a tuple."""
    many = isinstance(given, list | tuple) and given and not isinstance(given[0], str)
    return tuple(given) if many else (given,)


def _splits(entry: Any) -> bool:
    """Whether a rule keeps both parts."""
    return isinstance(entry, list | tuple) and len(entry) in (2, 3) and entry[1] == BOTH


def _refuse_split_mains(
    rules: Mapping[str, tuple[Any, ...]], halves: Mapping[str, tuple[str, ...]]
) -> None:
    """Refuse to let a fault end at one that is split: at which half?"""
    for name, entries in rules.items():
        for entry in entries:
            main = entry[0] if isinstance(entry, list | tuple) and entry else None
            if isinstance(main, str) and main in halves:
                raise InputError(
                    f"truncations: {name} ends at {main!r}, which is split into "
                    f"{' and '.join(map(repr, halves[main]))}. Name the half that it ends at."
                )


def _leaves(name: str, halves: Mapping[str, tuple[str, ...]]) -> tuple[str, ...]:
    """The parts of a fault that are not split again."""
    if name not in halves:
        return (name,)
    return tuple(leaf for half in halves[name] for leaf in _leaves(half, halves))
