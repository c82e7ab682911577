"""The Drogon field: points that were carried past dipping faults, faults from sticks."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs

# part of the field, or some faults, are left out on purpose; the warnings have tests of their own
pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")

HORIZONS = ("TopVolantis", "TopTherys", "TopVolon", "BaseVolantis")


@pytest.fixture(scope="module")
def field(shared, drogon_sticks):
    """Points of the horizons, and sticks of the faults, by name."""
    folder = shared / "data" / "drogon"
    points = {
        name: gs.read_points(
            folder / "horizons_poi" / f"{name}.poi", positive="down", length_unit="m"
        )
        for name in HORIZONS
    }
    return points, drogon_sticks


@pytest.fixture(scope="module")
def sheets(field):
    """All horizons, torn by all faults, which a scene makes as long as all of them need."""
    points, sticks = field
    return gs.Scene({name: points[name] for name in HORIZONS}, sticks, tear=True).sheets


def test_hidden_data_are_met(sheets):
    for sheet in sheets.values():
        report = sheet.report
        assert report.tips == report.declared_tips == 10
        assert report.holdout_misfit["median"] < 0.46
        assert report.holdout_misfit["p95"] < 5.0
        assert report.misfit["mean"] < 0.01


def test_throws_agree_between_the_horizons(sheets):
    largest = {
        name: {fault: np.nanmax(cut.throw) for fault, cut in sheet.cuts.items()}
        for name, sheet in sheets.items()
    }
    bounds = {
        "F1": (60, 70), "F2": (65, 90), "F3": (60, 77), "F4": (42, 55), "F5": (58, 72),
        "F6": (38, 45),
    }  # fmt: skip
    for fault, (low, high) in bounds.items():
        for name in HORIZONS:
            assert low < largest[name][fault] < high


def test_the_acute_wedge_is_reported_as_a_place_and_has_no_false_throw(sheets):
    """F6 ends on F2 at both ends, in wedges thinner than twice the trim."""
    for sheet in sheets.values():
        place = sheet.report.extrapolation[0]
        assert place["fault"] in ("F2", "F6")
        assert 8 <= place["cells"] <= 14
        assert np.hypot(place["place"][0] - 463790, place["place"][1] - 5932400) < 150
        cut = sheet.cuts["F6"]
        assert np.nanmin(cut.throw) > -15
        assert np.nanmax(cut.throw[cut.along < 500]) < 32
        assert cut.ends == ("branch of F2", "branch of F2")


def test_it_does_not_matter_whether_faults_were_extended_before(field, sheets):
    points, sticks = field
    sides = dict.fromkeys(sticks, ("up", "down"))
    scene = gs.Scene({name: points[name] for name in HORIZONS}, sticks, tear=True, extend=sides)
    for name, sheet in scene.sheets.items():
        for fault, cut in sheet.cuts.items():
            other = sheets[name].cuts[fault]
            assert other.ends == cut.ends
            np.testing.assert_allclose(other.throw, cut.throw, atol=0.02)
