"""Places of faults and beds, particle by particle: bit for bit what numpy finds, array by array."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf.kernels.sheets.moved_rock import across_fault, heights_on_triangles, values_in_table


def bilinear(table, u, v):
    i = np.minimum(u.astype(np.int64), table.shape[0] - 2)
    j = np.minimum(v.astype(np.int64), table.shape[1] - 2)
    f, g = u - i, v - j
    lower = table[i, j] * (1.0 - f) + table[i + 1, j] * f
    upper = table[i, j + 1] * (1.0 - f) + table[i + 1, j + 1] * f
    return lower * (1.0 - g) + upper * g


def some(rng, n, low, high):
    """Numbers from a little below `low` to a little above `high`, whole ones among them."""
    found = rng.uniform(low - 1.5, high + 1.5, n)
    return np.where(rng.random(n) < 0.3, np.rint(found), found)


@given(st.integers(0, 2**32 - 1))
def test_places_of_a_fault(seed):
    rng = np.random.default_rng(seed)
    table = rng.normal(size=rng.integers(2, 6, 2))
    low, length = rng.uniform(-9, 0), rng.uniform(1, 5)
    high = low + rng.uniform(1, 9)
    s, z, out = some(rng, 40, 0.0, length), some(rng, 40, low, high), np.empty(40)
    across_fault(table, low, high, length, 0.3, s, z, out)
    within = np.clip(z, low, high)
    u = np.clip(s / length, 0.0, 1.0) * (table.shape[0] - 1)
    v = (within - low) / (high - low) * (table.shape[1] - 1)
    assert out.tobytes() == (bilinear(table, u, v) + 0.3 * (z - within)).tobytes()
    values_in_table(table, u, v, out)
    assert out.tobytes() == bilinear(table, u, v).tobytes()


@pytest.mark.parametrize("rising", [True, False])
@given(st.integers(0, 2**32 - 1))
def test_heights_on_triangles_and_beyond_their_rim(rising, seed):
    rng = np.random.default_rng(seed)
    grid = rng.normal(size=rng.integers(2, 6, 2))
    n_row, n_col = grid.shape
    x, y, out = some(rng, 40, 0, n_col - 1), some(rng, 40, 0, n_row - 1), np.empty(40)
    heights_on_triangles(grid, rising, x, y, out)
    j = np.clip(np.floor(x), 0, n_col - 2).astype(np.int64)
    i = np.clip(np.floor(y), 0, n_row - 2).astype(np.int64)
    f, g = x - j, y - i
    a, b, d, c = grid[i, j], grid[i, j + 1], grid[i + 1, j], grid[i + 1, j + 1]
    if rising:
        large, small = np.maximum(f, g), np.minimum(f, g)
        middle = np.where(f >= g, b, d)
        expected = a + (large - small) * (middle - a) + small * (c - a)
    else:
        low = f + g <= 1.0
        base = np.where(low, a, c)
        first, second = np.where(low, f, 1 - g), np.where(low, g, 1 - f)
        expected = base + first * (b - base) + second * (d - base)
    assert out.tobytes() == expected.tobytes()
