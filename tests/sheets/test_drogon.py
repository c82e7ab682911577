"""The Drogon field: points that were carried past dipping faults, faults from sticks."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs


def taller(stick: np.ndarray) -> np.ndarray:
    """A stick drawn out up and down by a quarter of its height, 20 m at least."""
    reach = max(0.25 * abs(stick[0, 2] - stick[-1, 2]), 20.0)
    up, down = stick[0] - stick[1], stick[-1] - stick[-2]
    ends = [stick[0] + up * reach / abs(up[2]), stick[-1] + down * reach / abs(down[2])]
    return np.vstack([ends[0], stick, ends[1]])


@pytest.fixture(scope="module")
def drogon(shared):
    """Points of the uppermost horizon, and the faults of the field by name."""
    folder = shared / "data" / "drogon"
    faults = {}
    for path in sorted((folder / "fault_sticks_pol").glob("F*.pol")):
        sticks = gs.read_fault(path, positive="down", units="m")
        tall = gs.FaultSticks(path.stem, tuple(taller(stick) for stick in sticks.sticks))
        faults[path.stem] = gs.triangulate_fault(tall, name=path.stem)
    path = folder / "horizons_poi" / "TopVolantis.poi"
    return gs.read_points(path, positive="down", units="m"), faults


def test_top_is_torn_by_five_faults_and_meets_hidden_data(drogon):
    points, faults = drogon
    five = {name: fault for name, fault in faults.items() if name != "F6"}
    sheet = gs.tear_horizon(points, five, name="TopVolantis")
    report = sheet.report
    assert report.tips == report.declared_tips == 10
    assert sum(report.sign_changes.values()) == 0
    assert report.hidden["median"] < 0.45
    assert report.hidden["p95"] < 5.0
    for name, low, high in (("F1", 60, 70), ("F3", 60, 70), ("F4", 42, 50), ("F5", 58, 70)):
        assert low < np.nanmax(sheet.cuts[name].throw) < high


def test_a_branch_too_acute_to_close_is_named_with_its_place(drogon):
    points, faults = drogon
    with pytest.raises(gs.errors.GeometryError, match=r"cannot be closed.*first at \(easting 46"):
        gs.tear_horizon(points, faults, name="TopVolantis")
