"""Pairs that are surely apart, against exact contacts: never one that meets elsewhere."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf.arrangement.triangles import crossing_pairs
from geosurf.kernels.contacts.triangle_contact import FIRST_CODE, N_COLUMN, N_CORNER, meet_pairs
from geosurf.kernels.exact.predicates import frame_of
from tests import oracles

POINT = st.tuples(*[st.integers(0, 3)] * 3)


@st.composite
def meshes(draw):
    """Triangles with an area on few places of a small lattice, so that they meet in all ways."""
    points = np.array(draw(st.lists(POINT, min_size=4, max_size=9, unique=True)), dtype=float)
    every = list(itertools.combinations(range(len(points)), 3))
    rows = draw(st.lists(st.sampled_from(every), min_size=2, max_size=8))
    t = np.array([draw(st.permutations(row)) for row in rows], dtype=np.int64)
    a, b, c = (points[t[:, k]] for k in range(3))
    return points, t[np.cross(b - a, c - a).any(axis=1)]


def exact_pairs(x, t, n_first):
    """Pairs that meet elsewhere than in common corners and edges, each contact taken exactly."""
    pairs = np.array(
        [
            (i, j)
            for i, j in itertools.combinations(range(len(t)), 2)
            if i < n_first and set(t[i].tolist()) != set(t[j].tolist())
        ],
        dtype=np.int64,
    ).reshape(-1, 2)
    m, w = frame_of(x, len(t))
    rows = np.empty((len(pairs) + 1, N_COLUMN), dtype=np.int64)
    n, _ = meet_pairs(x, t, pairs, m, w, 0.0, rows, np.empty(0, dtype=np.int64))
    found = set()
    for row in rows[:n].tolist():
        codes = row[FIRST_CODE : FIRST_CODE + row[N_CORNER]]
        if any((code >> 3) > 2 or (code & 7) > 2 for code in codes):
            found.add((row[0], row[1]))
    return found


@given(meshes(), st.sampled_from([1.0, 1e-3, 1e9]), st.booleans(), st.integers(0, 3))
def test_crossing_pairs_are_those_of_all_pairs(mesh, scale, jitter, n_other):
    x, t = mesh
    x = x * scale
    if jitter:  # no longer in planes, and no differences without rounding
        x = x * (1.0 + 1e-3 * np.sin(np.arange(x.size).reshape(x.shape))) + scale / 3.0
    n_first = max(len(t) - n_other, 0)
    if n_first == 0:
        return
    found = crossing_pairs(x, t[:n_first], t[n_first:])
    assert {tuple(pair) for pair in found.tolist()} == exact_pairs(x, t, n_first)
    order = [tuple(pair) for pair in found.tolist()]
    assert order == sorted(set(order))


TURN = np.linalg.qr(np.array([[1.0, 2, 3], [4, 5, 6], [7, 8, 10]]))[0]


@pytest.mark.parametrize("shift", [0.0, 7e3, 7e6])
def test_what_was_in_one_plane_before_rounding_is_not_sure(shift):
    """Triangles over a lattice that was turned: many thousands miss or meet by an ulp."""
    lattice = np.array(list(itertools.product(range(3), repeat=3)), dtype=float)
    every = np.array(list(itertools.combinations(range(27), 3)))
    a, b, c = (lattice[every[:, k]] for k in range(3))
    every = every[np.cross(b - a, c - a).any(axis=1)]
    t = every[np.random.default_rng(5).choice(len(every), 130, replace=False)]
    x = lattice @ TURN + shift
    found = {tuple(pair) for pair in crossing_pairs(x, t).tolist()}
    expected = exact_pairs(x, t, len(t))
    assert len(expected) > 1000
    assert found == expected


@given(meshes())
def test_against_clipping(mesh):
    """Without the engine's contacts: what two triangles have in common, in rational numbers."""
    x, t = mesh
    t = t[:4]
    if len(t) == 0:
        return
    found = {tuple(pair) for pair in crossing_pairs(x, t).tolist()}
    for i, j in itertools.combinations(range(len(t)), 2):
        shared = set(t[i].tolist()) & set(t[j].tolist())
        if len(shared) == 3:
            continue
        met = oracles.meet_triangles(oracles.rational(x[t[i]]), oracles.rational(x[t[j]]))
        clean = set(met) <= set(oracles.rational(x[sorted(shared)]))
        assert ((i, j) in found) != clean
