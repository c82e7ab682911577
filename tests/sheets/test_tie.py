"""Horizons tied to well tops: analytic corrections, one side of each fault, tolerance, refusals."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import GeometryError, GeosurfWarning, InputError
from geosurf.measure.columns import columns_through
from geosurf.model.tops import TieSettings, tie_settings, tops_of
from geosurf.sheets.tie import data_to_tie, tie_horizon
from geosurf.sheets.tie.controls import cut_horizon
from geosurf.sheets.tie.correction import map_distances
from geosurf.sheets.tie.tie_horizon import points_of_data
from geosurf.synthetic.torn_horizon import side_of
from tests.grids import gridded
from tests.measure.worlds import tops_at
from tests.messages import refused

REACH = 300.0


def plane(n=41, step=25.0):
    """A dipping plane as a grid."""
    axis = step * np.arange(n)
    x, y = np.meshgrid(axis, axis)
    return gridded(-1800.0 + 0.05 * x - 0.02 * y, axis).rename("Top")


def on_plane(x, y):
    """Elevation of that plane."""
    return -1800.0 + 0.05 * np.asarray(x) - 0.02 * np.asarray(y)


def wall(x, south, north, name="F1"):
    """A vertical fault that runs north."""
    corners = [[x, y, z] for y in (south, north) for z in (-2300.0, -1300.0)]
    return gs.TriSurface(name, "fault", corners, [[0, 2, 1], [1, 2, 3]])


def untorn(data, points, faults=(), **settings):
    """A grid that is tied without tearing."""
    data = data_to_tie(data, "Top")
    settings = TieSettings(**{"range": REACH, **settings})
    return tie_horizon("Top", data, lambda one: one, faults, tops_of(tops_at(points)), settings)


def tearing(world):
    """The faults of a world, and what tears its horizon by them."""
    faults = [gs.triangulate_fault(fault, name=name) for name, fault in world.faults.items()]
    return faults, lambda one: gs.tear_horizon(one, faults, name="Top")


def share(q):
    """Wendland's function, written differently: the correction over that at the well."""
    q = np.minimum(q, 1.0)
    return 1.0 - 10.0 * q**2 + 20.0 * q**3 - 15.0 * q**4 + 4.0 * q**5


def test_law_one_well_moves_a_plane_by_a_known_amount_and_nothing_beyond_the_range():
    data = data_to_tie(plane(), "Top")
    well = np.array([500.0, 475.0, on_plane(500.0, 475.0) + 12.0])  # at a node
    tied = untorn(plane(), well)
    before, after = data.vertices, tied.made.vertices
    far = np.hypot(*(before[:, :2] - well[:2]).T)
    np.testing.assert_allclose(after[:, 2] - before[:, 2], 12.0 * share(far / REACH), atol=1e-5)
    assert before[far >= REACH].tobytes() == after[far >= REACH].tobytes()
    assert tied.report.after < 1e-9
    assert tied.report.largest == pytest.approx(12.0)
    assert tied.report.moved == pytest.approx((far < REACH).mean())


def test_law_all_wells_are_met_wherever_they_are():
    place = np.random.default_rng(4).uniform(20.0, 980.0, (14, 2))
    added = 0.02 * place[:, 0] - 9.0  # smooth: no two contradict each other
    tops = np.column_stack([place, on_plane(*place.T) + added])
    scene = gs.Scene({"Top": plane()}, tops=tops_at(tops), tie={"range": REACH})
    np.testing.assert_allclose(scene.misfit().misfit, 0.0, atol=1e-8)
    assert scene.ties["Top"].before == pytest.approx(np.abs(added).max())
    again = gs.Scene({"Top": plane()}, tops=tops_at(tops), tie={"range": REACH})
    one, two = (one.surface("Top").vertices.tobytes() for one in (scene, again))
    assert one == two


