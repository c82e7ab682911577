"""Measures by runs of grids: as of all triangles, and without listing these."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.results import inputs_of
from geosurf import Scene, carve_units
from geosurf.measure import allan_diagram, juxtaposition_table, orientation, wall_lines
from geosurf.measure.cutoffs import fault_polygons


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


def test_faults_are_measured_without_the_triangles_of_horizons(scene):
    fresh = Scene(*inputs_of(3, 61, 2))
    for name in fresh.horizon_names:
        assert fresh.fault_polygons(name).sizes["line"] == 2
        assert fresh.throw(name, "F0").sizes["point"]
    for name in fresh.faults_inside:
        fresh.juxtaposition(name)
        fresh.allan(name)

    # what is listed: triangles of the two faults, and no array of all triangles
    surfaces = [key for key in fresh.units.faces if isinstance(key, int)]
    assert [fresh.patches.names[i] for i in surfaces] == ["F0", "F1"]
    assert "triangles" not in fresh.patches.pieces.expanded.__dict__
    assert "_sorted" not in fresh.units[next(iter(fresh.units))]._shell[0].__dict__
