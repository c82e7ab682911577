"""Vertices and triangles of a large plain TSurf, all at once.

A plain file has one TSurf, all VRTX lines in one run and all TRGL lines in another. All other
files go to the reader of lines, which names what is wrong.
"""

from __future__ import annotations

import re

import numpy as np

from geosurf.read._common import plain_numbers
from geosurf.read._table import words_per_line

FEWEST = 100_000  # characters; below, lines are as fast
OTHERS = re.compile(r"^\s*(?:P?VRTX|P?ATOM|TRGL)\b", re.MULTILINE | re.IGNORECASE)
NOT_WHOLE = re.compile(r"VRTX[ \t]+\d*[^\d\s]")  # an id that is no plain whole number
OBJECT = re.compile(r"^\s*GOCAD\b", re.MULTILINE | re.IGNORECASE)


def plain_tsurf(text: str) -> tuple[str, np.ndarray, np.ndarray] | None:
    """
    Return what is left of a TSurf without vertices and triangles, and these.

    Parameters
    ----------
    text : str

    Returns
    -------
    (str, ndarray of float64, shape (n, 3), ndarray of int64, shape (m, 3)) or None
        Head and tail of the file; coordinates as in the file; rows of vertices.
    """
    if len(text) < FEWEST or len(OBJECT.findall(text[:FEWEST])) != 1:
        return None
    vertex_run, triangle_run = _run(text, "\nVRTX "), _run(text, "\nTRGL ")
    if vertex_run is None or triangle_run is None or vertex_run[1] > triangle_run[0]:
        return None
    parts = (text[: vertex_run[0]], text[vertex_run[1] : triangle_run[0]], text[triangle_run[1] :])
    rest = "".join(parts)
    if OTHERS.search(rest) or len(OBJECT.findall(rest)) != 1:
        return None

    vertex_text = text[slice(*vertex_run)]
    if NOT_WHOLE.search(vertex_text):
        return None
    vertices = _table(vertex_text.replace("VRTX", " ").replace("CNXYZ", " "), 4)
    triangle_text = text[slice(*triangle_run)].replace("TRGL", " ")
    if vertices is None:
        return None
    corners = _whole_table(triangle_text, 3)
    rows = None if corners is None else _rows(vertices[:, 0], corners)
    return None if rows is None else (rest, vertices[:, 1:].copy(), rows)


def _run(text: str, key: str) -> tuple[int, int] | None:
    """Where the lines that begin with a key begin and end, if no others lie between them."""
    first, last = text.find(key), text.rfind(key)
    end = text.find("\n", last + 1)
    if first < 0 or end < 0 or text.count(key, first, end) != text.count("\n", first, end):
        return None
    return first + 1, end + 1


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