def test_law_distance_around_the_tips_of_a_fault():
    """Behind a straight wall the shortest way bends at one of its tips."""
    tips = np.array([[512.0, 300.0], [512.0, 700.0]])
    cut = cut_horizon(data_to_tie(plane(), "Top"), [wall(512.0, 300.0, 700.0)])
    corners = cut.x[cut.triangles]
    source = np.array([431.0, 533.0])
    start = int(np.hypot(*(corners[:, :, :2].mean(axis=1) - source).T).argmin())
    source = corners[start, :, :2].mean(axis=0)
    vertices, found = map_distances(cut.x, cut.triangles, cut.walls, start, source, 700.0)
    x = cut.x[vertices, :2]
    straight = np.hypot(*(x - source).T)
    around = np.min([np.hypot(*(tip - source)) + np.hypot(*(x - tip).T) for tip in tips], axis=0)
    at_wall = source[1] + (x[:, 1] - source[1]) * (512.0 - source[0]) / (x[:, 0] - source[0])
    hidden = (x[:, 0] > 512.0) & (at_wall > 300.0) & (at_wall < 700.0)
    on_wall = x[:, 0] == 512.0
    expected = np.where(hidden, around, straight)
    off = np.abs(found - expected)
    assert hidden.sum() > 200
    np.testing.assert_allclose(off[x[:, 0] < 512.0], 0.0, atol=1e-5)
    assert (off <= 0.04 * expected)[~on_wall].all()  # behind a tip the image is approximate
    assert off[~on_wall].mean() < 2.5  # a tenth of a cell


@pytest.mark.parametrize("form", ["grid", "points", "untorn"])
def test_law_a_well_moves_its_own_side_of_a_fault_only(form):
    world = gs.synthetic.torn("through", n=41, smear=1 if form == "grid" else 0)
    faults, make = tearing(world)
    east = np.array([620.0, 510.0, 0.0])
    if form == "untorn":
        raw, make = data_to_tie(plane(), "Top"), lambda one: one
    else:
        given = world.horizons["Top"] if form == "grid" else world.truth["points"]
        raw = data_to_tie(given, "Top", positive="up", length_unit="m")
    cut = cut_horizon(make(raw), faults)
    height = columns_through(cut.patches, east[None], cut.rows).elevation[0]
    tops = tops_of(tops_at([[*east[:2], height + 9.0]]))
    tied = tie_horizon("Top", raw, make, faults, tops, TieSettings(REACH, 0.01))
    before, after = (points_of_data(one) for one in (raw, tied.data))
    moved = before[:, 2] != after[:, 2]
    side = side_of(world.truth["faults"]["F1"], *before.T)
    far = np.hypot(*(before[:, :2] - east[:2]).T)
    clear = np.abs(across(world, before)) > 40.0  # at least the cell that the fault cuts
    assert tied.report.after <= 0.01
    assert not moved[clear & (side < 0)].any()
    assert moved[clear & (side > 0) & (far < 0.9 * REACH)].all()
    assert (far[~moved | (far >= REACH)].min()) > 0


def across(world, points):
    """Distance of points from the fault across its strike [m]."""
    fault = world.truth["faults"]["F1"]
    along, far = fault.along_across(points[:, 0], points[:, 1])
    return far - fault.across(along, points[:, 2])


@pytest.mark.parametrize("kind", ["reverse", "Y"])
def test_torn_horizons_meet_their_tops_and_still_end_on_their_faults(kind):
    world = gs.synthetic.torn(kind, n=41, smear=0)
    faults, make = tearing(world)
    rng = np.random.default_rng(8)
    points = world.truth["points"]
    inner = points[(points[:, :2] > 60).all(axis=1) & (points[:, :2] < 940).all(axis=1)]
    wells = inner[rng.permutation(len(inner))[:6]] + [3.0, 4.0, 0.0]
    wells[:, 2] += 0.012 * wells[:, 0] - 6.0
    data = data_to_tie(points, "Top", positive="up")
    tied = tie_horizon("Top", data, make, faults, tops_of(tops_at(wells)), TieSettings(400.0, 0.05))
    assert tied.report.after <= 0.05 < 1.0 < tied.report.before
    assert len(tied.report.wells) + len(tied.report.unused) == 6
    assert any("tied to well tops" in note for note in tied.made.report.notes)
    surfaces = {fault.name: fault for fault in faults}
    scene = gs.Scene({"Top": tied.made}, surfaces, world.box, tops=tops_at(wells), tie=True)
    assert scene.check().ok
    assert np.nanmax(np.abs(scene.misfit().misfit.values)) <= 0.05


