"""A horizon on the nodes of a grid is where the model has it; what faults lose is stated."""

import numpy as np
import pytest

import geosurf as gs


def test_a_torn_horizon_as_a_grid_states_what_it_loses(tmp_path):
    world = gs.synthetic.faulted("graben", n=41)
    throw = {"F1": -70.0, "F2": 40.0}  # the first one is reverse
    sheet = gs.throw_horizon(world.horizons["Top"], world.faults, throw, name="Top")
    scene = gs.Scene({"Top": sheet}, {one.name: one for one in sheet.faults}, world.box)
    with pytest.warns(gs.GeosurfWarning, match="has no walls at faults: along") as caught:
        grid = scene.horizon_grid("Top", 50.0)
    assert caught[0].filename == __file__
    east, north = np.meshgrid(grid.easting, grid.northing)
    gap = np.isnan(grid.values)
    doubled = int(grid.attrs["lost"].split(" where the horizon is doubled")[0].split()[-2])
    assert 0 < gap.sum() < 100
    assert doubled > 0

    # just above the horizon lies the zone above it, just below it the other one
    for shift, zone in ((0.01, "above Top"), (-0.01, "below Top")):
        places = np.stack([east, north, grid.values + shift], axis=2)[~gap]
        assert (scene.sample(places).zone.values == zone).all()
    (file,) = gs.write(grid, tmp_path / "top.irapasc")
    back = gs.read_horizon(file, positive="up")
    np.testing.assert_array_equal(np.isnan(back.values), gap)


def test_a_horizon_without_walls_loses_nothing():
    given = gs.synthetic.waves(n=9).horizons
    name, horizon = next(iter(given.items()))
    grid = gs.Scene(given).horizon_grid(name, horizon)
    assert "lost" not in grid.attrs
    inside = ~np.isnan(grid.values)
    np.testing.assert_allclose(grid.values[inside], horizon.values[inside], atol=1e-9)
