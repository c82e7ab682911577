"""The text of a scenario: lines of its keys, what is not TOML, keys that are set outside."""

from __future__ import annotations

import copy
import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from geosurf.conventions import did_you_mean
from geosurf.errors import ScenarioError

# ---- lines of keys ----------------------------------------
# Where each key of a TOML file is: `tomllib` gives values without their lines. The text has been
# read by `tomllib` before, so it is valid.


Keys = tuple[str | int, ...]

_TEXT = r"""(?:"(?:[^"\\]|\\.)*"|'[^']*')"""
_OPAQUE = re.compile(rf"{_TEXT}|#.*")  # what may hold brackets that open nothing
_HEAD = re.compile(rf"\s*\[(\[?)((?:{_TEXT}|[^\[\]\"'])+)\]\]?\s*(?:#.*)?")
_PAIR = re.compile(rf"\s*((?:{_TEXT}|[^=#\"'])+?)\s*=")


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
        By the path of keys; tables in double brackets are counted from 0. What a value holds has
        the line of its key.

    Examples
    --------
    >>> found = lines_of_keys('title = "a"\n[[horizons]]\nname = "Top"\n')
    >>> found["horizons", 0], found["horizons", 0, "name"]
    (2, 3)
    """
    lines: dict[Keys, int] = {}
    count: dict[Keys, int] = {}  # tables of each list in double brackets
    table: Keys = ()
    n_open = 0  # brackets: a value may go on over several lines

    def note(path: Keys, words: list[str], line: int, *, one_more: bool = False) -> Keys:
        """Note a path; a name of a list in double brackets stands for its last table."""
        for k, word in enumerate(words, 1):
            path = (*path, word)
            lines.setdefault(path, line)
            if one_more and k == len(words):
                count[path] = count.get(path, 0) + 1
            if path in count:
                path = (*path, count[path] - 1)
                lines.setdefault(path, line)
        return path

    for line, row in enumerate(text.split("\n"), 1):
        if n_open:
            pass
        elif head := _HEAD.fullmatch(row):
            table = note((), _words(head[2]), line, one_more=bool(head[1]))
            lines[table] = line  # a table may be opened after a table inside it
        elif pair := _PAIR.match(row):
            note(table, _words(pair[1]), line)
        bare = _OPAQUE.sub("", row)
        n_open += sum(map(bare.count, "[{")) - sum(map(bare.count, "]}"))
    return lines


def _words(key: str) -> list[str]:
    """The words of a dotted key."""
    words, inside = [], tomllib.loads(f"{key} = 0")
    while isinstance(inside, dict):
        (word,) = inside
        words.append(word)
        inside = inside[word]
    return words


# ---- what is not TOML ----------------------------------------


OF_LINE = re.compile(r" \(at line (\d+), column \d+\)")


def mistake_of_toml(text: str, error: tomllib.TOMLDecodeError) -> tuple[int | None, str]:
    r"""
    Return line and sentence of the first mistake that `tomllib` finds.

    Parameters
    ----------
    text : str
        What is not TOML.
    error : tomllib.TOMLDecodeError
        What `tomllib.loads` raised.

    Examples
    --------
    >>> text = 'title = "A"\n[tear]\nnoise_m = 2,5\n'
    >>> try:
    ...     tomllib.loads(text)
    ... except tomllib.TOMLDecodeError as error:
    ...     line, sentence = mistake_of_toml(text, error)
    >>> line, sentence.partition(": ")[0]
    (3, "'noise_m = 2,5' is not TOML")
    """
    position = OF_LINE.search(str(error))
    if position is None:
        return None, f"not a valid TOML file: {error}. Close quotes and brackets."
    line, said = int(position[1]), OF_LINE.sub("", str(error)).rstrip(".")
    row = text.split("\n")[line - 1].strip()
    return line, (
        f"{row!r} is not TOML: {said}. Put text and paths between single quotes, write numbers "
        "as 2.5 without a unit, and each key and each table in single brackets once."
    )


# ---- settings ----------------------------------------
# Keys of a scenario that are set outside of its file: ``geosurf run --set tear.trim_cells=2``.


# What tables in double brackets are addressed by.
NAMES = ("name", "fault")
# tables that there may be several of
LISTS = ("horizons", "faults", "truncations", "throws", "contacts", "uncertain")


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
    matching = [table for table, one in zip(tables, names, strict=True) if one == name]
    if len(matching) == 1:
        made: dict[str, Any] = matching[0]
        return made
    if matching:
        raise ScenarioError(
            f"{path}: {words}: {len(matching)} tables are named {name!r}. Edit the scenario "
            "instead."
        )
    known = list(dict.fromkeys(filter(None, names)))
    if not known:  # such as [[uncertain]]: counted as people do
        if name.isdecimal() and 1 <= int(name) <= len(tables):
            parsed: dict[str, Any] = tables[int(name) - 1]
            return parsed
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
