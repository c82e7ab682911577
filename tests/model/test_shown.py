"""What a notebook shows at the end of a cell: every noun in words, none as a heap of arrays."""

from __future__ import annotations

import pytest

import geosurf as gs
from geosurf.carve.certificate import certify
from geosurf.conventions import place, volume_text


@pytest.fixture(scope="module")
def shown():
    world = gs.synthetic.torn("normal", n=31)
    sheet = gs.tear_horizon(world.horizons["Top"], world.faults)
    planes = gs.synthetic.graben(n=9)
    contacts = {"OWC": planes.box[4] + 0.6 * (planes.box[5] - planes.box[4])}
    scene = gs.Scene(planes.horizons, planes.faults, planes.box, contacts=contacts)
    thrown = gs.throw_horizon(planes.horizons["Top"], planes.faults, {"F1": 20.0})
    return {
        "world": world,
        "sheet": sheet,
        "sheet report": sheet.report,
        "cut": sheet.cuts["F1"],
        "lattice": sheet.lattice,
        "trim": gs.TrimProposal(2.0, 1.0, (8.0, 3.0)),
        "throw report": thrown.report,
        "scene": scene,
        "surface": scene.surface("F1"),
        "curves": scene.curves,
        "search": scene.search("Top", "F1"),
        "patches": scene.patches,
        "units": scene.units,
        "unit": next(iter(scene.units.values())),
        "certificate": scene.check(),
    }


def test_every_noun_is_shown_in_words(shown):
    for key, noun in shown.items():
        words = repr(noun)
        assert "object at 0x" not in words, key
        assert "array(" not in words, key
        assert "float64" not in words, key
        assert len(words.splitlines()) <= 45, key
        assert max(map(len, words.splitlines())) <= 160, key


def test_units_are_a_table_that_adds_up(shown):
    units = shown["units"].included()
    head, *rows, total, slivers, left = str(shown["units"]).splitlines()
    assert head.split() == ["zone", "region", "block", "contact", "GRV"]
    assert len(rows) == len(units) - len(units.slivers) == len(units.without_slivers)
    assert slivers == units.slivers_in_words
    for row, unit in zip(rows, units.without_slivers, strict=True):
        assert row.startswith(unit.zone)
        assert unit.block in row
        assert unit.contact in row
        assert row.endswith(volume_text(unit.volume, 4))
    assert total == f"{len(units)} units, GRV {volume_text(units.volume)}"
    rest = volume_text(shown["units"].volume - units.volume)
    n_left = len(shown["units"]) - len(units)
    words = f"Not shown: {n_left} units outside the reservoir, {rest}. units.table lists them."
    assert left == words
    assert "contact" not in str(gs.carve_units(gs.rebuild_surfaces(gs.build_walls(units.box))))


def test_a_certificate_names_the_units_that_are_no_balls():
    """A ring around a shaft: Euler number 0, named beside those that have 2."""
    box, shaft = gs.build_walls((0, 9, 0, 9, -9, 0)), gs.build_walls((3, 6, 3, 6, -9, 0))[:4]
    walls = [gs.TriSurface(f"F{i}", "fault", s.vertices, s.triangles) for i, s in enumerate(shaft)]
    patches = gs.rebuild_surfaces([*walls, *box])
    closed = certify(patches, gs.carve_units(patches)).checks[0]
    assert closed.passed
    assert closed.detail.startswith("2 units, 0 open edges; Euler number 2, but ")
    assert closed.detail.endswith(" 0")


def test_what_was_done_to_faults_is_told_in_sentences():
    world = gs.synthetic.faulted("Y", n=33)
    short = world.faults | {"F2": world.faults["F2"].isel(along_strike=slice(0, -8))}
    rules = {"F2": ("F1", "hanging wall", True)}
    longer, cut = map(str, gs.Scene({}, short, world.box, truncations=rules).fault_actions)
    assert longer.startswith("F2 (start) was extended by ")
    assert " m until F1: " in longer
    assert cut.startswith("F2 ends at F1 along ")
    assert " removed; " in cut
    assert cut.endswith(" in its hanging wall kept")


def test_a_gap_between_faults_has_its_place_and_its_faults():
    """Errors of fault networks were sentences only, which `render_place` cannot draw."""
    world = gs.synthetic.faulted("Y", n=33)
    picks = world.faults["F2"].isel(along_strike=slice(0, -8))
    rules = {"F2": ("F1", "hanging wall")}
    faults = world.faults | {"F2": picks}
    with pytest.raises(gs.errors.GeometryError, match=r"short of 'F1', nearest at ") as caught:
        _ = gs.Scene({}, faults, world.box, truncations=rules).fault_actions
    error = caught.value
    assert error.surfaces == ("F2", "F1")
    assert place(error.place) in str(error)


def test_a_horizon_beside_the_box_is_named():
    world = gs.synthetic.tilted_planes(n=5)
    west, east, south, north, bottom, top = world.box
    box = (west, east, south, north, bottom + 5000, top + 5000)
    with pytest.raises(gs.errors.GeometryError, match="does not reach the model box") as caught:
        _ = gs.Scene({"Top": world.horizons["Top"]}, {}, box).units
    assert caught.value.surfaces == ("Top",)
