"""Truncations and extensions as users give them -> checked rules, in an order that works.

A fault can only end at what is left of its main fault, so mains are truncated first. Rules that
go round in a circle have no such order, and are refused with the names of the circle. A fault may
also end at a horizon: an unconformity above it, a detachment below it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from geosurf.conventions import check_name, check_word, did_you_mean
from geosurf.errors import InputError
from geosurf.faults.rim import normals_of
from geosurf.kernels.meshes.mesh import edges, pieces, weld
from geosurf.model import TriSurface
from geosurf.model.base import in_crs_of
from geosurf.model.expected import expect, listed
from geosurf.model.network import SIDES

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
    rules_of_fault = {
        str(fault): tuple(_rule(str(fault), entry, faults, horizons) for entry in _entries(given))
        for fault, given in truncations.items()
    }
    for fault, rules in rules_of_fault.items():
        mains = [rule.main for rule in rules]
        for main in mains:
            if mains.count(main) > 1:
                raise InputError(
                    f"truncations: {fault} ends at {main} twice. Keep one of the two rules."
                )
    return tuple(rule for fault in _ordered(rules_of_fault) for rule in rules_of_fault[fault])


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
        others = f", the horizons {list(horizons)}" if len(known) > len(faults) else ""
        kind = "fault or horizon" if others else "fault"
        refusal = f"truncations name {name!r}, which is not a {kind}. The faults are"
        check_word(name, known, f"{refusal} {list(faults)}{others}.")


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
        refusal = f"{what} names {name!r}, which is not a fault. The faults are"
        check_name(name, faults, refusal)


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
        check_word(word, known, f"{what} has side {word!r}; sides are {known}.")

    # 'strike' stands for both ends; the order is that of work, not that of the words
    wanted = {"start", "end"} if "strike" in words else set()
    return tuple(side for side in SIDES if side in wanted.union(words))


# ---- halves ----------------------------------------
# Older faults that a younger one offsets: one surface becomes two halves, each a fault of its
# own.
#
# ``truncations={"F2": ("F1", "both")}`` states that F1 is younger. It is whole; F2 ends at it on
# both sides. The halves are ``F2 (1)``, on the side of the normal of F1 (its hanging wall, if it
# dips), and ``F2 (2)``. Rules for F2 hold for both halves; a half may have rules of its own.


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
    >>> halves = halves_of({"F2": ("F1", "both")}, ["F1", "F2"])
    >>> halves.names(["F1", "F2"])
    ('F1', 'F2 (1)', 'F2 (2)')
    >>> halves.truncations
    {'F2 (1)': (('F1', '+'),), 'F2 (2)': (('F1', '-'),)}
    """
    rules = {str(name): _entries(given) for name, given in truncations.items()}
    known = list(faults)
    halves: dict[str, tuple[str, ...]] = {}
    while True:
        splits = [
            (name, entry)
            for name, entries in rules.items()
            for entry in entries
            if name in known and _splits(entry) and entry[0] in known
        ]
        if not splits:
            break
        name, entry = splits[0]
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


# ---- split ----------------------------------------
# A fault mesh of several pieces -> one fault for each piece.


def split_fault(surface: TriSurface) -> dict[str, TriSurface]:
    """Return each connected piece of a fault as a fault of its own.

    Pieces are connected over common edges; vertices at one place count as one. A fault in several
    pieces divides what each piece crosses, but it cannot be extended or lengthened as a whole.

    Parameters
    ----------
    surface : TriSurface

    Returns
    -------
    dict of str to TriSurface
        ``F1 (1)``, ``F1 (2)`` ... from the largest area to the smallest, as `Scene` takes faults.
        Vertices and triangles stay as they are, in their order. A fault in one piece comes back
        under its own name.

    Raises
    ------
    InputError
        For anything that is not a TriSurface.

    Examples
    --------
    >>> corners = [[0, 0, 0], [0, 9, 0], [0, 9, 5], [0, 20, 0], [0, 24, 0], [0, 24, 5]]
    >>> parts = split_fault(TriSurface("F1", "fault", corners, [[3, 4, 5], [0, 1, 2]]))
    >>> {name: part.bounds[2:4] for name, part in parts.items()}
    {'F1 (1)': (0.0, 9.0), 'F1 (2)': (20.0, 24.0)}
    """
    expect(surface, TriSurface, "split_fault takes a TriSurface", "read_fault(path) gives one")
    x, t = surface.vertices, surface.triangles
    number, n_place = weld(x)
    at = number[t]
    piece, n_piece = pieces(at, edges(at, n_place)[0])
    if n_piece < 2:
        return {surface.name: surface}

    # the largest first; of equal ones that with the lowest coordinates
    area = np.linalg.norm(normals_of(x[t]), axis=1)
    rows = [np.flatnonzero(piece == p) for p in range(n_piece)]
    low = [tuple(x[t[mine]].min(axis=(0, 1))) for mine in rows]
    order = sorted(range(n_piece), key=lambda p: (-math.fsum(area[rows[p]]), low[p]))
    names = [f"{surface.name} ({k})" for k in range(1, n_piece + 1)]
    return {name: _part(surface, name, rows[p]) for name, p in zip(names, order, strict=True)}


def _part(surface: TriSurface, name: str, rows: np.ndarray) -> TriSurface:
    """Some triangles of a surface, with their vertices in the order as given."""
    used, t = np.unique(surface.triangles[rows], return_inverse=True)
    data = {key: values[used] for key, values in surface.vertex_data.items()}
    vertices = surface.vertices[used]
    part = TriSurface(name, surface.role, vertices, t.reshape(-1, 3), vertex_data=data)
    return in_crs_of(part, [surface])
