"""Memory that is asked for: nothing changes, whatever is asked for, and one instruction asks."""

import numpy as np
import pytest

from geosurf.kernels.compile.jit import RUNNER, entry, scalar
from geosurf.kernels.lattices.lattice_corners import prefetch


@scalar
def _ask(x, i):
    prefetch(x, i)


@entry("d2 l1 l -> d")
def total_asked_for(x, rows, early):
    total = 0.0
    for k in range(rows.shape[0]):
        _ask(x, rows[k] + early)
        prefetch(rows, k + early)
        total += x[rows[k], 0] + x[rows[k], 2]
    return total


@pytest.mark.parametrize("early", [0, 7, -3, 10**12, -(10**12)])
def test_what_is_asked_for_changes_nothing_and_need_not_be_there(early):
    x = np.arange(60.0).reshape(20, 3)
    rows = np.array([3, 0, 19, 3])
    assert total_asked_for(x, rows, early) == (2.0 * x[rows, 1]).sum()


def test_compiled_kernels_ask_by_one_instruction():
    if not RUNNER.compiles:
        assert prefetch(np.zeros(3), 5) is None
        return
    from geosurf.kernels.compile.helpers import entry_dispatcher  # with nothing kept
    from geosurf.kernels.compile.numba_runner import types_of

    made = entry_dispatcher(total_asked_for.python)
    made.compile(types_of(total_asked_for.signature.arguments))
    [code] = made.inspect_llvm().values()
    assert "call void @llvm.prefetch" in code
