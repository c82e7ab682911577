"""Radial order around an edge: doubles, exact numbers and fractions say the same."""

from __future__ import annotations

from functools import cmp_to_key

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.meshes.seams import N_AROUND, main_axis, sort_around, sort_by_floats
from tests.oracles import cross, dot

small = st.integers(-3, 3).map(float)


def fan(d: np.ndarray, tips: np.ndarray, back: list[bool]) -> tuple[np.ndarray, np.ndarray]:
    """Triangles around the edge from 0 to d: points, and corners, some running back."""
    x = np.concatenate([np.zeros((1, 3)), d[None], tips])
    rows = [[1, 0, k] if way else [0, 1, k] for k, way in enumerate(back, start=2)]
    return x, np.array(rows)


def by_doubles(x, t, back):
    """Order and ways of triangles around the edge from 0 to 1 by doubles; None where in doubt."""
    n, (axis, heading) = len(t), main_axis(x, 0, 1)
    order, ways, rows = np.arange(n), np.where(back, -1, 1), np.arange(n)
    px = x[t].reshape(-1, 3)
    sure = sort_by_floats(px, rows, axis, heading, order, ways, n, np.empty(n))
    return (order.tolist(), ways.tolist()) if sure else None


def by_integers(x, t, back):
    """The order by exact numbers; None where two are one."""
    n, px = len(t), x[t].reshape(-1, 3)
    order, ways, rows = np.arange(n), np.where(back, -1, 1), np.arange(n)
    around, pt = np.empty((n, N_AROUND)), np.arange(3 * n).reshape(-1, 3)
    done = sort_around(x, 0, 1, order, ways, around, n, rows, px, pt, *frame_of(px))
    return order.tolist() if done else None


def whole(values: np.ndarray) -> list[int]:
    return [int(value) for value in values]


def slow_order(d: np.ndarray, tips: np.ndarray) -> list[int] | None:
    """Half-planes by angle around d from the first, in whole numbers; None if two are one."""
    axis = whole(d)
    away = [cross(axis, cross(whole(tip), axis)) for tip in tips]  # from the edge, in its plane

    def half(a: list[int]) -> int:
        turn = dot(cross(away[0], a), axis)
        return 0 if turn > 0 or (turn == 0 and dot(away[0], a) > 0) else 1

    def compare(i: int, j: int) -> int:
        if half(away[i]) != half(away[j]):
            return half(away[i]) - half(away[j])
        turn = dot(cross(away[i], away[j]), axis)
        return -1 if turn > 0 else int(turn < 0)

    order = [0, *sorted(range(1, len(tips)), key=cmp_to_key(compare))]
    for i, j in zip(order, order[1:] + order[:1], strict=True):
        if len(tips) > 1 and dot(cross(away[i], away[j]), axis) == 0 < dot(away[i], away[j]):
            return None
    return order


fans = st.integers(2, 6).flatmap(
    lambda n: st.tuples(
        arrays(float, 3, elements=small),
        arrays(float, (n, 3), elements=small),
        st.lists(st.booleans(), min_size=n, max_size=n),
    )
)


@given(fans, st.sampled_from([1.0, 2.0**20, 2.0**24]))
def test_doubles_and_exact_numbers_sort_as_fractions_do(made, stretch):
    """Stretched along their edge, triangles lie nearly in one plane: doubles must say so."""
    d, tips, back = made
    assume(all(any(cross(whole(d), whole(tip))) for tip in tips))
    tips = tips + stretch * d * np.arange(len(tips))[:, None]
    expected = slow_order(d, tips)
    x, t = fan(d, tips, back)
    told = by_doubles(x, t, back)
    if told is not None:
        assert told == (expected, [-1 if back[i] else 1 for i in expected])
    assert by_integers(x, t, back) == expected


@pytest.mark.parametrize("spread", [1, 2**30])
def test_half_planes_around_the_first_are_in_order_or_not_told(rng, spread):
    """Behind the first or ahead by less than rounding: tips far off along the edge, as slivers."""
    told = 0
    for _ in range(100):
        d, first, other = rng.integers(-(2**40), 2**40, (3, 3))
        first = first + rng.integers(-(2**11), 2**11) * d
        near = first + rng.integers(-3, 4) * d + rng.integers(-spread, spread + 1, 3)
        tips = np.array([first, near, other], dtype=float)
        d = d.astype(float)
        expected = slow_order(d, tips)
        if expected is None:
            continue
        back = rng.integers(0, 2, 3).astype(bool).tolist()
        x, t = fan(d, tips, back)
        by_floats = by_doubles(x, t, back)
        told += by_floats is not None
        assert by_floats is None or by_floats[0] == expected
        assert by_integers(x, t, back) == expected
    assert told < 10 if spread == 1 else told > 90
