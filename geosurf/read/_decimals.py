"""Plain decimals in text to float64, in bulk, rounded as Python does.

A word is a sign, digits and a point: a whole number m below 10**18 over a power of ten. Below 2**53
one division rounds correctly. Larger m is a sum of two doubles, and the quotient is corrected by
its exact remainder (Dekker's product); where the correction is too near to half a step to be sure,
Python decides on that word. So it does on words with exponents, which are mostly one null value
many times, and on a few with more digits. Texts with many of these are left to the caller.
"""

from __future__ import annotations

import numpy as np

BLOCK = 1 << 18  # bytes at a time
WIDTH = 24  # longest word
MOST = 18  # digits of a whole number that int64 holds
EXACT = 2.0**53
SPLIT = 134217729.0  # 2**27 + 1, halves a double
SURE = 0.5 - 1e-9  # of a step: what a correction may be for its rounding to be certain
MINUS, PLUS, POINT, ZERO = b"-+.0"
FEW = 0.1  # of the words may have more digits
TENS = 10.0 ** np.arange(MOST + 1)


def plain_decimals(data: bytes) -> np.ndarray | None:
    r"""
    Return all words of a text as float64, or None if one is something else.

    Parameters
    ----------
    data : bytes
        Digits, signs, points, and blanks or line ends between words.

    Returns
    -------
    ndarray of float64, shape (n_word,), or None

    Examples
    --------
    >>> plain_decimals(b"1 -2.5\n .5"), plain_decimals(b"1-2"), plain_decimals(b"1E+30")
    (array([ 1. , -2.5,  0.5]), None, array([1.e+30]))
    """
    # pieces of whole words, which stay in the cache
    parts, at = [np.empty(0)], 0
    while at < len(data):
        ends = [k for k in (data.find(b"\n", at + BLOCK), data.find(b" ", at + BLOCK)) if k >= 0]
        end = min(ends, default=len(data))
        found = _piece(data[at:end])
        if found is None:
            return None
        parts.append(found)
        at = end
    return np.concatenate(parts)


def _piece(data: bytes) -> np.ndarray | None:
    """Words of a piece of text."""
    # words are what lies between blanks; padded, so that each has WIDTH characters before its end
    text = np.frombuffer(b" " * WIDTH + data + b" ", dtype=np.uint8)
    solid = text > ord(" ")
    edges = np.flatnonzero(solid[1:] != solid[:-1]) + 1
    starts, ends = edges[::2], edges[1::2]
    if not len(starts):
        return np.empty(0)
    lengths = ends - starts
    if lengths.max() > WIDTH:
        return None
    width = int(lengths.max())

    # characters (width, n), right-aligned; those of words before are blanked
    places = np.arange(-width, 0)[:, None]
    chars = text[ends + places]
    chars[places < -lengths] = ord(" ")
    digit = chars - np.uint8(ZERO)
    is_digit = digit < 10
    is_point = chars == POINT
    first = text[starts]
    signed = (first == MINUS) | (first == PLUS)
    powers = ((chars | 32) == ord("e")).any(axis=0)
    n_digit, n_point = is_digit.sum(axis=0), is_point.sum(axis=0)
    odd = (n_digit + n_point + signed != lengths) | (n_point > 1) | (n_digit < 1)
    long = n_digit > MOST
    if (odd & ~powers).any() or long.mean() > FEW:
        return None
    powers |= long

    # digits by Horner's rule, and how many of them follow the point
    whole = np.zeros(len(starts), dtype=np.int64)
    for row in range(width):
        np.copyto(whole, whole * 10 + digit[row], where=is_digit[row])
    n_after = np.where(n_point > 0, width - 1 - np.argmax(is_point, axis=0), 0)
    whole[powers] = n_after[powers] = 0
    values, doubtful = _quotients(whole, n_after)
    values = np.where(first == MINUS, -values, values)
    known: dict[bytes, float] = {}
    for k in np.flatnonzero(doubtful | powers).tolist():
        word = text[starts[k] : ends[k]].tobytes()
        try:
            values[k] = known[word] if word in known else known.setdefault(word, float(word))
        except ValueError:
            return None
    return values if np.isfinite(values).all() else None


def _quotients(whole: np.ndarray, n_after: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Whole numbers over powers of ten, and where their rounding is not certain."""
    high, below = whole.astype(np.float64), TENS[n_after]
    values = high / below
    doubtful = np.zeros(len(whole), dtype=bool)
    rows = np.flatnonzero(high >= EXACT)
    if not len(rows):
        return values, doubtful

    # high - quotient * below is a double: product and its error, both exact
    high, below, quotient = high[rows], below[rows], values[rows]
    low = (whole[rows] - high.astype(np.int64)).astype(np.float64)
    product = quotient * below
    a, b = _halves(quotient), _halves(below)
    error = ((a[0] * b[0] - product) + a[0] * b[1] + a[1] * b[0]) + a[1] * b[1]
    rest = (high - product) - error
    correction = (rest + low) / below

    # what is left after the sum is rounded has to be clearly below half a step
    found = quotient + correction
    left = np.abs(correction - (found - quotient))
    step = np.spacing(found)
    values[rows] = found
    at_power = np.frexp(found)[0] == 0.5  # steps below are half as long there
    doubtful[rows] = (left >= SURE * step) | at_power
    return values, doubtful


def _halves(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two doubles of 26 bits whose sum is each value."""
    scaled = SPLIT * values
    high = scaled - (scaled - values)
    return high, values - high


__all__ = ["plain_decimals"]
