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
WHOLE_TENS = np.array([10**k if k < 20 else 0 for k in range(WIDTH + 1)], dtype=np.uint64)


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
    windows = np.lib.stride_tricks.sliding_window_view(text, width)
    chars = np.ascontiguousarray(windows[ends - width].T)
    np.copyto(chars, ord(" "), where=np.arange(width, 0, -1)[:, None] > lengths)
    digit = chars - np.uint8(ZERO)
    is_digit = digit < 10
    is_point = chars == POINT
    first = text[starts]
    signed = (first == MINUS) | (first == PLUS)
    with_powers = b"e" in data or b"E" in data
    powers = ((chars | 32) == ord("e")).any(axis=0) if with_powers else np.zeros(len(starts), bool)
    n_digit, n_point = (
        np.add.reduce(one.view(np.uint8), axis=0, dtype=np.uint8) for one in (is_digit, is_point)
    )
    odd = (n_digit + n_point + signed != lengths) | (n_point > 1) | (n_digit < 1)
    long = n_digit > MOST
    if (odd & ~powers).any() or long.mean() > FEW:
        return None
    powers |= long

    # how many digits follow the point: the place of the point, counted from the end
    from_end = np.arange(width - 1, -1, -1, dtype=np.uint8)[:, None]
    n_after = np.add.reduce(is_point * from_end, axis=0, dtype=np.uint8).astype(np.int64)
    n_after[powers] = 0

    # a point stands as a zero among the digits: those before it are shifted by one place
    whole = _whole(digit * is_digit)
    with_point = n_point > 0
    after = whole % WHOLE_TENS[n_after]
    whole = np.where(with_point, (whole - after) // np.uint64(10) + after, whole)
    whole[powers] = 0
    whole = whole.astype(np.int64)
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


def _whole(digits: np.ndarray) -> np.ndarray:
    """Whole numbers (n,) of digits (width, n), in uint64: neighbours are joined pair by pair."""
    rows = -(-len(digits) // 8) * 8
    parts: np.ndarray = np.zeros((rows, digits.shape[1]), dtype=np.uint8)
    parts[rows - len(digits) :] = digits
    for factor, kind in ((10, np.uint8), (100, np.uint16), (10_000, np.uint32)):
        left: np.ndarray = parts[::2].astype(kind)
        parts = left * factor + parts[1::2]
    whole = parts[0].astype(np.uint64)
    for part in parts[1:]:
        whole = whole * np.uint64(100_000_000) + part
    return whole


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