def test_tops_that_contradict_each_other_are_refused_by_name():
    place = np.array([[500.0, 500.0], [560.0, 500.0]])
    tops = np.column_stack([place, on_plane(*place.T) + np.array([20.0, -25.0])])
    with pytest.raises(GeometryError, match=r"wells 'W0' and 'W1' are 60 m apart.*20 m and -25 m"):
        untorn(plane(), tops)
    between = wall(530.0, -100.0, 1100.0)
    tied = untorn(plane(), tops, [between])  # a fault between them: both are right
    assert tied.report.after <= 0.1


def test_tops_in_one_cell_act_as_one_within_the_tolerance():
    place = np.array([[500.0, 500.0], [508.0, 503.0]])
    height = on_plane(*place.T)
    tied = untorn(plane(), np.column_stack([place, height + np.array([5.0, 5.1])]), tolerance=0.1)
    assert tied.report.after <= 0.1
    with pytest.raises(GeometryError, match=r"'W0' and 'W1' are 8.54 m apart"):
        untorn(plane(), np.column_stack([place, height + np.array([5.0, 5.4])]), tolerance=0.1)


def test_tops_that_are_not_used_are_listed_with_their_reason():
    world = gs.synthetic.torn("through", n=41, smear=0)
    faults, make = tearing(world)
    foot, hang = (world.truth["cutoffs"]["F1", wall] for wall in "-+")
    gap = 0.5 * (foot + hang)[len(foot) // 2]
    beyond = hang[len(hang) // 2] + [15.0, 0.0, -120.0]
    outside = [5000.0, 5000.0, -1800.0]
    data = data_to_tie(world.truth["points"], "Top", positive="up")
    tops = tops_of(tops_at([gap, beyond, outside]))
    with pytest.warns(GeosurfWarning, match="The tie does not use 3 of 3 well tops") as found:
        tied = tie_horizon("Top", data, make, faults, tops, TieSettings(REACH))
    assert tied.report.wells == ()
    assert [word.partition("' ")[2].partition("' ")[2] for word in tied.report.unused] == [
        "lies in the gap of fault 'F1'",
        "lies on the other side of fault 'F1' than the horizon there",
        "lies outside the data of the horizon",
    ]
    assert found[0].message.kind == "tops"


def test_the_default_range_is_stated_with_its_effect():
    with pytest.warns(GeosurfWarning, match="moved .* by up to 7 m: those within 1 km of a well"):
        tied = tie_horizon(
            "Top", data_to_tie(plane(), "Top"), lambda one: one, [],
            tops_of(tops_at([500.0, 500.0, on_plane(500.0, 500.0) + 7.0])), tie_settings(True),
        )  # fmt: skip
    assert tied.report.settings.range == 1000.0


def test_a_tie_needs_tops_and_data():
    refused(InputError, "tie needs well tops", lambda: gs.Scene({"Top": plane()}, tie=True))
    world = gs.synthetic.torn("through", n=41)
    (fault,), make = tearing(world)
    sheet = make(world.horizons["Top"])
    top = sheet.lattice.places_of_nodes(np.array([41 * 20 + 5]))[0] + [0.0, 0.0, 6.0]
    scene = gs.Scene({"Top": sheet}, {"F1": fault}, tops=tops_at(top), tie=True)
    refused(InputError, r"torn before.*misses them by up to 6 m", scene.surface, "Top")
