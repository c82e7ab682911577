"""The Drogon field: four stacked grids, which touch, and six faults that end inside them."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.triangulate.footprint import footprint_of
from geosurf.triangulate.outline import signed_area
from tests.field_data.columns import columns
from tests.field_data.conftest import near, pieces

# part of the field, or some faults, are left out on purpose; the warnings have tests of their own
pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")


@pytest.fixture(scope="module")
def curves(drogon_horizons, drogon_faults):
    return gs.intersect_surfaces([*drogon_horizons, *drogon_faults])


@pytest.fixture(scope="module")
def scene(drogon_horizons, drogon_faults):
    """Top and base with all faults, in the largest upright rectangle."""
    top, _, _, base = drogon_horizons
    faults = {f.name: f for f in drogon_faults}
    return gs.Scene({"Top": top, "Base": base}, faults, aoi="rectangle")


def test_curves_of_all_horizons_and_faults_are_the_exact_ones(
    curves, drogon_horizons, drogon_faults, verify
):
    for horizon in drogon_horizons:
        for fault in drogon_faults:
            lines = curves.between(horizon.name, fault.name)
            points, segments = verify.polylines_to_graph(lines)
            meshes = near(horizon, fault), (fault.vertices, fault.triangles)
            exact = verify.exact_curve_segments(*meshes)
            report = verify.check_curve(*meshes, points, segments, 1e-8, exact=exact)
            assert report.exact_length > 2000  # each fault crosses each horizon
            assert abs(report.reported_length / report.exact_length - 1) < 1e-9
            _, number = np.unique(points, axis=0, return_inverse=True)
            assert pieces(number.ravel()[segments]) == pieces(exact.edges)


def test_zone_around_one_fault_is_one_block_with_a_slit(scene, drogon_faults):
    small = scene.replace(
        faults={f.name: None for f in drogon_faults if f.name != "F5"},
        box=(459000.0, 460200.0, 5933900.0, 5936700.0, -2100.0, -1450.0),
    )
    assert list(small.units) == ["above Top", "Top/Base", "below Base"]
    assert list(small.units.report["slits"]) == ["F5"]
    top, base = columns([small.surface("Top"), small.surface("Base")], small.box)
    assert small.units["Top/Base"].volume == pytest.approx(top - base, rel=1e-12)
    assert small.check().ok


@pytest.mark.slow
def test_all_grids_at_once_with_all_faults_are_carved_and_certified(
    drogon_horizons, drogon_faults, verify
):
    horizons = {h.name: h for h in drogon_horizons}
    scene = gs.Scene(horizons, {f.name: f for f in drogon_faults}, aoi="rectangle")
    box, units = scene.box, scene.units
    assert {w.kind for w in scene.warnings} == {"outside", "rim"}  # F5 ends 11 m before a side
    lowest = columns(drogon_horizons, box)
    footprint = (box[1] - box[0]) * (box[3] - box[2])
    ends = [footprint * box[5], *lowest, footprint * box[4]]
    for volume, upper, lower in zip(by_zone(units), ends[:-1], ends[1:], strict=True):
        assert volume == pytest.approx(upper - lower, rel=1e-12)
    assert scene.check().ok
    distinct = np.unique(np.sort(scene.patches.triangles, axis=1), axis=0)
    assert len(verify.nonconforming_pairs((scene.patches.local, distinct))) == 0


def test_the_default_area_is_the_field_with_all_faults(drogon_horizons, drogon_faults):
    horizons = {h.name: h for h in drogon_horizons}
    scene = gs.Scene(horizons, {f.name: f for f in drogon_faults})
    assert len(scene.aoi) == 4
    assert signed_area(scene.aoi) / footprint_of(drogon_horizons[0]).area > 0.9999
    assert min(scene.coverage.values()) > 0.99
    assert {u.zone for u in scene.units.values() if u.volume > 5e8} == {
        "above topvolantis", "topvolantis/toptherys", "toptherys/topvolon",
        "topvolon/basevolantis", "below basevolantis",
    }  # fmt: skip
    assert scene.warnings == ()
    assert abs(scene.units.volume / scene.units.box_volume - 1) < 1e-12


def by_zone(units) -> list[float]:
    """Volume of each zone, over all its blocks."""
    zone = units.table["zone_index"].values
    return np.bincount(zone, units.table["volume"].values).tolist()


def test_regions_are_the_segments_that_a_modeller_draws(drogon_horizons, drogon_faults):
    """Seven through all zones with virtual walls; pieces of faults that just miss are remnants."""
    faults = {f.name: f for f in drogon_faults}
    scene = gs.Scene({h.name: h for h in drogon_horizons}, faults, compartments=True)
    found = list(scene.regions.values())
    assert len(found) == 7
    for region in found:
        large = [block for block in region.blocks if block not in region.remnants]
        assert {zone for zone, _ in large} == set(scene.reservoir)
    whole = sum(u.volume for u in scene.units.included().values())
    small = [b for region in found for b in region.remnants]
    rest = sum(u.volume for u in scene.units.values() if (u.zone, u.block) in small)
    assert len(small) > 40
    assert rest < 0.001 * whole


@pytest.mark.parametrize(("form", "n_region"), [("points", 8), ("grids", 7)])
def test_torn_horizons_and_virtual_walls_make_one_model(data, drogon_faults, form, n_region):
    """Tears make F2 and F6 longer; both go on from one stick, and their walls are sealed.

    Of the points, one zone pinches out between two parts of a region.
    """
    if form == "points":
        folder = data / "drogon" / "horizons_poi"
        names = ("TopVolantis", "TopTherys", "TopVolon", "BaseVolantis")
        horizons = {name: gs.read_points(folder / f"{name}.poi", positive="down") for name in names}
    else:
        files = sorted((data / "drogon_xtgeo" / "horizons_gri").glob("0*.gri"))
        horizons = {file.stem: gs.read_horizon(file, positive="down") for file in files}
    faults = {fault.name: fault for fault in drogon_faults}
    scene = gs.Scene(horizons, faults, tear=True, compartments=True)
    assert scene.check().ok
    assert len(scene.regions) == n_region
    assert sum(len(region.remnants) for region in scene.regions.values()) < 5
    assert scene.replace(compartments={"F6": "nearest"}).check().ok  # its wall is left out whole
    assert scene.replace(aoi=data / "drogon_xtgeo" / "outline.pol").check().ok  # beside faults
