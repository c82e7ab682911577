"""Strips of triangles along a rim: notches filled, lengths smoothed, lines joined."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from geosurf.faults.rim import total

LEADS = 0.05  # of a side: steps at its ends that lead on by less are left to its neighbours


def without_notches(x: np.ndarray, arc: np.ndarray, way: np.ndarray) -> tuple[Any, np.ndarray]:
    """An arc with filled notches, as seen along its mean direction, and the triangles in them.

    The upper hull of the arc (Andrew 1979): of three vertices in turn the middle one is left
    behind if it lies short of the line that joins the others. No vertex is new. Whether the
    triangles may stay is decided later, exactly.
    """
    ahead = total(way)
    ahead /= max(float(np.linalg.norm(ahead)), np.finfo(float).tiny)

    # the arc in a plane: how far along the side, and how far ahead
    along = x[arc[-1]] - x[arc[0]]
    along = along - (along @ ahead) * ahead
    plane = x[arc] @ np.stack([along, ahead], axis=1)
    reach = float(along @ along)

    # three in turn: the middle one goes, and leaves a triangle, where it lies behind
    chain: list[int] = []
    filled = []
    for c in range(len(arc)):
        while len(chain) > 1:
            a, b = chain[-2:]
            (s, h), (u, v) = plane[b] - plane[a], plane[c] - plane[a]
            if s * v - h * u <= 1e-9 * (abs(s * v) + abs(h * u)):  # on the line: no notch
                break
            filled.append((arc[a], arc[c], arc[chain.pop()]))
        chain.append(c)
    # steps at the ends that do not lead on belong to the sides next to this one
    while len(chain) > 1 and plane[chain[1], 0] <= plane[chain[0], 0] + LEADS * reach:
        chain.pop(0)
    while len(chain) > 1 and plane[chain[-1], 0] <= plane[chain[-2], 0] + LEADS * reach:
        chain.pop()
    return arc[chain], np.array(filled, dtype=np.int64).reshape(-1, 3)


def filled_lengths(length: np.ndarray) -> np.ndarray:
    """Lengths with those that are not known taken from the nearest two, the longer one."""
    # ranks of the nearest known lengths to the left and right of each row, clipped at the ends
    known = np.flatnonzero(np.isfinite(length))
    rows = np.arange(len(length))
    right = np.minimum(np.searchsorted(known, rows), len(known) - 1)
    left = np.maximum(np.searchsorted(known, rows, side="right") - 1, 0)
    both = np.maximum(length[known[left]], length[known[right]])
    return np.where(np.isfinite(length), length, both)


def strip(arc: np.ndarray, n: int, near: np.ndarray, far: np.ndarray) -> np.ndarray:
    """Two triangles for each step of an arc, facing as the triangles behind it do.

    The shorter diagonal; where both are as long, the one from the lesser corner of the rim.
    """
    # near rows of the strip are the arc, far ones are the new vertices n, n + 1, ... in its order
    a, b = arc[:-1], arc[1:]
    c, d = n + np.arange(len(arc) - 1), n + np.arange(1, len(arc))

    # squares of both diagonals; ties are decided by coordinates, not by numbering
    one = ((near[:-1] - far[1:]) ** 2).sum(axis=1)
    two = ((near[1:] - far[:-1]) ** 2).sum(axis=1)
    lesser = np.array([tuple(p) < tuple(q) for p, q in pairwise(near)])
    from_a = (one < two) | ((one == two) & lesser)
    first = np.where(from_a[:, None], np.stack([b, a, d], 1), np.stack([b, a, c], 1))
    second = np.where(from_a[:, None], np.stack([a, c, d], 1), np.stack([b, c, d], 1))
    return np.stack([first, second], axis=1).reshape(-1, 3)
