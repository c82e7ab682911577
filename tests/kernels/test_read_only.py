"""Read-only arrays reach a kernel as the same memory, not as a copy, and as what they are."""

from __future__ import annotations

import numpy as np
import pytest

numba = pytest.importorskip("numba")
if numba.config.DISABLE_JIT:
    pytest.skip("nothing is compiled", allow_module_level=True)

from geosurf.kernels.compile.numba_runner import _writeable  # noqa: E402
from geosurf.model import frozen  # noqa: E402


def closed(array):
    array.flags.writeable = False
    return array


TABLE = np.arange(24.0).reshape(4, 6)
ARRAYS = {
    "all of another": frozen(TABLE, np.float64),
    "all of another, in another shape": frozen(TABLE, np.float64, (24,)),
    "a part": closed(TABLE[1:3]),
    "one element": closed(TABLE[2:3, 5:]),
    "of another kind": closed(TABLE.view(np.int64)),
    "its own": closed(np.arange(7)),
    "of one that is closed": closed(np.arange(8.0))[:],
    "nothing": closed(np.empty((0, 3))),
}


@pytest.mark.parametrize("name", ARRAYS)
def test_the_same_memory(name):
    array = ARRAYS[name]
    assert not array.flags.writeable
    seen = _writeable(array)
    assert type(seen) is np.ndarray
    assert seen.flags.carray
    assert seen.shape == array.shape
    assert seen.dtype == array.dtype
    np.testing.assert_array_equal(seen, array)
    if array.size:
        assert seen.__array_interface__["data"][0] == array.__array_interface__["data"][0]
    assert not array.flags.writeable


def test_it_outlives_its_owner():
    seen = _writeable(frozen(np.arange(5.0), np.float64))
    np.testing.assert_array_equal(seen, [0.0, 1.0, 2.0, 3.0, 4.0])


def test_what_is_writeable_or_a_number_stays():
    assert _writeable(TABLE) is TABLE
    assert _writeable(3) == 3
