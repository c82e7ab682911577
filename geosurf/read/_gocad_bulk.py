"""Vertices and triangles of a large plain TSurf, all at once.

Plain is a file of one TSurf whose VRTX lines follow one another, and whose TRGL lines do. Anything
else is None: the reader of lines, which names what is wrong, takes such files.
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
    vertex_run, triangle_run = _run(text, "VRTX", 0), _run(text, "TRGL", 0)
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
    if vertices is None or any(sign in triangle_text for sign in ".eE+-"):
        return None
    corners = _table(triangle_text, 3)
    rows = None if corners is None else _rows(vertices[:, 0], corners)
    return None if rows is None else (rest, vertices[:, 1:].copy(), rows)


def _run(text: str, key: str, start: int) -> tuple[int, int] | None:
    """Where the first run of lines that begin with a key begins and ends."""
    first = re.compile(rf"^{key} ", re.MULTILINE).search(text, start)
    if first is None:
        return None
    after = re.compile(rf"^(?!{key} )", re.MULTILINE).search(text, first.start() + 1)
    return first.start(), after.start() if after else len(text)


def _table(text: str, width: int) -> np.ndarray | None:
    """Numbers (n, width) of lines that have as many, or None."""
    if (words_per_line(text)[:-1] != width).any():
        return None
    values = plain_numbers(text)
    return None if values is None else values.reshape(-1, width)


def _rows(ids: np.ndarray, corners: np.ndarray) -> np.ndarray | None:
    """Rows of the vertices that triangles name, or None if one is absent or occurs twice."""
    if max(ids.max(), corners.max()) >= 2.0**53:
        return None
    # most programs count from 0 or 1
    if (np.diff(ids) == 1).all():
        rows = corners - ids[0]
        inside = rows.min() >= 0 and rows.max() < len(ids)
        return rows.astype(np.int64) if inside else None
    order = np.argsort(ids, kind="stable")
    ranked = ids[order]
    at = np.minimum(np.searchsorted(ranked, corners), len(ids) - 1)
    if (np.diff(ranked) == 0).any() or (ranked[at] != corners).any():
        return None
    return order[at].astype(np.int64)
