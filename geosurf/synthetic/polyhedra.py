"""Convex polyhedra cut by planes, in rational arithmetic.

Every float is a fraction, so nothing is rounded before the end.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import chain, pairwise, product

Point = tuple[Fraction, Fraction, Fraction]
Plane = tuple[Fraction, Fraction, Fraction, Fraction]  # a x + b y + c z + d >= 0 stays
Polyhedron = list[list[Point]]  # faces, each a convex ring of points


def box_polyhedron(box: Sequence[float]) -> Polyhedron:
    """Return the six faces of a box (west, east, south, north, bottom, top)."""
    limits = [[Fraction(box[2 * axis + side]) for side in (0, 1)] for axis in range(3)]
    faces = []

    # Corners of each face in a ring.
    for axis, side in product(range(3), range(2)):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        ring = []
        for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)):
            point = [Fraction(0)] * 3
            point[axis], point[u], point[v] = limits[axis][side], limits[u][i], limits[v][j]
            ring.append((point[0], point[1], point[2]))
        faces.append(ring)
    return faces


def clip(solid: Polyhedron, plane: Plane) -> Polyhedron:
    """Return the part of a convex polyhedron on the positive side of a plane.

    Examples
    --------
    >>> half = clip(box_polyhedron((0, 2, 0, 2, 0, 2)), (1, 1, 0, -2))
    >>> volume(half), volume(clip(half, (1, 1, 0, -2)))
    (Fraction(4, 1), Fraction(4, 1))
    """
    # Clip each face; the section closes the solid unless a face lies in the plane.
    faces = [ring for face in solid if len(ring := clip_ring(face, plane)) >= 3]
    sides = [[_side(point, plane) for point in face] for face in faces]
    if not any(map(any, sides)):
        return []  # nothing is above the plane
    if not all(map(any, sides)):
        return faces  # it only touches the plane: the lid is there
    corners = zip(chain(*faces), chain(*sides), strict=True)
    lid = _convex_ring({point for point, side in corners if side == 0}, plane)
    return [*faces, lid] if len(lid) >= 3 else faces


def clip_ring(ring: list[Point], plane: Plane) -> list[Point]:
    """Return the part of a convex ring on the positive side of a plane."""
    clipped: list[Point] = []
    sides = [_side(point, plane) for point in ring]
    for k, (q, at_q) in enumerate(zip(ring, sides, strict=True)):
        # Corners on the positive side stay; edges across the plane get a new corner.
        p, at_p = ring[k - 1], sides[k - 1]
        if at_p * at_q < 0:
            t = at_p / (at_p - at_q)
            x, y, z = (u + t * (v - u) for u, v in zip(p, q, strict=True))
            clipped.append((x, y, z))
        if at_q >= 0:
            clipped.append(q)
    return clipped


def section(solid: Polyhedron, plane: Plane) -> list[Point]:
    """Return the convex ring in which a plane cuts a polyhedron; [] if it misses."""
    return _convex_ring({point for face in solid for point in _on_plane(face, plane)}, plane)


def chord(ring: list[Point], plane: Plane) -> tuple[Point, Point] | None:
    """Return the two ends of the line in which a plane cuts a convex ring."""
    ends = sorted(set(_on_plane(ring, plane)))
    return (ends[0], ends[-1]) if len(ends) > 1 else None


def volume(solid: Polyhedron) -> Fraction:
    """Volume of a convex polyhedron: tetrahedra from one of its points."""
    if not solid:
        return Fraction(0)

    # A convex solid is the union of tetrahedra from one point to all faces.
    apex = solid[0][0]
    total = Fraction(0)
    for ring in solid:
        for b, c in pairwise(ring[1:]):
            total += abs(_det(_minus(ring[0], apex), _minus(b, apex), _minus(c, apex)))
    return total / 6


def area(ring: list[Point]) -> float:
    """Area of a plane convex ring [m2]."""
    if len(ring) < 3:
        return 0.0

    # A fan of triangles from the first corner; sums of cross products in fractions.
    total = [Fraction(0)] * 3
    for b, c in pairwise(ring[1:]):
        p, q = _minus(b, ring[0]), _minus(c, ring[0])
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            total[k] += p[i] * q[j] - p[j] * q[i]
    return 0.5 * math.sqrt(float(sum(t * t for t in total)))


def _side(point: Point, plane: Plane) -> Fraction:
    """Above 0 on the positive side of a plane, 0 on it."""
    a, b, c, d = plane
    return a * point[0] + b * point[1] + c * point[2] + d


def _on_plane(ring: list[Point], plane: Plane) -> list[Point]:
    """Points where the rim of a ring meets a plane."""
    return [point for point in clip_ring(ring, plane) if _side(point, plane) == 0]


def _convex_ring(points: set[Point], plane: Plane) -> list[Point]:
    """Points of one plane in convex order: the hull of their shadow (monotone chain)."""
    # Drop the axis that the plane faces most: the shadow has the same convex order.
    drop = max(range(3), key=lambda axis: abs(plane[axis]))
    u, v = (axis for axis in range(3) if axis != drop)
    ordered = sorted(points, key=lambda p: (p[u], p[v]))
    if len(ordered) < 3:
        return ordered

    def half(sequence: list[Point]) -> list[Point]:
        """One chain of the hull, turning one way only."""
        chain: list[Point] = []
        for p in sequence:
            while len(chain) > 1:
                a, b = chain[-2], chain[-1]
                if (b[u] - a[u]) * (p[v] - a[v]) > (b[v] - a[v]) * (p[u] - a[u]):
                    break
                chain.pop()
            chain.append(p)
        return chain[:-1]

    return half(ordered) + half(ordered[::-1])


def _minus(p: Point, q: Point) -> Point:
    return p[0] - q[0], p[1] - q[1], p[2] - q[2]


def _det(a: Point, b: Point, c: Point) -> Fraction:
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )
