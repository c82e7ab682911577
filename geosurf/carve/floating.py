"""Pieces of surfaces that touch nothing else: which cell holds each is asked with a ray.

A ray that meets nothing more has left the model: its piece lies beyond the walls, as a fault in
a corner of the bounds that the area of interest does not reach. It is put into the space outside.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from geosurf.conventions import place
from geosurf.errors import InvariantError

NOTHING = -1


def place_floating(
    x: np.ndarray, t: np.ndarray, piece: np.ndarray, fixed: np.ndarray, shell: np.ndarray
) -> np.ndarray:
    """Unite the outer shell of each floating piece with the cell, or the outside, that holds it.

    Parameters
    ----------
    x, t : ndarray
        Points and triangles.
    piece : ndarray of int64, shape (n_triangle,)
        Connected piece of each triangle.
    fixed : ndarray of int64
        Pieces that do not float: those of the walls, one at least.
    shell : ndarray of int64, shape (2 * n_triangle,)
        Shell of each side of each triangle.

    Returns
    -------
    ndarray of int64, shape (2 * n_triangle,)

    Raises
    ------
    InvariantError
        If no ray passes through a piece, which has no area then.

    Examples
    --------
    A tetrahedron as the wall, a triangle in it and one beside it, below nothing:

    >>> x = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9], [1, 1, 1], [2, 1, 1], [1, 2, 1],
    ...               [8, 8, 1], [9, 8, 1], [8, 9, 1]], dtype=float)
    >>> t = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3], [4, 5, 6], [7, 8, 9]])
    >>> outer, inner = 0, 1  # shells of the wall: normals point out
    >>> shell = np.array([outer, inner] * 4 + [8, 8, 10, 10])
    >>> piece = np.array([0, 0, 0, 0, 4, 5])
    >>> place_floating(x, t, piece, np.array([0]), shell)[8:].tolist()
    [1, 1, 0, 0]
    """
    sides = shell.copy()
    floating = np.setdiff1d(piece, fixed)
    shots = {p: shoot(x, t, np.flatnonzero(piece == p), piece == p) for p in floating}
    for p, (outer, holding) in shots.items():
        while True:
            label = sides[outer]
            group = [q for q in floating if sides[shots[q][0]] == label]
            if not np.isin(piece[np.flatnonzero(sides == label) // 2], group).all():
                break
            # pieces that float side by side may see each other only: ask beyond all of them
            if len(group) > 1:
                _, holding = shoot(x, t, np.flatnonzero(piece == p), np.isin(piece, group))
            if holding == NOTHING:
                # the topmost side of the walls sees the outside as well
                walls = np.isin(piece, fixed)
                holding, _ = shoot(x, t, np.flatnonzero(walls), walls)
            sides[sides == label] = sides[holding]
    return sides


def shoot(x, t, mine, member):
    """Sides (outer, holding) met by a ray through a piece, and beyond all members.

    `holding` is `NOTHING` where the ray meets no more.

    The ray runs along the axis on which the piece's first triangle is widest. It aims at
    rational points inside that triangle until it misses all edges; hits are exact. The points
    lie on a conic: an edge is in the way of two of them at most, so one of 6 n + 1 is free.
    """
    a, b, c = x[t[mine[0]]]
    axis = int(np.argmax(np.abs(np.cross(b - a, c - a))))
    u, v = (axis + 1) % 3, (axis + 2) % 3
    low, high = x[t].min(axis=1), x[t].max(axis=1)
    for step in range(1, 6 * len(t) + 2):
        ratio = Fraction(step + 30, 40)
        total = 1 + ratio + ratio * ratio
        weights = (1 / total, ratio / total, ratio * ratio / total)
        aim = [
            sum(f * Fraction(p[k]) for f, p in zip(weights, (a, b, c), strict=True)) for k in (u, v)
        ]
        near = (low[:, u] <= float(aim[0]) + 1e-6) & (high[:, u] >= float(aim[0]) - 1e-6)
        near &= (low[:, v] <= float(aim[1]) + 1e-6) & (high[:, v] >= float(aim[1]) - 1e-6)
        hits = [_hit(x[t[i]], axis, u, v, aim) for i in np.flatnonzero(near)]
        if None in hits:
            continue  # the ray grazes an edge: aim elsewhere
        met = [(h[0], i, h[1]) for i, h in zip(np.flatnonzero(near), hits, strict=True) if h]
        top = max((hit for hit in met if member[hit[1]]), key=lambda hit: hit[0])
        above = [hit for hit in met if not member[hit[1]] and hit[0] > top[0]]
        # the side towards +axis is the front where the normal points there
        outer = 2 * top[1] + (0 if top[2] > 0 else 1)
        if not above:
            return outer, NOTHING
        first = min(above, key=lambda hit: hit[0])
        return outer, 2 * first[1] + (1 if first[2] > 0 else 0)
    raise InvariantError(
        f"no ray passes through the inside of a floating triangle at {place(a)} in local "
        "coordinates; please report this with the surfaces."
    )


def _hit(corners, axis, u, v, aim):
    """(height, sign of the normal along the axis), () for a miss, None on an edge."""
    p = [[Fraction(float(c[k])) for k in (u, v, axis)] for c in corners]
    areas = []
    for i in range(3):
        q, r = p[i], p[(i + 1) % 3]
        areas.append((q[0] - aim[0]) * (r[1] - aim[1]) - (q[1] - aim[1]) * (r[0] - aim[0]))
    if all(area > 0 for area in areas) or all(area < 0 for area in areas):
        total = sum(areas)
        height = sum(areas[(i + 1) % 3] * p[i][2] for i in range(3)) / total
        return height, 1 if total > 0 else -1
    if any(area > 0 for area in areas) and any(area < 0 for area in areas):
        return ()
    return None
