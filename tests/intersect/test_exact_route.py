"""Where the exact curve costs less than a smooth one and is as near, it is the answer."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import intersect_surfaces
from geosurf.intersect import dial, exact_route
from tests.intersect.smooth_worlds import (
    along,
    distance_from,
    horizon,
    listric_fault,
    onto_the_curve,
    two_triangles,
    wavy_horizon,
)


@pytest.fixture
def no_cubics(monkeypatch):
    """What searches cells of cubics fails: the exact curve is returned at once."""

    def fail(*_):
        raise AssertionError("cubics were searched")

    monkeypatch.setattr(dial, "sides_of", fail)


def rough_pair(rng):
    noise = rng.normal(size=(81, 81))
    hills = horizon(lambda x, y: 200 * np.sin(x / 600) * np.sin(y / 700) + noise, 81)
    return [hills, two_triangles(-30.0, 0.05, 0.02)]


def same_curve(curves, plain) -> bool:
    """Whether all curves have the same points in the same order, bit by bit."""
    lines = [[c.points[line].tobytes() for line in c.curves] for c in (curves, plain)]
    return lines[0] == lines[1]


@pytest.mark.parametrize("tolerance", [2.0, 0.5])
def test_dense_lattices_keep_the_exact_curve_within_its_bound(tolerance, no_cubics):
    pair = [wavy_horizon(566), listric_fault(283, 566)]
    curves, plain = intersect_surfaces(pair, tolerance=tolerance), intersect_surfaces(pair)
    assert same_curve(curves, plain)
    assert curves.places == ()
    assert curves.cost["exact_pairs"] == 1
    (bound,) = curves.error_bound
    there = along(curves)
    worst = np.linalg.norm(onto_the_curve(there) - there, axis=1).max()
    assert worst <= bound <= min(tolerance, 10 * worst)
    back = onto_the_curve(there[:: max(1, len(there) // 1500)])
    assert distance_from(back, curves).max() <= 1.01 * bound


def test_a_tolerance_that_triangles_miss_is_met_by_a_smooth_curve():
    pair = [wavy_horizon(566), listric_fault(283, 566)]
    curves = intersect_surfaces(pair, tolerance=1e-3)
    assert "exact_pairs" not in curves.cost
    assert curves.error_bound.max() <= 1e-3


@pytest.mark.parametrize("flip", [False, True])
def test_one_pair_has_the_rows_of_the_exact_route_in_either_order(flip, rng):
    pair = rough_pair(rng)[:: -1 if flip else 1]
    curves, plain = intersect_surfaces(pair, tolerance=0.01), intersect_surfaces(pair)
    assert curves.names == plain.names == tuple(one.name for one in pair)
    for key in ("points", "segments", "surfaces_of_segment", "surfaces_of_curve", "closed"):
        assert getattr(curves, key).tobytes() == getattr(plain, key).tobytes()

    # among more surfaces they are the same curves, with the same bound and place
    apart = two_triangles(-3000.0).renamed("far below")
    both = intersect_surfaces([*pair, apart], tolerance=0.01)
    assert same_curve(both, plain)
    assert both.error_bound.tobytes() == curves.error_bound.tobytes()
    for one, other in zip(both.places, curves.places, strict=True):
        assert (one.reason, one.surfaces, one.curve) == (other.reason, other.surfaces, other.curve)
        np.testing.assert_allclose(one.points, other.points, atol=1e-9)


@pytest.mark.parametrize("tolerance", [0.3, 0.01])
def test_noise_keeps_the_exact_curve_at_once_and_says_so(tolerance, rng, no_cubics):
    pair = rough_pair(rng)
    curves = intersect_surfaces(pair, tolerance=tolerance)
    assert same_curve(curves, intersect_surfaces(pair))
    assert {place.reason for place in curves.places} == {"noise"}
    assert {place.curve for place in curves.places} == set(range(curves.n_curve))
    assert (curves.error_bound > 1.0).all()


def test_the_error_is_that_of_all_segments_where_they_are_few(monkeypatch, rng):
    """Fewer samples see no more: what all segments say is the largest of what some of them say."""
    pair = rough_pair(rng)
    found = []
    for most in (10, 10**6):
        monkeypatch.setattr(exact_route, "SEGMENTS", most)
        found.append(intersect_surfaces(pair, tolerance=0.01).error_bound.max())
    assert found[0] < 1.5 * found[1]
    assert found[1] < 10 * found[0]


def test_holes_and_surfaces_apart_are_left_to_smooth_curves(rng):
    noise = rng.normal(size=(81, 81))
    noise[38:42, 38:42] = np.nan
    hills = horizon(lambda x, y: 200 * np.sin(x / 600) * np.sin(y / 700) + noise, 81)
    holed = intersect_surfaces([hills, two_triangles(-30.0, 0.05, 0.02)], tolerance=0.01)
    assert "exact_pairs" not in holed.cost
    apart = intersect_surfaces([rough_pair(rng)[0], two_triangles(-3000.0)], tolerance=0.01)
    assert apart.n_curve == 0
