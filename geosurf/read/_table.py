"""Tables in text: which columns of a line are easting, northing and z.

Being first does not make a column a coordinate. Without a header and without
``columns=``, exactly three columns must hold numbers; they are x, y, z in that order. All others
hold numbers on no line, so that a point's number or an inline is never treated as an easting.

Values are separated by blanks, semicolons or commas. A comma inside numbers that are separated
otherwise ('460000,25 5930000,5') is refused, or is the decimal sign with ``decimal=","``.
"""

from __future__ import annotations

import csv
import itertools
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.errors import FormatError
from geosurf.read._blocks import TextBlocks
from geosurf.read._columns import (
    OF_LINES,
    Draft,
    Table,
    checked_columns,
    checked_decimal,
    is_value,
    named_places,
    numbered_places,
    three_words,
)
from geosurf.read._common import COMMA

ROWS = 50_000  # of csv that are taken apart at a time


def read_table(
    path: Path,
    columns: Any = None,
    decimal: Any = ".",
    more: tuple[Sequence[str], ...] = (),
    titles: tuple[str, ...] = OF_LINES,
) -> Table:
    """
    Return the points of a text or csv file, and words of further columns that it has.

    Parameters
    ----------
    path : pathlib.Path
        ``.csv`` is split at commas (or semicolons or tabs, if the first line has no comma),
        other text at blanks, semicolons and commas.
    columns : sequence of str or of int, optional
        Names of easting, northing and z in the header, or their numbers counted from 1.
    decimal : {".", ","}
    more : tuple of sequence of str
        Usual names of up to two further columns, lower case; the first that is there counts.
    titles : tuple of str
        What these mean. Those of lines may also be the fourth and fifth of `columns`.

    Returns
    -------
    Table

    Raises
    ------
    FormatError, InputError
    """
    most = 3 + (len(more) if titles is OF_LINES else 0)
    given = checked_columns(columns, most)
    draft = Draft(path, given, checked_decimal(decimal), spellings=more, titles=titles)
    draft.find_more(None)

    blocks = TextBlocks(path)
    if path.suffix.lower() == ".csv":
        return _from_csv(draft, blocks)
    for first, piece in blocks:
        _take_piece(draft, first, piece)
    return draft.table()


# ------------------------------------------------------------------------- text
def _take_piece(draft: Draft, first: int, piece: str) -> None:
    """Take whole lines of a text: the fast way if each has three values, else row by row."""
    # The fast way: three bare numbers on each line that is not empty.
    bare = not any(sign in piece for sign in ",;#!") and draft.columns is None
    if bare and draft.width in (None, 3) and draft.places in (None, [0, 1, 2]):
        # three words on each line that is not empty, counted over the bytes of the whole piece
        count = words_per_line(piece)
        whole = 3 * np.count_nonzero(count) == count.sum() and count.max() == 3
        words = piece.split()
        whole = whole and len(words) == count.sum()
        if whole and (draft.points or draft.header or not _is_header(draft, [words[:3]])):
            draft.take(words, first + np.flatnonzero(count))
            return

    found: list[str] = []
    lines: list[int] = []
    for i, line in enumerate(piece.split("\n"), start=first):
        words = _words(draft, line, i)
        if not words or words[0].startswith(("#", "!")):
            continue
        # The first line without any number is the header.
        if not draft.header and not draft.points and not lines and _is_header(draft, [words]):
            draft.header, draft.width = True, len(words)
            header = [word.lower() for word in words]
            draft.places = named_places(draft, header, i)
            draft.find_more(header)
            continue

        found += three_words(draft, words, i)
        draft.take_more(words, i)
        lines.append(i)
    draft.take(found, lines)


def words_per_line(piece: str) -> np.ndarray:
    """How many words each line has, counted where one begins; of ASCII, others count wrongly."""
    # A word begins where a byte is not blank and the one before is; line ends cut the count.
    codes = np.frombuffer(piece.encode("utf-8"), dtype=np.uint8)
    blank = codes <= ord(" ")
    begins = ~blank
    begins[1:] &= blank[:-1]

    line_ends = np.flatnonzero(codes == ord("\n"))
    ends = np.append(np.searchsorted(np.flatnonzero(begins), line_ends), begins.sum())
    return np.diff(ends, prepend=0)


