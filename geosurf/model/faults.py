"""What was done to faults, and what is proposed for them: extensions, truncations, a network."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from geosurf.conventions import area_text, length_text
from geosurf.errors import InputError
from geosurf.model.surfaces import TriSurface

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
        What it was continued to: ``"the model box"`` or a fault.
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
        return (
            f"{self.fault} ({self.side}) was extended by {length_text(self.shortest)} to "
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
        The truncated fault, and the one that it ends at.
    keep : str
        The part that is kept, as requested: ``"hanging wall"`` of the main fault ...
    side : {"+", "-"}
        The same by the normal of the main fault: ``+`` is where it points.
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
        more = (
            f", {area_text(self.coinciding_area)} of it coincident" if self.coinciding_area else ""
        )
        apart = f", {area_text(self.apart_area)} of it detached" if self.apart_area else ""
        return (
            f"{self.fault} ends at {self.main} along {length_text(self.length)}: "
            f"{area_text(self.dropped_area)} removed{more}; {area_text(self.kept_area)} in its "
            f"{self.keep} kept{apart}"
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


class RuledScene(Protocol):
    """What a fault network changes: a scene with truncations and extensions of its faults."""

    @property
    def truncations(self) -> Mapping[str, Any]:
        """Faults that end at others."""

    @property
    def extend(self) -> Mapping[str, tuple[str, ...]]:
        """Faults that are continued, and on which sides."""

    def replace(self, **changes: Any) -> Any:
        """Return a new scene with some inputs changed."""


@dataclass(frozen=True)
class FaultNetwork:
    """Every contact, near miss and dangling end of some faults, with proposals.

    Attributes
    ----------
    rows : tuple of NetworkRow
        As printed, numbered from 0.

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

    @property
    def truncations(self) -> dict[str, tuple[tuple[str, str, bool], ...]]:
        """The truncations that are proposed, as `Scene` takes them."""
        found: dict[str, tuple[tuple[str, str, bool], ...]] = {}
        for row in self.rows:
            if "truncate" in row.proposal:
                rule = (row.other, row.keep, row.proposal != "truncate")
                found[row.fault] = (*found.get(row.fault, ()), rule)
        return found

    @property
    def extend(self) -> dict[str, tuple[str, ...]]:
        """The extensions to the model box that are proposed, as `Scene` takes them."""
        found: dict[str, tuple[str, ...]] = {}
        for row in self.rows:
            if row.proposal == "extend":
                found[row.fault] = (*found.get(row.fault, ()), row.side)
        return found

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
        for number in numbers:
            if not isinstance(number, int | np.integer) or not 0 <= number < len(self.rows):
                raise InputError(
                    f"the network has no row {number!r}; rows are 0 to {len(self.rows) - 1}."
                )
        return FaultNetwork(tuple(r for i, r in enumerate(self.rows) if i not in numbers))

    def apply(self, scene: RuledScene) -> Any:
        """Return a scene with the proposals applied, in addition to its own rules.

        Parameters
        ----------
        scene : Scene

        Returns
        -------
        Scene
            Shares all results that still hold. Where the scene has truncations or an extension
            of a fault already, those stand and no proposal is added to them.
        """
        if not all(hasattr(scene, key) for key in ("replace", "truncations", "extend")):
            raise InputError(
                f"a FaultNetwork applies to a Scene, not to {type(scene).__name__}. Pass the "
                "scene that proposed it."
            )
        truncations = {**self.truncations, **scene.truncations}
        return scene.replace(truncations=truncations, extend={**self.extend, **scene.extend})

    def __repr__(self) -> str:
        """The table, one row for each contact, near miss and dangling end."""
        head = ("row", "kind", "fault", "other", "length [m]", "distance [m]", "proposal")
        cells = [head, *(_words(i, row) for i, row in enumerate(self.rows))]
        width = [max(len(line[k]) for line in cells) for k in range(len(head) - 1)]
        right = (0, 4, 5)
        lines = []
        for line in cells:
            padded = [
                cell.rjust(w) if k in right else cell.ljust(w)
                for k, (cell, w) in enumerate(zip(line[:-1], width, strict=True))
            ]
            lines.append("  ".join([*padded, line[-1]]).rstrip())
        return "\n".join(lines) if self.rows else "no contact, near miss or dangling end"


def _words(i: int, row: NetworkRow) -> tuple[str, ...]:
    """The cells of one row of the table."""
    fault = f"{row.fault} ({row.side})" if row.side else row.fault
    keep = f", keep {row.keep}" if row.keep else ""
    numbers = (f"{row.length:.1f}", f"{row.distance:.1f}")
    return (str(i), row.kind, fault, row.other, *numbers, f"{row.proposal}{keep}: {row.reason}")
