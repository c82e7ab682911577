"""Lines of GOCAD files that hold vertices or triangles: ``VRTX id x y z`` and ``TRGL id id id``.

A run is a number of such lines, one after another. Whatever else stands in a line ends the run, and
is left to the reader of lines, which names what is wrong.
"""

from __future__ import annotations

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.text.decimals import (
    BLANK,
    HARD,
    LINE_END,
    NINE,
    OTHER,
    TAB,
    ZERO,
    character,
    number_at,
)

VRTX = (86, 82, 84, 88)
TRGL = (84, 82, 71, 76)
CNXYZ = (67, 78, 88, 89, 90)  # a flag of control nodes, behind the coordinates
MOST_ID = 1_000_000_000_000_000  # ids are below; larger ones are left to Python


@scalar
def _is_word(text, at, end, a, b, c, d):
    """Whether four letters and a blank stand at a character."""
    return (
        at + 4 < end
        and character(text, at) == a
        and character(text, at + 1) == b
        and character(text, at + 2) == c
        and character(text, at + 3) == d
        and (character(text, at + 4) == BLANK or character(text, at + 4) == TAB)
    )


@scalar
def _same_line(text, at, end):
    """Where the next word of this line begins, or its end."""
    k = at
    while k < end and (character(text, k) == BLANK or character(text, k) == TAB):
        k += 1
    return k


@scalar
def _whole_at(text, at, end):
    """A number of digits only, and the character behind it; -1 if it is none."""
    k, value = at, 0
    while k < end and ZERO <= character(text, k) <= NINE:
        value = value * 10 + (character(text, k) - ZERO)
        if value >= MOST_ID:
            return -1, k
        k += 1
    c = character(text, k) if k < end else LINE_END
    fit = k > at and (c == BLANK or c == TAB or c == LINE_END)
    return (value if fit else -1), k


@scalar
def _without_flag(text, at, end):
    """The end of a line with nothing more than a flag, or -1."""
    k = _same_line(text, at, end)
    if (
        k + 5 <= end
        and character(text, k) == CNXYZ[0]
        and character(text, k + 1) == CNXYZ[1]
        and character(text, k + 2) == CNXYZ[2]
        and character(text, k + 3) == CNXYZ[3]
        and character(text, k + 4) == CNXYZ[4]
    ):
        k = _same_line(text, k + 5, end)
    return k if k == end or character(text, k) == LINE_END else -1


@entry("l1 l l d1 l1 d2 l2 -> l l l")
def vertex_run(text, at, end, tens, ids, points, hard):
    """
    Read vertices up to the first line that is none.

    Parameters
    ----------
    text : ndarray of int64
        See the notation of this room.
    at, end : int
        First character of a line, and number of characters.
    tens : ndarray of float64, shape (23,)
        Powers of ten.
    ids : ndarray of int64, shape (n,)
        Written.
    points : ndarray of float64, shape (n, 3)
        Written: coordinates; those that are hard are 0.
    hard : ndarray of int64, shape (3 n, 3)
        Written: place in `points`, first character and end of each word that Python has to read.

    Returns
    -------
    (int, int, int)
        Vertices read, hard words, and the first character of the line that is none.
    """
    n, n_hard = 0, 0
    while at < end and n < len(ids):
        if not _is_word(text, at, end, VRTX[0], VRTX[1], VRTX[2], VRTX[3]):
            break
        name, k = _whole_at(text, _same_line(text, at + 4, end), end)
        if name < 0:
            break
        before = n_hard
        for axis in range(3):
            k = _same_line(text, k, end)
            value, after, kind = number_at(text, k, end, tens)
            if kind == OTHER:
                return n, before, at
            if kind == HARD:
                hard[n_hard, 0] = 3 * n + axis
                hard[n_hard, 1] = k
                hard[n_hard, 2] = after
                n_hard += 1
            points[n, axis] = value
            k = after
        k = _without_flag(text, k, end)
        if k < 0:
            return n, before, at
        ids[n] = name
        n += 1
        at = k + 1
    return n, n_hard, min(at, end)


@entry("l1 l l l2 -> l l")
def triangle_run(text, at, end, corners):
    """
    Read triangles up to the first line that is none.

    Parameters
    ----------
    text, at, end
        As for `vertex_run`.
    corners : ndarray of int64, shape (n, 3)
        Written: ids of vertices.

    Returns
    -------
    (int, int)
        Triangles read, and the first character of the line that is none.
    """
    n = 0
    while at < end and n < len(corners):
        if not _is_word(text, at, end, TRGL[0], TRGL[1], TRGL[2], TRGL[3]):
            break
        k = at + 4
        for corner in range(3):
            k = _same_line(text, k, end)
            name, k = _whole_at(text, k, end)
            if name < 0:
                return n, at
            corners[n, corner] = name
        k = _same_line(text, k, end)
        if k < end and character(text, k) != LINE_END:
            break
        n += 1
        at = k + 1
    return n, min(at, end)
