"""Runs of a lattice against its list of triangles and the edges that they share."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from geosurf import TriSurface
from geosurf.carve.measures import AREA, FLAT, LOOKS_DOWN, LOOKS_UP, LOWER, UPPER, VOLUME
from geosurf.kernels.lattices import strips
from geosurf.kernels.meshes import volumes
from geosurf.model import Lattice

ALL = np.ones(1, dtype=bool)  # the faces that are measured: one


@st.composite
def holed_lattices(draw):
    """A lattice with holes, and some of its triangles, taken."""
    n_row, n_col = draw(st.integers(2, 7)), draw(st.integers(2, 7))
    z = np.array(draw(st.lists(st.integers(0, 9), min_size=n_row * n_col, max_size=n_row * n_col)))
    z = np.where(z < draw(st.sampled_from([0, 2])), np.nan, z).reshape(n_row, n_col)
    sign = draw(st.sampled_from([1.0, -1.0]))  # falling axes turn the triangles
    lattice = Lattice(np.arange(n_col), sign * np.arange(n_row), z, draw(st.booleans()))
    keys = lattice.keys
    kept = draw(st.lists(st.booleans(), min_size=len(keys), max_size=len(keys)))
    return lattice, keys[np.array(kept, dtype=bool)]


def run_of_keys(a, runs):
    """The run of each triangle by key, -1 where there is none: place by place."""
    n_row, n_col = a[9:11] - 1
    run = np.full(2 * n_row * n_col, -1)
    for i, (row, first, last, _) in enumerate(runs.tolist()):
        for place in range(first, last + 1):
            half = 1 - place % 2 if a[11] else place % 2  # rising or not
            run[2 * (row * n_col + place // 2) + half] = i
    return run


def edges_of(lattice):
    """Triangles on each edge: {two nodes: [(key, number of the edge in the triangle)]}."""
    found = {}
    corners = lattice.corners_of_keys(lattice.keys)
    for key, t in zip(lattice.keys.tolist(), corners.tolist(), strict=True):
        for k in range(3):
            found.setdefault(frozenset((t[k], t[(k + 1) % 3])), []).append((key, k))
    return found


@given(holed_lattices())
def test_runs_hold_what_is_left_and_know_their_neighbours(case):
    lattice, taken = case
    a = lattice.places
    absent = lattice.gaps
    runs = np.empty((200, 4), dtype=np.int64)
    start, n = strips.find_runs(a, taken, absent, runs)
    runs = runs[:n]
    run = run_of_keys(a, runs)
    left = np.setdiff1d(lattice.keys, taken)
    np.testing.assert_array_equal(np.flatnonzero(run >= 0), left)
    np.testing.assert_array_equal(strips.runs_of_keys(a, runs, start, left), run[left])
    assert (strips.runs_of_keys(a, runs, start, taken) == -1).all()
    low = strips.lowest_keys(a, runs)
    assert low.tolist() == [np.flatnonzero(run == i).min() for i in range(n)]
    edges = edges_of(lattice)
    pairs = {frozenset(run[key] for key, _ in on) for on in edges.values() if len(on) == 2}
    pairs = {pair for pair in pairs if len(pair) == 2 and -1 not in pair}
    assert pairs == {frozenset(p) for p in strips.join_runs(a, runs, start).tolist()}
    rim = {run[on[0][0]] for on in edges.values() if len(on) == 1} - {-1}
    assert rim == set(np.flatnonzero(runs[:, strips.RIM]).tolist())
    for on in edges.values():
        for key, k in on:
            other = next((other for other, _ in on if other != key), -1)
            found = strips.keys_across(a, absent, lattice.turned, np.array([key]), np.array([k]))
            assert found.tolist() == [other]


@given(holed_lattices())
def test_measures_are_those_of_the_triangles(case):
    lattice, taken = case
    surface = TriSurface("Top", "horizon", lattice=lattice)
    absent = lattice.gaps
    runs = np.empty((200, 4), dtype=np.int64)
    _, n = strips.find_runs(lattice.places, taken, absent, runs)
    run = run_of_keys(lattice.places, runs[:n])
    keys = np.flatnonzero(run >= 0)
    corners = surface.places_of_nodes(lattice.corners_of_keys(keys).ravel()).reshape(-1, 3, 3)
    a, b, c = (corners[:, k] for k in range(3))
    area = 0.5 * np.cross(b - a, c - a)[:, 2]
    full = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    volume = 3.0 * area * (corners[:, :, 2].mean(axis=1) - 4.0) * 2.0
    grid = (*lattice.coordinates, lattice.places, runs[:n])
    for face in (np.arange(n), np.arange(n) % 2):  # each run by itself, and two faces of several
        of, n_face = face[run[keys]], int(face.max(initial=-1)) + 1
        sums = np.zeros((n_face, volumes.N_SUM))
        sums[:, LOWER], sums[:, UPPER] = np.inf, -np.inf
        volumes.add_runs(*grid, face, np.array([1.0, 2.0, 3.0]), 1.0, sums)
        exact = [math.fsum(volume[of == i]) for i in range(n_face)]
        np.testing.assert_allclose(sums[:, VOLUME].sum(axis=1), exact, rtol=1e-15, atol=1e-13)
        flat, size = np.bincount(of, 2.0 * area, n_face), np.bincount(of, full, n_face)
        np.testing.assert_allclose(sums[:, FLAT], flat, atol=1e-12)
        np.testing.assert_allclose(sums[:, AREA].sum(axis=1), size, atol=1e-12)
        for i in range(n_face):
            inside = corners[of == i] - (1.0, 2.0, 3.0)
            assert sums[i, LOWER].tolist() == inside.min(axis=(0, 1)).tolist()
            assert sums[i, UPPER].tolist() == inside.max(axis=(0, 1)).tolist()
        up, down = sums[:, LOOKS_UP].sum(axis=1), sums[:, LOOKS_DOWN].sum(axis=1)
        mine = np.bincount(of, 2.0 * np.maximum(area, 0.0), n_face)
        np.testing.assert_allclose(up, mine, atol=1e-12)
        np.testing.assert_allclose(up - down, flat, atol=1e-12)


def test_nothing_is_lost_of_a_sum_of_large_and_small_terms():
    """Two numbers hold what one would round away: a thousand small steps on a large one."""
    x = np.array([[0.0, 0, 0], [1e8, 0, 0], [0, 1e8, 0], [1, 0, 1], [0, 1, 1], [0, 0, 1]])
    t = np.array([[0, 1, 2], *[[5, 3, 4]] * 1000, [0, 2, 1]])
    found = np.zeros((1, volumes.N_SUM))
    volumes.add_triangles(x, t, np.zeros(len(t), dtype=np.int64), ALL, -1.0, found)
    assert found[0, VOLUME].sum() == 6000.0
