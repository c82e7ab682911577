"""Decimals in bulk are rounded as Python does, or left to others."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf.read._decimals import decimal_rows, plain_decimals

sign = st.sampled_from(["", "-", "+"])
digits = st.text("0123456789", min_size=1, max_size=18)


@st.composite
def words(draw):
    """Any plain decimal of up to 18 digits."""
    found = draw(digits)
    point = draw(st.integers(0, len(found) + 1))
    body = found if point > len(found) else f"{found[:point]}.{found[point:]}"
    return draw(sign) + body


def assert_same(texts):
    found = plain_decimals(" ".join(texts).encode())
    assert found is not None
    assert found.tobytes() == np.array([float(text) for text in texts]).tobytes()


@given(st.lists(st.one_of(words(), st.floats(-1e15, 1e15).map(lambda x: f"{x:.1f}")), min_size=1))
def test_law_plain_decimals_are_rounded_as_python_does(texts):
    texts = [text for text in texts if sum(map(str.isdigit, text)) <= 18]
    if texts:
        assert_same(texts)


@given(st.integers(2**52, 2**53 - 2), st.integers(1, 6), st.integers(-1, 1))
def test_law_halfway_between_two_doubles(odd, power, step):
    # (2 k + 1) / 2**power lies halfway between two doubles; its neighbours in the last digit do not
    middle = Fraction(2 * odd + 1, 2**power)
    n = min(power, 2)
    if middle * 10**n % 1 == 0:
        whole = int(middle * 10**n) + step
        text = f"{whole:019d}"
        text = f"{text[:-n]}.{text[-n:]}".lstrip("0")
        if len(text) <= 19:
            assert_same([text, f"-{text}"])


@pytest.mark.parametrize(
    "word",
    [
        "1-2",
        "1e999",
        "1e",
        "e5",
        "1e3-2",
        "--1e3",
        "--1",
        ".",
        "-",
        "1..2",
        "1.2.3",
        "1_0",
        "nan",
        "1+",
        "1,5",
        "1D3",
        "1e3.",
        "0x1",
        "1\x0b2",
        "1\r2",
        "\xc3\xa9",
        "inf",
    ],
)
def test_other_words_are_left_to_others(word):
    assert plain_decimals(f"5 {word} 6".encode()) is None


def test_nothing_and_blanks():
    assert len(plain_decimals(b"")) == len(plain_decimals(b" \n\t ")) == 0
    assert plain_decimals(b"\n-0 5. .5\n007").tolist() == [0.0, 5.0, 0.5, 7.0]


exponents = st.integers(-330, 330).map(str) | st.sampled_from(["+07", "-007", "00"])


@given(
    st.lists(
        st.builds(
            lambda sign, body, e, power: f"{sign}{body}{e}{power}" if e else f"{sign}{body}",
            sign,
            st.from_regex(r"[0-9]{1,30}(\.[0-9]{0,30})?|\.[0-9]{1,30}", fullmatch=True),
            st.sampled_from(["", "e", "E"]),
            exponents,
        ),
        min_size=1,
    )
)
def test_law_any_decimal_is_rounded_as_python_does(texts):
    texts = [text for text in texts if np.isfinite(float(text))]
    if texts:
        assert_same(texts)


@given(st.floats(allow_nan=False, allow_infinity=False), st.integers(0, 40))
def test_law_doubles_with_any_number_of_digits(value, n):
    texts = [repr(value), f"{value:.{n}e}", f"{value:.{n}f}"]
    assert_same([text for text in texts if np.isfinite(float(text))])  # 1.8e308 is too large


@given(
    st.lists(
        st.tuples(st.lists(st.integers(-99, 99), max_size=4), st.sampled_from([" ", "\t", "  "])),
        max_size=30,
    ),
    st.booleans(),
)
def test_law_rows_have_one_width_and_know_their_lines(rows, with_end):
    text = "\n".join(blank.join(map(str, row)) for row, blank in rows) + "\n" * with_end
    found = decimal_rows(text.encode(), 3, 7)
    full = [(k, row) for k, (row, _) in enumerate(rows, start=7) if row]
    if any(len(row) != 3 for _, row in full):
        assert found is None
    else:
        assert found[0].tolist() == [row for _, row in full]
        assert found[1].tolist() == [k for k, _ in full]
