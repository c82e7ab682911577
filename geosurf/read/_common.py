"""Helpers of all readers: bytes, lines, numbers, and the direction of elevations.

Readers never guess. Whether a file holds elevation or depth is stated by the file
or by the caller; when both speak they must agree.
"""

from __future__ import annotations

import contextlib
import math
import re
import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from geosurf.conventions import did_you_mean, elevation_sign, first_given, metres_per_unit
from geosurf.conventions.axes import TimeUnit, is_time_unit
from geosurf.errors import FormatError, InputError, warn_of
from geosurf.read._guard import check_size, damaged, opened, read_some, refuse_beyond_memory

# ---- blocks ----------------------------------------
# A text file in blocks of whole lines, of which one at a time is in memory.


BLOCK = 1 << 18  # bytes at a time: they and their numbers stay in the cache
WIDE_MARKS = (b"\xff\xfe", b"\xfe\xff", b"\x00\x00\xfe\xff")  # UTF-16 and UTF-32
WIDE = "the text is in UTF-16 or UTF-32. Save the file as UTF-8."
BYTE_ORDER = b"\xef\xbb\xbf"


class TextBlocks:
    r"""
    Blocks of a text in UTF-8 or else Latin-1, with lines that end by a line feed.

    Iteration yields each block with the number of its first line. Blocks end at line ends, so
    that no number is cut in two.

    Parameters
    ----------
    path : pathlib.Path
    final_line_end : bool
        Whether the last line should have a line end. Without it a last number may be cut short
        ("1603.25" and "1603.2" both parse): a warning, where the format has no other end mark.

    Attributes
    ----------
    size : int
        Bytes of the file.
    head : str
        The first block: at least `BLOCK` bytes, or the whole text.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "a.txt"
    >>> _ = file.write_bytes(b"name\r\n1 2\r\n3 4\r\n")
    >>> blocks = TextBlocks(file)
    >>> blocks.skip(5)
    >>> list(blocks)
    [(2, '1 2\n3 4\n')]
    """

    def __init__(self, path: Path, *, final_line_end: bool = True) -> None:
        self.path = path
        self.size = 0
        self._blocks = self._decoded(final_line_end)
        self.head = next(self._blocks)
        self._line = 1

    def skip(self, n: int) -> None:
        """Leave out the first characters of the head, before blocks are taken."""
        self._line += self.head.count("\n", 0, n)
        self.head = self.head[n:]

    def __iter__(self) -> Iterator[tuple[int, str]]:
        # the head is not kept: its memory would stay with that of the values
        block: str | None = self.head
        self.head = ""
        while block is not None:
            yield self._line, block
            self._line += block.count("\n")
            block = next(self._blocks, None)

    def _decoded(self, final_line_end: bool) -> Iterator[str]:
        """Yield blocks as text; the first one holds more than white space."""
        waiting, n_line = "", 1
        for data, is_last in self._pieces():
            # UTF-8 first, which other encodings seldom pass by chance; Latin-1 takes any byte
            try:
                text = data.decode("utf-8")
            except UnicodeDecodeError:
                text = data.decode("latin-1")
            if "\r" in text:
                # line ends of Windows and of old Macs
                text = text.replace("\r\n", "\n").replace("\r", "\n")
            waiting += text
            blank = not waiting or waiting.isspace()
            if is_last and final_line_end and not blank and not waiting[-1].isspace():
                last = waiting[waiting.rfind("\n") + 1 :]
                warn_of_end(self.path, n_line + waiting.count("\n"), last)
                waiting += "\n"
            if n_line == 1 and blank:
                if is_last:
                    raise damaged(f"{self.path}: the file contains only white space")
                continue
            n_line += waiting.count("\n")
            if waiting:
                yield waiting
            waiting = ""

    def _pieces(self) -> Iterator[tuple[bytes, bool]]:
        """Yield whole lines of bytes, and whether they are the last ones."""
        parts: list[bytes] = []
        n_read = 0
        with opened(self.path) as (file, self.size):
            refuse_beyond_memory(self.path, self.size)
            # one byte more than expected shows that the file has grown meanwhile
            while data := read_some(self.path, file, min(BLOCK, self.size - n_read + 1)):
                self._refuse_no_text(data, n_read)
                text = data if n_read else data.removeprefix(BYTE_ORDER)
                n_read += len(data)
                # a carriage return at the end may belong to a line end of Windows
                cut = max(text.rfind(b"\n"), text.rfind(b"\r", 0, len(text) - 1)) + 1
                if cut:
                    yield b"".join([*parts, text[:cut]]), False
                    parts = []
                parts.append(text[cut:])
        check_size(self.path, self.size, n_read)
        yield b"".join(parts), True

    def _refuse_no_text(self, data: bytes, before: int) -> None:
        """Refuse zero bytes; wide texts have them between letters, and get their own sentence."""
        if before == 0 and data.startswith(WIDE_MARKS):
            raise FormatError(f"{self.path}: {WIDE}")
        if b"\0" in data:
            raise FormatError(
                f"{self.path}: byte {before + data.index(0)} is zero, so this is not a text file. "
                "Set format= to its format."
            )


