"""Layers on one map that are known not to meet: their cubics, evaluated densely, never do."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from geosurf import Lattice, TriSurface, intersect_surfaces
from geosurf.intersect.layers import are_apart
from tests.intersect.cubics import points_on, weights


def pair_of(z, difference, axes=None):
    y, x = axes or (50.0 * np.arange(z.shape[0]), 50.0 * np.arange(z.shape[1]))
    heights = z, z - difference
    return [
        TriSurface(name, "horizon", lattice=Lattice(x, y, h))
        for name, h in zip(("Top", "Base"), heights, strict=True)
    ]


def least_distance(pair):
    """Least vertical distance of the cubics of two lattices, over a raster of every cell."""
    n_row, n_col = pair[0].lattice.shape
    u, v = np.meshgrid(np.linspace(0, n_col - 1, 6 * n_col), np.linspace(0, n_row - 1, 6 * n_row))
    w = np.stack([u.ravel(), v.ravel()], axis=1)
    first, second = (
        points_on(s.lattice.easting[None, :], s.lattice.northing[:, None], s.lattice.elevation, w)
        for s in pair
    )
    np.testing.assert_allclose(first[:, :2], second[:, :2])
    return float((first[:, 2] - second[:, 2]).min())


def signs_of_a_rim(shape):
    """Differences of nodes that pull the cubic out of their range the most, in the first cell."""
    sign = np.sign(weights(np.array([0.65]))[0])
    found = np.ones(shape)
    found[:4, :4] = -np.outer(sign, sign)
    return found


@pytest.mark.parametrize("seed", range(16))
def test_layers_known_to_be_apart_are(seed):
    rng = np.random.default_rng(seed)
    shape = tuple(rng.integers(8, 45, 2))
    relief = 300.0 * rng.normal(size=shape).cumsum(axis=0)
    signs = signs_of_a_rim(shape) if seed % 2 else rng.choice([-1.0, 1.0], shape)
    if seed % 4 == 3:
        signs = signs[::-1, ::-1]
    known = 0
    for mean in (1.0, 1.5, 2.0, 2.5, 2.67, 3.5):
        pair = pair_of(relief, mean + signs)
        if are_apart(*pair):
            known += 1
            assert least_distance(pair) > 0.0
            assert are_apart(*pair[::-1])
    assert known  # of layers five times farther apart than they are thick or thin


def test_cubics_can_meet_where_nodes_are_apart():
    """What the bound is for: at a rim they leave the range of their nodes by more than a half."""
    pair = pair_of(np.zeros((12, 12)), 1.9 + signs_of_a_rim((12, 12)))
    assert least_distance(pair) < 0.0
    assert not are_apart(*pair)


@pytest.mark.parametrize("n", [18, 19, 33, 40])
def test_the_nodes_of_a_cell_may_lie_in_two_blocks(n):
    """Cells next to the side of a block use nodes beyond it, and in the last column two of them."""
    flat = np.zeros((9, n))
    for first in range(n - 3):
        difference = np.full((9, n), 1.0)
        difference[:, [first, first + 3]] = 2.2, 0.46  # too far apart for one cell, not for two
        for found in (difference, difference[:, ::-1]):
            assert not are_apart(*pair_of(flat, found))
            assert not are_apart(*pair_of(flat.T, found.T))


def test_layers_that_meet_anywhere_are_not_known_to_be_apart():
    z = np.add.outer(np.sin(np.arange(37.0) / 5), np.cos(np.arange(41.0) / 7))
    for i, j in itertools.product((0, 1, 15, 16, 17, 36), (0, 3, 16, 32, 40)):
        difference = np.full(z.shape, 5.0)
        difference[i, j] = 0.0
        assert not are_apart(*pair_of(z, difference))
    assert are_apart(*pair_of(z, np.full(z.shape, 5.0)))
    assert are_apart(*pair_of(z, np.full(z.shape, -5.0)))


def test_other_grids_are_searched():
    z, five = np.zeros((20, 20)), np.full((20, 20), 5.0)
    one, two = pair_of(z, five)
    assert are_apart(one, two)
    hole = z.copy()
    hole[3, 3] = np.nan
    assert not are_apart(one, pair_of(hole, five)[1])
    assert not are_apart(one, pair_of(z, five, (np.arange(20.0), np.arange(20.0)))[1])
    uneven = np.cumsum(1.0 + np.arange(20.0) % 2), np.arange(20.0)
    assert not are_apart(*pair_of(z, five, uneven))


def test_the_curves_are_those_of_a_search(monkeypatch):
    x = np.arange(60.0)
    z = 3.0 * np.add.outer(np.sin(x / 9), np.cos(x / 7))
    pairs = [pair_of(z, 2.0 + np.add.outer(np.sin(x / 11), 0 * x)), pair_of(z, np.sin(z))]
    quick = [intersect_surfaces(pair, tolerance=0.1) for pair in pairs]
    monkeypatch.setattr("geosurf.intersect.dial.are_apart", lambda one, two: False)
    for curves, pair in zip(quick, pairs, strict=True):
        searched = intersect_surfaces(pair, tolerance=0.1)
        assert curves.points.tobytes() == searched.points.tobytes()
        assert curves.n_curve == searched.n_curve
        assert [p.reason for p in curves.places] == [p.reason for p in searched.places]
    assert [curves.n_curve > 0 for curves in quick] == [False, True]
