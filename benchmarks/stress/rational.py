"""Two triangles in fractions: slow, obvious, and without a formula in common with the kernels.

The kernels take signs of determinants of named points. Here a triangle is a convex set: it is cut
with the plane of the other and clipped by its three half-planes, with divisions, and nothing
is ever rounded. Points are tuples of `fractions.Fraction`.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction

import numpy as np

Point = tuple[Fraction, Fraction, Fraction]


def rational(points: Iterable[Sequence[float]]) -> list[Point]:
    """Rows of floats as points, without rounding.

    Examples
    --------
    >>> rational([[0.5, 1, 2]])
    [(Fraction(1, 2), Fraction(1, 1), Fraction(2, 1))]
    """
    return [(Fraction(float(x)), Fraction(float(y)), Fraction(float(z))) for x, y, z in points]


def rounded(point: Point) -> tuple[float, ...]:
    """The nearest doubles: a quotient of integers is rounded correctly."""
    return tuple(f.numerator / f.denominator for f in point)


def minus(p: Point, q: Point) -> Point:
    """Vector from q to p."""
    return (p[0] - q[0], p[1] - q[1], p[2] - q[2])


def dot(p: Point, q: Point) -> Fraction:
    """Inner product."""
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


def cross(p: Point, q: Point) -> Point:
    """Vector product."""
    return (p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0])


def normal_of(triangle: Sequence[Point]) -> Point:
    """Twice the area vector of a triangle."""
    a, b, c = triangle
    return cross(minus(b, a), minus(c, a))


def flat(corners: Sequence[Sequence[float]] | np.ndarray) -> bool:
    """Whether a triangle of floats (3, 3) has no area.

    Examples
    --------
    >>> flat([[0, 0, 0], [1, 2, 3], [2, 4, 6]])
    True
    """
    return not any(normal_of(rational(corners)))


def meet(first: Sequence[Point], second: Sequence[Point]) -> list[Point]:
    """Corners of what two triangles have in common, in order around it; none if apart.

    Examples
    --------
    >>> flat, steep = [[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[1, 1, -1], [1, 1, 1], [9, 9, 1]]
    >>> [rounded(p) for p in meet(rational(flat), rational(steep))]
    [(1.0, 1.0, 0.0), (2.0, 2.0, 0.0)]
    """
    # first with the plane of the second: a triangle, a segment or a point is left
    normal = normal_of(second)
    points = _cut(list(first), normal, second[0])

    # then with the three half-planes of its edges, seen along its normal (Sutherland & Hodgman
    # 1974)
    for p, q in zip(second, (*second[1:], second[0]), strict=True):
        points = clip(points, cross(normal, minus(q, p)), p)
    return points


def _heights(points: list[Point], normal: Point, through: Point) -> list[Fraction]:
    level = dot(normal, through)
    return [dot(normal, p) - level for p in points]


def _ring(
    points: list[Point], heights: list[Fraction]
) -> Iterator[tuple[tuple[Point, Fraction], tuple[Point, Fraction]]]:
    """Consecutive corners of a closed chain with their heights."""
    corners = list(zip(points, heights, strict=True))
    return zip(corners, corners[1:] + corners[:1], strict=True)


def _between(p: Point, hp: Fraction, q: Point, hq: Fraction) -> Point:
    """The point of height 0."""
    # exact: a division of fractions
    t = hp / (hp - hq)
    return (p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]), p[2] + t * (q[2] - p[2]))


def _cut(points: list[Point], normal: Point, through: Point) -> list[Point]:
    """The part of a convex polygon that lies in a plane."""
    out = []
    for (p, hp), (q, hq) in _ring(points, _heights(points, normal, through)):
        if hp == 0:
            out.append(p)

        # strictly on opposite sides: points in the plane have been added as such
        elif hp * hq < 0:
            out.append(_between(p, hp, q, hq))

    # neighbours may give the same corner twice: equal fractions are one point
    return list(dict.fromkeys(out))


def clip(points: list[Point], normal: Point, through: Point) -> list[Point]:
    """The part of a convex polygon (or segment, or point) on the side where a normal points."""
    out = []
    for (p, hp), (q, hq) in _ring(points, _heights(points, normal, through)):
        if hp >= 0:
            out.append(p)
        if hp * hq < 0:
            out.append(_between(p, hp, q, hq))
    return list(dict.fromkeys(out))


def sides(first: Sequence[Point], second: Sequence[Point]) -> tuple[int, int, int]:
    """On which side of the plane of the second triangle the corners of the first one lie."""
    heights = _heights(list(first), normal_of(second), second[0])
    a, b, c = ((h > 0) - (h < 0) for h in heights)
    return a, b, c


def straddles(first: Sequence[Point], second: Sequence[Point]) -> bool:
    """Whether the first triangle has corners strictly on both sides of the second one's plane."""
    signs = sides(first, second)
    return min(signs) < 0 < max(signs)


def feature(triangle: Sequence[Point], p: Point) -> str:
    """The lowest-dimensional feature of a triangle that holds one of its points."""
    a, b, c = triangle
    normal = normal_of(triangle)

    # lines of edges that the point is on; it lies in the triangle, so two of them meet in a corner
    zero = [
        i
        for i, (q, r) in enumerate(((a, b), (b, c), (c, a)))
        if dot(normal, cross(minus(q, p), minus(r, p))) == 0
    ]
    if len(zero) == 2:  # on two edges: their common corner
        return f"vertex {0 if zero == [0, 2] else zero[1]}"
    return f"edge {zero[0]}" if zero else "face"


def area(corners: Sequence[Point]) -> float:
    """Area of a convex polygon with its corners in order."""
    # a fan from the first corner; the sum of normals is exact, only its length is rounded
    total: tuple[Fraction, ...] = (Fraction(0),) * 3
    for p, q in itertools.pairwise(corners[1:]):
        part = cross(minus(p, corners[0]), minus(q, corners[0]))
        total = tuple(s + t for s, t in zip(total, part, strict=True))
    return 0.5 * math.sqrt(sum(t * t for t in total))


def distance(p: Point, triangle: Sequence[Point]) -> float:
    """Distance of a point from a triangle, rounded once at the end.

    Examples
    --------
    >>> distance(*rational([[0, 0, 3]]), rational([[0, 0, 0], [4, 0, 0], [0, 4, 0]]))
    3.0
    """
    normal = normal_of(triangle)
    edges = list(zip(triangle, (*triangle[1:], triangle[0]), strict=True))

    # above the inside of the triangle: the plane counts; otherwise the nearest edge
    if all(dot(cross(normal, minus(r, q)), minus(p, q)) >= 0 for q, r in edges):
        height = dot(normal, minus(p, triangle[0]))
        return math.sqrt(height * height / dot(normal, normal))
    return math.sqrt(min(_from_segment(p, q, r) for q, r in edges))


def _from_segment(p: Point, q: Point, r: Point) -> Fraction:
    """Squared distance of a point from a segment."""
    along, to = minus(r, q), minus(p, q)

    # foot on the line, clipped to the segment
    t = min(Fraction(1), max(Fraction(0), dot(to, along) / dot(along, along)))
    gap = minus(to, (t * along[0], t * along[1], t * along[2]))
    return dot(gap, gap)


def error_of(point: np.ndarray, exact: Point) -> float:
    """Largest coordinate difference of a float point (3,) from an exact one."""
    return max(float(abs(Fraction(float(x)) - f)) for x, f in zip(point, exact, strict=True))
