"""Well tops against models whose horizons are known: misfit, block, gap, repetition."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import GeosurfWarning, InputError
from geosurf.synthetic.torn_horizon import side_of
from tests.grids import gridded
from tests.measure.worlds import tops_at
from tests.messages import refused


@pytest.fixture(scope="module", params=["through", "reverse"])
def torn(request):
    """A torn horizon, normal or reverse, with its truth."""
    world = gs.synthetic.torn(request.param, n=41, smear=0)
    sheet = gs.tear_horizon(world.truth["points"], world.faults, name="Top", positive="up")
    faults = {fault.name: fault for fault in sheet.faults}
    return world, gs.Scene({"Top": sheet}, faults, world.box)


def test_law_misfit_of_a_plane_is_what_was_added(planes):
    west, east, south, north, *_ = planes.box
    rng = np.random.default_rng(3)
    place = rng.uniform((west, south), (east, north), (40, 2))
    nodes = planes.surface("Top").vertices
    ramp, *_ = np.linalg.lstsq(np.column_stack([nodes[:, :2], np.ones(len(nodes))]), nodes[:, 2])
    truth = np.column_stack([place, np.ones(40)]) @ ramp
    added = rng.uniform(-20.0, 20.0, 40)
    found = planes.misfit(tops_at(np.column_stack([place, truth - added])))
    np.testing.assert_allclose(found.model, truth, atol=1e-8)
    np.testing.assert_allclose(found.misfit, added, atol=1e-8)
    assert set(found.status.values) == {"found"}
    assert set(found.block.values) == {"F1+", "F1-"}


def test_a_top_on_the_other_side_of_a_fault_names_the_fault(planes):
    fault, top = (planes.surface(name) for name in ("F1", "Top"))
    middle = fault.vertices.mean(axis=0)
    level = float(planes.misfit(tops_at(middle)).model[0])
    beyond = 2.0 * middle[2] - level  # as far on the other side of the fault
    found = planes.misfit(tops_at([[*middle[:2], beyond], [*middle[:2], level]]))
    assert found.fault.values.tolist() == ["F1", ""]
    assert found.block.values[0] != found.block.values[1]
    assert top.n_triangle


def test_every_sheet_of_a_torn_horizon_is_compared_at_its_own_height(torn):
    world, scene = torn
    truth = world.truth["points"]
    step = 25.0
    inner = truth[(truth[:, :2] > 5 * step).all(axis=1) & (truth[:, :2] < 35 * step).all(axis=1)]
    tops = inner[::7]
    found = scene.misfit(tops_at(tops))
    usable = found.status.isin(["found", "several"]).values
    assert usable.mean() > 0.97  # nodes in the cells of the cut-offs may be in the gap
    assert np.nanpercentile(np.abs(found.misfit), 95) < 0.5
    side = np.where(side_of(world.truth["faults"]["F1"], *tops.T) > 0, "F1+", "F1-")
    inside = np.isin(found.block.values, ["F1+", "F1-"])  # a fault that dies divides nothing
    assert (found.block.values[inside] == side[inside]).all()


def test_gap_and_repetition(torn):
    world, scene = torn
    foot, hang = (world.truth["cutoffs"]["F1", wall] for wall in "-+")
    middle = 0.5 * (foot + hang)[len(foot) // 2]
    found = scene.misfit(tops_at(middle + np.array([[0.0, 0.0, -25.0], [0.0, 0.0, 25.0]])))
    if world.name.endswith("through"):
        assert found.status.values.tolist() == ["fault gap"] * 2
        assert found.fault.values.tolist() == ["F1"] * 2
        assert np.isnan(found.misfit).all()
    else:
        assert found.status.values.tolist() == ["several"] * 2
        assert found.n_values.values.tolist() == [2, 2]
        assert found.model[0] < found.model[1]  # the nearest one of each


def test_what_cannot_be_compared_has_a_status(planes):
    place = planes.surface("Top").vertices[40]
    with pytest.warns(GeosurfWarning, match="1 well top of 'Topp'.*Did you mean 'Top'"):
        assert planes.misfit(tops_at(place, "Topp")).status.values.tolist() == ["unknown horizon"]
    far = planes.misfit(tops_at(place + np.array([1e6, 0.0, 0.0])))
    assert far.status.values.tolist() == ["outside"]
    assert np.isnan(far.model).all()


def test_tops_from_a_file_and_without(planes, tmp_path):
    east, north, up = planes.surface("Top").vertices[40]
    (tmp_path / "tops.csv").write_text(f"Well,X,Y,TVDSS,Top\nW1,{east},{north},{-up + 4},Top\n")
    found = planes.replace(positive="down").misfit(tmp_path / "tops.csv")
    assert found.misfit.values.tolist() == pytest.approx([4.0])
    refused(InputError, "the scene has no well tops", planes.misfit)
    refused(InputError, "tops is dict without all of well", planes.misfit, {"well": ["W1"]})


@pytest.mark.parametrize(
    ("factor", "how"), [(-1.0, "positive='down', or"), (1 / 0.3048, "read_tops length_unit='ft'")]
)
def test_a_top_of_another_sign_or_unit_is_named_and_not_tied(planes, factor, how):
    east, north, up = planes.surface("Top").vertices[37]  # F1 is not below it
    tops = tops_at([east, north, factor * up])
    with pytest.warns(GeosurfWarning, match=f"'Top' in well 'W0' is .* Give .*{how}"):
        planes.misfit(tops)
    refused(InputError, how, lambda: planes.replace(tops=tops, tie=True).units)


# ---- A horizon on the nodes of a grid is where the model has it; what faults lose is stated.
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


@pytest.mark.parametrize("rotated", [False, True])
def test_a_horizon_without_walls_loses_nothing_on_its_own_nodes(rotated):
    name, horizon = next(iter(gs.synthetic.waves(n=9).horizons.items()))
    if rotated:
        x, y = np.meshgrid(horizon.easting, horizon.northing)
        horizon = gridded(horizon.values, 0.8 * x - 0.6 * y, 0.8 * y + 0.6 * x)
    grid = gs.Scene({name: horizon}).horizon_grid(name)
    assert "lost" not in grid.attrs
    np.testing.assert_array_equal(grid.easting, horizon.easting)
    inside = ~np.isnan(grid.values)
    np.testing.assert_allclose(grid.values[inside], horizon.values[inside], atol=1e-9)
