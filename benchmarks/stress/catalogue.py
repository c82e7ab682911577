"""Two triangles, every way they can meet: a list known by hand, and a systematic one.

The first triangle is `BASE`. The list has the expected contact of each pair. The systematic
one puts the corners of the second triangle into every region that the first one's lines make
of its plane (its corners, its edges, its inside, and twelve regions around), and below, in or
above that plane.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

BASE = np.array([[0, 0, 0], [24, 0, 0], [0, 24, 0]])
UTM = (448_512.0, 6_725_632.0, -3_072.0)


@dataclass(frozen=True)
class Pair:
    """A second triangle, what it has in common with `BASE`, and in how many corners."""

    name: str
    corners: tuple[tuple[int, int, int], ...]
    kind: str
    count: int


def _pairs(kind: str, count: int, rows: Iterable[tuple[str, Any]]) -> list[Pair]:
    return [Pair(name, corners, kind, count) for name, corners in rows]


CATALOGUE = [
    *_pairs("disjoint", 0, [
        ("plane above plane", ((1, 2, 5), (20, 1, 5), (3, 17, 5))),
        ("hovering over the face", ((5, 5, 1), (8, 4, 7), (4, 8, 9))),
        ("astride the plane, outside", ((30, 3, -2), (33, 9, 5), (31, 4, 8))),
        ("astride a corner, apart", ((-3, -3, -4), (-1, -1, 6), (-2, -5, 6))),
        ("a corner in the plane, outside", ((15, 15, 0), (17, 12, 6), (12, 19, 3))),
        ("an edge in the plane, outside", ((14, 14, 0), (26, 3, 0), (20, 20, 7))),
        ("coplanar, far", ((40, 0, 0), (50, 3, 0), (42, 9, 0))),
        ("coplanar, within the box", ((23, 22, 0), (20, 23, 0), (14, 14, 0))),
        ("coplanar, edges on one line", ((25, 0, 0), (31, 0, 0), (27, -6, 0))),
        ("coplanar, corner on the line of an edge", ((27, 0, 0), (30, -5, 0), (29, 4, 0))),
    ]),
    *_pairs("point", 1, [
        ("corner on corner", ((0, 0, 0), (-5, 2, 7), (-6, -3, 4))),
        ("corner on corner, astride", ((24, 0, 0), (30, 1, 5), (31, 2, -6))),
        ("corner on corner, above the face", ((0, 0, 0), (6, 3, 5), (3, 6, 8))),
        ("corner on edge", ((9, 0, 0), (8, -4, 3), (12, -7, 5))),
        ("corner on edge, astride", ((0, 7, 0), (-5, 6, 4), (-3, 9, -4))),
        ("corner on face", ((5, 6, 0), (3, 3, 4), (9, 5, 8))),
        ("edge across edge", ((10, -3, -3), (10, 3, 3), (14, -9, 5))),
        ("edge through corner", ((-3, 3, -5), (3, -3, 5), (-6, -4, 7))),
        ("edge in the plane, touching a corner", ((24, -5, 0), (24, 5, 0), (30, 0, 6))),
        ("edges in line, end to end", ((-7, 0, 0), (0, 0, 0), (-3, 2, 6))),
        ("coplanar, corner on corner", ((0, 24, 0), (-4, 30, 0), (3, 31, 0))),
        ("coplanar, corner on edge", ((13, 0, 0), (9, -6, 0), (16, -4, 0))),
        ("coplanar, its edge on a corner", ((20, -4, 0), (28, 4, 0), (30, -6, 0))),
        ("coplanar, edges end to end", ((24, 0, 0), (33, 0, 0), (29, -4, 0))),
    ]),
    *_pairs("segment", 2, [
        ("edge on edge, equal", ((0, 0, 0), (24, 0, 0), (11, 4, 9))),
        ("edge on edge, inside", ((5, 0, 0), (17, 0, 0), (9, -4, 6))),
        ("edge on edge, from a corner", ((0, 0, 0), (0, 10, 0), (3, 4, 6))),
        ("edge on edge, shifted", ((-6, 0, 0), (8, 0, 0), (1, 1, 5))),
        ("edge on edge, beyond both ends", ((0, -5, 0), (0, 40, 0), (-4, 2, 5))),
        ("edge in the face", ((3, 4, 0), (9, 7, 0), (4, 4, 6))),
        ("edge in the face, from an edge", ((6, 0, 0), (7, 9, 0), (5, 5, 8))),
        ("edge in the face, out of it", ((4, 5, 0), (30, 8, 0), (9, 9, 7))),
        ("edge across the face", ((-4, 6, 0), (33, 6, 0), (2, 2, 9))),
        ("edge along the bisector", ((0, 0, 0), (12, 12, 0), (5, 6, 7))),
        ("corner through the face", ((6, 6, -3), (4, 5, 6), (9, 7, 6))),
        ("corner through an edge", ((10, 3, -4), (10, -7, 5), (10, 8, 5))),
        ("each through the other", ((9, 6, -6), (9, -20, 6), (10, 8, 6))),
        ("swallowed by a wall", ((-60, 5, -40), (80, 5, -40), (6, 5, 90))),
        ("wall through a corner", ((-20, -20, -20), (50, 50, -20), (6, 6, 70))),
        ("corner on face, astride", ((6, 5, 0), (9, 8, 6), (9, 8, -6))),
        ("corner on edge, astride inwards", ((11, 0, 0), (11, 5, 7), (11, 5, -7))),
        ("corner on corner, astride inwards", ((0, 0, 0), (5, 5, 6), (5, 5, -6))),
        ("astride along an edge", ((0, 0, 0), (9, 0, 6), (9, 0, -6))),
        ("coplanar, edge on edge, equal", ((0, 0, 0), (24, 0, 0), (9, -8, 0))),
        ("coplanar, edge on edge, inside", ((4, 0, 0), (15, 0, 0), (9, -8, 0))),
        ("coplanar, edge on edge, shifted", ((0, -4, 0), (0, 11, 0), (-7, 2, 0))),
        ("coplanar, edge on edge, beyond", ((-4, 0, 0), (40, 0, 0), (9, -8, 0))),
    ]),
    *_pairs("area", 3, [
        ("coplanar, equal", ((0, 0, 0), (24, 0, 0), (0, 24, 0))),
        ("coplanar, inside", ((3, 4, 0), (9, 5, 0), (5, 11, 0))),
        ("coplanar, inside, corners on edges", ((8, 0, 0), (16, 8, 0), (0, 9, 0))),
        ("coplanar, around", ((-20, -20, 0), (90, -20, 0), (-20, 90, 0))),
        ("coplanar, half", ((0, 0, 0), (24, 0, 0), (12, 12, 0))),
        ("coplanar, tip", ((7, 5, 0), (3, -6, 0), (12, -6, 0))),
    ]),
    *_pairs("area", 4, [
        ("coplanar, two corners inside", ((4, 5, 0), (12, 4, 0), (9, -14, 0))),
        ("coplanar, across", ((6, -5, 0), (10, -5, 0), (8, 80, 0))),
    ]),
    *_pairs("area", 5, [("coplanar, cut off", ((-3, 9, 0), (10, -4, 0), (10, 11, 0)))]),
    *_pairs("area", 6, [("coplanar, star", ((16, 16, 0), (-8, 16, 0), (16, -8, 0)))]),
]  # fmt: skip

# all orders of corners, and the 48 turns and reflections that map whole numbers to whole numbers:
# the kind of contact must be the same for each
ORDERS = list(itertools.permutations(range(3)))
TURNS = [
    np.diag(signs)[list(order)]
    for order in ORDERS
    for signs in itertools.product((1, -1), repeat=3)
]


def moved(rng: np.random.Generator, number: int, *triangles: np.ndarray) -> list[np.ndarray]:
    """Whole-numbered triangles turned, scaled by a power of two and shifted: no bit is lost."""
    # turns and powers of two are exact: the pair stays what the catalogue says
    turn = TURNS[number % len(TURNS)]
    shift = rng.integers(-60, 61, 3)
    scale = 2.0 ** rng.integers(-9, 10)
    offset = np.array(UTM) if rng.integers(2) else np.zeros(3)
    return [(triangle @ turn.T + shift) * scale + offset for triangle in triangles]


def random_turn(rng: np.random.Generator) -> np.ndarray:
    """A rotation (3, 3), the same bits on any processor: libraries of matrices differ there."""
    a, b, c, d = rng.normal(size=4).tolist()
    size = a * a + b * b + c * c + d * d

    # four normal numbers, so that turns are spread evenly
    return np.array([  # of a unit quaternion
        [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
        [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d],
    ]) / size  # fmt: skip


def turned(points: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Points (..., 3) turned by a matrix (3, 3), the same bits on any processor."""
    # products and sums in a fixed order: a matrix product may sum otherwise on another machine
    x, y, z = (points[..., k, None] * turn[:, k] for k in range(3))
    return np.asarray(x + y + z)


def region_corner(rng: np.random.Generator, region: int) -> np.ndarray:
    """A point of one of the 19 regions that the lines of `BASE` make of its plane, whole numbers.

    A point is known by the signs of its three barycentric weights; they cannot all be negative.
    """
    # tried until the last weight comes out with the sign that the region asks for
    signs = REGIONS[region]
    while True:
        weights = np.array([s * int(rng.integers(1, 20)) for s in signs])
        free = np.flatnonzero(weights)
        k = free[np.argmax(np.array(signs)[free])]

        # weights add up to 24, the side of `BASE`, so that corners are whole numbers
        weights[k] = 24 - (weights.sum() - weights[k])
        if (np.sign(weights) == signs).all():
            return np.array([weights[1], weights[2], 0])


REGIONS = [
    signs
    for signs in itertools.product((1, 0, -1), repeat=3)
    if 1 in signs  # the weights add up to one
]
