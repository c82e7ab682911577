"""Fault polygons: closed, as large as the heave, and together with the horizon without a gap."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import Scene, synthetic, tear_horizon
from geosurf.measure import faces_of
from tests.measure.worlds import faulted


def rings_of(found):
    """The rings of a dataset, each (n, 2)."""
    points = np.stack([found.easting.values, found.northing.values], axis=1)
    return np.split(points, np.cumsum(found["count"].values)[:-1])


def winding(ring, place):
    """How often a ring runs around a place, counter-clockwise: the sum of its angles."""
    p = ring - place
    q = np.roll(p, -1, axis=0)
    turn = np.arctan2(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0], (p * q).sum(axis=1))
    return round(turn.sum() / (2.0 * np.pi))


def shadows(scene, name, place):
    """How many triangles of a horizon lie over a place: facing up, less those that face down."""
    faces = faces_of(scene.patches, scene.units, name, "horizon")
    corners = (faces.x + faces.origin)[faces.triangles][:, :, :2] - place
    turns = []
    for k in range(3):
        p, q = corners[:, k], corners[:, (k + 1) % 3]
        turns.append(np.sign(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]))
    turns = np.array(turns)
    return int((turns > 0).all(axis=0).sum()) - int((turns < 0).all(axis=0).sum())


def assert_nothing_is_missing(scene, name, found, places):
    """Horizon and rings cover each place once, whatever lies above what."""
    west, east, south, north = scene.box[:4]
    faces = faces_of(scene.patches, scene.units, name, "horizon")
    covered = float(faces.vectors[:, 2].sum()) + float(found.map_area.sum())
    assert covered == pytest.approx((east - west) * (north - south), rel=1e-12)
    rings = rings_of(found)
    for place in places:
        assert shadows(scene, name, place) + sum(winding(r, place) for r in rings) == 1


@pytest.mark.parametrize("throw", [(4.0, 4.0), (1.0, 6.0), (-4.0, -4.0), (-3.0, 5.0), (0.0, 7.0)])
def test_rings_fill_the_gaps_of_planes(throw, rng):
    scene = faulted(throw, self_intersections=min(throw) < 0)  # its two rims may cross
    for name in ("Top", "Base"):
        found = scene.fault_polygons(name)
        assert_nothing_is_missing(scene, name, found, rng.uniform((0, 0), (60, 30), (200, 2)))
        profile = scene.throw(name, "F1")
        heave = np.trapezoid(profile.heave.values, profile.along_strike.values)
        assert float(found.map_area.sum()) == pytest.approx(heave, rel=1e-12)


@pytest.fixture(scope="module", params=["X", "Y"])
def crossing(request):
    """Two faults that move each other, or of which one ends at the other."""
    world = synthetic.torn(request.param, 25)
    sheet = tear_horizon(world.truth["points"], world.faults, name="Top", positive="up")
    faults = {fault.name: fault for fault in sheet.faults}
    box = (100.0, 500.0, 100.0, 500.0, -2070.0, -1530.0)
    return request.param, Scene({"Top": sheet}, faults, box)


def test_where_faults_meet_nothing_is_missing_and_nothing_is_there_twice(crossing, rng):
    kind, scene = crossing
    found = scene.fault_polygons("Top")
    assert set(found.fault.values) == {"F1", "F2"}
    assert set(found.kind.values) == {"gap"}
    # F1, which is younger, moves F2 aside; a fault that ends at another is whole
    parts = [int((found.fault == fault).sum()) for fault in ("F1", "F2")]
    assert parts == ([1, 2] if kind == "X" else [1, 1])
    places = rng.uniform((100, 100), (500, 500), (100, 2))
    middle = rng.uniform((250, 250), (350, 350), (100, 2))
    assert_nothing_is_missing(scene, "Top", found, [*places, *middle])
