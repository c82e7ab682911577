"""All words of a text as numbers, with the lines on which they stand."""

from __future__ import annotations

from geosurf.kernels.compile.jit import entry
from geosurf.kernels.text.decimals import (
    HARD,
    LINE_END,
    OTHER,
    character,
    is_blank,
    number_at,
)


@entry("l1 l l l d1 d1 l1 l2 -> l l")
def numbers_of_text(text, end, width, line, tens, values, lines, hard):
    """
    Read all words of a text.

    Parameters
    ----------
    text : ndarray of int64
        See the notation of this room.
    end : int
        Number of characters.
    width : int
        Words of each line that is not empty; 0 if lines do not matter.
    line : int
        Number of the first line.
    tens : ndarray of float64, shape (23,)
        Powers of ten.
    values : ndarray of float64, shape (end // 2 + 1,)
        Written: the numbers; those that are hard are 0.
    lines : ndarray of int64, shape (end // (2 * width) + 1,)
        Written if `width` is not 0: the line of each row.
    hard : ndarray of int64, shape (n, 3)
        Written: row in `values`, first character and end of each word that Python has to read.

    Returns
    -------
    (int, int)
        Numbers read, or -1 if a word is no number or a line has another width; hard ones.
    """
    n, n_hard, n_row, of_line = 0, 0, 0, 0
    k = 0
    while k <= end:
        c = character(text, k) if k < end else LINE_END
        if c == LINE_END:
            if width > 0 and of_line > 0:
                if of_line != width:
                    return -1, 0
                lines[n_row] = line
                n_row += 1
            of_line = 0
            line += 1
            k += 1
        elif is_blank(c):
            k += 1
        else:
            value, after, kind = number_at(text, k, end, tens)
            if kind == OTHER:
                return -1, 0
            if kind == HARD:
                hard[n_hard, 0] = n
                hard[n_hard, 1] = k
                hard[n_hard, 2] = after
                n_hard += 1
            values[n] = value
            n += 1
            of_line += 1
            k = after
    return n, n_hard
