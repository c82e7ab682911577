"""Points of contacts: placed where they are, each with one id, whatever makes them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given

from geosurf import Lattice, TriSurface
from geosurf.arrangement.search import find_contacts
from geosurf.kernels.contacts.triangle_contact import n_corners
from tests.kernels.test_signs import SCALES, plane, position
from tests.oracles import dot, minus, rational, rounded
from tests.strategies import soup, soups


def exact_points(contacts):
    """All points of contacts as fractions."""
    x, t, e = rational(contacts.x[: contacts.n_vertex]), contacts.t.tolist(), contacts.e.tolist()
    return [*map(tuple, x), *(position(x, t, e, row) for row in contacts.d.tolist())]


def check(contacts):
    """Each point of a contact lies in both planes, is rounded once, and has one id."""
    exact = exact_points(contacts)
    x, t = rational(contacts.x[: contacts.n_vertex]), contacts.t.tolist()
    made = contacts.x[contacts.n_vertex :].tolist()
    assert [rounded(point) for point in exact[contacts.n_vertex :]] == list(map(tuple, made))
    used = np.unique(contacts.t[contacts.rows[:, :2]])
    constructed = range(contacts.n_vertex, len(exact))
    mine = [exact[i] for i in (*used.tolist(), *constructed)]
    assert len(set(mine)) == len(mine)
    for row, ids in zip(contacts.rows, contacts.ids, strict=True):
        n = n_corners(row[None])[0]
        assert len(set(ids[:n].tolist())) == n
        assert set(ids[n:].tolist()) <= {-1}
        for face in row[:2].tolist():
            o, normal = plane(x, t, [], face)
            assert not any(dot(normal, minus(exact[i], o)) for i in ids[:n].tolist())


def scaled(surfaces, kind):
    return [
        TriSurface(s.name, s.role, SCALES[kind](np.asarray(s.vertices)) + 0.0, s.triangles)
        for s in surfaces
    ]


@pytest.mark.parametrize("kind", ["lattice", "thirds", "tiny"])
@given(surfaces=soups(most=8))
def test_points_of_soups(kind, surfaces):
    check(find_contacts(scaled(surfaces, kind), self_intersections=True))


def fan(n, height):
    """A hub below a plane, and `n` triangles from it to corners above."""
    angle = np.linspace(0.0, 6.0, n)
    rim = np.column_stack([np.cos(angle), np.sin(angle), np.full(n, height)]) * 7.0
    corners = np.concatenate([[[0.0, 0.0, -5.0]], rim])
    ring = np.arange(1, n)
    return TriSurface("F1", "fault", corners, np.stack([0 * ring, ring, ring + 1], axis=1))


@pytest.mark.parametrize("n", [3, 17, 18, 40, 197])
def test_a_hub_names_more_points_than_a_list_holds(n):
    floor = TriSurface(
        "Top", "horizon", [[-99, -98, 0.25], [97, -99, 0.5], [0, 99, 0.125]], [[0, 1, 2]]
    )
    contacts = find_contacts([floor, fan(n, 1.0)])
    assert len(contacts.rows) == n - 1
    assert len(contacts.d) == n  # each edge once, though two triangles have it
    check(contacts)


@pytest.mark.parametrize("n", [17, 40])
def test_an_edge_through_many_faces(n):
    z = np.arange(n)[:, None]
    corners = np.array([[-9.0, -9.0], [9.0, -8.0], [0.0, 9.0]])
    sheets = np.concatenate(
        [np.insert(corners * (1.0 + k / 64), 2, k + 0.5, axis=1) for k in range(n)]
    )
    stack = TriSurface("Tops", "horizon", sheets, 3 * z + [[0, 1, 2]])
    post = [[0.1, 0.2, -1.0], [0.3, -0.1, n + 1.0], [5.0, 0.7, n / 2], [-5.0, 0.3, n / 2]]
    wall = TriSurface("F1", "fault", post, [[0, 1, 2], [1, 0, 3]])
    contacts = find_contacts([stack, wall])
    shared = contacts.d[(contacts.d[:, 1:3] == contacts.d[0, 1:3]).all(axis=1)]
    assert len(shared) == n
    check(contacts)


@pytest.mark.parametrize("turned", [False, True])
def test_many_edges_of_one_plane_find_room(turned):
    """Tables of names begin with sixty-four slots."""
    n, few = 32, 3
    bars = np.array([[[k, -1.0, 0], [k + 0.5, n, 0], [k - 0.25, n, 0]] for k in range(n)])
    across = bars[:few, :, [1, 0, 2]] + [0.125, 0.25, 0]
    one, two = (across, bars) if turned else (bars, across)
    contacts = find_contacts([soup("A", one), soup("B", two)])
    assert len(contacts.rows) == n * few
    assert len(contacts.e) > 64
    assert len(contacts.d) > 3 * n * few
    check(contacts)
    # what cuts a face runs between points of both
    exact = exact_points(contacts)
    segments = contacts.records[contacts.records[:, 2] >= 0]
    assert len(segments) >= 4 * n * few
    for face, p, q, support in segments.tolist():
        x, t = rational(contacts.x[: contacts.n_vertex]), contacts.t.tolist()
        for by in (face, support):
            o, normal = plane(x, t, contacts.e.tolist(), by)
            assert not any(dot(normal, minus(exact[i], o)) for i in (p, q))


def test_points_on_planes_that_are_level_are_never_minus_zero():
    flat = np.array([[-4.0, -4, -0.0], [4, -4, -0.0], [0, 5, -0.0]])
    wall = np.array([[0.3, -3.0, -1], [0.7, 3, -1], [0.1, 0.7, 2]])
    for axes in ([0, 1, 2], [1, 2, 0], [2, 0, 1]):
        surfaces = [
            TriSurface("Top", "horizon", flat[:, axes], [[0, 1, 2]]),
            TriSurface("F1", "fault", wall[:, axes], [[0, 1, 2]]),
        ]
        contacts = find_contacts(surfaces)
        made = contacts.x[contacts.n_vertex :]
        assert len(made) == 2
        assert not np.signbit(made[made == 0.0]).any()


@pytest.mark.parametrize("step", [0.37, 3e5])
def test_points_of_level_lattices_are_never_minus_zero(rng, step):
    """These keep -0.0; where edges are short plain doubles place points, and others where not."""
    n = 5
    axis = step * (np.arange(n) - 2) + 100.0
    level = Lattice(axis, axis, np.full((n, n), -0.0))
    east, along = np.full((n, n), -0.0), np.cumsum(rng.uniform(0.1, 0.4, (n, n)), axis=1)
    high = step * (rng.uniform(0.3, 0.5, (n, n)) + np.arange(-2, n - 2)[:, None])
    upright = Lattice(east + 99.9 + 0.01 * step, 100 + step * (along - 0.6), high)
    wall = Lattice(east, 100 + step * (along - 0.6), high)
    flat = Lattice(axis - 100.0, axis, high - 0.1 * step)
    for one, two in ((level, upright), (flat, wall)):
        surfaces = TriSurface("A", "horizon", lattice=one), TriSurface("F", "fault", lattice=two)
        contacts = find_contacts(surfaces)
        made = contacts.x[contacts.n_vertex :]
        assert np.signbit(contacts.x[: contacts.n_vertex][:, [0, 2]]).any()
        assert (made == 0.0).sum() > 4
        assert not np.signbit(made[made == 0.0]).any()
        check(contacts)


def test_points_next_to_the_middle_of_two_doubles_are_rounded_the_right_way(rng):
    """Off it by less than double-doubles can tell: what these call sure is sure."""
    n, corners = 150, []
    while len(corners) < n:
        q, d, e = (int(rng.integers(2**k, 2 ** (k + 1))) | 1 for k in (52, 50, 50))
        if math.gcd(d, q) > 1:
            continue
        # the middle is (q + 1) / 2 or (q - 1) / 2 parts, of q, beyond a whole number
        p = (q + int(rng.choice([-1, 1]))) // 2 * pow(d, -1, q) % q
        a, c = 2**52 + int(rng.integers(2**51)), int(rng.integers(2**51))
        corners += [[[a, c, -p], [a + d, c + e, q - p], [a, 2**53, -p]]]
    comb = np.array(corners, dtype=float).reshape(-1, 3)
    assert comb.astype(np.int64).reshape(-1, 3, 3).tolist() == corners
    far = 2.0**58
    floor = TriSurface(
        "Top", "horizon", [[-far, -far, 0], [far, -far, 0], [0, far, 0]], [[0, 1, 2]]
    )
    fault = TriSurface("F1", "fault", comb, np.arange(3 * n).reshape(n, 3))
    contacts = find_contacts([floor, fault])
    assert len(contacts.d) >= 2 * n
    exact = exact_points(contacts)[contacts.n_vertex :]
    made = contacts.x[contacts.n_vertex :].tolist()
    assert [rounded(point) for point in exact] == list(map(tuple, made))
