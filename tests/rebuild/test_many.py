"""Some of the worlds of `many`, and those in which it found something."""

from __future__ import annotations

import pytest

from tests.rebuild import many

FOUND = {
    519: "a repair moved more neighbours of a list than of its lattice",
    8272: "vertices were numbered by which pairs the search called near",
    621127: "a repair moved what touches in a point, of lists only",
    8972: "patches of a surface on itself and another depended on their order",
}


@pytest.mark.parametrize("seed", range(24))
def test_small_worlds(seed):
    assert many.check(seed) in many.ENDS


@pytest.mark.parametrize("seed", FOUND)
def test_worlds_in_which_something_was_found(seed):
    assert many.check(seed) in ("rebuilt", "carved"), FOUND[seed]


def test_worlds_that_leak():
    """Of H1 and of H2; a horizon may end in the box only where it is taken away."""
    assert [many.check(seed) for seed in (39, 103, 343)] == ["open"] * 3
    assert many.check(901) == "empty"
