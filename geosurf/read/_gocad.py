"""The parser of GOCAD files: objects, their headers, vertices and triangles, line by line."""

from __future__ import annotations

import shlex
from array import array
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from geosurf.errors import FormatError, InputError
from geosurf.read._common import (
    Request,
    agreed_scale,
    agreed_sign,
    integer,
    is_number,
    line_blocks,
    number,
    number_rows,
)
from geosurf.read._guard import damaged

# ---- gocad header ----------------------------------------
# The header of a GOCAD object: name, coordinate system, properties.
#
# Keys know no case. The names of the axes give their order; AXIS_UNIT follows the same order. A
# coordinate system called ``Default``, ``Unknown`` or ``... Local`` is ignored.


DIRECTIONS = {"elevation": "up", "depth": "down"}
# what axes are called, lower case: x, y, z
AXES = (
    ("x", "e", "east", "easting"),
    ("y", "n", "north", "northing"),
    ("z", "elevation", "altitude", "height", "depth", "tvd", "tvdss"),
)
DEPTHS = ("depth", "tvd", "tvdss")
NO_SYSTEM = ("", "default", "local", "none", "unknown")  # last word of its name
COUNT_OF_AXES = 3


@dataclass
class Header:
    """The header of one object, as it is written before the vertices."""

    name: str | None = None
    positive: str | None = None
    axis_names: list[str] = field(default_factory=list)
    axis_units: list[str] = field(default_factory=list)
    system: dict[str, str] = field(default_factory=dict)
    inside: bool = False  # of the coordinate system
    properties: list[str] = field(default_factory=list)
    sizes: list[int] = field(default_factory=list)
    no_data: list[float] = field(default_factory=list)

    def take_brace_line(self, text: str) -> None:
        """Take the name from ``name: F1``, also from ``{NAME: "F1"}``."""
        key, colon, value = text.strip().strip("{}").partition(":")
        value = value.strip().strip('"').strip()
        if colon and key.strip().lower() == "name" and value:
            self.name = value

    def take_line(self, path: Path, i: int, words: list[str]) -> None:
        """Read one line that is not a vertex or triangle; most have no effect here."""
        key, rest = words[0].upper(), words[1:]

        # NAME means the system's inside its block, and the object's elsewhere
        if key.startswith("GOCAD_") and key.endswith("COORDINATE_SYSTEM"):
            self.inside = True
        elif key.startswith("END_") and key.endswith("COORDINATE_SYSTEM"):
            self.inside = False
        elif self.inside and key in ("NAME", "PROJECTION", "DATUM"):
            self.system[key] = " ".join(" ".join(rest).split())
        elif key == "ZPOSITIVE":
            self.positive = _direction(path, i, rest)
        elif key in ("AXIS_NAME", "AXIS_UNIT"):
            if len(rest) != COUNT_OF_AXES:
                raise FormatError(
                    f"{path}, line {i}: {key} has {len(rest)} words, expected 3 (x, y, z). "
                    "Correct that line."
                )
            setattr(self, key.lower() + "s", [word.strip() for word in rest])
        elif key == "PROPERTIES":
            self.properties = [word.strip() for word in rest]
        elif key == "ESIZES":
            self.sizes = [integer(word, path, i, "size of a property") for word in rest]
        elif key == "NO_DATA_VALUES":
            self.no_data = [
                number(word, path, i, "no-data value") if is_number(word) else np.nan
                for word in rest
            ]

    def property_sizes(self, path: Path, line: int) -> list[int]:
        """Values per property; 1 each unless ESIZES differs."""
        sizes = self.sizes or [1] * len(self.properties)
        if len(sizes) != len(self.properties) or min(sizes, default=1) < 1:
            raise FormatError(
                f"{path}: the surface that begins on line {line} has {len(self.properties)} "
                f"PROPERTIES but ESIZES {sizes}; each property needs one positive size. "
                "Correct the header."
            )
        return sizes

    def order(self, what: str) -> list[int]:
        """Column of x, of y and of z among the three of a vertex."""
        names = [word.lower() for word in self.axis_names]
        known = [next((k for k in range(3) if name in AXES[k]), None) for name in names]
        # Each axis is named once: columns may come in any order.
        if sorted(k for k in known if k is not None) == [0, 1, 2]:
            return [known.index(k) for k in range(COUNT_OF_AXES)]

        # some axes known, others not: in their usual order they may stay, otherwise it is a guess
        if any(k not in (None, at) for at, k in enumerate(known)):
            raise FormatError(
                f"{what}: AXIS_NAME is {self.axis_names}, so the order of x, y and z is "
                'unclear. Write AXIS_NAME "X" "Y" "Z", in the order of the columns.'
            )
        return [0, 1, 2]

    def to_metres(self, points: np.ndarray, request: Request, what: str) -> np.ndarray:
        """Points (n, 3) in the order x, y, z: metres, elevation up."""
        order = self.order(what)

        # an axis called depth, without a word on its direction, could be meant either way
        deep = self.axis_names[order[2]].lower() in DEPTHS if self.axis_names else False
        if self.positive is None and request.positive is None and deep:
            raise InputError(
                f"{what}: the third axis is called {self.axis_names[order[2]]!r}, and ZPOSITIVE is "
                "missing. Pass positive='down' for depths or positive='up' for elevations."
            )
        direction = (
            request.positive if request.positive is not None or self.positive is not None else "up"
        )
        sign = agreed_sign(self.positive, direction, what)
        # Units in the order x, y, z; the argument of the caller counts for z alone.
        stated = [self.axis_units[k] for k in order] if self.axis_units else [None] * 3
        requested = (None, None, request.length_unit)  # a caller's word is that of elevations
        pairs = zip(stated, requested, strict=True)
        scale = np.array([agreed_scale(*pair, "m", what) for pair in pairs])
        return points[:, order] * scale * [1.0, 1.0, sign]

    @property
    def crs(self) -> str | None:
        """The coordinate reference system: its name, else its datum and projection."""
        name, projection, datum = (
            _named(self.system.get(key, "")) for key in ("NAME", "PROJECTION", "DATUM")
        )
        return name or " / ".join(word for word in (datum, projection) if word) or None


