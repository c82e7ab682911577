"""What one file holds, and what is made of it."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import METRES_PER_UNIT

NO_POINTS = np.empty((0, 3))
OUT = "left out"


@dataclass
class Found:
    """
    One object in a file.

    Attributes
    ----------
    path : pathlib.Path
    kind : {"horizon", "fault", "polygons", "contact", "tops", "outline", "model", "left out"}
    form : str
        What the file holds: ``"grid"``, ``"points"``, ``"sticks"``, ``"mesh"`` ...
    note : str
        How that was recognised, or why the file is left out.
    name : str
    points : ndarray of float64, shape (n, 3)
        Easting and northing [m], z as in the file unless `states_direction`.
    parts : list of ndarray
        Of fault polygons: their points.
    states_direction, states_unit : bool
        Whether the file itself states them; then `points` has elevations, or metres.
    header : str
        The first line of a table.
    positive, length_unit : str or None
        As they are written into the scenario.
    data : object
        What the reader has returned, for faults.
    in_file : str
        Its name in a file with several objects, else ''.
    piece : int
        Of a mesh in several pieces, counted from 1; 0 for a whole one.
    why : str
        Reason of `length_unit`, for a comment.
    asks : list of (str, str)
        Open questions: the line of the scenario that answers it, and the question.
    """

    path: Path
    kind: str
    form: str = ""
    note: str = ""
    name: str = ""
    # A factory, because arrays cannot be defaults; all share one empty array.
    points: np.ndarray = field(default_factory=lambda: NO_POINTS)
    states_direction: bool = False
    states_unit: bool = False
    parts: list[np.ndarray] = field(default_factory=list)
    header: str = ""
    positive: str | None = None
    length_unit: str | None = None
    data: Any = None
    in_file: str = ""
    piece: int = 0
    why: str = ""
    asks: list[tuple[str, str]] = field(default_factory=list)

    @property
    def elevations(self) -> np.ndarray:
        """Points with elevations [m], as far as direction and unit are known."""
        # Only z is scaled: map coordinates are metres in all formats.
        return self.points * [1.0, 1.0, self.scale]

    @property
    def scale(self) -> float:
        """What z as it was read is multiplied by to give elevations [m]."""
        # Metres unless something says otherwise: the run warns of it.
        scale = 1.0 if self.states_unit else METRES_PER_UNIT[self.length_unit or "m"]
        return -scale if not self.states_direction and self.positive == "down" else scale

    def leave_out(self, reason: str) -> None:
        """Keep the file out of the model, for a reason."""
        # Files that are not used stay in the list: the scenario names each with the reason.
        self.kind, self.note = OUT, reason


@dataclass(frozen=True)
class Question:
    """What the files do not state: the line of the scenario, and whether a run needs the answer."""

    line: int
    text: str
    stops: bool = False


def name_from(path: Path) -> str:
    """A name from a file name: without suffix and leading number.

    Examples
    --------
    >>> name_from(Path("01_topreek.gri")), name_from(Path("7.gri"))
    ('topreek', '7')
    """
    name = re.sub(r"^\d+[\s_.-]+", "", path.stem).strip()
    return " ".join((name or path.stem).split())


__all__ = ["NO_POINTS", "OUT", "Found", "Question"]
