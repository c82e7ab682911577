"""The Reek field: four fine grids with holes, of which the lower two cross, and a contact."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs

BOX = (462600.0, 463500.0, 5930600.0, 5931500.0, -1950.0, -1500.0)


@pytest.mark.slow
def test_crossing_grids_are_clipped_and_each_zone_is_the_sum_of_its_columns(
    reek_horizons, drogon_faults, columns
):
    scene = gs.Scene({h.name: h for h in reek_horizons}, {f.name: f for f in drogon_faults})
    lowest = columns(reek_horizons, scene.box)
    volume, zone = scene.units.table["volume"].values, scene.units.table["zone_index"].values
    between = np.bincount(zone, volume)[1:-1]
    np.testing.assert_allclose(between, -np.diff(lowest), rtol=1e-12)
    assert len(scene.units.report["crossings"]) > 10  # base above low, in places
    assert abs(scene.units.volume / scene.units.box_volume - 1) < 1e-12
    certificate = scene.check()
    assert certificate.ok, str(certificate)


@pytest.fixture(scope="module")
def with_contact(data, reek_horizons, drogon_faults):
    """A small part of the field, cut by the free-water level."""
    grid = gs.read_horizon(data / "reek" / "reek_fwl.gri", positive="down", units="m")
    level = gs.triangulate_horizon(grid, name="fwl").renamed("fwl", "fault")
    part = [cropped(s, BOX) for s in (*reek_horizons, level)]
    faults = {"fwl": part[-1], **{f.name: f for f in drogon_faults if f.name in ("F3", "F6")}}
    return gs.Scene({s.name: s for s in part[:-1]}, faults, BOX)


def test_free_water_level_cuts_the_units_of_a_part_of_the_field(with_contact, columns):
    units, box = with_contact.units, with_contact.box
    horizons = [with_contact.surface(name) for name in with_contact.horizon_names]
    lowest = columns(horizons, box)
    volume, zone = units.table["volume"].values, units.table["zone_index"].values
    np.testing.assert_allclose(np.bincount(zone, volume)[1:-1], -np.diff(lowest), rtol=1e-12)
    above = sum(u.volume for u in units.values() if u.vertices[:, 2].min() >= -1640.0)
    footprint = (box[1] - box[0]) * (box[3] - box[2])
    assert above == pytest.approx(footprint * (box[5] + 1640.0), rel=1e-12)
    certificate = with_contact.check()
    assert certificate.ok, str(certificate)


def cropped(surface: gs.TriSurface, box) -> gs.TriSurface:
    """The triangles whose map view reaches a box."""
    corners = surface.vertices[surface.triangles][:, :, :2] - (box[0], box[2])
    size = (box[1] - box[0], box[3] - box[2])
    reach = (corners.max(axis=1) >= 0).all(axis=1) & (corners.min(axis=1) <= size).all(axis=1)
    used, faces = np.unique(surface.triangles[reach], return_inverse=True)
    return gs.TriSurface(surface.name, surface.role, surface.vertices[used], faces.reshape(-1, 3))