def _named(text: str) -> str:
    """Return the name of a system, or nothing where it names none."""
    # "GOCAD Local" and the like name no system
    last = (text.split() or [""])[-1].lower()
    return "" if last in NO_SYSTEM else text


def _direction(path: Path, i: int, rest: list[str]) -> str:
    direction = DIRECTIONS.get(rest[0].lower()) if rest else None
    if direction is None:
        raise FormatError(
            f"{path}, line {i}: ZPOSITIVE is {' '.join(rest)!r}, expected Elevation or Depth. "
            "Correct that line."
        )
    return direction


# ---- gocad draft ----------------------------------------
# The lines of a GOCAD file: objects, and what a TSurf has while its lines go by.


VERTEX_WORDS = ("VRTX", "PVRTX")
ALIAS_WORDS = ("ATOM", "PATOM")
AT_A_TIME = 60_000  # words of vertices that become numbers together

Line = tuple[int, list[str]]


@dataclass
class Draft:
    """One TSurf while its lines go by."""

    path: Path
    size: int  # of the file
    line: int
    header: Header = field(default_factory=Header)
    row_of_id: dict[str, int] = field(default_factory=dict)
    n_vertex: int = 0
    words: list[str] = field(default_factory=list)  # of coordinates, three a vertex
    lines: list[int] = field(default_factory=list)  # of those words
    points: list[np.ndarray] = field(default_factory=list)
    valued: list[np.ndarray] = field(default_factory=list)  # rows of vertices with properties
    values: list[np.ndarray] = field(default_factory=list)
    corners: array[int] = field(default_factory=lambda: array("q"))
    pending: list[tuple[int, int, list[str]]] = field(default_factory=list)

    def flush(self) -> None:
        """Turn words of vertices into numbers."""
        # Words of a vertex become numbers in bulk; lines serve for errors only.
        if self.words:
            self.points.append(number_rows(self.words, self.lines, self.path, "x, y or z"))
        if self.pending:
            # rows of vertices that have values: VRTX and PVRTX may be mixed
            numbered, lines, values = zip(*self.pending, strict=True)
            self.valued.append(np.array(numbered, dtype=np.int64))
            flat = [word for row in values for word in row]
            self.values.append(number_rows(flat, lines, self.path, "value of a property"))
        self.words, self.lines, self.pending = [], [], []


TITLES = {"tsurf": "TSurf", "sgrid": "SGrid", "pline": "PLine", "vset": "VSet"}


def bodies(path: Path, text: str, kind: str) -> Iterator[tuple[int, Iterator[Line]]]:
    """Yield first line and lines of each object of one kind, at least one; use up its lines."""
    # A file may hold several objects; each starts with GOCAD and ends with END.
    lines, has_object = _numbered_lines(text), False
    for i, line in lines:
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0].upper() != "GOCAD":
            raise FormatError(
                f"{path}, line {i}: found {line[:40]!r}, expected 'GOCAD TSurf 1'. This is not "
                "a GOCAD file, or the object before this line ended too early."
            )
        body = _body(path, lines, i)
        if len(words) > 1 and words[1].lower() == kind:
            has_object = True
            yield i, body
        else:
            deque(body, maxlen=0)  # another kind of object: pass over it
    if not has_object:
        raise damaged(f"{path}: the file has no GOCAD {TITLES[kind]}")


def _body(path: Path, lines: Iterator[tuple[int, str]], start: int) -> Iterator[Line]:
    """Lines of one object, as words, up to its END."""
    for i, line in lines:
        words = quoted_words(line)
        if not words or words[0].startswith("#"):
            continue
        key = words[0].upper()
        if key == "END":
            return

        # an object without END was cut short: its triangles may be missing
        if key == "GOCAD":
            raise damaged(
                f"{path}, line {i}: a new object begins before the END of the object on line "
                f"{start}"
            )
        yield i, words
    raise damaged(f"{path}: the object that begins on line {start} has no END")


