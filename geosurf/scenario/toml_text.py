"""The text of a scenario: lines of its keys, lines that are not TOML, keys that are set outside."""

from __future__ import annotations

import copy
import json
import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from geosurf.conventions import did_you_mean
from geosurf.errors import ScenarioError

# ---- toml lines ----------------------------------------
# Where each key of a TOML file is: `tomllib` gives values without their lines.
#
# The text has been read by `tomllib` before, so it is valid: the scan only has to find keys, and to
# skip values without mistaking their content for keys.


Keys = tuple[str | int, ...]

# Multi-line strings may end with quotes of their own before the closing three.
_TOKEN = re.compile(
    r'''(?P<skip>[ \t\r]+|\#[^\n]*)
    |(?P<text>"""(?:[^\\]|\\.)*?"""(?!")|\'\'\'.*?\'\'\'(?!\')|"(?:[^"\\\n]|\\.)*"|'[^'\n]*')
    |(?P<mark>[\[\]{}=,.\n])
    |(?P<bare>[^\s\[\]{}=,."'\#]+)''',
    re.DOTALL | re.VERBOSE,
)


def lines_of_keys(text: str) -> dict[Keys, int]:
    r"""
    Return the line of each table and key, counted from 1.

    Parameters
    ----------
    text : str
        Valid TOML, with lines that end with a line feed.

    Returns
    -------
    dict of tuple to int
        By the path of keys; tables in double brackets and entries of arrays are counted from 0.

    Examples
    --------
    >>> found = lines_of_keys('title = "a"\n[[horizons]]\nname = "Top"\n')
    >>> found["horizons", 0], found["horizons", 0, "name"]
    (2, 3)
    """
    scan = _Scan(text)
    table: Keys = ()
    while scan.token:
        if scan.token == "\n":
            scan.step()
        elif scan.token == "[":
            table = scan.header()
        else:
            scan.key_and_value(table)
    return scan.lines


class _Scan:
    """Goes through the tokens of a text, and notes where keys are."""

    def __init__(self, text: str) -> None:
        self.lines: dict[Keys, int] = {}
        self._n_tables: dict[Keys, int] = {}  # tables of each list in double brackets
        self._tokens = _TOKEN.finditer(text)
        self._line, self._n_line_ends = 1, 0
        self.token = ""
        self.step()

    def step(self) -> str:
        """Go to the next token, and return the one before; '' is the end."""
        before = self.token
        self._line += self._n_line_ends
        for found in self._tokens:
            if found.lastgroup != "skip":
                self.token, self._n_line_ends = found.group(), found.group().count("\n")
                return before
        self.token, self._n_line_ends = "", 0
        return before

    def header(self) -> Keys:
        """Read ``[table]`` or ``[[table]]``, and return its path."""
        line = self._line
        self.step()
        double = self.token == "["
        if double:
            self.step()
        path = self._inside((), self._dotted("]"), line, counted=double)
        for _ in range(1 + double):
            self.step()
        return path

    def _inside(self, path: Keys, words: list[str], line: int, *, counted: bool = False) -> Keys:
        """The path of a table; a name of a list in double brackets stands for its last table."""
        for k, word in enumerate(words):
            path = (*path, word)
            if counted and k == len(words) - 1:
                self._n_tables[path] = self._n_tables.get(path, 0) + 1
            self.lines.setdefault(path, line)
            if path in self._n_tables:
                path = (*path, self._n_tables[path] - 1)
                self.lines.setdefault(path, line)
        # a table may be opened after a table inside it
        if not counted:
            self.lines[path] = line
        return path

    def _dotted(self, end: str) -> list[str]:
        """Read the words of a key up to a mark, which stays."""
        words = []
        while self.token != end:
            token = self.step()
            if token[0] in "\"'":
                words.append(tomllib.loads(f"key = {token}")["key"])
            elif token != ".":
                words.append(token)
        return words

    def key_and_value(self, table: Keys) -> None:
        """Read ``key = value``."""
        line = self._line
        words = self._dotted("=")
        self.step()
        path = table
        for word in words:
            path = (*path, word)
            self.lines.setdefault(path, line)
        self._value(path)

    def _value(self, path: Keys) -> None:
        """Read a value: an array, a table in braces, or anything up to its end."""
        if self.token == "{":
            self.step()
            while self.token != "}":
                if self.token in (",", "\n"):
                    self.step()
                else:
                    self.key_and_value(path)
            self.step()
        elif self.token == "[":
            self.step()
            row = 0
            while self.token != "]":
                if self.token in (",", "\n"):
                    self.step()
                else:
                    self.lines[*path, row] = self._line
                    self._value((*path, row))
                    row += 1
            self.step()
        else:
            # numbers and dates may consist of several tokens
            while self.token and self.token not in (",", "]", "}", "\n"):
                self.step()


