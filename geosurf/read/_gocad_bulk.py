"""Vertices and triangles of large plain GOCAD files, block by block.

A plain file has VRTX and TRGL lines in runs, and no other words for vertices. All other files go
to the reader of lines, which names what is wrong.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np

from geosurf.read._blocks import TextBlocks
from geosurf.read._decimals import TENS, Words

FEWEST = 100_000  # bytes; below, lines are as fast
BYTES_IN_A_RUN = 250  # on average; below, lines are as fast
SHORTEST = 9  # bytes of a vertex or a triangle, with its line end
OTHERS = re.compile(r"^\s*(?:P?VRTX|P?ATOM|TRGL)\b", re.MULTILINE | re.IGNORECASE)
OBJECT = re.compile(r"^\s*GOCAD\b", re.MULTILINE | re.IGNORECASE)
BEGINNING = re.compile(rb"^(?:VRTX|TRGL)[ \t]", re.MULTILINE)


@dataclass
class _Object:
    """One object while its runs go by."""

    others: list[str] = field(default_factory=list)
    ids: list[np.ndarray] = field(default_factory=list)
    points: list[np.ndarray] = field(default_factory=list)
    corners: list[np.ndarray] = field(default_factory=list)
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


def plain_objects(path: Path) -> list[PlainObject] | None:
    """
    Return the objects of a large plain file, or None if it has to be read line by line.

    Parameters
    ----------
    path : pathlib.Path

    Raises
    ------
    FormatError
        If the file is empty or no text.
    """
    blocks = TextBlocks(path, final_line_end=False)
    if blocks.size < FEWEST:
        return None
    found: list[_Object] = []
    n_run = 0
    for _, piece in blocks:
        if not piece.isascii():
            return None
        for part in _parts(piece):
            n_run += 1
            if not _take(found, part):
                return None
        if n_run * BYTES_IN_A_RUN > blocks.size:
            return None
    plain = []
    while found:
        one = _arrays(found.pop(0))
        if one is None:
            return None
        plain.append(one)
    return plain


def _take(found: list[_Object], part: str | tuple[np.ndarray, ...]) -> bool:
    """Add a part of the text to its object; False if it belongs to none."""
    if isinstance(part, str):
        heads = [match.start() for match in OBJECT.finditer(part)]
        cuts = [0, *heads, len(part)]
        if found:
            found[-1].others.append(part[: cuts[1]])
        elif part[: cuts[1]].strip():
            return False  # lines before the first object
        found += [_Object([part[a:b]]) for a, b in pairwise(cuts[1:])]
        return True
    if not found:
        return False
    one = found[-1]
    if len(part) == 2:
        one.ids.append(part[0])
        one.points.append(part[1])
        one.n_vertex += len(part[0])
    else:
        one.corners.append(part[0])
        one.defined.append(one.n_vertex)
    return True


def _parts(piece: str) -> Iterator[str | tuple[np.ndarray, ...]]:
    """Yield what whole lines hold: other lines, ids and points of a run, or corners of a run."""
    from geosurf.kernels.text.gocad_lines import triangle_run, vertex_run

    words = Words.of(piece.encode())
    data, end = words.data, len(words.data)
    most = end // SHORTEST + 1
    ids, points = np.empty(most, dtype=np.int64), np.empty((most, 3))
    hard = np.empty((3 * most, 3), dtype=np.int64)
    corners = np.empty((most, 3), dtype=np.int64)
    at = 0
    while at < end:
        start = at
        if data.startswith(b"VRTX", at):
            n, n_hard, at = vertex_run(words.packed, at, end, TENS, ids, points, hard)
            if not words.read_hard(points.reshape(-1), hard[:n_hard]):
                yield data[start:].decode()
                return
            if n:
                yield ids[:n].copy(), points[:n].copy()
                continue
        elif data.startswith(b"TRGL", at):
            n, at = triangle_run(words.packed, at, end, corners)
            if n:
                yield (corners[:n].copy(),)
                continue
        # other lines, up to the next vertex or triangle after this line
        line_end = data.find(b"\n", start) + 1 or end
        following = BEGINNING.search(data, line_end)
        at = following.start() if following else end
        yield data[start:at].decode()


def _arrays(one: _Object) -> PlainObject | None:
    """Points and triangles of an object, or None if a line of it is unusual."""
    rest = "".join(one.others)
    if OTHERS.search(rest):
        return None
    if not one.ids and not one.corners:
        return PlainObject(rest, np.empty((0, 3)), np.empty((0, 3), dtype=np.int64))
    if not one.corners or not one.ids:
        return None
    points, ids = np.concatenate(one.points), np.concatenate(one.ids)
    one.points.clear()
    counts = [len(part) for part in one.corners]
    corners = np.concatenate(one.corners)
    one.corners.clear()
    rows = _rows(ids, corners)
    if rows is None:
        return None
    # vertices stand above the triangles that use them
    at = 0
    for count, defined in zip(counts, one.defined, strict=True):
        if rows[at : at + count].max() >= defined:
            return None
        at += count
    return PlainObject(rest, points, rows)


def _rows(ids: np.ndarray, corners: np.ndarray) -> np.ndarray | None:
    """Rows of the vertices that triangles name, or None if one is absent or occurs twice."""
    # most programs count from 0 or 1
    if (np.diff(ids) == 1).all():
        corners -= ids[0]
        return corners if corners.min() >= 0 and corners.max() < len(ids) else None
    order = np.argsort(ids, kind="stable")
    ranked = ids[order]
    at = np.minimum(np.searchsorted(ranked, corners), len(ids) - 1)
    if (np.diff(ranked) == 0).any() or (ranked[at] != corners).any():
        return None
    return order[at]
