"""Signs against rationals. GEOSURF_CASES sets how many.

``GEOSURF_CASES=1000000 python -m pytest tests/kernels/test_predicates.py`` takes a minute.
"""

from __future__ import annotations

import os
from fractions import Fraction
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf.errors import SurfaceError
from geosurf.kernels.exact.predicates import flat_triangles, frame_of, normal_axis, scale_of
from tests import oracles
from tests.kernels.families import FAMILIES, PREDICATES, kernel_signs, share, true_signs, tuples

CASES = int(os.environ.get("GEOSURF_CASES", "20000"))
every_predicate = pytest.mark.parametrize("name", PREDICATES)
every_family = pytest.mark.parametrize("family", FAMILIES)


@every_predicate
@every_family
def test_signs_are_never_wrong(name, family):
    points = tuples(family, share(CASES), *PREDICATES[name], seed=7)
    true = true_signs(name, points)
    found = kernel_signs(name, points)
    wrong = np.flatnonzero(true != found)
    assert len(wrong) == 0, (points[wrong[0]].tolist(), true[wrong[0]], found[wrong[0]])
    assert {-1, 1} <= set(true.tolist()), "the family is one-sided: it tests nothing"


@every_predicate
@pytest.mark.parametrize("family", ["lattice", "cocircular", "nudged", "powers"])
def test_families_hold_exact_zeros_where_they_should(name, family):
    points = tuples(family, 4000, *PREDICATES[name], seed=7)
    zeros = (true_signs(name, points) == 0).sum()
    assert zeros > (400 if family == "lattice" else 0) or (name, family) == ("incircle", "nudged")


@every_predicate
@every_family
def test_two_oracles_agree(name, family):
    points = tuples(family, 40, *PREDICATES[name], seed=8)
    slow = [getattr(oracles, name)(*p) for p in points]
    assert true_signs(name, points).tolist() == slow


@every_predicate
@every_family
def test_signs_follow_the_order_of_points(name, family):
    points = tuples(family, 150, *PREDICATES[name], seed=9)
    straight = kernel_signs(name, points)
    for order in permutations(range(points.shape[1])):
        n = len(order)
        odd = sum(order[i] > order[j] for i in range(n) for j in range(i + 1, n)) % 2
        np.testing.assert_array_equal(
            kernel_signs(name, points[:, order]), -straight if odd else straight
        )


@every_predicate
def test_mirrors_shifts_and_powers_of_two(name):
    points = tuples("lattice", 2000, *PREDICATES[name], seed=10)
    signs = kernel_signs(name, points)
    assert signs.any()
    mirror = np.ones(points.shape[2])
    mirror[0] = -1.0
    np.testing.assert_array_equal(kernel_signs(name, points * mirror), -signs)
    np.testing.assert_array_equal(kernel_signs(name, points * 2.0**-20 + 456_000.0), signs)
    np.testing.assert_array_equal(kernel_signs(name, points * 2.0**200), signs)
    # the products underflow, the answers do not
    np.testing.assert_array_equal(kernel_signs(name, points * 2.0**-300), signs)


def test_conventions():
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    assert kernel_signs("orient2d", square[None, :3]) == 1
    assert kernel_signs("incircle", np.array([[*square[:3], (0.5, 0.5)]])) == 1
    assert kernel_signs("incircle", np.array([[*square[:3], (0.0, 1.0)]])) == 0
    up = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]])
    assert kernel_signs("orient3d", up) == 1


@given(
    st.lists(
        st.one_of(
            st.floats(-(2.0**40), 2.0**40, allow_subnormal=True),
            st.sampled_from([5e-324, -0.0, 1.5, 3.0 * 2.0**-1070, 2.0**-1022, 2.0**60]),
            st.builds(lambda m, k: m * 2.0**k, st.integers(-9, 9), st.integers(-80, 50)),
        ),
        min_size=2,
        max_size=12,
    )
)
def test_scale_of_many_is_the_finest_of_all(values):
    assert scale_of(np.array(values)) == scale_by_fractions(values)
    # what comes behind blocks of numbers that say less
    many = [values[0], *([1.0, -3.0, 0.0] * 200), *values]
    assert scale_of(np.array(many)) == scale_by_fractions(many)


def scale_by_fractions(values):
    """Denominators are powers of two."""
    finest, top = [], []
    for value in values:
        if value != 0.0:
            over, under = Fraction(value).as_integer_ratio()
            finest.append(under.bit_length() - 1 - ((over & -over).bit_length() - 1))
            top.append(abs(over).bit_length() - (under.bit_length() - 1))
    k = max(finest, default=0)
    return (k, max(top) + k) if finest else (0, 1)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_scale_of_what_is_not_finite(bad):
    for values in ([bad], [1.0, bad], [*([1.5, 4.0] * 400), bad, 2.0]):
        assert scale_of(np.array(values))[1] == -1


def test_flat_triangles_are_found_exactly():
    x = np.array([[0.0, 0, 0], [0.1, 0.2, 0.3], [0.2, 0.4, 0.6], [0.2, 0.4, np.nextafter(0.6, 1)]])
    t = np.array([[0, 1, 2], [0, 1, 3], [1, 1, 3], [2, 3, 0]])
    m, w = frame_of(x)
    true = [i for i, row in enumerate(t) if oracles.flat(x[row])]
    assert flat_triangles(x, t, m, w).tolist() == true == [0, 2]


def test_numbers_that_cannot_be_used_are_refused():
    with pytest.raises(SurfaceError, match="not finite; leave out nodes"):
        frame_of(np.array([[0.0, np.nan, 1.0]]))
    with pytest.raises(SurfaceError, match=r"span \d+ binary digits.*Set numbers that mean zero"):
        frame_of(np.array([[1e-200, 1e200, 1.0]]))


@pytest.mark.parametrize("jitter", [0.0, 2.0**-50, 2.0**-20])
def test_the_longest_axis_of_a_normal_where_two_are_as_long_but_for_rounding(rng, jitter):
    """Seen alike from two sides, and the third as long, half as long, or none."""
    ties = 0
    for number in range(120):
        u, v = rng.uniform(-9, 9, (2, 3))
        turn = np.roll(np.arange(3), number % 3)
        third = (1.0, 0.5, 0.0)[number // 3 % 3]
        along = np.array([1.0, -1.0, 0.0])[turn]
        across = np.array([third, third, -2.0])[turn] / 2
        corners = np.stack([0 * u, u[0] * along + u[1] * across, v[0] * along + v[1] * across])
        corners = corners + rng.integers(-1, 2, (3, 3)) * jitter + u[2]
        a, b, c = oracles.rational(corners)
        normal = oracles.cross(oracles.minus(b, a), oracles.minus(c, a))
        lengths = [abs(value) for value in normal]
        axis = lengths.index(max(lengths))
        m, w = frame_of(corners)
        assert normal_axis(corners, m, w, 0, 1, 2) == (axis, oracles.sign(normal[axis]))
        first, second, _ = sorted(lengths)[::-1]
        ties += float((first - second) / first) < 2.0**-40
    assert ties > 60 if jitter < 2.0**-40 else ties < 60
