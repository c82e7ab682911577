"""Torn sheets as horizons of a model: units close, and the certificate holds."""

from __future__ import annotations

from functools import cache

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import GeometryError, HorizonError, InputError
from geosurf.sheets.mesh import build
from tests.messages import refused


@cache
def pair(kind: str):
    """Two sheets on the faults of a world, and a scene of them."""
    sheets = {}
    for name, level in (("Top", 0.0), ("Base", -120.0)):
        world = gs.synthetic.torn(kind, 41, level=level)
        points = world.truth["points"]
        sheets[name] = gs.tear_horizon(points, world.faults, name=name, positive="up")
    faults = {fault.name: fault for fault in sheets["Top"].faults}
    return sheets, gs.Scene(sheets, faults, (100.0, 900.0, 100.0, 900.0, -2070.0, -1530.0))


@pytest.mark.parametrize(("kind", "n_unit"), [("normal", 3), ("through", 6), ("reverse", 3)])
def test_units_of_torn_sheets_are_closed_and_certified(kind, n_unit):
    _, scene = pair(kind)
    assert len(scene.units) == n_unit
    assert scene.check().ok


def test_a_torn_sheet_has_no_curves_with_itself():
    _, scene = pair("normal")
    words = r"horizon 'Top' is torn, so .* Name a fault"
    refused(gs.errors.InputError, words, scene.curves_between, "Top", "Top")


def test_volume_between_torn_sheets_is_that_of_the_truth():
    """Both sheets are torn alike, 120 m apart, so their zone is 120 m thick but for the gap."""
    _, scene = pair("normal")
    area = 800.0 * 800.0
    assert scene.units["Top/Base"].volume == pytest.approx(120.0 * area, rel=0.04)


def test_cutoffs_of_a_scene_end_where_the_sheet_ends():
    """Both walls inside the box, nothing of what was carried on past the fault."""
    sheets, scene = pair("through")
    lines = scene.cutoffs("Top", "F1")
    assert len(lines) == 2
    found = np.concatenate(lines)
    cuts = np.concatenate([line for w in "+-" for line in sheets["Top"].cuts["F1"].cutoffs[w]])
    inside = cuts[(abs(cuts[:, :2] - 500.0) < 399.0).all(axis=1)]
    near = np.abs(found[None] - inside[:, None]).max(axis=2).min(axis=1)
    assert near.max() < 1e-7  # the model may have moved inputs by that much
    own = set(map(tuple, scene.patches.surface("Top").vertices.tolist()))
    assert own >= set(map(tuple, found.tolist()))


def test_a_sheet_needs_the_faults_that_tear_it():
    sheets, _ = pair("normal")
    scene = gs.Scene({"Top": sheets["Top"]}, {}, (100.0, 900.0, 100.0, 900.0, -2070.0, -1530.0))
    with pytest.raises(gs.errors.InputError, match=r"'Top' is torn at fault 'F1', which is not in"):
        scene.surface("Top")
    moved = gs.TriSurface(
        "F1", "fault", sheets["Top"].faults[0].vertices + 1.0, sheets["Top"].faults[0].triangles
    )
    with pytest.raises(gs.errors.InputError, match=r"'F1', which is another surface.*sheet.faults"):
        gs.Scene({"Top": sheets["Top"]}, {"F1": moved}).surface("Top")


def test_what_is_dropped_is_accounted_for():
    _, scene = pair("normal")
    report = scene.patches.report["dropped_area"]
    assert set(report) == {0, 1}
    for row, area in report.items():
        source = scene.patches.sources[row]
        corners = source.vertices[source.triangles]
        whole = 0.5 * np.linalg.norm(
            np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
        )
        assert 0 < area < 0.2 * whole.sum()


@pytest.mark.parametrize("kind", ["normal", "gentle", "listric"])
def test_throws_of_a_sheet_are_those_of_a_scene(torn_world, kind):
    """Read across at stations, and down the dip in the model: what docs/guides/measures.md says."""
    _, sheet = torn_world(kind, n=61)
    x, y = sheet.lattice.easting, sheet.lattice.northing
    inside = (x.min() + 40.0, x.max() - 40.0, y.min() + 40.0, y.max() - 40.0, -2600.0, -1000.0)
    scene = gs.Scene({"Top": sheet}, {fault.name: fault for fault in sheet.faults}, inside)
    found = scene.throw("Top", "F1").dropna("point", subset=["throw"])
    along = found.along_strike.values
    places = np.column_stack([found.easting, found.northing, np.ones(len(along))])
    middle = places.mean(axis=0) * [1.0, 1.0, 0.0]
    strike = np.linalg.lstsq(places - middle, along, rcond=None)[0]
    cut = sheet.cuts["F1"]
    at = (np.column_stack([cut.stations[:, :2], np.ones(len(cut.along))]) - middle) @ strike
    order = np.argsort(along, kind="stable")
    throw = np.interp(at, along[order], found.throw.values[order], left=np.nan, right=np.nan)
    off = np.abs(throw - cut.throw)
    assert np.isfinite(off).sum() > 0.9 * len(off)
    assert np.nanmean(off) < 0.03
    assert np.nanmax(off) < 0.3


# ---- Messages of the sheets say what is wrong, where, what next; reference systems stay apart.
@pytest.fixture(scope="module")
def world():
    return gs.synthetic.torn("through", n=31)


