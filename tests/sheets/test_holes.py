"""Holes by a minimum cut: against all cuts of small networks; remedies of sheets that stay open."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import geosurf as gs
from geosurf.sheets.mesh.cut import _minimum_cut
from geosurf.synthetic.torn_horizon import Fault
from tests.sheets.table import measure


@st.composite
def networks(draw):
    """Up to eight triangles, with links of whole lengths, some sources and some sinks."""
    n = draw(st.integers(2, 8))
    every = [(a, b) for a in range(n) for b in range(a)]
    pairs = draw(st.lists(st.sampled_from(every), min_size=1, max_size=12, unique=True))
    length = draw(st.lists(st.integers(1, 5), min_size=len(pairs), max_size=len(pairs)))
    kinds = np.array(draw(st.lists(st.sampled_from("abc"), min_size=n, max_size=n)))
    return np.array(pairs), np.array(length, dtype=float), kinds == "a", kinds == "b"


def least_by_trial(pairs, length, source, sink):
    """The smallest sum of links between two sets that part sources from sinks."""
    best = np.inf
    for sides in product([False, True], repeat=len(source)):
        side = np.array(sides)
        if side[source].all() and not side[sink].any():
            best = min(best, length[side[pairs[:, 0]] != side[pairs[:, 1]]].sum())
    return best


@given(networks())
def test_the_cut_is_the_least_of_all(network):
    pairs, length, source, sink = network
    cut, before = _minimum_cut(*network)
    assert length[cut].sum() == least_by_trial(*network)
    left = np.delete(pairs, cut, axis=0)
    reached = source.copy()
    for _ in range(len(source)):
        for a, b in left:
            reached[[a, b]] = reached[a] or reached[b]
    assert not (reached & sink).any()
    assert before.tolist() == np.flatnonzero(reached).tolist()


@pytest.fixture(scope="module")
def low():
    """A fault of 60 m of throw that was picked 6 m short of the deeper cut-off, and the truth."""
    world = gs.synthetic.torn("through", n=61)
    (fault,) = (gs.triangulate_fault(one, name=name) for name, one in world.faults.items())
    deepest = min(line[:, 2].min() for line in world.truth["cutoffs"].values())
    return world, fault, deepest


def clipped(fault, lowest):
    """A plane fault above a level: what is below it is moved up the dip."""
    points = fault.vertices.copy()
    normal = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][2]
    dip = np.cross(normal, [-normal[1], normal[0], 0.0])
    below = np.maximum(lowest - points[:, 2], 0.0)
    return gs.TriSurface(
        fault.name, "fault", points + below[:, None] * dip / dip[2], fault.triangles
    )


def test_remedies_are_warned_of_and_listed(low):
    world, fault, deepest = low
    with pytest.warns(
        gs.GeosurfWarning, match=r"leaves fault .* extended up its dip by .* and down its dip by"
    ):
        sheet = gs.tear_horizon(
            world.horizons["Top"], [clipped(fault, deepest + 6.0)], name="Top", trim=2
        )
    assert {one.kind for one in sheet.report.remedies} == {"fault extended"}
    assert sheet.faults[0].bounds[4] < deepest
    whole = gs.tear_horizon(world.horizons["Top"], [fault], name="Top", trim=2)
    assert whole.report.remedies == ()
    throw = np.nanmax(np.abs(sheet.cuts[fault.name].throw))
    assert throw == pytest.approx(np.nanmax(np.abs(whole.cuts[fault.name].throw)), abs=0.5)


def test_trims_are_chosen_by_fault():
    world = gs.synthetic.torn("parallel", n=81, smear=2)
    names = list(world.faults)
    top = world.horizons["Top"]
    auto = gs.tear_horizon(top, world.faults, name="Top").report
    assert set(auto.trims) == set(names)
    assert all(1.5 <= trim <= 4.0 for trim in auto.trims.values())
    given_one = gs.tear_horizon(top, world.faults, name="Top", trim={names[0]: 3}).report
    assert given_one.trims == {**auto.trims, names[0]: 3.0}
    same = gs.tear_horizon(top, world.faults, name="Top", trim=3.0)
    by_name = gs.tear_horizon(top, world.faults, name="Top", trim=dict.fromkeys(names, 3.0))
    np.testing.assert_array_equal(same.surface.vertices, by_name.surface.vertices)


@pytest.mark.parametrize("shift", [(0.0, 0.0), (10.0, 7.0)])
def test_faults_that_die_on_both_sides_of_their_crossing_need_no_remedy(shift):
    """At a tip a torn copy may have real corners only, on the far side of the fault, too."""
    x, y = np.add(850.0, shift)
    faults = {
        "F1": Fault(x, y, strike=24.0, dip=62.0, half=500.0, throw=58.0),
        "F2": Fault(x, y, strike=277.0, dip=84.0, half=440.0, throw=30.0),
    }
    world = gs.synthetic.torn(faults, 69)
    sheet = gs.tear_horizon(world.horizons["Top"], world.faults, trim=2.25)
    assert sheet.report.remedies == ()
    assert all(measure(world, sheet, name).throw.max() < 5.0 for name in faults)
