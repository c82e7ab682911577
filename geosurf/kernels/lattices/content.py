"""Many numbers mixed into a few, which stand for them in a fingerprint.

Number k goes into lane k modulo the number of lanes. Each step of a lane is one-to-one in its state
and in the number that comes in: a product with an odd number, which takes low bits to high ones,
and an exclusive or of the upper half with the lower one, which takes them back.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar

AT_ONCE = 4  # numbers of a lane: its state is read and written once for them
_ODD = np.int64(-0x61C8864680B583EB)  # 2**64 over the golden ratio
_LOWER = 0xFFFFFFFF


@scalar
def _mixed(state, number):
    product = (state ^ number) * _ODD
    return product ^ ((product >> 32) & _LOWER)


@entry("l1* l1 -> .")
def mix_into(state, numbers):
    """Mix numbers into the state of some lanes, as many as fill all lanes AT_ONCE times."""
    n = state.shape[0]
    for i in range(0, numbers.shape[0] - AT_ONCE * n + 1, AT_ONCE * n):
        a, b = numbers[i : i + n], numbers[i + n : i + 2 * n]
        c, d = numbers[i + 2 * n : i + 3 * n], numbers[i + 3 * n : i + 4 * n]
        for k in range(n):
            state[k] = _mixed(_mixed(_mixed(_mixed(state[k], a[k]), b[k]), c[k]), d[k])
