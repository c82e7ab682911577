"""Attempts look at a window around holes, and find there what the whole sheet has there."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from benchmarks.random_networks import random_network
from benchmarks.torn_networks import FAMILIES, TRIMS
from geosurf.sheets.mesh import build, window

pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")


@pytest.fixture(autouse=True)
def windows_of_small_sheets(monkeypatch):
    monkeypatch.setattr(window, "FEWEST", 0)


def network(number):
    """A random network of `benchmarks.torn_networks`, and its trim."""
    rng = np.random.default_rng([1, number])
    trim, smear = TRIMS[int(rng.integers(len(TRIMS)))]
    return random_network(FAMILIES[number % len(FAMILIES)], rng, smear), trim


def torn(number):
    world, trim = network(number)
    return gs.tear_horizon(world.horizon, world.faults, name="Top", trim=trim)


def holes(cut):
    return [(*np.round(hole.place, 3), round(hole.length, 3)) for hole in cut.holes]


@pytest.mark.parametrize("number", [2, 4])  # an X, and two parallel faults
def test_a_window_shows_the_holes_of_the_whole_sheet(number, monkeypatch):
    cut, shares = build._cut, []

    def both(setting, state, repairs, mesh, part=None):
        whole = cut(setting, state, repairs, mesh, part)
        if part is not None or not whole.is_open:
            return whole
        edges = [*whole.cut.leaks, *whole.cut.dead_ends]
        near = window.Window.around(whole.cut.holes, edges, whole.torn, setting.picks.frame, None)
        found = cut(setting, state, repairs, mesh, near)
        assert holes(found.cut) == holes(whole.cut)
        assert [*found.cut.leaks, *found.cut.dead_ends] == edges
        shares.append(len(found.cut.parts[0].corners) / size(whole.cut))
        return whole

    monkeypatch.setattr(build, "_cut", both)
    sheet = torn(number)
    assert shares
    assert max(shares) < 0.6
    # the whole sheet is cut at last: without windows it is the same one
    monkeypatch.setattr(build, "_cut", cut)
    monkeypatch.setattr(window, "MOST", -1.0)
    for one, two in zip(arrays(sheet), arrays(torn(number)), strict=True):
        assert one.tobytes() == two.tobytes()


def size(cut):
    return sum(len(part.corners) for part in cut.parts)


def arrays(sheet):
    return [sheet.copies, sheet.ghosts, sheet.outer, sheet.lattice.elevation]


def test_a_hole_that_no_window_shows_is_found_at_last(monkeypatch):
    """A window in which nothing counts as open: the whole sheet decides."""
    expected = torn(2)
    monkeypatch.setattr(window.Window, "has", lambda self, nodes: np.zeros(len(nodes), dtype=bool))
    found = torn(2)
    assert arrays(found)[0].tobytes() == arrays(expected)[0].tobytes()
