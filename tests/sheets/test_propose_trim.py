"""Trim is proposed from ignored data; what data cannot show is reported; blocks are filled."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs


@pytest.mark.parametrize("kind", ["normal", "Y"])
@pytest.mark.parametrize(("smear", "trim"), [(0, 2.0), (1, 2.0), (2, 3.5), (3, 5.0)])
def test_the_smear_of_a_grid_is_found(kind, smear, trim):
    world = gs.synthetic.torn(kind, 81, smear=smear)
    proposal = gs.propose_trim(world.horizons["Top"], world.faults)
    assert (proposal.smear, proposal.trim) == (smear, trim)
    assert f"proposed trim: {trim:g} cells (data are smeared over {smear} cells)" in str(proposal)


@pytest.mark.parametrize("kind", ["normal", "reverse"])
@pytest.mark.parametrize("smear", [2, 3, 4])
def test_law_a_wide_smear_takes_no_throw_away(kind, smear):
    """With one fault, too: a trim that is too small lets the throw fade without a word."""
    worlds = [gs.synthetic.torn(kind, 61, smear=k) for k in (smear, 0)]
    points = worlds[1].truth["scattered"](9000, 0.0, 1)
    one = gs.tear_horizon(worlds[0].horizons["Top"], worlds[0].faults, name="Top")
    two = gs.tear_horizon(points, worlds[1].faults, name="Top", positive="up")
    throws = [np.nanmedian(sheet.cuts["F1"].throw) for sheet in (one, two)]
    # eight cells of extrapolation, where a smear of four meets an overlap
    assert throws[0] == pytest.approx(
        throws[1], rel=0.12 if (kind, smear) == ("reverse", 4) else 0.07
    )


def test_a_fault_that_clearly_has_another_smear_has_a_trim_of_its_own():
    """As where the gridder knew one fault and not the other."""
    sharp, smeared = (gs.synthetic.torn("X", 81, smear=k) for k in (0, 3))
    top = sharp.horizons["Top"]
    x, y = np.meshgrid(top.easting, top.northing)
    away = [np.abs(f.along_across(x, y)[1]) for f in sharp.truth["faults"].values()]
    mixed = smeared.horizons["Top"].where(away[0] < away[1], top)
    assert gs.propose_trim(mixed, sharp.faults).of_fault == {"F1": 5.0, "F2": 2.0}


def test_smear_that_cannot_be_told_is_not_guessed():
    """Noise misses hidden data at all distances alike."""
    world = gs.synthetic.torn("normal", 61)
    top = world.horizons["Top"]
    noise = 4.0 * np.random.default_rng(0).standard_normal(top.shape)
    proposal = gs.propose_trim(top.copy(data=top.values + noise), world.faults)
    assert proposal.smear is None
    assert proposal.trim == 2.0
    assert "the width of the smear cannot be determined" in str(proposal)


def test_too_few_data_to_see_a_smear():
    world = gs.synthetic.torn("normal", 31)
    some = world.horizons["Top"][:4]
    with pytest.raises(gs.errors.GeometryError, match=r"too few to measure the smear. Set trim"):
        gs.propose_trim(some, world.faults)


def test_overlap_that_a_grid_cannot_show_is_said(torn_world):
    world, _ = torn_world("reverse", True, n=61)
    with pytest.warns(gs.errors.GeosurfWarning, match="Tear with a trim of 5 cells"):
        sheet = gs.tear_horizon(world.horizons["Top"], world.faults, trim=3)
    note, _ = sheet.report.notes
    assert note.startswith("Fault 'F1' is reverse: the horizon overlaps by up to ")
    assert "one value per node cannot show. Give points of both walls" in note
    assert note in str(sheet.report)
    for kind, points in (("reverse", True), ("normal", False), ("vertical", False)):
        assert torn_world(kind, points, n=61)[1].report.notes == []


@pytest.mark.parametrize("kind", ["normal", "Y", "acute Y", "X"])
def test_normal_faults_are_not_called_reverse(torn_world, kind):
    """At the contact of a branch a link may reach over the main fault: that is no overlap."""
    assert torn_world(kind, n=81)[1].report.notes == []
