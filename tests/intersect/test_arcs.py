"""Arcs between knots, chords, cones of normals, doubts along curves: each beside a slow oracle."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from geosurf import intersect_surfaces
from geosurf.intersect.sides import side_of
from geosurf.kernels.smooth.coverage import cone
from geosurf.kernels.smooth.cubic_patch import evaluate
from geosurf.kernels.smooth.curve_walk import measure_arc
from geosurf.kernels.smooth.error_estimate import ROUGH, WINDOW, errors_along
from geosurf.kernels.smooth.hermite_arcs import (
    K_LENGTH,
    K_SLOPE,
    N_KNOT,
    along_arc,
    chords_of_arc,
    on_arc,
    set_length,
    squared_distance_to_arc,
)
from geosurf.kernels.smooth.knots import ARC_SAFETY, set_knot
from geosurf.kernels.smooth.lift import (
    F_POINT,
    F_TANGENT,
    LIFTED,
    N_WORK,
    SurfacePair,
    newton_in_plane_to,
)
from geosurf.kernels.smooth.newton_seeds import patch_cone
from geosurf.kernels.smooth.patch_pairs import N_PATCH
from tests.intersect.smooth_worlds import listric_fault, wavy_horizon

PLACES = np.linspace(0.0, 1.0, 401)


def knot(point, tangent):
    """Return a knot with that point and tangent, and numbers of its own as parameters."""
    out = np.zeros(N_KNOT)
    out[:3], out[K_SLOPE : K_SLOPE + 3] = point, tangent
    out[3:7], out[K_SLOPE + 3 : K_LENGTH] = np.arange(4), np.arange(4) + 1
    return out


def drawn(one, two, places=PLACES):
    """Points and parameters at some places of an arc."""
    rows = np.empty((len(places), 7))
    for row, t in zip(rows, places, strict=True):
        on_arc(one, two, float(t), row)
    return rows


def any_arc(rng):
    """Two knots with whole numbers; the arc may turn back, and its ends may be one point."""
    one = knot(rng.integers(-3, 4, 3), rng.integers(-2, 3, 3))
    two = knot(rng.integers(-3, 4, 3), rng.integers(-2, 3, 3))
    two[K_LENGTH] = rng.integers(1, 6)
    return one, two


def on_circle(radius, angle):
    """Two knots on a circle, and the arc between them."""
    knots = [
        knot((radius * np.cos(a), radius * np.sin(a), 5.0), (-np.sin(a), np.cos(a), 0.0))
        for a in (0.0, angle)
    ]
    set_length(*knots)
    return knots


def test_an_arc_has_the_ends_and_slopes_of_its_knots(rng):
    one, two = any_arc(rng)
    rows = drawn(one, two, np.array([0.0, 1.0]))
    assert (rows == [one[:7], two[:7]]).all()
    for t, end in ((0.0, one), (1.0, two)):
        assert along_arc(one, two, t) == tuple(two[K_LENGTH] * end[K_SLOPE : K_SLOPE + 3])
    step = 1e-6
    for t in (0.2, 0.7):
        a, b = drawn(one, two, np.array([t - step, t + step]))
        assert np.allclose((b - a)[:3] / (2 * step), along_arc(one, two, t), atol=1e-6)


def test_arcs_of_a_circle_gain_four_orders():
    away = [
        np.abs(np.hypot(*drawn(*on_circle(1000.0, angle))[:, :2].T) - 1000.0).max()
        for angle in (0.4, 0.2, 0.1)
    ]
    assert away[0] < 0.1
    assert away[0] / away[1] > 14
    assert away[1] / away[2] > 14


@pytest.mark.parametrize("target", [2.0, 0.3, 0.02])
def test_no_chord_is_farther_from_its_arc_than_told(rng, target):
    for _ in range(20):
        one, two = any_arc(rng)
        count, told = chords_of_arc(one, two, target)
        assert told <= target
        corners = drawn(one, two, np.arange(count + 1) / count)[:, :3]
        place = np.minimum((PLACES * count).astype(int), count - 1)
        part = (PLACES * count - place)[:, None]
        linear = corners[place] + part * (corners[place + 1] - corners[place])
        away = np.linalg.norm(drawn(one, two)[:, :3] - linear, axis=1).max()
        assert away <= told * (1 + 1e-9) + 1e-12


def test_a_straight_arc_is_one_chord():
    one, two = knot((0, 0, 0), (0.6, 0.8, 0)), knot((6, 8, 0), (0.6, 0.8, 0))
    set_length(one, two)
    assert two[K_LENGTH] == 10.0
    count, told = chords_of_arc(one, two, 1e-6)
    assert count == 1
    assert told < 1e-12


def test_a_chord_of_a_circle_is_told_within_a_percent():
    one, two = on_circle(1000.0, 0.1)
    count, told = chords_of_arc(one, two, np.inf)
    assert count == 1
    assert told == pytest.approx(1000.0 * (1 - np.cos(0.05)), rel=0.01)


def test_distances_from_arcs_are_those_of_many_places(rng):
    one, two = on_circle(100.0, 0.6)
    fine = drawn(one, two, np.linspace(0, 1, 20001))[:, :3]
    for t, aside in rng.random((20, 2)) * (1.0, 0.5):
        point = drawn(one, two, np.array([t]))[0, :3] + rng.normal(size=3) * aside
        slow = np.linalg.norm(fine - point, axis=1).min()
        assert np.sqrt(squared_distance_to_arc(one, two, *point)) == pytest.approx(slow, abs=1e-4)


# ---- cones -------------------------------------------------------------------------------


def bernstein(t):
    """Values of the four polynomials at places (n,), and their derivatives."""
    s = 1 - t
    values = np.stack([s**3, 3 * s * s * t, 3 * s * t * t, t**3])
    return values, np.gradient(values, t, axis=1, edge_order=2)


@pytest.mark.parametrize("rough", [0.0, 0.2, 1.0])
def test_cones_hold_all_normals(rng, rough):
    u, v = np.meshgrid(np.arange(4.0), np.arange(4.0))
    values, slopes = bernstein(np.linspace(0, 1, 201))
    told = 0
    for _ in range(10):
        net = np.stack([u, v, 0.3 * u], axis=-1) + rough * rng.integers(-1, 2, (4, 4, 3)) / 2
        du = np.einsum("im,jn,ijk->mnk", values, slopes, net)[1:-1:4, 1:-1:4]
        dv = np.einsum("im,jn,ijk->mnk", slopes, values, net)[1:-1:4, 1:-1:4]
        normals = np.cross(du, dv)
        normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
        p, q, r, angle = cone(net)
        if angle < np.pi:
            told += 1
            assert (normals @ (p, q, r) >= np.cos(angle) - 1e-6).all()
    assert told > 0 or rough == 1.0


def test_a_flat_net_has_a_cone_of_no_width():
    u, v = np.meshgrid(np.arange(4.0), np.arange(4.0))
    p, q, r, angle = cone(np.stack([u, v, 0.75 * u], axis=-1))
    assert np.allclose((p, q, r), (-0.6, 0.0, 0.8))
    assert angle < 1e-7


def test_a_patch_without_area_has_no_cone():
    assert patch_cone(np.zeros(N_PATCH))[3] == np.pi


# ---- doubts ------------------------------------------------------------------------------


def slow_doubts(rows):
    """`errors_along`, written down once more."""
    total, rough = np.zeros(len(rows)), np.zeros(len(rows))
    for k in range(len(rows)):
        part = np.sqrt((rows[max(k - WINDOW, 0) : k + WINDOW + 1] ** 2).mean(axis=0))
        for own in (0, 3):
            fine, finer, noise = part[own : own + 3]
            q = finer / fine if fine > 0 else 0.0
            total[k] += rows[k, own] / (1 - min(q, ROUGH)) + noise
            rough[k] += noise * (q > ROUGH)
    return total / rows[:, 6], rough / rows[:, 6]


@pytest.mark.parametrize("n", [1, 5, 60])
def test_doubts_are_summed_over_windows(rng, n):
    rows = rng.random((n, 7)) * (1, 0.3, 0.1, 1, 0.4, 0.2, 1) + (0, 0, 0, 0, 0, 0, 0.1)
    rows[: n // 3, :3] = 0.0
    for fast, slow in zip(errors_along(rows), slow_doubts(rows), strict=True):
        assert np.allclose(fast, slow, rtol=1e-12)


def test_a_gap_in_the_data_is_no_number():
    rows = np.ones((4, 7))
    rows[2, :3] = np.nan
    total, _ = errors_along(rows)
    assert np.isnan(total).all()


# ---- walks -------------------------------------------------------------------------------


@pytest.mark.parametrize("tolerance", [1.0, 0.05, 0.004])
def test_walks_go_on_and_meet_the_tolerance_or_say_why(tolerance):
    """The seed lies in the middle of an open curve: both halves join there, and none turns back."""
    curves = intersect_surfaces([wavy_horizon(121), listric_fault(121, 121)], tolerance=tolerance)
    told = {place.curve for place in curves.places}
    for k, curve in enumerate(curves.curves):
        steps = np.diff(curves.points[curve], axis=0)
        steps /= np.linalg.norm(steps, axis=1, keepdims=True)
        assert ((steps[1:] * steps[:-1]).sum(axis=1) > 0.75).all()
        assert curves.error_bound[k] <= tolerance or k in told
        assert curves.error_bound[k] > 0.3 * tolerance or tolerance == 1.0


# ---- how far arcs are from curves -----------------------------------------------------------


def knots_along(sides, w, steps):
    """Knots on the curve of two lattices: from parameters (4,) on, by lengths along the tangent."""
    arrays = (sides[0].x, sides[0].y, sides[0].z, sides[1].x, sides[1].y, sides[1].z, sides[1].c)
    f, out = np.empty(N_WORK), []
    w, at = np.array(w, dtype=float), np.zeros(3)
    for k, step in enumerate([0.0, *steps]):
        if k == 0:
            evaluate(*arrays[:3], w[0], w[1], f, 0)
            at[:] = f[:3]
            way = (0.0, 0.0, 0.0)
        else:
            way = out[-1][K_SLOPE : K_SLOPE + 3]
            at[:] = out[-1][:3] + step * way
            w = out[-1][3:7] + step * out[-1][K_SLOPE + 3 : K_LENGTH]
        assert newton_in_plane_to(SurfacePair(*arrays), 0, w, *at, *way, 1e-9, f) == LIFTED
        knot = np.zeros(N_KNOT)
        knot[3:7] = w
        ahead = 1.0 if k == 0 or f[F_TANGENT : F_TANGENT + 3] @ way > 0 else -1.0
        set_knot(ahead, f, knot)
        if out:
            set_length(out[-1], knot)
        out.append(knot)
    return arrays, out


def test_no_curve_is_farther_from_its_arc_than_twice_what_was_measured(rng):
    """Steps of a third of a cell to two cells, over many borders of cells; at 61 places each."""
    surfaces = wavy_horizon(41), listric_fault(41, 41)
    sides = [side_of(surface, np.zeros(3)) for surface in surfaces]
    plain = intersect_surfaces(surfaces, tolerance=5.0)
    start = plain.points[plain.curves[0][len(plain.curves[0]) // 3]]
    x, y = surfaces[1].lattice.easting, surfaces[1].lattice.northing
    i, j = np.unravel_index(np.hypot(x - start[0], y - start[1]).argmin(), x.shape)
    w = (start[0] / 250.0, start[1] / 250.0, float(j), float(i))
    arrays, knots = knots_along(sides, w, rng.uniform(80.0, 500.0, 12))
    row, f, worst = np.empty(7), np.empty(N_WORK), []
    for one, two in pairwise(knots):
        measured = measure_arc(SurfacePair(*arrays), one, two, np.inf, 1e-9, row, f)
        most = 0.0
        for place in np.linspace(0.02, 0.98, 61):
            on_arc(one, two, float(place), row)
            x, y, z = row[:3]
            way = along_arc(one, two, float(place))
            assert (
                newton_in_plane_to(SurfacePair(*arrays), 0, row[3:7], x, y, z, *way, 1e-9, f)
                == LIFTED
            )
            most = max(most, float(np.linalg.norm(f[F_POINT : F_POINT + 3] - (x, y, z))))
        worst.append(most / measured)
    assert max(worst) <= ARC_SAFETY
    assert max(worst) > 1.1  # or the factor would not be needed
