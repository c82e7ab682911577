"""Remedies of sheets that stay open: faults left out, holes by a minimum cut, longer faults."""

from __future__ import annotations

from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import geosurf as gs
from geosurf.sheets.lattice import picks
from geosurf.sheets.mesh.cut import _minimum_cut
from geosurf.sheets.mesh.tear_ends import extended
from geosurf.sheets.report.remedies import _remedy_at_branch, longer_by
from geosurf.synthetic.torn_horizon import Fault
from tests.planes import between
from tests.sheets.junctions import CELL, junction, misses
from tests.sheets.table import measure

pytestmark = pytest.mark.filterwarnings("ignore::geosurf.GeosurfWarning")


def folded(throw, dip, n=73):
    """A horizon with folds of 15 m, torn at one fault; and its faults."""
    fault = Fault(900.0, 900.0, strike=30.0, dip=dip, half=500.0, throw=throw)
    world = gs.synthetic.torn({"F1": fault}, n)
    x, y = np.meshgrid(np.arange(n), np.arange(n))
    top = world.horizons["Top"] + 15.0 * np.sin(x / 3.1) * np.cos(y / 4.3)
    return top.assign_attrs(world.horizons["Top"].attrs), world.faults


@pytest.mark.parametrize("dip", [15.0, 89.0])
def test_a_fault_without_throw_is_no_reason_to_refuse(dip, monkeypatch):
    """Where the data show no throw, a tear that does not close is left out, and listed."""
    top, faults = folded(0.01, dip)
    exact = gs.tear_horizon(top, faults, name="Top", trim=1.5)  # fourth differences: none left out
    assert np.nanmax(np.abs(exact.cuts["F1"].throw), initial=0.0) < 2.5
    monkeypatch.setattr(picks, "FAINT", 0.0)  # third differences, as for data with noise
    sheet = gs.tear_horizon(top, faults, name="Top", trim=1.5)
    assert np.nanmax(np.abs(sheet.cuts["F1"].throw), initial=0.0) < 2.5
    left_out = [one for one in sheet.report.remedies if one.kind == "tear left out"]
    assert all("the data show no throw there" in one.effect for one in left_out)
    assert dip > 45.0 or left_out
    assert np.abs(sheet.lattice.elevation - top.values).max() < 2.5


def test_a_fault_half_outside_the_data_is_torn_inside():
    world = gs.synthetic.torn("normal", 61)
    top = world.horizons["Top"]
    whole = gs.tear_horizon(top, world.faults, name="Top", trim=2).cuts["F1"]
    middle = whole.stations[len(whole.stations) // 2, 0]
    half = gs.tear_horizon(top.where(top.easting > middle), world.faults, name="Top", trim=2)
    cut = half.cuts["F1"]
    inside = np.flatnonzero(cut.stations[:, 0] > middle + 150.0)
    assert len(inside) > 5

    # the same places along the fault; stations of the two sheets are up to 10 m apart
    order = np.argsort(whole.stations[:, 0])
    east = cut.stations[inside, 0]
    same = np.interp(east, whole.stations[order, 0], whole.throw[order])
    miss = np.abs(cut.throw[inside] - same)
    assert np.isnan(miss).sum() <= 1  # at the tip
    assert np.nanmax(miss) < 1.5
    assert np.nanmax(miss[east < east.max() - 50.0]) < 0.5  # two cells from the tip, of 60 m


def test_both_faults_of_a_junction_are_extended():
    """The branch stops a third of a cell short of its main fault, and both end 5 m too high."""
    grid, faults, middle, azimuth, throw = junction("straight main fault", np.random.default_rng(2))
    turn = np.radians(azimuth[2])
    way = np.array([np.sin(turn), np.cos(turn), 0.0])
    for name, shift in (("F1", 0.0), ("F3", 0.3 * CELL)):
        points = faults[name].vertices + shift * way
        points[:, 2] = np.where(points[:, 2] < -1675.0, -1675.0, points[:, 2])
        faults[name] = gs.TriSurface(name, "fault", points, faults[name].triangles)
    sheet = gs.tear_horizon(grid, faults, name="H", trim=1.5)
    assert {one.kind for one in sheet.report.remedies} == {"fault extended"}
    assert {one.subject for one in sheet.report.remedies} == {"F1", "F3"}
    assert misses(sheet, middle, azimuth, throw)[1] < 0.01
    assert all("in a scenario, lengthen_m" in one.remedy for one in sheet.report.remedies)


@pytest.mark.parametrize(
    "sides", [{"up": 120.0}, {"up": 120.0, "down": 150.0}, {"end": 90.0}, {"end": 90.0, "up": 60.0}]
)
def test_how_far_a_fault_was_continued_names_these_sides_only(sides):
    """A side that is longer because of the sides next to it was not continued itself."""
    fault = gs.synthetic.torn("normal", 41).faults["F1"]
    fault = gs.triangulate_fault(fault, name="F1")
    found = longer_by(fault, extended(fault, sides))
    assert found.keys() == sides.keys()
    assert all(found[side] == pytest.approx(far, rel=0.1) for side, far in sides.items())


def test_a_branch_that_ends_on_its_main_fault_is_not_told_to_end_there():
    """The warning of Drogon's grids advised the truncation that the scenario had."""
    main = gs.TriSurface("F1", "fault", [[0, -9, -9], [0, 9, -9], [0, 9, 9], [0, -9, 9]], FACES)
    branch = gs.TriSurface("F2", "fault", [[-5, 1, -8], [8, 1, -8], [8, 1, 8], [-5, 1, 8]], FACES)
    faults = {"F1": main, "F2": branch}
    ruled = gs.Scene({}, faults, (-9, 9, -9, 9, -9, 9), truncations={"F2": ("F1", "right")})
    ended = [ruled.surface(name) for name in faults]
    for some, words in (([main, branch], "truncations"), (ended, "ends on 'F1' already")):
        assert words in _remedy_at_branch("F2", "branch of F1", SimpleNamespace(faults=some))


FACES = [[0, 1, 2], [0, 2, 3]]


# ---- Remedies of a refusal: faults to leave out, each set of them tried.
# ---- Holes by a minimum cut: against all cuts of small networks; remedies of sheets that stay
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


def test_remedies_are_warned_of_and_listed(low):
    world, fault, deepest = low
    with pytest.warns(
        gs.GeosurfWarning, match=r"leaves fault .* extended up its dip by .* and down its dip by"
    ):
        sheet = gs.tear_horizon(
            world.horizons["Top"],
            [between(fault, deepest + 6.0, fault.bounds[5])],
            name="Top",
            trim=2,
        )
    assert {one.kind for one in sheet.report.remedies} == {"fault extended"}
    assert sheet.faults[0].bounds[4] < deepest
    whole = gs.tear_horizon(world.horizons["Top"], [fault], name="Top", trim=2)
    assert whole.report.remedies == ()
    throw = np.nanmax(np.abs(sheet.cuts[fault.name].throw))
    assert throw == pytest.approx(np.nanmax(np.abs(whole.cuts[fault.name].throw)), abs=0.5)


def test_trims_are_chosen_by_fault():
    world = gs.synthetic.torn("parallel", n=41, smear=2)
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
