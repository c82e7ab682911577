"""Fault polygons hold the throw of a horizon where its grid is smeared over the fault."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

import geosurf as gs

WIDE = (50, 950, 50, 950, -2200, -1400)


def ring_of(world, name="F1"):
    """The true polygon of a fault: the lower line, and the upper one back."""
    foot, hang = (np.asarray(world.truth["cutoffs"][name, wall]) for wall in "-+")
    return np.concatenate([hang, foot[::-1]])


def error_of(cut, world):
    """Mean error of the throw along a fault, as share of the largest one."""
    foot, hang = (np.asarray(world.truth["cutoffs"]["F1", wall]) for wall in "-+")
    n = min(len(foot), len(hang))
    throw, middle = foot[:n, 2] - hang[:n, 2], (foot[:n, :2] + hang[:n, :2]) / 2
    _, nearest = cKDTree(middle).query(cut.stations[:, :2])
    off = np.abs(cut.throw - throw[nearest])
    return np.nanmean(off) / np.abs(throw).max()


@pytest.mark.parametrize("kind", ["normal", "listric", "reverse"])
def test_a_polygon_holds_throw_that_the_grid_has_lost(kind):
    world = gs.synthetic.torn(kind, n=61, smear=4)
    plain = gs.tear_horizon(world.horizons["Top"], world.faults)
    fault = gs.fault_from_polygons({"Top": ring_of(world)}, name="F1", lengthen=300)
    sheet = gs.tear_horizon(world.horizons["Top"], [fault], name="Top")
    assert error_of(plain.cuts["F1"], world) > 0.04
    assert error_of(sheet.cuts["F1"], world) < 0.02


def test_neither_start_nor_direction_of_a_ring_matters():
    world = gs.synthetic.torn("normal", n=61, smear=4)
    ring = ring_of(world)
    throws = []
    for again in (ring, ring[::-1], np.roll(ring, 17, axis=0)):
        fault = gs.fault_from_polygons({"Top": again}, name="F1", lengthen=300)
        sheet = gs.tear_horizon(world.horizons["Top"], [fault], name="Top")
        throws.append(sheet.cuts["F1"].throw)
    for other in throws[1:]:
        np.testing.assert_allclose(other, throws[0], atol=1e-6)


def test_the_polygon_of_another_horizon_changes_nothing():
    world = gs.synthetic.torn("normal", n=61, smear=4)
    fault = gs.fault_from_polygons({"Base": ring_of(world)}, name="F1", lengthen=300)
    bare = gs.TriSurface("F1", "fault", fault.vertices, fault.triangles)
    one, two = (gs.tear_horizon(world.horizons["Top"], [f], name="Top") for f in (fault, bare))
    assert (one.surface.vertices == two.surface.vertices).all()


def test_scattered_points_meet_a_polygon():
    world = gs.synthetic.torn("normal", n=61)
    points = world.truth["scattered"](900, 0.0, 1)
    near = np.abs(points[:, 0] - 500) < 150  # what picks beside the fault would show is gone
    ring = ring_of(world)
    fault = gs.fault_from_polygons({"Top": ring}, name="F1", lengthen=300)
    sheet = gs.tear_horizon(points[~near], [fault], name="Top", positive="up", spacing=20)
    assert error_of(sheet.cuts["F1"], world) < 0.03


def test_a_scene_meets_polygons_at_faults_that_it_extends():
    world = gs.synthetic.torn("normal", n=61, smear=4)
    fault = gs.fault_from_polygons({"Top": ring_of(world)}, name="F1", lengthen=20)
    scene = gs.Scene(world.horizons, {"F1": fault}, WIDE, tear=True, extend={"F1": ["up", "down"]})
    assert error_of(scene.sheets["Top"].cuts["F1"], world) < 0.02
    other = gs.fault_from_polygons({"Base": ring_of(world)}, name="F1", lengthen=20)
    changed = scene.replace(faults={"F1": other})
    fresh = gs.Scene(world.horizons, {"F1": other}, WIDE, tear=True, extend={"F1": ["up", "down"]})
    with pytest.warns(gs.GeosurfWarning, match="on 'Base', and no horizon of that name"):
        sheets = [one.sheets["Top"] for one in (changed, fresh)]
    assert error_of(sheets[0].cuts["F1"], world) > 0.04
    assert (sheets[0].surface.vertices == sheets[1].surface.vertices).all()


@pytest.mark.filterwarnings("ignore::geosurf.GeosurfWarning")
def test_a_polygon_that_contradicts_its_horizon_is_left_out_by_name_or_named_by_the_audit():
    world = gs.synthetic.torn("normal", n=61, smear=2)
    ring = ring_of(world)
    ring[:, 2] = ring[:, 2].mean() + 5.0 * (ring[:, 2] - ring[:, 2].mean())
    fault = gs.fault_from_polygons({"Top": ring}, name="F1", lengthen=600)
    sheet = gs.tear_horizon(world.horizons["Top"], [fault], name="Top")
    assert {"polygon left out", "throw not as data"} & {one.kind for one in sheet.warnings}


def test_realisations_keep_the_throw_of_a_polygon():
    world = gs.synthetic.torn("normal", n=41, smear=4)
    fault = gs.fault_from_polygons({"Top": ring_of(world)}, name="F1", lengthen=300)
    scene = gs.Scene(world.horizons, {"F1": fault}, WIDE, tear=True)
    shift = gs.ensemble.DepthShift("Top", gs.ensemble.Uniform(-10.0, 10.0))
    for k in range(4):
        moved = gs.ensemble.realise(scene, k, uncertain=[shift])
        assert not np.array_equal(moved.surface("Top").vertices, scene.surface("Top").vertices)
        assert error_of(moved.sheets["Top"].cuts["F1"], world) < 0.03


def test_polygons_of_a_scene_in_time_count_in_depth():
    world = gs.synthetic.torn("normal", n=61, smear=4)
    fault = gs.fault_from_polygons({"Top": ring_of(world)}, name="F1", lengthen=200)
    top = world.horizons["Top"].assign_attrs(units="ms")
    words = {"time": "two-way", "tear": True, "velocity": 2000.0}
    scene = gs.Scene({"Top": top}, {"F1": fault}, **words)
    assert error_of(scene.sheets["Top"].cuts["F1"], world) < 0.02
