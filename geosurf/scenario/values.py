"""How values of a scenario are checked; each check states what it accepts.

A check takes a `KeyPath` and the value that TOML gave, and returns the value for
the dataclass. ``check.allowed`` is that statement, for messages and docs.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import MISSING, dataclass, field, fields, replace
from functools import wraps
from operator import eq
from pathlib import Path
from typing import Any, NoReturn, Protocol

from geosurf.conventions import METRES_PER_UNIT, did_you_mean, is_number
from geosurf.conventions.axes import MS_PER_UNIT
from geosurf.conventions.text import closest
from geosurf.errors import InputError
from geosurf.measure.velocity import TOPS, WELLS
from geosurf.model.network import SIDES, WAYS
from geosurf.model.regions import check_regions
from geosurf.read._guard import is_zarr
from geosurf.render.views import LARGEST, SMALLEST, ZOOMS, check_size

# ---- declare ----------------------------------------
# How a key of a scenario is declared.


def key(check: Check, *, unit: str = "", default: Any = MISSING) -> Any:
    """Declare one key: how its value is checked, and its default.

    What it means stands in the docstring of its table, from where the documentation takes it.
    """
    metadata = {"check": check, "unit": unit}
    if default is MISSING:
        return field(metadata=metadata)
    return field(default=default, metadata=metadata)


# ---- tables ----------------------------------------
# How tables of a scenario are read: each key by its check, then keys that are missing.


INCOMPLETE = object()  # stands for a table that lacks what it needs
# keys that stand in no table
TOP_LEVEL = ("title", "tolerance_m", "positive", "length_unit", "crs")


def table(kind: type) -> Check:
    """Return the check for a table, ``[kind]``."""

    @check("a table")
    def one_table(at: KeyPath, value: Any) -> Any:
        """The table as an object."""
        if isinstance(value, list | bool):  # [[name]] and name = true are the usual slips
            at.refuse(f"{at.words} must be one table: write [{at.words}] on a line of its own.")
        if not isinstance(value, Mapping):
            return None
        found = read_table(kind, at, value)
        return INCOMPLETE if found is None else found

    # `page` and the parser find the keys of the table here.
    one_table.kind = kind  # type: ignore[attr-defined]
    return one_table


def tables(kind: type) -> Check:
    """Return the check for tables in order, ``[[kind]]``, which all have different names."""

    @check("tables in double brackets")
    def many_tables(at: KeyPath, value: Any) -> tuple[Any, ...] | None:
        """The tables as objects."""
        # [name] in place of [[name]] is the usual slip.
        if not isinstance(value, list) or not all(isinstance(v, Mapping) for v in value):
            name = at.words
            at.refuse(f"{name} must be tables in double brackets, as in [[{name}]].")
        rows = (
            read_table(kind, at.row(row, _label(row, entry)), entry)
            for row, entry in enumerate(value)
        )
        return tuple(one for one in rows if one is not None)

    many_tables.kind = kind  # type: ignore[attr-defined]
    return many_tables


def _label(row: int, entry: Mapping[str, Any]) -> str:
    """The name of a table, else its number, counted from 1."""
    name = entry.get("name")
    return repr(name) if isinstance(name, str) and name.strip() else f"number {row + 1}"


def _belongs(word: str, at: KeyPath) -> str:
    """Where a key belongs that is of the whole scenario; TOML puts it into the table above."""
    if at.words and word in TOP_LEVEL:
        return f" {word!r} belongs to the whole scenario: write it above the first table."
    return ""


def read_table(kind: type, at: KeyPath, table: Mapping[str, Any], **more: Any) -> Any:
    """Check all keys of a table and return its dataclass.

    Parameters
    ----------
    kind : type
        A dataclass of `geosurf.scenario.keys`.
    at : KeyPath
        The path of the table; takes a note of each unknown key, each missing one, and each value
        that its check refuses.
    found : mapping
        What TOML gave.
    **more
        Values of fields that have no key in the file.

    Returns
    -------
    object of type `kind`, or None
        Wrong values have their defaults; a file is the scenario, and a name the number of the
        table, so that what refers to others can be checked. None if another value is needed.
    """
    known = {entry.name: entry for entry in fields(kind) if "check" in entry.metadata}
    where = f" in {at.words}" if at.words else ""
    checked: dict[str, Any] = {}
    tried = set()
    for word, value in table.items():
        meant = word
        if word not in known:
            # the value of a misspelt key may be wrong, too
            guess = closest(word, known)
            with at.inside(word).noting():
                at.inside(word).refuse(
                    f"unknown key {word!r}{where}; known keys are {listed_words(tuple(known))}."
                    f"{did_you_mean(word, known) or _belongs(word, at)}"
                )
            if guess is None or guess in table:
                continue
            meant = guess
        tried.add(meant)
        place = at.inside(word, meant)
        with place.noting():
            result = known[meant].metadata["check"](place, value)
            if result is not INCOMPLETE:
                checked[meant] = result

    # Then keys that are missing, with what they take.
    for word, entry in known.items():
        if entry.default is not MISSING or word in checked:
            continue
        if word not in tried:
            with at.noting():
                allowed = entry.metadata["check"].allowed
                at.refuse(f"{word!r} is missing{where}; give {allowed}.")
        if word not in ("name", "file"):
            return None
        checked[word] = at.file if word == "file" else f"table {at.words}"
    return kind(**checked, **more)


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
    """

    keys: Keys
    sentence: str


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

    def refuse(self, sentence: str) -> NoReturn:
        """End the check of this value with a sentence."""
        raise WrongValue(Mistake(self.keys, sentence))

    def note(self, sentence: str) -> None:
        """Note a mistake of this value; the check goes on."""
        self.found.append(Mistake(self.keys, sentence))

    def refuse_unknown(self, label: str, kind: str, name: str, known: Sequence[str]) -> None:
        """Refuse a name that none of some things has, and list those that they have."""
        if name not in known:
            listed = ", ".join(map(repr, dict.fromkeys(known))) or "none"
            guess = did_you_mean(name, known)
            self.refuse(f"{label}: unknown {kind} {name!r}; the scenario has {listed}.{guess}")

    @contextmanager
    def noting(self, label: str = "") -> Iterator[KeyPath]:
        """Note a mistake that the block raises, and go on behind it; a label precedes its words."""
        try:
            yield self
        except WrongValue as error:
            self.found.append(error.mistake)
        except InputError as error:
            self.note(f"{label}{error}")


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


