"""Sticks as files have them: points in any order, sticks twice, and a single one."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import GeosurfWarning, SurfaceError
from geosurf.triangulate.sticks import sorted_along


def listric(northing, n=9):
    """A stick that flattens with depth, and leans a little along strike."""
    t = np.linspace(0.0, 1.0, n)
    return np.column_stack([1000 * t**2, northing + 20 * t, -1500 - 800 * t])


def overturned(northing, n=15):
    """A stick that goes around a bend: no direction in which its points are in order."""
    a = np.linspace(0.0, 1.3 * np.pi, n)
    return np.column_stack([500 * np.sin(a), np.full(n, float(northing)), 400 * np.cos(a)])


def bytes_of(sticks):
    surface = gs.triangulate_sticks(sticks, name="F1")
    return surface.vertices.tobytes(), surface.triangles.tobytes()


@pytest.mark.parametrize("shape", [listric, overturned])
def test_sticks_and_their_points_may_come_in_any_order(shape, rng):
    sticks = [shape(300.0 * k) for k in range(5)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # in order there is nothing to warn of
        expected = bytes_of(sticks)
    for _ in range(3):
        mixed = [sticks[i][rng.permutation(len(sticks[i]))] for i in rng.permutation(5)]
        with pytest.warns(GeosurfWarning, match=r"'F1': the points of 5 sticks run back and forth"):
            assert bytes_of(mixed) == expected


def test_picks_that_slip_back_a_little_stay_as_they_are():
    level = np.array([[0, 0, 0], [100, 0, 1], [90, 0, -1], [200, 0, 0.0]])
    assert sorted_along(level) is level
    mixed = level[[0, 3, 1, 2]]
    assert np.ptp(np.diff(sorted_along(mixed)[:, 0])) < np.ptp(np.diff(mixed[:, 0]))


def test_a_stick_that_comes_twice_is_used_once():
    sticks = [listric(0.0), listric(300.0), listric(600.0)]
    words = r"2 sticks of 5 came twice and are used once; sticks 0 and 3 are the same, from \(E 0,"
    with pytest.warns(GeosurfWarning, match=words) as found:
        again = bytes_of([*sticks, sticks[0][::-1], sticks[2]])
    assert again == bytes_of(sticks)
    assert (found[0].message.kind, found[0].message.subject) == ("sticks", "F1")


@pytest.mark.parametrize("strike", [0.0, 30.0, 250.0])
def test_a_single_stick_with_a_strike_is_a_fault_of_that_strike(strike):
    stick = listric(0.0)
    surface = gs.triangulate_sticks([stick], name="F1", strike=strike, length=2000)
    along = np.array([np.sin(np.radians(strike)), np.cos(np.radians(strike)), 0.0])
    a, b, c = surface.vertices[surface.triangles].swapaxes(0, 1)
    normal = np.cross(b - a, c - a)
    assert np.abs(normal @ along).max() < 1e-9 * np.linalg.norm(normal, axis=1).max()
    reach = surface.vertices @ along
    own = stick @ along
    assert np.ptp(reach) == pytest.approx(2000 + np.ptp(own), rel=1e-12)
    places = {tuple(x) for x in surface.vertices.tolist()}
    assert all(tuple(x) in places for x in stick.tolist())


def test_a_strike_that_cannot_be_used_is_refused():
    for words, match in (
        ({"strike": 30}, r"length is None. A single stick needs strike, .*strike=30, length=2000"),
        ({"length": 500.0}, r"strike is None"),
        ({"strike": "N", "length": 500.0}, r"strike is 'N'"),
        ({"strike": 30, "length": -5}, r"length is -5"),
    ):
        with pytest.raises(SurfaceError, match=match):
            gs.triangulate_sticks([listric(0.0)], name="F1", **words)
    with pytest.raises(SurfaceError, match=r"has 2 sticks, which define its strike. Leave strike"):
        gs.triangulate_sticks([listric(0.0), listric(9.0)], name="F1", strike=3, length=9)
