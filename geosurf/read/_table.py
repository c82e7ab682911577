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
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import did_you_mean
from geosurf.conventions.axes import USUAL
from geosurf.errors import FormatError, InputError
from geosurf.model.expected import listed
from geosurf.read._common import COMMA, TextBlocks, is_number, noted, number_rows, with_point
from geosurf.read._guard import damaged

# ---- columns ----------------------------------------
# Which words of a line are easting, northing and z, and the rows collected so far.


END_MARK = 999.0  # three of these on a line end a polyline
Columns = tuple[str, ...] | tuple[int, ...] | None
OF_LINES = ("line number", "line name")  # what the further columns of lines mean


@dataclass
class Table:
    """Points as they stand in a file.

    Attributes
    ----------
    points : ndarray of float64, shape (n, 3)
        x, y, z; lines that end a polyline are 999, 999, 999.
    lines : ndarray of int64, shape (n,)
        Line of each, counted from 1.
    labels, names : list of str or None
        Words of two more columns: the number of the line, and the name of its fault; of points
        those that the caller wants.
    """

    points: np.ndarray
    lines: np.ndarray
    labels: list[str] | None = None
    names: list[str] | None = None


@dataclass
class Draft:
    """What is known of a table while its lines go by."""

    path: Path
    columns: Columns
    decimal: str
    width: int | None = None  # values on each line, if a header states it
    places: list[int] | None = None  # of x, y and z
    header: bool = False
    points: list[np.ndarray] = field(default_factory=list)
    lines: list[np.ndarray] = field(default_factory=list)
    spellings: tuple[Sequence[str], ...] = ()  # of more columns, lower case
    more: list[int | None] = field(default_factory=list)  # their places
    words: list[list[str]] = field(default_factory=list)  # their words, one list for each column
    titles: tuple[str, ...] = OF_LINES  # what they mean
    marks: bool = True  # three values of 999 end a polyline
    titled: bool = False  # lines with @ were there: a title may follow them, as of OpenWorks

    def take_more(self, row: list[str], line: int) -> None:
        """Add the words of the further columns of one row."""
        ends = self.titles is not OF_LINES and len(row) >= 3 and _are_end_mark(row)
        for words, place in zip(self.words, self.more, strict=True):
            if place is not None and ends:
                words.append("")  # what ends points belongs to no well
                continue
            if place is not None and place >= len(row):
                raise FormatError(
                    f"{self.path}, line {line}: found {len(row)} values, expected at least "
                    f"{place + 1}. Correct columns= or that line."
                )
            if place is not None:
                words.append(row[place].strip())

    def find_more(self, header: list[str] | None) -> None:
        """Find the further columns: by the caller's fourth and fifth, or by their usual names."""
        given = list((self.columns or ())[3:])
        self.more = []
        for k, usual in enumerate(self.spellings):
            word = given[k] if k < len(given) else None
            if isinstance(word, int):
                self.more.append(word - 1)
            elif word is not None and header is not None and word not in header:
                raise FormatError(
                    f"{self.path}: the header has no column {word!r}, only {', '.join(header)}. "
                    "Correct columns=."
                )
            else:
                self.more.append(
                    first_column(header or (), usual if word is None else (str(word),))
                )
        self.words = [[] for _ in self.spellings]

    def take(self, words: list[str], lines: Any) -> None:
        """Add x, y, z of some rows: three words for each of their lines."""
        if not words:
            return

        lines = np.asarray(lines, dtype=np.int64)
        if self.decimal == ",":
            words = [_with_point(self.path, lines[k // 3], word) for k, word in enumerate(words)]
        self.points.append(number_rows(words, lines, self.path, "x, y or z"))
        self.lines.append(lines)

    def table(self) -> Table:
        """Return what was taken."""
        if not self.points:
            below = " below the header" if self.header else ""
            raise damaged(
                f"{self.path}: the file has no points{below}, expected x y z on each line"
            )
        at = ", ".join(str(k + 1) for k in self.places or (0, 1, 2))
        by = "by the header" if self.header else "by columns=" if self.columns else "the only ones"
        noted("columns", f"easting, northing, z are columns {at} ({by})")
        noted("decimal sign", self.decimal)
        more: list[list[str] | None] = [None, None]
        for k, (place, words) in enumerate(zip(self.more, self.words, strict=True)):
            if place is not None:
                more[k] = words
                noted(self.titles[k], f"column {place + 1}")
        return Table(np.concatenate(self.points), np.concatenate(self.lines), more[0], more[1])


def checked_columns(
    columns: Any, titles: Sequence[str], example: str, more: Sequence[str] = ()
) -> Columns:
    """
    Return the columns that a caller names: names in lower case or numbers from 1, or None.

    Parameters
    ----------
    columns : sequence of str or of int, or None
    titles, more : sequence of str
        What has to be named, and what may follow.
    example : str
        Names as a caller would write them.

    Raises
    ------
    InputError
    """
    if columns is None:
        return None
    # one word alone is listed as one, which is too few
    one = isinstance(columns, str | int)
    how = f"give {len(titles)} names or numbers"
    words = (columns,) if one else listed(columns, "columns are words or numbers", how)
    names = all(isinstance(word, str) for word in words)
    counts = all(type(word) is int and word > 0 for word in words)
    if not len(titles) <= len(words) <= len(titles) + len(more) or not (names or counts):
        after = f" {' and '.join(more)} may follow: (4, 5, 6, 8, 7)." if more else ""
        raise InputError(
            f"columns is {columns!r}. Give {len(titles)} names of the header, those of "
            f"{', '.join(titles)}, as in columns={example}, or numbers counted from 1.{after}"
        )
    return tuple(word.strip().lower() if isinstance(word, str) else word for word in words)


def checked_decimal(decimal: Any) -> str:
    """Return the decimal sign, or raise an error for anything else."""
    if not isinstance(decimal, str) or decimal not in (".", ","):
        raise InputError(f"decimal is {decimal!r}, expected '.' or ','. Write decimal=','.")
    return decimal


def is_value(draft: Draft, word: str) -> bool:
    """Whether a word is a number with the decimal sign of this file."""
    return is_number(with_point(word, draft.decimal))


def three_words(draft: Draft, words: list[str], i: int) -> list[str]:
    """Words of x, y and z on one line, by the header, `columns`, or as the only numbers."""
    # cheap test first: end marks are rare, and lines are many
    ends = draft.marks and len(words) >= 3 and words[0].startswith("999")
    if ends and _are_end_mark(words):
        return ["999", "999", "999"]

    # a line with more or fewer values than the header is a shifted column, not a point
    if draft.width is not None and len(words) != draft.width:
        raise damaged(
            f"{draft.path}, line {i}: found {len(words)} values, expected {draft.width} as in the "
            "header"
        )

    # Places come from names, numbers of columns, or the only three numbers of the line.
    if draft.columns is None and not draft.header:
        draft.places = _only_numbers(draft, words, i)
    elif draft.places is None:
        draft.places = numbered_places(draft, i)
    if max(draft.places) >= len(words):
        raise damaged(
            f"{draft.path}, line {i}: found {len(words)} values, expected at least "
            f"{max(draft.places) + 1}"
        )
    return [words[k] for k in draft.places]


def numbered_places(draft: Draft, i: int) -> list[int]:
    """Places that the caller gave as numbers, where there is no header to look for names in."""
    columns = draft.columns or ()
    if any(isinstance(word, str) for word in columns):
        raise FormatError(
            f"{draft.path}, line {i}: the file has no header with the columns "
            f"{', '.join(map(str, columns))}. Give column numbers instead, as in columns=(1, 2, 3)."
        )
    return [int(k) - 1 for k in columns[:3]]


def _only_numbers(draft: Draft, words: list[str], i: int) -> list[int]:
    """Places of the three numbers of a line, which are those of the lines before."""
    if len(words) < 3:
        raise damaged(f"{draft.path}, line {i}: found {len(words)} values, expected x y z")

    # three words in the first three places, as on the lines before, need no look at each
    if len(words) == 3 and draft.places in (None, [0, 1, 2]):
        return [0, 1, 2]  # the reader reports a word that is not a number
    # Exactly three numbers among other words: these are x, y and z.
    places = [k for k, word in enumerate(words) if is_value(draft, word)]
    if len(places) != 3:
        raise FormatError(
            f"{draft.path}, line {i}: found {len(places)} numbers and no header, so the columns "
            "of easting, northing and z are unknown. Give their columns, counted from 1, as in "
            f"columns=(3, 4, 5).{_of_line(draft, words)}"
        )

    # numbers that change their columns within a file are refused: one kind of line is misread
    if draft.places not in (None, places):
        raise FormatError(
            f"{draft.path}, line {i}: numbers are in columns {[k + 1 for k in places]}, on the "
            f"lines before in {[k + 1 for k in draft.places or []]}. Give the right columns, "
            "as in columns=(1, 2, 3)."
        )
    return places


def _of_line(draft: Draft, words: list[str]) -> str:
    """For lines: which further columns a caller can give, and the words of this one."""
    more = ""
    if draft.titles is not OF_LINES:
        more = " Fault sticks: read_fault, with columns=(x, y, z, stick, fault)."
    elif draft.spellings:
        more = " The number of the stick and the name of the fault may follow: (3, 4, 5, 7, 6)."
    shown = ", ".join(f"{k + 1} {word!r}" for k, word in enumerate(words[:12]))
    return f"{more} This line is: {shown}."


def _are_end_mark(words: list[str]) -> bool:
    return all(is_number(word) and float(word) == END_MARK for word in words)


def _with_point(path: Path, line: int, word: str) -> str:
    """Return a number with a decimal comma as one with a point."""
    # a point, or a second comma, would be a thousands separator
    if "." in word or word.count(",") > 1:
        raise FormatError(
            f"{path}, line {line}: found {word!r}, expected a number with one decimal comma at "
            "most. Leave decimal=',' out, or export numbers without thousands separators."
        )
    return word.replace(",", ".")


def named_places(draft: Draft, header: list[str], line: int) -> list[int]:
    """Where x, y and z are in a header of lower case, by their usual names or the caller's."""
    # columns by number, counted from 1, go before names
    if draft.columns is not None and not isinstance(draft.columns[0], str):
        places = [int(k) - 1 for k in draft.columns[:3]]
        if max(places) >= len(header):
            raise FormatError(
                f"{draft.path}, line {line}: the header has {len(header)} columns, but "
                f"columns={draft.columns}. Columns are counted from 1."
            )
        return places

    spelled = USUAL if draft.columns is None else dict(zip(USUAL, draft.columns, strict=False))
    return columns_of_places(f"{draft.path}, line {line}", header, spelled)


def columns_of_places(where: str, header: Sequence[str], spelled: Mapping[str, Any]) -> list[int]:
    """Return where x, y and z are in a header of lower case, by one name or several of each."""
    letters, remedy = "".join(header), "Rename the columns, or set columns=."
    if any(map(str.isdigit, letters)) and not any(map(str.isalpha, letters)):
        remedy = (
            "These are numbers: write the names of the columns on a line above, such as X,Y,Z. "
            "Decimal commas need another separator than commas."
        )
    return [one_column(where, header, header, *one, remedy) for one in spelled.items()]


def one_column(
    where: str, header: Sequence[str], plain: Sequence[str], what: str, spellings: Any, remedy: str
) -> int:
    """
    Return the one column that has one of some names.

    Parameters
    ----------
    where : str
        File, and line where it is known.
    header, plain : sequence of str
        Names of the columns as they are written, and as they are compared.
    what : str
        What the column holds.
    spellings : str or sequence of str
    remedy : str
        What to do where there is none, or more than one.

    Raises
    ------
    FormatError
    """
    names = (spellings,) if isinstance(spellings, str) else spellings
    matching = [k for k, word in enumerate(plain) if word in names]
    if len(matching) != 1:
        there = ", ".join(map(repr, header)) or "no header"
        guess = "" if matching else did_you_mean(names[0], plain)
        raise FormatError(
            f"{where}: found {len(matching)} columns for {what} in {there}, expected one of "
            f"{', '.join(names)} (upper or lower case).{guess} {remedy}"
        )
    return matching[0]


def first_column(header: Sequence[str], spellings: Sequence[str]) -> int | None:
    """Return the column that has the first of some names that a header has, if any."""
    return next((header.index(word) for word in spellings if word in header), None)


ROWS = 50_000  # that are taken apart at a time


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
    further = titles if titles is OF_LINES and more else ()
    axes = ("easting", "northing", "z")
    given = checked_columns(columns, axes, "('X', 'Y', 'TVDSS') or columns=(3, 4, 5)", further)
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
    bare = not any(sign in piece for sign in ",;#!@") and draft.columns is None
    if bare and draft.width in (None, 3) and draft.places in (None, [0, 1, 2]):
        # three words on each line that is not empty, counted over the bytes of the whole piece
        count = words_per_line(piece)
        whole = 3 * np.count_nonzero(count) == count.sum() and count.max() == 3
        words = piece.split()
        whole = whole and len(words) == count.sum()
        if whole and (draft.points or draft.header or not _is_header(draft, [words[:3]])):
            draft.take(words, first + np.flatnonzero(count))
            return

    _take_rows(draft, _rows(draft, first, piece))


def _rows(draft: Draft, first: int, piece: str) -> Iterator[tuple[int, list[str]]]:
    """Line and words of each row with values; a header is taken on the way."""
    begun = bool(draft.points)
    for i, line in enumerate(piece.split("\n"), start=first):
        words = _words(draft, line, i)
        draft.titled |= bool(words) and words[0].startswith("@")
        if not words or words[0].startswith(("#", "!", "@")) or words == ["EOD"]:
            continue
        if draft.titled and not begun and sum(is_value(draft, word) for word in words) < 3:
            continue
        # The first line without any number is the header.
        if not draft.header and not begun and _is_header(draft, [words]):
            draft.header, draft.width = True, len(words)
            header = [word.lower() for word in words]
            draft.places = named_places(draft, header, i)
            draft.find_more(header)
            continue
        begun = True
        yield i, words


def _take_rows(draft: Draft, rows: Iterable[tuple[int, list[str]]]) -> None:
    """Take rows in portions: words take twenty times the memory of the file."""
    rows = iter(rows)
    while part := list(itertools.islice(rows, ROWS)):
        texts: list[str] = []
        for i, words in part:
            texts += three_words(draft, words, i)
            draft.take_more(words, i)
        draft.take(texts, [i for i, _ in part])


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
    draft.marks = False

    try:
        _csv_header(draft, next(reader, []))
        _take_rows(draft, ((reader.line_num, row) for row in reader if row))
    except csv.Error as error:
        raise damaged(
            f"{draft.path}, line {reader.line_num}: this line is not valid csv ({error})"
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
        _take_rows(draft, [(1, row)])