def quoted_words(line: str) -> list[str]:
    """Return the words of a line; those between quotes are one."""
    if '"' not in line:
        return line.split()
    try:
        return shlex.split(line)
    except ValueError:  # an odd quote, as in free-text headers
        return line.split()


def _numbered_lines(text: str) -> Iterator[tuple[int, str]]:
    """Lines of a text, counted from 1."""
    for first, piece in line_blocks(text):
        yield from enumerate(piece.split("\n")[: -1 if piece.endswith("\n") else None], first)


def fill(draft: Draft, body: Iterator[Line]) -> None:
    """Sort the lines of one TSurf into the draft."""
    block = ""  # HEADER, PROPERTY_CLASS_HEADER: lines between braces
    key = ""

    for i, words in body:
        before, key = key, words[0].upper()
        # Inside braces only the header's name matters.
        if block:
            if block == "HEADER":
                draft.header.take_brace_line(" ".join(words))
            if "}" in words[-1]:
                block = ""
        elif key in VERTEX_WORDS:
            _vertex_line(draft, i, key, words)
        elif key == "TRGL":
            _triangle_line(draft, i, words)
        elif key in ALIAS_WORDS:
            _alias_line(draft, i, words)
        elif "VRTX" in key or "TRGL" in key:
            raise damaged(f"{draft.path}, line {i}: found {words[0]!r}, expected VRTX or TRGL")
        # A block opens on this line and may close on it, too.
        elif "{" in " ".join(words):
            opened, _, rest = " ".join(words).partition("{")
            key = opened.split()[0].upper() if opened.split() else before
            if key == "HEADER":
                draft.header.take_brace_line(rest)
            block = "" if rest.rstrip().endswith("}") else key or "?"
        else:
            draft.header.take_line(draft.path, i, words)

    draft.flush()


def _vertex_line(draft: Draft, i: int, key: str, words: list[str]) -> None:
    """``VRTX id x y z`` or ``PVRTX id x y z value ...``, then perhaps words."""
    # how many values a PVRTX has follows from the header
    n_value = sum(draft.header.property_sizes(draft.path, draft.line)) if key == "PVRTX" else 0
    if len(words) < 5 + n_value:
        raise damaged(
            f"{draft.path}, line {i}: {key} has {len(words) - 1} values, expected {4 + n_value} "
            "(id, x, y, z, properties)"
        )

    # Coordinates wait as words, and properties with the row of their vertex.
    _new_id(draft, i, words[1], draft.n_vertex)
    draft.words += words[2:5]
    draft.lines.append(i)
    if n_value:
        draft.pending.append((draft.n_vertex, i, words[5 : 5 + n_value]))
    draft.n_vertex += 1

    # in portions: words take many times the memory of numbers
    if len(draft.words) >= AT_A_TIME:
        draft.flush()


def _alias_line(draft: Draft, i: int, words: list[str]) -> None:
    """``ATOM id other``: another name of vertex `other`, so of one and the same vertex."""
    if len(words) < 3:
        raise damaged(
            f"{draft.path}, line {i}: {words[0]} has {len(words) - 1} values, expected its id and "
            "that of a vertex"
        )

    # no vertex is made: two ids lead to one row
    _new_id(draft, i, words[1], row_of(draft, i, words[2]))


def _triangle_line(draft: Draft, i: int, words: list[str]) -> None:
    """``TRGL id id id``."""
    if len(words) < 4:
        raise damaged(
            f"{draft.path}, line {i}: TRGL has {len(words) - 1} values, expected 3 vertex ids"
        )

    # Nearly all ids are written alike, so a plain look-up comes first.
    rows = draft.row_of_id
    try:
        draft.corners.extend((rows[words[1]], rows[words[2]], rows[words[3]]))
    except KeyError:  # unknown, or written in another way
        draft.corners.extend([row_of(draft, i, word) for word in words[1:4]])


def _key(draft: Draft, i: int, word: str) -> str:
    """Return an id as it is written shortest: 7 for 007."""
    # the usual spelling needs no conversion; 007 and +7 are brought to it
    if word.isascii() and word.isdecimal() and word[0] != "0":
        return word
    return str(integer(word, draft.path, i, "id of a vertex"))


def _new_id(draft: Draft, i: int, word: str, row: int) -> None:
    key = _key(draft, i, word)
    if key in draft.row_of_id:
        raise damaged(
            f"{draft.path}, line {i}: vertex id {key} occurs twice; ids must be unique within a "
            "surface"
        )
    draft.row_of_id[key] = row


def row_of(draft: Draft, i: int, word: str) -> int:
    """Return the row of the vertex that an id names."""
    key = _key(draft, i, word)
    row = draft.row_of_id.get(key)
    if row is None:
        raise damaged(f"{draft.path}, line {i}: vertex {key} is used but not defined above")
    return row