# ---- choice ----------------------------------------
# Files with several named objects: which one a caller means.


Part = TypeVar("Part")
MOST_NAMED = 12  # names in one message


def chosen(
    path: Path, parts: Sequence[tuple[str, Part]], name: str | None, what: str
) -> tuple[str, list[Part]]:
    """
    Return the name and the parts of the one object that a caller means.

    Parameters
    ----------
    path : pathlib.Path
    parts : sequence of (str, part)
        Parts of all objects, each with the name of its object, "" without one.
    name : str or None
        The name that the caller gives; any name is right where there is one object.
    what : str
        Objects in the plural: "faults".

    Raises
    ------
    InputError
        If there are several and `name` is not one of them.

    Examples
    --------
    >>> parts = [("F1", 1), ("F1", 2), ("F2", 3)]
    >>> chosen(Path("f.dat"), parts, "F2", "faults")
    ('F2', [3])
    >>> chosen(Path("f.dat"), parts, None, "faults")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    geosurf.errors.InputError: f.dat: the file has 2 faults: F1, F2. Choose one, as in name='F1' ...
    """
    names = list(dict.fromkeys(title for title, _ in parts))
    listed = _listed(names)
    if any(names):
        noted("names", f"{len(names)} {what}: {listed}" if len(names) > 1 else listed)
    if len(names) > 1 and name in names:
        return str(name), [part for title, part in parts if title == name]
    if len(names) <= 1 or is_looking():  # `geosurf.info` looks at all of them
        return names[0] if len(names) == 1 else "", [part for _, part in parts]
    asked = "" if name is None else f", but none is called {name!r}"
    guess = "" if name is None else did_you_mean(name, names)
    raise InputError(
        f"{path}: the file has {len(names)} {what}: {listed}{asked}.{guess} Choose one, as in "
        f"name={names[0]!r} (on the command line: --name {shlex.quote(names[0])})."
    )


def check_name(path: Path, names: Iterable[str], name: str | None) -> None:
    """Note the names of the lines of a file, and refuse a name that none of them has."""
    known = list(dict.fromkeys(one for one in names if one))
    if known:
        noted("names", _listed(known))
    if name is not None and name not in known:
        raise InputError(
            f"{path}: no line is called {name!r}. Names are {_listed(known) or 'absent'}; leave "
            "name= out to read all lines."
        )


def _listed(names: list[str]) -> str:
    return ", ".join(names[:MOST_NAMED]) + (" ..." if len(names) > MOST_NAMED else "")


_LOOKING: ContextVar[bool] = ContextVar("geosurf_read_looking", default=False)
_NOTES: ContextVar[dict[str, str] | None] = ContextVar("geosurf_read_notes", default=None)


def noted(key: str, value: object) -> None:
    """Keep one sentence on what was read; later ones replace earlier ones."""
    notes = _NOTES.get()
    if notes is not None:
        notes[key] = str(value)


@contextlib.contextmanager
def collected(*, looking: bool = False) -> Iterator[dict[str, str]]:
    """
    Collect what readers note meanwhile, in this thread.

    `looking` is for `geosurf.info`: readers take a file with several objects, and do not warn.
    """
    notes: dict[str, str] = {}
    token, before = _NOTES.set(notes), _LOOKING.set(looking)
    try:
        yield notes
    finally:
        _NOTES.reset(token)
        _LOOKING.reset(before)


def is_looking() -> bool:
    """Whether `geosurf.info` looks at a file, which may then hold several objects."""
    return _LOOKING.get()


def warn_of_end(path: Path, line: int, last: str, missing: str = "line end") -> None:
    """Warn of a file that may be cut off: its last line may be half of one."""
    effect = f"{path}, line {line}: no {missing} follows {last.strip()[-60:]!r}"
    noted("end", f"no {missing} after the last line, so the file may be cut off")
    if not is_looking():
        effect += ", so the file may be cut off there; it is read as if it were complete."
        warn_of("file end", path.name, effect, f"Compare it with its source, or add the {missing}.")


WHOLE = re.compile(r"[+-]?[0-9]{1,18}")
COMMA = re.compile(r"[0-9],[0-9]")


def read_text(path: Path, *, final_line_end: bool = True) -> str:
    """Return the text of a file, in UTF-8 or else Latin-1, with lines that end by a line feed."""
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


