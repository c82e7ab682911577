"""Signs of the points of a face, and points in double-double, against fractions."""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest

from geosurf.kernels.circle import sign_rows
from geosurf.kernels.doubled import doubled_rows
from geosurf.kernels.exact import LIMBS
from geosurf.kernels.kept import roomy_workspace
from geosurf.kernels.predicates import frame_of
from tests.oracles import determinant, rational, rounded, sign

SCALES = {
    "lattice": lambda x: x,
    "thirds": lambda x: x / 3.0,
    "turned": lambda x: x @ np.linalg.qr(np.array([[1.0, 2, 3], [4, 5, 6], [7, 8, 10]]))[0] + 7e6,
    "tiny": lambda x: (x - 1.0) * 2.0**-40,
}


def cross(p, q):
    return [p[(i + 1) % 3] * q[(i + 2) % 3] - p[(i + 2) % 3] * q[(i + 1) % 3] for i in range(3)]


def minus(p, q):
    return [u - v for u, v in zip(p, q, strict=True)]


def dot(p, q):
    return sum(u * v for u, v in zip(p, q, strict=True))


def plane(x, t, e, p):
    """A point of a plane, and its normal."""
    if p < len(t):
        a, b, c = (x[v] for v in t[p])
        return a, cross(minus(b, a), minus(c, a))
    one, two, axis = e[p - len(t)]
    return x[one], cross(minus(x[two], x[one]), [Fraction(int(i == axis)) for i in range(3)])


def position(x, t, e, row):
    """The point that a definition makes, or None."""
    if row[0] == 1:
        a, b = x[row[1]], x[row[2]]
        o, n = plane(x, t, e, row[3])
        ha, hb = dot(n, minus(a, o)), dot(n, minus(b, o))
        if ha == hb:
            return None
        return tuple(u + v * ha / (ha - hb) for u, v in zip(a, minus(b, a), strict=True))
    planes = [plane(x, t, e, p) for p in row[1:]]
    below = determinant([n for _, n in planes])
    if below == 0:
        return None
    over = [[[*n[:k], dot(n, o), *n[k + 1 :]] for o, n in planes] for k in range(3)]
    return tuple(determinant(rows) / below for rows in over)


class World:
    """Lattice points, triangles over them, edge planes, and what they make in the first plane."""

    def __init__(self, kind: str, seed: int) -> None:
        random = np.random.default_rng(seed)
        lattice = np.array(list(itertools.product(range(4), repeat=3)), dtype=float)
        self.x = SCALES[kind](lattice[random.choice(64, 14, replace=False)]) + 0.0
        exact = rational(self.x)
        every = [list(c) for c in itertools.combinations(range(14), 3)]
        solid = [c for c in every if any(plane(exact, [c], [], 0)[1])]
        self.t = np.array([solid[i] for i in random.choice(len(solid), 12, replace=False)])
        edges = [(a, b, int(random.integers(3))) for a, b in ((0, 1), (2, 3), (4, 5))]
        self.e = np.array([c for c in edges if any(plane(exact, [], [c], 0)[1])]).reshape(-1, 3)
        _, normal = plane(exact, self.t.tolist(), [], 0)
        self.axis = max(range(3), key=lambda i: abs(normal[i]))
        n = len(self.t) + len(self.e)
        rows = [[1, a, b, 0] for a, b in itertools.combinations(range(14), 2)]
        rows += [[2, 0, p, r] for p, r in itertools.combinations(range(1, n), 2)]
        t, e = self.t.tolist(), self.e.tolist()
        places = {}
        for row in rows:
            at = position(exact, t, e, row)
            if at is not None:
                places.setdefault(at, row)
        self.places = list(places)
        self.d = np.array([places[at] for at in self.places])


@pytest.mark.parametrize("kind", SCALES)
def test_points_in_double_double_are_within_their_bounds(kind):
    known = 0
    for seed in range(4):
        world = World(kind, seed)
        m, _ = frame_of(world.x, len(world.t))
        out = np.empty((len(world.d), 10))
        doubled_rows(world.x, world.t, world.e, m, world.d, out)
        for at, row in zip(world.places, out, strict=True):
            if row[0] == 0.0:
                continue
            known += 1
            for k in range(3):
                wrong = abs(at[k] - Fraction(row[1 + k]) - Fraction(row[4 + k]))
                assert wrong <= Fraction(row[7 + k])
        extent = np.abs(world.x).max()
        assert np.median(out[out[:, 0] == 1.0, 7:]) < 2.0**-80 * extent
    assert known > 150


def random_rows(random, n: int, count: int) -> np.ndarray:
    return random.random((count, n)).argsort(axis=1)[:, :4]


def nearly_on_circles(flat, random) -> np.ndarray:
    """Rows of four points that are on a circle as far as doubles can tell, or nearly."""
    rows = random_rows(random, len(flat), 6000)
    at = np.array([[float(i), float(j)] for i, j in flat])[rows]
    at = at[:, :3] - at[:, 3:]
    lifted = np.concatenate([at, (at**2).sum(axis=2, keepdims=True)], axis=2)
    terms = np.maximum(np.prod(np.linalg.norm(lifted, axis=2), axis=1), 1e-300)
    turned = np.linalg.det(np.stack([at[:, 1] - at[:, 0], at[:, 2] - at[:, 0]], axis=1))
    order = np.argsort(np.abs(np.linalg.det(lifted)) / terms + (turned <= 1e-9 * np.abs(at).max()))
    return rows[order[:100]]


@pytest.mark.parametrize("kind", SCALES)
def test_signs_of_constructed_points(kind):
    """Turns and circles of points that are mostly on common lines, or nearly so."""
    zeros = ties = 0
    for seed in range(4):
        world = World(kind, seed)
        random = np.random.default_rng(seed)
        u, v = (world.axis + 1) % 3, (world.axis + 2) % 3
        flat = [(at[u], at[v]) for at in world.places]
        n = len(flat)
        rows = np.concatenate([random_rows(random, n, 300), nearly_on_circles(flat, random)])
        n_vertex = len(world.x)
        m, _ = frame_of(world.x, len(world.t))
        x = np.concatenate([world.x, [rounded(at) for at in world.places]])
        w = roomy_workspace(int(m[LIMBS]), 1)  # too small for all: rows are forgotten and made anew
        out = np.empty((len(rows), 3), dtype=np.int64)
        ids = np.arange(n_vertex, n_vertex + n)
        sign_rows(x, world.t, world.e, world.d, m, w, ids, world.axis, rows, out)
        for (a, b, c, o), (turned, side, inside) in zip(rows.tolist(), out.tolist(), strict=True):
            p, q, r, z = flat[a], flat[b], flat[c], flat[o]
            expected = sign(determinant([[*p, 1], [*q, 1], [*r, 1]]))
            assert turned == expected
            zeros += expected == 0
            if expected <= 0:
                continue
            lifted = [[i, j, i * i + j * j, 1] for i, j in (p, q, r, z)]
            circle = sign(determinant(lifted))
            ties += circle == 0
            assert side == circle
            assert inside == (circle > 0 or (circle == 0 and min(r, z) < min(p, q)))
    assert zeros > 10
    assert ties > 5 or kind != "lattice"
