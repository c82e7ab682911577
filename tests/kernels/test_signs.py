"""Signs of the points of a face, and points in double-double, against fractions."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest

from geosurf.kernels.cutting.cached_predicates import face_workspace
from geosurf.kernels.cutting.face_signs import AXIS, N_STATE, FacePoints, add_local, precedes
from geosurf.kernels.exact.exact_signs import EXACT_ORIENT2D, LIMBS, Frame
from geosurf.kernels.exact.predicates import frame_of
from tests.kernels.rows import point_dd_rows, sign_rows
from tests.oracles import cross, determinant, dot, minus, normal_of, rational, rounded, sign

SCALES = {
    "lattice": lambda x: x,
    "thirds": lambda x: x / 3.0,
    "turned": lambda x: x @ np.linalg.qr(np.array([[1.0, 2, 3], [4, 5, 6], [7, 8, 10]]))[0] + 7e6,
    "tiny": lambda x: (x - 1.0) * 2.0**-40,
}


def plane(x, t, e, p):
    """A point of a plane, and its normal."""
    if p < len(t):
        return x[t[p][0]], normal_of([x[v] for v in t[p]])
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
    for seed in range(2):
        world = World(kind, seed)
        m, _ = frame_of(world.x, len(world.t))
        out = np.empty((len(world.d), 10))
        point_dd_rows(world.x, world.t, world.e, m, world.d, out)
        for at, row in zip(world.places, out, strict=True):
            if row[0] == 0.0:
                continue
            known += 1
            for k in range(3):
                wrong = abs(at[k] - Fraction(row[1 + k]) - Fraction(row[4 + k]))
                assert wrong <= Fraction(row[7 + k])
        extent = np.abs(world.x).max()
        assert np.median(out[out[:, 0] == 1.0, 7:]) < 2.0**-80 * extent
    assert known > 75


def test_edges_that_lie_in_planes_but_for_rounding_are_within_their_bounds(rng):
    """Heights of their ends are all rounding: the bound has to grow as they shrink."""
    n = 40
    corners = rng.uniform(-9, 9, (n, 3, 3))
    shares = rng.dirichlet((1, 1, 1), (n, 2))
    x = np.concatenate([corners.reshape(-1, 3), (shares @ corners).reshape(-1, 3)])
    t, none = np.arange(3 * n).reshape(n, 3), np.empty((0, 3), dtype=np.int64)
    k = np.arange(n)
    d = np.stack([0 * k + 1, 3 * n + 2 * k, 3 * n + 2 * k + 1, k], axis=1)
    m, _ = frame_of(x, n)
    out = np.empty((n, 10))
    point_dd_rows(x, t, none, m, d, out)
    exact, known = rational(x), 0
    for row, at in zip(out, d.tolist(), strict=True):
        place = position(exact, t.tolist(), [], at)
        if place is not None and row[0] == 1.0:
            known += 1
            for i in range(3):
                wrong = abs(place[i] - Fraction(row[1 + i]) - Fraction(row[4 + i]))
                assert wrong <= Fraction(row[7 + i]) < 2.0**-20
    assert known > 10


def test_points_nearer_to_each_other_than_double_doubles_are_put_in_order():
    """Neighbours among fractions, a / b and c / d with a d - b c = 1, beyond some whole numbers."""
    level, asked = [[-9.0, -9, 1], [9, -9, 1], [0, 9, 1]], 0
    for far, less, k in itertools.product((0, 2**20 + 1, 2**40 + 1), (1, 111, 123), range(1, 5)):
        b, d = 2**52 - less, 2**52 - less - 2 * k
        if math.gcd(b, d) != 1:
            continue
        a = pow(d, -1, b)  # a d = 1 modulo b
        c = (a * d - 1) // b
        one, two = far + Fraction(a, b), far + Fraction(c, d)
        assert one - two == Fraction(1, b * d)
        ends = [[far, 0, 0], [far + a, b, b], [far, 3, 0], [far + c, d, d]]
        x = np.array([*level, *ends], dtype=float)
        t, none = np.array([[0, 1, 2]]), np.empty((0, 3), dtype=np.int64)
        defined = np.array([[1, 3, 4, 0], [1, 5, 6, 0]])
        places = [position(rational(x), t.tolist(), [], row) for row in defined.tolist()]
        assert [place[0] for place in places] == [one, two]
        m, _ = frame_of(x, 1)
        w = face_workspace(int(m[LIMBS]), 2)
        every = np.concatenate([x, [rounded(place) for place in places]])
        q, f = np.empty((2, 8), dtype=np.int64), np.empty((2, 8))
        s = np.zeros(N_STATE, dtype=np.int64)
        s[AXIS] = 2
        frame, points = Frame(every, t, none, defined, m, w), FacePoints(q, f, s)
        for i in (7, 8):
            add_local(frame, points, i, 0)
        found = (precedes(frame, points, i, 1 - i) for i in (0, 1))
        assert tuple(found) == (False, True), (far, b, d)
        asked += 1
    assert asked > 20


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


def assert_signs(x, t, e, d, places, axis, rows, n_row=1) -> tuple[int, int, int]:
    """Turns and circles of rows of four points, against fractions.

    Returns how many do not turn, how many are on a circle, and how many turns took integers.
    """
    u, v = (axis + 1) % 3, (axis + 2) % 3
    flat = [(at[u], at[v]) for at in places]
    m, _ = frame_of(x, len(t))
    w = face_workspace(int(m[LIMBS]), n_row)
    out = np.empty((len(rows), 3), dtype=np.int64)
    every = np.concatenate([x, [rounded(at) for at in places]])
    ids = np.arange(len(x), len(every))
    sign_rows(every, t, e, d, m, w, ids, axis, rows, out)
    zeros = ties = 0
    for (a, b, c, o), (turned, side, inside) in zip(rows.tolist(), out.tolist(), strict=True):
        p, q, r, z = flat[a], flat[b], flat[c], flat[o]
        expected = sign(determinant([[*p, 1], [*q, 1], [*r, 1]]))
        assert turned == expected, (a, b, c)
        zeros += expected == 0
        if expected <= 0 or o in (a, b, c):
            continue
        lifted = [[i, j, i * i + j * j, 1] for i, j in (p, q, r, z)]
        circle = sign(determinant(lifted))
        ties += circle == 0
        assert side == circle, (a, b, c, o)
        assert inside == (circle > 0 or (circle == 0 and min(r, z) < min(p, q))), (a, b, c, o)
    return zeros, ties, int(m[EXACT_ORIENT2D])


# products of such numbers underflow: neither doubles nor double-doubles say anything
MINUTE = 2.0**-480


@pytest.mark.parametrize("kind", [*SCALES, "minute"])
def test_signs_of_constructed_points(kind):
    """Turns and circles of points that are mostly on common lines, or nearly so."""
    zeros = ties = 0
    for seed in range(4):
        world = World("lattice" if kind == "minute" else kind, seed)
        random = np.random.default_rng(seed)
        u, v = (world.axis + 1) % 3, (world.axis + 2) % 3
        flat = [(at[u], at[v]) for at in world.places]
        rows = np.concatenate(
            [random_rows(random, len(flat), 300), nearly_on_circles(flat, random)]
        )
        x, places = world.x, world.places
        if kind == "minute":
            x, places = x * MINUTE, [tuple(c * Fraction(MINUTE) for c in at) for at in places]
        # the workspace is too small for all: rows are forgotten and made anew
        found = assert_signs(x, world.t, world.e, world.d, places, world.axis, rows)
        zeros, ties = zeros + found[0], ties + found[1]
    assert zeros > 10
    assert ties > 5 or kind not in ("lattice", "minute")


class Extruded:
    """Edges of planes through one face and its neighbour, as an extruded fault makes them.

    Corners of each plane are those of a lattice in it, and one that is slightly off; the first two
    planes stand upright, so that they are seen to be planes by zeros, the third one is oblique.
    """

    def __init__(self, seed: int, scale: float) -> None:
        random = np.random.default_rng(seed)
        face = [[-40.0, -41, 3], [53, -39, -7], [2, 60, 5]]
        a, b, c = face
        beside = [b[k] + c[k] - a[k] + (2.0**-40 if k == 2 else 0.0) for k in range(3)]
        turns = [((0, 5, 0), (0, 0, 7)), ((3, 5, 0), (0, 0, 9)), ((4, 1, 3), (-1, 5, 6))]
        corners = [np.array([*face, beside])]
        for along, up in turns:
            at = random.integers(-6, 7, 3)
            steps = random.permutation(list(itertools.product(range(-2, 3), (-3, -2, 2, 3))))[:7]
            corners.append(at + steps @ np.array([along, up]) + 0.0)
            corners[-1][6] += 2.0**-42
        self.x = np.concatenate(corners) * scale
        self.t = np.array([[0, 1, 2], [3, 2, 1]])
        self.plane, self.places, rows = [], [], []
        exact, t = rational(self.x), self.t.tolist()
        for k in range(len(turns)):
            own = range(4 + 7 * k, 11 + 7 * k)
            for a, b in itertools.combinations(own, 2):
                row = [1, a, b, int(random.integers(4) == 0)]  # mostly the face itself
                at = position(exact, t, [], row)
                if at is not None and at not in self.places:
                    self.places.append(at)
                    self.plane.append(k)
                    rows.append(row)
        self.d = np.array(rows)


@pytest.mark.parametrize("scale", [1.0, 1.0 / 3.0, MINUTE])
def test_points_of_edges_of_one_plane_are_seen_to_be_collinear_and_no_others(scale):
    """Lines that were found once answer later questions, in any order."""
    collinear = 0
    for seed in range(4):
        world = Extruded(seed, scale)
        random = np.random.default_rng(seed)
        groups = [np.flatnonzero(np.array(world.plane) == k) for k in range(3)]
        rows = []
        for _ in range(200):
            row = random.permutation(groups[random.integers(3)])[:3]
            if random.integers(3) == 0:
                row[random.integers(3)] = random.integers(len(world.places))
            if len(set(row.tolist())) == 3:
                rows.append([*row, row[0]])
        none = np.empty((0, 3), dtype=np.int64)
        zeros, _, _ = assert_signs(
            world.x, world.t, none, world.d, world.places, 2, np.array(rows), len(world.places)
        )
        collinear += zeros
    assert collinear > (20 if scale == 1.0 / 3.0 else 150)  # thirds are rounded, off their planes


class Level:
    """Lines between lattice points of one plane, through level planes: model grids have those."""

    def __init__(self, seed: int) -> None:
        random = np.random.default_rng(seed)
        flat = list(itertools.product(range(-2, 3), repeat=2))
        chosen = [flat[i] for i in random.choice(len(flat), 9, replace=False)]
        slope = 0.0 if seed % 2 == 0 else 12.0  # without it, lines look the same from the south
        self.x = [[4.0 * i, 4.0 * j, 12.0 * i + slope * j] for i, j in chosen]
        self.t = []
        for axis, height in itertools.product(range(3), (-3.0, 1.0, 4.0)):
            for corner in ((0, 0), (5, 0), (1, 7)):
                self.x.append(list(np.insert(np.array(corner, dtype=float), axis, height)))
            self.t.append([len(self.x) - 3, len(self.x) - 2, len(self.x) - 1])
        self.places, rows = [], []
        exact = rational(self.x)
        for (a, b), p in itertools.product(itertools.combinations(range(9), 2), range(len(self.t))):
            at = position(exact, self.t, [], [1, a, b, p])
            if at is not None and at not in self.places:
                self.places.append(at)
                rows.append([1, a, b, p])
        self.x, self.t, self.d = np.array(self.x), np.array(self.t), np.array(rows)


@pytest.mark.parametrize("scale", [1.0, MINUTE])
def test_points_on_level_planes_with_equal_coordinates(scale):
    """Coordinates that are equal by construction, among them those of rectangles."""
    ties = 0
    for seed in range(3):
        world, random = Level(seed), np.random.default_rng(seed)
        places = [tuple(c * Fraction(scale) for c in at) for at in world.places]
        number = {at[:2]: i for i, at in enumerate(world.places)}
        rows = random_rows(random, len(places), 250).tolist()
        for p, q in random.integers(0, len(places), (4000, 2)).tolist():
            (u, v), (i, j) = world.places[p][:2], world.places[q][:2]
            if u < i and v < j and (u, j) in number and (i, v) in number:
                around = [p, number[i, v], q, number[u, j]]
                rows.append([around[k] for k in ((0, 1, 2, 3), (1, 2, 3, 0))[random.integers(2)]])
        none = np.empty((0, 3), dtype=np.int64)
        found = assert_signs(world.x * scale, world.t, none, world.d, places, 2, np.array(rows))
        ties += found[1]
    assert ties > 40
