"""Scenes of simplified horizons: volumes within their bound."""

from __future__ import annotations

import numpy as np
import pytest
import xarray

import geosurf as gs
from geosurf import Scene, synthetic
from geosurf.errors import HorizonError, InputError
from geosurf.report.tables import accuracy


def test_no_tolerance_changes_no_byte():
    world = synthetic.graben(n=17)
    one = Scene(world.horizons, world.faults, world.box)
    two = Scene(world.horizons, world.faults, world.box, tolerance=2.0).replace(tolerance=None)
    assert two.tolerance is None
    for key in ("vertices", "triangles", "surface_of_triangle", "parent_of_triangle"):
        assert getattr(one.patches, key).tobytes() == getattr(two.patches, key).tobytes()
    assert one.curves.points.tobytes() == two.curves.points.tobytes()


def test_the_default_box_is_that_of_all_nodes():
    world = synthetic.waves(n=41)
    boxes = [Scene(world.horizons, world.faults, tolerance=t).box for t in (None, 8.0)]
    assert boxes[0] == boxes[1]


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


@pytest.mark.parametrize("flaw", ["few nodes", "a hole", "uneven coordinates"])
def test_a_horizon_that_needs_all_nodes_has_them(flaw):
    top = synthetic.waves(n=101 if flaw == "few nodes" else 301).horizons["Top"]
    if flaw == "a hole":
        top = top.where((top.easting > 300) | (top.northing > 300))
    elif flaw == "uneven coordinates":
        east, north = np.meshgrid(top.easting, top.northing)
        places = {"easting": east + 9 * np.sin(north / 99), "northing": north}
        dims = ("row", "column")
        coords = {key: (dims, value) for key, value in places.items()}
        top = xarray.DataArray(top.values, coords, dims, attrs=top.attrs)
    few, plain = (gs.triangulate_horizon(top, tolerance=t) for t in (8.0, 0.0))
    assert few.vertices.tobytes() == plain.vertices.tobytes()
    assert "vertical_error" not in few.vertex_data


@pytest.mark.parametrize("tolerance", [-0.5, np.nan, np.inf])
def test_the_tolerance_of_a_horizon_is_a_length(tolerance):
    top = synthetic.waves(n=41).horizons["Top"]
    with pytest.raises(HorizonError, match=r"'Top': tolerance is .*Give a length in metres"):
        gs.triangulate_horizon(top, name="Top", tolerance=tolerance)


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
