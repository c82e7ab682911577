"""Measures by runs of grids: as of all triangles, and without listing these."""

from __future__ import annotations

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
from geosurf.measure import thickness as unit_columns
from geosurf.measure.cutoffs import fault_polygons
from geosurf.measure.thickness import passages
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


@pytest.mark.parametrize("warp", [0.0, 60.0, 400.0])
@pytest.mark.parametrize("kind", ["isochore", "isopach"])
def test_thickness_by_coordinates_and_by_triangles_is_the_same(warp, kind):
    scene = turned_grids(warp=warp, holes=warp == 60.0)
    shells = Units(scene.units.values(), scene.box)  # no patches: triangles of shells are searched
    for zone in ("H0/H1", "above H0", "below H2"):
        one, two = (
            thickness_map(units, zone, 170.0, kind=kind, horizons=scene.horizon_names)
            for units in (scene.units, shells)
        )
        assert_same(one.to_dataset(), two.to_dataset())


# ---- Vertical lines through torn horizons: grids by coordinates, as all triangles of units ha
@pytest.mark.parametrize("kind", ["reverse", "X"])
def test_lines_pass_what_listed_units_have(kind, monkeypatch):
    world = gs.synthetic.torn(kind, n=41)
    scene = gs.Scene(world.horizons, world.faults, world.box, tear=True)
    units, rng = scene.units, np.random.default_rng(3)
    west, east, south, north = scene.box[:4]

    # also on nodes and on edges of cells
    axis = world.horizons["Top"].easting.values
    feet = rng.uniform([west, south], [east, north], (400, 2))
    feet[:200, 0] = rng.choice(axis[1:-1], 200)
    feet[:100, 1] = rng.choice(world.horizons["Top"].northing.values[1:-1], 100)
    middle = np.array([0.5 * (west + east), 0.5 * (south + north)])
    rows = list(range(len(units)))

    # no triangles of runs are searched
    with monkeypatch.context() as patch:
        patch.setattr(Strips, "keys_of", None)
        passed = list(passages(units, rows, feet, middle))
    met = {}
    for some, of_units in passed:
        number = np.arange(len(feet))[some]
        for u, one in enumerate(of_units):
            met[u] = sorted(
                zip(
                    number[one.foot].tolist(), one.way.tolist(), one.elevation.tolist(), strict=True
                )
            )
    assert sum(map(len, met.values())) > 2 * len(feet)
    for u, unit in enumerate(units.values()):
        one = unit_columns._of_shell(unit, feet, middle)
        listed = sorted(
            zip(one.foot.tolist(), one.way.tolist(), one.elevation.tolist(), strict=True)
        )
        assert [row[:2] for row in met[u]] == [row[:2] for row in listed]
        assert np.allclose([row[2] for row in met[u]], [row[2] for row in listed], atol=1e-9)
