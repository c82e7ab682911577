"""The lines of a GOCAD file: objects, and what a TSurf has while its lines go by."""

from __future__ import annotations

import shlex
from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from geosurf.errors import FormatError
from geosurf.read._common import integer, line_blocks, number_rows
from geosurf.read._gocad_header import Header

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
        rows = [self.words[k : k + 3] for k in range(0, len(self.words), 3)]
        if rows:
            self.points.append(number_rows(rows, self.lines, self.path, "x, y or z"))
        if self.pending:
            # rows of vertices that have values: VRTX and PVRTX may be mixed
            numbered, lines, values = zip(*self.pending, strict=True)
            self.valued.append(np.array(numbered, dtype=np.int64))
            what = "value of a property"
            self.values.append(number_rows(list(values), lines, self.path, what))
        self.words, self.lines, self.pending = [], [], []


def bodies(path: Path, text: str) -> Iterator[tuple[int, str, Iterator[Line]]]:
    """Yield first line, kind in lower case and lines of each object; those have to be used up."""
    # A file may hold several objects; each starts with GOCAD and ends with END.
    lines = _numbered_lines(text)
    for i, line in lines:
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0].upper() != "GOCAD":
            raise FormatError(
                f"{path}, line {i}: found {line[:40]!r}, expected 'GOCAD TSurf 1'. This is not "
                "a GOCAD file, or the object before this line ended too early."
            )
        yield i, words[1].lower() if len(words) > 1 else "", _body(path, lines, i)


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
            raise FormatError(
                f"{path}, line {i}: a new object begins before the END of the object on line "
                f"{start}. Export the file again."
            )
        yield i, words
    raise FormatError(
        f"{path}: the object that begins on line {start} has no END. The file is truncated; "
        "export it again."
    )


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
        raise FormatError(
            f"{draft.path}, line {i}: {key} has {len(words) - 1} values, expected {4 + n_value} "
            "(id, x, y, z, properties). Correct that line or export the file again."
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
        raise FormatError(
            f"{draft.path}, line {i}: {words[0]} has {len(words) - 1} values, expected its id and "
            "that of a vertex. Correct that line or export the file again."
        )

    # no vertex is made: two ids lead to one row
    _new_id(draft, i, words[1], row_of(draft, i, words[2]))


def _triangle_line(draft: Draft, i: int, words: list[str]) -> None:
    """``TRGL id id id``."""
    if len(words) < 4:
        raise FormatError(
            f"{draft.path}, line {i}: TRGL has {len(words) - 1} values, expected 3 vertex ids. "
            "Correct that line or export the file again."
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
        raise FormatError(
            f"{draft.path}, line {i}: vertex id {key} occurs twice; ids must be unique within "
            "a surface. Export the file again."
        )
    draft.row_of_id[key] = row


def row_of(draft: Draft, i: int, word: str) -> int:
    """Return the row of the vertex that an id names."""
    key = _key(draft, i, word)
    row = draft.row_of_id.get(key)
    if row is None:
        raise FormatError(
            f"{draft.path}, line {i}: vertex {key} is used but not defined above. Export the "
            "file again."
        )
    return row
