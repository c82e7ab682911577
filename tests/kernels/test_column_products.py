"""Sums of products of columns: as whole numbers say, and row after row whatever the library."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from geosurf.kernels.sheets.node_bands import products_of_columns, sums_of_columns


@given(st.integers(0, 9), st.integers(0, 4), st.integers(0, 3), st.integers(0, 2**32 - 1))
def test_whole_numbers_are_summed_exactly(n, k, m, seed):
    random = np.random.default_rng(seed)
    a, b = random.integers(-9, 10, (n, k)), random.integers(-9, 10, (n, m))
    share = random.integers(-9, 10, k)
    found = products_of_columns(a.astype(np.float64), b.astype(np.float64))
    assert np.array_equal(found, a.T @ b)
    found = sums_of_columns(a.astype(np.float64), share.astype(np.float64))
    assert np.array_equal(found, a @ share)


def test_rows_are_added_in_their_order():
    """Each row adds nothing to a sum that is large already, and counts before it is."""
    large = np.array([[2.0**53]])
    rows = np.ones((3, 1))
    first, last = np.concatenate([large, rows]), np.concatenate([rows, large])
    one = np.ones((4, 1))
    assert products_of_columns(first, one)[0, 0] == 2.0**53
    assert products_of_columns(last, one)[0, 0] == 2.0**53 + 4.0  # 2**53 + 3, rounded to even
    assert sums_of_columns(first.T.copy(), one[:, 0])[0] == 2.0**53
    assert sums_of_columns(last.T.copy(), one[:, 0])[0] == 2.0**53 + 4.0
