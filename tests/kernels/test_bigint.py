"""Limb arithmetic against Python's own integers, and rounding against Fraction."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf.kernels.exact import bigint, exact_signs

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


@given(a=number, b=number)
def test_sub(w, a, b):
    put(w, 0, a), put(w, 20, b)
    bigint.sub(w, 40, 0, 20, N)
    assert get(w, 40) == a - b
    bigint.sub(w, 0, 0, 20, N)  # in place
    assert get(w, 0) == a - b


@given(a=number, b=number, factor=st.sampled_from([-2, -1, 1, 2]))
def test_add_with_a_factor(w, a, b, factor):
    put(w, 0, a), put(w, 20, b)
    bigint.accumulate(w, 0, N, 20, N, factor)
    assert get(w, 0) == a + factor * b


@given(a=number, b=number, factor=st.sampled_from([-1, 1]))
def test_add_to_a_longer_number(w, a, b, factor):
    put(w, 0, a, N + 5), put(w, 20, b)
    bigint.accumulate(w, 0, N + 5, 20, N, factor)
    assert get(w, 0, N + 5) == a + factor * b


@given(a=number, b=number)
def test_mul(w, a, b):
    put(w, 0, a), put(w, 20, b)
    bigint.mul(w, 40, 0, N, 20, N)
    assert get(w, 40, 2 * N) == a * b


@given(a=number, b=number, c=number, factor=st.sampled_from([-1, 1]), more=st.integers(0, 4))
def test_mul_add(w, a, b, c, factor, more):
    put(w, 0, a), put(w, 20, b), put(w, 60, c, 2 * N + more)
    bigint.mul_add(w, 60, 2 * N + more, 0, N, 20, N, factor)
    assert get(w, 60, 2 * N + more) == c + factor * a * b


@given(a=number, b=st.integers(-(2**50), 2**50))
def test_mul_of_unequal_lengths(w, a, b):
    put(w, 0, a), put(w, 20, b, 2)
    bigint.mul(w, 40, 0, N, 20, 2)
    bigint.mul(w, 60, 20, 2, 0, N)
    assert get(w, 40, N + 2) == get(w, 60, N + 2) == a * b


@given(a=number, bits=st.integers(0, 130))
def test_shift(w, a, bits):
    put(w, 0, a)
    length = bigint.shift_left(w, 40, 0, N, bits)
    assert length == N + bits // BITS + 1
    assert get(w, 40, length) == a << bits


@given(a=number)
def test_sign_and_negate(w, a):
    put(w, 0, a)
    assert bigint.sign(w, 0, N) == (a > 0) - (a < 0)
    bigint.negate(w, 0, N)
    assert get(w, 0) == -a


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
