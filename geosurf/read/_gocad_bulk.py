"""Vertices and triangles of large plain GOCAD files, all at once.

A plain file has VRTX and TRGL lines in runs, and no other words for vertices. All other files go
to the reader of lines, which names what is wrong.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from geosurf.read._common import plain_numbers
from geosurf.read._table import words_per_line

FEWEST = 100_000  # characters; below, lines are as fast
LINES_IN_A_RUN = 8  # on average; below, lines are as fast
OTHERS = re.compile(r"^\s*(?:P?VRTX|P?ATOM|TRGL)\b", re.MULTILINE | re.IGNORECASE)
NOT_WHOLE = re.compile(r"VRTX[ \t]+\d*[^\d\s]")  # an id that is no plain whole number
OBJECT = re.compile(r"^\s*GOCAD\b", re.MULTILINE | re.IGNORECASE)
OTHER, VERTEX, TRIANGLE = 0, 1, 2  # kinds of lines
WORDS = {VERTEX: b"VRTX ", TRIANGLE: b"TRGL "}


@dataclass
class _Object:
    """One object while its runs go by."""

    others: list[str] = field(default_factory=list)
    vertices: list[str] = field(default_factory=list)
    triangles: list[str] = field(default_factory=list)
    defined: list[int] = field(default_factory=list)  # vertices above each run of triangles
    n_vertex: int = 0


@dataclass(frozen=True, eq=False)
class PlainObject:
    """
    One object of a GOCAD file.

    Attributes
    ----------
    others : str
        Its lines without vertices and triangles.
    points : ndarray of float64, shape (n, 3)
        Coordinates as in the file.
    triangles : ndarray of int64, shape (m, 3)
        Rows of `points`.
    """

    others: str
    points: np.ndarray
    triangles: np.ndarray


def plain_objects(text: str) -> list[PlainObject] | None:
    """
    Return the objects of a large plain file, or None if it has to be read line by line.

    Parameters
    ----------
    text : str
    """
    if len(text) < FEWEST or not text.isascii():
        return None
    found: list[_Object] = []
    runs = _runs(text)
    if runs is None:
        return None
    for kind, start, stop, n_line in runs:
        part = text[start:stop]
        if kind == OTHER:
            heads = [match.start() for match in OBJECT.finditer(part)]
            cuts = [0, *heads, len(part)]
            if found:
                found[-1].others.append(part[: cuts[1]])
            elif part[: cuts[1]].strip():
                return None  # lines before the first object
            found += [_Object([part[a:b]]) for a, b in pairwise(cuts[1:])]
        elif not found:
            return None
        elif kind == VERTEX:
            found[-1].vertices.append(part)
            found[-1].n_vertex += n_line
        else:
            found[-1].triangles.append(part)
            found[-1].defined.append(found[-1].n_vertex)
    plain = [_arrays(one) for one in found]
    return [one for one in plain if one is not None] if None not in plain else None


def _runs(text: str) -> list[tuple[int, int, int, int]] | None:
    """Kind, start, end and number of lines of each run, or None if runs are short."""
    data = np.frombuffer(text.encode() + b"\n" * 8, dtype=np.uint8)
    starts = np.concatenate([[0], np.flatnonzero(data[: len(text)] == ord("\n")) + 1])
    kind = np.zeros(len(starts), dtype=np.int8)
    for value, word in WORDS.items():
        same = np.ones(len(starts), dtype=bool)
        for k, letter in enumerate(word):
            same &= data[starts + k] == letter
        kind[same] = value
    first = np.flatnonzero(np.concatenate([[True], np.diff(kind) != 0]))
    if len(first) * LINES_IN_A_RUN > len(starts):
        return None
    ends = np.append(starts[first[1:]], len(text)).tolist()
    n_line = np.diff(np.append(first, len(starts))).tolist()
    return list(zip(kind[first].tolist(), starts[first].tolist(), ends, n_line, strict=True))


def _arrays(one: _Object) -> PlainObject | None:
    """Points and triangles of an object, or None if a line of it is unusual."""
    rest = "".join(one.others)
    if OTHERS.search(rest):
        return None
    if not one.vertices and not one.triangles:
        return PlainObject(rest, np.empty((0, 3)), np.empty((0, 3), dtype=np.int64))
    vertex_text = "".join(one.vertices)
    if NOT_WHOLE.search(vertex_text) or not one.triangles:
        return None
    vertices = _table(vertex_text.replace("VRTX", " ").replace("CNXYZ", " "), 4)
    corners = [_whole_table(part.replace("TRGL", " "), 3) for part in one.triangles]
    tables = [part for part in corners if part is not None]
    if vertices is None or len(vertices) == 0 or len(tables) < len(corners):
        return None
    rows = _rows(vertices[:, 0], np.concatenate(tables))
    if rows is None:
        return None
    # vertices stand above the triangles that use them
    defined = np.repeat(one.defined, [len(part) for part in tables])
    if (rows.max(axis=1) >= defined).any():
        return None
    return PlainObject(rest, vertices[:, 1:].copy(), rows)


def _table(text: str, width: int) -> np.ndarray | None:
    """Numbers (n, width) of lines that have as many, or None."""
    if (words_per_line(text)[:-1] != width).any():
        return None
    values = plain_numbers(text)
    return None if values is None else values.reshape(-1, width)


def _whole_table(text: str, width: int) -> np.ndarray | None:
    """Whole numbers (n, width) of lines that have as many, or None."""
    # numbers that do not fit become the largest one, which no vertex has
    if not text.isascii() or (words_per_line(text)[:-1] != width).any():
        return None
    if text.encode().translate(None, b"0123456789 \t\n"):
        return None
    return np.fromstring(text, dtype=np.int64, sep=" ").reshape(-1, width)


def _rows(ids: np.ndarray, corners: np.ndarray) -> np.ndarray | None:
    """Rows of the vertices that triangles name, or None if one is absent or occurs twice."""
    if ids.max() >= 2.0**53:
        return None
    ids = ids.astype(np.int64)
    # most programs count from 0 or 1
    if (np.diff(ids) == 1).all():
        rows = corners - int(ids[0])
        inside = rows.min() >= 0 and rows.max() < len(ids)
        return rows.astype(np.int64) if inside else None
    order = np.argsort(ids, kind="stable")
    ranked = ids[order]
    at = np.minimum(np.searchsorted(ranked, corners), len(ids) - 1)
    if (np.diff(ranked) == 0).any() or (ranked[at] != corners).any():
        return None
    return order[at].astype(np.int64)
