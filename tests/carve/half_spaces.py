"""A box cut by planes: which of its pieces are there, exactly. Slow and obvious; no geosurf.

Coordinates are doubles, so they are whole numbers of some power of two; corners of pieces are
quotients of whole numbers. On which side of a plane a corner lies is the sign of a whole number,
unless doubles are far from doubting it. Volumes are sums of doubles over corners that are rounded
once: as good as 1e-14 of the box, and never asked whether a piece is there at all.
"""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

SURE = 1e-12  # of the magnitudes of the terms: rounding is below 1e-15 of them


class Pieces:
    """Convex pieces of a box: rings of corners, turned outward.

    Parameters
    ----------
    box : (west, east, south, north, bottom, top)
    """

    def __init__(self, box, points) -> None:
        values = [Fraction(float(v)) for v in (*box, *(c for p in points for c in p))]
        self.power = max(v.denominator for v in values)
        self.low = [self._whole(v) for v in box[::2]]
        high = [self._whole(v) - a for v, a in zip(box[1::2], self.low, strict=True)]
        self.corners: list[tuple[int, int, int, int]] = []
        self.floats: list[tuple[float, float, float]] = []
        self.made: dict[tuple[int, int, int, int], int] = {}
        one = [self._corner(x, y, z, 1) for z in (0, high[2]) for y in (0, high[1])
               for x in (0, high[0])]  # fmt: skip
        faces = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
        self.box = [[one[k] for k in face] for face in faces]

    def _whole(self, value) -> int:
        """A coordinate in the smallest power of two that any of them has."""
        scaled = Fraction(float(value)) * self.power
        assert scaled.denominator == 1
        return scaled.numerator

    def _corner(self, x: int, y: int, z: int, w: int) -> int:
        if w < 0:
            x, y, z, w = -x, -y, -z, -w
        d = math.gcd(x, y, z, w)
        key = (x // d, y // d, z // d, w // d)
        if key not in self.made:
            self.made[key] = len(self.corners)
            self.corners.append(key)
            self.floats.append(tuple(value / (key[3] * self.power) for value in key[:3]))
        return self.made[key]

    def plane(self, triangle) -> tuple:
        """The plane of three points, in whole numbers and rounded; they turn left in front."""
        p, q, r = (
            [self._whole(v) - a for v, a in zip(point, self.low, strict=True)] for point in triangle
        )
        u, v = ([b - a for a, b in zip(p, other, strict=True)] for other in (q, r))
        n = [u[k - 2] * v[k - 1] - u[k - 1] * v[k - 2] for k in range(3)]
        whole = (*n, -sum(a * b for a, b in zip(n, p, strict=True)))
        size = max(map(abs, n))
        rounded = (*(a / size for a in n), whole[3] / (size * self.power))
        return whole, rounded

    def split(self, piece, plane) -> tuple[list, list]:
        """The part of a piece in front of a plane, and the one behind it; [] for nothing."""
        side = {c: self._side(c, plane) for ring in piece for c in ring}
        if min(side.values()) >= 0:
            return piece, []
        if max(side.values()) <= 0:
            return [], piece
        cut: dict[tuple[int, int], int] = {}
        for ring in piece:
            for p, q in zip(ring, ring[1:] + ring[:1], strict=True):
                if side[p] > 0 > side[q] or side[p] < 0 < side[q]:
                    key = (p, q) if p < q else (q, p)
                    if key not in cut:
                        cut[key] = self._meet(*key, plane)
                        side[cut[key]] = 0
        return tuple(self._part(piece, side, cut, sign) for sign in (1, -1))

    def _part(self, piece, side, cut, sign: int) -> list:
        rings, after = [], {}
        for ring in piece:
            out = []
            for p, q in zip(ring, ring[1:] + ring[:1], strict=True):
                if side[p] * sign >= 0:
                    out.append(p)
                if side[p] * side[q] < 0:
                    out.append(cut[(p, q) if p < q else (q, p)])
            if any(side[c] * sign > 0 for c in out):
                rings.append(out)
                for p, q in zip(out, out[1:] + out[:1], strict=True):
                    if side[p] == 0 == side[q]:
                        after[q] = p
        lid = [next(iter(after))]
        while after[lid[-1]] != lid[0]:
            lid.append(after[lid[-1]])
        return [*rings, lid]

    def _side(self, corner: int, plane) -> int:
        (a, b, c, d), (fa, fb, fc, fd) = plane
        x, y, z = self.floats[corner]
        terms = fa * x, fb * y, fc * z, fd
        height = sum(terms)
        if abs(height) > SURE * sum(map(abs, terms)):
            return 1 if height > 0 else -1
        x, y, z, w = self.corners[corner]
        value = a * x + b * y + c * z + d * w
        return (value > 0) - (value < 0)

    def _meet(self, p: int, q: int, plane) -> int:
        """Where the edge between two corners meets a plane."""
        a, b, c, d = plane[0]
        one, two = self.corners[p], self.corners[q]
        s, t = (a * x + b * y + c * z + d * w for x, y, z, w in (one, two))
        return self._corner(*(s * v - t * u for u, v in zip(one, two, strict=True)))

    def volume(self, piece) -> float:
        """To within rounding."""
        ox, oy, oz = self.floats[piece[0][0]]
        terms = []
        for ring in piece:
            radii = [(x - ox, y - oy, z - oz) for x, y, z in (self.floats[c] for c in ring)]
            ax, ay, az = radii[0]
            for (bx, by, bz), (cx, cy, cz) in itertools.pairwise(radii[1:]):
                terms.append(
                    ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
                )
        return math.fsum(terms) / 6.0
