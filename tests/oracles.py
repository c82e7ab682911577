"""Slow, obvious answers in rational arithmetic. Never imports geosurf.

Signs are determinants by Gaussian elimination, which divides; triangles meet by clipping one
convex set with the other's half-spaces. Neither has a formula in common with the kernels.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from fractions import Fraction

import numpy as np

Point = tuple[Fraction, ...]


def rational(points) -> list[Point]:
    """Rows of numbers as tuples of fractions, without rounding."""
    return [tuple(Fraction(float(value)) for value in point) for point in points]


def rounded(point: Iterable[Fraction]) -> tuple[float, ...]:
    """The nearest doubles: int / int is correctly rounded, ties to even."""
    return tuple(f.numerator / f.denominator for f in point)


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


# ------------------------------------------------------------------ convex sets
def minus(p: Point, q: Point) -> Point:
    return tuple(a - b for a, b in zip(p, q, strict=True))


def dot(p: Point, q: Point) -> Fraction:
    return sum((a * b for a, b in zip(p, q, strict=True)), Fraction(0))


def cross(p: Point, q: Point) -> Point:
    return (p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0])


def normal_of(triangle: Sequence[Point]) -> Point:
    """Where a triangle's front looks."""
    a, b, c = triangle
    return cross(minus(b, a), minus(c, a))


def clip(points: set[Point], normal: Point, through: Point) -> set[Point]:
    """Corners (and perhaps more points) of a convex set's part where the normal points."""
    height = {p: dot(normal, minus(p, through)) for p in points}
    out = {p for p, h in height.items() if h >= 0}
    above = [(p, h) for p, h in height.items() if h > 0]
    below = [(p, h) for p, h in height.items() if h < 0]
    for (p, hp), (q, hq) in itertools.product(above, below):
        t = hp / (hp - hq)
        out.add(tuple(a + t * (b - a) for a, b in zip(p, q, strict=True)))
    return out


def extreme(points: set[Point]) -> list[Point]:
    """Corners of the convex hull of points of one plane, in lexicographic order.

    A point is no corner if it lies between two others, or inside a triangle of others.
    """
    points = sorted(points)
    corners = []
    for p in points:
        others = [q for q in points if q != p]
        if any(_between(p, q, r) for q, r in itertools.combinations(others, 2)):
            continue
        if any(_inside(p, trio) for trio in itertools.combinations(others, 3)):
            continue
        corners.append(p)
    return corners


def _between(p: Point, q: Point, r: Point) -> bool:
    one, two = minus(q, p), minus(r, p)
    return not any(cross(one, two)) and dot(one, two) < 0


def _inside(p: Point, trio) -> bool:
    normal = cross(minus(trio[1], trio[0]), minus(trio[2], trio[0]))
    if not any(normal):
        return False
    return all(weight > 0 for weight in weights(trio, p))


def weights(triangle: Sequence[Point], p: Point) -> tuple[Fraction, ...]:
    """Barycentric coordinates of a point of a triangle's plane."""
    a, b, c = triangle
    normal = cross(minus(b, a), minus(c, a))
    size = dot(normal, normal)
    assert dot(normal, minus(p, a)) == 0, "the point is not in the plane"
    out = []
    for q, r in ((b, c), (c, a), (a, b)):
        out.append(dot(normal, cross(minus(q, p), minus(r, p))) / size)
    assert sum(out) == 1
    return tuple(out)


def feature(triangle, p: Point) -> str | None:
    """The lowest-dimensional feature of a triangle that holds a point: what a name must mean."""
    value = weights(rational(triangle), p)
    if min(value) < 0:
        return None
    zero = [i for i in range(3) if value[i] == 0]
    if len(zero) == 2:
        return f"vertex {3 - sum(zero)}"
    return f"edge {(zero[0] + 1) % 3}" if zero else "face"


def flat(triangle) -> bool:
    return not any(normal_of(rational(triangle)))


def coplanar(P, Q) -> bool:
    return all(orient3d(*P, q) == 0 for q in Q)


def meet_triangles(P, Q) -> list[Point]:
    """Corners of the intersection of two triangles, exact."""
    a, b, c = rational(Q)
    normal = cross(minus(b, a), minus(c, a))
    points = set(rational(P))
    points = clip(points, normal, a)
    points = clip(points, tuple(-n for n in normal), a)
    for p, q in ((a, b), (b, c), (c, a)):
        points = clip(points, cross(normal, minus(q, p)), p)
    return extreme(points)


def straddles(P, Q) -> bool:
    """Whether P has corners on both sides of the plane of Q."""
    signs = [orient3d(*Q, p) for p in P]
    return min(signs) < 0 < max(signs)


def area(corners: Sequence[Point]) -> float:
    """Area of a convex polygon of up to six corners in any order."""
    middle = tuple(sum(c) / len(corners) for c in zip(*corners, strict=True))
    order = _around(corners, middle)
    total = (Fraction(0),) * 3
    for p, q in zip(order, order[1:] + order[:1], strict=True):
        part = cross(minus(p, middle), minus(q, middle))
        total = tuple(s + t for s, t in zip(total, part, strict=True))
    return 0.5 * math.sqrt(dot(total, total))


def _around(corners, middle):
    floats = np.array([rounded(minus(p, middle)) for p in corners])
    _, _, axes = np.linalg.svd(floats)
    return [corners[i] for i in np.argsort(np.arctan2(floats @ axes[1], floats @ axes[0]))]


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
