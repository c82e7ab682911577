"""Numbers to text: decimals that give the same float64 back, as Python writes them."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence

import numpy as np

AT_ONCE = 16384  # rows at a time: words take many times the memory of numbers
SHORT = (1, 3, 6, 9, 12)  # decimals that are tried first
LARGEST = 1e8
MOST_FIXED = 13

Part = np.ndarray | bytes


def rows_text(parts: Sequence[Part], undefined: bytes = b"nan", head: bytes = b"") -> bytearray:
    r"""
    Return lines of text: in each row one word of every part, one after another.

    Parameters
    ----------
    parts : sequence of bytes or ndarray, shape (n,)
        Bytes stand in every row. Floats become decimals that give the same float64 back, whole
        numbers digits.
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
        columns = (
            itertools.repeat(part.decode())
            if isinstance(part, bytes)
            else _words(part[start : start + AT_ONCE], repr, undefined)
            for part in parts
        )
        text += "".join(itertools.chain.from_iterable(zip(*columns, strict=False))).encode()
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
    return _lines(values, per_line, repr, undefined, " ", head)


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
        See `n_fixed`.
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
    form = f"%{width}.{n_decimal}f".__mod__
    return _lines(values, per_line, form, undefined.rjust(width), "", head)


def n_fixed(values: np.ndarray, width: int) -> int:
    """Return how many decimals fields of a width need to be exact, or else have room for."""
    size = np.abs(values[~np.isnan(values)])
    largest = float(size.max(initial=0.0))
    room = width - 2 - len(str(int(min(largest, LARGEST)) + 1)) - 1  # blank, sign, point
    for n in SHORT:
        # a few values show that most maps have more decimals
        if n <= room and _is_short(size[:1000], n) and _is_short(size, n):
            return n
    return max(1, min(room, MOST_FIXED))


def _is_short(size: np.ndarray, n: int) -> bool:
    """Whether all values are decimals with n places, exactly."""
    scaled = np.rint(size * 10.0**n)
    return bool(((scaled / 10.0**n == size) & (scaled < 2.0**53)).all())


def _lines(
    values: np.ndarray,
    per_line: int,
    form: Callable[[float], str],
    undefined: bytes,
    between: str,
    head: bytes,
) -> bytearray:
    """Words of each row, in lines of at most `per_line`."""
    n = values.shape[1]
    last = [(k + 1) % per_line == 0 or k == n - 1 for k in range(n)]
    ends: Iterator[str] = itertools.cycle("\n" if one else between for one in last)
    text, values = bytearray(head), values.ravel()
    for start in range(0, len(values), AT_ONCE):
        words = _words(values[start : start + AT_ONCE], form, undefined)
        pairs = zip(words, ends, strict=False)
        text += "".join(itertools.chain.from_iterable(pairs)).encode()
    return text


def _words(values: np.ndarray, form: Callable[[float], str], undefined: bytes) -> list[str]:
    """A word for each number."""
    if values.dtype.kind in "iu":
        return [*map(str, values.tolist())]
    words = [*map(form, values.astype(np.float64, copy=False).tolist())]
    for k in np.flatnonzero(np.isnan(values)).tolist():
        words[k] = undefined.decode()
    return words
