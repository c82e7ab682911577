"""Fluids in place in ensembles: those that each realisation has as a scene of its own."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.cli import main
from geosurf.ensemble import ContactLevel, DepthShift, Discrete, Normal, Uniform
from geosurf.errors import InputError
from geosurf.scenario import read_scenario
from tests.ensemble.worlds import AREA, fault, layer_cake, plane
from tests.planes import scenario_tables

GIVEN = {
    "net_to_gross": Uniform(0.5, 0.9),
    "porosity": {"oil": Normal(0.25, 0.01), "elsewhere": 0.2},
    "water_saturation": Discrete([0.2, 0.3]),
    "formation_volume_factor": 1.25,
}
UNCERTAIN = [ContactLevel("OWC", shift=Uniform(-20, 20)), DepthShift("Top", Uniform(-9, 9))]


def at(numbers):
    """The arguments of `Scene.volumetrics` of one realisation."""
    porosity = {"oil": numbers["porosity oil"], "elsewhere": 0.2}
    keys = ("net_to_gross", "water_saturation")
    return {**GIVEN, "porosity": porosity, **{key: numbers[key] for key in keys}}


@pytest.fixture(scope="module")
def scene():
    return layer_cake(faults={"F1": fault()}, contacts={"OWC": -1050.0})


@pytest.fixture(scope="module")
def ensemble(scene):
    return gs.run_ensemble(
        scene, 12, uncertain=UNCERTAIN, volumetrics=GIVEN, workers=1, progress=False
    )


def test_each_realisation_has_what_its_scene_has(scene, ensemble):
    drawn = ensemble.data.drawn.to_pandas()
    table = ensemble.to_dataframe().set_index(["realisation", "region", "zone", "fluid"])
    for k in (0, 7):
        one = gs.ensemble.realise(scene, k, uncertain=UNCERTAIN)
        found = one.volumetrics(**at(drawn.loc[k])).to_dataframe()
        sums = found.groupby(["region", "zone", "fluid"]).sum(numeric_only=True)
        for name in ensemble.columns:
            np.testing.assert_allclose(table.loc[k][name], sums[name], rtol=1e-12)
    # closed form: a layer cake above a level
    top, level = -1000.0 + drawn["depth shift Top"], -1050.0 + drawn["contact OWC"]
    rock = AREA * (top - level) * drawn.net_to_gross * drawn["porosity oil"]
    stoiip = rock * (1.0 - drawn.water_saturation) / 1.25
    np.testing.assert_allclose(ensemble.sums(of="stoiip"), stoiip, rtol=1e-9)


def test_the_base_case_has_medians(scene, ensemble):
    assert ensemble.quantiles(()).base == pytest.approx(
        scene.volumetrics(
            net_to_gross=0.7,
            porosity={"oil": 0.25, "elsewhere": 0.2},
            water_saturation=0.2,
            formation_volume_factor=1.25,
        ).stoiip.sum().item(), rel=1e-12
    )  # fmt: skip
    assert set(ensemble.tornado().parameter.values) >= {"net_to_gross", "porosity oil"}
    assert "STOIIP [million Sm³]" in str(ensemble)
    assert ensemble.answers == [("stoiip", {})]


def test_sums_of_regions_zones_and_fluids_are_those_of_units(ensemble):
    for of in ensemble.columns:
        total = ensemble.sums((), of).values
        for by in ("region", "zone", "fluid", "unit", ("region", "zone", "fluid")):
            sums = ensemble.sums(by, of)
            whole = sums.values.reshape(len(total), -1).sum(axis=1)
            np.testing.assert_allclose(whole, total, rtol=1e-12)
        rows = ensemble.to_dataframe().groupby("realisation")[of].sum()
        np.testing.assert_allclose(rows, total, rtol=1e-12)


def test_maps_are_integrated_in_each_realisation(scene):
    trend = plane(0.2).astype(float)
    trend = trend + 5e-5 * trend.easting
    trend.attrs.clear()
    ensemble = gs.run_ensemble(
        scene, 3, uncertain=UNCERTAIN, workers=1, progress=False,
        volumetrics={"net_to_gross": Uniform(0.5, 0.9), "porosity": trend, "units": "field"},
    )  # fmt: skip
    number = float(ensemble.data.drawn.sel(parameter="net_to_gross")[2])
    one = gs.ensemble.realise(scene, 2, uncertain=UNCERTAIN)
    found = one.volumetrics(net_to_gross=number, porosity=trend, units="field")
    assert ensemble.sums(of="pore")[2] == pytest.approx(found.pore.sum().item(), rel=1e-12)
    assert ensemble.data.pore.attrs["units"] == "bbl"
    assert ensemble.answers[0][0] == "pore"


def test_regions_keep_the_names_of_the_base_case():
    """The larger block is A in the base case, and stays A where the other one is larger."""
    scene = layer_cake(faults={"F1": fault(x=1050.0)})
    west = scene.units["Top/Base F1-"].region
    shift = gs.ensemble.FaultShift("F1", Uniform(-400.0, 400.0))
    ensemble = gs.run_ensemble(scene, 20, uncertain=[shift], workers=1, progress=False)
    assert set(ensemble.data.region.values) == {"A", "B", ""}
    sums = ensemble.sums("region")
    first = sums.sel(region="A") > sums.sel(region="B")
    assert first.any()
    assert not first.all()
    np.testing.assert_allclose(
        sums.sel(region=west), ensemble.sums(unit="Top/Base F1-"), rtol=1e-12
    )


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (5, "give the arguments of Scene.volumetrics"),
        ({"porosty": 0.2}, "its keys are .* Did you mean 'porosity'"),
        ({"porosity": 0.2}, "needs net_to_gross"),
        ({"net_to_gross": Normal(0.8, 0.1)}, r"net_to_gross is from 0.\d+ to 1.\d+; it must be"),
        ({"net_to_gross": {"F9+": 0.8}}, "no unit is called so"),
        ({"net_to_gross": 1.0, "units": "SI"}, "it must be one of metric, field"),
        ({"net_to_gross": xr.DataArray([1.0])}, "net_to_gross"),
    ],
)
def test_what_cannot_be_is_refused_before_it_starts(scene, given, words):
    with pytest.raises(InputError, match=words):
        gs.run_ensemble(scene, 2, uncertain=UNCERTAIN, volumetrics=given, progress=False)
    with pytest.raises(InputError, match="one scene has one value"):
        scene.volumetrics(net_to_gross=Uniform(0.5, 0.9))


def test_scenarios_state_them(tmp_path):
    path = tmp_path / "s.toml"
    tables = scenario_tables(tmp_path, {"Top": plane(-1000.0), "Base": plane(-1100.0)})
    path.write_text(
        tables + '[[contacts]]\nname = "OWC"\nelevation_m = -1050.0\n[volumetrics]\n'
        "net_to_gross = {normal = [0.8, 0.1, 0.5, 1.0]}\n"
        "porosity = {oil = {uniform = [0.2, 0.3]}, elsewhere = 0.2}\n"
        "water_saturation = 0.2\nformation_volume_factor = 1.25\n"
    )
    assert read_scenario(path).volumetrics.net_to_gross == Normal(0.8, 0.1, 0.5, 1.0)
    for wrong in ("{uniform = [0.3, 0.2]}", "{normal = [0.8]}", "{lognormal = [0.8, 0.1]}"):
        words = ["validate", str(path), "--set", f"volumetrics.porosity={wrong}"]
        assert main(words) == 2
