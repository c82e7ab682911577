"""How well sheets meet worlds with several faults: laws, and networks whose cut-offs are known."""

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from benchmarks.random_networks import heights, random_network
from benchmarks.torn_networks import run_network
from geosurf.synthetic.torn_horizon import Fault
from tests.sheets.table import CELL, measure


def two_walls(apart: float, z):
    """Two upright faults, some cells apart, with heights z(x, y) and steps of 20 and 30 m."""
    n = 41
    x, y = np.meshgrid(np.arange(n) * CELL, np.arange(n) * CELL)
    at = [CELL * (20.0 + sign * 0.5 * apart) for sign in (-1, 1)]
    grid = z(x, y) - 20.0 * (x > at[0]) - 30.0 * (x > at[1])
    horizon = xr.DataArray(
        grid, {"northing": y[:, 0], "easting": x[0]}, attrs={"units": "m", "positive": "up"}
    )
    faults = {}
    for name, here in zip(("F1", "F2"), at, strict=True):
        corners = [[here, y0, z0] for y0 in (-100.0, 1100.0) for z0 in (-2300.0, -1200.0)]
        faults[name] = gs.TriSurface(name, "fault", np.array(corners), [[0, 2, 3], [0, 3, 1]])
    return horizon, faults


@pytest.mark.parametrize("trim", [0.4, 1.0])
def test_a_plane_between_two_faults_three_cells_apart_is_met(trim):
    """A trim of one cell leaves one column of data between them: enough along the faults."""
    slope = 0.2 if trim < 0.5 else 0.0  # across it, one column shows no slope
    horizon, faults = two_walls(3.0, lambda x, y: -1800.0 + slope * x + 0.1 * y)
    sheet = gs.tear_horizon(horizon, faults, name="Top", trim=trim)
    for name, throw in (("F1", 20.0), ("F2", 30.0)):
        assert np.abs(np.abs(sheet.cuts[name].throw) - throw).max() < 1e-3


@pytest.mark.parametrize(("number", "name", "trim"), [(49, "F1", 3.0), (14, "F1", 3.0)])
def test_throw_dies_as_a_crack_next_to_other_faults(number, name, trim):
    """Other faults around its tips do not hide from a fault how its own throw dies."""
    rng = np.random.default_rng([1, number])
    rng.integers(6)
    family = "mixed" if number == 49 else "parallel"
    world = random_network(family, rng, 1)
    sheet = gs.tear_horizon(world.horizon, world.faults, name="Top", trim=trim)
    found = measure(world, sheet, name)
    assert found.lost == 0
    assert found.position.max() < 0.1
    assert found.throw.mean() < 1.0
    assert found.throw.max() < 5.0


def test_a_branch_leaves_no_step_past_the_tips_of_its_main_fault():
    """The truth of a network is smooth where it has no fault: third differences stay small."""
    main = Fault(1000.0, 1000.0, strike=90.0, half=400.0, throw=50.0, wave=0.0)
    branch = Fault(1000.0, 1000.0, strike=10.0, half=500.0, throw=50.0, branch=("F1", 1))
    x, y = np.meshgrid(1475.0 + np.arange(8) * CELL, 800.0 + np.arange(17) * CELL)
    z = heights({"F1": main, "F2": branch}, x, y, 0)
    assert np.abs(np.diff(z, 3, axis=0)).max() < 1.0


def test_a_node_between_both_cutoffs_does_not_shorten_its_tear():
    """Near a tip of F2 such a node lies centimetres past the fault; throw was 6.2 % off there."""
    outcome = run_network(113, seed=1)
    assert not outcome.remedies
    assert outcome.errors["F2"][2.0].worst < 3.0
