"""A few of the pairs of `million`, and that it can see an error."""

from __future__ import annotations

import pytest

from tests.arrangement import million


def test_lattice_pairs_in_one_go(rng):
    n, meeting, _, _, wrong = million.lattice_chunk(rng, 3_000)
    assert 0 < meeting < n
    assert len(wrong) == 0


@pytest.mark.parametrize("family", million.FAMILIES)
def test_pairs_of_doubles(family, rng):
    n, meeting, _, _, wrong = million.double_chunk(family, rng, 1_000, sample=100)
    assert 0 < meeting < n
    assert len(wrong) == 0


def test_what_is_wrong_is_seen(rng):
    P, Q = million.lattice(rng, 500)
    true = million.true_contacts(P, Q)
    bent = P.astype(float)
    bent[:, 0, 2] += 2.0**-40
    found = million.found_contacts(bent, Q * 1.0)
    assert len(million.differing(true, found)) > 50
