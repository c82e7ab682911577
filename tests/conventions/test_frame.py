"""Which shifts of coordinates lose nothing."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from geosurf.conventions import checks, shift_is_exact


@pytest.mark.parametrize("shape", [(7,), (7, 5), (0,), (3, 0)])
@pytest.mark.parametrize("at_once", [1, 4, 1000])
def test_a_shift_is_exact_if_that_of_every_coordinate_is(shape, at_once, rng, monkeypatch):
    """Coordinates are looked at some at a time; the answer is that of rational numbers."""
    monkeypatch.setattr(checks, "_AT_ONCE", at_once)
    values, shift = 456_000.0 + rng.integers(0, 9000, shape) / 8.0, 455_680.0
    if values.size:
        values.flat[-1] = np.nan
    assert shift_is_exact(values, shift)
    for k in range(values.size - 1):
        odd = values.copy()
        odd.flat[k] = 1e-9
        assert Fraction(odd.flat[k]) - Fraction(shift) != Fraction(odd.flat[k] - shift)
        assert not shift_is_exact(odd, shift)
