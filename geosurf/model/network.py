"""A fault network: how faults meet, miss each other and end, and proposals that can be applied.

Proposals are made for faults as they are before horizons are torn at them. Applied together they
can contradict each other, or the geometry: a fault that is truncated at one main fault no longer
reaches another. So they are tried.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from geosurf.conventions import area_text, check_name, check_word, counted, grouped, length_text
from geosurf.conventions.card import Card, small_map
from geosurf.errors import GeometryError, InputError, warn_of
from geosurf.model.base import Shown
from geosurf.model.expected import outline_of
from geosurf.model.sheets import Sheet
from geosurf.model.surfaces import TriSurface

# ---- faults ----------------------------------------
# What was done to faults: extensions and truncations.


SIDES = ("start", "end", "up", "down")


@dataclass(frozen=True)
class Extension:
    """How far one side of a fault was continued.

    Attributes
    ----------
    fault : str
    side : {"start", "end", "up", "down"}
        Start and end of strike by the right-hand rule (the fault dips to the right of who
        walks from start to end), up and down the dip.
    distance, shortest : float
        Largest and least length of the new dip or strike lines [m].
    area : float
        Area that was added [m2].
    n_triangle : int
        Triangles that were added.
    until : str
        What it was continued to: ``"the model box"``, ``"the given distance"``, or a fault.
    lines : {"own", "averaged", "filled"}
        Whether the dip or strike lines of a grid or of sticks went on as they are, or
        directions were averaged along the rim: on other meshes, and where sticks would cross.
        ``"filled"``: averaged, and notches of the rim were filled with triangles first.
    """

    fault: str
    side: str
    distance: float
    shortest: float
    area: float
    n_triangle: int
    until: str
    lines: str = "own"

    def __str__(self) -> str:
        """One sentence, as for a log."""
        # One length where the extension is even, a range where it is not.
        same = self.shortest == self.distance
        least = "" if same else f"{length_text(self.shortest)} to "
        return (
            f"{self.fault} ({self.side}) was extended by {least}"
            f"{length_text(self.distance)} until {self.until}: {area_text(self.area)}, lines: "
            f"{self.lines}"
        )


@dataclass(frozen=True, eq=False)
class ExtendedFault:
    """A fault and its continuation.

    Attributes
    ----------
    surface : TriSurface
        Vertices and triangles as given come first, bit for bit, then those that were added.
    n_given : int
        Triangles as given; all behind them were added.
    extensions : tuple of Extension
    """

    surface: TriSurface
    n_given: int
    extensions: tuple[Extension, ...]


@dataclass(frozen=True)
class Truncation:
    """What one fault lost by ending at another.

    Attributes
    ----------
    fault, main : str
        The truncated fault, and the fault or horizon that it ends at.
    keep : str
        The part that is kept, as requested: ``"hanging wall"`` of the main fault, ``"below"`` a
        horizon ...
    side : {"+", "-"}
        The same by the normal of the main fault: ``+`` is where it points; above a horizon.
    kept_area, dropped_area : float
        [m2]; of what other truncations had left of the fault.
    coinciding_area : float
        Part of `dropped_area` that lay in the main fault itself [m2].
    apart_area : float
        Part of `kept_area` in pieces that do not meet the main fault [m2].
    length : float
        Of the line along which the fault now ends at the main one [m].
    """

    fault: str
    main: str
    keep: str
    side: str
    kept_area: float
    dropped_area: float
    coinciding_area: float
    apart_area: float
    length: float

    def __str__(self) -> str:
        """One sentence, as for a log."""
        # Parts are mentioned only where there are any.
        more = (
            f", {area_text(self.coinciding_area)} of it coincident" if self.coinciding_area else ""
        )
        apart = f", {area_text(self.apart_area)} of it detached" if self.apart_area else ""
        # Walls for faults, above and below for horizons, signs for surfaces without a dip.
        part = f"in its {self.keep}"
        if self.keep in ("above", "below"):
            part = f"{self.keep} it"
        elif self.keep in ("+", "-"):
            part = f"on its {self.keep} side"
        return (
            f"{self.fault} ends at {self.main} along {length_text(self.length)}: "
            f"{area_text(self.dropped_area)} removed{more}; {area_text(self.kept_area)} "
            f"{part} kept{apart}"
        )


@dataclass(frozen=True, eq=False)
class TruncatedFaults:
    """Faults that end at each other and share vertices there.

    Attributes
    ----------
    surfaces : dict of str to TriSurface
        One for each fault; main faults are whole, with the vertices of the contacts in them.
    parents : dict of str to ndarray of int64
        For each triangle of a fault the row of the triangle that it is a part of, among those of
        the fault as it was handed to `rebuild_surfaces`. Triangles as given come first in an
        extended fault, so that rows below `ExtendedFault.n_given` are those of its input.
    truncations : tuple of Truncation
        In the order in which they were made.
    largest_move : float
        By which vertices moved where rounding broke the arrangement [m]; 0 mostly.
    cut_by_walls : bool
        Whether the faults have cuts along the walls of the model box: where none of them has to
        end there, and they are known without walls, they have none.
    """

    surfaces: dict[str, TriSurface]
    parents: dict[str, np.ndarray]
    truncations: tuple[Truncation, ...]
    largest_move: float = 0.0
    cut_by_walls: bool = False


# ---- empty blocks ----------------------------------------
# What becomes of horizons in blocks without data: refused, continued, or pinched out.


PINCH_OUT, LOWER, UPPER = "pinch out", "lower", "upper"
WAYS = (PINCH_OUT, LOWER, UPPER)
HOW = (
    "Give True to continue horizons from the neighbouring block, 'lower' or 'upper' to pinch them "
    "out onto the horizon below or above, or {horizon: one of these}"
)


def filling_by_horizon(fill: Any, horizons: Sequence[str]) -> dict[str, bool | str]:
    """
    Return what becomes of each horizon: False, True, or the horizon that it is pinched out onto.

    Parameters
    ----------
    fill : bool, str, mapping of str to bool or str, or None
    horizons : sequence of str
        Youngest first.

    Raises
    ------
    InputError
        For another value, an unknown horizon, or two that would be pinched out onto each other.

    Examples
    --------
    >>> filling_by_horizon("lower", ["Top", "Base"])
    {'Top': 'Base', 'Base': False}
    >>> filling_by_horizon({"Base": "upper"}, ["Top", "Base"])
    {'Top': False, 'Base': 'Top'}
    """
    # One word counts for all horizons; a mapping names some.
    given = fill if isinstance(fill, Mapping) else dict.fromkeys(horizons, fill)
    filling: dict[str, bool | str] = dict.fromkeys(horizons, False)
    for name, choice in given.items():
        refusal = f"fill_empty_blocks names {name!r}, which is not a horizon. The horizons are"
        check_name(name, horizons, refusal)
        if choice is None or isinstance(choice, bool):
            filling[name] = bool(choice)
            continue
        check_word(choice, WAYS, f"fill_empty_blocks is {choice!r}. {HOW}.")
        # Horizons are ordered youngest first: the one above comes before.
        at = horizons.index(name) + (-1 if choice == UPPER else 1)
        if 0 <= at < len(horizons):
            filling[name] = horizons[at]
        # Asked for this horizon: an error. Asked for all: the outermost horizon stays as it is.
        elif isinstance(fill, Mapping):
            where = "above" if choice == UPPER else "below"
            raise InputError(
                f"fill_empty_blocks: no horizon lies {where} {name!r}, so it cannot be pinched out "
                f"there. Give {LOWER if choice == UPPER else UPPER!r}."
            )
    # Each would wait for the other to be built first.
    for name, onto in filling.items():
        if isinstance(onto, str) and filling[onto] == name:
            raise InputError(
                f"fill_empty_blocks would pinch out {name!r} and {onto!r} onto each other. Change "
                "one of them."
            )
    return filling


def in_order(filling: Mapping[str, bool | str]) -> list[str]:
    """Return the horizons, each after the one that it is pinched out onto.

    Examples
    --------
    >>> in_order({"Top": "Base", "Base": False})
    ['Base', 'Top']
    """
    done: list[str] = []
    # Each pass adds the horizons whose neighbour is done; chains end, since none points back.
    while len(done) < len(filling):
        done += [
            name
            for name, onto in filling.items()
            if name not in done and (isinstance(onto, bool) or onto in done)
        ]
    return done


# ---- network rows ----------------------------------------
# Rows of a fault network: contacts, near misses and dangling ends, and what became of each.


@dataclass(frozen=True)
class NetworkRow:
    """One contact, near miss or dangling end of a fault network, with a proposal.

    Attributes
    ----------
    kind : {"contact", "near miss", "dangling end"}
    fault : str
        The fault that something is proposed for.
    other : str
        The fault that it meets or misses; empty for a dangling end.
    side : str
        Which end of `fault` is concerned (see `Extension`); empty where none is.
    length : float
        Of the crossing curve [m]; 0 where there is none.
    distance : float
        From the end to the other fault, or by which it stays inside the model box [m].
    place : (float, float, float)
        World coordinates [m] of the middle of the curve, or of the end where it is nearest.
    proposal : {"truncate", "extend then truncate", "extend", "cross", "leave"}
    keep : str
        For truncations: which part of `fault` stays.
    reason : str
    """

    kind: str
    fault: str
    other: str
    side: str
    length: float
    distance: float
    place: tuple[float, float, float]
    proposal: str
    keep: str
    reason: str

    @property
    def changes(self) -> bool:
        """Whether the proposal changes a fault: it is neither `cross` nor `leave`."""
        # Crossing faults and ends inside a block are listed for the reader; nothing is done.
        return self.proposal not in ("cross", "leave")

    @property
    def subject(self) -> tuple[str, ...]:
        """What the proposal would do: equal where two rounds propose the same."""
        # an extension is the same whatever it reaches; a truncation is, with its main fault and the
        # part that stays
        if self.proposal == "extend":
            return self.proposal, self.fault, self.side
        return self.proposal, self.fault, self.other, self.keep


@dataclass(frozen=True)
class NetworkDecision:
    """What became of one proposal.

    Attributes
    ----------
    row : NetworkRow
        The proposal.
    accepted : bool
        Whether the faults can be built with it, and with all that was accepted before.
    reason : str
        Why it was proposed; of a dropped one, why it cannot be applied.
    round : int
        1 for proposals for the faults as they came, 2 for those of the network that these give ...
    """

    row: NetworkRow
    accepted: bool
    reason: str
    round: int

    def __str__(self) -> str:
        """One sentence, as for a log."""
        word = "accepted" if self.accepted else "dropped"
        return f"{fault_words(self.row)}, {proposal_words(self.row)}: {word}, {self.reason}"


@dataclass(frozen=True, eq=False)
class NetworkTrial:
    """Every proposal for a fault network, tried: accepted, or dropped with a reason.

    Attributes
    ----------
    scene : Scene
        With all that was accepted.
    decisions : tuple of NetworkDecision
        In the order in which they were made; prints as a table.
    """

    scene: Any
    decisions: tuple[NetworkDecision, ...]

    @property
    def accepted(self) -> tuple[NetworkDecision, ...]:
        """The proposals that ``scene`` has."""
        return tuple(decision for decision in self.decisions if decision.accepted)

    @property
    def dropped(self) -> tuple[NetworkDecision, ...]:
        """The proposals that cannot be applied, each with its reason."""
        return tuple(decision for decision in self.decisions if not decision.accepted)

    def __repr__(self) -> str:
        """The table, one row for each proposal, and a line with the numbers."""
        if not self.decisions:
            return "no proposal that changes a fault"

        # columns as wide as their longest cell; the reason comes last and may be long
        # The order of questions: when, which fault, at which other, what, and what became of it.
        head = ("round", "fault", "other", "proposal", "decision: reason")
        rows = [
            (
                str(decision.round),
                fault_words(decision.row),
                decision.row.other,
                proposal_words(decision.row),
                f"{'accepted' if decision.accepted else 'dropped'}: {decision.reason}",
            )
            for decision in self.decisions
        ]

        # True: accepted, False: dropped
        count = Counter(decision.accepted for decision in self.decisions)
        table = table_of((head, *rows), right=(0,))
        return f"{table}\n{counted(count[True], 'proposal')} accepted, {count[False]} dropped"


def fault_words(row: NetworkRow) -> str:
    """The fault of a row, with its end."""
    return f"{row.fault} ({row.side})" if row.side else row.fault


def proposal_words(row: NetworkRow) -> str:
    """The proposal of a row, with the part that stays."""
    return f"{row.proposal}, keep {row.keep}" if row.keep else row.proposal


def table_of(cells: Sequence[tuple[str, ...]], right: tuple[int, ...]) -> str:
    """Lines of a table; some columns end at the right, and the last one is as wide as it is."""
    # The last column is free: reasons are sentences.
    width = [max(len(line[k]) for line in cells) for k in range(len(cells[0]) - 1)]
    lines = []
    for line in cells:
        # Numbers are aligned right, words left.
        padded = [
            cell.rjust(w) if k in right else cell.ljust(w)
            for k, (cell, w) in enumerate(zip(line[:-1], width, strict=True))
        ]
        lines.append("  ".join([*padded, line[-1]]).rstrip())
    return "\n".join(lines)


LEAST_LEFT = 0.5  # share of its area that a fault must keep where truncations are proposed


class RuledScene(Protocol):
    """What a fault network changes: a scene with truncations and extensions of its faults."""

    @property
    def fault_names(self) -> tuple[str, ...]:
        """Names of the faults."""

    @property
    def truncations(self) -> Mapping[str, Any]:
        """Faults that end at others."""

    @property
    def extend(self) -> Mapping[str, tuple[str, ...]]:
        """Faults that are continued, and on which sides."""

    @property
    def given_sheets(self) -> Mapping[str, Sheet]:
        """Horizons that were given torn."""

    def prepared_fault(self, name: str) -> TriSurface:
        """Return one fault, extended and truncated, before horizons are torn."""

    def propose_fault_network(self, *, reach: float | None = None) -> FaultNetwork:
        """Return the proposals for the faults before horizons are torn."""

    def replace(self, **changes: Any) -> Any:
        """Return a new scene with some inputs changed."""


@dataclass(frozen=True, repr=False)
class FaultNetwork(Shown):
    """Every contact, near miss and dangling end of some faults, with proposals.

    Attributes
    ----------
    rows : tuple of NetworkRow
        As printed, numbered from 0.
    reach : float or None
        Largest distance of a near miss [m], as it was requested.
    declined : tuple of NetworkRow
        Rows that `without` has taken out; `apply` does not propose them again.
    faults : tuple of TriSurface
        What `show` and the map of a notebook draw.

    Examples
    --------
    >>> row = NetworkRow(
    ...     "near miss", "F2", "F1", "end", 0.0, 12.5, (100.0, 200.0, -1500.0),
    ...     "extend then truncate", "hanging wall", "12.5 m short of F1",
    ... )
    >>> network = FaultNetwork((row,))
    >>> network.truncations
    {'F2': (('F1', 'hanging wall', True),)}
    >>> print(network)
    row  kind       fault     other  length [m]  distance [m]  proposal
      0  near miss  F2 (end)  F1            0.0          12.5  extend then truncate, keep hanging wall: 12.5 m short of F1
    """  # noqa: E501 - a table

    rows: tuple[NetworkRow, ...]
    reach: float | None = None
    declined: tuple[NetworkRow, ...] = ()
    faults: tuple[TriSurface, ...] = field(default=(), compare=False)

    @property
    def truncations(self) -> dict[str, tuple[tuple[str, str, bool], ...]]:
        """The truncations that are proposed, as `Scene` takes them."""
        # A fault may end at several others: rules are collected in the order of rows.
        cut = [row for row in self.rows if "truncate" in row.proposal]
        found = grouped((row.fault, _rule_of(row)) for row in cut)
        return {fault: tuple(rules) for fault, rules in found.items()}

    @property
    def extend(self) -> dict[str, tuple[str, ...]]:
        """The extensions to the model box that are proposed, as `Scene` takes them."""
        # "extend then truncate" is a truncation; only ends that reach the box are extended here.
        found = grouped((row.fault, row.side) for row in self.rows if row.proposal == "extend")
        return {fault: tuple(sides) for fault, sides in found.items()}

    def without(self, *numbers: int) -> FaultNetwork:
        """Return the network without some rows: proposals that are not wanted.

        Parameters
        ----------
        *numbers : int
            Numbers of rows, as the table has them.

        Raises
        ------
        InputError
            If there is no such row.
        """
        # numbers come from a printed table: a wrong one is an error, not ignored
        for number in numbers:
            if not isinstance(number, int | np.integer) or not 0 <= number < len(self.rows):
                raise InputError(
                    f"the network has no row {number!r}; rows are 0 to {len(self.rows) - 1}."
                )

        # declined rows stay known, so that a second round does not propose them again
        rows = tuple(r for i, r in enumerate(self.rows) if i not in numbers)
        out = tuple(r for i, r in enumerate(self.rows) if i in numbers)
        return FaultNetwork(rows, self.reach, (*self.declined, *out), self.faults)

    def apply(self, scene: RuledScene) -> Any:
        """Return a scene with the proposals applied, in addition to its own rules.

        Parameters
        ----------
        scene : Scene

        Returns
        -------
        Scene
            Shares all results that still hold. Rules of the scene stand: it gets those of the
            proposals in addition. A warning names the proposals that could not be
            applied; `trial` lists all of them, with reasons.
        """
        # Dropped proposals are a warning, not an error: the rest of the network still holds.
        trial = self.trial(scene)
        if trial.dropped:
            names = ", ".join(
                f"{fault_words(one.row)}{' at ' + one.row.other if one.row.other else ''}"
                for one in trial.dropped[:5]
            )
            more = f" and {len(trial.dropped) - 5} others" if len(trial.dropped) > 5 else ""
            warn_of(
                "fault network",
                "faults",
                f"{len(trial.dropped)} of {len(trial.decisions)} proposals for the fault "
                f"network cannot be applied and are dropped: {names}{more}.",
                "print(network.trial(scene)) lists them with the reasons.",
                trial.dropped[0].row.place,
            )
        return trial.scene

    def trial(self, scene: RuledScene) -> NetworkTrial:
        """Try the proposals in order, and those for the network that they give, until none is left.

        Parameters
        ----------
        scene : Scene

        Returns
        -------
        NetworkTrial
            The scene, and for each proposal whether it was accepted, with the reason.

        Raises
        ------
        InputError
            If that is not a scene, or has no fault that the network names; if a horizon was given
            torn at a fault that would change.

        Notes
        -----
        A proposal is accepted if the faults can be built with it and with all that was accepted
        before, and no fault loses more than half of its area by it. Proposals of one round are
        tried together; those that an error names are tried again one by one, after the others.

        Faults are compared as they are before horizons are torn, so no trial tears one.

        Examples
        --------
        >>> from geosurf import Scene
        >>> main = [[0, -9, 90], [0, 99, 90], [90, 99, 0], [90, -9, 0]]
        >>> stub = [[25, -9, 55], [90, -9, 55], [90, 99, 55], [25, 99, 55]]
        >>> faults = {"F1": (main, [[0, 1, 2], [0, 2, 3]]), "F2": (stub, [[0, 1, 2], [0, 2, 3]])}
        >>> scene = Scene({}, faults, (5, 80, 0, 90, 20, 80))
        >>> trial = scene.propose_fault_network().trial(scene)
        >>> trial.accepted[0].row.proposal, dict(trial.scene.truncations)
        ('truncate', {'F2': (('F1', 'hanging wall', False),)})
        """
        if not all(hasattr(scene, key) for key in ("replace", "truncations", "extend")):
            raise InputError(
                f"a FaultNetwork applies to a Scene, not to {type(scene).__name__}. Pass the "
                "scene that proposed it."
            )

        # a proposal of another scene would fail later, with a less clear message
        for name in dict.fromkeys(n for row in self.rows for n in (row.fault, row.other) if n):
            refusal = f"the network names fault {name!r}, which the scene does not have; there are"
            check_name(name, scene.fault_names, refusal, " Pass the scene that proposed it.")
            scene.prepared_fault(name)  # its own rules must work before others are added

        # rounds: truncations create new ends and contacts, which the next round judges; `known`
        # keeps a subject from being tried twice, so the loop ends
        decisions: list[NetworkDecision] = []
        known = {row.subject for row in self.declined}
        network, turn = self, 0
        while True:
            turn += 1
            fresh = [row for row in network.rows if row.changes and row.subject not in known]
            if not fresh:
                return NetworkTrial(scene, tuple(decisions))
            _require_untorn(scene, fresh)
            known |= {row.subject for row in fresh}
            scene = _tried(scene, fresh, turn, decisions)
            network = scene.propose_fault_network(reach=self.reach)

    def _repr_html_(self) -> str:
        """Return a map and the table as HTML."""
        head = ("row", "kind", "fault", "other", "length [m]", "distance [m]", "proposal")
        cells = [_words(i, row) for i, row in enumerate(self.rows)]
        title = f"FaultNetwork: {counted(len(cells), 'row')}"
        return Card(title, cells, head, picture=self._map()).html()

    def _map(self) -> str:
        """The faults at their middle elevations, and the number of each row at its place."""
        if not self.faults:
            return ""
        corners = np.concatenate([fault.vertices[:, :2] for fault in self.faults])
        bounds = np.stack([corners.min(axis=0), corners.max(axis=0)], axis=1).ravel()
        traces = {fault.name: _trace(fault) for fault in self.faults}
        places = {str(i): row.place[:2] for i, row in enumerate(self.rows)}
        return small_map(outline_of(bounds), traces, places)

    def __repr__(self) -> str:
        """The table, one row for each contact, near miss and dangling end."""
        head = ("row", "kind", "fault", "other", "length [m]", "distance [m]", "proposal")
        cells = [head, *(_words(i, row) for i, row in enumerate(self.rows))]
        # An empty network prints one line instead of a table without rows.
        none = "no contact, near miss or dangling end"
        return table_of(cells, right=(0, 4, 5)) if self.rows else none


def _words(i: int, row: NetworkRow) -> tuple[str, ...]:
    """The cells of one row of the table."""
    numbers = (f"{row.length:.1f}", f"{row.distance:.1f}")
    proposal = f"{proposal_words(row)}: {row.reason}"
    return (str(i), row.kind, fault_words(row), row.other, *numbers, proposal)


def _trace(fault: TriSurface) -> list[np.ndarray]:
    """Where a fault is at its middle elevation: a line for each of its triangles there, (2, 2)."""
    middle = 0.5 * (fault.vertices[:, 2].min() + fault.vertices[:, 2].max())
    below = (fault.vertices[:, 2] < middle)[fault.triangles]
    a = fault.vertices[fault.triangles[below.any(axis=1) & ~below.all(axis=1)]]
    b = np.roll(a, -1, axis=1)
    # two of the three edges of each triangle pass the elevation
    above, after = a[:, :, 2] - middle, b[:, :, 2] - middle
    passed = (above < 0.0) != (after < 0.0)
    share = above[passed] / (above[passed] - after[passed])
    ends = a[passed] + share[:, None] * (b[passed] - a[passed])
    return [*ends.reshape(-1, 2, 3)[:, :, :2]]


def _rule_of(row: NetworkRow) -> tuple[str, str, bool]:
    """The truncation that a row proposes, as `Scene` takes it."""
    return row.other, row.keep, row.proposal != "truncate"


# ---- proposals, tried ------------------------------------------------------------------


def _tried(
    scene: Any, rows: Sequence[NetworkRow], turn: int, decisions: list[NetworkDecision]
) -> Any:
    """A scene with all rows that can be applied; each row is added to the decisions.

    All are tried together. A row that the error names waits until the others are in; so each row
    that fails costs two trials. Where no row is named, halves are tried.
    """
    left, waiting = list(rows), []
    while left:
        # tried on a copy: replace shares all results that still hold, so a trial costs what changes
        made, error, named = _attempt(scene, left)
        if made is not None:
            # All fit together: one build for all rows.
            decisions += [NetworkDecision(row, True, row.reason, turn) for row in left]
            scene, left = made, []
        # A single row that fails is dropped with its reason.
        elif len(left) == 1:
            decisions.append(NetworkDecision(left.pop(), False, error, turn))
        else:
            row = _named_row(left, named)
            if row is None:
                # the error names no row: halves find the culprit in about 2 log2(n) trials
                middle = len(left) // 2
                for half in (left[:middle], left[middle:]):
                    scene = _tried(scene, half, turn, decisions)
                left = []
            else:
                left.remove(row)
                waiting.append(row)

    # others first: a row that failed next to another may fit once that one is in
    for row in waiting:
        scene = _tried(scene, [row], turn, decisions)
    return scene


def _require_untorn(scene: RuledScene, rows: Sequence[NetworkRow]) -> None:
    """Refuse proposals for faults at which a horizon was torn before the scene was made."""
    changed = {name for row in rows for name in (row.fault, row.other)}
    for horizon, sheet in scene.given_sheets.items():
        for fault in sheet.faults:
            if fault.name in changed:
                raise InputError(
                    f"horizon {horizon!r} is torn at fault {fault.name!r} already, and would not "
                    "fit a changed fault. Apply the proposals first, and tear then: "
                    "network.apply(Scene(horizons, faults)).replace(tear=True); in a scenario, "
                    "apply = true in [network]."
                )


def _named_row(rows: Sequence[NetworkRow], named: tuple[str, ...]) -> NetworkRow | None:
    """The last row about the faults that an error names, if there is one."""
    # a row with both named faults is the likelier cause; the last of them, as later rows weigh less
    about = [row for row in rows if row.fault in named]
    both = [row for row in about if row.other in named]
    return next(reversed(both or about), None)


def _attempt(scene: Any, rows: Sequence[NetworkRow]) -> tuple[Any, str, tuple[str, ...]]:
    """The scene with some proposals; or None, why its faults cannot be built, and which."""
    # Copies: a failed attempt leaves the rules of the scene alone.
    truncations = {name: _rules(given) for name, given in scene.truncations.items()}
    extend = dict(scene.extend)
    for row in rows:
        if row.proposal == "extend":
            extend[row.fault] = (*extend.get(row.fault, ()), row.side)

        # each pair of faults has one rule: the scene's own stands
        elif any(rule[0] == row.other for rule in truncations.get(row.fault, ())):
            words = f"the scene has a truncation of {row.fault!r} at {row.other!r} already"
            return None, words, (row.fault, row.other)
        else:
            truncations[row.fault] = (*truncations.get(row.fault, ()), _rule_of(row))

    try:
        # the new faults are built, since only geometry shows whether rules agree
        made = scene.replace(truncations=truncations, extend=extend)
        for name in made.fault_names:
            before, after = scene.prepared_fault(name), made.prepared_fault(name)
            if after is not before:
                left = _area(after) / _area(before)

                # a truncation that removes most of a fault is nearly always the wrong side
                if left < LEAST_LEFT:
                    return None, f"only {100 * left:.0f} % of {name!r} would be left", (name,)
    # Whatever the geometry refuses is the reason that the table shows.
    except (InputError, GeometryError) as error:
        return None, str(error), error.surfaces
    return made, "", ()


def _rules(given: Any) -> tuple[Any, ...]:
    """The truncations of one fault, one or several, as a tuple of them."""
    return (given,) if isinstance(given[0], str) else tuple(given)


def _area(surface: TriSurface) -> float:
    """Area of a surface [m2]."""
    corners = surface.vertices[surface.triangles]

    # fsum, so that the share does not depend on the order of triangles
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return 0.5 * math.fsum(np.linalg.norm(normals, axis=1))
