"""Layouts of well-top files -> a header and rows of words.

Three are recognised by their first lines:

- Petrel well tops: column names between BEGIN HEADER and END HEADER, names in quotes;
- RMS points with attributes: lines such as ``String Well`` name what follows x y z in each row;
- a table, with one header line or none, separated by commas, semicolons, tabs or blanks.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from geosurf.errors import FormatError
from geosurf.read._common import is_number, read_text
from geosurf.read._guard import damaged

WORD = re.compile(r'"([^"]*)"|\'([^\']*)\'(?=\s|$)|(\S+)')
ATTRIBUTE = re.compile(r"(?i)(float|string|discrete|int|integer)\s+(\S.*)")
UNIT = re.compile(r"(?i)#\s*unit in depth:\s*(\S*)")
TYPED = re.compile(r"(?i)(?:float|double|int|integer|string|bool|date\w*|discrete)\s*[,\s]\s*(.+)")
BRACKETS = re.compile(r"(.*?)\s*[\[(]\s*(.*?)\s*[\])]\s*")
COMMENTS = ("#", "!", "--")
SEPARATORS = (",", ";", "\t")


@dataclass(frozen=True)
class Layout:
    """A file of well tops, taken apart.

    Attributes
    ----------
    header : list of str or None
        Names of the columns as they are written; None without a header.
    rows : list of (int, list of str)
        Line number from 1, and its words.
    petrel : bool
        Whether the file is in Petrel's format, which holds elevations.
    length_unit : str or None
        Unit of z, if the file declares one.
    """

    header: list[str] | None
    rows: list[tuple[int, list[str]]]
    petrel: bool = False
    length_unit: str | None = None


def layout_of(path: Path, decimal: str, *, typed: bool = False) -> Layout:
    """Return header and rows of a file of well tops, or of points with attributes.

    With `typed`, types before the names of columns are dropped (``FLOAT,dip``), and lines of
    ``999 999 999`` may be shorter than the header.

    Raises
    ------
    FormatError
        If the header has no end, or a row has another number of words than the header.
    """
    # line numbers are those of the file: comments and empty lines count, but are not rows
    lines = read_text(path).split("\n")
    unit = next((match[1] for line in lines[:50] if (match := UNIT.match(line.strip()))), None)
    numbered = [
        (number, line.strip())
        for number, line in enumerate(lines, start=1)
        if line.strip() and not line.lstrip().startswith(COMMENTS)
    ]
    if not numbered:
        raise damaged(f"{path}: the file has comments only")

    # the most particular layout first: a table would take nearly anything
    begins = [k for k, (_, line) in enumerate(numbered[:50]) if line.upper() == "BEGIN HEADER"]
    if begins:
        header, body = _petrel(path, numbered, begins[0])
        header = [_without_type(word) for word in header] if typed else header
        found = Layout(header, body, True, unit or None)
    elif ATTRIBUTE.fullmatch(numbered[0][1]):
        found = _with_attributes(numbered)
    else:
        found = _table(path, numbered, decimal)
    check_widths(path, found.header, found.rows, ends=typed)
    return found


def plain_name(word: str) -> str:
    """Return a name of a column in lower case, letters and digits only, without its unit.

    Examples
    --------
    >>> plain_name("Z_TVDSS [ft]")
    'ztvdss'
    """
    match = BRACKETS.fullmatch(word)
    return re.sub(r"[^a-z0-9]", "", (match[1] if match else word).lower())


def unit_in_name(word: str) -> str | None:
    """Return the unit in brackets behind the name of a column, in lower case; None without."""
    match = BRACKETS.fullmatch(word)
    return (match[2].lower() or None) if match else None


def unit_of_column(header: list[str] | None, place: int, whole: str | None) -> str | None:
    """Return the unit of a column: in brackets after its name, else that of the whole file."""
    return (unit_in_name(header[place]) if header else None) or whole


def _without_type(word: str) -> str:
    """A name without the type that Petrel writes before it, as in ``FLOAT,dip``."""
    found = TYPED.fullmatch(word.strip())
    return (found[1] if found else word).strip("\"' ")


def _petrel(
    path: Path, numbered: list[tuple[int, str]], begin: int
) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Names between BEGIN HEADER and END HEADER, and the rows below."""
    upper = [line.upper() for _, line in numbered]
    if "END HEADER" not in upper[begin:]:
        raise damaged(f"{path}, line {numbered[begin][0]}: BEGIN HEADER has no END HEADER")
    end = upper.index("END HEADER", begin)
    header = [line for _, line in numbered[begin + 1 : end]]
    return header, [(number, _blank_words(line)) for number, line in numbered[end + 1 :]]


def _with_attributes(numbered: list[tuple[int, str]]) -> Layout:
    """RMS points: one line for each attribute, then x y z and the attributes."""
    # attribute lines come first; the first line that is none begins the points
    header = ["x", "y", "z"]
    for _, line in numbered:
        match = ATTRIBUTE.fullmatch(line)
        if match is None:
            break
        header.append(match[2].strip("\"' "))
    body = numbered[len(header) - 3 :]
    return Layout(header, [(number, _blank_words(line)) for number, line in body])


def _table(path: Path, numbered: list[tuple[int, str]], decimal: str) -> Layout:
    """A table with one header line or none."""
    first = numbered[0][1]

    # the first line decides; a decimal comma does not separate
    separators = [sign for sign in SEPARATORS if sign in first and sign != decimal]
    if separators:
        rows = list(_separated(path, numbered, separators[0]))
    else:
        rows = [(number, _blank_words(line)) for number, line in numbered]

    # a header has no number in any column
    is_header = not any(is_number(word.replace(",", ".", 1)) for word in rows[0][1])
    return Layout(rows[0][1], rows[1:]) if is_header else Layout(None, rows)


def _separated(
    path: Path, numbered: list[tuple[int, str]], sign: str
) -> Iterator[tuple[int, list[str]]]:
    """Words of each line, separated by a sign and perhaps in quotes."""
    for number, line in numbered:
        try:
            words = next(csv.reader([line], delimiter=sign, skipinitialspace=True))
        except (csv.Error, StopIteration) as error:
            raise damaged(f"{path}, line {number}: this line is not valid csv ({error})") from error
        yield number, [word.strip() for word in words]


def _blank_words(line: str) -> list[str]:
    """Words between blanks; names in quotes may have blanks inside."""
    return [
        next(part for part in match.groups() if part is not None).strip()
        for match in WORD.finditer(line)
    ]


def check_widths(
    path: Path, header: list[str] | None, rows: list[tuple[int, list[str]]], *, ends: bool = False
) -> None:
    """Refuse rows that are shorter or longer than the header, except perhaps end marks."""
    for number, words in rows if header else ():
        if ends and len(words) >= 3 and all(is_number(w) and float(w) == 999 for w in words[:3]):
            continue
        if len(words) != len(header or ()):
            raise FormatError(
                f"{path}, line {number}: found {len(words)} values, expected {len(header or ())} "
                f"as the columns {', '.join(header or ())}. Put names with blanks in quotes. "
                "Numbers with decimal commas need another separator and decimal=','."
            )
