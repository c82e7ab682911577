"""What is wrong with a line that TOML cannot read, in words of people who write scenarios.

`tomllib` names the place of the first mistake in its own terms. Here the line is looked at: most
mistakes are numbers with a decimal comma, a unit or a blank, paths of Windows, and missing quotes.
The right line is guessed, so that the rest of the scenario can be read, too.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable
from typing import Any

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


__all__ = ["mistake_of_toml", "mistakes_of_toml"]
