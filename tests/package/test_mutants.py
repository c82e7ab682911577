"""The list of planted mistakes fits the code of today; `python -m tests.mutants` plants them."""

from __future__ import annotations

from tests import mutants


def test_each_planted_mistake_has_its_place():
    assert len(mutants.MUTANTS) >= 60
    assert [one.text for one in mutants.MUTANTS if mutants.found(one) is None] == []
