"""Direction, unit, order and names of what was found; what contradicts or repeats it stays out."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from itertools import combinations, permutations
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import METRES_PER_UNIT, counted
from geosurf.conventions.axes import FEWEST_CELLS, FOOT, cell_means, frame_around, relief_in_feet

# ---- found ----------------------------------------
# What one file holds, and what is made of it.


# ---- shape ----------------------------------------
# Dip of points and triangles.


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


SAME = 1.0  # [m]: horizons nearer than this in most cells are one
# Words of names, not parts of words: "stop" and "database" do not name the top or base of a zone.
UPPER = re.compile(r"(?:^|[^a-z])top|[a-z]top(?:[^a-z]|$)", re.IGNORECASE)
LOWER = re.compile(r"(?:^|[^a-z])(base|bottom)|[a-z](base|bottom)(?:[^a-z]|$)", re.IGNORECASE)
DEPTH_HEADER = re.compile(r"tvd|depth", re.IGNORECASE)
UP_HEADER = re.compile(r"elevation", re.IGNORECASE)
SOLID = ("horizon", "fault", "contact", "tops", "polygons")


@dataclass(frozen=True)
class Answers:
    """What the user has stated on the command line."""

    positive: str | None = None
    length_unit: str | None = None


@dataclass
class Ready:
    """All that a scenario is written from; horizons youngest first.

    Attributes
    ----------
    found : list of Found
    positive : str or None
        For all files that do not state it; None if nothing does, or each file has its own.
    reason : str
        Where `positive` is from.
    asks_direction : bool
        Whether a run needs `positive`.
    notes : list of str
        Comments at the head of the horizons.
    """

    found: list[Found]
    positive: str | None = None
    reason: str = ""
    asks_direction: bool = False
    notes: list[str] = field(default_factory=list)

    def of(self, *kinds: str) -> list[Found]:
        """Objects of some kinds."""
        return [one for one in self.found if one.kind in kinds]


def judged(files: list[Found], answers: Answers) -> Ready:
    """Return what a scenario is written from."""
    # The order matters: repeats and the stratigraphic order need elevations, hence direction and
    # unit.
    ready = Ready(files)
    _leave_alternatives_out(ready)
    _state_direction(ready, answers)
    _state_units(ready, answers)
    if ready.of("horizon") and not ready.asks_direction:
        _leave_repeats_out(ready)
        _order(ready)
    elif ready.asks_direction:
        ready.notes.append("the order is that of the files, until the direction of z is known")
    _polygons(ready)
    _name(ready)
    # The order of tables in the scenario; horizons keep theirs, since sorting is stable.
    rank = {"model": 0, "horizon": 1, "fault": 2}
    ready.found.sort(key=lambda file: rank.get(file.kind, 4 if file.kind == OUT else 3))
    return ready


# ---------------------------------------------------------------------- what stays out
def _leave_alternatives_out(ready: Ready) -> None:
    """A sealed model comes alone; of two files of one name and kind at one place, one is used."""
    models = ready.of("model")
    for other in models[1:]:
        other.leave_out(f"a scenario has one sealed model, {models[0].path.name}")
    # Contacts and tops can be combined with a sealed model.
    for surface in ready.of(*SOLID[:2]) if models else []:
        surface.leave_out(f"a sealed model has its own surfaces, see {models[0].path.name}")
    first: dict[tuple[str, str], Found] = {}
    for surface in ready.of("horizon", "fault"):
        # Case does not matter: exports on Windows change it.
        key = surface.kind, surface.name.casefold()
        known = first.setdefault(key, surface)
        if known is surface or known.path == surface.path:
            continue
        # A grid and its points, or a fault twice: one of both would be torn or cut twice.
        other_form = surface.kind == "fault" or known.form != surface.form
        if other_form and overlap_in_map(known.points, surface.points):
            surface.leave_out(f"{known.path.name} has {surface.name!r} as well; use one of them")
    for kind in ("tops", "outline"):
        for extra in ready.of(kind)[1:]:
            extra.leave_out(f"a scenario has one of these; {ready.of(kind)[0].path.name} is used")


def _leave_repeats_out(ready: Ready) -> None:
    """Horizons that coincide nearly everywhere are one horizon in two files."""
    means = _means(ready)
    # Pairs in the order of files; one that was left out is compared no more.
    for a, b in combinations(ready.of("horizon"), 2):
        if OUT in (a.kind, b.kind):
            continue
        # Cells of a coarse common grid: nodes of two grids differ in position.
        gap = np.abs(means[id(a)] - means[id(b)])
        both = np.isfinite(gap)
        # The median ignores places where one of both was edited.
        if both.sum() >= FEWEST_CELLS and np.median(gap[both]) < SAME:
            # the one with more nodes shows more of the horizon
            used, spare = (a, b) if len(a.points) >= len(b.points) else (b, a)
            middle = np.median(gap[both])
            spare.leave_out(f"coincides with {used.path.name} (median difference {middle:.2g} m)")


def _polygons(ready: Ready) -> None:
    """Fault polygons stand for faults where there are no fault surfaces; each file once."""
    used: list[Found] = []
    for file in ready.of("polygons"):
        same = next((u for u in used if _coincide(u.points, file.points)), None)
        if ready.of("fault"):
            file.leave_out(
                f"{counted(len(file.parts), 'closed line')}: fault polygons, and there are fault "
                "surfaces. To use them, see [[faults.polygons]]"
            )
        elif same is not None:
            file.leave_out(f"has the lines of {same.path.name}")
        else:
            used.append(file)


def _coincide(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether two files have the same points, but for digits that one of them lacks."""
    return a.shape == b.shape and bool((np.abs(a - b) < SAME).all())


