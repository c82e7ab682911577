"""Helpers of all readers: bytes, lines, numbers, and the direction of elevations.

Readers never guess. Whether a file holds elevation or depth is stated by the file
or by the caller; when both speak they must agree.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import elevation_sign, first_given, metres_per_unit
from geosurf.errors import FormatError, InputError
from geosurf.read._blocks import BLOCK, TextBlocks
from geosurf.read._noted import noted

WHOLE = re.compile(r"[+-]?[0-9]{1,18}")
COMMA = re.compile(r"[0-9],[0-9]")


def read_text(path: Path, *, final_line_end: bool = True) -> str:
    """Return the text of a file, in UTF-8 or else Latin-1, with lines that end by a line feed.

    A last line without its line end may be a number cut short ("1603.25" and
    "1603.2" both parse), so it is refused where the format has no other end mark.
    """
    return "".join(text for _, text in TextBlocks(path, final_line_end=final_line_end))


def line_blocks(text: str) -> Iterator[tuple[int, str]]:
    """Yield a text in pieces of whole lines, each with the number of its first line.

    Words of a file take twenty times its memory; those of a piece at a time do not.
    """
    at, line = 0, 1
    while at < len(text):
        # A piece ends at a line end, so that no number is cut in two.
        end = text.find("\n", at + BLOCK) + 1 or len(text)
        piece = text[at:end]
        yield line, piece
        line += piece.count("\n")
        at = end


def numbers(words: Sequence[str]) -> np.ndarray | None:
    """Return words as finite float64, or None if one is not a plain number.

    A plain number is what other programs take, too: not '1_000', 'nan' or digits of other scripts.

    Examples
    --------
    >>> numbers(["1", "-2.5e3"]), numbers(["1_000"]), numbers(["inf"])
    (array([ 1.0e+00, -2.5e+03]), None, None)
    """
    try:
        values = np.array(list(map(float, words)))
    except ValueError:
        return None

    # Python takes more than other programs do: underscores and digits of other scripts.
    joined = "".join(words)
    if "_" in joined or not joined.isascii() or not np.isfinite(values).all():
        return None
    return values


def is_number(word: str) -> bool:
    """Return whether a word of a file is a plain number, or infinite, or not-a-number.

    Examples
    --------
    >>> is_number("1e3"), is_number("nan"), is_number("1_000"), is_number("Top")
    (True, True, False, False)
    """
    try:
        float(word)
    except ValueError:
        return False
    return word.isascii() and "_" not in word


def number(token: str, path: Path, line: int, what: str) -> float:
    """Return a finite float, or name the line and the token."""
    if not is_number(token):
        decimal = " If it has a decimal comma, pass decimal=','." if COMMA.search(token) else ""
        raise FormatError(
            f"{path}, line {line}: found {token!r}, expected a number ({what}).{decimal} "
            "Correct that line or export the file again."
        )
    value = float(token)
    if not math.isfinite(value):
        raise FormatError(
            f"{path}, line {line}: found {token!r}, expected a finite number ({what}). "
            "Correct that line or export the file again."
        )
    return value


def integer(token: str, path: Path, line: int, what: str) -> int:
    """Return an int, or name the line and the token."""
    if not WHOLE.fullmatch(token):
        raise FormatError(
            f"{path}, line {line}: found {token[:40]!r}, expected a whole number ({what}). "
            "Correct that line or export the file again."
        )
    return int(token)


def number_rows(rows: list[list[str]], lines: Sequence[int], path: Path, what: str) -> np.ndarray:
    """Return equal-length rows of tokens as finite float64 (n_row, n_column)."""
    # All at once: a hundred times as fast as one by one.
    values = numbers(list(itertools.chain.from_iterable(rows)))
    if values is not None:
        return values.reshape(len(rows), -1)
    # something is wrong: go token by token and name the first that is
    return np.array(
        [
            [number(token, path, line, what) for token in row]
            for row, line in zip(rows, lines, strict=True)
        ]
    )


def number_text(text: str, path: Path, first: int, what: str) -> np.ndarray:
    """Return all words of a text, which begins on line `first` of its file, as finite float64."""
    parts = [
        piece_numbers(piece, path, first + line - 1, what) for line, piece in line_blocks(text)
    ]
    return np.concatenate([np.empty(0), *parts])


def piece_numbers(piece: str, path: Path, first: int, what: str) -> np.ndarray:
    """Return the words of some lines as finite float64, or name the first wrong one."""
    values = numbers(piece.split())
    if values is not None:
        return values
    for i, row in enumerate(piece.split("\n"), start=first):
        for word in row.split():
            number(word, path, i, what)
    raise AssertionError(f"{path}: a number was refused, and then not")


def block_numbers(
    blocks: TextBlocks,
    expected: int,
    take: Callable[[str, int], np.ndarray],
) -> tuple[np.ndarray, int]:
    """
    Return the numbers of a text, block by block, without lists of their parts.

    Parameters
    ----------
    blocks : TextBlocks
    expected : int
        How many numbers the header of the file announces.
    take : callable
        Numbers of a piece that begins on a line.

    Returns
    -------
    (ndarray of float64, shape (expected,), int)
        Numbers, and how many there are; if that is another count, the numbers are not whole.
    """
    # two bytes at least for each: a header that announces more gets no memory
    values = np.empty(min(expected, blocks.size))
    n = 0
    for line, piece in blocks:
        found = take(piece, line)
        values[n : n + len(found)] = found[: max(0, len(values) - n)]
        n += len(found)
    return values, n


@dataclass(frozen=True)
class Request:
    """What a caller says of a file; None where it says nothing.

    Attributes
    ----------
    name : str or None
        Which object is meant, or what to call the only one.
    positive, length_unit : str or None
        Direction and unit of z, for files that do not state them.
    columns : sequence of str or of int, or None
        Which columns of a table are x, y and z.
    decimal : str
        Decimal sign of a table.
    variable : str or None
        Which variable of a NetCDF file or Zarr store.
    """

    name: str | None = None
    positive: str | None = None
    length_unit: str | None = None
    columns: Any = None
    decimal: str = "."
    variable: str | None = None

    def named(self, path: Path) -> str:
        """Return the name, else that of the file without suffix."""
        return self.name or path.stem

    def scale(
        self,
        what: str,
        *,
        positive: str | None = None,
        unit: str | None = None,
        default: str | None = "m",
    ) -> float:
        """Metres of elevation per unit of z, below 0 for depths; a file may state both words."""
        sign = agreed_sign(positive, self.positive, what)
        return sign * agreed_scale(unit, self.length_unit, default, what)


class Otherwise(str):
    """A default for several files: it applies to the files that do not state their own value."""

    __slots__ = ()


def otherwise(words: Mapping[str, str | None]) -> dict[str, Any]:
    """Return ``positive`` and ``length_unit`` for a reader, as defaults."""
    return {key: None if word is None else Otherwise(word) for key, word in words.items()}


def agreed_sign(stated: str | None, requested: str | None, what: str) -> float:
    """Return +1 (elevation) or -1 (depth) from a file and the argument of a caller."""
    # a default for many files applies only where the file is silent
    if isinstance(requested, Otherwise):
        elevation_sign(requested, what)
        requested = requested if stated is None else None

    if requested is not None:
        elevation_sign(requested, what)  # a misspelt word is reported as such
    if (
        stated is not None
        and requested is not None
        and elevation_sign(stated, what) != elevation_sign(requested, what)
    ):
        raise InputError(
            f"{what}: the file has positive={stated!r}, but the argument is "
            f"positive={requested!r}. "
            "Leave the argument out, or correct the file."
        )
    sign = elevation_sign(stated if stated is not None else requested, what)
    noted("sign", f"positive {stated}, stated by the file" if stated else "open: give positive=")
    return sign


def agreed_scale(
    stated: str | None, requested: str | None, default: str | None, what: str
) -> float:
    """Return metres per unit from a file, the argument of a caller, or a format."""
    # A default of the caller gives way to what the file states.
    if isinstance(requested, Otherwise):
        metres_per_unit(requested, what)
        requested = requested if stated is None else None
    if requested is not None:
        metres_per_unit(requested, what)

    # Both state a unit: they have to agree in size, not in spelling.
    if stated is not None and requested is not None:
        if metres_per_unit(stated, what) != metres_per_unit(requested, what):
            raise InputError(
                f"{what}: the file has the length unit {stated!r}, but "
                f"length_unit={requested!r} was "
                "given. Leave the argument out, or correct the file."
            )
        return metres_per_unit(stated, what)
    found = f"{stated}, stated by the file" if stated else f"open: {default} unless length_unit="
    noted("unit of z", found)
    return metres_per_unit(first_given(stated, requested, default), what)
