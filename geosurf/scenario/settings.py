"""Keys of a scenario that are set outside of its file: ``geosurf run --set tear.trim_cells=2``."""

from __future__ import annotations

import copy
import json
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from geosurf.conventions import did_you_mean
from geosurf.errors import ScenarioError
from geosurf.scenario.toml_mistakes import LISTS

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


__all__ = ["with_settings"]
