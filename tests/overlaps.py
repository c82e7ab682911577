"""What surfaces have in common where they coincide, cross and touch, in rational arithmetic.

Independent of any triangulation. Two surfaces (or one and itself) have contacts: what pairs of
their triangles have in common. A place of a contact is *inside* an area where both surfaces are
one sheet there, and the same one. All other places of contact are curves, or points.

Lines are cut at every plane and edge that could matter; around the middle of each part, and
around single points, the triangles there are compared as half-planes and as sectors.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections import Counter
from fractions import Fraction

from benchmarks.stress.rational import cross, dot, meet, minus, normal_of, rational


class Together:
    """Two surfaces, or one and itself: their exact curves, touching points and area.

    Parameters
    ----------
    one, two : lists of triangles (three rational points each)
        `two` is None for a surface with itself.
    """

    def __init__(self, one, two=None):
        self.one, self.two = one, two
        if two is None:
            found = [
                (s, t, meet(s, t)) for s, t in itertools.combinations(one, 2) if boxes_meet(s, t)
            ]
            found = [
                (s, t, c) for s, t, c in found if len(c) > 2 or not {*c} <= {*s} & {*t}
            ]  # neighbours have corners and edges in common
        else:
            found = [(s, t, meet(s, t)) for s in one for t in two if boxes_meet(s, t)]
        self.contacts = [c for _, _, c in found if c]

    @functools.cached_property
    def areas(self):
        """Convex polygons of which the area is made."""
        return [c for c in self.contacts if len(c) > 2]

    @functools.cached_property
    def area(self) -> float:
        """Area that both have, each place of a sheet once."""
        planes: dict[tuple, list] = {}
        for polygon in self.areas:
            normal = unit(cross(minus(polygon[1], polygon[0]), minus(polygon[2], polygon[0])))
            normal = max(normal, opposite(normal))
            planes.setdefault((normal, dot(normal, polygon[0])), []).append(polygon)
        return math.fsum(union_area(normal, ps) for (normal, _), ps in planes.items())

    @functools.cached_property
    def curves(self) -> list[tuple]:
        """Parts (p, q) of the curves: each place once."""
        lines = [tuple(c) for c in self.contacts if len(c) == 2]
        for polygon in self.areas:
            lines += zip(polygon, [*polygon[1:], polygon[0]], strict=True)
        parts = {part for p, q in set(map(tuple, map(sorted, lines))) for part in self._parts(p, q)}
        return sorted(part for part in parts if not self._inside_line(*part))

    @functools.cached_property
    def points(self) -> list[tuple]:
        """Touching points."""
        found = {c[0] for c in self.contacts if len(c) == 1}
        found |= {p for polygon in self.areas for p in polygon}
        found -= {p for part in self.curves for p in part}
        return sorted(p for p in found if not self._inside_point(p))

    def _parts(self, p, q):
        """A segment, cut where triangles begin, end, or pass."""
        along = minus(q, p)
        cuts = {Fraction(0), Fraction(1)}
        for t in (*self.one, *(self.two or ())):
            normal = normal_of(t)
            slope, height = dot(normal, along), dot(normal, minus(t[0], p))
            if slope != 0:
                cuts.add(height / slope)
            elif height == 0:
                for a, b in zip(t, (*t[1:], t[0]), strict=True):
                    across = cross(normal, minus(b, a))
                    slope = dot(across, along)
                    if slope != 0:
                        cuts.add(dot(across, minus(a, p)) / slope)
        cuts = sorted(c for c in cuts if 0 <= c <= 1)
        ends = [tuple(u + c * v for u, v in zip(p, along, strict=True)) for c in cuts]
        return itertools.pairwise(ends)

    def _inside_line(self, p, q) -> bool:
        """Whether a part of a line is inside an area."""
        along = minus(q, p)
        middle = tuple((u + v) / 2 for u, v in zip(p, q, strict=True))
        one = half_planes(self.one, middle, along)
        if self.two is None:
            return len(one) == 2 and min(one.values()) > 1
        return len(one) == 2 and set(one) == set(half_planes(self.two, middle, along))

    def _inside_point(self, p) -> bool:
        """Whether a point is inside an area."""
        one = sectors(self.one, p)
        two = one if self.two is None else sectors(self.two, p)
        rays = rays_of([*one, *two])
        mine, others = (Counter(a for s in of for a in s.arcs(rays)) for of in (one, two))
        if self.two is None:
            return min(mine.values()) > 1 and is_ring(mine)
        return set(mine) == set(others) and is_ring(mine)


def together(surfaces, i: int, j: int) -> Together:
    """Of surfaces i and j of a list of TriSurface."""
    one, two = (
        [tuple(rational(t)) for t in s.vertices[s.triangles]] for s in (surfaces[i], surfaces[j])
    )
    return Together(one) if i == j else Together(one, two)


def boxes_meet(s, t) -> bool:
    """Whether the boxes of two triangles have a point in common."""
    return all(
        min(p[k] for p in s) <= max(p[k] for p in t)
        and min(p[k] for p in t) <= max(p[k] for p in s)
        for k in range(3)
    )


def unit(v):
    """The vector of the same direction whose largest component is 1 or -1."""
    size = max(map(abs, v))
    return tuple(c / size for c in v)


def opposite(v):
    """The vector that points the other way."""
    return tuple(-c for c in v)


def half_planes(triangles, middle, along) -> Counter:
    """Directions in which triangles go on from a line, at a place where none of them begins."""
    found: Counter = Counter()
    for t in triangles:
        normal = normal_of(t)
        if dot(normal, along) != 0 or dot(normal, minus(middle, t[0])) != 0:
            continue
        way = unit(cross(normal, along))
        for side in (way, opposite(way)):
            if reaches(t, normal, middle, side):
                found[side] += 1
    return found


def reaches(t, normal, p, way) -> bool:
    """Whether a triangle has the places just beside one of its points, that way in its plane."""
    for a, b in zip(t, (*t[1:], t[0]), strict=True):
        inward = cross(normal, minus(b, a))
        at = dot(inward, minus(p, a))
        if at < 0 or (at == 0 and dot(inward, way) < 0):
            return False
    return True


class Sector:
    """What a triangle is around one of its points: between two rays, a half-plane, a plane."""

    def __init__(self, normal, edges):
        self.normal = unit(normal)
        self.inward = [unit(cross(normal, along)) for along in edges]
        ends = [unit(e) for e in edges]
        self.rim = [e for e in (*ends, *map(opposite, ends)) if self.holds(e)]
        if not self.rim:
            some = next(a for k in range(3) if any(a := cross(self.normal, axis(k))))
            self.rim = [unit(some), opposite(unit(some))]

    def holds(self, ray) -> bool:
        """Whether a ray lies in it."""
        return dot(self.normal, ray) == 0 and all(dot(i, ray) >= 0 for i in self.inward)

    def extra(self):
        """Rays in its plane across its rim: no arc between rays is a half-circle."""
        for ray in self.rim:
            way = unit(cross(self.normal, ray))
            yield from (way, opposite(way), opposite(ray))

    def arcs(self, rays):
        """Pairs of neighbouring rays that have the sector between them."""
        mine = [r for r in rays if dot(self.normal, r) == 0]
        first = mine[0]
        half = lambda r: (  # noqa: E731
            dot(self.normal, cross(first, r)) < 0
            or (not any(cross(first, r)) and dot(first, r) < 0)
        )
        turn = lambda p, q: (  # noqa: E731
            half(p) - half(q) or (-1 if dot(self.normal, cross(p, q)) > 0 else 1)
        )
        mine = [first, *sorted(mine[1:], key=functools.cmp_to_key(turn))]
        for p, q in zip(mine, mine[1:] + mine[:1], strict=True):
            if (
                self.holds(p)
                and self.holds(q)
                and self.holds(tuple(a + b for a, b in zip(p, q, strict=True)))
            ):
                yield frozenset((p, q))


def axis(k: int):
    """A unit vector."""
    return tuple(Fraction(int(k == i)) for i in range(3))


def sectors(triangles, p) -> list[Sector]:
    """What triangles are around a point."""
    found = []
    for t in triangles:
        normal = normal_of(t)
        if dot(normal, minus(p, t[0])) != 0:
            continue
        sides = list(zip(t, (*t[1:], t[0]), strict=True))
        at = [dot(cross(normal, minus(b, a)), minus(p, a)) for a, b in sides]
        if min(at) >= 0:
            found.append(
                Sector(normal, [minus(b, a) for (a, b), h in zip(sides, at, strict=True) if h == 0])
            )
    return found


def rays_of(of: list[Sector]) -> list[tuple]:
    """All rays where sectors end or meet, and some between."""
    rays = {r for s in of for r in s.rim} | {r for s in of for r in s.extra()}
    for s, t in itertools.combinations(of, 2):
        line = cross(s.normal, t.normal)
        if any(line):
            rays |= {unit(line), opposite(unit(line))}
    return sorted(rays)


def is_ring(arcs) -> bool:
    """Whether arcs make one closed ring."""
    ends: dict[tuple, list] = {}
    for p, q in arcs:
        ends.setdefault(p, []).append(q)
        ends.setdefault(q, []).append(p)
    if not ends or any(len(of) != 2 for of in ends.values()):
        return False
    start = at = next(iter(ends))
    before, n = ends[start][0], 0
    while True:
        onward = ends[at][0] if ends[at][0] != before else ends[at][1]
        before, at, n = at, onward, n + 1
        if at == start:
            return n == len(ends)


def union_area(normal, polygons) -> float:
    """Area of convex polygons of one plane, what several have counted once."""
    k = max(range(3), key=lambda i: abs(normal[i]))
    flat = [[(p[(k + 1) % 3], p[(k + 2) % 3]) for p in polygon] for polygon in polygons]
    edges = [e for ps in flat for e in zip(ps, ps[1:] + ps[:1], strict=True)]
    stops = {p[0] for ps in flat for p in ps}
    for (a, b), (c, d) in itertools.combinations(edges, 2):
        (ux, uy), (vx, vy) = (b[0] - a[0], b[1] - a[1]), (d[0] - c[0], d[1] - c[1])
        turn = ux * vy - uy * vx
        if turn != 0:
            stops.add(a[0] + ux * ((c[0] - a[0]) * vy - (c[1] - a[1]) * vx) / turn)
    total = Fraction(0)
    for low, high in itertools.pairwise(sorted(stops)):
        at, end = (low + high) / 2, None
        for start, stop in sorted(filter(None, (_span(ps, at) for ps in flat))):
            start = start if end is None else max(start, end)
            end = stop if end is None else max(stop, end)
            total += max(stop - start, 0) * (high - low)
    return float(total) * math.sqrt(dot(normal, normal)) / abs(float(normal[k]))


def _span(polygon, at):
    """From where to where a convex polygon (n, 2) reaches at a place that is no corner's."""
    found = []
    for (x, y), (u, v) in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        if (x < at) != (u < at):
            found.append(y + (v - y) * (at - x) / (u - x))
    return (min(found), max(found)) if found else None