def nearest_horizon(ready: Ready, polygons: Found) -> str:
    """Name of the horizon whose elevations are those of some polygons."""
    horizons = ready.of("horizon")
    frame = frame_around([horizon.elevations for horizon in horizons])
    at = cell_means(polygons.elevations, frame)

    def away(horizon: Found) -> float:
        gap = np.abs(cell_means(horizon.elevations, frame) - at)
        return float(np.median(gap[np.isfinite(gap)])) if np.isfinite(gap).any() else np.inf

    return min(horizons, key=away).name


# ---------------------------------------------------------------------- direction
def _state_direction(ready: Ready, answers: Answers) -> None:
    """Find out whether z is depth or elevation; files of opposite sign have opposite words."""
    # Only files that do not state their direction are in question.
    silent = [file for file in ready.of(*SOLID) if not file.states_direction]
    if not silent:
        return
    word, reason = _direction(ready, silent, answers)
    if word is None:
        ready.asks_direction = True
        return

    # the word belongs to z of the sign that most files have
    # Depths below datum may be stored with either sign, in one field even.
    minority = [file for file in silent if _sign(file) != _majority(silent)]
    # What the user states on the command line counts for all files.
    if answers.positive is None and minority:
        for file in silent:
            opposite = "up" if word == "down" else "down"
            file.positive = opposite if file in minority else word
        ready.reason = f"{reason}; files of the other sign are positive = {opposite!r}"
        return
    for file in silent:
        file.positive = word
    ready.positive, ready.reason = word, reason


def _direction(ready: Ready, silent: list[Found], answers: Answers) -> tuple[str | None, str]:
    """The word for the files of the more frequent sign, and where it is from."""
    if answers.positive is not None:
        return answers.positive, "as given with --positive"
    usual = [file for file in silent if _sign(file) == _majority(silent)]
    # From the surest evidence to the weakest: names, headers, then neighbours that state it.
    for find in (_by_names, _by_header):
        word, reason = find(usual)
        if word:
            return word, reason
    word, reason = _by_neighbours(ready, usual)
    # Meshes of modelling programs are elevations by convention.
    if word is None and all(file.form == "mesh" for file in silent):
        return "up", "the default of such meshes"
    return word, reason


def _by_names(silent: list[Found]) -> tuple[str | None, str]:
    """A base below a top, by their names: z grows down if it is larger at the base."""
    horizons = [horizon for horizon in silent if horizon.kind == "horizon"]
    if len(horizons) < 2:
        return None, ""
    # Without a direction z itself is compared: only its trend from top to base matters.
    frame = frame_around([horizon.points for horizon in horizons])
    means = {id(horizon): cell_means(horizon.points, frame) for horizon in horizons}
    pairs = [
        (top, base)
        for top, base in permutations(horizons, 2)
        if UPPER.search(top.name) and LOWER.search(base.name) and not LOWER.search(top.name)
    ]

    # top and base of one interval say most: the top of the next one is below this base
    same_zone = [pair for pair in pairs if _interval(pair[0]) == _interval(pair[1])]
    # Every pair votes; contradicting votes leave the question open.
    words, last = set(), ""
    for top, base in same_zone or pairs:
        gap = means[id(base)] - means[id(top)]
        gap = gap[np.isfinite(gap)]
        if len(gap) >= FEWEST_CELLS and np.median(gap) != 0:
            words.add("down" if np.median(gap) > 0 else "up")
            last = f"z is {'larger' if np.median(gap) > 0 else 'smaller'} in {base.name!r} than "
            last += f"in {top.name!r}"
    return (words.pop(), last) if len(words) == 1 else (None, "")


def _interval(one: Found) -> str:
    """The name of a horizon without the words for top and base."""
    return re.sub(r"top|base|bottom|[^a-z0-9]", "", one.name.casefold())


def _by_header(silent: list[Found]) -> tuple[str | None, str]:
    """A column that is named depth or elevation."""
    headers = {file.header: file for file in silent if file.header and file.kind != "tops"}
    words = {}
    # One word in all headers, or nothing is concluded.
    for text, file in headers.items():
        if DEPTH_HEADER.search(text) or UP_HEADER.search(text):
            words["down" if DEPTH_HEADER.search(text) else "up"] = file
    if len(words) != 1:
        return None, ""
    word, file = words.popitem()
    return word, f"the header of {file.path.name} names the column"


