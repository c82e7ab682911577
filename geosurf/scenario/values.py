"""How values of a scenario are checked; each check states what it accepts.

A check takes a `KeyPath` and the value that TOML gave, and returns the value for
the dataclass. ``check.allowed`` is that statement, for messages and docs.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import wraps
from pathlib import Path
from typing import Any, NoReturn, Protocol

from geosurf.conventions import did_you_mean, is_number
from geosurf.errors import InputError
from geosurf.model.faults import WAYS
from geosurf.read._guard import is_zarr
from geosurf.render.views import LARGEST, SMALLEST, check_size

# words between quotes in what a check allows
BARE = re.compile(r'"(\w+)"')


Keys = tuple[str | int, ...]  # the path to a value in a document


@dataclass(frozen=True)
class Mistake:
    """What is wrong with a value.

    Attributes
    ----------
    keys : tuple of str or int
        The path of the value, or of the table that lacks it.
    sentence : str
        What is wrong, and what to write.
    missing : bool
        Whether a key is not there.
    """

    keys: Keys
    sentence: str
    missing: bool = False


class WrongValue(Exception):
    """Ends the check of one value."""

    def __init__(self, mistake: Mistake) -> None:
        super().__init__(mistake.sentence)
        self.mistake = mistake


@dataclass(frozen=True)
class KeyPath:
    """The place of a value in a scenario, and the mistakes that were found in the whole of it.

    Attributes
    ----------
    file : pathlib.Path
    keys : tuple of str or int
    words : str
        The same as messages have it: ``horizons['Top'].file``.
    found : list of Mistake
    tables : dict of str to tuple
        The keys of each table of a list, by its words.
    """

    file: Path
    keys: Keys = ()
    words: str = ""
    found: list[Mistake] = field(default_factory=list)
    tables: dict[str, Keys] = field(default_factory=dict)

    def inside(self, word: str, meant: str | None = None) -> KeyPath:
        """Return the place of a key in this table; messages name the key that is `meant`."""
        meant = meant or word
        words = f"{self.words}.{meant}" if self.words else meant
        return replace(self, keys=(*self.keys, word), words=words)

    def row(self, number: int, label: str) -> KeyPath:
        """Return the place of a table of this list."""
        words = f"{self.words}[{label}]"
        self.tables[words] = (*self.keys, number)
        return replace(self, keys=self.tables[words], words=words)

    def of(self, words: str, key: str = "") -> KeyPath:
        """Return the place of a table, or of a key in it, by the words for the table."""
        keys = self.tables.get(words, (words,) if words else ())
        return replace(self, keys=(*keys, key) if key else keys, words=words)

    def refuse(self, sentence: str, *, missing: bool = False) -> NoReturn:
        """End the check of this value with a sentence."""
        raise WrongValue(Mistake(self.keys, sentence, missing))

    @contextmanager
    def noting(self) -> Iterator[None]:
        """Note a mistake that the block raises, and go on behind it."""
        try:
            yield
        except WrongValue as error:
            self.found.append(error.mistake)
        except InputError as error:
            self.found.append(Mistake(self.keys, str(error)))


class Check(Protocol):
    """A function that turns a raw value into a checked one."""

    allowed: str

    def __call__(self, at: KeyPath, value: Any) -> Any:
        """Return the checked value, or raise `WrongValue`."""


def check(allowed: str) -> Callable[[Callable[[KeyPath, Any], Any]], Check]:
    """Make a check of a function that returns None for a value that is not allowed."""

    def wrap(function: Callable[[KeyPath, Any], Any]) -> Check:
        """Make the check of one function."""

        @wraps(function)
        def checked(at: KeyPath, value: Any) -> Any:
            """Return the value as it is to be used, or refuse it."""
            # None is "not allowed"; TOML has no null, so no value is lost
            result = function(at, value)
            if result is None:
                guess = did_you_mean(value, BARE.findall(allowed)) if isinstance(value, str) else ""
                at.refuse(f"{at.words} is {value!r}; it must be {allowed}.{guess}")
            return result

        checked.allowed = allowed  # type: ignore[attr-defined]
        return checked  # type: ignore[return-value]

    return wrap


@check("text between quotes")
def text(_: KeyPath, value: Any) -> str | None:
    """A string with something in it."""
    # Spaces alone count as empty.
    return value if isinstance(value, str) and value.strip() else None


@check("true or false")
def switch(_: KeyPath, value: Any) -> bool | None:
    """A truth value."""
    return value if isinstance(value, bool) else None


@check("a number above 0")
def above_zero(_: KeyPath, value: Any) -> float | None:
    """A finite number above zero."""
    return above_zero_or_none(value)


@check('"auto", a number above 0, or a table such as {F1 = 3.0}')
def trim(_: KeyPath, value: Any) -> str | float | dict[str, Any] | None:
    """A trim for all faults, or by fault."""
    # a table by fault; empty ones are refused, as they would mean nothing
    if isinstance(value, dict):
        every = all(one == "auto" or above_zero_or_none(one) for one in value.values())
        return dict(value) if value and every else None
    return "auto" if value == "auto" else above_zero_or_none(value)


@check('true, false, "lower", "upper", "pinch out", or a table such as {Middle = "lower"}')
def filling(_: KeyPath, value: Any) -> bool | str | dict[str, Any] | None:
    """What becomes of blocks without data, for all horizons or by horizon."""
    # One word for all horizons, or one for each.
    every = list(value.values()) if isinstance(value, dict) else [value]
    right = every and all(isinstance(one, bool) or one in list(WAYS) for one in every)
    return value if right else None


@check(
    '`true`, or a table of faults such as `{F3 = "boundary", F4 = "F1", F5 = {end = "nearest"}}`'
)
def compartments(_: KeyPath, value: Any) -> bool | dict[str, Any] | None:
    """Faults that virtual walls continue; the scene checks their names."""
    return value if isinstance(value, bool | dict) else None


@check(
    'a whole number above 0, or a table of zones such as `{"Top/Base" = 10}` or '
    '`{"Top/Base" = {thickness = 2.5, parallel = "top"}}`'
)
def layers(_: KeyPath, value: Any) -> int | dict[str, Any] | None:
    """Layers of a simulation grid; zones are checked when all horizons are known."""
    if isinstance(value, dict):
        return dict(value) if value else None
    whole = isinstance(value, int) and not isinstance(value, bool)
    return value if whole and value > 0 else None


@check("a number above 0, or two of them along both axes of the grid: [dx, dy]")
def cell(_: KeyPath, value: Any) -> float | tuple[float, float] | None:
    """Size of the cells of a simulation grid."""
    if isinstance(value, list):
        sizes = [above_zero_or_none(one) for one in value]
        return (sizes[0], sizes[1]) if len(sizes) == 2 and sizes[0] and sizes[1] else None
    return above_zero_or_none(value)


@check("a number above 0 and below 90")
def dip(_: KeyPath, value: Any) -> float | None:
    """A dip that is neither flat nor vertical."""
    return float(value) if is_number(value) and 0 < value < 90 else None


def above_zero_or_none(value: Any) -> float | None:
    """A finite number above zero, else None."""
    return float(value) if is_number(value) and value > 0 else None


@check("a whole number above 0")
def count(_: KeyPath, value: Any) -> int | None:
    """A number of something that is counted from 1."""
    return value if type(value) is int and value > 0 else None


@check('three names or numbers of columns or more, such as ["X", "Y", "Z"] or [1, 2, 3]')
def columns(_: KeyPath, value: Any) -> tuple[str, ...] | tuple[int, ...] | None:
    """Columns of a table; readers check how many they take."""
    if not isinstance(value, list) or len(value) < 3:
        return None
    right = all(type(v) is int and v > 0 for v in value) or all(isinstance(v, str) for v in value)
    return tuple(value) if right else None


@check("a number")
def number(_: KeyPath, value: Any) -> float | None:
    """A finite number."""
    return float(value) if is_number(value) else None


@check("a number, 0 or above")
def not_negative(_: KeyPath, value: Any) -> float | None:
    """A finite number that is not below zero."""
    return float(value) if is_number(value) and value >= 0 else None


@check("a number from 0 to 1")
def share(_: KeyPath, value: Any) -> float | None:
    """A part of a whole."""
    return float(value) if is_number(value) and 0 <= value <= 1 else None


@check("three or more corners: [[easting, northing], ...]")
def corners(_: KeyPath, value: Any) -> tuple[tuple[float, float], ...] | None:
    """Pairs of finite numbers."""
    # Shape first, then numbers: `map` would fail on anything else.
    if not isinstance(value, list) or len(value) < 3:
        return None
    if not all(isinstance(c, list) and len(c) == 2 and all(map(is_number, c)) for c in value):
        return None
    return tuple((float(x), float(y)) for x, y in value)


@check("lines of two points or more, no two in a row the same: [[[easting, northing], ...], ...]")
def lines(_: KeyPath, value: Any) -> tuple[tuple[tuple[float, float], ...], ...] | None:
    """Lines in the map; an empty list stands for none."""
    if not isinstance(value, list) or not all(isinstance(one, list) for one in value):
        return None
    found = []
    for one in value:
        # numbers of points and equal neighbours are checked where sections check them
        fits = [isinstance(c, list) and len(c) == 2 and all(map(is_number, c)) for c in one]
        if not all(fits):
            return None
        from geosurf.measure.section import check_line  # loaded by those who cut sections

        try:
            found.append(tuple(map(tuple, check_line(one).tolist())))
        except InputError:
            return None
    return tuple(found)


@check("one row or more: [[distance, throw], ...]")
def profile(_: KeyPath, value: Any) -> tuple[tuple[float, float], ...] | None:
    """Pairs of finite numbers."""
    if not isinstance(value, list) or len(value) == 0:
        return None
    if not all(isinstance(c, list) and len(c) == 2 and all(map(is_number, c)) for c in value):
        return None
    return tuple((float(s), float(t)) for s, t in value)


@check("a list of names, each once")
def names(_: KeyPath, value: Any) -> tuple[str, ...] | None:
    """Different names; whether they exist is asked when all are known."""
    if not isinstance(value, list) or not all(isinstance(v, str) for v in value):
        return None
    return tuple(value) if len(set(value)) == len(value) else None


@check("two numbers, the lower one first: [low, high]")
def interval(_: KeyPath, value: Any) -> tuple[float, float] | None:
    """Two finite numbers that increase."""
    if not isinstance(value, list) or len(value) != 2 or not all(map(is_number, value)):
        return None
    # Equal limits enclose nothing.
    low, high = map(float, value)
    return (low, high) if low < high else None


@check(f"two whole numbers, [width, height], from {list(SMALLEST)} to {list(LARGEST)}")
def picture_size(_: KeyPath, value: Any) -> tuple[int, int] | None:
    """Width and height in pixels."""
    # Whole numbers only: pixels cannot be halved.
    if not isinstance(value, list) or not all(type(v) is int for v in value):
        return None
    try:
        return check_size(tuple(value))
    except InputError:
        return None


@check('the names of two surfaces: ["Top", "F1"]')
def pair_of_names(_: KeyPath, value: Any) -> tuple[str, str] | None:
    """Two different names; whether they exist is asked when all names are known."""
    if not isinstance(value, list) or len(value) != 2 or not all(isinstance(v, str) for v in value):
        return None
    return (value[0], value[1]) if value[0] != value[1] else None


@check("a file that exists, its path relative to the scenario")
def file(at: KeyPath, value: Any) -> Path | None:
    """The path of a file, found from the folder of the scenario."""
    if not isinstance(value, str) or not value.strip():
        return None
    # Relative to the scenario, so that a folder can be moved as a whole.
    path = at.file.parent / value
    if not path.is_file() and not is_zarr(path):
        near = [entry.name for entry in _entries(path.parent)]
        what = "a folder" if path.is_dir() else "not there"
        at.refuse(
            f"{at.words} is {value!r}, and {path} is {what}. Paths are relative to the folder of "
            f"the scenario.{did_you_mean(path.name, near)}"
        )
    return path


def _entries(folder: Path) -> list[Path]:
    return sorted(folder.iterdir()) if folder.is_dir() else []


def listed_words(allowed: tuple[str, ...]) -> str:
    """Return words in quotes, with commas between them."""
    return ", ".join(repr(word) for word in allowed)


def one_of(*allowed: str) -> Check:
    """Return the check for one word of a list."""

    @check(f"one of {listed_words(allowed)}")
    def choice(at: KeyPath, value: Any) -> str | None:
        """The word, if it is allowed."""
        # A misspelt word gets a suggestion; other types get the list alone.
        if isinstance(value, str) and value not in allowed:
            guess = did_you_mean(value, allowed)
            at.refuse(f"{at.words} is {value!r}; it must be one of {listed_words(allowed)}.{guess}")
        return value if value in allowed else None

    return choice


def some_of(*allowed: str) -> Check:
    """Return the check for a list of words, each at most once."""

    @check(f"a list of any of {listed_words(allowed)}, each once")
    def choices(at: KeyPath, value: Any) -> tuple[str, ...] | None:
        """The words, if all are allowed and none comes twice."""
        if not isinstance(value, list) or not all(isinstance(v, str) for v in value):
            return None
        for word in value:
            if word not in allowed:
                guess = did_you_mean(word, allowed)
                at.refuse(f"{at.words} has {word!r}; it may have {listed_words(allowed)}.{guess}")
        return tuple(value) if len(set(value)) == len(value) else None

    return choices
