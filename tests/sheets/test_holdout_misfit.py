"""Hidden data are compared with the sheet of their own wall, also where walls overlap."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import geosurf as gs
from geosurf.sheets.report import describe
from geosurf.sheets.report.describe import holdout_misfit

# overlap and gap, faults that cross, and none of either
KINDS = ("normal", "vertical", "X", "scissors", "reverse", "thrust")


@pytest.fixture
def parts(monkeypatch):
    """Function that tears points: the report, and what its misfit was taken from."""

    def make(kind: str, scattered: bool):
        told = []

        def seen(*args):
            told.append(args)
            return holdout_misfit(*args)

        monkeypatch.setattr(describe, "holdout_misfit", seen)
        world = gs.synthetic.torn(kind, 61)
        points = world.truth["scattered"](3700) if scattered else world.truth["points"]
        sheet = gs.tear_horizon(points, world.faults, name="Top", trim=1.0, positive="up")
        return sheet.report, told[0]

    return make


@pytest.mark.parametrize("scattered", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_exact_points_are_met_on_both_walls(parts, kind, scattered):
    """The other wall is 40 to 100 m away, and a mixture of both up to half of that."""
    report, (picks, near, built) = parts(kind, scattered)
    state = built.state
    misfit = holdout_misfit(picks, near, built)
    assert report.holdout_misfit["max"] == misfit.max() < 3.0
    assert report.holdout_misfit["p95"] < 0.6
    assert report.holdout_misfit["median"] < 0.3
    if scattered:
        assert len(misfit) > 0.8 * (report.n_ignored - len(state.in_gap) - len(state.beyond))


@pytest.mark.parametrize("kind", ["vertical", "reverse", "thrust"])
def test_walls_that_are_swapped_are_seen(parts, kind):
    report, (picks, near, built) = parts(kind, True)
    swapped = [replace(fault, side=-fault.side) for fault in near]
    misfit = holdout_misfit(picks, swapped, built)
    assert len(misfit) > 20
    assert np.median(misfit) > 20.0 > 50.0 * report.holdout_misfit["median"]
