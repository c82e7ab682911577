"""Helpers that make no arrays do not count who holds one; nothing leaks by it."""

from __future__ import annotations

import numpy as np
import pytest

numba = pytest.importorskip("numba")
if numba.config.DISABLE_JIT:
    pytest.skip("nothing is compiled", allow_module_level=True)

from numba.core.runtime import _nrt_python, rtsys  # noqa: E402

from geosurf.kernels.compile.helpers import Helper, entry_dispatcher, makes_arrays  # noqa: E402


def largest(x):
    best = x[0]
    for i in range(x.shape[0]):
        best = max(best, x[i])
    return best


def doubled(x):
    out = np.empty(x.shape[0], dtype=np.float64)
    for i in range(x.shape[0]):
        out[i] = 2.0 * x[i]
    return out


largest = Helper(largest)
doubled = Helper(doubled)


def largest_doubled(x):
    return largest(doubled(x))


largest_doubled = Helper(largest_doubled)


def total(x, n):
    out = 0.0
    for _ in range(n):
        out += largest_doubled(x) + largest(x)
    return out


def hidden_maker(x):
    return np.cumsum(x)[-1]


def test_who_has_to_count():
    assert [f.counts for f in (largest, doubled, largest_doubled)] == [False, True, True]
    assert makes_arrays(total)


def test_every_array_is_given_back():
    entry = entry_dispatcher(total)
    x = np.arange(5.0)
    entry(x, 1)
    on = _nrt_python.memsys_stats_enabled()
    _nrt_python.memsys_enable_stats()
    try:
        before = rtsys.get_allocation_stats()
        assert entry(x, 1000) == 12000.0
        after = rtsys.get_allocation_stats()
    finally:
        if not on:
            _nrt_python.memsys_disable_stats()
    assert after.mi_alloc - before.mi_alloc >= 1000
    assert after.mi_alloc - before.mi_alloc == after.mi_free - before.mi_free


def test_a_maker_that_was_overlooked_does_not_compile():
    assert not makes_arrays(hidden_maker)
    helper = Helper(hidden_maker)

    def entry(x):
        return helper(x)

    with pytest.raises(numba.TypingError, match="Only accept returning of array passed"):
        entry_dispatcher(entry)(np.arange(3.0))
