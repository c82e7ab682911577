"""Numbers in text to float64, in bulk, rounded as Python does.

The kernels of `geosurf.kernels.text` read words; those whose rounding is not certain, and exponents
beyond their powers of ten, are read by Python one by one, equal ones once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

TENS = 10.0 ** np.arange(23)


@dataclass(frozen=True, eq=False)
class Words:
    """
    A text as kernels take it.

    Attributes
    ----------
    data : bytes
    packed : ndarray of int64
        Eight characters each, and a line end or more behind the last one.
    """

    data: bytes
    packed: np.ndarray

    @classmethod
    def of(cls, data: bytes) -> Words:
        """Pack a text."""
        padded = data + b"\n" * (16 - len(data) % 8)
        return cls(data, np.frombuffer(padded, dtype="<i8"))

    def read_hard(self, values: np.ndarray, hard: np.ndarray) -> bool:
        """
        Read the words that kernels left to Python.

        Parameters
        ----------
        values : ndarray of float64, shape (n,)
            Written.
        hard : ndarray of int64, shape (m, 3)
            Rows of `values`, first characters and ends.

        Returns
        -------
        bool
            Whether all of them are finite.
        """
        known: dict[bytes, float] = {}
        for row, start, end in hard.tolist():
            word = self.data[start:end]
            if word not in known:
                known[word] = float(word)
            values[row] = known[word]
        return all(np.isfinite(value) for value in known.values())


def plain_decimals(data: bytes) -> np.ndarray | None:
    r"""
    Return all words of a text as float64, or None if one is something else.

    Parameters
    ----------
    data : bytes
        Words, and blanks, tabs or line ends between them.

    Returns
    -------
    ndarray of float64, shape (n_word,), or None

    Examples
    --------
    >>> plain_decimals(b"1 -2.5\n .5"), plain_decimals(b"1-2"), plain_decimals(b"1E+30")
    (array([ 1. , -2.5,  0.5]), None, array([1.e+30]))
    """
    found = _numbers(data, 0, 1)
    return None if found is None else found[0]


def decimal_rows(data: bytes, width: int, line: int) -> tuple[np.ndarray, np.ndarray] | None:
    r"""
    Return the numbers of lines that have the same count of them, or None if one has not.

    Parameters
    ----------
    data : bytes
        Whole lines.
    width : int
        Words of each line that is not empty.
    line : int
        Number of the first line.

    Returns
    -------
    (ndarray of float64, shape (n, width), ndarray of int64, shape (n,)) or None
        Numbers, and the line of each row.

    Examples
    --------
    >>> decimal_rows(b"1 2\n\n3 4\n", 2, 1)
    (array([[1., 2.],
           [3., 4.]]), array([1, 3]))
    """
    found = _numbers(data, width, line)
    return None if found is None else (found[0].reshape(-1, width), found[1])


def _numbers(data: bytes, width: int, line: int) -> tuple[np.ndarray, np.ndarray] | None:
    """Numbers of a text and lines of its rows; without `width`, no lines."""
    # numba takes a second to import, and most files that are read are small scenarios' ones
    from geosurf.kernels.text.number_words import numbers_of_text

    words = Words.of(data)
    most = len(data) // 2 + 1
    values = np.empty(most)
    hard = np.empty((most, 3), dtype=np.int64)
    lines = np.empty(len(data) // (2 * width) + 1 if width else 0, dtype=np.int64)
    n, n_hard = numbers_of_text(words.packed, len(data), width, line, TENS, values, lines, hard)
    if n < 0 or not words.read_hard(values, hard[:n_hard]):
        return None
    return values[:n].copy(), lines[: n // width].copy() if width else lines


__all__ = ["TENS", "Words", "decimal_rows", "plain_decimals"]
