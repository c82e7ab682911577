"""What is foreseen of the error of exact curves: second differences and noise of lattices."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf.kernels.smooth.exact_error import judge_lattices

NONE = np.zeros((1, 1))
STEP = 25.0  # [m]


def judged(z, turned=False):
    """Second differences and noise of one lattice; `turned`: with axes of two dimensions."""
    n_row, n_col = z.shape
    x, y = STEP * np.arange(n_col)[None, :], STEP * np.arange(n_row)[:, None]
    if turned:
        x, y = (np.ascontiguousarray(q) for q in np.broadcast_arrays(x, y))
    return judge_lattices(x, y, z, NONE, NONE, NONE, 7)


def table(f, n=40):
    x, y = np.meshgrid(STEP * np.arange(n + 3), STEP * np.arange(n))
    return f(x, y)


@pytest.mark.parametrize("turned", [False, True])
def test_of_a_paraboloid_second_differences_are_known_and_nothing_is_noise(turned):
    bends, noise = judged(table(lambda x, y: 1e-4 * x * x + 3e-4 * y * y + 0.1 * x), turned)
    assert bends == pytest.approx(2 * (1e-4 + 3e-4) * STEP**2, rel=1e-9)
    assert noise < 1e-9


@pytest.mark.parametrize("size", [0.01, 3.0])
def test_the_noise_of_nodes_is_found(rng, size):
    noise = rng.normal(scale=size, size=(90, 80))
    found = judged(noise)[1]
    assert 0.7 * size < found < 2.0 * size  # the larger of two sides of cells
    hills = table(lambda x, y: 200 * np.sin(x / 600) * np.sin(y / 700), 90)
    assert judged(hills)[1] == 0.0
    assert judged(hills[:, :80] + noise)[1] == pytest.approx(found, rel=0.2)


def test_two_lattices_add_up(rng):
    z, w = rng.normal(size=(30, 40)), rng.normal(size=(9, 8))
    axes = [(STEP * np.arange(q.shape[1])[None, :], STEP * np.arange(q.shape[0])[:, None], q)
            for q in (z, w)]  # fmt: skip
    both = judge_lattices(*axes[0], *axes[1], 7)
    assert both == pytest.approx(np.add(judged(z), judged(w)), rel=1e-12)
