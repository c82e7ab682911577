"""How tables of a scenario are read: each key by its check, then keys that are missing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields
from typing import Any

from geosurf.conventions import did_you_mean
from geosurf.conventions.text import closest
from geosurf.scenario.values import Check, KeyPath, check, listed_words

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


def read_table(kind: type, at: KeyPath, found: Mapping[str, Any], **more: Any) -> Any:
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
    for word, value in found.items():
        meant = word
        if word not in known:
            # the value of a misspelt key may be wrong, too
            guess = closest(word, known)
            with at.inside(word).noting():
                at.inside(word).refuse(
                    f"unknown key {word!r}{where}; known keys are {listed_words(tuple(known))}."
                    f"{did_you_mean(word, known) or _belongs(word, at)}"
                )
            if guess is None or guess in found:
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
                at.refuse(f"{word!r} is missing{where}; give {allowed}.", missing=True)
        if word not in ("name", "file"):
            return None
        checked[word] = at.file if word == "file" else f"table {at.words}"
    return kind(**checked, **more)
