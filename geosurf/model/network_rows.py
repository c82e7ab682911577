"""Rows of a fault network: contacts, near misses and dangling ends, and what became of each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from geosurf.conventions import counted


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
        return tuple(one for one in self.decisions if one.accepted)

    @property
    def dropped(self) -> tuple[NetworkDecision, ...]:
        """The proposals that cannot be applied, each with its reason."""
        return tuple(one for one in self.decisions if not one.accepted)

    def __repr__(self) -> str:
        """The table, one row for each proposal, and a line with the numbers."""
        if not self.decisions:
            return "no proposal that changes a fault"

        # columns as wide as their longest cell; the reason comes last and may be long
        # The order of questions: when, which fault, at which other, what, and what became of it.
        head = ("round", "fault", "other", "proposal", "decision: reason")
        rows = [
            (
                str(one.round),
                fault_words(one.row),
                one.row.other,
                proposal_words(one.row),
                f"{'accepted' if one.accepted else 'dropped'}: {one.reason}",
            )
            for one in self.decisions
        ]

        # True: accepted, False: dropped
        count = Counter(one.accepted for one in self.decisions)
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
