"""Which sides of triangles lie in one part of space: slow and obvious. Never imports geosurf.

Triangles that meet in common corners and edges only enclose space where sets of them have each
edge twice or four times or never: cycles modulo 2. A basis of these tells parts of space apart, by
Alexander duality: two places lie in one part if a line from each crosses every cycle of the basis
as often, odd or even. So no order around edges is asked for, and no shell for what is inside it.
"""

from __future__ import annotations

import numpy as np

from tests import oracles


def cycles(triangles) -> list[int]:
    """A set of bits for each of the distinct triangles: the cycles of a basis that it is in.

    As many cycles as there are bounded parts (`oracles.n_cell`).
    """
    edges: dict[tuple[int, int], int] = {}
    pivots: dict[int, tuple[int, int]] = {}
    found = []
    for k, (a, b, c) in enumerate(triangles):
        row, made = 0, 1 << k
        for edge in ((a, b), (a, c), (b, c)):
            row ^= 1 << edges.setdefault(edge, len(edges))
        while row and row.bit_length() in pivots:
            other, of = pivots[row.bit_length()]
            row, made = row ^ other, made ^ of
        if row:
            pivots[row.bit_length()] = row, made
        else:
            found.append(made)
    return [
        sum(1 << number for number, made in enumerate(found) if made >> k & 1)
        for k in range(len(triangles))
    ]


def beside(points, triangles) -> np.ndarray:
    """
    Parts of space in front of each triangle and behind it: equal numbers, equal parts; 0 outside.

    Parameters
    ----------
    points : array of float64, shape (n, 3)
    triangles : array of int, shape (m, 3)
        That meet in common corners and edges only; the same one may be given twice, turned or not.
    """
    points, triangles = np.asarray(points, dtype=float), np.asarray(triangles)
    distinct, which = np.unique(np.sort(triangles, axis=1), axis=0, return_inverse=True)
    cycle = cycles(distinct.tolist())
    corners = points[distinct]
    out, numbers = np.empty((len(triangles), 2), dtype=np.int64), {0: 0}
    ahead = []  # of the front of the distinct triangle, and behind it
    for row in range(len(distinct)):
        side, there = crossed(corners, row)
        part = 0
        for k in there:
            part ^= cycle[k]
        other = part ^ cycle[row]
        ahead.append((part, other) if side > 0 else (other, part))
    for i, (k, triangle) in enumerate(zip(which.ravel().tolist(), triangles.tolist(), strict=True)):
        turns = sum(triangle[j] < triangle[(j + 1) % 3] for j in range(3)) == 2
        parts = ahead[k] if turns else ahead[k][::-1]
        out[i] = [numbers.setdefault(part, len(numbers)) for part in parts]
    return out


def crossed(corners, row: int) -> tuple[int, np.ndarray]:
    """
    On which side a line from the middle of a triangle leaves it, and which others it crosses.

    Parameters
    ----------
    corners : ndarray of float64, shape (n, 3, 3)
    row : int

    Returns
    -------
    side : int
        1 in front, -1 behind.
    there : ndarray of int64
    """
    rng = np.random.default_rng(row)
    exact = oracles.rational(corners[row])
    middle = tuple(sum(values) / 3 for values in zip(*exact, strict=True))
    while True:
        way = rng.integers(-999, 1000, 3)
        side = oracles.sign(oracles.dot(oracles.normal_of(exact), way.tolist()))
        hit, sure = by_floats(corners, np.array(oracles.rounded(middle)), way)
        sure[row], hit[row] = True, False
        for k in np.flatnonzero(~sure).tolist():
            hit[k], sure[k] = by_fractions(oracles.rational(corners[k]), middle, way.tolist())
        if side and sure.all():
            return side, np.flatnonzero(hit)


def by_floats(corners, middle, way) -> tuple[np.ndarray, np.ndarray]:
    """Whether a half line meets triangles, and whether rounding cannot have changed the answer."""
    a, b, c = (corners[:, k] - middle for k in range(3))
    far = np.linalg.norm([a, b, c], axis=2).max(axis=0)
    doubt = 128 * 2.0**-52 * np.abs(corners).max() * far * np.linalg.norm(way)
    turns = np.stack([np.cross(p, q) @ way for p, q in ((a, b), (b, c), (c, a))])
    normal = np.cross(b - a, c - a)
    rise, height = normal @ way, np.einsum("ij,ij->i", normal, a)
    plain = (np.abs(turns) > doubt).all(axis=0)
    past = (turns > doubt).any(axis=0) & (turns < -doubt).any(axis=0)
    away = (np.abs(rise) > doubt) & (np.abs(height) > doubt * far)
    hit = ~past & (height * rise > 0)
    return hit, past | (plain & away)


def by_fractions(corners, middle, way) -> tuple[bool, bool]:
    """The same, exactly; unsure where the line meets an edge, or lies in the plane."""
    a, b, c = (oracles.minus(corner, middle) for corner in corners)
    signs = [
        oracles.sign(oracles.dot(oracles.cross(p, q), way)) for p, q in ((a, b), (b, c), (c, a))
    ]
    normal = oracles.normal_of(corners)
    rise, height = oracles.sign(oracles.dot(normal, way)), oracles.sign(oracles.dot(normal, a))
    if {1, -1} <= set(signs):
        return False, True
    return height * rise > 0, 0 not in signs and rise * height != 0
