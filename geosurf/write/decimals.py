"""Numbers to text in bulk: millions of float64 as decimals that give the same float64 back.

A value is its whole part and its fraction, both exact. The fraction becomes whole numbers of four
digits, and a table turns each into four characters. Characters that are not needed, such as leading
zeros, are zero bytes until the end, where they are dropped.

How many decimals a value gets: the fewest of `SHORT` that give the value back, since a division of
two whole numbers below 2**53 is rounded correctly; else as many as its size needs. Doubles from 512
on are 1.1e-13 apart or more, and the nearest decimal with 13 places is nearer than half of that;
`LONG` has the places for other sizes. Smaller values with more digits, and larger ones than 1e8,
are few in maps: Python writes these, one by one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

AT_ONCE = 16384  # rows at a time: they stay in the cache
SHORT = (1, 3, 6, 9, 12)  # decimals that are tried first
# from this size on that many decimals: 17 digits in all
LONG = (
    (2.0**26, 8), (2.0**23, 9), (2.0**19, 10), (2.0**16, 11), (2.0**13, 12), (512.0, 13),
    (64.0, 14), (8.0, 15),
)  # fmt: skip
LARGEST = 1e8
WIDTH = 32  # bytes for a float: "-" 3, whole part 4-11, "." 15, fraction 16-31
N_FRACTION = 15
MOST_FIXED = 13

Part = np.ndarray | bytes


def _tables() -> tuple[np.ndarray, np.ndarray]:
    """Four characters for each number below 10000: without leading zeros, without trailing ones.

    The upper half of each table has all four digits.
    """
    digits = np.array([list(f"{k:04d}".encode()) for k in range(10_000)], dtype=np.uint8)
    zero = digits == ord("0")
    leading = np.where(np.minimum.accumulate(zero, axis=1), 0, digits)
    trailing = np.where(np.minimum.accumulate(zero[:, ::-1], axis=1)[:, ::-1], 0, digits)
    both = [np.concatenate([short, digits]).astype(np.uint8) for short in (leading, trailing)]
    lead, trail = (np.ascontiguousarray(table).view(np.uint32)[:, 0] for table in both)
    return lead, trail


LEADING, TRAILING = _tables()
ZERO = np.frombuffer(b"\0\0\x000", dtype=np.uint32)[0]  # the whole part of 0.5
ZERO_FRACTION = np.frombuffer(b"0\0\0\0", dtype=np.uint32)[0]  # the fraction of 5.0


def rows_text(parts: Sequence[Part], undefined: bytes = b"nan", head: bytes = b"") -> bytearray:
    r"""
    Return lines of text: in each row one word of every part, one after another.

    Parameters
    ----------
    parts : sequence of bytes or ndarray, shape (n,)
        Bytes stand in every row. Floats become decimals that give the same float64 back, whole
        numbers (not negative, below 1e12) digits. Characters (n, width) stay as they are.
    undefined : bytes
        What stands for NaN.
    head : bytes
        What stands before the rows: a header added later would copy the whole text.

    Returns
    -------
    bytearray

    Examples
    --------
    >>> rows_text([np.array([1, 20]), b" ", np.array([0.5, np.nan]), b"\n"], b"-999")
    bytearray(b'1 0.5\n20 -999\n')
    """
    n = max(len(part) for part in parts if isinstance(part, np.ndarray))
    text = bytearray(head)
    for start in range(0, n, AT_ONCE):
        block = [
            part if isinstance(part, bytes) else part[start : start + AT_ONCE] for part in parts
        ]
        n_row = min(AT_ONCE, n - start)
        fields = [_field(part, n_row, undefined) for part in block]
        text += np.concatenate(fields, axis=1).tobytes().translate(None, b"\0")
    return text


def lines_text(values: np.ndarray, per_line: int, undefined: bytes, head: bytes = b"") -> bytearray:
    r"""
    Return numbers in lines: each row begins a line, and has at most `per_line` numbers on one.

    Parameters
    ----------
    values : ndarray of float64, shape (n_row, n)
    per_line : int
    undefined : bytes
        What stands for NaN.
    head : bytes
        What stands before the rows.

    Returns
    -------
    bytearray

    Examples
    --------
    >>> lines_text(np.arange(6.0).reshape(2, 3), 2, b"nan")
    bytearray(b'0.0 1.0\n2.0\n3.0 4.0\n5.0\n')
    """
    return rows_text([values.ravel(), _ends(values.shape, per_line)], undefined, head)


def fixed_lines_text(
    values: np.ndarray,
    per_line: int,
    n_decimal: int,
    width: int,
    undefined: bytes,
    head: bytes = b"",
) -> bytearray:
    r"""
    Return the same with fields of one width and number of decimals, right-aligned.

    Parameters
    ----------
    values : ndarray of float64, shape (n_row, n)
    per_line : int
    n_decimal : int
        At most 13; see `n_fixed`.
    width : int
    undefined, head : bytes

    Returns
    -------
    bytearray

    Examples
    --------
    >>> fixed_lines_text(np.array([[-1.25, 30.0]]), 2, 1, 6, b"")
    bytearray(b'  -1.2  30.0\n')
    """
    ends = np.where(_ends(values.shape, per_line) == ord("\n"), ord("\n"), 0).astype(np.uint8)
    values = values.ravel()
    nothing = np.frombuffer(undefined.rjust(width), dtype=np.uint8)
    text = bytearray(head)
    for start in range(0, len(values), AT_ONCE):
        part = values[start : start + AT_ONCE]
        fields = np.full((len(part), width + 1), ord(" "), dtype=np.uint8)
        rows = _fixed(part, n_decimal)[:, -width:]
        fields[:, width - rows.shape[1] : width] = np.where(rows == 0, ord(" "), rows)
        fields[np.isnan(part), :width] = nothing
        fields[:, width:] = ends[start : start + AT_ONCE]
        text += fields.tobytes().translate(None, b"\0")
    return text


def _ends(shape: tuple[int, ...], per_line: int) -> np.ndarray:
    """The character after each number: a blank, or a line end."""
    ends = np.full(shape, ord(" "), dtype=np.uint8)
    ends[:, per_line - 1 :: per_line] = ord("\n")
    ends[:, -1] = ord("\n")
    return ends.reshape(-1, 1)


def n_fixed(values: np.ndarray, width: int) -> int:
    """Return how many decimals fields of a width need to be exact, or else have room for."""
    size = np.abs(values[~np.isnan(values)])
    largest = float(size.max(initial=0.0))
    room = width - 2 - len(str(int(min(largest, LARGEST)) + 1)) - 1  # blank, sign, point
    for n in SHORT:
        # a few values show that most maps have more decimals
        if n <= room and _is_short(size[:1000], n).all() and _is_short(size, n).all():
            return n
    return max(1, min(room, MOST_FIXED))


def _field(part: Part, n_row: int, undefined: bytes) -> np.ndarray:
    """Characters of one part for some rows, shape (n_row, width)."""
    if isinstance(part, bytes):
        return np.broadcast_to(np.frombuffer(part, dtype=np.uint8), (n_row, len(part)))
    if part.ndim == 2:
        return part
    return _whole(part) if part.dtype.kind in "iu" else _float(part, undefined)


def _whole(values: np.ndarray) -> np.ndarray:
    """Digits of whole numbers, without leading zeros."""
    rest, low = _split(values.astype(np.int64))
    high, middle = _split(rest)
    words = np.empty((len(values), 3), dtype=np.uint32)
    words[:, 0] = LEADING[high]
    words[:, 1] = LEADING[middle + 10_000 * (high > 0)]
    words[:, 2] = LEADING[low + 10_000 * (rest > 0)]
    words[values == 0, 2] = ZERO
    return words.view(np.uint8)


def _split(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Whole numbers without their last four digits, and these; `np.divmod` takes three times it."""
    high = values // 10_000
    return high, values - 10_000 * high


