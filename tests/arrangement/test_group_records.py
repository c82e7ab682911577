"""Records of cut faces, grouped: the quick search for keys against numpy's."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from geosurf.arrangement.arrange import _are_among

KEYS = arrays(np.int64, st.integers(1, 9), elements=st.integers(0, 6))


@given(KEYS, KEYS)
def test_keys_are_found_as_numpy_finds_them(keys: np.ndarray, others: np.ndarray) -> None:
    assert np.array_equal(_are_among(keys, others), np.isin(keys, others))
