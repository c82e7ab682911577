"""The throw of a sheet is compared with what its data show, and named where they differ."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import geosurf as gs
from benchmarks.random_networks import random_network


def torn(data, faults, **options):
    """A sheet, and its warnings of throw by fault."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gs.errors.GeosurfWarning)
        sheet = gs.tear_horizon(data, faults, name="Top", positive="up", **options)
    return sheet, {w.subject: w for w in sheet.warnings if w.kind == "throw not as data"}


@pytest.mark.parametrize("kind", ["normal", "reverse", "Y", "X"])
def test_law_data_show_the_true_throw_within_twice_their_spread(kind):
    """On the hanging wall minus footwall of points that were never smeared."""
    world = gs.synthetic.torn(kind, 81, smear=2)
    truth, _ = torn(world.truth["scattered"](8000, 0.0, 3), world.faults)
    sheet, named = torn(world.horizons["Top"], world.faults)
    assert not named
    for fault, audit in sheet.report.throw.items():
        true = truth.report.throw[fault]
        near = np.hypot(*(audit.stations[:, None] - true.stations)[..., :2].T).argmin(axis=0)
        off = np.abs(audit.data - true.sheet[near])
        shown = np.isfinite(off)
        assert shown.mean() > 0.4
        assert (off <= 2.0 * audit.spread + 1.0)[shown].mean() > 0.95


@pytest.mark.parametrize("kind", ["normal", "reverse", "X"])
def test_a_trim_that_loses_throw_is_named_and_its_remedy_works(kind):
    world = gs.synthetic.torn(kind, 81, smear=3)
    faults = list(world.faults)
    sheet, named = torn(world.horizons["Top"], world.faults, trim=1.5)
    assert list(named) == faults
    for fault, warning in named.items():
        audit = sheet.report.throw[fault]
        shown = np.isfinite(audit.data)
        assert audit.differs.sum() > 0.8 * shown.sum()
        assert f"Tear with a trim of {audit.trim:g} cells for {fault!r}" in warning.remedy
        assert np.allclose(warning.place, audit.stations[audit.worst])
    trims = {fault: audit.trim for fault, audit in sheet.report.throw.items()}
    assert not torn(world.horizons["Top"], world.faults, trim=trims)[1]


@pytest.mark.parametrize(("family", "smear"), [("relay", 0), ("lambda", 1), ("X", 2)])
def test_random_networks_are_not_named_where_they_are_right(family, smear):
    network = random_network(family, np.random.default_rng([3, smear]), smear)
    sheet, named = torn(network.horizon, network.faults)
    assert not named
    shown = [np.isfinite(audit.data).mean() for audit in sheet.report.throw.values()]
    assert np.mean(shown) > 0.2


def test_a_scene_lists_the_throw_of_model_and_data():
    world = gs.synthetic.torn("X", 81, smear=2)
    for trim, differs in (("auto", False), (1.5, True)):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", gs.errors.GeosurfWarning)
            scene = gs.Scene(world.horizons, world.faults, tear=trim)
            found = scene.throw_audit().sel(horizon="Top")
        assert (found.differs > 0).values.all() == differs
        assert (np.abs(found.off) > 10.0).values.all() == differs
        if not differs:
            assert (np.abs(found.model - found.data) < found.spread).values.all()
    flat = gs.synthetic.tilted_planes()
    with pytest.raises(gs.errors.InputError, match="no horizon is torn"):
        gs.Scene(flat.horizons, flat.faults, flat.box).throw_audit()


def test_no_trend_is_drawn_across_another_fault():
    """Two faults four cells apart: between them there is nothing that a trend could be drawn to."""
    world = gs.synthetic.torn("parallel", 81, smear=0)
    sheet, named = torn(world.horizons["Top"], world.faults)
    assert not named
    inside = [
        np.hypot(*(a.stations[:, :2] - 1000.0).T) < 500.0 for a in sheet.report.throw.values()
    ]
    for audit, mine in zip(sheet.report.throw.values(), inside, strict=True):
        assert mine.sum() > 20
        assert np.isnan(audit.data[mine]).all()
