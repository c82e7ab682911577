"""Measures by runs of grids: as of all triangles, and without listing these."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import geosurf as gs
from benchmarks.results import inputs_of
from geosurf import Scene, TriSurface, carve_units
from geosurf.measure import (
    allan_diagram,
    juxtaposition_table,
    orientation,
    thickness_map,
    vertical_section,
    wall_lines,
)
from geosurf.measure.cutoffs import fault_polygons
from geosurf.model import Lattice, Units
from geosurf.model.pieces import Strips


@pytest.fixture(scope="module")
def scene():
    """Three bent horizons of 61 x 61 nodes, and two faults that cut them."""
    horizons, faults, box = inputs_of(3, 61, 2)
    return Scene(horizons, faults, box)


@pytest.fixture(scope="module")
def listed(scene):
    """The same model without runs: every triangle by itself."""
    patches = scene.patches.changed()
    return patches, carve_units(patches)


def assert_same(one, two):
    """Both datasets have the same bytes."""
    assert one.identical(two)
    for name in one.variables:
        if one[name].dtype != object:
            assert one[name].values.tobytes() == two[name].values.tobytes()


def test_runs_and_triangles_give_the_same(scene, listed):
    pair = scene.patches, scene.units
    for name in scene.horizon_names:
        assert_same(fault_polygons(*pair, name), fault_polygons(*listed, name))
        for fault in scene.fault_names:
            for side in (0, 1):
                lines = (wall_lines(*model, name, fault, side) for model in (pair, listed))
                for one, two in zip(*lines, strict=True):
                    assert np.array_equal(one, two)
    for name in scene.fault_names:
        assert_same(juxtaposition_table(*pair, name), juxtaposition_table(*listed, name))
        assert_same(allan_diagram(*pair, name), allan_diagram(*listed, name))
        assert_same(orientation(*pair, name), orientation(*listed, name))


@pytest.mark.parametrize(
    "line",
    [
        [(500.0, 700.0), (9500.0, 8700.0)],
        [(5000.0, 300.0), (5000.0, 9000.0), (900.0, 4000.0)],  # along a column of nodes
        [(0.0, 4833.5), (10000.0, 4833.5)],
    ],
)
def test_sections_of_runs_and_of_triangles_are_the_same(scene, listed, line):
    one, two = (vertical_section(*m, line) for m in ((scene.patches, scene.units), listed))
    assert_same(one, two)
    assert float(one.area.sum()) > 0.0


def turned_grids(n=41, warp=0.0, holes=False):
    """The same horizons on a grid that is rotated by 33 degrees, warped, or has holes."""
    _, faults, box = inputs_of(3, 5, 2)
    u, v = np.meshgrid(np.linspace(-8e3, 8e3, n), np.linspace(-8e3, 8e3, n))
    u, v = u + warp * np.sin(v / 900.0), v + warp * np.cos(u / 700.0)
    turn = np.radians(33.0)
    x = 5e3 + u * np.cos(turn) - v * np.sin(turn)
    y = 5e3 + u * np.sin(turn) + v * np.cos(turn)
    horizons = {}
    for k in range(3):
        z = -1000.0 - 100.0 * k + 0.02 * x + 20.0 * np.sin(x / 1700.0 + k) * np.cos(y / 1300.0)
        if holes:
            z[:2], z[:, -2:] = np.nan, np.nan
        horizons[f"H{k}"] = TriSurface(f"H{k}", "horizon", lattice=Lattice(x, y, z))
    return Scene(horizons, faults, box)


def thickness_of(units, scene, step):
    """Maps of all zones, of both kinds."""
    zones = dict.fromkeys(unit.zone for unit in scene.units.values())
    return [
        thickness_map(units, zone, step, kind=kind, horizons=scene.horizon_names).to_dataset()
        for zone, kind in product(zones, ("isochore", "isopach"))
    ]


def assert_same_thickness(found, scene, step):
    """As of units without patches, of which all triangles are searched."""
    shells = Units(scene.units.values(), scene.box)
    for one, two in zip(found, thickness_of(shells, scene, step), strict=True):
        assert_same(one, two)


@pytest.mark.parametrize("warp", [0.0, 60.0, 400.0])
def test_thickness_by_coordinates_and_by_triangles_is_the_same(warp):
    scene = turned_grids(warp=warp, holes=warp == 60.0)
    assert_same_thickness(thickness_of(scene.units, scene, 170.0), scene, 170.0)


@pytest.mark.parametrize("kind", ["reverse", "X"])
def test_no_triangle_of_a_torn_grid_is_searched_for_its_thickness(kind, monkeypatch):
    """Every second line goes through nodes."""
    world = gs.synthetic.torn(kind, n=41)
    scene = gs.Scene(world.horizons, world.faults, world.box, tear=True)
    assert len(scene.units) > 1
    with monkeypatch.context() as patch:
        patch.setattr(Strips, "keys_of", None)
        found = thickness_of(scene.units, scene, 12.5)
    assert_same_thickness(found, scene, 12.5)
