"""Slow, obvious answers in rational arithmetic. Never imports geosurf.

Signs are determinants by Gaussian elimination, which divides; triangles meet by clipping one
convex set with the other's half-spaces (`benchmarks.stress.rational`). Neither has a formula in
common with the kernels.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from benchmarks.stress.rational import (
    area,
    clip,
    cross,
    dot,
    feature,
    flat,
    meet,
    minus,
    normal_of,
    rounded,
    straddles,
)

__all__ = ["clip", "feature", "flat", "normal_of", "rounded", "straddles"]  # beside those below

Point = tuple[Fraction, ...]


def rational(points) -> list[Point]:
    """Rows of numbers as tuples of fractions, without rounding."""
    return [tuple(Fraction(float(value)) for value in point) for point in points]


def sign(value) -> int:
    return (value > 0) - (value < 0)


def determinant(rows: Sequence[Sequence[Fraction]]) -> Fraction:
    """By elimination with divisions."""
    matrix = [[Fraction(value) for value in row] for row in rows]
    out = Fraction(1)
    for k in range(len(matrix)):
        pivot = next((i for i in range(k, len(matrix)) if matrix[i][k] != 0), None)
        if pivot is None:
            return Fraction(0)
        if pivot != k:
            matrix[k], matrix[pivot] = matrix[pivot], matrix[k]
            out = -out
        out *= matrix[k][k]
        for i in range(k + 1, len(matrix)):
            factor = matrix[i][k] / matrix[k][k]
            matrix[i] = [p - factor * q for p, q in zip(matrix[i], matrix[k], strict=True)]
    return out


def orient2d(a, b, c) -> int:
    return sign(determinant([[*p, 1] for p in rational((a, b, c))]))


def orient3d(a, b, c, o) -> int:
    return -sign(determinant([[*p, 1] for p in rational((a, b, c, o))]))


def incircle(a, b, c, o) -> int:
    rows = rational((a, b, c, o))
    return sign(determinant([[x, y, x * x + y * y, 1] for x, y in rows]))


def coplanar(P, Q) -> bool:
    return all(orient3d(*P, q) == 0 for q in Q)


def meet_triangles(P, Q) -> list[Point]:
    """Corners of the intersection of two triangles, in order around it, exact."""
    return meet(rational(P), rational(Q))


# --------------------------------------------------------------------- surfaces
def all_contacts(A, B):
    """(i, j, corners) of all pairs of triangles of two surfaces (V, F) that meet."""
    found = []
    for i, P in enumerate(np.asarray(A[0])[A[1]]):
        for j, Q in enumerate(np.asarray(B[0])[B[1]]):
            if (P.min(axis=0) > Q.max(axis=0)).any() or (Q.min(axis=0) > P.max(axis=0)).any():
                continue
            corners = meet_triangles(P, Q)
            if corners:
                found.append((i, j, corners))
    return found


def _between(p: Point, q: Point, r: Point) -> bool:
    one, two = minus(q, p), minus(r, p)
    return not any(cross(one, two)) and dot(one, two) < 0


def curves(A, B):
    """What two meshes have in common: segments and touching points off them, exact, and the area.

    Segments are those of pairs of triangles; meshes whose triangles meet in whole edges need no
    further cutting.
    """
    contacts = [corners for _, _, corners in all_contacts(A, B)]
    segments = {frozenset(c) for c in contacts if len(c) == 2}
    overlap = sum(area(c) for c in contacts if len(c) > 2)
    taken = {p for c in contacts if len(c) > 1 for p in c}
    single = {c[0] for c in contacts if len(c) == 1} - taken
    single = {p for p in single if not any(_between(p, *sorted(s)) for s in segments)}
    return segments, single, overlap


def volume(vertices, triangles) -> Fraction:
    """Signed volume of a closed shell, exact."""
    corners = rational(vertices)
    total = Fraction(0)
    for a, b, c in np.asarray(triangles).tolist():
        total += dot(corners[a], cross(corners[b], corners[c]))
    return total / 6


def n_cell(triangles) -> int:
    """How many bounded parts space falls into, by Alexander duality: triangles that meet in common
    corners and edges only have as many closed 2-cycles (modulo 2) that are independent.
    """
    edges: dict[tuple[int, ...], int] = {}
    pivots: dict[int, int] = {}
    rank = 0
    distinct = {tuple(sorted(t)) for t in np.asarray(triangles).tolist()}
    for a, b, c in distinct:
        row = 0
        for edge in ((a, b), (a, c), (b, c)):
            row ^= 1 << edges.setdefault(edge, len(edges))
        while row and row.bit_length() in pivots:
            row ^= pivots[row.bit_length()]
        if row:
            pivots[row.bit_length()] = row
            rank += 1
    return len(distinct) - rank
