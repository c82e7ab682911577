"""Points that triangles use, against loops over everything."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from geosurf.kernels.meshes.used import near_lines, number_untouched

N = 8
TRIANGLES = st.lists(st.permutations(range(N)).map(lambda p: p[:3]), min_size=1, max_size=20)


@given(TRIANGLES, st.integers(0, 2**32 - 1))
def test_untouched_triangles_get_new_points_in_order(triangles, seed):
    rng = np.random.default_rng(seed)
    t, taken = np.array(triangles), rng.random(len(triangles)) < 0.5
    known = np.where(rng.random(N) < 0.4, rng.permutation(N), -1)
    new = [p for p in range(N) if known[p] < 0 and (t[~taken] == p).any()]
    number = known.copy()
    number[new] = 100 + np.arange(len(new))
    points, n = number_untouched(t, taken, known, 100)
    assert n == np.count_nonzero(~taken)
    assert points.tolist() == new
    assert known.tolist() == number.tolist()


@given(st.integers(0, 2**32 - 1))
def test_places_near_a_line(seed):
    rng = np.random.default_rng(seed)
    places, lines = rng.integers(-5, 6, (30, 3)).astype(float), rng.integers(-3, 4, (2, 3)) * 0.5
    off = np.abs(places[:, None, 0] * lines[:, 0] + places[:, None, 1] * lines[:, 1] + lines[:, 2])
    assert near_lines(places, lines, 1.5).tolist() == (off <= 1.5).any(axis=1).tolist()
