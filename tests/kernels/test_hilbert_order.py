"""Points along Hilbert's curve: all of them, once, and neighbours near one another."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.kernels.rows import ranked_points


def along_hilbert(u, v, n_level):
    """Place of a point of the unit square on Hilbert's curve, below 4**n_level."""
    last = (1 << n_level) - 1
    i, j = int(u * last), int(v * last)
    place = 0
    side = 1 << (n_level - 1)
    while side > 0:
        right, up = (i & side) != 0, (j & side) != 0
        place = 4 * place + (3 if right and not up else (2 if right else (1 if up else 0)))
        if not up:
            if right:
                i, j = last - i, last - j
            i, j = j, i
        side >>= 1
    return place


@pytest.mark.parametrize("n_level", [1, 2, 5])
def test_the_curve_goes_from_cell_to_neighbour(n_level):
    n = 1 << n_level
    at = {}
    for i in range(n):
        for j in range(n):
            at[along_hilbert(i / (n - 1), j / (n - 1), n_level)] = (i, j)
    path = np.array([at[k] for k in range(n * n)])
    assert (np.abs(np.diff(path, axis=0)).sum(axis=1) == 1).all()


coordinate = st.sampled_from([0.0, 1.0, 2.0, 1.0 / 3.0, -7.5, 1e300, -1e-300])


@given(st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=40), st.integers(0, 3))
def test_all_points_once(points, low):
    f = np.zeros((low + len(points), 8))
    f[low:, :2] = points
    assert np.array_equal(np.sort(ranked_points(f, low)), np.arange(low, len(f)))


@pytest.mark.parametrize("n", [200, 5000])
def test_they_lie_as_their_places_on_the_curve(n):
    """Fewer and more points than those for which the curve is coarse, against a sort."""
    f = np.zeros((n, 8))
    f[:, :2] = np.random.default_rng(n).uniform(0.0, 1.0, (n, 2))
    f[:2, :2] = [[0.0, 0.0], [1.0, 1.0]]
    n_level = 8 if n <= 256 else 16
    place = [along_hilbert(u, v, n_level) for u, v in f[:, :2].tolist()]
    assert np.array_equal(ranked_points(f, 0), np.argsort(place, kind="stable"))
