"""Realisations that cannot be built count in no mean, no map and no quantile."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.ensemble import DepthShift, Ensemble
from geosurf.errors import GeometryError
from tests.ensemble.worlds import AREA, fault, layer_cake

N = 23  # more than two batches


def sometimes(stream):
    """A layer cake whose top moves, and which cannot be built every third time or so."""
    number = stream.random()
    if number < 0.35:
        raise GeometryError("it cannot be built.")
    shift = DepthShift("Top", 100.0 * number)
    return gs.ensemble.realise(layer_cake(faults={"F1": fault()}), 0, uncertain=[shift])


@pytest.fixture(scope="module")
def result():
    with pytest.warns(gs.GeosurfWarning, match="could not be built"):
        return gs.run_ensemble(sometimes, N, maps=500.0).data


def test_maps_are_those_of_the_realisations_that_were_built(result):
    built = result.status.values == 1
    assert 3 < (~built).sum() < N - 3
    zone = [name for name in result.unit.values if "Top/Base" in str(name)]
    thickness = result.bulk.sel(unit=zone).values.sum(axis=1)[built] / AREA
    assert np.ptp(thickness) > 1.0
    layer = next(name for name in result.layer.values if "Top/Base" in str(name))
    maps = result.sel(layer=layer)
    np.testing.assert_allclose(maps.thickness_mean, thickness.mean(), rtol=1e-9)
    np.testing.assert_allclose(maps.thickness_sd, thickness.std(ddof=1), rtol=1e-6)
    np.testing.assert_allclose(maps.probability, 1.0)


def test_quantiles_and_convergence_leave_failures_out(result):
    built = result.status.values == 1
    volumes = Ensemble(result).sums("zone").sel(zone="Top/Base").values
    kept = volumes[np.isfinite(volumes)]
    assert len(kept) == built.sum()
    found = Ensemble(result).quantiles(by="zone").sel(zone="Top/Base")
    for name, share in (("P90", 0.1), ("P50", 0.5), ("P10", 0.9)):
        assert float(found[name]) == pytest.approx(np.quantile(kept, share), rel=1e-12)


def test_juxtaposition_leaves_failures_out(result):
    """Both walls are alike: each zone faces itself in every model that was built."""
    built = result.status.values == 1
    found = Ensemble(result).juxtaposition("all")
    same = found.zone_plus.values == found.zone_minus.values
    assert same.any()
    np.testing.assert_array_equal(found.probability.values[same], 1.0)
    areas = result.juxtaposed_area.values[built].mean(axis=0)
    np.testing.assert_allclose(found["mean"].values, areas, rtol=1e-12)
