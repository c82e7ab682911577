"""The Reek field: four fine grids with holes, of which the lower two cross, and a contact."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.scenario import read_scenario
from geosurf.scenario.new import new_scenario
from geosurf.triangulate.footprint import footprint_of
from geosurf.triangulate.outline import signed_area
from tests.field_data.columns import columns

# part of the field, or some faults, are left out on purpose; the warnings have tests of their own
pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")

BOX = (462600.0, 463500.0, 5930600.0, 5931500.0, -1950.0, -1500.0)
CROSSING = (462200.0, 462800.0, 5933100.0, 5933700.0, -1950.0, -1450.0)


@pytest.mark.slow
def test_crossing_grids_are_clipped_and_each_zone_is_the_sum_of_its_columns(
    reek_horizons, drogon_faults
):
    horizons = {h.name: h for h in reek_horizons}
    scene = gs.Scene(horizons, {f.name: f for f in drogon_faults}, aoi="rectangle")
    lowest = columns(reek_horizons, scene.box)
    volume, zone = scene.units.table["volume"].values, scene.units.table["zone_index"].values
    between = np.bincount(zone, volume)[1:-1]
    np.testing.assert_allclose(between, -np.diff(lowest), rtol=1e-12)
    (clip,) = scene.units.report["clipped"]
    assert (clip.horizon, clip.by, clip.rule) == ("basereek_rota", "lowreek_rota", "conformable")
    assert len(clip.places) > 10
    assert abs(scene.units.volume / scene.units.box_volume - 1) < 1e-12
    assert scene.check().ok


def test_the_default_area_follows_the_rim_of_undefined_nodes(reek_horizons):
    """The field is a convex polygon whose rim is a staircase of nodes, in a rotated grid."""
    scene = gs.Scene({h.name: h for h in reek_horizons})
    field = footprint_of(reek_horizons[0]).area
    assert len(scene.aoi) < 40
    assert 0.992 < signed_area(scene.aoi) / field < 1.0
    rectangle = scene.replace(aoi="rectangle").box
    assert (rectangle[1] - rectangle[0]) * (rectangle[3] - rectangle[2]) / field < 0.7


@pytest.fixture(scope="module")
def with_contact(data, reek_horizons, drogon_faults):
    """A small part of the field, cut by the free-water level."""
    grid = gs.read_horizon(data / "reek" / "reek_fwl.gri", positive="down", length_unit="m")
    level = gs.triangulate_horizon(grid, name="fwl").renamed("fwl", "fault")
    part = [cropped(s, BOX) for s in (*reek_horizons, level)]
    faults = {"fwl": part[-1], **{f.name: f for f in drogon_faults if f.name in ("F3", "F6")}}
    return gs.Scene({s.name: s for s in part[:-1]}, faults, BOX)


def test_free_water_level_cuts_the_units_of_a_part_of_the_field(with_contact):
    units, box = with_contact.units, with_contact.box
    horizons = [with_contact.surface(name) for name in with_contact.horizon_names]
    lowest = columns(horizons, box)
    volume, zone = units.table["volume"].values, units.table["zone_index"].values
    np.testing.assert_allclose(np.bincount(zone, volume)[1:-1], -np.diff(lowest), rtol=1e-12)
    above = sum(u.volume for u in units.values() if u.vertices[:, 2].min() >= -1640.0)
    footprint = (box[1] - box[0]) * (box[3] - box[2])
    assert above == pytest.approx(footprint * (box[5] + 1640.0), rel=1e-12)
    assert with_contact.check().ok


def cropped(surface: gs.TriSurface, box) -> gs.TriSurface:
    """The triangles whose map view reaches a box."""
    corners = surface.vertices[surface.triangles][:, :, :2] - (box[0], box[2])
    size = (box[1] - box[0], box[3] - box[2])
    reach = (corners.max(axis=1) >= 0).all(axis=1) & (corners.min(axis=1) <= size).all(axis=1)
    used, faces = np.unique(surface.triangles[reach], return_inverse=True)
    return gs.TriSurface(surface.name, surface.role, surface.vertices[used], faces.reshape(-1, 3))


def test_lower_grid_as_base_takes_from_the_upper_one(reek_horizons):
    """Where the two cross, the younger laps onto the older: nothing of the older is lost."""
    low, base = (cropped(s, CROSSING) for s in reek_horizons[2:])
    scene = gs.Scene({"low": low, "base": base}, box=CROSSING, column={"base": "base"})
    turned = [
        gs.TriSurface(s.name, s.role, s.vertices * (1, 1, -1), s.triangles) for s in (base, low)
    ]
    base_alone, highest = (-integral for integral in columns(turned, CROSSING))
    footprint = (CROSSING[1] - CROSSING[0]) * (CROSSING[3] - CROSSING[2])
    between = sum(unit.volume for unit in scene.units.values() if unit.zone_index == 1)
    assert between == pytest.approx(highest - base_alone, rel=1e-12)
    assert scene.units["below base"].volume == pytest.approx(
        base_alone - footprint * CROSSING[4], rel=1e-12
    )
    assert scene.check().ok
    (clip,) = scene.units.report["clipped"]
    assert (clip.horizon, clip.by, clip.rule) == ("low", "base", "base")
    assert clip.thickness == pytest.approx(3.5279541015625, abs=1e-9)  # at a node of both
    _, lowest = columns([low, base], CROSSING)
    assert clip.volume == pytest.approx(base_alone - lowest, rel=1e-9)


def test_the_dip_of_the_horizons_closes_the_faults_of_its_polygons(data, tmp_path):
    """`geosurf new` asks; its own question is answered by taking out the marks of comments."""
    files = [*(data / "reek" / "horizons_gri").glob("0[14]*.gri")]
    new = new_scenario(tmp_path, [*files, *(data / "reek" / "fault_polygons").glob("*.csv")])
    head, asked = new.path.read_text().split("# QUESTION: has ")
    first, *lines = asked.partition("\n\n")[0].splitlines()  # the next question has no answer
    answered = "\n".join([f"# {first}", *(line.removeprefix("# ") for line in lines)])
    new.path.write_text(head + answered)
    dips = {fault.name: fault.dip for fault in read_scenario(new.path).faults}
    assert dips["P3"] == pytest.approx(80, abs=5)  # 38 in the polygon
    scene = gs.run_scenario(new.path, tmp_path / "out", pictures=False)
    assert scene.check().ok
    assert {*scene.fault_names} == {f"P{k}" for k in range(1, 8)}
    assert dips["P7"] is None  # 130 m long: too short to show one
    for name, sheet in scene.sheets.items():
        found = [one for one in sheet.report.remedies if one.subject != "P7"]
        assert {one.kind for one in found} <= {"fault extended"}, name


@pytest.mark.slow
def test_six_faults_close_each_at_its_own_place(data):
    """A hole at one fault must not hide a leak at another: both are places that remedies know."""
    base = gs.read_horizon(data / "reek" / "horizons_gri" / "04_basereek_rota.gri", positive="down")
    lines = gs.read_polygons(
        data / "reek" / "fault_polygons" / "top_upper_reek_faultpoly.csv", positive="down"
    )
    faults = {
        f"P{k}": gs.fault_from_polygons({"Top": line}, name=f"P{k}")
        for k, line in enumerate(lines, 1)
        if k != 4
    }
    sheet = gs.tear_horizon(base, faults, name="Base")
    assert set(sheet.cuts) == set(faults)
    assert len(sheet.report.remedies) <= 6