def _is_header(draft: Draft, rows: list[list[str]]) -> bool:
    """Whether a first line has words only."""
    return bool(rows) and not any(is_value(draft, word) for word in rows[0])


def _words(draft: Draft, line: str, i: int) -> list[str]:
    """Split a line at its separators; a comma that may be a decimal sign is refused."""
    line = line.strip()

    if draft.decimal == "," or "," not in line or line.startswith(("#", "!")):
        return line.replace(";", " ").split()
    # A comma between digits could be a decimal sign: refused unless it separates everything.
    blank = line.replace(";", " ").split()
    inside = next((word for word in blank if COMMA.search(word)), None)
    if inside and sum(word[0] in "+-.0123456789" for word in blank) > 1:
        raise FormatError(
            f"{draft.path}, line {i}: the comma in {inside!r} may be a decimal sign or a "
            "separator. For decimal commas pass decimal=','. Otherwise use one separator in "
            "the whole file."
        )
    if inside:
        return [word.strip() for word in line.rstrip(",").split(",")]
    return line.replace(",", " ").replace(";", " ").split()


# -------------------------------------------------------------------------- csv
def _from_csv(draft: Draft, blocks: TextBlocks) -> Table:
    """Points of csv, by its header; without one by numbers of columns."""
    first = blocks.head[: blocks.head.find("\n")]

    # the first line shows the separator; commas count unless they are decimal signs
    at_comma = "," in first and not (draft.decimal == "," and ";" in first)
    sign = "," if at_comma else next((sign for sign in ";\t" if sign in first), ",")
    # With a decimal comma, semicolons or tabs separate.
    lines = itertools.chain.from_iterable(piece.splitlines() for _, piece in blocks)

    # quoted words may hold the separator: csv takes care of that
    reader = csv.reader(lines, delimiter=sign)

    try:
        _csv_header(draft, next(reader, []))
        for words, lines_of_rows in _csv_rows(draft, reader):
            draft.take(words, lines_of_rows)
    except csv.Error as error:
        raise FormatError(
            f"{draft.path}, line {reader.line_num}: this line is not valid csv ({error}). "
            "Correct that line or export the file again."
        ) from error
    return draft.table()


def _csv_header(draft: Draft, row: list[str]) -> None:
    """Take the first row of csv."""
    # a first row with a number is data: then only column numbers can name x, y, z
    header = [word.strip().lower() for word in row]
    draft.width = len(header)
    draft.header = not any(is_value(draft, word) for word in header)

    if draft.header or not draft.columns or isinstance(draft.columns[0], str):
        draft.places = named_places(draft, header, 1)
        draft.find_more(header)
    else:  # numbers from the first line on
        draft.places = numbered_places(draft, 1)
        draft.take(three_words(draft, row, 1), [1])
        draft.take_more(row, 1)


def _csv_rows(draft: Draft, reader: Any) -> Iterator[tuple[list[str], list[int]]]:
    """Yield x, y, z in words and line numbers, some rows at a time."""
    # Rows in portions, so that words do not take twenty times the memory of the file.
    a, b, c = draft.places or [0, 1, 2]
    further = any(place is not None for place in draft.more)
    more = True
    while more:
        more = False
        words: list[str] = []
        lines: list[int] = []
        for row in itertools.islice(reader, ROWS):
            more = True
            if not row:
                continue
            if len(row) != draft.width:
                raise FormatError(
                    f"{draft.path}, line {reader.line_num}: found {len(row)} values, expected "
                    f"{draft.width} as in the header. Correct that line or export the file again."
                )
            words += (row[a], row[b], row[c])
            lines.append(reader.line_num)
            if further:
                draft.take_more(row, reader.line_num)
        yield words, lines
