"""How tables of a scenario are read: each key by its check, then keys that are missing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, Field, fields
from typing import Any

from geosurf.conventions import did_you_mean
from geosurf.scenario.values import Check, KeyPath, check, listed_words

# keys that stand in no table
TOP_LEVEL = ("title", "tolerance_m", "positive", "length_unit", "crs")


def table(kind: type) -> Check:
    """Return the check for a table, ``[kind]``."""

    @check("a table")
    def one_table(at: KeyPath, value: Any) -> Any:
        """The table as an object."""
        if isinstance(value, list | bool):  # [[name]] and name = true are the usual slips
            at.refuse(f"{at.keys} must be one table: write [{at.keys}] on a line of its own.")
        return read_table(kind, at, value) if isinstance(value, Mapping) else None

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
            name = at.keys
            at.refuse(f"{name} must be tables in double brackets, as in [[{name}]].")
        return tuple(
            read_table(kind, KeyPath(at.file, f"{at.keys}[{_label(row, entry)}]"), entry)
            for row, entry in enumerate(value)
        )

    many_tables.kind = kind  # type: ignore[attr-defined]
    return many_tables


def _label(row: int, entry: Mapping[str, Any]) -> str:
    """The name of a table, else its number, counted from 1."""
    name = entry.get("name")
    return repr(name) if isinstance(name, str) and name.strip() else f"number {row + 1}"


def _is_required(entry: Field[Any]) -> bool:
    """Return whether a key has no default."""
    return entry.default is MISSING


def _belongs(word: str, at: KeyPath) -> str:
    """Where a key belongs that is of the whole scenario; TOML puts it into the table above."""
    if at.keys and word in TOP_LEVEL:
        return f" {word!r} belongs to the whole scenario: write it above the first table."
    return ""


def read_table(kind: type, at: KeyPath, found: Mapping[str, Any], **more: Any) -> Any:
    """Check all keys of a table and return its dataclass.

    Parameters
    ----------
    kind : type
        A dataclass of `geosurf.scenario.keys`.
    at : KeyPath
        The path of the table.
    found : mapping
        What TOML gave.
    **more
        Values of fields that have no key in the file.

    Returns
    -------
    object of type `kind`

    Raises
    ------
    ScenarioError
        For an unknown key, a missing one, or a value that its check refuses.
    """
    # unknown keys first: a misspelt key also leaves another one missing
    known = {entry.name: entry for entry in fields(kind) if "check" in entry.metadata}
    where = f" in {at.keys}" if at.keys else ""
    for word in found:
        if word not in known:
            at.refuse(
                f"unknown key {word!r}{where}; known keys are {listed_words(tuple(known))}."
                f"{did_you_mean(word, known) or _belongs(word, at)}"
            )
    # each value by the check of its key; defaults are those of the dataclass
    checked = {
        word: known[word].metadata["check"](at.inside(word), value) for word, value in found.items()
    }

    # Then keys that are missing, with what they take.
    for word, entry in known.items():
        if word not in found and _is_required(entry):
            allowed = entry.metadata["check"].allowed
            at.refuse(f"{word!r} is missing{where}; give {allowed}.")
    return kind(**checked, **more)
