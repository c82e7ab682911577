"""Each uncertainty changes its input as it says: volumes and shapes are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.ensemble import (
    ContactLevel,
    DepthError,
    DepthShift,
    Discrete,
    FaultDip,
    FaultShift,
    Normal,
    Throw,
    Uniform,
    realisations,
    realise,
    run_ensemble,
)
from geosurf.ensemble.run import planned
from geosurf.ensemble.uncertain_faults import shifted, turned
from geosurf.errors import InputError
from tests.ensemble.worlds import AREA, fault, layer_cake, plane
from tests.grids import gridded
from tests.messages import refused


class Result:
    """Realisations without a store: drawn numbers and volumes."""

    def __init__(self, scene, n, uncertain):
        plan, _ = planned(scene, n, uncertain, 0, None)
        self.base = volumes_of(plan.start())
        records = [plan.run(k) for k in range(n)]
        assert not any(record.reason for record in records)
        self.volumes = [volumes_of(record) for record in records]
        self.numbers = [record.numbers for record in records]

    def volume(self, unit):
        return np.array([one.get(unit, 0.0) for one in self.volumes])

    def drawn(self, parameter):
        return np.array([one[parameter] for one in self.numbers])


def volumes_of(record):
    return {key.name: bulk for key, (bulk,) in record.amounts.items()}


def test_a_shift_changes_the_volume_by_its_length_times_the_area():
    result = Result(layer_cake(), 5, [DepthShift("Top", Normal(0.0, 9.0))])
    shift = result.drawn("depth shift Top")
    assert len(set(shift.tolist())) == 5
    np.testing.assert_allclose(result.volume("Top/Base"), AREA * (100.0 + shift), rtol=1e-12)
    assert result.base["Top/Base"] == pytest.approx(100.0 * AREA)


def test_horizons_that_share_a_shift_keep_their_thickness():
    result = Result(layer_cake(), 4, [DepthShift((), Uniform(-50.0, 50.0))])
    np.testing.assert_allclose(result.volume("Top/Base"), 100.0 * AREA, rtol=1e-12)
    shift = result.drawn("depth shift")
    np.testing.assert_allclose(result.volume("above Top"), AREA * (200.0 - shift), rtol=1e-12)


@pytest.mark.parametrize("words", [{"elevation": Uniform(-1090.0, -1010.0)},
                                   {"shift": Uniform(-40.0, 40.0)}])  # fmt: skip
@pytest.mark.parametrize("given", [-1050.0, gs.FluidContact(-1050.0, zones="Top/Base"),
                                   plane(-1050.0)])  # fmt: skip
def test_a_contact_splits_the_volume_where_it_is_drawn(words, given):
    scene = layer_cake(contacts={"OWC": given})
    result = Result(scene, 3, [ContactLevel("OWC", **words)])
    level = result.drawn("contact OWC") + (-1050.0 if "shift" in words else 0.0)
    name = "Top/Base above OWC"
    np.testing.assert_allclose(result.volume(name), AREA * (-1000.0 - level), rtol=1e-9)


def test_units_that_only_some_realisations_have_are_empty_in_the_others():
    scene = layer_cake(contacts={"OWC": -1150.0})
    levels = Discrete([-1150.0, -1050.0], [2, 1])
    ensemble = run_ensemble(scene, 12, uncertain=[ContactLevel("OWC", elevation=levels)])
    result = ensemble.data
    cut = result.drawn.sel(parameter="contact OWC").values == -1050.0
    below = result.bulk.sel(unit="Top/Base below OWC").values
    assert cut.any()
    assert not cut.all()
    assert (below > 0).tolist() == cut.tolist()
    assert np.isfinite(result.bulk.values).all()
    assert result.base_bulk.sel(unit="Top/Base below OWC") == 0.0
    present = ensemble.quantiles("unit").present.sel(unit="Top/Base below OWC")
    assert present == pytest.approx(cut.mean())


def test_a_fault_from_a_grid_moves_like_its_mesh():
    grid = gs.triangulate_fault(gs.synthetic.tilted_planes(n=5).faults["F1"], name="F1")
    mesh = gs.TriSurface("F1", "fault", grid.vertices, grid.triangles)
    for move in (shifted, turned):
        np.testing.assert_allclose(move(grid, 7.0).vertices, move(mesh, 7.0).vertices, atol=1e-9)


def test_blocks_change_with_the_fault_between_them():
    scene = layer_cake(faults={"F1": fault()})
    unc = [FaultShift("F1", Uniform(-200.0, 200.0)), FaultDip("F1", Uniform(-8.0, 8.0))]
    result = Result(scene, 3, unc)
    move, turn = result.drawn("position F1"), result.drawn("dip F1")
    # at -1050 m: the fault turns about its middle, at -1000 m
    middle = 1000.0 + move + 50.0 / np.tan(np.radians(60.0 + turn))
    np.testing.assert_allclose(result.volume("Top/Base F1-"), 100.0 * 1500.0 * middle, rtol=1e-9)


def test_throw_is_the_one_that_is_drawn():
    scene = layer_cake(faults={"F1": fault()})
    unc = [Throw("F1", Uniform(10.0, 60.0)), DepthError("Top", sd=3.0, range=900.0)]
    one = realise(scene, 2, uncertain=unc)
    result = Result(scene, 3, unc)
    throw = result.drawn("throw F1")[2]
    base = one.sheets["Base"].cuts["F1"].throw
    np.testing.assert_allclose(base[np.isfinite(base)], throw, atol=1e-6)
    assert result.volume("Top/Base F1+")[2] == one.units["Top/Base F1+"].volume
    every = [some.units["Top/Base F1+"].volume for some in realisations(scene, 3, uncertain=unc)]
    assert every == result.volume("Top/Base F1+").tolist()


FORMS = {
    "profile": np.array([[0.0, 20.0], [9000.0, 20.0]]),
    "map": gridded(np.full((2, 2), 20.0), [-9e3, 9e3]),
}  # fmt: skip


@pytest.mark.parametrize("form", FORMS)
def test_a_factor_multiplies_throw_of_every_form(form):
    scene = layer_cake(faults={"F1": fault()})
    one = realise(scene, 0, uncertain=[Throw("F1", FORMS[form], factor=2.0)])
    throw = one.sheets["Top"].cuts["F1"].throw
    np.testing.assert_allclose(throw[np.isfinite(throw)], 40.0, atol=1e-6)


def test_depth_errors_meet_picks_and_the_tops_of_the_scene():
    rng = np.random.default_rng(4)
    places = np.column_stack([rng.uniform(50, 1950, 9), rng.uniform(50, 1450, 9)])
    picks = np.column_stack([places, -1000.0 + 0.02 * places[:, 0] + rng.normal(0.0, 8.0, 9)])
    tops = {"well": [f"W{k}" for k in range(9)], "horizon": ["Top"] * 9,
            **dict(zip(("easting", "northing", "elevation"), picks.T, strict=True))}  # fmt: skip
    horizons = {"Top": plane(-1000.0, 0.02, n=31), "Base": plane(-1200.0)}
    scene = gs.Scene(horizons, box=(0, 2000, 0, 1500, -1300, -800), tops=tops)
    error = DepthError("Top", sd=10.0, range=800.0)
    for k in (None, 0, 1):
        assert np.abs(realise(scene, k, uncertain=[error]).misfit().misfit).max() < 1e-6
    same = DepthError("Top", sd=10.0, range=800.0, picks=picks)
    bare = scene.replace(tops=None)
    first, second = (realise(s, 1, uncertain=[e]) for s, e in ((scene, error), (bare, same)))
    assert np.array_equal(first.surface("Top").vertices, second.surface("Top").vertices)


def test_an_error_of_several_horizons_moves_them_alike():
    """On one grid, and on two that differ: then the field is read between its nodes."""
    for n in (31, 26):
        horizons = {"Top": plane(-1000.0, n=31), "Base": plane(-1100.0, n=n)}
        scene = gs.Scene(horizons, box=(0, 2000, 0, 1500, -1300, -800))
        one = realise(scene, 0, uncertain=[DepthError((), sd=15.0, range=900.0)])
        assert one.surface("Top").vertices[:, 2].std() > 2.0
        thickness = one.thickness("Top/Base", 100.0).values
        assert np.abs(thickness - 100.0).max() < (1e-9 if n == 31 else 0.5)


def test_points_that_are_torn_move_like_the_grid_that_they_came_from():
    world = gs.synthetic.torn("normal", n=41)
    grid = world.horizons["Top"]
    x, y = np.meshgrid(grid.easting.values, grid.northing.values)
    points = np.column_stack([x.ravel(), y.ravel(), grid.values.ravel()])
    attrs = {"units": "m", "positive": "up"}
    table = xr.Dataset({k: ("point", points[:, i], attrs if i == 2 else {})
                        for i, k in enumerate(("easting", "northing", "elevation"))})  # fmt: skip
    made = []
    for data in (grid, table):
        scene = gs.Scene({"Top": data}, world.faults, tear=True)
        moved = realise(scene, 0, uncertain=[DepthShift("Top", 25.0)])
        made.append(moved.sheets["Top"].surface.vertices)
        before = scene.sheets["Top"].surface.vertices
        assert made[-1][:, 2].mean() - before[:, 2].mean() == pytest.approx(25.0, abs=1.0)
    np.testing.assert_allclose(*made, atol=1e-9)


def test_a_default_box_is_that_of_the_base_case_and_tall_enough():
    horizons = {"Top": plane(-1000.0), "Base": plane(-1100.0)}
    scene, shift = gs.Scene(horizons), DepthShift((), Uniform(-400.0, 400.0))
    result = Result(scene, 6, [shift])
    total = [sum(one.values()) for one in result.volumes]
    np.testing.assert_allclose(total, sum(result.base.values()), rtol=1e-12)
    np.testing.assert_allclose(result.volume("Top/Base"), 100.0 * AREA, rtol=1e-12)


@pytest.mark.parametrize(
    ("uncertain", "words"),
    [
        ([], "nothing is uncertain"),
        ("wide", "uncertain is 'wide'; give a list of DepthShift"),
        ([Normal(0, 1)], r"uncertain has Normal\(.*; give a list of DepthShift"),
        ([DepthShift("Tip", 1.0)], "no horizon is called 'Tip'.*Did you mean 'Top'"),
        ([DepthShift("Top", 1.0), DepthShift("Top", 2.0)], "two uncertainties are called"),
        ([ContactLevel("OWC", shift=1.0)], "no fluid contact is called 'OWC'; there are none"),
        ([FaultShift("F2", 1.0)], "no fault is called 'F2'; there are F1"),
        ([FaultDip("F1", Normal(0.0, 60.0))], "a dip cannot change by 90 degrees"),
        ([DepthError("Top", sd=-1.0, range=500.0)], "sd is -1.0; give metres above 0"),
        ([DepthError("Top", sd=1.0, range=500.0, picks="wells")], "picks is 'wells'; give"),
        ([DepthError("Top", sd=1.0, range=500.0, picks=[[1, 2]])], "picks have shape"),
        ([DepthError("Top", sd=1.0, range=500.0, picks=[[9, 9, 999]])], "as a depth it would"),
        (
            [DepthError((), sd=1.0, range=500.0, picks=[[9, 9, -999]])],
            "cannot meet the well tops of",
        ),
    ],
)
def test_impossible_uncertainties_are_refused(uncertain, words):
    with pytest.raises(InputError, match=words):
        run_ensemble(layer_cake(faults={"F1": fault()}), 2, uncertain=uncertain)


def test_picks_outside_of_the_horizon_are_reported():
    error = DepthError("Top", 5.0, 500.0, picks=[[100.0, 100.0, -999.0], [9000.0, 0.0, -999.0]])
    with pytest.warns(gs.GeosurfWarning, match="1 of 2 picks lie outside of horizon 'Top'"):
        realise(layer_cake(), 0, uncertain=[error])


def test_sheets_are_refused_with_the_remedy():
    sheet = gs.throw_horizon(plane(-1000.0), {"F1": fault()}, {"F1": 30.0}, name="Top")
    scene = gs.Scene({"Top": sheet}, {"F1": fault()}, (0, 2000, 0, 1500, -1300, -800))
    with pytest.raises(InputError, match=r"'Top' is a sheet.*Scene\(tear=True\).*Throw"):
        Result(scene, 2, [DepthShift("Top", 1.0)])


def test_contacts_need_one_of_two_words():
    refused(InputError, "give either elevation= or shift=", ContactLevel, "OWC")
    blocks = {"OWC": {"F1+": -1050.0, "F1-": -1060.0}}
    scene = layer_cake(faults={"F1": fault()}, contacts=blocks)
    with pytest.raises(InputError, match=r"given for several blocks.*Give shift="):
        Result(scene, 2, [ContactLevel("OWC", elevation=-1040.0)])
    refused(InputError, r"give throw= \[m\], or factor=", Throw, "F1")
