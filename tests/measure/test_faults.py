"""Juxtaposition, Allan diagrams, cut-offs by wall, fault polygons, throw: known by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geosurf import (
    FluidContact,
    Scene,
    TriSurface,
    build_walls,
    carve_units,
    rebuild_surfaces,
    synthetic,
    tear_horizon,
)
from geosurf.measure import allan_diagram, faces_of, juxtaposition_table, separation
from geosurf.measure.cutoffs import wall_lines
from tests.grids import lines_of, ring_area
from tests.measure.worlds import BOX, NORTH, SOUTH, faulted, level, slope

ROOT2 = math.sqrt(2.0)


def diagram_lines(found):
    """Lines of an Allan diagram, distance along strike and elevation (n, 2) of each."""
    return lines_of(found, "along_strike", "elevation")


def turned_over(fault, name="F1"):
    return TriSurface(name, "fault", fault.vertices, fault.triangles[:, [0, 2, 1]])


# ---- juxtaposition -------------------------------------------------------------------


def test_areas_of_juxtaposed_zones_by_hand():
    found = faulted().juxtaposition("F1", "all")
    table = {
        (a, b): area
        for a, b, area in zip(found.zone_plus.values, found.zone_minus.values, found.area.values,
                              strict=True)
    }  # fmt: skip
    heights = {
        ("above Top", "above Top"): 10, ("above Top", "Top/Base"): 4, ("Top/Base", "Top/Base"): 6,
        ("Top/Base", "below Base"): 4, ("below Base", "below Base"): 16,
    }  # fmt: skip
    assert set(table) == set(heights)
    for pair, height in heights.items():
        assert table[pair] == pytest.approx(height * 30 * ROOT2, rel=1e-13)
    kinds = dict(zip(zip(found.zone_plus.values, found.zone_minus.values, strict=True),
                     found.kind.values, strict=True))  # fmt: skip
    assert kinds["above Top", "Top/Base"] == "juxtaposed"
    assert kinds["Top/Base", "Top/Base"] == "self-juxtaposed"
    assert found.area.attrs["units"] == "m2"
    assert found.attrs["area"] == pytest.approx(40 * 30 * ROOT2, rel=1e-13)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("order", [1, -1])
def test_the_hanging_wall_of_each_of_two_faults_that_coincide_in_part(turned, order):
    """F1 in the south and F2 in the north, ten metres of them one; Top is at -10 and at -14."""
    faults = [slope("F1", SOUTH, 20), slope("F2", 10, NORTH)]
    if turned:
        faults[1] = turned_over(faults[1], "F2")
    horizons = [s for s in faulted().surfaces if s.role == "horizon"]
    patches = rebuild_surfaces([*horizons, *faults[::order], *build_walls(BOX)])
    units = carve_units(patches)
    for name, way in (("F1", 1), ("F2", -1 if turned else 1)):
        for side, z in zip((0, 1)[::way], (-14.0, -10.0), strict=True):
            (line,) = wall_lines(patches, units, "Top", name, side)
            assert set(line[:, 2]) == {z}
            assert np.ptp(line[:, 1]) == 20.0
        table = juxtaposition_table(patches, units, name).to_dataframe()
        area = {
            (r.zone_plus, r.zone_minus)[::way]: r.area
            for r in table.itertuples()
            if "Top/Base" in (r.zone_plus, r.zone_minus)
        }
        expected = {("above Top", "Top/Base"): 4, ("Top/Base", "Top/Base"): 6,
                    ("Top/Base", "below Base"): 4}  # fmt: skip
        assert area == pytest.approx({k: h * 20 * ROOT2 for k, h in expected.items()}, rel=1e-13)
        for side in ("plus", "minus"):
            sign = {"plus": "+", "minus": "-"}[side]
            assert all(f"{name}{sign}" in block for block in table[f"block_{side}"])
        found = allan_diagram(patches, units, name)
        for label, side in zip(found.label.values, found.side.values, strict=True):
            assert label not in units or f"{name}{side}" in units[label].fault_sides


# ---- Allan diagram -------------------------------------------------------------------


def test_rings_of_the_allan_diagram_hold_the_areas():
    """45 degrees: heights on the diagram are lengths on the fault over root 2."""
    scene = faulted((1.0, 6.0))
    found, table = scene.allan("F1"), scene.juxtaposition("F1", "all")
    rings = np.array([ring_area(line) for line in diagram_lines(found)])
    kind, side = found.kind.values, found.side.values
    for sign in "+-":
        mine = (kind == "zone") & (side == sign)
        assert mine.sum() == 3
        assert (rings[mine] > 0).all()
        assert rings[mine].sum() == pytest.approx(40 * 30, rel=1e-13)
    mine = kind == "juxtaposition"
    by_pair = dict(zip(found.label.values[mine], rings[mine], strict=True))
    for a, b, area in zip(table.unit_plus.values, table.unit_minus.values, table.area.values,
                          strict=True):  # fmt: skip
        assert by_pair[f"{a} | {b}"] * ROOT2 == pytest.approx(area, rel=1e-12)
    assert found.attrs["strike"] == pytest.approx(0.0, abs=1e-12)
    s = found.along_strike.values
    assert s.min() == 0.0
    assert s.max() == pytest.approx(30.0)


def test_cutoffs_of_the_allan_diagram_lie_where_they_should():
    found = faulted().allan("F1")
    lines, seen = diagram_lines(found), {}
    for i in np.flatnonzero(found.kind.values == "cut-off"):
        seen[found.label.values[i], found.side.values[i]] = np.unique(lines[i][:, 1]).tolist()
    assert seen == {
        ("Top", "-"): [-10.0],
        ("Top", "+"): [-14.0],
        ("Base", "-"): [-20.0],
        ("Base", "+"): [-24.0],
    }


def test_each_wall_of_the_allan_diagram_has_its_own_contacts():
    """Two contacts in the hanging wall, another level in the footwall; one zone left out."""
    contacts = {
        "GOC": FluidContact(-17.0, zones="Top/Base", block="F1+"),
        "OWC": [
            FluidContact(-19.0, zones="Top/Base", block="F1+"),
            FluidContact(-15.0, zones="Top/Base", block="F1-"),
        ],
    }
    found = faulted().replace(contacts=contacts).allan("F1")
    assert found.attrs == faulted().allan("F1").attrs
    lines, seen = diagram_lines(found), {}
    for i in np.flatnonzero(found.kind.values == "contact"):
        s, z = lines[i].T
        assert (s.min(), s.max(), found.closed.values[i]) == (0.0, 30.0, 0)
        seen[found.label.values[i], found.side.values[i]] = np.unique(z).tolist()
    assert seen == {("GOC", "+"): [-17.0], ("OWC", "+"): [-19.0], ("OWC", "-"): [-15.0]}
    zones = ["above Top", "Top/Base", "below Base"]  # the level is above Top on one wall
    through = faulted().replace(contacts={"OWC": -12.0}, reservoir=zones).allan("F1")
    lines = [(s, z) for s, z in zip(through.side.values, through.kind.values, strict=True)]
    assert [s for s, kind in lines if kind == "contact"] == ["+", "-"]
    assert "contact" not in faulted().allan("F1").kind.values


def test_a_contact_of_one_block_ends_where_another_fault_meets_the_wall():
    """The line of the other fault on this wall parts blocks with other contacts: it is none."""
    corners = [(0.0, 15.0, -60.0), (70.0, 15.0, -60.0), (70.0, 15.0, 20.0), (0.0, 15.0, 20.0)]
    across = TriSurface("F2", "fault", corners, [(0, 1, 2), (0, 2, 3)])
    horizons = {name: level(name, z) for name, z in (("Top", -10.0), ("Base", -20.0))}
    faults = {"F1": slope(), "F2": across}
    scene = Scene(horizons, faults, BOX, contacts={"OWC": {"F1+ F2+": -15.0}})
    found = scene.allan("F1")
    levels = [diagram_lines(found)[i][:, 1] for i in np.flatnonzero(found.kind == "contact")]
    assert len(levels) == 1
    assert len(levels[0]) >= 2
    np.testing.assert_allclose(levels[0], -15.0)


# ---- cut-offs and polygons -----------------------------------------------------------


def test_each_wall_has_its_own_cutoff():
    scene = faulted((1.0, 6.0))
    (up,), (down,) = (scene.cutoffs("Top", "F1", side) for side in ("footwall", "hanging wall"))
    assert set(up[:, 2]) == {-10.0}
    assert set(up[:, 0]) == {20.0}
    throw = 1.0 + 5.0 * (down[:, 1] - SOUTH) / (NORTH - SOUTH)
    np.testing.assert_allclose(down[:, 2], -10 - throw, atol=1e-13)
    np.testing.assert_allclose(down[:, 0] + down[:, 2], 10.0, atol=1e-13)
    assert {0.0, 30.0} <= set(down[:, 1])
    np.testing.assert_array_equal(scene.cutoffs("Top", "F1", "+")[0], down)


@pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")  # of the order
def test_what_is_clipped_away_has_no_cutoff():
    low = level("Low", -5.0)  # older than Top, but above it: clipped everywhere but at the sides
    scene = Scene({"Top": level("Top", -10.0), "Low": low}, {"F1": slope()}, BOX)
    assert len(scene.cutoffs("Low", "F1")) == 1
    assert scene.cutoffs("Low", "F1", "+") == []
    assert len(scene.cutoffs("Top", "F1", "+")) == 1


# ---- throw ---------------------------------------------------------------------------


@pytest.mark.parametrize(("south", "north"), [(1.0, 6.0), (-3.0, -3.0)])
def test_throw_along_a_fault_is_the_throw_put_in(south, north):
    found = faulted((south, north)).throw("Base", "F1")
    y = found.northing.values
    expected = south + (north - south) * (y - SOUTH) / (NORTH - SOUTH)
    np.testing.assert_allclose(found.throw, expected, atol=1e-12)
    np.testing.assert_allclose(found.heave, expected, atol=1e-12)
    np.testing.assert_allclose(found.dip_separation, expected * ROOT2, atol=1e-12)
    np.testing.assert_allclose(found.apparent_dip, 45.0, atol=1e-9)
    np.testing.assert_allclose(found.along_strike, y, atol=1e-12)
    np.testing.assert_allclose([y.min(), y.max()], [0.0, 30.0], atol=1e-12)


def test_the_winding_of_a_mesh_says_nothing_about_its_throw():
    """Files wind triangles either way; the hanging wall is above the fault all the same."""
    plain = faulted()
    mesh = plain.surface("F1")
    mixed = mesh.triangles.copy()
    mixed[0] = mixed[0, [0, 2, 1]]
    for fault in (turned_over(mesh), TriSurface("F1", "fault", mesh.vertices, mixed)):
        scene = plain.replace(faults={"F1": fault})
        assert list(scene.units) == list(plain.units)
        np.testing.assert_allclose(scene.throw("Top", "F1").throw, 4.0, atol=1e-12)
        for side in ("hanging wall", "footwall"):
            one, two = (s.cutoffs("Top", "F1", side) for s in (plain, scene))
            np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize("azimuth", [0.0, 37.0, 180.0, 301.0])
@pytest.mark.parametrize("dip", [30.0, 60.0, 90.0])
def test_separation_on_any_plane(azimuth, dip):
    """Lines with vertices of their own, each in either direction, on a plane of any attitude."""
    a, d = np.radians([azimuth, dip])
    down, strike = np.array([math.sin(a), math.cos(a)]), np.array([-math.cos(a), math.sin(a)])

    def line(s, z):
        across = -np.asarray(z) / math.tan(d)
        return np.column_stack([np.outer(s, strike) + np.outer(across, down), z])

    s = np.array([0.0, 30.0, 80.0, 100.0])
    up, low = line(s, -0.1 * s), line([100.0, 55.0, 10.0], [-50.0, -27.5, -5.0])
    found = separation([low], [up], azimuth)
    t = found.along_strike.values + 0.0
    np.testing.assert_allclose(sorted(t), [10.0, 30.0, 55.0, 80.0, 100.0], atol=1e-9)
    np.testing.assert_allclose(found.throw, 0.4 * t, atol=1e-9)
    np.testing.assert_allclose(found.heave, 0.4 * t / math.tan(d), atol=1e-9)
    np.testing.assert_allclose(found.dip_separation, 0.4 * t / math.sin(d), atol=1e-9)
    np.testing.assert_allclose(found.apparent_dip, dip, atol=1e-7)


@pytest.mark.parametrize("kind", ["through", "reverse"])
def test_throw_of_a_torn_sheet_is_that_of_its_truth(kind):
    """Cut-offs of a model from a sheet, against the cut-offs that the world was made with."""
    world = synthetic.torn(kind, 41)
    sheet = tear_horizon(world.truth["points"], world.faults, name="Top", positive="up")
    faults = {fault.name: fault for fault in sheet.faults}
    scene = Scene({"Top": sheet}, faults, (100.0, 900.0, 100.0, 900.0, -2070.0, -1530.0))
    found = scene.throw("Top", "F1", direction="mean")
    azimuth = found.attrs["dip_azimuth"]
    walls = ([world.truth["cutoffs"]["F1", wall]] for wall in "+-")
    truth = separation(*walls, azimuth, start=0.0)
    model = separation(*(scene.cutoffs("Top", "F1", wall) for wall in "+-"), azimuth, start=0.0)
    np.testing.assert_array_equal(model.throw, found.throw)
    expected = np.interp(model.along_strike, truth.along_strike, truth.throw)
    largest = np.abs(expected).max()
    assert largest > 50.0
    assert np.abs(found.throw.values - expected).mean() < 0.02 * largest
    assert scene.fault_polygons("Top").kind.item() == ("gap" if kind == "through" else "overlap")


# ---- dips ----------------------------------------------------------------------------


@pytest.mark.parametrize(("dip", "azimuth"), [(35.0, 200.0), (60.0, 75.0), (90.0, 90.0)])
def test_dip_azimuth_and_area_of_planes(dip, azimuth):
    world = synthetic.tilted_planes(n=9, dip=dip, dip_direction=azimuth, tilt=2.0)
    scene = Scene(world.horizons, world.faults, world.box)
    fault, top = scene.orientation("F1"), scene.orientation("Top")
    assert float(fault.mean_dip) == pytest.approx(dip, abs=1e-9)
    assert float(fault.mean_azimuth) == pytest.approx(azimuth, abs=1e-9)
    assert float(fault.mean_strike) == pytest.approx((azimuth - 90.0) % 360.0, abs=1e-9)
    assert not fault.overturned.any()
    np.testing.assert_allclose(fault.dip, dip, atol=1e-6)
    assert float(top.mean_dip) == pytest.approx(2.0, abs=1e-9)
    assert float(top.mean_azimuth) == pytest.approx(225.0, abs=1e-9)
    area = 4000.0 * 3000.0 / math.cos(math.radians(2.0))
    assert float(top.total_area) == pytest.approx(area, rel=1e-12)
    assert float(top.area.sum()) == pytest.approx(area, rel=1e-12)


# ---- scene ---------------------------------------------------------------------------


def test_pairs_of_lines_follow_the_strike_in_whatever_order_they_come():
    """Once they came by their easting: a profile of a fault in two pieces ran backwards."""
    lines = [[[x, y, z], [x, y + 30.0, z]] for y in (50.0, 0.0) for x, z in ((10.0, -50.0),)]
    foot = [[[0.0, y, -30.0], [0.0, y + 30.0, -30.0]] for y in (0.0, 50.0)]
    found = separation(lines, foot, dip_azimuth=90.0)
    assert np.unique(found.along_strike.values.round(9)).tolist() == [0.0, 30.0, 50.0, 80.0]
    assert (np.diff(found.along_strike.values) > 0).all()
    assert (np.diff(found.pair.values) >= 0).all()


# ---- Fault polygons: closed, as large as the heave, and together with the horizon without a g
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
    rings = lines_of(found, "easting", "northing")
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
