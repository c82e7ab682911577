"""Fault polygons hold the throw of a horizon where its grid is smeared over the fault."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

import geosurf as gs
from geosurf.ensemble import DepthError, realise
from geosurf.ensemble.record import Record
from geosurf.ensemble.run import planned
from geosurf.sheets.tear import tear_from

WIDE = (50, 950, 50, 950, -2200, -1400)


def ring_of(world, name="F1"):
    """The true polygon of a fault: the lower line, and the upper one back."""
    foot, hang = (np.asarray(world.truth["cutoffs"][name, wall]) for wall in "-+")
    return np.concatenate([hang[::2], foot[::-2]])


def error_of(cut, world):
    """Mean error of the throw along a fault, as share of the largest one."""
    foot, hang = (np.asarray(world.truth["cutoffs"]["F1", wall]) for wall in "-+")
    n = min(len(foot), len(hang))
    throw, middle = foot[:n, 2] - hang[:n, 2], (foot[:n, :2] + hang[:n, :2]) / 2
    _, nearest = cKDTree(middle).query(cut.stations[:, :2])
    off = np.abs(cut.throw - throw[nearest])
    return np.nanmean(off) / np.abs(throw).max()


@pytest.mark.parametrize("kind", ["listric", "reverse"])
def test_a_polygon_holds_throw_that_the_grid_has_lost(kind):
    world = gs.synthetic.torn(kind, n=61, smear=4)
    plain = gs.tear_horizon(world.horizons["Top"], world.faults)
    fault = gs.fault_from_polygons({"Top": ring_of(world)}, name="F1", lengthen=300)
    sheet = gs.tear_horizon(world.horizons["Top"], [fault], name="Top")
    assert error_of(plain.cuts["F1"], world) > 0.04
    assert error_of(sheet.cuts["F1"], world) < 0.02


def test_neither_start_nor_direction_of_a_ring_matters():
    world = gs.synthetic.torn("normal", n=41, smear=4)
    ring = ring_of(world)
    throws = []
    for again in (ring, np.roll(ring[::-1], 17, axis=0)):
        fault = gs.fault_from_polygons({"Top": again}, name="F1", lengthen=300)
        sheet = gs.tear_horizon(world.horizons["Top"], [fault], name="Top")
        throws.append(sheet.cuts["F1"].throw)
    np.testing.assert_allclose(*throws, atol=1e-6)


def test_the_polygon_of_another_horizon_changes_nothing():
    world = gs.synthetic.torn("normal", n=41, smear=4)
    fault = gs.fault_from_polygons({"Base": ring_of(world)}, name="F1", lengthen=300)
    bare = gs.TriSurface("F1", "fault", fault.vertices, fault.triangles)
    one, two = (gs.tear_horizon(world.horizons["Top"], [f], name="Top") for f in (fault, bare))
    assert (one.surface.vertices == two.surface.vertices).all()


def test_scattered_points_meet_a_polygon():
    world = gs.synthetic.torn("normal", n=61)
    points = world.truth["scattered"](900, 0.0, 1)
    near = np.abs(points[:, 0] - 500) < 150  # what picks beside the fault would show is gone
    fault = gs.fault_from_polygons({"Top": ring_of(world)}, name="F1", lengthen=300)
    sheet = gs.tear_horizon(points[~near], [fault], name="Top", positive="up", spacing=20)
    assert error_of(sheet.cuts["F1"], world) < 0.03


def test_a_scene_meets_polygons_at_faults_that_it_extends():
    world = gs.synthetic.torn("normal", n=41, smear=4)
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
    for k in range(2):
        moved = gs.ensemble.realise(scene, k, uncertain=[shift])
        assert not np.array_equal(moved.surface("Top").vertices, scene.surface("Top").vertices)
        assert error_of(moved.sheets["Top"].cuts["F1"], world) < 0.03


def test_polygons_of_a_scene_in_time_count_in_depth():
    world = gs.synthetic.torn("normal", n=41, smear=4)
    fault = gs.fault_from_polygons({"Top": ring_of(world)}, name="F1", lengthen=200)
    top = world.horizons["Top"].assign_attrs(units="ms")
    words = {"time": "two-way", "tear": True, "velocity": 2000.0}
    scene = gs.Scene({"Top": top}, {"F1": fault}, **words)
    assert error_of(scene.sheets["Top"].cuts["F1"], world) < 0.02


# ---- A plan is where a tear starts: it closes the same data alike, and data that moved a little.
@pytest.fixture(scope="module")
def world():
    return gs.synthetic.torn("normal", n=41)


@pytest.fixture(scope="module")
def base(world):
    return gs.tear_horizon(world.horizons["Top"], world.faults)


def vertices(sheet):
    return sheet.surface.vertices


def left_of(sheet, world):
    """Elevations of what faults leave of a sheet in a model, by place."""
    z = world.horizons["Top"]
    sides = (z.easting.min(), z.easting.max(), z.northing.min(), z.northing.max())
    box = (*map(float, sides), float(z.min()) - 300.0, float(z.max()) + 300.0)
    top = gs.Scene({"Top": sheet}, world.faults, box=box).patches.surface("Top")
    return {(x, y): z for x, y, z in np.round(top.vertices, 6).tolist()}


def differences(one, other, world):
    """How far apart two sheets are at the nodes that both have in a model [m]."""
    here, there = left_of(one, world), left_of(other, world)
    both = here.keys() & there.keys()
    assert len(both) > 0.85 * len(here)  # all others are on traces
    return np.array([abs(here[place] - there[place]) for place in both])


def bend(grid, size):
    """A smooth error of some metres, whose slope is a few per cent at most."""
    x, y = np.meshgrid(np.linspace(0, 3, grid.shape[1]), np.linspace(0, 2, grid.shape[0]))
    return grid + size * np.sin(x) * np.cos(y)


def test_a_plan_closes_its_own_data_alike(world, base):
    again = tear_from(base.plan, world.horizons["Top"], world.faults)
    assert base.plan.searched
    assert not again.plan.searched
    # throw dies at the last link of each tip, where the tear of these data goes on by a part of it
    far = np.abs(again.lattice.elevation - base.lattice.elevation)
    assert np.nanmax(far) < 2.0  # of 56 m
    assert np.count_nonzero(far > 0.05) < 0.05 * far.size


def test_moved_data_are_torn_almost_as_without_a_plan(world, base):
    data = bend(world.horizons["Top"], 8.0)
    one = tear_from(base.plan, data, world.faults)
    other = gs.tear_horizon(data, world.faults)
    assert not one.plan.searched
    # data near the fault may count in one and not in the other
    far = differences(one, other, world)
    assert far.max() < 1.5  # of 56 m of throw
    assert np.mean(far > 0.0) < 0.1


@pytest.mark.parametrize("metres", [100.0, -400.0])
def test_wrong_heights_of_the_base_case_are_caught(world, base, metres):
    """Traces are some cells off then, or off the data."""
    wrong = replace(base.plan.base, off_data=base.plan.base.off_data + metres)
    sheet = tear_from(replace(base.plan, base=wrong), world.horizons["Top"], world.faults)
    far = np.abs(sheet.lattice.elevation - base.lattice.elevation)
    assert np.nanmax(far) < 3.0
    throws = [np.nanmax(one.cuts["F1"].throw) for one in (sheet, base)]
    assert throws[0] == pytest.approx(throws[1], abs=0.5)


@pytest.mark.parametrize("other", [{"traces": ()}, {"shape": (3, 3)}, {"trims": (2.0, 2.0)}])
def test_a_plan_of_something_else_leads_to_the_search(world, base, other):
    sheet = tear_from(replace(base.plan, **other), world.horizons["Top"], world.faults)
    assert sheet.plan.searched
    np.testing.assert_allclose(vertices(sheet), vertices(base), atol=0.05)


def test_realisations_count_what_was_torn_and_searched_for(world):
    scene = gs.Scene({"Top": world.horizons["Top"]}, world.faults, tear=True)
    error = DepthError("Top", sd=4.0, range=1500.0)
    plan, _ = planned(scene, 2, [error], 0, None)
    plan.start()
    record = Record.from_bytes(plan.run(1).to_bytes())
    assert (record.reason, record.n_torn, record.n_searched) == ("", 1, 0)
    one = realise(scene, 1, uncertain=[error])
    assert not one.sheets["Top"].plan.searched
    total = sum(unit.volume for unit in one.units.values())
    assert total == pytest.approx(sum(bulk for (bulk,) in record.amounts.values()), rel=1e-12)
