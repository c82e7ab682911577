"""Signs against rationals. GEOSURF_CASES sets how many.

``GEOSURF_CASES=1000000 python -m pytest tests/kernels/test_predicates.py`` takes a minute.
"""

from __future__ import annotations

import os
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf.errors import SurfaceError
from geosurf.kernels.exact import bigint, exact_signs
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
    # a family that is one-sided, or never degenerate, tests nothing
    assert {-1, 1} <= set(true.tolist())
    degenerate = ("lattice", "powers", "cocircular", "nudged")[: 3 if name == "incircle" else 4]
    assert (true == 0).any() or family not in degenerate


@every_predicate
@every_family
def test_two_oracles_agree(name, family):
    points = tuples(family, 40, *PREDICATES[name], seed=8)
    slow = [getattr(oracles, name)(*p) for p in points]
    assert true_signs(name, points).tolist() == slow


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


# ---- Limb arithmetic against Python's own integers, and rounding against Fraction.
BITS = bigint.BITS
N = 8
whole = st.integers(-(2 ** (BITS * N - 8)), 2 ** (BITS * N - 8)) | st.integers(-9, 9)
powers = st.builds(
    lambda e, s, d: s * 2**e + d,
    st.integers(0, BITS * N - 9),
    st.sampled_from([-1, 1]),
    st.integers(-1, 1),
)
number = whole | powers
doubles = st.floats(-(2.0**60), 2.0**60, allow_nan=False).filter(lambda x: x == 0 or abs(x) > 1e-30)


def put(w, at, value, n=N):
    """Write a Python int as limbs; the last one carries the sign."""
    for i in range(n - 1):
        w[at + i] = value & bigint.MASK
        value >>= BITS
    w[at + n - 1] = value


def get(w, at, n=N) -> int:
    """Read limbs as a Python int, and check that they are in normal form."""
    part = [int(v) for v in w[at : at + n]]
    assert all(0 <= v <= bigint.MASK for v in part[:-1]), part
    return sum(v << (BITS * i) for i, v in enumerate(part))


@pytest.fixture(scope="module")
def w():
    return np.full(400, 77, dtype=np.int64)


@given(
    a=number, b=number, c=number, factor=st.sampled_from([-1, 1]), more=st.integers(0, 4),
    bits=st.integers(0, 130),
)  # fmt: skip
def test_law_limbs_compute_as_integers_do(w, a, b, c, factor, more, bits):
    """Also in place, and with numbers that are longer than others."""
    put(w, 0, a), put(w, 20, b), put(w, 60, c, 2 * N + more)
    bigint.sub(w, 100, 0, 20, N)
    assert get(w, 100) == a - b
    bigint.mul(w, 100, 0, N, 20, N)
    assert get(w, 100, 2 * N) == a * b
    bigint.mul_add(w, 60, 2 * N + more, 0, N, 20, N, factor)
    assert get(w, 60, 2 * N + more) == c + factor * a * b
    length = bigint.shift_left(w, 100, 0, N, bits)
    assert length == N + bits // BITS + 1
    assert get(w, 100, length) == a << bits
    assert bigint.sign(w, 0, N) == (a > 0) - (a < 0)
    bigint.negate(w, 0, N)
    assert get(w, 0) == -a
    put(w, 0, a, N + more)
    bigint.accumulate(w, 0, N + more, 20, N, 2 * factor)
    assert get(w, 0, N + more) == a + 2 * factor * b
    bigint.sub(w, 20, 20, 20, N)
    assert get(w, 20) == 0


@given(x=doubles, spare=st.integers(0, 3))
def test_load(w, x, spare):
    f = Fraction(x)
    k = f.denominator.bit_length() - 1 + spare
    value = int(f * 2**k)
    n = (abs(value).bit_length() + 3 + BITS - 1) // BITS
    w[40:] = 77  # old numbers must not shine through
    bigint.load(w, 40, n, x, k)
    assert get(w, 40, n) == value
    if value % 4 == 0:  # a scale that is a multiple of the unit
        bigint.load(w, 40, n, x, k - 2)
        assert get(w, 40, n) == value // 4


@given(a=number.map(abs).filter(bool))
def test_leading(w, a):
    put(w, 0, a)
    m, e = bigint.leading(w, 0, N)
    assert abs(Fraction(m) * Fraction(2) ** e - a) <= Fraction(a, 2**50)


@st.composite
def quotients(draw):
    """X, W, k: plain ones, ties between two doubles, and neighbours of ties and powers of two."""
    mantissa = draw(st.integers(2**52, 2**53 - 1) | st.sampled_from([2**52, 2**53 - 1]))
    below = draw(st.integers(1, 2**60))
    half = draw(st.sampled_from([0, 1]))
    nudge = draw(st.sampled_from([0, 0, 1, -1]))
    top = (2 * mantissa + half) * below + nudge
    k = draw(st.integers(-10, 80))
    return draw(st.sampled_from([-1, 1])) * top, below, k


@given(
    q=quotients()
    | st.tuples(st.integers(-(2**120), 2**120), st.integers(1, 2**120), st.integers(-10, 80))
)
def test_rounding_is_correct(w, q):
    top, below, k = q
    m = np.zeros(exact_signs.N_META, dtype=np.int64)
    m[exact_signs.LIMBS], m[exact_signs.SCALE] = 4, k
    space = exact_signs.workspace(4)
    put(space, 0, top, 7), put(space, 20, below, 6)
    found = exact_signs.exact_round(m, space, 0, 7, 20, 6)
    true = Fraction(top, below) / Fraction(2) ** k
    assert found == true.numerator / true.denominator
    assert m[exact_signs.EXACT_ROUND] == 1