def numeric(allowed: str, fits: Callable[[float], bool]) -> Check:
    """Return the check for a finite number in a range."""
    return check(allowed)(
        lambda _, value: float(value) if is_number(value) and fits(value) else None
    )


def whole(allowed: str, least: int) -> Check:
    """Return the check for a whole number; true is one in Python, and is refused."""
    return check(allowed)(lambda _, value: value if type(value) is int and value >= least else None)


number = numeric("a number", lambda _: True)
above_zero = numeric("a number above 0", lambda value: value > 0)
not_negative = numeric("a number, 0 or above", lambda value: value >= 0)
share = numeric("a number from 0 to 1", lambda value: 0 <= value <= 1)
dip = numeric("a number above 0 and below 90", lambda value: 0 < value < 90)
full_dip = numeric("a number above 0 and below 180", lambda value: 0 < value < 180)
zoom = numeric("a number from 0.1 to 100", lambda value: ZOOMS[0] <= value <= ZOOMS[1])
count = whole("a whole number above 0", 1)
seed = whole("a whole number, 0 or above", 0)
switch = check("true or false")(lambda _, value: value if isinstance(value, bool) else None)

# spaces alone count as empty
text = check("text between quotes")(
    lambda _, value: value if isinstance(value, str) and value.strip() else None
)


@check('"auto", a number above 0, or a table such as {F1 = 3.0}')
def trim(_: KeyPath, value: Any) -> str | float | dict[str, Any] | None:
    """A trim for all faults, or by fault."""
    # a table by fault; empty ones are refused, as they would mean nothing
    if isinstance(value, dict):
        every = all(one == "auto" or above_zero_or_none(one) for one in value.values())
        return dict(value) if value and every else None
    return "auto" if value == "auto" else above_zero_or_none(value)


# `strike` stands for both ends along strike.
FAULT_SIDES = ("strike", *SIDES)


