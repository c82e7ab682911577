"""Scenes of simplified horizons: volumes within their bound."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf import Scene, synthetic
from geosurf.errors import InputError
from geosurf.report.tables import accuracy


def test_simplified_horizons_count_in_the_bound_and_in_reports():
    world = synthetic.waves(n=301)
    exact = Scene(world.horizons, world.faults, world.box)
    few = {
        name: gs.triangulate_horizon(horizon, name=name, tolerance=8.0)
        for name, horizon in world.horizons.items()
    }
    quick = exact.replace(horizons=few)
    assert quick.surface("Top").n_triangle < exact.surface("Top").n_triangle / 4
    off = float(abs(quick.volumes - exact.volumes).max())
    assert 0.0 < off <= quick.volume_error_bound < 0.1 * exact.units.box_volume
    assert exact.volume_error_bound == 0.0
    assert quick.check().ok
    (line,) = accuracy(quick)
    assert line.startswith("Horizons have fewer nodes than their grids, and are at most ")
    assert accuracy(exact) == []

    # the same nodes as of a scene with this tolerance
    scene = exact.replace(tolerance=8.0)
    assert scene.surface("Top").vertices.tobytes() == quick.surface("Top").vertices.tobytes()


@pytest.mark.parametrize("tolerance", [-1.0, 0.0, np.nan, np.inf, "5 m", True])
def test_a_tolerance_is_a_length(tolerance):
    world = synthetic.tilted_planes()
    with pytest.raises(InputError, match=r"tolerance is .*; give a length above 0 m, or None for"):
        Scene(world.horizons, world.faults, world.box, tolerance=tolerance)


def test_a_torn_horizon_has_no_tolerance():
    world = synthetic.tilted_planes()
    fault = Scene(world.horizons, world.faults, world.box).surface("F1")
    sheet = gs.throw_horizon(world.horizons["Top"], [fault], {"F1": 20.0}, name="Top")
    horizons = {**world.horizons, "Top": sheet}
    with pytest.raises(
        InputError, match=r"'Top' is a sheet torn at faults, .* Leave tolerance out"
    ):
        Scene(horizons, world.faults, world.box, tolerance=5.0)
