"""Quantiles, convergence and tornado follow their definitions."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.stats
import xarray as xr

import geosurf as gs
from geosurf.ensemble import DepthShift, Ensemble
from geosurf.errors import GeometryError, InputError
from tests.ensemble.worlds import AREA, fault, layer_cake
from tests.messages import refused

UNITS = ["above Top", "Top/Base F1- above OWC", "Top/Base F1+ above OWC", "Top/Base F1+ below OWC"]


@pytest.fixture(scope="module")
def result():
    """An ensemble of which the volumes are known functions of the parameters."""
    drawn = np.random.default_rng(8).normal(size=(300, 3))
    volume = 100.0 + np.stack(
        [drawn[:, 0], 5 * drawn[:, 1] - drawn[:, 0], np.exp(drawn[:, 0]), 0 * drawn[:, 0]], axis=1
    )
    status = np.where(np.arange(300) % 10 == 3, 2, 1).astype(np.uint8)
    volume[status == 2] = np.nan
    labels = {"zone": ["above Top", *["Top/Base"] * 3], "block": ["whole", "F1-", "F1+", "F1+"],
              "region": ["", "B", "A", "A"], "fluid": ["", "oil", "oil", "water"],
              "contact": ["", "above OWC", "above OWC", "below OWC"]}  # fmt: skip
    attrs = {"units": "m3", "long_name": "gross rock volume (GRV)"}
    return xr.Dataset(
        {"bulk": (("realisation", "unit"), volume, attrs), "status": ("realisation", status),
         "drawn": (("realisation", "parameter"), drawn),
         "base_bulk": ("unit", np.full(4, 100.0))},
        coords={"unit": UNITS, "realisation": np.arange(300),
                "parameter": ["throw F1", "contact OWC", "dip F1"],
                **{key: ("unit", value) for key, value in labels.items()}},
    )  # fmt: skip


def built(result):
    return result.bulk.values[result.status.values == 1]


def test_p90_is_exceeded_by_nine_tenths(result):
    found, values = Ensemble(result).quantiles("unit"), built(result)
    assert found.attrs["n"] == 270
    assert found.attrs["failed"] == 30
    for share in (90, 50, 10):
        exceeded = (values > found[f"P{share}"].values).mean(axis=0)
        assert np.abs(exceeded[:3] - share / 100).max() < 1 / 270
    np.testing.assert_allclose(found["mean"], values.mean(axis=0))
    np.testing.assert_allclose(found.sd, values.std(axis=0, ddof=1))
    assert list(Ensemble(result).quantiles((), exceeded=(95.0, 99.5)))[:2] == ["P95", "P99.5"]


def test_sums_are_taken_before_quantiles(result):
    values = built(result)
    zone = Ensemble(result).sums("zone")
    assert zone.zone.values.tolist() == ["above Top", "Top/Base"]
    np.testing.assert_allclose(zone.sel(zone="Top/Base"), values[:, 1:].sum(axis=1))
    part = Ensemble(result).sums(fluid="oil")
    np.testing.assert_allclose(part, values[:, 1] + values[:, 2])
    for by in ("unit", "zone", "block", "contact", "fluid", ("region", "fluid"), ()):
        dims = (by,) if isinstance(by, str) else by
        sums = Ensemble(result).sums(by).sum(dims)
        np.testing.assert_allclose(sums, values.sum(axis=1), rtol=1e-12)


def test_parts_of_a_zone_go_from_above_its_contacts_to_below(result):
    # the first block lies below the contact as a whole
    swapped, names = Ensemble(result.isel(unit=[3, 1, 2])), ["above OWC", "below OWC"]
    assert swapped.sums("contact").contact.values.tolist() == names
    np.testing.assert_allclose(swapped.quantiles("contact").base, [200.0, 100.0])
    assert swapped.sums("fluid").fluid.values.tolist() == ["oil", "water"]


def test_tables_have_a_row_for_each_realisation_and_part(result):
    ensemble, values = Ensemble(result), result.bulk.values
    frame = ensemble.to_dataframe()
    assert list(frame) == ["realisation", "region", "zone", "fluid", "bulk"]
    assert len(frame) == 300 * 4
    assert frame.attrs["units"] == {"bulk": "m3"}
    oil = frame[frame.fluid == "oil"].groupby("realisation").bulk.sum(min_count=1)
    np.testing.assert_allclose(oil, values[:, 1] + values[:, 2])
    assert len(ensemble.to_dataframe("region", region=["A", "B"])) == 300 * 2
    found = dict(ensemble.rows("bulk", region=["A", "B"]))
    labels = [(), ("oil",), ("water",), ("B",), ("A",), ("B", "oil"), ("A", "oil"), ("A", "water")]
    assert list(found) == labels
    assert found["A", "oil"]["P50"] == np.median(built(result)[:, 2])


def test_convergence_ends_at_the_quantiles(result):
    ensemble = Ensemble(result)
    found, last = ensemble.convergence(unit=UNITS[1]), ensemble.quantiles((), unit=UNITS[1])
    assert found.n.values[[0, -1]].tolist() == [2, 270]
    for name in ("P90", "P50", "P10", "mean"):
        assert float(found[name][-1]) == pytest.approx(float(last[name]))
    error = found.standard_error.values
    assert error[-1] == pytest.approx(float(last.sd) / np.sqrt(270))


def test_a_tornado_ranks_parameters_by_their_effect(result):
    ensemble = Ensemble(result)
    found = ensemble.tornado(unit=UNITS[1])
    assert found.parameter.values.tolist()[:2] == ["contact OWC", "throw F1"]
    drawn = result.drawn.values[result.status.values == 1]
    for name, column in zip(result.parameter.values, drawn.T, strict=True):
        expected = scipy.stats.spearmanr(column, built(result)[:, 1]).statistic
        assert float(found.rank_correlation.sel(parameter=name)) == pytest.approx(expected)
    first = found.isel(parameter=0)
    assert float(first.low) < found.attrs["mean"] < float(first.high)
    lone = ensemble.tornado(unit=UNITS[2]).isel(parameter=0)
    assert lone.parameter == "throw F1"
    assert float(lone.rank_correlation) == pytest.approx(1.0)
    assert (ensemble.tornado(unit=UNITS[3]).rank_correlation == 0).all()
    # without words: the rock that holds oil
    assert ensemble.tornado().identical(ensemble.tornado(fluid="oil"))


def test_what_cannot_be_answered_is_refused(result):
    ensemble = Ensemble(result)
    with pytest.raises(InputError, match="by is 'layer'; give one or several of unit, zone"):
        ensemble.quantiles(by="layer")
    with pytest.raises(InputError, match="no zone is called 'Top'; there are above Top, Top/Base"):
        ensemble.tornado(zone="Top")
    refused(InputError, "'layer' does not restrict sums; unit, zone", ensemble.tornado, layer="Top")
    refused(InputError, "of is 'stoip'; this ensemble has bulk", ensemble.tornado, "stoip")
    refused(InputError, "exceeded has 101; give percentages", ensemble.quantiles, exceeded=(101,))
    with pytest.raises(InputError, match="a tornado needs at least ten realisations"):
        Ensemble(result.isel(realisation=slice(0, 9))).tornado()
    with pytest.raises(InputError, match="convergence needs at least two realisations"):
        Ensemble(result.isel(realisation=[0])).convergence()
    with pytest.raises(InputError, match="no realisation of this ensemble has been built"):
        Ensemble(result.isel(realisation=[3])).quantiles()


# ---- Realisations that cannot be built count in no mean, no map and no quantile.
N = 23  # more than two batches


def sometimes(stream):
    """A layer cake whose top moves, and which cannot be built every third time or so."""
    number = stream.random()
    if number < 0.35:
        raise GeometryError("it cannot be built.")
    shift = DepthShift("Top", 100.0 * number)
    return gs.ensemble.realise(layer_cake(faults={"F1": fault()}), 0, uncertain=[shift])


@pytest.fixture(scope="module")
def result_failed_realisations():
    with pytest.warns(gs.GeosurfWarning, match="could not be built"):
        return gs.run_ensemble(sometimes, N, maps=500.0).data


def test_maps_are_those_of_the_realisations_that_were_built(result_failed_realisations):
    built = result_failed_realisations.status.values == 1
    assert 3 < (~built).sum() < N - 3
    zone = [name for name in result_failed_realisations.unit.values if "Top/Base" in str(name)]
    thickness = result_failed_realisations.bulk.sel(unit=zone).values.sum(axis=1)[built] / AREA
    assert np.ptp(thickness) > 1.0
    layer = next(
        name for name in result_failed_realisations.layer.values if "Top/Base" in str(name)
    )
    maps = result_failed_realisations.sel(layer=layer)
    np.testing.assert_allclose(maps.thickness_mean, thickness.mean(), rtol=1e-9)
    np.testing.assert_allclose(maps.thickness_sd, thickness.std(ddof=1), rtol=1e-6)
    np.testing.assert_allclose(maps.probability, 1.0)


def test_quantiles_and_convergence_leave_failures_out(result_failed_realisations):
    built = result_failed_realisations.status.values == 1
    volumes = Ensemble(result_failed_realisations).sums("zone").sel(zone="Top/Base").values
    kept = volumes[np.isfinite(volumes)]
    assert len(kept) == built.sum()
    found = Ensemble(result_failed_realisations).quantiles(by="zone").sel(zone="Top/Base")
    for name, share in (("P90", 0.1), ("P50", 0.5), ("P10", 0.9)):
        assert float(found[name]) == pytest.approx(np.quantile(kept, share), rel=1e-12)


def test_juxtaposition_leaves_failures_out(result_failed_realisations):
    """Both walls are alike: each zone faces itself in every model that was built."""
    built = result_failed_realisations.status.values == 1
    found = Ensemble(result_failed_realisations).juxtaposition("all")
    same = found.zone_plus.values == found.zone_minus.values
    assert same.any()
    np.testing.assert_array_equal(found.probability.values[same], 1.0)
    areas = result_failed_realisations.juxtaposed_area.values[built].mean(axis=0)
    np.testing.assert_allclose(found["mean"].values, areas, rtol=1e-12)