def test_faults_need_names_of_their_own(world):
    fault, top = gs.triangulate_fault(world.faults["F1"], name="F1"), world.horizons["Top"]
    refused(InputError, r"2 faults are called 'F1'; rename", gs.tear_horizon, top, [fault, fault])
    refused(InputError, r"faults is a TriSurface; give a mapping", gs.tear_horizon, top, fault)


def test_data_that_cannot_be_torn(world):
    mesh = gs.TriSurface("Top", "horizon", [[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]])
    words = r"'Top' is a mesh without a lattice.*Give the grid"
    refused(HorizonError, words, gs.tear_horizon, mesh, world.faults)
    points, scattered = world.truth["points"].copy(), world.truth["points"].copy()
    points[7, 2] = np.nan
    scattered[5, 0] += 9.0
    for data, words in (
        (points, r"1 points are not finite, the first is point 7"),
        (scattered, r"1 of \d+ points lie off the lattice.*0\.36 cells off"),
        (np.arange(4.0), r"points have shape \(4,\), expected numbers \(n, 3\)"),
        ((np.zeros((4, 3)), np.zeros((2, 3), int)), "arrays of several shapes"),
    ):
        refused(HorizonError, words, gs.tear_horizon, data, world.faults, positive="up")


def test_points_that_do_not_declare_elevation_or_depth_are_refused(world):
    """Two horizons at 2000 and 2100 m of depth were elevations, the younger one below."""
    points = world.truth["points"]
    names = ["easting", "northing", "elevation"]
    table = pd.DataFrame(points, columns=names)
    dataset = xr.Dataset(
        {name: ("point", column) for name, column in zip(names, points.T, strict=True)}
    )
    for data in (points, points.tolist(), table, dataset):
        for call in (gs.tear_horizon, gs.propose_trim):
            with pytest.raises(HorizonError, match=r"depth or elevation.* positive='down'.*'up'"):
                call(data, world.faults)
    depths = dataset.assign(elevation=-dataset["elevation"])
    depths["elevation"].attrs["positive"] = "down"
    found = gs.tear_horizon(depths, {}, name="Top")
    again = gs.tear_horizon(points, {}, name="Top", positive="up")
    np.testing.assert_array_equal(found.lattice.elevation, again.lattice.elevation)
    with pytest.raises(HorizonError, match=r"is 'down', the argument positive is 'up'. Leave"):
        gs.tear_horizon(depths, {}, positive="up")


def test_uneven_steps_are_refused(world):
    top = world.horizons["Top"]
    east = top["easting"].values.copy()
    east[10:] += 10.0
    with pytest.raises(HorizonError, match=r"even steps at right angles.*Resample it"):
        gs.tear_horizon(top.assign_coords(easting=east), world.faults)


def test_a_block_without_data_is_refused_by_name():
    world = gs.synthetic.torn("parallel", n=41, smear=0)
    top, turn = world.horizons["Top"], np.radians(12.0)
    across = (top["easting"] - 500.0) * np.cos(turn) - (top["northing"] - 500.0) * np.sin(turn)
    top = top.where(abs(across) > 60.0)  # nothing between the two faults
    words = r"block next to faults 'F1', 'F2' has no data.*fill_empty_blocks=True"
    refused(GeometryError, words, gs.tear_horizon, top, world.faults, trim=1.0)


def test_an_overlap_that_scattered_points_cannot_close_is_told_with_its_width(monkeypatch):
    monkeypatch.setattr(build, "ROUNDS", 1)  # it stays so, however many rings it gets
    world = gs.synthetic.torn("thrust", n=61)
    points = world.truth["scattered"](6000)
    with pytest.raises(
        GeometryError, match=r"cut at fault 'F1'.* 6\.9 cells, .* or a larger spacing\."
    ):
        gs.tear_horizon(points, world.faults, name="Top", trim=0.5, spacing=25.0, positive="up")


# ---- A torn horizon stays in the reference system of its data, and no other is mixed in.
UTM31, UTM32 = "EPSG:32631", "EPSG:32632"


def torn(horizon, faults):
    return gs.tear_horizon(horizon, faults, name="Top")


def thrown(horizon, faults):
    return gs.throw_horizon(horizon, faults, {"F1": 10.0}, name="Top")


def no_throw(horizon, faults):
    return gs.throw_horizon(horizon, faults, {}, name="Top")


@pytest.mark.parametrize("make", [torn, thrown, no_throw])
def test_a_sheet_is_in_the_reference_system_of_its_data(world, make):
    top = world.horizons["Top"]
    assert make(top, world.faults).crs is None
    said = top.assign_attrs(crs=UTM31)
    for horizon in (said, gs.triangulate_horizon(said)):
        sheet = make(horizon, world.faults)
        assert sheet.crs == sheet.surface.crs == UTM31
    assert np.array_equal(sheet.surface.vertices, make(top, world.faults).surface.vertices)


@pytest.mark.parametrize("make", [torn, thrown])
def test_faults_in_another_reference_system_are_refused(world, make):
    top = world.horizons["Top"].assign_attrs(crs=UTM31)
    (fault,) = world.faults.values()
    assert make(top, {"F1": fault.assign_attrs(crs=UTM31.lower())}).crs == UTM31
    words = r"'F1' is in EPSG:32632, but 'Top' is in EPSG:326"
    refused(gs.errors.InputError, words, lambda: make(top, {"F1": fault.assign_attrs(crs=UTM32)}))
