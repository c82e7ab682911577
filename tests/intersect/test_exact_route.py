"""Where the exact curve costs less than a smooth one, it is the answer, or the way to it."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import TriSurface, intersect_surfaces
from geosurf.intersect import dial, exact_follow
from geosurf.kernels.smooth.control_nets import lies_beside
from tests.intersect.smooth_worlds import (
    SIDE,
    along,
    distance_from,
    horizon,
    listric_fault,
    onto_the_curve,
    two_triangles,
    waves,
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


@pytest.mark.parametrize("tolerance", [5e-3, 1e-3, 1e-4])
def test_what_triangles_miss_is_met_along_the_exact_curve(tolerance, no_cubics):
    pair = [wavy_horizon(566), listric_fault(283, 566)]
    curves, plain = intersect_surfaces(pair, tolerance=tolerance), intersect_surfaces(pair)
    assert "exact_pairs" not in curves.cost
    assert curves.error_bound.max() <= tolerance
    assert tolerance < 5e-3 or len(curves.points) < 0.6 * len(plain.points)
    there = along(curves)
    worst = np.linalg.norm(onto_the_curve(there) - there, axis=1).max()
    assert worst <= curves.error_bound.max()
    back = onto_the_curve(plain.points[::9])
    assert distance_from(back, curves).max() <= curves.error_bound.max()


@pytest.mark.parametrize("tolerance", [0.1, 1e-3])
def test_curves_along_exact_ones_on_a_mesh_are_those_of_every_point(tolerance, monkeypatch):
    """Lifting each point of the exact curve leads to the same curve, within both bounds."""
    fault = listric_fault(12, 30)
    pair = [wavy_horizon(241), TriSurface("F1", "fault", fault.vertices, fault.triangles)]
    curves = intersect_surfaces(pair, tolerance=tolerance)
    monkeypatch.setattr(dial, "exact_curves", lambda *_: None)
    lifted = intersect_surfaces(pair, tolerance=tolerance)
    assert curves.n_curve == lifted.n_curve == 1
    both = curves.error_bound[0] + lifted.error_bound[0]
    assert distance_from(curves.points, lifted).max() <= both <= 2 * tolerance
    assert distance_from(lifted.points, curves).max() <= both
    assert np.abs(curves.points[curves.curves[0][[0, -1]]][:, :2]).min() < 1e-6


@pytest.mark.parametrize("tolerance", [0.5, 2e-3])
def test_next_to_a_hole_the_exact_curve_stays(tolerance, no_cubics):
    def holed(x, y):
        z = waves(x, y)
        z[np.hypot(x - truth[0], y - truth[1]) < 300.0] = np.nan
        return z

    whole = intersect_surfaces([wavy_horizon(566), two_triangles(-30.0, 0.01, 0.003, side=SIDE)])
    longest = max(whole.curves, key=len)
    truth = whole.points[longest[len(longest) // 2]]
    pair = [horizon(holed, 566, SIDE), two_triangles(-30.0, 0.01, 0.003, side=SIDE)]
    curves, plain = intersect_surfaces(pair, tolerance=tolerance), intersect_surfaces(pair)
    assert {place.reason for place in curves.places} == {"hole"}
    assert curves.n_curve == plain.n_curve
    stays = np.concatenate([place.points for place in curves.places])
    exact = {point.tobytes() for point in plain.points}
    assert {point.tobytes() for point in stays} <= exact
    assert set(np.flatnonzero(np.isinf(curves.error_bound))) == {p.curve for p in curves.places}

    # all that is near the hole stays, and nothing far from it does
    cell = SIDE / 565
    away = np.hypot(*(stays[:, :2] - truth[:2]).T) - 300.0
    assert away.max() < 9 * cell
    near = plain.points[np.hypot(*(plain.points[:, :2] - truth[:2]).T) < 300 + 2 * cell]
    assert len(near)
    assert {point.tobytes() for point in near} <= {point.tobytes() for point in curves.points}

    # elsewhere points are on the cubics, within the tolerance
    x, y, z = np.array([p for p in curves.points if p.tobytes() not in exact]).reshape(-1, 3).T
    assert len(x) == 0 if tolerance > 0.1 else len(x) > 100
    assert np.abs(z - waves(x, y)).max(initial=0.0) <= tolerance


@pytest.mark.parametrize("lattice", [False, True])
def test_dense_surfaces_apart_are_not_searched_again(lattice, no_cubics):
    far = horizon(lambda x, y: 0 * x - 3000.0, 41, SIDE, "far") if lattice else two_triangles(-3e3)
    curves = intersect_surfaces([wavy_horizon(566), far], tolerance=0.5)
    assert curves.n_curve == 0
    assert len(curves.error_bound) == 0


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
        monkeypatch.setattr(exact_follow, "SEGMENTS", most)
        found.append(intersect_surfaces(pair, tolerance=0.01).error_bound.max())
    assert found[0] < 1.5 * found[1]
    assert found[1] < 10 * found[0]


def test_noise_and_holes_keep_the_exact_curve_and_say_so(rng, no_cubics):
    noise = rng.normal(size=(81, 81))
    noise[38:42, 38:42] = np.nan
    hills = horizon(lambda x, y: 200 * np.sin(x / 600) * np.sin(y / 700) + noise, 81)
    pair = [hills, two_triangles(-30.0, 0.05, 0.02)]
    curves = intersect_surfaces(pair, tolerance=0.01)
    assert same_curve(curves, intersect_surfaces(pair))
    assert "noise" in {place.reason for place in curves.places}
    for place in curves.places:
        assert np.isinf(place.error_bound) == (place.reason == "hole")


def test_planes_through_edges_separate_what_lies_beside_a_triangle(rng):
    hits = 0
    for _ in range(300):
        t, net = rng.normal(size=(3, 3)), 0.5 * rng.normal(size=(4, 4, 3))
        net += rng.normal(size=3) * 2.0
        if not lies_beside(net, t):
            continue
        hits += 1

        # some edge has all of the net beyond it, in the plane of the triangle
        u, v = t[1] - t[0], t[2] - t[0]
        s = np.linalg.lstsq(np.stack([u, v], axis=1), (net.reshape(-1, 3) - t[0]).T, rcond=None)[0]
        assert ((s < 0).all(axis=1)).any() or (s.sum(axis=0) > 1).all()
    assert 50 < hits < 290
