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
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.errors import FormatError, InputError
from geosurf.model.expected import listed
from geosurf.read._common import COMMA, is_number, line_blocks, number, numbers, read_text

# spellings of the three columns, lower case
USUAL = {
    "x": ("x", "x_utme", "easting", "east"),
    "y": ("y", "y_utmn", "northing", "north"),
    "z": ("z", "z_tvdss", "elevation", "depth"),
}
END_MARK = 999.0  # three of these on a line end a polyline
ROWS = 50_000  # of csv that are taken apart at a time
Columns = tuple[str, ...] | tuple[int, ...] | None


@dataclass
class Table:
    """Points as they stand in a file.

    Attributes
    ----------
    points : ndarray of float64, shape (n, 3)
        x, y, z; lines that end a polyline are 999, 999, 999.
    lines : ndarray of int64, shape (n,)
        Line of each, counted from 1.
    labels : list of str or None
        Words of one more column.
    """

    points: np.ndarray
    lines: np.ndarray
    labels: list[str] | None = None


@dataclass
class _Draft:
    """What is known of a table while its lines go by."""

    path: Path
    columns: Columns
    decimal: str
    width: int | None = None  # values on each line, if a header states it
    places: list[int] | None = None  # of x, y and z
    header: bool = False
    points: list[np.ndarray] = field(default_factory=list)
    lines: list[np.ndarray] = field(default_factory=list)

    def take(self, words: list[str], lines: Any) -> None:
        """Add x, y, z of some rows: three words for each of their lines."""
        if not words:
            return

        lines = np.asarray(lines, dtype=np.int64)
        if self.decimal == ",":
            words = [_with_point(self.path, lines[k // 3], word) for k, word in enumerate(words)]

        # All words at once; one by one only to name the first that is wrong.
        values = numbers(words)
        if values is None:  # report the first invalid one
            values = np.array(
                [
                    number(word, self.path, lines[k // 3], "x, y or z")
                    for k, word in enumerate(words)
                ]
            )
        self.points.append(values.reshape(-1, 3))
        self.lines.append(lines)

    def table(self, labels: list[str] | None = None) -> Table:
        """Return what was taken."""
        if not self.points:
            below = " below the header" if self.header else ""
            raise FormatError(
                f"{self.path}: the file has no points{below}, expected x y z on each line. "
                "Export the file again."
            )
        return Table(np.concatenate(self.points), np.concatenate(self.lines), labels)


def checked_columns(columns: Any) -> Columns:
    """Return three names in lower case or three numbers from 1, or the reason why not."""
    if columns is None:
        return None
    how = "give three names or numbers"
    one = isinstance(columns, str | int)
    # One word alone is listed as one, which is too few.
    words = (columns,) if one else listed(columns, "columns are words or numbers", how)
    names = all(isinstance(word, str) for word in words)
    counts = all(type(word) is int and word > 0 for word in words)

    if len(words) != 3 or not (names or counts):
        raise InputError(
            f"columns is {columns!r}. Give three names of the header, as in columns=('X', 'Y', "
            "'TVDSS'), or three numbers counted from 1, as in columns=(3, 4, 5)."
        )
    return tuple(word.strip().lower() if isinstance(word, str) else word for word in words)


def checked_decimal(decimal: Any) -> str:
    """Return the decimal sign, or raise an error for anything else."""
    if not isinstance(decimal, str) or decimal not in (".", ","):
        raise InputError(f"decimal is {decimal!r}, expected '.' or ','. Write decimal=','.")
    return decimal


def read_table(
    path: Path, columns: Any = None, decimal: Any = ".", labels: Sequence[str] = ()
) -> Table:
    """
    Return the points of a text or csv file, with a column of labels if it is csv and has one.

    Parameters
    ----------
    path : pathlib.Path
        ``.csv`` is split at commas (or semicolons or tabs, if the first line has no comma),
        other text at blanks, semicolons and commas.
    columns : sequence of str or of int, optional
        Names of easting, northing and z in the header, or their numbers counted from 1.
    decimal : {".", ","}
    labels : sequence of str
        Names of a column to return as words, lower case; the first that is there counts.

    Returns
    -------
    Table

    Raises
    ------
    FormatError, InputError
    """
    draft = _Draft(path, checked_columns(columns), checked_decimal(decimal))

    text = read_text(path)
    if path.suffix.lower() == ".csv":
        return _from_csv(draft, text, labels)
    for first, piece in line_blocks(text):
        _take_piece(draft, first, piece)
    return draft.table()


# ------------------------------------------------------------------------- text
def _take_piece(draft: _Draft, first: int, piece: str) -> None:
    """Take whole lines of a text: the fast way if each has three values, else row by row."""
    # The fast way: three bare numbers on each line that is not empty.
    bare = not any(sign in piece for sign in ",;#!") and draft.columns is None
    if bare and draft.width in (None, 3) and draft.places in (None, [0, 1, 2]):
        count, words = _words_per_line(piece), piece.split()
        whole = len(words) == 3 * np.count_nonzero(count) == count.sum() and count.max() == 3
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
            draft.places = _places(draft, [word.lower() for word in words], i)
            continue

        found += _three(draft, words, i)
        lines.append(i)
    draft.take(found, lines)


def _words_per_line(piece: str) -> np.ndarray:
    """How many words each line has, counted where one begins; of ASCII, others count wrongly."""
    # A word begins where a byte is not blank and the one before is; line ends cut the count.
    codes = np.frombuffer(piece.encode("utf-8"), dtype=np.uint8)
    blank = codes <= ord(" ")
    begins = ~blank
    begins[1:] &= blank[:-1]

    line_ends = np.flatnonzero(codes == ord("\n"))
    ends = np.append(np.searchsorted(np.flatnonzero(begins), line_ends), begins.sum())
    return np.diff(ends, prepend=0)


def _is_header(draft: _Draft, rows: list[list[str]]) -> bool:
    """Whether a first line has words only."""
    return bool(rows) and not any(_counts(draft, word) for word in rows[0])


def _counts(draft: _Draft, word: str) -> bool:
    """Whether a word is a number with the decimal sign of this file."""
    return is_number(word.replace(",", ".", 1) if draft.decimal == "," else word)


def _words(draft: _Draft, line: str, i: int) -> list[str]:
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


def _three(draft: _Draft, words: list[str], i: int) -> list[str]:
    """Words of x, y and z on one line, by the header, `columns`, or as the only numbers."""
    ends = len(words) >= 3 and words[0].startswith("999") and _are_end_mark(words)
    if ends:
        return ["999", "999", "999"]

    if draft.width is not None and len(words) != draft.width:
        raise FormatError(
            f"{draft.path}, line {i}: found {len(words)} values, expected {draft.width} as in the "
            "header. Correct that line or export the file again."
        )

    # Places come from names, numbers of columns, or the only three numbers of the line.
    if draft.columns is None and not draft.header:
        draft.places = _only_numbers(draft, words, i)
    elif draft.places is None:
        draft.places = _numbered(draft, i)
    if max(draft.places) >= len(words):
        raise FormatError(
            f"{draft.path}, line {i}: found {len(words)} values, expected at least "
            f"{max(draft.places) + 1}. Correct that line or export the file again."
        )
    return [words[k] for k in draft.places]


def _numbered(draft: _Draft, i: int) -> list[int]:
    """Places that the caller gave as numbers, where there is no header to look for names in."""
    columns = draft.columns or ()
    if any(isinstance(word, str) for word in columns):
        raise FormatError(
            f"{draft.path}, line {i}: the file has no header with the columns "
            f"{', '.join(map(str, columns))}. Give column numbers instead, as in columns=(1, "
            "2, 3)."
        )
    return [int(k) - 1 for k in columns]


def _only_numbers(draft: _Draft, words: list[str], i: int) -> list[int]:
    """Places of the three numbers of a line, which are those of the lines before."""
    if len(words) < 3:
        raise FormatError(
            f"{draft.path}, line {i}: found {len(words)} values, expected x y z. "
            "Correct that line or export the file again."
        )

    if len(words) == 3 and draft.places in (None, [0, 1, 2]):
        return [0, 1, 2]  # the reader reports a word that is not a number
    # Exactly three numbers among other words: these are x, y and z.
    found = [k for k, word in enumerate(words) if _counts(draft, word)]
    if len(found) != 3:
        raise FormatError(
            f"{draft.path}, line {i}: found {len(found)} numbers and no header, so the columns "
            "of easting, northing and z are unknown. Give their columns, counted from 1, as in "
            "columns=(3, 4, 5)."
        )
    if draft.places not in (None, found):
        raise FormatError(
            f"{draft.path}, line {i}: numbers are in columns {[k + 1 for k in found]}, on the "
            f"lines before in {[k + 1 for k in draft.places or []]}. Give the right columns, "
            "as in columns=(1, 2, 3)."
        )
    return found


def _are_end_mark(words: list[str]) -> bool:
    return all(is_number(word) and float(word) == END_MARK for word in words)


def _with_point(path: Path, line: int, word: str) -> str:
    """Return a number with a decimal comma as one with a point."""
    if "." in word or word.count(",") > 1:
        raise FormatError(
            f"{path}, line {line}: found {word!r}, expected a number with one decimal comma at "
            "most. Leave decimal=',' out, or export numbers without thousands separators."
        )
    return word.replace(",", ".")


# -------------------------------------------------------------------------- csv
def _from_csv(draft: _Draft, text: str, labels: Sequence[str]) -> Table:
    """Points of csv, by its header; without one by numbers of columns."""
    first = text[: text.find("\n")]
    at_comma = "," in first and not (draft.decimal == "," and ";" in first)
    sign = "," if at_comma else next((sign for sign in ";\t" if sign in first), ",")
    # With a decimal comma, semicolons or tabs separate.
    lines = itertools.chain.from_iterable(piece.splitlines() for _, piece in line_blocks(text))
    reader = csv.reader(lines, delimiter=sign)

    found: list[str] = []
    try:
        named = _csv_header(draft, next(reader, []), labels)
        for words, lines_of_rows, more in _csv_rows(draft, reader, named):
            draft.take(words, lines_of_rows)
            found += more
    except csv.Error as error:
        raise FormatError(
            f"{draft.path}, line {reader.line_num}: this line is not valid csv ({error}). "
            "Correct that line or export the file again."
        ) from error
    return draft.table(None if named is None else found)


def _csv_header(draft: _Draft, row: list[str], labels: Sequence[str]) -> int | None:
    """Take the first row of csv; return the column of labels."""
    header = [word.strip().lower() for word in row]
    draft.width = len(header)
    draft.header = not any(_counts(draft, word) for word in header)

    if draft.header or not draft.columns or isinstance(draft.columns[0], str):
        draft.places = _places(draft, header, 1)
    else:  # numbers from the first line on
        draft.places = _numbered(draft, 1)
        draft.take(_three(draft, row, 1), [1])
    return next((header.index(word) for word in labels if word in header), None)


def _csv_rows(
    draft: _Draft, reader: Any, named: int | None
) -> Iterator[tuple[list[str], list[int], list[str]]]:
    """Yield x, y, z in words, line numbers and labels, some rows at a time."""
    # Rows in portions, so that words do not take twenty times the memory of the file.
    a, b, c = draft.places or [0, 1, 2]
    more = True
    while more:
        more = False
        words: list[str] = []
        lines: list[int] = []
        labels: list[str] = []
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
            if named is not None:
                labels.append(row[named].strip())
        yield words, lines, labels


def _places(draft: _Draft, header: list[str], line: int) -> list[int]:
    """Where x, y and z are in a header of lower case, by their usual names or the caller's."""
    if draft.columns is not None and not isinstance(draft.columns[0], str):
        places = [int(k) - 1 for k in draft.columns]
        if max(places) >= len(header):
            raise FormatError(
                f"{draft.path}, line {line}: the header has {len(header)} columns, but "
                f"columns={draft.columns}. Columns are counted from 1."
            )
        return places

    # Each axis needs exactly one column with a known name.
    at = []
    for k, (axis, usual) in enumerate(USUAL.items()):
        spellings = usual if draft.columns is None else draft.columns[k : k + 1]
        found = [i for i, word in enumerate(header) if word in spellings]
        if len(found) != 1:
            raise FormatError(
                f"{draft.path}, line {line}: found {len(found)} columns for {axis} in "
                f"{header}, expected one of {', '.join(map(str, spellings))} (upper or lower "
                "case). Rename the columns; for points, you can also set columns=."
            )
        at.append(found[0])
    return at
