"""Torn sheets as horizons of a model: units close, and the certificate holds."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs


@pytest.fixture(scope="module")
def pair():
    """Function of a kind of world: two sheets on one set of faults, and a scene of them."""

    def make(kind: str):
        sheets = {}
        for name, level in (("Top", 0.0), ("Base", -120.0)):
            world = gs.synthetic.torn(kind, 41, level=level)
            sheets[name] = gs.tear_horizon(
                world.truth["points"], world.faults, name=name, positive="up"
            )
        faults = {fault.name: fault for fault in sheets["Top"].faults}
        return sheets, gs.Scene(sheets, faults, (100.0, 900.0, 100.0, 900.0, -2070.0, -1530.0))

    return make


@pytest.mark.parametrize(("kind", "n_unit"), [("normal", 3), ("through", 6), ("reverse", 3)])
def test_units_of_torn_sheets_are_closed_and_certified(pair, kind, n_unit):
    _, scene = pair(kind)
    assert len(scene.units) == n_unit
    certificate = scene.check()
    assert certificate.ok, str(certificate)


def test_a_torn_sheet_has_no_curves_with_itself(pair):
    _, scene = pair("normal")
    words = r"horizon 'Top' is torn, so .* Name a fault"
    with pytest.raises(gs.errors.InputError, match=words):
        scene.curves_between("Top", "Top")


def test_volume_between_torn_sheets_is_that_of_the_truth(pair):
    """Both sheets are torn alike, 120 m apart, so their zone is 120 m thick but for the gap."""
    _, scene = pair("normal")
    area = 800.0 * 800.0
    volume = scene.units["Top/Base"].volume
    assert volume == pytest.approx(120.0 * area, rel=0.04)


def test_cutoffs_of_a_scene_end_where_the_sheet_ends(pair):
    """Both walls inside the box, nothing of what was carried on past the fault."""
    sheets, scene = pair("through")
    lines = scene.cutoffs("Top", "F1")
    assert len(lines) == 2
    found = np.concatenate(lines)
    cuts = np.concatenate([line for w in "+-" for line in sheets["Top"].cuts["F1"].cutoffs[w]])
    inside = cuts[(abs(cuts[:, :2] - 500.0) < 399.0).all(axis=1)]
    near = np.abs(found[None] - inside[:, None]).max(axis=2).min(axis=1)
    assert near.max() < 1e-7  # the model may have moved inputs by that much
    own = set(map(tuple, scene.patches.surface("Top").vertices.tolist()))
    assert own >= set(map(tuple, found.tolist()))


def test_a_sheet_needs_the_faults_that_tear_it(pair):
    sheets, _ = pair("normal")
    scene = gs.Scene({"Top": sheets["Top"]}, {}, (100.0, 900.0, 100.0, 900.0, -2070.0, -1530.0))
    with pytest.raises(gs.errors.InputError, match=r"'Top' is torn at fault 'F1', which is not in"):
        scene.surface("Top")
    moved = gs.TriSurface(
        "F1", "fault", sheets["Top"].faults[0].vertices + 1.0, sheets["Top"].faults[0].triangles
    )
    with pytest.raises(gs.errors.InputError, match=r"'F1', which is another surface.*sheet.faults"):
        gs.Scene({"Top": sheets["Top"]}, {"F1": moved}).surface("Top")


def test_what_is_dropped_is_accounted_for(pair):
    _, scene = pair("normal")
    report = scene.patches.report["dropped_area"]
    assert set(report) == {0, 1}
    for row, area in report.items():
        source = scene.patches.sources[row]
        corners = source.vertices[source.triangles]
        whole = 0.5 * np.linalg.norm(
            np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
        )
        assert 0 < area < 0.2 * whole.sum()


@pytest.mark.parametrize("kind", ["normal", "gentle", "listric"])
def test_throws_of_a_sheet_are_those_of_a_scene(torn_world, kind):
    """Read across at stations, and down the dip in the model: what docs/guides/measures.md says."""
    _, sheet = torn_world(kind, n=81)
    x, y = sheet.lattice.easting, sheet.lattice.northing
    inside = (x.min() + 40.0, x.max() - 40.0, y.min() + 40.0, y.max() - 40.0, -2600.0, -1000.0)
    scene = gs.Scene({"Top": sheet}, {fault.name: fault for fault in sheet.faults}, inside)
    found = scene.throw("Top", "F1").dropna("point", subset=["throw"])
    along = found.along_strike.values
    places = np.column_stack([found.easting, found.northing, np.ones(len(along))])
    middle = places.mean(axis=0) * [1.0, 1.0, 0.0]
    strike = np.linalg.lstsq(places - middle, along, rcond=None)[0]
    cut = sheet.cuts["F1"]
    at = (np.column_stack([cut.stations[:, :2], np.ones(len(cut.along))]) - middle) @ strike
    order = np.argsort(along, kind="stable")
    throw = np.interp(at, along[order], found.throw.values[order], left=np.nan, right=np.nan)
    off = np.abs(throw - cut.throw)
    assert np.isfinite(off).sum() > 0.9 * len(off)
    assert np.nanmean(off) < 0.03
    assert np.nanmax(off) < 0.3