def _is_short(size: np.ndarray, n: int) -> np.ndarray:
    """Whether each value is a decimal with n places, exactly."""
    scaled = np.rint(size * 10.0**n)
    exact: np.ndarray = (scaled / 10.0**n == size) & (scaled < 2.0**53)
    return exact


def _float(values: np.ndarray, undefined: bytes) -> np.ndarray:
    """Decimals of floats, shape (n, WIDTH)."""
    values = np.ascontiguousarray(values, dtype=np.float64)
    size = np.abs(values)
    whole = np.floor(np.where(size < LARGEST, size, 0.0))

    # the fewest decimals that are tried and give the value back, else as many as its size needs
    places = np.full(len(values), -1)
    open_rows = np.flatnonzero(size < LARGEST)
    for n in SHORT:
        short = _is_short(size[open_rows], n)
        places[open_rows[short]] = n
        open_rows = open_rows[~short]
        if not len(open_rows):
            break
    for least, n in LONG:
        large = size[open_rows] >= least
        places[open_rows[large]] = n
        open_rows = open_rows[~large]

    # fraction as a whole number of 15 digits; rounding may carry into the whole part
    used = np.maximum(places, 0)
    fraction = np.rint((np.where(size < LARGEST, size, 0.0) - whole) * 10.0**used)
    digits = fraction.astype(np.int64) * (10 ** (N_FRACTION - used)).astype(np.int64)
    over = digits >= 10**N_FRACTION
    rows = _words(whole.astype(np.int64) + over, np.where(over, 0, digits))
    rows[:, 3] = np.where(np.signbit(values), ord("-"), 0)
    for row in np.flatnonzero(places < 0).tolist():
        word = undefined if np.isnan(values[row]) else repr(float(values[row])).encode()
        rows[row] = np.frombuffer(word.ljust(WIDTH, b"\0"), dtype=np.uint8)
    return rows


