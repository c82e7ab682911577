"""What all readers share: bytes, lines, numbers, and the direction of elevations.

Readers never guess. Whether a file holds elevation or depth is said by the file
or by the caller; when both speak they must agree.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from geosurf.conventions import METRES_PER_UNIT, elevation_sign, metres_per_unit
from geosurf.errors import FormatError, InputError


def read_bytes(path: Path) -> bytes:
    """Return the content of a file, or say why there is none."""
    try:
        data = path.read_bytes()
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise InputError(f"{path}: cannot be read ({reason}). Check the path.") from error
    if not data:
        raise FormatError(f"{path}: the file is empty (0 bytes). Export it again.")
    return data


def read_text(path: Path, *, final_line_end: bool = True) -> str:
    """Return the text of a file, in UTF-8 or else Latin-1.

    A last line without its line end may be a number cut short ("1603.25" and
    "1603.2" both parse), so it is refused where the format has no other end mark.
    """
    data = read_bytes(path)
    if b"\0" in data:
        raise FormatError(
            f"{path}: byte {data.index(0)} is zero, so this is no text file. "
            "Say which format it is with format=."
        )
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    if final_line_end and not text[-1].isspace():
        n_line = text.count("\n") + 1
        raise FormatError(
            f"{path}, line {n_line}: the last line has no line end, so the file may be cut "
            "short. Export it again, or add a line end if it is complete."
        )
    return text


def number(token: str, path: Path, line: int, what: str) -> float:
    """Return a finite float, or name the line and the token."""
    try:
        value = float(token)
    except ValueError as error:
        raise FormatError(
            f"{path}, line {line}: found {token!r}, expected a number ({what}). "
            "Mend that line or export the file again."
        ) from error
    if not math.isfinite(value):
        raise FormatError(
            f"{path}, line {line}: found {token!r}, expected a finite number ({what}). "
            "Mend that line or export the file again."
        )
    return value


def integer(token: str, path: Path, line: int, what: str) -> int:
    """Return an int, or name the line and the token."""
    try:
        return int(token)
    except ValueError as error:
        raise FormatError(
            f"{path}, line {line}: found {token!r}, expected a whole number ({what}). "
            "Mend that line or export the file again."
        ) from error


def number_rows(rows: list[list[str]], lines: list[int], path: Path, what: str) -> np.ndarray:
    """Return equal-length rows of tokens as finite float64 (n_row, n_column)."""
    try:
        array = np.array(rows, dtype=np.float64)
    except ValueError:
        array = np.array([])
    if array.ndim == 2 and np.isfinite(array).all():
        return array
    # something is wrong: go token by token and name the first that is
    return np.array(
        [
            [number(token, path, line, what) for token in row]
            for row, line in zip(rows, lines, strict=True)
        ]
    )


def is_number(token: str) -> bool:
    """Whether a word of a file is a number."""
    try:
        float(token)
    except ValueError:
        return False
    return True


class Otherwise(str):
    """A word said of several files at once: it counts for those that do not say their own."""

    __slots__ = ()


def otherwise(words: Mapping[str, str | None]) -> dict[str, str | None]:
    """Return ``positive`` and ``units`` for a reader, as words for files that say nothing."""
    return {key: None if word is None else Otherwise(word) for key, word in words.items()}


def agreed_sign(said: str | None, asked: str | None, what: str) -> float:
    """Return +1 (elevation) or -1 (depth) from what a file says and a caller asks."""
    if isinstance(asked, Otherwise):
        elevation_sign(asked, what)
        asked = asked if said is None else None
    if said is not None and asked is not None and said != asked:
        elevation_sign(asked, what)  # a misspelt word is reported as such
        raise InputError(
            f"{what}: the file says positive={said!r}, the argument says positive={asked!r}. "
            "Leave the argument out, or correct the file."
        )
    return elevation_sign(said if said is not None else asked, what)


def agreed_scale(said: str | None, asked: str | None, default: str | None, what: str) -> float:
    """Return metres per unit from what a file says, a caller asks, or a format implies."""
    if isinstance(asked, Otherwise):
        metres_per_unit(asked, what)
        asked = asked if said is None else None
    if said is not None and asked is not None:
        if _known(said) and _known(asked) and _scale(said) != _scale(asked):
            raise InputError(
                f"{what}: the file says units {said!r}, the argument says units={asked!r}. "
                "Leave the argument out, or correct the file."
            )
        return metres_per_unit(said, what)
    return metres_per_unit(said or asked or default, what)


def _known(units: str) -> bool:
    return units.strip().lower() in METRES_PER_UNIT


def _scale(units: str) -> float:
    return METRES_PER_UNIT[units.strip().lower()]
