"""Quantiles, convergence and tornado follow their definitions."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
import scipy.stats
import xarray as xr

from geosurf.ensemble import (
    convergence,
    juxtaposition,
    quantiles,
    report_ensemble,
    tornado,
    volumes_by,
)
from geosurf.errors import InputError

UNITS = ["above Top", "Top/Base F1- above OWC", "Top/Base F1+ above OWC", "Top/Base F1+ below OWC"]


@pytest.fixture(scope="module")
def result():
    """An ensemble of which the volumes are known functions of the parameters."""
    rng = np.random.default_rng(8)
    drawn = rng.normal(size=(300, 3))
    volume = 100.0 + np.stack(
        [drawn[:, 0], 5 * drawn[:, 1] - drawn[:, 0], np.exp(drawn[:, 0]), 0 * drawn[:, 0]], axis=1
    )
    status = np.where(np.arange(300) % 10 == 3, 2, 1).astype(np.uint8)
    volume[status == 2] = np.nan
    labels = {"zone": ["above Top", *["Top/Base"] * 3], "block": ["whole", "F1-", "F1+", "F1+"],
              "contact": ["", "above OWC", "above OWC", "below OWC"]}  # fmt: skip
    return xr.Dataset(
        {"volume": (("realization", "unit"), volume), "status": ("realization", status),
         "drawn": (("realization", "parameter"), drawn),
         "base_volume": ("unit", np.full(4, 100.0))},
        coords={"unit": UNITS, "realization": np.arange(300),
                "parameter": ["throw F1", "contact OWC", "dip F1"],
                **{key: ("unit", value) for key, value in labels.items()}},
    )  # fmt: skip


def built(result):
    return result.volume.values[result.status.values == 1]


def test_p90_is_exceeded_by_nine_tenths(result):
    found, values = quantiles(result), built(result)
    assert found.attrs["n"] == 270
    assert found.attrs["failed"] == 30
    for share in (90, 50, 10):
        exceeded = (values > found[f"P{share}"].values).mean(axis=0)
        assert np.abs(exceeded[:3] - share / 100).max() < 1 / 270
    np.testing.assert_allclose(found["mean"], values.mean(axis=0))
    np.testing.assert_allclose(found.sd, values.std(axis=0, ddof=1))
    assert list(quantiles(result, exceeded=(95.0, 99.5)))[:2] == ["P95", "P99.5"]


def test_sums_are_taken_before_quantiles(result):
    values = built(result)
    zone = volumes_by(result, "zone")
    assert zone.zone.values.tolist() == ["above Top", "Top/Base"]
    np.testing.assert_allclose(zone.sel(zone="Top/Base"), values[:, 1:].sum(axis=1))
    part = volumes_by(result, "contact").sel(contact="Top/Base above OWC")
    np.testing.assert_allclose(part, values[:, 1] + values[:, 2])
    for by in ("unit", "zone", "block", "contact"):
        np.testing.assert_allclose(volumes_by(result, by).sum(by), values.sum(axis=1))


def test_parts_of_a_zone_go_from_above_its_contacts_to_below(result):
    # the first block lies below the contact as a whole
    swapped = result.isel(unit=[3, 0, 1, 2])
    names = ["Top/Base above OWC", "Top/Base below OWC", "above Top"]
    assert volumes_by(swapped, "contact").contact.values.tolist() == names
    np.testing.assert_allclose(quantiles(swapped, "contact").base, [200.0, 100.0, 100.0])
    np.testing.assert_allclose(
        volumes_by(swapped, "contact").sel(contact=names[:2]),
        volumes_by(result, "contact").sel(contact=names[:2]),
    )


def test_convergence_ends_at_the_quantiles(result):
    found, last = convergence(result, UNITS[1]), quantiles(result).sel(unit=UNITS[1])
    assert found.n.values[[0, -1]].tolist() == [2, 270]
    for name in ("P90", "P50", "P10", "mean"):
        assert float(found[name][-1]) == pytest.approx(float(last[name]))
    error = found.standard_error.values
    assert error[-1] == pytest.approx(float(last.sd) / np.sqrt(270))


def test_a_tornado_ranks_parameters_by_their_effect(result):
    found = tornado(result, UNITS[1])
    assert found.parameter.values.tolist()[:2] == ["contact OWC", "throw F1"]
    drawn = result.drawn.values[result.status.values == 1]
    for name, column in zip(result.parameter.values, drawn.T, strict=True):
        expected = scipy.stats.spearmanr(column, built(result)[:, 1]).statistic
        assert float(found.rank_correlation.sel(parameter=name)) == pytest.approx(expected)
    first = found.isel(parameter=0)
    assert float(first.low) < found.attrs["mean"] < float(first.high)
    lone = tornado(result, UNITS[2]).isel(parameter=0)
    assert lone.parameter == "throw F1"
    assert float(lone.rank_correlation) == pytest.approx(1.0)
    nothing = tornado(result, UNITS[3]).rank_correlation
    assert (nothing == 0).all()


def test_what_cannot_be_answered_is_refused(result):
    with pytest.raises(InputError, match="by is 'layer'; it must be one of unit, zone"):
        quantiles(result, by="layer")
    with pytest.raises(InputError, match="no zone is called 'Top'; there are above Top, Top/Base"):
        tornado(result, "Top", by="zone")
    with pytest.raises(InputError, match="exceeded has 101; give percentages"):
        quantiles(result, exceeded=(101,))
    with pytest.raises(InputError, match="a tornado needs at least ten realisations"):
        tornado(result.isel(realization=slice(0, 9)), UNITS[0])
    with pytest.raises(InputError, match="convergence needs at least two realisations"):
        convergence(result.isel(realization=[0]), UNITS[0])
    with pytest.raises(InputError, match="no realisation of this ensemble has been built"):
        quantiles(result.isel(realization=[3]))


@pytest.mark.parametrize("wrong", [5, None, "store", np.zeros(3), xr.Dataset(), object()])
def test_other_objects_are_refused_in_a_sentence(result, tmp_path, wrong):
    takes = (
        quantiles, volumes_by, juxtaposition, partial(convergence, name="Top"),
        partial(tornado, name="Top"), partial(report_ensemble, folder=tmp_path / "page"),
    )  # fmt: skip
    for function in takes:
        with pytest.raises(InputError, match="takes the results of an ensemble, not"):
            function(wrong)
    for function in (convergence, tornado):
        with pytest.raises(InputError):
            function(result, wrong)
        with pytest.raises(InputError, match="by is"):
            function(result, "Top/Middle", wrong)
    if not isinstance(wrong, str | np.ndarray | xr.Dataset):
        with pytest.raises(InputError, match="takes percentages"):
            quantiles(result, exceeded=wrong)