def _whole_words(whole: np.ndarray) -> np.ndarray:
    """Characters of whole parts and the point behind them, four in each word."""
    words = np.zeros((len(whole), WIDTH // 4), dtype=np.uint32)
    high, low = _split(whole)
    words[:, 1] = LEADING[high]
    words[:, 2] = np.where(whole == 0, ZERO, LEADING[low + 10_000 * (high > 0)])
    words[:, 3] = np.frombuffer(b"\0\0\0.", dtype=np.uint32)[0]
    return words


def _words(whole: np.ndarray, digits: np.ndarray) -> np.ndarray:
    """Characters of whole parts and of fractions of 15 digits, without needless zeros."""
    words = _whole_words(whole)

    # groups of four digits from the right; those before others that are not zero stand whole
    rest = digits * 10
    later = np.zeros(len(whole), dtype=bool)
    for place in (7, 6, 5):
        rest, group = _split(rest)
        words[:, place] = TRAILING[group + 10_000 * later]
        later |= group > 0
    first = TRAILING[rest + 10_000 * later]
    words[:, 4] = np.where((rest == 0) & ~later, ZERO_FRACTION, first)
    return words.view(np.uint8)


def _fixed(values: np.ndarray, n_decimal: int) -> np.ndarray:
    """Characters with a fixed number of decimals; a zero byte stands where a blank will."""
    size = np.where(np.isnan(values), 0.0, np.abs(values))
    whole = np.floor(size)
    fraction = np.rint((size - whole) * 10.0**n_decimal).astype(np.int64)
    over = fraction >= 10**n_decimal
    whole = whole.astype(np.int64) + over
    digits = np.where(over, 0, fraction) * 10 ** (N_FRACTION - n_decimal)

    # full groups here: trailing zeros stay
    words = _whole_words(whole)
    rest = digits * 10
    for place in (7, 6, 5, 4):
        rest, group = _split(rest)
        words[:, place] = TRAILING[group + 10_000]
    rows = words.view(np.uint8)

    # the sign stands right before the first digit
    n_digit = 1 + np.searchsorted(10 ** np.arange(1, 9), whole, side="right")
    below = np.flatnonzero(np.signbit(values) & ~np.isnan(values))
    rows[below, 11 - n_digit[below]] = ord("-")
    keep = [*range(3, 12), 15, *range(16, 16 + n_decimal)]
    return rows[:, keep]