def with_point(word: str, decimal: str) -> str:
    """Return a word of a file with that decimal sign as Python takes it."""
    return word.replace(",", ".", 1) if decimal == "," else word


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
        raise damaged(f"{path}, line {line}: found {token!r}, expected a finite number ({what})")
    return value


def integer(token: str, path: Path, line: int, what: str) -> int:
    """Return an int, or name the line and the token."""
    if not WHOLE.fullmatch(token):
        raise damaged(
            f"{path}, line {line}: found {token[:40]!r}, expected a whole number ({what})"
        )
    return int(token)


def number_rows(words: Sequence[str], lines: Sequence[int], path: Path, what: str) -> np.ndarray:
    """Return the words of some lines, as many of each, as finite float64 (n_line, n_column)."""
    # All at once: a hundred times as fast as one by one.
    values, width = numbers(words), len(words) // max(len(lines), 1)
    if values is None:  # something is wrong: go word by word and name the first that is
        found = (number(word, path, lines[k // width], what) for k, word in enumerate(words))
        values = np.array(list(found))
    return values.reshape(len(lines), width)


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
    blocks: TextBlocks, expected: int, take: Callable[[str, int], np.ndarray]
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
    """What a caller states of a file; None where it states nothing.

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


class Ratio(Otherwise):
    """In place of a length unit: values are ratios, or of this unit, and taken as they are."""

    __slots__ = ()


# readers of grids put "m" where files state nothing
RATIOS = ("None", "1", "", "m", "fraction", "v/v", "m3/m3", "rm3/sm3", "Rm3/Sm3")
VELOCITIES = ("None", "", "m", "m/s", "m s-1", "m.s-1", "m s^-1")


def check_ratio(stated: str | None, what: str, unit: str = "1") -> None:
    """Refuse a unit that no ratio has, or no velocity in m/s."""
    if str(stated) in (VELOCITIES if unit == "m/s" else RATIOS):
        return
    wanted = "a ratio. Divide percent by 100, and set attrs['units'] = '1'"
    if unit == "m/s":
        wanted = "in m/s. Convert it"
    raise InputError(f"{what} is in {stated!r}; it must be {wanted}.")


def otherwise(words: Mapping[str, str | None]) -> dict[str, Any]:
    """Return ``positive`` and ``length_unit`` for a reader, as defaults."""
    return {
        key: word if word is None or isinstance(word, TimeUnit) else Otherwise(word)
        for key, word in words.items()
    }


def _asked(
    stated: str | None, requested: str | None, check: Callable[[str, str], Any], what: str
) -> str | None:
    """What a caller asks for: a default for many files applies only where the file is silent."""
    if requested is not None:
        check(requested, what)  # a misspelt word is reported as such
    return None if isinstance(requested, Otherwise) and stated is not None else requested


def agreed_sign(stated: str | None, requested: str | None, what: str) -> float:
    """Return +1 (elevation) or -1 (depth) from a file and the argument of a caller."""
    requested = _asked(stated, requested, elevation_sign, what)
    if (
        stated is not None
        and requested is not None
        and elevation_sign(stated, what) != elevation_sign(requested, what)
    ):
        raise InputError(
            f"{what}: the file has positive={stated!r}, but the argument is "
            f"positive={requested!r}. Leave the argument out, or correct the file."
        )
    sign = elevation_sign(stated if stated is not None else requested, what)
    noted("sign", f"positive {stated}, stated by the file" if stated else "open: give positive=")
    return sign


def agreed_scale(
    stated: str | None, requested: str | None, default: str | None, what: str
) -> float:
    """Return metres per unit from a file, the argument of a caller, or a format."""
    if isinstance(requested, Ratio):
        check_ratio(stated, what, requested)
        return 1.0
    # A scene in time takes times only: its unit counts where the file states none.
    if isinstance(requested, TimeUnit):
        if stated is not None and not is_time_unit(stated):
            raise InputError(
                f"{what}: the file has the length unit {stated!r}, but the scene is in time. Leave "
                "time= out, or give the file in ms."
            )
        return metres_per_unit(TimeUnit(stated or requested), what)
    requested = _asked(stated, requested, metres_per_unit, what)

    # Both state a unit: they have to agree in size, not in spelling.
    if stated is not None and requested is not None:
        if metres_per_unit(stated, what) != metres_per_unit(requested, what):
            raise InputError(
                f"{what}: the file has the length unit {stated!r}, but length_unit={requested!r} "
                "was given. Leave the argument out, or correct the file."
            )
        return metres_per_unit(stated, what)
    found = f"{stated}, stated by the file" if stated else f"open: {default} unless length_unit="
    noted("unit of z", found)
    return metres_per_unit(first_given(stated, requested, default), what)
