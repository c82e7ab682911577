"""Which columns of a file hold the paths of wells, and their numbers."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import did_you_mean
from geosurf.errors import FormatError, InputError
from geosurf.read._common import COMMA, number
from geosurf.read._noted import noted
from geosurf.read._tops_layout import plain_name
from geosurf.read.wells.layouts import Trace, begins_with_name
from geosurf.read.wells.names import HORIZON, USUAL

SURVEY = ("md", "inclination", "azimuth")
PLACES = ("x", "y", "z")


def holds_wells(head: bytes) -> bool:
    """
    Return whether a table begins as one of well paths: places or directions, and no horizon.

    Parameters
    ----------
    head : bytes
        The first bytes of a file.

    Examples
    --------
    >>> holds_wells(b"Well,MD,Inc,Azi"), holds_wells(b"Well,X,Y,Z,Top"), holds_wells(b"X,Y,Z")
    (True, False, False)
    """
    lines = head.decode("utf-8", "replace").splitlines()
    if begins_with_name(lines):
        return True
    for line in lines:
        words = [plain_name(word) for word in line.replace(";", ",").replace("\t", ",").split(",")]
        if len(words) < 3:
            words = [plain_name(word) for word in line.split()]
        has = {key for key, names in USUAL.items() if any(word in names for word in words)}
        if any(word in HORIZON for word in words):
            return False
        if "md" in has and {"inclination", "azimuth"} <= has:
            return True
        if {*PLACES} <= has:
            return "well" in has or "md" in has
        if line.strip() and not line.lstrip().startswith(("#", "!", "--")):
            return False
    return False


def checked_columns(columns: Any) -> dict[str, str | int]:
    """Columns that the caller names, or the reason why not."""
    if columns is None:
        return {}
    how = f"Give a mapping of {', '.join(USUAL)} to names or numbers, as in {{'md': 'DEPT'}}."
    if not isinstance(columns, Mapping):
        raise InputError(f"columns is a {type(columns).__name__}. {how}")
    for key, word in columns.items():
        if key not in USUAL:
            raise InputError(f"columns has the key {key!r}.{did_you_mean(str(key), USUAL)} {how}")
        if not isinstance(word, str) and not (type(word) is int and word > 0):
            raise InputError(f"columns[{key!r}] is {word!r}. {how}")
    return dict(columns)


def three_names(given: dict[str, str | int]) -> list[str | int] | None:
    """Names of x, y and z for readers that take three."""
    if not given:
        return None
    return [given.get(key, key) for key in PLACES]


def places_of(path: Path, trace: Trace, given: dict[str, str | int]) -> dict[str, int]:
    """Where the columns are that the file has, by their usual names or the caller's."""
    words = [plain_name(word) for word in trace.header]
    width = len(words) or min(len(row) for _, row in trace.rows)
    found: dict[str, int] = {}
    for key, usual in USUAL.items():
        word = given.get(key)
        if isinstance(word, int):
            if word > width:
                raise FormatError(f"{path}: a line has {width} values, but {key} is column {word}.")
            found[key] = word - 1
            continue
        names = usual if word is None else (plain_name(word),)
        at = [k for k, one in enumerate(words) if one in names]
        if len(at) > 1:
            raise FormatError(
                f"{path}: the columns {' and '.join(trace.header[k] for k in at)} may both be "
                f"{key}. Name one, as in columns={{{key!r}: {trace.header[at[0]]!r}}}."
            )
        if word is not None and not at:
            raise FormatError(
                f"{path}: no column is called {word!r}, only {', '.join(trace.header)}."
                f"{did_you_mean(word, trace.header)}"
            )
        if at:
            found[key] = at[0]
    return found


def check_kind(path: Path, trace: Trace, places: dict[str, int]) -> None:
    """Refuse a file that has neither positions nor measured depths with directions."""
    if all(key in places for key in PLACES) or all(key in places for key in SURVEY):
        names = ", ".join(trace.header[k] if trace.header else str(k + 1) for k in places.values())
        noted("columns", f"{', '.join(places)} are {names}")
        return
    survey = sum(key in places for key in SURVEY) >= sum(key in places for key in PLACES)
    missing = [key for key in (SURVEY if survey else PLACES) if key not in places]
    true_north = any("tn" in plain_name(word)[-2:] for word in trace.header)
    hint = (
        " Azimuths from true north differ from grid north by the convergence; name such a column "
        "only if that is 0."
        if "azimuth" in missing and true_north
        else ""
    )
    raise FormatError(
        f"{path}: no column is {' or '.join(missing)}; columns are "
        f"{', '.join(trace.header) or 'not named'}. A path needs x, y, z, or md, inclination, "
        f"azimuth. Name them, as in columns={{{missing[0]!r}: '...'}}.{hint}"
    )


def column_of(path: Path, trace: Trace, place: int, key: str, decimal: str) -> np.ndarray:
    """Numbers of one column, all of them finite."""
    what = f"{key} of a well"
    words = [(line, row[place]) for line, row in trace.rows]
    if decimal == ",":
        words = [
            (line, word.replace(",", ".", 1) if COMMA.search(word) else word)
            for line, word in words
        ]
    return np.array([number(word, path, line, what) for line, word in words])


def rows_of_wells(path: Path, trace: Trace, places: dict[str, int]) -> dict[str, np.ndarray]:
    """Rows of each well, in the order of the wells' first rows."""
    if "well" not in places:
        return {trace.well or path.stem: np.arange(len(trace.rows))}
    rows: dict[str, list[int]] = {}
    for k, (line, words) in enumerate(trace.rows):
        name = words[places["well"]].strip()
        if not name:
            raise FormatError(
                f"{path}, line {line}: the name of the well is missing. Correct that line or "
                "export the file again."
            )
        rows.setdefault(name, []).append(k)
    return {name: np.array(at) for name, at in rows.items()}


__all__ = [
    "PLACES",
    "SURVEY",
    "check_kind",
    "checked_columns",
    "column_of",
    "holds_wells",
    "places_of",
    "rows_of_wells",
    "three_names",
]