def _by_neighbours(ready: Ready, silent: list[Found]) -> tuple[str | None, str]:
    """Files that state their direction: only one sign brings the others to their elevations."""
    stated = [surface for surface in ready.of(*SOLID[:2]) if surface.states_direction]
    solid = [surface for surface in silent if surface.kind in SOLID[:2]]
    if not stated or not solid:
        return None, ""
    # The range of files that state their direction, with its own height as margin.
    low = min(surface.points[:, 2].min() for surface in stated)
    high = max(surface.points[:, 2].max() for surface in stated)
    z = np.array([np.median(surface.points[:, 2]) for surface in solid])
    margin = high - low
    fits = {
        word: bool(((sign * z > low - margin) & (sign * z < high + margin)).any())
        for word, sign in (("up", 1.0), ("down", -1.0))
    }
    # Both signs fit, or none does: nothing is learned.
    if fits["up"] == fits["down"]:
        return None, ""
    return "up" if fits["up"] else "down", f"only so they meet {stated[0].path.name}"


def _sign(one: Found) -> float:
    # The median: single nodes may have the wrong sign.
    return float(np.sign(np.median(one.points[:, 2])))


def _majority(silent: list[Found]) -> float:
    return 1.0 if sum(_sign(one) for one in silent) >= 0 else -1.0


# ---------------------------------------------------------------------- unit
def _state_units(ready: Ready, answers: Answers) -> None:
    """Metres, but for files of which both the relief and the position fit feet only."""
    silent = [horizon for horizon in ready.of(*SOLID) if not horizon.states_unit]
    # The unit that the user gives counts for all silent files; metres are the default and are not
    # written.
    if answers.length_unit is not None:
        for horizon in silent:
            horizon.length_unit = None if answers.length_unit == "m" else answers.length_unit
        return
    horizons = ready.of("horizon")
    # Relief can only be compared with that of another horizon.
    if len(horizons) < 2:
        return
    frame = frame_around([horizon.points for horizon in horizons])
    means = {id(horizon): cell_means(horizon.points, frame) for horizon in horizons}
    verdicts = {
        id(horizon): _feet(horizon, [o for o in horizons if o is not horizon], means, ready)
        for horizon in horizons
        if horizon in silent
    }
    for horizon in horizons:
        # Two independent signs are needed to change a unit; one alone asks the user.
        relief, position = verdicts.get(id(horizon), (0.0, False))
        if relief and position:
            horizon.length_unit = "ft"
            horizon.why = f"its relief is {relief:.2f} times that of the others, and z fits only so"
        elif relief:
            horizon.asks.append((
                'length_unit = "ft"',
                f"is {horizon.path.name} in feet? Its relief is {relief:.2f} times that of others",
            ))  # fmt: skip


def _feet(
    horizon: Found, others: list[Found], means: dict[int, np.ndarray], ready: Ready
) -> tuple[float, bool]:
    """How much larger its relief is than that of others, 0 if not as feet are; and its position."""
    relief = relief_in_feet(means[id(horizon)], (means[id(other)] for other in others))

    # faults reach the horizons that they cut: in feet, not in metres
    bounds = ready.of("fault") or others
    z = np.concatenate([np.abs(f.points[:, 2]) for f in bounds])
    margin = np.ptp(z)
    middle = abs(float(np.median(horizon.points[:, 2])))
    low, high = z.min() - margin, z.max() + margin
    return relief, bool(low < middle * FOOT < high and not low < middle < high)


# ---------------------------------------------------------------------- order and names
def _means(ready: Ready) -> dict[int, np.ndarray]:
    horizons = ready.of("horizon")
    frame = frame_around([one.elevations for one in horizons])
    return {id(one): cell_means(one.elevations, frame) for one in horizons}


def _order(ready: Ready) -> None:
    """Sort horizons from the top down: by medians where all of them are, else of each alone."""
    horizons = ready.of("horizon")
    # Elevations, as direction and unit are known by now.
    means = _means(ready)
    table = np.array([means[id(horizon)] for horizon in horizons])
    # Only cells that all horizons have: a dipping horizon would otherwise seem higher where it
    # ends.
    shared = np.isfinite(table).all(axis=0)
    if shared.sum() < FEWEST_CELLS and len(horizons) > 1:
        ready.notes.append("these horizons share no area; their order is that of their medians")
        shared = np.ones(table.shape[1], dtype=bool)
    level = {id(horizon): float(np.nanmedian(row[shared]))
             for horizon, row in zip(horizons, table, strict=True)}  # fmt: skip
    # What has no level (faults, tops) goes to the end, in its order.
    ready.found.sort(key=lambda horizon: -level.get(id(horizon), -np.inf))


def _name(ready: Ready) -> None:
    """Give each surface a name of its own: that of its file, then with kind, folder or number."""
    used: set[str] = set()
    for surface in ready.of("horizon", "fault", "contact"):
        base = surface.name
        # The first name that is free: the file's own, then one that says more.
        choices = [base, f"{base} {surface.kind}", f"{base} {surface.path.parent.name}".strip()]
        choices += [f"{base} {k}" for k in range(2, len(ready.found) + 3)]
        surface.name = next(word for word in choices if word.casefold() not in used)
        used.add(surface.name.casefold())
