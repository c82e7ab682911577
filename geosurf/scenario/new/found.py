"""What one file holds, and what is made of it."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import METRES_PER_UNIT

# ---- shape ----------------------------------------
# Dip of points and triangles, and mean elevations of the cells of a coarse grid.


CELLS = 40  # along each axis of the area
MOST_POINTS = 4000  # that a plane is fitted to


def thinned(points: np.ndarray, most: int) -> np.ndarray:
    """Every n-th point, so that there are about this many."""
    # Evenly through the file: grids stay grids, and no random numbers are needed.
    return points[:: max(len(points) // most, 1)]


def plane_dip(points: np.ndarray) -> float:
    """Dip [degrees] of the plane that lies nearest to points (n, 3).

    Examples
    --------
    >>> round(plane_dip(np.array([[0, 0, 0], [1, 0, 1], [0, 1, 0], [1, 1, 1.0]])))
    45
    """
    few = thinned(points, MOST_POINTS)
    # The direction of least variance is the normal of the plane.
    normal = np.linalg.svd(few - few.mean(axis=0), full_matrices=False)[2][-1]
    return float(np.degrees(np.arccos(min(abs(normal[2]), 1.0))))


def mean_dip(vertices: np.ndarray, triangles: np.ndarray) -> float:
    """Mean dip [degrees] of triangles, by area."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    # Weighted by area: small steep triangles at rims count little.
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    level = np.abs(normal[:, 2]).sum() / max(area.sum(), np.finfo(float).tiny)
    return float(np.degrees(np.arccos(min(level, 1.0))))


def cell_means(points: np.ndarray, frame: tuple[float, float, float, float]) -> np.ndarray:
    """Mean z in each cell of a frame (west, south, width, height); NaN in cells without points."""
    west, south, width, height = frame
    # Points on the last rim belong to the last cell.
    column = np.clip((points[:, 0] - west) / width * CELLS, 0, CELLS - 1).astype(np.int64)
    row = np.clip((points[:, 1] - south) / height * CELLS, 0, CELLS - 1).astype(np.int64)
    at = row * CELLS + column
    count = np.bincount(at, minlength=CELLS * CELLS)
    total = np.bincount(at, weights=points[:, 2], minlength=CELLS * CELLS)
    # Empty cells are NaN, so that comparisons leave them out.
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def frame_of(clouds: list[np.ndarray]) -> tuple[float, float, float, float]:
    """West, south, width and height around points."""
    low = np.min([p[:, :2].min(axis=0) for p in clouds], axis=0)
    high = np.max([p[:, :2].max(axis=0) for p in clouds], axis=0)
    # A line of points still gets cells.
    width, height = np.maximum(high - low, 1.0)
    return float(low[0]), float(low[1]), float(width), float(height)


def overlap_in_map(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether the rectangles around two clouds overlap in the map."""
    # Rectangles are enough: a wrong yes only asks for a tear that cuts nothing.
    low = np.maximum(a[:, :2].min(axis=0), b[:, :2].min(axis=0))
    high = np.minimum(a[:, :2].max(axis=0), b[:, :2].max(axis=0))
    return bool((low <= high).all())


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
