"""All mistakes of a scenario at once, each with its line; no surface is read.

`read_scenario` stops at the first mistake. Here the value with the mistake is taken out of what the
file holds, or one that is right takes its place, and the rest is read again until nothing is left.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geosurf.errors import ScenarioError
from geosurf.model.expected import path_of
from geosurf.scenario.settings import with_settings
from geosurf.scenario.toml_lines import Keys, lines_of_keys
from geosurf.scenario.toml_mistakes import mistakes_of_toml
from geosurf.scenario.validate import checked_scenario, text_of

MOST = 200  # mistakes that are looked for
UNKNOWN = re.compile(r"unknown key '([^']+)'(?: in (.+?))?; known keys are")
MISSING = re.compile(r"'([^']+)' is missing(?: in (.+?))?; give ")
GUESS = re.compile(r"Did you mean '([^']+)'\?$")
OF_KEY = re.compile(r"unknown (\w+) '")
TWICE = re.compile(r"'([^']+)' is the name of ")
OF_THROW = re.compile(r"throws? of '([^']+)'")


@dataclass(frozen=True)
class Mistake:
    """One mistake.

    Attributes
    ----------
    line : int or None
        Where it is, counted from 1; None if it belongs to no line.
    sentence : str
        What is wrong, and what to write.
    """

    line: int | None
    sentence: str

    def __str__(self) -> str:
        where = "" if self.line is None else f"line {self.line}: "
        return f"{where}{self.sentence}"


def find_mistakes(path: str | os.PathLike[str], settings: Sequence[str] = ()) -> list[Mistake]:
    r"""
    Return all mistakes of a scenario, in the order of their lines.

    Parameters
    ----------
    path : path-like
        A TOML file.
    settings : sequence of str
        Keys that have another value than in the file, each ``key=value``.

    Returns
    -------
    list of Mistake
        Empty if the scenario can be run. Files are only looked for, not read.

    Raises
    ------
    ScenarioError
        If the file does not exist.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "scenario.toml"
    >>> _ = file.write_text("titel = 'A'\n[[horizons]]\nname = 'Top'\nfile = 'Top.gri'\n")
    >>> [(one.line, one.sentence.split(";")[0].split(",")[0]) for one in find_mistakes(file)]
    [(1, "unknown key 'titel'"), (4, "horizons['Top'].file is 'Top.gri'")]
    """
    path = path_of(path, "a scenario")
    text = text_of(path)
    broken, data, text = mistakes_of_toml(text)
    toml = [Mistake(*one) for one in broken]
    if data is None:
        return toml
    where: dict[Keys, int | None] = {**lines_of_keys(text)}
    written, data = data, with_settings(data, settings, path)
    where |= dict.fromkeys(_changes(written, data))  # what --set gives has no line
    found, gone = dict[str, Mistake](), set[Keys]()
    lost = {one.line for one in toml}  # keys of these lines may be missing now
    for _ in range(MOST):
        try:
            checked_scenario(path, data)
        except ScenarioError as error:
            sentence = str(error).removeprefix(f"{path}: ")
            lines = _Lines(data, where)  # of what is left: tables may have other names by now
            at = lines.place_of(sentence)
            if sentence in found:
                break  # nothing that can be taken out: what follows is not found
            # a table from which a value was taken out may be incomplete: no mistake of its own
            if at is None or not _follows(at, sentence, gone):
                found[sentence] = Mistake(lines.line_of(at), sentence)
            if at is None or not _take_out(data, at, path, sentence):
                break
            gone.add(at)
            right = GUESS.search(sentence) if UNKNOWN.match(sentence) else None
            if right and at in where:  # the key under its right name is on the same line
                where.setdefault((*at[:-1], right[1]), where[at])
        else:
            break
    own = [one for one in found.values() if not (lost and MISSING.match(one.sentence))]
    return sorted([*toml, *own], key=lambda one: one.line or 0)


def _follows(at: Keys, sentence: str, gone: set[Keys]) -> bool:
    """Whether a sentence about a table follows from a value that was taken out of it."""
    inside = {one for one in gone if one != at and one[: len(at)] == at}
    if missing := MISSING.match(sentence):
        return (*at, missing[1]) in inside
    return bool(inside)


def _changes(before: Any, after: Any, at: Keys = ()) -> Iterator[Keys]:
    """The keys whose values differ, those of new tables too."""
    if isinstance(before, dict) and isinstance(after, dict):
        for word in after:
            yield from _changes(before.get(word), after[word], (*at, word))
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for k, (old, new) in enumerate(zip(before, after, strict=True)):
            yield from _changes(old, new, (*at, k))
    elif before != after:
        yield at
        if isinstance(after, dict):
            yield from ((*at, word) for word in after)


class _Lines:
    """Lines of keys, by the names that messages have for them."""

    def __init__(self, data: Mapping[str, Any], lines: Mapping[Keys, int | None]) -> None:
        self.lines = lines
        self.named: dict[str, Keys] = {}
        self.of_throw: dict[str, Keys] = {}
        self.names: dict[Keys, Any] = {}
        for keys in lines:
            self.named[_in_words(data, keys)] = keys
            value = _value(data, keys)
            if keys[0] in ("horizons", "faults") and keys[2:] == ("name",):
                self.names[keys] = value
            if len(keys) == 2 and keys[0] == "throws" and isinstance(value, Mapping):
                self.of_throw[str(value.get("fault"))] = keys

    def place_of(self, sentence: str) -> Keys | None:
        """The keys that a sentence is about."""
        for pattern in (UNKNOWN, MISSING):
            if found := pattern.match(sentence):
                table = self.named.get(found[2]) if found[2] else ()
                if table is None:
                    return None
                return (*table, found[1]) if pattern is UNKNOWN else table or None
        if found := TWICE.match(sentence):
            same = [keys for keys, name in self.names.items() if name == found[1]]
            return same[1] if len(same) > 1 else None
        if found := OF_THROW.search(sentence):
            return self.of_throw.get(found[1])

        # the longest name of a key in the sentence, or the key of what is unknown
        known = [name for name in self.named if re.search(_bounded(name), sentence)]
        if not known:
            return None
        name = max(known, key=len)
        if found := OF_KEY.search(sentence):
            inside = (f"{name}.{found[1]}", f"{name}.{found[1]}s")
            name = next((one for one in inside if one in self.named), name)
        return self.named[name]

    def line_of(self, keys: Keys | None) -> int | None:
        """The line of a key, or of the table that lacks it."""
        while keys:
            if keys in self.lines:
                return self.lines[keys]
            keys = keys[:-1]
        return None


def _in_words(data: Mapping[str, Any], keys: Keys) -> str:
    """The name of keys in messages: horizons['Top'].file."""
    words = ""
    for k, word in enumerate(keys):
        if isinstance(word, int):
            entry = _value(data, keys[: k + 1])
            name = entry.get("name") if isinstance(entry, Mapping) else None
            named = isinstance(name, str) and name.strip()
            words += f"[{name!r}]" if named else f"[number {word + 1}]"
        else:
            words += f".{word}" if words else word
    return words


def _bounded(name: str) -> str:
    """A pattern of a name that is not a part of a longer word."""
    return rf"(?<![\w'.]){re.escape(name)}(?![\w'])"


def _value(data: Any, keys: Keys) -> Any:
    """What is at some keys; None if nothing is."""
    for word in keys:
        try:
            data = data[word]
        except (KeyError, IndexError, TypeError):
            return None
    return data


def _take_out(data: dict[str, Any], at: Keys, path: Path, sentence: str) -> bool:
    """Take out the value with a mistake, or put a right one in its place."""
    table, word = _value(data, at[:-1]), at[-1]
    if table is None or (isinstance(table, dict) and word not in table):
        return False
    guess = GUESS.search(sentence) if UNKNOWN.match(sentence) else None
    if guess and isinstance(table, dict) and guess[1] not in table:
        table[guess[1]] = table.pop(word)  # the value of a misspelt key may be wrong, too
    elif "it must be two numbers, the lower one first" in sentence and isinstance(table, dict):
        table[word] = [0.0, 1.0]
    elif "it must be a number" in sentence and isinstance(table, dict):
        table[word] = 1.0  # allowed wherever a number is: what needs one stays complete
    elif word == "file" and isinstance(table, dict):
        table[word] = path.name  # a file that exists: what refers to this surface stays right
    elif isinstance(word, int):
        # a table of a list: a name of its own, so that the others keep their places
        entry, missing = table[word], MISSING.match(sentence)
        if isinstance(entry, dict) and missing and missing[1] in ("file", "name"):
            entry[missing[1]] = path.name if missing[1] == "file" else f"table {word + 1}"
        else:
            del table[word]
    else:
        del table[word]
    return True


__all__ = ["Mistake", "find_mistakes"]
