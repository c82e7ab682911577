"""Places of faults and beds, particle by particle: bit for bit what numpy finds, array by array."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf.kernels.sheets.moved_rock import (
    across_fault,
    distances_from_fault,
    heights_on_triangles,
    move_rock,
    settle,
    values_in_table,
)
from geosurf.sheets.faults.fault_profile import DipLines


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
    across_fault(table, np.array([low, high, length, 0.3, 0.0]), s, z, out)
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


def moved_by_numpy(axes, table, fault, lines, steps, reach, xy, z, part, throw):
    """The same movement, array by array."""

    def across(s, z):
        out = np.empty(len(s))
        across_fault(table, fault, s, z, out)
        return out

    s, r = axes @ xy.T
    first = fault[4]
    s = s - first
    here = across(s, z)
    down = part * throw
    if np.isfinite(reach):
        away = np.where(part > 0, r - here, here - r)
        down = down * np.clip(1.0 - away / reach, 0.0, None) ** 2
    lower = z - down
    to = s if not len(lines) else DipLines(lines, fault[2], fault[:2]).moved(s, z, lower, steps)
    places = np.stack([to + first, r + across(to, lower) - here], axis=-1) @ axes
    return places, lower


@given(st.integers(0, 2**32 - 1), st.booleans(), st.booleans())
def test_movement_along_a_fault(seed, is_curved, dies):
    rng = np.random.default_rng(seed)
    turn, n = rng.uniform(0, 7), 40
    axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    table, fault = rng.normal(size=(5, 4)), np.array([-6.0, 3.0, 5.0, 0.3, 0.7])
    lines = rng.normal(size=(5, 4)) if is_curved else np.empty((0, 0))
    xy, z = rng.uniform(-9, 9, (n, 2)), some(rng, n, -6.0, 3.0)
    part = rng.choice([-0.4, 0.0, 0.6, 1.0], n)
    throw = rng.normal(size=n)
    of = (2, 4.0 if dies else np.inf, xy, z, part, throw)
    places, lower = np.empty((n, 2)), np.empty(n)
    move_rock(axes, table, fault, lines, *of, places, lower)
    expected, level = moved_by_numpy(axes, table, fault, lines, *of)
    np.testing.assert_allclose(places, expected, rtol=0, atol=1e-12)
    np.testing.assert_allclose(lower, level, rtol=0, atol=1e-12)
    still = part == 0.0
    assert (places[still] == xy[still]).all()
    assert (lower[still] == z[still]).all()


@given(st.integers(0, 2**32 - 1))
def test_distances_across_strike(seed):
    rng = np.random.default_rng(seed)
    table, fault = rng.normal(size=(5, 4)), np.array([-6.0, 3.0, 5.0, 0.3, 0.7])
    xy, z = rng.uniform(-9, 9, (40, 2)), some(rng, 40, -6, 3)
    out, there = np.empty(40), np.empty(40)
    distances_from_fault(np.eye(2), table, fault, xy, z, out)
    across_fault(table, fault, xy[:, 0] - 0.7, z, there)
    assert (out == xy[:, 1] - there).all()


@given(st.integers(0, 2**32 - 1), st.booleans())
def test_particles_that_arrive(seed, both):
    rng = np.random.default_rng(seed)
    n = 20
    todo = np.sort(rng.permutation(30)[:n])
    where, at = rng.uniform(-1, 1, (2, n, 2))
    now = where + rng.choice([0.0, 1e-3, 0.5], (n, 2))
    old, height = rng.uniform(size=(2, n))
    height = np.where(rng.random(n) < 0.5, old, height)
    z, was = np.zeros(30), np.zeros((30, 2))
    left = (np.abs(where - now) > 0.01).any(axis=1)
    if both:
        left |= np.abs(height - old) > 0.01
    found = settle(todo, where, at, old, now, height, both, 0.01, z, was)
    expected = todo[left], where[left], (at + (where - now))[left], height[left]
    for one, other in zip(found, expected, strict=True):
        assert one.tolist() == other.tolist()
    assert z[todo[~left]].tolist() == height[~left].tolist()
    assert was[todo[~left]].tolist() == at[~left].tolist()
    assert np.count_nonzero(was) == 2 * (~left).sum()
