"""Random networks and their judge: against worlds with one sheet for each combination of sides."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from benchmarks.random_networks import network_of
from benchmarks.torn_networks import FAMILIES, Errors, Outcome, networks_table, run_network

pytestmark = pytest.mark.long


@pytest.mark.parametrize("kind", ["Y", "acute X"])
def test_a_network_is_the_world_of_the_same_faults(kind):
    """There every combination of sides has a sheet; here sides are chosen place by place."""
    world = gs.synthetic.torn(kind, 81)
    network = network_of(kind, world.truth["faults"], world.faults, (2000.0, 2000.0), smear=1)
    assert abs(network.horizon.values - world.horizons["Top"].values).max() < 1e-9
    for key, line in world.truth["cutoffs"].items():
        mine = network.truth["cutoffs"][key]
        assert len(mine) == len(line)
        gap = np.hypot(*(mine[:, None, :2] - line[None, :, :2]).transpose(2, 0, 1)).min(axis=1)
        assert gap.max() < 1e-6


def test_a_network_is_judged_and_listed():
    found = run_network(FAMILIES.index("X"), seed=1)
    assert found.is_built
    assert all(errors[2.0].is_met for errors in found.errors.values())
    lost = Errors(position=0.0, mean=0.2, worst=0.4, lost=1)
    short = Outcome(7, "relay", 2.0, 2, errors={"F1": {2.0: lost}})
    table = networks_table([found, short, Outcome(8, "Y", 2.0, 2, refused="open at 'F1'")])
    assert "| **all** | 3 | 2 | 0 | 1 | 0 | 6 | " in table
    assert "2 of 3 |" in table  # a tear that ends early is wrong, however small its error
    assert "REFUSED open at 'F1'" in table
