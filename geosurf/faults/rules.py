"""Truncations and extensions as users give them -> checked rules, in an order that works.

A fault can only end at what is left of its main fault, so mains are truncated first. Rules that
go round in a circle have no such order, and are refused with the names of the circle. A fault may
also end at a horizon: an unconformity above it, a detachment below it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from geosurf.conventions import did_you_mean, is_word, known_names
from geosurf.errors import InputError
from geosurf.model.expected import listed
from geosurf.model.faults import SIDES

KEEP = ("hanging wall", "footwall", "right", "left", "+", "-", "above", "below")
LEVELS = ("above", "below")  # parts of a fault that ends at a horizon
ALL_SIDES = ("strike", "up", "down")
_HOW = "Give truncations={'F2': ('F1', 'hanging wall')}: F2 ends at F1, that part stays."


@dataclass(frozen=True)
class Rule:
    """One truncation: `fault` ends at `main`, and the part `keep` of it stays.

    Attributes
    ----------
    fault, main : str
        The main one is a fault or a horizon.
    keep : str
        One of `KEEP`: hanging wall and footwall of the main fault; right and left of its strike
        (right-hand rule), for those that are vertical; the side of its normal; or above and below
        it. At a horizon one of `LEVELS`.
    extend : bool
        Whether the fault is first continued beyond the main one from its nearest side.
    """

    fault: str
    main: str
    keep: str
    extend: bool = False


def part_in_words(rule: Rule) -> str:
    """Return where the part lies that a rule keeps.

    Examples
    --------
    >>> part_in_words(Rule("F2", "F1", "footwall")), part_in_words(Rule("F2", "Top", "below"))
    ("in the footwall of 'F1'", "below 'Top'")
    """
    if rule.keep in LEVELS:
        return f"{rule.keep} {rule.main!r}"
    if rule.keep in ("+", "-"):
        return f"on the {rule.keep} side of {rule.main!r}"
    return f"in the {rule.keep} of {rule.main!r}"


def read_truncations(
    truncations: Any, faults: Sequence[str] | None = None, horizons: Sequence[str] = ()
) -> tuple[Rule, ...]:
    """Check truncations, and order them so that main faults come first.

    Parameters
    ----------
    truncations : mapping of str to (main, keep) or (main, keep, extend), or several of these
        What each truncated fault ends at. `keep` is ``"hanging wall"``, ``"footwall"``,
        ``"right"``, ``"left"``, ``"+"``, ``"-"``, ``"above"`` or ``"below"`` of the main fault;
        ``"above"`` or ``"below"`` of a horizon.
    faults : sequence of str, optional
        Names that exist. Default: any.
    horizons : sequence of str
        Names of the horizons at which faults may end.

    Returns
    -------
    tuple of Rule
        By fault; a fault comes after all that it ends at. Otherwise by name, whatever the order
        in which they were given.

    Raises
    ------
    InputError
        For a rule of another form, an unknown name, or faults that truncate each other in a
        circle (with their names).

    Examples
    --------
    >>> rules = read_truncations({"A": ("B", "footwall"), "B": ("C", "+", True)})
    >>> [(rule.fault, rule.main) for rule in rules]
    [('B', 'C'), ('A', 'B')]
    >>> read_truncations({"A": ("B", "footwall"), "B": ("A", "footwall")})
    Traceback (most recent call last):
    geosurf.errors.InputError: truncations form a circle: A ends at B, B ends at A. Leave out one of them.
    """  # noqa: E501 - a message
    if not isinstance(truncations, Mapping):
        raise InputError(f"truncations is a {type(truncations).__name__}, not a mapping. {_HOW}")
    found = {
        str(fault): tuple(_rule(str(fault), entry, faults, horizons) for entry in _entries(given))
        for fault, given in truncations.items()
    }
    for fault, rules in found.items():
        mains = [rule.main for rule in rules]
        for main in mains:
            if mains.count(main) > 1:
                raise InputError(
                    f"truncations: {fault} ends at {main} twice. Keep one of the two rules."
                )
    return tuple(rule for fault in _ordered(found) for rule in found[fault])


def _entries(given: Any) -> Sequence[Any]:
    """One rule, or several."""
    many = isinstance(given, list | tuple) and given and not isinstance(given[0], str)
    return given if many else (given,)


def _rule(fault: str, entry: Any, faults: Sequence[str] | None, horizons: Sequence[str]) -> Rule:
    """One checked rule, or an InputError that names what is wrong with it."""
    if not isinstance(entry, list | tuple) or len(entry) not in (2, 3):
        raise InputError(f"truncations: {entry!r} is not a rule for {fault!r}. {_HOW}")
    main, keep, extend = (*entry, False)[:3]
    _refuse_unknown(fault, main, faults, horizons)
    if keep not in KEEP:
        words = LEVELS if main in horizons else KEEP
        raise InputError(
            f"truncations: {fault} is to keep {keep!r} of {main}; it can keep "
            f"{', '.join(map(repr, words[:-1]))} or {words[-1]!r}.{did_you_mean(str(keep), words)}"
        )
    if main in horizons and keep not in LEVELS:
        raise InputError(
            f"truncations: {fault} ends at horizon {main!r} and keeps {keep!r}; at a horizon it "
            f"keeps 'below' or 'above': {{{fault!r}: ({main!r}, 'below')}}."
        )
    if not isinstance(extend, bool):
        raise InputError(
            f"truncations: the third word for {fault} is {extend!r}; it is True where the fault is "
            "to be extended to its main fault first, or left out."
        )
    return Rule(fault, str(main), keep, extend)


def _refuse_unknown(
    fault: str, main: Any, faults: Sequence[str] | None, horizons: Sequence[str]
) -> None:
    """Refuse names that are not of a fault, or for the main one of a fault or a horizon."""
    if faults is None:
        return
    if fault in horizons:
        raise InputError(
            f"truncations name {fault!r}, which is a horizon and cannot end at {main!r}. Horizons "
            "that cross follow the rules of the column: column={...}."
        )
    for name, known in ((fault, faults), (main, [*faults, *horizons])):
        if name not in known:
            others = f", the horizons {list(horizons)}" if len(known) > len(faults) else ""
            raise InputError(
                f"truncations name {name!r}, which is not a fault{' or horizon' if others else ''}."
                f" The faults are {list(faults)}{others}.{did_you_mean(str(name), known)}"
            )


def _ordered(rules: Mapping[str, tuple[Rule, ...]]) -> list[str]:
    """Truncated faults, each after those that it ends at; by name where that leaves a choice."""
    left, order = sorted(rules), []

    # topological order; faults in `left` that wait for nothing are taken by name
    while left:
        ready = [f for f in left if not any(r.main in left for r in rules[f])]
        if not ready:
            raise InputError(
                f"truncations form a circle: {_circle(rules, left)}. Leave out one of them."
            )
        order.append(ready[0])
        left.remove(ready[0])
    return order


def _circle(rules: Mapping[str, tuple[Rule, ...]], left: list[str]) -> str:
    """Name one circle among faults none of which can come first."""
    path = [left[0]]

    # each fault left has a main that is left, so the walk must come back to itself
    while True:
        onward = next(rule.main for rule in rules[path[-1]] if rule.main in left)
        if onward in path:
            ring = [*path[path.index(onward) :], onward]
            return ", ".join(f"{a} ends at {b}" for a, b in pairwise(ring))
        path.append(onward)


def faults_at(horizon: str, horizons: Sequence[str], rules: Iterable[Rule]) -> set[str]:
    """Return the faults that end at a horizon, or at another one before they reach this one.

    Parameters
    ----------
    horizon : str
    horizons : sequence of str
        All of them, youngest first.
    rules : iterable of Rule
        Others than those at horizons do not count.

    Examples
    --------
    >>> rules = [Rule("F1", "Unconformity", "below"), Rule("F2", "Detachment", "above")]
    >>> column = ["Top", "Unconformity", "Base", "Detachment"]
    >>> [sorted(faults_at(name, column, rules)) for name in column]
    [['F1'], ['F1'], [], ['F2']]
    """
    rank = list(horizons).index(horizon)
    return {
        rule.fault
        for rule in rules
        if rule.main in horizons
        and (
            rank <= list(horizons).index(rule.main)
            if rule.keep == "below"
            else rank >= list(horizons).index(rule.main)
        )
    }


def read_extend(extend: Any, faults: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Check which faults are to be extended, and on which sides.

    Parameters
    ----------
    extend : bool, sequence of str, or mapping of str to sides
        True for all faults; names; or the sides of each, any of ``"strike"`` (both ends),
        ``"start"``, ``"end"``, ``"up"``, ``"down"``.
    faults : sequence of str
        Names that exist.

    Returns
    -------
    dict of str to tuple of str
        In the order of `faults`.

    Raises
    ------
    InputError
        For an unknown name or side.

    Examples
    --------
    >>> read_extend(["F1"], ["F1", "F2"])
    {'F1': ('start', 'end', 'up', 'down')}
    """
    if isinstance(extend, bool):
        extend = tuple(faults) if extend else ()
    if isinstance(extend, str):
        extend = (extend,)
    if extend is None:
        extend = ()
    if not isinstance(extend, Iterable):
        raise InputError(
            f"extend is {extend!r}; give True, names of faults, or {{name: sides}}, any of "
            f"{('strike', *SIDES)}."
        )

    # names alone mean all sides; `ALL_SIDES` orders strike before dip, which fills the corners
    sides_of = extend if isinstance(extend, Mapping) else dict.fromkeys(extend, ALL_SIDES)
    read_names(sides_of, "extend", faults)
    return {
        name: read_sides(sides_of[name], f"extend of {name!r}")
        for name in faults
        if name in sides_of
    }


def read_names(names: Iterable[Any], what: str, faults: Sequence[str]) -> None:
    """Refuse a name that is not a fault's."""
    for name in names:
        if name not in faults:
            raise InputError(
                f"{what} names {name!r}, which is not a fault. The faults are "
                f"{known_names(faults, name)}"
            )


def read_sides(sides: Any, what: str) -> tuple[str, ...]:
    """Return the sides that some words name, in the order in which they are continued.

    Examples
    --------
    >>> read_sides(["down", "strike"], "extend of 'F1'")
    ('start', 'end', 'down')
    """
    known = ("strike", *SIDES)
    if not isinstance(sides, Iterable):
        raise InputError(f"{what} is {sides!r}; give any of {known}.")
    words = (sides,) if isinstance(sides, str) else listed(sides, f"{what} are words", "list them")
    for word in words:
        if not is_word(word, known):
            raise InputError(
                f"{what} has side {word!r}; sides are {known}.{did_you_mean(str(word), known)}"
            )

    # 'strike' stands for both ends; the order is that of work, not that of the words
    wanted = {"start", "end"} if "strike" in words else set()
    return tuple(side for side in SIDES if side in wanted.union(words))
