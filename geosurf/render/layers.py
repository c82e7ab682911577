"""Choose what a picture shows: layers of triangles and lines with their legend.

Layers have world coordinates in float64 and do not depend on VTK, so tests can check the
content and the colours of a picture without drawing it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import takewhile
from typing import TypedDict, Unpack

import numpy as np

from geosurf.conventions import grouped, palette
from geosurf.conventions.palette import RGB
from geosurf.kernels.meshes.mesh import renumbered
from geosurf.render.views import corners

# ---- names ----------------------------------------
# Names on pictures: shortened without becoming alike, and placed without lying over each other.


LABEL_ROOM, DETAIL_ROOM = 21, 34  # characters that fit into a line of the legend
CUT = "…"
HEAD = 5  # letters of the start of a label whose end is left out
MARGIN = 1.5  # around names [pixels]
LEAST = 9  # letters of a label that can be told apart
NAME_SIZE = 12.0  # of names at points [design pixels]


def shortened(words: str, most: int = LABEL_ROOM) -> str:
    """Return text of at most so many letters; both the start and the end of a name remain.

    Examples
    --------
    >>> shortened("a horizon with a very long name")
    'a horizon…long name'
    >>> shortened("UpperVolantis/LowerVolantis")
    'Upper…ntis/Lower…ntis'
    """
    if len(words) <= most:
        return words

    # zones are named by two horizons: each of them is shortened by itself
    parts = words.split("/")
    if len(parts) == 2 and min(map(len, parts)) > most // 2:
        return "/".join(shortened(part, most // 2) for part in parts)
    return f"{words[: most // 2].rstrip()}{CUT}{words[-(most // 2 - 1) :].lstrip()}"


def shortened_apart(names: Iterable[str], most: int = LABEL_ROOM) -> dict[str, str]:
    """Return a label of at most so many letters for each name; different names stay different.

    Parameters
    ----------
    names : iterable of str
    most : int
        At least `LEAST`.

    Returns
    -------
    dict of str to str

    Examples
    --------
    >>> names = [f"Lower sandstone, member {i} (northern part)" for i in (12, 13)]
    >>> list(shortened_apart(names).values())
    ['Lower…12', 'Lower…13']
    """
    names = list(dict.fromkeys(names))
    labels_by_name = {name: shortened(name, most) for name in names}

    # zones are named by two horizons: each of them has to be told apart
    zones = [name for name in names if len(name) > most and name.count("/") == 1]
    if zones and most > 2 * LEAST:
        parts = [part for name in zones for part in name.split("/")]
        labels = shortened_apart(parts, (most - 1) // 2)
        labels_by_name |= {
            name: "/".join(labels[part] for part in name.split("/")) for name in zones
        }
    for group in _alike(labels_by_name):
        labels_by_name |= _with_difference(group, most)

    # names that differ in more than fits are numbered
    for group in _alike(labels_by_name):
        for i, name in enumerate(group, start=1):
            number = f"{CUT}({i})"
            labels_by_name[name] = f"{name[: most - len(number)].rstrip()}{number}"
    return labels_by_name


def _alike(labels: dict[str, str]) -> list[list[str]]:
    """Groups of names that have the same label."""
    groups = grouped((label, name) for name, label in labels.items())
    return [group for group in groups.values() if len(group) > 1]


def _with_difference(names: Sequence[str], most: int) -> dict[str, str]:
    """Labels that keep the first difference of names of equal starts."""
    start = _alike_at_start(names)
    end = _alike_at_start([name[start:][::-1] for name in names])

    # whole numbers: "12" and "13" do not become "2" and "3"
    while start and names[0][start - 1].isdigit():
        start -= 1
    while end and names[0][len(names[0]) - end].isdigit():
        end -= 1
    labels = {}
    for name in names:
        middle = name[start : len(name) - end]
        tail = name[len(name) - end :]

        # the difference first, then as much of the end as fits, then of the start
        room = most - 1 - len(middle)
        if room < 4:
            middle, tail = middle[: most - 5], ""
            room = most - 1 - len(middle)
        head = name[: most - 1 - len(middle) - len(tail)]
        if len(tail) > room - 3:
            # an end that does not fit is left out, and the label stays short
            tail, head = "", name[: min(room, HEAD)]
        labels[name] = f"{head.rstrip()}{CUT}{middle}{tail}"
    return labels


def _alike_at_start(names: Sequence[str]) -> int:
    """How many letters all names have in common at the start."""
    columns = zip(*names, strict=False)
    return sum(1 for _ in takewhile(lambda letters: len(set(letters)) == 1, columns))


class Room:
    """The parts of a picture that names have taken: boxes (left, bottom, right, top) [pixels]."""

    def __init__(self) -> None:
        self.taken: list[np.ndarray] = []

    def take(self, box: Sequence[float]) -> bool:
        """Take a box if it is free, with a margin for rims; return whether it was."""
        left, bottom, right, top = (
            box[0] - MARGIN, box[1] - MARGIN, box[2] + MARGIN, box[3] + MARGIN,
        )  # fmt: skip
        for one in self.taken:
            if left < one[2] and one[0] < right and bottom < one[3] and one[1] < top:
                return False
        self.taken.append(np.array([left, bottom, right, top]))
        return True

    def place(
        self,
        corners: Iterable[tuple[float, float]],
        wide: float,
        high: float,
        within: np.ndarray | None = None,
    ) -> tuple[float, float] | None:
        """Take the first free box of a size, by its lower left corner, inside of a rectangle."""
        for left, bottom in corners:
            right, top = left + wide, bottom + high
            inside = within is None or (
                within[0][0] <= left and right <= within[1][0] and top <= within[1][1]
            )
            if inside and self.take((left, bottom, right, top)):
                return left, bottom
        return None


# corners of a box are numbered by their sides, in binary: two make an edge if one side differs
BOX_EDGES = [(i, i | bit) for i in range(8) for bit in (1, 2, 4) if not i & bit]


class LayerStyle(TypedDict, total=False):
    """A layer of triangles or lines: see `geosurf.render.layers.Layer`."""

    colour: RGB
    opacity: float
    width: float
    sharp: bool


@dataclass(frozen=True, eq=False)
class Layer:
    """Triangles or lines in one colour.

    Attributes
    ----------
    points : ndarray of float64, shape (n_point, 3)
        World coordinates [m].
    triangles : ndarray of int64, shape (n_triangle, 3), or None
    lines : sequence of ndarray of int64
        Rows of `points`, in order; an array (n_line, 2) for single edges.
    colour : (red, green, blue)
    opacity : float
    width : float
        Of lines, in pixels.
    sharp : bool
        Whether creases between triangles stay sharp.
    shades : ndarray of float64, shape (n_point, 3), or None
        A colour for each point, in place of `colour`.
    dots : bool
        Whether points are drawn as dots that are `width` pixels wide.
    """

    points: np.ndarray
    triangles: np.ndarray | None = None
    lines: Sequence[np.ndarray] | np.ndarray = ()
    colour: palette.RGB = palette.INK
    opacity: float = 1.0
    width: float = 1.0
    sharp: bool = False
    shades: np.ndarray | None = None
    dots: bool = False


SYMBOLS = {"crest": "^", "spill": "v", "leak": "X"}  # of closures: markers of matplotlib


@dataclass(frozen=True)
class Entry:
    """An entry of the legend; `kind` is ``"area"``, ``"line"``, ``"dashes"``, ``"circle"``,
    ``"heading"``, or a key of `SYMBOLS`.

    An area with `stripes` has stripes of that colour.
    """

    label: str
    colour: palette.RGB = palette.INK
    detail: str = ""
    kind: str = "area"
    opacity: float = 1.0
    stripes: palette.RGB | None = None


@dataclass(frozen=True)
class Bar:
    """A colour bar: what it measures, its colours from low to high, and its round values."""

    words: str
    codes: tuple[str, ...]
    levels: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Content:
    """Layers, their legend, names at points of the world (easting, northing, elevation), a bar."""

    layers: tuple[Layer, ...] = ()
    legend: tuple[Entry, ...] = field(default=())
    names: tuple[tuple[str, tuple[float, float, float]], ...] = ()
    bar: Bar | None = None

    def __add__(self, other: Content) -> Content:
        return Content(
            self.layers + other.layers,
            self.legend + other.legend,
            self.names + other.names,
            self.bar or other.bar,
        )

    def moved(self, shift: np.ndarray) -> Content:
        """Return the content shifted by a vector [m]."""
        return replace(
            self, layers=tuple(replace(layer, points=layer.points + shift) for layer in self.layers)
        )


def triangle_layer(points: np.ndarray, triangles: np.ndarray, **look: Unpack[LayerStyle]) -> Layer:
    """Return a layer of triangles without unused points."""
    used, rows = renumbered(triangles)
    return Layer(points[used], rows, **look)


def segment_layer(ends: np.ndarray, **look: Unpack[LayerStyle]) -> Layer:
    """Return a layer of lines from their ends (n, 2, 3)."""
    # each segment has two points of its own: rows 2 i and 2 i + 1
    lines = np.arange(2 * len(ends)).reshape(-1, 2)
    return Layer(ends.reshape(-1, 3), lines=lines, **look)


def show_box(
    bounds: tuple[float, ...],
    towards: np.ndarray | None = None,
    colour: palette.RGB = palette.FRAME,
    width: float = 1.0,
) -> Content:
    """Return the edges of a box as thin lines, except those in front of the model.

    Parameters
    ----------
    bounds : (west, east, south, north, bottom, top)
        [m].
    towards : ndarray of float64, shape (3,), optional
        Direction to the viewer; the edges at the nearest corner are left out.
    colour, width
        Of the lines.
    """
    box = corners(bounds)
    edges = BOX_EDGES
    if towards is not None and (np.abs(towards) > 1e-9).all():
        # the corner that is nearest to the viewer, by its binary number: its three edges would run
        # in front of the model
        nearest = (towards > 0.0) @ (4, 2, 1)
        edges = [edge for edge in edges if nearest not in edge]
    return Content((Layer(box, lines=np.array(edges), colour=colour, width=width),))


def show_outline(ring: np.ndarray, level: float) -> Content:
    """Return the outline (n, 2) of an area of interest at an elevation, as a thin line."""
    points = np.column_stack([ring, np.full(len(ring), level)])
    there = np.arange(len(ring))
    lines = np.stack([there, np.roll(there, -1)], axis=1)
    return Content(
        (Layer(points, lines=lines, colour=palette.FAINT, width=1.2),),
        (Entry("Area of interest", kind="line", colour=palette.FAINT),),
    )
