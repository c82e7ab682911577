"""Smear: trim is proposed from it, wedges are met despite it, and lost throw is named."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

import geosurf as gs
from benchmarks.random_networks import random_network
from geosurf.sheets.faults.traces import mesh_in_frame
from geosurf.sheets.heights.passes import rebuild, solver_of
from geosurf.sheets.heights.state import BIN, Trims
from geosurf.sheets.lattice import picks
from geosurf.sheets.lattice.data import read_data
from geosurf.sheets.mesh.finish import fault_surfaces
from tests.sheets.table import measure


@pytest.mark.parametrize("kind", ["normal", "Y"])
@pytest.mark.parametrize(("smear", "trim"), [(0, 2.0), (1, 2.0), (2, 3.5), (3, 5.0)])
def test_the_smear_of_a_grid_is_found(kind, smear, trim):
    world = gs.synthetic.torn(kind, 61, smear=smear)
    proposal = gs.propose_trim(world.horizons["Top"], world.faults)
    assert (proposal.smear, proposal.trim) == (smear, trim)
    assert f"proposed trim: {trim:g} cells (data are smeared over {smear} cells)" in str(proposal)


@pytest.mark.parametrize(("kind", "off"), [("normal", 0.07), ("reverse", 0.12)])
def test_law_a_wide_smear_takes_no_throw_away(kind, off):
    """With one fault, too: a trim that is too small lets the throw fade without a word."""
    worlds = [gs.synthetic.torn(kind, 61, smear=k) for k in (4, 0)]
    points = worlds[1].truth["scattered"](9000, 0.0, 1)
    one = gs.tear_horizon(worlds[0].horizons["Top"], worlds[0].faults, name="Top")
    two = gs.tear_horizon(points, worlds[1].faults, name="Top", positive="up")
    throws = [np.nanmedian(sheet.cuts["F1"].throw) for sheet in (one, two)]
    # reverse: eight cells of extrapolation, where a smear of four meets an overlap
    assert throws[0] == pytest.approx(throws[1], rel=off)


def test_a_fault_that_clearly_has_another_smear_has_a_trim_of_its_own():
    """As where the gridder knew one fault and not the other."""
    sharp, smeared = (gs.synthetic.torn("X", 61, smear=k) for k in (0, 3))
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
    for kind, points in (("reverse", True), ("vertical", False)):
        assert torn_world(kind, points, n=61)[1].report.notes == []


# ---- How far off distrusted data are is seen where sheets reach them, and believed in wedges.
@pytest.mark.parametrize("kind", ["Y", "acute X"])
def test_the_smear_of_a_grid_ends_where_its_window_does(kind):
    """A square window of one node reaches no datum farther than the diagonal of a cell."""
    world = gs.synthetic.torn(kind, 61)
    picks = read_data(world.horizons["Top"], "Top").picks
    meshes = [mesh_in_frame(fault, picks.frame) for fault in fault_surfaces(world.faults)]
    spread = rebuild(
        solver_of(picks, meshes, Trims((2.0,) * len(meshes)), noise=0.0)
    ).evidence.smear.spread
    end = int(np.ceil(np.sqrt(2.0) / BIN))
    assert (spread[end:] < 0.1).all()
    assert (spread[: end - 1] > 0.3).all()


def test_a_wedge_hears_the_good_data_on_its_way(monkeypatch):
    """Four steps from trusted data, one that was right held nothing; a step more, and it did."""
    monkeypatch.setattr(picks, "FAINT", 0.0)  # third differences, as for data with noise
    world = gs.synthetic.torn("acute X", 81)
    worst = []
    for trim in (1.9, 2.0, 2.1):
        sheet = gs.tear_horizon(world.horizons["Top"], world.faults, name="Top", trim=trim)
        worst.append(max(measure(world, sheet, name).throw.max() for name in world.faults))
    assert max(worst) < 1.25 * min(worst)


@pytest.mark.parametrize(("kind", "trim"), [("acute Y", 1.5), ("acute Y", 2.5), ("acute X", 2.5)])
def test_acute_wedges_are_met_whatever_the_trim(kind, trim):
    """The wider the trim, the fewer data are trusted in a wedge: those seen to be right help."""
    world = gs.synthetic.torn(kind, 81)
    sheet = gs.tear_horizon(world.horizons["Top"], world.faults, name="Top", trim=trim)
    for name in world.faults:
        found = measure(world, sheet, name)
        assert found.throw.mean() < 0.5
        assert found.throw.max() < 3.5
        assert found.variation == pytest.approx((1.0, 1.0), abs=0.03)


# ---- The throw of a sheet is compared with what its data show, and named where they differ.
def torn(data, faults, **options):
    """A sheet, and its warnings of throw by fault."""
    with warnings.catch_warnings(action="ignore", category=gs.errors.GeosurfWarning):
        sheet = gs.tear_horizon(data, faults, name="Top", positive="up", **options)
    return sheet, {w.subject: w for w in sheet.warnings if w.kind == "throw not as data"}


@pytest.mark.parametrize("kind", ["reverse", "X"])
def test_law_data_show_the_true_throw_within_twice_their_spread(kind):
    """On the hanging wall minus footwall of points that were never smeared."""
    world = gs.synthetic.torn(kind, 61, smear=2)
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


@pytest.mark.parametrize("kind", ["normal", "X"])
def test_a_trim_that_loses_throw_is_named_and_its_remedy_works(kind):
    world = gs.synthetic.torn(kind, 61, smear=3)
    faults = list(world.faults)
    sheet, named = torn(world.horizons["Top"], world.faults, trim=1.5)
    assert list(named) == faults
    for fault, warning in named.items():
        audit = sheet.report.throw[fault]
        assert audit.differs.sum() > 0.8 * np.isfinite(audit.data).sum()
        assert f"Tear with a trim of {audit.trim:g} cells for {fault!r}" in warning.remedy
        assert np.allclose(warning.place, audit.stations[audit.worst])
    trims = {fault: audit.trim for fault, audit in sheet.report.throw.items()}
    assert not torn(world.horizons["Top"], world.faults, trim=trims)[1]


@pytest.mark.parametrize(("family", "smear"), [("lambda", 1), ("X", 2)])
def test_random_networks_are_not_named_where_they_are_right(family, smear):
    network = random_network(family, np.random.default_rng([3, smear]), smear)
    sheet, named = torn(network.horizon, network.faults)
    assert not named
    shown = [np.isfinite(audit.data).mean() for audit in sheet.report.throw.values()]
    assert np.mean(shown) > 0.2


@pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
def test_a_scene_lists_the_throw_of_model_and_data():
    world = gs.synthetic.torn("normal", 61, smear=2)
    for trim, differs in (("auto", False), (1.5, True)):
        scene = gs.Scene(world.horizons, world.faults, tear=trim)
        found = scene.throw_audit().sel(horizon="Top")
        assert (found.differs > 0).values.all() == differs
        assert (np.abs(found.off) > 10.0).values.all() == differs
        assert differs or (np.abs(found.model - found.data) < found.spread).values.all()
    # of a sheet, a model lists throw that is doubtful in its area, or lost there by a tear's end
    (data,), sheet = scene.warnings, scene.sheets["Top"]
    early = gs.errors.GeosurfWarning("tear ended early", "F1", "", "", data.place)
    sheet = replace(sheet, report=replace(sheet.report, warnings=(data, early)))
    for x, y, n in ((950, 1250, 2), (550, 350, 1), (200, 1200, 0)):
        area = np.array([[x - 99.0, y - 99.0], [x + 99.0, y - 99.0], [x, y + 99.0]])
        for horizon, trim, most in ((world.horizons["Top"], 1.5, 1), (sheet, None, 2)):
            scene = gs.Scene({"Top": horizon}, world.faults, aoi=area, tear=trim)
            assert len(scene.units) >= 2
            assert len({data, early} & {*scene.warnings}) == min(n, most)
    # the place lies beside this triangle, between its corners: its map shows no remedy
    scene = scene.replace(aoi=[[761.0, 796.0], [959.0, 796.0], [860.0, 994.0]])
    texts = [text.get_text() for axes in scene.plot.map("Top").axes for text in axes.texts]
    assert texts
    assert not any("remed" in text for text in texts)
    flat = gs.synthetic.tilted_planes()
    with pytest.raises(gs.errors.InputError, match="no horizon is torn"):
        gs.Scene(flat.horizons, flat.faults, flat.box).throw_audit()


def test_no_trend_is_drawn_across_another_fault():
    """Two faults four cells apart: between them there is nothing that a trend could be drawn to."""
    world = gs.synthetic.torn("parallel", 81, smear=0)
    sheet, named = torn(world.horizons["Top"], world.faults)
    assert not named
    for audit in sheet.report.throw.values():
        mine = np.hypot(*(audit.stations[:, :2] - 1000.0).T) < 500.0
        assert mine.sum() > 20
        assert np.isnan(audit.data[mine]).all()


def test_planes_without_throw_show_no_smear():
    """What a rebuild without data near a fault misses by is no throw to have a share of."""
    world = gs.synthetic.graben(n=31)
    sheet = gs.tear_horizon(world.horizons["Base"], world.faults, name="Base")
    assert (sheet.warnings, set(sheet.report.trims.values())) == ((), {2.0})
    with pytest.raises(gs.errors.GeometryError, match="too few data beyond the trim hold the"):
        gs.tear_horizon(world.horizons["Base"], world.faults, name="Base", trim=8)
