"""Some of the cases of `checked`, and those in which it found something."""

from __future__ import annotations

import pytest

from geosurf.errors import SurfaceError
from tests.field_data import checked, damages
from tests.field_data.damages import DAMAGES, HARMLESS, HOPELESS

FOUND = {
    122: "curves were forgotten where a surface with an overlap crosses itself",
    1117: "a surface that lies on itself had no curve where it crosses itself",
}


@pytest.fixture(scope="module")
def kit(shared):
    return checked.kit()


@pytest.mark.parametrize("seed", [*range(24), *FOUND])
def test_small_surfaces(kit, seed):
    kind, _ = checked.check(seed, *kit)
    assert kind in checked.KINDS


def test_structured_cases(kit):
    """Large ones: faults on vertices, edges and faces, slivers, holes, gaps, triple points."""
    verify, cases = kit
    whole = [c for c in cases.structured_cases() if not c.name.startswith(("egg", "self"))]
    assert len(whole) >= 14
    for case in whole:
        checked.check_meshes(verify, checked.finite(case.meshes), by_fractions=False)


def test_catalogue_variants(kit):
    """Every contact of two triangles that another author thought of, under exact motions."""
    verify, cases = kit
    variants = list(cases.catalogue_variants(5, 4))
    assert len(variants) > 200
    for configuration, *meshes in variants:
        n_pair = checked.check_meshes(verify, meshes)
        assert n_pair == (configuration.kind is not None), configuration.name


def test_a_wrong_curve_is_found(kit, monkeypatch):
    """The check itself can fail."""
    whole = checked.intersect_surfaces

    def halved(*args, **options):
        """All but the first segment."""
        curves = whole(*args, **options)
        object.__setattr__(curves, "segments", curves.segments[1:])
        object.__setattr__(curves, "surfaces_of_segment", curves.surfaces_of_segment[1:])
        return curves

    monkeypatch.setattr(checked, "intersect_surfaces", halved)
    with pytest.raises(kit[0].CheckError, match="missing"):
        checked.check(2, *kit)


# ---- A few of the cases of `damages`, and that it sees what is wrong.
def test_damaged_meshes_are_refused_by_name_or_rebuilt_rightly():
    found = [damages.what_becomes_of(seed) for seed in range(80)]
    assert {word for word, _ in found} == {"right", "refused"}, found


def test_damages_that_harm_nothing_or_everything_are_those_there_are():
    assert not HARMLESS & HOPELESS
    assert {*HARMLESS, *HOPELESS} <= {*DAMAGES}


def test_refusals_without_a_reason_and_answers_without_sense_are_wrong(monkeypatch):
    def refuse(*parts):
        raise SurfaceError("no")

    def case_of(seed):
        """A whole mesh, and one of words."""
        return ["words" if seed else "nothing"], lambda: damages.meets(None, None)

    answer = next(
        answer() for done, answer in map(damages.case_of, range(200)) if {*done} == {"nothing"}
    )
    assert answer.ok
    monkeypatch.setattr(damages, "case_of", case_of)
    monkeypatch.setattr(damages, "meets", refuse)
    assert [damages.what_becomes_of(seed)[0] for seed in (0, 1)] == ["wrong", "refused"]
    monkeypatch.setattr(damages, "meets", lambda *parts: answer)
    assert [damages.what_becomes_of(seed)[0] for seed in (0, 1)] == ["right", "wrong"]