@check("a number above 0, or a table of sides such as {up = 50, down = 80}")
def distances(_: KeyPath, value: Any) -> float | dict[str, float] | None:
    """One distance, or one for each side."""
    if not isinstance(value, Mapping):
        return above_zero_or_none(value)
    found = {side: above_zero_or_none(one) for side, one in value.items()}
    right = found and all(side in FAULT_SIDES and one for side, one in found.items())
    return {side: one for side, one in found.items() if one} if right else None


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


def above_zero_or_none(value: Any) -> float | None:
    """A finite number above zero, else None."""
    return float(value) if is_number(value) and value > 0 else None


@check('three names or numbers of columns or more, such as ["X", "Y", "Z"] or [1, 2, 3]')
def columns(_: KeyPath, value: Any) -> tuple[str, ...] | tuple[int, ...] | None:
    """Columns of a table; readers check how many they take."""
    if not isinstance(value, list) or len(value) < 3:
        return None
    right = all(type(v) is int and v > 0 for v in value) or all(isinstance(v, str) for v in value)
    return tuple(value) if right else None


def _pairs(value: Any, least: int) -> tuple[tuple[float, float], ...] | None:
    """A list of pairs of finite numbers, at least so many."""
    if not isinstance(value, list) or len(value) < least:
        return None
    if not all(isinstance(c, list) and len(c) == 2 and all(map(is_number, c)) for c in value):
        return None
    return tuple((float(x), float(y)) for x, y in value)


corners = check("three or more corners: [[easting, northing], ...]")(
    lambda _, value: _pairs(value, 3)
)
profile = check("one row or more: [[distance, throw], ...]")(lambda _, value: _pairs(value, 1))


@check("lines of two points or more, no two in a row the same: [[[easting, northing], ...], ...]")
def lines(_: KeyPath, value: Any) -> tuple[tuple[tuple[float, float], ...], ...] | None:
    """Lines in the map; an empty list stands for none."""
    lines_read = [_pairs(one, 2) for one in value] if isinstance(value, list) else [None]
    if any(one is None or any(map(eq, one, one[1:])) for one in lines_read):
        return None
    return tuple(filter(None, lines_read))


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


@check(
    'a table such as `{North = [461000.0, 5934000.0], Block = ["F1+", "F2-"], Terrace = "a.pol"}`: '
    "a place, sides of faults, or a file or corners of a polygon"
)
def regions(at: KeyPath, value: Any) -> dict[str, Any] | None:
    """Names of regions; whether they are there is known when the model is built."""
    return check_regions(_with_files(at, value)) if isinstance(value, Mapping) else None


@check(
    'a table such as `{"above Top" = 2000.0, "Top/Base" = {v0 = 1800.0, k = 0.6}, elsewhere = '
    '"map.gri"}`, in m/s'
)
def velocities(at: KeyPath, value: Any) -> dict[str, Any] | None:
    """Velocities by zone or horizon; whether these are there is known when the model is built."""
    return _with_files(at, value, (WELLS, TOPS)) if isinstance(value, Mapping) else None


def _with_files(
    at: KeyPath, value: Mapping[str, Any], but: tuple[str, str] | None = None
) -> dict[str, Any]:
    """Entries by name, with the path of the file that a text names."""
    words = {name: one for name, one in value.items() if isinstance(one, str)}
    files = {name: file(at.inside(name), one) for name, one in words.items() if (name, one) != but}
    return {**value, **files}


def _entries(folder: Path) -> list[Path]:
    return sorted(folder.iterdir()) if folder.is_dir() else []


def listed_words(allowed: tuple[str, ...]) -> str:
    """Return words in quotes, with commas between them."""
    return ", ".join(repr(word) for word in allowed)


def one_of(*allowed: str, meant: Callable[[str], str] | None = None) -> Check:
    """Return the check for one word of a list; `meant` guesses at another one."""

    @check(f"one of {listed_words(allowed)}")
    def choice(at: KeyPath, value: Any) -> str | None:
        """The word, if it is allowed."""
        # A misspelt word gets a suggestion; other types get the list alone.
        if isinstance(value, str) and value not in allowed:
            guess = did_you_mean(value, allowed) if meant is None else meant(value)
            at.refuse(f"{at.words} is {value!r}; it must be one of {listed_words(allowed)}.{guess}")
        return value if value in allowed else None

    return choice


direction = one_of("up", "down")
length_unit = one_of(*METRES_PER_UNIT, *MS_PER_UNIT)
decimal = one_of(".", ",")


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
