"""Compartments: which faults virtual walls continue, to where, and what came of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from geosurf.conventions import did_you_mean, is_word, known_names, length_text
from geosurf.errors import InputError
from geosurf.model.base import Noun

NEAREST, BOUNDARY = "nearest", "boundary"
EITHER = "either"  # end, of a fault that dies at one of them
ENDS = ("start", "end")  # of strike by the right-hand rule, as for `Extension`
_SUFFIX = " (virtual)"
HOW = (
    'Write compartments=True for all faults, or by fault: compartments={"F3": "boundary", '
    '"F4": "F1", "F5": {"end": "nearest"}}'
)


def virtual_name(fault: str) -> str:
    """Return what the virtual wall of a fault is called.

    Examples
    --------
    >>> virtual_name("F3")
    'F3 (virtual)'
    """
    return fault + _SUFFIX


def fault_of(surface: str) -> str:
    """Return the fault that a virtual wall continues; the name of a fault itself.

    Examples
    --------
    >>> fault_of("F3 (virtual)"), fault_of("F1")
    ('F3', 'F1')
    """
    return surface.removesuffix(_SUFFIX)


def separators(names: Sequence[str], roles: Sequence[str]) -> dict[str, list[int]]:
    """Return faults in order, and the rows of each with those of its virtual wall.

    Examples
    --------
    >>> separators(["Top", "F1", "F3", "F3 (virtual)"], ["horizon", "fault", "fault", "virtual"])
    {'F1': [1], 'F3': [2, 3]}
    """
    found: dict[str, list[int]] = {}
    for i, (name, role) in enumerate(zip(names, roles, strict=True)):
        if role in ("fault", "virtual"):
            found.setdefault(fault_of(name) if role == "virtual" else name, []).append(i)
    return found


@dataclass(frozen=True)
class VirtualWall(Noun):
    """One part of the wall that continues a fault: no rock moved there.

    Attributes
    ----------
    fault : str
    side : {"start", "end", "up", "down"}
        Of the fault, as for `Extension`.
    target : str
        The fault that it ends at, ``"boundary"``, or ``"top"`` and ``"base"`` of the model.
    length : float
        Shortest distance from the tip line to the target, at equal elevation inside the model;
        upward and downward the largest distance [m].
    area : float
        Inside the model [m2].
    place : (easting, northing, elevation)
        Where the join is shortest, on the tip line [m].
    facing : str
        Side of the target that it ends at, where two tip lines face each other; else ''.
    """

    fault: str
    side: str
    target: str
    length: float
    area: float
    place: tuple[float, float, float]
    facing: str = ""

    def __str__(self) -> str:
        """One sentence, as for a log."""
        to = {BOUNDARY: "the boundary of the model"}.get(self.target, self.target)
        if self.side in ("up", "down"):
            to = f"the {self.target} of the model"
        if self.facing:
            to += f" ({self.facing})"
        return f"{self.fault} ({self.side}) is joined to {to}: {length_text(self.length)}"


def read_compartments(given: Any, faults: Sequence[str]) -> dict[str, dict[str, str]]:
    """
    Return the faults that virtual walls continue, and where each end goes.

    Parameters
    ----------
    given : bool, sequence of str, or mapping of str to target
        A target is True or ``"nearest"``, ``"boundary"``, a fault, or these by end:
        ``{"start": "F1", "end": "boundary"}``.
    faults : sequence of str
        Names that exist.

    Returns
    -------
    dict of str to dict of str to str
        In the order of `faults`; ends that are left out are not continued. A fault as the only
        target is that of ``"either"`` end: the fault dies at one of them.

    Raises
    ------
    InputError
        For an unknown fault, end or target.

    Examples
    --------
    >>> read_compartments({"F3": "boundary", "F4": {"end": "F3"}}, ["F3", "F4"])
    {'F3': {'start': 'boundary', 'end': 'boundary'}, 'F4': {'end': 'F3'}}
    >>> read_compartments({"F4": "F3"}, ["F3", "F4"])
    {'F4': {'either': 'F3'}}
    """
    if given is None or given is False:
        return {}
    if given is True:
        given = dict.fromkeys(faults, NEAREST)
    elif isinstance(given, str):
        given = {given: NEAREST}
    elif isinstance(given, Iterable) and not isinstance(given, Mapping):
        given = dict.fromkeys(given, NEAREST)
    if not isinstance(given, Mapping):
        raise InputError(f"compartments is {given!r}. {HOW}.")
    for name in given:
        _known(name, faults, "compartments names")
    reserved = [name for name in faults if name in (NEAREST, BOUNDARY)]
    if reserved:
        raise InputError(
            f"compartments use the words {NEAREST!r} and {BOUNDARY!r}, and a fault is called "
            f"{reserved[0]!r}. Rename that fault."
        )
    return {name: _targets(name, given[name], faults) for name in faults if name in given}


def _targets(name: str, value: Any, faults: Sequence[str]) -> dict[str, str]:
    """Where each end of one fault goes."""
    ends = value if isinstance(value, Mapping) else dict.fromkeys(ENDS, value)
    if isinstance(value, str) and value not in (NEAREST, BOUNDARY):
        ends = {EITHER: value}
    found = {}
    for end, target in ends.items():
        if not is_word(end, (*ENDS, EITHER)):
            raise InputError(
                f"compartments of {name!r} has end {end!r}; the ends of a fault are 'start' and "
                f"'end'.{did_you_mean(str(end), ENDS)} {HOW}."
            )
        if target is True or (isinstance(target, str) and target == NEAREST):
            target = NEAREST
        elif not (isinstance(target, str) and target == BOUNDARY):
            _known(target, faults, f"compartments joins {name!r} to")
        if target == name:
            raise InputError(
                f"compartments joins {name!r} to itself. Name another fault, or 'boundary'."
            )
        found[end] = str(target)
    return found


def _known(name: Any, faults: Sequence[str], what: str) -> None:
    """Refuse a name that is not a fault's."""
    if name not in faults:
        raise InputError(
            f"{what} {name!r}, which is not a fault. The faults are "
            f"{known_names(faults, name)} {HOW}."
        )