# ---- toml mistakes ----------------------------------------
# What is wrong with a line that TOML cannot read, in words of people who write scenarios.
#
# `tomllib` names the place of the first mistake in its own terms. Here the line is looked at:
# most mistakes are numbers with a decimal comma, a unit or a blank, paths of Windows, and missing
# quotes. The right line is guessed, so that the rest of the scenario can be read, too.


# tables that there may be several of
LISTS = ("horizons", "faults", "truncations", "throws", "contacts", "uncertain")
OF_LINE = re.compile(r" \(at line (\d+), column \d+\)")
PAIR = re.compile(r"^(\s*[\w.\"' -]+?\s*=\s*)(.*?)\s*$")
MOST = 50  # lines that are looked at
NUMBER = r"[+-]?\d+(?:\.\d+)?"
# what stands behind "=", what it should be, and the sentence
Guess = tuple[re.Pattern[str], Callable[[re.Match[str]], str], str]
GUESSES: tuple[Guess, ...] = (
    (
        re.compile(r"([+-]?\d+),(\d+)"),
        lambda found: f"{found[1]}.{found[2]}",
        "Write a decimal point, not a comma",
    ),
    (
        re.compile(rf"({NUMBER})\s+(m|ft|km|m3|cells|degrees|%)\.?", re.IGNORECASE),
        lambda found: found[1],
        "Write the number without a unit",
    ),
    (
        re.compile(r"([+-]?\d{1,3}(?:[ ']\d{3})+(?:\.\d+)?)"),
        lambda found: found[1].replace(" ", "").replace("'", ""),
        "Write the number without blanks",
    ),
    (
        re.compile(r"(true|false|yes|no|on|off)", re.IGNORECASE),
        lambda found: "true" if found[1].lower() in ("true", "yes", "on") else "false",
        "Write true or false, in small letters",
    ),
    (
        re.compile(r'"([^"]*\\[^"]*)"'),
        lambda found: f"'{found[1]}'",
        "A \\ has a meaning of its own between double quotes. Use single quotes, or /",
    ),
    (
        re.compile(r"""["']?([^"'\[\]{}=,#]+)["']?"""),
        lambda found: f'"{found[1].strip()}"',
        "Put text between quotes",
    ),
)


def mistake_of_toml(text: str, error: tomllib.TOMLDecodeError) -> tuple[int | None, str, str]:
    r"""
    Return line, sentence and remainder of the first mistake that `tomllib` finds.

    Parameters
    ----------
    text : str
        What is not TOML.
    error : tomllib.TOMLDecodeError
        What `tomllib.loads` raised.

    Returns
    -------
    tuple of int or None, str, str
        The line, counted from 1; the sentence; and the text with a right line, or without it.

    Examples
    --------
    >>> text = 'title = "A"\n[tear]\nnoise_m = 2,5\n'
    >>> try:
    ...     tomllib.loads(text)
    ... except tomllib.TOMLDecodeError as error:
    ...     line, sentence, rest = mistake_of_toml(text, error)
    >>> line, sentence
    (3, "'noise_m = 2,5' is not TOML. Write a decimal point, not a comma: noise_m = 2.5")
    >>> tomllib.loads(rest)["tear"]
    {'noise_m': 2.5}
    """
    rows = text.split("\n")
    found = OF_LINE.search(str(error))
    line = int(found[1]) if found else _open_quotes(rows)
    if line is None:
        return None, f"not a valid TOML file: {error}.", ""
    said = OF_LINE.sub("", str(error)).rstrip(".")
    row = rows[line - 1].strip()
    if said.startswith("Cannot") and row.startswith("["):
        return _table_twice(rows, line)
    if said.startswith("Cannot overwrite"):
        return line, _twice(rows[:line], row.partition("=")[0].strip()), _with_line(rows, line, "")
    pair = PAIR.match(rows[line - 1].partition(" #")[0])
    for pattern, right, remedy in GUESSES if pair else ():
        assert pair is not None
        value = pattern.fullmatch(pair[2])
        new = f"{pair[1]}{right(value)}" if value else ""
        if value and _is_toml(new):
            return (
                line,
                f"'{row}' is not TOML. {remedy}: {new.strip()}",
                _with_line(rows, line, new),
            )
    return line, f"'{row}' is not TOML: {said}. Correct this line.", _with_line(rows, line, "")


