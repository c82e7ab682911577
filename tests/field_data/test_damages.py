"""A few of the cases of `damages`: each of a lattice twice, and that it sees what is wrong."""

from __future__ import annotations

import pytest

from geosurf.errors import SurfaceError
from tests.field_data import damages
from tests.field_data.damages import DAMAGES, HARMLESS, HOPELESS, LATTICE_DAMAGES


@pytest.mark.parametrize("damage", LATTICE_DAMAGES)
def test_damaged_lattices_are_refused_by_name_or_rebuilt_rightly(damage):
    number = list(LATTICE_DAMAGES).index(damage)
    for turn in range(2):
        seed = 2 * (number + turn * len(LATTICE_DAMAGES)) + 1
        assert damages.case_of(seed)[0][0] == damage
        word, why = damages.what_becomes_of(seed)
        assert word in ("right", "refused"), why


def test_damaged_meshes_are_refused_by_name_or_rebuilt_rightly():
    found = [damages.what_becomes_of(seed) for seed in range(0, 80, 2)]
    assert {word for word, _ in found} == {"right", "refused"}, found


def test_damages_that_harm_nothing_or_everything_are_those_there_are():
    assert not HARMLESS & HOPELESS
    assert {*HARMLESS, *HOPELESS} <= {*DAMAGES, *LATTICE_DAMAGES}


def test_refusals_without_a_reason_and_answers_without_sense_are_wrong(monkeypatch):
    def refuse(*parts):
        raise SurfaceError("no")

    cases = {damages.case_of(seed)[0][0]: seed for seed in range(1, 95, 2)}
    answer = damages.case_of(cases["nothing"])[1]()
    assert answer.ok
    monkeypatch.setattr(damages, "meets", refuse)
    assert damages.what_becomes_of(cases["nothing"])[0] == "wrong"
    assert damages.what_becomes_of(cases["words"])[0] == "refused"
    monkeypatch.setattr(damages, "meets", lambda *parts: answer)
    monkeypatch.setattr(damages, "damaged_lattice", lambda *parts: None)
    assert damages.what_becomes_of(cases["nothing"])[0] == "right"
    assert damages.what_becomes_of(cases["words"])[0] == "wrong"
