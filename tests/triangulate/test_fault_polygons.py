"""Fault polygons to surfaces: planes exactly, bent faults to a stated error, those of a field."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import SurfaceError

S = np.linspace(-1.0, 1.0, 41)


def polygon_on(fault, level, throw=30.0, length=4000.0, shift=0.0):
    """The gap of a fault in a level horizon: `fault(along, z)` gives eastings.

    The throw dies at both tips, and is shared by the walls.
    """
    half = 0.5 * throw * (1.0 - S**2)
    along = 0.5 * length * S + shift
    sides = []
    for z in (level + half, level - half):
        sides.append(np.column_stack([fault(along, z), along, z]))
    return np.concatenate([sides[0], sides[1][::-1]])


def plane(along, z):
    return 0.3 * along - 0.8 * (z + 1500.0)


def listric(along, z):
    """Steep above, flat below; bent along strike by 250 m on a length of 4 km."""
    depth = -z - 1300.0
    return 0.5 * depth + 0.0008 * depth**2 + 250.0 * (along / 2000.0) ** 2


def turned(polygon, degrees):
    a = np.radians(degrees)
    turn = np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
    return np.column_stack([polygon[:, :2] @ turn, polygon[:, 2]])


@pytest.mark.parametrize("degrees", [0, 40, 130, 270])
@pytest.mark.parametrize("levels", [(-1500.0,), (-1450.0, -1600.0, -1800.0)])
def test_a_plane_comes_back_exactly(degrees, levels):
    polygons = {
        f"H{k}": turned(polygon_on(plane, level, shift=100.0 * k), degrees)
        for k, level in enumerate(levels)
    }
    fault = gs.fault_from_polygons(polygons, name="F1", lengthen=150)
    back = turned(fault.vertices, -degrees)
    assert np.abs(back[:, 0] - plane(back[:, 1], back[:, 2])).max() < 1e-8
    # from tip to tip, and beyond the lines by the distance down the dip
    assert np.ptp(back[:, 1]) >= 4000.0 + 100.0 * (len(levels) - 1) - 1e-6
    way = np.array([-0.8, 0.0, 1.0]) / np.hypot(0.8, 1.0)  # dip lines lie near it, not on it
    assert fault.bounds[5] > max(levels) + 0.9 * 150 * way[2]
    assert fault.bounds[4] < min(levels) - 0.9 * 150 * way[2]


def test_any_start_direction_and_closing_point_of_a_polygon_gives_the_same():
    ring = polygon_on(plane, -1500.0)
    ring = ring[np.r_[True, (np.diff(ring, axis=0) != 0).any(axis=1)]]
    first = gs.fault_from_polygons({"Top": ring}, name="F1")
    for other in (np.roll(ring, 17, axis=0), ring[::-1], np.vstack([ring, ring[:1]])):
        again = gs.fault_from_polygons({"Top": other}, name="F1")
        np.testing.assert_allclose(again.vertices, first.vertices, atol=1e-9)


def test_a_bent_listric_fault_is_met_to_two_metres_between_its_lines():
    levels = np.linspace(-1400.0, -2000.0, 7)
    polygons = {f"H{k}": polygon_on(listric, z, throw=60.0) for k, z in enumerate(levels)}
    fault = gs.fault_from_polygons(polygons, name="F1", lengthen=50)
    x, y, z = fault.vertices.T
    between = (z <= -1400.0) & (z >= -2000.0)  # beyond, it goes on straight
    off = np.abs(x - listric(y, z))[between]
    assert between.sum() > 200
    assert off.max() < 2.0
    assert off.mean() < 0.2
    assert gs.intersect_surfaces([fault], self_intersections=True).n_curve == 0


@pytest.mark.parametrize("degrees", [0, 130])
@pytest.mark.parametrize("dip", [30.0, 60.0, 90.0, 120.0])
def test_a_dip_that_is_given_counts_instead_of_the_gap(dip, degrees):
    """It passes midway between the lines; no wall ends on them."""
    ring = turned(polygon_on(plane, -1500.0), degrees)
    fault = gs.fault_from_polygons({"Top": ring}, name="F1", lengthen=100, dip=dip)
    x, y, z = turned(fault.vertices, -degrees).T
    off = (x - 0.3 * y) / np.hypot(1.0, 0.3)  # across the strike
    np.testing.assert_allclose(
        off * np.sin(np.radians(dip)), -(z + 1500.0) * np.cos(np.radians(dip)), atol=0.05
    )
    assert not fault.vertex_data["cut-off on Top"].any()
    thrown = polygon_on(plane, -1500.0, throw=0.0)  # without a heave: refused without a dip
    assert gs.fault_from_polygons({"Top": thrown}, name="F1", lengthen=9, dip=dip).n_triangle


@pytest.mark.parametrize("degrees", [0, 40])
@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize("dip", [40.0, 60.0, 90.0])
def test_horizons_show_the_dip_that_their_smear_hides(dip, reverse, degrees):
    """Horizons on a slope, with 40 m of throw smeared over 100 m; the polygon is the smear."""
    grid = np.arange(0.0, 1500.0, 20.0)
    east, north = np.meshgrid(grid, grid)

    def horizon(level):
        middle = 750.0 + 0.1 * (north - 750.0) - (level + 1500.0) / np.tan(np.radians(dip))
        share = np.clip((east - middle) / 100.0 + 0.5, 0.0, 1.0)
        z = level + 0.02 * (east - 750.0) - (-40.0 if reverse else 40.0) * share
        points = np.column_stack([east.ravel(), north.ravel(), z.ravel()])
        return turned(points, degrees)

    along = np.linspace(300.0, 1200.0, 19)
    lines = [
        np.column_stack([750.0 + 0.1 * (along - 750.0) + away, along, np.full(19, -1500.0 + z)])
        for away, z in ((-50.0, 0.0), (50.0, 40.0 if reverse else -40.0))
    ]
    ring = turned(np.concatenate([lines[0], lines[1][::-1]]), degrees)
    horizons = [horizon(level) for level in (-1500.0, -1560.0, -1600.0)]
    found = gs.propose_dip(ring, horizons)
    assert abs(found - (180.0 - dip if reverse else dip)) < 3.0
    assert np.isnan(gs.propose_dip(ring, horizons[:1]))
    level = horizons[0] * [1.0, 1.0, 0.0]
    assert np.isnan(gs.propose_dip(ring, [level, level - 50.0]))
    assert np.isnan(gs.propose_dip(ring, [horizons[0]] * 2))
    short = turned(turned(ring, -degrees) * [1, 0.1, 1] + [0, 675, 0], degrees)
    assert np.isnan(gs.propose_dip(short, horizons))  # 90 m: some sections, alike
    with pytest.raises(SurfaceError, match=r"the fault polygon has shape \(38, 2\).*third column"):
        gs.propose_dip(ring[:, :2], horizons)


def test_such_a_fault_divides_a_model():
    fault = gs.fault_from_polygons({"Top": polygon_on(plane, -1500.0)}, name="F1", lengthen=400)
    box = (-400.0, 400.0, -1200.0, 1200.0, -1650.0, -1350.0)
    scene = gs.Scene({}, {"F1": fault}, box, extend=["F1"])
    assert len(scene.units) == 2
    assert scene.check().ok


def test_polygons_that_cannot_be_used_are_refused():
    hook = polygon_on(plane, -1500.0).copy()
    hook[15:20, 1] -= 2500.0
    for polygons, words in (
        ({"Top": hook}, r"runs back along strike at \(E.*Split it there"),
        ({"Top": polygon_on(plane, -1500.0, throw=0.0)}, r"two sides .* coincide.*or fault sticks"),
    ):
        with pytest.raises(SurfaceError, match=words):
            gs.fault_from_polygons(polygons, name="F1")


def test_the_seven_polygons_of_reek_become_faults(shared):
    path = shared / "data" / "reek" / "fault_polygons" / "top_upper_reek_faultpoly.pol"
    polygons = gs.read_polygons(path, positive="down", length_unit="m")
    assert len(polygons) == 7
    for k, polygon in enumerate(polygons):
        fault = gs.fault_from_polygons({"Top": polygon}, name=f"F{k}", lengthen=100)
        assert gs.intersect_surfaces([fault], self_intersections=True).n_curve == 0
        # the lines of the file lie on it, to 1.6 m where they close at the tips
        a, b, c = fault.vertices[fault.triangles].swapaxes(0, 1)
        u, v = (g.ravel() / 8 for g in np.meshgrid(np.arange(9), np.arange(9)))
        u, v = u[u + v <= 1, None], v[u + v <= 1, None]
        samples = (a[:, None] + u * (b - a)[:, None] + v * (c - a)[:, None]).reshape(-1, 3)
        from scipy.spatial import cKDTree

        near, _ = cKDTree(samples).query(polygon)
        spacing = np.linalg.norm(np.stack([b - a, c - b, a - c]), axis=2).max(axis=0).mean() / 8
        assert np.median(near) < 0.3 + spacing
