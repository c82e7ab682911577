"""What was done to faults: extensions and truncations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.conventions import area_text, did_you_mean, known_names, length_text
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
    found: dict[str, bool | str] = dict.fromkeys(horizons, False)
    for name, way in given.items():
        if name not in found:
            raise InputError(
                f"fill_empty_blocks names {name!r}, which is not a horizon. The horizons are "
                f"{known_names(horizons, name)}"
            )
        if way is None or isinstance(way, bool):
            found[name] = bool(way)
            continue
        if way not in WAYS:
            raise InputError(f"fill_empty_blocks is {way!r}. {HOW}.{did_you_mean(way, WAYS)}")
        # Horizons are ordered youngest first: the one above comes before.
        at = horizons.index(name) + (-1 if way == UPPER else 1)
        if 0 <= at < len(horizons):
            found[name] = horizons[at]
        # Asked for this horizon: an error. Asked for all: the outermost horizon stays as it is.
        elif isinstance(fill, Mapping):
            where = "above" if way == UPPER else "below"
            raise InputError(
                f"fill_empty_blocks: no horizon lies {where} {name!r}, so it cannot be pinched out "
                f"there. Give {LOWER if way == UPPER else UPPER!r}."
            )
    # Each would wait for the other to be built first.
    for name, onto in found.items():
        if isinstance(onto, str) and found[onto] == name:
            raise InputError(
                f"fill_empty_blocks would pinch out {name!r} and {onto!r} onto each other. Change "
                "one of them."
            )
    return found


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