def _with_line(rows: list[str], line: int, new: str) -> str:
    """The text with another line."""
    return "\n".join([*rows[: line - 1], new, *rows[line:]])


def _table_twice(rows: list[str], line: int) -> tuple[int, str, str]:
    """What is wrong with the second table of a name, or with the first of a list."""
    name = rows[line - 1].strip().strip("[]").strip()
    single = [k for k, row in enumerate(rows) if row.strip().strip("[]").strip() == name]
    single = [k for k in single if not rows[k].strip().startswith("[[")]
    if len(single) == 1 or name in LISTS:  # the others have double brackets
        for k in single:
            rows[k] = f"[[{name}]]"
        sentence = f"[{name}] needs double brackets, as all tables of this list: [[{name}]]."
        return single[0] + 1, sentence, "\n".join(rows)
    return line, f"the table [{name}] is there twice. Keep one, with the keys of both.", ""


def _twice(rows: list[str], name: str) -> str:
    """The sentence for a key that is there twice; tables in single brackets are a usual cause."""
    head = next((one.strip() for one in reversed(rows) if one.strip().startswith("[")), "")
    table = f" in {head}" if head else ""
    return f"the key {name!r} is there twice{table}. Keep one of them."


def _open_quotes(rows: list[str]) -> int | None:
    """The first line on which a quote is not closed; None for texts of several lines."""
    if any('"""' in row or "'''" in row for row in rows):
        return None
    for k, row in enumerate(rows):
        if "=" in row and row.partition("#")[0].count("'") % 2:
            return k + 1
    return None


def _is_toml(text: str) -> bool:
    """Whether a line can be read."""
    try:
        return bool(tomllib.loads(text))
    except tomllib.TOMLDecodeError:
        return False


def mistakes_of_toml(
    text: str,
) -> tuple[list[tuple[int | None, str]], dict[str, Any] | None, str]:
    r"""
    Return all mistakes that keep a text from being TOML, what it holds without them, and that text.

    Examples
    --------
    >>> found, data, _ = mistakes_of_toml("a = 1,5\nb = True\nc = 3\n")
    >>> [line for line, _ in found], data
    ([1, 2], {'a': 1.5, 'b': True, 'c': 3})
    """
    mistakes: list[tuple[int | None, str]] = []
    for _ in range(MOST):
        try:
            return mistakes, tomllib.loads(text), text
        except tomllib.TOMLDecodeError as error:
            line, sentence, text = mistake_of_toml(text, error)
            mistakes.append((line, sentence))
            if not text:
                break
    return mistakes, None, text


# ---- settings ----------------------------------------
# Keys of a scenario that are set outside of its file: ``geosurf run --set tear.trim_cells=2``.


# What tables in double brackets are addressed by.
NAMES = ("name", "fault")


