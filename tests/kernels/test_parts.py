"""Radial order around an edge: doubles, exact numbers and fractions say the same."""

from __future__ import annotations

import itertools
from functools import cmp_to_key

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.meshes.parts import open_edges
from geosurf.kernels.meshes.seams import (
    DONE,
    N_AROUND,
    NEEDS_EXACT,
    main_axis,
    sort_around,
    sort_by_floats,
    sort_seams,
)

small = st.integers(-3, 3).map(float)
PAIRED, FREE = -2, -1


def fan(d: np.ndarray, tips: np.ndarray, back: list[bool]) -> tuple[np.ndarray, np.ndarray]:
    """Triangles around the edge from 0 to d: points, and corners, some running back."""
    x = np.concatenate([np.zeros((1, 3)), d[None], tips])
    rows = [[1, 0, k] if way else [0, 1, k] for k, way in enumerate(back, start=2)]
    return x, np.array(rows)


def ring_of(n: int) -> np.ndarray:
    """All triangles of a fan share their first edge, and no other."""
    ring = np.arange(3 * n)
    ring[0::3] = np.roll(ring[0::3], -1)
    return ring


def whole(values: np.ndarray) -> list[int]:
    return [int(value) for value in values]


def cross(a: list[int], b: list[int]) -> list[int]:
    return [a[k - 2] * b[k - 1] - a[k - 1] * b[k - 2] for k in range(3)]


def dot(a: list[int], b: list[int]) -> int:
    return sum(p * q for p, q in zip(a, b, strict=True))


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
    n, px = len(t), x[t].reshape(-1, 3)
    axis, heading = main_axis(x, 0, 1)
    start = [-1 if way else 1 for way in back]
    order, ways = np.arange(n), np.array(start)
    if sort_by_floats(px, np.arange(n), axis, heading, order, ways, n, np.empty(n)):
        assert order.tolist() == expected
        assert ways.tolist() == [start[i] for i in order]
    order, ways = np.arange(n), np.array(start)
    m, w = frame_of(px)
    pt = np.arange(3 * n).reshape(-1, 3)
    told = sort_around(x, 0, 1, order, ways, np.empty((n, N_AROUND)), n, np.arange(n), px, pt, m, w)
    if expected is not None:
        assert told
        assert order.tolist() == expected


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
        x, t = fan(d, tips, rng.integers(0, 2, 3).astype(bool).tolist())
        px, start = x[t].reshape(-1, 3), np.where(t[:, 0] == 1, -1, 1)
        order, ways = np.arange(3), start.copy()
        axis, heading = main_axis(x, 0, 1)
        if sort_by_floats(px, np.arange(3), axis, heading, order, ways, 3, np.empty(3)):
            told += 1
            assert order.tolist() == expected
        order, ways, pt = np.arange(3), start.copy(), np.arange(9).reshape(-1, 3)
        m, w = frame_of(px)
        around = np.empty((3, N_AROUND))
        assert sort_around(x, 0, 1, order, ways, around, 3, np.arange(3), px, pt, m, w)
        assert order.tolist() == expected
    assert told < 10 if spread == 1 else told > 90


def test_half_planes_that_are_one_have_no_order(rng):
    for pair in itertools.combinations(range(4), 2):
        tips = rng.integers(-9, 10, (4, 3)).astype(float)
        d = np.array([3.0, -5.0, 7.0])
        tips[pair[1]] = 2 * tips[pair[0]] + d
        assert slow_order(d, tips) is None
        x, t = fan(d, tips, [True, False, True, False])
        px, pt = x[t].reshape(-1, 3), np.arange(12).reshape(-1, 3)
        order, ways = np.arange(4), np.array([-1, 1, -1, 1])
        axis, heading = main_axis(x, 0, 1)
        assert not sort_by_floats(px, np.arange(4), axis, heading, order, ways, 4, np.empty(4)), (
            pair
        )
        order, ways = np.arange(4), np.array([-1, 1, -1, 1])
        m, w = frame_of(px)
        around = np.empty((4, N_AROUND))
        assert not sort_around(x, 0, 1, order, ways, around, 4, np.arange(4), px, pt, m, w), pair


def test_half_planes_too_near_for_doubles_ask_for_exact_numbers():
    tips = np.array([[0, 1.0, 0], [0, 1.0, 2.0**-60], [0, -1.0, 0]])
    x, t = fan(np.array([1.0, 0, 0]), tips, [False] * 3)
    ring, part = ring_of(3), np.arange(3)
    link = np.where(ring == np.arange(9), FREE, PAIRED)
    px, pt, none = x[t].reshape(-1, 3), np.arange(9).reshape(-1, 3), np.empty(0, dtype=np.int64)
    first = open_edges(t, ring, link, part, 0, 9)
    start, seams = np.empty(len(first) + 1, dtype=np.int64), np.empty(9, dtype=np.int64)
    arguments = (x, t, ring, first, part, part, px, pt)
    assert sort_seams(*arguments, none, none, start, seams) == NEEDS_EXACT
    assert sort_seams(*arguments, *frame_of(px), start, seams) == DONE