def with_settings(data: Mapping[str, Any], settings: Sequence[str], path: Path) -> dict[str, Any]:
    """
    Return what a scenario holds after some of its keys are set.

    Parameters
    ----------
    data : mapping
        What TOML gave.
    settings : sequence of str
        Each ``key=value``. A key is written as in TOML, ``output.size_px``; a table in double
        brackets is addressed by its name, ``horizons.Top.file``. A value that TOML does not
        know is text.
    path : pathlib.Path
        The scenario, for messages.

    Returns
    -------
    dict
        A copy; its keys and values are not checked here.

    Raises
    ------
    ScenarioError
        If a setting has no ``=``, its key is not one of TOML, or no table has the name.

    Examples
    --------
    >>> data = {"horizons": [{"name": "Top", "file": "Top.gri"}]}
    >>> with_settings(data, ["title=Two trims", "horizons.Top.file=Old.gri"], Path("a.toml"))
    {'horizons': [{'name': 'Top', 'file': 'Old.gri'}], 'title': 'Two trims'}
    """
    changed = copy.deepcopy(dict(data))
    for setting in settings:
        key, equals, value = setting.partition("=")
        if not equals or not key.strip():
            raise ScenarioError(
                f"{path}: --set {setting!r} is not key=value. Write for example --set "
                "tear.trim_cells=2."
            )
        _put(changed, _read(key.strip(), value.strip(), path), f"--set {key.strip()}", path)
    return changed


def _read(key: str, value: str, path: Path) -> dict[str, Any]:
    """Read one setting with the rules of TOML; a value that TOML does not know is text."""
    # shells remove quotes: a list of bare words is a mistake, not a text with brackets
    texts = [value] if value.startswith(("[", "{")) else [value, json.dumps(value)]
    for text in texts:
        try:
            return tomllib.loads(f"{key} = {text}")
        except tomllib.TOMLDecodeError:
            continue
    if len(texts) == 1 and _is_key(key):
        raise ScenarioError(
            f"{path}: --set {key}: {value} is not a list or table of TOML. Put the setting between "
            "single quotes, and words in it between double quotes, as in --set "
            "'output.views=[\"top\"]'."
        )
    raise ScenarioError(
        f"{path}: --set {key!r} is not a key of TOML. Write for example --set tear.trim_cells=2; "
        'put names with blanks or points between quotes, as in horizons."Top 1".file.'
    )


def _is_key(key: str) -> bool:
    """Whether TOML can read a key."""
    try:
        return bool(tomllib.loads(f"{key} = 0"))
    except tomllib.TOMLDecodeError:
        return False


def _put(data: dict[str, Any], new: Mapping[str, Any], words: str, path: Path) -> None:
    """Put values into a table; tables inside it keep their other values."""
    for word, value in new.items():
        old = data.get(word)
        if isinstance(value, dict) and isinstance(old, dict):
            _put(old, value, words, path)
        elif isinstance(value, dict) and isinstance(old, list):
            for name, inside in value.items():
                if not isinstance(inside, dict):
                    raise ScenarioError(
                        f"{path}: {words} names a table. Add a key of it: {words}.file=..."
                    )
                _put(_named(old, name, f"{words} ({word})", path), inside, words, path)
        elif old is None and isinstance(value, dict) and word in LISTS:
            raise ScenarioError(
                f"{path}: {words}: the scenario has no [[{word}]]. --set changes tables that are "
                "there: add this one to the file."
            )
        else:
            data[word] = value


def _named(tables: list[Any], name: str, words: str, path: Path) -> dict[str, Any]:
    """Return the table of a list that has a name."""
    names = [_name_of(table) for table in tables]
    found = [table for table, one in zip(tables, names, strict=True) if one == name]
    if len(found) == 1:
        table: dict[str, Any] = found[0]
        return table
    if found:
        raise ScenarioError(
            f"{path}: {words}: {len(found)} tables are named {name!r}. Edit the scenario instead."
        )
    known = list(dict.fromkeys(filter(None, names)))
    if not known:  # such as [[uncertain]]: counted as people do
        if name.isdecimal() and 1 <= int(name) <= len(tables):
            numbered: dict[str, Any] = tables[int(name) - 1]
            return numbered
        raise ScenarioError(
            f"{path}: {words}: no table {name!r}. These tables have no names; count them, from 1 "
            f"to {len(tables)}."
        )
    raise ScenarioError(
        f"{path}: {words}: no table is named {name!r}. Names are "
        f"{', '.join(map(repr, known))}.{did_you_mean(name, known)}"
    )


def _name_of(table: Any) -> str | None:
    if not isinstance(table, Mapping):
        return None
    return next((str(table[key]) for key in NAMES if key in table), None)
